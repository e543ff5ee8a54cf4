"""Outlines of the unstable points of a grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from floquetrod.plane.family import Bools, Floats, Ints


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
    fine = _refined(unstable)
    rows, columns = np.nonzero(_crosswise(unstable))
    joined = middle(np.column_stack([0.5 * (u[columns] + u[columns + 1]), 0.5 * (v[rows] + v[rows + 1])]))
    for up, right in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
        fine[2 * rows[joined] + 3 + up, 2 * columns[joined] + 3 + right] = 1.0
    rings = _rings(fine)
    at, ends = np.concatenate([np.empty((0, 2)), *rings]), np.cumsum([0] + [len(ring) for ring in rings])
    u, v = (np.concatenate([line[:1], line, line[-1:]]) for line in (u, v))
    before, after = np.floor(at).astype(np.int64), np.ceil(at).astype(np.int64)
    first, other = (np.column_stack([u[i], v[j]]) for i, j in (before.T, after.T))
    within = np.pad(unstable, 1)[before[:, 1], before[:, 0]][:, None]
    inside, outside = np.where(within, first, other), np.where(within, other, first)
    return Crossings(inside, outside, [np.arange(*part) for part in pairwise(ends)])


def _rings(fine: Floats) -> list[Floats]:
    """Return closed rings about what is 1 on a grid twice as fine, as columns and rows of the grid itself.

    Only what lies between two points of that is kept, not what lies within its cells.
    """
    from contourpy import contour_generator

    generator: Any = contour_generator(z=fine, name="serial", line_type="Separate")
    rings = [0.5 * line[:-1] for line in generator.lines(0.5)]
    return [ring[(ring % 1.0 == 0.0).any(axis=1)] for ring in rings]


def _refined(unstable: Bools) -> Floats:
    """Return a grid twice as fine with stable points all around, 1 where all of the grid's points next to one are.

    Its cells, unlike those of the grid, do not differ crosswise, so that there is no choice of what is joined.
    """
    inner = np.pad(unstable, 1)
    fine = np.zeros([2 * size - 1 for size in inner.shape])
    fine[::2, ::2] = inner
    fine[1::2, ::2] = upright = inner[1:] & inner[:-1]
    fine[::2, 1::2] = inner[:, 1:] & inner[:, :-1]
    fine[1::2, 1::2] = upright[:, 1:] & upright[:, :-1]
    return fine


def _crosswise(unstable: Bools) -> Bools:
    """Return the cells of which two opposite corners are unstable and the others not."""
    low, high = unstable[:-1], unstable[1:]
    result: Bools = (low[:, 1:] != low[:, :-1]) & (low[:, 1:] == high[:, :-1]) & (low[:, :-1] == high[:, 1:])
    return result
