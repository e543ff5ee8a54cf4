"""A discretised rod driven by the kernels alone, for tests that want other ends, no gravity or no wall."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.kernels import cosserat
from floquetrod.simulation.mesh import DiscreteRod
from floquetrod.simulation.time_steps import critical_time_step

SHORT = fr.Rod(youngs_modulus=68e9, density=6500.0, radius=0.8e-3, length=0.4, channel_radius=4.7e-3)
"""A piece of the reference rod, shorter than half a wave of its critical mode."""

AT_REST = fr.AxialLoad(0.0, 0.0, 1.0)
FREE_SPACE = {"gravity": 0.0, "contact": 0.0}
"""Physics without weight and wall."""


def drive(
    mesh: DiscreteRod,
    seconds: float,
    start: Callable[[Any], None],
    *,
    samples: int = 200,
    ends: int = cosserat.FREE,
    load: fr.AxialLoad = AT_REST,
    friction: float = 0.0,
    part_of_step: float = 1.0,
    **changes: float,
) -> tuple[np.ndarray, list[Any]]:
    """Return times and records of a rod that ``start`` has put into its first state."""
    step = critical_time_step(mesh)[0] * part_of_step
    count = math.ceil(seconds / samples / step)
    step = seconds / samples / count
    rod = mesh.straight(load.mean)
    start(rod)
    mesh.initialise(rod)
    physics = mesh.physics(load, step, friction, ends)._replace(**changes)
    advance, drift = compiled(cosserat.advance), compiled(cosserat.drift)
    drift(rod, 0.5 * step, physics)
    records = []
    for sample in range(samples + 1):
        record = rod.copy()
        drift(record, -0.5 * step, physics)
        records.append(record)
        if sample < samples:
            advance(rod, count, physics)
    return np.arange(samples + 1) * (count * step), records


def frequency(time: np.ndarray, values: np.ndarray, guess: float) -> float:
    """Return the frequency in rad/s of a cosine near ``guess``."""
    from scipy.optimize import curve_fit

    def cosine(t: np.ndarray, a: float, b: float, w: float) -> np.ndarray:
        return a * np.cos(w * t) + b * np.sin(w * t)

    size = np.abs(values).max()
    (_, _, found), _ = curve_fit(cosine, time, values / size, p0=[1.0, 0.0, guess])
    return float(found)


def bend(rod: Any, mesh: DiscreteRod, y: np.ndarray) -> None:
    """Put nodes at ``y`` across the channel, on the floor, and turn every segment along the line between its nodes."""
    n, rest = mesh.segments, mesh.rod.radial_clearance + mesh.depth_at_rest
    rod["y"][: n + 1] = y
    rod["z"][: n + 1] = -np.sqrt(rest**2 - y**2)
    along(rod, n)


def along(rod: Any, n: int) -> None:
    """Turn every segment along the line between its nodes, by the smallest rotation."""
    line = np.array([np.diff(rod[axis][: n + 1]) for axis in "xyz"])
    line /= np.linalg.norm(line, axis=0)
    half = np.sqrt(0.5 * (1.0 + line[0]))
    rod["q0"][:n], rod["q1"][:n], rod["q2"][:n], rod["q3"][:n] = half, 0.0, -line[2] / (2 * half), line[1] / (2 * half)
