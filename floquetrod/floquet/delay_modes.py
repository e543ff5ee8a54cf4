"""Floquet solutions of systems with delays: null vectors of the collocation of one period.

On a solution with x(t + T) = mu x(t) a value k periods back is mu^-k times a value of the period itself.  With r the
highest derivatives at the nodes, s the state at the beginning and t in periods,

    (I - L(mu)) r = S(mu) s,    E r + E_0 s = mu s,    L = sum_k mu^-k L_k,  S = sum_k mu^-k S_k,

so that Delta(mu) s = (E (I - L)^-1 S + E_0 - mu I) s = 0: a matrix of no more rows than a state, however long the
delays are.  J. Sieber and R. Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011) 129, doi:10.1137/100796455.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod.equations import DelaySystem
from floquetrod.equations.delay_system import moved
from floquetrod.floquet.delay_solve import DelaySolution, joined_series
from floquetrod.floquet.multipliers import delay_maps, delay_mesh, delay_roots, spectra
from floquetrod.floquet.multipliers.system_stability import SystemStability

_NODES = (14, 19, 25, 32, 40)  # in a piece (a choice)
_MOST_ROWS = 1200  # of collocation (a choice: a second)
_RADIANS = 12.0  # that solutions turn by in a piece, about, at the rate of the fastest decay too (a choice)
_UNCHANGED = 1e-12  # change to more nodes at which refinement ends
_STEPS = 4  # of Newton's method, from a multiplier of ten digits or so
_SIMILAR = 1e-6  # singular value of a null vector of several equal multipliers, over the next one (a choice)


class Periodicity(NamedTuple):
    """A solution over a period with x(t + T) = exp(exponent T) x(t), of state 1 at the beginning."""

    exponent: complex
    solution: DelaySolution | ExponentialSolution  # complex; its error is an estimate

    def conjugate(self) -> Periodicity:
        """Return the conjugate solution."""
        return Periodicity(self.exponent.conjugate(), self.solution.conjugate())


class _Collocated(NamedTuple):
    """The equations of a period with so many nodes in each piece, time in periods."""

    breaks: tuple[float, ...]
    nodes: int
    powers: tuple[tuple[int, Floats, Floats], ...]  # k, L_k (F n, F n), S_k (F n, d n)
    end: Floats  # (d n, F n)
    end_state: Floats  # (d n, d n)

    def sums(self, log: complex) -> tuple[Complexes, Complexes, Complexes, Complexes]:
        """Return L and S at mu = exp(log), and their derivatives by it."""
        factors = [(np.exp(-k * log), k, left, start) for k, left, start in self.powers]
        left: Any = sum(factor * each for factor, _, each, _ in factors)
        start: Any = sum(factor * each for factor, _, _, each in factors)
        left_rate: Any = sum(-k * factor * each for factor, k, each, _ in factors)
        start_rate: Any = sum(-k * factor * each for factor, k, _, each in factors)
        return left, start, left_rate, start_rate


class _Null(NamedTuple):
    """Null vectors of Delta: the logarithm of mu, states (d n, m), unknowns (F n, m) and the rounding of states."""

    log: complex
    states: Complexes
    unknowns: Complexes
    rounding: float


@np.errstate(all="ignore")  # solutions that overflow are refused
def delayed_solutions(system: DelaySystem, verdict: SystemStability) -> list[Periodicity] | None:
    """Return the solutions of the multipliers of a verdict; None where they are not resolved, or not independent."""
    exponents = np.asarray(verdict.exponents)
    values, radii = np.asarray(verdict.multipliers), np.asarray(verdict.multiplier_errors)
    solve = _characteristic if system.is_constant else _converged
    solved: list[Periodicity] = []
    laid = delay_maps.period_pieces(system, set())
    turning = delay_maps.rate(system, max(0.0, -float(exponents.real.min()))) * laid.period * laid.longest
    equations = _Equations.of(system, laid.cut(min(max(1, math.ceil(turning / _RADIANS)), _MOST_ROWS)))
    for cluster in spectra.touching(np.abs(values[:, None] - values[None, :]), radii):
        center = complex(exponents[cluster].mean())
        if center.imag < 0.0:
            continue
        modes = solve(equations, center, len(cluster))
        allowed = float(radii[cluster].max() / np.abs(values[cluster]).min()) + 1e-9
        if modes is None or not abs(modes[0].exponent - center) * system.period <= 2.0 * allowed:
            return None
        solved += modes + [mode.conjugate() for mode in modes if center.imag > 0.0]
    return solved


class _Equations(NamedTuple):
    """A system, the pieces of its period, and the equations of collocation so far, by nodes and by their change."""

    system: DelaySystem
    laid: delay_maps.PeriodPieces
    collocated: dict[int, _Collocated | None]
    moved: tuple[_Equations, ...]  # of the system with coefficients larger by their error, one after another

    @staticmethod
    def of(system: DelaySystem, laid: delay_maps.PeriodPieces) -> _Equations:
        """Return the equations of a system, none collocated yet."""
        others = moved(system) if system.coefficient_error and not system.is_constant else ()
        return _Equations(system, laid, {}, tuple(_Equations(other, laid, {}, ()) for other in others))

    def with_nodes(self, nodes: int) -> _Collocated | None:
        """Return the equations with so many nodes in each piece."""
        if nodes not in self.collocated:
            self.collocated[nodes] = _collocated(self.system, self.laid, nodes)
        return self.collocated[nodes]


@dataclass(frozen=True)
class ExponentialSolution:
    """A solution exp(exponent t) vector of a system with constant coefficients."""

    exponent: complex
    vector: Complexes
    error: float

    def __call__(self, time: Any, derivative: int = 0) -> Any:
        """Return the solution at times, or its derivative; n in the last axis."""
        return (self.exponent**derivative * np.exp(self.exponent * np.asarray(time)))[..., None] * self.vector

    def conjugate(self) -> ExponentialSolution:
        """Return the conjugate solution."""
        return ExponentialSolution(self.exponent.conjugate(), self.vector.conj(), self.error)


class _Linear(NamedTuple):
    """A matrix Delta at one exponent, or at one logarithm of a multiplier."""

    delta: Complexes  # (N, N)
    slope: Complexes  # (N, N), its derivative
    unknowns: Complexes  # (F n, N), the highest derivatives at the nodes for unit states; of collocation only
    size: float  # of its entries, in place of the next singular value where all are zero


class _Singular(NamedTuple):
    """A zero of det Delta, and the null vectors (m, N) of Delta there."""

    zero: complex
    linear: _Linear
    vectors: Complexes
    rate: float  # of the smallest singular value along the derivative
    gap: float  # to the next singular value
    rest: float  # largest singular value of several null vectors; 0 of one


def _singular(linearised: Callable[[complex], _Linear | None], near: complex, count: int) -> _Singular | None:
    """Return the zero of det Delta near a value, by Newton's method for one null vector, the value itself for several.

    None where Delta overflows, and where it does not have ``count`` null vectors.
    """
    # With Delta = sum_i u_i s_i v_i^H, s_N smallest, the zero is at s_N / (u_N^H Delta' v_N) less, to first order.
    zero = near
    for _ in range(_STEPS):
        attempt = linearised(zero)
        if attempt is None or count > len(attempt.delta) or not np.isfinite(attempt.delta).all():
            return None
        linear = attempt
        left, sizes, right = np.linalg.svd(linear.delta)
        rate = complex(left[:, -1].conj() @ linear.slope @ right[-1].conj())
        step = sizes[-1] / rate
        if count > 1 or not abs(step) > 4.0 * EPS * (1.0 + abs(zero)):
            break
        zero = complex(zero - step)
    gap = float(sizes[-count - 1]) if count < len(sizes) else linear.size
    rest = float(sizes[-count]) if count > 1 else 0.0
    if count > 1 and not rest <= _SIMILAR * gap:
        return None
    return _Singular(zero, linear, right[-count:].conj(), abs(rate), gap, rest)


def _characteristic(equations: _Equations, exponent: complex, count: int) -> list[Periodicity] | None:
    """Return ``count`` solutions of constant coefficients near a characteristic root."""
    system = equations.system

    def linearised(root: complex) -> _Linear:
        at = np.array([root], dtype=complex)
        delta, slope = (matrices[0] for matrices in delay_roots.characteristic(system, at, rate=True))
        return _Linear(
            delta, slope, np.empty((0, len(delta)), dtype=complex), float(np.abs(delta).max() + np.abs(slope).max())
        )

    singular = _singular(linearised, exponent, count)
    if singular is None:
        return None
    root = singular.zero
    off = sum(math.exp(min(-root.real * float(delay), 300.0)) for delay in system.delays) + 1.0
    off *= system.order * system.coefficient_error
    turned = (8.0 * EPS * singular.linear.size + off + singular.rest) / singular.gap
    moved = off / singular.rate * system.period
    modes = []
    for vector in singular.vectors:
        norm = np.linalg.norm(vector) * (math.hypot(1.0, abs(root)) if system.is_second_order else 1.0)
        largest = vector[np.argmax(np.abs(vector))]
        vector = vector * (np.conj(largest) / (np.abs(largest) * norm))
        modes.append(Periodicity(root, ExponentialSolution(root, vector, float(turned + moved))))
    return modes


def _converged(equations: _Equations, exponent: complex, count: int) -> list[Periodicity] | None:
    """Return ``count`` solutions near a multiplier, with more nodes until they stay as they are."""
    best: list[Periodicity] | None = None
    before: list[Periodicity] | None = None
    last = 0
    for nodes in _NODES:
        modes = _modes(equations, nodes, exponent, count)
        if modes is None:
            break
        if before is not None:
            changed = [_with_change(one, other) for one, other in zip(modes, before, strict=True)]
            if best is not None and not _worst(changed) < _worst(best):
                break
            best, last = changed, nodes
            if _worst(best) <= _UNCHANGED:
                break
        before = modes
    if best is None:
        return None
    for other in equations.moved:
        modes = _modes(other, last, best[0].exponent, count)
        if modes is None:
            return None
        best = [_with_change(one, near) for one, near in zip(best, modes, strict=True)]
    return best


def _worst(modes: list[Periodicity]) -> float:
    error = max(mode.solution.error for mode in modes)
    return error if error == error else math.inf


def _with_change(mode: Periodicity, other: Periodicity) -> Periodicity:
    """Return a solution with its error larger by twice its change from another, and from the other's exponent."""
    solution: Any = mode.solution
    times = np.linspace(0.0, float(solution.time[-1]), 8 * len(solution.time) + 33)
    values, others = (each.solution(times) for each in (mode, other))
    change = float(np.abs(values - others).max() / np.abs(values).max())
    turned = abs(mode.exponent - other.exponent) * float(solution.time[-1])
    return mode._replace(solution=replace(solution, error=solution.error + 2.0 * (change + turned)))


