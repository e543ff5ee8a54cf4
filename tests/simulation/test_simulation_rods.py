"""Simulated real rods: inclined tubes in fluids with all ends, under waves and records, pushed, held and fed."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util import sealed_files
from floquetrod.simulation import simulation_problem as problems
from tests.damages import unpacked
from tests.simulation.test_simulation import Stop

TUBING = fr.Rod(
    207e9,
    7850.0,
    diameter=50.8e-3,
    inner_diameter=42.88e-3,
    length=60.0,
    channel_diameter=0.124,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
)
"""Coiled tubing in water."""

PUSH = TUBING.critical_force
RIGIDITY = TUBING.youngs_modulus * TUBING.area
MASS_ALONG = TUBING.density * TUBING.area * TUBING.length
INCLINED = TUBING.replace(inclination=math.radians(60.0))
UNMOVED = fr.Perturbation()
BOTH_FORMS = ("sine", (0.7 - 0.2j, 0.1, 0.2j))


def steady(force: float, **others: Any) -> fr.AxialLoad:
    """Return a force that does not vary."""
    return fr.AxialLoad(force, 0.0, 25.0, **others)


def wave(far_end: str, amplitude: float = 0.3 * PUSH, damping: float = 3.0, **others: Any) -> fr.AxialWave:
    """Return half the critical force and a vibration of 4 Hz at the upper end."""
    return fr.AxialWave.hertz(0.5 * PUSH, amplitude, 4.0, far_end=far_end, axial_damping=damping, **others)


def axial_force(run: fr.Simulation) -> tuple[np.ndarray, np.ndarray]:
    """Return places in m, and the compression there in N in every frame, by differences of fourth order."""
    n, length = run.problem.segments, run.rod.length / run.problem.segments
    steps = np.diff(run.positions, axis=1)
    tangents = (27.0 * steps[:, 1:-1] - (run.positions[:, 3:] - run.positions[:, :-3])) / (24.0 * length)
    rigidity = run.rod.youngs_modulus * run.rod.area
    return (np.arange(1, n - 1) + 0.5) * length, rigidity * (1.0 - np.linalg.norm(tangents, axis=2))


def vibration(load: fr.AxialLoad | fr.AxialWave, s: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return the force that theory says varies along the rod, (frames, places)."""
    total = np.zeros((time.size, s.size))
    for k, harmonic in enumerate(load.harmonics, start=1):
        phase = np.exp(1j * k * load.frequency * time)[:, None]
        profile = load.profile(TUBING.wave_speed, TUBING.length, s, k * load.frequency)
        total += (load.amplitude * harmonic * profile * phase).real
    return total


@pytest.mark.slow
@pytest.mark.parametrize("waveform", BOTH_FORMS)
@pytest.mark.parametrize("far_end", ["held", "free", "driven"])
def test_the_axial_force_is_that_of_the_wave_at_all_times(far_end: str, waveform: Any) -> None:
    load = wave(far_end, waveform=waveform)
    run = fr.simulate(TUBING, load, duration=1.0, frames=101, segments=100, perturbation=UNMOVED)
    s, force = axial_force(run)
    assert np.abs(force - load.mean - vibration(load, s, run.time)).max() < 5e-4 * load.amplitude
    moved = np.ptp(run.positions[:, -1, 0])
    assert moved == 0.0 if far_end == "held" else moved > 1e-3
    # Each the mean since the frame before, hence of times between frames.
    theirs = run.end_forces[1:, 1] - load.mean
    between = 0.5 * (run.time[1:] + run.time[:-1])
    expected = vibration(load, np.array([TUBING.length]), between)[:, 0] if far_end != "free" else np.zeros(100)
    assert np.abs(theirs - expected).max() < 0.05 * load.amplitude


def test_a_uniform_force_makes_the_wave_that_runs_from_both_ends() -> None:
    load = fr.AxialLoad.hertz(0.3 * PUSH, 0.3 * PUSH, 12.0)
    run = fr.simulate(TUBING, load, duration=0.5, frames=51, segments=100, perturbation=UNMOVED)
    s, force = axial_force(run)
    both = fr.AxialWave(load.mean, load.amplitude, load.frequency, far_end="driven")
    assert np.abs(force - load.mean - vibration(both, s, run.time)).max() < 1e-3 * load.amplitude


