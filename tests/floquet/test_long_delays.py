"""Delays of many periods by a winding number: public numbers, known polynomials, and collocation's multipliers."""

from __future__ import annotations

import cmath
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.multipliers import delay_series
from floquetrod.floquet.multipliers.delay_series import DelaySeries
from tests.conftest import depth

TURN = 2.0 * math.pi

TABLE = {  # stiffness, its wave, damping, delayed stiffness: {periods of delay: (number outside, largest modulus)}
    (3.0, 2.0, 0.1, 0.05): {
        10: (0, 0.910203461969),
        30: (0, 0.967978637286),
        100: (0, 0.989769002226),
        300: (0, None),
    },
    (3.0, 2.0, 0.1, 0.2): {
        10: (2, 1.015040208208),
        30: (6, 1.009190704159),
        100: (20, 1.003148769600),
        300: (58, None),
    },
    (0.9, 0.3, 0.3, 0.28): {
        10: (2, 1.002654157396),
        30: (6, 1.001031070199),
        100: (16, 1.000321528048),
        300: (48, None),
    },
}


def delayed_mathieu(p: float, q: float, c: float, b: float, periods: float) -> fr.DelaySystem:
    """X'' + c x' + (p + q cos t) x + b x(t - 2 pi periods) = 0."""
    return fr.DelaySystem([[p]], [[[q]]], damping=[[c]], delayed=[(periods * TURN, [[b]])])


def number_outside(found: Any) -> int:
    """How many multipliers lie outside the unit circle."""
    return sum(abs(mu) > 1.0 for mu in found.multipliers)


@pytest.mark.slow
@pytest.mark.parametrize("numbers", TABLE)
def test_counts_and_moduli_are_those_of_the_table(numbers: tuple[float, float, float, float]) -> None:
    for periods, (outside, largest) in TABLE[numbers].items():
        found = fr.stability(delayed_mathieu(*numbers, periods))
        assert found.method == "winding"
        assert number_outside(found) == outside
        assert found.status == ("unstable" if outside else "stable")
        assert found.error < 1e-11
        if largest is not None:
            assert abs(found.multipliers[0]) == pytest.approx(largest, abs=1e-12)


def test_moduli_are_those_of_25_digits() -> None:
    """From Taylor series with mpmath, and a secant method for det(Phi(mu^-r) - mu) = 0."""
    for numbers, periods, modulus in (
        ((3.0, 2.0, 0.1, 0.05), 30, 0.9679786372852672),
        ((3.0, 2.0, 0.1, 0.2), 10, 1.0150402082077496),
    ):
        assert abs(fr.stability(delayed_mathieu(*numbers, periods)).multipliers[0]) == pytest.approx(modulus, abs=5e-14)


@pytest.mark.slow
def test_longer_delays_take_as_many_maps() -> None:
    costs = [fr.stability(delayed_mathieu(3.0, 2.0, 0.1, 0.2, r), "winding").cost.amount for r in (20, 2000)]
    assert abs(costs[1] - costs[0]) <= 2


def test_multipliers_are_those_of_collocation() -> None:
    system = delayed_mathieu(0.9, 0.3, 0.3, 0.28, 4)
    one, other = fr.stability(system, "winding"), fr.stability(system, "collocation", above=0.3)
    gaps = [min(abs(mu - nu) for nu in other.multipliers) for mu in one.multipliers]
    assert max(gaps) < 1e-12


def polynomial(zeros: list[complex], error: float = 1e-14) -> DelaySeries:
    """K = 1 - sum_k C_k v^k = prod_i (1 - v / z_i)."""
    ones = np.ones(1, dtype=complex)
    for zero in zeros:
        ones = np.convolve(ones, [1.0, -1.0 / zero])
    return DelaySeries(np.arange(1, len(ones)), -ones[1:, None, None].real, error, 1, len(zeros))


