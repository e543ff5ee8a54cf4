"""`fr.solve`: one solution of an equation or a system from its initial values, at any time, by Taylor series."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Complexes, Floats, shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod.equations import DelaySystem, HillSystem, PeriodicSystem
from floquetrod.equations.base import Equation, require
from floquetrod.equations.complex_form import complex_vector, real_vector
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.equations.pieces import exact_period, in_time
from floquetrod.floquet.references import SOLUTIONS, references

_ORDERS = (26, 32)  # of the series, the second one to learn the error of the first (heuristic)
_TOLERANCES = (1e-16, 1e-18)  # part of the solution that the last terms of a step may be
_MOST_STEPS = 20_000  # in the limit of a small system, fewer of a large one (a choice: some seconds)
_PI = Fraction(round(Fraction(3141592653589793238462643383279502884197, 10**39) * 2**125), 2**125)
_ROUNDING = 4.0 * EPS  # of states, at least (measured)
_LARGEST = 1e290  # of a solution (a choice: doubles reach 1e308)


class _Piece(NamedTuple):
    """x' = (mean + slope (t - begin) + sum_k Re(Z_k exp(i k w t))) x from ``begin`` of a period to the next piece.

    ``doubt`` is what the mean may be off by, as far as a solution shows it.
    """

    begin: Fraction
    mean: Floats
    slope: Floats
    harmonics: Complexes
    doubt: Floats

    def series(self, time: float, into: float, omega: float, order: int) -> Floats:
        """Return the Taylor coefficients (order, N, N) of the matrix about a time of the period and of the piece."""
        taylor = np.zeros((order, *self.mean.shape))
        taylor[0] = self.mean + self.slope * into
        if order > 1:
            taylor[1] = self.slope
        if len(self.harmonics):
            rates = 1j * omega * np.arange(1, len(self.harmonics) + 1)
            powers = np.exp(rates * time) * np.ones((order, 1))
            powers[1:] *= np.cumprod(rates / np.arange(1, order)[:, None], axis=0)
            taylor += np.einsum("jk,kab->jab", powers, self.harmonics).real
        return taylor


class _Course(NamedTuple):
    """The pieces of an equation in first order, and its period, exactly."""

    pieces: tuple[_Piece, ...]
    period: Fraction

    def place(self, time: Fraction, sign: float) -> tuple[Fraction, int]:
        """Return when the period begins in which a step from ``time`` goes, and the number of its piece."""
        turn = time // self.period * self.period
        if sign < 0.0 and turn == time:
            turn -= self.period
        begins, phase = [piece.begin for piece in self.pieces], time - turn
        return turn, (bisect_right(begins, phase) if sign > 0.0 else bisect_left(begins, phase)) - 1

    def edge(self, turn: Fraction, place: int, sign: float) -> Fraction:
        """Return the time at which a piece of the period ends, or backwards begins."""
        place += sign > 0.0
        return turn + (self.pieces[place].begin if place < len(self.pieces) else self.period)

    def taylor(self, time: Fraction, turn: Fraction, place: int, state: Floats, order: int) -> Floats:
        """Return the Taylor coefficients of the solution about a time in a piece, (order, N)."""
        piece, phase = self.pieces[place], time - turn
        omega = 2.0 * math.pi / float(self.period)
        matrices = piece.series(float(phase), float(phase - piece.begin), omega, order - 1)
        terms = np.zeros((order, state.size))
        terms[0] = state
        constant = not np.any(matrices[1:])
        for n in range(order - 1):
            if constant:
                terms[n + 1] = matrices[0] @ terms[n] / (n + 1)
            else:
                terms[n + 1] = np.einsum("jab,jb->a", matrices[: n + 1], terms[n::-1]) / (n + 1)
        return terms

    def moved(self) -> _Course:
        """Return the equation with every mean off by its error."""
        return self._replace(pieces=tuple(piece._replace(mean=piece.mean + piece.doubt) for piece in self.pieces))


@dataclass(frozen=True, eq=False, repr=False)
class Solution(ByContent):
    """A solution on an interval of time, which a call evaluates anywhere in it.

    Attributes
    ----------
    equation : Equation, HillSystem or PeriodicSystem
    time : ndarray (steps + 1,)
        Where the steps begin and end.
    states : ndarray (steps + 1, N)
        There: A and A' of a scalar equation; q and then q' of a `HillSystem`; x of a `PeriodicSystem`, complex where
        the system is.
    error : float
        Estimate of the largest error of a state, as a fraction of the largest state until then: twice the difference
        from a solution with another order and other steps, whose coefficient is changed by its error, and rounding.
    """

    equation: Any
    time: Floats
    states: NDArray[Any]
    error: float
    _course: _Course = field(compare=False)
    _exact: tuple[Fraction, ...] = field(compare=False)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(SOLUTIONS)

    def __call__(self, time: Any, derivative: int = 0) -> Any:
        """Return the solution at times within the interval (array_like), or its first derivative.

        Of a scalar equation in the shape of ``time``, of a system with its n components in a last axis.
        """
        low, high = sorted((self.time[0], self.time[-1]))
        times = validate.array("time", time, least=low, largest=high)
        derivative = validate.integer("derivative", derivative, 0, 1)
        states = self._state(times.ravel(), 0 if self._second_order else derivative)
        if self._second_order:
            half = self.states.shape[1] // 2
            states = states[:, half * derivative : half * (derivative + 1)]
        if isinstance(self.equation, Equation):
            return shaped(states[:, 0], times.shape)
        return shaped(states, (*times.shape, states.shape[1]))

    def _state(self, times: Floats, derivative: int = 0) -> NDArray[Any]:
        """Return the states at times within the interval, or their derivative, (times, N)."""
        sign = 1.0 if self.time[-1] >= self.time[0] else -1.0
        steps = np.searchsorted(sign * self.time, sign * times, side="right") - 1
        steps = np.clip(steps, 0, len(self.time) - 2)
        states = np.empty((times.size, self._begins.shape[1]))
        for step in np.unique(steps):
            here = steps == step
            late = float(self._exact[step] - Fraction(float(self.time[step])))
            states[here] = _evaluate(self._series(step, sign), times[here] - self.time[step] - late, derivative)
        return complex_vector(states) if self._is_complex else states

    def _state_at(self, time: Fraction) -> Floats:
        """Return the state at an exact time within the interval, (N,), of a complex system its real form's."""
        sign = 1.0 if self.time[-1] >= self.time[0] else -1.0
        step = (
            bisect_right(self._exact, int(sign) * time, hi=len(self._exact) - 1, key=lambda start: int(sign) * start)
            - 1
        )
        offset = np.array([float(time - self._exact[step])])
        return np.asarray(_evaluate(self._series(step, sign), offset, 0)[0])

    def _series(self, step: int, sign: float) -> Floats:
        """Return the Taylor coefficients of a step, (order, N)."""
        start = self._exact[step]
        return self._course.taylor(start, *self._course.place(start, sign), self._begins[step], _ORDERS[0])

    @property
    def _is_complex(self) -> bool:
        return bool(np.iscomplexobj(self.states))

    @cached_property
    def _begins(self) -> Floats:
        """States at the beginnings of steps, of a complex system its real form's."""
        return real_vector(self.states) if self._is_complex else self.states

    @property
    def _second_order(self) -> bool:
        return not isinstance(self.equation, PeriodicSystem)

    def __repr__(self) -> str:
        """Return the equation that was solved."""
        span = f"from {self.time[0]:g} to {self.time[-1]:g}"
        return (
            f"<solution of {type(self.equation).__name__} {span}, error {self.error:.1g}, {len(self.time) - 1} steps>"
        )


