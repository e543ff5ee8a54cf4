"""How far a load is from a change of the verdict: on which ways it is searched."""

from __future__ import annotations

from collections.abc import Callable

from floquetrod._util.progress import Progress
from floquetrod.floquet.margins import Edge as Edge
from floquetrod.floquet.margins import Margin as Margin
from floquetrod.rod.loads.load import Quantity

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


def in_hundredths(progress: Progress | None, number: int, parts: int) -> Progress | None:
    """Return what reports one of the parts of a search in hundredths of them."""
    if progress is None:
        return None
    return lambda done, total: progress(100 * number + 100 * done // total, 100 * parts)
