"""The parts of a rod in a channel: material, section, channel and ends, each a frozen value checked when it is made."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message
from floquetrod._util.calling import level_of_caller
from floquetrod._util.implausible import SILENCE, PlausibilityWarning, is_typed
from floquetrod._util.suggest import did_you_mean
from floquetrod.rod.model import formulas

if TYPE_CHECKING:
    from floquetrod.wells.path import WellPath

_LEAST, _LARGEST = 1e-12, 1e15  # of any parameter in its SI unit: what is computed from them stays in range (a choice)
_SHARPEST = 1e3  # curvature of a channel in 1/m: a bend of a millimetre (a choice: beyond any)
_LARGEST_FRICTION = 1e6  # (a choice: beyond any)
_ROUGHEST = 1.5  # coefficient of friction: rubber on dry concrete has about 1 (a choice)

ON_A_FLOOR = math.pi**2 / 3.0 - 1.0
"""Added-mass coefficient of a cylinder that touches a plane floor, 2.29."""

LIMITS: dict[str, tuple[float, float]] = {
    **dict.fromkeys(("youngs_modulus", "density", "radius", "length", "channel_radius", "gravity"), (_LEAST, _LARGEST)),
    **dict.fromkeys(("damping_rate", "inner_radius", "fluid_inside", "fluid_outside"), (0.0, _LARGEST)),
    "added_mass_coefficient": (0.0, _LARGEST),
    "inclination": (_LEAST, 0.5 * math.pi),
    "curvature": (-_SHARPEST, _SHARPEST),
}
"""Least and largest of each parameter of a rod that is a number, whatever the others are."""


DIAMETERS = {"diameter": "radius", "inner_diameter": "inner_radius", "channel_diameter": "channel_radius"}
"""What may be given in place of a parameter: twice as much."""

INSTEAD = DIAMETERS | {"wall_thickness": "inner_radius"}
"""Arguments that may be given in place of a parameter."""

MEANT = {
    "outer_diameter": "the outer diameter is diameter",
    "outer_radius": "the outer radius is radius",
    "od": "the outer diameter is diameter",
    "id": "the inner diameter is inner_diameter",
    "wall": "did you mean wall_thickness?",
    "clearance": "give channel_radius, that of the rod and the clearance together",
}
"""What is often written for a parameter of a rod, with the remedy."""


_INSTEAD_LIMITS = {"inner_diameter": (0.0, _LARGEST), "depth": (0.0, _LARGEST)}
"""Limits of what is no parameter that is a number, but may be zero."""

_HINTS = {
    **dict.fromkeys(("youngs_modulus", "yield_strength"), "give it in Pa"),
    **dict.fromkeys(("density", "fluid_inside", "fluid_outside"), "give it in kg/m^3"),
    "gravity": "give it in m/s^2",
    "damping_rate": "give the decay rate in 1/s",
    "inner_radius": "give it in m; 0 for a solid rod",
    "added_mass_coefficient": "it is a ratio of masses such as 2.29",
    "curvature": "give it in 1/m, positive where the channel builds",
    "depth": "give it in m, along the path",
}
"""What to do about a wrong parameter, "give it in m" where it is not among them."""


def in_si(name: str, value: Any) -> Any:
    """Return a parameter that is a string with a unit, such as "0.8mm", as a number in its SI unit, else as it is."""
    return units.single(value, name, units.ROD_KINDS[name])


def parameter(name: str, value: Any) -> float:
    """Return a parameter of a rod, or what is given in place of one, in its SI unit and within its limits."""
    least, largest = (LIMITS | _INSTEAD_LIMITS).get(name, (_LEAST, _LARGEST))
    return units.number(name, value, units.ROD_KINDS[name], least, largest, _HINTS.get(name, "give it in m"))


def radius_of(radius: Any, diameter: Any, names: tuple[str, str]) -> Any:
    """Return a radius in m given by itself or by its diameter, None where neither is; ``names`` are both arguments'."""
    if diameter is None:
        return radius
    if radius is not None:
        got = f"got {validate.short(diameter)} and {validate.short(radius)}"
        raise validate.wrong_value(names[1], f"must not be given with {names[0]}, {got}; give one of them")
    return 0.5 * parameter(names[1], diameter)


