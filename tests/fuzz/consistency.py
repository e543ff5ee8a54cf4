"""The same question asked in every way the package has: answers must agree just inside and outside every stated end."""

from __future__ import annotations

import contextlib
import functools
import io
import json
import math
from collections.abc import Callable, Iterator
from itertools import pairwise, zip_longest
from typing import Any

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod import cli
from tests.fuzz import rods, system_answers
from tests.fuzz.calls import folder
from tests.fuzz.core import Found, limit

CASES = 60
QUICK = 2

DISTANCES = (1e-6, 1e-3)
"""From an end, relative to the interval it belongs to."""

HAIRLINE = 1e-6
"""Growth in 1/s: below it margins need not see a tongue."""

_ROUNDING = 1e-9  # growth beyond the tolerance, relative, that two ways may see differently
_ENDS = 8  # of the ends of a range that are looked at


def check(rng: np.random.Generator) -> Found:
    """Ask one question of one rod, or of one system of equations, in all ways."""
    if rng.random() < 0.3:
        return Found(1, system_answers.disagreements(rng))
    parts = ("ranges", "margins", "damping", "terminal")
    return Found(1, disagreements(rods.draw(rng), rng, parts if rng.random() < 0.2 else parts[:3]))


def disagreements(question: rods.Question, rng: np.random.Generator, parts: tuple[str, ...]) -> list[str]:
    """Return every pair of answers that contradict each other, each on a line."""
    lines: list[str] = []
    if "ranges" in parts:
        lines += _ranges(question, rng)
    if "margins" in parts:
        lines += _margins(question)
    if "damping" in parts:
        lines += _damping(question)
    if "terminal" in parts:
        lines += _terminal(question)
    return [f"{question}: {line}" for line in lines]


def _load(question: rods.Question, **changes: Any) -> dict[str, Any]:
    return {"mean": question.mean, "amplitude": question.amplitude, "frequency": question.frequency} | changes


def _ranges(q: rods.Question, rng: np.random.Generator) -> Iterator[str]:
    """Compare the ranges of each quantity with verdicts at points beside their ends, and with what is critical."""
    rod, unit = q.rod, q.rod.critical_force
    tail = {"growth_tolerance": q.tolerance}
    with limit():
        found = {
            "mean": rod.ranges("mean", amplitude=q.amplitude, frequency=q.frequency, bounds=(0.0, 1.2 * unit), **tail),
            "amplitude": rod.ranges("amplitude", mean=q.mean, frequency=q.frequency, bounds=(0.0, unit), **tail),
            "frequency": rod.ranges(
                "frequency", mean=q.mean, amplitude=q.amplitude, bounds=(0.6 * q.frequency, 1.6 * q.frequency), **tail
            ),
        }
    for varied, ranges in found.items():
        values, inside = _beside(ranges, rng)
        if values.size:
            yield from _verdicts(q, varied, values, inside)
    with limit():
        critical = {
            "mean": (
                rod.critical("mean", amplitude=q.amplitude, frequency=q.frequency, growth_tolerance=q.tolerance),
                1.5 * unit,
            ),
            "amplitude": (
                rod.critical("amplitude", mean=q.mean, frequency=q.frequency, growth_tolerance=q.tolerance),
                unit,
            ),
        }
    for varied, (value, upto) in critical.items():
        firsts = _first_ends(found[varied], functools.partial(_negligible, q, varied))
        may_be_missed = found[varied].resolution > 0.0 and value < firsts[0]
        same = any(math.isclose(first, value, rel_tol=1e-9, abs_tol=1e-12 * unit) for first in firsts)
        if firsts[0] < min(upto, 1.2 * unit) and not same and not may_be_missed:
            yield f"the critical {varied} is {value!r}, the ranges give {firsts!r}"


def _negligible(q: rods.Question, varied: str, value: float) -> bool:
    """Return whether nothing grows there by more than what modes left out may grow by, 1e-12 per second."""
    return bool(q.rod.is_stable(**_load(q, **{varied: value}), growth_tolerance=q.tolerance))


def _first_ends(ranges: Any, negligible: Callable[[float], bool]) -> list[float]:
    """Return where the first unstable part begins, and those before it that may be missed: narrow, or negligible."""
    low, high = ranges.bounds
    parts = list(ranges)
    if not parts or parts[0].low > low:
        return [low]
    ends = []
    for part, after in zip_longest(parts, parts[1:]):
        ends.append(part.high if part.high < high else math.inf)
        if after is None:
            break
        if after.low - part.high > ranges.resolution and not negligible(0.5 * (part.high + after.low)):
            break
    return ends


