"""Branches of symmetric systems and in invariant planes: several multipliers cross together, at known parameters."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import sympy

import floquetrod as fr
from floquetrod.orbits import locating_special_points
from tests.conftest import depth, some

LOG = logging.getLogger(__name__)


class Known(NamedTuple):
    """A branch over the parameter p, from about one orbit, with the special points that are known on it."""

    orbit: fr.results.PeriodicOrbit
    over: tuple[float, float]
    points: list[tuple[str, float, int]]  # kind, value, number of multipliers or pairs that cross together


def orbit_along(system: fr.NonlinearSystem, path: Callable[[Any], Any], count: int) -> fr.results.PeriodicOrbit:
    """Return the orbit with states path(t), 0, path(t), 0, ... over 2 pi, stable or not."""
    times = np.linspace(0.0, 2.0 * math.pi, 100)
    states = np.stack([path(times), np.zeros(100)] * count, axis=1)
    return fr.periodic_orbit(system, (times, states))


def identical_oscillators(rng: np.random.Generator, count: int) -> Known:
    """Return z_j' = (1 + i w) z_j - (1 + i c) |z_j|^2 z_j + p (1 + i b) (mean - z_j), in phase.

    Deviations across obey u' = -2 (1 + i c) Re u - p (1 + i b) u: count - 1 multipliers are 1 where p (2 + p + 2 b c +
    p b^2) = 0.
    """
    w, b, c = rng.uniform(0.3, 2.0), -rng.uniform(0.6, 1.5), rng.uniform(2.5, 4.0)
    known = -2.0 * (1.0 + b * c) / (1.0 + b**2)

    def rates(t: Any, x: Any, p: float) -> Any:
        u, v = x[0::2], x[1::2]
        up, vp = p * (u.mean(axis=0) - u), p * (v.mean(axis=0) - v)
        square = u**2 + v**2
        found = np.empty_like(x)
        found[0::2] = u - w * v - square * (u - c * v) + up - b * vp
        found[1::2] = v + w * u - square * (v + c * u) + vp + b * up
        return found

    over = known - rng.uniform(0.2, 0.5), known + rng.uniform(0.2, 0.5)
    system = fr.NonlinearSystem(rates, parameters={"p": known + 0.11})
    orbit = fr.periodic_orbit(system, [1.0, 0.0] * count, 2.0 * math.pi / abs(w - c))
    return Known(orbit, over, [("branch point", known, count - 1)])


def invariant_plane(rng: np.random.Generator, count: int) -> Known:
    """Return the circle of r' = r - r^3 with y_k' = (p - q + g(x)) y_k - y_k^3, the mean of g over the circle zero.

    y = 0 is invariant, the circle does not depend on p, and the multipliers exp(2 pi (p - q)) cross together.
    """
    q, a, b = rng.uniform(-1.0, 1.0), *rng.normal(size=2)

    def rates(t: Any, x: Any, p: float) -> Any:
        square = x[0] ** 2 + x[1] ** 2
        y = x[2:]
        rate = p - q + a * x[0] + b * x[0] * x[1]
        circle = [x[0] - x[1] - square * x[0], x[0] + x[1] - square * x[1]]
        return np.concatenate([np.stack(circle), rate * y - y**3])

    over = q - rng.uniform(0.1, 0.5), q + rng.uniform(0.1, 0.5)
    system = fr.NonlinearSystem(rates, parameters={"p": float(rng.uniform(*over))})
    orbit = fr.periodic_orbit(system, [1.0, 0.0] + [0.0] * count, 2.0 * math.pi)
    return Known(orbit, over, [("branch point", q, count)])


def turned_strips(rng: np.random.Generator, count: int) -> Known:
    """Return copies of a linear equation in axes that turn by half a turn a period, along them (p - q) y - y^3 and -y.

    Multipliers -exp(2 pi (p - q)) cross -1 together.
    """
    q, a = rng.uniform(-1.0, 1.0), rng.uniform(-0.5, 0.5)

    def rates(t: Any, x: Any, p: float) -> Any:
        u, v = x[0::2] - np.sin(t), x[1::2]  # about an orbit that moves
        c, s = np.cos(0.5 * t), np.sin(0.5 * t)
        y, z = c * u + s * v, c * v - s * u
        yp, zp = (p - q + a * np.cos(t)) * y - y**3, -z
        found = np.empty_like(x)
        found[0::2] = np.cos(t) + c * yp - s * zp - 0.5 * v
        found[1::2] = s * yp + c * zp + 0.5 * u
        return found

    over = q - rng.uniform(0.1, 0.4), q + rng.uniform(0.1, 0.4)
    system = fr.NonlinearSystem(rates, period=2.0 * math.pi, parameters={"p": float(rng.uniform(*over))})
    return Known(orbit_along(system, np.sin, count), over, [("period doubling", q, count)])


def spirals(rng: np.random.Generator, count: int) -> Known:
    """Return copies of z' = (p - q + i w) z - |z|^2 z about cos t: pairs exp(2 pi (p - q +- i w)) cross together."""
    q, w = rng.uniform(-1.0, 1.0), rng.uniform(0.1, 0.4)

    def rates(t: Any, x: Any, p: float) -> Any:
        u, v = x[0::2] - np.cos(t), x[1::2]
        growth = p - q + 0.3 * np.cos(t) - u**2 - v**2
        found = np.empty_like(x)
        found[0::2] = -np.sin(t) + growth * u - w * v
        found[1::2] = growth * v + w * u
        return found

    over = q - rng.uniform(0.1, 0.4), q + rng.uniform(0.1, 0.4)
    system = fr.NonlinearSystem(rates, period=2.0 * math.pi, parameters={"p": float(rng.uniform(*over))})
    return Known(orbit_along(system, np.cos, count), over, [("Neimark-Sacker", q, count)])


