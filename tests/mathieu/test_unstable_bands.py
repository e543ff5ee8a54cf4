"""Between stability intervals: the fastest growth, and the damping from which on nothing grows."""

from __future__ import annotations

import copy
import itertools
import math
import pickle
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod import units
from floquetrod.mathieu.tongue_intervals import damping_to_stabilise
from floquetrod.rod import UnstableBand
from floquetrod.rod.answers.stability_intervals import ListedRanges, last_digit
from tests.conftest import depth
from tests.inside import Resonance

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force
CLAMPED = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, inclination=1.0, ends="clamped-hinged", damping_rate=0.02)

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")

QUANTITIES = ("mean", "amplitude", "frequency")


def searched(
    rod: fr.Rod, varied: str, load: fr.AxialLoad, tolerance: float, bounds: tuple[float, float]
) -> fr.results.StabilityIntervals:
    """Return the stability intervals of one quantity of a load."""
    return rod.ranges(varied, load, bounds, growth_tolerance=tolerance)


def growth(rod: fr.Rod, varied: str, load: fr.AxialLoad, values: np.ndarray) -> np.ndarray:
    """Return growth rates along one quantity of a load."""
    return np.asarray(rod.growth_rate(load, **{varied: values}))


def assert_order(found: fr.results.StabilityIntervals) -> None:
    """Assert that stable and unstable parts share the bounds between them."""
    ends = sorted([part[:2] for part in found] + [band[:2] for band in found.unstable])
    assert [end for part in ends for end in part] == [
        found.bounds[0],
        *(x for one, _ in zip(ends[1:], ends, strict=False) for x in (one[0], one[0])),
        found.bounds[1],
    ]


QUESTIONS = given(
    st.sampled_from(["mean", "amplitude", "frequency"]),
    st.floats(2.0, 25.0),
    st.floats(0.0, 0.9),
    st.floats(0.05, 0.5),
    st.floats(1.0, 6.0),
    st.sampled_from([0.0, 0.3, 3.0]),
    st.floats(-4.0, -1.0),
)


@pytest.mark.slow
@settings(max_examples=depth(16, 4), deadline=None)
@QUESTIONS
def test_nothing_grows_faster_than_said(
    varied: str, modes: float, mean: float, amplitude: float, speed: float, damping: float, power: float
) -> None:
    rod = ROD.replace(length=ROD.length * modes / ROD.critical_mode, damping_rate=damping)
    omega = speed * rod.pendulum_frequency
    load = fr.AxialLoad(mean * FCR, amplitude * FCR, omega)
    bounds = {"mean": (0.0, 1.2 * FCR), "amplitude": (0.0, FCR), "frequency": (0.6 * omega, 1.5 * omega)}[varied]
    found = searched(rod, varied, load, 10.0**power, bounds)
    assert_order(found)
    for band in found.unstable:
        assert band.low <= band.at <= band.high
        rate = band.worst_growth
        assert growth(rod, varied, load, np.array([band.at]))[0] == pytest.approx(rate, rel=1e-9, abs=1e-13)
        assert growth(rod, varied, load, np.linspace(band.low, band.high, 3001)).max() <= rate * (1.0 + 1e-7) + 1e-12
        # A search for what grows faster, which is complete along mean force and frequency, finds nothing.
        if rate > 1e-9 and band.low < band.high:
            higher = searched(rod, varied, load, rate * (1.0 + 1e-6), band[:2])
            assert [part[:2] for part in higher] == [band[:2]]
            assert len(searched(rod, varied, load, rate * (1.0 - 1e-6), band[:2]).unstable) > 0


