"""How large the motion of a rod gets after its onset: a periodic orbit on the wall, and what it does to the rod."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Printed, Report
from floquetrod._util.suggest import listed
from floquetrod.floquet.status import Status
from floquetrod.orbits import PeriodicOrbit
from floquetrod.rod.answers.reports import answer_units, shown_in
from floquetrod.rod.loads.load import Load
from floquetrod.rod.model.data import RodData


@dataclass(frozen=True, eq=False, repr=False)
class SteadyMotion(ByContent, Printed, NoTruthValue):
    """The steady motion of a rod on its wall under a load, or rest.

    Attributes
    ----------
    rod : Rod
    load : AxialLoad or AxialWave
    mode : int
        Mode that moves most, by its number of half waves; 0 at rest.
    amplitude : float
        Largest angle in rad that any point of the rod reaches; 0 at rest.
    error : float
        Estimate of the error of the amplitude in rad as a solution of the equations on the wall: how much it changes
        with more modes, and the error of the orbit.
    orbit : PeriodicOrbit or None
        The orbit in the amplitudes of ``modes`` and their speeds; None at rest.
    modes : tuple of int
        Modes of the equations.
    status : "stable", "unstable" or "undecided"
        Whether motion returns to the orbit after small deviations in any mode, those not of ``modes`` too.
    is_rest_stable : bool
        Whether the rod at rest is stable, so that it takes a kick to reach the orbit.
    contact : tuple of float
        Least and largest contact force in N/m along the rod over a period, of a rod on the wall up to its ends; it
        leaves the wall where that is negative.
    lost_at : float or None
        Where the least is negative: its position in m from the upper end.
    shortening : tuple of float
        Least and largest shortening in m along the channel over a period, by the lateral motion.
    note : str
        Further remarks.
    """

    ask = ".status ('stable', 'unstable' or 'undecided')"

    rod: RodData
    load: Load
    mode: int
    amplitude: float
    error: float
    orbit: PeriodicOrbit | None
    modes: tuple[int, ...]
    status: Status
    is_rest_stable: bool
    contact: tuple[float, float]
    lost_at: float | None
    shortening: tuple[float, float]
    note: str = ""

    @property
    def stays_on_wall(self) -> bool:
        """Whether the contact force stays positive; otherwise the result does not hold."""
        return self.lost_at is None

    @property
    def _in_words(self) -> str:
        if self.orbit is None:
            return "at rest: no large motion was found"
        size = f"{math.degrees(self.amplitude):.4g} degrees in mode {self.mode}"
        how = {"stable": "", "unstable": ", unstable", "undecided": ", stability undecided"}[self.status]
        kick = ", after a kick: the rod at rest is stable" if self.is_rest_stable else ""
        return f"moves by {size}{how}{kick}"

    def report(self, units: Mapping[str, str] | None = None) -> Report:
        """Return amplitude, contact force, shortening and verdict in lines.

        ``units`` in which to show forces and lengths: ``{"force": "lbf", "length": "ft"}``.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        if self.orbit is None:
            return Report(self._in_words, [("note", self.note)] if self.note else [])
        shown = answer_units(shown_in(units, self.rod, self.load))
        pressed = shown.per_length
        smallest, largest = (pressed.of(value) for value in self.contact)
        short = [shown.across.of(value) for value in self.shortening]
        weight = self.rod.mass_per_length * self.rod.effective_gravity
        turns = round(self.orbit.period * self.load.frequency / (2.0 * math.pi))
        repeats = "every period of the load" if turns == 1 else f"every {turns} periods of the load"
        lines = [
            ("angle", f"{self.amplitude:.6g} rad, +- {self.error:.1g} of the equations on the wall; {repeats}"),
            ("contact", f"{smallest:.4g} to {largest:.4g} {pressed.name}, the weight is {pressed.of(weight):.4g}"),
            ("shorter", f"by {short[0]:.3g} to {short[1]:.3g} {shown.across.name}"),
            ("status", f"{self.status}, in modes {listed(self.modes)} and all others that matter"),
        ]
        if self.lost_at is not None:
            lines.append(
                ("contact", f"lost at {shown.length.show(self.lost_at, 4)}: the motion is another one, simulate it")
            )
        return Report(self._in_words, [*lines, ("note", self.note)] if self.note else lines)

    _keys = (
        "mode amplitude_rad error_rad status is_rest_stable contact_N_per_m contact_lost_at_m=lost_at shortening_m "
        "modes note"
    )
