"""The mean force along a string in a well, from its weight and its friction against the wall.

With the compression F, the weight in fluid w, the inclination phi and the curvatures kappa_n and kappa_b,

    dF/ds = w cos(phi) - mu N,    N = hypot(w sin(phi) + F kappa_n, F kappa_b) + h F^2 R / (4 E I),

downwards along a pushed string; pulled, friction changes its sign, and a standing string has none.  h is 1 where a
pushed string has buckled into a helix, else 0.  The string lies on the wall with its weight until F^2 R / (4 E I)
exceeds the first term of N: there it begins to snake, and at twice that, by energy, a helix is possible.

F = S tan(y) with the critical force S of a level hole is integrated for y, from the lower end up.  Where a helix locks
up F becomes infinite, and y passes through pi/2 as smoothly as anywhere.  Of several sections and bores S is that of
one pair all along, so that y is continuous where they meet, as the effective force is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import compiled
from floquetrod._util.content import ByContent
from floquetrod.wells.helix_criteria import HELIX_RATIOS
from floquetrod.wells.kernels import wall_contact
from floquetrod.wells.kernels.tool_wave import friction_shares
from floquetrod.wells.kernels.wall_contact import LOCKED
from floquetrod.wells.minimum_curvature import Points
from floquetrod.wells.path import WellPath

HELICAL = HELIX_RATIOS | {"always": 0.0}
"""Criteria of a helix by name: the smallest ratios, and a helix wherever the string is compressed."""


class Fineness(NamedTuple):
    """How finely forces are integrated: relative tolerance, and least number of steps between stations.

    Below the corner of friction, against a wave as fast as the string slides, rounding leaves the share ``soft`` of
    friction, which damps a wave next to an axial resonance; its speed has an error of up to thousands of times as much.
    """

    tolerance: float
    steps: int
    cells: int  # of a tool's wave
    share: float = 1.0  # of friction left before the wave is known: forces settle from above with 1, from below with 0
    soft: float = 1e-4  # rounding of the corner of friction


CHECKED = Fineness(1e-12, 2, 24), Fineness(1e-10, 1, 12, 0.0, 3e-4)
FAST, SOUGHT, TRIED = Fineness(1e-8, 1, 12), Fineness(1e-6, 1, 12), Fineness(1e-6, 1, 6)
"""Of one string, and of the coarser run whose difference is its error; of many strings; of searches for a depth; of
searches for a force at the lower end."""

OF_SECTIONS = Fineness(1e-12, 2, 12)
"""Of many strings of several sections, whose forces are those of the chain of their sections to 1e-6."""

_DIVIDED = 300.0  # m (a choice)
_NEARLY = LOCKED - 1e-13  # to rounding

MOTIONS = {"pushed": 1.0, "standing": 0.0, "pulled": -1.0}
"""Ways in which a string moves, and the sign of friction upwards."""


def end_contact_of_bend(rigidity: Any, clearance: Any, curvature: float) -> Any:
    """Return the contact force in N at the lower end of a string that is bent without load, in a straight hole.

    Held straight it carries the moment E I kappa_0 all along, without shear and so without contact.  Its free end
    springs across the clearance, over the length l = sqrt(12 R / kappa_0), and presses with E I kappa_0 / l where it
    ends and, on the other side of the hole, where it leaves the wall: together E I kappa_0^(3/2) / sqrt(3 R)
    (page `theory/surface_weights`).
    """
    return rigidity * curvature * np.sqrt(curvature / (3.0 * clearance))


@dataclass(frozen=True, eq=False)
class StringProperties(ByContent):
    """A string's rigidity, weight and clearance, of one section in one bore or at several places."""

    rigidity: Any  # E I in N m^2
    weight: Any  # weight in fluid in N/m
    clearance: Any  # R in m

    @cached_property
    def scale(self) -> float:
        """S, the critical force in a level hole, in N."""
        return 2.0 * math.sqrt(self.rigidity * self.weight / self.clearance)

    def some(self, i: Ints) -> StringProperties:
        """Return the properties at the places ``i``."""
        return StringProperties(self.rigidity[i], self.weight[i], self.clearance[i])

    def lying(self, force: Floats, geometry: WellGeometry) -> Floats:
        """Return the contact force in N/m of a lying string under a compression in N."""
        bent = self.weight * geometry.sine + force * geometry.kappa_n
        return np.asarray(np.hypot(bent, force * geometry.kappa_b))

    def helix(self, force: Floats) -> Floats:
        """Return the contact force of a helix beyond the lying string's, F^2 R / (4 E I), in N/m."""
        return np.asarray(np.maximum(force, 0.0) ** 2 * self.clearance / (4.0 * self.rigidity))


