"""Mathieu's equation, and the same with dry friction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.calling import constructor_hints
from floquetrod.equations.base import Alternating, Equation, Piece, damping_rate, set_field, signed, times, written
from floquetrod.equations.conventions import other_forms
from floquetrod.equations.hill import Hill
from floquetrod.parameter import Option, Parameter, by_name


def _number(name: str, most: float, text: str) -> Parameter:
    """Return the record of a dimensionless number of magnitude up to ``most``."""
    return Parameter(name=name, symbol=name, kind="ratio", least=-most, largest=most, option=Option(text))


_DAMPING = Parameter(
    name="damping",
    symbol="c",
    kind="ratio",
    least=0.0,
    largest=validate.LARGEST,
    default=0.0,
    option=Option("decay rate of the free motion per unit of tau, z or t (default 0)"),
)

MATHIEU = by_name(
    _number("alpha", validate.LARGEST, "with --beta: A'' + 2 c A' = (beta + alpha sin tau) A"),
    _number("beta", validate.LARGEST, "with --alpha; -0.25, say"),
    _DAMPING,
)
"""Parameters of Mathieu's equation by their names."""

MATHIEU_AQ = by_name(
    _number("a", 4.0 * validate.LARGEST, "with --q: y'' + 2 c y' + (a - 2 q cos 2z) y = 0"),
    _number("q", 2.0 * validate.LARGEST, "with --a"),
    _DAMPING,
)
"""Parameters of its standard form (DLMF 28.2.1) by their names."""

MATHIEU_DELTA = by_name(
    _number("delta", validate.LARGEST, "with --epsilon: x'' + 2 c x' + (delta + epsilon cos t) x = 0"),
    _number("epsilon", validate.LARGEST, "with --delta"),
    _DAMPING,
)
"""Arguments of `Mathieu.from_delta_epsilon` by their names."""


@constructor_hints(**other_forms("Mathieu", "makes the equation"))
@dataclass(frozen=True)
class Mathieu(Alternating):
    """Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A, of period 2 pi.

    Parameters
    ----------
    alpha : float
        Amplitude of the coefficient (dimensionless, magnitude at most 1e9).
    beta : float
        Mean of the coefficient (dimensionless, magnitude at most 1e9).
    damping : float
        c, the decay rate per unit tau of the free motion; zero or more.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges.

    Notes
    -----
    Eqs. (3)-(4) of DOI 10.1115/1.4031710.

    Examples
    --------
    >>> Mathieu(alpha=0.5, beta=-0.25).coefficient(0.0)
    -0.25
    """

    @staticmethod
    def from_aq(a: float, q: float, damping: float = 0.0) -> MathieuAQ:
        """Return y'' + 2 k y' + (a - 2 q cos 2 z) y = 0 (DLMF 28.2.1), whose answers are in its own time z.

        ``a`` and ``q`` are numbers of magnitude up to 4e9 and 2e9; ``damping`` is k, the decay rate per unit z.  Growth
        rates are per unit z and the period is pi; `MathieuAQ.in_tau` is the same equation in tau.

        Returns
        -------
        MathieuAQ
            The equation, in z.

        Raises
        ------
        TypeError, ValueError
            For numbers out of these ranges.

        Examples
        --------
        >>> equation = Mathieu.from_aq(a=1.0, q=1.0)
        >>> equation, equation.in_tau
        (Mathieu.from_aq(a=1.0, q=1.0, damping=0.0), Mathieu(alpha=0.5, beta=-0.25, damping=0.0))
        """
        return MathieuAQ(a, q, damping)

    @classmethod
    def from_delta_epsilon(cls, delta: float, epsilon: float, damping: float = 0.0) -> Mathieu:
        """Return x'' + 2 c x' + (delta + epsilon cos t) x = 0 as an equation in tau = t - pi / 2.

        ``delta`` and ``epsilon`` are numbers of magnitude up to 1e9, and beta = -delta; ``damping`` is c, the decay
        rate per unit t.

        Returns
        -------
        Mathieu
            The equation, in tau.

        Raises
        ------
        TypeError, ValueError
            For numbers out of these ranges.

        Examples
        --------
        >>> Mathieu.from_delta_epsilon(delta=0.25, epsilon=0.5)
        Mathieu(alpha=0.5, beta=-0.25, damping=0.0)
        """
        restoring, amplitude = (validate.coefficient(name, x) for name, x in (("delta", delta), ("epsilon", epsilon)))
        return cls(amplitude, -restoring, damping)

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return "Mathieu's equation"

    @property
    def _formula(self) -> str:
        """The equation with its numbers."""
        return f"{written('A', self.damping)} = ({self.beta:.10g} {signed(self.alpha)} sin tau) A"

    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient over one period from tau = 0."""
        return (Piece(Fraction(1), self.beta, (complex(0.0, -self.alpha),) if self.alpha else ()),)

    def half(self) -> tuple[Piece, ...]:
        """Return the coefficient over half a period from tau = pi / 2, where it is beta + alpha cos."""
        return (Piece(Fraction(1, 2), self.beta, (complex(self.alpha, 0.0),) if self.alpha else ()),)

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau) = beta + alpha sin tau; broadcasts over ``tau``.

        Returns
        -------
        float or ndarray
            In the shape of ``tau``.

        Raises
        ------
        TypeError, ValueError
            For instants other than finite numbers.
        """
        tau = times(tau, self.period)
        return shaped(self.beta + self.alpha * np.sin(tau), tau.shape)

    def as_hill(self) -> Hill:
        """Return the same equation as a `Hill` value.

        Returns
        -------
        Hill
            With one sine.
        """
        return Hill(self.beta, sines=(self.alpha,), damping=self.damping)


