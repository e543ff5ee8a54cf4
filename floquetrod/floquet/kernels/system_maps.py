"""Maps over equal segments of a period of x' = A(t) x, with error bounds, over arrays of systems."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.compilation import kernel, over_chunks, runner
from floquetrod.floquet.kernels.system_maps_steps import series_work, step_map
from floquetrod.floquet.kernels.system_series import (
    MOST_NUMBERS,
    MOST_TERMS,
    chain_error,
    coefficient_bound,
    plan_segments,
    reach,
    run_of,
    spectral_bound,
    usable,
)

_LONGEST = 2.5
"""Phase a series is used for at most, to either side: beyond it rounding grows and little is saved (heuristic)."""

_COMPILE_AFTER = 1000.0
"""Milliseconds, as estimated, for which a process interprets the kernel before it is compiled (heuristic)."""


class SegmentMaps(NamedTuple):
    """Maps over equal segments of a period, the first acting first."""

    maps: Floats  # (b, S, N, N), x at the end of a segment from x at its beginning
    errors: Floats  # (b, S), bounds of the Frobenius norm of D^-1 (map - true map) D, D = diag(scaling)
    scaling: Floats  # (b, N), powers of two that balance the rows and columns of A


class Monodromy(NamedTuple):
    """Maps over a whole period (b, N, N), errors (b,) and scaling (b, N) with the meaning of `SegmentMaps`."""

    matrix: Floats
    error: Floats
    scaling: Floats


def segment_maps(
    mean: Any,
    harmonics: Any,
    period: Any,
    accuracy: float = 1e-12,
    least_segments: int = 1,
    workers: int | None = 1,
    slope: Any = None,
    length: Any = None,
) -> SegmentMaps:
    """Return the maps of x' = A(t) x over ``least_segments`` equal parts of a period, or of what begins with t = 0.

    A(t) = mean + slope t + Re sum_k Z_k exp(i k w t), k = 1..H, w = 2 pi / period.  Each part is crossed in as many
    steps as the accuracy asks for, each a Taylor series about its centre used to both sides.

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
    slope : array_like, (b, N, N), optional
        None by default.
    length : array_like, (b,), optional
        How long, the period by default; harmonics turn by no more than a whole turn in it.

    Returns
    -------
    SegmentMaps
        The truncation is bounded rigorously from the computed terms, the rounding estimated to first order.
    """
    mean = np.array(mean, dtype=float, order="C")
    harmonics = np.array(harmonics, dtype=complex)
    period = np.array(period, dtype=float, order="C")
    batch, n = mean.shape[:2]
    lost = ~usable(mean, harmonics, period)
    slope = np.empty((batch, 0, n, n)) if slope is None else np.array(slope, dtype=float, order="C")[:, None]
    length = period if length is None else np.array(length, dtype=float, order="C")
    if length is not period:
        lost |= ~usable(mean, slope, length)
    if lost.any():
        mean[lost], harmonics[lost], slope[lost], period[lost], length[lost] = 0.0, 0.0, 0.0, 1.0, 1.0
    size = n * n
    out = np.empty((batch, least_segments * (size + 1) + n))
    inputs = (mean, harmonics.real.copy(), harmonics.imag.copy(), slope, period, length)
    chunk = max(1, 100000 // (size * n * least_segments))
    constants = (least_segments, accuracy, min(0.5 * reach(accuracy), _LONGEST))
    run = run_of(segment_fill, _COMPILE_AFTER, lambda: _milliseconds(mean, harmonics, length, least_segments))
    if run is segment_fill:
        # Plain floats are faster than numpy's.
        arguments: list[Any] = [*(array.tolist() for array in inputs), out, *constants]
        with np.errstate(all="ignore"):  # as machine code does
            run(*arguments)
    elif batch == 1:
        run(*inputs, out, *constants)  # the shortest way for a single system
    else:
        over_chunks(segment_fill, inputs, out, *constants, workers=workers, chunk=chunk, interpret_up_to=0)
    if lost.any():
        out[lost, : least_segments * size], out[lost, least_segments * size : -n] = math.nan, math.inf
    maps = out[:, : least_segments * size].reshape(batch, least_segments, n, n)
    return SegmentMaps(maps, out[:, least_segments * size : -n], out[:, -n:])


def product(segments: SegmentMaps) -> Monodromy:
    """Return the product of the maps of all segments of a period, with its error."""
    batch, count, n = segments.maps.shape[:3]
    if count == 1:
        return Monodromy(segments.maps[:, 0], segments.errors[:, 0], segments.scaling)
    out = np.empty((batch, n * n + 1))
    maps, errors, scaling = (np.array(value, dtype=float, order="C") for value in segments)
    with np.errstate(all="ignore"):  # interpreted, as machine code does
        runner(product_fill, batch * maps.shape[1], interpret_up_to=4, compile_after=100)(maps, errors, scaling, out)
    return Monodromy(out[:, :-1].reshape(batch, n, n), out[:, -1], segments.scaling)


def _milliseconds(mean: Floats, harmonics: Any, length: Floats, segments: int) -> float:
    """Return about how many milliseconds the interpreted kernel takes (measured)."""
    batch, n = mean.shape[:2]
    with np.errstate(over="ignore"):
        size = np.abs(mean).sum(axis=(1, 2)) + np.abs(harmonics).sum(axis=(1, 2, 3))
        phases = float(np.minimum(length * size / math.sqrt(n), 1e6).sum())
    more = max(0, harmonics.shape[1] - 1)
    return float(batch * (5.0 + 2.0 * segments) + phases * (0.1 + n * n / 400.0 + 0.08 * more))


@kernel
def segment_fill(
    mean: Any, real: Any, imag: Any, slope: Any, period: Any, length: Any, out: Any, segments: int, accuracy: float,
    reach: float,
) -> None:  # fmt: skip
    """Fill rows of ``out`` with the maps of all segments, their errors and the scaling."""
    # x' = (mean + sum_k Re, Im of the waves + slope t) x, one system of the batch after another: a[0] is its mean, a[1
    # ...] the cosine, then the sine amplitudes, a[-1] the slope where there is one, all in balanced coordinates
    # (``scaling``). A segment is ``steps`` Taylor steps from h before to h after a centre (`step_map`); their product,
    # with the bound of its error, is a row of ``out``: the maps (segments, n, n), an error for each, and the scaling.
    # Segments are not multiplied here: the cyclic method keeps decades that the product would lose.
    for b in range(len(out)):
        n, count, sloped = len(mean[b]), len(real[b]), len(slope[b])
        a = np.empty((1 + 2 * count + sloped, n, n))
        for i in range(n):
            for j in range(n):
                a[0, i, j] = mean[b][i][j]
                for k in range(count):
                    a[1 + k, i, j] = real[b][k][i][j]
                    a[1 + count + k, i, j] = imag[b][k][i][j]
                for k in range(sloped):
                    a[1 + 2 * count, i, j] = slope[b][k][i][j]
        scaling = np.ones(n)
        balance_matrices(a, scaling)
        for i in range(n):
            out[b, segments * (n * n + 1) + i] = scaling[i]
        steps, used, dropped, order, ratio, phase = segment_plan(
            a, count, period[b], length[b], segments, accuracy, reach
        )
        if steps == 0:
            for i in range(segments * n * n):
                out[b, i] = math.nan
            for i in range(segments):
                out[b, segments * n * n + i] = math.inf
            continue
        h = 0.5 * length[b] / (segments * steps)
        angle = 2.0 * math.pi / period[b] * h
        whole = 2.0 * segments * steps * (period[b] / length[b])
        maps, errors = np.empty((steps, n, n)), np.empty(steps)
        total = np.empty((n, n))
        work = series_work(a, used, angle, h, order, 0.003 * accuracy / h * math.exp(-phase))
        for segment in range(segments):
            for step in range(steps):
                place = 2 * (segment * steps + step) + 1
                errors[step] = step_map(work, used, angle, h, place, whole, order, ratio, phase, dropped, maps[step])
            error = chain_error(maps, errors, total) if steps > 1 else errors[0]
            result = total if steps > 1 else maps[0]
            for i in range(n):
                for j in range(n):
                    out[b, (segment * n + i) * n + j] = result[i, j] * scaling[i] / scaling[j]
            out[b, segments * n * n + segment] = error


@kernel
def balance_matrices(a: Any, scaling: Any) -> None:
    """Replace a (m, N, N) by D^-1 a D, D = diag(scaling), powers of two that make rows and columns equally large."""
    # Osborne's balancing, by powers of two, which round nothing (B. N. Parlett and C. Reinsch, Numerische Mathematik 13
    # (1969) 293, doi:10.1007/BF02165404), of all coefficient matrices of A(t) at once, since one D serves all times.
    # Row i sums |a_ij|, column i |a_ji|, j != i; D_i = sqrt(row / column) makes both equal.  Each i changes the sums of
    # all others: sweeps go on until none changes, ten at most.
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
            quotient = row / column
            if not 1e-300 < quotient < 1e300:
                continue
            factor = 2.0 ** math.floor(0.5 * np.log2(quotient) + 0.5)  # numba 0.59 has no math.log2
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
def segment_plan(
    a: Any, count: int, period: float, length: float, segments: int, accuracy: float, reach: float
) -> tuple[int, int, float, int, float, float]:
    """Return (steps of a segment, harmonics used, size of those dropped, order, ratio, phase); no steps if too many.

    A slope S is bounded like a harmonic: S (length + r) <= S length + S / v cosh(v r) at a distance r from the real
    times, for any v; here a multiple of w, four or more over the length.
    """
    # Steps are as long as two limits allow: the phase, beyond which the sum of a series loses digits to cancellation,
    # and Cauchy's estimate of the remainder, whose order and radius `plan_segments` chooses (A. Jorba and M. Zou,
    # Experimental Mathematics 14 (2005) 99).  ``norms`` bound the harmonics, the last of them dropped where their
    # integral over the period is below a share of the accuracy; a slope enters as a part of the mean and a harmonic of
    # ``ramp`` times w.
    n = a.shape[1]
    omega = 2.0 * math.pi / period
    norms = np.empty(count)
    for k in range(count):
        one, two = spectral_bound(a[1 + k]), spectral_bound(a[1 + count + k])
        norms[k] = math.sqrt(one * one + two * two)
    size = spectral_bound(a[0])
    # Harmonics too small to matter are an error of A.
    used, dropped = count, 0.0
    while used > 0 and (dropped + norms[used - 1]) * length < 0.003 * accuracy * segments:
        used -= 1
        dropped += norms[used]
    slope = spectral_bound(a[len(a) - 1]) if len(a) > 1 + 2 * count else 0.0
    ramp = math.ceil(4.0 / (omega * length)) if slope > 0.0 else 0
    bounds = np.zeros(max(used, ramp))
    for k in range(used):
        bounds[k] = norms[k]
    if slope > 0.0:
        size += slope * length
        bounds[ramp - 1] += slope / (ramp * omega)
    norms = bounds
    least = coefficient_bound(size, norms, 1, 0.0)
    room = MOST_NUMBERS / (n * n)
    steps, order, ratio, phase = 0, 0, 0.0, 0.0
    if 0.5 * length * least <= room * segments * reach:
        steps = max(1, math.ceil(0.5 * length / segments * least / reach))
        steps, order, ratio, phase = plan_segments(
            size, norms, 1, omega, 0.5 * length / segments, steps, 0.1 * accuracy, reach, 2 * MOST_TERMS - 4, False
        )
    if steps > room:
        steps = 0
    return steps, used, dropped, order, ratio, phase


@kernel
def product_fill(maps: Any, errors: Any, scaling: Any, out: Any) -> None:
    """Fill rows of ``out`` with the product of maps, and its error."""
    # Maps (count, n, n) go to balanced coordinates, D^-1 M D, in which their errors are given; `chain_error` multiplies
    # them there, the first acting first, and the product goes back.  A row of ``out`` is the product by rows, then its
    # error.
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
