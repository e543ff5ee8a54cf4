"""Rods in channels that bend: uniform curvature, whose modes stay Mathieu's, and paths, against other computations."""

from __future__ import annotations

import itertools
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh, expm

import floquetrod as fr
from floquetrod import mathieu
from tests.conftest import depth
from tests.inside import Loads, mode_constants

Floats = NDArray[np.float64]

ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force  # of the straight rod
DROPS = ROD.replace(curvature=-0.2)  # lies on the high side from 0.641 N on
BUILDS = ROD.replace(curvature=0.2)  # holds modes 1 to 7


def arc(upper: float, lower: float, **changes: Any) -> fr.Rod:
    """Return the rod on an arc in a vertical plane, between inclinations in degrees."""
    return ROD.replace(path=fr.WellPath.arc(length=3.1, inclination=np.radians([upper, lower])), **changes)


def s_shaped(side: float) -> fr.Rod:
    """Return the rod on a path of three arcs that turns to one side and builds, and then back."""
    inclination, azimuth = np.radians([80.0, 84.0, 88.0, 85.0]), side * np.radians([10.0, 14.0, 12.0, 11.0])
    return ROD.replace(path=fr.WellPath([0.0, 1.3, 2.1, 4.0], inclination, azimuth), depth=0.4)


def mode_growth(rod: fr.Rod, mean: Any, amplitude: Any, frequency: Any, modes: int = 30, side: int = 1) -> Floats:
    """Return the growth in 1/s of the fastest mode by the equation of each in a uniform bend, from the data sheet."""
    m = np.arange(1.0, modes + 1.0)[:, None]
    mass, w = rod.mass_per_length, math.pi / rod.length
    driven = ((m * w) ** 2 - side * rod.curvature / rod.radial_clearance) / mass
    bending = rod.flexural_rigidity / mass * (m * w) ** 4
    swing = side * rod.weight_per_length * math.sin(rod.inclination) / (mass * rod.radial_clearance)
    mean, amplitude, frequency = np.atleast_1d(mean, amplitude, frequency)
    alpha, beta = driven * amplitude / frequency**2, (driven * mean - bending - swing) / frequency**2
    return np.asarray((mathieu.growth_rate(alpha, beta, rod.damping_rate / frequency) * frequency).max(axis=0))


# --- the mode equations in a uniform bend ---


@pytest.mark.parametrize(("curvature", "force"), [(0.002, 1.7186134), (0.01, 1.8119169), (0.05, 2.3472859)])
def test_static_limit_of_nitinol(curvature: float, force: float) -> None:
    rod = ROD.replace(curvature=curvature)
    assert rod.critical_force == pytest.approx(force, abs=6e-8)
    check_static_limit(rod)


@pytest.mark.parametrize(("curvature", "force"), [(0.002, 60693.878), (0.01, 188759.127), (0.05, 906019.067)])
def test_static_limit_of_tubing(curvature: float, force: float) -> None:
    area = math.pi * (0.03**2 - 0.022**2)
    sheet = {"diameter": 0.06, "wall_thickness": 0.008, "channel_diameter": 0.1, "length": 300.0}
    rod = fr.Rod(200e9, 82.274467551 / (9.81 * area), **sheet, curvature=curvature)
    assert rod.critical_force == pytest.approx(force, abs=6e-4)
    check_static_limit(rod)


def check_static_limit(rod: fr.Rod) -> None:
    """Hold the static limit to its equation, and to the least force of any wavelength, to rounding."""
    k, rigidity = rod.curvature / rod.radial_clearance, rod.flexural_rigidity
    q = rod.weight_per_length / rod.radial_clearance
    force, p2 = rod.critical_force, (math.pi * rod.critical_mode / rod.length) ** 2
    assert force**2 == pytest.approx(4.0 * rigidity * (q + force * k), rel=1e-12)
    assert force == pytest.approx((rigidity * p2**2 + q) / (p2 - k), rel=1e-12)
    near = p2 * np.array([1.0 - 1e-4, 1.0 + 1e-4])
    assert (force < (rigidity * near**2 + q) / (near - k)).all()


