"""Headings of tables in spaced text: several rows of them become one by where their phrases stand."""

from __future__ import annotations

from floquetrod.tables.head import merged
from floquetrod.tables.text import Row


def headings(*lines: str, width: int) -> list[str]:
    rows = [Row(number, line.split(), line) for number, line in enumerate(lines, 1)]
    return merged(rows, " ", width)


BASE = "Depth (m)        Inc (deg)   Azi (deg)   TVD (m)"


def test_a_phrase_stays_together_where_it_stands_over_two_columns() -> None:
    upper = "Measured Along Hole Axis      True North"
    assert headings(upper, BASE, width=4) == [
        "Measured Along Hole Axis Depth (m)",
        "Inc (deg)",
        "True North Azi (deg)",
        "TVD (m)",
    ]


def test_as_many_words_as_columns_are_a_heading_each() -> None:
    assert headings("Measured         Hole        True        Vertical", BASE, width=4) == [
        "Measured Depth (m)",
        "Hole Inc (deg)",
        "True Azi (deg)",
        "Vertical TVD (m)",
    ]
    assert headings("MD Inc Azi TVD", width=4) == ["MD", "Inc", "Azi", "TVD"]
