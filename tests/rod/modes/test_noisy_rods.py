"""Rods under a force that is partly random: verdicts in mean square, how much noise they bear, records, files."""

from __future__ import annotations

import json
import math
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.cli import main
from floquetrod.equations.batches import pick
from floquetrod.rod.mode_equations.noisy_equations import NoisyModes
from floquetrod.rod.model.contact import LeavesWallError
from floquetrod.rod.modes.noisy_verdict import NoisyModel
from tests.conftest import depth
from tests.coupled_cases import by_name
from tests.inside import Loads, load_from_dict, scaled_noise
from tests.seams import Heard

ROD = fr.Rod.nitinol().replace(damping_rate=1.0)
FCR = ROD.critical_force
CONSTANTS = ROD._modes_under().constants  # type: ignore[attr-defined]
HIGH_MODES = 8.0 * ROD.damping_rate * ROD.flexural_rigidity * ROD.mass_per_length
"""Density in N^2/Hz that high modes bear: S k^2 / 2 = 4 c w^2."""


def load(noise: Any, amplitude: float = 0.1, mean: float = 0.3) -> fr.AxialLoad:
    return fr.AxialLoad(mean * FCR, amplitude * FCR, 150.0, noise=noise)


def test_without_vibration_each_mode_bears_what_its_equation_says() -> None:
    m = np.arange(1.0, 200.0)
    squared = CONSTANTS.bending * m**4 - CONSTANTS.per_newton * m**2 * 0.3 * FCR + CONSTANTS.restoring
    most = float((8.0 * ROD.damping_rate * squared / (CONSTANTS.per_newton * m**2) ** 2).min())
    found = ROD.critical("noise", load(1.0, amplitude=0.0))
    assert found == pytest.approx(most, rel=1e-9)
    for factor, status in ((1.0 - 1e-6, "stable"), (1.0 + 1e-6, "unstable")):
        assert ROD.stability(load(factor * most, amplitude=0.0)).status == status


def test_all_high_modes_grow_beyond_the_density_that_they_bear() -> None:
    pulled = fr.AxialLoad(-1.0, 0.0, 150.0, noise=1.0)
    assert ROD.critical("noise", pulled) == pytest.approx(HIGH_MODES, rel=1e-8)
    verdict = ROD.stability(fr.AxialLoad(-1.0, 0.0, 150.0, noise=1.5 * HIGH_MODES))
    assert verdict.status == "unstable"
    assert "all high modes grow at 1 1/s" in verdict.note
    assert verdict.growth_rate >= 1.0 - 1e-3


WEAKEST = "without damping even the weakest noise makes a mode grow"


@pytest.mark.parametrize("noise", [1e-9, [(40.0, 1e-9), (50.0, 1e-9), (60.0, 0.0)]])
def test_a_rod_without_damping_is_said_to_grow_under_any_noise(noise: float | list[tuple[float, float]]) -> None:
    for damping_rate, is_said in ((0.0, True), (ROD.damping_rate, False)):
        verdict = ROD.replace(damping_rate=damping_rate).stability(fr.AxialLoad(-1.0, 0.0, 150.0, noise=noise))
        assert (verdict.status, WEAKEST in verdict.note) == ("unstable" if is_said else "stable", is_said)


def test_the_verdict_is_that_on_the_second_moments_of_each_mode() -> None:
    verdict = ROD.stability(load(0.5 * HIGH_MODES), modes=(7, 11))
    for i, mode in enumerate((7, 11)):
        equation = ROD.modal_system(load(0.0), (mode,)).equations[0]  # type: ignore[union-attr]
        k = CONSTANTS.per_newton * mode**2
        s = math.sqrt(0.25 * HIGH_MODES) * k / 150.0**1.5  # per root of unit tau
        expected = 150.0 * fr.stability(equation, noise=s).exponents[0].real
        assert verdict.mode_growth_rates[i] == pytest.approx(expected, abs=1e-8)