@pytest.mark.parametrize("curvature", [0.2, 0.05, -0.02])
def test_growth_is_that_of_the_equation_of_each_mode(curvature: float) -> None:
    rod = ROD.replace(curvature=curvature)
    mean = np.linspace(0.1, 2.0, 40)
    found = rod.growth_rate(mean=mean, amplitude=0.3 * UNIT, frequency=133.0)
    np.testing.assert_allclose(found, mode_growth(rod, mean, 0.3 * UNIT, 133.0), rtol=1e-9, atol=1e-9)
    assert (found > 0.0).any()
    verdict = rod.stability(fr.AxialLoad(mean[-1], 0.3 * UNIT, 133.0))
    assert verdict.growth_rate == pytest.approx(found[-1], rel=1e-9, abs=1e-9)


def test_modes_longer_than_m0_are_driven_in_opposite_phase_and_at_m0_not_at_all() -> None:
    held = mode_constants(ROD.replace(curvature=1.0)).neutral_squared
    rod = ROD.replace(curvature=16.0 / held)
    alphas = [e.alpha for e in rod.modal_system(fr.AxialLoad(0.2, 0.3, 100.0), range(1, 9)).equations]
    assert (np.array(alphas[:3]) < 0.0).all()
    assert (np.array(alphas[4:]) > 0.0).all()
    assert abs(alphas[3]) < 1e-15
    assert alphas[1] == pytest.approx(-(alphas[7] / 48.0) * 12.0)


@pytest.mark.slow
@pytest.mark.parametrize("rod", [BUILDS, ROD.replace(curvature=-0.02), BUILDS.replace(damping_rate=0.5)])
@pytest.mark.parametrize("quantity", ["mean", "amplitude", "frequency"])
def test_ranges_agree_with_scans(rod: fr.Rod, quantity: str) -> None:
    if quantity == "mean":
        found = rod.ranges("mean", amplitude=0.2 * UNIT, frequency=150.0, growth_tolerance=1e-3)
        x = np.linspace(*found.bounds, 400)
        growth = mode_growth(rod, x, 0.2 * UNIT, 150.0)
    elif quantity == "amplitude":
        found = rod.ranges(
            "amplitude", mean=0.3 * UNIT, frequency=150.0, bounds=(0.0, 0.5 * UNIT), growth_tolerance=1e-3
        )
        x = np.linspace(*found.bounds, 400)
        growth = mode_growth(rod, 0.3 * UNIT, x, 150.0)
    else:
        found = rod.ranges(
            "frequency", mean=0.3 * UNIT, amplitude=0.2 * UNIT, bounds=(80.0, 200.0), growth_tolerance=1e-3
        )
        x = np.linspace(*found.bounds, 400)
        growth = mode_growth(rod, 0.3 * UNIT, 0.2 * UNIT, x)
    sure = np.abs(growth - 1e-3) > 1e-7
    assert 20 < np.count_nonzero(growth > 1e-3) < 380
    np.testing.assert_array_equal(
        found.contains(x[sure]) if hasattr(found, "contains") else [value in found for value in x[sure]],
        growth[sure] <= 1e-3,
    )


def test_modes_left_out_stay_below_their_bound() -> None:
    for curvature in (0.2, -0.02, 0.05):
        rod, load = ROD.replace(curvature=curvature), fr.AxialLoad(0.2, 0.3, 200.0)
        last, bound = rod.modes_needed(load, 1e-3)
        constants = mode_constants(rod)
        assert last**2 >= constants.neutral_squared
        growths = [rod.stability(load, [mode]).growth_rate for mode in range(last + 1, last + 8)]
        assert max(growths) <= bound <= 1e-3


def test_a_box_is_proved_as_its_loads_are() -> None:
    rod = BUILDS.replace(damping_rate=0.5)
    stable = next(iter(rod.ranges("frequency", mean=0.3 * UNIT, amplitude=0.2 * UNIT, bounds=(80.0, 200.0))))
    middle, width = 0.5 * (stable.low + stable.high), stable.high - stable.low
    proof = rod.certify(
        mean=(0.3 * UNIT, 0.301 * UNIT), amplitude=0.2 * UNIT, frequency=(middle - 0.2 * width, middle + 0.2 * width)
    )
    assert proof.status == "stable"
    varied = rod.certify(mean=0.3 * UNIT, amplitude=0.2 * UNIT, frequency=middle, rod={"curvature": (0.1995, 0.2005)})
    assert varied.status == "stable"
    worst = max(
        rod.ranges("frequency", mean=0.3 * UNIT, amplitude=0.2 * UNIT, bounds=(80.0, 200.0)).unstable,
        key=lambda b: b.worst_growth,
    )
    assert rod.certify(mean=(0.3 * UNIT, 0.301 * UNIT), amplitude=0.2 * UNIT, frequency=worst.at).status == "unstable"


