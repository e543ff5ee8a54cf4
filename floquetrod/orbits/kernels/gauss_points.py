"""Kernels that eliminate the Gauss points of every interval from the linearised equations of an orbit.

In an interval of length h the changes dz_j of the states at the m Gauss points obey, for changes dx of the state at its
beginning and ds of the free scalars,

    dz_j - h sum_k a_jk J_k dz_k = dx - r_j + h sum_k a_jk d_k ds,

with the integrals a_jk of the Lagrange polynomials, the derivatives J_k of f, the residuals r_j, and the changes d_k of
the rates by the scalars.  The m n equations are solved by Gaussian elimination with exchange of rows for n + 1 + S
right sides at once, and the change at the end of the interval follows by the weights b_k:

    dx' = dx + h sum_k b_k (J_k dz_k + d_k ds) - r.

Source: Ascher, Mattheij and Russell (doi:10.1137/1.9781611971231), section 5.6.  Layout: row j n + a of a matrix is the
component a at the Gauss point j; the columns of ``inner`` are the factors of dx, the constant, the factors of ds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel


@kernel
def factor(matrix: Any, pivots: Any) -> bool:
    """Factor a matrix in place, rows exchanged whole; return whether a pivot is zero."""
    size = len(matrix)
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        pivots[k] = best
        if matrix[best, k] == 0.0:
            return True
        if best != k:
            for j in range(size):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        upper = matrix[k, k + 1 :]
        for i in range(k + 1, size):
            share = matrix[i, k] / matrix[k, k]
            matrix[i, k] = share
            row = matrix[i, k + 1 :]
            for j in range(len(upper)):
                row[j] -= share * upper[j]
    return False


@kernel
def solve_factored(matrix: Any, pivots: Any, right: Any) -> None:
    """Replace right sides (m n, q) by the solutions with a factored matrix."""
    size, width = right.shape
    for k in range(size):
        best = pivots[k]
        if best != k:
            for c in range(width):
                right[k, c], right[best, c] = right[best, c], right[k, c]
    for k in range(size):
        upper = right[k]
        for i in range(k + 1, size):
            share, row = matrix[i, k], right[i]
            for c in range(width):
                row[c] -= share * upper[c]
    for k in range(size - 1, -1, -1):
        lower = right[k]
        for c in range(width):
            lower[c] /= matrix[k, k]
        for i in range(k):
            share, row = matrix[i, k], right[i]
            for c in range(width):
                row[c] -= share * lower[c]


@kernel
def largest_fill(nodes: Any, stages: Any, least_share: float, sizes: Any) -> None:
    """Fill ``sizes`` (n,) with the largest magnitude of each state at the mesh and at the Gauss points; NaN stays.

    Not less than ``least_share`` of the largest of all.
    """
    count, m, n = stages.shape
    most = 1e-150
    for a in range(n):
        largest = 0.0
        for i in range(count):
            if not abs(nodes[i, a]) <= largest:
                largest = abs(nodes[i, a])
            for j in range(m):
                if not abs(stages[i, j, a]) <= largest:
                    largest = abs(stages[i, j, a])
        sizes[a] = largest
        if least_share * largest > most:
            most = least_share * largest
    for a in range(n):
        if sizes[a] < most:
            sizes[a] = most


@kernel
def stages_fill(inner: Any, nodes: Any, constant: float, scalars: Any, stages: Any) -> None:
    """Fill the changes ``stages`` (N, m, n) that changes at the mesh and of the scalars make, by ``inner``."""
    count, m, n, width = inner.shape
    for i in range(count):
        for j in range(m):
            for a in range(n):
                factors = inner[i, j, a]
                total = constant * factors[n]
                for b in range(n):
                    total += factors[b] * nodes[i, b]
                for s in range(width - n - 1):
                    total += factors[n + 1 + s] * scalars[s]
                stages[i, j, a] = total


@kernel
def residual_fill(
    lengths: Any, integrals: Any, weights: Any, nodes: Any, stages: Any, rates: Any, winding: Any, residual: Any
) -> None:
    """Fill ``residual`` (N, m + 1, n): by how much the equations are missed at Gauss points and ends of intervals."""
    count, m, n = stages.shape
    for i in range(count):
        length, beginning, after = lengths[i], nodes[i], nodes[(i + 1) % count]
        for a in range(n):
            for j in range(m):
                total = 0.0
                for k in range(m):
                    total += integrals[j, k] * rates[i, k, a]
                residual[i, j, a] = stages[i, j, a] - beginning[a] - length * total
            total = 0.0
            for k in range(m):
                total += weights[k] * rates[i, k, a]
            end = after[a] + winding[a] if i == count - 1 else after[a]
            residual[i, m, a] = end - beginning[a] - length * total


@kernel
def condense_fill(
    lengths: Any, integrals: Any, weights: Any, jacobians: Any, drives: Any, residual: Any,
    factors: Any, pivots: Any, inner: Any, maps: Any, gaps: Any, columns: Any,
) -> bool:  # fmt: skip
    """Fill ``factors`` (N, m n, m n), ``pivots``, ``inner`` (N, m n, n + 1 + S) and the equations at the mesh.

    These have the maps (N, n, n), the gaps (N, n) and the columns of the scalars (N, n, S).  Return whether a matrix is
    singular.
    """
    # dz = (I - h a J)^-1 (dx - r + h a d ds), then dx' - dx = h b (J dz + d ds) - r, the equations of the head of this
    # file.  ``matrix`` is I - h a J, ``right`` first its right sides and, solved, the factors of dx, 1 and ds in dz.
    # ``end`` sums b (J dz + d ds) by the same columns; times h it gives the map, the gap and the scalars' columns.
    count, m, n, scalars = drives.shape
    width = n + 1 + scalars
    end = np.empty((n, width))
    for i in range(count):
        matrix, right = factors[i], inner[i]
        for j in range(m):
            for k in range(m):
                share = lengths[i] * integrals[j, k]
                for a in range(n):
                    for b in range(n):
                        matrix[j * n + a, k * n + b] = -share * jacobians[i, k, a, b]
            for a in range(n):
                row = j * n + a
                matrix[row, row] += 1.0
                for c in range(n):
                    right[row, c] = 0.0
                right[row, a] = 1.0
                right[row, n] = -residual[i, j, a]
                for s in range(scalars):
                    total = 0.0
                    for k in range(m):
                        total += integrals[j, k] * drives[i, k, a, s]
                    right[row, n + 1 + s] = lengths[i] * total
        if factor(matrix, pivots[i]):
            return True
        solve_factored(matrix, pivots[i], right)
        for a in range(n):
            for c in range(width):
                end[a, c] = 0.0
        for k in range(m):
            for a in range(n):
                for b in range(n):
                    share = weights[k] * jacobians[i, k, a, b]
                    for c in range(width):
                        end[a, c] += share * right[k * n + b, c]
                for s in range(scalars):
                    end[a, n + 1 + s] += weights[k] * drives[i, k, a, s]
        for a in range(n):
            for c in range(n):
                maps[i, a, c] = lengths[i] * end[a, c]
            maps[i, a, a] += 1.0
            gaps[i, a] = lengths[i] * end[a, n] - residual[i, m, a]
            for s in range(scalars):
                columns[i, a, s] = lengths[i] * end[a, n + 1 + s]
    return False


@kernel
def constants_fill(
    lengths: Any, weights: Any, jacobians: Any, residual: Any, factors: Any, pivots: Any, inner: Any, gaps: Any
) -> None:
    """Fill the changes ``inner`` (N, m n, 1) and ``gaps`` (N, n) that a residual makes, with matrices factored before.

    These are the constants among the columns of `condense_fill`.
    """
    count, m, n = residual.shape[0], residual.shape[1] - 1, residual.shape[2]
    for i in range(count):
        right = inner[i]
        for j in range(m):
            for a in range(n):
                right[j * n + a, 0] = -residual[i, j, a]
        solve_factored(factors[i], pivots[i], right)
        for a in range(n):
            total = 0.0
            for k in range(m):
                for b in range(n):
                    total += weights[k] * jacobians[i, k, a, b] * right[k * n + b, 0]
            gaps[i, a] = lengths[i] * total - residual[i, m, a]
