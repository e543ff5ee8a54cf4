"""A measured force: its period, harmonics and their errors, what is refused, and files."""

from __future__ import annotations

import datetime
import functools
import math
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import scipy.fft
from numpy.typing import NDArray
from scipy.optimize import least_squares

import floquetrod as fr
from floquetrod import units
from floquetrod.rod.loads import record_file, record_fit, record_period
from tests.conftest import depth
from tests.inside import suspicions_of_record
from tests.seams import Forbidden, Heard

OMEGA = 100.0
PERIOD = 2.0 * math.pi / OMEGA


class Made(NamedTuple):
    """A record made up: samples, and the harmonics they were made of."""

    time: NDArray[np.float64]
    force: NDArray[np.float64]
    harmonics: NDArray[np.complex128]
    noise: float


def wave(time: NDArray[np.float64], harmonics: NDArray[np.complex128]) -> NDArray[np.float64]:
    total = np.zeros(time.size)
    for number, amplitude in enumerate(harmonics, 1):
        total += np.abs(amplitude) * np.cos(number * OMEGA * time + np.angle(amplitude))
    return total


def made(rng: np.random.Generator, periods: float = 7.3, noise: float = 0.05, rate: int | None = None) -> Made:
    """Return three harmonics of random sizes within a decade and random phases, with noise relative to their rms."""
    rate = int(rng.integers(50, depth(501, 101))) if rate is None else rate
    time = np.arange(int(periods * rate)) * (PERIOD / rate)
    sizes = 10.0 ** rng.uniform(-1.0, 0.0, 3)
    harmonics = 2.0 * sizes / sizes.max() * np.exp(2j * math.pi * rng.random(3))
    level = noise * math.sqrt(0.5 * float((np.abs(harmonics) ** 2).sum()))
    return Made(time, 3.0 + wave(time, harmonics) + level * rng.standard_normal(time.size), harmonics, level)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20)


def right(record: fr.ForceRecord) -> bool:
    """Return whether a record was understood: its frequency within five errors, the harmonics 1, 2, 3."""
    return abs(record.frequency - OMEGA) < 5.0 * record.frequency_error and record.harmonic_numbers == (1, 2, 3)


@pytest.mark.slow
def test_period_and_errors_of_many_records(rng: np.random.Generator) -> None:
    off, frequency, sizes, means, false = [], [], [], [], 0
    for _ in range(100):
        case = made(rng)
        record = fr.ForceRecord(case.time, case.force)
        bound = frequency_bound(case)
        assert record.frequency_error == pytest.approx(bound, rel=0.35)  # the noise is known to 1/sqrt(2n), colours not
        off.append(abs(record.period / PERIOD - 1.0) / max(1e-4, 3.5 * bound / OMEGA))
        frequency.append((record.frequency - OMEGA) / record.frequency_error)
        sizes.append((np.abs(record.harmonics[:3]) - np.abs(case.harmonics)) / record.harmonic_errors[:3])
        means.append((record.mean - 3.0) / record.mean_error)
        false += record.harmonic_numbers != (1, 2, 3)
        assert {1, 2, 3} <= set(record.harmonic_numbers)
    assert max(off) < 1.0  # 1e-4 but for records whose noise does not allow for it
    assert false <= 4  # one expected
    for scaled in (np.array(frequency), np.ravel(sizes), np.array(means)):
        assert 0.90 < np.mean(np.abs(scaled) < 2.0) < 0.995
        assert 0.85 < math.sqrt(float(np.mean(scaled**2))) < 1.15


