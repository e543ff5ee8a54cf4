"""Modes under a force that is partly random: the second moments of each, and a bound of their growth.

Mode m of a rod with hinged ends obeys q'' + 2 c q' + (w^2 + p(t)) q = s q xi, with s^2 = S k^2 / 2 from the one-sided
density S of the force at twice the mode's frequency, and k what a newton of compression takes from the stiffness.

With Q = q' + a q, K = w^2 + a^2 - 2 a c + p, V = Q^2 + K q^2 and a = c + s^2 / 4 (w^2 - c^2),

    U = (V - g q Q) / sqrt(K),   g = s^2 / 2 (w^2 - c^2) - (p' + s^2) / 2 K,
    d E[U] / dt = (-2 c + s^2 / 2 K) E[U] + (g (p' + s^2) / 2 K - g') E[q Q] / sqrt(K),

and abs(q Q) <= V / 2 sqrt(K): between these bounds second moments grow where K is positive.  Without p they are sharp:
2 c against s^2 / 2 w^2, except for c^2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Bools, Floats
from floquetrod.equations import HillSystem, SecondMoments, second_moments
from floquetrod.rod.loads.load import Load, Loads, density_at, largest_density
from floquetrod.rod.model.constants import MOST_MODES, ModeConstants


class Parts(NamedTuple):
    """What the equations of modes under loads are made of, each (loads, modes) or what broadcasts to it.

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
    """

    squared: Floats
    waves: tuple[NDArray[np.complex128], ...]
    frequency: Floats
    intensity: Floats
    damping: float
    unit: float | None = None

    @property
    def growth_bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bound of the growth of second moments in 1/s, infinite where none is known."""
        noise, least = np.square(self.intensity), self.squared - self.damping**2
        held = least > 0.0
        least = np.where(held, least, 1.0)
        size, slope, curve = (self._size(power) for power in (0, 1, 2))
        middle = least + np.square(0.25 * noise / least)
        held &= middle > size
        low = np.where(held, middle - size, 1.0)
        off = np.where(held, _unevenness(noise, middle - least + size, slope, curve, low), np.inf)
        return 0.5 * noise / (middle + size) - 2.0 * self.damping - off, 0.5 * noise / low - 2.0 * self.damping + off

    def _size(self, power: int) -> Floats:
        """Return a bound of p, of p' or of p''."""
        turns = ((k * self.frequency) ** power * np.abs(wave) for k, wave in enumerate(self.waves, start=1))
        found: Any = sum(turns, np.zeros_like(self.squared))
        return np.asarray(found)

    @property
    def rate(self) -> Floats:
        """The unit of time of `moments`, by its inverse in 1/s."""
        if self.unit is not None:
            return np.full_like(self.squared, self.unit)
        return np.asarray(np.sqrt(np.maximum(np.abs(self.squared), 1e-12 * np.square(self.frequency))))

    def moments(self, chosen: Bools) -> SecondMoments:
        """Return the second moments of some modes as a batch, in the order of C, in units of time in which w is 1."""

        def each(values: Any, power: int) -> Floats:
            unit = np.broadcast_to(self.rate, chosen.shape)[chosen]
            return np.asarray(np.broadcast_to(values, chosen.shape)[chosen] / unit**power)

        waves = [each(wave, 2)[:, None, None] for wave in self.waves]
        system = HillSystem(
            each(self.squared, 2)[:, None, None],
            [wave.real for wave in waves],
            [-wave.imag for wave in waves],
            damping=2.0 * each(self.damping, 1)[:, None, None],
            period=2.0 * math.pi / each(self.frequency, 1),
        )
        return second_moments(system, [([[1.0]], each(self.intensity, 1) * np.sqrt(each(1.0, 1)))])


