"""Drag judged by the simulator: vibration and friction, the force along wells, helices, the wave of a tool."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from tests.conftest import some

Floats = NDArray[np.float64]

REST = fr.Perturbation()
INTERVALS = ((0.0, 0.2), (1.0, 0.5), (2.2, 0.1))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning"),  # a laboratory's bends
]


# --- friction under vibration ---


def under_vibration(modulus: float, push: float, periods: int, friction: float) -> tuple[float, Floats, Floats]:
    """Return k L of a short rod that a tool shakes at V = 4 m/s, and v / V and mean friction over mu N by periods.

    ``push`` times mu N pushes it; what that leaves over brakes it, period by period.
    """
    rod = fr.Rod(youngs_modulus=modulus, density=7850.0, radius=5e-3, length=0.5, channel_radius=8e-3)
    mass, most = rod.mass_along * rod.length, friction * rod.weight_per_length * rod.length
    frequency, speed = 400.0 * math.pi, 4.0
    cycle = 2.0 * math.pi / frequency
    run = fr.simulate(
        rod,
        fr.AxialLoad(push * most, 0.0, 1.0),
        far_force=0.0,
        tool=fr.VibrationTool(mass * frequency * speed, frequency),
        friction=friction,
        duration=periods * cycle,
        frames=periods + 1,
        segments=20,
        perturbation=REST,
    )
    share = np.array([0.5, *np.ones(19), 0.5]) / 20.0
    place, moving = run.positions[..., 0] @ share, run.velocities[..., 0] @ share
    wave = frequency / rod.wave_speed * rod.length
    return wave, np.diff(place) / cycle / speed, push - mass * np.diff(moving) / cycle / most


RATIOS = np.array([0.25, 0.4, 0.6, 0.8, 0.9, 0.98])


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_stiff_rod_slides_with_the_friction_of_the_arcsine_law(friction: float) -> None:
    wave, ratio, found = under_vibration(200e9, 0.0, round(190 / friction), friction)
    assert wave < 0.13
    assert ratio[0] > 0.99
    assert ratio[-1] < RATIOS[0]
    by_ratio = np.interp(-RATIOS, -ratio, found)
    np.testing.assert_allclose(by_ratio, 2.0 / math.pi * np.arcsin(RATIOS), rtol=0.01)
    _, ratio, found = under_vibration(200e9, 2.0, round(40 / friction), friction)
    assert ratio[-1] > 1.3
    np.testing.assert_allclose(found[ratio > 1.02], 1.0, rtol=1e-3)


def test_a_rod_whose_ends_move_differently_is_braked_otherwise() -> None:
    """Along a softer rod V varies by a half, and friction is off that law by a tenth."""
    wave, ratio, found = under_vibration(4e9, 0.0, 640, 0.3)
    assert 0.8 < wave < 0.9
    off = np.interp(-RATIOS, -ratio, found) / (2.0 / math.pi * np.arcsin(RATIOS)) - 1.0
    assert 0.05 < abs(off).max() < 0.15


# --- force and contact along wells ---

LAB = fr.Rod.nitinol().replace(youngs_modulus=3e9, damping_rate=2.0)
"""A rod so soft that it follows the well: its critical force in a level hole is 0.36 N."""


def arc(upper: float, lower: float, turn: float) -> fr.WellPath:
    """Return an arc twice as long as the rod, which bends as told along its upper half, in degrees."""
    angles, turns = np.radians([upper, 2.0 * lower - upper]), np.radians([0.0, 2.0 * turn])
    return fr.WellPath([0.0, 2.0 * LAB.length], angles, turns)


WELLS = {
    "level": ((90.0, 90.0, 0.0), 0.1),
    "build": ((45.0, 90.0, 0.0), 0.4),
    "drop": ((90.0, 75.0, 0.0), 0.3),
    "level turn": ((90.0, 90.0, 40.0), 0.2),
    "building turn": ((45.0, 65.0, 40.0), 0.4),
}
"""Arcs, and forces in N at the lower end."""


def fed(rod: fr.Rod, path: fr.WellPath, friction: Any, far_force: float) -> tuple[fr.Simulation, fr.results.MeanForce]:
    """Return a rod that is fed slowly down a well, and its mean force by theory at the nodes."""
    depth, feed = np.linspace(0.0, rod.length, 201), 0.003
    theory = rod.mean_force(path, friction, bottom=rod.length, far_force=far_force, depth=depth)
    run = fr.simulate(
        rod.replace(path=path),
        fr.AxialLoad(theory.at_top, 0.0, 1.0, mean_at=0.0),
        far_force=far_force,
        feed_speed=feed,
        friction=friction,
        duration=1.5,
        frames=101,
        segments=200,
        perturbation=REST,
    )
    assert run.positions[-1, -1, 0] - run.positions[50, -1, 0] == pytest.approx(feed * 0.75, rel=0.02)
    return run, theory


@pytest.mark.parametrize("friction", [0.3, INTERVALS])
@pytest.mark.parametrize("well", WELLS)
def test_force_and_contact_along_a_well_are_those_of_the_mean_force(well: str, friction: Any) -> None:
    angles, far_force = WELLS[well]
    path = arc(*angles)
    run, theory = fed(LAB, path, friction, far_force)
    assert run.end_forces[50:, 0].mean() == pytest.approx(theory.at_top, rel=0.02)
    along = 0.5 * (theory.force[1:] + theory.force[:-1])
    np.testing.assert_allclose(run.axial_force[50:].mean(axis=0)[5:-5], along[5:-5], rtol=0.02)
    # Near its ends a straight rod presses otherwise: there its moment begins.
    inside = slice(40, -40)
    np.testing.assert_allclose(run.contact_force[50:].mean(axis=0)[inside], theory.contact[inside], rtol=0.02)
    if friction == INTERVALS:  # of which each takes its own share
        lost = -np.gradient(run.axial_force[50:].mean(axis=0), LAB.length / 200)
        weight = LAB.weight_per_length * np.cos(path.inclination_at((np.arange(200) + 0.5) * LAB.length / 200))
        found = (lost + weight) / (0.5 * (theory.contact[1:] + theory.contact[:-1]))
        for (low, mu), high in zip(INTERVALS, (1.0, 2.2, LAB.length), strict=True):
            part = slice(max(40, math.ceil(low / LAB.length * 200) + 3), min(160, int(high / LAB.length * 200) - 3))
            assert found[part].mean() == pytest.approx(mu, rel=0.03)


def test_what_is_off_at_the_top_of_a_build_falls_with_the_stiffness() -> None:
    angles, far_force = WELLS["build"]
    off = []
    for stiffness in (1.0, 4.0):
        rod = LAB.replace(youngs_modulus=stiffness * LAB.youngs_modulus)
        run, theory = fed(rod, arc(*angles), 0.3, far_force)
        off.append(1.0 - run.end_forces[50:, 0].mean() / theory.at_top)
    assert 0.005 < off[0] < 0.015
    assert 1.5 < off[1] / off[0] < 3.0


# --- helices ---

PIPE = fr.Rod(youngs_modulus=0.2e9, density=1000.0, radius=0.01, length=1.0, channel_radius=0.015)
FORCE = PIPE.critical_force
LOCK_UP = PIPE.lock_up(friction=0.15, far_force=4.0 * FORCE).length


def coiled(build: float, turn: float, seed: int) -> tuple[fr.Simulation, fr.WellPath]:
    """Return half a lock-up length of a pipe, pushed against four critical forces in a well of these curvatures."""
    length, above = 0.5 * LOCK_UP, 5.0
    rod = PIPE.replace(length=length, ends="free", damping_rate=60.0)
    angles = 0.5 * math.pi - build * length * np.array([1.0, 1.0, 0.0, 0.0])
    turns = turn * length * np.array([0.0, 0.0, 1.0, 1.0])
    path = fr.WellPath([0.0, above, above + length, above + length + 5.0], angles, turns)
    load = fr.AxialWave(4.0 * FORCE, 0.0, 1.0, axial_damping=2.0, far_end="free")
    run = fr.simulate(
        rod.replace(path=path, depth=above),
        load,
        friction=0.15,
        far_force=load.mean,
        feed_speed=0.05,
        duration=0.012 * length / 0.05,
        segments=813,
        perturbation=fr.Perturbation.random(1e-2, seed=seed),
        frames=100,
    )
    return run, path


def wound_one_way(run: fr.Simulation, force: Floats) -> list[NDArray[np.intp]]:
    """Return the stretches of segments, a turn away from every reversal of the winding and from the ends."""
    ways = np.sign(np.diff(run.winding[-1]))
    pitch = 2.0 * math.pi / np.sqrt(force / (2.0 * PIPE.flexural_rigidity))
    turns = (pitch / run.problem.mesh.segment_length).astype(int)
    good = np.ones(force.size, dtype=bool)
    for place in (0, *np.flatnonzero(np.diff(ways)), force.size - 1):
        good[max(0, place - turns[place]) : place + turns[place] + 1] = False
    found = np.flatnonzero(good)
    return [piece for piece in np.split(found, np.flatnonzero(np.diff(found) > 1) + 1) if piece.size > 1]


def wound_all_along(path: fr.WellPath) -> float:
    """Return the force in N at the top of a helix that presses with R F^2 / (4 E I) alone, by Runge and Kutta."""
    step, depth, force = 0.5 * LOCK_UP / 400, 5.0 + 0.5 * LOCK_UP, 4.0 * FORCE

    def slope(depth: float, force: float) -> float:
        weight = PIPE.weight_per_length * math.cos(float(path.inclination_at(depth)))
        return weight - 0.15 * PIPE.radial_clearance * force**2 / (4.0 * PIPE.flexural_rigidity)

    for _ in range(400):
        one = slope(depth, force)
        two = slope(depth - 0.5 * step, force - 0.5 * step * one)
        three = slope(depth - 0.5 * step, force - 0.5 * step * two)
        four = slope(depth - step, force - step * three)
        depth, force = depth - step, force - step * (one + 2.0 * two + 2.0 * three + four) / 6.0
    return force


@pytest.mark.parametrize(("build", "turn"), [(0.0, 0.0), (0.006, 0.0), (0.02, 0.0), (0.0, 0.006), (0.0, 0.02)])
@pytest.mark.parametrize("seed", some([1, 2], 1, 1))
def test_a_helix_presses_with_its_own_force_alone_in_bends_too(build: float, turn: float, seed: int) -> None:
    """Around a helix the contact force of the string that lies has the mean zero; `Rod.mean_force` adds it."""
    run, path = coiled(build, turn, seed)
    force, push = (values[-20:].mean(axis=0) for values in (run.axial_force, run.contact_force))
    pieces = wound_one_way(run, force)
    places = np.concatenate(pieces)
    assert places.size > 0.5 * force.size
    wound = PIPE.radial_clearance * force**2 / (4.0 * PIPE.flexural_rigidity)
    pressed = 0.5 * (push[places] + push[places + 1]).mean()
    assert pressed == pytest.approx(wound[places].mean(), rel=0.03)
    length = run.problem.mesh.segment_length
    weight = PIPE.weight_per_length * np.cos(path.inclination_at(5.0 + (np.arange(force.size) + 0.5) * length))
    drops = sum(force[piece[0]] - force[piece[-1]] + length * weight[piece[:-1]].sum() for piece in pieces)
    assert drops == pytest.approx(sum(0.15 * length * wound[piece[:-1]].sum() for piece in pieces), rel=0.03)
    # Where the winding is reversed it presses less, as far as two turns.
    top = run.end_forces[-20:, 0].mean()
    assert 0.93 < top / wound_all_along(path) < 1.01
    added = PIPE.mean_force(path, 0.15, bottom=5.0 + 0.5 * LOCK_UP, far_force=4.0 * FORCE, depth=[5.0]).force[1]
    assert 0.83 < top / added < 0.95


# --- the wave of a tool ---


def shaken(
    speed: float,
    above_end: float,
    friction: float = 0.3,
    frequency: float = 20.0,
    second: tuple[float, float] | None = None,
) -> tuple[fr.Simulation, fr.results.MeanForce, float]:
    """Return a pipe of 60 m fed at a speed, its tool's wave beginning with 0.1 m/s, by theory too, and what damps it.

    ``second`` are the speed with which another wave begins and its frequency in Hz.  The last is the force in N its
    little damping takes at the top.
    """
    damping, length = 0.2 if friction > 0.2 else 0.5, 60.0
    rod = PIPE.replace(length=length, damping_rate=damping)
    path = fr.WellPath.straight(length=length + 5.0, inclination=0.5 * math.pi)
    amplitude = rod.mass_along * rod.wave_speed * 0.1 * (2.0 if above_end else 1.0)
    other = None if second is None else (10.0 * second[0] * amplitude, 2.0 * math.pi * second[1])
    tool = fr.VibrationTool(amplitude, 2.0 * math.pi * frequency, above_end, second=other)
    run = fr.simulate(
        rod,
        fr.AxialLoad(0.0, 0.0, 1.0),
        far_force=0.0,
        feed_speed=speed,
        friction=friction,
        tool=tool,
        duration=120.0 / frequency,
        frames=2401,
        segments=560,
        perturbation=REST,
    )
    depth = np.linspace(0.0, length, 561)
    theory = rod.mean_force(path, friction, bottom=length, depth=depth, tool=tool, speed=speed)
    return run, theory, 2.0 * damping * rod.mass_along * speed * length


def amplitudes(run: fr.Simulation, speed: float) -> Any:
    """Return those of the velocity with the tool's frequency in m/s, in the last sixty periods."""
    moving = run.velocities[-1201:-1, :, 0] - speed
    return 2.0 * np.abs(np.fft.rfft(moving, axis=0)[60]) / 1200.0


