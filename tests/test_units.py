"""Quantities as people write them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from floquetrod.units import quantity


@given(st.floats(-1e6, 1e6, allow_nan=False))
def test_a_number_alone_is_in_the_si_unit(value: float) -> None:
    assert quantity(repr(value), "mean", "force") == value
    assert quantity(value, "mean", "force") == value
    assert quantity(f" {value!r} kN ", "mean", "force") == pytest.approx(1e3 * value)


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("24Hz", "frequency", 48.0 * math.pi),
        ("150 rad/s", "frequency", 150.0),
        ("60rpm", "frequency", 2.0 * math.pi),
        ("0.8mm", "length", 0.8e-3),
        ("68GPa", "pressure", 68e9),
        ("6.5g/cm3", "density", 6500.0),
        ("-.5e-1N", "force", -0.05),
        ("0.2Fcr", "force", 0.4),
        ("3/s", "rate", 3.0),
        ("2.5us", "time", 2.5e-6),
    ],
)
def test_units(text: str, kind: str, value: float) -> None:
    assert quantity(text, "x", kind, critical_force=2.0) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["", "N", "1 2", "0x10", "nan", "inf", "1Fxr", "1 kg", None, [1], True])
def test_anything_else_is_refused_with_what_is_accepted(text: object) -> None:
    with pytest.raises(
        ValueError, match=r"^--mean must be a number with a force unit \(N, kN, mN, lbf; none means N\)"
    ):
        quantity(text, "--mean", "force")


def test_an_integer_beyond_a_double_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^length must be finite, got an integer beyond 1e308$"):
        quantity(10**400, "length", "length")


def test_fcr_needs_a_rod() -> None:
    with pytest.raises(ValueError, match="unit 'Fcr' is not understood"):
        quantity("1Fcr", "mean", "force")
