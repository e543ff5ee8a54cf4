"""The Taylor map over a period: its order, Liouville, invariance under shifts of time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod._compile import compiled
from floquetrod.kernels.taylor import advance
from floquetrod.methods.monodromy import monodromy, monodromy_matrix
from strategies import hills, mathieus, square_waves

pytestmark = pytest.mark.kernels

EQUATIONS = (
    mathieus(largest_alpha=10.0, beta=(-20.0, 1.0), largest_damping=0.5)
    | square_waves(largest=5.0, largest_damping=0.5)
    | hills(largest=5.0, largest_damping=0.5)
)


@settings(max_examples=60)
@given(EQUATIONS, st.floats(-30.0, 30.0))
def test_liouville_and_invariance_under_a_shift_of_time(
    equation: fr.Mathieu | fr.SquareWave | fr.Hill, start: float
) -> None:
    at_zero, shifted = monodromy_matrix(equation), monodromy_matrix(equation, start=start)
    size = max(1.0, np.abs(at_zero).max(), np.abs(shifted).max())
    expected = math.exp(-2.0 * equation.damping * equation.period)
    assert np.linalg.det(at_zero) == pytest.approx(expected, abs=1e-11 * size**2)
    assert np.trace(shifted) == pytest.approx(np.trace(at_zero), abs=1e-10 * size)


@settings(max_examples=60)
@given(EQUATIONS)
def test_half_a_period_and_a_whole_one_agree(equation: fr.Mathieu | fr.SquareWave | fr.Hill) -> None:
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


@pytest.mark.parametrize("order", [4, 6, 8])
def test_the_order_of_the_series_is_the_order_of_the_error(order: int) -> None:
    ends = []
    for steps in (8, 16, 32, 400):
        y = np.array([1.0, 0.0, 0.0, 1.0])
        advance(-0.7, [0.9, 0.3], [0.1, -0.4], 1.0, 0.2, 3.0, steps, order, y)
        ends.append(y)
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    measured = [math.log2(errors[i] / errors[i + 1]) for i in (0, 1)]
    assert measured[1] == pytest.approx(order, abs=0.5)


def test_interpreted_and_compiled_kernels_agree() -> None:
    ends = []
    for run in (advance, compiled(advance)):
        y = np.array([1.0, 0.0, 0.0, 1.0])
        exponent = run(30.0, np.array([0.9]), np.array([0.1]), 1.0, 0.2, 60.0, 200, 24, y)
        ends.append((*y, exponent))
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)
    assert ends[0][-1] > 100


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
