"""`fr.SimulationProblem`: a value that is checked, replaced, pickled and run, here or in another process."""

from __future__ import annotations

import dataclasses
import inspect
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

import floquetrod as fr
from floquetrod._util import sealed_files
from floquetrod.simulation.step_size import TimeSteps
from tests.damages import unpacked

ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)
PROBLEM = fr.SimulationProblem(ROD, LOAD, duration=0.01, friction=0.1, segments=60, frames=5)
OPTIONS = [part.name for part in dataclasses.fields(PROBLEM) if part.kw_only]


def test_it_holds_what_was_asked_for_cleaned() -> None:
    problem = fr.SimulationProblem(ROD, LOAD, duration=1, friction=0)
    assert problem.perturbation == fr.Perturbation.random(1e-3, seed=1)
    assert problem == fr.SimulationProblem(ROD, LOAD, duration=1.0, perturbation=problem.perturbation)
    assert (type(problem.duration), type(problem.friction), problem.time_step) == (float, float, None)
    with pytest.raises(dataclasses.FrozenInstanceError):
        problem.duration = 2.0  # type: ignore[misc]


def test_what_follows_from_it_is_computed_anew_when_it_is_replaced() -> None:
    steps = PROBLEM.time_steps
    assert (steps.count, steps.frames, steps.limit) == (4 * steps.per_frame, 5, "stretch")
    assert steps.size == 0.01 / steps.count
    assert PROBLEM.replace(duration=0.02).time_steps.count == pytest.approx(2 * steps.count, abs=8)
    finer = dataclasses.replace(PROBLEM, segments=120)
    assert (finer.mesh.segments, finer.time_steps.count) == (120, pytest.approx(2 * steps.count, rel=0.1))
    small = PROBLEM.replace(time_step=1.5e-6)  # which 2.5 ms between frames hold 1666.7 times
    assert small.time_steps == TimeSteps.between_frames(0.01, 5, 1667, "choice")
    assert small.time_step == 1.5e-6
    with pytest.raises(ValueError, match="time_step must be at most"):
        PROBLEM.replace(time_step=1e-4)


def test_simulate_runs_the_problem_it_is_given_the_options_of() -> None:
    options = {name: getattr(PROBLEM, name) for name in OPTIONS}
    result = fr.simulate(ROD, LOAD, **options)
    assert result == PROBLEM.run()
    assert result.problem == PROBLEM
    assert result.time_steps == PROBLEM.time_steps


def test_simulate_names_its_options() -> None:
    signature = inspect.signature(fr.simulate)
    assert list(signature.parameters) == ["rod", "load", *OPTIONS, "progress", "checkpoint"]
    for name in OPTIONS:
        assert signature.parameters[name].kind is inspect.Parameter.KEYWORD_ONLY
        assert signature.parameters[name].default == inspect.signature(fr.SimulationProblem).parameters[name].default
    assert not hasattr(fr.simulate, "__signature__")
    with pytest.raises(TypeError, match="unexpected keyword argument 'frictoin'"):
        fr.simulate(ROD, LOAD, frictoin=0.1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="positional"):
        fr.simulate(ROD, LOAD, 0.3)  # type: ignore[misc]


def test_a_pickled_problem_holds_its_parameters_alone() -> None:
    twin = pickle.loads(pickle.dumps(PROBLEM))
    assert twin == PROBLEM
    assert set(vars(twin)) == {"rod", "load", *OPTIONS}
    assert twin.time_steps == PROBLEM.time_steps


@pytest.mark.slow
def test_another_process_makes_the_same_simulation() -> None:
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(PROBLEM.run)
        here = PROBLEM.run()
        assert there.result() == here
        assert there.result().positions.tobytes() == here.positions.tobytes()


def test_plain_data_makes_the_problem_again() -> None:
    assert fr.SimulationProblem.from_dict(PROBLEM.as_dict()) == PROBLEM
    for changes in ({"frames": 5.0}, {"duration": "1"}, {"friction": -1.0}, {"extra": 1}):
        with pytest.raises((TypeError, ValueError)):
            fr.SimulationProblem.from_dict(PROBLEM.as_dict() | changes)


def test_a_file_tells_the_steps_that_were_taken(tmp_path: Path) -> None:
    """Another version may take other steps for the same problem; what it made stays readable, and says so."""
    path = PROBLEM.run().save(tmp_path / "run.npz")
    meta, arrays = unpacked(path)
    sealed_files.write_npz(path, {**meta, "steps_per_frame": 1000, "step_size": 0.01 / 4000}, arrays, compress=True)
    assert fr.Simulation.load(path).time_steps == TimeSteps.between_frames(0.01, 5, 1000, "stretch")


def test_steps_of_a_duration_with_a_unit() -> None:
    assert TimeSteps.between_frames("10ms", 5, 1000, "stretch") == TimeSteps.between_frames(0.01, 5, 1000, "stretch")
    with pytest.raises(ValueError, match="duration must be"):
        TimeSteps.between_frames("10m", 5, 1000, "stretch")
    with pytest.raises(ValueError, match="duration must be"):
        TimeSteps.between_frames(0.0, 5, 1000, "stretch")


def test_a_checkpoint_of_an_older_format_is_refused_with_a_remedy(tmp_path: Path) -> None:
    path = tmp_path / "run.ckpt"
    PROBLEM.run(checkpoint=path)
    meta, arrays = unpacked(path)
    sealed_files.write_npz(path, {**meta, "format": "floquetrod checkpoint 2"}, arrays, compress=False)
    with pytest.raises(ValueError, match=r"its format is 'floquetrod checkpoint 2'.*; give another path, or remove it"):
        PROBLEM.run(checkpoint=path)


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
def test_default_segments_are_as_many_as_there_may_be() -> None:
    rod, load = fr.Rod.nitinol(), fr.AxialLoad(0.0, 0.0, 10.0)
    for radii in (8.0, 8.9, 10.5, 11.99, 30.01):
        stub = rod.replace(length=radii * rod.radius * (1.0 + 1e-12))
        assert fr.SimulationProblem(stub, load, duration=0.01).segments <= radii
    with pytest.raises(
        ValueError, match="rod cannot be simulated: of 8 segments each would be shorter than its radius"
    ):
        fr.SimulationProblem(rod.replace(length=7.5 * rod.radius), load, duration=0.01)
