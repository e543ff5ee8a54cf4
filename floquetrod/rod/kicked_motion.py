"""Kicks to a rod that is stable at rest: which come to rest, and which lead to a large motion, by a scan."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod.rod.answers.safe_kick import SafeKick
from floquetrod.rod.large_orbits import alone, beam_functions, indentation_of, orbits_alone, require_possible
from floquetrod.rod.loads.load import AnyLoad, Load, require_load
from floquetrod.rod.mode_equations.large_motion import Shapes
from floquetrod.rod.mode_equations.one_mode import LARGEST, LIMIT, OneMode, Orbit
from floquetrod.rod.model.data import RodData
from floquetrod.rod.modes.mode_model import ModeModel

_SPEEDS, _PHASES = 24, 16  # tried at a time
_ROUNDS = 2  # of speeds, each between two neighbours of the one before
_DECAYS = 9.0  # of free motion, after which a kicked mode has settled: e^-9
_MOST_PERIODS = 3000  # of the load, that a mode is given to settle (a choice)
_RESTS = 0.3  # of the smallest large orbit: motion that ends smaller has come to rest


class _Scan(NamedTuple):
    """Kicks of one mode in rad/s: the largest up to which all came to rest, the least that did not, and its phase."""

    safe: float
    escapes: float
    phase: float


def safe_kick(model: ModeModel, given: AnyLoad, indentation: float) -> SafeKick:
    """Return the kicks after which a stable rod comes to rest, by a scan; see `floquetrod.Rod.safe_kick`."""
    indentation = indentation_of(indentation)
    load, rod = require_load("load", given), model.rod
    require_possible(rod, load)
    _require_returning(model, load)
    shapes = Shapes.of(rod, load, beam_functions(rod, None))
    best: tuple[_Scan, int, OneMode, Orbit] | None = None
    safe, safe_mode, tried = math.inf, 0, 0
    for mode in sorted(set(shapes.numbers.tolist())):
        equation = alone(rod, load, shapes, mode, indentation)
        large = [orbit for orbit in orbits_alone(equation) if orbit.is_stable and orbit.amplitude <= LIMIT]
        if not large:
            continue
        scan = _scanned(equation, large[0])
        tried += _ROUNDS * _SPEEDS * _PHASES
        own = scan.safe * equation.peak * rod.radial_clearance
        safe, safe_mode = min((safe, safe_mode), (own, mode))
        if best is None or scan.escapes * equation.peak < best[0].escapes * best[2].peak:
            best = scan, mode, equation, large[0]
    if best is None or math.isinf(best[0].escapes):
        return SafeKick(rod, load, safe, safe_mode, math.inf, 0, 0.0, math.inf, 0.0, tried)
    scan, mode, equation, orbit = best
    speed = scan.escapes * equation.peak
    swing = speed / math.sqrt(max(float(equation.stiffness(0.0)), load.frequency**2 * 1e-6))
    kick = speed * rod.radial_clearance
    return SafeKick(rod, load, safe, safe_mode, kick, mode, scan.phase, swing, orbit.amplitude, tried)


def _require_returning(model: ModeModel, load: Load) -> None:
    """Raise ValueError for a rod that comes to rest after no kick."""
    rod: RodData = model.rod
    if rod.damping_rate == 0.0:
        raise validate.wrong_value("damping_rate", "must be greater than 0: without it no kick comes to rest")
    rest = model.verdict(load, None, 0.0, None)
    if rest.status != "stable":
        raise validate.wrong_value(
            "load", f"must leave the rod stable at rest, got one under which it is {rest.status}"
        )


def _scanned(equation: OneMode, large: Orbit) -> _Scan:
    """Return a scan over speeds and phases, finer between the last safe speed and the next."""
    low, high = 0.0, LARGEST / equation.peak * equation.fastest
    safe, escapes, phase = low, math.inf, 0.0
    for _ in range(_ROUNDS):
        speeds = low + (high - low) * np.arange(1, _SPEEDS + 1) / _SPEEDS
        ends = _comes_to_rest(equation, speeds, large)
        bad = np.flatnonzero(~ends.all(axis=1))
        if not bad.size:
            return _Scan(float(speeds[-1]), escapes, phase)
        first = int(bad[0])
        escapes = float(speeds[first])
        phase = 2.0 * math.pi * int(np.flatnonzero(~ends[first])[0]) / _PHASES
        safe = float(speeds[first - 1]) if first else low
        low, high = safe, escapes
    return _Scan(safe, escapes, phase)


def _comes_to_rest(equation: OneMode, speeds: Floats, large: Orbit) -> Bools:
    """Return which kicks come to rest, (speeds, phases)."""
    load, rod = equation.motion.load, equation.motion.rod
    period = 2.0 * math.pi / load.frequency
    start = np.tile(period * np.arange(_PHASES) / _PHASES, len(speeds))
    v = np.repeat(speeds, _PHASES)
    a, most = np.zeros_like(v), np.zeros_like(v)
    moving = np.arange(v.size)
    with np.errstate(all="ignore"):
        for _ in range(min(_MOST_PERIODS, math.ceil(_DECAYS / rod.damping_rate / period))):
            a[moving], v[moving], most[moving] = equation.marched(a[moving], v[moving], 1, start[moving])
            still = most[moving] * equation.peak > 0.05 * _RESTS * large.amplitude
            moving = moving[still & np.isfinite(a[moving])]
            if not moving.size:
                break
    return np.asarray(most * equation.peak < _RESTS * large.amplitude).reshape(len(speeds), _PHASES)
