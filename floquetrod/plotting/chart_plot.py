"""Drawings of charts and transition curves, and files of figures."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.sealed_files import atomic_file
from floquetrod.plotting import palette

_BELOW = 36.0  # points from the axes to the legend below: ticks, their labels and that of the axis
_SCALE = "critical force"  # of a rod, which a note tells and a title leaves out
_TITLE = 70  # characters of a title, which then is as wide as the axes of `new_axes`
_TAU = "\N{GREEK SMALL LETTER TAU}"
_NOTE = 105  # characters of a line of a note, which then is as wide as the axes of `new_axes`
_WIDE = 5.4  # inches: the width of these axes

NAMES = {
    "mean": ("mean force", r"F_\mathrm{ave}"),
    "amplitude": ("amplitude", r"\Delta F"),
    "frequency": ("frequency", r"\omega"),
}
"""Name and symbol of each quantity of a load."""

FIGURES = (".png", ".pdf", ".svg")
"""Kinds of file a figure is written to."""

_LINES_OF_RESPONSE = 8  # of equal deflection, about


def draw_chart(chart: Any, ax: Any = None) -> Any:
    """Draw a `floquetrod.plane.Chart`: white where stable, orange where not, darker with growth where it is known."""
    ax = axes_or_new(ax)
    x, y = chart.x.values, chart.y.values
    if chart.cells is not None:
        _draw_cells(chart, ax)
    elif chart.growth_rate is None:
        ax.pcolormesh(x, y, ~chart.stable, cmap=palette.verdicts(), vmin=0.0, vmax=1.0, rasterized=True)
    else:
        growth = np.where(chart.stable, np.nan, np.nan_to_num(chart.growth_rate))  # unknown where undecided
        mesh = ax.pcolormesh(x, y, growth, cmap=palette.shades(), vmin=0.0, rasterized=True)
        if np.nanmax(growth, initial=0.0) > 0.0:
            ax.figure.colorbar(mesh, ax=ax, label=growth_label(chart.growth_unit))
    if chart.cells is None and chart.stable.any() and not chart.stable.all():
        ax.contour(x, y, chart.stable, levels=[0.5], colors="black", linewidths=0.6)
    draw_large_motion(chart, ax)
    draw_response_lines(chart, ax)
    finish(ax, chart, title(chart), chart.caption, areas(chart))
    return ax


def draw_large_motion(chart: Any, ax: Any, zorder: float = 1.0) -> None:
    """Hatch where a rod that is stable at rest carries a large motion, too."""
    if chart.carries_large_motion.any():
        area = chart.carries_large_motion.astype(float)
        hatch = [palette.LARGE["hatch"]]
        ax.contourf(chart.x.values, chart.y.values, area, [0.5, 1.5], colors="none", hatches=hatch, zorder=zorder)


def draw_response_lines(chart: Any, ax: Any) -> None:
    """Draw lines of equal largest deflection, in mm, of a rod that is not straight, where it is stable."""
    if chart.response is None or not np.isfinite(chart.response).any():
        return
    sizes = 1e3 * chart.response
    least, most = (math.log10(float(limit(sizes))) for limit in (np.nanmin, np.nanmax))
    decades = np.arange(math.floor(least), math.ceil(most) + 1.0)
    levels = np.array([step * 10.0**decade for decade in decades for step in (1.0, 2.0, 5.0)])
    levels = levels[(levels > 10.0**least) & (levels < 10.0**most)]
    levels = levels[:: max(1, math.ceil(len(levels) / _LINES_OF_RESPONSE))]
    if levels.size:
        lines = ax.contour(chart.x.values, chart.y.values, sizes, levels, colors="0.35", linewidths=0.7)
        ax.clabel(lines, fmt=lambda value: f"{value:.3g}", fontsize="x-small")


def finish(ax: Any, plane: Any, heading: str, note: str, handles: Sequence[Any]) -> None:
    """Label the axes of a chart or of bands, with a short title above, and below what its areas and names mean."""
    ax.set_xlabel(plane.x.label)
    ax.set_ylabel(plane.y.label)
    ax.set_title(heading, fontsize="medium", wrap=True)
    explain(ax, handles, note)


def explain(ax: Any, handles: Sequence[Any], note: str = "", columns: int = 4) -> None:
    """Write a legend, and a note over it, below the label of the x axis; a tuple of areas is one of several shades."""
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.transforms import ScaledTranslation

    below = ScaledTranslation(0.0, -_BELOW / 72.0, ax.figure.dpi_scale_trans)
    legend = ax.legend(
        handles=handles,
        labels=[(handle[0] if isinstance(handle, tuple) else handle).get_label() for handle in handles],
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0.0)},
        title=filled(ax, note),
        loc="upper left",
        bbox_to_anchor=(0.0, 0.0),
        bbox_transform=ax.transAxes + below,
        borderaxespad=0.0,
        borderpad=0.0,
        ncols=columns,
        frameon=False,
        fontsize="x-small",
        title_fontsize="x-small",
        alignment="left",
    )
    legend.set_zorder(1.0)


def filled(ax: Any, note: str) -> str:
    """Return a note in lines as wide as axes: narrow axes beside others get shorter lines."""
    width = ax.get_position(original=True).width * ax.figure.bbox.width / ax.figure.dpi  # a subfigure may be its figure
    return typeset(textwrap.fill(note, min(_NOTE, int(_NOTE * width / _WIDE))))


def areas(chart: Any) -> list[Any]:
    """Return what the colours and the hatch of a chart mean, as a legend shows it."""
    large = (
        [patch("stable at rest, a large motion on the wall found", palette.LARGE)]
        if chart.carries_large_motion.any()
        else []
    )
    return [*_verdicts(chart), *large, *_lines_of_response(chart)]


def _lines_of_response(chart: Any) -> list[Any]:
    """Return what the lines of equal deflection mean, where there are some."""
    if chart.response is None or not np.isfinite(chart.response).any():
        return []
    from matplotlib.lines import Line2D

    return [Line2D([], [], color="0.35", linewidth=0.7, label="largest deflection / mm")]


def _verdicts(chart: Any) -> list[Any]:
    """Return what the colours of a chart mean."""
    if chart.cells is not None:
        neutral, undecided = {"facecolor": palette.NEUTRAL}, palette.OPEN
        return [
            *colours("proved unstable", "proved stable"),
            patch("holds a boundary", neutral),
            patch("undecided", undecided),
        ]
    if chart.growth_rate is None:
        unstable, stable = _kicked(chart) or ("unstable", "stable")
        return colours(f"{unstable} or undecided" if chart.undecided else unstable, stable)
    shades = palette.UNSEEN, palette.UNSTABLE, palette.FASTEST
    name = f"unstable{' or undecided' if chart.undecided else ''}, the darker the faster it grows"
    return [tuple(patch(name, {"facecolor": shade}) for shade in shades), colours(name, "stable")[1]]


def _kicked(chart: Any) -> tuple[str, str] | None:
    """Return what a kick does where friction holds the rod, None for a chart without friction."""
    kick = next((units.with_unit(value, unit, 3) for name, value, unit in chart.subject["fixed"] if name == "kick"), "")
    return (f"a kick of {kick} buckles it", f"a kick of {kick} does not") if kick else None


def colours(unstable: str, stable: str) -> list[Any]:
    """Return what orange and white mean, as a legend shows it."""
    white = {"facecolor": palette.STABLE, "edgecolor": "black", "linewidth": 0.6}
    return [patch(unstable, {"facecolor": palette.UNSTABLE}), patch(stable, white)]


def patch(name: str, style: Mapping[str, Any]) -> Any:
    """Return an area as a legend shows it."""
    from matplotlib.patches import Patch

    return Patch(label=name, **style)


def title(chart: Any) -> str:
    """Return the charted quantity and the values of fixed ones, in three digits; the note has the parts too long.

    Before them stands the name of the user's function that makes the equations, where it has one.
    """
    fixed = [
        f"{name} {units.with_unit(value, unit, 3)}" for name, value, unit in chart.subject["fixed"] if name != _SCALE
    ]
    kind = ": ".join(filter(None, [chart.subject.get("name"), chart.subject["kind"]]))
    whole = ", ".join([kind, *fixed])
    return typeset(whole if len(whole) <= _TITLE else ", ".join([kind.partition(",")[0], *fixed]))


def typeset(text: str) -> str:
    """Return a text with the signs that axes have: critical force and dimensionless time."""
    critical = r" $F_\mathrm{cr}$"
    return text.replace(" Fcr", critical).replace(" F_cr", critical).replace(" tau", f" {_TAU}")


def growth_label(unit: str) -> str:
    """Return the label of a scale of growth rates."""
    words = {"per tau": f"per unit of {_TAU}", "per z": "per unit of $z$", "per unit time": "per unit of time"}
    return f"growth rate {words.get(unit, f'/ ({unit})')}"


def _draw_cells(chart: Any, ax: Any) -> None:
    """Draw the proof of each cell: white where stable, orange where not, neutral on a boundary, else hatched."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba

    across, up = chart.x.cell_edges, chart.y.cell_edges
    colours = np.array([to_rgba(c) for c in (palette.UNSTABLE, palette.STABLE, palette.NEUTRAL, palette.NEUTRAL)])
    ax.pcolormesh(across, up, colours[chart.cells], rasterized=True)  # what is undecided, -1, has the last
    rectangles = [
        [(across[i], up[j]), (across[i + 1], up[j]), (across[i + 1], up[j + 1]), (across[i], up[j + 1])]
        for j, i in np.argwhere(chart.cells == -1)
    ]
    ax.add_collection(PolyCollection(rectangles, **palette.OPEN))


