"""Kernel for two coupled equations: from coefficients to the two numbers x = mu + 1/mu, with errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.kernels.system_even_steps import half_period, workspace
from floquetrod.kernels.system_series import ROUNDING, invert, spectral_bound


@kernel
def pair_fill(
    stiffness: Any, amplitudes: Any, period: Any, out: Any, accuracy: float, reach: float, symmetric: bool
) -> None:
    """Fill rows of ``out`` (8) with Re x, Im x, the error and the Krein form of each of the two pairs."""
    first = 1 if symmetric else 0
    count = len(amplitudes[0]) + 1 - first
    s, f, g = np.empty(2), np.zeros((count, 2, 2)), np.empty(2)
    total, copy, inverse = np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4))
    y, r = np.empty((2, 2)), np.empty((2, 2))
    b, c = np.empty((2, 2)), np.empty((2, 2))
    work = workspace(2, count)
    for i in range(len(out)):
        stiff = stiffness[i]
        s[0], s[1] = stiff[0][0], stiff[1][1]
        cosine, sine = 1.0, 0.0
        slack = 2.0 * ROUNDING
        if not symmetric:
            f[0, 0, 1], f[0, 1, 0] = stiff[0][1], stiff[1][0]
        elif stiff[0][1] != 0.0:
            slack = 10.0 * ROUNDING
            ratio = 0.5 * (s[1] - s[0]) / stiff[0][1]
            tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
            s[0] -= tangent * stiff[0][1]
            s[1] += tangent * stiff[0][1]
            cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
            sine = tangent * cosine
        for k in range(1 - first, count):
            a = amplitudes[i][k + first - 1]
            p, q, t, u = a[0][0], a[0][1], a[1][0], a[1][1]
            if sine != 0.0:
                # columns, then rows, by the rotation (cosine, -sine) and (sine, cosine)
                p, q = cosine * p - sine * q, sine * p + cosine * q
                t, u = cosine * t - sine * u, sine * t + cosine * u
                p, t = cosine * p - sine * t, sine * p + cosine * t
                q, u = cosine * q - sine * u, sine * q + cosine * u
            f[k, 0, 0], f[k, 0, 1], f[k, 1, 0], f[k, 1, 1] = p, q, t, u
        omega = 2.0 * math.pi / period[i]
        error = half_period(s, f, first, omega, accuracy, reach, symmetric, slack, 2, g, work, total)
        for row in range(2):
            for column in range(2):
                b[row, column] = total[column, 2 + row]
                c[row, column] = total[2 + row, column]
                r[row, column] = total[0, row] * total[2, column] + total[1, row] * total[3, column]
        wrong = error
        if not symmetric:
            copy[:] = total
            invert(copy, inverse)
            for row in range(2):
                for column in range(2):
                    b[row, column] = -inverse[row, 2 + column]
            norm = spectral_bound(inverse)
            wrong = norm * norm * (error + 16.0 * ROUNDING * spectral_bound(total))
            wrong = wrong / (1.0 - norm * error) if norm * error < 0.5 else math.inf
        for row in range(2):
            for column in range(2):
                y[row, column] = b[row, 0] * c[0, column] + b[row, 1] * c[1, column]
        size_b, size_c = spectral_bound(b), spectral_bound(c)
        slip = size_b * error + size_c * wrong + error * wrong + 4.0 * ROUNDING * size_b * size_c
        size_a = spectral_bound(total[:2, :2])
        form_slip = size_a * error + size_c * error + error * error + 4.0 * ROUNDING * size_a * size_c
        pair_values(y, slip, r, form_slip if symmetric else math.inf, out[i])


@kernel
def pair_values(y: Any, slip: float, r: Any, form_slip: float, out: Any) -> None:
    """Fill ``out`` from Y, whose eigenvalues are (x - 2) / 4, and the form R with which it is self-adjoint.

    ``slip`` and ``form_slip`` are their errors in the Frobenius norm.
    """
    mean = 0.5 * (y[0, 0] + y[1, 1])
    half = 0.5 * (y[0, 0] - y[1, 1])
    square = half * half + y[0, 1] * y[1, 0]
    slope = math.sqrt(2.0 * half * half + y[0, 1] * y[0, 1] + y[1, 0] * y[1, 0])
    square_slip = (slope + slip) * slip + 4.0 * ROUNDING * slope * slope
    root = math.sqrt(abs(square))
    decided = abs(square) > square_slip
    if decided:
        root_slip = square_slip / (root + math.sqrt(abs(square) - square_slip))
    else:
        root_slip = math.sqrt(square_slip)
    error = 4.0 * (0.7072 * slip + root_slip) + 8.0 * ROUNDING * (1.0 + abs(mean) + root)
    norm = spectral_bound(r)
    for j in range(2):
        sign = 2.0 * j - 1.0
        out[4 * j] = 2.0 + 4.0 * (mean + (sign * root if square > 0.0 else 0.0))
        out[4 * j + 1] = 0.0 if square > 0.0 else 4.0 * sign * root
        out[4 * j + 2] = error
        out[4 * j + 3] = 0.0
        if square > 0.0 and decided:
            # Two rows of (Y - y) u = 0; the one with the longer u is the better conditioned.
            p, q = y[0, 1], sign * root - half
            if abs(half + sign * root) > abs(q):
                p, q = half + sign * root, y[1, 0]
            length = math.sqrt(p * p + q * q)
            turn = 2.0 * (slip + root_slip + 4.0 * ROUNDING * slope) / length
            form = (p * p * r[0, 0] + p * q * (r[0, 1] + r[1, 0]) + q * q * r[1, 1]) / (length * length)
            if abs(form) > form_slip + 2.0 * norm * turn:
                out[4 * j + 3] = form
