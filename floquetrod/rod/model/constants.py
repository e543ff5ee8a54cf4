"""What the mode equations need of a rod, which loads are refused, and how many modes decide a verdict."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod.rod.kernels import modes as kernels
from floquetrod.rod.loads.load import Load, Loads

NEGLIGIBLE_GROWTH = 1e-12  # growth in 1/s that modes left out may have: a doubling in 20,000 years
HAIRLINE_GROWTH = 1e-6
"""Growth in 1/s, tenfold in a month, up to which a tongue is a hairline: searches leave it out, and count it."""

MOST_MODES = 20_000  # beyond it the unit of a length or a force is wrong (a choice)

_MOST_PER_CYCLE = math.sqrt(validate.LARGEST)  # rates in frequencies of the load: their squares are coefficients


class ModeConstants(NamedTuple):
    """All that the mode equations of a rod depend on besides the load.

    Attributes
    ----------
    w2 : float
        Square of the first mode's wavenumber, 1/m^2.
    mass_per_length : float
        kg/m.
    rigidity : float
        E I in N m^2.
    pendulum_frequency : float
        rad/s.
    damping_rate : float
        Decay rate of free motion, 1/s.
    """

    w2: float
    mass_per_length: float
    rigidity: float
    pendulum_frequency: float
    damping_rate: float

    @property
    def critical_force(self) -> float:
        """F_cr in N, see `RodData.critical_force`."""
        return 2.0 * math.sqrt(self.rigidity * self.mass_per_length) * self.pendulum_frequency

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict and a bound in 1/s on all others; see `Rod.modes_needed`."""
        self.require_in_reach(Loads.single(load))
        a, b, stiffness, d = kernels.mode_family(*self[:4], load.mean, load.amplitude, load.frequency)
        c = self.damping_rate / load.frequency
        d -= c * c
        target = c + max(growth_tolerance, NEGLIGIBLE_GROWTH) / load.frequency
        last = kernels.modes_needed(a, b, stiffness, d, target, 1)
        if last > MOST_MODES:
            raise validate.wrong_value(
                "load",
                f"needs {last} modes, more than {MOST_MODES}: its frequency {load.frequency:g} rad/s or its "
                f"forces are far beyond those of this rod; check the units",
            )
        bound = kernels.modes_left_out(a, b, stiffness, d, last)
        return last, max(0.0, bound - c) * load.frequency

    def require_in_reach(self, loads: Loads) -> None:
        """Raise ValueError for loads that need too many modes, or whose mode equations have too large coefficients.

        The largest mean, amplitude and frequency are taken together, and the lowest frequency.
        """
        slowest = float(np.min(loads.frequency, initial=math.inf))
        modes, fastest = self._extent(loads)
        if modes > MOST_MODES:
            push = float(np.max(loads.mean, initial=-math.inf) + np.max(loads.amplitude, initial=0.0))
            raise validate.wrong_value(
                "load",
                f"needs more than {MOST_MODES} modes: mean and amplitude come to {push:g} N, far above the "
                f"critical force {self.critical_force:g} N of this rod; check units and length",
            )
        least = fastest / _MOST_PER_CYCLE
        if slowest < least:
            raise validate.wrong_value(
                "frequency",
                f"must be at least {least:.3g} rad/s for this rod and load, got {slowest:g}: coefficients of "
                f"its mode equations would exceed {validate.LARGEST:g}; check the units",
            )
        most = float(highest_frequency(*self[:3]))
        highest = float(np.max(loads.frequency, initial=0.0))
        if highest > most:
            raise validate.wrong_value(
                "frequency",
                f"must be at most {most:.3g} rad/s for this rod, got {highest:g}: it sets "
                f"off modes beyond {MOST_MODES}; check the units",
            )
        if self.damping_rate > _MOST_PER_CYCLE * slowest:
            raise validate.wrong_value(
                "damping_rate",
                f"must be at most {_MOST_PER_CYCLE:.3g} times the frequency, got "
                f"{self.damping_rate:g} 1/s at {slowest:g} rad/s; check the units",
            )

    def loads_at_once(self, loads: Loads) -> int:
        """Return how many loads a thread takes at a time: the slower they are the fewer, so that Ctrl-C is handled."""
        modes, fastest = self._extent(loads)
        return at_once(modes, fastest / float(np.min(loads.frequency, initial=math.inf)))

    def _extent(self, loads: Loads) -> tuple[float, float]:
        """Return `extent` for the largest mean, in size too, and the largest amplitude taken together."""
        strongest = np.max(loads.amplitude, initial=0.0)
        push = max(0.0, float(np.max(loads.mean, initial=-math.inf) + strongest))
        force = float(np.max(np.abs(loads.mean), initial=0.0) + strongest)
        modes, fastest = extent(*self[:4], push, force)
        return float(modes), float(fastest)


def extent(w2: Any, mass: Any, rigidity: Any, pendulum: Any, push: Any, force: Any) -> tuple[Any, Any]:
    """Return up to which mode a push outweighs bending, and a bound in rad/s on motion up to there.

    Of rods given by what `ModeConstants` holds, in numbers or arrays: ``push`` is the largest compression in N, zero or
    more, ``force`` the largest force in size.
    """
    with np.errstate(over="ignore"):  # infinite is out of reach, too
        modes = np.sqrt(push / rigidity / w2)
        highest = w2 * np.maximum(1.0, modes) ** 2
        return modes, np.sqrt((force * highest + rigidity * highest * highest) / mass + pendulum**2)


def highest_frequency(w2: Any, mass: Any, rigidity: Any) -> Any:
    """Return the natural frequency of the last mode that is looked at, in rad/s: no load may be faster."""
    return np.sqrt(rigidity / mass) * w2 * MOST_MODES**2


def are_in_reach(
    constants: tuple[Any, Any, Any, Any, Any], extents: tuple[Any, Any], frequency: Any
) -> NDArray[np.bool_]:
    """Return what `ModeConstants.require_in_reach` asks of one load, for arrays; ``extents`` is what `extent` gives."""
    w2, mass, rigidity, _, damping_rate = constants
    modes, fastest = extents
    return np.asarray(
        (modes <= MOST_MODES)
        & (frequency >= fastest / _MOST_PER_CYCLE)
        & (frequency <= highest_frequency(w2, mass, rigidity))
        & (damping_rate <= _MOST_PER_CYCLE * frequency)
    )


def at_once(modes: float, rows: float) -> int:
    """Return how many loads a thread takes at a time, from how many modes and rows of Hill's matrix each may take."""
    return max(1, int(4096.0 / (1.0 + 1e-4 * modes * rows)))
