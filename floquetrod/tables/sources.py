"""Where the rows of a table come from: text, a log in LAS, or a sheet of a workbook."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from floquetrod._util import validate
from floquetrod._util.extras import pandas
from floquetrod.tables.text import Line, Row, delimiters_of, lines_of, rows_of, text_of

WORKBOOKS = (".xlsx", ".xlsm")
"""Ends of names of workbooks."""

_OTHER_BOOKS = {".xls": "an old workbook", ".ods": "a sheet of an office", ".xlsb": "a binary workbook"}


class Source(NamedTuple):
    """The rows of a table for each separator of columns that it may have; its first lines, comments among them."""

    rows: dict[str, list[Row]]
    comments: Sequence[Line] = ()


def source(path: Path, delimiter: str | None, sheet: str | int | None) -> Source:
    """Return the rows of a file: of text by ``delimiter``, of a workbook from ``sheet``."""
    kind = path.suffix.lower()
    if kind in WORKBOOKS:
        if delimiter is not None:
            raise validate.wrong_value("delimiter", f"is for text, got {delimiter!r} for a workbook; leave it out")
        return Source({"\t": _of_workbook(path, sheet)})
    if sheet is not None:
        raise validate.wrong_value("sheet", f"is for workbooks such as {WORKBOOKS[0]}, got {sheet!r} for text")
    if kind in _OTHER_BOOKS:
        raise ValueError(f"it is {_OTHER_BOOKS[kind]}, which is not read; save it as .xlsx or as CSV")
    if kind == ".json":
        raise ValueError("it is JSON, which has no columns; save the stations as CSV")
    lines = lines_of(text_of(path))
    first = next((text.strip() for _, text in lines if text.strip() and not text.startswith("#")), "")
    if first.startswith(("{", "[{")):
        raise ValueError("it is JSON, which has no columns; save the stations as CSV")
    if re.match(r"~\s*V", first, re.IGNORECASE):
        return Source({" ": of_las(lines)})
    rows = {mark: list(rows_of(lines, mark)) for mark in delimiters_of(lines, delimiter)}
    return Source(rows, [(number, text.strip().lstrip("#").strip()) for number, text in lines if text[:1] == "#"])


_LAS_LINE = re.compile(r"\s*([^.\s][^.]*?)\s*\.([^\s:]*)\s*(.*?)\s*(?::([^:]*))?$")


def of_las(lines: Sequence[Line]) -> list[Row]:
    """Return the rows of a log in LAS 1.2 or 2.0: headings with their units first; lost values are empty.

    Source: Canadian Well Logging Society, LAS version 2.0 (2017).
    """
    section, lost, names, rows = "", None, [], []
    for number, text in lines:
        line = text.strip()
        if not line or line.startswith("#"):
            continue
        if line.startswith("~"):
            section = line[1:2].upper()
            continue
        if section == "A":
            cells = re.split(r"[ \t]+", line)
            rows.append(Row(number, ["" if _is(cell, lost) else cell for cell in cells], line))
            continue
        match = _LAS_LINE.fullmatch(line)
        if match is None:
            continue
        word, unit, value, _ = match.groups()
        if section == "V" and word.upper() == "VERS" and not value.startswith(("1", "2")):
            raise ValueError(
                f"line {number}: it is LAS {value}, of which versions 1.2 and 2.0 are read; save it as CSV"
            )
        if section == "V" and word.upper() == "WRAP" and value.upper().startswith("Y"):
            raise ValueError(f"line {number}: it is LAS with wrapped lines; save it unwrapped, or as CSV")
        if section == "W" and word.upper() == "NULL":
            lost = value
        if section == "C":
            names.append(f"{word} ({unit})" if unit else word)
    heading = Row(rows[0].line - 1 if rows else 0, names, " ".join(names))
    return [heading, *(_of_width(row, len(names)) for row in rows)]


def _is(cell: str, lost: str | None) -> bool:
    """Return whether a cell has the number that a log writes for no value."""
    try:
        return lost is not None and float(cell) == float(lost)
    except ValueError:
        return False


def _of_width(row: Row, many: int) -> Row:
    if len(row.cells) != many:
        raise ValueError(f"line {row.line} has {len(row.cells)} values below {many} curves")
    return row


def _of_workbook(path: Path, sheet: str | int | None) -> list[Row]:
    """Return the rows of a sheet, the first one by default; several sheets without a choice are refused."""
    if not path.is_file():
        raise ValueError("there is no such file")
    try:
        read = pandas("xlsx")
        import openpyxl  # noqa: F401 - which pandas reads workbooks with
    except ImportError:
        raise ValueError(
            "it is a workbook, which needs pandas and openpyxl: pip install floquetrod[xlsx]; or save it as CSV"
        ) from None
    try:
        book = read.ExcelFile(path, engine="openpyxl")
    except Exception as error:  # of zip, XML or openpyxl
        raise ValueError(f"it is no workbook that can be read: {error}") from None
    with book:
        names = [str(name) for name in book.sheet_names]
        chosen = _sheet(names, sheet, lambda name: _cells(book, name))
        return _cells(book, chosen)


def _sheet(names: Sequence[str], sheet: str | int | None, cells: Callable[[str], list[Row]]) -> str:
    """Return the name of the sheet that is chosen, or the only one that is filled."""
    if isinstance(sheet, int) and sheet < len(names):
        return names[sheet]
    if isinstance(sheet, str) and sheet in names:
        return sheet
    filled = [name for name in names if len(cells(name)) > 1]
    if sheet is None and len(filled) == 1:
        return filled[0]
    got = f"got {sheet!r}" if sheet is not None else f"{len(filled)} of them are filled"
    raise validate.wrong_value("sheet", f"must be one of {', '.join(map(repr, names))}, {got}")


def _cells(book: object, name: str) -> list[Row]:
    """Return the rows of a sheet as texts, numbers with all their digits."""
    frame = book.parse(name, header=None, dtype=object)  # type: ignore[attr-defined]
    rows = [
        Row(number, [_text(cell) for cell in values], "\t".join(_text(cell) for cell in values).strip())
        for number, values in enumerate(frame.itertuples(index=False), 1)
    ]
    return [row for row in rows if any(row.cells)]


def _text(cell: object) -> str:
    """Return a cell as text, "" for an empty one."""
    if cell is None or cell != cell:
        return ""
    if isinstance(cell, float | int) and not isinstance(cell, bool):
        return repr(int(cell)) if float(cell).is_integer() and abs(cell) < 1e15 else repr(float(cell))
    return re.sub(r"\s+", " ", str(cell)).strip()
