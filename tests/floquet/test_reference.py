"""The arbitrary-precision method against closed forms, itself at other precision, and equations that must agree."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.equations import Equation, Hill, Mathieu, Meissner
from floquetrod.floquet.methods.reference import DiscriminantExcess, TooMuchWork
from floquetrod.methods import discriminant_excess, reference
from tests.conftest import depth
from tests.strategies import hills, mathieus, near_boundary_points, numbers, square_waves

mp = mpmath.mp.clone()  # for what the tests compute themselves
mp.dps = 150


def relative(x: Any, y: Any) -> Any:
    """Return the distance of two excesses in the sense of the digits promised."""
    return abs(mp.mpf(x) - mp.mpf(y)) / max(1, abs(mp.mpf(y)))


def excess_of(trace: Any) -> Any:
    return (abs(trace) - 2) / 4


def constant_excess(level: float, period: Any) -> Any:
    """Return X of u'' = level u, to 150 digits."""
    turn = mp.sqrt(abs(mp.mpf(level))) * period / 2
    # cos(2 turn) of either sign: the excess is that of the magnitude
    return mp.sinh(turn) ** 2 if level > 0 else -min(mp.sin(turn) ** 2, mp.cos(turn) ** 2)


@pytest.mark.parametrize("level", [-400.0, -7.3, -0.25000000001, -1e-300, 1e-12, 0.7, 60.0])
def test_constant_coefficient(level: float) -> None:
    for equation in (Mathieu(0.0, level), Meissner(0.0, level), Hill(level, period=3.0, cosines=(0.0,))):
        period = mp.mpf(3) if isinstance(equation, Hill) else 2 * mp.pi
        assert relative(discriminant_excess(equation).excess, constant_excess(level, period)) < 1e-50
        assert reference(equation).status == ("unstable" if level > 0 else "stable")


def test_constant_coefficient_on_a_boundary() -> None:
    assert reference(Mathieu(0.0, -0.25)).status == "stable"  # every solution has period 4 pi
    assert reference(Mathieu(0.0, -4.0)).status == "stable"
    rest = reference(Mathieu(0.0, 0.0))  # A = tau
    assert (rest.status, rest.growth_rate) == ("unstable", 0.0)
    assert reference(Mathieu(0.0, 0.0, damping=0.1)).status == "stable"  # A = 1
    assert reference(Mathieu(0.0, -1.0, damping=3.0)).status == "stable"  # no oscillation left, yet decay


@pytest.mark.parametrize("beta", [1e-6, 2.0])
def test_growth_of_a_damped_constant_coefficient(beta: float) -> None:
    growth = reference(Mathieu(0.0, beta, damping=0.5)).growth_rate
    assert growth == pytest.approx(float(mp.sqrt(mp.mpf(beta) + 0.25) - 0.5), rel=1e-15)


def half_wave_map(level: Any, damping: Any) -> Any:
    """Return the exponential of pi [[0, 1], [level, -2 c]] by scaling and squaring a Taylor series."""
    matrix = mp.matrix([[0, 1], [level, -2 * damping]]) * mp.pi / 2**12
    term = total = mp.eye(2)
    for n in range(1, 90):
        term = term * matrix / n
        total = total + term
    for _ in range(12):
        total = total * total
    return total


@given(square_waves(largest=30.0, largest_damping=0.5))
@settings(max_examples=depth(15, 3))
@example(Meissner(3.0, 3.0))
@example(Meissner(1e-30, -2.0, 0.3))
def test_square_wave_is_two_matrix_exponentials(equation: Meissner) -> None:
    alpha, beta, c = (mp.mpf(x) for x in (equation.alpha, equation.beta, equation.damping))
    matrix = half_wave_map(beta - alpha, c) * half_wave_map(beta + alpha, c)
    expected = excess_of(mp.exp(2 * mp.pi * c) * (matrix[0, 0] + matrix[1, 1]))
    found = discriminant_excess(equation)
    assert relative(found.excess, expected) < 1e-50
    assert found.error <= 1e-50 * max(1, abs(found.excess))


def runge_kutta_excess(equation: Hill | Mathieu, steps: int) -> tuple[Any, Any]:
    """Return X from classical Runge-Kutta steps, extrapolated twice, and the size of the last correction."""

    def trace(steps: int) -> Any:
        period = mp.mpf(equation.period) if isinstance(equation, Hill) else 2 * mp.pi
        step = period / steps
        hill = equation.as_hill()
        c = mp.mpf(hill.damping)

        def p(tau: Any) -> Any:
            waves = enumerate(hill.harmonics, start=1)
            return hill.mean + sum((z * mp.expj(2 * mp.pi * k * tau / period)).real for k, z in waves)

        def slope(p: Any, y: tuple[Any, Any]) -> tuple[Any, Any]:
            return y[1], p * y[0] - 2 * c * y[1]

        def ahead(y: tuple[Any, Any], k: tuple[Any, Any], h: Any) -> tuple[Any, Any]:
            return y[0] + h * k[0], y[1] + h * k[1]

        columns = [(mp.one, mp.zero), (mp.zero, mp.one)]
        for n in range(steps):
            early, middle, late = p(n * step), p((n + 0.5) * step), p((n + 1) * step)
            for i, y in enumerate(columns):
                k1 = slope(early, y)
                k2 = slope(middle, ahead(y, k1, step / 2))
                k3 = slope(middle, ahead(y, k2, step / 2))
                k4 = slope(late, ahead(y, k3, step))
                k = tuple(a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
                columns[i] = ahead(y, (k[0], k[1]), step / 6)
        return mp.exp(c * period) * (columns[0][0] + columns[1][1])

    with mp.workdps(30):
        one, two, four = trace(steps), trace(2 * steps), trace(4 * steps)
        first, second = two + (two - one) / 15, four + (four - two) / 15
        best = second + (second - first) / 31
        return excess_of(best), abs(second - first)


@pytest.mark.slow
@pytest.mark.parametrize(
    "equation",
    [
        Mathieu(2.3, -1.1, damping=0.2),
        pytest.param(
            Hill(-0.6, cosines=(0.1, 0.2), sines=(0.3, -0.1, 0.05), period=3.0, damping=0.1), marks=pytest.mark.slow
        ),
        Hill(0.2, sines=(0.0, 1.0), period=5.0),
    ],
)
def test_direct_integration_by_runge_kutta(equation: Hill | Mathieu) -> None:
    expected, correction = runge_kutta_excess(equation, 150)
    assert correction < 1e-7
    assert relative(discriminant_excess(equation).excess, expected) < correction


def assert_consistent(few: DiscriminantExcess, many: DiscriminantExcess, digits: int) -> None:
    assert few.sign == many.sign or abs(few.excess + 0.5) < few.error  # the trace is then zero
    assert relative(few.excess, many.excess) < mp.mpf(10) ** -digits
    assert abs(mp.mpf(few.excess) - mp.mpf(many.excess)) <= few.error + many.error
    assert few.error <= mp.mpf(10) ** -digits * max(1, abs(few.excess))


@pytest.mark.slow
@given(mathieus(largest_damping=0.5) | hills(largest_damping=0.5))
@settings(max_examples=depth(25, 3))
@example(Mathieu(400.0, -400.0))
@example(Mathieu(400.0, 40.0))
@example(Mathieu(50.0, -10.0))
@example(Mathieu(0.5, -0.2, damping=30.0))
def test_digits_are_correct(equation: Equation) -> None:
    assert_consistent(discriminant_excess(equation, 50), discriminant_excess(equation, 80), 50)


@given(near_boundary_points(nearest=1e-12))
@settings(max_examples=depth(10, 3))
def test_digits_near_transition_curves(point: tuple[float, float]) -> None:
    assert_consistent(discriminant_excess(Mathieu(*point), 30), discriminant_excess(Mathieu(*point), 50), 30)


@given(numbers(-60.0, 60.0), st.integers(-(2**12), 2**9), st.integers(1, 2**7))
@settings(max_examples=depth(15, 3))
def test_damping_is_a_shift_of_the_mean(alpha: float, mean: int, rate: int) -> None:
    beta, c = mean / 2**6, rate / 2**8
    shifted = beta + c * c
    assert math.frexp(shifted)[0] * 2**40 % 1 == 0.0  # exact: few bits are enough
    assume(alpha != 0.0)
    damped, free = discriminant_excess(Mathieu(alpha, beta, damping=c)), discriminant_excess(Mathieu(alpha, shifted))
    assert damped.sign == free.sign or abs(free.excess + 0.5) < free.error
    assert relative(damped.excess, free.excess) < 1e-50


@given(hills(harmonics=3), st.sampled_from(["quarter", "half", "reversed"]))
@settings(max_examples=depth(15, 3))
def test_shift_and_reversal_of_time_change_nothing(equation: Hill, change: str) -> None:
    size = max(len(equation.cosines), len(equation.sines))
    cosines = equation.cosines + (0.0,) * (size - len(equation.cosines))
    sines = equation.sines + (0.0,) * (size - len(equation.sines))
    pairs = list(zip(cosines, sines, range(1, size + 1), strict=True))
    if change == "reversed":
        moved = [(a, -b) for a, b, _ in pairs]
    else:  # a cos k x + b sin k x, with x ahead by a quarter turn as often as said
        moved = []
        for a, b, k in pairs:
            for _ in range(k * (1 if change == "quarter" else 2) % 4):
                a, b = b, -a
            moved.append((a, b))
    other = Hill(equation.mean, tuple(a for a, _ in moved), tuple(b for _, b in moved), period=equation.period)
    assert relative(discriminant_excess(other).excess, discriminant_excess(equation).excess) < 1e-50


def test_sign_of_alpha_does_not_matter() -> None:
    assert (
        relative(discriminant_excess(Mathieu(-3.7, -2.1)).excess, discriminant_excess(Mathieu(3.7, -2.1)).excess)
        < 1e-50
    )


def test_unit_of_time_does_not_matter() -> None:
    fast = Hill(-0.7 / 16, (0.5 / 16,), (0.0, 0.3 / 16), period=20.0, damping=0.125 / 4)
    slow = Hill(-0.7, (0.5,), (0.0, 0.3), period=5.0, damping=0.125)
    assert relative(discriminant_excess(fast).excess, discriminant_excess(slow).excess) < 1e-50


@given(mathieus(largest_alpha=100.0, beta=(-100.0, 20.0), largest_damping=0.5))
@settings(max_examples=depth(10, 3))
def test_verdict_follows_from_the_excess(equation: Mathieu) -> None:
    found, verdict = discriminant_excess(equation, 30), reference(equation, digits=30)
    assume(abs(found.excess) > found.error)
    growth = 0 if found.excess <= 0 else mp.asinh(mp.sqrt(mp.mpf(found.excess))) / mp.pi
    net = growth - mp.mpf(equation.damping)
    assume(not equation.damping or abs(net) > 1e-25)  # else on the boundary as far as 30 digits can tell
    assert verdict.stable is bool(net < 0 or found.excess < 0)
    assert verdict.growth_rate == pytest.approx(float(max(0, net)), rel=1e-14)
    determinant = verdict.multipliers[0] * verdict.multipliers[1]
    assert determinant.real == pytest.approx(math.exp(-4.0 * math.pi * equation.damping), rel=1e-12)


def test_golden_values(rng: np.random.Generator) -> None:
    with np.load(Path(__file__).parents[1] / "data/golden.npz") as golden:
        columns = dict(golden)
    for i in rng.choice(len(columns["alpha"]), depth(30, 12), replace=False):
        row = {name: values[i] for name, values in columns.items()}
        found = discriminant_excess(Mathieu(row["alpha"], row["beta"]), 30)
        expected = math.ldexp(row["excess_mantissa"], int(row["excess_exponent"]))
        assert float(found.excess) == pytest.approx(expected, rel=1e-15)
        assert found.sign == row["sign"]
        assert row["stable"] == (found.excess < 0) == (row["growth_rate"] == 0.0)
        assert row["discriminant"] == pytest.approx(float(found.sign * (2 + 4 * mp.mpf(found.excess))), rel=1e-15)
        assert row["log_abs_discriminant"] == pytest.approx(math.log(abs(row["discriminant"])), rel=1e-14, abs=1e-15)


def test_thin_tongue() -> None:
    verdict = reference(Mathieu(1e-8, -0.25))
    assert verdict.status == "unstable"
    assert verdict.growth_rate == pytest.approx(5.0e-9, rel=1e-6)


def test_vibration_stabilised_strip() -> None:
    assert reference(Mathieu(1.0, 0.378488)).status == "stable"
    assert reference(Mathieu(1.0, 0.378490)).status == "unstable"
    assert reference(Mathieu(1.0, 0.378488, damping=0.03)).status == "unstable"  # damping destabilises


@pytest.mark.slow
def test_tiny_parameters() -> None:
    verdict = reference(Mathieu(1e-300, -0.25))
    assert verdict.status == "unstable"
    assert verdict.growth_rate == pytest.approx(5e-301, rel=1e-12)
    assert reference(Mathieu(1e-300, -0.3), digits=10).status == "stable"
    assert reference(Mathieu(1e-300, 1e-300)).growth_rate == pytest.approx(1e-150, rel=1e-12)
    assert reference(Mathieu(1e-300, -0.25, damping=1e-3)).status == "stable"
    assert reference(Meissner(1e-300, -0.25)).growth_rate == pytest.approx(2e-300 / math.pi, rel=1e-12)


def test_undecided_when_the_digits_allowed_are_too_few() -> None:
    verdict = reference(Mathieu(1e-300, -0.25), digits=10)  # X = 2.5e-600
    assert verdict.status == "undecided"
    assert verdict.growth_rate < 1e-90
    # Both half periods turn by half turns: X is zero, and no number of digits shows it.
    assert reference(Meissner(4.0, -5.0), digits=10).status == "undecided"


@pytest.mark.slow
def test_huge_parameters() -> None:
    verdict = reference(Mathieu(1e5, 1e5), digits=20)
    assert verdict.status == "unstable"
    assert verdict.discriminant == math.inf
    assert verdict.log_abs_discriminant == pytest.approx(2.0 * math.pi * verdict.growth_rate, rel=1e-14)
    wave = reference(Meissner(1e9, 1e9))
    assert wave.log_abs_discriminant == pytest.approx(math.pi * math.sqrt(2e9), rel=1e-4)
    for equation in (Mathieu(1e9, 1e9), Mathieu(1e9, -1e9), Hill(1.0, (1.0,), period=1e300)):
        assert reference(equation).status == "undecided"
        assert reference(equation).note
        with pytest.raises(TooMuchWork):
            discriminant_excess(equation)


def test_leaves_the_precision_of_mpmath_alone() -> None:
    before = mpmath.mp.prec
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(discriminant_excess, [Mathieu(6.0, -4.0), Meissner(6.0, -4.0)] * 2, [40, 60] * 2))
    assert found[:2] == found[2:]
    assert mpmath.mp.prec == before


@pytest.mark.parametrize(("digits", "error"), [(9, ValueError), (-1, ValueError), (20.0, TypeError), ("50", TypeError)])
def test_wrong_digits(digits: Any, error: type[Exception]) -> None:
    with pytest.raises(error, match="digits"):
        reference(Mathieu(1.0, -1.0), digits=digits)


def test_wrong_equation() -> None:
    with pytest.raises(TypeError, match="equation must be an Equation"):
        reference((1.0, -1.0))  # type: ignore[arg-type]


@pytest.mark.parametrize("digits", [math.inf, math.nan, 5, 10**9, 10**400, "30", None, 30.0])
def test_digits_that_are_no_number_of_digits_are_refused(digits: Any) -> None:
    for function in (fr.methods.discriminant_excess, fr.methods.reference):
        with pytest.raises((ValueError, TypeError), match="digits must be"):
            function(fr.Mathieu(0.1, 0.2), digits=digits)
    with pytest.raises(TypeError, match="equation must be"):
        fr.methods.discriminant_excess(3)  # type: ignore[arg-type]
