"""Answers about rods whose modes are coupled, held against each other: arrays, maps, ranges, margins, shapes."""

from __future__ import annotations

import copy
import functools
import math
import pickle
from typing import Any, cast

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.rod.mode_equations import coupled_samples
from tests.conftest import depth, some
from tests.coupled_cases import by_name
from tests.inside import CoupledModel, CoupledModes, Load, Loads, Resonance, modes_needed
from tests.seams import Heard, Tuned

PLAIN = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05)
"""A rod of few modes, m_cr = 2.4."""

ROD = PLAIN.replace(inclination=1.0, ends="clamped-hinged", damping_rate=0.02)
UNIT, SWING = ROD.critical_force, ROD.pendulum_frequency
MEAN, AMPLITUDE, FREQUENCY = 0.3 * UNIT, 0.4 * UNIT, 2.0 * SWING
KINDS: dict[str, Load] = {
    "sine": fr.AxialLoad(0.0, 0.0, 1.0, mean_at=0.3),
    "harmonics": fr.AxialLoad(0.0, 0.0, 1.0, waveform=(0.7 - 0.4j, 0.0, 0.5 + 0.3j)),
    "wave": fr.AxialWave(0.0, 0.0, 1.0, far_end="held", axial_damping=3.0),
    "driven": fr.AxialWave(0.0, 0.0, 1.0, far_end="driven", mean_at=None),
}


def load(kind: str = "sine", mean: float = MEAN, amplitude: float = AMPLITUDE, frequency: float = FREQUENCY) -> Load:
    """Return a load of a kind."""
    return KINDS[kind].with_numbers(mean, amplitude, frequency)


@functools.cache
def verdict(kind: str = "sine") -> fr.results.RodStability:
    """Return the verdict under a load of a kind, which makes the rod grow."""
    found = ROD.stability(load(kind))
    assert isinstance(found, fr.results.RodStability)
    assert found.status == "unstable"
    return found


def scan(varied: str, values: np.ndarray, kind: str = "sine", rod: fr.Rod = ROD, tolerance: float = 1e-6) -> np.ndarray:
    """Return where a rod is stable along one quantity of the load."""
    numbers = {"mean": MEAN, "amplitude": AMPLITUDE, "frequency": FREQUENCY} | {varied: values}
    return np.asarray(rod.growth_rate(KINDS[kind], **numbers) <= tolerance)


# --- one load and many ---


@pytest.mark.parametrize("kind", [pytest.param(kind, marks=[pytest.mark.slow] * (kind != "sine")) for kind in KINDS])
def test_arrays_say_what_single_verdicts_do(kind: str, rng: np.random.Generator) -> None:
    size = depth(6, 2)
    numbers = (
        rng.uniform(-0.2, 0.9, size) * UNIT,
        rng.uniform(0.0, 0.6, size) * UNIT,
        rng.uniform(1.0, 4.0, size) * SWING,
    )
    like = KINDS[kind]
    verdicts = ROD.verdicts(like, **by_name(*numbers))
    growth = ROD.growth_rate(like, **by_name(*numbers))
    assert verdicts.dtype == np.int8
    assert ROD.verdicts(like, **by_name(*numbers), workers=1).tolist() == verdicts.tolist()
    assert ROD.verdicts(like, **by_name(*numbers), workers=2).tolist() == verdicts.tolist()
    assert ROD.growth_rate(like, **by_name(*numbers), workers=2).tolist() == growth.tolist()
    rate, mode = ROD.growth_rate(like, **by_name(*numbers), return_mode=True)
    assert rate.tolist() == growth.tolist()
    assert mode.tolist() == np.where(growth > 0.0, -1, 0).tolist()
    for i, (mean, amplitude, frequency) in enumerate(zip(*numbers, strict=True)):
        single = ROD.stability(like.with_numbers(mean, amplitude, frequency))
        if single.status != "undecided" and verdicts[i] != -1:
            assert (verdicts[i] == 1) == single.stable, (mean, amplitude, frequency)
        assert growth[i] == pytest.approx(single.growth_rate, rel=1e-4, abs=1e-4)
        if verdicts[i] != -1:
            assert ROD.is_stable(like, mean=mean, amplitude=amplitude, frequency=frequency) == (verdicts[i] == 1)


def test_shapes_broadcast_and_scalars_stay_scalars() -> None:
    means = np.array([[0.1], [0.3]]) * UNIT
    frequencies = np.array([1.5, 2.0, 3.1]) * SWING
    growth = ROD.growth_rate(mean=means, amplitude=AMPLITUDE, frequency=frequencies)
    assert growth.shape == ROD.is_stable(mean=means, amplitude=AMPLITUDE, frequency=frequencies).shape == (2, 3)
    # As many modes as a group of frequencies needs, so that fewer loads may differ by what those left out change.
    assert growth[1, 1] == pytest.approx(
        ROD.growth_rate(mean=means[1, 0], amplitude=AMPLITUDE, frequency=frequencies[1]), rel=1e-6
    )
    assert np.ndim(ROD.growth_rate(mean=MEAN, amplitude=AMPLITUDE, frequency=FREQUENCY)) == 0
    assert bool(ROD.is_stable(mean=MEAN, amplitude=AMPLITUDE, frequency=FREQUENCY)) is False
    assert int(ROD.verdicts(mean=0.0, amplitude=0.0, frequency=FREQUENCY)) == 1
    assert ROD.growth_rate(mean=[], amplitude=AMPLITUDE, frequency=FREQUENCY).shape == (0,)
    with pytest.raises(ValueError, match="broadcast"):
        ROD.growth_rate(mean=[1.0, 2.0], amplitude=[1.0, 2.0, 3.0], frequency=FREQUENCY)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sine", pytest.param("wave", marks=pytest.mark.slow)])
