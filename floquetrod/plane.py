"""Stability over a plane: one frozen result for charts of an equation and maps of a rod, saved and loaded whole."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import files, validate
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.version import __version__

_FORMAT = "floquetrod chart 2"
_AT_ONCE = 1 << 18  # points computed between two reports of progress: about a megabyte an array
_MOST_POINTS = 1 << 28  # of a chart, which are five gigabytes with growth rates and modes (a choice)

_CRITICAL = "critical force"
"""Name of the rod's critical force among what is fixed."""


Progress = Callable[[int, int], None]
"""Called with the number of points done and their total."""


@dataclass(frozen=True, eq=False)
class Axis(ByContent):
    """One axis of a chart: what varies, its symbol in mathematics, its unit ("" for none) and its values."""

    name: str
    symbol: str
    unit: str
    values: NDArray[np.float64]

    @property
    def label(self) -> str:
        """Label of the axis, symbol and unit included."""
        if not self.symbol:
            return self.name + (f" / {self.unit}" if self.unit else "")
        # "alpha" and its letter would say it twice
        name = "" if self.symbol.replace("_{", "").strip("\\}") == self.name.replace("_", "") else self.name
        return units.label(name, self.symbol, self.unit)


@dataclass(frozen=True, eq=False, repr=False)
class Chart(NoTruthValue, ByContent):
    """Verdicts over a plane.

    Attributes
    ----------
    x, y : Axis
        Columns and rows.
    stable : ndarray (ny, nx) of bool
        Verdict, growth tolerance included.
    growth_rate : ndarray (ny, nx) or None
        Growth rate of the fastest solution or mode, in ``growth_unit``; None unless asked for.
    first_mode : ndarray (ny, nx) of int or None
        Mode of a rod that grows fastest, 0 where none grows; None unless growth was asked for, and for equations.
    growth_unit : str
        "per tau", "per unit time" (of systems) or "1/s".
    subject : dict
        "kind" says what is charted, "fixed" lists [name, value, unit] of what does not vary; a rod's data sheet is
        under "rod".
    growth_tolerance : float
        Growth, in ``growth_unit``, up to which a point counts as stable.
    criterion : str
        What "stable" means where it is not the equation's own stability; "" where it is.
    undecided : int
        Points that no method could decide; they count as not stable.
    version : str
        Version of the package that made it.
    """

    ask = ".stable, an array"

    x: Axis
    y: Axis
    stable: NDArray[np.bool_]
    growth_rate: NDArray[np.float64] | None
    first_mode: NDArray[np.int64] | None
    growth_unit: str
    subject: dict[str, Any]
    growth_tolerance: float
    criterion: str
    undecided: int
    version: str

    @property
    def caption(self) -> str:
        """One sentence that says what is shown."""
        fixed = ", ".join(f"{name} {value:.6g} {unit}".strip() for name, value, unit in self.subject["fixed"])
        share = f"{100.0 * self.stable.mean():.1f} % of {self.stable.size} points stable"
        tolerance = f"; growth up to {self.growth_tolerance:g} {self.growth_unit} counts as stable"
        text = ", ".join(filter(None, [self.subject["kind"], fixed]))
        text += f": {share}" + (tolerance if self.growth_tolerance else "")
        text += f"; {self.undecided} undecided" if self.undecided else ""
        return text + (f"; {self.criterion}" if self.criterion else "")

    def in_units(self, **names: str) -> Chart:
        """Return the same chart in other units, for axes, caption and drawings.

        Each quantity goes by the first word of its name: ``chart.in_units(mean="Fcr", frequency="Hz")``.  "Fcr" is the
        critical force of the rod.

        Raises
        ------
        ValueError
            For a quantity that the chart does not have, and for a unit that does not measure it.
        """
        fixed = [list(entry) for entry in self.subject["fixed"]]
        scale = next((units.unit(u, name, "force").si(value) for name, value, u in fixed if name == _CRITICAL), None)
        present = {self.x.name: self.x.unit, self.y.name: self.y.unit} | {name: u for name, _, u in fixed}
        sizes: dict[str, tuple[str, float]] = {}  # of each quantity: its new unit, and what to multiply values with
        for key, wanted in names.items():
            name = next((name for name in present if name.partition(" ")[0] == key), None)
            kind = units.kind_of(present[name]) if name else None
            if name is None or kind is None:
                raise ValueError(f"{key} must be a quantity with a unit of this chart: {', '.join(present)}")
            old, new = (units.unit(u, key, kind, scale) for u in (present[name], wanted))
            sizes[name] = new.name, old.size / new.size

        def axis(old: Axis) -> Axis:
            unit, factor = sizes.get(old.name, (old.unit, 1.0))
            return Axis(old.name, old.symbol, unit, old.values * factor)

        for entry in fixed:
            unit, factor = sizes.get(entry[0], (entry[2], 1.0))
            entry[1:] = [entry[1] * factor, unit]
        return replace(self, x=axis(self.x), y=axis(self.y), subject=self.subject | {"fixed": fixed})

    def __repr__(self) -> str:
        """Return the caption, axes included."""
        return f"<{self.y.name} over {self.x.name}; {self.caption}>"

    def plot(self, ax: Any = None) -> Any:
        """Draw the chart, orange where unstable (darker the faster, if growth is known); return the matplotlib axes."""
        from floquetrod.plotting.charts import draw_chart

        return draw_chart(self, ax)

    def save(self, path: str | Path) -> Path:
        """Write everything to an npz file; an older file of that name stays whole until the new one is complete."""
        arrays: dict[str, Any] = {"x": self.x.values, "y": self.y.values, "stable": self.stable}
        for name in ("growth_rate", "first_mode"):
            if getattr(self, name) is not None:
                arrays[name] = getattr(self, name)
        meta = {
            "format": _FORMAT,
            "x": [self.x.name, self.x.symbol, self.x.unit],
            "y": [self.y.name, self.y.symbol, self.y.unit],
            "growth_unit": self.growth_unit,
            "subject": self.subject,
            "growth_tolerance": self.growth_tolerance,
            "criterion": self.criterion,
            "undecided": self.undecided,
            "version": self.version,
        }
        return files.write_npz(path, meta, arrays, compress=True)

    @classmethod
    def load(cls, path: str | Path) -> Chart:
        """Read a chart that `save` wrote.

        Raises ValueError for a file that is damaged, if only in one bit, or foreign.
        """
        return files.read_npz(path, _FORMAT, "a chart", _chart)

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset (needs xarray, an extra: pip install floquetrod[xarray])."""
        import xarray

        coords = {axis.name: (axis.name, axis.values, {"units": axis.unit}) for axis in (self.x, self.y)}
        names = ("stable", "growth_rate", "first_mode")
        data = {n: ((self.y.name, self.x.name), getattr(self, n)) for n in names if getattr(self, n) is not None}
        attributes = {n: getattr(self, n) for n in ("growth_unit", "growth_tolerance", "criterion", "version")}
        return xarray.Dataset(data, coords, attributes)


def _chart(meta: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Chart:
    """Return the chart that a file describes; ValueError or KeyError where it is not as `Chart.save` writes it."""
    x, y = (_axis(meta, arrays, name) for name in "xy")
    shape = y.values.size, x.values.size
    tolerance, undecided = files.entry(meta, "growth_tolerance", float), files.entry(meta, "undecided", int)
    if tolerance < 0.0 or not 0 <= undecided <= shape[0] * shape[1]:
        raise ValueError(f"growth_tolerance is {tolerance!r} and undecided {undecided!r}")
    subject = files.entry(meta, "subject", dict)
    for name, value, unit in [(subject["kind"], 0.0, ""), *subject["fixed"]]:
        if type(name) is not str or type(value) not in (int, float) or type(unit) is not str:
            raise ValueError(f"subject is {subject!r}")
    return Chart(
        x,
        y,
        files.field(arrays, "stable", np.bool_, shape),
        files.field(arrays, "growth_rate", np.float64, shape) if "growth_rate" in arrays else None,
        files.field(arrays, "first_mode", np.int64, shape) if "first_mode" in arrays else None,
        files.entry(meta, "growth_unit", str),
        subject,
        tolerance,
        files.entry(meta, "criterion", str),
        undecided,
        files.entry(meta, "version", str),
    )


def _axis(meta: dict[str, Any], arrays: dict[str, NDArray[Any]], name: str) -> Axis:
    words = files.entry(meta, name, list)
    values = files.field(arrays, name, np.float64, (None,), finite=True)
    if [type(word) for word in words] != [str] * 3 or not (np.diff(values) > 0.0).all():
        raise ValueError(f"axis {name} is {words!r} with values {values!r}")
    word, symbol, unit = words
    return Axis(word, symbol, unit, values)


def axis_values(name: str, values: Any) -> NDArray[np.float64]:
    """Return the values of an axis given as (low, high, number) or as an increasing array of another length than 3."""
    array = validate.array(name, values, least=-1e12, largest=1e12)
    if array.ndim != 1 or array.size < 2:
        raise ValueError(f"{name} must be (low, high, number) or an increasing array, got {validate.short(values)}")
    if array.size == 3 and isinstance(values, tuple):
        count = validate.integer(f"{name}[2]", values[2], 2)
        _require_bearable(count, f"{name}[2]")
        if not array[0] < array[1]:
            raise ValueError(f"{name} must be (low, high, number) with low < high, got {validate.short(values)}")
        return np.linspace(array[0], array[1], count)
    if not (np.diff(array) > 0.0).all():
        raise ValueError(f"{name} must increase from value to value, got {validate.short(values)}")
    return array


def fill_rows(
    compute: Callable[[NDArray[np.float64]], Sequence[NDArray[Any]]],
    y: NDArray[np.float64],
    columns: int,
    dtypes: Sequence[Any],
    progress: Progress | None,
    rows_at_once: int | None = None,
) -> list[NDArray[Any]]:
    """Compute arrays of ``len(y)`` rows a few rows at a time, so that scratch memory stays small and Ctrl-C works."""
    _require_bearable(y.size * columns, "the number of points")
    results = [np.empty((y.size, columns), dtype=dtype) for dtype in dtypes]
    rows = rows_at_once or max(1, _AT_ONCE // columns)
    for start in range(0, y.size, rows):
        for result, piece in zip(results, compute(y[start : start + rows, None]), strict=True):
            result[start : start + rows] = piece
        if progress is not None:
            progress(min(y.size, start + rows) * columns, y.size * columns)
    return results


def charted(
    x: Axis,
    y: Axis,
    classify: Callable[[NDArray[np.float64]], Sequence[NDArray[Any]]],
    *,
    growth: bool,
    growth_tolerance: float,
    growth_unit: str,
    subject: Callable[[], dict[str, Any]],
    criterion: str = "",
    rows_at_once: int | None = None,
    progress: Progress | None,
) -> Chart:
    """Return the chart of verdicts that ``classify`` computes, a few rows at a time.

    Parameters
    ----------
    classify : callable (values of y, one a row) -> (status, growth rate)
        Status 1 where stable, 0 where not, -1 where undecided.
    subject : callable () -> dict
        What is charted, asked when all is classified.
    growth, growth_tolerance, growth_unit, criterion
        As in `Chart`; whether to keep growth rates.
    """
    kinds = np.int8, np.float64
    status, rate = fill_rows(classify, y.values, x.values.size, kinds, progress, rows_at_once)
    return Chart(
        x,
        y,
        status == 1,
        rate if growth else None,
        None,
        growth_unit,
        subject(),
        growth_tolerance,
        criterion,
        int((status < 0).sum()),
        __version__,
    )


def _require_bearable(points: int, name: str) -> None:
    if points > _MOST_POINTS:
        raise ValueError(f"{name} must be at most {_MOST_POINTS:,}, got {points:,}; take fewer, or a part of the plane")
