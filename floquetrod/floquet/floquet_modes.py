"""The Floquet solutions of any equation or system, marched by `solve`; with delays, by collocation of a period."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Complexes, shaped
from floquetrod._util.content import ByContent
from floquetrod.equations import DelaySystem, PeriodicSystem
from floquetrod.floquet.delay_modes import ExponentialSolution, delayed_solutions
from floquetrod.floquet.delay_solve import DelaySolution
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.monodromy_matrix import marched, monodromy_over_period, states_of
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.problems import Problem, require_problem
from floquetrod.floquet.solve import Solution

_LATEST = 1e6  # periods (a choice: beyond it rounding of the phase costs more than ten digits)
_DECAYS = 1.0 - 1e-6  # magnitudes of multipliers below it are found from the map backwards (a choice)
_SURE = 1e-3  # rad that the error of the map may turn an eigenvector by (a choice)
_LARGEST_RESIDUAL = 1e-6  # of a solution, relative (a choice)


@dataclass(frozen=True, eq=False, repr=False)
class FloquetMode(ByContent):
    """A solution x(t) = exp(exponent t) p(t), p of the period of the equation.

    Attributes
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
    exponent : complex
        Its real part is the growth rate; the imaginary one lies between -pi / period and pi / period, of a system that
        is "unitary" minus the quasienergy.  With delays and constant coefficients it is a characteristic root.
    period : float
    error : float
        Estimate of the largest error of a state, as a fraction of the largest state within a period, of both
        parts, by how much the state at the end of the period differs from exp(exponent period) times that at its start,
        and the angle by which the error of the map may turn the start.  With delays it is twice the change to fewer
        nodes of collocation, and rounding.
    """

    equation: Any
    exponent: complex
    period: float
    error: float
    _parts: tuple[Solution | DelaySolution | ExponentialSolution, ...]

    def __call__(self, time: Any, derivative: int = 0) -> Any:
        """Return the solution at times (array_like), or its first derivative.

        Complex; of a scalar equation in the shape of ``time``, of a system with its n components in a last axis.
        """
        times = validate.array("time", time, least=-_LATEST * self.period, largest=_LATEST * self.period)
        periods = np.floor(times / self.period)
        phase = np.clip(times - periods * self.period, 0.0, self.period)
        state = _joined([np.asarray(part(phase, derivative)) for part in self._parts])
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            values = _times(np.exp(self.exponent * self.period * periods), state)
        return shaped(values, values.shape)

    def periodic(self, time: Any) -> Any:
        """Return the periodic part p at times, exp(-exponent t) x(t).

        Returns
        -------
        ndarray
            (..., n), behind the shape of ``time``.

        Raises
        ------
        TypeError, ValueError
            For times other than finite numbers.
        """
        times = validate.array("time", time, least=-_LATEST * self.period, largest=_LATEST * self.period)
        phase = times - np.floor(times / self.period) * self.period
        values = _times(np.exp(-self.exponent * phase), np.asarray(self(phase)))
        return shaped(values, values.shape)

    def __repr__(self) -> str:
        """Return the equation, the exponent and the error of the solution."""
        return (
            f"<Floquet solution of {type(self.equation).__name__}, exponent {self.exponent:.6g}, values +- "
            f"{self.error:.1g} of the largest>"
        )


def _joined(parts: Sequence[NDArray[Any]]) -> Complexes:
    """Return the sum of a real part and an imaginary one, or the one complex part."""
    return parts[0] if len(parts) == 1 else np.asarray(parts[0] + 1j * parts[1])


def _times(factors: Any, states: Complexes) -> Complexes:
    """Return factors times states, whose components are in a last axis where they have several."""
    several = np.asarray(factors)
    return np.asarray(several.reshape(several.shape + (1,) * (states.ndim - several.ndim)) * states)


@np.errstate(over="ignore", invalid="ignore")  # of what overflows: its error is not finite then
def floquet_solutions(equation: Problem) -> tuple[FloquetMode, ...]:
    """Return the Floquet solutions exp(exponent t) p(t) of any equation or system, the faster growing first.

    As many as the equation has multipliers, 2 of a scalar equation, independent of each other.  Each begins with a
    state of norm 1: an eigenvector of the map over a period, marched by `floquetrod.solve`, backwards where it decays.
    Where a system is "unitary" they are orthogonal at all times; where two of its quasienergies nearly coincide,
    `FloquetMode.error` includes the angle by which their solutions may be mixed.  For Mathieu's equation
    `floquetrod.mathieu.floquet_solutions` has Fourier series.

    A system with delays has infinitely many: those of the multipliers that `floquetrod.stability` lists are returned,
    by collocation of one period, in which values k periods back are 1 / multiplier^k times those of the period itself.

    Parameters
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        One, not a batch.

    Returns
    -------
    tuple of FloquetMode

    Raises
    ------
    TypeError
        For anything else.
    ValueError
        Where multipliers of a system that is not "unitary" cannot be distinguished and need not have as many solutions,
        as on a boundary of stability, where they span too many decades, and where a solution grows beyond the range of
        `floquetrod.solve`; with delays where a period has too many turns for collocation, or its solutions begin with a
        state of zero.

    Examples
    --------
    >>> import floquetrod as fr
    >>> growing, decaying = floquet_solutions(fr.Meissner(alpha=0.5, beta=-0.25))
    >>> f"{growing.exponent:.9f}", growing.error < 1e-12
    ('0.270847649+0.500000000j', True)

    Of a delay of 20 periods, the history and what follows from it are one function:

    >>> delayed = fr.DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], delayed=[(40.0 * math.pi, [[0.2]])])
    >>> mode = floquet_solutions(delayed)[0]
    >>> error = mode(1.0 + 2.0 * math.pi) - mode(1.0) * np.exp(2.0 * math.pi * mode.exponent)
    >>> bool(abs(error[0]) < 1e-12), mode.error < 1e-9
    (True, True)
    """
    require_problem(equation)
    if isinstance(equation, DelaySystem):
        return _in_order(_delayed_modes(equation))
    modes = [_mode(equation, pair) for pair in _eigenpairs(equation)]
    return _in_order(modes)


def _in_order(modes: list[FloquetMode]) -> tuple[FloquetMode, ...]:
    return tuple(sorted(modes, key=lambda mode: (-mode.exponent.real, -mode.exponent.imag)))


def _delayed_modes(system: DelaySystem) -> list[FloquetMode]:
    """Return the Floquet solutions of the multipliers that a verdict lists."""
    verdict: Any = stability(system)
    solutions = delayed_solutions(system, verdict) if verdict.exponents else None
    if solutions is None:
        raise _indistinct(system, "some")
    largest = max(solution.error for _, solution in solutions)
    if not largest < _LARGEST_RESIDUAL:
        raise ValueError(
            "equation must be one whose solutions collocation of a period resolves, none of a state of zero at the "
            f"beginning, got {validate.short(system)}, whose solutions are off by up to {largest:.1g}"
        )
    period = float(system.period)
    return [FloquetMode(system, exponent, period, solution.error, (solution,)) for exponent, solution in solutions]


class _Eigenpair(NamedTuple):
    """A multiplier of the map over a period, or of that backwards, an eigenvector, and about its error as an angle."""

    multiplier: complex
    vector: Complexes
    angle: float
    backward: bool


def _eigenpairs(equation: Problem) -> list[_Eigenpair]:
    """Return the multipliers; those that decay from the map backwards, in which they are the largest."""
    order = states_of(equation)
    growing = _independent(equation, order, backward=False)
    return growing + (_independent(equation, order - len(growing), backward=True) if len(growing) < order else [])


def _independent(equation: Problem, most: int, *, backward: bool) -> list[_Eigenpair]:
    """Return eigenvalues of a map over a period, none that decay, and independent eigenvectors, ``most`` of them.

    ValueError where there may be fewer vectors than eigenvalues.
    """
    matrix, error = monodromy_over_period(equation, backward=backward)
    unitary = isinstance(equation, PeriodicSystem) and equation.keeps_norm
    discs = (spectra.normal_discs if unitary else spectra.diagonalised_discs)(matrix, error * len(matrix))
    if discs is None:
        raise _indistinct(equation, "some")
    values = discs.values / np.abs(discs.values) if unitary else discs.values
    eigenpairs = []
    for cluster in discs.clusters:
        if float(np.abs(discs.values[cluster]).max()) < _DECAYS and not backward:
            continue
        vectors, angle = discs.right[:, cluster], spectra.subspace_error(discs, cluster)
        if len(cluster) > 1:
            vectors = spectra.basis_of(discs, cluster)
            block = vectors.conj().T @ matrix @ vectors - np.mean(discs.values[cluster]) * np.eye(len(cluster))
            angle = angle if float(np.abs(block).max()) <= 8.0 * discs.error else math.inf
        angles = [angle] * len(cluster)
        if unitary and not angle < _SURE:
            # A unitary map has N orthonormal eigenvectors, whatever its eigenvalues: Schur's, each as sure as its gap.
            vectors = discs.right[:, cluster]
            angles = [min(1.0, spectra.subspace_error(discs, np.array([i]))) for i in cluster]
        eigenpairs += [
            _Eigenpair(complex(values[i]), vectors[:, k], angles[k], backward) for k, i in enumerate(cluster)
        ]
    eigenpairs = sorted(eigenpairs, key=lambda pair: -abs(pair.multiplier))[:most]
    unsure = [pair.multiplier for pair in eigenpairs if not (pair.angle < _SURE or unitary)]
    if unsure:
        raise _indistinct(equation, f"{1.0 / unsure[0] if backward else unsure[0]:.6g}")
    return eigenpairs


def _indistinct(equation: Problem, where: str) -> ValueError:
    return ValueError(
        f"equation must have multipliers that can be distinguished, or as many solutions as they are, got {where} that "
        f"cannot: {validate.short(equation)} is on a boundary of stability, or too close to one"
    )


def _mode(equation: Problem, pair: _Eigenpair) -> FloquetMode:
    """March an eigenvector over a period, and check that it returns multiplied."""
    period, factor = float(equation.period), pair.multiplier
    span = (period, 0.0) if pair.backward else (0.0, period)
    vector, mu = (pair.vector / factor, 1.0 / factor) if pair.backward else (pair.vector, factor)
    is_complex = isinstance(equation, PeriodicSystem) and equation.is_complex
    starts = [vector] if is_complex else [vector.real, vector.imag]
    parts = tuple(marched(equation, np.ascontiguousarray(start), span) for start in starts)
    begin, end = (_joined([part.states[i] for part in parts]) for i in (0, -1))
    size = max(float(np.abs(part.states).max()) for part in parts)
    residual = float(np.abs(end - factor * begin).max()) / size
    if not residual < _LARGEST_RESIDUAL:
        raise ValueError(
            f"equation must have multipliers that a double can hold beside each other, got {validate.short(equation)}, "
            f"whose Floquet solution of multiplier {mu:.6g} misses its end by {residual:.1g}"
        )
    error = max(residual, *(part.error for part in parts)) + (pair.angle + EPS) * float(np.abs(vector).max()) / size
    exponent = complex(np.log(complex(mu.real, mu.imag + 0.0))) / period  # of -x + 0i, whatever the sign of zero
    if isinstance(equation, PeriodicSystem) and equation.keeps_norm:
        exponent = complex(0.0, exponent.imag)
    return FloquetMode(equation, exponent, period, error, parts)
