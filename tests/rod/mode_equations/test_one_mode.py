"""Orbits of one mode of a rod at finite angles: what is found satisfies the equation, and is all that a scan finds."""

from __future__ import annotations

import numpy as np
import pytest

import floquetrod as fr
from tests.inside import LargeMotion, OneMode, Shapes

ROD = fr.Rod.nitinol().replace(damping_rate=1.0)


def one_mode(mode: int, mean: float, amplitude: float, frequency: float, indentation: float = 0.0) -> OneMode:
    load = fr.AxialLoad(mean * ROD.critical_force, amplitude * ROD.critical_force, frequency)
    return OneMode(LargeMotion(ROD, load, Shapes.of(ROD, load, mode).some([mode - 1]), indentation))


@pytest.mark.parametrize(
    ("load", "mode", "angle"), [((0.2, 0.2, 140.5), 7, 0.158367), ((0.6, 0.25, 124.0), 8, 0.171483)]
)
def test_orbits_of_one_mode_are_within_a_percent_of_the_shared_truth(
    load: tuple[float, float, float], mode: int, angle: float
) -> None:
    (found,) = one_mode(mode, *load).orbits(2)
    assert found.is_stable
    assert found.amplitude == pytest.approx(angle, rel=0.01)


def test_an_orbit_closes_and_is_where_motion_settles() -> None:
    equation = one_mode(7, 0.2, 0.2, 140.5, 1e-4)
    (found,) = equation.orbits(2)
    a, v, _ = equation.marched(*found.states[0][:, None], 2)
    assert a[0] == pytest.approx(found.states[0][0], abs=2e-5)
    near = 1.02 * found.states[0]
    a, v = near[:1], near[1:]
    for _ in range(15):
        a, v, _ = equation.marched(a, v, 2)
    left = np.array([a[0], v[0] / 70.0]) - found.states[0] / [1.0, 70.0]
    away = 0.02 * np.linalg.norm(found.states[0] / [1.0, 70.0])
    assert np.linalg.norm(left) < 2.0 * np.abs(found.multipliers).max() ** 15 * away < away


def test_a_stable_mode_may_carry_an_orbit_behind_an_unstable_one() -> None:
    equation = one_mode(7, 0.6, 0.25, 124.0)
    low, high = equation.orbits(2)
    assert np.abs(equation.multipliers_of_rest(2)).max() < 1.0
    assert not low.is_stable
    assert high.is_stable
    assert 0.18 < low.amplitude < 0.23


def test_the_multipliers_of_rest_are_those_of_the_linear_mode() -> None:
    equation = one_mode(7, 0.2, 0.2, 140.5)
    load = equation.motion.load
    growth = np.log(np.abs(equation.multipliers_of_rest(1)).max()) * load.frequency / (2.0 * np.pi)
    assert growth == pytest.approx(ROD.stability(load).growth_rate, rel=1e-3)


def test_modes_whose_motion_is_never_as_fast_as_the_load_cannot_resonate() -> None:
    assert one_mode(7, 0.2, 0.2, 140.5).may_resonate(2)
    assert not one_mode(12, 0.2, 0.2, 140.5).may_resonate(2)
