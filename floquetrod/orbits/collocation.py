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
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod.equations.nonlinear_system import NonlinearSystem
from floquetrod.orbits import bordered, kernels
from floquetrod.orbits.kernels import gauss_points, interval_cycle, machine_code, machine_code_in_use

_LEAST_SCALE = 1e-6  # of a state, part of the largest
_MOST_ITERATIONS = 8
_ROUNDING = 16.0 * EPS  # of a change of the states
_FEW = 8  # systems with other values of the parameter that are cached
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
        n = self.nodes.shape[1]
        run = machine_code_in_use(gauss_points.largest_fill)
        if run is not None:
            sizes = np.empty(n)
            run(self.nodes, self.stages, _LEAST_SCALE, sizes)
            return sizes
        every = np.concatenate([self.nodes, self.stages.reshape(-1, n)])
        sizes = np.maximum(every.max(axis=0), -every.min(axis=0))
        return np.asarray(np.maximum(sizes, max(_LEAST_SCALE * float(sizes.max()), 1e-150)))


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
    rates: Floats  # (N, m, n), f at the Gauss points
    jacobians: Floats  # (N, m, n, n), its derivatives
    matrices: Floats  # (N, m n, m n), of the equations at the Gauss points of each interval, factored or not
    pivots: NDArray[np.int64] | None  # (N, m n), rows exchanged in factored matrices; None where they are not factored
    drives: Floats  # (N, m, n, S), how each free scalar changes the rates in physical time, at the Gauss points


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

    @cached_property
    def scalars(self) -> tuple[str, ...]:
        """Names of the free scalars, in their order, such as "period", "parameter"."""
        return (*(() if self.turns else ("period",)), *(() if self.parameter is None else ("parameter",)))

    @cached_property
    def steps(self) -> Floats:
        """Lengths of the intervals (N,)."""
        return np.diff(self.mesh)

    @cached_property
    def shares(self) -> Floats:
        """Places of the Gauss points in the period (N, m)."""
        return self.mesh[:-1, None] + self.steps[:, None] * gauss(self.degree).points

    @cached_property
    def weights(self) -> Floats:
        """Weights (N,) of the mesh in means over the period, which sum to 1."""
        return np.asarray(0.5 * (self.steps + np.roll(self.steps, 1)))

    def system_at(self, value: float) -> NonlinearSystem:
        """Return the system with this value of the unknown parameter."""
        if self.parameter is None:
            return self.system
        system = self._systems.get(value)
        if system is None:
            if len(self._systems) >= _FEW:
                self._systems.clear()
            system = self._systems[value] = self.system.with_parameters(**{self.parameter: value})
        return system

    @cached_property
    def _systems(self) -> dict[float, NonlinearSystem]:
        """Systems with recent values of the parameter, by value."""
        return {}

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
        return self._of(point, self.system.evaluated.values)

    def jacobians(self, point: Point) -> Floats:
        """Return the derivatives of f at the Gauss points (N, m, n, n)."""
        return self._of(point, self.system.evaluated.derivatives)

    def _of(self, point: Point, call: Callable[[Floats, Floats, Mapping[str, float]], Floats]) -> Floats:
        times, states = (point.period * self.shares).ravel(), point.stages.reshape(-1, point.nodes.shape[1])
        values = call(times, states, self._parameters(point.value))
        # Read-only arrays, of functions that are constant, would let kernels be compiled once more.
        return np.require(values.reshape(*self.shares.shape, *values.shape[1:]), requirements="W")

    def rates_at_mesh(self, point: Point) -> Floats:
        """Return f at the beginnings of the intervals (N, n)."""
        times, parameters = point.period * self.mesh[:-1], self._parameters(point.value)
        return self.system.evaluated.values(times, point.nodes, parameters)

    def _parameters(self, value: float) -> Mapping[str, float]:
        """Return the parameters with this value of the unknown one."""
        known = self.system.parameters
        return known if self.parameter is None else {**known, self.parameter: value}

    def by_parameter(self, point: Point) -> Floats:
        """Return the derivative of period times f with the parameter, per period, at the Gauss points (N, m, n)."""
        step = _PARAMETER_STEP * max(abs(point.value), 1e-3)
        states = point.stages.reshape(-1, point.nodes.shape[1])
        evaluated = self.system.evaluated
        sides: list[Floats] = []
        for value in (point.value - step, point.value + step):
            period = self.period_at(point._replace(value=value)) if self.turns else point.period
            times = (period * self.shares).ravel()
            sides.append(period * evaluated.values(times, states, self._parameters(value)))
        return np.asarray((sides[1] - sides[0]).reshape(point.stages.shape) / (2.0 * step * point.period))

    def residual(self, point: Point, rates: Floats | None = None) -> Floats:
        """Return by how much the equations are missed, at the Gauss points and the ends of intervals (N, m + 1, n)."""
        method, rates = gauss(self.degree), self.rates(point) if rates is None else rates
        lengths = point.period * self.steps
        missed = np.empty((len(point.nodes), self.degree + 1, point.nodes.shape[1]))
        run = self.machine_code_of(gauss_points.residual_fill, point)
        if run is not None:
            given = lengths, method.integrals, method.weights, point.nodes, point.stages, rates
            run(*given, self._growth(point.nodes.shape[1]), missed)
            return missed
        moved = lengths[:, None, None] * (method.integrals @ rates)
        missed[:, :-1] = point.stages - point.nodes[:, None] - moved
        ends = np.roll(point.nodes, -1, axis=0)
        if self.winding:
            ends[-1] += self.winding
        missed[:, -1] = ends - point.nodes - lengths[:, None] * (method.weights @ rates)
        return missed

    def _growth(self, order: int) -> Floats:
        """Return by how much each state grows in a period (n,)."""
        return np.array(self.winding) if self.winding else np.zeros(order)

    def linearised(
        self,
        point: Point,
        rates: Floats | None = None,
        residual: Floats | None = None,
        by_parameter: Floats | None = None,
    ) -> Condensed:
        """Return the residual and the Jacobian matrix, condensed to the mesh.

        Rates, residual and derivatives with the parameter are computed where they are not known.
        """
        jacobians = self.jacobians(point)
        rates = self.rates(point) if rates is None else rates
        residual = self.residual(point, rates) if residual is None else residual
        drives = self._drives(point, rates, by_parameter)
        run = self.machine_code_of(gauss_points.condense_fill, point)
        way = self._condensed_together if run is None else functools.partial(self._condensed_by, run)
        return way(point.period * self.steps, residual, rates, jacobians, drives)

    def _condensed_by(
        self,
        run: Callable[..., Any],
        lengths: Floats,
        residual: Floats,
        rates: Floats,
        jacobians: Floats,
        drives: Floats,
    ) -> Condensed:
        """Return the equations condensed by the kernel, interval by interval."""
        method, (count, m, n, scalars) = gauss(self.degree), drives.shape
        matrices, pivots = np.empty((count, m * n, m * n)), np.empty((count, m * n), dtype=np.int64)
        inner = np.empty((count, m * n, n + 1 + scalars))
        maps, gaps, columns = np.empty((count, n, n)), np.empty((count, n)), np.empty((count, n, scalars))
        ends = maps, gaps, columns
        if run(lengths, method.integrals, method.weights, jacobians, drives, residual, matrices, pivots, inner, *ends):
            raise np.linalg.LinAlgError("singular")
        changes = inner.reshape(count, m, n, n + 1 + scalars)
        return Condensed(maps, gaps, columns, changes, residual, rates, jacobians, matrices, pivots, drives)

    def _condensed_together(
        self, lengths: Floats, residual: Floats, rates: Floats, jacobians: Floats, drives: Floats
    ) -> Condensed:
        """Return the equations condensed by LAPACK, all intervals at once."""
        method, (count, m, n, scalars) = gauss(self.degree), drives.shape
        lengths = lengths[:, None, None]
        shares = (-lengths * method.integrals)[:, :, None, :, None]
        matrices: Floats = (shares * jacobians.transpose(0, 2, 1, 3)[:, None]).reshape(count, m * n, m * n)
        matrices[:, np.arange(m * n), np.arange(m * n)] += 1.0
        right = np.empty((count, m, n, n + 1 + scalars))
        right[..., :n] = np.eye(n)
        right[..., n] = -residual[:, :-1]
        flat = drives.reshape(count, m, n * scalars)
        right[..., n + 1 :] = (lengths * (method.integrals @ flat)).reshape(drives.shape)
        changes = np.linalg.solve(matrices, right.reshape(count, m * n, -1))
        weighed = (method.weights[:, None, None] * jacobians).transpose(0, 2, 1, 3).reshape(count, n, m * n)
        bent = lengths * (weighed @ changes)
        bent[:, :, n + 1 :] += lengths * (method.weights @ flat).reshape(count, n, scalars)
        maps = bent[:, :, :n] + np.eye(n)
        gaps = bent[:, :, n] - residual[:, -1]
        inner = np.asarray(changes.reshape(right.shape), dtype=np.float64)
        return Condensed(maps, gaps, bent[:, :, n + 1 :], inner, residual, rates, jacobians, matrices, None, drives)

    def settled(self, point: Point) -> tuple[Point, Floats, Floats]:
        """Return a point whose states at the Gauss points satisfy the equations from its states at the mesh.

        With the rates and the residual there.  By iteration, as far as it contracts: where intervals are short enough,
        it does so by several digits a time.
        """
        before, scale = np.inf, point.scale
        with np.errstate(all="ignore"):
            rates = self.rates(point)
            residual = self.residual(point, rates)
            for _ in range(_MOST_ITERATIONS):
                change = float((np.abs(residual[:, :-1]) / scale).max())
                if not _ROUNDING < change < 0.3 * before:
                    break
                trial = point._replace(stages=point.stages - residual[:, :-1])
                there = self.rates(trial)
                point, rates, residual, before = trial, there, self.residual(trial, there), change
        return point, rates, residual

    def recondensed(self, condensed: Condensed, point: Point, rates: Floats, residual: Floats) -> Condensed:
        """Return the equations of the chord method: the residual at another point, the same matrices."""
        method, (count, m, n) = gauss(self.degree), rates.shape
        lengths, inner = point.period * self.steps, condensed.inner.copy()
        run = None if condensed.pivots is None else machine_code(gauss_points.constants_fill)
        if run is None or condensed.pivots is None:
            changes = np.linalg.solve(condensed.matrices, -residual[:, :-1].reshape(count, m * n, 1))
            weighed = (
                (method.weights[:, None, None] * condensed.jacobians).transpose(0, 2, 1, 3).reshape(count, n, m * n)
            )
            gaps = (lengths[:, None, None] * (weighed @ changes))[:, :, 0] - residual[:, -1]
        else:
            changes, gaps = np.empty((count, m * n, 1)), np.empty((count, n))
            run(
                lengths,
                method.weights,
                condensed.jacobians,
                residual,
                condensed.matrices,
                condensed.pivots,
                changes,
                gaps,
            )
        inner[..., n] = changes.reshape(count, m, n)
        return condensed._replace(gaps=gaps, inner=inner, residual=residual, rates=rates)

    def machine_code_of(self, function: Callable[..., Any], point: Point) -> Callable[..., Any] | None:
        """Return the machine code of a kernel for a branch of few equations; None where LAPACK does its work."""
        few = self.parameter is not None and point.nodes.shape[1] <= kernels.MOST_EQUATIONS
        return machine_code(function) if few else None

    def _drives(self, point: Point, rates: Floats, by_parameter: Floats | None) -> Floats:
        """Return how each free scalar changes the rates of change in physical time (N, m, n, S)."""
        drives = np.empty((*rates.shape, len(self.scalars)))
        if not self.turns:
            np.divide(rates, point.period, out=drives[..., 0])
        if self.parameter is not None:
            drives[..., -1] = self.by_parameter(point) if by_parameter is None else by_parameter
        return drives

    def phase(self, reference: Point, scale: Floats | None = None, flow: Floats | None = None) -> BorderRow:
        """Return the phase condition: the mean distance from a reference orbit, along its velocity, is zero.

        ``scale`` (n,) holds a unit for each state, by default ``reference.scale``; along a branch it must not change
        where a state passes through zero.  ``flow`` (N, n) is the velocity at the mesh, if it is known.
        """
        scale = reference.scale if scale is None else scale
        scaled = self.weights[:, None] * (self.rates_at_mesh(reference) if flow is None else flow) / scale
        nodes = scaled / (scale * math.sqrt(float(np.vdot(scaled, scaled))))
        return BorderRow(nodes, np.zeros(len(self.scalars)), float(np.vdot(nodes, reference.nodes)))

    def values(self, point: Point) -> Floats:
        """Return the free scalars of a point (S,)."""
        every = {"period": point.period, "parameter": point.value}
        return np.array([every[name] for name in self.scalars])

    def solved(
        self, condensed: Condensed, rows: Sequence[BorderRow], point: Point, scale: Floats | None = None
    ) -> Step:
        """Return the step of Newton's method at a point; `numpy.linalg.LinAlgError` where there is none.

        ``scale`` (n,) is the scale of the states at the point, if it is known.
        """
        scalars = self.values(point)
        missed = [row.target - (np.vdot(row.nodes, point.nodes) + np.vdot(row.scalars, scalars)) for row in rows]
        return self._step(
            condensed, rows, point.scale if scale is None else scale, condensed.gaps, np.array(missed), 1.0
        )

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
        run = machine_code(interval_cycle.bordered_fill) if condensed.pivots is not None else None
        if run is not None:
            border = self._border(condensed, rows)
            return bordered.solve_by(run, condensed.maps, condensed.columns, gaps, *border, targets, scale)[:2]
        solution, units = self._bordered(condensed, rows, scale, gaps, targets)
        return solution.nodes * scale[:, None], solution.scalars * units[:, None]

    def kernel(self, condensed: Condensed, rows: Sequence[BorderRow], scale: Floats) -> Step:
        """Return the change that the linearised equations and the rows leave alone, or nearly so."""
        gaps, targets = np.zeros((*condensed.gaps.shape, 1)), np.zeros((len(rows), 1))
        solution, units = self._bordered(condensed, rows, scale, gaps, targets)
        nodes, scalars = solution.kernel
        return self._with_stages(condensed, nodes * scale, scalars * units, 0.0)

    def _border(self, condensed: Condensed, rows: Sequence[BorderRow]) -> tuple[Floats, Floats]:
        """Return the factors of the states (S, N, n) and of the scalars (S, S) in rows."""
        ties = np.array([row.nodes for row in rows]).reshape(len(rows), *condensed.gaps.shape)
        return ties, np.array([row.scalars for row in rows]).reshape(len(rows), len(self.scalars))

    def _bordered(
        self, condensed: Condensed, rows: Sequence[BorderRow], scale: Floats, gaps: Floats, targets: Floats
    ) -> tuple[bordered.BorderedSolution, Floats]:
        """Return the solution in components, scalars and rows of size 1, and the units of the scalars."""
        ties, corner = self._border(condensed, rows)
        balanced = bordered.balanced(ties * scale, corner, condensed.columns / scale[:, None])
        solution = bordered.solve(
            condensed.maps * scale / scale[:, None],
            balanced.columns,
            gaps / scale[:, None],
            balanced.rows,
            balanced.corner,
            targets * balanced.sizes[:, None],
        )
        return solution, balanced.units

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
        run = machine_code(interval_cycle.bordered_fill) if condensed.pivots is not None else None
        if run is not None:
            given = condensed.maps, condensed.columns, gaps[:, :, None], *self._border(condensed, rows)
            at_mesh, free, stages = bordered.solve_by(run, *given, targets[:, None], scale, condensed.inner, constant)
            if stages is None:
                return self._with_stages(condensed, at_mesh[:, :, 0], free[:, 0], constant)
            return Step(at_mesh[:, :, 0], stages, free[:, 0])
        nodes, scalars = self.responses(condensed, rows, scale, gaps[:, :, None], targets[:, None])
        return self._with_stages(condensed, nodes[:, :, 0], scalars[:, 0], constant)

    @staticmethod
    def _with_stages(condensed: Condensed, nodes: Floats, scalars: Floats, constant: float) -> Step:
        """Return a step at the Gauss points, too, from that at the mesh."""
        n, factors = nodes.shape[1], condensed.inner
        shares = np.empty((len(nodes), factors.shape[3], 1))
        shares[:, :n, 0], shares[:, n, 0], shares[:, n + 1 :, 0] = nodes, constant, scalars
        stages = factors.reshape(len(nodes), -1, factors.shape[3]) @ shares
        return Step(nodes, stages.reshape(factors.shape[:3]), scalars)

    def moved(self, point: Point, step: Step, share: float = 1.0) -> Point:
        """Return the point after a share of a step."""
        scalars = dict(zip(self.scalars, (share * step.scalars).tolist(), strict=True))
        there = Point(
            point.nodes + share * step.nodes,
            point.stages + share * step.stages,
            point.period + scalars.get("period", 0.0),
            point.value + scalars.get("parameter", 0.0),
        )
        return there._replace(period=self.period_at(there)) if self.turns else there
