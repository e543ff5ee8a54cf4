"""The steady motion of a rod under a load: which mode, its orbit in the modes that matter, and its stability."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.equations import NonlinearSystem, PeriodicSystem, sampling
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.status import Status
from floquetrod.orbits import NoOrbitError, PeriodicOrbit, periodic_orbit
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.steady_motion import SteadyMotion
from floquetrod.rod.large_orbits import (
    MOST_HALF_WAVES,
    ModeOrbit,
    beam_functions,
    candidates,
    indentation_of,
    orbits_of,
    require_possible,
)
from floquetrod.rod.loads.load import AnyLoad, Load, Quantity, require_load
from floquetrod.rod.mode_equations.large_motion import LargeMotion, Shapes
from floquetrod.rod.mode_equations.one_mode import LIMIT
from floquetrod.rod.model.data import RodData
from floquetrod.rod.modes.mode_model import ModeModel

NEAR = ((0, 0), (6, 2), (12, 6))
"""Modes on either side of the one that moves, and of the one three times as short, taken in turn: the last answers."""

TOLERANCE = 1e-5  # of the orbit
_KEPT = 8  # loads: those of differences, and one to compare with
_INSTANTS = 512  # of a period, at which a motion is examined: the largest angle is 2e-5 low at most


@dataclass(frozen=True)
class _Function:
    """The rates of a motion as a `NonlinearSystem` calls them, at one instant or many, by quantities of the load."""

    motions: Motions
    derive: bool = False

    def __call__(self, t: Any, x: Any, **changed: float) -> Floats:
        """Return rates (n, ...) or their derivatives (n, n, ...) of states (n, ...)."""
        states, motion = np.atleast_2d(np.asarray(x).T), self.motions.at(**changed)
        times = np.broadcast_to(t, len(states))
        values = motion.jacobians(times, states) if self.derive else motion.rates(times, states)
        return values[0] if np.ndim(x) == 1 else np.moveaxis(values, 0, -1)


@dataclass(frozen=True)
class Motions:
    """Motion in some shapes under loads that differ in one quantity or none; the last few are kept."""

    first: LargeMotion
    kept: dict[float, LargeMotion] = field(default_factory=dict, compare=False)

    def at(self, **changed: float) -> LargeMotion:
        """Return the motion under the load with a quantity changed."""
        for name, value in changed.items():
            if value not in self.kept:
                while len(self.kept) >= _KEPT:
                    del self.kept[next(iter(self.kept))]
                self.kept[value] = self.first.under(self.first.load.varied(cast(Quantity, name), value))
            return self.kept[value]
        return self.first

    def system(self, quantity: Quantity | None = None) -> NonlinearSystem:
        """Return the equations, with a quantity of the load as their parameter, or with none."""
        load = self.first.load
        parameters: dict[str, float] = {} if quantity is None else {quantity: float(getattr(load, quantity))}
        period = "2*pi/frequency" if quantity == "frequency" else 2.0 * math.pi / load.frequency
        return NonlinearSystem(_Function(self), _Function(self, True), period, parameters)


def steady_motion(model: ModeModel, given: AnyLoad, mode: int | None, indentation: float) -> SteadyMotion:
    """Return the steady motion under a load; see `floquetrod.Rod.steady_motion`."""
    load, rod = require_load("load", given), model.rod
    indentation = indentation_of(indentation)
    if mode is not None:
        mode = validate.integer("mode", mode, 1, MOST_HALF_WAVES, "half waves of the motion to look at")
    require_possible(rod, load)
    if load.amplitude == 0.0:  # any frequency is that of a constant force: one near those of the rod
        load = load.varied("frequency", rod.pendulum_frequency)
    shapes = Shapes.of(rod, load, beam_functions(rod, mode))
    rest = model.verdict(load, None, 0.0, None)
    beyond: SteadyMotion | None = None
    for orbit_alone in orbits_of(rod, load, shapes, candidates(rest, shapes, mode), indentation):
        motion = _motion(rod, load, rest, shapes, orbit_alone, indentation)
        if motion.amplitude <= LIMIT:
            return motion
        beyond = beyond or motion
        if rest.status != "stable":
            break
    return _resting(rod, load, rest, mode, beyond)


def _resting(
    rod: RodData, load: Load, rest: RodStability, mode: int | None, beyond: SteadyMotion | None
) -> SteadyMotion:
    """Return rest, where it is stable; ValueError where the rod moves further than is examined, as in ``beyond``."""
    limit = f"{math.degrees(LIMIT):.0f} degrees"
    size = "" if beyond is None else f"{math.degrees(beyond.amplitude):.4g} degrees in mode {beyond.mode}"
    if rest.status == "unstable" and (mode is None or mode in rest.unstable_modes):
        where = f"by {size}, further than {limit}" if size else f"further than {limit}, or in no one mode"
        raise validate.wrong_value("load", f"makes the rod move {where}, where it leaves its wall; simulate it")
    weight = rod.mass_per_length * rod.effective_gravity
    which = "in any mode alone" if mode is None else f"in mode {mode}"
    note = f"a search up to {limit} found no periodic motion {which}"
    if size:
        note += f"; a kick may lead to one of {size}, where the equations on the wall do not hold: simulate it"
    is_stable = rest.status == "stable"
    return SteadyMotion(
        rod, load, 0, 0.0, 0.0, None, (), rest.status, is_stable, (weight, weight), None, (0.0, 0.0), note
    )


def _motion(
    rod: RodData, load: Load, rest: RodStability, shapes: Shapes, orbit_alone: ModeOrbit, indentation: float
) -> SteadyMotion:
    """Return the motion near an orbit of one mode, with all modes that matter."""
    # The orbit of one mode is continued into larger and larger sets of modes (`NEAR`), each orbit the start of the
    # next; the last one is the answer, and the change of the largest angle from the last set but one its error.
    # Contact force and shortening are evaluated at `_INSTANTS` of a period, (instants, nodes) and (instants,).
    sets = [chosen(shapes, orbit_alone.mode, *near) for near in NEAR]
    every: list[PeriodicOrbit] = []
    for i, taken in enumerate(sets):
        fewer = (every[-1], sets[i - 1], taken) if every else None
        every.append(_orbit(LargeMotion(rod, load, shapes.some(taken), indentation), orbit_alone, fewer))
    first, orbit = every[-2:]
    many, motion = sets[-1], LargeMotion(rod, load, shapes.some(sets[-1]), indentation)
    times = orbit.period * np.arange(_INSTANTS) / _INSTANTS
    states = orbit(times)
    amplitude = largest(motion, states)
    before = largest(LargeMotion(rod, load, shapes.some(sets[-2])), first(times))
    contact = motion.contact_force(times, states)
    shorter = motion.shortening(states)
    lift_off = float(motion.shapes.nodes[int(contact.min(axis=0).argmin())]) * rod.length
    least_contact = float(contact.min())
    status, note = _judged(rod, load, shapes, many, orbit, indentation)
    if rod.damping_rate == 0.0:
        note = f"{note}; without damping motion never settles: it beats about this orbit".lstrip("; ")
    return SteadyMotion(
        rod,
        load,
        orbit_alone.mode,
        amplitude,
        abs(amplitude - before) + orbit.error * amplitude + _SHORT * amplitude,
        orbit,
        tuple(motion.shapes.numbers.tolist()),
        status,
        rest.status == "stable",
        (least_contact, float(contact.max())),
        lift_off if least_contact < 0.0 else None,
        (float(shorter.min()), float(shorter.max())),
        note,
    )


_SHORT = 2e-5  # part of the largest angle, by which it is low where it falls between instants and places examined


def largest(motion: LargeMotion, states: Floats) -> float:
    """Return the largest angle in rad."""
    return float(np.abs(motion.angles(states)).max())


def chosen(shapes: Shapes, mode: int, near: int, shorter: int) -> Any:
    """Return which modes to take: neighbours, and those three times as short, of one symmetry where there is one."""
    numbers = shapes.numbers
    index = numbers.tolist().index(mode)
    alike = shapes.even == shapes.even[index]
    wanted = (np.abs(numbers - mode) <= near) | (np.abs(numbers - 3 * mode) <= shorter)
    return np.flatnonzero(alike & wanted)


def orbit_near(motion: LargeMotion, load: Load, orbit_alone: ModeOrbit) -> tuple[Floats, Floats, float]:
    """Return times, states of a motion and the period of an orbit of one of its modes."""
    period, record = orbit_alone.orbit.turns * 2.0 * math.pi / load.frequency, orbit_alone.orbit.states
    index = motion.shapes.numbers.tolist().index(orbit_alone.mode)
    states = np.zeros((len(record) + 1, 2 * motion.size))
    states[:-1, [index, motion.size + index]] = record
    states[-1] = states[0]
    return np.linspace(0.0, period, len(states)), states, period


def _orbit(motion: LargeMotion, orbit_alone: ModeOrbit, before: Any) -> PeriodicOrbit:
    """Return the orbit of a motion, by Newton's method from an orbit of one mode, or of fewer modes, ``before``."""
    n = motion.size
    times, states, period = orbit_near(motion, motion.load, orbit_alone)
    if before is not None:
        orbit, few, many = before
        places = np.searchsorted(many, few)
        states[:, np.concatenate([places, n + places])] = orbit(times)
        states[-1] = states[0]
    try:
        return periodic_orbit(Motions(motion).system(), (times, states), period, tolerance=TOLERANCE)
    except NoOrbitError as error:
        raise validate.wrong_value(
            "load", f"leads to no periodic motion near that of mode {orbit_alone.mode}: {error}; simulate it"
        ) from None


