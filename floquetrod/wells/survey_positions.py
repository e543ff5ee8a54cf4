"""Directions of a well from the positions of its stations."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.wells.minimum_curvature import Points, WellArcs

_BEND = math.radians(3.0) / 30.0  # rad/m, of the prior for the bend between stations (a choice)
_EXACT = 1e-7  # of a chord, below which digits are lost to rounding (a choice)
_ROUNDS = 12  # of the linear problem, whose chords shorten with the bend (a choice)


def directions(depth: Floats, positions: Floats, step: float) -> tuple[Floats, Floats, float]:
    """Return inclinations and azimuths in rad at stations, and by how much in m the path then misses the positions.

    Parameters
    ----------
    depth : ndarray (n,)
        Measured depths in m, increasing.
    positions : ndarray (n, 3)
        North, east and down in m.
    step : float
        Last digit of the positions in m.

    Notes
    -----
    The chord of an arc has the direction of the sum of the unit tangents at its ends, t_i + t_{i+1} = 2 cos(theta_i/2)
    c_i.  These n - 1 equations leave one tangent free, and errors of rounding alternate from station to station along
    the well.  So tangents are those that satisfy them up to the error of the chords, and bend least: the minimum of
    sum |t_i + t_{i+1} - 2 cos(theta_i/2) c_i|^2 / (4 s_i^2) + sum |t_{i+1} - t_i|^2 / b_i^2 with the errors s_i of the
    chords' directions and usual bends b_i of the intervals, linear for given angles theta_i, which are repeated.  An
    arc of the length l has the chord l (1 - theta^2 / 24 + ...), so that the measured depths limit b_i, too.
    """
    chord = np.diff(positions, axis=0)
    length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
    unit = chord / length[:, None]
    along = np.diff(depth)
    error = np.maximum(0.4 * step / length, _EXACT)  # of both ends, uniform within their last digit
    longest = np.sqrt(24.0 * (np.maximum(along - length, 0.0) + step) / along)  # angle of an arc of this chord
    bend = np.clip(_BEND * along, 1e-3, np.maximum(longest, 1e-3))
    sums, differences = 0.25 / error**2, 1.0 / bend**2
    matrix = np.zeros((3, depth.size))
    matrix[1, :-1] += sums + differences
    matrix[1, 1:] += sums + differences
    matrix[0, 1:] = sums - differences
    matrix[2, :-1] = sums - differences
    from scipy.linalg import solve_banded

    tangent = np.concatenate([unit[:1], unit])
    for _ in range(_ROUNDS):
        half = 0.5 * np.linalg.norm(tangent[1:] + tangent[:-1], axis=1)  # cos(theta / 2)
        right = np.zeros((depth.size, 3))
        pull = (2.0 * half * sums)[:, None] * unit
        right[:-1] += pull
        right[1:] += pull
        tangent = solve_banded((1, 1), matrix, right)
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    level = np.hypot(tangent[:, 0], tangent[:, 1])
    inclination = np.arctan2(level, tangent[:, 2])
    azimuth = np.where(level > _EXACT, np.arctan2(tangent[:, 1], tangent[:, 0]) % (2.0 * math.pi), 0.0)
    arcs = WellArcs.between(depth, inclination, azimuth)
    ends = np.cumsum(Points(arcs, np.arange(along.size), arcs.length).moved, axis=0)
    miss = float(np.linalg.norm(ends - (positions[1:] - positions[0]), axis=1).max())
    return inclination, np.asarray(azimuth), miss
