"""Beyond the onset of buckling: helix, contact force, slow pushes, lock-up, and drag that vibration reduces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.simulation.kernels import rod_step

PIPE = fr.Rod(youngs_modulus=0.2e9, density=1000.0, radius=0.01, length=1.0, channel_radius=0.015, damping_rate=2.0)
"""A polyethylene rod.  Its critical force strains it by 1e-3: waves along it are slow, so that long runs are quick."""

FORCE = PIPE.critical_force
WEIGHT = PIPE.mass_per_length * PIPE.effective_gravity
GAP, STIFFNESS = PIPE.radial_clearance, PIPE.flexural_rigidity


def pipe(half_waves: float, **changes: Any) -> fr.Rod:
    """Return the rod, as long as so many half waves of its critical mode."""
    return PIPE.replace(length=half_waves * PIPE.length / PIPE.critical_mode, **changes)


def constant(force: float, **options: Any) -> fr.AxialWave:
    """Return a constant force in critical forces."""
    return fr.AxialWave(force * FORCE, 0.0, 1.0, axial_damping=2.0, **options)


def first(found: np.ndarray) -> int:
    """Return the first frame in which something is found."""
    assert found.any()
    return int(found.argmax())


# --- what is measured -------------------------------------------------------------------------------------------------


def shaken() -> fr.Simulation:
    """Return a run whose nodes press on the wall, leave it and strike it."""
    load = fr.AxialLoad(3.0 * FORCE, 0.0, 1.0)
    kick = fr.Perturbation.random(0.3, seed=3)
    return fr.simulate(pipe(2.0), load, duration=0.1, frames=6, segments=24, perturbation=kick)


def test_contact_force_is_that_of_the_law_of_the_contact() -> None:
    run = shaken()
    mesh = run.problem.mesh
    y, z = run.positions[..., 1], run.positions[..., 2]
    vy, vz = run.velocities[..., 1], run.velocities[..., 2]
    depth = np.maximum((y**2 + z**2 - GAP**2) / (2.0 * GAP), 0.0)
    rate = (y * vy + z * vz) / GAP
    law = mesh.contact_stiffness * np.sqrt(depth) * np.maximum(depth + mesh.contact_time * rate, 0.0)
    expected = PIPE.mass_per_length * law * np.hypot(y, z) / GAP
    assert (expected == 0.0).any()
    assert (expected > 3.0 * WEIGHT).any()
    np.testing.assert_allclose(run.contact_force, expected, rtol=1e-9, atol=1e-9 * WEIGHT)


def test_the_wall_pushes_alike_with_friction_and_without() -> None:
    run = shaken()
    mesh, driving = run.problem.mesh, run.problem.driving
    physics = mesh.physics(driving, 1e-5)
    records = []
    for friction in (None, 0.0):
        rod = mesh.start(driving, np.zeros(mesh.segments + 1))
        for axis, name in enumerate("xyz"):
            mesh.nodes(rod, name)[:] = run.positions[-1, :, axis]
            mesh.nodes(rod, f"v{name}")[:] = run.velocities[-1, :, axis]
        compiled(rod_step.move_nodes)(rod, None, None, friction, physics)
        records.append(rod)
    for name in ("vx", "vy", "vz"):
        np.testing.assert_allclose(records[0][name], records[1][name], rtol=1e-12, atol=1e-15)


def test_a_rod_at_rest_presses_with_its_weight_and_its_mean_force() -> None:
    load = fr.AxialLoad(0.5 * FORCE, 0.0, 1.0)
    run = fr.simulate(pipe(3.0), load, duration=0.01, frames=3, perturbation=fr.Perturbation.modes({}))
    np.testing.assert_allclose(run.contact_force, WEIGHT, rtol=1e-9)
    np.testing.assert_allclose(run.axial_force, 0.5 * FORCE, rtol=1e-9)
    assert run.axial_force.shape == (3, run.problem.segments)
    assert not run.winding.any()


# --- the helix --------------------------------------------------------------------------------------------------------


def longest_helix(run: fr.Simulation, force: float) -> slice:
    """Return the nodes of whole turns of the longest stretch wound one way, a turn away from where it ends."""
    length = run.problem.mesh.segment_length
    turn = round(2.0 * math.pi / math.sqrt(force / (2.0 * STIFFNESS)) / length)
    winding = run.winding[-1]
    ways = np.sign(np.diff(winding))
    ends = np.flatnonzero(np.diff(ways)) + 1
    pieces = np.split(np.arange(winding.size), ends)
    nodes = max(pieces, key=len)[turn:-turn]
    turns = np.abs(winding[nodes] - winding[nodes[0]]) / (2.0 * math.pi)
    assert turns[-1] > 2.0
    last = int(np.flatnonzero(turns <= math.floor(turns[-1]))[-1])
    return slice(nodes[0], nodes[0] + last + 1)


@pytest.mark.slow
@pytest.mark.parametrize("force", [4.0, 6.0])
def test_pitch_and_contact_force_of_the_helix(force: float) -> None:
    load = fr.AxialLoad(force * FORCE, 0.0, 1.0)
    rod = pipe(14.0, ends="free", damping_rate=10.0)
    run = fr.simulate(rod, load, duration=2.0, frames=3, perturbation=fr.Perturbation.random(1e-2, seed=1))
    nodes, step = longest_helix(run, load.mean), run.problem.mesh.segment_length
    winding, push = run.winding[-1, nodes], run.contact_force[-1, nodes]
    wave_number = math.sqrt(load.mean / (2.0 * STIFFNESS))
    assert abs(winding[-1] - winding[0]) / (winding.size - 1) / step == pytest.approx(wave_number, rel=0.02)
    # The weight is averaged out over whole turns.
    assert push.mean() == pytest.approx(GAP * load.mean**2 / (4.0 * STIFFNESS), rel=0.02)
    # Node by node it is not: Mitchell's contact force, of the angle as it is.
    rates = [winding]
    for _ in range(3):
        rates.append(np.gradient(rates[-1], step, edge_order=2))
    _, one, two, three = (values[8:-8] for values in rates)
    bent = load.mean * one**2 + STIFFNESS * (4.0 * one * three + 3.0 * two**2 - one**4)
    expected = WEIGHT * np.cos(winding[8:-8]) + GAP * bent
    np.testing.assert_allclose(push[8:-8], expected, atol=0.02 * expected.mean())


# --- slow pushes ------------------------------------------------------------------------------------------------------


def pushed(friction: float, speed: float, half_waves: int = 12) -> tuple[float, float, fr.Simulation]:
    """Return the forces in F_p at which a rod pushed against a stop waves (5 degrees), and first goes over the top."""
    rod = pipe(half_waves, damping_rate=0.5)
    run = fr.simulate(
        rod,
        constant(0.9),
        friction=friction,
        feed_speed=speed * half_waves / 12.0,
        duration=0.018 / speed,
        frames=500,
        segments=24 * half_waves,
        perturbation=fr.Perturbation.random(1e-2, seed=1),
    )
    force = run.end_forces[:, 0] / FORCE
    waves = first(run.largest_angle > math.radians(5.0))
    helix = first(np.abs(run.winding).max(axis=1) > math.pi)
    assert waves < helix
    return force[:waves].max(), force[:helix].max(), run


@pytest.mark.slow
def test_a_slowly_pushed_rod_waves_and_then_winds() -> None:
    """Waves from F_p on; a helix between sqrt(2) (Chen, Lin and Cheatham) and 1.83 F_p (Wu and Juvkam-Wold)."""
    waves, helix, run = pushed(0.0, 2e-3)
    assert 1.0 < waves < 1.15
    assert math.sqrt(2.0) < helix < 1.83
    shape = run.angle[first(run.largest_angle > math.radians(20.0))]
    assert np.count_nonzero(np.diff(np.sign(shape[1:-1]))) == pytest.approx(11, abs=1)


@pytest.mark.slow
def test_the_slower_the_push_the_nearer_the_first_wave_is_to_the_critical_force() -> None:
    found = [pushed(0.0, speed)[0] for speed in (8e-3, 2e-3, 5e-4)]
    assert found[0] > found[1] > found[2] > 1.0
    assert found[2] < 1.06


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.1, 0.3])
@pytest.mark.parametrize("speed", [2e-3, 5e-4])
def test_friction_delays_both_shapes(friction: float, speed: float) -> None:
    """Both come later, the helix still before 2.83 F_p, above which there is no other shape (Mitchell)."""
    waves, helix, run = pushed(friction, speed)
    assert 1.2 < waves < 2.0
    assert 1.5 < helix < 2.0 * math.sqrt(2.0)
    assert np.ptp(run.winding[-1]) > 2.0 * math.pi


# --- lock-up ----------------------------------------------------------------------------------------------------------


def slid(part: float, friction: float, force: float, highest: float, **options: Any) -> tuple[fr.Simulation, Any]:
    """Return a rod pushed down its channel against a force (F_p) at its lower end, and what `Rod.lock_up` says.

    The rod is ``part`` of its lock-up length long, and has segments for a helix under the ``highest`` force (F_p).
    """
    rod = pipe(10.0, ends="free", damping_rate=60.0)
    formula = rod.lock_up(friction=friction, far_force=force * FORCE)
    rod = rod.replace(length=part * formula.length)
    given = {
        "rod": rod,
        "load": constant(force, far_end="free"),
        "friction": friction,
        "far_force": force * FORCE,
        "feed_speed": 0.05,
        "duration": 0.012 * rod.length / 0.05,
        "segments": math.ceil(12.0 * rod.critical_mode * math.sqrt(highest)),
        "perturbation": fr.Perturbation.random(1e-2, seed=1),
        "frames": 100,
    }
    return fr.simulate(**(given | options)), formula


def mean_over_the_last(run: fr.Simulation, values: np.ndarray) -> np.ndarray:
    """Return the mean of values over the last fifth of the frames."""
    return np.asarray(values[-run.time.size // 5 :].mean(axis=0))


def wound_one_way(run: fr.Simulation, force: np.ndarray) -> list[np.ndarray]:
    """Return the stretches of segments, a turn away from every reversal of the winding and from the ends."""
    length = run.problem.mesh.segment_length
    ways = np.sign(np.diff(run.winding[-1]))
    turns = (2.0 * math.pi / np.sqrt(force / (2.0 * STIFFNESS)) / length).astype(int)
    good = np.ones(force.size, dtype=bool)
    for place in (0, *np.flatnonzero(np.diff(ways)), force.size - 1):
        good[max(0, place - turns[place]) : place + turns[place] + 1] = False
    found = np.flatnonzero(good)
    return [piece for piece in np.split(found, np.flatnonzero(np.diff(found) > 1) + 1) if piece.size > 1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_lock_up_length(seed: int) -> None:
    """Along a helix 1/F falls by mu w / F_p^2 per length, to 0 where it locks up: where the formula says, within 5 %.

    Where its winding is reversed it presses less on the wall: a string with reversals goes further.
    """
    run, formula = slid(0.5, 0.15, 4.0, 8.4, perturbation=fr.Perturbation.random(1e-2, seed=seed))
    force, length = mean_over_the_last(run, run.axial_force), run.problem.mesh.segment_length
    moved = run.positions[-1] - run.positions[-20]
    assert moved[-1, 0] == pytest.approx(moved[0, 0], rel=0.05)  # it slides all along
    pieces = wound_one_way(run, force)
    covered = length * sum(piece[-1] - piece[0] for piece in pieces)
    assert covered > 0.4 * run.rod.length
    falls = sum(1.0 / force[piece[-1]] - 1.0 / force[piece[0]] for piece in pieces)
    assert covered / falls / formula.far_force == pytest.approx(formula.length, rel=0.05)
    upper = mean_over_the_last(run, run.end_forces)[0]
    assert 1.0 < run.rod.length / formula.pushed_length(upper) < 1.15
    # Weight is averaged out: the helix presses with R F^2 / (4 E I) alone.
    push = mean_over_the_last(run, run.contact_force)
    places = np.concatenate(pieces)
    pressed = 0.5 * (push[places] + push[places + 1]).mean()
    assert pressed == pytest.approx(GAP * (force[places] ** 2).mean() / (4.0 * STIFFNESS), rel=0.04)


@pytest.mark.slow
def test_a_sliding_helix_is_held_back_by_its_contact_force() -> None:
    """Friction opposes the whole slip, of which a small part is around the channel."""
    friction = 0.3
    run, _ = slid(0.5, friction, 4.0, 8.4)
    push = mean_over_the_last(run, run.contact_force)
    upper, lower = mean_over_the_last(run, run.end_forces)
    most = friction * push[1:].sum() * run.problem.mesh.segment_length
    assert 0.95 * most < upper - lower < 1.01 * most


@pytest.mark.slow
def test_a_string_locks_up_and_vibration_carries_it_past() -> None:
    """At 1.2 times the lock-up length the far end stays, whatever the push; a vibration there lets it slide."""
    rod = pipe(10.0, damping_rate=3.0)
    rod = rod.replace(length=1.2 * rod.lock_up(friction=0.3, far_force=3.0 * FORCE).length)
    still, shaken = (
        slid(1.2, 0.3, 3.0, 12.0, rod=rod, load=load, duration=0.005 * rod.length / 0.05)[0]
        for load in (fr.AxialLoad.hertz(3.0 * FORCE, amplitude * FORCE, 10.0) for amplitude in (0.0, 1.0))
    )
    assert still.end_forces[-1, 0] > 15.0 * FORCE
    assert mean_over_the_last(shaken, shaken.end_forces)[0] < 7.0 * FORCE
    fed = still.positions[-1, 0, 0] - still.positions[0, 0, 0]
    moved = [run.positions[-1, -1, 0] - run.positions[0, -1, 0] for run in (still, shaken)]
    assert moved[0] < 0.05 * fed
    assert moved[1] > 0.6 * fed


# --- drag -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.5, 2.0, 8.0])
def test_vibration_reduces_drag_as_coulombs_law_on_average(ratio: float) -> None:
    """A straight rod pushed at v while its far end vibrates: the mean drag of each node is 2/pi asin(v / A), A > v.

    ``ratio`` is the largest A over v.  A is that of the wave without friction, which is small beside the force.
    """
    friction, amplitude, hertz, count = 0.05, 0.25 * FORCE, 10.0, 48
    rod = pipe(3.0, damping_rate=5.0)
    load = fr.AxialLoad.hertz(0.1 * FORCE, amplitude, hertz)
    wave_number = load.frequency / rod.wave_speed
    nodes = np.arange(1, count) * rod.length / count  # the ends are hinged: what holds them bears them
    fastest = amplitude * rod.wave_speed / (rod.youngs_modulus * rod.area) / math.cos(wave_number * rod.length)
    speeds = fastest * np.sin(wave_number * nodes)
    speed = speeds[-1] / ratio
    run = fr.simulate(
        rod,
        load,
        friction=friction,
        feed_speed=speed,
        duration=2.0,
        frames=21,
        segments=count,
        perturbation=fr.Perturbation.modes({}),
    )
    drag = np.diff(run.end_forces[11:], axis=1).mean() * -1.0
    drag -= 2.0 * rod.damping_rate * rod.density * rod.area * rod.length * speed  # of the fluid
    slowed = 2.0 / math.pi * np.arcsin(np.minimum(1.0, speed / speeds))
    assert drag / (friction * WEIGHT * rod.length) == pytest.approx(slowed.sum() / count, abs=0.02)
