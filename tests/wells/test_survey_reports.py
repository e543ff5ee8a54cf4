"""Surveys as reports, logs and sheets: each kind of file is read as the same well, or refused in one line."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.cli.main import main
from tests.inside import SURVEY_KEYS

FILES = Path(__file__).parents[1] / "data" / "surveys"
WELL = fr.WellPath([0.0, 500.0, 800.0, 1400.0], ["0deg", "0.4deg", "24deg", "88deg"], np.radians([40, 40, 42, 47]))
NOTES = {
    "dashes.txt": "line 11, 'End of survey', is no station: the table ends above it",
    "repeated.csv": "station 4 (line 5, 800 m) left out: the same as the one above",
    "td_line.tsv": "line 7, 'TD at 1400 m', is no station: the table ends above it",
    "pages.txt": "line 4, 'Page 2 of 2', and the headings below it are left out: the table goes on below them",
}


@pytest.mark.parametrize("path", [path for path in sorted(FILES.iterdir()) if path.name != "trace.txt"], ids=str)
@pytest.mark.filterwarnings("ignore:.*is left out, its:floquetrod.PlausibilityWarning")
def test_each_kind_of_file_is_read_as_the_same_well(path: Path) -> None:
    well = fr.WellPath.from_csv(path)
    np.testing.assert_allclose(well.depth, WELL.depth, rtol=1e-15)
    np.testing.assert_allclose(well.inclination, WELL.inclination, rtol=1e-15)
    np.testing.assert_allclose(well.azimuth, WELL.azimuth, rtol=1e-15)
    if path.name in NOTES:
        assert well.note == NOTES[path.name]


def test_lost_values_are_told_by_station() -> None:
    with pytest.warns(fr.PlausibilityWarning) as caught:
        fr.WellPath.from_csv(FILES / "lost.csv")
    said = [str(each.message) for each in caught]
    assert any(
        "line 4: station 3 at 650 m is left out, its inclination ('---') and azimuth ('N/A')" in text for text in said
    )
    assert any(
        "line 5: station 4 at 700 m is left out, its inclination ('-999.25') is missing" in text for text in said
    )


def test_of_two_azimuths_one_is_chosen_in_python_and_in_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="2 of them say azimuth: 'AZIM_TN', 'AZIM_GN'; choose one by azimuth"):
        fr.WellPath.from_csv(FILES / "trace.txt", depth_unit="m")
    chosen = fr.WellPath.from_csv(FILES / "trace.txt", azimuth="AZIM_GN", depth_unit="m")
    np.testing.assert_allclose(chosen.azimuth, WELL.azimuth, rtol=1e-15)
    line = ["check", "--rod", "nitinol", "--mean", "0.3N", "--amplitude", "0.2N", "--frequency", "24Hz", "--no-margins"]
    survey = ["--path", str(FILES / "trace.txt"), "--depth-unit", "m"]
    assert main([*line, *survey]) == 2
    assert "choose one by --survey-columns ,,AZIMUTH" in capsys.readouterr().err
    assert main([*line, *survey, "--survey-columns", ",,AZIM_XX"]) == 2
    assert "azimuth must be a heading of one column, got 'AZIM_XX'" in capsys.readouterr().err


def test_a_rod_file_names_the_columns_of_its_survey(tmp_path: Path) -> None:
    (tmp_path / "trace.txt").write_bytes((FILES / "trace.txt").read_bytes())
    rod = tmp_path / "rod.toml"
    sizes = 'youngs_modulus = "70GPa"\ndensity = 6450.0\ndiameter = "0.8mm"\nchannel_diameter = "8mm"\nlength = "3m"\n'
    path = 'path = {file = "trace.txt", azimuth = "AZIM_GN", depth_unit = "m", to = "1500m"}\n'
    rod.write_text(sizes + 'depth = "600m"\n' + path, encoding="utf-8")
    expected = fr.WellPath.from_csv(FILES / "trace.txt", azimuth="AZIM_GN", depth_unit="m", to=1500.0)
    assert fr.Rod.from_toml(rod).path == expected
    assert expected.end == 1500.0
    rod.write_text(sizes + path.replace("azimuth", "azimut"), encoding="utf-8")
    with pytest.raises(ValueError, match="unknown key 'azimut'; did you mean azimuth"):
        fr.Rod.from_toml(rod)


STUDY = """[rod]
youngs_modulus = "70GPa"
density = 6450.0
diameter = "0.8mm"
channel_diameter = "8mm"
length = "3m"
depth = "600m"
path = {{file = "survey.txt", {}}}
[load]
mean = "0.1N"
amplitude = "0.05N"
frequency = "24Hz"
[run]
duration = "1ms"
segments = 40
[over]
seed = [1, 2]
"""
KEYS = {
    "depth": "Along",
    "inclination": 2,
    "azimuth": "AZIM_GN",
    "depth_unit": "m",
    "angle_unit": "deg",
    "delimiter": "!",
    "to": "1500m",
}


def test_a_study_file_names_every_way_in_which_its_survey_is_read(tmp_path: Path) -> None:
    rows = zip(WELL.depth.tolist(), np.degrees(WELL.inclination).tolist(), np.degrees(WELL.azimuth), strict=True)
    text = "Along!AZIM_TN!Tilt!AZIM_GN\n" + "".join(f"{d}!0!{i!r}!{a}\n" for d, i, a in rows)
    (tmp_path / "survey.txt").write_text(text, encoding="utf-8")
    assert {*KEYS, "sheet"} == {*SURVEY_KEYS}
    given = ", ".join(f"{key} = {value!r}" for key, value in KEYS.items())
    study = tmp_path / "study.toml"
    study.write_text(STUDY.format(given), encoding="utf-8")
    path = fr.Study.from_toml(study).problem.rod.path
    assert path is not None
    assert path == fr.WellPath.from_csv(tmp_path / "survey.txt", **KEYS)
    np.testing.assert_allclose(path.azimuth[:-1], WELL.azimuth, rtol=1e-14)
    assert path.end == 1500.0
    for wrong, words in (
        ('sheet = "Surveys"', "sheet is for workbooks"),
        ('survey_columns = "1,2,3"', "unknown key 'survey_columns'"),
        ('to = "1200m"', "to must lie below the last station at 1400 m, got 1200 m"),
        ('depth_unit = "kg"', "depth_unit must be"),
    ):
        name = wrong.split()[0]
        kept = ", ".join(part for part in given.split(", ") if not part.startswith(f"{name} "))
        study.write_text(STUDY.format(f"{kept}, {wrong}"), encoding="utf-8")
        with pytest.raises(ValueError, match=rf"study file .*study.toml: \[rod\] .*{words}"):
            fr.Study.from_toml(study)


def test_messages_are_in_the_units_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    for rows, words in (
        (
            "0,0,30\n2000,190,30\n",
            "line 3: inclination at station 2 must lie between 0, .*, and 180 deg, .*got 190 deg",
        ),
        ("0,0,30\n2000,1,30\n1990,2,30\n", "depth at station 3 must increase .*got 1990 ft after 2000 ft"),
        (
            "-25,0,30\n2000,1,30\n",
            "depth at station 1 must lie between 0 and .* ft, got -25 ft; it lies above the datum",
        ),
    ):
        path.write_text(f"MD (ft),Inc (deg),Azi (deg)\n{rows}", encoding="utf-8")
        with pytest.raises(ValueError, match=words) as caught:
            fr.WellPath.from_csv(path)
        assert "numpy" not in str(caught.value)
    path.write_text("MD (ft),Inc (deg),Azi (deg)\n0,0,30\n2000,0,30\n2020,40,31\n4000,60,33\n", encoding="utf-8")
    with pytest.warns(fr.PlausibilityWarning, match="dogleg of 200 deg/100 ft between 2000 and 2020 ft"):
        well = fr.WellPath.from_csv(path)
    assert "doglegs up to 200 deg/100 ft between 2000 and 2020 ft" in repr(well)


def test_a_well_says_where_it_begins_and_to_which_depth_it_is_projected() -> None:
    well = WELL.part(76.3, 1400.0)
    assert ("start", "the string begins at 76.3 m, the first station") in well.report().lines
    longer = well.projected("1450m")
    assert (longer.end, longer.inclination[-1]) == (1450.0, well.inclination[-1])
    np.testing.assert_allclose(longer.position(1400.0), well.position(1400.0), rtol=1e-14)
    with pytest.raises(ValueError, match="to must lie below the last station at 1400 m, got 1300 m"):
        well.projected(1300.0)


def test_a_depth_far_below_a_survey_is_doubted() -> None:
    """As one in metres is below a survey in feet."""
    well = WELL.part(0.0, 1400.0)
    well.projected(1530.0)
    with pytest.warns(fr.PlausibilityWarning, match=r"^to = 4593 m is 3193 m straight on below .* station, 228 % of"):
        assert well.projected(4593.0).end == 4593.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "MD (m),Inc,Azi\n0,0,30\n600,0.0.1,30\n900,30,35\n",
            "line 3, station 2: inclination must be a number, got '0.0.1'",
        ),
        (
            "Well,MD (m),Inc,Azi\nA-1,0,0,0\nA-1,500,0,0\nA-2,600,0,0\n",
            "line 4: column 'Well' goes from 'A-1' to 'A-2'",
        ),
        ("north,east,tvd\n0,0,0\n0,0,600\n10,10,900\n", "depth is in no column of line 1, which has positions alone"),
        (
            "MD (m),Inc,Azi\n0,0,0\n600,0,0\nWell 2\n900,0,0\n",
            "line 4, station 3: depth must be a number, got 'Well 2'",
        ),
        ('{"md": [0, 1], "inc": [0, 1]}\n', "it is JSON"),
    ],
)
def test_what_cannot_be_decided_is_refused(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "survey.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        fr.WellPath.from_csv(tmp_path / "survey.csv")


@st.composite
def wells(draw: st.DrawFn) -> fr.WellPath:
    """Draw a well of stations with two decimals that builds from the vertical."""
    steps = draw(st.lists(st.tuples(st.integers(2000, 6000), st.integers(0, 500), st.integers(-300, 300)), min_size=3))
    rows = np.cumsum([(0, 0, 4500), (draw(st.integers(30000, 90000)), 0, 0), *steps[:12]], axis=0) / 100.0
    return fr.WellPath(rows[:, 0], np.radians(np.minimum(rows[:, 1], 95.0)), np.radians(rows[:, 2] % 360.0))


def rows_of(well: fr.WellPath, mark: str, decimal: str) -> str:
    columns = (well.depth, np.degrees(well.inclination), np.degrees(well.azimuth))
    return "\n".join(
        mark.join(f"{number:.2f}".replace(".", decimal) for number in row) for row in zip(*columns, strict=True)
    )


@given(well=wells(), mark=st.sampled_from([",", ";", "\t", " ", "|"]), comma=st.booleans(), quoted=st.booleans())
@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
def test_a_well_written_in_each_format_reads_back(
    well: fr.WellPath, mark: str, comma: bool, quoted: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "drawn.csv"
    lines = [
        mark.join(["MD(m)", "Inc(deg)", "Azi(deg)"]),
        *rows_of(well, mark, "," if comma and mark != "," else ".").split("\n"),
    ]
    if quoted and mark != " ":
        lines = [f'"{line}"' for line in lines]
    path.write_text("\n".join(["Company: X", *lines, "TD"] if not quoted else lines), encoding="utf-8")
    read = fr.WellPath.from_csv(path)
    np.testing.assert_allclose(read.depth, well.depth, rtol=1e-14)
    np.testing.assert_allclose(np.degrees(read.inclination), np.degrees(well.inclination), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(np.degrees(read.azimuth), np.degrees(well.azimuth), rtol=0.0, atol=1e-9)


@given(well=wells(), digits=st.sampled_from([3, 6]), up=st.booleans())
def test_a_well_written_by_positions_reads_back(
    well: fr.WellPath, digits: int, up: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """To rounding of its positions, the bend between stations less than that of half an interval."""
    path = tmp_path_factory.getbasetemp() / "drawn.dev"
    north, east, down = well.position(well.depth).T
    table = zip(east + 5e5, north + 6.5e6, 25.0 - down if up else down, well.depth, strict=True)
    rows = "\n".join(" ".join(f"{number:.{digits}f}" for number in row) for row in table)
    path.write_text(f"WELLTRACK 'A-1'\n{rows} /\n" if False else f"name A-1\n{rows}\n", encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fr.PlausibilityWarning)
        read = fr.WellPath.from_csv(path, depth_unit="m")
    assert np.linalg.norm(read.position(read.depth) - well.position(well.depth), axis=1).max() < 1e-3 * well.length
    direction = [
        np.stack(
            [
                np.sin(w.inclination) * np.cos(w.azimuth),
                np.sin(w.inclination) * np.sin(w.azimuth),
                np.cos(w.inclination),
            ]
        )
        for w in (read, well)
    ]
    miss = np.degrees(np.arccos(np.clip((direction[0] * direction[1]).sum(axis=0), -1.0, 1.0)))
    assert miss.max() < max(0.5, 0.5 * float(np.degrees(well.arcs.dogleg.max())))
    assert math.isclose(read.end, well.end)