def test_growth_lies_between_its_bounds() -> None:
    rng = np.random.default_rng(2)
    for _ in range(depth(40, 4)):
        rod = ROD.replace(damping_rate=float(rng.uniform(0.0, 8.0)))
        force = fr.AxialLoad(
            rng.uniform(-1.0, 0.9) * FCR,
            rng.uniform(0.0, 0.5) * FCR,
            rng.uniform(100.0, 250.0),
            noise=rng.uniform(0.0, 0.02),
            waveform=(1.0, 0.2j) if rng.uniform() < 0.3 else "sine",
        )
        modes = NoisyModes(rod._modes_under().constants, force)  # type: ignore[attr-defined]
        last = int(rng.integers(8, 30))
        left_out = float(modes.growth_bounds(Loads.single(force)).left_out(np.array([last]))[0])
        parts = modes.parts(Loads((1,), *Loads.single(force).flat), [last, last + 1, last + 9])
        low, high = (bound[0] for bound in parts.growth_bounds)
        every = parts.moments(np.ones((1, 3), dtype=np.bool_))
        for i in range(3):
            found = fr.stability(pick(every, i), "monodromy").exponents[0].real * parts.rate[0, i]
            assert low[i] - 1e-6 <= found <= high[i] + 1e-6
            assert i == 0 or found <= left_out + 1e-6


def test_growth_is_that_of_the_fastest_mode_among_the_first_and_the_highest() -> None:
    """All high modes grow, lower ones faster, neither the first ones nor the last."""
    rod = fr.Rod.nitinol().replace(length=2.511216768744762, damping_rate=0.549411566455027)
    force = fr.AxialLoad(0.4564704478310943, 0.0, 147.2769511376555, noise=0.0012590242300885503)
    verdict, every = rod.stability(force), rod.stability(force, modes=range(1, 31))
    assert (verdict.fastest_mode, every.fastest_mode) == (10, 10)
    assert abs(verdict.growth_rate - every.growth_rate) <= verdict.error + every.error + 1e-14
    assert verdict.growth_rate == pytest.approx(0.0875265440731, abs=1e-12)
    assert verdict.time_to_grow() == pytest.approx(math.log(10.0) / verdict.growth_rate)
    assert set(verdict.unstable_modes) == set(every.unstable_modes) & set(verdict.modes)
    assert "and all high modes" in str(verdict)
    growth, mode = rod.growth_rate(force, return_mode=True)
    assert (growth, mode) == (pytest.approx(verdict.growth_rate, abs=1e-9), 10)


def drawn(rng: np.random.Generator, unit: bool = False) -> tuple[fr.Rod, fr.AxialLoad, float]:
    """Return a rod, long or short, damped a little or much, a load, weakly or strongly random, and a tolerance."""
    rod = ROD.replace(length=rng.uniform(0.8, 7.0), damping_rate=10.0 ** rng.uniform(-1.5, 1.7))
    if rng.uniform() < 0.1:
        rod = rod.replace(curvature=rng.uniform(-0.05, 0.1))
    high_modes = 8.0 * rod.damping_rate * rod.flexural_rigidity * rod.mass_per_length
    noise: Any = 1.0 if unit else high_modes * 10.0 ** rng.uniform(-2.0, 0.7)
    if rng.uniform() < 0.2:
        noise = ((0.0, noise), (rng.uniform(1.0, 100.0), 0.5 * noise), (rng.uniform(100.0, 600.0), 0.0))
    mean = 0.0 if rng.uniform() < 0.1 else rng.uniform(-1.0, 0.95)
    amplitude = 0.0 if rng.uniform() < 0.25 else rng.uniform(0.0, 0.6)
    force = fr.AxialLoad(
        mean * rod.critical_force,
        amplitude * rod.critical_force,
        10.0 ** rng.uniform(0.7, 2.4),
        noise=noise,
        waveform=(1.0, 0.3j) if rng.uniform() < 0.2 else "sine",
    )
    return rod, force, 0.0 if rng.uniform() < 0.7 else 10.0 ** rng.uniform(-3.0, 0.0)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
