"""Spans of a line: the runs of a mask, and the gaps between spans."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from floquetrod._util.arrays import Bools


class Span(Protocol):
    """An interval, by its two ends."""

    @property
    def low(self) -> float:
        """Lower end."""

    @property
    def high(self) -> float:
        """Upper end."""


P = TypeVar("P", bound=Span)


class Gap(NamedTuple, Generic[P]):
    """The gap between two spans; None before the first and after the last."""

    low: float
    high: float
    before: P | None
    after: P | None


def complement(bounds: tuple[float, float], spans: Iterable[P]) -> list[Gap[P]]:
    """Return the gaps that spans, in any order, leave within bounds; bounds of no width are one gap unless covered.

    A gap begins at the span that reaches furthest, the first of equal ones.
    """
    edge, high = bounds
    before: P | None = None
    gaps = []
    for span in sorted(spans, key=lambda span: (span.low, span.high)):
        if span.low > high:
            break
        if span.low > edge:
            gaps.append(Gap(edge, span.low, before, span))
        if span.high > edge or span.low >= edge:
            edge, before = span.high, span
    if edge < high or before is None:
        gaps.append(Gap(edge, high, before, None))
    return gaps


def runs(mask: Bools) -> list[tuple[int, int]]:
    """Return the runs of true entries of a mask, each as its first index and the index after its last."""
    edges = np.flatnonzero(np.diff(np.pad(mask.astype(np.int8), 1))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
