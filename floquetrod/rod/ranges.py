"""Which loads are safe: every stable interval of one quantity of the load, in order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.content import NoTruthValue
from floquetrod.rod.tongues import Quantity, UnstableLoads

QUANTITIES: dict[Quantity, tuple[str, str]] = {
    "mean": ("mean force", "N"),
    "amplitude": ("amplitude", "N"),
    "frequency": ("frequency", "rad/s"),
}
"""Name and unit of what may vary."""


class SafeInterval(NamedTuple):
    """Stable from ``low`` to ``high``; what closes each end is (mode, tongue), or None at an end of the search."""

    low: float
    high: float
    low_end: tuple[int, int] | None
    high_end: tuple[int, int] | None


@dataclass(frozen=True, repr=False)
class SafeRanges(NoTruthValue):
    """All stable intervals of one quantity of the load within a range.

    Attributes
    ----------
    quantity, unit : str
        What varies ("mean force", "amplitude" or "frequency"), in N or rad/s.
    between : tuple of float
        The range searched.
    intervals : tuple of SafeInterval
        Stable intervals in increasing order; nothing between them is stable.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable; tongues that never exceed it are left out.
    modes : int
        Modes looked at, 1 to this; every higher mode grows at less than 1e-12 per second or the tolerance.
    hairlines : int
        Tongues within the stable intervals that grow, but nowhere faster than the tolerance.
    resolution : float
        Unstable parts up to this width may have been missed, in ``unit``: 0 where the search is complete.

    Iterating gives the intervals; ``value in ranges`` asks whether a value is safe.
    """

    ask = "len(...) or .intervals: how many intervals are stable says nothing of a load"

    quantity: str
    unit: str
    between: tuple[float, float]
    intervals: tuple[SafeInterval, ...]
    growth_tolerance: float
    modes: int
    hairlines: int
    resolution: float

    def __iter__(self) -> Iterator[SafeInterval]:
        """Iterate over the intervals."""
        return iter(self.intervals)

    def __len__(self) -> int:
        """Return the number of intervals."""
        return len(self.intervals)

    def __contains__(self, value: Any) -> bool:
        """Return whether ``value`` is safe; an end of the search may be, an end of a tongue is not."""
        return any(
            part.low < value < part.high
            or (value == part.low and part.low_end is None)
            or (value == part.high and part.high_end is None)
            for part in self.intervals
        )

    @property
    def note(self) -> str:
        """What has been left out."""
        slow = max(self.growth_tolerance, 1e-12)
        text = f"modes 1 to {self.modes}; growth at or below {slow:g} 1/s does not count"
        if self.hairlines:
            text += f": {self.hairlines} tongue{'s' * (self.hairlines > 1)} left out"
        return text

    def __repr__(self) -> str:
        """Return the intervals as a table."""
        return self.table(self.unit, 1.0)

    def table(self, unit: str, size: float) -> str:
        """Return the intervals as a table in another unit, ``size`` of `unit` each: ("Hz", 2 pi), say."""
        if not isinstance(unit, str):
            raise TypeError(f"unit must be a word such as 'Hz', got {validate.short(unit)}")
        size = validate.positive("size", size, "give it in the unit of the ranges")
        low, high = (value / size for value in self.between)
        lines = [f"stable {self.quantity} in {unit}, between {low:.6g} and {high:.6g}"]
        for part in self.intervals:
            ends = (_end(end) for end in (part.low_end, part.high_end))
            lines.append(f"  {part.low / size:12.9g} to {part.high / size:12.9g}   " + " ... ".join(ends))
        if not self.intervals:
            lines.append("  none")
        if self.resolution:
            lines.append(f"  (unstable parts narrower than {self.resolution / size:.2g} {unit} may have been missed)")
        return "\n".join([*lines, f"  ({self.note})"])


def safe_ranges(
    quantity: str,
    unit: str,
    unstable: UnstableLoads,
    between: tuple[float, float],
    growth_tolerance: float,
    modes: int,
) -> SafeRanges:
    """Return what the unstable loads leave of ``between``."""
    low, high = between
    at, closed_by = low, None
    intervals = []
    for part in sorted(unstable.ranges):
        if part.high <= at or part.low >= high:
            continue
        cause = (part.mode, part.tongue)
        if part.low > at:
            intervals.append(SafeInterval(at, part.low, closed_by, cause))
        at, closed_by = part.high, cause
    if at < high:
        intervals.append(SafeInterval(at, high, closed_by, None))
    return SafeRanges(
        quantity,
        unit,
        between,
        tuple(intervals),
        growth_tolerance,
        modes,
        unstable.hairlines,
        unstable.resolution,
    )


def _end(end: tuple[int, int] | None) -> str:
    return "end of the search" if end is None else f"mode {end[0]}, tongue {end[1]}"