@pytest.mark.parametrize("seed", range(depth(20, 1)))
def test_growth_is_that_of_the_fastest_of_all_modes_named(seed: int) -> None:
    """Against every mode on its own, many more than were examined, without the bounds that exclude modes."""
    rng, grew = np.random.default_rng((48, seed)), 0
    draws = depth(25, 8)
    for _ in range(draws):
        rod, force, tolerance = drawn(rng)
        try:
            verdict = rod.stability(force, growth_tolerance=tolerance)
        except LeavesWallError:
            continue
        model: Any = rod._modes_under(force)
        rates = np.array(model.growth_of_modes(force, range(1, max(60, len(verdict.modes) + 20) + 1)))
        limit, close = model.growth_beyond(force), 1e-8 * (1.0 + rod.damping_rate)
        fastest = max(float(rates.max()), limit)
        assert abs(verdict.growth_rate - fastest) <= verdict.error + close
        # Of noise in a band both count what it may do where it is uneven.
        rate = 1.0 + rod.damping_rate + verdict.growth_rate
        assert verdict.status == "stable" or isinstance(force.noise, tuple) or verdict.error <= 1e-5 * rate
        if abs(fastest - tolerance) > close and not verdict.undecided_by:
            assert verdict.status == ("unstable" if fastest > tolerance else "stable")
        if verdict.fastest_mode is not None:
            assert rates[verdict.fastest_mode - 1] >= fastest - verdict.error - close
        if verdict.status == "unstable":
            growing = set((np.flatnonzero(rates > tolerance + close) + 1).tolist())
            assert growing & set(verdict.modes) <= set(verdict.unstable_modes)
            assert limit > tolerance or growing <= set(verdict.modes)
        numbers = force.mean, force.amplitude, force.frequency
        status = int(rod.verdicts(force, **by_name(*numbers), growth_tolerance=tolerance))
        assert status == {"stable": 1, "unstable": 0, "undecided": -1}[verdict.status]
        growth, mode = rod.growth_rate(force, **by_name(*numbers), return_mode=True)
        assert abs(growth - verdict.growth_rate) <= verdict.error + close
        if verdict.growth_rate > tolerance + close:  # a slower mode may be in the error, not examined
            assert mode == (verdict.fastest_mode or -1)
        grew += verdict.status == "unstable"
    assert 0 < grew < draws


def both_ways(rod: fr.Rod, force: fr.AxialLoad, tolerance: float) -> tuple[str, int]:
    """Return the verdict on one load, and that of arrays."""
    status = rod.verdicts(force, growth_tolerance=tolerance)
    return rod.stability(force, growth_tolerance=tolerance).status, int(status)


