"""The seam of equations: one written here alone is served by every method, by comparison and by charts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import floquetrod as fr
from conftest import depth
from floquetrod.equations import Equation, Piece
from strategies import numbers


@dataclass(frozen=True)
class Trapezoid(Equation):
    """A'' + 2 c A' = (beta + alpha w(tau)) A, w a trapezoidal wave whose flanks take ``ramp`` of the period each."""

    alpha: float
    beta: float
    damping: float = 0.0
    ramp: Fraction = Fraction(1, 8)

    @property
    def period(self) -> float:
        """Period in tau."""
        return 2.0 * math.pi

    @property
    def period_over_pi(self) -> Fraction:
        """Its exact value over pi."""
        return Fraction(2)

    def pieces(self) -> tuple[Piece, ...]:
        """Return the flat parts and the flanks."""
        a, b, flat = Fraction(self.alpha), Fraction(self.beta), Fraction(1, 2) - self.ramp
        steep = 2 * a / (self.ramp * Fraction(self.period))
        return (
            Piece(flat, b + a),
            Piece(self.ramp, b + a, slope=-steep),
            Piece(flat, b - a),
            Piece(self.ramp, b - a, slope=steep),
        )


@dataclass(frozen=True)
class Bumps(Equation):
    """A coefficient that is a wave for a third of the period, a ramped wave for another, and then constant."""

    alpha: float
    beta: float
    damping: float = 0.0

    @property
    def period(self) -> float:
        """Period in tau."""
        return 5.0

    def pieces(self) -> tuple[Piece, ...]:
        """Return the three parts."""
        third = Fraction(1, 3)
        return (
            Piece(third, self.beta, (complex(self.alpha, 0.2), complex(0.0, 0.3 * self.alpha))),
            Piece(third, self.beta, (complex(0.1, self.alpha),), slope=0.4),
            Piece(third, self.beta - self.alpha),
        )


KINDS = st.sampled_from((Trapezoid, Bumps))


