"""Maps over equal segments of a period of x' = A(t) x, with error bounds, over arrays of systems."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import compiled, kernel, over_chunks
from floquetrod.kernels.system_series import (
    MOST_TERMS,
    ROUNDING,
    chain_error,
    coefficient_bound,
    invert,
    multiply,
    plan_terms,
    reach,
    spectral_bound,
)

Floats = NDArray[np.float64]

_LONGEST = 2.5
"""Phase a series is used for at most, to either side: beyond it rounding grows and little is saved (heuristic)."""

_PLAIN_UP_TO = 64
"""Multiplications a term of the past may take before BLAS is called for them (heuristic)."""


class SegmentMaps(NamedTuple):
    """Maps over equal segments of a period, the first acting first.

    Attributes
    ----------
    maps : numpy.ndarray, (b, S, N, N)
        x at the end of a segment from x at its beginning.
    errors : numpy.ndarray, (b, S)
        Bounds of the Frobenius norm of D^-1 (map - true map) D, D = diag(scaling).
    scaling : numpy.ndarray, (b, N)
        Powers of two that balance the rows and columns of A.
    """

    maps: Floats
    errors: Floats
    scaling: Floats


class Monodromy(NamedTuple):
    """Maps over a whole period (b, N, N), errors (b,) and scaling (b, N) with the meaning of `SegmentMaps`."""

    matrix: Floats
    error: Floats
    scaling: Floats


def segment_maps(
    mean: Any, harmonics: Any, period: Any, accuracy: float = 1e-12, least_segments: int = 1, workers: int | None = 1
) -> SegmentMaps:
    """Return the maps of x' = A(t) x over ``least_segments`` equal parts of a period.

    A(t) = mean + Re sum_k Z_k exp(i k w t), k = 1..H, w = 2 pi / period.  Each part is crossed in as many steps as the
    accuracy asks for, each a Taylor series about its centre used to both sides.

    Parameters
    ----------
    mean : array_like, (b, N, N)
        The mean of A, real.
    harmonics : array_like, (b, H, N, N)
        Z_k, complex; H may be 0.
    period : array_like, (b,)
        The period, positive.
    accuracy : float
        The error aimed at, in the balanced norm of `SegmentMaps` and relative to a map of norm 1.  What was reached
        is in ``errors``.
    least_segments : int
        The number of maps S, at least 1.
    workers : int or None
        Threads; None for all cores.

    Returns
    -------
    SegmentMaps
        The truncation is bounded rigorously from the computed terms, the rounding estimated to first order.
    """
    mean = np.array(mean, dtype=float, order="C")
    harmonics = np.asarray(harmonics, dtype=complex)
    batch, n = mean.shape[:2]
    size = n * n
    out = np.empty((batch, least_segments * (size + 1) + n))
    inputs = (mean, harmonics.real.copy(), harmonics.imag.copy(), np.array(period, dtype=float, order="C"))
    chunk = max(1, 100000 // (size * n * least_segments))
    constants = (least_segments, accuracy, min(0.5 * reach(accuracy), _LONGEST))
    if batch == 1:
        compiled(segment_fill)(*inputs, out, *constants)  # the shortest way for a single system
    else:
        over_chunks(segment_fill, inputs, out, *constants, workers=workers, chunk=chunk, interpret_up_to=0)
    maps = out[:, : least_segments * size].reshape(batch, least_segments, n, n)
    return SegmentMaps(maps, out[:, least_segments * size : -n], out[:, -n:])


def product(segments: SegmentMaps) -> Monodromy:
    """Return the product of the maps of all segments of a period, with its error."""
    batch, _, n = segments.maps.shape[:3]
    out = np.empty((batch, n * n + 1))
    maps, errors, scaling = (np.array(value, dtype=float, order="C") for value in segments)
    compiled(product_fill)(maps, errors, scaling, out)
    return Monodromy(out[:, :-1].reshape(batch, n, n), out[:, -1], segments.scaling)


@kernel
def segment_fill(
    mean: Any, real: Any, imag: Any, period: Any, out: Any, segments: int, accuracy: float, reach: float
) -> None:
    """Fill rows of ``out`` with the maps of all segments, their errors and the scaling."""
    for b in range(len(out)):
        n, count = len(mean[b]), len(real[b])
        a = np.empty((1 + 2 * count, n, n))
        for i in range(n):
            for j in range(n):
                a[0, i, j] = mean[b][i][j]
                for k in range(count):
                    a[1 + k, i, j] = real[b][k][i][j]
                    a[1 + count + k, i, j] = imag[b][k][i][j]
        scaling = np.ones(n)
        balance_matrices(a, scaling)
        segment_row(a, count, period[b], segments, accuracy, reach, scaling, out[b])


@kernel
def balance_matrices(a: Any, scaling: Any) -> None:
    """Replace a (m, N, N) by D^-1 a D, D = diag(scaling), powers of two that make rows and columns equally large."""
    count, n = a.shape[0], a.shape[1]
    for _ in range(10):
        changed = False
        for i in range(n):
            row, column = 0.0, 0.0
            for k in range(count):
                for j in range(n):
                    if j != i:
                        row += abs(a[k, i, j])
                        column += abs(a[k, j, i])
            if row == 0.0 or column == 0.0:
                continue
            factor = 2.0 ** math.floor(0.5 * math.log2(row / column) + 0.5)
            if factor == 1.0:
                continue
            changed = True
            scaling[i] *= factor
            for k in range(count):
                for j in range(n):
                    if j != i:
                        a[k, i, j] /= factor
                        a[k, j, i] *= factor
        if not changed:
            break


@kernel
def is_companion(a: Any) -> bool:
    """Say whether the upper half of all matrices is that of q' = E p, E diagonal and constant."""
    count, n = a.shape[0], a.shape[1]
    half = n // 2
    if n % 2 == 1:
        return False
    for k in range(count):
        for i in range(half):
            for j in range(n):
                if a[k, i, j] != 0.0 and (k > 0 or j != half + i):
                    return False
    return True


