"""Checks at the public border: each returns the cleaned value or raises, naming argument, value and remedy.

One rule for all: a value of the wrong kind (text, a truth value, None, complex numbers, dates, masked arrays) raises
TypeError, a number out of range ValueError; both begin with the argument's name.
"""

from __future__ import annotations

import math
import operator
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arguments import wrong_type as wrong_type
from floquetrod._util.arguments import wrong_value as wrong_value
from floquetrod._util.measured import is_measured, mapped, without_unit
from floquetrod._util.suggest import did_you_mean
from floquetrod._util.suggest import short as short

LARGEST = 1e9
"""Largest magnitude of a dimensionless coefficient; beyond it a double no longer resolves the tongues it lies among."""

LARGEST_DAMPING = LARGEST**0.5
"""Largest damping c, whose square is added to a coefficient."""

MOST_THREADS = 1024
"""Largest number of threads (a choice)."""

MOST_NUMBERS = 20_000
"""Most modes, orders or Fourier coefficients in one list (a choice)."""

MOST_ELEMENTS = 100_000_000
"""Most elements of an array, 0.8 GB of doubles, beyond which memory may run out before Ctrl-C is heard (a choice)."""

_MOST_CHARACTERS = 4096  # of a path that Linux opens
_DEEPEST = 32  # levels of nested lists: more than NumPy 1 takes

_LEAST_POSITIVE = math.ulp(0.0)
_LARGEST_INTEGER = 2**62  # by default; within an integer of machine code, with room to add

T = TypeVar("T")


# --- single numbers ---


def finite(name: str, value: Any, hint: str = "") -> float:
    """Return ``value`` as a finite float; `floquetrod.units` takes quantities of pint, here they must have no unit."""
    if type(value) is not float and is_measured(value):
        value = without_unit(name, value)
    # A truth value, text, an array or a numpy scalar that is no number: float() would take some of them.
    if (
        isinstance(value, bool | str | bytes | bytearray)
        or is_masked(value)
        or (isinstance(value, np.ndarray | np.generic) and (value.dtype.kind not in "iuf" or value.ndim > 0))
    ):
        raise wrong_type(name, f"must be a real number, got {short(value)}{_remedy(hint)}")
    try:
        number = float(value)
    except OverflowError:
        raise wrong_value(name, f"must be finite, got a number beyond 1e308{_remedy(hint)}") from None
    except Exception:  # whatever an object's own conversion raises
        raise wrong_type(name, f"must be a single real number, got {short(value)}{_remedy(hint)}") from None
    if not math.isfinite(number):
        raise _outside(name, number, -math.inf, math.inf, hint)
    return number


def positive(name: str, value: Any, hint: str = "") -> float:
    """Return ``value`` as a finite float above zero."""
    return within(name, value, _LEAST_POSITIVE, math.inf, hint)


def nonnegative(name: str, value: Any, hint: str = "") -> float:
    """Return ``value`` as a finite float that is zero or more."""
    return within(name, value, 0.0, math.inf, hint)


def within(name: str, value: Any, least: float, largest: float, hint: str = "") -> float:
    """Return ``value`` as a float from ``least`` to ``largest``.

    For zero and less the error asks for "greater than zero" where ``least`` is above zero, for "zero or more" at zero.
    """
    number = finite(name, value, hint)
    if not least <= number <= largest:
        raise _outside(name, number, least, largest, hint)
    return number


def tolerance(name: str, value: Any) -> float:
    """Return a growth rate up to which a motion counts as stable, zero to `LARGEST`."""
    return within(name, value, 0.0, LARGEST)


def confidence(value: Any) -> float:
    """Return the argument ``confidence``, between 0 and 1."""
    number = positive("confidence", value, "0.95, say")
    if number >= 1.0:
        raise wrong_value("confidence", f"must be less than 1, got {number:g}; 0.95, say")
    return number


def coefficient(name: str, value: Any) -> float:
    """Return ``value`` as a float of magnitude at most `LARGEST`, which it must be exactly."""
    return unrounded(
        name, value, within(name, value, -LARGEST, LARGEST, "check the units of the numbers it was computed from")
    )


def unrounded(name: str, value: Any, number: float) -> float:
    """Return ``number`` if it equals ``value`` exactly.

    An equation is defined by its parameters: a verdict on the nearest double is not one on 1/3.
    """
    if value != number and not is_measured(value):
        raise ValueError(
            f"{name} = {short(value)} is not a binary number of 53 digits; round it with float({name}), or prove the "
            f"exact number with certify(Mathieu, {name}=..., ...), say"
        )
    return number


