"""Margins of rods whose modes are coupled against dense scans by finite differences, and at their very edges."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from tests import coupled_cases
from tests import finite_differences as fd
from tests.fuzz import real_rods
from tests.fuzz.core import Found, limit
from tests.fuzz.real_rods import Question
from tests.fuzz.rods import decades

CASES = 40
QUICK = 1

SECONDS = 1.0
"""Of the search for a margin, which states its resolution."""

POINTS, CLOSER = 200, 20
"""Values of a quantity looked at between the load and the end of a margin, and either side of one that contradicts."""

_LONGEST = 3.0  # half waves of a rod
_MOST_MODES = 16
_CELLS = 120  # of the grid along the rod
_SHAPES = (6, 12)  # natural shapes that are followed, at least and at most
_REACH = 3.0  # frequencies of the load up to which they are
_GROUPS = 4  # of values of like periods
_TURN = 0.8  # of the fastest of them in a step, in rad
_SURE = 2e-3  # growth over a period within which finite differences are not relied upon
_SHIFTS = np.linspace(-1.0, 1.0, 7) * 2e-3  # relative, of a value at which all modes are asked in their place
_INSIDE = 1.0 - np.array([1e-9, 1e-7, 1e-5])
_BEYOND = 1.0 + np.array([1e-9, 1e-7, 1e-6, 1e-5, 1e-4])

# Order four, six stages: Blanes & Moan, J. Comput. Appl. Math. 142 (2002) 313, table 2.
_DRIFTS = (0.0792036964311957, 0.353172906049774, -0.0420650803577195)
_KICKS = (0.209515106613362, -0.143851773179818)

Array = NDArray[np.float64]


def check(rng: np.random.Generator) -> Found:
    """Compare the three margins of one short rod."""
    real_rods.warm()
    question, verdict = draw(rng)
    lines, answers = [], 0
    for varied in ("mean", "amplitude", "frequency"):
        with limit(60.0):
            margin = verdict.margin(varied, seconds=SECONDS)
        if any(margin.searched):
            answers += 1
            lines += compared(question, verdict, varied, margin, rng)
    return Found(answers, [f"{question}: {line}" for line in lines])


def draw(rng: np.random.Generator) -> tuple[Question, Any]:
    """Return a short rod under a load that couples its modes, and a verdict that is decided."""
    while True:
        question = real_rods.draw(rng)
        rod = question.rod
        length = rod.length * decades(rng, 0.3, _LONGEST) / rod.critical_mode
        question = question._replace(rod=rod.replace(length=length))
        try:
            verdict = real_rods.ask(question)
        except ValueError:  # at an axial resonance
            continue
        coupled = bool(rod._modes_under(question.load).coupling) and verdict.modes_checked <= _MOST_MODES
        if coupled and verdict.stable is not None and question.load.amplitude > 0.0:
            return question, verdict


def compared(question: Question, verdict: Any, varied: str, margin: Any, rng: np.random.Generator) -> list[str]:
    """Return where the verdict changes within a margin, or does not at its ends."""
    here, lines = getattr(question.load, varied), []
    for sign, size, searched in zip((-1.0, 1.0), margin, margin.searched, strict=True):
        reach = min(size, searched)
        if not reach > 0.0:
            continue
        told = f"the {varied} margin is {margin}, searched {margin.searched}, resolution {margin.resolution:g}"
        values = here + sign * reach * np.sort(rng.uniform(1e-6, 1.0 - 1e-6, POINTS))
        lines += [f"{told}, but {wrong}" for wrong in within(question, verdict, varied, margin, sign * reach, values)]
        if math.isfinite(size):
            lines += [f"{told}, but {wrong}" for wrong in at_its_end(question, verdict, varied, here, sign * size)]
    return lines


def within(question: Question, verdict: Any, varied: str, margin: Any, reach: float, values: Array) -> list[str]:
    """Return where finite differences, and all modes near by, have another verdict within a margin."""
    here, tolerance = getattr(question.load, varied), verdict.margin_tolerance
    growth, period = scan(question, varied, values)
    sure = _SURE / period + 1e-2 * tolerance
    at = np.flatnonzero(growth > tolerance + sure if verdict.stable else growth < min(tolerance, 1e-5 / period.max()))
    for run in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)[:3] if at.size else ():
        place = float(values[run[np.argmax(growth[run]) if verdict.stable else run.size // 2]])
        near = place + _SHIFTS * abs(place)
        near = near[_is_within(near, here, reach, varied)]
        wrong = near[real_rods._otherwise(question, varied, near, tolerance, verdict)] if near.size else near
        if wrong.size:
            place = float(wrong[wrong.size // 2])
            around = place + margin.resolution * np.linspace(-1.0, 1.0, 2 * CLOSER + 1)
            around = around[_is_within(around, here, reach, varied)]
            if real_rods._otherwise(question, varied, around, tolerance, verdict).size > CLOSER:
                return [f"the verdict changes at {place!r}"]
            continue
        there = Question(question.rod, question.load.varied(varied, place), tolerance)
        lines = real_rods.against_finite_differences(there, real_rods.ask(there))
        if lines:
            return [f"at {place!r}: {line}" for line in lines]
    return []


def _is_within(values: Array, here: float, reach: float, varied: str) -> NDArray[np.bool_]:
    """Return which values lie within a margin, and may be taken."""
    return (np.abs(values - here) < abs(reach)) & ((values > 0.0) | (varied == "mean"))


def at_its_end(question: Question, verdict: Any, varied: str, here: float, reach: float) -> list[str]:
    """Return whether the verdict changes before the end of a margin, or stays beyond it."""
    tolerance = verdict.margin_tolerance
    lines = []
    if real_rods._otherwise(question, varied, here + reach * _INSIDE, tolerance, verdict).size:
        lines.append(f"the verdict changes before {here + reach!r}")
    beyond = here + reach * _BEYOND
    beyond = beyond[(beyond > 0.0) | (varied == "mean")]
    load = dict(zip(("mean", "amplitude", "frequency"), coupled_cases.numbers(question.load), strict=True))
    growth = question.rod.growth_rate(question.load, **load | {varied: beyond})
    if beyond.size and not (growth > tolerance if verdict.stable else growth <= tolerance).any():
        lines.append(f"the verdict stays beyond {here + reach!r}")
    return lines


# --- another way to growth rates ---


def scan(question: Question, varied: str, values: Array) -> tuple[Array, Array]:
    """Return growth rates in 1/s, negative where all decays, and periods in s, by finite differences along the rod."""
    stiffness, waves, frequency = _matrices(question, varied, values)
    period = 2.0 * math.pi / frequency
    fastest = math.sqrt(float(np.abs(np.linalg.eigvalsh(stiffness[[0, -1]])).max()))
    largest = np.empty(values.size)
    for part in np.array_split(np.argsort(period), _GROUPS):
        steps = math.ceil(fastest * float(period[part].max()) / _TURN)
        maps = _period_maps(stiffness[part], waves[part], period[part], steps)
        largest[part] = np.abs(np.linalg.eigvals(maps)).max(axis=1)
    return np.log(largest) / period - question.rod.damping_rate, period


def _matrices(question: Question, varied: str, values: Array) -> tuple[Array, Array, Array]:
    """Return mean stiffness (b, m, m), cosines and sines of the vibration (b, 2 H, m, m), and frequencies (b,)."""
    rod, load = question.rod, question.load
    model = coupled_cases.model(rod, load)
    grid = fd._grid(model, _CELLS)
    highest = _REACH * len(load.harmonics) * (values.max() if varied == "frequency" else load.frequency)
    squared, shapes = np.linalg.eigh(grid.mean_stiffness())
    shapes = shapes[:, : int(np.clip((squared < highest**2).sum(), *_SHAPES))]
    every = grid.in_shapes(shapes)
    still = every[0] - rod.damping_rate**2 * np.eye(shapes.shape[1])
    mean, waves = np.tile(still, (values.size, 1, 1)), np.tile(every[1:], (values.size, 1, 1, 1))
    frequency = np.full(values.size, load.frequency)
    if varied == "mean":
        uniform = grid._replace(forces=np.ones((2, grid.forces.shape[1]))).in_shapes(shapes)[1]
        mean += (values - load.mean)[:, None, None] * uniform
    elif varied == "amplitude":
        waves *= (values / load.amplitude)[:, None, None, None]
    else:
        frequency = values
        if not load.is_uniform:
            waves = np.array([_waves_at(rod, load, value, shapes) for value in values.tolist()])
    return mean, waves, frequency


def _waves_at(rod: fr.Rod, load: Any, frequency: float, shapes: Array) -> Array:
    """Return cosines and sines of the vibration at another frequency."""
    grid = fd._grid(coupled_cases.model(rod, load.varied("frequency", frequency)), _CELLS)
    turned = grid.turn @ shapes
    return np.asarray(-np.swapaxes(turned[None] * grid.forces[1:, :, None], 1, 2) @ turned)


def _period_maps(stiffness: Array, waves: Array, period: Array, steps: int) -> Array:
    """Return the maps over a period of u'' + K(t) u = 0, (b, 2 m, 2 m), by a splitting of order four."""
    size = stiffness.shape[-1]
    state = np.tile(np.eye(2 * size), (len(stiffness), 1, 1))
    position, velocity = state[:, :size], state[:, size:]
    h = (period / steps)[:, None, None]
    drifts = [*_DRIFTS, 1.0 - 2.0 * sum(_DRIFTS), *_DRIFTS[::-1]]
    kicks = [*_KICKS, 0.5 - sum(_KICKS), 0.5 - sum(_KICKS), *_KICKS[::-1], 0.0]
    for step in range(steps):
        turn = 2.0 * math.pi * step / steps
        for drift, kick in zip(drifts, kicks, strict=True):
            position += drift * h * velocity
            turn += drift * 2.0 * math.pi / steps
            if kick:
                velocity -= kick * h * (_at(stiffness, waves, turn) @ position)
    return state


def _at(stiffness: Array, waves: Array, turn: float) -> Array:
    """Return K at an angle of the period."""
    order = np.arange(1, waves.shape[1] // 2 + 1) * turn
    factors = np.column_stack([np.cos(order), np.sin(order)]).ravel()
    return np.asarray(stiffness + np.tensordot(waves, factors, axes=(1, 0)))
