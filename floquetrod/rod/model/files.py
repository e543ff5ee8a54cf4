"""Rod files: TOML tables of the parameters of a rod, with units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import located
from floquetrod._util.tables import read_toml, require_known
from floquetrod.rod.model.parts import INSTEAD, MEANT

T = TypeVar("T")

_OF_A_PIPE = ("catalogue", "bore")
_FROM_THE_PIPE = ("youngs_modulus", "density", "radius")
_HOLE = ("channel_radius", "channel_diameter")


def read_rod(path: str | Path, kind: type[T]) -> T:
    """Return the rod of a kind, a dataclass, that a TOML file describes: its fields are the keys, or `INSTEAD` of them.

    Raises ValueError, naming file and key, for files that cannot be read, for unknown and missing keys, for quantities
    that are none and for what the rod refuses.
    """
    path = validate.path("path", path)
    table = read_toml(path, "rod file")
    try:
        return rod_of(table, kind, path.parent)
    except (TypeError, ValueError) as error:
        raise located(f"rod file {path}", error) from None


def rod_of(table: Mapping[str, Any], kind: type[T], folder: Path) -> T:
    """Return the rod that the table of a file in a folder describes, with the survey that it names.

    TypeError or ValueError, naming the key, as `read_rod`.
    """
    needed = {f.name: f.default is MISSING for f in fields(kind)}  # type: ignore[arg-type]  # a dataclass
    _require_keys(table, needed)
    given = {key: _value(key, value, folder) for key, value in table.items()}
    if "catalogue" not in given:
        return kind(**given)
    return kind.catalogue(given.pop("catalogue"), **given)  # type: ignore[attr-defined,no-any-return]


def _require_keys(table: Mapping[str, Any], needed: Mapping[str, bool]) -> None:
    """Raise ValueError for keys that are unknown, or missing."""
    if "catalogue" in table:
        known = [key for key in (*_OF_A_PIPE, *needed, *INSTEAD) if key not in _HOLE]
        least = ["bore", *(key for key, need in needed.items() if need and key not in (*_HOLE, *_FROM_THE_PIPE))]
        if any(key in table for key in _HOLE):
            raise ValueError("bore is the key for the hole of a pipe of the catalogue, in place of a channel")
    else:
        known = [*needed, *INSTEAD, "catalogue"]
        least = [key for key, need in needed.items() if need]
    written = next((key for key in table if key in MEANT), None)
    if written is not None:
        raise ValueError(f"unknown key {written!r}; {MEANT[written]}")
    require_known(table, known)
    given = {*table, *(INSTEAD[key] for key in table if key in INSTEAD)}
    missing = [f"missing key {key!r}" for key in least if key not in given]
    if missing:
        raise ValueError(f"{', '.join(missing)}; the keys are {', '.join(known)}")


def _value(key: str, value: Any, folder: Path) -> Any:
    """Return a quantity in SI units, or the path in a survey; anything else, such as a word, unchanged."""
    if key == "path" and isinstance(value, str):
        from floquetrod.wells.path import WellPath

        return WellPath.from_csv(folder / value)
    return units.quantity(value, key, units.ROD_KINDS[key]) if key in units.ROD_KINDS else value
