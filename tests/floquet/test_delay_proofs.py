"""Proofs by the count of multipliers of systems with delays, against closed forms and estimated multipliers."""

from __future__ import annotations

import cmath
import math
from fractions import Fraction

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.equations.pieces import Varying
from floquetrod.floquet.proof import delay_counts
from tests.conftest import depth
from tests.floquet.test_delays import delayed_mathieu, hayes
from tests.floquet.test_long_delays import TABLE
from tests.inside import Doubles, Integers

SLOT = fr.Milling(x=[fr.ToolMode("922Hz", 0.011, "39.93g")], teeth=2, tangential="600MPa", radial="200MPa")


def test_systems_of_the_table_are_proved() -> None:
    for numbers in ((3.0, 2.0, -0.15, 0.1), (1.2, 0.5, 0.2, 0.05)):
        proof = fr.certify(delayed_mathieu(*numbers))
        assert proof.status == "stable"
        assert proof.statement == "every solution decays: no multiplier lies on the unit circle or outside it"
    proof = fr.certify(delayed_mathieu(3.0, 2.0, 0.95, 0.1))
    assert (proof.status, proof.statement) == ("unstable", "2 multipliers lie outside the unit circle, and none on it")


@pytest.mark.parametrize(("depth_of_cut", "status"), [("0.40862mm", "stable"), ("0.40864mm", "unstable")])
def test_the_critical_depth_of_a_slot_is_proved_to_four_digits(depth_of_cut: str, status: str) -> None:
    assert fr.certify(SLOT.system("5000rpm", depth_of_cut)).status == status


@pytest.mark.parametrize("omega", [0.3, 2.9, *(pytest.param(omega, marks=pytest.mark.slow) for omega in (1.0, 2.0))])
def test_proofs_near_hayes_boundary(omega: float) -> None:
    """At a = w cot w, b = -w / sin w a root i w crosses."""
    a, b = omega / math.tan(omega), -omega / math.sin(omega)
    assert fr.certify(hayes(a, b * (1.0 - 1e-7))).status == "stable"
    beyond = fr.certify(hayes(a, b * (1.0 + 1e-7)))
    assert beyond.status == "unstable"
    assert beyond.statement.startswith("2 multipliers")


@pytest.mark.slow
def test_roots_far_outside_take_more_digits() -> None:
    """The determinant then spans more decades than doubles have; e^(a + b w) w = 1 has 10 solutions in the circle."""
    proof = fr.certify(hayes(0.5, -30.0))
    assert (proof.status, proof.digits) == ("unstable", 30)
    assert proof.statement.startswith("10 multipliers")


