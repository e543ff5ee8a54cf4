"""Names of bands, placed inside them where there is room; laid out again whenever a figure is drawn."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.plotting import palette

Mask = NDArray[np.bool_]

_CELL = 1.5  # side in points of the cells in which room is searched for (a choice)
_MOST = 300  # bands examined, the largest ones (a choice)
_ROOM = 3.0  # points around a label (a choice)


def label(band: Any) -> str:
    """Return the short name of a band: "7·1" for mode 7 in tongue 1, "1+2·1" for a combination of modes 1 and 2.

    One number where one is known, "" where none is.
    """
    mode = band.mode if band.partner is None else f"{band.mode}{band.partner:+d}".replace("-", "\N{MINUS SIGN}")
    return "·".join(str(number) for number in (mode, band.tongue) if number is not None)


def explanation(bands: Sequence[Any]) -> str:
    """Return what labels mean, by an example where they are of two numbers; "" where there are none."""
    named = [(tongue, 0.0) for band in bands for tongue in band.merged]
    named += [(band, _area(band)) for band in bands if not band.merged]
    known = [(band, area) for band, area in named if label(band)]
    if not known:
        return ""
    both = [(band, area) for band, area in known if band.mode is not None and band.tongue is not None]
    if both:  # tongue 0 has no room for its name at times
        shown, _ = max(both, key=lambda entry: (entry[0].tongue > 0, entry[1], entry[0].partner is not None))
        return f"labels mode·tongue: {label(shown)} is {shown.name}"
    return "labels: modes" if known[0][0].mode is not None else "labels: tongues"


def add_labels(
    ax: Any,
    bands: Sequence[Any],
    *,
    halo: bool,
    note: Callable[[str], str] | None = None,
    others: Sequence[Any] = (),
) -> None:
    """Name the bands in axes whenever these are drawn; ``halo``: letters are edged, for areas that may be dark.

    ``note`` makes the note over the legend of what a label means, which then is explained by one that is drawn, or by
    one of the ``others``, bands named elsewhere.
    """
    named = sorted((band for band in bands if label(band)), key=_area, reverse=True)[:_MOST]
    if not named:
        return
    drawn = _artists().labels([label(band) for band in named], named, halo)
    ax.add_artist(drawn)
    if note is not None:
        ax.add_artist(_artists().note(drawn, lambda shown: note(explanation([*(named[i] for i in shown), *others]))))


def places(wanted: Sequence[tuple[Floats, Floats, float, float]], free: Mask) -> list[tuple[float, float] | None]:
    """Return where labels go: in the middle of the roomiest part of each polygon, None where there is too little room.

    ``wanted`` are polygons and the size of their labels, (x, y, width, height) in cells, the most important one first.
    Only ``free`` cells (rows, columns) are written on, not where two of the polygons or labels overlap.
    """
    covers = [cells_inside(x, y, free.shape) for x, y, _, _ in wanted]
    count = np.zeros(free.shape, dtype=np.int32)
    for cover in covers:
        count += cover
    free, positions = free & (count == 1), []
    for cover, (_, _, width, height) in zip(covers, wanted, strict=True):
        place = _roomiest(cover & free, width, height)
        positions.append(place)
        if place is not None:
            column, row = (round(value) for value in place)
            across, up = int(width) // 2 + 1, int(height) // 2 + 1
            free[max(0, row - up) : row + up + 1, max(0, column - across) : column + across + 1] = False
    return positions


def _roomiest(mask: Mask, width: float, height: float) -> tuple[float, float] | None:
    """Return the middle (column, row) of the largest rectangle of this shape, or larger, that lies in a mask."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not rows.size:
        return None
    top, left = int(rows[0]), int(columns[0])
    part = mask[top : rows[-1] + 1, left : columns[-1] + 1]
    sums = np.zeros((part.shape[0] + 1, part.shape[1] + 1), dtype=np.int64)
    sums[1:, 1:] = part.cumsum(axis=0).cumsum(axis=1)
    best = None
    for scale in 1.25 ** np.arange(20):
        w, h = int(np.ceil(scale * width)), int(np.ceil(scale * height))
        if w > part.shape[1] or h > part.shape[0]:
            break
        whole = sums[h:, w:] - sums[:-h, w:] - sums[h:, :-w] + sums[:-h, :-w] == w * h
        if not whole.any():
            break
        fits = np.argwhere(whole)
        row, column = fits[np.abs(fits - fits.mean(axis=0)).sum(axis=1).argmin()]
        best = left + column + 0.5 * (w - 1), top + row + 0.5 * (h - 1)
    return best


def cells_inside(x: Floats, y: Floats, shape: tuple[int, int]) -> Mask:
    """Return the cells of a grid whose middles, whole numbers, lie in a polygon, by crossings along each row."""
    count = np.zeros((shape[0], shape[1] + 1), dtype=np.int32)
    ends = np.roll(x, -1), np.roll(y, -1)
    rows = np.arange(shape[0])[:, None]
    row, side = np.nonzero((y <= rows) != (ends[1] <= rows))
    crossing = x[side] + (row - y[side]) * (ends[0][side] - x[side]) / (ends[1][side] - y[side])
    np.add.at(count, (row, np.clip(np.ceil(crossing), 0, shape[1]).astype(np.int64)), 1)
    inside: Mask = count[:, :-1].cumsum(axis=1) % 2 == 1
    return inside


