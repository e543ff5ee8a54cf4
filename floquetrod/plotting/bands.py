"""Drawings of unstable bands as shapes."""

from __future__ import annotations

from typing import Any

from floquetrod.plotting import palette
from floquetrod.plotting.charts import new_axes


def draw_bands(bands: Any, ax: Any = None) -> Any:
    """Draw `floquetrod.plane.Bands` as polygons, thin ones as lines; return the axes."""
    ax = new_axes() if ax is None else ax
    for band in bands:
        ax.fill(band.x, band.y, facecolor=palette.UNSTABLE, edgecolor=palette.UNSTABLE, linewidth=0.6)
    ax.set_xlim(*bands.x.values)
    ax.set_ylim(*bands.y.values)
    ax.set_xlabel(bands.x.label)
    ax.set_ylabel(bands.y.label)
    return ax
