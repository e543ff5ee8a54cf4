"""Branches of periodic orbits: closed forms, what ends them, and what becomes of them on disk and under Ctrl-C."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import floquetrod as fr
from floquetrod.orbits import continuation
from tests.conftest import depth


def cycles(t: Any, x: Any, mu: float) -> Any:
    """Return r' = r (mu + r^2 - r^4), turning at rate 1: cycles r^2 = (1 +- sqrt(1 + 4 mu)) / 2."""
    square = x[0] ** 2 + x[1] ** 2
    growth = mu + square - square**2
    return growth * x[0] - x[1], x[0] + growth * x[1]


def pitchfork(t: Any, x: Any, p: float) -> Any:
    """Return y' = (p + cos t) y - y^3 about y = x - sin t: the orbit y = 0 has the multiplier exp(2 pi p)."""
    y = x[0] - np.sin(t)
    return (np.cos(t) + (p + np.cos(t)) * y - y**3,)


def torus(t: Any, x: Any, p: float) -> Any:
    """Return z' = (p^2 - 2 + 0.3 i) z - |z|^2 z about (2 cos t, sin 2 t), stretched by 1 + sin(t) / 2."""
    stretch, rate = 1.0 + 0.5 * np.sin(t), 0.5 * np.cos(t)
    u, v = (x[0] - 2.0 * np.cos(t)) / stretch, (x[1] - np.sin(2.0 * t)) / stretch
    growth = p**2 - 2.0 - u**2 - v**2
    up, vp = growth * u - 0.3 * v, 0.3 * u + growth * v
    return -2.0 * np.sin(t) + rate * u + stretch * up, 2.0 * np.cos(2.0 * t) + rate * v + stretch * vp


def roessler(t: Any, x: Any, c: float) -> Any:
    return -x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - c)


CYCLES = fr.NonlinearSystem(cycles, parameters={"mu": 0.1})
PITCHFORK = fr.NonlinearSystem(pitchfork, period=2.0 * math.pi, parameters={"p": -0.3})
TORUS = fr.NonlinearSystem(torus, period=2.0 * math.pi, parameters={"p": 1.3})


@pytest.fixture(scope="module")
def fold() -> fr.Branch:
    radius = math.sqrt(0.5 * (1.0 + math.sqrt(1.4)))
    orbit = fr.periodic_orbit(CYCLES, [radius, 0.0], 2.0 * math.pi)
    return fr.follow(orbit, {"mu": (-0.4, 0.3)}, longest=0.1)


def test_cycles_fold_and_shrink_to_rest(fold: fr.Branch) -> None:
    (point,) = fold.special_points
    assert point.kind == "fold"
    assert abs(point.value + 0.25) <= max(point.error, 1e-15) < 1e-12
    known = np.sqrt(0.5 * (1.0 + np.where(fold.status == 1, 1.0, -1.0) * np.sqrt(1.0 + 4.0 * fold.values)))
    assert np.abs(fold.amplitude - known[:, None]).max() < 1e-5
    assert np.abs(fold.period - 2.0 * math.pi).max() < 1e-10
    rates = 2.0 * known**2 * (1.0 - 2.0 * known**2)  # of deviations across
    assert (np.abs(fold.multipliers[:, 0] - np.exp(2.0 * math.pi * rates)) <= fold.multiplier_errors[:, 0]).all()
    unstable = fold.orbits[int(np.flatnonzero(fold.status == 0)[0])]
    assert [str(name) for name in unstable.stability.resonances] == ["fold or branch point"]
    rest, range_end = fold.ends
    assert "state of rest (a Hopf point) near mu = " in rest
    value, error = map(float, rest.split("= ")[1].split(" +- "))
    assert abs(value) <= error < 1e-5
    assert range_end == "mu = 0.3 is the end of the range"
    assert repr(fold).endswith(", 1 special points, a Hopf point at one end>")
    assert fold.report().headline == "1 fold, a Hopf point at one end"
    assert fold.values[-1] == 0.3