def test_nothing_is_proved_where_the_wall_is_left() -> None:
    rod = DROPS.replace(damping_rate=0.5)
    assert rod.certify(mean=0.2, amplitude=0.01, frequency=150.0, max_boxes=50).status == "stable"
    assert rod.certify(mean=(0.2, 0.7), amplitude=0.01, frequency=150.0, max_boxes=50).status != "stable"
    assert rod.certify(mean=0.7, amplitude=0.01, frequency=150.0, max_boxes=50).status == "undecided"


@pytest.mark.slow
def test_probability_of_curvature_is_that_of_samples() -> None:
    load = fr.AxialLoad(0.3 * UNIT, 0.2 * UNIT, 150.0)
    found = fr.probability_of_instability(ROD, load, {"curvature": (0.0, 0.1)}, samples=2000, seed=3)
    curvatures = np.linspace(0.0, 0.1, 201)
    share = np.mean(
        [mode_growth(ROD.replace(curvature=c), load.mean, load.amplitude, 150.0)[0] > 1e-6 for c in curvatures]
    )
    assert 0.1 < share < 0.9
    assert found.undecided == 0
    assert found.probability == pytest.approx(share, abs=0.04)


def test_what_a_path_tells_cannot_vary() -> None:
    """Also where the path is straight, so that modes are independent: copies of another inclination have no path."""
    load = fr.AxialLoad(0.3 * UNIT, 0.2 * UNIT, 150.0, mean_at=None)
    for rod in (arc(80.0, 90.0), ROD.replace(path=fr.WellPath([0.0, 50.0], [1.2, 1.2]))):
        with pytest.raises(ValueError, match="parameters must not name inclination of a rod on a path"):
            fr.probability_of_instability(rod, load, {"inclination": (1.4, 1.5)}, samples=8)
        with pytest.raises(ValueError, match=r"rod must not name curvature of a rod on a path|a path that bends"):
            rod.certify(load, mean=0.3, amplitude=0.1, frequency=150.0, rod={"curvature": (0.0, 0.1)})


# --- both sides of the channel ---


def test_on_the_high_side_stiffness_is_the_magnitude() -> None:
    for mean in (1.5, 5.0):
        found = DROPS.stability(fr.AxialLoad(mean, 0.3, 150.0)).growth_rate
        assert found == pytest.approx(float(mode_growth(DROPS, mean, 0.3, 150.0, side=-1)[0]), rel=1e-9, abs=1e-12)
    assert found > 1.0


def test_where_the_wall_is_left_there_is_no_verdict() -> None:
    limit = DROPS.weight_per_length / 0.2
    message = rf"leaves the wall when its force comes to {limit:.6g} N, and it comes to 0.7 N"
    with pytest.raises(fr.LeavesWallError, match=message):
        DROPS.stability(fr.AxialLoad(0.6, 0.1, 150.0))
    means = [0.2, 0.6, 1.5]
    assert DROPS.verdicts(mean=means, amplitude=0.1, frequency=150.0).tolist() == [1, -1, 1]
    assert np.isnan(DROPS.growth_rate(mean=means, amplitude=0.1, frequency=150.0)).tolist() == [False, True, False]
    with pytest.warns(fr.UndecidedWarning):
        assert DROPS.is_stable(mean=means, amplitude=0.1, frequency=150.0).tolist() == [True, False, True]
    assert DROPS.ranges("mean", amplitude=0.05, frequency=150.0).bounds[1] == pytest.approx(limit - 0.05, rel=1e-9)
    with pytest.raises(fr.LeavesWallError):
        DROPS.ranges("mean", amplitude=0.05, frequency=150.0, bounds=(0.0, 1.0))


