"""Checks at the public border: each returns the cleaned value or raises, naming argument, value and way out."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST = 1e9
"""Largest magnitude of a dimensionless coefficient; beyond it a double no longer resolves the tongues it lies among."""


def finite(name: str, value: Any, hint: str = "") -> float:
    """Return ``value`` as a finite float."""
    if isinstance(value, bool | np.bool_ | str | bytes):
        raise TypeError(f"{name} must be a real number, got {value!r}{_way_out(hint)}")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a single real number, got {_short(value)}{_way_out(hint)}") from None
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {number!r}{_way_out(hint)}")
    return number


def positive(name: str, value: Any, hint: str = "") -> float:
    """Return ``value`` as a finite float above zero."""
    number = finite(name, value, hint)
    if number <= 0.0:
        raise ValueError(f"{name} must be greater than zero, got {number!r}{_way_out(hint)}")
    return number


def nonnegative(name: str, value: Any, hint: str = "") -> float:
    """Return ``value`` as a finite float that is zero or more."""
    number = finite(name, value, hint)
    if number < 0.0:
        raise ValueError(f"{name} must be zero or more, got {number!r}{_way_out(hint)}")
    return number


def coefficient(name: str, value: Any) -> float:
    """Return ``value`` as a float of magnitude at most `LARGEST`."""
    number = finite(name, value)
    if abs(number) > LARGEST:
        raise ValueError(
            f"{name} must lie between -{LARGEST:g} and {LARGEST:g}, got {number!r}; "
            "check the units of what it was computed from"
        )
    return number


def integer(name: str, value: Any, least: int) -> int:
    """Return ``value`` as an int of at least ``least``."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be an integer, got {_short(value)}") from None
    if number < least:
        raise ValueError(f"{name} must be {least} or more, got {number}")
    return number


def choice(name: str, value: Any, allowed: Sequence[str]) -> str:
    """Return ``value`` when it is one of ``allowed``."""
    if value not in allowed:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, allowed))}, got {value!r}")
    return str(value)


def numbers(name: str, values: Any) -> tuple[float, ...]:
    """Return a one-dimensional sequence of finite numbers as a tuple."""
    if isinstance(values, str | bytes) or not np.iterable(values):
        raise TypeError(f"{name} must be a sequence of numbers such as (0.5, 0.1), got {_short(values)}")
    return tuple(coefficient(f"{name}[{index}]", value) for index, value in enumerate(values))


def array(name: str, values: Any, *, least: float = -LARGEST, largest: float = LARGEST) -> NDArray[np.float64]:
    """Return ``values`` as a float64 array of finite numbers in ``[least, largest]``."""
    raw = np.asarray(values)
    if raw.dtype.kind not in "iuf":
        raise TypeError(f"{name} must hold real numbers, got {_short(values)}")
    result = raw.astype(np.float64, copy=False)
    # One pass decides the common case: a NaN makes both comparisons false.
    if result.size and not (result.min() >= least and result.max() <= largest):
        wrong = ~((result >= least) & (result <= largest))
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        where = f"{name}[{', '.join(map(str, index))}]" if index else name
        raise ValueError(
            f"{name} must be finite and lie between {least:g} and {largest:g}, got {where} = {float(result[index])!r} "
            f"({int(wrong.sum())} of {result.size} values are outside); mask or mend them first"
        )
    return result


def _way_out(hint: str) -> str:
    return f"; {hint}" if hint else ""


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
