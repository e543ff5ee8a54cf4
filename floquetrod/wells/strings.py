"""Strings that are pushed or pulled through a well, with a tool or without: their force from the lower end up."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.wells import march
from floquetrod.wells.arcs import Floats
from floquetrod.wells.drag import LOCKED, Drag, Effort, States, Strings

_PASSES = 30  # over what is below a tool at most: four are usual
_STEEP = 0.1, 10.0  # slopes of what is missing, negative, between which a secant is trusted
_CLOSE = 1e-10  # m/s of a wave, between passes


def run(
    drag: Drag, top: float, bottoms: Floats, far_force: Any, depths: Floats, effort: Effort, is_shaken: Any = True
) -> States:
    """Return the states at measured depths of strings whose lower ends are at ``bottoms`` in m.

    The force in N at the lower end is one for all or of each its own; so is ``is_shaken``, which says in which of them
    the tool works, where there is one.
    """
    size = bottoms.size
    start = np.broadcast_to(drag.y_of(np.asarray(far_force)), size)
    wave = np.where(np.broadcast_to(is_shaken, size), 0.0 if drag.shaking is None else drag.shaking.wave, 0.0)
    strings = Strings(np.full(size, top), bottoms, start, wave)
    if drag.shaking is None or not drag.shaking.above_end:
        return march.up(drag, strings, depths, effort)
    tools = np.maximum(bottoms - drag.shaking.above_end, top)
    wave = np.where(tools > top, wave, 0.0)
    below = _below(drag, strings._replace(top=tools), wave, depths, effort)
    above = march.up(drag, strings._replace(bottom=tools, y=below.top_y, wave=wave), depths, effort)
    y, waves = (np.where(np.isnan(a), b, a) for a, b in ((above.y, below.y), (above.wave, below.wave)))
    return above._replace(y=y, wave=waves)


def _below(drag: Drag, strings: Strings, wave: Floats, depths: Floats, effort: Effort) -> States:
    """Return the states below the tools, where waves run down: they have ``wave`` at the tool, which is on top.

    The wave at the lower end is found by secants, that of a string that hardly moves by what is missing at the tool.
    """
    close = max(_CLOSE, 1e-2 * float(np.max(effort.tolerance))) * (1.0 + wave.max())
    at_end, before, lacked = wave, wave, np.zeros(wave.size)
    for _ in range(_PASSES):
        found = march.up(drag, strings._replace(wave=at_end), depths, effort, towards=1.0)
        missing = np.where(found.top_y < LOCKED, wave - found.top_wave, 0.0)  # none passes a lock-up
        if np.abs(missing).max() <= close:
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (missing - lacked) / (at_end - before)
        before, lacked = at_end, missing
        at_end = at_end - missing / np.where((slope < -_STEEP[0]) & (slope > -_STEEP[1]), slope, -1.0)
    return found
