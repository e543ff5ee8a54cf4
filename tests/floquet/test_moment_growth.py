"""The growth of second moments of many equations, against the matrix of all their moments."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.multipliers.moment_growth import MomentGrowth
from tests.conftest import depth


def check(count: int, seed: int, most: int) -> None:
    """Compare random systems with `fr.stability` of their second moments."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        n, sources = int(rng.integers(1, most + 1)), int(rng.integers(1, 3))
        wave, skew, *matrices = rng.normal(size=(2 + sources, n, n))
        system = fr.HillSystem(
            np.diag(rng.uniform(0.3, 6.0, n)),
            [0.2 * (wave + wave.T)],
            [0.2 * wave],
            damping=rng.uniform(0.02, 0.2) * np.eye(n),
            gyroscopic=0.1 * (skew - skew.T),
            period=float(rng.uniform(1.0, 7.0)),
        )
        s = float(rng.uniform(0.0, 0.5))
        whole = fr.stability(system, noise=[(matrix, s) for matrix in matrices])
        found = MomentGrowth.of(system, matrices)(s * s)
        assert found.error < 1e-4, (number, found)
        assert found.rate == pytest.approx(whole.exponents[0].real, abs=found.error + 1e-11), number


def test_growth_is_that_of_all_moments() -> None:
    check(3, 1, 2)


@pytest.mark.slow
def test_growth_is_that_of_all_moments_of_many_systems() -> None:
    check(depth(60, 40), 2, 4)


def test_growth_without_noise_is_twice_that_of_solutions() -> None:
    system = fr.HillSystem([[1.0]], [[[0.8]]], damping=[[0.05]], period=math.pi)
    rate = fr.stability(system).exponents[0].real
    assert MomentGrowth.of(system, [np.eye(1)])(0.0).rate == pytest.approx(2.0 * rate, abs=1e-6)


def test_an_oscillator_bears_four_c_w_squared() -> None:
    growth = MomentGrowth.of(fr.HillSystem([[2.0]], damping=[[0.2]], period=1.3), [np.eye(1)])
    found = growth(0.8)
    assert abs(found.rate) <= found.error < 1e-6
    assert growth(0.9).rate > 0.0 > growth(0.7).rate


def test_two_equal_oscillators_under_one_noise() -> None:
    """Exactly equal solutions make other moments grow as fast: the answer is that of one, or none is given."""
    single = MomentGrowth.of(fr.HillSystem([[2.0]], damping=[[0.2]], period=1.3), [np.eye(1)])(0.5)
    both = MomentGrowth.of(fr.HillSystem(2.0 * np.eye(2), damping=0.2 * np.eye(2), period=1.3), [np.eye(2)])(0.5)
    assert math.isinf(both.error) or both.rate == pytest.approx(single.rate, abs=1e-8)
