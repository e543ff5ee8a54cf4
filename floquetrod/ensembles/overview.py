"""An ensemble at a glance: how many runs there are of each status, why some failed, how probable buckling is."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.result_report import number
from floquetrod.ensembles.outcome_warnings import counted, doubts, fixed_starts
from floquetrod.ensembles.runs import Runs, require_runs
from floquetrod.ensembles.shares import RANDOM, probability_of
from floquetrod.ensembles.variables import DONE, FAILED, PENDING
from floquetrod.simulation.outcome import KINDS

_NUMBERS = str.maketrans("", "", "0123456789.,+-")


class BucklingShare(NamedTuple):
    """The probability of buckling, with its interval, for one value of everything but the samples."""

    at: dict[str, float]
    counts: dict[str, int]
    shares: dict[str, float | None]


class Overview(NamedTuple):
    """What came of an ensemble: numbers of runs, reasons of failures, and a row for every value of the other axes."""

    total: int
    done: int
    failed: int
    pending: int
    buckled: int
    outcomes: dict[str, int]
    resting: tuple[float, float] | None  # rad, the least and the largest angle of a rod at rest beyond 5 degrees
    doubts: list[str]
    reasons: list[tuple[str, int]]
    rows: list[BucklingShare]
    units: dict[str, str]
    wall_time: float  # s that all runs done took, one after the other

    @classmethod
    def of(cls, result: Any, confidence: float) -> Overview:
        """Return it from what `floquetrod.ensemble` returned."""
        if not isinstance(result, Runs):
            names = ["status", "reason", "buckled", "outcome", "angle_in_the_end", "largest_angle", "wall_time"]
            result = result[names]  # frames stay where they are
        runs = require_runs("runs", result)
        status = runs["status"]
        done, failed, pending = (int((status == kind).sum()) for kind in (DONE, FAILED, PENDING))
        buckled = int((runs["buckled"][status == DONE] == 1).sum())
        sampled = [dim for dim in runs.variables["status"].dims if dim in RANDOM]
        rows = _table(probability_of(runs, "buckled", sampled, confidence)) if sampled else []
        rest = runs["angle_in_the_end"][(status == DONE) & (runs["outcome"] == KINDS.index("at rest"))]
        return cls(
            status.size,
            done,
            failed,
            pending,
            buckled,
            counted(runs),
            (float(rest.min()), float(rest.max())) if rest.size else None,
            [*doubts(runs), *fixed_starts(runs)],
            _counted(runs["reason"][status == FAILED]),
            rows,
            runs.units,
            float(np.nansum(runs["wall_time"][status == DONE])),
        )


def _table(probabilities: Runs) -> list[BucklingShare]:
    """Return the probability of buckling for every value of the chosen axes, in SI units."""
    dims, shape = probabilities.variables["probability"].dims, probabilities["probability"].shape
    rows = []
    for place in np.ndindex(shape):
        at = dict(zip(dims, place, strict=True))
        values = {name: axis.values[at[axis.dims[0]]].item() for name, axis in probabilities.coords.items()}
        counts = {name: int(probabilities[name][place]) for name in ("done", "failed", "moving")}
        ends = ("probability", "lower", "upper", "upper_moving")
        shares = {name: number(float(probabilities[name][place])) for name in ends}
        rows.append(BucklingShare(values, counts, shares))
    return rows


def _counted(reasons: Any) -> list[tuple[str, int]]:
    """Return the reasons of failures, with how often; those that differ in numbers alone are one."""
    groups: dict[str, tuple[str, int]] = {}
    for reason in map(str, np.ravel(reasons)):
        kind = reason.translate(_NUMBERS)
        first, count = groups.get(kind, (reason, 0))
        groups[kind] = first, count + 1
    return sorted(groups.values(), key=lambda group: -group[1])
