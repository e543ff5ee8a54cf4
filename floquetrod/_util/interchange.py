"""Results for other programs: JSON by one schema, and tables of pandas."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Iterator, Mapping
from numbers import Integral, Real
from operator import attrgetter
from typing import Any

from floquetrod._util import extras, validate
from floquetrod._util.version import __version__

SCHEMA = "floquetrod result"
"""Value of the key "schema" in the JSON of a result."""

SCHEMA_VERSION = 1
"""Raised when an entry of such a text changes its place or its meaning."""

_SEVERAL = ("state", "multiplier")
"""Dimensions that become columns, one for each entry."""

_UNIT = re.compile(r"(_(N|Pa|J|m|s|rad))?(_per_(m|s))?$")
"""The unit at the end of a key."""


def to_json(result: Any, *, indent: int | None = None) -> str:
    """Return a result as JSON, by one schema with a version for all results.

    An object of five names: ``schema``, "floquetrod result"; ``schema_version``, 1; ``floquetrod``, the version that
    wrote it; ``kind``, the name of the result's class; and ``result``, its numbers by name: from ``as_dict()`` where
    the result has it, with units in the names, else its attributes, in the units stated in its documentation.  Infinite
    and unknown numbers are null, complex ones have ``re`` and ``im``, arrays are lists, and results within a result are
    objects again.  JSON is not read back; for files to be loaded again use ``save``.

    Parameters
    ----------
    result
        The result of any function of the package.
    indent : int, optional
        Spaces of indentation; by default the text is one line.

    Returns
    -------
    str
        One JSON object.

    Raises
    ------
    TypeError
        For anything that is not a result.

    Examples
    --------
    >>> import floquetrod as fr
    >>> text = to_json(fr.stability(fr.Mathieu(0.5, -0.25)))
    >>> text[:61], json.loads(text)["result"]["status"]
    ('{"schema": "floquetrod result", "schema_version": 1, "floquet', 'unstable')
    """
    _require(result)
    spaces = None if indent is None else validate.integer("indent", indent, 0, 16)
    document = {
        "schema": SCHEMA,
        "schema_version": SCHEMA_VERSION,
        "floquetrod": __version__,
        "kind": type(result).__name__,
        "result": plain(result),
    }
    return json.dumps(document, allow_nan=False, indent=spaces)


def to_pandas(result: Any) -> Any:
    """Return the table of a result as a pandas.DataFrame (needs pandas: pip install floquetrod[pandas]).

    A row for each depth of a string in a well, interval of a range, method of a comparison, station of a path, point of
    a chart, orbit of a branch, band, or run of an ensemble, with units in the names of the columns where they are
    known.  Several values of a row, such as the multipliers of an orbit, are in columns counted from 0, and complex
    values in two columns, _re and _im; vertices of bands and frames of runs are in ``to_xarray()`` only.

    Parameters
    ----------
    result
        A result with a table: `Reach`, `MeanForce`, `StabilityIntervals`, `Comparison`, `WellPath`, `Chart`, `Bands`,
        `Branch`, ensembles, and so on; or a sequence of results, a row each, such as ``branch.special_points``.

    Returns
    -------
    pandas.DataFrame
        The table.

    Raises
    ------
    TypeError
        For anything that is not a result with a table.
    ImportError
        Without pandas.

    Examples
    --------
    >>> import floquetrod as fr
    >>> path = fr.WellPath.straight(length=300.0, inclination="60deg")
    >>> list(to_pandas(path))  # doctest: +SKIP
    ['depth', 'inclination', 'azimuth']
    """
    several = type(result) in (tuple, list) and len(result) > 0
    for each in result if several else [result]:
        _require(each)
    pandas = extras.pandas()
    if several:
        return pandas.DataFrame([dict(_cells(plain(each))) for each in result])
    if hasattr(result, "to_xarray"):
        return _rows(result.to_xarray(), pandas)
    numbers = plain(result)
    lists = {name: value for name, value in numbers.items() if isinstance(value, list) and len(value) > 0}
    rows = next((value for value in lists.values() if all(isinstance(row, dict) for row in value)), None)
    if rows is not None:
        return pandas.DataFrame([dict(_cells(row)) for row in rows])
    columns = {name: value for name, value in lists.items() if len(value) == len(next(iter(lists.values())))}
    if not columns or any(isinstance(cell, list | dict) for value in columns.values() for cell in value):
        raise validate.wrong_type("result", f"must have a table, got {validate.short(result)}; fr.to_json takes all")
    return pandas.DataFrame(columns)


def _cells(row: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the names and values of a row, one for each element of a list or a mapping in it."""
    for name, value in row.items():
        if isinstance(value, list):
            value = {str(i): element for i, element in enumerate(value)}
        if isinstance(value, Mapping):
            yield from _cells(value, f"{before}{name}_")
        else:
            yield f"{before}{name}", value


