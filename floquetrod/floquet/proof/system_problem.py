"""Systems of equations whose numbers are exact or lie within bounds, and the same in balls.

The coefficients come in pieces of the period; a Fourier series is one piece.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from floquetrod._util.caching import cached_property
from floquetrod.floquet.proof.balls import Array, up
from floquetrod.floquet.proof.many_digits import Unresolved

Arithmetic = Any  # `Doubles` or `Integers`
Matrix = Any  # their arrays of balls


_MOST_TERMS = 40  # of the series for the inverse mass (a choice)


class Known(NamedTuple):
    """A matrix each of whose entries is known to lie about a middle."""

    middle: Array
    radius: Array | None  # None where the middle is exact

    @property
    def is_zero(self) -> bool:
        """Whether it is exactly zero."""
        return not self.middle.any() and (self.radius is None or not self.radius.any())

    def at(self, index: Any) -> Known:
        """Return some of the entries."""
        return Known(self.middle[index], None if self.radius is None else self.radius[index])

    def ball(self, arithmetic: Arithmetic) -> Matrix:
        """Return it in balls."""
        exact = arithmetic.exact(self.middle)
        return exact if self.radius is None else exact.widened(self.radius)


class ExactRange(NamedTuple):
    """A number, zero or more, that is known to lie between two."""

    low: Fraction
    high: Fraction

    def ball(self, arithmetic: Arithmetic, power: int = 1) -> Matrix:
        """Return a power of it as a ball."""
        low, high = self.low**power, self.high**power
        middle = arithmetic.rational((low + high) / 2)
        return middle if low == high else middle.widened(np.array(up(float((high - low) / 2))))


class BallPiece(NamedTuple):
    """A piece of the period: mean + slope (t - begin) + sum_k Re(Z_k exp(2 pi i k t)), t in periods.

    Its matrices are balls in which the period is the unit of time, or, with the unit of time of the system, `Known`.
    """

    begin: Fraction  # as parts of the period, exactly, as is the length
    length: Fraction
    mean: Matrix
    slope: Matrix | None  # None where zero
    waves: list[Matrix]  # Z_k, k = 1, 2, ...

    def each(self, of_mean: Callable[[Matrix], Matrix], of_other: Callable[[Matrix], Matrix]) -> BallPiece:
        """Return the same with functions applied to the mean and to the other matrices."""
        slope = None if self.slope is None else of_other(self.slope)
        return self._replace(mean=of_mean(self.mean), slope=slope, waves=[of_other(wave) for wave in self.waves])

    def ball(self, arithmetic: Arithmetic, unit: ExactRange) -> BallPiece:
        """Return the `Known` matrices in balls, the slope with the period as the unit of time."""
        piece = self.each(lambda m: m.ball(arithmetic), lambda m: m.ball(arithmetic))
        return piece if piece.slope is None else piece._replace(slope=piece.slope * unit.ball(arithmetic))

    @property
    def size(self) -> Array:
        """Upper bound of the modulus of each entry."""
        others = self.waves if self.slope is None else [*self.waves, self.slope]
        return sum((matrix.upper() for matrix in others), self.mean.upper())


@dataclass(frozen=True)
class _KnownSystem:
    """Systems alike whose numbers are `Known`, with K(t) or A(t) off by up to ``error`` in each entry at any time.

    ``is_paired``: with every multiplier mu there is 1 / conj(mu).  ``is_hamiltonian``: the system is, of second order
    with uniform damping removed.
    """

    pieces: tuple[BallPiece, ...]
    period: ExactRange
    error: float
    is_paired: bool
    is_hamiltonian: bool

    @property
    def is_constant(self) -> bool:
        """Whether nothing depends on time."""
        return self.is_series and not self.pieces[0].waves

    @property
    def is_series(self) -> bool:
        """Whether the coefficient is one Fourier series, except for its error."""
        return len(self.pieces) == 1 and self.pieces[0].slope is None

    @cached_property
    def unit(self) -> ExactRange:
        """The period; with constant coefficients, where any time will do, one in which solutions change little."""
        if not self.is_constant:
            return self.period
        fastest = float(np.abs(np.linalg.eigvals(self._generator())).max())
        time = Fraction(2) ** -round(math.log2(fastest)) if fastest > 0.0 else self.period.low
        return ExactRange(time, time)

    def _generator(self) -> Array:
        """Return the matrix of first order of constant coefficients, about."""
        raise NotImplementedError


@dataclass(frozen=True)
class FirstOrder(_KnownSystem):
    """x' = A(t) x.  ``is_hamiltonian``: x are positions and momenta."""

    is_damped = False

    def _generator(self) -> Array:
        return self.pieces[0].mean.middle

    def stretches(self, arithmetic: Arithmetic, unit: ExactRange) -> list[BallPiece]:
        """Return the pieces in balls, with ``unit`` as the unit of time."""
        time = unit.ball(arithmetic)
        error = 0.0 if not self.error else up(self.error * float(unit.high) * (1.0 + 1e-9))

        def scaled(matrix: Matrix) -> Matrix:
            return matrix * time

        def mean(matrix: Matrix) -> Matrix:
            return scaled(matrix).widened(np.full(matrix.shape, error)) if error else scaled(matrix)

        return [piece.ball(arithmetic, unit).each(mean, scaled) for piece in self.pieces]

    def flow(self, arithmetic: Arithmetic, *, freed: bool = False) -> Flow:
        """Return the system in balls."""
        form = arithmetic.exact(canonical_form(len(self.pieces[0].mean.middle)))
        return balanced(self.stretches(arithmetic, self.unit), form)


