"""Formulas that people write in files: their values, and texts that are none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floquetrod._util.formulas import Formula


def drawn(rng: np.random.Generator, depth: int) -> tuple[str, str]:
    """Return a formula of a and b, and the same as Python writes it."""
    if depth == 0:
        number = f"{rng.uniform(0.1, 3.0):.3g}"
        return [("a", "a"), ("b", "b"), (number, number), ("pi", "math.pi")][rng.integers(4)]
    left, right = drawn(rng, depth - 1), drawn(rng, int(rng.integers(depth)))
    kind = rng.integers(7)
    if kind < 4:
        sign = "+-*/"[kind]
        return f"({left[0]}{sign}{right[0]})", f"({left[1]}{sign}{right[1]})"
    if kind == 4:
        return f"-{left[0]} ** 2", f"-{left[1]} ** 2.0"
    if kind == 5:
        return f"sqrt(1 + {left[0]}**2) ", f"math.sqrt(1.0 + {left[1]}**2.0)"
    return f"sin( {left[0]} )", f"math.sin({left[1]})"


def test_values_are_those_of_python(rng: np.random.Generator) -> None:
    for _ in range(300):
        text, python = drawn(rng, int(rng.integers(1, 5)))
        numbers = {"a": float(rng.uniform(0.2, 2.0)), "b": float(rng.uniform(-2.0, -0.2))}
        try:
            expected = eval(python, {"math": math}, dict(numbers))  # of texts drawn above
        except (ArithmeticError, ValueError):  # a division by zero, the sine of an overflow
            continue
        formula = Formula.read(text)
        assert formula.value(numbers) == expected, text
        assert set(formula.names) <= {"a", "b", "pi"}


@pytest.mark.parametrize(
    ("text", "value"),
    [("-0.1+2i", -0.1 + 2j), ("i", 1j), ("a/2i", 1.5 / 2j), ("-i*a", -1.5j), ("1e-3i", 1e-3j), ("a", 1.5)],
)
def test_numbers_may_be_imaginary(text: str, value: complex) -> None:
    assert Formula.read(text, imaginary=True).value({"a": 1.5}) == value
    if "i" in text:
        with pytest.raises(ValueError, match=r"not a formula|no parameter"):
            Formula.read(text).value({"a": 1.5})


@pytest.mark.parametrize(
    "text",
    [
        "", "a b", "24Hz", "1_000", "0x10", "True", "'a'*10**9", "1<<10**9", "().__class__", "a.real", "a[0]", "[a]",
        "__import__('os').system('true')", "sqrt", "sqrt(a, a)", "sqrt(x=a)", "max(a)", "lambda: a", "a if a else a",
        "a; a", "a = 1", "(a := 1)", "f'{a}'", "a < 1", "a % 2", "a // 2", "a @ a", "~a", "not a", "9" * 400, "1j",
        "(" * 400, "a" + "+a" * 600, "*a", "yield", "\0",
    ],
)  # fmt: skip
def test_other_texts_are_none(text: str) -> None:
    with pytest.raises(ValueError, match=r"not a formula|no parameter|at most 1000 are read"):
        Formula.read(text).value({"a": 1.0})


@pytest.mark.parametrize("text", ["a*omega^2", "2^a", "(a + 1) ^ 2"])
def test_a_caret_is_led_to_powers(text: str) -> None:
    with pytest.raises(ValueError, match=r"not a formula; write \*\* for powers$"):
        Formula.read(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a/0", "division by zero"),
        ("9**9**9", "beyond 1e308"),
        ("exp(1e4)", "beyond 1e308"),
        ("sqrt(-a)", "sqrt"),
        ("(-a)**0.5", "its value is complex"),
        ("omeag", "which is no parameter; did you mean omega"),
    ],
)
def test_values_that_are_none_are_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Formula.read(text).value({"a": 1.0, "omega": 2.0})


def test_long_formulas_are_read_in_no_time() -> None:
    assert Formula.read("-" * 900 + "1").value({}) == 1.0
    assert Formula.read("+".join(["a"] * 500)).value({"a": 2.0}) == 1000.0
