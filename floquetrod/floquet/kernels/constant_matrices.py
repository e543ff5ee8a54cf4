"""Kernels for x' = A x, A constant on each piece of a period, of up to four equations: multipliers with errors.

Neighbours of an array stand side by side, as in `system_even_lanes`: every loop over them is innermost.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod._util.compilation import kernel, over_chunks
from floquetrod.floquet.kernels.constant_pieces import pairs_of_map
from floquetrod.floquet.kernels.system_even_lanes import LANES
from floquetrod.floquet.kernels.system_series import ROUNDING, run_of

MOST_ROWS = 4
"""Equations of first order: of more the polynomial of the multipliers keeps too few digits (a choice)."""

_TERMS = tuple(1.0 / math.factorial(k) for k in range(17))
"""Coefficients of the exponential series, each rounded once: squaring doubles what 1 would be off."""

_REACH = 0.8
"""Norm up to which a Taylor polynomial of degree 16 has a remainder below rounding."""

_MOST_HALVINGS = 12
"""Of a matrix: each doubles the errors of its neighbours, too (a choice)."""

_LARGEST = 1e70
"""Norm of a map up to which its polynomial stays in the range of doubles."""

_MOST_SWEEPS = 24
"""Over the roots of a polynomial: simple ones take about eight (a choice)."""

_ANGLES = (0.7, 2.5, 4.1, 5.9)
"""Where the search for roots starts on a circle: not symmetric about the real axis, or no root would become real."""

_COMPILE_AFTER = 1000.0
"""Milliseconds of general maps, as estimated, after which a process compiles these kernels (heuristic)."""

_MILLISECONDS = 3.0
"""That interpreted kernels take for the general map of a system, about (measured)."""


def piece_multipliers(
    matrices: Floats, length: Floats, uncertainty: Floats, *, paired: bool
) -> tuple[Complexes, Floats] | None:
    """Return the multipliers of x' = A x with radii of discs that together hold them, (b, N) each.

    Where ``paired``, return y = (mu + 1/mu - 2) / 4 of the pairs mu, 1 / mu with bounds of their errors, (b, N / 2)
    each.

    Parameters
    ----------
    matrices : numpy.ndarray, (b, P, N, N)
        A on each piece; N is 1 to 4, and even where ``paired``.
    length : numpy.ndarray, (b, P)
        Durations of the pieces.
    uncertainty : numpy.ndarray, (N, N)
        Errors of the entries of A.

    Returns
    -------
    values : numpy.ndarray, complex
        NaN where they are not computed.
    radii : numpy.ndarray
        As many values lie in discs that touch each other as there are discs; infinite where a map grows too much.
        None for both where there are fewer than eight systems, or too few in a process to compile the kernels.
    """
    fill = paired_fill if paired else multipliers_fill
    batch, count = len(length), matrices.shape[-1] // (1 + paired)
    if batch < LANES or run_of(fill, _COMPILE_AFTER, lambda: _MILLISECONDS * batch) is fill:
        return None
    out = np.empty((batch, 3 * count))
    over_chunks(fill, (matrices, length), out, uncertainty, workers=1, interpret_up_to=0)
    values = np.empty((batch, count), dtype=np.complex128)
    values.real, values.imag = out[:, :count], out[:, count : 2 * count]
    return values, out[:, 2 * count :]


@kernel
def multipliers_fill(matrices: Any, length: Any, out: Any, uncertainty: Any) -> None:
    """Fill rows of ``out`` with the real parts, the imaginary parts and the radii of all multipliers."""
    # Multipliers are m plus the roots of det(z - (M - m)): `lane_maps` gives the map M, `lane_polynomial` the
    # coefficients, `start_roots` and `lane_roots` the roots z, `lane_radii` the radii.  Of two equations or one the
    # start is the root.  vectors[8] holds the error of M, vectors[9] m.  LANES systems are done at a time, along the
    # last index of every array; a chunk with fewer repeats its last system, and nothing of the copies is written.
    n = len(matrices[0][0])
    work = lane_workspace(len(length[0]), n)
    total, z, polynomial, vectors = work[3], work[4], work[5], work[6]
    c = np.empty(n)
    for start in range(0, len(out), LANES):
        lane_maps(matrices, length, uncertainty, start, min(LANES, len(out) - start), work)
        # Of M - m, m the mean of its eigenvalues: where these are close to each other, digits are kept.
        for lane in range(LANES):
            vectors[9, lane] = 0.0
        for i in range(n):
            for lane in range(LANES):
                vectors[9, lane] += total[i, i, lane] / n
        for i in range(n):
            for lane in range(LANES):
                vectors[8, lane] += EPS * (abs(total[i, i, lane]) + abs(vectors[9, lane]))
                total[i, i, lane] -= vectors[9, lane]
        lane_polynomial(work)
        for lane in range(LANES):
            for k in range(n):
                c[k] = polynomial[0, k, lane]
            start_roots(c, z, lane)
        if n > 2:
            lane_roots(work)
        lane_radii(work)
        for lane in range(min(LANES, len(out) - start)):
            lost = not vectors[8, lane] < math.inf
            for i in range(n):
                radius = z[2, i, lane] + EPS * (abs(vectors[9, lane]) + abs(z[0, i, lane]))
                lost = lost or not radius < math.inf
                out[start + lane, i] = vectors[9, lane] + z[0, i, lane]
                out[start + lane, n + i], out[start + lane, 2 * n + i] = z[1, i, lane], radius
            if lost:
                for i in range(n):
                    out[start + lane, i], out[start + lane, n + i] = math.nan, math.nan
                    out[start + lane, 2 * n + i] = math.inf


@kernel
def paired_fill(matrices: Any, length: Any, out: Any, uncertainty: Any) -> None:
    """Fill rows of ``out`` with the real parts, the imaginary parts and the errors of y of all pairs."""
    n = len(matrices[0][0])
    work = lane_workspace(len(length[0]), n)
    total, vectors = work[3], work[6]
    matrix = np.empty((n, n))
    for start in range(0, len(out), LANES):
        used = min(LANES, len(out) - start)
        lane_maps(matrices, length, uncertainty, start, used, work)
        for lane in range(used):
            row = out[start + lane]
            if vectors[8, lane] < math.inf:
                for i in range(n):
                    for q in range(n):
                        matrix[i, q] = total[i, q, lane]
                pairs_of_map(matrix, vectors[8, lane], row)
            else:
                for i in range(n // 2):
                    row[i], row[n // 2 + i], row[n + i] = math.nan, math.nan, math.inf


@kernel
def lane_workspace(count: int, n: int) -> Any:
    """Return the arrays that the lanes work in, for ``count`` pieces of ``n`` equations."""
    return (
        np.empty((count, n, n, LANES)),  # A h of each piece, balanced
        np.empty((count, n, n, LANES)),  # maps over the pieces
        np.empty((6, n, n, LANES)),  # powers of a matrix, products
        np.empty((n, n, LANES)),  # the map over all pieces
        np.empty((3, n, LANES)),  # real and imaginary parts of the roots, radii
        np.empty((2, n, LANES)),  # coefficients of the polynomial, their errors
        np.empty((12, LANES)),  # norms and their workspace (0 to 5); error of a matrix, of its exponential, of the map
        np.empty((2, count, LANES)),  # errors of the maps over the pieces, norms of what acts before
        np.empty((n, LANES)),  # scaling
    )


@kernel
def lane_maps(matrices: Any, length: Any, uncertainty: Any, start: int, used: int, work: Any) -> None:
    """Set the maps D^-1 M D over all pieces of ``used`` systems, and their errors in the Frobenius norm.

    D is diagonal and balances the rows and columns of all A h.  Errors are not finite where a map is too large.
    """
    # M = exp(A_P h_P) .. exp(A_1 h_1).  One D serves all pieces, since the product of the scaled maps is scaled by it
    # too: it comes first, then each exponential with its error, then the product.  vectors[6] is the error of A h:
    # h |D^-1 U D| for errors U of A, and two roundings of |A h|; vectors[1] has squares of norms, of `lane_norms`.
    steps, maps, small, total, _, _, vectors, of_pieces, scaling = work
    count, n = len(steps), len(scaling)
    for lane in range(LANES):
        b = start + min(lane, used - 1)
        for j in range(count):
            for i in range(n):
                for q in range(n):
                    steps[j, i, q, lane] = length[b][j] * matrices[b][j][i][q]
    lane_balance(steps, scaling, small[0], vectors)
    for j in range(count):
        # The rounding of h and of the balanced A h, beside the error of A.
        lane_norms(steps[j], vectors)
        for lane in range(LANES):
            vectors[6, lane] = 0.0
        for i in range(n):
            for q in range(n):
                for lane in range(LANES):
                    stretched = uncertainty[i][q] * scaling[q, lane] / scaling[i, lane]
                    vectors[6, lane] += stretched * stretched
        for lane in range(LANES):
            b = start + min(lane, used - 1)
            vectors[6, lane] = length[b][j] * math.sqrt(vectors[6, lane]) + 2.0 * EPS * math.sqrt(vectors[1, lane])
        lane_exponential(steps[j], maps[j], small, vectors)
        for lane in range(LANES):
            of_pieces[0, j, lane] = vectors[7, lane]
    lane_chain(maps, total, small, vectors, of_pieces)
    lane_norms(total, vectors)
    for lane in range(LANES):
        if not vectors[1, lane] < _LARGEST * _LARGEST:
            vectors[8, lane] = math.inf


@kernel
def lane_balance(steps: Any, scaling: Any, sizes: Any, v: Any) -> None:
    """Replace matrices X by D^-1 X D, D = diag(scaling), in which rows and columns of their sum are about as large."""
    # E. E. Osborne, J. ACM 7 (1960) 338, doi:10.1145/321043.321048, on S = sum_j |X_j|, ``sizes``.  With r and c the
    # sums of row i and of column i without the diagonal, row i is divided and column i multiplied by sqrt(r / c), which
    # makes the two equal; v[0] is that factor, v[1] its inverse.  Three sweeps over i, then D is applied to all X.
    count, n = len(steps), len(scaling)
    for i in range(n):
        for lane in range(LANES):
            scaling[i, lane] = 1.0
        for q in range(n):
            for lane in range(LANES):
                sizes[i, q, lane] = 0.0
    for j in range(count):
        for i in range(n):
            for q in range(n):
                for lane in range(LANES):
                    sizes[i, q, lane] += abs(steps[j, i, q, lane])
    for _ in range(3):
        for i in range(n):
            for lane in range(LANES):
                v[0, lane], v[1, lane] = 0.0, 0.0
            for q in range(n):
                if q != i:
                    for lane in range(LANES):
                        v[0, lane] += sizes[i, q, lane]
                        v[1, lane] += sizes[q, i, lane]
            for lane in range(LANES):
                quotient = v[0, lane] / v[1, lane] if v[1, lane] > 0.0 else 0.0
                v[0, lane] = math.sqrt(quotient) if 1e-100 < quotient < 1e100 else 1.0
                v[1, lane] = 1.0 / v[0, lane]
                scaling[i, lane] *= v[0, lane]
            for q in range(n):
                if q != i:
                    for lane in range(LANES):
                        sizes[i, q, lane] *= v[1, lane]
                        sizes[q, i, lane] *= v[0, lane]
    for i in range(n):
        for q in range(n):
            if q != i:
                for lane in range(LANES):
                    v[0, lane] = scaling[q, lane] / scaling[i, lane]
                for j in range(count):
                    for lane in range(LANES):
                        steps[j, i, q, lane] *= v[0, lane]


@kernel
def lane_norms(a: Any, v: Any) -> None:
    """Set v[0] to bounds of the 2-norms of matrices, v[1] to the squares of their Frobenius norms."""
    n = len(a)
    for lane in range(LANES):
        v[1, lane], v[2, lane], v[3, lane] = 0.0, 0.0, 0.0
    for i in range(n):
        for lane in range(LANES):
            v[4, lane], v[5, lane] = 0.0, 0.0
        for q in range(n):
            for lane in range(LANES):
                v[1, lane] += a[i, q, lane] * a[i, q, lane]
                v[4, lane] += abs(a[i, q, lane])
                v[5, lane] += abs(a[q, i, lane])
        for lane in range(LANES):
            v[2, lane], v[3, lane] = max(v[2, lane], v[4, lane]), max(v[3, lane], v[5, lane])
    for lane in range(LANES):
        v[0, lane] = math.sqrt(min(v[1, lane], v[2, lane] * v[3, lane]))


@kernel
def lane_multiply(a: Any, b: Any, out: Any) -> None:
    """Set ``out`` to the products of matrices."""
    n = len(a)
    for i in range(n):
        for q in range(n):
            for lane in range(LANES):
                out[i, q, lane] = a[i, 0, lane] * b[0, q, lane]
            for j in range(1, n):
                for lane in range(LANES):
                    out[i, q, lane] += a[i, j, lane] * b[j, q, lane]


@kernel
def lane_copy(a: Any, out: Any) -> None:
    """Set ``out`` to copies of matrices."""
    for i in range(len(a)):
        for q in range(len(a)):
            for lane in range(LANES):
                out[i, q, lane] = a[i, q, lane]


@kernel
def lane_exponential(x: Any, out: Any, small: Any, v: Any) -> None:
    """Set ``out`` to exp(X) of matrices X in error by v[6], and v[7] to the errors, both in the Frobenius norm.

    v[0] and v[1] are the norms of X as of `lane_norms`.  Errors are not finite where X or its exponential is too large.
    """
    # exp(X) = T(X / 2^s)^(2^s) with the Taylor polynomial T of degree 16, evaluated as a polynomial of degree 4 in X^4
    # (M. S. Paterson and L. J. Stockmeyer, SIAM J. Comput. 2 (1973) 60, doi:10.1137/0202007).
    n = len(x)
    largest, halvings = 0.0, 0
    for lane in range(LANES):
        usable = v[0, lane] <= _REACH * 2.0**_MOST_HALVINGS
        if usable:
            largest = max(largest, v[0, lane])
        v[7, lane] = 0.0 if usable else math.inf
    while largest > _REACH:
        largest *= 0.5
        halvings += 1
    first, second, third, fourth, other = small[0], small[1], small[2], small[3], small[4]
    scale = 0.5**halvings
    for i in range(n):
        for q in range(n):
            for lane in range(LANES):
                first[i, q, lane] = scale * x[i, q, lane] if v[7, lane] == 0.0 else 0.0
    lane_multiply(first, first, second)
    lane_multiply(first, second, third)
    lane_multiply(second, second, fourth)
    # Blocks of four terms of T, from the last.
    for i in range(n):
        for q in range(n):
            for lane in range(LANES):
                out[i, q, lane] = _TERMS[16] * fourth[i, q, lane]
    for block in range(3, -1, -1):
        constant, one, two, three = (
            _TERMS[4 * block],
            _TERMS[4 * block + 1],
            _TERMS[4 * block + 2],
            _TERMS[4 * block + 3],
        )
        for i in range(n):
            for q in range(n):
                for lane in range(LANES):
                    terms = two * second[i, q, lane] + one * first[i, q, lane]
                    out[i, q, lane] += three * third[i, q, lane] + terms
            for lane in range(LANES):
                out[i, i, lane] += constant
        if block > 0:
            lane_multiply(fourth, out, other)
            lane_copy(other, out)
    # Roundings: two of X, n + 4 of X^2 / 2, 2 n + 5 of X^3 / 6, 9 n + 25 at most of any later term that matters, and of
    # the sum; then the remainder of the series; then the error of X.  v[8] bounds the exponential by exp(m), m the
    # largest eigenvalue of (X + X^T) / 2, by its rows at most.
    for lane in range(LANES):
        size, length, slip = scale * v[0, lane], scale * math.sqrt(v[1, lane]), scale * v[6, lane]
        square = length * length
        later = square * square / (24.0 - 4.8 * length)
        error = 2.0 * length + square * (0.5 * n + 2.0 + (2.0 * n + 5.0) * length / 6.0) + (9.0 * n + 25.0) * later
        error = ROUNDING * (error + math.sqrt(1.0 * n) + length + square * (0.5 + length / 6.0) + later)
        error += length * size**16 / 3.3e14 + 2.3 * slip * (1.0 + slip)
        v[7, lane] = error + v[7, lane] if slip < 1.0 else math.inf
        v[8, lane] = -math.inf
    for i in range(n):
        for lane in range(LANES):
            v[9, lane] = x[i, i, lane]
        for q in range(n):
            if q != i:
                for lane in range(LANES):
                    v[9, lane] += 0.5 * abs(x[i, q, lane] + x[q, i, lane])
        for lane in range(LANES):
            v[8, lane] = max(v[8, lane], v[9, lane])
    for lane in range(LANES):
        inverse = 1.0 - min(scale * v[8, lane], 1.0) / 8.0
        inverse *= inverse
        inverse *= inverse
        v[8, lane] = 1.0 / (inverse * inverse)
    for _ in range(halvings):
        lane_norms(out, v)
        lane_multiply(out, out, other)
        lane_copy(other, out)
        for lane in range(LANES):
            error = v[7, lane]
            v[7, lane] = (2.0 * min(v[0, lane], v[8, lane]) + error) * error + ROUNDING * n * v[1, lane]
            v[8, lane] *= v[8, lane]


@kernel
def lane_chain(maps: Any, total: Any, small: Any, v: Any, of_pieces: Any) -> None:
    """Set ``total`` to the products of the maps, the first acting first, and v[8] to their errors, as `chain_error`."""
    # An error e_j of map j changes the product by |M_P .. M_(j+1)| e_j |M_(j-1) .. M_1| to first order.  Norms of what
    # acts before j are kept while the product is formed, in ``before``; a second pass, from the last map down, forms
    # what acts after j in ``suffix``.  Terms of second order and more are bounded through v[9], the sum of e_j / |M_j|.
    count, n = len(maps), len(total)
    other, suffix = small[0], small[1]
    errors, before = of_pieces[0], of_pieces[1]
    lane_copy(maps[0], total)
    for j in range(1, count):
        lane_norms(total, v)
        for lane in range(LANES):
            before[j, lane] = v[0, lane]
        lane_multiply(maps[j], total, other)
        lane_copy(other, total)
    for lane in range(LANES):
        v[6, lane], v[8, lane], v[9, lane] = 1.0, 0.0, 0.0  # norm of what acts after, error, sum of relative errors
        before[0, lane] = 1.0
    lane_copy(maps[count - 1], suffix)
    for j in range(count - 1, -1, -1):
        if j < count - 1:
            lane_norms(suffix, v)
            for lane in range(LANES):
                v[6, lane] = v[0, lane]
            if j > 0:
                lane_multiply(suffix, maps[j], other)
                lane_copy(other, suffix)
        lane_norms(maps[j], v)
        rounding = ROUNDING * (n + 2.0) * math.sqrt(1.0 * n) if j > 0 else 0.0
        for lane in range(LANES):
            local = errors[j, lane] + rounding * v[0, lane]
            v[8, lane] += v[6, lane] * local * before[j, lane]
            v[9, lane] += local / v[0, lane]
    for lane in range(LANES):
        share = count * v[9, lane]
        v[8, lane] = v[8, lane] * (1.0 + 2.0 * share) if share < 0.5 else math.inf


@kernel
def lane_polynomial(work: Any) -> None:
    """Set the coefficients c of det(z - M) = z^n + c[0] z^(n-1) + ... + c[n-1], and their errors; M's are v[8]."""
    # Faddeev and LeVerrier: B_0 = 1, c_k = -tr(M B_(k-1)) / k, B_k = M B_(k-1) + c_k.  A change of M by E changes c_k
    # by -tr(E B_(k-1)) to first order; the terms of order two and more are bounded by the number of minors of order k.
    # v[6] is the Frobenius norm of B, v[7] the error of B that rounding has caused.
    small, matrix, c, slips, v = work[2], work[3], work[5][0], work[5][1], work[6]
    n = len(matrix)
    b, product = small[0], small[1]
    lane_norms(matrix, v)
    for lane in range(LANES):
        v[6, lane], v[7, lane], v[10, lane], v[11, lane] = math.sqrt(1.0 * n), 0.0, v[0, lane], math.sqrt(v[1, lane])
    lane_copy(matrix, product)
    minors = 1.0
    for k in range(1, n + 1):
        minors *= (n - k + 1.0) / k
        if k > 1:
            lane_multiply(matrix, b, product)
        for lane in range(LANES):
            v[0, lane], v[1, lane] = 0.0, 0.0
        for i in range(n):
            for lane in range(LANES):
                v[0, lane] += product[i, i, lane]
                v[1, lane] += abs(product[i, i, lane])
        for lane in range(LANES):
            error, size, whole, norm = v[8, lane], v[10, lane], v[11, lane], v[6, lane]
            c[k - 1, lane] = -v[0, lane] / k
            lost = (whole * v[7, lane] + ROUNDING * n * (whole * norm + v[1, lane])) / k
            more = 0.0
            if k > 1:
                more = 0.5 * k * (k - 1.0) * minors * error * error
                for _ in range(k - 2):
                    more *= size + error
            slips[k - 1, lane] = norm * error + more + lost
            v[7, lane] = size * v[7, lane] + ROUNDING * n * whole * norm + math.sqrt(1.0 * n) * lost
        lane_copy(product, b)
        for i in range(n):
            for lane in range(LANES):
                b[i, i, lane] += c[k - 1, lane]
        lane_norms(b, v)
        for lane in range(LANES):
            v[6, lane] = math.sqrt(v[1, lane])
            v[7, lane] += ROUNDING * v[6, lane]


