"""Results as a document to pass on: one HTML file that needs no other, or a PDF of A4 pages."""

from __future__ import annotations

import base64
import io
import textwrap
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.files import atomic_file
from floquetrod._util.report import Report
from floquetrod.plotting import palette

KINDS = (".html", ".pdf")
"""Endings of the files that can be written."""

_A4 = (8.27, 11.69)  # inches
_COLUMNS, _ROWS = 92, 74  # of a page of text in 8.5 points
_SALT = "floquetrod"  # so that the same figure has the same bytes

_COLOURS = [
    "; ".join(f"--{name}: {pair[shade]}" for name, pair in palette.PAGE.items()) for shade in (0, 1)
]  # in light, in the dark
_STYLE = (
    f"""
:root {{ color-scheme: light dark; {_COLOURS[0]}; }}
@media (prefers-color-scheme: dark) {{ :root {{ {_COLOURS[1]}; }} }}
@media print {{ :root {{ {_COLOURS[0]}; }} section {{ break-inside: avoid; }} }}
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
img { width: 100%; height: auto; border-radius: 4px; }
"""
)


class Section(NamedTuple):
    """A part of a document: a title, what is said, and what is drawn, axes or a figure, when it is written."""

    title: str
    report: Report | None = None
    draw: Callable[[], Any] | None = None


def save(path: str | Path, title: str, sections: Sequence[Section]) -> Path:
    """Write a document to a file that ends in .html or .pdf, whole or not at all; ValueError for other endings."""
    path = validate.path("path", path)
    if path.suffix.lower() not in KINDS:
        raise validate.wrong_value("path", f"must end in {' or '.join(KINDS)}, got {str(path)!r}")
    content = _html(title, sections) if path.suffix.lower() == ".html" else _pdf(title, sections)
    with atomic_file(path) as file:
        file.write(content)
    return path


def _html(title: str, sections: Sequence[Section]) -> bytes:
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


def _pdf(title: str, sections: Sequence[Section]) -> bytes:
    from matplotlib.backends.backend_pdf import PdfPages

    file = io.BytesIO()
    with PdfPages(file, metadata={"Title": title, "CreationDate": None}) as pages:
        lines = [title, "=" * min(len(title), _COLUMNS), ""]
        for section in sections:
            lines += [section.title, "-" * len(section.title), ""]
            if section.report is not None:
                lines += [*_wrapped(str(section.report)), ""]
            if section.draw is not None:
                _text_pages(pages, lines)
                lines = []
                _figure_page(pages, section.title, section.draw)
        _text_pages(pages, lines)
    return file.getvalue()


def _wrapped(text: str) -> Iterator[str]:
    """Yield the lines of a report no wider than a page; what continues a line stands under its text."""
    for line in text.splitlines():
        indent = " " * (len(line) - len(line.lstrip()) + 2)
        yield from textwrap.wrap(line, _COLUMNS, subsequent_indent=indent, replace_whitespace=False) or [""]


def _text_pages(pages: Any, lines: list[str]) -> None:
    for start in range(0, len(lines), _ROWS):
        page = _page()
        page.text(
            0.09, 0.95, "\n".join(lines[start : start + _ROWS]), family="monospace", fontsize=8.5, va="top",
            linespacing=1.25, parse_math=False, color="black",
        )  # fmt: skip
        pages.savefig(page)


def _figure_page(pages: Any, title: str, draw: Callable[[], Any]) -> None:
    from matplotlib.image import imread

    page = _page()
    page.text(0.09, 0.95, title, fontsize=12, va="top", color="black")
    axes = page.add_axes((0.09, 0.08, 0.82, 0.84))
    axes.set_axis_off()
    axes.imshow(imread(io.BytesIO(_drawn(draw, "png")), format="png"))
    axes.set_anchor("N")
    pages.savefig(page)


def _page() -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=_A4, facecolor=palette.STABLE)


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
