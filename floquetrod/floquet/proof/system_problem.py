"""Systems of equations in exact numbers, and the same in balls with the period as the unit of time.

The coefficients come in pieces of the period, of which a Fourier series has one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.matrices import require_one
from floquetrod.equations.pieces import TimedPiece, exact_period, in_time
from floquetrod.floquet.proof.balls import Array, up
from floquetrod.floquet.proof.intervals import Unresolved

Arithmetic = Any  # `Doubles` or `Integers`
Matrix = Any  # their arrays of balls


_MOST_TERMS = 40  # of the series for the inverse mass (a choice)


@dataclass(frozen=True)
class SecondOrder:
    """M q'' + (C + G) q' + K(t) q = 0, all numbers exact, K known up to ``error`` in each entry.

    M is symmetric and positive definite, G = -G^T.  ``is_reversible``: C = G = 0 and K is even about an instant.
    """

    mass: Array
    damping: Array
    gyroscopic: Array
    pieces: tuple[TimedPiece, ...]
    period: Fraction
    is_reversible: bool = False
    error: float = 0.0

    @property
    def order(self) -> int:
        """Number of equations."""
        return int(self.mass.shape[0])

    @property
    def is_constant(self) -> bool:
        """Whether nothing depends on time."""
        return len(self.pieces) == 1 and self.pieces[0].is_constant

    @property
    def is_series(self) -> bool:
        """Whether K is one Fourier series, known exactly."""
        return len(self.pieces) == 1 and self.pieces[0].slope is None and not self.error

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether K(t) is symmetric, as its error then is."""
        every = [m for p in self.pieces for m in (p.mean, *(() if p.slope is None else (p.slope,)), *p.harmonics)]
        return all(np.array_equal(m, m.T) for m in every)

    @cached_property
    def uniform_damping(self) -> Fraction | None:
        """The c >= 0 of a damping 2 c M, exactly; None for any other."""
        if not self.damping.any():
            return Fraction(0)
        twice = Fraction(float(self.damping[0, 0])) / Fraction(float(self.mass[0, 0]))
        pairs = zip(self.damping.ravel().tolist(), self.mass.ravel().tolist(), strict=True)
        return twice / 2 if twice >= 0 and all(Fraction(c) == twice * Fraction(m) for c, m in pairs) else None

    @cached_property
    def is_hamiltonian(self) -> bool:
        """Whether the system, with uniform damping removed, is Hamiltonian."""
        damping = self.uniform_damping
        return self.is_symmetric and damping is not None and (damping == 0 or not self.gyroscopic.any())

    @property
    def is_paired(self) -> bool:
        """Whether with every multiplier mu there is 1 / conj(mu)."""
        return self.is_reversible or (self.is_hamiltonian and not self.damping.any())

    def oscillators(self, arithmetic: Arithmetic, period: Fraction, *, freed: bool) -> Oscillators:
        """Return the system in balls; ``freed`` of uniform damping."""
        return oscillators(arithmetic, self, period, freed=freed)


@dataclass(frozen=True)
class FirstOrder:
    """x' = A(t) x, all numbers exact, A known up to ``error`` in each entry.

    ``is_paired``: with every multiplier mu there is 1 / conj(mu).  ``is_hamiltonian``: x are positions and momenta.
    """

    pieces: tuple[TimedPiece, ...]
    period: Fraction
    error: float = 0.0
    is_paired: bool = False
    is_hamiltonian: bool = False

    @property
    def is_constant(self) -> bool:
        """Whether nothing depends on time."""
        return len(self.pieces) == 1 and self.pieces[0].is_constant

    def flow(self, arithmetic: Arithmetic, period: Fraction) -> Flow:
        """Return the system in balls."""
        return flow(arithmetic, self, period)


def system_problem(system: HillSystem | PeriodicSystem) -> SecondOrder | FirstOrder:
    """Return the problem of a system, which must not be a batch."""
    require_one(system)
    reversible, error, period = system.structure == "reversible", system.coefficient_error, exact_period(system)
    pieces = in_time(system)
    if system.is_constant:
        pieces = (pieces[0]._replace(length=period),)
    if isinstance(system, PeriodicSystem):
        hamiltonian = not error and system.structure == "hamiltonian"
        return FirstOrder(pieces, period, error, (reversible and not error) or hamiltonian, hamiltonian)
    n = system.order
    mass = np.eye(n) if system.mass is None else system.mass
    damping, gyroscopic = (np.zeros((n, n)) if m is None else m for m in (system.damping, system.gyroscopic))
    return SecondOrder(mass, damping, gyroscopic, pieces, period, reversible and not error, error)


