"""The equations, as small frozen values: A'' + 2 c A' = p(tau) A with p periodic.

Time tau is dimensionless.  Positive p pushes away from A = 0: the sign convention of the rod, where p grows with the
axial force (Eq. (3) of DOI 10.1115/1.4031710).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import shaped

_LATEST = 1e14  # periods, after which neighbouring doubles lie a large part of one apart


@dataclass(frozen=True)
class Mathieu:
    """Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A, of period 2 pi.

    Parameters
    ----------
    alpha, beta : float
        Amplitude and mean of the coefficient (dimensionless, magnitude at most 1e9).
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

    alpha: float
    beta: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        _set(self, "alpha", validate.coefficient("alpha", self.alpha))
        _set(self, "beta", validate.coefficient("beta", self.beta))
        _set(self, "damping", _damping(self.damping))

    @property
    def period(self) -> float:
        """Period of the coefficient, 2 pi."""
        return 2.0 * math.pi

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau) = beta + alpha sin tau; broadcasts over ``tau``."""
        times = _times(tau, self.period)
        return shaped(self.beta + self.alpha * np.sin(times), times.shape)

    def as_hill(self) -> Hill:
        """Return the same equation as a `Hill` value."""
        return Hill(self.beta, sines=(self.alpha,), damping=self.damping)


@dataclass(frozen=True)
class Meissner:
    """Meissner's equation A'' + 2 c A' = (beta + alpha sign(sin tau)) A, of period 2 pi.

    Parameters
    ----------
    alpha, beta : float
        Amplitude and mean of the coefficient (dimensionless, magnitude at most 1e9).
    damping : float
        c, the decay rate per unit tau of the free motion; zero or more.

    Notes
    -----
    The square-wave problem behind Eq. (A4) of DOI 10.1115/1.4031710.
    """

    alpha: float
    beta: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        _set(self, "alpha", validate.coefficient("alpha", self.alpha))
        _set(self, "beta", validate.coefficient("beta", self.beta))
        _set(self, "damping", _damping(self.damping))

    @property
    def period(self) -> float:
        """Period of the coefficient, 2 pi."""
        return 2.0 * math.pi

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau) = beta + alpha sign(sin tau); broadcasts over ``tau``."""
        times = _times(tau, self.period)
        return shaped(self.beta + self.alpha * np.sign(np.sin(times)), times.shape)


SquareWave = Meissner
"""The name that DOI 10.1115/1.4031710 gives it."""


@dataclass(frozen=True)
class Hill:
    """Hill's equation A'' + 2 c A' = p(tau) A for a finite Fourier series p.

    p(tau) = mean + sum_k cosines[k-1] cos(k W tau) + sines[k-1] sin(k W tau), k = 1, 2, ..., with W = 2 pi / period.

    Parameters
    ----------
    mean : float
        Mean of the coefficient.
    cosines, sines : sequence of float
        Fourier coefficients from the first harmonic on; their lengths may differ.
    period : float
        Period of the coefficient, in the unit of tau.
    damping : float
        c, the decay rate per unit tau of the free motion; zero or more.

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
        _set(self, "mean", validate.coefficient("mean", self.mean))
        _set(self, "cosines", validate.numbers("cosines", self.cosines))
        _set(self, "sines", validate.numbers("sines", self.sines))
        period = validate.positive("period", self.period, "give the period of the coefficient in tau")
        _set(self, "period", validate.unrounded("period", self.period, period))
        _set(self, "damping", _damping(self.damping))

    def coefficient(self, tau: Any) -> Any:
        """Return p(tau); broadcasts over ``tau``."""
        phase = (2.0 * math.pi / self.period) * _times(tau, self.period)
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

    def as_hill(self) -> Hill:
        """Return this equation."""
        return self


@dataclass(frozen=True)
class FrictionalMathieu:
    """Mathieu's equation with dry friction, A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A').

    sign(0) is any number between -1 and 1, as Coulomb's law has it (Filippov): a motion that comes to rest sticks while
    abs((beta + alpha sin tau) A) <= gamma.  Judged by `floquetrod.friction`.

    Parameters
    ----------
    alpha, beta : float
        Amplitude and mean of the coefficient (dimensionless, magnitude at most 1e9).
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
        _set(self, "alpha", validate.coefficient("alpha", self.alpha))
        _set(self, "beta", validate.coefficient("beta", self.beta))
        _set(self, "gamma", validate.nonnegative("gamma", self.gamma, "friction opposes the motion"))
        _set(self, "damping", _damping(self.damping))

    @property
    def without_friction(self) -> Mathieu:
        """The same equation for gamma = 0."""
        return Mathieu(self.alpha, self.beta, self.damping)


Equation: TypeAlias = Mathieu | Meissner | Hill
"""Any equation a method may be asked about."""


def require(value: Any, kinds: tuple[type, ...] = (Mathieu, Meissner, Hill), by: str = "") -> None:
    """Raise TypeError unless ``value`` is one of the equation ``kinds``."""
    if not isinstance(value, kinds):
        names = ", ".join(kind.__name__ for kind in kinds)
        raise TypeError(f"equation must be {names}{' for ' + by if by else ''}, got {validate.short(value)}")


def _damping(value: Any) -> float:
    number = validate.nonnegative("damping", value, "growth of the free motion is not damping")
    if number > validate.LARGEST_DAMPING:
        raise ValueError(f"damping must be at most {validate.LARGEST_DAMPING:g}, got {number!r}; check its unit")
    return validate.unrounded("damping", value, number)


def _times(tau: Any, period: float) -> NDArray[np.float64]:
    return validate.array("tau", tau, least=-_LATEST * period, largest=_LATEST * period)


def _set(equation: object, name: str, value: object) -> None:
    object.__setattr__(equation, name, value)
