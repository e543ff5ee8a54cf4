"""What a vibration tool takes from the friction, against a chain of masses integrated in time until it is periodic."""

import numba
import numpy as np
import pytest

import floquetrod as fr

FRICTION, SLIDING, FREQUENCY = 0.25, 0.2, 10.0  # 1, m/s, Hz
TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
IMPEDANCE = TUBING.mass_along * TUBING.wave_speed

# Of theory/mean_force: largest free speed over the sliding one, wavelengths, share of the friction that a tool takes in
# theory and in the chain in %, largest speed of the wave in theory over the sliding one.
TABLE = [
    (1.1, 3.0, 5.9, 4.1, 1.10),
    (1.1, 3.06, 5.4, 2.5, 1.09),
    (1.25, 3.0, 13.3, 14.0, 1.24),
    (1.25, 3.06, 12.0, 6.9, 1.22),
    (1.5, 3.0, 21.7, 26.7, 1.42),
    (1.5, 3.06, 19.9, 25.3, 1.38),
    (4.0, 3.0, 65.7, 66.1, 3.87),
    (4.0, 3.06, 64.8, 64.9, 3.74),
]


def shaken(free: float, wavelengths: float) -> tuple[float, float, fr.results.MeanForce]:
    """Return length in m and force of the tool in N of a level string, and what the package says of it.

    Without friction the wave would be ``free`` times as fast as the string slides.
    """
    length = wavelengths * TUBING.wave_speed / FREQUENCY
    force = free * SLIDING * IMPEDANCE * abs(np.cos(2.0 * np.pi * wavelengths))
    level, tool = fr.WellPath.straight(length=length, inclination="90deg"), fr.VibrationTool(force, f"{FREQUENCY}Hz")
    return length, force, TUBING.mean_force(level, FRICTION, tool=tool, speed=SLIDING)


@numba.njit(fastmath=True)
def mean_force_of_chain(
    n: int,
    cell: float,
    stiffness: float,
    mass: float,
    rubs: float,
    amplitude: float,
    steps: int,
    step: float,
    periods: int,
    last: int,
) -> float:
    """Return the mean compression in N at the upper end of n masses over the last periods; symplectic Euler.

    Each mass slides down at SLIDING beside its velocity here; the corner of friction is 2 mm/s wide.
    """
    place, velocity, force = np.zeros(n + 1), np.zeros(n + 1), np.empty(n)
    below = -0.5 * rubs
    for i in range(n - 1, -1, -1):
        below += rubs
        force[i] = below
    for i in range(n):
        place[i + 1] = place[i] - force[i] / stiffness * cell
    total = 0.0
    for period in range(periods):
        push = amplitude * min(1.0, period / 50)
        for k in range(steps):
            for i in range(n):
                force[i] = -stiffness * (place[i + 1] - place[i]) / cell
            if period >= periods - last:
                total += force[0] + 0.5 * rubs  # the upper end does not vibrate: half a cell of it rubs fully
            for i in range(1, n + 1):
                share = 0.5 if i == n else 1.0
                along = force[i - 1] - share * rubs * np.tanh((velocity[i] + SLIDING) / 2e-3)
                along += push * np.cos(2.0 * np.pi * k / steps) if i == n else -force[i]
                velocity[i] += step * along / (share * mass)
                place[i] += step * velocity[i]
    return total / (last * steps)


def friction_and_force(n: int, length: float, amplitude: float) -> tuple[float, float]:
    """Return the friction of the whole string and the mean force at the upper end of n masses with the tool, in N."""
    full, cell = FRICTION * TUBING.weight_per_length * length, length / n
    steps = int(np.ceil(TUBING.wave_speed / (0.45 * cell * FREQUENCY)))
    of_cells = IMPEDANCE * TUBING.wave_speed, TUBING.mass_along * cell, full / n
    return full, mean_force_of_chain(n, cell, *of_cells, amplitude, steps, 1.0 / (FREQUENCY * steps), 600, 20)


@pytest.mark.slow
@pytest.mark.parametrize(("free", "wavelengths", "theory", "chain", "speed"), TABLE)
def test_the_table_of_the_theory_is_what_a_chain_gives(
    free: float, wavelengths: float, theory: float, chain: float, speed: float
) -> None:
    length, amplitude, found = shaken(free, wavelengths)
    full, top = friction_and_force(700, length, amplitude)
    assert 100.0 * (1.0 - top / full) == pytest.approx(chain, abs=0.1)
    assert 100.0 * (1.0 - found.at_top / full) == pytest.approx(theory, abs=0.06)
    assert found.speed.max() / SLIDING == pytest.approx(speed, abs=0.006)
    assert found.gain_is_uncertain or theory < chain


@pytest.mark.slow
def test_a_tool_gains_from_faster_waves_about_what_is_computed() -> None:
    rng, drawn = np.random.default_rng(20261129), 0
    while drawn < 25:
        free, wavelengths = 1.0 + rng.exponential(1.0), rng.uniform(1.0, 4.0)
        length, amplitude, found = shaken(free, wavelengths)
        if found.is_helix.any() or not found.speed.max() > 1.3 * SLIDING:
            continue
        drawn += 1
        full, top = friction_and_force(int(150 * wavelengths), length, amplitude)
        assert 0.95 < (full - top) / (full - found.at_top) < 1.25, (free, wavelengths)


def test_a_wave_hardly_faster_than_the_string_slides_is_warned_of() -> None:
    for free, is_said in ((0.9, False), (1.1, True), (4.0, False)):
        _, _, found = shaken(free, 3.0)
        assert found.gain_is_uncertain == is_said == ("harmonics" in str(found.report()))
        assert found.sliding == SLIDING
        assert found.as_dict()["gain_is_uncertain"] == is_said
    still = TUBING.mean_force(fr.WellPath.straight(length=100.0, inclination="90deg"), FRICTION)
    assert still.sliding == 0.0
    assert not still.gain_is_uncertain


@pytest.mark.slow
def test_a_reach_warns_of_it_too() -> None:
    well, said = fr.WellPath.straight(length=3000.0, inclination="90deg"), []
    for free in (1.1, 4.0):
        tool = fr.VibrationTool(free * SLIDING * IMPEDANCE, f"{FREQUENCY}Hz")
        reach = TUBING.reach(well, FRICTION, tool=tool, speed=SLIDING)
        said.append("harmonics" in str(reach.report()))
        assert said[-1] == reach.along.gain_is_uncertain == (1.0 < reach.along.speed.max() / SLIDING <= 1.3)
    assert said == [True, False]
