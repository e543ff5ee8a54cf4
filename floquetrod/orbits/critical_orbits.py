"""Orbits with a multiplier on the unit circle, two parameters unknown: equations and Newton's method.

Beside the equations of the orbit x, its period T and the parameters a and b, a number g must vanish that is zero where
the linearised equations V' = T A(s) V + v f, V(1) = rho V(0), have a solution, with s the time in periods:

| kind | rho | unknown beside x, T, a, b | equations beside the orbit's |
| --- | --- | --- | --- |
| fold | 1 | | g |
| period doubling | -1 | | g |
| Neimark-Sacker | exp(i angle) | angle | the real and the imaginary part of g |
| branch point | 1 | e, by which the orbit's equations are missed | g, and h |

v, the change of the period, is there for autonomous systems and rho = 1.  With vectors l and r near the left and the
right null vector, g is the last unknown of the bordered equations

    [L  l] [V]   [0]
    [r* 0] [g] = [1],

regular on the whole curve (W. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, SIAM 2000,
doi:10.1137/1.9780898719543, chapters 3 and 4; E. J. Doedel, W. Govaerts and Yu. A. Kuznetsov, SIAM J. Numer. Anal. 41
(2003) 401, doi:10.1137/S0036142902400779).  h is the same unknown where the right side is, in place of (0, 1), the
change of the orbit's equations along a direction in the plane of the parameters.  With w, the solution of the
transposed equations, dg = w . d(L) V: its derivatives need second derivatives of f along V only.

At a branch point the orbits of the branch exist for all a and b near the curve, as symmetry or an invariant plane has
it, and e is zero; elsewhere branches that cross part for other values, and there is no such curve.

Nodes of vectors are scaled by the states' magnitudes, the period by itself, the parameters by their ranges.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.orbits import bordered, orbit_mesh
from floquetrod.orbits.arclength import MOST_STEPS
from floquetrod.orbits.collocation import Collocation, Condensed, Point, gauss
from floquetrod.orbits.newton import ENOUGH, NEARLY, NoOrbitError
from floquetrod.orbits.special_points import Kind

_STEP = 1e-5  # of central differences along V and in the parameters, relative
_SECOND_STEP = 1e-4  # of central differences in the parameters of quantities that are differences themselves, relative
_LARGEST = 1e6  # of a step of Newton's method, relative, beyond which it is given up
_SMALLEST = 1e-6  # change of the equations by a scalar, relative: smaller ones are rounding, they do not depend on it

Values = tuple[float, float]


class CriticalOrbit(NamedTuple):
    """An orbit, its parameters known, and the angle of a pair, or e of a branch point."""

    collocation: Collocation  # of the system with the values of both parameters
    point: Point
    extra: float  # angle of the multiplier; at branch points e; else 0

    @property
    def system(self) -> Any:
        """The system with the values of both parameters."""
        return self.collocation.system


class Vector(NamedTuple):
    """A change of the unknowns, scaled: at the mesh (N, n), and of the scalars (S,)."""

    nodes: Floats
    scalars: Floats


class Borders(NamedTuple):
    """The vectors l (N, q) and r, (N, q) and (1,) for the period or (0,); q = n, or 2 n for real and imaginary part."""

    left: Floats
    right: Floats
    period: Floats


class Linear(NamedTuple):
    """The linearised equations of a critical orbit, scaled, for steps ds of the scalars."""

    maps: Floats  # (N, n, n)
    columns: Floats  # (N, n, S)
    gaps: Floats  # (N, n)
    inner: Floats  # (N, m, n, n + 1 + S), changes at the Gauss points, in the unit of the states
    units: Floats  # (S,)
    rows: Floats  # (S - 1, N, n), all but the last
    corner: Floats  # (S - 1, S)
    targets: Floats  # (S - 1,)
    condensed: Condensed
    borders: Borders  # the null vectors, for the next step
    blur: Floats  # (N, n, n), weights of errors of the maps in g
    rate: float  # magnitude of the derivative of g with the logarithm of the critical multiplier


class Solved(NamedTuple):
    """A critical orbit, the direction in which the curve goes on, and the equations there."""

    orbit: CriticalOrbit
    direction: Vector
    linear: Linear
    steps: int


class _Null(NamedTuple):
    """Solutions of the bordered equations and of the transposed ones: one for each of g and h, or parts of g."""

    nodes: Floats  # (N, q, 2 or 1)
    period: Floats  # (2 or 1,)
    defects: Floats  # values of g and h, or the parts of g
    left: Floats  # (N, q, 1 or 2)


@dataclass(frozen=True, eq=False)
class CriticalEquations(ByContent):
    """Equations of critical orbits of a kind, with two parameters by name, their ranges, and magnitudes of states."""

    kind: Kind
    names: tuple[str, str]
    widths: Values
    scale: Floats  # (n,)
    across: Values = (1.0, 0.0)  # direction in the plane of the parameters, scaled, of h

    def values(self, orbit: CriticalOrbit) -> Values:
        """Return the values of both parameters."""
        first, second = (float(orbit.system.parameters[name]) for name in self.names)
        return first, second

    def scalars(self, orbit: CriticalOrbit) -> tuple[str, ...]:
        """Return the names of the scalars, in their order."""
        period = () if orbit.collocation.turns else ("period",)
        extra = () if self.kind in ("fold", "period doubling") else ("extra",)
        return (*period, *self.names, *extra)

    def begun(self, orbit: CriticalOrbit) -> Borders:
        """Return borders for an orbit that is critical, or nearly so."""
        maps, columns, rows = self._null_problem(orbit, *self._condensed(orbit))
        scalars, (count, q) = columns.shape[2], maps.shape[:2]
        nothing = np.zeros((count, q, 1)), np.zeros((scalars, scalars)), np.zeros((scalars, 1))
        right = bordered.solve(maps, columns, nothing[0], rows, *nothing[1:]).kernel
        given = _transposed(maps, columns, rows, nothing[1])
        left = bordered.solve(given[0], given[1], nothing[0], given[2], given[3], nothing[2]).kernel
        return _normal(Borders(left[0][::-1], right[0], right[1]))

    def corrected(
        self,
        orbit: CriticalOrbit,
        borders: Borders,
        direction: Vector | None = None,
        pinned: tuple[str, float] | None = None,
    ) -> Solved:
        """Return the critical orbit near one across a direction, or with one parameter pinned to a value.

        The default direction is along the curve.  Raises NoOrbitError.
        """
        before = np.inf
        with np.errstate(all="ignore"):
            for count in range(1, MOST_STEPS + 1):
                linear = self.linearised(orbit, borders)
                direction = self.tangent(orbit, linear) if direction is None else direction
                row, target = self._last_row(orbit, direction, pinned)
                step, onward = self._solved(orbit, linear, row, target)
                size = self._size(orbit, step)
                if not size < _LARGEST:
                    break
                orbit = self.moved(orbit, linear, step)
                if orbit.point.period <= 0.0:
                    break
                if size <= ENOUGH or (size <= NEARLY and size > 0.3 * before):
                    linear = self.linearised(orbit, borders)
                    return Solved(orbit, self._unit(orbit, onward, direction), linear, count)
                before = size
        raise NoOrbitError(f"Newton's method did not converge to a {self.kind}")

    def product(self, orbit: CriticalOrbit, one: Vector, other: Vector) -> float:
        """Return the product of changes: the mean over the period, and the period, the parameters and the angle."""
        mean = float((orbit.collocation.weights[:, None] * one.nodes * other.nodes).sum())
        return mean + float(one.scalars @ other.scalars)

    def ahead(self, solved: Solved, length: float) -> CriticalOrbit:
        """Return the guess at a length along the direction of the curve."""
        nodes, scalars = (length * part for part in solved.direction)
        return self.moved(solved.orbit, solved.linear, Vector(nodes, scalars), constant=0.0)

    def moved(self, orbit: CriticalOrbit, linear: Linear, step: Vector, constant: float = 1.0) -> CriticalOrbit:
        """Return the orbit after a step."""
        n = len(self.scale)
        nodes, scalars = step.nodes * self.scale, step.scalars * linear.units
        stages = np.einsum("ijab,ib->ija", linear.inner[..., :n], nodes) + constant * linear.inner[..., n]
        stages += linear.inner[..., n + 1 :] @ scalars
        change = dict(zip(self.scalars(orbit), scalars.tolist(), strict=True))
        values = {name: value + change[name] for name, value in zip(self.names, self.values(orbit), strict=True)}
        point = orbit.point._replace(
            nodes=orbit.point.nodes + nodes,
            stages=orbit.point.stages + stages,
            period=orbit.point.period + change.get("period", 0.0),
        )
        return with_values(orbit, point, values)._replace(extra=orbit.extra + change.get("extra", 0.0))

    def carried(
        self, orbit: CriticalOrbit, borders: Borders, direction: Vector, mesh: Floats, degree: int
    ) -> tuple[CriticalOrbit, Borders, Vector]:
        """Return an orbit, borders and a direction on another mesh or of another degree."""
        given = orbit.collocation
        collocation, point = orbit_mesh.carried(given, orbit.point, mesh, degree)
        at = np.clip(np.searchsorted(given.mesh, mesh[:-1], side="right") - 1, 0, len(given.mesh) - 2)
        moved = _normal(Borders(borders.left[at], borders.right[at], borders.period))
        there = orbit._replace(collocation=collocation, point=point)
        return there, moved, direction._replace(nodes=direction.nodes[at])

    def linearised(self, orbit: CriticalOrbit, borders: Borders) -> Linear:
        """Return the linearised equations of a critical orbit."""
        condensed, columns, inner = self._condensed(orbit)
        null = self._null(orbit, borders, condensed, columns)
        scale, point = self.scale, orbit.point
        of_period = [] if orbit.collocation.turns else [point.period]
        extra = [1.0] if "extra" in self.scalars(orbit) else []
        units = np.array([*of_period, *self.widths, *extra])
        gaps, driven = condensed.gaps / scale, columns / scale[:, None]
        if extra:
            column = borders.left if self.kind == "branch point" else np.zeros_like(gaps)
            driven = np.concatenate([driven, column[:, :, None]], axis=2)
            inner = np.concatenate([inner, np.zeros((*inner.shape[:3], 1))], axis=3)
            gaps = gaps + (orbit.extra * column if self.kind == "branch point" else 0.0)
        rows, corner, targets = self._defect_rows(orbit, null, condensed, inner)
        if of_period:
            phase = orbit.collocation.phase(point, scale).nodes * scale
            rows = np.concatenate([phase[None], rows])
            corner = np.concatenate([np.zeros((1, len(units))), corner])
            targets = np.concatenate([[0.0], targets])
        maps = condensed.maps * scale / scale[:, None]
        vectors = _normal(Borders(null.left[:, :, 0], null.nodes[:, :, 0], null.period[:1]))
        left = np.abs(null.left).max(axis=2)
        right = np.abs(null.nodes).max(axis=2)
        if self.kind == "Neimark-Sacker":
            n = len(scale)
            left, right = np.hypot(left[:, :n], left[:, n:]), np.hypot(right[:, :n], right[:, n:])
        blur, rate = left[:, :, None] * right[:, None, :], self._rate(orbit, null, maps)
        corner = corner * units
        return Linear(maps, driven * units, gaps, inner, units, rows, corner, targets, condensed, vectors, blur, rate)

    def _rate(self, orbit: CriticalOrbit, null: _Null, maps: Floats) -> float:
        """Return |dg / d log rho| = |w . V(1) / rho| at the end of the period."""
        n, nodes, left = len(self.scale), null.nodes[-1, :, 0], null.left[-1, :, 0]
        end = self._closing(orbit) @ (nodes.reshape(-1, n) @ maps[-1].T).ravel()
        if self.kind != "Neimark-Sacker":
            return abs(float(left @ end))
        return math.hypot(float(left @ end), float(left @ np.concatenate([end[n:], -end[:n]])))

    def multiplier(self, orbit: CriticalOrbit) -> complex:
        """Return the critical multiplier: 1, -1, or exp(i angle)."""
        if self.kind == "Neimark-Sacker":
            return complex(math.cos(orbit.extra), math.sin(orbit.extra))
        return -1.0 + 0.0j if self.kind == "period doubling" else 1.0 + 0.0j

    def tangent(self, orbit: CriticalOrbit, linear: Linear) -> Vector:
        """Return a direction of the curve of length 1."""
        nothing = Vector(np.zeros_like(linear.gaps), np.zeros(len(linear.units)))
        rows, corner, columns, units, _ = _balanced(linear, nothing)
        count, n = linear.gaps.shape
        right, targets = np.zeros((count, n, 1)), np.zeros((len(units), 1))
        nodes, scalars = bordered.solve(linear.maps, columns, right, rows, corner, targets).kernel
        return self._unit(orbit, Vector(nodes, scalars * units), None)

    def changes(self, solved: Solved, gaps: Floats, blur: float) -> tuple[Floats, Floats]:
        """Return the changes of an orbit and its scalars by gaps (N, n, k) in the equations and by an error of g and h.

        The largest change of a state, relative, (k + 1,), and changes of the scalars (S, k + 1), by the error last.
        """
        linear, direction = solved.linear, solved.direction
        row, _ = self._last_row(solved.orbit, direction, None)
        rows, corner, columns, units, sizes = _balanced(linear, row)
        count, n, k = gaps.shape
        tests = 2 if self.kind in ("Neimark-Sacker", "branch point") else 1
        right = np.concatenate([gaps / self.scale[:, None], np.zeros((count, n, 1))], axis=2)
        targets = np.zeros((len(units), k + 1))
        targets[len(units) - 1 - tests : -1, k] = blur
        solution = bordered.solve(linear.maps, columns, right, rows, corner, targets * sizes[:, None])
        return np.abs(solution.nodes).max(axis=(0, 1)), solution.scalars * (units * linear.units)[:, None]

    def _last_row(
        self, orbit: CriticalOrbit, direction: Vector, pinned: tuple[str, float] | None
    ) -> tuple[Vector, float]:
        """Return the last row and its target: across a direction, or one parameter at a value."""
        if pinned is None:
            return Vector(orbit.collocation.weights[:, None] * direction.nodes, direction.scalars), 0.0
        name, value = pinned
        which = self.names.index(name)
        scalars = np.array([float(each == name) for each in self.scalars(orbit)])
        return Vector(np.zeros_like(direction.nodes), scalars), (value - self.values(orbit)[which]) / self.widths[which]

    def _solved(self, orbit: CriticalOrbit, linear: Linear, last: Vector, target: float) -> tuple[Vector, Vector]:
        """Return the step of Newton's method, and the direction in which the last row grows."""
        rows, corner, columns, units, sizes = _balanced(linear, last)
        right = np.stack([linear.gaps, np.zeros_like(linear.gaps)], axis=2)
        targets = np.zeros((len(units), 2))
        targets[:, 0] = [*linear.targets, target]
        targets[-1, 1] = 1.0
        try:
            found = bordered.solve(linear.maps, columns, right, rows, corner, targets * sizes[:, None])
        except np.linalg.LinAlgError:
            raise NoOrbitError("the equations are singular") from None
        scalars = found.scalars * units[:, None]
        return Vector(found.nodes[:, :, 0], scalars[:, 0]), Vector(found.nodes[:, :, 1], scalars[:, 1])

    def _unit(self, orbit: CriticalOrbit, vector: Vector, like: Vector | None) -> Vector:
        """Return a vector scaled to length 1, its sign such that the product with another is positive."""
        length = math.sqrt(self.product(orbit, vector, vector))
        sign = 1.0 if like is None or self.product(orbit, vector, like) >= 0.0 else -1.0
        return Vector(*(sign / max(length, 1e-300) * part for part in vector))

    def _size(self, orbit: CriticalOrbit, step: Vector) -> float:
        """Return the largest part of a step."""
        return max(float(np.abs(step.nodes).max()), float(np.abs(step.scalars).max()))

    def _condensed(self, orbit: CriticalOrbit) -> tuple[Condensed, Floats, Floats]:
        """Return the linearised equations of the orbit, columns of period and parameters, and the Gauss points."""
        rates = orbit.collocation.rates(orbit.point)
        every = []
        for name, value in zip(self.names, self.values(orbit), strict=True):
            unknown = replace(orbit.collocation, parameter=name)
            every.append(unknown.linearised(orbit.point._replace(value=value), rates))
        first, second = every
        columns = np.concatenate([first.columns, second.columns[:, :, -1:]], axis=2)
        return first, columns, np.concatenate([first.inner, second.inner[..., -1:]], axis=3)

    def _null_problem(
        self, orbit: CriticalOrbit, condensed: Condensed, columns: Floats, inner: Floats | None = None
    ) -> tuple[Floats, Floats, Floats]:
        """Return the maps, the column of the period and the phase condition of the equations of V."""
        scale, n = self.scale, len(self.scale)
        maps = condensed.maps * scale / scale[:, None]
        if self.kind == "Neimark-Sacker":
            double = np.zeros((len(maps), 2 * n, 2 * n))
            double[:, :n, :n] = double[:, n:, n:] = maps
            maps = double
        maps = np.concatenate([maps[:-1], (self._closing(orbit) @ maps[-1])[None]])
        count, q = maps.shape[:2]
        if orbit.collocation.turns or self.kind not in ("fold", "branch point"):
            return maps, np.zeros((count, q, 0)), np.zeros((0, count, q))
        phase = orbit.collocation.phase(orbit.point, scale).nodes * scale
        return maps, columns[:, :, :1] / scale[:, None] * orbit.point.period, phase[None]

    def _closing(self, orbit: CriticalOrbit) -> Floats:
        """Return the matrix 1 / rho that takes V at the end of the period to the beginning."""
        n = len(self.scale)
        if self.kind != "Neimark-Sacker":
            return (-1.0 if self.kind == "period doubling" else 1.0) * np.eye(n)
        c, s = math.cos(orbit.extra), math.sin(orbit.extra)
        return np.kron(np.array([[c, s], [-s, c]]), np.eye(n))

    def _null(self, orbit: CriticalOrbit, borders: Borders, condensed: Condensed, columns: Floats) -> _Null:
        """Return V and the solution of the transposed equations, and the values that must vanish."""
        maps, of_period, rows = self._null_problem(orbit, condensed, columns)
        count, q = maps.shape[:2]
        own = of_period.shape[2]
        every, given = [borders.left], [borders.right]
        if self.kind == "Neimark-Sacker":
            every, given = [borders.left, _turned(borders.left)], [borders.right, _turned(borders.right)]
        wide = np.concatenate([of_period, -np.stack(every, axis=2)], axis=2)
        rows = np.concatenate([rows, np.array(given)])
        size = own + len(every)
        corner = np.zeros((size, size))
        corner[own, :own] = borders.period
        right, targets = np.zeros((count, q, 1)), np.zeros((size, 1))
        targets[own, 0] = 1.0
        if self.kind == "branch point":
            direction = np.array(self.across) * self.widths
            right = np.concatenate([right, (columns[:, :, -2:] @ direction / self.scale)[:, :, None]], axis=2)
            targets = np.concatenate([targets, np.zeros((size, 1))], axis=1)
        found = bordered.solve(maps, wide, right, rows, corner, targets)
        turned, driven, tied, end = _transposed(maps, wide, rows, corner)
        wanted = np.zeros((size, len(every)))
        wanted[own:] = np.eye(len(every))
        left = bordered.solve(turned, driven, np.zeros((count, q, len(every))), tied, end, wanted)
        defects = found.scalars[own:].ravel()
        return _Null(found.nodes, found.scalars[:own].ravel(), defects, left.nodes[::-1])

    def _defect_rows(
        self, orbit: CriticalOrbit, null: _Null, condensed: Condensed, inner: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Return the rows of g and h, or of the parts of g: factors of the nodes and scalars, and targets."""
        rows, corner, targets = [], [], []
        count = len(null.defects)
        n, scale = len(self.scale), self.scale
        names = self.scalars(orbit)
        closing = self._closing(orbit)
        for k in range(count):
            left = null.left[:, :, min(k, null.left.shape[2] - 1)]
            which = min(k, null.nodes.shape[2] - 1)
            nodes = null.nodes[:, :, which]
            last = closing.T @ left[-1]
            weights = np.concatenate([left[:-1], last[None]])
            vector: NDArray[Any] = nodes * np.tile(scale, nodes.shape[1] // n)
            adjoint: NDArray[Any] = weights / np.tile(scale, nodes.shape[1] // n)
            if self.kind == "Neimark-Sacker":
                vector, adjoint = vector[:, :n] + 1j * vector[:, n:], adjoint[:, :n] - 1j * adjoint[:, n:]
            period = float(null.period[which]) * orbit.point.period if null.period.size else 0.0
            driven = self.kind == "branch point" and k == 1
            row, constant, scalars = self._derivative(orbit, vector, adjoint, period, driven, inner)
            if self.kind == "Neimark-Sacker":
                maps = condensed.maps[-1] * scale / scale[:, None]
                end = closing @ np.concatenate([maps @ nodes[-1, :n], maps @ nodes[-1, n:]])
                scalars[names.index("extra")] = left[-1] @ np.concatenate([end[n:], -end[:n]])
            rows.append(row * scale)
            corner.append(scalars)
            targets.append(-null.defects[k] - constant)
        return np.array(rows), np.array(corner), np.array(targets)

    def _derivative(
        self,
        orbit: CriticalOrbit,
        vector: NDArray[Any],
        adjoint: NDArray[Any],
        period: float,
        driven: bool,
        inner: Floats,
    ) -> tuple[Floats, float, Floats]:
        """Return the derivative of Re sum w . column(E), E = T A V + v f, with nodes, by the gaps, and with scalars."""
        n = len(self.scale)
        names = self.scalars(orbit)
        stages = np.einsum("ijab,ib->ija", inner[..., :n], vector)
        if period:
            stages = stages + period * inner[..., n + 1]
        direction = np.array(self.across) * self.widths if driven else np.zeros(2)
        if driven:
            at = names.index(self.names[0])
            stages = stages + inner[..., n + 1 + at : n + 3 + at] @ direction
        factors = self._adjoint_stages(orbit, adjoint)
        matrix = self._second(orbit, stages, period, direction)
        bent = np.real(np.einsum("ija,ijab->ijb", factors, matrix))
        row = np.einsum("ijb,ijbc->ic", bent, inner[..., :n])
        constant = float((bent * inner[..., n]).sum())
        scalars = np.einsum("ijb,ijbs->s", bent, inner[..., n + 1 :])
        for k, name in enumerate(names):
            if name == "period":
                change = self._drive(orbit, stages, 0.0, direction) / orbit.point.period
                scalars[k] += float(np.real(factors * change).sum())
            elif name in self.names:
                which = self.names.index(name)
                step = (_SECOND_STEP if driven else _STEP) * self.widths[which]
                sides = [
                    self._drive(self._shifted(orbit, which, sign * step), stages, period, direction)
                    for sign in (-1.0, 1.0)
                ]
                scalars[k] += float(np.real(factors * (sides[1] - sides[0])).sum()) / (2.0 * step)
        return row, constant, scalars

    def _shifted(self, orbit: CriticalOrbit, which: int, step: float) -> CriticalOrbit:
        """Return the same states with another value of a parameter."""
        name = self.names[which]
        return with_values(orbit, orbit.point, {name: float(orbit.system.parameters[name]) + step})

    def _drive(self, orbit: CriticalOrbit, stages: NDArray[Any], period: float, direction: Floats) -> NDArray[Any]:
        """Return T A V + v f, and the change of T f along a direction of the parameters."""
        point = orbit.point
        drive: NDArray[Any] = point.period * np.einsum("ijab,ijb->ija", orbit.collocation.jacobians(point), stages)
        if period:
            drive = drive + period * orbit.collocation.rates(point)
        if direction.any():
            sides = [self._along(orbit, sign * _SECOND_STEP * direction) for sign in (-1.0, 1.0)]
            every = [side.point.period * side.collocation.rates(side.point) for side in sides]
            drive = drive + (every[1] - every[0]) / (2.0 * _SECOND_STEP)
        return drive

    def _along(self, orbit: CriticalOrbit, shift: Floats) -> CriticalOrbit:
        values = self.values(orbit)
        return with_values(orbit, orbit.point, {name: values[k] + float(shift[k]) for k, name in enumerate(self.names)})

    def _second(self, orbit: CriticalOrbit, stages: NDArray[Any], period: float, direction: Floats) -> NDArray[Any]:
        """Return the derivative of T A V + v f, and of the change along a direction, with the states."""
        collocation, point = orbit.collocation, orbit.point
        total: NDArray[Any] = np.zeros((*stages.shape, stages.shape[2]))
        for part, factor in ((np.real(stages), 1.0), (np.imag(stages), 1j)):
            largest = float((np.abs(part) / self.scale).max())
            if largest == 0.0:
                continue
            step = _STEP / largest
            sides = [collocation.jacobians(point._replace(stages=point.stages + s * step * part)) for s in (-1.0, 1.0)]
            total = total + (factor * point.period / (2.0 * step)) * (sides[1] - sides[0])
        if period:
            total = total + period * collocation.jacobians(point)
        if direction.any():
            ends = [self._along(orbit, sign * _SECOND_STEP * direction) for sign in (-1.0, 1.0)]
            every = [end.point.period * end.collocation.jacobians(end.point) for end in ends]
            total = total + (every[1] - every[0]) / (2.0 * _SECOND_STEP)
        return total

    def _adjoint_stages(self, orbit: CriticalOrbit, adjoint: NDArray[Any]) -> NDArray[Any]:
        """Return factors (N, m, n) of changes of V' at the Gauss points in the sum of w . change at the mesh."""
        collocation, point = orbit.collocation, orbit.point
        method, m = gauss(collocation.degree), collocation.degree
        jacobians = point.period * collocation.jacobians(point)
        count, n = adjoint.shape
        steps = collocation.steps
        inner = -(steps[:, None, None, None, None] * np.einsum("jk,ikab->ijakb", method.integrals, jacobians))
        inner = inner.reshape(count, m * n, m * n)
        inner[:, np.arange(m * n), np.arange(m * n)] += 1.0
        pulled = steps[:, None, None] * np.einsum("j,ijab,ia->ijb", method.weights, jacobians, adjoint)
        solved = np.linalg.solve(np.swapaxes(inner, 1, 2), pulled.reshape(count, m * n, 1)).reshape(count, m, n)
        direct = method.weights[:, None] * adjoint[:, None]
        return np.asarray(steps[:, None, None] * (direct + np.einsum("jk,ija->ika", method.integrals, solved)))


def with_values(orbit: CriticalOrbit, point: Point, values: Mapping[str, float]) -> CriticalOrbit:
    """Return an orbit with other values of parameters, on which the period of the forcing may depend."""
    collocation = replace(orbit.collocation, system=orbit.system.with_parameters(**values))
    return orbit._replace(collocation=collocation, point=point._replace(period=collocation.period_at(point)))


def _normal(borders: Borders) -> Borders:
    """Return borders of length 1."""
    left = borders.left / np.linalg.norm(borders.left)
    size = math.sqrt(float((borders.right**2).sum() + (borders.period**2).sum()))
    return Borders(left, borders.right / size, borders.period / size)


def _turned(vector: Floats) -> Floats:
    """Return i times a complex vector, real and imaginary parts one after the other."""
    n = vector.shape[1] // 2
    return np.concatenate([-vector[:, n:], vector[:, :n]], axis=1)


def _transposed(maps: Floats, columns: Floats, rows: Floats, corner: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the transposed equations, whose unknowns are in reversed order, y_(N - 1 - k)."""
    turned = np.ascontiguousarray(np.swapaxes(maps[::-1], 1, 2))
    driven = -np.moveaxis(rows[:, ::-1], 0, 2)
    return turned, np.ascontiguousarray(driven), -np.moveaxis(columns[::-1], 2, 0), corner.T


def _balanced(linear: Linear, last: Vector) -> bordered.Balanced:
    """Return the linearised equations with a last row, scalars and rows of size 1."""
    rows = np.concatenate([linear.rows, last.nodes[None]])
    corner = np.concatenate([linear.corner, last.scalars[None]])
    return bordered.balanced(rows, corner, linear.columns, _SMALLEST)
