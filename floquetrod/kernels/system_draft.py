"""Draft of the maps over a period, until the compiled kernels arrive."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray


def flow(mean: Any, harmonics: Any, w: float, length: float, rtol: float) -> tuple[NDArray[np.float64], float, int]:
    """Return the map over ``length`` from t = 0, an estimate of its absolute error, and the number of steps."""
    size = np.linalg.norm(mean, 2) + sum(np.linalg.norm(z, 2) for z in harmonics)
    steps = max(4, math.ceil(length * (size + w * len(harmonics)) / 1.5))
    order, h, n = 26, length / steps, len(mean)
    total = np.eye(n)
    k = np.arange(1, len(harmonics) + 1)
    growth = 1.0
    for step in range(steps):
        turned = [z * np.exp(1j * j * w * step * h) for j, z in zip(k, harmonics, strict=True)]
        u = [np.eye(n)]
        for j in range(order):
            term = mean @ u[j]
            for m, z in zip(k, turned, strict=True):
                inner = sum(((1j * m * w) ** i / math.factorial(i)) * u[j - i] for i in range(j + 1))
                term = term + (z @ inner).real
            u.append(term / (j + 1))
        one = sum(u[j] * h**j for j in range(order, -1, -1))
        total = one @ total
        growth *= max(1.0, float(np.linalg.norm(one, 2)))
    return total, 1e-15 * steps * n * growth, steps
