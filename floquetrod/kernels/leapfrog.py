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
            size = max(abs(a), abs(v))
            if size > 1e100:
                a /= size
                v /= size
                taken += math.log(size)
    return a, v, taken


@kernel
def _scaled(a: float, b: float, c: float, d: float) -> tuple[float, float, float, float, float]:
    """Return a matrix divided by its largest entry, and the logarithm of that."""
    size = max(abs(a), abs(b), abs(c), abs(d))
    if size == 0.0:
        return a, b, c, d, 0.0
    return a / size, b / size, c / size, d / size, math.log(size)


@kernel
def leapfrog_fill(alpha: Any, beta: Any, damping: Any, sine: Any, periods: int, out: Any) -> None:
    """Fill ``out`` with log10 |A(end) / A'(0)| of the paper's test (6), A(0) = 0, for (alpha, beta, damping).

    ``sine`` holds sin tau (or a square wave) at equal steps over 2 pi.  The scheme is linear and its coefficient
    periodic, so its map over one period, raised to the power ``periods`` by squaring, ends where stepping would.
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
            if max(abs(a1), abs(v1), abs(a2), abs(v2)) > 1e100:
                a1, v1, a2, v2, log_size = _scaled(a1, v1, a2, v2)
                taken += log_size
        # Only A(end) after A'(0) = 1 is asked for: carry that one column by the binary digits of ``periods``.
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
