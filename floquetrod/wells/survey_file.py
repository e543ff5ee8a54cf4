"""The stations of a survey read from a file: by directions, or by positions along the well."""

from __future__ import annotations

import functools
import itertools
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message, wrong_value
from floquetrod._util.arrays import Floats
from floquetrod.tables.cells import Marks, Placed, is_lost_number, is_missing, is_numeric, marks_of, split_unit
from floquetrod.tables.head import Candidate, Column, Head, Wanted, find_head, unheaded
from floquetrod.tables.sources import Source, source
from floquetrod.tables.text import Row, is_data
from floquetrod.wells.survey_headings import (
    AXES,
    KINDS,
    in_english,
    parts,
    places_of,
    places_of_axis,
    rank,
    rank_of_axis,
)
from floquetrod.wells.survey_positions import directions

_USUAL = "'MD (m)', 'Inc (deg)' and 'Azi (deg)'"
_LABELS = ("well", "wellbore", "well name", "well id", "uwi", "hole", "hole id", "bhid", "borehole", "sidetrack", "api")
_BEARING = re.compile(
    r"([NS])\s*(?:(\d+(?:[.,]\d*)?)\s*(?:[°º˚]|deg)?\s*(?:(\d+(?:[.,]\d*)?)\s*['\u2019\u2032]\s*)?)([EW])",
    re.IGNORECASE,
)
_CHOSEN = {"depth": "DEPTH", "inclination": ",INCLINATION", "azimuth": ",,AZIMUTH"}
"""How the option of the terminal chooses one column alone."""

_QUARTERS = {"N": 0.0, "E": 90.0, "S": 180.0, "W": 270.0}
_NEAR = 1e-3  # of its length, by which a path may miss positions (a choice)
_NEARLY_ALL = 0.5  # of the stations, which must not be lost (a choice)


class SurveyFile(NamedTuple):
    """Depths in m and angles in rad, the line and the number of each station, and how they were read.

    Inclinations are ``in_degrees`` by their heading or for want of one, not by an argument; ``depth_unit`` and
    ``angle_unit`` are the units of the file.  ``notes`` say what was left out, ``doubts`` what may be a mistake.
    """

    depth: Floats
    inclination: Floats
    azimuth: Floats
    lines: Sequence[int]
    stations: Sequence[int]
    has_headings: bool
    in_degrees: bool
    depth_unit: str
    angle_unit: str
    notes: Sequence[str]
    doubts: Sequence[str]


class _Table(NamedTuple):
    """The head of a table, its rows, the mark before decimals, and what was passed over."""

    head: Head
    rows: list[Row]
    marks: Marks
    notes: list[str]


def read(
    path: Path,
    wanted: dict[str, str | int | None],
    given: dict[str, str | None],
    delimiter: str | None,
    sheet: str | int | None = None,
) -> SurveyFile:
    """Return the stations in a file; ValueError names line and station.

    ``wanted`` chooses columns and ``given`` their units, see `floquetrod.WellPath.from_csv`.
    """
    file = source(path, delimiter, sheet)
    if not any(file.rows.values()):
        raise ValueError("it holds no stations")
    columns = [_wanted(name, wanted[name], given[name]) for name in KINDS]
    head, rows = _head(file, columns, given)
    table = _table(head, rows)
    if len(table.rows) > validate.MOST_NUMBERS:
        raise ValueError(f"it holds {len(table.rows)} stations, at most {validate.MOST_NUMBERS} are read")
    _require_one_well(table)
    if {column.name for column in head.columns} == set(AXES):
        return _by_positions(table, given)
    return _by_directions(table, given)


def _wanted(name: str, column: str | int | None, unit: str | None) -> Wanted:
    kind = KINDS[name]
    return Wanted(
        name,
        kind,
        column,
        unit,
        functools.partial(places_of, name),
        lambda text: parts(text, kind)[1],
        is_optional=name == "azimuth",
        remedy=Mention("survey_columns", name, _CHOSEN[name]),
        may_be_unnamed=True,
    )


def _axes(given: dict[str, str | None]) -> list[Wanted]:
    """Return the columns of a survey by positions."""
    unit = given["depth"]
    return [
        Wanted(name, kind, None, unit, functools.partial(places_of_axis, name), lambda text: parts(text, "length")[1])
        for name, kind in AXES.items()
    ]


