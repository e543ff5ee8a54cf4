"""Where Mathieu's equation grows faster than a level, along its mean, its frequency and its amplitude.

Damping is removed from the equations: u'' = (b + alpha sin tau) u with b = beta + c^2, whose growth rate is compared
with c and a tolerance.  Every function takes arrays with an entry for each pair of equation and range, and returns the
unstable intervals for all pairs.  The page `theory/ranges` derives which searches are complete.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.compilation import over_chunks
from floquetrod._util.roots import bisected
from floquetrod.floquet.kernels import mathieu_discriminant
from floquetrod.floquet.mathieu_chains import mathieu_counts
from floquetrod.mathieu import enclosures
from floquetrod.mathieu.concave_growth import Exceedances, level, parts_above
from floquetrod.mathieu.kernels import characteristic_bisection

_SPACING = 1e-3  # of points along the amplitude where nothing is proved, as a fraction of the range (a choice)
_SHARE = 2.0**-8  # of a tongue, where it is narrower than that many points (a choice)
_INTERPRETED_ROWS = 4000.0  # of Hill's matrices, left to the interpreter: about a millisecond (heuristic)
BISECTION = 50.0  # counts that an end of a tongue takes
_COMPILE_AFTER = 300  # times as many before anything is compiled: what compiling takes at the least (heuristic)


class Tongues(NamedTuple):
    """Parts of tongues ``order`` in the questions ``which``, from ``first`` to ``last``.

    ``left_out`` is the number of tongues that meet the ranges and nowhere exceed the level; ``resolution`` the width,
    in each question, up to which parts may have been missed: zero where the search is complete.
    """

    which: Ints
    order: Ints
    first: Floats
    last: Floats
    left_out: int
    resolution: Floats


def along_mean(alpha: Floats, above: Floats, low: Floats, high: Floats) -> Tongues:
    """Return where ``low`` < b < ``high`` grows faster than ``above`` >= 0 per unit tau, each with its own alpha.

    The tongues that meet a range are known by counting.  Inside each the growth is concave in b.
    """
    q = 2.0 * np.abs(alpha)
    free = q == 0.0
    start = np.where(free, high, low)
    bound = np.flatnonzero((above > 0.0) & ~free)
    start[bound] = where_bounded(
        lambda b, i: growth_bounds(-4.0 * b, q[bound[i]]) <= above[bound[i]],
        low[bound],
        np.clip(-0.5 * q[bound], low[bound], high[bound]),
    )
    begin, end, whole = (counts(-4.0 * b, q) // 2 for b in (start, high, low))
    index, order = numbers_between(end, begin)
    index, order = _only(~free[index], index, order)
    a, b = (_characteristic(order, q[index], odd) for odd in (False, True))
    bottom = np.clip(-0.25 * np.maximum(a, b), low[index], high[index])
    top = np.clip(np.where(order == 0, np.inf, -0.25 * np.minimum(a, b)), low[index], high[index])
    parts = _in_tongues(
        lambda x, i: _growth(alpha[index[i]], x), index, bottom, top, above[index], np.zeros(index.size)
    )
    edge = np.maximum(above**2, low)  # without forcing only b > 0 grows, at sqrt(b)
    buckled = np.flatnonzero(free & (edge < high))
    resonant = int((whole - end)[~free].sum()) + int((end == 0)[~free].sum())
    collected = _collect(parts, index, order, buckled, edge, high)
    return Tongues(*collected, max(0, resonant - parts.which.size), np.zeros(q.size))


def along_frequency(alpha: Floats, b: Floats, rate: Floats, low: Floats, high: Floats) -> Tongues:
    """Return where ``low`` < omega < ``high`` the growth per second exceeds ``rate``; alpha and b at omega = 1.

    Both are proportional to x = 1 / omega^2, so that Hill's matrix is K - x V with K = diag(k^2) and V fixed.  Where an
    eigenvalue passes zero, K v = x V v, its slope is -v.V v = -v.K v / x <= 0: eigenvalues pass zero downwards only,
    the count of negative ones never falls as x grows, and bisection on it finds every passage.  In between the growth
    per unit tau is concave in x, and it is compared with rate sqrt(x).
    """
    q, a = 2.0 * np.abs(alpha), -4.0 * b
    free = q == 0.0

    def count(omega: Floats, i: Ints) -> Ints:
        x = omega**-2.0
        return counts(a[i] * x, q[i] * x)

    start = np.where(free, high, low)
    bound = np.flatnonzero((rate > 0.0) & ~free & (a > 2.0 * q))
    start[bound] = where_bounded(
        lambda omega, i: growth_bounds(a[bound[i]] / omega**2, q[bound[i]] / omega**2) * omega <= rate[bound[i]],
        low[bound],
        high[bound],
    )
    every = np.arange(q.size)
    begin, end, whole = count(start, every), count(high, every), count(low, every)
    index, target = numbers_between(end, begin)  # the count is `target` just above the frequency sought, or more below
    climbs = target < begin[index]
    place = start[index].copy()
    sought = np.flatnonzero(climbs)
    place[sought] = _passages(count, index[sought], target[sought], start[index[sought]], high[index[sought]])
    upper = np.append(high[:1], place[:-1]) if place.size else place
    upper = np.where(target == end[index], high[index], upper)
    keep = (target % 2 == 0) & (upper > place) & ~free[index]
    index, order, bottom, top = _only(keep, index, target // 2, place, upper)
    parts = _in_tongues(
        lambda x, i: _growth(alpha[index[i]] * x, b[index[i]] * x),
        index,
        top**-2.0,
        bottom**-2.0,
        np.zeros(index.size),
        rate[index],
    )
    exact = rate[index[parts.which]] == 0.0
    first, last = (np.maximum(x, 1e-300) ** -0.5 for x in (parts.last, parts.first))
    # Where a part ends with its tongue its end is that of the tongue, not twice converted.
    at_bottom = exact | (parts.last == (bottom**-2.0)[parts.which])
    at_top = exact | (parts.first == (top**-2.0)[parts.which])
    first, last = np.where(at_bottom, bottom[parts.which], first), np.where(at_top, top[parts.which], last)
    buckled = np.flatnonzero(free & (b > 0.0) & (b > rate**2))
    met = (whole + 2) // 2 - (end + 1) // 2  # even counts from end to whole
    left_out = max(0, int(met[~free].sum()) - parts.which.size)
    collected = _collect(Exceedances(parts.which, first, last), index, order, buckled, low, high)
    return Tongues(*collected, left_out, np.zeros(q.size))


def along_amplitude(b: Floats, above: Floats, low: Floats, high: Floats) -> Tongues:
    """Return where ``low`` < alpha < ``high`` grows faster than ``above`` per unit tau, each with its own b.

    For b >= 0 the search is complete: the count of Hill's negative eigenvalues never falls as alpha grows, and between
    its jumps the growth is concave in alpha.  For b < 0 neither holds: counts and growth are
    enclosed from single places, see `enclosures`, or evaluated at places no further apart than a thousandth of the
    range, which is then the ``resolution``.
    """
    start = low.copy()
    bound = np.flatnonzero((above > 0.0) & (b < 0.0))
    a = -4.0 * b
    start[bound] = where_bounded(
        lambda alpha, i: growth_bounds(a[bound[i]], 2.0 * alpha) <= above[bound[i]], low[bound], high[bound]
    )
    index, count, bottom, top = _amplitude_pieces(b, start, high)
    left_out = int((np.abs(counts(a, 2.0 * start) - counts(a, 2.0 * low)) // 2).sum())
    index, order, bottom, top = _only(count % 2 == 0, index, count // 2, bottom, top)
    proved = np.flatnonzero((b[index] >= 0.0) | (above[index] == 0.0))
    other = np.flatnonzero((b[index] < 0.0) & (above[index] > 0.0))
    at = index[proved]
    root = np.zeros(at.size)
    whole = _in_tongues(lambda x, i: _growth(x, b[at[i]]), at, bottom[proved], top[proved], above[at], root)
    at = index[other]
    least = np.minimum(_SPACING * (high - low)[at], _SHARE * (top - bottom)[other])
    some = enclosures.parts_above(b[at], bottom[other], top[other], above[at], least, _growth, counts)
    exceedances = [Exceedances(chosen[parts.which], *parts[1:]) for chosen, parts in ((proved, whole), (other, some))]
    resolution = np.where((b < 0.0) & (start < high), _SPACING * (high - low), 0.0)
    parts = Exceedances(*(np.concatenate(values) for values in zip(*exceedances, strict=True)))
    nothing = np.empty(0, dtype=np.int64)
    left_out += index.size - len(set(parts.which.tolist()))
    return Tongues(*_collect(parts, index, order, nothing, low, high), left_out, resolution)


def damping_to_stabilise(alpha: Floats, beta: Floats, least: Floats | float = 0.0) -> Floats:
    """Return the smallest c above which every damping stabilises each equation, infinite where none does.

    Answers below ``least`` may be zero instead, which takes less work.

    Stable means u(beta + c^2) <= c, u the undamped growth.  For beta > 0 strong damping leaves A' = p A / (2 c), which
    grows at beta / (2 c): no damping suffices.  For beta <= 0 put b = beta + c^2.  In tongue 0 solutions without zeros
    have r = A' / A with r' = p - r^2, so u^2 = mean(r)^2 <= mean(r^2) = b <= c^2: stable.  What remains are tongues 1,
    2, ... between beta and tongue 0, from the top: the largest b of the first that has u > sqrt(b - beta), where u and
    the root are both concave in b.
    """
    q = 2.0 * np.abs(alpha)
    floor = beta + np.square(least)
    damping = np.where((beta > 0.0) | ((beta == 0.0) & (q == 0.0)), np.inf, 0.0)
    left = np.flatnonzero((damping == 0.0) & (q > 0.0))
    tongues = np.zeros(q.size, dtype=np.int64)
    tongues[left] = counts(-4.0 * beta[left], q[left]) // 2
    met: list[tuple[Ints, Ints]] = []
    for order in range(1, int(tongues.max(initial=0)) + 1):
        left = left[tongues[left] >= order]
        # Tongue n lies within q / 2 of b = -n^2 / 4, which tells most of those out of reach.
        bottom, top = (np.maximum(floor[left], -0.25 * order**2 + side * q[left]) for side in (-0.5, 0.5))
        near = left[~_out_of_reach(alpha[left], beta[left], bottom, top)]
        met.append((near, np.full(near.size, order)))
    if not met:
        return damping
    which, orders = (np.concatenate(values) for values in zip(*met, strict=True))
    a, b = (-0.25 * _characteristic(orders, q[which], odd) for odd in (False, True))
    bottom, top = np.maximum(floor[which], np.minimum(a, b)), np.maximum(a, b)
    reached = (top > floor[which]) & ~_out_of_reach(alpha[which], beta[which], bottom, top)
    which, bottom, top = _only(reached, which, bottom, top)
    above = level(0.0, 1.0, beta[which], size=which.size)
    parts = parts_above(lambda x, i: _growth(alpha[which[i]], x), bottom, top, above)
    last = parts.last - beta[which[parts.which]]
    np.maximum.at(damping, which[parts.which], np.sqrt(np.maximum(0.0, last)))
    return damping


def _out_of_reach(alpha: Floats, beta: Floats, bottom: Floats, top: Floats) -> Bools:
    """Return which tongues from ``bottom`` to ``top`` lie too far above beta for sqrt(b - beta) to be exceeded there.

    u <= alpha / (pi sqrt(-b)) wherever b < 0 (energy u'^2 - b u^2).
    """
    with np.errstate(divide="ignore"):
        return (top < 0.0) & (bottom - beta > alpha * alpha / (math.pi**2 * -top))


def _in_tongues(
    growth: Callable[[Floats, Ints], Floats], index: Ints, bottom: Floats, top: Floats, constant: Floats, root: Floats
) -> Exceedances:
    """Return the parts of tongues above their level, which are whole tongues where the level is zero."""
    every = np.arange(index.size)
    whole = (constant == 0.0) & (root == 0.0) & (top > bottom)
    some = np.flatnonzero(~whole & (top > bottom))
    above = level(constant[some], root[some], size=some.size)
    exceedances = parts_above(lambda x, i: growth(x, some[i]), bottom[some], top[some], above)
    which = np.concatenate([every[whole], some[exceedances.which]])
    return Exceedances(
        which, np.concatenate([bottom[whole], exceedances.first]), np.concatenate([top[whole], exceedances.last])
    )


def _collect(
    parts: Exceedances, index: Ints, order: Ints, buckled: Ints, low: Floats, high: Floats
) -> tuple[Ints, Ints, Floats, Floats]:
    """Return question, order and ends of all parts, those that buckle without forcing at the end."""
    return (
        np.concatenate([index[parts.which], buckled]),
        np.concatenate([order[parts.which], np.zeros(buckled.size, dtype=np.int64)]),
        np.concatenate([parts.first, low[buckled]]),
        np.concatenate([parts.last, high[buckled]]),
    )


def _only(kept: Bools, *arrays: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    return tuple(array[kept] for array in arrays)


def numbers_between(start: Ints, stop: Ints) -> tuple[Ints, Ints]:
    """Return (question, number) for the numbers from ``start`` to ``stop``, both included, of every question."""
    sizes = np.maximum(stop - start + 1, 0)
    index = np.repeat(np.arange(start.size), sizes)
    first = np.repeat(np.cumsum(sizes) - sizes, sizes)
    return index, np.arange(index.size) - first + start[index]


def where_bounded(settled: Callable[[Floats, Ints], Bools], low: Floats, high: Floats) -> Floats:
    """Return a place up to which ``settled`` holds, which it does from ``low`` up to some place or nowhere."""
    every = np.arange(low.size)
    if not low.size:
        return low
    holds = settled(low, every)
    all_of_it = settled(high, every) & holds
    some = np.flatnonzero(holds & ~all_of_it)
    place = np.where(all_of_it, high, low)
    place[some], _ = bisected(lambda x: settled(x, some), low[some], high[some], 40)
    return place


def _passages(count: Callable[[Floats, Ints], Ints], index: Ints, target: Ints, more: Floats, less: Floats) -> Floats:
    """Return where the count passes ``target``, to rounding: it exceeds it at ``more`` and not at ``less``."""
    more, less = more.copy(), less.copy()
    open_ = np.arange(index.size)
    while open_.size:
        low, high = np.minimum(more, less)[open_], np.maximum(more, less)[open_]
        middle = np.sqrt(low) * np.sqrt(high)  # quicker where the ends are far apart
        middle = np.where((middle > low) & (middle < high) & (low < 0.5 * high), middle, 0.5 * (low + high))
        parted = (middle > low) & (middle < high)
        open_, middle = open_[parted], middle[parted]
        exceeds = count(middle, index[open_]) > target[open_]
        more[open_], less[open_] = np.where(exceeds, middle, more[open_]), np.where(exceeds, less[open_], middle)
    return less


def _amplitude_pieces(b: Floats, low: Floats, high: Floats) -> tuple[Ints, Ints, Floats, Floats]:
    """Return question, count and ends of the pieces of [low, high] of alpha on which the count is constant.

    For b >= 0 counts never fall as alpha grows (the pencil -d^2 + b is not negative); for b < 0 they may turn back, and
    are taken at points between which they are known to stay as they are, or `_SPACING` of the range apart.
    """

    def count(alpha: Floats, i: Ints) -> Ints:
        return counts(-4.0 * b[i], 2.0 * alpha)

    least = np.where(b < 0.0, _SPACING * (high - low), np.inf)
    owner, place = enclosures.divided(b, low, high, least, counts)
    counted = count(place, owner)
    cell = np.flatnonzero((owner[1:] == owner[:-1]) & (counted[1:] != counted[:-1]))
    least, most = np.minimum(counted[cell], counted[cell + 1]), np.maximum(counted[cell], counted[cell + 1])
    passed, target = numbers_between(least, most - 1)
    left, right = place[cell][passed], place[cell + 1][passed]
    falling = counted[cell][passed] > target
    at = _passages(count, owner[cell][passed], target, np.where(falling, left, right), np.where(falling, right, left))
    every = np.arange(b.size)
    place, owner = np.concatenate([low, high, at]), np.concatenate([every, every, owner[cell][passed]])
    order = np.lexsort((place, owner))
    place, owner = place[order], owner[order]
    within = (owner[1:] == owner[:-1]) & (place[1:] > place[:-1])
    index, bottom, top = owner[:-1][within], place[:-1][within], place[1:][within]
    return index, count(0.5 * (bottom + top), index), bottom, top


def _growth(alpha: Floats, b: Floats) -> Floats:
    inputs = alpha, b, np.zeros(b.size)
    return filled(mathieu_discriminant.growth_fill, inputs, np.empty(b.size), (-4.0 * b, 2.0 * alpha), 4.0)


def counts(a: Floats, q: Floats) -> Ints:
    """Return how many characteristic values lie below each a."""
    return filled(mathieu_counts.count_fill, (a, q), np.empty(a.size, dtype=np.int64), (a, q), 1.0, chunk=4096)


def growth_bounds(a: Floats, q: Floats) -> Floats:
    """Return a bound on the growth per unit tau, which falls as a grows and rises with q; infinite for a <= 2 q."""
    return filled(mathieu_discriminant.growth_bound_fill, (a, q), np.empty(a.size), (a, q), 1.0, chunk=4096)


def filled(
    fill: Any,
    inputs: Sequence[NDArray[Any]],
    out: NDArray[Any],
    sizes: tuple[Floats, Floats],
    cost: float,
    chunk: int = 1024,
) -> NDArray[Any]:
    """Return ``out`` filled by a kernel, interpreted where there are few equations: the larger they are, the fewer.

    ``sizes`` are about the a and q of each, ``cost`` what one takes, in counts.
    """
    a, q = sizes
    rows = 20.0 + math.sqrt(max(0.0, float(np.max(a + 2.0 * np.abs(q), initial=0.0))))
    few = int(_INTERPRETED_ROWS / (cost * rows))
    over_chunks(fill, inputs, out, chunk=chunk, interpret_up_to=few, compile_after=_COMPILE_AFTER)
    return out


def _characteristic(order: Ints, q: Floats, odd_solution: bool) -> Floats:
    """Return a_order(q) or, for ``odd_solution``, b_order(q); for b_0, which does not exist, a_0."""
    inputs = order, q, np.full(order.size, odd_solution) & (order > 0)
    sizes = 4.0 * order.astype(np.float64) ** 2, q
    return filled(characteristic_bisection.characteristic_fill, inputs, np.empty(order.size), sizes, BISECTION)
