"""Outlines of the unstable points of a grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.content import ByContent


@dataclass(frozen=True, eq=False)
class Crossings(ByContent):
    """Pairs of neighbouring grid points, one unstable and one stable, in rings with the unstable side to the left.

    On the edge of the plane, beyond which nothing is unstable, both points of a pair coincide.
    """

    inside: Floats  # (n, 2), the unstable neighbour
    outside: Floats  # (n, 2), the other
    rings: list[Ints]  # closed rings of crossings, in order


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
    from contourpy import contour_generator

    heights = np.pad(_heights(u, v, unstable, middle), 1)  # with stable points all around every outline is closed
    generator: Any = contour_generator(z=heights, name="serial", line_type="Separate")
    rings = [line[:-1] for line in generator.lines(0.5)]
    at, ends = np.concatenate([np.empty((0, 2)), *rings]), np.cumsum([0] + [len(ring) for ring in rings])
    u, v = (np.concatenate([line[:1], line, line[-1:]]) for line in (u, v))
    before, after = np.floor(at).astype(np.int64), np.ceil(at).astype(np.int64)
    first, other = (np.column_stack([u[i], v[j]]) for i, j in (before.T, after.T))
    within = heights[before[:, 1], before[:, 0]][:, None] > 0.5
    inside, outside = np.where(within, first, other), np.where(within, other, first)
    return Crossings(inside, outside, [np.arange(*part) for part in pairwise(ends)])


def _heights(u: Floats, v: Floats, unstable: Bools, middle: Callable[[Floats], Bools]) -> Floats:
    """Return heights (rows, columns), above 0.5 at unstable points, for contours at 0.5.

    In a crosswise cell, whose corners alternate, the contour joins the unstable corners where the mean of the four
    heights exceeds 0.5: corners are raised or lowered to agree with the verdict at the middle of the cell.  Adjacent
    cells may disagree about a shared corner; where they disagree about all four, the unstable corners stay apart.
    """
    heights = unstable.astype(np.float64)
    low, high = unstable[:-1], unstable[1:]
    crosswise = (low[:, 1:] != low[:, :-1]) & (low[:, 1:] == high[:, :-1]) & (low[:, :-1] == high[:, 1:])
    rows, columns = np.nonzero(crosswise)
    joined = middle(np.column_stack([0.5 * (u[columns] + u[columns + 1]), 0.5 * (v[rows] + v[rows + 1])]))
    for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
        place = rows + corner[0], columns + corner[1]
        raised, lowered = unstable[place] & joined, ~unstable[place] & ~joined
        heights[place[0][raised], place[1][raised]] = 2.0
        heights[place[0][lowered], place[1][lowered]] = -1.0
    return heights
