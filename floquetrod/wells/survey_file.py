"""A survey in a file: from its text to stations, by directions or by positions along the well."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Floats
from floquetrod.tables.cells import split_unit
from floquetrod.tables.sources import source
from floquetrod.wells.survey_columns import find_columns
from floquetrod.wells.survey_headings import AXES, WELL_LABELS
from floquetrod.wells.survey_numbers import SurveyNumbers, numbers_in, units_of
from floquetrod.wells.survey_positions import directions
from floquetrod.wells.survey_rows import SurveyTable, cells_in, survey_table

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


def read_survey_file(
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
    head, rows = find_columns(file, wanted, given)
    table = survey_table(head, rows)
    if len(table.rows) > validate.MOST_NUMBERS:
        raise ValueError(f"it holds {len(table.rows)} stations, at most {validate.MOST_NUMBERS} are read")
    _require_one_well(table)
    if {column.name for column in head.columns} == set(AXES):
        return _by_positions(table, given)
    return _by_directions(table, given)


def _by_directions(table: SurveyTable, given: dict[str, str | None]) -> SurveyFile:
    """Return the stations of a table of depths, inclinations and azimuths."""
    shown = units_of(table, given)
    stations = numbers_in(table, shown)
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


def _without_lost(
    stations: SurveyNumbers, table: SurveyTable, shown: dict[str, units.Unit], doubts: list[str]
) -> SurveyNumbers:
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
                zip((column.name for column in table.head.columns), cells_in(table.rows[i], table.head), strict=True)
            )
            said = " and ".join(f"{name} ({validate.short(cells[name])})" for name in names)
            doubts.append(
                f"line {stations.lines[i]}: station {stations.stations[i]}{at} is left out, its {said} "
                f"{'is' if len(names) == 1 else 'are'} missing"
            )
    return stations.at(np.array(kept, dtype=np.intp))


def _without_repeated(
    stations: SurveyNumbers, table: SurveyTable, length: units.Unit, notes: list[str]
) -> SurveyNumbers:
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


def _require_one_well(table: SurveyTable) -> None:
    """Raise ValueError where a column names several wells."""
    headings = table.head.headings or []
    for place, heading in enumerate(headings):
        if re.sub(r"[\W_]+", " ", heading.casefold()).strip() not in WELL_LABELS:
            continue
        named = [(row.line, row.cells[place]) for row in table.rows if place < len(row.cells) and row.cells[place]]
        for (_, before), (line, after) in itertools.pairwise(named):
            if before != after:
                raise ValueError(
                    f"line {line}: column {heading!r} goes from {before!r} to {after!r}; write each well into a "
                    "file of its own"
                )


def _by_positions(table: SurveyTable, given: dict[str, str | None]) -> SurveyFile:
    """Return the stations of a table of positions and measured depths, directions from `directions`."""
    # Order of work: marks for lost values go, then stations that repeat the one above; what is left must go deeper with
    # each station, as the measured depth is the length along the well; positions (stations, 3) are north, east, down in
    # m.  A chord may not exceed the length between its ends, by more than the last digits written (``step``) explain.
    # Directions at the stations follow from positions and lengths (`directions`), and the path through them is compared
    # with the positions: ``miss`` says how far apart stations are.
    shown = units_of(table, given)
    stations = numbers_in(table, shown)
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


def _step(table: SurveyTable, name: str) -> float:
    """Return the last digit of the numbers in a column, in its unit."""
    column = next(column for column in table.head.columns if column.name == name)
    cells = [split_unit(row.cells[column.place])[0] for row in table.rows if column.place < len(row.cells)]
    digits = max((len(cell.partition(table.marks.decimal)[2]) for cell in cells), default=0)
    return 10.0**-digits
