"""A branch of orbits followed in one direction by pseudo-arclength, step by step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats
from floquetrod.orbits import arclength, finding, orbit_mesh
from floquetrod.orbits.arclength import CurvePoint, Measure
from floquetrod.orbits.collocation import BorderRow, Collocation, Point, gauss
from floquetrod.orbits.crossings import OrbitMultipliers, Tests, multipliers_of, tests
from floquetrod.orbits.finding import Compared
from floquetrod.orbits.newton import NoOrbitError
from floquetrod.orbits.orbit import PeriodicOrbit

FIRST_LENGTH = 0.01
"""Length of the first step along a branch or a curve (a choice)."""

LEAST_LENGTH = 1e-7
"""Length of a step below which a branch or a curve is given up."""

SHARPEST_TURN = 0.9
"""Cosine of the angle between directions below which a step is made shorter (a choice)."""

MOST_MESHES = 4
"""Meshes on which a point is solved, one after the other."""

_GENTLE = 0.985  # cosine of the angle between directions above which the next step is longer (a choice)
_FEW = 4  # steps of Newton's method up to which the next step is longer
HOPF = "a Hopf point"
"""What a branch's end says where its orbits shrink to a state of rest."""

_REST = 1e-4  # motion as a fraction of the largest on the branch, below which an orbit has shrunk to a state of rest


class Task(NamedTuple):
    """What is followed: a parameter by name, its range, the tolerance of the states, the longest step, until when."""

    parameter: str
    low: float
    high: float
    tolerance: float
    longest: float
    until: Callable[[PeriodicOrbit, PeriodicOrbit], str] | None = None


class Sample(NamedTuple):
    """A place of a branch, the orbit of a higher degree there, its multipliers, and what tells special points."""

    place: CurvePoint
    compared: Compared
    orbit: PeriodicOrbit
    value: float
    value_error: float
    multipliers: OrbitMultipliers
    tests: Tests

    @classmethod
    def of(cls, place: CurvePoint, finer: Compared) -> Sample:
        """Return the sample of a place whose orbit of a higher degree is known."""
        orbit = finding.as_orbit(finer, place.steps + finer.steps)
        multipliers = multipliers_of(orbit)
        signs = tests(multipliers, float(place.direction.scalars[-1]))
        return cls(place, finer, orbit, finer.point.value, finer.value_error, multipliers, signs)


class Ended(Exception):
    """The branch or the curve cannot be followed on; the message says why."""


def sampled(place: CurvePoint, measure: Measure, value: float | None = None) -> Sample:
    """Return the sample of a point of the branch: the orbit of a higher degree, its error and its multipliers.

    That orbit has the same parameter where a ``value`` is given, else it lies across the direction of the branch.
    """
    collocation, point = place.collocation, place.point
    if value is None:
        row = measure.row(collocation, point, place.direction)
    else:
        row = arclength.pinned(collocation, point, value, measure)
    finer = finding.compared(
        collocation, point, place.condensed, arclength.rows_of(collocation, point, row, measure, place.flow)
    )
    if value is not None:  # Newton's last step may miss it by rounding
        exact = finer.point._replace(value=value)
        finer = finer._replace(point=exact._replace(period=finer.collocation.period_at(exact)))
    return Sample.of(place, finer)


def lowered(orbit: PeriodicOrbit, parameter: str, onto: Collocation) -> tuple[Collocation, Point]:
    """Return an orbit's equations, a parameter unknown, and its point, on the mesh of others and two degrees lower."""
    collocation = replace(orbit.collocation, parameter=parameter)
    point = orbit.point._replace(value=orbit.system.parameters[parameter])
    return orbit_mesh.carried(collocation, point, onto.mesh, onto.degree - finding.MORE)


def started(orbit: PeriodicOrbit, task: Task, measure: Measure) -> CurvePoint:
    """Return the place of an orbit on a branch, going on to larger values of the parameter."""
    collocation, point = lowered(orbit, task.parameter, orbit.collocation)
    row = arclength.pinned(collocation, point, point.value, measure)
    return arclength.placed(collocation, point, row, row, measure)


def next_length(length: float, longest: float, newton_steps: int, cosine: float) -> float:
    """Return the length of the next step, from Newton's steps in this one and the cosine of its turn."""
    if newton_steps <= _FEW and cosine > _GENTLE:
        return min(1.5 * length, longest)
    return 0.7 * length if newton_steps > _FEW + 2 else length


