"""Quantities of pint and its like, values with a unit, without importing their libraries."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from floquetrod._util.arguments import wrong_value
from floquetrod._util.suggest import short

_DEEPEST = 32  # levels of nested lists, as arrays of numpy have
_PLAIN = frozenset({float, int})


def is_measured(value: Any) -> bool:
    """Return whether a value, or an array, has a unit and converts itself to another one."""
    try:
        says = hasattr(value, "units") or hasattr(value, "unit")
        return says and (hasattr(value, "magnitude") or hasattr(value, "value")) and callable(value.to)
    except Exception:  # whatever an object's attributes raise
        return False


def magnitude(value: Any, unit: str) -> Any:
    """Return a measured value in a unit, named as in pint, as a float or an array."""
    converted = value.to(unit)
    number = converted.magnitude if hasattr(converted, "magnitude") else converted.value
    return number if getattr(number, "ndim", 0) else float(number)


def without_unit(name: str, value: Any) -> Any:
    """Return a dimensionless measured value as a float or an array; ValueError for any other."""
    try:
        return magnitude(value, "dimensionless")
    except Exception as error:  # pint has its own for each way in which units differ
        raise wrong_value(name, f"must have no unit, got {short(value)}: {error}") from None


def mapped(
    name: str, values: Any, is_one: Callable[[Any], bool], convert: Callable[[str, Any], Any], depth: int = 0
) -> Any:
    """Return values with every measured one converted: a single one, or elements of lists and arrays of objects.

    Everything else stays the same.  ``convert(name, value)`` is called with names such as "mean[3]".
    """
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if type(values) in _PLAIN or (type(values).__module__ == "numpy" and kind is not None and kind not in "OU"):
        return values
    if is_one(values):
        return convert(name, values)
    if isinstance(values, str):  # an entry of an array of texts, itself like an array without axes
        return values
    if isinstance(values, list | tuple):
        if depth > _DEEPEST or {*map(type, values)} <= _PLAIN:
            return values
        known: dict[int, Any] = {}  # nested lists may share their parts
        for i, value in enumerate(values):
            if id(value) not in known:
                known[id(value)] = mapped(f"{name}[{i}]", value, is_one, convert, depth + 1)
        converted = [known[id(value)] for value in values]
        return tuple(converted) if isinstance(values, tuple) else converted
    if is_measured(data := getattr(values, "data", None)):  # an array of xarray about one of pint
        return convert(name, data)
    if kind in ("O", "U"):
        import numpy as np

        array = np.asarray(values)
        entries = np.empty(array.shape, dtype=object)
        for index, value in np.ndenumerate(array):
            label = f"{name}[{', '.join(map(str, index))}]" if index else name
            entries[index] = mapped(label, value, is_one, convert, depth + 1)
        return entries
    return values
