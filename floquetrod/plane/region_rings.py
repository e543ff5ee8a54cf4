"""Rings of straight sides about regions of a plane: found by rays, divided, and joined where they meet."""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod.plane.polygons import tidied

_AT_ONCE = 1 << 20  # pairs of rays and sides examined together (a choice): some tens of megabytes


class RegionRings:
    """Nodes, each followed by another; a side is known by the node that it begins with.

    The unstable region lies to the left of every side.
    """

    def __init__(self) -> None:
        self.size = 0
        self._place = np.empty((64, 2))
        self._after = np.empty(64, dtype=np.int64)
        self._done = np.empty(64, dtype=np.bool_)

    @property
    def place(self) -> Floats:
        """Places of the nodes, (n, 2)."""
        return self._place[: self.size]

    @property
    def after(self) -> Ints:
        """The node that follows each, (n,)."""
        return self._after[: self.size]

    @property
    def done(self) -> Bools:
        """Whether the side that begins at each node needs no more work, (n,)."""
        return self._done[: self.size]

    def add_ring(self, places: Floats) -> None:
        """Add a closed ring of nodes."""
        first = self.size
        for place in places:
            self._add(place, self.size + 1, False)
        self._after[self.size - 1] = first

    def divide(self, side: int, place: Floats, done: bool = False) -> int:
        """Put a node into a side; return it."""
        node = self._add(place, self._after[side], done)
        self._after[side] = node
        self._done[side] = done
        return node

    def join(self, one: int, other: int) -> None:
        """Open two sides, which face each other, and connect their ends."""
        self._after[one], self._after[other] = self._after[other], self._after[one]
        self._done[one] = self._done[other] = False

    def _add(self, place: Floats, after: int, done: bool) -> int:
        node = self.size
        if node == len(self._place):
            self._place, self._after, self._done = (
                np.concatenate([old, np.empty_like(old)]) for old in (self._place, self._after, self._done)
            )
        self._place[node], self._after[node], self._done[node] = place, after, done
        self.size += 1
        return node

    def sides(self, some: Ints) -> tuple[Floats, Floats]:
        """Return the ends of sides."""
        return self.place[some], self.place[self.after[some]]

    def on_edge(self, some: Ints) -> Bools:
        """Return which sides lie on the edge of the plane."""
        start, end = self.sides(some)
        same = start == end
        result: Bools = (same & ((start == 0.0) | (start == 1.0))).any(axis=1)
        return result

    def hits(self, start: Floats, along: Floats, own: Ints) -> tuple[Floats, Ints]:
        """Return how far rays go before they meet a side other than their own, and that side; infinity and -1 if none.

        Distances are in lengths of ``along``.
        """
        a, b = self.sides(np.arange(self.size))
        distance, side = np.full(len(start), np.inf), np.full(len(start), -1)
        each = max(1, _AT_ONCE // max(1, self.size))
        for first in range(0, len(start), each):
            part = slice(first, first + each)
            to, across = a[None] - start[part, None], (b - a)[None]
            ray = along[part, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                area = ray[..., 0] * across[..., 1] - ray[..., 1] * across[..., 0]
                t = (to[..., 0] * across[..., 1] - to[..., 1] * across[..., 0]) / area
                s = (to[..., 0] * ray[..., 1] - to[..., 1] * ray[..., 0]) / area
            t = np.where((area != 0.0) & (t > 0.0) & (s >= 0.0) & (s <= 1.0), t, np.inf)
            t[np.arange(len(t)), own[part]] = np.inf
            nearest = t.argmin(axis=1)
            distance[part] = t[np.arange(len(t)), nearest]
            side[part] = np.where(np.isfinite(distance[part]), nearest, -1)
        return distance, side

    def rings(self) -> list[Floats]:
        """Return the places of each ring, without spare nodes."""
        after, seen, order, number = self.after.tolist(), [False] * self.size, [], []
        for first in range(self.size):
            at = first
            while not seen[at]:
                seen[at] = True
                order.append(at)
                number.append(first)
                at = after[at]
        which, vertices = tidied(np.array(number, dtype=np.int64), self.place[order])
        rings = np.split(vertices, np.flatnonzero(np.diff(which)) + 1)
        return [ring for ring in rings if len(ring) > 2]
