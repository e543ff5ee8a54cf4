"""Surveys as Compass prints them: pages, labels between stations and tables below them; no station is lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr

TITLE = """Standard Survey Report
Company:  Acme Energy LLC     TVD Reference:  RKB @ 2815.50usft
Well:     Badger 12-1H        MD Reference:   RKB @ 2815.50usft
"""
HEAD = """Survey
 Measured                          Vertical                        Vertical   Dogleg
  Depth   Inclination   Azimuth     Depth     +N/-S      +E/-W     Section     Rate
  (usft)      (°)         (°)       (usft)    (usft)     (usft)    (usft)   (°/100usft)
"""
FIRST = """      0.00   0.00     0.00       0.00      0.00      0.00      0.00     0.00
  3,000.00   0.00     0.00   3,000.00      0.00      0.00      0.00     0.00
"""
SECOND = """  3,100.00   9.00   120.00   3,099.59     -3.92      6.79      7.84     9.00
  3,200.00  18.00   120.00   3,196.73    -15.58     26.98     31.16     9.00
"""
PAGE = "11/29/2026 9:12:44AM          Page 2          COMPASS 5000.14 Build 85\n"
ANNOTATIONS = """
Design Annotations
 Measured   Vertical     Local Coordinates
  Depth      Depth     +N/-S    +E/-W
  (usft)     (usft)   (usft)   (usft)   Comment
  3,000.00  3,000.00    0.00     0.00   KOP
  3,200.00  3,196.73  -15.58    26.98   TD at 3200.00 with a comment of some words
"""
CASINGS = """
Casing Points
  Measured   Vertical                        Casing    Hole
   Depth      Depth          Name          Diameter  Diameter
   (usft)     (usft)                          (")       (")
   1,500.00   1,500.00   9 5/8" Casing      9-5/8    12-1/4
   3,150.00   3,150.00   7                      7     8-3/4
"""
FORMATIONS = """
Formations
  Measured   Vertical                                        Dip
   Depth      Depth        Name          Lithology    Dip  Direction
   (usft)     (usft)                                  (°)     (°)
   2,500.00   2,500.00   Wolfcamp                     0.00   0.00
   3,150.00   3,148.00   Wolfcamp B      shale        0.00   0.00
"""
PROJECTED = ANNOTATIONS.replace("3,200.00 ", "3,250.00 ")
BELOW = ANNOTATIONS + CASINGS + FORMATIONS + PROJECTED + "\nChecked By: ______ Approved By: ______\n" + PAGE


def read(text: str, folder: Path) -> fr.WellPath:
    path = folder / "survey.txt"
    path.write_text(TITLE + HEAD + text, encoding="utf-8")
    return fr.WellPath.from_csv(path)


@pytest.mark.parametrize("below", [ANNOTATIONS, CASINGS, FORMATIONS, PROJECTED, BELOW])
@pytest.mark.parametrize("page", ["", PAGE + TITLE + HEAD], ids=["1 page", "2 pages"])
def test_tables_below_the_stations_are_not_read(below: str, page: str, tmp_path: Path) -> None:
    well = read(FIRST + page + SECOND + below, tmp_path)
    np.testing.assert_allclose(well.depth, np.array([0.0, 3000.0, 3100.0, 3200.0]) * 1200.0 / 3937.0, rtol=1e-14)
    np.testing.assert_allclose(well.inclination, np.radians([0.0, 0.0, 9.0, 18.0]), rtol=1e-14)
    title = below.split("\n")[1]
    rows = sum(bool(line.strip()) for line in below.split("\n"))
    assert f"{title!r} and {rows - 1} more below it, is no station: the table ends above it" in str(well.note)
    assert ("Page 2" in str(well.note)) == bool(page)


def test_stations_go_on_below_a_table_and_repeated_headings(tmp_path: Path) -> None:
    well = read(FIRST + ANNOTATIONS + PAGE + TITLE + HEAD + SECOND, tmp_path)
    assert well.depth.size == 4
    assert well.note is not None
    assert "'Design Annotations', and the lines below it are left out: the table goes on below them" in well.note


@pytest.mark.parametrize("label", ["KOP to EOC", '9 5/8"', "Tie-on", "KOP to EOC, 9 deg/100ft", 'Tie-on\n   7" liner'])
@pytest.mark.parametrize("page", ["", PAGE + TITLE + HEAD], ids=["1 page", "2 pages"])
def test_labels_between_stations_are_passed_over(label: str, page: str, tmp_path: Path) -> None:
    well = read(FIRST + f"   {label}\n" + SECOND[:77] + page + SECOND[77:], tmp_path)
    assert well.depth.size == 4
    first, _, second = label.partition("\n")
    more = " and 1 more below it are" if second else ", is"
    assert well.note is not None
    assert f"line 10, {first!r}{more} left out: the table goes on below" in well.note


SHORT = "  3,300.00  27.00   120.00   3,289.02    -34.69     60.09     69.39\n"
MISTYPED = SHORT.replace("27.00", "2T.00")
WIDE = SHORT.replace("\n", "   9.00\n")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SECOND + SHORT, "line 12, station 5: it holds 7 values for 8 columns"),
        (SECOND + "Tie-on\n" + SHORT, "line 13, station 5: it holds 7 values for 8 columns"),
        (SECOND + "Tie-on\n" + SHORT + WIDE, "line 13, station 5: it holds 7 values for 8 columns"),
        (SECOND + "Tie-on\nKOP\n" + SHORT, "line 14, station 5: it holds 7 values for 8 columns"),
        (SECOND + "Tie-on\n" + MISTYPED, "line 13, station 5: inclination must be a number, got '2T.00'"),
        (SECOND + "Tie-on\n" + MISTYPED + WIDE, "line 13, station 5: inclination must be a number, got '2T.00'"),
        (SECOND + ANNOTATIONS + WIDE, "line 13, station 5: depth must be a number, got 'Design'"),
        (SECOND + "Well: Badger 13\n" + WIDE, "line 12, station 5: depth must be a number, got 'Well:'"),
        (SECOND + "MD Inc Azi\n" + WIDE, "line 12, station 5: depth must be a number, got 'MD'"),
        (SECOND + "Badger 13\nPlan 2\n" + FIRST, "line 12, station 5: depth must be a number, got 'Badger'"),
        (
            SECOND + "3,25O.00 2O.00 120 3,2OO -1O 3O 3l 9.OO\n" + WIDE,
            "line 12, station 5: depth must be a number, got '3,25O.00'",
        ),
    ],
)
def test_rows_that_may_be_stations_are_refused(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=words):
        read(FIRST + text, tmp_path)
