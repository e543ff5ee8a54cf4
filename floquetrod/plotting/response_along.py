"""Pictures of the motion of a rod that is not straight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import axes_or_new, explain

_INSTANTS = 64  # of a period, between which the deflection hardly changes


def draw_rod_response(response: Any, ax: Any = None) -> Any:
    """Draw a `floquetrod.results.RodResponse` along the rod: its mean, its range over a period, its shape without load.

    Of a random shape the standard deviations, which are not negative.
    """
    ax = axes_or_new(ax)
    places, shape = response.positions, response.rod.natural_shape
    period = 2.0 * math.pi / response.load.frequency
    motion = 1e3 * response.deflection(np.arange(_INSTANTS) * (period / _INSTANTS))
    patterns = 1e3 * shape.patterns(places / response.rod.length, response.rod.length).deflection
    free = np.sqrt((patterns**2).sum(axis=0)) if response.is_random else patterns[0]
    low, high = motion.min(axis=0), motion.max(axis=0)
    name = "standard deviation" if response.is_random else "deflection"
    reached = ax.fill_between(places, low, high, color=palette.NEUTRAL, linewidth=0.0, label="range over a period")
    (mean,) = ax.plot(places, 1e3 * response.mean, color="black", linewidth=1.2, label="mean")
    (own,) = ax.plot(places, free, color="0.35", linestyle="--", linewidth=1.0, label="natural shape, without load")
    (at,) = ax.plot(
        [response.largest_at], [_height(response, low, high)], label="largest", linestyle="none", **palette.POINT
    )
    if np.abs(free).max() > 3.0 * np.abs(motion).max():  # a bend that the channel holds nearly straight
        limit = 1.3 * float(np.abs(motion).max())
        ax.set_ylim(-limit, limit)
    ax.set_xlabel("distance from the upper end $s$ / m")
    ax.set_ylabel(f"{name} $y$ / mm")
    ax.set_title(f"Moves {response.in_words()}", fontsize="medium", wrap=True)
    explain(ax, [reached, mean, own, at])
    return ax


def _height(response: Any, low: Any, high: Any) -> float:
    """Return the largest deflection in mm, with its sign."""
    index = int(np.argmin(np.abs(response.positions - response.largest_at)))
    return 1e3 * math.copysign(response.largest, high[index] + low[index])
