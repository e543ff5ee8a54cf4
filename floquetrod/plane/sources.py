"""The bands of a family: between exact curves where it has them, else traced from verdicts on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.content import ByContent
from floquetrod._util.progress import Progress
from floquetrod.plane.bands import Bands
from floquetrod.plane.boundary_tracing import traced
from floquetrod.plane.family import Family
from floquetrod.plane.plane_axes import Axis


@dataclass(frozen=True, eq=False)
class FamilyBands(ByContent):
    """A source of bands, see `floquetrod.plane.BandSource`."""

    family: Family
    x: Axis
    y: Axis
    status: NDArray[np.int8]  # (ny, nx), of the points of the chart, for families without exact curves

    @property
    def prompt(self) -> bool:
        """Whether the bands are found about as fast as the chart."""
        return self.family.prompt

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands with an accuracy as a fraction of each axis."""
        bands = self.family.exact_bands(self.x.ends, self.y.ends, accuracy, progress)
        if bands is None:
            bands = traced(self.family, self.x, self.y, self.status == 0, accuracy, progress)
        return Bands(
            self.x.ends,
            self.y.ends,
            bands.bands,
            self.family.growth_unit,
            self.family.growth_tolerance,
            bands.tongues_left_out,
            bands.accuracy,
            bands.resolution,
        )