def _modes(equations: _Equations, nodes: int, exponent: complex, count: int) -> list[Periodicity] | None:
    """Return ``count`` solutions with so many nodes."""
    system, laid = equations.system, equations.laid
    collocated = equations.with_nodes(nodes)
    null = None if collocated is None else _null_vectors(collocated, exponent * system.period, count)
    if null is None:
        return None
    n, derivatives = system.order, 2 if system.is_second_order else 1
    own = Fraction(laid.period)
    edges = np.array([float(Fraction(share) * own) for share in laid.breaks])
    units = np.repeat(float(laid.period) ** -np.arange(derivatives), n)
    modes = []
    for state, unknowns in zip(null.states.T, null.unknowns.T, strict=True):
        series, states = joined_series(unknowns.reshape(-1, nodes, n), laid.breaks, state.reshape(derivatives, n))
        states = states * units
        phase = states[0][np.argmax(np.abs(states[0]))]
        scale = np.conj(phase) / (np.abs(phase) * float(np.linalg.norm(states[0])))
        residual = float(np.abs(states[-1] - np.exp(null.log) * states[0]).max() / np.abs(states).max())
        solution = DelaySolution(system, edges, states * scale, residual + null.rounding, series * scale)
        modes.append(Periodicity(null.log / float(system.period), solution))
    return modes


