"""Which kicks a stable rod comes to rest from, and which lead to a large motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from floquetrod._util.report import Report, Reported, number
from floquetrod.rod.loads.load import Load
from floquetrod.rod.model.data import RodData


@dataclass(frozen=True, repr=False)
class SafeKick(Reported):
    """How hard a knock a rod takes that is stable at rest, by a scan of kicks to one mode after the other.

    A kick is a transverse velocity that a mode is given at rest, at any phase of the load: that of the place of the rod
    where it is largest.

    Attributes
    ----------
    rod : Rod
    load : AxialLoad or AxialWave
    safe_up_to : float
        Kick in m/s up to which every one that was tried came to rest; infinite where no large motion was found.
    escapes_at : float
        Least kick in m/s found that leads to a large motion; infinite where none was found.
    mode : int
        The mode that it kicks; 0 for none.
    phase : float
        Phase of the load in rad, omega t, at which it does.
    angle : float
        About the angle in rad to which that kick swings the rod, freely; infinite for none.
    large : float
        Largest angle in rad of the large motion, in that mode alone; 0 for none.
    tried : int
        Kicks tried.
    """

    rod: RodData
    load: Load
    safe_up_to: float
    escapes_at: float
    mode: int
    phase: float
    angle: float
    large: float
    tried: int

    @property
    def _in_words(self) -> str:
        if self.mode == 0:
            return "safe against any kick: no large motion was found"
        return (
            f"safe up to {1e3 * self.safe_up_to:.4g} mm/s; {1e3 * self.escapes_at:.4g} mm/s in mode {self.mode} "
            f"leads to a motion of {math.degrees(self.large):.3g} degrees"
        )

    def report(self) -> Report:
        """Return the kicks in lines."""
        if self.mode == 0:
            return Report(self._in_words)
        lines = [
            ("kick", f"of mode {self.mode} at {math.degrees(self.phase):.3g} degrees of the load"),
            ("swings", f"by about {math.degrees(self.angle):.3g} degrees"),
            ("tried", f"{self.tried:,} kicks, each of one mode alone: between the two nothing is known"),
        ]
        return Report(self._in_words, lines)

    def as_dict(self) -> dict[str, Any]:
        """Return the kicks as numbers for JSON, units in the keys; None for infinite ones."""
        return {
            "safe_up_to_m_per_s": number(self.safe_up_to),
            "escapes_at_m_per_s": number(self.escapes_at),
            "mode": self.mode,
            "phase_rad": self.phase,
            "angle_rad": number(self.angle),
            "large_rad": self.large,
            "tried": self.tried,
        }

    def __str__(self) -> str:
        return str(self.report())

    def __repr__(self) -> str:
        """Return the kicks as a sentence."""
        return f"<{self._in_words}>"