def folding_copies(rng: np.random.Generator, count: int) -> Known:
    """Return copies of y' = p - q - (y - cos t)^2 - sin t beside z' = sin t - z: all fold together at p = q."""
    q = rng.uniform(-1.0, 1.0)

    def rates(t: Any, x: Any, p: float) -> Any:
        found = np.empty_like(x)
        found[0::2] = p - q - (x[0::2] - np.cos(t)) ** 2 - np.sin(t)
        found[1::2] = np.sin(t) - x[1::2]
        return found

    over = q - 0.2, q + rng.uniform(0.1, 0.3)
    p = q + 0.08
    system = fr.NonlinearSystem(rates, period=2.0 * math.pi, parameters={"p": p})
    return Known(fr.periodic_orbit(system, [1.0 + math.sqrt(p - q), -0.5] * count), over, [("fold", q, count)])


FAMILIES: tuple[Callable[[np.random.Generator, int], Known], ...] = (
    identical_oscillators,
    invariant_plane,
    turned_strips,
    spirals,
    folding_copies,
)


def check(known: Known, longest: float) -> fr.Branch:
    """Compare the special points of a branch with those that are known."""
    branch = fr.follow(known.orbit, {"p": known.over}, longest=longest)
    found = [(point.kind, point.count) for point in branch.special_points]
    assert found == [(kind, count) for kind, _, count in known.points], branch
    for point, (_, value, _) in zip(branch.special_points, known.points, strict=True):
        assert abs(point.value - value) <= point.error < 1e-6, branch
    assert branch.notes == ()
    assert (branch.values >= known.over[0]).all()
    assert (branch.values <= known.over[1]).all()
    assert all("is the end of the range" in end for end in branch.ends), branch
    return branch


@pytest.mark.parametrize(
    "family",
    [pytest.param(f, marks=[pytest.mark.slow] * (f is not folding_copies)) for f in FAMILIES],
)
def test_multipliers_that_cross_together_are_located(family: Callable[[np.random.Generator, int], Known]) -> None:
    for seed in range(depth(6, 1)):
        rng = np.random.default_rng([seed, 48])
        count = int(rng.integers(2, 4))
        check(family(rng, count), 0.2)


@pytest.mark.slow
def test_a_branch_point_next_to_which_no_multiplier_is_resolved_is_located() -> None:
    rng = np.random.default_rng(17)
    check(identical_oscillators(rng, int(rng.integers(2, 5))), 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("tens", some(range(4), 1, 1))
def test_drawn_branches_with_symmetry(family: Callable[[np.random.Generator, int], Known], tens: int) -> None:
    for seed in range(10 * tens, 10 * tens + 10):
        rng = np.random.default_rng(seed)
        count = int(rng.integers(2 if family is identical_oscillators else 1, 5))
        branch = check(family(rng, count), float(rng.choice([0.1, 0.3])))
        LOG.info("%s %d %s", family.__name__, count, branch.special_points)


@pytest.mark.slow
def test_identical_oscillators_lose_all_but_one_multiplier_together() -> None:
    """At K = 2 with w = 1, c = 3, b = -1, of three oscillators: the sign of a product does not change."""

    def rates(t: Any, x: Any, K: float) -> Any:
        u, v = x[0::2], x[1::2]
        up, vp = K * (u.mean(axis=0) - u), K * (v.mean(axis=0) - v)
        square, found = u**2 + v**2, np.empty_like(x)
        found[0::2] = u - v - square * (u - 3.0 * v) + up + vp
        found[1::2] = v + u - square * (v + 3.0 * u) + vp - up
        return found

    system = fr.NonlinearSystem(rates, parameters={"K": 2.3})
    branch = fr.follow(fr.periodic_orbit(system, [1.0, 0.0] * 3, math.pi), {"K": (1.6, 2.5)}, longest=0.3)
    (point,) = branch.special_points
    assert (point.kind, point.count) == ("branch point", 2)
    assert abs(point.value - 2.0) <= point.error < 1e-6
    assert str(point).endswith("2 multipliers together")
    assert "2 together" in str(branch)
    assert point.as_dict()["count"] == 2


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3, 4])
def test_identical_oscillators_with_default_steps(count: int) -> None:
    orbit = fr.periodic_orbit(coupled_by_sympy(count, 1.0, 3.0, -1.0, 1.5), [1.0, 0.0] * count, math.pi)
    branch = fr.follow(orbit, {"K": (1.0, 3.0)})
    (point,) = branch.special_points
    assert (point.kind, point.count) == ("branch point", count - 1)
    assert abs(point.value - 2.0) <= point.error < 1e-7
    assert branch.notes == ()


