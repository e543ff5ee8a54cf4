"""One figure of the study, or one panel of it, with the data that are drawn."""

from __future__ import annotations

import csv
import re
import textwrap
from collections.abc import Iterator
from typing import Any, TextIO

import numpy as np

_WIDTH = 92  # characters of a line of the caption under one panel

_HEAD = ("panel", "shape", "number")

Row = tuple[str, int, float, float, float | None]
"""Name of a shape, its number, x, y, and the value of a point of a map."""


def panels_of(figure: Any) -> dict[str, Any]:
    """Return the panels of a figure by their letters; where these have none, all axes by their numbers."""
    titles = {ax.get_title(loc="left"): ax for ax in figure.axes}
    lettered = {title[1]: ax for title, ax in titles.items() if re.fullmatch(r"\([a-h]\)", title)}
    return lettered or {str(number): ax for number, ax in enumerate(figure.axes, 1)}


def keep_panel(figure: Any, letter: str) -> None:
    """Leave one panel of a figure, in a page of its own, with the caption of all."""
    from matplotlib.gridspec import GridSpec

    kept = panels_of(figure)[letter]
    for ax in list(figure.axes):
        if ax is not kept:
            ax.remove()
    kept.set_subplotspec(GridSpec(1, 1, figure=figure)[0])
    figure.set_size_inches(5.0, 4.8)
    caption = " ".join(figure.get_supxlabel().split())
    figure.supxlabel(textwrap.fill(caption, _WIDTH), fontsize="x-small", x=0.01, ha="left")


def write_data(figure: Any, file: TextIO) -> None:
    """Write what is drawn as CSV: points of lines, corners of bands and bars, points of maps with their values.

    The columns are the panel, the shape, its number among those of its name, the two coordinates and, of maps, the
    value.  Where panels have different axes, each begins with a heading of its own.
    """
    heading: tuple[str, ...] = ()
    table = csv.writer(file, lineterminator="\n")
    for panel, ax in panels_of(figure).items():
        columns = (*_HEAD, *(_plain(label) for label in _labels(figure, ax)), "value")
        for shape, number, x, y, value in _rows(ax):
            if columns != heading:
                table.writerow(columns)
                heading = columns
            table.writerow((panel, shape, number, f"{x:.12g}", f"{y:.12g}", "" if value is None else f"{value:.12g}"))


def _labels(figure: Any, ax: Any) -> tuple[str, str]:
    """Return what is on the axes of a panel; strips from above share theirs, and have names of loads in their place."""
    return (ax.get_xlabel(), ax.get_ylabel()) if len(figure.axes) < 10 else ("x / m", "y / mm")


def _rows(ax: Any) -> Iterator[Row]:
    """Yield the rows of a panel, shape by shape."""
    from matplotlib.collections import PolyCollection, QuadMesh

    numbers: dict[str, int] = {}
    for artist in [*ax.collections, *ax.lines]:
        name = artist.get_label()
        if not name or name.startswith("_"):  # no datum: contours of a map, say
            continue
        if isinstance(artist, QuadMesh):
            yield from ((name, 1, *point) for point in _points(artist))
            continue
        is_area = isinstance(artist, PolyCollection)
        lines: list[Any] = [path.vertices for path in artist.get_paths()] if is_area else [artist.get_xydata()]
        for line in lines:
            numbers[name] = numbers.get(name, 0) + 1
            yield from ((name, numbers[name], float(x), float(y), None) for x, y in line if np.isfinite(x + y))


def _points(mesh: Any) -> Iterator[tuple[float, float, float]]:
    """Yield the points of a map that are drawn, each with its value."""
    corners = mesh.get_coordinates()
    centres = 0.25 * (corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1])
    values = np.ma.asarray(mesh.get_array()).reshape(centres.shape[:2])
    drawn = ~np.ma.getmaskarray(values)
    for (x, y), value in zip(centres[drawn], values[drawn], strict=True):
        yield float(x), float(y), float(value)


def _plain(label: str) -> str:
    r"""Return the label of an axis without its typesetting.

    >>> _plain(r"$F_\mathrm{ave} / F_\mathrm{cr}$")
    'F_ave / F_cr'
    """
    return re.sub(r"\\mathrm\{(\w+)\}|[$\\]", r"\1", label)