def inside_wall(radius: Any, wall_thickness: Any, inner: dict[str, Any]) -> float:
    """Return the inner radius in m of a tube given by its outer radius and wall; ``inner`` must hold only None."""
    for name, value in inner.items():
        if value is not None:
            raise validate.wrong_value(
                "wall_thickness",
                f"must not be given with {name}, got {validate.short(wall_thickness)} and "
                f"{validate.short(value)}; give one of them",
            )
    outer, wall = parameter("radius", radius), parameter("wall_thickness", wall_thickness)
    if wall >= outer:
        raise validate.wrong_value(
            "wall_thickness",
            f"must be less than the outer radius, got wall_thickness = {wall:g} m and radius = "
            f"{outer:g} m; leave it out for a solid rod",
        )
    return outer - wall


def on_path(path: Any, depth: Any, length: float, instead: Mapping[str, Any]) -> tuple[WellPath | None, float]:
    """Return the path of a rod of a length in m, given as one or by its arguments, and the depth in m of its upper end.

    ``instead`` must hold only None with a path.
    """
    start = parameter("depth", depth)
    if path is None:
        if start:
            raise validate.wrong_value(
                "depth",
                f"is the measured depth of the rod's upper end on a path, got {start:g} m without one; give path",
            )
        return None, start
    from floquetrod.wells.path import WellPath

    for name, value in instead.items():
        if value is not None:
            raise validate.wrong_value(
                name, f"must not be given with path, which determines it, got {validate.short(value)}; give one of them"
            )
    if isinstance(path, Mapping):
        path = WellPath(**path)
    path = validate.instance("path", path, WellPath, "WellPath.from_csv(file), say")
    room = 1e-9 * max(path.end, length)
    if not path.start - room <= start <= start + length <= path.end + room:
        raise validate.wrong_value(
            "depth",
            f"must leave all of the rod on its path from {path.start:g} to {path.end:g} m, and from {start:g} m it "
            f"reaches to {start + length:g} m",
        )
    return path, start


def friction_coefficient(value: Any) -> float:
    """Return a coefficient of friction as a float; warns of one that was probably meant in per cent."""
    number = validate.nonnegative("friction", value, "friction opposes the motion")
    validate.within("friction", number, 0.0, _LARGEST_FRICTION, "it is a coefficient such as 0.1")
    if _ROUGHEST < number <= 100.0 * _ROUGHEST and is_typed(number):
        warnings.warn(
            Message(
                Mention("friction"),
                f" = {number:g} is larger than that of rubber on concrete; was it in per cent? It is a coefficient: ",
                Mention("friction", f"friction={number / 100.0:g}", f"{number / 100.0:g}"),
                SILENCE,
            ),
            PlausibilityWarning,
            stacklevel=level_of_caller(),
        )
    return number


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
        object.__setattr__(self, "youngs_modulus", parameter("youngs_modulus", self.youngs_modulus))
        object.__setattr__(self, "density", parameter("density", self.density))

    @property
    def wave_speed(self) -> float:
        """Speed of axial waves, sqrt(E / rho), in m/s."""
        return math.sqrt(self.youngs_modulus / self.density)


@dataclass(frozen=True)
class Section:
    """Circular section, solid or of a tube.

    Parameters
    ----------
    radius : float
        Outer radius r_o in m.
    inner_radius : float
        r_i in m, less than the outer radius; 0 for a solid section.
    """

    radius: float
    inner_radius: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        radius, inner = parameter("radius", self.radius), parameter("inner_radius", self.inner_radius)
        if not formulas.has_wall(radius, inner):
            raise validate.wrong_value(
                "inner_radius",
                f"must be less than the outer radius, got {inner:g} m and {radius:g} m: half of inner_diameter = "
                f"{2.0 * inner:g} m and of diameter = {2.0 * radius:g} m",
            )
        object.__setattr__(self, "radius", radius)
        object.__setattr__(self, "inner_radius", inner)

    @property
    def area(self) -> float:
        """Area of the material, A_s = pi (r_o^2 - r_i^2), in m^2."""
        return float(formulas.ring(self.radius, self.inner_radius))

    @property
    def outer_area(self) -> float:
        """Area within the outer radius, A_o = pi r_o^2, in m^2."""
        return float(formulas.disc(self.radius))

    @property
    def inner_area(self) -> float:
        """Area of the bore, A_i = pi r_i^2, in m^2."""
        return float(formulas.disc(self.inner_radius))

    @property
    def second_moment(self) -> float:
        """Second moment of area, I = pi (r_o^4 - r_i^4) / 4, in m^4."""
        return float(formulas.second_moment(self.radius, self.inner_radius))


