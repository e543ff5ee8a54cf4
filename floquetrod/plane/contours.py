"""Outlines of the unstable points of a grid."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

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


def crossings(u: Floats, v: Floats, unstable: Bools) -> Crossings:
    """Return the outlines of unstable points of a grid with columns ``u`` and rows ``v``, by marching squares.

    Unstable points that only a diagonal connects have outlines of their own.
    """
    from contourpy import contour_generator

    inner = np.pad(unstable, 1)  # so that every outline is closed
    lines = contour_generator(z=inner.astype(np.float64), name="serial", line_type="Separate").lines(0.5)
    middles = np.concatenate([np.empty((0, 2)), *(line[:-1] for line in lines)])  # column and row, one of them halfway
    ends = np.cumsum([0] + [len(line) - 1 for line in lines])
    u, v = (np.concatenate([line[:1], line, line[-1:]]) for line in (u, v))
    (before, after), within = (np.floor(middles).astype(int), np.ceil(middles).astype(int)), inner.T
    first, other = (np.column_stack([u[i], v[j]]) for i, j in (before.T, after.T))
    unstable_first = within[tuple(before.T)][:, None]
    inside, outside = np.where(unstable_first, first, other), np.where(unstable_first, other, first)
    return Crossings(inside, outside, [np.arange(*part) for part in pairwise(ends)])
