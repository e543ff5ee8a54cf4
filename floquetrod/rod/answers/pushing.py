"""Strings pushed into a well as far as they go: until they lock up, yield or need more than the injector gives.

Without a tool, the state y at the upper end depends on the depth b of the lower end through

    dy_top / db = P (mu N - w cos(phi)),    P > 0,

with the bracket at the lower end, under the force there: of two strings the one with the larger force anywhere has the
larger force everywhere above.  Between zeros of the bracket the force at every place of the string rises with b, or
falls.  A string that passes the depths at which it changes sign therefore passes all depths between them.  The largest
stress at a place, under a push or a pull, is then largest at one end, too; stress that the lower end has at once, where
it enters a bend, is examined along the well.

Of a string of several sections all joints go deeper with the lower end, each with a share of the change above, so that
no such bound holds: a hundredth of the path apart, and beside the largest forces seen, it is examined as with a tool.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.roots import roots
from floquetrod.rod.answers.assembly import StringCells, added_by, cells_of, deepest_of, reference_strength, weakness
from floquetrod.rod.answers.mean_force import MeanForce, mean_force
from floquetrod.rod.answers.stress_along import StressAlong, excess_inside, stress_along, stress_of
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.wellhead import OPEN, Wellhead
from floquetrod.wells import strings
from floquetrod.wells.drag import CHECKED, FAST, OF_SECTIONS, SOUGHT, Drag, Fineness, WellGeometry
from floquetrod.wells.survey import LENGTHS

LOCK_UP, YIELD, PUSH, END, ASKED = "lock-up", "yield", "push", "end of the well", "deepest asked for"
LENGTH = "length of the string"
"""What limits a reach."""

ACCURACY = 1e-6, 1e-4
"""Of a reach, over the length of the path, without a tool and with one."""

RESOLUTION = 0.01
"""Largest distance between depths `Pushing.examined` with a tool or several sections, over the length of the path."""

_SPACING, _MOST_PLACES = 10.0, 2000  # m between the places of a string whose stress is examined, and their number
_PER_PIECE = 17  # depths of a piece of one arc and friction between which the bracket above changes sign
_SECTIONS = 26, 8  # into how many a bracket is divided at once
_WIDENS = 4.0  # how much farther the next attempt lies
_PARTS = (25, 9, 9), (25, 2, 2, 2, 2, 2, 2)
"""Into how many parts what holds a limit sought is divided, one time after the other, without a tool and with it.

