"""Where the table of a measured force begins in a text file, which columns it has, and in which units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.columns import NUMBER, Line, cells_of, content_lines, delimiter_of, is_missing
from floquetrod.rod.loads.record_clock import CLOCK

_DATES = ("date", "datum")
_USUAL = {
    "time": ("time", "t", "timestamp", "datetime", "date/time", "elapsed", "epoch", "zeit", "uhrzeit", *_DATES),
    "force": ("force", "f", "load", "kraft"),
}
"""Headings of a column, or words of them."""

HEAD = 200
"""Lines among which headings are searched for (a choice)."""


class Column(NamedTuple):
    """A column: the argument that chose it, its place, its unit's size in SI, and whether a unit was named."""

    name: str
    place: int
    size: float
    has_unit: bool


class Head(NamedTuple):
    """What a file says before its samples: the separator, headings, the line and how many lines of all to leave out."""

    delimiter: str
    headings: list[str] | None
    units: list[str] | None  # the line below the headings, where it has units and nothing else
    row: list[str]  # the first with samples
    last: int  # number of the last line that is no sample, 0 for none


class Wanted(NamedTuple):
    """What is known of a column beforehand: its argument, the heading or place, and the unit."""

    name: str
    column: str | int | None
    unit: str | None


def head(lines: Sequence[Line], delimiter: str | None, wanted: Sequence[Wanted]) -> Head:
    """Return what the first lines of a file say; lines above the headings that are no table are passed over."""
    texts = list(content_lines(lines))
    if not texts:
        raise ValueError("it holds no samples")
    cells = cells_of(texts[0], delimiter or delimiter_of(texts[0]))
    if len(cells) > 1 and all(is_value(cell) for cell in cells):
        return Head(delimiter or delimiter_of(texts[0]), None, None, cells, 0)
    for at in range(len(texts) - 1):
        if found := _head_at(texts, at, delimiter, wanted):
            return found
    _require_headings(texts, delimiter, wanted)
    if len(cells) < 2:
        raise ValueError(
            f"line {texts[0][0]} has one column, {validate.short(cells[0])}; give delimiter, such as ';', or put # "
            "before lines without data"
        )
    row = cells_of(texts[1], delimiter or delimiter_of(texts[0])) if len(texts) > 1 else []
    return Head(delimiter or delimiter_of(texts[0]), cells, None, row, texts[0][0])


def columns(found: Head, wanted: Sequence[Wanted]) -> tuple[Column, Column, int | None]:
    """Return the columns of time and force, and the place of one with dates beside times of day."""
    time, force = (_column(each, found) for each in wanted)
    if time.place == force.place:
        raise ValueError(f"time and force must be two columns, got column {time.place} for both")
    dates = [i for i, text in enumerate(found.headings or ()) if text.casefold() in _DATES and i != time.place]
    return time, force, dates[0] if len(dates) == 1 else None


def is_value(cell: str) -> bool:
    """Return whether a cell holds a number, or says that one is missing."""
    return is_missing(cell) or any(each.fullmatch(cell) for each in (NUMBER, CLOCK))


def _head_at(texts: Sequence[Line], at: int, delimiter: str | None, wanted: Sequence[Wanted]) -> Head | None:
    """Return the head whose headings are in a line, None where no table with both columns begins there."""
    mark = delimiter or delimiter_of(texts[at])
    try:
        headings, *below = (cells_of(line, mark) for line in texts[at : at + 3])
        if any(is_value(cell) for cell in headings):
            return None
        places = [_place(each, headings, len(headings)) for each in wanted]
    except ValueError:
        return None
    has_units = len(below) > 1 and _are_units(below[0], places, wanted)
    row = below[1 if has_units else 0]
    if len(row) < len(headings) or not all(is_value(row[place]) for place in places):
        return None
    return Head(mark, headings, below[0] if has_units else None, row, texts[at + has_units][0])


def _require_headings(texts: Sequence[Line], delimiter: str | None, wanted: Sequence[Wanted]) -> None:
    """Raise ValueError where a table begins that has not the headings asked for, listing those that it has."""
    if not any(isinstance(each.column, str) for each in wanted):
        return
    for at in range(len(texts) - 1):
        mark = delimiter or delimiter_of(texts[at])
        try:
            headings, *below = (cells_of(line, mark) for line in texts[at : at + 3])
        except ValueError:
            continue
        values = max(sum(cell != "" and is_value(cell) for cell in row[: len(headings)]) for row in below)
        if len(headings) > 1 and values > 1 and not any(is_value(cell) for cell in headings):
            for each in wanted:
                _place(each, headings, len(headings))
            return


