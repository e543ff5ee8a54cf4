"""A measured force in the terminal: its units are those of the answer, as in Python, and its noise counts."""

from __future__ import annotations

import json
import operator
import re
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli, units
from floquetrod.rod.loads.record import ChangedRecord
from floquetrod.rod.model.plausibility import warn_of_load, warn_of_record
from floquetrod.rod.record_verdict import NOISE_DRAWS
from tests.conftest import depth

ROD = fr.Rod.nitinol().replace(damping_rate=0.3)
MEAN, AMPLITUDE, OMEGA = 0.3 * ROD.critical_force, 0.05 * ROD.critical_force, 150.0
UNITS = units.units_of("force")


def written(folder: Path, unit: str, noise: float = 0.02) -> Path:
    """Write a record in a unit of force, with a first and a second harmonic, and return its file."""
    t = np.arange(0.0, 0.5, 1e-3)
    clean = MEAN + AMPLITUDE * (np.sin(OMEGA * t) + 0.3 * np.cos(2.0 * OMEGA * t))
    force = clean + noise * AMPLITUDE * np.random.default_rng(0).standard_normal(t.size)
    path = folder / f"force_{unit}.csv"
    np.savetxt(path, np.c_[t, force / UNITS[unit]], "%.9g", ",", header=f"time / s,force / {unit}", comments="")
    return path


def forces(text: str) -> set[str]:
    """Return the units of force in the lines on the load and the record."""
    lines = [line for line in text.splitlines() if line.startswith(("load", "record", "          critical force"))]
    return set(re.findall(r"[\d.]+ (\w*(?:N|lbf|kgf|tf|kip))\b(?!/)", " ".join(lines)))


@pytest.mark.slow
@pytest.mark.parametrize("unit", UNITS)
def test_a_record_is_shown_in_its_own_unit(unit: str, tmp_path: Path) -> None:
    record = fr.ForceRecord.from_csv(written(tmp_path, unit))
    assert record.given_units.force == unit
    assert record.load.given_units == record.noisy_load.load.given_units == record.given_units
    assert f" {unit} " in repr(record)
    above, below = record.plot()
    assert (above.get_ylabel(), below.get_ylabel()) == (f"force $F$ / {unit}", f"amplitude / {unit}")


@pytest.mark.parametrize("unit", ["lbf", "mN", *UNITS][: depth(99, 1)])
def test_terminal_and_python_answer_in_its_unit(unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, unit)
    record = fr.ForceRecord.from_csv(path)
    arguments = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--force", str(path), "--modes", "1-4"]
    assert cli.main(arguments) == 0
    text = capsys.readouterr().out
    report = str(ROD.stability(record, modes=range(1, 5)).report())
    assert forces(text) == forces(report) == {unit}
    loads = [next(line for line in each.splitlines() if line.startswith("load")) for each in (text, report)]
    assert loads[0] == loads[1]
    assert " Hz (" in loads[0]


@pytest.mark.slow
def test_what_is_typed_comes_before_the_unit_of_a_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(written(tmp_path, "lbf"))
    for more, expected in ((["--mean", "300mN"], "mN"), (["--unit", "kgf"], "kgf"), (["--mean", "0.3Fcr"], "lbf")):
        assert cli.main(["check", "--rod", "nitinol", "--modes", "1-4", "--force", path, *more]) == 0
        text = capsys.readouterr().out
        assert forces(text) == {expected}


@pytest.mark.slow
def test_a_record_without_a_unit_of_force_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "N")
    asked = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--no-margins", "--force", str(path)]
    told = "floquetrod: warning: the record names no unit of force: taken in N; give --force-unit, such as N or lbf\n"
    for heading, more, expected in (
        ("Force / N", [], False),
        ("Force", [], True),
        ("Force", ["--force-unit", "N"], False),
    ):
        lines = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join([f"time / s,{heading}", *lines[1:]]), encoding="utf-8")
        assert cli.main([*asked, *more]) == 0
        assert (told in capsys.readouterr().err) == expected


def test_times_of_a_force_too_quick_for_any_machine_are_warned_of(tmp_path: Path) -> None:
    path, matters = written(tmp_path, "N"), "its force 23,87. Hz, .* Give time_unit, such as s or ms"
    quick, slow = (fr.ForceRecord.from_csv(path, time_unit=unit) for unit in ("ms", "s"))
    with pytest.warns(fr.PlausibilityWarning, match=matters):
        warn_of_record(ROD, quick, quick.load)  # as the terminal and studies do
    with pytest.warns(fr.PlausibilityWarning, match=matters):
        warn_of_load(ROD, quick.load, quick)  # as `Rod.stability` does
    warn_of_record(ROD, slow, slow.load)
    warn_of_load(ROD, slow.load, slow)