def integer(name: str, value: Any, least: int, most: int = _LARGEST_INTEGER, hint: str = "") -> int:
    """Return ``value`` as an int from ``least`` to ``most``."""
    if isinstance(value, bool):
        raise wrong_type(name, f"must be an integer, got {value!r}{_remedy(hint)}")
    try:
        number = operator.index(value)
    except Exception:  # whatever an object's own conversion raises
        raise wrong_type(name, f"must be an integer, got {short(value)}{_remedy(hint)}") from None
    if number < least:
        raise wrong_value(name, f"must be {least} or more, got {short(number)}{_remedy(hint)}")
    if number > most:
        raise wrong_value(name, f"must be at most {most}, got {short(number)}{_remedy(hint)}")
    return number


def interval(name: str, value: Any, element: Callable[[str, Any], float] = finite) -> tuple[float, float]:
    """Return ``value`` as two increasing numbers, both checked by ``element``."""
    try:
        if isinstance(value, str | bytes | Mapping | Set):
            raise TypeError
        low, high = value
    except Exception:  # whatever an object's own iterator raises
        raise wrong_type(name, f"must be two numbers (low, high), got {short(value)}") from None
    ends = element(f"{name}[0]", low), element(f"{name}[1]", high)
    if not ends[0] < ends[1]:
        raise wrong_value(name, f"must increase, got ({ends[0]:g}, {ends[1]:g}); give the lower end first")
    return ends


# --- several numbers ---


def sequence(name: str, values: Any, example: str = "(0.5, 0.1)") -> list[Any]:
    """Return a one-dimensional sequence as a list of no more than `MOST_NUMBERS`."""
    require_dense(name, values)
    if isinstance(values, str | bytes | Mapping | Set) or is_masked(values) or not iterable(values):
        raise wrong_type(name, f"must be a sequence of numbers such as {example}, got {short(values)}")
    return listed(name, values, MOST_NUMBERS, "numbers")


def is_masked(value: Any) -> bool:
    """Return whether ``value`` is a masked array; none exists until numpy.ma is imported."""
    return "numpy.ma" in sys.modules and isinstance(value, np.ma.MaskedArray)


def is_sparse(value: Any) -> bool:
    """Return whether ``value`` is a sparse matrix; none exists until scipy.sparse is imported."""
    sparse = sys.modules.get("scipy.sparse")
    return sparse is not None and bool(sparse.issparse(value))


def require_dense(name: str, value: Any) -> None:
    """Raise TypeError for a sparse matrix, where numbers or a sequence are meant."""
    if is_sparse(value):
        raise wrong_type(name, f"must be a dense array, got a sparse one of shape {value.shape}; give {name}.toarray()")


def iterable(values: Any) -> bool:
    """Return whether ``values`` can be iterated over, without iterating."""
    try:
        iter(values)
    except Exception:  # is not, or raises when asked
        return False
    return True


def listed(name: str, values: Iterable[Any], most: int, what: str) -> list[Any]:
    """Return an iterable of at most ``most`` values as a list."""
    values_listed = [] if _length(values) > most else list(islice(values, most + 1))
    if _length(values) > most or len(values_listed) > most:
        raise wrong_value(name, f"must hold at most {most} {what}, got more")
    return values_listed


def numbers(name: str, values: Any) -> tuple[float, ...]:
    """Return a one-dimensional sequence of coefficients as a tuple."""
    return tuple(coefficient(f"{name}[{i}]", value) for i, value in enumerate(sequence(name, values)))


def integers(name: str, values: Any, least: int, most: int = MOST_NUMBERS, hint: str = "") -> tuple[int, ...]:
    """Return a one-dimensional sequence of ints from ``least`` to ``most`` as a tuple."""
    given = sequence(name, values, "(6, 7, 8)")
    return tuple(integer(f"{name}[{i}]", value, least, most, hint) for i, value in enumerate(given))


def modes(values: Any, name: str = "modes") -> tuple[int, ...]:
    """Return mode numbers, one at least, as a tuple."""
    chosen = integers(name, values, 1)
    if not chosen:
        raise wrong_value(name, "must name at least one mode, got none; leave it out to use all that matter")
    return chosen