@pytest.mark.parametrize("a", [1.5, *(pytest.param(a, marks=pytest.mark.slow) for a in (0.7, 1.0))])
def test_a_hopf_point_has_its_error(a: float) -> None:
    # The Brusselator's state of rest (a, b / a) has the trace b - 1 - a^2.
    def brusselator(t: Any, x: Any, a: float, b: float) -> Any:
        return a + x[0] ** 2 * x[1] - (b + 1.0) * x[0], b * x[0] - x[0] ** 2 * x[1]

    system = fr.NonlinearSystem(brusselator, parameters={"a": a, "b": 1.3 + a * a})
    branch = fr.follow(fr.periodic_orbit(system, [1.2 * a, (1.0 + a * a) / a]), over={"b": (0.5, 1.5 + a * a)})
    value, error = map(float, branch.ends[0].split("(a Hopf point) near b = ")[1].split(" +- "))
    assert abs(value - 1.0 - a * a) <= error < 1e-5
    table = fr.to_pandas(branch)
    assert (table["a"] == a).all()
    assert (table["b"] == branch.values).all()


def test_a_pitchfork_and_the_branch_that_crosses() -> None:
    branch = fr.follow(fr.periodic_orbit(PITCHFORK, [0.0]), {"p": (-0.5, 0.5)}, longest=0.2)
    (point,) = branch.special_points
    assert point.kind == "branch point"
    assert abs(point.value) <= point.error < 1e-8
    orbit = point.switch(distance=0.2)
    p = orbit.system.parameters["p"]
    # u = 1 / y^2 solves u' = 2 - 2 (p + cos t) u, whose periodic solution is an integral.
    whole = quad(lambda s: 2.0 * math.exp(2.0 * (p * s + math.sin(s))), 0.0, 2.0 * math.pi, epsabs=0.0, epsrel=1e-13)[0]
    assert abs(orbit.states[0, 0] ** -2 - whole / math.expm1(4.0 * math.pi * p)) < 1e-9 * orbit.states[0, 0] ** -2
    assert orbit.status == "stable"
    assert np.sign(orbit.states[0, 0]) == -np.sign(point.switch(side=-1, distance=0.2).states[0, 0])
    for side in (0, 2, np.broadcast_to(1, (10**6, 10**6))):
        with pytest.raises((ValueError, TypeError), match=r"^side must be"):
            point.switch(side=side)
    other = fr.follow(orbit, {"p": (-0.5, p + 0.02)}, longest=0.2, steps=9)
    assert [each.kind for each in other.special_points] == ["branch point"]
    assert abs(other.special_points[0].value) <= other.special_points[0].error < 1e-8


def test_a_pair_crosses_the_circle() -> None:
    branch = fr.follow(fr.periodic_orbit(TORUS, [2.0, 0.0]), {"p": (1.3, 1.5)}, longest=0.3)
    (point,) = branch.special_points
    assert point.kind == "Neimark-Sacker"
    assert abs(point.value - math.sqrt(2.0)) <= point.error < 1e-10
    assert abs(point.multiplier - np.exp(0.6j * math.pi)) < 1e-9
    unstable = branch.orbits[int(np.flatnonzero(branch.status == 0)[0])]
    assert [str(name) for name in unstable.stability.resonances] == ["Neimark-Sacker"]
    with pytest.raises(ValueError, match="two frequencies"):
        point.switch()