def draw_curves(curves: Any, ax: Any = None) -> Any:
    """Draw `floquetrod.mathieu.TransitionCurves`: solid where a solution has period 4 pi, dashed where 2 pi."""
    ax = axes_or_new(ax)
    step = max(1, curves.alpha.size // 3)
    for row, order in enumerate(curves.orders):
        for values, name, place in ((curves.even[row], "a", 3 * step // 2), (curves.odd[row], "b", step)):
            if np.isnan(values).all():
                continue
            line = "--" if order % 2 == 0 else "-"
            ax.plot(curves.alpha, values, color="black", linestyle=line, linewidth=0.9)
            at = min(place, curves.alpha.size - 1)
            box = palette.BOX | {"boxstyle": "round,pad=0.1", "edgecolor": "none"}
            text = f"${name}_{{{order}}}$"
            ax.text(
                curves.alpha[at], values[at], text, fontsize="small", ha="center", va="center", bbox=box, clip_on=True
            )
    ax.set_xlabel(r"$\alpha$")
    ax.set_ylabel(r"$\beta$")
    ax.set_title(r"transition curves $\beta = -a_m/4$, $-b_m/4$; period $4\pi$ solid, $2\pi$ dashed", fontsize="small")
    return ax


def mark(ax: Any, x: float, y: float, text: str) -> None:
    """Mark one point of a chart and say what it is."""
    ax.plot([x], [y], **palette.POINT, markersize=8, linestyle="none")
    ax.annotate(text, (x, y), xytext=(10, 10), textcoords="offset points", fontsize="small", bbox=palette.BOX)


def save_figure(drawn: Any, path: str | Path) -> Path:
    """Write a figure, or the one that axes belong to, to a file of the kind its name tells, and close it."""
    from matplotlib import pyplot

    path = validate.path("path", path)
    figure = getattr(drawn, "figure", drawn)
    with atomic_file(path) as file:
        figure.savefig(file, dpi=150, format=path.suffix[1:] or "png")
    pyplot.close(figure)
    return path


def show() -> None:
    """Show the open figures and wait until they are closed; ValueError where there is no screen."""
    import matplotlib as mpl
    from matplotlib import pyplot

    if mpl.get_backend().lower() in ("agg", "pdf", "svg", "ps", "cairo", "template"):
        raise ValueError(
            f"no window can be opened: matplotlib's backend here is {mpl.get_backend()!r}; "
            "write the picture to a file with --out, or install one with a window, PyQt6 say"
        )
    pyplot.show()


def new_axes() -> Any:
    """Return the axes of a new figure."""
    from matplotlib import pyplot

    return pyplot.subplots(figsize=(7.0, 5.0), layout="constrained")[1]


def picture(drawn: Any) -> bytes:
    """Return a chart or its bands as PNG, without a figure of pyplot, which a notebook would show a second time."""
    from matplotlib.figure import Figure

    figure, file = Figure(figsize=(7.0, 5.0), layout="constrained"), io.BytesIO()
    drawn.plot(figure.subplots())
    figure.savefig(file, format="png", bbox_inches="tight")
    return file.getvalue()


def axes_or_new(ax: Any) -> Any:
    """Return axes to draw into, of a new figure for None; TypeError unless they are axes of matplotlib."""
    from matplotlib.axes import Axes

    return new_axes() if ax is None else validate.instance("ax", ax, Axes, "create them with pyplot.subplots()")


def figure_or_new(figure: Any, size: tuple[float, float]) -> Any:
    """Return a figure or subfigure to draw into, a new one of a size in inches for None; TypeError for other types."""
    from matplotlib import pyplot
    from matplotlib.figure import FigureBase

    if figure is None:
        return pyplot.figure(figsize=size, layout="constrained")
    return validate.instance("figure", figure, FigureBase, "create it with pyplot.figure()")
