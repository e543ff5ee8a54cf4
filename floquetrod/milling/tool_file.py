"""Milling cutters read from TOML files."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.tables import read_toml, require_known
from floquetrod.milling.cutter import ToolMode

_KEYS = ("x", "y", "teeth", "tangential", "radial", "immersion", "direction")
_RANGES = ("speed", "depth")
_OF_A_MODE = ("frequency", "damping_ratio", "mass", "stiffness")
_REQUIRED = ("teeth", "tangential", "radial")


class ToolFile(NamedTuple):
    """What a file says: the arguments of a `Milling`, and ranges of speed and depth such as "0mm:4mm", where given."""

    arguments: dict[str, Any]
    ranges: dict[str, str]


def read_tool(path: str | Path) -> ToolFile:
    """Return the table [tool] of a TOML file; ValueError names file and key of what is missing or not known."""
    path = validate.path("path", path)
    table = read_toml(path, "tool file")
    try:
        if set(table) != {"tool"} or not isinstance(table["tool"], dict):
            raise ValueError("it must hold one table [tool], with [[tool.x]] and [[tool.y]] for the modes")
        given = table["tool"]
        require_known(given, (*_KEYS, *_RANGES))
        if missing := [key for key in _REQUIRED if key not in given]:
            raise ValueError(f"key {missing[0]!r} is missing")
        arguments = {key: value for key, value in given.items() if key in _KEYS}
        modes = {axis: [_mode(axis, i, mode) for i, mode in enumerate(given.get(axis, []))] for axis in ("x", "y")}
        return ToolFile(arguments | modes, {key: str(given[key]) for key in _RANGES if key in given})
    except (TypeError, ValueError) as error:
        raise ValueError(f"tool file {path}: {error}") from None


def _mode(axis: str, number: int, table: Any) -> ToolMode:
    """Return a mode from its table."""
    try:
        if not isinstance(table, dict):
            raise ValueError(f"modes are tables [[tool.{axis}]], got {validate.short(table)}")
        require_known(table, _OF_A_MODE)
        return ToolMode(**table)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{axis}[{number}]: {error}") from None
