"""Maps over equal segments of a period of x' = A(t) x, with error bounds, over arrays of systems."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import compiled, kernel, over_chunks
from floquetrod.kernels.system_maps_steps import series_work, step_map
from floquetrod.kernels.system_series import (
    MOST_TERMS,
    chain_error,
    coefficient_bound,
    plan_terms,
    reach,
    spectral_bound,
)

Floats = NDArray[np.float64]

_LONGEST = 2.5
"""Phase a series is used for at most, to either side: beyond it rounding grows and little is saved (heuristic)."""


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
