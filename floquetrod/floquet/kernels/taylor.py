"""Kernel that carries u'' = p(tau) u over an interval by Taylor series, p a finite Fourier series."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

ORDER = 24
REACH = 1.9  # step times frequency at which the 24th-order remainder is about rounding (measured)


@kernel
def advance(
    mean: float,
    ramp: float,
    real: Any,
    imag: Any,
    omega: float,
    start: float,
    length: float,
    steps: int,
    order: int,
    y: Any,
) -> int:
    """Carry two solutions y = (u1, u1', u2, u2') from ``start`` over ``length`` in equal Taylor steps.

    p(tau) = mean + ramp (tau - start) + sum_k real[k-1] cos(k omega tau) - imag[k-1] sin(k omega tau).  Returns the
    binary exponent that has been taken out of y, which holds mantissas.

    With p = sum p_j t^j and u = sum u_j t^j about the start of a step, (j + 1)(j + 2) u_(j+2) = sum_i p_i u_(j-i).
    The kernel keeps p_j h^(j+2) and u_j h^j, h the step: neither a tiny nor a huge period leaves the range of a double.
    """
    # p holds p_j h^(j+2): mean and slope, then each harmonic by the Taylor series of its cosine and sine about the
    # start. u holds u_j h^j of one solution, both after one another: (j+1)(j+2) u_(j+2) = sum_i p_i u_(j-i). Sums run
    # from the highest power down, the smallest first.  y keeps both solutions as mantissas: after a step that passes
    # 1e100 a power of two is taken out, which ``exponent`` counts.
    h = length / steps
    p = np.empty(order + 1)
    u = np.empty(order + 2)
    exponent = 0
    for step in range(steps):
        tau = start + step * h
        for j in range(order + 1):
            p[j] = 0.0
        p[0] = (mean + ramp * (step * h)) * h * h
        p[1] = ramp * h * h * h
        for k in range(len(real)):
            rate = (k + 1.0) * omega
            cosine, sine = math.cos(rate * tau), math.sin(rate * tau)
            angle = rate * h
            a = (real[k] * cosine - imag[k] * sine) * h * h
            b = (real[k] * sine + imag[k] * cosine) * h * h
            for j in range(order + 1):
                p[j] += a
                a, b = -angle * b / (j + 1.0), angle * a / (j + 1.0)
        for column in range(0, 4, 2):
            u[0] = y[column]
            u[1] = y[column + 1] * h
            for j in range(order):
                total = 0.0
                for i in range(j + 1):
                    total += p[i] * u[j - i]
                u[j + 2] = total / ((j + 1.0) * (j + 2.0))
            value = 0.0
            slope = 0.0
            for j in range(order + 1, 1, -1):  # the smallest first
                value += u[j]
                slope += j * u[j]
            y[column] = value + u[1] + u[0]
            y[column + 1] += slope / h
        size = max(abs(y[0]), abs(y[1]), abs(y[2]), abs(y[3]))
        if size > 1e100:
            shift = math.frexp(size)[1]
            for i in range(4):
                y[i] = math.ldexp(y[i], -shift)
            exponent += shift
    return exponent


@kernel
def mathieu_map_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` (n, 5) with the map over 2 pi of A'' + 2 c A' = (beta + alpha sin tau) A, and a logarithm.

    (A, A') from (1, 0), then from (0, 1); the map is these four numbers times the exponential of the fifth.
    """
    real = np.zeros(1)
    imag = np.empty(1)
    y = np.empty(4)
    for i in range(len(alpha)):
        c = damping[i]
        mean = beta[i] + c * c
        imag[0] = -alpha[i]
        frequency = math.sqrt(abs(mean) + abs(alpha[i])) + 1.0
        steps = int(2.0 * math.pi * frequency / REACH) + 1
        y[0], y[1], y[2], y[3] = 1.0, 0.0, 0.0, 1.0
        exponent = advance(mean, 0.0, real, imag, 1.0, 0.0, 2.0 * math.pi, steps, ORDER, y)
        # (A, A') = exp(-c tau) (u, u' - c u), and u'(0) = A'(0) + c A(0)
        out[i, 0] = y[0] + c * y[2]
        out[i, 1] = (y[1] - c * y[0]) + c * (y[3] - c * y[2])
        out[i, 2] = y[2]
        out[i, 3] = y[3] - c * y[2]
        out[i, 4] = exponent * math.log(2.0) - 2.0 * math.pi * c
