"""Kernels that carry u'' + K(t) u = 0, K even, over half a period by Taylor series about segment centres.

The first centre is t = 0 and the last is T/2.  K is even about both, so that each solution there has every second
coefficient only, and half as many products of matrices are needed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.floquet.kernels.system_series import (
    MOST_NUMBERS,
    MOST_TERMS,
    ROUNDING,
    chain_error,
    coefficient_bound,
    copy_to,
    invert,
    multiply,
    plan_segments,
    spectral_bound,
    tail,
    weighted_sum,
)


@kernel
def plan(
    size: float, norms: Any, first: int, omega: float, accuracy: float, reach: float, n: int
) -> tuple[int, int, float, float]:
    """Return (segments, terms, ratio, rounding) of a cheap plan.

    A segment reaches h = T / (4 segments) to either side.  ``terms`` powers of h^2 are kept; `tail` may use a radius of
    ``ratio`` h.  ``rounding`` estimates the error of a segment's map in balanced coordinates.  ``segments`` are 0 where
    coefficients are not finite or half a period is too long.
    """
    least = math.sqrt(coefficient_bound(size, norms, first, 0.0))
    if not (0.0 < omega < math.inf and 4.0 * n * n * least <= MOST_NUMBERS * reach * omega):
        return 0, 2, 2.0, math.inf
    quarter = 0.5 * math.pi / omega
    segments = max(1, math.ceil(quarter * least / reach))
    segments, order, ratio, phase = plan_segments(
        size, norms, first, omega, quarter, segments, accuracy, reach, 2 * MOST_TERMS - 2, True
    )
    if segments == 0:
        return 0, 2, 2.0, math.inf
    terms = order // 2 + 1
    bound = coefficient_bound(size, norms, first, omega * quarter / segments)
    forcing = (bound - size) / bound if bound > 0.0 else 0.0
    rounding = ROUNDING * (1.0 + 0.5 * phase) * (4.0 + forcing * (n + 6.0)) * math.cosh(phase)
    return segments, terms, ratio, rounding


@kernel
def workspace(n: int, count: int) -> Any:
    """Return the arrays that `half_period_fill` works in, for n equations of ``count`` amplitudes."""
    length = 4 * n * n
    rows = 2 * MOST_TERMS + 1
    return (
        np.zeros((rows, length)),  # the terms of the series
        np.empty((count + 3, rows)),  # coefficients of each harmonic, and three rows of weights
        np.empty((2, length)),
        np.empty((2, count, n, n)),
        np.empty((2, 2 * n, 2 * n)),
        np.empty(count),
    )


@kernel
def apply_coefficients(
    x: Any, i: int, c: Any, most: int, s: Any, f: Any, first: int, n: int, halves: int, y: Any
) -> None:
    """Set y[1] = s x_i + sum_k F_k sum_l c_kl x_(i-l): a coefficient of K u; x_i are n rows of ``halves`` times 2 n.

    Each half has its own F.
    """
    # (K u)_i of u'' + K u = 0: the past is first mixed by each cosine (`weighted_sum` into y[0]), then multiplied by
    # its F, n^2 products for each column instead of n^2 for each lag.  x[i] is (n rows, halves, 2 n columns) in one
    # line; a harmonic of order 0 is constant and takes the newest term alone.
    width = 2 * n * halves
    for r in range(n):
        factor = s[r]
        for q in range(r * width, (r + 1) * width):
            y[1, q] = factor * x[i, q]
    for k in range(f.shape[1]):
        weighted_sum(x, i, c, k, most if k + first > 0 else 0, n * width, y, 0)
        for half in range(halves):
            for r in range(n):
                start = r * width + half * 2 * n
                for j in range(n):
                    factor = f[half, k, r, j]
                    other = j * width + half * 2 * n
                    for q in range(2 * n):
                        y[1, start + q] += factor * y[0, other + q]


@kernel
def end_maps(
    s: Any, first: int, omega: float, h: float, terms: int, most: int, ratio: float, n: int, g: Any,
    work: Any,
) -> float:  # fmt: skip
    """Fill the maps from 0 to h and from T/2 - h to T/2 (2, 2 n, 2 n), in coordinates balanced by g; return `tail`.

    The amplitudes are those about t = 0, and those about T/2 of the transposed equation.
    """
    # About both ends K is even: x_(i+1) = -h^2 / ((2i+1)(2i+2)) (K x)_i for even solutions, (2i+2)(2i+3) for odd ones,
    # h the reach of a segment, and c[k, l] the Taylor coefficients of cos((k + first) w h t) in t^2. x[i] holds n rows
    # of two ends times 2 n columns, first the even, then the odd solutions; the rest beyond the last term is bounded by
    # `tail`.  y[0] sums values at h, y[1] slopes, smallest terms first; ``ends`` are these in the coordinates balanced
    # by g.  The map of the end T/2 is that of the transposed equation, transposed: it leads from T/2 - h to T/2.
    x, c, y, f, ends, _ = work
    width = 4 * n
    count = f.shape[1]
    for k in range(count):
        angle = (k + first) * omega * h
        value = 1.0
        for i in range(terms):
            c[k, i] = value
            value *= -angle * angle / ((2.0 * i + 1.0) * (2.0 * i + 2.0))
    for q in range(n * width):
        x[0, q] = 0.0
    for r in range(n):
        for block in range(4):
            x[0, r * width + block * n + r] = 1.0
    for i in range(terms - 1):
        apply_coefficients(x, i, c, most, s, f, first, n, 2, y)
        cosine = -h * h / ((2.0 * i + 1.0) * (2.0 * i + 2.0))
        sine = -h * h / ((2.0 * i + 2.0) * (2.0 * i + 3.0))
        for start in range(0, n * width, 2 * n):
            for q in range(n):
                x[i + 1, start + q] = cosine * y[1, start + q]
                x[i + 1, start + n + q] = sine * y[1, start + n + q]
    rest = tail(x, terms - 1, ratio**-4.0, n * width, y)
    for i in range(terms):
        c[count, i] = 1.0
        c[count + 1, i] = 2.0 * (terms - 1 - i)
    for k in range(len(y)):  # a loop, for the sum to be compiled once
        weighted_sum(x, terms - 1, c, count + k, terms, n * width, y, k)
    for r in range(n):
        for j in range(n):
            q = r * width + j
            scale = g[r] / g[j]
            rate = h * g[r] * g[j]
            ends[0, r, j] = y[0, q] * scale
            ends[0, r, n + j] = y[0, q + n] * rate
            ends[0, n + r, j] = y[1, q] / rate
            ends[0, n + r, n + j] = (y[1, q + n] + y[0, q + n]) / scale
            q += 2 * n
            ends[1, n + j, n + r] = y[0, q] * scale
            ends[1, j, n + r] = y[0, q + n] * rate
            ends[1, n + j, r] = y[1, q] / rate
            ends[1, j, r] = (y[1, q + n] + y[0, q + n]) / scale
    return rest


@kernel
def inner_map(
    s: Any, first: int, omega: float, h: float, segment: int, segments: int, terms: int, most: int, ratio: float,
    n: int,    g: Any, symmetric: bool, work: Any, forth: Any, back: Any,
) -> float:  # fmt: skip
    """Set ``forth`` and ``back`` to the maps from a centre t to t + h, and from t - h to t, in balanced coordinates.

    The centre is ``segment`` / ``segments`` of half a period.  Return `tail`.
    """
    # About an inner centre K is not even: x_(i+2) = -h^2 / ((i+1)(i+2)) (K x)_i with all powers i, where the
    # coefficients c[k, l] are those of cos((k + first) w t) about the centre.  x[i] holds n rows of 2 n columns:
    # displacements from unit displacement, then from unit velocity.  One series serves both sides, with the signs of
    # odd powers changed behind the centre; the map from t - h is the inverse of that to t - h, of a symmetric K its
    # symplectic inverse, without divisions. y[0] sums values, y[1] slopes; c[count] and c[count + 1] hold the weights
    # of these sums.
    x, c, y, f, _, _ = work
    width = 2 * n
    order = 2 * terms
    count = f.shape[1]
    for k in range(count):
        # The angle is reduced in whole numbers: no harmonic loses digits.
        angle = math.pi * ((k + first) * segment % (2 * segments)) / segments
        cosine, sine = math.cos(angle), math.sin(angle)
        step = (k + first) * omega * h
        for i in range(order + 1):
            c[k, i] = cosine
            cosine, sine = -sine * step / (i + 1.0), cosine * step / (i + 1.0)
    for q in range(n * width):
        x[0, q] = 0.0
        x[1, q] = 0.0
    for r in range(n):
        x[0, r * width + r] = 1.0
        x[1, r * width + n + r] = 1.0
    for i in range(order - 1):
        apply_coefficients(x, i, c, most, s, f, first, n, 1, y)
        factor = -h * h / ((i + 1.0) * (i + 2.0))
        for q in range(n * width):
            x[i + 2, q] = factor * y[1, q]
    rest = tail(x, order, ratio**-2.0, n * width, y)
    for side in range(2):
        for lag in range(order + 1):
            i = order - lag
            sign = -1.0 if side == 1 and i % 2 == 1 else 1.0
            c[count, lag] = sign
            c[count + 1, lag] = sign * i if side == 0 else -sign * i
        for k in range(len(y)):
            weighted_sum(x, order, c, count + k, order, n * width, y, k)
        target = forth if side == 0 else back
        for r in range(n):
            for j in range(n):
                q = r * width + j
                scale = g[r] / g[j]
                rate = h * g[r] * g[j]
                target[r, j] = y[0, q] * scale
                target[r, n + j] = y[0, q + n] * rate
                target[n + r, j] = y[1, q] / rate
                target[n + r, n + j] = y[1, q + n] / scale
    other = np.empty((width, width))
    copy_to(back, other)
    if symmetric:
        transpose_inverse(other, back)
    else:
        invert(other, back)
    return rest


@kernel
def transpose_inverse(a: Any, out: Any) -> None:
    """Set out to the inverse of a symplectic matrix, [[D^T, -B^T], [-C^T, A^T]]."""
    n = len(a) // 2
    for r in range(n):
        for j in range(n):
            out[j, r] = a[n + r, n + j]
            out[j, n + r] = -a[r, n + j]
            out[n + j, r] = -a[n + r, j]
            out[n + j, n + r] = a[r, j]


@kernel
def balance(s: Any, f: Any, omega: float, g: Any) -> tuple[float, float, float]:
    """Set g to the roots of the rates by which velocities are divided; return max |s| and the extreme rates.

    A NaN among them is returned.  Element by element: assigning arrays takes numba seconds to compile.
    """
    size, slow, fast = 0.0, math.inf, 0.0
    for i in range(len(s)):
        square = abs(s[i]) + 0.0625 * omega * omega
        for k in range(len(f)):
            square += abs(f[k, i, i])
        rate = math.sqrt(square)
        g[i] = math.sqrt(rate)
        if abs(s[i]) > size or math.isnan(s[i]):
            size = abs(s[i])
        if rate < slow or math.isnan(rate):
            slow = rate
        if rate > fast or math.isnan(rate):
            fast = rate
    return size, slow, fast


@kernel
def cut_harmonics(
    norms: Any, first: int, omega: float, h: float, terms: int, slow: float, accuracy: float
) -> tuple[int, float]:
    """Return how many powers of the squared angle the series of the harmonics need, and the error of leaving the rest.

    Those left out are a perturbation of K, too small to matter.
    """
    # cos(k w h x) without its powers from x^2i on is wrong by at most (k w h)^2i / (2i)!, alternating and falling where
    # angle < i: |K| times that, times h / slow, which a perturbation of K amounts to in balanced coordinates, is
    # compared with a small share of the accuracy.
    angle = (len(norms) - 1 + first) * omega * h
    term = 2.0 * coefficient_bound(0.0, norms, first, 0.0) * h / slow
    for i in range(1, terms):
        term *= angle * angle / ((2.0 * i) * (2.0 * i - 1.0))
        if term < 0.003 * accuracy and angle * angle < i * i:
            return i - 1, 2.0 * term
    return terms, 0.0


@kernel
def half_period_fill(
    rates: Any, amplitudes: Any, frequency: Any, out: Any, first: int, accuracy: float, reach: float, symmetric: bool,
    slack: float,
) -> None:  # fmt: skip
    """Fill rows of ``out`` with the map over half a period (2 n, 2 n) in balanced coordinates, their scales, the error.

    K(t) = diag(s) + sum_k F_k cos((k + first) w t), s rows of ``rates``, F (H, n, n) and w likewise.  ``slack`` is the
    error of K relative to its size.
    """
    # Half a period in ``segments`` pieces of length 2 h: the first and the last reach h from the ends, where K is even,
    # the others h to either side of their centres.  Each map has an error: rounding + truncation (`tail` times the
    # factor from terms to balanced maps) + that of K itself (slack) and of the harmonics cut off; products carry them
    # (`chain_error`). s, f, g are one system's rates, amplitudes and balance, copied since records of a batch are slow
    # to index; ``both`` has the amplitudes about t = 0, and transposed with alternating signs about T/2. Maps of single
    # segments come first and products last, for the error of each to be carried by norms of its neighbours.
    n, count = len(rates[0]), len(amplitudes[0])
    total = np.empty((2 * n, 2 * n))
    g, s, f = np.empty(n), np.empty(n), np.empty((count, n, n))
    work = workspace(n, count)
    both, ends, norms = work[3], work[4], work[5]
    for b in range(len(out)):
        omega = frequency[b]
        for i in range(n):
            s[i] = rates[b][i]
            for k in range(count):
                for j in range(n):
                    f[k, i, j] = amplitudes[b][k][i][j]
        for k in range(count):
            norms[k] = spectral_bound(f[k])
        size, slow, fast = balance(s, f, omega, g)
        segments, terms, ratio, rounding = plan(size, norms, first, omega, accuracy, reach, n)
        if segments == 0:
            for q in range(4 * n * n + n):
                out[b, q] = math.nan
            out[b, 4 * n * n + n] = math.inf
            continue
        h = 0.5 * math.pi / (omega * segments)
        for k in range(count):
            sign = 1.0 if (k + first) % 2 == 0 else -1.0
            for r in range(n):
                for j in range(n):
                    both[0, k, r, j] = f[k, r, j]
                    both[1, k, r, j] = sign * f[k, j, r]
        most, cut = cut_harmonics(norms, first, omega, h, terms, slow, accuracy)
        rest = end_maps(s, first, omega, h, terms, most, ratio, n, g, work)
        noise = rounding + cut + slack * coefficient_bound(size, norms, first, 0.0) / slow * h
        # Of the four blocks: displacement and slope of either solution, in balanced coordinates.
        spread = math.sqrt(fast / slow)
        factor = spread * (2.0 * terms + 2.0) + fast * h + (2.0 * terms + 1.0) / (slow * h)
        error = noise + rest * factor / (1.0 - ratio**-2.0) ** 2
        if segments == 1:
            multiply(ends[1], ends[0], total)
            one, two = spectral_bound(ends[0]), spectral_bound(ends[1])
            error = error * (one + two + error) + ROUNDING * (2.0 * n + 2.0) * one * two
        else:
            maps = np.empty((segments + 1, 2 * n, 2 * n))
            errors = np.empty(segments + 1)
            copy_to(ends[0], maps[0])
            errors[0] = error
            copy_to(ends[1], maps[segments])
            errors[segments] = error
            forth = np.empty((2 * n, 2 * n))
            back = np.empty((2 * n, 2 * n))
            for j in range(1, segments):
                rest = inner_map(
                    s, first, omega, h, j, segments, terms, 2 * most + 1, ratio, n, g, symmetric, work, forth, back
                )
                error = noise + rest * factor / (1.0 - 1.0 / ratio) ** 2
                multiply(forth, back, maps[j])
                one, two = spectral_bound(forth), spectral_bound(back)
                errors[j] = error * (one + two + error) + ROUNDING * (2.0 * n + 2.0) * one * two
                if not symmetric:
                    errors[j] += error * one * two * two + ROUNDING * (8.0 * n) * one * two * two
            error = chain_error(maps, errors, total)
        for i in range(2 * n):
            for j in range(2 * n):
                out[b, i * 2 * n + j] = total[i, j]
        for i in range(n):
            out[b, 4 * n * n + i] = g[i]
        out[b, 4 * n * n + n] = error
