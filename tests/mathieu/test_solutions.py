"""Floquet solutions of Mathieu's equation and characteristic values of real order, against many digits and SciPy."""

from __future__ import annotations

import math
from typing import Any

import matplotlib as mpl
import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special

import floquetrod as fr
from floquetrod.equations import in_tau
from floquetrod.mathieu import (
    characteristic_function,
    characteristic_values,
    exponents,
    floquet_solutions,
    real_order_values,
)
from tests.conftest import depth

mpl.use("Agg")
Z = np.array([0.1, 0.7, 1.3, 2.9])


def precise(order: float, q: float) -> tuple[Any, list[Any]]:
    """Return lambda_nu(q) and me_nu at `Z` with 40 digits, from the eigenvalues of a large matrix."""
    with mp.workdps(40):
        count = 14 + int(abs(order)) + 2 * int(abs(q) ** 0.5)  # what is left out is below 1e-28
        frequencies = [mp.mpf(order) - 2 * round(order / 2) + 2 * k for k in range(-count, count + 1)]
        matrix = mp.matrix(len(frequencies))
        for i, frequency in enumerate(frequencies):
            matrix[i, i] = frequency**2
            if i:
                matrix[i, i - 1] = matrix[i - 1, i] = mp.mpf(q)
        values, vectors = mp.eigsy(matrix)
        rank = sum(abs(f) < abs(order) for f in frequencies)
        vector = vectors[:, rank]
        sign = 1 if sum(vector) > 0 else -1
        norm = mp.sqrt(sum(c**2 for c in vector))
        return values[rank], [
            sum(sign * c / norm * mp.expj(f * z) for c, f in zip(vector, frequencies, strict=True)) for z in Z.tolist()
        ]


LARGE = [(3.3, 25.0), (7.9, 100.0), (0.01, 50.0)]  # ten seconds of digits


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "q"), [(0.5, 1.0), *(pytest.param(*both, marks=pytest.mark.slow) for both in ((-2.2, -7.0), *LARGE))]
)
def test_real_orders_to_1e_12(order: float, q: float) -> None:
    value, function = precise(order, q)
    assert abs(real_order_values(order, q) - value) < 1e-13 * max(1.0, abs(q))
    found = characteristic_function(order, q)
    assert max(abs(complex(a) - b) for a, b in zip(function, found(Z), strict=True)) < 1e-12
    assert found.exponent == 0j
    assert characteristic_function(-order, q)(Z) == pytest.approx(found(-Z), abs=1e-12)


def largest_coefficient(order: float, q: float) -> tuple[float, float]:
    """Return the frequency and the value of the largest coefficient of me_nu, me_nu(0) > 0, from 60 digits."""
    with mp.workdps(60):
        level = mp.mpf(real_order_values(order, q))
        count = int(0.5 * math.sqrt(max(float(level) + 2.0 * abs(q), 0.0)) + 60.0 + 6.0 * abs(q) ** 0.25)
        frequencies = [mp.mpf(order) - 2 * mp.nint(mp.mpf(order) / 2) + 2 * k for k in range(-count, count + 1)]
        vector = [mp.mpf(1) / (1 + k % 7) for k in range(len(frequencies))]
        for _ in range(3):  # inverse iteration: no row of the elimination is small but the last
            above, solved = [mp.mpf(q) / (frequencies[0] ** 2 - level)], [vector[0] / (frequencies[0] ** 2 - level)]
            for frequency, entry in zip(frequencies[1:], vector[1:], strict=True):
                pivot = frequency**2 - level - q * above[-1]
                above.append(q / pivot)
                solved.append((entry - q * solved[-1]) / pivot)
            for i in range(len(solved) - 2, -1, -1):
                solved[i] -= above[i] * solved[i + 1]
            norm = mp.sqrt(sum(entry**2 for entry in solved))
            vector = [entry / norm for entry in solved]
            level = sum((f * v) ** 2 for f, v in zip(frequencies, vector, strict=True)) + 2 * q * sum(
                one * other for one, other in zip(vector[1:], vector[:-1], strict=True)
            )
        assert abs(sum(vector)) > mp.mpf(10) ** -45
        largest = max(range(len(vector)), key=lambda i: abs(vector[i]))
        return float(frequencies[largest]), float(vector[largest] * mp.sign(sum(vector)))


HIDDEN = [  # one of value and slope at pi / 2, or at 0 where q < 0, is lost in rounding
    (-1.0017358982635463, 116.58419534013841),
    (5.058448585046072, 267.76515354527794),
    (-3.626050225179746, 283.23317177243786),
    (-3.762128100176909, -226.85550261759775),
    (1.0000024356735329, -214.62535932392274),
]


