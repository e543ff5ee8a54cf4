"""Errors of the coefficients of systems with delays: whatever they are within their bound, stated errors hold."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import floquetrod as fr


def hayes(value: float, delayed: float, error: float = 0.0) -> fr.DelaySystem:
    return fr.DelaySystem.first_order([[value]], delayed=[(1.0, [[delayed]])], coefficient_error=error)


@pytest.mark.parametrize("method", ["collocation", "winding"])
def test_terms_that_cancel_for_one_sign_count_for_the_other(method: str) -> None:
    exact = fr.stability(hayes(-1.0, 0.9), method).multipliers[0]
    signs = itertools.product((-1e-4, 1e-4), repeat=2)
    moved = [fr.stability(hayes(-1.0 + a, 0.9 + b), method).multipliers[0] for a, b in signs]
    stated = fr.stability(hayes(-1.0, 0.9, 1e-4), method).multiplier_errors[0]
    assert max(abs(each - exact) for each in moved) < stated < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_drawn_systems(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, second, size = 1 + seed % 3, seed % 2 == 0, 10.0 ** rng.uniform(-7.0, -3.0)
    mean, wave, past = (scale * rng.normal(size=(n, n)) for scale in (0.4, 0.3, 0.3))

    def system(error: float, change: Any = 0.0, late: Any = 0.0) -> fr.DelaySystem:
        named: dict[str, Any] = {"period": 2.0, "delayed": [(1.7, past + late)], "coefficient_error": error}
        if second:
            return fr.DelaySystem(1.5 * np.eye(n) + mean + change, [wave], damping=0.3 * np.eye(n), **named)
        return fr.DelaySystem.first_order(mean - np.eye(n) + change, [wave], **named)

    exact, stated = fr.stability(system(0.0)).multipliers[0], fr.stability(system(size)).multiplier_errors[0]
    for _ in range(4):
        changes = (size * rng.choice([-1.0, 1.0], size=(n, n)) for _ in range(2))
        moved = np.array(fr.stability(system(0.0, *changes)).multipliers)
        assert np.abs(moved - exact).min() < stated


@pytest.mark.slow
def test_errors_of_five_equations_hold_for_the_worst_signs() -> None:
    rng = np.random.default_rng(11)
    n, size = int(rng.integers(5, 8)), 1e-6
    mean, wave, past = (scale * rng.normal(size=(n, n)) for scale in (0.4, 0.3, 0.3))

    def found(error: float, change: Any = 0.0) -> Any:
        named: dict[str, Any] = {"period": 2.0, "delayed": [(1.7, past)], "coefficient_error": error}
        return fr.stability(fr.DelaySystem.first_order(mean - np.eye(n) + change, [wave], **named), "collocation")

    exact, stated = found(0.0).multipliers[0], found(size).multiplier_errors[0]
    slopes = np.zeros((n, n), dtype=complex)
    for place in np.ndindex(n, n):
        change = np.zeros((n, n))
        change[place] = size
        off = np.array(found(0.0, change).multipliers) - exact
        slopes[place] = off[np.abs(off).argmin()]
    for phase in np.exp(1j * np.linspace(0.0, np.pi, 8, endpoint=False)):
        worst = found(0.0, size * np.sign((slopes * phase).real))
        assert np.abs(np.array(worst.multipliers) - exact).min() < stated


def test_charts_count_them() -> None:
    """The boundary is at b = 1: nothing is decided within the errors of both terms, in charts as in single verdicts."""
    axes = {"b": np.array([0.9, 0.995]), "c": np.array([0.0, 1e-9])}
    chart = fr.chart(lambda b, c: hayes(-1.0 + c, b, 1e-2), axes)
    assert chart.undecided == 2
    assert chart.stable.tolist() == [[True, False]] * 2
    assert [fr.stability(hayes(-1.0, b, 1e-2)).status for b in (0.9, 0.995)] == ["stable", "undecided"]
