"""Equality of results that hold arrays: by what is in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, ClassVar, NoReturn

import numpy as np

from floquetrod._util.calling import TellsAttributes


class ByContent:
    """Base of frozen dataclasses with arrays: equal when all compared fields are, NaN to NaN, elements of arrays too.

    A dataclass of its own would compare tuples of arrays, whose truth is ambiguous.  The hash agrees with equality; of
    an array it takes the shape alone, so that it stays the same even if somebody writes into the array.  Declare the
    class with ``@dataclass(frozen=True, eq=False)``.
    """

    def __eq__(self, other: object) -> bool:
        """Return whether ``other`` is of the same type with the same content."""
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(getattr(self, name), getattr(other, name)) for name in _compared(self))

    def __hash__(self) -> int:
        """Return a hash that equal results share."""
        return hash((type(self), *(_key(getattr(self, name)) for name in _compared(self))))


def _compared(result: Any) -> list[str]:
    return [field.name for field in fields(result) if field.compare]


def _same(one: Any, other: Any) -> bool:
    """Return whether two values have the same content."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        both = isinstance(one, np.ndarray) and isinstance(other, np.ndarray)
        return both and np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")  # text has no NaN
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    if isinstance(one, tuple | list) and type(one) is type(other):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other or (one != one and other != other))


def _key(value: Any) -> Any:
    """Return what a value adds to the hash."""
    if isinstance(value, np.ndarray):
        return value.shape
    if isinstance(value, Mapping):
        return frozenset(value)
    if isinstance(value, tuple | list):
        return tuple(map(_key, value))
    return value if value == value else "NaN"


class NoTruthValue(TellsAttributes):
    """A result that has no truth value: as a plain object it would count as true whatever its verdict.

    Raises TypeError that names ``ask``, what to look at instead.
    """

    ask: ClassVar[str]

    def __bool__(self) -> NoReturn:
        """Raise TypeError."""
        raise TypeError(f"the truth value of {type(self).__name__} is ambiguous; look at {self.ask}")
