"""Drawings of unstable bands as shapes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from floquetrod.plotting import labels, palette
from floquetrod.plotting.chart_plot import (
    areas,
    axes_or_new,
    colours,
    draw_large_motion,
    draw_response_lines,
    filled,
    finish,
    growth_label,
    title,
)
from floquetrod.plotting.leaders import name_bands

_LINE = 0.6
"""Width in points of a band's edge, and of a band thinner than that."""

_MOST_VERTICES = 100_000
"""Vertices up to which bands are shapes in a file too; more are pixels there, a shape taking 20 bytes a vertex."""


def draw_bands(bands: Any, ax: Any = None) -> Any:
    """Draw `floquetrod.plane.Bands` as shapes, thin ones as lines, named where there is room; return the axes."""
    ax = axes_or_new(ax)
    fill(ax, bands, palette.UNSTABLE)

    def note(explanation: str) -> str:
        return "; ".join(filter(None, [bands.caption, explanation]))

    name_bands(ax, bands.bands, halo=False, note=lambda explanation: filled(ax, note(explanation)))
    _frame(ax, bands, "unstable bands", note(labels.explanation(bands.bands)), colours("unstable", "stable"))
    return ax


def draw_banded_chart(chart: Any, ax: Any = None) -> Any:
    """Draw the bands of a `floquetrod.plane.Chart`, darker the faster growth is where it is known; return the axes."""
    ax = axes_or_new(ax)
    bands = chart.bands
    if chart.growth_rate is None:
        fill(ax, bands, palette.UNSTABLE)
    else:
        # Edges first: what lies over them leaves those of the whole, and bands thinner than a line.
        fill(ax, bands, palette.UNSTABLE)
        fill(ax, bands, palette.UNSEEN, line=0.0, zorder=1.1)
        image = _growth(ax, chart)
        if len(bands):
            image.set_clip_path(_outline(bands), ax.transData)
        image.set_visible(len(bands) > 0)
        if len(bands) and image.get_array().max() > 0.0:
            ax.figure.colorbar(image, ax=ax, label=growth_label(chart.growth_unit))
    draw_large_motion(chart, ax, 0.5)
    draw_response_lines(chart, ax)
    undecided = f"{chart.undecided} of {chart.stable.size} points undecided" if chart.undecided else ""

    def note(explanation: str) -> str:
        caption = f"{chart.heading}: {bands.caption}"
        return "; ".join(filter(None, [caption, explanation, chart.criterion, undecided]))

    halo = chart.growth_rate is not None
    name_bands(ax, bands.bands, halo=halo, note=lambda explanation: filled(ax, note(explanation)))
    _frame(ax, bands, title(chart), note(labels.explanation(bands.bands)), areas(chart))
    return ax


def fill(
    ax: Any, bands: Collection[Any], colour: str, *, line: float = _LINE, zorder: float = 1.0, label: str = ""
) -> None:
    """Fill bands with a colour; unless ``line``, in points, is 0, they are seen however thin they are."""
    from matplotlib.collections import PolyCollection

    shapes = PolyCollection(
        [np.column_stack([band.x, band.y]) for band in bands],
        facecolors=colour,
        edgecolors=colour if line else "none",
        linewidths=line,
        joinstyle="round",
        rasterized=sum(band.x.size for band in bands) > _MOST_VERTICES,
        zorder=zorder,
        label=label,
    )
    ax.add_collection(shapes, autolim=False)


def _growth(ax: Any, chart: Any) -> Any:
    """Draw growth about the unstable points of a chart as a smooth image, zero where it is not known; return it.

    It ends a point beyond them, in the colour of the slowest growth.
    """
    from matplotlib.colors import to_rgb
    from matplotlib.image import NonUniformImage

    x, y = chart.x.values, chart.y.values
    growth = np.nan_to_num(chart.growth_rate)
    near = np.pad(~chart.stable, 1)
    near = near[:, :-2] | near[:, 1:-1] | near[:, 2:]
    near = near[:-2] | near[1:-1] | near[2:]
    colours = palette.shades().with_extremes(bad=(*to_rgb(palette.UNSEEN), 0.0))
    image = NonUniformImage(ax, interpolation="bilinear", cmap=colours, extent=(x[0], x[-1], y[0], y[-1]), zorder=1.2)
    image.set_data(x, y, np.ma.masked_where(~near, growth))
    image.set_clim(0.0, max(float(growth.max()), 1e-300))
    ax.add_image(image)
    return image


def _outline(bands: Any) -> Any:
    """Return the path about all bands, each passed in the same sense: where they overlap is inside too."""
    from matplotlib.path import Path

    points, codes = [], []
    for band in bands:
        turn = np.dot(band.x, np.roll(band.y, -1)) - np.dot(band.y, np.roll(band.x, -1))
        ring = np.column_stack([band.x, band.y])[:: -1 if turn < 0.0 else 1]
        points.append(np.vstack([ring, ring[:1]]))
        codes.append(np.r_[Path.MOVETO, np.full(len(ring) - 1, Path.LINETO), Path.CLOSEPOLY])
    return Path(np.vstack(points), np.concatenate(codes))


def _frame(ax: Any, bands: Any, heading: str, note: str, handles: Sequence[Any]) -> None:
    """Label the axes, title them, and let them end where the plane does."""
    finish(ax, bands, heading, note, handles)
    ax.set_xlim(*bands.x.values)
    ax.set_ylim(*bands.y.values)
