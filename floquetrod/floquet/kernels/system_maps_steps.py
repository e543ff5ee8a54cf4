"""Kernels that carry x' = A(t) x over a step by a Taylor series about its centre, used to both sides.

The two halves of x are kept apart: where the first is q and the second its velocity, rows of q' = E p cost nothing,
and matrices that act on the velocities alone are often constant.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.floquet.kernels.system_series import ROUNDING, invert, multiply, spectral_bound

_PLAIN_UP_TO = 64
"""Multiplications a term of the past may take before BLAS is called for them (heuristic)."""


@kernel
def is_companion(a: Any) -> bool:
    """Return whether the upper half of all matrices says q' = E p, E diagonal and constant."""
    # Upper rows [0, E], E diagonal, of the mean a[0], and zero of all harmonics: x = (q, p) with q' = E p.
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

    Rows ``top`` and below of the result are kept.  The mean comes first, whether zero or not; a slope, which is there
    where ``a`` has an even number of matrices, has the number 1 + 2 ``used``.
    """
    # Most entries of A are zero: of the columns left..right and rows from ``top`` on only matrices that are not are
    # kept. kept[group] is the number of a matrix: 0 the mean, 1 to ``used`` cosines, the next ``used`` sines, 1 + 2
    # used the slope; ``place`` is its number in ``a``, which holds the harmonics dropped, too. matrices[group, j rows +
    # r] is its entry (top + r, left + j): transposed, so that sums over lags are one product.
    count, n = (a.shape[0] - 1) // 2, a.shape[1]
    rows, width = n - top, right - left
    last = 2 * used + a.shape[0] - 2 * count
    kept = np.zeros(last, dtype=np.int64)
    groups = 1
    for g in range(1, last):
        place = g if g <= used else g - used + count
        if g > 2 * used:
            place = 2 * count + 1
        nonzero = False
        for r in range(top, n):
            for j in range(left, right):
                nonzero = nonzero or a[place, r, j] != 0.0
        if nonzero:
            kept[groups] = g
            groups += 1
    matrices = np.empty((groups, width * rows))
    norms = np.empty(groups)
    for g in range(groups):
        place = kept[g] if kept[g] <= used else kept[g] - used + count
        if kept[g] > 2 * used:
            place = 2 * count + 1
        norms[g] = spectral_bound(a[place, top:, left:right])
        for j in range(width):
            for r in range(rows):
                matrices[g, j * rows + r] = a[place, top + r, left + j]
    return kept[:groups].copy(), matrices, norms


@kernel
def part_lags(
    kept: Any, norms: Any, used: int, angle: float, h: float, order: int, tolerance: float
) -> tuple[int, float]:
    """Return how many terms of the past matter, and the error of leaving out those before: the integral of a norm.

    ``angle`` is w h; times and rates are in units of h.
    """
    # The Taylor coefficient l of a harmonic's factor, in units of h, is at most rate^l / l!, rate = k w h: ``powers``
    # are these times the norms of the matrices.  Without the coefficients from ``lag`` on A is wrong by at most left
    # x^lag, x = t / h, the geometric series of ratio rate / (lag + 1) included, of integral left / (lag + 1).  A slope
    # has the coefficient 1 alone.  The smallest number of lags whose integral is below the tolerance is returned, and
    # that integral.
    powers = norms[1:].copy()
    for lag in range(1, order + 1):
        left = 0.0
        for g in range(len(powers)):
            if kept[1 + g] > 2 * used:
                left += powers[g] * h if lag == 1 else 0.0
                continue
            rate = angle * ((kept[1 + g] - 1) % used + 1)
            powers[g] *= rate / lag
            quotient = rate / (lag + 1.0)
            left += powers[g] / (1.0 - quotient) if quotient < 0.7 else math.inf
        if len(powers) == 0 or left / (lag + 1.0) < tolerance:
            return lag, left / (lag + 1.0)
    return order, 0.0


@kernel
def part_weights(kept: Any, used: int, lags: int, angle: float, h: float, place: int, whole: float, c: Any) -> None:
    """Set c[lag, g]: Taylor coefficients of the factors of the matrices, about ``place`` / ``whole`` of a period.

    A slope counts from the beginning, ``place`` times h before.
    """
    # Factors of the matrices: 1 of the mean, cos(k w t) and -sin(k w t) of Re and Im Z_k, t of a slope.  About the
    # centre, turned by k place / whole of a turn, which is reduced exactly while it is a whole number, (value, other)
    # are the factor and its derivative over k w, and follow from lag to lag by f_(l+1) = f'_l k w h / (l + 1), two
    # derivatives changing the sign.
    for lag in range(lags):
        c[lag, 0] = 0.0
    c[0, 0] = 1.0
    for g in range(1, len(kept)):
        if kept[g] > 2 * used:
            for lag in range(lags):
                c[lag, g] = place * h if lag == 0 else (h if lag == 1 else 0.0)
            continue
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
    # out = sum_lag A_lag x_(i-lag), A_lag = sum_g c[lag, g] M_g, where x_(i-lag) is row last + lag of x (columns j n +
    # q) and the tables have the entry (r, j) of a matrix at j rows + r.  Directly, A_lag is in ``table``: by loops
    # while small, else as one product of (rows, lags width) by (lags width, n).  Otherwise the past is mixed first,
    # mixed_g = sum_lag c[lag, g] x_(i-lag), and out = sum_g M_g mixed_g: fewer multiplications where lags are many and
    # harmonics few.
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
def part_work(
    a: Any, used: int, top: int, left: int, right: int, angle: float, h: float, order: int, tolerance: float
) -> Any:
    """Return what `step_map` keeps of rows left..right of x: terms, last first, matrices, weights, tables, lags."""
    n = a.shape[1]
    kept, matrices, norms = part_matrices(a, used, top, left, right)
    lags, left_out = part_lags(kept, norms, used, angle, h, order, tolerance)
    groups = len(kept)
    # A table of the Taylor coefficients of A, or the terms mixed first: whichever takes fewer multiplications.
    direct = lags * (n - top) <= groups * (lags + n - top)
    x = np.empty((order + 1, (right - left) * n))
    table = np.empty((lags if direct else 0, (right - left) * (n - top)))
    mixed = np.empty((0 if direct else groups, (right - left) * n))
    return x, kept, matrices, np.empty((lags, groups)), table, mixed, lags, left_out, direct


@kernel
def series_work(a: Any, used: int, angle: float, h: float, order: int, tolerance: float) -> Any:
    """Return the work of `step_map`: both halves of x, the factors of q' = E p where A has this form, and the rest."""
    # x is cut into halves, ``upper`` and ``lower``, each with its own matrices (columns), tables and lags; of a
    # companion form only rows from ``top`` on need products, and ``rates`` = E serve the others.  Then arrays of
    # `step_map`: forces of both halves, signs of the two sums, and three matrices.
    n = a.shape[1]
    half = max(n // 2, 1)
    companion = is_companion(a)
    top = half if companion else 0
    upper = part_work(a, used, top, 0, half, angle, h, order, tolerance)
    lower = part_work(a, used, top, half, n, angle, h, order, tolerance)
    rates = np.zeros(top)
    for i in range(top):
        rates[i] = a[0, i, top + i]
    rows = n - top
    return upper, lower, rates, np.empty((2, rows, n)), np.empty((2, order + 1)), np.empty((3, n, n))


@kernel
def add_sides(ends: Any, first: int, sides: Any) -> None:
    """Set rows of the maps to both sides, from row ``first`` on."""
    n = sides.shape[2]
    for side in range(2):
        for q in range(ends.shape[1]):
            sides[side, first + q // n, q % n] = ends[side, q]


@kernel
def step_map(
    work: Any, used: int, angle: float, h: float, place: int, whole: float, order: int, ratio: float, phase: float,
    dropped: float, result: Any,
) -> float:  # fmt: skip
    """Set ``result`` to the map from h before to h after a centre, ``place`` / ``whole`` of a period; return its error.

    The solution that is the identity at the centre is summed to both sides.
    """
    # x_(i+1) = h / (i + 1) sum_l (A_l x_(i-l)), A_l the Taylor coefficients of A about the centre in units of h.  Terms
    # are stored backwards, term i in row order - i, so that the sum over lags reads memory forwards.  x holds the first
    # half of the unknowns, z the second: rows of q' = E p are a multiplication by ``rates``; ``one`` and ``two`` are
    # the forces of both halves.  The sum with all signs plus is the map to h after, with alternating signs to h before
    # the centre; the second one is inverted.  ``rest`` is `tail`, ``size`` the sum of norms, from which the rounding is
    # bounded.
    upper, lower, rates, force, signs, sides = work
    x, kept_x, matrices_x, c_x, table_x, mixed_x, lags_x, left_x, direct_x = upper
    z, kept_z, matrices_z, c_z, table_z, mixed_z, lags_z, left_z, direct_z = lower
    n, top = sides.shape[1], len(rates)
    half, rows = max(n // 2, 1), n - top
    part_weights(kept_x, used, lags_x, angle, h, place, whole, c_x)
    if direct_x:
        np.dot(c_x, matrices_x, table_x)
    if half < n:
        part_weights(kept_z, used, lags_z, angle, h, place, whole, c_z)
        if direct_z:
            np.dot(c_z, matrices_z, table_z)
    for q in range(half * n):
        x[order, q] = 0.0
    for q in range((n - half) * n):
        z[order, q] = 0.0
    for r in range(n):
        if r < half:
            x[order, r * n + r] = 1.0
        else:
            z[order, (r - half) * n + r] = 1.0
    # The recurrence: newest term in row ``last``, the next one goes to row last - 1.
    one, two = force[0], force[1]
    for i in range(order):
        last = order - i
        factor = h / (i + 1.0)
        apply_part(x, last, min(lags_x, i + 1), c_x, matrices_x, table_x, direct_x, mixed_x, rows, n, one)
        if half < n:
            apply_part(z, last, min(lags_z, i + 1), c_z, matrices_z, table_z, direct_z, mixed_z, rows, n, two)
            for r in range(rows):
                for q in range(n):
                    one[r, q] += two[r, q]
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
    # Horner's rule of `tail`, oldest term first, and the sums of both sides in one product each.
    rest, size, shrink = 0.0, 0.0, ratio**-2.0
    for i in range(order + 1):
        square = np.dot(x[order - i], x[order - i])
        if half < n:
            square += np.dot(z[order - i], z[order - i])
        rest = shrink * (rest + square)
        size += math.sqrt(square)
        signs[0, i] = 1.0
        signs[1, i] = -1.0 if (order - i) % 2 == 1 else 1.0
    add_sides(np.dot(signs, x), 0, sides)
    if half < n:
        add_sides(np.dot(signs, z), half, sides)
    # Rounding: each term is a sum of products, and carried on by those after it.
    length = math.sqrt(1.0 * lags_x * half + lags_z * (n - half))
    error = math.sqrt(rest) / (1.0 - 1.0 / ratio) + ROUNDING * (6.0 + length) * (1.0 + phase) * size
    error += (dropped + left_x + left_z) * h * math.exp(phase) * math.sqrt(1.0 * n)
    # result = forth back^-1.  The error of an inverse is |back^-1|^2 |error|, to all orders over 1 - |back^-1| |error|.
    forth, size_back = spectral_bound(sides[0]), spectral_bound(sides[1])
    invert(sides[1], sides[2])
    multiply(sides[0], sides[2], result)
    inverse = spectral_bound(sides[2])
    slip = error + ROUNDING * 4.0 * n * size_back
    slip *= inverse * inverse / (1.0 - inverse * slip) if inverse * slip < 0.5 else math.inf
    return float(error * (inverse + slip) + forth * slip + ROUNDING * (n + 2.0) * forth * inverse)