@pytest.mark.parametrize(
    ("rod", "numbers", "mode"),
    [
        (
            fr.Rod(
                4766063780.852754,
                2143.0482359694447,
                radius=0.01124387879662149,
                length=3.2354038977813966,
                channel_radius=0.2328261041550565,
                damping_rate=66.53758651111661,
            ),
            (5.610429952998382, 0.6185012786735394, 12.182026642890781),
            4,
        ),
        (
            fr.Rod.nitinol().replace(length=3.0608192459699874, damping_rate=0.10118106403204984),
            (-0.12110290799447535, 0.1721191316143035, 83.68233563823031),
            None,
        ),
        pytest.param(
            fr.Rod.nitinol().replace(length=2.0899549, damping_rate=30.607),
            (0.0, 0.4482 * FCR, 15.032),
            None,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_both_verdicts_change_within_the_error_of_the_critical_noise(
    rod: fr.Rod, numbers: tuple[float, float, float], mode: int | None
) -> None:
    told: list[tuple[int, int]] = []
    found = rod.critical("noise", fr.AxialLoad(*numbers, noise=1.0), progress=lambda *parts: told.append(parts))
    assert (found.mode, found.searched) == (mode, float(found))
    assert 0.0 < found.error <= 1e-8 * found
    for way, says in ((-2.0, ("stable", 1)), (2.0, ("unstable", 0))):
        assert both_ways(rod, fr.AxialLoad(*numbers, noise=found + way * found.error), 0.0) == says
    assert [done for done, _ in told] == list(range(1, len(told) + 1))
    assert told[-1][0] == told[-1][1]
    again = pickle.loads(pickle.dumps(found))
    assert (again, again.error, again.mode) == (found, found.error, found.mode)
    assert json.loads(json.dumps(found.as_dict()))["critical_noise_factor"] == float(found)
    assert f"{float(found):.9g} times the noise" in repr(found)


@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
@pytest.mark.parametrize("seed", range(depth(10, 1)))
def test_critical_noise_separates_verdicts_of_drawn_rods(seed: int) -> None:
    rng, separated = np.random.default_rng((49, seed)), 0
    while separated < depth(12, 2):
        rod, force, tolerance = drawn(rng, unit=True)
        try:
            found = rod.critical("noise", force, growth_tolerance=tolerance)
        except ValueError as error:
            if not re.search("stable without noise|leaves the wall", str(error)):
                raise
            continue
        if math.isinf(found):
            assert "no critical noise" in repr(found)
            continue
        if found.error > 1e-6 * found:  # of a narrow band: verdicts above are undecided, up to the error
            assert "verdicts are undecided" in repr(found)
            below, above = (scaled_noise(force.noise, factor * found) for factor in (1.0 - 1e-6, 1.0 + 1e-6))
            assert both_ways(rod, replace(force, noise=below), tolerance) == ("stable", 1)
            assert both_ways(rod, replace(force, noise=above), tolerance) == ("undecided", -1)
            continue
        for way, says in ((-2.0, ("stable", 1)), (2.0, ("unstable", 0))):
            near = replace(force, noise=scaled_noise(force.noise, found + way * found.error))
            assert both_ways(rod, near, tolerance) == says
        separated += 1


@pytest.mark.parametrize(("width", "mode"), [(0.1, 7), (1.0, 7), (3.0, 6)])
def test_the_critical_noise_of_a_narrow_band_is_where_verdicts_are_no_longer_stable(width: float, mode: int) -> None:
    """Above it they are undecided, up to its error.

    The first two make twice the frequency of mode 7 drift, 22 Hz, until it is in the band.
    """
    density = [(20.0 - width, 0.0), (20.0 - 0.5 * width, 1e-3), (20.0 + 0.5 * width, 1e-3), (20.0 + width, 0.0)]
    rod, band = ROD.replace(damping_rate=0.3), fr.AxialLoad(0.3 * FCR, 0.0, 150.0, noise=tuple(density))
    found = rod.critical("noise", band)
    assert found.mode == mode

    def status(factor: float) -> str:
        return rod.stability(replace(band, noise=scaled_noise(band.noise, factor))).status

    assert [status(share * found) for share in (0.3, 0.99, 1.0 - 1e-6)] == 3 * ["stable"]
    assert [status(share * found) for share in (1.0 + 1e-6, 1.0005)] == 2 * ["undecided"]
    assert "undecided" in repr(found)
    assert "may begin to grow" in repr(found)
    assert status(found + found.error) == "unstable"
    if mode == 6:
        assert found.error < 0.2 * found
    else:  # to the factor at which high modes buckle, to which the band is slow
        assert status(3.0 * found) == "undecided"


def test_growth_that_no_method_finds_lies_between_its_bounds() -> None:
    strong = ROD.stability(load(5e4), modes=[128])
    assert strong.mode_verdicts[0].exponents == ()
    assert 0.0 < strong.growth_rate < math.inf


def test_arrays_of_loads_say_what_single_ones_do() -> None:
    mean = np.linspace(0.1, 1.0, 10) * FCR
    like = load(0.1 * HIGH_MODES)
    together = ROD.verdicts(like, mean=mean, amplitude=0.1 * FCR, frequency=150.0)
    alone = [ROD.stability(like.varied("mean", float(each))) for each in mean]
    assert together.tolist() == [{"stable": 1, "unstable": 0}[each.status] for each in alone]
    growth = ROD.growth_rate(like, mean=mean, amplitude=0.1 * FCR, frequency=150.0)
    assert growth == pytest.approx([each.growth_rate for each in alone], abs=1e-7)
    assert np.count_nonzero(ROD.verdicts(mean=mean, amplitude=0.1 * FCR, frequency=150.0)) > np.count_nonzero(together)


def test_only_the_highest_modes_may_grow() -> None:
    like = load(1.5 * HIGH_MODES)
    growth, mode = ROD.growth_rate(like, mean=-5.0, amplitude=0.0, frequency=150.0, return_mode=True)
    assert growth == pytest.approx(ROD.stability(fr.AxialLoad(-5.0, 0.0, 150.0, noise=1.5 * HIGH_MODES)).growth_rate)
    assert (growth > 0.9, mode) == (True, -1)


def test_each_side_of_a_bend_has_its_own_modes_and_bound(heard: Heard) -> None:
    bent, asked = ROD.replace(curvature=0.5), heard(NoisyModes, "growth_bounds")
    like, told = load(0.1 * HIGH_MODES), []
    mean = np.array([-3.0, 2.0, -1.0, -0.15, 3.0]) * FCR
    status = bent.verdicts(
        like, mean=mean, amplitude=0.02 * FCR, frequency=150.0, progress=lambda done, total: told.append((done, total))
    )
    restoring = [float(modes.constants.restoring) for modes, _ in asked]
    assert restoring == pytest.approx([CONSTANTS.restoring, -CONSTANTS.restoring])
    assert told == [(3, 5), (5, 5)]
    alone = [
        bent.stability(fr.AxialLoad(each, 0.02 * FCR, 150.0, noise=like.noise)).status for each in np.delete(mean, 3)
    ]
    assert status.tolist() == [*({"stable": 1, "unstable": 0}[each] for each in alone[:3]), -1, 1]
    assert alone[3] == "stable"
    with pytest.raises(fr.LeavesWallError):
        bent.verdicts(like, mean=mean[3], amplitude=0.02 * FCR, frequency=150.0)


def test_noise_below_the_frequencies_of_modes_is_not_felt() -> None:
    slow = load(((0.5, HIGH_MODES), (1.0, HIGH_MODES)))
    quiet, noisy = (ROD.stability(each) for each in (load(0.0), slow))
    assert (quiet.status, noisy.status) == ("stable", "stable")
    assert noisy.mode_growth_rates.max() == pytest.approx(-2.0 * quiet.decay_rate, abs=1e-6)
    band = ((0.0, 10.0 * HIGH_MODES), (40.0, 10.0 * HIGH_MODES), (41.0, 0.0))
    assert ROD.stability(load(band)).status == "unstable"
    assert ROD.critical("noise", load(band)) < 1.0


@pytest.mark.slow
def test_ranges_margins_and_maps_know_noise() -> None:
    like = load(0.1 * HIGH_MODES)
    quiet = ROD.ranges("mean", amplitude=0.1 * FCR, frequency=150.0, bounds=(0.0, FCR))
    noisy = ROD.ranges("mean", like, amplitude=0.1 * FCR, frequency=150.0, bounds=(0.0, FCR))
    assert noisy.resolution > 0.0
    for part in noisy:
        assert any(one.low <= part.low and part.high <= one.high for one in quiet)
        for end, inside in ((part.low, 1.0), (part.high, -1.0)):
            if 0.0 < end < FCR:
                near = [like.varied("mean", end + inside * way * 1e-6 * FCR) for way in (1.0, -1.0)]
                assert [ROD.stability(each).status for each in near] == ["stable", "unstable"]
    assert all(band.worst_growth > 0.0 for band in noisy.unstable)
    margins = ROD.stability(like).margins()
    assert margins["mean"].below < ROD.stability(load(0.0)).margins()["mean"].below
    chart = fr.stability_map(ROD, like, mean=(0.0, FCR, 20), amplitude=0.1 * FCR, frequency=(100.0, 200.0, 10))
    flat = ROD.verdicts(like, mean=chart.y.values[:, None], amplitude=0.1 * FCR, frequency=chart.x.values)
    assert np.array_equal(chart.stable, flat == 1)
    assert "noise of" in repr(chart)


def test_ranges_under_noise_say_what_grows_and_that_growth_is_of_squares() -> None:
    like, at = load(0.1 * HIGH_MODES), {"amplitude": 0.1 * FCR, "frequency": 150.0}
    found = ROD.ranges("mean", like, bounds=(0.15 * FCR, 0.2 * FCR), **at)
    (band,) = found.unstable
    verdict = ROD.stability(like.with_numbers(band.at, 0.1 * FCR, 150.0))
    assert (band.cause, band.worst_growth) == (verdict.fastest_mode, pytest.approx(verdict.growth_rate, rel=1e-6))
    text = found.table()
    assert "growth of q^2 1/s" in text
    assert "stable in mean square" in text
    assert f"mode {band.cause}" in text
    assert "not named" not in text
    assert "twice that of amplitudes" in found.as_dict()["growth_is"]
    quiet = ROD.ranges("mean", bounds=(0.15 * FCR, 0.2 * FCR), **at)
    assert "growth_is" not in quiet.as_dict()
    assert "q^2" not in quiet.table()


def test_assumptions_say_that_single_runs_may_decay() -> None:
    assert any("single runs usually grow more slowly" in said for said in ROD.stability(load(0.1)).assumptions)


@pytest.mark.slow
def test_the_first_range_under_noise_ends_at_the_critical_load() -> None:
    like, shared = load(0.1 * HIGH_MODES), {"amplitude": 0.1 * FCR, "frequency": 150.0}
    critical, ranges = ROD.critical("mean", like, **shared), ROD.ranges("mean", like, **shared)
    assert ranges.intervals[0].high == critical
    assert ranges.intervals[0].low == 0.0
    assert ranges.resolution >= critical.resolution > 0.0


def test_a_noisy_rod_is_proved_stable_and_unstable() -> None:
    like = load(0.1 * HIGH_MODES)
    stable = ROD.certify(like, mean=0.3 * FCR, amplitude=0.1 * FCR, frequency=150.0)
    assert stable.status == "stable"
    assert "in mean square" in stable.statement
    assert ROD.certify(like, mean=0.17 * FCR, amplitude=0.1 * FCR, frequency=150.0).status == "unstable"
    assert ROD.certify(load(1.1 * HIGH_MODES), mean=0.17 * FCR, amplitude=0.0, frequency=150.0).status != "stable"


def test_a_box_in_which_some_loads_grow_is_mixed() -> None:
    like = load(0.1 * HIGH_MODES)
    found = ROD.certify(like, mean=(0.17 * FCR, 0.31 * FCR), amplitude=0.1 * FCR, frequency=150.0)
    assert (found.status, found.stable) == ("mixed", None)
    assert [each.status for each in found.examples] == ["stable", "unstable"]
    for each in found.examples:
        assert found.box[0].low <= each.load.mean <= found.box[0].high
        assert ROD.stability(each.load).status == each.status
        assert (
            ROD.certify(like, mean=each.load.mean, amplitude=each.load.amplitude, frequency=150.0).status == each.status
        )
    assert str(found.report()).count("in mean square") >= 2
    assert [each["status"] for each in found.as_dict()["examples"]] == ["stable", "unstable"]


@pytest.mark.slow
def test_a_box_of_forces_is_proved_under_noise() -> None:
    found = ROD.certify(load(0.1 * HIGH_MODES), mean=(0.29 * FCR, 0.31 * FCR), amplitude=0.1 * FCR, frequency=150.0)
    assert found.status == "stable"


def record() -> fr.ForceRecord:
    time = np.arange(4000) / 400.0
    noise = 0.1 * np.random.default_rng(1).standard_normal(time.size)
    return fr.ForceRecord(time, 0.3 * FCR + 0.1 * FCR * np.sin(150.0 * time) + noise)


def test_the_residual_of_a_record_is_its_noise() -> None:
    found = record().noise_spectrum
    density = [each for _, each in found]
    # Its mean square over half the rate, within four standard errors.
    assert density == pytest.approx([2.0 * 0.1**2 / 400.0] * 2, rel=4.0 / math.sqrt(2000.0))
    assert found[-1][0] < 200.0
    noisy = record().noisy_load
    assert noisy.load.noise == found
    assert ROD.stability(noisy).status == "stable"


def test_the_noise_of_a_load_is_kept_in_files_and_words() -> None:
    for noise in (0.02, ((1.0, 0.02), (2.0, 0.0))):
        force = fr.AxialLoad(1.0, 1.0, 10.0, noise=noise)
        data = json.loads(json.dumps(force.kind_as_dict() | {"mean": 1.0, "amplitude": 1.0, "frequency": 10.0}))
        assert load_from_dict(data) == force
        assert fr.AxialLoad(**force.as_dict()) == force
        assert "noise of" in force.features
    assert fr.AxialLoad(1.0, 1.0, 10.0, noise="0.02 N^2/Hz").noise == 0.02
    assert fr.AxialLoad(1.0, 1.0, 10.0, noise="2e-6 kN^2/Hz").noise == pytest.approx(2.0)
    assert "noise" not in fr.AxialLoad(1.0, 1.0, 10.0).kind_as_dict()


def check(*words: str) -> int:
    point = ["--mean", "0.3Fcr", "--amplitude", "0.1Fcr", "--frequency", "150", "--damping-rate", "1"]
    return main(["check", "--rod", "nitinol", *point, "--no-margins", *words])


def test_the_terminal_takes_noise(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert check("--noise", "0.0001N^2/Hz") == 0
    text = capsys.readouterr().out
    assert "STABLE in mean square: " in text
    assert "noise of 0.0001 N^2/Hz" in text
    assert check("--noise", "spectrum") == 2
    assert "--noise spectrum needs --force" in capsys.readouterr().err
    assert check("--noise", "-1") == 2
    assert "--noise must be zero or more" in capsys.readouterr().err
    path = tmp_path / "force.csv"
    rows = zip(record().time.tolist(), record().samples.tolist(), strict=True)
    path.write_text("\n".join(["time,force", *(f"{t},{f}" for t, f in rows)]), encoding="utf-8")
    assert check("--force", str(path), "--noise", "spectrum", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["in_mean_square"] is True
    (_, density), *_ = found["load"]["noise"]
    assert density == pytest.approx(2.0 * 0.1**2 / 400.0, rel=0.1)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: load(-1.0), "noise must be zero or more"),
        (lambda: load(math.nan), "noise must be"),
        (lambda: load("1 N/Hz"), "unit 'N/Hz' is not understood"),
        (lambda: load([(2.0, 1.0), (1.0, 1.0)]), "noise must have frequencies that increase"),
        (lambda: load([(2.0, -1.0)]), r"noise\[0\]\[1\] must be zero or more"),
        (lambda: fr.AxialWave(1.0, 1.0, 10.0, noise=0.1), "give an AxialLoad"),
        (lambda: ROD.stability(load(0.1), friction=0.1, kick=0.05), r"friction is not answered under .*give .*noise=0"),
        (lambda: ROD.modal_system(load(0.1)), "modal_system is not answered under noise"),
        (lambda: ROD.largest_safe_box(load(0.1)), "largest_safe_box is not answered under noise"),
        (lambda: fr.simulate(ROD, load(0.1), duration=0.01), "load must have no noise to be simulated"),
        (
            lambda: ROD.certify(load(0.1), mean=0.1, amplitude=0.1, frequency=(100.0, 150.0)),
            "frequency must be one number under noise",
        ),
        (lambda: ROD.critical("noise", load(0.0)), "load must have noise"),
        (lambda: ROD.critical("noise", load(1.0, mean=0.17)), "load must be stable without noise"),
        pytest.param(
            lambda: ROD.replace(damping_rate=0.0).critical("noise", load(1.0)),
            "load must be stable without noise",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_what_noise_cannot_be_is_told(call: Any, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        call()


def test_one_place_chooses_the_model() -> None:
    assert isinstance(ROD._modes_under(load(0.1)), NoisyModel)
    assert not isinstance(ROD._modes_under(load(0.0)), NoisyModel)
