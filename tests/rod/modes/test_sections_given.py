"""Strings of sections as people give them: in Python, in files and in the terminal, and what is said of a wrong one."""

from __future__ import annotations

import copy
import json
import pickle
import re
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.cli.main import main
from tests.conftest import depth

TUBING, THICK = "2.00x0.156 CT90", "2.00x0.203 CT90"
SECTIONS = (
    fr.Section(TUBING, length="30m"),
    fr.Section(THICK, length="25m"),
    fr.Section(diameter="2.875in", inner_diameter="1in", length="5m"),
)
WATER: dict[str, Any] = {"fluid_inside": "8.6ppg", "fluid_outside": "8.6ppg"}
BORES = [("0m", "4.778in"), ("45m", "6.184in")]
STRING = fr.Rod(sections=SECTIONS, bores=BORES, damping_rate=0.2, **WATER)
FILE = """\
bores = [["0m", "4.778in"], ["45m", "6.184in"]]
fluid_inside = "8.6ppg"
fluid_outside = "8.6ppg"
damping_rate = 0.2

[[sections]] # from the upper end down
name = "2.00x0.156 CT90"
length = "30m"

[[sections]]
name = "2.00x0.203 CT90"
length = "25m"

[[sections]]
diameter = "2.875in"
inner_diameter = "1in"
length = "5m"
"""
PUSH = ["--mean", "7.1kN", "--amplitude", "3.84kN", "--frequency", "2.55Hz"]


def string(**changes: Any) -> fr.Rod:
    """Return a string of two sections in a bore, with other arguments."""
    return fr.Rod(**{"sections": SECTIONS[:2], "channel_diameter": "4.778in", **WATER} | changes)


def in_bores(*bores: Any, **changes: Any) -> fr.Rod:
    """Return the string in bores."""
    return string(channel_diameter=None, bores=list(bores), **changes)


