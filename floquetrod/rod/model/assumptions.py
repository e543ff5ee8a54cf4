"""What the equations of a rod assume, listed in every verdict."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection
from typing import Any

import numpy as np

from floquetrod._util.arguments import Mention, Message
from floquetrod._util.calling import level_of_caller
from floquetrod.rod.loads.axial import wave_ratio
from floquetrod.rod.loads.load import AxialWave, Load
from floquetrod.rod.model.data import RodData

UNIFORM_UP_TO = 0.1
"""Ratio of forcing speed to wave speed up to which the force counts as uniform (heuristic)."""

_MATTERS = 0.1  # of the largest harmonic, above which another one counts (a choice)


class Assumption(str):
    """What is assumed, with how far that holds: numbers from the pages `theory/trust` and `theory/bends`."""

    limit: str

    def __new__(cls, text: str, limit: str) -> Assumption:
        """Return the text."""
        made = super().__new__(cls, text)
        made.limit = limit
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickles make it of."""
        return Assumption, (str(self), self.limit)


SHAPE = (
    Assumption(
        "small angles",
        "at 15 degrees gravity acts as if 0.9 % weaker, at 30 by 3.4 %, at 60 by 13 %; beyond a quarter turn the rod "
        "is on no wall",
    ),
    Assumption("linear elasticity", "up to the yield strength"),
)
"""Of every rod."""

WEIGHT_NEGLECTED = Assumption(
    "the weight along the rod is neglected", "matters where it is no small fraction of the mean force"
)
"""Of a load whose mean is the same all along the rod."""

_STRAIGHT = Assumption(
    "straight channel, whose floor the rod never leaves; no torque",
    "a bend of 0.01/m can raise the critical force several times; a rod that bounces leaves the floor",
)
_END_EFFECT = 0.4
"""Share of growth by which a straight rod with hinged ends differs, times half waves; see `channel_assumptions`."""

MOST_FORCED = math.radians(1.0)
"""Angle in rad up to which a rod that the vibration moves along the wall counts as at rest there (a choice)."""

WALL = Assumption(
    "the load is the compression in the wall",
    "with fluids inside or outside give their densities and the effective force",
)
"""Which force is meant without fluids."""

IMMERSED = (
    Assumption(
        "the load is the effective force, F_wall + p_i A_i - p_o A_o",
        "the weight of the fluids acts, their flow does not",
    ),
    Assumption(
        "fluids at rest, added mass constant",
        "a fluid that flows, or a narrow gap in which it is squeezed, damps and adds more mass",
    ),
)
"""Which force is meant with a fluid inside or outside, and what else is assumed then."""


class UniformForceWarning(UserWarning):
    """The load changes too fast for the axial force to be the same all along the rod."""


class ForcedAngleWarning(UserWarning):
    """The vibration moves a rod along the wall of a channel that turns, which a linear verdict neglects."""


def forced_in_words(angle: float) -> Assumption:
    """Return how far in rad the vibration moves the rod along the wall, and warn where that is far."""
    if angle > MOST_FORCED:
        warnings.warn(
            f"the vibration moves the rod along the wall of this well, which turns, by up to {math.degrees(angle):.3g} "
            f"deg: the verdict is that on small motion about its mean position, and the angle should be below "
            f"{math.degrees(MOST_FORCED):g} deg",
            ForcedAngleWarning,
            stacklevel=level_of_caller(),
        )
    return Assumption(
        f"about the mean position, from which the vibration moves the rod by up to {math.degrees(angle):.2g} deg",
        f"good below {math.degrees(MOST_FORCED):g} deg",
    )