Many strings without a tool take hardly longer than one, side by side; with a tool each takes its time.
"""
MOST_FORCE = 10.0  # critical forces, up to which they are tried at the lower end (a choice: pipes yield before)


class Limits(NamedTuple):
    """The largest force in N at the injector, and the largest stress in Pa; infinite for none."""

    push: float = math.inf
    stress: float = math.inf


STATICS = Limits()
"""Lock-up alone."""


class UpperEnds(NamedTuple):
    """Forces in N at the injector, infinite where a string is stopped, and the largest stress in Pa along.

    Of several sections each stress is times the largest yield strength of them over the yield strength of the section.
    """

    force: Floats
    stress: Floats

    def within(self, limits: Limits) -> Bools:
        """Return which strings are not stopped."""
        return np.asarray(np.isfinite(self.force) & (self.force <= limits.push) & (self.stress <= limits.stress))

    def reason(self, k: int, limits: Limits) -> str:
        """Return the limit that stops string k."""
        if not math.isfinite(self.force[k]):
            return LOCK_UP
        return PUSH if self.force[k] > limits.push else YIELD


class Reached(NamedTuple):
    """Measured depth in m that a string reaches, and what limits it."""

    depth: float
    limit: str


class Sought(NamedTuple):
    """How deep strings reach, within limits and by statics alone, and what it takes.

    The force in N at the injector of strings to all depths, and the greatest that arrives at the lower ends at a few.
    """

    injector: Floats
    bit: Floats
    reached: Reached
    lock_up: Reached


def stress_limit(rod: RodData, yield_share: Any) -> float:
    """Return the largest stress in Pa: a share of the yield strength, infinite where either is None."""
    if yield_share is None:
        return math.inf
    share = validate.within("yield_share", yield_share, 1e-3, 1.0, "a share of the yield strength, or None for none")
    strength = reference_strength(rod)
    return math.inf if strength is None else share * strength


@dataclass(frozen=True)
class Pushing:
    """Strings of one rod in one well, with the compression in N at their lower ends.

    To the depth ``passed`` in m they go without their tool, which need not run before: its stress there does not count.
    """

    rod: RodData
    drag: Drag
    far_force: float
    passed: float = -math.inf
    wellhead: Wellhead = OPEN

    @property
    def accuracy(self) -> float:
        """Accuracy in m of a reach."""
        path = self.drag.path
        return ACCURACY[self.drag.shaking is not None] * (path.end - path.start)

    @cached_property
    def places(self) -> Floats:
        """Measured depths in m at which the stress of strings is examined."""
        path = self.drag.path
        number = int(np.clip((path.end - path.start) / _SPACING, 50, _MOST_PLACES))
        places = np.union1d(np.linspace(path.start, path.end, number + 1), path.stations)
        if self.drag.assembly is None:
            return places
        bores = self.drag.assembly.bores
        bores = np.append(bores, np.nextafter(bores, -math.inf))
        return np.union1d(places, bores[(bores >= path.start) & (bores <= path.end)])

    def _curvature(self, depth: Floats) -> Floats:
        """Return the curvature of the well in 1/m, at a station the larger one of both arcs."""
        arcs = self.drag.path.arcs
        below = arcs.at(depth).arc
        above = np.maximum(np.searchsorted(arcs.start, depth, side="left") - 1, 0)
        return np.maximum(arcs.curvature[below], arcs.curvature[above])

    def _stress(self, depth: Floats, y: Floats, vibration: Any, bottom: Floats, section_at: Any = None) -> Floats:
        """Return the stress in Pa of strings to depths ``bottom`` at depths, NaN where they are not.

        Of the sections there, or of those at the depths ``section_at``.
        """
        path, assembly, there = self.drag.path, self.drag.assembly, depth if section_at is None else section_at
        positions, force, string = WellGeometry.at(path.arcs.at(depth)), self.drag.force(y), self.drag.at(there, bottom)
        is_wound = string.is_snaking(positions, force) | string.is_helix(positions, y)
        excess = excess_inside(self.rod, path, depth, self.wellhead)
        if assembly is None:
            return stress_of(self.rod, self._curvature(depth), force, is_wound, vibration, excess).largest
        cells = StringCells.at(self.rod, assembly, there, bottom)
        stress = stress_of(cells.cross_sections, self._curvature(depth), force, is_wound, vibration, excess).largest
        return np.asarray(weakness(self.rod, cells) * stress)

    def run(self, bottoms: Floats, far_force: Any, effort: Fineness, limits: Limits) -> UpperEnds:
        """Return the forces and stresses of strings to measured depths; stresses are 0 where none is limited."""
        drag = self.drag
        is_limited = math.isfinite(limits.stress)
        places = self.places[self.places < bottoms.max()] if is_limited else np.empty(0)
        runs = strings.run(drag, drag.path.start, bottoms, far_force, places, effort)
        force = np.where(runs.is_settled, drag.force(runs.top_y) + self._added(bottoms), math.inf)
        stress = np.zeros(bottoms.size)
        if is_limited:
            y = drag.y_of(drag.above_end(far_force, bottoms))
            stress = self._stress(bottoms, y, 0.0, bottoms)
            if places.size:
                along = self._stress(places[:, None], runs.y, runs.wave[1], bottoms)
                stress = np.fmax(stress, np.fmax.reduce(along, axis=0))
            if drag.assembly is not None and runs.joint_y.size:
                joints = bottoms - drag.assembly.inner[:, None]
                for there in (joints, np.nextafter(joints, -math.inf)):
                    joined = self._stress(
                        np.maximum(joints, drag.path.start), runs.joint_y, runs.joint_vibration, bottoms, there
                    )
                    stress = np.fmax(stress, np.fmax.reduce(joined, axis=0))
        return UpperEnds(force, stress)

    def _added(self, bottoms: Floats) -> Any:
        """Return the compression in N at the injector beyond the effective one, of strings to depths."""
        return added_by(self.wellhead, self.rod, self.drag, bottoms)

    def pushed(self, bottoms: Floats, effort: Fineness, limits: Limits) -> UpperEnds:
        """Return the ends, as `run`, of strings with the force at their lower ends, whose stress may not count."""
        ends = self.run(bottoms, self.far_force, effort, limits)
        return ends._replace(stress=np.where(bottoms > self.passed, ends.stress, 0.0))

    def turning(self, deepest: float) -> Floats:
        """Return the depths of the lower end at which the force above begins to rise or fall as it goes deeper."""
        drag = self.drag
        ends = drag.edges
        ends = np.unique(np.append(ends[(ends > drag.path.start) & (ends < deepest)], [drag.path.start, deepest]))
        share = (np.arange(_PER_PIECE) + 0.5) / _PER_PIECE
        depth = (ends[:-1, None] + np.diff(ends)[:, None] * share).ravel()
        rises = self._rise(depth)
        i = np.flatnonzero((rises[1:] > 0.0) != (rises[:-1] > 0.0))
        low, high = depth[i], depth[i + 1]
        is_across = i % _PER_PIECE == _PER_PIECE - 1  # from one piece to the next
        turning = ends[1 + i // _PER_PIECE]
        within = np.flatnonzero(~is_across)
        if within.size:
            at = i[within]
            turning[within] = roots(lambda x, _: self._rise(x), low[within], high[within], rises[at], rises[at + 1])
        return np.asarray(turning[(turning > drag.path.start) & (turning < deepest)])

    def _rise(self, depth: Floats) -> Floats:
        """Return -dy/ds at the lower end of strings."""
        drag, positions = self.drag.at(depth, depth), WellGeometry.at(self.drag.path.arcs.at(depth))
        y = drag.y_of(self.drag.above_end(self.far_force, depth))
        return -drag.slopes(positions, drag.friction.at(depth), y, drag.is_helix(positions, y))

    def examined(self, depths: Floats, limits: Limits) -> Floats:
        """Return the depths that a string must pass to reach the last of increasing ones, all of these among them.

        With a tool, whose wave is reflected by the ends, nothing rises or falls with depth alone, nor does it where
        several sections go deeper together: no two depths are farther from each other than a hundredth of the path.
        """
        path, deepest = self.drag.path, float(depths[-1])
        begin = np.array([path.start + LENGTHS[0]])
        if not (self.drag.above_end(self.far_force, begin) + self._added(begin) > limits.push).any():
            begin = np.empty(0)  # it takes no more than the push to begin with
        every = [begin]
        if self.drag.shaking is not None or self.drag.assembly is not None:
            before = np.append(path.start, depths[:-1])
            parts = np.ceil((depths - before) / (RESOLUTION * (path.end - path.start)) - 1e-9)
            pieces = zip(before, depths, np.maximum(parts, 1.0).astype(int), strict=True)
            every += [np.linspace(a, b, n + 1)[1:] for a, b, n in pieces]
            if self.drag.assembly is None:
                return np.concatenate(every)
            every.append(self._passings(deepest))
        if self.drag.shaking is not None:
            return np.unique(np.concatenate(every))
        enters = np.empty(0)
        if math.isfinite(limits.stress):
            places = self.places[(self.places > path.start) & (self.places < deepest)]
            y = self.drag.y_of(self.drag.above_end(self.far_force, places))
            enters = places[self._stress(places, y, 0.0, places) > limits.stress][:1]
        return np.unique(np.concatenate([*every, self.turning(deepest), enters, self._jumps(deepest), depths]))

    def _passings(self, deepest: float) -> Floats:
        """Return the depths of the lower end at which a section passes a change of friction or bore, or where it bends.

        There the force above turns; a short section bends in a short bend between two of the depths a hundredth apart.
        """
        path, assembly = self.drag.path, self.drag.assembly
        if assembly is None:
            return np.empty(0)
        meets = assembly.heights[np.isfinite(assembly.heights)]
        changes = np.concatenate([self.drag.friction.depths, assembly.bores])
        passings = [(changes[:, None] + meets).ravel()]
        is_short = np.diff(assembly.heights) < RESOLUTION * (path.end - path.start)
        passings.append((path.stations[:, None] + meets[:-1][is_short[: meets.size - 1]]).ravel())
        every = np.concatenate(passings)
        return np.asarray(every[(every > path.start) & (every < deepest)])

    def _jumps(self, deepest: float) -> Floats:
        """Return depths beside those at which friction at the lower end, and with it the force above, jumps."""
        if not self.drag.residual_curvature:
            return np.empty(0)
        jumps = np.array(self.drag.friction.depths)
        if self.drag.assembly is not None:
            jumps = np.append(jumps, self.drag.assembly.bores)
        jumps = np.concatenate([jumps, np.nextafter(jumps, -math.inf)])
        return np.asarray(jumps[(jumps > self.drag.path.start) & (jumps < deepest)])

    def _ends(self, depths: Floats, effort: Fineness, limits: Limits) -> tuple[Floats, UpperEnds]:
        """Return the depths `examined`, and the ends of the strings to them.

        Of several sections the depths of the largest forces between them are examined, too.
        """
        every = self.examined(depths, limits)
        ends = self.pushed(every, effort, limits)
        if self.drag.assembly is None or self.drag.shaking is not None:
            return every, ends
        low, middle, high = ends.force[:-2], ends.force[1:-1], ends.force[2:]
        with np.errstate(invalid="ignore"):
            k = 1 + np.flatnonzero(np.isfinite(low + middle + high) & (middle >= low) & (middle > high))
        if not k.size:
            return every, ends
        # The summit of a parabola through a largest force and the two beside it.
        before, after = every[k] - every[k - 1], every[k + 1] - every[k]
        rise, fall = (ends.force[k] - ends.force[k - 1]) / before, (ends.force[k + 1] - ends.force[k]) / after
        summits = 0.5 * (every[k - 1] + every[k]) + 0.5 * (before + after) * rise / (rise - fall)
        new = np.setdiff1d(summits, every)
        added = self.pushed(new, effort, limits) if new.size else UpperEnds(new, new)
        order = np.argsort(np.append(every, new))
        forces, stresses = (np.append(a, b)[order] for a, b in zip(ends, added, strict=True))
        return np.append(every, new)[order], UpperEnds(forces, stresses)

    def passes(self, depths: Floats, limits: Limits) -> Bools:
        """Return to which increasing depths strings are pushed through all depths `examined`."""
        every, ends = self._ends(depths, SOUGHT, limits)
        goes = np.logical_and.accumulate(ends.within(limits))
        return np.asarray(goes[np.searchsorted(every, depths)])

    def sought(self, depths: Floats, few: Ints, limits: Limits) -> Sought:
        """Return how deep strings reach, at most to the last of increasing depths, and the forces at both ends.

        Those at the lower ends are sought at a ``few`` of the depths.
        """
        start, deepest = self.drag.path.start, float(depths[-1])
        every, ends = self._ends(depths, FAST if self.drag.assembly is None else OF_SECTIONS, limits)
        kinds = (limits,) if limits == STATICS else (limits, STATICS)
        passed = [np.logical_and.accumulate(ends.within(kind)) for kind in kinds]
        rows = np.searchsorted(every, depths)
        arrives = few[passed[0][rows[few]]]
        # Columns: the depths at which the force at the lower end is sought, then the reach of each kind that stops.
        stops = [(kind, int(np.argmin(goes))) for kind, goes in zip(kinds, passed, strict=True) if not goes.all()]
        y = float(self.drag.y_of(np.asarray(self.far_force)))
        low, high = np.full((2, 2, arrives.size + len(stops)), y)
        before = np.append(start, every)
        low[0], high[0] = (np.append(depths[arrives], [bounds[k] for _, k in stops]) for bounds in (before, every))
        high[1, : arrives.size] = max(y, math.atan(MOST_FORCE))
        if low.size:
            of = [limits] * arrives.size + [kind for kind, _ in stops]
            relieved = np.append(np.full(arrives.size, -math.inf), np.full(len(stops), self.passed))
            low, high = self._narrowed(low, high, relieved, np.array([kind == STATICS for kind in of]), limits)
        bit = np.full(few.size, math.nan)
        middle = 0.5 * (low[1] + high[1])[: arrives.size]
        bit[np.isin(few, arrives)] = self.drag.scale * np.tan(middle)
        reached = [self._ended(deepest)] * len(kinds)
        for (kind, _), a, b in zip(stops, low[0, arrives.size :], high[0, arrives.size :], strict=True):
            if kind == limits or reached[0].limit != LOCK_UP:
                reached[kinds.index(kind)] = self.confirmed(float(a), float(b), deepest, kind)
            else:
                reached[1] = reached[0]
        return Sought(ends.force[rows], bit, reached[0], reached[-1])

    def reached(self, deepest: float, limits: Limits) -> Reached:
        """Return how deep strings reach, at most to a depth."""
        return self.sought(np.array([deepest]), np.empty(0, dtype=np.intp), limits).reached

    def _ended(self, deepest: float) -> Reached:
        if deepest >= self.drag.path.end:
            return Reached(deepest, END)
        return Reached(deepest, LENGTH if deepest >= deepest_of(self.rod, self.drag.path) else ASKED)

    def _narrowed(
        self, low: Floats, high: Floats, relieved: Floats, is_static: Bools, limits: Limits
    ) -> tuple[Floats, Floats]:
        """Return narrowed brackets ``low``, ``high`` (2, columns): a string goes to ``low`` and is stopped at ``high``.

        Row 0 holds the depth of the lower end, row 1 its force as y.  Stress counts only below the depth ``relieved``
        of a column, and in columns where ``is_static`` a string is stopped by lock-up alone.
        """
        for k, count in enumerate(_PARTS[self.drag.shaking is not None]):
            steps = np.linspace(low, high, count + 1, axis=1)
            bottoms, y = steps[:, 1:] if k == 0 else steps[:, 1:-1]
            ends = self.run(bottoms.ravel(), self.drag.scale * np.tan(y.ravel()), SOUGHT, limits)
            stress = np.where(bottoms.ravel() > np.tile(relieved, len(y)), ends.stress, 0.0)
            within = ends._replace(stress=stress).within(limits)
            goes = np.where(np.tile(is_static, len(y)), ends.within(STATICS), within)
            last = np.cumprod(goes.reshape(y.shape), axis=0).sum(axis=0)
            columns = np.arange(last.size)
            low, high = steps[:, last, columns], steps[:, np.minimum(last + 1, count), columns]
        return low, high

    def confirmed(self, low: float, high: float, deepest: float, limits: Limits) -> Reached:
        """Return the reach, from depths between which a string is stopped by quicker integration, by `mean_force`'s.

        The string goes there as `mean_force` computes it, and is stopped no farther below than ``accuracy``.
        """
        shallowest = self.drag.path.start + LENGTHS[0]
        sections, widens = _SECTIONS[self.drag.shaking is not None], max(high - low, 2.0 * self.accuracy)
        low, high = min(max(low - widens, shallowest), deepest), min(max(high + widens, shallowest), deepest)
        while True:
            depth = np.unique(np.linspace(low, high, sections + 1))
            ends = self._checked(depth, limits)
            goes = ends.within(limits)
            if goes.all():
                if high >= deepest:
                    return self._ended(deepest)
                low, high, widens = high, min(high + widens, deepest), _WIDENS * widens
            elif not goes[0]:
                if low <= shallowest:
                    return Reached(self.drag.path.start, ends.reason(0, limits))
                low, high, widens = max(low - widens, shallowest), low, _WIDENS * widens
            else:
                k = int(np.argmin(goes))
                low, high = float(depth[k - 1]), float(depth[k])
                if high - low <= self.accuracy:
                    # Deeper than it goes without its tool by nothing, where the tool alone adds too much stress.
                    reason = ends.reason(k, limits)
                    return Reached(self.passed if reason == YIELD and low < self.passed < high else low, reason)

    def _checked(self, depth: Floats, limits: Limits) -> UpperEnds:
        """Return forces and stresses by the integrations of `mean_force`, infinite where one of them is."""
        ends = self.pushed(depth, CHECKED[0], limits)
        if self.drag.shaking is None:
            return ends
        finer = self.pushed(depth, CHECKED[1], STATICS)
        return ends._replace(force=np.where(np.isfinite(finer.force), ends.force, math.inf))

    def shown_at(self, reached: Reached) -> float:
        """Return the depth in m for which the force of a string that goes no deeper is told.

        Where it locks up a little above that, where its force is not larger than any other.
        """
        start = self.drag.path.start
        length = max(reached.depth - start, LENGTHS[0])
        return start + (max((1.0 - 1e-3) * length, LENGTHS[0]) if reached.limit == LOCK_UP else length)

    def along(self, reached: Reached, limits: Limits) -> tuple[Reached, MeanForce, StressAlong]:
        """Return the reach with the string along its length there, by `mean_force`, whose stress is within limits.

        Where the string locks up, its force is told a little above, see `shown_at`.
        """
        path, step = self.drag.path, self.accuracy
        while True:
            bottom = self.shown_at(reached)
            along = mean_force(self.rod, self.drag, self.far_force, bottom, None)
            stress = stress_along(self.rod, path, along, along.vibration, self.wellhead)
            largest = weakness(self.rod, cells_of(self.rod, along)) * stress.largest
            is_within = reached.depth <= self.passed or not (largest > limits.stress).any()
            if is_within or reached.limit == LOCK_UP or reached.depth <= path.start:
                return reached, along, stress
            reached = Reached(max(reached.depth - step, path.start), YIELD)
            step *= _WIDENS