@dataclass(frozen=True)
class Fluids:
    """Fluids inside and outside of a rod, at rest except for the mass that its motion moves.

    Parameters
    ----------
    inside : float
        Density rho_i in kg/m^3, 0 for none; the argument ``fluid_inside`` of a rod.
    outside : float
        Density rho_o likewise; ``fluid_outside`` of a rod.
    added_mass_coefficient : float
        C_a, the mass of outer fluid that moves with the rod over the mass that the rod displaces; by default that of a
        cylinder touching a plane floor, pi^2/3 - 1 = 2.29.
    """

    inside: float = 0.0
    outside: float = 0.0
    added_mass_coefficient: float = ON_A_FLOOR

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "inside", parameter("fluid_inside", self.inside))
        object.__setattr__(self, "outside", parameter("fluid_outside", self.outside))
        added = parameter("added_mass_coefficient", self.added_mass_coefficient)
        object.__setattr__(self, "added_mass_coefficient", added)


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
        object.__setattr__(self, "radius", parameter("channel_radius", self.radius))
        object.__setattr__(self, "gravity", parameter("gravity", self.gravity))
        hint = 'it is the angle from the vertical in radians: math.radians(60), or "60deg"'
        inclination = validate.finite("inclination", self.inclination, hint)
        if not _LEAST <= inclination <= 0.5 * math.pi:
            raise validate.wrong_value(
                "inclination", f"must be above 0 and at most pi/2 = 1.5708 (horizontal), got {inclination:g}; {hint}"
            )
        object.__setattr__(self, "inclination", inclination)

    @property
    def gravity_across(self) -> float:
        """Component of gravity across the channel, g sin(inclination), in m/s^2."""
        return float(formulas.gravity_across(self.gravity, self.inclination))

    @property
    def gravity_along(self) -> float:
        """Component of gravity along the channel, g cos(inclination), in m/s^2; exactly 0 in a horizontal one."""
        return self.gravity * math.cos(self.inclination) if self.inclination < 0.5 * math.pi else 0.0

    def clearance(self, section: Section) -> float:
        """Return R = channel radius - rod radius in m; ValueError where the section does not fit."""
        if not formulas.fits(section.radius, self.radius):
            raise validate.wrong_value(
                "channel_radius",
                f"must exceed the rod's radius, got channel_radius = {self.radius:g} m and "
                f"radius = {section.radius:g} m, half the diameters {2.0 * self.radius:g} m and "
                f"{2.0 * section.radius:g} m",
            )
        return float(formulas.clearance(section.radius, self.radius))


CONDITIONS = ("hinged", "clamped", "guided", "free")
"""What an end of a rod may be."""


@dataclass(frozen=True)
class Ends:
    """How the two ends are held across the channel; the axial force acts through both, along the channel.

    Parameters
    ----------
    upper : {"hinged", "clamped", "guided", "free"}
        At s = 0, the upper end of an inclined rod.  Hinged: no displacement, no moment.  Clamped: no displacement, no
        rotation.  Guided: no rotation, no force across.  Free: no moment, no force across.
    lower : {"hinged", "clamped", "guided", "free"}
        At s = L.
    """

    upper: str = "hinged"
    lower: str = "hinged"

    @classmethod
    def of(cls, word: Any) -> Ends:
        """Return the ends that a word names: "clamped" for both, or "clamped-hinged", the upper end first."""
        parts = word.lower().replace(" ", "").split("-") if isinstance(word, str) else []
        if not 1 <= len(parts) <= 2 or not set(parts) <= set(CONDITIONS):
            raise validate.wrong_value(
                "ends",
                f"must be one of {', '.join(CONDITIONS)}, or two of them joined by a hyphen, the upper end first, "
                f'such as "clamped-hinged"; got {validate.short(word)}{_meant(parts)}',
            )
        return cls(parts[0], parts[-1])

    @property
    def are_hinged(self) -> bool:
        """Whether both are hinged, so that the modes of a rod under a uniform force are independent sines."""
        return self.upper == self.lower == "hinged"

    def __str__(self) -> str:
        """Return the word for them."""
        return self.upper if self.upper == self.lower else f"{self.upper}-{self.lower}"

    def first_wavenumber(self, length: float) -> float:
        """Return w_1 = pi / L in 1/m; mode m of a rod with hinged ends has m times as much."""
        return float(formulas.first_wavenumber(length))


def _meant(parts: list[str]) -> str:
    """Return the question whether the condition nearest to the first unknown one was meant, "" where none is near."""
    return next((did_you_mean(part, CONDITIONS) for part in parts if part not in CONDITIONS), "")
