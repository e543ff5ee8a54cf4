"""The pieces in which a quantity of the load is searched for a change of the verdict, outward.

A margin is searched from a load, a critical load and a range from zero, in the same pieces, with as many modes as each
needs.
"""

from __future__ import annotations

from collections.abc import Callable

from floquetrod._util.progress import Progress
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


def ends_between(quantity: Quantity, bounds: tuple[float, float], unit: float) -> list[float]:
    """Return the ends of the pieces in which a force is searched within bounds, in increasing order.

    Critical loads and ranges share them: zero and the ends of a margin about zero, with ``unit`` the critical force.
    """
    low, high = bounds
    below, above = WAYS[quantity](0.0, unit)
    return [low, *sorted({end for end in (*below, 0.0, *above) if low < end < high}), high]


def in_hundredths(progress: Progress | None, number: int, parts: int) -> Progress | None:
    """Return the progress of a search of several parts, in hundredths of them, as reported by one part."""
    if progress is None:
        return None
    return lambda done, total: progress(100 * number + 100 * done // total, 100 * parts)