PLAIN = 0.3 * PIPE.weight_per_length * 60.0
"""Force in N at the top without a tool."""


@pytest.mark.parametrize("speed", [0.005, 0.01, 0.02])
def test_friction_takes_from_a_wave_what_theory_says_until_the_string_sticks(speed: float) -> None:
    """From about twice the speed of sliding on it sticks in a part of every period, and the wave runs on in pulses.

    Theory ends the wave at the speed of sliding, and asks for more force than it takes.
    """
    run, theory, drag = shaken(speed, 0.0)
    found = amplitudes(run, speed)
    strong = theory.speed > max(2.0 * speed, 0.03)
    assert strong.sum() > 100
    np.testing.assert_allclose(found[strong], theory.speed[strong], atol=0.05 * 0.1)  # of what the wave begins with
    assert 1.2 * speed < found[theory.speed <= speed][50:].mean() < 2.0 * speed
    top = run.end_forces[-1200:, 0].mean() - drag
    assert 0.9 * theory.at_top < top < theory.at_top < PLAIN
    assert 1.05 < (PLAIN - top) / (PLAIN - theory.at_top) < 1.2


@pytest.mark.filterwarnings("ignore::floquetrod.ResolutionWarning")
@pytest.mark.parametrize("seed", range(2))
def test_friction_takes_from_two_waves_what_theory_says(seed: int) -> None:
    """Where they move the string more than seven times as fast as it slides: else it sticks, as with one."""
    rng = np.random.default_rng([11, seed])
    speed, size, faster = rng.uniform(0.01, 0.02), rng.uniform(0.04, 0.1), 20.0 * rng.uniform(1.55, 1.7)
    run, theory, drag = shaken(speed, 0.0, second=(size, faster))
    phase = 2.0 * math.pi * np.arange(1200) / 20.0
    waves = [wave(x) for x in (phase, phase * faster / 20.0) for wave in (np.cos, np.sin)]
    moving = run.velocities[-1201:-1, :, 0]
    _, a, b, c, d = np.linalg.lstsq(np.array([np.ones(1200), *waves]).T, moving, rcond=None)[0]
    found = np.hypot(a, b) + np.hypot(c, d)
    strong = theory.speed > 7.0 * speed
    assert strong.sum() > 100
    np.testing.assert_allclose(found[strong], theory.speed[strong], atol=0.05 * (0.1 + size))
    assert found[-1] == pytest.approx(theory.speed[-1], rel=0.01)
    top = run.end_forces[-1200:, 0].mean() - drag
    assert 0.8 * theory.at_top < top < theory.at_top < PLAIN


def test_a_tool_inside_the_string_saves_more_than_theory_says() -> None:
    """Where the wave is slow, the string sticks in a part of every period."""
    run, theory, drag = shaken(0.02, 20.0)
    top = run.end_forces[-1200:, 0].mean() - drag
    assert 0.87 * theory.at_top < top < theory.at_top < 0.6 * PLAIN


@pytest.mark.filterwarnings("ignore::floquetrod.ResolutionWarning")
@pytest.mark.parametrize(("frequency", "above_end"), [(20.0, 0.0), (20.0, 20.0), (12.0, 20.0), (33.0, 20.0)])
def test_the_ends_reflect_a_wave_as_theory_says(frequency: float, above_end: float) -> None:
    """Little friction lets it stand between them: at 21 Hz a quarter of a wave is as long as the string."""
    run, theory, drag = shaken(0.01, above_end, 0.05, frequency)
    found = amplitudes(run, 0.01)
    assert found.max() > 1.9 * 0.1  # of what it begins with
    np.testing.assert_allclose(found, theory.speed, atol=0.01 * found.max())
    top = run.end_forces[-1200:, 0].mean() - drag
    assert top == pytest.approx(theory.at_top, rel=0.08)
    assert top < PLAIN / 40.0
