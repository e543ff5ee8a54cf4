"""Proofs: the arithmetic encloses, the counts are those of dense matrices, the verdicts those of the reference."""

from __future__ import annotations

import math
import operator
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from floquetrod.equations import Equation, FrictionalMathieu, Hill, HillSystem, Mathieu, Meissner
from floquetrod.floquet.proof import certify
from floquetrod.floquet.proof.exact_equation import problem_of
from floquetrod.floquet.proof.scalar import by_trace
from floquetrod.floquet.proof.trace import enclose_trace
from floquetrod.floquet.verdict import Interval
from floquetrod.methods import discriminant_excess, reference
from tests.conftest import depth
from tests.inside import arithmetic, cosh_sinhc, pi
from tests.strategies import (
    hills,
    mathieu_points,
    mathieus,
    near_boundary_points,
    numbers,
    square_waves,
    transition_betas,
)

DIGITS = 20  # of the reference that proofs are held against; it uses up to 20 times as many

doubles = st.floats(allow_nan=False, allow_infinity=False)


def ends(interval: Any) -> tuple[Fraction, Fraction]:
    """Return the exact ends of an interval."""
    low, high = ((-1) ** sign * Fraction(int(man)) * Fraction(2) ** exp for sign, man, exp, _ in interval._mpi_)
    return low, high


def holds(interval: Any, value: Any) -> bool:
    """Return whether a number of mpmath lies in an interval."""
    low, high = (mpmath.mp.make_mpf(end) for end in interval._mpi_)
    return bool(low <= value <= high)


@given(doubles, doubles, st.sampled_from([operator.add, operator.sub, operator.mul, operator.truediv]))
@example(1.0, 3.0, operator.truediv)
@example(1.0, 1e-300, operator.sub)
@example(-1.0, 1e-300, operator.add)
def test_intervals_of_mpmath_are_rounded_outwards(x: float, y: float, operation: Any) -> None:
    assume(operation is not operator.truediv or y != 0.0)
    context = arithmetic(6)  # fewer digits than a double has: even the operands are rounded
    low, high = ends(operation(context.mpf(x), context.mpf(y)))
    assert low <= operation(Fraction(x), Fraction(y)) <= high
    context = arithmetic(15)
    low, high = ends(operation(context.mpf(x), context.mpf(y)))
    exact = operation(Fraction(x), Fraction(y))
    assert low <= exact <= high
    assert high - low <= abs(exact) / 2**51


@given(doubles, doubles, doubles, doubles, st.sampled_from([operator.mul, operator.truediv]))
def test_operations_on_wide_intervals(a: float, b: float, c: float, d: float, operation: Any) -> None:
    first, second = sorted((a, b)), sorted((c, d))
    assume(operation is operator.mul or second[0] > 0.0 or second[1] < 0.0)
    context = arithmetic(15)
    low, high = ends(operation(context.mpf(first), context.mpf(second)))
    for x in first:
        for y in second:
            assert low <= operation(Fraction(x), Fraction(y)) <= high


@given(numbers(-4000.0, 4000.0) | st.sampled_from([0.0, 1e-300, -1e-30, 1.0, -1.0, -1e9]), st.integers(8, 60))
def test_entire_functions_are_enclosed(z: float, digits: int) -> None:
    context = arithmetic(digits)
    even, odd = cosh_sinhc(context, context.mpf(z))
    with mpmath.mp.workdps(150):
        root = mpmath.sqrt(mpmath.mpc(z))
        assert holds(even, mpmath.cosh(root).real)
        assert holds(odd, mpmath.mpf(1) if z == 0.0 else (mpmath.sinh(root) / root).real)
        assert holds(pi(context), mpmath.pi())
        size = mpmath.cosh(root.real) * (1 + abs(z))
        assert even.delta.b <= context.mpf(mpmath.nstr(size * mpmath.mpf(10) ** (3 - digits), 20)).b


@given(mathieu_points(largest_alpha=50.0, beta=(-50.0, 60.0)))
def test_interval_is_counted_as_by_dense_eigenvalues(point: tuple[float, float]) -> None:
    alpha, beta = point
    assume(alpha != 0.0)
    curves = transition_betas(alpha, 40)
    assume(min(abs(beta - curve) for curve in curves) > 1e-9)
    assert certify(Mathieu(alpha, beta)).interval == Interval.from_count(sum(curve > beta for curve in curves))