# --- where the table begins ---


def _head(file: Source, wanted: Sequence[Wanted], given: dict[str, str | None]) -> tuple[Head, list[Row]]:
    """Return the head of the table with directions, else with positions, and all rows."""
    failures: list[Candidate] = []
    for mark, rows in file.rows.items():
        if (head := find_head(rows, mark, wanted, failures)) is not None:
            return head, rows
    is_chosen = any(each.column is not None for each in wanted)
    for mark, rows in file.rows.items():
        if not is_chosen and (head := find_head(rows, mark, _axes(given), [])) is not None:
            return head, rows
    if not any(isinstance(each.column, str) for each in wanted):
        for mark, rows in file.rows.items():
            first = next((i for i, row in enumerate(rows) if _is_unheaded(row)), None)
            if first is None or not _may_stand_above(rows[:first], is_chosen):
                continue
            below = rows[first:]
            if (named := _commented(file, mark, below, wanted)) is not None:
                return named, below
            return _unheaded(below, mark, wanted), below
    raise _no_headings(file, wanted, failures)


def _is_unheaded(row: Row) -> bool:
    return is_data(row) and sum(is_numeric(cell) for cell in row.cells) > 1


def _may_stand_above(rows: Sequence[Row], is_chosen: bool) -> bool:
    """Return whether rows above numbers are no headings: the name of a well, or anything where columns are chosen."""
    names = all(re.match(r"(well|name|welltrack|wellname)\b|--", row.text, re.IGNORECASE) for row in rows)
    return is_chosen or names


def _commented(file: Source, mark: str, rows: list[Row], wanted: Sequence[Wanted]) -> Head | None:
    """Return the head whose headings are in a comment above the first row, None without any."""
    for number, text in reversed([line for line in file.comments if line[0] < rows[0].line]):
        cells = text.split() if mark == " " else [cell.strip() for cell in text.split(mark)]
        above = Row(number, cells, text)
        if (head := find_head([above, *rows], mark, wanted, [])) is not None:
            return head._replace(first=head.first - 1)
    return None


def _unheaded(rows: list[Row], mark: str, wanted: Sequence[Wanted]) -> Head:
    """Return the columns of rows without headings: depth, inclination, azimuth, or x, y, z and depth."""
    head = unheaded(rows, mark, wanted)
    if any(each.column is not None for each in wanted):
        return head
    numbers = [[_quick(cell) for cell in row.cells[:4]] for row in rows if is_data(row)]
    by_directions = _may_be_directions(numbers)
    if not _may_be_positions(numbers):
        return head
    if by_directions:
        raise ValueError(
            Message(
                f"line {rows[0].line} has no headings above it, and its columns may be depth, inclination and azimuth "
                "or x, y, z and measured depth; ",
                _name_columns(),
            )
        )
    places = {"depth": 3, "north": 1, "east": 0, "down": 2}
    return Head(mark, None, [Column(name, place, "", None) for name, place in places.items()], 0)


def _quick(cell: str) -> float:
    """Return the number in a cell, NaN for another one."""
    number = Marks(".").number(cell)
    return float("nan") if number is None else number


def _may_be_directions(numbers: Sequence[Sequence[float]]) -> bool:
    """Return whether the first three columns may be depth, inclination and azimuth in degrees."""
    table = np.array([row[:3] for row in numbers if len(row) > 2])
    with np.errstate(invalid="ignore"):
        increases = bool((np.diff(table[:, 0]) >= 0.0).all()) if len(table) else False
        return increases and bool((np.abs(table[:, 1]) <= 180.0).all() and (np.abs(table[:, 2]) <= 720.0).all())


def _may_be_positions(numbers: Sequence[Sequence[float]]) -> bool:
    """Return whether four columns may be x, y, z and measured depth: no chord is longer than the well along it."""
    if len(numbers) < 2 or any(len(row) < 4 for row in numbers):
        return False
    table = np.array([row[:4] for row in numbers])
    if not np.isfinite(table).all():
        return False
    chords, along = np.linalg.norm(np.diff(table[:, :3], axis=0), axis=1), np.diff(table[:, 3])
    return bool((along > 0.0).all() and (chords <= along * 1.01 + 0.1).all() and (chords >= 0.6 * along - 0.1).all())


