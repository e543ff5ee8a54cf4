"""Safe ranges and margins of random rods against dense scans by the oracle, refined at humps that may hide a band."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from tests.fuzz import rods
from tests.fuzz.core import Found, limit

CASES = 20
QUICK = 1

POINTS = 4000
_HUMPS = 16  # local maxima of growth that are looked at more closely, of each mode
_ZOOM = 25  # points between the neighbours of such a maximum, in each of two rounds
_REACH = 2.0  # critical forces, or times a frequency, up to which margins are compared
_ROUNDING = 1e-9  # of an end, relative

Array = NDArray[np.float64]


class Within(NamedTuple):
    """What a margin says as ranges do: the load's verdict holds between ``low`` and ``high``."""

    parts: tuple[fr.rod.StabilityInterval, ...]
    resolution: float
    modes: int

    def __iter__(self) -> Any:
        """Iterate over what is said to be stable."""
        return iter(self.parts)


class Scan(NamedTuple):
    """Growth beyond the tolerance in 1/s over values of one quantity: at least ``low``, at most ``high``."""

    values: Array
    low: Array
    high: Array
    mode: NDArray[np.int64]


def check(rng: np.random.Generator) -> Found:
    """Compare ranges and margin of one quantity with a scan of 4,000 points, jittered, and what refines it."""
    question = rods.draw(rng)
    varied = str(rng.choice(["mean", "amplitude", "frequency"]))
    margins = [*margin_against_ranges(question, varied), *margin_against_scan(question, varied, rng)]
    if varied == "mean":
        question = question._replace(mean=0.0)
    bounds, stated = ask(question, varied)
    failures = [f"{stated}: {wrong}" for wrong in compare(question, varied, bounds, _answer(stated), rng)]
    return Found(3, [*margins, *failures])


def ask(question: rods.Question, varied: str) -> tuple[tuple[float, float], str]:
    """Return the range asked about, and the call as an expression."""
    q, rod = question, question.rod
    tail = f"growth_tolerance={q.tolerance!r})"
    name = rods.named(rod)
    if varied == "mean":
        bounds = (0.0, 1.5 * rod.critical_force)
        return (
            bounds,
            f"{name}.ranges('mean', None, {bounds!r}, amplitude={q.amplitude!r}, frequency={q.frequency!r}, {tail}",
        )
    if varied == "amplitude":
        bounds = (0.0, rod.critical_force)
        return (
            bounds,
            f"{name}.ranges('amplitude', None, {bounds!r}, mean={q.mean!r}, frequency={q.frequency!r}, {tail}",
        )
    bounds = (0.5 * q.frequency, 2.0 * q.frequency)
    return bounds, f"{name}.ranges('frequency', None, {bounds!r}, mean={q.mean!r}, amplitude={q.amplitude!r}, {tail}"


def _answer(call: str) -> Any:
    with limit():
        return eval(call, {"fr": fr})


def margin_against_ranges(question: rods.Question, varied: str) -> list[str]:
    """Return where a margin ends elsewhere than the stable ranges about the load, or between which it lies."""
    asked = _margin(question, varied)
    if asked is None:
        return []
    question, stable, margin, here, bounds = asked
    fixed = {name: value for name, value in _load(question).items() if name != varied}
    with limit():
        ranges = question.rod.ranges(varied, None, bounds, **fixed, growth_tolerance=question.tolerance)
    lines = []
    for sign, size, bound in zip((-1.0, 1.0), margin, bounds, strict=True):
        stated = here + sign * size if sign * (bound - here - sign * size) > 0.0 else bound
        expected = _first_change(ranges, here, sign, stable, bound)
        if abs(stated - expected) > _ROUNDING * max(abs(stated), abs(here)) and not _is_narrow(
            question, varied, min(stated, expected, key=lambda end: sign * end), sign, margin, ranges, stable
        ):
            lines.append(f"{question}: the {varied} margin {margin} ends at {stated!r}, the ranges have {expected!r}")
    return lines


