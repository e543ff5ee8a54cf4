"""The load that pushes a rod's ends together, one or arrays of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import broadcast

Quantity: TypeAlias = Literal["mean", "amplitude", "frequency"]
"""A quantity of `AxialLoad`."""

_STRONGEST = 1e12  # N
_SLOWEST, _FASTEST = 1e-9, 1e12  # rad/s: beyond any rod, and within what doubles can follow


class _Limits(NamedTuple):
    """What a quantity of a load may be: from ``least`` to ``largest``, both in ``unit``; ``check`` sees it first."""

    least: float
    largest: float
    unit: str
    check: Callable[[str, Any, str], float]
    hint: str


LIMITS: dict[Quantity, _Limits] = {
    "mean": _Limits(-_STRONGEST, _STRONGEST, "N", validate.finite, "give it in N"),
    "amplitude": _Limits(
        0.0, _STRONGEST, "N", validate.nonnegative, "a negative amplitude only shifts time: give its size"
    ),
    "frequency": _Limits(
        _SLOWEST, _FASTEST, "rad/s", validate.positive, "for a constant force set amplitude=0 and any frequency"
    ),
}
"""Limits of the quantities of a load, for every check of one."""


def load_number(quantity: Quantity, value: Any, name: str | None = None) -> float:
    """Return a quantity of a load as a float within its limits; ``name`` is the argument's, where it is another."""
    name, limits = name or quantity, LIMITS[quantity]
    number = limits.check(name, value, limits.hint)
    return validate.within(name, number, limits.least, limits.largest, f"give it in {limits.unit}")


def load_bounds(quantity: Quantity, bounds: Any) -> tuple[float, float]:
    """Return the argument ``bounds``, (low, high) of a quantity of a load, low below high."""
    return validate.interval("bounds", bounds, lambda name, value: load_number(quantity, value, name))


class Loads(NamedTuple):
    """Loads in flat arrays of one length: mean force (N), amplitude (N), frequency (rad/s); ``shape`` is theirs."""

    shape: tuple[int, ...]
    mean: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    frequency: NDArray[np.float64]

    @classmethod
    def of(cls, mean: Any, amplitude: Any, frequency: Any) -> Loads:
        """Return arrays that broadcast as loads; ValueError and TypeError name the quantity that cannot be."""
        given: dict[Quantity, Any] = {"mean": mean, "amplitude": amplitude, "frequency": frequency}
        arrays: dict[str, NDArray[np.float64]] = {
            name: validate.array(name, values, least=LIMITS[name].least, largest=LIMITS[name].largest)
            for name, values in given.items()
        }
        shape, flat = broadcast(**arrays)
        return cls(shape, *flat)

    @classmethod
    def single(cls, load: AxialLoad) -> Loads:
        """Return one load as arrays of one element."""
        return cls((), *(np.array([value]) for value in (load.mean, load.amplitude, load.frequency)))

    @property
    def size(self) -> int:
        """Number of loads."""
        return self.frequency.size

    @property
    def flat(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The three arrays."""
        return self.mean, self.amplitude, self.frequency

    def part(self, part: slice) -> Loads:
        """Return some of the loads."""
        return Loads((len(self.frequency[part]),), *(values[part] for values in self.flat))


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
        for name in LIMITS:
            object.__setattr__(self, name, load_number(name, getattr(self, name)))

    @classmethod
    def hertz(cls, mean: float, amplitude: float, frequency: float) -> AxialLoad:
        """Return a load whose frequency is given in Hz."""
        return cls(mean, amplitude, 2.0 * math.pi * validate.positive("frequency", frequency))