@kernel
def start_roots(c: Any, z: Any, lane: int) -> None:
    """Set a lane of ``z`` to the roots of z^n + c[0] z^(n-1) + ... + c[n-1], n = 1 or 2, or to points near them."""
    # Of a quadratic the root of larger modulus comes first, free of cancellation, and the other is c[1] over it.
    n = len(c)
    if n == 1:
        z[0, 0, lane], z[1, 0, lane] = -c[0], 0.0
        return
    if n == 2:
        middle = -0.5 * c[0]
        inside = middle * middle - c[1]
        root = math.sqrt(abs(inside))
        if inside < 0.0:
            z[0, 0, lane], z[1, 0, lane], z[0, 1, lane], z[1, 1, lane] = middle, root, middle, -root
            return
        far = middle + root if middle > 0.0 else middle - root
        z[0, 0, lane], z[1, 0, lane], z[1, 1, lane] = far, 0.0, 0.0
        z[0, 1, lane] = c[1] / far if far != 0.0 else 0.0
        return
    # Radii of circles are slopes of the upper hull of the points (k, log |c_k|) (D. A. Bini, Numerical Algorithms 13
    # (1996) 179, doi:10.1007/BF02207694).
    k, here = 0, 0.0
    while k < n:
        end, steepest, there = k + 1, -math.inf, 0.0
        for later in range(k + 1, n + 1):
            size = abs(c[later - 1])
            height = math.log(size) if size > 0.0 else -1e30
            slope = (height - here) / (later - k)
            if slope >= steepest:
                end, steepest, there = later, slope, height
        radius = math.exp(steepest) if steepest > -700.0 else 0.0
        for i in range(k, end):
            z[0, i, lane], z[1, i, lane] = radius * math.cos(_ANGLES[i]), radius * math.sin(_ANGLES[i])
        k, here = end, there


