"""The one result every method returns, and the one place where a discriminant becomes a verdict.

With c the damping, T the period and A = exp(-c tau) u, the undamped u has multipliers of product 1 and sum D_u.
The *excess* X = (abs(D_u) - 2) / 4 is what decides: X = sinh(growth T / 2)^2 where u grows, -sin(rotation / 2)^2 where
it is bounded.  Methods hand over X rather than D_u because near a boundary X keeps digits that D_u has rounded away.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

from floquetrod._util.content import NoTruthValue
from floquetrod._util.report import Report, Reported, number
from floquetrod.equations import Equation
from floquetrod.floquet.references import references
from floquetrod.floquet.status import Status as Status

_EPS = sys.float_info.epsilon


class Interval(NamedTuple):
    """Where an equation lies between transition curves, counted from the static limit.

    ``kind`` is "stability" for the interval of bounded motion between a_m and b_(m+1), "tongue" for the resonance
    tongue between b_m and a_m; ``order`` is m.  Tongue 0 is static buckling, beyond a_0 (DLMF 28.2(v)).
    """

    kind: Literal["stability", "tongue"]
    order: int

    @classmethod
    def from_count(cls, below: int) -> Interval:
        """Return the interval with ``below`` transition curves under it (0: tongue 0, 1: stability interval 0, ...)."""
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
        Bound or estimate of the error, of what and in which sense is said where the verdict is defined.
    cost : Cost
        Work done.
    note : str
        What a reader must know before relying on it: an approximation, a limit of the method, why it is undecided.
    assumptions : tuple of str
        Modelling assumptions that the verdict rests on.
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
        slowest = max((exponent.real for exponent in self.exponents), default=0.0)
        return max(0.0, -slowest) if self.status == "stable" else 0.0

    @property
    def multipliers(self) -> tuple[complex, ...]:
        """Eigenvalues of the map over a period, in the order of the exponents; infinite beyond a double's range."""
        return tuple(_multiplier(exponent, self.period) for exponent in self.exponents)


@dataclass(frozen=True, kw_only=True, repr=False)
class Stability(Reported, Verdict):
    """Verdict on one scalar equation, per unit tau.

    Attributes
    ----------
    equation : Equation
        The equation classified.
    method : str
        Name of the method.
    discriminant : float
        Trace of the monodromy matrix (sum of the multipliers); infinite when beyond the range of a double.
    log_abs_discriminant : float
        Natural logarithm of its magnitude, finite where the discriminant itself is not.
    interval : Interval or None
        The stability interval or resonance tongue, of the equation freed of its damping; None where the method cannot
        tell.
    status, growth_rate, exponents, multipliers, period, error, cost, note, assumptions
        As in every `Verdict`; there are two exponents, and ``error`` is a bound or estimate (the method says which) on
        the discriminant's error relative to max(1, abs(discriminant)).
    """

    equation: Equation
    method: str
    discriminant: float
    log_abs_discriminant: float
    interval: Interval | None

    @property
    def references(self) -> tuple[str, ...]:
        """What to cite, in plain text with DOI, floquetrod first, then the sources of what was used."""
        return references(("equation", self.method))

    def report(self) -> Report:
        """Return the verdict in lines: growth, discriminant, method."""
        where = "" if self.interval is None else f": {self.interval}"
        lines = [("equation", repr(self.equation))]
        if self.growth_rate > 0.0:
            lines.append(("growth", f"{self.growth_rate:.6g} per unit tau"))
        lines.append(("trace", f"discriminant {self._size} +- {self.error:.1g} relative"))
        lines.append(("method", f"{self.method}, {self.cost}"))
        return Report(self.status.upper() + where, lines + ([("note", self.note)] if self.note else []))

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as numbers for JSON, units in the keys; None for what is infinite or not known."""
        return {
            "method": self.method,
            "status": self.status,
            "growth_rate_per_tau": number(self.growth_rate),
            "discriminant": number(self.discriminant),
            "log_abs_discriminant": number(self.log_abs_discriminant),
            "discriminant_relative_error": number(self.error),
            "interval": None if self.interval is None else str(self.interval),
            "cost": str(self.cost),
            "note": self.note,
        }

    @property
    def _size(self) -> str:
        """The discriminant, as a power of e where it is beyond a double's range."""
        if math.isinf(self.discriminant):
            return f"{'-' if self.discriminant < 0.0 else ''}exp({self.log_abs_discriminant:.10g})"
        return f"{self.discriminant:.10g}"

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        verdict: str = self.status
        if self.status == "unstable":
            verdict += f": grows {pace(self.growth_rate)} per unit tau"
        elif self.status == "undecided":
            verdict += f": growth {self.growth_rate:.3g} per unit tau cannot be distinguished from none"
        if self.interval is not None:
            verdict += f", {self.interval}"
        text = f"{verdict}; discriminant {self._size} +- {self.error:.1g} relative; {self.method}, {self.cost}"
        return f"<{text}; {self.note}>" if self.note else f"<{text}>"


