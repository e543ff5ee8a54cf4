"""Kernel that solves Hill's matrix for a force: a band of blocks, with an estimate of the error, over arrays."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

EPS = 2.220446049250313e-16
_ROUNDS = 3  # of the estimate of a norm, at most


@kernel
def size_of(value: Any) -> float:
    """Return |Re| + |Im|, which is at most the root of two times the modulus, at a fraction of its time."""
    return float(abs(value.real) + abs(value.imag))


@kernel
def assemble(
    mass: Any, rates: Any, means: Any, halves: Any, delays: Any, omega: float, shift: float, cut: int, width: int,
    band: Any,
) -> None:  # fmt: skip
    """Set ``band`` (rows, 3 width + 1) to Hill's matrix of harmonics -cut to cut, row i from column i - width on."""
    # The harmonic k turns at s = shift + k omega.  Its block is -s^2 M + i s C + sum_q K_q exp(-i s tau_q); K_q has the
    # harmonics Z / 2, ``halves``, which take the harmonic l to k = l + m with the delay of l: exp(-i s_l tau_q).
    n, count = len(mass), len(halves[0])
    for source in range(2 * cut + 1):
        s = shift + (source - cut) * omega
        for i in range(n):
            for j in range(n):
                band[source * n + i, j - i + width] += complex(-s * s * mass[i][j], s * rates[i][j])
        for q in range(len(means)):
            turn = cmath.exp(complex(0.0, -s * delays[q])) if delays[q] != 0.0 else complex(1.0, 0.0)
            for i in range(n):
                for j in range(n):
                    band[source * n + i, j - i + width] += means[q][i][j] * turn
            for m in range(1, count + 1):
                for i in range(n):
                    for j in range(n):
                        value = halves[q][m - 1][i][j]
                        if value == 0.0:
                            continue
                        if source + m <= 2 * cut:
                            band[(source + m) * n + i, j - i - m * n + width] += value * turn
                        if source - m >= 0:
                            band[(source - m) * n + i, j - i + m * n + width] += value.conjugate() * turn


@kernel
def factor_band(band: Any, width: int, pivots: Any) -> bool:
    """Factor a band matrix in place, rows exchanged; return whether it is singular."""
    # Row i holds the columns i - width to i + 2 width; the multipliers of column k stay below it, not exchanged.
    rows = len(band)
    for k in range(rows):
        last = min(k + width, rows - 1)
        chosen, size = k, size_of(band[k, width])
        for i in range(k + 1, last + 1):
            value = size_of(band[i, k - i + width])
            if value > size:
                chosen, size = i, value
        pivots[k] = chosen
        if not 0.0 < size < math.inf:
            return True
        end = min(k + 2 * width, rows - 1)
        if chosen != k:
            for j in range(k, end + 1):
                band[k, j - k + width], band[chosen, j - chosen + width] = (
                    band[chosen, j - chosen + width],
                    band[k, j - k + width],
                )
        inverse = 1.0 / band[k, width]
        for i in range(k + 1, last + 1):
            factor = band[i, k - i + width] * inverse
            band[i, k - i + width] = factor
            if factor != 0.0:
                for j in range(k + 1, end + 1):
                    band[i, j - i + width] -= factor * band[k, j - k + width]
    return False


@kernel
def solve_band(band: Any, width: int, pivots: Any, x: Any) -> None:
    """Replace x by the solution of A y = x."""
    rows = len(band)
    for k in range(rows):
        p = pivots[k]
        if p != k:
            x[k], x[p] = x[p], x[k]
        if x[k] != 0.0:
            for i in range(k + 1, min(k + width, rows - 1) + 1):
                x[i] -= band[i, k - i + width] * x[k]
    for k in range(rows - 1, -1, -1):
        total = x[k]
        for j in range(k + 1, min(k + 2 * width, rows - 1) + 1):
            total -= band[k, j - k + width] * x[j]
        x[k] = total / band[k, width]


@kernel
def solve_adjoint(band: Any, width: int, pivots: Any, x: Any) -> None:
    """Replace x by the solution of A^H y = x."""
    rows = len(band)
    for k in range(rows):
        value = x[k] / band[k, width].conjugate()
        x[k] = value
        if value != 0.0:
            for j in range(k + 1, min(k + 2 * width, rows - 1) + 1):
                x[j] -= band[k, j - k + width].conjugate() * value
    for k in range(rows - 1, -1, -1):
        total = x[k]
        for i in range(k + 1, min(k + width, rows - 1) + 1):
            total -= band[i, k - i + width].conjugate() * x[i]
        x[k] = total
        p = pivots[k]
        if p != k:
            x[k], x[p] = x[p], x[k]


@kernel
def inverse_norm(band: Any, width: int, pivots: Any, columns: Any, rows: Any, start: Any) -> float:
    """Return an estimate of the 1-norm of D^-1 A^-1 S^-1, D = diag(columns) and S = diag(rows), from a solution."""
    # N. J. Higham, ACM Trans. Math. Software 14 (1988) 381, doi:10.1145/50063.214386: the columns that a sign vector
    # names, beginning with a solution, which near a resonance has the signs of the resonant one.  B = D^-1 A^-1 S^-1:
    #     z = B^H sign(y),  j the largest of |z|,  y = B e_j,  |B| is at least |y|_1,
    # until j repeats or |y|_1 no longer grows.  ``x`` holds z, then y before it is divided by the columns.
    count = len(band)
    x = np.empty(count, dtype=np.complex128)
    signs = np.empty(count, dtype=np.complex128)
    for i in range(count):
        size = abs(start[i])
        signs[i] = start[i] / size if size > 0.0 else 1.0
    best, before = 0.0, -1
    for _ in range(_ROUNDS):
        for i in range(count):
            x[i] = signs[i] / columns[i]
        solve_adjoint(band, width, pivots, x)
        chosen, size = 0, -1.0
        for i in range(count):
            value = size_of(x[i]) / rows[i]
            if value > size:
                chosen, size = i, value
        if chosen == before:
            break
        before = chosen
        for i in range(count):
            x[i] = 0.0
        x[chosen] = 1.0 / rows[chosen]  # S^-1 e_j
        solve_band(band, width, pivots, x)
        total = 0.0
        for i in range(count):
            value = abs(x[i]) / columns[i]
            total += value
            signs[i] = x[i] / (value * columns[i]) if value > 0.0 else 1.0
        if not total > best:
            break
        best = total
    return best


