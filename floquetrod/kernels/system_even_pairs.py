"""Kernel for two coupled equations: from coefficients to the two numbers x = mu + 1/mu, with errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.kernels.system_even_lanes import LANES, lane_load, lane_maps, lane_workspace, rotated, rotation
from floquetrod.kernels.system_even_steps import half_period, workspace
from floquetrod.kernels.system_series import ROUNDING, invert, spectral_bound


@kernel
def pair_fill(stiffness: Any, amplitudes: Any, period: Any, out: Any, accuracy: float, reach: float) -> None:
    """Fill rows of ``out`` (8): Re and Im of both x, then their errors, then their Krein forms."""
    batch, count = len(out), len(amplitudes[0])
    work, general = workspace(2, count), workspace(2, count + 1)
    small = np.empty((5, 4, 4))
    lanes = lane_workspace(count)
    start = 0
    while start < batch:
        used = min(LANES, batch - start)
        together = used > LANES // 4 and lane_load(stiffness, amplitudes, period, start, used, lanes)
        if together and lane_maps(accuracy, reach, lanes):
            for lane in range(used):
                for row in range(4):
                    for column in range(4):
                        small[0, row, column] = lanes[7][row * 4 + column, lane]
                error = lanes[8][2, lane]
                pair_outcome(small, error, error, True, out[start + lane])
        else:
            for i in range(start, start + used):
                symmetric = is_symmetric(stiffness[i])
                for k in range(count):
                    symmetric = symmetric and is_symmetric(amplitudes[i][k])
                space = work if symmetric else general
                pair_row(stiffness[i], amplitudes[i], period[i], accuracy, reach, symmetric, small, space, out[i])
        start += used


@kernel
def is_symmetric(matrix: Any) -> bool:
    """Say whether a matrix (2, 2) is symmetric, to the bit."""
    return bool(matrix[0][1] == matrix[1][0])


@kernel
def pair_row(
    stiff: Any, amplitudes: Any, period: float, accuracy: float, reach: float, symmetric: bool, small: Any, work: Any,
    out: Any,
) -> None:  # fmt: skip
    """Fill one row of `pair_fill`."""
    first = 1 if symmetric else 0
    count = len(amplitudes) + 1 - first
    total, copy, inverse = small[0], small[1], small[2]
    s, f, g = np.empty(2), np.zeros((count, 2, 2)), np.empty(2)
    s[0], s[1] = stiff[0][0], stiff[1][1]
    tangent, cosine, sine = 0.0, 1.0, 0.0
    if symmetric:
        tangent, cosine, sine = rotation(s[0], s[1], stiff[0][1])
        s[0] -= tangent * stiff[0][1]
        s[1] += tangent * stiff[0][1]
    else:
        f[0, 0, 1], f[0, 1, 0] = stiff[0][1], stiff[1][0]
    for k in range(1 - first, count):
        f[k, 0, 0], f[k, 0, 1], f[k, 1, 0], f[k, 1, 1] = rotated(amplitudes[k + first - 1], cosine, sine)
    slack = (10.0 if sine != 0.0 else 2.0) * ROUNDING
    error = half_period(s, f, first, 2.0 * math.pi / period, accuracy, reach, symmetric, slack, 2, g, work, total)
    wrong = error
    if not symmetric:
        copy[:] = total
        invert(copy, inverse)
        norm = spectral_bound(inverse)
        wrong = norm * norm * (error + 16.0 * ROUNDING * spectral_bound(total))
        wrong = wrong / (1.0 - norm * error) if norm * error < 0.5 else math.inf
    pair_outcome(small, error, wrong, symmetric, out)


@kernel
def pair_outcome(small: Any, error: float, wrong: float, symmetric: bool, out: Any) -> None:
    """Fill one row of `pair_fill` from the map and, where K is not symmetric, its inverse; their errors are given."""
    total, inverse = small[0], small[2]
    y, r, b, c = small[3, :2, :2], small[3, 2:, 2:], small[4, :2, :2], small[4, 2:, 2:]
    for row in range(2):
        for column in range(2):
            b[row, column] = total[column, 2 + row] if symmetric else -inverse[row, 2 + column]
            c[row, column] = total[2 + row, column]
            r[row, column] = total[0, row] * total[2, column] + total[1, row] * total[3, column]
    for row in range(2):
        for column in range(2):
            y[row, column] = b[row, 0] * c[0, column] + b[row, 1] * c[1, column]
    size_b, size_c = spectral_bound(b), spectral_bound(c)
    slip = size_b * error + size_c * wrong + error * wrong + 4.0 * ROUNDING * size_b * size_c
    size_a = spectral_bound(total[:2, :2])
    form_slip = size_a * error + size_c * error + error * error + 4.0 * ROUNDING * size_a * size_c
    pair_values(y, slip, r, form_slip if symmetric else math.inf, out)


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
        out[2 * j] = 2.0 + 4.0 * (mean + (sign * root if square > 0.0 else 0.0))
        out[2 * j + 1] = 0.0 if square > 0.0 else 4.0 * sign * root
        out[4 + j] = error
        out[6 + j] = 0.0
        if square > 0.0 and decided:
            # Two rows of (Y - y) u = 0; the one with the longer u is the better conditioned.
            p, q = y[0, 1], sign * root - half
            if abs(half + sign * root) > abs(q):
                p, q = half + sign * root, y[1, 0]
            length = math.sqrt(p * p + q * q)
            turn = 2.0 * (slip + root_slip + 4.0 * ROUNDING * slope) / length
            form = (p * p * r[0, 0] + p * q * (r[0, 1] + r[1, 0]) + q * q * r[1, 1]) / (length * length)
            if abs(form) > form_slip + 2.0 * norm * turn:
                out[6 + j] = form
