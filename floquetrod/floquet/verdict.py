"""What every method returns, and the one place where the excess of a scalar equation becomes a verdict.

With c the damping, T the period and A = exp(-c tau) u, the undamped u has multipliers of product 1 and sum D_u.
Their excess X = (abs(D_u) - 2) / 4 decides: see `floquetrod.floquet.multiplier_pairs`.  Methods hand over X rather
than D_u because near a boundary X keeps digits that D_u has rounded away.  `classify` derives the status, damping
included, says "undecided" when the error covers both answers, and decides constant coefficients by their sign.

Every verdict, on an equation, a system or a rod, has the core `Verdict`: status, growth, exponents and multipliers,
error, cost, note, assumptions; on equations and systems it is a
`FloquetVerdict`, with the fields of one row in `Stability` and of several in `SystemStability`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np

from floquetrod._util.arrays import EPS
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.interchange import plain
from floquetrod._util.result_report import Report, Reported, number
from floquetrod.equations import DelayedMoments, DelaySystem, Equation, PeriodicSystem
from floquetrod.floquet import multiplier_pairs
from floquetrod.floquet.references import references
from floquetrod.floquet.registry import sources
from floquetrod.floquet.status import Status as Status
from floquetrod.floquet.status import status_between, status_of

if TYPE_CHECKING:
    from floquetrod.floquet.monodromy_matrix import MonodromyMatrix

_STATUS: dict[int, Status] = {1: "unstable", -1: "stable"}


class Interval(NamedTuple):
    """Where an equation lies between transition curves, counted from the static limit.

    ``kind`` is "stability" for the interval of bounded motion between a_m and b_(m+1), "tongue" for the resonance
    tongue between b_m and a_m; ``order`` is m.  Tongue 0 is static buckling, beyond a_0 (DLMF 28.2(v)).
    """

    kind: Literal["stability", "tongue"]
    order: int

    @classmethod
    def from_count(cls, below: int) -> Interval:
        """Return the interval with ``below`` transition curves under it (0: tongue 0, 1: stability interval 0, ...).

        Returns
        -------
        Interval
            Its kind and its number.
        """
        return cls("stability", (below - 1) // 2) if below % 2 else cls("tongue", below // 2)

    def __str__(self) -> str:
        """Return, say, "tongue 1"."""
        return f"{'stability interval' if self.kind == 'stability' else 'tongue'} {self.order}"


class Cost(NamedTuple):
    """Work done for a verdict: ``amount`` of ``unit`` (pivots, steps, ...)."""

    amount: int
    unit: str

    def __str__(self) -> str:
        """Return, say, "37 pivots"."""
        return f"{self.amount} {self.unit}"


class Answer(NoTruthValue):
    """An answer that is stable, unstable or undecided: ``status``, a field of some classes, a property of others."""

    ask: ClassVar[str] = ".stable (True, False, or None when undecided)"
    if TYPE_CHECKING:

        @property
        def status(self) -> Status:
            """Verdict."""

    @property
    def stable(self) -> bool | None:
        """True, False, or None when undecided."""
        return {"stable": True, "unstable": False}.get(self.status)


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(Answer):
    """The core of every verdict, on an equation, a rod or a system of equations.

    Attributes
    ----------
    status : {"stable", "unstable", "undecided"}
        Verdict.  "stable": every solution stays bounded (decays, if damped).
    growth_rate : float
        Rate of the fastest growing solution, per unit of time; 0 when stable, the best estimate when undecided.
    exponents : tuple of complex
        Floquet exponents per unit of time, defined up to multiples of 2 pi i / period; faster growing ones first.
    period : float
        Period of the coefficients, in the same unit of time.
    error : float
        Bound or estimate of the error; the class of the verdict names the quantity.
    cost : Cost
        Work done.
    note : str
        Remarks to read before relying on it: an approximation, a limit of the method, why it is undecided.
    assumptions : tuple of str
        Modelling assumptions of the verdict.
    """

    status: Status
    growth_rate: float
    exponents: tuple[complex, ...]
    period: float
    error: float
    cost: Cost = field(compare=False)
    note: str = ""
    assumptions: tuple[str, ...] = ()

    @property
    def decay_rate(self) -> float:
        """Rate, per unit of time, at which the slowest solution decays; 0 where one does not, or that is not known."""
        slowest = self._slowest
        return max(0.0, -slowest) if self.status == "stable" and slowest > -math.inf else 0.0

    @property
    def _slowest(self) -> float:
        """Largest real part of the known exponents; minus infinity where none is."""
        return max((exponent.real for exponent in self.exponents if exponent == exponent), default=-math.inf)

    @property
    def multipliers(self) -> tuple[complex, ...]:
        """Eigenvalues of the map over a period, in the order of the exponents; infinite beyond a double's range."""
        return tuple(_multiplier(exponent, self.period) for exponent in self.exponents)


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class FloquetVerdict(ByContent, Reported, Verdict):
    """Verdict on a scalar equation or a system of equations, in the unit of its time.

    It has all that every `Verdict` has.  A method that gave up has no exponents, and NaN for the growth rate.

    Attributes
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem classified; ``system`` is another name of it.
    method : str
        Name of the method.
    exponent_errors : tuple of float
        Error of each exponent: a bound or an estimate, the method says which.
    """

    equation: Any
    method: str
    if TYPE_CHECKING:

        @property
        def exponent_errors(self) -> tuple[float, ...]:
            """Error of each exponent."""

    @classmethod
    def declined(cls, equation: Any, method: str, cost: Cost, note: str) -> Self:
        """Return the undecided verdict of a method that gave up, for the reason in ``note``."""
        return cls(
            equation=equation,
            method=method,
            status="undecided",
            growth_rate=math.nan,
            exponents=(),
            period=float(equation.period),
            error=math.inf,
            cost=cost,
            note=note,
        )

    @property
    def system(self) -> Any:
        """The same as ``equation``."""
        return self.equation

    @property
    def unit(self) -> str:
        """The unit of time of growth rates and exponents, "tau" of most equations."""
        return self.equation.time if isinstance(self.equation, Equation) else "time"

    @cached_property
    def monodromy(self) -> MonodromyMatrix:
        """The matrix that maps (A, A'), (q, q') or x over one period from time 0, and its error; computed when asked.

        Apart from the method of the verdict, by `floquetrod.solve`.

        Examples
        --------
        >>> import floquetrod as fr
        >>> matrix, error = fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25)).monodromy
        >>> f"{matrix[0, 0] + matrix[1, 1]:.9f}", error < 1e-12
        ('-4.396667735', True)
        """
        from floquetrod.floquet.monodromy_matrix import monodromy_over_period

        return monodromy_over_period(self.equation)

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Uniform damping rate, per unit of time, at which motion no longer grows; 0 where none is needed.

        The rate c is added to the existing damping: c of a scalar equation, C + 2 c M in a `HillSystem`, as
        A - c I in a `PeriodicSystem`, where it is the growth rate itself.  Else it is searched, to ten digits: nothing
        grows at larger rates among those tried, which are two, four and eight times the growth rate, and those from the
        fastest frequency down in 12 steps by halves.  Damping can destabilise: of a stable system it need not be 0.

        Infinite where the mean stiffness alone is unstable, the delayed terms' added, even of a stable system:
        strong damping then only slows its motion away from rest down, while a weak rate may stabilise it. NaN
        of second moments with delays, where the search would take more than about a minute, and where growth is not
        known, or cannot be distinguished from none at some rate.

        Examples
        --------
        >>> import floquetrod as fr
        >>> found = fr.stability(fr.HillSystem([[1.0]], cosines=[[[0.3]]], period=3.141592653589793))
        >>> round(found.growth_rate, 6), round(found.damping_to_stabilise, 6)
        (0.074803, 0.074908)
        """
        if isinstance(self.equation, PeriodicSystem) or math.isnan(self.growth_rate):
            return self.growth_rate
        if isinstance(self.equation, DelayedMoments):
            return math.nan
        from floquetrod.floquet.multipliers.stabilising_damping import damping_of_delayed, damping_to_stabilise

        if isinstance(self.equation, DelaySystem):
            return damping_of_delayed(self.equation, self.growth_rate)
        system = self.equation.as_system() if isinstance(self.equation, Equation) else self.equation
        return damping_to_stabilise(system, self.growth_rate)

    @property
    def multiplier_errors(self) -> tuple[float, ...]:
        """Error of each multiplier, in the sense of ``exponent_errors``."""
        return tuple(
            abs(mu) * math.expm1(min(error * self.period, 700.0)) if error < math.inf else math.inf
            for mu, error in zip(self.multipliers, self.exponent_errors, strict=True)
        )

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(sources(self.equation, self.method))

    @property
    def _status_in_words(self) -> str:
        return self.status

    @property
    def _named(self) -> str:
        """Name of what grows, or of the interval, after a comma."""
        return ""

    @property
    def _known(self) -> str:
        """What was computed, and how well it is known."""
        return ""

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        verdict = self._status_in_words
        if self.status == "unstable":
            verdict += f": grows {rate_in_words(self.growth_rate)} per unit {self.unit}"
        elif self.status == "undecided" and self.exponents:
            verdict += f": growth {self.growth_rate:.3g} per unit {self.unit} cannot be distinguished from none"
        text = f"{verdict}{self._named}; {self._known}; {self.method}, {self.cost}"
        return f"<{text}; {self.note}>" if self.note else f"<{text}>"


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Stability(FloquetVerdict):
    """Verdict on one scalar equation, per unit of its time: tau, or z of Mathieu's equation in (a, q).

    It has all that every `FloquetVerdict` has.  There are two exponents, and ``error`` is a bound or estimate (the
    method says which) on the discriminant's error relative to max(1, abs(discriminant)).

    Attributes
    ----------
    discriminant : float
        Trace of the monodromy matrix (sum of the multipliers); infinite when beyond the range of a double.
    log_abs_discriminant : float
        Natural logarithm of its magnitude, finite where the discriminant itself is not.
    interval : Interval or None
        The stability interval or resonance tongue, of the equation with its damping removed; None where the method
        cannot tell.
    """

    discriminant: float = math.nan
    log_abs_discriminant: float = math.nan
    interval: Interval | None = None

    @property
    def exponent_errors(self) -> tuple[float, ...]:
        """Error of each exponent, from the error of the discriminant; near a boundary from its root."""
        if not self.exponents:
            return ()
        s = (self.exponents[0] + self.equation.damping) * self.period
        if s.real > 600.0:
            error = 0.5 * self.error
        else:
            y, above = (np.array([half**2]) for half in (np.sinh(0.5 * s), np.cosh(0.5 * s)))
            radius = 0.25 * self.error * np.maximum(1.0, np.minimum(np.abs(y), np.abs(above)))
            error = float(multiplier_pairs.log_errors(y, above, radius)[0])
        return (error / self.period + 4.0 * EPS * abs(self.exponents[0]),) * 2

    def report(self) -> Report:
        """Return the verdict in lines: growth and the time of tenfold growth, discriminant, method."""
        where = "" if self.interval is None else f": {self.interval}"
        lines = [("equation", repr(self.equation))]
        if formula := self.equation._formula:
            lines.append(("", formula))
        if self.growth_rate > 0.0:
            growth = f"{self.growth_rate:.6g} per unit {self.unit}, tenfold in {self._tenfold}"
            lines.append(("growth", growth))
        if self.decay_rate > 0.0:
            lines.append(("decay", f"{self.decay_rate:.6g} per unit {self.unit}, the slowest motion"))
        if self.exponents:
            both = " and ".join(f"{each.real + 0.0:.6g} {each.imag:+.6g}i" for each in self.exponents)
            lines.append(("exponent", f"{both} per unit {self.unit}, each +- {self.exponent_errors[0]:.1g}"))
        bound = 1.0 + math.exp(-2.0 * self.equation.damping * self.period)  # both multipliers real, one of them 1
        known = f"discriminant {self._size} +- {self.error:.1g} relative"
        lines.append(("trace", f"{known}; stable where its magnitude is below {bound:.6g}"))
        lines.append(("method", f"{self.method}, {self.cost}"))
        return Report(self.status.upper() + where, lines + ([("note", self.note)] if self.note else []))

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as numbers for JSON, units in the keys; None for infinite or unknown ones."""
        return {
            "method": self.method,
            "status": self.status,
            f"growth_rate_per_{self.unit}": number(self.growth_rate),
            f"decay_rate_per_{self.unit}": self.decay_rate,
            f"exponents_per_{self.unit}": plain(self.exponents),
            f"exponent_error_per_{self.unit}": number(max(self.exponent_errors, default=math.nan)),
            "discriminant": number(self.discriminant),
            "log_abs_discriminant": number(self.log_abs_discriminant),
            "discriminant_relative_error": number(self.error),
            "interval": None if self.interval is None else str(self.interval),
            "cost": str(self.cost),
            "note": self.note,
        }

    @property
    def _tenfold(self) -> str:
        """The time in which motion grows tenfold, with its unit."""
        return f"{math.log(10.0) / self.growth_rate:.4g} {self.unit}"

    @property
    def _size(self) -> str:
        """The discriminant, as a power of e where it is beyond a double's range."""
        if math.isinf(self.discriminant):
            return f"{'-' if self.discriminant < 0.0 else ''}exp({self.log_abs_discriminant:.10g})"
        return f"{self.discriminant:.10g}"

    @property
    def _named(self) -> str:
        return "" if self.interval is None else f", {self.interval}"

    @property
    def _known(self) -> str:
        return f"discriminant {self._size} +- {self.error:.1g} relative" if self.exponents else "nothing computed"


