"""What a worker does: the runs of a task, and the result of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from floquetrod._util import validate
from floquetrod.ensembles.stores import RunResult, reason_of
from floquetrod.ensembles.variables import DONE, FAILED
from floquetrod.ensembles.varied_axes import varied
from floquetrod.simulation.outcome import KINDS
from floquetrod.simulation.simulation_problem import Simulation, SimulationProblem

Summary = Callable[[Simulation], Mapping[str, float]]

_MOST_JUDGED = 20  # runs whose segments are judged before the others are made, ten milliseconds each (a choice)
T = TypeVar("T")

OWN_ERRORS = (Exception, SystemExit)
"""What a run or its summary may raise without ending others."""


class TaskSettings(NamedTuple):
    """What all tasks share: the problem, the summary, its names (None while unknown), and whether frames are stored."""

    problem: SimulationProblem
    summary: Summary | None
    names: tuple[str, ...] | None
    frames: bool


Batch = Sequence[tuple[int, Mapping[str, float]]]
"""Runs of a task: their numbers, with the values that they vary."""


def simulate_runs(
    job: TaskSettings, batch: Batch, progress: Callable[[int, int], None] | None = None
) -> list[RunResult]:
    """Make the runs of a task; what a run raises is recorded, and those that were interrupted are left out."""
    outcomes = []
    for run, values in batch:
        try:
            problem = varied(job.problem, values)
            made = problem._run(problem.time_steps, progress, None)  # what `run` warns of, the ensemble says once
            if not made.complete:
                break
            outcomes.append(outcome(job, run, made))
        except OWN_ERRORS as error:  # whatever it is, the other runs continue
            outcomes.append(failure(run, error))
    return outcomes


def spread(runs: Sequence[T]) -> list[T]:
    """Return up to twenty of the runs, evenly spread from the first to the last."""
    places = np.unique(np.linspace(0, len(runs) - 1, min(len(runs), _MOST_JUDGED)).astype(int))
    return [runs[place] for place in places.tolist()]


def coarseness(problem: SimulationProblem, values: Mapping[str, float]) -> str:
    """Return what too few segments make wrong in a run, in words; "" where there are enough, or no such run."""
    try:
        return varied(problem, values)._coarseness
    except (ValueError, ArithmeticError):
        return ""


def outcome(job: TaskSettings, run: int, made: Simulation) -> RunResult:
    """Return what came of a run that was made."""
    return RunResult(run, DONE, "", results(made), summarised(job, made), frames_of(job, made))


def failure(run: int, error: BaseException) -> RunResult:
    """Return the result of a run that raised an error."""
    return RunResult(run, FAILED, reason_of(error))


def results(made: Simulation) -> dict[str, float]:
    """Return the results of a run by name: `floquetrod.ensembles.stores.RESULTS` without the status."""
    mode = made.dominant_mode
    try:
        growth = made.growth_rate(mode)
        rate, error = growth.rate, growth.error
    except ValueError:  # friction, or too short
        rate = error = math.nan
    return {
        "buckled": made.buckled,
        "outcome": KINDS.index(made.outcome.kind),
        "angle_in_the_end": made.outcome.angle,
        "time_to_buckle": math.nan if made.buckled_at is None else made.buckled_at,
        "dominant_mode": mode,
        "growth_rate": rate,
        "growth_error": error,
        "largest_angle": float(made.largest_angle.max()),
        "energy_error": float(np.abs(made.energy_error).max()),
        "wall_time": made.seconds,
    }


def summarised(job: TaskSettings, made: Simulation) -> dict[str, float]:
    """Return what the summary makes of a run; an error unless it maps the names expected to numbers."""
    if job.summary is None:
        return {}
    summary = job.summary(made)
    if not isinstance(summary, Mapping) or not all(isinstance(name, str) for name in summary):
        raise TypeError(f"summary must return a mapping of names to numbers, got {validate.short(summary)}")
    if job.names is not None and set(summary) != set(job.names):
        raise ValueError(f"summary must return {', '.join(job.names)} of every run, got {', '.join(summary)}")
    return {name: number(name, value) for name, value in summary.items()}


def number(name: str, value: Any) -> float:
    """Return a number of a summary, which may be NaN, infinite or a truth value."""
    if isinstance(value, bool | np.bool_):
        return float(value)
    if isinstance(value, float | np.floating) and not math.isfinite(value):
        return float(value)
    return validate.finite(f"summary[{name!r}]", value)


def frames_of(job: TaskSettings, made: Simulation) -> dict[str, Any] | None:
    """Return the frames of a run, if they are asked for."""
    if not job.frames:
        return None
    expected = job.problem.mesh.segments + 1, job.problem.frames
    if (made.positions.shape[1], made.problem.frames) != expected:
        raise ValueError(
            "frames of all runs must have the same numbers of nodes and frames; vary neither with frames=True"
        )
    return {"time": made.time, "angle": made.angle, "positions": made.positions}
