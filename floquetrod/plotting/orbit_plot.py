"""Pictures of periodic orbits."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import axes_or_new

STYLES = {"stable": "-", "unstable": "--", "undecided": ":"}
"""Lines of orbits, and of parts of branches, by their verdict."""

_MOST = 6  # states in one picture
_WEIGHTS = (1.6, 1.0, 1.6, 1.0, 1.6, 1.0)
_COLOURS = ("black", "black", "0.45", "0.45", palette.NEUTRAL, palette.NEUTRAL)


def draw_orbit(orbit: Any, ax: Any = None) -> Any:
    """Draw the states of a `floquetrod.results.PeriodicOrbit` over a period, in a line that tells its verdict."""
    ax = axes_or_new(ax)
    at = orbit.extremes  # a peak may be shorter than the picture's steps
    peaks = orbit.period * np.concatenate([at.least_at, at.largest_at])
    time = np.unique(np.concatenate([np.linspace(0.0, orbit.period, 1000), orbit.times, peaks]))
    states = orbit(time)
    count = min(_MOST, states.shape[1])
    for i in range(count):
        style = {"linestyle": STYLES[orbit.status], "linewidth": _WEIGHTS[i], "color": _COLOURS[i]}
        ax.plot(time, states[:, i], label=f"x[{i}]", **style)
    ax.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    ax.set_xlim(0.0, orbit.period)
    ax.set_xlabel("t, over a period")
    ax.set_ylabel("states" if count == states.shape[1] else f"states, the first {count} of {states.shape[1]}")
    ax.set_title(f"{orbit.status} orbit, period {orbit.period:.6g}", fontsize="small")
    ax.legend(loc="best", fontsize="small", frameon=False)
    return ax
