"""Nanoseconds an element-step without and with friction, and the throughput of two runs in two threads.

Held against PyElastica with a tube contact written for it here, where that is installed (pip install pyelastica).
"""

from __future__ import annotations

import importlib.util
import math
import os
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import floquetrod as fr
from benchmarks.measure import Row, best_of
from floquetrod._util.compilation import compiled
from floquetrod.kernels import cosserat
from floquetrod.simulation.mesh import DiscreteRod
from floquetrod.simulation.time_steps import critical_time_step

SEGMENTS, STEPS = 250, 1000
PEER, PEER_STEP = "PyElastica", 0.4e-6  # s: the largest step that it takes for this rod
ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)


def run() -> list[Row]:
    """Return the figures of the issue's list, with what was promised."""
    installed = importlib.util.find_spec("elastica") is not None
    rows = []
    for name, friction, most, ratio in (("no friction", 0.0, 9.0, 20.0), ("friction and rolling", 0.1, 14.0, 12.0)):
        ours, theirs = 1e9 * element_step(friction), 1e9 * peer_element_step(friction) if installed else None
        against = {"against": PEER, "peer": theirs, "ratio_at_least": ratio} if installed else {}
        rows.append(Row(f"element-step, {name}", ours, "ns", at_most=most, **against))
        if friction == 0.0:
            second = fr.simulate(ROD, LOAD, duration=0.05, segments=SEGMENTS, frames=21).seconds / 0.05
            if theirs is not None:
                against = {"against": PEER, "peer": 1e-9 * theirs * SEGMENTS / PEER_STEP, "ratio_at_least": 80.0}
            rows.append(Row("simulated second of the reference rod, frames included", second, "s", **against))
    if (os.cpu_count() or 1) > 1:
        rows.append(Row("two runs in two threads, over one after the other", two_threads(), "", at_most=1.0 / 1.7))
    return rows


def prepared(friction: float) -> tuple[Any, Any]:
    """Return a moving rod and its physics."""
    mesh = DiscreteRod(ROD, SEGMENTS)
    rod = mesh.straight(LOAD.mean)
    rod["vy"][: SEGMENTS + 1] = fr.Perturbation.random(1e-3, seed=1).velocities(SEGMENTS)
    mesh.initialise(rod)
    return rod, mesh.physics(LOAD, critical_time_step(mesh)[0], friction)


def element_step(friction: float) -> float:
    """Return the seconds one step of one segment takes."""
    rod, physics = prepared(friction)
    advance = compiled(cosserat.advance)
    return best_of(lambda: advance(rod, STEPS, physics), repeats=40) / (STEPS * SEGMENTS)


def two_threads() -> float:
    """Return the time of two runs in two threads over that of both, one after the other; the best of several."""
    advance = compiled(cosserat.advance)
    rods = [prepared(0.1) for _ in range(2)]
    ratios = []
    with ThreadPoolExecutor(2) as pool:
        for _ in range(10):
            start = time.perf_counter()
            for rod, physics in rods:
                advance(rod, 20 * STEPS, physics)
            middle = time.perf_counter()
            list(pool.map(lambda pair: advance(pair[0], 20 * STEPS, pair[1]), rods))
            ratios.append((time.perf_counter() - middle) / (middle - start))
    return min(ratios)


def peer_element_step(friction: float) -> float:
    """Return the seconds one step of one element takes PyElastica, with contact and friction in one compiled loop."""
    import elastica
    import numba
    import numpy as np

    mesh = DiscreteRod(ROD, SEGMENTS)
    gap, stiffness, damping, gravity = ROD.radial_clearance, mesh.contact_stiffness, mesh.contact_time, ROD.gravity

    @numba.njit
    def press(x: Any, v: Any, mass: Any, force: Any) -> None:
        for i in range(x.shape[1]):
            y, z = x[1, i], x[2, i]
            distance = math.sqrt(y * y + z * z)
            force[2, i] -= mass[i] * gravity
            if distance > gap:
                ny, nz, depth = y / distance, z / distance, distance - gap
                outwards = v[1, i] * ny + v[2, i] * nz
                normal = max(0.0, mass[i] * stiffness * math.sqrt(depth) * (depth + damping * outwards))
                around = v[2, i] * ny - v[1, i] * nz
                rub = friction * normal / max(math.hypot(v[0, i], around), 1e-6)
                force[0, i] -= rub * v[0, i]
                force[1, i] += rub * around * nz - normal * ny
                force[2, i] -= rub * around * ny + normal * nz

    class Tube(elastica.NoForces):  # type: ignore[misc]
        def apply_forces(self, system: Any, time: float = 0.0) -> None:
            press(system.position_collection, system.velocity_collection, system.mass, system.external_forces)

    class Simulator(elastica.BaseSystemCollection, elastica.Forcing):  # type: ignore[misc]
        pass

    rod = elastica.CosseratRod.straight_rod(
        SEGMENTS,
        np.array([0.0, 0.0, -gap]),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        ROD.length,
        ROD.radius,
        ROD.density,
        youngs_modulus=ROD.youngs_modulus,
        shear_modulus=mesh.shear_modulus,
    )
    rod.velocity_collection[1] = fr.Perturbation.random(1e-3, seed=1).velocities(SEGMENTS)
    simulator, stepper, clock = Simulator(), elastica.PositionVerlet(), [np.float64(0.0)]
    simulator.append(rod)
    simulator.add_forcing_to(rod).using(Tube)
    simulator.finalize()

    def steps() -> None:
        for _ in range(200):
            clock[0] = stepper.step(simulator, clock[0], np.float64(PEER_STEP))

    seconds = best_of(steps) / (200 * SEGMENTS)
    if not np.isfinite(rod.position_collection).all():
        raise RuntimeError(f"PyElastica did not bear a step of {PEER_STEP:g} s")
    return seconds
