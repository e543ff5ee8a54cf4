"""Branches of a rod's large motion over a quantity of the load: where they begin, how far they go, what they do."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress, shifted
from floquetrod.orbits import Branch, PeriodicOrbit, follow, periodic_orbit
from floquetrod.rod.answers.rod_branches import OFF_WALL, RodBranch, RodBranches
from floquetrod.rod.large_orbits import (
    INDENTATION,
    MOST_HALF_WAVES,
    ModeOrbit,
    alone,
    beam_functions,
    candidates,
    indentation_of,
    orbits_alone,
    orbits_of,
    require_possible,
)
from floquetrod.rod.loads.load import QUANTITIES, AnyLoad, Load, Quantity, load_number, require_load
from floquetrod.rod.mode_equations.large_motion import LargeMotion, Shapes
from floquetrod.rod.mode_equations.one_mode import LIMIT
from floquetrod.rod.model.data import RodData
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.motion import NEAR, TOLERANCE, Motions, chosen, largest, orbit_near

_LOADS = 5  # of the range, at which orbits are searched for (a choice)
_SAME = 0.02  # of an angle, by which an orbit may differ from one on a branch, between its points
_PRESSED = 1.0 / 3.0  # of the weight: with less contact than that motion and the simulator's part
_INSTANTS = 256  # of a period, at which a motion is examined


class _Task(NamedTuple):
    """What to follow: the equations, the quantity and its range, steps to each side and their length."""

    motions: Motions
    quantity: Quantity
    over: tuple[float, float]
    steps: int
    longest: float


def branches(
    model: ModeModel,
    given: AnyLoad,
    over: Any,
    which: tuple[int | None, bool],
    indentation: float,
    steps: int,
    longest: float,
    progress: Progress | None,
) -> RodBranches:
    """Return the branches of a rod's motion; see `floquetrod.Rod.follow`."""
    load, rod = require_load("load", given), model.rod
    mode, all_modes, indentation, steps, longest = _checked(which, indentation, steps, longest, progress)
    quantity, low, high = _range(over)
    load = load.varied(quantity, min(max(float(getattr(load, quantity)), low), high))
    require_possible(rod, load)
    if quantity != "amplitude" and load.amplitude == 0.0:
        raise validate.wrong_value("load", "must vibrate: under a constant force steady_motion computes the angle")
    shapes = Shapes.of(rod, load, beam_functions(rod, mode))
    loads = [load, *(load.varied(quantity, value) for value in _values(low, high))]
    mode = _moving(model, loads, shapes, indentation) if mode is None else mode
    motion = LargeMotion(
        rod, load, shapes.some(chosen(shapes, mode, *(NEAR[-1] if all_modes else NEAR[0]))), indentation
    )
    task = _Task(Motions(motion), quantity, (low, high), steps, longest)
    pieces = _searched(task, mode, loads, shapes, progress)
    if not pieces:
        raise validate.wrong_value(
            "over",
            f"must hold loads that carry a large motion in mode {mode}; a search up to {math.degrees(LIMIT):.0f} "
            f"degrees at {len(loads)} loads found none",
        )
    modes = tuple(motion.shapes.numbers.tolist())
    return RodBranches(rod, load, quantity, (low, high), mode, modes, tuple(pieces))


def resumed(
    rod: RodData,
    result: RodBranches,
    over: Any,
    which: tuple[int | None, bool],
    indentation: float,
    steps: int,
    longest: float,
    progress: Progress | None,
) -> RodBranches:
    """Return branches with what follows their ends; see `floquetrod.Rod.follow`."""
    if result.rod != rod:
        raise validate.wrong_value("load", "must be branches of this rod; follow them with the rod that they are of")
    mode, all_modes, indentation, steps, longest = _checked(which, indentation, steps, longest, progress)
    given = {"mode": mode is not None, "all_modes": all_modes, "indentation": indentation != INDENTATION}
    if name := next((name for name, is_given in given.items() if is_given), None):
        raise validate.wrong_value(name, "must be left out where branches are continued, which keep theirs")
    quantity, low, high = (result.parameter, *result.over) if over is None else _range(over)
    pieces = []
    for i, piece in enumerate(result.parts):
        motions = cast(Any, piece.branch.system.function).motions
        task = _Task(motions, quantity, (low, high), steps, longest)
        pieces.append(_followed(task, piece.branch, shifted(progress, 2 * i * steps, 2 * i * steps)))
    return replace(result, over=(low, high), parts=tuple(pieces))


