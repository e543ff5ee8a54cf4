"""The terminal for rods whose modes are coupled: reports, JSON, options of the load, and refusals in one line."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod import AxialWave, cli
from tests.conftest import DEEP
from tests.seams import Tuned

mpl.use("Agg")
ROOT = Path(__file__).parents[2]
WIRE, WELL = (str(ROOT / f"floquetrod/examples/{name}.toml") for name in ("wire", "well"))
PUSH = ["--mean", "0.3Fcr", "--amplitude", "0.2Fcr", "--frequency", "20Hz"]
SHAKE = ["--mean", "0.5Fcr", "--amplitude", "0.3Fcr", "--frequency", "4Hz"]
HERTZ = 2.0 * np.pi


def said(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert cli.main(arguments) == status
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    text = said(capsys, *arguments, "--json")
    return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    message = captured.err
    assert re.fullmatch(r"floquetrod: error: .+\n", message)
    return message


def load_of(rod: fr.Rod, mean: float, amplitude: float, hertz: float, **others: Any) -> fr.AxialLoad:
    return fr.AxialLoad(mean * rod.critical_force, amplitude * rod.critical_force, hertz * HERTZ, **others)


def wave_of(load: fr.AxialLoad, **others: Any) -> AxialWave:
    return AxialWave(load.mean, load.amplitude, load.frequency, **others)


@pytest.fixture
def record(tmp_path: Path) -> str:
    t = np.arange(1500) / 2000.0
    force = 0.6 + 0.4 * np.sin(20.0 * HERTZ * t) + 0.1 * np.cos(40.0 * HERTZ * t)
    force += 0.02 * np.random.default_rng(1).standard_normal(t.size)
    path = tmp_path / "record.csv"
    path.write_text("time (s),force (N)\n" + "\n".join(f"{a:.7f},{b:.7f}" for a, b in zip(t, force, strict=True)))
    return str(path)


@pytest.fixture
def asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compute the answer to one question once, however often the terminal and a test ask for it."""
    asks = {fr.Rod: ["stability", "ranges"], fr.results.RodStability: ["margin"]}
    for kind, names in asks.items():
        for name in names:
            monkeypatch.setattr(kind, name, remembering(getattr(kind, name)))
    search = fr.results.RodStability.margin
    if not DEEP:  # fewer samples, which find the same margins of these loads
        monkeypatch.setattr(
            fr.results.RodStability, "margin", lambda result, quantity, **_: search(result, quantity, seconds=1.0)
        )


