"""A curve of special points in the plane of two parameters."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import extras
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Printed, Report, Table
from floquetrod.orbits.crossings import multipliers_of, nearest
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.special_points import Kind

_LISTED = 12  # points in the table of a report


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationCurve(ByContent, Printed, NoTruthValue):
    """Folds, branch points, period doublings or Neimark-Sacker points of periodic orbits, over two parameters.

    Attributes
    ----------
    kind : {"fold", "branch point", "period doubling", "Neimark-Sacker"}
        Kind of the special point that the curve goes through.
    parameters : (str, str)
        Names of the parameters.
    over : ((float, float), (float, float))
        Their ranges.
    orbits : tuple of PeriodicOrbit (k,)
        The orbit at each point of the curve, in their order.
    errors : ndarray (k, 2)
        Estimates of the errors of both parameters, across the curve: of the orbit, of the multiplier and of rounding.
    start : int
        Index of the special point that the curve was begun with.
    ends : (str, str)
        Why the curve ends where it does, before its first point and after its last.
    tolerance : float
        Error of the states for which the meshes were chosen.
    notes : tuple of str
        Where the curve passes cusps of folds, and strong resonances of a pair.
    """

    ask = ".outside, an array with the number of other multipliers outside the unit circle"

    kind: Kind
    parameters: tuple[str, str]
    over: tuple[tuple[float, float], tuple[float, float]]
    orbits: tuple[PeriodicOrbit, ...]
    errors: Floats
    start: int
    ends: tuple[str, str]
    tolerance: float = field(default=1e-10, compare=False)
    notes: tuple[str, ...] = ()

    @cached_property
    def values(self) -> Floats:
        """Values of both parameters (k, 2)."""
        return np.array([[orbit.system.parameters[name] for name in self.parameters] for orbit in self.orbits])

    @cached_property
    def period(self) -> Floats:
        """Periods (k,), in the unit of the system's time."""
        return np.array([orbit.period for orbit in self.orbits])

    @cached_property
    def largest(self) -> Floats:
        """Largest value of each state over the period (k, n)."""
        return np.array([orbit.largest for orbit in self.orbits])

    @cached_property
    def least(self) -> Floats:
        """Least value of each state over the period (k, n)."""
        return np.array([orbit.least for orbit in self.orbits])

    @cached_property
    def multipliers(self) -> Complexes:
        """Multipliers (k, n), NaN where unknown; of autonomous systems (k, n - 1), without the trivial one."""
        return np.array([multipliers_of(orbit).values for orbit in self.orbits])

    @cached_property
    def critical(self) -> Complexes:
        """Critical multiplier (k,), of a pair the one with positive imaginary part; NaN where unknown."""
        return np.array([self._critical(i)[1] for i in range(len(self.orbits))])

    @cached_property
    def outside(self) -> NDArray[np.int64]:
        """Number of other multipliers outside the unit circle (k,), -1 where an error covers the circle.

        Where it is 0, orbits to one side of the curve are stable.
        """
        return np.array([self._outside(i) for i in range(len(self.orbits))])

    def _critical(self, i: int) -> tuple[list[int], complex]:
        """Return the indices of the critical multipliers of an orbit, and the one with positive imaginary part."""
        multipliers = multipliers_of(self.orbits[i])
        if not np.isfinite(multipliers.values).all():
            return [], complex(np.nan)
        which = nearest(multipliers, self.kind)
        mu = complex(multipliers.values[which])
        if self.kind != "Neimark-Sacker":
            return [which], mu
        return [which, int(np.abs(multipliers.values - mu.conjugate()).argmin())], mu

    def _outside(self, i: int) -> int:
        which, _ = self._critical(i)
        multipliers = multipliers_of(self.orbits[i])
        sizes, errors = (np.delete(part, which) for part in (np.abs(multipliers.values), multipliers.errors))
        if not which or not ((sizes - errors > 1.0) | (sizes + errors < 1.0)).all():
            return -1
        return int(np.count_nonzero(sizes > 1.0))

    def plot(self, ax: Any = None) -> Any:
        """Draw the curve: solid where no other multiplier is outside the unit circle, dashed where one is, else dotted.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw into; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.branch_plot import draw_bifurcation_curve

        return draw_bifurcation_curve(self, ax)

    def report(self) -> Report:
        """Return the curve in lines, and a table of some of its points.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        reach = [
            f"{name} from {low:.6g} to {high:.6g}"
            for name, low, high in zip(self.parameters, self.values.min(axis=0), self.values.max(axis=0), strict=True)
        ]
        worst = [f"{error:.1g} of {name}" for name, error in zip(self.parameters, self.errors.max(axis=0), strict=True)]
        numbers, points = np.unique(self.outside, return_counts=True)
        named = ["an unknown number" if k < 0 else str(k) for k in numbers.tolist()]
        counts = [f"{count} with {name}" for count, name in zip(points.tolist(), named, strict=True)]
        lines = [
            ("curve", f"{len(self.orbits)} points: {'; '.join(reach)}"),
            ("period", f"{self.period.min():.6g} to {self.period.max():.6g}"),
            ("error", f"{', '.join(worst)} across the curve, the largest along it"),
            ("outside", f"points by other multipliers outside the unit circle: {', '.join(counts)}"),
            ("begins", self.ends[0]),
            ("ends", self.ends[1]),
            *(("note", note) for note in self.notes),
        ]
        return Report(f"{self.kind} curve of periodic orbits", lines, self._table())

    def _table(self) -> Table:
        first, second = self.parameters
        columns = (
            ("", ">4"),
            (first, "<16"),
            (second, "<16"),
            (f"{first} error", ">10"),
            (f"{second} error", ">10"),
            ("period", ">10"),
            ("multiplier", "<26"),
        )
        listed = np.unique(np.linspace(0, len(self.orbits) - 1, min(_LISTED, len(self.orbits))).round().astype(int))
        rows = []
        for i in listed.tolist():
            a, b = self.values[i]
            mu = complex(self.critical[i])
            sign = f"{mu.real:.6f}" + (f" +- {mu.imag:.6f} i" if self.kind == "Neimark-Sacker" else "")
            rows.append(
                (
                    str(i),
                    f"{a:.10g}",
                    f"{b:.10g}",
                    *(f"{error:.1g}" for error in self.errors[i]),
                    f"{self.period[i]:.6g}",
                    sign,
                )
            )
        return Table(columns, rows)

    _keys = "kind parameters over values errors period critical outside least largest start ends notes"

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset over the points of the curve (needs xarray, an extra).

        Returns
        -------
        xarray.Dataset
            Parameters, errors, period, least and largest states and multipliers of each point of the curve.

        Raises
        ------
        ImportError
            Without xarray.
        """
        xarray = extras.xarray()
        data: dict[str, Any] = {"period": ("point", self.period), "outside": ("point", self.outside)}
        data |= {f"{name}_error": ("point", self.errors[:, k]) for k, name in enumerate(self.parameters)}
        data |= {name: (("point", "state"), getattr(self, name)) for name in ("largest", "least")}
        data["multipliers"] = (("point", "multiplier"), self.multipliers)
        coordinates = {name: ("point", self.values[:, k]) for k, name in enumerate(self.parameters)}
        return xarray.Dataset(data, coordinates, {"kind": self.kind, "begins": self.ends[0], "ends": self.ends[1]})

    def __repr__(self) -> str:
        """Return the curve as a sentence."""
        (a, b), (c, d) = self.values.min(axis=0), self.values.max(axis=0)
        first, second = self.parameters
        return (
            f"<{self.kind} curve of {len(self.orbits)} points, {first} from {a:.6g} to {c:.6g}, {second} from {b:.6g} "
            f"to {d:.6g}>"
        )
