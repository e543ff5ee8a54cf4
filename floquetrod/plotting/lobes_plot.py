"""Drawings of stability lobes."""

from __future__ import annotations

import textwrap
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.plotting import labels, palette

_WIDE = 60
"""Characters of a line within axes."""


class LobeOutline(NamedTuple):
    """A polygon, in the units of the axes."""

    x: Floats
    y: Floats


def draw_lobes(lobes: Any, ax: Any = None) -> Any:
    """Draw stability lobes: the chart, with names inside the lobes that have room for them.

    Where there are none the chart says why.
    """
    ax = lobes.chart.plot(ax)
    if lobes.lobes:
        names = [f"{lobe.kind} {lobe.number}" for lobe in lobes.lobes]
        labels.add_names(ax, names, [outline(lobes, lobe) for lobe in lobes.lobes])
    else:
        style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small", "in_layout": False}
        text = textwrap.fill(lobes.none_in_range, _WIDE)
        ax.text(0.5, 0.5, text, transform=ax.transAxes, bbox=palette.BOX, **style)
    return ax


def outline(lobes: Any, lobe: Any) -> LobeOutline:
    """Return the polygon of a lobe on its chart: at its speeds from the critical depth up to where nothing grows."""
    chart = lobes.chart
    first, last = np.searchsorted(lobes.speeds, lobe.speeds)
    columns = np.arange(first, last + 1)
    low, depths = 1e3 * lobes.depths[columns], chart.y.values
    ends = chart.stable[:, columns] & (depths[:, None] > low)
    stable_again = np.where(ends.any(axis=0), ends.argmax(axis=0), depths.size)
    top = np.maximum(depths[np.maximum(stable_again - 1, 0)], low)
    x = chart.x.values[columns]
    return LobeOutline(np.concatenate([x, x[::-1]]), np.concatenate([low, top[::-1]]))