def test_maps_say_what_arrays_do(kind: str) -> None:
    like = KINDS[kind]
    means, frequencies = np.linspace(0.0, 0.8, 4) * UNIT, np.linspace(1.2, 3.5, 5) * SWING
    chart = fr.stability_map(ROD, like, mean=means, amplitude=AMPLITUDE, frequency=frequencies, growth=True)
    expected = ROD.growth_rate(like, mean=means[:, None], amplitude=AMPLITUDE, frequency=frequencies)
    assert chart.growth_rate == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert (
        chart.stable.tolist()
        == (ROD.verdicts(like, mean=means[:, None], amplitude=AMPLITUDE, frequency=frequencies) == 1).tolist()
    )
    tolerant = fr.stability_map(ROD, like, mean=means, amplitude=AMPLITUDE, frequency=frequencies, growth_tolerance=0.5)
    apart = np.abs(expected - 0.5) > 1e-4
    assert tolerant.stable[apart].tolist() == (expected <= 0.5)[apart].tolist()


# --- tolerance ---


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", ["sine", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("harmonics", "wave"))]
)
def test_a_tolerance_divides_loads_by_their_growth(kind: str) -> None:
    rate, numbers = verdict(kind).growth_rate, (MEAN, AMPLITUDE, FREQUENCY)
    for tolerance, expected in ((0.99 * rate, "unstable"), (1.01 * rate, "stable")):
        found = ROD.stability(load(kind), growth_tolerance=tolerance)
        assert found.status == expected
        assert found.growth_tolerance == tolerance
        assert found.growth_rate == pytest.approx(rate, rel=1e-5)
        assert bool(found.unstable_modes) == (expected == "unstable")
        assert ROD.verdicts(KINDS[kind], **by_name(*numbers), growth_tolerance=tolerance) == (expected == "stable")
    found = ROD.stability(load(kind), growth_tolerance=rate)
    assert found.status == "undecided" or found.error < 1e-6 * rate


# --- margins and ranges against scans ---


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "quantity"),
    [
        pytest.param("wave", "amplitude", marks=pytest.mark.slow),
        pytest.param("sine", "mean", marks=pytest.mark.slow),
        pytest.param("sine", "frequency", marks=pytest.mark.slow),
        pytest.param("wave", "mean", marks=pytest.mark.slow),
        ("sine", "amplitude"),
        pytest.param("wave", "frequency", marks=pytest.mark.slow),
    ],
)
def test_margins_are_where_a_scan_changes(kind: str, quantity: str) -> None:
    found = verdict(kind)
    here = getattr(found.load, quantity)
    margin = getattr(found, "mean_force_margin" if quantity == "mean" else f"{quantity}_margin")
    assert margin.nearest == min(margin.below, margin.above) > 0.0
    for distance, sign in ((margin.below, -1.0), (margin.above, 1.0)):
        if math.isinf(distance):
            continue
        near = here + sign * distance * np.array([0.02, 0.5, 0.999, 1.001])
        stable = scan(quantity, near, kind, tolerance=found.margin_tolerance)
        assert stable.tolist() == [False, False, False, True]


BOUNDS = {"mean": (0.0, 1.2 * UNIT), "amplitude": (0.0, 0.8 * UNIT), "frequency": (1.5 * SWING, 3.5 * SWING)}


@pytest.mark.parametrize(
    ("kind", "quantity"),
    [
        pytest.param(kind, quantity, marks=pytest.mark.slow)
        for kind in ("driven", "sine")
        for quantity in some(("mean", "amplitude", "frequency"), 2, 1)
    ],
)
def test_ranges_are_those_of_a_scan(kind: str, quantity: str) -> None:
    bounds = BOUNDS[quantity]
    load = KINDS[kind].with_numbers(MEAN, AMPLITUDE, FREQUENCY)
    called: list[tuple[int, int]] = []
    found = ROD.ranges(
        quantity,  # type: ignore[arg-type]  # a parameter of the test
        load,
        bounds,
        growth_tolerance=0.01,
        progress=lambda done, of: called.append((done, of)),
    )
    assert called[-1][0] == called[-1][1] > 0
    assert 0.0 < found.resolution <= (bounds[1] - bounds[0]) / 256.0 * (1.0 + 1e-9)
    assert len(found) > 0
    values = np.linspace(*bounds, depth(307, 101))
    stable = scan(quantity, values, kind, tolerance=0.01)
    said = np.array([value in found for value in values.tolist()])
    differ = np.flatnonzero(stable != said)
    # Only parts narrower than the resolution may have been missed, and rounding decides at an end.
    step = values[1] - values[0]
    for run in np.split(differ, np.flatnonzero(np.diff(differ) > 1) + 1):
        assert run.size * step <= found.resolution
    for part in found:
        assert part.low < part.high
        for end, cause, sign in ((part.low, part.low_end, -1.0), (part.high, part.high_end, 1.0)):
            if cause is None:
                assert end in bounds
                continue
            assert isinstance(cause, Resonance)
            near = min(2e-4 * (bounds[1] - bounds[0]), 0.25 * (part.high - part.low))
            close = np.array([end - sign * near, end + sign * near])
            assert scan(quantity, close, kind, tolerance=0.01).tolist() == [True, False]
    text = repr(found)
    assert "may have been missed" in text
    assert "resonance" in str(found.report(full=True))


