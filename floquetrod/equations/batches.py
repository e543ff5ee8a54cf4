"""Batches of systems: their arrays, flat, and their members."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.periodic_system import PeriodicSystem


def flat(array: Any, shape: tuple[int, ...], tail: int) -> NDArray[Any]:
    """Return an array with the leading shape of a batch made one axis; its last ``tail`` axes stay as they are."""
    array = np.asarray(array)
    inner = array.shape[array.ndim - tail :]
    return np.ascontiguousarray(np.broadcast_to(array, (*shape, *inner))).reshape(-1, *inner)


def pick(systems: HillSystem | PeriodicSystem, index: int) -> HillSystem | PeriodicSystem:
    """Return one system of a batch by its place in the order of C."""
    if not systems.shape:
        return systems
    place = np.unravel_index(index, systems.shape)

    def one(array: Any, tail: int = 2) -> Any:
        array = np.asarray(array)
        return np.broadcast_to(array, (*systems.shape, *array.shape[array.ndim - tail :]))[place]

    series = [[one(matrix) for matrix in matrices] for matrices in (systems.cosines, systems.sines)]
    period = float(one(systems.period, 0))
    if isinstance(systems, PeriodicSystem):
        return PeriodicSystem(one(systems.mean), *series, period=period, coefficient_error=systems.coefficient_error)
    names = ("mass", "damping", "gyroscopic")
    others = {name: one(matrix) for name in names if (matrix := getattr(systems, name)) is not None}
    return HillSystem(one(systems.stiffness), *series, **others, period=period)