def channel_assumptions(rod: RodData) -> tuple[Assumption, ...]:
    """Return the assumptions about the channel; for a bent channel with the ratios that should be small.

    In a bend, ends without a moment lift a straight rod off its wall near them, and growth differs: by 6 % in
    simulations of a rod of seven half waves, in inverse proportion to their number.  With clamped ends, or where the
    rod's own shape is the channel's, it does not.
    """
    if rod.course.is_straight:
        return (_STRAIGHT,)
    kappa, along = rod.course.sharpest, rod.along(rod.course.samples)
    room = kappa * float(along.clearance.max())
    share = float(along.rigidity.max()) * kappa * kappa / rod.critical_force
    found = [
        Assumption("a wall which the rod never leaves; no torque", "a load that lifts the rod off its wall is refused"),
        Assumption(
            f"gentle bends: curvature times clearance is {room:.2g}, E I curvature^2 {share:.2g} of the critical "
            "force; both should be far below 1",
            "growth differs by 0.7 % where curvature times clearance is 0.005, by 4 % where it is 0.04",
        ),
    ]
    if "hinged" in rod.ends:
        found.append(
            Assumption(
                "the rod's own shape is the channel's: a straight one lies otherwise near hinged ends, and its growth "
                f"differs by some {100.0 * _END_EFFECT / max(rod.critical_mode, 1.0):.2g} %",
                "no effect where ends are clamped",
            )
        )
    if rod.course.is_uniform:
        change = math.degrees(abs(rod.curvature) * rod.length)
        found.append(
            Assumption(
                f"weight across uniform, though the inclination changes by {change:.3g} deg along the rod",
                "on the path of a survey the local transverse weight is used",
            )
        )
    return tuple(found)


def section_assumptions(rod: RodData) -> tuple[Assumption, ...]:
    """Return the assumptions about a string of several sections, or in several bores; none of a uniform rod."""
    if not rod.varies:
        return ()
    every = [part.rod for part in rod.uniform_parts]
    bend = max((each.flexural_rigidity / each.weight_per_length) ** 0.25 for each in every)
    found = [
        Assumption(
            "inertia, weight and E I uniform within each section, one damping rate for all",
            "connections, which are stiffer over a short length, are counted by their weight alone",
        )
    ]
    if len({each.radial_clearance for each in every}) > 1:
        found.append(
            Assumption(
                "the string lies on the floor right up to where the clearance changes; that it bends there, over some "
                f"(E I / w)^(1/4) = {bend:.2g} m, is left out",
                "matters where sections are not many times as long as that",
            )
        )
    return tuple(found)


def warn_unless_uniform(rod: RodData, load: Load) -> None:
    """Warn where a force that is taken to be uniform along the rod is not, its harmonics that matter included."""
    sizes = np.abs(load.harmonics)
    highest: float = 1 + int(np.flatnonzero(sizes >= _MATTERS * sizes.max())[-1])
    if load.second is not None:
        highest = max(highest, load.second[1] / load.frequency)
    ratio, fast = highest * wave_ratio(rod, load), highest * load.frequency
    if load.amplitude > 0.0 and load.is_uniform and ratio > UNIFORM_UP_TO:
        warnings.warn(
            Message(
                f"at {fast:.6g} rad/s ({fast / (2.0 * math.pi):.4g} Hz) the rod is {ratio:.2g} axial wavelengths long "
                f"(wave speed {rod.wave_speed:.0f} m/s); this load assumes a force that is uniform along the rod, "
                f"which is accurate below {UNIFORM_UP_TO:g} wavelengths; use ",
                Mention("wave", "AxialWave"),
                ", which computes the waves",
            ),
            UniformForceWarning,
            stacklevel=level_of_caller(),
        )


def assumptions(rod: RodData, load: Load) -> tuple[Assumption, ...]:
    """Return what the equations assume."""
    if isinstance(load, AxialWave):
        vibration = Assumption(
            f"axial waves without friction on them{'' if load.axial_damping else ', undamped'}",
            "friction on the wall damps them along the rod, which the reach into a well and simulations include",
        )
    else:
        vibration = Assumption(
            f"vibration uniform along the rod, which is {wave_ratio(rod, load):.2g} axial wavelengths long",
            "at a tenth of a wavelength the middle feels 5 % more than the ends, as an axial wave computes",
        )
    return (vibration, *rod_assumptions(rod, load))


def rod_assumptions(rod: RodData, load: Load, varied: Collection[str] = ()) -> tuple[Assumption, ...]:
    """Return what the equations assume of a rod; some parameters may be ``varied``."""
    is_inclined = rod.weight_along > 0.0 or not rod.course.is_uniform or "inclination" in varied
    is_immersed = any(getattr(rod, name) or name in varied for name in ("fluid_inside", "fluid_outside"))
    return (
        *([WEIGHT_NEGLECTED] if is_inclined and load.mean_at is None else []),
        *SHAPE,
        *channel_assumptions(rod),
        *section_assumptions(rod),
        *(IMMERSED if is_immersed else (WALL,)),
    )
