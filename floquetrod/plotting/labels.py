"""Names of bands, inside them where there is room, else beside; laid out again whenever a figure is drawn."""

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
_FEW = 6  # bands without room inside, of which each is named beside it; of more none is, for a clear picture (a choice)
_BESIDE = 30.0  # points between a band and its name beside it, at most (a choice)
_CENTRED = 1e-3  # weight of the distance of a point from the middle of its label (a choice)
_COVERED = 1e3  # weight of a cell that is covered, against a cell of distance (a choice)
_LEADER: dict[str, Any] = {"color": "black", "linewidth": 0.7, "linestyle": (0.0, (1.0, 2.0))}
_END: dict[str, Any] = {"color": "black", "marker": "o", "markersize": 2.0, "linestyle": "none"}
"""Styles of a line and of its end at the point: dotted, as no boundary of a chart is."""


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
) -> Any:
    """Name the bands in axes whenever these are drawn; ``halo``: letters are edged, for areas that may be dark.

    A few bands that are too narrow for their names have them beside, joined by a dotted line.  Returns the artist, None
    where no band has a name.

    ``note`` makes the note over the legend of what a label means, which then is explained by one that is drawn, or by
    one of the ``others``, bands that are named elsewhere or not at all.
    """
    named = sorted((band for band in bands if label(band)), key=_area, reverse=True)[:_MOST]
    if not named:
        return None
    drawn = _artists().labels([label(band) for band in named], named, halo, others)
    ax.add_artist(drawn)
    if note is not None:
        ax.add_artist(_artists().note(drawn, lambda shown: note(explanation([*(named[i] for i in shown), *others]))))
    return drawn


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


def places_beside(
    wanted: Sequence[tuple[Floats, Floats, float, float]], free: Mask, numbers: Sequence[int]
) -> dict[int, tuple[Floats, Floats]]:
    """Return where labels of some of the polygons go beside them, by number, and the point of the polygon each names.

    As `places`.  Nothing is written on any of the polygons, nor far from the one that is named.  One that overlaps
    another, or lies behind it, is not named.
    """
    covers = [cells_inside(x, y, free.shape) for x, y, _, _ in wanted]
    count = np.zeros(free.shape, dtype=np.int32)
    for cover in covers:
        count += cover
    free, found, outlines = free & (count == 0), {}, []
    for x, y, _, _ in wanted:
        around = _along(np.column_stack([np.append(x, x[0]), np.append(y, y[0])]), 0.5)
        seen = ((around > -0.5) & (around < np.array(free.shape[::-1]) - 0.5)).all(axis=1)
        outlines.append(around[seen])
        column, row = np.rint(around[seen]).astype(int).T
        free[row, column] = False
    for number in numbers:
        points, size = outlines[number], np.array(wanted[number][2:])
        if not len(points) or (count[covers[number]] > 1).any():
            continue
        point = points[np.hypot(*(points - points.mean(axis=0)).T).argmin()]
        middle = nearest_room(free, point, size)
        if middle is None:
            continue
        (left, low), (w, h) = np.rint(middle - 0.5 * (np.ceil(size) - 1.0)).astype(int), np.ceil(size).astype(int)
        end = np.clip(point, middle - 0.5 * size, middle + 0.5 * size)
        near = np.hypot(*(end - point)) * _CELL <= _BESIDE
        column, row = np.rint(_along(np.array([point, end]), 0.5)).astype(int).T
        crosses = (count - covers[number])[row, column].any()  # another polygon, which the line would seem to name
        if near and not crosses and free[low : low + h, left : left + w].all():
            take(free, middle, size)
            found[number] = middle, point
    return found


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


