"""What follows from a rod's parameters, written once for floats, numpy arrays and intervals.

Sums, differences, products, quotients and whole powers only; the circle constant and the sine are arguments, since
intervals have their own.  Areas and second moments go together as `SectionNumbers`, in SI units or over the area of the
material: most of a section's size then cancels, and intervals are not widened by it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

THINNEST = 1e-6  # wall of a tube in outer radii: far below any, and area and second moment keep ten digits (a choice)
FLOATING = 1e-9  # weight over that without buoyancy up to which a rod counts as floating: rounding is near (a choice)


class SectionNumbers(NamedTuple):
    """Areas of a section and its second moment: in m^2 and m^4, or all over the area of the material.

    Attributes
    ----------
    material, inner, outer : number, array or interval
        A_s, A_i and A_o: of the material, of the bore, and within the outer radius.
    second_moment : number, array or interval
        I, about a diameter.
    """

    material: Any
    inner: Any
    outer: Any
    second_moment: Any


class ModeNumbers(NamedTuple):
    """What the equation of mode m needs: q'' + 2 c q' + (c1 m^4 - c2 m^2 F(t) + Omega^2) q = 0, F a compression.

    Attributes
    ----------
    bending : number, array or interval
        c1 = (E I / m_t) (pi / L)^4 in 1/s^2.
    per_newton : number, array or interval
        c2 = (pi / L)^2 / m_t in 1/(N s^2).
    pendulum_squared : number, array or interval
        Omega^2 in 1/s^2.
    damping_rate : number, array or interval
        c in 1/s.
    """

    bending: Any
    per_newton: Any
    pendulum_squared: Any
    damping_rate: Any


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


def section_numbers(radius: Any, inner_radius: Any) -> SectionNumbers:
    """Return areas and second moment in SI units."""
    return SectionNumbers(
        ring(radius, inner_radius), disc(inner_radius), disc(radius), second_moment(radius, inner_radius)
    )


def relative_section_numbers(radius: Any, inner_radius: Any) -> SectionNumbers:
    """Return areas and second moment over the area of the material: I / A_s = (r_o^2 + r_i^2) / 4."""
    outer, inner = radius**2, inner_radius**2
    bore = inner / (outer - inner)
    return SectionNumbers(1.0, bore, 1.0 + bore, 0.25 * (outer + inner))


def has_wall(radius: Any, inner_radius: Any) -> Any:
    """Return whether a tube's wall is thick enough to count as one."""
    return inner_radius <= (1.0 - THINNEST) * radius


# --- mass and weight ---


def own_mass(density: Any, fluid_inside: Any, section: SectionNumbers) -> Any:
    """Return the mass of the material and of the fluid inside, per length."""
    return density * section.material + fluid_inside * section.inner


def inertia(own: Any, fluid_outside: Any, added_mass_coefficient: Any, section: SectionNumbers) -> Any:
    """Return own mass and added mass, per length."""
    return own + added_mass_coefficient * fluid_outside * section.outer


def weighing_mass(own: Any, fluid_outside: Any, section: SectionNumbers) -> Any:
    """Return own mass less that of the fluid displaced, per length."""
    return own - fluid_outside * section.outer


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


def effective_gravity(across: Any, weight_over_inertia: Any) -> Any:
    """Return the acceleration by which a rod is pulled to the floor."""
    return across * weight_over_inertia


def pendulum_squared(gravity: Any, room: Any) -> Any:
    """Return the squared frequency of swinging, from the effective gravity and the clearance."""
    return gravity / room


# --- modes ---


def first_wavenumber(length: Any, pi: Any = math.pi) -> Any:
    """Return w_1 = pi / L; mode m of a rod with hinged ends has m times as much."""
    return pi / length


def rigidity(youngs_modulus: Any, section: SectionNumbers) -> Any:
    """Return E I."""
    return youngs_modulus * section.second_moment


class ModeParameters(NamedTuple):
    """What `floquetrod.rod.model.constants.ModeConstants` holds, the pendulum frequency squared; SI units.

    Attributes
    ----------
    w2, mass_per_length, rigidity, pendulum_squared, damping_rate : number or array
    """

    w2: Any
    mass_per_length: Any
    rigidity: Any
    pendulum_squared: Any
    damping_rate: Any


def mode_parameters(parameters: Mapping[str, Any], sin: Callable[[Any], Any] = math.sin) -> ModeParameters:
    """Return what the mode equations depend on, from all parameters of a rod but its ends, floats or arrays.

    The same operations in the same order as the properties of `floquetrod.rod.model.data.RodData`.
    """
    p = parameters
    section = section_numbers(p["radius"], p["inner_radius"])
    own = own_mass(p["density"], p["fluid_inside"], section)
    mass = inertia(own, p["fluid_outside"], p["added_mass_coefficient"], section)
    weighing = weighing_mass(own, p["fluid_outside"], section)
    pull = effective_gravity(gravity_across(p["gravity"], p["inclination"], sin), weighing / mass)
    return ModeParameters(
        first_wavenumber(p["length"]) ** 2,
        mass,
        rigidity(p["youngs_modulus"], section),
        pendulum_squared(pull, clearance(p["radius"], p["channel_radius"])),
        p["damping_rate"],
    )


def mode_constants(
    parameters: Mapping[str, Any], *, pi: Any = math.pi, sin: Callable[[Any], Any] = math.sin
) -> ModeNumbers:
    """Return what the mode equations need, from all parameters of a rod but its ends: floats, arrays or intervals.

    Parameters
    ----------
    parameters : mapping
        The parameters of `floquetrod.Rod` by name, SI units, such as `RodData.parameters` with some replaced.
    pi : number or interval
        The circle constant; of intervals an enclosure.
    sin : callable
        The sine for what ``parameters["inclination"]`` is.

    Notes
    -----
    Written for intervals: without a bore or fluids each parameter occurs once in each number, so that enclosures are
    tight.  The same numbers as those that follow from `mode_parameters`, but for rounding.
    """
    p = parameters
    section = relative_section_numbers(p["radius"], p["inner_radius"])
    own = own_mass(p["density"], p["fluid_inside"], section)
    mass = inertia(own, p["fluid_outside"], p["added_mass_coefficient"], section)
    # Weight over inertia is `weighing_mass` over ``mass``, here with own mass in one place: exactly 1 without a fluid.
    displaced = (1.0 + p["added_mass_coefficient"]) * p["fluid_outside"] * section.outer / mass
    pull = effective_gravity(gravity_across(p["gravity"], p["inclination"], sin), 1.0 - displaced)
    w = first_wavenumber(p["length"], pi)
    return ModeNumbers(
        rigidity(p["youngs_modulus"], section) / mass * w**4,
        w**2 / (ring(p["radius"], p["inner_radius"], pi) * mass),
        pendulum_squared(pull, clearance(p["radius"], p["channel_radius"])),
        p["damping_rate"],
    )
