"""Over a plane of loads: where a rod that is stable at rest carries a large motion, too, in one mode alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod.rod.large_orbits import ModeOrbit, alone, beam_functions, require_possible
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.mode_equations.large_motion import Shapes
from floquetrod.rod.mode_equations.many_orbits import ModeLoads, smallest_stable
from floquetrod.rod.mode_equations.one_mode import OneMode
from floquetrod.rod.model.data import RodData

_AT_ONCE = 200  # loads between two reports of progress


def large_motion(rod: RodData, kind: Load, loads: Loads, stable: Bools, progress: Progress | None) -> Floats:
    """Return the largest angle in rad of the smallest stable orbit on the wall found under each load that is stable.

    0 where a search finds none, NaN where the rod at rest is not stable.  Each mode alone, without lift-off at hinged
    ends, in its shape under the middle of the mean forces; orbits of one period of the load or two.
    """
    middle = 0.5 * float(loads.mean.min() + loads.mean.max())
    middle_load = kind.with_numbers(middle, 1.0, float(loads.frequency[0]))
    require_possible(rod, middle_load)
    shapes = Shapes.of(rod, middle_load, beam_functions(rod, None))
    equations = [alone(rod, middle_load, shapes, mode, 0.0) for mode in sorted(set(shapes.numbers.tolist()))]
    wanted = np.flatnonzero(stable.ravel() & (loads.amplitude > 0.0))
    angles = np.where(stable.ravel(), 0.0, np.nan)
    for first in range(0, len(wanted), _AT_ONCE):
        block = wanted[first : first + _AT_ONCE]
        angles[block] = _smallest(equations, loads.some(block))
        if progress is not None:
            progress(min(first + _AT_ONCE, len(wanted)), len(wanted))
    return angles.reshape(loads.shape)


def _smallest(equations: list[OneMode], loads: Loads) -> Floats:
    """Return the angles under some loads."""
    angles = np.full(loads.size, np.inf)
    vibrations = _vibrations(equations, loads)
    for equation, vibration in zip(equations, vibrations, strict=True):
        mode = int(equation.motion.shapes.numbers[0])
        for i, orbit in enumerate(smallest_stable(equation, ModeLoads(loads.mean, loads.frequency, vibration))):
            if orbit is not None and orbit.amplitude < angles[i]:
                load = equation.motion.load.with_numbers(*(float(values[i]) for values in loads.flat))
                if ModeOrbit(mode, orbit, OneMode(equation.motion.under(load))).stays_on_wall:
                    angles[i] = orbit.amplitude
    return np.where(np.isfinite(angles), angles, 0.0)


def _vibrations(equations: list[OneMode], loads: Loads) -> list[Any]:
    """Return the stiffness of each mode that the vibration takes, (modes, k, 2 H)."""
    every, index = np.unique(loads.frequency, return_inverse=True)
    vibrations = []
    for equation in equations:
        motion = equation.motion
        per_newton = np.array(
            [motion.under(motion.load.varied("frequency", w)).vibrating[:, 0, 0] for w in every.tolist()]
        )
        vibrations.append(loads.amplitude[:, None] * per_newton[index])
    return vibrations
