"""Pipes of the catalogue, as rods and in rod files; what rod files refuse."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

import floquetrod as fr
from floquetrod.cli.main import main
from tests.inside import CataloguePipe, pipe, pipes, read_rod, weight_in_air

ROOT = Path(__file__).parents[3]
INCH = 0.0254
KSI = 6894757.293168
WELL: dict[str, Any] = {"bore": "4.778in", "length": 60.0}

# The table of sizes in wells: name, hole in inches; w_e N/m, EI kN m^2, R mm, F_p kN, half wave m, in water.
WELLS = [
    ("1.25 x .109", 4.000, 16.9, 5.5, 34.9, 3.27, 5.8),
    ("1.50 x .125", 4.892, 23.4, 11.1, 43.1, 4.91, 6.7),
    ("1.75 x .134", 4.892, 29.5, 19.3, 39.9, 7.54, 7.1),
    ("2.00 x .156", 4.778, 39.2, 33.3, 35.3, 12.2, 7.4),
    ("2.375 x .190", 4.778, 56.5, 67.6, 30.5, 22.4, 7.7),
    ("2.375 x .175", 4.778, 52.4, 63.4, 30.5, 20.9, 7.7),
    ("2.875 x .204", 6.184, 74.2, 132.0, 42.0, 30.6, 9.2),
    ("5.0 x .362", 8.500, 229.0, 1228.0, 44.4, 159.0, 12.4),
]


@pytest.mark.parametrize(("name", "hole", "weight", "rigidity", "clearance", "force", "half_wave"), WELLS)
def test_wells_of_the_trade(
    name: str, hole: float, weight: float, rigidity: float, clearance: float, force: float, half_wave: float
) -> None:
    rod = fr.Rod.catalogue(name, bore=f"{hole}in", length=100.0, fluid_inside=1000.0, fluid_outside=1000.0)
    assert rod.weight_per_length == pytest.approx(weight, rel=0.01)
    assert rod.flexural_rigidity == pytest.approx(1e3 * rigidity, rel=0.01)
    assert rod.radial_clearance == pytest.approx(1e-3 * clearance, rel=0.01)
    assert rod.critical_force == pytest.approx(1e3 * force, rel=0.01)
    assert rod.critical_half_wave == pytest.approx(half_wave, rel=0.01)


# --- names ---


@pytest.mark.parametrize("product", ["coiled tubing", "drill pipe", "tubing", "sucker rod"])
def test_every_pipe_is_found_by_its_name_and_grades(product: str) -> None:
    for found in (row for row in pipes() if row.product == product):
        check_pipe(found)


def check_pipe(found: CataloguePipe) -> None:
    plain = pipe(found.name)
    assert plain[2:4] == found[2:4]
    assert plain == found or plain.product == "coiled tubing" or plain.product == "drill pipe"
    assert re.fullmatch(r"API Spec (5ST|5DP|5CT|11B)", found.source)
    assert 0.0 <= 2.0 * found.wall_thickness < found.diameter
    assert found.grade == ""
    assert found.yield_strength is None
    for grade in found.grades:
        graded = pipe(f"{found.name} {grade}")
        assert graded.grade == grade
        ksi = {"K": 60.0, "C": 60.0, "D": 85.0, "KD": 85.0, "HL": 115.0}.get(grade) or float(re.sub(r"\D", "", grade))
        assert graded.yield_strength == pytest.approx(ksi * KSI, rel=1e-15)
        assert graded._replace(grade="", yield_strength=None) == found
    rod = fr.Rod.catalogue(found.name, bore=0.3, length=10.0)
    assert (2.0 * rod.radius, rod.youngs_modulus) == (found.diameter, 207e9)
    if found.product == "sucker rod":
        assert (rod.inner_radius, rod.mass_along) == (0.0, pytest.approx(weight_in_air(found) / 9.80665, rel=1e-14))
        assert 1.05 < rod.density / 7850.0 < 1.12  # couplings
        return
    assert rod.density == 7850.0
    assert rod.inner_radius == pytest.approx(0.5 * found.diameter - found.wall_thickness, rel=1e-14)
    assert rod.mass_along == pytest.approx(weight_in_air(found) / 9.80665, rel=1e-13)


def test_no_two_pipes_are_alike() -> None:
    assert len({(found.name, found.product) for found in pipes()}) == len(pipes())
    for found in pipes():  # where a size is of several products, their grades differ
        others = [other.grades for other in pipes() if other.name == found.name and other != found]
        assert all(not {*found.grades} & {*grades} for grades in others)


# Maker's and standard's tables: plain-end weight in lb/ft, of coiled tubing and of API 5CT.
WEIGHTS = [
    ("1.25x0.109", 1.330),
    ("2.00x0.125", 2.506),
    ("2.00x0.224", 4.253),
    ("2.375x0.190", 4.438),
    ("2.875x0.217", 6.166),
    ("3.50x0.254", 8.814),
    ("4.50x0.271", 12.252),
]


@pytest.mark.parametrize(("name", "pounds"), WEIGHTS)
def test_weights_are_those_of_the_tables(name: str, pounds: float) -> None:
    assert weight_in_air(pipe(name)) * 0.3048 / 4.4482216152605 == pytest.approx(pounds, rel=2e-3)


def test_coiled_tubing_of_two_inches_has_the_walls_and_grades_that_makers_list() -> None:
    walls = {row.name.partition("x")[2] for row in pipes() if row.product == "coiled tubing" and row.diameter == 0.0508}
    assert {"0.125", "0.134", "0.145", "0.156", "0.175", "0.188", "0.190", "0.204", "0.224"} <= walls
    for ksi in (70, 80, 90, 100, 110, 120, 130):
        assert pipe(f"2.00x0.204 CT{ksi}").yield_strength == pytest.approx(ksi * KSI)


def test_the_grade_tells_which_product_of_a_size_is_meant() -> None:
    assert [pipe(f"2.375x0.190 {grade}").product for grade in ("CT80", "L80")] == ["coiled tubing", "tubing"]
    assert [pipe(f"3.50x0.254 {grade}").product for grade in ("E75", "J55")] == ["drill pipe", "tubing"]


def test_the_catalogue_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["catalogue"]) == 0
    text = capsys.readouterr().out
    assert all(row.name.partition("x")[0] in text and row.name.partition("x")[2] in text for row in pipes())
    assert main(["catalogue", "2.00", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in listed["pipes"]] == [row.name for row in pipes() if row.name.startswith("2.00")]
    assert listed["yield_strength_Pa"]["CT90"] == pytest.approx(90.0 * KSI)
    assert main(["catalogue", "9"]) == 2
    assert "SIZE must begin the name of a pipe or a rod, got '9'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("2.00x0.156 CT90", "2.00x0.156 CT90"),
        ("2x.156ct90", "2.00x0.156 CT90"),
        ("2. X 0.1560 ct-90 ", "2.00x0.156 CT90"),
        ("2.00 in x 0.156 in CT 90", "2.00x0.156 CT90"),
        ('2.000"\u00d7.156"', "2.00x0.156 "),
        ("2-7/8x0.204", "2.875x0.204 "),
        ("2 7/8 in. x .362 s-135", "2.875x0.362 S135"),
        ("9/2 inches x 0.271 inch E75", "4.50x0.271 E75"),
        ("3/4 rod D", "3/4 rod D"),
        ('0.75" sucker-rod kd', "3/4 rod KD"),
        ("1-1/8 in. sucker rods", "1-1/8 rod "),
    ],
)
def test_names_are_read_as_people_write_them(name: str, expected: str) -> None:
    found = pipe(name)
    assert f"{found.name} {found.grade}" == expected


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        (None, TypeError, "name must be the size of a pipe such as '2.00x0.156 CT90', got None"),
        (2.0, TypeError, "name must be the size of a pipe"),
        ("", ValueError, "name must be an outer diameter and a wall thickness .*; floquetrod catalogue lists them"),
        ("2.00", ValueError, "name must be an outer diameter and a wall thickness"),
        ("2.00x0.156 steel", ValueError, "name must be an outer diameter and a wall thickness"),
        ("50.8mm x 3.96mm", ValueError, "name must be an outer diameter and a wall thickness in inches"),
        ("2-1/0x0.156", ValueError, "name must be an outer diameter and a wall thickness"),
        ("9" * 9999 + "x0.1", ValueError, "name must be an outer diameter .*, got '9{70,76}\\.\\.\\.;"),
        ("2.00x0.160", ValueError, "got '2.00x0.160'; the closest are 2.00x0.156, .*; for another size write diameter"),
        ("2.002x0.156", ValueError, "the closest are 2.00x0.156"),
        (
            "2.00x0.156 CT95",
            ValueError,
            r"name must end in a grade of .*\(CT70, CT80, .*, CT130\) or in none",
        ),
        ("2.00x0.156 S135", ValueError, "name must end in a grade of 2.00x0.156 coiled tubing"),
        ("4.5x.271 S135", ValueError, r"name must end in a grade of 4.50x0.271 drill pipe \(E75\)"),
    ],
)
def test_other_names_are_refused_with_the_closest(name: Any, error: type[Exception], message: str) -> None:
    for call in (lambda: pipe(name), lambda: fr.Rod.catalogue(name, **WELL)):
        with pytest.raises(error, match=f"^{message}" if message.startswith("name") else message):
            call()


# --- rods ---


def test_a_pipe_is_the_rod_of_its_sizes() -> None:
    sizes = {"diameter": 2.0 * INCH, "wall_thickness": 0.156 * INCH, "channel_diameter": 4.778 * INCH}
    expected = fr.Rod(207e9, 7850.0, length=60.96, **sizes, inclination=math.radians(60.0), damping_rate=0.1)
    expected = expected.replace(yield_strength=90.0 * KSI)
    changes: dict[str, Any] = {"inclination": "60deg", "damping_rate": 0.1}
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="200 ft", **changes)
    assert rod.as_dict() == pytest.approx(expected.as_dict(), rel=1e-14)
    assert type(rod) is fr.Rod
    plain = fr.Rod.catalogue("2.00x0.156", bore=4.778 * INCH, length="200 ft", **changes)
    assert plain == rod.replace(yield_strength=None)  # all that the grade tells


def test_changes_replace_what_the_catalogue_says() -> None:
    rod = fr.Rod.catalogue("2.00x0.156", **WELL)
    assert fr.Rod.catalogue("2.00x0.156", **WELL, density=8000.0) == rod.replace(density=8000.0)
    assert fr.Rod.catalogue("2.00x0.156", **WELL, youngs_modulus="30Mpsi").youngs_modulus == 30e3 * KSI
    assert fr.Rod.catalogue("2.00x0.156", **WELL, inner_radius=0.0) == rod.replace(inner_radius=0.0)
    assert fr.Rod.catalogue("2.00x0.156", **WELL, inner_diameter=0.04).inner_radius == 0.02
    worn = fr.Rod.catalogue("2.00x0.156", **WELL, wall_thickness="0.14in")
    assert worn.inner_radius == pytest.approx(0.86 * INCH, rel=1e-14)
    wide = fr.Rod.catalogue("2.00x0.156", **WELL, radius=0.03)
    assert (wide.radius, wide.inner_radius) == (0.03, pytest.approx(0.03 - 0.156 * INCH, rel=1e-14))


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"bore": 0.0}, ValueError, "^bore must be greater than zero"),
        ({"bore": None}, TypeError, "^bore must be a single real number"),
        ({"bore": "4.778 parsec"}, ValueError, "^bore must be a number with a length unit"),
        ({"bore": "2in"}, ValueError, "^bore must exceed the outer diameter of the pipe, got 0.0508 m for 0.0508 m"),
        ({"length": "200 lbf"}, ValueError, "^length must be a number with a length unit"),
        ({"length": -1.0}, ValueError, "^length must be greater than zero"),
        ({"channel_radius": 0.06}, ValueError, "^channel_radius must not be given with bore, got 0.06"),
        ({"channel_diameter": "4in"}, ValueError, "^channel_diameter must not be given with bore, got '4in'"),
        ({"radius": 0.07}, ValueError, "^channel_radius must exceed the rod's radius"),
        ({"radius": 0.03, "diameter": 0.06}, ValueError, "^diameter must not be given with radius"),
        ({"fluid_outside": "1 kg"}, ValueError, "^fluid_outside must be a number with a density unit"),
        ({"colour": "red"}, TypeError, "colour"),
    ],
)
def test_bad_wells(change: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.Rod.catalogue("2.00x0.156", **{**WELL, **change})


# --- rod files ---


def test_the_example_of_a_well() -> None:
    rod = fr.Rod.from_toml(ROOT / "floquetrod/examples/well.toml")
    fluids: dict[str, Any] = {"fluid_inside": "8.6ppg", "fluid_outside": "8.6ppg"}
    assert rod == fr.Rod.catalogue("2x.156 CT90", bore="4.778in", length="200ft", inclination="60deg", **fluids)


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_keys_replace_what_the_catalogue_says(tmp_path: Path) -> None:
    text = 'catalogue = "2x.156"\nbore = 0.12\nlength = 60\nwall_thickness = "4mm"\ndensity = "8 g/cm3"\n'
    found = fr.Rod.from_toml(written(tmp_path, text))
    assert found == fr.Rod.catalogue("2x.156", bore=0.12, length=60.0, wall_thickness=0.004, density=8000.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('catalogue = "2x.16"\nbore = 0.12\nlength = 60', "name must be the size .* the closest are 2.00x0.156"),
        ("catalogue = 2\nbore = 0.12\nlength = 60", "name must be the size of a pipe"),
        ('catalogue = "2x.156"\nlength = 60', "missing key 'bore'; the keys are catalogue, bore, youngs_modulus, "),
        ('catalogue = "2x.156"', "missing key 'bore', missing key 'length'; "),
        ('catalogue = "2x.156"\nbore = 0.12\nlength = 60\nchannel_radius = 0.06', "bore is the key for the hole"),
        ('catalogue = "2x.156"\nbore = "12 kg"\nlength = 60', "bore must be a number with a length unit"),
        ('catalogue = "2x.156"\nbore = 0.12\nlength = 60\ninclinaton = 1', "unknown key 'inclinaton'; did you mean"),
        (
            "bore = 0.12\nlength = 60",
            "unknown key 'bore'; a hole of one bore has channel_diameter, one that changes bores; a catalogue pipe",
        ),
        ("radis = 0.12\nlength = 60", "unknown key 'radis'; did you mean radius?"),
        ("fluid_insde = 0.12", "unknown key 'fluid_insde'; did you mean fluid_inside?"),
        ("length = 60", "missing key 'youngs_modulus', missing key 'density', missing key 'radius', missing key 'chan"),
        ("length = " + 5000 * "[", "cannot be read"),
        ("length = 60 #" + (1 << 20) * "x", "cannot be read: it has more than 1,048,576 bytes"),
    ],
)
def test_bad_files(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ValueError, match=rf"^rod file .*rod\.toml:? .*{message}"):
        fr.Rod.from_toml(written(tmp_path, text))


def test_folders_and_other_encodings_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(b"# \xe9")
    for path in (tmp_path, tmp_path / "latin.toml", tmp_path / "none.toml"):
        with pytest.raises(ValueError, match=r"^rod file .* cannot be read: "):
            fr.Rod.from_toml(path)


def test_a_key_may_hold_a_word(tmp_path: Path) -> None:
    sheet = 'youngs_modulus = "207GPa"\ndensity = 7850\nradius = "25mm"\nchannel_radius = "60mm"\n'
    rod = read_rod(written(tmp_path, f'{sheet}length = "2ft"\nends = "clamped"'), fr.Rod)
    assert (rod.length, rod.ends) == (0.6096, "clamped")
    pipe = read_rod(written(tmp_path, 'catalogue = "2.00x0.156"\nbore = 2\nlength = 3\nends = "free"'), fr.Rod)
    assert (pipe.channel_radius, pipe.length, pipe.ends) == (1.0, 3.0, "free")
