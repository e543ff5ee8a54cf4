"""A short simulated rod with checkpoints at every occasion, and what makes two runs the same to the bit."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod.ensembles import stores
from floquetrod.ensembles.runs import require_runs
from floquetrod.simulation import checkpoints, integration

ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.4, 0.6, 150.0)


def simulate(checkpoint: Path | None = None, frames: int = 12, progress: Any = None) -> fr.Simulation:
    """Run, with a checkpoint after every piece of work instead of every few seconds."""
    before = checkpoints._SECONDS_BETWEEN, integration._ELEMENT_STEPS
    # Pieces of a thousand steps, saved one by one.
    checkpoints._SECONDS_BETWEEN, integration._ELEMENT_STEPS = -1.0, 1
    try:
        return fr.simulate(
            ROD,
            LOAD,
            duration=0.05,
            friction=0.1,
            segments=40,
            frames=frames,
            time_step=4e-6,
            checkpoint=checkpoint,
            progress=progress,
        )
    finally:
        checkpoints._SECONDS_BETWEEN, integration._ELEMENT_STEPS = before


@functools.cache
def reference() -> fr.Simulation:
    """Return the run that nothing disturbs."""
    return simulate()


PROBLEM = fr.SimulationProblem(ROD, LOAD, duration=0.004, friction=0.1, segments=40, frames=5, time_step=4e-6)
OVER = {"kick": [0.01, 0.05, 0.2], "seed": range(20)}


def fill(place: Path | None = None, frames: bool = False, progress: Any = None) -> dict[str, Any]:
    """Make an ensemble, in a store that is saved at every occasion; return its arrays but for what runs took."""
    before = stores._SECONDS_BETWEEN, stores._LONGER
    stores._SECONDS_BETWEEN, stores._LONGER = 0.0, 0.0
    try:
        found = fr.ensemble(PROBLEM, OVER, store=place, frames=frames, progress=progress)
    finally:
        stores._SECONDS_BETWEEN, stores._LONGER = before
    return arrays(found)


@functools.cache
def filled(frames: bool) -> dict[str, Any]:
    """Return the ensemble that nothing disturbs."""
    return fill(frames=frames)


def arrays(found: Any) -> dict[str, Any]:
    """Return the arrays of an ensemble but for the times that runs took; texts of any length compare."""
    runs = require_runs("found", found)
    every = {name: runs[name] for name in (*runs.coords, *runs.variables) if name != "wall_time"}
    return every | {"reason": every["reason"].tolist()}


def differing(one: dict[str, Any], other: dict[str, Any]) -> list[str]:
    """Return the names of arrays in which two ensembles differ by a bit."""
    return [name for name in one.keys() | other.keys() if not same(one.get(name), other.get(name))]


def differences(one: Any, other: Any) -> list[str]:
    """Return the names of fields in which two results of one class differ by a bit."""
    return [
        part.name
        for part in dataclasses.fields(one)
        if part.compare and part.name != "seconds" and not same(getattr(one, part.name), getattr(other, part.name))
    ]


def same(one: Any, other: Any) -> bool:
    """Return whether two values are the same to the bit, arrays and NaN included."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        one, other = np.asarray(one), np.asarray(other)
        return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if isinstance(one, dict):
        return isinstance(other, dict) and one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if dataclasses.is_dataclass(one) and not isinstance(one, type):
        return type(one) is type(other) and not differences(one, other)
    if isinstance(one, list | tuple):
        return isinstance(other, list | tuple) and len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def strays(folder: Path) -> list[str]:
    """Return names of partial files left in a folder."""
    return sorted(path.name for path in folder.iterdir() if path.name.endswith(".part"))
