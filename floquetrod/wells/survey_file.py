"""The columns of a survey read from a text file."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message
from floquetrod._util.arrays import Floats
from floquetrod._util.columns import NUMBER, Line, cells_of, content_lines, delimiter_of, text_of
from floquetrod.wells.survey import KINDS

HEADINGS = {
    name: tuple(words.split(", "))
    for name, words in {
        "depth": (
            "md, measured depth, meas depth, md rkb, mdepth, depth md, md kb, md rt, survey depth, measured, "
            "dept, depth"
        ),
        "inclination": (
            "inc, incl, devi, inclination, inclin, hole inclination, hole angle, deviation, dev, drift, angle"
        ),
        "azimuth": (
            "azi, azimuth, azim, az, azm, hole azimuth, azimuth grid, azi gn, azimuth true, azi tn, hazi, direction"
        ),
    }.items()
}
"""Headings of the columns in small letters without their units; where several are in a file the first counts."""

_UNIT_ROWS = 10  # below headings, more than any file has (a choice)
_USUAL = "'MD (m)', 'Inc (deg)' and 'Azi (deg)'"
_GROUPED = re.compile(r"[-+]?\d{1,3}([ ,.'\u00a0\u2009\u202f]\d{3})+([.,]\d*)?", re.ASCII)  # 1,000.5 and the like
_MAY_BE_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}", re.ASCII)
_PLAIN = re.compile(r"[\s_.:\-]+")


class SurveyFile(NamedTuple):
    """Depths in m and angles in rad, the line of each station, and how they were read.

    Inclinations are ``in_degrees`` by their heading or for want of one, not by an argument; ``depth_unit`` is the unit
    of depths in the file.
    """

    depth: Floats
    inclination: Floats
    azimuth: Floats
    lines: Sequence[int]
    has_headings: bool
    in_degrees: bool
    depth_unit: str


class _Column(NamedTuple):
    name: str
    place: int
    unit: str | None


def read(
    path: Path, wanted: dict[str, str | int | None], given: dict[str, str | None], delimiter: str | None
) -> SurveyFile:
    """Return the stations in a file; ValueError names line and station.

    ``wanted`` chooses columns and ``given`` their units, see `floquetrod.WellPath.from_csv`.
    """
    lines = list(content_lines(enumerate(io.StringIO(text_of(path), newline=None), 1)))
    if not lines:
        raise ValueError("it holds no stations")
    first, columns, delimiter = _headed(lines, wanted, delimiter)
    if len(lines) - first > validate.MOST_NUMBERS + _UNIT_ROWS:
        raise ValueError(f"it holds {len(lines) - first} stations, at most {validate.MOST_NUMBERS} are read")
    _require_one_mark(lines[first:], columns, delimiter)
    rows = [(number, cells_of((number, text), delimiter)) for number, text in lines[first:]]
    columns, skipped = _with_unit_rows(columns, rows)
    rows = [(number, cells) for number, cells in rows[skipped:] if any(cells)]
    _require_as_wide(lines[first - 1] if first else None, rows, delimiter, len(columns))
    units_of = {c.name: _unit(c, given[c.name]) for c in columns}
    columns_in_si = {c.name: units_of[c.name].size * np.array(_numbers(c, rows)) for c in columns}
    azimuth, stations = columns_in_si.get("azimuth", np.zeros(len(rows))), [number for number, _ in rows]
    in_degrees = given["inclination"] is None and units_of["inclination"].size != 1.0
    is_named = first > 0 or None not in wanted.values()
    depths, inclinations = columns_in_si["depth"], columns_in_si["inclination"]
    return SurveyFile(depths, inclinations, azimuth, stations, is_named, in_degrees, units_of["depth"].name)


def _require_as_wide(headings: Line | None, rows: Sequence[tuple[int, list[str]]], delimiter: str, chosen: int) -> None:
    """Raise ValueError where a line holds more cells than headings, as with decimal commas between commas.

    Between spaces a comment of several words may, but no azimuth that has no heading.
    """
    if headings is None or (delimiter == " " and chosen > 2):
        return
    many = len(cells_of(headings, delimiter))
    for station, (line, cells) in enumerate(rows, 1):
        if any(cells[many:]):
            remedy = "; with decimal commas separate columns by semicolons" if delimiter == "," else ""
            raise ValueError(
                f"line {line}, station {station}: it holds {len(cells)} cells below {many} headings{remedy}"
            )


def _require_one_mark(lines: Sequence[Line], columns: Sequence[_Column], delimiter: str) -> None:
    """Raise ValueError where commas may stand before decimals or between thousands."""
    if delimiter == ",":
        return
    with_comma: list[tuple[int, str]] = []
    with_point: list[tuple[int, str]] = []
    for line, text in lines:
        cells = [cell.strip(' "') for cell in text.split(delimiter)]
        chosen = [cells[c.place] for c in columns if c.place < len(cells)]
        with_comma += [(line, cell) for cell in chosen if cell.count(",") == 1 and "." not in cell]
        with_point += [(line, cell) for cell in chosen if "." in cell and NUMBER.fullmatch(cell)]
    if with_comma and with_point:
        line, cell = with_point[0]
        raise ValueError(
            f"line {line} has {cell!r} and line {with_comma[0][0]} has {with_comma[0][1]!r}, points and commas before "
            "decimals or between thousands; write one of them before decimals, and nothing between thousands"
        )
    if with_comma and all(_MAY_BE_GROUPED.fullmatch(cell) for _, cell in with_comma):
        line, cell = with_comma[0]
        whole = cell.replace(",", "")
        raise ValueError(
            f"line {line} has {cell!r}, which may be {whole} or {float(cell.replace(',', '.')):g}; write numbers "
            "without marks between thousands, and decimals behind a point"
        )


def _headed(
    lines: Sequence[Line], wanted: dict[str, str | int | None], delimiter: str | None
) -> tuple[int, list[_Column], str]:
    """Return the index of the first line below the headings, the columns and their separator.

    Lines before the headings, such as the name of a well, are passed over.
    """
    seen, most, choices = lines[0], 0, list(wanted.values())
    for i, line in enumerate(lines):
        mark = delimiter or delimiter_of(line)
        cells = cells_of(line, mark)
        if _is_row(cells):
            if any(isinstance(choice, str) for choice in choices) or (i and None in choices):
                break  # the lines above it should have been headings
            return i, _columns(wanted, None, _width(lines[i:], mark)), mark
        known = {name for name, choice in wanted.items() if _found(name, choice, cells)}
        if known >= wanted.keys() - {"azimuth"}:
            return i + 1, _columns(wanted, cells, len(cells)), mark
        if len(known) >= most:
            seen, most = line, len(known)
    else:
        seen = lines[0]
    usual = ", ".join(validate.short(choice) for choice in choices if isinstance(choice, str)) or _USUAL
    raise ValueError(
        Message(
            f"line {seen[0]} should have headings such as {usual}, got {validate.short(seen[1])}",
            Mention("", "; name the columns by depth, inclination and azimuth"),
        )
    )


def _is_row(cells: Sequence[str]) -> bool:
    """Return whether all filled cells are numbers, two at least."""
    full = [cell for cell in cells if cell]
    return len(full) > 1 and all(map(NUMBER.fullmatch, full))


def _width(lines: Sequence[Line], delimiter: str) -> int:
    """Return the most cells that a line of numbers fills: the first station may leave its azimuth out."""
    rows = filter(_is_row, (cells_of(line, delimiter) for line in lines))
    return max(max(place for place, cell in enumerate(cells, 1) if cell) for cells in rows)


def _columns(wanted: dict[str, str | int | None], headings: Sequence[str] | None, many: int) -> list[_Column]:
    """Return depth, inclination and, where there is one, azimuth."""
    columns = []
    for order, (name, choice) in enumerate(wanted.items()):
        places = [order] if headings is None and choice is None else _found(name, choice, headings or [])
        if isinstance(choice, int) and not choice < many:
            raise validate.wrong_value(name, f"must be a column from 0 to {many - 1}, got {choice}")
        if name == "azimuth" and choice is None and many == 2:
            continue  # a well in one plane
        if len(places) != 1 or places[0] >= many:
            count_of_matches = f"{len(places)} columns may be it" if len(places) > 1 else "no column is known to be it"
            got = count_of_matches if choice is None else f"got {validate.short(choice)}"
            listed = f"; the headings are {', '.join(map(repr, headings))}" if headings else ""
            raise validate.wrong_value(name, f"must be the heading of one column or its number, {got}{listed}")
        unit = None if headings is None else units.heading(headings[places[0]], KINDS[name])[1]
        columns.append(_Column(name, places[0], unit))
    if len({column.place for column in columns}) < len(columns):
        raise ValueError("depth, inclination and azimuth must be different columns")
    return columns


def _found(name: str, choice: str | int | None, headings: Sequence[str]) -> list[int]:
    """Return the indices of the columns that match."""
    if isinstance(choice, int):
        return [choice]
    if choice is not None:
        heading_wanted = choice.strip().casefold()
        return [i for i, heading in enumerate(headings) if heading.casefold() == heading_wanted]
    plain = [_PLAIN.sub(" ", units.heading(text, KINDS[name])[0]).strip().casefold() for text in headings]
    usual = next((usual_heading for usual_heading in HEADINGS[name] if usual_heading in plain), None)
    return [i for i, text in enumerate(plain) if text == usual]


def _with_unit_rows(columns: list[_Column], rows: Sequence[tuple[int, list[str]]]) -> tuple[list[_Column], int]:
    """Return the columns with the units in lines below their headings, and the number of such lines."""
    for skipped, (_, cells) in enumerate(rows):
        below = [cells[c.place].strip(" ()[]") if c.place < len(cells) else "" for c in columns]
        is_unit = [units.is_unit(cell, KINDS[c.name]) for c, cell in zip(columns, below, strict=True)]
        if not is_unit[0] and below[0].casefold() not in HEADINGS["depth"]:
            return columns, skipped
        named = zip(columns, below, is_unit, strict=True)
        columns = [c._replace(unit=cell) if is_named else c for c, cell, is_named in named]
    return columns, len(rows)


def _numbers(column: _Column, rows: Sequence[tuple[int, list[str]]]) -> list[float]:
    """Return the numbers in a column."""
    numbers = []
    for station, (line, cells) in enumerate(rows, 1):
        cell = cells[column.place] if column.place < len(cells) else ""
        if not NUMBER.fullmatch(cell):
            hint = "write a point before decimals, or separate columns by semicolons" if "," in cell else ""
            hint = "write numbers without marks between thousands" if _GROUPED.fullmatch(cell) else hint
            hint = hint or ("fill it in" if not cell and station == 1 else "put # before lines without data")
            raise ValueError(
                f"line {line}, station {station}: {column.name} must be a number, got {validate.short(cell)}; {hint}"
            )
        numbers.append(float(cell))
    return numbers


def _unit(column: _Column, given: str | None) -> units.Unit:
    """Return the unit of a column: degrees where no unit of an angle is named."""
    kind, argument = KINDS[column.name], "depth_unit" if column.name == "depth" else "angle_unit"
    unit = given or column.unit
    if unit is None and column.name != "depth":
        return units.unit("deg", argument, kind)
    if unit is not None and units.is_unit(unit, kind):
        return units.unit(unit, argument, kind)
    why = "names none" if unit is None else f"names {unit!r}"
    raise validate.wrong_value(
        argument, f"must be given, such as {'m or ft' if kind == 'length' else 'deg or rad'}: the heading {why}"
    )
