"""Rods in wells: random ends, fluids, inclinations and loads, against finite differences and against themselves."""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np

import floquetrod as fr
from tests import coupled_cases
from tests import finite_differences as fd
from tests.fuzz.core import Found, limit
from tests.fuzz.rods import decades

CASES = 300
QUICK = 2

SHARE = 0.1
"""Share of the cases that finite differences are asked about, which takes a second or two each."""

POINTS, CLOSER = 150, 20
"""Values of a quantity of the load looked at before the end of a margin, and either side of one that contradicts it."""

_UNTOLD = 1e-6  # growth in 1/s that modes left out may have
_SAME = 1e-6  # relative difference between two ways to the same growth
_OVER_ARRAYS = 1e-3  # the same where fewer modes may be taken, as over arrays of loads, which state no error
_VAGUE = 1e-2  # error of finite differences, of the bed's frequency, beyond which they say nothing
_MOST_SHAPES = 130  # that finite differences are asked to follow


class Question(NamedTuple):
    """A rod, a load of any kind and a growth tolerance in 1/s."""

    rod: fr.Rod
    load: Any
    tolerance: float

    def __str__(self) -> str:
        """Return it as an expression."""
        return f"fr.{self.rod!r}.stability(fr.{self.load!r}, growth_tolerance={self.tolerance!r})"


def check(rng: np.random.Generator) -> Found:
    """Ask about one rod in every cheap way, and by finite differences once in a while."""
    warm()
    question = draw(rng)
    try:
        with limit(60.0):
            verdict = ask(question)
    except ValueError as error:
        resonant = isinstance(question.load, fr.AxialWave) and question.load.axial_damping == 0.0
        expected = resonant and "axial_damping" in str(error)
        return Found(1, [] if expected else [f"{question}: refused, {error}"])
    lines = sound(question, verdict)
    if math.isfinite(verdict.growth_rate + verdict.error):
        lines += by_other_ways(question, verdict, rng)
    if rng.random() < SHARE:
        lines += against_finite_differences(question, verdict)
    if rng.random() < SHARE:
        lines += along_a_margin(question, verdict, str(rng.choice(("mean", "amplitude", "frequency"))), rng)
    return Found(1, [f"{question}: {line}" for line in lines])


@functools.cache
def warm() -> None:
    """Compile what verdicts run, which no limit of time is for."""
    rng = np.random.default_rng(1)
    for _ in range(12):
        question = draw(rng)
        ask(question)
        question.rod.growth_rate(question.load)


def ask(question: Question) -> Any:
    """Return the verdict."""
    return question.rod.stability(question.load, growth_tolerance=question.tolerance)


# --- questions ---


def draw(rng: np.random.Generator) -> Question:
    """Return a rod with a load of the order of its own forces and frequencies, realistic or extreme."""
    rod = draw_rod(rng)
    load = draw_load(rng, rod)
    swing = rod.pendulum_frequency
    tolerance = float(rng.choice((0.0, 0.0, decades(rng, 1e-4, 1e-2) * swing, decades(rng, 1e-2, 0.2) * swing)))
    return Question(rod, load, tolerance)


def draw_rod(rng: np.random.Generator) -> fr.Rod:
    """Return a wire, a catheter or a pipe: solid or not, dry or in fluids, with any ends, at any inclination."""
    radius = decades(rng, 3e-4, 5e-2)
    inner = radius * float(rng.choice((0.0, rng.uniform(0.2, 0.97))))
    density = decades(rng, 900.0, 9000.0)
    own = density * (1.0 - (inner / radius) ** 2)
    rod = fr.Rod(
        decades(rng, 1e7, 2.5e11),
        density,
        radius,
        1.0,
        radius * (1.0 + decades(rng, 0.1, 10.0)),
        float(rng.uniform(1.0, 20.0)),
        inner_radius=inner,
        fluid_inside=float(rng.choice((0.0, rng.uniform(1.0, 2000.0)))),
        fluid_outside=float(rng.choice((0.0, rng.uniform(0.0, 0.9)))) * own,
        added_mass_coefficient=float(rng.uniform(0.0, 5.0)),
        inclination=float(rng.choice((math.pi / 2, rng.uniform(0.1, math.pi / 2), rng.uniform(1.2, math.pi / 2)))),
        ends=str(rng.choice(coupled_cases.ENDS)),
    )
    rates = (0.0, 0.0, decades(rng, 1e-4, 0.05), decades(rng, 0.05, 1.0))
    damping = rod.pendulum_frequency * float(rng.choice(rates))
    return rod.replace(length=decades(rng, 0.5, 9.0) / rod.critical_mode, damping_rate=damping)


