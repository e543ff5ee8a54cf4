"""Material, cross section and fluids of a rod, each a frozen value checked when it is made."""

from __future__ import annotations

import math
from dataclasses import dataclass

from floquetrod.rod.model import formulas
from floquetrod.rod.model.parameters import ON_A_FLOOR, ROD
from floquetrod.rod.model.possible_rod import HAS_WALL


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
        object.__setattr__(self, "youngs_modulus", ROD["youngs_modulus"].number(self.youngs_modulus))
        object.__setattr__(self, "density", ROD["density"].number(self.density))

    @property
    def wave_speed(self) -> float:
        """Speed of axial waves, sqrt(E / rho), in m/s."""
        return math.sqrt(self.youngs_modulus / self.density)


@dataclass(frozen=True)
class CrossSection:
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
        radius, inner = ROD["radius"].number(self.radius), ROD["inner_radius"].number(self.inner_radius)
        HAS_WALL.check({"radius": radius, "inner_radius": inner})
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
        C_a, the mass of outer fluid that moves with the rod over the mass that the rod displaces; by default
        pi^2/3 - 1 = 2.29, the value for a cylinder touching a plane floor.
    """

    inside: float = 0.0
    outside: float = 0.0
    added_mass_coefficient: float = ON_A_FLOOR

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "inside", ROD["fluid_inside"].number(self.inside))
        object.__setattr__(self, "outside", ROD["fluid_outside"].number(self.outside))
        added = ROD["added_mass_coefficient"].number(self.added_mass_coefficient)
        object.__setattr__(self, "added_mass_coefficient", added)