def rate_in_words(growth_rate: float) -> str:
    """Return how fast an unstable solution grows, in words that end before the unit of time."""
    return f"at {growth_rate:.6g}" if growth_rate > 0.0 else "slower than any exponential, at 0"


def classify(
    equation: Equation,
    method: str,
    *,
    sign: int,
    excess: float,
    exponent: int = 0,
    excess_error: float,
    cost: Cost,
    interval: Interval | None = None,
    undamped_status: Status | None = None,
    growth: tuple[float, float, float] | None = None,
    tested: tuple[Status, float] | None = None,
    note: str = "",
) -> Stability:
    """Return the `Stability` that follows from an excess X and its error: the one place where conclusions are drawn.

    Where the error leaves it undecided and the coefficient is constant, its sign decides: tongues have closed there.

    Parameters
    ----------
    sign : int
        Sign of the undamped discriminant, +1 or -1.
    excess, exponent : float, int
        X = excess * 2**exponent, so that neither huge nor tiny X leaves the range of a double.
    excess_error : float
        Error of X relative to max(1, abs(X)).
    undamped_status : Status, optional
        Verdict on the equation with its damping removed when known otherwise than from X (by counting, say).
    growth : (low, middle, high), optional
        Growth rate less damping and its bounds when known better than from X, where the undamped equation is unstable.
    tested : (status, growth rate), optional
        The outcome of a method's own test, which then decides in place of X.
    """
    period, damping = equation.period, equation.damping
    if excess > 0.0:
        excess, shift = math.frexp(excess)
        exponent += shift
    else:
        excess, exponent = multiplier_pairs.ldexp(excess, exponent), 0
    undamped_growth = multiplier_pairs.growth(excess, exponent) / period
    net = undamped_growth - damping
    status = undamped_status or _STATUS.get(multiplier_pairs.decided_far(excess, exponent, excess_error), "undecided")
    if damping > 0.0 and status != "stable":
        low, high = (edge / period - damping for edge in multiplier_pairs.growth_band(excess, exponent, excess_error))
        if growth is not None:
            low, net, high = growth
        status = status_between(low, high)
    if tested is not None:
        status, net = tested
    elif status == "undecided" and excess_error < math.inf:
        level = equation.level
        if level is not None:
            status, note = static_status(-level, 0.0, damping), ""
    net = max(0.0, net)
    discriminant, log_size = _discriminant(sign, excess, exponent, damping * period)
    if status == "undecided" and not note:
        note = "too close to a boundary for this method"
    return Stability(
        equation=equation,
        method=method,
        status=status,
        growth_rate=0.0 if status == "stable" else net,
        discriminant=discriminant,
        log_abs_discriminant=log_size,
        exponents=_exponents(sign, excess, undamped_growth, damping, period),
        error=4.0 * excess_error + 4.0 * EPS,
        interval=interval,
        period=period,
        cost=cost,
        note=note,
    )