@pytest.mark.slow
def test_the_sign_of_me_is_that_of_sixty_digits(rng: np.random.Generator) -> None:
    many = depth(15, 5)
    drawn = zip(rng.uniform(-12.0, 12.0, many).tolist(), rng.uniform(-400.0, 400.0, many).tolist(), strict=True)
    beside = rng.integers(-9, 10, many) + rng.choice([-1.0, 1.0], many) * 10.0 ** rng.uniform(-6.0, -1.0, many)
    for order, q in [*HIDDEN, *drawn, *zip(beside.tolist(), rng.uniform(-400.0, 400.0, many).tolist(), strict=True)]:
        frequency, coefficient = largest_coefficient(order, q)
        found = characteristic_function(order, q)
        place = int(np.argmin(np.abs(found.frequencies - frequency)))
        assert found.coefficients[place].real == pytest.approx(coefficient, abs=1e-9), (order, q)


@given(st.floats(-9.0, 9.0), st.floats(-10.0, 10.0))  # beyond, the bands of low orders are thinner than rounding
@settings(max_examples=depth(60, 15), deadline=None)
def test_orders_and_exponents_are_inverse(order: float, q: float) -> None:
    """At a = lambda_nu(q) the exponent per unit z is i nu, up to its sign and even numbers."""
    if abs(order - round(order)) < 1e-3:
        return
    a = real_order_values(order, q)
    first, second = exponents(*fr.conventions.from_aq(a, q), per="z")
    turned = abs(order - 2.0 * round(0.5 * order))
    assert [first, second] == pytest.approx([1j * turned, -1j * turned], abs=1e-5)
    lower, upper = sorted((math.floor(abs(order)), math.ceil(abs(order))))
    assert characteristic_values(lower, q, "a") <= a + 1e-9 * max(1.0, abs(a), abs(q))
    assert a <= characteristic_values(upper, q, "b") + 1e-9 * max(1.0, abs(a), abs(q))