@dataclass(frozen=True, repr=False)
class MathieuAQ(Equation):
    """Mathieu's equation in its standard form y'' + 2 k y' + (a - 2 q cos 2 z) y = 0, of period pi in z.

    Parameters
    ----------
    a : float
        Dimensionless, of magnitude up to 4e9.
    q : float
        Dimensionless, of magnitude up to 2e9.
    damping : float
        k, the decay rate per unit z of the free motion; zero or more.

    Notes
    -----
    DLMF 28.2.1.  With tau = 2 z + pi / 2 it is `Mathieu` of alpha = q / 2, beta = -a / 4 and c = k / 2.
    """

    time = "z"
    a: float
    q: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        for name in ("a", "q"):
            record, value = MATHIEU_AQ[name], validate.finite(name, getattr(self, name))
            set_field(self, name, validate.within(name, value, record.least, record.largest))
        set_field(self, "damping", damping_rate(self.damping))

    def __repr__(self) -> str:
        """Return the call that makes it."""
        return f"Mathieu.from_aq(a={self.a!r}, q={self.q!r}, damping={self.damping!r})"

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return "Mathieu's equation"

    @property
    def _formula(self) -> str:
        """The equation with its numbers."""
        return f"{written('y', self.damping)} + ({self.a:.10g} {signed(-2.0 * self.q)} cos 2z) y = 0"

    @property
    def period(self) -> float:
        """Period of the coefficient in z, pi."""
        return math.pi

    @property
    def period_over_pi(self) -> Fraction:
        """The exact period over pi, 1."""
        return Fraction(1)

    @property
    def in_tau(self) -> Mathieu:
        """The same equation in tau = 2 z + pi / 2, in which growth rates are half as large."""
        return Mathieu(0.5 * self.q, -0.25 * self.a, 0.5 * self.damping)

    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient 2 q cos 2 z - a over one period from z = 0."""
        return (Piece(Fraction(1), 0.0 - self.a, (complex(2.0 * self.q, 0.0),) if self.q else ()),)

    def half(self) -> tuple[Piece, ...]:
        """Return the coefficient over half a period from z = 0, about which it is even."""
        return (Piece(Fraction(1, 2), 0.0 - self.a, (complex(2.0 * self.q, 0.0),) if self.q else ()),)

    def coefficient(self, z: Any) -> Any:
        """Return 2 q cos 2 z - a; broadcasts over ``z``.

        Returns
        -------
        float or ndarray
            In the shape of ``z``.
        """
        z = times(z, self.period, "z")
        return shaped(2.0 * self.q * np.cos(2.0 * z) - self.a, z.shape)

    def as_hill(self) -> Hill:
        """Return the same equation as a `Hill` value, of period pi.

        Returns
        -------
        Hill
            With one cosine.
        """
        return Hill(0.0 - self.a, cosines=(2.0 * self.q,), period=math.pi, damping=self.damping)


def in_tau(equation: Any) -> Any:
    """Return Mathieu's equation of (a, q) in (alpha, beta), which kernels know; any other unchanged."""
    return equation.in_tau if isinstance(equation, MathieuAQ) else equation


@constructor_hints(**other_forms("conventions"))
@dataclass(frozen=True)
class FrictionalMathieu:
    """Mathieu's equation with dry friction, A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A').

    sign(0) is any number between -1 and 1, as Coulomb's law has it (Filippov): a motion that comes to rest sticks while
    abs((beta + alpha sin tau) A) <= gamma.  Verdicts on it are in `floquetrod.friction`.

    Parameters
    ----------
    alpha : float
        Amplitude of the coefficient (dimensionless, magnitude at most 1e9).
    beta : float
        Mean of the coefficient (dimensionless, magnitude at most 1e9).
    gamma : float
        Friction force over inertia, zero or more.
    damping : float
        c, the decay rate per unit tau of the free motion; zero or more.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges.

    Notes
    -----
    Eq. (14) of DOI 10.1115/1.4031710.  Only alpha, beta, damping and the kick over gamma matter: with A also k A is a
    motion, for k gamma.

    Examples
    --------
    >>> FrictionalMathieu(alpha=0.5, beta=0.1, gamma=0.01).without_friction
    Mathieu(alpha=0.5, beta=0.1, damping=0.0)
    """

    alpha: float
    beta: float
    gamma: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        set_field(self, "alpha", validate.coefficient("alpha", self.alpha))
        set_field(self, "beta", validate.coefficient("beta", self.beta))
        set_field(self, "gamma", validate.nonnegative("gamma", self.gamma, "friction opposes the motion"))
        set_field(self, "damping", damping_rate(self.damping))

    @property
    def without_friction(self) -> Mathieu:
        """The same equation for gamma = 0."""
        return Mathieu(self.alpha, self.beta, self.damping)
