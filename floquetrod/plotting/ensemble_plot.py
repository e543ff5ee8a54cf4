"""The drawings of an ensemble: the probability of a result over each quantity that varies, or over two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import NAMES, colours, explain, figure_or_new, patch
from floquetrod.units import Unit


def draw_share_plane(plane: Any, result: str, units: Mapping[str, Unit] | None = None, figure: Any = None) -> Any:
    """Return a figure of a `floquetrod.ensembles.shares.SharePlane` as cells about its values, hatched where not known.

    Quantities are in ``units`` by their names.
    """
    figure = figure_or_new(figure, (7.2, 4.4))
    ax = figure.subplots()
    (x, label_x), (y, label_y) = (
        _in_unit(name, unit, values, units)
        for name, unit, values in zip(plane.names, plane.units, (plane.x, plane.y), strict=True)
    )
    across, up = _edges(x), _edges(y)
    shown = np.ma.masked_invalid(plane.share)
    if shown.mask.any():
        from matplotlib.patches import Rectangle

        corners = (across[0], up[0]), across[-1] - across[0], up[-1] - up[0]
        ax.add_patch(Rectangle(*corners, **palette.OPEN, zorder=0.5))
    mesh = ax.pcolormesh(
        across, up, shown, cmap=palette.shares(), vmin=0.0, vmax=1.0, edgecolors=palette.NEUTRAL, linewidth=0.3
    )
    ax.set_xlabel(label_x)
    ax.set_ylabel(label_y)
    handles = [patch("no run done", palette.OPEN)] if shown.mask.any() else []
    if plane.is_drawn:
        ax.figure.colorbar(mesh, ax=ax, label=f"share of runs {result}")
    else:
        handles = [*colours(result, f"not {result}"), *handles]
    if handles:
        explain(ax, handles, "" if plane.is_drawn else "each cell is one run, at its middle")
    return figure


def draw_runs(over: Any, result: str, units: Mapping[str, Unit] | None = None, figure: Any = None) -> Any:
    """Return a figure of `floquetrod.ensembles.shares.RunsOver`: a point for each run, filled where it has the result.

    Quantities are in ``units`` by their names.
    """
    figure = figure_or_new(figure, (7.2, 4.4))
    ax = figure.subplots()
    (x, label_x), (y, label_y) = (
        _in_unit(name, unit, values, units)
        for name, unit, values in zip(over.names, over.units, (over.x, over.y), strict=True)
    )
    handles = []
    for true, fill, words in ((False, palette.STABLE, f"not {result}"), (True, palette.UNSTABLE, result)):
        chosen = over.result == true
        style = {**palette.POINT, "markerfacecolor": fill, "markeredgewidth": 0.7, "markersize": 5.0}
        handles += ax.plot(x[chosen], y[chosen], **style, linestyle="none", label=words)
    ax.set_xlabel(label_x)
    ax.set_ylabel(label_y)
    explain(ax, handles, "each point is one run")
    return figure


def _edges(values: Any) -> Any:
    """Return the edges of cells about values: the middles between them, and as far beyond the first and the last."""
    middles = 0.5 * (values[1:] + values[:-1])
    return np.r_[2.0 * values[0] - middles[0], middles, 2.0 * values[-1] - middles[-1]]


def draw_results(
    name: str, unit: str, values: Any, results: Any, result: str, units: Mapping[str, Unit] | None, figure: Any
) -> Any:
    """Return a figure of runs over one quantity in its SI ``unit``: each with a result, true or false."""
    values, label = _in_unit(name, unit, values, units)
    figure = figure_or_new(figure, (7.2, 2.7))
    ax = figure.subplots()
    (drawn,) = ax.plot(values, results.astype(int), **palette.POINT, linestyle="none")
    drawn.set_label("a run")
    ax.set_yticks([0, 1], [f"not {result}", result])
    ax.set_ylim(-0.3, 1.3)
    ax.set_xlabel(label)
    explain(ax, [drawn])
    return figure


def _in_unit(name: str, unit: str, values: Any, units: Mapping[str, Unit] | None) -> tuple[Any, str]:
    """Return the values of a quantity, and its name with its unit, in a unit of ``units`` or their own."""
    shown = (units or {}).get(name, Unit("" if unit == "1" else unit, 1.0))
    words, _ = NAMES.get(name, (name.replace("_", " "), ""))
    written = f"({shown.name})" if "/" in shown.name else shown.name
    return shown.of(values), f"{words}{f' / {written}' if written else ''}"


def draw_shares(
    shares: Sequence[Any], result: str, confidence: float, units: Mapping[str, Unit] | None = None, figure: Any = None
) -> Any:
    """Return a figure with a panel for each `floquetrod.ensembles.shares.ShareAlong`, in ``units`` by its name."""
    figure = figure_or_new(figure, (7.2, 2.7 * len(shares)))
    panels = np.atleast_1d(figure.subplots(len(shares), 1))
    for ax, along in zip(panels, shares, strict=True):
        (value, low, high), label = _in_unit(
            along.name, along.unit, np.array([along.value, along.low, along.high]), units
        )
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
        ax.set_ylabel(f"{result}, share\nof runs done")
        ax.set_xlabel(label)
    handle = panels[0].containers[0].lines[0]
    bins = "; across, the drawn values put together" if any(np.any(each.high > each.low) for each in shares) else ""
    handle.set_label(f"share of runs; upright, its interval of {100.0 * confidence:g} % confidence{bins}")
    explain(panels[-1], [handle])
    return figure
