"""Unstable bands of a rod whose modes are independent, between exact curves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from floquetrod._util.progress import Progress
from floquetrod.mathieu.tongue_bands import tongue_bands
from floquetrod.mathieu.tongue_curves import Window
from floquetrod.mathieu.tongue_regions import UndampedEquations
from floquetrod.plane import Axis, FoundBands
from floquetrod.rod.kernels.modes import mode_coefficients, mode_family
from floquetrod.rod.loads.load import LIMITS, AxialLoad, Quantity
from floquetrod.rod.model.constants import SLOW_GROWTH, ModeConstants


@dataclass(frozen=True)
class ExactBands:
    """Finds the bands of a map over two of mean force, amplitude and frequency.

    Attributes
    ----------
    constants : ModeConstants
    across, up : str
        Quantities of the axes.
    fixed : float
        The third quantity.
    growth_tolerance : float
        In 1/s.
    """

    constants: ModeConstants
    across: Quantity
    up: Quantity
    fixed: float
    growth_tolerance: float

    def __call__(self, x: Axis, y: Axis, accuracy: float, progress: Progress | None) -> FoundBands:
        """Return the bands of every mode that can matter."""
        ranges: dict[Quantity, tuple[float, float]] = {
            name: (float(axis.values[0]), float(axis.values[-1])) for name, axis in ((self.across, x), (self.up, y))
        }
        largest = (ranges.get(name, (self.fixed, self.fixed))[1] for name in LIMITS)
        last, _ = self.constants.modes_needed(AxialLoad(*largest), self.growth_tolerance)
        modes = np.arange(1.0, last + 1.0)
        gain, stiffness = mode_coefficients(*mode_family(*self.constants[:4], 0.0, 1.0, 1.0), modes)
        damping = self.constants.damping_rate
        oscillators = UndampedEquations(-stiffness - damping**2, gain, damping, self.growth_tolerance, SLOW_GROWTH)
        # Parts of tongues are single intervals on lines along the mean, and on those along the frequency.
        along: Literal["mean", "frequency"] = "mean" if "mean" in ranges else "frequency"
        over: Literal["frequency", "amplitude"] = "amplitude" if "amplitude" in ranges else "frequency"
        window = Window(along, over, self.fixed, *ranges[along], ranges[over])
        return tongue_bands(oscillators, window, self.across, accuracy, progress, are_modes=True)