def test_where_a_path_is_left_is_said_with_its_measured_depth() -> None:
    drop = fr.WellPath([100.0, 101.0, 104.0], np.radians([88.0, 88.0, 60.0]))
    rod = ROD.replace(path=drop, depth=100.4)
    with pytest.raises(fr.LeavesWallError, match=r"measured depth 103.5 m, .* when its force comes to 0\.\d+ N"):
        rod.stability(fr.AxialLoad(0.5, 0.3, 150.0))
    with pytest.raises(fr.LeavesWallError, match=r"low side above and on the high side below"):
        rod.stability(fr.AxialLoad(1.5, 0.01, 150.0))


# --- paths ---


@pytest.mark.parametrize(
    ("upper", "lower", "mean", "amplitude", "frequency", "growth"),
    [
        (80.0, 90.0, 0.6, 0.35, 120.0, 5.8427648),
        (90.0, 86.0, 0.4, 0.25, 110.0, 5.1337707),
        (86.0, 90.0, 0.5, 0.30, 133.0, 5.2757810),
    ],
)
def test_growth_on_arcs(
    upper: float, lower: float, mean: float, amplitude: float, frequency: float, growth: float
) -> None:
    """Of an own model elsewhere: sines, Gauss quadrature, a fourth-order exponential integrator."""
    rod, load = arc(upper, lower), fr.AxialLoad(mean * UNIT, amplitude * UNIT, frequency)
    found = rod.stability(load)
    assert found.growth_rate == pytest.approx(growth, abs=6e-8)
    assert abs(found.growth_rate - growth) < found.error + 5e-8
    assert rod.growth_rate(mean=load.mean, amplitude=load.amplitude, frequency=frequency) == pytest.approx(
        growth, abs=6e-8
    )


def hermite(xi: Floats, h: float) -> tuple[Floats, Floats, Floats]:
    """Return the four shape functions of a beam element with first and second derivatives, (4, q)."""
    values = np.array([1 - 3 * xi**2 + 2 * xi**3, h * xi * (1 - xi) ** 2, xi**2 * (3 - 2 * xi), h * xi**2 * (xi - 1)])
    slopes = np.array([6 * xi * (xi - 1), h * (1 - xi) * (1 - 3 * xi), 6 * xi * (1 - xi), h * xi * (3 * xi - 2)]) / h
    curves = np.array([12 * xi - 6, h * (6 * xi - 4), 6 - 12 * xi, h * (6 * xi - 2)]) / h**2
    return values, slopes, curves


def elements_growth(rod: fr.Rod, load: fr.AxialLoad, elements: int, steps: int, kept: int = 26) -> float:
    """Return the growth in 1/s of finite elements with hinged ends: m R th'' + E I R th'''' + R (F th')' + N th = 0."""
    assert rod.path is not None
    stations = [s - rod.depth for s in rod.path.stations if 0.0 < s - rod.depth < rod.length]
    ends = np.array([0.0, *stations, rod.length])
    counts = np.maximum(1, np.rint(elements * np.diff(ends) / rod.length)).astype(int)
    nodes = np.concatenate(
        [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends, ends[1:], counts, strict=False)]
    )
    nodes = np.append(nodes, rod.length)
    points, weights = np.polynomial.legendre.leggauss(6)
    xi = 0.5 * (points + 1.0)
    size = 2 * len(nodes)
    mass, still, shaken = np.zeros((3, size, size))
    room, w = rod.radial_clearance, rod.weight_per_length
    middle = rod.path.position(rod.depth + 0.5 * rod.length)[2]
    for i, (a, b) in enumerate(itertools.pairwise(nodes)):
        h = float(b - a)
        values, slopes, curves = hermite(xi, h)
        at = rod.depth + a + h * xi
        phi, (kn, kb) = rod.path.inclination_at(at), rod.path.curvature(at)
        force = load.mean + w * (rod.path.position(at)[:, 2] - middle)
        down, side = w * np.sin(phi) + force * kn, force * kb
        contact = np.hypot(down, side)
        towards = (kn * down + kb * side) / contact
        part, dx = slice(2 * i, 2 * i + 4), 0.5 * weights * h
        mass[part, part] += rod.mass_per_length * room * (values * dx) @ values.T
        still[part, part] += room * (
            rod.flexural_rigidity * (curves * dx) @ curves.T - (slopes * dx * force) @ slopes.T
        )
        still[part, part] += (values * dx * contact) @ values.T
        shaken[part, part] += load.amplitude * ((values * dx * towards) @ values.T - room * (slopes * dx) @ slopes.T)
    free = np.delete(np.arange(size), [0, size - 2])
    squares, shapes = eigh(still[np.ix_(free, free)], mass[np.ix_(free, free)])
    shapes = shapes[:, :kept]
    forcing = shapes.T @ shaken[np.ix_(free, free)] @ shapes
    n, period = shapes.shape[1], 2.0 * math.pi / load.frequency
    step, state = period / steps, np.eye(2 * n)
    for k in range(steps):  # commutator-free Magnus integrator of fourth order
        one, two = (np.sin(2.0 * math.pi * (k + 0.5 + c) / steps) for c in (-math.sqrt(3) / 6, math.sqrt(3) / 6))
        for x, y in (
            (0.25 + math.sqrt(3) / 6, 0.25 - math.sqrt(3) / 6),
            (0.25 - math.sqrt(3) / 6, 0.25 + math.sqrt(3) / 6),
        ):
            half = np.zeros((2 * n, 2 * n))
            half[:n, n:] = 0.5 * np.eye(n)
            half[n:, :n] = -0.5 * np.diag(squares[:n]) - (x * one + y * two) * forcing
            state = expm(step * half) @ state
    return float(np.log(np.abs(np.linalg.eigvals(state)).max()) / period)


