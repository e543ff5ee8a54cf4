"""Safe ranges and margins: every end right, nothing missed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.mathieu import tongue_intervals
from floquetrod.mathieu.tongue_intervals import along_amplitude
from floquetrod.methods import reference
from tests.conftest import depth
from tests.fuzz import ranges as ranges_attack
from tests.fuzz import rods
from tests.inside import SLOW_GROWTH
from tests.seams import Heard

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")

WORDS = {"mean force": "mean", "amplitude": "amplitude", "frequency": "frequency"}


def searches(
    rod: fr.Rod, mean: float, amplitude: float, omega: float, tolerance: float
) -> list[tuple[fr.results.StabilityIntervals, dict[str, float]]]:
    """Return the three kinds of ranges about a load, with what is fixed."""
    return [
        (
            rod.ranges("mean", amplitude=amplitude, frequency=omega, growth_tolerance=tolerance),
            {"amplitude": amplitude, "frequency": omega},
        ),
        (
            rod.ranges("amplitude", mean=mean, frequency=omega, growth_tolerance=tolerance),
            {"mean": mean, "frequency": omega},
        ),
        (
            rod.ranges(
                "frequency",
                mean=mean,
                amplitude=amplitude,
                bounds=(0.5 * omega, 2.0 * omega),
                growth_tolerance=tolerance,
            ),
            {"mean": mean, "amplitude": amplitude},
        ),
    ]


def scan(rod: fr.Rod, ranges: fr.results.StabilityIntervals, fixed: dict[str, float], points: int) -> None:
    """Assert that a dense scan agrees with the ranges everywhere but within rounding of an end."""
    values = np.linspace(*ranges.bounds, points + 2)[1:-1]
    found = rod.is_stable(
        **{WORDS[ranges.quantity]: values}, **fixed, growth_tolerance=max(ranges.growth_tolerance, 1e-9)
    )
    inside, near = np.zeros(points, bool), np.zeros(points, bool)
    for part in ranges:
        inside |= (values > part.low) & (values < part.high)
        for end in part[:2]:
            near |= np.abs(values - end) < 1e-9 * abs(end)
    assert (inside == found)[~near].all(), (ranges, values[(inside != found) & ~near])


@pytest.mark.parametrize(("mean", "omega"), [(0.34, 150.0), (0.1, 85.0), (0.6, 40.0)])
@pytest.mark.parametrize(
    ("damping", "tolerance"),
    [(0.2, 0.5), *(pytest.param(*both, marks=pytest.mark.slow) for both in ((0.0, 1e-3), (0.0, 0.5), (0.2, 1e-3)))],
)
def test_dense_scans_of_the_reference_rod(mean: float, omega: float, tolerance: float, damping: float) -> None:
    rod = ROD.replace(damping_rate=damping)
    for ranges, fixed in searches(rod, mean * FCR, 0.2 * FCR, omega, tolerance):
        scan(rod, ranges, fixed, depth(20_000, 5_000))


@pytest.mark.parametrize(("low", "high"), [(0.2, 0.7), (-0.5, 0.4), (-0.9, -0.1)])
def test_bounds_need_not_begin_at_zero(low: float, high: float) -> None:
    whole = ROD.ranges("mean", amplitude=0.2 * FCR, frequency=150.0, bounds=(-1.0 * FCR, FCR), growth_tolerance=1e-3)
    part = ROD.ranges(
        "mean", amplitude=0.2 * FCR, frequency=150.0, bounds=(low * FCR, high * FCR), growth_tolerance=1e-3
    )
    scan(ROD, part, {"amplitude": 0.2 * FCR, "frequency": 150.0}, 5000)
    ends = [end for interval in part for end in interval[:2] if low * FCR < end < high * FCR]
    known = [end for interval in whole for end in interval[:2] if low * FCR < end < high * FCR]
    assert ends == pytest.approx(known, rel=1e-9)
    amplitudes = ROD.ranges(
        "amplitude", mean=0.34 * FCR, frequency=150.0, bounds=(abs(low) * FCR, FCR), growth_tolerance=1e-3
    )
    scan(ROD, amplitudes, {"mean": 0.34 * FCR, "frequency": 150.0}, 5000)


RODS_AND_LOADS = given(
    st.floats(2.0, 100.0), st.floats(0.0, 0.9), st.floats(0.05, 0.5), st.floats(1.0, 6.0), st.floats(-4.0, -2.0)
)


def scan_a_rod(modes: float, mean: float, amplitude: float, speed: float, power: float) -> None:
    """Scan the three ranges of a rod whose critical mode is ``modes``."""
    rod = ROD.replace(length=ROD.length * modes / ROD.critical_mode)
    omega = speed * rod.pendulum_frequency
    for ranges, fixed in searches(rod, mean * FCR, amplitude * FCR, omega, 10.0**power * omega):
        scan(rod, ranges, fixed, 1500)


@pytest.mark.slow
@settings(max_examples=3)
@RODS_AND_LOADS
def test_dense_scans_of_random_rods(modes: float, mean: float, amplitude: float, speed: float, power: float) -> None:
    scan_a_rod(modes, mean, amplitude, speed, power)


@pytest.mark.slow
@settings(max_examples=depth(40, 20))
@RODS_AND_LOADS
def test_dense_scans_of_many_random_rods(
    modes: float, mean: float, amplitude: float, speed: float, power: float
) -> None:
    scan_a_rod(modes, mean, amplitude, speed, power)


DAMPED = given(
    st.floats(-1.0, 1.5),
    st.floats(-0.3, 1.2),
    st.floats(0.01, 1.0),
    st.floats(-1.0, 2.0),
    st.one_of(st.just(0.0), st.floats(-3.0, 4.0).map(math.exp)),
    st.one_of(st.just(SLOW_GROWTH), st.floats(-7.0, 3.0).map(math.exp)),
)


def scan_a_damped_rod(
    size: float, mean: float, amplitude: float, speed: float, damping: float, tolerance: float
) -> int:
    """Scan the three ranges of a damped rod, growth rates unclipped; return how many have ends inside."""
    rod = ROD.replace(length=ROD.length * math.exp(size), damping_rate=damping)
    omega = rod.pendulum_frequency * math.exp(speed)
    partial = 0
    for ranges, fixed in searches(rod, mean * FCR, amplitude * FCR, omega, tolerance):
        values = np.linspace(*ranges.bounds, 4002)[1:-1]
        growth = rod.growth_rate(**{WORDS[ranges.quantity]: values}, **fixed)
        inside = np.zeros(values.size, dtype=bool)
        for part in ranges:
            inside |= (values > part.low) & (values < part.high)
        clear = np.abs(growth - tolerance) > 1e-7 * (tolerance + damping)
        assert (inside == (growth <= tolerance))[clear].all(), (
            ranges,
            values[(inside != (growth <= tolerance)) & clear],
        )
        partial += inside.any() and not inside.all()
    return partial


@pytest.mark.slow
@settings(max_examples=depth(15, 3))
@DAMPED
def test_damped_and_tolerant_ranges_against_dense_scans(
    size: float, mean: float, amplitude: float, speed: float, damping: float, tolerance: float
) -> None:
    scan_a_damped_rod(size, mean, amplitude, speed, damping, tolerance)


@settings(max_examples=depth(700, 2))
@given(st.integers(0, 2**32 - 1))
def test_margins_end_where_stable_ranges_do(seed: int) -> None:
    question = rods.draw(np.random.default_rng(seed))
    for varied in WORDS.values():
        assert ranges_attack.margin_against_ranges(question, varied) == []


@pytest.mark.slow
def test_a_margin_beyond_a_stable_range_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    question = rods.Question(ROD, 0.34 * FCR, 0.2 * FCR, 150.0, 0.01)
    assert ranges_attack.margin_against_ranges(question, "mean") == []
    right = fr.results.RodStability.margin

    def wrong(self: fr.results.RodStability, *given: Any) -> fr.rod.Margin:
        found = right(self, *given)
        return fr.rod.Margin(found.below, 1.001 * found.above)

    monkeypatch.setattr(fr.results.RodStability, "margin", wrong)
    assert "the ranges have" in ranges_attack.margin_against_ranges(question, "mean")[0]
    scanned = ranges_attack.margin_against_scan(question, "mean", np.random.default_rng(1))
    assert "missed band" in scanned[0]


@pytest.mark.slow
def test_three_hundred_damped_and_tolerant_ranges_against_dense_scans() -> None:
    partial = 0

    @settings(max_examples=100)
    @DAMPED
    def scan(size: float, mean: float, amplitude: float, speed: float, damping: float, tolerance: float) -> None:
        nonlocal partial
        partial += scan_a_damped_rod(size, mean, amplitude, speed, damping, tolerance)

    scan()
    assert partial > 71  # most questions must have something to miss


def test_a_band_that_starts_below_its_damping() -> None:
    # Mode 7 grows at 0.267 1/s at 102 rad/s; where its tongue begins, damping exceeds its growth.
    rod = ROD.replace(damping_rate=12.0)
    ranges = rod.ranges("frequency", mean=0.6 * FCR, amplitude=0.4 * FCR, bounds=(50.0, 150.0), growth_tolerance=0.0)
    assert 102.0 not in ranges
    assert next((part.low, part.high) for part in ranges) == (50.0, pytest.approx(97.61, abs=0.01))
    assert ranges.intervals[1].low == pytest.approx(107.86, abs=0.01)
    margin = rod.stability(fr.AxialLoad(0.6 * FCR, 0.4 * FCR, 96.0)).frequency_margin
    assert 96.0 + margin.above == pytest.approx(ranges.intervals[0].high, rel=1e-6)


def test_a_dip_of_growth_along_the_amplitude() -> None:
    # Just below the lowest place of its upper edge, growth in tongue 3 dips to a sixth along the amplitude.
    found = along_amplitude(*(np.array([x]) for x in (-2.3156, 0.01, 0.0, 2.5)))
    assert found.order.tolist() == [3, 3]
    assert found.last[0] < 2.0682 < found.first[1]
    assert found.resolution[0] == pytest.approx(2.5e-3)
    for end in (*found.first, *found.last[:-1]):
        assert fr.mathieu.growth_rate(end, -2.3156) == pytest.approx(0.01, rel=1e-8)


def test_tongues_are_left_out_and_counted() -> None:
    default, strict = (
        ROD.ranges("frequency", mean=0.3, amplitude=0.3, bounds=(60.0, 200.0), **option)
        for option in ({}, {"growth_tolerance": 0})
    )
    assert default.growth_tolerance == SLOW_GROWTH
    # What the default leaves out are tongues, each of which parts a stable interval.
    assert 0 < len(strict) - len(default) <= default.tongues_left_out
    assert f"{default.tongues_left_out} tongues in which nothing grows faster than 1e-06 1/s" in repr(default)


def test_without_vibration_only_buckling_is_left_along_the_frequency() -> None:
    safe = ROD.ranges("frequency", mean=0.9 * FCR, amplitude=0.0, bounds=(50.0, 150.0))
    assert [(part.low, part.high) for part in safe] == [(50.0, 150.0)]
    assert len(ROD.ranges("frequency", mean=1.1 * FCR, amplitude=0.0, bounds=(50.0, 150.0))) == 0


def test_no_range_at_all_is_said() -> None:
    assert "safe: nowhere from 100 to 101 rad/s\n" in repr(
        ROD.ranges("frequency", mean=0.9 * FCR, amplitude=0.7 * FCR, bounds=(100.0, 101.0))
    )


def test_the_cost_follows_the_question(heard: Heard) -> None:
    # More than a thousand tongues lie below, and are not resolved, since nothing grows in them.
    asked = heard(tongue_intervals, "_growth")
    ranges = ROD.ranges("frequency", mean=0.3, amplitude=0.3, bounds=(2.0, 60.0))
    assert ranges.tongues_left_out > 1000
    assert sum(first.size for first, *_ in asked) < 10 * ranges.tongues_left_out


def test_progress_is_told_by_modes() -> None:
    told: list[tuple[int, int]] = []
    ROD.ranges("mean", amplitude=0.2 * FCR, frequency=150.0, progress=lambda *done: told.append(done))
    assert told == sorted(told)
    assert told[-1][0] == told[-1][1] > 10


@pytest.mark.slow
def test_every_end_judged_by_the_reference() -> None:
    # 1e-9 relative inside is stable, outside unstable, in the mode named; tongues wide enough to have an outside.
    for ranges, fixed in searches(ROD, 0.34 * FCR, 0.2 * FCR, 150.0, 0.0):
        ends = [(part.low, -1.0, part.low_end) for part in ranges]
        ends += [(part.high, 1.0, part.high_end) for part in ranges]
        judged = 0
        for value, outwards, cause in ends:
            if cause is None:
                continue
            for side in (1.0, -1.0):
                place = value * (1.0 + side * outwards * 1e-9)
                if side > 0.0 and any(part.low < place < part.high for part in ranges):
                    continue  # the tongue is thinner than that
                load = fr.AxialLoad(**{WORDS[ranges.quantity]: place}, **fixed)
                verdict = reference(ROD.modal_system(load, [cause[0]]).equations[0], digits=40)
                assert verdict.status == ("unstable" if side > 0.0 else "stable"), (ranges.quantity, value, cause)
                judged += 1
        assert judged >= 2


def test_tolerance_leaves_thin_tongues_out_and_says_so() -> None:
    strict = ROD.ranges("mean", amplitude=0.2 * FCR, frequency=85.0, growth_tolerance=0.0)
    lenient = ROD.ranges("mean", amplitude=0.2 * FCR, frequency=85.0, growth_tolerance=0.022 * 85.0)
    assert len(strict) > len(lenient)
    assert "growth of 1.87 1/s or less does not count" in repr(lenient)
    # F3-a: with the 100-period threshold stable up to 0.45 F_cr, exactly there is a band about 0.285.
    assert lenient.intervals[0].high / FCR == pytest.approx(0.45, abs=0.01)
    assert 0.285 * FCR not in strict
    assert strict.intervals[0].high_end is not None


def test_critical_values() -> None:
    force = ROD.critical("mean", amplitude=0.2 * FCR, frequency=150.0, growth_tolerance=0.01)
    assert force == ROD.ranges("mean", amplitude=0.2 * FCR, frequency=150.0, growth_tolerance=0.01).intervals[0].high
    amplitude = ROD.critical("amplitude", mean=0.34 * FCR, frequency=150.0, growth_tolerance=0.05)
    sides = ROD.is_stable(
        mean=0.34 * FCR,
        amplitude=amplitude * np.array([1.0 - 1e-9, 1.0 + 1e-6]),
        frequency=150.0,
        growth_tolerance=0.05,
    )
    assert sides.tolist() == [True, False]
    # Already buckled, and never buckled within reach.
    long = ROD.replace(length=31.0)
    assert long.critical("amplitude", mean=1.2 * FCR, frequency=10.0) == 0.0
    assert ROD.critical("mean", amplitude=1e-6 * FCR, frequency=1e4, growth_tolerance=1.0) == pytest.approx(
        min(_static(m) for m in range(1, 30)), rel=0.1
    )


def _static(mode: int) -> float:
    """Mean force that buckles a mode without vibration."""
    w = mode * math.pi / ROD.length
    return ROD.flexural_rigidity * w**2 + ROD.mass_per_length * ROD.pendulum_frequency**2 / w**2


@pytest.mark.slow
@pytest.mark.parametrize(("mean", "amplitude", "omega"), [(0.2, 0.2, 150.0), (0.34, 0.2, 150.0), (0.5, 0.4, 85.0)])
def test_margins_in_every_direction(mean: float, amplitude: float, omega: float) -> None:
    load = fr.AxialLoad(mean * FCR, amplitude * FCR, omega)
    result = ROD.stability(load, growth_tolerance=1e-3)
    for name, margin in (("amplitude", result.amplitude_margin), ("frequency", result.frequency_margin)):
        assert margin.nearest == min(margin) < math.inf
        for sign, distance in zip((-1.0, 1.0), margin, strict=True):
            if math.isinf(distance):
                continue
            values = {"mean": load.mean, "amplitude": load.amplitude, "frequency": load.frequency}
            here = values.pop(name)
            steps = here + sign * distance * np.append(np.linspace(0.0, 1.0 - 1e-7, 500), 1.0 + 1e-6)
            found = ROD.is_stable(**{name: steps}, **values, growth_tolerance=1e-3)
            assert (found[:-1] == result.stable).all()
            assert found[-1] != result.stable


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ROD.ranges("mean", amplitude=0.1, frequency=150.0, bounds=(0.1, -1.0)), "bounds must increase"),
        (
            lambda: ROD.ranges("amplitude", mean=0.1, frequency=150.0, bounds=(-0.1, 1.0)),
            r"bounds\[0\] must be zero or more",
        ),
        (
            lambda: ROD.ranges("mean", amplitude=0.1, frequency=150.0, bounds=(0.0, 1e13)),
            r"bounds\[1\] must lie between",
        ),
        (lambda: ROD.ranges("mean", amplitude=-0.1, frequency=150.0), "amplitude must be zero or more"),
        (lambda: ROD.ranges("amplitude", mean=0.1, frequency=0.0), "frequency must be greater than zero"),
        (lambda: ROD.ranges("frequency", mean=0.1, amplitude=0.1, bounds=(5.0, 1.0)), "bounds must increase"),
        (
            lambda: ROD.ranges("frequency", mean=0.1, amplitude=0.1, bounds=(0.0, 1.0)),
            r"bounds\[0\] must be greater than zero",
        ),
        (
            lambda: ROD.critical("amplitude", mean=0.1, frequency=1.0, growth_tolerance=math.nan),
            "growth_tolerance must be finite",
        ),
    ],
)
def test_bad_questions(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()  # type: ignore[operator]


@pytest.mark.slow
def test_tongues_thinner_than_rounding_end_a_search() -> None:
    """Far below the modes' frequencies ends of tongues are neighbouring doubles, between which no place is left."""
    rod = fr.Rod.nitinol()
    assert rod.critical("amplitude", mean=0.3, frequency=0.1) == pytest.approx(1.389778981186, rel=1e-11)


def test_bands_too_thin_for_the_table_stand_above_it() -> None:
    """Whoever adds up the rows and the middles above them has every unstable band, and the full table is whole."""
    found = ROD.ranges("frequency", mean=0.3 * FCR, amplitude=0.1 * FCR, bounds=("15Hz", "40Hz"), growth_tolerance=0.01)
    report, full = found.report(), found.report(full=True)
    (above,) = [text for _, text in report.lines if "unstable band" in text]
    count = int(above.split()[0])
    middles = [float(each) for each in above.split(" in Hz: ")[1].split(";")[0].split(", ")]
    assert report.table is not None
    rows = [[float(end) for end in row[0].split(" to ")] for row in report.table.rows]
    hertz = [(band.low / math.tau, band.high / math.tau) for band in found.unstable]
    assert len(middles) == count > 0
    assert len(rows) + count == len(hertz)
    for low, high in hertz:
        listed = any(first <= low and high <= last for first, last in rows)
        assert listed != any(abs(middle - 0.5 * (low + high)) <= 5e-3 for middle in middles)
    assert not any("narrower than the last digit" in text for _, text in full.lines)
    assert full.table is not None
    assert len([row for row in full.table.rows if row[1] == "unstable"]) == len(hertz)
