"""The bands of a family: between exact curves where it has them, else traced from verdicts on a grid."""

from __future__ import annotations

from dataclasses import dataclass

from floquetrod.plane.axes import Axis
from floquetrod.plane.bands import Bands
from floquetrod.plane.family import Bools, Family, Progress
from floquetrod.plane.tracing import traced


@dataclass(frozen=True, eq=False)
class FamilyBands:
    """A source of bands, see `floquetrod.plane.BandSource`.

    Attributes
    ----------
    family : Family
    x, y : Axis
    unstable : ndarray (ny, nx) of bool
        The points of the chart that are unstable, for families without exact curves.
    """

    family: Family
    x: Axis
    y: Axis
    unstable: Bools

    @property
    def prompt(self) -> bool:
        """Whether the bands are found about as fast as the chart."""
        return self.family.prompt

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands with an accuracy as a share of each axis."""
        found = self.family.exact_bands(self.x.ends, self.y.ends, accuracy, progress)
        if found is None:
            found = traced(self.family, self.x, self.y, self.unstable, accuracy, progress)
        return Bands(
            self.x.ends,
            self.y.ends,
            found.bands,
            self.family.growth_unit,
            self.family.growth_tolerance,
            found.hairlines,
            found.accuracy,
            found.resolution,
        )
