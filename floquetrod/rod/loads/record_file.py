"""Times and forces of a record, read from a table in a text file."""

from __future__ import annotations

import io
import itertools
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod.tables.cells import NUMBER, is_missing, is_value, plain
from floquetrod.tables.clock import CLOCK, DATES, Clock
from floquetrod.tables.head import HEAD, Candidate, Column, Head, Wanted, best, find_head, headed_by, unheaded
from floquetrod.tables.text import Line, Row, delimiters_of, rows_of, text_of

_DATES = ("date", "datum")
_USUAL = {
    "time": ("time", "t", "timestamp", "datetime", "date/time", "elapsed", "epoch", "zeit", "uhrzeit", *_DATES),
    "force": ("force", "f", "load", "kraft"),
}
"""Headings of a column, or words of them."""

_NOT_PLAIN = re.compile(r'["#]|\r(?!\n)')
"""What lines hold that NumPy's reader reads otherwise than this one."""

_NOT_A_SPACE = re.compile(r"[^\S \n\r]")
_TOGETHER = 20_000  # lines read at once; where one is not plain numbers, each is read alone (a choice)


class Columns(NamedTuple):
    """Times in s and forces in N, NaN where a cell is empty; the file's unit of force, "" where it names none."""

    time: NDArray[np.float64]
    force: NDArray[np.float64]
    force_unit: str
    has_time_unit: bool


class _Measured(NamedTuple):
    """A column of a record: its argument, its place, and the size of its unit in SI."""

    name: str
    place: int
    size: float


def read_columns(
    path: Path,
    time: str | int | None,
    force: str | int | None,
    time_unit: str | None,
    force_unit: str | None,
    delimiter: str | None,
) -> Columns:
    """Return the samples of a file; ValueError names line and column.

    `floquetrod.ForceRecord.from_csv` lists the accepted forms.
    """
    numbered = enumerate(io.StringIO(text_of(path)), 1)
    lines = list(itertools.islice(numbered, HEAD))
    wanted = [_wanted("time", time, time_unit), _wanted("force", force, force_unit)]
    head, rows = _head(lines, delimiter, wanted)
    row = rows[head.first] if head.first < len(rows) else Row(0, [], "")
    in_units = [_unit(column, each, row) for column, each in zip(head.columns, wanted, strict=True)]
    chosen = [
        _Measured(column.name, column.place, 1.0 if unit is None else unit.size)
        for column, unit in zip(head.columns, in_units, strict=True)
    ]
    reader = _Rows(chosen, _date(head), head.delimiter, Clock(time_unit))
    above = next((i for i, (number, _) in enumerate(lines) if number == row.line), len(lines))
    samples = [np.empty((0, 2)), reader.read(lines[above:])]
    while lines := list(itertools.islice(numbered, _TOGETHER)):
        samples.append(reader.read(lines))
    numbers = np.concatenate(samples)
    if not numbers.size:
        raise ValueError("it holds no samples below its headings")
    times, forces = (numbers * [column.size for column in chosen]).T
    is_clock = _date(head) is not None or any(":" in cell for cell in row.cells)
    of_time, of_force = in_units
    return Columns(times, forces, "" if of_force is None else of_force.name, of_time is not None or is_clock)


def _wanted(name: str, column: str | int | None, unit: str | None) -> Wanted:
    return Wanted(
        name, name, column, unit, lambda listed: _places(name, listed, unit), lambda text: _parts(text, name)[1]
    )


def _head(lines: Sequence[Line], delimiter: str | None, wanted: Sequence[Wanted]) -> tuple[Head, list[Row]]:
    """Return what the first lines say, and their rows; lines above the headings that are no table are passed over."""
    failures: list[Candidate] = []
    first: tuple[str, list[Row]] | None = None
    for mark in delimiters_of(lines, delimiter):
        rows = list(rows_of(lines, mark))
        if not rows:
            raise ValueError("it holds no samples")
        if _is_sample(rows[0]):
            return unheaded(rows, mark, wanted), rows
        head = find_head(rows, mark, wanted, failures)
        if head is not None and (head.first < len(rows) or _are_usual(head.columns)):
            if len({column.place for column in head.columns}) < len(wanted):
                raise ValueError(f"time and force must be two columns, got column {head.columns[0].place} for both")
            return head, rows
        if first is None or len(first[1][0].cells) < 2:
            first = mark, rows
    failure = max(failures, key=lambda each: (each.known, len(each.headings)), default=None)
    if failure is not None and len(failure.headings) > 1:
        raise failure.error
    mark, rows = first or ("", [])
    if not rows or len(rows[0].cells) < 2:
        raise ValueError(
            f"line {rows[0].line} has one column, {validate.short(rows[0].text)}; give delimiter, such as ';', or put "
            "# before lines without data"
        )
    return headed_by(rows, mark, wanted), rows


def _is_sample(row: Row) -> bool:
    return len(row.cells) > 1 and all(is_value(plain(cell, "")) for cell in row.cells)