@kernel
def left_out(halves: Any, x: Any, cut: int, n: int) -> float:
    """Return the 1-norm of what the harmonics of the solution drive beyond those kept."""
    count, total = len(halves[0]), 0.0
    for q in range(len(halves)):
        for m in range(1, count + 1):
            for outer in range(m):
                for i in range(n):
                    for j in range(n):
                        size = size_of(halves[q][m - 1][i][j])
                        if outer <= 2 * cut:
                            total += size * (size_of(x[outer * n + j]) + size_of(x[(2 * cut - outer) * n + j]))
    return total


@kernel
def balance_fill(
    mass: Any, rates: Any, means: Any, halves: Any, delays: Any, omega: Any, shift: Any, force: Any, unknown: Any,
    out: Any, cut: int,
) -> None:  # fmt: skip
    """Fill rows of ``out`` with the amplitudes of the harmonics -cut to cut, an error, and what truncation leaves out.

    The error is one for all amplitudes of a coordinate together, over the largest one.  ``unknown`` is the error of the
    coefficients and of the force, entry by entry.
    """
    # Hill's matrix L, banded, is solved for the force.  Componentwise residuals g, with the rounding of L and of the
    # force, bound the error of the solution by |L^-1| g; of that the norm of D^-1 L^-1 S^-1 is estimated, D the largest
    # amplitude of each coordinate and S what makes the rows of L D one, so that units do not matter.
    for b in range(len(out)):
        n, count = len(mass[b]), len(halves[b][0])
        rows, width = (2 * cut + 1) * n, (count + 1) * n - 1
        band = np.zeros((rows, 3 * width + 1), dtype=np.complex128)
        assemble(mass[b], rates[b], means[b], halves[b], delays[b], omega[b], shift[b], cut, width, band)
        kept = band[:, : 2 * width + 1].copy()
        pivots = np.zeros(rows, dtype=np.int64)
        x, right = np.zeros(rows, dtype=np.complex128), np.zeros(rows, dtype=np.complex128)
        first = cut - (len(force[b]) - 1) // 2
        for k in range(len(force[b])):
            for i in range(n):
                right[(first + k) * n + i] = force[b][k][i]
        for i in range(rows):
            x[i] = right[i]
        if factor_band(band, width, pivots):
            for i in range(rows):
                out[b, i] = complex(math.nan, math.nan)
            out[b, rows], out[b, rows + 1] = math.inf, 0.0
            continue
        solve_band(band, width, pivots, x)
        largest, sizes, whole = np.zeros(n), np.empty(rows), 0.0
        for i in range(rows):
            sizes[i] = size_of(x[i])
            largest[i % n] = max(largest[i % n], sizes[i])
            whole += sizes[i]
        top = 0.0
        for i in range(n):
            top = max(top, largest[i])
        if not top < math.inf:
            for i in range(rows):
                out[b, i] = complex(math.nan, math.nan)
            out[b, rows], out[b, rows + 1] = math.inf, 0.0
            continue
        longest = 0.0
        for q in range(len(delays[b])):
            longest = max(longest, delays[b][q])
        columns, scale = np.empty(rows), np.empty(rows)
        for i in range(rows):
            columns[i] = largest[i % n] if largest[i % n] > 0.0 else (top if top > 0.0 else 1.0)
        total, coarse = 0.0, 0.0
        for i in range(rows):
            residual, size, row = right[i], size_of(right[i]), 0.0
            for j in range(max(0, i - width), min(rows - 1, i + width) + 1):
                value = kept[i, j - i + width]
                if value != 0.0:
                    residual -= value * x[j]
                    weight = size_of(value)
                    size += weight * sizes[j]
                    row += weight * columns[j]
            scale[i] = 1.0 / row if row > 0.0 else 1.0
            coarse = max(coarse, scale[i])
            s, r, begin = abs(shift[b] + (i // n - cut) * omega[b]), i % n, i - i % n
            for j in range(n):  # the parts of the block may cancel: each is rounded
                weight = s * s * abs(mass[b][r][j]) + s * abs(rates[b][r][j])
                for q in range(len(means[b])):
                    weight += abs(means[b][q][r][j])
                size += weight * sizes[begin + j]
            total += (size_of(residual) + (6.0 + s * longest) * EPS * size) * scale[i]
        edge = max(scale[n - 1], scale[rows - 1])
        for i in range(n):
            edge = max(edge, scale[i], scale[rows - 1 - i])
        beyond = left_out(halves[b], x, cut, n) * edge
        total += beyond + coarse * n * (unknown[b][0] * whole + unknown[b][1])
        norm = inverse_norm(band, width, pivots, columns, scale, x)
        for i in range(rows):
            out[b, i] = x[i]
        out[b, rows], out[b, rows + 1] = total * norm, beyond