def draw_load(rng: np.random.Generator, rod: fr.Rod) -> Any:
    """Return a force the same along the rod or a wave, a sine or a few harmonics."""
    unit, swing = rod.critical_force, rod.pendulum_frequency
    parts = float(rng.uniform(-0.3, 1.2)) * unit, decades(rng, 0.01, 1.0) * unit, decades(rng, 0.5, 5.0) * swing
    choices: dict[str, Any] = {"mean_at": (None, 0.0, 0.5, 1.0, float(rng.random()))[rng.integers(5)]}
    if rng.random() < 0.3:
        count = int(rng.integers(1, 4))
        amplitudes = rng.normal(size=(count, 2)) @ (1.0, 1j) / np.arange(1.0, count + 1.0)
        choices["waveform"] = tuple(complex(h) for h in 0.7 * amplitudes)
    if rng.random() < 0.5:
        return fr.AxialLoad(*parts, **choices)
    rates = (0.0, decades(rng, 1e-3, 10.0) * swing)
    return fr.AxialWave(
        *parts,
        far_end=str(rng.choice(("held", "free", "driven"))),
        axial_damping=float(rng.choice(rates)),
        **choices,
    )


# --- answers ---


def sound(question: Question, verdict: Any) -> list[str]:
    """Return what is wrong about a verdict by itself."""
    lines = []
    unknown = verdict.status == "undecided"
    if not unknown and (not math.isfinite(verdict.growth_rate) or math.isnan(verdict.error)):
        lines.append(f"growth {verdict.growth_rate!r}, error {verdict.error!r}")
    if unknown and not verdict.note:
        lines.append("undecided without a reason")
    if verdict.status == "stable" and verdict.growth_rate > question.tolerance * (1.0 + _SAME) + _UNTOLD:
        lines.append(f"stable, growth {verdict.growth_rate!r}")
    if verdict.status == "unstable":
        if verdict.growth_rate < question.tolerance * (1.0 - _SAME):
            lines.append(f"unstable, growth {verdict.growth_rate!r} within the tolerance")
        if not verdict.unstable_modes:
            lines.append("unstable, no mode named")
    return lines


def by_other_ways(question: Question, verdict: Any, rng: np.random.Generator) -> list[str]:
    """Compare a verdict with those over arrays, with more modes, and with other tolerances."""
    rod, load, tolerance = question
    numbers, rate = coupled_cases.numbers(load), verdict.growth_rate
    lines = []
    found = float(rod.growth_rate(load, **coupled_cases.by_name(*numbers)))
    slack = stated(verdict) + _SAME * (1.0 + abs(rate)) + blur(question, rate)
    if abs(found - rate) > slack + _OVER_ARRAYS * abs(rate):
        lines.append(f"growth {rate!r}, over arrays {found!r}")
    decided = int(rod.verdicts(load, **coupled_cases.by_name(*numbers), growth_tolerance=tolerance))
    if (decided, verdict.status) in ((1, "unstable"), (0, "stable")) and abs(
        rate - tolerance
    ) > slack + _OVER_ARRAYS * rate:
        lines.append(f"{verdict.status}, over arrays {decided}; growth {rate!r}")
    if rng.random() < 0.3:
        apart = 3.0 * slack
        above = ask(question._replace(tolerance=max(rate, 0.0) + apart))
        if above.status == "unstable":
            lines.append(f"growth {rate!r}, yet unstable with the tolerance {above.growth_tolerance!r}")
        if rate > 2.0 * apart:
            below = ask(question._replace(tolerance=rate - apart))
            if below.status == "stable":
                lines.append(f"growth {rate!r}, yet stable with the tolerance {below.growth_tolerance!r}")
    if rng.random() < 0.3:
        most = math.ceil(1.3 * verdict.modes_checked) + 2
        more = rod.stability(load, range(1, most + 1), growth_tolerance=tolerance)
        if abs(more.growth_rate - rate) > _UNTOLD + 3.0 * slack:
            several = f"{rate!r} +- {verdict.error:.2g} with {verdict.modes_checked} modes"
            lines.append(f"growth {several}, {more.growth_rate!r} with {most}")
    return lines


