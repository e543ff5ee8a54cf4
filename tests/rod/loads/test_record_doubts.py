"""What a measured force leaves open, so that a verdict on it is undecided: narrow noise, a drift, a random residual."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import units
from floquetrod.cli.main import main
from floquetrod.rod.loads.record import ChangedRecord
from tests.conftest import depth

POUND = 4.4482216152605
ROD = fr.Rod(
    youngs_modulus="30Mpsi", density="490lb/ft3", diameter="2in", wall_thickness="0.156in", length="200ft",
    channel_diameter="4.778in", fluid_inside="8.5ppg", fluid_outside="8.5ppg", damping_rate=0.15,
)  # fmt: skip
HERTZ = 7.5
NEAR = range(12, 17)  # modes under noise, of which the fourteenth grows first
TIME = np.arange(12000) / 200.0  # s


def push(mean: float = 1350.0, amplitude: float = 120.0) -> np.ndarray:
    """Return a force in lbf."""
    return mean + amplitude * np.sin(2.0 * math.pi * HERTZ * TIME)


def hump(hertz: float, width: float, rms: float, seed: int = 3) -> np.ndarray:
    """Return noise of an even density in a band, in lbf."""
    rng, at = np.random.default_rng(seed), np.fft.rfftfreq(TIME.size, 1.0 / 200.0)
    inside = np.abs(at - hertz) < 0.5 * width
    noise = np.fft.irfft(inside * (rng.standard_normal(at.size) + 1j * rng.standard_normal(at.size)))
    return rms * noise / noise.std()


def white(rms: float = 8.0, seed: int = 4) -> np.ndarray:
    return rms * np.random.default_rng(seed).standard_normal(TIME.size)


def record(force: np.ndarray) -> fr.ForceRecord:
    return fr.ForceRecord(TIME, POUND * force)


def test_a_band_is_divided_where_its_noise_is_uneven() -> None:
    """A band of 0.1 Hz has the density of its own, 31360 lbf^2/Hz, within four standard errors of a half."""
    found = record(push() + hump(8.1, 0.1, 56.0) + white())
    hertz, density = np.array(found.noise_spectrum).T
    inside = np.abs(hertz - 8.1) < 0.04
    assert inside.any()
    true = (56.0 * POUND) ** 2 / 0.1
    assert 0.3 * true < density[inside].max() < 3.0 * true
    assert density[np.abs(hertz - 8.1) > 0.2].max() < 1e-2 * true
    even = sum(len(record(push() + white(seed=seed)).noise_spectrum) == 2 for seed in range(5, 15))
    assert even >= 6


def test_as_a_random_force_its_errors_count_in_python_too() -> None:
    """The noise of nb1: growth in mean square near 0, of which the density in so narrow a band tells little."""
    measured = record(push(amplitude=300.0) + hump(8.1, 0.1, 56.0) + white())
    verdict = ROD.stability(measured.noisy_load, modes=NEAR)
    assert verdict.status == "undecided"
    assert 0.01 < verdict.error < math.inf
    assert verdict.undecided_by in str(verdict.report())
    assert measured.noisy_load.load.noise == measured.noise_spectrum


def test_a_residual_that_is_no_noise_of_a_sensor_is_tried_as_a_random_force() -> None:
    measured = record(push(amplitude=300.0) + hump(8.1, 1.5, 200.0) + white())
    assert not measured.lines
    verdict = ROD.stability(measured)
    assert verdict.status == "undecided"
    assert "as a random force the rod is in mean square unstable" in verdict.undecided_by
    even = ROD.stability(record(push(amplitude=300.0) + white()))
    assert even.status == "stable"
    assert even.undecided_by == ""


def test_a_mean_that_drifts_across_a_boundary_leaves_it_undecided() -> None:
    drifts = record(push() + 15.0 * (TIME - 30.0) + white())
    verdict = ROD.stability(drifts)
    assert verdict.status == "undecided"
    assert "drifts from 4004 to 8007 N" in verdict.undecided_by
    assert verdict.undecided_by.endswith("the rod is unstable")
    across = record(push(841.0) - 5.1 * (TIME - 30.0) + white())  # past the tongue from 874 to 966 lbf
    means = (across.mean, *across._means)
    assert [ROD.stability(across.load.varied("mean", mean)).status for mean in means] == 3 * ["stable"]
    verdict = ROD.stability(across)
    assert verdict.status == "undecided"
    low, high = re.search(r"with means of (\d+) to (\d+) N the rod is unstable", verdict.undecided_by).groups()
    assert 873.4 < float(low) / POUND < 885.0
    assert 955.0 < float(high) / POUND < 966.2
    little = ROD.stability(record(push() + 0.5 * (TIME - 30.0) + white()))
    assert little.status == "stable"


def test_an_error_of_the_mean_force_that_leaves_a_verdict_open_is_named() -> None:
    """A slow wave makes the mean uncertain; a mean that is typed decides."""
    found = record(push(900.0, 120.0) + 60.0 * np.sin(2.0 * math.pi * TIME / 23.0 + 0.3) + white())
    verdict = ROD.stability(found)
    assert verdict.status == "undecided"
    error = found.mean_error
    assert f"the error of the mean force alone, {found.mean:.4g} +- {error:.2g} N, leaves that open" in verdict.note
    ends = [ROD.is_stable(found.load.varied("mean", found.mean + way * 2.0 * error)) for way in (-1.0, 1.0)]
    assert not all(end == ROD.is_stable(found.load) for end in ends)
    (typed,) = re.findall(r"--mean (\S+?);", verdict.note)
    known = ChangedRecord(found, lambda fit: replace(fit, mean=units.quantity(typed, "mean", "force")))
    assert ROD.stability(known).status != "undecided"


@pytest.mark.parametrize(("times", "width"), [(1.0, 0.0), (3.0, 0.8)])
def test_a_narrow_excess_that_chance_may_make_is_not_passed_over(times: float, width: float) -> None:
    """Sixteen frequencies of three times the density about twice a mode's frequency; without them records decide."""
    rod = fr.Rod.nitinol().replace(damping_rate=1.0)
    mean, even, seconds, rate = 0.3 * rod.critical_force, 1.13e-3, 20.0, 200.0  # N, N^2/Hz, s, Hz
    verdicts = []
    for seed in range(depth(40, 8)):
        rng, at = np.random.default_rng(seed), np.fft.rfftfreq(int(seconds * rate), 1.0 / rate)
        density = even * np.where(np.abs(at - 22.042) < 0.5 * width, times, 1.0)  # of mode 7
        parts = rng.standard_normal((2, at.size)) * np.sqrt(0.25 * density * rate**2 * seconds)
        parts[:, 0] = 0.0
        force = mean + np.fft.irfft(parts[0] + 1j * parts[1])
        measured = fr.ForceRecord(np.arange(force.size) / rate, force, harmonics=0)
        verdicts.append(rod.stability(measured.noisy_load).status)
    assert "unstable" not in verdicts
    stable = verdicts.count("stable") / len(verdicts)
    assert stable >= 0.6 if times == 1.0 else stable <= 0.1  # a fifth and more without the averages over few


