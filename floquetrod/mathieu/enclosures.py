"""Growth along the amplitude below the static limit, where it is not concave: enclosed from its value at one amplitude.

Characteristic values of u'' = (b + alpha sin tau) u move along b by no more than the amplitude changes, |sin| <= 1.  In
a tongue X = sinh(pi u)^2, u the growth per unit tau, is a constant times the product of the distances d_k from b to all
characteristic values of one parity.  A change of the amplitude by no more than h multiplies X by no more than
prod(1 + h / d_k) <= exp(h S) and no less than prod(1 - h / d_k) >= exp(-2 ln 2 h S), S = sum 1 / d_k, where every d_k
is at least 2 h.
S is bounded by counting the values within 2 h, 4 h, 8 h, ...; those far above lie above k^2 - 2 q.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.roots import roots
from floquetrod.mathieu.concave_growth import Exceedances, joined

Evaluated: TypeAlias = Callable[[Floats, Floats], Floats]
Counted: TypeAlias = Callable[[Floats, Floats], Ints]

_ROUNDING = 1e-9  # relative, by which radii are enlarged


def divided(b: Floats, low: Floats, high: Floats, least: Floats, counts: Counted) -> tuple[Ints, Floats]:
    """Return question and place of points between which counts are the same, or which are no further apart than least.

    ``counts(a, q)`` returns how many characteristic values lie below a = -4 b.  Points are in order in each question,
    its ends included.
    """
    every = np.arange(b.size)
    which, x1, x2 = every, low, high
    places, owners = [low, high], [every, every]
    while which.size:
        middle, h = 0.5 * (x1 + x2), 0.5 * (x2 - x1)
        open_ = (x2 - x1 > least[which]) & (x1 < middle) & (middle < x2)
        open_ &= _within(b[which], middle, h, counts) > 0
        which, x1, middle, x2 = which[open_], x1[open_], middle[open_], x2[open_]
        places.append(middle)
        owners.append(which)
        which, x1, x2 = np.tile(which, 2), np.concatenate([x1, middle]), np.concatenate([middle, x2])
    place, owner = np.concatenate(places), np.concatenate(owners)
    order = np.lexsort((place, owner))
    return owner[order], place[order]


def parts_above(
    b: Floats, low: Floats, high: Floats, above: Floats, least: Floats, growth: Evaluated, counts: Counted
) -> Exceedances:
    """Return the parts of [low, high], each within a tongue, in which ``growth(alpha, b)`` exceeds ``above`` > 0.

    What is narrower than ``least`` may be missed.
    """
    which, x1, x2 = np.arange(b.size), low, high
    target = _log_excess(above)
    exceedances = [Exceedances(which[:0], low[:0], low[:0])]
    while which.size:
        middle, h = 0.5 * (x1 + x2), 0.5 * (x2 - x1)
        bottom, top = enclosed(b[which], middle, h, _log_excess(growth(middle, b[which])), counts)
        over, under = bottom > target[which], top <= target[which]
        exceedances.append(Exceedances(which[over], x1[over], x2[over]))
        left = ~(over | under)
        fine = left & ((x2 - x1 <= least[which]) | (middle <= x1) | (middle >= x2))
        exceedances.append(_cut(b, above, growth, Exceedances(which[fine], x1[fine], x2[fine])))
        left &= ~fine
        which, x1, middle, x2 = which[left], x1[left], middle[left], x2[left]
        which, x1, x2 = np.tile(which, 2), np.concatenate([x1, middle]), np.concatenate([middle, x2])
    return joined(exceedances)


def _cut(b: Floats, above: Floats, growth: Evaluated, parts: Exceedances) -> Exceedances:
    """Return what lies above of narrow parts that cross the level once, or not at all."""

    def surplus(x: Floats, i: Ints) -> Floats:
        return growth(x, b[parts.which[i]]) - above[parts.which[i]]

    every = np.arange(parts.which.size)
    at_low, at_high = surplus(parts.first, every), surplus(parts.last, every)
    i = np.flatnonzero((at_low > 0.0) != (at_high > 0.0))
    root = roots(lambda x, k: surplus(x, i[k]), parts.first[i], parts.last[i], at_low[i], at_high[i])
    first, last = parts.first.copy(), parts.last.copy()
    first[i], last[i] = np.where(at_low[i] > 0.0, first[i], root), np.where(at_low[i] > 0.0, root, last[i])
    kept = (at_low > 0.0) | (at_high > 0.0)
    return Exceedances(parts.which[kept], first[kept], last[kept])


def _within(b: Floats, alpha: Floats, radius: Floats, counts: Counted) -> Ints:
    """Return how many characteristic values lie within a radius of b."""
    radius, q = 4.0 * radius * (1.0 + _ROUNDING), 2.0 * alpha
    ends = counts(np.concatenate([radius - 4.0 * b, -radius - 4.0 * b]), np.concatenate([q, q]))
    return ends[: b.size] - ends[b.size :]


def enclosed(b: Floats, alpha: Floats, h: Floats, excess: Floats, counts: Counted) -> tuple[Floats, Floats]:
    """Return between what log X lies within h of alpha, where it is ``excess``; without bounds near a boundary."""
    single = h == 0.0  # ends of a tongue that is thinner than rounding
    bottom, top = np.where(single, excess, -np.inf), np.where(single, excess, np.inf)
    clear = np.flatnonzero(~single & (_within(b, alpha, 2.0 * h, counts) == 0))
    total = _sum_of_inverses(b[clear], alpha[clear], 2.0 * h[clear], counts)
    bottom[clear] = excess[clear] - 2.0 * math.log(2.0) * h[clear] * total
    top[clear] = excess[clear] + h[clear] * total
    return bottom, top


def _sum_of_inverses(b: Floats, alpha: Floats, radius: Floats, counts: Counted) -> Floats:
    """Return a bound on the sum of 1 / d_k over all characteristic values, where every distance d_k > ``radius``."""
    q, extent = 2.0 * alpha, np.maximum(-4.0 * b, 0.0) + 4.0 * alpha + 8.0
    # All within 8 (a + 2 q + 8) / 4 of b are counted; of the others n^2 < y - 2 q, and d > 2 y / 3.
    shells = np.maximum(1, np.ceil(np.log2(0.5 * extent / radius))).astype(np.int64)
    index = np.repeat(np.arange(b.size), shells)
    number = np.arange(index.size) - np.repeat(np.cumsum(shells) - shells, shells)
    inner = radius[index] * 2.0**number
    within = _within(b[index], alpha[index], 2.0 * inner, counts)
    before = np.where(number == 0, 0, np.roll(within, 1))
    near = np.bincount(index, (within - before) / inner, minlength=b.size)
    far = 4.0 * (radius * 2.0**shells) - 4.0 * b + 2.0 * q  # y of those beyond, with a + 2 q at most half the radius
    return np.asarray(near + 4.0 * 1.5 * (4.0 / np.sqrt(far) + 1.0 / far))


def _log_excess(growth: Floats) -> Floats:
    """Return log sinh(pi u)^2."""
    x = math.pi * growth
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 * (x + np.log(-np.expm1(-2.0 * x)) - math.log(2.0)))
