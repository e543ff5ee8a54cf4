"""Stress along a string in a well: its force, the bends of the well, and those of a helix or waves."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.rod.answers.mean_force import MeanForce
from floquetrod.rod.model.data import RodData
from floquetrod.wells.path import WellPath


class StressAlong(NamedTuple):
    """Sizes of the stress in Pa at depths along a string, infinite where it is locked up."""

    axial: Floats
    bending: Floats


def stress_along(rod: RodData, path: WellPath, along: MeanForce, amplitude: Floats) -> StressAlong:
    """Return the largest stress in the section, with the vibration of the force in N.

    E r_o times the curvature of the well, and of a helix R theta'^2 = R F / (2 E I), which waves are given, too.  Both
    are added, as where a turn of the helix bends the string the way the well does.
    """
    bent = np.hypot(*path.curvature(along.depth))
    push = np.maximum(along.force, 0.0)
    wound = (
        np.where(along.is_snaking | along.is_helix, push, 0.0) * rod.radial_clearance / (2.0 * rod.flexural_rigidity)
    )
    axial = (np.abs(along.force) + amplitude) / rod.area
    return StressAlong(axial, rod.youngs_modulus * rod.radius * (bent + wound))
