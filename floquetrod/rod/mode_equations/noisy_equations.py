"""Modes under a force that is partly random: the second moments of each, and bounds of their growth.

Mode m of a rod with hinged ends obeys q'' + 2 c q' + (w^2 + p(t)) q = s q xi, with s^2 = S k^2 / 2 from the one-sided
density S of the force at twice the mode's frequency, and k what a newton of compression takes from the stiffness.

With e > 0 from 4 e (w^2 - c^2 + e^2) = s^2, Q = q' + (c + e) q, K0 = w^2 - c^2 + e^2, K = K0 + p, V = Q^2 + K q^2,

    U = (V - g q Q) / sqrt(K),   g = s^2 / 2 K0 - (p' + s^2) / 2 K,
    d E[U] / dt = (-2 c + s^2 / 2 K) E[U] + (g (p' + s^2) / 2 K - g') E[q Q] / sqrt(K),

and abs(q Q) <= V / 2 sqrt(K): where K is positive, second moments grow over a period at the mean of the first bracket,
plus a term bounded by the second.  The mean of 1 / K lies between 1 / K0 + v / K0^2 (K0 +- max abs(p)), v the mean of
p^2.  Without p both bounds are sharp: second moments grow at -2 c + 2 e, which is zero at s^2 = 4 c w^2.

High modes under white noise grow at -2 c + S c2^2 / 4 c1 in the limit, c1 and c2 of `ModeConstants`, which they
approach from above under a compression and from below under tension: the fastest may have any number, or be none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats, Ints
from floquetrod.rod.loads.load import Load, Loads, density_at, largest_density
from floquetrod.rod.mode_equations.moment_coefficients import ModeCoefficients, unevenness_bound
from floquetrod.rod.mode_equations.narrow_noise import Densities, Excess, densities_about, excess_below
from floquetrod.rod.mode_equations.slow_noise import least_intensities
from floquetrod.rod.model.constants import MOST_MODES, NEGLIGIBLE_GROWTH, ModeConstants

_SINGLE = 64  # modes each with a bound of its own (a choice)
_WIDER = 1.125  # numbers of modes at both ends of a block of higher ones (a choice)
_EXAMINED = 128  # modes at most that a growth rate needs, the rest of which is in its error (a choice)
_NEGLIGIBLE = 1e-10  # growth beside that of others, in terms of damping and of the limit of high modes (a choice)

IN_MEAN_SQUARE = (
    "growth is that of second moments, twice that of amplitudes: the verdict is in mean square, and single runs "
    "usually grow more slowly, or decay, as few large ones make the average"
)

ASSUMED = (
    IN_MEAN_SQUARE,
    "the random force acts on each mode as white noise of its density at twice the mode's frequency (Ito's sense and "
    "Stratonovich's are the same); where it is uneven there, or slow noise changes the stiffness, the growth is known "
    "between two rates",
)
"""What is assumed of noise."""


def _blocks() -> Ints:
    """Return the first mode of each block of high modes; the last block has no end."""
    count = math.ceil(math.log(MOST_MODES / (_SINGLE + 1)) / math.log(_WIDER))
    return np.unique(np.geomspace(_SINGLE + 1, MOST_MODES, count).round().astype(np.int64))


_FIRST = _blocks()
_EVERY = np.append(np.arange(1, _SINGLE + 1), _FIRST)


@dataclass(frozen=True, eq=False)
class NoisyModes:
    """The independent modes of a rod under loads of a kind that has noise.

    Attributes
    ----------
    constants : ModeConstants
        Of the rod, on the side of the channel where it lies.
    template : Load
        Gives waveform and noise.
    """

    constants: ModeConstants
    template: Load

    def parts(self, loads: Loads, modes: Any) -> ModeCoefficients:
        """Return the equations of some modes under flat loads; slow noise counts as white noise that acts as it does.

        That is of no less intensity than makes them grow as fast as they grow at least as their stiffness drifts.
        """
        alone = self.without_drift(loads, modes)
        if not isinstance(self.template.noise, tuple):
            return alone
        least = least_intensities(alone, self.excess(alone), self.template.noise)
        return alone._replace(least=least, intensity=np.maximum(alone.intensity, least))

    def without_drift(self, loads: Loads, modes: Any) -> ModeCoefficients:
        """Return the equations of some modes under flat loads, with the density at twice their frequency."""
        constants, m2 = self.constants, np.square(np.asarray(modes, dtype=float))
        mean, amplitude, frequency = (values[:, None] for values in loads.flat)
        per_newton = constants.per_newton * (m2 - constants.neutral_squared)
        squared = constants.bending * m2 * m2 - per_newton * mean + constants.restoring
        waves = tuple(-per_newton * amplitude * h for h in self.template.harmonics.tolist())
        damping_rate = float(constants.damping_rate)
        parts = ModeCoefficients(squared, waves, frequency, np.zeros_like(squared), damping_rate, per_newton=per_newton)
        return parts.with_density(density_at(self.template.noise, parts.hertz))

    def densities(self, parts: ModeCoefficients) -> Densities:
        """Return between which densities noise that may be uneven acts on modes, (loads, modes)."""
        w = math.pi * parts.hertz
        gain = np.divide(0.25 * np.abs(parts.per_newton), w, out=np.zeros_like(w), where=w > 0.0)
        return densities_about(self.template.noise, parts.hertz, gain)

    def excess(self, parts: ModeCoefficients) -> Excess:
        """Return by how much noise below twice the frequencies of modes exceeds that there, (loads, modes)."""
        return excess_below(self.template.noise, parts.reference)

    def limit(self) -> float:
        """Return the growth in 1/s that high modes approach, -2 c where the density ends."""
        bending, per_newton, _, _, c = (float(part) for part in self.constants.equation)
        density = 0.0 if isinstance(self.template.noise, tuple) else float(self.template.noise)
        return 0.25 * density * per_newton**2 / bending - 2.0 * c

    def growth_bounds(self, loads: Loads) -> GrowthBounds:
        """Return bounds on the growth of all modes under flat loads."""
        parts = self.parts(loads, np.arange(1, _SINGLE + 1))
        low, single = parts.growth_bounds
        together = self._together(loads)
        if isinstance(self.template.noise, tuple):  # beyond its band modes grow as without noise
            strongest = self.template.with_numbers(*(float(values.max()) for values in loads.flat))
            quiet, plain = self.constants.modes_needed(strongest, 0.0)
            single, together = (
                np.where((first > quiet) & (density == 0.0), np.minimum(high, 2.0 * plain), high)
                for first, density, high in (
                    (np.arange(1, _SINGLE + 1), np.square(parts.intensity), single),
                    (_FIRST, self._densities(loads, _FIRST.astype(float) ** 2), together),
                )
            )
        every = np.concatenate([single, together], axis=1)
        beyond = np.maximum.accumulate(every[:, ::-1], axis=1)[:, ::-1]
        negligible = NEGLIGIBLE_GROWTH + _NEGLIGIBLE * (self.limit() + 2.0 * float(self.constants.damping_rate))
        return GrowthBounds(low, single, beyond, self.limit(), negligible)

    def _together(self, loads: Loads) -> Floats:
        """Return bounds on the growth of all modes of each block, (loads, blocks).

        With u = 1 / m^2 the growth without p is at most -2 c + S k^2 / 4 w^2 where that is positive, and with w^2 - c^2
        for w^2 wherever; k^2 / w^2 = c2^2 (1 - h u)^2 / (c1 - c2 F u (1 - h u) + Omega^2 u^2) has one maximum or none.
        What p adds to it falls with m^2 from the first mode of a block on, where k <= c2 m^2 (1 + abs(h) / m^2).
        """
        bending, per_newton, restoring, neutral_squared, c = (float(part) for part in self.constants.equation)
        mean, amplitude, frequency = (values[:, None] for values in loads.flat)
        x = _FIRST.astype(float) ** 2
        near, far = 1.0 / x, np.append(1.0 / np.square(_FIRST[1:] - 1.0), 0.0)
        density = self._densities(loads, x)

        def largest_share(pendulum: float) -> Floats:
            """Return the largest k^2 / w^2, infinite where w^2 is not positive."""
            linear, square = -per_newton * mean, pendulum + per_newton * mean * neutral_squared
            with np.errstate(divide="ignore", invalid="ignore"):
                at = -(2.0 * neutral_squared * bending + linear) / (2.0 * square + neutral_squared * linear)
                lowest = -0.5 * linear / square
            found: Any = 0.0
            least: Any = math.inf
            for turn in (at, lowest):
                for u in (near, far, np.clip(np.nan_to_num(turn), far, near)):
                    below = bending + linear * u + square * u * u
                    least = np.minimum(least, below)
                    found = np.maximum(found, (1.0 - neutral_squared * u) ** 2 / np.where(below > 0.0, below, 1.0))
            return np.where(least > 0.0, per_newton**2 * found, np.inf)

        with np.errstate(invalid="ignore"):  # no noise times infinity
            share, damped = (
                np.where(density > 0.0, 0.25 * density * largest_share(pendulum), 0.0) - 2.0 * c
                for pendulum in (restoring, restoring - c * c)
            )
        plain = np.minimum(np.maximum(share, 0.0), damped)
        k = per_newton * (x + abs(neutral_squared))
        sizes, turns = np.abs(self.template.harmonics), np.arange(1, self.template.harmonics.size + 1)
        # waves[n] bounds the n-th derivative of the vibrating part of the stiffness, in 1/s^(2 + n), at a block's first
        # mode.
        waves = [k * amplitude * frequency**n * float((sizes * turns**n).sum()) for n in range(4)]
        mean_square = 0.5 * np.square(k * amplitude) * float(np.square(sizes).sum())
        # The stiffness less c^2 without vibration, from below; noise is S k^2 / 2.
        center = bending * x * x - k * np.maximum(0.0, mean) - max(0.0, -restoring) - c * c
        known = center > waves[0]
        center, waves[0] = np.where(known, center, 1.0), np.where(known, waves[0], 0.0)
        noise = 0.5 * density * k * k
        most = 0.5 * noise * mean_square / (center * center * (center - waves[0])) + unevenness_bound(
            noise, waves, center
        )
        return np.where(known, plain + most, np.inf)

    def _densities(self, loads: Loads, x: Floats) -> Floats:
        """Return the largest density at twice the frequencies of all modes from m^2 = ``x`` on, (loads, modes)."""
        bending, per_newton, restoring, neutral_squared, _ = (float(part) for part in self.constants.equation)
        push = per_newton * np.maximum(0.0, loads.flat[0])[:, None]
        squared = bending * x * x - push * (x + abs(neutral_squared)) + min(0.0, restoring)
        return largest_density(self.template.noise, np.sqrt(np.maximum(0.0, squared)) / math.pi)

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth in mean square of all others.

        A tolerance below zero asks for all modes that may decay more slowly than that, of the first `_EXAMINED`.
        """
        bounds = self.growth_bounds(Loads.single(load))
        last = (
            bounds.modes_needed(bounds.least, growth_tolerance)
            if growth_tolerance >= 0.0
            else bounds.modes_above(np.array([growth_tolerance]))
        )
        return int(last[0]), max(0.0, float(bounds.left_out(last)[0]))


