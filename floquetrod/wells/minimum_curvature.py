"""Minimum curvature: the circular arcs that join the directions at neighbouring stations.

Every formula holds for straight pieces too: nothing is divided by the angle of an arc.  The frame at a point has the
axes (t, e_n, e_b): along the well, in the vertical plane of greater inclination, and level to greater azimuth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent

_VERTICAL = 1e-12  # sine of an inclination below which an azimuth means nothing


@dataclass(frozen=True, eq=False)
class WellArcs(ByContent):
    """Circular arcs one after the other, one to an interval between stations."""

    start: Floats  # (n,), measured depth of the upper ends in m
    length: Floats  # (n,), in m
    inclination: Floats  # (n,), direction at the upper ends in rad
    azimuth: Floats  # (n,), at a vertical upper end the azimuth of the lower end
    dogleg: Floats  # (n,), angles of the arcs in rad
    kappa_n: Floats  # (n,), curvature at the upper ends in 1/m, in the vertical plane
    kappa_b: Floats  # (n,), and sideways

    @classmethod
    def between(cls, depth: Floats, inclination: Floats, azimuth: Floats) -> WellArcs:
        """Return the arcs between stations."""
        upper, lower = inclination[:-1], inclination[1:]
        psi = np.where(np.sin(upper) > _VERTICAL, azimuth[:-1], azimuth[1:])
        turn = np.where(np.sin(lower) > _VERTICAL, azimuth[1:] - psi, 0.0)
        dogleg, build, side = _bend(upper, lower, turn)
        length = np.diff(depth)
        rate = 1.0 / (length * np.sinc(dogleg / math.pi))  # curvature over the sine of the dogleg
        return cls(depth[:-1], length, upper, psi, dogleg, rate * build, rate * side)

    @property
    def curvature(self) -> Floats:
        """Curvatures of the arcs in 1/m."""
        return np.asarray(self.dogleg / self.length)

    def at(self, depth: Floats) -> Points:
        """Return points at measured depths, on a station of the interval below it."""
        i = np.clip(np.searchsorted(self.start, depth, side="right") - 1, 0, self.start.size - 1)
        return Points(self, i, depth - self.start[i])


@dataclass(frozen=True, eq=False)
class Points(ByContent):
    """Points on arcs: the index of the arc, and the distance in m below its upper end."""

    arcs: WellArcs
    arc: NDArray[np.intp]
    below: Floats

    @property
    def _angle(self) -> Floats:
        """Angle of the arc from its upper end, in rad."""
        return np.asarray(self.arcs.curvature[self.arc] * self.below)

    @property
    def _bend(self) -> tuple[Floats, Floats]:
        """Distance run along the arc's normal for each radian, in the directions e_n and e_b, in rad."""
        run = self.below * np.sinc(self._angle / math.pi)
        return self.arcs.kappa_n[self.arc] * run, self.arcs.kappa_b[self.arc] * run

    @property
    def _level(self) -> tuple[Floats, Floats]:
        """Level part of the tangent, in the vertical plane of the upper end and sideways."""
        phi, along = self.arcs.inclination[self.arc], np.cos(self._angle)
        build, side = self._bend
        return np.sin(phi) * along + np.cos(phi) * build, side

    @property
    def inclination(self) -> Floats:
        """Inclination from the vertical in rad."""
        phi = self.arcs.inclination[self.arc]
        down = np.cos(phi) * np.cos(self._angle) - np.sin(phi) * self._bend[0]
        return np.asarray(np.arctan2(np.hypot(*self._level), down))

    @property
    def azimuth(self) -> Floats:
        """Azimuth in rad, within half a turn of the azimuth at the upper end of the arc."""
        ahead, side = self._level
        return np.asarray(self.arcs.azimuth[self.arc] + np.where(side == 0.0, 0.0, np.arctan2(side, ahead)))

    @property
    def curvature(self) -> tuple[Floats, Floats]:
        """Curvature in the vertical plane and sideways in 1/m."""
        return self.seen[2:]

    @property
    def seen(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Sine and cosine of the inclination, and both curvatures."""
        arcs, i, angle = self.arcs, self.arc, self._angle
        run = self.below * np.sinc(angle / math.pi)
        back = arcs.curvature[i] * np.sin(angle)
        phi = np.sin(arcs.inclination[i]), np.cos(arcs.inclination[i])
        level, down, moving = turned(np.hypot, *phi, np.cos(angle), run, back, arcs.kappa_n[i], arcs.kappa_b[i])
        with np.errstate(invalid="ignore", divide="ignore"):
            ahead, aside = (
                np.where(level[2] > 0.0, component / level[2], vertical)
                for component, vertical in zip(level, (1.0, 0.0), strict=False)
            )
        return level[2], down, *curvatures(level[2], down, ahead, aside, moving)

    @property
    def moved(self) -> Floats:
        """Distance from the upper end of the arc, north, east and down, in m, (..., 3)."""
        phi, psi, angle = self.arcs.inclination[self.arc], self.arcs.azimuth[self.arc], self._angle
        forward = self.below * np.sinc(angle / math.pi)
        aside = 0.5 * self.below**2 * np.sinc(0.5 * angle / math.pi) ** 2
        build, side = aside * self.arcs.kappa_n[self.arc], aside * self.arcs.kappa_b[self.arc]
        ahead = forward * np.sin(phi) + build * np.cos(phi)
        north = ahead * np.cos(psi) - side * np.sin(psi)
        east = ahead * np.sin(psi) + side * np.cos(psi)
        return np.stack([north, east, forward * np.cos(phi) - build * np.sin(phi)], axis=-1)


def turned(
    hypot: Any, sine: Any, cosine: Any, along: Any, run: Any, back: Any, build: Any, side: Any
) -> tuple[tuple[Any, Any, Any], Any, tuple[Any, Any, Any]]:
    """Return the direction at a point of an arc, and its change, from the direction at the upper end.

    Of floats or arrays: sine and cosine of the inclination at the upper end, cosine of the angle, run for a unit of
    curvature, sine of the angle times the curvature, and both curvatures at the upper end.  The direction is its level
    part ahead, aside and altogether, and its part down; the change is ahead, aside and down.
    """
    ahead, aside = sine * along + cosine * build * run, side * run
    down = cosine * along - sine * build * run
    moving = along * build * cosine - back * sine, along * side, -along * build * sine - back * cosine
    return (ahead, aside, hypot(ahead, aside)), down, moving


def curvatures(level: Any, down: Any, ahead: Any, aside: Any, moving: tuple[Any, Any, Any]) -> tuple[Any, Any]:
    """Return the curvatures where the level part of the direction points to (ahead, aside), a unit vector."""
    radial = moving[0] * ahead + moving[1] * aside
    return radial * down - moving[2] * level, moving[1] * ahead - moving[0] * aside


def doglegs(inclination: Floats, azimuth: Floats, apart: int = 1) -> Floats:
    """Return the angles in rad between the directions at stations and at the stations ``apart`` further down."""
    return _bend(inclination[:-apart], inclination[apart:], azimuth[apart:] - azimuth[:-apart])[0]


def _bend(upper: Floats, lower: Floats, turn: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the angle between two directions, and the second's components along e_n and e_b of the first.

    By differences of angles, which keep their digits however small they are.
    """
    half = np.sin(0.5 * turn) ** 2
    square = np.sin(0.5 * (lower - upper)) ** 2 + np.sin(upper) * np.sin(lower) * half
    dogleg = 2.0 * np.arcsin(np.sqrt(np.minimum(square, 1.0)))
    build = np.sin(lower - upper) - 2.0 * np.cos(upper) * np.sin(lower) * half
    return dogleg, build, np.sin(lower) * np.sin(turn)