FIRST = ("0m", "4.778in")
WRONG: list[tuple[Callable[[], Any], tuple[str, ...]]] = [
    # the call; what its message names: the argument, what came, the way out
    (lambda: string(sections=[]), ("sections must be a list of one or more", "fr.Section", "leave it out")),
    (lambda: string(sections=SECTIONS[0]), ("sections must be a list", "got Section('2.00x0.156 CT90'")),
    (lambda: string(sections={"name": TUBING}), ("sections must be a list", "got {'name'")),
    (lambda: string(sections="2.00x0.156"), ("sections must be a list", "got '2.00x0.156'")),
    (lambda: string(sections=0), ("sections must be a list", "got 0")),
    (lambda: string(sections=[SECTIONS[0]] * 1_000_000), ("sections must be 1,000 at most", "got 1,000,000", "as one")),
    (lambda: string(sections=[SECTIONS[0], 5]), ("sections[1] must be a section", "got 5", "fr.Section(")),
    (lambda: string(sections=[SECTIONS[0], {"name": TUBING}]), ("sections[1]", "missing", "'length'")),
    (lambda: string(sections=[{"lenght": 3.0}]), ("sections[0]", "'lenght'", "did you mean length?")),
    (
        lambda: string(sections=[SECTIONS[0], {"name": TUBING, "length": "-3m"}]),
        ("sections[1]: length", "greater than zero", "-3"),
    ),
    (lambda: fr.Section(TUBING), ("missing", "'length'", "its arguments are")),
    (lambda: fr.Section(TUBING, length="0m"), ("length must be greater than zero", "give it in m")),
    (lambda: fr.Section(TUBING, length=float("nan")), ("length must be finite", "nan")),
    (lambda: fr.Section(TUBING, length="3kg"), ("length", "'3kg'", "it is a unit of mass")),
    (lambda: fr.Section("2.00x0.15", length=3.0), ("name", "'2.00x0.15'", "2.00x0.156", "diameter and wall_thickness")),
    (lambda: fr.Section(5, length=3.0), ("name", "got 5", "2.00x0.156 CT90")),  # type: ignore[arg-type]
    (lambda: fr.Section(length=3.0), ("radius must be given, in m", "diameter", "name of a pipe")),
    (lambda: fr.Section(TUBING, length=3.0, radius=0.02, diameter="4cm"), ("diameter", "'4cm'", "give one of them")),
    (
        lambda: fr.Section(diameter="5cm", wall_thickness="3cm", length=3.0),
        ("wall_thickness must be less than the outer radius", "0.03 m", "leave it out"),
    ),
    (lambda: fr.Section(diameter="5cm", inner_diameter="5cm", length=3.0), ("inner_radius", "less than the outer")),
    (lambda: fr.Section(TUBING, length=3.0, wall="3mm"), ("'wall'", "did you mean wall_thickness?")),  # type: ignore[call-arg]
    (lambda: string(radius="2in"), ("radius must not be given with sections", "'2in'", "each section has its own")),
    (lambda: string(length="60m"), ("length must not be given with sections", "'60m'", "each section has its own")),
    (lambda: string(weight="3lb/ft"), ("weight must not be given with sections", "'3lb/ft'")),
    (lambda: string().replace(length="60m"), ("length must not be given with sections", "'60m'")),
    (lambda: string(bores=BORES), ("channel_diameter must not be given with bores", "'4.778in'", "its own diameter")),
    (lambda: string(channel_diameter=None), ("channel_radius must be given", "channel_diameter, or bores")),
    (
        lambda: in_bores(FIRST, ("40m", "1.9in")),
        ("bores must leave room for every section", "1.9 in around section 2 of 2 in", "40 m", "wider bore"),
    ),
    (
        lambda: string(channel_diameter="48mm", sections=[{"diameter": "50mm", "length": 3.0}, SECTIONS[0]]),
        ("channel_radius must leave room", "48 mm around section 1 of 50 mm", "thinner section"),
    ),
    (lambda: in_bores(FIRST, ("40m", "6in"), ("30m", "5in")), ("bores[2]", "below", "'30m' after '40m'", "top down")),
    (lambda: in_bores(("10ft", "4.778in")), ("bores[0]", "upper end of the rod, at 0 m", "'10ft'")),
    (lambda: in_bores(), ("bores must be a list of one or more", "4.778in", "leave it out")),
    (lambda: in_bores(FIRST, "6in"), ("bores[1] must be a depth and a diameter", "'6in'", '("0m", "4.778in")')),
    (lambda: in_bores(("0m", "4.778in", 3)), ("bores[0] must be a depth and a diameter", "got ('0m'")),
    (lambda: string(channel_diameter=None, bores={"0m": "5in"}), ("bores must be a list", "got {'0m'")),
    (lambda: in_bores(("0m", 0.0)), ("bores[0] must be greater than zero", "got 0")),
    (lambda: in_bores(("0m", "4.778kg")), ("bores[0]", "'4.778kg'", "it is a unit of mass")),
    (lambda: in_bores((-3.0, "5in")), ("bores[0] must be zero or more", "-3", "depth in m")),
    (lambda: in_bores(("0m", float("nan"))), ("bores[0] must be finite", "nan")),
    (
        lambda: string(sections=[SECTIONS[0], {"diameter": "5cm", "inner_diameter": "4.9cm", "length": 3.0}],
                       fluid_inside=0.0, fluid_outside="2g/cm3"),
        ("section 2: fluid_outside must be lighter", "2000 kg/m^3", "this rod floats"),
    ),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_a_wrong_string_is_refused_in_one_line(number: int) -> None:
    call, words = WRONG[number]
    with pytest.raises((TypeError, ValueError)) as caught:
        call()
    message = str(caught.value)
    assert all(word in message for word in words), message
    assert "\n" not in message
    assert len(message) < 400


def replaced(old: str, new: str) -> str:
    """Return the file with a text replaced."""
    assert old in FILE
    return FILE.replace(old, new, 1)


WRONG_FILES: list[tuple[str, tuple[str, ...]]] = [
    # the file; what its message names
    (replaced('length = "25m"', 'lenght = "25m"'), ("section 2: unknown key 'lenght'", "did you mean length?")),
    (replaced('length = "25m"\n', ""), ("section 2: missing key 'length'", "the keys are name, ")),
    (replaced('diameter = "2.875in"\n', ""), ("section 3: missing key 'radius'", "diameter")),
    (replaced('"2.00x0.203 CT90"', '"2.00x0.20"'), ("section 2: name", "'2.00x0.20'", "2.00x0.203")),
    (replaced('"25m"', '"25kg"'), ("section 2: length", "'25kg'", "mass")),
    (replaced('"25m"', '"-25m"'), ("section 2: length must be greater than zero", "-25")),
    (replaced('diameter = "2.875in"', 'od = "2.875in"'), ("section 3: unknown key 'od'", "the outer diameter is")),
    (replaced('diameter = "2.875in"', 'diameter = "7in"'), ("bores must", "6.184 in around section 3 of 7 in")),
    (replaced('["45m", "6.184in"]', '["45m"]'), ("bore 2 must be a depth and a diameter", "got ['45m']")),
    (replaced('"45m"', '"45kg"'), ("bore 2 must be a number with a length unit", "'45kg'")),
    (replaced('["0m", ', '["3m", '), ("bore 1 must begin at or above the upper end", "'3m'")),
    (replaced('bores = [["0m", "4.778in"], ["45m", "6.184in"]]\n', ""), ("missing key 'channel_radius'",)),
    ("length = 60.0\n" + FILE, ("length must not be given with sections", "each section has its own")),
    ('bore = "5in"\n' + FILE, ("unknown key 'bore'", "bores")),
    ('catalogue = "2.00x0.156"\n' + FILE, ("catalogue must not be given with sections", 'name = "2.00x0.156"')),
    ("sections = []\n" + FILE.partition("[[sections]]")[0], ("sections must be a list of one or more",)),
    ("sections = [3]\n" + FILE.partition("[[sections]]")[0], ("sections must be tables [[sections]], got [3]",)),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(WRONG_FILES)))
