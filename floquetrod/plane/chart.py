"""Stability over a plane: one frozen result for charts of an equation and maps of a rod, saved and loaded whole."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import extras, sealed_files, validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.progress import Progress
from floquetrod.plane.bands import Bands
from floquetrod.plane.plane_axes import Axis

_FORMAT = "floquetrod chart 3"
_OPTIONAL = {
    **dict.fromkeys(("growth_rate", "large_motion", "response"), np.float64),
    "first_mode": np.int64,
    "cells": np.int8,
}
"""Arrays that a chart may have, by the types of their elements."""
_ENTRIES = {
    "growth_unit": str,
    "subject": dict,
    "growth_tolerance": float,
    "criterion": str,
    "undecided": int,
    "version": str,
}
"""What a file holds beside the axes, ``stable`` and the bands: arrays of some charts, and entries of all."""

_CRITICAL = "critical force"
"""Name of the rod's critical force among what is fixed."""

_BANDS = "band_"
"""What names of arrays of bands begin with in a file."""

CELLS = {"proved stable": 1, "proved unstable": 0, "with a boundary": 2, "undecided": -1}
"""What the values of `Chart.cells` mean: the codes of every status, and 2 where both are proved of parts."""

ACCURACY = 1.0 / 3000.0
"""Accuracy of bands as a fraction of each axis: half a pixel of a picture 1,500 pixels wide (a choice)."""


