"""Periodic orbits of x' = f(t, x, p) discretised: collocation at Gauss points on a mesh, made for continuation.

The interface, for Newton's method and for whatever follows orbits:

- `Collocation(system, mesh, degree, turns, parameter)`: the equations on a mesh of N intervals of the unit circle, with
  ``degree`` points in each.  ``turns`` is the number of the system's periods in one of the orbit, None where it is
  autonomous; ``parameter`` names one that is unknown, None where none is.
- `Point`: the unknowns: states at the mesh, states at the Gauss points, the period, and the value of the parameter.
- ``collocation.linearised(point)`` is the residual and the Jacobian matrix, condensed to the mesh: `Condensed` with
  the map of each interval, the gaps, and the columns of the free scalars, the period (of an autonomous system) and the
  parameter, in this order (``collocation.scalars`` names them).
- `BorderRow`: one scalar equation that ties everything together, a phase condition or an arclength; there must be as
  many rows as free scalars.  `collocation.phase(reference)` is the phase condition.
- ``collocation.solved(condensed, rows, point)`` is the step of Newton's method, ``collocation.moved(point, step)`` the
  point after it, and ``collocation.tangent(point, rows)`` the direction in which a branch goes on: the solution of the
  linearised equations whose last row grows at rate 1.
- `floquetrod.orbits.newton.corrected(collocation, point, rows)` iterates; `floquetrod.orbits.orbit_mesh` moves a point
  to another mesh or degree; `floquetrod.orbits.finding.orbit_of(collocation, point)` refines the mesh until the error
  is small, states that error, and returns a `PeriodicOrbit`.

Source: U. M. Ascher, R. M. M. Mattheij and R. D. Russell, Numerical Solution of Boundary Value Problems for Ordinary
Differential Equations, SIAM 1995, doi:10.1137/1.9781611971231.

Unit of the mesh: the orbit's period, so that time is t = period s, 0 <= s <= 1.  States in the unit of the system.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.equations.nonlinear_system import NonlinearSystem
from floquetrod.orbits import bordered

_PARAMETER_STEP = 1e-5  # of central differences in a parameter, relative: good to about 10 digits


class Gauss(NamedTuple):
    """The Runge-Kutta method of Gauss on the unit interval."""

    points: Floats  # (m,)
    weights: Floats  # (m,)
    integrals: Floats  # (m, m), integrals of the Lagrange polynomials up to each point
    to_series: Floats  # (m + 1, m + 1), from values at 0 and at the points to coefficients of Legendre polynomials


@functools.cache
def gauss(degree: int) -> Gauss:
    """Return the method with this number of points."""
    from numpy.polynomial import legendre

    points, weights = legendre.leggauss(degree)
    values = legendre.legvander(points, degree - 1)
    series = np.linalg.inv(values)  # from values at the points to coefficients
    integrated = np.stack([legendre.legval(points, legendre.legint(c, lbnd=-1.0)) for c in np.eye(degree)], axis=1)
    places = np.concatenate([[-1.0], points])
    to_series = np.linalg.inv(legendre.legvander(places, degree))
    return Gauss(0.5 * (points + 1.0), 0.5 * weights, 0.5 * integrated @ series, to_series)


def weights_at(degree: int, shares: Floats) -> Floats:
    """Return the factors (k, m + 1) of the values at 0 and at the Gauss points in the polynomial at shares of it."""
    from numpy.polynomial import legendre

    return np.asarray(legendre.legvander(2.0 * shares - 1.0, degree) @ gauss(degree).to_series)


class Point(NamedTuple):
    """The unknowns of an orbit on a mesh."""

    nodes: Floats  # (N, n), states at the beginnings of the intervals, that of the first at the end of the last, too
    stages: Floats  # (N, m, n), states at the Gauss points
    period: float
    value: float = 0.0  # of the unknown parameter; 0 where there is none

    @property
    def scale(self) -> Floats:
        """What errors of each component are compared with, its largest magnitude, not less than 1e-6 of them all."""
        sizes = np.maximum(np.abs(self.nodes).max(axis=0), np.abs(self.stages).max(axis=(0, 1)))
        return np.asarray(np.maximum(sizes, max(1e-6 * float(sizes.max()), 1e-150)))


class BorderRow(NamedTuple):
    """The equation sum(nodes * x) + scalars . s = target, of the states x at the mesh and the free scalars s."""

    nodes: Floats
    scalars: Floats
    target: float


class Condensed(NamedTuple):
    """The linearised equations with the Gauss points eliminated, for changes dx and ds: dx_(i+1) - maps_i dx_i =
    gaps_i + columns_i ds.
    """

    maps: Floats  # (N, n, n), over each interval, of the linearised equations
    gaps: Floats  # (N, n), minus the residual at the ends of the intervals
    columns: Floats  # (N, n, S), of the free scalars
    inner: Floats  # (N, m, n, n + 1 + S), changes at the Gauss points: factors of dx_i, the constant, factors of ds
    residual: Floats  # (N, m + 1, n), at the Gauss points, and at the ends of the intervals


class Step(NamedTuple):
    """Changes of the unknowns: at the mesh (N, n), at the Gauss points (N, m, n), and of the free scalars (S,)."""

    nodes: Floats
    stages: Floats
    scalars: Floats


@dataclass(frozen=True, eq=False)
class Collocation(ByContent):
    """The equations of a periodic orbit on a mesh."""

    system: NonlinearSystem
    mesh: Floats  # (N + 1,), from 0 to 1, increasing
    degree: int  # Gauss points in each interval
    turns: int | None  # periods of the system in one of the orbit; None where the system is autonomous
    parameter: str | None = None  # name of a parameter that is unknown
    winding: tuple[float, ...] = ()  # by how much each state grows in a period (n,), such as 2 pi; () where none does

    @property
    def scalars(self) -> tuple[str, ...]:
        """Names of the free scalars, in their order, such as "period", "parameter"."""
        return (*(() if self.turns else ("period",)), *(() if self.parameter is None else ("parameter",)))

    @property
    def steps(self) -> Floats:
        """Lengths of the intervals (N,)."""
        return np.diff(self.mesh)

    @property
    def shares(self) -> Floats:
        """Places of the Gauss points in the period (N, m)."""
        return self.mesh[:-1, None] + self.steps[:, None] * gauss(self.degree).points

    @property
    def weights(self) -> Floats:
        """Weights (N,) of the mesh in means over the period, which sum to 1."""
        return np.asarray(0.5 * (self.steps + np.roll(self.steps, 1)))

    def system_at(self, value: float) -> NonlinearSystem:
        """Return the system with this value of the unknown parameter."""
        return self.system if self.parameter is None else self.system.with_parameters(**{self.parameter: value})

    def with_value(self, value: float) -> Collocation:
        """Return the equations with this value of the parameter, which is known then."""
        return replace(self, system=self.system_at(value), parameter=None)

    def period_at(self, point: Point) -> float:
        """Return the period of a point: its own, or as many of the system's as the orbit takes."""
        if not self.turns:
            return point.period
        period = self.system_at(point.value).period
        return float(self.turns * (np.nan if period is None else period))

    def rates(self, point: Point) -> Floats:
        """Return f at the Gauss points (N, m, n)."""
        return self._of(point, self.system_at(point.value).rates)

    def jacobians(self, point: Point) -> Floats:
        """Return the derivatives of f at the Gauss points (N, m, n, n)."""
        return self._of(point, self.system_at(point.value).jacobians)

    def _of(self, point: Point, call: Callable[[Floats, Floats], Floats]) -> Floats:
        n = point.nodes.shape[1]
        values = call((point.period * self.shares).ravel(), point.stages.reshape(-1, n))
        return np.asarray(values.reshape(*self.shares.shape, *values.shape[1:]))

    def rates_at_mesh(self, point: Point) -> Floats:
        """Return f at the beginnings of the intervals (N, n)."""
        return np.asarray(self.system_at(point.value).rates(point.period * self.mesh[:-1], point.nodes))

    def by_parameter(self, point: Point) -> Floats:
        """Return the derivative of period times f with the parameter, per period, at the Gauss points (N, m, n)."""
        step = _PARAMETER_STEP * max(abs(point.value), 1e-3)
        values = []
        for share in (-1.0, 1.0):
            other = point._replace(value=point.value + share * step)
            other = other._replace(period=self.period_at(other))
            values.append(other.period * self.rates(other))
        return np.asarray((values[1] - values[0]) / (2.0 * step * point.period))

    def residual(self, point: Point, rates: Floats | None = None) -> Floats:
        """Return by how much the equations are missed, at the Gauss points and the ends of intervals (N, m + 1, n)."""
        method, rates = gauss(self.degree), self.rates(point) if rates is None else rates
        lengths = point.period * self.steps
        missed = np.empty((len(point.nodes), self.degree + 1, point.nodes.shape[1]))
        moved = lengths[:, None, None] * (method.integrals @ rates)
        missed[:, :-1] = point.stages - point.nodes[:, None] - moved
        ends = np.roll(point.nodes, -1, axis=0)
        if self.winding:
            ends[-1] += self.winding
        missed[:, -1] = ends - point.nodes - lengths[:, None] * np.einsum("k,ikn->in", method.weights, rates)
        return missed

    def linearised(self, point: Point, rates: Floats | None = None) -> Condensed:
        """Return the residual and the Jacobian matrix, condensed to the mesh."""
        method, jacobians = gauss(self.degree), self.jacobians(point)
        rates = self.rates(point) if rates is None else rates
        count, m, n = rates.shape
        residual = self.residual(point, rates)
        lengths = point.period * self.steps
        inner = -(lengths[:, None, None, None, None] * np.einsum("jk,ikab->ijakb", method.integrals, jacobians))
        inner = inner.reshape(count, m * n, m * n)
        inner[:, np.arange(m * n), np.arange(m * n)] += 1.0
        drives = self._drives(point, rates)  # (N, m, n, S), of the right side of x' = f per unit of physical time
        right = np.empty((count, m, n, n + 1 + drives.shape[3]))
        right[..., :n] = np.eye(n)
        right[..., n] = -residual[:, :-1]
        right[..., n + 1 :] = lengths[:, None, None, None] * np.einsum("jk,ikas->ijas", method.integrals, drives)
        changes = np.linalg.solve(inner, right.reshape(count, m * n, -1)).reshape(right.shape)
        bent = lengths[:, None, None] * np.einsum("k,ikab,ikbc->iac", method.weights, jacobians, changes, optimize=True)
        bent[:, :, n + 1 :] += lengths[:, None, None] * np.einsum("k,ikas->ias", method.weights, drives)
        maps = bent[:, :, :n] + np.eye(n)
        return Condensed(maps, bent[:, :, n] - residual[:, -1], bent[:, :, n + 1 :], changes, residual)

    def _drives(self, point: Point, rates: Floats) -> Floats:
        """Return how each free scalar changes the rates of change in physical time (N, m, n, S)."""
        every = {"period": lambda: rates / point.period, "parameter": lambda: self.by_parameter(point)}
        drives = [every[name]() for name in self.scalars]
        return np.stack(drives, axis=-1) if drives else np.zeros((*rates.shape, 0))

    def phase(self, reference: Point, scale: Floats | None = None) -> BorderRow:
        """Return the phase condition: the mean distance from a reference orbit, along its velocity, is zero.

        ``scale`` (n,) holds a unit for each state, by default ``reference.scale``; along a branch it must not change
        where a state passes through zero.
        """
        scale = reference.scale if scale is None else scale
        nodes = self.weights[:, None] * self.rates_at_mesh(reference) / scale**2
        nodes = nodes / np.linalg.norm(nodes * scale)
        return BorderRow(nodes, np.zeros(len(self.scalars)), float((nodes * reference.nodes).sum()))

    def values(self, point: Point) -> Floats:
        """Return the free scalars of a point (S,)."""
        every = {"period": point.period, "parameter": point.value}
        return np.array([every[name] for name in self.scalars])

    def solved(self, condensed: Condensed, rows: Sequence[BorderRow], point: Point) -> Step:
        """Return the step of Newton's method at a point; `numpy.linalg.LinAlgError` where there is none."""
        missed = [
            row.target - float((row.nodes * point.nodes).sum() + row.scalars @ self.values(point)) for row in rows
        ]
        return self._step(condensed, rows, point.scale, condensed.gaps, np.array(missed), 1.0)

    def tangent(self, condensed: Condensed, rows: Sequence[BorderRow], scale: Floats) -> Step:
        """Return the solution of the linearised equations on which the last row grows at rate 1, the others not."""
        targets = np.zeros(len(rows))
        targets[-1] = 1.0
        return self._step(condensed, rows, scale, np.zeros_like(condensed.gaps), targets, 0.0)

    def responses(
        self, condensed: Condensed, rows: Sequence[BorderRow], scale: Floats, gaps: Floats, targets: Floats
    ) -> tuple[Floats, Floats]:
        """Return the changes at the mesh (N, n, q) and of the free scalars (S, q) that q gaps and targets ask for.

        Gaps (N, n, q) in the unit of the states, targets (S, q).
        """
        solution, units = self._bordered(condensed, rows, scale, gaps, targets)
        return solution.nodes * scale[:, None], solution.scalars * units[:, None]

    def kernel(self, condensed: Condensed, rows: Sequence[BorderRow], scale: Floats) -> Step:
        """Return the change that the linearised equations and the rows leave alone, or nearly so."""
        gaps, targets = np.zeros((*condensed.gaps.shape, 1)), np.zeros((len(rows), 1))
        solution, units = self._bordered(condensed, rows, scale, gaps, targets)
        nodes, scalars = solution.kernel
        return self._with_stages(condensed, nodes * scale, scalars * units, 0.0)

    def _bordered(
        self, condensed: Condensed, rows: Sequence[BorderRow], scale: Floats, gaps: Floats, targets: Floats
    ) -> tuple[bordered.BorderedSolution, Floats]:
        """Return the solution in components, scalars and rows of size 1, and the units of the scalars."""
        count, n = gaps.shape[:2]
        ties = np.array([row.nodes * scale for row in rows]).reshape(len(rows), count, n)
        corner = np.array([row.scalars for row in rows]).reshape(len(rows), len(self.scalars))
        columns = condensed.columns / scale[:, None]
        # Where an orbit does not depend on the parameter its column is rounding; the rows tell its unit then.
        ends = np.abs(corner).max(axis=0, initial=0.0)
        units = 1.0 / np.maximum(np.maximum(np.abs(columns).sum(axis=(0, 1)), ends), 1e-300)
        sizes = 1.0 / np.maximum(np.abs(ties).sum(axis=(1, 2)) + np.abs(corner * units).sum(axis=1), 1e-300)
        solution = bordered.solve(
            condensed.maps * scale / scale[:, None],
            columns * units,
            gaps / scale[:, None],
            ties * sizes[:, None, None],
            corner * units * sizes[:, None],
            targets * sizes[:, None],
        )
        return solution, units

    def _step(
        self,
        condensed: Condensed,
        rows: Sequence[BorderRow],
        scale: Floats,
        gaps: Floats,
        targets: Floats,
        constant: float,
    ) -> Step:
        """Return the solution of the linearised equations, at the Gauss points too."""
        nodes, scalars = self.responses(condensed, rows, scale, gaps[:, :, None], targets[:, None])
        return self._with_stages(condensed, nodes[:, :, 0], scalars[:, 0], constant)

    @staticmethod
    def _with_stages(condensed: Condensed, nodes: Floats, scalars: Floats, constant: float) -> Step:
        """Return a step at the Gauss points, too, from that at the mesh."""
        n, factors = nodes.shape[1], condensed.inner
        stages = np.einsum("ijab,ib->ija", factors[..., :n], nodes) + constant * factors[..., n]
        return Step(nodes, stages + factors[..., n + 1 :] @ scalars, scalars)

    def moved(self, point: Point, step: Step, share: float = 1.0) -> Point:
        """Return the point after a share of a step."""
        scalars = dict(zip(self.scalars, (share * step.scalars).tolist(), strict=True))
        there = Point(
            point.nodes + share * step.nodes,
            point.stages + share * step.stages,
            point.period + scalars.get("period", 0.0),
            point.value + scalars.get("parameter", 0.0),
        )
        return there._replace(period=self.period_at(there))
