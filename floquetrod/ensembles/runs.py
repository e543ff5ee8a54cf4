"""`Runs`: named arrays over named dimensions with units, what an ensemble returns where xarray is not installed."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import extras, sealed_files, validate
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Table
from floquetrod._util.sealed_files import atomic_file
from floquetrod.ensembles.variables import DONE, FAILED, PENDING, Variable

_FORMAT = "floquetrod runs 1"
_PRINTED = 200  # values of one variable that are printed (a choice)


@dataclass(frozen=True, eq=False, repr=False)
class Runs(NoTruthValue, ByContent):
    """Arrays over the axes of an ensemble; ``runs["buckled"]`` is one of them.

    Attributes
    ----------
    variables : dict of Variable
        Results by name: (dims, values, attrs).
    coords : dict of Variable
        The quantities varied, in the same form.
    attrs : dict
        The package's version, the problem as JSON, and the quantities varied.

    Examples
    --------
    >>> size = Variable(("kick",), np.array([1.0, 2.0]), {"units": "rad"})
    >>> runs = Runs({"largest_angle": size}, {"kick": size._replace(attrs={"units": "m/s"})}, {})
    >>> float(runs["largest_angle"].max()), runs.dims, runs.units["kick"]
    (2.0, {'kick': 2}, 'm/s')
    """

    ask = '["buckled"]'

    variables: dict[str, Variable]
    coords: dict[str, Variable]
    attrs: dict[str, Any]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the values of a variable or a coordinate."""
        everything = self.coords | self.variables
        if name not in everything:
            raise KeyError(f"{name!r} is none of {', '.join(everything)}")
        return everything[name].values

    @property
    def dims(self) -> dict[str, int]:
        """Lengths of the dimensions by name."""
        every = [*self.coords.values(), *self.variables.values()]
        return {dim: length for v in every for dim, length in zip(v.dims, v.values.shape, strict=True)}

    @property
    def units(self) -> dict[str, str]:
        """Units by name, "1" for numbers without."""
        return {name: v.attrs.get("units", "1") for name, v in (self.coords | self.variables).items()}

    def __repr__(self) -> str:
        """Return the lengths, and how many runs there are of each status."""
        shape = ", ".join(f"{name}: {length}" for name, length in self.dims.items())
        if "status" not in self.variables:
            return f"<{', '.join(self.variables)} ({shape})>"
        counts = np.bincount(self["status"].ravel(), minlength=3)
        return f"<{counts[DONE]:,} runs done, {counts[FAILED]:,} failed, {counts[PENDING]:,} pending ({shape})>"

    def __str__(self) -> str:
        """Return the values as a table where they are no runs but what was computed from them, and not too many."""
        shape = tuple(self.dims.values())
        if "status" in self.variables or not self.variables or math.prod(shape) > _PRINTED:
            return repr(self)
        every = {
            name: np.broadcast_to(v.values[tuple(slice(None) if dim in v.dims else None for dim in self.dims)], shape)
            for name, v in (self.coords | self.variables).items()
            if v.dims == tuple(dim for dim in self.dims if dim in v.dims)
        }
        columns = [(f"{name} {unit}" if (unit := self.units[name]) != "1" else name, ">11") for name in every]
        values = zip(*(each.ravel().tolist() for each in every.values()), strict=True)
        return str(Table(columns, [[f"{x:.6g}" if isinstance(x, float) else str(x) for x in row] for row in values]))

    def plot(
        self, name: str = "buckled", *, over: Sequence[str] | None = None, confidence: float = 0.95, figure: Any = None
    ) -> Any:
        """Draw the share of runs with a result over the quantities that vary; return the figure.

        Where two quantities are chosen it is over both of them.  Where runs are drawn it is also over each quantity,
        averaged over all others, as `floquetrod.ensembles.probability` does, with its interval; values that were drawn
        are put into bins.  Over one chosen quantity each run is a point, and over two quantities that are drawn, too.

        Parameters
        ----------
        name : str
            A result that is true or false in each run, such as "buckled".
        over : (str, str), optional
            Two quantities that vary: every run is a point over both; by default the two that are drawn, if two are.
        confidence : float
            Probability of the intervals, between 0 and 1.
        figure : matplotlib.figure.Figure or SubFigure, optional
            Figure to draw into; by default a new one.

        Returns
        -------
        matplotlib.figure.Figure or SubFigure
            The figure drawn into.

        Raises
        ------
        ValueError
            Where no runs are drawn and none or more than two quantities are chosen, for a result that is neither true
            nor false, and for an ``over`` that is not two quantities that vary.
        """
        from floquetrod.ensembles.pictures import draw

        return draw(self, name, confidence, over=over, figure=figure)

    def to_csv(self, path: str | Path) -> Path:
        """Write a table with one row for each run: its varied quantities and its results, units in the headings.

        Words stand for the status and the outcome, nothing for results of unfinished runs.  What has dimensions
        of its own, such as frames, is left out.

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
        dims = self.variables["status"].dims if "status" in self.variables else tuple(self.dims)
        shape = tuple(self.dims[dim] for dim in dims)
        columns = {}
        for name, v in (self.coords | self.variables).items():
            if v.dims == tuple(dim for dim in dims if dim in v.dims):
                at = tuple(slice(None) if dim in v.dims else None for dim in dims)
                heading = f"{name} ({unit})" if (unit := self.units[name]) != "1" else name
                columns[heading] = self._cells(name, np.broadcast_to(v.values[at], shape).ravel())
        text = io.StringIO(newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
        path = validate.path("path", path)
        with atomic_file(path) as file:
            file.write(text.getvalue().encode())
        return path

    def _cells(self, name: str, values: NDArray[Any]) -> list[Any]:
        """Return the values of a variable in each run for a table: words where its numbers stand for some."""
        cells: list[Any] = values.tolist()
        attrs = self.variables[name].attrs if name in self.variables else {}
        if "flag_meanings" in attrs:
            words = dict(zip(np.ravel(attrs["flag_values"]).tolist(), attrs["flag_meanings"].split(), strict=True))
            cells = [words.get(value, str(value)).replace("_", " ") for value in cells]
        if name in self.variables and name != "status" and values.dtype.kind in "bi" and "status" in self.variables:
            done = self["status"].ravel() == DONE
            cells = [cell if is_done else "" for cell, is_done in zip(cells, done.tolist(), strict=True)]
        return cells

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset (needs xarray, an extra: pip install floquetrod[ensemble]).

        Returns
        -------
        xarray.Dataset
            Results and quantities by name.

        Raises
        ------
        ImportError
            Without xarray.
        """
        xarray = extras.xarray("ensemble")
        variables, coords = dict(self.variables), dict(self.coords)
        return xarray.Dataset(variables, coords, self.attrs)

    @classmethod
    def from_xarray(cls, dataset: Any) -> Runs:
        """Return the content of an xarray.Dataset, loaded into memory.

        Returns
        -------
        Runs
            With all results and frames.
        """

        def content(of: Any) -> dict[str, Variable]:
            every = of.items()
            return {str(n): Variable(tuple(map(str, v.dims)), np.asarray(v.values), dict(v.attrs)) for n, v in every}

        return cls(content(dataset.data_vars), content(dataset.coords), dict(dataset.attrs))

    @classmethod
    def of_each_run(cls, dataset: Any) -> Runs:
        """Return what an xarray.Dataset has of each run, loaded into memory; frames stay where they are.

        Returns
        -------
        Runs
            Without frames.
        """
        dims = set(dataset["status"].dims)
        return cls.from_xarray(dataset[[name for name, v in dataset.data_vars.items() if set(v.dims) <= dims]])

    def save(self, path: str | Path) -> Path:
        """Write everything to an npz file; an older file of that name is kept until the new one is complete.

        Returns
        -------
        Path
            Of the file written.

        Raises
        ------
        OSError
            Where the file cannot be written.
        """
        kinds = {"variables": self.variables, "coords": self.coords}
        meta = {
            "format": _FORMAT,
            "attrs": self.attrs,
            **{kind: {name: [v.dims, v.attrs] for name, v in of.items()} for kind, of in kinds.items()},
        }
        arrays = {f"{kind}.{name}": v.values for kind, of in kinds.items() for name, v in of.items()}
        return sealed_files.write_npz(path, meta, arrays, compress=True)

    @classmethod
    def load(cls, path: str | Path) -> Runs:
        """Read runs that `save` wrote.

        Returns
        -------
        Runs
            Equal to the runs saved.

        Raises
        ------
        ValueError
            For a file that is damaged, if only in one bit, or foreign.
        """
        if validate.path("path", path).is_dir():
            raise ValueError(
                f"{path} is a folder; Runs.load reads .npz files, xarray.open_zarr the stores that end in .zarr"
            )
        return sealed_files.read_npz(path, _FORMAT, "an ensemble", cls._read)

    @classmethod
    def _read(cls, meta: dict[str, Any], arrays: sealed_files.Arrays) -> Runs:
        """Return what a file holds; ValueError where it is not as `save` writes it."""
        lengths: dict[str, int] = {}
        kinds = {kind: sealed_files.entry(meta, kind, dict) for kind in ("coords", "variables")}
        for kind, of in kinds.items():  # before anything is read: shapes cost no memory
            for name, (dims, attrs) in of.items():
                shape = sealed_files.require_shape(arrays, f"{kind}.{name}", tuple(lengths.get(dim) for dim in dims))
                lengths |= dict(zip(map(str, dims), shape, strict=True))
                if not isinstance(attrs, dict):
                    raise ValueError(f"attributes of {name} are {attrs!r}")
        by_kind = {
            kind: {
                name: Variable(tuple(map(str, dims)), arrays[f"{kind}.{name}"], attrs)
                for name, (dims, attrs) in of.items()
            }
            for kind, of in kinds.items()
        }
        return cls(by_kind["variables"], by_kind["coords"], sealed_files.entry(meta, "attrs", dict))


def require_runs(name: str, value: Any) -> Runs:
    """Return an argument that is `Runs` or an xarray.Dataset as `Runs`; TypeError for anything else."""
    if isinstance(value, Runs):
        return value
    if not all(hasattr(value, part) for part in ("data_vars", "coords", "attrs")):
        raise TypeError(f"{name} must be what fr.ensemble returns, got {validate.short(value)}")
    return Runs.from_xarray(value)
