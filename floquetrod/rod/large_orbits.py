"""Large orbits of a rod's modes, each alone, and which rods and modes are examined."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod.parameter import require_known
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, require_one_sine
from floquetrod.rod.mode_equations.large_motion import LargeMotion, Shapes
from floquetrod.rod.mode_equations.one_mode import LIMIT, OneMode, Orbit
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import ROD

INDENTATION = 1e-4
"""Depth to which the weight of the rod indents its channel, over the radial clearance, where it is left out."""

MOST_HALF_WAVES = 60  # of a mode whose motion is computed (a choice: seconds)


class ModeOrbit(NamedTuple):
    """An orbit of one mode."""

    mode: int
    orbit: Orbit
    alone: OneMode

    @property
    def in_words(self) -> str:
        """How large it is, in which mode, and why the rod may move otherwise."""
        if self.is_beyond:
            return f"more than {math.degrees(LIMIT):.0f} degrees in mode {self.mode} alone, where it leaves its wall"
        beats = "" if self.alone.motion.rod.damping_rate > 0.0 else ", about which it beats without damping"
        leaves = "" if self.stays_on_wall else ", beyond where it leaves its wall"
        return f"about {math.degrees(self.orbit.amplitude):.2g} degrees in mode {self.mode} alone{beats}{leaves}"

    @property
    def is_beyond(self) -> bool:
        """Whether it is larger than `LIMIT`."""
        return self.orbit.amplitude > LIMIT

    @property
    def stays_on_wall(self) -> bool:
        """Whether the contact force of the mode alone stays positive."""
        motion, states = self.alone.motion, self.orbit.states
        period = self.orbit.turns * 2.0 * math.pi / motion.load.frequency
        return bool(motion.contact_force(period * np.arange(len(states)) / len(states), states).min() > 0.0)


def require_possible(rod: RodData, load: Load) -> None:
    """Raise ValueError for rods whose large motion is not known here, with the remedy."""
    require_known(rod, ROD, "large motion")
    ends = rod.end_conditions
    require_one_sine(load, "large motion")
    if load.noise:
        raise validate.wrong_value("load", "must be without noise, which leads to no periodic motion; leave it out")
    if "free" in (ends.upper, ends.lower):
        raise validate.wrong_value(
            "ends", f'must not be free, got "{ends}": a free end leaves the wall; simulate the rod, or take "guided"'
        )
    if not rod.course.is_straight:
        raise validate.wrong_value(
            "rod", "must lie in a straight channel: in one that bends the contact force changes too; simulate it"
        )
    if rod.critical_mode > MOST_HALF_WAVES / 1.5:
        raise validate.wrong_value(
            "length",
            f"must be at most {MOST_HALF_WAVES / 1.5 * rod.critical_half_wave:.4g} m, that of "
            f"{MOST_HALF_WAVES / 1.5:g} half waves, got {rod.length:g} m; take a part of the rod",
        )


def indentation_of(value: Any) -> float:
    """Return the argument ``indentation``."""
    return validate.within("indentation", value, 1e-8, 0.1, f"a part of the radial clearance, such as {INDENTATION:g}")


def beam_functions(rod: RodData, mode: int | None) -> int:
    """Return how many beam functions the modes are made of."""
    return max(math.ceil(3.0 * rod.critical_mode), 3 * (mode or 0)) + 4


def candidates(rest: RodStability, shapes: Shapes, mode: int | None) -> list[int]:
    """Return the modes to examine: the one given, the growing ones, fastest first, or all where nothing grows."""
    if mode is not None:
        return [mode]
    growing = [m for resonance in rest.resonances for m in resonance.modes] if rest.status != "stable" else []
    return list(dict.fromkeys(growing)) or sorted(set(shapes.numbers.tolist()))


def alone(rod: RodData, load: Load, shapes: Shapes, mode: int, indentation: float) -> OneMode:
    """Return the equation of one mode."""
    index = shapes.numbers.tolist().index(mode)
    return OneMode(LargeMotion(rod, load, shapes.some([index]), indentation))


def orbits_of(rod: RodData, load: Load, shapes: Shapes, modes: list[int], indentation: float) -> Iterator[ModeOrbit]:
    """Yield the stable orbits of modes alone, the smallest of each first."""
    for mode in modes:
        equation = alone(rod, load, shapes, mode, indentation)
        for orbit in orbits_alone(equation):
            if orbit.is_stable:
                yield ModeOrbit(mode, orbit, equation)


def orbits_alone(equation: OneMode) -> list[Orbit]:
    """Return the orbits of one mode alone, of one period of the load or two, the smallest first."""
    if equation.motion.load.amplitude == 0.0:
        return equation.equilibria()
    every = [orbit for turns in (2, 1) if equation.may_resonate(turns) for orbit in equation.orbits(turns)]
    return sorted(every, key=lambda orbit: orbit.amplitude)


def grown(rod: RodData, load: Load, rest: RodStability) -> ModeOrbit | None:
    """Return the large orbit of the mode that grows fastest, alone and on the wall; None where it is not known.

    In a tenth of a second: angles are within some percent of the angles of `Rod.steady_motion`.
    """
    try:
        require_possible(rod, load)
    except ValueError:
        return None
    mode = rest.fastest_mode
    if rest.status != "unstable" or mode is None or mode > MOST_HALF_WAVES / 3:
        return None
    return next(orbits_of(rod, load, Shapes.of(rod, load, beam_functions(rod, mode)), [mode], 0.0), None)