def test_zeros_of_known_polynomials_are_counted_and_found() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        pairs = rng.uniform(0.3, 2.0, 3) * np.exp(1j * rng.uniform(0.1, 3.0, 3))
        real = rng.uniform(0.3, 2.0, 2) * [1.0, -1.0]
        every = [*pairs, *pairs.conj(), *real.astype(complex)]
        series = polynomial(every)
        inside = sum(abs(z) < 1.0 for z in every)
        count = delay_series.outside(series, 0.0)
        assert count == inside
        found = delay_series.zeros(series, 0.0, inside)
        assert found is not None
        for log, radius in zip(found.values, found.radii, strict=True):
            assert min(abs(log - cmath.log(z)) for z in every) < radius < 1e-10
        upper = [z for z in every if abs(z) < 1.0 and z.imag >= 0.0]
        assert len(found.values) == len(upper)


def test_a_zero_within_the_error_of_the_circle_is_not_counted() -> None:
    beside = 1.0 + 1e-9
    zeros = [beside * cmath.exp(0.7j), beside * cmath.exp(-0.7j), 0.5 + 0j]
    assert delay_series.outside(polynomial(zeros, 1e-12), 0.0) == 1
    assert delay_series.outside(polynomial(zeros, 1e-8), 0.0) is None


def test_double_multipliers_count_twice() -> None:
    """Of two equal oscillators that are not coupled each multiplier is double."""
    one = delayed_mathieu(3.0, 2.0, 0.1, 0.2, 10)
    two = np.eye(2)
    both = fr.DelaySystem(3.0 * two, [2.0 * two], damping=0.1 * two, delayed=[(10.0 * TURN, 0.2 * two)])
    single, double = fr.stability(one, "winding"), fr.stability(both, "winding")
    assert number_outside(double) == 2 * number_outside(single) == 4
    assert len(double.multipliers) == 2 * len(single.multipliers)
    assert abs(double.multipliers[0]) == pytest.approx(abs(single.multipliers[0]), abs=1e-11)


def test_on_the_boundary_nothing_is_guessed() -> None:
    """Hayes' curve: at a = w cot w, b = -w / sin w a root lies on the imaginary axis."""
    for w in (0.5, 1.5, 2.5):
        a, b = w / math.tan(w), -w / math.sin(w)
        for side, status in ((1.0 - 1e-9, "stable"), (1.0, "undecided"), (1.0 + 1e-9, "unstable")):
            system = fr.DelaySystem.first_order([[a]], delayed=[(1.0, [[b * side]])])
            assert fr.stability(system, "winding").status == status


def test_roots_of_constant_coefficients_solve_their_equation() -> None:
    """With delays of three and of two steps, 1,200 radians long."""
    system = fr.DelaySystem([[4.0]], damping=[[0.3]], delayed=[(600.0, [[0.4]]), (400.0, [[-0.2]])], period=7.0)
    found = fr.stability(system)
    assert found.method == "winding"
    for s, error in zip(found.exponents, found.exponent_errors, strict=True):
        far, near = 0.4 * cmath.exp(-600.0 * s), -0.2 * cmath.exp(-400.0 * s)
        value = s * s + 0.3 * s + 4.0 + far + near
        slope = 2.0 * s + 0.3 - 600.0 * far - 400.0 * near
        assert abs(value / slope) <= error + 1e-14


def drawn(rng: np.random.Generator) -> fr.DelaySystem:
    """Draw one or two equations of either order with delays of whole steps: a period, its half or its third."""
    n, period, constant = int(rng.integers(1, 3)), float(rng.uniform(0.5, 4.0)), rng.random() < 0.2
    parts = int(rng.choice([1, 1, 1, 2, 3]))
    steps = rng.integers(1, 6 * parts, int(rng.integers(1, 3)))
    delays = [period * int(p) / parts for p in steps]

    def matrix(size: float) -> Any:
        return size * rng.normal(size=(n, n))

    first = rng.random() < 0.4
    mean = -np.eye(n) if first else np.diag(rng.uniform(0.5, 6.0, n))
    named = {} if first else {"damping": rng.uniform(0.05, 0.4) * np.eye(n)}
    if not first and rng.random() < 0.3:
        named["mass"] = np.diag(rng.uniform(0.5, 2.0, n))
    if constant or rng.random() < 0.5:
        waves = [] if constant else [matrix(0.4)]
        terms = [(delay, matrix(0.4), [] if constant else [matrix(0.3)]) for delay in delays]
        made = fr.DelaySystem.first_order if first else fr.DelaySystem
        return made(mean + first * matrix(0.5), waves, period=period, delayed=terms, **named)
    cut = Fraction(period) * Fraction(float(rng.uniform(0.2, 0.8)))

    def pieces(middle: Any, size: float) -> list[tuple[Fraction, Any]]:
        return [(length, middle + matrix(size)) for length in (cut, Fraction(period) - cut)]

    terms = [(delay, pieces(np.zeros((n, n)), 0.5)) for delay in delays]
    made = fr.DelaySystem.first_order_from_pieces if first else fr.DelaySystem.from_pieces
    return made(pieces(mean, 0.4), delayed=terms, **named)