def _checked(
    which: tuple[Any, Any], indentation: Any, steps: Any, longest: Any, progress: Any
) -> tuple[int | None, bool, float, int, float]:
    """Return the mode, whether all modes are taken, the indentation, and how many steps and how long, checked."""
    mode, all_modes = which[0], validate.flag("all_modes", which[1])
    if mode is not None:
        mode = validate.integer("mode", mode, 1, MOST_HALF_WAVES, "half waves of the motion to follow")
    indentation = indentation_of(indentation)
    steps = validate.integer("steps", steps, 1, 10_000)
    validate.progress(progress)
    return mode, all_modes, indentation, steps, validate.within("longest", longest, 1e-3, 1.0)


def _range(over: Any) -> tuple[Quantity, float, float]:
    """Return the quantity and its range, checked."""
    if not isinstance(over, Mapping) or len(over) != 1:
        raise TypeError(
            "over must be one quantity of the load with its range, such as {'frequency': (100.0, 180.0)}, got "
            f"{validate.short(over)}"
        )
    ((name, ends),) = over.items()
    quantity = cast(Quantity, validate.choice("over", name, QUANTITIES))
    low, high = validate.interval(f"over[{name!r}]", ends, lambda label, value: load_number(quantity, value, label))
    return quantity, low, high


def _values(low: float, high: float) -> list[float]:
    """Return values at which to look for orbits, not those at the ends of the range."""
    return [low + (high - low) * (k + 0.5) / _LOADS for k in range(_LOADS)]


def _moving(model: ModeModel, loads: list[Load], shapes: Shapes, indentation: float) -> int:
    """Return the mode that moves under the first of some loads under which one does."""
    for load in loads:
        rest = model.verdict(load, None, 0.0, None)
        orbit_alone = next(orbits_of(model.rod, load, shapes, candidates(rest, shapes, None), indentation), None)
        if orbit_alone is not None:
            return orbit_alone.mode
    raise validate.wrong_value(
        "over",
        f"must hold loads that carry a large motion; a search up to {math.degrees(LIMIT):.0f} degrees at "
        f"{len(loads)} loads found none in any mode",
    )


def _searched(task: _Task, mode: int, loads: list[Load], shapes: Shapes, progress: Progress | None) -> list[RodBranch]:
    """Return the branches through the orbits of one mode at some loads, up to the first that is not whole."""
    pieces: list[RodBranch] = []
    try:
        for orbit in _starts(task, mode, loads, shapes):
            value = orbit.system.parameters[task.quantity]
            if not _is_on_one(pieces, value, orbit, task):
                report = shifted(progress, 2 * len(pieces) * task.steps, 2 * len(pieces) * task.steps)
                pieces.append(_followed(task, orbit, report))
                if any("continues" in end for end in pieces[-1].branch.ends):
                    break
    except KeyboardInterrupt:
        if not pieces:
            raise
    return pieces


def _starts(task: _Task, mode: int, loads: list[Load], shapes: Shapes) -> Iterator[PeriodicOrbit]:
    """Yield orbits of the mode, stable or not, at one load after the other."""
    motion = task.motions.first
    for load in loads:
        system = task.motions.system(task.quantity).with_parameters(
            **{task.quantity: float(getattr(load, task.quantity))}
        )
        equation = alone(motion.rod, load, shapes, mode, motion.indentation)
        for orbit in orbits_alone(equation):
            try:
                times, states, period = orbit_near(motion, load, ModeOrbit(mode, orbit, equation))
                in_modes = periodic_orbit(system, (times, states), period, tolerance=TOLERANCE)
            except ValueError:
                continue  # of one mode alone, not of two
            if _angle(motion, in_modes) > 0.1 * orbit.amplitude and not _beyond(motion, in_modes):  # not at rest
                yield in_modes


