"""Lines of a record, sines that its fit does not hold: found, said, and never passed over by a verdict."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.signal import lfilter

import floquetrod as fr
from floquetrod.cli.main import main
from floquetrod.rod.loads.record import ChangedRecord
from tests.conftest import depth

ROD = fr.Rod(
    youngs_modulus="29.5Mpsi", density="0.276 lb/in3", diameter="1/8in", length="20ft", channel_diameter="0.75in",
    damping_rate=0.08,
)  # fmt: skip
POUND = 4.4482216152605


def record(second: float, hertz: float = 17.22, noise: float = 0.05, seed: int = 8) -> fr.ForceRecord:
    """Six seconds of 1.22 and 0.35 lbf at 24.3 Hz, under which nothing grows, and of a second sine in lbf."""
    t = np.arange(0.0, 6.0, 1.0 / 800.0)
    force = 1.22 + 0.35 * np.sin(2.0 * math.pi * 24.3 * t + 0.3) + second * np.sin(2.0 * math.pi * hertz * t + 1.0)
    return fr.ForceRecord(t, POUND * (force + noise * np.random.default_rng(seed).standard_normal(t.size)))


def test_a_line_has_its_amplitude_frequency_and_phase() -> None:
    ((amplitude, frequency, phase),) = record(0.25).lines
    assert amplitude == pytest.approx(0.25 * POUND, rel=0.02)
    assert frequency == pytest.approx(2.0 * math.pi * 17.22, rel=1e-4)
    assert phase == pytest.approx(1.0, abs=0.05)


def test_two_lines_are_found_the_strongest_first() -> None:
    t = np.arange(0.0, 6.0, 1.0 / 800.0)
    force = sum(a * np.sin(2.0 * math.pi * f * t) for a, f in ((1.0, 24.3), (0.1, 57.1), (0.3, 17.22)))
    found = fr.ForceRecord(t, 3.0 + force + 0.02 * np.random.default_rng(1).standard_normal(t.size)).lines
    np.testing.assert_allclose([line[:2] for line in found], [(0.3, 108.196), (0.1, 358.77)], rtol=0.02)


def sampled(rate: float, hertz: float, jitter: float = 0.0, **options: Any) -> fr.ForceRecord:
    """Return 40 s of three harmonics of 18.174 Hz, the third at a frequency, sampled about evenly at a rate in Hz."""
    rng = np.random.default_rng(0)
    t = (np.arange(40.0 * rate) + jitter * rng.random(int(40.0 * rate))) / rate
    force = sum(a * np.sin(2.0 * math.pi * f * t) for a, f in ((1.5, 18.174), (0.4, 36.348), (0.25, hertz)))
    return fr.ForceRecord(t, 5.0 + force + 0.05 * rng.standard_normal(t.size), **options)


def test_a_line_that_may_be_a_folded_harmonic_is_said_to_be() -> None:
    """At 100 Hz the third harmonic, 54.522 Hz, is sampled as 45.478 Hz; another sine near it is none."""
    said = r"45\.47\d* Hz may be harmonic 3 folded at the sampling rate of 100 Hz, as a faster record would show"
    found = sampled(100.0, 3.0 * 18.174)
    ((amplitude, frequency, _),) = found.lines
    assert (amplitude, frequency) == (pytest.approx(0.25, rel=0.02), pytest.approx(2.0 * math.pi * 45.478, rel=1e-5))
    assert len(re.findall(said, repr(found))) == 1
    with pytest.warns(fr.PlausibilityWarning, match=said):
        assert found.noisy_load.lines == found.lines
    assert len(re.findall(said, repr(sampled(100.0, 3.0 * 18.174, second=frequency)))) == 1
    assert sampled(400.0, 3.0 * 18.174).harmonic_numbers == (1, 2, 3)
    for other in (sampled(100.0, 45.2), sampled(400.0, 45.478), sampled(100.0, 45.478, jitter=0.5)):
        assert len(other.lines) == 1
        assert "beside the fit" in repr(other)
        assert "folded" not in repr(other)


@pytest.mark.parametrize("hertz", [5.517, 15.503, 4.6497])
def test_a_sine_in_no_ratio_is_a_line_and_no_harmonic(hertz: float) -> None:
    """Near 16 ninths, 5 and 3 halves of 3.1 Hz: both sines are found where they are."""
    t, rng = np.arange(8000) / 200.0, np.random.default_rng(12)
    force = 2400.0 + 900.0 * np.sin(2.0 * math.pi * 3.1 * t) + 600.0 * np.sin(2.0 * math.pi * hertz * t + 0.7)
    found = fr.ForceRecord(t, force + 30.0 * rng.standard_normal(t.size))
    assert found.harmonic_numbers == (1,)
    assert abs(found.frequency - 2.0 * math.pi * 3.1) < 4.0 * found.frequency_error
    ((amplitude, frequency, phase),) = found.lines
    assert (amplitude, phase) == (pytest.approx(600.0, rel=0.01), pytest.approx(0.7, abs=0.02))
    assert frequency == pytest.approx(2.0 * math.pi * hertz, rel=1e-4)


def test_sines_in_the_ratio_of_integers_are_harmonics() -> None:
    """Of a fundamental that is not there; a third sine in no ratio with them is a line all the same."""
    t, rng = np.arange(8000) / 200.0, np.random.default_rng(13)
    for third in (0.0, 200.0):
        sines = ((900.0, 9.0 * 0.34), (600.0, 16.0 * 0.34), (third, 10.7 * 0.34))
        force = 2400.0 + sum(a * np.sin(2.0 * math.pi * f * t + a) for a, f in sines)
        found = fr.ForceRecord(t, force + 30.0 * rng.standard_normal(t.size))
        assert found.harmonic_numbers == (9, 16)
        assert found.frequency == pytest.approx(2.0 * math.pi * 0.34, rel=1e-4)
        assert [line[1] / (2.0 * math.pi) for line in found.lines] == pytest.approx([3.638] * (third > 0.0), rel=1e-3)


@pytest.mark.parametrize(
    "kind", ["white", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("pink", "resonant"))]
)
def test_noise_makes_few(kind: str, rng: np.random.Generator) -> None:
    """In white noise one record of 1000 has any; noise that is stronger about a frequency may pass for a line."""
    count, of = 0, depth(300, 25)
    for _ in range(of):
        n = int(rng.integers(300, 4000))
        t, white = np.arange(n) / 1000.0, rng.standard_normal(n)
        noise = white
        if kind == "pink":
            noise = np.fft.irfft(np.fft.rfft(white) / np.sqrt(np.maximum(np.arange(n // 2 + 1), 1.0)), n)
        elif kind == "resonant":
            radius, angle = rng.uniform(0.9, 0.99), rng.uniform(0.1, 3.0)
            noise = lfilter([1.0], [1.0, -2.0 * radius * math.cos(angle), radius**2], white)
        frequency = 2.0 * math.pi * rng.uniform(10.0, n / 8.0) / t[-1]
        force = 3.0 + np.sin(frequency * t) + rng.uniform(0.05, 0.5) * noise / noise.std()
        count += bool(fr.ForceRecord(t, force, frequency=frequency).lines)
    assert count <= {"white": 2, "pink": 0.05 * of, "resonant": 0.1 * of}[kind]


@pytest.mark.parametrize(("second", "with_it"), [(0.25, "unstable"), (0.12, "unstable"), (0.015, "stable")])
def test_no_verdict_passes_over_a_line(second: float, with_it: str) -> None:
    """Undecided where the verdict with the line as the second sine is another one, which the note has."""
    measured = record(second, noise=0.01)
    (line,) = measured.lines
    load = replace(measured.load, second=line)
    beside, alone = ROD.stability(load), ROD.stability(measured.load)
    verdict = ROD.stability(measured)
    assert (alone.status, beside.status) == ("stable", with_it)
    assert verdict.status == ("undecided" if with_it == "unstable" else "stable")
    assert abs(beside.growth_rate - verdict.growth_rate) <= verdict.error
    assert f"beside the fit: {with_it}" in verdict.note


@pytest.mark.slow
def test_a_second_sine_that_is_the_line_answers() -> None:
    measured = record(0.25)
    changed = ChangedRecord(measured, lambda fit: replace(fit, second=(0.25 * POUND, 2.0 * math.pi * 17.22)))
    assert not changed.lines
    assert ROD.stability(changed).status == "unstable"
    other = ChangedRecord(measured, lambda fit: replace(fit, second=(0.25 * POUND, 2.0 * math.pi * 31.0)))
    assert other.lines == measured.lines
    assert ROD.stability(other).status == "undecided"


def test_beside_noise_what_a_line_does_is_not_known() -> None:
    measured = record(0.25)
    verdict = ROD.stability(ChangedRecord(measured, lambda fit: replace(fit, noise=1e-6)))
    assert verdict.status == "undecided"
    assert verdict.error == math.inf
    assert "is not known" in verdict.note


@pytest.mark.slow
def test_narrow_noise_is_told_from_that_beside_it_and_its_error_counts() -> None:
    """A hump of 1.3 Hz shakes a mode at its middle as its own density does, not as an average over many hertz.

    The growth in mean square of a mode is proportional to the density at twice its frequency; that of a process of
    which the record is a sample lies within the stated error, in which the error of a density from so many periods is.
    """
    rod = fr.Rod(youngs_modulus="30Mpsi", density="490lb/ft3", diameter="0.5in", length="40ft", channel_diameter="2in",
                 damping_rate=0.05)  # fmt: skip
    t, random = np.arange(8000) / 1000.0, np.random.default_rng(3)
    hertz = np.fft.rfftfreq(t.size, 1e-3)
    shape = np.exp(-(((hertz - 20.0) / 0.8) ** 2))  # of the density
    hump = np.fft.irfft(np.sqrt(shape) * (random.standard_normal(hertz.size) + 1j * random.standard_normal(hertz.size)))
    push = 90.0 + 15.0 * np.sin(2.0 * math.pi * 12.53 * t)
    measured = fr.ForceRecord(t, POUND * (push + 5.0 * hump / hump.std() + 0.3 * random.standard_normal(t.size)))
    level = (5.0 * POUND) ** 2 / (np.trapezoid(shape, hertz))
    process = tuple((float(at), float(level * dense) + 1e-6) for at, dense in zip(hertz[1:], shape[1:], strict=True))
    true = rod.stability(replace(measured.load, noise=process[:400]))
    verdict = rod.stability(ChangedRecord(measured, lambda fit: replace(fit, noise=measured.noise_spectrum)))
    assert verdict.status in ("undecided", true.status)
    assert true.exponents[0].real > 0.0
    assert abs(verdict.exponents[0].real - true.exponents[0].real) < verdict.error < 0.3


def test_a_line_is_no_noise() -> None:
    with pytest.warns(
        fr.PlausibilityWarning,
        match="holds a sine, or noise in a narrow band, beside the fit: .* as noise its power is spread",
    ):
        assert record(0.25).noisy_load.load.noise


@pytest.mark.slow
def test_the_terminal_warns_of_it_and_takes_the_words_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    measured = record(0.25)
    columns = np.column_stack([measured.time, measured.samples / POUND])
    np.savetxt("log.csv", columns, "%.6f", ",", header="time (s),load (lbf)", comments="")
    Path("rod.toml").write_text(
        'youngs_modulus = "29.5Mpsi"\ndensity = "0.276 lb/in3"\ndiameter = "1/8in"\nlength = "20ft"\n'
        'channel_diameter = "0.75in"\ndamping_rate = 0.08\n'
    )
    ask = ["check", "--rod", "rod.toml", "--force", "log.csv", "--no-margins"]
    assert main(ask) == 0
    said = capsys.readouterr()
    assert said.out.startswith("UNDECIDED")
    second = said.err.partition("beside the fit: ")[2].partition(";")[0]
    assert re.fullmatch(r"0\.2\d*lbf@17\.2\d*Hz", second)
    assert main([*ask, "--second", second]) == 0
    answered = capsys.readouterr()
    assert answered.out.startswith("UNSTABLE: mode 7 grows")
    assert "beside the fit" not in answered.err


def two_sines(hertz: float, duration: float, **options: Any) -> fr.ForceRecord:
    """Return a record of 1.22, 0.35 and 0.25 lbf, the last at a frequency, fitted with options."""
    t = np.arange(0.0, duration, 1.0 / 800.0)
    force = 1.22 + 0.35 * np.sin(2.0 * math.pi * 24.3 * t + 0.3) + 0.25 * np.sin(2.0 * math.pi * hertz * t + 1.0)
    return fr.ForceRecord(t, POUND * (force + 0.01 * np.random.default_rng(8).standard_normal(t.size)), **options)


def test_both_sines_are_fitted_as_by_a_general_least_squares_solver() -> None:
    """At 5.4 frequencies that the record tells apart, where each draws the fit of the other alone to itself."""
    joint = two_sines(21.6, 2.0, harmonics=1, second="21.7Hz")
    assert joint.second is not None
    assert joint.second_errors is not None
    t, force = joint.time, joint.samples

    def misfit(u: np.ndarray) -> np.ndarray:
        return u[0] + u[1] * np.sin(u[2] * t + u[3]) + u[4] * np.sin(u[5] * t + u[6]) - force

    true = [1.22 * POUND, 0.35 * POUND, 2.0 * math.pi * 24.3, 0.3, 0.25 * POUND, 2.0 * math.pi * 21.6, 1.0]
    found = least_squares(misfit, true, xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale="jac")
    variance = 2.0 * found.cost / (t.size - 7)
    errors = np.sqrt(variance * np.linalg.inv(found.jac.T @ found.jac).diagonal())
    assert joint.trend == 0.0
    mine = np.array([joint.mean, joint.amplitude, joint.frequency, joint.second[0], joint.second[1], joint.second[2]])
    at = [0, 1, 2, 4, 5, 6]
    assert np.abs((mine - found.x[at]) / errors[at]).max() < 2e-3
    assert joint.noise == pytest.approx(math.sqrt(variance), rel=1e-6)
    stated = joint.mean_error, joint.harmonic_errors[0], joint.frequency_error, *joint.second_errors
    np.testing.assert_allclose(stated, errors[[0, 1, 2, 4, 5]], rtol=0.05)  # cos^2 of the angle between both: 0.02
    assert joint.lines == ()
    alone = two_sines(21.6, 2.0, harmonics=1)
    assert alone.noise > 10.0 * joint.noise
    np.testing.assert_allclose(joint.force(t), force, atol=5.0 * joint.noise)
    assert f"second sine of {joint.second[0]:.4g} N" in repr(joint)


def test_a_harmonic_below_the_second_sine_is_found_beside_it() -> None:
    t = np.arange(0.0, 6.0, 1.0 / 800.0)
    force = np.sin(152.0 * t) + 0.01 * np.cos(304.0 * t) + 0.8 * np.sin(100.0 * t)
    force += 3.0 + 0.03 * np.random.default_rng(2).standard_normal(t.size)
    assert fr.ForceRecord(t, force).harmonic_numbers == (1,)
    assert fr.ForceRecord(t, force, second=100.0).harmonic_numbers == (1, 2)


@pytest.mark.parametrize(
    ("hertz", "said"),
    [(24.3, "the fit holds harmonic 1, so that"), (48.6, r"it holds 17\.2\d* Hz"), (20.0, r"it holds 17\.2\d* Hz")],
)
def test_a_second_frequency_that_was_not_measured_is_refused(hertz: float, said: str) -> None:
    with pytest.raises(ValueError, match=rf"second must be the frequency of a sine .* {said}"):
        two_sines(17.22, 2.0, second=2.0 * math.pi * hertz)


def test_the_second_sine_of_a_record_is_no_noise_of_the_first() -> None:
    """The errors of a verdict are those of the joint fit, with the sine of the record and with one that was typed."""
    rod, typed = ROD.replace(damping_rate=1.15), (0.25 * POUND, 2.0 * math.pi * 17.22)
    true = fr.AxialLoad(1.22 * POUND, 0.35 * POUND, 2.0 * math.pi * 24.3, second=typed)
    assert rod.stability(true, modes=[7]).status == "stable"
    joint = two_sines(17.22, 2.0, second="17.2Hz")
    for source in (joint, ChangedRecord(joint, lambda fit: replace(fit, second=typed))):
        verdict = rod.stability(source, modes=[7])
        assert verdict.status == "stable"
        assert verdict.left_out == ""
        assert "--noise" not in verdict.note  # which is refused beside a second sine
    alone = ChangedRecord(two_sines(17.22, 2.0), lambda fit: replace(fit, second=typed))
    assert rod.stability(alone, modes=[7]).status == "undecided"
    drawn = list(joint._within_errors(200))
    for place, error in enumerate(joint.second_errors or ()):
        assert np.std([load.second[place] for load in drawn]) == pytest.approx(2.0 * error, rel=0.2)
    with pytest.raises(ValueError, match="goes without a second sine"):
        _ = joint.noisy_load


def test_uneven_noise_beside_both_sines_is_not_passed_over() -> None:
    """A force that makes the rod unstable in mean square leaves it undecided with a second sine as without."""
    rod = fr.Rod(youngs_modulus="30Mpsi", density="490lb/ft3", diameter="2in", wall_thickness="0.156in", length="200ft",
                 channel_diameter="4.778in", fluid_inside="8.5ppg", fluid_outside="8.5ppg",
                 damping_rate=0.15)  # fmt: skip
    t, rng = np.arange(12000) / 200.0, np.random.default_rng(3)
    at = np.fft.rfftfreq(t.size, 1.0 / 200.0)
    hump = np.fft.irfft((np.abs(at - 8.1) < 0.75) * np.exp(2j * math.pi * rng.random(at.size)))
    sines = 300.0 * np.sin(2.0 * math.pi * 7.5 * t) + 60.0 * np.sin(2.0 * math.pi * 4.3033 * t)
    force = POUND * (1350.0 + sines + 200.0 * hump / hump.std() + 8.0 * rng.standard_normal(t.size))
    measured = fr.ForceRecord(t, force, frequency="7.5Hz", second="4.3033Hz")
    assert not measured.lines
    verdict = rod.stability(measured, modes=range(12, 17))
    assert verdict.status == "undecided"
    assert "as a random force, without the second sine, the rod is in mean square unstable" in verdict.undecided_by


def test_the_terminal_fits_both_and_replaces_what_is_typed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    joint = two_sines(17.22, 6.0, second="17.22Hz")
    columns = np.column_stack([joint.time, joint.samples / POUND])
    np.savetxt("log.csv", columns, "%.6f", ",", header="time (s),load (lbf)", comments="")
    ask = ["check", "--rod", "nitinol", "--damping-rate", "9", "--force", "log.csv", "--no-margins", "--modes", "1"]
    said = {}
    for second in ("17.2Hz", "0.3lbf@17.2Hz", "0.3lbf@31Hz"):
        assert main([*ask, "--second", second]) in (0, 1)
        said[second] = capsys.readouterr()
    assert re.search(r"a second sine of 0\.2[45]\d* lbf at 17\.2[12]\d* Hz of phase", said["17.2Hz"].out)
    assert "second sine of 0.3 lbf at 17.2 Hz" in said["0.3lbf@17.2Hz"].out
    assert "second sine of 0.3 lbf at 31 Hz" in said["0.3lbf@31Hz"].out
    assert ["beside the fit" in each.err for each in said.values()] == [False, False, True]
    for second, match in (("31Hz", "--second must be the frequency of a sine"), ("3lbf", "--second must be such as")):
        assert main([*ask, "--second", second]) == 2
        assert match in capsys.readouterr().err
    assert main([*ask, "--second", "17.2Hz", "--noise", "spectrum"]) == 2
    assert "goes without noise" in capsys.readouterr().err
