"""Systems of equations in exact numbers, and the same in balls with the period as the unit of time."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.matrices import require_one
from floquetrod.floquet.proof.balls import up
from floquetrod.floquet.proof.intervals import Unresolved

Array = Any
Arithmetic = Any  # `Doubles` or `Integers`
Matrix = Any  # their arrays of balls


_MOST_TERMS = 40  # of the series for the inverse mass (a choice)


@dataclass(frozen=True)
class SecondOrder:
    """M q'' + (C + G) q' + K(t) q = 0, K(t) = mean + sum_k Re(Z_k exp(2 pi i k t / period)), all doubles exact.

    M is symmetric and positive definite, G = -G^T.  ``is_reversible``: C = G = 0 and K is even about an instant.
    """

    mass: Array
    damping: Array
    gyroscopic: Array
    stiffness: Array
    harmonics: Array
    period: float
    is_reversible: bool = False

    @property
    def order(self) -> int:
        """Number of equations."""
        return int(self.mass.shape[0])

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether every matrix of the stiffness is symmetric."""
        return bool(
            np.array_equal(self.stiffness, self.stiffness.T)
            and np.array_equal(self.harmonics, self.harmonics.swapaxes(-1, -2))
        )

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
        """Whether the system, freed of uniform damping, is Hamiltonian."""
        damping = self.uniform_damping
        return self.is_symmetric and damping is not None and (damping == 0 or not self.gyroscopic.any())

    @property
    def is_paired(self) -> bool:
        """Whether with every multiplier mu there is 1 / conj(mu)."""
        return self.is_reversible or (self.is_hamiltonian and not self.damping.any())


@dataclass(frozen=True)
class FirstOrder:
    """x' = A(t) x, A(t) = mean + sum_k Re(Z_k exp(2 pi i k t / period)), known but for ``error`` in each entry of A(t).

    ``is_paired``: with every multiplier mu there is 1 / conj(mu).
    """

    mean: Array
    harmonics: Array
    period: float
    error: float = 0.0
    is_paired: bool = False


def system_problem(system: HillSystem | PeriodicSystem) -> SecondOrder | FirstOrder:
    """Return the problem of a system, which must not be a batch."""
    require_one(system)
    reversible = system.structure == "reversible"
    if isinstance(system, PeriodicSystem):
        error = system.coefficient_error
        paired = not error and (reversible or system.structure == "hamiltonian")
        return FirstOrder(system.mean, system.harmonics, system.period, error, paired)
    n = system.order
    mass = np.eye(n) if system.mass is None else system.mass
    damping, gyroscopic = (np.zeros((n, n)) if m is None else m for m in (system.damping, system.gyroscopic))
    return SecondOrder(mass, damping, gyroscopic, system.stiffness, system.harmonics, system.period, reversible)


class Oscillators(NamedTuple):
    """M q'' + (C + G) q' + K(t) q = 0 with the period as the unit of time and M close to the unit matrix.

    ``excess`` is M - I, None where zero, and ``defect`` bounds its largest row sum; ``damping`` and ``gyroscopic`` are
    None where zero; the amplitude Z_k of the stiffness stands in ``waves`` at index k - 1.
    """

    excess: Matrix | None
    defect: float
    damping: Matrix | None
    gyroscopic: Matrix | None
    stiffness: Matrix
    waves: list[Matrix]


class Flow(NamedTuple):
    """x' = A(t) x with the period as the unit of time: A = mean + sum_k cosine_k cos 2 pi k t + sine_k sin 2 pi k t.

    ``error`` bounds the row sums of the error of A(t).
    """

    mean: Matrix
    cosines: list[Matrix]
    sines: list[Matrix]
    error: float


def row_sum(matrix: Matrix) -> float:
    """Return an upper bound of the largest sum of moduli in a row, which bounds the moduli of eigenvalues."""
    return float(up(matrix.upper().sum(-1)).max())