def _is_on_one(pieces: list[RodBranch], value: float, orbit: PeriodicOrbit, task: _Task) -> bool:
    """Return whether an orbit lies on a branch followed before."""
    angle = _angle(task.motions.first, orbit)
    for piece in pieces:
        if piece.turns != (orbit.collocation.turns or 1):
            continue
        x, y = piece.branch.values, piece.amplitude
        x, y = np.concatenate([[_or(piece.rests[0], x[0])], x, [_or(piece.rests[1], x[-1])]]), np.pad(y, 1)
        y[0], y[-1] = (0.0 if rest is not None else y[i] for rest, i in zip(piece.rests, (1, -2), strict=True))
        across = (x[:-1] - value) * (x[1:] - value) <= 0.0
        share = (value - x[:-1][across]) / np.where(x[1:] == x[:-1], 1.0, x[1:] - x[:-1])[across]
        there = y[:-1][across] + share * np.diff(y)[across]
        if (np.abs(there - angle) < _SAME * angle + 0.25 * np.abs(np.diff(y)[across])).any():
            return True
    return False


def _or(value: float | None, other: float) -> float:
    return other if value is None else value


def _angle(motion: LargeMotion, orbit: PeriodicOrbit) -> float:
    """Return the largest angle of an orbit in rad."""
    return largest(motion, orbit(orbit.period * np.arange(_INSTANTS) / _INSTANTS))


def _followed(task: _Task, start: PeriodicOrbit | Branch, progress: Progress | None) -> RodBranch:
    """Return the branch through an orbit, and what the rod does along it."""
    motion = task.motions.first
    branch = follow(
        start,
        {task.quantity: task.over},
        steps=task.steps,
        longest=task.longest,
        tolerance=TOLERANCE,
        until=partial(_leaves, motion),
        progress=progress,
    )
    seen = np.array([_seen(motion, orbit) for orbit in branch.orbits])
    special = np.array([_angle(motion, point.orbit) for point in branch.special_points])
    ends = [seen[:2, 0], seen[-2:, 0][::-1]]
    values = [branch.values[:2], branch.values[-2:][::-1]]
    rests = [
        _rest(x, y) if end.startswith("motion shrinks") else None
        for end, x, y in zip(branch.ends, values, ends, strict=True)
    ]
    return RodBranch(branch, seen[:, 0], seen[:, 1], seen[:, 2], special, (rests[0], rests[1]))


def _rest(values: Floats, angles: Floats) -> float | None:
    """Return where angles, the last one first, vanish, whose squares go like the parameter; None for one alone."""
    if len(values) < 2 or angles[0] == angles[1]:
        return None
    return float(values[0] - angles[0] ** 2 * (values[1] - values[0]) / (angles[1] ** 2 - angles[0] ** 2))


def _leaves(motion: LargeMotion, before: PeriodicOrbit, orbit: PeriodicOrbit) -> str:
    """Return why a branch is not followed to an orbit: it is beyond rest, or too large; "" where it is."""
    ((name, value),) = before.system.parameters.items()
    shares = np.arange(16) / 16.0
    if float((before(before.period * shares) * orbit(orbit.period * shares) / orbit.point.scale**2).sum()) <= 0.0:
        return f"motion shrinks to rest beyond {name} = {value:.6g}"
    reason = _beyond(motion, orbit)
    return f"{reason} beyond {name} = {value:.6g}" if reason else ""


def _beyond(motion: LargeMotion, orbit: PeriodicOrbit) -> str:
    """Return why the equations on the wall do not hold for an orbit, "" where they do."""
    angle, least_contact, _ = _seen(motion, orbit)
    if angle > LIMIT:
        return f"angles are larger than {math.degrees(LIMIT):.0f} degrees"
    weight = motion.rod.mass_per_length * motion.rod.effective_gravity
    return (
        f"{OFF_WALL}: it presses on it with less than a third of its weight"
        if least_contact < _PRESSED * weight
        else ""
    )


def _seen(motion: LargeMotion, orbit: PeriodicOrbit) -> tuple[float, float, float]:
    """Return the largest angle in rad, the least contact force in N/m, and the largest slope of an orbit."""
    ((name, value),) = orbit.system.parameters.items()
    motion = motion.under(motion.load.varied(cast(Quantity, name), value))
    times = orbit.period * np.arange(_INSTANTS) / _INSTANTS
    states = orbit(times)
    steep = np.abs(states[:, : motion.size] @ motion.shapes.slopes).max() * motion.rod.radial_clearance
    least_contact = float(motion.contact_force(times, states).min())
    return largest(motion, states), least_contact, float(steep) / motion.rod.length
