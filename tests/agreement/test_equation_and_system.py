"""A scalar equation and the system of one that it is: the same questions, the same answers."""

from __future__ import annotations

import json
import math
import pickle

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import mathieu_b

import floquetrod as fr
from floquetrod.floquet.verdict import FloquetVerdict
from tests.conftest import depth
from tests.strategies import hills, mathieus

EQUATIONS = mathieus(largest_alpha=8.0, beta=(-12.0, 2.0), largest_damping=0.3) | hills(
    largest=4.0, largest_damping=0.3
)
SHARED = """status stable growth_rate decay_rate exponents exponent_errors multipliers multiplier_errors period error
cost note assumptions method equation system references damping_to_stabilise monodromy"""


def same_up_to_errors(one: FloquetVerdict, other: FloquetVerdict) -> None:
    """Assert that both have the same exponents, each within the errors that they state."""
    turns = 2.0 * math.pi / one.period
    for exponent, error in zip(one.exponents, one.exponent_errors, strict=True):
        gaps = []
        for found, theirs in zip(other.exponents, other.exponent_errors, strict=True):
            apart = exponent - found
            angle = math.remainder(apart.imag, turns)
            gaps.append(abs(complex(apart.real, angle)) - 2.0 * (error + theirs) - 1e-12 * (1.0 + abs(exponent)))
        assert min(gaps) <= 0.0, (exponent, one, other)


@settings(max_examples=depth(60, 8))
@given(EQUATIONS)
def test_verdicts_are_those_of_the_system(equation: fr.Mathieu | fr.Hill) -> None:
    one, other = fr.stability(equation), fr.stability(equation.as_system())
    assert {one.status, other.status} != {"stable", "unstable"}
    assume("undecided" not in (one.status, other.status))
    same_up_to_errors(one, other)
    assert abs(one.growth_rate - other.growth_rate) <= 2.0 * (
        max(one.exponent_errors) + max(other.exponent_errors)
    ) + 1e-12 * (1.0 + one.growth_rate)


@settings(max_examples=depth(30, 4))
@given(EQUATIONS)
def test_the_errors_of_exponents_cover_the_truth(equation: fr.Mathieu | fr.Hill) -> None:
    truth = fr.stability(equation, "reference", digits=20)
    for method in ("spectral", "monodromy"):
        same_up_to_errors(fr.stability(equation, method), truth)


@settings(max_examples=depth(25, 2))
@given(EQUATIONS)
def test_the_map_over_a_period_has_the_multipliers(equation: fr.Mathieu | fr.Hill) -> None:
    one, other = fr.stability(equation), fr.stability(equation.as_system())
    matrix, error = one.monodromy
    assert np.abs(matrix - other.monodromy.matrix).max() <= error + other.monodromy.error
    assert abs(np.trace(matrix) - one.discriminant) <= 2.0 * error + one.error * max(1.0, abs(one.discriminant))
    assert np.linalg.det(matrix) == pytest.approx(
        math.exp(-2.0 * equation.damping * equation.period), abs=8.0 * error * max(1.0, np.abs(matrix).max())
    )


@settings(max_examples=depth(30, 4))
@given(EQUATIONS)
def test_proofs_are_those_of_the_system(equation: fr.Mathieu | fr.Hill) -> None:
    assert {fr.certify(equation).status, fr.certify(equation.as_system()).status} != {"stable", "unstable"}


@pytest.mark.slow
@settings(max_examples=depth(12, 2), deadline=None)
@given(st.floats(0.2, 1.0), st.floats(-0.4, -0.1), st.just(0.0) | st.floats(0.01, 0.1))
def test_the_damping_that_stabilises_is_that_of_the_system(alpha: float, beta: float, damping: float) -> None:
    equation = fr.Mathieu(alpha, beta, damping)
    found = fr.stability(equation).damping_to_stabilise
    assert found == pytest.approx(fr.stability(equation.as_system()).damping_to_stabilise, rel=1e-8, abs=1e-12)
    if 0.0 < found < math.inf:
        assert fr.stability(fr.Mathieu(alpha, beta, damping + found * (1.0 + 1e-8))).status == "stable"
        assert fr.stability(fr.Mathieu(alpha, beta, damping + found * (1.0 - 1e-8))).status == "unstable"


@pytest.mark.slow
@settings(max_examples=depth(20, 3), deadline=None)
@given(EQUATIONS)
def test_floquet_solutions_are_those_of_the_system(equation: fr.Mathieu | fr.Hill) -> None:
    verdict = fr.stability(equation)
    assume(verdict.status != "undecided")
    apart = abs(verdict.exponents[0] - verdict.exponents[1]) * verdict.period
    assume(apart > 1e-3)
    assume(verdict.growth_rate * verdict.period < 30.0)
    ours, theirs = fr.floquet_solutions(equation), fr.floquet_solutions(equation.as_system())
    assert [mode.exponent for mode in ours] == pytest.approx([mode.exponent for mode in theirs], abs=1e-9)
    times = np.linspace(0.0, 2.5, 7) * verdict.period
    for one, other in zip(ours, theirs, strict=True):
        assert one.error < max(1e-9, 1e-11 / apart**3)  # of two solutions that are nearly one
        ratio = other(times[1])[0] / one(times[1])
        assert other(times)[:, 0] == pytest.approx(ratio * one(times), abs=1e-7 * np.abs(other(times)).max())