def frequency_bound(case: Made) -> float:
    """Return the Cramer-Rao bound of the frequency, from derivatives by differences."""
    parts = np.concatenate([case.harmonics.real, case.harmonics.imag])

    def model(unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
        numbers = np.arange(1, 4)[:, None]
        c = unknowns[2:5] + 1j * unknowns[5:]
        return unknowns[0] + (c[:, None] * np.exp(1j * numbers * unknowns[1] * case.time)).sum(axis=0).real

    at = np.concatenate([[3.0, OMEGA], parts])
    steps = 1e-5 * np.eye(at.size)
    jacobian = np.stack([(model(at + step) - model(at - step)) / 2e-5 for step in steps], axis=1)
    return case.noise * math.sqrt(np.linalg.inv(jacobian.T @ jacobian)[1, 1])


def test_agrees_with_a_general_least_squares_solver(rng: np.random.Generator) -> None:
    case = made(rng, rate=60)
    record = fr.ForceRecord(case.time, case.force, harmonics=3)

    def misfit(unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
        numbers = np.arange(1, 4)[:, None]
        c = unknowns[2:5] + 1j * unknowns[5:]
        fit = unknowns[0] + (c[:, None] * np.exp(1j * numbers * unknowns[1] * case.time)).sum(axis=0).real
        return fit - case.force

    start = np.concatenate([[3.0, OMEGA], case.harmonics.real, case.harmonics.imag])
    found = least_squares(misfit, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale="jac")
    assert record.trend == 0.0
    assert record.frequency == pytest.approx(found.x[1], abs=1e-3 * record.frequency_error)
    assert record.mean == pytest.approx(found.x[0], abs=1e-3 * record.mean_error)
    assert np.abs(record.harmonics - (found.x[2:5] + 1j * found.x[5:])).max() < 3e-3 * record.harmonic_errors.min()
    variance = 2.0 * found.cost / (case.time.size - 8)
    errors = np.sqrt(variance * np.linalg.inv(found.jac.T @ found.jac).diagonal())
    assert record.noise == pytest.approx(math.sqrt(variance), rel=1e-6)
    assert (record.mean_error, record.frequency_error) == pytest.approx(tuple(errors[:2]), rel=1e-3)


def test_a_clean_record_is_found_to_rounding(rng: np.random.Generator) -> None:
    case = made(rng, noise=0.0)
    record = fr.ForceRecord(case.time, case.force)
    assert record.frequency == pytest.approx(OMEGA, rel=1e-13)
    assert record.harmonics[:3] == pytest.approx(case.harmonics, rel=1e-11)
    assert record.harmonic_numbers == (1, 2, 3)
    assert record.mean == pytest.approx(3.0, rel=1e-13)


def test_amplitude_and_waveform_make_the_force(rng: np.random.Generator) -> None:
    record = fr.ForceRecord(*made(rng)[:2])
    t = np.linspace(0.0, record.period, 200_001)
    force = record.force(t)
    assert record.amplitude == pytest.approx(0.5 * np.ptp(force), rel=1e-8)
    numbers = np.arange(1, len(record.waveform) + 1)
    terms = np.array(record.waveform) * np.exp(1j * np.outer(t[::1000], numbers) * record.frequency)
    assert record.mean + record.amplitude * terms.sum(axis=1).real == pytest.approx(force[::1000], rel=1e-12)
    assert record.force(0.25) == pytest.approx(float(record.force(np.array([0.25]))[0]), rel=1e-15)


@pytest.mark.parametrize("periods", [2.1, *(pytest.param(k, marks=pytest.mark.slow) for k in (3.1, 60.7))])
def test_short_and_long_records(periods: float, rng: np.random.Generator) -> None:
    many = depth(20, 10)
    assert sum(right(fr.ForceRecord(*made(rng, periods)[:2])) for _ in range(many)) >= 0.9 * many


def gap(case: Made, rng: np.random.Generator) -> tuple[Any, Any]:
    keep = (case.time < 2.0 * PERIOD) | (case.time > 4.5 * PERIOD)
    return case.time[keep], case.force[keep]


def nan(case: Made, rng: np.random.Generator) -> tuple[Any, Any]:
    return case.time, np.where(rng.random(case.time.size) < 0.3, math.nan, case.force)


def uneven(case: Made, rng: np.random.Generator) -> tuple[Any, Any]:
    time = np.sort(rng.uniform(0.0, case.time[-1], case.time.size))
    return time, 3.0 + wave(time, case.harmonics) + case.noise * rng.standard_normal(time.size)


def trend(case: Made, rng: np.random.Generator) -> tuple[Any, Any]:
    return case.time, case.force + 5.0 * case.time


def late(case: Made, rng: np.random.Generator) -> tuple[Any, Any]:
    return case.time + 1e6, case.force


def wandering(case: Made, rng: np.random.Generator) -> tuple[Any, Any]:
    walk = np.cumsum(rng.standard_normal(case.time.size))
    return case.time, case.force + 0.05 * walk / walk.std()


@pytest.mark.slow
@pytest.mark.parametrize("change", [gap, nan, uneven, trend, late, wandering][:: depth(1, 3)])
def test_imperfect_records(change: Callable[..., tuple[Any, Any]], rng: np.random.Generator) -> None:
    many = depth(20, 10)
    assert sum(right(fr.ForceRecord(*change(made(rng), rng))) for _ in range(many)) >= 0.9 * many


@pytest.mark.slow
def test_errors_hold_in_noise_that_is_not_white(rng: np.random.Generator) -> None:
    scaled = []
    for _ in range(40):
        case = made(rng, 30.3, rate=60)
        record = fr.ForceRecord(*wandering(case, rng))
        scaled.append((record.frequency - OMEGA) / record.frequency_error)
    assert np.mean(np.abs(scaled) < 2.0) >= 0.85
    assert "times its average" in record.note


def in_a_band(rng: np.random.Generator, time: NDArray[np.float64], middle: float, width: float) -> NDArray[np.float64]:
    """Return noise of rms 1 in a band of frequencies in Hz."""
    frequency = np.fft.rfftfreq(4 * time.size, time[1])
    inside = np.abs(frequency - middle) <= 0.5 * width
    parts = inside * (rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size))
    noise = np.fft.irfft(parts, 4 * time.size)[: time.size]
    return noise * (4 * time.size) / (2.0 * math.sqrt(float(inside.sum())))


@pytest.mark.parametrize(
    ("width", "beside"),
    [(0.3, 0.0), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((0.14, 0.0), (2.0, 0.0), (0.3, 0.15)))],
)
def test_errors_hold_in_a_narrow_band_of_noise(width: float, beside: float, rng: np.random.Generator) -> None:
    """Where an average over half the fundamental would underestimate the noise several times."""
    time, many, scaled = np.arange(2400) / 80.0, depth(100, 50), []
    for _ in range(many):
        angle = 2.0 * math.pi * 8.1 * time + rng.uniform(0.0, 2.0 * math.pi)
        noise = 0.2 * in_a_band(rng, time, 8.1 + beside, width) + 0.04 * rng.standard_normal(time.size)
        record = fr.ForceRecord(time, np.sin(angle) + noise, harmonics=3)
        assert record.harmonic_numbers == (1,)
        off = (record.frequency - 2.0 * math.pi * 8.1) / record.frequency_error
        scaled.append((off, (abs(record.harmonics[0]) - 1.0) / record.harmonic_errors[0]))
        assert "which the errors account for" in record.note
    for size in np.sqrt(np.mean(np.square(scaled), axis=0)):
        assert 0.7 < size < 1.4


def test_noise_about_a_harmonic_is_no_harmonic(rng: np.random.Generator) -> None:
    """Noise in a band is stronger there than on average, and no sine."""
    time, false = np.arange(2400) / 80.0, 0
    for _ in range(20):
        noise = 0.2 * in_a_band(rng, time, 16.2, 0.8) + 0.02 * rng.standard_normal(time.size)
        record = fr.ForceRecord(time, np.sin(2.0 * math.pi * 8.1 * time) + noise, harmonics=3)
        false += record.harmonic_numbers != (1,)
    assert false <= 2


def test_a_harmonic_no_stronger_than_the_noise_next_to_it_is_kept_with_a_note(rng: np.random.Generator) -> None:
    """As that of a tool whose speed wanders."""
    time = np.arange(2400) / 80.0
    phase = np.cumsum(rng.standard_normal(time.size)) * math.sqrt(2.0 / 80.0)
    record = fr.ForceRecord(time, np.sin(2.0 * math.pi * 8.1 * time + phase) + 0.02 * rng.standard_normal(time.size))
    assert record.frequency == pytest.approx(2.0 * math.pi * 8.1, rel=0.03)
    assert "no harmonic stands above the noise next to it" in record.note
    assert "the errors account for" not in record.note


def test_a_trend_is_reported_and_no_part_of_the_force(rng: np.random.Generator) -> None:
    case = made(rng)
    record = fr.ForceRecord(*trend(case, rng))
    assert record.trend == pytest.approx(5.0, rel=0.2)
    assert "N/s" in record.note
    assert record.mean == pytest.approx(3.0 + 2.5 * case.time[-1], abs=5.0 * record.mean_error)
    assert record.force(0.0) == pytest.approx(float(record.force(record.period)), rel=1e-9)


