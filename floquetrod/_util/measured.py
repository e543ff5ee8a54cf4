"""Quantities of pint and its like, which are not imported for this: values that say what unit they are in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from floquetrod._util.arguments import wrong_value
from floquetrod._util.suggest import short

_DEEPEST = 32  # levels of nested lists, as arrays of numpy have
_PLAIN = frozenset({float, int})


def is_measured(value: Any) -> bool:
    """Return whether a value, or an array, says what unit it is in and converts itself to another one."""
    try:
        says = hasattr(value, "units") or hasattr(value, "unit")
        return says and (hasattr(value, "magnitude") or hasattr(value, "value")) and callable(value.to)
    except Exception:  # whatever an object raises that is asked what it has
        return False


def magnitude(value: Any, unit: str) -> Any:
    """Return the float, or the array, that a measured value is in a unit, named as pint does."""
    converted = value.to(unit)
    number = converted.magnitude if hasattr(converted, "magnitude") else converted.value
    return number if getattr(number, "ndim", 0) else float(number)


def without_unit(name: str, value: Any) -> Any:
    """Return the float, or the array, of a measured value that has no dimension; ValueError for any other."""
    try:
        return magnitude(value, "dimensionless")
    except Exception as error:  # pint has its own for each way in which units differ
        raise wrong_value(name, f"must have no unit, got {short(value)}: {error}") from None


def mapped(
    name: str, values: Any, is_one: Callable[[Any], bool], convert: Callable[[str, Any], Any], depth: int = 0
) -> Any:
    """Return values in which all that have a unit are converted: one alone, or those in lists and arrays of objects.

    Everything else stays as it is.  ``convert`` gets the name of each, such as "mean[3]", and itself.
    """
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if type(values) in _PLAIN or (type(values).__module__ == "numpy" and kind is not None and kind not in "OU"):
        return values
    if is_one(values):
        return convert(name, values)
    if isinstance(values, list | tuple):
        if depth > _DEEPEST or {*map(type, values)} <= _PLAIN:
            return values
        known: dict[int, Any] = {}  # nested lists may share their parts
        for i, each in enumerate(values):
            if id(each) not in known:
                known[id(each)] = mapped(f"{name}[{i}]", each, is_one, convert, depth + 1)
        found = [known[id(each)] for each in values]
        return tuple(found) if isinstance(values, tuple) else found
    if is_measured(held := getattr(values, "data", None)):  # an array of xarray about one of pint
        return convert(name, held)
    if kind in ("O", "U"):
        import numpy as np

        array = np.asarray(values)
        entries = np.empty(array.shape, dtype=object)
        for index, each in np.ndenumerate(array):
            at = f"{name}[{', '.join(map(str, index))}]" if index else name
            entries[index] = mapped(at, each, is_one, convert, depth + 1)
        return entries
    return values
