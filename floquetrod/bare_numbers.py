"""Numbers without a unit among quantities that have one: in which other unit they may have been meant.

A number alone is in the SI unit of its kind.  Beside "200N/mm2" a 600 is probably not in Pa, and beside "50ft" a 15 is
not in rad/s: both readings are named, and whoever reads the text refuses or warns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from floquetrod import units

_USUAL = {"frequency": "Hz", "angle": "deg", "curvature": "deg/30m", "weight": "kg/m"}
"""Units that people think in where the SI unit counts radians, or newtons of a weight."""

_IN_FEET = {
    "force": "lbf",
    "length": "ft",
    "pressure": "psi",
    "density": "ppg",
    "weight": "lb/ft",
    "speed": "ft/min",
    "frequency": "Hz",
    "angle": "deg",
    "curvature": "deg/100ft",
}
_FEET = re.compile(
    "k?lbf|lbs?|kips?|in|inch|inches|ft|foot|feet|m?psi|ksi|ppg|pcf|ppf|lbf?/.*|.*/(100)?ft|ft/.*", re.IGNORECASE
)
"""Units beside which those of `_IN_FEET` are usual."""

_ALONG = ("length", "depth", "depths")
"""Ends of the names of lengths that are in feet where diameters are in inches."""

_RELATIVE = ("fcr", "%")
"""Units that are parts of something else."""

_LARGEST = {"pressure": 2e12, "density": 3e4}
"""In the SI unit, stiffer than diamond and heavier than osmium: what a number cannot have been meant as (a choice)."""


class Quantity(NamedTuple):
    """A quantity as typed: its name in messages, its value (text or number), and its kind, see `floquetrod.units`."""

    name: str
    value: Any
    kind: str

    @property
    def unit(self) -> str | None:
        """The unit of a text, "" for a number, None for nothing of these."""
        if isinstance(self.value, str):
            return units.unit_of(self.value)
        return "" if isinstance(self.value, int | float) and not isinstance(self.value, bool) else None

    @property
    def size(self) -> float:
        """The size of the number, without its unit."""
        return abs(units.quantity(self.value, self.name, self.kind))

    @property
    def numbers(self) -> list[Quantity]:
        """Each number of a range or a list, which has the unit of the last one where it has none."""
        if not isinstance(self.value, str):
            return [self]
        return [self._replace(value=text) for text in units.same_unit(*re.split("[:,]", self.value))]


class BareNumber(NamedTuple):
    """A number without a unit, the SI unit and another one it may be in, and a quantity beside it that has a unit."""

    quantity: Quantity
    unit: str
    other: str
    beside: Quantity

    @property
    def readings(self) -> str:
        """How to write it in either unit."""
        typed = str(self.quantity.value).strip()
        return f"{typed}{self.unit} or {typed}{self.other}"

    @property
    def problem(self) -> str:
        """The rest of a sentence that refuses it."""
        return (
            f"must have a unit, as {self.beside.name} {str(self.beside.value)!r} has: got {self.quantity.value}, "
            f"which may be in {self.unit} or in {self.other}; write {self.readings}"
        )

    @property
    def warning(self) -> str:
        """A sentence that warns of it."""
        name, value = self.quantity.name, self.quantity.value
        return (
            f"{name} {value} is taken in {self.unit}, and {self.beside.name} {str(self.beside.value)!r} has a unit; "
            f"write {self.readings}"
        )


def bare_numbers(
    quantities: Iterable[Quantity], usual: Mapping[str, str] | None = None, shown: Iterable[str] = ()
) -> list[BareNumber]:
    """Return the numbers without a unit that may have been meant in another unit, where other quantities have a unit.

    The suspected unit is the one in which another quantity of the same kind is given, or else the usual one of the
    kind: degrees for an angle, pounds beside feet, or the entry of ``usual``.  ``shown`` are the units requested for
    the answer.  Critical forces and percentages say nothing about other kinds; zero is the same in every unit.
    """
    listed = [number for each in quantities for number in each.numbers if each.kind != "ratio"]
    with_unit = [each for each in listed if each.unit]
    of_any_kind = [each for each in with_unit if str(each.unit).lower() not in _RELATIVE]
    in_feet = any(_FEET.fullmatch(name) for name in (*(str(each.unit) for each in of_any_kind), *shown))
    usually = {**(usual or {}), **_USUAL, **(_IN_FEET if in_feet else {})}
    ambiguous = []
    for each in (each for each in listed if each.unit == "" and each.size > 0.0):
        alike = [other for other in with_unit if other.kind == each.kind]
        si = next(iter(units.units_of(each.kind)))
        other = next(
            (like.unit for like in alike if like.unit not in (si, "%")), None if alike else usually.get(each.kind)
        )
        if other == "in" and each.name.endswith(_ALONG):
            other = "ft"
        if other is not None and (alike or of_any_kind) and _is_possible(each, other):
            ambiguous.append(BareNumber(each, si, other, (alike or of_any_kind)[0]))
    return ambiguous


def _is_possible(quantity: Quantity, unit: str) -> bool:
    """Return whether a number in a unit is plausible."""
    size = units.unit(unit, quantity.name, quantity.kind, 1.0).size
    return quantity.size * size <= _LARGEST.get(quantity.kind, math.inf)