def _rows(dataset: Any, pandas: Any) -> Any:
    """Return a table with a row for each entry of the dataset's first variable."""
    first = next(iter(dataset.data_vars.values()))
    columns: dict[str, Any] = {}
    for name in (*dataset.coords, *dataset.data_vars):
        variable = dataset[name]
        column = with_unit(name, variable.attrs.get("units", ""))
        if set(variable.dims) <= set(first.dims):
            columns[column] = variable.broadcast_like(first).transpose(*first.dims).values.ravel()
        elif variable.dims[:-1] == first.dims and variable.dims[-1] in _SEVERAL:
            columns |= {f"{column}_{i}": variable[..., i].values.ravel() for i in range(variable.shape[-1])}
    return pandas.DataFrame(dict(pair for name, values in columns.items() for pair in _real(name, values)))


def _real(name: str, values: Any) -> list[tuple[str, Any]]:
    """Return a column by its name, complex values as two columns."""
    return [(f"{name}_re", values.real), (f"{name}_im", values.imag)] if values.dtype.kind == "c" else [(name, values)]


def with_unit(name: str, unit: str) -> str:
    """Return a name with its unit, as in keys and columns; the unit "1" adds nothing.

    >>> with_unit("mean force", "N"), with_unit("kick", "m/s"), with_unit("growth_rate", "1/s"), with_unit("mode", "1")
    ('mean_force_N', 'kick_m_per_s', 'growth_rate_per_s', 'mode')
    """
    written = "" if unit == "1" else unit.replace("^", "").replace("/", "_per_").removeprefix("1_")
    return "_".join(filter(None, (name.replace(" ", "_"), written)))


def _require(result: Any) -> None:
    if not type(result).__module__.startswith("floquetrod") or isinstance(result, type):
        raise validate.wrong_type("result", f"must be a result of floquetrod, got {validate.short(result)}")


def plain(value: Any) -> Any:
    """Return a value as JSON's types."""
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real) and not hasattr(value, "as_dict"):  # a result may be a number with attributes
        return float(value) if math.isfinite(value) else None
    if isinstance(value, complex):
        return {"re": plain(value.real), "im": plain(value.imag)}
    if isinstance(value, Mapping):
        return {str(name): plain(entry) for name, entry in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if hasattr(value, "as_dict"):
        return plain(value.as_dict())
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(entry) for entry in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value) if field.compare}
    return repr(value)


def by_keys(value: Any, keys: str) -> dict[str, Any]:
    """Return attributes of a value as JSON's types; None for each where the value is None.

    ``keys``, between blanks, are names of attributes with their units, such as "force_N", or keys with their attribute,
    "mean_N=load.mean".
    """
    pairs = [key.partition("=") for key in keys.split()]
    names = {key: name or _UNIT.sub("", key) for key, _, name in pairs}
    return {key: None if value is None else plain(attrgetter(name)(value)) for key, name in names.items()}