@given(numbers(1e-3, 5.0), numbers(-2.0, 6.0))
def test_small_q_and_negative_a(alpha: float, beta: float) -> None:
    # The first coupling of the even chain is the larger one, which matters where few pivots are needed.
    curves = transition_betas(alpha, 20)
    assume(min(abs(beta - curve) for curve in curves) > 1e-9)
    assert certify(Mathieu(alpha, beta)).interval == Interval.from_count(sum(curve > beta for curve in curves))


@pytest.mark.parametrize(
    ("alpha", "beta"), [(1.0, 0.0), (1.0, -1.0), (2.0, -2.0), (0.5, -0.25), (1e-9, -4.0), (1.95, 3.95 / 4.0)]
)
def test_pivots_that_vanish_are_no_obstacle(alpha: float, beta: float) -> None:
    proof = certify(Mathieu(alpha, beta))
    assert proof.digits == 15
    assert proof.status == reference(Mathieu(alpha, beta), digits=DIGITS).status


def assert_agrees(equation: Equation) -> None:
    """Hold a proof against the reference, wherever the latter decides."""
    verdict = reference(equation, digits=DIGITS)
    assume(verdict.status != "undecided")
    assert certify(equation, max_digits=400).status == verdict.status


@given(mathieus())
@settings(max_examples=depth(40, 10))
def test_mathieu_agrees_with_the_reference(equation: Mathieu) -> None:
    assert_agrees(equation)


@pytest.mark.slow
def test_golden_verdicts_are_proved(rng: np.random.Generator) -> None:
    with np.load(Path(__file__).parents[1] / "data/golden.npz") as golden:
        alpha, beta, stable = (golden[name] for name in ("alpha", "beta", "stable"))
    for i in rng.choice(len(alpha), depth(300, 100), replace=False):
        assert certify(Mathieu(alpha[i], beta[i])).stable is bool(stable[i])


@given(near_boundary_points(nearest=1e-12))
@settings(max_examples=depth(40, 10))
def test_agrees_beside_transition_curves(point: tuple[float, float]) -> None:
    assert_agrees(Mathieu(*point))


@given(mathieus(largest_alpha=10.0, beta=(-10.0, 3.0), largest_damping=0.5))
@settings(max_examples=depth(15, 3))
def test_damped_mathieu_agrees_with_the_reference(equation: Mathieu) -> None:
    assert_agrees(equation)


@given(square_waves(largest_damping=0.5))
@settings(max_examples=depth(60, 15))
@example(Meissner(1e9, -1e9))
@example(Meissner(3.0, -3.0, 0.2))
def test_square_wave_agrees_with_the_reference(equation: Meissner) -> None:
    assert_agrees(equation)


@pytest.mark.slow
@given(hills(harmonics=3))
@settings(max_examples=depth(25, 6))
@example(Hill(0.0, (1.0,)))
@example(Hill(-1.0, (0.0, 1.0)))
@example(Hill(-400.0, (200.0,), (0.0, 0.0, 0.0, 200.0)))
def test_hill_agrees_with_the_reference(equation: Hill) -> None:
    assert_agrees(equation)


@given(hills(harmonics=2, largest=3.0, largest_damping=0.3))
@settings(max_examples=depth(8, 3))
@example(Hill(0.5, (0.5,), (0.3,), period=3.0, damping=0.1))
def test_damped_hill_agrees_with_the_reference(equation: Hill) -> None:
    assert_agrees(equation)


@given(mathieu_points(largest_alpha=30.0, beta=(-30.0, 5.0)))
@settings(max_examples=depth(25, 6))
def test_mathieu_as_hill_lies_in_the_same_interval(point: tuple[float, float]) -> None:
    alpha, beta = point
    assume(abs(alpha) > 1e-6)
    # Its period is the double next to 2 pi: stay clear of curves.
    assume(min(abs(beta - curve) for curve in transition_betas(alpha, 30)) > 1e-9)
    assert certify(Mathieu(alpha, beta).as_hill()).interval == certify(Mathieu(alpha, beta)).interval


@pytest.mark.parametrize(
    "equation",
    [Mathieu(2.0, -1.0, damping=0.3), Mathieu(20.0, -7.0, damping=0.1), Hill(-0.3, (1.0, 0.2), (0.4,), 4.0, 0.2)],
)
@pytest.mark.parametrize("digits", [15, 30])
def test_trace_is_enclosed(equation: Mathieu | Hill, digits: int) -> None:
    context = arithmetic(digits)
    problem = problem_of(equation)
    assert problem is not None
    trace = enclose_trace(context, problem)
    found = discriminant_excess(equation, 60)
    with mpmath.mp.workdps(60):
        assert holds(trace, found.sign * (2 + 4 * found.excess))
    assert trace.delta.b < 1e6 * context.mpf(10) ** -digits * (1 + abs(found.excess))