def _name_columns() -> Mention:
    """Return the remedy for headings that are not known."""
    return Mention("survey_columns", "name the columns by depth, inclination and azimuth", "DEPTH,INCLINATION,AZIMUTH")


def _no_headings(file: Source, wanted: Sequence[Wanted], failures: Sequence[Candidate]) -> ValueError:
    """Return the error for a file in which no table begins, with the headings that were most nearly known."""
    closest = max(failures, key=lambda each: (each.known, _is_above_numbers(each, file)), default=None)
    if closest is not None and _lacks_depth(closest):
        return wrong_value(
            "depth",
            f"is in no column of line {closest.row.line}, which has positions alone: add a column of measured depths, "
            "such as MD",
        )
    by_name = any(isinstance(each.column, str) for each in wanted)
    if closest is not None and (closest.known > 1 or (by_name and closest.known)):
        return closest.error
    rows = next(iter(file.rows.values()))
    is_likely = closest is not None and (closest.known > 0 or _is_above_numbers(closest, file))
    row = closest.row if closest is not None and is_likely else rows[0]
    for each in wanted:
        if isinstance(each.column, int) and closest is not None:
            return closest.error
    usual = ", ".join(validate.short(each.column) for each in wanted if isinstance(each.column, str)) or _USUAL
    remedy = "" if by_name else "; "
    return ValueError(
        Message(
            f"line {row.line} should have headings such as {usual}, got {validate.short(row.text)}",
            *((remedy, _name_columns()) if remedy else ()),
        )
    )


def _is_above_numbers(candidate: Candidate, file: Source) -> bool:
    """Return whether the next row is one of numbers."""
    for rows in file.rows.values():
        for row, below in itertools.pairwise(rows):
            if row.line == candidate.row.line:
                return is_data(below)
    return False


def _lacks_depth(candidate: Candidate) -> bool:
    """Return whether headings are of positions without a measured depth."""
    axes = [any(rank_of_axis(name, text) is not None for text in candidate.headings) for name in ("north", "east")]
    return all(axes) and not any(rank(name, text) is not None for name in KINDS for text in candidate.headings)


# --- where it ends ---


def _table(head: Head, rows: Sequence[Row]) -> _Table:
    """Return the rows of a table, which ends at the first row that is none; what follows is named in a note.

    It goes on below headings that are repeated, as on the next page.  Rows of stations below another one are refused:
    one of them is mistyped, or they are another table.
    """
    stations: list[Row] = []
    others: list[Row] = []
    notes: list[str] = []
    heading_texts = {row.text for row in head.heading_rows}
    repeated = False
    for row in rows[head.first :]:
        if row.text in heading_texts and head.heading_rows:
            repeated = True
            continue
        if _is_unit_row(row, head):
            continue
        if _is_station(row, head):
            if others and not repeated:
                raise _not_a_station(others[0], head, len(stations) + 1)
            if others:
                notes.append(
                    f"line {others[0].line}, {validate.short(others[0].text)}, and the headings below it are "
                    "left out: the table goes on below them"
                )
                others = []
            stations.append(row)
            continue
        if _is_mistyped(row, head):
            raise _not_a_station(row, head, len(stations) + 1)
        others.append(row)
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
    return _Table(head, stations, marks, notes)


def _cells(row: Row, head: Head) -> list[str]:
    """Return the cells of the chosen columns."""
    return [row.cells[column.place] if column.place < len(row.cells) else "" for column in head.columns]


def _is_number(cell: str) -> bool:
    return is_numeric(split_unit(cell)[0]) or _BEARING.fullmatch(cell) is not None


def _is_station(row: Row, head: Head) -> bool:
    """Return whether all chosen cells are numbers or marks of lost values, one a number at least."""
    cells = _cells(row, head)
    if head.delimiter == " " and head.headings is None and len(row.cells) < len(head.columns):
        return _is_number(cells[0]) and all(map(_is_number, row.cells))
    return (
        all(_is_number(cell) or is_missing(cell) for cell in cells)
        and any(map(_is_number, cells))
        and (_is_number(cells[0]) or any(map(_is_number, cells[1:])))
    )


def _is_mistyped(row: Row, head: Head) -> bool:
    """Return whether a row is a station with a cell that cannot be read: other cells are numbers."""
    numbers = list(map(_is_number, _cells(row, head)))
    if head.delimiter == " " and sum(numbers) < 2:
        return False
    return sum(numbers) > 1 or (numbers[0] and head.delimiter != " ")


