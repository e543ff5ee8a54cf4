"""Branches of orbits in npz files: meshes and states of all orbits, one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import sealed_files, validate
from floquetrod._util.arrays import Floats
from floquetrod.equations import NonlinearSystem
from floquetrod.orbits.arclength import Measure
from floquetrod.orbits.collocation import Collocation, Point, Step
from floquetrod.orbits.finding import Compared, as_orbit
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.orbit_multipliers import Segments
from floquetrod.orbits.special_points import SpecialPoint

_FORMAT = "floquetrod branch 1"
_OTHER = 1e-6  # of the states, by which an orbit may miss the equations of the system it is said to be of


def save(branch: Any, path: str | Path) -> Path:
    """Write a `floquetrod.Branch`."""
    points = branch.special_points
    orbits = [*branch.orbits, *(point.orbit for point in points)]
    first = orbits[0].collocation
    meta: dict[str, Any] = {
        "format": _FORMAT,
        "parameter": branch.parameter,
        "over": list(branch.over),
        "ends": list(branch.ends),
        "tolerance": branch.tolerance,
        "notes": list(branch.notes),
        "turns": first.turns,
        "winding": list(first.winding),
        "parameters": dict(branch.system.parameters),
        "kinds": [point.kind for point in points],
        "after": [point.after for point in points],
        "counts": [point.count for point in points],
        "orbits": len(branch.orbits),
        "equations": orbits[0].states.shape[1],
    }
    return sealed_files.write_npz(path, meta, _arrays(branch.parameter, orbits) | _of_points(points), compress=True)


def _arrays(parameter: str, orbits: list[PeriodicOrbit]) -> dict[str, NDArray[Any]]:
    """Return the numbers of orbits."""
    each: dict[str, list[Any]] = {
        "values": [orbit.system.parameters[parameter] for orbit in orbits],
        "periods": [orbit.period for orbit in orbits],
        "period_errors": [orbit.period_error for orbit in orbits],
        "errors": [orbit.error for orbit in orbits],
        "traces": [orbit.segments.trace for orbit in orbits],
        "trace_errors": [orbit.segments.trace_error for orbit in orbits],
    }
    counts = {
        "intervals": [len(orbit.point.nodes) for orbit in orbits],
        "degrees": [orbit.collocation.degree for orbit in orbits],
        "steps": [orbit.steps for orbit in orbits],
    }
    parts = {
        "meshes": [orbit.collocation.mesh for orbit in orbits],
        "nodes": [orbit.point.nodes for orbit in orbits],
        "stages": [orbit.point.stages for orbit in orbits],
        "maps": [orbit.segments.maps for orbit in orbits],
        "map_errors": [orbit.segments.errors for orbit in orbits],
    }
    return (
        {name: np.array(values, dtype=float) for name, values in each.items()}
        | {name: np.array(values, dtype=np.int64) for name, values in counts.items()}
        | {name: np.concatenate([part.ravel() for part in values]) for name, values in parts.items()}
    )


def _of_points(points: tuple[SpecialPoint, ...]) -> dict[str, NDArray[Any]]:
    """Return what special points have beside their orbits."""
    empty = np.empty(0)
    return {
        "point_errors": np.array([point.error for point in points], dtype=float),
        "point_multipliers": np.array([[point.multiplier.real, point.multiplier.imag] for point in points]).ravel(),
        "directions": np.concatenate([empty, *(point.direction.nodes.ravel() for point in points)]),
        "scalars": np.concatenate([empty, *(point.direction.scalars for point in points)]),
        "scales": np.concatenate([empty, *(point.measure.scale for point in points)]),
        "widths": np.array([point.measure.width for point in points], dtype=float),
    }


def load(path: str | Path, system: NonlinearSystem) -> dict[str, Any]:
    """Return the fields of a branch in a file, of a system that is not in it."""
    validate.instance("system", system, NonlinearSystem)
    return sealed_files.read_npz(path, _FORMAT, "a branch", lambda meta, arrays: _branch(meta, arrays, system))


def _branch(meta: dict[str, Any], arrays: sealed_files.Arrays, system: NonlinearSystem) -> dict[str, Any]:
    """Return the fields that a file describes; ValueError or KeyError where it is not as `save` writes it."""
    parameter, count = sealed_files.entry(meta, "parameter", str), sealed_files.entry(meta, "orbits", int)
    given = sealed_files.entry(meta, "parameters", dict)
    if set(given) != set(system.parameters):
        raise ValueError(f"it is of a system with the parameters {', '.join(given)}")
    orbits = list(_orbits(meta, arrays, system.with_parameters(**given)))
    points = tuple(_points(meta, arrays, orbits[count:]))
    low, high = sealed_files.entry(meta, "over", list)
    begins, ends = sealed_files.entry(meta, "ends", list)
    tolerance = sealed_files.entry(meta, "tolerance", float)
    return {
        "parameter": parameter,
        "over": (low, high),
        "orbits": tuple(orbits[:count]),
        "special_points": points,
        "ends": (begins, ends),
        "tolerance": tolerance,
        "notes": tuple(meta.get("notes", ())),
    }


def _orbits(meta: dict[str, Any], arrays: sealed_files.Arrays, system: NonlinearSystem) -> Iterator[PeriodicOrbit]:
    """Return the orbits, one after the other."""
    n, parameter, turns = (
        sealed_files.entry(meta, "equations", int),
        sealed_files.entry(meta, "parameter", str),
        meta["turns"],
    )
    names = ("values", "periods", "period_errors", "errors", "traces", "trace_errors", "intervals", "degrees", "steps")
    many = (sealed_files.entry(meta, "orbits", int) + len(sealed_files.entry(meta, "kinds", list)),)
    for name in names:
        sealed_files.require_shape(arrays, name, many)
    column = {name: arrays[name].tolist() for name in names}
    columns = zip(*column.values(), strict=True)
    lengths = {"meshes": 0, "nodes": 0, "stages": 0, "maps": 0}
    for count, degree in zip(column["intervals"], column["degrees"], strict=True):
        lengths["meshes"] += count + 1
        lengths["nodes"] += count * n
        lengths["stages"] += count * degree * n
        lengths["maps"] += count * n * n
    for name, length in (*lengths.items(), ("map_errors", lengths["maps"])):
        sealed_files.require_shape(arrays, name, (length,))
    taken = {name: _Taken(arrays[name]) for name in (*lengths, "map_errors")}
    for value, period, period_error, error, trace, trace_error, count, degree, steps in columns:
        mesh, nodes = taken["meshes"].next(count + 1), taken["nodes"].next(count, n)
        point = Point(nodes, taken["stages"].next(count, degree, n), period, value)
        winding = tuple(float(each) for each in meta.get("winding", ()))
        collocation = Collocation(system, mesh, degree, turns, parameter, winding)
        missed = float((np.abs(collocation.residual(point)) / point.scale).max())
        if not missed <= max(_OTHER, 10.0 * error):
            raise ValueError(f"an orbit in it misses the equations of this system by {missed:.1g} of its states")
        flow = None if turns else collocation.rates_at_mesh(point)
        maps, errors = taken["maps"].next(count, n, n), taken["map_errors"].next(count, n, n)
        segments = Segments(maps, errors, flow, trace, trace_error)
        comparison = Compared(collocation, point, segments, np.zeros(count), 0.0, error, period_error, 0.0, steps)
        yield as_orbit(comparison, steps)


def _points(meta: dict[str, Any], arrays: sealed_files.Arrays, orbits: list[PeriodicOrbit]) -> Iterator[SpecialPoint]:
    """Return the special points, whose orbits are known."""
    parameter, taken = meta["parameter"], {n: _Taken(arrays[n]) for n in ("directions", "scalars", "scales")}
    multipliers = arrays["point_multipliers"].reshape(-1, 2)
    counts = meta.get("counts", [1] * len(meta["kinds"]))  # which older files do not have
    columns = zip(meta["kinds"], meta["after"], counts, arrays["point_errors"], arrays["widths"], strict=True)
    for i, (kind, after, several, error, width) in enumerate(columns):
        orbit = orbits[i]
        count, n = orbit.point.nodes.shape
        scalars = taken["scalars"].next(1 if meta["turns"] else 2)
        direction = Step(taken["directions"].next(count, n), np.empty((count, 0, n)), scalars)
        measure = Measure(taken["scales"].next(n), float(width))
        mu, value = complex(*multipliers[i]), orbit.system.parameters[parameter]
        yield SpecialPoint(kind, parameter, value, float(error), mu, orbit, direction, measure, after, several)


class _Taken:
    """Parts of a long array, one after the other."""

    def __init__(self, values: NDArray[Any]) -> None:
        """Begin with its first number."""
        self.values, self.at = values, 0

    def next(self, *shape: int) -> Floats:
        """Return the next part, of a shape; ValueError where there is none."""
        size = int(np.prod(shape))
        part = self.values[self.at : self.at + size]
        self.at += size
        return np.asarray(part, dtype=float).reshape(shape)
