"""Axial and bending stress of a rod that lies in its channel, before it moves, and how far that is from yield."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.interchange import by_keys
from floquetrod.rod.loads.axial import largest_along, wave_ratio
from floquetrod.rod.loads.load import Load
from floquetrod.rod.model.course import weight_gained
from floquetrod.units import Unit, unit

_MOST_WAVES = 100_000  # six million places
_PLACES = 257  # and 64 more for each axial wave: a largest stress between two of them is missed by a thousandth


@dataclass(frozen=True)
class Stress:
    """Largest stress in a rod at rest in its channel, at the outer radius of the section where it occurs.

    Attributes
    ----------
    axial : float
        Largest size over a period of the effective force at that section over the area of the material, in Pa.  With
        equal pressures inside and outside it is the von Mises stress of the wall without bending.
    bending : float
        E r_o times the curvature of the channel there and the residual one of the rod, in Pa.
    position : float
        Distance of the section from the upper end in m.
    yield_strength : float or None
        That of the rod in Pa, None where it is not known.
    excess_inside : float
        Pressure inside less that outside at that section in Pa; 0 where they are taken as equal.
    von_mises : float, optional
        Von Mises' stress in Pa at the inner or the outer radius, where the pressures are not taken as equal.
    section : int, optional
        Of several sections the number, from 1, of the one where the share of its yield strength is largest; where no
        strength is known, the stress.

    Examples
    --------
    >>> import floquetrod as fr
    >>> pipe = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0, curvature="3deg/30m")
    >>> pipe.stress(fr.AxialLoad("20kN", "5kN", "15Hz"))
    <at most 52.1 MPa, 8.4 % of the yield strength 621 MPa: axial 42.9 MPa, bending 9.18 MPa>
    """

    axial: float
    bending: float
    position: float
    yield_strength: float | None
    excess_inside: float = 0.0
    von_mises: float | None = None
    section: int | None = None

    @property
    def largest(self) -> float:
        """Von Mises' stress in Pa, axial and bending stress together where the pressures are equal."""
        return self.axial + self.bending if self.von_mises is None else self.von_mises

    @property
    def share_of_yield(self) -> float | None:
        """``largest`` over the yield strength, None where that is not known."""
        return None if self.yield_strength is None else self.largest / self.yield_strength

    def as_dict(self) -> dict[str, Any]:
        """Return the stresses in Pa, plain numbers; None where they are infinite."""
        section = "" if self.section is None else " section"
        return by_keys(self, f"axial_Pa bending_Pa largest_Pa position_m yield_strength_Pa share_of_yield{section}")

    def __str__(self) -> str:
        """Return the stresses in a line, in MPa."""
        return self.in_words(unit("MPa", "", "pressure"))

    def in_words(self, shown: Unit) -> str:
        """Return the stresses in a line, in a unit."""
        share = "" if self.yield_strength is None else self._of_yield(shown)
        section = "" if self.section is None else f", in section {self.section}"
        whole = f"at most {shown.show(self.largest, 3)}{share}{section}"
        parts = f": axial {shown.show(self.axial, 3)}, bending {shown.show(self.bending, 3)}"
        if self.von_mises is not None:
            side = "inside" if self.excess_inside >= 0.0 else "outside"
            return f"{whole}{parts}, von Mises with {shown.show(abs(self.excess_inside), 3)} more {side}"
        return f"{whole}{parts}" if self.bending else whole

    def __repr__(self) -> str:
        """Return the stresses in brackets."""
        return f"<{self}>"

    def _of_yield(self, shown: Unit) -> str:
        strength = f"the yield strength {shown.show(self.yield_strength or 0.0, 3)}"
        share = self.share_of_yield
        assert share is not None  # noqa: S101
        return f", beyond {strength}" if share > 1.0 else f", {100.0 * share:.2g} % of {strength}"


def stress(rod: Any, load: Load) -> Stress:
    """Return what `RodData.stress` does."""
    waves = 0.0 if load.is_uniform else len(load.harmonics) * wave_ratio(rod, load)
    if waves > _MOST_WAVES:
        raise wrong_value("frequency", f"must make at most {_MOST_WAVES:,} axial waves along the rod, got {waves:.3g}")
    x = np.union1d(np.linspace(0.0, 1.0, _PLACES + math.ceil(64.0 * waves)), rod.course.samples)
    mean = load.mean + (0.0 if load.mean_at is None else weight_gained(rod, x, load.mean_at))
    every = [part.rod for part in rod.uniform_parts]
    index = np.searchsorted(rod.edges[1:-1], x, side="right")
    area = np.array([each.area for each in every])[index]
    stiffness = np.array([each.youngs_modulus * each.radius for each in every])[index]
    axial = (np.abs(mean) + largest_along(load, rod.axial_line, x * rod.length)) / area
    place = rod.course.place(x)
    curvature = np.broadcast_to(np.hypot(place.kappa_n, place.kappa_b), x.shape)
    bending = stiffness * (curvature + rod.residual_curvature)
    strengths = [each.yield_strength for each in every]
    # Where a strength is not known its section is no nearer to yield than any other: the largest share is of the known.
    known = np.array([math.inf if strength is None else strength for strength in strengths])[index]
    share = (axial + bending) / known if any(strengths) else axial + bending
    worst = int(np.argmax(share))
    number = int(index[worst])
    found = Stress(float(axial[worst]), float(bending[worst]), float(x[worst] * rod.length), strengths[number])
    return replace(found, section=rod.uniform_parts[number].section + 1) if rod.varies else found
