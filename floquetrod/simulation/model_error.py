"""Differences between the growth of a simulated rod and its linear equations', estimated by these equations."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

from floquetrod.rod.loads.axial import wave_ratio
from floquetrod.rod.loads.load import AxialLoad, Load, with_waves
from floquetrod.rod.model.assumptions import UNIFORM_UP_TO
from floquetrod.rod.rod import Rod
from floquetrod.simulation.driving import least_axial_rigidity

_MORE = 1.25  # of the effect of segments, for what one wavenumber leaves out (a choice)
_AT_THE_ENDS = 4.0  # times more where an end is clamped or free, and shapes change fast (measured: up to 3.5)
_AT_EDGES = 0.25  # of (k l)^2 / (k L) by which a jump to any stiffness changes it (measured: up to 0.2)
_STRAINED = 5.0  # of the strain, by which growth falls short besides (measured: 3 to 4)
_ANGLE = 0.05  # rad: the effect of other angles follows from it, as their square


class ModelErrors(NamedTuple):
    """How far growth changes with each departure from the linear equations, in 1/s.

    Attributes
    ----------
    segments : float
        Derivatives along the discretised rod have errors of fourth order; with a margin.
    floor : float
        The weight at rest indents the floor: the rod swings on a larger circle.
    strain : float
        The force shortens the rod; with a margin.
    large_angle : float
        Angles up to 0.05 rad are not small: bending stiffens, the weight pulls back less.
    edges : float
        Where sections meet, derivatives along the discretised rod have errors of second order.
    steps : float
        Beside a step of the wall or of the rod's radius the rod rests off the wall, and presses to its edge instead.
    """

    segments: float
    floor: float
    strain: float
    large_angle: float
    edges: float = 0.0
    steps: float = 0.0

    def up_to(self, angle: float) -> float:
        """Return the sum of all for motion up to an angle in rad."""
        plain = self.segments + self.floor + self.strain + self.edges + self.steps
        return plain + self.large_angle * (angle / _ANGLE) ** 2


def model_errors(
    rod: Rod,
    load: Load,
    mode: int | None,
    wavenumber: float,
    segment: float,
    indentation: float,
    rate: float,
    lifted: float = 0.0,
) -> ModelErrors:
    """Return the changes for motion of a wavenumber in 1/m, in a mode that is independent or, with None, in all modes.

    ``segment`` is the length of a segment in m, ``indentation`` the depth to which the floor is indented, as a fraction
    of the radial clearance, and ``rate`` about the growth rate in 1/s: modes that cannot grow so fast are left out.
    ``lifted`` is the part of the rod that rests off the wall.

    With sigma = sin(k l / 2) the scheme has (2 sigma / l) (1 + sigma^2 / 6) for a derivative and
    (2 sigma / l)^2 (1 + sigma^2 / 3) for the curvature of directions, in place of k and k^2.  Large angles: the cubic
    terms of EI (theta'''' - 6 theta'^2 theta'') and of the weight, averaged over a standing wave.
    """
    if isinstance(load, AxialLoad) and wave_ratio(rod, load) > UNIFORM_UP_TO:
        # What an AxialLoad does to a rod of this length.
        load = with_waves(load)
    modes = rod._modes_under(load).showing(load, mode, 0.25 * rate)

    def growth(*, bending: float = 1.0, force: float = 1.0, weight: float = 1.0) -> float:
        pushed = load.with_numbers(force * load.mean, force * load.amplitude, load.frequency)
        return modes.changed(bending, force, weight).growth_of(pushed, mode)

    plain = growth()

    def change(**factors: float) -> float:
        difference = abs(growth(**factors) - plain)
        return difference if math.isfinite(difference) else math.inf

    half = 0.5 * wavenumber * segment
    squared = math.sin(half) ** 2
    slope = squared * (1.0 + squared / 6.0) ** 2 / half**2
    curvature = squared * (1.0 + squared / 3.0) / half**2
    strain = (abs(load.mean) + load.amplitude) / least_axial_rigidity(rod)
    longer = 1.0 / (1.0 - strain)
    jumps = sum(
        1.0 - min(above / below, below / above)
        for above, below in itertools.pairwise(part.rod.flexural_rigidity for part in rod.uniform_parts)
    )
    uneven = _AT_EDGES * jumps * wavenumber * segment**2 / rod.length
    ends = rod.end_conditions
    more = _MORE * (_AT_THE_ENDS if {ends.upper, ends.lower} & {"clamped", "free"} else 1.0)
    return ModelErrors(
        segments=more * change(bending=slope * curvature, force=slope),
        floor=change(weight=1.0 / (1.0 + indentation)),
        strain=2.0 * change(bending=longer**2, force=longer) + _STRAINED * strain * rate,
        large_angle=change(bending=1.0 + 9.0 / 8.0 * _ANGLE**2, weight=1.0 - 3.0 / 32.0 * _ANGLE**2),
        edges=change(bending=1.0 + uneven) if rod.varies else 0.0,
        steps=max(change(weight=1.0 - lifted), change(weight=1.0 + lifted)) if lifted else 0.0,
    )
