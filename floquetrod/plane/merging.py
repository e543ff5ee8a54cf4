"""Where the tongues that merge in a polygon begin: the lowest place of each, seen from one of four sides."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats

_LEAST = (
    0.01  # height of a tongue up to where it merges, as a fraction of the axis, below which it is a bend (a choice)
)
_MOST = 24  # tongues of a polygon, the highest ones (a choice)


class Foot(NamedTuple):
    """One of the tongues that merge in a polygon.

    Attributes
    ----------
    tip : tuple of float
        Where it begins.
    inside : tuple of float
        A place within it, about half-way to where it merges with another.
    """

    tip: tuple[float, float]
    inside: tuple[float, float]


def merging_tongues(ring: Floats) -> list[Foot]:
    """Return the tongues that merge in a polygon (n, 2) over the unit square; fewer than two are none.

    A tongue is a part that lies alone at its level: from below upwards, from above downwards, or from either side.
    """
    feet: list[tuple[float, Foot]] = []
    for turned in (False, True):
        for sign in (1.0, -1.0):
            points = ring[:, ::-1] if turned else ring
            parts = _parts(points * (1.0, sign))
            if len(parts) < 2:
                continue
            for part in parts:
                ends = [(x, sign * y) for x, y in (part.tip, part.middle)]
                feet.append((part.height, Foot(*((y, x) if turned else (x, y) for x, y in ends))))
    return [foot for _, foot in sorted(feet, key=lambda entry: -entry[0])[:_MOST]]


@dataclass(eq=False)
class _Part:
    """A part of a polygon below a level, not connected there with the rest."""

    tip: tuple[float, float]
    end: float = float("inf")  # level at which it first meets another
    into: _Part | None = None  # the part it has become one with
    middles: list[tuple[float, float]] = field(default_factory=list)

    @property
    def height(self) -> float:
        """Height up to where it meets another."""
        return self.end - self.tip[1]

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of it, half-way up to where it meets another."""
        level = 0.5 * (self.tip[1] + self.end)
        return min(self.middles, key=lambda place: abs(place[1] - level))

    def whole(self) -> _Part:
        """Return the part that it is one with."""
        part = self
        while part.into is not None:
            part = part.into
        return part


def _parts(ring: Floats) -> list[_Part]:
    """Return the parts of a polygon that lie alone at their lowest level and meet another above.

    A sweep over the levels of the vertices.  Between two levels the polygon consists of trapezoids; one that touches
    none below begins a part, one that touches several joins theirs, and the one that began lowest goes on.
    """
    ends = np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
    ends = np.where((ends[:, 0, 1] <= ends[:, 1, 1])[:, None, None], ends, ends[:, ::-1])
    ends = ends[ends[:, 0, 1] < ends[:, 1, 1]]
    ends = ends[np.argsort(ends[:, 0, 1], kind="stable")]
    levels = np.unique(ends[:, :, 1]).tolist()
    sides = [(*low, *high) for low, high in ends.tolist()]
    parts: list[_Part] = []
    active: list[tuple[float, ...]] = []
    below: list[tuple[float, float, _Part]] = []
    begun = 0
    for bottom, top in itertools.pairwise(levels):
        active = [side for side in active if side[3] > bottom]
        while begun < len(sides) and sides[begun][1] <= bottom:
            active.append(sides[begun])
            begun += 1
        level = 0.5 * (bottom + top)
        crossed: list[tuple[float, ...]] = []
        for place in sorted((_at(side, level), _at(side, bottom), _at(side, top)) for side in active):
            if crossed and crossed[-1] == place:
                crossed.pop()  # a seam, passed both ways
            else:
                crossed.append(place)
        above: list[tuple[float, float, _Part]] = []
        for left, right in zip(crossed[::2], crossed[1::2], strict=True):
            touched = [part for low, high, part in below if low <= right[1] and high >= left[1]]
            part = _joined(touched, bottom) if touched else _Part((0.5 * (left[1] + right[1]), bottom))
            parts += [] if touched else [part]
            part.middles.append((0.5 * (left[0] + right[0]), level))
            above.append((left[2], right[2], part))
        below = [(low, high, part.whole()) for low, high, part in above]
    return [part for part in parts if _LEAST <= part.height < float("inf")]


def _at(side: tuple[float, ...], level: float) -> float:
    """Return where a side is at a level."""
    x0, y0, x1, y1 = side
    return x1 if level == y1 else x0 + (x1 - x0) * ((level - y0) / (y1 - y0))


def _joined(touched: list[_Part], level: float) -> _Part:
    """Return the part that several become at a level: the one that began lowest; bends end none."""
    whole = sorted({id(part.whole()): part.whole() for part in touched}.values(), key=lambda part: part.tip[1])
    for part in whole[1:]:
        part.into, part.end = whole[0], min(part.end, level)
        if part.height >= _LEAST:
            whole[0].end = min(whole[0].end, level)
    return whole[0]