@pytest.mark.parametrize(
    ("equation", "status"),
    [
        (HillSystem([[-2000.0]], [[[-500.0]]], period=8.0, damping=[[0.2]]), "unstable"),
        (Mathieu(2000.0, 30000.0, 0.1), "unstable"),
        (Mathieu(2e5, -0.25, 300.0), "stable"),  # whose trace and whose bound 2 cosh(c period) are beyond doubles
    ],
)
def test_growth_beyond_the_range_of_doubles_is_proved(equation: Any, status: str) -> None:
    assert certify(equation).status == status


@given(square_waves(largest=10.0))
@settings(max_examples=depth(30, 7))
def test_enclosures_of_the_square_wave_hold_the_trace(equation: Meissner) -> None:
    proof = certify(equation)
    assume(proof.enclosures)  # undecided at the limit of digits: nothing enclosed
    found = discriminant_excess(equation, 40)
    above, below = proof.enclosures
    with mpmath.mp.workdps(700):  # X may be as small as 1e-600
        trace = found.sign * (2 + 4 * found.excess)
        assert above.low - found.error <= (trace - 2) / 4 <= above.high + found.error
        assert below.low - found.error <= (trace + 2) / 4 <= below.high + found.error


def test_thin_tongues_are_proved() -> None:
    assert certify(Mathieu(1e-8, -0.25)).interval == Interval("tongue", 1)
    assert certify(Mathieu(1e-300, -0.25)).interval == Interval("tongue", 1)
    # Tongue 2 at q = 2e-6 is 2e-12 wide: 4 - q^2/12 < a < 4 + 5 q^2/12 (DLMF 28.6).
    q = 2e-6
    places = {
        -1.0: ("stability", 1),
        -0.04: ("tongue", 2),
        0.2: ("tongue", 2),
        0.38: ("tongue", 2),
        1.0: ("stability", 2),
    }
    for place, interval in places.items():
        assert certify(Mathieu(q / 2.0, -(4.0 + place * q * q) / 4.0)).interval == Interval(*interval)  # type: ignore[arg-type]
    assert certify(Mathieu(1e-300, -1.0)).interval == Interval("tongue", 2)  # 1e-600 wide


def neighbours_across_a_boundary(alpha: float, stable: float, unstable: float) -> tuple[float, float]:
    """Return adjacent doubles with a transition curve between them."""
    while True:
        middle = 0.5 * (stable + unstable)
        if middle in (stable, unstable):
            return stable, unstable
        if certify(Mathieu(alpha, middle)).stable:
            stable = middle
        else:
            unstable = middle


def test_too_few_digits_beside_a_boundary() -> None:
    sides = neighbours_across_a_boundary(1.0, 0.378, 0.379)
    assert math.nextafter(sides[0], 1.0) == sides[1]
    assert sides[0] == pytest.approx(0.378489, abs=1e-6)
    for beta in sides:
        proof = certify(Mathieu(1.0, beta), max_digits=10)
        assert proof.status == "undecided"
        assert proof.digits == 10
        assert "10 digits" in proof.statement
        assert proof.stable is None


def test_precision_is_raised_until_it_decides() -> None:
    assert certify(Meissner(1e-300, -0.25)).status == "undecided"
    proof = certify(Meissner(1e-300, -0.25), max_digits=1000)
    assert proof.status == "unstable"
    assert 300 < proof.digits < 1000  # the trace differs from 2 by 1e-600, its factors from zero by 1e-300


