"""Kernels for two coupled equations: from coefficients to the two numbers x = mu + 1/mu, with errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.floquet.kernels.system_even_lanes import (
    LANES,
    lane_ends,
    lane_errors,
    lane_load,
    lane_plan,
    lane_product,
    lane_series,
    lane_workspace,
)
from floquetrod.floquet.kernels.system_series import ROUNDING, spectral_bound

NOT_DONE = -1.0
"""In place of the first error: the systems next to each other share no plan of a single segment."""


@kernel
def pair_fill(stiffness: Any, amplitudes: Any, period: Any, out: Any, accuracy: float, reach: float) -> None:
    """Fill rows of ``out`` (8): Re and Im of both x, then their errors, then their Krein forms; or mark them."""
    # From half a period P = [[A, B], [C, D]] to both x = mu + 1 / mu: K is even, so the map of the whole period is M =
    # (R P^-1 R) P with R = diag(1, 1, -1, -1), and where P is symplectic M + M^-1 has the upper left block 2 + 4 B^T C.
    # Hence x = 2 + 4 y with the two eigenvalues y of the 2 x 2 matrix Y = B^T C. Systems are taken `LANES` at a time
    # through one plan (`lane_plan`, `lane_series`, ...); where one segment is not enough for a group, its rows are
    # marked and left to `half_period_fill`.  total (16, LANES) is P of each lane, scalars[2] its error.
    batch, h = len(out), 0.5 * math.pi
    work = lane_workspace(len(amplitudes[0]))
    total, scalars = work[7], work[8]
    small = pair_workspace()
    for start in range(0, batch, LANES):
        used = min(LANES, batch - start)
        terms = 0
        if lane_load(stiffness, amplitudes, period, start, used, work):
            terms, most, ratio, rounding, cut, bound = lane_plan(accuracy, reach, work)
        if terms == 0:
            for lane in range(used):
                out[start + lane, 4] = NOT_DONE
            continue
        lane_series(h, terms, most, ratio**-4.0, work)
        lane_errors(h, terms, ratio, rounding, cut, bound, work)
        lane_ends(h, terms, work)
        lane_product(work)
        for lane in range(used):
            for row in range(len(small[0])):
                for column in range(len(small[0])):
                    small[0][row, column] = total[row * 4 + column, lane]
                    small[1][row, column] = small[0][row, column]
            pair_outcome(small, scalars[2, lane], scalars[2, lane], True, out[start + lane])


@kernel
def outcome_fill(maps: Any, inverses: Any, errors: Any, wrong: Any, symmetric: Any, out: Any) -> None:
    """Fill rows of ``out`` as `pair_fill` does, from maps over half a period, their inverses and the errors of both."""
    small = pair_workspace()
    for i in range(len(out)):
        for row in range(4):
            for column in range(4):
                small[0][row, column], small[1][row, column] = maps[i][row][column], inverses[i][row][column]
        pair_outcome(small, errors[i], wrong[i], symmetric[i], out[i])


@kernel
def pair_workspace() -> Any:
    """Return the arrays of `pair_outcome`: a map, its inverse, and blocks made of them."""
    return (
        np.empty((4, 4)), np.empty((4, 4)), np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2)), np.empty((2, 2)),
        np.empty((2, 2)),
    )  # fmt: skip


@kernel
def pair_outcome(small: Any, error: float, wrong: float, symmetric: bool, out: Any) -> None:
    """Fill one row of `pair_fill` from the map and, where K is not symmetric, its inverse; their errors are given."""
    # Y = b c, b = B^T of a symplectic map, and minus the upper right block of the inverse otherwise (P^-1 P = 1 gives
    # the same x = 2 + 4 y).  r = A^T C is the form in which Y is self-adjoint.  Errors in the Frobenius norm: with
    # |dB|, |dC| <= error (``wrong`` of the inverse) the product is off by |B| |dC| + |dB| |C| + |dB| |dC|, and by its
    # rounding.
    total, inverse, y, r, a, b, c = small
    n = len(y)
    for row in range(n):
        for column in range(n):
            a[row, column] = total[row, column]
            b[row, column] = total[column, 2 + row] if symmetric else -inverse[row, 2 + column]
            c[row, column] = total[2 + row, column]
            r[row, column] = total[0, row] * total[2, column] + total[1, row] * total[3, column]
    for row in range(n):
        for column in range(n):
            y[row, column] = b[row, 0] * c[0, column] + b[row, 1] * c[1, column]
    size_a, size_b, size_c = spectral_bound(a), spectral_bound(b), spectral_bound(c)
    slip = size_b * error + size_c * wrong + error * wrong + 4.0 * ROUNDING * size_b * size_c
    form_slip = size_a * error + size_c * error + error * error + 4.0 * ROUNDING * size_a * size_c
    pair_values(y, slip, r, form_slip if symmetric else math.inf, out)


@kernel
def pair_values(y: Any, slip: float, r: Any, form_slip: float, out: Any) -> None:
    """Fill ``out`` from Y, whose eigenvalues are (x - 2) / 4, and the form R with which it is self-adjoint.

    ``slip`` and ``form_slip`` are their errors in the Frobenius norm.
    """
    # Eigenvalues of a 2 x 2 matrix: mean +- sqrt(square), square = ((Y_11 - Y_22) / 2)^2 + Y_12 Y_21, and x = 2 + 4 y.
    # Errors go the same way: ``slope`` bounds how fast ``square`` changes with Y, ``square_slip`` its error, and the
    # error of the root is that over twice the root, or the root of the error where the sign of ``square`` is not known.
    # Y is self-adjoint in R, so that u^T R u of a real eigenvector u has the pair's Krein sign; it is given where it
    # exceeds its error, which ``turn`` carries, the angle by which u may be off.
    largest = max(max(abs(y[0, 0]), abs(y[0, 1])), max(abs(y[1, 0]), abs(y[1, 1])))
    unit = 1.0
    if 1e100 < largest < math.inf:  # its square would overflow
        unit = 2.0 ** math.floor(np.log2(largest))
        slip /= unit
        for row in range(2):
            for column in range(2):
                y[row, column] /= unit
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
        out[2 * j] = 2.0 + unit * 4.0 * (mean + (sign * root if square > 0.0 else 0.0))
        out[2 * j + 1] = 0.0 if square > 0.0 else unit * 4.0 * sign * root
        out[4 + j] = unit * error
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
