"""Searches among loads with noise: where verdicts in mean square change, what damping and how much noise it takes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod.floquet.systems.many import STABLE
from floquetrod.rod.answers.intervals import Search
from floquetrod.rod.loads.load import Load, Loads, largest_density, scaled_noise
from floquetrod.rod.mode_equations.noisy_modes import NoisyModes
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.contact import constants_under
from floquetrod.rod.modes.mode_model import ModeModel

_CLOSER, _ROUNDS = 17, 9  # places between two samples in each round of a search: to 4e-11 of their distance
_STRONGEST = 10.0  # damping rate that is tried, in terms of the frequency of the load (a choice)
_LARGEST = 1e9  # density that is tried, in terms of the limit of high modes (a choice)
_DAMPINGS = 60  # halvings at most of what damping stabilises


def is_stable_under(model: ModeModel, load: Load, growth_tolerance: float) -> bool:
    """Return whether a rod is seen to be stable in mean square under one load."""
    if NoisyModes(constants_under(model.rod, load.mean), load).growth_beyond(load) > growth_tolerance:
        return False
    return bool(model.under(load).status(Loads((1,), *Loads.single(load).flat), growth_tolerance)[0] == STABLE)


def stable_at(model: ModeModel, search: Search, places: Floats, progress: Progress | None = None) -> Bools:
    """Return whether loads along a quantity are stable."""
    there = model.under(search.load)
    loads = Loads.along(search.load, search.varied, places)
    return np.asarray(there.status(loads, search.growth_tolerance, None, progress) == STABLE)


def edge(model: ModeModel, search: Search, inside: float, outside: float) -> float:
    """Return where the answer of `stable_at` changes between two values that it tells apart, within the first."""
    for _ in range(_ROUNDS):
        places = np.linspace(inside, outside, _CLOSER)
        stable = stable_at(model, search, places)
        differ = np.flatnonzero(stable != stable[0])
        if not differ.size:
            break
        after = int(differ[0])
        if places[after] in (inside, outside) and places[after - 1] in (inside, outside):
            break
        inside, outside = float(places[after - 1]), float(places[after])
    return float(inside)


def damping_required(model: ModeModel, load: Load, growth_tolerance: float) -> float:
    """Return the least damping rate in 1/s, to nine digits, above which a load is stable, as far as tried.

    Infinite where the mean force alone buckles a mode, and where none up to ten times the frequency of the load is.
    """
    last, _ = constants_under(model.rod, load.mean).modes_needed(load, growth_tolerance)
    modes = NoisyModes(constants_under(model.rod, load.mean), load)
    still = modes.parts(Loads((1,), *Loads.single(load).flat), range(1, last + 1))
    if still.squared.min() <= 0.0:
        return math.inf

    def is_stable(rate: float) -> bool:
        return is_stable_under(replace(model, rod=model.rod.replace(damping_rate=rate)), load, growth_tolerance)

    if is_stable(0.0):
        return 0.0
    low, high = 0.0, 1e-6 * load.frequency
    while not is_stable(high):
        low, high = high, 4.0 * high
        if high > _STRONGEST * load.frequency:
            return math.inf
    for _ in range(_DAMPINGS):
        if high - low <= 1e-9 * high:
            break
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_stable(middle) else (middle, high)
    return high


def critical_noise(model: ModeModel, load: Load, growth_tolerance: float) -> float:
    """Return the largest factor of the noise of a load at which it is stable in mean square, to 1e-10."""

    def is_stable(factor: float) -> bool:
        return is_stable_under(model, replace(load, noise=scaled_noise(load.noise, factor)), growth_tolerance)

    constants = mode_constants(model.rod)
    largest = largest_density(load.noise, 0.0)
    bound = 8.0 * model.rod.damping_rate * constants.bending / constants.per_newton**2
    low, high = 0.0, bound / largest or 1.0
    while is_stable(high):
        low, high = high, 4.0 * high
        if high * largest > _LARGEST * bound:
            return math.inf
    while high - low > 1e-10 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(middle) else (low, middle)
        if low == 0.0 and high * largest <= bound / _LARGEST:
            raise wrong_value("load", "must be stable without noise to have a critical one, got one that is not")
    return low
