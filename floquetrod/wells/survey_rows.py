"""The rows of a survey in a file: which are stations, where the table ends, and which of them are refused."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from floquetrod._util import validate
from floquetrod.tables.cells import Marks, Placed, is_missing, is_numeric, marks_of, split_unit
from floquetrod.tables.head import Head
from floquetrod.tables.text import Row
from floquetrod.wells.survey_headings import KINDS, WELL_LABELS, parts, rank, words_of

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

    It goes on below repeated headings, as on the next page, and between spaces below labels such as "KOP to EOC".
    Between spaces it ends at the title and the headings of another table, whose rows are not read.  Other rows of
    numbers below a row that is no station are refused: one of them is mistyped, or they are another table.
    """
    # `others` are the rows passed over since the last station.  Between spaces rows of numbers below two of them or
    # more (a title, headings) are of another table, `has_foreign`, if they are not as wide as stations and either not
    # below the last one or below headings of depths.
    stations: list[Row] = []
    others: list[Row] = []
    notes: list[str] = []
    heading_texts = {row.text for row in head.heading_rows}
    unit_texts = {unit_row.text for unit_row in head.unit_rows}
    above = _Above(head)
    has_pages, is_new_page, has_foreign = False, False, False
    for row in rows[head.first :]:
        if row.text in heading_texts and head.heading_rows:
            has_pages = is_new_page = True
            continue
        if row.text in unit_texts:
            continue
        is_station = _is_station(row, head)
        if not is_station and not _is_mistyped(row, head):
            others.append(row)
            continue
        goes_on = is_station and (not others or has_pages)
        if others and stations and head.delimiter == " " and not is_new_page:
            is_wide, is_below = is_station and above.is_as_wide(row), is_station and above.is_deeper(row)
            if len(others) > 1 and not is_wide and (not is_below or has_foreign or any(map(_is_heading, others))):
                others.append(row)
                has_foreign = True
                continue
            goes_on = is_wide and is_below and not has_foreign and (has_pages or _are_labels(others))
            if is_below and not goes_on:
                _as_wide(row, head, len(stations) + 1)
        if not goes_on:
            raise _not_a_station(others[0] if others and is_station else row, head, len(stations) + 1)
        if others:
            notes.append(_passed_over(others, is_new_page, has_foreign))
        others, is_new_page, has_foreign = [], False, False
        stations.append(row)
        if head.delimiter == " ":
            above.add(row)
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


class _Above:
    """The stations above a row: where all of them have numbers, and the last of them."""

    def __init__(self, head: Head) -> None:
        self._head = head
        self._last: Row | None = None
        self._numbered: set[int] = set()

    def add(self, row: Row) -> None:
        """Take a station below those above."""
        numbered = {place for place, cell in enumerate(row.cells) if _is_number(cell) or is_missing(cell)}
        self._numbered = numbered if self._last is None else self._numbered & numbered
        self._last = row

    def is_as_wide(self, row: Row) -> bool:
        """Return whether a row has a number wherever all stations have one, and none beyond the headings."""
        many = len(self._head.headings or [])
        ends_in_chosen = max(column.place for column in self._head.columns) == many - 1
        if ends_in_chosen and len(row.cells) > many and is_numeric(row.cells[many]):
            return False
        return all(
            place < len(row.cells) and (_is_number(row.cells[place]) or is_missing(row.cells[place]))
            for place in self._numbered
        )

    def is_deeper(self, row: Row) -> bool:
        """Return whether a row lies below the last station, or repeats it."""
        if self._last is None or cells_in(row, self._head) == cells_in(self._last, self._head):
            return True
        place = next(column.place for column in self._head.columns if column.name == "depth")
        depths = [split_unit(each.cells[place])[0] for each in (self._last, row)]
        try:
            marks = marks_of([Placed(row.line, text, True) for text in depths], self._head.delimiter)
        except ValueError:  # 1,500 beside 2,000.5: refused with all rows, or decided by them
            marks = Marks(".")
        last, depth = map(marks.number, depths)
        return last is None or (depth is not None and depth > last)


def _are_labels(rows: Sequence[Row]) -> bool:
    """Return whether rows are labels between stations: words, with one number at most, neither headings nor a well."""
    for row in rows:
        words = words_of(row.text)
        named = [any(rank(name, cell) is not None for cell in row.cells) for name in KINDS]
        has_words = any(_WORD.fullmatch(cell) for cell in row.cells) or row.text.rstrip().endswith('"')
        if not has_words or sum(map(is_numeric, row.cells)) > 1 or sum(named) > 1 or words[:1] in _OF_WELLS:
            return False
    return True


_WORD = re.compile(r"\W*[^\W\d_][^\d_]+")
"""A word of two letters or more, without digits: not a mistyped number."""

_OF_WELLS = {words_of(label)[:1] for label in WELL_LABELS}
"""First words of lines that may name another well."""


def _is_heading(row: Row) -> bool:
    """Return whether a row has two headings of depths, or of their units, at least: Depth Depth, (usft) (usft)."""
    return sum(rank("depth", cell) is not None or _is_unit_alone(cell) for cell in row.cells) > 1


def _is_unit_alone(cell: str) -> bool:
    name, unit = parts(cell, "length")
    return not name and unit is not None


def _passed_over(others: Sequence[Row], is_new_page: bool, has_foreign: bool) -> str:
    """Return the note on rows between stations."""
    named = f"line {others[0].line}, {validate.short(others[0].text.strip())}"
    if is_new_page:
        below = "lines" if has_foreign else "headings"
        return f"{named}, and the {below} below it are left out: the table goes on below them"
    more = f" and {len(others) - 1} more below it are" if len(others) > 1 else ", is"
    return f"{named}{more} left out: the table goes on below"


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
