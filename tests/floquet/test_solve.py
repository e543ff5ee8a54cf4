"""`fr.solve` against DOP853, high-precision Taylor series, Floquet theory and itself."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import floquetrod as fr
from tests.conftest import depth
from tests.seams import Tuned

HILL = fr.HillSystem(
    [[1.0, 0.1], [0.1, 2.0]],
    [[[0.3, 0.1], [0.1, 0.2]]],
    mass=[[2.0, 0.3], [0.3, 1.0]],
    damping=[[0.1, 0.0], [0.0, 0.2]],
    gyroscopic=[[0.0, 0.4], [-0.4, 0.0]],
    period=3.0,
)
FIRST = fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], cosines=[[[0.0, 0.0], [-0.2, 0.0]]], period=5.0)
CASES = [
    (fr.Mathieu(0.5, -0.25), (1.0, 0.0), (0.0, 20.0)),
    (fr.Mathieu(3.0, -20.0, 0.1), (1.0, 0.5), (3.0, 40.0)),
    (fr.Mathieu(3.0, -20.0, 0.1), (1.0, 0.5), (3.0, -6.0)),
    (fr.Hill(-1.0, cosines=(0.3,), sines=(0.0, 0.2), damping=0.05), (0.0, 1.0), (0.0, 30.0)),
    (HILL, [[1.0, 0.0], [0.0, 0.3]], (-2.0, 25.0)),
    (FIRST, (1.0, 0.0), (0.0, 60.0)),
]


def derivative(equation: Any, time: float, state: Any) -> Any:
    """Return the derivative of a state."""
    if isinstance(equation, fr.PeriodicSystem):
        return equation.coefficient(time) @ state
    if isinstance(equation, fr.HillSystem):
        n = equation.order
        force = equation.coefficient(time) @ state[:n] + (equation.damping + equation.gyroscopic) @ state[n:]
        return np.concatenate([state[n:], -np.linalg.solve(equation.mass, force)])
    return [state[1], equation.coefficient(time) * state[0] - 2.0 * equation.damping * state[1]]


@pytest.mark.parametrize(
    ("equation", "initial", "span"),
    [
        pytest.param(*case, marks=[pytest.mark.slow] * (number in (1, 2, 3, 4, 5))) for number, case in enumerate(CASES)
    ],  # and backwards
)
def test_against_dop853(equation: Any, initial: Any, span: tuple[float, float]) -> None:
    solution = fr.solve(equation, initial, span)
    times = np.linspace(*span, 41)
    other = solve_ivp(
        lambda t, x: derivative(equation, t, x), span, np.ravel(initial), "DOP853", times, rtol=1e-12, atol=1e-14
    ).y.T
    values, rates = solution(times), solution(times, derivative=1)
    if isinstance(equation, fr.PeriodicSystem):
        mine = values
        assert rates == pytest.approx(
            np.array([derivative(equation, t, x) for t, x in zip(times, values, strict=True)])
        )
    else:
        mine = np.column_stack([values, rates])
    assert np.abs(mine - other).max() < 1e-9 * np.abs(other).max()
    assert solution.error < 1e-12


def test_jumps_are_met_exactly() -> None:
    """A square wave is constant on both halves: the closed form, and no step across a jump."""
    equation = fr.Meissner(alpha=0.5, beta=-0.8)
    solution = fr.solve(equation, (1.0, 0.5), 3.0 * math.pi)
    state = np.array([1.0, 0.5])
    for half, p in enumerate((-0.3, -1.3, -0.3)):
        w = math.sqrt(-p)
        c, s = math.cos(w * math.pi), math.sin(w * math.pi)
        state = np.array([[c, s / w], [-w * s, c]]) @ state
        assert [solution((half + 1) * math.pi), solution((half + 1) * math.pi, 1)] == pytest.approx(state, abs=1e-13)
    jumps = math.pi * np.arange(4)
    assert all(np.abs(solution.time - jump).min() < 1e-14 for jump in jumps)


def precise(alpha: float, beta: float, end: float) -> float:
    """Return A(end) of Mathieu's equation from A = 1, A' = 0 with 40 digits, by short Taylor steps."""
    with mp.workdps(40):
        x, v, steps = mp.mpf(1), mp.mpf(0), 40 * math.ceil(end * math.sqrt(abs(alpha) + abs(beta) + 1))
        h = mp.mpf(end) / steps
        for k in range(steps):
            t = k * h
            s, c = mp.sin(t), mp.cos(t)
            p = [mp.mpf(beta) + alpha * s]
            p += [alpha * (c, -s, -c, s)[(j - 1) % 4] / mp.factorial(j) for j in range(1, 20)]
            a = [x, v]
            for n in range(18):
                a.append(sum(p[j] * a[n - j] for j in range(n + 1)) / ((n + 1) * (n + 2)))
            x, v = mp.polyval(a[::-1], h), mp.polyval([n * a[n] for n in range(19, 0, -1)], h)
        return float(x)


@pytest.mark.slow
@pytest.mark.parametrize(("alpha", "beta", "end"), [(0.5, -0.25, 30.0), (2.0, -5.0, 12.0), (10.0, -40.0, 6.0)])
def test_against_many_digits(alpha: float, beta: float, end: float) -> None:
    solution = fr.solve(fr.Mathieu(alpha, beta), (1.0, 0.0), end)
    assert abs(solution(end) - precise(alpha, beta, end)) < 1e-13 * np.abs(solution.states).max()


@given(
    st.floats(-5.0, 5.0),
    st.floats(-5.0, 1.0),
    st.floats(0.0, 0.3),
    st.floats(-10.0, 10.0),
    st.sampled_from([-1.0, 1.0]),
)
@settings(max_examples=depth(40, 5), deadline=None)
def test_a_period_multiplies_by_the_multipliers(
    alpha: float, beta: float, damping: float, start: float, way: float
) -> None:
    """The trace over a period, from any instant and either way, is the discriminant that `fr.stability` gives."""
    equation = fr.Mathieu(alpha, beta, damping)
    columns = []
    for initial in ((1.0, 0.0), (0.0, 1.0)):
        columns.append(fr.solve(equation, initial, (start, start + way * 2.0 * math.pi)).states[-1])
    trace = columns[0][0] + columns[1][1]
    expected = sum(z ** (1 if way > 0.0 else -1) for z in fr.mathieu.multipliers(alpha, beta, damping))
    assert trace == pytest.approx(expected.real, rel=1e-9, abs=1e-9 * np.abs(columns).max())


def test_there_and_back() -> None:
    equation = fr.Mathieu(2.0, -3.0)
    there = fr.solve(equation, (0.3, -0.2), (1.0, 17.0))
    back = fr.solve(equation, there.states[-1], (17.0, 1.0))
    assert back.states[-1] == pytest.approx([0.3, -0.2], abs=1e-11)
    times = np.linspace(1.0, 17.0, 29)
    assert back(times) == pytest.approx(there(times), abs=1e-11)


def test_shapes_and_words() -> None:
    solution = fr.solve(HILL, [[1.0, 0.0], [0.0, 0.3]], 4.0)
    assert solution(1.0).shape == (2,)
    assert solution(np.ones((3, 2))).shape == (3, 2, 2)
    assert isinstance(fr.solve(fr.Mathieu(0.5, -1.0), (1, 0), 2)(0.5), float)
    assert "HillSystem from 0 to 4" in repr(solution)
    assert solution == fr.solve(HILL, [[1.0, 0.0], [0.0, 0.3]], 4.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((fr.FrictionalMathieu(0.5, -0.2, 0.1), (1, 0), 2.0), "friction"),
        ((fr.Mathieu(0.5, -1.0), (1, 0, 0), 2.0), r"initial must be \(A, A'\) of shape \(2,\)"),
        ((HILL, (1, 0), 2.0), r"initial must be \(q, q'\) of shape \(2, 2\)"),
        ((fr.Mathieu(0.5, -1.0), (1, math.nan), 2.0), "initial"),
        ((fr.Mathieu(0.5, -1.0), (1, 0), 0.0), "span must reach"),
        ((fr.Mathieu(0.5, -1.0), (1, 0), (1.0, 2.0, 3.0)), "span must be"),
        ((fr.Mathieu(0.5, -1.0), (1, 0), "long"), "span"),
        ((fr.Mathieu(0.5, 1.0), (1, 0), 1e4), "grows beyond"),
        ((fr.HillSystem(np.ones((3, 1, 1)), [[[0.1]]]), [[1.0], [0.0]], 1.0), "one system"),
    ],
)
def test_bad_input(arguments: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        fr.solve(*arguments)


def test_too_long(tuned: Tuned) -> None:
    tuned(steps_of_a_solution=12)
    with pytest.raises(ValueError, match="span takes more than 10 steps"):
        fr.solve(fr.Mathieu(0.5, -1.0), (1.0, 0.0), 1e3)
    solution = fr.solve(fr.Mathieu(0.5, -1.0), (1.0, 0.0), 3.0)
    with pytest.raises(ValueError, match="time"):
        solution(3.1)


def exact_state(pieces: list[tuple[float, Any]], initial: Any, start: float, stop: float) -> Any:
    """Return the state of x' = A x, A constant on pieces of the period, by products of exponentials in 40 digits."""
    state, time, period = mp.matrix(initial), Fraction(start), sum(Fraction(t) for t, _ in pieces)
    while time < stop:
        end = time // period * period
        for duration, a in pieces:
            end += Fraction(duration)
            if time < min(end, Fraction(stop)):
                step = min(end, Fraction(stop)) - time
                state = mp.expm(mp.matrix(a) * (mp.mpf(step.numerator) / step.denominator)) * state
                time += step
    return state


