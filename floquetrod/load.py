"""The load that pushes a rod's ends together."""

from __future__ import annotations

import math
from dataclasses import dataclass

from floquetrod import _validate


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
        object.__setattr__(self, "mean", _validate.finite("mean", self.mean))
        object.__setattr__(
            self,
            "amplitude",
            _validate.nonnegative("amplitude", self.amplitude, "a negative amplitude only shifts time: give its size"),
        )
        object.__setattr__(
            self,
            "frequency",
            _validate.positive("frequency", self.frequency, "for a constant force set amplitude=0 and any frequency"),
        )

    @classmethod
    def hertz(cls, mean: float, amplitude: float, frequency: float) -> AxialLoad:
        """Return a load whose frequency is given in Hz."""
        return cls(mean, amplitude, 2.0 * math.pi * _validate.positive("frequency", frequency))
