"""Kernels for the leapfrog scheme: kick, drift, kick, with damping split symmetrically about them."""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel


@kernel
def leapfrog_run(
    table: Any, stride: int, step: float, damping: float, periods: int, a: float, v: float
) -> tuple[float, float, float]:
    """Carry (A, A') over whole periods; return both and the logarithm of the factor taken out of them.

    ``table`` holds the coefficient at equal steps over one period, of which every ``stride``-th is used, ``step``
    apart.
    """
    decay = math.exp(-damping * step)
    taken = 0.0
    count = len(table) // stride
    for _ in range(periods):
        p = table[0]
        for i in range(count):
            v = v * decay + 0.5 * step * p * a
            a += step * v
            p = table[(i + 1) * stride] if i + 1 < count else table[0]
            v = (v + 0.5 * step * p * a) * decay
            size = max(abs(a), abs(v))
            if size > 1e100:
                a /= size
                v /= size
                taken += math.log(size)
    return a, v, taken


@kernel
def leapfrog_map_fill(alpha: Any, beta: Any, damping: Any, out: Any, sine: Any) -> None:
    """Fill ``out`` (n, 5) with the scheme's map over 2 pi: (A, A') from (1, 0), from (0, 1), and a logarithm.

    The map is the first four numbers times the exponential of the fifth.  ``sine`` holds sin tau, or a square wave,
    at equal steps over the period.
    """
    count = len(sine)
    h = 2.0 * math.pi / count
    for point in range(len(alpha)):
        decay = math.exp(-damping[point] * h)
        a1, v1, a2, v2 = 1.0, 0.0, 0.0, 1.0
        taken = 0.0
        kick = 0.5 * h * (beta[point] + alpha[point] * sine[0])
        for i in range(count):
            v1 = v1 * decay + kick * a1
            v2 = v2 * decay + kick * a2
            a1 += h * v1
            a2 += h * v2
            kick = 0.5 * h * (beta[point] + alpha[point] * sine[(i + 1) % count])
            v1 = (v1 + kick * a1) * decay
            v2 = (v2 + kick * a2) * decay
            size = max(abs(a1), abs(v1), abs(a2), abs(v2))
            if size > 1e100:
                a1, v1, a2, v2 = a1 / size, v1 / size, a2 / size, v2 / size
                taken += math.log(size)
        out[point, 0] = a1
        out[point, 1] = v1
        out[point, 2] = a2
        out[point, 3] = v2
        out[point, 4] = taken