@kernel
def part_matrices(a: Any, used: int, top: int, left: int, right: int) -> tuple[Any, Any, Any]:
    """Return the nonzero matrices that act on rows left..right of x, transposed, their numbers and their norms.

    Rows ``top`` and below of the result are kept.  The mean comes first, whether zero or not.
    """
    count, n = (a.shape[0] - 1) // 2, a.shape[1]
    rows, width = n - top, right - left
    kept = np.zeros(1 + 2 * used, dtype=np.int64)
    groups = 1
    for g in range(1, 1 + 2 * used):
        place = g if g <= used else g - used + count
        if np.any(a[place, top:, left:right] != 0.0):
            kept[groups] = g
            groups += 1
    matrices = np.empty((groups, width * rows))
    norms = np.empty(groups)
    for g in range(groups):
        place = kept[g] if kept[g] <= used else kept[g] - used + count
        norms[g] = spectral_bound(a[place, top:, left:right])
        for j in range(width):
            for r in range(rows):
                matrices[g, j * rows + r] = a[place, top + r, left + j]
    return kept[:groups].copy(), matrices, norms


@kernel
def part_lags(kept: Any, norms: Any, used: int, angle: float, order: int, tolerance: float) -> tuple[int, float]:
    """Return how many terms of the past matter, and the error of leaving out those before: the integral of a norm.

    ``angle`` is w h; times and rates are in units of h.
    """
    powers = norms[1:].copy()
    for lag in range(1, order + 1):
        left = 0.0
        for g in range(len(powers)):
            rate = angle * ((kept[1 + g] - 1) % used + 1)
            powers[g] *= rate / lag
            quotient = rate / (lag + 1.0)
            left += powers[g] / (1.0 - quotient) if quotient < 0.7 else math.inf
        if len(powers) == 0 or left / (lag + 1.0) < tolerance:
            return lag, left / (lag + 1.0)
    return order, 0.0


@kernel
def part_weights(kept: Any, used: int, lags: int, angle: float, place: int, whole: int, c: Any) -> None:
    """Set c[lag, g]: Taylor coefficients of the factors of the matrices, about ``place`` / ``whole`` of a period."""
    c[:] = 0.0
    c[0, 0] = 1.0
    for g in range(1, len(kept)):
        k = (kept[g] - 1) % used + 1
        turn = 2.0 * math.pi * (k * place % whole) / whole
        value, other = math.cos(turn), -math.sin(turn)
        if kept[g] > used:
            value, other = other, -value
        for lag in range(lags):
            c[lag, g] = value
            value, other = other * k * angle / (lag + 1.0), -value * k * angle / (lag + 1.0)


@kernel
def apply_part(
    x: Any, last: int, lags: int, c: Any, matrices: Any, table: Any, direct: bool, mixed: Any, rows: int, n: int,
    out: Any,
) -> None:  # fmt: skip
    """Set out (rows, n) to a coefficient of A x, from the terms of x that begin with number ``last`` of its array."""
    width = x.shape[1] // n
    if direct and width * rows * n <= _PLAIN_UP_TO:
        for r in range(rows):
            for q in range(n):
                out[r, q] = 0.0
        for lag in range(lags):
            for j in range(width):
                for r in range(rows):
                    factor = table[lag, j * rows + r]
                    for q in range(n):
                        out[r, q] += factor * x[last + lag, j * n + q]
    elif direct:
        past = x[last : last + lags].reshape(lags * width, n)
        np.dot(table[:lags].reshape(lags * width, rows).T, past, out)
    else:
        np.dot(c[:lags].T, x[last : last + lags], mixed)
        groups = len(matrices)
        np.dot(matrices.reshape(groups * width, rows).T, mixed.reshape(groups * width, n), out)