def _is_unit_row(row: Row, head: Head) -> bool:
    return any(row.text == unit_row.text for unit_row in head.unit_rows)


def _not_a_station(row: Row, head: Head, station: int) -> ValueError:
    """Return the error for a row among stations that is none."""
    cells = _cells(row, head)
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
            len(row.cells) <= last or not all(map(_is_number, _cells(row, head))) or _may_be_shifted(row, head)
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


# --- numbers ---


class _Stations(NamedTuple):
    """Numbers of the stations in SI units by column, NaN where lost, and their lines and numbers from 1."""

    values: dict[str, Floats]
    lines: list[int]
    stations: list[int]

    def at(self, index: NDArray[np.intp]) -> _Stations:
        """Return the stations at indices."""
        lines, stations = np.array(self.lines)[index], np.array(self.stations)[index]
        return _Stations({name: each[index] for name, each in self.values.items()}, lines.tolist(), stations.tolist())


def _stations(table: _Table, shown: dict[str, units.Unit]) -> _Stations:
    """Return the numbers of all stations."""
    values = {
        column.name: np.array(
            [
                _number(row, station, column, table.marks, shown[column.name])
                for station, row in enumerate(table.rows, 1)
            ]
        )
        for column in table.head.columns
    }
    return _Stations(values, [row.line for row in table.rows], list(range(1, len(table.rows) + 1)))


def _number(row: Row, station: int, column: Column, marks: Marks, unit: units.Unit) -> float:
    """Return the number in a cell in SI units, NaN for a lost value; a bearing such as N30E is an azimuth."""
    cell = row.cells[column.place] if column.place < len(row.cells) else ""
    if is_missing(cell) or is_lost_number(cell):
        return float("nan")
    if column.name == "azimuth" and (bearing := _BEARING.fullmatch(cell)) is not None:
        return math.radians(_azimuth_of(bearing))
    text, written = split_unit(cell)
    if written and units.is_unit(in_english(written), _kind(column)):
        unit = _same(row, station, column, units.unit(in_english(written), "", _kind(column)), unit)
        written = ""
    number = None if written else marks.number(text)
    if number is None:
        hint = "write numbers without marks between thousands" if "," in cell else "put # before lines without data"
        raise ValueError(
            f"line {row.line}, station {station}: {column.name} must be a number, got {validate.short(cell)}; {hint}"
        )
    return number * unit.size


def _kind(column: Column) -> str:
    return KINDS.get(column.name, "length")


def _same(row: Row, station: int, column: Column, written: units.Unit, unit: units.Unit) -> units.Unit:
    """Return the unit in a cell, which must be the unit of the column."""
    if written.size != unit.size:
        raise ValueError(
            f"line {row.line}, station {station}: {column.name} is in {written.name}, below a heading in {unit.name}"
        )
    return written


def _azimuth_of(bearing: re.Match[str]) -> float:
    """Return the azimuth in deg of a bearing in a quadrant: N30E is 30, S45W is 225."""
    north, degrees, minutes, east = bearing.groups()
    angle = float(degrees.replace(",", ".")) + float((minutes or "0").replace(",", ".")) / 60.0
    if not 0.0 <= angle <= 90.0:
        raise ValueError(f"azimuth must be a bearing from 0 to 90 deg in its quadrant, got {bearing[0]!r}")
    turned = 1.0 if (north.upper() == "N") == (east.upper() == "E") else -1.0
    return (_QUARTERS[north.upper()] + turned * angle) % 360.0


def _units_of(table: _Table, given: dict[str, str | None]) -> dict[str, units.Unit]:
    return {
        column.name: _unit(column, given["depth" if _kind(column) == "length" else "inclination"], table)
        for column in table.head.columns
    }


def _unit(column: Column, given: str | None, table: _Table) -> units.Unit:
    """Return the unit of a column: by argument, its heading or its cells; degrees where angles have none."""
    kind, argument = _kind(column), "depth_unit" if _kind(column) == "length" else "angle_unit"
    named = given or column.unit or (_unit_in_cells(column, table) if kind == "length" else None)
    if named is None and kind == "angle":
        return units.unit("deg", argument, kind)
    if named is not None and units.is_unit(named, kind):
        return units.unit(named, argument, kind)
    why = "names none" if named is None else f"names {named!r}"
    raise validate.wrong_value(
        argument, f"must be given, such as {'m or ft' if kind == 'length' else 'deg or rad'}: the heading {why}"
    )