def test_a_wrong_file_is_refused_in_one_line(number: int, tmp_path: Path) -> None:
    """Sections and bores are counted from 1, as in what is said of them."""
    text, words = WRONG_FILES[number]
    path = tmp_path / "string.toml"
    path.write_text(text)
    with pytest.raises(ValueError) as caught:  # noqa: PT011  (its text is what is tested)
        fr.Rod.from_toml(path)
    message = str(caught.value)
    assert message.startswith(f"rod file {path}: ")
    assert all(word in message for word in words), message
    assert "\n" not in message


def written(text: str, folder: Path) -> str:
    """Return the path of a file with a text."""
    path = folder / "string.toml"
    path.write_text(text)
    return str(path)


def test_a_file_gives_the_rod_that_its_arguments_give(tmp_path: Path) -> None:
    rod = fr.Rod.from_toml(written(FILE, tmp_path))
    assert rod == STRING
    assert rod.given_units == STRING.given_units
    assert (rod.given_units.length, rod.given_units.across, rod.given_units.density) == ("m", "in", "ppg")


def test_a_file_of_one_section_gives_a_uniform_rod(tmp_path: Path) -> None:
    text = f'bore = "5in"\nlength = "30m"\ncatalogue = "{TUBING}"\n'
    of_catalogue = fr.Rod.from_toml(written(text, tmp_path))
    text = f'channel_diameter = "5in"\n[[sections]]\nname = "{TUBING}"\nlength = "30m"\n'
    assert fr.Rod.from_toml(written(text, tmp_path)) == of_catalogue


def test_a_study_file_has_a_string_in_its_table(tmp_path: Path) -> None:
    table = FILE.replace("[[sections]]", "[[rod.sections]]")
    load = 'load = {mean = "7kN", amplitude = "3kN", frequency = "2.55Hz"}\n'
    study = f'{load}over = {{kick = ["1mm/s", "2mm/s"]}}\nrun = {{duration = "1ms", segments = 200}}\n[rod]\n{table}'
    path = written(study, tmp_path)
    assert fr.Study.from_toml(path).problem.rod == STRING
    wrong = written(study.replace('length = "25m"', 'lenght = "25m"'), tmp_path)
    with pytest.raises(ValueError, match=r"\[rod\] section 2: unknown key 'lenght'; did you mean length"):
        fr.Study.from_toml(wrong)


@pytest.mark.parametrize(
    "made",
    [
        lambda rod: pickle.loads(pickle.dumps(rod)),
        copy.copy,
        copy.deepcopy,
        lambda rod: rod.replace(),
        lambda rod: rod.replace(damping_rate=0.1).replace(damping_rate=rod.damping_rate),
        lambda rod: fr.Rod(**rod.as_dict()),
        lambda rod: fr.Rod(**json.loads(json.dumps(rod.as_dict()))),
        lambda rod: eval(repr(rod), {"Rod": fr.Rod}),
    ],
)
def test_a_string_comes_back_as_it_was(made: Callable[[fr.Rod], fr.Rod]) -> None:
    other = made(STRING)
    assert other == STRING
    assert hash(other) == hash(STRING)
    assert repr(other) == repr(STRING)
    assert [section.name for section in other.sections] == [TUBING, THICK, ""]
    assert other.uniform_parts == STRING.uniform_parts