def _beside(ranges: Any, rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return points inside and outside the ends of stable intervals, and which are inside some interval."""
    parts = list(ranges)
    gaps = [(a.high, b.low) for a, b in pairwise(parts)]
    points: list[float] = []
    for low, high in [*((part.low, part.high) for part in parts), *gaps]:
        points += [place for d in DISTANCES for place in (low + d * (high - low), high - d * (high - low))]
        points.append(0.5 * (low + high))
    if len(points) > 5 * _ENDS:
        points = list(rng.choice(points, 5 * _ENDS, replace=False))
    points = [x for x in points if min((abs(x - e) for part in parts for e in part[:2]), default=1.0) > 1e-12 * abs(x)]
    values = np.unique(points)
    return values, np.array([any(part.low < x < part.high for part in parts) for x in values], dtype=np.bool_)


def _verdicts(q: rods.Question, varied: str, values: NDArray[np.float64], inside: NDArray[np.bool_]) -> Iterator[str]:
    """Compare membership in the ranges with every other verdict at these values."""
    load = _load(q, **{varied: values})
    with limit():
        arrays = q.rod.is_stable(**load, growth_tolerance=q.tolerance)
        rate, mode = q.rod.growth_rate(**load, return_mode=True)
        other = "frequency" if varied != "frequency" else "mean"
        pair = np.array([load[other], load[other] * 1.5 + q.rod.critical_force * (load[other] <= 0.0)])
        order = np.sort(pair)
        mapped = fr.stability_map(q.rod, **load | {other: order}, growth=True, growth_tolerance=q.tolerance)
    at = int(np.flatnonzero(order == load[other])[0])
    row = (lambda a: a[at]) if (mapped.x.name.split()[0] == varied) else (lambda a: a[:, at])
    single = [
        q.rod.stability(fr.AxialLoad(**_load(q, **{varied: float(x)})), growth_tolerance=q.tolerance) for x in values
    ]
    clear = np.abs(rate - q.tolerance) > _ROUNDING * max(q.tolerance, q.rod.damping_rate)
    clear |= (q.tolerance == 0.0) & (q.rod.damping_rate == 0.0)
    answers = {"is_stable": arrays, "stability_map": row(mapped.stable), "ranges": inside}
    for name, found in answers.items():
        wrong = np.flatnonzero((found != arrays) & clear)
        if wrong.size:
            i = wrong[0]
            yield (
                f"{varied} {float(values[i])!r}: {name} says {'un' * (not found[i])}stable, is_stable otherwise "
                f"(mode {mode[i]} grows {rate[i]:.6g} 1/s)"
            )
    for i, result in enumerate(single):
        if result.stable is not None and clear[i] and result.stable != arrays[i]:
            yield f"{varied} {float(values[i])!r}: stability says {result.status}, is_stable {bool(arrays[i])}"
        if result.stable is not None and not math.isclose(result.growth_rate, rate[i], rel_tol=1e-8, abs_tol=1e-10):
            yield f"{varied} {float(values[i])!r}: stability has growth {result.growth_rate!r}, fastest {rate[i]!r}"
    if not np.allclose(row(mapped.growth_rate), rate, rtol=1e-12, atol=0.0):
        yield f"{varied}: growth of the map differs from fastest"


def _margins(q: rods.Question) -> Iterator[str]:
    """Compare the three margins with verdicts just before and just beyond them."""
    tolerance = max(q.tolerance, HAIRLINE)
    with limit():
        result = q.rod.stability(fr.AxialLoad(**_load(q)), growth_tolerance=tolerance)
        margins = {
            "mean": result.mean_force_margin,
            "amplitude": result.amplitude_margin,
            "frequency": result.frequency_margin,
        }
    if result.stable is None:
        return
    for varied, margin in margins.items():
        here = _load(q)[varied]
        for sign, size in zip((-1.0, 1.0), margin, strict=True):
            if math.isfinite(size):
                yield from margin_lines(q, tolerance, bool(result.stable), varied, here, sign * size)


def margin_lines(
    q: rods.Question, tolerance: float, stable: bool, varied: str, here: float, step: float
) -> Iterator[str]:
    """Look for a change of verdict before the margin ends, and for one at its end."""
    before = here + step * np.concatenate([np.linspace(0.0, 1.0, 41)[1:-1], 1.0 - np.array(DISTANCES)])
    beyond = here + step * (1.0 + np.array([0.0, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6]))
    beyond = beyond + math.copysign(1e-12, step) * max(abs(here), abs(step))
    beyond = beyond[(beyond > 0.0) | (varied == "mean")]
    with limit():
        kept = q.rod.is_stable(**_load(q, **{varied: before}), growth_tolerance=tolerance)
        left = q.rod.is_stable(**_load(q, **{varied: beyond}), growth_tolerance=tolerance)
    if (kept != stable).any():
        at = float(before[kept != stable][0])
        yield f"the {varied} margin is {step!r} at tolerance {tolerance!r}, but the verdict changes before, at {at!r}"
    if left.size and (left == stable).all():
        yield f"the {varied} margin is {step!r} at tolerance {tolerance!r}, but the verdict stays the same beyond"


def _damping(q: rods.Question) -> Iterator[str]:
    """Compare the damping that stabilises with verdicts on rods that have a little more and a little less."""
    with limit():
        rate = q.rod.stability(fr.AxialLoad(**_load(q))).damping_to_stabilise
        if math.isinf(rate):
            return
        for larger in (rate * (1.0 + 1e-6) + 1e-9, 1.3 * rate + 1e-3, 5.0 * rate + 1.0):
            if not q.rod.replace(damping_rate=larger).is_stable(**_load(q)):
                yield f"damping_to_stabilise is {rate!r}, but {larger!r} does not"
        if rate > 1e-3 and q.rod.replace(damping_rate=rate * (1.0 - 1e-6)).is_stable(**_load(q)):
            yield f"damping_to_stabilise is {rate!r}, but a millionth less does, too"


def _terminal(q: rods.Question) -> Iterator[str]:
    """Compare `check`, `ranges` and `map` with the library."""
    place = folder() / "consistent.toml"
    sheet = "\n".join(f"{name} = {value!r}" for name, value in q.rod.as_dict().items())
    place.write_text(sheet, encoding="utf-8")
    rod = ["--rod", str(place), "--growth-tolerance", repr(q.tolerance)]
    load = {name: f"--{name}={value!r}" for name, value in _load(q).items()}
    with limit():
        record = _json(["check", *rod, *load.values()])
        result = q.rod.stability(fr.AxialLoad(**_load(q)), growth_tolerance=q.tolerance)
    if (record["status"], record["growth_rate_per_s"]) != (result.status, result.growth_rate):
        yield f"check says {record['status']}, {record['growth_rate_per_s']!r}; stability {result!r}"
    bounds = (0.6 * q.frequency, 1.6 * q.frequency)
    asked = f"--frequency={bounds[0]!r}:{bounds[1]!r}"
    with limit():
        record = _json(["ranges", *rod, load["mean"], load["amplitude"], asked])
        ranges = q.rod.ranges(
            "frequency", mean=q.mean, amplitude=q.amplitude, bounds=bounds, growth_tolerance=q.tolerance
        )
    ends = [(part["low_rad_per_s"], part["high_rad_per_s"]) for part in record["stable"]]
    if not np.allclose(ends, [part[:2] for part in ranges], rtol=1e-12, atol=0.0):
        yield f"ranges prints {ends}, Rod.ranges has {list(ranges)}"
    out = folder() / "consistent.npz"
    mean = f"--mean=0:{q.rod.critical_force!r}"
    with limit():
        _json(["map", *rod, mean, load["amplitude"], asked, "--points=7x5", "--growth", f"--out={out}"])
        chart = fr.Chart.load(out)
        grid = {"mean": chart.y.values[:, None], "frequency": chart.x.values}
        scale = q.rod.critical_force / chart.y.values[-1]
        stable = q.rod.is_stable(
            mean=grid["mean"] * scale, amplitude=q.amplitude, frequency=grid["frequency"], growth_tolerance=q.tolerance
        )
    if (chart.stable != stable).any():
        yield "map draws another verdict than is_stable gives"


def _json(words: list[str]) -> Any:
    """Return what a command prints as JSON."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = cli.main([*words, "--json"])
    if status != 0:
        raise RuntimeError(f"floquetrod {' '.join(words)} ended with {status}: {err.getvalue()}")
    return json.loads(out.getvalue())
