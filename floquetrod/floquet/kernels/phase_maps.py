"""Kernels for two frequencies: maps over a period of the first at phases of the second, and their products."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

ORDER = 18
"""Highest power of the Taylor series of a step (a choice)."""

_REACH = 0.8  # phase of the fastest rate that a step crosses, at first (a choice)
_DOUBLINGS = 6  # of the number of steps, while the last terms of a series are too large
_LARGEST = 1e150  # of a map


@kernel
def add_waves(table: Any, waves: Any, size: float, rate: float, time: float, spread: float) -> None:
    """Add size times the Taylor coefficients in t of sum_k cosine_k cos(k x) + sine_k sin(k x), x = rate (time + t).

    The tables (powers, rows, columns, phases) have a phase ``spread`` times 0, 1, ... besides; ``waves`` are cosines
    and sines (2, H, rows, columns), and t counts in steps.
    """
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
    # x_(i+1) = h / (i + 1) (a x_i + sum_l table_l x_(i-l)), all phases side by side.
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
def phase_maps_fill(mean: Any, own: Any, second: Any, ratio: Any, out: Any, phases: int, top: int, right: int,
                    accuracy: float) -> None:  # fmt: skip
    """Fill rows of ``out`` with the maps over a period of the first frequency at phases of the second, and an error.

    x' = A(t, y) x over t from 0 to 2 pi, A = mean + own waves of k t + second waves of k (ratio t + y); waves are
    cosines and sines (2, H, N, N), in rows from ``top`` and columns below ``right`` alone.  The phases y are equally
    spaced; a row is (N, N, phases) and the error, infinite where maps overflow.
    """
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
    """Fill rows of ``out`` with the product of the maps at the phases 2 pi j p / q, j = 0 to q - 1, and a logarithm.

    The maps are Re sum_k (real + i imag)[k] exp(i k phase), (K, N, N); the product is the first N N numbers times the
    exponential of the last.
    """
    for b in range(len(out)):
        p, q, count = int(fraction[b][0]), int(fraction[b][1]), len(real[b])
        waves = np.empty((2, count, n, n))
        for k in range(count):
            for i in range(n):
                for j in range(n):
                    waves[0, k, i, j] = real[b][k][i][j]
                    waves[1, k, i, j] = imag[b][k][i][j]
        total, here, product = np.eye(n), np.empty((n, n)), np.empty((n, n))
        taken = 0.0
        for turn in range(q):
            angle = 2.0 * math.pi * ((turn * p) % q) / q
            cosine, sine, c, s = math.cos(angle), math.sin(angle), 1.0, 0.0
            here[:] = 0.0
            for k in range(count):
                for i in range(n):
                    for j in range(n):
                        here[i, j] += c * waves[0, k, i, j] - s * waves[1, k, i, j]
                c, s = c * cosine - s * sine, s * cosine + c * sine
            largest = 0.0
            for i in range(n):
                for j in range(n):
                    value = 0.0
                    for m in range(n):
                        value += here[i, m] * total[m, j]
                    product[i, j] = value
                    largest = max(largest, abs(value))
            if not 0.0 < largest < math.inf:
                taken = math.nan
                break
            scale = 1.0
            if not 1e-100 < largest < 1e100:
                scale = 1.0 / largest
                taken += math.log(largest)
            for i in range(n):
                for j in range(n):
                    total[i, j] = scale * product[i, j]
        for i in range(n):
            for j in range(n):
                out[b, i * n + j] = total[i, j]
        out[b, n * n] = taken
