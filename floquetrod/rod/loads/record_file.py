"""Columns of time and force read from a text file."""

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

from floquetrod._util import validate
from floquetrod._util.columns import NUMBER, Line, cells_of, content_lines, is_missing, text_of
from floquetrod.rod.loads.record_clock import DATES, Clock
from floquetrod.rod.loads.record_head import HEAD, Column, Wanted, columns, head

_NOT_PLAIN = re.compile(r'["#]|\r(?!\n)')
"""What lines hold that NumPy's reader reads otherwise than this one."""

_NOT_A_SPACE = re.compile(r"[^\S \n\r]")
_TOGETHER = 20_000  # lines read at once; where one is not plain numbers, each is read alone (a choice)


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
    lines = list(itertools.islice(numbered, HEAD))
    wanted = Wanted("time", time, time_unit), Wanted("force", force, force_unit)
    found = head(lines, delimiter, wanted)
    *chosen, date = columns(found, wanted)
    rows = _Rows(chosen, date, found.delimiter, Clock(time_unit))
    parts = [rows.read(lines[found.last :])]
    while lines := list(itertools.islice(numbered, _TOGETHER)):
        parts.append(rows.read(lines))
    samples = np.concatenate([np.empty((0, 2)), *parts])
    if not samples.size:
        raise ValueError("it holds no samples below its headings")
    times, forces = (samples * [column.size for column in chosen]).T
    return Columns(times, forces, chosen[1].has_unit)


class _Rows:
    """Reads the numbers of two columns, many lines at a time where they are plain numbers, else line by line."""

    def __init__(self, columns: Sequence[Column], date: int | None, delimiter: str, clock: Clock) -> None:
        self.columns = columns
        self.date = date
        self.delimiter = delimiter
        self.clock = clock

    def read(self, lines: list[Line]) -> NDArray[np.float64]:
        """Return the numbers of lines, (n, 2)."""
        found = self._at_once(lines)
        return self.careful(lines) if found is None else found

    def careful(self, lines: Iterable[Line]) -> NDArray[np.float64]:
        """Return the numbers of lines, (n, 2); ValueError for the first that cannot be read."""
        rows = [self._row(number, cells_of((number, text), self.delimiter)) for number, text in content_lines(lines)]
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

    def _value(self, cells: Sequence[str], column: Column, number: int) -> float:
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
