"""The parts of a rod in a channel: material, section, channel and ends, each a frozen value checked when it is made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from floquetrod._util import validate

_LEAST, _LARGEST = 1e-12, 1e15  # of any parameter in its SI unit: what is computed from them stays in range (a choice)


def parameter(name: str, value: Any, unit: str) -> float:
    """Return a parameter of a rod, greater than zero, in its SI unit."""
    number = validate.positive(name, value, f"give it in {unit}")
    return validate.within(name, number, _LEAST, _LARGEST, f"give it in {unit}")


def decay_rate(value: Any) -> float:
    """Return the decay rate of free motion in 1/s, zero or more."""
    rate = validate.nonnegative("damping_rate", value, "give the decay rate in 1/s")
    return validate.within("damping_rate", rate, 0.0, _LARGEST)


@dataclass(frozen=True)
class Material:
    """Linear elastic material.

    Parameters
    ----------
    youngs_modulus : float
        E in Pa.
    density : float
        rho in kg/m^3.
    """

    youngs_modulus: float
    density: float

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "youngs_modulus", parameter("youngs_modulus", self.youngs_modulus, "Pa"))
        object.__setattr__(self, "density", parameter("density", self.density, "kg/m^3"))

    @property
    def wave_speed(self) -> float:
        """Speed of axial waves, sqrt(E / rho), in m/s."""
        return math.sqrt(self.youngs_modulus / self.density)


@dataclass(frozen=True)
class Section:
    """Solid circular section.

    Parameters
    ----------
    radius : float
        r in m.
    """

    radius: float

    def __post_init__(self) -> None:
        """Check and clean the parameter."""
        object.__setattr__(self, "radius", parameter("radius", self.radius, "m"))

    @property
    def area(self) -> float:
        """Area, pi r^2, in m^2."""
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        """Second moment of area, I = pi r^4 / 4, in m^4."""
        return 0.25 * math.pi * self.radius**4


@dataclass(frozen=True)
class Channel:
    """Horizontal circular channel, the rod on its floor.

    Parameters
    ----------
    radius : float
        Inner radius in m; the argument ``channel_radius`` of a rod.
    gravity : float
        g in m/s^2.
    """

    radius: float
    gravity: float

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "radius", parameter("channel_radius", self.radius, "m"))
        object.__setattr__(self, "gravity", parameter("gravity", self.gravity, "m/s^2"))

    def clearance(self, section: Section) -> float:
        """Return R = channel radius - rod radius in m; ValueError where the section does not fit."""
        if section.radius >= self.radius:
            raise ValueError(
                f"channel_radius must exceed the rod's radius, got channel_radius = {self.radius:g} m and "
                f"radius = {section.radius:g} m; both are radii, not diameters"
            )
        return self.radius - section.radius

    def pendulum_frequency(self, section: Section) -> float:
        """Return the frequency sqrt(g / R) in rad/s at which a rigid rod of this section swings."""
        return math.sqrt(self.gravity / self.clearance(section))


@dataclass(frozen=True)
class Ends:
    """Hinged ends: no displacement across the channel and no moment, so that the modes are sines."""

    def first_wavenumber(self, length: float) -> float:
        """Return w_1 = pi / L in 1/m; mode m has m times as much."""
        return math.pi / length
