"""Systems and families of systems read from files: TOML tables, and npz files of arrays."""

from __future__ import annotations

import math
import re
import tomllib
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.formulas import WORDS, Formula
from floquetrod._util.sealed_files import Arrays, require_regular
from floquetrod._util.tables import read_toml, require_keys
from floquetrod.equations import matrices
from floquetrod.equations.delay_system import DelaySystem
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.pieces import Varying, refuse_mean_with_slope

_SERIES = ("cosines", "sines", "period", "frequency")
_SECOND_ORDER = ("stiffness", "mass", "damping", "gyroscopic", "coefficient_error", "delayed", "pieces", *_SERIES)
_FIRST_ORDER = ("mean", "coefficient_error", "delayed", "pieces", *_SERIES)
_DELAYED = ("delay", "matrix", "cosines", "sines", "pieces")
_STARTS = {"stiffness": "stiffness_start", "mean": "matrix_start", "matrix": "matrix_start"}
"""Keys of a piece's matrix at its beginning, which go with a slope, in place of its constant matrix."""

_OF_A_DELAYED_PIECE = ("duration", "matrix", "matrix_start", "slope", "cosines", "sines")
_OF_A_PIECE = ("duration", "stiffness", "stiffness_start", "mean", "matrix_start", "slope", "cosines", "sines")
_KEYS = tuple(dict.fromkeys((*_SECOND_ORDER, *_FIRST_ORDER)))
_MATRICES = (*_OF_A_PIECE[1:], "mass", "damping", "gyroscopic", "delayed", "delayed_cosines", "delayed_sines")
_COMPLEX = ("mean", "matrix_start", "slope", "cosines", "sines")
_TABLED = {*_MATRICES, "matrix"} - {"delayed"}  # keys of matrices in TOML files
_IMAGINARY_UNIT = re.compile(r"(?<![^\W\d])[ijI]\b")
_REAL = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBER = re.compile(rf"(?P<real>[+-]?{_REAL}(?![\d.eE]*[ij]))?(?:(?P<imaginary>[+-]?(?:{_REAL})?)[ij])?")
_SMALL = 1 << 20  # entries of an array that is read unchecked (a choice)
_FORMULAS = "formulas need a table [parameters], which may be empty"
_QUANTITIES = ("period", "frequency", "delay", "duration")  # keys whose texts may have a unit
_DEEPEST = 16  # nested lists and tables; a piece of a delayed term has nine (a choice)
_LARGEST = {".toml": 1 << 26, ".npz": 1 << 32}  # bytes that are read, in npz files unpacked (a choice)


class SystemFamily(NamedTuple):
    """A family of systems in a file: the function of two parameters, and the ends of their ranges.

    ``with_unit`` as of `SystemFile`.
    """

    system: Callable[..., HillSystem | PeriodicSystem | DelaySystem]
    over: dict[str, tuple[float, float]]
    with_unit: str


class SystemFile(NamedTuple):
    """A system in a file, and a time or a frequency there that has a unit, as in 'frequency = "24Hz"', "" without any.

    With a unit time is in seconds.
    """

    system: HillSystem | PeriodicSystem | DelaySystem
    with_unit: str


def read_system(
    path: str | Path, values: Mapping[str, Any] = MappingProxyType({})
) -> HillSystem | PeriodicSystem | DelaySystem:
    """Read one system from a file, as `read_system_file` does, which says whether time is in seconds."""
    return read_system_file(path, values).system


