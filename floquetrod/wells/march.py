"""Strings marched up a well side by side, each with its own steps, by an explicit Runge-Kutta method of order 8.

By the method of Dormand and Prince with its dense output of order 7 (Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, II.5), with SciPy's coefficients.  A step ends at a station, where friction changes, at the
upper end, where sections meet, where the bore changes, and where the string becomes a helix or ceases to be one: there
its equation has another right side.  A helix presses harder, so that a short one may grow until it locks the string up:
no step passes over one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.content import ByContent
from floquetrod._util.roots import largest, roots
from floquetrod.wells.drag import Drag, Fineness, Strings, WellGeometry
from floquetrod.wells.kernels.wall_contact import LOCKED
from floquetrod.wells.minimum_curvature import Points

Ints = NDArray[np.intp]

_SAFETY, _SHRINKS, _GROWS = 0.9, 0.2, 10.0  # of the next step (Hairer, Norsett and Wanner)
_AT_ONCE = 1e-12  # share of a step: a change of shape before it is one at its beginning
_MOST_STEPS = 100_000  # of a string: a few hundred are usual
_SAMPLES = 16  # of a step in which a helix may begin or end (a choice)
_SECTIONS = 16  # of the bracket of a largest value: to 5e-4 of it
_TOUCHES = 1e-9  # of the terms of `helix_margin`: so little is rounding


def up(drag: Drag, strings: Strings, depths: Floats, fineness: Fineness) -> tuple[Floats, Floats, Floats]:
    """Return y of strings at increasing measured depths in m, (m, n), NaN beyond their ends, and at upper ends (n,).

    And where j + 1 sections meet, from the lowest up, (j, n), NaN where they do not in the well.
    """
    march = _March(drag, strings, depths, fineness)
    march.go()
    return march.noted, march.state, march.joint_y


class _March:
    """Strings on their way up: their depths, their y (n,) there, and y noted at the wanted depths (m, n)."""

    def __init__(self, drag: Drag, strings: Strings, wanted: Floats, fineness: Fineness) -> None:
        size = strings.y.size
        self.drag, self.top, self.wanted = drag, strings.top, wanted
        self.tolerance, self.steps = np.full(size, fineness.tolerance), np.full(size, fineness.steps)
        self.depth = strings.bottom.copy()
        self.state = strings.y.copy()
        self.is_helix = np.zeros(size, bool)
        self.longest = np.full(size, math.inf)  # next step
        self.noted = np.full((wanted.size, size), math.nan)
        self.ends = drag.edges  # of pieces of one arc, friction and bore
        middle = 0.5 * (self.ends[:-1] + self.ends[1:])
        self.arc, self.friction = drag.path.arcs.at(middle).arc, drag.friction.at(middle)
        self.section, self.meets = np.zeros(size, np.intp), np.full(size, -math.inf)  # depth of its upper end
        self.joint_y = np.empty((0, size))
        if drag.assembly is not None:
            self.bore, inner = drag.assembly.bore_at(middle), drag.assembly.inner
            self.joints = np.vstack([strings.bottom - inner[:, None], self.meets])
            self.joint_y = np.full((inner.size, size), math.nan)

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
        """Return the pieces of strings, on an edge the piece above."""
        return np.maximum(np.searchsorted(self.ends, self.depth[strings]) - 1, 0)

    def _enter(self, strings: Ints) -> None:
        """Move strings into the pieces above them, where they may have another shape."""
        if self.joint_y.size:
            section = (self.joints[:, strings] >= self.depth[strings]).sum(axis=0)
            k, i = np.nonzero(self.joints[:-1, strings] == self.depth[strings])
            self.joint_y[k, strings[i]] = self.state[strings[i]]
            self.section[strings], self.meets[strings] = section, self.joints[section, strings]
        slopes = self._slopes(strings)
        geometry = slopes.place(self.depth[strings])
        self.is_helix[strings] = slopes.drag.is_helix(geometry, self.state[strings])
        self.longest[strings] = math.inf

    def _slopes(self, strings: Ints) -> _Slopes:
        piece, drag = self._piece(strings), self.drag
        if drag.assembly is not None:
            drag = drag.within(self.section[strings], self.bore[piece])
        return _Slopes(drag, self.arc[piece], self.friction[piece], self.is_helix[strings])

    def _lock(self, strings: Ints) -> None:
        """Note the states of locked strings, which are the same all the way up."""
        for k in strings.tolist():
            above = (self.wanted >= self.top[k]) & (self.wanted <= self.depth[k])
            self.noted[above, k] = self.state[k]
            if self.joint_y.size:
                above = (self.joints[:-1, k] >= self.top[k]) & (self.joints[:-1, k] <= self.depth[k])
                self.joint_y[above, k] = self.state[k]

    def _advance(self, moving: Ints) -> None:
        """Try a step of every string in ``moving``, and take the accurate ones."""
        step = self._tried(moving)
        error = step.error(self.tolerance[moving])
        is_taken = error < 1.0
        factor = _SAFETY * np.maximum(error, 1e-30) ** -0.125
        self.longest[moving] = step.length * np.clip(factor, _SHRINKS, np.where(is_taken, _GROWS, 1.0))
        if is_taken.any():
            taken = np.flatnonzero(is_taken)
            self._take(moving[taken], step if is_taken.all() else step.some(taken))

    def _tried(self, moving: Ints) -> _Step:
        """Return the next step of strings."""
        depth, piece = self.depth[moving], self._piece(moving)
        upper = np.maximum(np.maximum(self.ends[piece], self.top[moving]), self.meets[moving])
        most = (self.ends[piece + 1] - self.ends[piece]) / self.steps[moving]
        length = np.minimum(self.longest[moving], most)
        is_last = length >= (1.0 - 1e-9) * (depth - upper)
        end = np.where(is_last, upper, depth - length)
        return _Step.of(self._slopes(moving), depth, end, is_last, self.state[moving])

    def _take(self, strings: Ints, step: _Step) -> None:
        """Move strings to the ends of their steps, or to their next change of shape; note y at wanted depths."""
        first, last = np.searchsorted(self.wanted, step.end), np.searchsorted(self.wanted, step.depth, side="right")
        end, state, is_changing = step.end.copy(), step.new, np.zeros(strings.size, bool)
        curved = np.flatnonzero(step.may_change | (last > first))
        if curved.size:
            substep = step.some(curved)
            curve = substep.curve()
            share = substep.changes(curve)
            change = np.flatnonzero(np.isfinite(share))
            if change.size:
                is_changing[curved[change]] = True
                end[curved[change]] -= (share[change] - 1.0) * substep.length[change]
                state[curved[change]] = curve.at(share[change], change)
            self._note(strings[curved], substep, curve, (np.searchsorted(self.wanted, end[curved]), last[curved]))
        self.depth[strings], self.state[strings] = end, state
        self.is_helix[strings[is_changing]] ^= True
        enters = step.is_last & ~is_changing
        if self.joint_y.size:  # where it changes its shape just there, too
            enters |= end == self.meets[strings]
        self._enter(strings[enters])

    def _note(self, strings: Ints, step: _Step, curve: _Curve, rows: tuple[Ints, Ints]) -> None:
        """Note the states of each string in its own range of rows."""
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
        """Return the right side of the strings ``i``."""
        return _Slopes(self.drag.some(i), self.arc[i], self.friction[i], self.is_helix[i])

    def place(self, depth: Floats) -> WellGeometry:
        """Return the well at measured depths (..., n)."""
        arcs = self.drag.path.arcs
        return WellGeometry.at(Points(arcs, self.arc, depth - arcs.start[self.arc]))

    def at(self, geometry: WellGeometry, state: Floats) -> Floats:
        """Return dy/ds of each string at its place."""
        return self.drag.slopes(geometry, self.friction, state, self.is_helix)


@dataclass(frozen=True, eq=False)
class _Step(ByContent):
    """A step up of n strings: its ends, the states there, and minus the slopes on the way (13, n).

    ``is_last`` says whether it is the last in its piece; ``places`` are the well at the lower end, in the middle and at
    the upper end (3, n).
    """

    slopes: _Slopes
    depth: Floats
    end: Floats
    is_last: Bools
    old: Floats
    new: Floats
    rises: Floats
    places: WellGeometry

    @classmethod
    def of(cls, slopes: _Slopes, depth: Floats, end: Floats, is_last: Bools, old: Floats) -> _Step:
        """Return a step from a state."""
        from scipy.integrate import DOP853

        rises = np.empty((13, *old.shape))
        state, length = old, depth - end
        places = slopes.place(depth - np.append(DOP853.C, [1.0, 0.5])[:, None] * length)
        for k, row in enumerate([*DOP853.A[1:], DOP853.B, None]):
            rises[k] = -slopes.at(WellGeometry(*(column[k] for column in places)), state)
            if row is not None:
                state = old + length * _sum(row[: k + 1], rises)
        ends = WellGeometry(*(column[[0, -1, -2]] for column in places))
        return cls(slopes, depth, end, is_last, old, state, rises, ends)

    @property
    def length(self) -> Floats:
        """Length in m."""
        return self.depth - self.end

    def some(self, i: Ints) -> _Step:
        """Return the step of the strings ``i``."""
        columns = self.old[i], self.new[i], self.rises[:, i], WellGeometry(*(column[:, i] for column in self.places))
        return _Step(self.slopes.some(i), self.depth[i], self.end[i], self.is_last[i], *columns)

    def error(self, tolerance: Floats) -> Floats:
        """Return the estimated error over the tolerance, relative and absolute, as Hairer, Norsett and Wanner do."""
        from scipy.integrate import DOP853

        scale = tolerance * (1.0 + np.maximum(np.abs(self.old), np.abs(self.new)))
        fifth, third = ((_sum(weights, self.rises) / scale) ** 2 for weights in (DOP853.E5, DOP853.E3))
        under = np.sqrt(np.maximum(fifth + 0.01 * third, 1e-300))
        return np.asarray(self.length * fifth / under)

    @property
    def may_change(self) -> Bools:
        """Whether bounds at both sides allow strings another shape within the step.

        By three places, with y in the middle of a cubic.  Between them y and the contact force of the lying string, a
        vector across it, leave their chords by no more than their second differences, eight times as far as a parabola.
        A lying string becomes no helix where sin^2 y is less than h lying / wound, and a helix does not end where it is
        more.
        """
        drag = self.slopes.drag
        if drag.motion != "pushed":
            return np.zeros(self.old.shape, bool)
        bulge = 0.125 * self.length * (self.rises[0] - self.rises[12])
        y = np.array([self.old, 0.5 * (self.old + self.new) + bulge, self.new])
        off = np.abs(y[0] - 2.0 * y[1] + y[2]) + np.abs(bulge)
        low, high = y.min(axis=0) - off, y.max(axis=0) + off
        lightest, heaviest = _lying_between(drag.lying_across(self.places, y))
        helical = drag.sliding.helical / drag.sliding.wound
        lies_on = np.where(high > 0.0, np.sin(np.minimum(high, LOCKED)) ** 2 < helical * lightest, True)
        winds_on = (low > 0.0) & (np.sin(np.clip(low, 0.0, LOCKED)) ** 2 > helical * heaviest)
        return np.asarray(np.where(self.slopes.is_helix, ~winds_on, ~lies_on | (high >= LOCKED)))

    def curve(self) -> _Curve:
        """Return the solution within the step."""
        from scipy.integrate import DOP853

        rises = np.concatenate([self.rises, np.empty((3, *self.old.shape))])
        places = self.slopes.place(self.depth - DOP853.C_EXTRA[:, None] * self.length)
        for k, row in enumerate(DOP853.A_EXTRA):
            state = self.old + self.length * _sum(row[: 13 + k], rises)
            rises[13 + k] = -self.slopes.at(WellGeometry(*(column[k] for column in places)), state)
        change, first, last = self.new - self.old, self.length * rises[0], self.length * rises[12]
        higher = [self.length * _sum(row, rises) for row in DOP853.D]
        return _Curve(self.old, np.array([change, first - change, 2.0 * change - first - last, *higher]))

    def changes(self, curve: _Curve) -> Floats:
        """Return the shares of the step after which the shapes of strings first change, NaN where none does.

        By samples of the solution, and by the largest value between samples of `helix_margin`, signed by the shape: a
        helix may begin and end between two.
        """
        size, strings = self.old.size, np.arange(self.old.size)
        if self.slopes.drag.motion != "pushed":
            return np.full(size, math.nan)
        share = np.arange(_SAMPLES + 1) / _SAMPLES
        states = curve.at(np.repeat(share, size), np.tile(strings, _SAMPLES + 1)).reshape(-1, size)
        geometry, drag = self.slopes.place(self.depth - share[:, None] * self.length), self.slopes.drag
        is_other = (drag.is_helix(geometry, states) != self.slopes.is_helix) & (states < LOCKED)
        is_other[0] = False
        first = np.where(is_other.any(axis=0), is_other.argmax(axis=0), _SAMPLES + 1)
        upper = np.where(first <= _SAMPLES, share[np.minimum(first, _SAMPLES)], math.nan)
        lower = upper - 1.0 / _SAMPLES
        # Summits between samples before the first that has another shape, from the lower end up: the first counts.
        margin = np.where(self.slopes.is_helix, -1.0, 1.0) * drag.helix_margin(geometry, states)
        k, i = np.nonzero(_has_summit(margin) & (states < LOCKED) & (np.arange(_SAMPLES + 1)[:, None] < first))
        if k.size:
            begin, stop = share[np.maximum(k - 1, 0)], share[np.minimum(k + 1, _SAMPLES)]
            summit, _ = largest(lambda shares, j: self._margin(curve, shares, i[j])[0], begin, stop, _SECTIONS)
            value, terms = self._margin(curve, summit, i)
            for j in np.flatnonzero(value > _TOUCHES * terms)[::-1].tolist():
                lower[i[j]], upper[i[j]] = begin[j], summit[j]
        changes = np.full(size, math.nan)
        changing = np.flatnonzero(np.isfinite(upper))
        if changing.size:
            changes[changing] = self._change(curve, lower[changing], upper[changing], changing)
        return changes

    def _margin(self, curve: _Curve, share: Floats, i: Ints) -> tuple[Floats, Floats]:
        """Return the signed margin of strings i after shares of the step, above 0 in another shape, and its terms."""
        slopes, state = self.slopes.some(i), curve.at(share, i)
        geometry = slopes.place(self.depth[i] - share * self.length[i])
        margin, sine = slopes.drag.helix_margin(geometry, state), np.sin(state)
        terms = 2.0 * sine**4 + np.abs(margin)
        return np.where(state < LOCKED, np.where(slopes.is_helix, -margin, margin), -math.inf), terms

    def _change(self, curve: _Curve, lower: Floats, upper: Floats, i: Ints) -> Floats:
        """Return the shares of the step between two at which the shapes of strings i change."""
        step = self.some(i)

        def wants(end: Floats, j: Ints) -> Floats:
            slopes = step.slopes.some(j)
            geometry = slopes.place(step.depth[j] - (end - 1.0) * step.length[j])
            return slopes.drag.helix_excess(geometry, curve.at(end - 1.0, i[j]))

        # From 1 to 2, so that the beginning is found to rounding of a step and no closer.
        strings, begin, end = np.arange(i.size), 1.0 + lower, 1.0 + upper
        at_begin, at_end = wants(begin, strings), wants(end, strings)
        # Where it has just changed rounding may put it on the other side: it is on the side of its shape.
        is_there = at_begin * at_end < -1e-9 * at_end**2
        share = roots(wants, begin, end, np.where(is_there, at_begin, -at_end), at_end) - 1.0
        return np.where(share < _AT_ONCE, 0.0, share)


class _Curve(NamedTuple):
    """States (n,) at the beginning of a step, and the coefficients (7, n) of the polynomials added to them."""

    old: Floats
    parts: Floats

    def at(self, share: Floats, i: Ints) -> Floats:
        """Return the states of strings i after shares of the step."""
        added = np.zeros(i.size)
        for k, coefficient in enumerate(self.parts[::-1, i]):
            added = (added + coefficient) * (share if k % 2 == 0 else 1.0 - share)
        return np.asarray(self.old[i] + added)


def _lying_between(across: Floats) -> tuple[Floats, Floats]:
    """Return bounds of the sizes (n,) of vectors between three places, from the vectors (2, 3, n) there."""
    off = np.hypot(*(across[:, 0] - 2.0 * across[:, 1] + across[:, 2]))
    begin, chord = across[:, :2], np.diff(across, axis=1)
    share = -(begin * chord).sum(axis=0) / np.maximum((chord * chord).sum(axis=0), 1e-300)
    nearest = np.hypot(*(begin + np.clip(share, 0.0, 1.0) * chord)).min(axis=0)
    return np.maximum(nearest - off, 0.0), np.hypot(*across).max(axis=0) + off


def _has_summit(values: Floats) -> Bools:
    """Return the samples (m, n) beside which a smooth function may have a maximum above 0.

    It exceeds the sample by an eighth of the second difference, of a parabola: all of it is allowed for.  Beside the
    first and the last sample it has one only where it rises from there into the bracket.
    """
    steps = np.diff(values, axis=0)
    curved = np.abs(np.diff(steps, axis=0))
    curved = np.concatenate([curved[:1], curved, curved[-1:]])
    outer = np.stack([1.5 * steps[0] - 0.5 * steps[1], 0.5 * steps[-2] - 1.5 * steps[-1]])
    is_summit = np.empty(values.shape, bool)
    is_summit[1:-1] = (steps[:-1] >= 0.0) & (steps[1:] <= 0.0)
    is_summit[0], is_summit[-1] = (steps[0] <= 0.0) & (outer[0] > 0.0), (steps[-1] >= 0.0) & (outer[1] > 0.0)
    return np.asarray(is_summit & (values + curved > 0.0))


def _sum(weights: Floats, rises: Floats) -> Floats:
    """Return the weighted sum (n,) of the first slopes."""
    return np.asarray(weights @ rises[: len(weights)])
