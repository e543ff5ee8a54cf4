"""Kernels of branches: their eliminations against LAPACK's, step by step and along a branch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.orbits import bordered, finding, orbit_mesh
from floquetrod.orbits.collocation import BorderRow, Collocation, Condensed, Point, Step
from floquetrod.orbits.kernels import interval_cycle
from tests.conftest import needs_jit
from tests.seams import Tuned

pytestmark = pytest.mark.kernels


def growing(t: Any, x: Any, mu: float) -> Any:
    return (mu * np.cos(t) - x[0] - 0.1 * x[0] ** 3,)


def van_der_pol(t: Any, x: Any, mu: float) -> Any:
    return x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]


def roessler(t: Any, x: Any, mu: float) -> Any:
    return -x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - mu)


def unknown_mu(function: Any, equations: int) -> tuple[Collocation, Point]:
    """Return equations with mu unknown on 8 intervals, and a point that does not satisfy them."""
    turns = 1 if equations == 1 else None
    system = fr.NonlinearSystem(function, period=None if turns is None else "2*pi", parameters={"mu": 1.0})
    collocation = Collocation(system, np.linspace(0.0, 1.0, 9), 4, turns, "mu")
    s = 2.0 * np.pi * np.concatenate([collocation.mesh[:-1, None], collocation.shares], axis=1)
    states = np.stack([2.0 * np.cos(s + 1.3 * k) for k in range(equations)], axis=2)
    point = Point(states[:, 0].copy(), states[:, 1:].copy(), 6.6, 1.1)
    return collocation, point._replace(period=collocation.period_at(point))


def solved(collocation: Collocation, point: Point) -> tuple[Condensed, Condensed, Step, Step]:
    """Return the equations condensed, again with another residual, Newton's step, and a tangent."""
    pinned = BorderRow(np.zeros_like(point.nodes), np.eye(len(collocation.scalars))[-1], 1.0)
    rows = [pinned] if collocation.turns else [collocation.phase(point), pinned]
    condensed = collocation.linearised(point)
    step = collocation.solved(condensed, rows, point)
    moved = collocation.moved(point, step, 0.1)
    rates = collocation.rates(moved)
    again = collocation.recondensed(condensed, moved, rates, collocation.residual(moved, rates))
    return condensed, again, step, collocation.tangent(condensed, rows, point.scale)


@pytest.mark.parametrize(("function", "equations"), [(growing, 1), (van_der_pol, 2), (roessler, 3)])
def test_equations_are_eliminated_as_by_lapack(function: Any, equations: int, tuned: Tuned) -> None:
    collocation, point = unknown_mu(function, equations)
    tuned(orbit_kernels=lambda kernel: None)
    known = solved(collocation, point)
    tuned(orbit_kernels=lambda kernel: kernel)
    found = solved(collocation, point)
    for mine, theirs in zip(found[:2], known[:2], strict=True):
        assert mine.pivots is not None
        assert theirs.pivots is None
        for name in ("maps", "gaps", "columns", "inner", "residual"):
            assert np.allclose(getattr(mine, name), getattr(theirs, name), rtol=1e-11, atol=1e-11), name
    for step, same in zip(found[2:], known[2:], strict=True):
        for name, value in step._asdict().items():
            assert np.allclose(value, getattr(same, name), rtol=1e-9, atol=1e-9), name


@pytest.mark.parametrize(("function", "equations"), [(growing, 1), (van_der_pol, 2), (roessler, 3)])
def test_errors_on_a_mesh_are_as_by_numpy(function: Any, equations: int, tuned: Tuned) -> None:
    given, point = unknown_mu(function, equations)
    mesh = np.concatenate([given.mesh[:-1] ** 1.3, [1.0]])
    coarse, there = orbit_mesh.carried(given, point, mesh, 6)
    fine, start = orbit_mesh.carried(coarse, there, mesh, 8)
    finer = start._replace(nodes=1.001 * start.nodes, stages=start.stages + 0.01 * np.sin(start.stages))
    known = errors_of(coarse, there, fine, finer, tuned, None)
    for mine, theirs in zip(errors_of(coarse, there, fine, finer, tuned, lambda kernel: kernel), known, strict=True):
        assert np.allclose(mine, theirs, rtol=1e-9, atol=1e-300)
    assert [len(each) for each in known[:2]] == [8, 8]


