"""Kernels for u'' + K u = 0, one or two equations, K constant and symmetric on each piece: maps in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod._util.compilation import kernel, over_chunks
from floquetrod.floquet.kernels.system_series import chain_error

_FARTHEST = 300.0
"""Logarithm of the growth over a piece up to which its map is computed: products of two stay in range (a choice)."""

_LARGEST_PHASE = 1e8
"""Phase of a piece up to which its map is computed: half the digits of a double are left (a choice)."""


def piece_pairs(stiffness: Floats, length: Floats, uncertainty: Floats) -> tuple[Complexes, Floats]:
    """Return y = (mu + 1/mu - 2) / 4 of all pairs of multipliers, and bounds of their errors, (b, n) each.

    Parameters
    ----------
    stiffness : numpy.ndarray, (b, P, n, n)
        K on each piece, symmetric; n is 1 or 2.
    length : numpy.ndarray, (b, P)
        Durations of the pieces.
    uncertainty : numpy.ndarray, (b,)
        Error of K in the 2-norm.

    Returns
    -------
    y : numpy.ndarray, (b, n), complex
        Real, or a complex pair; NaN where a map is not computed.
    errors : numpy.ndarray, (b, n)
        Infinite where a piece has too large a phase or growth.
    """
    n = stiffness.shape[-1]
    out = np.empty((len(length), 3 * n))
    over_chunks(piece_pairs_fill, (stiffness, length, uncertainty), out, workers=1)
    y = np.empty((len(length), n), dtype=np.complex128)
    y.real, y.imag = out[:, :n], out[:, n : 2 * n]
    return y, out[:, 2 * n :]


@kernel
def piece_pairs_fill(stiffness: Any, length: Any, uncertainty: Any, out: Any) -> None:
    """Fill rows of ``out`` with Re y, Im y and the error of y of all pairs, y = (mu + 1/mu - 2) / 4.

    Arguments as of `piece_pairs`.
    """
    # Coordinates (u, u' / omega), omega the root of the largest |K| or an inverse period: both drive each other equally
    # there, and the map over a period is the product of those of the pieces.
    count, n = len(length[0]), len(stiffness[0][0])
    maps, errors, total = np.empty((count, 2 * n, 2 * n)), np.empty(count), np.empty((2 * n, 2 * n))
    for b in range(len(out)):
        largest, period = 0.0, 0.0
        for j in range(count):
            period += length[b][j]
            for r in range(n):
                for q in range(n):
                    largest = max(largest, abs(stiffness[b][j][r][q]))
        omega = max(math.sqrt(n * largest), 1.0 / period)
        error = 0.0
        for j in range(count):
            errors[j] = piece_map(stiffness[b][j], length[b][j], omega, uncertainty[b], maps[j])
            error += errors[j]
        if not error < math.inf:
            for i in range(n):
                out[b, i], out[b, n + i], out[b, 2 * n + i] = math.nan, math.nan, math.inf
            continue
        pairs_of_map(total, chain_error(maps, errors, total), out[b])


@kernel
def piece_map(stiffness: Any, length: float, omega: float, uncertainty: float, out: Any) -> float:
    """Set ``out`` to the map of u'' + K u = 0 over a length in coordinates (u, u' / omega); return its error.

    The error is in the Frobenius norm; infinite where growth or phase are too large.
    """
    # K = Q diag(k) Q^T by one rotation of Jacobi.  Of u'' + k u = 0 the map is [[c, s], [-k s / omega^2, c]], c =
    # cos(sqrt(k) h), s = omega sin(sqrt(k) h) / sqrt(k), hyperbolic for k < 0; |map| <= wide exp(sqrt(-k) h).
    n = len(stiffness)
    k, c, s = np.empty(2), np.empty(2), np.empty(2)
    k[0], cosine, sine, size = stiffness[0][0], 1.0, 0.0, abs(stiffness[0][0])
    if n == 2:
        coupling, k[1] = stiffness[0][1], stiffness[1][1]
        size = math.sqrt(k[0] * k[0] + k[1] * k[1] + 2.0 * coupling * coupling)
        if coupling != 0.0:
            half = 0.5 * (k[1] - k[0])
            tangent = coupling / (abs(half) + math.hypot(half, coupling))
            tangent = -tangent if half < 0.0 else tangent
            cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
            sine = tangent * cosine
            k[0] -= tangent * coupling
            k[1] += tangent * coupling
    wide, growth = 2.0, 0.0
    for i in range(n):
        root = math.sqrt(abs(k[i]))
        phase = root * length
        if not phase < (_LARGEST_PHASE if k[i] > 0.0 else _FARTHEST):
            return math.inf
        if k[i] > 0.0:
            c[i], s[i] = math.cos(phase), omega * math.sin(phase) / root
        elif k[i] < 0.0:
            c[i], s[i] = math.cosh(phase), omega * math.sinh(phase) / root
            growth = max(growth, phase)
        else:
            c[i], s[i] = 1.0, omega * length
        wide = max(wide, 1.0 + (omega * length if phase < 1.0 else omega / root))
    square = 0.0
    for r in range(n):
        for q in range(n):
            even, upper, lower = 0.0, 0.0, 0.0
            for i in range(n):
                weight = (cosine if r == i else (sine if i == 1 else -sine)) * (
                    cosine if q == i else (sine if i == 1 else -sine)
                )
                even += weight * c[i]
                upper += weight * s[i]
                lower -= weight * (k[i] / omega / omega) * s[i]
            out[r, q], out[n + r, n + q], out[r, n + q], out[n + r, q] = even, even, upper, lower
            square += 2.0 * even * even + upper * upper + lower * lower
    # Rotation, eigenvalues and their roots are exact for a K off by 16 roundings, beside its own uncertainty; a change
    # dA of A = [[0, omega], [-K / omega, 0]] changes the map by wide exp(growth) (exp(wide |dA| h) - 1) at most.  Then
    # the rounding of h, of the functions and of the products with Q.
    slip = wide * (length / omega) * (16.0 * EPS * size + uncertainty)
    if not slip < 1.0:
        return math.inf
    return wide * math.exp(growth) * math.expm1(slip) + EPS * (omega * length + 24.0) * math.sqrt(square)


@kernel
def pairs_of_map(total: Any, error: float, out: Any) -> None:
    """Fill a row of `piece_pairs_fill` from a symplectic map over a period and its error in the Frobenius norm."""
    # x = mu + 1 / mu: of one equation the trace a; of two the roots of x^2 - a x + b - 2, b the sum of the principal
    # minors of order two, as the characteristic polynomial is mu^4 - a mu^3 + b mu^2 - a mu + 1.
    n = len(total) // 2
    trace, spread, square, minors, gross = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(2 * n):
        trace += total[i, i]
        spread += abs(total[i, i])
        for j in range(2 * n):
            square += total[i, j] * total[i, j]
            if j > i:
                minors += total[i, i] * total[j, j] - total[i, j] * total[j, i]
                gross += abs(total[i, i] * total[j, j]) + abs(total[i, j] * total[j, i])
    # |tr dM| <= sqrt(2 n) |dM|; b = (tr^2 M - tr M^2) / 2 changes by (2 |tr M| + |M|) |dM|, and to second order.
    trace_slip = 2.0 * error + 4.0 * EPS * spread
    if n == 1:
        out[0], out[1], out[2] = 0.25 * (trace - 2.0), 0.0, 0.25 * trace_slip + EPS * (abs(trace) + 2.0)
        return
    slip = (2.0 * abs(trace) + math.sqrt(square) + 3.0 * error) * error + 8.0 * EPS * (gross + 2.0)
    mean = 0.5 * trace
    product = minors - 2.0
    inside = mean * mean - product
    inside_slip = (abs(mean) + 0.25 * trace_slip) * trace_slip + slip + 4.0 * EPS * (mean * mean + abs(product))
    root = math.sqrt(abs(inside))
    # |sqrt(z) - sqrt(z')| is at most |z - z'| / sqrt(z) where z, z' have one sign, and sqrt(|z - z'|) always.
    root_slip = inside_slip / root if abs(inside) > inside_slip else math.sqrt(inside_slip)
    wrong = 0.5 * trace_slip + root_slip + 4.0 * EPS * (abs(mean) + root)
    if not wrong < math.inf:  # the map overflows
        for j in range(2):
            out[j], out[2 + j], out[4 + j] = math.nan, math.nan, math.inf
        return
    if inside > 0.0:
        # Of the smaller root the product of both keeps more digits.
        far = mean + root if mean > 0.0 else mean - root
        near, near_wrong = 2.0 * mean - far, wrong
        if abs(far) > 2.0 * wrong:
            quotient = product / far
            quotient_slip = (slip + abs(quotient) * wrong) / (abs(far) - wrong) + 2.0 * EPS * abs(quotient)
            if quotient_slip < wrong:
                near, near_wrong = quotient, quotient_slip
        out[0], out[1], out[2], out[3] = 0.25 * (far - 2.0), 0.25 * (near - 2.0), 0.0, 0.0
        out[4] = 0.25 * wrong + EPS * (abs(far) + 2.0)
        out[5] = 0.25 * near_wrong + EPS * (abs(near) + 2.0)
        return
    for j in range(2):
        out[j], out[2 + j] = 0.25 * (mean - 2.0), 0.25 * root * (1.0 - 2.0 * j)
        out[4 + j] = 0.25 * wrong + EPS * (abs(mean) + 2.0)
