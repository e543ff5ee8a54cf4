"""Results as a document to pass on: one HTML file that needs no other, or a PDF of A4 pages."""

from __future__ import annotations

import base64
import functools
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.result_report import Report, Table
from floquetrod._util.sealed_files import atomic_file
from floquetrod.plotting import palette

KINDS = (".html", ".pdf")
"""Endings of the files that can be written."""

_A4 = (8.27, 11.69)  # inches
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.75, 7.52, 11.0, 0.85  # inches, of what is printed
_WIDE = _RIGHT - _LEFT
_POINTS, _SMALL, _HEAD, _TITLE = 8.5, 7.5, 11.0, 16.0  # sizes of type
_LINE = 1.45  # from line to line, in sizes of type
_GAP = 0.16  # inches between columns of a table
_WIDEST_LABEL = 2.2  # inches, of the first column of lines
_NARROWEST = 1.5  # inches, of a last column (a choice)
_TOGETHER = 4.0  # inches up to which a table is kept on one page (a choice)
_SHRUNK = 0.8  # part of its height to which a figure is shrunk to fit on a page
_ROUNDING = 1e-6  # inches, of a width
_SALT = "floquetrod"  # so that the same figure has the same bytes

_COLOURS = [
    "; ".join(f"--{name}: {pair[shade]}" for name, pair in palette.PAGE.items()) for shade in (0, 1)
]  # in light, in the dark
_STYLE = (
    f"""
:root {{ color-scheme: light dark; {_COLOURS[0]}; }}
@media (prefers-color-scheme: dark) {{ :root {{ {_COLOURS[1]}; }} }}
@media print {{ :root {{ {_COLOURS[0]}; }} h2, .wide > p {{ break-after: avoid; }} }}
@media print {{ tr, figure {{ break-inside: avoid; }} }}
img {{ background: {palette.STABLE}; }}
"""
    + """
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--page); max-width: 52rem;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; } .about { margin-top: 0.2rem; }
h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid var(--line); }
.verdict { border: 2px solid var(--ink); border-radius: 4px; padding: 0.6rem 0.9rem; font-weight: 600; }
.verdict p { margin: 0.2rem 0; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.9rem; }
th, td { text-align: left; vertical-align: top; padding: 0.15rem 0.9rem 0.15rem 0; }
table + table { margin-top: 0.8rem; } th { font-weight: 600; white-space: nowrap; } th + th { white-space: normal; }
td { overflow-wrap: break-word; font-variant-numeric: tabular-nums; } td:not(:last-child) { white-space: nowrap; }
td:nth-child(3) ~ td:last-child { min-width: 14rem; } td:nth-child(6) ~ td:last-child { min-width: 0; }
figure { margin: 1rem 0; } figcaption { font-size: 0.9rem; }
img { width: 100%; height: auto; max-height: 25cm; object-fit: contain; border-radius: 4px; }
@media print { :root { font-size: 12px; } body { font-size: 1rem; margin: 0; max-width: none; } }
@media print { img { max-height: 22cm; } }
@page { margin: 15mm; @bottom-right { content: counter(page) " of " counter(pages); font: 9px sans-serif; } }
"""
)


class Illustration(NamedTuple):
    """A figure of a document: what draws it into a figure or subfigure, its caption, and its height over its width.

    For a page of HTML ``draw`` may return a finished figure instead.
    """

    draw: Callable[[Any], Any]
    caption: str
    height: float = 0.7


class DocumentSection(NamedTuple):
    """A part of a document: a title, a report, and figures, drawn when it is written."""

    title: str
    report: Report | None = None
    illustrations: Sequence[Illustration] = ()


class Document(NamedTuple):
    """A title, lines about the document, sentences of the verdict for a box, and sections."""

    title: str
    about: Sequence[str]
    verdict: Sequence[str]
    sections: Sequence[DocumentSection]


def save(path: str | Path, document: Document) -> Path:
    """Write a document to a file that ends in .html or .pdf, whole or not at all; ValueError for other endings."""
    path = checked_path(path)
    content = _html(document) if path.suffix.lower() == ".html" else _pdf(document)
    with atomic_file(path) as file:
        file.write(content)
    return path


def checked_path(path: str | Path) -> Path:
    """Return the path of a document; ValueError unless it ends in .html or .pdf."""
    path = validate.path("path", path)
    if path.suffix.lower() not in KINDS:
        raise validate.wrong_value("path", f"must end in {' or '.join(KINDS)}, got {str(path)!r}")
    return path


def _html(document: Document) -> bytes:
    title, numbers = escape(document.title), iter(range(1, 1000))
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{title}</h1>",
        f'<p class="about">{escape(_joined(document.about))}</p>',
        f'<div class="verdict">{"".join(f"<p>{escape(text)}</p>" for text in document.verdict)}</div>',
    ]
    for section in document.sections:
        parts.append(f"<section><h2>{escape(section.title)}</h2>")
        if section.report is not None:
            parts.append(f'<div class="wide">{section.report._repr_html_()}</div>')
        for illustration in section.illustrations:
            picture = base64.b64encode(_svg(illustration)).decode()
            caption = escape(_caption(next(numbers), illustration))
            parts.append(
                f'<figure><img alt="{caption}" src="data:image/svg+xml;base64,{picture}">'
                f"<figcaption>{caption}</figcaption></figure>"
            )
        parts.append("</section>")
    return "\n".join([*parts, "</body></html>", ""]).encode()