def errors_of(coarse: Collocation, point: Point, fine: Collocation, finer: Point, tuned: Tuned, kernels: Any) -> Any:
    """Return errors and densities of intervals, a new mesh, differences, and errors of maps and of the trace."""
    tuned(orbit_kernels=kernels or (lambda kernel: None))
    condensed = fine.linearised(finer)
    needs = orbit_mesh._needs(coarse, point, coarse.jacobians(point), 1e-10)
    mesh = orbit_mesh.adapted(coarse, point, coarse.jacobians(point), 1e-10)
    assert mesh is not None
    doubts = finding.doubts(fine, finer, condensed, 1e-9, 0.999 * condensed.maps)
    return *needs, mesh, orbit_mesh.differences(fine, finer, point, (0.08, 0.29, 0.92)), *doubts


@pytest.mark.parametrize("equations", [1, 2, 3])
@pytest.mark.parametrize("scalars", [0, 1, 2])
def test_a_bordered_cycle_is_solved_as_by_lapack(equations: int, scalars: int) -> None:
    """Maps that grow and shrink by a factor of 100 an interval, one after the other their product would overflow."""
    rng = np.random.default_rng(7 * equations + scalars)
    count, n, sides = 9, equations, 2
    maps = rng.normal(size=(count, n, n)) * np.array([100.0, 0.01, 1.0])[:n]
    columns, right = rng.normal(size=(count, n, scalars)), rng.normal(size=(count, n, sides))
    rows, corner = rng.normal(size=(scalars, count, n)), rng.normal(size=(scalars, scalars))
    targets, scale = rng.normal(size=(scalars, sides)), rng.uniform(0.5, 2.0, n)
    given = maps, columns, right, rows, corner, targets
    nodes, free, _ = bordered.solve_by(interval_cycle.bordered_fill, *given, scale)
    missed = np.roll(nodes, -1, axis=0) - maps @ nodes - columns @ free - right
    assert np.abs(missed).max() <= 1e-11 * (1.0 + np.abs(nodes).max() * 100.0)
    assert np.allclose(np.einsum("sin,inq->sq", rows, nodes) + corner @ free, targets, atol=1e-9)
    known = bordered.solve(*given)
    assert np.allclose(nodes, known.nodes, rtol=1e-8, atol=1e-8)


def test_a_family_of_orbits_takes_the_shortest_step() -> None:
    """Where the last equations are singular, as along a family, the kernel leaves them to LAPACK."""
    maps, right = np.broadcast_to(np.eye(2), (4, 2, 2)).copy(), np.zeros((4, 2, 1))
    none = np.zeros((0, 4, 2)), np.zeros((0, 0)), np.zeros((0, 1))
    maps[0] = [[1.0, 1.0], [0.0, 1.0]]
    right[0] = [[1.0], [0.0]]
    nodes, *_ = bordered.solve_by(interval_cycle.bordered_fill, maps, np.zeros((4, 2, 0)), right, *none, np.ones(2))
    assert np.allclose(nodes[0, :, 0], [0.0, -1.0])


@pytest.mark.slow
@needs_jit
def test_a_branch_is_the_same_by_kernels_and_by_lapack(tuned: Tuned) -> None:
    orbit = fr.periodic_orbit(fr.NonlinearSystem(van_der_pol, parameters={"mu": 1.0}), [2.0, 0.0])
    compiled = fr.follow(orbit, over={"mu": (0.9, 1.2)})
    tuned(equations_of_orbit_kernels=0)
    plain = fr.follow(orbit, over={"mu": (0.9, 1.2)})
    assert np.allclose(compiled.values, plain.values, rtol=0.0, atol=1e-9)
    assert np.allclose(compiled.period, plain.period, rtol=0.0, atol=1e-9)
    assert (np.abs(compiled.multipliers - plain.multipliers) <= 1e-9).all()
    assert max(each.error for each in compiled.orbits) <= 2.0 * max(each.error for each in plain.orbits)