@pytest.mark.parametrize(
    ("equation", "status"),
    [
        (Mathieu(0.0, -0.25), "stable"),  # M = -1
        (Mathieu(0.0, 0.0), "unstable"),  # A = tau
        (Mathieu(0.0, 0.0, damping=0.1), "stable"),  # A = 1
        (Mathieu(0.0, 1e-300), "unstable"),
        (Meissner(0.0, -1.0), "stable"),
        (Hill(0.5), "unstable"),
        (Hill(-0.5, damping=2.0), "stable"),
        (Meissner(4.0, -5.0), "stable"),  # levels -1 and -9: both halves turn by half turns
        (Meissner(-4.0, -5.0), "stable"),
        (Meissner(0.5, -0.5), "unstable"),  # levels 0 and -1: A = 1, and one that grows linearly
    ],
)
def test_exact_cases(equation: Equation, status: str) -> None:
    proof = certify(equation)
    assert (proof.status, proof.digits) == (status, 0)
    undamped = type(equation) is not Meissner or equation.alpha == 0.0
    assert "constant" in proof.statement if undamped else "half turns" in proof.statement


def test_damping_can_destabilise() -> None:
    # alpha = 1: the strip of stabilised buckling ends at beta = 0.378489.
    assert certify(Mathieu(1.0, 0.378488)).status == "stable"
    destabilised = certify(Mathieu(1.0, 0.378488, damping=0.03))
    assert destabilised.status == "unstable"
    assert destabilised.interval == Interval("tongue", 0)
    assert certify(Mathieu(1.0, 0.37, damping=0.03)).status == "stable"
    assert certify(Mathieu(0.5, -0.2, damping=0.2)).status == "unstable"
    assert certify(Mathieu(0.5, -0.2, damping=0.3)).status == "stable"


def test_both_ways_of_treating_damping_agree() -> None:
    # Where counting proves decay, the trace must prove it too.
    equation = Mathieu(1.0, -0.6, damping=0.05)
    assert certify(equation).statement.endswith("every solution decays")
    assert by_trace(arithmetic(30), problem_of(equation), None).status == certify(equation).status == "stable"


def test_huge_parameters() -> None:
    proof = certify(Mathieu(1e6, -1e6))
    assert proof.status == "stable"
    assert proof.interval is not None
    assert certify(Mathieu(1e9, 1e9)).interval == Interval("tongue", 0)
    for equation in (Hill(1e9, (1e9,)), Hill(1.0, (1.0,), period=1e300), Mathieu(1e8, 1e8, damping=0.1)):
        proof = certify(equation)
        assert proof.status == "undecided"
        assert "would take too long" in proof.statement


def test_leaves_the_precision_of_mpmath_alone() -> None:
    before = mpmath.iv.prec
    certify(Mathieu(1e-300, -0.25))
    certify(Meissner(1e-20, -0.25))
    assert mpmath.iv.prec == before


def test_repr_is_a_sentence() -> None:
    text = repr(certify(Mathieu(0.5, -0.25)))
    assert text.startswith(
        "<unstable, tongue 1: 2 boundaries of stability lie below its mean stiffness and none on it; "
    )
    assert text.endswith("above an even number of them a solution grows (15 digits)>")
    assert repr(certify(Mathieu(0.0, -0.25))).startswith("<stable: the coefficient is constant and negative")
    (first, *_) = certify(Mathieu(1.0, -0.6)).enclosures
    assert str(first).startswith("pivot closest to zero, even, period pi in [")


@pytest.mark.parametrize(("digits", "error"), [(4, ValueError), (15.0, TypeError), ("200", TypeError)])
def test_wrong_digits(digits: Any, error: type[Exception]) -> None:
    with pytest.raises(error, match="max_digits"):
        certify(Mathieu(1.0, -1.0), max_digits=digits)


def test_wrong_equation() -> None:
    with pytest.raises(TypeError, match=r"equation must be an Equation,? such as Mathieu"):
        certify("Mathieu")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"equation\(.*\) must return .* or an Equation, got FrictionalMathieu"):
        certify(FrictionalMathieu, alpha=1, beta=0, gamma=1)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("equation", "constant", "halves", "sinusoid"),
    [
        (Mathieu(0.5, -0.25), None, None, (Fraction(-1, 4), Fraction(1, 2))),
        (Mathieu(0.0, -0.25), Fraction(-1, 4), None, None),
        (Meissner(0.5, -0.25), None, (Fraction(1, 4), Fraction(-3, 4)), None),
        (Meissner(0.0, -0.25), Fraction(-1, 4), None, None),
        (Hill(-0.25, sines=(0.5,)), None, None, None),  # its period is a double, which 2 pi is not
        (Hill(-0.25, sines=(0.0,)), Fraction(-1, 4), None, None),
        (Hill(-0.25, (0.5,), (0.0, 0.0)), None, None, None),
    ],
)
def test_an_equation_becomes_one_exact_problem(equation: Equation, constant: Any, halves: Any, sinusoid: Any) -> None:
    problem = problem_of(equation)
    assert problem.equation == equation
    assert sum(piece.share for piece in problem.pieces) == 1
    assert (problem.constant, problem.halves, problem.sinusoid) == (constant, halves, sinusoid)
    assert problem.period == (Fraction(equation.period) if isinstance(equation, Hill) else None)


