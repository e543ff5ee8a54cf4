"""`fr.ensemble`: what is varied, what comes of it, and what is refused."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import floquetrod as fr
from floquetrod._util import waiting
from floquetrod.ensembles import Runs, varied_axes
from floquetrod.ensembles.stores import RESULTS, chunk_shape
from floquetrod.ensembles.variables import Variable
from floquetrod.simulation import outcome
from tests.ensemble_cases import LOAD, OVER, PROBLEM, assert_same, depth, fails_at_150, in_memory, undisturbed
from tests.seams import Heard, Tuned


def test_every_run_is_the_simulation_of_its_values() -> None:
    found = undisturbed(depth, frames=True)
    assert dict(found.sizes) == {"frequency": 2, "kick": 3, "seed": 2, "frame": 5, "node": 61, "axis": 3}
    assert (found.status == 1).all()
    assert (found.reason == "").all()
    one = found.isel(frequency=1, kick=2, seed=0)
    kick = fr.Perturbation.random(1e-3, seed=3)
    kick = fr.Perturbation.random(1e-3 * float(0.1 / np.abs(kick.velocities(60)).max()), seed=3)
    run = PROBLEM.replace(load=fr.AxialLoad(0.3, 0.3, 150.0), perturbation=kick).run()
    assert abs(np.abs(kick.velocities(60)).max() - 0.1) < 1e-15
    assert bool(one.buckled) == run.buckled
    assert run.buckled_at is None
    assert np.isnan(one.time_to_buckle)
    assert outcome.KINDS[int(one.outcome)] == run.outcome.kind == "swinging"
    assert float(one.angle_in_the_end) == run.outcome.angle
    assert int(one.dominant_mode) == run.dominant_mode
    assert float(one.largest_angle) == run.largest_angle.max()
    assert float(one.energy_error) == np.abs(run.energy_error).max()
    assert np.isnan(one.growth_rate)
    assert float(one.depth) == run.positions[:, :, 2].min()
    assert float(one.early) == 0.0
    assert np.array_equal(one.positions, run.positions)
    assert np.array_equal(one.angle, run.angle)
    assert np.array_equal(one.time, run.time)


def test_growth_is_that_of_the_dominant_mode() -> None:
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.2 * rod.critical_force, 0.2 * rod.critical_force, 150.0)
    kick = fr.Perturbation.modes({7: 1e-4})
    problem = fr.SimulationProblem(rod, load, duration=0.3, segments=60, frames=80, perturbation=kick)
    found = fr.ensemble(problem, {"mean": [load.mean], "friction": [0.0, 0.1]})
    growth = problem.run().growth_rate(7)
    assert found.growth_rate.values.tolist()[0][0] == growth.rate
    assert found.growth_error.values.tolist()[0][0] == growth.error
    assert np.isnan(found.growth_rate.values[0, 1])


def test_units_and_meaning_are_attributes() -> None:
    found = fr.ensemble(PROBLEM, {"frequency": [120.0, 150.0]})
    assert found.frequency.attrs == {"long_name": "frequency", "units": "rad/s"}
    assert found.time_to_buckle.attrs["units"] == "s"
    assert found.status.attrs["flag_meanings"] == "pending done failed"
    assert fr.SimulationProblem.from_dict(json.loads(found.attrs["problem"])) == PROBLEM
    assert found.attrs["version"] == fr.__version__
    assert found.attrs["varied"] == ["frequency"]
    assert {v.attrs["units"] for name, v in found.data_vars.items() if name in RESULTS} == {"1", "s", "1/s", "rad", "J"}


def test_all_that_can_be_varied_has_a_unit_that_study_files_know() -> None:
    problem = fr.SimulationProblem(fr.Rod.nitinol(), fr.AxialLoad(1.0, 1.0, 100.0), tool=fr.VibrationTool(1.0, "20Hz"))
    names = {name for known in varied_axes.names_of(problem).values() for name in known}
    assert {*varied_axes.OF_TOOL.values(), "second"} == {part.name for part in fields(fr.VibrationTool)}
    assert names - set(varied_axes.VARIED_KINDS) == {"segments", "frames", "seed"}
    found = {name: varied_axes.VariedAxis(name, name, np.ones(1)).unit for name in names}
    assert found["feed_speed"] == "m/s"
    assert found["far_force"] == found["tool_amplitude"] == "N"
    assert found["curvature"] == "1/m"
    assert found["friction"] == found["seed"] == "1"


def test_names_that_can_be_varied_are_of_one_thing_only() -> None:
    names = varied_axes.names_of(PROBLEM)
    every = [name for known in names.values() for name in known]
    assert len(every) == len(set(every))
    assert {"friction", "duration", "segments"} <= set(names["problem"])
    assert {"mean", "amplitude", "frequency", "mean_at"} == set(names["load"])
    assert not set(every) & ({*RESULTS} | {"reason", "time", "angle", "positions", "run", "sample", "frame", "node"})


@pytest.mark.parametrize("name", [name for names in varied_axes.names_of(PROBLEM).values() for name in names])
def test_every_name_reaches_the_problem(name: str) -> None:
    values = {
        "segments": 66,
        "frames": 6,
        "seed": 5,
        "inclination": 1.5,
        "inner_radius": 1e-4,
        "inner_diameter": 2e-4,
        "wall_thickness": 1e-4,
    }
    known = next(filter(None, (getattr(part, name, None) for part in (PROBLEM, PROBLEM.rod, LOAD))), 0.01)
    value = values.get(name, 1e-5 if name == "time_step" else 0.9 * known)
    if name == "diameter" or name == "channel_diameter":
        value = 1.8 * getattr(PROBLEM.rod, name.replace("diameter", "radius"))
    instead = {"wall_thickness": "inner_radius", "weight": "density"}
    held = instead.get(name, name.replace("diameter", "radius"))
    refused = ""
    try:
        made = varied_axes.varied(PROBLEM, {name: value})
    except ValueError as error:  # of a rod that cannot be simulated
        refused = str(error)
    if refused:
        assert held in refused
        return
    assert made != PROBLEM
    if name not in varied_axes.START:
        plain = {"diameter": 0.5, "channel_diameter": 0.5, "inner_diameter": 0.5}.get(name, 1.0) * value
        plain = PROBLEM.rod.radius - value if name == "wall_thickness" else plain
        if name == "weight":
            plain = value / (9.80665 * np.pi * PROBLEM.rod.radius**2)
        got = next(getattr(part, held) for part in (made, made.load, made.rod) if hasattr(part, held))
        assert got == (pytest.approx(plain, rel=1e-14) if name == "weight" else plain)


def test_several_noises_stay_independent() -> None:
    problem = PROBLEM.replace(perturbation=fr.Perturbation(((3, 1e-3),), ((1e-3, 1), (2e-3, 2))))
    made = varied_axes.varied(problem, {"seed": 9, "kick": 0.02}).perturbation
    assert made.noises[0][1] == 9
    assert made.noises[1][1] not in (2, 9)
    assert np.abs(made.velocities(60)).max() == pytest.approx(0.02)
    assert made.speeds[0][1] / made.noises[0][0] == pytest.approx(1.0)


def test_a_list_takes_columns_together() -> None:
    over = {"radius": [3.6e-4, 4e-4], "channel_radius": [6e-3, 7e-3], "seed": [3, 4]}
    found = fr.ensemble(PROBLEM, over, layout="list")
    assert dict(found.sizes) == {"run": 2}
    assert found.radius.dims == ("run",)
    rod = PROBLEM.rod.replace(radius=4e-4, channel_radius=7e-3)
    run = PROBLEM.replace(rod=rod, perturbation=fr.Perturbation.random(1e-3, 4)).run()
    assert float(found.largest_angle[1]) == run.largest_angle.max()


def test_drawn_values_share_a_dimension() -> None:
    over = {"frequency": [120.0, 150.0], "friction": stats.uniform(0.1, 0.1), "seed": stats.randint(0, 1000)}
    found = fr.ensemble(PROBLEM, over, samples=4, seed=3)
    assert dict(found.sizes) == {"frequency": 2, "sample": 4}
    assert ((found.friction >= 0.1) & (found.friction <= 0.2)).all()
    assert found.seed.dtype.kind == "i"
    again = fr.ensemble(PROBLEM, over, samples=4, seed=3)
    assert_same(found, again)
    assert (fr.ensemble(PROBLEM, over, samples=4, seed=4).friction != found.friction).all()
    alone = fr.ensemble(PROBLEM, {"kick": [0.1, 0.2], "friction": stats.uniform(0.1, 0.1)}, layout="list")
    assert alone.friction.dims == ("run",)


def raising(run: Callable[..., fr.Simulation]) -> Callable[..., fr.Simulation]:
    """Return a method that raises what a run may, for two kinds of friction."""

    def wrapped(problem: fr.SimulationProblem, *arguments: Any) -> fr.Simulation:
        if problem.friction == 0.2:
            raise fr.SimulationDiverged("torn", None)
        if problem.friction == 0.3:
            raise MemoryError
        return run(problem, *arguments)

    return wrapped


def test_failures_are_recorded_and_stop_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    found = fr.ensemble(PROBLEM, {"friction": [0.1, -1.0, 0.2]})
    assert found.status.values.tolist() == [1, 2, 1]
    assert "friction must be zero or more" in str(found.reason.values[1])
    assert np.isnan(found.largest_angle.values[1])
    with monkeypatch.context() as patched:
        patched.setattr(fr.SimulationProblem, "_run", raising(fr.SimulationProblem._run))
        torn = fr.ensemble(PROBLEM, {"friction": [0.1, 0.2, 0.3]})
    assert torn.status.values.tolist() == [1, 2, 2]
    assert torn.reason.values.tolist() == ["", "SimulationDiverged: torn", "MemoryError: "]
    later = fr.ensemble(PROBLEM, {"frequency": [120.0, 150.0, 160.0]}, summary=fails_at_150)
    assert later.status.values.tolist() == [1, 2, 1]
    assert str(later.reason.values[1]) == "ArithmeticError: this summary knows no 150 rad/s"
    ragged = fr.ensemble(PROBLEM, {"segments": [60, 66]}, frames=True)
    assert ragged.status.values.tolist() == [1, 2]


@pytest.mark.slow
def test_parts_are_disjoint_and_make_the_whole() -> None:
    whole = undisturbed()
    status = np.zeros(whole.status.shape, dtype=int)
    for k in range(1, 8):
        found = fr.ensemble(PROBLEM, OVER, part=(k, 7))
        status += found.status.values
        done = found.status.values == 1
        assert np.array_equal(found.largest_angle.values[done], whole.largest_angle.values[done])
    assert (status == 1).all()


@pytest.mark.parametrize("shape", [(1,), (7,), (300,), (2, 3, 100), (5, 1, 3), (40, 1000), (1000, 7, 3), (2, 2, 2, 2)])
@pytest.mark.parametrize("parts", [1, 2, 7, 100])
def test_chunks_are_ranges_of_runs(shape: tuple[int, ...], parts: int) -> None:
    chunk, size = chunk_shape(shape, parts), int(np.prod(shape))
    assert np.prod(chunk) <= min(256, -(-size // parts))
    partial = next((i for i, step in enumerate(chunk) if step > 1), len(chunk) - 1)
    assert chunk[partial + 1 :] == shape[partial + 1 :]
    plan = axes_layout(shape, chunk)
    runs = np.arange(size).reshape(shape)
    for number, start in enumerate(plan.starts):
        corner = np.unravel_index(start, shape)
        block = runs[tuple(slice(at, at + step) for at, step in zip(corner, chunk, strict=True))].ravel()
        assert block.tolist() == list(plan.runs_of(range(number, number + 1)))
    shares = [plan.runs_of(plan.part((k, parts))) for k in range(1, parts + 1)]
    assert [run for share in shares for run in share] == list(range(size))


def axes_layout(shape: tuple[int, ...], chunk: tuple[int, ...]) -> Any:
    from floquetrod.ensembles.stores import StoreLayout

    names = ("mean", "amplitude", "frequency", "friction")
    axis = tuple(varied_axes.VariedAxis(n, n, np.arange(length)) for n, length in zip(names, shape, strict=False))
    return StoreLayout(varied_axes.Design(PROBLEM, axis), (), False, chunk)


@pytest.mark.parametrize("is_shown", [True, False])
def test_a_terminal_shows_how_far_it_is(is_shown: bool, tuned: Tuned, heard: Heard) -> None:
    tuned(can_redraw_a_line=lambda: is_shown)
    lines = heard(waiting.Waiting, "__call__")
    fr.ensemble(PROBLEM, {"seed": range(3)})
    assert [done for _, *done in lines] == ([[1, 3], [2, 3], [3, 3]] if is_shown else [])


def test_progress_counts_every_run() -> None:
    seen: list[tuple[int, int]] = []
    fr.ensemble(PROBLEM, {"seed": range(5)}, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(done, 5) for done in range(1, 6)]


def test_a_given_executor_is_used_and_not_shut_down() -> None:
    with ThreadPoolExecutor(1) as pool:
        found = fr.ensemble(PROBLEM, OVER, executor=pool)
        assert pool.submit(int).result() == 0
    assert_same(found, undisturbed())


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"over": 3}, TypeError, "over must map names"),
    ({"over": {}}, ValueError, "over must name at least one"),
    ({"over": {"colour": [1.0]}}, ValueError, "over must name what can be varied, .*'colour'"),
    ({"over": {1: [1.0]}}, ValueError, "over must name what can be varied"),
    ({"over": {"rod": [1.0]}}, ValueError, "over must name what can be varied"),
    ({"over": {"friction": 0.1}}, TypeError, r"over\['friction'\] must be a sequence"),
    ({"over": {"friction": "0.1"}}, TypeError, r"over\['friction'\] must be a sequence"),
    ({"over": {"friction": {0.1}}}, TypeError, r"over\['friction'\] must be a sequence"),
    ({"over": {"friction": ["a"]}}, ValueError, r"over\['friction'\]\[0\] must be a number with no unit"),
    ({"over": {"friction": [None]}}, TypeError, r"over\['friction'\]"),
    ({"over": {"friction": [True]}}, TypeError, r"over\['friction'\] must hold real numbers"),
    ({"over": {"friction": []}}, ValueError, r"over\['friction'\] must have one dimension"),
    ({"over": {"friction": [[0.1]]}}, ValueError, r"over\['friction'\] must have one dimension"),
    ({"over": {"friction": [float("nan")]}}, ValueError, r"over\['friction'\] must be finite"),
    ({"over": {"friction": stats.uniform}}, TypeError, r"over\['friction'\] must be a sequence"),
    ({"over": {"segments": [60.5]}}, TypeError, r"over\['segments'\] must hold integers"),
    ({"over": {"seed": [-1]}}, ValueError, r"over\['seed'\] must lie between 0"),
    ({"over": {"seed": stats.uniform(0, 10)}, "samples": 3}, ValueError, r"over\['seed'\].*integer"),
    ({"over": {"friction": stats.uniform(0, 1)}}, ValueError, "samples must say how often friction"),
    ({"over": {"friction": stats.uniform(0, 1)}, "samples": 0}, ValueError, "samples must be 1 or more"),
    ({"over": {"friction": stats.uniform(0, 1)}, "samples": 2.5}, TypeError, "samples must be an integer"),
    ({"over": {"friction": stats.uniform([0, 1], 1)}, "samples": 2}, TypeError, "distribution of one number"),
    ({"samples": 5}, ValueError, "samples is for distributions"),
    ({"over": {"friction": [-1.0, -2.0]}}, ValueError, "runs that are impossible, .*friction must be zero or more"),
    ({"over": {"friction": [0.1], "mean": [0.1, 0.2]}, "layout": "list"}, ValueError, "friction has 1, mean has 2"),
    ({"over": {"seed": range(4000), "mean": range(4000)}}, ValueError, "16,000,000 runs"),
    ({"layout": "cube"}, ValueError, "layout must be one of"),
    ({"layout": None}, TypeError, "layout must be one of"),
    ({"seed": -1}, ValueError, "seed must be 0 or more"),
    ({"seed": 1.5}, TypeError, "seed must be an integer"),
    ({"executor": 8}, TypeError, "executor must submit tasks as those of concurrent.futures"),
    ({"executor": ThreadPoolExecutor(1), "workers": 2}, ValueError, "workers is a number of own processes"),
    ({"workers": 0}, ValueError, "workers must be 1 or more"),
    ({"workers": "all"}, TypeError, "workers must be an integer"),
    ({"store": 3}, TypeError, "store must be a path"),
    ({"store": ""}, ValueError, "store must name"),
    ({"store": "runs.csv"}, ValueError, r"store must end in .zarr or .npz"),
    ({"store": "no/such/folder/runs.npz"}, ValueError, "there is no folder"),
    ({"store": "no/such/folder/runs.zarr"}, ValueError, "there is no folder"),
    ({"summary": 3}, TypeError, "summary must be a function"),
    ({"summary": lambda run: 3.0}, ValueError, "summary must return numbers .* mapping of names"),
    ({"summary": lambda run: {"a": "b"}}, ValueError, "summary must return numbers"),
    ({"summary": lambda run: {"buckled": 1.0}}, ValueError, "names that are not taken, got 'buckled'"),
    ({"summary": lambda run: {"friction": 1.0}}, ValueError, "names that are not taken, got 'friction'"),
    ({"summary": lambda run: {"a b": 1.0}}, ValueError, "names that are not taken"),
    ({"summary": lambda run: 1 / 0}, ValueError, "summary must return numbers .*division by zero"),
    ({"summary": lambda run: {"a": 1.0}, "workers": 1}, TypeError, "summary must be picklable"),
    ({"frames": "yes"}, TypeError, "frames must be True or False"),
    ({"part": 3}, TypeError, "part must be two integers"),
    ({"part": "12"}, TypeError, "part must be two integers"),
    ({"part": (1 // 0 for _ in range(2))}, TypeError, "part must be two integers"),
    ({"part": (0, 3)}, ValueError, r"part\[0\] must be 1 or more"),
    ({"part": (4, 3)}, ValueError, r"part\[0\] must be at most 3"),
    ({"part": (1, 0)}, ValueError, r"part\[1\] must be 1 or more"),
    ({"part": (1.0, 3)}, TypeError, r"part\[0\] must be an integer"),
    ({"part": (1, 3), "store": "runs.npz"}, ValueError, "part needs a store that many can write"),
    ({"progress": 3}, TypeError, "progress must be a function"),
    ({"problem": PROBLEM.rod}, TypeError, "problem must be a SimulationProblem"),
]


@pytest.mark.parametrize(("changed", "kind", "match"), BAD)
def test_bad_input_is_refused_before_anything_runs(
    changed: dict[str, Any], kind: type[Exception], match: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments: dict[str, Any] = {"problem": PROBLEM, "over": {"friction": [0.1, 0.2]}} | changed
    with pytest.raises(kind, match=match):
        fr.ensemble(**arguments)
    assert not list(tmp_path.iterdir())


def test_a_seed_needs_something_drawn() -> None:
    problem = PROBLEM.replace(perturbation=fr.Perturbation.modes({3: 0.01}))
    with pytest.raises(ValueError, match="over varies the seed, but nothing is random"):
        fr.ensemble(problem, {"seed": [1, 2]})
    still = PROBLEM.replace(perturbation=fr.Perturbation())
    with pytest.raises(ValueError, match="kick scales the perturbation of the problem, which is zero"):
        fr.ensemble(still, {"kick": [0.1]})


def test_without_xarray_runs_are_returned(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with_it = undisturbed()
    for name in ("xarray", "floquetrod.ensembles.accessor"):
        monkeypatch.setitem(sys.modules, name, None)
    found = fr.ensemble(PROBLEM, OVER, store=tmp_path / "runs.npz")
    assert isinstance(found, Runs)
    assert_same(found, with_it)
    assert found.dims == {"frequency": 2, "kick": 3, "seed": 2}
    assert repr(found) == "<12 runs done, 0 failed, 0 pending (frequency: 2, kick: 3, seed: 2)>"
    assert found.units["kick"] == "m/s"
    with pytest.raises(ImportError, match=r"needs xarray: pip install floquetrod\[ensemble\]"):
        fr.ensemble(PROBLEM, OVER, store=tmp_path / "runs.zarr")
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(ImportError, match=r"needs zarr: pip install floquetrod\[ensemble\]"):
        fr.ensemble(PROBLEM, OVER, store=tmp_path / "runs.zarr")


def test_runs_can_be_saved(tmp_path: Path) -> None:
    found = in_memory(fr.ensemble(PROBLEM, {"friction": [0.1, -1.0]}, frames=True))
    again = Runs.load(found.save(tmp_path / "runs.npz"))
    assert again == found
    assert again.to_xarray().identical(found.to_xarray())
    with pytest.raises(KeyError, match="'colour' is none of friction, status"):
        found["colour"]
    content = (tmp_path / "runs.npz").read_bytes()
    (tmp_path / "runs.npz").write_bytes(content[:-200] + bytes([content[-200] ^ 1]) + content[-199:])
    with pytest.raises(ValueError, match="is not an ensemble that can be read"):
        Runs.load(tmp_path / "runs.npz")


def test_exact_numbers_become_the_nearest_double() -> None:
    assert fr.ensemble(PROBLEM, {"friction": [Fraction(1, 3)]}).friction.values[0] == 1 / 3


def test_a_file_of_runs_that_there_is_not(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"none\.npz is not an ensemble that can be read: there is no such file"):
        Runs.load(tmp_path / "none.npz")


def test_probabilities_print_as_a_table() -> None:
    kick = Variable(("kick",), np.array([0.04, 0.08]), {"units": "m/s"})
    dims, even = ("kick", "seed"), np.arange(8).reshape(2, 4) % 2 == 0
    runs = Runs(
        {"status": Variable(dims, np.ones((2, 4), int), {}), "buckled": Variable(dims, even, {})}, {"kick": kick}, {}
    )
    heading, first, _ = str(fr.ensembles.probability(runs, over="seed")).splitlines()
    assert heading.split() == ["kick", "m/s", "probability", "lower", "upper", "done", "failed"]
    assert first.split()[:2] == ["0.04", "0.5"]
    assert str(runs) == repr(runs)
    assert str(Runs({}, {}, {})) == repr(Runs({}, {}, {}))


@pytest.mark.slow
def test_probability_is_that_of_binomial_tests() -> None:
    over = {"kick": [0.01, 0.06, 0.1], "seed": range(12), "length": [PROBLEM.rod.length, -1.0]}
    found = fr.ensemble(PROBLEM, over).isel(length=0)
    found = found.assign(far=found.largest_angle > 0.06)
    answer = found.floquetrod.probability("far", over="seed", confidence=0.9)
    assert answer.probability.dims == ("kick",)
    assert answer.kick.values.tolist() == [0.01, 0.06, 0.1]
    for place in range(3):
        count = int(found.far.isel(kick=place).sum())
        low, high = stats.binomtest(count, 12).proportion_ci(0.9, "exact")
        assert answer.probability.values[place] == pytest.approx(count / 12)
        assert answer.lower.values[place] == pytest.approx(low, rel=1e-12)
        assert answer.upper.values[place] == pytest.approx(high, rel=1e-12)
        assert (answer.done.values[place], answer.failed.values[place]) == (12, 0)
    assert 0.0 < answer.probability.values[1] < 1.0
    counted = {0.0, 1.0} - set(answer.probability.values.tolist())
    assert len(counted) < 2, "no end of the range was met"
    in_numpy = fr.ensembles.probability(in_memory(found), "far", over="seed", confidence=0.9)
    assert np.array_equal(in_numpy["upper"], answer.upper)
    status = Variable(("seed",), np.array([1, 1, 1, 1, 2, 2]), {})
    far = Variable(("seed",), np.array([True, False, True, False, False, False]), {})
    lost = fr.ensembles.probability(Runs({"status": status, "far": far}, {}, {}), "far", over="seed")
    assert float(lost["probability"]) == 0.5
    assert float(lost["lower"]) == pytest.approx(stats.binomtest(2, 6).proportion_ci(0.95, "exact").low)
    assert float(lost["upper"]) == pytest.approx(stats.binomtest(4, 6).proportion_ci(0.95, "exact").high)
    pending = fr.ensemble(PROBLEM, {"seed": range(4)}, part=(1, 2)).floquetrod.probability(over="seed")
    assert int(pending.done) == 2
    nothing = fr.ensembles.probability(
        fr.ensemble(PROBLEM, {"mean": [0.1, 0.2], "seed": [1]}, part=(1, 2)), over="seed"
    )
    assert np.isnan(nothing.probability.values[1])
    assert (nothing.lower.values[1], nothing.upper.values[1]) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("arguments", "kind", "match"),
    [
        ({"name": "colour"}, ValueError, "name must be one of"),
        ({"name": "largest_angle"}, ValueError, "true or false"),
        ({"over": "kick"}, ValueError, "over must name a dimension of these runs, seed, got 'kick'; give over='seed'"),
        ({"over": []}, ValueError, "over must name at least one"),
        ({"over": 3}, TypeError, "over must be a sequence"),
        ({"confidence": 1.0}, ValueError, "confidence must be less than 1"),
        ({"confidence": "95"}, TypeError, "confidence must be a real number"),
        ({"runs": 3}, TypeError, "runs must be what fr.ensemble returns"),
    ],
)
def test_bad_questions_are_refused(arguments: dict[str, Any], kind: type[Exception], match: str) -> None:
    found = fr.ensemble(PROBLEM, {"seed": [1, 2]})
    with pytest.raises(kind, match=match):
        fr.ensembles.probability(**({"runs": found, "name": "buckled", "over": "seed"} | arguments))
