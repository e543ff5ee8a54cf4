"""Where a table begins: its separator, its headings in one row or several, and the units of its columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message
from floquetrod.tables.cells import is_missing, is_numeric, is_value
from floquetrod.tables.text import Row, is_data, phrases, words

HEAD = 200
"""Rows among which headings are searched for (a choice)."""

_ROWS = 3  # of headings, at most (a choice)
_UNIT_ROWS = 3  # below them, at most (a choice)


class Wanted(NamedTuple):
    """A column to be found: its argument, the kind of its unit, its known unit, and how headings are understood.

    ``places`` returns the places of the headings that suit best, ``unit_in`` the unit that a heading names.
    """

    name: str
    kind: str
    column: str | int | None
    unit: str | None
    places: Callable[[Sequence[str]], list[int]]
    unit_in: Callable[[str], str | None]
    is_optional: bool = False  # in a table of two columns
    remedy: Mention | None = None  # what chooses a column
    may_be_unnamed: bool = False  # where there are more columns than wanted and no headings

    def is_unit(self, cell: str) -> bool:
        """Return whether a cell below a heading is a unit of the column."""
        return units.is_unit(cell.strip("[](){} "), self.kind)


class Column(NamedTuple):
    """A column: its argument, its place, its heading, and the unit that its heading or the row below names."""

    name: str
    place: int
    heading: str
    unit: str | None


class Head(NamedTuple):
    """What a table says before its rows; ``first`` is the index of the first of them among all rows."""

    delimiter: str
    headings: list[str] | None
    columns: list[Column]
    first: int
    heading_rows: Sequence[Row] = ()
    unit_rows: Sequence[Row] = ()


class Candidate(NamedTuple):
    """Rows that may be headings: how many columns are known by them, and why they are none."""

    known: int
    row: Row
    headings: list[str]
    error: ValueError


def find_head(rows: Sequence[Row], delimiter: str, wanted: Sequence[Wanted], failures: list[Candidate]) -> Head | None:
    """Return the head of the first table with all columns, None without any; rows above are passed over.

    ``failures`` receives rows that may be headings, for messages.
    """
    are_numbered = all(isinstance(column.column, int) for column in wanted)
    for at, row in enumerate(rows[:HEAD]):
        if any(is_numeric(cell) for cell in row.cells) and not are_numbered:
            continue
        for many in range(1, _ROWS + 1):
            block = rows[at : at + many]
            if len(block) < many or any(is_numeric(cell) for below in block[1:] for cell in below.cells):
                break
            width = next((len(below.cells) for below in rows[at + many :] if _has_numbers(below)), 0)
            if width < 2 and at + many < len(rows):
                break
            width = width or len(block[-1].cells)
            headings = merged(block, delimiter, width)
            head = _head_below(rows, at + many, delimiter, headings, block, wanted, failures, width)
            if head is not None:
                return head
    return None


def unheaded(rows: Sequence[Row], delimiter: str, wanted: Sequence[Wanted]) -> Head:
    """Return the head of a table that has no headings, whose first row has values: columns by number or in order."""
    filled = (max(place for place, cell in enumerate(row.cells, 1) if cell) for row in rows if is_data(row))
    many = max(filled, default=len(rows[0].cells))
    columns = []
    for order, each in enumerate(wanted):
        if each.is_optional and each.column is None and many == 2:
            continue
        in_order = each.column is None and order < many and (many == len(wanted) or each.may_be_unnamed)
        place = order if in_order else place_of(each, None, many)
        columns.append(Column(each.name, place, "", None))
    if len({column.place for column in columns}) < len(columns):
        raise ValueError(
            f"{in_words(columns)} must be {_COUNTS[len(columns)]} columns, got {_doubled(columns)} for both"
        )
    return Head(delimiter, None, columns, 0)


def headed_by(rows: Sequence[Row], delimiter: str, wanted: Sequence[Wanted]) -> Head:
    """Return the head whose headings are the first row; ValueError where they are not known."""
    headings = rows[0].cells
    columns = []
    for each in wanted:
        place = place_of(each, headings, len(headings))
        columns.append(Column(each.name, place, headings[place], each.unit_in(headings[place])))
    return Head(delimiter, headings, columns, 1, rows[:1])


def _has_numbers(row: Row) -> bool:
    return sum(cell != "" and is_value(cell) and not is_missing(cell) for cell in row.cells) > 1


def _head_below(
    rows: Sequence[Row],
    below: int,
    delimiter: str,
    headings: list[str],
    block: Sequence[Row],
    wanted: Sequence[Wanted],
    failures: list[Candidate],
    width: int,
) -> Head | None:
    """Return the head whose headings end above a row, None where a column or its values are missing."""
    columns, error = [], None
    for each in wanted:
        try:
            place = place_of(each, headings, len(headings))
            columns.append(Column(each.name, place, headings[place], each.unit_in(headings[place])))
        except ValueError as unknown:
            if not (each.is_optional and each.column is None and len(headings) == 2):
                error = error or unknown
    if error is None and len({column.place for column in columns}) < len(columns):
        error = ValueError(f"{in_words(columns)} must be different columns, got {_doubled(columns)} for both")
    if error is not None:
        failures.append(Candidate(len(columns), block[-1], headings, error))
        return None
    skipped: list[Row] = []
    for row in rows[below : below + _UNIT_ROWS]:
        texts = aligned(row, block, delimiter, headings, width)
        named = _units_of(texts, columns, wanted)
        if named is None:
            break
        columns = [column._replace(unit=unit or column.unit) for column, unit in zip(columns, named, strict=True)]
        skipped.append(row)
    first = below + len(skipped)
    if first < len(rows) and not _has_values(rows[first], columns):
        return None
    return Head(delimiter, headings, columns, first, tuple(block), tuple(skipped))


def _has_values(row: Row, columns: Sequence[Column]) -> bool:
    cells = [row.cells[column.place] if column.place < len(row.cells) else "" for column in columns]
    return is_value(cells[0]) and not is_missing(cells[0])


def _units_of(texts: Sequence[str], columns: Sequence[Column], wanted: Sequence[Wanted]) -> list[str] | None:
    """Return the units in the row below headings, "" where a column has none there; None for another row."""
    kinds = {each.name: each for each in wanted}
    named = [texts[column.place].strip("[](){} ") if column.place < len(texts) else "" for column in columns]
    if not any(named):
        return None
    are_units = all(not text or kinds[column.name].is_unit(text) for text, column in zip(named, columns, strict=True))
    return named if are_units else None


def merged(block: Sequence[Row], delimiter: str, width: int) -> list[str]:
    """Return headings in several rows as one row, in spaced text by their positions."""
    if delimiter != " ":
        many = max(len(row.cells) for row in block)
        columns = ([row.cells[i] if i < len(row.cells) else "" for row in block] for i in range(many))
        return [" ".join(filter(None, column)) for column in columns]
    base = _spans(block, width)
    texts = [aligned_spans(_phrases_of(row, width), base) for row in block]
    return [" ".join(filter(None, column)) for column in zip(*texts, strict=True)]


def aligned(row: Row, block: Sequence[Row], delimiter: str, headings: Sequence[str], width: int) -> list[str]:
    """Return the cells of a row below headings, in spaced text each at the heading that it stands below."""
    if delimiter != " " or len(row.cells) == len(headings):
        return row.cells
    return aligned_spans(_phrases_of(row, width), _spans(block, width))


def _phrases_of(row: Row, width: int) -> list[tuple[int, int, str]]:
    """Return the headings in a row of spaced text: as many as there are columns, by single spaces or by several."""
    apart, single = phrases(row.text), words(row.text)
    if len(apart) != width and len(single) == width:
        return single
    return apart if 1 < len(apart) <= width else single if len(single) <= width else apart


def _spans(block: Sequence[Row], width: int) -> list[tuple[int, int, str]]:
    """Return the places of the columns, from the row with the most headings."""
    return max((_phrases_of(row, width) for row in reversed(block)), key=len)


def aligned_spans(given: Sequence[tuple[int, int, str]], base: Sequence[tuple[int, int, str]]) -> list[str]:
    """Return texts at the places that they overlap most, or are nearest to."""
    texts = [""] * len(base)
    for start, end, text in given:
        overlaps = [min(end, b) - max(start, a) for a, b, _ in base]
        place = max(range(len(base)), key=overlaps.__getitem__)
        texts[place] = f"{texts[place]} {text}".strip()
    return texts


def place_of(wanted: Wanted, headings: Sequence[str] | None, many: int) -> int:
    """Return the place of a column: its number, its heading, with its unit or without, or by usual headings."""
    name, column = wanted.name, wanted.column
    if isinstance(column, int):
        if column >= many:
            raise validate.wrong_value(name, f"must be a column from 0 to {many - 1}, got {column}")
        return column
    if isinstance(column, str) and headings is None:
        raise validate.wrong_value(name, f"must be the number of a column, got {column!r}: there are no headings")
    listed = headings or ()
    places = wanted.places(listed) if column is None else headed(column.strip(), listed, wanted.kind)
    if len(places) != 1:
        raise validate.wrong_value(name, not_one(wanted, places, headings, many))
    return places[0]


def not_one(wanted: Wanted, matches: Sequence[int], headings: Sequence[str] | None, many: int) -> Message:
    """Return the complaint where a column is not known, or several may be it."""
    what = "a heading of one column" if headings else f"a column from 0 to {many - 1}"
    said = f"and {len(matches) or 'none'} of them {'say' if matches else 'says'} {wanted.name}"
    said = said if wanted.column is None else f"got {validate.short(wanted.column)}"
    listed = f"; the headings are {', '.join(map(repr, headings))}" if headings else ""
    named = ": " + ", ".join(repr(headings[place]) for place in matches) if headings and len(matches) > 1 else ""
    can_choose = headings is not None and wanted.column is None and wanted.remedy is not None
    choose = f"must be {what}, {said}{named}{'; choose one' if named or can_choose else ''}"
    by = (" by ", wanted.remedy) if wanted.remedy is not None and (named or can_choose) else ()
    return Message(choose, *by, listed)


def headed(heading: str, listed: Sequence[str], kind: str) -> list[int]:
    """Return the places of a heading: in its own case, in any, or without the unit of a kind that is listed with it."""
    names = listed, [text.casefold() for text in listed], [units.heading(text, kind)[0].casefold() for text in listed]
    sought = heading, heading.casefold(), heading.casefold()
    found = ([i for i, text in enumerate(each) if text == name] for each, name in zip(names, sought, strict=True))
    return next(filter(None, found), [])


def best(headings: Sequence[str], rank: Callable[[str], int | None]) -> list[int]:
    """Return the places of the headings of the lowest rank."""
    ranks = {i: value for i, text in enumerate(headings) if (value := rank(text)) is not None}
    return [i for i, value in ranks.items() if value == min(ranks.values())]


_COUNTS = {2: "two", 3: "three different", 4: "four different"}


def _doubled(columns: Sequence[Column]) -> str:
    """Return the column that is chosen twice."""
    places = [column.place for column in columns]
    return f"column {next(place for place in places if places.count(place) > 1)}"


def in_words(columns: Sequence[Column]) -> str:
    """Return the arguments of columns in words."""
    *most, last = (column.name for column in columns)
    return f"{', '.join(most)} and {last}"