def test_a_record_without_a_unit_and_arrays_are_in_newtons(tmp_path: Path) -> None:
    path = written(tmp_path, "N")
    path.write_text(path.read_text(encoding="utf-8").replace(" / N", ""), encoding="utf-8")
    record = fr.ForceRecord.from_csv(path)
    assert (record.given_units.force, record.given_units.frequency) == ("", "Hz")
    again = fr.ForceRecord(record.time, record.samples)
    assert (again, again.given_units) == (record, record.given_units)
    assert " N " in repr(again)


OPTIONS = {"mean": "0.25Fcr", "amplitude": "0.06Fcr", "frequency": "25Hz", "wave": "held", "mean_at": "none"}


def loads_drawn(capsys: pytest.CaptureFixture[str], arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the JSON of an answer, and what the verdict was about."""
    asked: list[Any] = []
    stability = fr.Rod.stability

    def noted(rod: fr.Rod, load: Any, *given: Any, **named: Any) -> Any:
        asked.append(load)
        return stability(rod, load, *given, **named)

    with monkeypatch.context() as patch:
        patch.setattr(fr.Rod, "stability", noted)
        assert cli.main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out), asked[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", OPTIONS)
def test_the_noise_of_a_record_counts_whatever_an_option_changes(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, "lbf", 0.2)
    arguments = ["check", "--rod", "nitinol", "--modes", "1-4", "--force", str(path)]
    told, source = loads_drawn(capsys, [*arguments, f"--{name.replace('_', '-')}", OPTIONS[name]], monkeypatch)
    assert told["force_record"]["noise_in_error"]
    assert "noise in the record" in told["note"]
    record = fr.ForceRecord.from_csv(path)
    assert isinstance(source, ChangedRecord)
    changed = list(source._within_errors(NOISE_DRAWS))
    own = list(record._within_errors(NOISE_DRAWS))
    assert len(changed) == NOISE_DRAWS
    for load, drawn in zip(changed, own, strict=True):  # all but the option is drawn as without it
        for each in ("mean", "amplitude", "frequency"):
            assert getattr(load, each) == (getattr(source.load, each) if each == name else getattr(drawn, each))
        assert load.waveform == drawn.waveform
        assert (type(load).__name__ == "AxialWave") == (name == "wave")
        assert load.mean_at == (None if name == "mean_at" else 0.5)
    verdict = ROD.replace(damping_rate=0.0).stability(source, modes=range(1, 5))
    assert (told["status"], told["growth_rate_error_per_s"]) == (verdict.status, verdict.error)


GROWING, GROWING_MEAN = ["--mean", "0.17Fcr", "--damping-rate", "0.1"], 0.17 * ROD.critical_force
DAMPED_LITTLE = ROD.replace(damping_rate=0.1)


def checked(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, str]:
    """Return what `check` says of the reference rod, by the labels of its lines."""
    assert cli.main(["check", "--rod", "nitinol", "--growth-tolerance", "1e-3", *arguments]) == 0
    lines = capsys.readouterr().out.splitlines()
    return {line[:10].strip(): line[10:] for line in lines if re.match(r"[a-z]", line)}


@pytest.mark.slow
def test_the_sine_beside_a_random_force_has_no_noise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(written(tmp_path, "N"))
    lines = checked(capsys, *GROWING, "--force", path, "--noise", "spectrum")
    record = fr.ForceRecord.from_csv(path)
    sine = DAMPED_LITTLE.stability(fr.AxialLoad(GROWING_MEAN, record.amplitude, record.frequency))
    match = re.fullmatch(
        r"of the same mean, amplitude and frequency, without noise: unstable, (\S+) 1/s", lines["sine"]
    )
    assert match is not None
    assert float(match[1]) == pytest.approx(sine.growth_rate, rel=1e-5)  # in mean square it is twice as much


@pytest.mark.slow
@pytest.mark.parametrize(("more", "name"), [([], "load"), (["--noise", "spectrum"], "noisy_load.load")])
def test_an_unstable_record_names_the_damping_without_margins(
    more: list[str], name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(written(tmp_path, "N"))
    options = [*GROWING, "--force", path, *more]
    lines = checked(capsys, *options)
    assert lines["margins"].startswith("not searched")
    calm = "no mode grows in mean square" if more else "stable"
    match = re.fullmatch(rf"{calm} with every damping_rate tried above (\S+) 1/s", lines["damping"])
    assert match is not None
    push = operator.attrgetter(name)(fr.ForceRecord.from_csv(path)).varied("mean", GROWING_MEAN)
    damped = [ROD.replace(damping_rate=factor * float(match[1])) for factor in (0.99, 1.01)]
    assert [rod.stability(push, growth_tolerance=1e-3).status for rod in damped] == ["unstable", "stable"]
    assert "damping" not in checked(capsys, *options, "--no-margins")


@pytest.mark.slow
def test_a_record_of_one_harmonic_has_the_margins_of_the_sine(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t, path = np.arange(0.0, 0.5, 1e-3), tmp_path / "force.csv"
    np.savetxt(path, np.c_[t, MEAN + AMPLITUDE * np.sin(OMEGA * t)], "%.9g", ",", header="t / s,F / N", comments="")
    lines = checked(capsys, "--damping-rate", "0.3", "--force", str(path))
    record = fr.ForceRecord.from_csv(path)
    sine = fr.AxialLoad(record.mean, record.amplitude, record.frequency)
    margin = ROD.stability(sine, growth_tolerance=1e-3).mean_force_margin
    below, above = (float(each) for each in re.findall(r"([\d.]+) N (?:lower|higher)", lines["margins"]))
    assert (below, above) == pytest.approx(tuple(margin), rel=1e-3)


def test_a_record_of_noise_alone_names_the_question_without_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file is one with columns of time and force, so this is not what is missing; and what is named is answered."""
    path, random = tmp_path / "force.csv", np.random.default_rng(1)
    t = np.arange(0.0, 20.0, 1e-2)
    np.savetxt(path, np.c_[t, 2.0 + 0.1 * random.standard_normal(t.size)], "%.6g", ",", header="t / s,F / N")
    assert cli.main(["check", "--rod", "nitinol", "--force", str(path), "--noise", "spectrum"]) == 2
    said = capsys.readouterr().err
    assert "text file" not in said
    match = re.search(r"(--mean \S+ --amplitude 0N --noise \S+) and any --frequency, such as (1Hz)", said)
    assert match is not None
    asked = [*match[1].split(), "--frequency", match[2]]
    assert cli.main(["check", "--rod", "nitinol", "--damping-rate", "0.3", "--no-margins", *asked]) == 0
    assert "in mean square" in capsys.readouterr().out


def test_a_range_of_amplitudes_of_a_record_of_noise_alone_is_led_to_its_density(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An amplitude of zero would leave nothing of the map."""
    path, t = tmp_path / "force.csv", np.arange(0.0, 20.0, 1e-2)
    force = 0.4 + 0.01 * np.random.default_rng(1).standard_normal(t.size)
    np.savetxt(path, np.c_[t, force], "%.6g", ",", header="t / s,F / N", comments="")
    asked = ["map", "--rod", "nitinol", "--damping-rate", "2", "--amplitude", "0:0.3Fcr", "--frequency", "10:20Hz"]
    asked += ["--points", "3x3", "--out", str(tmp_path / "map.npz")]
    assert cli.main([*asked, "--force", str(path), "--noise", "spectrum"]) == 2
    said = capsys.readouterr().err
    assert "for --amplitude 0:0.3Fcr, a range, a record without a sine has no waveform" in said
    match = re.search(r"(--mean \S+) --amplitude 0N (--noise \S+) and any", said)
    assert match is not None
    assert cli.main([*asked, *match[1].split(), *match[2].split()]) == 0


@pytest.mark.parametrize(("low", "high"), [(20.0, 30.0), (24.0, 24.5)])
def test_a_band_of_noise_alone_is_answered_with_its_spectrum(
    low: float, high: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the command that is named, as in Python; where a sine is fitted to chance in the band it is noise as well."""
    path, random, t = tmp_path / "band.csv", np.random.default_rng(2), np.arange(0.0, 20.0, 2e-3)
    at = np.fft.rfftfreq(t.size, 2e-3)
    band = ((at > low) & (at < high)) * (random.standard_normal(at.size) + 1j * random.standard_normal(at.size))
    force = np.fft.irfft(band, t.size)
    np.savetxt(path, np.c_[t, 1.0 + 0.03 * force / force.std()], "%.9g", ",", header="time / s,force / N", comments="")
    question = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--no-margins", "--force", str(path)]
    named = cli.main(question)
    said = capsys.readouterr()
    match = re.search(r"random alone, take .*?: (--amplitude 0 --noise spectrum) ", said.out + said.err)
    assert match is not None, named
    assert cli.main([*question, *match[1].split(), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    record = fr.ForceRecord.from_csv(path, harmonics=0)
    verdict = ROD.replace(damping_rate=0.3).stability(record.noisy_load)
    assert record.noise == pytest.approx(0.03, rel=1e-3)
    assert (found["status"], found["growth_rate_per_s"]) == (verdict.status, verdict.growth_rate)
    assert found["growth_rate_error_per_s"] == verdict.error
    assert found["force_record"]["harmonic_numbers"] == []
    assert found["force_record"]["noise_N"] == record.noise
    assert (found["amplitude_N"], found["mean_N"]) == (0.0, record.mean)


def test_a_sine_near_the_frequency_given_is_no_noise_where_it_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["--amplitude", "0", "--noise", "spectrum", "--force-frequency", "24Hz", "--no-margins", "--modes", "1-3"]
    lines = checked(capsys, "--damping-rate", "0.3", "--force", str(written(tmp_path, "N")), *asked)
    assert "above a noise of" in lines["record"]


def test_no_harmonic_is_taken_out_of_a_record_asked_for_as_random_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Harmonics found in slow noise, or those of a sine, are noise as in Python: without them it would be less."""
    question = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--no-margins", "--modes", "1", "--json"]
    path, t, white = tmp_path / "slow.csv", 1e-2 * np.arange(2000), np.random.default_rng(26).standard_normal(2000)
    slow = np.array(list(accumulate(white, lambda before, each: 0.9 * before + each)))
    np.savetxt(path, np.c_[t, MEAN + 0.01 * slow], "%.9g", ",", header="time / s,force / N", comments="")
    for each in (path, written(tmp_path, "N")):
        fitted = fr.ForceRecord.from_csv(each)
        assert fitted.harmonic_numbers
        assert "may be chance" not in fitted.note
        assert cli.main([*question, "--force", str(each), "--amplitude", "0", "--noise", "spectrum"]) == 0
        found = json.loads(capsys.readouterr().out)
        record = fr.ForceRecord.from_csv(each, harmonics=0)
        assert found["force_record"]["harmonic_numbers"] == []
        assert found["force_record"]["noise_N"] == record.noise > fitted.noise


def test_a_slow_record_of_less_than_two_periods_may_be_random_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t, path = np.arange(0.0, 20.0, 1e-2), tmp_path / "slow.csv"
    force = MEAN + 0.02 * np.sin(0.45 * t) + 0.01 * np.random.default_rng(1).standard_normal(t.size)
    np.savetxt(path, np.c_[t, force], "%.9g", ",", header="time / s,force / N", comments="")
    question = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--no-margins", "--modes", "1"]
    assert cli.main([*question, "--force", str(path), "--noise", "spectrum"]) == 2
    said = capsys.readouterr().err
    assert re.search(r"two periods or more, got 1\.\d:", said)
    match = re.search(r"random alone, take its spectrum: (--amplitude 0 --noise spectrum) ", said)
    assert match is not None
    assert cli.main([*question, "--force", str(path), *match[1].split()]) == 0
    assert "no sine" in capsys.readouterr().out


def test_modes_under_harmonics_alone_are_not_called_coupled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = checked(capsys, "--damping-rate", "0.3", "--force", str(written(tmp_path, "N")), "--no-margins")
    assert "modes" in lines["checked"]
    assert "coupled" not in lines["checked"]


def test_an_amplitude_of_zero_has_the_unit_of_the_mean(capsys: pytest.CaptureFixture[str]) -> None:
    lines = checked(capsys, "--mean", "0.5lbf", "--amplitude", "0", "--frequency", "24Hz")
    assert "amplitude 0 lbf" in lines["load"]


@pytest.mark.slow
def test_a_record_that_pulls_on_average_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Many load cells count compression as negative, and what pulls buckles nothing."""
    t = np.arange(0.0, 2.0, 1e-3)
    force = 4.0 + 2.0 * np.sin(2.0 * np.pi * 16.0 * t)
    said = {}
    for sign in (1.0, -1.0):
        path = tmp_path / f"record{sign:g}.csv"
        np.savetxt(path, np.c_[t, sign * force], "%.6g", ",", header="time / s,force / N", comments="")
        assert cli.main(["check", "--rod", "nitinol", "--force", str(path), "--modes", "1-4"]) == 0
        said[sign] = capsys.readouterr().out
        assert ("pulls on average" in repr(fr.ForceRecord.from_csv(path))) == (sign < 0.0)
    assert "pulls on average" in said[-1.0]
    assert "change the sign" not in said[1.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    "question",
    [
        "check --modes 1-4 --json",
        "ranges --mean 0:0.2Fcr",
        "certify --mean 0:0.01Fcr",
        "map --mean 0:0.2Fcr --amplitude 0:0.1Fcr --points 3x3 --out {}.npz",
        "simulate --case A:6 --duration 1ms --out {}.npz",
        "explore --out {}.png",
    ],
)
def test_every_command_warns_of_a_record_that_pulls_on_average(
    question: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Answers without a line on the record, and JSON, would leave a sensor of the other sign unnoticed."""
    monkeypatch.chdir(tmp_path)
    t = np.arange(0.0, 0.5, 1e-3)
    push = MEAN + AMPLITUDE * np.sin(OMEGA * t)
    said = {}
    for sign in (1, -1):
        np.savetxt("record.csv", np.c_[t, sign * push], "%.6g", ",", header="time / s,force / N", comments="")
        cli.main([*question.format(sign).split(), "--rod", "nitinol", "--force", "record.csv"])
        said[sign] = capsys.readouterr().err
    assert "pulls" not in said[1]
    line = "floquetrod: warning: the record pulls on average, as forces are positive in compression; if the sensor"
    assert said[-1].count(line) == 1


def test_a_slow_wave_is_passed_over_with_an_approximate_frequency(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its refusal names the option, with which the frequency is refined as in Python."""
    t = np.arange(0.0, 10.0, 5e-3)
    force = MEAN + AMPLITUDE * (np.sin(OMEGA * t) + 1.3 * np.sin(0.9 * t))
    force += 0.02 * AMPLITUDE * np.random.default_rng(0).standard_normal(t.size)
    path = tmp_path / "slow.csv"
    np.savetxt(path, np.c_[t, force], "%.9g", ",", header="time / s,force / N", comments="")
    asked = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--no-margins", "--modes", "1-4"]
    asked += ["--force", str(path)]
    assert cli.main(asked) == 2
    assert "approximate frequency: --force-frequency" in capsys.readouterr().err
    assert cli.main([*asked, "--force-frequency", f"{1.02 * OMEGA:g}rad/s"]) == 0
    assert re.search(r"^record .* 23\.873\d* Hz \+- .*, harmonic 1 above", capsys.readouterr().out, re.MULTILINE)


def test_a_frequency_that_moves_the_strongest_harmonic_is_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is that of the fundamental, which may be far from that of the strongest harmonic."""
    t = np.arange(0.0, 5.0, 2e-3)
    for number, moved in ((1, False), (3, True)):
        force = MEAN + AMPLITUDE * (np.sin(number * 31.4 * t) + 0.2 * np.cos((number + 1) * 31.4 * t))
        force += 0.02 * AMPLITUDE * np.random.default_rng(0).standard_normal(t.size)
        path = tmp_path / "slow.csv"
        np.savetxt(path, np.c_[t, force], "%.9g", ",", header="time / s,force / N", comments="")
        asked = ["--rod", "nitinol", "--damping-rate", "0.3", "--force", str(path)]
        for command, given, said in (
            (["check", "--no-margins", "--modes", "1-4"], "15Hz", "15 Hz .* to 45 Hz"),
            (["ranges"], "10:10.2Hz", "10:10.2 Hz .* to between 30 and 30.6 Hz"),
        ):
            assert cli.main([*command, *asked, "--frequency", given]) == 0
            warned = re.search(rf"--frequency {said}", found := capsys.readouterr().err.replace("\n", " "))
            assert (warned is not None) == moved, found
            if moved:
                assert "replaces that of the fundamental, 4.99" in found
                assert "number 3, moves from 14.99 to " in found
    assert cli.main(["check", "--no-margins", "--modes", "1-4", *asked]) == 0
    answer = capsys.readouterr()
    assert "--frequency" not in answer.err
    assert re.search(r"harmonics 3, 4 above a noise of [\d.]+ N, the strongest, number 3, at 14\.99\d* Hz;", answer.out)
