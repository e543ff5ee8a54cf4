"""Quantities as people write them, "0.2Fcr", "24Hz", "2.375in", "9.2ppg", and the units that answers are in."""

from __future__ import annotations

from floquetrod.units.answer_units import AnswerUnits, GivenUnits, InUnits
from floquetrod.units.quantities import (
    array,
    in_si,
    is_written,
    number,
    quantity,
    same_unit,
    si,
    single,
    tolerance,
    unit_of,
)
from floquetrod.units.table import Unit, heading, is_unit, kind_of, label, unit, units_of, with_unit

__all__ = [
    "AnswerUnits",
    "GivenUnits",
    "InUnits",
    "Unit",
    "array",
    "heading",
    "in_si",
    "is_unit",
    "is_written",
    "kind_of",
    "label",
    "number",
    "quantity",
    "same_unit",
    "si",
    "single",
    "tolerance",
    "unit",
    "unit_of",
    "units_of",
    "with_unit",
]