@pytest.mark.slow
def test_ends_whose_cause_cannot_be_named_are_ends_of_unstable_parts(tuned: Tuned) -> None:
    bounds = (0.0, 0.6 * UNIT)
    named = ROD.ranges("amplitude", KINDS["sine"], bounds, mean=MEAN, frequency=FREQUENCY, growth_tolerance=0.01)
    tuned(modes_whose_resonances_are_named=2)  # in place of 200
    found = ROD.ranges("amplitude", KINDS["sine"], bounds, mean=MEAN, frequency=FREQUENCY, growth_tolerance=0.01)
    assert [part[:2] for part in found] == [part[:2] for part in named]
    assert isinstance(named.intervals[0].high_end, Resonance)
    first = found.intervals[0]
    assert (first.low_end, first.high_end) == (None, "unnamed")
    assert "   end of the search ... not named\n" in str(found.report(full=True))
    assert first.low in found
    assert first.high not in found


WIRE = fr.Rod.nitinol().replace(damping_rate=0.5)
CASES = {
    # Of several bands the first, 1.7 rad/s wide in a search up to 180; `ranges` finds it, too.
    "clamped": (WIRE.replace(ends="clamped"), (0.1, 0.1, 20.0), 102.060348),
    "inclined": (WIRE.replace(inclination=1.2), (0.2, 0.15, 30.0), 92.841736),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", ["clamped", "inclined"])
def test_a_margin_ends_where_the_stable_range_does(case: str) -> None:
    rod, (mean, amplitude, frequency), end = CASES[case]
    numbers = mean * WIRE.critical_force, amplitude * WIRE.critical_force
    margin = rod.stability(fr.AxialLoad(*numbers, frequency)).frequency_margin
    assert frequency + margin.above == pytest.approx(end, rel=1e-7)
    load = fr.AxialLoad(*numbers, frequency)
    ranges = rod.ranges("frequency", load, (0.8 * end, 1.05 * end), growth_tolerance=1e-6)
    assert frequency + margin.above == pytest.approx(ranges.intervals[0].high, rel=1e-8)
    assert 0.0 < margin.resolution < 1.0
    assert margin.searched[1] == margin.above
    assert 0.0 < margin.searched[0] < frequency


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["mean", "amplitude", "frequency"])
def test_margins_stay_within_ranges(quantity: Any) -> None:
    # The stable range about a load ends where its margin does, within what both say they may miss.
    rod, at = ROD.replace(damping_rate=0.1), {"mean": MEAN, "amplitude": 0.02 * UNIT, "frequency": 1.4 * SWING}
    found = rod.stability(fr.AxialLoad(**at), growth_tolerance=0.01)
    assert found.stable
    margin = found.margin(quantity)
    here = at[quantity]
    below, above = (min(size, reach) for size, reach in zip(margin, margin.searched, strict=True))
    bounds = (max(here - below, 0.0 if quantity == "amplitude" else -math.inf), here + above * 1.01)
    ranges = rod.ranges(quantity, fr.AxialLoad(**at), bounds, growth_tolerance=0.01)
    inside = [part for part in ranges if part.low <= here <= part.high]
    assert len(inside) == 1
    if math.isfinite(margin.above):
        assert inside[0].high == pytest.approx(here + margin.above, abs=ranges.resolution + margin.resolution)
    else:
        assert inside[0].high == bounds[1]


@pytest.mark.slow
def test_a_band_that_fewer_modes_have_elsewhere_ends_a_margin() -> None:
    # 0.0007 N wide, and shifted by 0.0006 N where fewer than all modes are asked.
    rod = fr.Rod(
        101742419789.73457,
        7810.495309075631,
        0.0004800379058778047,
        0.8263256805198368,
        0.0006986247439141004,
        6.842908995172754,
        fluid_inside=1326.335543039406,
        added_mass_coefficient=3.9073343558760207,
        inclination=1.363339261063933,
        ends="free-clamped",
    )
    waveform = (0.662437 - 0.651627j, 0.0628053 - 0.110371j, -0.122686 + 0.0358046j)
    push = fr.AxialLoad(0.7128337080158016, 0.07277299918, 383.457372022089, mean_at=0.0, waveform=waveform)
    margin = rod.stability(push).amplitude_margin
    assert push.amplitude + margin.above == pytest.approx(0.15093, abs=2e-4)


