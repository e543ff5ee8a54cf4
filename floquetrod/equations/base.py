"""Scalar equations A'' + 2 c A' = p(tau) A: the base class, with the coefficient p in smooth pieces.

Time tau is dimensionless.  Positive p pushes away from A = 0: the sign convention of the rod, where p grows with the
axial force (Eq. (3) of DOI 10.1115/1.4031710).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats, shaped
from floquetrod._util.calling import TellsAttributes
from floquetrod._util.result_report import Report, ShownInNotebook
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.pieces import Varying, one_of_mean_and_start, refuse_mean_with_slope

_LATEST = 1e14  # periods, after which neighbouring doubles lie a large part of one apart


@dataclass(frozen=True, init=False)
class Piece:
    """A part of the period on which p = start + slope t + sum_k Re(z_k exp(i k W tau)), t from its beginning.

    Parameters
    ----------
    share : Fraction
        Its length as a fraction of the period; an exact number, so that pieces meet without rounding.
    mean : Fraction or float, optional
        Constant part of a piece without slope, taken as the exact number it is: give either ``mean`` or ``start``.
    harmonics : tuple of complex
        Amplitudes z_k, k = 1, 2, ..., with W = 2 pi / period and tau counted from the beginning of the period; none by
        default.
    slope : Fraction or float
        Change of p per unit of tau, taken as the exact number it is; by default 0.
    start : Fraction or float, optional
        Value of start + slope t at the beginning of the piece, taken as the exact number it is; beside a slope ``mean``
        is refused, since a ramp has its mean half the piece later.

    Examples
    --------
    >>> Piece(Fraction(1, 2), -0.3) == Piece(Fraction(1, 2), start=-0.3)
    True
    >>> Piece(Fraction(1, 2), start=-0.3, slope=0.1)
    Piece(share=Fraction(1, 2), start=-0.3, harmonics=(), slope=0.1)
    """

    share: Fraction
    start: Fraction | float
    harmonics: tuple[complex, ...] = ()
    slope: Fraction | float = 0.0

    def __init__(
        self,
        share: Fraction,
        mean: Fraction | float | None = None,
        harmonics: tuple[complex, ...] = (),
        slope: Fraction | float = 0.0,
        *,
        start: Fraction | float | None = None,
    ) -> None:
        """Refuse a mean beside a slope."""
        name, value = one_of_mean_and_start(mean, start)
        if slope and name == "mean":
            refuse_mean_with_slope("share * period")
        vars(self).update(share=share, start=value, harmonics=harmonics, slope=slope)

    @property
    def is_constant(self) -> bool:
        """Whether p is one number."""
        return not self.harmonics and self.slope == 0.0


class Equation(ShownInNotebook, TellsAttributes, ABC):
    """Base of the scalar equations A'' + 2 c A' = p(tau) A.

    A new equation is a frozen dataclass with ``period`` (in the unit of tau), ``damping`` (c, zero or more) and
    `pieces`; the general methods, comparison and charts then take it as they take `Hill`.
    """

    time: ClassVar[str] = "tau"
    """Name of the time, per unit of which growth rates are."""
    damping: float

    @property
    @abstractmethod
    def period(self) -> float:
        """Period of the coefficient, in the unit of tau."""

    @property
    def period_over_pi(self) -> Fraction | None:
        """The exact period over pi, where it is not the double ``period``; None where it is."""
        return None

    @abstractmethod
    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient over one period from tau = 0, in pieces whose shares add up to 1.

        Returns
        -------
        tuple of Piece
            From tau = 0 on.
        """

    def _at_hand(self) -> Report:
        """Return the numbers of the equation for a notebook."""
        value: Any = self
        numbers = [(each.name, str(getattr(self, each.name))) for each in fields(value)]
        known = {name for name, _ in numbers}
        return Report(self.title, numbers + ([] if "period" in known else [("period", f"{self.period:.6g}")]))

    def half(self) -> tuple[Piece, ...] | None:
        """Return the coefficient over half a period from an instant about which it is even; None if none is known.

        Time and the phase of harmonics count from that instant.

        Returns
        -------
        tuple of Piece or None
            Shares of them add up to 1/2.
        """
        return None

    @property
    def is_smooth(self) -> bool:
        """Whether the coefficient is one Fourier series all over the period."""
        pieces = self.pieces()
        return len(pieces) == 1 and pieces[0].slope == 0.0

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return type(self).__name__

    @property
    def _formula(self) -> str:
        """The equation with its numbers, as one writes it; "" where it is too long for a line."""
        return ""

    @property
    def level(self) -> Fraction | None:
        """The coefficient where it is constant, exactly; None where it varies."""
        pieces = self.pieces()
        first = Fraction(pieces[0].start)
        return first if all(p.is_constant and Fraction(p.start) == first for p in pieces) else None

    def as_system(self) -> HillSystem:
        """Return the same equation as a system of one: K = -p, since positive stiffness restores, and C = 2 c.

        Its period is the double ``period``.  Where the start or the slope of a piece is no double it is rounded, which
        the system's ``coefficient_error`` bounds.

        Returns
        -------
        HillSystem
            Of one equation.
        """
        damping = [[2.0 * self.damping]] if self.damping else None
        period, pieces, errors = Fraction(self.period), [], [Fraction(0)]
        for piece in self.pieces():
            start, slope = -float(piece.start), -float(piece.slope)
            cosines = [[[-z.real]] for z in piece.harmonics]
            sines = [[[z.imag]] for z in piece.harmonics]
            pieces.append((piece.share * period, Varying(None, [[slope]], cosines, sines, start=[[start]])))
            off = abs(Fraction(piece.slope) + Fraction(slope)) * piece.share * period
            errors.append(abs(Fraction(piece.start) + Fraction(start)) + off)
        error = float(max(errors))
        if max(errors) > error:  # rounded down
            error = math.nextafter(error, math.inf)
        return HillSystem.from_pieces(pieces, damping=damping, coefficient_error=error)

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau), its mean value at a jump; broadcasts over ``tau``.

        Returns
        -------
        float or ndarray
            In the shape of ``tau``.
        """
        tau, period = times(tau, self.period), self.period
        phase = tau - period * np.floor(tau / period)
        total, weight, end = np.zeros(phase.shape), np.zeros(phase.shape), Fraction(0)
        for piece in self.pieces():
            begin, end = end, end + piece.share
            low, high = float(begin) * period, float(end) * period
            for shift in (0.0, period) if end == 1 else (0.0,):  # the end of the period is its beginning
                t = phase + shift
                here = (low <= t) & (t <= high)
                total[here] += value_on(piece, t[here], low, period)
                weight[here] += 1.0
        return shaped(total / weight, phase.shape)

    def plot(self, ax: Any = None) -> Any:
        r"""Draw p(tau) over one period, its jumps and its mean, on ``ax`` or on new axes; return the axes.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Examples
        --------
        >>> from floquetrod.equations import Mathieu
        >>> Mathieu(alpha=0.5, beta=-0.25).plot().get_ylabel()
        'coefficient $p(\\tau)$'
        """
        from floquetrod.plotting.coefficient_plot import CoefficientPiece, draw_coefficients, instants

        require(self)
        stretches, end = [], Fraction(0)
        for piece in self.pieces():
            begin, end = end, end + piece.share
            low, high = float(begin) * self.period, float(end) * self.period
            tau = low + (high - low) * instants(len(piece.harmonics))
            stretches.append(CoefficientPiece(tau, value_on(piece, tau, low, self.period)[:, None]))
        time = {"tau": r"\tau"}.get(self.time, self.time)
        return draw_coefficients(
            stretches,
            [f"$p({time})$"],
            time=f"${time}$",
            axis=f"coefficient $p({time})$",
            title=f"{self.title}: $A'' + 2 c A' = p({time}) A$, $c$ = {self.damping:.5g}",
            mean=-float(self.as_system().stiffness[0, 0]),
            ax=ax,
        )


@dataclass(frozen=True)
class Alternating(Equation):
    """Base of the equations whose coefficient has the mean beta, the amplitude alpha and the period 2 pi."""

    alpha: float
    beta: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        set_field(self, "alpha", validate.coefficient("alpha", self.alpha))
        set_field(self, "beta", validate.coefficient("beta", self.beta))
        set_field(self, "damping", damping_rate(self.damping))

    @property
    def period(self) -> float:
        """Period of the coefficient, 2 pi."""
        return 2.0 * math.pi

    @property
    def period_over_pi(self) -> Fraction:
        """The exact period over pi, 2."""
        return Fraction(2)


def value_on(piece: Piece, tau: Floats, begin: float, period: float) -> Floats:
    """Return p at times within a piece that begins at ``begin``."""
    value = float(piece.start) + float(piece.slope) * (tau - begin)
    for k, z in enumerate(piece.harmonics, start=1):
        angle = k * (2.0 * math.pi / period) * tau
        value = value + z.real * np.cos(angle) - z.imag * np.sin(angle)
    return value


def from_instant(pieces: tuple[Piece, ...], start: float, period: float) -> tuple[tuple[Piece, ...], float]:
    """Return one period's pieces from tau = ``start``, and the phase of that instant, from 0 up to ``period``.

    The piece in which it begins is split in two; harmonics keep their phase, which counts from tau = 0.
    """
    phase = start % period
    share = min(Fraction(phase) / Fraction(period), Fraction(1))
    before: list[Piece] = []
    after: list[Piece] = []
    end = Fraction(0)
    for piece in pieces:
        begin, end = end, end + piece.share
        if end <= share:
            before.append(piece)
        elif begin >= share:
            after.append(piece)
        else:
            cut = share - begin
            risen = Fraction(piece.start) + Fraction(piece.slope) * cut * Fraction(period)
            before.append(replace(piece, share=cut))
            after.append(replace(piece, share=piece.share - cut, start=risen))
    return (*after, *before), phase


def require(value: Any, kinds: tuple[type, ...] = (Equation,), by: str = "", hint: str = "") -> None:
    """Raise TypeError unless ``value`` is one of the equation ``kinds``, ValueError where its pieces leave gaps."""
    if not isinstance(value, kinds):
        example = "an Equation, such as Mathieu, Meissner or Hill"
        names = example if kinds == (Equation,) else ", ".join(kind.__name__ for kind in kinds)
        names += f", {hint}" if hint else ""
        raise validate.wrong_type(
            "equation", f"must be {names}{' for ' + by if by else ''}, got {validate.short(value)}"
        )
    if isinstance(value, Equation):
        shares = [piece.share for piece in value.pieces()]
        if not (all(isinstance(share, Fraction) and share > 0 for share in shares) and sum(shares) == 1):
            raise validate.wrong_value(
                "equation",
                f"must have pieces whose shares are positive Fractions that add up to 1, got {shares}; "
                "Fraction(1, 10) is exact, 0.1 is not",
            )


def damping_rate(value: Any) -> float:
    """Return c, checked."""
    number = validate.nonnegative("damping", value, "growth of the free motion is not damping")
    if number > validate.LARGEST_DAMPING:
        raise validate.wrong_value(
            "damping", f"must be at most {validate.LARGEST_DAMPING:g}, got {number!r}; check its unit"
        )
    return validate.unrounded("damping", value, number)


def times(tau: Any, period: float, name: str = "tau") -> Floats:
    """Return times as an array, checked."""
    return validate.array(name, tau, least=-_LATEST * period, largest=_LATEST * period)


def set_field(equation: object, name: str, value: object) -> None:
    """Set a field of a frozen dataclass while it is made."""
    object.__setattr__(equation, name, value)


def signed(number: float) -> str:
    """Return a number with its sign apart, as a term of a sum: "- 0.5"."""
    return f"{'-' if number < 0.0 else '+'} {abs(number):.10g}"


def written(motion: str, damping: float) -> str:
    """Return the left side A'' + 2 c A' of an equation in a motion A, without damping A''."""
    return f"{motion}'' {signed(2.0 * damping)} {motion}'" if damping else f"{motion}''"
