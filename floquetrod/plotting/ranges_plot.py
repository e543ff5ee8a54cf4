"""The drawing of stable and unstable intervals along one quantity of a load."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util.arrays import Floats
from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import NAMES, axes_or_new, colours, explain, patch, typeset
from floquetrod.plotting.leaders import add_leaders
from floquetrod.units import Unit

_NAMED = 6  # stable ranges and unstable bands that are named, the widest ones and the fastest (a choice)
_SPAN = 0.86  # of the height, at which stable ranges are spanned (a choice)
_NARROW = 0.03  # of the axis, below which a stable range is not named (a choice)


class _Bar(NamedTuple):
    """A polygon, in the units of the axes."""

    x: Floats
    y: Floats


def draw_ranges(
    found: Any, unit: Unit, safe: Sequence[tuple[str, str]], in_words: Callable[[Any], str], ax: Any = None
) -> Any:
    """Draw `floquetrod.results.StabilityIntervals`: unstable bands shaded, as high as the fastest growth in them.

    ``safe`` are the safe ranges of the report, as it writes them; ``in_words`` names the cause of a band.
    """
    ax = axes_or_new(ax)
    low, high = unit.of(found.bounds[0]), unit.of(found.bounds[1])
    fastest = max((band.worst_growth for band in found.unstable), default=0.0)
    bars = []
    for band in found.unstable:
        ends = unit.of(band.low), unit.of(band.high)
        ax.axvspan(*ends, facecolor=palette.UNSEEN, edgecolor=palette.UNSEEN, linewidth=0.6, zorder=0.5)
        bars.append(_Bar(np.array([*ends, *ends[::-1]]), np.repeat([0.0, band.worst_growth], 2)))
        ax.fill(*bars[-1], facecolor=palette.UNSTABLE, edgecolor=palette.UNSTABLE, linewidth=0.8, zorder=1.0)
    for gap in found.not_computed:
        ends = unit.of(gap.low), unit.of(gap.high)
        ax.axvspan(*ends, facecolor=palette.NEUTRAL, edgecolor=palette.NEUTRAL, linewidth=0.6, zorder=0.6)
    ax.set_xlim(low, high)
    top = 1.5 * fastest or 1.0
    ax.set_ylim(0.0, top)
    growing = sorted((b for b in found.unstable if b.worst_growth > 0.0), key=lambda b: -b.worst_growth)[:_NAMED]
    names = [in_words(band.cause) for band in growing]
    points = [(float(unit.of(0.5 * (band.low + band.high))), band.worst_growth) for band in growing]
    spans = sorted(((float(ends[0]), float(ends[1]), " to ".join(ends)) for ends in safe), key=lambda s: s[0] - s[1])
    for i, (left, right, name) in enumerate(spans):
        ax.plot([left, right], [_SPAN * top, _SPAN * top], color="black", marker="|", linewidth=0.8)
        if i >= _NAMED or right - left <= _NARROW * (high - low):
            continue
        names.append(name)
        points.append((0.5 * (left + right), _SPAN * top))
    add_leaders(ax, names, points, bars)
    ax.set_xlabel(units.label(*NAMES[found.searched.search.varied], unit.name))
    what = "growth of $q^2$" if found.searched.search.load.noise else "growth"
    ax.set_ylabel(f"fastest {what} / (1/s)")
    ax.set_title(_title(found, unit), fontsize="medium")
    areas = [colours("", "stable")[1]]
    if found.unstable:
        seen = sorted({band.status for band in found.unstable}, reverse=True)
        areas.append(patch(" or ".join(seen), {"facecolor": palette.UNSEEN}))
    if growing:
        areas.append(patch("fastest growth in the band", {"facecolor": palette.UNSTABLE}))
    if found.not_computed:
        areas.append(patch("not computed: axial resonance", {"facecolor": palette.NEUTRAL}))
    explain(ax, areas, found.note)
    return ax


def _title(found: Any, unit: Unit) -> str:
    """Return what varies, and what the other quantities of the load are, forces in one unit."""
    search, given = found.searched.search, found.given_units
    force = unit if search.varied != "frequency" else units.AnswerUnits.named(given=given).force
    frequency = units.unit(given.frequency or "Hz", "", "frequency")
    shown = {"mean": force, "amplitude": force, "frequency": frequency}
    fixed = [
        f"{NAMES[name][0]} {_digits(each.of(getattr(search.load, name)))} {each.name}"
        for name, each in shown.items()
        if name != search.varied
    ]
    return typeset(f"{found.quantity}, at {' and '.join(fixed)}")


def _digits(value: float) -> str:
    """Return a number to three digits, without a power of ten."""
    return f"{float(f'{value:.3g}'):,.10g}"
