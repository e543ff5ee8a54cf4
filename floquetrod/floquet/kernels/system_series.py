"""Kernels shared by the maps of periodic systems: size of the coefficients, plan of a series, small dense algebra."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from floquetrod._util.compilation import compiled, is_at_hand, kernel, runner

ROUNDING = 1.1102230246251565e-16
MOST_TERMS = 40
"""Even terms of a series at most; where that is too few the segments are shortened."""

MOST_NUMBERS = 1 << 28
"""Numbers of the maps of a system at most, two gigabytes: longer products of maps are not attempted."""
LARGEST = 1e150
"""Coefficients beyond this are not usable: their squares overflow."""

OFTEN_ASKED: set[Any] = set()
"""Kernels that the process has asked for often enough to compile them, so that it need not be estimated again."""

_LOADING = 50  # milliseconds in which machine code kept on disk is loaded while numba runs (measured)
_PLAIN_UP_TO = 20
_MOST_PLANS = 10000
_HALF_LOG_TWO = 0.34657359027997264
_LOG_LARGEST = 600.0
_LARGEST_ANGLE = 700.0


def run_of(function: Callable[..., Any], compile_after: float, milliseconds: Callable[[], float]) -> Callable[..., Any]:
    """Return a kernel as it stands or compiled, in view of the milliseconds that it takes when interpreted.

    What a process has asked for before changes only how long an answer takes: both give the same bits.
    """
    if function in OFTEN_ASKED or compile_after == 0.0:
        return compiled(function)
    work = math.ceil(milliseconds())
    at_once = work > _LOADING and is_at_hand(function)
    run = compiled(function) if at_once else runner(function, work, interpret_up_to=1, compile_after=int(compile_after))
    if run is not function:
        OFTEN_ASKED.add(function)
    return run


def usable(mean: Any, harmonics: Any, period: Any) -> Any:
    """Say which systems (b,) are finite, and small enough for squares not to overflow."""
    small = (np.abs(mean) < LARGEST).all(axis=(1, 2)) & (np.abs(harmonics) < LARGEST).all(axis=(1, 2, 3))
    return small & (period > 1.0 / LARGEST) & (period < LARGEST)


@functools.cache
def reach(accuracy: float) -> float:
    """Return the largest phase (frequency times half the length of a segment) at which rounding stays below accuracy.

    The sum of a series of cosines of phase z loses a factor cosh z.
    """
    z = 4.0
    for _ in range(20):
        z = math.acosh(max(accuracy / (16.0 * ROUNDING * (1.0 + z)), 1.2))
    return min(max(z, 1.0), 9.0)


@kernel
def coefficient_bound(size: float, norms: Any, first: int, angle: float) -> float:
    """Bound |K| = |S + sum F_k cos(k w t)| over complex times t with |w Im t| <= angle."""
    total = size
    for k in range(len(norms)):
        if norms[k] > 0.0:  # the other factor may be infinite
            height = (k + first) * angle
            total += norms[k] * math.cosh(height) if height < _LARGEST_ANGLE else math.inf
    return total


@kernel
def plan_terms(
    size: float, norms: Any, first: int, omega: float, h: float, log_tolerance: float, squared: bool
) -> tuple[float, float, float]:
    """Return (terms, ratio, exponent) with which Cauchy's estimate of a Taylor remainder at h is smallest.

    The remainder beyond ``terms`` powers is exp(exponent) ratio^-terms, times factors of the caller: solutions grow by
    the integral of a(r), where a^2 (for ``squared``) or a is the bound of the coefficients, over the radius ratio h.
    a is convex, so that the trapezoidal rule bounds its integral.  Terms are infinite when no radius is usable.
    """
    # Cauchy: a solution that grows at most by exp(integral of a) on a circle of radius rho = ratio h has Taylor terms
    # below exp(exponent) ratio^-i at h, exponent = integral of a(r) from 0 to rho (A. Jorba and M. Zou, Experimental
    # Mathematics 14 (2005) 99).  ``needed`` terms take the remainder below the tolerance; radii grow by sqrt 2 from
    # step to step, as the exponent is summed by trapezoids, until ``needed`` rises again: it has one minimum.
    best, best_ratio, best_exponent = math.inf, 1.0, 0.0
    highest = (len(norms) - 1 + first) * omega * h
    inner, exponent = 0.0, 0.0
    ratio = 1.0
    rate = coefficient_bound(size, norms, first, 0.0)
    rate = math.sqrt(rate) if squared else rate
    for step in range(21):
        if highest * ratio > _LOG_LARGEST:
            break
        outer = coefficient_bound(size, norms, first, omega * h * ratio)
        outer = math.sqrt(outer) if squared else outer
        exponent += 0.5 * h * (ratio - inner) * (rate + outer)
        if exponent > _LOG_LARGEST:
            break
        if step > 0:
            needed = (exponent - log_tolerance) / (_HALF_LOG_TWO * step)
            if needed >= best:
                break
            best, best_ratio, best_exponent = needed, ratio, exponent
        inner, rate = ratio, outer
        ratio *= math.sqrt(2.0)
    return best, best_ratio, best_exponent


@kernel
def plan_segments(
    size: float, norms: Any, first: int, omega: float, whole: float, segments: int, accuracy: float, reach: float,
    most: int, squared: bool,
) -> tuple[int, int, float, float]:  # fmt: skip
    """Return (segments, order, ratio, phase) of the fewest segments, from ``segments`` on, that series can cross.

    A series reaches ``whole`` / segments to either side, where its phase is at most ``reach``.  It keeps ``order``
    powers; `tail` may use a radius of ``ratio`` times its reach.  ``segments`` are 0 where there is no such plan.
    """
    # Two limits: the phase, h times the mean of the rate sqrt(|K|) (or |A|) on the real times and on the circle of
    # radius h, is at most ``reach``, beyond which a sum of terms that size cancels too many digits; and Cauchy's
    # estimate must need no more terms than ``most`` (`plan_terms`).  The first number of segments that meets both is
    # taken, one more at a time: fewer and longer segments cost less.  Beyond 1000 trials the step grows, for the loop
    # to end.
    least = coefficient_bound(size, norms, first, 0.0)
    least = math.sqrt(least) if squared else least
    for trial in range(_MOST_PLANS):
        h = whole / segments
        bound = coefficient_bound(size, norms, first, omega * h)
        phase = 0.5 * h * (least + (math.sqrt(bound) if squared else bound))
        if phase <= reach:
            needed, ratio, _ = plan_terms(size, norms, first, omega, h, math.log(accuracy), squared)
            if needed <= most:
                # Every second power is zero about an instant of evenness.
                order = max(2 * int(0.5 * needed), 2) if squared else max(int(needed) + 1, 4)
                order, ratio = widest_circle(size, norms, first, omega, h, order, ratio, squared)
                if order <= 2 * MOST_TERMS - 2:
                    return segments, order, ratio, phase
        segments += 1 if trial < 1000 else 1 + segments // 16
        if segments > MOST_NUMBERS:
            break
    return 0, 0, 0.0, math.inf


@kernel
def widest_circle(
    size: float, norms: Any, first: int, omega: float, h: float, order: int, ratio: float, squared: bool
) -> tuple[int, float]:
    """Return (order, ratio): about the largest radius, ratio h, that `tail` may use, and the powers it takes.

    Off an instant of evenness, or with both parts of a harmonic together, the sum is sqrt(2) times larger.
    """
    # `tail` needs (ratio h)^2 |K|(ratio h) <= i (i - 1), or ratio h |A|(ratio h) <= i, at the first term left out:
    # ``there`` is its root, quotient = (order + 1) / there must be 1 or more, and close to 1 for the largest radius.
    # |K| grows with the radius like exp(growth ratio) at most, which is the power of the correction, a Newton step in
    # logarithms.  Where even 1.3 h is too wide, more terms are kept.
    growth = (0.5 if squared else 1.0) * (len(norms) - 1 + first) * omega * h
    for tries in range(200):
        there = 1.4143 * coefficient_bound(size, norms, first, omega * h * ratio)
        there = ratio * h * (math.sqrt(there) if squared else there)
        quotient = (order + 1.0) / max(there, 1e-3)
        if quotient >= 1.0 and (quotient < 1.1 or tries > 8 or ratio > 1e4):
            return order, ratio
        ratio *= quotient ** (1.0 / (1.0 + growth * ratio)) * (0.98 if quotient < 1.0 else 1.0)
        if ratio < 1.3:
            ratio = 1.3
            order += 2 if squared else 1
    return 4 * MOST_TERMS, ratio


@kernel
def weighted_sum(x: Any, last: int, weights: Any, k: int, most: int, length: int, out: Any, target: int) -> None:
    """Set out[target] = sum_l weights[k, l] x[last - l], l = 0..min(last, most), four rows at a time."""
    # The convolution of a series with a cosine: x (rows, length) are terms, newest in row ``last``, weights[k, l] the
    # Taylor coefficients of cosine k.  The first one to four lags are set, so that the others come in fours: ``out`` is
    # read and written once for four products, and the loop over q is all vectors.  Sums within a four are made in
    # pairs, an order that is the same in interpreted and compiled code.
    count = min(last, most) + 1
    a = weights[k, 0]
    lag = 1
    if count % 4 == 0:
        b, c, d = weights[k, 1], weights[k, 2], weights[k, 3]
        for q in range(length):
            out[target, q] = (a * x[last, q] + b * x[last - 1, q]) + (c * x[last - 2, q] + d * x[last - 3, q])
        lag = 4
    elif count % 4 == 3:
        b, c = weights[k, 1], weights[k, 2]
        for q in range(length):
            out[target, q] = a * x[last, q] + (b * x[last - 1, q] + c * x[last - 2, q])
        lag = 3
    elif count % 4 == 2:
        b = weights[k, 1]
        for q in range(length):
            out[target, q] = a * x[last, q] + b * x[last - 1, q]
        lag = 2
    else:
        for q in range(length):
            out[target, q] = a * x[last, q]
    while lag < count:
        a, b, c, d = weights[k, lag], weights[k, lag + 1], weights[k, lag + 2], weights[k, lag + 3]
        row = last - lag
        for q in range(length):
            out[target, q] += (a * x[row, q] + b * x[row - 1, q]) + (c * x[row - 2, q] + d * x[row - 3, q])
        lag += 4


@kernel
def tail(x: Any, last: int, shrink: float, length: int, y: Any) -> float:
    """Bound the first omitted term of a series, in the Frobenius norm.

    The terms x_i h^i are bounded by M (h / rho)^i as far as they were computed.  Where rho^2 |K|(rho) <= i (i - 1), the
    recursion carries this bound to the next one: it holds for all.  ``shrink`` is the ratio of two neighbours' squares.
    """
    # sum_i |x_i|^2 shrink^(last + 1 - i), by Horner's rule from the oldest term: at least the square of the largest x_i
    # (h / rho)^(last + 1 - i), which is Cauchy's bound of term last + 1.
    for q in range(length):
        y[0, q] = 0.0
    for i in range(last + 1):
        for q in range(length):
            y[0, q] = shrink * (y[0, q] + x[i, q] * x[i, q])
    total = 0.0
    for q in range(length):
        total += y[0, q]
    return math.sqrt(total)


@kernel
def spectral_bound(matrix: Any) -> float:
    """Bound the spectral norm of a matrix from its entries."""
    # |A|_2 <= min(|A|_F, sqrt(|A|_1 |A|_inf)): the second is better for nearly diagonal matrices.
    rows, columns = matrix.shape
    square, largest_row, largest_column = 0.0, 0.0, 0.0
    for i in range(rows):
        total = 0.0
        for j in range(columns):
            total += abs(matrix[i, j])
            square += matrix[i, j] * matrix[i, j]
        largest_row = max(largest_row, total)
    for j in range(columns):
        total = 0.0
        for i in range(rows):
            total += abs(matrix[i, j])
        largest_column = max(largest_column, total)
    return min(math.sqrt(square), math.sqrt(largest_row * largest_column))


@kernel
def multiply(a: Any, b: Any, out: Any) -> None:
    """Set out = a b; by BLAS where that is faster."""
    # Row by row of ``out``, the innermost loop along rows of b and out, which lie in memory one after the other.
    if len(a) > _PLAIN_UP_TO:
        np.dot(a, b, out)
        return
    for i in range(a.shape[0]):
        for q in range(b.shape[1]):
            out[i, q] = 0.0
        for j in range(a.shape[1]):
            factor = a[i, j]
            for q in range(b.shape[1]):
                out[i, q] += factor * b[j, q]


@kernel
def copy_to(a: Any, out: Any) -> None:
    """Set out to a copy of a matrix: assigning to a slice takes seconds to compile."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            out[i, j] = a[i, j]


