"""Columns of time and force read from a text file."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate

_LARGEST = 1 << 29  # bytes of a file that are read, ten million samples or so (a choice)
_DEFAULTS = {"time": ("time", "t"), "force": ("force", "f")}
_MISSING = ("", "nan", "na", "n/a")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_BRACKETS = re.compile(r"(.*?)\s*(?:[\[(]\s*([^\[\]()]*?)\s*[\])]|/\s*(\S+))")
_LAST_WORD = re.compile(r"(.+?)[\s_]+(\S+)")

Line = tuple[int, list[str]]


class _Column(NamedTuple):
    """A column: the argument that chose it, its place, and what its numbers are multiplied by."""

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
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times (s) and forces (N) of a file, NaN where a cell is empty; ValueError names line and column.

    `floquetrod.ForceRecord.from_csv` says what is accepted.
    """
    lines = _lines(_text(path), delimiter)
    first = next(lines, None)
    if first is None:
        raise ValueError("it holds no samples")
    number, cells = first
    if len(cells) < 2:
        raise ValueError(f"line {number} has one column, {validate.short(cells[0])}; give delimiter, such as ';'")
    headings = None if all(_is_value(cell) for cell in cells) else cells
    columns = [
        _column("time", time, headings, len(cells), time_unit),
        _column("force", force, headings, len(cells), force_unit),
    ]
    if columns[0].place == columns[1].place:
        raise ValueError(f"time and force must be two columns, got column {columns[0].place} for both")
    rows = _rows(lines if headings else _with(first, lines), columns)
    samples: NDArray[np.float64] = np.array(list(rows)).reshape(-1, 2)
    if not samples.size:
        raise ValueError("it holds no samples below its headings")
    return samples[:, 0] * columns[0].size, samples[:, 1] * columns[1].size


def _text(path: Path) -> str:
    """Return the text of a file."""
    if not path.is_file():
        raise ValueError("it is a folder or a device" if path.exists() else "there is no such file")
    if path.stat().st_size > _LARGEST:
        raise ValueError(f"it has {path.stat().st_size:,} bytes, at most {_LARGEST:,} are read")
    content = path.read_bytes()
    if b"\0" in content:
        raise ValueError("it is not text in UTF-8 but binary, or text of another encoding; save it as CSV in UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(f"line {line} is not text in UTF-8; save it as CSV in UTF-8") from None


def _lines(text: str, delimiter: str | None) -> Iterator[Line]:
    """Yield the number and the cells of each line that is neither empty nor a comment."""
    stripped = ((number, line.strip(" \r\n")) for number, line in enumerate(io.StringIO(text), 1))
    lines = ((number, line) for number, line in stripped if line.strip() and not line.startswith("#"))
    for number, line in lines:
        if delimiter is None:
            delimiter = next((mark for mark in ";\t," if mark in line), " ")
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True, strict=True))
        except (csv.Error, StopIteration) as error:
            raise ValueError(f"line {number} cannot be read: {error}") from None
        if delimiter != ",":
            cells = [cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell for cell in cells]
        yield number, [cell.strip() for cell in cells]


def _with(first: Line, others: Iterator[Line]) -> Iterator[Line]:
    yield first
    yield from others


def _is_value(cell: str) -> bool:
    """Return whether a cell holds a number, or says that one is missing."""
    return cell.lower() in _MISSING or _NUMBER.fullmatch(cell) is not None


def _column(
    name: str, wanted: str | int | None, headings: Sequence[str] | None, many: int, unit: str | None
) -> _Column:
    """Return the column of an argument."""
    if isinstance(wanted, str) and headings is None:
        raise ValueError(f"{name} must be the number of a column, 0 for the first, as line 1 has no headings")
    if isinstance(wanted, int):
        if wanted >= many:
            raise ValueError(f"{name} must be a column from 0 to {many - 1}, got {wanted}")
        place = wanted
    else:
        place = _place(name, wanted, headings, many)
    heading = "" if headings is None else headings[place]
    return _Column(name, place, _size(name, heading, unit))


def _place(name: str, wanted: str | None, headings: Sequence[str] | None, many: int) -> int:
    """Return the place of the column with a heading, or with the usual one."""
    listed = headings or ()
    if wanted is None:
        found = [i for i, text in enumerate(listed) if _plain(text, name).casefold() in _DEFAULTS[name]]
        if not found and many == 2:
            others = [_plain(text, other).casefold() in _DEFAULTS[other] for other in _DEFAULTS for text in listed]
            if not any(others):
                return list(_DEFAULTS).index(name)
    else:
        found = [i for i, text in enumerate(listed) if text == wanted.strip()]
        found = found or [i for i, text in enumerate(listed) if text.casefold() == wanted.strip().casefold()]
    if len(found) != 1:
        what = "a heading of one column" if headings else f"a column from 0 to {many - 1}"
        raise ValueError(
            f"{name} must be {what}, got {validate.short(wanted)}"
            + (f"; the headings are {', '.join(map(repr, listed))}" if listed else "")
        )
    return found[0]


def _parts(heading: str, name: str) -> tuple[str, str | None]:
    """Return the name and the unit of a heading, None without one; a last word counts where it is a unit."""
    if match := _BRACKETS.fullmatch(heading):
        return match[1], match[2] or match[3] or ""
    match = _LAST_WORD.fullmatch(heading)
    if match and any(unit == match[2] for unit in units.units_of(name)):
        return match[1], match[2]
    return heading, None


def _plain(heading: str, name: str) -> str:
    return _parts(heading, name)[0]


def _size(name: str, heading: str, unit: str | None) -> float:
    """Return the size in SI units of what a column is measured in."""
    if unit is not None:
        return units.unit(unit, f"{name}_unit", name).size
    written = _parts(heading, name)[1]
    if written is None:
        return 1.0
    try:
        return units.unit(written or "none", "", name).size
    except ValueError:
        raise ValueError(
            f"{name}_unit must be given, one of {', '.join(units.units_of(name))}: the heading {heading!r} names none"
        ) from None


def _rows(lines: Iterator[Line], columns: Sequence[_Column]) -> Iterator[tuple[float, ...]]:
    """Yield the numbers of the columns of each line."""
    for number, cells in lines:
        yield tuple([_value(cells, column, number) for column in columns])


def _value(cells: Sequence[str], column: _Column, number: int) -> float:
    """Return the number in a cell, NaN where it is empty."""
    if column.place >= len(cells):
        raise ValueError(
            f"line {number} has {len(cells)} column{'s' * (len(cells) != 1)}, {column.name} should be in column "
            f"{column.place} counted from 0"
        )
    cell = cells[column.place]
    if _NUMBER.fullmatch(cell):
        return float(cell)
    if cell.lower() in _MISSING:
        return math.nan
    raise ValueError(
        f"line {number}: {column.name} must be a number, got {validate.short(cell)}; put # before lines without data"
    )


def column_argument(name: str, value: Any) -> str | int | None:
    """Return the argument that chooses a column: a heading, a number from 0, or None."""
    if value is None or isinstance(value, str):
        return value
    return validate.integer(name, value, 0, hint="give the heading of a column or its number, 0 for the first")


def delimiter_argument(value: Any) -> str | None:
    """Return the argument ``delimiter``: one character, or None."""
    if value is not None and (not isinstance(value, str) or len(value) != 1 or value in '"#\r\n.-+' or value.isalnum()):
        kind = ValueError if isinstance(value, str) else TypeError
        raise kind(f"delimiter must be one character such as ',', ';' or '\\t', got {validate.short(value)}")
    return value
