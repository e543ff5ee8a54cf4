"""Numbers that others have published: the rows of docs/theory/validation.md, each held to the digits printed."""

from __future__ import annotations

import dataclasses
import itertools
import re
from pathlib import Path

import pytest

from tests.published import SUBJECTS, Row, Shown

PAGE = (Path(__file__).parents[2] / "docs/theory/validation.md").read_text(encoding="utf-8")
ROWS = list(itertools.chain.from_iterable(rows() for rows in SUBJECTS.values()))


@pytest.mark.parametrize("row", [pytest.param(row, id=row.what, marks=[pytest.mark.slow] * row.slow) for row in ROWS])
def test_a_published_number(row: Row) -> None:
    assert row.faults == []


def test_a_row_that_drifts_is_seen() -> None:
    right = next(row for row in ROWS if row.what == "a_5(5)")
    wrong = next(row for row in ROWS if row.what == "a_50(2000)")
    assert right.faults == wrong.faults == []
    assert dataclasses.replace(right, compute=lambda: right.ours + 1e-11).faults
    assert dataclasses.replace(wrong, compute=lambda: float(wrong.printed)).faults
    assert dataclasses.replace(wrong, compute=lambda: wrong.ours + 0.01).faults
    assert dataclasses.replace(right, why="there is a difference").faults


def test_rows_say_where_they_are_from_and_the_page_shows_all() -> None:
    assert all(row.source and row.what for row in ROWS)
    assert all(row.here for row in ROWS if row.why)  # what differs has our own number, so that it is held, too
    assert re.findall(r'^shown\("(.*)"\)$', PAGE, re.MULTILINE) == list(SUBJECTS)
    shown = Shown(ROWS[:3])._repr_html_()
    assert shown.count("a_5(") == 3
    assert shown.count("Burkardt") == 1  # a source stands over its rows
