"""All values of beta at which A'' + 2 c A' = (beta + alpha sin tau) A grows, at given alpha: complete, no grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from floquetrod.kernels import characteristic, mathieu

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


class UnstableInterval(NamedTuple):
    """Unstable for ``low`` < beta < ``high``, within tongue ``order``; tongue 0 has no upper end."""

    low: float
    high: float
    order: int


def unstable_intervals(
    alpha: float, damping: float, threshold: float, low: float, high: float
) -> list[UnstableInterval]:
    """Return every interval of beta meeting [low, high] where the net growth per unit tau exceeds ``threshold``.

    The tongues that meet the range are known by counting, so none is missed.  Without damping and threshold their ends
    are characteristic values; otherwise each is searched for the part where the growth u of the undamped equation
    exceeds c + threshold.  There u^2 is taken to rise to one maximum and fall again: proved for tongue 0 (u increases
    with beta), for the others an observation that the tests check.

    Parameters
    ----------
    alpha : float
        Amplitude; with alpha = 0 only tongue 0 is open.
    damping, threshold : float
        c and the net growth rate, both per unit tau, from which a solution counts as growing.
    low, high : float
        Range of beta.
    """
    c2 = damping * damping
    level = damping + threshold
    q = 2.0 * abs(alpha)
    found = []
    if q == 0.0:
        edge = level * level - c2
        return [UnstableInterval(edge, math.inf, 0)] if edge < high else []
    for order in range(_tongue_at(low + c2, q), _tongue_at(high + c2, q) - 1, -1):
        top = math.inf if order == 0 else -0.25 * characteristic.characteristic_value(order, q, True)
        # The bound falls as beta does: a tongue whose upper end cannot reach the level need not be searched.
        if level > 0.0 and -4.0 * top > 2.0 * q and mathieu.growth_bound(-4.0 * top, q) <= level:
            continue
        bottom = -0.25 * characteristic.characteristic_value(order, q, False)
        bottom, top = min(bottom, top), max(bottom, top)
        part = _above(alpha, bottom, top, level) if level > 0.0 else (bottom, top)
        if part is not None and part[1] - c2 > low and part[0] - c2 < high:
            found.append(UnstableInterval(part[0] - c2, part[1] - c2, order))
    return found


def damping_to_stabilise(alpha: float, beta: float) -> float:
    """Return the smallest c from which on every larger damping stabilises the equation, infinite where none does.

    Stable means u(beta + c^2) <= c, u the undamped growth.  For beta > 0 strong damping leaves A' = p A / (2 c), which
    grows at beta / (2 c): no damping suffices.  For beta <= 0 put b = beta + c^2.  In tongue 0 solutions without zeros
    have r = A' / A with r' = p - r^2, so u^2 = mean(r)^2 <= mean(r^2) = b <= c^2: stable.  What remains are tongues 1,
    2, ... between beta and tongue 0, from the top: the largest root of u^2 = b - beta in the first that has one.
    """
    if beta > 0.0 or (beta == 0.0 and alpha == 0.0):
        return math.inf
    q = 2.0 * abs(alpha)
    if q == 0.0:
        return 0.0
    for order in range(1, _tongue_at(beta, q) + 1):
        bottom = -0.25 * characteristic.characteristic_value(order, q, False)
        top = -0.25 * characteristic.characteristic_value(order, q, True)
        bottom, top = max(beta, min(bottom, top)), max(bottom, top)
        # u <= alpha / (pi sqrt(-b)) wherever b < 0 (energy u'^2 - b u^2): a tongue too far above beta is out of reach.
        if top <= beta or (top < 0.0 and bottom - beta > alpha * alpha / (math.pi**2 * -top)):
            continue

        def surplus(b: float) -> float:
            rate = mathieu.undamped_growth(alpha, b, 0.0)
            return rate * rate - (b - beta)

        peak = bottom if surplus(bottom) > 0.0 else _maximise(surplus, bottom, top)
        if surplus(peak) > 0.0:
            return math.sqrt(max(0.0, _root(surplus, peak, top) - beta))
    return 0.0


def _tongue_at(beta: float, q: float) -> int:
    """Return the order of the tongue that beta lies in, or of the next one above it."""
    return max(0, mathieu.count_below(-4.0 * beta, q)) // 2


def _above(alpha: float, bottom: float, top: float, level: float) -> tuple[float, float] | None:
    """Return the part of a tongue where the undamped growth exceeds ``level`` > 0."""

    def surplus(b: float) -> float:
        return mathieu.undamped_growth(alpha, b, 0.0) - level

    if math.isinf(top):  # u >= sqrt(b - |alpha|), and u increases with b
        far = max(bottom, abs(alpha) + level * level) + 1.0
        return _root(lambda b: -surplus(b), bottom, far), top
    return part_above(surplus, bottom, top)


def part_above(surplus: Callable[[float], float], low: float, high: float) -> tuple[float, float] | None:
    """Return the part of [low, high] where ``surplus`` is positive, which is taken to have one maximum there."""
    peak = max((low, high, _maximise(surplus, low, high)), key=surplus)
    if surplus(peak) <= 0.0:
        return None
    first = low if surplus(low) > 0.0 else _root(lambda x: -surplus(x), low, peak)
    last = high if surplus(high) > 0.0 else _root(surplus, peak, high)
    return first, last


def _maximise(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function with one maximum is largest (golden section), to about 1e-6 of the interval."""
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_left, at_right = function(left), function(right)
    for _ in range(30):
        if at_left > at_right:
            high, right, at_right = right, left, at_left
            left = high - _GOLDEN * (high - low)
            at_left = function(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + _GOLDEN * (high - low)
            at_right = function(right)
    return left if at_left > at_right else right


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where ``function`` falls from positive (at ``low``) to negative, to a few units of rounding."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)
