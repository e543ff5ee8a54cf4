"""Strings that are pushed or pulled through a well, with a tool or without: their force from the lower end up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floquetrod.wells.arcs import Floats
from floquetrod.wells.drag import Drag, Effort, States, Strings

_PASSES = 30  # over what is below a tool: each brings four digits
_CLOSE = 1e-10  # m/s of a wave, between passes


def run(drag: Drag, top: float, bottoms: Floats, far_force: float, depths: Floats, effort: Effort) -> States:
    """Return the states at measured depths of strings whose lower ends are at ``bottoms``, increasing, in m."""
    strings = Strings(
        np.full(bottoms.size, top),
        bottoms,
        np.full(bottoms.size, float(drag.y_of(np.array(far_force)))),
        np.full(bottoms.size, 0.0 if drag.shaking is None else drag.shaking.wave),
    )
    if drag.shaking is None or not drag.shaking.above_end:
        return drag.up(strings, depths, effort)
    tools = bottoms - drag.shaking.above_end
    is_in = tools > top
    below = _below(
        drag, strings._replace(top=np.maximum(tools, top)), np.where(is_in, drag.shaking.wave, 0.0), depths, effort
    )
    if not is_in.any():
        return below
    at_tool = below.y[np.searchsorted(below.depth, tools[is_in]), np.flatnonzero(is_in)]
    kept = Strings(*(each[is_in] for each in (strings.top, tools, strings.y, strings.wave)))
    return _joined(below, drag.up(kept._replace(y=at_tool), depths, effort), is_in)


def _below(drag: Drag, strings: Strings, wave: Floats, depths: Floats, effort: Effort) -> States:
    """Return the states below the tools, where waves run down: they have ``wave`` at the tool, which is on top."""
    places = np.arange(strings.top.size)
    at_end = wave
    for _ in range(_PASSES):
        found = drag.up(strings._replace(wave=at_end), depths, effort, towards=1.0)
        missing = wave - found.wave[np.searchsorted(found.depth, strings.top), places]
        if np.abs(missing).max() <= _CLOSE * (1.0 + wave.max()):
            break
        at_end = at_end + missing
    return found


def _joined(below: States, above: States, is_in: NDArray[np.bool_]) -> States:
    """Return the states along whole strings."""
    depth = np.union1d(below.depth, above.depth)
    y, wave = np.full((2, depth.size, is_in.size), np.nan)
    for states, columns in ((below, np.arange(is_in.size)), (above, np.flatnonzero(is_in))):
        rows = np.searchsorted(depth, states.depth)
        for whole, part in ((y, states.y), (wave, states.wave)):
            there = ~np.isnan(part)
            block = whole[np.ix_(rows, columns)]
            block[there] = part[there]
            whole[np.ix_(rows, columns)] = block
    return States(depth, y, wave)
