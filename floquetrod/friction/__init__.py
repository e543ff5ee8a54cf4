"""A kick against Coulomb friction: does A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A') escape, ever?

Every motion starts at A(0) = 0 with A'(0) = epsilon, the kick.  It either stays bounded for ever or grows in the end
like the growing Floquet solution; which, is decided for all time and not for some number of periods.  The equation is
Eq. (14) of DOI 10.1115/1.4031710; derivations and proofs are in docs/friction.md.
"""

from __future__ import annotations

from floquetrod.friction.critical import (
    CriticalPerturbation,
    KickRange,
    certain_kicks,
    critical_bounds,
    critical_perturbation,
)
from floquetrod.friction.fates import BOUNDED, ESCAPES, UNDECIDED, Fate, UndecidedWarning, escapes, fate, outcome
from floquetrod.friction.leapfrog import leapfrog_escapes
from floquetrod.friction.ranges import EscapeRanges, escape_ranges
from floquetrod.friction.trajectories import Trajectory, trajectory

__all__ = [
    "BOUNDED",
    "ESCAPES",
    "UNDECIDED",
    "CriticalPerturbation",
    "EscapeRanges",
    "Fate",
    "KickRange",
    "Trajectory",
    "UndecidedWarning",
    "certain_kicks",
    "critical_bounds",
    "critical_perturbation",
    "escape_ranges",
    "escapes",
    "fate",
    "leapfrog_escapes",
    "outcome",
    "trajectory",
]
