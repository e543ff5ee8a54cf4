"""Strings that are pushed or pulled through a well, with a tool or without: their force from the lower end up."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.wells import march
from floquetrod.wells.arcs import Floats
from floquetrod.wells.drag import Drag, Effort, States, Strings

_PASSES = 30  # over what is below a tool: each brings four digits
_CLOSE = 1e-10  # m/s of a wave, between passes


def run(
    drag: Drag, top: float, bottoms: Floats, far_force: float, depths: Floats, effort: Effort, is_shaken: Any = True
) -> States:
    """Return the states at measured depths of strings whose lower ends are at ``bottoms`` in m.

    The tool, where there is one, works in those of which ``is_shaken`` is true, one for all or of each its own.
    """
    size = bottoms.size
    start = float(drag.y_of(np.array(far_force)))
    wave = np.where(np.broadcast_to(is_shaken, size), 0.0 if drag.shaking is None else drag.shaking.wave, 0.0)
    strings = Strings(np.full(size, top), bottoms, np.full(size, start), wave)
    if drag.shaking is None or not drag.shaking.above_end:
        return march.up(drag, strings, depths, effort)
    tools = np.maximum(bottoms - drag.shaking.above_end, top)
    wave = np.where(tools > top, wave, 0.0)
    below = _below(drag, strings._replace(top=tools), wave, depths, effort)
    above = march.up(drag, strings._replace(bottom=tools, y=below.top_y, wave=wave), depths, effort)
    y, waves = (np.where(np.isnan(a), b, a) for a, b in ((above.y, below.y), (above.wave, below.wave)))
    return above._replace(y=y, wave=waves)


def _below(drag: Drag, strings: Strings, wave: Floats, depths: Floats, effort: Effort) -> States:
    """Return the states below the tools, where waves run down: they have ``wave`` at the tool, which is on top."""
    at_end = wave
    for _ in range(_PASSES):
        found = march.up(drag, strings._replace(wave=at_end), depths, effort, towards=1.0)
        missing = np.where(
            found.top_y < 0.5 * np.pi, wave - found.top_wave, 0.0
        )  # none gets past where it is locked up
        if np.abs(missing).max() <= _CLOSE * (1.0 + wave.max()):
            break
        at_end = at_end + missing
    return found
