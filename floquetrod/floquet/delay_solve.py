"""A solution of a system with delays from its history: step by step, by collocation."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats, shaped
from floquetrod._util.content import ByContent
from floquetrod.equations import DelaySystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.multipliers import delay_maps
from floquetrod.floquet.multipliers.delay_mesh import integral, rule
from floquetrod.floquet.references import DELAYED_SOLUTIONS, references

History = Callable[[float], Any]

_NODES = (16, 22)  # of a step, the second number to learn the error of the first (heuristic)
_INSIDE = np.linspace(-0.9, 0.9, 5)  # of a step from -1 to 1, where its error is learned, beside its end (a choice)
_RADIANS = 4.0  # that solutions turn by in a step, about (a choice)
_GENERATIONS = 12  # of the images of a jump under delays that end a step (a choice)
_MOST_STEPS = 20_000  # (a choice: some seconds)
_MOST_IMAGES = 5_000  # of jumps (a choice)
_ROUNDING = 16.0 * EPS


class _DelayedSteps(NamedTuple):
    """A solution: ends of its steps, Legendre coefficients (steps, m, n) on each, and states at the ends."""

    ends: Floats
    series: Floats
    states: Floats


@dataclass(frozen=True, eq=False, repr=False)
class DelaySolution(ByContent):
    """A solution of a system with delays on an interval of time, which a call evaluates anywhere in it.

    Attributes
    ----------
    equation : DelaySystem
    time : ndarray (steps + 1,)
        Where the steps begin and end.
    states : ndarray (steps + 1, N)
        There: q and then q', or x.
    error : float
        Estimate of the largest error of a state, as a fraction of the largest state until then: twice the difference
        from steps with more nodes, and rounding.
    """

    equation: DelaySystem
    time: Floats
    states: Floats
    error: float
    series: Floats

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(DELAYED_SOLUTIONS)

    def __call__(self, time: Any, derivative: int = 0) -> Any:
        """Return the solution at times within the interval (array_like), or its derivative; n in the last axis."""
        times = validate.array("time", time, least=float(self.time[0]), largest=float(self.time[-1]))
        derivative = validate.integer("derivative", derivative, 0, 1)
        values = _values(_DelayedSteps(self.time, self.series, self.states), times.ravel(), derivative)
        return shaped(values, (*times.shape, self.equation.order))

    def conjugate(self) -> DelaySolution:
        """Return the conjugate of a complex solution."""
        return replace(self, states=self.states.conj(), series=self.series.conj())

    def __repr__(self) -> str:
        """Return what was solved."""
        span = f"from {self.time[0]:g} to {self.time[-1]:g}"
        return f"<solution of DelaySystem {span}, error {self.error:.1g}, {len(self.time) - 1} steps>"


def solve_delayed(system: DelaySystem, initial: Any, start: float, stop: float) -> DelaySolution:
    """Return the solution from a history, see `floquetrod.solve`."""
    if not stop > start:
        raise ValueError(f"span must go forward in time for a system with delays, got {start:g} to {stop:g}")
    history, rate = _history(system, initial, start)
    ends = _ends(system, start, stop)
    one, other = (_marched(system, history, rate, ends, nodes) for nodes in _NODES)
    largest = np.maximum.accumulate(np.abs(other.states).max(axis=1))
    inside = [legendre.legval(_INSIDE, np.moveaxis(each.series, 1, 0)) for each in (one, other)]
    gaps = np.abs(one.states - other.states).max(axis=1)
    gaps[1:] = np.maximum(gaps[1:], np.abs(inside[0] - inside[1]).max(axis=(1, 2)))
    gaps /= np.maximum(largest, 1e-300)
    solution = DelaySolution(system, one.ends, one.states, 0.0, one.series)
    return replace(solution, error=2.0 * float(gaps.max()) + _ROUNDING * len(ends))


def _history(system: DelaySystem, initial: Any, start: float) -> tuple[History, Floats | None]:
    """Return the history as a function, checked at its end, and the rate at the start of equations of second order."""
    rate = None
    if system.is_second_order:
        if not isinstance(initial, tuple | list) or len(initial) != 2:
            raise TypeError(
                "initial must be (history, rate): q(t) until the start, a function or one vector, and q' there, "
                f"got {validate.short(initial)}"
            )
        initial, rate = initial[0], _vector("initial[1]", initial[1], system.order)
    if not callable(initial):
        constant = _vector("initial", initial, system.order)
        return (lambda _: constant), rate
    given: Callable[[float], Any] = initial

    def history(t: float) -> Floats:
        return _vector(f"history({t:g})", given(t), system.order)

    history(start)
    return history, rate


def _vector(name: str, value: Any, order: int) -> Floats:
    array = validate.array(name, value)
    if array.shape != (order,):
        raise ValueError(f"{name} must be a vector of {order}, got shape {array.shape}")
    return np.array(array)


def _ends(system: DelaySystem, start: float, stop: float) -> Floats:
    """Return the ends of steps: on jumps, and what delays make of them, and no step longer than a delay."""
    begin, end = Fraction(start), Fraction(stop)
    period = by_pieces.exact_period(system.present)
    parts = (system.present, *(term.coefficient for term in system.delayed))
    jumps = {piece.begin for part in parts if part.pieces for piece in by_pieces.in_time(part)}
    turns = range(math.floor(begin / period), math.ceil(end / period) + 1) if jumps else ()
    if len(turns) * len(jumps) > _MOST_STEPS:
        raise ValueError(f"span takes more than {_MOST_STEPS:,} steps; take a shorter one")
    fresh = {begin} | {time for turn in turns for jump in jumps if begin < (time := turn * period + jump) < end}
    images = set(fresh)
    for _ in range(_GENERATIONS):
        fresh = {t + Fraction(d) for t in fresh for d in system.delays if t + Fraction(d) < end} - images
        if len(images) + len(fresh) > _MOST_IMAGES:
            break
        images |= fresh
    edges = [*sorted(map(float, images)), stop]
    waves = max(piece.harmonics.shape[-3] for part in parts for piece in by_pieces.in_time(part))
    turning = delay_maps.rate(system) + 2.0 * math.pi * waves / system.period
    longest = min([_RADIANS / max(turning, 1e-300), stop - start, *map(float, system.delays)])
    least = 1e-13 * max(abs(start), abs(stop))
    edges = [t for t, later in pairwise(edges) if later - t > least] + [stop]
    counts = [math.ceil((high - low) / longest * (1.0 - 1e-12)) for low, high in pairwise(edges)]
    if sum(counts) > _MOST_STEPS:
        raise ValueError(f"span takes {sum(counts):,} steps, at most {_MOST_STEPS:,}; take a shorter one")
    parts_ = [np.linspace(low, high, n + 1)[1:] for (low, high), n in zip(pairwise(edges), counts, strict=True)]
    return np.concatenate([[start], *parts_])


def _marched(system: DelaySystem, history: History, rate: Floats | None, ends: Floats, nodes: int) -> _DelayedSteps:
    """Return the solution by steps with so many nodes."""
    # The method of steps by Gauss-Legendre collocation: x'' = K x + D x' + sum_d M_d x(t - tau_d), or x' = K x + ...
    # where ``rate`` is None; given holds K, D and M_d at the nodes of a step.  Unknown are the highest derivatives r at
    # the nodes (nodes, n); x and x' there are q + (t - low) v + half^2 I_2 r and v + half I_1 r, I_k the matrix that
    # integrates the interpolant k times from -1.  Steps are no longer than the least delay, so that x(t - tau_d) is
    # known: of the history or of the steps before.  Then (1 - left) r = right, a linear system of nodes n equations.
    # states (steps + 1, n derivatives) are x and x' at the ends, series the Legendre coefficients of x on each step.
    n, derivatives = system.order, 2 if rate is not None else 1
    count = len(ends) - 1
    places = 0.5 * (rule(nodes)[0] + 1.0)
    integrals = [integral(nodes, rule(nodes)[0], k + 1) for k in range(derivatives)]
    whole = [integral(nodes, np.array([1.0]), k + 1)[0] for k in range(derivatives)]
    values = history(float(ends[0]))
    states = np.zeros((count + 1, n * derivatives))
    states[0] = values if rate is None else np.concatenate([values, rate])
    series = np.zeros((count, nodes + derivatives, n))
    for i, (low, high) in enumerate(pairwise(ends.tolist())):
        half = 0.5 * (high - low)
        times = low + 2.0 * half * places
        given = delay_maps.coefficients(system, 1.0, times)
        q, v = states[i, :n], states[i, n:]
        reach = q + (times - low)[:, None] * v if derivatives == 2 else np.broadcast_to(q, (nodes, n))
        right = np.einsum("fij,fj->fi", given.value[0], reach)
        top = half**derivatives * integrals[-1]
        left = given.value[0][:, :, None, :] * top[:, None, :, None]
        if given.rate is not None:
            right = right + given.rate[0] @ v
            left = left + given.rate[0][:, :, None, :] * (half * integrals[0])[:, None, :, None]
        known = _DelayedSteps(ends[: i + 1], series[:i], states[: i + 1])
        for delay, matrix in zip(system.delays, given.delayed, strict=True):
            right = right + np.einsum("fij,fj->fi", matrix[0], _earlier(known, history, times - float(delay)))
        size = nodes * n
        rates = np.linalg.solve(np.eye(size) - left.reshape(size, size), right.ravel()).reshape(nodes, n)
        series[i] = as_series(rates, half, states[i].reshape(derivatives, n))
        ended = [half * whole[0] @ rates + (v if derivatives == 2 else q)]
        if derivatives == 2:
            ended.insert(0, q + 2.0 * half * v + half**2 * whole[1] @ rates)
        states[i + 1] = np.concatenate(ended)
    return _DelayedSteps(ends, series, states)


def as_series(rates: Floats, half: float, state: Floats) -> Floats:
    """Return Legendre coefficients of the solution on a step from the values of its highest derivative."""
    series: NDArray[Any] = rule(len(rates))[1] @ rates
    for value in state[::-1]:
        series = half * legendre.legint(series, lbnd=-1, axis=0)
        series[0] += value
    return np.asarray(series)


def joined_series(rates: Any, breaks: Sequence[float], state: Any) -> tuple[Any, Any]:
    """Return Legendre coefficients on all pieces from highest derivatives, and the states at the ends.

    Of rates (pieces, nodes, n) and the state (derivatives, n) at the beginning, q and q' or x: series
    (pieces, nodes + derivatives, n) and states (pieces + 1, derivatives n).
    """
    series, states = [], [state]
    for values, (low, high) in zip(rates, pairwise(breaks), strict=True):
        series.append(as_series(values, 0.5 * (high - low), states[-1]))
        ends = [series[-1].sum(axis=0)]  # P_k(1) = 1, P_k'(1) = k (k + 1) / 2
        if len(state) == 2:
            k = np.arange(len(series[-1]))
            ends.append((0.5 * k * (k + 1)) @ series[-1] * (2.0 / (high - low)))
        states.append(np.array(ends))
    return np.array(series), np.array(states).reshape(len(states), -1)


def _earlier(known: _DelayedSteps, history: History, times: Floats) -> Floats:
    """Return values at times before the step, of the history too."""
    before = times <= known.ends[0]
    values = np.empty((len(times), known.series.shape[2]))
    if before.any():
        values[before] = [history(t) for t in times[before].tolist()]
    if not before.all():
        values[~before] = _values(known, times[~before], 0)
    return values


def _values(steps: _DelayedSteps, times: Floats, derivative: int) -> Any:
    """Return the solution at times of the steps, or its derivative, (times, n)."""
    place = np.clip(np.searchsorted(steps.ends, times, side="right") - 1, 0, len(steps.series) - 1)
    values: Any = np.empty((times.size, steps.series.shape[2]), dtype=steps.series.dtype)
    for step in np.unique(place):
        here = place == step
        low, high = steps.ends[step], steps.ends[step + 1]
        series = steps.series[step]
        if derivative:
            series = legendre.legder(series) * (2.0 / (high - low))
        values[here] = legendre.legval(2.0 * (times[here] - low) / (high - low) - 1.0, series).T
    return values
