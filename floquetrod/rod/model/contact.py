"""Where on the wall of a channel that bends a string lies, how it is pressed there, and where it would leave it.

On an arc of curvatures kappa_n and kappa_b a compression F presses the string outwards, so that with its weight w it
lies at the angle theta_0 = atan2(F kappa_b, w sin(phi) + F kappa_n) from the lowest line of the wall, with the contact
force N = hypot(F kappa_b, w sin(phi) + F kappa_n) per length: on the low side, or on the high side of a plane path that
drops.  While F vibrates about its mean N follows with F kappa, kappa the curvature towards the wall at theta_0, and
the component sideways moves the string along the wall.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.content import ByContent
from floquetrod.rod.loads import axial
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.model.constants import ModeConstants, softest_constants
from floquetrod.rod.model.course import ChannelShape, weight_gained
from floquetrod.rod.model.data import RodData

_INSTANTS = 8  # for each harmonic, at which a force is examined for its least (a choice)
_HALVINGS = 40  # of a piece, to where it leaves the wall (a choice)


class LeavesWallError(ValueError):
    """A string leaves the wall that it lies on, or lies on both sides of it, so that no linear verdict holds."""


@dataclass(frozen=True, eq=False)
class Lying(ByContent):
    """A string at rest on the wall at some places."""

    angle: Floats  # theta_0 in rad
    contact: Floats  # N, in N/m or in what the wall has for it
    bend: Floats  # curvature towards the wall in 1/m
    aside: Floats  # curvature along it in 1/m

    @property
    def side(self) -> float:
        """1 where all of it lies on the lower half of the wall, -1 on the upper half, 0 on both."""
        low = np.cos(self.angle) >= 0.0
        return 1.0 if low.all() else 0.0 if low.any() else -1.0


@dataclass(frozen=True)
class Wall:
    """The wall at some places: the weight per length of what lies there, and the press of a newton and a curvature.

    Both one for all places, or one for each.
    """

    place: ChannelShape
    weight: Any
    per_newton: Any = 1.0

    def across(self, force: Floats) -> Floats:
        """Return w sin(phi) + F kappa_n under compressions in N."""
        return np.asarray(self.weight * self.place.sine + self.per_newton * force * self.place.kappa_n)

    def lying(self, force: Floats) -> Lying:
        """Return the string at rest under compressions in N."""
        down, side = self.across(force), self.per_newton * force * self.place.kappa_b
        angle = np.arctan2(side, down)
        cos, sin = (np.sign(down), 0.0 * side) if not self.place.turns else (np.cos(angle), np.sin(angle))
        kappa_n, kappa_b = self.place.kappa_n, self.place.kappa_b
        return Lying(angle, np.hypot(down, side), kappa_n * cos + kappa_b * sin, kappa_b * cos - kappa_n * sin)


def added_mean(rod: RodData, load: Load, x: Any) -> Any:
    """Return what the weight along a rod adds to the mean force at x = s / L, in N."""
    return 0.0 * x if load.mean_at is None else weight_gained(rod, x, load.mean_at)


@functools.lru_cache(maxsize=64)  # asked several times in a verdict
def constants_under(rod: RodData, mean: float) -> ModeConstants:
    """Return the constants of the modes on the side where a rod lies under a mean force in N.

    For a rod on a path that bends, or of several sections, the constants of a uniform rod in a uniform channel that
    needs at least as many modes, an estimate.
    """
    constants, course = softest_constants(rod), rod.course
    if course.is_straight:
        return constants
    place, along = course.sampled, rod.along(course.samples)
    lying = Wall(place, along.weight).lying(mean + 0.0 * place.sine)
    if course.is_uniform:
        return constants.on_side(lying.side or 1.0)
    press = lying.contact - mean * lying.bend
    if rod.varies:
        hold = float((press / (along.clearance * along.inertia)).min())
        neutral_squared = (rod.length / math.pi) ** 2 * float((lying.bend / along.clearance).min())
        return constants.pressed(hold)._replace(neutral_squared=neutral_squared)
    unit = constants.weight / (rod.weight_per_length * math.sin(rod.inclination))
    neutral_squared = (rod.length / math.pi) ** 2 / rod.radial_clearance * float(lying.bend.min())
    return constants.pressed(unit * float(press.min()))._replace(neutral_squared=neutral_squared)


def on_wall(rod: RodData, like: Load, loads: Loads) -> Bools:
    """Return under which flat loads of a kind a string lies on one side of its wall, and never leaves it."""
    if rod.course.is_straight:
        return np.ones(loads.size, dtype=np.bool_)
    found = np.empty(loads.size, dtype=np.bool_)
    for frequency in np.unique(loads.frequency).tolist() if not like.is_uniform else [None]:
        at = np.flatnonzero(loads.frequency == frequency) if frequency is not None else np.arange(loads.size)
        wall, x, least, most = _shaken(rod, like, float(loads.frequency[at[0]]) if at.size else 1.0)
        force = loads.mean.ravel()[at, None] + added_mean(rod, like, x)
        lying = wall.lying(force)
        down = wall.across(force) > 0.0
        amplitude = loads.amplitude.ravel()[at, None]
        lost = np.minimum(lying.bend * least, lying.bend * most) * amplitude
        found[at] = (lying.contact + lost > 0.0).all(axis=1) & (down.all(axis=1) | (~down).all(axis=1))
    return found


def require_on_wall(rod: RodData, load: Load, *, only_low: bool = False) -> None:
    """Raise LeavesWallError, saying where and at which force, where a linear verdict does not hold.

    With ``only_low`` also where the rod lies on the high side, for which verdicts alone are known.
    """
    if rod.course.is_straight:
        return
    wall, x, least, most = _shaken(rod, load, load.frequency)
    force = load.mean + added_mean(rod, load, x)
    lying = wall.lying(force)
    down = wall.across(force)
    if down.min() <= 0.0 and (only_low or down.max() > 0.0):
        i = int(np.argmin(np.abs(down)))
        what = f"lies on the low side above and on the high side below, or the other way round, under {force[i]:.6g} N"
        raise _left(rod, x[i], what)
    lost = np.minimum(lying.bend * least, lying.bend * most) * load.amplitude
    i = int(np.argmin(lying.contact + lost))
    if not lying.contact[i] + lost[i] > 0.0:
        shaken = force[i] + load.amplitude * float(least[i] if lying.bend[i] > 0.0 else most[i])
        limit = force[i] - lying.contact[i] / lying.bend[i] if lying.bend[i] else force[i]
        what = f"leaves the wall when its force comes to {limit:.6g} N, and it comes to {shaken:.6g} N"
        raise _left(rod, x[i], what)


def up_to_wall(
    rod: RodData, load: Load, varied: Quantity, piece: tuple[float, float], *, only_low: bool = False
) -> tuple[float, float]:
    """Return a piece of a quantity of the load, in either direction, cut where the rod would leave its wall."""
    if rod.course.is_straight:
        return piece

    def lies(value: float) -> bool:
        try:
            require_on_wall(rod, load.varied(varied, value), only_low=only_low)
        except LeavesWallError:
            return False
        return True

    near, far = piece
    if lies(far) or not lies(near):
        return piece
    for _ in range(_HALVINGS):
        middle = 0.5 * (near + far)
        near, far = (middle, far) if lies(middle) else (near, middle)
    return piece[0], near


def _left(rod: RodData, x: float, what: str) -> ValueError:
    """Return the error for a string that is not on one side of its wall at x = s / L."""
    s = float(x) * rod.length
    at = "" if rod.path is None else f", measured depth {rod.depth + s:.6g} m,"
    return wrong_value(
        "load",
        f"must leave the string on one side of its wall, and at {s:.4g} m from its upper end{at} it {what}: a linear "
        "verdict does not hold; give another mean force, less amplitude, or a part of the well",
        kind=LeavesWallError,
    )


def _shaken(rod: RodData, load: Load, frequency: float) -> tuple[Wall, Floats, Floats, Floats]:
    """Return the wall at places x = s / L, and the least and the largest vibration there for an amplitude of 1 N."""
    x, place = (rod.course.samples, rod.course.sampled) if load.is_uniform else rod.course.sampled_for_waves
    every = axial.along(load, rod.axial_line, x * rod.length, frequency)
    if len(every) == 1:
        most = np.abs(every[0])
        least = -most
    else:
        instants = np.arange(_INSTANTS * len(every)) / (_INSTANTS * len(every))
        turns = np.exp(2j * math.pi * np.outer(instants, np.arange(1, len(every) + 1)))
        over = (turns @ every).real
        least, most = over.min(axis=0), over.max(axis=0)
    return Wall(place, rod.along(x).weight), x, least, most
