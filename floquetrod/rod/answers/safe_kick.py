"""Which kicks a stable rod was found to come to rest from, and which to lead to a large motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

from floquetrod._util.result_report import Printed, Report
from floquetrod.rod.loads.load import Load
from floquetrod.rod.mode_equations.one_mode import LARGEST
from floquetrod.rod.model.data import RodData


@dataclass(frozen=True, repr=False)
class SafeKick(Printed):
    """The kick up to which a rod that is stable at rest was found to return to it: a search, one mode at a time.

    A kick is a transverse velocity of a mode at rest, at any phase of the load, at the point of the rod where it is
    largest.  Tried are the modes for which, each alone, a search finds a large stable orbit.  Nothing is proved:
    kicks between those tried, in several modes at once, and in other modes may behave differently.

    Attributes
    ----------
    rod : Rod
    load : AxialLoad or AxialWave
    safe_up_to : float
        Kick in m/s up to which the rod came to rest after every kick tried; infinite where no large motion was found,
        and no kick tried.
    safe_mode : int
        The mode that sets this limit, which may be another than ``mode``; 0 for none.
    escapes_at : float
        Least kick in m/s found that leads to a large motion; infinite where none was found.
    mode : int
        The mode that this kick is of; 0 for none.
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
    safe_mode: int
    escapes_at: float
    mode: int
    phase: float
    angle: float
    large: float
    tried: int

    @property
    def _in_words(self) -> str:
        if self.safe_mode == 0:
            return f"no large motion of one mode found up to {math.degrees(LARGEST):.0f} degrees"
        rests = f"kicks of mode {self.safe_mode} up to {1e3 * self.safe_up_to:.4g} mm/s came to rest"
        if self.mode == 0:
            return f"{rests}; none was found that does not"
        which = "" if self.mode == self.safe_mode else f" of mode {self.mode}"
        return (
            f"{rests}; {1e3 * self.escapes_at:.4g} mm/s{which} leads to a motion of {math.degrees(self.large):.3g} "
            "degrees"
        )

    def report(self) -> Report:
        """Return the kicks in lines.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        lines = [("searched", f"orbits of one mode alone up to {math.degrees(LARGEST):.0f} degrees; nothing is proved")]
        if self.tried:
            lines.append(("tried", f"{self.tried:,} kicks, each of one mode alone that carries such an orbit"))
        if self.mode:
            lines.append(("kick", f"of mode {self.mode} at {math.degrees(self.phase):.3g} degrees of the load"))
            lines.append(("swings", f"by about {math.degrees(self.angle):.3g} degrees"))
        return Report(self._in_words, lines)

    _keys = "safe_up_to_m_per_s safe_mode escapes_at_m_per_s mode phase_rad angle_rad large_rad tried"
