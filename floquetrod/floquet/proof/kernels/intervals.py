"""Intervals of doubles rounded outwards: what a kernel proves rests on these few operations.

An operation on doubles is rounded to the nearest one (IEEE 754), so the exact result lies within a unit of the last
place of what is computed; `down` and `up` step over it.  A number that is not finite stays so or becomes NaN, and every
comparison with NaN is false: kernels conclude only from comparisons that hold.
"""

from __future__ import annotations

import math

from floquetrod._util.compilation import kernel

ULP = 2.220446049250313e-16  # 2^-52: times abs(x) it is at least the distance from x to its neighbours
TINY = 5e-324  # the smallest double: the distance from x to its neighbours where x is subnormal
PI_LOW = 3.141592653589793  # the double below pi
PI_HIGH = 3.1415926535897936  # the double above pi
LOG2_LOW = 0.6931471805599453  # the double below log 2
LOG2_HIGH = 0.6931471805599454  # the double above log 2


@kernel
def down(x: float) -> float:
    """Return a double below every real number that is rounded to ``x``."""
    return x - (abs(x) * ULP + TINY)


@kernel
def up(x: float) -> float:
    """Return a double above every real number that is rounded to ``x``."""
    return x + (abs(x) * ULP + TINY)


@kernel
def add(a: float, b: float, c: float, d: float) -> tuple[float, float]:
    """Enclose the sum of [a, b] and [c, d]."""
    return down(a + c), up(b + d)


@kernel
def subtract(a: float, b: float, c: float, d: float) -> tuple[float, float]:
    """Enclose the difference of [a, b] and [c, d]."""
    return down(a - d), up(b - c)


@kernel
def multiply(a: float, b: float, c: float, d: float) -> tuple[float, float]:
    """Enclose the product of [a, b] and [c, d]; NaN where a product of two ends is."""
    ac = a * c
    ad = a * d
    bc = b * c
    bd = b * d
    low = min(min(ac, ad), min(bc, bd))
    high = max(max(ac, ad), max(bc, bd))
    poison = 0.0 * (ac + ad + bc + bd)  # min and max may drop a NaN
    return down(low + poison), up(high + poison)


@kernel
def square(a: float, b: float) -> tuple[float, float]:
    """Enclose the squares of [a, b]."""
    aa = a * a
    bb = b * b
    poison = 0.0 * (aa + bb)
    low = 0.0 if a <= 0.0 <= b else max(0.0, down(min(aa, bb)))
    return low + poison, up(max(aa, bb) + poison)


@kernel
def divide(a: float, b: float, c: float, d: float) -> tuple[float, float]:
    """Enclose the quotients of [a, b] by [c, d], which must not hold zero: else NaN."""
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
def exp(x: float) -> tuple[float, float]:
    """Enclose the exponential of a double between -600 and 600: powers of two and a series."""
    if not -600.0 <= x <= 600.0:
        return math.nan, math.nan
    n = float(math.floor(x / LOG2_LOW + 0.5))
    a, b = multiply(n, n, LOG2_LOW, LOG2_HIGH)
    a, b = subtract(x, x, a, b)
    low, high = 1.0, 1.0
    for k in range(16, 0, -1):  # 1 + r / k (1 + r / (k + 1) (...)), the rest within r^17 / 17! < 1e-21
        low, high = multiply(low, high, a, b)
        low, high = divide(low, high, float(k), float(k))
        low, high = add(low, high, 1.0, 1.0)
    scale = math.ldexp(1.0, int(n))
    return down((low - 1e-20) * scale), up((high + 1e-20) * scale)


@kernel
def sinh_squared(x: float) -> tuple[float, float]:
    """Enclose sinh(x)^2 for a double from 0 to 300."""
    if not 0.0 <= x <= 300.0:
        return math.nan, math.nan
    if x < 0.5:  # the sum of (2 x)^(2 j) / (2 (2 j)!), the rest within a part in 1e18 of the first term
        y, z = square(2.0 * x, 2.0 * x)
        low, high = 1.0, 1.0
        for j in range(9, 1, -1):
            low, high = multiply(low, high, y, z)
            low, high = divide(low, high, 2.0 * j * (2.0 * j - 1.0), 2.0 * j * (2.0 * j - 1.0))
            low, high = add(low, high, 1.0, 1.0)
        y, z = square(x, x)
        low, high = multiply(low, high, y, z)
        return max(0.0, low), up(high * (1.0 + 4.0 * ULP))
    low, high = exp(x)
    a, b = divide(1.0, 1.0, low, high)
    a, b = subtract(low, high, a, b)
    low, high = square(a, b)
    return 0.25 * low, 0.25 * high