class Stretch(NamedTuple):
    """A piece, with the period as the unit of time: mean + slope (t - begin) + sum_k Re(Z_k exp(2 pi i k t)).

    ``begin`` and ``length`` are exact parts of the period; ``slope`` is None where zero, and Z_k stands in ``waves`` at
    index k - 1.
    """

    begin: Fraction
    length: Fraction
    mean: Matrix
    slope: Matrix | None
    waves: list[Matrix]

    def each(self, of_mean: Callable[[Matrix], Matrix], of_other: Callable[[Matrix], Matrix]) -> Stretch:
        """Return the same with functions applied to the mean and to the other matrices."""
        slope = None if self.slope is None else of_other(self.slope)
        return self._replace(mean=of_mean(self.mean), slope=slope, waves=[of_other(wave) for wave in self.waves])

    @property
    def size(self) -> Array:
        """Upper bound of the modulus of each entry."""
        others = self.waves if self.slope is None else [*self.waves, self.slope]
        return sum((matrix.upper() for matrix in others), self.mean.upper())


class Oscillators(NamedTuple):
    """M q'' + (C + G) q' + K(t) q = 0 with the period as the unit of time and M close to the unit matrix.

    ``excess`` is M - I, None where zero, and ``defect`` bounds its largest row sum; ``damping`` and ``gyroscopic`` are
    None where zero; ``error`` bounds the error of each entry of K(t).
    """

    excess: Matrix | None
    defect: float
    damping: Matrix | None
    gyroscopic: Matrix | None
    pieces: list[Stretch]
    error: float

    @property
    def stiffness(self) -> Matrix:
        """Mean of a stiffness that is one Fourier series."""
        return self.pieces[0].mean

    @property
    def waves(self) -> list[Matrix]:
        """Amplitudes of a stiffness that is one Fourier series."""
        return self.pieces[0].waves


class Flow(NamedTuple):
    """x' = A(t) x with the period as the unit of time; ``error`` bounds the row sums of the error of A(t).

    ``form`` is the Hermitian form i (q^H p - p^H q) of positions and momenta, which Hamiltonian motion keeps.
    """

    pieces: list[Stretch]
    error: float
    form: Matrix


def row_sum(matrix: Matrix) -> float:
    """Return an upper bound of the largest sum of moduli in a row, which bounds the moduli of eigenvalues."""
    return float(up(matrix.upper().sum(-1)).max())


def oscillators(arithmetic: Arithmetic, system: SecondOrder, period: Fraction, *, freed: bool) -> Oscillators:
    """Return a system of second order in balls; ``freed`` of uniform damping, by which M c^2 leaves the stiffness."""
    mass = arithmetic.exact(system.mass)
    damping = system.uniform_damping
    unit = np.eye(system.order)
    plain = np.array_equal(system.mass, unit)
    transform = None if plain else arithmetic.exact(congruence(system.mass))

    def scaled(matrix: Matrix, power: int) -> Matrix:
        if transform is not None:
            matrix = transform @ matrix @ transform.adjoint()
        return matrix * arithmetic.rational(period**power) if power else matrix

    excess = None if plain else scaled(mass, 0) - arithmetic.exact(unit)
    defect = row_sum(excess) if excess is not None else 0.0
    if not defect < 0.5:
        raise Unresolved("the mass matrix cannot be distinguished from a singular one")
    dissipation = system.damping.any() and not freed

    def stiffness(matrix: Matrix) -> Matrix:
        return scaled(matrix - mass * arithmetic.rational(damping * damping) if freed and damping else matrix, 2)

    # X E X^T of an E with entries below e has entries below e times the squared row sum of abs(X).
    stretch = 1.0 if transform is None else row_sum(transform)
    error = up(system.error * stretch * stretch * float(period**2) * (1.0 + 1e-9)) if system.error else 0.0
    return Oscillators(
        excess,
        defect,
        scaled(arithmetic.exact(system.damping), 1) if dissipation else None,
        scaled(arithmetic.exact(system.gyroscopic), 1) if system.gyroscopic.any() else None,
        [piece.each(stiffness, lambda m: scaled(m, 2)) for piece in stretches(arithmetic, system.pieces, period)],
        error,
    )