def _judged(
    rod: RodData, load: Load, shapes: Shapes, many: Any, orbit: PeriodicOrbit, indentation: float
) -> tuple[Status, str]:
    """Return whether the orbit is stable against all modes, and what to note."""
    others = np.setdiff1d(np.arange(len(shapes.numbers)), many)
    alike = shapes.even[others] == shapes.even[many[0]]
    own = _beside(rod, load, shapes, (many, others[alike], True), orbit, indentation)
    if own.status != "stable" or alike.all():
        return own.status, ""
    apart = _beside(rod, load, shapes, (many, others[~alike], False), orbit, indentation)
    return apart.status, "" if apart.status == "stable" else f"{apart.status} against modes of the other symmetry"


def _beside(
    rod: RodData, load: Load, shapes: Shapes, modes: tuple[Any, Any, bool], orbit: PeriodicOrbit, indentation: float
) -> SystemStability:
    """Return the verdict on small motion beside an orbit in modes that take no part in it, or together with its own."""
    many, group, together = modes
    motion = LargeMotion(rod, load, shapes.some(np.concatenate([many, group])), indentation)
    n, own = motion.size, len(many)
    moving = np.concatenate([np.arange(own), n + np.arange(own)])
    rows = np.arange(2 * n) if together else np.setdiff1d(np.arange(2 * n), moving)
    units = np.concatenate([np.ones(n), np.sqrt(np.maximum(motion.shapes.frequencies, load.frequency**2))])

    def derivatives(times: Floats, wider: float = 1.0) -> Floats:
        states = np.zeros((len(times), 2 * n))
        states[:, moving] = wider * orbit(times)
        return np.asarray((motion.jacobians(times, states) * units / units[:, None])[:, rows[:, None], rows])

    instants = orbit.period / 16.0 * np.arange(16.0)
    change = np.abs(derivatives(instants, 1.001) - derivatives(instants)).max() * 1e3
    coefficients = sampling.smooth(derivatives, orbit.period, math.inf)
    error = coefficients.error + 2.0 * float(change) * orbit.error
    return stability(PeriodicSystem.from_pieces(coefficients.pieces, coefficient_error=error))
