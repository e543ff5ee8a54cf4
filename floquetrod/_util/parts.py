"""Parts of a line: where a mask is true, and what some parts leave of the rest."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from floquetrod._util.arrays import Bools


class Part(Protocol):
    """What has two ends."""

    @property
    def low(self) -> float:
        """Where it begins."""

    @property
    def high(self) -> float:
        """Where it ends."""


P = TypeVar("P", bound=Part)


class Gap(NamedTuple, Generic[P]):
    """What lies between two parts; None before the first and after the last."""

    low: float
    high: float
    before: P | None
    after: P | None


def complement(bounds: tuple[float, float], parts: Iterable[P]) -> list[Gap[P]]:
    """Return what parts, in any order, leave of bounds; of bounds without a width themselves, where no part is there.

    A gap is closed by the part that reaches furthest, the first of equal ones.
    """
    at, high = bounds
    before: P | None = None
    gaps = []
    for part in sorted(parts, key=lambda each: (each.low, each.high)):
        if part.low > high:
            break
        if part.low > at:
            gaps.append(Gap(at, part.low, before, part))
        if part.high > at or part.low >= at:
            at, before = part.high, part
    if at < high or before is None:
        gaps.append(Gap(at, high, before, None))
    return gaps


def runs(mask: Bools) -> list[tuple[int, int]]:
    """Return where a mask is true: the first place of each run, and the one after its last."""
    edges = np.flatnonzero(np.diff(np.pad(mask.astype(np.int8), 1))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