def remembering(ask: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method that keeps its answers, by all that it is given but a report of progress."""

    def asked(*given: Any, **named: Any) -> Any:
        bound = inspect.signature(ask).bind(*given, **{name: v for name, v in named.items() if name != "progress"})
        bound.apply_defaults()
        question = repr(bound.arguments)
        if question not in ANSWERS.setdefault(ask.__name__, {}):
            ANSWERS[ask.__name__][question] = ask(*given, **named)
        return ANSWERS[ask.__name__][question]

    return asked


ANSWERS: dict[str, dict[str, Any]] = {}


# --- check -----------------------------------------------------------------------------------------------------------


def found_with_margins(result: fr.results.RodStability) -> tuple[str, ...]:
    """Return what `check` tells of margins, and of the damping that stabilises."""
    return (
        r"margins   mean force  stable 0\.223 Fcr lower",
        # Between two tongues, from 20.2943 to 20.295 Hz, the rod is stable, by an integration of ten modes, too.
        r"          frequency   stable 1\.28\d Hz lower or 0\.2943 Hz higher",
        r"          found by sampling",
        rf"damping   stable with every damping_rate tried above {result.damping_to_stabilise:.6g} 1/s",
    )


@pytest.mark.usefixtures("asked_once")
@pytest.mark.parametrize("margins", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_check_tells_all_a_user_needs(margins: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pyplot.close("all")  # of other tests
    shape = tmp_path / "shape.png"
    asked = [] if margins else ["--no-margins"]
    text = said(capsys, "check", "--rod", WIRE, *PUSH, *asked, "--out", str(shape), "--assumptions")
    result = fr.Rod.from_toml(WIRE).stability(load_of(fr.Rod.from_toml(WIRE), 0.3, 0.2, 20.0))
    assert text.startswith("UNSTABLE: direct resonance of mode 1, order 1; tenfold in ")
    for line in (
        r"ends clamped-hinged",
        r"load      mean 0\.3 Fcr \(0\.08066 N\), amplitude 0\.2 Fcr \(0\.05377 N\), 20 Hz \(125\.7 rad/s\)",
        r"          mean force 0\.264236 Fcr at the upper end, 0\.335764 Fcr at the lower",
        r"which is 0\.0074 axial wavelengths long",
        rf"growth    {result.growth_rate:.6g} 1/s, tenfold in {result.time_to_grow():.4g} s",
        rf"grows     direct resonance of mode 1, order 1, {result.growth_rate:.6g} 1/s",
        *(found_with_margins(result) if margins else ()),
        r"checked   \d+ coupled modes; with \d+ growth differs by ",
        r"method    half_period, 1 half period; growth good to \de-\d+ 1/s",
    ):
        assert re.search(line, text), line
    assert text.endswith(f"written: {shape}\n")
    assert shape.read_bytes().startswith(b"\x89PNG")
    assert pyplot.get_fignums() == []


def test_json_says_what_the_library_does(capsys: pytest.CaptureFixture[str]) -> None:
    wave = ["--wave", "held", "--axial-damping", "0.5", "--mean-at", "0", "--no-margins"]
    found = answer(capsys, "check", "--rod", WIRE, *PUSH, *wave)
    rod = fr.Rod.from_toml(WIRE)
    load = wave_of(load_of(rod, 0.3, 0.2, 20.0), axial_damping=0.5, mean_at=0.0)
    result = rod.stability(load)
    assert found["status"] == result.status == "unstable"
    assert found["growth_rate_per_s"] == result.growth_rate
    assert found["growth_rate_error_per_s"] == result.error
    assert [(entry["modes"], entry["growth_rate_per_s"]) for entry in found["convergence"]] == list(result.convergence)
    first = found["resonances"][0]
    assert first["name"] == str(result.resonances[0])
    assert tuple(first["modes"]) == result.resonances[0].modes
    assert found["load"] == {
        "type": "AxialWave",
        "mean_at": 0.0,
        "waveform": "sine",
        "far_end": "held",
        "axial_damping": 0.5,
    }
    assert fr.Rod(**found["rod"]) == rod


@pytest.mark.slow
@pytest.mark.usefixtures("asked_once")
def test_json_tells_the_margins_that_the_library_finds(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, "check", "--rod", WIRE, *PUSH)
    rod = fr.Rod.from_toml(WIRE)
    result = rod.stability(load_of(rod, 0.3, 0.2, 20.0))
    margin = result.mean_force_margin
    assert found["damping_to_stabilise_per_s"] == result.damping_to_stabilise
    assert found["mean_force_margin_below_N"] == margin.below
    assert found["mean_force_margin_resolution_N"] == margin.resolution > 0.0
    assert found["mean_force_margin_searched_N"] == list(margin.searched)


@pytest.mark.slow
def test_the_weight_along_the_rod_may_be_neglected(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "check", "--rod", WELL, *SHAKE, "--mean-at", "none")
    assert "          weight along the rod neglected\n" in text
    assert "where                  growth 1/s" in text  # independent modes
    rod = fr.Rod.from_toml(WELL)
    result = rod.stability(load_of(rod, 0.5, 0.3, 4.0, mean_at=None))
    assert f"growth    {result.growth_rate:.6g} 1/s in mode {result.fastest_mode}" in text
    friction = ["--mean-at", "none", "--no-margins", "--friction", "0.2", "--kick", "5mm/s"]
    assert "without friction:" in said(capsys, "check", "--rod", WELL, *SHAKE, *friction)


def test_the_exit_code_is_the_verdict(capsys: pytest.CaptureFixture[str]) -> None:
    said(capsys, "check", "--rod", WIRE, *PUSH, "--no-margins", "--exit-code", status=1)
    stable = ["--mean", "0", "--amplitude", "0.1Fcr", "--frequency", "20Hz", "--damping-rate", "3"]
    assert said(capsys, "check", "--rod", WIRE, *stable, "--no-margins", "--exit-code").startswith(
        "STABLE: nothing grows\n"
    )


@pytest.mark.slow
@pytest.mark.usefixtures("asked_once")
def test_margins_are_left_out_where_they_take_long(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "check", "--rod", WIRE, *PUSH, "--modes", "1-51")
    assert "margins   not searched, because this takes hundreds of verdicts; add --margins" in text
    assert "checked   51 coupled modes, as requested" in text
    assert "mean_force_margin_below_N" not in answer(capsys, "check", "--rod", WIRE, *PUSH, "--no-margins")
    plain = ["check", "--rod", "nitinol", *PUSH]
    assert "margins " not in said(capsys, *plain, "--no-margins")
    assert said(capsys, *plain, "--margins") == said(capsys, *plain)


def test_a_measured_force_is_told_in_the_units_asked_for(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "check", "--rod", "nitinol", "--force", record, "--no-margins", "--unit", "lbf,Hz,ft")
    pound, rod = 4.4482216152605, fr.Rod.nitinol()
    measured = fr.ForceRecord.from_csv(record)
    assert f"critical force {rod.critical_force / pound:.4g} lbf" in text
    line = next(each for each in text.splitlines() if each.startswith("record"))
    assert f"mean {measured.mean / pound:.6g} lbf and amplitude {measured.amplitude / pound:.6g} lbf" in line
    assert f" {measured.frequency / 2.0 / np.pi:.6g} Hz +- " in line
    assert " N" not in line


@pytest.mark.slow
def test_a_measured_force(record: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pyplot.close("all")  # of other tests
    fit = tmp_path / "fit.svg"
    given = ["check", "--rod", "nitinol", "--force", record, "--mean", "0.2Fcr"]
    text = said(capsys, *given, "--no-margins", "--out", str(fit))
    measured = fr.ForceRecord.from_csv(record)
    assert f"amplitude {measured.amplitude:.6g} N" in text
    assert "          waveform of 2 harmonics\n" in text
    assert "record    force of mean " in text
    assert text.endswith(f"written: {fit}\n")
    assert fit.exists()
    assert pyplot.get_fignums() == []
    found = answer(capsys, *given, "--no-margins")
    rod = fr.Rod.nitinol()
    mean = 0.2 * rod.critical_force
    load = fr.AxialLoad(mean, measured.amplitude, measured.frequency, waveform=measured.waveform)
    assert found["growth_rate_per_s"] == rod.stability(load).growth_rate
    assert (found["mean_N"], found["amplitude_N"]) == (mean, measured.amplitude)
    assert found["force_record"]["harmonic_numbers"] == [1, 2]
    assert found["load"]["waveform"] == [[h.real, h.imag] for h in measured.waveform]
    # Without --mean that of the record; as a wave, too.
    whole = answer(capsys, "check", "--rod", "nitinol", "--force", record, "--wave", "driven", "--no-margins")
    assert whole["mean_N"] == measured.mean
    waves = wave_of(
        fr.AxialLoad(measured.mean, measured.amplitude, measured.frequency),
        far_end="driven",
        waveform=measured.waveform,
    )
    assert whole["growth_rate_per_s"] == rod.stability(waves).growth_rate


# --- ranges and maps -------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("asked_once")
def test_ranges_name_resonances_and_their_resolution(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    question = ["ranges", "--rod", WIRE, "--amplitude", "0.2Fcr", "--frequency", "20Hz", "--mean", "0:0.6Fcr"]
    text = said(capsys, *question)
    assert re.search(r"  unstable .* sum resonance of modes 1 and 4, order 1\n", text)
    assert re.search(r"\nsampled +unstable bands narrower than \S+ Fcr may have been missed\n", text)
    found = answer(capsys, *question)
    rod = fr.Rod.from_toml(WIRE)
    unit = rod.critical_force
    expected = rod.ranges("mean", amplitude=0.2 * unit, frequency=20.0 * HERTZ, bounds=(0.0, 0.6 * unit))
    assert [(part["low_N"], part["high_N"]) for part in found["stable"]] == [(p.low, p.high) for p in expected]
    assert found["stable"][0]["low_end"] is None
    assert [part["high_end"] and part["high_end"]["name"] for part in found["stable"]] == [
        part.high_end and str(part.high_end) for part in expected
    ]
    assert found["parts_missed_up_to_N"] == expected.resolution > 0.0
    sampled = answer(capsys, "ranges", "--rod", "nitinol", "--force", record, "--mean", "0:0.3N")
    measured = fr.ForceRecord.from_csv(record)
    like = fr.AxialLoad(0.0, 1.0, 1.0, waveform=measured.waveform)
    wanted = fr.Rod.nitinol().ranges(
        "mean", like, amplitude=measured.amplitude, frequency=measured.frequency, bounds=(0.0, 0.3)
    )
    assert [part["low_N"] for part in sampled["stable"]] == [part.low for part in wanted]


@pytest.mark.slow
def test_ranges_say_where_a_resonance_has_no_name(tuned: Tuned, capsys: pytest.CaptureFixture[str]) -> None:
    tuned(modes_whose_resonances_are_named=2)  # in place of 200
    question = ["ranges", "--rod", WIRE, "--amplitude", "0.2Fcr", "--frequency", "20Hz", "--mean", "0:0.6Fcr"]
    found = answer(capsys, *question)
    assert (found["stable"][0]["low_end"], found["stable"][0]["high_end"]) == (None, "unnamed")
    assert "'unnamed'" in found["ends_are"]


@pytest.mark.slow
@pytest.mark.usefixtures("asked_once")
def test_ranges_take_waves(capsys: pytest.CaptureFixture[str]) -> None:
    question = ["ranges", "--rod", WELL, "--mean", "0.5Fcr", "--frequency", "4Hz", "--amplitude", "0:0.1Fcr"]
    rod = fr.Rod.from_toml(WELL)
    unit = rod.critical_force
    like = AxialWave(0.0, 0.0, 1.0, far_end="free", axial_damping=0.5)
    expected = rod.ranges("amplitude", like, mean=0.5 * unit, frequency=4.0 * HERTZ, bounds=(0.0, 0.1 * unit))
    found = answer(capsys, *question, "--wave", "free", "--axial-damping", "0.5")
    assert [part["high_N"] for part in found["stable"]] == [part.high for part in expected]


@pytest.mark.slow
def test_maps_say_what_kind_of_load_they_are_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "map.npz"
    load = ["--mean", "0:1Fcr", "--amplitude", "0:0.5Fcr", "--frequency", "4Hz", "--points", "5x4"]
    text = said(capsys, "map", "--rod", WELL, *load, "--wave", "driven", "--out", str(path), "--growth")
    assert text.startswith("rod, axial waves, both ends driven, frequency 4 Hz, critical force ")
    chart = fr.Chart.load(path)
    assert chart.subject["load"]["far_end"] == "driven"
    rod = fr.Rod.from_toml(WELL)
    like = AxialWave(0.0, 0.0, 1.0, far_end="driven")
    means, amplitudes = chart.x.values, chart.y.values[:, None]
    assert np.array_equal(chart.stable, rod.is_stable(like, mean=means, amplitude=amplitudes, frequency=4.0 * HERTZ))
    assert np.array_equal(
        chart.growth_rate, rod.growth_rate(like, mean=means, amplitude=amplitudes, frequency=4.0 * HERTZ)
    )
    reports: list[tuple[int, int]] = []
    axes = {"mean": (0.0, rod.critical_force, 250), "amplitude": (0.0, 1.0, 9)}
    fr.stability_map(rod, **axes, frequency=25.0, progress=lambda *done: reports.append(done))
    assert reports == [(1998, 2250), (2250, 2250)]  # whole columns of 9
    plain = said(capsys, "map", "--rod", WIRE, *load, "--out", str(tmp_path / "map.png"))
    assert plain.startswith("rod, frequency 4 Hz")


# --- refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_noise_of_a_record_counts_in_the_terminal_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rod = fr.Rod.nitinol().replace(damping_rate=0.3)
    shape = fr.AxialLoad(0.3 * rod.critical_force, 1.0, 150.0, waveform=(-1j, 0.5))
    edge = rod.critical("amplitude", shape)
    t = np.arange(0.0, 0.5, 4e-4)
    force = shape.mean + edge * (np.sin(150.0 * t) + 0.5 * np.cos(300.0 * t))
    noise = 0.1 * edge * np.random.default_rng(0).standard_normal(t.size)
    path = tmp_path / "force.csv"
    np.savetxt(path, np.c_[t, force + noise], "%.9g", ",", header="time / s,force / N", comments="")
    given = ["check", "--rod", "nitinol", "--damping-rate", "0.3", "--force", str(path), "--no-margins"]
    found, expected = answer(capsys, *given), rod.stability(fr.ForceRecord.from_csv(path))
    assert (found["status"], found["growth_rate_error_per_s"]) == (expected.status, expected.error)
    assert expected.status == "undecided"
    assert found["note"] == expected.note
    assert cli.main([*given, "--exit-code"]) == 3
    assert "sine      of the same mean, amplitude and frequency: " in capsys.readouterr().out
    replaced = answer(capsys, *given, "--mean", f"{shape.mean}N")
    assert (found["force_record"]["noise_in_error"], replaced["force_record"]["noise_in_error"]) == (True, True)
    assert replaced["status"] == "undecided"  # the amplitude is as uncertain, if the mean is given


@pytest.mark.parametrize("command", ["check", "ranges", "map"])
@pytest.mark.parametrize(
    ("option", "text", "remedy"),
    [
        ("--wave", "up", "--wave must be one of held, free, driven"),
        ("--mean-at", "2", "a fraction of the length from 0, the upper end, to 1, the lower, or none"),
        ("--mean-at", "-0.1", "a fraction of the length"),
        ("--mean-at", "middle", "a fraction of the length"),
        ("--mean-at", "", "a fraction of the length"),
        ("--mean-at", "nan", "a fraction of the length"),
        ("--axial-damping", "0.5", "add --wave held, free or driven"),
        ("--force", "no/such.csv", "a text file with columns of time and force, .*: there is no such file"),
        ("--force", "table.toml", "a text file with columns of time and force: "),
        ("--force", ".", "a text file with columns of time and force, and .* is a folder"),
        ("--force", "", "a text file with columns of time and force, and .* is a folder"),
    ],
)
def test_junk_is_one_line_that_names_option_value_and_remedy(
    command: str,
    option: str,
    text: str,
    remedy: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("table.toml").write_text('length = "1m"\n')
    loads = {"check": PUSH, "ranges": [*PUSH[2:], "--mean", "0:1Fcr"]}
    loads["map"] = [*PUSH[4:], "--mean", "0:1Fcr", "--amplitude", "0:1Fcr"]
    message = refused(capsys, command, "--rod", WIRE, *loads[command], f"{option}={text}")
    assert option in message
    assert text in message
    assert re.search(remedy, message)


@pytest.mark.parametrize("rate", ["-1", "x", "nan", "1Hz", "1e400"])
def test_bad_rates_of_axial_damping(rate: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = refused(capsys, "check", "--rod", WIRE, *PUSH, "--wave", "held", f"--axial-damping={rate}")
    assert "--axial-damping must be" in message
    assert repr(rate) in message


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--friction", "0.1", "--kick", "5mm/s"], "--friction needs independent modes.*clamped-hinged ends, weight"),
        (["--modes", "3,5"], r"got \[3, 5\]; give --modes 1-n"),
        (["--out", "shape.doc"], "--out must end in .png, .pdf or .svg, got 'shape.doc'"),
        (["--method", "segmented"], "--method belongs to --system"),
    ],
)
def test_what_coupled_modes_do_not_have(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert re.search(message, refused(capsys, "check", "--rod", WIRE, *PUSH, *arguments))


@pytest.mark.slow
def test_independent_modes_draw_the_sine_that_grows_and_keep_the_verdict_where_none_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture, load = tmp_path / "shape.svg", ["--amplitude", "0.2Fcr", "--frequency", "150rad/s", "--no-margins"]
    for mean in "0.2Fcr", "0.3Fcr":
        assert cli.main(["check", "--rod", "nitinol", "--mean", mean, *load, "--out", str(picture)]) == 0
        text = capsys.readouterr().out
        grows = text.startswith("UNSTABLE")
        assert picture.exists() is grows is ("written" in text)
        assert ("shape     not drawn: plot draws the shape in which the rod grows" in text) is not grows
        picture.unlink(missing_ok=True)
    rod = fr.Rod.nitinol()
    verdict = rod.stability(fr.AxialLoad(0.2 * rod.critical_force, 0.2 * rod.critical_force, 150.0))
    drawn = verdict.plot().lines[0].get_ydata()
    assert np.count_nonzero(np.diff(np.sign(drawn[1:-1][np.abs(drawn[1:-1]) > 1e-9]))) == verdict.fastest_mode - 1


def test_other_refusals(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    rubbing = ["--friction", "0.1", "--kick", "5mm/s"]
    assert "; --mean-at none neglects the weight" in refused(capsys, "check", "--rod", WELL, *SHAKE, *rubbing)
    plane = ["--mean", "0:1Fcr", "--amplitude", "0:1Fcr", "--frequency", "20Hz", "--paper-criterion", "exact"]
    assert "--paper-criterion needs independent modes" in refused(capsys, "map", "--rod", WIRE, *plane)
    assert "the following arguments are required: --mean, --frequency (see floquetrod ranges --help)" in refused(
        capsys, "ranges", "--rod", WIRE, "--amplitude", "0:1Fcr"
    )
    for amplitude, helps in (("0", True), ("0.0lbf", True), ("0.3N", False)):
        constant = refused(capsys, "check", "--rod", WIRE, "--mean", "0.5Fcr", "--amplitude", amplitude)
        assert ("any will do, such as --frequency 1Hz" in constant) == helps
    assert "must be a range" in refused(capsys, "ranges", "--rod", WIRE, "--force", record)
    system = str(ROOT / "floquetrod/examples/system.toml")
    for option in (["--wave", "held"], ["--mean-at", "0"], ["--force", record], ["--margins"], ["--out", "x.png"]):
        assert f"{option[0]} belongs to --rod" in refused(capsys, "check", "--system", system, *option)


def test_a_warning_speaks_of_options(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "--rod", WELL, *SHAKE[:4], "--frequency", "20Hz", "--no-margins"]) == 0
    warning = capsys.readouterr().err
    assert warning.startswith("floquetrod: warning: at 125.664 rad/s (20 Hz) the rod is 0.24 axial wavelengths long")
    assert warning.endswith("; use --wave, which computes the waves\n")


def test_help_teaches_real_rods(capsys: pytest.CaptureFixture[str]) -> None:
    for command, words in (
        (
            "check",
            (
                "wire.toml",
                "--wave held",
                'ends = "clamped-hinged"',
                "catalogue = ",
                "bore = ",
                "--force record",
            ),
        ),
        ("ranges", ("wire.toml", "--wave held", "--force record.csv")),
        ("map", ("wire.toml", "--wave free")),
    ):
        with pytest.raises(SystemExit):
            cli.main([command, "--help-all"])
        text = capsys.readouterr().out
        assert [word for word in words if word not in text] == []


@pytest.mark.slow
def test_margins_of_a_record_wait_until_they_are_asked_for_and_its_frequency_is_in_hertz(
    record: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = said(capsys, "check", "--rod", "nitinol", "--force", record)
    assert "margins   not searched, because this takes hundreds of verdicts; add --margins" in text
    assert re.search(r"load .* [\d.]+ Hz \(", text)