def read_system_file(path: str | Path, values: Mapping[str, Any] = MappingProxyType({})) -> SystemFile:
    """Read one system from a TOML file, under [system], or from an npz file of arrays.

    Keys, or names of arrays, are the parameters of `HillSystem` (with ``stiffness``) or of `PeriodicSystem` (with
    ``mean``), in any units that fit together.  In place of ``period`` there may be ``frequency``, angular: 2 pi /
    period.  Both may be strings with a unit, such as "24Hz" or "0.2s", where time is in seconds.

    A coefficient in pieces, which may jump, has a table [[system.pieces]] for each, with its ``duration`` and its
    ``stiffness`` or ``mean``, and with ``slope``, ``cosines`` and ``sines`` where it varies as `Varying` does.  Beside
    a ``slope`` it has its value at the beginning of the piece, ``stiffness_start`` or, in first order,
    ``matrix_start``, in place of ``stiffness`` or ``mean``.  In an npz file an array of all ``durations`` says so; the
    other arrays then have the pieces as their first axis.

    Delayed terms have, in TOML files, a table [[system.delayed]] each, with the ``delay`` and the ``matrix``, with
    ``cosines`` and ``sines``, or with tables [[system.delayed.pieces]] of ``duration`` and ``matrix``, or
    ``matrix_start`` and ``slope``.  In npz files they are arrays with the terms as their first axis: ``delays``,
    ``delayed``, ``delayed_cosines`` and ``delayed_sines``.

    A TOML file may have [parameters] and formulas of them, as of `read_family`, where each parameter has a number, in
    the file or in ``values``, by its name.

    In first order without delays entries may be complex: in TOML files texts such as "-0.1+2i", "0.5i" or "-i", among
    numbers; in npz files arrays are complex.

    Raises
    ------
    ValueError
        Naming file and key: for files that cannot be read, are too large or of another kind, for unknown and missing
        keys, and for values that the constructors refuse.
    """
    path = validate.path("path", path)
    readers = {".toml": _toml, ".npz": _npz}
    if path.suffix not in readers:
        raise ValueError(f"system file {path} must end in .toml or .npz")
    try:
        require_regular(path, _LARGEST[path.suffix])
        table = readers[path.suffix](path)
    except (OSError, ValueError, KeyError, EOFError, NotImplementedError, RecursionError, zipfile.BadZipFile) as error:
        raise ValueError(f"system file {path} cannot be read: {error}") from None
    try:
        numbers = _at_values(table, values)
        return SystemFile(_system(_with_numbers(numbers, _takes_complex(numbers))), _with_unit(table))
    except (TypeError, ValueError) as error:
        is_formula = "parameters" not in table and _holds_formula(table, _takes_complex(table))
        remedy = f"; {_FORMULAS}" if is_formula else ""
        raise ValueError(f"system file {path}: {error}{remedy}") from None


def _with_unit(value: Any) -> str:
    """Return the first time or frequency with a unit in a table or list of tables, as a line of its file."""
    if not isinstance(value, dict):
        return next(filter(None, map(_with_unit, value)), "") if isinstance(value, list) else ""
    for key, entry in value.items():
        if key in _QUANTITIES and isinstance(entry, str) and _has_unit(entry):
            return f'{key} = "{entry}"'
        if found := _with_unit(entry):
            return found
    return ""


def read_family(path: str | Path) -> SystemFamily:
    """Read a family of systems from a TOML file: [system] as of `read_system_file`, and [parameters].

    Two parameters have a range, a text such as "1.5:4.5", the first one along the columns of a chart; others have a
    number.  In place of any number of the system there may be a formula of them, a text such as "0.5*epsilon**2": with
    + - * / **, brackets, pi, sqrt, exp, log, sin, cos and tan, and in first order without delays with i.

    Raises
    ------
    ValueError
        Naming file and key: for files that cannot be read, for other than two ranges, for texts that are no formula,
        and for parameters that no formula names.
    """
    path = validate.path("path", path)
    if path.suffix != ".toml":
        raise ValueError(f"system file {path} must end in .toml: a family of systems has formulas")
    text = read_toml(path, "system file")
    try:
        _require_shallow(text)
        return _family(text, path.stem)
    except (TypeError, ValueError) as error:
        raise ValueError(f"system file {path}: {error}") from None


def _holds_formula(value: Any, imaginary: bool) -> bool:
    """Return whether a text in a table is a formula, such as "2*pi", and no number; ``imaginary`` as of `Formula`."""
    if isinstance(value, dict | list):
        entries = value.values() if isinstance(value, dict) else value
        return any(_holds_formula(entry, imaginary) for entry in entries)
    if not isinstance(value, str) or _parts(value) is not None:
        return False
    try:
        Formula.read(value, imaginary=imaginary)
        return True
    except ValueError:
        return False


