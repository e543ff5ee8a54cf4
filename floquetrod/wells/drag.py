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
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod.wells.arcs import Points
from floquetrod.wells.kernels import contact
from floquetrod.wells.kernels.contact import LOCKED
from floquetrod.wells.path import WellPath

HELICAL = {"energy": 2.0, "loading": 1.83**2, "alone": 8.0, "always": 0.0}
"""Criteria of a helix by name: F^2 R / (4 E I) over the contact force of the string that lies, from which on one forms.

In a straight well sqrt(2) (Chen, Lin & Cheatham 1990), 1.83 (Wu & Juvkam-Wold 1993) and 2 sqrt(2) (Mitchell 1996) times
the critical force; or wherever the string is compressed.  The first follows by energy in bent wells too
(docs/theory/mean_force.md), the other two are taken to keep their ratio to it.
"""


class Effort(NamedTuple):
    """How finely forces are integrated: relative tolerance, and least number of steps between stations.

    With a tool, how many cells its wave has, and the share of friction that is taken to be left before the wave is
    known: forces are approached from above with 1, and from below with 0; and how far the corner of friction against a
    wave that is as fast as the string slides is rounded: below it that much of friction is left, which damps a wave
    next to an axial resonance, whose speed has an error of up to thousands of times as much.
    """

    tolerance: float
    steps: int
    cells: int
    share: float = 1.0
    soft: float = 1e-4


CHECKED = Effort(1e-12, 2, 24), Effort(1e-10, 1, 12, 0.0, 3e-4)
FAST, SOUGHT, TRIED = Effort(1e-8, 1, 12), Effort(1e-6, 1, 12), Effort(1e-6, 1, 6)
"""Of one string, and what it is compared with, whose error is the difference; of many strings; of a depth sought; of a
force sought at the lower end."""

_DIVIDED = 300.0  # m (a choice)
_NEARLY = LOCKED - 1e-13  # to rounding

MOTIONS = {"pushed": 1.0, "standing": 0.0, "pulled": -1.0}
"""Ways in which a string moves, and the sign of friction upwards."""


@dataclass(frozen=True)
class Pipe:
    """What the mean force needs of a string."""

    rigidity: float  # E I in N m^2
    weight: float  # weight in fluid in N/m
    clearance: float  # R in m

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

    def at(self, depth: Floats) -> Floats:
        """Return the coefficient at measured depths, that below on a boundary."""
        place = np.searchsorted(self.depths, depth, side="right") - 1
        return np.asarray(self.values)[np.maximum(place, 0)]


FRICTIONLESS = Friction((0.0,), (0.0,))


@dataclass(frozen=True)
class Shaking:
    """A tool that shakes a string along its axis, and what is left of friction."""

    amplitude: float  # of its force in N
    frequency: Any  # in rad/s, the same for all strings, or (n,), of each its own
    above_end: float  # distance of the tool from the lower end of the string in m
    impedance: float  # Z of the string in N s/m
    wave_speed: float  # of axial waves in m/s
    damping: float  # rate in 1/s at which the string's own damping, without friction, makes waves decay
    speed: float  # v, at which the string slides, in m/s

    def of(self, size: int, strings: Ints) -> Shaking:
        """Return that of some of so many strings, of each its own frequency."""
        return replace(self, frequency=np.broadcast_to(self.frequency, size)[strings])

    @property
    def length(self) -> Floats:
        """Of a wave in m, of each string."""
        return np.asarray(2.0 * math.pi * self.wave_speed / self.frequency)

    @property
    def divided(self) -> Floats:
        """Length in m that is divided into cells, that of a wave or less, since friction changes along long ones."""
        return np.minimum(self.length, _DIVIDED)

    def left(self, speed: Floats) -> Floats:
        """Return mean friction over that without vibration, (2 / pi) asin(v / V), for V in m/s."""
        return np.asarray(2.0 / math.pi * np.arcsin(self.speed / np.maximum(speed, self.speed)))


class Strings(NamedTuple):
    """Strings in one well: measured depths of their ends in m, and y at the lower one, (n,) each."""

    top: Floats
    bottom: Floats
    y: Floats


class States(NamedTuple):
    """Y of strings at measured depths, (m, n), NaN where a string is not; and at their upper ends, (n,)."""

    depth: Floats
    y: Floats
    top_y: Floats


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

    def is_helix(self, place: Place, y: Floats) -> Bools:
        """Return whether strings are wound into a helix."""
        return np.asarray(self.wants_helix(place, y) >= 0.0)

    def is_snaking(self, place: Place, force: Floats) -> Bools:
        """Return whether strings are buckled under a compression in N, into waves or a helix."""
        held = np.where(np.isfinite(force), force, 0.0)
        return np.asarray(np.isinf(force) | ((held > 0.0) & (self.pipe.helix(held) >= self.pipe.lying(held, place))))

    @cached_property
    def pushed(self) -> contact.Pushed:
        """What the equation of a string needs besides the place."""
        helical = HELICAL[self.helical] if self.motion == "pushed" else math.inf
        return contact.Pushed(self.pipe.weight, self.pipe.scale, MOTIONS[self.motion], helical)

    def wants_helix(self, place: Place, y: Floats) -> Floats:
        """Return what is zero or more where a string is wound into a helix, which only one that is pushed is."""
        if self.motion != "pushed":
            return np.full(y.shape, -1.0)
        sine = np.sin(y)
        return np.asarray(contact.wants_helix(self.pushed, self._lying(place, sine, np.cos(y)), sine))

    def helix_margin(self, place: Place, y: Floats) -> Floats:
        """Return what has the sign of `wants_helix` and is smooth between places."""
        sine = np.sin(y)
        return np.asarray(contact.helix_margin(self.pushed, self._lying(place, sine, np.cos(y)), sine))

    def lying_across(self, place: Place, y: Floats) -> Floats:
        """Return the contact force in N/m of strings that lie, times cos^2 y, as a vector: in the plane, and across."""
        sine, cosine = np.sin(y), np.cos(y)
        push = self.pipe.scale * sine
        bent = self.pipe.weight * place.sine * cosine + push * place.kappa_n
        return np.array([cosine * bent, cosine * push * place.kappa_b])

    def _lying(self, place: Place, sine: Floats, cosine: Floats) -> Floats:
        return np.asarray(contact.lying(self.pushed, place.sine, place.kappa_n, place.kappa_b, sine, cosine))

    def slopes(self, place: Place, mu: Floats, y: Floats, helix: Any) -> Floats:
        """Return d/ds of y of strings at a place of each, of which a part is wound into a helix."""
        sine, cosine = np.sin(y), np.cos(y)
        pressed = contact.contact(self.pushed, self._lying(place, sine, cosine), sine, helix)
        return np.asarray(contact.slope(self.pushed, place.cosine, mu, cosine, pressed))