def array(name: str, values: Any, *, least: float = -LARGEST, largest: float = LARGEST) -> NDArray[np.float64]:
    """Return ``values`` as a float64 array of finite numbers in ``[least, largest]``."""
    if type(values) is float and least <= values <= largest:  # the common default, at a tenth of the time
        return np.array(values)
    raw = untyped(name, values)
    if raw.dtype.kind == "O":  # Fraction, Decimal, int beyond 64 bits: as a single number would be taken
        flat = [finite(_at(name, index), value) for index, value in np.ndenumerate(raw)]
        raw = np.array(flat, dtype=np.float64).reshape(raw.shape)
    elif raw.dtype.kind not in "iuf" and raw.size:
        raise wrong_type(name, f"must hold real numbers, got {short(values)}")
    if raw.dtype == np.float64:
        result = raw
    else:
        with np.errstate(over="ignore"):  # of longer floats; infinity is then refused
            result = raw.astype(np.float64, copy=False)
    # Two passes decide the common case: a NaN makes both comparisons false.  The methods min and max take longer.
    if result.size and not (
        np.minimum.reduce(result, axis=None) >= least and np.maximum.reduce(result, axis=None) <= largest
    ):
        wrong = ~((result >= least) & (result <= largest))
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise wrong_value(
            name,
            f"must be finite and lie between {least:g} and {largest:g}, got {_at(name, index)} = "
            f"{float(result[index])!r} ({int(wrong.sum())} of {result.size} values are outside); remove them first",
        )
    return result


def complex_array(name: str, values: Any, largest: float = LARGEST) -> NDArray[Any]:
    """Return ``values`` as an array of finite numbers whose parts are up to ``largest``: float64 where all are real."""
    raw = values if type(values) is np.ndarray and values.dtype == np.float64 else untyped(name, values)
    if raw.dtype.kind == "O" and any(isinstance(value, complex | np.complexfloating) for value in raw.flat):
        parts = [np.array([_part(value, part) for value in raw.flat], dtype=object) for part in ("real", "imag")]
        real, imaginary = (part.reshape(raw.shape) for part in parts)
    elif raw.dtype.kind == "c":
        real, imaginary = raw.real, raw.imag
    else:
        return array(name, values, least=-largest, largest=largest)
    real, imaginary = (array(name, part, least=-largest, largest=largest) for part in (real, imaginary))
    if not imaginary.any():
        return np.array(real)
    joined = np.empty(real.shape, dtype=np.complex128)
    joined.real, joined.imag = real, imaginary
    return joined


def _part(value: Any, part: str) -> Any:
    """Return the real or the imaginary part of a number, a real number of any kind unchanged."""
    if isinstance(value, complex | np.complexfloating):
        return getattr(value, part)
    return value if part == "real" else 0.0


def integer_array(name: str, values: Any, least: int, most: int = MOST_NUMBERS, hint: str = "") -> NDArray[np.int64]:
    """Return ``values`` as an int64 array of integers from ``least`` to ``most``."""
    raw = untyped(name, values)
    if raw.dtype.kind not in "iu" and raw.size:
        if raw.dtype.kind == "O":  # names the entry that is none, or is too large
            for index, value in np.ndenumerate(raw):
                integer(_at(name, index), value, least, most, hint)
        raise wrong_type(name, f"must hold integers, got {short(values)}{_remedy(hint)}")
    if raw.size and (raw.min() < least or raw.max() > most):
        raise wrong_value(name, f"must lie between {least} and {most}, got {short(values)}{_remedy(hint)}")
    return raw.astype(np.int64)


# --- everything else ---


def choice(name: str, value: Any, allowed: Iterable[str]) -> str:
    """Return ``value`` when it is one of ``allowed``."""
    options = tuple(allowed)
    if not isinstance(value, str):
        raise wrong_type(name, f"must be one of {', '.join(map(repr, options))}, got {short(value)}")
    if value not in options:
        raise wrong_value(
            name, f"must be one of {', '.join(map(repr, options))}, got {short(value)}{did_you_mean(value, options)}"
        )
    return str(value)


def flag(name: str, value: Any) -> bool:
    """Return ``value`` as a bool: only True and False are accepted."""
    if not isinstance(value, bool | np.bool_):
        raise wrong_type(name, f"must be True or False, got {short(value)}")
    return bool(value)