@pytest.mark.slow
def test_growth_within_its_own_error_is_undecided() -> None:
    found = 0
    for rms in (60.0, 75.0, 90.0):
        measured = record(push(amplitude=250.0) + hump(8.1, 0.4, rms) + white())
        verdict = ROD.stability(measured.noisy_load, modes=NEAR)
        growth = verdict.exponents[0].real
        found += verdict.status == "undecided"
        assert verdict.status == "undecided" or abs(growth) > verdict.error - 1e-9
    assert found


def test_margins_and_ranges_say_which_sines_they_leave_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    force = push(amplitude=100.0) + 20.0 * np.sin(2.0 * math.pi * 5.3033 * TIME) + white()
    measured = record(force)
    verdict = ROD.stability(measured)
    assert verdict.status == "stable"
    assert re.fullmatch(r"the sine 8\d\.\d+N@5\.303\d*Hz of the record", verdict.left_out)
    assert not verdict.has_quick_margins
    margins = {"mean": verdict.margin("mean")}
    assert f"of the fit alone and leave out {verdict.left_out}" in str(verdict.report(margins=margins))
    assert verdict.as_dict(margins)["margins_leave_out"] == verdict.left_out
    np.savetxt("log.csv", np.c_[TIME, force], "%.6f", ",", header="time (s),load (lbf)", comments="")
    Path("rod.toml").write_text(
        'youngs_modulus = "30Mpsi"\ndensity = "490lb/ft3"\ndiameter = "2in"\nwall_thickness = "0.156in"\n'
        'length = "200ft"\nchannel_diameter = "4.778in"\nfluid_inside = "8.5ppg"\nfluid_outside = "8.5ppg"\n'
        "damping_rate = 0.15\n"
    )
    asked = ["--rod", "rod.toml", "--force", "log.csv"]
    assert main(["ranges", *asked, "--mean", "1300:1400lbf"]) == 0
    headline = capsys.readouterr().out.splitlines()[0]
    second = re.fullmatch(r"safe: .* lbf, without the sine (\S+lbf@5\.303\S*Hz) of the record", headline)
    assert second is not None
    drawn = ["--mean", "1300:1400lbf", "--frequency", "7:8Hz", "--points", "3x3"]
    assert main(["map", *asked, *drawn, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["left_out"] == f"the sine {second[1]} of the record"
    assert main(["check", *asked, "--no-margins", "--second", second[1]]) == 0
    said = capsys.readouterr()
    assert "beside the fit" not in said.out + said.err
