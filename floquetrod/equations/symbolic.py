"""Sympy's expressions of a system as functions of numpy: the rates, and their derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Number
from typing import Any

from floquetrod._util import validate


class _Lambdified:
    """Expressions as a function f(t, x, **parameters) of arrays; pickled as the expressions."""

    def __init__(self, expressions: Any, states: Sequence[Any], time: Any, names: Sequence[str]) -> None:
        """Take sympy expressions: a sequence of them, or a matrix."""
        import sympy

        self.parts = expressions, tuple(states), time, tuple(names)
        symbols = [sympy.Symbol("t_") if time is None else time, *states]
        # Parameters as they occur, with their assumptions.
        occurring = {str(symbol): symbol for expression in expressions for symbol in expression.free_symbols}
        others = [occurring.get(name, sympy.Symbol(name)) for name in names]
        rows = expressions.tolist() if isinstance(expressions, sympy.MatrixBase) else list(expressions)
        self._call = sympy.lambdify([*symbols, *others], rows, modules="numpy", cse=True)

    def __call__(self, t: Any, x: Any, **parameters: float) -> Any:
        return self._call(t, *x, *(parameters[name] for name in self.parts[3]))

    def __reduce__(self) -> tuple[Any, ...]:
        return (_Lambdified, self.parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Lambdified) and other.parts == self.parts

    def __hash__(self) -> int:
        return hash(str(self.parts))

    def __repr__(self) -> str:
        return f"[{', '.join(map(str, self.parts[0]))}]"


def _expression(i: int, given: Any) -> Any:
    """Return the right-hand side of one equation; TypeError for anything but an expression."""
    import sympy
    from sympy.core.function import AppliedUndef

    # Only numbers are converted: sympy evaluates texts, and texts within other objects, as code.
    expression = sympy.sympify(given, strict=True) if isinstance(given, Number) else given
    if not isinstance(expression, sympy.Expr):
        hint = "; sympy runs texts as code: write it with symbols" if isinstance(given, str | bytes) else ""
        raise TypeError(f"equations[{i}] must be an expression of sympy, got {validate.short(given)}{hint}")
    if undefined := expression.atoms(AppliedUndef):
        shown = validate.short(sorted(map(str, undefined))[0])
        raise TypeError(f"equations[{i}] must be of functions that sympy can compute, got {shown} in it")
    return expression


def _sequence(name: str, values: Any, what: str, example: str) -> list[Any]:
    """Return a sequence of objects of sympy as a list; TypeError for a text or one alone."""
    if isinstance(values, str | bytes) or not validate.iterable(values):
        raise validate.wrong_type(name, f"must be a sequence of {what} such as {example}, got {validate.short(values)}")
    return validate.listed(name, values, validate.MOST_NUMBERS, what)


def lambdified(
    equations: Any, states: Any, time: Any, parameters: Mapping[str, float]
) -> tuple[_Lambdified, _Lambdified]:
    """Return the rates and their derivatives as functions; ValueError names a symbol that has no value."""
    import sympy

    rates = [
        _expression(i, expression)
        for i, expression in enumerate(_sequence("equations", equations, "expressions", "[v, -x]"))
    ]
    symbols = _sequence("states", states, "symbols", "[x, v]")
    for i, expression in enumerate(symbols):
        if not isinstance(expression, sympy.Symbol):
            raise TypeError(f"states[{i}] must be a symbol of sympy, got {validate.short(expression)}")
    if len(rates) != len(symbols) or not symbols:
        raise ValueError(f"equations must be one for each of {len(symbols)} states, got {len(rates)}")
    if time is not None and not isinstance(time, sympy.Symbol):
        raise TypeError(f"time must be a symbol of sympy, got {validate.short(time)}")
    known = {*map(str, symbols), *parameters, *(() if time is None else (str(time),))}
    free = sorted({str(symbol) for expression in rates for symbol in expression.free_symbols} - known)
    if free:
        remedy = "give it in parameters" + ("" if time is not None else ", or as time")
        raise ValueError(f"equations have {validate.short(free[0])}, which has no value; {remedy}")
    derivatives = sympy.Matrix(rates).jacobian(symbols)
    return tuple(_Lambdified(expression, symbols, time, list(parameters)) for expression in (rates, derivatives))  # type: ignore[return-value]