def _unit_in_cells(column: Column, table: _Table) -> str | None:
    """Return the unit that all cells of a column name."""
    written = {
        in_english(split_unit(row.cells[column.place])[1]) for row in table.rows if column.place < len(row.cells)
    }
    return written.pop() if len(written) == 1 and "" not in written else None


# --- stations ---


def _by_directions(table: _Table, given: dict[str, str | None]) -> SurveyFile:
    """Return the stations of a table of depths, inclinations and azimuths."""
    shown = _units_of(table, given)
    stations = _stations(table, shown)
    if "azimuth" not in stations.values:
        stations.values["azimuth"] = np.zeros(len(stations.lines))
    notes = list(table.notes)
    doubts: list[str] = []
    _fill_vertical(stations.values)
    stations = _without_lost(stations, table, shown, doubts)
    stations = _without_repeated(stations, table, shown["depth"], notes)
    columns = stations.values
    named = table.head.headings is not None or bool(table.head.heading_rows)
    in_degrees = given["inclination"] is None and shown["inclination"].size != 1.0
    return SurveyFile(
        columns["depth"],
        columns["inclination"],
        columns["azimuth"],
        stations.lines,
        stations.stations,
        named,
        in_degrees,
        shown["depth"].name,
        shown["inclination"].name,
        notes,
        doubts,
    )


def _fill_vertical(values: dict[str, Floats]) -> None:
    """Give vertical stations without an azimuth the one of the next station that has one, else of the one before."""
    azimuth, inclination = values["azimuth"], values["inclination"]
    known = np.flatnonzero(~np.isnan(azimuth))
    for i in np.flatnonzero(np.isnan(azimuth) & (inclination == 0.0)):
        below = known[known > i]
        nearest = below[:1] if below.size else known[-1:]
        azimuth[i] = azimuth[nearest[0]] if nearest.size else 0.0


def _without_lost(stations: _Stations, table: _Table, shown: dict[str, units.Unit], doubts: list[str]) -> _Stations:
    """Return the stations that have all values; each of the others is told, with what is lost."""
    lost = [
        [name for name, values in stations.values.items() if np.isnan(values[i])] for i in range(len(stations.lines))
    ]
    kept = [i for i, names in enumerate(lost) if not names]
    if len(kept) < len(lost) and len(kept) < max(2.0, _NEARLY_ALL * len(lost)):
        i = next(i for i, names in enumerate(lost) if names)
        raise ValueError(
            f"line {stations.lines[i]}, station {stations.stations[i]}: {lost[i][0]} is missing, and {len(kept)} of "
            f"{len(lost)} stations have all their values; fill it in"
        )
    for i, names in enumerate(lost):
        if names:
            depth = stations.values["depth"][i]
            at = "" if np.isnan(depth) else f" at {shown['depth'].show(depth)}"
            cells = dict(
                zip((column.name for column in table.head.columns), _cells(table.rows[i], table.head), strict=True)
            )
            said = " and ".join(f"{name} ({validate.short(cells[name])})" for name in names)
            doubts.append(
                f"line {stations.lines[i]}: station {stations.stations[i]}{at} is left out, its {said} "
                f"{'is' if len(names) == 1 else 'are'} missing"
            )
    return stations.at(np.array(kept, dtype=np.intp))


def _without_repeated(stations: _Stations, table: _Table, length: units.Unit, notes: list[str]) -> _Stations:
    """Return the stations without those that repeat the one above, which a note names."""
    depth, angles = stations.values["depth"], [stations.values[name] for name in ("inclination", "azimuth")]
    repeated = [
        i
        for i in range(1, depth.size)
        if depth[i] == depth[i - 1] and all(values[i] == values[i - 1] for values in angles)
    ]
    if repeated:
        named = ", ".join(
            f"{stations.stations[i]} (line {stations.lines[i]}, {length.show(depth[i])})" for i in repeated[:3]
        )
        more = f" and {len(repeated) - 3} more" if len(repeated) > 3 else ""
        notes.append(f"station{'s' * (len(repeated) > 1)} {named}{more} left out: the same as the one above")
    return stations.at(np.array([i for i in range(depth.size) if i not in set(repeated)], dtype=np.intp))