lengths = st.floats(0.5, 3000.0)
drawn_sections = st.lists(
    st.one_of(
        st.tuples(st.sampled_from([TUBING, THICK]), lengths).map(lambda each: {"name": each[0], "length": each[1]}),
        st.tuples(st.floats(0.02, 0.1), st.floats(0.0, 0.9), lengths).map(
            lambda each: {"diameter": each[0], "inner_diameter": each[0] * each[1], "length": each[2]}
        ),
    ),
    min_size=1,
    max_size=5,
)
drawn_bores = st.lists(st.tuples(st.floats(1.0, 5000.0), st.floats(0.11, 0.3)), max_size=3).map(
    lambda bores: [(0.0, 0.12), *({each[0]: each for each in sorted(bores)}.values())]
)


@pytest.mark.slow
@given(drawn_sections, drawn_bores)
@settings(max_examples=depth(300, 30))
def test_a_drawn_string_is_the_same_by_file_and_by_arguments(sections: list[dict[str, Any]], bores: list[Any]) -> None:
    lines = [f"bores = {json.dumps(bores)}"]
    for section in sections:
        lines += ["[[sections]]", *(f"{key} = {json.dumps(value)}" for key, value in section.items())]
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", fr.PlausibilityWarning)
        rod = fr.Rod.from_toml(written("\n".join(lines), Path(folder)))
        assert rod == fr.Rod(sections=[fr.Section(**section) for section in sections], bores=bores)
        assert rod == fr.Rod(**json.loads(json.dumps(rod.as_dict())))
    assert rod.length == pytest.approx(sum(section["length"] for section in sections), rel=1e-12)
    assert [part.end for part in rod.uniform_parts][-1] == rod.length


# --- numbers that are probably in another unit ---


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            '"25m"',
            "25",
            "section 2: length 25 is taken in m, and section 1: length '100ft' has a unit; write 25m or 25ft",
        ),
        ('"150ft"', "45", "bore 2: depth 45 is taken in m, .* write 45m or 45ft"),
        ('"6.184in"', "0.157", ""),  # plausible in metres alone
    ],
)
def test_numbers_without_a_unit(old: str, new: str, words: str, tmp_path: Path) -> None:
    in_feet = FILE.replace('"30m"', '"100ft"').replace('"5m"', '"16ft"').replace('"45m"', '"150ft"')
    assert old in in_feet
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fr.Rod.from_toml(written(in_feet.replace(old, new), tmp_path))
    said = [str(each.message) for each in caught]
    assert len(said) == bool(words)
    assert not words or re.search(words, said[0])


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"radius": 25.4, "length": 3.0}, "section 2: radius = 25.4 m .* millimetres"),
        ({"radius": 0.02, "length": 3.0, "youngs_modulus": 207.0}, "section 2: youngs_modulus = 207 Pa .* GPa"),
        ({"radius": 0.02, "length": 3.0, "yield_strength": 620.0}, "section 2: yield_strength = 620 Pa .* MPa"),
        ({"radius": 0.0508, "wall_thickness": 3.9624e-3, "length": 3.0}, r"section 2: radius .* name='2.00x0.156'"),
    ],
)
def test_a_section_that_is_implausible_is_named(section: dict[str, Any], words: str) -> None:
    wide = 60.0 if section["radius"] > 1.0 else 0.1214
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fr.Rod(sections=[SECTIONS[0], section], channel_diameter=wide)
    assert any(re.search(words, str(each.message)) for each in caught), [str(each.message) for each in caught]


# --- in the terminal ---


