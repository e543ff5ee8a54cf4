"""Meissner's equation: a square wave."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod._util.arrays import shaped
from floquetrod._util.calling import constructor_hints
from floquetrod.equations.base import Alternating, Piece, signed, times, written

_SQUARE = "in x'' + (delta + epsilon sign(sin t)) x = 0 alpha is -epsilon and beta is -delta"


@constructor_hints(delta=_SQUARE, epsilon=_SQUARE)
@dataclass(frozen=True)
class Meissner(Alternating):
    """Meissner's equation A'' + 2 c A' = (beta + alpha sign(sin tau)) A, of period 2 pi.

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
    The square-wave problem behind Eq. (A4) of DOI 10.1115/1.4031710.
    """

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return "Meissner's equation (square wave)"

    @property
    def _formula(self) -> str:
        """The equation with its numbers."""
        return f"{written('A', self.damping)} = ({self.beta:.10g} {signed(self.alpha)} sign(sin tau)) A"

    @property
    def levels(self) -> tuple[Fraction, Fraction]:
        """The two values of the coefficient, beta + alpha and beta - alpha, exactly."""
        return Fraction(self.beta) + Fraction(self.alpha), Fraction(self.beta) - Fraction(self.alpha)

    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient over one period from tau = 0."""
        return tuple(Piece(Fraction(1, 2), level) for level in self.levels)

    def half(self) -> tuple[Piece, ...]:
        """Return the coefficient over half a period from tau = pi / 2."""
        return tuple(Piece(Fraction(1, 4), level) for level in self.levels)

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau) = beta + alpha sign(sin tau); broadcasts over ``tau``.

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
        return shaped(self.beta + self.alpha * np.sign(np.sin(tau)), tau.shape)


SquareWave = Meissner
"""The name that DOI 10.1115/1.4031710 gives it."""