@pytest.mark.parametrize(
    ("pieces", "start", "stop"),
    [
        ([(1000.1, 1e-6), (0.7, 1e4), (0.3, 4e4)], 0.0, 1001.1),  # 1000.1 + 0.7 rounded moves its end by much of a step
        ([(0.1, 2.0), (0.3, 5.0)], 1e6, 1e6 + 1.7),  # number times period rounded moves every jump
        ([(0.7, 1.0)], 3e5, 3e5 + 2.3),  # where no jump is, no step ends, and no rounding matters
    ],
)
def test_the_error_holds_far_from_the_beginning(pieces: list[tuple[float, float]], start: float, stop: float) -> None:
    with mp.workdps(40):
        exact = exact_state([(t, [[0, 1], [-k, 0]]) for t, k in pieces], [1.0, 0.5], start, stop)
        solution = fr.solve(fr.HillSystem.from_pieces([(t, [[k]]) for t, k in pieces]), [[1.0], [0.5]], (start, stop))
        size = np.abs(solution.states).max()
        assert max(abs(solution.states[-1][i] - exact[i]) for i in (0, 1)) <= solution.error * size
        assert solution.error < 1e-12


def test_the_error_holds_what_rounds_the_coefficient() -> None:
    """A mean between two doubles: after 602 radians the phase is off by more than the rounding of steps."""
    mean = -1 - Fraction(99, 100 * 2**53)

    class Between(fr.Hill):
        def pieces(self) -> tuple[Any, ...]:
            return (replace(super().pieces()[0], start=mean),)

    solution = fr.solve(Between(-1.0, period=100.0), (1.0, 0.0), 602.0)
    with mp.workdps(40):
        off = abs(solution.states[-1][0] - mp.cos(602 * mp.sqrt(mp.mpf(-mean.numerator) / mean.denominator)))
    assert 1e-15 < off <= solution.error < 1e-13
