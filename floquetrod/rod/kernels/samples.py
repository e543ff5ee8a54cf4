"""Kernels over samples of rods: every sample has a rod of its own and a load of its own."""

from __future__ import annotations

from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.rod.kernels.modes import rod_is_stable


@kernel
def samples_stable_fill(
    mean: Any,
    amplitude: Any,
    frequency: Any,
    bending: Any,
    per_newton: Any,
    pendulum_squared: Any,
    held: Any,
    damping_rate: Any,
    out: Any,
    tolerance: float,
    smallest: float,
) -> None:
    """Fill ``out`` with whether no mode of each rod grows faster than ``tolerance`` under its load (rates per second).

    Rates below ``smallest`` may be left out.
    """
    slowest = max(tolerance, smallest)
    last = 1
    suspect = 1
    for i in range(len(mean)):
        constants = bending[i], per_newton[i], pendulum_squared[i], held[i], damping_rate[i]
        out[i], last, suspect = rod_is_stable(
            constants, mean[i], amplitude[i], frequency[i], tolerance, slowest, last, suspect
        )