@pytest.mark.slow
@settings(max_examples=depth(25, 3), deadline=None)
@QUESTIONS
def test_more_damping_than_required_stabilises_the_band(
    varied: str, modes: float, mean: float, amplitude: float, speed: float, damping: float, power: float
) -> None:
    rod = ROD.replace(length=ROD.length * modes / ROD.critical_mode, damping_rate=damping)
    omega = speed * rod.pendulum_frequency
    load = fr.AxialLoad(mean * FCR, amplitude * FCR, omega)
    bounds = {"mean": (0.0, 1.2 * FCR), "amplitude": (0.0, FCR), "frequency": (0.6 * omega, 1.5 * omega)}[varied]
    for band in searched(rod, varied, load, 10.0**power, bounds).unstable:
        values = np.linspace(band.low, band.high, 501)
        if math.isinf(band.required_damping):
            heavy = growth(rod.replace(damping_rate=100.0 * omega), varied, load, values)
            assert heavy.max() > 0.0
            continue
        assert band.required_damping > damping
        for share in (1.0001, 1.5, 4.0):
            held = rod.replace(damping_rate=share * band.required_damping)
            assert growth(held, varied, load, values).max() <= 1e-9
        less = rod.replace(damping_rate=0.99 * band.required_damping)
        dense = np.append(np.linspace(band.low, band.high, 4001), band.at)
        assert growth(less, varied, load, dense).max() > 0.0


@pytest.mark.slow
def test_the_required_damping_is_the_largest_of_single_loads() -> None:
    load = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, 150.0)
    for varied, bounds in (("mean", (0.0, 0.9 * FCR)), ("frequency", (100.0, 200.0))):
        for band in searched(ROD, varied, load, 0.01, bounds).unstable:
            values = np.linspace(band.low, band.high, 41).tolist()
            single = [ROD.stability(load.varied(varied, value)).damping_to_stabilise for value in values]
            assert max(single) <= band.required_damping * (1.0 + 1e-7)
            assert band.required_damping <= 1.01 * max(single)


def test_dampings_below_the_least_may_be_left_out(rng: np.random.Generator) -> None:
    alpha, beta = 10.0 ** rng.uniform(-4, 2, 400), -(10.0 ** rng.uniform(-3, 3, 400))
    least = 10.0 ** rng.uniform(-3, 1, 400)
    every, some = damping_to_stabilise(alpha, beta), damping_to_stabilise(alpha, beta, least)
    above = every > least
    assert 20 < above.sum() < 380
    assert some[above] == pytest.approx(every[above], rel=1e-12)
    assert (some[~above] <= every[~above] * (1.0 + 1e-12)).all()


def test_growth_and_damping_are_computed_when_asked_for() -> None:
    found = ROD.ranges("mean", amplitude=0.2 * FCR, frequency=150.0)
    assert "unstable" not in vars(found)
    assert found.unstable is found.unstable
    assert pickle.loads(pickle.dumps(found)).unstable == copy.deepcopy(found).unstable == found.unstable