def test_a_margin_is_searched_with_the_modes_of_each_piece() -> None:
    found = PLAIN.replace(inclination=1.0).stability(load())
    assert isinstance(found, fr.results.RodStability)
    few = PLAIN.replace(inclination=1.0).stability(load(), range(1, 9))
    assert isinstance(few, fr.results.RodStability)
    piece = (FREQUENCY, 9.0 * FREQUENCY)
    needed = modes_needed(found.rod, load(), Loads.single(load(frequency=piece[1])), 1e-6)
    chosen, asked = (
        cast(CoupledModel, verdict.model).modes_of_piece(verdict, "frequency", piece) for verdict in (found, few)
    )
    assert chosen.count == max(needed, found.modes_checked)
    assert asked.count == 8


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")  # of the longer rod
@pytest.mark.parametrize(
    ("length", "hasty_seconds", "seconds"),
    # Of the longer rod a change at 972.9 rad/s was one of the modes left out.
    [(12.0, 0.1, 0.4), pytest.param(25.0, 0.5, 2.5, marks=pytest.mark.slow)],
)
def test_a_search_that_would_take_long_says_how_far_it_went(
    length: float, hasty_seconds: float, seconds: float
) -> None:
    rod = fr.Rod.nitinol().replace(inclination=1.0, length=length)
    found = rod.stability(fr.AxialLoad(0.3, 0.3, 150.0))
    hasty = found.margin("frequency", seconds=hasty_seconds)
    assert hasty == (math.inf, math.inf)
    assert hasty.searched == (0.0, 0.0)
    margin = found.margin("frequency", seconds=seconds)
    assert margin == (math.inf, math.inf)
    assert 4.0 < min(margin.searched) <= max(margin.searched) < 8.0 * 150.0
    assert 0.0 < margin.resolution < 2.0
    with pytest.raises(ValueError, match="quantity must be one of"):
        found.margin("force")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="seconds must be greater than zero"):
        found.margin("mean", seconds=0.0)


def test_a_margin_reports_each_piece_of_its_search() -> None:
    told: list[tuple[int, int]] = []
    fr.Rod.nitinol().stability(fr.AxialLoad(0.2, 0.0, 150.0)).margin("mean", progress=lambda *both: told.append(both))
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert len(told) > 3  # more than both ways and the end
    assert told[-1] == (1000, 1000)


@pytest.mark.slow
def test_a_margin_reports_within_each_piece_of_its_search() -> None:
    told: list[tuple[int, int]] = []
    verdict("sine").margin("mean", seconds=2.0, progress=lambda *both: told.append(both))
    assert told == sorted(told)
    assert any(done % 100 for done, _ in told)  # hundredths of a piece
    assert told[-1] == (1000, 1000)


@pytest.mark.slow
def test_a_change_is_located_in_few_verdicts(heard: Heard) -> None:
    asked = heard(CoupledModes, "answers")
    found = ROD.replace(damping_rate=0.1).stability(fr.AxialLoad(MEAN, 0.02 * UNIT, 1.4 * SWING), growth_tolerance=0.01)
    # Where time is limited, as in reports, few modes are asked between verdicts: 17 pieces take 40 of these.
    margin = found.mean_force_margin
    assert math.isfinite(margin.above)
    assert sum(loads.size for _, loads, *_ in asked) <= 80
    # Where it is not, every fourth sample is a verdict, by choice; the change itself still takes few.
    asked.clear()
    patient = found.margin("mean")
    assert patient.above == pytest.approx(margin.above, rel=1e-9)
    sizes = [loads.size for _, loads, *_ in asked]
    assert max(sizes) == 1 + 128 // 4
    assert sizes.count(1) <= 20


@pytest.mark.slow
def test_a_margin_ends_where_a_strong_vibration_displaces_a_resonance() -> None:
    """The amplitude is nine times the mean: few modes alone have the resonance at another mean, 20 steps away."""
    rod = fr.Rod(
        304.25e6, 7139.2, 0.390896e-3, 0.0939014, 0.651991e-3, 14.27637, fluid_inside=891.736,
        added_mass_coefficient=0.53728, inclination=1.271943, ends="free-clamped",
    )  # fmt: skip
    load = fr.AxialLoad(2.30752e-3, 20.8579e-3, 167.09874, mean_at=1.0)
    verdict = rod.stability(load)
    assert verdict.stable
    grows = fr.AxialLoad(2.44e-3, load.amplitude, load.frequency, mean_at=1.0)
    assert not rod.stability(grows, growth_tolerance=0.1).stable
    assert verdict.margin("mean", seconds=1.0).above < grows.mean - load.mean


@pytest.mark.slow
def test_a_search_takes_waveforms_of_many_harmonics() -> None:
    def growth(waveform: tuple[complex, ...]) -> list[float]:
        load = fr.AxialLoad(MEAN, AMPLITUDE, FREQUENCY, waveform=waveform)
        search = coupled_samples._CoupledSamples("frequency", CoupledModes.of(ROD, load, 8), load, 0.0)
        return search._growth_of_few(np.linspace(1.0, 3.0, 9) * SWING, (-math.inf, 2.5)).tolist()

    few = growth((-1j, 0.1))
    assert max(few) > 0.01
    assert growth((-1j, 0.1, *(520 * (1e-12j,)))) == pytest.approx(few, rel=1e-6, abs=1e-9)


def test_loads_that_would_take_too_long_are_not_called_stable() -> None:
    # Their growth was that of a placeholder, 0.08 1/s, which a tolerance of 0.1 takes for stable.
    slow = Loads((1,), *(np.array([value]) for value in (2000.0, 700.0, 0.3)))
    rod = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, ends="clamped-hinged", inclination=1.0)
    modes = CoupledModes.of(rod, fr.AxialWave(500.0, 700.0, 29.0, axial_damping=3.0), 14)
    status, growth = modes.answers(slow, 0.1, quick=True)
    assert status[0] == -1
    assert math.isnan(growth[0])


