"""Rods whose modes are coupled: an inclined rod, tubing shaken by a travelling wave, a long string, a map.

Set OPENBLAS_NUM_THREADS=1 for times of one thread.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from benchmarks.measure import Row, best_of
from benchmarks.systems import dop853_multipliers

Floats = NDArray[np.float64]

NITINOL = fr.Rod.nitinol()
INCLINED = NITINOL.replace(inclination=math.radians(75.0))
TUBING = fr.Rod(
    207e9,
    7850.0,
    radius=25.4e-3,
    inner_radius=21.44e-3,
    length=60.0,
    channel_radius=62e-3,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
    damping_rate=0.2,
)
BATCH = 64  # loads at once
SIDE = 200  # of the map


def run() -> list[Row]:
    """Return the times of a verdict with what was promised."""
    return [*inclined(), *tubing(), *long_string(), *chart()]


def inclined() -> list[Row]:
    """Return the times of an inclined rod with 12 modes."""
    load = fr.AxialLoad(0.2 * NITINOL.critical_force, 0.2 * NITINOL.critical_force, 150.0)
    system = INCLINED.modal_system(load, range(1, 13))
    assert isinstance(system, fr.HillSystem)  # noqa: S101
    means = np.linspace(0.0, 1.0, BATCH)[:, None, None]
    weakest = INCLINED.modal_system(load.varied("mean", 0.0), range(1, 13))
    assert isinstance(weakest, fr.HillSystem)  # noqa: S101
    stiffness = weakest.stiffness + means * (system.stiffness - weakest.stiffness)
    batch = fr.HillSystem(stiffness, list(system.cosines), list(system.sines), period=system.period)
    single = best_of(lambda: INCLINED.stability(load, range(1, 13)))
    many = best_of(lambda: fr.systems.is_stable(batch, workers=1)) / BATCH
    peer = integrated(system)
    return [
        Row("inclined rod, 12 modes: verdict, 64 at once", 1e3 * many, "ms", "DOP853", 1e3 * peer, at_most=1.0),
        Row("inclined rod, 12 modes: one call of stability", 1e3 * single, "ms", "DOP853", 1e3 * peer),
    ]


def tubing() -> list[Row]:
    """Return the times of 60 m of tubing that a travelling wave shakes."""
    unit = TUBING.critical_force
    load = fr.AxialWave.hertz(0.5 * unit, 0.3 * unit, 4.0)
    means = np.linspace(0.3, 0.6, BATCH) * unit
    single = best_of(lambda: TUBING.stability(load), repeats=5)
    many = best_of(lambda: TUBING.verdicts(load, mean=means, workers=1), repeats=5)
    system = TUBING.modal_system(load)
    assert isinstance(system, fr.HillSystem)  # noqa: S101
    peer = integrated(system)
    name = f"60 m of tubing, {system.order} modes"
    return [
        Row(f"{name}: verdict, 64 at once", 1e3 * many / BATCH, "ms", "DOP853", 1e3 * peer, at_most=5.0),
        Row(f"{name}: one call of stability", 1e3 * single, "ms", "DOP853", 1e3 * peer),
    ]


def long_string() -> list[Row]:
    """Return the time of a verdict on 3 km of tubing, timed once."""
    string = TUBING.replace(length=3000.0, damping_rate=0.5)
    unit = string.critical_force
    load = fr.AxialWave.hertz(0.3 * unit, 0.3 * unit, 4.0, axial_damping=0.5)
    start = time.perf_counter()
    found = string.stability(load)
    spent = time.perf_counter() - start
    return [Row(f"3 km of tubing, {found.modes_checked} modes: one call of stability", spent, "s", at_most=15.0)]


def chart() -> list[Row]:
    """Return the time of a map of an inclined rod, and of the same by DOP853, from one load."""
    unit = NITINOL.critical_force
    axes = {"mean": (0.0, 1.1 * unit, SIDE), "frequency": (50.0, 200.0, SIDE)}
    start = time.perf_counter()
    fr.stability_map(INCLINED, amplitude=0.2 * unit, **axes)
    spent = time.perf_counter() - start
    system = INCLINED.modal_system(fr.AxialLoad(0.2 * unit, 0.2 * unit, 150.0))
    assert isinstance(system, fr.HillSystem)  # noqa: S101
    peer = integrated(system) * SIDE * SIDE
    return [Row(f"map of {SIDE} x {SIDE} loads of an inclined rod", spent, "s", "DOP853", peer, at_most=12.0)]


def integrated(system: fr.HillSystem) -> float:
    """Return the seconds that DOP853 takes for the multipliers of a system."""
    first = system.as_periodic_system()
    matrices = np.asarray(first.mean), np.asarray(first.harmonics), float(first.period)
    start = time.perf_counter()
    dop853_multipliers(*matrices, 1e-10)
    return time.perf_counter() - start