@pytest.mark.slow
def test_a_period_doubling_and_the_doubled_orbit() -> None:
    orbit = fr.periodic_orbit(fr.NonlinearSystem(roessler, parameters={"c": 2.8}), [1.0, 1.0, 0.0], 5.77)
    branch = fr.follow(orbit, {"c": (2.8, 2.85)}, longest=0.5)
    (point,) = branch.special_points
    assert point.kind == "period doubling"
    assert abs(point.value - 2.832445027914) <= 1e-9  # by DOP853 and Newton's method: test_branches_against_marching
    assert point.error < 1e-9
    doubled = point.switch()
    assert abs(doubled.period / point.orbit.period - 2.0) < 0.01
    assert doubled.status == "stable"
    assert [str(name) for name in branch.orbits[-1].stability.resonances] == ["period doubling"]
    again = fr.follow(doubled, {"c": (2.8, doubled.system.parameters["c"])}, longest=0.5)
    assert again.ends[0].startswith(
        "the branch joins the orbits of half its period at period doubling at c = 2.8324450"
    )
    assert abs(again.special_points[0].switch().period / point.orbit.period - 1.0) < 1e-9
    twice = fr.periodic_orbit(point.orbit.system, point.orbit.states[0], 2.0 * point.orbit.period)
    with pytest.raises(ValueError, match="returns after 1/2 of its period"):
        fr.follow(twice, {"c": (2.8, 2.9)})


def test_a_branch_is_kept(fold: fr.Branch, tmp_path: Path) -> None:
    again = fr.Branch.load(fold.save(tmp_path / "branch.npz"), CYCLES)
    assert again == fold
    assert np.array_equal(again.multipliers, fold.multipliers)
    other = fr.NonlinearSystem(lambda t, x, mu: (x[1], mu - x[0]), parameters={"mu": 0.1})
    with pytest.raises(ValueError, match="misses the equations"):
        fr.Branch.load(tmp_path / "branch.npz", other)
    with pytest.raises(ValueError, match="a system with the parameters mu"):
        fr.Branch.load(tmp_path / "branch.npz", TORUS)


def test_a_branch_is_said_and_drawn(fold: fr.Branch) -> None:
    assert "1 fold" in str(fold)
    assert fold.as_dict()["special_points"][0]["kind"] == "fold"
    assert fold.to_xarray()["status"].shape == fold.values.shape
    with pytest.raises(TypeError, match="status"):
        bool(fold)
    for quantity in ("amplitude", "largest", "least", "period"):
        ax = fold.plot(quantity=quantity)
        assert ax.get_legend_handles_labels()[1] == ["stable", "unstable", "fold"]
        drawn = [line for line in ax.lines if line.get_label() == "fold"]
        assert drawn[0].get_xdata()[0] == fold.special_points[0].value


def test_a_branch_goes_on_where_it_was_left() -> None:
    orbit = fr.periodic_orbit(PITCHFORK, [0.0])
    told: list[tuple[int, int]] = []

    def stop(done: int, total: int) -> None:
        told.append((done, total))
        if done == 2:
            raise KeyboardInterrupt

    first = fr.follow(orbit, {"p": (-0.5, 0.5)}, longest=0.2, steps=30, progress=stop)
    assert told == [(1, 60), (2, 60)]
    assert len(first.orbits) == 3
    assert first.ends[1].startswith("interrupted")
    second = fr.follow(first, longest=0.2)
    assert [point.kind for point in second.special_points] == ["branch point"]
    assert (second.values[0], second.values[-1]) == (-0.5, 0.5)
    assert set(first.values) <= set(second.values)
    third = fr.follow(second, {"p": (-0.6, 0.5)}, longest=0.2)
    assert (third.values[0], third.values[-1]) == (-0.6, 0.5)
    assert third.special_points == second.special_points


def test_a_branch_that_cannot_be_continued_keeps_what_it_has() -> None:
    system = fr.NonlinearSystem(
        lambda t, x, p: (np.cos(t) - np.sqrt(p) * x[0],), period=2.0 * math.pi, parameters={"p": 0.2}
    )
    branch = fr.follow(fr.periodic_orbit(system, [0.0]), {"p": (-1.0, 0.3)}, longest=0.3)
    assert len(branch.orbits) > 2
    assert "no orbit was found beyond p = " in branch.ends[0]


