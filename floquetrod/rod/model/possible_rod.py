"""What makes a rod impossible, or its parameters unknown to verdicts: one rule for a rod, samples and boxes of rods.

Numbers are parameters of a rod in SI units by name: floats of one rod, or arrays of samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Bools
from floquetrod.parameter import is_known, require_known
from floquetrod.rod.model import formulas
from floquetrod.rod.model.parameters import ROD


class Requirement(NamedTuple):
    """A condition that the numbers of a rod fulfil together, and the error of a rod that does not."""

    holds: Callable[[Mapping[str, Any]], Any]  # a bool, or an array of bools
    refusal: Callable[[Mapping[str, float]], ValueError]

    def check(self, numbers: Mapping[str, float]) -> None:
        """Raise ValueError where the floats of one rod do not fulfil it."""
        if not self.holds(numbers):
            raise self.refusal(numbers)


def _masses(p: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return own mass and weighing mass in kg/m."""
    area, bore = formulas.ring(p["radius"], p["inner_radius"]), formulas.disc(p["inner_radius"])
    own = formulas.own_mass(p["density"], p["fluid_inside"], area, bore)
    return own, formulas.weighing_mass(own, p["fluid_outside"], formulas.disc(p["radius"]))


def _has_wall(p: Mapping[str, Any]) -> Any:
    return formulas.has_wall(p["radius"], p["inner_radius"])


def _fits(p: Mapping[str, Any]) -> Any:
    return formulas.fits(p["radius"], p["channel_radius"])


def _sinks(p: Mapping[str, Any]) -> Any:
    return formulas.sinks(*_masses(p))


def _no_wall(p: Mapping[str, float]) -> ValueError:
    inner, outer = p["inner_radius"], p["radius"]
    return wrong_value(
        "inner_radius",
        f"must be less than the outer radius, got {inner:g} m and {outer:g} m: half of inner_diameter = "
        f"{2.0 * inner:g} m and of diameter = {2.0 * outer:g} m",
    )


def _no_room(p: Mapping[str, float]) -> ValueError:
    channel, outer = p["channel_radius"], p["radius"]
    return wrong_value(
        "channel_radius",
        f"must exceed the rod's radius, got {channel:g} m and {outer:g} m: half of channel_diameter = "
        f"{2.0 * channel:g} m and of diameter = {2.0 * outer:g} m",
    )


def _floats(p: Mapping[str, float]) -> ValueError:
    weight = p["gravity"] * _masses(p)[1]
    return wrong_value(
        "fluid_outside",
        f"must be lighter than the rod with what is inside, got {p['fluid_outside']:g} kg/m^3 "
        f"for density = {p['density']:g} and fluid_inside = {p['fluid_inside']:g}, a weight of "
        f"{weight:.4g} N/m: this rod floats",
    )


HAS_WALL = Requirement(_has_wall, _no_wall)
"""A tube's wall is thick enough to count as one."""

FITS = Requirement(_fits, _no_room)
"""The rod has room in its channel."""

SINKS = Requirement(_sinks, _floats)
"""The rod lies on the floor."""

REQUIREMENTS = (HAS_WALL, FITS, SINKS)
"""What the numbers of every rod fulfil together."""


def require_possible(numbers: Mapping[str, float]) -> None:
    """Raise ValueError, naming the argument, where numbers within their limits are no possible rod."""
    for requirement in REQUIREMENTS:
        requirement.check(numbers)


def are_possible(numbers: Mapping[str, Any]) -> Bools:
    """Return which samples are possible rods within the limits of their numbers, and known to verdicts."""
    good = np.ones((), dtype=np.bool_)
    for name, values in numbers.items():
        good = good & (ROD[name].least <= values) & (values <= ROD[name].largest)
    if good.all():  # the limits keep the formulas in range
        for requirement in REQUIREMENTS:
            good = good & requirement.holds(numbers)
    is_straight = np.equal(numbers["curvature"], 0.0)
    known = np.where(is_straight, is_known(numbers, ROD, "modes"), is_known(numbers, ROD, "bends"))
    return np.asarray(good & known)


def require_known_to_verdicts(rod: Any) -> None:
    """Raise ValueError where verdicts on the modes of a rod would ignore one of its parameters."""
    require_known(rod, ROD, "modes" if rod.course.is_straight else "bends")