@dataclass(frozen=True)
class SecondOrder(_KnownSystem):
    """M q'' + (C + G) q' + K(t) q = 0, M symmetric and positive definite, G = -G^T."""

    mass: Known
    damping: Known
    gyroscopic: Known
    rates: ExactRange | None  # of the c of a damping 2 c M; None for any other

    @property
    def order(self) -> int:
        """Number of equations."""
        return len(self.mass.middle)

    @property
    def is_damped(self) -> bool:
        """Whether there is damping."""
        return not self.damping.is_zero

    def _generator(self) -> Array:
        n = self.order
        forces = np.hstack([self.pieces[0].mean.middle, self.damping.middle + self.gyroscopic.middle])
        return np.vstack([np.eye(n, 2 * n, n), -np.linalg.solve(self.mass.middle, forces)])

    def flow(self, arithmetic: Arithmetic, *, freed: bool = False) -> Flow:
        """Return the system of first order in balls; ``freed`` of uniform damping."""
        return self.oscillators(arithmetic, self.unit, freed=freed).flow(arithmetic)

    def oscillators(self, arithmetic: Arithmetic, unit: ExactRange, *, freed: bool) -> Oscillators:
        """Return the system in balls; ``freed`` of uniform damping, by which M c^2 leaves the stiffness."""
        mass, one = self.mass.ball(arithmetic), np.eye(self.order)
        transform = None
        if not np.array_equal(self.mass.middle, one):
            transform = arithmetic.exact(_congruence(self.mass.middle))
        times = {power: unit.ball(arithmetic, power) for power in (1, 2)}

        def scaled(matrix: Matrix, power: int) -> Matrix:
            if transform is not None:
                matrix = transform @ matrix @ transform.adjoint()
            return matrix * times[power] if power else matrix

        def friction(known: Known) -> Matrix | None:
            return None if known.is_zero else scaled(known.ball(arithmetic), 1)

        is_unit = transform is None and self.mass.radius is None
        excess = None if is_unit else scaled(mass, 0) - arithmetic.exact(one)
        defect = 0.0 if excess is None else row_sum(excess)
        if not defect < 0.5:
            raise Unresolved("the mass matrix cannot be distinguished from a singular one")
        removed = mass * self.rates.ball(arithmetic, 2) if freed and self.rates and self.rates.high else None

        def stiffness(matrix: Matrix) -> Matrix:
            return scaled(matrix if removed is None else matrix - removed, 2)

        pieces = [piece.ball(arithmetic, unit).each(stiffness, lambda m: scaled(m, 2)) for piece in self.pieces]
        damping = None if freed else friction(self.damping)
        error = None
        if self.error:
            error = scaled(Known(np.zeros(one.shape), np.full(one.shape, self.error)).ball(arithmetic), 2).upper()
        return Oscillators(excess, defect, damping, friction(self.gyroscopic), pieces, error)


SystemProblem: TypeAlias = SecondOrder | FirstOrder


