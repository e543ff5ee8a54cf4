"""The number of a pair of multipliers mu, 1 / mu: y = (mu + 1/mu - 2) / 4 = sinh(s / 2)^2, s = log mu.

The motion is bounded where y lies between -1 and 0; near these ends y keeps digits that mu has lost.  By how much a
real y lies beyond the nearer end is its *excess* X: sinh(growth / 2)^2 where the motion grows, -sin(turn / 2)^2 where
it is bounded, growth and turn from the nearer end over a period.  Of one scalar equation, its damping removed, with the
discriminant D, X = (abs(D) - 2) / 4.  A computation gives y or X with an error, and what they lie between decides.

Floats stand for one pair, X = excess * 2**exponent, so that growth may leave the range of a double; arrays for many.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Complexes, Floats

_HUGE = 900  # binary exponents of X from which X itself may not be formed


def excess(y: Any, above: Any) -> Any:
    """Return X of real y, 1 + y given as ``above``."""
    return np.maximum(y, -above)


def decided(excess: Any, error: Any) -> Any:
    """Return 1 where X within its error is positive, so that the motion grows, -1 where negative, 0 where not known."""
    return (excess > error) * 1 - (excess < -error) * 1


def decided_far(excess: float, exponent: int, error: float) -> int:
    """Return what `decided` does of X = excess * 2**exponent, ``error`` relative to max(1, abs(X))."""
    if exponent > _HUGE:
        return int(error < 1.0)
    value = ldexp(excess, exponent)
    return int(decided(value, error * max(1.0, abs(value))))


def growth(excess: float, exponent: int = 0) -> float:
    """Return the growth over a period, 2 asinh(sqrt X), of X = excess * 2**exponent; zero where X <= 0."""
    if excess <= 0.0:
        return 0.0
    if exponent > _HUGE:
        return 2.0 * math.log(2.0) + math.log(excess) + exponent * math.log(2.0)
    odd = exponent % 2
    return 2.0 * math.asinh(ldexp(math.sqrt(ldexp(excess, odd)), (exponent - odd) // 2))


def growth_band(excess: float, exponent: int, error: float) -> tuple[float, float]:
    """Return the growth over a period at both ends of the band of X, ``error`` relative to max(1, abs(X))."""
    if exponent > _HUGE:
        middle = growth(excess, exponent)
        return middle - 2.0 * error, middle + 2.0 * error
    value = ldexp(excess, exponent)
    size = error * max(1.0, abs(value))
    slack = 4.0 * EPS
    return growth(value - size) * (1.0 - slack), growth(value + size) * (1.0 + slack)


def turn(excess: float, sign: int) -> float:
    """Return the angle of the multipliers, from 0 to pi, of X <= 0 and the sign of the discriminant."""
    angle = 2.0 * math.asin(min(1.0, math.sqrt(-excess)))
    return angle if sign > 0 else math.pi - angle


def logarithms(y: Any) -> Any:
    """Return s = 2 asinh(sqrt y) of complex y: the real part is the growth over a period, up to its sign."""
    return 2.0 * np.arcsinh(np.sqrt(y))


def upper_logarithms(y: Complexes, above: Complexes) -> Complexes:
    """Return s, its angle from 0 to pi, or its negative below the real axis, from y and 1 + y."""
    far = np.abs(above) >= np.abs(y)
    logs = np.asarray(logarithms(np.where(far, y, -above)))
    # Next to -1 s = i pi + v with sinh(v / 2)^2 = -(1 + y).
    turned = np.copysign(math.pi - np.abs(logs.imag), np.where(y.imag < 0.0, -1.0, 1.0))
    logs.imag = np.where(far, logs.imag, turned)
    return logs


def outside(y: Complexes, above: Complexes) -> Floats:
    """Return distances of y from the interval from -1 to 0."""
    return np.asarray(np.where(y.real > 0.0, np.abs(y), np.where(above.real < 0.0, np.abs(above), np.abs(y.imag))))


def slopes(y: NDArray[Any], above: NDArray[Any], radii: Floats) -> Floats:
    """Return by how much s changes within discs, to first order: ds = dy / sqrt(y (1 + y)), 1 + y given."""
    y, above = np.abs(y), np.abs(above)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        product = y * above
        return np.asarray(2.0 * radii / np.where(np.isinf(product), np.sqrt(y) * np.sqrt(above), np.sqrt(product)))


def log_errors(y: NDArray[Any], above: NDArray[Any], radii: Floats) -> Floats:
    """Return by how much s may change within discs, a root near the ends of y.

    Half way to an end and closer s has changed by no more than a root's whole way.
    """
    nearest = np.minimum(np.abs(y), np.abs(above))
    whole = 2.0 * np.abs(np.arcsinh(np.sqrt(nearest + radii))) + 2.0 * np.sqrt(radii)
    return np.asarray(np.where(radii > 0.5 * nearest, whole, np.fmin(slopes(y, above, radii), whole)))


def growth_bounds(y: NDArray[Any], radii: Floats) -> tuple[Floats, Floats]:
    """Return bounds of the growth over a period within large discs: abs(y) = sinh(growth / 2)^2 + sin(turn / 2)^2."""
    low = 2.0 * np.arcsinh(np.sqrt(np.maximum(0.0, np.abs(y) - radii - 1.0)))
    return low, 2.0 * np.arcsinh(np.sqrt(np.abs(y) + radii))


def vague_growth(y: NDArray[Any], radii: Floats) -> tuple[Floats, Floats]:
    """Return the middle of the bounds of the growth over a period within large discs, and the error of s."""
    low, high = growth_bounds(y, radii)
    return 0.5 * (low + high), np.hypot(0.5 * (high - low), math.pi)


def ldexp(value: float, exponent: int) -> float:
    """Return value * 2**exponent, infinite beyond the range of a double."""
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.copysign(math.inf, value)
