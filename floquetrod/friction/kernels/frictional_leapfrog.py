"""Kernel for the paper's leapfrog with dry friction, gamma = 1: independent of the event-driven kernel."""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel

_FAR = 1e250  # where friction no longer matters and the result is known


@kernel
def _held(v: float, impulse: float) -> float:
    """Return a velocity after a friction impulse, which stops the motion but never reverses it: so it sticks."""
    return math.copysign(max(0.0, abs(v) - impulse), v)


@kernel
def frictional_leapfrog_fill(
    alpha: Any, beta: Any, damping: Any, kick: Any, sine: Any, periods: int, limit: float, out: Any
) -> None:
    """Fill ``out`` with whether abs(A) reaches ``limit`` times the kick at the end of ``periods``.

    ``sine`` holds sin tau at equal steps over 2 pi.
    """
    count = len(sine)
    h = 2.0 * math.pi / count
    for i in range(len(alpha)):
        decay = math.exp(-damping[i] * h)
        a, v = 0.0, kick[i]
        period = 0
        while period < periods and abs(a) < _FAR:
            p = beta[i] + alpha[i] * sine[0]
            for j in range(count):
                v = _held(v * decay + 0.5 * h * p * a, 0.5 * h)
                a += h * v
                p = beta[i] + alpha[i] * sine[j + 1 if j + 1 < count else 0]
                v = _held(v + 0.5 * h * p * a, 0.5 * h) * decay
            period += 1
        out[i] = kick[i] > 0.0 and not abs(a) < limit * kick[i]  # NaN: beyond doubles within a period
