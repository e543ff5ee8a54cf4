"""Equations and conventions: values, validation, and the conversions between the forms people meet."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given

import floquetrod as fr
from floquetrod.floquet.registry import applicable
from tests.strategies import hills, mathieu_points


def test_equations_are_frozen_values() -> None:
    equation = fr.Mathieu(alpha=1, beta=-2)
    assert equation == fr.Mathieu(1.0, -2.0, damping=0)
    assert hash(equation) == hash(fr.Mathieu(1.0, -2.0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        equation.alpha = 2.0  # type: ignore[misc]


def test_coefficients_broadcast() -> None:
    tau = np.linspace(0.0, 7.0, 11)
    mathieu = fr.Mathieu(0.7, -0.3)
    assert mathieu.coefficient(tau) == pytest.approx(-0.3 + 0.7 * np.sin(tau))
    assert mathieu.as_hill().coefficient(tau) == pytest.approx(mathieu.coefficient(tau))
    assert fr.Meissner(0.7, -0.3).coefficient(4.0) == pytest.approx(-1.0)
    assert isinstance(mathieu.coefficient(1.0), float)


@given(hills())
def test_harmonics_are_the_series(equation: fr.Hill) -> None:
    tau = np.linspace(0.0, equation.period, 9)
    turn = 2.0 * math.pi / equation.period
    total = equation.mean + sum(
        (z * np.exp(1j * k * turn * tau)).real for k, z in enumerate(equation.harmonics, start=1)
    )
    scale = 1.0 + abs(equation.mean) + sum(map(abs, equation.harmonics))
    assert np.abs(total - equation.coefficient(tau)).max() < 1e-12 * scale


@given(mathieu_points())
def test_conventions_are_inverses(point: tuple[float, float]) -> None:
    assert fr.conventions.from_aq(*fr.conventions.to_aq(*point)) == point
    assert fr.conventions.from_delta_epsilon(*fr.conventions.to_delta_epsilon(*point)) == point


def test_conventions_describe_the_same_equation() -> None:
    alpha, beta = 0.7, -0.3
    tau = np.linspace(0.0, 6.0, 7)
    p = fr.Mathieu(alpha, beta).coefficient(tau)
    a, q = fr.conventions.to_aq(alpha, beta)
    z = 0.5 * (tau - 0.5 * math.pi)  # y'' = 4 A'', for z is half of tau
    assert -(a - 2.0 * q * np.cos(2.0 * z)) / 4.0 == pytest.approx(p)
    delta, epsilon = fr.conventions.to_delta_epsilon(alpha, beta)
    assert -(delta + epsilon * np.cos(tau + 0.5 * math.pi)) == pytest.approx(p)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: fr.Mathieu(math.nan, 0.0), ValueError, "alpha must be finite, got nan"),
        (lambda: fr.Mathieu(0.0, math.inf), ValueError, "beta must be finite"),
        (lambda: fr.Mathieu("1", 0.0), TypeError, "alpha must be a real number"),
        (lambda: fr.Mathieu(1.0, [1.0, 2.0]), TypeError, "beta must be a single real number"),
        (lambda: fr.Mathieu(1.0, True), TypeError, "beta must be a real number"),
        (lambda: fr.Mathieu(1.0, 0.0, damping=-0.1), ValueError, "damping must be zero or more"),
        (lambda: fr.Mathieu(1.0, 1.0, 1e200), ValueError, "damping must be at most"),
        (lambda: fr.Mathieu(1e10, 0.0), ValueError, "check the units"),
        (lambda: fr.Meissner(1.0, math.nan), ValueError, "beta must be finite"),
        (lambda: fr.Hill(0.0, cosines=0.5), TypeError, "cosines must be a sequence"),
        (lambda: fr.Hill(0.0, sines=(0.5, math.nan)), ValueError, r"sines\[1\] must be finite"),
        (lambda: fr.Hill(0.0, period=0.0), ValueError, "period must be greater than zero"),
    ],
)
def test_bad_input(make: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        make()  # type: ignore[operator]


def test_package_names() -> None:
    assert set(fr.__all__) <= set(dir(fr))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        fr.nothing  # noqa: B018


def test_methods_are_functions_before_and_after_one_has_been_used() -> None:
    for method in (method.name for method in applicable(fr.Mathieu(alpha=0.5, beta=-0.6))):
        first = getattr(fr.methods, method)(fr.Mathieu(alpha=0.5, beta=-0.6)).status
        assert first == fr.stability(fr.Mathieu(alpha=0.5, beta=-0.6), method=method).status
        assert callable(getattr(fr.methods, method))
    assert all(callable(getattr(fr.methods, name)) for name in fr.methods.__all__)
