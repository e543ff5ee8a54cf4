"""Kernels for the edges of a tongue's part above a level, along straight lines through the plane of (a, q).

Slope 1 and q1 = 0 is a line along the mean, with u = a; slope 4 kappa and q0 = 0 one along the frequency at given
forces, with u = 1 / omega^2.  What is compared with the level is growth^2 / (w0 + w1 u), growth per unit tau, which
must have one maximum within the tongue: w0 = 1 / omega^2 or w1 = 1 make it the square of growth per second.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.arrays import EPS
from floquetrod._util.compilation import kernel
from floquetrod.floquet.kernels.mathieu_discriminant import undamped_growth
from floquetrod.mathieu.kernels.characteristic_bisection import PlaneLine, tongue_bracket

_GOLDEN = 0.3819660112501051
_CLOSE = 1e-8  # share of a tongue to which its summit is located: growth is then known to rounding


@kernel
def tongue_end(order: int, odd_solution: bool, line: PlaneLine, low: float, high: float) -> float:
    """Return the place on a line, between ``low`` and ``high``, beyond which a lies above a_order, or b_order."""
    if order == 0 and odd_solution:
        return low
    return tongue_bracket(order, odd_solution, line, low, high)[1]


@kernel
def squared_rate(u: float, line: PlaneLine) -> float:
    """Return growth^2 / (w0 + w1 u) at a place on a line."""
    slope, q0, q1, w0, w1 = line
    rate = undamped_growth(0.5 * (q0 + q1 * u), -0.25 * (slope * u), 0.0)
    return rate * rate / (w0 + w1 * u)


@kernel
def summit(line: PlaneLine, low: float, high: float) -> tuple[float, float]:
    """Return where on a line, between ``low`` and ``high``, the squared rate is largest, and its value there.

    Brent's method: parabolas through the best three places, golden sections where they do not help.
    """
    # R. P. Brent, Algorithms for Minimization without Derivatives, 1973, chapter 5.  The maximum lies in [a, b]; best,
    # second and third are the three best places so far.  The parabola through them has its summit at best + top /
    # below; it is taken where it lies within [a, b] and halves the step before the last, else the longer side is cut.
    best = 0.5 * (low + high)
    value = squared_rate(best, line)
    second, at_second = best, value
    third, at_third = best, value
    step = 0.0
    before = 0.0
    a = low
    b = high
    width = high - low
    for _ in range(100):
        middle = 0.5 * (a + b)
        least = _CLOSE * width + 2.0 * EPS * abs(best)
        if abs(best - middle) <= 2.0 * least - 0.5 * (b - a):
            break
        parabola = False
        if abs(before) > least:
            # Slopes of chords to the second and the third best; top / below is the step to the vertex of the parabola.
            r = (best - second) * (at_third - value)
            s = (best - third) * (at_second - value)
            top = (best - third) * s - (best - second) * r
            below = 2.0 * (s - r)
            if below > 0.0:
                top = -top
            below = abs(below)
            if abs(top) < abs(0.5 * below * before) and below * (a - best) < top < below * (b - best):
                before = step
                step = top / below
                parabola = True
                place = best + step
                if place - a < 2.0 * least or b - place < 2.0 * least:
                    step = least if best < middle else -least
        if not parabola:
            # Golden section of the longer side.
            before = (b if best < middle else a) - best
            step = _GOLDEN * before
        place = best + (step if abs(step) >= least else math.copysign(least, step))
        if not low <= place <= high:
            break
        here = squared_rate(place, line)
        # A better place becomes the best, and the old one an end of [a, b]; a worse one becomes an end itself.
        if here >= value:
            if place >= best:
                a = best
            else:
                b = best
            third, at_third = second, at_second
            second, at_second = best, value
            best, value = place, here
        else:
            if place < best:
                a = place
            else:
                b = place
            if here >= at_second or second == best:
                third, at_third = second, at_second
                second, at_second = place, here
            elif here >= at_third or third in (best, second):
                third, at_third = place, here
    return best, value


@kernel
def _crossing(
    line: PlaneLine, target: float, inside: float, at_inside: float, outside: float, at_outside: float
) -> float:
    """Return where the squared rate passes ``target``, surplus positive ``inside``: Chandrupatla's method."""
    # T. R. Chandrupatla, Advances in Engineering Software 28 (1997) 145, doi:10.1016/S0965-9978(96)00051-8.  a is the
    # newest place, b the other side of the zero, c the place before; fa, fb, fc the surplus there.  The inverse
    # parabola through the three is used where it is monotone between a and b, xi and phi being the shares of place and
    # value; else the interval is halved.  The place returned is the one closer to the target.
    a, b, c = inside, outside, inside
    fa, fb, fc = at_inside, at_outside, at_inside
    t = 0.5
    for _ in range(200):
        place = a + t * (b - a)
        value = squared_rate(place, line) - target
        if (value > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, fc = b, fb
            b, fb = a, fa
        a, fa = place, value
        size = abs(a) if abs(fa) < abs(fb) else abs(b)
        width = abs(b - a)
        if fa == 0.0 or width <= 4.0 * EPS * size or width == 0.0:
            break
        least = 2.0 * EPS * size / width
        xi = (a - b) / (c - b)
        phi = (fa - fb) / (fc - fb)
        t = 0.5
        if phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        t = min(max(t, least), 1.0 - least)
    return a if abs(fa) < abs(fb) else b


@kernel
def level_edges(
    order: int, line: PlaneLine, low: float, high: float, target: float, lower: bool, upper: bool
) -> tuple[float, float]:
    """Return the lower and the upper end in u of the part of a tongue whose squared rate exceeds ``target``.

    They are the tongue's own ends where ``target`` is zero, and both the summit where nothing exceeds it.  Tongue 0
    begins at ``low``.  Of an end not asked for, neither ``lower`` nor ``upper``, any value is returned.
    """
    # Within a tongue the rate rises from 0 at its own ends to one summit: each end of what exceeds a level lies between
    # the summit and that end, and is found by its sign change there.  So the tongue's ends come first, then the summit,
    # unless tongue 0 begins above the level at ``low``; the crossings last, each where the rate at the end is below the
    # level.
    first = tongue_end(order, True, line, low, high) if lower or target > 0.0 else low
    last = tongue_end(order, False, line, low, high) if upper or target > 0.0 else high
    if target == 0.0:
        return first, last
    top = first
    most = squared_rate(first, line) if order == 0 else -1.0
    if most <= target:
        top, most = summit(line, first, last)
    if most <= target:
        return top, top
    if lower and first != top:
        at_end = squared_rate(first, line) - target
        if at_end < 0.0:
            first = _crossing(line, target, top, most - target, first, at_end)
    if upper and last != top:
        at_end = squared_rate(last, line) - target
        if at_end < 0.0:
            last = _crossing(line, target, top, most - target, last, at_end)
    return first, last


@kernel
def edge_fill(
    order: Any,
    slope: Any,
    q0: Any,
    q1: Any,
    w0: Any,
    w1: Any,
    low: Any,
    high: Any,
    target: Any,
    lower: Any,
    upper: Any,
    out: Any,
) -> None:
    """Fill ``out`` (n, 2) with `level_edges`."""
    # All arguments are arrays (n,): an order, a line, where it is searched, the level, and which ends are asked for.
    for i in range(len(order)):
        line = PlaneLine(slope[i], q0[i], q1[i], w0[i], w1[i])
        out[i, 0], out[i, 1] = level_edges(order[i], line, low[i], high[i], target[i], lower[i], upper[i])


@kernel
def ridge_fill(order: Any, slope: Any, q0: Any, q1: Any, w0: Any, w1: Any, low: Any, high: Any, out: Any) -> None:
    """Fill ``out`` with the largest squared rate of whole tongues."""
    for i in range(len(order)):
        line = PlaneLine(slope[i], q0[i], q1[i], w0[i], w1[i])
        first = tongue_end(order[i], True, line, low[i], high[i])
        last = tongue_end(order[i], False, line, low[i], high[i])
        _, out[i] = summit(line, first, last)


@kernel
def summit_fill(slope: Any, q0: Any, q1: Any, w0: Any, w1: Any, low: Any, high: Any, out: Any) -> None:
    """Fill ``out`` (n, 2) with `summit` on pieces of tongues, growth at whose ends is not zero."""
    # Brent's method never evaluates the ends, and growth on a piece may be largest there.
    for i in range(len(slope)):
        line = PlaneLine(slope[i], q0[i], q1[i], w0[i], w1[i])
        place, value = summit(line, low[i], high[i])
        for end in (low[i], high[i]):
            at_end = squared_rate(end, line)
            if at_end >= value:
                place, value = end, at_end
        out[i, 0], out[i, 1] = place, value
