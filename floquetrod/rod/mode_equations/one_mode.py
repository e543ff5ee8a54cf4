"""Motion of a rod at finite angles in one mode alone: many starts at once, and the orbits that they lead to.

With the mode's function of unit norm its amplitude a obeys (1 + J a^2) a_tt + J a a_t^2 + 2 c a_t + g(a) - f(t) a = 0,
J from the inertia of shortening, g the slope of the potential energy under the mean force, lift-off at hinged ends
with it, and f the vibration.  That is an estimate, for starts and for a first answer: other modes change it by a
percent or so.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.rod.mode_equations.large_motion import LargeMotion

LARGEST = 0.7  # rad up to which motion is examined: a rod leaves its wall long before
LIMIT = math.radians(40.0)  # rad up to which motion is answered
_DEGREE = 5  # of the slope of the potential energy over a, in a^2
_STEPS = 32  # of Runge and Kutta in a period of the fastest motion: 8e-5 of it a period
_ANGLES, _PHASES = 14, 6  # starts of a search (a choice)
_INSTANTS = 24  # of a period and harmonic of the load, at which the equation holds
_NEWTON = 14
_SAME = 1e-4  # of an amplitude, by which orbits found from two starts may differ


class Driven(NamedTuple):
    """Drive of motions (k, count): rates in rad/s and added stiffness (k, 1), and the vibrating force (k, count)."""

    rate: Floats
    added: Floats
    force: Floats

    def some(self, kept: Any) -> Driven:
        """Return the drive of the motions ``kept``."""
        return Driven(self.rate[kept], self.added[kept], self.force[kept])


class Orbit(NamedTuple):
    """A periodic orbit of one mode.

    Attributes
    ----------
    turns : int
        Periods of the load that it takes.
    states : ndarray (k, 2)
        a in rad (of a function of unit norm) and a_t in rad/s at equal instants from time 0 on.
    amplitude : float
        Largest angle in rad.
    multipliers : ndarray (2,)
        Of deviations in the same mode.
    """

    turns: int
    states: Floats
    amplitude: float
    multipliers: Any

    @property
    def is_stable(self) -> bool:
        """Whether motion in this mode returns to it, or without damping stays near."""
        return bool(np.abs(self.multipliers).max() <= 1.0 + 1e-6)


@dataclass(frozen=True, eq=False)
class OneMode:
    """The equation of one mode of a rod.

    Parameters
    ----------
    motion : LargeMotion
        Of this mode alone.
    """

    motion: LargeMotion

    @cached_property
    def peak(self) -> float:
        """Largest value of the function of unit norm."""
        return float(np.abs(self.motion.shapes.there).max())

    @cached_property
    def hardening(self) -> Floats:
        """Coefficients of g(a) / a in powers of (a / a_max)^2."""
        a = LARGEST / self.peak * np.sin(0.5 * math.pi * (np.arange(40) + 0.5) / 40.0)
        stiffness = self.motion.resting(a[:, None])[:, 0] / a
        return np.polynomial.polynomial.polyfit((a * self.peak / LARGEST) ** 2, stiffness, _DEGREE)

    @cached_property
    def shortening(self) -> float:
        """J, the inertia of shortening."""
        return float(np.sum(self.motion.shortening_inertia[0, 0] ** 2))

    @cached_property
    def _vibration(self) -> Floats:
        """The loss of stiffness under each part of the vibration, (2 H,)."""
        return self.motion.vibrating[:, 0, 0]

    def stiffness(self, a: Any) -> Any:
        """Return g(a) / a in 1/s^2 under the mean force."""
        return np.polynomial.polynomial.polyval(np.minimum((a * self.peak / LARGEST) ** 2, 1.5), self.hardening)

    @property
    def fastest(self) -> float:
        """About the highest frequency of its motion, in rad/s."""
        stiff = np.abs(self.stiffness(np.linspace(0.0, LARGEST, 9) / self.peak)).max()
        return math.sqrt(float(stiff + np.abs(self._vibration).sum()))

    def steps(self, turns: int) -> int:
        """Return how many steps so many periods of the load take."""
        load = self.motion.load
        return turns * math.ceil(_STEPS * max(1.0, self.fastest / load.frequency))

    def marched(self, a: Floats, v: Floats, turns: int, start: Any = 0.0) -> tuple[Floats, Floats, Floats]:
        """Return amplitudes and speeds after so many periods of the load, and the largest amplitudes on the way.

        They begin at times ``start``, one or as many as there are motions.
        """
        steps = self.steps(turns)
        h = turns * 2.0 * math.pi / self.motion.load.frequency / steps
        times = np.add.outer(np.linspace(0.0, h * steps, 2 * steps + 1), start)
        halves = self.motion.parts(times) @ self._vibration
        rate, most = self._acceleration(), np.abs(a)
        for i in range(steps):
            f0, f1, f2 = halves[2 * i : 2 * i + 3]
            k1 = rate(a, v, f0)
            a2, v2 = a + 0.5 * h * v, v + 0.5 * h * k1
            k2 = rate(a2, v2, f1)
            a3, v3 = a + 0.5 * h * v2, v + 0.5 * h * k2
            k3 = rate(a3, v3, f1)
            a4, v4 = a + h * v3, v + h * k3
            k4 = rate(a4, v4, f2)
            a = a + h / 6.0 * (v + 2.0 * (v2 + v3) + v4)
            v = v + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
            most = np.maximum(most, np.abs(a))
        return a, v, most

    def _acceleration(self) -> Callable[[Floats, Floats, Any], Floats]:
        """Return the function that gives a_tt of a, a_t and the force."""
        last, *others = self.hardening[::-1].tolist()
        unit, j, c = (self.peak / LARGEST) ** 2, self.shortening, 2.0 * self.motion.rod.damping_rate

        def rate(a: Floats, v: Floats, force: Any) -> Floats:
            squared = a * a
            x = np.minimum(unit * squared, 1.5)
            stiff = last
            for each in others:
                stiff = stiff * x + each
            slowed: Floats = -((stiff - force + j * (v * v)) * a + c * v) / (1.0 + j * squared)
            return slowed

        return rate

    def multipliers_of_rest(self, turns: int) -> Any:
        """Return the multipliers of small motion."""
        return np.linalg.eigvals(self._map(np.zeros(1), np.zeros(1), turns)[2][..., 0])

    def _map(self, a: Floats, v: Floats, turns: int) -> tuple[Floats, Floats, Floats]:
        """Return the states after so many periods, and their derivatives with those before, (2, 2, k)."""
        da = 1e-6 * LARGEST / self.peak
        dv = da * self.fastest
        starts = np.concatenate([a, a + da, a, a - da, a]), np.concatenate([v, v, v + dv, v, v - dv])
        after_a, after_v = (part.reshape(5, -1) for part in self.marched(*starts, turns)[:2])
        by_a = np.stack([after_a[1] - after_a[3], after_v[1] - after_v[3]]) / (2.0 * da)
        by_v = np.stack([after_a[2] - after_a[4], after_v[2] - after_v[4]]) / (2.0 * dv)
        return after_a[0], after_v[0], np.stack([by_a, by_v], axis=1)

    def orbits(self, turns: int) -> list[Orbit]:
        """Return the orbits found of so many periods of the load, by Newton's method from many starts, smallest first.

        A search, not a proof: of orbits that differ by sign or by whole periods of the load one is returned.  The
        equation of motion holds at equally spaced instants; derivatives are taken of the Fourier series through them.
        """
        load, count = self.motion.load, self.instants(turns)
        times = turns * 2.0 * math.pi / load.frequency * np.arange(count) / count
        a = self._starts(times, turns)
        force = np.broadcast_to(self.motion.parts(times) @ self._vibration, a.shape)
        rate = load.frequency / turns
        a, _ = self.solved(a, Driven(np.full((len(a), 1), rate), np.zeros((len(a), 1)), force))
        return self._apart(a, rate * (a @ derivative(count).T), turns)

    def instants(self, turns: int) -> int:
        """Return at how many instants of so many periods of the load the equation holds."""
        return _INSTANTS * turns * len(self.motion.load.harmonics)

    def solved(self, a: Floats, driven: Driven) -> tuple[Floats, Any]:
        """Return the periodic motions (m, count) to which Newton's method converges, and the indices of their starts.

        Starts are the rows of ``a``.  Motions at rest and motions too large are left out.
        """
        first = derivative(a.shape[1])
        second, start = first @ first, np.arange(len(a))
        amplitudes, origins = [a[:0]], [start[:0]]
        with np.errstate(all="ignore"):
            for _ in range(_NEWTON):
                missed, slope = self.missed(a, first, second, driven)
                try:
                    step = np.linalg.solve(slope, -missed[..., None])[..., 0]
                except np.linalg.LinAlgError:
                    step = -missed / np.abs(slope).max()
                moved = np.abs(step).max(axis=1)
                a = a + step * np.minimum(1.0, 0.1 * LARGEST / self.peak / np.maximum(moved, 1e-300))[:, None]
                kept = np.isfinite(a).all(axis=1) & (np.abs(a).max(axis=1) * self.peak < 1.2 * LARGEST)
                ends = moved < 1e-8  # the step after this one would be below rounding
                amplitudes.append(a[kept & ends])
                origins.append(start[kept & ends])
                on = kept & ~ends
                a, start, driven = a[on], start[on], driven.some(on)
                if not len(a):
                    break
        a, start = np.concatenate(amplitudes), np.concatenate(origins)
        moves = np.abs(a).max(axis=1) * self.peak > 1e-3
        return a[moves], start[moves]

    def equilibria(self) -> list[Orbit]:
        """Return the angles but 0 at which a constant force holds the mode, as orbits of a period, smallest first."""
        roots = np.polynomial.polynomial.polyroots(self.hardening)
        squares = np.sort(roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0) & (roots.real < 1.0)].real)
        slope = np.polynomial.polynomial.polyder(self.hardening)
        period, c = 2.0 * math.pi / self.motion.load.frequency, self.motion.rod.damping_rate
        orbits = []
        for x in squares.tolist():
            stiff = 2.0 * x * float(np.polynomial.polynomial.polyval(x, slope))
            rates = -c + np.array([1.0, -1.0]) * np.emath.sqrt(c * c - stiff)
            angle = math.sqrt(x) * LARGEST
            states = np.tile([angle / self.peak, 0.0], (_INSTANTS, 1))
            orbits.append(Orbit(1, states, angle, np.exp(rates * period)))
        return orbits

    def _starts(self, times: Floats, turns: int) -> Floats:
        """Return harmonic motions of many sizes and phases, as fast as free motion of that size about is."""
        size = LARGEST * (np.arange(_ANGLES) + 0.5) / _ANGLES / self.peak
        free = np.sqrt(np.maximum(self.stiffness(0.8 * size), 0.0)) * turns / self.motion.load.frequency
        phases, histories = 2.0 * math.pi * (np.arange(_PHASES) + 0.5) / _PHASES, []
        for a, ratio in zip(size.tolist(), free.tolist(), strict=True):
            for k in {max(1, round(ratio + shift)) for shift in (-0.4, 0.0, 0.4)}:
                if turns == 1 or k % 2:
                    angle = k * self.motion.load.frequency / turns * times
                    histories.append(a * np.cos(angle + phases[:, None]))
        return np.concatenate(histories) if histories else np.empty((0, len(times)))

    def missed(self, a: Floats, first: Floats, second: Floats, driven: Driven) -> tuple[Floats, Floats]:
        """Return by how much motions a (k, count) miss the equation, and the derivatives of that."""
        rate, v, w = driven.rate, driven.rate * (a @ first.T), driven.rate**2 * (a @ second.T)
        stiff = self.stiffness(a) + driven.added - driven.force
        inertia, drag, diagonal = self.beside(a, v, w, stiff)
        slope = (inertia * rate**2)[..., None] * second + (drag * rate)[..., None] * first
        slope[:, np.arange(a.shape[1]), np.arange(a.shape[1])] += diagonal
        j, c = self.shortening, self.motion.rod.damping_rate
        return inertia * w + (j * a * v + 2.0 * c) * v + stiff * a, slope

    def beside(self, a: Floats, v: Floats, w: Floats, stiff: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the factors of b_tt, b_t and b in the equation of small deviations b from motions a, a_t, a_tt.

        ``stiff`` is the stiffness of the motions at each instant, g(a) / a less the vibration.
        """
        j, c = self.shortening, self.motion.rod.damping_rate
        x = np.minimum((self.peak / LARGEST * a) ** 2, 1.5)
        polynomial = np.polynomial.polynomial
        stiffening = 2.0 * x * polynomial.polyval(x, polynomial.polyder(self.hardening))
        return 1.0 + j * a * a, 2.0 * (j * a * v + c), 2.0 * j * a * w + j * v * v + stiff + stiffening

    def _apart(self, a: Floats, v: Floats, turns: int) -> list[Orbit]:
        """Return the distinct orbits, smallest first, from angles ``a`` and rates ``v`` (orbits, instants)."""
        if not a.size:
            return []
        most = self.marched(a[:, 0], v[:, 0], turns)[2] * self.peak
        order = np.argsort(most)
        order = order[np.diff(most[order], prepend=0.0) > _SAME * most[order]]
        slope = self._map(a[order, 0], v[order, 0], turns)[2]
        return [
            Orbit(turns, np.stack([a[k], v[k]], axis=1), float(most[k]), np.linalg.eigvals(slope[..., i]))
            for i, k in enumerate(order.tolist())
        ]

    def may_resonate(self, turns: int) -> bool:
        """Return whether free motion up to the largest angle may be as fast as the turns-th part of the load."""
        stiff = self.stiffness(np.linspace(0.0, LARGEST, 33) / self.peak)
        half, spread = math.pi / turns, float(np.abs(self._vibration).sum())
        wanted = (half / math.pi * self.motion.load.frequency) ** 2
        return bool(stiff.min() - spread < wanted < stiff.max() + spread)


@functools.cache
def derivative(count: int) -> Floats:
    """Return the matrix from an even number of samples of a function of period 2 pi to samples of its derivative."""
    k = np.arange(1, count)
    column = np.concatenate([[0.0], 0.5 * (-1.0) ** k / np.tan(math.pi * k / count)])
    return np.asarray(column[(np.arange(count)[:, None] - np.arange(count)) % count])
