"""Searches among loads with noise, by samples and halving: where verdicts in mean square change, and least values."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod._util.roots import bisected
from floquetrod.floquet.status import STABLE
from floquetrod.rod.answers.intervals import Search
from floquetrod.rod.answers.margins import Edge
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.modes.mode_model import ModeModel

AT_ONCE = 16  # samples examined before a change is searched for (a choice)
HALVINGS = 36  # of the distance of two samples (a choice)
_MOST_HALVINGS = 60  # of a search for the least value


def stable_at(model: ModeModel, search: Search, places: Floats, progress: Progress | None = None) -> Bools:
    """Return whether loads along a quantity are stable."""
    there = model.under(search.load)
    loads = Loads.along(search.load, search.varied, places)
    return np.asarray(there.status(loads, search.growth_tolerance, None, progress) == STABLE)


class Effort(NamedTuple):
    """How many verdicts a search takes: at samples, and to halve the distance of two; of so many seconds each."""

    samples: int
    halvings: int
    each: float = 0.0

    @property
    def seconds(self) -> float:
        """What it takes, as estimated."""
        return (self.samples + self.halvings) * self.each


def changes(model: ModeModel, search: Search, places: Floats, stable: Bools, halvings: int = HALVINGS) -> Floats:
    """Return the last stable place before each change of the verdicts of neighbouring places."""
    at = np.flatnonzero(stable[1:] != stable[:-1])
    near, far = places[at], places[at + 1]
    good, bad = np.where(stable[at], near, far), np.where(stable[at], far, near)
    return bisected(partial(stable_at, model, search), good, bad, halvings)[0]


def first_change(
    model: ModeModel,
    search: Search,
    places: Floats,
    begins: bool,
    *,
    known: bool = False,
    at_once: int = AT_ONCE,
    halvings: int = HALVINGS,
    refused: type[Exception] | tuple[()] = (),
    progress: Progress | None = None,
) -> Edge:
    """Return where a verdict first changes along places: the last stable place next to that.

    ``known`` where the first place has the verdict that it begins with; at an error ``refused`` the search ends.
    """
    distance = abs(float(places[1] - places[0]))
    for start in range(int(known), len(places), at_once):
        near, some = float(places[max(0, start - 1)]), places[start : start + at_once]
        try:
            stable = np.append(begins, stable_at(model, search, some))
            if (stable != begins).any():
                to_first = slice(0, int((stable != begins).argmax()) + 1)
                at = float(changes(model, search, np.append(near, some)[to_first], stable[to_first], halvings)[0])
                return Edge(at, at, distance)
        except refused:
            return Edge(None, near, distance)
        if progress is not None:
            progress(min(start + at_once, len(places)), len(places))
    return Edge(None, float(places[-1]), distance)


def least(holds: Callable[[float], bool], start: float, limit: float, digits: float) -> tuple[float, float]:
    """Return two values, relatively so close, between which a statement that is wrong at zero becomes true.

    Tried from ``start`` up, each time four times as much; the second is infinite where it stays wrong up to a limit.
    """
    low, high = 0.0, start
    while not holds(high):
        low, high = high, 4.0 * high
        if high > limit:
            return low, math.inf
    for _ in range(_MOST_HALVINGS):
        if high - low <= digits * high:
            break
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return low, high
