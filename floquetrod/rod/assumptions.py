"""What the equations of a rod take for granted, listed in every verdict."""

from __future__ import annotations

from floquetrod.rod.data import RodData
from floquetrod.rod.load import AxialWave, Load

SHAPE = ("small angles", "linear elasticity", "straight channel, whose floor the rod never leaves; no torque")
"""Of every rod."""

WALL = "the load is the compression in the wall"
"""Which force is meant without fluids."""

IMMERSED = ("the load is the effective force, F_wall + p_i A_i - p_o A_o", "fluids at rest, added mass constant")
"""Which force is meant with a fluid inside or outside, and what else is taken for granted then."""


def assumptions(rod: RodData, load: Load) -> tuple[str, ...]:
    """Return what the equations take for granted."""
    if isinstance(load, AxialWave):
        vibration = "axial waves without friction on them"
        vibration += "" if load.axial_damping else ", undamped"
    else:
        vibration = f"vibration uniform along the rod: omega L / (2 pi c_0) = {rod.wave_ratio(load):.2g} neglected"
    weight = rod.weight_along > 0.0 and load.mean_at is None
    return (
        vibration,
        *(["the weight along the rod is neglected"] if weight else []),
        *SHAPE,
        *(IMMERSED if rod.fluid_inside or rod.fluid_outside else (WALL,)),
    )
