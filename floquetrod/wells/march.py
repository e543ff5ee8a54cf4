"""Strings marched up a well side by side, each with steps of its own, by an explicit Runge-Kutta method of order 8.

The method is that of Dormand and Prince with its dense output of order 7 (Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, II.5), with SciPy's coefficients.  A step ends at a station, where friction changes, at the
upper end, and where the string becomes a helix or ceases to be one: there its equation has another right side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod._util.roots import roots
from floquetrod.wells.arcs import Points
from floquetrod.wells.drag import Drag, Effort, Place, States, Strings
from floquetrod.wells.kernels.contact import LOCKED

Ints = NDArray[np.intp]

_SAFETY, _SHRINKS, _GROWS = 0.9, 0.2, 10.0  # of the next step (Hairer, Norsett and Wanner)
_AT_ONCE = 1e-12  # of a step: a string that changes its shape before does so where it is
_MOST_STEPS = 100_000  # of a string: a few hundred are usual


def up(drag: Drag, strings: Strings, depths: Floats, effort: Effort) -> States:
    """Return the states of strings at measured depths in m and at their upper ends, from those at their lower ends."""
    march = _March(drag, strings, np.unique(depths), effort)
    march.go()
    return States(march.wanted, march.noted, march.state)


class _March:
    """Strings on their way up: where each is, its y (n,) there, and what has been noted of it (m, n)."""

    def __init__(self, drag: Drag, strings: Strings, wanted: Floats, effort: Effort) -> None:
        size = strings.y.size
        self.drag, self.top, self.wanted = drag, strings.top, wanted
        self.tolerance, self.steps = np.full(size, effort.tolerance), np.full(size, effort.steps)
        self.depth = strings.bottom.copy()
        self.state = strings.y.copy()
        self.is_helix = np.zeros(size, bool)
        self.longest = np.full(size, math.inf)  # next step
        self.noted = np.full((wanted.size, size), math.nan)
        ends = np.unique(np.concatenate([drag.path.stations, drag.friction.depths]))
        self.ends = ends[(ends >= drag.path.start) & (ends <= drag.path.end)]  # of pieces of one arc and friction
        middle = 0.5 * (self.ends[:-1] + self.ends[1:])
        self.arc, self.friction = drag.path.arcs.at(middle).arc, drag.friction.at(middle)

    def go(self) -> None:
        """March all strings to their upper ends, or until their force is infinite."""
        moving = np.arange(self.top.size)
        self._enter(moving)
        for _ in range(_MOST_STEPS):
            is_locked = self.state[moving] >= LOCKED
            self._lock(moving[is_locked])
            moving = moving[~is_locked & (self.depth[moving] > self.top[moving])]
            if not moving.size:
                return
            self._advance(moving)
        raise RuntimeError(f"a string at {self.depth[moving[0]]:g} m takes too many steps")

    def _piece(self, strings: Ints) -> Ints:
        """Return the pieces that strings are in, or are about to enter from below."""
        return np.maximum(np.searchsorted(self.ends, self.depth[strings]) - 1, 0)

    def _enter(self, strings: Ints) -> None:
        """Let strings enter the pieces above them, where they may have another shape."""
        place = self._slopes(strings).place(self.depth[strings])
        self.is_helix[strings] = self.drag.is_helix(place, self.state[strings])
        self.longest[strings] = math.inf

    def _slopes(self, strings: Ints) -> _Slopes:
        piece = self._piece(strings)
        return _Slopes(self.drag, self.arc[piece], self.friction[piece], self.is_helix[strings])

    def _lock(self, strings: Ints) -> None:
        """Note the states of strings that are locked up, which hold all the way up."""
        for k in strings.tolist():
            above = (self.wanted >= self.top[k]) & (self.wanted <= self.depth[k])
            self.noted[above, k] = self.state[k]

    def _advance(self, moving: Ints) -> None:
        """Try a step of every string that moves, and take those that are accurate enough."""
        step = self._tried(moving)
        error = step.error(self.tolerance[moving])
        is_passing = step.is_passing
        is_taken = (error < 1.0) & ~is_passing
        factor = _SAFETY * np.maximum(error, 1e-30) ** -0.125
        factor = np.clip(factor, _SHRINKS, np.where(is_taken, _GROWS, 1.0))
        self.longest[moving] = step.length * np.where(is_passing, np.minimum(factor, 0.5), factor)
        if is_taken.any():
            taken = np.flatnonzero(is_taken)
            self._take(moving[taken], step if is_taken.all() else step.some(taken))

    def _tried(self, moving: Ints) -> _Step:
        """Return the next step of strings."""
        depth, piece = self.depth[moving], self._piece(moving)
        upper = np.maximum(self.ends[piece], self.top[moving])
        most = (self.ends[piece + 1] - self.ends[piece]) / self.steps[moving]
        length = np.minimum(self.longest[moving], most)
        is_last = length >= (1.0 - 1e-9) * (depth - upper)
        end = np.where(is_last, upper, depth - length)
        return _Step.of(self._slopes(moving), depth, end, is_last, self.state[moving])

    def _take(self, strings: Ints, step: _Step) -> None:
        """Move strings to the ends of their steps, or to where their shape changes on the way; note what is wanted."""
        first, last = np.searchsorted(self.wanted, step.end), np.searchsorted(self.wanted, step.depth, side="right")
        end, state, is_changing = step.end.copy(), step.new, step.is_changing
        curved = np.flatnonzero(is_changing | (last > first))
        if curved.size:
            part = step.some(curved)
            curve = part.curve()
            change = np.flatnonzero(is_changing[curved])
            if change.size:
                share = part.changes(curve, change)
                end[curved[change]] -= (share - 1.0) * part.length[change]
                state[curved[change]] = curve.at(share, change)
            self._note(strings[curved], part, curve, (np.searchsorted(self.wanted, end[curved]), last[curved]))
        self.depth[strings], self.state[strings] = end, state
        self.is_helix[strings[is_changing]] ^= True
        self._enter(strings[step.is_last & ~is_changing])

    def _note(self, strings: Ints, step: _Step, curve: _Curve, rows: tuple[Ints, Ints]) -> None:
        """Note the states in rows from the first to before the last, of each string its own."""
        number = np.maximum(rows[1] - rows[0], 0)
        which = np.repeat(np.arange(number.size), number)
        row = np.arange(which.size) + (rows[0] - np.cumsum(number) + number)[which]
        share = (step.depth[which] - self.wanted[row]) / step.length[which]
        self.noted[row, strings[which]] = curve.at(share, which)


@dataclass(frozen=True, eq=False)
class _Slopes(ByContent):
    """The right side of the equations of strings, each on its arc with its friction and shape."""

    drag: Drag
    arc: Ints
    friction: Floats
    is_helix: Bools

    def some(self, i: Ints) -> _Slopes:
        """Return that of some strings."""
        return replace(self, arc=self.arc[i], friction=self.friction[i], is_helix=self.is_helix[i])

    def place(self, depth: Floats) -> Place:
        """Return the well at measured depths (..., n)."""
        arcs = self.drag.path.arcs
        return Place.at(Points(arcs, self.arc, depth - arcs.start[self.arc]))

    def at(self, place: Place, state: Floats) -> Floats:
        """Return d/ds of y at a place of each string."""
        return self.drag.slopes(place, self.friction, state, self.is_helix)


@dataclass(frozen=True, eq=False)
class _Step(ByContent):
    """A step up of n strings: its ends, the states there, and minus the slopes on the way (13, n).

    ``is_last`` says whether it is the last in its piece.
    """

    slopes: _Slopes
    depth: Floats
    end: Floats
    is_last: Bools
    old: Floats
    new: Floats
    rises: Floats

    @classmethod
    def of(cls, slopes: _Slopes, depth: Floats, end: Floats, is_last: Bools, old: Floats) -> _Step:
        """Return a step from a state."""
        from scipy.integrate import DOP853

        rises = np.empty((13, *old.shape))
        state, length = old, depth - end
        places = slopes.place(depth - np.append(DOP853.C, 1.0)[:, None] * length)
        for k, row in enumerate([*DOP853.A[1:], DOP853.B, None]):
            rises[k] = -slopes.at(Place(*(each[k] for each in places)), state)
            if row is not None:
                state = old + length * _sum(row[: k + 1], rises)
        return cls(slopes, depth, end, is_last, old, state, rises)

    @property
    def length(self) -> Floats:
        """How far in m."""
        return self.depth - self.end

    def some(self, i: Ints) -> _Step:
        """Return the step of some strings."""
        columns = self.old[i], self.new[i], self.rises[:, i]
        return _Step(self.slopes.some(i), self.depth[i], self.end[i], self.is_last[i], *columns)

    def error(self, tolerance: Floats) -> Floats:
        """Return the estimated error over the tolerance, relative and absolute, as Hairer, Norsett and Wanner do."""
        from scipy.integrate import DOP853

        scale = tolerance * (1.0 + np.maximum(np.abs(self.old), np.abs(self.new)))
        fifth, third = ((_sum(each, self.rises) / scale) ** 2 for each in (DOP853.E5, DOP853.E3))
        under = np.sqrt(np.maximum(fifth + 0.01 * third, 1e-300))
        return np.asarray(self.length * fifth / under)

    @cached_property
    def is_changing(self) -> Bools:
        """Whether strings that are not locked up have another shape at the end than it is taken to be."""
        wants = self.slopes.drag.is_helix(self.slopes.place(self.end), self.new)
        return np.asarray((wants != self.slopes.is_helix) & (self.new < LOCKED))

    @property
    def is_passing(self) -> Bools:
        """Whether strings have another shape half way, by a cubic, and their own again at the end."""
        middle = 0.5 * (self.old + self.new) + 0.125 * self.length * (self.rises[0] - self.rises[12])
        is_helix = self.slopes.drag.is_helix(self.slopes.place(0.5 * (self.depth + self.end)), middle)
        return np.asarray((is_helix != self.slopes.is_helix) & (middle < LOCKED) & ~self.is_changing)

    def curve(self) -> _Curve:
        """Return the solution within the step."""
        from scipy.integrate import DOP853

        rises = np.concatenate([self.rises, np.empty((3, *self.old.shape))])
        places = self.slopes.place(self.depth - DOP853.C_EXTRA[:, None] * self.length)
        for k, row in enumerate(DOP853.A_EXTRA):
            state = self.old + self.length * _sum(row[: 13 + k], rises)
            rises[13 + k] = -self.slopes.at(Place(*(each[k] for each in places)), state)
        change, first, last = self.new - self.old, self.length * rises[0], self.length * rises[12]
        higher = [self.length * _sum(row, rises) for row in DOP853.D]
        return _Curve(self.old, np.array([change, first - change, 2.0 * change - first - last, *higher]))

    def changes(self, curve: _Curve, i: Ints) -> Floats:
        """Return the shares of the step after which some strings, whose shape changes, do so."""
        some = self.some(i)

        def wants(end: Floats, j: Ints) -> Floats:
            place = some.slopes.some(j).place(some.depth[j] - (end - 1.0) * some.length[j])
            return some.slopes.drag.wants_helix(place, curve.at(end - 1.0, i[j]))

        # From 1 to 2, so that the beginning is found to rounding of a step and no closer.
        every, begin, end = np.arange(i.size), np.ones(i.size), np.full(i.size, 2.0)
        at_begin, at_end = wants(begin, every), wants(end, every)
        # Where it has just changed rounding may put it on the other side: it is on the side of its shape.
        is_there = at_begin * at_end < -1e-9 * at_end**2
        found = roots(wants, begin, end, np.where(is_there, at_begin, -at_end), at_end) - 1.0
        return np.where(found < _AT_ONCE, 0.0, found)


class _Curve(NamedTuple):
    """States (n,) at the beginning of a step, and the coefficients (7, n) of what is added to them on the way."""

    old: Floats
    parts: Floats

    def at(self, share: Floats, i: Ints) -> Floats:
        """Return the states of strings i after shares of the step."""
        added = np.zeros(i.size)
        for k, part in enumerate(self.parts[::-1, i]):
            added = (added + part) * (share if k % 2 == 0 else 1.0 - share)
        return np.asarray(self.old[i] + added)


def _sum(weights: Floats, rises: Floats) -> Floats:
    """Return the weighted sum (n,) of as many slopes as there are weights."""
    return np.asarray(weights @ rises[: len(weights)])
