"""Pages of the site that docstrings name, such as `theory/ranges`, are links there; help() shows the name."""

from __future__ import annotations

import re

import sphinx.application

PAGE = re.compile(r"(?<!`)`((?:how_to|reference|start|theory)/\w+)`(?!`)")


def linked(text: str) -> str:
    """Return a line of a docstring with the names of pages as links, which Sphinx shows by their titles."""
    return PAGE.sub(r":doc:`/\1`", text)


def _linked(app: object, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    lines[:] = map(linked, lines)


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Do so with what autodoc found."""
    app.connect("autodoc-process-docstring", _linked)
    return {"parallel_read_safe": True}