def _joined(texts: Sequence[str]) -> str:
    return " \N{MIDDLE DOT} ".join(texts)


def _caption(number: int, illustration: Illustration) -> str:
    return f"Figure {number}. {illustration.caption}"


def _svg(illustration: Illustration) -> bytes:
    """Return a figure as the content of a file."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure, file = Figure(figsize=(7.2, 7.2 * illustration.height), layout="constrained"), io.BytesIO()
    drawn = illustration.draw(figure)
    if isinstance(drawn, Figure):
        figure = drawn
    with mpl.rc_context({"svg.hashsalt": _SALT}):
        figure.savefig(file, format="svg", dpi=200, metadata={"Date": None})
    return file.getvalue()


def _pdf(document: Document) -> bytes:
    from matplotlib.backends.backend_pdf import PdfPages

    numbers, pages = iter(range(1, 1000)), _Pages()
    pages.paragraph(document.title, _TITLE, weight="bold")
    pages.paragraph(_joined(document.about), _SMALL)
    pages.box(document.verdict)
    for section in document.sections:
        first = section.illustrations[0] if section.illustrations and section.report is None else None
        pages.head(section.title, 0.8 if first is None else _SHRUNK * _WIDE * first.height)
        if section.report is not None:
            pages.report(section.report)
        for illustration in section.illustrations:
            pages.figure(illustration, _caption(next(numbers), illustration))
    pages.number(document.title)
    file = io.BytesIO()
    with PdfPages(file, metadata={"Title": document.title, "CreationDate": None}) as pdf:
        for page in pages.pages:
            pdf.savefig(page, dpi=200)
    return file.getvalue()


class _Pages:
    """Pages of a PDF, filled from top to bottom; lengths are in inches from below and from the left."""

    def __init__(self) -> None:
        self.pages: list[Any] = []
        self.place = 0.0  # of what comes next

    def head(self, title: str, below: float) -> None:
        """Write the title of a section, on a new page where there is less than so much room ``below`` it."""
        self._room(0.5 + below)
        self.place -= 0.16
        self._write(_LEFT, title, _HEAD, weight="bold")
        self.place -= 1.6 * _HEAD / 72.0
        self._line(_LEFT, _RIGHT, self.place, 0.6, palette.PAGE["line"][0])
        self.place -= 0.08

    def paragraph(self, text: str, size: float, **style: Any) -> None:
        """Write a text in lines as wide as the page."""
        self._rows([([text], size, style)], [_WIDE + _GAP])

    def box(self, texts: Sequence[str]) -> None:
        """Write sentences into a box."""
        from matplotlib.patches import Rectangle

        lines = [line for text in texts for line in _wrapped(text, _WIDE - 0.3, _HEAD - 1.0, "bold")]
        step = _LINE * (_HEAD - 1.0) / 72.0
        height = step * len(lines) + 0.24
        self._room(height)
        across, up = _A4
        corner = _LEFT / across, (self.place - height) / up
        frame = Rectangle(corner, _WIDE / across, height / up, fill=False, edgecolor="black", linewidth=1.2)
        frame.set_transform(self.page.transSubfigure)
        self.page.add_artist(frame)
        self.place -= 0.14
        for line in lines:
            self._write(_LEFT + 0.15, line, _HEAD - 1.0, weight="bold")
            self.place -= step
        self.place -= 0.2

    def report(self, report: Report) -> None:
        """Write the headline of a report, its lines in two columns, and its table."""
        if report.headline:
            self.paragraph(report.headline, _POINTS, weight="bold")
        if report.lines:
            widest = min(max(_width(label, _POINTS) for label, _ in report.lines) + _GAP, _WIDEST_LABEL)
            rows = [((label, text), _POINTS, dict[str, Any]()) for label, text in report.lines]
            self._rows(rows, [widest, _WIDE - widest + _GAP])
        if report.table is not None:
            self._table(report.table)
        self.place -= 0.06
        if report.rest is not None:
            self.report(report.rest)

    def _table(self, table: Table) -> None:
        titles = [title for title, _ in table.columns]
        cells = [titles, *table.rows] if any(titles) else [*table.rows]
        every = [[cell.strip() for cell in row] for row in cells]
        widths = [max(_width(row[k], _POINTS, "bold") for row in every) + _GAP for k in range(len(titles))]
        widths[-1] = min(widths[-1], max(_WIDE + _GAP - sum(widths[:-1]), _NARROWEST))
        rows = [(row, _POINTS, {"weight": "bold"} if any(titles) and k == 0 else {}) for k, row in enumerate(every)]
        lines = sum(max(len(_wrapped(row[k], widths[k] - _GAP, _POINTS)) for k in range(len(row))) for row in every)
        if lines * _LINE * _POINTS / 72.0 < _TOGETHER:
            self._room(lines * _LINE * _POINTS / 72.0)
        self._rows(rows, widths, [align.startswith(">") for _, align in table.columns])
        if table.rest.strip():
            for text in table.rest.splitlines():
                self.paragraph(text.strip(), _SMALL)

    def figure(self, illustration: Illustration, caption: str) -> None:
        """Draw a figure as wide as the text, or a little lower where it then fits on the page, and its caption."""
        from matplotlib.gridspec import GridSpec

        whole = min(_WIDE * illustration.height, _TOP - _BOTTOM - 0.8)
        lines = _wrapped(caption, _WIDE, _SMALL)
        below = 0.12 + _LINE * _SMALL / 72.0 * len(lines)
        self._room(_SHRUNK * whole + below)
        height = min(whole, self.place - _BOTTOM - below)
        across, up = _A4
        grid = GridSpec(
            3,
            3,
            figure=self.page,
            height_ratios=[up - self.place, height, self.place - height],
            width_ratios=[_LEFT, _WIDE, across - _RIGHT],
        )
        illustration.draw(self.page.add_subfigure(grid[1, 1]))
        self.place -= height + 0.06
        for line in lines:
            self._write(_LEFT, line, _SMALL, style="italic")
            self.place -= _LINE * _SMALL / 72.0
        self.place -= 0.14

    def number(self, title: str) -> None:
        """Write the number of each page, and the title, at its foot."""
        for k, page in enumerate(self.pages, 1):
            style: dict[str, Any] = {"fontsize": _SMALL, "color": "0.35", "parse_math": False}
            page.text(_LEFT / _A4[0], 0.45 / _A4[1], title, **style)
            page.text(_RIGHT / _A4[0], 0.45 / _A4[1], f"{k} of {len(self.pages)}", ha="right", **style)

    @property
    def page(self) -> Any:
        """The page that is being filled."""
        return self.pages[-1]

    def _rows(
        self,
        rows: Iterable[tuple[Sequence[str], float, dict[str, Any]]],
        widths: Sequence[float],
        right: Sequence[bool] = (),
    ) -> None:
        """Write rows of cells, each with a size of type and a style, in columns; those to the ``right`` end there."""
        for cells, size, style in rows:
            weight = style.get("weight", "normal")
            texts = [_wrapped(cell, width - _GAP, size, weight) for cell, width in zip(cells, widths, strict=True)]
            step = _LINE * size / 72.0
            self._room(step * max(map(len, texts)))
            top, left = self.place, _LEFT
            for k, lines in enumerate(texts):
                self.place = top
                is_right = k < len(right) and right[k]
                for line in lines:
                    place = left + widths[k] - _GAP if is_right else left
                    self._write(place, line, size, ha="right" if is_right else "left", **style)
                    self.place -= step
                left += widths[k]
            self.place = top - step * max(map(len, texts))
        self.place -= 0.04

    def _room(self, height: float) -> None:
        """Begin a new page unless so much fits on this one."""
        if not self.pages or self.place - height < _BOTTOM:
            from matplotlib.figure import Figure

            self.pages.append(Figure(figsize=_A4, facecolor=palette.STABLE, layout="constrained"))
            self.place = _TOP

    def _write(self, left: float, text: str, size: float, **style: Any) -> None:
        x, y = left / _A4[0], self.place / _A4[1]
        self.page.text(x, y, text, va="top", parse_math=False, color="black", fontsize=size, **style)

    def _line(self, left: float, right: float, place: float, width: float, colour: str) -> None:
        from matplotlib.lines import Line2D

        across, up = _A4
        x, y = [left / across, right / across], [place / up, place / up]
        line = Line2D(x, y, linewidth=width, color=colour, transform=self.page.transSubfigure)
        self.page.add_artist(line)


def _wrapped(text: str, width: float, size: float, weight: str = "normal") -> list[str]:
    """Return a text in lines no wider than so many inches; wider words are divided."""
    lines = [""]
    for word in _words(text, width, size, weight):
        longer = f"{lines[-1]} {word}" if lines[-1] else word
        if _width(longer, size, weight) <= width + _ROUNDING or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def _words(text: str, width: float, size: float, weight: str) -> Iterator[str]:
    """Yield the words of a text, in parts where they are wider than a line."""
    for word in text.split():
        while _width(word, size, weight) > width + _ROUNDING and len(word) > 1:
            ends = (k for k in range(len(word) - 1, 0, -1) if k == 1 or _width(word[:k], size, weight) <= width)
            end = next(ends)
            yield word[:end]
            word = word[end:]
        yield word


@functools.lru_cache(maxsize=4096)
def _width(text: str, size: float, weight: str = "normal") -> float:
    """Return how wide a text is in inches."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(size=size, weight=weight)
    return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0]) / 72.0
