"""The rows of a survey in a file: which are stations, where the table ends, and which of them are refused."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from floquetrod._util import validate
from floquetrod.tables.cells import Marks, Placed, is_missing, is_numeric, marks_of, split_unit
from floquetrod.tables.head import Head
from floquetrod.tables.text import Row

BEARING = re.compile(
    r"([NS])\s*(?:(\d+(?:[.,]\d*)?)\s*(?:[°º˚]|deg)?\s*(?:(\d+(?:[.,]\d*)?)\s*['\u2019\u2032]\s*)?)([EW])",
    re.IGNORECASE,
)
"""An azimuth as an angle from north or south: N30E."""


class SurveyTable(NamedTuple):
    """The head of a table, its rows, the mark before decimals, and what was passed over."""

    head: Head
    rows: list[Row]
    marks: Marks
    notes: list[str]


def survey_table(head: Head, rows: Sequence[Row]) -> SurveyTable:
    """Return the rows of a table, which ends at the first row that is none; what follows is named in a note.

    It goes on below repeated headings, as on the next page.  Rows of stations below another one are refused:
    one of them is mistyped, or they are another table.
    """
    stations: list[Row] = []
    others: list[Row] = []
    notes: list[str] = []
    heading_texts = {row.text for row in head.heading_rows}
    unit_texts = {unit_row.text for unit_row in head.unit_rows}
    repeated = False
    for row in rows[head.first :]:
        if row.text in heading_texts and head.heading_rows:
            repeated = True
            continue
        if row.text in unit_texts:
            continue
        if _is_station(row, head):
            if others and not repeated:
                raise _not_a_station(others[0], head, len(stations) + 1)
            if others:
                notes.append(
                    f"line {others[0].line}, {validate.short(others[0].text)}, and the headings below it are "
                    "left out: the table goes on below them"
                )
                others = []
            stations.append(row)
            continue
        if _is_mistyped(row, head):
            raise _not_a_station(row, head, len(stations) + 1)
        others.append(row)
    if others:
        more = f" and {len(others) - 1} more below it" if len(others) > 1 else ""
        notes.append(
            f"line {others[0].line}, {validate.short(others[0].text)}{more}, is no station: the table ends above it"
        )
    stations = [_as_wide(row, head, station) for station, row in enumerate(stations, 1)]
    marks = marks_of(
        [
            Placed(row.line, row.cells[column.place], column.name == "depth")
            for row in stations
            for column in head.columns
            if column.place < len(row.cells) and is_numeric(split_unit(row.cells[column.place])[0])
        ],
        head.delimiter,
    )
    return SurveyTable(head, stations, marks, notes)


def cells_in(row: Row, head: Head) -> list[str]:
    """Return the cells of the chosen columns."""
    return [row.cells[column.place] if column.place < len(row.cells) else "" for column in head.columns]


def _is_number(cell: str) -> bool:
    return is_numeric(split_unit(cell)[0]) or BEARING.fullmatch(cell) is not None


def _is_station(row: Row, head: Head) -> bool:
    """Return whether all chosen cells are numbers or marks of lost values, one a number at least."""
    cells = cells_in(row, head)
    if head.delimiter == " " and head.headings is None and len(row.cells) < len(head.columns):
        return _is_number(cells[0]) and all(map(_is_number, row.cells))
    return (
        all(_is_number(cell) or is_missing(cell) for cell in cells)
        and any(map(_is_number, cells))
        and (_is_number(cells[0]) or any(map(_is_number, cells[1:])))
    )


def _is_mistyped(row: Row, head: Head) -> bool:
    """Return whether a row is a station with a cell that cannot be read: other cells are numbers."""
    numbers = list(map(_is_number, cells_in(row, head)))
    if head.delimiter == " " and sum(numbers) < 2:
        return False
    return sum(numbers) > 1 or (numbers[0] and head.delimiter != " ")


def _not_a_station(row: Row, head: Head, station: int) -> ValueError:
    """Return the error for a row among stations that is none."""
    cells = cells_in(row, head)
    for column, cell in zip(head.columns, cells, strict=True):
        if not _is_number(cell) and not is_missing(cell):
            return ValueError(
                f"line {row.line}, station {station}: {column.name} must be a number, got {validate.short(cell)}; "
                f"{_hint(cell)}"
            )
    return ValueError(
        f"line {row.line}, {validate.short(row.text)}, is no station, and stations follow below it; put # before lines "
        "without data, and write another well into a file of its own"
    )


def _hint(cell: str) -> str:
    if "," in cell:
        return "write a point before decimals, or separate columns by semicolons"
    return "put # before lines without data"


def _as_wide(row: Row, head: Head, station: int) -> Row:
    """Return a row that has as many cells as headings; one with more or fewer is refused where cells may be shifted.

    A comment in the last column may hold the separator of columns, or spaces; a row between spaces may lack no value.
    """
    last = max(column.place for column in head.columns)
    if head.headings is None:
        if head.delimiter == " " and len(row.cells) <= last:
            raise _short(row, station, last + 1)
        return row
    many = len(head.headings)
    if head.delimiter == " ":
        lacks = len(row.cells) < many and (
            len(row.cells) <= last or not all(map(_is_number, cells_in(row, head))) or _may_be_shifted(row, head)
        )
        if lacks:
            raise _short(row, station, many)
        if len(row.cells) > many and last == many - 1 and is_numeric(row.cells[many]):
            raise _long(row, station, many, head.delimiter)
        return row
    if any(row.cells[many:]) and not (last < many - 1 and not is_numeric(row.cells[many - 1])):
        raise _long(row, station, many, head.delimiter)
    return row


def _may_be_shifted(row: Row, head: Head) -> bool:
    """Return whether a value that is missing between spaces may be one of the chosen columns."""
    return any(is_numeric(cell) for cell in row.cells[max(column.place for column in head.columns) :])


def _short(row: Row, station: int, many: int) -> ValueError:
    return ValueError(
        f"line {row.line}, station {station}: it holds {len(row.cells)} values for {many} columns, and between spaces "
        "nobody sees which is missing; write --- for it"
    )


def _long(row: Row, station: int, many: int, delimiter: str) -> ValueError:
    remedy = "; with decimal commas separate columns by semicolons" if delimiter == "," else ""
    return ValueError(
        f"line {row.line}, station {station}: it holds {len(row.cells)} cells below {many} headings{remedy}"
    )