def _collocated(system: DelaySystem, laid: delay_maps.PeriodPieces, nodes: int) -> _Collocated | None:
    """Return the equations of collocation; None of too many."""
    n, derivatives = system.order, 2 if system.is_second_order else 1
    if n * nodes * (len(laid.breaks) - 1) > _MOST_ROWS:
        return None
    mesh, sources = delay_mesh.one_period(laid.breaks, nodes, derivatives, laid.delays(system), laid.active)
    given = delay_maps.coefficients(system, laid.period, mesh.nodes)
    size = n * len(mesh.nodes)

    def placed(coefficient: Floats, rows: Floats) -> Floats:
        return np.asarray(np.einsum("fij,fg->figj", coefficient[0], rows).reshape(size, -1))

    left = placed(given.value, mesh.value)
    start = placed(given.value, mesh.value_state)
    if given.rate is not None:
        left, start = left + placed(given.rate, mesh.rate), start + placed(given.rate, mesh.rate_state)
    powers: dict[int, list[Floats]] = {0: [left, start]}
    for coefficient, source in zip(given.delayed, sources, strict=True):
        for back in np.unique(source.periods[source.active]).tolist():
            here = (source.active & (source.periods == back))[:, None]
            terms = placed(coefficient, source.value * here), placed(coefficient, source.state * here)
            if back in powers:
                terms = terms[0] + powers[back][0], terms[1] + powers[back][1]
            powers[back] = list(terms)
    one = np.eye(n)
    return _Collocated(
        laid.breaks,
        nodes,
        tuple((k, *matrices) for k, matrices in sorted(powers.items())),  # type: ignore[misc]
        np.asarray(np.kron(mesh.end, one), dtype=np.float64),
        np.asarray(np.kron(mesh.end_state, one), dtype=np.float64),
    )