def solve(equation: Any, initial: Any, span: Any) -> Any:
    """Return the solution of an equation or a system that has given initial values.

    Parameters
    ----------
    equation : Mathieu, Meissner, Hill or another Equation, HillSystem, PeriodicSystem, DelaySystem
        One, not a batch.
    initial : array_like
        (A, A') of a scalar equation, (q, q') of shape (2, n) of a `HillSystem`, x (N,) of a `PeriodicSystem`, which
        may be complex.
        Of a `DelaySystem` the history: a function of the time before the start, or the one vector that it is; where it
        is of second order, (history, q').
    span : float or (float, float)
        End time, from 0 on, or start and end, in the unit of the equation; without delays backwards, too.

    Returns
    -------
    Solution
        Of a `DelaySystem` a `floquetrod.floquet.delay_solve.DelaySolution`, which is used in the same way.

    Raises
    ------
    TypeError, ValueError
        For other equations, wrong shapes, intervals that take more than some 16,000 steps (fewer of a large system),
        and solutions that grow beyond 1e290.

    Notes
    -----
    Taylor series of order 26 with the steps of A. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99,
    doi:10.1080/10586458.2005.10128904; no step crosses a jump of the coefficient.  With delays collocation at Gauss's
    nodes, in steps no longer than the shortest delay.

    Examples
    --------
    >>> import floquetrod as fr
    >>> solution = solve(fr.Mathieu(alpha=0.5, beta=-0.25), initial=(1.0, 0.0), span=20.0)
    >>> round(solution(20.0), 9), solution.error < 1e-13
    (-32.205545641, True)
    """
    require(equation, (Equation, HillSystem, PeriodicSystem, DelaySystem), "solve", "friction: fr.friction.trajectory")
    start, stop = _span(span)
    if isinstance(equation, DelaySystem):
        from floquetrod.floquet.delay_solve import solve_delayed

        return solve_delayed(equation, initial, start, stop)
    state = _initial(equation, initial)
    is_complex = isinstance(equation, PeriodicSystem) and (equation.is_complex or bool(np.iscomplexobj(state)))
    course = first_order_course(equation.doubled if is_complex else equation)
    state = real_vector(state) if is_complex else state
    one, other = (
        list(_steps(of, start, stop, state, order, tolerance))
        for of, order, tolerance in zip((course, course.moved()), _ORDERS, _TOLERANCES, strict=True)
    )
    exact, states = tuple(time for time, _ in one), np.array([state for _, state in one])
    states = complex_vector(states) if is_complex else states
    solution = Solution(equation, np.array(exact, dtype=float), states, 0.0, course, exact)
    both = math.sqrt(2.0) if is_complex else 1.0  # errors of the real and of the imaginary part
    return replace(solution, error=2.0 * both * _disagreement(solution, other) + _ROUNDING)


