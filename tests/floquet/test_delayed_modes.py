"""Floquet solutions of systems with delays: solved again from their own histories, and known exponentials."""

from __future__ import annotations

import cmath
import math
import pickle
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import depth
from tests.floquet.test_delays import delayed_mathieu, hayes
from tests.floquet.test_long_delays import drawn

TURN = 2.0 * math.pi


def missed_by_steps(system: fr.DelaySystem, mode: Any) -> float:
    """Solve on from the history of a mode; return the largest difference as part of the largest value.

    Less the solver's own error, which counts bends that a history in pieces has and the solver does not know of.
    """
    span, missed, size, error = system.period, 0.0, 0.0, 0.0
    grid = np.linspace(0.0, span, 23)
    for part in (np.real, np.imag):

        def history(t: float, part: Any = part) -> Any:
            return part(mode(t))

        initial = (history, part(mode(0.0, 1))) if system.is_second_order else history
        solution = fr.solve(system, initial, (0.0, span))
        missed = max(missed, float(np.abs(solution(grid) - part(mode(grid))).max()))
        size, error = max(size, float(np.abs(mode(grid)).max())), max(error, solution.error)
    return missed / size - 10.0 * error


def start(mode: Any) -> Any:
    """Return the state at the beginning."""
    return np.concatenate([mode(0.0), mode(0.0, 1)]) if mode.equation.is_second_order else mode(0.0)


SYSTEMS = {
    "one period": delayed_mathieu(3.0, 2.0, -0.15, 0.1),
    "ten periods": fr.DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], delayed=[(10.0 * TURN, [[0.2]])]),
    "e periods": fr.DelaySystem([[1.2]], [[[0.5]]], damping=[[0.05]], delayed=[(math.e * TURN, [[-0.2]])]),
    "jumps": fr.DelaySystem.from_pieces(
        [(0.5, [[9.3]]), (0.5, [[7.0]])],
        damping=[[0.2]],
        delayed=[(1.0, [(0.5, [[0.3]]), (0.5, [[0.0]])]), (0.3, [(0.25, [[0.0]]), (0.75, [[0.4]])])],
    ),
    "constant": hayes(0.5, -1.0),
    "constant, two": fr.DelaySystem(
        [[2.0, 0.3], [0.1, 3.0]], damping=0.2 * np.eye(2), delayed=[(5.0, [[0.3, 0.0], [0.1, 0.2]])], period=1.0
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name != "one period")) for name in SYSTEMS],
)
def test_modes_are_solutions_of_their_own_histories(name: str) -> None:
    system = SYSTEMS[name]
    verdict, modes = fr.stability(system), fr.floquet_solutions(system)
    assert len(modes) == len(verdict.exponents)
    exponents = np.array(verdict.exponents)
    for mode in modes:
        assert np.abs(exponents - mode.exponent).min() <= 2.0 * max(verdict.exponent_errors)
        assert mode.error < 1e-11
        assert np.linalg.norm(start(mode)) == pytest.approx(1.0, abs=1e-12)
        time = np.array([-3.3, 0.4, 12.0])
        factor = cmath.exp(mode.exponent * mode.period)
        assert mode(time + mode.period) == pytest.approx(factor * mode(time), rel=1e-9, abs=1e-12)
    assert missed_by_steps(system, modes[0]) < 1e-11
    assert missed_by_steps(system, modes[-1]) < 1e-8


def test_a_mode_of_constant_coefficients_is_an_exponential() -> None:
    for mode in fr.floquet_solutions(SYSTEMS["constant, two"]):
        s = mode.exponent
        matrix = s * s * np.eye(2) + 0.2 * s * np.eye(2) + [[2.0, 0.3], [0.1, 3.0]]
        matrix = matrix + np.exp(-5.0 * s) * np.array([[0.3, 0.0], [0.1, 0.2]])
        assert np.abs(matrix @ mode(0.0)).max() < 1e-12
        assert mode.periodic(0.3) == pytest.approx(mode.periodic(0.0), abs=1e-12)
        assert mode(1.7, 1) == pytest.approx(s * mode(1.7), rel=1e-12)


@pytest.mark.slow
def test_equal_oscillators_have_as_many_solutions_as_one_each() -> None:
    one = SYSTEMS["ten periods"]
    two = np.eye(2)
    both = fr.DelaySystem(3.0 * two, [2.0 * two], damping=0.1 * two, delayed=[(10.0 * TURN, 0.2 * two)])
    modes = fr.floquet_solutions(both)
    assert len(modes) == 2 * len(fr.floquet_solutions(one))
    first = [mode for mode in modes if abs(mode.exponent - modes[0].exponent) < 1e-9]
    assert len(first) == 2
    assert np.linalg.svd(np.array([start(mode) for mode in first]))[1].min() > 0.9
    assert missed_by_steps(both, first[1]) < 1e-10


def test_errors_of_coefficients_are_in_the_error() -> None:
    named: dict[str, Any] = {"damping": [[0.1]], "delayed": [(10.0 * TURN, [[0.2]])]}
    vague = fr.floquet_solutions(fr.DelaySystem([[3.0]], [[[2.0]]], **named, coefficient_error=1e-8))[0]
    moved = fr.floquet_solutions(fr.DelaySystem([[3.0 + 1e-8]], [[[2.0]]], **named))[0]
    times = np.linspace(0.0, TURN, 30)
    assert np.abs(vague(times) - moved(times)).max() < vague.error < 1e-5


def test_modes_are_values() -> None:
    for name in ("one period", "constant"):
        for mode in fr.floquet_solutions(SYSTEMS[name]):
            assert pickle.loads(pickle.dumps(mode)) == mode


def test_what_has_no_modes_is_refused() -> None:
    w = 1.5
    tangent = fr.DelaySystem.first_order([[0.0, 1.0], [0.0, 0.0]], delayed=[(1.0, [[0.0, 0.0], [0.0, 0.0]])])
    with pytest.raises(ValueError, match="equation must have multipliers that can be distinguished"):
        fr.floquet_solutions(tangent)
    on_the_boundary = hayes(w / math.tan(w), -w / math.sin(w))
    assert len(fr.floquet_solutions(on_the_boundary)) == len(fr.stability(on_the_boundary).exponents)


def check_drawn(count: int, seed: int) -> int:
    """Solve on from histories of the leading modes of drawn systems; return how many have modes."""
    rng, solved = np.random.default_rng(seed), 0
    for number in range(count):
        system = drawn(rng)
        try:
            modes = fr.floquet_solutions(system)
        except ValueError:
            continue
        solved += 1
        allowed = 1e-9 + 10.0 * modes[0].error
        assert missed_by_steps(system, modes[0]) < allowed, (number, system)
    return solved


@pytest.mark.slow
def test_drawn_systems() -> None:
    assert check_drawn(8, 3) > 6


@pytest.mark.slow
def test_many_drawn_systems() -> None:
    count = depth(30, 15)
    assert check_drawn(count, 4) > 0.9 * count