def _first_change(ranges: Any, here: float, sign: float, stable: bool, bound: float) -> float:
    """Return where the verdict first changes from ``here`` in a direction by the ranges, the bound where nowhere."""
    ends = [end for part in ranges for end in part[:2] if sign * (end - here) >= 0.0]
    if stable:
        ends = [part.high if sign > 0.0 else part.low for part in ranges if part.low <= here <= part.high] or [here]
    return min([*ends, bound], key=lambda end: sign * end)


def _is_narrow(
    question: rods.Question, varied: str, end: float, sign: float, margin: Any, ranges: Any, stable: bool
) -> bool:
    """Return whether what begins at an end is narrower than what the answers say may be passed over."""
    resolution = max(margin.resolution, ranges.resolution)
    if resolution == 0.0:
        return False
    values = end + sign * resolution * np.linspace(0.0, 1.0, 102)[1:]
    load = _load(question) | {varied: values[values > 0.0] if varied != "mean" else values}
    return bool((question.rod.is_stable(**load, growth_tolerance=question.tolerance) == stable).any())


def margin_against_scan(question: rods.Question, varied: str, rng: np.random.Generator) -> list[str]:
    """Return where the verdict changes within a margin, by the oracle."""
    asked = _margin(question, varied)
    if asked is None:
        return []
    question, stable, margin, here, bounds = asked
    bounds = max(bounds[0], here - margin.below), min(bounds[1], here + margin.above)
    if not bounds[0] < bounds[1]:
        return []
    parts = (fr.rod.StabilityInterval(*bounds, None, None),) if stable else ()
    largest = _load(question) | {varied: bounds[1]}
    count = question.rod.stability(fr.AxialLoad(**largest), growth_tolerance=question.tolerance).modes_checked
    said = Within(parts, margin.resolution, count)
    return [f"{question}: {varied} {margin}: {wrong}" for wrong in compare(question, varied, bounds, said, rng)]


def _margin(question: rods.Question, varied: str) -> tuple[rods.Question, bool, Any, float, tuple[float, float]] | None:
    """Return the question with the tolerance of its margins, the verdict, a margin, the load and bounds about it."""
    with limit():
        verdict = question.rod.stability(fr.AxialLoad(**_load(question)), growth_tolerance=question.tolerance)
        margin = verdict.margin(varied)
    if verdict.stable is None:
        return None
    here, unit = _load(question)[varied], _REACH * question.rod.critical_force
    low, high = (here / _REACH, here * _REACH) if varied == "frequency" else (here - unit, here + unit)
    below, above = margin.searched
    bounds = max(low, here - 1.5 * below), min(high, here + 1.5 * above)
    bounds = (max(0.0, bounds[0]) if varied == "amplitude" else bounds[0]), bounds[1]
    return question._replace(tolerance=verdict.margin_tolerance), bool(verdict.stable), margin, here, bounds


def _load(question: rods.Question) -> dict[str, float]:
    return {"mean": question.mean, "amplitude": question.amplitude, "frequency": question.frequency}


def compare(
    question: rods.Question, varied: str, bounds: tuple[float, float], ranges: Any, rng: np.random.Generator
) -> list[str]:
    """Return what is wrong about stated ranges: a band called stable, or a stable stretch called unstable."""
    low, high = bounds
    values = np.linspace(low, high, POINTS + 1)[:-1] + (high - low) / POINTS * rng.random(POINTS)
    load = _load(question)
    modes = rods.modes_seen(question.rod, **load | {varied: np.sort(values)}, tolerance=question.tolerance)
    scans = [_scan(question, varied, values, mode) for mode in modes]
    scans += [_closer(question, varied, scan) for scan in list(scans)]
    return [*_missed(question, varied, ranges, scans), *_invented(question, varied, ranges, values, scans)]


def _scan(question: rods.Question, varied: str, values: Array, mode: Any, accuracy: float = 1e-9) -> Scan:
    load: dict[str, Any] = _load(question) | {varied: values}
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
