"""Rods under measured forces: the verdict is that of the force without noise; records stand for loads everywhere."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import depth
from tests.coupled_cases import by_name
from tests.inside import Answers, CoupledModel

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")  # third harmonics of fast loads

ROD = fr.Rod.nitinol().replace(damping_rate=0.3)
FCR = ROD.critical_force


def clean_load(rng: np.random.Generator) -> fr.AxialLoad:
    """Return a load with three harmonics, in units of the rod's own force and frequency."""
    sizes = np.array([1.0, rng.uniform(0.3, 1.0), rng.uniform(0.2, 0.6)])
    waveform = tuple((sizes * np.exp(2j * math.pi * rng.random(3))).tolist())
    mean, amplitude = rng.uniform(0.1, 0.5) * FCR, rng.uniform(0.02, 0.15) * FCR
    return fr.AxialLoad(mean, amplitude, rng.uniform(80.0, 250.0), waveform=waveform)


def force(load: fr.AxialLoad, t: np.ndarray) -> np.ndarray:
    """Return the force of a load over time."""
    waves = [h * np.exp(1j * k * load.frequency * t) for k, h in enumerate(load.waveform, start=1)]  # type: ignore[arg-type]
    return np.asarray(load.mean + load.amplitude * np.sum(waves, axis=0).real)


def recorded(load: fr.AxialLoad, rng: np.random.Generator) -> fr.ForceRecord:
    """Return 7.3 periods of a load, sampled with 5 % noise."""
    period = 2.0 * math.pi / load.frequency
    t = np.arange(0.0, 7.3 * period, period / 128)
    clean = force(load, t)
    noise = 0.05 * np.std(clean) * rng.standard_normal(t.size)
    return fr.ForceRecord(t, clean + noise)


@pytest.mark.slow
def test_verdicts_are_those_of_the_clean_force() -> None:
    rng = np.random.default_rng(14)
    count = depth(100, 20)
    looked_at = agreeing = unstable = undecided = covered = 0
    while looked_at < count:
        load = clean_load(rng)
        # Away from boundaries: alike with one per cent more or less of everything.
        near = [(1.0, 1.0, 1.0), (1.01, 1.01, 1.0), (0.99, 0.99, 1.0), (1.0, 1.0, 1.002), (1.0, 1.0, 0.998)]
        loads = [(a * load.mean, b * load.amplitude, c * load.frequency) for a, b, c in near]
        verdicts = {ROD.is_stable(load, **by_name(*numbers)) for numbers in loads}
        if len(verdicts) != 1:
            continue
        looked_at += 1
        (stable,) = verdicts
        unstable += not stable
        record = recorded(load, rng)
        agreeing += ROD.stability(record.load).stable == stable
        if looked_at % 10 == 0:  # with the noise, which takes ten times as long
            verdict = ROD.stability(record)
            agreeing -= verdict.stable is (not stable)
            undecided += verdict.stable is None
            covered += abs(verdict.growth_rate - ROD.stability(load).growth_rate) <= verdict.error
    assert agreeing >= 0.99 * count
    assert undecided <= 0.02 * count
    assert covered >= 0.08 * count  # of a tenth; two standard errors: some 95 %
    assert 0.2 * count <= unstable <= 0.8 * count


@pytest.mark.slow
def test_near_a_boundary_the_noise_leaves_the_verdict_open() -> None:
    """On it some one in six is decided all the same: errors are drawn as if independent."""
    rng = np.random.default_rng(8)
    load = fr.AxialLoad(0.3 * FCR, 0.1 * FCR, 150.0, waveform=(-1j, 0.5))
    edge = ROD.critical("amplitude", load)
    found = {}
    near, far = depth(30, 3), depth(6, 1)
    for share, count in ((0.8, far), (1.0, near), (1.2, far)):
        verdicts = [ROD.stability(recorded(replace(load, amplitude=share * edge), rng)) for _ in range(count)]
        found[share] = [verdict.status for verdict in verdicts]
        for phrase in ("forces within its errors are not", "a longer record has smaller errors"):
            assert all((phrase in v.note) == (v.status == "undecided") for v in verdicts)
    assert set(found[0.8]) == {"stable"}
    assert set(found[1.2]) == {"unstable"}
    assert found[1.0].count("undecided") >= 2 * near // 3
    assert "noise in the record makes the growth rate uncertain by" in verdicts[0].note
    assert 0.0 < verdicts[0].error < verdicts[0].growth_rate


def test_a_verdict_tells_of_the_forces_within_the_noise() -> None:
    calls: list[tuple[int, int]] = []
    load = fr.AxialLoad(0.3 * FCR, 0.1 * FCR, 150.0, waveform=(-1j, 0.5))
    verdict = ROD.stability(recorded(load, np.random.default_rng(8)), progress=lambda *of: calls.append(of))
    assert isinstance(verdict, fr.results.RodStability)
    trials = len(verdict.convergence)
    assert calls == [(done, trials + 20) for done in range(1, trials + 21)]


