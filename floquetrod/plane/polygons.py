"""Polygons: areas, points inside, and holes joined to the polygons about them."""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints


def tidied(number: Ints, vertices: Floats) -> tuple[Ints, Floats]:
    """Return polygons without spare vertices: of those that coincide one is left, of those on one straight line two.

    Only level and upright lines count, as the edges of a plane are.

    Parameters
    ----------
    number : ndarray (n,)
        Which polygon each vertex belongs to, in increasing order.
    vertices : ndarray (n, 2)
        In the order of each polygon.
    """
    for straight in (False, True):
        size = np.bincount(number)
        stop, place = np.cumsum(size), np.arange(number.size)
        begins = np.diff(number, prepend=-1) > 0
        ends = np.diff(number, append=size.size) > 0
        before = np.where(begins, stop[number] - 1, place - 1)
        same = vertices == vertices[before]
        if straight:
            after = np.where(ends, (stop - size)[number], place + 1)
            kept = ~(same & (vertices == vertices[after])).any(axis=1)
        else:
            kept = ~same.all(axis=1)
        number, vertices = number[kept], vertices[kept]
    return number, vertices


def area(ring: Floats) -> float:
    """Return the area within a ring (n, 2), positive where it runs counter-clockwise."""
    x, y = (ring - ring[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def contains(ring: Floats, points: Floats) -> Bools:
    """Return which points lie within a ring, by the number of sides to their right."""
    inside = np.zeros(len(points), dtype=np.bool_)
    px, py = points.T
    for (x0, y0), (x1, y1) in zip(ring.tolist(), np.roll(ring, -1, axis=0).tolist(), strict=True):
        if y0 != y1:
            inside ^= ((py < y0) != (py < y1)) & (px < x0 + (py - y0) * (x1 - x0) / (y1 - y0))
    return inside


def with_holes_joined(rings: list[Floats]) -> list[Floats]:
    """Return the counter-clockwise rings, each with the clockwise ones within it joined by seams of no width."""
    outer = sorted((ring for ring in rings if area(ring) > 0.0), key=area)
    holes: list[list[Floats]] = [[] for _ in outer]
    for ring in rings:
        if area(ring) < 0.0:
            around = (i for i, out in enumerate(outer) if contains(out, ring).mean() > 0.5)
            which = next(around, None)
            if which is not None:
                holes[which].append(ring)
    return [_joined(ring, inner) for ring, inner in zip(outer, holes, strict=True)]


def _joined(ring: Floats, holes: list[Floats]) -> Floats:
    """Return one ring of an outer one and its holes: from the rightmost hole on, each joined to its nearest vertex."""
    for hole in sorted(holes, key=lambda hole: -float(hole[:, 0].max())):
        start = int(hole[:, 0].argmax())
        first = _visible(ring, hole[start], [hole])
        ring = np.concatenate([ring[: first + 1], np.roll(hole, -start, axis=0), hole[start : start + 1], ring[first:]])
    return ring


def _visible(ring: Floats, point: Floats, others: list[Floats]) -> int:
    """Return the index of a ring's vertex nearest to a point whose straight line to it crosses no side."""
    order = np.argsort(np.hypot(*(ring - point).T), kind="stable")
    for vertex in order.tolist():
        if not any(_crosses(line, point, ring[vertex]) for line in (ring, *others)):
            return int(vertex)
    return int(order[0])


def _crosses(ring: Floats, start: Floats, end: Floats) -> bool:
    """Return whether a line crosses a side of a ring elsewhere than at its ends."""
    a, b = ring, np.roll(ring, -1, axis=0)

    def turn(p: Floats, q: Floats, r: Floats) -> Floats:
        left, right = q - p, r - p
        return np.asarray(left[..., 0] * right[..., 1] - left[..., 1] * right[..., 0])

    return bool(np.any((turn(a, b, start) * turn(a, b, end) < 0.0) & (turn(start, end, a) * turn(start, end, b) < 0.0)))
