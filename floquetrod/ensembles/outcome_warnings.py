"""What makes outcomes of an ensemble doubtful: motion at the end of runs, loads that theory calls stable."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.shares import RANDOM
from floquetrod.ensembles.tasks import coarseness, spread
from floquetrod.ensembles.variables import DONE
from floquetrod.ensembles.varied_axes import varied
from floquetrod.simulation.findings import STABLE_LOAD
from floquetrod.simulation.outcome import KINDS, Outcome
from floquetrod.simulation.simulation_problem import SimulationProblem

_MOST_VERDICTS = 20  # on loads under which rods buckled, milliseconds each (a choice)
_OF_A_PROBLEM = ("kick", "seed", "duration", "time_step", "frames", "segments", "friction")
"""Quantities on which the stability of a load without friction does not depend."""


class OutcomeWarning(UserWarning):
    """Simulated rods may end otherwise in longer runs, are all alike, or should not have buckled by theory."""


def counted(runs: Runs) -> dict[str, int]:
    """Return how many of the runs done have come to each outcome, by its kind."""
    kinds = runs["outcome"][runs["status"] == DONE]
    return {kind: int(np.sum(kinds == number)) for number, kind in enumerate(KINDS)}


def doubts(runs: Runs) -> list[str]:
    """Return, in sentences, why some of the runs done may not have ended as they seem; nothing without ``outcome``."""
    if not {"outcome", "buckled"} <= runs.variables.keys():
        return []
    sentences = []
    for kind, count in counted(runs).items():
        if count and (doubt := Outcome(kind, 0.0).doubt):
            sentences.append(f"{count:,} {'run' if count == 1 else 'runs'} counted as not buckled, {doubt}")
    sentences += _too_coarse(runs) + _identical(runs)
    count = _buckled_under_stable_loads(runs)
    return (
        [*sentences, f"{count:,} {'run' if count == 1 else 'runs'} buckled, but {STABLE_LOAD}"] if count else sentences
    )


def fixed_starts(runs: Runs) -> list[str]:
    """Return a sentence where neither the seed nor a distribution varies, or where all runs start with one seed."""
    if not any(dim in RANDOM for dim in runs.variables["status"].dims):
        return ["neither a seed nor a distribution varies: each combination of the values is one run, without a share"]
    if "problem" not in runs.attrs or "seed" in runs.coords:
        return []
    if not SimulationProblem.from_dict(json.loads(runs.attrs["problem"])).perturbation.noises:
        return []
    return ["no seed varies: all runs start with the same random speeds, and the shares hold for these speeds alone"]


def _identical(runs: Runs) -> list[str]:
    """Return a sentence where all runs of a cell moved alike, so that they count as one and the interval is too narrow.

    Cells are the combinations of chosen values.  Runs of different starts have different largest angles.
    """
    dims = runs.variables["status"].dims
    drawn = [place for place, dim in enumerate(dims) if dim in RANDOM]
    if not drawn or "largest_angle" not in runs.variables:
        return []

    def by_cell(name: str) -> Any:
        values = np.moveaxis(runs[name], drawn, range(-len(drawn), 0))
        return values.reshape(-1, int(np.prod(values.shape[-len(drawn) :])))

    done, angle = by_cell("status") == DONE, by_cell("largest_angle")
    least, largest = (np.where(done, angle, end) for end in (np.inf, -np.inf))
    several = done.sum(axis=1) > 1
    alike = several & (least.min(axis=1) == largest.max(axis=1))
    if not alike.any():
        return []
    where = "" if alike.all() else f" in {alike.sum():,} of {len(alike):,} cells"
    return [
        f"all runs of a cell are identical{where}: they count as one run, so that the interval is too narrow; vary the "
        "seed of a random start, or draw values from a distribution"
    ]


def _too_coarse(runs: Runs) -> list[str]:
    """Return a sentence about runs with too few segments for the modes that grow, among twenty spread over them all."""
    names = list(runs.attrs.get("varied", ()))
    if "problem" not in runs.attrs or not set(names) <= runs.coords.keys():
        return []
    problem = SimulationProblem.from_dict(json.loads(runs.attrs["problem"]))
    dims, texts = runs.variables["status"].dims, []
    for place in spread(list(np.argwhere(runs["status"] == DONE))):
        at = dict(zip(dims, place.tolist(), strict=True))
        values = {name: runs[name][tuple(at[dim] for dim in runs.coords[name].dims)].item() for name in names}
        texts.append(coarseness(problem, values))
    coarse = list(filter(None, texts))
    return [f"{'' if all(texts) else 'some '}runs are too coarse: {coarse[0]}"] if coarse else []


def _buckled_under_stable_loads(runs: Runs) -> int:
    """Return how many runs buckled under loads stable by theory, among the first twenty different loads.

    Coupled modes, whose verdict may take half a minute, are left out; so are rods that a tool or a moved end drives.
    """
    dims = runs.variables["status"].dims
    buckled = np.argwhere((runs["status"] == DONE) & (runs["buckled"] == 1))
    if not buckled.size or "problem" not in runs.attrs:
        return 0
    problem = SimulationProblem.from_dict(json.loads(runs.attrs["problem"]))
    # Theory is of independent modes of a rod that nothing but its load drives.
    driven = any(given is not None for given in (problem.feed_speed, problem.far_force, problem.tool))
    if driven or not problem.rod._modes_under(problem.load).modes_apart(range(1, 2)):
        return 0
    of_the_load = [name for name in runs.attrs.get("varied", ()) if name not in _OF_A_PROBLEM]
    if not set(of_the_load) <= runs.coords.keys():
        return 0
    counts: dict[tuple[float, ...], int] = {}
    for place in buckled:
        at = dict(zip(dims, place.tolist(), strict=True))
        values = tuple(runs[name][tuple(at[dim] for dim in runs.coords[name].dims)].item() for name in of_the_load)
        counts[values] = counts.get(values, 0) + 1
    return sum(_stable(problem, of_the_load, list(counts.items())[:_MOST_VERDICTS]))


def _stable(problem: SimulationProblem, names: list[str], counts: list[tuple[tuple[float, ...], int]]) -> Iterator[int]:
    """Yield the numbers of runs under each stable load."""
    for values, count in counts:
        try:
            each = varied(problem, dict(zip(names, values, strict=True)))
            status = each.rod.stability(each.load).status
        except (ValueError, ArithmeticError):  # a rod or a load of which there is no verdict
            continue
        if status == "stable":
            yield count