class Oscillators(NamedTuple):
    """M q'' + (C + G) q' + K(t) q = 0 in balls, with the period as the unit of time and M close to the unit matrix."""

    excess: Matrix | None  # M - I, None where zero
    defect: float  # bound of its largest row sum
    damping: Matrix | None  # None where zero, as the next
    gyroscopic: Matrix | None
    pieces: list[BallPiece]  # of K
    error: Array | None  # bounds of the entries of an E(t) in K(t) that varies in an unknown way, None where zero

    @property
    def order(self) -> int:
        """Number of equations."""
        return int(self.pieces[0].mean.shape[0])

    @property
    def stiffness(self) -> Matrix:
        """Mean of a stiffness that is one Fourier series, for counts.

        A symmetric E lies between the diagonal matrix of the sums of its bounds' rows and its negative, and so do
        numbers of negative eigenvalues.
        """
        mean = self.pieces[0].mean
        return mean if self.error is None else mean.widened(np.diag(up(self.error.sum(1))))

    @property
    def waves(self) -> list[Matrix]:
        """Amplitudes of a stiffness that is one Fourier series."""
        return self.pieces[0].waves

    def stretches(self, arithmetic: Arithmetic, own: int | None = None) -> list[BallPiece]:
        """Return the pieces of the system of first order for positions and velocities.

        Those after the first ``own`` are of a further coefficient, beside which there is nothing else.
        """
        n = self.order
        inverse = -_inverse_mass(arithmetic, self)
        frictions = [inverse @ matrix for matrix in (self.damping, self.gyroscopic) if matrix is not None]

        def other(matrix: Matrix) -> Matrix:
            block = arithmetic.zeros((2 * n, 2 * n), real=matrix.is_real)
            block[n:, :n] = inverse @ matrix
            return block

        def mean(matrix: Matrix) -> Matrix:
            return other(matrix if self.error is None else matrix.widened(self.error))

        def whole(matrix: Matrix) -> Matrix:
            block = mean(matrix)
            block[:n, n:] = arithmetic.exact(np.eye(n))
            for friction in frictions:
                block[n:, n:] = block[n:, n:] + friction
            return block

        alone = len(self.pieces) if own is None else own
        return [piece.each(whole if i < alone else mean, other) for i, piece in enumerate(self.pieces)]

    def flow(self, arithmetic: Arithmetic) -> Flow:
        """Return the system of first order for positions and velocities, and the form of their momenta."""
        n = self.order
        unit = arithmetic.exact(np.eye(n))
        mass = unit if self.excess is None else unit + self.excess
        form = arithmetic.zeros((2 * n, 2 * n), real=False)  # p = M q' + G q / 2
        form[:n, n:], form[n:, :n] = mass.times_i(), -mass.times_i()
        if self.gyroscopic is not None:
            form[:n, :n] = self.gyroscopic.times_i()
        return balanced(self.stretches(arithmetic), form)


class Flow(NamedTuple):
    """x' = A(t) x in balls, with the period as the unit of time."""

    pieces: list[BallPiece]
    form: Matrix  # the Hermitian i (q^H p - p^H q) of positions and momenta, which Hamiltonian motion keeps


def row_sum(matrix: Matrix) -> float:
    """Return an upper bound of the largest sum of moduli in a row, which bounds the moduli of eigenvalues."""
    return float(up(matrix.upper().sum(-1)).max())


def _congruence(mass: Array) -> Array:
    """Return X with X M X^T close to the unit matrix."""
    try:
        return np.linalg.inv(np.linalg.cholesky(mass))
    except np.linalg.LinAlgError:
        raise Unresolved("the mass matrix cannot be distinguished from one that is not positive definite") from None


def _inverse_mass(arithmetic: Arithmetic, system: Oscillators) -> Matrix:
    """Enclose the inverse of I + E by I - E + E^2 - ...: the terms left out have row sums below d^k / (1 - d)."""
    n = system.order
    inverse = arithmetic.exact(np.eye(n))
    if system.excess is None:
        return inverse
    power, left_out = inverse, system.defect
    for _ in range(_MOST_TERMS):
        power = -(power @ system.excess)
        inverse = inverse + power
        left_out *= system.defect
        if left_out < 10.0**-arithmetic.digits:
            break
    return inverse.widened(np.full((n, n), up(left_out / (1.0 - system.defect))))


def canonical_form(order: int) -> Array:
    """Return the form of positions and momenta of equal numbers; of an odd order one that nothing keeps."""
    half = np.eye(order, order, order // 2)
    return 1j * (half - half.T)


def balanced(pieces: list[BallPiece], form: Matrix) -> Flow:
    """Scale the unknowns by powers of two so that rows and columns have alike sums."""
    from scipy.linalg import matrix_balance

    size = np.maximum.reduce([piece.size for piece in pieces])
    if not np.isfinite(size).all():
        raise Unresolved("the coefficients are too large")
    scale = matrix_balance(np.where(size > 1e-200, size, 0.0), permute=False, separate=True)[1][0]
    ratio = scale[None, :] / scale[:, None]

    def shifted(matrix: Matrix) -> Matrix:
        return matrix.shifted(ratio)

    return Flow([piece.each(shifted, shifted) for piece in pieces], form.shifted(scale[:, None] * scale[None, :]))
