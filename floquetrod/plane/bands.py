"""Unstable bands of a plane: polygons between boundary curves, whatever they were found by."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, SupportsIndex, overload

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import extras, sealed_files, validate
from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod.plane.plane_axes import Axis


class MergedTongue(NamedTuple):
    """One of the resonance tongues that merge in a band.

    Attributes
    ----------
    mode : int or None
        Mode that grows; None where it is not known.
    partner : int or None
        The other mode of a combination resonance, negative of a difference; None where one mode grows alone.
    tongue : int or None
        Order of the resonance; None where it is not known.
    place : tuple of float
        (x, y) where it begins: its tip or, where the plane ends before it, the middle of its side on that end.
    """

    mode: int | None
    partner: int | None
    tongue: int | None
    place: tuple[float, float]

    @property
    def name(self) -> str:
        """Return its name, in the form of `Band.name`."""
        return _name(self.mode, self.partner, self.tongue)


def beginning(band: Band, tongue: MergedTongue) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ranges of x and y over which a tongue begins: of its tip, or of its side where the plane ends."""
    ranges = [(value, value) for value in tongue.place]
    for along, across in ((0, 1), (1, 0)):
        line, level = (band.x, band.y)[along], (band.x, band.y)[across]
        # The sides of the polygon that lie at the level of the place, and of these the ones that are one with it.
        flat = (level == tongue.place[across]) & (np.roll(level, -1) == tongue.place[across])
        sides = np.sort(np.column_stack([line, np.roll(line, -1)])[flat], axis=1)
        low = high = tongue.place[along]
        while (touching := (sides[:, 0] <= high) & (sides[:, 1] >= low)).any():
            low, high = min(low, float(sides[touching, 0].min())), max(high, float(sides[touching, 1].max()))
            sides = sides[~touching]
        if low < tongue.place[along] < high:
            ranges[along] = low, high
    return ranges[0], ranges[1]


def _name(mode: int | None, partner: int | None, tongue: int | None) -> str:
    parts = [] if mode is None else [f"mode {mode}"]
    if partner is not None:
        parts = [f"modes {mode} {'+' if partner > 0 else '-'} {abs(partner)}"]
    return ", ".join(parts if tongue is None else [*parts, f"tongue {tongue}"])


@dataclass(frozen=True, eq=False, repr=False)
class Band(ByContent):
    """One unstable region of a plane.

    Attributes
    ----------
    x : ndarray (n,)
        Vertices of the polygon about it, in order, the first not repeated, in the unit of the axis.  Each lies on a
        boundary or on the edge of the plane.  A stable hole is joined to the outside by a seam, passed both ways.
    y : ndarray (n,)
        The vertices along the other axis.
    mode : int or None
        Mode that grows; None where there is none, or where it is not known.
    tongue : int or None
        Its resonance tongue, which is the order of a resonance; None likewise.
    largest_growth : float
        Largest growth rate within it, in the growth unit of the `Bands`; NaN where it is not known.
    place : tuple of float
        (x, y) where that is.
    partner : int or None
        The other mode of a combination resonance, negative of a difference; None where one mode grows alone.
    merged : tuple of MergedTongue
        The resonance tongues that merge in it, each named by what grows fastest half-way to where it meets another;
        empty where it is of one tongue, and for bands between exact curves, which may overlap instead.
    """

    x: Floats
    y: Floats
    mode: int | None
    tongue: int | None
    largest_growth: float
    place: tuple[float, float]
    partner: int | None = None
    merged: tuple[MergedTongue, ...] = ()

    @property
    def name(self) -> str:
        """Return, say, "mode 7, tongue 1" or "modes 1 + 2, tongue 1"; "" where neither is known."""
        return _name(self.mode, self.partner, self.tongue)

    def __repr__(self) -> str:
        """Return name, size and fastest growth."""
        fastest = f"largest growth {self.largest_growth:.6g} at ({self.place[0]:.6g}, {self.place[1]:.6g})"
        merged = f"; merged: {'; '.join(tongue.name for tongue in self.merged)}" if self.merged else ""
        return f"<{self.name or 'band'}: {self.x.size} vertices, {fastest}{merged}>"


