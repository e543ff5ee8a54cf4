"""What friction takes from a wave across a string that slides along."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.inside import damping_across, least_speed

SLIDING = 0.05


def damping(pressed: float, shaking: float, across: float) -> float:
    """Return the decay rate of one wave."""
    return float(damping_across(np.array([pressed]), SLIDING, np.array([shaking]), np.array([across]))[0])


@pytest.mark.parametrize(("shaking", "across"), [(0.0, 0.01), (0.03, 0.02), (0.15, 0.05), (0.15, 1.0), (0.5, 0.005)])
def test_it_is_the_decay_of_a_mass_that_slides(shaking: float, across: float) -> None:
    """A mass on a spring across, Coulomb's friction against its whole velocity, stepped through ten seconds."""
    natural, forced, step = 61.0, 113.0 * math.sqrt(2.0) / 1.4, 2.5e-4
    pressed = 5e-3 / damping(1.0, shaking, across)  # so that a twentieth is lost
    place, speed = 0.0, across
    cosine, sine = math.cos(natural * step), math.sin(natural * step)
    for along in (SLIDING + shaking * np.cos(forced * step * np.arange(40_000))).tolist():
        place, speed = place * cosine + speed / natural * sine, speed * cosine - natural * place * sine
        speed -= step * pressed * speed / math.hypot(along, speed)
    left = math.hypot(speed, natural * place) / across
    assert -math.log(left) / (40_000 * step) == pytest.approx(5e-3, rel=0.04)


def test_without_vibration_it_is_viscous_at_first_and_constant_at_last() -> None:
    assert damping(3.0, 0.0, 1e-9) == pytest.approx(3.0 / (2.0 * SLIDING), rel=1e-12)
    assert damping(3.0, 0.0, 1e3) == pytest.approx(2.0 * 3.0 / (math.pi * 1e3), rel=1e-6)
    assert damping(3.0, 0.03, 0.0) == pytest.approx(3.0 / (2.0 * math.hypot(0.04, 0.0)), rel=1e-12)
    assert math.isinf(damping(3.0, 0.1, 0.0))  # the string stands twice in a period
    assert damping(0.0, 0.1, 0.0) == 0.0


def test_from_the_least_speed_on_waves_grow() -> None:
    rate, pressed, shaking = (
        np.array([0.5, 2.0, 50.0, 0.0]),
        np.array([0.8, 0.8, 1.0, 1.0]),
        np.array([0.2, 0.2, 0.0, 0.2]),
    )
    least = least_speed(rate, pressed, SLIDING, shaking)
    assert math.isinf(least[3])
    assert least[2] == 0.0  # less than friction takes of the slowest
    for factor, grows in ((0.999, False), (1.001, True)):
        lost = damping_across(pressed[:2], SLIDING, shaking[:2], factor * least[:2])
        assert ((rate[:2] > lost) == grows).all()


@pytest.mark.parametrize("seed", range(6))
def test_of_two_frequencies_it_is_the_mean_over_a_long_time(seed: int) -> None:
    """Of 1 / hypot, where the velocity along and that across are about as large, and either frequency first."""
    rng = np.random.default_rng([84, seed])
    one, other, across = 10.0 ** rng.uniform(-2.0, 0.0, (3, 1))
    time = 0.6180339887 * np.arange(400_000)
    along = SLIDING + one * np.cos(time) + other * np.cos(math.sqrt(2.0) * time + 1.0)
    expected = 0.5 * np.mean(1.0 / np.hypot(along, 0.25 * math.pi * across))
    found = damping_across(np.ones(1), SLIDING, one, across, other)
    assert found == pytest.approx(expected, rel=2e-3)
    assert found == damping_across(np.ones(1), SLIDING, other, across, one)
    alone = damping_across(np.ones(1), SLIDING, one, across)
    assert damping_across(np.ones(1), SLIDING, one, across, np.zeros(1)) == pytest.approx(alone, rel=1e-9)
    rate = 0.7 * found
    least = least_speed(rate, np.ones(1), SLIDING, one, other)
    assert damping_across(np.ones(1), SLIDING, one, least, other) == pytest.approx(rate, rel=1e-9)
