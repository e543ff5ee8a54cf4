"""Columns of time and force read from a text file."""

from __future__ import annotations

import datetime
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
from floquetrod._util.columns import MISSING, NUMBER, Line, cells_of, delimiter_of, text_of, written

_DEFAULTS = {"time": ("time", "t", "timestamp", "date", "datetime", "date/time"), "force": ("force", "f")}
_CLOCK = re.compile(
    r"(?:(\d{4}-\d\d-\d\d)[T ])?([01]?\d|2[0-3]):([0-5]\d):([0-5]\d(?:\.\d*)?)\s*([Zz]|[-+]\d\d(?::?\d\d)?)?", re.ASCII
)
_NOT_PLAIN = re.compile(r'["#]|\r(?!\n)')
"""What lines hold that NumPy's reader reads otherwise than this one."""

_NOT_A_SPACE = re.compile(r"[^\S \n\r]")
_TOGETHER = 20_000  # lines read at once; where one is not plain numbers, each is read alone (a choice)


class _Column(NamedTuple):
    """A column: the argument that chose it, its place, its unit's size in SI, and whether a unit was named."""

    name: str
    place: int
    size: float
    has_unit: bool


class Columns(NamedTuple):
    """Times in s and forces in N, NaN where a cell is empty, and whether a unit of force was named."""

    time: NDArray[np.float64]
    force: NDArray[np.float64]
    has_unit: bool


def read_columns(
    path: Path,
    time: str | int | None,
    force: str | int | None,
    time_unit: str | None,
    force_unit: str | None,
    delimiter: str | None,
) -> Columns:
    """Return the samples of a file; ValueError names line and column.

    `floquetrod.ForceRecord.from_csv` says what is accepted.
    """
    numbered = enumerate(io.StringIO(text_of(path)), 1)
    first = next(written(numbered), None)
    if first is None:
        raise ValueError("it holds no samples")
    delimiter = delimiter or delimiter_of(first)
    cells = cells_of(first, delimiter)
    if len(cells) < 2:
        raise ValueError(f"line {first[0]} has one column, {validate.short(cells[0])}; give delimiter, such as ';'")
    headings = None if all(_is_value(cell) for cell in cells) else cells
    columns = (
        _column("time", time, headings, len(cells), time_unit),
        _column("force", force, headings, len(cells), force_unit),
    )
    if columns[0].place == columns[1].place:
        raise ValueError(f"time and force must be two columns, got column {columns[0].place} for both")
    rows = _Rows(columns, delimiter, _Clock(time_unit))
    parts = [] if headings else [rows.careful([first])]
    while lines := list(itertools.islice(numbered, _TOGETHER)):
        parts.append(rows.read(lines))
    samples = np.concatenate([np.empty((0, 2)), *parts])
    if not samples.size:
        raise ValueError("it holds no samples below its headings")
    return Columns(samples[:, 0] * columns[0].size, samples[:, 1] * columns[1].size, columns[1].has_unit)


class _Rows:
    """Reads the numbers of two columns, many lines at a time where they are plain numbers, else line by line."""

    def __init__(self, columns: tuple[_Column, _Column], delimiter: str, clock: _Clock) -> None:
        self.columns = columns
        self.delimiter = delimiter
        self.clock = clock

    def read(self, lines: list[Line]) -> NDArray[np.float64]:
        """Return the numbers of lines, (n, 2)."""
        found = self._at_once(lines)
        return self.careful(lines) if found is None else found

    def careful(self, lines: Iterable[Line]) -> NDArray[np.float64]:
        """Return the numbers of lines, (n, 2); ValueError for the first that cannot be read."""
        rows = [self._row(number, cells_of((number, text), self.delimiter)) for number, text in written(lines)]
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
            found = np.loadtxt(io.StringIO(text), delimiter=delimiter, usecols=places, comments=None, ndmin=2)
        except ValueError:
            return None
        return found if np.isfinite(found).all() and not self.clock.is_used else None

    def _row(self, number: int, cells: Sequence[str]) -> tuple[float, float]:
        time, force = self.columns
        return self._value(cells, time, number), self._value(cells, force, number)

    def _value(self, cells: Sequence[str], column: _Column, number: int) -> float:
        """Return the number in a cell, the seconds of a time of day, NaN where it is empty."""
        if column.place >= len(cells):
            raise ValueError(
                f"line {number} has {len(cells)} column{'s' * (len(cells) != 1)}, {column.name} should be in column "
                f"{column.place} counted from 0"
            )
        cell = cells[column.place]
        if cell.lower() in MISSING:
            return math.nan
        if column.name == "time" and (seconds := self.clock.seconds(cell)) is not None:
            return seconds
        if NUMBER.fullmatch(cell) and not (column.name == "time" and self.clock.is_used):
            return float(cell)
        is_clock = column.name == "time" and self.clock.is_used
        wanted = "a time of day as in the lines before" if is_clock else "a number"
        hint = "; times are like 12:00:00.000 or 2024-01-31 12:00:00.000" if ":" in cell else ""
        raise ValueError(
            f"line {number}: {column.name} must be {wanted}, got {validate.short(cell)}{hint}; put # before lines "
            "without data"
        )


