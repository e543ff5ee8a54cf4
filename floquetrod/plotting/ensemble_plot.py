"""The drawing of an ensemble: the probability of a result over each quantity that varies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import explain, figure_or_new
from floquetrod.units import Unit


def draw_shares(
    shares: Sequence[Any], result: str, confidence: float, units: Mapping[str, Unit] | None = None, figure: Any = None
) -> Any:
    """Return a figure with a panel for each `floquetrod.ensembles.shares.ShareAlong`, in ``units`` by its name."""
    figure = figure_or_new(figure, (7.2, 2.7 * max(len(shares), 1)))
    panels = np.atleast_1d(figure.subplots(max(len(shares), 1), 1))
    for ax, along in zip(panels, shares, strict=False):
        name = "" if along.unit == "1" else along.unit
        unit = (units or {}).get(along.name, Unit(name, 1.0))
        value, low, high = (unit.of(each) for each in (along.value, along.low, along.high))
        known = np.isfinite(along.share)
        share = along.share[known]
        up = np.array([share - along.lower[known], along.upper[known] - share])
        across = np.array([value - low, high - value])[:, known]
        ax.errorbar(
            value[known],
            share,
            yerr=np.maximum(up, 0.0),
            xerr=across if across.any() else None,
            **{**palette.POINT, "linestyle": "none", "capsize": 3.0, "elinewidth": 0.9, "ecolor": "0.35"},
        )
        ax.set_ylim(-0.03, 1.03)
        ax.set_ylabel(f"probability\n{result}")
        shown = f"({unit.name})" if "/" in unit.name else unit.name
        ax.set_xlabel(f"{along.name.replace('_', ' ')}{f' / {shown}' if shown else ''}")
    if shares:
        handle = panels[0].containers[0].lines[0]
        bins = "; across, the drawn values put together" if any(np.any(each.high > each.low) for each in shares) else ""
        handle.set_label(f"share of runs; upright, its interval of {100.0 * confidence:g} % confidence{bins}")
        explain(panels[-1], [handle])
    return figure
