"""How far a load is from a change of the verdict: what a margin is, and on which ways it is searched."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from floquetrod.rod.loads.load import Progress, Quantity

_SPANS = (1 / 32, 1 / 8, 0.5, 2.0, 8.0)
"""How far a margin is searched, in pieces: in critical forces, or as the factor less one of a frequency."""


WAYS: dict[Quantity, Callable[[float, float], tuple[list[float], list[float]]]] = {
    "mean": lambda here, unit: ([here - x * unit for x in _SPANS], [here + x * unit for x in _SPANS]),
    "amplitude": lambda here, unit: (
        [max(0.0, here - x * unit) for x in _SPANS],
        [here + x * unit for x in _SPANS if x <= 2.0],
    ),
    "frequency": lambda here, unit: ([here / (1.0 + x) for x in _SPANS], [here * (1.0 + x) for x in _SPANS]),
}
"""The ends of the pieces of a search for a margin, down and up, from where the load is and the critical force."""

MARGIN_SECONDS = 10.0
"""About how long the search for a margin of coupled modes may take, unless somebody asks for more."""

FEW_MODES = 50
"""Coupled modes up to which all margins together take some seconds."""


class _Distances(NamedTuple):
    below: float
    above: float


class Margin(_Distances):
    """How far one quantity of the load may fall or rise until the verdict changes; infinite when out of reach.

    Attributes
    ----------
    below, above : float
        The distances; ``below, above = margin``.
    resolution : float
        Changes closer together than this may have been passed over, in the unit of the distances; 0 where none can be.
    searched : (float, float)
        Up to which distances below and above was searched: where there is a change, it is that.

    Comparing compares the distances.
    """

    resolution: float
    searched: tuple[float, float]

    def __new__(
        cls, below: float, above: float, resolution: float = 0.0, searched: tuple[float, float] | None = None
    ) -> Margin:
        """Return a pair of distances with what is known of the search."""
        margin = super().__new__(cls, below, above)
        margin.resolution, margin.searched = resolution, (below, above) if searched is None else searched
        return margin

    @property
    def nearest(self) -> float:
        """The smaller of both."""
        return min(self)


class Edge(NamedTuple):
    """Where the verdict changes on a way, None where it does not, up to where was searched, and how finely.

    ``seconds`` is about how long that takes.
    """

    at: float | None
    searched: float
    resolution: float
    seconds: float = 0.0


def in_hundredths(progress: Progress | None, number: int, parts: int) -> Progress | None:
    """Return what reports one of the parts of a search in hundredths of them."""
    if progress is None:
        return None
    return lambda done, total: progress(100 * number + 100 * done // total, 100 * parts)
