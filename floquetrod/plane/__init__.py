"""Verdicts over a plane, of any subject: axes, charts, and how they are filled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.plane.axes import Axis, axis_values
    from floquetrod.plane.bands import Band, Bands
    from floquetrod.plane.chart import BandSource, Chart, Progress
    from floquetrod.plane.filling import charted, fill_rows
    from floquetrod.plane.tracing import TracedBands

__all__ = [
    "Axis",
    "Band",
    "BandSource",
    "Bands",
    "Chart",
    "Progress",
    "TracedBands",
    "axis_values",
    "charted",
    "fill_rows",
]

__getattr__ = names_of(
    __name__,
    {
        "plane.axes": (
            "Axis",
            "axis_values",
        ),
        "plane.bands": (
            "Band",
            "Bands",
        ),
        "plane.chart": (
            "BandSource",
            "Chart",
            "Progress",
        ),
        "plane.filling": (
            "charted",
            "fill_rows",
        ),
        "plane.tracing": ("TracedBands",),
    },
)


def __dir__() -> list[str]:
    return __all__