def pace(growth_rate: float) -> str:
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
        Verdict on the equation freed of its damping when known otherwise than from X (by counting, say).
    growth : (low, middle, high), optional
        Growth rate less damping and its bounds when known better than from X, where the undamped equation is unstable.
    tested : (status, growth rate), optional
        What a method's own test says, where its verdict is not meant to be that of X.
    """
    period, damping = equation.period, equation.damping
    if excess > 0.0:
        excess, shift = math.frexp(excess)
        exponent += shift
    else:
        excess, exponent = _ldexp(excess, exponent), 0
    undamped_growth = _growth(excess, exponent, period)
    net = undamped_growth - damping
    status = undamped_status or _decide(excess, exponent, excess_error)
    if damping > 0.0 and status != "stable":
        low, high = (edge - damping for edge in _growth_band(excess, exponent, excess_error, period))
        if growth is not None:
            low, net, high = growth
        status = "unstable" if low > 0.0 else "stable" if high < 0.0 else "undecided"
    if tested is not None:
        status, net = tested
    elif status == "undecided" and excess_error < math.inf:
        decided = _without_variation(equation)
        status, note = (decided, "") if decided else (status, note)
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
        error=4.0 * excess_error + 4.0 * _EPS,
        interval=interval,
        period=period,
        cost=cost,
        note=note,
    )


def declined(equation: Equation, method: str, cost: Cost, note: str) -> Stability:
    """Return the undecided `Stability` of a method that gave up, for the reason in ``note``."""
    return classify(equation, method, sign=1, excess=0.0, excess_error=math.inf, cost=cost, note=note)


def tolerated(rate: Any, tolerance: float) -> Any:
    """Return whether unstable motion of this growth rate, or rates, counts as stable: none with a tolerance of zero.

    Motion that drifts, or grows at a rate too small for a double, has the rate zero.
    """
    return (tolerance > 0.0) & (rate <= tolerance)


def _without_variation(equation: Equation) -> Status | None:
    """Return the verdict on a constant coefficient: its sign decides.  None where the coefficient varies."""
    level = equation.level
    if level is None:
        return None
    bounded = level < 0 or (level == 0 and equation.damping > 0.0)  # at zero, with damping: 1 and exp(-2 c tau)
    return "stable" if bounded else "unstable"


def _decide(excess: float, exponent: int, excess_error: float) -> Status:
    """Return the verdict on an undamped equation that X and its error allow."""
    if exponent > 900:
        return "unstable" if excess_error < 1.0 else "undecided"
    value = _ldexp(excess, exponent)
    size = excess_error * max(1.0, abs(value))
    return "unstable" if value > size else "stable" if value < -size else "undecided"


def discriminant_excess_of(trace: float) -> tuple[int, float]:
    """Return the sign of an undamped discriminant and its excess (which loses digits near +-2; prefer factors)."""
    return (1 if trace >= 0.0 else -1), 0.25 * (abs(trace) - 2.0)


def _growth(excess: float, exponent: int, period: float) -> float:
    """Growth rate of u: 2 asinh(sqrt X) / T, zero where X <= 0."""
    if excess <= 0.0:
        return 0.0
    if exponent > 900:
        return (2.0 * math.log(2.0) + math.log(excess) + exponent * math.log(2.0)) / period
    odd = exponent % 2
    root = _ldexp(math.sqrt(_ldexp(excess, odd)), (exponent - odd) // 2)
    return 2.0 * math.asinh(root) / period


def _growth_band(excess: float, exponent: int, excess_error: float, period: float) -> tuple[float, float]:
    """Return the growth rates of u at both ends of the band of X."""
    if exponent > 900:
        middle = _growth(excess, exponent, period)
        spread = 2.0 * excess_error / period
        return middle - spread, middle + spread
    value = _ldexp(excess, exponent)
    size = excess_error * max(1.0, abs(value))
    slack = 4.0 * _EPS
    return _growth(value - size, 0, period) * (1.0 - slack), _growth(value + size, 0, period) * (1.0 + slack)


def _discriminant(sign: int, excess: float, exponent: int, decay: float) -> tuple[float, float]:
    """Return the damped discriminant and the logarithm of its magnitude."""
    if exponent > 900:
        log_size = 2.0 * math.log(2.0) + math.log(excess) + exponent * math.log(2.0) - decay
        return sign * _exp(log_size), log_size
    size = 2.0 + 4.0 * _ldexp(excess, exponent)
    log_size = math.log(abs(size)) - decay if size != 0.0 else -math.inf
    if math.isinf(size) or decay > 700.0:
        return sign * _exp(log_size), log_size
    return sign * size * math.exp(-decay), log_size


def _exponents(sign: int, excess: float, growth: float, damping: float, period: float) -> tuple[complex, complex]:
    half_turn = math.pi / period
    if excess > 0.0:
        turn = half_turn if sign < 0 else 0.0
        return complex(growth - damping, turn), complex(-growth - damping, turn)
    angle = 2.0 * math.asin(min(1.0, math.sqrt(-excess))) / period
    if sign < 0:
        angle = half_turn - angle
    return complex(-damping, angle), complex(-damping, -angle)


def _multiplier(exponent: complex, period: float) -> complex:
    size = _exp(exponent.real * period)
    angle = exponent.imag * period
    if abs(angle) >= math.pi * (1.0 - _EPS):  # the half turn is exact, the sine of a rounded pi is not
        return complex(-size, 0.0)
    if angle == 0.0:
        return complex(size, 0.0)
    return complex(size * math.cos(angle), size * math.sin(angle))


def _exp(power: float) -> float:
    return math.exp(power) if power < 709.0 else math.inf


def _ldexp(value: float, exponent: int) -> float:
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.copysign(math.inf, value)