@dataclass(frozen=True, eq=False)
class NoisyModes:
    """The independent modes of a rod under loads of a kind that has noise.

    Attributes
    ----------
    constants : ModeConstants
        Of the rod, on the side of the channel where it lies.
    like : Load
        Gives waveform and noise.
    """

    constants: ModeConstants
    like: Load

    def parts(self, loads: Loads, modes: Any) -> Parts:
        """Return the equations of some modes under flat loads."""
        constants, m2 = self.constants, np.square(np.asarray(modes, dtype=float))
        mean, amplitude, frequency = (values[:, None] for values in loads.flat)
        per_newton = constants.per_newton * (m2 - constants.held)
        squared = constants.bending * m2 * m2 - per_newton * mean + constants.pendulum_squared
        at = np.sqrt(np.maximum(squared, 0.0)) / math.pi  # twice the mode's frequency, in Hz
        intensity = np.abs(per_newton) * np.sqrt(0.5 * density_at(self.like.noise, at))
        waves = tuple(-per_newton * amplitude * h for h in self.like.harmonics.tolist())
        return Parts(squared, waves, frequency, intensity, float(constants.damping_rate))

    def left_out(self, load: Load, last: int) -> float:
        """Return a bound in 1/s on the growth of the second moments of all modes beyond one; infinite without any.

        For x = m^2 from (last + 1)^2 on k <= c2 g x, g = 1 + abs(h) / x: every term of the bound falls with x.
        """
        bending, per_newton, pendulum_squared, held, c = (float(part) for part in self.constants)
        x = float(last + 1) ** 2
        sizes = np.abs(self.like.harmonics) * load.amplitude
        turns = load.frequency * np.arange(1, sizes.size + 1)
        g = 1.0 + abs(held) / x
        size, slope, curve = (per_newton * g * x * float((sizes * turns**power).sum()) for power in (0, 1, 2))
        softer = per_newton * g * x * max(0.0, load.mean) + size + max(0.0, -pendulum_squared) + c * c
        least = bending * x * x - softer
        if not least > 0.0:
            return math.inf
        density = largest_density(load.noise, math.sqrt(least) / math.pi)
        noise = 0.5 * density * (per_newton * g * x) ** 2
        off = _unevenness(noise, size + (0.25 * noise / least) ** 2, slope, curve, least)
        return -2.0 * c + 0.5 * noise / least + float(off)

    def growth_beyond(self, loads: Loads) -> Floats:
        """Return growth rates in 1/s that the second moments of the highest mode of all have at least, or 0."""
        return np.maximum(0.0, self.parts(loads, [MOST_MODES]).growth_bounds[0][:, 0])

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth in mean square of all others.

        Beyond the band of the noise it is that without noise.  White noise makes all high modes grow or decay alike:
        where they grow, see `growth_beyond`, the bound is loose.
        """
        first, plain = self.constants.modes_needed(load, growth_tolerance)
        beyond = _least(lambda last: not largest_density(load.noise, self._lowest(load, last)), first)
        limit = self.left_out(load, MOST_MODES)
        loose = 2.0 * (max(0.0, limit) + float(self.constants.damping_rate))
        target = growth_tolerance if limit < growth_tolerance else loose
        last = _least(lambda last: self.left_out(load, last) <= target, first)
        if beyond is not None and (last is None or beyond <= last):
            return beyond, 2.0 * plain
        if last is None:
            raise wrong_value("load", f"needs more than {MOST_MODES} modes for its noise; check the units")
        return last, max(0.0, self.left_out(load, last))

    def _lowest(self, load: Load, last: int) -> float:
        """Return a frequency in Hz below twice those of all modes beyond one."""
        x = float(last + 1) ** 2
        bending, per_newton, pendulum_squared, held, _ = (float(part) for part in self.constants)
        squared = bending * x * x - per_newton * (x + abs(held)) * max(0.0, load.mean) + min(0.0, pendulum_squared)
        return math.sqrt(max(0.0, squared)) / math.pi


def _unevenness(noise: Any, size: Any, slope: Any, curve: Any, least: Any) -> Any:
    """Return a bound of what the last term of d E[U] / dt adds to the rate, K being ``least`` at least.

    ``size`` bounds the distance of K from w^2 - c^2, ``slope`` and ``curve`` p' and p''.
    """
    g = (noise * size / least + slope) / (2.0 * least)
    change = (curve + (slope + noise) * slope / least) / (2.0 * least)
    room = 1.0 - g / (2.0 * np.sqrt(least))
    found = (g * (slope + noise) / (2.0 * least) + change) / (2.0 * np.sqrt(least) * np.where(room > 0.0, room, 1.0))
    return np.where(room > 0.0, found, np.inf)


def _least(holds: Callable[[int], bool], first: int) -> int | None:
    """Return the least number of modes, from the first on, for which something holds that then holds for all more."""
    if not holds(MOST_MODES):
        return None
    low, high = first - 1, first
    while not holds(high):
        low, high = high, min(2 * high, MOST_MODES)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
