"""The map over a period and the Floquet solutions of any equation or system, marched by `solve`."""

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
from floquetrod.equations import Equation, HillSystem, PeriodicSystem
from floquetrod.equations.hill_system import states
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.problems import Problem, require_problem, require_without_delays
from floquetrod.floquet.solve import Solution, solve

_LATEST = 1e6  # periods (a choice: beyond it rounding of the phase costs more than ten digits)
_DECAYS = 1.0 - 1e-6  # magnitudes of multipliers below it are found from the map backwards (a choice)
_SURE = 1e-3  # rad that the error of the map may turn an eigenvector by (a choice)
_LARGEST_RESIDUAL = 1e-6  # of a solution, relative (a choice)


class MonodromyMatrix(NamedTuple):
    """The matrix (N, N) that maps a state over one period, and an estimate of the largest error of an entry.

    Complex for a complex system.
    """

    matrix: NDArray[Any]
    error: float


def monodromy_over_period(problem: Problem, *, backward: bool = False) -> MonodromyMatrix:
    """Return the matrix that maps (A, A'), (q, q') or x from the beginning of a period to its end, or back.

    Each column is a solution with unit initial values; its error is the estimate of `floquetrod.solve`.
    """
    require_without_delays(problem, "a monodromy matrix, whose map is one of histories")
    span = (float(problem.period), 0.0) if backward else (0.0, float(problem.period))
    order = _states(problem)
    columns = [_marched(problem, unit, span) for unit in np.eye(order)]
    matrix = np.stack([column.states[-1] for column in columns], axis=1)
    return MonodromyMatrix(matrix, max(column.error * float(np.abs(column.states).max()) for column in columns))


def _states(problem: Problem) -> int:
    """Return how many numbers make a state."""
    return 2 if isinstance(problem, Equation) else states(problem)


def _marched(problem: Problem, state: NDArray[Any], span: tuple[float, float]) -> Solution:
    """Return the solution from a state at the beginning of a span."""
    start = state.reshape(2, -1) if isinstance(problem, HillSystem) else state
    try:
        solution: Solution = solve(problem, start, span)
    except ValueError as error:
        raise ValueError(f"equation must be one that can be solved over its period, and {error}") from None
    return solution


@dataclass(frozen=True, eq=False, repr=False)
class FloquetMode(ByContent):
    """A solution x(t) = exp(exponent t) p(t), p of the period of the equation.

    Attributes
    ----------
    equation : Equation, HillSystem or PeriodicSystem
    exponent : complex
        Its real part is the growth rate; the imaginary one lies between -pi / period and pi / period, of a system that
        is "unitary" minus the quasienergy.
    period : float
    error : float
        Estimate of the largest error of a state, as a fraction of the largest state within a period, of both
        parts, by how much the state at the end of the period differs from exp(exponent period) times that at its start,
        and the angle by which the error of the map may turn the start.
    """

    equation: Any
    exponent: complex
    period: float
    error: float
    _parts: tuple[Solution, ...]

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
        """Return the periodic part p at times, exp(-exponent t) x(t)."""
        times = validate.array("time", time, least=-_LATEST * self.period, largest=_LATEST * self.period)
        phase = times - np.floor(times / self.period) * self.period
        values = _times(np.exp(-self.exponent * phase), np.asarray(self(phase)))
        return shaped(values, values.shape)

    def __repr__(self) -> str:
        """Return the equation and the exponent."""
        return f"<Floquet solution of {type(self.equation).__name__}, exponent {self.exponent:.6g}, {self.error:.1g}>"


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

    Parameters
    ----------
    equation : Equation, HillSystem or PeriodicSystem
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
        `floquetrod.solve`.

    Examples
    --------
    >>> import floquetrod as fr
    >>> growing, decaying = floquet_solutions(fr.Meissner(alpha=0.5, beta=-0.25))
    >>> f"{growing.exponent:.9f}", growing.error < 1e-12
    ('0.270847649+0.500000000j', True)
    """
    require_problem(equation)
    modes = [_mode(equation, pair) for pair in _eigenpairs(equation)]
    return tuple(sorted(modes, key=lambda mode: (-mode.exponent.real, -mode.exponent.imag)))


class _Eigenpair(NamedTuple):
    """A multiplier of the map over a period, or of that backwards, an eigenvector, and about its error as an angle."""

    multiplier: complex
    vector: Complexes
    angle: float
    backward: bool


def _eigenpairs(equation: Problem) -> list[_Eigenpair]:
    """Return the multipliers; those that decay from the map backwards, in which they are the largest."""
    order = _states(equation)
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
    parts = tuple(_marched(equation, np.ascontiguousarray(start), span) for start in starts)
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
