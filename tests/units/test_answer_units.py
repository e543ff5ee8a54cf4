"""The units of an answer are those of its question, kind by kind, in Python and in the terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.cli.main import main
from floquetrod.units import AnswerUnits, GivenUnits, units_of

NAMES = {
    "length": st.sampled_from(["", "m", "ft", "in", "mm", "ftUS"]),
    "force": st.sampled_from(["", "N", "kN", "lbf", "klbf", "daN"]),
    "pressure": st.sampled_from(["", "MPa", "psi", "bar"]),
    "frequency": st.sampled_from(["", "Hz", "rpm"]),
}


@given(st.fixed_dictionaries(NAMES), st.fixed_dictionaries(NAMES))
def test_what_is_asked_for_comes_before_what_was_given_and_that_before_what_is_usual(
    asked: dict[str, str], written: dict[str, str]
) -> None:
    shown = AnswerUnits.named(**{k: name or None for k, name in asked.items()}, given=GivenUnits(**written))
    for kind in NAMES:
        if chosen := asked[kind] or written[kind].replace("ftUS", "ft"):
            assert getattr(shown, kind) == (chosen, units_of(kind)[chosen])
    in_feet = shown.length.name in ("ft", "ftUS", "in")
    if not (asked["force"] or written["force"]):
        assert shown.force.name == ("lbf" if in_feet else "N")
    if not (asked["length"] or written["length"]):
        assert in_feet == (shown.force.name in ("lbf", "klbf"))
    assert (shown.speed.name, shown.across.name) == (("ft/min", "in") if in_feet else ("m/s", "mm"))


def test_units_are_those_in_which_a_question_was_given() -> None:
    path = fr.WellPath(["0ft", "3000ft", "4000ft"], ["0deg", "0deg", "90deg"])
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0, fluid_outside="9.2ppg")
    assert path.given_units == path.part(100.0, 200.0).given_units == GivenUnits(length="ft")
    assert rod.given_units == rod.replace(damping_rate=0.1).given_units == GivenUnits(across="in", density="ppg")
    assert rod.replace(length="200ft").given_units.length == "ft"
    assert rod.replace(path=path, depth=1000.0, length=30.0).given_units.length == "ft"
    load = fr.AxialLoad("2lbf", 1.0, "24Hz")
    assert load.given_units == load.varied("mean", 3.0).given_units == GivenUnits(force="lbf", frequency="Hz")
    assert fr.AxialLoad.hertz(1.0, 1.0, 24.0).given_units.frequency == "Hz"
    assert fr.AxialLoad(1.0, 1.0, 24.0).given_units == GivenUnits()
    assert fr.VibrationTool("5kN", "18Hz", "30m").given_units == GivenUnits("m", force="kN", frequency="Hz")


def test_equality_and_arguments_do_not_depend_on_units() -> None:
    typed, plain = fr.AxialLoad("2kN", "1kN", "1rad/s"), fr.AxialLoad(2e3, 1e3, 1.0)
    assert (typed, hash(typed), typed.as_dict()) == (plain, hash(plain), plain.as_dict())
    assert fr.WellPath(["0m", "100m"], 0.5) == fr.WellPath([0.0, 100.0], 0.5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("length", "force", "weight"), [("ft", "lbf", "lbf/ft"), pytest.param("m", "kN", "N/m", marks=pytest.mark.slow)]
)
def test_a_survey_says_in_which_units_a_reach_is_answered(length: str, force: str, weight: str) -> None:
    size = units_of("length")[length]
    depths = [f"{depth / size!r}{length}" for depth in (0.0, 900.0, 1200.0, 2400.0)]
    path = fr.WellPath(depths, ["0deg", "0deg", "90deg", "90deg"])
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
    push = "20kN" if force == "kN" else None
    reach = rod.reach(path, 0.3, push=push)
    text = str(reach.report())
    assert f" {length}" in text.splitlines()[0]
    assert f"{weight} in air" in text
    assert text == str(reach.report(depth=length, force=force))
    plain = rod.reach(fr.WellPath(path.depth.copy(), path.inclination.copy()), 0.3, push=push)
    assert str(plain.report(depth=length, force=force)) == text
    assert (plain.reach, plain.as_dict()) == (reach.reach, reach.as_dict())


SURVEY = "MD ({unit}),Inc (deg)\n0,0\n{a!r},0\n{b!r},90\n{c!r},90\n"


def test_one_question_in_feet_and_in_si_has_one_answer_in_terminal_and_python(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    foot, reach, answers = units_of("length")["ft"], fr.Rod.reach, {}

    def reach_once(rod: fr.Rod, path: fr.WellPath, *given: Any, **named: Any) -> Any:
        """Return the answer to one question in one unit, computed once."""
        question = path.given_units, rod.given_units, repr((rod, path, given, named))
        if question not in answers:
            answers[question] = reach(rod, path, *given, **named)
        return answers[question]

    monkeypatch.setattr(fr.Rod, "reach", reach_once)
    sizes = {"ft": (1.0, "4.778in"), "m": (foot, f"{4.778 * 0.0254!r}m")}
    texts, numbers = {}, {}
    for unit, (size, bore) in sizes.items():
        file = tmp_path / f"{unit}.csv"
        depths = {name: depth * size for name, depth in {"a": 1200.0, "b": 1600.0, "c": 3000.0}.items()}
        file.write_text(SURVEY.format(unit=unit, **depths), encoding="utf-8")
        words = ["reach", "--well", str(file), "--rod", "2.00x0.156 CT90", "--bore", bore, "--friction", "0.3"]
        for asked in ([], ["--unit", "ft,lbf,ksi"], ["--unit", "m,kN,MPa"]):
            assert main([*words, *asked]) == 0
            texts[unit, *asked[1:]] = capsys.readouterr().out
        assert main([*words, "--json"]) == 0
        numbers[unit] = json.loads(capsys.readouterr().out)
        rod = fr.Rod.catalogue("2.00x0.156 CT90", bore=bore, length=1000.0)
        in_python = rod.reach(fr.WellPath.from_csv(file), 0.3)
        assert f"{in_python.report()}\n" == texts[(unit,)]
    assert texts[("ft",)] == texts["ft", "ft,lbf,ksi"] == texts["m", "ft,lbf,ksi"]
    assert texts[("m",)] == texts["m", "m,kN,MPa"] == texts["ft", "m,kN,MPa"]
    assert "ft" in texts[("ft",)].splitlines()[0]
    assert numbers["ft"]["reach_m"] == pytest.approx(numbers["m"]["reach_m"], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("hertz", [True, False])
def test_bounds_in_hertz_are_answered_in_hertz(hertz: bool, capsys: pytest.CaptureFixture[str]) -> None:
    rod, load, turn = fr.Rod.nitinol(), fr.AxialLoad(0.3, 0.34, 1.0), 6.283185307179586
    bounds = ("22Hz", "25Hz") if hertz else (22.0 * turn, 25.0 * turn)
    intervals = rod.ranges("frequency", load, bounds)
    name = "Hz" if hertz else "rad/s"
    assert f"{'22 to 25' if hertz else '138.23 to 157.08'} {name}" in repr(intervals)
    assert intervals.table() == intervals.table(name)
    assert (intervals.unit, intervals.bounds[1]) == ("rad/s", pytest.approx(25.0 * turn))
    options = ["--mean", "0.3N", "--amplitude", "0.34N", "--frequency", "22Hz:25Hz" if hertz else "138.23:157.08"]
    assert main(["ranges", "--rod", "nitinol", *options]) == 0
    assert name in capsys.readouterr().out


def test_proofs_are_reported_in_the_units_of_their_question(capsys: pytest.CaptureFixture[str]) -> None:
    rod = fr.Rod.nitinol().replace(damping_rate=0.5)
    box = {"mean": ("0.56N", "0.59N"), "amplitude": ("0.32N", "0.34N"), "frequency": ("23.8Hz", "24Hz")}
    proof = rod.certify(**box, rod={"length": (3.09, 3.11)})
    assert ("load", "mean force 0.56 to 0.59 N") in proof.report().lines
    assert ("", "frequency 23.8 to 24 Hz") in proof.report().lines
    words = [f"--{name}={low.rstrip('NHz')}:{high}" for name, (low, high) in box.items()]
    line = ["certify", "--rod", "nitinol", "--damping-rate", "0.5", *words, "--vary", "length=3.09:3.11m"]
    assert main(line) == 0
    assert capsys.readouterr().out == f"{proof.report()}\n"
    plain = rod.certify(mean=(0.56, 0.59), amplitude=(0.32, 0.34), frequency=(150.0, 151.0))
    assert ("", "frequency 150 to 151 rad/s") in plain.report().lines
    assert ("", "frequency 23.8732 to 24.0324 Hz") in plain.report({"frequency": "Hz"}).lines
    safe = rod.largest_safe_box(fr.AxialLoad("0.577N", "0.339N", "23.9Hz"), vary=("mean",))
    assert " Hz" in str(safe.report())
    assert "rad/s" not in str(safe.report())


def test_rods_and_loads_are_reported_in_the_units_they_were_given_in() -> None:
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="200ft", fluid_outside="1.2sg")
    load = fr.AxialLoad("1klbf", "300lbf", "4Hz")
    text = str(rod.stability(load).report())
    assert "mean 1 klbf" in text
    assert "4 Hz (25.13 rad/s)" in text
    assert "1.2 sg" in text
    assert "lb/ft" in text
    assert "klbf" in repr(rod.critical("amplitude", load))
    assert " ft " in str(rod.lock_up(0.3).report())


def test_a_map_is_drawn_in_the_units_of_its_ranges() -> None:
    rod, turn = fr.Rod.nitinol(), 6.283185307179586
    typed = fr.stability_map(rod, mean=("0N", "1N", 4), amplitude="300mN", frequency=("10Hz", "40Hz", 5))
    plain = fr.stability_map(rod, mean=(0.0, 1.0, 4), amplitude=0.3, frequency=(10.0 * turn, 40.0 * turn, 5))
    assert typed == plain
    assert typed.x.unit == plain.x.unit == "rad/s"
    drawn = [chart.plot(bands=False) for chart in (typed, plain, plain.in_units(frequency="Hz"))]
    assert [axes.get_xlabel().rpartition(" / ")[2] for axes in drawn] == ["Hz", "(rad/s)", "Hz"]
    assert drawn[0].get_xlim() == pytest.approx(drawn[2].get_xlim())
    bands = typed.plot().get_xlim()
    assert bands == pytest.approx((10.0, 40.0))
    assert typed.in_units(frequency="rpm").plot(bands=False).get_xlabel().endswith("rpm")


@pytest.mark.slow
def test_a_figure_of_ranges_names_the_fixed_quantities_in_the_units_of_the_question() -> None:
    rod, load = fr.Rod.nitinol(), fr.AxialLoad("0.1lbf", "0.05lbf", "17Hz")
    for found in (
        rod.ranges("frequency", load, ("10Hz", "16Hz")),
        rod.ranges("frequency", None, ("10Hz", "16Hz"), mean="0.1lbf", amplitude="0.05lbf"),
    ):
        assert found.plot().get_title() == "frequency, at mean force 0.1 lbf and amplitude 0.05 lbf"
    rpm = fr.AxialLoad("0.1lbf", "0.05lbf", "1020rpm")
    forces = rod.ranges("mean", rpm, (0.0, 0.4))
    assert forces.plot().get_title() == "mean force, at amplitude 0.222 N and frequency 1,020 rpm"


@pytest.mark.slow
def test_a_figure_and_a_map_of_the_terminal_are_in_the_units_typed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    rod, fixed = ["--rod", "nitinol", "--out", str(tmp_path / "f.svg")], ["--mean", "0.1lbf", "--amplitude", "0.05lbf"]
    assert main(["ranges", *rod, *fixed, "--frequency", "10Hz:16Hz"]) == 0
    assert "at mean force 0.1 lbf and amplitude 0.05 lbf" in (tmp_path / "f.svg").read_text(encoding="utf-8")
    assert main(["map", *rod, "--mean", "0:0.2lbf", "--amplitude", "0:10%", "--frequency", "17Hz"]) == 0
    assert "critical force 0.381282 lbf" in capsys.readouterr().out
    assert "critical force 0.381282 lbf" in (tmp_path / "f.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "push", [["--mean", "0.1lbf", "--amplitude", "0.05lbf"], ["--mean", "20%", "--amplitude", "5%"]]
)
def test_a_second_sine_is_in_the_units_typed(push: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    line = ["check", "--rod", "nitinol", *push, "--frequency", "17Hz", "--second", "0.025lbf@17.22Hz", "--no-margins"]
    assert main(line) in (0, 1)
    assert "a second sine of 0.025 lbf at 17.22 Hz" in capsys.readouterr().out


def test_a_second_sine_alone_may_give_the_units() -> None:
    assert fr.AxialLoad(0.1, 0.1, 100.0, second=("0.025lbf", "17.22Hz")).features == (
        "a second sine of 0.025 lbf at 17.22 Hz"
    )