@dataclass(frozen=True, eq=False)
class StringAssembly(ByContent):
    """The k sections of a string from its lower end up, in a hole of b bores from its upper end down.

    ``heights`` of the ends of sections are above the lower end of the string.
    """

    heights: Floats  # (k + 1,), in m, from 0 to the length of the string
    bores: Floats  # (b,), measured depths in m from which bores begin
    rigidity: Floats  # (k,), E I in N m^2
    weight: Floats  # (k,), in fluid in N/m
    clearance: Floats  # (k, b), R in m
    reference: StringProperties  # of one section in one bore, whose S is that of F = S tan(y)
    impedance: Floats  # (k,), of axial waves in N s/m
    wave_speed: Floats  # (k,), in m/s

    @property
    def inner(self) -> Floats:
        """Heights in m above the lower end at which sections meet."""
        return self.heights[1:-1]

    def section_at(self, depth: Floats, bottom: Floats) -> Ints:
        """Return the sections at measured depths of strings to others, from the lowest up; on an edge the lower one."""
        return np.asarray(np.searchsorted(self.inner, bottom - depth))

    def bore_at(self, depth: Floats) -> Ints:
        """Return the bores at measured depths, on an edge the lower one."""
        return np.maximum(np.searchsorted(self.bores, depth, side="right") - 1, 0)

    def pipe(self, section: Ints, bore: Ints) -> StringProperties:
        """Return the properties of sections in bores."""
        return StringProperties(self.rigidity[section], self.weight[section], self.clearance[section, bore])


class WellGeometry(NamedTuple):
    """A well at measured depths: sine and cosine of the inclination, and curvatures in 1/m."""

    sine: Any
    cosine: Any
    kappa_n: Any
    kappa_b: Any

    @classmethod
    def at(cls, points: Points) -> WellGeometry:
        """Return the geometry at points of a well's arcs."""
        return cls(*points.seen)


@dataclass(frozen=True)
class Friction:
    """Coefficients of friction, each from a measured depth in m to the next."""

    depths: tuple[float, ...]
    values: tuple[float, ...]

    def __str__(self) -> str:
        """Return, say, "0.2", or "0.2, 0.35 from 1500 m on"."""
        return self.in_words(units.unit("m", "", "length"))

    def in_words(self, length: units.Unit) -> str:
        """Return the same with the depths in a unit."""
        pairs = zip(self.values, self.depths, strict=True)
        words = ((f"{value:g}", f" from {length.show(depth)} on" if depth else "") for value, depth in pairs)
        return ", ".join(f"{value}{where}" for value, where in words)

    @property
    def largest(self) -> float:
        """The largest coefficient."""
        return max(self.values)

    def at(self, depth: Floats) -> Floats:
        """Return the coefficient at measured depths, on a boundary the one below."""
        index = np.searchsorted(self.depths, depth, side="right") - 1
        return np.asarray(self.values)[np.maximum(index, 0)]


FRICTIONLESS = Friction((0.0,), (0.0,))