def stretches(arithmetic: Arithmetic, pieces: tuple[TimedPiece, ...], period: Fraction) -> list[Stretch]:
    """Return pieces in balls, times in periods; of a constant coefficient, any time is its period."""
    whole = pieces[-1].begin + pieces[-1].length
    found = []
    for piece in pieces:
        slope = None if piece.slope is None else arithmetic.exact(piece.slope) * arithmetic.rational(period)
        waves = [arithmetic.exact(wave if wave.imag.any() else wave.real) for wave in piece.harmonics]
        mean = arithmetic.exact(piece.mean)
        found.append(Stretch(piece.begin / whole, piece.length / whole, mean, slope, waves))
    return found


def congruence(mass: Array) -> Array:
    """Return X with X M X^T close to the unit matrix."""
    try:
        return np.linalg.inv(np.linalg.cholesky(mass))
    except np.linalg.LinAlgError:
        raise Unresolved("the mass matrix cannot be distinguished from one that is not positive definite") from None


def flow_of_oscillators(arithmetic: Arithmetic, system: Oscillators) -> Flow:
    """Return the system of first order for positions and velocities."""
    n = system.stiffness.shape[0]
    inverse = -_inverse_mass(arithmetic, system)
    frictions = [inverse @ matrix for matrix in (system.damping, system.gyroscopic) if matrix is not None]

    def other(matrix: Matrix) -> Matrix:
        block = arithmetic.zeros((2 * n, 2 * n), real=matrix.is_real)
        block[n:, :n] = inverse @ matrix
        return block

    def whole(stiffness: Matrix) -> Matrix:
        block = other(stiffness)
        block[:n, n:] = arithmetic.exact(np.eye(n))
        for friction in frictions:
            block[n:, n:] = block[n:, n:] + friction
        return block

    errors = np.zeros((2 * n, 2 * n))
    errors[n:, :n] = up(
        system.error / (1.0 - system.defect)
    )  # row sums of the inverse of I + E are at most 1 / (1 - d)
    unit = arithmetic.exact(np.eye(n))
    mass = unit if system.excess is None else unit + system.excess
    form = arithmetic.zeros((2 * n, 2 * n), real=False)  # p = M q' + G q / 2
    form[:n, n:], form[n:, :n] = mass.times_i(), -mass.times_i()
    if system.gyroscopic is not None:
        form[:n, :n] = system.gyroscopic.times_i()
    return balanced([piece.each(whole, other) for piece in system.pieces], errors, form)


def _inverse_mass(arithmetic: Arithmetic, system: Oscillators) -> Matrix:
    """Enclose the inverse of I + E by I - E + E^2 - ...: what is left out has row sums below d^k / (1 - d)."""
    n = system.stiffness.shape[0]
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


def flow(arithmetic: Arithmetic, system: FirstOrder, period: Fraction) -> Flow:
    """Return a system of first order in balls."""
    factor = arithmetic.rational(period)

    def scaled(matrix: Matrix) -> Matrix:
        return matrix * factor

    pieces = [piece.each(scaled, scaled) for piece in stretches(arithmetic, system.pieces, period)]
    errors = np.full(pieces[0].mean.shape, up(system.error * float(period)) if system.error else 0.0)
    return balanced(pieces, errors, arithmetic.exact(canonical_form(len(errors))))


def canonical_form(order: int) -> Array:
    """Return the form of positions and momenta of equal numbers; of an odd order one that nothing keeps."""
    half = np.eye(order, order, order // 2)
    return 1j * (half - half.T)


def balanced(pieces: list[Stretch], errors: Array, form: Matrix) -> Flow:
    """Scale the unknowns by powers of two so that rows and columns have alike sums; ``errors`` are those of entries."""
    from scipy.linalg import matrix_balance

    size = np.maximum.reduce([piece.size for piece in pieces])
    if not np.isfinite(size).all():
        raise Unresolved("the coefficients are too large")
    scale = matrix_balance(np.where(size > 1e-200, size, 0.0), permute=False, separate=True)[1][0]
    ratio = scale[None, :] / scale[:, None]
    error = float(up((errors * ratio).sum(1).max())) if errors.any() else 0.0

    def shifted(matrix: Matrix) -> Matrix:
        return matrix.shifted(ratio)

    return Flow(
        [piece.each(shifted, shifted) for piece in pieces], error, form.shifted(scale[:, None] * scale[None, :])
    )
