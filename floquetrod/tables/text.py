"""The text of a file, and its rows of cells."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from floquetrod._util.sealed_files import require_regular
from floquetrod.tables.cells import is_value

_LARGEST = 1 << 29  # bytes of a file that are read, ten million samples or so

Line = tuple[int, str]
"""A line and its number."""

DELIMITERS = ";\t,|"
"""Separators of columns in the order in which they are tried; beside them there are spaces."""

_UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
_RULE = re.compile(r"[\s|+:;,\"]*([-=_*~#.\u2500-\u257f]{2,}[\s|+:;,\"]*)+")


class Row(NamedTuple):
    """A row of cells without spaces at their ends, the number of its first line, and its text."""

    line: int
    cells: list[str]
    text: str


def text_of(path: Path) -> str:
    """Return the text of a file: UTF-8, UTF-16 with its mark, or Windows-1252."""
    require_regular(path, _LARGEST)
    content = path.read_bytes()
    if content.startswith(_UTF_16):
        return _utf_16(content)
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


def _utf_16(content: bytes) -> str:
    """Return the text that spreadsheets write as Unicode text."""
    try:
        return content.decode("utf-16")
    except UnicodeDecodeError:
        raise ValueError("it is not whole text in UTF-16; save it as CSV in UTF-8") from None


def lines_of(text: str) -> list[Line]:
    """Return the lines of a text; lines each in quotes as a whole lose them."""
    lines = list(enumerate(io.StringIO(text, newline=None), 1))
    full = [line.strip() for _, line in lines if line.strip()]
    if len(full) > 1 and all(_is_quoted(line) for line in full):
        return [(number, f"{line.strip()[1:-1].replace(chr(34) * 2, chr(34))}\n") for number, line in lines]
    return lines


def _is_quoted(line: str) -> bool:
    """Return whether a line is one cell in quotes that holds the separators of several."""
    return re.fullmatch(r'"([^"]|"")*"', line) is not None and re.search(rf"[{DELIMITERS}]|\S[ ]+\S", line) is not None


def delimiters_of(lines: Sequence[Line], delimiter: str | None) -> list[str]:
    """Return the possible separators of columns in lines, the first to try first."""
    if delimiter is not None:
        return [delimiter]
    for _, line in lines:
        if match := re.fullmatch(r'\s*"?sep=(.)"?\s*', line):  # with which spreadsheets begin
            return [match[1]]
        if line.strip():
            break
    return [*(mark for mark in DELIMITERS if any(mark in line for _, line in lines)), " "]


def rows_of(lines: Iterable[Line], delimiter: str) -> Iterator[Row]:
    """Yield rows other than empty ones, comments and rules of dashes; ValueError where a quote is not closed."""
    if delimiter == " " or (delimiter == "|"):
        split = _spaced if delimiter == " " else _piped
        for number, text in lines:
            if not _is_skipped(text):
                yield Row(number, split(text), text.rstrip("\r\n"))
        return
    yield from _delimited(lines, delimiter)


def _delimited(lines: Iterable[Line], delimiter: str) -> Iterator[Row]:
    """Yield the rows of lines by the csv module, cells in quotes over several lines among them."""
    read: list[Line] = []

    def texts() -> Iterator[str]:
        for line in lines:
            if read or not _is_skipped(line[1]):
                read.append(line)
                yield line[1]

    reader = csv.reader(texts(), delimiter=delimiter, skipinitialspace=delimiter != "\t", strict=True)
    while True:
        read.clear()
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            number = read[0][0] if read else 0
            raise ValueError(f"line {number} cannot be read: {error}; is a quote there not closed?") from None
        row = Row(read[0][0], [re.sub(r"\s+", " ", cell).strip() for cell in cells], read[0][1].strip(" \r\n"))
        if any(row.cells):
            yield row


def _is_skipped(line: str) -> bool:
    """Return whether a line is empty, a comment, a rule of dashes, or names the separator."""
    text = line.strip()
    return not text or text.startswith(("#", "sep=")) or _RULE.fullmatch(text) is not None


def _spaced(text: str) -> list[str]:
    """Return the words of a line, those in quotes as one."""
    if '"' in text:
        try:
            return [cell for cell in next(csv.reader([text.strip()], delimiter=" ", skipinitialspace=True)) if cell]
        except (csv.Error, StopIteration):
            pass
    return re.split(r"[ \t]+", text.strip())


def _piped(text: str) -> list[str]:
    """Return the cells of a line between bars, as in Markdown."""
    line = text.strip()
    whole = line.removeprefix("|").removesuffix("|") if line.startswith("|") else line
    return [cell.strip() for cell in whole.split("|")]


def phrases(text: str) -> list[tuple[int, int, str]]:
    """Return the headings in a line of spaced text, with the places where each begins and ends.

    Words that a single space separates are of one heading.
    """
    return [(match.start(), match.end(), match[0]) for match in re.finditer(r"\S+( \S+)*", text.expandtabs())]


def words(text: str) -> list[tuple[int, int, str]]:
    """Return the words of a line of spaced text with their places, units in brackets with the word before them."""
    return [
        (match.start(), match.end(), match[0])
        for match in re.finditer(r"\S+?( ?[(\[][^)\]]*[)\]])(?=\s|$)|\S+", text.expandtabs())
    ]


def is_data(row: Row) -> bool:
    """Return whether all filled cells of a row are values, two at least."""
    full = [cell for cell in row.cells if cell]
    return len(full) > 1 and all(map(is_value, full))
