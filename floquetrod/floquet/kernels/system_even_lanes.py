"""Maps over half a period of several symmetric systems of two equations side by side.

Neighbours of an array share one plan, in time scaled to w = 1, where the coefficients of the cosines are the same for
all.  Every loop over neighbours is innermost and of fixed length, which compilers turn into vector instructions; the
bounds of the loops around it are known at run time only, or they would be unrolled and take long to compile.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.floquet.kernels.system_even_steps import cut_harmonics, plan
from floquetrod.floquet.kernels.system_series import LARGEST, MOST_TERMS, ROUNDING, coefficient_bound, weighted_sum

LANES = 8
"""Systems side by side: more no longer fit into the fastest cache (heuristic)."""


@kernel
def lane_workspace(count: int) -> Any:
    """Return the arrays that `lane_maps` works in, for ``count`` amplitudes."""
    return (
        np.zeros((MOST_TERMS + 1, 16 * LANES)),  # terms: two ends, two rows, four columns
        np.empty((count + 2, MOST_TERMS + 1)),  # coefficients of each harmonic, and two rows of weights
        np.empty((2, 16 * LANES)),
        np.empty((2, LANES)),  # stiffness
        np.empty((count, 4, LANES)),  # amplitudes
        np.empty((2, LANES)),  # roots of the rates
        np.empty((2, 16, LANES)),  # maps from and to the ends
        np.empty((16, LANES)),  # their product
        np.empty((3, LANES)),  # slack, slowest rate, error
        np.empty(count),
    )


@kernel
def rotation(p: float, q: float, off: float) -> tuple[float, float, float]:
    """Return (tangent, cosine, sine) of the rotation that diagonalises [[p, off], [off, q]]."""
    if off == 0.0:
        return 0.0, 1.0, 0.0
    ratio = 0.5 * (q - p) / off
    tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    return tangent, cosine, tangent * cosine


@kernel
def lane_load(stiffness: Any, amplitudes: Any, period: Any, start: int, used: int, work: Any) -> bool:
    """Load ``used`` systems in principal axes, the last of them repeated; False if not symmetric or not finite."""
    # K(t) = S + sum_k A_k cos(k t) in time scaled to w = 1, which multiplies K by (T / 2 pi)^2, then in the
    # eigenvectors of S by a Jacobi rotation: s[row, lane] are its eigenvalues, f[k, entry, lane] the four entries of
    # the turned A_k, g[row, lane] the rates sqrt(1/16 + |S_ii| + sum_k |A_k,ii|) by whose roots coordinates are
    # balanced (`lane_ends` takes the roots).  scalars[0, lane] is the relative error that the rotation leaves.  Lanes
    # are the last axis: they become vectors.
    _, _, _, s, f, g, _, _, scalars, norms = work
    count = len(norms)
    for lane in range(LANES):
        i = start + min(lane, used - 1)
        stiff = stiffness[i]
        if stiff[0][1] != stiff[1][0]:
            return False
        scale = period[i] / (2.0 * math.pi)
        scale *= scale
        tangent, cosine, sine = rotation(stiff[0][0], stiff[1][1], stiff[0][1])
        s[0, lane] = scale * (stiff[0][0] - tangent * stiff[0][1])
        s[1, lane] = scale * (stiff[1][1] + tangent * stiff[0][1])
        scalars[0, lane] = (14.0 if sine != 0.0 else 6.0) * ROUNDING
        one, two, total = abs(s[0, lane]) + 0.0625, abs(s[1, lane]) + 0.0625, 0.0
        for k in range(count):
            a = amplitudes[i][k]
            if a[0][1] != a[1][0]:
                return False
            # The basis has the columns (cosine, -sine) and (sine, cosine).
            p, q = cosine * a[0][0] - sine * a[0][1], sine * a[0][0] + cosine * a[0][1]
            t, u = cosine * a[1][0] - sine * a[1][1], sine * a[1][0] + cosine * a[1][1]
            f[k, 0, lane], f[k, 1, lane] = scale * (cosine * p - sine * t), scale * (cosine * q - sine * u)
            f[k, 2, lane], f[k, 3, lane] = scale * (sine * p + cosine * t), scale * (sine * q + cosine * u)
            one += abs(f[k, 0, lane])
            two += abs(f[k, 3, lane])
            total += abs(f[k, 1, lane])
        if not (one + two + total < LARGEST and period[i] > 1.0 / LARGEST):
            return False
        g[0, lane], g[1, lane] = math.sqrt(one), math.sqrt(two)
    return True


@kernel
def lane_plan(accuracy: float, reach: float, work: Any) -> tuple[int, int, float, float, float, float]:
    """Return (terms, powers of the angles, ratio, rounding, cut, bound) of one plan for the systems loaded.

    ``rounding`` and ``cut`` are errors, ``bound`` is the bound of the coefficients.  There are no terms where a segment
    is not enough.
    """
    _, _, _, s, f, g, _, _, _, norms = work
    size, slow = 0.0, math.inf
    for lane in range(LANES):
        size = max(size, abs(s[0, lane]), abs(s[1, lane]))
        slow = min(slow, g[0, lane], g[1, lane])
    for k in range(len(norms)):
        norms[k] = 0.0
        for lane in range(LANES):
            side = abs(f[k, 1, lane])
            norms[k] = max(norms[k], side + max(abs(f[k, 0, lane]), abs(f[k, 3, lane])))
    segments, terms, ratio, rounding = plan(size, norms, 1, 1.0, accuracy, reach, 2)
    if segments != 1:
        return 0, 0, 1.0, 0.0, 0.0, 0.0
    most, cut = cut_harmonics(norms, 1, 1.0, 0.5 * math.pi, terms, slow, accuracy)
    return terms, most, ratio, rounding, cut, coefficient_bound(size, norms, 1, 0.0)


@kernel
def lane_series(h: float, terms: int, most: int, shrink: float, work: Any) -> None:
    """Fill the terms of the series about both ends, and the squared norms under the root of `tail`."""
    # u'' + K u = 0 with K even about both ends: even solutions have the powers t^2i, odd ones t^(2i+1), so that term i
    # + 1 is -h^2 / ((2i+1)(2i+2)) or -h^2 / ((2i+2)(2i+3)) times (K u)_i, where (A_k cos(k t) u)_i = A_k sum_l c[k, l]
    # x_(i-l). x[i] holds the terms: two ends, two rows, four columns (even and odd solutions), LANES each; about the
    # end T/2 the cosines of odd k change their sign.  y[1] gathers the weighted squares for `tail` while a term is in
    # the cache.
    x, c, y, s, f, _, _, _, _, norms = work
    count, n = len(norms), len(s)
    length = x.shape[1]
    for k in range(count):
        angle = (k + 1) * h
        value = 1.0
        for i in range(terms):
            c[k, i] = value
            value *= -angle * angle / ((2.0 * i + 1.0) * (2.0 * i + 2.0))
    for q in range(length):
        x[0, q] = 0.0
    for row in range(2 * n):
        for column in range(row % n, 2 * n, n):
            for lane in range(LANES):
                x[0, (row * 4 + column) * LANES + lane] = 1.0
    for q in range(length):
        y[1, q] = shrink * x[0, q]
    # x[i + 1] first holds (K x)_i, the mean and then the cosines, and is multiplied by its factor last.
    for i in range(terms - 1):
        cosine = -h * h / ((2.0 * i + 1.0) * (2.0 * i + 2.0))
        sine = -h * h / ((2.0 * i + 2.0) * (2.0 * i + 3.0))
        for row in range(2 * n):
            for column in range(2 * n):
                start = (row * 4 + column) * LANES
                for lane in range(LANES):
                    x[i + 1, start + lane] = s[row % n, lane] * x[i, start + lane]
        for k in range(count):
            weighted_sum(x, i, c, k, most, length, y, 0)
            for half in range(n):
                sign = -1.0 if half == 1 and k % 2 == 0 else 1.0
                for column in range(2 * n):
                    upper, lower = (half * 8 + column) * LANES, (half * 8 + 4 + column) * LANES
                    for lane in range(LANES):
                        a, b = sign * y[0, upper + lane], sign * y[0, lower + lane]
                        x[i + 1, upper + lane] += f[k, 0, lane] * a + f[k, 1, lane] * b
                        x[i + 1, lower + lane] += f[k, 2, lane] * a + f[k, 3, lane] * b
        for row in range(2 * n):
            for column in range(2 * n):
                start = (row * 4 + column) * LANES
                factor = cosine if column < 2 else sine
                for lane in range(LANES):
                    value = factor * x[i + 1, start + lane]
                    x[i + 1, start + lane] = value
                    y[1, start + lane] = shrink * (y[1, start + lane] + value * value)
    for q in range(length):
        y[0, q] = y[1, q]


@kernel
def lane_ends(h: float, terms: int, work: Any) -> None:
    """Fill the maps from 0 to T/4 and from T/4 to T/2 (4 x 4 each), in coordinates balanced by g."""
    # At the distance h = T/4 from either end values are sum x_i, slopes sum 2i x_i of even solutions and (2i + 1) x_i
    # of odd ones: rows ``count`` and ``count`` + 1 of c hold these weights, last term first, so that the smallest are
    # added first; y[0] and y[1] hold the sums, one to four the four blocks of `x`.  In (g u, u' / g) the map from 0 to
    # T/4 is [[value even, h value odd], [slope even / h, slope odd]], scaled; that from T/4 to T/2 has the blocks of
    # the end T/2 transposed and a and d exchanged, K being symmetric and even about T/2.
    x, c, y, _, _, g, ends, _, _, norms = work
    count, n, length = len(norms), len(g), x.shape[1]
    for i in range(terms):
        c[count, i] = 1.0
        c[count + 1, i] = 2.0 * (terms - 1 - i)
    for k in range(n):  # a loop, for the sum to be compiled once
        weighted_sum(x, terms - 1, c, count + k, terms, length, y, k)
    for r in range(n):
        for lane in range(LANES):
            g[r, lane] = math.sqrt(g[r, lane])
    for r in range(n):
        for j in range(n):
            one, two = (r * 4 + j) * LANES, (r * 4 + 2 + j) * LANES
            three, four = one + 8 * LANES, two + 8 * LANES
            for lane in range(LANES):
                scale = g[r, lane] / g[j, lane]
                rate = h * g[r, lane] * g[j, lane]
                ends[0, r * 4 + j, lane] = y[0, one + lane] * scale
                ends[0, r * 4 + 2 + j, lane] = y[0, two + lane] * rate
                ends[0, 8 + r * 4 + j, lane] = y[1, one + lane] / rate
                ends[0, 8 + r * 4 + 2 + j, lane] = (y[1, two + lane] + y[0, two + lane]) / scale
                ends[1, 8 + j * 4 + 2 + r, lane] = y[0, three + lane] * scale
                ends[1, j * 4 + 2 + r, lane] = y[0, four + lane] * rate
                ends[1, 8 + j * 4 + r, lane] = y[1, three + lane] / rate
                ends[1, j * 4 + r, lane] = (y[1, four + lane] + y[0, four + lane]) / scale


@kernel
def lane_errors(h: float, terms: int, ratio: float, rounding: float, cut: float, bound: float, work: Any) -> None:
    """Set the errors of the maps from both ends, as `half_period_fill` does; before roots of the rates are taken."""
    # y[0] holds the squares of `tail`, so that rest = tail^2 bounds the first term left out, and tail / (1 -
    # ratio^-2)^2 all of them with their weights 2i.  ``factor`` carries it from terms to balanced blocks: sqrt(fast /
    # slow) bounds g_r / g_j, fast h and 1 / (slow h) the scales of b and c.  scalars[1] adds what rounding, harmonics
    # cut off and K contribute.
    _, _, y, _, _, g, _, _, scalars, _ = work
    remainder = 1.0 / ((1.0 - ratio**-2.0) * (1.0 - ratio**-2.0))
    for lane in range(LANES):
        fast, slow = max(g[0, lane], g[1, lane]), min(g[0, lane], g[1, lane])
        rest = 0.0
        for entry in range(y.shape[1] // LANES):
            rest += y[0, entry * LANES + lane]
        factor = math.sqrt(fast / slow) * (2.0 * terms + 2.0) + fast * h + (2.0 * terms + 1.0) / (slow * h)
        scalars[1, lane] = rounding + cut + scalars[0, lane] * (bound * h) / slow
        scalars[1, lane] += math.sqrt(rest) * factor * remainder


@kernel
def lane_product(work: Any) -> None:
    """Set the maps over half a period, products of those from both ends, and their errors."""
    # total = ends[1] ends[0], 4 x 4 matrices by rows, a lane each.  With the same error e of both factors the product
    # is off by e (|ends[0]| + |ends[1]| + e), Frobenius norms, and by the rounding of sums of four products.
    ends, total, scalars = work[6], work[7], work[8]
    size = len(total) // 4
    for row in range(size):
        for column in range(size):
            for lane in range(LANES):
                total[row * 4 + column, lane] = (
                    ends[1, row * 4, lane] * ends[0, column, lane]
                    + ends[1, row * 4 + 1, lane] * ends[0, 4 + column, lane]
                ) + (
                    ends[1, row * 4 + 2, lane] * ends[0, 8 + column, lane]
                    + ends[1, row * 4 + 3, lane] * ends[0, 12 + column, lane]
                )
    for lane in range(LANES):
        one, two = 0.0, 0.0
        for entry in range(len(total)):
            one += ends[0, entry, lane] * ends[0, entry, lane]
            two += ends[1, entry, lane] * ends[1, entry, lane]
        one, two, error = math.sqrt(one), math.sqrt(two), scalars[1, lane]
        scalars[2, lane] = error * (one + two + error) + ROUNDING * 6.0 * one * two
