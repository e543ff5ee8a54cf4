"""Outlines of tongues as the bands of a chart; those of charts of Mathieu's equation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floquetrod.mathieu.tongue_curves import Plane
from floquetrod.mathieu.tongue_regions import Family, unstable_regions
from floquetrod.plane import Axis, Band, Bands, Progress

HAIRLINE_GROWTH = 1e-9
"""Growth per unit tau, tenfold in 4e8 periods, up to which a tongue of the equation is a hairline."""


@dataclass(frozen=True)
class ExactMathieuBands:
    """Finds the bands of a chart of Mathieu's equation over alpha and beta, its axes ``x`` and ``y`` two ends each."""

    x: Axis
    y: Axis
    damping: float
    growth_tolerance: float

    @property
    def prompt(self) -> bool:
        """Whether the bands are found about as fast as a chart; they are."""
        return True

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands of every tongue."""
        c, tolerance = self.damping, self.growth_tolerance
        family = Family(np.array([-c * c]), np.ones(1), c + tolerance, c + (tolerance or HAIRLINE_GROWTH))
        first, last = self.x.values.tolist()
        low, high = self.y.values.tolist()
        return make_bands(
            family,
            Plane("mean", "amplitude", 1.0, low, high, (first, last)),
            self.x,
            self.y,
            lines_across=True,
            numbered=False,
            damping=c,
            growth_unit="per tau",
            growth_tolerance=tolerance,
            accuracy=accuracy,
            progress=progress,
        )


def make_bands(
    family: Family,
    plane: Plane,
    x: Axis,
    y: Axis,
    *,
    lines_across: bool,
    numbered: bool,
    damping: float,
    growth_unit: str,
    growth_tolerance: float,
    accuracy: float,
    progress: Progress | None,
) -> Bands:
    """Return the bands of a family over a window.

    Parameters
    ----------
    family, plane
        As in `unstable_regions`.
    x, y : Axis
        With two values each.
    lines_across : bool
        Whether x tells one line of the plane from the next; else y does.
    numbered : bool
        Whether the equations are modes 1, 2, ...
    damping : float
        What growth is less by than that of the equations freed of it.
    growth_unit, growth_tolerance, accuracy, progress
        As in `Bands` and `Chart.find_bands`.
    """
    found = unstable_regions(family, plane, accuracy, progress)
    shapes = found.outlines
    at = np.cumsum(shapes.size) - shapes.size
    bands = []
    for i, (start, size) in enumerate(zip(at.tolist(), shapes.size.tolist(), strict=True)):
        vertices = shapes.line[start : start + size], shapes.place[start : start + size]
        peak = float(shapes.peak[i, 0]), float(shapes.peak[i, 1])
        bands.append(
            Band(
                *(vertices if lines_across else vertices[::-1]),
                int(found.which[i]) + 1 if numbered else None,
                int(found.order[i]),
                float(shapes.growth[i]) - damping,
                peak if lines_across else peak[::-1],
            )
        )
    return Bands(x, y, tuple(bands), growth_unit, growth_tolerance, found.hairlines, accuracy, (0.0, 0.0))