def has_shrunk(before: PeriodicOrbit, orbit: PeriodicOrbit, scale: Floats) -> bool:
    """Return whether an orbit of an autonomous system has shrunk to a state of rest, or passed through one.

    ``before`` is the orbit before it on the branch, ``scale`` (n,) the magnitudes of the states along the branch.
    """
    was, now = before.segments.flow, orbit.segments.flow
    if was is None or now is None:
        return False
    if float((np.ptp(orbit.point.nodes, axis=0) / scale).max()) < _REST:
        return True
    mesh, shares = before.collocation.mesh, orbit.collocation.mesh
    if mesh is not shares:
        was = np.stack([np.interp(shares[:-1], mesh[:-1], column, period=1.0) for column in was.T], axis=1)
    return float((was * now / scale**2).sum()) < 0.0


class Continuation:
    """The march along a branch from a place; it changes its own place, step and units."""

    def __init__(self, task: Task, start: Sample, measure: Measure, direction: float) -> None:
        """Begin at a sample, in its direction or against it."""
        self.task, self.measure, self.length = task, measure, min(FIRST_LENGTH, task.longest)
        step = arclength.scaled(start.place.direction, direction)
        place = start.place._replace(direction=step)
        self.sample = start._replace(place=place, tests=start.tests._replace(turning=direction * start.tests.turning))
        outward = task.high - start.value if step.scalars[-1] > 0.0 else start.value - task.low
        self.at_end = outward <= 1e-12 * (task.high - task.low)
        self._behind: CurvePoint | None = None

    def advanced(self) -> Sample:
        """Return the next sample, on the end of the range where the branch leaves it.  Raises Ended."""
        if self.at_end:
            raise Ended(f"{self.task.parameter} = {self.sample.value:.6g} is the end of the range")
        place = self._stepped()
        bound = self._bound_passed(place.point.value)
        if bound is not None:
            place, self.at_end = self._at(bound, place), True
        place = self._resolved(place)
        try:
            sample = sampled(place, self.measure, bound)
        except NoOrbitError as error:
            raise Ended(f"the orbit at {self.task.parameter} = {place.point.value:.9g} was lost: {error}") from None
        self._require_motion(sample)
        self.measure = self.measure.grown(sample.place.point)
        place = sample.place
        unit = self.measure.unit(place.collocation, place.point, place.direction)  # which has other units now
        self._behind = self.sample.place
        self.sample = sample._replace(place=place._replace(direction=unit))
        return self.sample

    def _stepped(self) -> CurvePoint:
        """Return the place a step on, the step as long as Newton's method and the branch's bends allow."""
        said, before = "", self.sample.place
        row = self.measure.row(before.collocation, before.point, before.direction)
        while self.length >= LEAST_LENGTH:
            try:
                place = self._corrected(row, self.length)
            except (NoOrbitError, ValueError, ArithmeticError) as error:
                said = str(error)
                self.length *= 0.5
                continue
            cosine = arclength.product(row, place.direction)
            if cosine < SHARPEST_TURN:
                said = "it bends too sharply"
                self.length *= 0.5
                continue
            self.length = next_length(self.length, self.task.longest, place.steps, cosine)
            return place
        raise Ended(
            f"no orbit was found beyond {self.task.parameter} = {self.sample.value:.9g}, however short the step: {said}"
        )

    def _corrected(self, row: BorderRow, length: float) -> CurvePoint:
        """Return the place at a length along the present direction, the product with ``row``."""
        before = self.sample.place
        ahead = row._replace(target=row.target + length)
        guess = before.collocation.moved(before.point, before.direction, length)
        closer = self._extrapolated(row, length)
        return arclength.placed(before.collocation, guess, ahead, row, self.measure, closer=closer)

    def _extrapolated(self, row: BorderRow, length: float) -> Point | None:
        """Return the point at a length along the present direction, from the place before, too; None at the start."""
        here, behind = self.sample.place, self._behind
        if behind is None:
            return None
        mesh = here.collocation.mesh
        if behind.collocation.mesh is not mesh:
            behind = self._behind = arclength.on_mesh(behind, mesh)
        return arclength.extrapolated(behind, here, row, length)

    def _bound_passed(self, value: float) -> float | None:
        """Return the end of the range beyond which a value lies; None inside."""
        low, high = self.task.low, self.task.high
        return low if value < low else high if value > high else None

    def _at(self, bound: float, place: CurvePoint) -> CurvePoint:
        """Return the place between the present one and another where the parameter has a value."""
        before = self.sample.place
        change = arclength.between(before.collocation, before.point, place.point)
        share = (bound - before.point.value) / (place.point.value - before.point.value)
        guess = place.collocation.moved(before.point, change, share)
        row = arclength.pinned(place.collocation, guess, bound, self.measure)
        onward = self.measure.row(place.collocation, place.point, place.direction)
        try:
            return arclength.placed(place.collocation, guess, row, onward, self.measure)
        except ValueError as error:
            raise Ended(f"no orbit was found at the end of the range: {error}") from None

    def _resolved(self, place: CurvePoint) -> CurvePoint:
        """Return the place on a mesh that resolves it, and is not much finer."""
        for _ in range(MOST_MESHES):
            jacobians = place.condensed.jacobians
            mesh = orbit_mesh.adapted(place.collocation, place.point, jacobians, self.task.tolerance)
            if mesh is None:
                return place
            collocation, point, *_ = place = arclength.on_mesh(place, mesh)
            row = self.measure.row(collocation, point, place.direction)
            last = arclength.pinned(collocation, point, point.value, self.measure) if self.at_end else row
            try:
                place = arclength.placed(collocation, point, last, row, self.measure)
            except ValueError as error:
                raise Ended(
                    f"the orbit at {self.task.parameter} = {point.value:.9g} was lost on a new mesh: {error}"
                ) from None
        return place

    def _require_motion(self, sample: Sample) -> None:
        """Raise Ended where an orbit of an autonomous system has shrunk to a state of rest, or passed through one."""
        if has_shrunk(self.sample.orbit, sample.orbit, self.measure.scale):
            value, error = self._rest(sample)
            where = f"{self.task.parameter} = {value:.9g} +- {error:.1g}"
            raise Ended(f"the orbit shrinks to a state of rest ({HOPF}) near {where}")

    def _rest(self, sample: Sample) -> tuple[float, float]:
        """Return the value of the parameter where the orbit has shrunk to nothing, and its error."""
        # About a Hopf point the parameter is a power series p = p_0 + c_1 s + c_2 s^2 + ... of the mean square s of the
        # motion (J. E. Marsden and M. McCracken, The Hopf Bifurcation and Its Applications, Springer 1976, section 3).
        # p_0 is the parabola through the last three orbits at s = 0; its distance from the line through the last two,
        # c_2 s_1 s_2, is taken as its error, which is of order s^3.  An error e of the states changes s by 2 e sqrt(s).
        last = [(each.value, _mean_square(each.place, self.measure.scale)) for each in (self.sample, sample)]
        (p_1, s_1), (p_2, s_2) = last
        if s_1 == s_2:
            return p_2, abs(p_2 - p_1)
        slope = (p_2 - p_1) / (s_2 - s_1)
        rest = p_2 - slope * s_2
        error = 2.0 * abs(slope) * math.sqrt(s_2) * max(sample.orbit.error, self.sample.orbit.error)
        error += 4.0 * EPS * (abs(p_2) + abs(slope) * s_2)
        if self._behind is None:
            return rest, error + abs(rest - p_2)
        p_0, s_0 = self._behind.point.value, _mean_square(self._behind, self.measure.scale)
        if s_0 in (s_1, s_2):
            return rest, error + abs(rest - p_2)
        curvature = (slope - (p_1 - p_0) / (s_1 - s_0)) / (s_2 - s_0)
        return rest + curvature * s_1 * s_2, error + abs(curvature) * s_1 * s_2


def _mean_square(place: CurvePoint, scale: Floats) -> float:
    """Return the mean square of the motion about its mean over a period, each state as a fraction of its scale."""
    collocation, stages = place.collocation, place.point.stages / scale
    weights = collocation.steps[:, None, None] * gauss(collocation.degree).weights[:, None]
    mean = (weights * stages).sum(axis=(0, 1))
    return float((weights * (stages - mean) ** 2).sum())
