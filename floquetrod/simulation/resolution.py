"""How short the waves are that a load makes grow on a rod, and how many segments they need."""

from __future__ import annotations

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import over_chunks
from floquetrod.floquet.kernels import mathieu_discriminant
from floquetrod.rod.kernels import independent_modes as rod_modes
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.model.constants import ModeConstants, mode_constants
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.lumping import uniform_rods
from floquetrod.simulation.start import LEAST_SEGMENTS

_PLACES = 9  # along the rod at which the force is examined, besides where it vibrates most (a choice)
_HARMONICS = 4  # of a force, the strongest (a choice)
_MOST_MODES = 2000  # whose growth is computed; of more, some evenly spread (a choice)
_SHARE = 0.5  # of the fastest growth from which a mode counts (a choice)
_GROWTH = 3.0  # e-foldings in the time simulated below which nothing comes of a mode (a choice)


class ResolutionWarning(UserWarning):
    """Too few segments for the modes that, by theory, a simulated load makes grow."""


class GrowingWaves(NamedTuple):
    """The modes that theory expects to see grow in a simulation.

    Attributes
    ----------
    fastest, highest : int
        The mode that grows fastest, and the highest that grows at half its rate or more; 0 where none does.
    rate : float
        Of the fastest, in 1/s.
    """

    fastest: int
    highest: int
    rate: float

    @property
    def least_segments(self) -> int:
        """The least number of segments that resolves them, 6 for every half wave."""
        return LEAST_SEGMENTS * self.highest


@functools.lru_cache(maxsize=16)  # of the rods and loads of an ensemble: as long as a short run takes
def growing_waves(driving: Driving, duration: float) -> GrowingWaves:
    """Return the modes that grow by a factor of 20 or more in ``duration`` s, an estimate.

    Modes are counted in half waves along the rod, and judged by the mode equation of hinged ends under the force at
    several places along the rod, for coupled modes too: waves short beside the rod follow the force where they are.
    Each harmonic of the force counts alone.  A rod that varies along is judged as one like each of its parts.
    """
    waves, rods = GrowingWaves(0, 0, 0.0), map(mode_constants, uniform_rods(driving.rod))
    forces = driving.forces(_PLACES, _HARMONICS)
    for constants, (frequency, mean, amplitude) in itertools.product(rods, forces):
        loads = Loads.of(mean, amplitude, frequency)
        try:
            constants.require_in_reach(loads)
        except ValueError:  # no theory to go by
            continue
        modes, rates = _growth(constants, loads, _GROWTH / duration)
        fastest = int(rates.argmax())
        if rates[fastest] * duration > _GROWTH and rates[fastest] > waves.rate:
            counts = np.flatnonzero(rates >= max(_SHARE * rates[fastest], _GROWTH / duration))
            waves = GrowingWaves(int(modes[fastest]), int(modes[counts[-1]]), float(rates[fastest]))
    return waves


def _growth(constants: ModeConstants, loads: Loads, slowest: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return modes, and for each its growth in 1/s under the load that makes it grow fastest.

    No other one grows at ``slowest`` or more, in 1/s.
    """
    mean, amplitude, frequency = loads.flat
    c = constants.damping_rate / frequency
    family = np.broadcast_arrays(*rod_modes.mode_family(*constants[:4], mean, amplitude, frequency))
    forcing, compression, bending, gravity, neutral_squared = (float(part.max()) for part in family)
    target = c[0] + slowest / frequency[0]
    last = rod_modes.modes_needed(forcing, compression, bending, gravity - c[0] * c[0], neutral_squared, target, 1)
    modes = np.arange(1, last + 1, math.ceil(last / _MOST_MODES))
    A, B, C, D, _ = (part[:, None] for part in family)
    alpha, beta = rod_modes.mode_coefficients(A, B, C, D, constants.neutral_squared, modes)
    rates = np.empty(alpha.size)
    over_chunks(mathieu_discriminant.growth_fill, (alpha.ravel(), beta.ravel(), np.repeat(c, modes.size)), rates)
    return modes, (rates.reshape(alpha.shape) * frequency[:, None]).max(axis=0)
