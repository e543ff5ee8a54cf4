"""Where the teeth of a cutter cut, and which earlier tooth left the surface they cut.

A tooth that stands back, or whose surface was cut deeper by an earlier one, cuts nothing: the next one then meets the
surface of two pitches ago.  The chip of tooth j, at the angle phi from y, over the surface left l teeth earlier is

    h_l(phi) = feed per turn (angle between both) / (2 pi) sin phi + r_j - r_(j+l),

and the least of these is the chip cut, where it is positive.
J. Tlusty and F. Ismail, CIRP Annals 30 (1981) 299, doi:10.1016/S0007-8506(07)60946-9.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats

_NARROWEST = 1e-9  # rad: narrower arcs are none
_EQUAL = 1e-12  # rad or m: pitches and radii apart by less are equal
_DENOMINATOR = 7200  # of parts of a turn that pitches in whole twentieths of a degree are (a choice)


class Arc(NamedTuple):
    """Angles in rad from which to which a tooth cuts a surface that the cutter left so many rad earlier."""

    tooth: int
    start: float
    end: float
    delay: float


def teeth_that_repeat(pitch: Sequence[float], runout: Sequence[float]) -> int:
    """Return after how many teeth pitch and runout repeat, all around the cutter."""
    teeth = len(pitch)
    values = np.column_stack([pitch, runout])
    for count in range(1, teeth):
        if teeth % count == 0 and np.abs(np.roll(values, count, axis=0) - values).max() < _EQUAL:
            return count
    return teeth


def arcs(pitch: Sequence[float], runout: Sequence[float], feed: float, angles: tuple[float, float]) -> tuple[Arc, ...]:
    """Return the arcs that teeth cut.

    Parameters
    ----------
    pitch : sequence of float
        Angle in rad from each tooth to the one that cuts before it.
    runout : sequence of float
        Radius of each in m, beyond any mean.
    feed : float
        Per turn, in m; of no effect without runout.
    angles : (float, float)
        At which a tooth enters and leaves, in rad, between 0 and pi.
    """
    if not np.ptp(runout) > 0.0:
        return tuple(Arc(tooth, *angles, delay) for tooth, delay in enumerate(pitch))
    return tuple(arc for tooth in range(len(pitch)) for arc in _arcs_of(tooth, pitch, runout, feed, angles))


def _arcs_of(
    tooth: int, pitch: Sequence[float], runout: Sequence[float], feed: float, angles: tuple[float, float]
) -> list[Arc]:
    """Return the arcs of one tooth: where the least chip is positive, by the surface that it is cut from."""
    spans = np.cumsum(np.roll(pitch, -tooth))
    slopes = feed * spans / (2.0 * math.pi)  # of chips over sin phi
    steps = runout[tooth] - np.roll(runout, -tooth - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = (steps[:, None] - steps) / (slopes - slopes[:, None])
    sines = np.concatenate([crossings[np.triu_indices(len(spans), 1)], -steps / slopes])
    sines = sines[(sines > 0.0) & (sines < 1.0)]
    turns = np.arcsin(sines)
    inside = [angle for angle in np.concatenate([turns, math.pi - turns]).tolist() if angles[0] < angle < angles[1]]
    edges = apart([angles[0], *sorted(inside), angles[1]])
    listed: list[Arc] = []
    for start, end in pairwise(edges):
        chips = slopes * math.sin(0.5 * (start + end)) + steps
        least = int(chips.argmin())
        if chips[least] <= 0.0:
            continue
        if listed and listed[-1].end == start and listed[-1].delay == spans[least]:
            listed[-1] = listed[-1]._replace(end=end)
        else:
            listed.append(Arc(tooth, start, end, float(spans[least])))
    return listed


def apart(edges: Sequence[float], least: float = _NARROWEST) -> list[float]:
    """Return sorted edges without any that is nearly the one before it, with the last one."""
    kept = [edges[0]]
    for edge in edges[1:-1]:
        if edge - kept[-1] > least and edges[-1] - edge > least:
            kept.append(edge)
    return [*kept, edges[-1]]


def part(angle: float, whole: float) -> Fraction:
    """Return an angle as part of another, as a plain fraction where rounding alone keeps it from being one."""
    exact = Fraction(angle / whole)
    plain = exact.limit_denominator(_DENOMINATOR)
    return plain if abs(plain - exact) < _EQUAL else exact


def means_of_products(angle: Floats, lag: float, start: float, end: float) -> tuple[Floats, Floats, Floats]:
    """Return means of sin^2, sin cos and cos^2 over the edge of a helical tooth, as far as it cuts.

    The edge lies between angle - lag and angle, in rad, and cuts between start and end.  Products of sines are
    integrated in closed form, without differences of nearly equal numbers where a tooth enters.
    """
    sums = [np.zeros(angle.shape) for _ in range(3)]
    for turn in range(math.ceil(lag / (2.0 * math.pi)) + 1):
        high = np.minimum(angle + 2.0 * math.pi * turn, end)
        low = np.maximum(angle + 2.0 * math.pi * turn - lag, start)
        width = np.maximum(high - low, 0.0)
        share, chord = 0.5 * width / lag, np.sinc(width / math.pi)
        square = width * width
        flat = np.where(width < 0.1, square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)), 1.0 - chord)
        odd, turned = chord * np.sin(high + low), flat * np.cos(high + low)
        squares = 2.0 * np.sin(0.5 * (high + low)) ** 2 + turned, 2.0 * np.cos(0.5 * (high + low)) ** 2 - turned
        for total, value in zip(sums, (squares[0], odd, squares[1]), strict=True):
            total += share * value
    return sums[0], sums[1], sums[2]