def extrapolated(rod: fr.Rod, load: fr.AxialLoad, elements: int, kept: int = 26) -> float:
    """Return what finite elements converge to, of the fourth order in their length."""
    coarse, fine = (elements_growth(rod, load, n, 96, kept) for n in (elements, 2 * elements))
    return fine + (fine - coarse) / 15.0


def test_finite_elements_converge_to_the_truth_on_an_arc() -> None:
    load = fr.AxialLoad(0.6 * UNIT, 0.35 * UNIT, 120.0)
    assert extrapolated(arc(80.0, 90.0), load, 40) == pytest.approx(5.8427648, rel=2e-6)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.ForcedAngleWarning")
@pytest.mark.parametrize("side", [0.0, 1.0])
def test_finite_elements_converge_to_the_modes_on_a_path_that_turns(side: float) -> None:
    rod, load = s_shaped(side), fr.AxialLoad(0.5 * UNIT, 0.3 * UNIT, 133.0)
    found, elements = rod.stability(load), extrapolated(rod, load, 40)
    assert found.growth_rate == pytest.approx(elements, rel=3e-5)
    assert abs(found.growth_rate - elements) < found.error


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.ForcedAngleWarning")
@pytest.mark.parametrize("side", [0.0, 1.0, 3.0])
def test_finer_elements_converge_to_the_modes(side: float) -> None:
    rod, load = s_shaped(side), fr.AxialLoad(0.5 * UNIT, 0.3 * UNIT, 133.0)
    assert rod.stability(load, range(1, 101)).growth_rate == pytest.approx(extrapolated(rod, load, 160, 80), rel=1e-6)


@pytest.mark.filterwarnings("ignore::floquetrod.ForcedAngleWarning")
def test_a_path_that_turns_the_other_way_is_the_mirror_image() -> None:
    load = fr.AxialLoad(0.5 * UNIT, 0.3 * UNIT, 133.0)
    one, other, plane = (s_shaped(side).stability(load).growth_rate for side in (1.0, -1.0, 0.0))
    assert one == pytest.approx(other, rel=1e-12)
    assert abs(one - plane) > 1e-3 * plane