def _span(span: Any) -> tuple[float, float]:
    """Return the interval as two different times."""
    if isinstance(span, str | bytes) or not validate.iterable(span):
        start, stop = 0.0, validate.finite("span", span)
    else:
        values = validate.array("span", span)
        if values.shape != (2,):
            raise ValueError(f"span must be a time or two times (from, to), got shape {values.shape}")
        start, stop = float(values[0]), float(values[1])
    if start == stop:
        raise ValueError(f"span must reach from one time to another, got {start:g} twice")
    return start, stop


def _initial(equation: Any, initial: Any) -> NDArray[Any]:
    """Return the state that initial values make."""
    take = validate.complex_array if isinstance(equation, PeriodicSystem) else validate.array
    values = take("initial", initial)
    if isinstance(equation, Equation):
        shape: tuple[int, ...] = (2,)
        example = "(A, A')"
    else:
        if equation.shape:
            raise ValueError(
                f"equation must be one system, got a batch of shape {equation.shape}; solve them one by one"
            )
        second = isinstance(equation, HillSystem)
        shape, example = ((2, equation.order), "(q, q')") if second else ((equation.order,), "x")
    if values.shape != shape:
        raise ValueError(f"initial must be {example} of shape {shape}, got shape {values.shape}")
    return values.ravel()


def first_order_course(equation: Any) -> _Course:
    """Return the equation in first order, in smooth pieces of its period."""
    if isinstance(equation, Equation):
        return _of_equation(equation)
    turned = _second_order(equation) if isinstance(equation, HillSystem) else _as_it_is
    doubt = equation.coefficient_error * equation.order * turned(np.eye(equation.order))
    pieces = []
    for piece in in_time(equation):
        slope = np.zeros_like(piece.mean) if piece.slope is None else piece.slope
        mean = turned(piece.mean, mean=True)
        off = doubt + _inverse_error(equation) * np.abs(mean)
        pieces.append(_Piece(piece.begin, mean, turned(slope), turned(piece.harmonics), off))
    return _Course(tuple(pieces), exact_period(equation))


def _as_it_is(matrix: NDArray[Any], *, mean: bool = False) -> NDArray[Any]:
    """Return a matrix of a system of first order."""
    return matrix


def _inverse_error(system: Any) -> float:
    """Return the part by which rounding may change what the inverse of the mass multiplies; 0 without a mass."""
    mass = getattr(system, "mass", None)
    return 0.0 if mass is None else EPS * float((np.abs(np.linalg.inv(mass)) @ np.abs(mass)).sum(axis=1).max())