def test_a_search_for_a_critical_load_that_is_stopped_says_how_far_it_came() -> None:
    told: list[tuple[int, int]] = []

    def stop(done: int, total: int) -> None:
        told.append((done, total))
        raise InterruptedError("enough")

    rod = ROD.replace(damping_rate=30.0)  # stable throughout
    with pytest.raises(InterruptedError) as caught:
        rod.critical("amplitude", mean=0.0, frequency=3.3 * SWING, progress=stop)
    (done, total), note = told[0], caught.value.__notes__[0]
    assert note == f"up to amplitude {done / total * rod.critical_force:.6g} N nothing grows"
    with pytest.raises(InterruptedError) as caught:
        fr.Rod.nitinol().critical("mean", amplitude=0.0, frequency=150.0, progress=stop)
    assert "up to mean force" in caught.value.__notes__[0]


def test_a_margin_keeps_what_is_known_of_its_search() -> None:
    margin = fr.rod.Margin(1.0, math.inf, 0.5, (1.0, 8.0))
    below, above = margin
    assert (below, above) == margin == (1.0, math.inf)
    for other in (pickle.loads(pickle.dumps(margin)), copy.deepcopy(margin)):
        assert (other.resolution, other.searched) == (0.5, (1.0, 8.0))
    assert margin.nearest == 1.0


@pytest.mark.slow
def test_critical_loads_are_where_growth_begins() -> None:
    for kind in ("sine", "wave"):
        like = KINDS[kind]
        mean = ROD.critical("mean", like, amplitude=0.1 * UNIT, frequency=FREQUENCY)
        amplitude = ROD.critical("amplitude", like, mean=MEAN, frequency=FREQUENCY)
        assert 0.0 < mean < 1.5 * UNIT
        assert 0.0 < amplitude < UNIT
        for share, expected in ((0.999, True), (1.001, False)):
            assert (
                ROD.growth_rate(like, mean=share * mean, amplitude=0.1 * UNIT, frequency=FREQUENCY) <= 1e-6
            ) == expected
            assert (
                ROD.growth_rate(like, mean=MEAN, amplitude=share * amplitude, frequency=FREQUENCY) <= 1e-6
            ) == expected
        assert not (scan("amplitude", np.linspace(0.0, 0.99, 40) * amplitude, kind) == 0).any()
    assert math.isinf(ROD.replace(damping_rate=30.0).critical("amplitude", mean=0.0, frequency=3.3 * SWING))


def test_critical_loads_of_zero_have_a_reason() -> None:
    long = PLAIN.replace(inclination=0.2, length=180.0)
    load = fr.AxialLoad(0.3 * long.critical_force, 0.3 * long.critical_force, 0.1 * long.pendulum_frequency)
    alone = r"weight along the rod alone buckles it, with 2134 N, 2\.41 critical forces, .* at the lower end"
    with pytest.warns(fr.rod.BucklingWarning, match=rf"amplitude 0 is the limit: the {alone}"):
        assert long.critical("amplitude", load) == 0.0
    with pytest.warns(fr.rod.BucklingWarning, match=rf"mean force 0 is the limit: the {alone}"):
        assert long.critical("mean", load) == 0.0
    short = PLAIN.replace(inclination=1.0)
    with pytest.warns(fr.rod.BucklingWarning, match="the mean force with the weight along the rod buckles it"):
        assert short.critical("amplitude", mean=3.0 * short.critical_force, frequency=SWING) == 0.0
    held = PLAIN.replace(ends="clamped")  # no weight along it: the mean force given is the reason
    assert held.critical("amplitude", mean=3.0 * held.critical_force, frequency=SWING) == 0.0


def test_an_undecided_start_is_not_called_unstable(monkeypatch: pytest.MonkeyPatch) -> None:
    undecided = np.array([-1], dtype=np.int8), np.array([np.nan])
    monkeypatch.setattr(CoupledModes, "_judged", lambda *_: ManyVerdicts(*undecided))
    with pytest.warns(fr.UndecidedWarning, match="without mean force could not be decided"):
        assert ROD.critical("mean", amplitude=AMPLITUDE, frequency=FREQUENCY) == 0.0


@pytest.mark.slow
def test_without_vibration_the_stiffness_decides(rng: np.random.Generator) -> None:
    rod = ROD.replace(damping_rate=float(rng.uniform(0.0, 0.5)))
    mean = rng.uniform(-0.5, 3.0, 7) * UNIT
    numbers = mean, np.where(np.arange(7) % 3, 0.0, AMPLITUDE), FREQUENCY  # some vibrate, some do not
    status, growth = rod.verdicts(**by_name(*numbers)), rod.growth_rate(**by_name(*numbers))
    for i in np.flatnonzero(numbers[1] == 0.0):
        found = rod.stability(fr.AxialLoad(float(mean[i]), 0.0, FREQUENCY))
        assert {1: "stable", 0: "unstable"}[int(status[i])] == found.status
        assert growth[i] == pytest.approx(found.growth_rate, rel=1e-6, abs=1e-9)


