"""Nanoseconds an element-step, the time to a growth rate good to 1 %, a long string, two runs in two threads.

Held against the former simulator, a Cosserat rod of second order (`benchmarks.cosserat`), and against PyElastica with a
tube contact written for it here, where that is installed (pip install pyelastica).
"""

from __future__ import annotations

import importlib.util
import math
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import floquetrod as fr
from benchmarks import cosserat
from benchmarks.measure import Row, best_of
from floquetrod._util.compilation import compiled
from floquetrod.simulation.kernels import rod_step
from floquetrod.simulation.rod_mesh import DiscreteRod

SEGMENTS, STEPS = 250, 1000
FORMER = "former"
PEER, PEER_STEP = "PyElastica", 0.4e-6  # s: the largest step that it takes for this rod
ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)

GROWING = fr.AxialLoad(0.15 * ROD.critical_force, 0.40 * ROD.critical_force, 171.0)
GROWTH, MODE, GOOD = 6.7791456, 8, 0.01
"""Growth in 1/s of its fastest mode by Floquet theory with the axial wave, by Magnus steps of fourth order; how near a
simulated rate is to be."""

TUBING = fr.Rod(
    207e9,
    7850.0,
    diameter=50.8e-3,
    inner_diameter=42.88e-3,
    length=3000.0,
    channel_diameter=0.124,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
)


def run() -> list[Row]:
    """Return the figures of the issues' lists, with what was promised."""
    installed = importlib.util.find_spec("elastica") is not None
    rows = []
    for name, friction, most, ratio in (("no friction", 0.0, 9.0, 20.0), ("friction and rolling", 0.1, 14.0, 12.0)):
        for segments in (125, SEGMENTS, 1000):
            ours, former = (1e9 * step(friction, segments) for step in (element_step, former_element_step))
            # As before or better: a twentieth is left to chance.
            rows.append(Row(f"element-step, {name}, {segments}", ours, "ns", FORMER, former, most, 0.95))
            if segments == SEGMENTS and installed:
                theirs = 1e9 * peer_element_step(friction)
                rows.append(Row(f"element-step, {name}", ours, "ns", PEER, theirs, ratio_at_least=ratio))
                if friction == 0.0:
                    second = fr.simulate(ROD, LOAD, duration=0.05, segments=SEGMENTS, frames=21).seconds / 0.05
                    peer = 1e-9 * theirs * SEGMENTS / PEER_STEP
                    rows.append(
                        Row("simulated second of the reference rod", second, "s", PEER, peer, ratio_at_least=80)
                    )
    rows.append(growth())
    string = fr.SimulationProblem(TUBING, vibrated(), duration=10.0, friction=0.3)
    name = f"10 s of 3 km of tubing with friction, {string.segments} segments"
    rows.append(Row(name, string.run().seconds, "s", at_most=10.0))
    if (os.cpu_count() or 1) > 1:
        rows.append(Row("two runs in two threads, over one after the other", two_threads(), "", at_most=1.0 / 1.7))
    return rows


def prepared(friction: float, segments: int = SEGMENTS) -> tuple[Any, Any]:
    """Return a moving rod and its physics."""
    problem = fr.SimulationProblem(ROD, LOAD, friction=friction, segments=segments)
    rod = problem.mesh.start(problem.driving, problem.perturbation.velocities(segments), friction)
    return rod, problem.mesh.physics(problem.driving, problem.time_steps.size, problem.wall_friction)


def element_step(friction: float, segments: int) -> float:
    """Return the seconds one step of one segment takes."""
    return _element_step(rod_step.advance, *prepared(friction, segments))


def former_element_step(friction: float, segments: int) -> float:
    """Return the seconds one step of one segment takes the former kernel."""
    problem = fr.SimulationProblem(ROD, LOAD, friction=friction, segments=segments)
    step = cosserat.critical_time_step(problem.mesh, 1e-3)
    return _element_step(
        cosserat.advance, cosserat.start(problem), cosserat.physics(problem.mesh, LOAD, step, friction)
    )


def _element_step(kernel: Callable[..., Any], rod: Any, physics: Any) -> float:
    """Return the seconds one step of one segment takes a kernel."""
    advance = compiled(kernel)
    return best_of(lambda: advance(rod, STEPS, physics), repeats=40) / (STEPS * physics.segments)


def growth() -> Row:
    """Return the time of a simulation whose growth rate is good to 1 %, by the fewest segments that make it so."""
    periods = 20
    problem = fr.SimulationProblem(
        ROD,
        GROWING,
        duration=periods * 2.0 * math.pi / GROWING.frequency,
        perturbation=fr.Perturbation.modes({MODE: 1e-6}),
        frames=8 * periods + 1,
        segments=48,
    )
    found = [fewest(problem, simulate) for simulate in (fr.SimulationProblem.run, cosserat.simulate)]
    (ours, mine), (former, theirs) = found
    name = f"growth to {GOOD:.0%}: {ours} segments, formerly {former}"
    return Row(name, mine, "s", FORMER, theirs, ratio_at_least=4.0)


def fewest(problem: fr.SimulationProblem, simulate: Callable[[Any], fr.Simulation]) -> tuple[int, float]:
    """Return the fewest segments, in steps of 8, with which the growth rate is good, and the seconds that takes."""
    segments = 6 * MODE
    while abs(simulate(problem.replace(segments=segments)).growth_rate(MODE).rate / GROWTH - 1.0) > GOOD:
        segments += 8
    enough = problem.replace(segments=segments)
    return segments, best_of(lambda: simulate(enough), repeats=20)


def vibrated() -> fr.AxialWave:
    """Return half of what buckles the tubing, and a vibration of 16 Hz that travels down from its upper end."""
    return fr.AxialWave.hertz(0.5 * TUBING.critical_force, 0.3 * TUBING.critical_force, 16.0)


def two_threads() -> float:
    """Return the time of two runs in two threads over that of both, one after the other; the best of several."""
    advance = compiled(rod_step.advance)
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
