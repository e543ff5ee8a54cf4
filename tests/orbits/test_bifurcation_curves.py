"""Curves of special points over two parameters: closed forms, Mathieu's tongues, and points located along branches."""

from __future__ import annotations

import functools
import logging
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import depth

LOG = logging.getLogger(__name__)


def cycles(t: Any, x: Any, mu: float, k: float) -> Any:
    """Return r' = r (mu + k r^2 - r^4), turning at rate 1 + 0.3 r^2: cycles fold at mu = -k^2 / 4, of r^2 = k / 2."""
    square = x[0] ** 2 + x[1] ** 2
    growth, turn = mu + k * square - square**2, 1.0 + 0.3 * square
    return growth * x[0] - turn * x[1], turn * x[0] + growth * x[1]


def torus(t: Any, x: Any, p: float, q: float) -> Any:
    """Return z' = (p^2 - 2 q + i w) z - |z|^2 z about (2 cos t, sin 2 t), stretched, with w = 0.3 + q / 10."""
    stretch, rate = 1.0 + 0.5 * np.sin(t), 0.5 * np.cos(t)
    u, v = (x[0] - 2.0 * np.cos(t)) / stretch, (x[1] - np.sin(2.0 * t)) / stretch
    growth, w = p**2 - 2.0 * q - u**2 - v**2, 0.3 + 0.1 * q
    up, vp = growth * u - w * v, w * u + growth * v
    return -2.0 * np.sin(t) + rate * u + stretch * up, 2.0 * np.cos(2.0 * t) + rate * v + stretch * vp


def ring(t: Any, x: Any, p: float, q: float, e: float) -> Any:
    """Return a pitchfork about sin t where p^2 + q^2 = 1, which e breaks."""
    y = x[0] - np.sin(t)
    return (np.cos(t) + e + (p**2 + q**2 - 1.0 + np.cos(t)) * y - y**3,)


def mathieu(t: Any, x: Any, a: float, b: float, c: float) -> Any:
    """Return x'' + c x' + (a + b cos t) x + x^3 = 0, whose solution 0 has the multipliers of Mathieu's equation."""
    return x[1], -c * x[1] - (a + b * np.cos(t)) * x[0] - x[0] ** 3


def roessler(t: Any, x: Any, c: float, a: float) -> Any:
    return -x[1] - x[2], x[0] + a * x[1], 0.2 + x[2] * (x[0] - c)


def duffing(t: Any, x: Any, omega: float, force: float) -> Any:
    return x[1], force * np.cos(omega * t) - 0.2 * x[1] - x[0] - x[0] ** 3


def brusselator(t: Any, x: Any, a: float, w: float) -> Any:
    """Return the forced Brusselator of Tomita, Kai and Hikami, Prog. Theor. Phys. 57 (1977) 1159."""
    square = x[0] ** 2 * x[1]
    return 0.4 + a * np.cos(w * t) - 2.2 * x[0] + square, 1.2 * x[0] - square


def plane_cycle(t: Any, x: Any, p: float, q: float) -> Any:
    """Return the circle of r' = r - r^3 beside z' = (p - q^2 + x y) z - z^3: a pitchfork at p = q^2."""
    square = x[0] ** 2 + x[1] ** 2
    rate = p - q**2 + x[0] * x[1]
    return x[0] - x[1] - square * x[0], x[0] + x[1] - square * x[1], rate * x[2] - x[2] ** 3


TWO_PI = 2.0 * math.pi


def located(branch: fr.Branch, kind: str = "") -> fr.results.SpecialPoint:
    """Return the first special point of a kind."""
    return next(point for point in branch.special_points if kind in ("", point.kind))


class Known(NamedTuple):
    """A family with a curve in closed form: the branch over its first parameter, ranges, and what is zero on it."""

    system: fr.NonlinearSystem
    start: list[float]
    first: tuple[float, float]
    over: dict[str, tuple[float, float]]
    kind: str
    gap: Callable[[Any, Any], Any]