@pytest.mark.parametrize(("name", "value"), [("--length", "50m"), ("--weight", "4lb/ft"), ("--bore", "5in")])
def test_options_of_a_uniform_rod_are_refused(
    name: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(FILE, tmp_path)
    assert main(["check", "--rod", path, *PUSH, name, value]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert f"{name} must not be given for a rod of several" in said[0]
    assert repr(value) in said[0]
    assert said[0].endswith(f"change it in {path}")


def test_the_bore_of_a_string_in_one_bore_may_be_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(replaced('bores = [["0m", "4.778in"], ["45m", "6.184in"]]', 'channel_diameter = "5in"'), tmp_path)
    question = ["check", "--rod", path, *PUSH, "--no-margins"]
    assert main([*question, "--bore", "4.778in"]) == 0
    narrow = capsys.readouterr().out
    assert "in a 4.778 in bore" in narrow
    assert main(question) == 0
    assert capsys.readouterr().out != narrow


def test_check_says_what_the_string_is_and_where_it_grows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "--rod", written(FILE, tmp_path), *PUSH, "--no-margins", "--assumptions"]) == 0
    text = capsys.readouterr().out
    assert (
        "string of 3 sections, 60 m: 2.00x0.156 CT90 30 m, 2.00x0.203 CT90 25 m, 2.875 in pipe of 0.9375 in wall 5 m, "
        "in bores of 4.778 in, 6.184 in from 45 m on"
    ) in text
    assert "most in section 1, 2.00x0.156 CT90, in the 4.778 in bore, at 4" in text
    assert "of the yield strength 621 MPa, in section 1" in text
    assert "one damping rate for all" in text
    assert "(E I / w)^(1/4)" in text


# --- what varies, and what is passed on ---


@pytest.mark.parametrize(
    ("name", "table"), [("density", "sections"), ("length", "sections"), ("channel_radius", "bores")]
)
def test_what_a_section_has_for_itself_does_not_vary(name: str, table: str) -> None:
    well = fr.WellPath([0.0, 1000.0], ["0deg", "80deg"])
    varied = {name: (0.9 * getattr(STRING, name), getattr(STRING, name))}
    words = rf"parameters must not name {name} of a rod of several {table}, each of which has its own"
    with pytest.raises(ValueError, match=words):
        fr.probability_of_instability(STRING, fr.AxialLoad(6e3, 3e3, 22.0), varied, samples=10)
    if name != "length":  # which is no parameter of a string in a well
        with pytest.raises(ValueError, match=words):
            fr.probability_of_reach(STRING, well, 0.2, varied, samples=10)


def test_what_the_whole_string_has_varies() -> None:
    load = fr.AxialLoad(6e3, 3e3, 22.0)
    found = fr.probability_of_instability(STRING, load, {"damping_rate": (0.0, 3.0)}, samples=12, seed=1)
    assert 0.0 < found.probability < 1.0


@pytest.mark.slow
def test_one_file_about_a_string_has_its_sections(tmp_path: Path) -> None:
    verdict = STRING.stability(fr.AxialLoad("7.1kN", "3.84kN", "2.55Hz"))
    text = fr.save_report(verdict, tmp_path / "string.html", margins=False).read_text(encoding="utf-8")
    assert text.count(f"<td>{THICK}</td>") == 2  # in two bores
    assert "string of 3 sections, 60 m" in text
    assert "most in section 1, 2.00x0.156 CT90" in text
    assert "left out" in text
    numbers = json.loads(json.dumps(verdict.as_dict()))
    assert [part["section"] for part in numbers["parts"]] == [1, 2, 2, 3]
    assert numbers["grows_most_at_m"] == verdict.shape.position
    assert numbers["stress"]["section"] == 1


def test_the_section_nearest_to_its_yield_strength_is_named() -> None:
    """Which is not the one of the largest stress."""
    load = fr.AxialLoad(0.3, 0.0, 10.0)
    thick = fr.Section(diameter="2mm", length=1.0, yield_strength="10MPa")
    thin = fr.Section(diameter="1mm", length=1.0, yield_strength="500MPa")
    rod = fr.Rod(sections=[thick, thin], channel_diameter="20mm")
    found = rod.stress(load)
    every = [part.rod.stress(load) for part in rod.uniform_parts]
    assert (found.section, found.largest, found.share_of_yield) == (1, every[0].largest, every[0].share_of_yield)
    assert every[1].largest > found.largest
    unknown = fr.Rod(sections=[thick.as_dict() | {"yield_strength": None}, thin], channel_diameter="20mm")
    assert unknown.stress(load).section == 2
