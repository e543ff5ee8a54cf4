"""Points of a branch of orbits: how far they are apart, and Newton's method across the direction it goes on in.

The length of a change (dx, dT, dp) of the states, the period and the parameter is the square root of mean(|dx /
scale|^2) + (dT / T)^2 + (dp / width)^2: the mean over the period and the sum over the states, each as a fraction of its
largest magnitude, the period only where it is unknown, and the parameter as a fraction of the range it is followed over
(H. B. Keller, in Applications of Bifurcation Theory, Academic Press 1977, 359).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.orbits import orbit_mesh
from floquetrod.orbits.collocation import BorderRow, Collocation, Condensed, Point, Step
from floquetrod.orbits.newton import Corrected, corrected

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
        return through(collocation, point, self._across(collocation, point, direction))

    def _across(self, collocation: Collocation, point: Point, direction: Step) -> BorderRow:
        """Return the product with a direction as a row."""
        nodes = collocation.weights[:, None] * direction.nodes / self.scale**2
        return BorderRow(nodes, direction.scalars / self.units(collocation, point) ** 2, 0.0)

    def length(self, collocation: Collocation, point: Point, step: Step) -> float:
        """Return the length of a step."""
        return math.sqrt(max(product(self._across(collocation, point, step), step), 0.0))

    def unit(self, collocation: Collocation, point: Point, step: Step) -> Step:
        """Return a step of length 1 in the same direction."""
        return scaled(step, 1.0 / self.length(collocation, point, step))

    def grown(self, point: Point) -> Measure:
        """Return units that hold a point's states, too."""
        return Measure(np.maximum(self.scale, point.scale), self.width)


class CurvePoint(NamedTuple):
    """A point that satisfies the equations, and the equations linearised there.

    With the direction, of length 1, in which the branch goes on, the steps of Newton's method that it took, and the
    rates of change of the states, None of a forced system.
    """

    collocation: Collocation
    point: Point
    condensed: Condensed
    direction: Step
    steps: int
    flow: Step | None


def product(row: BorderRow, step: Step) -> float:
    """Return the product of a row and a step."""
    return float(np.vdot(row.nodes, step.nodes) + row.scalars @ step.scalars)


def scaled(step: Step, factor: float) -> Step:
    """Return a multiple of a step."""
    return Step(*(factor * part for part in step))


def between(collocation: Collocation, start: Point, end: Point) -> Step:
    """Return the step from one point to another on the same mesh."""
    scalars = collocation.values(end) - collocation.values(start)
    return Step(end.nodes - start.nodes, end.stages - start.stages, scalars)


def through(collocation: Collocation, point: Point, row: BorderRow) -> BorderRow:
    """Return a row whose equation holds at a point."""
    return row._replace(target=float(np.vdot(row.nodes, point.nodes) + row.scalars @ collocation.values(point)))


def pinned(collocation: Collocation, point: Point, value: float, measure: Measure) -> BorderRow:
    """Return the row that gives the parameter a value, in its unit."""
    scalars = np.array([float(name == "parameter") / measure.width for name in collocation.scalars])
    return BorderRow(np.zeros_like(point.nodes), scalars, value / measure.width)


def rows_of(
    collocation: Collocation, reference: Point, last: BorderRow, measure: Measure, flow: Step | None = None
) -> list[BorderRow]:
    """Return a phase condition, where the orbit is autonomous, and a last row.

    ``flow`` is the flow at the reference, if it is known.
    """
    if collocation.turns:
        return [last]
    return [collocation.phase(reference, measure.scale, None if flow is None else flow.nodes), last]


def flow_of(collocation: Collocation, solution: Corrected) -> Step | None:
    """Return the rates of change of the states, None of a forced system."""
    if collocation.turns:
        return None
    still = np.zeros(len(collocation.scalars))
    return Step(collocation.rates_at_mesh(solution.point), solution.condensed.rates, still)


def placed(
    collocation: Collocation,
    guess: Point,
    last: BorderRow,
    onward: BorderRow,
    measure: Measure,
    most_steps: int = MOST_STEPS,
    closer: Point | None = None,
) -> CurvePoint:
    """Return the place near a guess where a row holds, its direction that in which the row ``onward`` grows.

    The guess sets the phase; Newton's method begins there, or where a ``closer`` one is known, at that.  Raises
    NoOrbitError where it finds no orbit.
    """
    rows = rows_of(collocation, guess, last, measure)
    solution = corrected(collocation, guess if closer is None else closer, rows, most_steps)
    flow = flow_of(collocation, solution)
    rows = rows_of(collocation, solution.point, onward, measure, flow)
    direction = collocation.tangent(solution.condensed, rows, solution.point.scale)
    unit = measure.unit(collocation, solution.point, direction)
    return CurvePoint(collocation, solution.point, solution.condensed, unit, solution.steps, flow)


def extrapolated(before: CurvePoint, last: CurvePoint, row: BorderRow, length: float) -> Point:
    """Return the point at a length beyond the last of two on one mesh, by the cubic through both in their directions.

    Lengths are those along the direction at the last point, the product with ``row``: the cubic is of the curve itself
    by them, and its error of the fourth order in the steps.  Directions do not change the phase; points do, by as much
    as the phase condition about a guess along the tangent makes of every step, and so the cubic has that rate, too.
    """
    collocation = last.collocation
    change = between(collocation, last.point, before.point)
    back = -product(row, change)
    share, slope, later = length / back, product(row, before.direction), 0.0
    if before.flow is not None and last.flow is not None:
        flow = before.flow.nodes + last.flow.nodes
        weighed = collocation.weights[:, None] * flow / last.point.scale**2
        missed = change.nodes + 0.5 * back * (before.direction.nodes + last.direction.nodes)
        later = -2.0 * float(np.vdot(weighed, missed)) / (float(np.vdot(weighed, flow)) * back)
        slope += later * product(row, before.flow)
    old, new = length * share * (1.0 + share) / slope, length * (1.0 + share) ** 2
    terms = [(share**2 * (3.0 + 2.0 * share), change), (old, before.direction), (new, last.direction)]
    if before.flow is not None and last.flow is not None:
        terms += [(old * later, before.flow), (new * later, last.flow)]
    nodes, stages, scalars = (np.asarray(sum(factor * step[k] for factor, step in terms)) for k in range(3))
    return collocation.moved(last.point, Step(nodes, stages, scalars))


def on_mesh(place: CurvePoint, mesh: Floats) -> CurvePoint:
    """Return a place on another mesh, to go on from: its linearised equations stay those on the old one."""
    point, direction, flow = place.point, place.direction, place.flow
    every = [point, direction] if flow is None else [point, direction, flow]
    nodes, stages = (np.concatenate([each[k] for each in every], axis=-1) for k in (0, 1))
    given, together = place.collocation, point._replace(nodes=nodes, stages=stages)
    collocation, there = orbit_mesh.carried(given, together, mesh, given.degree)
    parts = [[np.ascontiguousarray(x) for x in np.split(there[k], len(every), axis=-1)] for k in (0, 1)]
    moved = [{"nodes": at_mesh, "stages": inside} for at_mesh, inside in zip(*parts, strict=True)]
    return place._replace(
        collocation=collocation,
        point=point._replace(**moved[0]),
        direction=direction._replace(**moved[1]),
        flow=None if flow is None else flow._replace(**moved[2]),
    )