def check_against_collocation(count: int, seed: int) -> tuple[int, int]:
    """Compare multipliers of drawn systems, none left out by either; return how many are stable, and undecided."""
    rng, stable, undecided = np.random.default_rng(seed), 0, 0
    for number in range(count):
        system = drawn(rng)
        one, other = fr.stability(system, "winding"), fr.stability(system, "collocation")
        assert {one.status, other.status} != {"stable", "unstable"}, (number, system)
        stable, undecided = stable + (one.status == "stable"), undecided + (one.status == "undecided")
        if not one.exponents or not other.exponents:
            continue
        ours, theirs = np.asarray(one.multipliers), np.asarray(other.multipliers)
        errors, bounds = np.asarray(one.multiplier_errors), np.asarray(other.multiplier_errors)
        least = 1.0001 * max(np.abs(ours).min(), np.abs(theirs).min(), 0.5 ** (1.0 / max(1.0, _periods(system))))
        for values, beside in ((ours, theirs), (theirs, ours)):
            gaps = np.abs(values[:, None] - beside[None, :])
            allowed = errors[:, None] + bounds[None, :] if values is ours else bounds[:, None] + errors[None, :]
            near = (gaps <= allowed + 1e-13).any(axis=1)
            assert near[np.abs(values) > least].all(), (number, system)
        assert (np.abs(ours) > least).sum() == (np.abs(theirs) > least).sum(), (number, system)
    return stable, undecided


def _periods(system: fr.DelaySystem) -> float:
    return system.longest_delay / system.period


@pytest.mark.slow
def test_drawn_systems_have_the_multipliers_of_collocation() -> None:
    stable, undecided = check_against_collocation(10, 11)
    assert 2 < stable < 9
    assert undecided == 0


@pytest.mark.slow
def test_many_drawn_systems_have_the_multipliers_of_collocation() -> None:
    count = depth(50, 50)
    stable, undecided = check_against_collocation(count, 54)
    assert 0.2 * count < stable < 0.9 * count
    assert undecided <= 0.02 * count


def test_a_delay_that_misses_the_period_by_rounding_is_a_whole_one() -> None:
    exact = fr.DelaySystem([[1.2]], [[[0.5]]], damping=[[0.05]], period=0.3, delayed=[(Fraction(0.3) * 20, [[-0.2]])])
    rounded = fr.DelaySystem([[1.2]], [[[0.5]]], damping=[[0.05]], period=0.3, delayed=[(6.0, [[-0.2]])])
    one, other = fr.stability(exact), fr.stability(rounded)
    assert one.method == other.method == "winding"
    assert one.multipliers[0] == pytest.approx(other.multipliers[0], abs=1e-13)


def test_delays_of_no_whole_steps_have_the_multipliers_of_collocation() -> None:
    """Of e and of 2.7 periods, and an error of the coefficients moves the multipliers by no more than is said."""
    terms = [(math.e * TURN, [[-0.2]]), (2.7 * TURN, [[0.1]])]
    named: dict[str, Any] = {"damping": [[0.05]], "delayed": terms}
    system = fr.DelaySystem([[1.2]], [[[0.5]]], **named)
    one, other = fr.stability(system, "winding"), fr.stability(system, "collocation")
    least = max(0.5 ** (1.0 / math.e), min(map(abs, other.multipliers)))
    sizes = [sum(abs(mu) > 1.001 * least for mu in found.multipliers) for found in (one, other)]
    assert sizes[0] == sizes[1] > 0
    assert max(min(abs(mu - nu) for nu in other.multipliers) for mu in one.multipliers) < 1e-11
    vague = fr.stability(fr.DelaySystem([[1.2]], [[[0.5]]], **named, coefficient_error=1e-6), "winding")
    near = fr.stability(fr.DelaySystem([[1.2 + 1e-6]], [[[0.5]]], **named), "winding")
    assert abs(near.multipliers[0] - vague.multipliers[0]) < vague.multiplier_errors[0] < 1e-4