class _Clock:
    """Turns times of day, with dates or without, into seconds from the first midnight."""

    def __init__(self, unit: str | None) -> None:
        self.unit = unit
        self.first: int | None = None  # day of the first date
        self.days = 0  # that have passed where there are no dates
        self.last: float | None = None

    @property
    def is_used(self) -> bool:
        """Whether a time of day has been read."""
        return self.last is not None

    def seconds(self, cell: str) -> float | None:
        """Return the seconds of a time of day, None for another cell; without dates, midnight begins another day."""
        match = _CLOCK.fullmatch(cell)
        if match is None:
            return None
        if self.unit is not None:
            raise validate.wrong_value(
                "time_unit", f"is for numbers, got {self.unit!r} for times of day such as {cell!r}"
            )
        date, hours, minutes, seconds, zone = match.groups()
        time = 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds) - _offset(zone)
        time += 86400.0 * self._day(date, time, cell)
        self.last = time
        return time

    def _day(self, date: str | None, time: float, cell: str) -> int:
        """Return the number of the day of a time, 0 for the first."""
        if self.last is not None and (date is None) != (self.first is None):
            raise validate.wrong_value("time", f"must have a date in every line or in none, got {cell!r}")
        if date is None:
            if self.last is not None and time + 86400.0 * self.days < self.last - 43200.0:
                self.days += 1
            return self.days
        try:
            day = datetime.date.fromisoformat(date).toordinal()
        except ValueError:
            raise validate.wrong_value("time", f"must have dates such as 2024-01-31, got {cell!r}") from None
        self.first = day if self.first is None else self.first
        return day - self.first


def _offset(zone: str | None) -> float:
    """Return the seconds by which a time zone is ahead of UTC."""
    if zone in (None, "", "Z", "z"):
        return 0.0
    hours, minutes = zone[1:3], zone[3:].lstrip(":") or "0"
    return (-1.0 if zone[0] == "-" else 1.0) * (3600.0 * int(hours) + 60.0 * int(minutes))


def _is_value(cell: str) -> bool:
    """Return whether a cell holds a number, or says that one is missing."""
    return cell.lower() in MISSING or any(each.fullmatch(cell) for each in (NUMBER, _CLOCK))


def _column(
    name: str, wanted: str | int | None, headings: Sequence[str] | None, many: int, unit: str | None
) -> _Column:
    """Return the column of an argument."""
    if isinstance(wanted, str) and headings is None:
        raise validate.wrong_value(name, f"must be the number of a column, got {wanted!r}: there are no headings")
    if isinstance(wanted, int):
        if wanted >= many:
            raise validate.wrong_value(name, f"must be a column from 0 to {many - 1}, got {wanted}")
        place = wanted
    else:
        place = _place(name, wanted, headings, many)
    heading = "" if headings is None else headings[place]
    return _Column(
        name, place, _size(name, heading, unit), unit is not None or units.heading(heading, name)[1] is not None
    )


def _place(name: str, wanted: str | None, headings: Sequence[str] | None, many: int) -> int:
    """Return the place of the column with a heading, or with the usual one, or one that is a unit and nothing else."""
    listed = headings or ()
    if wanted is None:
        found = [i for i, text in enumerate(listed) if _plain(text, name).casefold() in _DEFAULTS[name]]
        found = found or [i for i, text in enumerate(listed) if units.is_unit(text, name)]
        if not found and many == 2:
            others = [_plain(text, other).casefold() in _DEFAULTS[other] for other in _DEFAULTS for text in listed]
            if not any(others):
                return list(_DEFAULTS).index(name)
    else:
        found = [i for i, text in enumerate(listed) if text == wanted.strip()]
        found = found or [i for i, text in enumerate(listed) if text.casefold() == wanted.strip().casefold()]
    if len(found) != 1:
        what = "a heading of one column" if headings else f"a column from 0 to {many - 1}"
        raise validate.wrong_value(
            name,
            f"must be {what}, {'and none of them says ' + name if wanted is None else 'got ' + validate.short(wanted)}"
            + (f"; the headings are {', '.join(map(repr, listed))}" if listed else ""),
        )
    return found[0]


def _plain(heading: str, name: str) -> str:
    return units.heading(heading, name)[0]


def _size(name: str, heading: str, unit: str | None) -> float:
    """Return the size in SI units of what a column is measured in."""
    if unit is not None:
        return units.unit(unit, f"{name}_unit", name).size
    written = units.heading(heading, name)[1]
    if written is None:
        return 1.0
    if not units.is_unit(written, name):
        raise validate.wrong_value(
            f"{name}_unit",
            f"must be given, one of {', '.join(units.units_of(name))}: the heading {heading!r} names none",
        )
    return units.unit(written, "", name).size