PROBLEMS = [
    fr.Mathieu(0.5, -0.25),
    fr.Meissner(0.5, -0.25),
    fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]]),
    fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], [[[0.0, 0.0], [0.3, 0.0]]]),
]


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: type(problem).__name__)
def test_verdicts_have_the_same_attributes(problem: fr.Mathieu | fr.HillSystem) -> None:
    verdict = fr.stability(problem)
    assert isinstance(verdict, FloquetVerdict)
    assert verdict.equation is verdict.system is problem
    order = 2 if isinstance(problem, fr.Mathieu | fr.Meissner) else verdict.monodromy.matrix.shape[0]
    for name in SHARED.split():
        if not (name == "damping_to_stabilise" and isinstance(problem, fr.Meissner)):
            assert getattr(verdict, name) is not None or name == "stable"
    assert len(verdict.exponents) == len(verdict.exponent_errors) == len(verdict.multiplier_errors) == order
    values = np.linalg.eigvals(verdict.monodromy.matrix)
    for mu in verdict.multipliers:
        assert np.abs(values - mu).min() < 1e-6


def test_a_method_that_gives_up_says_so_alike() -> None:
    scalar = fr.stability(fr.Mathieu(1e9, -1e9), "reference")
    system = fr.stability(fr.HillSystem(np.diag([1e18, 4.0]), [np.ones((2, 2))]), "monodromy")
    for verdict in (scalar, system):
        assert (verdict.status, verdict.exponents, verdict.exponent_errors) == ("undecided", (), ())
        assert math.isnan(verdict.growth_rate)
        assert verdict.error == math.inf
        assert pickle.loads(pickle.dumps(verdict)) == verdict
        assert hash(pickle.loads(pickle.dumps(verdict))) == hash(verdict)
        assert verdict.note


@settings(max_examples=depth(20, 2), deadline=None)
@given(st.sampled_from(PROBLEMS), st.floats(-40.0, 40.0))
def test_floquet_solutions_solve_the_equation_and_return_multiplied(problem: fr.HillSystem, time: float) -> None:
    for mode in fr.floquet_solutions(problem):
        later = mode(time + mode.period)
        assert later == pytest.approx(np.exp(mode.exponent * mode.period) * mode(time), rel=1e-9)
        assert mode.periodic(time + mode.period) == pytest.approx(mode.periodic(time), rel=1e-9, abs=1e-10)
        phase = time % mode.period
        initial = np.array([mode(0.0), mode(0.0, 1)]) if not isinstance(problem, fr.PeriodicSystem) else mode(0.0)
        if phase > 0.0:
            parts = [
                fr.solve(problem, np.ascontiguousarray(part), phase)(phase) for part in (initial.real, initial.imag)
            ]
            size = np.abs(mode(np.linspace(0.0, mode.period, 20))).max()
            assert mode(phase) == pytest.approx(parts[0] + 1j * parts[1], abs=1e-9 * size)


def test_those_of_mathieu_are_its_fourier_series() -> None:
    equation = fr.Mathieu(0.7, -0.8, 0.02)
    for mode, series in zip(fr.floquet_solutions(equation), fr.mathieu.floquet_solutions(equation), strict=True):
        times = np.linspace(-4.0, 9.0, 11)
        assert mode.exponent == pytest.approx(series.exponent, abs=1e-12)
        assert mode(times) == pytest.approx(mode(1.0) / series(1.0) * series(times), rel=1e-9)


@pytest.mark.parametrize(
    "problem",
    [
        fr.Mathieu(0.0, 0.0),
        fr.Mathieu(1.0, -0.25 * fr.mathieu.characteristic_values(1, 2.0, "a")),
        fr.HillSystem([[-36.0, 0.0], [0.0, 1.0]], cosines=[[[0.3, 0.3], [0.3, 0.3]]]),
    ],
    ids=["drift", "boundary", "decades"],
)
def test_what_has_no_solutions_to_show_is_refused(problem: fr.Mathieu | fr.HillSystem) -> None:
    with pytest.raises(ValueError, match="equation must have"):
        fr.floquet_solutions(problem)


def test_equal_oscillators_have_as_many_solutions_as_one_each() -> None:
    same = fr.floquet_solutions(fr.HillSystem(np.eye(2), [0.2 * np.eye(2)], period=3.0))
    assert len(same) == 4
    states = np.array([[*mode(0.0), *mode(0.0, 1)] for mode in same])
    assert np.linalg.cond(states) < 1e3


