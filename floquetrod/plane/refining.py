"""Outlines brought onto the boundary of a region: first by what a grid knows, then by asking between its points."""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod.plane.contours import Crossings
from floquetrod.plane.places import Plane, between
from floquetrod.plane.region_rings import RegionRings
from floquetrod.plane.tips import THINNEST, follow

_FAR_APART = 8  # every how many crossings of a grid a vertex is put first (a choice)
_AT_ONE_THIRD = np.array([0.3, 0.65])  # of a side, where it is compared with the boundary: no two symmetric
_MOST_ROUNDS = 100  # of refining (a choice: every round halves the longest sides)


def outlined(plane: Plane, crossings: Crossings) -> RegionRings:
    """Return the outlines of a grid's unstable points, vertices on the boundary, that agree with all of its verdicts.

    Vertices are put only where the line between two others would pass a point of the grid on its wrong side.
    """
    place = 0.5 * (crossings.inside + crossings.outside)
    on_edge = (crossings.inside == crossings.outside).all(axis=1)
    chosen = [_first_choice(ring, place, on_edge) for ring in crossings.rings]
    new = [ring[keep & ~on_edge[ring]] for ring, keep in zip(crossings.rings, chosen, strict=True)]
    outline = RegionRings()
    try:
        while sum(part.size for part in new):
            some = np.concatenate(new)
            place[some] = plane.boundary(crossings.inside[some], crossings.outside[some])
            new = [
                _violated(crossings, ring, keep, place, on_edge)
                for ring, keep in zip(crossings.rings, chosen, strict=True)
            ]
    finally:
        for ring, keep in zip(crossings.rings, chosen, strict=True):
            outline.add_ring(place[ring[keep]])
    return outline


