"""Drawings of stability lobes."""

from __future__ import annotations

import itertools
import math
from typing import Any

from floquetrod.plotting import palette

_ROOM = (0.09, 0.07)
"""Parts of the axes that a name takes: another one so near it is left out."""

_LOWEST = 0.9
"""Part of the height below which a lobe's lowest point must be for it to be named."""


def draw_lobes(lobes: Any, ax: Any = None) -> Any:
    """Draw `floquetrod.milling.lobes.Lobes`: the chart, and lobes named where they are lowest, wide ones first.

    Neighbours of one kind and number share a name.
    """
    ax = lobes.chart.plot(ax)
    across, up = lobes.chart.x.values, lobes.chart.y.values
    alike = [list(group) for _, group in itertools.groupby(lobes.lobes, lambda lobe: (lobe.kind, lobe.number))]
    placed: list[tuple[float, float]] = []
    for group in sorted(alike, key=lambda group: group[0].speeds[0] - group[-1].speeds[1]):
        lobe = min(group, key=lambda lobe: lobe.depth)
        at, depth = 30.0 / math.pi * lobe.at, 1e3 * lobe.depth
        share = (at - across[0]) / (across[-1] - across[0]), (depth - up[0]) / (up[-1] - up[0])
        near = any(abs(share[0] - x) < _ROOM[0] and abs(share[1] - y) < _ROOM[1] for x, y in placed)
        if near or share[1] > _LOWEST:
            continue
        placed.append(share)
        side = "left" if share[0] < 0.05 else "right" if share[0] > 0.95 else "center"
        ax.annotate(
            f"{lobe.kind} {lobe.number}",
            (at, depth),
            xytext=({"left": 4, "center": 0, "right": -4}[side], 12),
            textcoords="offset points",
            ha=side,
            fontsize="small",
            bbox=palette.BOX,
        )
    return ax
