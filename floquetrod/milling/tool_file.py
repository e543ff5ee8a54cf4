"""Milling cutters read from TOML files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.tables import read_toml, require_keys
from floquetrod.bare_numbers import Quantity, bare_numbers
from floquetrod.milling.cutter import CUTTER, TOOL_MODE, ToolMode
from floquetrod.parameter import REQUIRED

_RANGES = {"speed": "", "depth": "length"}
"""Ranges that a file may give, and their kinds; spindle speeds are in rpm without a unit."""

_OF_A_MODE = [each for parameter in TOOL_MODE.values() for each in (parameter, *parameter.instead)]


class ToolFile(NamedTuple):
    """What a file says: the arguments of a `Milling`, and ranges of speed and depth such as "0mm:4mm", where given."""

    arguments: dict[str, Any]
    ranges: dict[str, str]


def read_tool(path: str | Path) -> ToolFile:
    """Return the table [tool] of a TOML file; ValueError names the file and a missing or unknown key."""
    path = validate.path("path", path)
    table = read_toml(path, "tool file")
    try:
        if set(table) != {"tool"} or not isinstance(table["tool"], dict):
            raise ValueError("it must hold one table [tool], with [[tool.x]] and [[tool.y]] for the modes")
        given = table["tool"]
        require_keys(given, (*CUTTER, *_RANGES))
        if missing := [key for key, parameter in CUTTER.items() if parameter.default is REQUIRED and key not in given]:
            raise ValueError(f"key {missing[0]!r} is missing")
        _require_units(given)
        arguments = {key: value for key, value in given.items() if key in CUTTER}
        modes = {axis: [_mode(axis, i, mode) for i, mode in enumerate(given.get(axis, []))] for axis in ("x", "y")}
        return ToolFile(arguments | modes, {key: str(given[key]) for key in _RANGES if key in given})
    except (TypeError, ValueError) as error:
        raise ValueError(f"tool file {path}: {error}") from None


_USUAL = {"pressure": "N/mm2", "length": "mm", "mass": "g", "stiffness": "N/um"}
"""Units in which numbers of a cutter may be meant where nothing beside them tells."""


def _require_units(given: dict[str, Any]) -> None:
    """Raise ValueError for a number without a unit where others have theirs; spindle speeds are in rpm without one."""
    kinds = _RANGES | {key: parameter.kind for key, parameter in CUTTER.items()}
    quantities = [
        Quantity(name, value, kind)
        for key, kind in kinds.items()
        if kind and key in given
        for name, value in _each(key, given[key])
    ]
    quantities += [
        Quantity(f"{axis}[{i}]: {parameter.name}", mode[parameter.name], parameter.kind)
        for axis in ("x", "y")
        for i, mode in enumerate(given.get(axis, []))
        for parameter in _OF_A_MODE
        if isinstance(mode, dict) and parameter.name in mode
    ]
    for number in bare_numbers(quantities, _USUAL):
        raise ValueError(f"{number.quantity.name} {number.problem}")


def _each(key: str, value: Any) -> list[tuple[str, Any]]:
    """Return a value by its name, of a list of one for each tooth every one."""
    return [(f"{key}[{i}]", each) for i, each in enumerate(value)] if isinstance(value, list) else [(key, value)]


def spindle_speed(text: str, name: str, least: float = 0.0) -> float:
    """Return a spindle speed in rad/s, of a text whose number alone is in rpm, as on machines."""
    return units.quantity(f"{text}rpm" if units.unit_of(text) == "" else text, name, "frequency", least=least)


def cutting_depth(text: str, name: str) -> float:
    """Return a depth of cut in m; ValueError for a number alone, which may be in mm, unless it is zero."""
    depth = units.quantity(text, name, "length", least=0.0)
    if depth > 0.0 and units.unit_of(text) == "":
        raise ValueError(f"{name} must have a unit, got {text!r}, which may be in m or in mm; write {text.strip()}mm")
    return depth


def _mode(axis: str, number: int, table: Any) -> ToolMode:
    """Return a mode from its table."""
    try:
        if not isinstance(table, dict):
            raise ValueError(f"modes are tables [[tool.{axis}]], got {validate.short(table)}")
        require_keys(table, [parameter.name for parameter in _OF_A_MODE])
        return ToolMode(**table)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{axis}[{number}]: {error}") from None
