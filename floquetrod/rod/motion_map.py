"""Over a plane of loads: where a rod that is stable at rest carries a large motion, too, in one mode alone."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod.rod.large_orbits import Found, alone, beam_functions, require_possible
from floquetrod.rod.loads.load import Load
from floquetrod.rod.mode_equations.large_motion import Shapes
from floquetrod.rod.mode_equations.many_orbits import Loads, smallest_stable
from floquetrod.rod.mode_equations.one_mode import OneMode
from floquetrod.rod.model.data import RodData

_AT_ONCE = 200  # loads between two reports of progress


class Numbers(NamedTuple):
    """Means and amplitudes in N and frequencies in rad/s of loads, all of one shape."""

    mean: Floats
    amplitude: Floats
    frequency: Floats


def large_motion(rod: RodData, kind: Load, numbers: Numbers, stable: Bools, progress: Progress | None) -> Floats:
    """Return the largest angle in rad of the smallest stable orbit on the wall found under each load that is stable.

    0 where a search finds none, NaN where the rod at rest is not stable.  Each mode alone, without lift-off at hinged
    ends, in its shape under the middle of the mean forces; orbits of one period of the load or two.
    """
    middle = 0.5 * float(numbers.mean.min() + numbers.mean.max())
    like = kind.with_numbers(middle, 1.0, float(numbers.frequency.ravel()[0]))
    require_possible(rod, like)
    shapes = Shapes.of(rod, like, beam_functions(rod, None))
    equations = [alone(rod, like, shapes, mode, 0.0) for mode in sorted(set(shapes.numbers.tolist()))]
    wanted = np.flatnonzero(stable & (numbers.amplitude > 0.0))
    angles = np.where(stable, 0.0, np.nan)
    for first in range(0, len(wanted), _AT_ONCE):
        part = wanted[first : first + _AT_ONCE]
        some = Numbers(*(each.ravel()[part] for each in numbers))
        angles.ravel()[part] = _smallest(equations, some)
        if progress is not None:
            progress(min(first + _AT_ONCE, len(wanted)), len(wanted))
    return np.asarray(angles)


def _smallest(equations: list[OneMode], numbers: Numbers) -> Floats:
    """Return the angles under some loads."""
    angles = np.full(len(numbers.mean), np.inf)
    vibrations = _vibrations(equations, numbers)
    for equation, vibration in zip(equations, vibrations, strict=True):
        mode = int(equation.motion.shapes.numbers[0])
        loads = Loads(numbers.mean, numbers.frequency, vibration)
        for i, orbit in enumerate(smallest_stable(equation, loads)):
            if orbit is not None and orbit.amplitude < angles[i]:
                under = equation.motion.under(equation.motion.load.with_numbers(*(float(each[i]) for each in numbers)))
                if Found(mode, orbit, OneMode(under)).stays_on_wall:
                    angles[i] = orbit.amplitude
    return np.where(np.isfinite(angles), angles, 0.0)


def _vibrations(equations: list[OneMode], numbers: Numbers) -> list[Any]:
    """Return what the vibration takes from the stiffness of each mode, (modes, k, 2 H)."""
    every, place = np.unique(numbers.frequency, return_inverse=True)
    found = []
    for equation in equations:
        motion = equation.motion
        per_newton = np.array(
            [motion.under(motion.load.varied("frequency", w)).vibrating[:, 0, 0] for w in every.tolist()]
        )
        found.append(numbers.amplitude[:, None] * per_newton[place])
    return found