@pytest.mark.parametrize(("mean_at", "friction"), [(0.0, 0.0), (0.5, 0.0), (1.0, 0.2), (None, 0.0)])
def test_an_inclined_rod_stays_at_rest_with_a_force_that_grows_downwards(mean_at: Any, friction: float) -> None:
    load = steady(0.3 * PUSH, mean_at=mean_at)
    run = fr.simulate(INCLINED, load, duration=0.5, frames=5, segments=100, friction=friction, perturbation=UNMOVED)
    # What the ends lack in order starts a faint wave; the weight alone would bring 2 m/s.
    assert np.abs(run.velocities).max() < 1e-4
    s, force = axial_force(run)
    grown = 0.0 if mean_at is None else INCLINED.weight_along * (s - mean_at * INCLINED.length)
    assert np.abs(force - load.mean - grown).max() < 1e-4 * load.mean
    ends = np.diff(run.end_forces, axis=1)[:, 0]
    assert ends == pytest.approx(0.0 if mean_at is None else INCLINED.weight_along * INCLINED.length, rel=1e-9)


def test_a_rod_slides_down_its_channel_once_nothing_bears_it() -> None:
    """Friction bears mu w_e sin(inclination), the weight along pulls by w_e cos(inclination); the material moves."""
    gravity = INCLINED.weight_per_length / (INCLINED.density * INCLINED.area)
    for friction, acceleration in (
        (0.1, gravity * (math.cos(INCLINED.inclination) - 0.1 * math.sin(INCLINED.inclination))),
        (0.7, 0.0),
    ):
        sliding = INCLINED.replace(ends="guided")
        run = fr.simulate(
            sliding, steady(0.0), duration=0.5, frames=5, friction=friction, perturbation=UNMOVED, far_force=0.0
        )
        upper = -sliding.weight_along * sliding.length * 0.5  # the pull that holds the upper half at the start
        assert run.end_forces[-1] == pytest.approx([upper, 0.0])
        acceleration = max(0.0, acceleration + upper / MASS_ALONG) if acceleration else 0.0
        assert run.velocities[-1, :, 0].mean() == pytest.approx(acceleration * 0.5, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_forces_at_both_ends_accelerate_the_material(friction: float) -> None:
    rod, first, last = TUBING.replace(ends="guided"), 2000.0, 500.0
    run = fr.simulate(
        rod, steady(first), duration=0.2, frames=5, far_force=last, friction=friction, perturbation=UNMOVED
    )
    force = first - last - friction * rod.weight_per_length * rod.length
    momentum = rod.density * rod.area * rod.length * run.velocities[-1, :, 0].mean()
    assert momentum == pytest.approx(force * 0.2, rel=0.02)  # the end nodes count half
    assert np.abs(run.energy_error).max() < 1e-3 * run.energy["work"].max()


def test_friction_holds_a_rod_that_is_pushed_less() -> None:
    first, last = 0.5 * PUSH, 0.5 * PUSH - 0.9 * 0.3 * TUBING.weight_per_length * TUBING.length
    run = fr.simulate(TUBING, steady(first), duration=0.5, frames=5, far_force=last, friction=0.3, perturbation=UNMOVED)
    assert np.abs(run.velocities[-1, 1:-1]).max() < 1e-12
    assert np.abs(run.velocities[-1]).max() < 1e-4  # at the hinges, which bear the ends without friction
    assert run.end_forces == pytest.approx(np.tile([first, last], (5, 1)))


def test_a_fed_end_moves_as_told_and_its_force_rises_with_the_strain() -> None:
    speed = 1e-3
    load = wave("held", 0.0, 60.0)
    run = fr.simulate(TUBING, load, duration=1.0, frames=21, feed_speed=speed, perturbation=UNMOVED)
    fed = run.positions[:, 0, 0] - run.positions[0, 0, 0]
    assert fed == pytest.approx(speed * run.time, abs=speed * run.time_steps.size)
    assert np.ptp(run.positions[:, -1, 0]) == 0.0
    between = 0.5 * (run.time[1:] + run.time[:-1])
    rise = RIGIDITY * speed / TUBING.length
    late = run.time[1:] > 0.3  # once the wave that the start of the feed sends out has died
    expected = load.mean + rise * between[late]
    drag = 2.0 * 60.0 * 0.5 * MASS_ALONG * speed  # of damping on a motion that falls to zero at the lower end
    assert run.end_forces[1:, 1][late] == pytest.approx(expected - drag / 3.0, abs=0.01 * rise)
    assert run.end_forces[1:, 0][late] == pytest.approx(expected + 2.0 * drag / 3.0, abs=0.01 * rise)
    work = np.diff(run.energy["work"])
    expected = run.end_forces[1:, 0] * np.diff(run.time) * speed
    assert work[1:] == pytest.approx(expected[1:], rel=1e-9)
    expected[0] -= 0.5 * load.mean * speed * run.time_steps.size  # it is at rest until half a step after the start
    assert work[0] == pytest.approx(expected[0], rel=1e-5)  # the force rises within the first step
    assert np.abs(run.energy_error).max() < 1e-3 * run.energy["work"].max()


def test_a_fed_rod_rubs_all_along_its_channel() -> None:
    """Pushed at a constant speed it slides as a whole, and the upper end bears friction more than the lower one."""
    rod = TUBING.replace(ends="guided", damping_rate=2.0)
    run = fr.simulate(rod, steady(1000.0), duration=2.0, frames=41, feed_speed=0.1, friction=0.2, perturbation=UNMOVED)
    late = run.time > 1.0
    assert run.velocities[late][:, :, 0].mean() == pytest.approx(0.1, rel=0.02)
    rubs = 0.2 * rod.weight_per_length * rod.length + 2.0 * 2.0 * MASS_ALONG * 0.1
    assert (run.end_forces[late, 0] - run.end_forces[late, 1]).mean() == pytest.approx(rubs, rel=0.02)
    assert np.abs(run.energy_error).max() < 1e-3 * run.energy["work"].max()


KICKED = fr.Perturbation.modes({5: 0.5})
BALANCED = [
    (TUBING, fr.AxialLoad.hertz(0.5 * PUSH, 0.6 * PUSH, 4.0), {}),
    (TUBING.replace(damping_rate=1.0, ends="clamped"), wave("free"), {}),
    (INCLINED.replace(ends="clamped-guided"), wave("held"), {}),
    (INCLINED.replace(ends="free", damping_rate=0.5), wave("driven", waveform=BOTH_FORMS[1]), {}),
    (TUBING.replace(ends="guided-hinged"), steady(0.5 * PUSH), {"far_force": 0.4 * PUSH}),
    (INCLINED, fr.AxialLoad.hertz(0.5 * PUSH, 0.3 * PUSH, 4.0), {"feed_speed": 5e-3}),
    (TUBING.replace(ends="hinged-clamped"), wave("held", 0.0), {"feed_speed": 5e-3}),
]


@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize(("rod", "load", "ends"), BALANCED)
def test_energy_balance(rod: fr.Rod, load: Any, ends: dict[str, float], friction: float) -> None:
    """Thrown to 100 degrees and more, at half the usual step."""
    run = fr.simulate(
        rod,
        load,
        duration=1.0,
        frames=21,
        segments=100,
        friction=friction,
        perturbation=KICKED,
        time_step=4.6e-5,
        **ends,
    )
    turned_over = run.energy["kinetic"].max() + np.abs(run.energy["work"]).max() + run.energy["dissipated"].max()
    assert np.abs(run.energy_error).max() < 1e-3 * turned_over
    assert (np.diff(run.energy["dissipated"]) >= 0.0).all()
    assert (run.energy["dissipated_friction"][-1] > 0.0) == (friction > 0.0)
    assert (run.energy["dissipated_damping"][-1] > 0.0) == (rod.damping_rate > 0.0 or isinstance(load, fr.AxialWave))


@pytest.mark.parametrize(("rod", "load", "ends"), [BALANCED[0], BALANCED[5], BALANCED[6]])
def test_the_error_of_the_balance_is_of_second_order_in_the_step(
    rod: fr.Rod, load: Any, ends: dict[str, float]
) -> None:
    """Contact included, and the work of an end that is fed from rest."""
    errors = [
        fr.simulate(
            rod, load, duration=1.0, frames=21, segments=100, perturbation=KICKED, time_step=step, **ends
        ).energy_error
        for step in (4.6e-5, 2.3e-5)
    ]
    assert np.abs(errors[0]).max() / np.abs(errors[1]).max() == pytest.approx(4.0, rel=0.1)


@pytest.mark.kernels
@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize(("rod", "load", "ends"), BALANCED)
def test_very_short_runs(rod: fr.Rod, load: Any, ends: dict[str, float], friction: float) -> None:
    run = fr.simulate(rod, load, duration=4e-3, frames=3, segments=60, friction=friction, perturbation=KICKED, **ends)
    assert run.complete
    assert np.abs(run.energy_error).max() < 1e-3 * run.energy["kinetic"].max()


def test_a_record_runs_as_its_harmonics() -> None:
    time = np.linspace(0.0, 1.0, 513)[:-1]
    force = 0.5 * PUSH * (1.0 + 0.4 * np.sin(8 * math.pi * time) + 0.1 * np.cos(24 * math.pi * time))
    record = fr.ForceRecord(time, force)
    one = fr.simulate(TUBING, record, duration=0.2, frames=21)
    other = fr.simulate(TUBING, record.load, duration=0.2, frames=21)
    assert one == other
    assert one.problem.load == record.load
    between = 0.5 * (one.time[1:] + one.time[:-1])
    expected = np.interp(between, time, force)
    assert np.abs(one.end_forces[1:] - expected[:, None]).max() < 0.01 * PUSH


@pytest.mark.parametrize(("rod", "load", "ends"), BALANCED[3:6])
def test_resumes_saves_and_loads_to_the_bit(rod: fr.Rod, load: Any, ends: dict[str, float], tmp_path: Path) -> None:
    problem = fr.SimulationProblem(rod, load, duration=0.2, frames=21, friction=0.1, perturbation=KICKED, **ends)
    path, whole = tmp_path / "run.ckpt", problem.run()
    assert not problem.run(checkpoint=path, progress=Stop(7)).complete
    resumed = problem.run(checkpoint=path)
    assert resumed == whole
    assert resumed.end_forces.tobytes() == whole.end_forces.tobytes()
    assert fr.Simulation.load(whole.save(tmp_path / "run.npz")) == whole
    assert fr.SimulationProblem.from_dict(problem.as_dict()) == problem


def test_a_simulation_of_an_older_format_is_refused(tmp_path: Path) -> None:
    path = fr.simulate(TUBING, wave("held"), duration=0.01, frames=3).save(tmp_path / "run.npz")
    meta, arrays = unpacked(path)
    assert meta["format"] == "floquetrod simulation 4"
    sealed_files.write_npz(path, {**meta, "format": "floquetrod simulation 3"}, arrays, compress=True)
    with pytest.raises(ValueError, match="its format is 'floquetrod simulation 3'"):
        fr.Simulation.load(path)


def test_segments_resolve_what_the_load_excites() -> None:
    every = problems._SEGMENTS_IN_HALF_WAVE

    def segments(rod: fr.Rod, load: Any, **others: Any) -> int:
        return fr.SimulationProblem(rod, load, duration=0.1, **others).segments

    nitinol = fr.Rod.nitinol()
    calm = fr.AxialLoad(0.2 * nitinol.critical_force, 0.2 * nitinol.critical_force, 1.0)
    assert segments(nitinol, calm) == math.ceil(every * nitinol.critical_mode)
    assert segments(nitinol, calm, perturbation=fr.Perturbation.modes({11: 0.1})) == 11 * every
    pushed = fr.AxialLoad(4.0 * nitinol.critical_force, 0.0, 1.0)
    assert segments(nitinol, pushed) == math.ceil(every * 2.0 * nitinol.critical_mode)
    # Free motion at half the frequency: omega^2 / 4 = pendulum^2 + (EI / m) k^4.
    fast = dataclasses.replace(calm, frequency=400.0)
    stiffness = nitinol.flexural_rigidity / nitinol.mass_per_length
    wavenumber = ((200.0**2 - nitinol.pendulum_frequency**2) / stiffness) ** 0.25
    assert segments(nitinol, fast) == math.ceil(every * wavenumber * nitinol.length / math.pi)
    assert segments(nitinol, fast, segments=100) == 100
    short = fr.Rod(68e9, 6500.0, radius=0.8e-3, length=0.02, channel_radius=4.7e-3)
    assert segments(short, steady(0.0)) == 25  # none shorter than the radius
    assert segments(short.replace(length=0.2), steady(0.0)) == 5 * every  # of a short rod


@pytest.mark.parametrize(
    ("load", "changes", "message"),
    [
        (steady(1.0), {"feed_speed": -1.0}, "feed_speed must be zero or more"),
        (steady(1.0), {"feed_speed": math.nan}, "feed_speed must be finite"),
        (wave("held"), {"feed_speed": 0.1}, "feed_speed must not be given with a vibration of the upper end"),
        (wave("free"), {"feed_speed": 0.1}, "feed_speed must not be given with a vibration of the upper end"),
        (wave("held"), {"far_force": 1.0}, "far_force must not be given with a lower end that is held"),
        (steady(1.0), {"far_force": math.inf}, "far_force must be finite"),
        (steady(1.0), {"far_force": 1e9}, "load strains the rod by"),
        (steady(1e9), {}, "load strains the rod by"),
        (fr.AxialLoad(1.0, 1.0, 9.0, waveform=(1.0,) * 101), {}, "load must have at most 100 harmonics"),
        (steady(1.0), {"segments": 7}, "segments must be 8 or more"),
    ],
)
def test_refuses_ends_that_cannot_be(load: Any, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.SimulationProblem(TUBING, load, duration=0.1, **changes)


@pytest.mark.parametrize("name", ["feed_speed", "far_force"])
@pytest.mark.parametrize("value", ["one", [1.0], True, 1j, object()])
def test_refuses_what_is_no_number(name: str, value: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=f"{name} must be"):
        fr.SimulationProblem(TUBING, steady(1.0), duration=0.1, **{name: value})
