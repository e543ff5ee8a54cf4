"""Numbers, units and marks of lost values in the cells of a table."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from floquetrod.tables.clock import CLOCK

_LOST = {
    *("", "nan", "na", "n/a", "#n/a", "null", "none", "lost", "absent", "missing"),
    *("ol", "o.l", "ovl", "ovld", "ovfl", "overload", "overflow", "overrange", "underrange"),
}
_LOST_NUMBERS = {"999.25", "9999", "9999.25", "99999", "99999.25"}
"""Numbers of logs that stand for no value, with either sign: no angle is as large, and few depths are these."""

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
"""A number in a cell."""

_MARKED = re.compile(r"[-+]?(\d[\d.,'\u2019 \u00a0\u2009\u202f]*|[.,]\d+)([eE][-+]?\d+)?", re.ASCII)
_WITH_UNIT = re.compile(r"(.*[\d.,])\s*([^\d\s.,+-][^\d]*)")
_SPACES = re.compile(r"[-+]?\d{1,3}(['\u2019 \u00a0\u2009\u202f])\d{3}(\1\d{3})*([.,]\d*)?", re.ASCII)
_GROUPS = {mark: re.compile(rf"[-+]?[1-9]\d{{0,2}}(\{mark}\d{{3}})+", re.ASCII) for mark in ",."}
_COMMAS = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?", re.ASCII)


def is_missing(cell: str) -> bool:
    """Return whether a cell marks a missing value, such as loggers write beyond their range.

    >>> [is_missing(cell) for cell in ("", "---", "NaN", "OVLD", "+OL", "Over Range", "0", "Load")]
    [True, True, True, True, True, True, False, False]
    """
    return re.sub(r"[\s_\u2013\u2014-]", "", cell.casefold()).strip("+.*") in _LOST


def is_lost_number(cell: str) -> bool:
    """Return whether a cell has a number that logs write in place of a lost value.

    >>> [is_lost_number(cell) for cell in ("-999.25", "-999.2500", "-9999", "999.3", "99.25")]
    [True, True, True, False, False]
    """
    number = cell.lstrip("+-")
    return (number.rstrip("0").rstrip(".") if "." in number else number) in _LOST_NUMBERS or number == "999.2500"


def is_numeric(cell: str) -> bool:
    """Return whether a cell is a number, whatever its decimal mark, perhaps with a degree sign."""
    return _MARKED.fullmatch(cell.rstrip("°º˚ ")) is not None


def is_value(cell: str) -> bool:
    """Return whether a cell holds a number or a time, or says that one is missing."""
    return is_missing(cell) or is_numeric(cell) or CLOCK.fullmatch(cell) is not None


def split_unit(cell: str) -> tuple[str, str]:
    """Return number and unit of a cell.

    >>> split_unit("30°"), split_unit("1500 m"), split_unit("-999.25"), split_unit("1e3")
    (('30', '°'), ('1500', 'm'), ('-999.25', ''), ('1e3', ''))
    """
    match = None if _MARKED.fullmatch(cell) else _WITH_UNIT.fullmatch(cell)
    return (match[1], match[2].strip()) if match else (cell, "")


def plain(cell: str, delimiter: str) -> str:
    """Return a number with a point before its decimals, any other cell unchanged.

    Where commas separate columns, one within a cell was in quotes and may stand between thousands; elsewhere a single
    comma stands before decimals.

    >>> plain("1,500.25", ","), plain("1500,25", ";")
    ('1500.25', '1500.25')
    """
    if delimiter == ",":
        return cell.replace(",", "") if _COMMAS.fullmatch(cell) else cell
    return cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell


class Marks(NamedTuple):
    """The mark before decimals in a table; the other one of point and comma stands between thousands."""

    decimal: str

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, None for another cell.

        >>> Marks(".").number("1,250.5"), Marks(",").number("1.250,5"), Marks(".").number("1 250.5")
        (1250.5, 1250.5, 1250.5)
        """
        if _SPACES.fullmatch(cell):
            cell = re.sub(r"['\u2019 \u00a0\u2009\u202f]", "", cell)
        group = "," if self.decimal == "." else "."
        whole, mark, decimals = cell.partition(self.decimal)
        if group in whole:
            if _GROUPS[group].fullmatch(whole) is None:
                return None
            whole = whole.replace(group, "")
        text = whole + mark.replace(",", ".") + decimals
        return float(text) if NUMBER.fullmatch(text) else None


