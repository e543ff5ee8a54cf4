"""The mean force along a string in a well: its weight, and friction against the wall that it is pressed to.

With the compression F, the weight in fluid w, the inclination phi and the curvatures kappa_n and kappa_b,

    dF/ds = w cos(phi) - mu N,    N = hypot(w sin(phi) + F kappa_n, F kappa_b) + h F^2 R / (4 E I),

downwards along a string that is pushed; pulled, friction changes its sign, and a string that stands has none.  h is 1
where a pushed string has buckled into a helix, else 0.  The string lies on the wall with its weight until F^2 R / (4 E
I) exceeds the first term of N: there it begins to snake, and at twice that, by energy, a helix is possible.

F = S tan(y) with the critical force S of a level hole is integrated for y, from the lower end up.  Where a helix locks
up F becomes infinite, and y passes through pi/2 as smoothly as anywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.caching import cached_property
from floquetrod.wells.arcs import Floats, Points
from floquetrod.wells.path import WellPath

HELICAL = {"energy": 2.0, "loading": 1.83**2, "alone": 8.0, "always": 0.0}
"""Criteria of a helix by name: F^2 R / (4 E I) over the contact force of the string that lies, from which on one forms.

In a straight well sqrt(2) (Chen, Lin & Cheatham 1990), 1.83 (Wu & Juvkam-Wold 1993) and 2 sqrt(2) (Mitchell 1996) times
the critical force; or wherever the string is compressed.  The first follows by energy in bent wells too
(docs/theory/mean_force.md), the other two are taken to keep their ratio to it.
"""


class Effort(NamedTuple):
    """How finely forces are integrated: relative tolerance, and least number of steps between stations.

    Of all strings, or of each its own, (n,).
    """

    tolerance: Any
    steps: Any


CHECKED, FAST, SOUGHT = Effort(np.array([1e-12, 1e-10]), np.array([2, 1])), Effort(1e-8, 1), Effort(1e-6, 1)
"""Of one string, and what it is compared with, whose error is the difference; of many strings; of a depth sought."""

LOCKED = 0.5 * math.pi
"""The y from which on the force is infinite."""

_NEARLY = LOCKED - 1e-13  # to rounding
_LEAST = 1e-3  # cos^2 y below which a wave is not damped any more: it has ended long before (a choice)

MOTIONS = {"pushed": 1.0, "standing": 0.0, "pulled": -1.0}
"""Ways in which a string moves, and the sign of friction upwards."""


@dataclass(frozen=True)
class Pipe:
    """What the mean force needs of a string.

    Attributes
    ----------
    rigidity : float
        E I in N m^2.
    weight : float
        Weight in fluid in N/m.
    clearance : float
        R in m.
    """

    rigidity: float
    weight: float
    clearance: float

    @cached_property
    def scale(self) -> float:
        """S, the critical force in a level hole, in N."""
        return 2.0 * math.sqrt(self.rigidity * self.weight / self.clearance)

    def lying(self, force: Floats, place: Place) -> Floats:
        """Return the contact force in N/m of the string that lies on the wall under a compression in N."""
        bent = self.weight * place.sine + force * place.kappa_n
        return np.asarray(np.hypot(bent, force * place.kappa_b))

    def helix(self, force: Floats) -> Floats:
        """Return what a helix adds to the contact force, F^2 R / (4 E I), in N/m."""
        return np.asarray(np.maximum(force, 0.0) ** 2 * self.clearance / (4.0 * self.rigidity))


class Place(NamedTuple):
    """A well at measured depths: sine and cosine of the inclination, and curvatures in 1/m."""

    sine: Any
    cosine: Any
    kappa_n: Any
    kappa_b: Any

    @classmethod
    def at(cls, points: Points) -> Place:
        """Return a well at points of its arcs."""
        return cls(*points.seen)


@dataclass(frozen=True)
class Friction:
    """Coefficients of friction, each from a measured depth in m to the next."""

    depths: tuple[float, ...]
    values: tuple[float, ...]

    def __str__(self) -> str:
        """Return, say, "0.2", or "0.2, 0.35 from 1500 m on"."""
        pairs = zip(self.values, self.depths, strict=True)
        return ", ".join(f"{value:g} from {depth:g} m on" if depth else f"{value:g}" for value, depth in pairs)

    @property
    def largest(self) -> float:
        """The largest coefficient."""
        return max(self.values)

    def at(self, depth: NDArray[np.float64]) -> Floats:
        """Return the coefficient at measured depths, that below on a boundary."""
        place = np.searchsorted(self.depths, depth, side="right") - 1
        return np.asarray(self.values)[np.maximum(place, 0)]


FRICTIONLESS = Friction((0.0,), (0.0,))


@dataclass(frozen=True)
class Shaking:
    """A wave that runs along the string from a tool, and what is left of friction.

    By energy: a wave whose velocity V exceeds the speed v of sliding loses (2 / pi) mu N sqrt(V^2 - v^2) a length, and
    so W = sqrt(V^2 - v^2) falls by 2 mu N / (pi Z) a length, Z = A_s sqrt(E rho); below v it loses nothing.

    Attributes
    ----------
    impedance : float
        Z in N s/m.
    speed : float
        v in m/s.
    source : float
        V in m/s where the wave leaves the tool.
    above_end : float
        Distance of the tool from the lower end of the string in m.
    """

    impedance: float
    speed: float
    source: float
    above_end: float = 0.0

    @property
    def wave(self) -> float:
        """W in m/s at the tool."""
        return math.sqrt(max(self.source**2 - self.speed**2, 0.0))

    def speed_of(self, wave: Floats) -> Floats:
        """Return the amplitude V in m/s for W: from that of sliding on friction takes nothing from a wave."""
        return np.asarray(np.hypot(np.maximum(wave, 0.0), min(self.speed, self.source)))

    def left(self, wave: Floats) -> Floats:
        """Return mean friction over that without vibration, (2 / pi) asin(v / V), for W in m/s."""
        return np.asarray(2.0 / math.pi * np.arctan2(self.speed, np.maximum(wave, 0.0)))


class Strings(NamedTuple):
    """Strings in one well: measured depths of their ends in m, and y and W at the lower one, (n,) each."""

    top: Floats
    bottom: Floats
    y: Floats
    wave: Floats


class States(NamedTuple):
    """Y and W of strings at measured depths, (m, n), NaN where a string is not; and at their upper ends, (n,)."""

    depth: Floats
    y: Floats
    wave: Floats
    top_y: Floats
    top_wave: Floats


@dataclass(frozen=True)
class Drag:
    """Mean force along strings of one pipe in one well."""

    path: WellPath
    pipe: Pipe
    friction: Friction
    motion: str = "pushed"
    helical: str = "energy"
    shaking: Shaking | None = None

    def force(self, y: Floats) -> Floats:
        """Return the compression in N, infinite from y = pi / 2 on."""
        below = np.minimum(y, _NEARLY)
        return np.where(y > below, math.inf, self.pipe.scale * np.tan(below))

    def y_of(self, force: Floats) -> Floats:
        """Return what stands for a compression in N."""
        return np.asarray(np.arctan(force / self.pipe.scale))

    def is_helix(self, place: Place, y: Floats) -> NDArray[np.bool_]:
        """Return whether strings are wound into a helix."""
        return np.asarray(self.wants_helix(place, y) >= 0.0)

    def wants_helix(self, place: Place, y: Floats) -> Floats:
        """Return what is zero or more where a string is wound into a helix, which only one that is pushed is."""
        if self.motion != "pushed":
            return np.full(y.shape, -1.0)
        sine, cosine = np.sin(y), np.cos(y)
        lying = self._lying(place, sine, cosine)
        return np.asarray(sine * np.abs(sine) * self.pipe.weight - HELICAL[self.helical] * lying)

    def _lying(self, place: Place, sine: Floats, cosine: Floats) -> Floats:
        """Return the contact force of the string that lies times cos^2 y, which is finite where the force is not."""
        push = self.pipe.scale * sine
        bent = self.pipe.weight * place.sine * cosine + push * place.kappa_n
        return np.asarray(np.abs(cosine) * np.hypot(bent, push * place.kappa_b))

    def slopes(self, place: Place, mu: Floats, state: Floats, is_helix: NDArray[np.bool_], towards: float) -> Floats:
        """Return d/ds of y and W, (2, n), of strings at a place of each."""
        y, wave = state
        sine, cosine, weight = np.sin(y), np.cos(y), self.pipe.weight
        square = cosine * cosine
        contact = mu * (self._lying(place, sine, cosine) + weight * is_helix * sine * sine)
        slope = np.zeros(state.shape)
        held = contact if self.shaking is None else contact * self.shaking.left(wave)
        slope[0] = (weight * place.cosine * square - MOTIONS[self.motion] * held) / self.pipe.scale
        if self.shaking is not None:
            lost = -towards * 2.0 / math.pi / self.shaking.impedance
            slope[1] = lost * contact / np.maximum(square, _LEAST)
        return slope
