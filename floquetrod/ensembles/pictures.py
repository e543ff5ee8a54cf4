"""The picture of an ensemble: over two chosen quantities, or over each that varies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from floquetrod._util import validate
from floquetrod.ensembles.shares import RANDOM, chosen_quantities, overall, runs_over, share_over, shares_along
from floquetrod.ensembles.variables import DONE
from floquetrod.units import Unit

_PLANE, _PANEL = 4.4, 2.7  # inches: height of the picture over two quantities, and of a panel over one


def draw(
    runs: Any,
    result: str,
    confidence: float,
    units: Mapping[str, Unit] | None = None,
    over: Any = None,
    figure: Any = None,
) -> Any:
    """Return a figure of a result of `Runs`, true or false in each, with quantities in ``units`` by their names.

    The share of runs over both quantities where two are chosen, and its probability over each where runs are drawn.
    Every run over the two quantities of ``over``, or over two that are drawn.  Over one chosen quantity without drawn
    runs it shows each run.  The title has the share of all runs.  ValueError where there is nothing of this.
    """
    figure = _drawn(runs, result, confidence, units, over, figure)
    figure.axes[0].set_title(overall(runs, result, confidence), fontsize="medium", wrap=True)
    return figure


def _drawn(runs: Any, result: str, confidence: float, units: Mapping[str, Unit] | None, over: Any, figure: Any) -> Any:
    """Return the figure without its title."""
    from floquetrod.plotting import ensemble_plot
    from floquetrod.plotting.chart_plot import figure_or_new

    plane: Any = None if over is not None else share_over(runs, result)
    draw_plane: Any = ensemble_plot.draw_share_plane
    if plane is None:
        plane, draw_plane = runs_over(runs, result, over), ensemble_plot.draw_runs
    shares = shares_along(runs, result, confidence)
    if plane is None and shares:
        return ensemble_plot.draw_shares(shares, result, confidence, units, figure)
    if plane is not None and not shares:
        return draw_plane(plane, result, units, figure)
    if plane is not None:
        figure = figure_or_new(figure, (7.2, _PLANE + _PANEL * len(shares)))
        above, below = figure.subfigures(2, 1, height_ratios=[_PLANE, _PANEL * len(shares)])
        draw_plane(plane, result, units, above)
        ensemble_plot.draw_shares(shares, result, confidence, units, below)
        return figure
    require_drawable(list(chosen_quantities(runs)), is_drawn=False)
    (name,) = chosen_quantities(runs)
    done = runs["status"].ravel() == DONE
    values, results = runs[name].astype(float)[done], runs[result].ravel()[done] == 1
    return ensemble_plot.draw_results(name, runs.units[name], values, results, result, units, figure)


def require_drawable(chosen: list[str], *, is_drawn: bool) -> None:
    """Raise ValueError where neither drawn runs nor one or two chosen quantities are there to be drawn."""
    if not is_drawn and len(chosen) not in (1, 2):
        raise validate.wrong_value(
            "runs",
            f"must vary with one or two chosen quantities for a picture, or along {', '.join(RANDOM)}, got "
            f"{', '.join(chosen) or 'none'}; give all but two one value, or draw them",
        )
