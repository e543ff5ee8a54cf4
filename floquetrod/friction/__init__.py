"""Kicks against Coulomb friction: does A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A') stay bounded?

Every motion starts at A(0) = 0 with A'(0) = kick (epsilon in the paper).  Its fate is to stay bounded or to grow in the
end like the growing Floquet solution; it is decided for all time and not for some number of periods.  The equation is
Eq. (14) of DOI 10.1115/1.4031710; derivations and proofs are on the page `theory/friction`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.floquet.status import UndecidedWarning
    from floquetrod.friction.critical_kicks import CriticalKickBounds, critical_kick
    from floquetrod.friction.fate_of_kicks import BOUNDED, ESCAPES, UNDECIDED, Fate, escapes, fate, fates
    from floquetrod.friction.kick_ranges import EscapeRanges, KickRange, escape_ranges
    from floquetrod.friction.leapfrog_criterion import leapfrog_escapes
    from floquetrod.friction.proved_kicks import CertainKicks, certain_kicks
    from floquetrod.friction.trajectories import Trajectory, trajectory

__all__ = [
    "BOUNDED",
    "ESCAPES",
    "UNDECIDED",
    "CertainKicks",
    "CriticalKickBounds",
    "EscapeRanges",
    "Fate",
    "KickRange",
    "Trajectory",
    "UndecidedWarning",
    "certain_kicks",
    "critical_kick",
    "escape_ranges",
    "escapes",
    "fate",
    "fates",
    "leapfrog_escapes",
    "trajectory",
]

__getattr__, __dir__ = names_of(
    __name__,
    {
        "floquet.status": ("UndecidedWarning",),
        "friction.critical_kicks": ("CriticalKickBounds", "critical_kick"),
        "friction.fate_of_kicks": ("BOUNDED", "ESCAPES", "UNDECIDED", "Fate", "escapes", "fate", "fates"),
        "friction.leapfrog_criterion": ("leapfrog_escapes",),
        "friction.proved_kicks": ("CertainKicks", "certain_kicks"),
        "friction.kick_ranges": ("EscapeRanges", "KickRange", "escape_ranges"),
        "friction.trajectories": ("Trajectory", "trajectory"),
    },
)