def oscillators(arithmetic: Arithmetic, system: SecondOrder, period: Fraction, *, freed: bool) -> Oscillators:
    """Return a system of second order in balls; ``freed`` of uniform damping, by which M c^2 leaves the stiffness."""
    mass = arithmetic.exact(system.mass)
    stiffness = arithmetic.exact(system.stiffness)
    damping = system.uniform_damping
    if freed and damping:
        stiffness = stiffness - mass * arithmetic.rational(damping * damping)
    unit = np.eye(system.order)
    plain = np.array_equal(system.mass, unit)
    transform = None if plain else arithmetic.exact(_congruence(system.mass))

    def scaled(matrix: Matrix, power: int) -> Matrix:
        if transform is not None:
            matrix = transform @ matrix @ transform.adjoint()
        return matrix * arithmetic.rational(period**power) if power else matrix

    excess = None if plain else scaled(mass, 0) - arithmetic.exact(unit)
    defect = row_sum(excess) if excess is not None else 0.0
    if not defect < 0.5:
        raise Unresolved("the mass matrix cannot be distinguished from a singular one")
    dissipation = system.damping.any() and not freed
    return Oscillators(
        excess,
        defect,
        scaled(arithmetic.exact(system.damping), 1) if dissipation else None,
        scaled(arithmetic.exact(system.gyroscopic), 1) if system.gyroscopic.any() else None,
        scaled(stiffness, 2),
        [scaled(arithmetic.exact(wave if wave.imag.any() else wave.real), 2) for wave in system.harmonics],
    )


def _congruence(mass: Array) -> Array:
    """Return X with X M X^T close to the unit matrix."""
    try:
        return np.linalg.inv(np.linalg.cholesky(mass))
    except np.linalg.LinAlgError:
        raise Unresolved("the mass matrix cannot be distinguished from one that is not positive definite") from None


def flow_of_oscillators(arithmetic: Arithmetic, system: Oscillators) -> Flow:
    """Return the system of first order for positions and velocities."""
    n = system.stiffness.shape[0]
    inverse = -_inverse_mass(arithmetic, system)
    mean = arithmetic.zeros((2 * n, 2 * n), real=True)
    mean[:n, n:] = arithmetic.exact(np.eye(n))
    mean[n:, :n] = inverse @ system.stiffness
    for friction in (system.damping, system.gyroscopic):
        if friction is not None:
            mean[n:, n:] = mean[n:, n:] + inverse @ friction
    cosines: list[Matrix] = []
    sines: list[Matrix] = []
    for wave in system.waves:
        real, imaginary = wave.parts()
        for part, place in ((real, cosines), (-imaginary, sines)):
            block = arithmetic.zeros((2 * n, 2 * n), real=True)
            block[n:, :n] = inverse @ part
            place.append(block)
    return _balanced(Flow(mean, cosines, sines, 0.0))


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
    waves = [(arithmetic.exact(wave) * factor).parts() for wave in system.harmonics]
    mean = arithmetic.exact(system.mean) * factor
    return _balanced(
        Flow(mean, [wave[0] for wave in waves], [-wave[1] for wave in waves], 0.0), up(system.error * float(period))
    )


def _balanced(flow: Flow, entry_error: float = 0.0) -> Flow:
    """Scale the unknowns by powers of two so that rows and columns have alike sums."""
    from scipy.linalg import matrix_balance

    size = sum((matrix.upper() for matrix in (*flow.cosines, *flow.sines)), flow.mean.upper())
    if not np.isfinite(size).all():
        raise Unresolved("the coefficients are too large")
    scale = matrix_balance(np.where(size > 1e-200, size, 0.0), permute=False, separate=True)[1][0]
    ratio = scale[None, :] / scale[:, None]
    error = float(up(entry_error * ratio.sum(1).max())) if entry_error else 0.0
    return Flow(
        flow.mean.shifted(ratio),
        [matrix.shifted(ratio) for matrix in flow.cosines],
        [matrix.shifted(ratio) for matrix in flow.sines],
        error,
    )