@pytest.mark.slow
def test_two_uncoupled_helmholtz_oscillators_have_the_points_of_one_twice() -> None:
    def rates(t: Any, x: Any, force: float) -> Any:
        u, v, found = x[0::2], x[1::2], np.empty_like(x)
        found[0::2] = v
        found[1::2] = force * np.cos(0.85 * t) - 0.1 * v - u + u**2
        return found

    system = fr.NonlinearSystem(rates, period=2.0 * math.pi / 0.85, parameters={"force": 0.02})
    one, two = (fr.follow(fr.periodic_orbit(system, [0.0, 0.0] * n), {"force": (0.01, 0.2)}) for n in (1, 2))
    assert [point.kind for point in one.special_points] == ["fold", "fold", "period doubling"]
    for single, double in zip(one.special_points, two.special_points, strict=True):
        assert (double.kind, double.count) == (single.kind, 2)
        assert abs(double.value - single.value) < 1e-11


def coupled_by_sympy(count: int, w: float, c: float, b: float, coupling: float) -> fr.NonlinearSystem:
    """Return the identical oscillators as expressions, whose derivatives are exact."""
    strength, states = sympy.Symbol("K"), sympy.symbols(f"x:{2 * count}")
    u, v = states[0::2], states[1::2]
    equations = []
    for x, y in zip(u, v, strict=True):
        across, up, square = sum(u) / count - x, sum(v) / count - y, x**2 + y**2
        equations.append(x - w * y - square * (x - c * y) + strength * (across - b * up))
        equations.append(y + w * x - square * (y + c * x) + strength * (up + b * across))
    return fr.NonlinearSystem.from_sympy(equations, states, parameters={strength: coupling})


@pytest.mark.slow
@pytest.mark.parametrize("longest", [0.2, pytest.param(0.04, marks=pytest.mark.slow)])
def test_the_error_of_a_branch_point_holds(longest: float) -> None:
    """The multiplier that crosses is refined: near K = 2 the verdicts' is off by 8e-10, within its own error."""
    orbit = fr.periodic_orbit(coupled_by_sympy(2, 1.0, 3.0, -1.0, 1.5), [1.0, 0.0] * 2, 3.0)
    (point,) = fr.follow(orbit, {"K": (1.2, 3.0)}, longest=longest).special_points
    assert abs(point.value - 2.0) <= point.error < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(40, 1)))
def test_the_error_of_drawn_branch_points_holds(seed: int) -> None:
    rng = np.random.default_rng([seed, 481])
    count, longest = int(rng.integers(2, 5)), float(rng.choice([0.03, 0.1, 0.2]))
    w, b, c = rng.uniform(0.3, 2.0), -rng.uniform(0.6, 1.5), rng.uniform(2.5, 4.0)
    known = -2.0 * (1.0 + b * c) / (1.0 + b**2)
    low, high = known - rng.uniform(0.1, 0.3), known + rng.uniform(0.1, 0.3)
    orbit = fr.periodic_orbit(coupled_by_sympy(count, w, c, b, low), [1.0, 0.0] * count, 2.0 * math.pi / abs(w - c))
    (point,) = fr.follow(orbit, {"K": (low, high)}, longest=longest).special_points
    assert point.count == count - 1
    assert abs(point.value - known) <= point.error < 1e-6


@pytest.mark.slow
def test_the_branch_that_crosses_in_an_invariant_plane() -> None:
    known = invariant_plane(np.random.default_rng(3), 1)
    branch = check(known, 0.3)
    orbit = branch.special_points[0].switch(distance=0.2)
    assert orbit.status == "stable"
    assert abs(orbit.states[0, 2]) > 0.01
    other = fr.follow(orbit, {"p": (known.over[0], orbit.system.parameters["p"] + 0.05)}, longest=0.3, steps=12)
    assert "branch point" in [point.kind for point in other.special_points]
    assert abs(other.special_points[0].value - known.points[0][1]) <= other.special_points[0].error


def test_a_point_that_cannot_be_located_is_said_with_its_cause(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fails(crossing: Any) -> Any:
        raise RuntimeError("Failed to converge after 100 iterations.")

    known = invariant_plane(np.random.default_rng(5), 2)
    monkeypatch.setattr(locating_special_points, "located", fails)
    branch = fr.follow(known.orbit, {"p": known.over}, longest=0.3)
    (note,) = branch.notes
    assert "where the number of multipliers outside the unit circle changes from " in note
    assert "Failed to converge" in note
    assert branch.special_points == ()
    assert "1 place where a special point was not located" in repr(branch)
    assert note in str(branch).replace("\n", " ")
    assert "not located" in branch.report().headline
    assert fr.Branch.load(branch.save(tmp_path / "branch.npz"), known.orbit.system) == branch