def _toml(path: Path) -> Mapping[str, Any]:
    """Return the table [system] of a TOML file, with [parameters] both tables."""
    text = tomllib.loads(path.read_text(encoding="utf-8"))
    _require_shallow(text)
    table = text.pop("system", None)
    if not isinstance(table, dict):
        raise ValueError("it has no table [system]")
    if set(text) == {"parameters"}:
        return {"system": table, **text}
    if text:
        raise ValueError(f"it holds {', '.join(map(repr, text))} outside of [system]")
    return table


def _require_shallow(value: Any, levels: int = _DEEPEST) -> None:
    """Raise ValueError for lists in tables that are nested more deeply than any system has them."""
    if isinstance(value, dict | list):
        if not levels:
            raise ValueError(f"it has lists or tables nested more than {_DEEPEST} deep")
        for entry in value.values() if isinstance(value, dict) else value:
            _require_shallow(entry, levels - 1)


def _npz(path: Path) -> Mapping[str, Any]:
    """Return the arrays of an npz file, single numbers and words as such."""
    with Arrays.opened(path, path.stat().st_size) as content:
        if content.size > _LARGEST[".npz"]:
            raise ValueError(f"it holds {content.size:,} bytes, at most {_LARGEST['.npz']:,} are read")
        _require_possible({name: header.shape for name, header in content.headers.items()})
        arrays = dict(content)
    table = {name: value if value.ndim else value.item() for name, value in arrays.items()}
    whole = _by_piece(table) if "durations" in table else table
    return _by_delay(whole) if "delays" in whole else whole