def test_a_buckling_load_is_undecided_without_vibration() -> None:
    modes = CoupledModes.of(ROD, load(), 12)
    low, high = 0.0, 10.0 * UNIT
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if modes.static_answers(np.array([middle])).status[0] == 1 else (low, middle)
    assert modes.static_answers(np.array([low * (1.0 - 1e-9), high, high * (1.0 + 1e-9)])).status.tolist() == [1, -1, 0]


# --- damping ---


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", ["sine", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("harmonics", "wave"))]
)
def test_damping_stabilises_from_where_it_is_said_to(kind: str) -> None:
    needed = verdict(kind).damping_to_stabilise
    assert 0.02 < needed < math.inf
    below, above = (ROD.replace(damping_rate=share * needed).stability(load(kind)) for share in (0.9999, 1.0001))
    assert below.status == "unstable"
    assert above.status == "stable"
    tolerant = ROD.stability(load(kind), growth_tolerance=0.2).damping_to_stabilise
    assert tolerant < needed
    at = ROD.replace(damping_rate=tolerant).stability(load(kind)).growth_rate
    assert at == pytest.approx(0.2, rel=1e-3)


@pytest.mark.slow
def test_no_damping_is_needed_where_nothing_grows() -> None:
    quiet = ROD.stability(load(amplitude=0.0))
    assert quiet.status == "stable"
    assert quiet.damping_to_stabilise == 0.0
    assert math.isinf(ROD.stability(load(mean=3.0 * UNIT)).damping_to_stabilise)


@pytest.mark.parametrize("rate", [3.0, 10.0])
def test_overdamped_rods_creep_back(rate: float) -> None:
    rod = ROD.replace(damping_rate=rate * SWING)
    found = rod.stability(load(amplitude=0.1 * UNIT), range(1, 9))
    assert found.status == "stable"
    assert found.exponents[0].real < 0.0
    least = np.linalg.eigvalsh(np.asarray(rod.modal_system(load(amplitude=0.0), range(1, 9)).stiffness))[0]  # type: ignore[union-attr]
    creep = rate * SWING - math.sqrt((rate * SWING) ** 2 - least)
    assert found.exponents[0].real == pytest.approx(-creep, rel=0.1)


# --- limits that are known ---


def test_harmonics_on_a_plain_rod_are_those_of_hill_equations() -> None:
    # Hinged ends and a uniform force: the modes stay apart, whatever the waveform.
    waveform = (0.4 - 0.8j, 0.3j, 0.25)
    rod = PLAIN.replace(damping_rate=0.05)
    push = fr.AxialLoad(0.4 * PLAIN.critical_force, 0.5 * PLAIN.critical_force, 2.1 * SWING, waveform=waveform)
    found = rod.stability(push)
    assert isinstance(found, fr.results.RodStability)
    rates = []
    for mode in range(1, found.modes_checked + 1):
        k2 = (mode * math.pi / rod.length) ** 2
        own = rod.flexural_rigidity / rod.mass_per_length * k2**2 + rod.pendulum_frequency**2
        scale = k2 / rod.mass_per_length
        hill = fr.Hill(
            push.mean * scale - own,  # x'' = (mean + sum a_k cos + b_k sin) x
            tuple(push.amplitude * scale * h.real for h in waveform),
            tuple(-push.amplitude * scale * h.imag for h in waveform),
            period=2.0 * math.pi / push.frequency,
            damping=0.05,
        )
        rates.append(fr.stability(hill).growth_rate)
    assert found.growth_rate == pytest.approx(max(rates), rel=1e-8)
    assert found.growth_rate > 0.1
    assert rates[found.fastest_mode - 1] > 0.0
    assert found.resonances[0].kind == "direct"


@pytest.mark.slow
def test_a_sine_may_be_written_as_a_harmonic() -> None:
    numbers = 0.3 * PLAIN.critical_force, 0.4 * PLAIN.critical_force, 2.0 * SWING
    sine, harmonic = fr.AxialLoad(*numbers), fr.AxialLoad(*numbers, waveform=(-1j,))
    apart, coupled = PLAIN.stability(sine), PLAIN.stability(harmonic)
    assert isinstance(apart, fr.results.RodStability)
    assert isinstance(coupled, fr.results.RodStability)
    assert coupled.growth_rate == pytest.approx(apart.growth_rate, rel=1e-9)
    assert coupled.fastest_mode == apart.fastest_mode
    likewise = (
        ROD.stability(load("sine")),
        ROD.stability(fr.AxialLoad(*numbers_of(load()), mean_at=0.3, waveform=(-1j,))),
    )
    assert likewise[0].growth_rate == likewise[1].growth_rate


def numbers_of(given: Load) -> tuple[float, float, float]:
    """Return mean, amplitude and frequency."""
    return given.mean, given.amplitude, given.frequency


def test_what_the_template_may_be() -> None:
    # Of the template only what is not given otherwise is taken.
    other = KINDS["wave"].with_numbers(1.0, 2.0, 3.0)
    numbers = MEAN, AMPLITUDE, FREQUENCY
    assert ROD.growth_rate(other, **by_name(*numbers)) == ROD.growth_rate(KINDS["wave"], **by_name(*numbers))
    for bad in (MEAN, "wave", ROD, [KINDS["wave"]]):
        for ask in (ROD.growth_rate, ROD.verdicts, ROD.is_stable, ROD.modal_system):
            with pytest.raises(TypeError, match=r"^load must be an AxialLoad, AxialWave or ForceRecord"):
                ask(bad, **by_name(*numbers))  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"^load must be"):
            ROD.ranges("mean", bad, amplitude=AMPLITUDE, frequency=FREQUENCY)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"^load must be"):
            ROD.critical("amplitude", bad, mean=MEAN, frequency=FREQUENCY)  # type: ignore[arg-type]