def _of_equation(equation: Equation) -> _Course:
    multiple = equation.period_over_pi
    period = Fraction(equation.period) if multiple is None else multiple * _PI
    pieces, begin = [], Fraction(0)
    for piece in equation.pieces():
        mean = np.array([[0.0, 1.0], [float(piece.start), -2.0 * equation.damping]])
        slope = np.array([[0.0, 0.0], [float(piece.slope), 0.0]])
        harmonics = np.zeros((len(piece.harmonics), 2, 2), dtype=complex)
        harmonics[:, 1, 0] = piece.harmonics
        risen = (Fraction(piece.slope) - Fraction(float(piece.slope))) * piece.share * period
        off = abs(Fraction(piece.start) - Fraction(float(piece.start))) + abs(risen)
        doubt = np.array([[0.0, 0.0], [float(off), 0.0]])
        pieces.append(_Piece(begin * period, mean, slope, harmonics, doubt))
        begin += piece.share
    return _Course(tuple(pieces), period)


def _second_order(system: HillSystem) -> Callable[..., Any]:
    """Return the function from a matrix of K(t) in M q'' + (D + G) q' + K(t) q = 0 to its matrix for (q, q')."""
    n, inverse = system.order, np.linalg.inv(mass_matrix(system))
    rates = velocity_matrix(system)

    def state(matrix: NDArray[Any], *, mean: bool = False) -> NDArray[Any]:
        first_order = np.zeros((*matrix.shape[:-2], 2 * n, 2 * n), dtype=matrix.dtype)
        first_order[..., n:, :n] = -inverse @ matrix
        if mean:
            first_order[..., :n, n:], first_order[..., n:, n:] = np.eye(n), -inverse @ rates
        return first_order

    return state


def _steps(
    course: _Course, start: float, stop: float, state: Floats, order: int, tolerance: float
) -> Iterator[tuple[Fraction, Floats]]:
    """Yield times and states at the ends of steps, the start among them.

    Times are exact: doubles except for the ends of pieces, which far from 0 rounding would move by much of a step.
    """
    time, last, sign = Fraction(start), Fraction(stop), math.copysign(1.0, stop - start)
    yield time, state
    most = _most_steps(state.size, max(len(piece.harmonics) for piece in course.pieces))
    for _ in range(most):
        turn, place = course.place(time, sign)
        edge = course.edge(turn, place, sign)
        edge = min(edge, last) if sign > 0.0 else max(edge, last)
        series = course.taylor(time, turn, place, state, order)
        sizes = np.abs(series).max(axis=1)
        reach = min(
            (float(tolerance * sizes[0] / sizes[n])) ** (1.0 / n) if sizes[n] > 0.0 else math.inf
            for n in (order - 2, order - 1)
        )
        target = edge if reach >= abs(edge - time) else Fraction(float(time) + sign * reach)
        state = _evaluate(series, np.array([float(target - time)]), 0)[0]
        time = target
        if not np.abs(state).max() < _LARGEST:
            raise ValueError(
                f"the solution grows beyond {_LARGEST:g} before t = {float(time):.6g}; take a shorter span"
            )
        yield time, state
        if time == last:
            return
    raise ValueError(
        f"span takes more than {most:,} steps, got to t = {float(time):.6g} of {stop:g}; take a shorter one, or "
        "multipliers of fr.stability for what happens later"
    )


def _most_steps(size: int, harmonics: int) -> int:
    """Return how many steps of a state of some size are taken; each costs what it does in proportion (measured)."""
    return math.ceil(_MOST_STEPS / (1.0 + size / 9.0 + (size / 40.0) ** 2 * (1.0 + harmonics / 10.0)))


def _evaluate(series: Floats, offsets: Floats, derivative: int) -> Floats:
    """Return a Taylor series at offsets from its centre, or its derivative, (offsets, N)."""
    if derivative:
        series = series[1:] * np.arange(1, len(series))[:, None]
    values = np.zeros((offsets.size, series.shape[1]))
    for term in series[::-1]:
        values = values * offsets[:, None] + term
    return values


def _disagreement(solution: Solution, other: list[tuple[Fraction, Floats]]) -> float:
    """Return the largest difference from another solution, over the largest state until then."""
    largest, worst = 0.0, 0.0
    for time, state in other:
        mine = solution._state_at(time)
        largest = max(largest, float(np.abs(state).max()))
        worst = max(worst, float(np.abs(mine - state).max()) / largest if largest else 0.0)
    return worst
