"""Runs that stop early, once clearly buckled or at rest, and what they tell of their end."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.simulation import outcome

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force
RESTING = fr.SimulationProblem(
    ROD.replace(damping_rate=60.0),  # friction alone does not stop a rod that rolls to and fro
    fr.AxialLoad(0.05 * FORCE, 0.02 * FORCE, 150.0),
    duration=0.5,
    friction=0.5,
    segments=48,
    frames=101,
    perturbation=fr.Perturbation.modes({3: 2e-3}),
    stop_early=True,
)
BUCKLING = RESTING.replace(
    load=fr.AxialLoad(3.0 * FORCE, 0.1 * FORCE, 150.0),
    friction=0.0,
    segments=84,
    perturbation=fr.Perturbation.modes({8: 0.1}),
)


@pytest.mark.parametrize(("problem", "ended"), [(RESTING, "at rest"), (BUCKLING, "buckled")])
def test_a_run_stops_at_the_first_frame_that_tells(problem: fr.SimulationProblem, ended: str) -> None:
    early, whole = problem.run(), problem.replace(stop_early=False).run()
    assert (early.ended, whole.ended) == (ended, "duration")
    assert early.complete
    assert whole.complete
    count = early.time.size
    assert 2 <= count < whole.time.size
    assert np.array_equal(early.positions, whole.positions[:count])
    # By the definition, frame by frame.
    period, step = 2.0 * math.pi / 150.0, whole.time[1]
    told = []
    for last in range(whole.time.size):
        first = last - math.ceil(period / step - 1e-9)
        window = whole.angle[max(first, 0) : last + 1]
        rests = first >= 0 and problem.friction > 0.0 and bool((np.ptp(window, axis=0) <= 1e-5).all())
        told.append(whole.largest_angle[last] > math.radians(45.0) or (rests and whole.largest_angle[last] < 0.087))
    assert told.index(True) == count - 1
    assert early.buckled == whole.buckled == (ended == "buckled")


def test_when_a_rod_buckled() -> None:
    run = BUCKLING.run()
    assert run.buckled_at is not None
    place = int(np.flatnonzero(run.time == run.buckled_at)[0])
    assert (run.largest_angle[:place] <= outcome.BUCKLED_ANGLE).all()
    assert run.largest_angle[place] > outcome.BUCKLED_ANGLE
    assert RESTING.run().buckled_at is None
    assert "stopped at" in repr(run)
    assert "stopped" not in repr(BUCKLING.replace(stop_early=False, duration=0.01).run())


@pytest.mark.parametrize("problem", [RESTING, BUCKLING])
def test_a_checkpoint_continues_a_run_that_stops_early(problem: fr.SimulationProblem, tmp_path: Path) -> None:
    path, whole = tmp_path / "run.ckpt", problem.run()
    calls = 0

    def interrupt(done: int, total: int) -> None:
        nonlocal calls
        calls += 1
        if calls == whole.time.size // 2:
            raise KeyboardInterrupt

    cut_short = problem.run(interrupt, path)
    assert cut_short.ended == "interrupted"
    assert problem.run(checkpoint=path) == whole
    assert problem.run(checkpoint=path) == whole  # nothing is left to do


@pytest.mark.parametrize("problem", [RESTING, BUCKLING])
def test_a_run_that_stopped_early_is_saved(problem: fr.SimulationProblem, tmp_path: Path) -> None:
    run = problem.run()
    again = fr.Simulation.load(run.save(tmp_path / "run.npz"))
    assert again == run
    assert again.ended == run.ended


@pytest.mark.parametrize("value", [1, "yes", None])
def test_stop_early_is_true_or_false(value: object) -> None:
    with pytest.raises(TypeError, match="stop_early must be True or False"):
        RESTING.replace(stop_early=value)
