"""Kernels for the leapfrog scheme: kick, drift, kick, with damping split symmetrically about them."""

from __future__ import annotations

import math
from typing import Any

from floquetrod._compile import kernel


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
            if i % 64 == 0 or i + 1 == count:
                size = max(abs(a), abs(v))
                if size > 1e100:
                    a /= size
                    v /= size
                    taken += math.log(size)
    return a, v, taken