def _area(band: Any) -> float:
    """Return the size of a polygon."""
    x, y = band.x - band.x[0], band.y - band.y[0]
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


class _Artists(NamedTuple):
    """The artists that draw labels, and that keep the note on them true."""

    labels: Any
    note: Any


@functools.cache
def _artists() -> _Artists:
    """Return the classes of artists, which matplotlib is imported for."""
    from matplotlib.artist import Artist
    from matplotlib.patheffects import withStroke
    from matplotlib.text import Text

    class Labels(Artist):
        """Labels of polygons, placed when drawn: then the size of the axes, and what else they hold, is known."""

        def __init__(self, names: Sequence[str], shapes: Sequence[Any], halo: bool) -> None:
            super().__init__()
            self.set_zorder(2.5)
            self.set_in_layout(False)
            self.shapes = shapes
            effects = [withStroke(linewidth=1.8, foreground=palette.STABLE)] if halo else []
            style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "x-small"}
            self.texts = [Text(0, 0, name, path_effects=effects, **style) for name in names]
            self.ready: list[int] | None = None  # where they have been placed for the note of the same picture
            self.shown: list[str] = []

        def placed(self, renderer: Any) -> list[int]:
            """Place the labels and return the numbers of those for which there is room."""
            axes: Any = self.axes
            cell = renderer.points_to_pixels(_CELL)
            window = axes.get_window_extent(renderer)
            wanted = []
            for shape, text in zip(self.shapes, self.texts, strict=True):
                text.set_figure(self.figure)
                points = axes.transData.transform(np.column_stack([shape.x, shape.y]))
                x, y = ((points - (window.x0, window.y0)) / cell - 0.5).T
                around, size = _ROOM / _CELL, text.get_window_extent(renderer)
                wanted.append((x, y, size.width / cell + around, size.height / cell + around))
            positions = places(wanted, free_cells(axes, renderer, cell))
            for text, place in zip(self.texts, positions, strict=True):
                if place is not None:
                    text.set_position((window.x0 + (place[0] + 0.5) * cell, window.y0 + (place[1] + 0.5) * cell))
            return [number for number, place in enumerate(positions) if place is not None]

        def draw(self, renderer: Any) -> None:
            """Draw the labels for which there is room."""
            if not self.get_visible():
                return
            numbers = self.placed(renderer) if self.ready is None else self.ready
            drawn, self.ready = [self.texts[number] for number in numbers], None
            for text in drawn:
                text.draw(renderer)
            self.shown = [text.get_text() for text in drawn]

    class Note(Artist):
        """What keeps the note over a legend true, which is drawn before the labels are: it draws nothing."""

        def __init__(self, labels: Any, note: Callable[[list[int]], str]) -> None:
            super().__init__()
            self.set_zorder(0.5)
            self.set_in_layout(False)
            self.labels = labels
            self.note = note

        def draw(self, renderer: Any) -> None:
            """Write the note on the labels that will be drawn."""
            legend = self.axes.get_legend() if self.axes is not None else None
            if legend is not None and self.labels.get_visible():
                self.labels.ready = self.labels.placed(renderer)
                legend.get_title().set_text(self.note(self.labels.ready))

    return _Artists(Labels, Note)


_NOTHING = ("None", "none", "", " ", None)
"""What matplotlib calls a line or a marker that is none."""


def free_cells(ax: Any, renderer: Any, cell: float) -> Mask:
    """Return which cells of the axes hold no line, marker, text or legend."""
    window = ax.get_window_extent(renderer)
    shape = max(1, int(window.height / cell)), max(1, int(window.width / cell))
    free = np.ones(shape, dtype=np.bool_)
    free[[0, -1]] = free[:, [0, -1]] = False
    boxes = []
    for line in ax.lines:
        points = line.get_transform().transform(line.get_xydata())
        if line.get_linestyle() not in _NOTHING:
            boxes.append(np.tile(_along(points, cell), 2))
        if line.get_marker() not in _NOTHING:
            radius = 0.5 * renderer.points_to_pixels(line.get_markersize())
            boxes.append(np.hstack([points - radius, points + radius]))
    for other in [*ax.texts, ax.get_legend()]:
        if other is not None and other.get_visible():
            boxes.append(other.get_window_extent(renderer).extents[None])
    taken = (np.vstack([np.empty((0, 4)), *boxes]) - [window.x0, window.y0] * 2) / cell
    taken = taken[np.isfinite(taken).all(axis=1) & (taken[:, 2:] > 0.0).all(axis=1)]
    first, last = np.clip(taken[:, :2], 0.0, 1e6).astype(int), np.clip(taken[:, 2:], 0.0, 1e6).astype(int) + 1
    for (x0, y0), (x1, y1) in zip(first.tolist(), last.tolist(), strict=True):
        free[y0:y1, x0:x1] = False
    return free


def _along(points: Floats, step: float) -> Floats:
    """Return points along a line, not farther apart than ``step`` where the line is not endless."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        return points
    length = np.r_[0.0, np.hypot(*np.diff(points, axis=0).T).cumsum()]
    at = np.linspace(0.0, length[-1], min(20_000, int(length[-1] / step) + 2))
    return np.column_stack([np.interp(at, length, points[:, 0]), np.interp(at, length, points[:, 1])])
