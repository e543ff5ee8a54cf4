"""Unstable bands of a rod whose modes are independent, between exact curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floquetrod.mathieu.tongue_bands import make_bands
from floquetrod.mathieu.tongue_curves import Plane
from floquetrod.mathieu.tongue_regions import Family
from floquetrod.plane import Axis, Bands, Progress
from floquetrod.rod.kernels.modes import mode_coefficients, mode_family
from floquetrod.rod.loads.load import LIMITS, AxialLoad, Quantity
from floquetrod.rod.model.constants import HAIRLINE_GROWTH, ModeConstants


@dataclass(frozen=True)
class ExactRodBands:
    """Finds the bands of a map over two of mean force, amplitude and frequency.

    Attributes
    ----------
    constants : ModeConstants
    across, up : str
        Quantities of the axes.
    x, y : Axis
        The axes, their values the ends.
    fixed : float
        The third quantity.
    growth_tolerance : float
        In 1/s.
    """

    constants: ModeConstants
    across: Quantity
    up: Quantity
    x: Axis
    y: Axis
    fixed: float
    growth_tolerance: float

    @property
    def prompt(self) -> bool:
        """Whether the bands are found about as fast as a chart; they are."""
        return True

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands of every mode that can matter."""
        ranges: dict[Quantity, tuple[float, float]] = {
            name: (float(axis.values[0]), float(axis.values[1]))
            for name, axis in ((self.across, self.x), (self.up, self.y))
        }
        mean, amplitude, frequency = (ranges.get(name, (self.fixed, self.fixed))[1] for name in LIMITS)
        load = AxialLoad(mean, amplitude, frequency)
        last, _ = self.constants.modes_needed(load, self.growth_tolerance)
        modes = np.arange(1.0, last + 1.0)
        gain, stiffness = mode_coefficients(*mode_family(*self.constants[:3], 0.0, 1.0, 1.0), modes)
        damping = self.constants.damping_rate
        family = Family(
            -stiffness - damping**2,
            gain,
            damping + self.growth_tolerance,
            damping + (self.growth_tolerance or HAIRLINE_GROWTH),
        )
        # Parts of tongues are single intervals on lines along the mean, and on those along the frequency.
        if "mean" not in ranges:
            plane = Plane("frequency", "amplitude", self.fixed, *ranges["frequency"], ranges["amplitude"])
        elif "frequency" in ranges:
            plane = Plane("mean", "frequency", self.fixed, *ranges["mean"], ranges["frequency"])
        else:
            plane = Plane("mean", "amplitude", self.fixed, *ranges["mean"], ranges["amplitude"])
        return make_bands(
            family,
            plane,
            self.x,
            self.y,
            lines_across=self.across == plane.over,
            numbered=True,
            damping=damping,
            growth_unit="1/s",
            growth_tolerance=self.growth_tolerance,
            accuracy=accuracy,
            progress=progress,
        )