def test_where_nothing_grows_the_note_does_not_tell_of_an_error_of_zero() -> None:
    load = fr.AxialLoad(0.1 * FCR, 0.005 * FCR, 150.0, waveform=(-1j, 0.5))
    verdict = ROD.stability(recorded(load, np.random.default_rng(8)))
    assert verdict.status == "stable"
    assert verdict.note.split("; ")[0] == "noise in the record: no mode grows at 20 forces within its errors either"


def test_a_verdict_without_noise_on_the_rod_says_what_it_takes_the_noise_for() -> None:
    load = fr.AxialLoad(0.1 * FCR, 0.005 * FCR, 150.0, waveform=(-1j, 0.5))
    record = recorded(load, np.random.default_rng(8))
    verdict, noisy = ROD.stability(record), ROD.stability(record.noisy_load)
    said = "noise taken as an error of the sensor; if the force itself is random: --noise spectrum "
    assert f"{said}(Python: record.noisy_load)" in verdict.note
    assert said in " ".join(str(verdict.report()).split())
    assert said not in noisy.note


def test_the_noise_of_chosen_modes_is_that_of_these_modes() -> None:
    """Mode 7 grows at some 7 1/s, and says nothing of the first three."""
    load = fr.AxialLoad(0.3 * FCR, 0.4 * FCR, 150.0, waveform=(-1j, 0.5))
    record = recorded(load, np.random.default_rng(0))
    few, more = ROD.stability(record, modes=range(1, 4)), ROD.stability(record, modes=iter(range(1, 9)))
    assert (few.status, few.modes, more.status) == ("stable", (1, 2, 3), "unstable")
    assert few.error < 1e-6
    assert abs(more.growth_rate - ROD.stability(load).growth_rate) < more.error < 0.1


@pytest.mark.slow
def test_what_modes_that_were_added_change_is_no_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """A verdict may take more modes than are taken under the forces within the noise."""
    record = recorded(fr.AxialLoad(0.3 * FCR, 0.4 * FCR, 150.0, waveform=(-1j, 0.5)), np.random.default_rng(0))
    expected, answers = ROD.stability(record), CoupledModel.answers

    def of_fewer(self: CoupledModel, *given: Any) -> Answers:
        found = answers(self, *given)
        return found._replace(growth=found.growth - 0.5)

    monkeypatch.setattr(CoupledModel, "answers", of_fewer)
    assert ROD.stability(record).error == pytest.approx(expected.error, rel=1e-9)


@pytest.mark.slow
def test_a_record_stands_for_its_load() -> None:
    record = recorded(fr.AxialLoad(0.3 * FCR, 0.1 * FCR, 150.0, waveform=(-1j, 0.5)), np.random.default_rng(3))
    load, numbers = record.load, (record.mean, record.amplitude, record.frequency)
    verdict, fitted = ROD.stability(record), ROD.stability(load)
    assert verdict.error >= fitted.error
    assert replace(verdict, error=fitted.error, note=fitted.note) == fitted
    assert (
        ROD.is_stable(record, **by_name(*numbers))
        == ROD.is_stable(load, **by_name(*numbers))
        == ROD.stability(load).stable
    )
    found = ROD.ranges("amplitude", record, mean=record.mean, frequency=record.frequency)
    assert found.intervals == ROD.ranges("amplitude", load, mean=record.mean, frequency=record.frequency).intervals
    chart = fr.stability_map(ROD, record, mean=(0.0, FCR, 3), amplitude=record.amplitude, frequency=(100.0, 200.0, 3))
    assert chart.stable.shape == (3, 3)
    wave = fr.AxialWave(*numbers, waveform=record.waveform, far_end="driven")
    assert ROD.stability(wave).growth_rate == pytest.approx(ROD.stability(load).growth_rate, rel=0.05)
    with pytest.raises(ValueError, match="friction needs independent modes"):
        ROD.stability(record, friction=0.1, kick=0.05)
    with pytest.raises(TypeError, match="load must be an AxialLoad, AxialWave or ForceRecord, got 3"):
        ROD.stability(3)  # type: ignore[arg-type]


def test_the_fit_is_the_force() -> None:
    record = recorded(fr.AxialLoad(0.3 * FCR, 0.1 * FCR, 150.0, waveform=(-1j, 0.5)), np.random.default_rng(3))
    t = np.linspace(0.0, record.period, 50)
    assert record.force(t) == pytest.approx(force(record.load, t), abs=1e-12 * FCR)
    still = replace(record.load, amplitude=0.0)
    assert np.ptp(force(still, t)) == 0.0


