"""Kernel that carries a motion over many periods, given the map over one."""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel


@kernel
def _scaled(a: float, b: float, c: float, d: float) -> tuple[float, float, float, float, float]:
    """Return a matrix divided by its largest entry, and the logarithm of that."""
    size = max(abs(a), abs(b), abs(c), abs(d))
    if size == 0.0:
        return a, b, c, d, 0.0
    return a / size, b / size, c / size, d / size, math.log(size)


@kernel
def displacement_fill(maps: Any, out: Any, periods: int) -> None:
    """Fill ``out`` with log10 |A / A'(0)| after whole periods from A(0) = 0.

    ``maps`` (n, 5) holds the map over one period as `leapfrog_map_fill` leaves it.  It is raised to the power by
    squaring, and carries the one motion asked for by the binary digits of ``periods``.
    """
    # M^periods (0, 1) by repeated squaring (D. E. Knuth, The Art of Computer Programming 2, 4.6.3): M^2^j is squared
    # from bit to bit, and multiplied into the motion (a, v) where the bit is 1; powers of M commute, so bits may come
    # lowest first.  Matrix and motion are divided by their largest entry each time; ``taken`` and ``total`` are the
    # logarithms.
    for point in range(len(maps)):
        a1, v1, a2, v2 = maps[point][0], maps[point][1], maps[point][2], maps[point][3]
        a1, v1, a2, v2, taken = _scaled(a1, v1, a2, v2)
        taken += maps[point][4]
        a, v, total = 0.0, 1.0, 0.0
        left = periods
        while left > 0:
            if left % 2 == 1:
                a, v = a1 * a + a2 * v, v1 * a + v2 * v
                size = max(abs(a), abs(v))
                if size == 0.0:
                    break
                a /= size
                v /= size
                total += taken + math.log(size)
            a1, v1, a2, v2, log_size = _scaled(
                a1 * a1 + a2 * v1, v1 * a1 + v2 * v1, a1 * a2 + a2 * v2, v1 * a2 + v2 * v2
            )
            taken = 2.0 * taken + log_size
            left //= 2
        out[point] = (total + math.log(abs(a))) / math.log(10.0) if a != 0.0 else -math.inf
