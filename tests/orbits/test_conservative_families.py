"""Families of orbits of conservative systems, followed over their energy: motion is pulled onto a level of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

import floquetrod as fr

PULL = 0.5


def duffing(t: Any, x: Any, energy: float) -> Any:
    """Return u'' + u + u^3 = 0, pulled at a rate onto a level of its energy."""
    u, v = x
    force = u + u**3
    excess = 0.5 * v**2 + 0.5 * u**2 + 0.25 * u**4 - energy
    pull = PULL * excess / (force**2 + v**2)
    return v - pull * force, -force - pull * v


def henon_heiles(t: Any, x: Any, energy: float) -> Any:
    """Return the equations of H = (|p|^2 + |q|^2) / 2 + q_0^2 q_1 - q_1^3 / 3, pulled likewise."""
    q, r, p, s = x
    by_q, by_r = q + 2.0 * q * r, r + q**2 - r**2
    excess = 0.5 * (p**2 + s**2 + q**2 + r**2) + q**2 * r - r**3 / 3.0 - energy
    pull = PULL * excess / (by_q**2 + by_r**2 + p**2 + s**2)
    return p - pull * by_q, s - pull * by_r, -by_q - pull * p, -by_r - pull * s


def test_periods_of_a_hardening_spring_over_its_energy() -> None:
    """T = 4 K(m) / sqrt(1 + a^2), m = a^2 / (2 (1 + a^2)), at the amplitude a of a^2 = sqrt(1 + 4 energy) - 1."""
    system = fr.NonlinearSystem(duffing, parameters={"energy": 0.75})
    branch = fr.follow(fr.periodic_orbit(system, [1.0, 0.0]), {"energy": (0.1, 5.0)}, longest=0.2)
    squares = np.sqrt(1.0 + 4.0 * branch.values) - 1.0
    period = 4.0 * ellipk(0.5 * squares / (1.0 + squares)) / np.sqrt(1.0 + squares)
    assert np.abs(branch.period / period - 1.0).max() < 1e-10
    assert np.abs(branch.amplitude[:, 0] ** 2 / squares - 1.0).max() < 1e-9
    # The multiplier of the pull onto the level, where the one of a conservative system would be 1 once more.
    assert (np.abs(branch.multipliers[:, 0] - np.exp(-PULL * period)) <= branch.multiplier_errors[:, 0]).all()
    assert branch.special_points == ()
    assert all("is the end of the range" in end for end in branch.ends)


@pytest.mark.slow
def test_the_pair_of_a_family_of_henon_and_heiles() -> None:
    """Along q_0 = 0 deviations across obey y'' + (1 + 2 q_1(t)) y = 0, whose multipliers are the pair."""
    system = fr.NonlinearSystem(henon_heiles, parameters={"energy": 0.05})
    orbit = fr.periodic_orbit(system, [0.0, 0.3, 0.0, 0.0], 2.0 * math.pi)
    for energy in (0.05, 0.1, 0.15):
        near = fr.periodic_orbit(system.with_parameters(energy=energy), orbit)
        times = np.linspace(0.0, near.period, 400, endpoint=False)
        assert abs(near(times)[:, 0]).max() < 1e-12
        assert near.multipliers[-1].real == pytest.approx(math.exp(-PULL * near.period), abs=1e-9)

        def across(t: Any, near: Any = near) -> Any:
            return np.array([[1.0 + 2.0 * float(near(t)[1])]])

        truth = fr.stability(fr.HillSystem.from_function(across, near.period))
        pair = sorted(near.multipliers[:2], key=lambda mu: mu.imag)
        known = sorted(truth.multipliers, key=lambda mu: mu.imag)
        assert np.abs(np.array(pair) - np.array(known)).max() < 1e-7
