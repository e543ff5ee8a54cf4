"""Where the explorer begins, and how far its sliders go: as far as the rod makes sense of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod.rod.loads.load import AxialLoad, Load
from floquetrod.rod.rod import Rod
from floquetrod.units import Unit

_STRONGEST = 50.0  # times the force of `Scale`: beyond, a map takes too long for interactive use
_SLOWEST = 1000.0  # times slower than the frequency of `Scale`, and faster (a choice)
_STEPS = 1000  # of a slider at least, each a round number


class Scale(NamedTuple):
    """What loads of a rod are measured by."""

    force: float  # critical force in N; of a rod shorter than its critical half wave the larger one that buckles it
    frequency: float  # pendulum frequency in rad/s; of such a rod the larger frequency of its first mode

    @classmethod
    def of(cls, rod: Rod) -> Scale:
        """Return the scale of a rod; ends other than hinged double the scale of a short one, as clamped ones do."""
        if rod.critical_mode >= 1.0:
            return cls(rod.critical_force, rod.pendulum_frequency)
        first = float(rod.natural_frequency(1)) * (1.0 if rod.end_conditions.are_hinged else 2.0)
        return cls(first**2 * rod.mass_per_length * (rod.length / math.pi) ** 2, first)

    def first_load(self, shown: Mapping[str, Unit]) -> AxialLoad:
        """Return where to begin, in the middle of things, in three digits of the units shown."""
        numbers = {"mean": 0.2 * self.force, "amplitude": 0.2 * self.force, "frequency": 3.0 * self.frequency}
        rounded = {n: float(shown[n].si(float(f"{shown[n].of(value):.3g}"))) for n, value in numbers.items()}
        return AxialLoad(rounded["mean"], rounded["amplitude"], rounded["frequency"])

    def require(self, load: Load) -> None:
        """Raise ValueError for a load out of reach."""
        for name in ("mean", "amplitude"):
            most = _STRONGEST * self.force
            validate.within(name, getattr(load, name), -most, most, "these are in N")
        slowest, fastest = self.frequency / _SLOWEST, self.frequency * _SLOWEST
        validate.within("frequency", load.frequency, slowest, fastest, "these are in rad/s")

    def limits(self, load: Load) -> dict[str, tuple[float, float]]:
        """Return the ends of each slider in SI units; the load given lies within."""
        force, frequency = self
        return {
            "mean": (min(0.0, 1.25 * load.mean), max(1.1 * force, load.mean)),
            "amplitude": (0.0, max(0.7 * force, load.amplitude)),
            "frequency": (min(0.4 * frequency, load.frequency), max(5.0 * frequency, load.frequency)),
        }


def step(low: float, high: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that fits a thousand times between the ends.

    >>> step(0.0, 1.9)
    0.001
    """
    most = (high - low) / _STEPS
    power = 10.0 ** math.floor(math.log10(most))
    return float(power * np.array([1.0, 2.0, 5.0])[np.array([1.0, 2.0, 5.0]) * power <= most * (1.0 + 1e-9)][-1])
