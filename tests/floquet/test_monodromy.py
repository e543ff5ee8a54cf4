"""The Taylor map over a period: its order, Liouville, invariance under shifts of time."""

from __future__ import annotations

import importlib
import math
import sys
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.methods import monodromy, monodromy_matrix
from tests.conftest import depth, needs_jit
from tests.inside import advance
from tests.strategies import hills, mathieus, square_waves

pytestmark = pytest.mark.kernels

EQUATIONS = (
    mathieus(largest_alpha=10.0, beta=(-20.0, 1.0), largest_damping=0.5)
    | square_waves(largest=5.0, largest_damping=0.5)
    | hills(largest=5.0, largest_damping=0.5)
)


@settings(max_examples=depth(60, 15))
@given(EQUATIONS, st.floats(-30.0, 30.0))
def test_liouville_and_invariance_under_a_shift_of_time(
    equation: fr.Mathieu | fr.Meissner | fr.Hill, start: float
) -> None:
    at_zero, shifted = monodromy_matrix(equation), monodromy_matrix(equation, start=start)
    size = max(1.0, np.abs(at_zero).max(), np.abs(shifted).max())
    expected = math.exp(-2.0 * equation.damping * equation.period)
    assert np.linalg.det(at_zero) == pytest.approx(expected, abs=1e-11 * size**2)
    assert np.trace(shifted) == pytest.approx(np.trace(at_zero), abs=1e-10 * size)


@settings(max_examples=depth(60, 15))
@given(EQUATIONS)
def test_half_a_period_and_a_whole_one_agree(equation: fr.Mathieu | fr.Meissner | fr.Hill) -> None:
    matrix = monodromy_matrix(equation)
    result = monodromy(equation)
    assert np.trace(matrix) == pytest.approx(result.discriminant, abs=1e-10 * max(1.0, np.abs(matrix).max()))


def test_an_even_series_is_recognised_wherever_it_starts() -> None:
    shift = 0.7
    plain = fr.Hill(-0.3, cosines=(0.5, 0.0, 0.2))
    moved = fr.Hill(
        -0.3,
        cosines=(0.5 * math.cos(shift), 0.0, 0.2 * math.cos(3 * shift)),
        sines=(0.5 * math.sin(shift), 0.0, 0.2 * math.sin(3 * shift)),
    )
    assert monodromy(moved).discriminant == pytest.approx(monodromy(plain).discriminant, abs=1e-13)
    assert monodromy(moved).cost == monodromy(plain).cost
    lopsided = fr.Hill(-0.3, cosines=(0.5, 0.2), sines=(0.0, 0.3))
    assert monodromy(lopsided).cost.amount > monodromy(plain).cost.amount


def test_a_sine_too_small_for_an_angle_is_taken() -> None:
    # cmath.phase raises OverflowError where the angle is below the least double.
    one, other = fr.Hill(0.0, (2.0,), (5e-324,), 1.0), fr.Hill(0.0, (2.0,), (), 1.0)
    assert fr.stability(one, method="monodromy").discriminant == fr.stability(other, method="monodromy").discriminant


@pytest.mark.parametrize("order", [4, 6, 8])
def test_the_order_of_the_series_is_the_order_of_the_error(order: int) -> None:
    ends = []
    for steps in (8, 16, 32, 400):
        y = np.array([1.0, 0.0, 0.0, 1.0])
        advance(-0.7, 0.0, [0.9, 0.3], [0.1, -0.4], 1.0, 0.2, 3.0, steps, order, y)
        ends.append(y)
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    measured = [math.log2(errors[i] / errors[i + 1]) for i in (0, 1)]
    assert measured[1] == pytest.approx(order, abs=0.5)


def test_interpreted_and_compiled_kernels_agree() -> None:
    ends = []
    for run in (advance, compiled(advance)):
        y = np.array([1.0, 0.0, 0.0, 1.0])
        exponent = run(30.0, 0.5, np.array([0.9]), np.array([0.1]), 1.0, 0.2, 60.0, 200, 24, y)
        ends.append((*y, exponent))
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)
    assert ends[0][-1] > 100


def test_numba_is_used_where_it_is_loaded_and_not_loaded_for_a_few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []

    def recorded(function: Callable[..., Any]) -> Callable[..., Any]:
        asked.append(function)
        return compiled(function)

    monkeypatch.setattr("floquetrod._util.compilation.compiled", recorded)
    equation = fr.Hill(-0.3, (0.5, 0.2), (0.0, 0.3))
    monkeypatch.setitem(sys.modules, "numba", importlib.import_module("numba"))
    loaded = monodromy(equation)
    assert set(asked) == {advance}
    asked.clear()
    monkeypatch.delitem(sys.modules, "numba")
    assert monodromy(equation) == loaded
    assert not asked
    assert "numba" not in sys.modules


def test_growth_beyond_the_range_of_a_double() -> None:
    equation = fr.Mathieu(2000.0, 30000.0)
    result, exact = monodromy(equation), fr.stability(equation, method="spectral")
    assert math.isinf(result.discriminant)
    assert result.log_abs_discriminant == pytest.approx(exact.log_abs_discriminant, rel=1e-12)
    with pytest.raises(OverflowError, match="exceeds the range of a double"):
        monodromy_matrix(equation)