@kernel
def segment_row(
    a: Any, count: int, period: float, segments: int, accuracy: float, reach: float, scaling: Any, out: Any
) -> None:
    """Fill one row of `segment_fill` from the balanced matrices: mean, real parts, imaginary parts."""
    n = a.shape[1]
    omega = 2.0 * math.pi / period
    norms = np.empty(count)
    for k in range(count):
        one, two = spectral_bound(a[1 + k]), spectral_bound(a[1 + count + k])
        norms[k] = math.sqrt(one * one + two * two)
    size = spectral_bound(a[0])
    # Harmonics too small to matter are an error of A.
    used, dropped = count, 0.0
    while used > 0 and (dropped + norms[used - 1]) * period < 0.003 * accuracy * segments:
        used -= 1
        dropped += norms[used]
    norms = norms[:used].copy()
    least = coefficient_bound(size, norms, 1, 0.0)
    steps = max(1, math.ceil(0.5 * period / segments * least / reach))
    while True:
        h = 0.5 * period / (segments * steps)
        phase = 0.5 * h * (least + coefficient_bound(size, norms, 1, omega * h))
        if phase <= reach:
            needed, ratio, _ = plan_terms(size, norms, 1, omega, h, math.log(0.1 * accuracy), False)
            if needed <= 2.0 * MOST_TERMS - 4.0:
                break
        steps += 1
    order = max(int(needed) + 1, 4)
    highest = used * omega * h
    tries = 0
    while True:  # the largest radius `tail` may use; both parts of a harmonic together are sqrt(2) times larger
        there = max(ratio * h * 1.4143 * coefficient_bound(size, norms, 1, omega * h * ratio), 1e-3)
        quotient = (order + 1.0) / there
        if quotient >= 1.0 and (quotient < 1.1 or tries > 8 or ratio > 1e4):
            break
        tries += 1
        ratio *= quotient ** (1.0 / (1.0 + highest * ratio)) * (0.98 if quotient < 1.0 else 1.0)
        if ratio < 1.3:
            ratio = 1.3
            order += 1
    maps, errors = np.empty((steps, n, n)), np.empty(steps)
    total = np.empty((n, n))
    work = series_work(a, used, omega * h, order, 0.003 * accuracy / h * math.exp(-phase))
    for segment in range(segments):
        for step in range(steps):
            place = 2 * (segment * steps + step) + 1
            errors[step] = step_map(
                work, used, omega * h, h, place, 2 * segments * steps, order, ratio, phase, dropped, maps[step]
            )
        error = chain_error(maps, errors, total) if steps > 1 else errors[0]
        result = total if steps > 1 else maps[0]
        for i in range(n):
            for j in range(n):
                out[(segment * n + i) * n + j] = result[i, j] * scaling[i] / scaling[j]
        out[segments * n * n + segment] = error
    for i in range(n):
        out[segments * (n * n + 1) + i] = scaling[i]


@kernel
def part_work(a: Any, used: int, top: int, left: int, right: int, angle: float, order: int, tolerance: float) -> Any:
    """Return what `step_map` keeps of rows left..right of x: terms, last first, matrices, weights, tables, lags."""
    n = a.shape[1]
    kept, matrices, norms = part_matrices(a, used, top, left, right)
    lags, left_out = part_lags(kept, norms, used, angle, order, tolerance)
    groups = len(kept)
    # A table of the Taylor coefficients of A, or the terms mixed first: whichever takes fewer multiplications.
    direct = lags * (n - top) <= groups * (lags + n - top)
    x = np.empty((order + 1, (right - left) * n))
    table = np.empty((lags if direct else 0, (right - left) * (n - top)))
    mixed = np.empty((0 if direct else groups, (right - left) * n))
    return x, kept, matrices, np.empty((lags, groups)), table, mixed, lags, left_out, direct


