"""The record that holds a simulated rod, and the numbers of its physics: what the kernels of `rod_step` take."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FIRST = 2
"""Place of node 0 and of segment 0 in the fields of a record; before and after come ghost cells."""

NODE = ("x", "y", "z", "vx", "vy", "vz", "angle", "spin")
"""Of nodes: position, velocity; angle and rate of spin about the rod's own axis."""

LOST = ("lost_contact", "lost_friction", "lost_damping")
"""Of nodes: energy lost so far to each cause, per length of a node and per mass in motion across."""

PARTS = ("share", "grip")
"""Of nodes: their part of the rod, in segments; their coefficient of friction, 0 at an end that is held or moved, whose
share is taken apart."""

ONCE = ("anchor", "cosines", "sines", "work", "impulse", "clock")
"""Offset from the channel's axis at which the upper and the lower end are held, three numbers each.  Cosines and sines
of harmonics 1, 2, ... of the vibration, in N.  Work done by the end forces so far.  Impulses by which the upper and the
lower end have been pushed so far.  Steps done so far."""

SCRATCH = ("d1", "d2", "d3", "inverse", "tension", "f1", "f2", "f3", "torque")
"""Of segments: direction, 1 / |t|, tension, gradient of the energy by t, torque of twist."""

ANCHOR = ("c1", "c2", "c3", "t1", "t2", "t3", "k1", "k2", "k3", "place", "arc")
"""Of nodes in a well: the point of the axis, its tangent and curvature; its distance along the axis, and its arc."""

NATURAL = ("b1", "b2", "b3", "shift")
"""In a well, of segments: what the stencil of bending makes of the directions of the natural shape.  Of the upper and
the lower end, three numbers each: the offset of the ghost node of a naturally curved rod from a straight rod's."""


SECTIONS = (
    *("mass", "mass_along", "inertia", "gravity", "gravity_along", "outer", "contact", "contact_time"),
    *("gap", "taper", "mark"),
    *("stretch", "twist", "bend", "bend_next", "bend_second"),
)
"""Of a rod that varies along.

Of nodes: masses of a segment across and along, moment of inertia about its own axis; acceleration by weight towards the
floor (in a well, along gravity) and towards the lower end; outer radius, k and C of the contact; radial clearance at
the place ``mark``, and how fast it grows from there.  Of segments: E A / l, G J / l, and what the gradient of the
energy of bending has of the direction of the segment itself, of the next one and of the second one, over l.
"""


def rod_type(segments: int, *, in_well: bool = False, varies: bool = False) -> np.dtype[np.void]:
    """Return the record that holds a rod of so many segments.

    The lengths of its fields are part of its type: compilers then know that fields do not overlap, and vectorise loops
    over any number of them.  They come in few sizes because each is compiled again, for some five seconds: one serves
    every rod of up to 514 segments, and is no slower for few of them (measured).  Sizes are odd multiples of 64 bytes
    because rows at powers of two would compete for the same lines of the cache.
    """
    size = 512
    while size + 2 < segments:
        size *= 2
    # What not every rod has comes first: to numba a record with more fields at its end is one of the shorter kind.
    special = (*(SECTIONS if varies else ()), *((*ANCHOR, *NATURAL) if in_well else ()))
    fields = (*special, *NODE, *LOST, *PARTS, *ONCE, *SCRATCH)
    return np.dtype([(name, np.float64, (size + 8,)) for name in fields])


HINGED, CLAMPED, GUIDED, FREE = range(4)
"""What an end may be across the channel."""


class End(NamedTuple):
    """One end of a rod: what it may do across the channel and along it."""

    across: int  # HINGED, CLAMPED, GUIDED or FREE
    moved: bool  # whether it moves along the channel at a given speed, else it is pushed by a force
    speed: float  # the speed, in the direction of a push
    mean: float  # mean of the force that pushes it
    drive: float  # the part of the vibration that pushes it, 0 or 1

    @property
    def is_held(self) -> bool:
        """Whether it is held across the channel."""
        return self.across in (HINGED, CLAMPED)


class ToolForce(NamedTuple):
    """A tool in the rod that pushes it down and pulls it up with two sines, the second perhaps of amplitude 0.

    Without a tool the node is -1: numba would compile the loop once more for None, for ten seconds and more.
    """

    amplitude: float
    frequency: float
    node: int  # the last one above it; -1 without a tool
    beyond: float  # its distance from there, in segments
    second_amplitude: float
    second_frequency: float
    phase: float  # of the second, in rad


NO_TOOL = ToolForce(0.0, 0.0, -1, 0.0, 0.0, 0.0, 0.0)


class Well(NamedTuple):
    """What `Physics` has of a well: the axis of its channel, and the weight as a vector."""

    gravity: tuple[float, float, float]  # weight over the mass in motion across; its direction where the rod varies
    weight_along: float  # 1 where the weight acts along the channel too, else 0
    arcs: NDArray[np.float64]  # a row each: place of its upper end; point, tangent and normal there; curvature


class WallCorners(NamedTuple):
    """The wall of the channel of a rod that varies along."""

    corners: NDArray[
        np.float64
    ]  # a row each: a place along the channel, radius there, and how fast it grows from there


class Physics(NamedTuple):
    """Rod, channel, ends, load and time step as the loop uses them, in SI units.

    Of a rod that varies along, numbers that its record has are NaN here.
    """

    segments: int
    step: float
    segment: float  # unstrained length of a segment
    mass: float  # of a segment in motion across the channel
    mass_along: float  # and along it
    inertia: float  # of a segment about its own axis
    stretch: float  # EA
    bend: float  # EI
    twist: float  # GJ
    radius: float
    radial_clearance: float  # R, where contact begins
    gravity: float  # acceleration towards the floor
    gravity_along: float  # and towards the lower end
    contact: float  # k in the contact acceleration k sqrt(d) (d + C v)
    contact_damping: float  # C
    friction: float  # the largest coefficient
    grips: NDArray[np.float64]  # a row each: a place along the channel, and the coefficient from there on
    decay: float  # factor on velocities across and on spins in half a step
    decay_along: float  # and on velocities along
    frequency: float
    harmonics: int  # of the vibration
    upper: End
    lower: End
    steps_before: float = 0.0  # in which the load has acted before the clock of the record began
    tool: ToolForce = NO_TOOL
    well: Any = None  # a `Well`, or None in a straight channel
    wall: Any = None  # a `WallCorners`, or None of a uniform rod in one bore