def _null_vectors(collocated: _Collocated, log: complex, count: int) -> _Null | None:
    """Return ``count`` null vectors of Delta near the logarithm of a multiplier."""
    from scipy.linalg import lu_factor, lu_solve

    one = np.eye(len(collocated.end_state))

    def linearised(log: complex) -> _Linear | None:
        left, start, left_rate, start_rate = collocated.sums(log)
        if not (np.isfinite(left).all() and np.isfinite(start).all()):
            return None
        factors = lu_factor(np.eye(len(left)) - left, check_finite=False)
        unknowns = lu_solve(factors, start, check_finite=False)
        delta = collocated.end @ unknowns + collocated.end_state - np.exp(log) * one
        slope = collocated.end @ lu_solve(factors, left_rate @ unknowns + start_rate, check_finite=False)
        slope = slope - np.exp(log) * one
        return _Linear(delta, slope, unknowns, 1.0 + float(np.abs(unknowns).max()))

    singular = _singular(linearised, log, count)
    if singular is None:
        return None
    unknowns = singular.linear.unknowns
    scale = 1.0 + float(np.abs(collocated.end).sum(axis=1).max() * np.abs(unknowns).max())
    rounding = EPS * math.sqrt(len(unknowns)) * scale / singular.gap + singular.rest / singular.gap
    states: NDArray[Any] = singular.vectors.T
    return _Null(singular.zero, states, unknowns @ states, rounding)