@pytest.mark.parametrize("offset", [Fraction(1, 10**30), Fraction(1, 7 * 10**25)])
def test_the_exact_number_is_proved_and_not_its_nearest_double(offset: Fraction) -> None:
    # Tongue 1 reaches from -1/4 - alpha / 2 to -1/4 + alpha / 2, to first order; -1/4 lies in the middle.
    beside = Fraction(-1, 4) - Fraction(51, 100) * offset
    assert float(beside) == -0.25
    proof = certify(Mathieu, alpha=offset, beta=beside)
    assert proof.status == "stable"
    assert proof.equation == Mathieu(float(offset), -0.25)
    assert dict(proof.exact)["beta"] == beside
    assert "beta = " in repr(proof)
    assert certify(Mathieu(float(offset), -0.25)).status == "unstable"
    assert certify(Mathieu, alpha=offset, beta=Fraction(-1, 4) - Fraction(49, 100) * offset).status == "unstable"


@pytest.mark.parametrize("kind", [Mathieu, Meissner])
def test_a_mean_too_small_for_a_double_keeps_its_sign(kind: type[Equation]) -> None:
    assert certify(kind, alpha=0, beta="-1e-400").status == "stable"
    assert certify(kind, alpha=0, beta="1e-400").status == "unstable"
    assert certify(kind, alpha=0, beta="0", damping="1e-400").status == "stable"


def test_exact_hill_and_square_wave() -> None:
    exact = certify(Hill, mean="-1/4", sines=("1e-20",), cosines=[0], period="6.283185307179586476925286766559005768")
    assert exact.status == "unstable"
    assert [name for name, _ in exact.exact] == ["sines[0]", "period"]
    # The nearest double to 2 pi is off by more than that tongue is wide.
    assert certify(Hill, mean="-1/4", sines=("1e-20",)).status == "stable"
    assert certify(Meissner, alpha="0.5", beta="-0.5") == certify(Meissner(0.5, -0.5))


@pytest.mark.slow
@given(mathieus(20.0, (-20.0, 5.0), 0.3) | square_waves(10.0, 0.3) | hills(2, 5.0, 0.3))
@settings(max_examples=depth(15, 3))
def test_values_and_classes_are_proved_alike(equation: Equation) -> None:
    parameters = {name: getattr(equation, name) for name in equation.__dataclass_fields__}
    assert certify(type(equation), **parameters) == certify(equation)
    assert certify(equation).exact == ()


@pytest.mark.parametrize("value", [Fraction(1, 3), Decimal("0.1"), 2**53 + 1, np.longdouble(1) / 3])
def test_equations_refuse_what_they_would_round(value: Any) -> None:
    with pytest.raises(ValueError, match=r"^alpha "):
        Mathieu(value, -0.25)
    with pytest.raises(ValueError, match=r"^mean "):
        Hill(value)
    with pytest.raises(ValueError, match=r"^cosines\[1\] "):
        Hill(-0.3, cosines=(0.5, value))
    with pytest.raises(ValueError, match=r"^damping "):
        Mathieu(0.5, -0.25, damping=value)


@pytest.mark.parametrize(
    "value", ["", "1/", "1/0", "nan", "inf", "1e999999999", "x", "9" * 20_000, None, True, 1j, math.nan, [1], 10**400]
)
def test_junk_is_no_exact_number(value: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=r"^alpha "):
        certify(Mathieu, alpha=value, beta=-0.25)


def test_parameters_follow_a_class_and_are_its_own() -> None:
    with pytest.raises(TypeError, match="alpha must follow a class"):
        certify(Mathieu(0.5, -0.25), alpha="1/3")
    with pytest.raises(TypeError, match="gamma is not a parameter of Mathieu; they are alpha, beta, damping"):
        certify(Mathieu, alpha=1, beta=0, gamma=1)
    with pytest.raises(TypeError, match="beta"):
        certify(Mathieu, alpha=1)
    with pytest.raises(ValueError, match="damping must be zero or more"):
        certify(Mathieu, alpha=1, beta=0, damping="-1e-400")