def test_the_forced_angle_of_a_turn_is_told_and_warned_of() -> None:
    """Of a slow force on a level turn: theta_0 = atan2(F kappa_b, w) at its largest less that at the mean."""
    level = fr.WellPath([0.0, 3.1], [0.5 * math.pi] * 2, [0.0, 0.02])
    rod = ROD.replace(path=level, ends="guided")
    load = fr.AxialLoad(0.2 * UNIT, 0.02 * UNIT, 0.5)
    found = rod._modes_under(load).in_modes(12).forced_angle(load)
    per_newton = 0.02 / 3.1 / ROD.weight_per_length
    exact = math.atan(per_newton * 0.22 * UNIT) - math.atan(per_newton * 0.2 * UNIT)
    assert found == pytest.approx(exact, rel=1e-2)
    with pytest.warns(fr.ForcedAngleWarning, match="turns"):
        verdict = s_shaped(3.0).stability(fr.AxialLoad(0.5 * UNIT, 0.3 * UNIT, 133.0))
    assert any("from which the vibration moves the rod by up to" in line for line in verdict.assumptions)
    assert any("curvature times clearance is" in line for line in verdict.assumptions)
    assert arc(80.0, 90.0)._modes_under(load).in_modes(12).forced_angle(load) is None


def test_bends_too_sharp_for_the_theory_are_told() -> None:
    wide = ROD.replace(channel_radius=0.0508)  # a clearance of 5 cm
    with pytest.warns(fr.PlausibilityWarning, match=r"curvature times clearance is 0\.01[12], above 0\.01"):
        wide.replace(curvature=0.23)
    with pytest.warns(fr.PlausibilityWarning, match="gentle bends"):
        wide.replace(path=fr.WellPath([0.0, 4.0], [0.5 * math.pi] * 2, [0.0, 1.0]))
    wide.replace(curvature=0.19)


def test_a_straight_path_is_the_inclination() -> None:
    load = fr.AxialLoad(0.4 * UNIT, 0.3 * UNIT, 133.0, mean_at=None)
    inclined = ROD.replace(inclination=1.2)
    path = ROD.replace(path=fr.WellPath([0.0, 50.0], [1.2, 1.2], 0.3), depth=7.0)
    assert path.critical_force == pytest.approx(inclined.critical_force, rel=1e-14)
    for each in (load, fr.AxialLoad(0.4 * UNIT, 0.3 * UNIT, 133.0)):
        one, other = inclined.stability(each), path.stability(each)
        assert one.evidence.kind == other.evidence.kind
        assert one.growth_rate == other.growth_rate > 0.0


def test_bending_little_changes_little() -> None:
    load, straight = fr.AxialLoad(0.4 * UNIT, 0.3 * UNIT, 133.0), ROD.replace(inclination=math.radians(85.0))
    growth = straight.stability(load).growth_rate
    bent = [arc(85.0 - x, 85.0 + x).stability(load).growth_rate - growth for x in (0.01, 0.001)]
    assert abs(bent[1]) < 1e-2 * growth
    assert bent[0] / bent[1] == pytest.approx(10.0, rel=0.02)


def test_the_matrices_of_a_uniform_bend_are_those_of_its_modes() -> None:
    load = fr.AxialLoad(0.6 * UNIT, 0.3 * UNIT, 133.0)
    system = BUILDS._modes_under(load).in_modes(20).system(Loads.single(load))
    assert fr.stability(system).growth_rate == pytest.approx(BUILDS.stability(load).growth_rate, rel=1e-9)
    assert BUILDS._modes_under(load).coupling == ()
    assert arc(80.0, 90.0)._modes_under(load).coupling == ("a path that bends",)


def test_the_static_limit_of_coupled_modes_in_a_uniform_bend() -> None:
    """With hinged ends the least of the modes; found through matrices, without vibration."""
    rod = ROD.replace(curvature=0.05)
    modes = rod._modes_under().in_modes(20)
    m2 = np.arange(1.0, 21.0) ** 2
    c = mode_constants(rod)
    rising = m2 > c.neutral_squared
    limit = float(((c.bending * m2**2 + c.restoring) / (c.per_newton * (m2 - c.neutral_squared)))[rising].min())
    assert modes.static_answers(limit * np.array([1.0 - 1e-9, 1.0 + 1e-9])).status.tolist() == [1, 0]


# --- the rod as a value ---


