"""The seam of equations: one written here alone is served by every method, by comparison and by charts."""

from __future__ import annotations

import json
import math
import pickle
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from matplotlib import pyplot
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.cli import main
from floquetrod.equations import Equation, Piece, Varying
from floquetrod.floquet import registry
from tests.conftest import depth
from tests.strategies import numbers


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
            Piece(self.ramp, start=b + a, slope=-steep),
            Piece(flat, b - a),
            Piece(self.ramp, start=b - a, slope=steep),
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
            Piece(third, start=self.beta, harmonics=(complex(0.1, self.alpha),), slope=0.4),
            Piece(third, self.beta - self.alpha),
        )


@dataclass(frozen=True)
class Ramp(Equation):
    """A ramp for a part of the period, written with its value at the beginning or with its mean, and then constant."""

    share: Fraction
    height: Fraction
    slope: Fraction
    rest: Fraction
    by_mean: bool
    damping: float = 0.0
    period: float = 2.0

    @property
    def start(self) -> Fraction:
        """Value at the beginning of the ramp, which is lower than its mean by half of what it rises."""
        rise = self.slope * self.share * Fraction(self.period)
        return self.height - rise / 2 if self.by_mean else self.height

    def pieces(self) -> tuple[Piece, ...]:
        """Return the ramp and the rest."""
        return Piece(self.share, start=self.start, slope=self.slope), Piece(1 - self.share, self.rest)

    def trace(self) -> float:
        """Return the sum of the multipliers without damping by DOP853, from the straight line through its two ends."""
        length = float(self.share) * self.period
        low, high = float(self.start), float(self.start) + float(self.slope) * length
        if self.by_mean:
            assert (low + high) / 2.0 == pytest.approx(float(self.height), abs=1e-12)

        def ramp(t: float, y: np.ndarray) -> np.ndarray:
            a, b, c, d = y
            p = low + (high - low) * t / length
            return np.array([b, p * a, d, p * c])

        def rest(t: float, y: np.ndarray) -> np.ndarray:
            a, b, c, d = y
            return np.array([b, float(self.rest) * a, d, float(self.rest) * c])

        y = np.array([1.0, 0.0, 0.0, 1.0])
        for rates, span in ((ramp, length), (rest, self.period - length)):
            y = solve_ivp(rates, (0.0, span), y, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
        return float(y[0] + y[3])


quarters = st.fractions(-9, 3, max_denominator=8)


@given(
    share=st.sampled_from([Fraction(1, 4), Fraction(1, 3), Fraction(5, 8)]),
    level=quarters,
    slope=st.fractions(-8, 8, max_denominator=8),
    rest=quarters,
    by_mean=st.booleans(),
)
@settings(max_examples=depth(500, 8), deadline=None)
def test_a_ramp_written_with_its_start_or_its_mean(
    share: Fraction, level: Fraction, slope: Fraction, rest: Fraction, by_mean: bool
) -> None:
    equation = Ramp(share, level, slope, rest, by_mean)
    trace = equation.trace()
    assume(abs(abs(trace) - 2.0) > 1e-6 * max(1.0, abs(trace)))
    expected = "unstable" if abs(trace) > 2.0 else "stable"
    verdict, system = fr.stability(equation), equation.as_system()
    assert verdict.status == expected == fr.stability(system).status
    assert sum(verdict.multipliers).real == pytest.approx(trace, rel=1e-8, abs=1e-8)
    assert fr.certify(equation).status == fr.certify(system).status == expected
    mean = float(share * level + (1 - share) * rest) + (0.0 if by_mean else float(share**2 * slope))
    assert -system.stiffness[0, 0] == pytest.approx(mean, abs=1e-12)
    if slope:
        with pytest.raises(
            ValueError, match=r"two ways: give start = mean where .* mean - slope \* share \* period / 2"
        ):
            Piece(share, level, slope=slope)
    else:
        assert Piece(share, level, slope=slope) == Piece(share, start=level)


def test_pieces_have_a_mean_or_a_start() -> None:
    for wrong in ({}, {"mean": 1.0, "start": 1.0}):
        with pytest.raises(TypeError, match="either its mean, where it has no slope, or its start"):
            Piece(Fraction(1), **wrong)
        with pytest.raises(TypeError, match="either its mean, where it has no slope, or its start"):
            Varying(**{name: [[value]] for name, value in wrong.items()})
    with pytest.raises(ValueError, match=r"two ways: give start = mean where .* mean - slope \* duration / 2"):
        Varying([[1.0]], slope=[[0.5]])
    assert Varying([[1.0]], slope=[[0.0]]) == Varying(start=[[1.0]])
    piece = Piece(Fraction(1, 3), start=0.5, harmonics=(1j,), slope=0.25)
    assert pickle.loads(pickle.dumps(piece)) == piece == eval(repr(piece), {"Piece": Piece, "Fraction": Fraction})


@given(st.integers(0, 10**6))
@settings(max_examples=depth(60, 3), deadline=None)
def test_the_picture_of_a_coefficient_is_what_it_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    share, slope = Fraction(int(rng.integers(1, 8)), 8), Fraction(int(rng.integers(-8, 8)), 4)
    ramp = Ramp(share, Fraction(-1), slope, Fraction(-2), by_mean=bool(seed % 2))
    drawn: tuple[Any, ...] = (ramp, ramp.as_system(), Bumps(0.3, -0.4), fr.Mathieu(0.5, -0.2))
    for equation in drawn:
        ax = equation.plot()
        solid = [line for line in ax.lines if line.get_linestyle() == "-" and len(line.get_xdata()) > 2]
        areas, widths = [], []
        for line in solid:
            x, y = (np.asarray(data, float) for data in line.get_data())
            assert y[1:-1] == pytest.approx(np.ravel(equation.coefficient(x[1:-1])), abs=1e-12)
            areas.append(float(np.diff(x) @ (y[1:] + y[:-1]) / 2.0))
            widths.append(x[-1] - x[0])
        (mean,) = (line for line in ax.lines if line.get_linestyle() == "-.")
        assert sum(widths) == pytest.approx(float(equation.period), rel=1e-12)
        assert mean.get_ydata()[0] == pytest.approx(sum(areas) / sum(widths), abs=1e-3)
        assert str(ax.get_ylabel()).count("$") == 2
        assert str(ax.get_xlabel()).startswith("$")
        pyplot.close("all")


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


def takes_all(method: registry.Method) -> bool:
    return method.equations is not None and method.equations.refusal is None


@settings(max_examples=depth(30, 7))
@given(KINDS, numbers(-8.0, 8.0), numbers(-12.0, 2.0), st.just(0.0) | numbers(1e-3, 0.3))
def test_every_method_serves_it_and_they_agree(kind: type, alpha: float, beta: float, damping: float) -> None:
    equation = kind(alpha, beta, damping)
    comparison = fr.compare(equation)
    results = {result.method: result for result in comparison.results}
    assert results.keys() == {method.name for method in registry.methods_for("equations") if takes_all(method)}
    monodromy, reference = results["monodromy"], results.pop("reference")
    scale = max(1.0, abs(reference.discriminant))
    for one in results.values():
        assert abs(one.discriminant - reference.discriminant) <= (one.error + reference.error) * scale, (one, reference)
    assume("undecided" not in (monodromy.status, reference.status))
    assert monodromy.status == reference.status == fr.stability(equation).status


@pytest.mark.slow
@pytest.mark.parametrize("equation", [Trapezoid(3.0, -1.5), Bumps(2.0, -0.4, 0.05)])
def test_its_discriminant_is_that_of_another_solver(equation: Equation) -> None:
    for method in ("monodromy", "reference"):
        assert fr.stability(equation, method=method).discriminant == pytest.approx(trace(equation), rel=1e-8)


@given(KINDS, numbers(-5.0, 5.0), numbers(-5.0, 1.0), numbers(-20.0, 20.0))
def test_where_the_period_begins_changes_no_eigenvalue(kind: type, alpha: float, beta: float, start: float) -> None:
    matrix = fr.methods.monodromy_matrix(kind(alpha, beta), start=start)
    found = fr.stability(kind(alpha, beta), method="monodromy")
    assert np.trace(matrix) == pytest.approx(found.discriminant, rel=1e-9, abs=1e-9 * np.abs(matrix).max())


@settings(max_examples=depth(20, 4))
@given(KINDS, numbers(-5.0, 5.0), numbers(-8.0, 2.0), st.just(0.0) | numbers(1e-2, 0.3))
def test_it_is_proved(kind: type, alpha: float, beta: float, damping: float) -> None:
    assume(alpha != 0.0)
    equation = kind(alpha, beta, damping)
    proof, verdict = fr.certify(equation, max_digits=30), fr.stability(equation)
    assert isinstance(proof, fr.results.Proof)
    assert proof.equation == equation
    assert {proof.status, verdict.status} != {"stable", "unstable"}
    clear = damping == 0.0 and abs(abs(verdict.discriminant) - 2.0) > 1e-6
    assert proof.status != "undecided" or not clear
    assert proof.status == fr.certify(equation.as_system(), max_digits=30).status
    assert ("its period, 2 pi, was taken as the double" in proof.statement) == (kind is Trapezoid)


@pytest.mark.slow
@settings(max_examples=depth(10, 3))
@given(KINDS, numbers(0.5, 3.0), numbers(-3.0, 0.5), st.just(0.0) | numbers(1e-2, 0.3))
def test_it_is_solved_and_has_floquet_solutions(kind: type, alpha: float, beta: float, damping: float) -> None:
    equation = kind(alpha, beta, damping)
    verdict = fr.stability(equation)
    assume(abs(verdict.exponents[0] - verdict.exponents[1]) * verdict.period > 1e-2)
    matrix, error = verdict.monodromy
    assert np.abs(matrix - fr.methods.monodromy_matrix(equation)).max() < 1e-9 * np.abs(matrix).max() + error
    times = np.linspace(0.0, 2.0, 9) * equation.period
    for mode, exponent in zip(fr.floquet_solutions(equation), verdict.exponents, strict=True):
        assert mode.exponent.real == pytest.approx(exponent.real, abs=1e-9)
        both = [
            fr.solve(equation, part, times[-1])
            for part in zip(*((mode(0.0, d).real, mode(0.0, d).imag) for d in (0, 1)), strict=True)
        ]
        size = np.abs(mode(times)).max() + np.abs(mode(times[-1]))
        growth = np.exp(verdict.growth_rate * times[-1])  # which a solution that decays has of the other
        assert mode(times) == pytest.approx(both[0](times) + 1j * both[1](times), abs=1e-9 * (size + growth))


@pytest.mark.parametrize("kind", [Trapezoid, Bumps])
def test_everything_about_it_can_be_pickled(kind: type) -> None:
    equation = kind(1.5, -0.6, 0.02)
    results = [equation, fr.stability(equation), fr.certify(equation), fr.solve(equation, (1.0, 0.0), 3.0)]
    for result in [*results, *fr.floquet_solutions(equation)]:
        assert pickle.loads(pickle.dumps(result)) == result
    assert pickle.loads(pickle.dumps(fr.compare(equation))).results == fr.compare(equation).results


@pytest.mark.parametrize("kind", [Trapezoid, Bumps])
def test_the_damping_that_stabilises_it_does(kind: type) -> None:
    equation = kind(2.5, -1.0)
    least = fr.stability(equation).damping_to_stabilise
    assert 0.0 < least < math.inf
    assert fr.stability(kind(2.5, -1.0, least * (1.0 + 1e-7))).status == "stable"
    assert fr.stability(kind(2.5, -1.0, least * (1.0 - 1e-7))).status == "unstable"


def test_the_terminal_takes_it_as_a_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    equation = Trapezoid(2.5, -1.0, 0.03)
    lines = ["[system]", f"damping = [[{2.0 * equation.damping!r}]]"]
    for piece in equation.pieces():
        lines += ["[[system.pieces]]", f"duration = {float(piece.share) * equation.period!r}"]
        lines += [f"stiffness_start = [[{-float(piece.start)!r}]]", f"slope = [[{-float(piece.slope)!r}]]"]
    path = tmp_path / "trapezoid.toml"
    path.write_text("\n".join(lines))
    assert main(["check", "--system", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    verdict = fr.stability(equation)
    assert found["status"] == verdict.status
    assert found["growth_rate_per_unit_time"] == pytest.approx(verdict.growth_rate, rel=1e-9)
    assert main(["certify", "--system", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == fr.certify(equation).status == verdict.status


@dataclass(frozen=True)
class Smooth(Equation):
    """A smooth equation whose period is an exact multiple of pi, and not 2 pi."""

    alpha: float
    beta: float
    damping: float = 0.0

    @property
    def period(self) -> float:
        """Period in tau."""
        return math.pi

    @property
    def period_over_pi(self) -> Fraction:
        """Its exact value over pi."""
        return Fraction(1)

    def pieces(self) -> tuple[Piece, ...]:
        """Return the series."""
        return (Piece(Fraction(1), self.beta, (complex(self.alpha, 0.0),)),)


@pytest.mark.parametrize("alpha", [1e-12, 0.3, 4.0])
def test_a_smooth_one_is_proved_as_fast_as_mathieus_and_with_its_exact_period(alpha: float) -> None:
    """A'' = (beta + alpha cos 2 tau) A is Mathieu's equation in twice the time; its first tongue is at beta = -1."""
    for beta in (-1.0, -0.7, -2.6, 0.1):
        proof, known = fr.certify(Smooth(alpha, beta)), fr.certify(fr.Mathieu(alpha / 4.0, beta / 4.0))
        assert (proof.status, proof.interval) == (known.status, known.interval)
        assert fr.stability(Smooth(alpha, beta)).status == known.status


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
    value = float(piece.start) + float(piece.slope) * (phase - (ends[i - 1] if i else 0.0))
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
    for method in (method.name for method in registry.methods_for("equations") if not takes_all(method)):
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