@pytest.mark.parametrize(
    ("over", "error", "message"),
    [
        ({"q": (0.0, 1.0)}, ValueError, "over has 'q', which is no parameter; it has p"),
        ({"p": (1.0, 0.0)}, ValueError, "must increase"),
        ({"p": (0.0, 1.0)}, ValueError, "must contain the orbit's value, -0.3, got"),
        ({"p": 1.0}, TypeError, "two numbers"),
        ({}, TypeError, "one parameter with its range"),
        (None, TypeError, "one parameter with its range"),
    ],
)
def test_ranges_that_are_none(over: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.follow(fr.periodic_orbit(PITCHFORK, [0.0]), over)


def test_what_is_no_orbit(fold: fr.Branch) -> None:
    with pytest.raises(TypeError, match=r"must be a PeriodicOrbit, got .*fr\.periodic_orbit"):
        fr.follow(PITCHFORK, {"p": (0.0, 1.0)})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must contain the branch"):
        fr.follow(fold, {"mu": (0.0, 1.0)})
    with pytest.raises(ValueError, match="no branch crosses at a fold"):
        fold.special_points[0].switch()


def test_a_component_that_grows_fast_is_followed() -> None:
    system = fr.NonlinearSystem(
        lambda t, x, p: (np.exp(p) * np.cos(t) - x[0],), period=2.0 * math.pi, parameters={"p": 0.0}
    )
    branch = fr.follow(fr.periodic_orbit(system, [0.0]), {"p": (-1.0, 3.0)}, longest=0.5)
    assert branch.values[-1] == 3.0
    assert len(branch.orbits) < 40  # 24; with steps as long as in the units before it grew, 110
    assert np.abs(branch.amplitude[:, 0] / np.exp(branch.values) * math.sqrt(2.0) - 1.0).max() < 1e-5


def test_a_branch_is_followed_until_something_is_told() -> None:
    asked: list[tuple[float, float]] = []

    def until(before: fr.results.PeriodicOrbit, orbit: fr.results.PeriodicOrbit) -> str:
        asked.append((before.system.parameters["p"], orbit.system.parameters["p"]))
        return "far enough" if abs(asked[-1][1] + 0.3) > 0.1 else ""

    branch = fr.follow(fr.periodic_orbit(PITCHFORK, [0.0]), {"p": (-0.5, 0.5)}, longest=0.2, until=until)
    assert branch.ends == ("far enough", "far enough")
    assert np.abs(branch.values + 0.3).max() <= 0.1
    assert {p for _, p in asked} - set(branch.values) == {p for _, p in asked if abs(p + 0.3) > 0.1}
    assert not branch.special_points


def test_an_orbit_that_is_lost_on_a_finer_mesh_ends_the_branch(monkeypatch: pytest.MonkeyPatch) -> None:
    orbit = fr.periodic_orbit(PITCHFORK, [0.0])
    found, calls = continuation.sampled, [0]

    def lost(*given: Any) -> Any:
        calls[0] += 1
        if calls[0] > 2:
            raise fr.NoOrbitError("no periodic orbit was found")
        return found(*given)

    monkeypatch.setattr(continuation, "sampled", lost)
    branch = fr.follow(orbit, {"p": (-0.5, 0.5)}, longest=0.2)
    assert len(branch.orbits) == 3
    assert all("was lost: no periodic orbit was found" in end for end in branch.ends)


def test_a_branch_ends_on_the_ends_of_its_range_to_the_bit() -> None:
    radius = math.sqrt(0.5 * (1.0 + math.sqrt(1.4)))
    orbit = fr.periodic_orbit(CYCLES, [radius, 0.0], 2.0 * math.pi)
    ranges = ((0.05, 0.3), (1.0 / 30.0, 1.0 / 3.0), (0.09, 0.11))
    for (low, high), tolerance in list(itertools.product(ranges, (1e-10, 1e-4)))[:: depth(1, 3)]:
        branch = fr.follow(orbit, {"mu": (low, high)}, longest=0.3, tolerance=tolerance)
        assert branch.values[0] == low
        assert branch.values[-1] == high
