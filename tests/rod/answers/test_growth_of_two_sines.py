"""How fast waves across a string grow under two vibrations: against one, a long integration and all waves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod.rod.answers.growth_along import contact_slope, growth_along
from floquetrod.rod.answers.growth_of_two_sines import UncertainGrowth, _Search, _Waves, growth_of_two_sines
from floquetrod.wells.drag import StringProperties, WellGeometry
from tests.conftest import some

TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
PIPE = StringProperties(TUBING.flexural_rigidity, TUBING.weight_per_length, TUBING.radial_clearance)
SLOW = 113.0  # rad/s
Place = tuple[WellGeometry, NDArray[np.float64]]


def drawn_places(rng: np.random.Generator, size: int) -> Place:
    """Return places of a string that lies, a third of them in a build or a turn, and the compression there."""
    sine = rng.uniform(0.2, 1.0, size)
    bends = np.where(rng.random((2, size)) < 0.3, rng.uniform([[-0.001], [0.0]], [[0.004], [0.004]], (2, size)), 0.0)
    place = WellGeometry(sine, np.sqrt(1.0 - sine**2), *bends)
    force = rng.uniform(-2e4, 0.97 * TUBING.critical_force, size)
    lies = PIPE.helix(force) < PIPE.lying(force, place)
    return WellGeometry(*(each[lies] for each in place)), force[lies]


def drawn_sizes(rng: np.random.Generator, number: int) -> NDArray[np.float64]:
    """Return amplitudes of two vibrations, weak to strong."""
    return np.asarray(rng.choice([1e3, 6e3, 2e4]) * 10.0 ** rng.uniform(-1.5, 0.0, (2, number)))


def multiplied(matrices: NDArray[np.float64]) -> float:
    """Return the logarithm of the size of a product of matrices (n, 2, 2), the first one at its right."""
    logarithm = 0.0
    while len(matrices) > 1:
        odd = matrices[-1:] if len(matrices) % 2 else matrices[:0]
        matrices = np.concatenate([matrices[1::2] @ matrices[: 2 * (len(matrices) // 2) : 2], odd])
        scales = np.abs(matrices).max(axis=(1, 2))
        matrices, logarithm = matrices / scales[:, None, None], logarithm + float(np.log(scales).sum())
    return logarithm + math.log(float(np.abs(matrices).max()))


def integrated(
    wave: float, place: Place, sizes: NDArray[np.float64], ratio: float, damping: float, *, slow: float = SLOW
) -> float:
    """Return the growth of a wave in 1/s by Runge and Kutta's method through minutes."""
    (geometry, force), square = place, wave**2
    m, r = TUBING.mass_per_length, TUBING.radial_clearance
    stiff = PIPE.rigidity * square**2 - force * square + PIPE.lying(force, geometry) / r
    tilt = contact_slope(PIPE, geometry, force) / r
    one, two = (size * (square - tilt) / m for size in sizes)
    step = 1e-3
    times = step * np.arange(0.0, 400.0 / step, 0.5)
    pull = -stiff / m + one * np.cos(slow * times) + two * np.cos(ratio * slow * times + 1.0)
    rates = np.zeros((times.size, 2, 2))
    rates[:, 0, 1], rates[:, 1, 0], rates[:, 1, 1] = SLOW, pull / SLOW, -2.0 * damping
    begin, middle, end = rates[0:-2:2], rates[1:-1:2], rates[2::2]
    second = middle @ (np.eye(2) + 0.5 * step * begin)
    third = middle @ (np.eye(2) + 0.5 * step * second)
    fourth = end @ (np.eye(2) + step * third)
    steps = np.eye(2) + step / 6.0 * (begin + 2.0 * second + 2.0 * third + fourth)
    half = len(steps) // 4
    return (multiplied(steps) - multiplied(steps[:half])) / (step * (len(steps) - half))


def grown(place: Place, sizes: NDArray[np.float64], ratio: float, damping: float) -> UncertainGrowth:
    rod = TUBING.replace(damping_rate=damping)
    return growth_of_two_sines(rod, *place, (sizes[0], sizes[1]), (SLOW, ratio * SLOW))


@pytest.mark.parametrize(("still", "damping"), [(0, 0.0), (1, 0.3)])
def test_a_second_sine_that_does_not_push_leaves_the_growth_of_one(still: int, damping: float) -> None:
    """To the error, where waves of one sine are examined closer still: there they lie on a grid."""
    rng = np.random.default_rng([80, still])
    place = drawn_places(rng, 8)
    sizes = drawn_sizes(rng, place[1].size)
    sizes[still] = 0.0
    found = grown(place, sizes, 1.617, damping)
    frequency = SLOW * (1.617 if still == 0 else 1.0)
    one = growth_along(TUBING.replace(damping_rate=damping), *place, sizes[1 - still], frequency)
    assert (found.rate >= one.rate - found.error - 1e-9).all()
    assert (found.rate <= one.rate + found.error + 3e-3 * (one.rate + damping)).all()
    assert (found.error < 0.02 * (found.rate + damping)).all()
    both = (found.rate > 0.1) & (one.rate > 0.1)
    np.testing.assert_allclose(found.half_wave[both], one.half_wave[both], rtol=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_the_growth_is_that_of_a_long_integration(seed: int) -> None:
    rng = np.random.default_rng([81, seed])
    place = drawn_places(rng, 6)
    sizes, ratio, damping = drawn_sizes(rng, place[1].size), rng.uniform(1.2, 3.0), (0.0, 0.2)[seed]
    sizes *= 8e3 / sizes.max()
    found = grown(place, sizes, ratio, damping)
    k = int(np.argmax(found.rate))
    there = WellGeometry(*(each[k : k + 1] for each in place[0])), place[1][k : k + 1]
    expected = integrated(math.pi / found.half_wave[k], there, sizes[:, k : k + 1], ratio, damping)
    assert found.rate[k] > 0.5
    assert found.rate[k] == pytest.approx(expected, abs=5e-3 + found.error[k])


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(5), 2, 1))
def test_no_other_wave_grows_faster(seed: int) -> None:
    """Of 800 wavenumbers up to a third more than the one that resonates with the faster frequency."""
    rng = np.random.default_rng([82, seed])
    place = drawn_places(rng, 12)
    count, ratio = place[1].size, float(rng.choice([1.05, 1.617, 2.41, 6.3]) * (1.0 + 1e-3 * rng.random()))
    sizes, damping = drawn_sizes(rng, count), float(rng.choice([0.0, 0.3]))
    found = grown(place, sizes, ratio, damping)
    rod, frequencies = TUBING.replace(damping_rate=damping), (SLOW, ratio * SLOW)
    search = _Search(rod, *place, (sizes[0], sizes[1]), frequencies)
    top, _ = search._resonant(np.full(count, frequencies[1] ** 2), 1.0)
    squares = (np.linspace(0.01, 1.3, 800)[:, None] ** 2 * top).ravel()
    numbers = np.tile(np.arange(count), 800)
    every = _Waves(numbers, numbers, squares, squares)
    largest = search.largest(every, search.growth(every).rate)
    assert (largest <= found.rate + found.error + 1e-6).all()
    assert damping > 0.0 or (largest > 0.0).any()


def test_nothing_grows_without_vibration() -> None:
    place = drawn_places(np.random.default_rng(83), 5)
    found = grown(place, np.zeros((2, place[1].size)), 1.617, 0.0)
    assert not found.rate.any()
    assert not found.error.any()
    assert not found.half_wave.any()