KNOWN = {
    "cycles": Known(
        fr.NonlinearSystem(cycles, parameters={"mu": -0.2, "k": 1.0}),
        [0.85, 0.0],
        (-0.3, -0.1),
        {"mu": (-0.5, 0.5), "k": (0.5, 1.3)},
        "fold",
        lambda mu, k: mu + k**2 / 4.0,
    ),
    "torus": Known(
        fr.NonlinearSystem(torus, period=TWO_PI, parameters={"p": 1.3, "q": 1.0}),
        [2.0, 0.0],
        (1.3, 1.5),
        {"p": (0.6, 4.0), "q": (-1.0, 3.0)},
        "Neimark-Sacker",
        lambda p, q: p**2 - 2.0 * q,
    ),
    "ring": Known(
        fr.NonlinearSystem(ring, period=TWO_PI, parameters={"p": 0.7, "q": 0.0, "e": 0.0}),
        [0.0],
        (0.6, 1.4),
        {"p": (-2.0, 2.0), "q": (-2.0, 2.0)},
        "branch point",
        lambda p, q: np.hypot(p, q) - 1.0,
    ),
    "cycle in a plane": Known(
        fr.NonlinearSystem(plane_cycle, parameters={"p": 0.1, "q": 0.5}),
        [1.0, 0.0, 0.0],
        (0.1, 0.4),
        {"p": (-0.5, 1.0), "q": (-0.8, 0.8)},
        "branch point",
        lambda p, q: p - q**2,
    ),
}


@functools.cache
def curve_of(name: str) -> fr.results.BifurcationCurve:
    return followed(KNOWN[name])


def followed(known: Known, longest: float = 0.3) -> fr.results.BifurcationCurve:
    name = next(iter(known.over))
    branch = fr.follow(fr.periodic_orbit(known.system, known.start, None), {name: known.first}, longest=0.3)
    return fr.follow(located(branch, known.kind), known.over, longest=longest)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name != "cycles")) for name in KNOWN])
def test_a_curve_in_closed_form(name: str) -> None:
    known, curve = KNOWN[name], curve_of(name)
    assert curve.kind == known.kind
    assert len(curve.orbits) > 5
    gaps = np.abs(known.gap(*curve.values.T))
    assert (gaps <= 3.0 * curve.errors.sum(axis=1)).all(), (gaps.max(), curve.errors.max())
    assert curve.errors.max() < 1e-9
    for k, (low, high) in enumerate(curve.over):
        assert (curve.values[:, k] >= low).all()
        assert (curve.values[:, k] <= high).all()
    assert (curve.outside == 0).all()


@pytest.mark.slow
def test_how_curves_end() -> None:
    ring_curve = curve_of("ring")
    assert ring_curve.ends == ("the curve closes on itself", "the curve closes on itself")
    assert np.array_equal(ring_curve.values[-1], ring_curve.values[ring_curve.start])
    angles = np.unwrap(np.arctan2(*ring_curve.values.T))
    assert abs(abs(angles[-1] - angles[0]) - TWO_PI) < 1e-9
    torus_curve = curve_of("torus")
    ends = sorted(torus_curve.ends)
    assert ends[0] == "p = 0.6 is the end of the range"
    assert ends[1].startswith("the pair meets on the real axis (1:2 resonance, two multipliers -1) near p = ")
    assert abs(float(ends[1].split("p = ")[1].split(",")[0]) - 2.0) < 1e-2
    (note,) = torus_curve.notes
    assert note.startswith("1:3 resonance near p = 0.8")
    angles = np.sort(np.angle(torus_curve.critical))
    assert np.abs(angles - TWO_PI * np.sort(0.3 + 0.1 * torus_curve.values[:, 1])).max() < 1e-7
    cycle = KNOWN["cycles"]._replace(over={"mu": (-0.5, 0.5), "k": (-1.0, 1.1)})
    assert any("the orbit shrinks to a state of rest near mu = " in end for end in followed(cycle).ends)


@pytest.mark.slow
def test_a_branch_point_that_nothing_keeps_is_refused() -> None:
    known = KNOWN["ring"]
    branch = fr.follow(fr.periodic_orbit(known.system, known.start), {"p": known.first}, longest=0.3)
    with pytest.raises(ValueError, match="the branches that cross part beyond p = 1, e = 0"):
        fr.follow(branch.special_points[0], {"p": (-2.0, 2.0), "e": (-1.0, 1.0)})