def path(name: str, value: Any) -> Path:
    """Return the path of a file or folder."""
    if not isinstance(value, str | os.PathLike) or not isinstance(os.fspath(value), str):
        raise wrong_type(name, f"must be a path such as 'result.npz', got {short(value)}")
    if not os.fspath(value):
        raise wrong_value(name, f"must name a file, got {value!r}")
    if "\0" in os.fspath(value):
        raise wrong_value(name, f"must not hold a null byte, got {short(value)}")
    if len(os.fspath(value)) > _MOST_CHARACTERS:
        raise wrong_value(name, f"must be a path of at most {_MOST_CHARACTERS} characters, got {short(value)}")
    return Path(value)


def instance(name: str, value: Any, kind: type[T], hint: str = "") -> T:
    """Return ``value`` when it is a ``kind``."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise wrong_type(name, f"must be {article} {kind.__name__}, got {short(value)}{_remedy(hint)}")
    return value


def function(name: str, value: Any) -> Any:
    """Return ``value`` when it can be called."""
    if not callable(value):
        raise wrong_type(name, f"must be a function, got {short(value)}")
    return value


def progress(value: Any) -> None:
    """Raise TypeError unless ``value`` is None or can be called with numbers done and total."""
    if value is not None:
        function("progress", value)


def workers(value: Any) -> int | None:
    """Return a number of threads, None for the default."""
    return None if value is None else integer("workers", value, 1, MOST_THREADS, "leave it out for one per core")


def untyped(name: str, values: Any) -> NDArray[Any]:
    """Return ``values`` as an array of any type; raise for ragged, masked, too large ones, and ones with units."""
    elements(name, values.size if type(values) is np.ndarray else _counted(name, values, {}))
    values = mapped(name, values, is_measured, without_unit)
    try:
        return np.asarray(values)
    except Exception:  # ragged, or whatever an object's own conversion raises
        raise wrong_value(name, f"must be an array or nested lists of equal lengths, got {short(values)}") from None


def dimensions(name: str, values: Any) -> int:
    """Return the number of dimensions of an array, or of nested lists as `untyped` takes them."""
    return int(values.ndim) if hasattr(values, "ndim") else untyped(name, values).ndim


def elements(name: str, count: int) -> None:
    """Raise ValueError for an array of more than `MOST_ELEMENTS`, before memory is taken for it."""
    if count > MOST_ELEMENTS:
        raise wrong_value(
            name, f"must have at most {MOST_ELEMENTS:,} elements, got {short(count)}; ask for one piece at a time"
        )


def _counted(name: str, values: Any, known: dict[int, int], depth: int = 0) -> int:
    """Return the number of elements of an array of nested lists; raise for lists that cannot become one.

    A list met again, whose number is in ``known``, is not gone through again: nested lists may share their elements.
    """
    require_dense(name, values)
    if is_masked(values):
        raise wrong_type(
            name,
            f"must not be a masked array: its mask would be lost; give {name}.compressed(), or "
            f"{name}.filled(value) and mask the result",
        )
    if isinstance(values, np.ndarray):
        return values.size
    if not isinstance(values, list | tuple):
        return 1 if isinstance(values, str | bytes) or hasattr(values, "__array__") else _length(values)
    if depth > _DEEPEST:
        raise wrong_value(name, f"must not be nested deeper than {_DEEPEST} levels; does a list in it contain itself?")
    if id(values) not in known:
        nested = (value for value in values if not isinstance(value, float | int))
        known[id(values)] = len(values) + sum(_counted(name, element, known, depth + 1) for element in nested)
    return known[id(values)]


def _length(values: Any) -> int:
    """Return the length of an object, 1 without one."""
    try:
        return len(values)
    except OverflowError:  # more than a list can hold
        return _LARGEST_INTEGER
    except Exception:  # has none, or raises when asked
        return 1


def _at(name: str, index: Sequence[int]) -> str:
    return f"{name}[{', '.join(map(str, index))}]" if index else name


def _outside(name: str, number: float, least: float, largest: float, hint: str) -> ValueError:
    """Return the error for a number that is not finite or not from ``least`` to ``largest``: the one wording."""
    if not math.isfinite(number):
        wanted = "be finite"
    elif number <= 0.0 < least:
        wanted = "be greater than zero"
    elif number < 0.0 == least:
        wanted = "be zero or more"
    else:
        wanted = f"lie between {least:g} and {largest:g}"
    return wrong_value(name, f"must {wanted}, got {number!r}{_remedy(hint)}")


def _remedy(hint: str) -> str:
    return f"; {hint}" if hint else ""
