"""What is found along one quantity of a load: stability intervals, what closes them, and what lies between."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.rod.loads.axial import AxialGap
from floquetrod.rod.loads.load import Load, Quantity

WhatGrows: TypeAlias = tuple[int, int] | Resonance | Literal["unnamed"]
"""What grows: (mode, tongue), a resonance of coupled modes, or "unnamed" where that could not be determined."""

Cause: TypeAlias = WhatGrows | Literal["axial resonance"] | None
"""What closes a stability interval: (mode, tongue), a resonance of coupled modes, or None at an end of the search.

"axial resonance" where nothing was computed beyond it, see `StabilityIntervals.not_computed`.
"unnamed" where coupled modes grow, or may grow, and none could be named: beyond 200 of them, or where undecided.
"""


class BucklingWarning(UserWarning):
    """The weight along the rod buckles it even where the quantity varied is zero."""


class StabilityInterval(NamedTuple):
    """Stable from ``low`` to ``high``; what closes each end is (mode, tongue), where modes are coupled a `Resonance`.

    "unnamed" where that could not be determined; None at an end of the search.
    """

    low: float
    high: float
    low_end: Cause
    high_end: Cause


class UnstableBand(NamedTuple):
    """A range of one quantity of the load, in N or rad/s, in which some mode grows, or may grow where undecided.

    Attributes
    ----------
    low : float
        Where it begins: where a stability interval ends, or the search begins.
    high : float
        Where it ends likewise.
    worst_growth : float
        Largest growth rate in it, in 1/s; zero where none is seen to grow.
    at : float
        Where that is.
    cause : (int, int), Resonance or "unnamed"
        The mode and tongue that grow there, where modes are coupled a resonance.
    required_damping : float
        The rod's total damping rate in 1/s above which every rate stabilises all of the band, infinite where
        none does: the largest of samples, refined about it.  Where modes are coupled, that of the load ``at`` which
        growth is worst.
    """

    low: float
    high: float
    worst_growth: float
    at: float
    cause: WhatGrows
    required_damping: float


class Search(NamedTuple):
    """A search along one quantity of a load."""

    varied: Quantity
    load: Load  # with the largest value of what is varied
    bounds: tuple[float, float]
    growth_tolerance: float  # growth in 1/s up to which a mode counts as stable


class FoundIntervals(NamedTuple):
    """What a search found, as `floquetrod.results.StabilityIntervals` has it."""

    intervals: tuple[StabilityInterval, ...]
    modes: int  # modes examined, 1 to this
    tongues_left_out: int = 0  # resonance tongues left out
    resolution: float = 0.0  # unstable parts up to this width may have been missed
    not_computed: tuple[AxialGap, ...] = ()
