"""A branch of periodic orbits over a parameter."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import extras
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Printed, Report, Table
from floquetrod.equations import NonlinearSystem
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.orbits.branch_files import load, save
from floquetrod.orbits.continuation import HOPF
from floquetrod.orbits.crossings import multipliers_of
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.special_points import SpecialPoint


@dataclass(frozen=True, eq=False, repr=False)
class Branch(ByContent, Printed, NoTruthValue):
    """Periodic orbits that change continuously with a parameter of the system, in their order.

    Attributes
    ----------
    parameter : str
        Name of the parameter.
    over : (float, float)
        Range of its values requested.
    orbits : tuple of PeriodicOrbit (k,)
        Each with its verdict.  Where the parameter turns back, the ``error`` of an orbit compares its states at the
        same length along the branch, not at the same value of the parameter.
    special_points : tuple of SpecialPoint
        Where a multiplier crosses the unit circle, in the order of the orbits.  A Hopf point, where the orbits shrink
        to a state of rest, is no orbit and not among them: it is named in ``ends``.
    ends : (str, str)
        Why the branch ends where it does, before its first orbit and after its last.
    tolerance : float
        Error of the states for which the meshes were chosen.
    notes : tuple of str
        Where the number of multipliers outside the unit circle changes and no special point was located, and why.
    """

    ask = ".status, an array with 1 where an orbit is stable, 0 where not and -1 where undecided"

    parameter: str
    over: tuple[float, float]
    orbits: tuple[PeriodicOrbit, ...]
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[str, str]
    tolerance: float = field(default=1e-10, compare=False)
    notes: tuple[str, ...] = ()

    @property
    def system(self) -> NonlinearSystem:
        """The system, with the parameters of the first orbit."""
        return self.orbits[0].system

    @cached_property
    def values(self) -> Floats:
        """Values of the parameter (k,)."""
        return np.array([orbit.system.parameters[self.parameter] for orbit in self.orbits])

    @cached_property
    def period(self) -> Floats:
        """Periods (k,), in the unit of the system's time."""
        return np.array([orbit.period for orbit in self.orbits])

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """Verdicts (k,), 1 stable, 0 unstable, -1 undecided."""
        return np.array([STATUS_CODES[orbit.status] for orbit in self.orbits], dtype=np.int8)

    @cached_property
    def largest(self) -> Floats:
        """Largest value of each state over the period (k, n), each as accurate as the states of its orbit."""
        return np.array([orbit.largest for orbit in self.orbits])

    @cached_property
    def least(self) -> Floats:
        """Least value of each state over the period (k, n), likewise."""
        return np.array([orbit.least for orbit in self.orbits])

    @property
    def amplitude(self) -> Floats:
        """Half the difference between the largest and the least value of each state (k, n)."""
        return 0.5 * (self.largest - self.least)

    @cached_property
    def multipliers(self) -> Complexes:
        """Multipliers (k, n), NaN where unknown; of autonomous systems (k, n - 1), without the trivial one."""
        return np.array([multipliers_of(orbit).values for orbit in self.orbits])

    @cached_property
    def multiplier_errors(self) -> Floats:
        """Their errors, in the same shape."""
        return np.array([multipliers_of(orbit).errors for orbit in self.orbits])

    def plot(self, ax: Any = None, *, state: int = 0, quantity: str = "amplitude") -> Any:
        """Draw the branch: solid where stable, dashed where unstable, dotted where undecided, special points named.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw into; a new figure by default.
        state : int
            Which state, counted from 0.
        quantity : {"amplitude", "largest", "least", "period"}
            The quantity drawn over the parameter.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        TypeError, ValueError
            For a state or a quantity that is not there.
        """
        from floquetrod._util import validate
        from floquetrod.plotting.branch_plot import draw_branch

        validate.choice("quantity", quantity, ("amplitude", "largest", "least", "period"))
        state = validate.integer("state", state, 0, self.orbits[0].states.shape[1] - 1)
        return draw_branch(self, ax, state, quantity)

    def report(self) -> Report:
        """Return the branch in lines, and a table of its special points.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        counts = [f"{int((self.status == code).sum())} {name}" for name, code in STATUS_CODES.items()]
        low, high = float(self.values.min()), float(self.values.max())
        lines = [
            (
                "branch",
                f"{self.parameter} from {low:.6g} to {high:.6g}, {len(self.orbits)} orbits: {', '.join(counts)}",
            ),
            ("period", f"{self.period.min():.6g} to {self.period.max():.6g}"),
            ("error", f"{max(orbit.error for orbit in self.orbits):.1g} of the states at most, along the branch"),
            ("begins", self.ends[0]),
            ("ends", self.ends[1]),
            *(("note", note) for note in self.notes),
        ]
        kinds = [point.kind for point in self.special_points]
        named = [f"{kinds.count(kind)} {kind}{'s' * (kinds.count(kind) > 1)}" for kind in dict.fromkeys(kinds)]
        named += [self._hopf] if self._hopf else []
        named += [self._unlocated[2:]] if self.notes else []
        return Report(", ".join(named) or "no special points", lines, self._table() if kinds else None)

    @property
    def _hopf(self) -> str:
        """At how many ends the branch shrinks to a state of rest, in words; "" for none."""
        return ("", "a Hopf point at one end", "a Hopf point at either end")[sum(HOPF in end for end in self.ends)]

    @property
    def _unlocated(self) -> str:
        """How many special points are not located, in words; "" for none."""
        count = len(self.notes)
        return f", {count} place{'s' * (count > 1)} where a special point was not located (see notes)" if count else ""

    def _table(self) -> Table:
        columns = (
            ("", ">3"),
            ("point", "<16"),
            (self.parameter, "<16"),
            ("error", ">8"),
            ("period", ">10"),
            ("multiplier", "<24"),
        )
        rows = [
            (str(i), point.kind, f"{point.value:.11g}", f"{point.error:.0e}", f"{point.orbit.period:.6g}", _mu(point))
            for i, point in enumerate(self.special_points)
        ]
        return Table(columns, rows)

    _keys = "parameter over values status period largest least special_points ends notes"

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset over the orbits and the special points (needs xarray, an extra).

        Returns
        -------
        xarray.Dataset
            Status, period, least and largest states and multipliers of each orbit; the parameters as coordinates, those
            that the branch keeps without a dimension.

        Raises
        ------
        ImportError
            Without xarray.
        """
        xarray = extras.xarray()
        data: dict[str, Any] = {"status": ("orbit", self.status), "period": ("orbit", self.period)}
        data |= {name: (("orbit", "state"), getattr(self, name)) for name in ("largest", "least", "amplitude")}
        data |= {name: (("orbit", "multiplier"), getattr(self, name)) for name in ("multipliers", "multiplier_errors")}
        points = self.special_points
        coordinates: dict[str, Any] = {self.parameter: ("orbit", self.values)}
        kept = {name: value for name, value in self.system.parameters.items() if name != self.parameter}
        coordinates |= {f"parameter_{name}" if name in data else name: value for name, value in kept.items()}
        attributes = {"parameter": self.parameter, "begins": self.ends[0], "ends": self.ends[1]}
        if not points:  # an empty dimension would leave a DataFrame of xarray without rows
            return xarray.Dataset(data, coordinates, attributes)
        data["special_kind"] = ("special_point", np.array([point.kind for point in points], dtype=str))
        data["special_value"] = ("special_point", np.array([point.value for point in points], dtype=float))
        data["special_error"] = ("special_point", np.array([point.error for point in points], dtype=float))
        return xarray.Dataset(data, coordinates, attributes)

    def save(self, path: str | Path) -> Path:
        """Write everything but the function of the system to an npz file.

        An older file of that name is kept until the new one is complete.

        Returns
        -------
        Path
            Of the file written.

        Raises
        ------
        TypeError, ValueError
            For a path that is no text or path.
        OSError
            Where the file cannot be written.
        """
        return save(self, path)

    @classmethod
    def load(cls, path: str | Path, system: NonlinearSystem) -> Branch:
        """Read a branch that `save` wrote, of a system that is not in the file, because it is a function.

        Returns
        -------
        Branch
            Equal to the branch saved.

        Raises
        ------
        TypeError, ValueError
            For a file that is damaged, if only in one bit, or foreign, or of another system.
        """
        return cls(**load(path, system))

    def __repr__(self) -> str:
        """Return the branch as a sentence."""
        ends = f"{self._hopf and ', ' + self._hopf}{self._unlocated}"
        return (
            f"<branch of {len(self.orbits)} orbits, {self.parameter} from {self.values.min():.6g} to "
            f"{self.values.max():.6g}, {len(self.special_points)} special points{ends}>"
        )


def _mu(point: SpecialPoint) -> str:
    mu, times = point.multiplier, f", {point.count} together" if point.count > 1 else ""
    return (f"{mu.real:.8f} +- {mu.imag:.8f} i" if point.kind == "Neimark-Sacker" else f"{mu.real:.8f}") + times
