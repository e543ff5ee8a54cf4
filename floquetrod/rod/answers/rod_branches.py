"""How large a rod's motion becomes over a range of loads: its branches of periodic orbits, with angles as ordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import extras
from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.interchange import by_keys
from floquetrod._util.result_report import Printed, Report, Table
from floquetrod._util.suggest import listed
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.orbits import Branch
from floquetrod.rod.loads.load import LOAD, Load, Quantity, load_number
from floquetrod.rod.model.data import RodData

OFF_WALL = "the rod is about to leave its wall"
"""What the ends of branches begin with beyond which the equations do not hold."""

LARGE_SLOPE = 0.1
"""Slope of a rod along its channel from which its square, a percent, is said to count (a choice)."""


@dataclass(frozen=True, eq=False, repr=False)
class RodBranch(ByContent):
    """One branch of the periodic motion of a rod.

    Attributes
    ----------
    branch : Branch
        Its k orbits in the amplitudes and speeds of the modes, special points and ends.
    amplitude : ndarray (k,)
        Largest angle in rad of each orbit.
    contact : ndarray (k,)
        Least contact force in N/m of each, of a rod on its wall up to its ends.
    slope : ndarray (k,)
        Largest slope along the channel, R theta_s, which the equations take for small.
    special_amplitudes : ndarray (p,)
        Largest angle in rad at each special point.
    rests : tuple of float or None
        Value of the parameter at which motion shrinks to rest beyond the first orbit, and beyond the last.
    """

    branch: Branch
    amplitude: Floats
    contact: Floats
    slope: Floats
    special_amplitudes: Floats
    rests: tuple[float | None, float | None]

    @property
    def turns(self) -> int:
        """Periods of the load that the motion takes."""
        return int(self.branch.orbits[0].collocation.turns or 1)

    @property
    def ends(self) -> tuple[str, str]:
        """Why the branch ends where it does, before its first orbit and after its last."""
        name, (begins, ends) = self.branch.parameter, self.branch.ends
        ends_at_rest = [None if at is None else f"motion shrinks to rest at {name} = {at:.6g}" for at in self.rests]
        return ends_at_rest[0] or begins, ends_at_rest[1] or ends

    @property
    def leaves(self) -> list[int]:
        """Orbits beyond which the rod is about to leave its wall, 0, the first, or -1, the last."""
        return [i for i, end in zip((0, -1), self.branch.ends, strict=True) if end.startswith(OFF_WALL)]


@dataclass(frozen=True, eq=False, repr=False)
class RodBranches(ByContent, Printed, NoTruthValue):
    """The large motions of a rod in one mode over a range of loads.

    Attributes
    ----------
    rod : Rod
    load : AxialLoad or AxialWave
        The load with the parameter at the value where the search began.
    parameter : "frequency", "mean" or "amplitude"
    over : (float, float)
        Its range, in rad/s or N.
    mode : int
        Mode that moves, by its number of half waves.
    modes : tuple of int
        Modes of the equations: it, and the one three times as short, or all that matter.
    parts : tuple of RodBranch
        The branches that were found: a search from some loads of the range, not a proof that there are no others.
    """

    ask = ".status, an array with 1 where an orbit is stable, 0 where not and -1 where undecided"

    rod: RodData
    load: Load
    parameter: Quantity
    over: tuple[float, float]
    mode: int
    modes: tuple[int, ...]
    parts: tuple[RodBranch, ...]

    @property
    def unit(self) -> str:
        """Unit of the parameter."""
        return "rad/s" if self.parameter == "frequency" else "N"

    @property
    def values(self) -> Floats:
        """Values of the parameter in rad/s or N (k,), of all branches one after the other."""
        return np.concatenate([part.branch.values for part in self.parts])

    @property
    def amplitude(self) -> Floats:
        """Largest angles in rad (k,), likewise."""
        return np.concatenate([part.amplitude for part in self.parts])

    @property
    def status(self) -> NDArray[np.int8]:
        """Verdicts (k,), likewise, 1 stable, 0 unstable, -1 undecided, of deviations in ``modes``."""
        return np.concatenate([part.branch.status for part in self.parts])

    @property
    def contact(self) -> Floats:
        """Least contact forces in N/m (k,), likewise."""
        return np.concatenate([part.contact for part in self.parts])

    @property
    def slope(self) -> Floats:
        """Largest slopes along the channel (k,), likewise."""
        return np.concatenate([part.slope for part in self.parts])

    @property
    def number(self) -> Ints:
        """Number of the branch of each orbit (k,), from 0."""
        return np.repeat(np.arange(len(self.parts)), [len(part.amplitude) for part in self.parts])

    @property
    def is_whole(self) -> bool:
        """Whether no branch was interrupted, or ran out of steps."""
        return not any("continues" in end for part in self.parts for end in part.branch.ends)

    def at(self, value: float | str) -> list[tuple[float, str]]:
        """Return the largest angles in rad at a value of the parameter, smallest first, and whether each is stable.

        Between two orbits of a branch, by a straight line; none where no branch comes to the value.

        Parameters
        ----------
        value : float or str
            In rad/s or N, or with a unit, such as "23.5Hz".

        Returns
        -------
        list of (float, str)
            Angle and status.

        Raises
        ------
        TypeError, ValueError
            For a value that is no number, or in another unit.
        """
        value = load_number(self.parameter, value, "value")
        names = {code: name for name, code in STATUS_CODES.items()}
        orbits_there: list[tuple[float, str]] = []
        near = 1e-9 * (self.over[1] - self.over[0])
        for part in self.parts:
            orbits = zip(part.branch.values.tolist(), part.amplitude.tolist(), part.branch.status.tolist(), strict=True)
            for (x0, y0, s0), (x1, y1, s1) in pairwise(orbits):
                if min(x0, x1) - near <= value <= max(x0, x1) + near:
                    y = y0 + (value - x0) / (x1 - x0) * (y1 - y0) if x0 != x1 else y0
                    if not orbits_there or abs(orbits_there[-1][0] - y) > 1e-6 * y:  # not the end of the piece before
                        orbits_there.append((y, names[s0] if s0 == s1 else "undecided"))
        return sorted(orbits_there)

    def plot(self, ax: Any = None, *, unit: str = "") -> Any:
        """Draw the largest angle over the parameter: solid where stable, dashed where unstable, dotted undecided.

        A cross marks where the rod is about to leave its wall: beyond it, the rod must be simulated.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw into; a new figure by default.
        unit : str
            Of the parameter: "Hz", "Fcr"; by default the SI unit.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        from floquetrod.plotting.branch_plot import draw_rod_branches

        chosen = units.unit(unit, "unit", LOAD[self.parameter].kind, self.rod.critical_force)
        return draw_rod_branches(self, ax, chosen)

    @property
    def _in_words(self) -> str:
        count = f"{len(self.parts)} branch{'es' * (len(self.parts) != 1)}"
        return f"{count} of motion in mode {self.mode}, up to {math.degrees(self.amplitude.max()):.3g} degrees"

    def report(self) -> Report:
        """Return the branches in a table, with their ends, and the limits of the equations.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        lines = []
        for i, part in enumerate(self.parts):
            lines += [(f"{i}", f"begins: {part.ends[0]}"), ("", f"ends: {part.ends[1]}")]
            lines += [("", f"{point}") for point in part.branch.special_points]
        lost = [math.degrees(part.amplitude[i]) for part in self.parts for i in part.leaves]
        if lost:
            lines.append(("contact", f"is about to be lost from {min(lost):.3g} degrees on: simulate the rod there"))
        if self.slope.max() > LARGE_SLOPE:
            lines.append(("slopes", f"up to {self.slope.max():.2g}: the equations are those of small ones"))
        lines.append(("status", f"of deviations in modes {listed(self.modes)}; steady_motion includes all modes"))
        return Report(self._in_words, lines, Table(_COLUMNS, [_row(i, part) for i, part in enumerate(self.parts)]))

    def as_dict(self) -> dict[str, Any]:
        """Return the branches as numbers for JSON, units in the keys.

        Returns
        -------
        dict of str
            Among them ``branches``, a list with a dict for each.
        """
        of_each = (
            "values=branch.values amplitude_rad status=branch.status contact_N_per_m slope turns "
            "special_points=branch.special_points ends"
        )
        branches = [by_keys(part, of_each) for part in self.parts]
        return by_keys(self, "mode modes parameter unit over") | {"branches": branches}

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset over the orbits of all branches (needs xarray, an extra).

        Returns
        -------
        xarray.Dataset
            Amplitude, status, contact and slope of each orbit.

        Raises
        ------
        ImportError
            Without xarray.
        """
        xarray = extras.xarray()
        names = {"amplitude": "rad", "status": "", "contact": "N/m", "slope": "", "number": ""}
        data = {name: ("orbit", getattr(self, name), {"units": unit}) for name, unit in names.items()}
        ends = [end for part in self.parts for end in part.ends]
        attributes = {"parameter": self.parameter, "mode": self.mode, "ends": ends}
        return xarray.Dataset(data, {self.parameter: ("orbit", self.values, {"units": self.unit})}, attributes)


_COLUMNS = (("", ">3"), ("from", ">9"), ("to", ">9"), ("degrees", ">14"), ("repeats", ">7"), ("orbits", "<40"))


def _row(number: int, part: RodBranch) -> tuple[str, ...]:
    """Return the row of a branch in the table."""
    x, y, codes = part.branch.values, np.degrees(part.amplitude), part.branch.status
    counts = [f"{int((codes == code).sum())} {name}" for name, code in STATUS_CODES.items() if (codes == code).any()]
    angles = f"{y.min():.3g} to {y.max():.3g}"
    return (str(number), f"{x.min():.6g}", f"{x.max():.6g}", angles, f"{part.turns}", ", ".join(counts))
