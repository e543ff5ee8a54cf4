"""One question about a system in every public way: `stability`, arrays, charts, `certify`, `compare`, the terminal."""

from __future__ import annotations

import contextlib
import io
import json
import math
from dataclasses import fields
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod import cli
from tests.fuzz import system_draws, systems
from tests.fuzz.calls import folder
from tests.fuzz.core import limit
from tests.fuzz.system_draws import System

_SLACK = 1e-7  # of growth over a period, beside the errors stated: that of a double multiplier on a batch's coarser map


def disagreements(rng: np.random.Generator) -> list[str]:
    """Return every pair of answers about one random system that contradict each other, each on a line."""
    systems.warm()
    system = system_draws.draw(rng, most=4)
    with limit(60.0):
        result = fr.stability(system)
    lines = [*_arrays(system, result), *_chart(system, rng), *_terminal(system, result)]
    with limit(60.0):
        proof, methods = fr.certify(system), fr.compare(system)
    if {proof.status, result.status} == {"stable", "unstable"}:
        lines.append(f"certify proves {proof.status}, stability says {result.status}")
    lines += [f"{one} and {other} disagree" for one, other, _ in methods.disagreements]
    return [f"{systems.told(system)}: {line}" for line in lines]


def contradicts(result: Any, stable: bool, growth: float) -> bool:
    """Return whether a verdict and a growth rate, one of each, contradict a result beyond its errors."""
    if result.status == "undecided":
        return False
    near = abs(growth - result.growth_rate) * result.period <= 2.0 * result.error + _SLACK
    # False with no growth to speak of is how arrays say undecided.
    return not near or (stable if result.status == "unstable" else not stable and growth * result.period > _SLACK)


def _arrays(system: System, result: Any) -> list[str]:
    with limit(60.0):
        stable, growth = fr.systems.is_stable(system), fr.systems.growth_rate(system)
        multipliers = fr.systems.multipliers(system)
    lines = []
    if contradicts(result, stable, growth):
        lines.append(f"is_stable {stable}, growth_rate {growth!r}; stability has {result!r}")
    if result.exponents:
        one, other = (np.sort(np.abs(m))[::-1] for m in (multipliers, np.array(result.multipliers)))
        doubt = (result.error + _SLACK) * other[0]
        if np.abs(one - other).max() > max(doubt, _SLACK):
            lines.append(f"multipliers gives magnitudes {one.tolist()}, stability {other.tolist()}")
    return lines


def _chart(system: System, rng: np.random.Generator) -> list[str]:
    """Compare the chart of forcing and period, the system in one corner of it, with verdicts on its points."""
    axes = {
        "forcing": np.array([1.0, 1.0 + system_draws.decades(rng, 1e-9, 1.0)]),
        "longer": np.array([1.0, 1.0 + system_draws.decades(rng, 1e-9, 0.5)]),
    }

    def family(forcing: float, longer: float) -> System:
        forced = system_draws.forced(system, forcing)
        return system_draws.rewritten(forced, period=longer * system.period)

    with limit(60.0):
        chart = fr.chart(family, axes, growth=True)
        points = [(x, y, fr.stability(family(x, y))) for y in axes["longer"] for x in axes["forcing"]]
    rates = np.asarray(chart.growth_rate).ravel().tolist()
    verdicts = np.asarray(chart.stable).ravel().tolist()
    return [
        f"forcing {x!r}, longer {y!r}: the chart says stable {stable}, growth {rate!r}; stability {result!r}"
        for (x, y, result), stable, rate in zip(points, verdicts, rates, strict=True)
        if contradicts(result, stable, rate)
    ]


def _stacked(system: System) -> dict[str, Any]:
    """Return what a file has of a system in pieces: arrays of them all in place of its mean, its series and period."""
    durations, values = zip(*system.pieces, strict=True)
    most, zero = max(len(value.cosines) for value in values), np.zeros((system.order, system.order))
    cosines = [[*value.cosines, *[zero] * (most - len(value.cosines))] for value in values]
    gone = dict.fromkeys(("pieces", "period", "sines", system.MEAN))
    slopes = [value.slope_or_zero for value in values]
    start = "stiffness_start" if system.MEAN == "stiffness" else "matrix_start"
    starts = [value.start for value in values]
    return gone | {"durations": durations, start: starts, "slope": slopes, "cosines": cosines}


def _terminal(system: System, result: Any) -> list[str]:
    """Compare `check --system` with the library."""
    path = folder() / "asked.npz"
    made = {field.name: getattr(system, field.name) for field in fields(system)}
    made |= _stacked(system) if system.pieces else {}
    given = {name: np.array(value) for name, value in made.items() if value is not None}
    np.savez(path, **{name: array for name, array in given.items() if array.size})
    out = io.StringIO()
    with contextlib.redirect_stdout(out), limit(60.0):
        status = cli.main(["check", "--system", str(path), "--json", "--exit-code"])
    expected = {"stable": 0, "unstable": 1, "undecided": 3}[result.status]
    if status != expected:
        return [f"check ends with {status}, stability says {result.status}"]
    record = json.loads(out.getvalue())
    growth = record["growth_rate_per_unit_time"]
    same = growth == result.growth_rate or (growth is None and math.isnan(result.growth_rate))
    return [] if same and record["status"] == result.status else [f"check has {growth!r}, stability {result!r}"]
