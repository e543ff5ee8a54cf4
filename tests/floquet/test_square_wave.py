"""The closed form of the square wave."""

from __future__ import annotations

import cmath
import math

import pytest
from hypothesis import given, settings

import floquetrod as fr
from floquetrod.methods import monodromy, square_wave
from tests.conftest import depth
from tests.strategies import square_waves


@settings(max_examples=depth(150, 37))
@given(square_waves(largest=40.0, largest_damping=0.3))
def test_closed_form_against_integration(equation: fr.Meissner) -> None:
    closed, carried = square_wave(equation), monodromy(equation)
    assert {closed.status, carried.status} != {"stable", "unstable"}
    scale = max(1.0, abs(closed.discriminant))
    assert abs(closed.discriminant - carried.discriminant) <= (closed.error + carried.error) * scale


@pytest.mark.parametrize(("alpha", "beta"), [(0.7, 0.2), (3.0, -1.0), (1.3, 1.2), (20.0, -19.5)])
def test_the_papers_formula_where_it_is_stated(alpha: float, beta: float) -> None:
    # Eq. (A4), for alpha > |beta|, with q^2 = alpha - beta and p^2 = alpha + beta.
    q, p = math.sqrt(alpha - beta), math.sqrt(alpha + beta)
    trace = 2.0 * math.cos(math.pi * q) * math.cosh(math.pi * p)
    trace += (p / q - q / p) * math.sin(math.pi * q) * math.sinh(math.pi * p)
    assert square_wave(fr.Meissner(alpha, beta)).discriminant == pytest.approx(trace, rel=1e-12)


@pytest.mark.parametrize(
    ("alpha", "beta"), [(0.5, -0.9), (0.3, 2.0), (2.0, 2.0), (2.0, -2.0), (0.0, -0.49), (0.0, 0.0)]
)
def test_the_formula_continued_to_complex_p_and_q(alpha: float, beta: float) -> None:
    # Where p or q vanishes the limit is taken by a small complex step, whose error is of second order.
    q, p = cmath.sqrt(alpha - beta + 1e-9j), cmath.sqrt(alpha + beta + 1e-9j)
    trace = 2.0 * cmath.cos(math.pi * q) * cmath.cosh(math.pi * p)
    trace += (p / q - q / p) * cmath.sin(math.pi * q) * cmath.sinh(math.pi * p)
    assert square_wave(fr.Meissner(alpha, beta)).discriminant == pytest.approx(trace.real, rel=1e-9, abs=1e-9)


def test_huge_growth_does_not_overflow() -> None:
    result = square_wave(fr.Meissner(1e6, 5e5))
    assert math.isinf(result.discriminant)
    assert result.growth_rate == pytest.approx(result.log_abs_discriminant / (2.0 * math.pi), rel=1e-12)
    assert monodromy(fr.Meissner(2e4, 1e4)).growth_rate == pytest.approx(
        square_wave(fr.Meissner(2e4, 1e4)).growth_rate, rel=1e-10
    )


def test_for_mathieu_it_is_labelled_an_approximation() -> None:
    assert "approximation" in square_wave(fr.Mathieu(0.5, -0.25)).note
    assert square_wave(fr.Meissner(0.5, -0.25)).note == ""
    with pytest.raises(TypeError, match="Meissner, Mathieu for the square-wave method"):
        square_wave(fr.Hill(0.0))  # type: ignore[arg-type]


def test_a_degenerate_boundary_is_undecided_by_doubles_and_proved_by_intervals() -> None:
    # r_1 = i, r_2 = 3i: every solution has period 2 pi, the discriminant touches 2 without crossing.
    equation = fr.Meissner(4.0, -5.0)
    assert square_wave(equation).status == "undecided"
    assert fr.certify(equation).status == "stable"


@given(square_waves())
def test_the_sign_of_alpha_does_not_matter(equation: fr.Meissner) -> None:
    one, other = square_wave(equation), square_wave(fr.Meissner(-equation.alpha, equation.beta))
    assert one.discriminant == pytest.approx(other.discriminant, rel=one.error, abs=one.error)
