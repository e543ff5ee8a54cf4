"""Rod files: TOML tables of the parameters of a rod, with units."""

from __future__ import annotations

import json
import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from floquetrod._util import validate
from floquetrod._util.arguments import Message, argument_of, error_in
from floquetrod._util.calling import level_of_caller
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning
from floquetrod._util.suggest import short
from floquetrod._util.tables import read_toml, require_keys
from floquetrod.bare_numbers import Quantity, bare_numbers
from floquetrod.parameter import REQUIRED
from floquetrod.rod.model.parameters import GIVEN, INSTEAD, MEANT, OF_A_SECTION, ROD, units_given
from floquetrod.units import InUnits

if TYPE_CHECKING:
    from floquetrod.rod.model.sections import Section

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
    rod = _made(_read(table, folder), kind)
    rod.given_in(units_given(table).or_else(rod.given_units))
    _warn_of_bare_numbers(table, kind, folder)
    return rod


def _read(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the arguments of a rod: quantities in SI units, sections as such."""
    return {key: _value(key, value, folder) for key, value in table.items()}


def _made(given: Mapping[str, Any], kind: type[T]) -> T:
    """Return the rod of parameters in SI units."""
    if "catalogue" not in given:
        try:
            return kind(**given)
        except (TypeError, ValueError) as error:
            raise _of_a_bore(error) from None
    parameters = {key: value for key, value in given.items() if key != "catalogue"}
    return kind.catalogue(given["catalogue"], **parameters)  # type: ignore[attr-defined,no-any-return]


def _of_a_bore(error: TypeError | ValueError) -> TypeError | ValueError:
    """Return an error that calls a bore by its number from 1, as lines of a file are counted."""
    about = argument_of(error)
    if about is None or about.name != "bores" or not about.place:
        return error
    return ValueError(about.named(f"bore {int(about.place) + 1}"))


class _Written(NamedTuple):
    """A quantity as a file has it, and where: the keys and numbers of its table, its list and itself."""

    quantity: Quantity
    at: tuple[str | int, ...]


def _written(table: Mapping[str, Any]) -> Iterator[_Written]:
    """Yield the quantities of a rod file, its sections and bores included."""
    kinds = {name: parameter.kind for name, parameter in GIVEN.items() if parameter.kind}
    for key, value in table.items():
        if key in kinds:
            yield _Written(Quantity(key, value, kinds[key]), (key,))
    for i, section in enumerate(table.get("sections", ())):
        for key, value in section.items():
            if key in kinds:
                yield _Written(Quantity(f"section {i + 1}: {key}", value, kinds[key]), ("sections", i, key))
    for i, pair in enumerate(table.get("bores", ())):
        for k, what in enumerate(("depth", "diameter")):
            yield _Written(Quantity(f"bore {i + 1}: {what}", pair[k], "length"), ("bores", i, k))


def _with(table: Any, at: tuple[str | int, ...], value: Any) -> Any:
    """Return a copy of a table, or of a list in it, with another value somewhere."""
    if not at:
        return value
    first, *inside = at
    changed = dict(table) if isinstance(table, Mapping) else list(table)
    changed[first] = _with(table[first], tuple(inside), value)  # type: ignore[index]
    return changed


def _warn_of_bare_numbers(table: Mapping[str, Any], kind: type[T], folder: Path) -> None:
    """Warn of a number without a unit that may be meant in another one, with which the rod is plausible, too.

    The rod itself warns of an implausible number.
    """
    written = {each.quantity.name: each for each in _written(table)}
    for number in bare_numbers(each.quantity for each in written.values()):
        name, value, _ = number.quantity
        at = written[name].at
        if all(_is_plausible(_with(table, at, each), kind, folder) for each in (value, f"{value}{number.other}")):
            text = Message(f"in the file {number.warning}", SILENCE)
            warnings.warn(text, PlausibilityWarning, stacklevel=level_of_caller())


def _is_plausible(table: Mapping[str, Any], kind: type[T], folder: Path) -> bool:
    """Return whether a rod is one, and warns of nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", PlausibilityWarning)
        try:
            _made(_read(table, folder), kind)
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
        if any(key in table for key in ("sections", "bores")):
            raise ValueError(
                "catalogue must not be given with sections or bores; write a table [[sections]] with "
                f"name = {json.dumps(table['catalogue'], default=str)} and a length"
            )
    else:
        known = [*ROD, *INSTEAD, "catalogue"]
        left_out = (*(OF_A_SECTION if "sections" in table else ()), *(_HOLE if "bores" in table else ()))
        needed = [key for key in required if key not in left_out]
    _require_these(table, known, needed)


def _require_these(table: Mapping[str, Any], known: Collection[str], needed: Iterable[str]) -> None:
    """Raise ValueError for unknown keys of a table, and for missing ones."""
    written = next((key for key in table if key in MEANT and key not in known), None)
    if written is not None:
        raise ValueError(f"unknown key {written!r}; {MEANT[written]}")
    require_keys(table, known)
    given = {*table, *(INSTEAD[key] for key in table if key in INSTEAD)}
    missing = [f"missing key {key!r}" for key in needed if key not in given]
    if missing:
        raise ValueError(f"{', '.join(missing)}; the keys are {', '.join(known)}")


def _sections(tables: Any) -> tuple[Section, ...]:
    """Return the sections that the tables of a file describe, which messages count from 1."""
    from floquetrod.rod.model.sections import Section, sections_of

    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise ValueError(f"sections must be tables [[sections]], got {short(tables)}")
    made = []
    for i, table in enumerate(tables):
        try:
            needed = ("length",) if "name" in table else ("length", "radius")
            _require_these(table, ("name", *OF_A_SECTION, *(k for k in INSTEAD if INSTEAD[k] in OF_A_SECTION)), needed)
            made.append(Section(**table))
        except (TypeError, ValueError) as error:
            raise error_in(f"section {i + 1}", error) from None
    return sections_of(made)


def _value(key: str, value: Any, folder: Path) -> Any:
    """Return a quantity in SI units, or the path in a survey; anything else, such as a word, unchanged."""
    if key == "path" and (isinstance(value, str) or (isinstance(value, Mapping) and "file" in value)):
        from floquetrod.wells.path import WellPath

        given = {"file": value} if isinstance(value, str) else dict(value)
        require_keys(given, ("file", *SURVEY_KEYS))
        return WellPath.from_csv(folder / given.pop("file"), **given)
    if key == "sections":
        return _sections(value)
    return GIVEN[key].quantity(value, key) if key in GIVEN and GIVEN[key].kind else value
