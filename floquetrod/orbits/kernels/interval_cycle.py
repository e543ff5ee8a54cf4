"""Kernels that eliminate the states between the intervals of a cycle, one after the other, with a border.

x_(i+1) - G_i x_i = K_i y for i = 0 .. N - 1, where y = (x_0, s, 1) has the state at the beginning, the free scalars
and a one for every right side, so that K_i has columns for each.  Two equations,

    F x_i = K y,    -G_i x_i + x_(i+1) = K_i y,

are turned by reflections of Householder until the lower n rows are free of x_i: the upper ones give R x_i = K' y -
A x_(i+1), the lower ones are the next equation F x_(i+1) = K y.  Being orthogonal, this is stable whatever the maps G
grow or shrink by.  What is left, F x_0 = K y, and the rows of the border are as many equations as x_0 and s have.

Source: S. J. Wright, SIAM J. Sci. Stat. Comput. 13 (1992) 742, doi:10.1137/0913044.  Layout: a row of ``work`` has the
n columns of x_i, the n of x_(i+1), and the w = n + S + q of y; of ``equations`` (N, n, w) the first n columns are the
maps, the others those of K_i for the scalars and the right sides.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.orbits.kernels.gauss_points import stages_fill

LARGEST_CONDITION = 1e8
"""Product of the norms of the last equations' matrix and its inverse, far from one whose zeros `bordered` sets aside (a
choice)."""

SINGULAR, NEARLY_SINGULAR = 1, 2
"""Outcomes of `bordered_fill`."""


@kernel
def reflect(work: Any, columns: int, vector: Any, dots: Any) -> None:
    """Make the first ``columns`` columns of ``work`` upper triangular by reflections.

    ``vector`` and ``dots`` have room for a column and a row.
    """
    rows, width = work.shape
    for j in range(columns):
        square = 0.0
        for r in range(j, rows):
            vector[r] = work[r, j]
            square += vector[r] * vector[r]
        if square == 0.0:
            continue
        root = math.copysign(math.sqrt(square), -work[j, j])
        half = square - root * work[j, j]  # half the square of the vector's length
        vector[j] -= root
        for c in range(j, width):
            dots[c] = 0.0
        for r in range(j, rows):
            for c in range(j, width):
                dots[c] += vector[r] * work[r, c]
        for r in range(j, rows):
            share = vector[r] / half
            for c in range(j, width):
                work[r, c] -= share * dots[c]


@kernel
def invert(matrix: Any, inverse: Any) -> float:
    """Fill the inverse of a matrix, the first columns of ``matrix``, which is overwritten.

    Return the product of both norms, of largest row sums; infinite where a pivot is zero.
    """
    # Gauss and Jordan: rows are exchanged for the largest pivot, and column k is eliminated above and below it.
    # N. J. Higham, Accuracy and Stability of Numerical Algorithms (2002), doi:10.1137/1.9780898718027, section 14.4.
    # The matrix has as many rows as a state and the scalars: the inverse costs little, and its norm is the condition.
    size = len(matrix)
    norm, other = 0.0, 0.0
    for i in range(size):
        total = 0.0
        for j in range(size):
            total += abs(matrix[i, j])
            inverse[i, j] = 1.0 if i == j else 0.0
        norm = max(norm, total)
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if not abs(matrix[best, k]) > 0.0:
            return math.inf
        for j in range(size):
            matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
            inverse[k, j], inverse[best, j] = inverse[best, j], inverse[k, j]
        pivot = matrix[k, k]
        for j in range(size):
            matrix[k, j] /= pivot
            inverse[k, j] /= pivot
        for i in range(size):
            share = matrix[i, k]
            if i != k:
                for j in range(size):
                    matrix[i, j] -= share * matrix[k, j]
                    inverse[i, j] -= share * inverse[k, j]
    for i in range(size):
        total = 0.0
        for j in range(size):
            total += abs(inverse[i, j])
        other = max(other, total)
    return norm * other


@kernel
def cycle_fill(equations: Any, states: Any, left: Any) -> bool:
    """Fill ``states`` (N, n, w), every x_i as a matrix applied to y, and ``left`` (n, w) with left y = 0.

    Return whether a block is singular.
    """
    count, n, width = equations.shape
    kept, work = np.empty((count, n, 2 * n + width)), np.empty((2 * n, 2 * n + width))
    vector, dots = np.empty(2 * n), np.empty(2 * n + width)
    # The rows of ``work`` are the upper equation F x_i = K y, moved up from the lower rows of the interval before, and
    # the lower one, -G_i x_i + x_(i+1) = K_i y.  `reflect` frees the lower rows of x_i; the upper ones are ``kept``.
    # After the last interval x_N = x_0, which gives ``left``; states follow backwards from R x_i = K' y - A x_(i+1).
    for a in range(n):  # x_0 = x_0 comes before the first interval
        for c in range(2 * n + width):
            work[n + a, c] = 1.0 if c == n + a or c == 2 * n + a else 0.0
    for i in range(count):
        for a in range(n):
            for c in range(2 * n + width):
                work[a, c] = work[n + a, c]
            for b in range(n):
                work[a, b], work[a, n + b] = work[n + a, n + b], 0.0
            for c in range(width):
                value = equations[i, a, c]
                work[n + a, 2 * n + c] = value if c >= n else 0.0
                if c < n:
                    work[n + a, c], work[n + a, n + c] = -value, 1.0 if c == a else 0.0
        reflect(work, n, vector, dots)
        for a in range(n):
            if work[a, a] == 0.0:
                return True
            for c in range(2 * n + width):
                kept[i, a, c] = work[a, c]
    for a in range(n):
        for c in range(width):
            left[a, c] = (work[n + a, n + c] if c < n else 0.0) - work[n + a, 2 * n + c]
            states[0, a, c] = 1.0 if a == c else 0.0
    for i in range(count - 1, 0, -1):
        row, here, after = kept[i], states[i], states[(i + 1) % count]
        for a in range(n - 1, -1, -1):
            for c in range(width):
                total = row[a, 2 * n + c]
                for b in range(n):
                    total -= row[a, n + b] * after[b, c]
                for b in range(a + 1, n):
                    total -= row[a, b] * here[b, c]
                here[a, c] = total / row[a, a]
    return False


@kernel
def bordered_fill(
    maps: Any, columns: Any, gaps: Any, rows: Any, corner: Any, targets: Any, scale: Any, inner: Any, constant: float,
    states: Any, left: Any, units: Any, nodes: Any, free: Any, stages: Any,
) -> int:  # fmt: skip
    """Solve the equations with a border: fill ``nodes`` (N, n, q) and ``free`` (S, q).

    And ``stages`` (N, m, n) with the changes at the Gauss points that the first solution makes, by ``inner`` and the
    factor ``constant`` as in `gauss_points.stages_fill`; none where ``inner`` has no rows.

    The maps (N, n, n), the columns of the scalars (N, n, S) and the right sides ``gaps`` (N, n, q) are those of the
    equations; the border is rows (S, N, n) times the states plus ``corner`` (S, S) times the scalars, equal to
    ``targets`` (S, q).  On the way the equations are written in units of ``scale`` (n,) for the states and of ``units``
    (S,) for the scalars, in which their columns have the sum 1, and each row of the border in one in which its sum is
    1: ``states`` as in `cycle_fill`, ``left`` (n + S, w) with left y = 0.  Return SINGULAR where a block is,
    NEARLY_SINGULAR where the last equations may be and ``nodes`` and ``free`` are not filled, else 0.
    """
    count, n, scalars = columns.shape
    size = n + scalars
    width = size + gaps.shape[2]
    equations = np.empty((count, n, width))
    # The cycle leaves n equations for y = (x_0, s, 1), and the border S more: its rows times the states, each of which
    # is a matrix applied to y, make the rows n .. n + S - 1 of ``left``.  Their inverse gives x_0 and s, and these all
    # states.  A large condition is returned and not solved: `bordered` then treats the singular direction apart.
    # Where an orbit does not depend on the parameter its column is rounding; the rows tell its unit then.
    for s in range(scalars):
        total, largest = 0.0, 1e-300
        for i in range(count):
            for a in range(n):
                total += abs(columns[i, a, s]) / scale[a]
        for r in range(scalars):
            largest = max(largest, abs(corner[r, s]))
        units[s] = 1.0 / max(total, largest)
    for i in range(count):
        for a in range(n):
            for c in range(n):
                equations[i, a, c] = maps[i, a, c] * (scale[c] / scale[a])
            for s in range(scalars):
                equations[i, a, n + s] = columns[i, a, s] * (units[s] / scale[a])
            for q in range(width - size):
                equations[i, a, size + q] = gaps[i, a, q] / scale[a]
    if cycle_fill(equations, states, left):
        return SINGULAR
    for r in range(scalars):
        total = 1e-300
        for c in range(n, width):
            value = corner[r, c - n] * units[c - n] if c < size else -targets[r, c - size]
            total += abs(value) if c < size else 0.0
            left[n + r, c] = value
        for c in range(n):
            left[n + r, c] = 0.0
        for i in range(count):
            for a in range(n):
                share = rows[r, i, a] * scale[a]
                total += abs(share)
                for c in range(width):
                    left[n + r, c] += share * states[i, a, c]
        for c in range(width):
            left[n + r, c] /= total
    matrix, inverse, answer = np.empty((size, size)), np.empty((size, size)), np.empty(size)
    for r in range(size):
        for c in range(size):
            matrix[r, c] = left[r, c]
    if not invert(matrix, inverse) < LARGEST_CONDITION:
        return NEARLY_SINGULAR
    for q in range(width - size):
        for r in range(size):
            answer[r] = 0.0
            for c in range(size):
                answer[r] -= inverse[r, c] * left[c, size + q]
        for i in range(count):
            for a in range(n):
                total = states[i, a, size + q]
                for c in range(size):
                    total += states[i, a, c] * answer[c]
                nodes[i, a, q] = total * scale[a]
        for s in range(scalars):
            free[s, q] = answer[n + s] * units[s]
    stages_fill(inner, nodes[:, :, 0], constant, free[:, 0], stages)
    return 0