@pytest.mark.parametrize("q", [-20.0, -3.0, 0.0, 0.5, 7.0, 20.0])
@pytest.mark.parametrize("kind", ["a", "b"])
def test_small_orders_are_those_of_scipy(q: float, kind: str) -> None:
    """Values, signs and norm; for q < 0 by DLMF 28.2(vi)."""
    for m in range(kind == "b", 9):
        found = characteristic_function(m, q, kind)
        if q >= 0.0:
            other = (special.mathieu_cem if kind == "a" else special.mathieu_sem)(m, q, np.degrees(Z))[0]
        else:
            sign = -1.0 if (m // 2 - (kind == "b" and m % 2 == 0)) % 2 else 1.0
            even = (kind == "a") == (m % 2 == 0)
            function = special.mathieu_cem if even else special.mathieu_sem
            other = sign * function(m, -q, np.degrees(0.5 * math.pi - Z))[0]
        assert found(Z) == pytest.approx(other, abs=1e-10)
        assert isinstance(found(0.3), float)


@pytest.mark.parametrize(
    ("order", "q", "kind"),
    [
        (50, 2000.0, "a"),
        (50, 2000.0, "b"),
        (2, 1e5, "b"),
        (3, 1e4, "a"),
        (7.3, 900.0, "floquet"),
        (0.2, 1e4, "floquet"),
    ],
)
def test_the_equation_holds_where_scipy_fails(order: float, q: float, kind: str) -> None:
    z = np.linspace(-3.0, 3.0, 61)
    a = characteristic_values(order, q, kind) if kind in "ab" else real_order_values(order, q)
    y = characteristic_function(order, q, kind)
    residual = y(z, 2) + (a - 2.0 * q * np.cos(2.0 * z)) * y(z)
    assert np.abs(residual).max() < 1e-12 * max(abs(a), q) * np.abs(y(z)).max()
    assert y(z + math.pi) == pytest.approx(y(z) * np.exp(1j * math.pi * order).real, abs=1e-9) or kind == "floquet"
    grid = np.arange(4096) * (2.0 * math.pi / 4096)
    norm = np.mean(y(grid) ** 2) * 2.0 if kind in "ab" else np.mean(y(grid) * y(-grid)).real
    assert norm == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    "equation",
    [
        fr.Mathieu(0.5, -0.25),
        fr.Mathieu(0.5, -0.6),
        fr.Mathieu(0.5, -0.6, 0.1),
        fr.Mathieu(200.0, -30.0),
        fr.Mathieu(3.0, 1.0, 0.2),
        fr.Mathieu(0.0, 0.3, 0.1),
        fr.Mathieu.from_aq(7.0, 3.0),
    ],
)
def test_floquet_solutions_of_an_equation(equation: fr.Mathieu) -> None:
    first, second = floquet_solutions(equation)
    tau = np.linspace(-2.0, 2.0, 31)
    for solution in (first, second):
        values = solution(tau)
        residual = solution(tau, 2) + 2.0 * equation.damping * solution(tau, 1) - equation.coefficient(tau) * values
        scale = 1.0 + np.abs(equation.coefficient(np.linspace(0.0, equation.period, 9))).max()
        assert np.abs(residual).max() < 1e-10 * scale * np.abs(values).max()
        turned = solution(tau + equation.period)
        assert turned == pytest.approx(values * np.exp(equation.period * solution.exponent), rel=1e-7)
    assert first.exponent.real >= second.exponent.real
    same = in_tau(equation)
    per_tau = equation.period / same.period * first.exponent.real
    growth = fr.mathieu.growth_rate(same.alpha, same.beta, same.damping)
    assert per_tau == pytest.approx(growth or -same.damping, abs=1e-12)
    k, a, q = 2.0 * same.damping, -4.0 * same.beta, 2.0 * same.alpha
    z = np.linspace(-1.0, 1.0, 31)
    for solution, other in zip(floquet_solutions(equation, per="z"), (first, second), strict=True):
        values = solution(z)
        residual = solution(z, 2) + 2.0 * k * solution(z, 1) + (a - 2.0 * q * np.cos(2.0 * z)) * values
        assert np.abs(residual).max() < 1e-10 * (1.0 + abs(a) + abs(q)) * np.abs(values).max()
        in_z = equation.time == "z"  # as the other already is
        assert solution.exponent == (1.0 if in_z else 2.0) * other.exponent
        ratio = other(z if in_z else 2.0 * z + 0.5 * math.pi) / values  # the same solution, but for its scale
        assert ratio == pytest.approx(np.full(31, ratio[0]), rel=1e-7)
    # As a solution from its own initial values.
    start = [solution.real for solution in (complex(first(0.0)), complex(first(0.0, 1)))]
    assert fr.solve(equation, start, 3.0)(3.0) == pytest.approx(complex(first(3.0)).real, abs=1e-9 * abs(first(3.0)))


@pytest.mark.parametrize("per", ["tau", "z"])
@pytest.mark.parametrize("equation", [fr.Mathieu.from_aq(5.3, 4.1), fr.Mathieu(0.5, -0.25, 0.1), fr.Mathieu(0.5, -0.6)])
def test_a_real_multiplier_has_a_real_solution(equation: fr.Mathieu, per: str) -> None:
    is_unstable = fr.stability(equation).growth_rate > 0.0
    for solution in floquet_solutions(equation, per=per):
        terms = np.exp(np.multiply.outer([0.0, 0.7, 3.0], solution.exponent + 1j * solution.frequencies))
        values = terms @ solution.coefficients
        assert solution.is_real == is_unstable == np.isrealobj(solution(0.3))
        assert (np.abs(values.imag).max() < 1e-12 * np.abs(values).max()) == is_unstable
        assert [line.get_label() for line in solution.plot().lines[:2]][1:] != ["imaginary part"] or not is_unstable


def test_with_equal_exponents_there_is_one() -> None:
    beta = float(fr.mathieu.transition_curves([0.5], [1]).even[0, 0])
    found = floquet_solutions(fr.Mathieu(0.5, beta))
    assert len(found) in (1, 2)  # as the curve is rounded
    assert all(abs(solution.exponent.real) < 1e-7 for solution in found)
    (only,) = floquet_solutions(fr.Mathieu(1e-300, -1.0))
    assert only.exponent == 0j


@pytest.mark.parametrize(
    ("beta", "damping"), [(-1.0, 0.0), (-0.25, 0.0), (-0.3, 0.1), (0.7, 0.1), (0.0, 0.1), (-9.0, 2.0)]
)
def test_without_forcing_solutions_are_exponentials(beta: float, damping: float) -> None:
    """Independent ones, where the exponents differ by a whole number of turns, too."""
    first, second = floquet_solutions(fr.Mathieu(0.0, beta, damping))
    assert abs(first(0.0) * second(0.0, 1) - first(0.0, 1) * second(0.0)) > 0.1
    roots = np.roots([1.0, 2.0 * damping, -beta])
    for solution in (first, second):
        (rate,) = solution.exponent + 1j * solution.frequencies
        assert np.abs(roots - rate).min() < 1e-12
        assert solution(0.7) == pytest.approx(np.exp(0.7 * rate), rel=1e-12)
    (constant,) = floquet_solutions(fr.Mathieu(0.0, 0.0))
    assert constant(3.0) == 1.0


