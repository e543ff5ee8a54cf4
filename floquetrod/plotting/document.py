"""Results as a document to pass on: one HTML file that needs no other, or a PDF of A4 pages."""

from __future__ import annotations

import base64
import io
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.result_report import Report
from floquetrod._util.sealed_files import atomic_file
from floquetrod.plotting import palette

KINDS = (".html", ".pdf")
"""Endings of the files that can be written."""

_A4 = (8.27, 11.69)  # inches
_COLUMNS = 92  # of text
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.75, 7.52, 11.1, 0.75  # inches, of what is printed
_POINTS, _LINE = 8.5, 0.148  # size of the text, and inches from line to line
_NARROWEST = 30  # columns of a text that is continued
_SHRUNK = 0.75  # part of its height to which a figure is shrunk to fit on a page
_SALT = "floquetrod"  # so that the same figure has the same bytes

_COLOURS = [
    "; ".join(f"--{name}: {pair[shade]}" for name, pair in palette.PAGE.items()) for shade in (0, 1)
]  # in light, in the dark
_STYLE = (
    f"""
:root {{ color-scheme: light dark; {_COLOURS[0]}; }}
@media (prefers-color-scheme: dark) {{ :root {{ {_COLOURS[1]}; }} }}
@media print {{ :root {{ {_COLOURS[0]}; }} h2, .wide > p {{ break-after: avoid; }} tr, img {{ break-inside: avoid; }} }}
img {{ background: {palette.STABLE}; }}
"""
    + """
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--page); max-width: 52rem;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid var(--line); }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.9rem; }
th, td { text-align: left; vertical-align: top; padding: 0.15rem 0.9rem 0.15rem 0; }
table + table { margin-top: 0.8rem; } th { font-weight: 600; white-space: nowrap; }
td { overflow-wrap: break-word; } td:not(:last-child) { white-space: nowrap; }
td:nth-child(3) ~ td:last-child { min-width: 14rem; }
img { width: 100%; height: auto; max-height: 25cm; object-fit: contain; border-radius: 4px; }
@media print { :root { font-size: 12px; } body { font-size: 1rem; margin: 0; max-width: none; } }
@media print { img { max-height: 24cm; } }
@page { margin: 15mm; }
"""
)


class DocumentSection(NamedTuple):
    """A part of a document: a title, a report, and a function that draws axes or a figure when it is written."""

    title: str
    report: Report | None = None
    draw: Callable[[], Any] | None = None


def save(path: str | Path, title: str, sections: Sequence[DocumentSection]) -> Path:
    """Write a document to a file that ends in .html or .pdf, whole or not at all; ValueError for other endings."""
    path = validate.path("path", path)
    if path.suffix.lower() not in KINDS:
        raise validate.wrong_value("path", f"must end in {' or '.join(KINDS)}, got {str(path)!r}")
    content = _html(title, sections) if path.suffix.lower() == ".html" else _pdf(title, sections)
    with atomic_file(path) as file:
        file.write(content)
    return path


def _html(title: str, sections: Sequence[DocumentSection]) -> bytes:
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{escape(title)}</h1>",
    ]
    for section in sections:
        parts.append(f"<section><h2>{escape(section.title)}</h2>")
        if section.report is not None:
            parts.append(f'<div class="wide">{section.report._repr_html_()}</div>')
        if section.draw is not None:
            picture = base64.b64encode(_drawn(section.draw, "svg")).decode()
            parts.append(f'<img alt="{escape(section.title)}" src="data:image/svg+xml;base64,{picture}">')
        parts.append("</section>")
    return "\n".join([*parts, "</body></html>", ""]).encode()


def _pdf(title: str, sections: Sequence[DocumentSection]) -> bytes:
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.image import imread

    file = io.BytesIO()
    with PdfPages(file, metadata={"Title": title, "CreationDate": None}) as pdf:
        pages = _Pages(pdf)
        pages.head(title, 14.0)
        for section in sections:
            picture = None if section.draw is None else imread(io.BytesIO(_drawn(section.draw, "png")), format="png")
            pages.head(section.title, 11.0, 1.0 if section.report is not None else _SHRUNK * _height(picture))
            if section.report is not None:
                pages.text(_wrapped(str(section.report)))
            if picture is not None:
                pages.figure(picture)
        pages.end()
    return file.getvalue()


class _Pages:
    """Pages of a PDF, filled from top to bottom."""

    def __init__(self, pdf: Any) -> None:
        self.pdf = pdf
        self.page: Any = None
        self.place = 0.0  # of what comes next, in inches from below

    def end(self) -> None:
        """Write the page that was begun."""
        if self.page is not None:
            self.pdf.savefig(self.page)
        self.page, self.place = None, 0.0

    def head(self, title: str, size: float, below: float = 1.0) -> None:
        """Write a title, on a new page where there is less than so much room ``below`` it."""
        self._room(0.45 + below)
        self._write(title, self.place - 0.1, fontsize=size, weight="bold")
        self.place -= 0.45

    def text(self, lines: Iterable[Sequence[str]]) -> None:
        """Write lines, each with what continues it on the same page."""
        for parts in lines:
            self._room(_LINE * len(parts))
            for part in parts:
                self._write(part, self.place, family="monospace", fontsize=_POINTS)
                self.place -= _LINE
        self.place -= 0.15

    def figure(self, picture: Any) -> None:
        """Place a picture as wide as the text, or a little smaller where it then fits on the page."""
        self._room(_SHRUNK * _height(picture))
        low = max(self.place - _height(picture), _BOTTOM)
        across, up = _A4
        axes = self.page.add_axes((_LEFT / across, low / up, (_RIGHT - _LEFT) / across, (self.place - low) / up))
        axes.set_axis_off()
        axes.imshow(picture, interpolation="antialiased")
        axes.set_anchor("N")
        self.place = low - 0.2

    def _room(self, height: float) -> None:
        """Begin a new page unless so much fits on this one."""
        if self.page is None or self.place - height < _BOTTOM:
            from matplotlib.figure import Figure

            self.end()
            self.page, self.place = Figure(figsize=_A4, facecolor=palette.STABLE), _TOP

    def _write(self, text: str, place: float, **style: Any) -> None:
        x, y = _LEFT / _A4[0], place / _A4[1]
        self.page.text(x, y, text, va="top", parse_math=False, color="black", **style)


def _height(picture: Any) -> float:
    """Return how high a picture is, in inches, that is as wide as the text, or as high as a page."""
    return float(min((_RIGHT - _LEFT) * picture.shape[0] / picture.shape[1], _TOP - _BOTTOM))


def _wrapped(text: str) -> Iterator[Sequence[str]]:
    """Yield the lines of a report in parts no wider than a page, the later ones under the last column of the first."""
    for line in text.splitlines():
        columns = [match.end() for match in re.finditer(r"(?<=\S) {2,}(?=\S)|^ +", line)]
        indent = " " * min(columns[-1] if columns else 0, _COLUMNS - _NARROWEST)
        yield textwrap.wrap(line, _COLUMNS, subsequent_indent=indent, replace_whitespace=False) or [""]


def _drawn(draw: Callable[[], Any], kind: str) -> bytes:
    """Return a figure as a file of a kind, and close it."""
    import matplotlib as mpl
    from matplotlib import pyplot

    drawn = draw()
    figure = getattr(drawn, "figure", drawn)
    file = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": _SALT}):
        figure.savefig(file, format=kind, dpi=200, metadata={"Date": None} if kind == "svg" else None)
    pyplot.close(figure)
    return file.getvalue()
