"""Hill's equation: a finite Fourier series."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import zip_longest
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, shaped
from floquetrod._util.calling import constructor_hints
from floquetrod.equations.base import Equation, Piece, damping_rate, set_field, times

_MOST_ERROR = 1e-12  # of the series of a function, over its size (a choice)


@constructor_hints(frequency="period is 2 pi / frequency")
@dataclass(frozen=True)
class Hill(Equation):
    """Hill's equation A'' + 2 c A' = p(tau) A for a finite Fourier series p.

    p(tau) = mean + sum_k cosines[k-1] cos(k W tau) + sines[k-1] sin(k W tau), k = 1, 2, ..., with W = 2 pi / period.

    Parameters
    ----------
    mean : float
        Mean of the coefficient.
    cosines : sequence of float
        Coefficients of the cosines from the first harmonic on; none by default.
    sines : sequence of float
        Coefficients of the sines from the first harmonic on; none by default.  There may be more or fewer of them than
        cosines.
    period : float
        Period of the coefficient, in the unit of tau.
    damping : float
        c, the decay rate per unit tau of the free motion; zero or more.

    Raises
    ------
    TypeError, ValueError
        For coefficients other than finite numbers, a period not above 0, and negative damping.

    Examples
    --------
    >>> Hill(-0.25, cosines=(0.1,), sines=(0.5, 0.2)).coefficient(0.0)
    -0.15
    """

    mean: float
    cosines: tuple[float, ...] = ()
    sines: tuple[float, ...] = ()
    period: float = 2.0 * math.pi
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        set_field(self, "mean", validate.coefficient("mean", self.mean))
        set_field(self, "cosines", validate.numbers("cosines", self.cosines))
        set_field(self, "sines", validate.numbers("sines", self.sines))
        period = validate.positive("period", self.period, "give the period of the coefficient in tau")
        set_field(self, "period", validate.unrounded("period", self.period, period))
        set_field(self, "damping", damping_rate(self.damping))

    @classmethod
    def from_function(
        cls, function: Callable[[float], float], period: float, damping: float = 0.0, *, jumps: Any = ()
    ) -> Hill | JumpingHill:
        """Return the equation whose coefficient a function computes: a Fourier series, or pieces between its jumps.

        Every value is within 1e-12 of the largest value of the function.  ``HillSystem.from_function``, of one
        equation, allows larger errors, and includes them in its verdicts.

        Parameters
        ----------
        function : callable (tau) -> float
            p, periodic and smooth except for its jumps.
        period : float
            Its period.
        damping : float
            Damping c, as of the equation.
        jumps : sequence of float
            Instants from 0 up to the period at which p jumps, or has a kink; none by default.

        Returns
        -------
        Hill or JumpingHill
            The second where the function jumps.

        Raises
        ------
        TypeError, ValueError
            For a function whose series does not come within 1e-12 of it, as with a jump that is not named; for a
            period that is not positive, and negative damping.

        Examples
        --------
        >>> len(Hill.from_function(lambda tau: -1.0 / (1.1 + math.cos(tau)), 2.0 * math.pi).cosines)
        74
        >>> wave = Hill.from_function(lambda tau: -2.0 if tau % 2.0 < 1.0 else -0.5, 2.0, jumps=[0.0, 1.0])
        >>> [(str(piece.share), piece.start) for piece in wave.pieces()]
        [('1/2', -2.0), ('1/2', -0.5)]
        """
        from floquetrod.equations import sampling

        validate.function("function", function)
        period, damping = validate.positive("period", period), damping_rate(damping)
        expansion = sampling.expanded(lambda tau: [[function(tau)]], period, jumps, 1)
        pieces = tuple(_piece(Fraction(duration) / Fraction(period), value) for duration, value in expansion.pieces)
        largest = max(abs(float(p.start)) + abs(float(p.slope)) * period + sum(map(abs, p.harmonics)) for p in pieces)
        if expansion.error > _MOST_ERROR * largest:
            raise ValueError(
                f"function must have a series that agrees with it to {_MOST_ERROR:g} of its size, got one to "
                f"{expansion.error / largest:.1g}; HillSystem.from_function takes it, of one equation with K = -p"
            )
        if len(pieces) > 1:
            return JumpingHill(pieces, period, damping)
        ((_, value),) = expansion.pieces
        cosines, sines = (tuple(float(m[0, 0]) for m in series) for series in (value.cosines, value.sines))
        return cls(float(value.start[0, 0]), cosines, sines, period, damping)

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau); broadcasts over ``tau``.

        Returns
        -------
        float or ndarray
            In the shape of ``tau``.

        Raises
        ------
        TypeError, ValueError
            For instants other than finite numbers.
        """
        phase = (2.0 * math.pi / self.period) * times(tau, self.period)
        total = np.full(phase.shape, self.mean)
        for k, value in enumerate(self.cosines, start=1):
            total = total + value * np.cos(k * phase)
        for k, value in enumerate(self.sines, start=1):
            total = total + value * np.sin(k * phase)
        return shaped(total, phase.shape)

    @property
    def harmonics(self) -> tuple[complex, ...]:
        """Amplitudes z_k, k = 1, 2, ..., with p = mean + sum_k Re(z_k exp(i k W tau)); trailing zeros dropped."""
        pairs = zip_longest(self.cosines, self.sines, fillvalue=0.0)
        values = [complex(cosine, -sine) for cosine, sine in pairs]
        while values and values[-1] == 0.0:
            values.pop()
        return tuple(values)

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return "Hill's equation"

    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient over one period from tau = 0."""
        return (Piece(Fraction(1), self.mean, self.harmonics),)

    def half(self) -> tuple[Piece, ...] | None:
        """Return the coefficient over half a period from an instant about which it is even, to rounding, or None."""
        amplitudes = _even_amplitudes(self.harmonics)
        return None if amplitudes is None else (Piece(Fraction(1, 2), self.mean, amplitudes),)

    def as_hill(self) -> Hill:
        """Return this equation.

        Returns
        -------
        Hill
            The equation itself.
        """
        return self


@dataclass(frozen=True)
class JumpingHill(Equation):
    """Hill's equation whose coefficient is made of pieces of the period, the result of `Hill.from_function` with jumps.

    Parameters
    ----------
    parts : tuple of Piece
        From tau = 0 on, over a period.
    period : float
        Period of the coefficient, in the unit of tau.
    damping : float
        c, the decay rate per unit tau of the free motion; zero or more.
    """

    parts: tuple[Piece, ...]
    period: float = 2.0 * math.pi
    damping: float = 0.0

    def pieces(self) -> tuple[Piece, ...]:
        """Return the coefficient over one period from tau = 0."""
        return self.parts

    @property
    def title(self) -> str:
        """Name of the equation in charts."""
        return "Hill's equation"


def _piece(share: Fraction, value: Any) -> Piece:
    """Return a piece of a scalar equation from matrices of one row."""
    pairs = zip_longest(value.cosines, value.sines, fillvalue=[[0.0]])
    harmonics = tuple(complex(cosine[0][0], -sine[0][0]) for cosine, sine in pairs)
    start, slope = float(value.start[0, 0]), float(value.slope_or_zero[0, 0])
    return Piece(share, harmonics=harmonics, slope=slope, start=start)


def _even_amplitudes(harmonics: tuple[complex, ...]) -> tuple[complex, ...] | None:
    """Return the real amplitudes about an instant of even symmetry, to rounding; None without one."""
    first = next((k for k, z in enumerate(harmonics, start=1) if z != 0.0), None)
    if first is None:
        return ()
    for turn in range(2 * first):
        phase = (math.pi * turn - math.atan2(harmonics[first - 1].imag, harmonics[first - 1].real)) / first
        turned = [z * cmath.exp(1j * k * phase) for k, z in enumerate(harmonics, start=1)]
        if all(abs(z.imag) <= 8.0 * EPS * k * abs(z) for k, z in enumerate(turned, start=1)):
            return tuple(complex(z.real, 0.0) for z in turned)
    return None
