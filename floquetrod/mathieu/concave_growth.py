"""Where a growth rate that is concave between its zeros exceeds a level: branch and bound, on many intervals at once.

A concave function lies above its chords and, outside the interval of a chord, below its extension.  On a piece whose
ends and neighbours have been evaluated it is thus enclosed, and the piece is settled when the enclosure lies on one
side of the level; otherwise it is divided.  Levels are constant + root * sqrt(x - origin), concave too, so that line
minus level is convex and largest at an end of where the line holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from floquetrod._util.arrays import EPS, Bools, Floats, Ints
from floquetrod._util.roots import roots

Growth: TypeAlias = Callable[[Floats, Ints], Floats]
"""Values at places x, one for each, in the intervals with the numbers given."""

_POINTS = 3  # inside every interval evaluated at the start, closer together near its ends (a choice)
TOUCHING = 1e-9  # a peak that exceeds its level by less than this share of it counts as below (heuristic: rounding)
_NARROWEST = 1e-9  # share of its interval, or of its place, at which a piece is no longer divided (heuristic: rounding)


class Level(NamedTuple):
    """The level constant + root * sqrt(x - origin) of every interval."""

    constant: Floats
    root: Floats
    origin: Floats

    def __call__(self, x: Floats, which: Ints) -> Floats:
        """Return the level at ``x`` in the intervals ``which``."""
        distance = np.sqrt(np.maximum(x - self.origin[which], 0.0))
        result: Floats = self.constant[which] + self.root[which] * distance
        return result

    def steepest(self, low: Floats, which: Ints) -> Floats:
        """Return the largest slope of the level right of ``low``."""
        distance = np.sqrt(np.maximum(low - self.origin[which], 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.root[which] == 0.0, 0.0, 0.5 * self.root[which] / distance)


class Exceedances(NamedTuple):
    """Parts of the intervals ``which`` from ``first`` to ``last``, where the level is exceeded."""

    which: Ints
    first: Floats
    last: Floats


class _Brackets(NamedTuple):
    """Pieces [x1, x2] with the values there and at their neighbours x0 < x1 and x3 > x2 (NaN where there is none)."""

    which: Ints
    x: Floats  # (n, 4)
    g: Floats  # (n, 4)

    def some(self, chosen: Bools) -> _Brackets:
        return _Brackets(self.which[chosen], self.x[chosen], self.g[chosen])


def level(constant: Floats | float, root: Floats | float = 0.0, origin: Floats | float = 0.0, *, size: int) -> Level:
    """Return a level for ``size`` intervals."""
    return Level(*(np.broadcast_to(np.asarray(part, dtype=np.float64), size) for part in (constant, root, origin)))


def parts_above(growth: Growth, low: Floats, high: Floats, above: Level) -> Exceedances:
    """Return the parts of the intervals [low, high] where ``growth`` exceeds the level ``above``.

    Within each interval the growth must be concave: then none is left out but peaks that exceed the level by less than
    `TOUCHING` of it.
    """
    pieces = _start(growth, low, high)
    nothing = np.empty(0)
    exceedances: list[Exceedances] = [Exceedances(pieces.which[:0], nothing, nothing)]
    crossing: list[_Brackets] = []
    while pieces.which.size:
        pieces = _settle(pieces, above, exceedances, crossing, high - low)
        pieces = _divide(pieces, growth)
    if crossing:
        exceedances.append(_cut(growth, above, crossing))
    return joined(exceedances)


def _start(growth: Growth, low: Floats, high: Floats) -> _Brackets:
    """Return the pieces between the first points of every interval."""
    which = np.repeat(np.arange(low.size), _POINTS + 2)
    number = np.tile(np.arange(_POINTS + 2), low.size)  # of a point in its interval
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip((number - 0.5) / _POINTS, 0.0, 1.0))
    x = np.minimum(low[which] + (high - low)[which] * share, high[which])
    x = np.where(share == 1.0, high[which], x)  # exactly the end
    g = growth(x, which)
    left = np.flatnonzero((which[1:] == which[:-1]) & (x[1:] > x[:-1]))
    window = left[:, None] + np.arange(-1, 3)
    place = np.clip(window, 0, which.size - 1)
    inside = (place == window) & (which[place] == which[left][:, None])
    return _Brackets(which[left], np.where(inside, x[place], np.nan), np.where(inside, g[place], np.nan))


def _slopes(pieces: _Brackets) -> tuple[Floats, Floats, Floats]:
    """Return the slopes of the chords left of, across and right of every piece; unbounded where there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        left, chord, right = (np.diff(pieces.g) / np.diff(pieces.x)).T
    return np.where(np.isnan(left), np.inf, left), chord, np.where(np.isnan(right), -np.inf, right)


