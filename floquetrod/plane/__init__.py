"""Verdicts over a plane, of any subject: axes, charts, and how they are filled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.plane.bands import Band, Bands, MergedTongue
    from floquetrod.plane.chart import BandSource, Chart
    from floquetrod.plane.family import Family, FoundBands, Verdicts
    from floquetrod.plane.filling import charted
    from floquetrod.plane.plane_axes import Axis, axis_values

__all__ = [
    "Axis",
    "Band",
    "BandSource",
    "Bands",
    "Chart",
    "Family",
    "FoundBands",
    "MergedTongue",
    "Verdicts",
    "axis_values",
    "charted",
]

__getattr__, __dir__ = names_of(
    __name__,
    {
        "plane.plane_axes": ("Axis", "axis_values"),
        "plane.bands": ("Band", "Bands", "MergedTongue"),
        "plane.chart": ("BandSource", "Chart"),
        "plane.family": ("Family", "FoundBands", "Verdicts"),
        "plane.filling": ("charted",),
    },
)