def test_points_at_which_several_multipliers_cross_are_refused() -> None:
    def copies(t: Any, x: Any, p: float, q: float) -> Any:
        return np.stack([(p - q) * y + np.cos(t) * y - y**3 for y in x])

    system = fr.NonlinearSystem(copies, period=TWO_PI, parameters={"p": -0.3, "q": 0.0})
    branch = fr.follow(fr.periodic_orbit(system, [0.0, 0.0]), {"p": (-0.4, 0.4)}, longest=0.3)
    (point,) = branch.special_points
    assert point.count == 2
    with pytest.raises(ValueError, match="one multiplier, or one pair, crosses by itself, got branch point at p = "):
        fr.follow(point, {"p": (-1.0, 1.0), "q": (-1.0, 1.0)})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("over", "error", "message"),
    [
        ({"p": (0.0, 1.0)}, TypeError, "two parameters with their ranges"),
        (None, TypeError, "two parameters with their ranges"),
        ({"p": (0.0, 1.5), "r": (0.0, 1.0)}, ValueError, "over has 'r', which is no parameter"),
        ({"p": (0.0, 0.5), "q": (-1.0, 1.0)}, ValueError, r"over\['p'\] must contain the point's value, 1, got"),
        ({"p": (0.0, 1.5), "q": (1.0, -1.0)}, ValueError, "must increase"),
    ],
)
def test_planes_that_are_none(over: Any, error: type[Exception], message: str) -> None:
    known = KNOWN["ring"]
    branch = fr.follow(fr.periodic_orbit(known.system, known.start), {"p": known.first}, longest=0.3)
    with pytest.raises(error, match=message):
        fr.follow(branch.special_points[0], over)


def mathieu_branch(a: float, b: float, c: float, over: tuple[float, float]) -> fr.Branch:
    system = fr.NonlinearSystem(mathieu, period=TWO_PI, parameters={"a": a, "b": b, "c": c})
    return fr.follow(fr.periodic_orbit(system, [0.0, 0.0]), {"a": over}, longest=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("a", "kind", "c"),
    [
        (0.05, "period doubling", 0.05),
        (0.05, "period doubling", 0.0),
        (0.75, "branch point", 0.05),
        (0.75, "branch point", 0.0),
    ],
)
def test_edges_of_mathieus_tongues(a: float, kind: str, c: float) -> None:
    """Edges at multipliers exp(-pi c): of the undamped equation at a - c^2 / 4, where abs(trace) = 2 cosh(pi c)."""
    b = 0.3 if kind == "period doubling" else 0.8
    branch = mathieu_branch(a, b, c, (a, a + 0.25))
    curve = fr.follow(located(branch, kind), {"a": (-0.3, 1.8), "b": (0.0, 1.5)}, longest=0.3)
    wanted = (-2.0 if kind == "period doubling" else 2.0) * math.cosh(math.pi * c)
    for first, second in curve.values:
        truth = fr.stability(fr.Mathieu.from_delta_epsilon(delta=first - c**2 / 4.0, epsilon=second))
        assert abs(truth.discriminant - wanted) < 1e-10, (first, second)
    assert curve.errors.max() < 1e-11


class Drawn(NamedTuple):
    """A family: an orbit off the curve, ranges of both parameters, and the kind of the curve."""

    system: fr.NonlinearSystem
    start: list[float]
    period: float | None
    first: tuple[float, float]
    over: dict[str, tuple[float, float]]
    kind: str


DRAWN = {
    "roessler": Drawn(
        fr.NonlinearSystem(roessler, parameters={"c": 2.7, "a": 0.2}),
        [1.0, 1.0, 0.0],
        5.75,
        (2.5, 3.0),
        {"c": (1.8, 5.0), "a": (0.12, 0.3)},
        "period doubling",
    ),
    "duffing": Drawn(
        fr.NonlinearSystem(duffing, period="2*pi/omega", parameters={"omega": 1.3, "force": 1.0}),
        [2.0, 0.0],
        None,
        (1.2, 2.5),
        {"omega": (1.2, 3.0), "force": (0.3, 2.0)},
        "fold",
    ),
    "brusselator": Drawn(
        fr.NonlinearSystem(brusselator, period="2*pi/w", parameters={"a": 0.2, "w": 1.3}),
        [0.4, 3.0],
        None,
        (0.02, 0.25),
        {"a": (0.02, 0.3), "w": (1.1, 1.5)},
        "Neimark-Sacker",
    ),
}


