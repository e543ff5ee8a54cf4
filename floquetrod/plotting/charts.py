"""Drawings of charts and transition curves, and files of figures."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.files import whole_file
from floquetrod.plotting import palette

FIGURES = (".png", ".pdf", ".svg")
"""Kinds of file a figure is written to."""


def draw_chart(chart: Any, ax: Any = None) -> Any:
    """Draw a `floquetrod.plane.Chart`: white where stable, orange where not, darker with growth where it is known."""
    ax = new_axes() if ax is None else ax
    x, y = chart.x.values, chart.y.values
    if chart.cells is not None:
        _draw_cells(chart, ax)
    elif chart.growth_rate is None:
        ax.pcolormesh(x, y, ~chart.stable, cmap=palette.verdicts(), vmin=0.0, vmax=1.0, rasterized=True)
    else:
        growth = np.where(chart.stable, np.nan, np.nan_to_num(chart.growth_rate))  # unknown where undecided
        mesh = ax.pcolormesh(x, y, growth, cmap=palette.shades(), vmin=0.0, rasterized=True)
        ax.figure.colorbar(mesh, ax=ax, label=growth_label(chart.growth_unit))
    if chart.cells is None and chart.stable.any() and not chart.stable.all():
        ax.contour(x, y, chart.stable, levels=[0.5], colors="black", linewidths=0.6)
    finish(ax, chart, chart.caption)
    return ax


def finish(ax: Any, plane: Any, caption: str) -> None:
    """Label the axes of a chart or of bands, and set its title."""
    ax.set_xlabel(plane.x.label)
    ax.set_ylabel(plane.y.label)
    ax.set_title("\n".join(textwrap.wrap(caption, 70)), fontsize="small")


def growth_label(unit: str) -> str:
    """Return the label of a scale of growth rates."""
    units = {"per tau": "per unit of $\\tau$", "per unit time": "per unit of time"}
    return f"growth rate {units.get(unit, f'/ ({unit})')}"


def _draw_cells(chart: Any, ax: Any) -> None:
    """Draw what is proved of each cell: white where stable, orange where not, neutral on a boundary, else hatched."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba

    across, up = chart.x.cell_edges, chart.y.cell_edges
    colours = np.array([to_rgba(c) for c in (palette.NEUTRAL, palette.NEUTRAL, palette.UNSTABLE, palette.STABLE)])
    ax.pcolormesh(across, up, colours[chart.cells + 2], rasterized=True)
    rectangles = [
        [(across[i], up[j]), (across[i + 1], up[j]), (across[i + 1], up[j + 1]), (across[i], up[j + 1])]
        for j, i in np.argwhere(chart.cells == -2)
    ]
    ax.add_collection(PolyCollection(rectangles, **palette.OPEN))


def draw_curves(curves: Any, ax: Any = None) -> Any:
    """Draw `floquetrod.mathieu.TransitionCurves`: solid where a solution has period 4 pi, dashed where 2 pi."""
    ax = new_axes() if ax is None else ax
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
    with whole_file(path) as file:
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
