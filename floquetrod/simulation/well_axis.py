"""The axis of the channel of a rod that is simulated in a well, and the coordinates along it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.wells.minimum_curvature import WellArcs
from floquetrod.wells.path import WellPath

_ROUNDS = 8  # of Newton's method from places some micrometres off: two are enough
_VERTICAL = 1e-9  # sine of an inclination below which a well has no high side
_SETTLED = 1e-15  # of the length, by which a round changes no place any more


class Frames(NamedTuple):
    """Points of the axis, each with its axes along the channel, sideways and to its high side, (n, 3) each.

    ``bend`` is the vector of curvature in 1/m.
    """

    point: Floats
    along: Floats
    sideways: Floats
    up: Floats
    bend: Floats


@dataclass(frozen=True)
class WellAxis:
    """Axis of a well from some measured depth on, in a Cartesian system with its origin at the middle of a rod.

    There the first axis points along the channel, and the third to its high side.  Beyond its stations the well is
    straight.  Places x along the axis are measured in m from the middle.

    Parameters
    ----------
    path : WellPath
    depth : float
        Measured depth of the upper end of the rod in m.
    length : float
        Of the rod in m.
    """

    path: WellPath
    depth: float
    length: float

    @property
    def middle(self) -> float:
        """Measured depth of the middle of the rod in m."""
        return self.depth + 0.5 * self.length

    def frames(self, x: Floats) -> Frames:
        """Return the frames at places ``x``."""
        arc = np.take(self.arcs, self.arc_at(x), axis=0)
        below, curvature = (x - arc[:, 0])[:, None], arc[:, 10:]
        tangent, normal, angle = arc[:, 4:7], arc[:, 7:10], curvature * below
        sine, cosine = np.sin(angle), np.cos(angle)
        run, aside = below * np.sinc(angle / math.pi), 0.5 * curvature * (below * np.sinc(0.5 * angle / math.pi)) ** 2
        along = cosine * tangent + sine * normal
        high = dot(along, self.gravity)[:, None] * along - self.gravity
        size = np.linalg.norm(high, axis=1, keepdims=True)
        up = np.where(size > _VERTICAL, high, self._level - dot(along, self._level)[:, None] * along)
        up = up / np.linalg.norm(up, axis=1, keepdims=True)
        bend = curvature * (cosine * normal - sine * tangent)
        return Frames(arc[:, 1:4] + run * tangent + aside * normal, along, np.cross(up, along), up, bend)

    def arc_at(self, x: Floats) -> NDArray[np.intp]:
        """Return the rows of `arcs` to which places ``x`` belong."""
        return np.maximum(np.searchsorted(self.arcs[:, 0], x, side="right") - 1, 0)

    def cartesian(self, positions: Floats) -> Floats:
        """Return where nodes with coordinates (n, 3) along the axis, sideways and up lie."""
        frames = self.frames(positions[:, 0])
        return np.asarray(frames.point + positions[:, 1:2] * frames.sideways + positions[:, 2:] * frames.up)

    def along(self, places: Floats, near: Floats) -> tuple[Floats, Frames]:
        """Return the coordinates (n, 3) of Cartesian places, and the frames nearest to them.

        ``near`` are places along the axis to start from.
        """
        x = near
        for _ in range(_ROUNDS):
            frames = self.frames(x)
            off = places - frames.point
            change = dot(off, frames.along) / (1.0 - dot(off, frames.bend))
            x = x + change
            if np.abs(change).max() <= _SETTLED * self.length:
                break
        return np.stack([x, dot(off, frames.sideways), dot(off, frames.up)], axis=1), frames

    @cached_property
    def gravity(self) -> Floats:
        """Direction of gravity, (3,)."""
        return np.asarray(self._turn[2])

    @cached_property
    def arcs(self) -> Floats:
        """The arcs of the axis, (n, 11).

        A row each: place of the upper end; point, tangent and normal there; curvature in 1/m.  The first and the last
        are the straight pieces beyond the stations.
        """
        path, turn = self.path, self._turn
        arcs = WellArcs.between(path.depth, path.inclination, path.azimuth)
        start, curvature = arcs.start - self.middle, arcs.curvature
        along, sideways, up = _axes(arcs.inclination, arcs.azimuth)
        bend = arcs.kappa_n[:, None] * up - arcs.kappa_b[:, None] * sideways
        normal = bend / np.where(curvature > 0.0, curvature, 1.0)[:, None]
        point = path.position(arcs.start) - self._origin
        bent = np.column_stack([start, point @ turn, along @ turn, normal @ turn, curvature])
        last = np.array([path.end])
        ahead = _axes(path.inclination_at(last), path.azimuth_at(last))[0]
        below = np.column_stack([last - self.middle, (path.position(last) - self._origin) @ turn, ahead @ turn])
        above = bent[:1, :7].copy()
        above[:, 0] -= self.length
        above[:, 1:4] -= self.length * above[:, 4:7]
        straight = np.zeros((1, 4))
        return np.vstack([np.hstack([above, straight]), bent, np.hstack([below, straight])])

    @property
    def sharpest(self) -> float:
        """Largest curvature along the rod in 1/m."""
        half = 0.5 * self.length
        first, last = self.arc_at(np.array([-half, half]))
        return float(self.arcs[first : last + 1, 10].max())

    @property
    def _level(self) -> Floats:
        """What stands for the high side where a well is vertical, (3,)."""
        return np.array([0.0, 0.0, 1.0])

    @cached_property
    def _origin(self) -> Floats:
        """North, east and depth of the middle."""
        return self.path.position(self.middle)

    @cached_property
    def _turn(self) -> Floats:
        """What turns north, east and down into the Cartesian system, (3, 3), from the right."""
        return np.stack(_axes(self.path.inclination_at(self.middle), self.path.azimuth_at(self.middle)), axis=-1)


def _axes(inclination: Floats, azimuth: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the directions along a well, sideways to smaller azimuth, and to its high side, north, east, down."""
    sin, cos, zero = np.sin(inclination), np.cos(inclination), np.zeros_like(inclination)
    north, east = np.cos(azimuth), np.sin(azimuth)
    along = np.stack([sin * north, sin * east, cos], axis=-1)
    return along, np.stack([east, -north, zero], axis=-1), np.stack([cos * north, cos * east, -sin], axis=-1)


def dot(a: Floats, b: Floats) -> Floats:
    """Return the scalar products of vectors (n, 3) with vectors (n, 3) or with one."""
    return np.asarray(np.einsum("ij,ij->i" if b.ndim == 2 else "ij,j->i", a, b))
