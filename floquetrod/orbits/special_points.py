"""Special points of a branch of orbits, where a multiplier crosses the unit circle, and ways onto other branches."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.orbits import arclength, finding, orbit_mesh
from floquetrod.orbits.arclength import Measure
from floquetrod.orbits.collocation import Collocation, Point, Step
from floquetrod.orbits.newton import NoOrbitError, corrected
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.orbit_extent import returns_after

Kind = Literal["fold", "branch point", "period doubling", "Neimark-Sacker"]

_ZERO = 2e-6  # of the largest state, up to which another is zero along a branch (a choice)
_SHORTER = (1.0, 0.4, 0.1, 0.02)  # parts of the distance that are tried (a choice)
_FARTHEST = 4.0  # times the distance: an orbit farther away is that of another place (a choice)
_REFUSED = {
    "fold": "no branch crosses at a fold; the branch itself continues there",
    "Neimark-Sacker": "the motion that begins at a Neimark-Sacker point has two frequencies and is no periodic orbit",
}


@dataclass(frozen=True, eq=False, repr=False)
class SpecialPoint(ByContent):
    """A point of a branch where a multiplier of the orbit crosses the unit circle.

    Attributes
    ----------
    kind : {"fold", "branch point", "period doubling", "Neimark-Sacker"}
        At +1 where the parameter turns back; at +1 where another branch crosses; at -1; a complex pair, where motion
        with a second frequency appears.
    parameter : str
        Name of the parameter.
    value : float
        Its value there.
    error : float
        Estimate of the error of ``value``: of the multiplier, of the zero it was located by, and of the orbit.
    multiplier : complex
        The one that crosses, of a pair that with the positive imaginary part.
    orbit : PeriodicOrbit
        The orbit there, whose verdict as a rule is undecided.
    after : int
        The point lies between this orbit of the branch and the next one.
    count : int
        How many multipliers cross there together, as symmetry makes them do; at a Neimark-Sacker point, how many pairs.
    """

    kind: Kind
    parameter: str
    value: float
    error: float
    multiplier: complex
    orbit: PeriodicOrbit
    direction: Step = field(compare=False)
    measure: Measure = field(compare=False)
    after: int = field(default=0, compare=False)
    count: int = 1

    @property
    def period(self) -> float:
        """Period of the orbit there."""
        return self.orbit.period

    @property
    def least(self) -> Floats:
        """Least value of each state over the period (n,)."""
        return self.orbit.least

    @property
    def largest(self) -> Floats:
        """Largest value of each state over the period (n,)."""
        return self.orbit.largest

    @property
    def amplitude(self) -> Floats:
        """Half the difference between the largest and the least value of each state (n,)."""
        return 0.5 * (self.largest - self.least)

    def switch(self, *, side: int = 1, distance: float = 0.05) -> PeriodicOrbit:
        """Return an orbit on the branch that begins or crosses here, near this point, for `floquetrod.follow`.

        Parameters
        ----------
        side : {1, -1}
            Side of this branch.  At a period doubling both sides give one orbit, shifted by half its period in time.
            From a branch of doubled orbits, the orbit of half the period is returned.
        distance : float
            How far away, as a fraction of the largest magnitudes of the states, from 1e-4 to 1; less where there is no
            orbit so far out.  A state that is zero along this branch counts as the largest of all.

        Returns
        -------
        PeriodicOrbit
            On the other branch.

        Raises
        ------
        ValueError
            At folds, where nothing crosses; at Neimark-Sacker points, where the new motion is not periodic; and where
            no orbit was found.
        """
        return _switched(self, side, distance)

    def as_dict(self) -> dict[str, Any]:
        """Return the point as numbers for JSON.

        Returns
        -------
        dict of str
            Kind, value, error, multiplier and the orbit that it follows.
        """
        mu = [self.multiplier.real, self.multiplier.imag]
        numbers = {"kind": self.kind, "value": self.value, "error": self.error, "multiplier": mu, "after": self.after}
        return numbers | {"count": self.count}

    def __str__(self) -> str:
        return repr(self)

    def __repr__(self) -> str:
        """Return, say, "fold at omega = 2.2036 +- 1e-11"."""
        pairs = "pairs" if self.kind == "Neimark-Sacker" else "multipliers"
        together = f", {self.count} {pairs} together" if self.count > 1 else ""
        return f"{self.kind} at {self.parameter} = {self.value:.10g} +- {self.error:.1g}{together}"


def _switched(special: SpecialPoint, side: int, distance: float) -> PeriodicOrbit:
    """Return an orbit on the branch of doubled orbits that begins at a point, or on the one that crosses."""
    if special.kind in _REFUSED:
        raise ValueError(f"{_REFUSED[special.kind]}; switch at a branch point or a period doubling")
    if validate.integer("side", side, -1, 1) == 0:
        raise ValueError("side must be 1 or -1, got 0")
    distance = validate.within("distance", distance, 1e-4, 1.0)
    orbit = special.orbit
    if special.kind == "period doubling" and returns_after(orbit.collocation, orbit.point, 2):  # of doubled orbits
        return finding.periodic_orbit(orbit.system, orbit.states[0], 0.5 * orbit.period)
    collocation, point, direction = _at(special)
    measure = special.measure._replace(scale=deviation_scale(special.measure.scale))
    across = _across(collocation, point, direction, measure)
    for share in _SHORTER:
        found = _out(collocation, point, across, measure, side * share * distance)
        if found is not None:
            return found
    where = f"{special.parameter} = {special.value:.9g}"
    raise NoOrbitError(f"no orbit was found on the branch that crosses at {where}; try another distance")


def deviation_scale(scale: Floats) -> Floats:
    """Return magnitudes (n,) of deviations from an orbit: of a state that is zero along it, the largest of all."""
    return np.where(scale <= _ZERO * scale.max(), scale.max(), scale)


def _at(special: SpecialPoint) -> tuple[Collocation, Point, Step]:
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
    rows = arclength.rows_of(collocation, point, measure.row(collocation, point, direction), measure)
    return measure.unit(collocation, point, collocation.kernel(condensed, rows, point.scale))


def _out(
    collocation: Collocation, point: Point, across: Step, measure: Measure, distance: float
) -> PeriodicOrbit | None:
    """Return the orbit at a distance across the branch; None where there is none near."""
    guess = collocation.moved(point, across, distance)
    row = arclength.through(collocation, guess, measure.row(collocation, point, across))
    try:
        solution = corrected(
            collocation, guess, arclength.rows_of(collocation, guess, row, measure), arclength.MOST_STEPS
        ).point
        if measure.length(collocation, point, arclength.between(collocation, point, solution)) > _FARTHEST * abs(
            distance
        ):
            return None
        orbit = finding.orbit_of(collocation, solution)
    except NoOrbitError:
        return None
    fixed = replace(collocation, parameter=None)
    there = orbit_mesh.carried(orbit.collocation, orbit.point, collocation.mesh, collocation.degree)[1]
    gap = measure.length(fixed, there, arclength.between(fixed, solution._replace(value=0.0), there))
    return orbit if gap < 0.3 * abs(distance) else None
