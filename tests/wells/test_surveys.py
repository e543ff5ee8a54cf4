"""Surveys in files: headings, units and marks as the trade writes them, and what is refused by line and station."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr

EXPECTED = fr.WellPath([0.0, 304.8, 609.6], np.radians([0.0, 1.5, 12.25]), np.radians([10.0, 20.0, 350.0]))

WRITTEN = {
    "trade headings": "MD (ft),Inc (deg),Azi (deg)\n0,0,10\n1000,1.5,20\n2000,12.25,350\n",
    "metres": "Measured Depth [m];INC [DEG];AZIMUTH [DEG]\n0;0;10\n304.8;1.5;20\n609.6;12.25;350\n",
    "decimal commas": "MD (m);Incl.;Azim.\n0;0;10\n304,8;1,5;20\n609,6;12,25;350\n",
    "tabs and signs": "Depth MD / ft\tInclination (°)\tAzimuth (°)\n0\t0\t10\n1000\t1.5\t20\n2000\t12.25\t350\n",
    "a row of units": "MD,Inc,Azi\nft,deg,deg\n0,0,10\n1000,1.5,20\n2000,12.25,350\n",
    "headings in two rows": "Measured;Incl.;Azim.\nDepth;;\n(ft);(°);(°)\n0;0;10\n1000;1.5;20\n2000;12.25;350\n",
    "underscores": "measured_depth_m,inclination_deg,azimuth_deg\n0,0,10\n304.8,1.5,20\n609.6,12.25,350\n",
    "a preamble, comments and empty lines": "Well: A-12\n# by gyro\n\nNo,MD ft,INC,AZI,TVD\n1,0,0,10,0\n"
    "# tie-in\n2,1000,1.5,20,990\n,,,,\n3,2000,12.25,350,1970\n",
    "another order": "Azi,TVD (m),Inc,MD (m)\n10,0,0,0\n20,304,1.5,304.8\n350,606,12.25,609.6\n",
    "spaces": "MD_ft INC AZI\n   0    0   10\n1000  1.5   20\n2000 12.25 350\n",
    "quotes": '"MD (ft)","Inc","Azi"\n"0","0","10"\n"1000","1.5","20"\n"2000","12.25","350"\n',
    "old line ends": "MD (ft),Inc (deg),Azi (deg)\r0,0,10\r1000,1.5,20\r2000,12.25,350\r",
    "a mark of the order of bytes": "\ufeffMD (ft),Inc (deg),Azi (deg)\n0,0,10\n1000,1.5,20\n2000,12.25,350\n",
    "thousands in quotes": 'MD (ft),Inc (deg),Azi (deg)\n0,0,10\n"1,000.00",1.5,20\n"2,000",12.25,350\n',
    "headings of logs": "DEPT,DEVI,HAZI\nFT,DEG,DEG\n0,0,10\n1000,1.5,20\n2000,12.25,350\n",
    "three decimals": "MD (m);Inc;Azi\n0,000;0,000;10,000\n304,800;1,500;20,000\n609,600;12,250;350,000\n",
    "radians": "MD (m),Inc (rad),Azi (rad)\n"
    + "".join(f"{s!r},{a!r},{b!r}\n" for s, a, b in zip(*EXPECTED.as_dict().values(), strict=True)),
}


def written(place: Path, text: str, encoding: str = "utf-8") -> Path:
    """Return the path of a file with a text."""
    (place / "survey.csv").write_text(text, encoding=encoding, newline="")
    return place / "survey.csv"


@pytest.mark.parametrize("kind", WRITTEN)
def test_surveys_are_read_as_they_are_written(kind: str, tmp_path: Path) -> None:
    found = fr.WellPath.from_csv(written(tmp_path, WRITTEN[kind]))
    for name in ("depth", "inclination", "azimuth"):
        np.testing.assert_allclose(getattr(found, name), getattr(EXPECTED, name), rtol=1e-15)


def test_columns_and_units_can_be_named(tmp_path: Path) -> None:
    path = written(tmp_path, "along;dip;north\n0;0;10\n1000;1.5;20\n2000;12.25;350\n", "cp1252")
    by_name = fr.WellPath.from_csv(path, "along", "dip", "north", depth_unit="ft")
    by_number = fr.WellPath.from_csv(path, 0, 1, 2, depth_unit="ft", angle_unit="deg", delimiter=";")
    assert by_name == by_number
    np.testing.assert_allclose(by_name.depth, EXPECTED.depth, rtol=1e-15)
    path = written(tmp_path, "0 0 10\n1000 1.5 20\n2000 12.25 350\n")
    assert fr.WellPath.from_csv(path, depth_unit="ft") == by_name


def test_survey_feet_are_longer_by_two_in_a_million(tmp_path: Path) -> None:
    found = fr.WellPath.from_csv(written(tmp_path, "MD (usft),Inc (°),Azi (°)\n0,0,0\n3937,1,0\n", "cp1252"))
    assert found.depth[1] == pytest.approx(1200.0, rel=1e-15)


def test_two_columns_are_a_well_in_one_plane(tmp_path: Path) -> None:
    found = fr.WellPath.from_csv(written(tmp_path, "MD (m),Inc\n0,0\n300,4\n"))
    assert found == fr.WellPath([0.0, 300.0], [0.0, math.radians(4.0)])


HEAD = "MD (m),Inc,Azi\n"
BAD = {
    "line 3, station 2: depth must be a number, got 'x30'": HEAD + "0,0,0\nx30,1,0\n",
    "line 3, station 2: azimuth is missing, and 1 of 2 stations have all": HEAD + "0,0,0\n30,1\n",
    "line 3, station 2: inclination is missing": HEAD + "0,0,0\n30,NaN,0\n",
    "line 3, station 2: depth must be a number, got '1 00.0'": HEAD + '0,0,0\n"1 00.0",1,0\n',
    "line 3, station 2: depth must be a number, got '1,00,0'": HEAD + '0,0,0\n"1,00,0",1,0\n',
    "inclination must be a heading of one column.*'Kippung": "Teufe,Kippung,HAZI\nFT,DEG,DEG\n0,0,0\n30,1,0\n",
    "line 3, station 2: inclination must be a number, got '1:30'": HEAD + "0,0,0\n30,1:30,0\n",
    "line 5: depth at station 4 must increase.* got 50 m after 60 m": HEAD + "0,0,0\n30,1,0\n60,1,0\n50,1,0\n",
    "line 3: depth at station 2 must increase.*measured twice": HEAD + "30,0,0\n30,1,0\n60,2,0\n",
    "line 2: depth at station 1 must lie between": HEAD + "-3,0,0\n30,1,0\n",
    "line 3: depth at station 2 must be finite": HEAD + "0,0,0\n1e999,1,0\n",
    "line 3: depth at station 2 must lie between 0 and 1e.06 m, got 1000000000 m": HEAD + "0,0,0\n1e9,1,0\n",
    "line 4: inclination at station 3 must lie between 0": HEAD + "0,0,0\n30,1,0\n60,181,0\n",
    "line 2: inclination at station 1 must lie between 0": HEAD + "0,-2,0\n30,1,0\n",
    "line 3: azimuth at station 2 must lie within two turns": HEAD + "0,2,0\n30,2,3600\n",
    "line 3: inclination at station 2 must not reverse": HEAD + "0,90,0\n30,90,180\n",
    "line 2: depth at station 1 must have two stations or more": HEAD + "0,0,0\n",
    "it holds no stations below its headings": HEAD,
    "it holds no stations": "# a comment\n\n",
    "line 1 should have headings such as 'MD .m.', 'Inc .deg.'": "well,operator\nA,B\n",
    "inclination must be a heading of one column, and 2 .*: 'Inc', .*; choose": "MD m,Inc,Inc,Azi\n0,0,0,0\n1,0,0,0\n",
    "line 2 should have headings such as.*got 'Sohle,Kippung,Peilung'": "A-12\nSohle,Kippung,Peilung\n0,0,0\n30,1,0\n",
    "azimuth must be a heading of one column, and none.*'Toolface'": "MD (m),Inc,Toolface\n0,0,0\n30,1,0\n",
    "depth_unit must be given, such as m or ft: the heading names none": "MD,Inc,Azi\n0,0,0\n30,1,0\n",
    "depth_unit must be given, such as m or ft: the heading names 'chain'": "MD (chain),Inc,Azi\n0,0,0\n30,1,0\n",
    "angle_unit must be given, such as deg or rad: the heading names 'mil'": "MD (m),Inc (mil),Azi\n0,0,0\n30,1,0\n",
    "line 3, station 2: it holds 6 cells below 3 headings; with decimal commas": HEAD + "0,0,0\n30,5,1,5,0,0\n",
    "line 3 has '1,500', which may be 1500 or 1.5": "MD (ft);Inc;Azi\n0;0;0\n1,500;1;0\n2,000;2;0\n",
    "line 3 has '1.000', which may be 1000 or 1;": "MD (m);Inc;Azi\n0;0;0\n1.000;1,5;0\n2.000;2,5;0\n",
    "depth must be a heading of one column, and 2 of them say": "MD m,Azi,Inc,MD ft\n0,0,0,0\n3,0,0,9\n",
    "it holds 20011 stations, at most 20000": HEAD + "0,0,0\n" * 20011,
    "line 2 cannot be read": HEAD + '0,"0,0\n30,1,0\n',
}


@pytest.mark.parametrize(
    "words", [pytest.param(words, marks=[pytest.mark.slow] * ("20011 stations" in words)) for words in BAD]
)
def test_bad_surveys_are_refused_in_one_line_with_the_place(words: str, tmp_path: Path) -> None:
    path = written(tmp_path, BAD[words])
    with pytest.raises(ValueError, match=words) as caught:
        fr.WellPath.from_csv(path)
    assert str(caught.value).startswith(f"survey {path}: ")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 320 + len(str(path))


@pytest.mark.parametrize("mark", [",", ";", "\t", " "])
def test_a_blank_azimuth_matters_only_where_the_well_is_inclined(mark: str, tmp_path: Path) -> None:
    file = tmp_path / "survey.csv"
    rows = [["0", "0", "---" if mark == " " else ""], ["600", "0.5", "45"], ["1000", "15", "50"]]
    file.write_text("\n".join(mark.join(row) for row in rows), encoding="utf-8")
    expected = fr.WellPath([0.0, 600.0, 1000.0], ["0deg", "0.5deg", "15deg"], ["45deg", "45deg", "50deg"])
    np.testing.assert_allclose(fr.WellPath.from_csv(file, depth_unit="m").azimuth, expected.azimuth, rtol=1e-15)
    file.write_text("\n".join([mark.join(["MD(m)", "Inc(deg)"]), *(mark.join(row) for row in rows)]), encoding="utf-8")
    with pytest.raises(ValueError, match=r"station [12]: it holds 3 cells below 2 headings"):
        fr.WellPath.from_csv(file)
    bare = [mark.join([*row[:2], *([""] * (mark != " "))]) for row in rows]
    file.write_text("\n".join(bare), encoding="utf-8")
    assert fr.WellPath.from_csv(file, depth_unit="m").azimuth.tolist() == [0.0, 0.0, 0.0]


def test_a_value_that_is_missing_between_spaces_is_refused(tmp_path: Path) -> None:
    """Nobody sees which one it is: 600 0 600 may be depth, inclination and azimuth."""
    rows = "MD(m)  Inc(deg)  Azi(deg)  TVD(m)\n0 0 45 0\n600 0 600\n900 10 45 890\n"
    with pytest.raises(ValueError, match=r"line 3, station 2: it holds 3 values for 4 columns.*write ---"):
        fr.WellPath.from_csv(written(tmp_path, rows))
    with pytest.raises(ValueError, match="line 2, station 2: it holds 2 values for 3 columns"):
        fr.WellPath.from_csv(written(tmp_path, "0 0 45\n600 0\n900 10 45\n"), depth_unit="m")


def test_files_that_are_no_surveys_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="there is no such file"):
        fr.WellPath.from_csv(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="it is a folder"):
        fr.WellPath.from_csv(tmp_path)
    (tmp_path / "binary.csv").write_bytes(b"MD\0\0")
    with pytest.raises(ValueError, match="binary"):
        fr.WellPath.from_csv(tmp_path / "binary.csv")
    path = written(tmp_path, HEAD + "0,0,0\n30,1,0\n")
    for wrong, words in (
        ({"depth": "Depth"}, "depth must be a heading of one column, got 'Depth'; the headings are 'MD"),
        ({"depth": 7}, "depth must be a column from 0 to 2, got 7"),
        ({"depth": 1, "inclination": 1}, "different columns"),
        ({"depth_unit": "deg"}, "depth_unit must be a unit of length.*got 'deg'"),
        ({"angle_unit": "m"}, "angle_unit must be a unit of angle"),
        ({"delimiter": "1"}, "delimiter must be one character"),
    ):
        with pytest.raises(ValueError, match=words):
            fr.WellPath.from_csv(path, **wrong)  # type: ignore[arg-type]


def test_a_station_that_looks_mistyped_is_told_with_its_line(tmp_path: Path) -> None:
    path = written(tmp_path, HEAD + "0,0,0\n30,1,0\n60,21,0\n90,3,0\n")
    with pytest.warns(fr.PlausibilityWarning, match="line 4: station 3 turns the well by 20 deg and back at 60 m"):
        fr.WellPath.from_csv(path)
