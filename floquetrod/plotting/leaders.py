"""Labels beside the points they name, joined to them by a dotted line; laid out again whenever a figure is drawn."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.plotting import palette
from floquetrod.plotting.labels import Mask, add_labels, cells_inside, free_cells, label

_CELL = 2.0  # side in points of the cells in which room is searched for (a choice)
_ROOM = 4.0  # points around a label (a choice)
_NEAR = 9.0  # points up to which a label needs no line (a choice)
_CENTRED = 1e-3  # weight of the distance from its middle (a choice)
_LEADER: dict[str, Any] = {"color": "black", "linewidth": 0.7, "linestyle": (0.0, (1.0, 2.0))}
_END: dict[str, Any] = {"color": "black", "marker": "o", "markersize": 2.0, "linestyle": "none"}
"""Styles of a line and of its end at the point: dotted, as no boundary of a chart is."""

_COVERED = 1e3  # weight of a cell that is covered, against a cell of distance (a choice)


def add_leaders(
    ax: Any,
    names: Sequence[str],
    points: Sequence[tuple[float, float]],
    shapes: Sequence[Any] = (),
    farthest: float = math.inf,
) -> None:
    """Name points, in the units of the axes, where nothing is covered, nor ``shapes``, which have ``x`` and ``y``.

    A name for which there is no room within so many typographic points, ``farthest``, is left out.
    """
    if names:
        ax.add_artist(_artist()(names, points, shapes, farthest))


def name_bands(ax: Any, bands: Sequence[Any], *, halo: bool, note: Callable[[str], str] | None = None) -> None:
    """Name bands inside them, and each of the tongues that merge in one beside the place where it begins.

    As `floquetrod.plotting.labels.add_labels`.
    """
    merging = [band for band in bands if band.merged]
    tongues = [tongue for band in merging for tongue in band.merged]
    add_labels(ax, [band for band in bands if not band.merged], halo=halo, note=note, others=merging)
    add_leaders(ax, [label(tongue) for tongue in tongues], [tongue.place for tongue in tongues], bands)


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


@functools.cache
def _artist() -> Any:
    """Return the class of the artist, which matplotlib is imported for."""
    from matplotlib.artist import Artist
    from matplotlib.lines import Line2D
    from matplotlib.patheffects import withStroke
    from matplotlib.text import Text

    class Leaders(Artist):
        """Labels beside points, placed when drawn: then the size of the axes, and what else they hold, is known."""

        def __init__(
            self,
            names: Sequence[str],
            points: Sequence[tuple[float, float]],
            shapes: Sequence[Any],
            farthest: float,
        ) -> None:
            super().__init__()
            self.set_zorder(5.0)
            self.set_in_layout(False)
            effects = [withStroke(linewidth=2.0, foreground=palette.STABLE)]
            style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "x-small", "path_effects": effects}
            self.texts = [Text(0, 0, name, **style) for name in names]
            self.points = points
            self.shapes = shapes
            self.farthest = farthest

        def draw(self, renderer: Any) -> None:
            """Draw every label, and the line to its point."""
            if not self.get_visible():
                return
            axes: Any = self.axes
            window, cell = axes.get_window_extent(renderer), renderer.points_to_pixels(_CELL)
            corner = np.array([window.x0, window.y0])

            def in_cells(x: Any, y: Any) -> Floats:
                points = axes.transData.transform(np.column_stack(np.atleast_1d(x, y)))
                return np.asarray((points - corner) / cell - 0.5)

            free = free_cells(axes, renderer, cell)
            for shape in self.shapes:
                x, y = in_cells(shape.x, shape.y).T
                free &= ~cells_inside(x, y, free.shape)
            for text, (point,) in zip(self.texts, (in_cells(*each) for each in self.points), strict=True):
                text.set_figure(self.figure)
                text.set_visible(True)  # else it has no extent
                extent = text.get_window_extent(renderer)
                size = np.array([extent.width, extent.height]) / cell
                middle = nearest_room(free, point, size + _ROOM / _CELL)
                end = point if middle is None else np.clip(point, middle - 0.5 * size, middle + 0.5 * size)
                away = float(np.hypot(*(end - point))) * _CELL
                text.set_visible(middle is not None and away <= self.farthest)
                if middle is None or away > self.farthest:
                    continue
                take(free, middle, size + _ROOM / _CELL)
                if away > _NEAR:
                    x, y = (corner + cell * (np.array([point, end]) + 0.5)).T
                    for line in (Line2D(x, y, **_LEADER), Line2D(x[:1], y[:1], **_END)):
                        line.set_figure(self.figure)
                        line.draw(renderer)
                text.set_position(corner + cell * (middle + 0.5))
                text.draw(renderer)

    return Leaders
