"""Equality, by content, of results that hold arrays."""

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


def _same(a: Any, b: Any) -> bool:
    """Return whether two values have the same content."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        both = isinstance(a, np.ndarray) and isinstance(b, np.ndarray)
        return both and np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")  # text has no NaN
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_same(a[name], b[name]) for name in a)
    if isinstance(a, tuple | list) and type(a) is type(b):
        return len(a) == len(b) and all(map(_same, a, b))
    return bool(a == b or (a != a and b != b))


def _key(value: Any) -> Any:
    """Return a hashable key of a value, equal for values of the same content."""
    if isinstance(value, np.ndarray):
        return value.shape
    if isinstance(value, Mapping):
        return frozenset(value)
    if isinstance(value, tuple | list):
        return tuple(map(_key, value))
    return value if value == value else "NaN"


class NoTruthValue(TellsAttributes):
    """A result that has no truth value: as a plain object it would count as true whatever its verdict.

    Raises TypeError that names ``ask``, the attribute to look at instead.
    """

    ask: ClassVar[str]

    def __bool__(self) -> NoReturn:
        """Raise TypeError."""
        raise TypeError(f"the truth value of {type(self).__name__} is ambiguous; look at {self.ask}")
