"""How a time is taken, and the row that reports it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One figure: what it is, what it was held against, and what was promised.

    Attributes
    ----------
    name : str
        What was measured.
    value, unit : float, str
        The figure.
    peer : float or None
        The same figure for the peer named in ``against``; the ratio reported is peer / value.
    at_most, ratio_at_least : float or None
        What was promised.
    """

    name: str
    value: float
    unit: str
    against: str = ""
    peer: float | None = None
    at_most: float | None = None
    ratio_at_least: float | None = None

    @property
    def ratio(self) -> float | None:
        """How many times less this is than the peer's figure."""
        return None if self.peer is None or self.value == 0.0 else self.peer / self.value

    @property
    def target(self) -> str:
        """What was promised, in words."""
        promises = []
        if self.at_most is not None:
            promises.append(f"<= {self.at_most:g} {self.unit}")
        if self.ratio_at_least is not None:
            promises.append(f">= {self.ratio_at_least:g} times less")
        return ", ".join(promises)

    @property
    def met(self) -> bool | None:
        """Whether every promise was kept; None when there was none."""
        if not self.target:
            return None
        cheap = self.at_most is None or self.value <= self.at_most
        return cheap and (self.ratio_at_least is None or (self.ratio or 0.0) >= self.ratio_at_least)


def best_of(function: Callable[[], object], repeats: int = 7, least_seconds: float = 0.02) -> float:
    """Return the seconds one call takes: the least of ``repeats`` timings, each long enough for the clock.

    The first call is not timed: it may compile.
    """
    function()
    calls = 1
    while (spent := _seconds(function, calls)) < least_seconds:
        calls *= max(2, int(least_seconds / max(spent, 1e-9) * 1.2)) if spent < 0.5 * least_seconds else 2
    return min(spent, *(_seconds(function, calls) for _ in range(repeats - 1))) / calls


def _seconds(function: Callable[[], object], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        function()
    return time.perf_counter() - start