def test_parts_of_a_period_may_be_of_different_sizes() -> None:
    """Couplings of both halves differ a hundredfold, in opposite directions; a delay is one period and a half."""
    pieces = [(0.5, [[-1.0, 40.0], [0.2, -1.5]]), (0.5, [[-1.2, 0.3], [-30.0, -1.0]])]
    terms = [(1.5, [(0.5, [[0.1, 3.0], [0.0, 0.2]]), (0.5, [[0.2, 0.0], [2.0, -0.1]])])]
    system = fr.DelaySystem.first_order_from_pieces(pieces, delayed=terms)
    one, other = fr.stability(system, "winding"), fr.stability(system, "collocation")
    gaps = [min(abs(mu - nu) for nu in other.multipliers) for mu in one.multipliers]
    assert max(gaps) < 1e-9 * abs(one.multipliers[0])
    assert one.status == other.status


@pytest.mark.slow
def test_three_equations_with_three_long_delays() -> None:
    rng = np.random.default_rng(3)

    def matrix(size: float) -> Any:
        return size * rng.normal(size=(3, 3))

    mean, wave = -0.5 * np.eye(3) + matrix(0.2), [matrix(0.2)]
    terms = [(38.0, matrix(0.15), [matrix(0.05)]), (46.0, matrix(0.15)), (51.0, matrix(0.15))]
    found = fr.stability(fr.DelaySystem.first_order(mean, wave, period=8.6, delayed=terms))
    assert (found.method, found.status, len(found.multipliers)) == ("winding", "unstable", 19)
    assert abs(found.multipliers[0]) == pytest.approx(1.39967560745969, abs=1e-10)  # as by collocation


def test_charts_of_long_delays_have_the_verdicts_of_their_points() -> None:
    def family(p: float, b: float) -> fr.DelaySystem:
        return delayed_mathieu(p, 2.0, 0.1, b, 30)

    chart = fr.chart(family, over={"p": (2.0, 4.0, 3), "b": (0.02, 0.3, 3)}, workers=1)
    assert {True, False} <= set(np.ravel(chart.stable).tolist())
    for i, p in enumerate(np.linspace(2.0, 4.0, 3)):
        for j, b in enumerate(np.linspace(0.02, 0.3, 3)):
            assert bool(chart.stable[j, i]) == (fr.stability(family(p, b)).status == "stable")


@pytest.mark.parametrize(
    ("p", "q", "c", "b", "r"),
    [
        (0.40692, 1.0398, 0.24942, -0.073691, 37),
        (0.50773, 1.56457, 0.072275, -0.087683, 20),
        (0.35445, 1.2057, 0.12226, -0.0090162, 9),
    ],
)
def test_a_search_that_begins_without_zeros_goes_on(p: float, q: float, c: float, b: float, r: int) -> None:
    terms = [(r * Fraction(TURN), [[b]])]  # exactly, as proofs need it
    system = fr.DelaySystem([[p]], [[[q]]], damping=[[c]], delayed=terms)
    assert fr.stability(system, "winding").status == fr.certify(system).status


def test_what_is_not_served_is_said() -> None:
    system = fr.DelaySystem([[1.0]], [[[0.5]]], damping=[[0.1]], period=1.0, delayed=[])
    with pytest.raises(TypeError, match="system must have delays for winding"):
        fr.stability(system, "winding")
    assert "winding" in dict(fr.compare(system).left_out)
    assert fr.stability(system).method == "collocation"
    with pytest.raises(ValueError, match="above must lie between"):
        fr.stability(delayed_mathieu(3.0, 2.0, 0.1, 0.2, 10), "winding", above=2.0)
