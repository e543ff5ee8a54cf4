"""Points of a branch of orbits: how far they are apart, and Newton's method across the direction it goes on in.

The length of a change (dx, dT, dp) of the states, the period and the parameter is the square root of mean(|dx /
scale|^2) + (dT / T)^2 + (dp / width)^2: the mean over the period and the sum over the states, each as a fraction of its
largest magnitude, the period only where it is unknown, and the parameter as a fraction of the range it is followed over
(H. B. Keller, in Applications of Bifurcation Theory, Academic Press 1977, 359).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.orbits import orbit_mesh
from floquetrod.orbits.collocation import BorderRow, Collocation, Condensed, Point, Step
from floquetrod.orbits.newton import corrected

MOST_STEPS = 9  # of Newton's method, before a shorter step along the branch is tried


class Measure(NamedTuple):
    """Units of the states (n,) and of the parameter, in which lengths along a branch are told."""

    scale: Floats
    width: float

    def units(self, collocation: Collocation, point: Point) -> Floats:
        """Return the units of the free scalars (S,)."""
        every = {"period": point.period, "parameter": self.width}
        return np.array([every[name] for name in collocation.scalars])

    def row(self, collocation: Collocation, point: Point, direction: Step) -> BorderRow:
        """Return the product with a direction as a row that vanishes at a point."""
        nodes = collocation.weights[:, None] * direction.nodes / self.scale**2
        scalars = direction.scalars / self.units(collocation, point) ** 2
        return through(collocation, point, BorderRow(nodes, scalars, 0.0))

    def length(self, collocation: Collocation, point: Point, step: Step) -> float:
        """Return the length of a step."""
        row = self.row(collocation, point, step)
        return math.sqrt(max(product(row, step), 0.0))

    def unit(self, collocation: Collocation, point: Point, step: Step) -> Step:
        """Return a step of length 1 in the same direction."""
        return scaled(step, 1.0 / self.length(collocation, point, step))

    def grown(self, point: Point) -> Measure:
        """Return units that hold a point's states, too."""
        return Measure(np.maximum(self.scale, point.scale), self.width)


class CurvePoint(NamedTuple):
    """A point that satisfies the equations, and the equations linearised there.

    With the direction, of length 1, in which the branch goes on, and the steps of Newton's method that it took.
    """

    collocation: Collocation
    point: Point
    condensed: Condensed
    direction: Step
    steps: int


def product(row: BorderRow, step: Step) -> float:
    """Return the product of a row and a step."""
    return float((row.nodes * step.nodes).sum() + row.scalars @ step.scalars)


def scaled(step: Step, factor: float) -> Step:
    """Return a multiple of a step."""
    return Step(*(factor * part for part in step))


def between(collocation: Collocation, start: Point, end: Point) -> Step:
    """Return the step from one point to another on the same mesh."""
    scalars = collocation.values(end) - collocation.values(start)
    return Step(end.nodes - start.nodes, end.stages - start.stages, scalars)


def through(collocation: Collocation, point: Point, row: BorderRow) -> BorderRow:
    """Return a row whose equation holds at a point."""
    return row._replace(target=float((row.nodes * point.nodes).sum() + row.scalars @ collocation.values(point)))


def pinned(collocation: Collocation, point: Point, value: float, measure: Measure) -> BorderRow:
    """Return the row that gives the parameter a value, in its unit."""
    scalars = np.array([float(name == "parameter") / measure.width for name in collocation.scalars])
    return BorderRow(np.zeros_like(point.nodes), scalars, value / measure.width)


def rows_of(collocation: Collocation, reference: Point, last: BorderRow, measure: Measure) -> list[BorderRow]:
    """Return a phase condition, where the orbit is autonomous, and a last row."""
    return [last] if collocation.turns else [collocation.phase(reference, measure.scale), last]


def placed(
    collocation: Collocation,
    guess: Point,
    last: BorderRow,
    onward: BorderRow,
    measure: Measure,
    most_steps: int = MOST_STEPS,
) -> CurvePoint:
    """Return the place near a guess where a row holds, its direction that in which the row ``onward`` grows.

    Raises NoOrbitError where Newton's method finds none.
    """
    solution = corrected(collocation, guess, rows_of(collocation, guess, last, measure), most_steps)
    rows = rows_of(collocation, solution.point, onward, measure)
    direction = collocation.tangent(solution.condensed, rows, solution.point.scale)
    unit = measure.unit(collocation, solution.point, direction)
    return CurvePoint(collocation, solution.point, solution.condensed, unit, solution.steps)


def moved_to(place: CurvePoint, mesh: Floats, measure: Measure) -> tuple[Collocation, Point, BorderRow]:
    """Return the equations on another mesh, the point there, and the row of the direction."""
    collocation, point = orbit_mesh.carried(place.collocation, place.point, mesh, place.collocation.degree)
    direction = carried_step(place.collocation, place.direction, mesh, place.collocation.degree)
    return collocation, point, measure.row(collocation, point, direction)


def carried_step(collocation: Collocation, step: Step, mesh: Floats, degree: int) -> Step:
    """Return a step on another mesh or of another degree."""
    as_point = Point(step.nodes, step.stages, 1.0)
    values = orbit_mesh.carried(replace(collocation, parameter=None), as_point, mesh, degree)[1]
    return Step(values.nodes, values.stages, step.scalars)
