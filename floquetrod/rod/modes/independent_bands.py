"""Unstable bands of a rod whose modes are independent, between exact curves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from floquetrod._util.arrays import Bools
from floquetrod._util.progress import Progress
from floquetrod.mathieu.tongue_bands import tongue_bands
from floquetrod.mathieu.tongue_curves import Window
from floquetrod.mathieu.tongue_regions import UndampedEquations
from floquetrod.plane import Axis, Band, FoundBands
from floquetrod.rod.kernels.independent_modes import mode_coefficients, mode_family
from floquetrod.rod.loads.load import QUANTITIES, AxialLoad, Quantity
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

    def __call__(self, x: Axis, y: Axis, accuracy: float, progress: Progress | None) -> FoundBands | None:
        """Return the bands of every mode that can matter; None where the rod does not stay on one side of its wall.

        None as well where a mode is exactly as long as compression neither holds nor drives: it has no curves.
        """
        ranges = self._ranges(x, y)
        constants = self._lying(ranges)
        if constants is None:
            return None
        last, _ = constants.modes_needed(AxialLoad(*(ranges[name][1] for name in QUANTITIES)), self.growth_tolerance)
        modes = np.arange(1, last + 1)
        gain, stiffness = mode_coefficients(*mode_family(*constants[:4], 0.0, 1.0, 1.0), modes)
        if not gain.all():
            return None
        # Parts of tongues are single intervals on lines along the mean, and on those along the frequency.
        along: Literal["mean", "frequency"] = "mean" if "mean" in (self.across, self.up) else "frequency"
        over: Literal["frequency", "amplitude"] = "amplitude" if "amplitude" in (self.across, self.up) else "frequency"
        window = Window(along, over, self.fixed, *ranges[along], ranges[over])
        damping = self.constants.damping_rate

        def bands_of(chosen: Bools, window: Window) -> FoundBands:
            squared = -stiffness[chosen] - damping**2
            oscillators = UndampedEquations(squared, np.abs(gain[chosen]), damping, self.growth_tolerance, SLOW_GROWTH)
            return tongue_bands(oscillators, window, self.across, accuracy, progress, modes=modes[chosen])

        driven = bands_of(gain > 0.0, window)
        if gain[0] > 0.0:
            return driven
        held = bands_of(gain < 0.0, _mirrored(window))
        bands = held.bands if along == "frequency" else tuple(map(self._mirrored_back, held.bands))
        left_out = driven.tongues_left_out + held.tongues_left_out
        return driven._replace(bands=(*bands, *driven.bands), tongues_left_out=left_out)

    def _ranges(self, x: Axis, y: Axis) -> dict[Quantity, tuple[float, float]]:
        """Return the least and the largest of each quantity in the window."""
        axes = {self.across: x, self.up: y}
        ends = {name: (float(axis.values[0]), float(axis.values[-1])) for name, axis in axes.items()}
        return {name: ends.get(name, (self.fixed, self.fixed)) for name in QUANTITIES}

    def _lying(self, ranges: dict[Quantity, tuple[float, float]]) -> ModeConstants | None:
        """Return the constants on the side where the rod lies in all of the window, None where there is none."""
        sides = self.constants.sides(np.array(ranges["mean"]), max(ranges["amplitude"]))
        return self.constants.on_side(int(sides[0])) if sides[0] == sides[1] != 0 else None

    def _mirrored_back(self, band: Band) -> Band:
        """Return a band with the sign of the mean turned."""
        across = self.across == "mean"
        x, y = (-band.x, band.y) if across else (band.x, -band.y)
        place = (-band.place[0], band.place[1]) if across else (band.place[0], -band.place[1])
        return replace(band, x=x, y=y, place=place)


def _mirrored(window: Window) -> Window:
    """Return a window in which the mean force has the other sign.

    A mode that compression holds is one that tension drives; the sign of an amplitude only shifts time.
    """
    if window.along == "mean":
        return window._replace(low=-window.high, high=-window.low)
    return window._replace(fixed=-window.fixed)