@dataclass(frozen=True, eq=False, repr=False)
class Bands(NoTruthValue, ByContent):
    """The unstable bands of a chart.

    Attributes
    ----------
    x : Axis
        The horizontal axis of the plane; its values are its ends, (low, high).
    y : Axis
        The vertical axis likewise.
    bands : tuple of Band
        They may overlap; those in which nothing grows faster than the tolerance are left out.
    growth_unit : str
        As in `Chart`.
    growth_tolerance : float
        Growth up to which motion counts as stable; a band's boundary is where growth equals it.
    tongues_left_out : int
        Resonance tongues left out, in which nothing grows faster than the tolerance, or, where that is 0, than
        1e-6 1/s, for equations 1e-9 per tau.
    accuracy : float
        Distance up to which edges of the polygons may depart from the boundary between two vertices, as a fraction of
        each axis.
    resolution : tuple of float
        Bands, and stable gaps in and between them, narrower than this along x and y may have been missed; (0, 0) where
        tongues are found by counts and not among points of the plane (the page `theory/maps` says which part of that is
        proved, and which observed).

    Iterating gives the bands, and so do an index and a slice, as of the tuple.
    """

    ask = "len(...) or .bands"

    x: Axis
    y: Axis
    bands: tuple[Band, ...]
    growth_unit: str
    growth_tolerance: float
    tongues_left_out: int
    accuracy: float
    resolution: tuple[float, float]

    def __iter__(self) -> Iterator[Band]:
        """Iterate over the bands."""
        return iter(self.bands)

    @overload
    def __getitem__(self, index: SupportsIndex) -> Band: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Band, ...]: ...

    def __getitem__(self, index: SupportsIndex | slice) -> Band | tuple[Band, ...]:
        """Return the band at an index, or the bands of a slice."""
        return self.bands[index]

    def __len__(self) -> int:
        """Return the number of bands."""
        return len(self.bands)

    def __repr__(self) -> str:
        """Name the axes, and give the numbers of bands and of tongues left out."""
        return f"<{self.y.name} over {self.x.name}; {self.caption}>"

    @property
    def caption(self) -> str:
        """The number of bands, their growth, and the number of tongues left out."""
        count = f"{len(self.bands):,} unstable band{'s' * (len(self.bands) != 1)}"
        if self.growth_tolerance:
            count += f" of growth above {self.growth_tolerance:g} {self.growth_unit}"
        return "; ".join(filter(None, [count, self.note]))

    @property
    def note(self) -> str:
        """The bands that were left out, "" without any."""
        parts = []
        if self.tongues_left_out:
            kind = "slower" if self.growth_tolerance else "negligible"
            parts.append(f"{self.tongues_left_out:,} {kind} tongue{'s' * (self.tongues_left_out > 1)} left out")
        if any(self.resolution):
            x, y = (
                units.with_unit(size, axis.unit, 2)
                for size, axis in zip(self.resolution, (self.x, self.y), strict=True)
            )
            parts.append(f"bands, and gaps in them, narrower than {x} by {y} may have been missed")
        return "; ".join(parts)

    def scaled(self, x: Axis, y: Axis, factors: tuple[float, float]) -> Bands:
        """Return the same bands over axes in other units, coordinates multiplied by the factors."""
        fx, fy = factors

        def moved(found: Any) -> tuple[float, float]:
            return found.place[0] * fx, found.place[1] * fy

        bands = tuple(
            replace(
                band,
                x=band.x * fx,
                y=band.y * fy,
                place=moved(band),
                merged=tuple(tongue._replace(place=moved(tongue)) for tongue in band.merged),
            )
            for band in self
        )
        resolution = self.resolution[0] * fx, self.resolution[1] * fy
        return replace(self, x=x.ends, y=y.ends, bands=bands, resolution=resolution)

    def to_csv(self, path: str | Path) -> Path:
        """Write a table of all vertices to a file, one per line: band, mode, partner, tongue, growth, x, y.

        Units stand in the first line.  An older file of that name is kept until the new one is complete.

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
        path = validate.path("path", path)
        text = io.StringIO(newline="")
        table = csv.writer(text, lineterminator="\n")
        places = [f"{axis.name} [{axis.unit}]" if axis.unit else axis.name for axis in (self.x, self.y)]
        table.writerow(["band", "mode", "partner", "tongue", f"largest growth [{self.growth_unit}]", *places])
        for number, band in enumerate(self, 1):
            names = ["" if name is None else name for name in (band.mode, band.partner, band.tongue)]
            for x, y in zip(band.x.tolist(), band.y.tolist(), strict=True):
                table.writerow([number, *names, band.largest_growth, x, y])
        with sealed_files.atomic_file(path) as file:
            file.write(text.getvalue().encode())
        return path

    def to_xarray(self) -> Any:
        """Return an xarray.Dataset of bands and vertices (needs xarray: pip install floquetrod[xarray]).

        The dimensions are "band" and "vertex", to which ``vertex_band`` gives the band, counted from 0; a mode or
        tongue that is not known is -1, and a partner 0.

        Returns
        -------
        xarray.Dataset
            Of bands and vertices.

        Raises
        ------
        ImportError
            Without xarray.
        """
        xarray = extras.xarray()
        arrays = self.as_arrays()
        x, y = (axis.name for axis in (self.x, self.y))
        data = {
            "mode": ("band", arrays["mode"]),
            "partner": ("band", arrays["partner"]),
            "tongue": ("band", arrays["tongue"]),
            "largest_growth": ("band", arrays["growth"], {"units": self.growth_unit}),
            "vertex_band": ("vertex", np.repeat(np.arange(len(self)), arrays["size"])),
            x: ("vertex", arrays["x"], {"units": self.x.unit}),
            y: ("vertex", arrays["y"], {"units": self.y.unit}),
        }
        names = ("growth_tolerance", "tongues_left_out", "accuracy", "resolution")
        return xarray.Dataset(data, attrs={name: getattr(self, name) for name in names})

    def _repr_png_(self) -> bytes:
        """Return the picture that a notebook shows."""
        from floquetrod.plotting.chart_plot import picture

        return picture(self)

    def plot(self, ax: Any = None) -> Any:
        """Draw the bands as shapes, orange, thin ones as lines, named where there is room.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.shapes import draw_bands

        return draw_bands(self, ax)

    def as_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the bands as arrays: one entry a band, and ``x``, ``y`` with all vertices after each other.

        Those that begin with ``merged_`` have an entry for each tongue that merges in a band.
        """
        nothing = [np.empty(0)]
        tongues = [tongue for band in self for tongue in band.merged]
        return {
            "merged_number": np.array([len(band.merged) for band in self], dtype=np.int64),
            "merged_names": np.array(
                [
                    (-1 if mode is None else mode, partner or 0, -1 if tongue is None else tongue)
                    for mode, partner, tongue, _ in tongues
                ],
                dtype=np.int64,
            ).reshape(-1, 3),
            "merged_place": np.array([tongue.place for tongue in tongues], dtype=np.float64).reshape(-1, 2),
            "size": np.array([band.x.size for band in self], dtype=np.int64),
            "mode": np.array([-1 if band.mode is None else band.mode for band in self], dtype=np.int64),
            "partner": np.array([band.partner or 0 for band in self], dtype=np.int64),
            "tongue": np.array([-1 if band.tongue is None else band.tongue for band in self], dtype=np.int64),
            "growth": np.array([band.largest_growth for band in self], dtype=np.float64),
            "place": np.array([band.place for band in self], dtype=np.float64).reshape(-1, 2),
            "x": np.concatenate(nothing + [band.x for band in self]),
            "y": np.concatenate(nothing + [band.y for band in self]),
        }

    @staticmethod
    def bands_of(arrays: Mapping[str, NDArray[Any]]) -> tuple[Band, ...]:
        """Return the bands that `as_arrays` describes; ValueError where the arrays do not fit each other."""
        each = sealed_files.require_shape(arrays, "size", (None,))
        for name in ("mode", "partner", "tongue", "growth"):
            sealed_files.require_shape(arrays, name, each)
        size = sealed_files.field(arrays, "size", np.int64, each)
        mode, partner, tongue = (
            sealed_files.field(arrays, name, np.int64, each) for name in ("mode", "partner", "tongue")
        )
        growth = sealed_files.field(arrays, "growth", np.float64, each)
        place = sealed_files.field(arrays, "place", np.float64, (size.size, 2))
        if (size < 3).any():
            raise ValueError("a band has fewer than three vertices")
        total = (int(size.sum()),)
        x, y = (sealed_files.field(arrays, name, np.float64, total, finite=True) for name in ("x", "y"))
        at = np.concatenate([[0], np.cumsum(size)]).tolist()
        merged = _merged(arrays, size.size)
        return tuple(
            Band(
                x[at[i] : at[i + 1]],
                y[at[i] : at[i + 1]],
                None if mode[i] < 0 else int(mode[i]),
                None if tongue[i] < 0 else int(tongue[i]),
                float(growth[i]),
                (float(place[i, 0]), float(place[i, 1])),
                int(partner[i]) or None,
                merged[i],
            )
            for i in range(size.size)
        )


def _merged(arrays: Mapping[str, NDArray[Any]], bands: int) -> list[tuple[MergedTongue, ...]]:
    """Return the merged tongues of each band of a file, none for files that do not hold them."""
    if "merged_number" not in arrays:
        return [()] * bands
    number = sealed_files.field(arrays, "merged_number", np.int64, (bands,))
    if (number < 0).any():
        raise ValueError("a band has a negative number of merged tongues")
    names = sealed_files.field(arrays, "merged_names", np.int64, (int(number.sum()), 3)).tolist()
    place = sealed_files.field(arrays, "merged_place", np.float64, (len(names), 2), finite=True).tolist()
    tongues = [
        MergedTongue(None if mode < 0 else mode, partner or None, None if tongue < 0 else tongue, (x, y))
        for (mode, partner, tongue), (x, y) in zip(names, place, strict=True)
    ]
    ends = np.cumsum(number).tolist()
    return [tuple(tongues[end - count : end]) for end, count in zip(ends, number.tolist(), strict=True)]
