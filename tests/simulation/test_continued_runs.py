"""Simulations made longer: bit for bit as if asked for at once, through files, interruptions and other arithmetics."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod import cli
from tests.conftest import depth
from tests.seams import Tuned

LOAD = fr.AxialLoad(0.3, 0.3, 150.0)
PATH = fr.WellPath.arc(length=4.0, inclination=(1.2, 1.4), azimuth=(0.4, 0.6))

pytestmark = pytest.mark.filterwarnings(
    "ignore::floquetrod.PlausibilityWarning", "ignore::floquetrod.ResolutionWarning"
)


@st.composite
def problems(draw: st.DrawFn) -> fr.SimulationProblem:
    """Return a short run of a rod that is drawn, with its load, friction and kick."""
    rod = fr.Rod.nitinol().replace(
        ends=draw(st.sampled_from(["hinged", "clamped", "guided"])),
        damping_rate=draw(st.sampled_from([0.0, 2.5])),
        path=draw(st.sampled_from([None, PATH])),
    )
    mean, amplitude = (draw(st.floats(0.0, 1.0)) * rod.critical_force for _ in range(2))
    return fr.SimulationProblem(
        rod,
        fr.AxialLoad(mean, amplitude, draw(st.floats(20.0, 300.0))),
        duration=draw(st.floats(2e-3, 8e-3)),
        frames=draw(st.integers(2, 6)),
        friction=draw(st.sampled_from([0.0, 0.15, ((0.0, 0.1), (1.0, 0.3))])),
        perturbation=fr.Perturbation.random(draw(st.floats(1e-3, 0.1)), seed=draw(st.integers(0, 9))),
        segments=60,
    )


def at_once(problem: fr.SimulationProblem, times: int) -> fr.Simulation:
    """Return the run of so many times the duration, with frames at the same distance."""
    return replace(problem, duration=times * problem.duration, frames=times * (problem.frames - 1) + 1).run()


@given(problems(), st.sampled_from([2, 4]))
@settings(max_examples=depth(100, 6))
def test_a_continued_run_is_the_longer_one_bit_for_bit(problem: fr.SimulationProblem, times: int) -> None:
    run = problem.run()
    longer = at_once(problem, times)
    assert run.continued((times - 1) * problem.duration) == longer
    piece = run
    for _ in range(times - 1):
        piece = piece.continued(problem.duration)
    assert (piece.time.size, piece.ended, piece.problem.frames) == (longer.time.size, "duration", longer.problem.frames)
    assert run.continued(problem.duration) == at_once(problem, 2)


def test_a_file_and_a_pickle_continue_as_the_run_does(tmp_path: Path) -> None:
    run = fr.simulate(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5, friction=0.1)
    saved = fr.Simulation.load(run.save(tmp_path / "run.npz"))
    assert saved == run
    longer = run.continued("10ms")
    assert saved.continued("10ms", checkpoint=tmp_path / "run.ckpt") == longer == at_once(run.problem, 2)
    odd = run.continued(0.0031)  # two frames more, whose step is the run's own
    assert (odd.time.size, odd.time_steps.size) == (7, run.time_steps.size)
    assert fr.Simulation.load(odd.save(tmp_path / "odd.npz")) == odd
    assert (odd.positions[:5] == run.positions).all()


def test_an_interrupted_run_goes_on_to_its_end() -> None:
    def stop(done: int, _: int) -> None:
        if done > 500:
            raise KeyboardInterrupt

    problem = fr.SimulationProblem(fr.Rod.nitinol(), LOAD, duration=0.02, segments=60, frames=3)
    cut = problem.run(stop)
    assert not cut.complete
    assert cut.continued() == problem.run()
    assert cut.continued(problem.duration) == at_once(problem, 2)


@pytest.mark.slow
def test_a_run_that_stopped_early_goes_on() -> None:
    rod = fr.Rod.nitinol()
    problem = fr.SimulationProblem(
        rod,
        fr.AxialLoad(3.0 * rod.critical_force, 0.1 * rod.critical_force, 150.0),
        duration=0.5,
        frames=101,
        segments=84,
        perturbation=fr.Perturbation.modes({8: 0.1}),
        stop_early=True,
    )
    run = problem.run()
    assert run.ended == "buckled"
    assert run.continued() == replace(problem, stop_early=False).run()


def test_what_cannot_be_continued_is_refused(tuned: Tuned) -> None:
    run = fr.simulate(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5)
    with pytest.raises(ValueError, match=r"^duration must be positive for a run that is complete, got 0 s; give"):
        run.continued()
    with pytest.raises(ValueError, match=r"^duration must be .*, got -1"):
        run.continued(-1.0)
    with pytest.raises(ValueError, match="has no last state to continue from"):
        replace(run, last_state=None).continued(1.0)
    state = run.last_state
    assert state is not None
    before = state.before.copy()
    before[8 * 3] ^= 1
    with pytest.raises(ValueError, match=r"cannot be continued bit for bit here: its last .* come out otherwise"):
        replace(run, last_state=state._replace(before=before)).continued(1.0)
    tuned(arithmetic_of_checkpoints=lambda: {**state.arithmetic, "numba": "0.1"})
    with pytest.raises(ValueError, match=r"cannot be continued bit for bit here: it was computed with numba "):
        run.continued(1.0)


def test_the_terminal_continues_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = fr.simulate(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5)
    first, second = run.save(tmp_path / "run.npz"), tmp_path / "longer.npz"
    line = ["simulate", "--continue", str(first), "--no-theory"]
    assert cli.main([*line, "--duration", "10ms", "--out", str(second), "--json"]) == 0
    answer: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert (answer["simulated_s"], answer["frames"]) == (0.02, 9)
    assert fr.Simulation.load(second) == run.continued(0.01)
    for words, message in (
        ([], "--continue needs --duration, the time to add, because the run is complete"),
        (["--duration", "1s", "--mean", "3N"], "--mean must be left out with --continue, whose file has it, got '3N'"),
        (["--duration", "1s", "--rod", "nitinol"], "--rod not allowed with argument --continue"),
    ):
        assert cli.main([*line, *words]) == 2
        assert message in capsys.readouterr().err