def test_too_many_steps_are_declined() -> None:
    result = monodromy(fr.Hill(-1e9, cosines=(1e9,), period=1e4))
    assert result.status == "undecided"
    assert "steps" in result.note
    with pytest.raises(ValueError, match="rtol must be greater than zero"):
        monodromy(fr.Mathieu(1.0, 1.0), rtol=0.0)


@settings(max_examples=depth(30, 7))
@given(mathieus(largest_alpha=50.0, beta=(-50.0, 5.0), largest_damping=0.3))
def test_the_sign_of_alpha_is_a_shift_of_half_a_period(equation: fr.Mathieu) -> None:
    one, other = monodromy(equation), monodromy(fr.Mathieu(-equation.alpha, equation.beta, equation.damping))
    assert one.discriminant == pytest.approx(other.discriminant, rel=one.error, abs=one.error)
    assert {one.status, other.status} != {"stable", "unstable"}


@pytest.mark.parametrize("beta", [-7.3, -0.3, -1e-9, 1e-9, 0.04, 9.0])
@pytest.mark.parametrize("kind", [fr.Mathieu, fr.Meissner])
def test_a_constant_coefficient_has_a_closed_form(kind: type[fr.Mathieu] | type[fr.Meissner], beta: float) -> None:
    result = monodromy(kind(0.0, beta))
    angle = 2.0 * math.pi * math.sqrt(abs(beta))
    exact = 2.0 * (math.cosh(angle) if beta > 0.0 else math.cos(angle))
    assert abs(result.discriminant - exact) <= result.error * max(1.0, abs(exact))
    assert result.status == ("unstable" if beta > 0.0 else "stable")


def test_the_boundary_above_the_papers_point() -> None:
    # F2-c: at beta = -0.80 the tongue begins between alpha = 1.58 and 1.6.
    assert monodromy(fr.Mathieu(1.58, -0.80)).status == "stable"
    assert monodromy(fr.Mathieu(1.60, -0.80)).status == "unstable"


@pytest.mark.parametrize("index", [-39, -38, -35, -1, 1, 2, 3, 7, 38])
def test_a_square_wave_may_start_at_a_jump_or_beside_it(index: int) -> None:
    equation = fr.Meissner(1.3, -0.6)
    expected = monodromy_matrix(equation, start=math.pi if index % 2 else 0.0)
    jump = index * math.pi
    for start in (math.nextafter(jump, -math.inf), jump, math.nextafter(jump, math.inf)):
        assert monodromy_matrix(equation, start=start) == pytest.approx(expected, abs=1e-10)


def test_growth_and_decay_that_cancel_do_not_overflow() -> None:
    # u grows by exp(817); A decays, its slower exponent about p / 2 c.
    equation = fr.Mathieu(0.5, -0.25, damping=130.0)
    matrix, result = monodromy_matrix(equation), monodromy(equation)
    assert np.trace(matrix) == pytest.approx(result.discriminant, rel=1e-9)
    assert result.discriminant == pytest.approx(math.exp(-0.25 * math.pi / 130.0), rel=1e-4)


@pytest.mark.parametrize("period", [1e-300, 1e-30, 1e-6])
def test_a_period_too_short_for_any_coefficient_leaves_free_motion(period: float) -> None:
    result = monodromy(fr.Hill(-1e-9, cosines=(1e-9,), period=period))
    assert result.discriminant == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize("period", [1e-3, 1.0, 1e6])
def test_the_unit_of_time_does_not_matter(period: float) -> None:
    w = 2.0 * math.pi / period
    result = monodromy(fr.Hill(-0.3 * w * w, cosines=(0.5 * w * w,), period=period))
    assert result.discriminant == pytest.approx(monodromy(fr.Mathieu(0.5, -0.3)).discriminant, abs=1e-12)


def test_a_period_too_long_is_declined() -> None:
    for period in (1e300, 1e307):
        assert monodromy(fr.Hill(-1e9, period=period)).status == "undecided"
        with pytest.raises(ValueError, match="period too long"):
            monodromy_matrix(fr.Hill(-1e9, period=period))


@needs_jit
def test_maps_scaled_at_different_steps_still_compare() -> None:
    # Two maps of 20 and more rescalings each: steps are halved once, because the first halving already agrees.
    result = monodromy(fr.Meissner(1.0, 1e7))
    assert result.status == "unstable"
    assert result.growth_rate == pytest.approx(math.sqrt(1e7), rel=1e-9)
    assert result.cost.amount <= 3 * (math.pi * (math.sqrt(1e7 + 1.0) + 1.0) / 1.9 + 2.0)


def test_error_of_the_matrix_holds_the_rounding_of_the_times_of_jumps() -> None:
    # A stiff piece after a long soft one: 1000.1 + 0.7 rounded moves its end by more than the steps round.
    pieces = [(1000.1, 1e-6), (0.7, 1e4), (0.3, 4e4)]
    matrix, error = fr.stability(fr.HillSystem.from_pieces([(t, [[k]]) for t, k in pieces])).monodromy
    with mpmath.workdps(40):
        true = mpmath.eye(2)
        for t, k in pieces:
            true = mpmath.expm(mpmath.matrix([[0, 1], [-k, 0]]) * mpmath.mpf(t)) * true
        assert (
            max(abs(matrix[i, j] - true[i, j]) for i in range(2) for j in range(2)) <= error < 1e-6 * abs(matrix).max()
        )
