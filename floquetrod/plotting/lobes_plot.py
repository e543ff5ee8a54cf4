"""Drawings of stability lobes."""

from __future__ import annotations

import math
import textwrap
from typing import Any

from floquetrod.plotting import palette
from floquetrod.plotting.leaders import add_leaders

_WIDE = 60
"""Characters of a line within axes."""

_NAMED = 12  # lobes that are named, those whose lowest parts are widest (a choice)
_FARTHEST = 40.0  # typographic points from a lobe to its name (a choice)


def draw_lobes(lobes: Any, lowest: list[Any], ax: Any = None) -> Any:
    """Draw stability lobes: the chart, with names near the points of the widest ones of the ``lowest`` parts.

    Where there are none the chart says why.
    """
    ax = lobes.chart.plot(ax)
    if lobes.lobes:
        widest = sorted(lowest, key=lambda lobe: lobe.speeds[0] - lobe.speeds[1])[:_NAMED]
        names = [f"{lobe.kind} {lobe.number}" for lobe in widest]
        points = [(30.0 * lobe.at / math.pi, 1e3 * lobe.depth) for lobe in widest]
        add_leaders(ax, names, points, list(lobes.chart.bands), _FARTHEST)
    else:
        style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small", "in_layout": False}
        text = textwrap.fill(lobes.none_in_range, _WIDE)
        ax.text(0.5, 0.5, text, transform=ax.transAxes, bbox=palette.BOX, **style)
    return ax