@given(st.lists(st.floats(1e-3, 60.0), min_size=2, max_size=20, unique=True), st.sampled_from([1.0, 2.0 * math.pi]))
def test_safe_ranges_are_rounded_inwards_and_thin_bands_counted(ends: list[float], size: float) -> None:
    ends = sorted(ends)[: len(ends) // 2 * 2]
    intervals = [(size * a, size * b) for a, b in zip(ends[::2], ends[1::2], strict=True)]
    bands = [(a[1], b[0]) for a, b in itertools.pairwise(intervals)]
    listed = ListedRanges.of(bands, intervals, units.Unit("Hz", size), 60.0)
    for low, high in ((float(a), float(b)) for a, b in listed.safe):
        inside = [band for band in bands if size * low < band[1] and band[0] < size * high]
        assert set(inside) <= set(listed.thin)  # nothing that is called safe is unstable, except what is counted
        assert any(a <= size * low * (1.0 + 1e-8) for a, _ in intervals)
        assert any(b >= size * high * (1.0 - 1e-8) for _, b in intervals)
    for low, high in listed.thin:
        assert high - low < size * last_digit(low / size, 60.0)
    merged = len(intervals) - len(listed.thin)
    assert len(listed.safe) + listed.narrow == merged


def test_the_table_has_stable_and_unstable_rows_in_order() -> None:
    found = ROD.ranges("mean", amplitude=0.2 * FCR, frequency=150.0, bounds=(0.0, 1.5 * FCR), growth_tolerance=0.01)
    lines = found.table("Fcr", FCR, full=True).splitlines()
    assert lines[2].startswith("searched  mean force from 0 to 1.5 Fcr; ")
    rows = [line for line in lines if re.search(r" (un)?stable  ", line)]
    assert len(rows) == len(found) + len(found.unstable)
    assert ["unstable" in row for row in rows] == [False, True] * 5
    assert [float(row.split()[2]) for row in rows[:-1]] == [float(row.split()[0]) for row in rows[1:]]
    first = found.unstable[0]
    said = rf"{first.worst_growth:.4g} +{first.at / FCR:.6g} +([\d.]+) 1/s +mode 7, tongue 1"
    matched = re.search(said, rows[1])
    assert matched is not None
    assert 0.0 <= float(matched[1]) - first.required_damping < 1e-3  # rounded up
    assert math.isinf(found.required_damping)
    assert any(line.startswith("damping   no rate stabilises all bands; ") for line in lines)
    assert rows[-1].split()[6] == "none"
    assert math.isinf(found.unstable[-1].required_damping)
    assert len({row.index("mode") for row in rows[1::2]}) == 1


def test_nothing_unstable_and_nothing_stable() -> None:
    quiet = ROD.ranges("frequency", mean=0.9 * FCR, amplitude=0.0, bounds=(50.0, 150.0))
    assert quiet.unstable == ()
    assert quiet.required_damping == 0.0
    assert "unstable" not in quiet.table("N", 1.0)
    (band,) = ROD.ranges("frequency", mean=0.9 * FCR, amplitude=0.7 * FCR, bounds=(100.0, 101.0)).unstable
    assert band[:2] == (100.0, 101.0)
    buckled = ROD.ranges("frequency", mean=1.1 * FCR, amplitude=0.0, bounds=(50.0, 150.0)).unstable
    assert [(b[:2], b.cause[1], b.required_damping) for b in buckled] == [((50.0, 150.0), 0, math.inf)]


@pytest.mark.slow
def test_bands_of_coupled_modes() -> None:
    unit, swing = CLAMPED.critical_force, CLAMPED.pendulum_frequency
    load = fr.AxialLoad(0.3 * unit, 0.4 * unit, 2.0 * swing)
    found = searched(CLAMPED, "frequency", load, 0.01, (1.7 * swing, 2.1 * swing))
    assert_order(found)
    assert len(found.unstable) > 1
    for band in found.unstable:
        assert isinstance(band, UnstableBand)
        assert isinstance(band.cause, Resonance)
        dense = growth(CLAMPED, "frequency", load, np.linspace(band.low, band.high, depth(201, 81)))
        assert band.worst_growth == pytest.approx(dense.max(), rel=2e-3)
        worst = load.varied("frequency", band.at)
        held = CLAMPED.replace(damping_rate=1.001 * band.required_damping)
        assert held.stability(worst, growth_tolerance=0.01).status == "stable"
        assert CLAMPED.replace(damping_rate=0.99 * band.required_damping).stability(worst).growth_rate > 0.01
    assert "a band is stable above its rate, at the load of its fastest growth" in found.table("rad/s", 1.0)


@pytest.mark.slow
def test_the_required_damping_is_refined_to_the_worst_load() -> None:
    # Two samples next to the worst load tie, and three refinements left 5e-7 of the damping out.
    rod = fr.Rod(182.645e9, 3499.19, 0.552784e-3, 1.20374, 0.944477e-3, damping_rate=0.80377)
    found = rod.ranges(
        "frequency", mean=1.82801, amplitude=0.130656, bounds=(184.801, 369.603), growth_tolerance=1.58257
    )
    band = found.unstable[0]
    system = rod.modal_system(mean=1.82801, amplitude=0.130656, frequency=np.linspace(band.low, band.high, 20_001))
    worst = 0.0
    for mode in range(1, 12):
        alpha, beta = system.coefficients(mode)
        frequency = system.loads.frequency
        worst = max(worst, float((damping_to_stabilise(alpha, beta) * frequency).max()))
    assert worst * (1.0 - 1e-12) <= band.required_damping == pytest.approx(worst, rel=1e-6)
