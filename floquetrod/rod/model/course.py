"""The channel along a rod: its inclination and curvature, uniform or along a well's path."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.roots import bisected
from floquetrod.rod.model import formulas
from floquetrod.rod.model.cross_section import CrossSection
from floquetrod.rod.model.parameters import ROD
from floquetrod.rod.model.possible_rod import FITS

if TYPE_CHECKING:
    from floquetrod.wells.path import WellPath

_IN_AN_ARC = np.linspace(0.0, 1.0, 17)  # places of each arc at which the least of something is searched for (a choice)
_ALONG_WAVES = np.linspace(0.0, 1.0, 257)  # places at which a wave is examined (a choice)
_INSIDE = 1e-12  # of an arc, by which its ends are kept off the stations, where curvature jumps


@dataclass(frozen=True)
class Channel:
    """Straight circular channel, horizontal or inclined, the rod on its floor.

    Parameters
    ----------
    radius : float
        Inner radius in m; the argument ``channel_radius`` of a rod.
    gravity : float
        g in m/s^2.
    inclination : float
        Angle from the vertical in radians, above 0 and at most pi/2, which is horizontal.
    """

    radius: float
    gravity: float
    inclination: float = 0.5 * math.pi

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "radius", ROD["channel_radius"].number(self.radius))
        object.__setattr__(self, "gravity", ROD["gravity"].number(self.gravity))
        object.__setattr__(self, "inclination", ROD["inclination"].number(self.inclination))

    @property
    def gravity_across(self) -> float:
        """Component of gravity across the channel, g sin(inclination), in m/s^2."""
        return float(formulas.gravity_across(self.gravity, self.inclination))

    @property
    def gravity_along(self) -> float:
        """Component of gravity along the channel, g cos(inclination), in m/s^2; exactly 0 in a horizontal one."""
        return self.gravity * math.cos(self.inclination) if self.inclination < 0.5 * math.pi else 0.0

    def clearance(self, section: CrossSection) -> float:
        """Return R = channel radius - rod radius in m; ValueError where the section does not fit."""
        FITS.check({"channel_radius": self.radius, "radius": section.radius})
        return float(formulas.clearance(section.radius, self.radius))


class ChannelShape(NamedTuple):
    """The channel at some places: sine of its inclination, and curvatures in 1/m, in its vertical plane and aside."""

    sine: Floats
    kappa_n: Floats
    kappa_b: Floats

    @property
    def turns(self) -> bool:
        """Whether it bends sideways anywhere."""
        return bool(np.any(self.kappa_b))


class Course(ABC):
    """The channel at x = s / L along a rod, from its upper end."""

    is_uniform: bool
    """Whether inclination and curvature are the same all along, none of it sideways."""
    is_straight: bool
    breaks: tuple[float, ...] = ()
    """Places in between at which curvature jumps."""

    @abstractmethod
    def place(self, x: Floats) -> ChannelShape:
        """Return the channel at places."""

    @property
    def sharpest(self) -> float:
        """The largest curvature in 1/m."""
        place = self.sampled
        return float(np.hypot(place.kappa_n, place.kappa_b).max())

    @property
    @abstractmethod
    def samples(self) -> Floats:
        """Places among which the least of what changes along the channel is."""

    @cached_property
    def sampled(self) -> ChannelShape:
        """The channel at its samples."""
        return self.place(self.samples)

    @cached_property
    def sampled_for_waves(self) -> tuple[Floats, ChannelShape]:
        """Places, close enough for waves too, and the channel there."""
        x = np.union1d(self.samples, _ALONG_WAVES)
        return x, self.place(x)


@dataclass(frozen=True)
class UniformCourse(Course):
    """A channel whose inclination in rad and curvature in 1/m are given as uniform."""

    inclination: float
    curvature: float
    edges: tuple[float, ...] = ()  # places between the ends at which the rod changes
    is_uniform = True

    @property
    def is_straight(self) -> bool:  # type: ignore[override]
        """Whether it does not bend."""
        return self.curvature == 0.0

    def place(self, x: Floats) -> ChannelShape:
        """Return the channel at places."""
        ones = np.ones_like(x)
        return ChannelShape(math.sin(self.inclination) * ones, self.curvature * ones, 0.0 * ones)

    @property
    def samples(self) -> Floats:
        """Both ends, and both sides of the edges of a rod's parts."""
        edges = np.array(self.edges)
        return np.unique(np.concatenate([[0.0, 1.0], edges - _INSIDE, edges + _INSIDE]))