def tolerated(rate: Any, tolerance: float) -> Any:
    """Return whether unstable motion of this growth rate, or rates, counts as stable: none with a tolerance of zero.

    Motion that drifts, or grows at a rate too small for a double, has the rate zero.
    """
    return (tolerance > 0.0) & (rate <= tolerance)


def static_status(stiffness: Any, error: float, damping: Any) -> Status:
    """Return the verdict on q'' + 2 c q' + k q = 0, k known up to its error: the sign of k decides.

    Where k is exactly zero motion drifts without damping, and comes to rest with any.
    """
    if stiffness == 0 and error == 0.0:
        return "stable" if damping > 0.0 else "unstable"
    return status_of(-stiffness, error)


def discriminant_excess_of(trace: float) -> tuple[int, float]:
    """Return the sign of an undamped discriminant and its excess (which loses digits near +-2; prefer factors)."""
    return (1 if trace >= 0.0 else -1), 0.25 * (abs(trace) - 2.0)


def _discriminant(sign: int, excess: float, exponent: int, decay: float) -> tuple[float, float]:
    """Return the damped discriminant and the logarithm of its magnitude."""
    if exponent > 900:
        log_size = 2.0 * math.log(2.0) + math.log(excess) + exponent * math.log(2.0) - decay
        return sign * _exp(log_size), log_size
    size = 2.0 + 4.0 * multiplier_pairs.ldexp(excess, exponent)
    log_size = math.log(abs(size)) - decay if size != 0.0 else -math.inf
    if math.isinf(size) or decay > 700.0:
        return sign * _exp(log_size), log_size
    return sign * size * math.exp(-decay), log_size


def _exponents(sign: int, excess: float, growth: float, damping: float, period: float) -> tuple[complex, complex]:
    if excess > 0.0:
        half_turn = math.pi / period if sign < 0 else 0.0
        return complex(growth - damping, half_turn), complex(-growth - damping, half_turn)
    angle = multiplier_pairs.turn(excess, sign) / period
    return complex(-damping, angle), complex(-damping, -angle)


def _multiplier(exponent: complex, period: float) -> complex:
    if exponent != exponent:
        return exponent
    size = _exp(exponent.real * period)
    angle = exponent.imag * period
    if abs(angle) > math.pi * (1.0 + 2.0 * EPS):  # a characteristic root, which has turned more than half
        angle = math.remainder(angle, 2.0 * math.pi)
    if abs(angle) >= math.pi * (1.0 - EPS):  # the half turn is exact, the sine of a rounded pi is not
        return complex(-size, 0.0)
    if angle == 0.0:
        return complex(size, 0.0)
    return complex(size * math.cos(angle), size * math.sin(angle))


def _exp(power: float) -> float:
    return math.exp(power) if power < 709.0 else math.inf