def test_margins_are_those_of_the_system_and_of_the_curves() -> None:
    """The tongues at alpha = 0.1 begin and end at characteristic values."""

    def system(beta: float) -> fr.HillSystem:
        return fr.Mathieu(0.1, beta).as_system()

    ours = fr.margin(fr.Mathieu, "beta", (-0.9, 0.0), samples=10, alpha=0.1, beta=-0.5)
    theirs = fr.margin(system, "beta", (-0.9, 0.0), samples=10, beta=-0.5)
    edge = -0.25 * fr.mathieu.characteristic_values(1, 0.2, "a")
    assert ours.above == pytest.approx(abs(edge + 0.5), abs=1e-9)
    assert ours == pytest.approx(theirs, abs=1e-8)
    assert ours.below == math.inf
    assert ours.searched == pytest.approx((0.4, ours.above))
    assert ours.resolution == pytest.approx(0.5 / 9.0)
    assert repr(ours) == f"Margin(below=inf, above={ours.above:.10f}, searched up to 0.4 below in steps of 0.0556)"
    assert abs(ours.above - abs(edge + 0.5)) <= ours.errors[1] < 1e-10
    assert math.isnan(ours.errors[0])
    grown = fr.margin(fr.Mathieu, "beta", (-0.5, 0.0), alpha=0.1, beta=-0.25)
    assert fr.stability(fr.Mathieu(0.1, -0.25 - grown.below * 1.0001)).status == "stable"
    assert fr.stability(fr.Mathieu(0.1, -0.25 - grown.below * 0.9999)).status == "unstable"
    assert grown.nearest == min(grown)


def trap(q: float) -> fr.HillSystem:
    """Return an ion trap without a direct voltage."""
    return fr.HillSystem(np.zeros((2, 2)), [np.diag([-2.0 * q, 2.0 * q])], period=np.pi)


def test_a_margin_states_its_steps() -> None:
    """The second region, 0.07 wide, is narrower than the steps."""
    coarse = fr.margin(trap, "q", (0.0, 9.0), samples=9, q=8.0)
    assert repr(coarse) == "Margin(below=inf, above=inf, searched up to 8 below and 1 above in steps of 1)"
    told = json.loads(fr.to_json(coarse))["result"]
    assert told == {"below": None, "above": None, "resolution": 1.0, "searched": [8.0, 1.0], "errors": [None, None]}
    assert repr(fr.results.Margin(1.0, 2.0)) == "Margin(below=1, above=2, searched without gaps)"


@pytest.mark.slow
def test_margins_of_a_trap_hold_within_their_errors() -> None:
    """Without a field, the true edge, the verdict is undecided."""
    edge = brentq(lambda q: float(mathieu_b(1, q)), 0.8, 1.0, xtol=1e-14)
    low = fr.margin(trap, "q", (0.0, 4.0), samples=9, q=0.5)
    assert abs(low.below - 0.5) <= low.errors[0] < 1e-6
    assert abs(low.above - (edge - 0.5)) <= low.errors[1] < 1e-8
    assert repr(low) == "Margin(below=0.4999999, above=0.408046334, searched in steps of 0.438)"
    fine = fr.margin(trap, "q", (7.0, 8.0), samples=21, q=8.0)
    assert fine.resolution == pytest.approx(0.05)
    assert fr.stability(trap(8.0 - fine.below - 1e-4)).status == "stable"
    assert fr.stability(trap(8.0 - fine.below + 1e-4)).status == "unstable"


def test_what_has_no_margin_is_refused() -> None:
    with pytest.raises(ValueError, match="along must be one of 'alpha', 'beta'"):
        fr.margin(fr.Mathieu, "gamma", (0.0, 1.0), alpha=0.1, beta=-0.5)
    missing = "got 'alpha' and no arguments by name; give every argument of the family by name, .* alpha=..."
    with pytest.raises(ValueError, match=missing):
        fr.margin(fr.Mathieu, "alpha", (0.0, 1.0))
    with pytest.raises(
        ValueError, match=r"along must be one of 'beta', got 'alpha'; give every argument .* alpha=\.\.\."
    ):
        fr.margin(fr.Mathieu, "alpha", (0.0, 1.0), beta=-0.5)
    with pytest.raises(ValueError, match="did you mean beta"):
        fr.margin(fr.Mathieu, "bta", (-1.0, 0.0), alpha=0.1, beta=-0.5)
    with pytest.raises(TypeError, match="along must be the name of a parameter, got 3"):
        fr.margin(fr.Mathieu, 3, (0.0, 1.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"within must hold beta = -0\.5"):
        fr.margin(fr.Mathieu, "beta", (0.0, 1.0), alpha=0.1, beta=-0.5)
    with pytest.raises(TypeError, match="equation must be an Equation"):
        fr.margin(dict, "beta", (-1.0, 1.0), beta=-0.5)
