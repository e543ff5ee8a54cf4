"""Bands of any family whose places can be judged: their boundaries traced from verdicts alone."""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod.plane.bands import Band, MergedTongue
from floquetrod.plane.contours import crossings
from floquetrod.plane.family import Family, FoundBands, Names
from floquetrod.plane.merging import merging_tongues
from floquetrod.plane.places import OutOfBudget, Plane
from floquetrod.plane.plane_axes import Axis
from floquetrod.plane.polygons import contains, with_holes_joined
from floquetrod.plane.refining import outlined, refined
from floquetrod.plane.region_rings import RegionRings

_FEWEST, _EACH = 30_000, 30
"""Places judged at most: ``_EACH`` for each point of the grid, at least the first number (a choice)."""

_STARTS = 64  # points of a band at which growth is examined first (a choice)
_CLIMBS = 40  # rounds of looking for larger growth nearby, at most (a choice)
_SMALL = 1e-3  # step of that at which it ends, as a fraction of the grid's (a choice)


def traced(
    family: Family, x: Axis, y: Axis, unstable: Bools, accuracy: float, progress: Progress | None = None
) -> FoundBands:
    """Return the bands about the unstable points of a grid.

    Parameters
    ----------
    family : Family
    x, y : Axis
        Columns and rows of the grid.
    unstable : ndarray (ny, nx) of bool
        What the family says there; an undecided place bounds a band like a stable one.
    accuracy : float
        As in `floquetrod.plane.Chart.find_bands`; it is coarser where that would need too many places.
    progress : callable, optional

    Notes
    -----
    Marching squares over the grid give the regions; sides are divided, on the boundary itself, until they lie within
    the accuracy; where a region ends with a wide side, its tongue is followed to its tip, and joined to what it meets.
    Regions, and gaps in them, that no point of the grid shows are missed.
    """
    plane = Plane(family, x, y, max(_FEWEST, _EACH * unstable.size))
    u, v = _grid(x, y)
    outline = RegionRings()
    try:
        outline = outlined(plane, crossings(u, v, unstable, lambda places: plane.unstable(places)[0]))
        whole = refined(plane, outline, accuracy, progress or (lambda *_: None))
    except OutOfBudget:
        whole = False
    if not whole:
        accuracy = max(accuracy, float(np.diff(u).max()), float(np.diff(v).max()))
    rows, columns = np.nonzero(unstable)
    points = np.column_stack([u[columns], v[rows]])
    least = _SMALL * np.array([np.diff(line).max() for line in (u, v)])
    bands = tuple(_band(plane, ring, points, least) for ring in with_holes_joined(outline.rings()))
    return FoundBands(bands, 0, accuracy, (float(np.diff(x.values).max()), float(np.diff(y.values).max())))


def _grid(x: Axis, y: Axis) -> tuple[Floats, Floats]:
    """Return columns and rows as shares of the axes."""
    u, v = ((axis.values - axis.values[0]) / (axis.values[-1] - axis.values[0]) for axis in (x, y))
    return u, v


def _band(plane: Plane, ring: Floats, unstable: Floats, least: Floats) -> Band:
    """Return the band within a ring, of a grid whose unstable points are known."""
    place, growth = _fastest(plane, ring, unstable, least)
    vertices, at = plane.places(ring), plane.places(place[None])[0]
    where = float(at[0]), float(at[1])
    mode, partner, tongue = names = plane.family.name(*where)
    merged = _merged(plane, ring, names)
    return Band(vertices[:, 0], vertices[:, 1], mode, tongue, growth, where, partner, merged)


def _merged(plane: Plane, ring: Floats, fastest: Names) -> tuple[MergedTongue, ...]:
    """Return the named tongues that merge in a ring, each name once; none where all are what grows fastest in it."""
    feet = merging_tongues(ring)
    if len(feet) < 2:
        return ()
    tips, inside = (plane.places(np.array(places)).tolist() for places in zip(*feet, strict=True))
    named: dict[Names, MergedTongue] = {}
    for (x, y), place in zip(tips, inside, strict=True):
        names = plane.family.name(*place)
        if names != (None, None, None):
            named.setdefault(names, MergedTongue(*names, (x, y)))
    return tuple(named.values()) if named.keys() - {fastest} else ()


def _rates(plane: Plane, shares: Floats) -> Floats:
    """Return growth rates at places."""
    return np.broadcast_to(plane.family.growth(*plane.places(shares).T), len(shares))


def _fastest(plane: Plane, ring: Floats, unstable: Floats, least: Floats) -> tuple[Floats, float]:
    """Return where in a ring growth is largest, and how large: the best of some points, then uphill from there."""
    low, high = ring.min(axis=0), ring.max(axis=0)
    points = unstable[((unstable >= low) & (unstable <= high)).all(axis=1)]
    points = points[_inside(ring, points)]
    if not len(points):
        points = _within(ring)
    points = points[:: -(-len(points) // _STARTS)]
    rates = _rates(plane, points)
    if not np.isfinite(rates).any():
        free = np.hypot(*(points[:, None] - ring[None]).T).min(axis=0)
        return points[int(free.argmax())], float("nan")
    best = int(np.nanargmax(rates))
    place, growth = points[best], float(rates[best])
    step = (high - low) / 8.0
    star = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j])
    for _ in range(_CLIMBS):
        if (step < least).all():
            break
        near = np.clip(place + star * step, 0.0, 1.0)
        near = near[_inside(ring, near)]
        rates = _rates(plane, near) if len(near) else np.empty(0)
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