@kernel
def invert(a: Any, out: Any) -> None:
    """Set out to the inverse of a, by elimination with row pivoting; a is destroyed."""
    # Gauss and Jordan: [a | 1] is reduced to [1 | a^-1], row operations that clear column j above and below its pivot,
    # the largest entry on or below the diagonal.  Columns before j of ``a`` are done and left alone.  A pivot of zero
    # makes infinities and NaN of ``out``, which bounds of the caller turn into an infinite error.
    n = len(a)
    for i in range(n):
        for j in range(n):
            out[i, j] = 0.0
        out[i, i] = 1.0
    for j in range(n):
        pivot = j
        for i in range(j + 1, n):
            if abs(a[i, j]) > abs(a[pivot, j]):
                pivot = i
        if pivot != j:
            for q in range(n):
                a[j, q], a[pivot, q] = a[pivot, q], a[j, q]
                out[j, q], out[pivot, q] = out[pivot, q], out[j, q]
        # Row j over its pivot, then taken from all other rows, so that column j becomes that of the identity.
        scale = 1.0 / a[j, j] if a[j, j] != 0.0 else math.inf
        for q in range(j, n):
            a[j, q] *= scale
        for q in range(n):
            out[j, q] *= scale
        for i in range(n):
            factor = a[i, j]
            if i == j or factor == 0.0:
                continue
            for q in range(j, n):
                a[i, q] -= factor * a[j, q]
            for q in range(n):
                out[i, q] -= factor * out[j, q]