def test_a_rod_on_a_path_round_trips() -> None:
    rod = s_shaped(1.0)
    assert eval(repr(rod), {"Rod": fr.Rod}) == rod
    assert fr.Rod(**rod.as_dict()) == rod == pickle.loads(pickle.dumps(rod))
    assert hash(rod) == hash(fr.Rod(**rod.as_dict()))
    assert rod != s_shaped(-1.0)
    assert rod.replace(length=2.0).path == rod.path
    assert rod.replace(inclination=1.0) == ROD.replace(inclination=1.0)
    assert ROD.replace(curvature=0.1).replace(path=rod.path, depth=0.4) == rod


def test_files_name_a_survey_or_hold_it(tmp_path: Path) -> None:
    (tmp_path / "survey.csv").write_text("MD (m),Inc (deg),Azi (deg)\n0,80,0\n200,84,3\n500,90,5\n")
    sheet = 'catalogue = "2.00x0.156"\nbore = "4.778in"\nlength = "60m"\ndepth = "100ft"\n'
    file = tmp_path / "rod.toml"
    file.write_text(sheet + 'path = "survey.csv"\n')
    found = fr.Rod.from_toml(file)
    assert found.depth == pytest.approx(30.48)
    assert found.path == fr.WellPath.from_csv(tmp_path / "survey.csv")
    file.write_text(sheet + '[path]\ndepth = [0, 500]\ninclination = ["80deg", "90deg"]\n')
    assert fr.Rod.from_toml(file).path == fr.WellPath([0.0, 500.0], ["80deg", "90deg"])
    file.write_text(sheet.replace('depth = "100ft"\n', "") + 'curvature = "3deg/30m"\n')
    assert fr.Rod.from_toml(file).curvature == pytest.approx(math.radians(0.1))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"depth": 3.0}, "depth is the measured depth"),
        ({"curvature": 1e4}, "curvature must lie between"),
        ({"path": "well"}, "path must be a WellPath"),
        ({"path": fr.WellPath([0.0, 9.0], [1.0, 1.02]), "depth": 7.0}, "depth .* reaches to 10.1 m"),
        ({"path": fr.WellPath([0.0, 9.0], [0.0, 0.0])}, "straight and vertical"),
    ],
)
def test_what_is_no_rod_on_a_path_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        ROD.replace(**changes)
    with pytest.raises(ValueError, match="inclination must not be given with path"):
        fr.Rod(68e9, 6500.0, 0.8e-3, 3.1, 4.7e-3, inclination=1.0, path=fr.WellPath([0.0, 9.0], [1.0, 1.02]))


def test_what_bends_is_not_kicked_and_without_a_path_not_simulated() -> None:
    load = fr.AxialLoad(0.2, 0.1, 150.0)
    for rod in (BUILDS, arc(80.0, 90.0)):
        with pytest.raises(ValueError, match="friction"):
            rod.stability(load, friction=0.1, kick=0.05)
        with pytest.raises(ValueError, match="bends"):
            rod.lock_up(0.2)
    with pytest.raises(ValueError, match="rod must have a path to be simulated where its channel bends"):
        fr.simulate(BUILDS, load, duration=0.1)
    with pytest.raises(ValueError, match="friction"):
        BUILDS.verdicts(mean=0.2, amplitude=0.1, frequency=150.0, friction=0.1, kick=0.05)