@dataclass(frozen=True)
class Shaking:
    """A tool that shakes a string along its axis, and the friction that its wave leaves."""

    amplitude: float  # of its force in N
    frequency: Any  # in rad/s, one for all strings, or (n,)
    above_end: float  # distance of the tool from the lower end of the string in m
    impedance: float  # Z of the string in N s/m, of several sections the smallest
    wave_speed: float  # of axial waves in m/s, of several sections the slowest
    damping: float  # rate in 1/s at which the string's own damping, without friction, makes waves decay
    speed: float  # v, at which the string slides, in m/s
    second: tuple[float, float] | None = None  # amplitude and frequency of a second sine of the force

    def of(self, size: int, strings: Ints) -> Shaking:
        """Return the tool of the ``strings`` of ``size``, each with its own frequency."""
        return replace(self, frequency=np.broadcast_to(self.frequency, size)[strings])

    @property
    def sines(self) -> tuple[tuple[float, Any], ...]:
        """Amplitude in N and frequency in rad/s of each sine of its force."""
        first = self.amplitude, self.frequency
        return (first,) if self.second is None else (first, self.second)

    @property
    def length(self) -> Floats:
        """Of the shorter wave in m, of each string."""
        fastest = self.frequency if self.second is None else np.maximum(self.frequency, self.second[1])
        return np.asarray(2.0 * math.pi * self.wave_speed / fastest)

    @property
    def divided(self) -> Floats:
        """Length in m divided into cells, a wave, or less of a long one, along which friction changes."""
        return np.minimum(self.length, _DIVIDED)

    def left(self, speed: Floats, other: Floats | None = None) -> Floats:
        """Return mean friction over that without vibration, (2 / pi) asin(v / V), for V in m/s, or beside another V."""
        if other is None:
            return np.asarray(2.0 / math.pi * np.arcsin(self.speed / np.maximum(speed, self.speed)))
        share = np.empty(speed.size)
        compiled(friction_shares)(self.speed, speed, other, share)
        return share


class Strings(NamedTuple):
    """Strings in one well: measured depths of their ends in m, and y at the lower one, (n,) each."""

    top: Floats
    bottom: Floats
    y: Floats


