"""Stress along a string in a well: of its force, of the bends of the well and of a helix or waves, and of pressure.

Lame's stresses in a tube under pressures p_i inside and p_o outside are sigma_r = A - B / r^2 and
sigma_h = A + B / r^2 at the radius r, with A = (p_i r_i^2 - p_o r_o^2) / (r_o^2 - r_i^2) and
B = (p_i - p_o) r_i^2 r_o^2 / (r_o^2 - r_i^2).  A string under the effective compression F has the wall force
F - p_i A_i + p_o A_o, thus the axial stress A - F / A_s, and von Mises' stress is

    sqrt((F / A_s + bending)^2 + 3 (B / r^2)^2):

a pressure on both sides drops out, and only the difference p_i - p_o counts.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod.rod.answers.assembly import CrossSections, cells_of
from floquetrod.rod.answers.mean_force import MeanForce
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.wellhead import OPEN, Wellhead
from floquetrod.wells.path import WellPath


class StressAlong(NamedTuple):
    """Sizes of the stress in Pa at depths along a string, infinite where it is locked up.

    ``axial`` is due to the effective force, ``bending`` holds at the outer radius, and ``largest`` is von Mises' stress
    at the inner or the outer radius.
    """

    axial: Floats
    bending: Floats
    largest: Floats


def stress_along(
    rod: RodData, path: WellPath, along: MeanForce, amplitude: Floats, wellhead: Wellhead = OPEN
) -> StressAlong:
    """Return the largest stress in the section, with the vibration of the force in N.

    E r_o times the curvature of the well, and of a helix R theta'^2 = R F / (2 E I), which waves are given, too.  Both
    are added, as where a turn of the helix bends the string the way the well does, and the curvature that the string
    has without load, as where it is bent against that.
    """
    bent = np.hypot(*path.curvature(along.depth))
    is_wound = along.is_snaking | along.is_helix
    excess = excess_inside(rod, path, along.depth, wellhead)
    return stress_of(cells_of(rod, along).cross_sections, bent, along.force, is_wound, amplitude, excess)


def excess_inside(rod: RodData, path: WellPath, depth: Floats, wellhead: Wellhead) -> Floats | None:
    """Return the pressure inside less that around the string in Pa at measured depths in m; None for none."""
    if wellhead.pressure_inside is None:
        return None
    return wellhead.excess_inside(rod.fluids, rod.gravity, path.position(depth)[..., 2])


def stress_of(
    rod: RodData | CrossSections, bent: Floats, force: Floats, is_wound: Bools, amplitude: Any, excess: Floats | None
) -> StressAlong:
    """Return the stress where a well has a curvature in 1/m, from the force in N and its vibration.

    ``excess`` is the pressure inside less that around the string in Pa, None where they are equal.
    """
    push = np.where(is_wound, np.maximum(force, 0.0), 0.0)
    wound = push * rod.radial_clearance / (2.0 * rod.flexural_rigidity)
    axial = (np.abs(force) + amplitude) / rod.area
    bending = rod.youngs_modulus * rod.radius * (bent + wound + rod.residual_curvature)
    if excess is None:
        return StressAlong(axial, bending, np.asarray(axial + bending))
    inner, outer = rod.inner_radius, rod.radius
    inside = math.sqrt(3.0) * outer**2 / (outer**2 - inner**2) * excess  # sqrt(3) B / r_i^2
    at_inner = np.hypot(axial + inner / outer * bending, inside)
    at_outer = np.hypot(axial + bending, (inner / outer) ** 2 * inside)
    return StressAlong(axial, bending, np.maximum(at_outer, at_inner))
