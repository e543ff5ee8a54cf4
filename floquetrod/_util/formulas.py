"""Formulas of named numbers that people write as texts, computed without running the text as code."""

from __future__ import annotations

import ast
import functools
import math
import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from floquetrod._util.suggest import did_you_mean, short

_LONGEST = 1000  # characters of a formula (a choice)
_CONSTANTS = {"pi": math.pi}
_FUNCTIONS = {name: getattr(math, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan")}
_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
_NUMBER = r"(?>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
_WITH_LETTERS = re.compile(rf"(?<![\w.]){_NUMBER}(?![ij]\b)[^\W\d]")  # as in 24Hz
_IMAGINARY = re.compile(rf"((?<![\w.]){_NUMBER})i\b")  # as in 0.5i, which Python writes 0.5j

WORDS = ("i", *_CONSTANTS, *_FUNCTIONS)
"""Names with a meaning of their own in formulas."""

Value = Callable[[Mapping[str, complex]], Any]
"""The value of a formula, as a function of its names' values."""


@dataclass(frozen=True)
class Formula:
    """A formula such as "2*pi/omega": numbers, names, + - * / **, brackets, pi, sqrt, exp, log, sin, cos and tan."""

    text: str
    names: tuple[str, ...]
    imaginary: bool
    value_of: Value

    @property
    def _constants(self) -> dict[str, Any]:
        return _CONSTANTS | {"i": 1j} if self.imaginary else _CONSTANTS

    @classmethod
    def read(cls, text: str, *, imaginary: bool = False) -> Formula:
        """Return the formula of a text, ``imaginary`` where it may hold i or 2i; ValueError says why it is none."""
        return _read(text, imaginary)

    def require(self, parameters: Collection[str]) -> None:
        """Raise ValueError where the formula has a name that is none of these parameters."""
        known = [*parameters, *self._constants]
        for name in self.names:
            if name not in known:
                raise ValueError(
                    f"{short(self.text)} has {short(name)}, which is no parameter{did_you_mean(name, known)}"
                )

    def value(self, numbers: Mapping[str, complex]) -> Any:
        """Return the value where names have these numbers, a float where all are real; ValueError says why not."""
        try:
            value = self.value_of(self._constants | dict(numbers))
            if self.imaginary or not isinstance(value, complex):
                return value
            reason = "its value is complex"
        except KeyError:
            self.require(numbers)
            raise
        except OverflowError:
            reason = "its value is beyond 1e308"
        except (ArithmeticError, ValueError, TypeError, RecursionError) as error:
            reason = str(error)
        raise ValueError(f"{short(self.text)}: {reason[:80]}")


@functools.lru_cache(256)
def _read(text: str, imaginary: bool) -> Formula:
    """Return the formula of a text."""
    if len(text) > _LONGEST:
        raise ValueError(f"{short(text)}: it has {len(text)} characters, at most {_LONGEST} are read")
    try:
        if _WITH_LETTERS.search(text):
            raise SyntaxError
        python = _IMAGINARY.sub(r"\1j", text.strip()) if imaginary else text.strip()
        names: dict[str, None] = {}
        value_of = _value_of(ast.parse(python, mode="eval").body, names, imaginary)
    except (SyntaxError, ValueError, ArithmeticError, RecursionError, MemoryError):
        power = "; write ** for powers" if "^" in text else ""
        raise ValueError(f"{short(text)}: not a formula{power}") from None
    return Formula(text, tuple(names), imaginary, value_of)


def _value_of(node: ast.expr, names: dict[str, None], imaginary: bool) -> Value:
    """Return the value of a node of a formula, and enter its names; SyntaxError for other nodes of Python's grammar.

    Numbers are doubles: powers of integers would take any memory and time, powers of doubles overflow.
    """
    match node:
        case ast.Constant(value=complex() as number) if imaginary:
            return lambda _: number
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            double = float(number)
            return lambda _: double
        case ast.Name(id=name):
            names[name] = None
            return operator.itemgetter(name)
        case ast.UnaryOp(op=sign, operand=operand) if type(sign) in _OPERATORS:
            return _applied(_OPERATORS[type(sign)], _value_of(operand, names, imaginary))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _FUNCTIONS:
            return _applied(_FUNCTIONS[name], _value_of(argument, names, imaginary))
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in _OPERATORS:
            combine = _OPERATORS[type(sign)]
            first, second = _value_of(left, names, imaginary), _value_of(right, names, imaginary)
            return lambda numbers: combine(first(numbers), second(numbers))
    raise SyntaxError


def _applied(function: Callable[[Any], Any], argument: Value) -> Value:
    return lambda numbers: function(argument(numbers))