# --- what a verdict carries ---


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sine", "wave"])
def test_the_shape_belongs_to_the_fastest_solution(kind: str) -> None:
    found = verdict(kind)
    s, deflection, envelope = found.shape
    assert s[0] == 0.0
    assert s[-1] == ROD.length
    assert envelope.max() == pytest.approx(1.0)
    assert np.abs(deflection).max() == pytest.approx(1.0)
    assert (np.abs(deflection) <= envelope + 1e-9).all()
    step = s[1]
    assert np.abs([deflection[0], deflection[-1]]).max() < 1e-9
    assert abs(deflection[1]) < 20.0 * (math.pi * found.modes_checked * step / ROD.length) ** 2  # clamped at s = 0
    # Integrated over a period from the shape's own start, the solution comes back times exp(growth T).
    system, n = found.system, found.coupled.size
    first = system.as_periodic_system()
    steps = 4000
    dt = found.period / steps
    state = np.eye(2 * n)
    for i in range(steps):  # the midpoint rule
        half = 0.5 * dt * first.coefficient((i + 0.5) * dt)
        state = np.linalg.solve(np.eye(2 * n) - half, state + half @ state)
    values, vectors = np.linalg.eig(state)
    fastest = int(np.abs(values).argmax())
    assert math.log(abs(values[fastest])) / found.period == pytest.approx(found.growth_rate, rel=1e-3)
    # Both span the same: at some instant of the period the deflection is a combination of both parts of the solution.
    functions = found.coupled.basis.shapes(s / ROD.length)
    path = [vectors[:, fastest]]
    for i in range(steps):
        half = 0.5 * dt * first.coefficient((i + 0.5) * dt)
        path.append(np.linalg.solve(np.eye(2 * n) - half, path[-1] + half @ path[-1]))
    times = dt * np.arange(steps + 1)
    moving = functions.T @ (np.array(path)[:, :n] * np.exp(-found.growth_rate * times)[:, None]).T
    largest = np.abs(moving).max(axis=1)
    assert envelope == pytest.approx(largest / largest.max(), abs=5e-3)


@pytest.mark.slow
def test_a_verdict_can_be_kept_and_compared() -> None:
    found = verdict()
    again = pickle.loads(pickle.dumps(found))
    for other in (again, copy.deepcopy(found)):
        assert isinstance(other, fr.results.RodStability)
        assert repr(other) == repr(found)
        assert other.growth_rate == found.growth_rate
        assert other.load == found.load
        assert other.rod == found.rod
        assert other.convergence == found.convergence
    assert again.mean_force_margin == found.mean_force_margin
    assert hash(found) == hash(found)
    assert found == found
    with pytest.raises(TypeError, match="stable"):
        bool(found)
    assert repr(found).startswith("<unstable: ")
    assert "coupled modes" in repr(found)
    assert found.time_to_grow(math.e) == pytest.approx(1.0 / found.growth_rate)
    assert found.modes == tuple(range(1, found.modes_checked + 1))
    assert found.convergence[-1] == (found.modes_checked, found.growth_rate)
    assert found.fastest_mode in found.unstable_modes
    assert found.assumptions


def test_modes_may_be_chosen_from_the_first_on() -> None:
    many = verdict().modes_checked
    fewer = ROD.stability(load(), range(1, many - 1))
    assert isinstance(fewer, fr.results.RodStability)
    assert fewer.modes_checked == many - 2
    assert "as requested" in fewer.cutoff
    assert fewer.growth_rate == pytest.approx(verdict().growth_rate, rel=1e-3)
    for bad in ((2, 3), (1, 3), (3, 2, 1), (1, 1, 2)):
        with pytest.raises(
            ValueError, match=r"^modes of a rod whose modes are coupled must be 1 to some number.*range"
        ):
            ROD.stability(load(), bad)
    with pytest.raises(ValueError, match=r"^modes must name at least one mode"):
        ROD.stability(load(), ())
    with pytest.raises(ValueError, match=r"^modes must be at most 2000"):
        ROD.stability(load(), range(1, 2500))
    with pytest.raises(TypeError, match=r"^modes must be a sequence"):
        ROD.stability(load(), 7)  # type: ignore[arg-type]


def test_what_the_theory_does_not_cover_is_refused() -> None:
    numbers = MEAN, AMPLITUDE, FREQUENCY
    message = r"needs independent modes, .*got clamped-hinged ends"
    for ask in (
        lambda: ROD.stability(load(), friction=0.1, kick=0.05),
        lambda: ROD.is_stable(**by_name(*numbers), friction=0.1, kick=0.05),
        lambda: ROD.critical_kick(load(), friction=0.1),
        lambda: ROD.critical_kick(**by_name(*numbers), friction=0.1),
        lambda: fr.stability_map(
            ROD, mean=(0.0, 1.0, 2), amplitude=1.0, frequency=(10.0, 20.0, 2), friction=0.1, kick=1.0
        ),
    ):
        with pytest.raises(ValueError, match="^friction " + message):
            ask()
    with pytest.raises(ValueError, match=r"^criterion " + message):
        ROD.verdicts(**by_name(*numbers), criterion=fr.FiniteTimeCriterion())
    with pytest.raises(ValueError, match=r"^mean, amplitude and frequency must be numbers"):
        ROD.modal_system(mean=[MEAN], amplitude=AMPLITUDE, frequency=FREQUENCY)
    with pytest.raises(TypeError, match=r"^load must be an AxialLoad, AxialWave or ForceRecord"):
        ROD.stability(MEAN)  # type: ignore[call-overload]


