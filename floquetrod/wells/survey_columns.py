"""The columns of a survey in a file: where its table begins, by headings, by numbers alone, or as they are chosen."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Sequence

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message, wrong_value
from floquetrod.tables.cells import Marks, is_numeric
from floquetrod.tables.head import Candidate, Column, Head, Wanted, find_head, unheaded
from floquetrod.tables.sources import Source
from floquetrod.tables.text import Row, is_data
from floquetrod.wells.survey_headings import AXES, KINDS, parts, places_of, places_of_axis, rank, rank_of_axis

_USUAL = "'MD (m)', 'Inc (deg)' and 'Azi (deg)'"
_CHOSEN = {"depth": "DEPTH", "inclination": ",INCLINATION", "azimuth": ",,AZIMUTH"}
"""How the option of the terminal chooses one column alone."""


def find_columns(
    file: Source, chosen: dict[str, str | int | None], given: dict[str, str | None]
) -> tuple[Head, list[Row]]:
    """Return the head of the table with directions, else with positions, and all rows; ValueError where none begins.

    ``chosen`` are columns and ``given`` their units, see `floquetrod.WellPath.from_csv`.
    """
    wanted = [_wanted(name, chosen[name], given[name]) for name in KINDS]
    failures: list[Candidate] = []
    for mark, rows in file.rows.items():
        if (head := find_head(rows, mark, wanted, failures)) is not None:
            return head, rows
    is_chosen = any(each.column is not None for each in wanted)
    for mark, rows in file.rows.items():
        if not is_chosen and (head := find_head(rows, mark, _axes(given), [])) is not None:
            return head, rows
    if not any(isinstance(each.column, str) for each in wanted):
        for mark, rows in file.rows.items():
            first = next((i for i, row in enumerate(rows) if _is_unheaded(row)), None)
            if first is None or not _may_stand_above(rows[:first], is_chosen):
                continue
            below = rows[first:]
            if (named := _commented(file, mark, below, wanted)) is not None:
                return named, below
            return _unheaded(below, mark, wanted), below
    raise _no_headings(file, wanted, failures)


def _wanted(name: str, column: str | int | None, unit: str | None) -> Wanted:
    kind = KINDS[name]
    return Wanted(
        name,
        kind,
        column,
        unit,
        functools.partial(places_of, name),
        lambda text: parts(text, kind)[1],
        is_optional=name == "azimuth",
        remedy=Mention("survey_columns", name, _CHOSEN[name]),
        may_be_unnamed=True,
    )


def _axes(given: dict[str, str | None]) -> list[Wanted]:
    """Return the columns of a survey by positions."""
    unit = given["depth"]
    return [
        Wanted(name, kind, None, unit, functools.partial(places_of_axis, name), lambda text: parts(text, "length")[1])
        for name, kind in AXES.items()
    ]


def _is_unheaded(row: Row) -> bool:
    return is_data(row) and sum(is_numeric(cell) for cell in row.cells) > 1


def _may_stand_above(rows: Sequence[Row], is_chosen: bool) -> bool:
    """Return whether rows above numbers are no headings: the name of a well, or anything where columns are chosen."""
    names = all(re.match(r"(well|name|welltrack|wellname)\b|--", row.text, re.IGNORECASE) for row in rows)
    return is_chosen or names


def _commented(file: Source, mark: str, rows: list[Row], wanted: Sequence[Wanted]) -> Head | None:
    """Return the head whose headings are in a comment above the first row, None without any."""
    for number, text in reversed([line for line in file.comments if line[0] < rows[0].line]):
        cells = text.split() if mark == " " else [cell.strip() for cell in text.split(mark)]
        above = Row(number, cells, text)
        if (head := find_head([above, *rows], mark, wanted, [])) is not None:
            return head._replace(first=head.first - 1)
    return None


def _unheaded(rows: list[Row], mark: str, wanted: Sequence[Wanted]) -> Head:
    """Return the columns of rows without headings: depth, inclination, azimuth, or x, y, z and depth."""
    head = unheaded(rows, mark, wanted)
    if any(each.column is not None for each in wanted):
        return head
    numbers = [[_quick(cell) for cell in row.cells[:4]] for row in rows if is_data(row)]
    by_directions = _may_be_directions(numbers)
    if not _may_be_positions(numbers):
        return head
    if by_directions:
        raise ValueError(
            Message(
                f"line {rows[0].line} has no headings above it, and its columns may be depth, inclination and azimuth "
                "or x, y, z and measured depth; ",
                _name_columns(),
            )
        )
    places = {"depth": 3, "north": 1, "east": 0, "down": 2}
    return Head(mark, None, [Column(name, place, "", None) for name, place in places.items()], 0)


def _quick(cell: str) -> float:
    """Return the number in a cell, NaN for another one."""
    number = Marks(".").number(cell)
    return float("nan") if number is None else number


def _may_be_directions(numbers: Sequence[Sequence[float]]) -> bool:
    """Return whether the first three columns may be depth, inclination and azimuth in degrees."""
    table = np.array([row[:3] for row in numbers if len(row) > 2])
    with np.errstate(invalid="ignore"):
        increases = bool((np.diff(table[:, 0]) >= 0.0).all()) if len(table) else False
        return increases and bool((np.abs(table[:, 1]) <= 180.0).all() and (np.abs(table[:, 2]) <= 720.0).all())


def _may_be_positions(numbers: Sequence[Sequence[float]]) -> bool:
    """Return whether four columns may be x, y, z and measured depth: no chord is longer than the well along it."""
    if len(numbers) < 2 or any(len(row) < 4 for row in numbers):
        return False
    table = np.array([row[:4] for row in numbers])
    if not np.isfinite(table).all():
        return False
    chords, along = np.linalg.norm(np.diff(table[:, :3], axis=0), axis=1), np.diff(table[:, 3])
    return bool((along > 0.0).all() and (chords <= along * 1.01 + 0.1).all() and (chords >= 0.6 * along - 0.1).all())


def _name_columns() -> Mention:
    """Return the remedy for unknown headings."""
    return Mention("survey_columns", "name the columns by depth, inclination and azimuth", "DEPTH,INCLINATION,AZIMUTH")


def _no_headings(file: Source, wanted: Sequence[Wanted], failures: Sequence[Candidate]) -> ValueError:
    """Return the error for a file in which no table begins, with the headings that were most nearly known."""
    closest = max(failures, key=lambda each: (each.known, _is_above_numbers(each, file)), default=None)
    if closest is not None and _lacks_depth(closest):
        return wrong_value(
            "depth",
            f"is in no column of line {closest.row.line}, which has positions alone: add a column of measured depths, "
            "such as MD",
        )
    by_name = any(isinstance(each.column, str) for each in wanted)
    if closest is not None and (closest.known > 1 or (by_name and closest.known)):
        return closest.error
    rows = next(iter(file.rows.values()))
    is_likely = closest is not None and (closest.known > 0 or _is_above_numbers(closest, file))
    row = closest.row if closest is not None and is_likely else rows[0]
    for each in wanted:
        if isinstance(each.column, int) and closest is not None:
            return closest.error
    usual = ", ".join(validate.short(each.column) for each in wanted if isinstance(each.column, str)) or _USUAL
    remedy = "" if by_name else "; "
    return ValueError(
        Message(
            f"line {row.line} should have headings such as {usual}, got {validate.short(row.text)}",
            *((remedy, _name_columns()) if remedy else ()),
        )
    )


def _is_above_numbers(candidate: Candidate, file: Source) -> bool:
    """Return whether the next row is one of numbers."""
    for rows in file.rows.values():
        for row, below in itertools.pairwise(rows):
            if row.line == candidate.row.line:
                return is_data(below)
    return False


def _lacks_depth(candidate: Candidate) -> bool:
    """Return whether headings are of positions without a measured depth."""
    axes = [any(rank_of_axis(name, text) is not None for text in candidate.headings) for name in ("north", "east")]
    return all(axes) and not any(rank(name, text) is not None for name in KINDS for text in candidate.headings)
