"""Systems with delays, M q'' + (C + G) q' + K(t) q + sum_j D_j(t) q(t - tau_j) = 0, and their first-order form."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from floquetrod._util import validate
from floquetrod._util.calling import constructor_hints
from floquetrod._util.content import ByContent
from floquetrod.equations import matrices
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.matrices import Structure
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.pieces import mapped

Present = TypeVar("Present", HillSystem, PeriodicSystem)

MOST_DELAYS = 64
"""Most delayed terms of a system (a choice)."""

_LONGEST = 1e100
_ENTRY_BY_ENTRY = 4  # equations up to which each entry of a coefficient is moved by itself (a choice)
_SERIES = "(delay, matrix), (delay, matrix, cosines) or (delay, matrix, cosines, sines)"
_PIECES = "(delay, pieces), pieces a sequence of (duration, matrix)"
_FUNCTIONS = "(delay, function) or (delay, matrix)"
_TABLES = "(delay, table of matrices) or (delay, matrix)"


class DelayedTerm(NamedTuple):
    """A delayed term: D(t) q(t - delay), or B(t) x(t - delay).

    Attributes
    ----------
    delay : float or Fraction
        tau, exactly.
    coefficient : PeriodicSystem
        The periodic matrix D or B: ``coefficient.coefficient(t)``.
    """

    delay: float | Fraction
    coefficient: PeriodicSystem


@constructor_hints(frequency="period is 2 pi / frequency", delays="each delay goes with its matrix into delayed")
@dataclass(frozen=True, eq=False, repr=False, init=False)
class DelaySystem(ByContent):
    """The system M q'' + (C + G) q' + K(t) q + sum_j D_j(t) q(t - tau_j) = 0 of n equations, K and D_j periodic.

    `from_pieces` takes coefficients that jump, `from_function` and `from_samples` take them as functions and tables,
    `first_order` and its kin take the form x' = A(t) x + sum_j B_j(t) x(t - tau_j).  Delays
    may be any positive numbers, shorter or longer than the period, commensurate with it or not; terms without a delay
    belong to the stiffness.

    Parameters
    ----------
    stiffness : array_like (n, n)
        Mean of K.
    cosines : sequence of array_like (n, n)
        Of K, from the first harmonic on, as of a `HillSystem`; none by default.
    sines : sequence of array_like (n, n)
        Of K, likewise.
    mass : array_like (n, n), optional
        M, as of a `HillSystem`.
    damping : array_like (n, n), optional
        C, likewise.
    gyroscopic : array_like (n, n), optional
        G, likewise.
    period : float
        Period of K and of all D_j; any where nothing varies.
    delayed : sequence of (delay, D0), (delay, D0, cosines) or (delay, D0, cosines, sines)
        Of each term its delay, a float or a `Fraction` in the unit of the period, taken exactly, and D_j as mean and
        harmonics.
    coefficient_error : float
        Bound or estimate of the error of K(t) and of each D_j(t), entry by entry.

    Attributes
    ----------
    present : HillSystem or PeriodicSystem
        The system without its delayed terms.
    delayed : tuple of DelayedTerm
        The delayed terms.

    Raises
    ------
    TypeError, ValueError
        For arguments that a `HillSystem` refuses, for delays of zero or less, for terms of another order or period, and
        for batches.

    Examples
    --------
    >>> import floquetrod as fr
    >>> system = DelaySystem([[1.2]], [[[0.5]]], damping=[[0.05]], delayed=[(2.0 * math.pi, [[-0.2]])])
    >>> found = fr.stability(system)
    >>> found.status, f"{found.multipliers[0]:.9f}"
    ('stable', '0.952316474-0.006558236j')
    """

    MEANING: ClassVar[str] = ""

    present: HillSystem | PeriodicSystem
    delayed: tuple[DelayedTerm, ...]

    def __init__(
        self,
        stiffness: Any,
        cosines: Any = (),
        sines: Any = (),
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
        period: Any = 2.0 * math.pi,
        delayed: Any = (),
        coefficient_error: float = 0.0,
    ) -> None:
        """Check and copy the parameters."""
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic}
        present = HillSystem(stiffness, cosines, sines, **others, period=period, coefficient_error=coefficient_error)
        self._take(present, _by_series(delayed, present))

    @classmethod
    def from_pieces(
        cls,
        pieces: Any,
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
        delayed: Any = (),
        coefficient_error: float = 0.0,
    ) -> DelaySystem:
        """Return the system whose K(t) and D_j(t) are given piece by piece of the period, and may jump.

        Parameters
        ----------
        pieces : sequence of (duration, K)
            Of K as `HillSystem.from_pieces` takes them; the exact sum of the durations is the period.
        mass : array_like (n, n), optional
            M, as of the system.
        damping : array_like (n, n), optional
            C, as of the system.
        gyroscopic : array_like (n, n), optional
            G, as of the system.
        delayed : sequence of (delay, pieces)
            Of each term its delay and the pieces of D_j, whose durations add up to the same period.
        coefficient_error : float
            As of the system.

        Returns
        -------
        DelaySystem
            Of n equations of second order.

        Raises
        ------
        TypeError, ValueError
            For durations not above 0 or that do not add up to one period, for delays not above 0,
            and for matrices of other shapes.

        Examples
        --------
        A delayed force that acts in half of the period only:

        >>> cut = [(0.5, [[0.3]]), (0.5, [[0.0]])]
        >>> system = DelaySystem.from_pieces([(0.5, [[1.3]]), (0.5, [[1.0]])], delayed=[(1.0, cut)])
        >>> system.period, system.delays
        (1.0, (1.0,))
        """
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic}
        present = HillSystem.from_pieces(pieces, **others, coefficient_error=coefficient_error)
        return cls._made(present, _by_pieces(delayed, present))

    @classmethod
    def from_function(
        cls,
        function: Callable[[float], Any],
        period: float,
        jumps: Any = (),
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
        delayed: Any = (),
    ) -> DelaySystem:
        """Return the system whose K(t) and D_j(t) are functions, expanded as by `PeriodicSystem.from_function`.

        Its ``coefficient_error`` is the largest error of these expansions, estimated; verdicts include it.

        Parameters
        ----------
        function : callable (t) -> array_like (n, n)
            K, periodic and smooth except for its jumps.
        period : float
            Period of K and of all D_j.
        jumps : sequence of float
            Instants from 0 up to the period at which K or a D_j jumps, or has a kink; none by default.
        mass : array_like (n, n), optional
            M, as of the system.
        damping : array_like (n, n), optional
            C, as of the system.
        gyroscopic : array_like (n, n), optional
            G, as of the system.
        delayed : sequence of (delay, function) or (delay, matrix)
            Of each term its delay and D_j, a function of t as K, or a constant matrix.

        Returns
        -------
        DelaySystem
            Of n equations of second order.

        Raises
        ------
        TypeError, ValueError
            Where K or a D_j a period later differs, and where it is not smooth between the jumps; for delays that
            are not positive, and for matrices whose shapes do not fit.

        Examples
        --------
        >>> def cut(t):
        ...     return [[0.2 * math.exp(math.cos(t))]]
        >>> system = DelaySystem.from_function(lambda t: [[1.2 + cut(t)[0][0]]], 2.0 * math.pi, delayed=[(9.0, cut)])
        >>> system.delays, system.coefficient_error < 1e-13
        ((9.0,), True)
        """
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic}
        present = HillSystem.from_function(function, period, jumps, **others)
        return cls._made(*_by_functions(delayed, present, jumps))

    @classmethod
    def from_samples(
        cls,
        times: Any,
        values: Any,
        period: float,
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
        delayed: Any = (),
    ) -> DelaySystem:
        """Return the system whose K(t) and D_j(t) go through tables of matrices, as by `PeriodicSystem.from_samples`.

        Its ``coefficient_error`` is the largest error of these series, estimated; verdicts include it.

        Parameters
        ----------
        times : array_like (N,)
            Instants of all tables within one period, increasing, at least 5; of phases give the period 2 pi.
        values : array_like (N, n, n)
            K there.
        period : float
            Period of K and of all D_j.
        mass : array_like (n, n), optional
            M, as of the system.
        damping : array_like (n, n), optional
            C, as of the system.
        gyroscopic : array_like (n, n), optional
            G, as of the system.
        delayed : sequence of (delay, table) or (delay, matrix)
            Of each term its delay and D_j, a table (N, n, n) at the same instants, or a constant matrix.

        Returns
        -------
        DelaySystem
            Of n equations of second order.

        Raises
        ------
        TypeError, ValueError
            For instants that do not increase or lie further apart than a period, for delays not above 0,
            and for shapes that do not fit.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        >>> stiffness = (1.2 + 0.5 * np.cos(t))[:, None, None]
        >>> DelaySystem.from_samples(t, stiffness, 2.0 * np.pi, delayed=[(9.0, [[0.2]])]).coefficient_error < 1e-14
        True
        """
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic}
        present = HillSystem.from_samples(times, values, period, **others)
        return cls._made(*_by_samples(delayed, present, times))

    @classmethod
    def first_order(
        cls,
        mean: Any,
        cosines: Any = (),
        sines: Any = (),
        *,
        period: Any = 2.0 * math.pi,
        delayed: Any = (),
        coefficient_error: float = 0.0,
    ) -> DelaySystem:
        """Return the system x' = A(t) x + sum_j B_j(t) x(t - tau_j) of N equations.

        Parameters
        ----------
        mean : array_like (N, N)
            Mean of A.
        cosines : sequence of array_like (N, N)
            Of A, from the first harmonic on; none by default.
        sines : sequence of array_like (N, N)
            Of A, likewise.
        period : float
            Period of A and of all B_j; any where nothing varies.
        delayed : sequence of (delay, B0), (delay, B0, cosines) or (delay, B0, cosines, sines)
            The delayed terms.
        coefficient_error : float
            Of A(t) and of each B_j(t).

        Returns
        -------
        DelaySystem
            Of N equations of first order.

        Raises
        ------
        TypeError, ValueError
            For a period or delays not above 0, and for matrices of other shapes.

        Examples
        --------
        Hayes' equation x' = a x + b x(t - 1), on the stable side of its boundary:

        >>> import floquetrod as fr
        >>> fr.stability(DelaySystem.first_order([[0.5]], delayed=[(1.0, [[-1.0]])])).status
        'stable'
        """
        present = PeriodicSystem(mean, cosines, sines, period=period, coefficient_error=coefficient_error)
        return cls._made(present, _by_series(delayed, present))

    @classmethod
    def first_order_from_pieces(cls, pieces: Any, *, delayed: Any = (), coefficient_error: float = 0.0) -> DelaySystem:
        """Return the system x' = A(t) x + sum_j B_j(t) x(t - tau_j) whose matrices are given piece by piece.

        Parameters
        ----------
        pieces : sequence of (duration, A)
            As `PeriodicSystem.from_pieces` takes them.
        delayed : sequence of (delay, pieces)
            Of each term its delay and the pieces of B_j, whose durations add up to the same period.
        coefficient_error : float
            Of A(t) and of each B_j(t).

        Returns
        -------
        DelaySystem
            Of N equations of first order.

        Raises
        ------
        TypeError, ValueError
            For durations not above 0 or that do not add up to one period, for delays not above 0,
            and for matrices of other shapes.

        Examples
        --------
        >>> DelaySystem.first_order_from_pieces([(1.0, [[-1.0]]), (0.5, [[0.2]])], delayed=[]).period
        1.5
        """
        present = PeriodicSystem.from_pieces(pieces, coefficient_error=coefficient_error)
        return cls._made(present, _by_pieces(delayed, present))

    @classmethod
    def first_order_from_function(
        cls, function: Callable[[float], Any], period: float, jumps: Any = (), *, delayed: Any = ()
    ) -> DelaySystem:
        """Return the system x' = A(t) x + sum_j B_j(t) x(t - tau_j) whose matrices are functions of time.

        Parameters
        ----------
        function : callable (t) -> array_like (N, N)
            A, as of `PeriodicSystem.from_function`.
        period : float
            Period of A and of all B_j.
        jumps : sequence of float
            Instants from 0 up to the period at which A or a B_j jumps, or has a kink; none by default.
        delayed : sequence of (delay, function) or (delay, matrix)
            Of each term its delay and B_j, a function of t as A, or a constant matrix.

        Returns
        -------
        DelaySystem
            Of N equations of first order.

        Raises
        ------
        TypeError, ValueError
            Where A or a B_j a period later differs, and where it is not smooth between the jumps; for delays that
            are not positive, and for matrices whose shapes do not fit.

        Examples
        --------
        >>> system = DelaySystem.first_order_from_function(
        ...     lambda t: [[-1.0 / (1.5 + math.cos(t))]], 2.0 * math.pi, delayed=[(20.0, [[0.3]])]
        ... )
        >>> system.is_second_order, system.coefficient_error < 1e-13
        (False, True)
        """
        return cls._made(*_by_functions(delayed, PeriodicSystem.from_function(function, period, jumps), jumps))

    @classmethod
    def first_order_from_samples(cls, times: Any, values: Any, period: float, *, delayed: Any = ()) -> DelaySystem:
        """Return the system x' = A(t) x + sum_j B_j(t) x(t - tau_j) whose matrices go through tables.

        Parameters
        ----------
        times : array_like (N,)
            Instants of all tables, as of `PeriodicSystem.from_samples`.
        values : array_like (N, n, n)
            A there.
        period : float
            Period of A and of all B_j.
        delayed : sequence of (delay, table) or (delay, matrix)
            Of each term its delay and B_j, a table (N, n, n) at the same instants, or a constant matrix.

        Returns
        -------
        DelaySystem
            Of N equations of first order.

        Raises
        ------
        TypeError, ValueError
            For instants that do not increase or lie further apart than a period, for delays not above 0,
            and for shapes that do not fit.

        Examples
        --------
        >>> t = [0.0, 0.2, 0.4, 0.6, 0.8]
        >>> rates = [[[math.cos(2.0 * math.pi * s) - 1.0]] for s in t]
        >>> system = DelaySystem.first_order_from_samples(t, rates, 1.0, delayed=[(7.5, [[0.5]])])
        >>> [round(float(wave[0, 0]), 12) for wave in system.present.cosines]
        [1.0, 0.0]
        """
        return cls._made(*_by_samples(delayed, PeriodicSystem.from_samples(times, values, period), times))

    @classmethod
    def _made(cls, present: HillSystem | PeriodicSystem, delayed: tuple[DelayedTerm, ...]) -> DelaySystem:
        system = object.__new__(cls)
        system._take(present, delayed)
        return system

    def _take(self, present: HillSystem | PeriodicSystem, delayed: tuple[DelayedTerm, ...]) -> None:
        """Store the system without delay and the delayed terms, checked to be single systems."""
        for name, coefficient in (
            ("coefficients (stiffness, mean or pieces) and period", present),
            *((f"delayed[{j}]", t.coefficient) for j, t in enumerate(delayed)),
        ):
            if coefficient.shape:
                raise ValueError(f"{name} must be of a single system, got a batch of shape {coefficient.shape}")
            if getattr(coefficient, "is_complex", False):
                raise ValueError(
                    f"{name} must be real in a system with delays, got complex matrices; give those of the real parts "
                    "and of the imaginary parts of x, [[P, -Q], [Q, P]] for P + i Q"
                )
        vars(self).update(present=present, delayed=delayed)

    @property
    def order(self) -> int:
        """Number of equations."""
        return self.present.order

    @property
    def shape(self) -> tuple[int, ...]:
        """Leading shape of a batch, always empty, as one system is described."""
        return ()

    @property
    def period(self) -> float:
        """Period of the coefficients."""
        return float(self.present.period)

    @property
    def is_second_order(self) -> bool:
        """Whether the equations are of second order."""
        return isinstance(self.present, HillSystem)

    @property
    def delays(self) -> tuple[float | Fraction, ...]:
        """Every delay, in the order of the terms."""
        return tuple(term.delay for term in self.delayed)

    @property
    def longest_delay(self) -> float:
        """The longest delay, 0 without any."""
        return max(map(float, self.delays), default=0.0)

    @property
    def coefficient_error(self) -> float:
        """Error of K(t) and of each D_j(t), or of A(t) and each B_j(t), entry by entry."""
        return self.present.coefficient_error

    @property
    def is_constant(self) -> bool:
        """Whether nothing depends on time."""
        return self.present.is_constant and all(term.coefficient.is_constant for term in self.delayed)

    @property
    def structure(self) -> Structure:
        """The word "general", since delayed terms leave multipliers unpaired."""
        return "general"

    @property
    def pieces(self) -> tuple[Any, ...]:
        """Pieces of the coefficients without delay, as of a `HillSystem` or `PeriodicSystem`."""
        return self.present.pieces

    @property
    def harmonics(self) -> Any:
        """Harmonics of the coefficients without delay, likewise."""
        return self.present.harmonics

    def damped(self, rate: float) -> DelaySystem:
        """Return the system with uniform damping added: C + 2 rate M, or A - rate I; per unit of time.

        Returns
        -------
        DelaySystem
            With the same period and delays.

        Raises
        ------
        TypeError, ValueError
            For a rate that is negative or too large for doubles.
        """
        present = self.present
        unit = matrices.mass_matrix(present) if isinstance(present, HillSystem) else np.eye(self.order)
        largest = 0.25 * matrices.LARGEST_ENTRY / max(1.0, float(np.abs(unit).max()))
        rate = validate.within("rate", rate, 0.0, largest)
        if isinstance(present, HillSystem):
            damping = np.zeros_like(unit) if present.damping is None else present.damping
            return self._made(replace(present, damping=damping + 2.0 * rate * unit), self.delayed)
        shift, error = rate * unit, present.coefficient_error
        lowered = mapped(PeriodicSystem, present, lambda m: m - shift, coefficient_error=error)
        return self._made(lowered, self.delayed)

    @property
    def variation(self) -> str:
        """How the coefficients vary, and how many delays there are, in words."""
        count = len(self.delayed)
        delays = f"{count} delayed term{'' if count == 1 else 's'}" if count else "no delayed term"
        return f"{self.present.variation}, {delays}"

    def __repr__(self) -> str:
        """Return the system without delay and the delayed terms."""
        terms = ", ".join(f"{float(term.delay):.17g}: {term.coefficient!r}" for term in self.delayed)
        return f"<DelaySystem of {self.present!r}, delayed by {{{terms}}}>"


def moved(system: DelaySystem) -> Iterator[DelaySystem]:
    """Yield the system with one entry of one coefficient larger by the coefficient error, for each entry.

    The sum of the changes of a multiplier is its error by constant errors of the coefficients, to first order.
    Of more than `_ENTRY_BY_ENTRY` equations the n entries of a cyclic diagonal are moved at once, by sqrt(n) times the
    error: their changes may cancel, and sum_i |x_i| is at most sqrt(n) times the root of sum_i |x_i|^2.
    """
    n, size = system.order, system.coefficient_error
    rows, columns = np.divmod(np.arange(n * n), n)
    groups = np.arange(n * n)
    if n > _ENTRY_BY_ENTRY:
        groups, size = (columns - rows) % n, math.sqrt(n) * size
    exact = _shifted(system.present, np.zeros((n, n)))
    for group in np.unique(groups):
        shift = np.where(groups == group, size, 0.0).reshape(n, n)
        yield DelaySystem._made(_shifted(system.present, shift), system.delayed)
        for j, (delay, coefficient) in enumerate(system.delayed):
            other = DelayedTerm(delay, mapped(PeriodicSystem, coefficient, partial(np.add, shift)))
            yield DelaySystem._made(exact, (*system.delayed[:j], other, *system.delayed[j + 1 :]))


def _shifted(present: HillSystem | PeriodicSystem, shift: Any) -> HillSystem | PeriodicSystem:
    """Return a system without delays with a constant matrix added to its K or A, and no coefficient error."""
    if isinstance(present, HillSystem):
        others = {name: getattr(present, name) for name in ("mass", "damping", "gyroscopic")}
        return mapped(HillSystem, present, partial(np.add, shift), **others)
    return mapped(PeriodicSystem, present, partial(np.add, shift))


def with_terms(system: DelaySystem, present: HillSystem | PeriodicSystem, terms: Sequence[DelayedTerm]) -> DelaySystem:
    """Return a system with another one in place of its undelayed part, and with more delayed terms."""
    return DelaySystem._made(present, (*system.delayed, *terms))


def _by_series(delayed: Any, present: HillSystem | PeriodicSystem) -> tuple[DelayedTerm, ...]:
    """Return the delayed terms of a system whose coefficients are Fourier series."""
    terms = []
    for name, given in terms_of(delayed, (2, 3, 4), _SERIES):
        delay, mean, *series = given
        matrix = matrices.square(f"{name}[1]", mean, present.order, present.MEAN)
        parts = [
            matrices.by_harmonic(f"{name}[{k}]", values, present.order, present.MEAN)
            for k, values in enumerate(series, 2)
        ]
        coefficient = PeriodicSystem(matrix, *parts, period=present.period)
        terms.append(DelayedTerm(delay_of(f"{name}[0]", delay), coefficient))
    return tuple(terms)


def _by_pieces(delayed: Any, present: HillSystem | PeriodicSystem) -> tuple[DelayedTerm, ...]:
    """Return the delayed terms of a system whose coefficients are in pieces."""
    terms = []
    for name, (delay, pieces) in terms_of(delayed, (2,), _PIECES):
        try:
            coefficient = PeriodicSystem.from_pieces(pieces)
        except (TypeError, ValueError) as error:
            raise type(error)(f"{name}[1]: {error}") from None
        if coefficient.order != present.order:
            raise ValueError(f"{name}[1] must be {present.order} x {present.order} as the other pieces are")
        if np.shape(coefficient.period) == () and coefficient.period != present.period:
            raise ValueError(f"{name}[1] must add up to the period {present.period!r}, got {coefficient.period!r}")
        terms.append(DelayedTerm(delay_of(f"{name}[0]", delay), coefficient))
    return tuple(terms)


def _by_functions(delayed: Any, present: Present, jumps: Any) -> tuple[Present, tuple[DelayedTerm, ...]]:
    """Return a system and its delayed terms whose coefficients are functions, with the largest of their errors."""

    def expanded(function: Any) -> PeriodicSystem | None:
        return PeriodicSystem.from_function(function, present.period, jumps) if callable(function) else None

    return _with_errors(delayed, present, _FUNCTIONS, expanded)


def _by_samples(delayed: Any, present: Present, times: Any) -> tuple[Present, tuple[DelayedTerm, ...]]:
    """Return the same of coefficients in tables, (N, n, n) each."""

    def interpolated(values: Any) -> PeriodicSystem | None:
        with contextlib.suppress(ValueError):  # of rows of different lengths, which are refused below
            if validate.dimensions("values", values) == 2:
                return None
        return PeriodicSystem.from_samples(times, values, present.period)

    return _with_errors(delayed, present, _TABLES, interpolated)


def _with_errors(
    delayed: Any, present: Present, example: str, varying: Callable[[Any], PeriodicSystem | None]
) -> tuple[Present, tuple[DelayedTerm, ...]]:
    """Return a system and its delayed terms; ``varying`` makes a coefficient, or None of a constant matrix."""
    terms, error = [], present.coefficient_error
    for name, (delay, value) in terms_of(delayed, (2,), example):
        try:
            coefficient = varying(value)
        except (TypeError, ValueError) as refusal:
            raise type(refusal)(f"{name}[1]: {refusal}") from None
        if coefficient is None:
            matrix = matrices.square(f"{name}[1]", value, present.order, present.MEAN)
            coefficient = PeriodicSystem(matrix, period=present.period)
        if coefficient.order != present.order:
            raise ValueError(f"{name}[1] must be {present.order} x {present.order} as {present.MEAN} is")
        error = max(error, coefficient.coefficient_error)
        terms.append(DelayedTerm(delay_of(f"{name}[0]", delay), replace(coefficient, coefficient_error=0.0)))
    return replace(present, coefficient_error=error), tuple(terms)


def terms_of(delayed: Any, lengths: tuple[int, ...], example: str, name: str = "delayed") -> list[tuple[str, Any]]:
    """Return delayed terms with their names, each of one of the lengths."""
    if isinstance(delayed, str | bytes) or not validate.iterable(delayed):
        raise TypeError(f"{name} must be a sequence of {example}, got {validate.short(delayed)}")
    terms = []
    for j, given in enumerate(validate.listed(name, delayed, MOST_DELAYS, "terms")):
        if not isinstance(given, tuple | list) or len(given) not in lengths:
            raise TypeError(f"{name} must be a sequence of {example}, got {validate.short(given)} as {name}[{j}]")
        terms.append((f"{name}[{j}]", given))
    return terms


def delay_of(
    name: str, value: Any, hint: str = "terms without a delay belong to the stiffness, or to the matrix A"
) -> float | Fraction:
    """Return a delay, exactly: a double, or a Fraction where it is none."""
    number = validate.within(
        name, float(value) if isinstance(value, Fraction) else value, 1.0 / _LONGEST, _LONGEST, hint
    )
    return value if isinstance(value, Fraction) and value != number else number
