"""From a special point onto the branch of doubled orbits that begins there, or the one that crosses."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.orbits import arclength, finding
from floquetrod.orbits import mesh as meshes
from floquetrod.orbits.arclength import Measure
from floquetrod.orbits.collocation import Collocation, Point, Step
from floquetrod.orbits.extents import returns_after
from floquetrod.orbits.newton import NoOrbitError, corrected
from floquetrod.orbits.orbit import PeriodicOrbit

Kind = Literal["fold", "branch point", "period doubling", "Neimark-Sacker"]

_SHORTER = (1.0, 0.4, 0.1, 0.02)  # parts of the distance that are tried (a choice)
_FARTHEST = 4.0  # times the distance: an orbit farther away is that of another place (a choice)
_REFUSED = {
    "fold": "no branch crosses at a fold; the branch itself continues there",
    "Neimark-Sacker": "the motion that begins at a Neimark-Sacker point has two frequencies and is no periodic orbit",
}


class Origin(NamedTuple):
    """A special point: its kind, the parameter and its value, the orbit there, and the direction of its branch."""

    kind: Kind
    parameter: str
    value: float
    orbit: PeriodicOrbit
    direction: Step
    measure: Measure


def switched(special: Origin, side: int, distance: float) -> PeriodicOrbit:
    """Return an orbit on the other branch; see `SpecialPoint.switch`."""
    if special.kind in _REFUSED:
        raise ValueError(f"{_REFUSED[special.kind]}; switch at a branch point or a period doubling")
    if side not in (1, -1):
        raise ValueError(f"side must be 1 or -1, got {validate.short(side)}")
    distance = validate.within("distance", distance, 1e-4, 1.0)
    if special.kind == "period doubling" and returns_after(special.orbit, 2):  # found from the doubled orbits
        return finding.periodic_orbit(special.orbit.system, special.orbit.states[0], 0.5 * special.orbit.period)
    collocation, point, direction = _at(special)
    across = _across(collocation, point, direction, special.measure)
    for share in _SHORTER:
        found = _out(collocation, point, across, special.measure, side * share * distance)
        if found is not None:
            return found
    where = f"{special.parameter} = {special.value:.9g}"
    raise NoOrbitError(f"no orbit was found on the branch that crosses at {where}; try another distance")


def _at(special: Origin) -> tuple[Collocation, Point, Step]:
    """Return the equations with the parameter unknown, the point and the direction, doubled at a period doubling."""
    orbit, direction = special.orbit, special.direction
    collocation = replace(orbit.collocation, parameter=special.parameter)
    point = orbit.point._replace(value=special.value)
    if special.kind != "period doubling":
        return collocation, point, direction
    mesh = np.concatenate([0.5 * collocation.mesh, 0.5 + 0.5 * collocation.mesh[1:]])
    turns = None if collocation.turns is None else 2 * collocation.turns
    doubled = replace(collocation, mesh=mesh, turns=turns)
    twice = Point(_twice(point.nodes), _twice(point.stages), 2.0 * point.period, point.value)
    factors = np.array([2.0 if name == "period" else 1.0 for name in collocation.scalars])
    return doubled, twice, Step(_twice(direction.nodes), _twice(direction.stages), factors * direction.scalars)


def _twice(values: Floats, sign: float = 1.0) -> Floats:
    return np.concatenate([values, sign * values])


def _across(collocation: Collocation, point: Point, direction: Step, measure: Measure) -> Step:
    """Return the direction of length 1 in which the linearised equations have another solution."""
    condensed = collocation.linearised(point)
    rows = arclength.rows_of(collocation, point, measure.row(collocation, point, direction))
    return measure.unit(collocation, point, collocation.kernel(condensed, rows, point.scale))


def _out(
    collocation: Collocation, point: Point, across: Step, measure: Measure, distance: float
) -> PeriodicOrbit | None:
    """Return the orbit at a distance across the branch; None where there is none near."""
    guess = collocation.moved(point, across, distance)
    row = arclength.through(collocation, guess, measure.row(collocation, point, across))
    try:
        found = corrected(collocation, guess, arclength.rows_of(collocation, guess, row), arclength.MOST_STEPS).point
        if measure.length(collocation, point, arclength.between(collocation, point, found)) > _FARTHEST * abs(distance):
            return None
        orbit = finding.orbit_of(collocation, found)
    except NoOrbitError:
        return None
    fixed = replace(collocation, parameter=None)
    there = meshes.carried(orbit.collocation, orbit.point, collocation.mesh, collocation.degree)[1]
    gap = measure.length(fixed, there, arclength.between(fixed, found._replace(value=math.nan), there))
    return orbit if gap < 0.3 * abs(distance) else None