# --- extremes ---


def test_static_loads_buckle_where_stiffness_ends() -> None:
    system: Any = ROD.modal_system(load(amplitude=0.0), range(1, 15))
    assert np.linalg.eigvalsh(np.asarray(system.stiffness))[0] > 0.0
    assert ROD.stability(load(amplitude=0.0)).status == "stable"
    buckled = ROD.stability(load(mean=2.0 * UNIT, amplitude=0.0))
    assert buckled.status == "unstable"
    assert buckled.resonances[0].kind == "buckling"
    stiffness = np.asarray(ROD.modal_system(load(mean=2.0 * UNIT, amplitude=0.0), range(1, 15)).stiffness)  # type: ignore[union-attr]
    rate = math.sqrt(0.02**2 - np.linalg.eigvalsh(stiffness)[0]) - 0.02
    assert buckled.growth_rate == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize(
    "ends",
    ["free", *(pytest.param(ends, marks=pytest.mark.slow) for ends in ("hinged-free", "free-guided")), "guided"],
)
def test_rods_that_may_move_as_a_whole_are_judged(ends: str) -> None:
    rod = ROD.replace(ends=ends)
    assert rod.stability(load(mean=-0.1 * UNIT, amplitude=0.0)).status == "stable"  # on the floor
    found = rod.stability(load(mean=0.1 * UNIT))
    assert found.status in ("stable", "unstable")
    assert math.isfinite(found.growth_rate)


@pytest.mark.slow
@pytest.mark.parametrize("pull", [0.1, *(pytest.param(pull, marks=pytest.mark.slow) for pull in (3.0, 1e5)), 1e3])
def test_tension_stabilises(pull: float) -> None:
    assert ROD.stability(load(mean=-pull * UNIT, amplitude=0.05 * UNIT)).status == "stable"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mean": 1e6 * UNIT}, "^frequency must be at least .* rad/s for this rod and load.*check the units"),
        ({"mean": 1e11}, "check"),
        ({"amplitude": 1e12}, "^load needs more than .* modes: mean and amplitude come to .* N, far above"),
        ({"frequency": 1e-9}, "^frequency must be at least"),
        ({"frequency": 1e12}, "^frequency must be at most"),
    ],
)
def test_overwhelming_loads_are_refused_with_a_remedy(change: dict[str, float], message: str) -> None:
    far = load(**change)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        ROD.modal_system(far) if far.frequency > 1e6 else ROD.stability(far)
    with pytest.raises(ValueError, match=message):
        ROD.verdicts(far)


def test_a_load_too_slow_to_follow_is_undecided_with_a_reason() -> None:
    found = ROD.stability(load(amplitude=0.2 * UNIT, frequency=1e-3))
    assert found.status in ("undecided", "stable")
    assert "nan" not in repr(found)
    assert found.status == "stable" or found.note


@pytest.mark.parametrize(
    ("rod", "count", "question"),
    [
        pytest.param(*asked, question, marks=[pytest.mark.slow] * (asked[0] is ROD))
        for asked in ((ROD, 32), (PLAIN, 1500))
        for question in ("verdicts", "is_stable", "growth_rate")
    ],
)
def test_arrays_of_loads_tell_their_progress_and_change_nothing(rod: fr.Rod, count: int, question: str) -> None:
    """Reports grow up to all loads, and come before the last one; those without vibration are counted, too."""
    ask = getattr(rod, question)
    mean = np.linspace(0.0, 0.9 * UNIT, count)
    amplitude, frequency = np.where(mean < 0.3 * UNIT, 0.0, AMPLITUDE), np.linspace(0.9, 1.1, count) * FREQUENCY
    loads = by_name(mean, amplitude, frequency)
    told: list[tuple[int, int]] = []
    found = ask(**loads, progress=lambda done, total: told.append((done, total)))
    assert np.array_equal(found, ask(**loads))
    assert told == sorted(told)
    assert told[-1] == (count, count)
    assert {total for _, total in told} == {count}
    assert 0 < told[0][0] < count


@pytest.mark.parametrize("rod", [ROD, PLAIN], ids=["coupled", "independent"])
def test_what_progress_raises_ends_the_work(rod: fr.Rod) -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt(f"{done} of {total}")

    with pytest.raises(KeyboardInterrupt, match="of 3000"):
        rod.verdicts(mean=np.linspace(0.0, 0.5 * UNIT, 3000), amplitude=AMPLITUDE, frequency=FREQUENCY, progress=stop)
    with pytest.raises(TypeError, match="progress"):
        rod.verdicts(mean=0.0, amplitude=AMPLITUDE, frequency=FREQUENCY, progress="often")