def test_the_modes_named_are_those_whose_own_equations_grow() -> None:
    rng = np.random.default_rng(5)
    rod, seen = ROD.replace(damping_rate=0.0), 0
    count = depth(30, 5)
    for _ in range(count):
        load = clean_load(rng)
        verdict = rod.stability(load)
        rates = {}
        for mode in range(1, 16):
            (unit,) = rod.modal_system(fr.AxialLoad(load.mean, 1.0, load.frequency), [mode]).equations
            z = unit.alpha * load.amplitude * load.harmonics
            own = fr.stability(fr.Hill(unit.beta, cosines=tuple(z.real), sines=tuple(-z.imag)))
            if own.status == "unstable" and own.growth_rate * load.frequency > 1e-6:
                rates[mode] = own.growth_rate * load.frequency
        named = {r.modes[0]: r.growth_rate for r in verdict.resonances if r.growth_rate > 1e-6}
        assert named == pytest.approx(rates, rel=1e-6)
        seen += len(rates)
        if rates:
            assert verdict.fastest_mode == max(rates, key=rates.__getitem__)
    assert seen >= 0.2 * count


def random_alone(size: float, shape: slice = slice(None)) -> fr.ForceRecord:
    """Return a record of a random force with one density at the frequencies of a slice, of 4001.

    ``size`` is the root mean square in N of the force at all of them.
    """
    shares = np.zeros(4001)
    shares[shape] = 1.0
    waves = np.fft.rfft(np.random.default_rng(3).standard_normal(8000)) * shares
    return fr.ForceRecord(np.arange(8000) * 0.005, 0.3 * FCR + size * np.fft.irfft(waves), harmonics=0)


def test_a_verdict_that_densities_leave_undecided_names_the_growth_and_the_mean_of_even_ones() -> None:
    record = random_alone(0.246)
    verdict = ROD.stability(record.noisy_load)
    assert verdict.status == "undecided"
    grows = re.search(r"forces within its errors are not, under which the rod grows at up to (\S+) 1/s;", verdict.note)
    assert grows is not None
    drawn = (ROD.stability(load).growth_rate for load in record.noisy_load._within_errors(20))
    assert float(grows[1]) == pytest.approx(max(drawn), rel=0.05)
    density = re.search(r'\(Python: noise="(.*)" of the load\)', verdict.note)
    assert density is not None
    assert ROD.stability(replace(record.load, noise=density[1])).status == "stable"
    assert replace(record.load, noise=density[1]).noise == pytest.approx(2.0 * 0.005 * 0.246**2, rel=0.05)
    uneven = ROD.stability(random_alone(0.246, slice(2000)).noisy_load)
    assert "within its errors are not, under which the rod grows" in uneven.note
    assert "one density" not in uneven.note


def test_a_record_of_even_noise_is_judged_as_its_density_is() -> None:
    """Records of 40 s; high modes grow from a factor of 1 on, just below which averages over few frequencies doubt."""
    beyond = fr.AxialLoad(0.3 * FCR, 0.0, 10.0, noise=1.0)
    critical = math.sqrt(100.0 * float(ROD.critical("noise", beyond)))  # root mean square in N below 100 Hz
    for factor, status in ((0.6, "stable"), (0.97, "undecided"), (1.15, "unstable")):
        assert ROD.stability(random_alone(critical * math.sqrt(factor)).noisy_load).status == status


def test_noise_that_may_take_all_stiffness_is_white_to_a_mode_where_it_is_even() -> None:
    """It matters where it is slow: there it may make modes grow, and the growth of those that do is a range."""
    rod = ROD.replace(damping_rate=1.0)
    even = rod.stability(random_alone(0.6).noisy_load)
    assert even.status == "unstable"
    assert max(even.evidence.growth_errors) < 1e-6 < even.growth_rate
    slow = rod.stability(random_alone(2.0, slice(300)).noisy_load)
    assert slow.status == "undecided"
    assert "changes the stiffness slowly: the mode may grow" in slow.undecided_by
    some = rod.stability(random_alone(2.0, slice(800)).noisy_load)
    less, more = some.evidence.growth_errors
    assert some.status == "unstable"
    assert less < 0.1 * some.growth_rate < 0.1 * more
    assert re.search(r"growth from \S+ to \S+ 1/s, estimated, as the noise is uneven or slow", str(some.report()))


@pytest.mark.slow
def test_damping_that_ends_growth_is_found_under_strong_noise() -> None:
    """As for one density at all frequencies."""
    rod = ROD.replace(damping_rate=0.3)
    verdict = rod.stability(random_alone(0.45).noisy_load)
    assert verdict.status == "unstable"
    damping = verdict.damping_to_stabilise
    even = rod.stability(fr.AxialLoad(0.3 * FCR, 0.0, 10.0, noise=2.0 * 0.005 * 0.45**2))
    assert damping == pytest.approx(even.damping_to_stabilise, rel=0.1)
    for factor, grows in ((0.99, True), (1.01, False)):
        damped = rod.replace(damping_rate=factor * damping).stability(verdict.load)
        assert (damped.growth_rate > 0.0) == grows
    text = str(verdict.report(margins=verdict.margins(seconds=0.1)))
    assert f"no mode grows in mean square with every damping_rate tried above {damping:.6g} 1/s" in text
