"""Strings that a tool shakes, marched up a well side by side by fixed steps, with what is left of friction in each.

By the classical Runge-Kutta method of order 4, a step to each piece.  In a step within which a string becomes a helix
or ceases to be one it is one for its part of the step, by the secant: an error of order 2, as that of the wave, and a
contact force that follows the force without jumps, without which turns between force and wave need not settle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.wells.arcs import Points
from floquetrod.wells.drag import LOCKED, Drag, Place, Strings

Ints = NDArray[np.intp]


class Marched(NamedTuple):
    """Y of n strings at the ends of their m pieces, (m + 1, n), and what each piece has, (m, n).

    That is -dy/ds within, above and below, and the part that is a helix.
    """

    y: Floats
    above: Floats
    below: Floats
    helix: Floats

    def some(self, strings: Ints) -> Marched:
        """Return that of some strings."""
        return Marched(*(each[:, strings] for each in self))

    def put(self, strings: Ints, some: Marched) -> None:
        """Set that of some strings."""
        for each, new in zip(self, some, strict=True):
            each[:, strings] = new


class Pieces:
    """Pieces of strings between measured depths ``ends``, (m + 1,), empty where a string is not.

    Attributes
    ----------
    ends : ndarray (m + 1, n)
        Those within each string.
    friction : ndarray (m, 1)
        Coefficients of friction without vibration.
    """

    def __init__(self, drag: Drag, strings: Strings, ends: Floats) -> None:
        """Look at the well at the ends and in the middle of all pieces."""
        self.drag, self.start = drag, strings.y
        self.ends = np.clip(ends[:, None], strings.top, strings.bottom)
        self.length = np.diff(self.ends, axis=0)
        middle, arcs = 0.5 * (ends[1:] + ends[:-1]), drag.path.arcs
        self.friction = drag.friction.at(middle)[:, None]
        arc = np.broadcast_to(arcs.at(middle).arc[:, None], self.length.shape)
        at = self.ends[1:], self.ends[1:] - 0.5 * self.length, self.ends[:-1]
        self.places = np.array([Points(arcs, arc, depth - arcs.start[arc]).seen for depth in at])

    def _place(self, k: int, strings: Ints) -> Floats:
        """Return some strings' pieces at their lower ends, 0, middle, 1, or upper ends, 2: as `Place`, (4, m, k)."""
        places: Floats = self.places[k]
        return places if strings.size == self.start.size else np.asarray(places[..., strings])

    def up(self, share: Floats, strings: Ints) -> Marched:
        """March some strings up with the share of friction (m, k) that is left; locked up they are so all the way."""
        size = len(self.length)
        found = Marched(np.empty((size + 1, strings.size)), *np.zeros((3, size, strings.size)))
        found.y[-1] = self.start[strings]
        places, length, friction = [self._place(k, strings) for k in range(3)], self.length[:, strings], self.friction
        for i in range(size - 1, -1, -1):
            step = _Step(self.drag, [Place(*place[:, i]) for place in places], length[i], friction[i] * share[i])
            new, found.above[i], found.below[i], found.helix[i] = step.up(found.y[i + 1])
            found.y[i] = np.where(found.y[i + 1] >= LOCKED, LOCKED, np.minimum(new, LOCKED))
        return found

    def pressed(self, found: Marched, strings: Ints) -> Floats:
        """Return mu N in N/m without vibration in the middle of all pieces of some strings, (m, k)."""
        bulge = 0.125 * self.length[:, strings] * (found.below - found.above)
        y = np.minimum(0.5 * (found.y[1:] + found.y[:-1]) + bulge, LOCKED)
        return self.drag.pressed(Place(*self._place(1, strings)), self.friction, y, found.helix)

    def at(self, found: Marched, depth: Floats) -> Floats:
        """Return y of all strings at measured depths, NaN where a string is not, by cubics within pieces."""
        result = np.full((depth.size, self.start.size), np.nan)
        for j, ends in enumerate(self.ends.T):
            there = (depth >= ends[0]) & (depth <= ends[-1])
            i = np.clip(np.searchsorted(ends, depth[there], side="left") - 1, 0, len(ends) - 2)
            length = np.maximum(ends[i + 1] - ends[i], 1e-300)
            up = (ends[i + 1] - depth[there]) / length
            low, high = found.y[i + 1, j], found.y[i, j]
            bend = length * (found.below[i, j] * (1.0 - up) - found.above[i, j] * up) - (high - low) * (1.0 - 2.0 * up)
            result[there, j] = np.minimum(low + up * (high - low) + up * (1.0 - up) * bend, LOCKED)
        return result


class _Step(NamedTuple):
    """A step of some strings up a piece, seen at its lower end, its middle and its upper end."""

    drag: Drag
    places: list[Place]
    length: Floats
    friction: Floats

    def up(self, y: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return y above, -dy/ds above and below, and the part of the piece that is a helix."""
        before = self.drag.wants_helix(self.places[0], y)
        helix = np.where(before >= 0.0, 1.0, 0.0)
        found = self._taken(y, helix)
        after = self.drag.wants_helix(self.places[2], found[0])
        is_changing = (after >= 0.0) != (before >= 0.0)
        if not is_changing.any():
            return found
        part = np.maximum(after, before) / np.maximum(np.abs(after - before), 1e-300)
        return self._taken(y, np.where(is_changing, part, helix))

    def _taken(self, y: Floats, helix: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        low, middle, high = self.places
        half = 0.5 * self.length
        first = self._rise(low, y, helix)
        second = self._rise(middle, y + half * first, helix)
        third = self._rise(middle, y + half * second, helix)
        fourth = self._rise(high, y + self.length * third, helix)
        return y + half / 3.0 * (first + 2.0 * (second + third) + fourth), fourth, first, helix

    def _rise(self, place: Place, y: Floats, helix: Floats) -> Floats:
        return -self.drag.slopes(place, self.friction, y, helix)
