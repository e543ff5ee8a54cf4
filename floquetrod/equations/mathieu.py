"""Mathieu's equation, and the same with dry friction."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.calling import constructor_hints
from floquetrod.equations.base import Alternating, Piece, damping_rate, set_field, times
from floquetrod.equations.conventions import other_forms
from floquetrod.equations.hill import Hill


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

    Notes
    -----
    Eqs. (3)-(4) of DOI 10.1115/1.4031710.

    Examples
    --------
    >>> Mathieu(alpha=0.5, beta=-0.25).coefficient(0.0)
    -0.25
    """

    @classmethod
    def from_aq(cls, a: float, q: float, damping: float = 0.0) -> Mathieu:
        """Return y'' + 2 k y' + (a - 2 q cos 2 z) y = 0 as an equation in tau = 2 z + pi / 2.

        ``a`` and ``q`` are numbers of magnitude up to 4e9 and 2e9; ``damping`` is k, the decay rate per unit z, twice
        that per unit tau, as all rates.

        >>> Mathieu.from_aq(a=1.0, q=1.0)
        Mathieu(alpha=0.5, beta=-0.25, damping=0.0)
        """
        mean, amplitude = (validate.finite(name, value) for name, value in (("a", a), ("q", q)))
        validate.within("a", mean, -4.0 * validate.LARGEST, 4.0 * validate.LARGEST)
        validate.within("q", amplitude, -2.0 * validate.LARGEST, 2.0 * validate.LARGEST)
        return cls(0.5 * amplitude, -0.25 * mean, 0.5 * damping_rate(damping))

    @classmethod
    def from_delta_epsilon(cls, delta: float, epsilon: float, damping: float = 0.0) -> Mathieu:
        """Return x'' + 2 c x' + (delta + epsilon cos t) x = 0 as an equation in tau = t - pi / 2.

        ``delta`` and ``epsilon`` are numbers of magnitude up to 1e9, and beta = -delta; ``damping`` is c, the decay
        rate per unit t.

        >>> Mathieu.from_delta_epsilon(delta=0.25, epsilon=0.5)
        Mathieu(alpha=0.5, beta=-0.25, damping=0.0)
        """
        restoring, amplitude = (validate.coefficient(name, x) for name, x in (("delta", delta), ("epsilon", epsilon)))
        return cls(amplitude, -restoring, damping)

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return "Mathieu's equation"

    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient over one period from tau = 0."""
        return (Piece(Fraction(1), self.beta, (complex(0.0, -self.alpha),) if self.alpha else ()),)

    def half(self) -> tuple[Piece, ...]:
        """Return the coefficient over half a period from tau = pi / 2, where it is beta + alpha cos."""
        return (Piece(Fraction(1, 2), self.beta, (complex(self.alpha, 0.0),) if self.alpha else ()),)

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau) = beta + alpha sin tau; broadcasts over ``tau``."""
        tau = times(tau, self.period)
        return shaped(self.beta + self.alpha * np.sin(tau), tau.shape)

    def as_hill(self) -> Hill:
        """Return the same equation as a `Hill` value."""
        return Hill(self.beta, sines=(self.alpha,), damping=self.damping)


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