@kernel
def lane_roots(work: Any) -> None:
    """Move z from near the roots of z^n + c[0] z^(n-1) + ... + c[n-1] to them, by the iteration of Aberth."""
    # O. Aberth, Mathematics of Computation 27 (1973) 339, doi:10.2307/2005621: Newton's step, from which the other
    # roots are divided out, one root after another.
    z, c, v = work[4], work[5][0], work[6]
    n = z.shape[1]
    for _ in range(_MOST_SWEEPS):
        farthest = 0.0
        for i in range(n):
            # The polynomial (v[0], v[1]), its derivative (v[2], v[3]), the sum of 1 / (z_i - z_j) (v[4], v[5]).
            for lane in range(LANES):
                v[0, lane], v[1, lane], v[2, lane], v[3, lane], v[4, lane], v[5, lane] = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(n):
                for lane in range(LANES):
                    x, y = z[0, i, lane], z[1, i, lane]
                    p, q, s, t = v[0, lane], v[1, lane], v[2, lane], v[3, lane]
                    v[2, lane], v[3, lane] = s * x - t * y + p, s * y + t * x + q
                    v[0, lane], v[1, lane] = p * x - q * y + c[k, lane], p * y + q * x
            for j in range(n):
                if j != i:
                    for lane in range(LANES):
                        x, y = z[0, i, lane] - z[0, j, lane], z[1, i, lane] - z[1, j, lane]
                        square = x * x + y * y
                        inverse = 1.0 / square if square > 0.0 else 0.0
                        v[4, lane] += x * inverse
                        v[5, lane] -= y * inverse
            for lane in range(LANES):
                p, q = v[0, lane], v[1, lane]
                s = v[2, lane] - (p * v[4, lane] - q * v[5, lane])
                t = v[3, lane] - (p * v[5, lane] + q * v[4, lane])
                square = s * s + t * t
                inverse = 1.0 / square if square > 0.0 else 0.0
                x, y = (p * s + q * t) * inverse, (q * s - p * t) * inverse
                z[0, i, lane] -= x
                z[1, i, lane] -= y
                size = abs(z[0, i, lane]) + abs(z[1, i, lane])
                v[0, lane] = (abs(x) + abs(y)) / size if size > 0.0 else 0.0
            for lane in range(LANES):
                farthest = max(farthest, v[0, lane])
        if farthest < 1e-8:
            return


