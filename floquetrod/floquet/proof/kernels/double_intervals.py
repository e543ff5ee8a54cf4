"""Intervals of doubles rounded outwards, pairs (low, high): what a kernel proves rests on these few operations.

An operation on doubles is rounded to the nearest one (IEEE 754), so the exact result lies within a unit of the last
place of the computed double; `down` and `up` step over it.  A number that is not finite stays so or becomes NaN, and
every comparison with NaN is false: kernels conclude only from comparisons that hold.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from floquetrod._util.compilation import kernel

ULP = 2.220446049250313e-16  # 2^-52: times abs(x) it is at least the distance from x to its neighbours
TINY = 5e-324  # the smallest double: the distance from x to its neighbours where x is subnormal
PI_LOW = 3.141592653589793  # the double below pi
PI_HIGH = 3.1415926535897936  # the double above pi
LOG2_LOW = 0.6931471805599453  # the double below log 2
LOG2_HIGH = 0.6931471805599454  # the double above log 2

Pair: TypeAlias = tuple[float, float]


@kernel
def down(x: float) -> float:
    """Return a double below every real number that is rounded to ``x``."""
    return x - (abs(x) * ULP + TINY)


@kernel
def up(x: float) -> float:
    """Return a double above every real number that is rounded to ``x``."""
    return x + (abs(x) * ULP + TINY)


@kernel
def add(x: Pair, y: Pair) -> Pair:
    """Enclose the sum of two intervals."""
    return down(x[0] + y[0]), up(x[1] + y[1])


@kernel
def subtract(x: Pair, y: Pair) -> Pair:
    """Enclose the difference of two intervals."""
    return down(x[0] - y[1]), up(x[1] - y[0])


@kernel
def multiply(x: Pair, y: Pair) -> Pair:
    """Enclose the product of two intervals; NaN where a product of two ends is."""
    # The extremes of x y over a rectangle lie at its corners.
    a, b = x
    c, d = y
    ac = a * c
    ad = a * d
    bc = b * c
    bd = b * d
    low = min(min(ac, ad), min(bc, bd))
    high = max(max(ac, ad), max(bc, bd))
    poison = 0.0 * (ac + ad + bc + bd)  # min and max may drop a NaN
    return down(low + poison), up(high + poison)


@kernel
def square(x: Pair) -> Pair:
    """Enclose the squares of an interval."""
    a, b = x
    aa = a * a
    bb = b * b
    poison = 0.0 * (aa + bb)
    low = 0.0 if a <= 0.0 <= b else max(0.0, down(min(aa, bb)))
    return low + poison, up(max(aa, bb) + poison)


@kernel
def divide(x: Pair, y: Pair) -> Pair:
    """Enclose the quotients of an interval by another, which must not hold zero: else NaN."""
    # The extremes of x / y, y of one sign, lie at the corners of the rectangle.
    a, b = x
    c, d = y
    if not (c > 0.0 or d < 0.0):
        return math.nan, math.nan
    ac = a / c
    ad = a / d
    bc = b / c
    bd = b / d
    low = min(min(ac, ad), min(bc, bd))
    high = max(max(ac, ad), max(bc, bd))
    poison = 0.0 * (ac + ad + bc + bd)
    return down(low + poison), up(high + poison)


@kernel
def exp(x: float) -> Pair:
    """Enclose the exponential of a double between -600 and 600: powers of two and a series."""
    # exp(x) = 2^n exp(r), n = x / log 2 rounded to a whole number and r = x - n log 2 within 0.35 of zero, enclosed.
    if not -600.0 <= x <= 600.0:
        return math.nan, math.nan
    n = float(math.floor(x / LOG2_LOW + 0.5))
    rest = subtract((x, x), multiply((n, n), (LOG2_LOW, LOG2_HIGH)))
    total = 1.0, 1.0
    for k in range(16, 0, -1):  # 1 + r / k (1 + r / (k + 1) (...)), the rest within r^17 / 17! < 1e-21
        total = add(divide(multiply(total, rest), (float(k), float(k))), (1.0, 1.0))
    scale = math.ldexp(1.0, int(n))
    return down((total[0] - 1e-20) * scale), up((total[1] + 1e-20) * scale)


@kernel
def sinh_squared(x: float) -> Pair:
    """Enclose sinh(x)^2 for a double from 0 to 300."""
    # sinh^2 x = (cosh 2x - 1) / 2 = x^2 (1 + (2x)^2 / (3 4) (1 + (2x)^2 / (5 6) (...))) near zero, where (e^x - e^-x)^2
    # / 4 would cancel.
    if not 0.0 <= x <= 300.0:
        return math.nan, math.nan
    if x < 0.5:  # the sum of (2 x)^(2 j) / (2 (2 j)!), the rest within a part in 1e18 of the first term
        y = square((2.0 * x, 2.0 * x))
        total = 1.0, 1.0
        for j in range(9, 1, -1):
            n = 2.0 * j * (2.0 * j - 1.0)
            total = add(divide(multiply(total, y), (n, n)), (1.0, 1.0))
        low, high = multiply(total, square((x, x)))
        return max(0.0, low), up(high * (1.0 + 4.0 * ULP))
    grown = exp(x)
    low, high = square(subtract(grown, divide((1.0, 1.0), grown)))
    return 0.25 * low, 0.25 * high
