"""What the equations of a rod take for granted, listed in every verdict."""

from __future__ import annotations

import warnings

import numpy as np

from floquetrod._util.arguments import Mention, Message
from floquetrod._util.calling import level_of_caller
from floquetrod.rod.loads.load import AxialWave, Load
from floquetrod.rod.model.data import RodData

UNIFORM_UP_TO = 0.1
"""Ratio of forcing speed to wave speed up to which the force counts as uniform (heuristic)."""

_MATTERS = 0.1  # of the largest harmonic, above which another one counts (a choice)

SHAPE = ("small angles", "linear elasticity", "straight channel, whose floor the rod never leaves; no torque")
"""Of every rod."""

WALL = "the load is the compression in the wall"
"""Which force is meant without fluids."""

IMMERSED = ("the load is the effective force, F_wall + p_i A_i - p_o A_o", "fluids at rest, added mass constant")
"""Which force is meant with a fluid inside or outside, and what else is taken for granted then."""


class UniformForceWarning(UserWarning):
    """The load changes too fast for the axial force to be the same all along the rod."""


def warn_unless_uniform(rod: RodData, load: Load) -> None:
    """Warn where a force that is taken to be uniform along the rod is not, its harmonics that matter included."""
    sizes = np.abs(load.harmonics)
    highest = 1 + int(np.flatnonzero(sizes >= _MATTERS * sizes.max())[-1])
    ratio = highest * rod.wave_ratio(load)
    if load.amplitude > 0.0 and load.is_uniform and ratio > UNIFORM_UP_TO:
        warnings.warn(
            Message(
                f"at {highest * load.frequency:.6g} rad/s the rod is {ratio:.2g} axial wavelengths long (wave speed "
                f"{rod.wave_speed:.0f} m/s); this load assumes a force that is uniform along the rod, which is "
                f"accurate below {UNIFORM_UP_TO:g} wavelengths; use ",
                Mention("wave", "AxialWave"),
                ", which computes the waves",
            ),
            UniformForceWarning,
            stacklevel=level_of_caller(),
        )


def assumptions(rod: RodData, load: Load) -> tuple[str, ...]:
    """Return what the equations take for granted."""
    if isinstance(load, AxialWave):
        vibration = "axial waves without friction on them"
        vibration += "" if load.axial_damping else ", undamped"
    else:
        vibration = f"vibration uniform along the rod, which is {rod.wave_ratio(load):.2g} axial wavelengths long"
    weight = rod.weight_along > 0.0 and load.mean_at is None
    return (
        vibration,
        *(["the weight along the rod is neglected"] if weight else []),
        *SHAPE,
        *(IMMERSED if rod.fluid_inside or rod.fluid_outside else (WALL,)),
    )