def _places(name: str, headings: Sequence[str], unit: str | None) -> list[int]:
    """Return the places of usual headings; of two columns with other headings the first is time.

    Of two columns of which one is the other quantity, this one is known by its unit, in the heading or given.
    """
    places = best(headings, lambda text: _rank(name, text))
    if places or len(headings) != 2:
        return places
    known = [place for place, text in enumerate(headings) if any(_rank(each, text) for each in _USUAL)]
    if not known:
        return [list(_USUAL).index(name)]
    left = [place for place in range(2) if place not in known]
    return [place for place in left if unit or units.is_unit(_parts(headings[place], name)[1] or "", name)]


def _are_usual(columns: Sequence[Column]) -> bool:
    """Return whether headings without rows below are headings: any two words would be."""
    return any(_rank(column.name, column.heading) is not None for column in columns)


def _rank(name: str, heading: str) -> int | None:
    """Return how well a heading suits: a usual one, a unit, one with a usual word; dates beside times last."""
    text = _parts(heading, name)[0].casefold()
    if text in _USUAL[name]:
        return 4 if text in _DATES else 1
    if units.is_unit(heading, name):
        return 2
    return 3 if set(re.split(r"[\W_]+", text)) & set(_USUAL[name]) else None


def _parts(heading: str, name: str) -> tuple[str, str | None]:
    """Return name and unit of a heading, where "date/time" has no unit."""
    return (heading, None) if heading.casefold() in _USUAL[name] else units.heading(heading, name)


def _unit(column: Column, wanted: Wanted, row: Row) -> units.Unit | None:
    """Return the unit of a column, None where none was named: its numbers are then in SI."""
    name, unit = wanted.name, wanted.unit
    if name == "time" and unit is None and column.place < len(row.cells) and CLOCK.fullmatch(row.cells[column.place]):
        return units.unit("s", "", name)
    if unit is not None:
        return units.unit(unit, f"{name}_unit", name)
    if column.unit is None:
        return None
    if not units.is_unit(column.unit, name):
        raise validate.wrong_value(
            f"{name}_unit",
            f"must be given, one of {', '.join(units.units_of(name))}: the heading {column.heading!r} names none",
        )
    return units.unit(column.unit, "", name)


def _date(head: Head) -> int | None:
    """Return the place of a column with dates beside times of day, None without one."""
    time = head.columns[0].place
    dates = [i for i, text in enumerate(head.headings or ()) if text.casefold() in _DATES and i != time]
    return dates[0] if len(dates) == 1 else None


class _Rows:
    """Reads the numbers of two columns, many lines at a time where they are plain numbers, else line by line."""

    def __init__(self, columns: Sequence[_Measured], date: int | None, delimiter: str, clock: Clock) -> None:
        self.columns = columns
        self.date = date
        self.delimiter = delimiter
        self.clock = clock

    def read(self, lines: list[Line]) -> NDArray[np.float64]:
        """Return the numbers of lines, (n, 2)."""
        numbers = self._at_once(lines)
        return self.careful(lines) if numbers is None else numbers

    def careful(self, lines: Iterable[Line]) -> NDArray[np.float64]:
        """Return the numbers of lines, (n, 2); ValueError for the first that cannot be read."""
        rows = [self._row(row) for row in rows_of(lines, self.delimiter)]
        return np.array(rows, dtype=np.float64).reshape(-1, 2)

    def _at_once(self, lines: list[Line]) -> NDArray[np.float64] | None:
        """Return what `careful` does, by NumPy's reader; None where it might read otherwise."""
        text = "".join(line for _, line in lines)
        if _NOT_PLAIN.search(text) or (self.delimiter == " " and _NOT_A_SPACE.search(text)) or not text.strip():
            return None
        if self.delimiter != "," and "," in text:
            if "." in text:
                return None
            text = text.replace(",", ".")
        places = [column.place for column in self.columns]
        delimiter = None if self.delimiter == " " else self.delimiter
        try:
            numbers = np.loadtxt(io.StringIO(text), delimiter=delimiter, usecols=places, comments=None, ndmin=2)
        except ValueError:
            return None
        return numbers if np.isfinite(numbers).all() and not self.clock.is_used else None

    def _row(self, row: Row) -> tuple[float, float]:
        cells = [plain(cell, self.delimiter) for cell in row.cells]
        time, force = self.columns
        return self._value(cells, time, row.line), self._value(cells, force, row.line)

    def _value(self, cells: Sequence[str], column: _Measured, number: int) -> float:
        """Return the number in a cell, the seconds of a time of day, NaN where it says that there is none."""
        if column.place >= len(cells):
            raise ValueError(
                f"line {number} has {len(cells)} column{'s' * (len(cells) != 1)}, {column.name} should be in column "
                f"{column.place} counted from 0"
            )
        cell = cells[column.place]
        if is_missing(cell):
            return math.nan
        if column.name == "time" and self.date is not None and self.date < len(cells) and ":" in cell:
            cell = f"{cells[self.date]} {cell}"
        if column.name == "time" and (seconds := self.clock.seconds(cell)) is not None:
            return seconds
        if NUMBER.fullmatch(cell) and not (column.name == "time" and self.clock.is_used):
            return float(cell)
        is_clock = column.name == "time" and self.clock.is_used
        wanted = "a time of day as in the lines before" if is_clock else "a number"
        hint = f"; times are like 12:00:00.000, with a date such as {DATES}" if ":" in cell else ""
        raise ValueError(
            f"line {number}: {column.name} must be {wanted}, got {validate.short(cell)}{hint}; put # before lines "
            "without data"
        )