def trace(equation: Equation) -> float:
    """Return the sum of the multipliers by SciPy's solver of ordinary differential equations, step by step to jumps."""
    ends = np.cumsum([0.0, *(float(piece.share) for piece in equation.pieces())]) * equation.period
    y = np.array([1.0, 0.0, 0.0, 1.0])
    for begin, end in pairwise(ends):
        inside = end - begin

        def rates(t: float, y: np.ndarray, begin: float = begin, inside: float = inside) -> list[float]:
            p = equation.coefficient(begin + min(max(t - begin, 1e-9 * inside), (1.0 - 1e-9) * inside))  # not at a jump
            c = equation.damping
            return [y[1], p * y[0] - 2.0 * c * y[1], y[3], p * y[2] - 2.0 * c * y[3]]

        y = solve_ivp(rates, (begin, end), y, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return float(y[0] + y[3])


@settings(max_examples=depth(30, 7))
@given(KINDS, numbers(-8.0, 8.0), numbers(-12.0, 2.0), st.just(0.0) | numbers(1e-3, 0.3))
def test_every_method_serves_it_and_they_agree(kind: type, alpha: float, beta: float, damping: float) -> None:
    equation = kind(alpha, beta, damping)
    comparison = fr.compare(equation)
    assert [result.method for result in comparison.results] == ["monodromy", "leapfrog", "reference"]
    monodromy, leapfrog, reference = comparison.results
    scale = max(1.0, abs(reference.discriminant))
    for one in (monodromy, leapfrog):
        assert abs(one.discriminant - reference.discriminant) <= (one.error + reference.error) * scale, (one, reference)
    assume("undecided" not in (monodromy.status, reference.status))
    assert monodromy.status == reference.status == fr.stability(equation).status


@pytest.mark.parametrize("equation", [Trapezoid(3.0, -1.5), Bumps(2.0, -0.4, 0.05)])
def test_its_discriminant_is_that_of_another_solver(equation: Equation) -> None:
    for method in ("monodromy", "reference"):
        assert fr.stability(equation, method=method).discriminant == pytest.approx(trace(equation), rel=1e-8)


@given(KINDS, numbers(-5.0, 5.0), numbers(-5.0, 1.0), numbers(-20.0, 20.0))
def test_where_the_period_begins_changes_no_eigenvalue(kind: type, alpha: float, beta: float, start: float) -> None:
    matrix = fr.methods.monodromy_matrix(kind(alpha, beta), start=start)
    found = fr.stability(kind(alpha, beta), method="monodromy")
    assert np.trace(matrix) == pytest.approx(found.discriminant, rel=1e-9, abs=1e-9 * np.abs(matrix).max())


def test_steep_ramps_tend_to_the_square_wave() -> None:
    square = fr.stability(fr.Meissner(2.0, -1.0)).discriminant
    far, near = (fr.stability(Trapezoid(2.0, -1.0, ramp=Fraction(1, n))).discriminant for n in (1000, 10_000))
    assert abs(near - square) < 0.2 * abs(far - square) < 1e-2


@given(KINDS, numbers(-1e3, 1e3))
def test_the_coefficient_is_that_of_its_pieces(kind: type, tau: float) -> None:
    equation = kind(2.0, -0.5)
    phase = tau % equation.period
    ends = np.cumsum([float(piece.share) for piece in equation.pieces()]) * equation.period
    assume(np.abs(np.append(ends, 0.0) - phase).min() > 1e-9)
    i = int(np.searchsorted(ends, phase))
    piece = equation.pieces()[i]
    value = float(piece.mean) + float(piece.slope) * (phase - (ends[i - 1] if i else 0.0))
    for k, z in enumerate(piece.harmonics, start=1):
        value += (z * np.exp(2j * math.pi * k * phase / equation.period)).real
    assert equation.coefficient(tau) == pytest.approx(value, rel=1e-9, abs=1e-9)


def test_at_a_jump_the_coefficient_has_its_mean() -> None:
    equation = Bumps(2.0, -0.5)
    before, after = equation.coefficient([5.0 - 1e-12, 5.0 + 1e-12])
    assert equation.coefficient(0.0) == equation.coefficient(5.0) == pytest.approx(0.5 * (before + after))


def test_charts_take_it() -> None:
    chart = fr.mathieu.chart((0.5, 3.0, 4), (-2.0, 0.0, 3), equation=Trapezoid, growth=True)
    assert chart.caption.startswith("Trapezoid, ")
    for row, beta in enumerate(chart.y.values):
        for column, alpha in enumerate(chart.x.values):
            assert chart.stable[row, column] == fr.stability(Trapezoid(alpha, beta)).stable


def test_constant_coefficients_are_decided_by_their_sign() -> None:
    for damping, level, status in ((0.0, -0.25, "stable"), (0.0, 0.0, "unstable"), (0.1, 0.0, "stable")):
        flat = Trapezoid(0.0, level, damping)
        assert {r.status for r in fr.compare(flat).results if r.method != "leapfrog"} == {status}


def test_what_a_method_cannot_serve_it_refuses() -> None:
    for method in ("spectral", "determinant", "square_wave"):
        with pytest.raises(TypeError, match="equation must be"):
            fr.stability(Trapezoid(1.0, 0.0), method=method)


@pytest.mark.parametrize("share", [Fraction(1, 3), Fraction(0), 0.5])
def test_pieces_that_leave_gaps_are_refused(share: Fraction | float) -> None:
    class Gap(Trapezoid):
        def pieces(self) -> tuple[Piece, ...]:
            """Return two pieces."""
            return Piece(Fraction(1, 2), self.beta), Piece(share, self.alpha)  # type: ignore[arg-type]

    with pytest.raises(ValueError, match="equation must have pieces whose shares are positive Fractions"):
        fr.stability(Gap(1.0, 0.0))
