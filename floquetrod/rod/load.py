"""The load that pushes a rod's ends together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate

LARGEST_FORCE = 1e12  # N
LEAST_FREQUENCY, LARGEST_FREQUENCY = 1e-9, 1e12  # rad/s: beyond any rod, and within what doubles can follow

_BOUNDS = {
    "mean": (-LARGEST_FORCE, LARGEST_FORCE),
    "amplitude": (0.0, LARGEST_FORCE),
    "frequency": (LEAST_FREQUENCY, LARGEST_FREQUENCY),
}


def load_array(name: str, values: Any) -> NDArray[np.float64]:
    """Return mean forces (N), amplitudes (N) or frequencies (rad/s), as ``name`` says, within what a load may have."""
    least, largest = _BOUNDS[name]
    return validate.array(name, values, least=least, largest=largest)


@dataclass(frozen=True)
class AxialLoad:
    """Force F(t) = mean + amplitude sin(frequency t) that pushes both ends of the rod inwards.

    Parameters
    ----------
    mean : float
        F_ave in N; negative pulls.
    amplitude : float
        dF in N, zero or more; zero is the static limit.
    frequency : float
        omega in rad/s, greater than zero; `AxialLoad.hertz` takes Hz.

    Examples
    --------
    >>> round(AxialLoad.hertz(0.3, 0.3, 24.0).frequency, 3)
    150.796
    """

    mean: float
    amplitude: float
    frequency: float

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        mean = validate.within("mean", self.mean, -LARGEST_FORCE, LARGEST_FORCE, "give it in N")
        amplitude = validate.nonnegative(
            "amplitude", self.amplitude, "a negative amplitude only shifts time: give its size"
        )
        validate.within("amplitude", amplitude, 0.0, LARGEST_FORCE, "give it in N")
        frequency = validate.positive(
            "frequency", self.frequency, "for a constant force set amplitude=0 and any frequency"
        )
        validate.within("frequency", frequency, LEAST_FREQUENCY, LARGEST_FREQUENCY, "give it in rad/s")
        for name, value in (("mean", mean), ("amplitude", amplitude), ("frequency", frequency)):
            object.__setattr__(self, name, value)

    @classmethod
    def hertz(cls, mean: float, amplitude: float, frequency: float) -> AxialLoad:
        """Return a load whose frequency is given in Hz."""
        return cls(mean, amplitude, 2.0 * math.pi * validate.positive("frequency", frequency))