@dataclass(frozen=True)
class PathCourse(Course):
    """A channel along a path that bends, from a measured depth in m over a length in m."""

    path: WellPath
    depth: float
    length: float
    edges: tuple[float, ...] = ()  # places between the ends at which the rod changes
    is_uniform = False
    is_straight = False

    @property
    def breaks(self) -> tuple[float, ...]:  # type: ignore[override]
        """The stations in between."""
        x = (self.path.stations - self.depth) / self.length
        return tuple(x[(x > 0.0) & (x < 1.0)].tolist())

    def depths(self, x: Floats) -> Floats:
        """Return measured depths in m."""
        return self.depth + self.length * x

    def place(self, x: Floats) -> ChannelShape:
        """Return the channel at places."""
        sine, _, build, aside = self.path.arcs.at(self._on_path(x)).seen
        return ChannelShape(sine, build, aside)

    def fallen(self, x: Floats, at: float) -> Floats:
        """Return how far places are below one of them, in m."""
        depths = self._on_path(np.append(x, at))
        vertical = self.path.position(depths)[:, 2]
        return np.asarray((vertical[:-1] - vertical[-1]).reshape(np.shape(x)))

    @cached_property
    def fall(self) -> float:
        """How far the lower end is below the upper one, in m."""
        return float(self.fallen(np.array(1.0), 0.0))

    def _on_path(self, x: Floats) -> Floats:
        """Return measured depths in m, rounding at the ends of the path aside."""
        return np.clip(self.depths(x), self.path.start, self.path.end)

    @cached_property
    def samples(self) -> Floats:
        """Places in every arc, up to its ends."""
        ends = np.unique([0.0, *self.breaks, *self.edges, 1.0])
        inside = np.clip(_IN_AN_ARC, _INSIDE, 1.0 - _INSIDE)
        return (ends[:-1, None] + np.diff(ends)[:, None] * inside).ravel()


def course_of(
    inclination: float,
    curvature: float,
    path: WellPath | None,
    depth: float,
    length: float,
    edges: tuple[float, ...] = (),
) -> Course:
    """Return the channel along a rod; a path that is straight there is given by its inclination.

    ``edges`` are the places between the ends at which sections or bores of the rod change.
    """
    if path is None:
        return UniformCourse(inclination, curvature, edges)
    upper = max(0, int(np.searchsorted(path.stations, depth, side="right")) - 1)
    around = slice(upper, 1 + int(np.searchsorted(path.stations, depth + length)))
    phi, psi = path.inclination[around], path.azimuth[around]
    if (phi == phi[0]).all() and ((psi == psi[0]).all() or phi[0] == 0.0):
        return UniformCourse(float(phi[0]), 0.0, edges)
    return PathCourse(path, depth, length, edges)


def critical_forces(place: ChannelShape, rigidity: Any, weight: Any, clearance: Any) -> Floats:
    """Return the least constant push in N that buckles a long rod at each place, with its own numbers or one for all.

    F^2 = 4 E I N(F) / R with the contact force N = hypot(w sin(phi) + F kappa_n, F kappa_b), the criterion of He and
    Kyllingstad (SPE 25370, 1995); in a plane F = 2 E I (k + sqrt(k^2 + q / E I)), k = kappa_n / R, q = w sin(phi) / R,
    which is exact where both are uniform.
    """
    across = np.sqrt(rigidity * (weight / clearance) * place.sine)
    bend, aside = (rigidity / clearance * kappa for kappa in (place.kappa_n, place.kappa_b))
    low = critical_push(bend, across)
    if not np.any(place.kappa_b):
        return low

    def holds(force: Floats) -> Bools:
        return np.asarray(force * force <= 4.0 * np.hypot(across**2 + force * bend, force * aside))

    return bisected(holds, low, critical_push(bend + np.abs(aside), across), 60)[0]


def critical_push(bend: Floats, across: Floats) -> Floats:
    """Return 2 (b + sqrt(b^2 + a^2)) without cancellation: bit for bit 2 a where b = 0."""
    root = np.hypot(bend, across)
    with np.errstate(invalid="ignore", divide="ignore"):  # of what is not taken
        return np.asarray(2.0 * np.where(bend >= 0.0, bend + root, across * across / (root - bend)))


def weight_gained(rod: Any, x: Any, at: float) -> Any:
    """Return the weight in N that is hung along the channel between places x = s / L of the rod and one of them."""
    course = rod.course
    if rod.varies:
        return _gained(rod, x, at)
    if isinstance(course, PathCourse):
        return rod.weight_per_length * course.fallen(np.asarray(x), at)
    return rod.weight_along * rod.length * (x - at)


def _gained(rod: Any, x: Any, at: float) -> Any:
    """Return `weight_gained` of a rod of several parts: what each part has between the two places."""
    course, total = rod.course, 0.0
    for part in rod.uniform_parts:
        ends = part.start / rod.length, part.end / rod.length
        lower, upper = np.clip(np.asarray(x, dtype=float), *ends), float(np.clip(at, *ends))
        if isinstance(course, PathCourse):
            total = total + part.rod.weight_per_length * course.fallen(lower, upper)
        else:
            total = total + part.rod.weight_along * rod.length * (lower - upper)
    return total
