"""Maps of x' = A(t) x to any number of digits, with a bound of their error: Taylor series in fixed-point arithmetic.

Matrices hold integers, multiples of 2^-bits, and every operation rounds down by less than one of them.  Norms are the
largest sums of magnitudes along a row, except for the final bound of the map's error.  Only the matrices are used: no
symmetry, and no code of the maps in doubles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats

_GUARD_BITS = 40
_STEP = 6.0  # growth exponent of a step: longer ones lose digits
_FACTORS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0)  # times the fewest steps: the cheapest plan is taken
_PRODUCTS = 20.0  # cost of a term's matrix products over the product of a harmonic and an earlier term (heuristic)
_MOST_STEPS = 1e9
_AT_ONCE = 16  # steps whose terms are computed together, which spares calls of numpy (a choice)
_SLACK = 4.0  # digits by which a step's series ends below the error wanted, which the product of maps loses (a choice)
_UP = 1.0 + 1e-9  # covers the rounding of bounds, which are computed in doubles


class PieceSeries(NamedTuple):
    """A(phase) = mean + slope (phase - start) + sum_k cosines[k-1] cos(k phase) + sines[k-1] sin(k phase).

    Per unit of phase, over a ``length`` of phase from ``start`` on: a piece of the period, which is 2 pi long.
    In numbers of mpmath.
    """

    mean: NDArray[Any]  # (N, N)
    waves: NDArray[Any]  # (2 H, N, N), cosine and sine coefficients of the first harmonic, then of the second, ...
    start: Any
    length: Any
    slope: NDArray[Any] | None = None  # (N, N), None for zero

    @property
    def sizes(self) -> Floats:
        """Norms of the mean, the slope over the piece included, and, cosine and sine together, of each harmonic."""
        mean, *waves = (_row_sum(matrix) for matrix in (self.mean, *self.waves))
        mean += self.steepness * float(self.length)
        return _UP * np.array([mean, *(c + s for c, s in zip(waves[::2], waves[1::2], strict=True))])

    @property
    def steepness(self) -> float:
        """Norm of the slope."""
        return 0.0 if self.slope is None else _UP * _row_sum(self.slope)


class PeriodMap(NamedTuple):
    """The map over a period."""

    matrix: NDArray[Any]  # (N, N), numbers of mpmath
    error: Any  # bound of its error in the 2-norm, of mpmath
    terms: int  # terms of all series


class Plan(NamedTuple):
    """How a piece of the period is integrated."""

    steps: int  # of equal lengths
    order: int  # power of the last term of the series over each
    bits: int  # after the point
    log_error: float  # logarithm of a bound of the truncation of each series
    rounding: float  # bound of the rounding of a step, in units of 2^-bits

    @property
    def terms(self) -> int:
        """Terms of all series."""
        return self.steps * self.order


def last_power(sizes: Floats, waves: Floats, h: float, log_wanted: float, steepness: float = 0.0) -> Any:
    """Return the last power of series over steps h, and the logarithm of a bound of their truncation.

    With a(r) = steepness r + sum_k sizes_k cosh(waves_k r), which bounds A for complex times up to r from a real one, a
    solution grows from there at most by exp(r a(r)), so that by Cauchy the series cut after the power p errs by at most
    exp(r a(r)) (h / r)^(p + 1) / (1 - h / r), for any r > h.  None where 2,000 powers are too few.
    """
    with np.errstate(over="ignore"):
        radii = h * np.geomspace(1.25, 400.0, 60)
        exponent = radii * (sizes @ np.cosh(np.outer(waves, radii)) + steepness * radii) * (1.0 + 1e-10)
        ratio = np.log(radii / h)
        rest = exponent - np.log1p(-np.exp(-ratio))
        for order in range(8, 2000):
            log_error = float((rest - (order + 1) * ratio).min())
            if log_error < log_wanted:
                return order, log_error + 1e-8 * (abs(log_error) + 1.0)
    return None


def plan(pieces: Sequence[PieceSeries], digits: float) -> tuple[Plan, ...] | None:
    """Return plans for series that end ``digits`` digits below 1; None where they converge too slowly."""
    plans = [_plan(series, digits) for series in pieces]
    if any(fit is None for fit in plans):
        return None
    bits = max(fit.bits for fit in plans if fit is not None)
    return tuple(fit._replace(bits=bits) for fit in plans if fit is not None)


def _plan(series: PieceSeries, digits: float) -> Plan | None:
    sizes, length = series.sizes, float(series.length)
    waves = np.arange(float(len(sizes)))
    # Harmonics turn by less than a quarter of a turn in a step.
    fewest = max(length * float(sizes.sum()) / _STEP, 4.0 * waves[-1] * length / (2.0 * math.pi), 1.0)
    if not fewest < _MOST_STEPS:
        return None
    options = []
    for steps in (math.ceil(fewest * factor) for factor in _FACTORS):
        power = last_power(sizes, waves, length / steps, -math.log(10.0) * (digits + _SLACK), series.steepness)
        if power is not None:
            options.append((steps * power[0] * (power[0] + _PRODUCTS), steps, *power))
    if not options:
        return None
    _, steps, order, log_error = min(options)
    rounding = _rounding(sizes, waves, series.steepness, length / steps, order, len(series.mean))
    bits = math.ceil(math.log2(10.0) * (digits + _SLACK) + math.log2(rounding)) + _GUARD_BITS
    return Plan(steps, order, bits, log_error, rounding)


def _rounding(sizes: Floats, waves: Floats, steepness: float, h: float, last: int, order: int) -> float:
    """Return a bound of the rounding of a step, in units of 2^-bits.

    Rounded, the terms solve x' = A x + f, f a series whose coefficients are the roundings, and this with |A|, |f| in
    place of A, f bounds by how much they differ.  A term rounds in its products (1), in the division (last + 2), in the
    matrices and in the weights of the harmonics, which differ by less than 8 multiples of 2^-bits.
    """
    growth = h * (float(sizes @ np.cosh(waves * h)) + steepness * h)
    spread = math.exp(growth)
    matrices = 2.0 * len(sizes) + (3.0 if steepness else 1.0)
    units = last + 3.0 + matrices * 8.0 * (1.0 + growth) * (1.0 + spread) * math.cosh(waves[-1] * h)
    return _UP * order * units * spread * (1.0 + math.log(last + 1.0)) + order


def period_map(pieces: Sequence[PieceSeries], context: Any, planned: Sequence[Plan]) -> PeriodMap:
    """Return the map over all pieces in a context of mpmath, whose precision is set as the plans need."""
    bits, order = planned[0].bits, len(pieces[0].mean)
    context.prec = bits + _GUARD_BITS
    total, maps, local = None, [], []
    for series, plan in zip(pieces, planned, strict=True):
        steps = _PieceSteps(series, context, plan)
        error = context.exp(plan.log_error) + context.ldexp(plan.rounding, -bits)
        for first in range(0, plan.steps, _AT_ONCE):
            for fine in steps.across(range(first, min(first + _AT_ONCE, plan.steps))):
                total = fine if total is None else np.dot(fine, total) >> bits
                maps.append(np.array([v / (1 << bits) for v in fine.flat], dtype=float).reshape(order, order))
                local.append(error)
    before, after = _products(maps)
    # A 2-norm is at most sqrt(N) times a norm of row sums.  Products of errors are far below _UP.
    magnified = sum(float(b * a) * error for b, a, error in zip(before, after, local, strict=True))
    rounded = order * sum(after)
    error = _UP * (math.sqrt(order) * magnified + context.ldexp(float(rounded), -bits))
    matrix = np.array([context.ldexp(context.mpf(v), -bits) for v in np.asarray(total).flat], dtype=object)
    return PeriodMap(matrix.reshape(order, order), error, sum(plan.terms for plan in planned))


class _PieceSteps:
    """The data of all steps of a piece: matrices times the step, Taylor coefficients of cos(k h s), sin(k h s)."""

    def __init__(self, series: PieceSeries, context: Any, planned: Plan) -> None:
        order, bits = len(series.mean), planned.bits
        self.context, self.bits, self.last, self.series = context, bits, planned.order, series
        self.length = series.length / planned.steps
        self.identity = np.array([[1 << bits if i == j else 0 for j in range(order)] for i in range(order)], object)
        self.mean = _fixed(series.mean * self.length, bits, context)
        self.slope = None if series.slope is None else _fixed(series.slope * self.length**2, bits, context)
        waves = _fixed(series.waves * self.length, bits, context)
        varies = (waves != 0).any(axis=0) if len(waves) else np.zeros((order, order), dtype=bool)
        self.rows, self.columns = np.flatnonzero(varies.any(axis=1)), np.flatnonzero(varies.any(axis=0))
        self.waves = waves[:, self.rows[:, None], self.columns]
        weights = [self._weights(k + 1) for k in range(len(waves) // 2)]
        self.even, self.odd = (np.array([w[i::2] for w in weights], dtype=object) for i in (0, 1))

    def _weights(self, k: int) -> list[int]:
        """Return the Taylor coefficients of cos(k h s), even ones, and of sin(k h s), odd ones."""
        weights, term = [], self.context.mpf(1)
        for power in range(self.last + 1):
            weights.append(int(self.context.ldexp(-term if power % 4 > 1 else term, self.bits)))
            term = term * k * self.length / (power + 1)
        return weights

    def across(self, steps: range) -> NDArray[Any]:
        """Return the maps over ``steps``, shape (steps, N, N).

        Terms x_m of x' = h A(h s) x at s = 0: (m + 1) x_(m+1) = h mean x_m + h^2 slope x_(m-1)
        + sum_k (C_k sum_j c_j x_(m-j) + S_k sum_j s_j x_(m-j)), c and s the Taylor coefficients of cos(k h s),
        sin(k h s), C and S turned to the beginning of each step.
        """
        order, width, harmonics = len(self.identity), len(self.columns), len(self.even)
        waves = np.stack([self._turned(self.series.start + step * self.length) for step in steps])
        mean = np.stack([self._mean(step) for step in steps])
        newest = total = np.stack([self.identity] * len(steps))
        older = np.zeros_like(newest)
        history = np.zeros((self.last, len(steps) * width * order), dtype=object)
        for m in range(self.last):
            change = np.matmul(mean, newest)
            if self.slope is not None:
                change += np.matmul(self.slope, older)
            if width:
                history[m] = newest[:, self.columns].ravel()
                even = np.dot(self.even[:, : m // 2 + 1], history[m::-2])
                odd = np.dot(self.odd[:, : (m + 1) // 2], history[m - 1 :: -2]) if m else np.zeros_like(even)
                convolved = np.stack([even, odd], axis=1).reshape(2 * harmonics, len(steps), width, order) >> self.bits
                change[:, self.rows] += np.matmul(waves, convolved.swapaxes(0, 1).reshape(len(steps), -1, order))
            older, newest = newest, (change >> self.bits) // (m + 1)
            total = total + newest
        return total

    def _mean(self, step: int) -> NDArray[Any]:
        """Return the mean at the beginning of a step, times its length."""
        if self.series.slope is None or not step:
            return self.mean
        return _fixed(
            (self.series.mean + self.series.slope * (step * self.length)) * self.length, self.bits, self.context
        )

    def _turned(self, begin: Any) -> NDArray[Any]:
        """Return the coefficients of cos(k h s) and sin(k h s), s from the beginning of a step, side by side."""
        turned = []
        for k, (cosine, sine) in enumerate(zip(self.waves[::2], self.waves[1::2], strict=True), 1):
            c, s = (int(self.context.ldexp(v, self.bits)) for v in self.context.cos_sin(k * begin))
            turned += [(cosine * c + sine * s) >> self.bits, (sine * c - cosine * s) >> self.bits]
        return np.concatenate(turned, axis=1) if turned else np.zeros((0, 0), dtype=object)


@np.errstate(over="ignore", under="ignore", invalid="ignore")  # a product that overflows has an infinite norm, or NaN
def _products(maps: list[Floats]) -> tuple[list[float], list[float]]:
    """Return bounds of the 2-norms of the products of all maps before, and of all maps after each map."""
    order = len(maps[0])
    before, after = [1.0], [1.0]
    for bounds, sequence, left in ((before, maps, True), (after, maps[::-1], False)):
        product = np.eye(order)
        for matrix in sequence[:-1]:
            product = matrix @ product if left else product @ matrix
            bounds.append(_norm(product))
    return before, after[::-1]


def _norm(matrix: Floats) -> float:
    """Return the Frobenius norm, also where squares of entries overflow."""
    exponent = np.frexp(np.abs(matrix).max())[1]
    return float(np.ldexp(np.linalg.norm(np.ldexp(matrix, -exponent)), exponent))


def _row_sum(matrix: NDArray[Any]) -> float:
    """Return the largest sum of magnitudes along a row of numbers of mpmath."""
    return max(float(sum(abs(v) for v in row)) for row in matrix)


def _fixed(matrix: NDArray[Any], bits: int, context: Any) -> NDArray[Any]:
    """Return numbers of mpmath as integers, multiples of 2^-bits."""
    flat = np.array([int(context.ldexp(v, bits)) for v in matrix.flat], dtype=object)
    return flat.reshape(matrix.shape)