def along_a_margin(question: Question, verdict: Any, varied: str, rng: np.random.Generator) -> list[str]:
    """Scan one quantity of the load up to its margins: the verdict stays as it is, and changes at their ends."""
    if verdict.stable is None:
        return []
    margin = getattr(verdict, {"mean": "mean_force_margin"}.get(varied, f"{varied}_margin"))
    here, tolerance, lines = getattr(question.load, varied), verdict.margin_tolerance, []
    for sign, size, searched in zip((-1.0, 1.0), margin, margin.searched, strict=True):
        reach = min(size, searched)
        if not reach > 0.0:
            continue
        steps = np.sort(rng.uniform(1e-6, 1.0 - 1e-6, POINTS)) * reach
        at = _otherwise(question, varied, here + sign * steps, tolerance, verdict)
        for run in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size else ():
            place = here + sign * float(steps[run[run.size // 2]])
            around = place + margin.resolution * np.linspace(-1.0, 1.0, 2 * CLOSER + 1)
            around = around[(around > 0.0) & (abs(around - here) < reach)] if varied != "mean" else around
            wrong = _otherwise(question, varied, around, tolerance, verdict)
            if wrong.size > CLOSER:
                lines.append(f"the {varied} margin is {margin}, but the verdict changes before, at {place!r}")
                break
        if math.isfinite(size):
            beyond = here + sign * size * (1.0 + np.array([1e-9, 1e-7, 1e-6, 1e-5]))
            beyond = beyond[(beyond > 0.0) | (varied == "mean")]
            changed = _otherwise(question, varied, beyond, tolerance, verdict, surely=False)
            if beyond.size and not changed.size:
                lines.append(f"the {varied} margin is {margin}, but the verdict stays beyond {here + sign * size!r}")
    return lines


def _otherwise(
    question: Question, varied: str, values: Any, tolerance: float, verdict: Any, *, surely: bool = True
) -> Any:
    """Return at which values of one quantity of the load the verdict surely is another, or may be."""
    loads = dict(zip(("mean", "amplitude", "frequency"), coupled_cases.numbers(question.load), strict=True))
    growth = question.rod.growth_rate(question.load, **loads | {varied: values})
    slack = (_UNTOLD + _OVER_ARRAYS * tolerance) * (1.0 if surely == bool(verdict.stable) else -1.0)
    return np.flatnonzero(growth > tolerance + slack if verdict.stable else growth <= tolerance + slack)


def stated(verdict: Any) -> float:
    """Return the error of the growth rate in 1/s that a verdict states; independent modes state another one."""
    return float(verdict.error) if hasattr(verdict, "convergence") else 0.0


def blur(question: Question, rate: float) -> float:
    """Return how far rounding may shift a growth rate: multipliers that meet are as uncertain as a square root."""
    per_period = rate * 2.0 * math.pi / question.load.frequency
    return 1e-11 / max(per_period, 3e-6) * question.load.frequency


def against_finite_differences(question: Question, verdict: Any) -> list[str]:
    """Compare a verdict with the growth of a model that shares no code with the package."""
    model = coupled_cases.model(question.rod, question.load)
    if fd.enough_shapes(model) > _MOST_SHAPES:
        return []
    rate, error = fd.growth(model)
    if error > _VAGUE * question.rod.pendulum_frequency:
        return []
    slack = 5.0 * error + _UNTOLD + _SAME * abs(rate) + blur(question, rate)
    return compared(question, verdict, rate, slack)


def compared(question: Question, verdict: Any, rate: float, slack: float) -> list[str]:
    """Return what a verdict says against a growth rate known to ``slack``."""
    known = f"finite differences have {rate!r} +- {slack:.2g}"
    if verdict.status == "unstable" and rate + slack < question.tolerance:
        return [f"unstable, {known}"]
    if verdict.status == "stable" and rate - slack > question.tolerance:
        return [f"stable, {known}"]
    if math.isfinite(verdict.growth_rate) and abs(
        max(verdict.growth_rate, 0.0) - max(rate, 0.0)
    ) > slack + 2.0 * stated(verdict):
        return [f"{verdict.status}, growth {verdict.growth_rate!r} +- {stated(verdict):.2g}, {known}"]
    return []
