"""Stress along a string in a well: of its force, of the bends of the well, and of the bends of a helix or waves."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod.rod.answers.mean_force import MeanForce
from floquetrod.rod.model.data import RodData
from floquetrod.wells.path import WellPath


class StressAlong(NamedTuple):
    """Sizes of the stress in Pa at depths along a string, infinite where it is locked up."""

    axial: Floats
    bending: Floats

    @property
    def largest(self) -> Floats:
        """Both together."""
        return np.asarray(self.axial + self.bending)


def stress_along(rod: RodData, path: WellPath, along: MeanForce, amplitude: Floats) -> StressAlong:
    """Return the largest stress in the section, with the vibration of the force in N.

    E r_o times the curvature of the well, and of a helix R theta'^2 = R F / (2 E I), which waves are given, too.  Both
    are added, as where a turn of the helix bends the string the way the well does.
    """
    bent = np.hypot(*path.curvature(along.depth))
    return stress_of(rod, bent, along.force, along.is_snaking | along.is_helix, amplitude)


def stress_of(rod: RodData, bent: Floats, force: Floats, is_wound: Bools, amplitude: Any) -> StressAlong:
    """Return the stress where a well has a curvature in 1/m, from the force in N and its vibration."""
    push = np.where(is_wound, np.maximum(force, 0.0), 0.0)
    wound = push * rod.radial_clearance / (2.0 * rod.flexural_rigidity)
    return StressAlong((np.abs(force) + amplitude) / rod.area, rod.youngs_modulus * rod.radius * (bent + wound))
