"""Mathieu's equation in (a, q): answers in its own time z, beside those of the same equation in tau = 2 z + pi / 2."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr

POINTS = st.tuples(  # whose quarter is no double that rounds to zero
    st.floats(-3.0, 12.0).map(lambda a: round(a, 9)),
    st.floats(-4.0, 4.0).map(lambda q: round(q, 9)),
    st.one_of(st.just(0.0), st.floats(1e-3, 0.5)),
)


def pair(point: tuple[float, float, float]) -> tuple[Any, fr.Mathieu]:
    equation = fr.Mathieu.from_aq(*point)
    return equation, equation.in_tau


@given(POINTS, st.sampled_from(["auto", "spectral", "determinant", "monodromy", "square_wave", "reference"]))
def test_verdicts_are_those_in_tau_with_rates_per_z(point: tuple[float, float, float], method: str) -> None:
    verdict, same = (fr.stability(each, method) for each in pair(point))
    assert verdict.equation == fr.Mathieu.from_aq(*point)
    assert (verdict.status, verdict.interval, verdict.unit, same.unit) == (same.status, same.interval, "z", "tau")
    assert verdict.discriminant == pytest.approx(same.discriminant, rel=1e-9, abs=1e-9)
    near = abs(abs(same.discriminant) - 2.0) < 1e-6  # where exponents are those of a root
    for ours, theirs in zip(verdict.exponents, same.exponents, strict=True):
        assert ours == pytest.approx(2.0 * theirs, abs=1e-3 if near else 1e-8)
    assert verdict.growth_rate == pytest.approx(2.0 * same.growth_rate, abs=1e-3 if near else 1e-8)
    assert verdict.exponent_errors == pytest.approx([2.0 * error for error in same.exponent_errors], rel=0.5, abs=1e-6)
    assert (verdict.period, same.period) == (math.pi, 2.0 * math.pi)


@given(POINTS)
def test_proofs_are_those_in_tau(point: tuple[float, float, float]) -> None:
    proof, same = map(fr.certify, pair(point))
    assert (proof.status, proof.interval, proof.digits) == (same.status, same.interval, same.digits)
    assert repr(proof.equation) == repr(fr.Mathieu.from_aq(*point))


@given(POINTS, st.floats(0.1, 3.0))
def test_a_solution_starts_at_z_0_and_has_its_derivative_in_z(point: tuple[float, float, float], z: float) -> None:
    equation, same = pair(point)
    solution = fr.solve(equation, initial=(1.0, 0.5), span=z)
    quarter = 0.5 * math.pi
    in_tau = fr.solve(same, initial=(1.0, 0.25), span=(quarter, 2.0 * z + quarter))  # A' is half of y'
    tau = 2.0 * z + quarter
    assert solution(z) == pytest.approx(in_tau(tau), rel=1e-9, abs=1e-9)
    assert solution(z, derivative=1) == pytest.approx(2.0 * in_tau(tau, derivative=1), rel=1e-9, abs=1e-9)
    free = fr.solve(fr.Mathieu.from_aq(4.0, 0.0), initial=(1.0, 0.0), span=z)
    assert free(z) == pytest.approx(math.cos(2.0 * z), abs=1e-12)


@given(POINTS)
def test_coefficient_and_pieces_are_those_of_dlmf(point: tuple[float, float, float]) -> None:
    a, q, _ = point
    equation, same = pair(point)
    z = np.linspace(-2.0, 4.0, 25)
    assert equation.coefficient(z) == pytest.approx(2.0 * q * np.cos(2.0 * z) - a, abs=1e-14)
    assert equation.as_hill().coefficient(z) == pytest.approx(equation.coefficient(z), abs=1e-13)
    assert super(type(equation), equation).coefficient(z) == pytest.approx(equation.coefficient(z), abs=1e-12)
    assert equation.coefficient(z) == pytest.approx(4.0 * same.coefficient(2.0 * z + 0.5 * math.pi), abs=1e-12)


def test_reports_say_growth_per_z_and_the_damping_as_it_was_given() -> None:
    equation = fr.Mathieu.from_aq(a=1.0, q=1.0, damping=0.1)
    verdict = fr.stability(equation)
    assert repr(equation) == "Mathieu.from_aq(a=1.0, q=1.0, damping=0.1)"
    assert "grows at 0.354917 per unit z" in repr(verdict)
    assert "Mathieu.from_aq(a=1.0, q=1.0, damping=0.1)" in str(verdict.report())
    assert "0.354917 per unit z" in str(verdict.report())
    assert verdict.as_dict()["growth_rate_per_z"] == verdict.growth_rate
    assert verdict.damping_to_stabilise == pytest.approx(
        2.0 * fr.stability(equation.in_tau).damping_to_stabilise, rel=1e-9
    )
    assert "growth per z" in str(fr.compare(equation).report())
    assert "$p(z)$" in equation.plot().get_ylabel()
    assert equation.plot().get_xlabel() == r"$z$, over a period of $\pi$"


def test_charts_have_growth_per_z_in_their_numbers_and_colour_bars() -> None:
    def damped(a: float, q: float) -> Any:
        return fr.Mathieu.from_aq(a, q, damping=0.1)

    over = {"q": (0.1, 3.0, 5), "a": (-1.0, 5.0, 6)}
    chart = fr.chart(damped, over=over, growth=True, growth_tolerance=0.05)
    assert chart.growth_unit == "per z"
    assert "growth up to 0.05 per z counts as stable" in chart.caption
    for row, a in enumerate(chart.y.values):
        for column, q in enumerate(chart.x.values):
            rate = fr.mathieu.growth_rate(*fr.conventions.from_aq(a, q), 0.05)  # c is half of k
            assert chart.growth_rate[row, column] == pytest.approx(2.0 * rate, abs=1e-9)
    axes = chart.plot(bands=False)
    assert "growth rate per unit of $z$" in [ax.get_ylabel() for ax in axes.figure.axes]


def test_boxes_of_a_and_q_have_their_tolerance_per_z() -> None:
    box = {"a": (0.98, 1.02), "q": (0.1, 0.12)}
    rate = fr.stability(fr.Mathieu.from_aq(1.0, 0.11)).growth_rate
    assert rate == pytest.approx(0.055, abs=1e-3)  # q / 2
    loose, tight = (fr.certify(fr.Mathieu, growth_tolerance=each * rate, **box) for each in (1.3, 0.6))
    assert (loose.status, tight.status) == ("stable", "unstable")
    assert loose.growth_unit == "per z"
    assert loose.growth_tolerance == pytest.approx(1.3 * rate)
    assert loose.statement.endswith(f"no solution grows faster than {1.3 * rate:g} per z")


def test_floquet_solutions_are_functions_of_z() -> None:
    equation = fr.Mathieu.from_aq(a=1.0, q=1.0, damping=0.1)
    for ours, theirs in zip(
        fr.mathieu.floquet_solutions(equation), fr.mathieu.floquet_solutions(equation.in_tau, per="z"), strict=True
    ):
        assert ours == theirs
        z = np.linspace(0.0, 3.0, 7)
        residual = ours(z, 2) + 0.2 * ours(z, 1) - equation.coefficient(z) * ours(z)
        assert np.abs(residual).max() < 1e-10
    assert fr.mathieu.floquet_solutions(equation, per="tau") == fr.mathieu.floquet_solutions(equation.in_tau)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"a": math.nan, "q": 1.0}, "a must be"),
        ({"a": 1.0, "q": 1e10}, "q must lie"),
        ({"a": 5e9, "q": 1.0}, "a must lie"),
        ({"a": 1.0, "q": 1.0, "damping": -0.1}, "damping must be zero or more"),
    ],
)
def test_wrong_parameters_are_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.Mathieu.from_aq(**arguments)
