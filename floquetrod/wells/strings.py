"""Strings pushed or pulled through a well, with a tool or without: their force from the lower end up.

The wave of a tool depends on the contact force along the string, and the force on the friction that the wave leaves.
Both are computed in turns until the force stays along all of the string.  A string that does not settle is about to
lock up or has: it counts as stopped.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.compilation import cores, in_threads
from floquetrod.wells import march
from floquetrod.wells.drag import Drag, Fineness, Shaking, Strings
from floquetrod.wells.shaken_string import ShakenString

_TURNS = 30  # at most: seven are usual; of two waves, which settle beside each other, three times as many
_STAYS = 1e-7, 10.0  # largest change of y in the last turn: at least, and over the tolerance
_WAVE_ROWS = 5
_MOST_WAVES = 500  # along a string (a choice): tools make some twenty


class Run(NamedTuple):
    """Y of strings at depths, (m, n), at their upper ends, (n,), and where j + 1 sections meet, (j, n).

    Beside these what their tools' waves do, (5, m, n): the amplitudes of the velocity in m/s and of the force in N, of
    two waves their sums, 0 without a tool, the share of friction left, and the amplitudes of the second wave alone, 0
    without; the amplitude of the force where sections meet; and whether forces and waves have settled, (n,), without
    which y is meaningless.
    """

    depth: Floats
    y: Floats
    top_y: Floats
    wave: Floats
    is_settled: Bools
    joint_y: Floats
    joint_vibration: Floats


def run(drag: Drag, top: float, bottoms: Floats, far_force: Any, depths: Floats, fineness: Fineness) -> Run:
    """Return the states at measured depths of strings whose lower ends are at ``bottoms`` in m.

    ``far_force`` in N at the lower end is one for all, or (n,).
    """
    size, depths = bottoms.size, np.unique(depths)
    start = np.array(drag.y_of(drag.above_end(far_force, bottoms)))
    strings = Strings(np.full(size, top), bottoms, start)
    y, wave = np.empty((depths.size, size)), np.empty((_WAVE_ROWS, depths.size, size))
    joints = np.zeros((2, 0 if drag.assembly is None else drag.assembly.inner.size, size))
    states = Run(depths, y, np.empty(size), wave, np.ones(size, bool), *joints)
    works = np.zeros(size, bool)
    if drag.shaking is not None:
        works = (bottoms - drag.shaking.above_end > top) & (drag.shaking.amplitude > 0.0)
    for i, is_working in ((np.flatnonzero(~works), False), (np.flatnonzero(works), True)):
        if i.size:
            group = Strings(*(column[i] for column in strings))
            if is_working and drag.shaking is not None:
                run_of_group = _shaken(drag, drag.shaking.of(size, i), group, depths, fineness)
            else:
                group_y, top_y, joint_y = march.up(drag, group, depths, fineness)
                no_wave = np.array([0.0, 0.0, 1.0, 0.0, 0.0])[:, None, None] + np.zeros(group_y.shape)
                still = no_wave, np.ones(i.size, bool), joint_y, np.zeros(joint_y.shape)
                run_of_group = Run(depths, group_y, top_y, *still)
            states.y[:, i], states.top_y[i] = run_of_group.y, run_of_group.top_y
            states.wave[..., i], states.is_settled[i] = run_of_group.wave, run_of_group.is_settled
            states.joint_y[:, i], states.joint_vibration[:, i] = run_of_group.joint_y, run_of_group.joint_vibration
    return states


def _shaken(drag: Drag, shaking: Shaking, strings: Strings, depths: Floats, fineness: Fineness) -> Run:
    """Return the states of strings with a tool, each of its own frequency."""
    size, stays = strings.y.size, max(_STAYS[0], _STAYS[1] * fineness.tolerance)
    number = float(((strings.bottom - strings.top) / shaking.length).max())
    if number > _MOST_WAVES:
        raise validate.wrong_value(
            "tool", f"must make {_MOST_WAVES} waves along the string at most, got {number:.4g}: give a lower frequency"
        )
    inner = np.empty(0) if drag.assembly is None else drag.assembly.inner
    y, wave = np.empty((depths.size, size)), np.empty((_WAVE_ROWS, depths.size, size))
    states = Run(depths, y, np.empty(size), wave, np.empty(size, bool), *np.empty((2, inner.size, size)))
    frequency = np.broadcast_to(shaking.frequency, size).tolist()

    def settle(k: int) -> None:
        top, bottom, y = (float(column[k]) for column in strings)
        string = ShakenString(drag, replace(shaking, frequency=frequency[k]), top, bottom, y, fineness)
        states.is_settled[k] = string.settle(stays, _TURNS if shaking.second is None else 3 * _TURNS)
        states.top_y[k] = string.marched.y[-1]
        if depths.size:
            states.y[:, k], states.wave[..., k] = string.y_at(depths), string.wave_at(depths)
        if inner.size:
            joints = bottom - inner
            states.joint_y[:, k], states.joint_vibration[:, k] = string.y_at(joints), string.wave_at(joints)[1]

    in_threads(settle, [(k,) for k in range(size)], cores())
    return states


def highest_frequency(shaking: Shaking, length: float) -> float:
    """Return the highest frequency in rad/s of a tool in a string of a length in m."""
    return 2.0 * math.pi * shaking.wave_speed * _MOST_WAVES / length
