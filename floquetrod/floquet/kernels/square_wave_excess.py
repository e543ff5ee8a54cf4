"""Kernels for Meissner's equation A'' = (beta + alpha sign(sin tau)) A: the closed form, entire in its coefficients."""

from __future__ import annotations

import math

from floquetrod._util.arrays import EPS
from floquetrod._util.compilation import kernel


@kernel
def _quarter(value: float) -> tuple[float, float, float, int]:
    """Return C = cosh(h r), S = sinh(h r) / r, r^2 = value, h = pi / 2, both times 2^exponent, and |r|.

    Both are entire in r^2: for negative values they are cos(h |r|) and sin(h |r|) / |r|.
    """
    h = 0.5 * math.pi
    root = math.sqrt(abs(value))
    if value == 0.0:
        return 1.0, h, 0.0, 0
    if value < 0.0:
        return math.cos(h * root), math.sin(h * root) / root, root, 0
    if h * root < 80.0:  # the product of four such factors stays in range
        return math.cosh(h * root), math.sinh(h * root) / root, root, 0
    power = h * root / math.log(2.0)
    whole = math.floor(power)
    half = 0.5 * 2.0 ** (power - whole)
    return half, half / root, root, int(whole)


@kernel
def square_wave_excess(high: float, low: float, slack: float) -> tuple[int, float, int, float]:
    """Return (sign, X, exponent, error) for the coefficient ``high`` on half a period and ``low`` on the other.

    ``error`` bounds the error of X relative to max(1, |X|), to first order in rounding; ``slack`` is the absolute
    error of ``high`` and ``low`` themselves.
    """
    # With C and S of both halves, y1' = r1^2 S1 C2 + r2^2 C1 S2 and y2 = S1 C2 + C1 S2 give (trace - 2) / 4 = y1' y2,
    # and y1 y2' gives (trace + 2) / 4 (docs/theory/square_wave.md): two factors each, so that X keeps its digits at a
    # boundary. c, s, r, e hold C, S, abs(r) and the binary exponent of a half; a name with d before it holds an error
    # bound. The first pair of factors serves unless trace < 0, when the second one does: X = (abs(trace) - 2) / 4.
    c1, s1, r1, e1 = _quarter(high)
    c2, s2, r2, e2 = _quarter(low)
    h = 0.5 * math.pi
    # Error of C: r S times that of its argument h r; of S: h times that of C over its own; d(r^2) enters both.
    d1 = 4.0 * EPS * (1.0 + h * r1) + h * slack / max(r1, 1.0)
    d2 = 4.0 * EPS * (1.0 + h * r2) + h * slack / max(r2, 1.0)
    dc1, ds1 = d1 * (abs(c1) + r1 * abs(s1)), d1 * (abs(s1) + h * abs(c1) / max(1.0, h * r1))
    dc2, ds2 = d2 * (abs(c2) + r2 * abs(s2)), d2 * (abs(s2) + h * abs(c2) / max(1.0, h * r2))
    e = 2 * (e1 + e2)
    one = 2.0 ** -min(e, 1000)
    first = high * s1 * c2 + low * c1 * s2
    second = s1 * c2 + c1 * s2
    dfirst = (abs(high) * ds1 + slack * abs(s1)) * abs(c2) + abs(high * s1) * dc2
    dfirst += (abs(low) * ds2 + slack * abs(s2)) * abs(c1) + abs(low * s2) * dc1
    dsecond = ds1 * abs(c2) + abs(s1) * dc2 + dc1 * abs(s2) + abs(c1) * ds2
    sign = 1
    if first * second < -0.5 * one:
        sign = -1
        common = dc1 * abs(c2) + abs(c1) * dc2
        first = -(c1 * c2 + high * s1 * s2)
        second = c1 * c2 + low * s1 * s2
        product = abs(s1) * ds2 + ds1 * abs(s2)
        dfirst = common + abs(high) * product + slack * abs(s1 * s2)
        dsecond = common + abs(low) * product + slack * abs(s1 * s2)
    x = first * second
    dx = dfirst * abs(second) + dsecond * abs(first) + dfirst * dsecond + 4.0 * EPS * abs(x)
    return sign, x, e, dx / max(one, abs(x))
