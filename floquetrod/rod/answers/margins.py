"""How far a load is from a change of the verdict: on which ways it is searched, outward in pieces.

A margin is searched from a load, a critical load from zero: by the same pieces, each with as many modes as it needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

from floquetrod._util.interchange import plain, with_unit
from floquetrod._util.progress import Progress
from floquetrod.floquet.margins import Edge as Edge
from floquetrod.floquet.margins import Margin as Margin
from floquetrod.rod.loads.load import LOAD, Quantity

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


class CriticalLoad(float):
    """Smallest value of one quantity of the load, from zero up, at which something grows; infinite where none is found.

    A float, with what is known of the search for it.

    Attributes
    ----------
    quantity : "mean" or "amplitude"
        The quantity that varies.
    resolution : float
        Unstable bands below it up to this width may have been passed over, in N; 0 where none can be.
    searched : float
        Up to which value in N was searched: itself where something grows.
    """

    quantity: Quantity
    resolution: float
    searched: float

    def __new__(
        cls, value: float, quantity: Quantity = "mean", resolution: float = 0.0, searched: float | None = None
    ) -> CriticalLoad:
        """Return a number in N with what is known of the search for it."""
        critical = super().__new__(cls, value)
        critical.quantity, critical.resolution = quantity, resolution
        critical.searched = float(value) if searched is None else searched
        return critical

    def __repr__(self) -> str:
        """Return the number, or up to where nothing grows, and how wide a band may have been passed over."""
        name = LOAD[self.quantity].words
        if math.isfinite(self):
            size = f"critical {name} {float(self):.9g} N"
        else:
            size = f"no critical {name} up to {self.searched:.6g} N"
        missed = f"unstable bands narrower than {self.resolution:.2g} N may have been missed"
        return f"<{size}; {missed}>" if self.resolution else f"<{size}>"

    def as_dict(self) -> dict[str, Any]:
        """Return number, resolution and end of the search for JSON, units in the keys; None for infinite."""
        limits = LOAD[self.quantity]
        return {
            with_unit(f"critical {limits.words}", limits.unit): plain(float(self)),
            with_unit("resolution", limits.unit): self.resolution,
            with_unit("searched", limits.unit): self.searched,
        }


def ends_between(quantity: Quantity, bounds: tuple[float, float], unit: float) -> list[float]:
    """Return the ends of the pieces in which a force is searched within bounds, in increasing order.

    Critical loads and ranges share them: zero and the ends of a margin about zero, with ``unit`` the critical force.
    """
    low, high = bounds
    below, above = WAYS[quantity](0.0, unit)
    return [low, *sorted({end for end in (*below, 0.0, *above) if low < end < high}), high]


def outward(
    way: list[float],
    edge: Callable[[tuple[float, float], float, Progress | None], Edge],
    progress: Iterable[Progress | None],
    seconds: float = math.inf,
) -> Edge:
    """Return where the verdict first changes on a way of several pieces, or where a search in some seconds ends.

    Parameters
    ----------
    way : list of float
        The ends of the pieces, the nearest first.
    edge : callable
        Searches a piece in some seconds and reports its progress.
    progress : iterable of callable
        What reports the progress in each piece.
    seconds : float
        A piece gets half of the time that is left, the last one all of it: what is nearest comes first.
    """
    found, left = Edge(None, way[0], 0.0), seconds
    for piece, told in zip(pairwise(way), progress, strict=True):
        if piece[0] != piece[1]:
            share = left if piece[1] == way[-1] else 0.5 * left
            change = edge(piece, share, told)
            found = change._replace(resolution=max(found.resolution, change.resolution))
            left -= change.seconds
            if found.at is not None or found.searched != piece[1]:
                break
        if told is not None:
            told(1, 1)
    return found


def in_hundredths(progress: Progress | None, number: int, parts: int) -> Progress | None:
    """Return what reports one of the parts of a search in hundredths of them."""
    if progress is None:
        return None
    return lambda done, total: progress(100 * number + 100 * done // total, 100 * parts)