class BandSource(Protocol):
    """What finds the bands of a chart, in the units in which the chart was computed; can be pickled.

    ``prompt`` says whether they take about as long as the chart itself, so that they may be drawn unasked.
    """

    @property
    def prompt(self) -> bool:
        """Whether the bands are found about as fast as the chart."""

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands with an accuracy as a fraction of each axis."""


@dataclass(frozen=True, eq=False, repr=False)
class Chart(units.InUnits, NoTruthValue, ByContent):
    """Verdicts over a plane.

    Attributes
    ----------
    x : Axis
        Columns.
    y : Axis
        Rows.
    stable : ndarray (ny, nx) of bool
        Verdict, growth tolerance included.
    growth_rate : ndarray (ny, nx) or None
        Growth rate of the fastest solution or mode, in ``growth_unit``; None unless asked for.
    first_mode : ndarray (ny, nx) of int or None
        Mode of a rod that grows fastest, 0 where none grows; None unless growth was asked for, and for equations.
    growth_unit : str
        "per tau", "per z" (of equations in a and q), "per unit time" (of systems) or "1/s".
    subject : dict
        "kind" is the subject of the chart, "fixed" lists [name, value, unit] of the fixed quantities; a rod's data
        sheet is under "rod".
    growth_tolerance : float
        Growth, in ``growth_unit``, up to which a point counts as stable.
    criterion : str
        Meaning of "stable" where it is not the equation's own stability; "" where it is.
    undecided : int
        Points that no method could decide; they count as not stable.
    version : str
        Version of the package that made it.
    source : callable or None
        Source of the bands for `find_bands`; None where it is not known, as in a chart read from a file.
    cells : ndarray (ny, nx) of int8 or None
        Proved status of the rectangle about each point, up to the middle between it and its neighbours: 1 stable
        everywhere, 0 unstable everywhere, 2 both occur, -1 undecided.  None unless requested.
    large_motion : ndarray (ny, nx) or None
        Where the rod at rest is stable: about the largest angle in rad of a large motion that it carries, too, 0 where
        a search finds none on the wall; NaN elsewhere.  None unless asked for.
    response : ndarray (ny, nx) or None
        Of a rod with a natural shape: its largest deflection in m where it is stable, NaN elsewhere.  None unless
        asked for.
    """

    ask = ".stable, an array"

    x: Axis
    y: Axis
    stable: Bools
    growth_rate: Floats | None
    first_mode: Ints | None
    growth_unit: str
    subject: dict[str, Any]
    growth_tolerance: float
    criterion: str
    undecided: int
    version: str
    source: BandSource | None = field(default=None, compare=False)
    cells: NDArray[np.int8] | None = None
    large_motion: Floats | None = None
    response: Floats | None = None

    @cached_property
    def bands(self) -> Bands:
        """The unstable bands between their boundaries, found when first asked for, by `find_bands`."""
        return self.find_bands()

    def find_bands(self, accuracy: float = ACCURACY, *, progress: Progress | None = None) -> Bands:
        """Return the unstable bands as polygons between the boundaries, not made of the chart's points.

        `bands` holds them for the default accuracy, computed once.

        Parameters
        ----------
        accuracy : float
            How far edges may depart from the boundary between two vertices, as a fraction of each axis, 1e-6 to 0.1.
        progress : callable, optional
            Called with the work done and the work to do.

        Returns
        -------
        Bands
            In the units of the chart.

        Raises
        ------
        ValueError
            Where the chart has no source: one from a file, saved before its bands were computed.
        """
        accuracy = validate.within("accuracy", accuracy, 1e-6, 0.1, "it is a share of each axis")
        validate.progress(progress)
        if accuracy == ACCURACY and "bands" in self.__dict__:
            return self.bands
        if self.source is None:
            raise ValueError(
                "bands must be computed before a chart is saved: a file holds those of chart.bands, and this one none"
            )
        bands = self.source(accuracy, progress)
        if accuracy == ACCURACY:
            self._keep(bands)
        return bands

    @property
    def heading(self) -> str:
        """Subject of the chart, and the values of the fixed quantities."""
        fixed = ", ".join(f"{name} {units.with_unit(value, unit)}" for name, value, unit in self.subject["fixed"])
        return ", ".join(filter(None, [self.subject["kind"], fixed]))

    @property
    def caption(self) -> str:
        """One sentence that describes the chart."""
        share = f"{100.0 * self.stable.mean():.1f} % of {self.stable.size} points stable"
        tolerance = f"; growth up to {self.growth_tolerance:g} {self.growth_unit} counts as stable"
        text = f"{self.heading}: {share}" + (tolerance if self.growth_tolerance else "")
        text += f"; {self.undecided} undecided" if self.undecided else ""
        if self.cells is not None:
            counts = [int((self.cells == value).sum()) for value in CELLS.values()]
            text += "; cells: " + ", ".join(f"{n} {name}" for name, n in zip(CELLS, counts, strict=True) if n)
        if self.large_motion is not None:
            text += f"; a large motion found, too, at {int(self.carries_large_motion.sum())} stable points"
        if self.response is not None and np.isfinite(self.response).any():
            least, most = (1e3 * float(limit(self.response)) for limit in (np.nanmin, np.nanmax))
            text += f"; the shape moves it by {least:.3g} to {most:.3g} mm where it is stable"
        return text + (f"; {self.criterion}" if self.criterion else "")

    @property
    def carries_large_motion(self) -> Bools:
        """Where `large_motion` was found (ny, nx)."""
        if self.large_motion is None:
            return np.zeros_like(self.stable)
        return np.asarray(np.nan_to_num(self.large_motion) > 0.0)

    def in_units(self, **names: str) -> Chart:
        """Return the same chart in other units, for axes, caption and drawings.

        Each quantity goes by the first word of its name: ``chart.in_units(mean="Fcr", frequency="Hz")``.  "Fcr" is the
        critical force of the rod.

        Returns
        -------
        Chart
            The same points and verdicts.

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
        x, y = axis(self.x), axis(self.y)
        factors = tuple(sizes.get(old.name, ("", 1.0))[1] for old in (self.x, self.y))
        source = None if self.source is None else _Scaled(self.source, x, y, (factors[0], factors[1]))
        chart = replace(self, x=x, y=y, subject=self.subject | {"fixed": fixed}, source=source)
        if "bands" in self.__dict__:
            chart._keep(self.bands.scaled(x, y, (factors[0], factors[1])))
        return chart

    def _keep(self, bands: Bands) -> None:
        """Take bands for those that `bands` would find."""
        self.__dict__["bands"] = bands

    def __repr__(self) -> str:
        """Return the caption, axes included."""
        return f"<{self.y.name} over {self.x.name}; {self.caption}>"

    def _repr_png_(self) -> bytes:
        """Return the picture that a notebook shows."""
        from floquetrod.plotting.chart_plot import picture

        return picture(self)

    def plot(self, ax: Any = None, *, bands: bool | None = None) -> Any:
        """Draw the chart, orange where unstable (darker the faster, if growth is known).

        Axes are in the units in which the ranges of the chart were given, such as ``frequency=("10Hz", "40Hz", 40)``.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Axes to draw into; by default in a new figure.
        bands : bool, optional
            Whether to draw `bands`, shapes named by mode and tongue where there is room, or the chart's points as
            pixels; by default bands, where they have been found or are found about as fast as the chart, and no `cells`
            have been proved.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        ValueError
            With ``bands=True`` for a chart that has neither bands nor a source, see `find_bands`.
        """
        prompt = self.source is not None and self.source.prompt
        known = self.cells is None and (prompt or "bands" in self.__dict__)
        if known if bands is None else validate.flag("bands", bands):
            from floquetrod.plotting.shapes import draw_banded_chart

            _ = self.bands  # kept with the chart, whatever the units of its picture
            return draw_banded_chart(self._in_given_units(), ax)
        from floquetrod.plotting.chart_plot import draw_chart

        return draw_chart(self._in_given_units(), ax)

    def _in_given_units(self) -> Chart:
        """Return the chart in the units in which its ranges were given."""
        present = [(axis.name, axis.unit) for axis in (self.x, self.y)]
        present += [(name, unit) for name, _, unit in self.subject["fixed"]]
        given = self.given_units._asdict()
        names = {name.partition(" ")[0]: given.get(units.kind_of(unit) or "", "") for name, unit in present}
        names = {name: unit for name, unit in names.items() if unit}
        return self.in_units(**names) if names else self

    def save(self, path: str | Path) -> Path:
        """Write everything to an npz file, bands if they have been computed.

        An older file of that name is kept until the new one is complete.

        Returns
        -------
        Path
            Of the file written.

        Raises
        ------
        TypeError, ValueError
            For a path that is no text or path, and for the name of a table or a picture.
        OSError
            Where the file cannot be written.
        """
        path = validate.path("path", path)
        if path.suffix.lower() in (".csv", ".png", ".pdf", ".svg"):
            remedy = "bands.to_csv(path)" if path.suffix.lower() == ".csv" else "plot().figure.savefig(path)"
            raise ValueError(f"path must be the name of an npz file, got {path.name!r}; {remedy} writes that")
        arrays = {"x": self.x.values, "y": self.y.values} | self._over_points()
        axes = {name: [axis.name, axis.symbol, axis.unit] for name, axis in (("x", self.x), ("y", self.y))}
        meta: dict[str, Any] = {"format": _FORMAT} | axes | {name: getattr(self, name) for name in _ENTRIES}
        if "bands" in self.__dict__:
            arrays |= {f"{_BANDS}{name}": values for name, values in self.bands.as_arrays().items()}
            meta["bands"] = {name: getattr(self.bands, name) for name in ("tongues_left_out", "accuracy", "resolution")}
        return sealed_files.write_npz(path, meta, arrays, compress=True)

    @classmethod
    def load(cls, path: str | Path) -> Chart:
        """Read a chart that `save` wrote.

        Returns
        -------
        Chart
            Equal to the chart saved.

        Raises
        ------
        TypeError, ValueError
            For a file that is damaged, if only in one bit, or foreign.
        """
        return sealed_files.read_npz(path, _FORMAT, "a chart", _chart)

    def _over_points(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of values at the points, by name."""
        return {name: found for name in ("stable", *_OPTIONAL) if (found := getattr(self, name)) is not None}

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset (needs xarray, an extra: pip install floquetrod[xarray]).

        Returns
        -------
        xarray.Dataset
            Over both axes.

        Raises
        ------
        ImportError
            Without xarray.
        """
        xarray = extras.xarray()
        coords = {axis.name: (axis.name, axis.values, {"units": axis.unit}) for axis in (self.x, self.y)}
        data = {name: ((self.y.name, self.x.name), values) for name, values in self._over_points().items()}
        attributes = {n: getattr(self, n) for n in ("growth_unit", "growth_tolerance", "criterion", "version")}
        return xarray.Dataset(data, coords, attributes)


def _chart(meta: dict[str, Any], arrays: sealed_files.Arrays) -> Chart:
    """Return the chart that a file describes; ValueError or KeyError where it is not as `Chart.save` writes it."""
    shape = sealed_files.require_shape(arrays, "y", (None,)) + sealed_files.require_shape(arrays, "x", (None,))
    for name in ("stable", *(name for name in _OPTIONAL if name in arrays)):
        sealed_files.require_shape(arrays, name, shape)
    x, y = (_axis(meta, arrays, name) for name in "xy")
    entries: dict[str, Any] = {name: sealed_files.entry(meta, name, kind) for name, kind in _ENTRIES.items()}
    tolerance, undecided, subject = (entries[name] for name in ("growth_tolerance", "undecided", "subject"))
    if tolerance < 0.0 or not 0 <= undecided <= shape[0] * shape[1]:
        raise ValueError(f"growth_tolerance is {tolerance!r} and undecided {undecided!r}")
    for name, value, unit in [(subject["kind"], 0.0, subject.get("name", "")), *subject["fixed"]]:
        if type(name) is not str or type(value) not in (int, float) or type(unit) is not str:
            raise ValueError(f"subject is {subject!r}")
    some: dict[str, Any] = {
        name: sealed_files.field(arrays, name, kind, shape) if name in arrays else None
        for name, kind in _OPTIONAL.items()
    }
    if some["cells"] is not None and not np.isin(some["cells"], list(CELLS.values())).all():
        raise ValueError(f"cells must be {', '.join(map(str, CELLS.values()))}")
    chart = Chart(x, y, sealed_files.field(arrays, "stable", np.bool_, shape), **some, **entries)
    if "bands" in meta:
        chart._keep(_bands(chart, sealed_files.entry(meta, "bands", dict), arrays))
    return chart


def _bands(chart: Chart, meta: dict[str, Any], arrays: sealed_files.Arrays) -> Bands:
    """Return the bands that a file of a chart describes."""
    resolution = sealed_files.entry(meta, "resolution", list)
    if [type(size) for size in resolution] != [float, float]:
        raise ValueError(f"resolution of bands is {resolution!r}")
    return Bands(
        chart.x.ends,
        chart.y.ends,
        Bands.bands_of(arrays.under(_BANDS)),
        chart.growth_unit,
        chart.growth_tolerance,
        sealed_files.entry(
            meta, "tongues_left_out" if "tongues_left_out" in meta else "hairlines", int
        ),  # its earlier name
        sealed_files.entry(meta, "accuracy", float),
        (resolution[0], resolution[1]),
    )


@dataclass(frozen=True)
class _Scaled:
    """A source of bands in other units."""

    source: BandSource
    x: Axis
    y: Axis
    factors: tuple[float, float]

    @property
    def prompt(self) -> bool:
        """Whether the bands are found about as fast as the chart."""
        return self.source.prompt

    def __call__(self, accuracy: float, progress: Progress | None) -> Bands:
        """Return the bands in these units."""
        return self.source(accuracy, progress).scaled(self.x, self.y, self.factors)


def _axis(meta: dict[str, Any], arrays: sealed_files.Arrays, name: str) -> Axis:
    words = sealed_files.entry(meta, name, list)
    values = sealed_files.field(arrays, name, np.float64, (None,), finite=True)
    if [type(word) for word in words] != [str] * 3 or not (np.diff(values) > 0.0).all():
        raise ValueError(f"axis {name} is {words!r} with values {values!r}")
    word, symbol, unit = words
    return Axis(word, symbol, unit, values)
