"""Maps of x' = A(t) x to any number of digits: Gragg's midpoint rule with extrapolation, in fixed-point arithmetic.

Over a step H the midpoint rule x_(m+1) = x_(m-1) + 2 h A(t_m) x_m with h = H / n, n even, has an error in even powers
of h; combining n = 2, 4, ..., 2 K removes the first K - 1 of them.  Matrices hold integers, multiples of 2^-bits.
Gragg, SIAM J. Numer. Anal. 2 (1965) 384, doi:10.1137/0702030.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_GUARD_BITS = 40
_COLUMNS_PER_DIGIT = 0.8  # measured to be fastest (heuristic)
_SLACK = 4.0  # digits by which the plan aims below the error wanted (heuristic)


class Series(NamedTuple):
    """A(phase) = mean + sum_k cosines[k-1] cos(k phase) + sines[k-1] sin(k phase), per unit of phase.

    Attributes
    ----------
    mean : ndarray (N, N) of numbers of mpmath
        Mean.
    waves : ndarray (2 H, N, N) of numbers of mpmath
        Cosine and sine coefficients of the first harmonic, then of the second, and so on.
    start : number of mpmath
        Phase at which the period begins.
    """

    mean: NDArray[Any]
    waves: NDArray[Any]
    start: Any


class PeriodMap(NamedTuple):
    """The map over a period.

    Attributes
    ----------
    matrix : ndarray (N, N) of numbers of mpmath
        Map over one period.
    error : number of mpmath
        Estimate of its error in the 2-norm.
    evaluations : int
        How often A was evaluated.
    """

    matrix: NDArray[Any]
    error: Any
    evaluations: int


class Plan(NamedTuple):
    """How a period is integrated: steps, columns of the extrapolation and bits after the point."""

    steps: int
    columns: int
    bits: int

    @property
    def evaluations(self) -> int:
        """How often A is evaluated."""
        return self.steps * self.columns * (self.columns + 1)


def plan(size: float, digits: int, rate: float = 1.0) -> Plan:
    """Return a plan for A of norm ``size`` per unit of phase; ``rate`` above 1 takes more steps."""
    columns = max(6, math.ceil(_COLUMNS_PER_DIGIT * digits))
    # The error of a step of z = H |A| is about that of the exponential series, z^(2K-1) / (2K-1)!.
    power = 2 * columns - 1
    reach = math.exp((math.lgamma(power + 1.0) - math.log(10.0) * (digits + _SLACK)) / power)
    steps = max(1, math.ceil(2.0 * math.pi * size * rate / reach))
    weights = max(abs(w) for w in _weights(columns, 0))
    bits = math.ceil(math.log2(10.0) * (digits + _SLACK) + math.log2(float(weights)) + 3.0 * reach) + _GUARD_BITS
    return Plan(steps, columns, bits)


def period_map(series: Series, context: Any, planned: Plan) -> PeriodMap:
    """Return the map over a period in a context of mpmath, whose precision is set to what the plan needs.

    The error is estimated from the last two columns of each step; not a proven bound.
    """
    bits, order = planned.bits, len(series.mean)
    context.prec = bits + _GUARD_BITS
    one = 1 << bits
    length = 2 * context.pi / planned.steps
    mean = _fixed(series.mean, bits, context)
    waves = _fixed(series.waves, bits, context).reshape(len(series.waves), order * order)
    places = np.flatnonzero((waves != 0).any(axis=0)) if len(waves) else np.zeros(0, dtype=np.intp)
    waves = waves[:, places]
    last, before = (
        [int((weight.numerator << bits) // weight.denominator) for weight in _weights(planned.columns, first)]
        for first in (0, 1)
    )
    # Every part of a step rounds once, and the weights magnify what it rounds.
    rounding = context.ldexp(8 * order * planned.columns * sum(map(abs, last)), -2 * bits)
    identity = np.array([[one if i == j else 0 for j in range(order)] for i in range(order)], dtype=object)
    total = identity
    maps, errors = [], []
    for step in range(planned.steps):
        begin = series.start + step * length
        ends = [
            _midpoint(mean, waves, places, identity, begin, length, 2 * j, bits, context)
            for j in range(1, planned.columns + 1)
        ]
        fine, coarse = (
            np.asarray(sum(weight * end for weight, end in zip(weights, chosen, strict=True))) >> bits
            for weights, chosen in ((last, ends), (before, ends[1:]))
        )
        total = np.dot(fine, total) >> bits
        maps.append(_floats(fine, bits))
        errors.append(_size(fine - coarse, bits, context) + rounding * float(1.0 + np.square(maps[-1]).sum()))
    error = sum(
        (e * float(f) for e, f in zip(errors, _factors(maps), strict=True)), context.ldexp(order * planned.steps, -bits)
    )
    matrix = np.array([context.ldexp(context.mpf(v), -bits) for v in total.flat], dtype=object)
    return PeriodMap(matrix.reshape(order, order), error, planned.evaluations)


def _midpoint(
    mean: NDArray[Any],
    waves: NDArray[Any],
    places: NDArray[np.intp],
    identity: NDArray[Any],
    begin: Any,
    length: Any,
    count: int,
    bits: int,
    context: Any,
) -> NDArray[Any]:
    """Return the map over a step by the midpoint rule in ``count`` parts."""
    part = length / count
    twice = int(context.ldexp(2 * part, bits))
    c, s = (int(context.ldexp(v, bits)) for v in context.cos_sin(begin))
    turn_c, turn_s = (int(context.ldexp(v, bits)) for v in context.cos_sin(part))
    mean_part, waves_part = mean * twice >> bits, waves * twice >> bits
    harmonics = len(waves) // 2
    older, newer = identity, identity
    for m in range(count):
        matrix = mean_part
        if harmonics:
            matrix = mean_part.copy()
            matrix.reshape(-1)[places] += np.dot(_powers(c, s, harmonics, bits), waves_part) >> bits
            c, s = (c * turn_c - s * turn_s) >> bits, (s * turn_c + c * turn_s) >> bits
        change = np.dot(matrix, newer) >> bits
        older, newer = newer, (older + change if m else newer + (change >> 1))
    return newer


def _powers(c: int, s: int, harmonics: int, bits: int) -> NDArray[Any]:
    """Return cos k phase and sin k phase, k = 1, 2, ..., one after the other."""
    found, x, y = [c, s], c, s
    for _ in range(harmonics - 1):
        x, y = (x * c - y * s) >> bits, (y * c + x * s) >> bits
        found += [x, y]
    return np.array(found, dtype=object)


def _weights(columns: int, first: int) -> list[Fraction]:
    """Return the weights of n = 2 j, first < j <= columns, that extrapolate even powers of 1 / n to zero."""
    squares = [j * j for j in range(first + 1, columns + 1)]
    found = []
    for a in squares:
        numerator = denominator = 1
        for b in squares:
            if b != a:
                numerator *= a
                denominator *= a - b
        found.append(Fraction(numerator, denominator))
    return found


@np.errstate(over="ignore", invalid="ignore")  # a product that overflows has an infinite norm, or NaN
def _factors(maps: list[NDArray[np.float64]]) -> list[float]:
    """Return by how much each map's error is magnified: norms of what is applied before and after it."""
    order = len(maps[0])
    before, after = [1.0], [1.0]
    for found, sequence, left in ((before, maps, True), (after, maps[::-1], False)):
        product = np.eye(order)
        for matrix in sequence[:-1]:
            product = matrix @ product if left else product @ matrix
            found.append(_norm(product))
    return [b * a for b, a in zip(before, after[::-1], strict=True)]


def _norm(matrix: NDArray[np.float64]) -> float:
    """Return the Frobenius norm, also where squares of entries overflow."""
    exponent = np.frexp(np.abs(matrix).max())[1]
    return float(np.ldexp(np.linalg.norm(np.ldexp(matrix, -exponent)), exponent))


def _fixed(matrix: NDArray[Any], bits: int, context: Any) -> NDArray[Any]:
    """Return numbers of mpmath as integers, multiples of 2^-bits."""
    flat = np.array([int(context.ldexp(v, bits)) for v in matrix.flat], dtype=object)
    return flat.reshape(matrix.shape)


def _floats(matrix: Any, bits: int) -> NDArray[np.float64]:
    """Return integers that are multiples of 2^-bits as doubles."""
    scale = 1 << bits
    return np.array([v / scale for v in matrix.flat], dtype=float).reshape(matrix.shape)


def _size(matrix: Any, bits: int, context: Any) -> Any:
    """Return the Frobenius norm of integers that are multiples of 2^-bits."""
    return context.ldexp(context.sqrt(context.mpf(int((matrix * matrix).sum()))), -bits)
