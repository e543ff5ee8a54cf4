"""Numbers that others have published: the rows of docs/theory/validation.md, each held to the digits printed."""

from __future__ import annotations

import dataclasses
import itertools
import re
from pathlib import Path

import pytest

import published
from published import SUBJECTS, Row, half_unit

PAGE = (Path(__file__).parents[1] / "docs/theory/validation.md").read_text(encoding="utf-8")
ROWS = list(itertools.chain.from_iterable(rows() for rows in SUBJECTS.values()))


def faults(row: Row) -> list[str]:
    """Return what is wrong with a row."""
    found = []
    if bool(row.why) == (abs(row.difference) <= row.tolerance):
        found.append(f"{row.what}: {row.ours!r} is{'' if row.why else ' not'} what is printed, {row.printed}")
    if row.here and abs(float(row.here) - row.ours) > half_unit(row.here):
        found.append(f"{row.what}: {row.ours!r} is not {row.here}")
    return found


@pytest.mark.parametrize("row", [pytest.param(row, id=row.what, marks=[pytest.mark.slow] * row.slow) for row in ROWS])
def test_a_published_number(row: Row) -> None:
    assert faults(row) == []


def test_a_row_that_drifts_is_seen() -> None:
    right = next(row for row in ROWS if row.what == "a_5(5)")
    wrong = next(row for row in ROWS if row.what == "a_50(2000)")
    assert faults(right) == faults(wrong) == []
    assert faults(dataclasses.replace(right, compute=lambda: right.ours + 1e-11))
    assert faults(dataclasses.replace(wrong, compute=lambda: float(wrong.printed)))
    assert faults(dataclasses.replace(wrong, compute=lambda: wrong.ours + 0.01))
    assert faults(dataclasses.replace(right, why="there is a difference"))


def test_rows_say_where_they_are_from_and_the_page_shows_all() -> None:
    assert all(row.source and row.what for row in ROWS)
    assert all(row.here for row in ROWS if row.why)  # what differs has our own number, so that it is held, too
    assert re.findall(r'^shown\("(.*)"\)$', PAGE, re.MULTILINE) == list(SUBJECTS)
    assert len(published.table(ROWS[:3]).table.rows) == 3
