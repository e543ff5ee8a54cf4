"""Outlines of the unstable points of a grid: marching squares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from floquetrod.plane.judging import Bools, Floats, Ints


@dataclass(frozen=True)
class Crossings:
    """Pairs of neighbours on a grid of which one is unstable, in rings with the unstable side to the left.

    Attributes
    ----------
    inside, outside : ndarray (n, 2)
        The unstable neighbour and the other; the same place on the edge of the plane, beyond which nothing is unstable.
    rings : list of ndarray of int
        Closed rings of crossings, in order.
    """

    inside: Floats
    outside: Floats
    rings: list[Ints]


def crossings(u: Floats, v: Floats, unstable: Bools, middle: Callable[[Floats], Bools]) -> Crossings:
    """Return the outlines of unstable points of a grid.

    Parameters
    ----------
    u : ndarray
        Columns.
    v : ndarray
        Rows.
    unstable : ndarray (len(v), len(u)) of bool
    middle : callable ((n, 2)) -> (n,)
        Says whether places are unstable; asked about the middles of cells whose corners differ crosswise.
    """
    inner = np.pad(unstable, 1)
    u, v = (np.concatenate([line[:1], line, line[-1:]]) for line in (u, v))
    columns = u.size
    # corners of each cell, counter-clockwise from the lower left one
    corners = [inner[:-1, :-1], inner[:-1, 1:], inner[1:, 1:], inner[1:, :-1]]
    rows, cols = np.nonzero((corners[0] != corners[1]) | (corners[1] != corners[2]) | (corners[2] != corners[3]))
    state = np.array([corner[rows, cols] for corner in corners])
    point = rows * columns + cols
    # each edge is known by its lower or left point, upright ones after the level ones
    upright = inner.size
    edges = np.array([point, upright + point + 1, point + columns, upright + point])
    leaves, enters = state & ~np.roll(state, -1, axis=0), ~state & np.roll(state, -1, axis=0)
    crosswise = leaves.sum(axis=0) == 2
    following = np.full(2 * inner.size, -1)
    one = ~crosswise
    following[edges.T[one][leaves.T[one]]] = edges.T[one][enters.T[one]]
    if crosswise.any():
        r, c = rows[crosswise], cols[crosswise]
        joined = middle(np.column_stack([0.5 * (u[c] + u[c + 1]), 0.5 * (v[r] + v[r + 1])]))
        for cell, together in zip(np.flatnonzero(crosswise).tolist(), joined.tolist(), strict=True):
            for side in np.flatnonzero(leaves[:, cell]).tolist():
                following[edges[side, cell]] = edges[(side + (1 if together else -1)) % 4, cell]
    numbers = np.flatnonzero(following >= 0)
    first = numbers % inner.size
    other = first + np.where(numbers < upright, 1, columns)
    within = inner.ravel()[first]
    places = np.array([np.column_stack([u[p % columns], v[p // columns]]) for p in (first, other)])
    inside = np.where(within[:, None], places[0], places[1])
    outside = np.where(within[:, None], places[1], places[0])
    return Crossings(inside, outside, _rings(np.searchsorted(numbers, following[numbers])))


def _rings(following: Ints) -> list[Ints]:
    """Return the cycles of a permutation."""
    after, seen, rings = following.tolist(), [False] * following.size, []
    for start in range(following.size):
        ring, at = [], start
        while not seen[at]:
            seen[at] = True
            ring.append(at)
            at = after[at]
        if ring:
            rings.append(np.array(ring))
    return rings
