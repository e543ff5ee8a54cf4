"""Bands of any chart whose points can be judged: their boundaries traced from verdicts alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from floquetrod.plane.axes import Axis
from floquetrod.plane.bands import Band, Bands
from floquetrod.plane.chart import Progress
from floquetrod.plane.contours import crossings
from floquetrod.plane.judging import VERTEX, Bools, Floats, Judge, Namer, OutOfBudget, Plane
from floquetrod.plane.outline import Outline
from floquetrod.plane.polygons import contains, with_holes_joined
from floquetrod.plane.refining import outlined, refined

_FEWEST, _MOST, _EACH = 30_000, 300_000, 30
"""Points judged at most: ``_EACH`` for each of the chart's, at least the first and at most the second (a choice)."""

_STARTS = 64  # points of a band at which growth is examined first (a choice)
_CLIMBS = 40  # rounds of looking for larger growth nearby, at most (a choice)
_SMALL = 1e-3  # step of that at which it ends, as a share of the grid's (a choice)


@dataclass(frozen=True, eq=False)
class TracedBands:
    """A source of bands: what judges points, and what a chart has found on its grid.

    Attributes
    ----------
    judge : callable (x (n,), y (n,)) -> (status, growth rate)
        Status 1 where stable, 0 where not, -1 where undecided, which bounds a band like a stable place; growth rates
        of the unstable places, NaN where not known.
    x, y : Axis
    unstable : ndarray (ny, nx) of bool
    growth : callable (x (n,), y (n,)) -> growth rate, optional
        Growth where ``judge`` does not tell it.
    quick : callable (x (n,), y (n,)) -> (status, growth rate), optional
        A judge that leaves undecided what would take long, for thin tongues: they end where it decides nothing.
    most : int
        Points judged at most.
    vertex : float
        How far vertices may be from the boundary, as a share of the axes; tongues ten times as thin are not followed.
    name : callable (x, y) -> (mode, partner, tongue), optional
        What grows at a place, each None where it is not known, see `Band`.
    prompt : bool
        As in `floquetrod.plane.BandSource`.
    growth_unit, growth_tolerance
        As in `Chart`.

    Notes
    -----
    Marching squares over the chart's points give the regions; sides are divided, on the boundary itself, until they
    lie within the accuracy; where a region ends bluntly, its tongue is followed to its tip, and joined to what it
    meets.  Regions, and gaps in them, that no point of the grid shows are missed.
    """

    judge: Judge
    x: Axis
    y: Axis
    unstable: Bools
    growth_unit: str
    growth_tolerance: float
    growth: Callable[[Floats, Floats], Floats] | None = None
    quick: Judge | None = None
    most: int = _MOST
    vertex: float = VERTEX
    prompt: bool = True
    name: Namer | None = None

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands; ``accuracy`` is coarser in them than asked for where that would need too many points."""
        most = min(self.most, max(_FEWEST, _EACH * self.unstable.size))
        plane = Plane(self.judge, self.x, self.y, self.growth_tolerance, most, self.quick, self.vertex)
        steps = np.array([np.diff(axis.values).max() for axis in (self.x, self.y)])
        outline = Outline()
        reached = accuracy
        try:
            u, v = self._grid(plane)
            outline = outlined(plane, crossings(u, v, self.unstable))
            whole = refined(plane, outline, accuracy, progress or (lambda *_: None))
        except OutOfBudget:
            whole = False
        if not whole:
            reached = max(accuracy, float((steps / (plane.high - plane.low)).max()))
        bands = [self._band(plane, ring) for ring in with_holes_joined(outline.rings())]
        return Bands(
            self.x.ends,
            self.y.ends,
            tuple(bands),
            self.growth_unit,
            self.growth_tolerance,
            0,
            reached,
            (float(steps[0]), float(steps[1])),
        )

    def _grid(self, plane: Plane) -> tuple[Floats, Floats]:
        """Return columns and rows as shares of the axes."""
        u, v = ((a.values - a.values[0]) / (a.values[-1] - a.values[0]) for a in (self.x, self.y))
        return u, v

    def _band(self, plane: Plane, ring: Floats) -> Band:
        """Return the band within a ring."""
        place, growth = self._fastest(plane, ring)
        vertices, at = plane.places(ring), plane.places(place[None])[0]
        where = float(at[0]), float(at[1])
        mode, partner, tongue = (None, None, None) if self.name is None else self.name(*where)
        return Band(vertices[:, 0], vertices[:, 1], mode, tongue, growth, where, partner)

    def _rates(self, plane: Plane, shares: Floats) -> Floats:
        """Return growth rates at places."""
        x, y = plane.places(shares).T
        return self.judge(x, y)[1] if self.growth is None else self.growth(x, y)

    def _fastest(self, plane: Plane, ring: Floats) -> tuple[Floats, float]:
        """Return where in a ring growth is largest, and how large: the best of some points, then uphill from there."""
        u, v = self._grid(plane)
        low, high = ring.min(axis=0), ring.max(axis=0)
        columns, rows = (
            np.arange(np.searchsorted(line, low[k]), np.searchsorted(line, high[k], "right"))
            for k, line in enumerate((u, v))
        )
        across, up = (part.ravel() for part in np.meshgrid(columns, rows))
        some = self.unstable[up, across]
        points = np.column_stack([u[across[some]], v[up[some]]])
        points = points[_inside(ring, points)]
        if not len(points):
            points = _within(ring)
        points = points[:: -(-len(points) // _STARTS)]
        rates = self._rates(plane, points)
        if not np.isfinite(rates).any():
            free = np.hypot(*(points[:, None] - ring[None]).T).min(axis=0)
            return points[int(free.argmax())], float("nan")
        best = int(np.nanargmax(rates))
        place, growth = points[best], float(rates[best])
        step, last = (high - low) / 8.0, _SMALL * np.array([np.diff(line).max() for line in (u, v)])
        star = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j])
        for _ in range(_CLIMBS):
            if (step < last).all():
                break
            near = np.clip(place + star * step, 0.0, 1.0)
            near = near[_inside(ring, near)]
            rates = self._rates(plane, near) if len(near) else np.empty(0)
            if (rates > growth).any():
                best = int(np.nanargmax(rates))
                place, growth = near[best], float(rates[best])
            else:
                step = 0.5 * step
        return place, growth


def _inside(ring: Floats, places: Floats) -> Bools:
    """Return which places lie within a ring, those on the edge of the plane too."""
    return contains(ring, places + 1e-9 * (0.5 - places))


def _within(ring: Floats) -> Floats:
    """Return one place within a ring: midway between the first two sides on a level line between its vertices."""
    levels = np.unique(ring[:, 1])
    gap = int(np.diff(levels).argmax())
    level = 0.5 * (levels[gap] + levels[gap + 1])
    a, b = ring, np.roll(ring, -1, axis=0)
    cut = (a[:, 1] < level) != (b[:, 1] < level)
    x = np.sort(a[cut, 0] + (level - a[cut, 1]) * (b[cut, 0] - a[cut, 0]) / (b[cut, 1] - a[cut, 1]))
    return np.array([[0.5 * (x[0] + x[1]), level]])