def _are_units(cells: Sequence[str], places: Sequence[int], wanted: Sequence[Wanted]) -> bool:
    """Return whether a line below the headings has the units of the columns."""
    if len(cells) <= max(places):
        return False
    named = [(_bare(cells[place]), each.name) for place, each in zip(places, wanted, strict=True)]
    return any(cell for cell, _ in named) and all(not cell or units.is_unit(cell, name) for cell, name in named)


def _bare(cell: str) -> str:
    return cell.strip("[]() ")


def _column(wanted: Wanted, found: Head) -> Column:
    """Return the column of an argument."""
    name, _, unit = wanted
    place = _place(wanted, found.headings, len(found.headings or found.row))
    heading = "" if found.headings is None else found.headings[place]
    if found.units is not None and _bare(found.units[place]):
        heading = _bare(found.units[place])
    if name == "time" and unit is None and place < len(found.row) and CLOCK.fullmatch(found.row[place]):
        return Column(name, place, 1.0, has_unit=True)
    return Column(name, place, _size(name, heading, unit), unit is not None or _parts(heading, name)[1] is not None)


def _place(wanted: Wanted, headings: Sequence[str] | None, many: int) -> int:
    """Return the place of a column: as given, with a usual heading, or that is a unit and nothing else."""
    name, column, _ = wanted
    if isinstance(column, int):
        if column >= many:
            raise validate.wrong_value(name, f"must be a column from 0 to {many - 1}, got {column}")
        return column
    if isinstance(column, str) and headings is None:
        raise validate.wrong_value(name, f"must be the number of a column, got {column!r}: there are no headings")
    listed = headings or ()
    found = _usual(name, listed) if column is None else _headed(column.strip(), listed)
    if not found and column is None and many == 2 and not any(_usual(each, listed) for each in _USUAL):
        return list(_USUAL).index(name)
    if len(found) != 1:
        raise validate.wrong_value(name, _not_one(wanted, len(found), headings, many))
    return found[0]


def _not_one(wanted: Wanted, found: int, headings: Sequence[str] | None, many: int) -> str:
    """Return what is wrong where a column is not found, or several are."""
    what = "a heading of one column" if headings else f"a column from 0 to {many - 1}"
    said = f"and {found or 'none'} of them {'say' if found else 'says'} {wanted.name}"
    said = said if wanted.column is None else f"got {validate.short(wanted.column)}"
    return f"must be {what}, {said}" + (f"; the headings are {', '.join(map(repr, headings))}" if headings else "")


def _headed(heading: str, listed: Sequence[str]) -> list[int]:
    """Return the places of a heading, in its own case or in any."""
    found = [i for i, text in enumerate(listed) if text == heading]
    return found or [i for i, text in enumerate(listed) if text.casefold() == heading.casefold()]


def _usual(name: str, listed: Sequence[str]) -> list[int]:
    """Return the places of usual headings, else of those with a usual word, else of units; dates beside times last."""
    plain = [_parts(text, name)[0].casefold() for text in listed]
    found = [i for i, text in enumerate(plain) if text in _USUAL[name]]
    found = found or [i for i, text in enumerate(listed) if units.is_unit(text, name)]
    found = found or [i for i, text in enumerate(plain) if set(re.split(r"[\W_]+", text)) & set(_USUAL[name])]
    return [i for i in found if plain[i] not in _DATES] or found


def _parts(heading: str, name: str) -> tuple[str, str | None]:
    """Return name and unit of a heading, where "date/time" has no unit."""
    return (heading, None) if heading.casefold() in _USUAL[name] else units.heading(heading, name)


def _size(name: str, heading: str, unit: str | None) -> float:
    """Return the size in SI units of what a column is measured in."""
    if unit is not None:
        return units.unit(unit, f"{name}_unit", name).size
    written = _parts(heading, name)[1]
    if written is None:
        return 1.0
    if not units.is_unit(written, name):
        raise validate.wrong_value(
            f"{name}_unit",
            f"must be given, one of {', '.join(units.units_of(name))}: the heading {heading!r} names none",
        )
    return units.unit(written, "", name).size
