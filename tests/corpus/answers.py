"""Results as plain JSON with their errors, and when an answer is another than the one kept.

An answer is made of words and whole numbers (the same or different), floats (compared within a tolerance of their
kind), numbers with the error that they state, {"value": ..., "error": ...}, multipliers, which have no order,
{"spectrum": ..., "error": ...}, and lists and mappings of all these.  A refusal is "refused: " with the exception.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

WORDS = {1: "stable", 0: "unstable", -1: "undecided"}
DECIDED = ("stable", "unstable", "mixed", "bounded", "escapes")
"""What undecided may become."""
ROUNDING = 16.0 * np.finfo(float).eps
"""Relative size of a difference in rounding, which every number may have beside its stated error."""
COARSER, FINE = 100.0, 1e-9
"""A stated error that has become so many times larger and is above this part of the number differs, too."""


class Finding(NamedTuple):
    """What is not as it was: whether that is allowed, where in the answer, and what."""

    allowed: bool
    where: str
    what: str


def plain(value: Any) -> Any:
    """Return numbers, arrays, tuples with and without names, and mappings as JSON; of anything else its text."""
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if hasattr(value, "_asdict"):
        return {name: plain(part) for name, part in value._asdict().items()}
    if isinstance(value, dict):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, complex):
        return [value.real, value.imag]
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def number(value: Any, error: Any) -> dict[str, Any]:
    """Return a number, or an array of them, with the error it states."""
    return {"value": plain(value), "error": plain(error)}


def words(codes: Any, names: dict[int, str] = WORDS) -> Any:
    """Return codes 1, 0, -1 as words; True and False stay."""
    if isinstance(codes, list):
        return [words(code, names) for code in codes]
    return codes if isinstance(codes, bool) else names[codes]


def statuses(v: Any) -> Any:
    """Return the verdicts of arrays as words, or as True and False where that is what was asked for."""
    return words(plain(v))


def growth_error(v: Any, damping: float) -> float:
    """Return the error of a growth rate that follows from a discriminant, 2 + 4 sinh(u T / 2)^2, u the undamped rate.

    The error of a verdict is that of its discriminant relative to max(1, abs(discriminant)).
    """
    if v.growth_rate == 0.0 and v.status == "stable":  # a growth within the tolerance has an error like any other
        return 0.0
    if not v.error < math.inf:
        return math.inf
    half = 0.5 * (v.growth_rate + damping) * v.period
    if half > 15.0:
        return v.error / v.period
    excess = math.sinh(half) ** 2
    change = v.error * (0.5 + excess)
    edges = (2.0 * math.asinh(math.sqrt(max(0.0, excess + way * change))) / v.period for way in (-1.0, 1.0))
    return max(abs(edge - v.growth_rate - damping) for edge in edges)


def differences(old: Any, new: Any, relative: float, floor: float, where: str = "") -> Iterator[Finding]:
    """Yield where two answers differ; floats by more than ``relative`` times the larger of them, or times ``floor``."""
    if isinstance(old, dict) and isinstance(new, dict):
        if "error" in old and "error" in new:
            yield from _stated(old, new, where)
        elif old.get("status") == "undecided" and new.get("status") in DECIDED:
            yield Finding(True, where, f"undecided has become {new['status']}")
        else:
            yield from _named(old, new, relative, floor, where)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, pair in enumerate(zip(old, new, strict=True)):
            yield from differences(*pair, relative, floor, f"{where}[{i}]")
    elif isinstance(old, float) and _is_number(new):
        if _apart(old, new, relative * max(abs(old), abs(new), floor)):
            yield Finding(False, where, f"was {old!r}, is {new!r}, allowed is {relative:g} relative")
    elif type(old) is not type(new) or old != new:
        decided = (old == "undecided" and new in DECIDED) or (_is_refusal(old) and not _is_refusal(new))
        yield Finding(decided, where, f"was {_short(old)}, is {_short(new)}")


def _named(old: Any, new: Any, relative: float, floor: float, where: str) -> Iterator[Finding]:
    for name in old:
        if name in new:
            yield from differences(old[name], new[name], relative, floor, f"{where}.{name}")
        else:
            yield Finding(False, f"{where}.{name}", f"has disappeared, was {_short(old[name])}")
    for name in new.keys() - old.keys():
        yield Finding(True, f"{where}.{name}", f"has appeared: {_short(new[name])}")


def _stated(old: Any, new: Any, where: str) -> Iterator[Finding]:
    """Yield where numbers differ by more than the sum of the errors they state, and where these have grown."""
    key = "spectrum" if "spectrum" in old else "value"
    if key not in new or np.shape(old[key]) != np.shape(new[key]):
        yield Finding(False, where, f"was {_short(old)}, is {_short(new)}")
        return
    (before, least), (after, most) = _with_errors(old, key), _with_errors(new, key)
    if key == "spectrum":
        order = _matched(before, after)
        after, most = after[order], most[order]
    size = np.maximum(abs(before), abs(after))
    for at in map(tuple, np.argwhere(_apart(before, after, least + most + ROUNDING * size))[:3]):
        numbers = f"was {before[at].item()!r} +- {least[at]:.2g}, is {after[at].item()!r} +- {most[at]:.2g}"
        yield Finding(False, f"{where}{list(map(int, at)) or ''}", numbers)
    unstated = (least == 0.0) & (before != 0.0)  # of growth within a tolerance, when these answers were kept
    coarser = np.argwhere((most > COARSER * least + FINE * size) & (least < np.inf) & ~unstated)
    for at in map(tuple, coarser[:1]):
        yield Finding(False, where, f"the stated error has grown from {least[at]:.2g} to {most[at]:.2g}")


def _with_errors(answer: Any, key: str) -> tuple[Any, Any]:
    """Return numbers, complex ones for multipliers, and their errors as arrays of one shape."""
    value, error = np.asarray(answer[key], dtype=float), np.asarray(answer["error"], dtype=float)
    if key == "spectrum":
        value = value.reshape(-1, 2) @ [1.0, 1.0j]
    value, error = np.broadcast_arrays(value, error)
    return value, error


def _matched(before: Any, after: Any) -> Any:
    """Return the order in which the multipliers after lie nearest to those before."""
    from scipy.optimize import linear_sum_assignment

    return linear_sum_assignment(abs(before[:, None] - after[None, :]))[1]


def _apart(old: Any, new: Any, allowed: Any) -> Any:
    with np.errstate(invalid="ignore"):
        return ~((old == new) | (np.isnan(old) & np.isnan(new)) | (abs(np.subtract(old, new)) <= allowed))


def _is_refusal(value: Any) -> bool:
    return isinstance(value, str) and value.startswith("refused: ")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else repr(value)
    return re.sub(r"(?s)^(.{100}).+", r"\1 ...", text)


# --- results of each kind as JSON -------------------------------------------------------------------------------------


def fields(*names: str) -> Callable[[Any], Any]:
    """Return a reader of these fields of a result."""
    return lambda v: {name: plain(getattr(v, name)) for name in names}


def equation(v: Any) -> Any:
    """Return the verdict on an equation."""
    found = {"status": v.status, "interval": None if v.interval is None else str(v.interval)}
    found["growth"] = number(v.growth_rate, growth_error(v, v.equation.damping))
    if math.isfinite(v.discriminant):
        return found | {"discriminant": number(v.discriminant, v.error * max(1.0, abs(v.discriminant)))}
    return found | {"log_abs_discriminant": number(v.log_abs_discriminant, v.error)}


def system(v: Any) -> Any:
    """Return the verdict on a system, with the multipliers that doubles hold."""
    rates, errors = np.array([x.real for x in v.exponents]), np.array(v.exponent_errors)
    found = {"status": v.status, "structure": v.structure, "strongly_stable": v.strongly_stable}
    if not rates.size:
        return found
    error = max((rates + errors).max() - rates.max(), rates.max() - (rates - errors).max())
    kept = [i for i, mu in enumerate(v.multipliers) if abs(mu) < 1e300]
    return found | {
        "growth": number(v.growth_rate, float(error)),
        "multipliers": {
            "spectrum": [plain(v.multipliers[i]) for i in kept],
            "error": [v.multiplier_errors[i] for i in kept],
        },
        "krein_signs": sorted(v.krein_signs),
        "resonances": sorted(str(r) for r in v.resonances),  # in no order where two grow equally fast
    }


def growth(v: Any) -> Any:
    """Return status and growth of a verdict whose multipliers are no more than those that were asked for."""
    rates, errors = np.array([x.real for x in v.exponents]), np.array(v.exponent_errors)
    error = max((rates + errors).max() - rates.max(), rates.max() - (rates - errors).max())
    return {"status": v.status, "fastest": number(float(rates.max()), float(error))}


def orbit(v: Any) -> Any:
    """Return period and multipliers of a periodic orbit with their errors, and the largest value of each state."""
    found = {"status": v.status, "period": number(v.period, v.period_error)}
    verdict = v.stability
    return found | {
        "multipliers": {
            "spectrum": [plain(mu) for mu in verdict.multipliers],
            "error": list(verdict.multiplier_errors),
        },
        "largest": number(_largest(v), v.error * np.abs(v.states).max(axis=0)),
    }


def _largest(v: Any) -> Any:
    """Return the largest value of each state, wherever the mesh has its nodes."""
    times = np.linspace(0.0, v.period, 2001)
    step = times[1]
    peaks = times[v(times).argmax(axis=0)]
    return [
        -minimize_scalar(lambda t, i=i: -v(t % v.period)[i], bounds=(at - step, at + step), method="bounded").fun
        for i, at in enumerate(peaks)
    ]


def noisy_rod(v: Any) -> Any:
    """Return the verdict in mean square on a rod, whose error is that of the growth of its second moments."""
    return fields("status", "unstable_modes", "fastest_mode")(v) | {"growth": number(v.growth_rate, 1e-9)}


def proof(v: Any) -> Any:
    """Return what a proof says; the numbers it rests on are the business of its method."""
    return {"status": v.status, "interval": None if v.interval is None else str(v.interval)}


def comparison(v: Any) -> Any:
    """Return which methods say what, and whether they agree."""
    return {"agree": v.agree, "status": {r.method: r.status for r in v.results}}


def safe_box(v: Any) -> Any:
    """Return a safe box, whose sides are known as closely as was asked for."""
    sides = {r.quantity: number([r.low, r.high], v.accuracy * (r.high - r.low)) for r in v.ranges}
    return {"status": v.proof.status, "sides": sides}


def bent_rod(v: Any) -> Any:
    """Return the verdict on a rod some of whose modes grow so fast that which others grow is lost in rounding."""
    fastest = [str(r) for r in v.resonances[:1] if r.growth_rate > v.growth_tolerance]
    return {"status": v.status, "growth": number(v.growth_rate, v.error), "fastest": fastest}


def rod(v: Any) -> Any:
    """Return the verdict on a rod: its error is that of the growth rate with coupled modes, else of a discriminant."""
    found = fields("status", "unstable_modes", "fastest_mode")(v)
    if hasattr(v, "convergence"):
        names = sorted(str(r) for r in v.resonances if r.growth_rate > v.growth_tolerance)
        return found | {"growth": number(v.growth_rate, v.error), "resonances": names}
    modes = [m for m in v.mode_verdicts[:8] if math.isfinite(m.discriminant)]
    errors = [m.error * max(1.0, abs(m.discriminant)) for m in modes]
    found["growth"] = number(v.growth_rate, growth_error(v, v.rod.damping_rate))
    return found | {"discriminants": number([m.discriminant for m in modes], errors)}


def kicked(v: Any) -> Any:
    """Return the verdict on a rod with friction."""
    return fields("status", "unstable_modes")(v) | {"fates": [fate.status for fate in v.fates]}


def ranges(v: Any) -> Any:
    """Return stability intervals and what lies between them."""
    stable = [[i.low, i.high, *map(_cause, (i.low_end, i.high_end))] for i in v.intervals]
    unstable = [[u.low, u.high, u.worst_growth, u.required_damping, _cause(u.cause)] for u in v.unstable]
    found = {"stable": stable, "unstable": unstable, "required_damping": v.required_damping}
    return found | {"complete": v.resolution == 0.0, "hairlines": v.tongues_left_out}


def _cause(cause: Any) -> str | None:
    return None if cause is None else str(cause)


def margin(v: Any) -> Any:
    """Return a margin and whether anything may have been passed over."""
    return {"below": v.below, "above": v.above, "complete": v.resolution == 0.0}


def fates(v: Any) -> Any:
    """Return the fates of kicks in words."""
    return words(plain(v), {0: "escapes", 1: "bounded", -1: "undecided"})


def chart(v: Any) -> Any:
    """Return the points of a chart, with what was asked for beside the verdict."""
    rows = ["".join("-+"[stable] for stable in row) for row in v.stable.tolist()]
    return {"stable": rows} | fields("growth_rate", "undecided", "cells")(v)


def bands(v: Any) -> Any:
    """Return the bands of a chart: names, areas with what the accuracy of edges leaves open, fastest growth."""
    sides = [axis.values[-1] - axis.values[0] for axis in (v.x, v.y)]
    found = []
    for band in v.bands:
        x, y = band.x / sides[0], band.y / sides[1]
        area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
        around = float(np.hypot(x - np.roll(x, -1), y - np.roll(y, -1)).sum())
        found.append([band.name, number(area, v.accuracy * around), band.largest_growth])
    return {"bands": sorted(found, key=lambda band: (band[0], band[1]["value"])), "hairlines": v.tongues_left_out}


def solution(v: Any) -> Any:
    """Return where a solution ends, and in the middle, with the error it states."""
    middle = 0.5 * (v.time[0] + v.time[-1])
    states = np.array([v.states[-1], np.ravel(v.states[len(v.states) // 2])])
    size = float(np.abs(v.states).max())
    here = np.ravel(v(middle))
    return {"states": number(states[0], 2.0 * v.error * size), "middle": number(here, 2.0 * v.error * size)}


def simulation(v: Any) -> Any:
    """Return the last frame of a simulation, positions across in clearances, and energies as parts of the largest."""
    across = v.positions[-1][:, 1:] / v.rod.radial_clearance
    largest = max(float(np.abs(values).max()) for values in v.energy.values())
    energy = {name: float(values[-1]) / largest for name, values in v.energy.items()}
    return {"ended": v.ended, "across": plain(across[::5]), "energy": energy, "buckled": v.buckled}


def record(v: Any) -> Any:
    """Return what was fitted to a measured force, which the same least squares give far within its standard errors."""
    return {
        "mean": number(v.mean, 1e-6 * v.mean_error),
        "frequency": number(v.frequency, 1e-6 * v.frequency_error),
        "sizes": number(np.abs(v.harmonics), 1e-6 * v.harmonic_errors),
    }


def tongues(v: Any) -> Any:
    """Return tongues to first order, the fastest growing first."""
    read = fields("kind", "modes", "order", "frequency", "coupling", "damping", "half_width", "overlaps")
    return [read(tongue) for tongue in v]
