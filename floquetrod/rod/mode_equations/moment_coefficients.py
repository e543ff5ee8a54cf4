"""Second moments of modes under noise: coefficients, closed forms and bounds of growth.

The mathematics is that of `noisy_equations`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Bools, Floats, Ints
from floquetrod.equations import HillSystem, SecondMoments, second_moments

_NEWTON = 12  # steps
_ROUNDING = 64.0 * EPS  # relative, of growth from coefficients


class ModeCoefficients(NamedTuple):
    """Coefficients of the equations of modes under loads, each of a shape that broadcasts to (loads, modes).

    Attributes
    ----------
    squared : ndarray
        w^2 in 1/s^2.
    waves : tuple of ndarray
        Complex amplitudes of the harmonics of p in 1/s^2.
    frequency : ndarray
        Of the load in rad/s.
    intensity : ndarray
        s in 1/s^1.5.
    damping : float
        c in 1/s.
    unit : float, optional
        Inverse of the unit of time of `moments` in 1/s, by default about w.
    per_newton : ndarray, optional
        k, what a newton of compression takes from the stiffness, in 1/(N s^2).
    least : ndarray, optional
        Least intensity in 1/s^1.5 with any density.
    """

    squared: Floats
    waves: tuple[NDArray[np.complex128], ...]
    frequency: Floats
    intensity: Floats
    damping: float
    unit: float | None = None
    per_newton: Any = 0.0
    least: Any = 0.0

    @property
    def hertz(self) -> Floats:
        """Twice the frequencies of the modes in Hz, 0 of those that buckle."""
        return np.asarray(np.sqrt(np.maximum(self.squared, 0.0)) / math.pi)

    @property
    def reference(self) -> Floats:
        """Twice the frequencies in Hz, of modes that buckle twice their growth over 2 pi."""
        return np.asarray(np.sqrt(np.abs(self.squared)) / math.pi)

    def some(self, at: tuple[Ints, Ints]) -> ModeCoefficients:
        """Return the coefficients of some modes under some loads, (n, 1)."""

        def each(values: Any) -> Any:
            return np.broadcast_to(values, self.squared.shape)[at][:, None]

        return self._replace(
            squared=each(self.squared),
            waves=tuple(each(wave) for wave in self.waves),
            frequency=each(self.frequency),
            intensity=each(self.intensity),
            per_newton=each(self.per_newton),
            least=each(self.least),
        )

    def with_density(self, density: Floats) -> ModeCoefficients:
        """Return the equations with a density in N^2/Hz at twice the frequency of each mode."""
        return self._replace(intensity=np.maximum(np.abs(self.per_newton) * np.sqrt(0.5 * density), self.least))

    @property
    def growth_bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bound of the growth of second moments in 1/s, -2 c and infinite where none is known."""
        noise, c = np.square(self.intensity), self.damping
        sizes = [self.sizes(power) for power in range(4)]
        mean_square = 0.5 * np.asarray(sum(np.square(np.abs(wave)) for wave in self.waves))
        e = _excess(self.squared - c * c, noise)
        center = self.squared - c * c + e * e
        held = center > sizes[0]
        center, sizes[0] = np.where(held, center, 1.0), np.where(held, sizes[0], 0.0)
        off = unevenness_bound(noise, sizes, center)
        off = off + _ROUNDING * (2.0 * c + 2.0 * e * (1.0 + (np.abs(self.squared) + c * c) / center))
        low, high = (
            2.0 * e * (1.0 + mean_square / (center * (center + sign * sizes[0]))) - 2.0 * c - sign * off
            for sign in (1.0, -1.0)
        )
        return np.where(held, np.maximum(low, -2.0 * c), -2.0 * c), np.where(held, high, np.inf)

    def sizes(self, power: int) -> Floats:
        """Return a bound of a derivative of p."""
        turns = ((k * self.frequency) ** power * np.abs(wave) for k, wave in enumerate(self.waves, start=1))
        found: Any = sum(turns, np.zeros_like(self.squared))
        return np.asarray(found)

    @property
    def rate(self) -> Floats:
        """The unit of time of `moments`, by its inverse in 1/s."""
        if self.unit is not None:
            return np.full_like(self.squared, self.unit)
        return np.asarray(np.sqrt(np.maximum(np.abs(self.squared), 1e-12 * np.square(self.frequency))))

    def system(self, chosen: Bools) -> HillSystem:
        """Return some modes without noise as a batch, in the order of C, in units of time in which w is 1."""
        waves = [self._each(wave, 2, chosen)[:, None, None] for wave in self.waves]
        return HillSystem(
            self._each(self.squared, 2, chosen)[:, None, None],
            [wave.real for wave in waves],
            [-wave.imag for wave in waves],
            damping=2.0 * self._each(self.damping, 1, chosen)[:, None, None],
            period=2.0 * math.pi / self._each(self.frequency, 1, chosen),
        )

    def moments(self, chosen: Bools) -> SecondMoments:
        """Return the second moments of the same modes, in the same units."""
        intensity = self._each(self.intensity, 1, chosen) * np.sqrt(self._each(1.0, 1, chosen))
        return second_moments(self.system(chosen), [([[1.0]], intensity)])

    def _each(self, values: Any, power: int, chosen: Bools) -> Floats:
        """Return values of some modes over a power of the unit of their rates."""
        unit = np.broadcast_to(self.rate, chosen.shape)[chosen]
        return np.asarray(np.broadcast_to(values, chosen.shape)[chosen] / unit**power)


