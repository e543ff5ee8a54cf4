"""Rod files: TOML tables of the parameters of a rod, with units."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from floquetrod._util import validate
from floquetrod._util.arguments import Message, error_in
from floquetrod._util.calling import level_of_caller
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning
from floquetrod._util.tables import read_toml, require_keys
from floquetrod.bare_numbers import Quantity, bare_numbers
from floquetrod.parameter import REQUIRED
from floquetrod.rod.model.parameters import GIVEN, INSTEAD, MEANT, ROD, units_given
from floquetrod.units import InUnits

T = TypeVar("T", bound=InUnits)

_OF_A_PIPE = ("catalogue", "bore")
_FROM_THE_PIPE = ("youngs_modulus", "density", "radius")
_HOLE = ("channel_radius", "channel_diameter")


SURVEY_KEYS = ("depth", "inclination", "azimuth", "depth_unit", "angle_unit", "delimiter", "sheet", "to")
"""Keys of a table ``path`` beside its ``file``: the arguments of `floquetrod.WellPath.from_csv`."""


def read_rod(path: str | Path, kind: type[T]) -> T:
    """Return the rod of a kind, a dataclass, that a TOML file describes: keys are its parameters, or `INSTEAD` of them.

    Raises ValueError, naming file and key, for files that cannot be read, for unknown and missing keys, for text that
    is no quantity and for values that the rod refuses.
    """
    path = validate.path("path", path)
    table = read_toml(path, "rod file")
    try:
        return rod_of(table, kind, path.parent)
    except (TypeError, ValueError) as error:
        raise error_in(f"rod file {path}", error) from None


def rod_of(table: Mapping[str, Any], kind: type[T], folder: Path) -> T:
    """Return the rod that the table of a file in a folder describes, with the survey that it names.

    TypeError or ValueError, naming the key, as `read_rod`.
    """
    _require_keys(table)
    rod = _made({key: _value(key, value, folder) for key, value in table.items()}, kind)
    rod.given_in(units_given(table).or_else(rod.given_units))
    _warn_of_bare_numbers(table, kind, folder)
    return rod


def _made(given: Mapping[str, Any], kind: type[T]) -> T:
    """Return the rod of parameters in SI units."""
    if "catalogue" not in given:
        return kind(**given)
    parameters = {key: value for key, value in given.items() if key != "catalogue"}
    return kind.catalogue(given["catalogue"], **parameters)  # type: ignore[attr-defined,no-any-return]


def _warn_of_bare_numbers(table: Mapping[str, Any], kind: type[T], folder: Path) -> None:
    """Warn of a number without a unit that may be meant in another one, with which the rod is plausible, too.

    The rod itself warns of an implausible number.
    """
    kinds = {name: parameter.kind for name, parameter in GIVEN.items() if parameter.kind}
    quantities = (Quantity(key, value, kinds[key]) for key, value in table.items() if key in kinds)
    for number in bare_numbers(quantities):
        name, value, _ = number.quantity
        if all(_is_plausible({**table, name: each}, kind, folder) for each in (value, f"{value}{number.other}")):
            text = Message(f"in the file {number.warning}", SILENCE)
            warnings.warn(text, PlausibilityWarning, stacklevel=level_of_caller())


def _is_plausible(table: Mapping[str, Any], kind: type[T], folder: Path) -> bool:
    """Return whether a rod is one, and warns of nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", PlausibilityWarning)
        try:
            _made({key: _value(key, value, folder) for key, value in table.items()}, kind)
        except (PlausibilityWarning, TypeError, ValueError):
            return False
    return True


def _require_keys(table: Mapping[str, Any]) -> None:
    """Raise ValueError for unknown and for missing keys."""
    required = [name for name, parameter in ROD.items() if parameter.default is REQUIRED]
    if "catalogue" in table:
        known = [key for key in (*_OF_A_PIPE, *ROD, *INSTEAD) if key not in _HOLE]
        needed = ["bore", *(key for key in required if key not in (*_HOLE, *_FROM_THE_PIPE))]
        if any(key in table for key in _HOLE):
            raise ValueError("bore is the key for the hole of a pipe of the catalogue, in place of a channel")
    else:
        known = [*ROD, *INSTEAD, "catalogue"]
        needed = required
    written = next((key for key in table if key in MEANT), None)
    if written is not None:
        raise ValueError(f"unknown key {written!r}; {MEANT[written]}")
    require_keys(table, known)
    given = {*table, *(INSTEAD[key] for key in table if key in INSTEAD)}
    missing = [f"missing key {key!r}" for key in needed if key not in given]
    if missing:
        raise ValueError(f"{', '.join(missing)}; the keys are {', '.join(known)}")


def _value(key: str, value: Any, folder: Path) -> Any:
    """Return a quantity in SI units, or the path in a survey; anything else, such as a word, unchanged."""
    if key == "path" and (isinstance(value, str) or (isinstance(value, Mapping) and "file" in value)):
        from floquetrod.wells.path import WellPath

        given = {"file": value} if isinstance(value, str) else dict(value)
        require_keys(given, ("file", *SURVEY_KEYS))
        return WellPath.from_csv(folder / given.pop("file"), **given)
    return GIVEN[key].quantity(value, key) if key in GIVEN and GIVEN[key].kind else value
