"""Safe ranges of random rods against dense scans by the oracle, refined at every hump that may hide a band."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from fuzz import rods
from fuzz.core import Found, limit

CASES = 20
QUICK = 1

POINTS = 4000
_HUMPS = 16  # local maxima of growth that are looked at more closely, of each mode
_ZOOM = 25  # points between the neighbours of such a maximum, in each of two rounds

Array = NDArray[np.float64]


class Scan(NamedTuple):
    """Growth beyond the tolerance in 1/s over values of one quantity: at least ``low``, at most ``high``."""

    values: Array
    low: Array
    high: Array
    mode: NDArray[np.int64]


def check(rng: np.random.Generator) -> Found:
    """Compare the ranges of one quantity with a scan of 4,000 points, jittered, and what refines it."""
    question = rods.draw(rng)
    varied = str(rng.choice(["mean", "amplitude", "frequency"]))
    if varied == "mean":
        question = question._replace(mean=0.0)
    bounds, stated = ask(question, varied)
    failures = [f"{stated}: {wrong}" for wrong in compare(question, varied, bounds, _answer(stated), rng)]
    return Found(1, failures)


def ask(question: rods.Question, varied: str) -> tuple[tuple[float, float], str]:
    """Return the range asked about, and the call as an expression."""
    q, rod = question, question.rod
    tail = f"growth_tolerance={q.tolerance!r})"
    name = rods.named(rod)
    if varied == "mean":
        bounds = (0.0, 1.5 * rod.critical_force)
        return bounds, f"{name}.stable_mean_forces({q.amplitude!r}, {q.frequency!r}, {bounds!r}, {tail}"
    if varied == "amplitude":
        bounds = (0.0, rod.critical_force)
        return bounds, f"{name}.stable_amplitudes({q.mean!r}, {q.frequency!r}, {bounds!r}, {tail}"
    bounds = (0.5 * q.frequency, 2.0 * q.frequency)
    return bounds, f"{name}.stable_frequencies({q.mean!r}, {q.amplitude!r}, {bounds!r}, {tail}"


def _answer(call: str) -> Any:
    with limit():
        return eval(call, {"fr": fr})


def compare(
    question: rods.Question, varied: str, bounds: tuple[float, float], ranges: Any, rng: np.random.Generator
) -> list[str]:
    """Return what is wrong about stated ranges: a band called stable, or a stable stretch called unstable."""
    low, high = bounds
    values = np.linspace(low, high, POINTS + 1)[:-1] + (high - low) / POINTS * rng.random(POINTS)
    load = {"mean": question.mean, "amplitude": question.amplitude, "frequency": question.frequency}
    modes = rods.modes_seen(question.rod, **load | {varied: np.sort(values)}, tolerance=question.tolerance)
    scans = [_scan(question, varied, values, mode) for mode in modes]
    scans += [_closer(question, varied, scan) for scan in list(scans)]
    return [*_missed(question, varied, ranges, scans), *_invented(question, varied, ranges, values, scans)]


def _scan(question: rods.Question, varied: str, values: Array, mode: Any, accuracy: float = 1e-9) -> Scan:
    load = {"mean": question.mean, "amplitude": question.amplitude, "frequency": question.frequency} | {varied: values}
    rate = rods.growth(question.rod, **load, mode=mode, accuracy=accuracy, unless_below=question.tolerance)
    modes = np.broadcast_to(mode, values.shape).astype(np.int64)
    return Scan(values, rate.low - question.tolerance, rate.high - question.tolerance, modes)


def _closer(question: rods.Question, varied: str, scan: Scan) -> Scan:
    """Look twice at the humps that the scan passed below the threshold: a thin band may stand between two points."""
    mode = int(scan.mode[0])
    values, rate = scan.values, scan.low
    parts = []
    for _ in range(2):
        hump = np.flatnonzero((rate[1:-1] >= rate[:-2]) & (rate[1:-1] > rate[2:]) & (rate[1:-1] < 0.0)) + 1
        hump = hump[np.argsort(-rate[hump])[:_HUMPS]]
        if not hump.size:
            break
        values = np.unique(np.linspace(values[hump - 1], values[hump + 1], _ZOOM).ravel())
        parts.append(_scan(question, varied, values, mode))
        rate = parts[-1].low
    if not parts:
        return Scan(*(part[:0] for part in scan))
    return Scan(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _missed(question: rods.Question, varied: str, ranges: Any, scans: list[Scan]) -> list[str]:
    """Return the worst point called stable at which the oracle sees a mode grow beyond tolerance and error."""
    worst = None
    for scan in scans:
        inside_one = _strictly_inside(ranges, scan.values) & (scan.low > 0.0)
        for at in np.flatnonzero(inside_one):
            if worst is None or scan.low[at] > worst[0]:
                worst = float(scan.low[at]), float(scan.values[at]), int(scan.mode[at])
    if worst is None:
        return []
    rate, value, mode = worst
    around = _scan(question, varied, value + getattr(ranges, "resolution", 0.0) * np.linspace(-1.0, 1.0, 101), mode)
    if (around.low <= 0.0).any():  # narrower than what the result says may be missed
        return []
    return [f"missed band: at {value!r} mode {mode} grows {rate:.3g} 1/s beyond the tolerance"]


def _invented(question: rods.Question, varied: str, ranges: Any, values: Array, scans: list[Scan]) -> list[str]:
    """Return a point called unstable at which the oracle sees every mode the package looked at stay below."""
    quiet = ~inside(ranges, values)
    for scan in scans:
        if scan.values.shape == values.shape:
            quiet &= scan.high < 0.0
    at = np.flatnonzero(quiet)[:3]
    for value in values[at]:
        modes = np.arange(1, min(ranges.modes, 400) + 1)
        every = _scan(question, varied, np.full(modes.size, value), modes, 1e-12)
        if (every.high < -1e-9 * question.frequency).all():
            return [f"stable stretch called unstable: at {float(value)!r} every mode stays below the tolerance"]
    return []


def inside(ranges: Any, values: Array) -> NDArray[np.bool_]:
    found = np.zeros(values.shape, dtype=np.bool_)
    for part in ranges:
        found |= (values >= part.low) & (values <= part.high)
    return found


def _strictly_inside(ranges: Any, values: Array) -> NDArray[np.bool_]:
    """Leave out what is within rounding of an end."""
    found = np.zeros(values.shape, dtype=np.bool_)
    for part in ranges:
        slack = 1e-9 * max(abs(part.low), abs(part.high)) if math.isfinite(part.high) else 0.0
        found |= (values > part.low + slack) & (values < part.high - slack)
    return found