@kernel
def chain_error(maps: Any, errors: Any, product: Any) -> float:
    """Multiply ``maps`` (m, N, N), the first acting first, into ``product``; bound its error in the Frobenius norm.

    The error of each map, and the rounding of each multiplication, is carried by the product of the maps after it
    and the product of the maps before it: first order in the errors, then a bound on the higher orders.
    """
    # The product M_m ... M_1 of maps with errors E_j is off by sum_j (M_m ... M_(j+1)) E_j (M_(j-1) ... M_1) to first
    # order. before[j] bounds the norm of the product of the maps before j, ``after`` that of the maps after it; both
    # are needed, so prefixes are formed forwards and suffixes backwards.  ``share`` sums errors relative to norms:
    # exp(share count) bounds all higher orders.  prefix, suffix and other are workspaces that change their parts.
    count, size = len(maps), maps.shape[1]
    before = np.empty(count)
    prefix, suffix, other = np.empty((size, size)), np.empty((size, size)), np.empty((size, size))
    copy_to(maps[0], prefix)
    before[0] = 1.0
    for j in range(1, count):
        before[j] = spectral_bound(prefix)
        multiply(maps[j], prefix, other)
        prefix, other = other, prefix
    copy_to(prefix, product)
    copy_to(maps[count - 1], suffix)
    rounding = ROUNDING * (size + 2.0)
    total = 0.0
    share = 0.0
    for j in range(count - 1, -1, -1):
        after = 1.0
        if j < count - 1:
            after = spectral_bound(suffix)
            multiply(suffix, maps[j], other)
            suffix, other = other, suffix
        norm = spectral_bound(maps[j])
        local = errors[j]
        if j > 0:
            local += rounding * norm * math.sqrt(size)
        total += after * local * before[j]
        share += local / norm if norm > 0.0 else math.inf
    return total * math.exp(min(share * count, 50.0))
