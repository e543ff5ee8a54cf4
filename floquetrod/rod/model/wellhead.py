"""The wellhead that a string is pushed or pulled through: pressures there, and the friction of the stripper.

The mean force along a string is the effective compression F = F_wall + p_i A_i - p_o A_o.  A straight cylinder feels no
axial force from the pressure on its side, so that F_wall changes in the stripper by its friction f alone.  Above it
p_o is the pressure of the air.  The pipe carries the pressure inside on to the reel or the swivel; the injector's force
is F + p_wh A_o + f for a string pushed in and F + p_wh A_o - f for one pulled out (Newman, Bhalla & McSpadden, Basic
Tubing Forces Model, CTES 2003: weight = F_E - WHP A_o -+ stripper).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Floats
from floquetrod._util.interchange import by_keys
from floquetrod.parameter import Option, Parameter, by_name
from floquetrod.rod.model.cross_section import CrossSection, Fluids
from floquetrod.units import AnswerUnits, GivenUnits, InUnits
from floquetrod.wells.drag import MOTIONS

_HIGHEST, _TIGHTEST = 1e9, 1e7  # Pa and N (a choice: a hundred times what is usual)

WELLHEAD = by_name(
    Parameter(
        name="wellhead_pressure",
        symbol="p_wh",
        kind="pressure",
        least=0.0,
        largest=_HIGHEST,
        default=0.0,
        known_to=frozenset({"strings"}),
        hint='it is the pressure around the string below the stripper, above that of the air: in Pa, or "3000psi"',
        option=Option("pressure around the string below the stripper such as 3000psi (default 0)", "PRESSURE"),
    ),
    Parameter(
        name="stripper",
        symbol="f",
        kind="force",
        least=0.0,
        largest=_TIGHTEST,
        default=0.0,
        known_to=frozenset({"strings"}),
        hint='it is the friction of the stripper: in N, or "4500lbf"',
        option=Option("friction of the stripper such as 4500lbf (default 0)", "FORCE"),
    ),
    Parameter(
        name="pressure_inside",
        symbol="p_i",
        kind="pressure",
        least=0.0,
        largest=_HIGHEST,
        default=None,
        known_to=frozenset({"strings"}),
        hint='it is the pressure in the string at its upper end, above that of the air: in Pa, or "4000psi"',
        option=Option(
            "pressure in the string at its upper end such as 4000psi, for its stress (default: that around it, all "
            "along)",
            "PRESSURE",
        ),
    ),
)
"""Parameters of a wellhead by their names."""


@dataclass(frozen=True)
class Wellhead(InUnits):
    """A wellhead, checked by `of`.

    Parameters
    ----------
    wellhead_pressure : float
        Pressure around the string below the stripper in Pa, above the pressure of the air.
    stripper : float
        Friction of the stripper in N.
    pressure_inside : float, optional
        Pressure in the string at its upper end in Pa, None where it is taken as equal to the pressure around it.
    """

    wellhead_pressure: float = 0.0
    stripper: float = 0.0
    pressure_inside: float | None = None

    @classmethod
    def of(cls, **given: Any) -> Self:
        """Return a wellhead from numbers or strings with a unit; ValueError or TypeError, naming the argument."""
        numbers: dict[str, Any] = {
            name: None if name == "pressure_inside" and value is None else WELLHEAD[name].number(value)
            for name, value in given.items()
        }
        pressures = [given.get(name) for name in ("wellhead_pressure", "pressure_inside")]
        return cls(**numbers).given_in(GivenUnits.of(pressure=pressures, force=given.get("stripper")))

    def require_tube(self, section: CrossSection) -> None:
        """Raise ValueError for a pressure inside a string that is solid."""
        if self.pressure_inside is not None and not section.inner_radius:
            raise wrong_value(
                "pressure_inside",
                f"is that in a tube, and this rod is solid, got {self.pressure_inside:g} Pa; leave it out, or give the "
                "rod an inner_radius",
            )

    def added(self, section: CrossSection, motion: str) -> float:
        """Return the compression in N at the injector beyond the effective one below the stripper."""
        return self.wellhead_pressure * section.outer_area + MOTIONS[motion] * self.stripper

    def excess_inside(self, fluids: Fluids, gravity: float, vertical: Floats) -> Floats | None:
        """Return the pressure inside less that around the string in Pa at vertical depths in m below the wellhead.

        Of fluids at rest; None where both are taken as equal.
        """
        if self.pressure_inside is None:
            return None
        heavier = gravity * (fluids.inside - fluids.outside)
        return np.asarray(self.pressure_inside - self.wellhead_pressure + heavier * vertical)

    def as_dict(self) -> dict[str, float | None]:
        """Return the parameters in SI units, units in the keys."""
        return by_keys(self, "wellhead_pressure_Pa stripper_N pressure_inside_Pa")

    def in_words(self, section: CrossSection, motion: str, shown: AnswerUnits) -> str:
        """Return what the wellhead adds at the injector, in units."""
        force, pressure = shown.force, shown.pressure.show(self.wellhead_pressure, 4)
        pushed_out = f"{force.show(self.wellhead_pressure * section.outer_area, 4)} by {pressure} on the cross-section"
        parts = [pushed_out] if self.wellhead_pressure else []
        parts += [f"{force.show(MOTIONS[motion] * self.stripper, 4)} by the stripper"] if self.stripper else []
        return f"{force.show(self.added(section, motion), 4)} of push at the injector: {' and '.join(parts)}"


OPEN = Wellhead()
"""A wellhead without pressure and stripper."""
