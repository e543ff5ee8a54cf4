"""What follows from a rod's parameters, written once for floats, numpy arrays and intervals.

Sums, differences, products, quotients and whole powers only; the circle constant and the sine are arguments, since
intervals have their own.  `floquetrod.rod.model.constants.ModeConstants.of` puts together what the modes need.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

THINNEST = 1e-6  # wall of a tube in outer radii: far below any, and area and second moment keep ten digits (a choice)
FLOATING = 1e-9  # weight over that without buoyancy up to which a rod counts as floating: rounding is near (a choice)


# --- section ---


def disc(radius: Any, pi: Any = math.pi) -> Any:
    """Return the area within a radius."""
    return pi * radius**2


def ring(radius: Any, inner_radius: Any, pi: Any = math.pi) -> Any:
    """Return the area between two radii."""
    return pi * (radius**2 - inner_radius**2)


def second_moment(radius: Any, inner_radius: Any, pi: Any = math.pi) -> Any:
    """Return the second moment of the area between two radii about a diameter."""
    return 0.25 * pi * (radius**4 - inner_radius**4)


def has_wall(radius: Any, inner_radius: Any) -> Any:
    """Return whether a tube's wall is thick enough to count as one."""
    return inner_radius <= (1.0 - THINNEST) * radius


# --- mass and weight, per length from areas in m^2, or per area of the material from areas over that ---


def own_mass(density: Any, fluid_inside: Any, material: Any, bore: Any) -> Any:
    """Return the mass of the material and of the fluid inside."""
    return density * material + fluid_inside * bore


def inertia(own: Any, fluid_outside: Any, added_mass_coefficient: Any, outer: Any) -> Any:
    """Return own mass and added mass."""
    return own + added_mass_coefficient * fluid_outside * outer


def weighing_mass(own: Any, fluid_outside: Any, outer: Any) -> Any:
    """Return the own mass less the mass of the fluid displaced, in kg/m."""
    return own - fluid_outside * outer


def sinks(own: Any, weighing: Any) -> Any:
    """Return whether a rod lies on the floor: its own mass outweighs the fluid displaced, beyond rounding."""
    return weighing > FLOATING * own


# --- channel ---


def fits(radius: Any, channel_radius: Any) -> Any:
    """Return whether a rod has room in the channel."""
    return radius < channel_radius


def clearance(radius: Any, channel_radius: Any) -> Any:
    """Return the radius on which the rod's axis moves."""
    return channel_radius - radius


def gravity_across(gravity: Any, inclination: Any, sin: Callable[[Any], Any] = math.sin) -> Any:
    """Return the component of gravity across a channel, ``inclination`` from the vertical."""
    return gravity * sin(inclination)


# --- what acts across the channel ---


class Masses(NamedTuple):
    """Masses per length of a rod."""

    inertia: Any  # m_t in kg/m
    weighing_share: Any  # own mass less that of the fluid displaced, over m_t


def effective_gravity(across: Any, weighing_share: Any) -> Any:
    """Return the acceleration by which a rod is pulled to the floor."""
    return across * weighing_share


def weight_across(p: Mapping[str, Any], masses: Masses, sin: Callable[[Any], Any] = math.sin) -> Any:
    """Return the force w_e sin(inclination) by which the weight presses a rod to the floor, over R m_t, in 1/s^2.

    Of the parameters of a rod by name.
    """
    across = gravity_across(p["gravity"], p["inclination"], sin)
    return effective_gravity(across, masses.weighing_share) / clearance(p["radius"], p["channel_radius"])


def restoring(p: Mapping[str, Any], masses: Masses, sin: Callable[[Any], Any] = math.sin) -> Any:
    """Return Omega^2 in 1/s^2, all that restores a rod across, over its inertia m_t: its weight alone.

    Of the parameters of a rod by name.  In a bend the compression presses the rod besides, see `contact`.
    """
    return weight_across(p, masses, sin)


# --- modes ---


def first_wavenumber(length: Any, pi: Any = math.pi) -> Any:
    """Return w_1 = pi / L; mode m of a rod with hinged ends has m times as much."""
    return pi / length


def neutral_mode_squared(curvature: Any, room: Any, first: Any) -> Any:
    """Return m_0^2 = (kappa / R) / w_1^2: what compression holds down equals what it drives at so many half waves."""
    return curvature / (room * first**2)