@given(
    st.floats(-4.0, 4.0),
    st.floats(-5.0, 1.0),
    st.sampled_from([0.0, 1e-3, 0.1, 0.4, 2.0, 150.0]),
    st.sampled_from([1.0, 30.0, 1e3]),
)
@settings(max_examples=depth(200, 15), deadline=None)
def test_exponents_are_those_of_the_verdict(alpha: float, beta: float, damping: float, scale: float) -> None:
    """Decaying ones, too, and where multipliers underflow."""
    verdict = fr.stability(fr.Mathieu(scale * alpha, scale * beta, damping))
    found = exponents(scale * alpha, scale * beta, damping)
    largest = max(1.0, damping, abs(found[0].real))
    assert found == pytest.approx(np.array(verdict.exponents), abs=1e-6 * largest)
    assert found.sum().real == pytest.approx(-2.0 * damping, abs=1e-12 * largest)
    assert exponents(scale * alpha, scale * beta, damping, per="z") == pytest.approx(2.0 * found, rel=1e-15)


def test_exponents_never_overflow_and_broadcast() -> None:
    found = exponents(np.array([[1e6], [0.5]]), [1e6, -0.6])
    assert found.shape == (2, 2, 2)
    assert np.isfinite(found).all()
    assert found[..., 0].real == pytest.approx(fr.mathieu.growth_rate(np.array([[1e6], [0.5]]), [1e6, -0.6]))
    assert 2.0 * found == pytest.approx(exponents(np.array([[1e6], [0.5]]), [1e6, -0.6], per="z"))


def test_from_aq_and_words() -> None:
    assert fr.Mathieu.from_aq(1.0, 1.0, damping=0.4).in_tau == fr.Mathieu(0.5, -0.25, 0.2)
    solution = characteristic_function(3, 10.0, "a")
    assert "ce_3(z, 10)" in repr(solution)
    assert solution == characteristic_function(3, 10.0, "a")
    ax = solution.plot()
    assert ax.get_xlabel() == "$z$"
    assert floquet_solutions(fr.Mathieu(0.5, -0.6))[0].plot(periods=1.0).get_xlabel() == r"$\tau$"
    assert floquet_solutions(fr.Mathieu(0.5, -0.6), per="z")[0].plot(periods=1.0).get_xlabel() == "$z$"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: real_order_values(2.0, 1.0), "order must not be a whole number, got 2"),
        (lambda: real_order_values(0.5, math.nan), "q"),
        (lambda: characteristic_function(0, 1.0, "b"), "order must be 1 or more"),
        (
            lambda: characteristic_function(0.5, 1.0, "a"),
            'order must be an integer, got 0.5; kind "floquet" accepts other',
        ),
        (
            lambda: characteristic_function(3, 1.0),
            'order must not be .* kind "floquet", got 3; "a" is ce and "b" is se',
        ),
        (lambda: characteristic_values(0.37, 1.0, "a"), "must hold integers, got 0.37; real_order_values accepts"),
        (lambda: characteristic_values([0, 1], 1.0, "b"), "order must lie between 1 .* and there is no b_0"),
        (lambda: exponents(a=1.2, q=0.9), "unexpected keyword argument 'a'"),  # type: ignore[call-arg]
        (lambda: characteristic_function(0.5, 1.0, "c"), "kind"),
        (lambda: characteristic_function(1, 1e8, "a"), "q must lie between"),
        (lambda: characteristic_function(3, 1.0, "a")(math.inf), "time"),
        (lambda: characteristic_function(3, 1.0, "a")(0.0, 3), "derivative"),
        (lambda: floquet_solutions(fr.Meissner(0.5, -0.2)), "Mathieu"),
        (lambda: floquet_solutions(fr.Mathieu(1e8, -0.2)), "alpha"),
        (lambda: exponents(0.5, -0.2, per="hour"), "per"),
        (lambda: fr.Mathieu.from_aq(math.nan, 1.0), "a must be"),
    ],
)
def test_bad_input(call: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call()
