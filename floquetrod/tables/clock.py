"""Dates and times of day in a text file, as seconds."""

from __future__ import annotations

import datetime
import re

from floquetrod._util import validate

DATES = "2024-01-31, 31.01.2024 or 01/31/2024"
"""How dates may be written, for messages."""

CLOCK = re.compile(
    r"(?:(\d{1,4}([-./])\d\d?\2\d{1,4})[T ]\s*)?"
    r"([01]?\d|2[0-3]):([0-5]\d):([0-5]\d(?:[.,]\d*)?)\s*([AaPp][Mm])?\s*([Zz]|[-+]\d\d(?::?\d\d)?)?",
    re.ASCII,
)
"""A time of day, with a date before it or without."""


class Clock:
    """Turns times of day, with dates or without, into seconds from the first midnight."""

    def __init__(self, unit: str | None) -> None:
        self.unit = unit
        self.calendar = _Calendar()
        self.days = 0  # that have passed where there are no dates
        self.last: float | None = None

    @property
    def is_used(self) -> bool:
        """Whether a time of day has been read."""
        return self.last is not None

    def seconds(self, cell: str) -> float | None:
        """Return the seconds of a time of day, None for another cell; without dates, midnight begins another day."""
        match = CLOCK.fullmatch(cell)
        if match is None:
            return None
        if self.unit is not None:
            raise validate.wrong_value(
                "time_unit", f"is for numbers, got {self.unit!r} for times of day such as {cell!r}"
            )
        date, _, hours, minutes, seconds, half, zone = match.groups()
        time = 3600.0 * _hour(int(hours), half, cell) + 60.0 * int(minutes) + float(seconds.replace(",", "."))
        time -= _offset(zone)
        time += 86400.0 * self._day(date, time, cell)
        self.last = time
        return time

    def _day(self, date: str | None, time: float, cell: str) -> int:
        """Return the number of the day of a time, 0 for the first."""
        if self.last is not None and (date is None) != self.calendar.is_empty:
            raise validate.wrong_value("time", f"must have a date in every line or in none, got {cell!r}")
        if date is not None:
            return self.calendar.day(date)
        if self.last is not None and time + 86400.0 * self.days < self.last - 43200.0:
            self.days += 1
        return self.days


class _Calendar:
    """Counts days from the first date.

    Which number of 01/02/2024 is the month matters only where the date changes, and is taken such that the days are
    the closer together.
    """

    def __init__(self) -> None:
        self.first: dict[str, int] = {}  # the first date by what it begins with
        self.found = ("", 0)

    @property
    def is_empty(self) -> bool:
        """Whether no date has been read."""
        return not self.first

    def day(self, date: str) -> int:
        """Return the days from the first date to another."""
        if date != self.found[0]:
            self.found = date, self._count(date)
        return self.found[1]

    def _count(self, date: str) -> int:
        days = _readings(date)
        self.first = self.first or days
        counts = {order: days[order] - self.first[order] for order in days.keys() & self.first.keys()}
        if not counts:
            raise validate.wrong_value("time", f"must have dates such as {DATES}, all alike, got {date!r}")
        order = min(counts, key=lambda each: abs(counts[each]))
        if counts[order]:
            self.first = {order: self.first[order]}
        return counts[order]


def _readings(date: str) -> dict[str, int]:
    """Return the number of a date's day for each order in which it may be written, by what comes first."""
    parts = [int(each) for each in re.split(r"[-./]", date)]
    if re.match(r"\d{4}", date):
        orders = {"year": parts}
    else:
        first, second, year = parts
        year += 2000 if year < 100 else 0
        orders = {"day": [year, second, first]} | ({} if "." in date else {"month": [year, first, second]})
    found = {}
    for name, (year, month, day) in orders.items():
        try:
            found[name] = datetime.date(year, month, day).toordinal()
        except ValueError:
            continue
    return found


def _hour(hour: int, half: str | None, cell: str) -> int:
    """Return the hour from 0 to 23."""
    if half is None:
        return hour
    if not 1 <= hour <= 12:
        raise validate.wrong_value("time", f"must have hours from 1 to 12 before AM or PM, got {cell!r}")
    return hour % 12 + (12 if half[0] in "pP" else 0)


def _offset(zone: str | None) -> float:
    """Return the seconds by which a time zone is ahead of UTC."""
    if zone in (None, "", "Z", "z"):
        return 0.0
    hours, minutes = zone[1:3], zone[3:].lstrip(":") or "0"
    return (-1.0 if zone[0] == "-" else 1.0) * (3600.0 * int(hours) + 60.0 * int(minutes))