def nearest_room(free: Mask, point: Floats, size: Floats) -> Floats | None:
    """Return the middle (column, row) of the rectangle nearest to a point that covers least of what is not free.

    All in cells, ``free`` in rows and columns.  None where there is no room for its size (width, height).
    """
    (w, h), (rows, columns) = np.ceil(size).astype(int), free.shape
    if w > columns or h > rows:
        return None
    sums = np.zeros((rows + 1, columns + 1), dtype=np.int64)
    sums[1:, 1:] = (~free).cumsum(axis=0).cumsum(axis=1)
    covered = sums[h:, w:] - sums[:-h, w:] - sums[h:, :-w] + sums[:-h, :-w]
    x, y = np.arange(covered.shape[1]), np.arange(covered.shape[0])
    across = np.maximum(np.maximum(x - point[0], point[0] - (x + w - 1)), 0.0)
    up = np.maximum(np.maximum(y - point[1], point[1] - (y + h - 1)), 0.0)[:, None]
    aside = np.hypot(x + 0.5 * (w - 1) - point[0], (y + 0.5 * (h - 1) - point[1])[:, None])
    cost = _COVERED * covered + np.hypot(across, up) + _CENTRED * aside
    row, column = np.unravel_index(cost.argmin(), cost.shape)
    return np.array([column + 0.5 * (w - 1), row + 0.5 * (h - 1)])


def take(free: Mask, middle: Floats, size: Floats) -> None:
    """Mark the cells of a rectangle as taken."""
    (left, bottom), (right, top) = (np.rint(middle + side * size).astype(int) for side in (-0.5, 0.5))
    free[max(0, bottom) : top + 1, max(0, left) : right + 1] = False


def draw_line(figure: Any, renderer: Any, x: Floats, y: Floats) -> None:
    """Draw the dotted line from a point, with a dot, to its label, in pixels."""
    from matplotlib.lines import Line2D

    for line in (Line2D(x, y, **_LEADER), Line2D(x[:1], y[:1], **_END)):
        line.set_figure(figure)
        line.draw(renderer)


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

        def __init__(self, names: Sequence[str], shapes: Sequence[Any], halo: bool, others: Sequence[Any]) -> None:
            super().__init__()
            self.set_zorder(2.5)
            self.set_in_layout(False)
            self.shapes = shapes
            self.others = others
            effects = [withStroke(linewidth=1.8, foreground=palette.STABLE)] if halo else []
            style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "x-small"}
            self.texts = [Text(0, 0, name, path_effects=effects, **style) for name in names]
            self.ready: list[int] | None = None  # where they have been placed for the note of the same picture
            self.shown: list[str] = []
            self.lines: dict[int, Floats] = {}  # from bands to their names beside them, in pixels

        def placed(self, renderer: Any) -> list[int]:
            """Place the labels and return the numbers of those for which there is room."""
            axes: Any = self.axes
            cell = renderer.points_to_pixels(_CELL)
            window = axes.get_window_extent(renderer)
            corner, around, wanted = np.array([window.x0, window.y0]), _ROOM / _CELL, []

            def in_cells(shape: Any) -> Floats:
                points = axes.transData.transform(np.column_stack([shape.x, shape.y]))
                return np.asarray(((points - corner) / cell - 0.5).T)

            for shape, text in zip(self.shapes, self.texts, strict=True):
                text.set_figure(self.figure)
                (x, y), size = in_cells(shape), text.get_window_extent(renderer)
                wanted.append((x, y, size.width / cell + around, size.height / cell + around))
            free = free_cells(axes, renderer, cell)
            positions: list[Any] = places(wanted, free)
            outside = [number for number, place in enumerate(positions) if place is None]
            beside: dict[int, tuple[Floats, Floats]] = {}
            if 0 < len(outside) <= _FEW:
                avoided = [(x, y, 0.0, 0.0) for x, y in map(in_cells, self.others)]
                beside = places_beside([*wanted, *avoided], free, outside)
            self.lines = {}
            for number, (place, point) in beside.items():
                positions[number] = place
                half = 0.5 * (np.array(wanted[number][2:]) - around)
                ends = np.array([point, np.clip(point, place - half, place + half)])
                self.lines[number] = corner + cell * (ends + 0.5)
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
            for number in numbers:
                if number in self.lines:
                    draw_line(self.figure, renderer, *self.lines[number].T)
            for text in drawn:
                text.draw(renderer)
            self.shown = [text.get_text() for text in drawn]

        def boxes_beside(self, renderer: Any) -> list[Any]:
            """Return the boxes of the names that are written beside their bands."""
            return [self.texts[number].get_window_extent(renderer) for number in self.lines]

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