def test_a_fundamental_weaker_than_its_harmonics_is_found(rng: np.random.Generator) -> None:
    time = np.arange(1500) * (PERIOD / 200)
    noise = 0.03 * rng.standard_normal(time.size)
    for sizes, kept in (((0.05, 1.0), (1, 2)), ((0.0, 1.0, 0.3), (2, 3)), ((0.1, 0.0, 0.2, 0.0, 1.0), (1, 3, 5))):
        harmonics = np.array(sizes) * np.exp(2j * math.pi * rng.random(len(sizes)))
        record = fr.ForceRecord(time, wave(time, harmonics) + noise)
        assert record.harmonic_numbers == kept
        assert record.frequency == pytest.approx(OMEGA, rel=1e-3)


@pytest.mark.slow
def test_a_pure_wave_is_not_taken_for_a_harmonic(rng: np.random.Generator) -> None:
    time = np.arange(1500) * (PERIOD / 200)
    many = depth(50, 20)
    records = [fr.ForceRecord(time, np.sin(OMEGA * time) + 0.2 * rng.standard_normal(time.size)) for _ in range(many)]
    assert all(abs(record.frequency / OMEGA - 1.0) < 1e-2 for record in records)
    assert sum(record.harmonic_numbers == (1,) for record in records) >= 0.94 * many


def test_a_given_frequency_is_refined(rng: np.random.Generator) -> None:
    time, force, *_ = made(rng)
    found = fr.ForceRecord(time, force)
    for guess in (0.93, 1.05):
        assert fr.ForceRecord(time, force, frequency=guess * OMEGA).frequency == pytest.approx(
            found.frequency, rel=1e-9
        )
    assert fr.ForceRecord(time, force, frequency=0.5 * OMEGA).harmonic_numbers[:3] == (2, 4, 6)


def test_harmonics_are_limited_by_the_sampling_and_by_the_argument(rng: np.random.Generator) -> None:
    time = np.arange(500) * (PERIOD / 24.7)
    force = np.sign(np.sin(OMEGA * time)) + 0.01 * rng.standard_normal(time.size)
    assert fr.ForceRecord(time, force).harmonics.size == 12  # below half of the sampling rate
    assert "no more" in fr.ForceRecord(time, force, harmonics=40).note
    few = fr.ForceRecord(time, force, harmonics=3)
    assert few.harmonic_numbers == (1, 3)
    assert "harmonics 5, 7, 9 and others above the noise but not fitted (Python: harmonics=" in few.note
    with pytest.raises(ValueError, match=r"harmonics must be at most 8 for 20 samples"):
        fr.ForceRecord(time[:20], force[:20], harmonics=9)


def long_record(rng: np.random.Generator, fundamental: float, size: float) -> tuple[Any, Any]:
    time = np.arange(1 << 18) / 1000.0
    angle = OMEGA * time
    waves = fundamental * np.sin(angle) + np.cos(2.0 * angle) + 0.2 * np.cos(3.0 * angle)
    return time, 3.0 + size * waves + 0.5 * rng.standard_normal(time.size)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fundamental", "size"), [(0.1, 1.0), *(pytest.param(2.0, size, marks=pytest.mark.slow) for size in (0.01, 1.0))]
)
def test_a_long_record_is_fitted_by_some_of_its_samples_first(
    fundamental: float, size: float, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch, heard: Heard
) -> None:
    """With the same answer as by all of them, also where few know too little; the last words are those of all."""
    case = long_record(rng, fundamental, size)
    monkeypatch.setattr(record_fit.Samples, "is_long", False)
    every = fr.ForceRecord(*case)
    monkeypatch.undo()
    sums = heard(record_fit, "_sums")
    record = fr.ForceRecord(*case)
    assert record.harmonic_numbers == every.harmonic_numbers
    assert abs(record.frequency - every.frequency) < 0.1 * every.frequency_error
    assert np.abs(record.harmonics - every.harmonics).max() < 0.1 * every.harmonic_errors.min()
    assert record.frequency_error == pytest.approx(every.frequency_error, rel=1e-3)
    if size == 1.0:
        whole = [samples.tau.size == case[0].size and len(numbers) > 3 for samples, _, numbers, _ in sums]
        assert sum(whole) <= 10  # of 20 harmonics: one climb, or two where the fundamental is not the strongest


def test_some_samples_of_a_long_record_fold_nothing_down(rng: np.random.Generator) -> None:
    """A frequency far above half of their mean rate is fitted with its own size."""
    time, _ = long_record(rng, 1.0, 1.0)
    samples = record_fit.Samples.of(time, np.sin(2600.0 * time))
    assert samples.some.tau.size == samples.tau.size // 4
    found = record_fit.fit(samples.some, 2600.0 * samples.half, (1,))
    assert found is not None
    assert abs(found.amplitudes[0]) == pytest.approx(1.0, rel=1e-4)
    other = record_fit.fit(
        samples.some, (2.0 * math.pi * 250.0 - 2600.0) % (2.0 * math.pi * 250.0) * samples.half, (1,)
    )
    assert other is None or abs(other.amplitudes[0]) < 0.1


def test_the_spectrum_of_even_samples_is_their_transform(rng: np.random.Generator, heard: Heard) -> None:
    """Padded to four times their number, and no longer."""
    time = 0.01 * np.arange(200)
    samples = record_fit.Samples.of(time, rng.standard_normal(time.size))
    transforms = heard(scipy.fft, "rfft")
    found = record_period.power_spectrum(samples, samples.values)
    assert 4 * (time.size - 1) <= transforms[0][1] <= 4 * time.size + 8
    at = math.pi * found.step * np.arange(1, found.power.size + 1)
    direct = np.abs(np.exp(-1j * np.outer(at, samples.tau)) @ samples.values) ** 2 / time.size
    assert found.power == pytest.approx(direct, rel=1e-9, abs=1e-12)
    assert found.step * found.power.size > 0.99 * samples.highest


def test_noise_alone_is_refused(rng: np.random.Generator) -> None:
    for size in (20, 200, 2000):
        for _ in range(30):
            with pytest.raises(ValueError, match="shows no period"):
                fr.ForceRecord(np.arange(size) * 0.01, rng.standard_normal(size))


