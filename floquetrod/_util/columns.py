"""Text files of columns: their lines, cells and numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from floquetrod._util import validate
from floquetrod._util.sealed_files import require_regular

_LARGEST = 1 << 29  # bytes of a file that are read, ten million samples or so

_MISSING = {
    *("", "nan", "na", "n/a", "#n/a", "null"),
    *("ol", "o.l", "ovl", "ovld", "ovfl", "overload", "overflow", "overrange", "underrange"),
}
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?", re.ASCII)

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
"""A number in a cell."""


def is_missing(cell: str) -> bool:
    """Return whether a cell marks a missing value, such as loggers write beyond their range.

    >>> [is_missing(cell) for cell in ("", "---", "NaN", "OVLD", "+OL", "Over Range", "0", "Load")]
    [True, True, True, True, True, True, False, False]
    """
    return re.sub(r"[\s_-]", "", cell.casefold()).strip("+.") in _MISSING


Line = tuple[int, str]
"""A line that is neither empty nor a comment, without spaces at its ends, and its number."""


def text_of(path: Path) -> str:
    """Return the text of a file."""
    require_regular(path, _LARGEST)
    content = path.read_bytes()
    if b"\0" in content:
        raise ValueError("it is not text in UTF-8 but binary, or text of another encoding; save it as CSV in UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
    try:
        return content.decode("cp1252")
    except UnicodeDecodeError:
        raise ValueError(f"line {line} is not text in UTF-8; save it as CSV in UTF-8") from None


def content_lines(numbered: Iterable[Line]) -> Iterator[Line]:
    """Yield the lines other than empty ones and comments."""
    stripped = ((number, line.strip(" \r\n")) for number, line in numbered)
    return ((number, line) for number, line in stripped if line.strip() and not line.startswith("#"))


def delimiter_of(line: Line) -> str:
    """Return the delimiter of columns: the first of semicolon, tab, comma and space that a line holds."""
    return next((mark for mark in ";\t," if mark in line[1]), " ")


def cells_of(line: Line, delimiter: str) -> list[str]:
    """Return the cells of a line, decimal commas as points where commas separate no columns.

    Where they do, a comma within a cell was in quotes and may stand between thousands, as spreadsheets write them.

    >>> cells_of((1, '"1,500.25",90'), ","), cells_of((1, "1500,25;90"), ";")
    (['1500.25', '90'], ['1500.25', '90'])
    """
    number, text = line
    try:
        cells = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True, strict=True))
    except (csv.Error, StopIteration) as error:
        raise ValueError(f"line {number} cannot be read: {error}") from None
    if delimiter != ",":
        cells = [cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell for cell in cells]
    cells = [cell.strip() for cell in cells]
    return (
        [cell.replace(",", "") if _GROUPED.fullmatch(cell) else cell for cell in cells] if delimiter == "," else cells
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