def growth_of_white_noise(least: Floats, noise: Floats) -> Floats:
    """Return the growth of second moments 2 e without damping and vibration, from w^2 and s^2."""
    return 2.0 * _excess(least, noise)


def _excess(least: Floats, noise: Floats) -> Floats:
    """Return e > 0 from 4 e (least + e^2) = noise, by Newton's method from above: the cubic is convex there."""
    target = 0.25 * noise
    with np.errstate(divide="ignore", invalid="ignore"):
        linear = np.where(least > 0.0, target / least, np.inf)
        e = np.minimum(linear, np.cbrt(target) + np.sqrt(np.maximum(0.0, -least)))
        for _ in range(_NEWTON):
            slope = 3.0 * e * e + least
            e = np.where(slope > 0.0, (2.0 * e**3 + target) / slope, e)
    return np.asarray(e)


def unevenness_bound(noise: Any, sizes: Sequence[Any], center: Any) -> Any:
    """Return a bound of the last term of d E[U] / dt over E[U], for K = ``center`` + p > 0.

    ``sizes`` bound p and its first three derivatives.  With D = Q^2 - K q^2, h the factor of E[q Q] / sqrt(K), and

        4 K E[q Q] = (2 e + (s^2 - p') / 2 K) E[V] - (2 c + (s^2 - p') / 2 K) E[D] - d E[D] / dt,

    W = U + j D, j = h / 4 K^1.5, has d E[W] / dt = (-2 c + s^2 / 2 K) E[W] + j ((2 e + (s^2 - p') / 2 K) E[V]
    - (2 s^2 - p') / 2 K E[D]) + j' E[D], and abs(D) <= V: a bound that falls with m^6, not m^4.
    """
    size, slope, curve, third = sizes
    least = center - size
    twice, root, driven = 2.0 * least, np.sqrt(least), noise + slope
    g = (noise * size / center + slope) / twice
    change = (curve + driven * slope / least) / twice
    h = g * driven / twice + change
    turn = (third + (2.0 * slope + driven) * curve / least) / twice + driven * np.square(slope / least) / least
    turn = turn + (change * driven + g * (curve + driven * slope / least)) / twice
    j, j_change = 0.25 * h / least, 0.25 * (turn + 1.5 * h * slope / least) / least
    once, again = 1.0 - 0.5 * g / root, 1.0 - 0.5 * g / root - j
    first = h / (2.0 * root * np.where(once > 0.0, once, 1.0))
    second = (j * (0.5 * noise / center + (3.0 * noise + 2.0 * slope) / twice) + j_change) / np.where(
        again > 0.0, again, 1.0
    )
    return np.minimum(np.where(once > 0.0, first, np.inf), np.where(again > 0.0, second, np.inf))


def intensity_of_growth(least: Floats, growth: Floats) -> Floats:
    """Return s of white noise that makes second moments grow so fast without damping and vibration, from w^2."""
    e = 0.5 * growth
    return np.sqrt(np.maximum(0.0, 4.0 * e * (least + np.square(e))))
