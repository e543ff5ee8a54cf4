"""Labels beside the points they name, joined to them by a dotted line; laid out again whenever a figure is drawn."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.plotting import palette
from floquetrod.plotting.labels import add_labels, cells_inside, draw_line, free_cells, label, nearest_room, take

_CELL = 2.0  # side in points of the cells in which room is searched for (a choice)
_ROOM = 4.0  # points around a label (a choice)
_NEAR = 9.0  # points up to which a label needs no line (a choice)


def add_leaders(
    ax: Any,
    names: Sequence[str],
    points: Sequence[tuple[float, float]],
    shapes: Sequence[Any] = (),
    farthest: float = math.inf,
    written: Any = None,
) -> None:
    """Name points, in the units of the axes, where nothing is covered, nor ``shapes``, which have ``x`` and ``y``.

    A name for which there is no room within so many typographic points, ``farthest``, is left out.  ``written`` are
    names of bands, as of `floquetrod.plotting.labels.add_labels`, over which nothing is written.
    """
    if names:
        ax.add_artist(_artist()(names, points, shapes, farthest, written))


def name_bands(ax: Any, bands: Sequence[Any], *, halo: bool, note: Callable[[str], str] | None = None) -> None:
    """Name bands as `floquetrod.plotting.labels.add_labels`, and tongues that merge in one where each begins."""
    merging = [band for band in bands if band.merged]
    others = [band for band in bands if band.merged or not label(band)]
    tongues = [tongue for band in merging for tongue in band.merged]
    written = add_labels(ax, [band for band in bands if not band.merged], halo=halo, note=note, others=others)
    names, starts = [label(tongue) for tongue in tongues], [tongue.place for tongue in tongues]
    add_leaders(ax, names, starts, bands, written=written)


@functools.cache
def _artist() -> Any:
    """Return the class of the artist, which matplotlib is imported for."""
    from matplotlib.artist import Artist
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
            written: Any,
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
            self.written = written

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
            for box in self.written.boxes_beside(renderer) if self.written is not None else ():
                take(free, (0.5 * (box.min + box.max) - corner) / cell - 0.5, np.array([box.width, box.height]) / cell)
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
                    draw_line(self.figure, renderer, x, y)
                text.set_position(corner + cell * (middle + 0.5))
                text.draw(renderer)

    return Leaders
