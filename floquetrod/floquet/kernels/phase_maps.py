"""Kernels for two frequencies: maps over a period of the first at phases of the second, and their products."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

ORDER = 18
"""Highest power of the Taylor series of a step (a choice)."""

_REACH = 0.8  # phase of the fastest rate that a step crosses, at first (a choice)
_LONG_REACH = 1.2  # likewise of many equations, whose series end as the fastest one's does
_DOUBLINGS = 6  # of the number of steps, while the last terms of a series are too large
_LARGEST = 1e150  # of a map


@kernel
def add_waves(table: Any, waves: Any, size: float, rate: float, time: float, spread: float) -> None:
    """Add size times the Taylor coefficients in t of sum_k cosine_k cos(k x) + sine_k sin(k x), x = rate (time + t).

    The tables (powers, rows, columns, phases) have a phase ``spread`` times 0, 1, ... besides; ``waves`` are cosines
    and sines (2, H, rows, columns), and t counts in steps.
    """
    # cos(k rate (time + t)) has the coefficients cos, -sin, -cos, sin of the angle in turn, times (k rate)^i / i!.
    phases = table.shape[3]
    for k in range(waves.shape[1]):
        order = k + 1.0
        for phase in range(phases):
            angle = order * (rate * time + spread * phase)
            c, s = math.cos(angle), math.sin(angle)
            for power in range(len(table)):
                for i in range(waves.shape[2]):
                    for j in range(waves.shape[3]):
                        table[power, i, j, phase] += size * (c * waves[0, k, i, j] + s * waves[1, k, i, j])
                factor = order * rate / (power + 1.0)
                c, s = -s * factor, c * factor


@kernel
def series_step(x: Any, a: Any, table: Any, h: float, top: int) -> float:
    """Carry solutions x[0] (n, n, phases) over a step; return the largest of the last terms of the series, relative."""
    # x(t + h s) = sum_i x_i s^i with x_(i+1) = (h a x_i + sum_l table_l x_(i-l)) / (i + 1): ``a`` is constant and equal
    # for all phases, ``table`` (power, row, column, phase) has the waves, times h, in rows from ``top`` on alone.
    # Phases are innermost, so that all go through one loop.  The sum over i begins with the smallest term.
    n, phases, right = len(a), x.shape[3], table.shape[2]
    for power in range(ORDER):
        for i in range(n):
            for j in range(n):
                for phase in range(phases):
                    x[power + 1, i, j, phase] = 0.0
                for m in range(n):
                    factor = h * a[i, m]
                    if factor != 0.0:
                        for phase in range(phases):
                            x[power + 1, i, j, phase] += factor * x[power, m, j, phase]
                if i >= top:
                    for lag in range(power + 1):
                        for m in range(right):
                            for phase in range(phases):
                                x[power + 1, i, j, phase] += table[lag, i - top, m, phase] * x[power - lag, m, j, phase]
                for phase in range(phases):
                    x[power + 1, i, j, phase] /= power + 1.0
    largest, last = 0.0, 0.0
    for i in range(n):
        for j in range(n):
            for phase in range(phases):
                total = 0.0
                for power in range(ORDER, -1, -1):
                    total += x[power, i, j, phase]
                last = max(last, abs(x[ORDER, i, j, phase]), abs(x[ORDER - 1, i, j, phase]))
                x[0, i, j, phase] = total
                largest = max(largest, abs(total))
    return last / max(largest, 1.0) if largest < _LARGEST else math.inf


@kernel
def modulated_step(x: Any, y: Any, maps: Any, a: Any, shapes: Any, table: Any, h: float, top: int) -> float:
    """Carry solutions over a step, as `series_step`, where waves are few matrices ``shapes`` (R, rows, columns).

    Their factors are ``table`` (powers, R, 1, phases); ``maps`` (n, n, phases) are replaced.  ``x`` (powers, n, phases)
    and ``y`` (columns, phases) are room for one solution.
    """
    # y = sum_l table_l x_(i-l) first, as all entries of a matrix have one factor.
    n, phases, right = len(a), x.shape[2], shapes.shape[2]
    largest, last = 0.0, 0.0
    for j in range(n):
        for i in range(n):
            for phase in range(phases):
                x[0, i, phase] = maps[i, j, phase]
        for power in range(ORDER):
            for i in range(n):
                for phase in range(phases):
                    x[power + 1, i, phase] = 0.0
                for m in range(n):
                    factor = h * a[i, m]
                    if factor != 0.0:
                        for phase in range(phases):
                            x[power + 1, i, phase] += factor * x[power, m, phase]
            for shape in range(len(shapes)):
                for m in range(right):
                    for phase in range(phases):
                        y[m, phase] = 0.0
                    for lag in range(power + 1):
                        for phase in range(phases):
                            y[m, phase] += table[lag, shape, 0, phase] * x[power - lag, m, phase]
                for i in range(top, n):
                    for m in range(right):
                        factor = shapes[shape, i - top, m]
                        if factor != 0.0:
                            for phase in range(phases):
                                x[power + 1, i, phase] += factor * y[m, phase]
            for i in range(n):
                for phase in range(phases):
                    x[power + 1, i, phase] /= power + 1.0
        for i in range(n):
            for phase in range(phases):
                total = 0.0
                for power in range(ORDER, -1, -1):
                    total += x[power, i, phase]
                last = max(last, abs(x[ORDER, i, phase]), abs(x[ORDER - 1, i, phase]))
                maps[i, j, phase] = total
                largest = max(largest, abs(total))
    return last / max(largest, 1.0) if largest < _LARGEST else math.inf


@kernel
def modulated_maps_fill(mean: Any, own: Any, second: Any, shapes: Any, ratio: Any, out: Any, phases: int, top: int,
                        accuracy: float) -> None:  # fmt: skip
    """Fill rows of ``out`` as `phase_maps_fill`, where waves are few matrices ``shapes`` (R, rows, columns).

    Their factors are cosines and sines (2, H, R, 1).
    """
    n, few = len(mean[0]), len(shapes[0])
    rows, right = len(shapes[0][0]), len(shapes[0][0][0])
    a, maps, matrices = np.empty((n, n)), np.empty((n, n, phases)), np.empty((few, rows, right))
    x, y = np.empty((ORDER + 1, n, phases)), np.empty((right, phases))
    shared, table = np.empty((ORDER + 1, few, 1, 1)), np.empty((ORDER + 1, few, 1, phases))
    for b in range(len(out)):
        firsts = np.empty((2, len(own[b][0]), few, 1))
        seconds = np.empty((2, len(second[b][0]), few, 1))
        sizes = np.zeros(few)
        for side in range(2):
            for shape in range(few):
                for k in range(firsts.shape[1]):
                    firsts[side, k, shape, 0] = own[b][side][k][shape][0]
                    sizes[shape] += abs(firsts[side, k, shape, 0])
                for k in range(seconds.shape[1]):
                    seconds[side, k, shape, 0] = second[b][side][k][shape][0]
                    sizes[shape] += abs(seconds[side, k, shape, 0])
        fastest = max(1.0 * firsts.shape[1], ratio[b] * seconds.shape[1])
        for i in range(n):
            row = 0.0
            for j in range(n):
                a[i, j] = mean[b][i][j]
                row += abs(a[i, j])
            if i >= top:
                for shape in range(few):
                    for j in range(right):
                        matrices[shape, i - top, j] = shapes[b][shape][i - top][j]
                        row += sizes[shape] * abs(matrices[shape, i - top, j])
            fastest = max(fastest, row)
        steps = math.ceil(2.0 * math.pi * fastest / _LONG_REACH)
        error = math.inf
        for _ in range(_DOUBLINGS):
            error, h = 0.0, 2.0 * math.pi / steps
            maps[:] = 0.0
            for i in range(n):
                for phase in range(phases):
                    maps[i, i, phase] = 1.0
            for step in range(steps):
                shared[:] = 0.0
                table[:] = 0.0
                add_waves(shared, firsts, h, h, 1.0 * step, 0.0)
                add_waves(table, seconds, h, ratio[b] * h, 1.0 * step, 2.0 * math.pi / phases)
                for power in range(ORDER + 1):
                    for shape in range(few):
                        for phase in range(phases):
                            table[power, shape, 0, phase] += shared[power, shape, 0, 0]
                error = max(error, modulated_step(x, y, maps, a, matrices, table, h, top))
                if not error <= accuracy:
                    break
            if error <= accuracy or error == math.inf:
                break
            steps *= 2
        for i in range(n):
            for j in range(n):
                for phase in range(phases):
                    out[b, (i * n + j) * phases + phase] = maps[i, j, phase]
        out[b, n * n * phases] = error if error <= accuracy else math.inf


@kernel
def phase_maps_fill(mean: Any, own: Any, second: Any, ratio: Any, out: Any, phases: int, top: int, right: int,
                    accuracy: float) -> None:  # fmt: skip
    """Fill rows of ``out`` with the maps over a period of the first frequency at phases of the second, and an error.

    x' = A(t, y) x over t from 0 to 2 pi, A = mean + own waves of k t + second waves of k (ratio t + y); waves are
    cosines and sines (2, H, N, N), in rows from ``top`` and columns below ``right`` alone.  The phases y are equally
    spaced; a row is (N, N, phases) and the error, infinite where maps overflow.
    """
    # A step times the largest row sum of A, or the rate of the fastest wave, is `_REACH`; it is halved until the last
    # terms of its Taylor series (`series_step`) are within the accuracy.  Tables hold the series of the waves in A:
    # ``shared`` of the first frequency, equal for all phases, ``table`` of both.
    n = len(mean[0])
    a, x = np.empty((n, n)), np.empty((ORDER + 1, n, n, phases))
    shared, table = np.empty((ORDER + 1, n - top, right, 1)), np.empty((ORDER + 1, n - top, right, phases))
    for b in range(len(out)):
        firsts = np.empty((2, len(own[b][0]), n - top, right))
        seconds = np.empty((2, len(second[b][0]), n - top, right))
        fastest = max(1.0 * firsts.shape[1], ratio[b] * seconds.shape[1])
        for i in range(n):
            row = 0.0
            for j in range(n):
                a[i, j] = mean[b][i][j]
                row += abs(a[i, j])
            if i >= top:
                for side in range(2):
                    for j in range(right):
                        for k in range(firsts.shape[1]):
                            firsts[side, k, i - top, j] = own[b][side][k][i][j]
                            row += abs(firsts[side, k, i - top, j])
                        for k in range(seconds.shape[1]):
                            seconds[side, k, i - top, j] = second[b][side][k][i][j]
                            row += abs(seconds[side, k, i - top, j])
            fastest = max(fastest, row)
        steps = math.ceil(2.0 * math.pi * fastest / _REACH)
        error = math.inf
        for _ in range(_DOUBLINGS):
            error, h = 0.0, 2.0 * math.pi / steps
            x[0] = 0.0
            for i in range(n):
                for phase in range(phases):
                    x[0, i, i, phase] = 1.0
            for step in range(steps):
                shared[:] = 0.0
                table[:] = 0.0
                add_waves(shared, firsts, h, h, 1.0 * step, 0.0)
                add_waves(table, seconds, h, ratio[b] * h, 1.0 * step, 2.0 * math.pi / phases)
                for power in range(ORDER + 1):
                    for i in range(n - top):
                        for j in range(right):
                            for phase in range(phases):
                                table[power, i, j, phase] += shared[power, i, j, 0]
                error = max(error, series_step(x, a, table, h, top))
                if not error <= accuracy:
                    break
            if error <= accuracy or error == math.inf:
                break
            steps *= 2
        for i in range(n):
            for j in range(n):
                for phase in range(phases):
                    out[b, (i * n + j) * phases + phase] = x[0, i, j, phase]
        out[b, n * n * phases] = error if error <= accuracy else math.inf


@kernel
def orbit_products_fill(real: Any, imag: Any, fraction: Any, out: Any, n: int) -> None:
    """Fill rows of ``out`` with the product of the maps at the phases 2 pi j p / q, j = 0 to q - 1, and two logarithms.

    The maps are Re sum_k (real + i imag)[k] exp(i k phase), (K, N, N).  The product is the first N N numbers times the
    exponential of the next; the last is the logarithm by which an error of a map, the same for all, grows in it.
    """
    # P = M_(q-1) ... M_0.  An error e of every map changes P by sum_j |M_(q-1) ... M_(j+1)| e |M_(j-1) ... M_0|, to
    # first order; |M| is N times the largest entry.  Products before M_j come first, then those after it, downwards.
    for b in range(len(out)):
        p, q, count = int(fraction[b][0]), int(fraction[b][1]), len(real[b])
        waves = np.empty((2, count, n, n))
        for k in range(count):
            for i in range(n):
                for j in range(n):
                    waves[0, k, i, j] = real[b][k][i][j]
                    waves[1, k, i, j] = imag[b][k][i][j]
        maps, before = np.zeros((q, n, n)), np.zeros(q)
        total, product = np.eye(n), np.empty((n, n))
        taken = 0.0
        for turn in range(q):
            angle = 2.0 * math.pi * ((turn * p) % q) / q
            cosine, sine, c, s = math.cos(angle), math.sin(angle), 1.0, 0.0
            for k in range(count):
                for i in range(n):
                    for j in range(n):
                        maps[turn, i, j] += c * waves[0, k, i, j] - s * waves[1, k, i, j]
                c, s = c * cosine - s * sine, s * cosine + c * sine
            before[turn] = taken + log_of_largest(total)
            taken += times_in_range(maps[turn], total, product)
            if not taken < math.inf:
                break
        for i in range(n):
            for j in range(n):
                out[b, i * n + j] = total[i, j]
        out[b, n * n], out[b, n * n + 1] = taken, math.inf
        if not taken < math.inf:
            out[b, n * n] = math.nan
            continue
        for i in range(n):
            for j in range(n):
                total[i, j] = 1.0 if i == j else 0.0
        after, largest, whole = 0.0, -math.inf, 0.0
        for step in range(q):
            turn = q - 1 - step
            growth = after + log_of_largest(total) + before[turn]
            if growth > largest:
                whole = 1.0 + (whole * math.exp(largest - growth) if step else 0.0)
                largest = growth
            else:
                whole += math.exp(growth - largest)
            for i in range(n):
                for j in range(i):
                    maps[turn, i, j], maps[turn, j, i] = maps[turn, j, i], maps[turn, i, j]
            after += times_in_range(maps[turn], total, product)  # transposes, so that the new map comes first
        out[b, n * n + 1] = largest + math.log(whole) + 2.0 * math.log(n)


@kernel
def log_of_largest(matrix: Any) -> float:
    """Return the logarithm of the largest entry."""
    largest = 0.0
    for i in range(len(matrix)):
        for j in range(len(matrix)):
            largest = max(largest, abs(matrix[i, j]))
    return math.log(largest) if largest > 0.0 else -math.inf


@kernel
def times_in_range(matrix: Any, total: Any, product: Any) -> float:
    """Set ``total`` to the product of a matrix and it, kept in range; return the logarithm taken out, inf if lost."""
    n = len(matrix)
    largest = 0.0
    for i in range(n):
        for j in range(n):
            value = 0.0
            for m in range(n):
                value += matrix[i, m] * total[m, j]
            product[i, j] = value
            largest = max(largest, abs(value))
    if not 0.0 < largest < math.inf:
        return math.inf
    inside = 1e-100 < largest < 1e100
    scale = 1.0 if inside else 1.0 / largest
    for i in range(n):
        for j in range(n):
            total[i, j] = scale * product[i, j]
    return 0.0 if inside else math.log(largest)