@pytest.mark.parametrize("arithmetic", [Doubles(), Integers(30)])
def test_the_determinant_and_its_polynomial_hold_the_closed_form(arithmetic: delay_counts.Arithmetic) -> None:
    """Of x' = a x + b x(t - 1): f(w) = 1 - w exp(a + b w); of delays 2 and 1/2 periods that of what they read."""
    a, b = -0.4, 1.1
    problem = delay_counts._problem(arithmetic, hayes(a, b))
    count, left_out = delay_counts._points(problem, arithmetic.digits)
    values = arithmetic.zeros((count // 2 + 1,), real=False)
    for j in range(count // 2 + 1):
        values[j] = delay_counts._value(arithmetic, problem, Fraction(j, count))
        w = cmath.exp(2j * math.pi * j / count)
        assert abs(values[j].centre() - (1.0 - w * cmath.exp(a + b * w))) <= values[j].offset() + 1e-14
    series = delay_counts._polynomial(arithmetic, values, count)
    exact = [1.0] + [-math.exp(a) * b**k / math.factorial(k) for k in range(count - 1)]
    assert np.all(np.abs(series.centre() - exact) <= series.offset() + left_out + 1e-16)
    assert 0.0 < left_out < 1e-12


def test_what_is_left_out_is_bounded() -> None:
    """The determinant along larger circles is below the bound that decides how much is left out."""
    a, b = -0.4, 1.1
    problem = delay_counts._problem(Doubles(), hayes(a, b))
    for radius in (1.5, 4.0, 10.0):
        largest = max(abs(1.0 - w * cmath.exp(a + b * w)) for w in radius * np.exp(2j * np.pi * np.arange(64) / 64))
        bound = problem.states * np.logaddexp(0.0, math.log(radius) + delay_counts._growth(problem, radius))
        assert math.log(largest) <= bound < math.log(largest) + 2.0


@pytest.mark.slow
@pytest.mark.parametrize(("period", "delay"), [(1.0, 1.0), (0.5, 1.0), (2.0, 1.0), (4.0, 1.0), (1.0, 1.5)])
def test_delays_of_parts_and_of_several_periods(period: float, delay: float) -> None:
    """Of x' = b x(t - tau), whatever its period is said to be, a root i w crosses at b tau = -pi / 2."""
    for push, status in ((-1e-3, "stable"), (1e-3, "unstable")):
        b = -math.pi / 2.0 / delay * (1.0 + push)
        wavy = fr.DelaySystem.first_order([[0.0]], [[[1e-200]]], period=period, delayed=[(delay, [[b]])])
        assert fr.certify(wavy).status == status


@pytest.mark.slow
def test_jumps_slopes_and_harmonics_against_estimated_multipliers() -> None:
    here = Varying(start=[[2.0, 0.1], [0.1, 3.0]], slope=[[0.8, 0.0], [0.0, -0.5]], cosines=[[[0.5, 0.2], [0.2, 0.3]]])
    there = Varying(start=[[0.2, 0.3], [-0.4, 0.1]], slope=[[0.3, 0.0], [0.1, 0.0]])
    counted = set()
    for delay in (0.5, 1.0, 2.0):
        for size in (0.5, 6.0):
            back = Varying(start=size * there.start, slope=size * there.slope)
            system = fr.DelaySystem.from_pieces(
                [(0.25, here), (0.75, [[2.5, 0.0], [0.0, 2.0]])],
                damping=[[0.4, 0.0], [0.0, 0.3]],
                mass=[[1.0, 0.2], [0.2, 1.5]],
                delayed=[(delay, [(0.5, back), (0.5, [[0.1, 0.0], [0.0, 0.0]])])],
            )
            proof, found = fr.certify(system), fr.stability(system)
            assert proof.status == found.status
            count = sum(abs(mu) > 1.0 for mu in found.multipliers)
            assert not count or proof.statement.startswith(f"{count} multiplier")
            counted.add(count)
    assert len(counted) > 1


def test_without_delays_the_count_is_that_of_the_system() -> None:
    for beta in (0.2, 0.6):
        plain = fr.HillSystem([[1.0, 0.0], [0.0, 2.0]], [[[beta, 0.1], [0.1, 0.0]]], damping=0.1 * np.eye(2))
        same = fr.DelaySystem(plain.stiffness, plain.cosines, damping=plain.damping)
        assert fr.certify(same).status == fr.certify(plain).status != "undecided"


def test_errors_of_coefficients_leave_undecided_what_they_may_change() -> None:
    def near(error: float) -> fr.results.Proof:
        return fr.certify(
            fr.DelaySystem.first_order(
                [[0.0]], delayed=[(1.0, [[-0.999 * math.pi / 2.0]])], period=1.0, coefficient_error=error
            )
        )

    assert near(0.0).status == near(1e-7).status == "stable"
    assert near(1e-2).status == "undecided"


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (fr.DelaySystem([[1.0]], [[[2.0]]], delayed=[(1.0, [[1.0]])]), "not implemented for incommensurate delays"),
        (fr.DelaySystem([[1.0]], delayed=[(1.0, [[1.0]]), (math.pi, [[1.0]])]), "incommensurate delays"),
        (fr.DelaySystem([[1.0]], [[[2.0]]], period=1.0, delayed=[(100.0, [[1.0]]), (7.0, [[1.0]])]), "at most 32"),
        (fr.DelaySystem([[1.0]], [[[2.0]]], period=1.0, delayed=[(2000.0, [[1.0]])]), "more than 1000 periods"),
        (fr.DelaySystem(np.eye(13), delayed=[(1.0, np.eye(13))]), "more than 24 states"),
        (hayes(800.0, 1e4), "more than 512 points"),
        (hayes(0.0, 0.0), "cannot be distinguished from one on the unit circle"),
    ],
)
def test_what_is_not_proved_is_said(system: fr.DelaySystem, words: str) -> None:
    proof = fr.certify(system)
    assert proof.status == "undecided"
    assert words in proof.statement


@pytest.mark.slow
def test_proofs_never_contradict_verdicts_and_count_what_they_find() -> None:
    rng, found = np.random.default_rng(9), {"stable": 0, "unstable": 0, "undecided": 0}
    for _ in range(150):
        system = drawn(rng)
        proof, verdict = fr.certify(system), fr.stability(system)
        found[proof.status] += 1
        if proof.status != "undecided":
            assert verdict.status in (proof.status, "undecided"), system
        if proof.status == "unstable":
            count = int(proof.statement.split()[0])
            sizes = np.abs(verdict.multipliers)
            assert (sizes > 1.0).sum() == min(count, len(sizes)), system
    assert min(found["stable"], found["unstable"]) > 4 * found["undecided"], found


@pytest.mark.parametrize(
    "numbers", [pytest.param(numbers, marks=[pytest.mark.slow] * (k > 0)) for k, numbers in enumerate(TABLE)]
)
def test_long_delays_of_the_table_are_counted(numbers: tuple[float, float, float, float]) -> None:
    p, q, c, b = numbers
    for periods, (outside, _) in TABLE[numbers].items():
        delay = periods * Fraction(2.0 * math.pi)
        proof = fr.certify(fr.DelaySystem([[p]], [[[q]]], damping=[[c]], delayed=[(delay, [[b]])]))
        assert proof.status == ("unstable" if outside else "stable")
        assert not outside or proof.statement.startswith(f"{outside} multipliers")


def test_coefficients_of_powers_hold_the_closed_form() -> None:
    """Of x' = a x + b x(t - 3 T): det(I - w Phi(w^3)) = 1 - w exp(a + b w^3); of matrices det(I - w M)."""
    a, b = -0.4, 1.1
    system = fr.DelaySystem.first_order([[a]], [[[1e-200]]], period=1.0, delayed=[(3.0, [[b]])])
    problem = delay_counts._problem(Doubles(), system)
    assert problem.common == 3
    u = cmath.exp(0.25j * math.pi)
    value = delay_counts._map(Doubles(), problem, Fraction(1, 8))[0, 0]
    assert abs(value.centre() - cmath.exp(a + b * u)) <= value.offset() + 1e-15
    matrix = np.random.default_rng(2).normal(size=(4, 4)).astype(complex)
    for arithmetic in (Doubles(), Integers(30)):
        found = delay_counts._by_powers(arithmetic, arithmetic.exact(matrix))
        assert np.all(np.abs(found.centre() - np.poly(matrix)[1:]) <= found.offset() + 1e-13)


def long_and_drawn(rng: np.random.Generator) -> fr.DelaySystem:
    """Return a random system of one or two equations, its one or two delays multiples of up to 150 periods."""
    n, common, period = int(rng.integers(1, 3)), int(rng.integers(2, 60)), float(rng.integers(2, 24)) / 8.0
    delays = [common * period] + ([2 * common * period] if rng.random() < 0.4 else [])
    size = 10.0 ** rng.uniform(-1.5, 0.0)
    terms = [(delay, size * rng.normal(size=(n, n)), [0.5 * size * rng.normal(size=(n, n))]) for delay in delays]
    waves = [0.3 * rng.normal(size=(n, n))]
    if rng.random() < 0.5:
        mean = -rng.uniform(0.3, 1.0) * np.eye(n)
        return fr.DelaySystem.first_order(mean, waves, period=period, delayed=terms)
    damping = rng.uniform(0.1, 0.5) * np.eye(n)
    return fr.DelaySystem(np.diag(rng.uniform(0.5, 4.0, n)), waves, damping=damping, period=period, delayed=terms)


def check_long(count: int, seed: int) -> dict[str, int]:
    """Compare counts of drawn systems with their verdicts; return how many have which proof."""
    rng, statuses = np.random.default_rng(seed), {"stable": 0, "unstable": 0, "undecided": 0}
    for number in range(count):
        system = long_and_drawn(rng)
        proof, verdict = fr.certify(system), fr.stability(system, "winding")
        statuses[proof.status] += 1
        if proof.status != "undecided":
            assert verdict.status in (proof.status, "undecided"), (number, system)
        if proof.status == "unstable" and verdict.status == "unstable":
            sure = np.abs(verdict.multipliers) - np.array(verdict.multiplier_errors) > 1.0
            assert sure.sum() <= int(proof.statement.split()[0]), (number, system)
            if not (np.abs(np.abs(verdict.multipliers) - 1.0) <= verdict.multiplier_errors).any():
                assert sure.sum() == int(proof.statement.split()[0]), (number, system)
    return statuses


@pytest.mark.slow
def test_long_delays_drawn_are_counted_as_they_are_found() -> None:
    statuses = check_long(depth(8, 5), 3)
    assert statuses["undecided"] <= 2


@pytest.mark.slow
def test_many_long_delays_drawn() -> None:
    count = depth(40, 20)
    statuses = check_long(count, 4)
    assert min(statuses["stable"], statuses["unstable"]) > statuses["undecided"], statuses


def drawn(rng: np.random.Generator) -> fr.DelaySystem:
    """Return a random system of up to three equations, with delays that are commensurate with its period."""
    n, size, period = int(rng.integers(1, 4)), 10.0 ** rng.uniform(-1.5, 0.5), float(rng.integers(2, 40)) / 8.0

    def matrix() -> np.ndarray:
        return size * rng.normal(size=(n, n))

    delay = period * float(rng.choice([0.5, 1.0, 1.0, 1.5, 2.0]))
    waves = [0.5 * rng.normal(size=(n, n))] * int(rng.integers(0, 3))
    delayed = [(delay, matrix(), [matrix()] * int(rng.integers(0, 2)))]
    if rng.random() < 0.3:
        delayed.append((period, matrix()))
    kind = rng.random()
    if kind < 0.4:
        root = rng.normal(size=(n, n))
        return fr.DelaySystem(
            np.diag(rng.uniform(-0.3, 4.0, n)),
            waves,
            mass=root @ root.T + np.eye(n),
            damping=rng.uniform(0.0, 1.0) * np.eye(n),
            period=period,
            delayed=delayed,
        )
    if kind < 0.7:
        return fr.DelaySystem.first_order(rng.normal(size=(n, n)) - np.eye(n), waves, period=period, delayed=delayed)

    def varying() -> Varying:
        slope = 0.3 * rng.normal(size=(n, n)) if rng.random() < 0.5 else None
        return Varying(start=rng.normal(size=(n, n)) + 2.0 * np.eye(n), slope=slope, cosines=waves)

    first = period / 4.0
    return fr.DelaySystem.from_pieces(
        [(first, varying()), (period - first, varying())],
        damping=0.5 * np.eye(n),
        delayed=[(delay, [(period / 2.0, matrix()), (period / 2.0, Varying(start=matrix(), slope=0.3 * matrix()))])],
    )