def _require_possible(shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Raise ValueError for large arrays that no system can have, before they are read."""
    order = next((shapes[name][-1:] for name in ("stiffness", "mean") if name in shapes), (0,)) or (0,)
    for name, shape in shapes.items():
        harmonics, pieces = name.endswith(("cosines", "sines")), name in _OF_A_PIECE and "durations" in shapes
        stacked = harmonics + pieces + name.startswith("delayed")
        is_matrix = shape[-2:] == 2 * order and len(shape) <= 2 + stacked and order[0] <= matrices.MOST_EQUATIONS
        if math.prod(shape) > _SMALL and not (name in _MATRICES and is_matrix):
            raise ValueError(f"array {name!r} has shape {shape}, which no system of its other arrays takes")


def _by_delay(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return arrays with an axis of delayed terms as a table of each."""
    delays = np.atleast_1d(table["delays"]).tolist()
    names = {"delayed": "matrix", "delayed_cosines": "cosines", "delayed_sines": "sines"}
    terms = [{"delay": delay} for delay in delays]
    for key, name in names.items():
        if key in table:
            value = np.asarray(table[key])
            if value.shape[:1] != (len(delays),):
                raise ValueError(f"array {key!r} must have {len(delays)} terms as delays has, got shape {value.shape}")
            terms = [term | {name: value[i]} for i, term in enumerate(terms)]
    return {key: value for key, value in table.items() if key not in ("delays", *names)} | {"delayed": terms}


def _by_piece(table: dict[str, Any]) -> Mapping[str, Any]:
    """Return arrays with an axis of pieces as a table of each piece."""
    durations = np.atleast_1d(table.pop("durations")).tolist()
    stacked = {key: table.pop(key) for key in _OF_A_PIECE if key in table}
    for key, value in stacked.items():
        if len(np.atleast_1d(value)) != len(durations):
            raise ValueError(f"array {key!r} must have {len(durations)} pieces as durations has, got {np.shape(value)}")
    pieces = [{"duration": duration} for duration in durations]
    return table | {
        "pieces": [piece | {key: value[i] for key, value in stacked.items()} for i, piece in enumerate(pieces)]
    }


def _takes_complex(table: Mapping[str, Any]) -> bool:
    """Return whether the entries of a system may be complex: in first order without delays."""
    pieces = table.get("pieces")
    tables = [table, *(pieces if isinstance(pieces, list) else [])]
    keys = {key for part in tables if isinstance(part, Mapping) for key in part}
    return "delayed" not in keys and not keys.isdisjoint(("mean", _STARTS["mean"]))


def _with_numbers(value: Any, is_complex: bool, name: str = "", key: str = "") -> Any:
    """Return a table, or a value of one, with texts such as "-0.1+2i" in matrices as complex numbers.

    ValueError names the entry that is another text, or one of a system whose numbers are real.
    """
    if isinstance(value, dict):
        dot = f"{name}." if name else ""
        return {each: _with_numbers(entry, is_complex, f"{dot}{each}", each) for each, entry in value.items()}
    if isinstance(value, list):
        return [_with_numbers(entry, is_complex, f"{name}[{i}]", key) for i, entry in enumerate(value)]
    if not isinstance(value, str) or key not in _TABLED:
        return value
    if is_complex and key in _COMPLEX:
        return _complex(value, name)
    raise ValueError(
        f"{name} must be a real number, got {validate.short(value)}{_imaginary_hint(value, is_complex=False)}"
    )


def _complex(text: str, name: str) -> complex:
    """Return the complex number of a text; ValueError names the entry."""
    parts = _parts(text)
    if parts is None:
        hint = _imaginary_hint(text, is_complex=True)
        raise ValueError(
            f'{name} must be a number, or a text such as "-0.1+2i" for a complex one, got {validate.short(text)}{hint}'
        )
    imaginary = parts["imaginary"]
    if imaginary is None:
        return complex(float(parts["real"]))
    return complex(float(parts["real"] or 0.0), float(f"{imaginary}1" if imaginary in ("", "+", "-") else imaginary))


def _parts(text: str) -> re.Match[str] | None:
    """Return the real and the imaginary part of the number that a text is, None for any other text."""
    compact = re.sub(r"\s", "", text)
    return _NUMBER.fullmatch(compact) if compact else None


def _imaginary_hint(text: str, *, is_complex: bool) -> str:
    """Return how to write the imaginary unit in place of that of a text, or where entries may be complex."""
    unit = _IMAGINARY_UNIT.search(text)
    if unit is None:
        return ""
    if not is_complex:
        return "; complex entries need mean, in first order without delays"
    return "; the imaginary unit is written i" if unit[0] == "I" else ""


def _system(table: Mapping[str, Any]) -> HillSystem | PeriodicSystem | DelaySystem:
    """Return the system of a table; ValueError or TypeError names the key."""
    require_keys(table, _KEYS)
    if "pieces" in table:
        return _in_pieces(table)
    if ("stiffness" in table) == ("mean" in table):
        both = "stiffness and mean" if "mean" in table else "neither stiffness nor mean"
        raise ValueError(f"it has {both}; give stiffness for M q'' + (C + G) q' + K(t) q = 0, mean for x' = A(t) x")
    first_order = "mean" in table
    misplaced = [key for key in table if key not in (_FIRST_ORDER if first_order else _SECOND_ORDER)]
    if misplaced:
        form = "mean, in first order" if first_order else "stiffness, in second order"
        raise ValueError(f"key {misplaced[0]!r} does not go with {form}")
    given = {key: value for key, value in table.items() if key != "frequency"} | _period(table)
    if "delayed" in table:
        given["delayed"] = [_delayed(f"delayed[{i}]", term) for i, term in enumerate(_tables(table, "delayed"))]
        return DelaySystem.first_order(**given) if first_order else DelaySystem(**given)
    system = PeriodicSystem(**given) if first_order else HillSystem(**given)
    matrices.require_one(system)
    return system


def _at_values(text: Mapping[str, Any], values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the table of a system at the numbers of its parameters."""
    if "parameters" not in text or "system" not in text:
        if values:
            raise ValueError(f"it has no table [parameters], and a value of {next(iter(values))!r} was given")
        return text
    if isinstance(text["parameters"], dict):
        require_keys(values, text["parameters"])
        text = {**text, "parameters": {**text["parameters"], **values}}
    constants, over, table = _in_formulas(text)
    if over:
        name, (low, high) = next(iter(over.items()))
        raise ValueError(
            f"parameter {name!r} must have a number for one system, got the range {low:g}:{high:g}; give it one, in "
            f"the terminal --set {name}={0.5 * (low + high):.3g}, or draw them all by floquetrod chart"
        )
    numbers: Mapping[str, Any] = _with_values(table, constants)
    return numbers


class _InFormulas(NamedTuple):
    """Numbers and ranges of the parameters of a file, and its system with formulas of them."""

    constants: dict[str, float]
    over: dict[str, tuple[float, float]]
    table: Any


def _in_formulas(text: Mapping[str, Any]) -> _InFormulas:
    """Return the parameters and the system of a file's tables."""
    require_keys(text, ("system", "parameters"))
    for key in ("system", "parameters"):
        if not isinstance(text.get(key), dict):
            raise ValueError(f"it has no table [{key}]" + " with two ranges" * (key == "parameters"))
    constants: dict[str, float] = {}
    over: dict[str, tuple[float, float]] = {}
    for key, value in text["parameters"].items():
        if not key.isidentifier() or key in WORDS:
            raise ValueError(
                f"parameters must have names of letters such as omega, none of {', '.join(WORDS)}: {key!r}"
            )
        ends = [_constant(end, key) for end in (value.split(":") if isinstance(value, str) else [value])]
        if len(ends) == 1:
            constants[key] = ends[0]
        elif len(ends) == 2 and ends[0] < ends[1]:
            over[key] = ends[0], ends[1]
        else:
            raise ValueError(f'{key} must be a number or a range from less to more such as "1.5:4.5", got {value!r}')
    named: set[str] = set()
    table = _with_formulas(text["system"], {*constants, *over}, named)
    if unused := [key for key in (*over, *constants) if key not in named]:
        raise ValueError(f"no formula of the system has the parameter {unused[0]!r}")
    return _InFormulas(constants, over, table)


def _family(text: Mapping[str, Any], name: str) -> SystemFamily:
    """Return the family of a file's tables."""
    constants, over, table = _in_formulas(text)
    if len(over) != 2:
        raise ValueError(f'two parameters must have ranges such as "1.5:4.5", got {", ".join(over) or "none"}')

    def system(**point: float) -> HillSystem | PeriodicSystem | DelaySystem:
        return _system(_with_values(table, constants | point))

    system.__name__ = name
    return SystemFamily(system, over, _with_unit(text))


def _constant(value: Any, key: str) -> float:
    """Return the number of a parameter, which may be a formula without names."""
    try:
        number = Formula.read(value).value({}) if isinstance(value, str) else value
    except ValueError as error:
        number_with_unit = isinstance(value, str) and re.fullmatch(
            r"\s*[-+]?[\d.]+(e[-+]?\d+)?\s*[^\W\d][\w/^]*\s*", value
        )
        numbers = "a number without a unit" if number_with_unit else "a number"
        raise ValueError(f"{key} must be {numbers}, or a formula of numbers such as 2*pi, got {error}") from None
    return validate.finite(key, number)


def _with_formulas(table: Any, parameters: set[str], named: set[str], name: str = "", key: str = "") -> Any:
    """Return a table with formulas in place of texts, and enter the parameters that these name."""
    if isinstance(table, dict):
        dot = f"{name}." if name else ""
        return {each: _with_formulas(value, parameters, named, f"{dot}{each}", each) for each, value in table.items()}
    if isinstance(table, list):
        return [_with_formulas(entry, parameters, named, f"{name}[{i}]", key) for i, entry in enumerate(table)]
    if not isinstance(table, str) or (key in _QUANTITIES and _has_unit(table)):
        return table
    try:
        formula = Formula.read(table, imaginary=key in _COMPLEX)
        formula.require(parameters)
    except ValueError as error:
        hint = _imaginary_hint(table, is_complex=key in _COMPLEX)
        raise ValueError(f"{name} must be a number or a formula such as '0.5*epsilon', got {error}{hint}") from None
    named.update(formula.names)
    return formula


def _has_unit(text: str) -> bool:
    """Return whether a text is a number with a unit; in "2*pi*24" an operator, no unit, follows the number."""
    unit = units.unit_of(text)
    return bool(unit) and str(unit)[0] not in "+-*/"


def _with_values(table: Any, numbers: Mapping[str, float]) -> Any:
    """Return a table with numbers in place of formulas."""
    if isinstance(table, dict):
        return {name: _with_values(value, numbers) for name, value in table.items()}
    if isinstance(table, list):
        return [_with_values(entry, numbers) for entry in table]
    return table.value(numbers) if isinstance(table, Formula) else table


def _tables(table: Mapping[str, Any], key: str) -> list[Any]:
    """Return a list of tables; ValueError for anything else."""
    listed = table[key]
    if not isinstance(listed, list) or not listed or not all(isinstance(entry, dict) for entry in listed):
        raise ValueError(f"{key} must be tables [[system.{key}]], got {validate.short(listed)}")
    return listed


def _delayed(name: str, table: Mapping[str, Any], *, pieces: bool = False) -> tuple[Any, ...]:
    """Return a delayed term from its table."""
    try:
        require_keys(table, _DELAYED)
        needed = ("delay", "pieces") if pieces else ("delay", "matrix")
        if missing := [key for key in needed if key not in table]:
            raise ValueError(f"key {missing[0]!r} is missing")
        if misplaced := [key for key in table if key not in (*needed, *(() if pieces else ("cosines", "sines")))]:
            raise ValueError(f"key {misplaced[0]!r} does not go with {needed[1]}")
        delay = units.quantity(table["delay"], "delay", "time", least=math.ulp(0.0))
        if not pieces:
            return delay, table["matrix"], table.get("cosines", ()), table.get("sines", ())
        numbered = enumerate(_tables(table, "pieces"))
        return delay, [_piece(f"pieces[{i}]", piece, "matrix", _OF_A_DELAYED_PIECE) for i, piece in numbered]
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from None


def _in_pieces(table: Mapping[str, Any]) -> HillSystem | PeriodicSystem | DelaySystem:
    """Return the system of a table with tables of pieces."""
    listed = _tables(table, "pieces")
    misplaced = [key for key in ("stiffness", "mean", *_SERIES) if key in table]
    if misplaced:
        raise ValueError(f"key {misplaced[0]!r} belongs to the pieces; their durations make the period")
    first_order = ("mean", _STARTS["mean"])
    named = ["mean" if any(key in piece for key in first_order) else "stiffness" for piece in listed]
    if len(set(named)) > 1:
        raise ValueError("it has pieces with stiffness and pieces with mean; give one of them in all")
    pieces = [_piece(f"pieces[{i}]", piece, named[0]) for i, piece in enumerate(listed)]
    others = {key: value for key, value in table.items() if key != "pieces"}
    if "delayed" in table:
        terms = enumerate(_tables(table, "delayed"))
        others["delayed"] = [_delayed(f"delayed[{i}]", term, pieces=True) for i, term in terms]
    if named[0] == "stiffness":
        kind = DelaySystem if "delayed" in table else HillSystem
        return kind.from_pieces(pieces, **others)
    misplaced = [key for key in others if key not in _FIRST_ORDER]
    if misplaced:
        raise ValueError(f"key {misplaced[0]!r} does not go with mean, in first order")
    make = DelaySystem.first_order_from_pieces if "delayed" in table else PeriodicSystem.from_pieces
    return make(pieces, **others)


def _piece(
    name: str, table: Mapping[str, Any], mean: str, known: tuple[str, ...] = _OF_A_PIECE
) -> tuple[float, Varying]:
    """Return the duration and the matrix of a piece."""
    try:
        require_keys(table, known)
        start = _STARTS[mean]
        if "duration" not in table or (mean not in table and start not in table):
            hint = ", or a mean in first order" if mean in _OF_A_PIECE else ""
            raise ValueError(f"it must have a duration and a {mean}, or {start} beside a slope{hint}")
        if mean in table and start in table:
            raise ValueError(f"it has {mean} and {start}; give {start} beside a slope, else {mean}")
        duration = units.quantity(table["duration"], "duration", "time", least=math.ulp(0.0))
        varying = {key: value for key, value in table.items() if key in ("slope", "cosines", "sines")}
        value = Varying(start=table[start if start in table else mean], **varying)
        if mean in table and value.slope is not None:
            refuse_mean_with_slope("duration", mean, start)
        return duration, value
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from None


def _period(table: Mapping[str, Any]) -> dict[str, float]:
    """Return the period, from a period or an angular frequency; an empty dictionary without either."""
    given = [key for key in ("period", "frequency") if key in table]
    if len(given) == 2:
        raise ValueError("it has period and frequency; give one of them")
    if not given:
        if "cosines" in table or "sines" in table:
            raise ValueError("it has neither period nor frequency; give one of them for cosines and sines")
        return {}
    kind = "time" if given == ["period"] else "frequency"
    value = units.quantity(table[given[0]], given[0], kind, least=math.ulp(0.0))
    return {"period": value if kind == "time" else 2.0 * math.pi / value}
