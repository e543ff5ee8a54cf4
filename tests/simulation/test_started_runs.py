"""Simulations that start from the last state of another one: the same motion, other loads, what becomes of the rod."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod import cli
from tests.conftest import depth
from tests.simulation.test_continued_runs import PATH, problems

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force
BUCKLES = fr.AxialLoad(0.825 * FORCE, 0.7 * FORCE, 150.0)
CALM = fr.AxialLoad(0.3 * FORCE, 0.05 * FORCE, 85.0)
TOOL = fr.VibrationTool(0.1, 700.0, 1.0)

pytestmark = pytest.mark.filterwarnings(
    "ignore::floquetrod.PlausibilityWarning", "ignore::floquetrod.ResolutionWarning"
)


@pytest.fixture(scope="module")
def buckled() -> fr.Simulation:
    """Return a run that has buckled."""
    kick = fr.Perturbation.random(1e-2, seed=3)
    run = fr.simulate(ROD, BUCKLES, duration=0.8, frames=161, segments=60, perturbation=kick)
    assert run.buckled
    return run


def require_the_rest_of(longer: fr.Simulation, later: fr.Simulation) -> None:
    """Fail unless a run is the later part of a longer one, bit for bit."""
    begin = longer.time.size - later.time.size
    for name in ("time", "positions", "velocities"):
        np.testing.assert_array_equal(getattr(later, name), getattr(longer, name)[begin:])
    np.testing.assert_array_equal(later.end_forces[1:], longer.end_forces[begin + 1 :])
    for name, values in later.energy.items():
        np.testing.assert_array_equal(values, longer.energy[name][begin:])


@pytest.mark.slow
@given(problems(), st.sampled_from([None, TOOL]))
@settings(max_examples=depth(100, 5))
def test_under_the_same_load_it_is_the_run_continued_bit_for_bit(
    problem: fr.SimulationProblem, tool: fr.VibrationTool | None
) -> None:
    problem = replace(problem, tool=tool)
    run = problem.run()
    later = problem.replace(start=run).run()
    require_the_rest_of(run.continued(problem.duration), later)
    last = problem.replace(start=later).run()
    require_the_rest_of(run.continued(problem.duration).continued(problem.duration), last)
    longer = run.continued(3 * problem.duration)  # the step of the run, which may differ in the last digit
    frames = longer.time.size - run.time.size + 1
    require_the_rest_of(longer, replace(problem, start=run, duration=3 * problem.duration, frames=frames).run())


@given(st.floats(20.0, 400.0), st.floats(0.1, 1.0), st.integers(20, 40))
@settings(max_examples=depth(50, 4))
def test_time_goes_on_and_with_it_the_phase_of_any_load(frequency: float, amplitude: float, frames: int) -> None:
    run = fr.simulate(ROD, BUCKLES, duration=0.0123, frames=4, segments=60)
    load = fr.AxialLoad(0.2 * FORCE, amplitude * FORCE, frequency)
    later = fr.simulate(ROD, load, duration=0.02, frames=frames, start=run)
    assert later.time_steps.size != run.time_steps.size
    assert (later.time[0], later.problem.segments) == (pytest.approx(run.time[-1], rel=1e-12), 60)
    phase = np.cos(frequency * later.time)  # the load is a sine
    mean = load.mean - load.amplitude * np.diff(phase) / (frequency * np.diff(later.time))
    np.testing.assert_allclose(later.end_forces[1:, 0], mean, atol=1e-5 * FORCE)
    np.testing.assert_allclose(later.positions[0], run.positions[-1], atol=1e-12)
    np.testing.assert_array_equal(later.velocities[0], run.velocities[-1])
    stored = later.energy["kinetic"] + later.energy["stretch"]
    assert np.abs(later.energy_error).max() < 0.02 * stored.max()  # waves as short as segments, which a step excites


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.1, pytest.param(0.0, marks=pytest.mark.slow)])
def test_a_buckled_rod_is_said_to_be_so_until_it_is_at_rest(buckled: fr.Simulation, friction: float) -> None:
    """Under a load that makes nothing grow, with damping: large, then dying out, then within 5 degrees."""
    rod = ROD.replace(damping_rate=3.0)
    assert rod.stability(CALM).status == "stable"
    kinds = []
    run = buckled
    for _ in range(6):
        run = fr.simulate(rod, CALM, duration=0.2, frames=41, friction=friction, start=run)
        kinds.append(run.outcome.kind)
        angle = math.degrees(run.outcome.angle)
        assert (angle <= 5.0) == (run.outcome.kind == "quiet")
        assert run.buckled == (run.outcome.kind == "buckled")
        if run.outcome.kind == "dying out":
            assert "not buckled" not in run.outcome.words
            assert f"dying out at {angle:.3g} degrees, from " in str(run.report())
    assert "dying out" in kinds
    assert kinds == sorted(kinds, key=["buckled", "dying out", "quiet"].index)
    assert kinds[-1] == "quiet"


@pytest.mark.slow
def test_what_is_said_of_a_run_is_what_comes_of_the_rod(buckled: fr.Simulation, rng: np.random.Generator) -> None:
    """Of loads that are drawn: what is dying out comes to rest, what stays large was buckled all the time.

    Seldom, of 132 drawn four times, does a vibrating load keep some motion up beside a stable rest: see below.
    """
    dying, kept_up = 0, 0
    for _ in range(depth(40, 2)):
        rod = ROD.replace(damping_rate=float(rng.choice([0.0, 1.0, 4.0])))
        load = fr.AxialLoad(rng.uniform(0.0, 0.9) * FORCE, rng.uniform(0.0, 0.8) * FORCE, rng.uniform(80.0, 200.0))
        options = {"friction": float(rng.choice([0.0, 0.0, 0.1])), "frames": 81}
        runs = [fr.simulate(rod, load, duration=time, start=buckled, **options) for time in (0.05, 0.2, 0.6)]
        last = fr.simulate(rod, load, duration=2.5, start=runs[-1], **options)
        kinds = [run.outcome.kind for run in runs]
        assert all(kind == "quiet" for kind, run in zip(kinds, runs, strict=True) if run.outcome.angle <= 0.087)
        assert set(kinds) <= {"buckled", "dying out", "quiet", "at rest"}
        if "dying out" in kinds:
            dying, kept_up = dying + 1, kept_up + last.buckled
            if last.buckled:
                assert rod.stability(load).status == "stable"
                require_a_motion_kept_up(last)
        if options["friction"] == rod.damping_rate == 0.0 and "quiet" not in kinds:
            assert last.buckled
    assert kept_up <= 1 + 0.2 * dying


def require_a_motion_kept_up(run: fr.Simulation) -> None:
    """Fail unless the load of a run keeps its motion up: it goes on as large, and ends without the vibration."""
    later = fr.simulate(run.problem.rod, run.problem.load, duration=2.5, frames=201, start=run)
    sizes = [np.sqrt(np.mean(part**2)) for part in np.array_split(later.angle, 2)]
    assert sizes[1] == pytest.approx(sizes[0], rel=0.1)
    still = replace(run.problem.load, amplitude=0.0)
    assert not fr.simulate(run.problem.rod, still, duration=2.5, frames=201, start=run).buckled


@pytest.mark.slow
def test_motion_that_is_dying_out_may_approach_one_that_is_kept_up(buckled: fr.Simulation) -> None:
    """Rest is stable, and the motion shrinks to 18 degrees within 0.6 s: then the load takes it up to 38 degrees."""
    rod, load = ROD.replace(damping_rate=1.0), fr.AxialLoad(0.164127 * FORCE, 0.237973 * FORCE, 162.38727)
    assert rod.stability(load).status == "stable"
    first = fr.simulate(rod, load, duration=0.6, frames=81, start=buckled)
    assert first.outcome.kind == "dying out"
    assert "unless the load keeps it up: simulate longer" in str(first.findings(theory=False).report())
    last = fr.simulate(rod, load, duration=2.5, frames=201, start=first)
    assert last.buckled
    assert math.degrees(last.outcome.angle) == pytest.approx(38.3, abs=1.0)
    require_a_motion_kept_up(last)


def test_without_damping_a_buckled_rod_goes_on_under_a_stable_load(buckled: fr.Simulation) -> None:
    run = fr.simulate(ROD, CALM, duration=0.4, frames=81, start=buckled)
    assert run.buckled
    assert run.buckled_at == run.time[0] == buckled.time[-1]
    assert "the motion that another run left it with" in str(run.findings().report())


def test_a_rod_at_rest_against_friction_is_measured_from_the_floor() -> None:
    still = fr.AxialLoad(0.0, 0.0, 150.0)
    kick = fr.Perturbation.random(0.16, seed=2)
    run = fr.simulate(ROD, still, duration=0.4, frames=101, segments=60, friction=0.4, perturbation=kick)
    assert run.outcome.kind == "at rest"
    later = fr.simulate(ROD, still, duration=0.1, frames=26, friction=0.4, start=run)
    assert later.outcome.kind == "at rest"
    assert later.outcome.angle == pytest.approx(run.outcome.angle, rel=0.05)
    freed = fr.simulate(ROD, still, duration=0.2, frames=51, start=run)
    assert freed.largest_angle[-25:].max() > math.radians(4.0)
    assert freed.energy["dissipated_friction"][-1] == freed.energy["dissipated_friction"][0] > 0.0


@pytest.mark.slow
def test_growth_after_a_stable_load_is_that_without_it() -> None:
    kick = fr.Perturbation.modes({7: 1e-4})
    rod = ROD.replace(damping_rate=0.3)
    grows = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
    quiet = grows.with_numbers(grows.mean, 0.02 * FORCE, 150.0)
    assert rod.stability(quiet).status == "stable"
    first = fr.simulate(rod, quiet, duration=0.3, frames=61, segments=60, perturbation=kick)
    assert not first.buckled
    later = fr.simulate(rod, grows, duration=1.0, start=first)
    alone = fr.simulate(rod, grows, duration=1.0, segments=60, perturbation=kick)
    fit, expected = later.growth_rate(7), alone.growth_rate(7)
    assert fit.rate == pytest.approx(expected.rate, abs=fit.error + expected.error)
    assert fit.start == later.time[0] == first.time[-1]
    assert later.outcome.kind == alone.outcome.kind == "quiet"


@pytest.mark.slow
def test_growth_of_a_run_that_begins_large_is_refused_in_a_sentence(buckled: fr.Simulation) -> None:
    for load in (CALM, fr.AxialWave(CALM.mean, CALM.amplitude, CALM.frequency)):
        run = fr.simulate(ROD, load, duration=0.2, start=buckled)
        with pytest.raises(ValueError, match=r"^growth_rate needs three forcing periods"):
            run.growth_rate()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rod": ROD.replace(length=3.0)}, "must be a run of the same rod, got one with length 3.1, not 3.0; load"),
        ({"rod": ROD.replace(ends="clamped")}, "same rod, got one with ends 'hinged', not 'clamped'"),
        (
            {"rod": ROD.replace(radius=0.7e-3, density=7e3)},
            "with density 6500.0, not 7000.0, radius 0.0008, not 0.0007",
        ),
        ({"rod": ROD.replace(path=PATH)}, "another path"),
        ({"segments": 61}, "must be a run with the same options, got one with segments 60, not 61;"),
        ({"indentation": 1e-3}, "got one with indentation 0.0001, not 0.001;"),
    ],
)
def test_another_rod_is_refused(buckled: fr.Simulation, changes: dict[str, Any], message: str) -> None:
    options = {"rod": ROD, "load": CALM, "start": buckled, **changes}
    with pytest.raises(ValueError, match=r"^start must be a run (of|with) the same ") as refused:
        fr.simulate(**options)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_what_a_start_cannot_be_is_refused(buckled: fr.Simulation, tmp_path: Path) -> None:
    def refused(start: Any, **options: Any) -> str:
        with pytest.raises((ValueError, TypeError)) as error:
            fr.simulate(ROD, CALM, start=start, **options)
        return str(error.value)

    assert "start must be a Simulation, or the path of its npz file, got 3" in refused(3)
    assert "there is no such file" in refused(tmp_path / "none.npz")
    assert "start has no last state" in refused(replace(buckled, last_state=None))
    assert buckled.last_state is not None
    old = buckled.last_state._replace(arithmetic={"simulator": "3"})
    assert "start holds a state of version 3 of the simulator" in refused(replace(buckled, last_state=old))
    assert "perturbation must be left out with start" in refused(buckled, perturbation=fr.Perturbation.random(1.0, 1))


def test_damping_gravity_and_forces_may_differ(buckled: fr.Simulation) -> None:
    rod = ROD.replace(damping_rate=2.0, gravity=1.6)
    wave = fr.AxialWave(0.1 * FORCE, 0.1 * FORCE, 90.0, far_end="held")
    for load, options in (
        (CALM, {"feed_speed": 1e-3}),
        (wave, {}),
        (CALM, {"far_force": 0.1}),
        (CALM, {"tool": TOOL, "friction": ((0.0, 0.1), (1.0, 0.3))}),
    ):
        run = fr.simulate(rod, load, duration=0.02, frames=5, start=buckled, **options)
        assert np.abs(run.energy_error).max() < 1e-3 * np.ptp(run.energy["kinetic"])


@pytest.mark.slow
def test_in_a_well_rest_is_where_the_new_load_presses_it(tmp_path: Path) -> None:
    """A pull lifts the rod in the bend; the later run rests where its own load lays it."""
    path = fr.WellPath.arc(length=4.0, inclination=(1.2, 1.4), azimuth=(0.0, 0.15))
    rod = ROD.replace(path=path, damping_rate=20.0, ends="clamped")
    still = {"duration": 0.3, "frames": 41, "segments": 80}
    pulled = fr.simulate(rod, fr.AxialLoad(-0.5, 0.0, 1.0), perturbation=fr.Perturbation(), **still)
    pushed = fr.AxialLoad(0.5, 0.0, 1.0)
    alone = fr.simulate(rod, pushed, perturbation=fr.Perturbation(), **still)
    shift = np.abs(np.degrees(pulled.angle[-1] - alone.angle[-1])).max()
    assert shift > 10.0
    later = fr.simulate(rod, pushed, start=pulled.save(tmp_path / "pulled.npz"), **still)
    assert later.outcome.kind == "quiet"
    assert later.outcome.angle < math.radians(1.0)


@pytest.mark.slow
def test_early_ends_count_from_the_state(buckled: fr.Simulation) -> None:
    run = fr.simulate(ROD, BUCKLES, duration=0.1, frames=11, start=buckled, stop_early=True)
    assert (run.ended, run.buckled) == ("duration", True)
    rod = ROD.replace(damping_rate=3.0)
    rest = fr.simulate(
        rod, CALM.with_numbers(0.0, 0.0, 85.0), duration=3.0, start=buckled, friction=0.1, stop_early=True
    )
    assert rest.ended == "at rest"
    assert rest.time[-1] < 3.0


def test_files_interruptions_and_checkpoints(buckled: fr.Simulation, tmp_path: Path) -> None:
    def stop(done: int, _: int) -> None:
        if done > 1500:
            raise KeyboardInterrupt

    problem = fr.SimulationProblem(ROD, CALM, duration=0.1, frames=5, friction=0.1, start=buckled)
    whole = problem.run()
    assert fr.SimulationProblem(ROD, CALM, duration=0.1, frames=5, friction=0.1, start=problem.start) == problem
    assert fr.Simulation.load(whole.save(tmp_path / "whole.npz")) == whole
    file = tmp_path / "run.ckpt"
    cut = problem.run(stop, file)
    assert not cut.complete
    assert "INTERRUPTED at 0.025 s of 0.1 s" in str(cut.report())
    assert cut.continued() == problem.run(checkpoint=file) == whole
    with pytest.raises(ValueError, match=r"belongs to another run, with another .*start"):
        problem.replace(start=whole).run(checkpoint=file)
    assert fr.Simulation.load(whole.save(tmp_path / "whole.npz")).continued(0.1) == whole.continued(0.1)


@pytest.mark.slow
def test_an_ensemble_starts_from_a_state(buckled: fr.Simulation) -> None:
    problem = fr.SimulationProblem(ROD, CALM, duration=0.05, frames=11, start=buckled)
    means = [0.1 * FORCE, 0.4 * FORCE]
    runs = fr.ensemble(problem, {"mean": means})
    alone = [fr.simulate(ROD, replace(CALM, mean=mean), duration=0.05, frames=11, start=buckled) for mean in means]
    assert runs.angle_in_the_end.values.tolist() == [run.outcome.angle for run in alone]
    with pytest.raises(ValueError, match="perturbation must be left out with start"):
        fr.ensemble(problem, {"kick": [0.1, 0.2]})


def test_the_terminal_starts_from_a_file(
    buckled: fr.Simulation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first, second = buckled.save(tmp_path / "run.npz"), tmp_path / "later.npz"
    line = ["simulate", "--start", str(first), "--rod", "nitinol", "--mean", "0.3Fcr", "--amplitude", "0.05Fcr"]
    line += ["--frequency", "85rad/s", "--damping-rate", "3", "--mu", "0.1", "--duration", "0.2s"]
    assert cli.main([*line, "--out", str(second), "--json", "--frames", "41"]) == 0
    answer: dict[str, Any] = json.loads(capsys.readouterr().out)
    run = fr.simulate(ROD.replace(damping_rate=3.0), CALM, duration=0.2, friction=0.1, frames=41, start=first)
    assert fr.Simulation.load(second) == run
    assert (answer["outcome"], answer["simulated_s"]) == (run.outcome.kind, pytest.approx(0.2))
    assert answer["start_s"] == buckled.time[-1]
    for words, message in (
        (["--kick", "8:50mm/s"], "--kick must be left out with --start, whose rod is moving already"),
        (["--seed", "2"], "--seed must be left out with --start"),
        (["--length", "3m"], "--start must be a run of the same rod, got one with length 3.1, not 3.0"),
        (["--segments", "70"], "--start must be a run with the same options, got one with segments 60, not 70"),
    ):
        assert cli.main([*line, *words]) == 2
        assert message in capsys.readouterr().err
    assert cli.main(["simulate", "--continue", str(first), "--start", str(first), "--duration", "1s"]) == 2
    assert "--start must be left out with --continue" in capsys.readouterr().err