class Placed(NamedTuple):
    """A cell with the number of its line, and whether it is of the column that increases from row to row."""

    line: int
    text: str
    is_increasing: bool = False


def marks_of(cells: Sequence[Placed], delimiter: str) -> Marks:
    """Return the mark before decimals in all cells of a table.

    A cell such as 600,5 or 1.250,5 decides; 2,000 may be two thousand or two, which the column that increases, or a
    comma between columns, may decide.  ValueError, with the line, where nothing does or cells contradict each other.
    """
    sure: dict[str, Placed] = {}
    unsure: dict[str, list[Placed]] = {",": [], ".": []}
    for cell in cells:
        for mark, is_sure in _evidence(cell.text):
            if is_sure:
                sure.setdefault(mark, cell)
            else:
                unsure[mark].append(cell)
    if len(sure) == 2:
        point, comma = sure["."], sure[","]
        raise ValueError(
            f"line {point.line} has {point.text!r} and line {comma.line} has {comma.text!r}, points and commas before "
            "decimals or between thousands; write one of them before decimals, and nothing between thousands"
        )
    decimal = next(iter(sure), None)
    doubtful = unsure["," if decimal == "." else "."] if decimal else [*unsure[","], *unsure["."]]
    if not doubtful:
        return Marks(decimal or ".")
    mark = "," if "," in doubtful[0].text else "."
    group = "." if mark == "," else ","
    if delimiter == "," and decimal != ",":
        return Marks(".")
    as_groups, as_decimals = (_increases(cells, decimal or other, are) for are, other in ((False, group), (True, mark)))
    if as_groups and not as_decimals:
        return Marks(group)
    if as_decimals and not as_groups and decimal is None:
        return Marks(mark)
    cell = doubtful[0]
    whole = cell.text.replace(mark, "")
    raise ValueError(
        f"line {cell.line} has {cell.text!r}, which may be {whole} or {float(cell.text.replace(',', '.')):g}; write "
        "numbers without marks between thousands, and decimals behind a point"
    )


def _evidence(cell: str) -> list[tuple[str, bool]]:
    """Return which mark stands before decimals by one cell, and whether that is sure."""
    text = re.sub(r"['\u2019 \u00a0\u2009\u202f+-]", "", split_unit(cell)[0])
    marks = [mark for mark in ",." if mark in text]
    if len(marks) == 2:
        return [("," if text.rfind(",") > text.rfind(".") else ".", True)]
    if not marks or not is_numeric(text):
        return []
    mark = marks[0]
    if text.count(mark) > 1:
        return [("." if mark == "," else ",", True)]
    return [(mark, _GROUPS[mark].fullmatch(text) is None)]


def _increases(cells: Sequence[Placed], decimal: str, doubtful_are_decimals: bool) -> bool:
    """Return whether the column that increases does, with doubtful marks before decimals or between thousands."""
    last = float("-inf")
    for cell in cells:
        if not cell.is_increasing:
            continue
        text = split_unit(cell.text)[0]
        is_doubtful = any(not is_sure for _, is_sure in _evidence(text))
        both = text.replace(",", ".") if doubtful_are_decimals else text.replace(",", "").replace(".", "")
        value = float(both) if is_doubtful and NUMBER.fullmatch(both) else Marks(decimal).number(text)
        if value is not None:
            if value < last:
                return False
            last = value
    return True
