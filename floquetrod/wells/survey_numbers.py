"""The numbers of a survey in a file, in SI units: units by argument, heading or cell, bearings, lost values."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.tables.cells import Marks, is_lost_number, is_missing, split_unit
from floquetrod.tables.head import Column
from floquetrod.tables.text import Row
from floquetrod.wells.survey_headings import KINDS, in_english
from floquetrod.wells.survey_rows import BEARING, SurveyTable

_QUARTERS = {"N": 0.0, "E": 90.0, "S": 180.0, "W": 270.0}


class SurveyNumbers(NamedTuple):
    """Numbers of the stations in SI units by column, NaN where lost, and their lines and numbers from 1."""

    values: dict[str, Floats]
    lines: list[int]
    stations: list[int]

    def at(self, index: NDArray[np.intp]) -> SurveyNumbers:
        """Return the stations at indices."""
        lines, stations = np.array(self.lines)[index], np.array(self.stations)[index]
        return SurveyNumbers(
            {name: each[index] for name, each in self.values.items()}, lines.tolist(), stations.tolist()
        )


def numbers_in(table: SurveyTable, shown: dict[str, units.Unit]) -> SurveyNumbers:
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
    return SurveyNumbers(values, [row.line for row in table.rows], list(range(1, len(table.rows) + 1)))


def _number(row: Row, station: int, column: Column, marks: Marks, unit: units.Unit) -> float:
    """Return the number in a cell in SI units, NaN for a lost value; a bearing such as N30E is an azimuth."""
    cell = row.cells[column.place] if column.place < len(row.cells) else ""
    if is_missing(cell) or is_lost_number(cell):
        return float("nan")
    if column.name == "azimuth" and (bearing := BEARING.fullmatch(cell)) is not None:
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


def units_of(table: SurveyTable, given: dict[str, str | None]) -> dict[str, units.Unit]:
    """Return the unit of each column; ``given`` has the units of depths and of angles by argument, None without."""
    return {
        column.name: _unit(column, given["depth" if _kind(column) == "length" else "inclination"], table)
        for column in table.head.columns
    }


def _unit(column: Column, given: str | None, table: SurveyTable) -> units.Unit:
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


def _unit_in_cells(column: Column, table: SurveyTable) -> str | None:
    """Return the unit that all cells of a column name."""
    written = {
        in_english(split_unit(row.cells[column.place])[1]) for row in table.rows if column.place < len(row.cells)
    }
    return written.pop() if len(written) == 1 and "" not in written else None