class GrowthBounds(NamedTuple):
    """Bounds in 1/s on the growth of second moments of all modes under loads.

    Attributes
    ----------
    low, high : ndarray
        Of each of the first modes, (loads, modes).
    beyond : ndarray
        Upper bound for each of the first modes, then for blocks of modes, and all above, (loads, modes and blocks).
    limit : float
        Growth that high modes approach.
    negligible : float
        Growth below which a mode counts as not growing.
    """

    low: Floats
    high: Floats
    beyond: Floats
    limit: float
    negligible: float

    @property
    def least(self) -> Floats:
        """Lower bound for the fastest mode, or the limit of high ones."""
        return np.asarray(np.maximum(self.low.max(axis=1), self.limit))

    def some(self, chosen: Ints) -> GrowthBounds:
        """Return the bounds under the chosen loads."""
        return self._replace(low=self.low[chosen], high=self.high[chosen], beyond=self.beyond[chosen])

    def left_out(self, last: Ints) -> Floats:
        """Return a bound for all modes beyond one, for each load."""
        block = np.searchsorted(_EVERY, last + 1, side="right") - 1
        return np.asarray(self.beyond[np.arange(last.size), block])

    def modes_needed(self, fastest: Floats, growth_tolerance: float) -> Ints:
        """Return how many modes to examine where one is known that grows so fast, for each load.

        All that may grow faster than the tolerance, as far as these have an end, and than the fastest known.  Where the
        verdict is known without, no more than `_EXAMINED`.
        """
        decisive, loosely = (
            self._modes_beyond_which(np.full(fastest.shape, max(growth_tolerance, least)))
            for least in (0.0, 2.0 * NEGLIGIBLE_GROWTH)
        )
        decisive = np.where(decisive > MOST_MODES, loosely, decisive)
        sharp = self.modes_above(np.maximum(fastest, 0.0))
        some = np.where(fastest > growth_tolerance, np.minimum(decisive, _EXAMINED), decisive)
        highest = np.where(self.low.max(axis=1) > self.limit, self.low.argmax(axis=1) + 1, 1)
        return np.maximum(np.where(decisive > MOST_MODES, highest, some), sharp)

    def modes_above(self, growth: Floats) -> Ints:
        """Return how many modes may grow, by more than is negligible, faster than that; `_EXAMINED` at most."""
        return np.minimum(self._modes_beyond_which(growth + self.negligible), _EXAMINED)

    def _modes_beyond_which(self, growth: Floats) -> Ints:
        """Return after how many modes, one at least, none grows faster, for each load; more than all where some may."""
        slow = self.beyond <= growth[:, None]
        return np.maximum(1, np.where(slow.any(axis=1), _EVERY[slow.argmax(axis=1)] - 1, MOST_MODES + 1))