def _first_choice(ring: Ints, place: Floats, on_edge: Bools) -> Bools:
    """Return which crossings of a ring become vertices at first: a few, corners, and where the edge is reached."""
    keep: Bools = np.arange(ring.size) % (_FAR_APART if ring.size > _FAR_APART * 3 // 2 else 1) == 0
    edge = on_edge[ring]
    before, later = np.roll(edge, 1), np.roll(edge, -1)
    here = place[ring]
    straight = ((here == np.roll(here, 1, axis=0)) & (here == np.roll(here, -1, axis=0))).any(axis=1) & before & later
    keep = keep | before | later
    corner = ((here == 0.0) | (here == 1.0)).all(axis=1)
    keep[edge] = ~straight[edge] | corner[edge]
    return keep


def _violated(breaches: Crossings, ring: Ints, keep: Bools, place: Floats, on_edge: Bools) -> Ints:
    """Choose further crossings, the middle one of each side that passes a point on its wrong side; return them."""
    at = np.flatnonzero(keep)
    side = np.searchsorted(at, np.arange(ring.size), side="right") - 1  # -1 is the last, round the end of the list
    others = np.flatnonzero(~keep & ~on_edge[ring])
    if not others.size:
        return np.empty(0, dtype=np.int64)
    a = place[ring[at[side[others]]]]
    b = place[ring[at[(side[others] + 1) % at.size]]]

    def left(points: Floats) -> Floats:
        return (b - a)[:, 0] * (points - a)[:, 1] - (b - a)[:, 1] * (points - a)[:, 0]

    wrong = (left(breaches.inside[ring[others]]) < 0.0) | (left(breaches.outside[ring[others]]) > 0.0)
    sides = np.unique(side[others[wrong]])
    new = []
    for s in sides.tolist():
        mine = others[side[others] == s]
        new.append(mine[mine.size // 2])
    keep[new] = True
    return ring[np.array(new, dtype=np.int64)]


def refined(plane: Plane, outline: RegionRings, accuracy: float, report: Progress) -> bool:
    """Divide sides until they lie within an accuracy of the boundary, and follow tongues to their tips.

    Returns whether all is done as asked; not where there was no end after many rounds.
    """
    wide_ends: dict[int, bool] = {}
    for _ in range(_MOST_ROUNDS):
        some = np.flatnonzero(~outline.done)
        start, end = outline.sides(some)
        outline.done[some[outline.on_edge(some) | (np.hypot(*(end - start).T) < THINNEST * plane.vertex)]] = True
        some = np.flatnonzero(~outline.done)
        report(outline.size - some.size, outline.size)
        if not some.size:
            sides = np.array([side for side in wide_ends if outline.done[side]], dtype=np.int64)
            start, end = outline.sides(sides)
            sides = sides[np.hypot(*(end - start).T) >= THINNEST * plane.vertex]  # others have met since
            if not sides.size:
                return True
            colour = np.array([wide_ends[side] for side in sides.tolist()])
            wide_ends = {}
            if follow(plane, outline, sides, colour, 0.5 * accuracy):
                return False
            continue
        departs = ~_agrees(plane, outline, some, 0.5 * accuracy)
        outline.done[some[~departs]] = True
        if departs.any():
            _move(plane, outline, some[departs], accuracy, wide_ends)
    return False


def _normals(outline: RegionRings, some: Ints) -> tuple[Floats, Floats]:
    """Return unit normals of sides, away from the unstable region, and the sides' lengths."""
    start, end = outline.sides(some)
    length = np.hypot(*(end - start).T)
    across = (end - start) / length[:, None]
    return np.column_stack([across[:, 1], -across[:, 0]]), length


def _agrees(plane: Plane, outline: RegionRings, some: Ints, tolerance: float) -> Bools:
    """Return for each side whether points on either side of it are stable outside and unstable inside.

    The points' distance from the side is at most ``tolerance``, its length, half the width of the region or gap in
    which they lie, and the whole width across the side: tongues as narrow as that are noticed where they begin.
    """
    normal, length = _normals(outline, some)
    start, end = outline.sides(some)
    result = np.ones(some.size, dtype=np.bool_)
    for share in _AT_ONE_THIRD:
        left = np.flatnonzero(result)
        base, out = start[left] + share * (end - start)[left], normal[left]
        gap, width = (outline.hits(base, sign * out, some[left])[0] for sign in (1.0, -1.0))
        reach = np.minimum(tolerance, length[left])
        outward, inward = (
            np.minimum(reach, np.minimum(0.5 * gap, width)),
            np.minimum(reach, np.minimum(0.5 * width, gap)),
        )
        places = np.concatenate([base + outward[:, None] * out, base - inward[:, None] * out])
        beyond, within = np.split(plane.unstable(places)[0], 2)
        result[left] = within & ~beyond
    return result


def _move(plane: Plane, outline: RegionRings, some: Ints, accuracy: float, wide_ends: dict[int, bool]) -> None:
    """Put a vertex on the boundary next to the middle of sides; join sides that meet; note wide ends."""
    normal, length = _normals(outline, some)
    start, end = outline.sides(some)
    middle = 0.5 * (start + end)
    colour, _ = plane.unstable(middle)
    along = np.where(colour[:, None], normal, -normal)
    first = np.minimum(0.25 * accuracy, length / 16.0)
    reached, before, now = plane.march(middle, along, first, length, colour)
    place = np.full((some.size, 2), np.nan)
    ends = between(middle, along, before, now, colour)
    place[reached] = plane.boundary(ends[0][reached], ends[1][reached])
    far = np.where(reached, np.hypot(*(place - middle).T), length)
    for k, side in enumerate(some.tolist()):
        if outline.done[side] or (outline.sides(np.array([side]))[1] != end[k]).any():
            continue  # changed by another one of this round
        distance, hit = outline.hits(middle[k : k + 1], along[k : k + 1], np.array([side]))
        if distance[0] < far[k]:
            outline.join(side, int(hit[0]))
        elif reached[k]:
            outline.divide(side, place[k])
        else:
            outline.done[side] = True
            wide_ends[side] = bool(colour[k])