def _summit(pieces: _Brackets, left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Return where the extensions of the neighbouring chords meet within each piece, and the bound there."""
    _, x1, x2, _ = pieces.x.T
    _, g1, g2, _ = pieces.g.T
    width = x2 - x1
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = (g2 - g1 - right * width) / (left - right)
        offset = np.where(np.isneginf(right), width, np.where(np.isposinf(left), 0.0, offset))
        offset = np.clip(np.where(np.isfinite(offset), offset, 0.5 * width), 0.0, width)
        from_left = np.where(np.isposinf(left), np.inf, g1 + left * offset)
        from_right = np.where(np.isneginf(right), np.inf, g2 + right * (offset - width))
    return x1 + offset, np.maximum(np.minimum(from_left, from_right), np.maximum(g1, g2))


def _settle(
    pieces: _Brackets, above: Level, exceedances: list[Exceedances], crossing: list[_Brackets], widths: Floats
) -> _Brackets:
    """Store pieces above the level and those that cross it once; return those still open."""
    which, x1, x2 = pieces.which, pieces.x[:, 1], pieces.x[:, 2]
    f1, f2 = pieces.g[:, 1] - above(x1, which), pieces.g[:, 2] - above(x2, which)
    left, chord, right = _slopes(pieces)
    summit, bound = _summit(pieces, left, right)
    narrow = x2 - x1 <= _floor(pieces, widths)
    ceiling = above(summit, which)
    under = (f1 <= 0.0) & (f2 <= 0.0) & ((bound <= ceiling * (1.0 + TOUCHING)) | narrow)
    over = (f1 > 0.0) & (f2 > 0.0) & ((_lowest(pieces, chord, above) >= 0.0) | narrow)
    # The slope of a concave function lies between those of the chords beside it.
    steep, flat = above.steepest(x1, which), above.steepest(x2, which)
    single = ((f1 > 0.0) != (f2 > 0.0)) & ((right >= steep) | (left <= flat) | narrow)
    exceedances.append(Exceedances(which[over], x1[over], x2[over]))
    crossing.append(pieces.some(single))
    return pieces.some(~(under | over | single))


def _floor(pieces: _Brackets, widths: Floats) -> Floats:
    """Return the width below which no piece is divided any further."""
    width = widths[pieces.which]
    place = np.maximum(np.abs(pieces.x[:, 1]), np.abs(pieces.x[:, 2]))
    least = _NARROWEST * np.minimum(width, place)
    return np.maximum(least, 4.0 * EPS * np.maximum(width, place))


def _lowest(pieces: _Brackets, chord: Floats, above: Level) -> Floats:
    """Return the least value of chord minus level, which is convex, over each piece."""
    which, x1, x2, g1 = pieces.which, pieces.x[:, 1], pieces.x[:, 2], pieces.g[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        stationary = above.origin[which] + (0.5 * above.root[which] / chord) ** 2
    place = np.where(chord > 0.0, np.clip(stationary, x1, x2), x2)
    place = np.where(np.isnan(place), x1, place)
    result: Floats = np.minimum(g1 + chord * (place - x1) - above(place, which), pieces.g[:, 2] - above(x2, which))
    return result


def _divide(pieces: _Brackets, growth: Growth) -> _Brackets:
    """Return both parts of every piece, split where the bound is largest but not close to an end."""
    if not pieces.which.size:
        return pieces
    left, _, right = _slopes(pieces)
    summit, _ = _summit(pieces, left, right)
    x1, x2 = pieces.x[:, 1], pieces.x[:, 2]
    width = x2 - x1
    place = np.clip(summit, x1 + 0.25 * width, x2 - 0.25 * width)[:, None]
    value = growth(place[:, 0], pieces.which)[:, None]
    x, g = pieces.x, pieces.g
    return _Brackets(
        np.concatenate([pieces.which, pieces.which]),
        np.vstack([np.hstack([x[:, :2], place, x[:, 2:3]]), np.hstack([x[:, 1:2], place, x[:, 2:]])]),
        np.vstack([np.hstack([g[:, :2], value, g[:, 2:3]]), np.hstack([g[:, 1:2], value, g[:, 2:]])]),
    )


def _cut(growth: Growth, above: Level, crossing: list[_Brackets]) -> Exceedances:
    """Return the parts above the level of pieces that cross it once."""
    which = np.concatenate([pieces.which for pieces in crossing])
    x1, x2 = np.concatenate([pieces.x[:, 1:3] for pieces in crossing]).T
    g1, g2 = np.concatenate([pieces.g[:, 1:3] for pieces in crossing]).T
    at_low, at_high = g1 - above(x1, which), g2 - above(x2, which)

    def surplus(x: Floats, chosen: Ints) -> Floats:
        return growth(x, which[chosen]) - above(x, which[chosen])

    root = roots(surplus, x1, x2, at_low, at_high)
    return Exceedances(which, np.where(at_low > 0.0, x1, root), np.where(at_low > 0.0, root, x2))


def joined(exceedances: Sequence[Exceedances]) -> Exceedances:
    """Return the parts with those that touch made one."""
    which, first, last = (np.concatenate(values) for values in zip(*exceedances, strict=True))
    order = np.lexsort((first, which))
    which, first, last = which[order], first[order], last[order]
    begins = np.ones(which.size, dtype=np.bool_)
    begins[1:] = (which[1:] != which[:-1]) | (first[1:] > last[:-1])
    ends = np.append(begins[1:], True) if which.size else begins
    return Exceedances(which[begins], first[begins], last[ends])