def test_noise_alone_is_told_how_to_be_given(rng: np.random.Generator, tmp_path: Path) -> None:
    """With its mean and its density, in newtons and in the unit of a file."""
    time, force = np.arange(4000) * 0.01, 50.0 + 3.0 * rng.standard_normal(4000)
    path = tmp_path / "random.csv"
    np.savetxt(path, np.c_[time, force], "%.9g", ",", header="time / s,force / lbf", comments="")
    for unit, ask in (("N", lambda: fr.ForceRecord(time, force)), ("lbf", lambda: fr.ForceRecord.from_csv(path))):
        with pytest.raises(ValueError, match="shows no period") as refused:
            ask()
        mean, density = f"{force.mean():.4g}{unit}", f"{2.0 * force.var() / 100.0:.4g}{unit}^2/Hz"
        assert f"--mean {mean} --amplitude 0{unit} --noise {density} and any --frequency" in str(refused.value)
        assert f'fr.AxialLoad("{mean}", 0, "1Hz", noise="{density}")' in str(refused.value)
        load = fr.AxialLoad(mean, 0, "1Hz", noise=density)
        assert load.noise == pytest.approx(2.0 * np.var(force) / 100.0 * units.units_of("force")[unit] ** 2, rel=1e-3)
        assert pickle.loads(pickle.dumps(refused.value)).args == refused.value.args
    with pytest.raises(ValueError, match="above the noise near the frequency given") as again:
        fr.ForceRecord.from_csv(path, frequency=12.0)
    assert "or give another frequency;" in str(again.value)
    assert "--noise spectrum without --force-frequency (Python" in str(again.value)


def test_without_harmonics_all_but_mean_and_trend_is_noise(rng: np.random.Generator) -> None:
    """Its power is that of the spectrum; a trend is found as with harmonics, and chance makes one in few records."""
    time, trends = np.arange(4000) * 0.01, 0
    for slope in (0.0, 0.02) * 10:
        force = 50.0 + slope * time + 3.0 * rng.standard_normal(time.size)
        record = fr.ForceRecord(time, force, harmonics=0)
        line = np.polynomial.polynomial.polyfit(time - time.mean(), force, 1)
        trends += record.trend != 0.0 if slope == 0.0 else 0
        level = line if record.trend else [force.mean(), 0.0]
        assert (record.mean, record.trend) == pytest.approx(tuple(level), rel=1e-9)
        assert slope == 0.0 or abs(record.trend - slope) < 5.0 * record.trend_error
        assert abs(record.mean - 50.0 - slope * time.mean()) < 5.0 * record.mean_error
        left = force - np.polynomial.polynomial.polyval(time - time.mean(), level)
        assert record.noise == pytest.approx(math.sqrt(left @ left / (time.size - 1 - bool(record.trend))), rel=1e-9)
        density = np.array(record.noise_spectrum)[:, 1]
        assert np.mean(density) * 50.0 == pytest.approx(record.noise**2, rel=0.05)
        load = record.noisy_load.load
        assert (load.mean, load.amplitude, load.noise) == (record.mean, 0.0, record.noise_spectrum)
        assert record.load == fr.AxialLoad(record.mean, 0.0, record.frequency)
        assert record.harmonics.size == 0
        assert "and no sine; 39.99 s, 4000 samples" in repr(record)
        assert record.force(1.0) == record.mean
    assert trends <= 2


def test_the_density_of_even_noise_grows_more_certain_with_the_length_of_the_record() -> None:
    """It has one band in four of five records; its standard error is the root of two over the number of samples."""
    for samples in (1000, 4000, 64000):
        off, divided = [], 0
        for seed in range(20):
            time, random = np.arange(samples) * 0.01, np.random.default_rng(seed)
            (_, density), *others = fr.ForceRecord(
                time, 5.0 + random.standard_normal(samples), harmonics=0
            ).noise_spectrum
            divided += len(others) > 1
            if len(others) == 1:
                off.append(density / 0.02 - 1.0)
        assert divided <= 8
        assert np.sqrt(np.mean(np.square(off))) == pytest.approx(math.sqrt(2.0 / samples), rel=0.5)


@pytest.mark.parametrize(("width", "times"), [(12, 10.0), (40, 3.5), (200, 2.0), (24, 0.0)])
def test_noise_that_is_stronger_or_weaker_in_a_narrow_band_is_seen(width: int, times: float) -> None:
    """In one of ten records at most the density found there is nearer to that beside it."""
    missed, samples = 0, 8000
    for seed in range(10):
        random = np.random.default_rng(seed)
        first = int(random.integers(100, 3700))
        waves = np.fft.rfft(random.standard_normal(samples))
        waves[first : first + width] *= math.sqrt(times)
        record = fr.ForceRecord(np.arange(samples) * 0.01, 5.0 + np.fft.irfft(waves), harmonics=0)
        middle = (first + 0.5 * width) / (samples * 0.01)
        density = np.interp(middle, *np.array(record.noise_spectrum).T)
        missed += abs(density / 0.02 - 1.0) < 0.5 * abs(times - 1.0)
    assert missed <= 1


def test_a_sine_in_a_record_without_harmonics_is_a_line() -> None:
    """It is warned of, as its power is spread over a band as if it were noise."""
    rng, time = np.random.default_rng(1), np.arange(4000) * 0.01
    force = 5.0 + 1.0 * np.sin(2.0 * math.pi * 7.0 * time) + 0.5 * rng.standard_normal(time.size)
    record = fr.ForceRecord(time, force, harmonics=0)
    ((amplitude, omega, _),) = record.lines
    assert amplitude == pytest.approx(1.0, rel=0.1)
    assert omega == pytest.approx(2.0 * math.pi * 7.0, rel=1e-3)
    with pytest.warns(fr.PlausibilityWarning, match="as noise its power is spread over a band"):
        assert record.noisy_load.load.noise


def test_a_drift_is_no_part_of_the_noise_that_is_told(rng: np.random.Generator, tmp_path: Path) -> None:
    """Noise of 0.05 lbf at 200 samples a second has 2.5e-5 lbf^2/Hz, whatever the force drifts by."""
    time = np.arange(8000) / 200.0
    force = 1.6 + 0.03 * time + 0.05 * rng.standard_normal(time.size)
    path = tmp_path / "drift.csv"
    np.savetxt(path, np.c_[time, force], "%.9g", ",", header="time / s,force / lbf", comments="")
    with pytest.raises(ValueError, match=r"it drifts from 1\.6\d* to 2\.8\d* lbf; .*--mean 2\.\d*lbf") as refused:
        fr.ForceRecord.from_csv(path)
    density = float(str(refused.value).rpartition("--noise ")[2].partition("lbf")[0])
    assert density == pytest.approx(2.5e-5, rel=0.05)


def test_one_harmonic_is_not_called_harmonics(rng: np.random.Generator) -> None:
    time = np.arange(4000) / 400.0
    slow = np.cumsum(rng.standard_normal((2, time.size)), axis=1) * 0.002
    force = np.sin(OMEGA * time) * (1.0 + slow[0]) + np.cos(OMEGA * time) * slow[1]
    record = fr.ForceRecord(time, force + 0.01 * rng.standard_normal(time.size))
    assert record.harmonic_numbers == (1,)
    assert "noise about harmonic 1 up to" in record.note