@pytest.mark.slow
def test_growth_of_random_bends_is_that_of_their_modes() -> None:
    rng = np.random.default_rng(5)
    for _ in range(depth(200, 40)):
        rod = ROD.replace(curvature=rng.uniform(-0.1, 0.5), damping_rate=rng.choice([0.0, 0.3]))
        mean, amplitude, frequency = rng.uniform(0.0, 1.0), rng.uniform(0.0, 0.4), rng.uniform(60.0, 300.0)
        try:
            found = rod.stability(fr.AxialLoad(mean, amplitude, frequency)).growth_rate
        except fr.LeavesWallError:
            continue
        assert found == pytest.approx(float(mode_growth(rod, mean, amplitude, frequency)[0]), rel=1e-8, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("curvature", [0.2, -0.2])
@pytest.mark.parametrize("reach", [(0.3, 2.0), (-1.0, 2.0)])
def test_mean_forces_on_a_line_that_moves_the_rod_to_the_other_side_are_judged_one_by_one(
    curvature: float, reach: tuple[float, float]
) -> None:
    """A pull lifts what builds, a push what drops: the stiffness then has a kink in the mean force."""
    rod = ROD.replace(curvature=curvature, ends="clamped", inclination=1.2)
    modes = rod._modes_under(None).in_modes(6)
    loads = Loads.of(-math.copysign(1.0, curvature) * np.linspace(*reach, 30), 0.1, 150.0)
    together = modes.answers(loads)
    each = [modes.answers(loads.some(slice(i, i + 1))) for i in range(loads.size)]
    assert together.status.tolist() == [int(one.status[0]) for one in each]
    expected = np.array([one.growth[0] for one in each])
    np.testing.assert_allclose(together.growth, expected, rtol=1e-8, atol=1e-8)
    ends = sorted(loads.mean[[0, -1]].tolist())
    sides = {modes._lying(mean).side for mean in loads.mean.tolist()}  # type: ignore[attr-defined]
    assert modes.is_affine(*ends) == (len(sides) == 1)


@pytest.mark.filterwarnings("ignore:station 2")
def test_numbers_of_modes_that_agree_by_chance_do_not_hide_the_error() -> None:
    # Growth with 15, 17, 19 and 80 modes: 4.601411, 4.601337, 4.601410, 4.601497 (4.601499 by finite elements).
    path = fr.WellPath([0.0, 1.63946228, 3.1], ["81.323deg", "79.928deg", "89.639deg"])
    rod = fr.Rod.nitinol().replace(path=path, ends="clamped", damping_rate=0.3)
    unit = fr.Rod.nitinol().critical_force
    load = fr.AxialLoad(0.257932806 * unit, 0.387046927 * unit, 142.134649, mean_at=0.5)
    found, many = rod.stability(load), rod.stability(load, range(1, 61))
    assert abs(found.growth_rate - many.growth_rate) <= found.error
    assert len(found.convergence) >= 3


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning", "ignore:the vibration moves the rod along")
@pytest.mark.parametrize(("seed", "count"), [(1, 4), pytest.param(2, depth(48, 24), marks=pytest.mark.slow)])
def test_the_stated_error_holds_the_growth_of_twice_as_many_modes(seed: int, count: int) -> None:
    rng, held = np.random.default_rng(seed), 0
    for _ in range(count // 4):
        for path in (None, "bend", "turn", "turn"):
            string, load = drawn_string(rng, path)
            try:
                found = string.stability(load)
            except fr.LeavesWallError:
                continue
            modes = found.modes_checked
            if 60 < modes < 230 and found.status != "undecided":
                more = string.stability(load, range(1, 2 * modes + 1))
                assert found.growth_rate == pytest.approx(more.growth_rate, abs=found.error, rel=0.0), (string, load)
                held += found.growth_rate > 0.0
    assert held > count // 5


def drawn_string(rng: np.random.Generator, path: str | None) -> tuple[fr.Rod, fr.Load]:
    """Return a section of tubing 150 to 500 m long and a load that shakes it."""
    length, water = rng.uniform(150.0, 500.0), {"fluid_inside": 1000.0, "fluid_outside": 1000.0}
    name = str(rng.choice(["1.50x0.125", "2.00x0.156", "2.375x0.190", "2.875x0.204"]))
    string = fr.Rod.catalogue(name, bore="4.892in", length=length, damping_rate=rng.choice([0.0, 0.05, 0.2]), **water)
    slope, stations = rng.uniform(0.8, 1.4), np.linspace(0.0, length, rng.integers(4, 12))
    if path is None:
        string = string.replace(inclination=slope)
    elif path == "bend":
        arc = fr.WellPath.arc(length=length, inclination=(slope, slope + rng.uniform(0.02, 0.3)))
        string = string.replace(path=arc, inclination=None)
    else:
        steps = rng.uniform(0.0, 0.04, stations.size), rng.uniform(-0.03, 0.03, stations.size)
        string = string.replace(
            path=fr.WellPath(stations, slope + steps[0].cumsum(), steps[1].cumsum()), inclination=None
        )
    unit, kind = string.critical_force, fr.AxialWave if rng.random() < 0.5 else fr.AxialLoad
    load = kind.hertz(rng.uniform(0.1, 0.6) * unit, rng.uniform(0.03, 0.2) * unit, rng.uniform(5.0, 30.0))
    return string, load