def _require_one_well(table: _Table) -> None:
    """Raise ValueError where a column names several wells."""
    headings = table.head.headings or []
    for place, heading in enumerate(headings):
        if re.sub(r"[\W_]+", " ", heading.casefold()).strip() not in _LABELS:
            continue
        named = [(row.line, row.cells[place]) for row in table.rows if place < len(row.cells) and row.cells[place]]
        for (_, before), (line, after) in itertools.pairwise(named):
            if before != after:
                raise ValueError(
                    f"line {line}: column {heading!r} goes from {before!r} to {after!r}; write each well into a "
                    "file of its own"
                )


def _by_positions(table: _Table, given: dict[str, str | None]) -> SurveyFile:
    """Return the stations of a table of positions and measured depths, directions from `directions`."""
    shown = _units_of(table, given)
    stations = _stations(table, shown)
    notes = list(table.notes)
    doubts: list[str] = []
    stations = _without_lost(stations, table, shown, doubts)
    depth = stations.values["depth"]
    same = [i for i in range(1, depth.size) if all(v[i] == v[i - 1] for v in stations.values.values())]
    stations = stations.at(np.array([i for i in range(depth.size) if i not in set(same)], dtype=np.intp))
    if same:
        notes.append(f"{len(same)} stations left out: the same as the one above")
    columns, length = stations.values, shown["depth"]
    line, station = stations.lines, stations.stations
    if columns["depth"].size < 2:
        raise ValueError(f"line {line[0] if line else 0}: a survey by positions must have two stations or more")
    for i in np.flatnonzero(np.diff(columns["depth"]) <= 0.0):
        raise wrong_value(
            "depth",
            f"at line {line[i + 1]}, station {station[i + 1]}, must increase from station to station, got "
            f"{length.show(columns['depth'][i + 1])} after {length.show(columns['depth'][i])}; sort the stations",
        )
    down = _downwards(columns, line, length)
    positions = np.stack([columns["north"], columns["east"], down], axis=-1)
    step = max((_step(table, axis) for axis in ("north", "east", "down")), default=0.0) * length.size
    chords, along = np.linalg.norm(np.diff(positions, axis=0), axis=1), np.diff(columns["depth"])
    for i in np.flatnonzero(chords > along * (1.0 + 1e-6) + 2.0 * step):
        raise ValueError(
            f"line {line[i + 1]}, station {station[i + 1]}: its position is {length.show(chords[i])} from the one "
            f"above, farther than the {length.show(along[i])} between their measured depths; are the units the same?"
        )
    inclination, azimuth, miss = directions(columns["depth"], positions, step)
    notes.append(f"directions follow from positions, which the path misses by {length.show(miss, 2)} at most")
    if miss > 2.0 * step + _NEAR * float(depth[-1] - depth[0]):
        doubts.append(
            f"its positions are too far apart for directions: the path misses them by {length.show(miss, 2)}; give "
            "inclinations and azimuths, or more stations"
        )
    return SurveyFile(
        columns["depth"],
        inclination,
        azimuth,
        line,
        station,
        True,
        False,
        length.name,
        "deg",
        notes,
        doubts,
    )


def _downwards(columns: dict[str, Floats], lines: Sequence[int], length: units.Unit) -> Floats:
    """Return depths below the first station: a column that falls along the well holds elevations.

    ValueError where a well is so level that nobody sees which way the column points.
    """
    values = columns["down"] - columns["down"][0]
    extent = float(columns["depth"][-1] - columns["depth"][0])
    furthest = values[int(np.argmax(np.abs(values)))]
    if abs(furthest) < 0.02 * extent:
        raise ValueError(
            f"line {lines[-1]}: depths below the surface change by {length.show(abs(furthest))} in "
            f"{length.show(extent)}, too little to see whether they count down or up; add inclinations"
        )
    return np.asarray(values if furthest > 0.0 else -values)


def _step(table: _Table, name: str) -> float:
    """Return the last digit of the numbers in a column, in its unit."""
    column = next(column for column in table.head.columns if column.name == name)
    cells = [split_unit(row.cells[column.place])[0] for row in table.rows if column.place < len(row.cells)]
    digits = max((len(cell.partition(table.marks.decimal)[2]) for cell in cells), default=0)
    return 10.0**-digits