TIME, FORCE, *_ = made(np.random.default_rng(3), rate=100)


@pytest.mark.parametrize(
    ("time", "force", "options", "match"),
    [
        (FORCE, np.arange(FORCE.size), {}, "two columns are swapped"),
        (FORCE, TIME, {}, "two columns are swapped"),
        (TIME[::-1], FORCE, {}, "sort the samples by time"),
        (np.round(TIME, 3), FORCE, {}, "equal times may have lost digits"),
        (TIME[:5], FORCE[:5], {}, "12 samples or more, got 5"),
        ([], [], {}, "12 samples or more, got 0"),
        (TIME[:130], FORCE[:130], {}, "two periods or more"),
        (TIME, np.full(TIME.size, 2.0), {}, "force must vary"),
        (TIME, FORCE[:-1], {}, "time and force must have one length"),
        (TIME, np.where(TIME > 0.2, np.nan, FORCE), {}, "numbers in half of the samples"),
        (TIME, np.where(TIME > 0.2, np.inf, FORCE), {}, "force must be finite"),
        (TIME, FORCE + 0j, {}, "force must hold real numbers"),
        (TIME, [TIME, FORCE], {}, "force must be one-dimensional"),
        ("a", FORCE, {}, "time must be a number with a time unit"),
        (TIME, [[1.0], [2.0, 3.0]], {}, "force must be an array"),
        (np.ma.array(TIME), FORCE, {}, "time must not be a masked array"),
        (TIME, FORCE, {"harmonics": -1}, "harmonics must be 0 or more"),
        (TIME, FORCE, {"harmonics": 2.0}, "harmonics must be an integer"),
        (TIME, FORCE, {"harmonics": 0, "frequency": 50.0}, "frequency goes with a harmonic at least"),
        (TIME, FORCE, {"frequency": -1.0}, "frequency must be greater than zero"),
        (TIME, FORCE, {"frequency": 1.0}, "frequency must have two periods"),
        (TIME, FORCE, {"frequency": 1e6}, "frequency must lie below half of the sampling rate"),
    ],
)
def test_what_is_no_record_is_refused(time: Any, force: Any, options: dict[str, Any], match: str) -> None:
    with pytest.raises((TypeError, ValueError), match=match):
        fr.ForceRecord(time, force, **options)


def test_a_record_is_a_frozen_value() -> None:
    record = fr.ForceRecord(TIME, FORCE)
    twin = pickle.loads(pickle.dumps(record))
    assert record == twin == fr.ForceRecord(list(TIME), list(FORCE))
    assert hash(record) == hash(twin)
    assert record != fr.ForceRecord(TIME, 2.0 * FORCE)
    with pytest.raises(AttributeError):
        record.mean = 1.0  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        record.harmonics[0] = 1.0
    text = repr(record)
    assert "harmonics 1, 2, 3" in text
    assert "7.29 periods, 730 samples" in text


def test_the_drawing_shows_fit_and_spectrum() -> None:
    record = fr.ForceRecord(TIME, FORCE)
    frequency, amplitude, left = record.spectrum()
    at = int(np.abs(frequency - 1.0 / record.period).argmin())
    assert amplitude[at] == pytest.approx(abs(record.harmonics[0]), rel=0.3)
    assert left.max() < 6.0 * record.noise / math.sqrt(record.time.size)
    above, below = record.plot()
    assert above.get_ylabel() == "force $F$ / N"
    assert below.get_xlabel() == "frequency / Hz"
    assert record.plot((above, below)) == (above, below)
    for ax in (above, below):  # no legend covers a sample or a harmonic
        ax.figure.draw_without_rendering()
        assert not ax.get_legend().get_window_extent().overlaps(ax.get_window_extent())


def test_the_axis_of_a_record_with_dates_begins_at_its_first_sample() -> None:
    above, _ = fr.ForceRecord(TIME + 50878.0, FORCE).plot()
    assert above.lines[0].get_xdata()[0] == 0.0
    assert above.get_xlabel() == "time after the first sample / s"


# --- files ---


def written(
    path: Path, *, head: str = "", mark: str = ",", comma: str = ".", size: tuple[float, float] = (1, 1)
) -> Path:
    rows = [f"{t / size[0]!r}{mark}{f / size[1]!r}".replace("np.float64(", "").replace(")", "") for t, f in pairs()]
    text = "\n".join(row if comma == "." else row.replace(".", ",") for row in rows)
    path.write_bytes((head + text + "\n").encode())
    return path


@functools.cache
def plain() -> fr.ForceRecord:
    return fr.ForceRecord(TIME, FORCE)


