"""The units of an answer are those of its question, kind by kind, in Python and in the terminal."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
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
        if chosen := asked[kind] or written[kind]:
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


@pytest.mark.parametrize(("length", "force"), [("ft", "lbf"), ("m", "kN")])
def test_a_survey_says_in_which_units_a_reach_is_answered(length: str, force: str) -> None:
    size = units_of("length")[length]
    depths = [f"{depth / size!r}{length}" for depth in (0.0, 900.0, 1200.0, 2400.0)]
    path = fr.WellPath(depths, ["0deg", "0deg", "90deg", "90deg"])
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
    push = "20kN" if force == "kN" else None
    reach = rod.reach(path, 0.3, push=push)
    text = str(reach.report())
    assert f" {length}" in text.splitlines()[0]
    assert f"{force}/{length} in air" in text
    assert text == str(reach.report(depth=length, force=force))
    plain = rod.reach(fr.WellPath(path.depth.copy(), path.inclination.copy()), 0.3, push=push)
    assert str(plain.report(depth=length, force=force)) == text
    assert (plain.reach, plain.as_dict()) == (reach.reach, reach.as_dict())