def points_by_both_ways(family: Drawn, share: float, longest: float) -> tuple[float, float, float]:
    """Return the first parameter by the curve and by a branch, at a share of the second one's range, and errors."""
    (name, _), (second, (low, high)) = family.over.items()
    branch = fr.follow(fr.periodic_orbit(family.system, family.start, family.period), {name: family.first}, longest=0.2)
    begun, given = located(branch, family.kind), family.system.parameters[second]
    value = low + share * (high - low)
    ends = (value, given) if value < given else (given, value)
    curve = fr.follow(begun, {**family.over, second: ends}, longest=longest)
    end = int(np.abs(curve.values[:, 1] - value).argmin())
    assert curve.values[end, 1] == value, curve
    by_curve, slope = curve.values[end, 0], 0.0
    if len(curve.orbits) > 1:
        step = np.diff(curve.values[[end, end - 1 if end else 1]], axis=0)[0]
        slope = abs(step[0] / step[1])
    near = curve.orbits[end]
    aside = by_curve + 0.02 * (family.first[0] - family.first[1])
    orbit = fr.periodic_orbit(near.system.with_parameters(**{name: aside}), near)
    other = fr.follow(orbit, {name: (aside, by_curve + 0.5 * (by_curve - aside))}, longest=0.3)
    by_branch = located(other, family.kind)
    LOG.info("%s at %s = %.6g: %.12g by the curve, %s", family.kind, second, value, by_curve, by_branch)
    errors = by_branch.error + curve.errors[end, 0] + slope * curve.errors[end, 1]
    return by_curve, by_branch.value, errors


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_a_point_of_a_curve_is_the_one_that_a_branch_has(name: str) -> None:
    by_curve, by_branch, errors = points_by_both_ways(DRAWN[name], 0.37, 0.3)
    assert abs(by_curve - by_branch) <= errors + 1e-12
    assert abs(by_curve - by_branch) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("seed", range(depth(12, 3)))
def test_drawn_points_of_curves_are_those_that_branches_have(name: str, seed: int) -> None:
    share = float(np.random.default_rng([seed, 54]).uniform(0.02, 0.98))
    by_curve, by_branch, errors = points_by_both_ways(DRAWN[name], share, 0.15)
    assert abs(by_curve - by_branch) <= errors + 1e-12
    assert abs(by_curve - by_branch) < 1e-8


@pytest.mark.slow
def test_report_and_plot_of_a_curve() -> None:
    curve = curve_of("cycle in a plane")
    assert curve.report().headline == "branch point curve of periodic orbits"
    assert repr(curve).startswith("<branch point curve of ")
    assert curve.as_dict()["kind"] == "branch point"
    assert curve.to_xarray()["p_error"].shape == curve.period.shape
    assert fr.to_pandas(curve).describe()["multipliers_0_re"]["mean"] == pytest.approx(
        curve.multipliers[:, 0].real.mean()
    )
    with pytest.raises(TypeError, match="outside"):
        bool(curve)
    ax = curve.plot()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("p", "q")
    assert ax.get_legend_handles_labels()[1] == ["branch point", "branch point on the branch"]
    assert "error" in str(curve)


@pytest.mark.slow
def test_a_curve_ends_by_until_steps_and_ctrl_c() -> None:
    known, calls = KNOWN["ring"], list[tuple[int, int]]()

    def until(before: fr.results.PeriodicOrbit, orbit: fr.results.PeriodicOrbit) -> str:
        return "far enough" if abs(orbit.system.parameters["q"]) > 0.5 else ""

    branch = fr.follow(fr.periodic_orbit(known.system, known.start), {"p": known.first}, longest=0.3)
    (point,) = branch.special_points
    curve = fr.follow(point, known.over, longest=0.2, until=until, progress=lambda *done: calls.append(done))
    assert curve.ends == ("far enough", "far enough")
    assert np.abs(curve.values[:, 1]).max() <= 0.5
    assert calls[-1] == (len(curve.orbits) - 1, 800)

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    assert fr.follow(point, known.over, longest=0.2, progress=stop).ends == ("interrupted", "interrupted")
    assert fr.follow(point, known.over, longest=0.2, steps=2).ends == ("2 steps were made", "2 steps were made")