def pairs() -> list[tuple[float, float]]:
    return list(zip(TIME.tolist(), FORCE.tolist(), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("head", "made_with", "options"),
    [
        ("", {}, {}),
        ("time,force\n", {}, {}),
        ("# a comment\n\n#another, with commas\nTime (s), Force (N)\n", {}, {}),
        ("\ufefftime;force\n", {"mark": ";", "comma": ","}, {}),
        ("", {"mark": "\t"}, {}),
        ("", {"mark": "   "}, {}),
        ("", {"mark": "|"}, {"delimiter": "|"}),
        ("t [ms],F [lbf]\n", {"size": (1e-3, 4.4482216152605)}, {}),
        ("time_ms,F / kN\n", {"size": (1e-3, 1e3)}, {}),
        ("clock,push\n", {"size": (1e-3, 1e3)}, {"time_unit": "ms", "force_unit": "kN"}),
        ("t [?],push\n", {}, {"time_unit": "s", "time": "t [?]", "force": "PUSH"}),
        ("", {}, {"time": 0, "force": 1}),
    ],
)
def test_files_as_people_write_them(head: str, made_with: Any, options: Any, tmp_path: Path) -> None:
    record = fr.ForceRecord.from_csv(written(tmp_path / "force.csv", head=head, **made_with), **options)
    expected = plain()
    assert (record.frequency, record.mean) == pytest.approx((expected.frequency, expected.mean), rel=1e-9)
    assert record.harmonic_numbers == expected.harmonic_numbers


def test_columns_are_chosen_by_heading_and_empty_cells_left_out(tmp_path: Path) -> None:
    rows = ["count,force,time"] + [f"{i},{'' if i % 50 == 7 else f},{t}" for i, (t, f) in enumerate(pairs())]
    path = tmp_path / "force.csv"
    path.write_text("\n".join(rows), encoding="utf-8")
    record = fr.ForceRecord.from_csv(path)
    assert right(record)
    assert record.note == "15 samples without a number left out"
    assert fr.ForceRecord.from_csv(path, "time", "force", harmonics=3, frequency=99.0).harmonics.size == 3


@pytest.mark.parametrize(
    ("content", "options", "match"),
    [
        (b"", {}, "no samples"),
        (b"# nothing\n", {}, "no samples"),
        (b"time,force\n", {}, "no samples below its headings"),
        (b"1.0\n2.0\n", {}, "line 1 has one column"),
        (b"time,force\n1.0,2.0\n1.5\n", {}, "line 3 has 1 column,"),
        (b"time,force\n1.0,2.0\n1.5,abc\n", {}, "line 3: force must be a number, got 'abc'"),
        (b"time,force\n1_0,2.0\n", {}, "line 2: time must be a number, got '1_0'"),
        (b"time,force\n2024-05-01 12:00,2.0\n", {}, "line 2: time must be a number"),
        (b'a,b\n"1,2\n', {}, "line 2 cannot be read"),
        (
            b"a,b,c\n1,2,3\n",
            {},
            "time must be a heading of one column, and none of them says time; the headings are 'a', 'b', 'c'",
        ),
        (b"1,2,3\n", {}, "time must be a column from 0 to 2"),
        (b"1,2\n", {"time": "t"}, "time must be the number of a column"),
        (b"1,2\n", {"force": 2}, "force must be a column from 0 to 1, got 2"),
        (b"1,2\n", {"time": 1}, "time and force must be two columns"),
        (b"t [weeks],F\n1,2\n", {}, "time_unit must be given, one of s, ms"),
        (b"t,F (tension)\n1,2\n", {}, "force_unit must be given"),
        (b"t,F\n1,2\n", {"time_unit": "fortnight"}, "time_unit must be a unit of time"),
        (b"\x00\x01\x02", {}, "binary"),
        ("t,F\n1,2\n".encode("utf-16")[:-1], {}, "save it as CSV in UTF-8"),
        (b"t,F\n1,2 \xb5\n", {}, "line 2: force must be a number, got '2 \N{MICRO SIGN}'"),
        (b"t,F\n1,2 \x81\n", {}, "line 2 is not text in UTF-8"),
        (b"t,F\n12:00:01,2\n13.5,2\n", {}, "line 3: time must be a time of day as in the lines before, got '13.5'"),
        (b"t,F\n2024-02-30 12:00:01,2\n", {}, "dates such as 2024-01-31, .* got '2024-02-30"),
        (b"t,F\n2024-02-03 12:00:01,2\n12:00:02,2\n", {}, "a date in every line or in none, got '12:00:02'"),
        (b"t,F\n12:00:01,2\n", {"time_unit": "ms"}, "time_unit is for numbers, got 'ms'"),
        (b"t,F\n12:00,2\n", {}, "times are like 12:00:00.000, with a date such as 2024"),
        (b"t,F\n31.01.2024 12:00:01,2\n2024-02-01 12:00:01,2\n", {}, "all alike, got '2024-02-01'"),
        (b"t,F\n01/31/2024 13:00:01 PM,2\n", {}, "hours from 1 to 12 before AM or PM"),
        (b"time,zeit,F\n1,2,3\n", {}, "and 2 of them say time"),
        (b"report\n\nof May\n", {}, "put # before lines without data"),
        (b"t,F\n1,2\n2,3\n", {}, "12 samples or more, got 2"),
        (b"1,2\n", {"delimiter": "ab"}, "delimiter must be one character"),
        (b"1,2\n", {"harmonics": -1}, "harmonics must be 0 or more"),
    ],
)
def test_files_that_are_no_records_are_refused(content: bytes, options: Any, match: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=match) as caught:
        fr.ForceRecord.from_csv(path, **options)
    argument = any(f"{name}" in str(caught.value) for name in options)
    assert argument or str(path) in str(caught.value)


def test_swapped_columns_and_missing_files_are_named(tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    path.write_text("\n".join(f"{f},{t}" for t, f in pairs()), encoding="utf-8")
    with pytest.raises(ValueError, match=r"force\.csv: time must increase; force does in its place"):
        fr.ForceRecord.from_csv(path)
    with pytest.raises(ValueError, match="there is no such file"):
        fr.ForceRecord.from_csv(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="folder or a device"):
        fr.ForceRecord.from_csv(tmp_path)


def test_units_written_in_headings_are_known() -> None:
    assert {"s", "ms"} <= units.units_of("time").keys()
    assert {"N", "kN", "lbf"} <= units.units_of("force").keys()


@pytest.mark.parametrize(
    ("heading", "size"),
    [
        ("time_s,force_lbf", 4.4482216152605),
        ("Time,Force LBF", 4.4482216152605),
        ("time,force_lb", 4.4482216152605),
        ("TIME_S,F_LBS", 4.4482216152605),
        ("t,lbf", 4.4482216152605),
        ("s,kN", 1e3),
        ("time,FORCE_KN", 1e3),
        ("time,force_mN", 1e-3),
    ],
)
def test_units_in_headings_may_be_the_last_or_the_only_word_in_any_case(
    heading: str, size: float, tmp_path: Path
) -> None:
    path = tmp_path / "force.csv"
    path.write_text(f"{heading}\n0.0,1.0\n0.5,2.0\n", encoding="utf-8")
    found = record_file.read_columns(path, None, None, None, None, None)
    assert found.force_unit
    assert found.time.tolist() == [0.0, 0.5]
    assert found.force.tolist() == [size, 2.0 * size]


@pytest.mark.parametrize("heading", ["t,force (%)", "t,force (pounds)", "t,force (none)"])
def test_what_is_no_unit_of_force_in_brackets_is_refused(heading: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    path.write_text(f"{heading}\n0.0,1.0\n0.5,2.0\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"force_unit must be given, one of N, kN"):
        fr.ForceRecord.from_csv(path)


def _clock(seconds: float, date: str = "", zone: str = "") -> str:
    """Return a time of day that many seconds after 23:59:59.5, as loggers write it."""
    late = 86399.5 + seconds
    day, rest = divmod(late, 86400.0)
    text = f"{int(rest // 3600):02d}:{int(rest % 3600 // 60):02d}:{rest % 60.0:012.9f}"
    return f"{date.format(int(day) + 1)}{text}{zone}"


@pytest.mark.parametrize(
    ("date", "zone"),
    [("", ""), ("2024-03-0{}T", "Z"), ("2024-03-0{} ", "+01:00")],  # the first passes midnight without a date
)
def test_times_of_day(date: str, zone: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    start = pairs()[0][0]
    path.write_text("\n".join(f"{_clock(t - start, date, zone)};{f!r}" for t, f in pairs()), encoding="utf-8")
    record, plain = fr.ForceRecord.from_csv(path), fr.ForceRecord(TIME, FORCE)
    assert (record.frequency, record.mean) == pytest.approx((plain.frequency, plain.mean), rel=1e-6)
    assert record.time[0] == (82799.5 if zone.startswith("+") else 86399.5)
    assert record.harmonic_numbers == plain.harmonic_numbers


@pytest.mark.parametrize(
    ("head", "row", "mark"),
    [
        ("Date/Time,Load (lbf)", "%m/%d/%Y %I:%M:%S.%f %p", ","),
        ("Date,Time,Force (lbf)", "%m/%d/%Y,%H:%M:%S.%f", ","),
        ("Date;Time (hh:mm:ss);Force (lbf)", "%d/%m/%y;%H:%M:%S,%f", ";"),
        ("Logger; HX-200\nSerial; 4711\n\nZeit;Kraft\n;[lbf]", "%d.%m.%Y %H:%M:%S,%f", ";"),
        ("Timestamp [UTC]\tCh1 Force (lbf)", "%Y/%m/%d %H:%M:%S.%f", "\t"),
    ],
)
@pytest.mark.parametrize("start", ["2024-03-04T23:59:59.5", "2024-02-29T23:59:58", "2024-12-31T23:59:59.1"])
def test_dates_and_headings_as_loggers_write_them(head: str, row: str, mark: str, start: str, tmp_path: Path) -> None:
    """All pass midnight, where 04/03 is followed by 05/03 and 03/04 by 03/05: the days are one apart."""
    path, begin = tmp_path / "force.csv", datetime.datetime.fromisoformat(start)
    seconds = np.arange(40) / 8.0
    times = [(begin + datetime.timedelta(seconds=t)).strftime(row) for t in seconds]
    path.write_text("\n".join([head, *(f"{t}{mark}{i}" for i, t in enumerate(times))]), encoding="utf-8")
    found = record_file.read_columns(path, None, None, None, None, None)
    assert np.allclose(found.time - found.time[0], seconds, rtol=0.0, atol=1e-9)
    assert found.force[1] == 4.4482216152605
    assert found.force_unit == "lbf"


@pytest.mark.parametrize(
    ("text", "row"),
    [
        ("No.\tElapsed (ms)\tCh1 Force (kN)\tCh2 Temp (degC)\n{}", "{i}\t{ms}\t{f}\t23"),
        ('"Time","Force"\n"ms","kN"\n{}', "{ms},{f}"),
        ("epoch_ms,force_kN\n{}", "{ms},{f}"),
        ("rig 4, 12 May\nrate, 8 Hz\nTime (ms), Axial load (kN)\n{}", "{ms},{f}"),
    ],
)
def test_headings_below_other_lines_and_units_below_headings(text: str, row: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    rows = [row.format(i=i, ms=125.0 * i, f=0.5 * i) for i in range(20)]
    path.write_text(text.format("\n".join(rows)), encoding="utf-8")
    found = record_file.read_columns(path, None, None, None, None, None)
    assert found.time.tolist() == pytest.approx((np.arange(20) / 8.0).tolist())
    assert found.force.tolist() == [500.0 * i for i in range(20)]


def test_text_of_windows(tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    rows = ["Messung \N{DEGREE SIGN}C;Zeit [s];Kraft [N]", *(f"20;{t};{f}".replace(".", ",") for t, f in pairs())]
    path.write_text("\r\n".join(rows), encoding="cp1252", newline="")
    assert right(fr.ForceRecord.from_csv(path, "Zeit [s]", "Kraft [N]"))


# Lines that NumPy's reader would not read, or read otherwise, and lines that it may.
LINES = "{}\n1.0,2.0,a\n 2.5 ,-3e-2,b\n+4.,.5,c\n"


@pytest.mark.parametrize(
    ("text", "delimiter"),
    [
        (LINES.format("0,1,9"), None),
        (LINES.format('"0","1",9'), None),
        (LINES.format("0,1,9\n0.5,1,#"), None),
        (LINES.format("0,,9"), None),
        (LINES.format("nan,1,9").replace("\n", "\r\n"), None),
        (LINES.format("0,1,9\n\n# a comment\n   "), None),
        (LINES.format("0,1,9").replace(",", ";").replace(".", ","), None),
        (LINES.format("0,1,9").replace(",", "   "), None),
        (LINES.format("0,1,9").replace(",", "|"), "|"),
    ],
)
def test_lines_together_are_read_as_each_alone(text: str, delimiter: str | None, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    path.write_text(text, encoding="utf-8", newline="")
    together = record_file.read_columns(path, 0, 1, None, None, delimiter)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(record_file._Rows, "_at_once", lambda *_: None)
        alone = record_file.read_columns(path, 0, 1, None, None, delimiter)
    assert np.array_equal(np.array(together[:2]), np.array(alone[:2]), equal_nan=True)
    assert together.time.size >= 4


@pytest.mark.parametrize("cell", ["0x10", "1_0", "inf", "1\x0b2", "1\r2", "1e", "'1'", "\N{ARABIC-INDIC DIGIT ONE}"])
@pytest.mark.parametrize("delimiter", [",", " "])
def test_what_is_no_number_is_none_among_many_lines(cell: str, delimiter: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    rows = [f"{t}{delimiter}{f}" for t, f in pairs()]
    path.write_text("\n".join([*rows[:30], f"1.0{delimiter}{cell}", *rows[30:]]), encoding="utf-8", newline="")
    with pytest.raises(ValueError, match="line 31"):
        fr.ForceRecord.from_csv(path)


def test_regular_lines_are_never_read_one_by_one(tmp_path: Path, forbidden: Forbidden) -> None:
    path = tmp_path / "force.csv"
    path.write_text("time,force\n" + "\n".join(f"{t},{f}" for t, f in pairs()), encoding="utf-8")
    forbidden(record_file._Rows, "_row")
    assert right(fr.ForceRecord.from_csv(path))


WELL = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=60.0, inclination="60deg", damping_rate=0.1)


@pytest.mark.parametrize(
    ("rod", "size", "heading", "options", "words"),
    [
        (WELL, 2.0, "t,F", {}, "in kN .*; give force_unit, N or kN"),
        (WELL, 2.0, "t,F [kN]", {}, ""),
        (WELL, 2.0, "t,F", {"force_unit": "N"}, ""),
        (WELL, 2000.0, "t,F", {}, "in lbf .*; give force_unit, N or lbf"),
        (WELL, 2000.0, "t,F", {"force_unit": "N"}, ""),
        (WELL, 2000.0, "t,F_lbf", {}, ""),
        (WELL, 80.0, "t,F", {}, "in kN .*, in lbf .*; give force_unit, N, kN or lbf"),
        (fr.Rod.nitinol(), 200.0, "t,F", {}, "in mN .*; give force_unit, N or mN"),
        (fr.Rod.nitinol(), 0.05, "t,F", {}, ""),
    ],
)
def test_a_record_without_a_unit_is_doubted_where_another_would_matter(
    rod: fr.Rod, size: float, heading: str, options: Any, words: str, tmp_path: Path
) -> None:
    path = tmp_path / "force.csv"
    t = np.arange(0.0, 1.0, 1e-3)
    f = size * (1.0 + np.sin(150.0 * t)) + 1e-4 * size * np.random.default_rng(1).standard_normal(t.size)
    path.write_text("\n".join([heading, *(f"{a:.4f},{b:.9g}" for a, b in zip(t, f, strict=True))]), encoding="utf-8")
    record = fr.ForceRecord.from_csv(path, **options)
    assert record.force_unit_named is (heading != "t,F" or bool(options))
    found = list(suspicions_of_record(rod, record)) if not record.force_unit_named else []
    assert len(found) == bool(words)
    assert not words or re.search(words, found[0])
    assert fr.ForceRecord(record.time, record.samples).force_unit_named


def test_a_record_is_told_in_other_units() -> None:
    time = np.arange(2000) / 200.0
    push = 1e3 + 5.0 * time + 400.0 * np.sin(2.0 * np.pi * 5.0 * time)
    record = fr.ForceRecord(time, push + np.random.default_rng(3).standard_normal(time.size))
    pound, hertz = units.unit("lbf", "", "force"), units.unit("Hz", "", "frequency")
    text = record.in_words(pound, hertz)
    assert f"force of mean {record.mean / pound.size:.6g} lbf and amplitude" in text
    assert f"{record.frequency / hertz.size:.8g} Hz +- " in text
    assert f"trend of {record.trend / pound.size:.3g} +- {record.trend_error / pound.size:.1g} lbf/s" in text
    assert " N" not in text
    assert 0.0 < record.trend_error < 0.1
    assert "N/s" in repr(record)


@pytest.mark.parametrize("lost", ["OVLD", "OL", "-OL", "---", "Over Range", "OVERLOAD", "NaN"])
def test_what_loggers_write_for_a_lost_sample_is_left_out(lost: str, tmp_path: Path) -> None:
    rows = ["time,force"] + [f"{t},{lost if i % 50 == 7 else f}" for i, (t, f) in enumerate(pairs())]
    path = tmp_path / "force.csv"
    path.write_text("\n".join(rows), encoding="utf-8")
    record = fr.ForceRecord.from_csv(path)
    assert right(record)
    assert record.note == "15 samples without a number left out"


def test_numbers_in_quotes_may_have_marks_between_thousands(tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    rows = [f'{t},"{1e3 * f:,.6f}"' for t, f in pairs()]
    path.write_text("\n".join(["time [s],force [mN]", *rows]), encoding="utf-8")
    assert any(row.count(",") > 1 for row in rows)
    assert right(fr.ForceRecord.from_csv(path))


@pytest.mark.parametrize("preamble", ["", "Data Logger DX-200 ver 3.1\nserial,17\n\n"])
def test_a_heading_that_is_not_there_is_told_with_those_that_are(preamble: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    path.write_text(f"{preamble}Date/Time,Push\n" + "\n".join(f"{t},{f}" for t, f in pairs()), encoding="utf-8")
    message = r"time must be a heading of one column, got 'Time'; the headings are 'Date/Time', 'Push'$"
    with pytest.raises(ValueError, match=message):
        fr.ForceRecord.from_csv(path, time="Time")
    with pytest.raises(ValueError, match="force must be a heading of one column, got 'Force'; the headings are 'Date"):
        fr.ForceRecord.from_csv(path, force="Force")
    assert right(fr.ForceRecord.from_csv(path, "date/time", "Push"))


def _written(path: Path, heading: str, row: str = "{t},{f}") -> Path:
    path.write_text("\n".join([heading, *(row.format(t=t, f=f) for t, f in pairs())]), encoding="utf-8")
    return path


@pytest.mark.parametrize("force", ["WOB", "wob", " Wob ", "WOB [N]", "wob [n]"])
def test_a_column_is_named_with_its_unit_or_without(force: str, tmp_path: Path) -> None:
    path = _written(tmp_path / "force.csv", "Stamp [s],Torque [N],WOB [N]", "{t},0.5,{f}")
    assert right(fr.ForceRecord.from_csv(path, time="stamp", force=force))


def test_a_name_of_several_columns_is_refused_with_these(tmp_path: Path) -> None:
    path = _written(tmp_path / "force.csv", "Time [s],WOB [kN],WOB [N]", "{t},0.5,{f}")
    with pytest.raises(ValueError, match=r"force must be a heading .* got 'WOB': 'WOB \[kN\]', 'WOB \[N\]'; choose"):
        fr.ForceRecord.from_csv(path, force="WOB")
    assert right(fr.ForceRecord.from_csv(path, force="WOB [N]"))


def test_of_two_columns_the_one_that_is_not_time_is_force_by_its_unit(tmp_path: Path) -> None:
    path = _written(tmp_path / "force.csv", "Time [s],WOB [N]")
    assert right(fr.ForceRecord.from_csv(path))
    _written(path, "WOB [N],Time [s]", "{f},{t}")
    assert right(fr.ForceRecord.from_csv(path))
    _written(path, "Stamp [s],Force [N]")
    assert right(fr.ForceRecord.from_csv(path))
    _written(path, "Time [s],WOB\ns,N")
    assert right(fr.ForceRecord.from_csv(path))
    _written(path, "Time [s],WOB")
    with pytest.raises(ValueError, match="force must be a heading of one column, and none of them says force; the"):
        fr.ForceRecord.from_csv(path)
    assert right(fr.ForceRecord.from_csv(path, force_unit="N"))
    _written(path, "Time [s],Torque [N m]")
    with pytest.raises(ValueError, match="none of them says force"):
        fr.ForceRecord.from_csv(path)