@dataclass(frozen=True)
class Drag:
    """Mean force along strings of one pipe, or of one assembly of sections, in one well."""

    path: WellPath
    pipe: StringProperties  # of an assembly its reference; as `at` and `within` return the string, those at places
    friction: Friction
    motion: str = "pushed"
    helical: str = "energy"
    shaking: Shaking | None = None
    residual_curvature: float = 0.0  # in 1/m, without load
    assembly: StringAssembly | None = None

    @property
    def scale(self) -> float:
        """S of F = S tan(y) in N."""
        return self.pipe.scale if self.assembly is None else self.assembly.reference.scale

    @property
    def end_contact(self) -> Any:
        """Contact force in N, concentrated at the lower end, of a string with a residual curvature."""
        return end_contact_of_bend(self.pipe.rigidity, self.pipe.clearance, self.residual_curvature)

    @cached_property
    def edges(self) -> Floats:
        """Measured depths in m at which the well, its friction or its bore changes, increasing, with both ends."""
        bores = () if self.assembly is None else self.assembly.bores
        ends = np.unique(np.concatenate([self.path.stations, self.friction.depths, bores]))
        return np.asarray(ends[(ends >= self.path.start) & (ends <= self.path.end)])

    def at(self, depth: Floats, bottom: Floats) -> Drag:
        """Return the string at measured depths in m, of strings to depths ``bottom``."""
        if self.assembly is None:
            return self
        return self.within(self.assembly.section_at(depth, bottom), self.assembly.bore_at(depth))

    def within(self, section: Ints, bore: Ints) -> Drag:
        """Return the string where sections of its assembly, counted from the lower end up, are in bores."""
        return self if self.assembly is None else replace(self, pipe=self.assembly.pipe(section, bore))

    def some(self, i: Ints) -> Drag:
        """Return the string at the places ``i`` of those at which it is."""
        return self if self.assembly is None else replace(self, pipe=self.pipe.some(i))

    def above_end(self, far_force: Any, bottom: Floats) -> Floats:
        """Return the compression in N above the contact at the lower end, of strings to measured depths in m.

        A tool does not change the friction there.
        """
        force = np.broadcast_to(np.asarray(far_force, dtype=float), bottom.shape)
        if not self.residual_curvature:
            return force
        contact = self.at(bottom, bottom).end_contact
        return np.asarray(force + MOTIONS[self.motion] * self.friction.at(bottom) * contact)

    def force(self, y: Floats) -> Floats:
        """Return the compression in N, infinite from y = pi / 2 on."""
        below = np.minimum(y, _NEARLY)
        return np.where(y > below, math.inf, self.scale * np.tan(below))

    def y_of(self, force: Floats) -> Floats:
        """Return y of a compression in N."""
        return np.asarray(np.arctan(force / self.scale))

    def is_helix(self, geometry: WellGeometry, y: Floats) -> Bools:
        """Return whether strings are wound into a helix."""
        return np.asarray(self.helix_excess(geometry, y) >= 0.0)

    def is_snaking(self, geometry: WellGeometry, force: Floats) -> Bools:
        """Return whether strings are buckled under a compression in N, into waves or a helix."""
        finite = np.where(np.isfinite(force), force, 0.0)
        return np.asarray(
            np.isinf(force) | ((finite > 0.0) & (self.pipe.helix(finite) >= self.pipe.lying(finite, geometry)))
        )

    @cached_property
    def sliding(self) -> wall_contact.SlidingString:
        """The string's constants in the equation for y, for kernels."""
        helical = HELICAL[self.helical] if self.motion == "pushed" else math.inf
        wound = self.pipe.weight
        if self.assembly is not None:
            wound = self.scale**2 * self.pipe.clearance / (4.0 * self.pipe.rigidity)
        return wall_contact.SlidingString(self.pipe.weight, self.scale, MOTIONS[self.motion], helical, wound)

    def helix_excess(self, geometry: WellGeometry, y: Floats) -> Floats:
        """Return sin y - sqrt(h lying / wound), zero or more where a string is a helix; -1 unless it is pushed."""
        if self.motion != "pushed":
            return np.full(y.shape, -1.0)
        sine = np.sin(y)
        return np.asarray(wall_contact.helix_excess(self.sliding, self._lying(geometry, sine, np.cos(y)), sine))

    def helix_margin(self, geometry: WellGeometry, y: Floats) -> Floats:
        """Return a function of y with the sign of `helix_excess` that is smooth along the well."""
        sine = np.sin(y)
        return np.asarray(wall_contact.helix_margin(self.sliding, self._lying(geometry, sine, np.cos(y)), sine))

    def lying_across(self, geometry: WellGeometry, y: Floats) -> Floats:
        """Return the contact force in N/m of lying strings, times cos^2 y, as a vector: in the plane, and across."""
        sine, cosine = np.sin(y), np.cos(y)
        push = self.scale * sine
        bent = self.pipe.weight * geometry.sine * cosine + push * geometry.kappa_n
        return np.array([cosine * bent, cosine * push * geometry.kappa_b])

    def _lying(self, geometry: WellGeometry, sine: Floats, cosine: Floats) -> Floats:
        return np.asarray(
            wall_contact.lying(self.sliding, geometry.sine, geometry.kappa_n, geometry.kappa_b, sine, cosine)
        )

    def slopes(self, geometry: WellGeometry, mu: Floats, y: Floats, helix: Any) -> Floats:
        """Return dy/ds of strings, each at its place, ``helix`` the share of them wound into a helix."""
        sine, cosine = np.sin(y), np.cos(y)
        pressed = wall_contact.contact(self.sliding, self._lying(geometry, sine, cosine), sine, helix)
        return np.asarray(wall_contact.slope(self.sliding, geometry.cosine, mu, cosine, pressed))