@kernel
def series_work(a: Any, used: int, angle: float, order: int, tolerance: float) -> Any:
    """Return the work of `step_map`: both halves of x, the factors of q' = E p where A has this form, and the rest."""
    n = a.shape[1]
    half = max(n // 2, 1)
    companion = is_companion(a)
    top = half if companion else 0
    upper = part_work(a, used, top, 0, half, angle, order, tolerance)
    lower = part_work(a, used, top, half, n, angle, order, tolerance)
    rates = np.zeros(top)
    for i in range(top):
        rates[i] = a[0, i, top + i]
    rows = n - top
    return upper, lower, rates, np.empty((2, rows, n)), np.empty((2, order + 1)), np.empty((3, n, n))


@kernel
def step_map(
    work: Any, used: int, angle: float, h: float, place: int, whole: int, order: int, ratio: float, phase: float,
    dropped: float, result: Any,
) -> float:  # fmt: skip
    """Set ``result`` to the map from h before to h after a centre, ``place`` / ``whole`` of a period; return its error.

    The solution that is the identity at the centre is summed to both sides.
    """
    upper, lower, rates, force, signs, sides = work
    x, kept_x, matrices_x, c_x, table_x, mixed_x, lags_x, left_x, direct_x = upper
    z, kept_z, matrices_z, c_z, table_z, mixed_z, lags_z, left_z, direct_z = lower
    n, top = sides.shape[1], len(rates)
    half, rows = max(n // 2, 1), n - top
    part_weights(kept_x, used, lags_x, angle, place, whole, c_x)
    if direct_x:
        np.dot(c_x, matrices_x, table_x)
    if half < n:
        part_weights(kept_z, used, lags_z, angle, place, whole, c_z)
        if direct_z:
            np.dot(c_z, matrices_z, table_z)
    x[order] = 0.0
    z[order] = 0.0
    for r in range(n):
        if r < half:
            x[order, r * n + r] = 1.0
        else:
            z[order, (r - half) * n + r] = 1.0
    one, two = force[0], force[1]
    for i in range(order):
        last = order - i
        factor = h / (i + 1.0)
        apply_part(x, last, min(lags_x, i + 1), c_x, matrices_x, table_x, direct_x, mixed_x, rows, n, one)
        if half < n:
            apply_part(z, last, min(lags_z, i + 1), c_z, matrices_z, table_z, direct_z, mixed_z, rows, n, two)
            one += two
        for r in range(top):
            rate = factor * rates[r]
            for q in range(n):
                x[last - 1, r * n + q] = rate * z[last, r * n + q]
        for r in range(rows):
            if top + r < half:
                for q in range(n):
                    x[last - 1, r * n + q] = factor * one[r, q]
            else:
                start = (top + r - half) * n
                for q in range(n):
                    z[last - 1, start + q] = factor * one[r, q]
    rest, size, shrink = 0.0, 0.0, ratio**-2.0
    for i in range(order + 1):
        square = np.dot(x[order - i], x[order - i])
        if half < n:
            square += np.dot(z[order - i], z[order - i])
        rest = shrink * (rest + square)
        size += math.sqrt(square)
        signs[0, i] = 1.0
        signs[1, i] = -1.0 if (order - i) % 2 == 1 else 1.0
    ends = np.dot(signs, x[: order + 1])
    sides[0, :half] = ends[0].copy().reshape(half, n)
    sides[1, :half] = ends[1].copy().reshape(half, n)
    if half < n:
        ends = np.dot(signs, z[: order + 1])
        sides[0, half:] = ends[0].copy().reshape(n - half, n)
        sides[1, half:] = ends[1].copy().reshape(n - half, n)
    # Rounding: each term is a sum of products, and carried on by those after it.
    length = math.sqrt(1.0 * lags_x * half + lags_z * (n - half))
    error = math.sqrt(rest) / (1.0 - 1.0 / ratio) + ROUNDING * (6.0 + length) * (1.0 + phase) * size
    error += (dropped + left_x + left_z) * h * math.exp(phase) * math.sqrt(1.0 * n)
    forth, size_back = spectral_bound(sides[0]), spectral_bound(sides[1])
    invert(sides[1], sides[2])
    multiply(sides[0], sides[2], result)
    inverse = spectral_bound(sides[2])
    slip = error + ROUNDING * 4.0 * n * size_back
    slip *= inverse * inverse / (1.0 - inverse * slip) if inverse * slip < 0.5 else math.inf
    return float(error * (inverse + slip) + forth * slip + ROUNDING * (n + 2.0) * forth * inverse)


@kernel
def product_fill(maps: Any, errors: Any, scaling: Any, out: Any) -> None:
    """Fill rows of ``out`` with the product of maps, and its error."""
    for b in range(len(out)):
        count, n = len(maps[b]), len(scaling[b])
        scaled, total = np.empty((count, n, n)), np.empty((n, n))
        wrong = np.empty(count)
        for k in range(count):
            wrong[k] = errors[b][k]
            for i in range(n):
                for j in range(n):
                    scaled[k, i, j] = maps[b][k][i][j] * scaling[b][j] / scaling[b][i]
        out[b, n * n] = chain_error(scaled, wrong, total)
        for i in range(n):
            for j in range(n):
                out[b, i * n + j] = total[i, j] * scaling[b][i] / scaling[b][j]
