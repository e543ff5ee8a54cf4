"""Systems with delays from functions and tables: the same as from series and pieces, with errors that verdicts hold."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import floquetrod as fr

TURN = 2.0 * math.pi
CONSTANT = [[-0.2, 0.1], [0.0, -0.15]]


def wavy(mean: Any, cosine: Any, sine: Any) -> Any:
    """Return the function mean + cosine cos t + sine sin 2 t."""
    return lambda t: np.asarray(mean) + np.asarray(cosine) * math.cos(t) + np.asarray(sine) * math.sin(2.0 * t)


def drawn(rng: np.random.Generator, size: float) -> tuple[Any, Any, Any]:
    """Draw a mean, a cosine and a sine of the second harmonic."""
    mean, cosine, sine = size * rng.normal(size=(3, 2, 2))
    return mean, cosine, sine


@pytest.mark.slow
@pytest.mark.parametrize("delay", [1.7, *(pytest.param(turns * TURN, marks=pytest.mark.slow) for turns in (2.0, 6.0))])
def test_functions_and_tables_have_the_multipliers_of_the_series(delay: float) -> None:
    rng = np.random.default_rng(int(delay))
    present, back = drawn(rng, 0.2), drawn(rng, 0.15)
    present[0][:] += np.diag([1.3, 2.1])
    none = np.zeros((2, 2))
    terms = [(delay, back[0], [back[1]], [none, back[2]]), (TURN, CONSTANT)]
    t = np.arange(12) * (TURN / 12)
    named: dict[str, Any] = {"damping": 0.3 * np.eye(2)}
    series = fr.DelaySystem(present[0], [present[1]], [none, present[2]], **named, delayed=terms)
    function = fr.DelaySystem.from_function(
        wavy(*present), TURN, **named, delayed=[(delay, wavy(*back)), (TURN, CONSTANT)]
    )
    table = fr.DelaySystem.from_samples(
        t,
        [wavy(*present)(s) for s in t],
        TURN,
        **named,
        delayed=[(delay, [wavy(*back)(s) for s in t]), (TURN, sparse.csr_array(CONSTANT))],
    )
    same = fr.stability(series)
    for system in (function, table):
        assert system.delays == series.delays
        assert 0.0 < system.coefficient_error < 1e-12
        found = fr.stability(system)
        assert found.status == same.status
        assert found.multipliers[0] == pytest.approx(same.multipliers[0], abs=1e-9)


def test_first_order_with_jumps_is_that_of_the_pieces() -> None:
    def rates(t: float) -> Any:
        return [[-1.0]] if t % 2.0 < 0.5 else [[0.3]]

    def back(t: float) -> Any:
        return sparse.csr_array([[0.0 if t % 2.0 < 0.5 else -0.6]])

    function = fr.DelaySystem.first_order_from_function(rates, 2.0, [0.0, 0.5], delayed=[(9.0, back), (1.0, [[0.1]])])
    halves = [(0.5, [[0.1]]), (1.5, [[0.1]])]
    pieces = fr.DelaySystem.first_order_from_pieces(
        [(0.5, [[-1.0]]), (1.5, [[0.3]])], delayed=[(9.0, [(0.5, [[0.0]]), (1.5, [[-0.6]])]), (1.0, halves)]
    )
    one, other = fr.stability(function), fr.stability(pieces)
    assert function.coefficient_error == 0.0
    assert one.multipliers[0] == pytest.approx(other.multipliers[0], abs=1e-12)


@pytest.mark.parametrize("delay", [0.7, 40.0, 20.0 * TURN])
def test_the_error_of_a_coarse_table_is_in_the_verdict(delay: float) -> None:
    """Of each coefficient alone: the stated error is the larger one, and covers what the table misses."""
    t = np.arange(13) * (TURN / 13)

    def rough(s: float) -> Any:
        return [[0.2 / (1.6 + math.cos(s))]]

    smooth = fr.DelaySystem.from_function(lambda s: [[1.5]], TURN, damping=[[0.2]], delayed=[(delay, rough)])
    exact = fr.stability(smooth)
    coarse = fr.DelaySystem.from_samples(
        t, [[[1.5]]] * 13, TURN, damping=[[0.2]], delayed=[(delay, [rough(s) for s in t])]
    )
    fine = np.linspace(0.0, TURN, 300)
    missed = np.abs(coarse.delayed[0].coefficient.coefficient(fine)[:, 0, 0] - [rough(s)[0][0] for s in fine]).max()
    assert missed <= coarse.coefficient_error
    found = fr.stability(coarse)
    assert found.multiplier_errors[0] > 1e-5
    if found.status != "undecided":
        assert found.status == exact.status
    assert abs(found.multipliers[0] - exact.multipliers[0]) <= found.multiplier_errors[0]


def test_what_is_wrong_is_named() -> None:
    t = np.arange(8) * (TURN / 8)
    table = [[[1.0]]] * 8
    calls: list[tuple[Any, str]] = [
        (lambda: fr.DelaySystem.from_function(wavy(1.0, 0.0, 0.0), TURN), r"function.* must be a square matrix"),
        (
            lambda: fr.DelaySystem.from_samples(t, table, TURN, delayed=[(1.0, np.eye(2))]),
            r"delayed\[0\]\[1\] must be 1 x 1 as stiffness is",
        ),
        (
            lambda: fr.DelaySystem.from_samples(t, table, TURN, delayed=[(1.0, table[:7])]),
            r"delayed\[0\]\[1\]: times and values must be of the shapes",
        ),
        (
            lambda: fr.DelaySystem.first_order_from_function(lambda s: [[1.0]], TURN, delayed=[(1.0, lambda s: [[s]])]),
            r"delayed\[0\]\[1\]: function is not periodic",
        ),
        (
            lambda: fr.DelaySystem.first_order_from_function(lambda s: [[1.0]], TURN, delayed=[(0.0, [[1.0]])]),
            r"delayed\[0\]\[0\] must be greater than zero",
        ),
        (
            lambda: fr.DelaySystem.first_order_from_samples(t, 1j * np.array(table), TURN),
            "must be real in a system with delays",
        ),
    ]
    for call, message in calls:
        with pytest.raises(ValueError, match=message):
            call()
