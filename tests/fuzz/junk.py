"""Junk arguments to every public callable: a ValueError or TypeError that names an argument, or a sound answer."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import math
import re
import sys
import warnings
from fractions import Fraction
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import FloquetVerdict
from tests.fuzz.calls import CLAMPED, LOAD, ROD, Call, folder, table
from tests.fuzz.core import Found, TookTooLong, limit, own_warnings, told

CASES = 2000
QUICK = 120

JUNK: tuple[str, ...] = (
    "10**400",
    "-(10**400)",
    "1e-300",
    "1e300",
    "-1e300",
    "5e-324",
    "2**64",
    "2**63",
    "10**9",
    "1e16",
    "0",
    "0.0",
    "-0.0",
    "-1",
    "-0.5",
    "math.nan",
    "math.inf",
    "-math.inf",
    "None",
    "True",
    "'x'",
    "''",
    "b''",
    "'A\\x00B'",
    "[]",
    "()",
    "{}",
    "[[1.0], [1.0, 2.0]]",
    "[1.0, 'x']",
    "[None]",
    "(1.0, 2.0)",
    "(3.0, 1.0)",
    "(1.0, 2.0, 3.0, 4.0)",
    "5",
    "1 + 2j",
    "[1 + 2j]",
    "Fraction(1, 3)",
    "object()",
    "len",
    "iter([1.0])",
    "range(3)",
    "np.float32(0.3)",
    "np.array(0.3)",
    "np.array([])",
    "np.empty((0, 3))",
    "np.array([0.3, math.nan])",
    "np.array([[0.3, 0.4], [0.1, 0.2]])",
    "np.array([0.3, None], dtype=object)",
    "np.array(['0.3'])",
    "np.array([True, False])",
    "np.ma.array([0.3, 0.4], mask=[False, True])",
    "np.ma.masked",
    "np.full(100, 0.3)",
    "np.arange(4, dtype=np.uint64) + np.uint64(2**63)",
    "np.datetime64('2020-01-01')",
    "fr.Mathieu(0.5, -0.3)",
    "fr.Hill(-1.0)",
    "ROD",
    "ROD.replace(length=1e-12)",
    "ROD.replace(length=1e15)",
    "ROD.replace(radius=1e-12)",
    "ROD.replace(gravity=1e15)",
    "ROD.replace(youngs_modulus=1e-12)",
    "ROD.replace(damping_rate=1e15)",
    "LOAD",
    "fr.AxialLoad(1e12, 0.3, 150.0)",
    "fr.AxialLoad(0.3, 1e12, 150.0)",
    "fr.AxialLoad(0.3, 0.3, 1e-9)",
    "fr.AxialLoad(0.3, 0.3, 1e12)",
    "fr.FiniteTimeCriterion(periods=10**9)",
    "[[1.0, 0.5], [0.5, 2.0]]",
    "[[[1.0, 0.5], [0.5, 2.0]]]",
    "np.full((2, 2), 1e30)",
    "np.full((2, 2, 2), 0.3)",
    "np.zeros((2, 2))",
    "np.array([[1.0, math.nan], [0.0, 1.0]])",
    "fr.HillSystem([[1e30, 0.0], [0.0, 1e-30]], [[[1e-3, 0.0], [0.0, 1e-3]]])",
    "fr.HillSystem(np.eye(2), [np.eye(2)], damping=1e6 * np.diag([1.0, 2.0]), period=1e3)",
    "fr.HillSystem(np.eye(3), period=np.array([1.0, 1e-100, 1e100]))",
    "fr.PeriodicSystem([[0.0]], period=1e-100)",
    "fr.PeriodicSystem([[1e20, 1.0], [0.0, -1e20]], [np.eye(2)])",
    "fr.PeriodicSystem([[-1.0]], coefficient_error=1e300)",
    "{'omega': (2.5, 3.5, 3), 'epsilon': [0.1, 0.2]}",
    "{'omega': (2.5, 3.5, 3), 'epsilon': (0.1, math.inf, 2)}",
    "{'omega': (2.5, 3.5, 3)}",
    "{'omega': (-1.0, 0.0, 2), 'epsilon': (0.1, 0.2, 2)}",
    "loop()",
    "loop(0.3)",
    "loop(twice=True)",
    "tree(40)",
    "tree(30)",
    "Endless()",
    "Raising()",
    "[Raising()]",
    "objects(0.3, Raising())",
    "range(10**12)",
    "range(10**30)",
    "'x' * 10**6",
    "'1' * 10**6",
    "b'x' * 10**6",
    "['x' * 10**6]",
    "np.array(['x' * 10**5])",
    "np.broadcast_to(0.3, 10**12)",
    "np.broadcast_to(0.3, (10**6, 10**6))",
    "np.broadcast_to(0.3, (10**10, 2, 2))",
)
"""What is put in the place of an argument, as expressions."""

LONGEST_MESSAGE = 10_000
"""Characters that an error may have: two paths of the longest kind, and what is said of them."""


def loop(*first: float, twice: bool = False) -> list[Any]:
    """Return a list that holds itself after some numbers, as often as asked."""
    found: list[Any] = [*first]
    found += [found] * (1 + twice)
    return found


def tree(levels: int) -> Any:
    """Return nested pairs, each of one list twice: few lists, and two numbers to the power of the levels."""
    found: Any = 0.3
    for _ in range(levels):
        found = [found, found]
    return found


def objects(*values: Any) -> np.ndarray:
    """Return an array of objects, none of which is asked for anything."""
    found = np.empty(len(values), dtype=object)
    for place, value in enumerate(values):
        found[place] = value
    return found


class Endless:
    """A sequence that says it has a million million numbers."""

    def __len__(self) -> int:
        return 10**12

    def __getitem__(self, place: int) -> float:
        if not 0 <= place < 10**12:
            raise IndexError
        return 0.3


class Raising:
    """Something that can be asked for nothing, not even for its text."""

    def _refuse(self, *arguments: object, **options: object) -> Any:
        raise ZeroDivisionError("nothing can be asked of this")

    __float__ = __index__ = __array__ = __len__ = __iter__ = __repr__ = __str__ = _refuse


_NAMES = {"fr": fr, "np": np, "math": math, "Fraction": Fraction, "ROD": ROD, "LOAD": LOAD} | {
    "loop": loop,
    "tree": tree,
    "objects": objects,
    "Endless": Endless,
    "Raising": Raising,
}


def check(rng: np.random.Generator) -> Found:
    """Call one public callable with one or two of its arguments replaced."""
    names = sorted(table())
    name = names[int(rng.integers(len(names)))]
    call = table()[name]
    places = sorted(call.arguments)
    chosen = rng.choice(places, size=min(len(places), 1 + int(rng.random() < 0.2)), replace=False)
    with contextlib.chdir(folder()):
        return Found(1, attack(name, call, {str(place): JUNK[int(rng.integers(len(JUNK)))] for place in chosen}))


def attack(name: str, call: Call, junk: dict[str, str]) -> list[str]:
    """Call with junk, and return what is wrong about how it is answered."""
    values = {place: eval(text, dict(_NAMES)) for place, text in junk.items()}
    line = f"{name}({', '.join(f'{place}={text}' for place, text in junk.items())}, ...)"
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        wrong = _judge(_call(call, values), call, values)
    foreign = [w for w in heard if not issubclass(w.category, tuple(own_warnings()))]
    if foreign:
        wrong.append(f"{foreign[0].category.__name__}: {foreign[0].message}")
    _close_pictures()
    if any(values.get(place) is len for place in ("progress", "equation", "function", "family")):
        return []  # a function where one belongs: what it raises is its own affair
    return [f"{line}: {what}" for what in wrong]


def _call(call: Call, values: dict[str, Any]) -> Any:
    """Return the answer, or the exception."""
    try:
        with limit():
            return call.function(**{**call.arguments, **values})
    except (Exception, TookTooLong) as error:
        return error


def _judge(answer: Any, call: Call, values: dict[str, Any]) -> list[str]:
    if isinstance(answer, BaseException):
        if not isinstance(answer, ValueError | TypeError):
            return [told(answer)]
        if len(str(answer)) > LONGEST_MESSAGE:
            return [f"a message of {len(str(answer))} characters: {told(answer)}"]
        return [] if _names_an_argument(str(answer), call) else [f"names no argument: {told(answer)}"]
    wrong = []
    # NaN where nothing could be computed
    of_systems = call.function in (fr.systems.growth_rate, fr.systems.multipliers, CLAMPED.growth_rate)
    if (
        _has_nan(answer)
        and not of_systems
        and not isinstance(answer, fr.results.Reach)  # at depths that the string does not reach
        and not any(_has_nan(value) or _is_infinite(value) for value in values.values())
    ):
        wrong.append("answers NaN")
    if any(isinstance(v, np.ma.MaskedArray) and v.size > 1 for v in values.values()):
        arrays = answer if isinstance(answer, tuple) else (answer,)
        if any(type(part) is np.ndarray and part.shape == (2,) for part in arrays):
            wrong.append("loses the mask")
    return wrong


def _names_an_argument(message: str, call: Call) -> bool:
    names = {*call.arguments, *inspect.signature(call.function).parameters}
    for value in (*call.arguments.values(), getattr(call.function, "__self__", None)):
        if dataclasses.is_dataclass(value):
            names |= {part.name for part in dataclasses.fields(value)}
    if "path" in names:
        names.add("file")  # a message about a file names it by its path
    return any(re.search(rf"\b{re.escape(name)}\b", message) for name in names)


def _is_infinite(value: Any) -> bool:
    return isinstance(value, float) and math.isinf(value)


def _has_nan(value: Any, depth: int = 0) -> bool:
    """Return whether a NaN hides anywhere in a value.

    The second curve of order 0 is none, and of an equation about which nothing could be computed the growth is NaN: so
    is a multiplier of infinite error.
    """
    if isinstance(value, float | complex | np.floating):
        return bool(np.isnan(value))
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "fcO":
            return False
        if value.dtype.kind == "O":
            return any(_has_nan(part, depth + 1) for part in value.ravel())
        return bool(np.isnan(np.ma.getdata(value)).any())
    if depth > 4 or isinstance(value, str | bytes):
        return False
    if (
        isinstance(value, FloquetVerdict | fr.results.RodStability)
        and value.status == "undecided"
        and not value.exponents
    ):
        return False
    if isinstance(value, SystemStability) and value.status == "undecided" and math.isinf(value.error):
        return False
    if isinstance(value, fr.mathieu.TransitionCurves):
        return _has_nan(value.even) or _has_nan(value.width)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return any(_has_nan(getattr(value, part.name), depth + 1) for part in dataclasses.fields(value))
    if isinstance(value, dict):
        return any(_has_nan(part, depth + 1) for part in value.values())
    if isinstance(value, list | tuple):
        return any(_has_nan(part, depth + 1) for part in value)
    return False


def _close_pictures() -> None:
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