@kernel
def lane_radii(work: Any) -> None:
    """Set z[2] to radii of discs about z: all discs hold the roots of the polynomial; its errors are included.

    Discs that touch no other hold as many roots as there are discs.
    """
    # |z - z_i| <= n |p(z_i)| / prod |z_i - z_j| (B. T. Smith, J. ACM 17 (1970) 661, doi:10.1145/321607.321615), p with
    # its rounding and with the errors of its coefficients.
    z, c, slips, v = work[4], work[5][0], work[5][1], work[6]
    n = z.shape[1]
    for i in range(n):
        for lane in range(LANES):
            x, y = z[0, i, lane], z[1, i, lane]
            v[0, lane], v[1, lane], v[2, lane], v[3, lane], v[4, lane] = 1.0, 0.0, 1.0, 0.0, 1.0
            v[5, lane] = math.sqrt(x * x + y * y)
        for k in range(n):
            for lane in range(LANES):
                x, y, p, q = z[0, i, lane], z[1, i, lane], v[0, lane], v[1, lane]
                v[0, lane], v[1, lane] = p * x - q * y + c[k, lane], p * y + q * x
                v[2, lane] = v[2, lane] * v[5, lane] + abs(c[k, lane])
                v[3, lane] = v[3, lane] * v[5, lane] + slips[k, lane]
        for j in range(n):
            if j != i:
                for lane in range(LANES):
                    x, y = z[0, i, lane] - z[0, j, lane], z[1, i, lane] - z[1, j, lane]
                    v[4, lane] *= math.sqrt(x * x + y * y)
        for lane in range(LANES):
            value = abs(v[0, lane]) + abs(v[1, lane]) + v[3, lane] + 4.0 * n * EPS * v[2, lane]
            radius = n * value * (1.0 + 8.0 * n * EPS)
            z[2, i, lane] = radius / v[4, lane] if v[4, lane] > 0.0 else math.inf
