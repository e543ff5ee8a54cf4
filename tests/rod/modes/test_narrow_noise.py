"""Noise in a narrow band about twice a mode's frequency or beside it: no verdict that holds for white noise alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.mode_equations.narrow_noise import densities_about
from floquetrod.rod.mode_equations.noisy_equations import NoisyModes
from floquetrod.rod.model.contact import constants_under
from tests.conftest import depth

ROD = fr.Rod.nitinol().replace(damping_rate=1.0)
MODE, MEAN = 5, 0.3 * ROD.critical_force


def coefficients() -> tuple[float, float]:
    """Return frequency of the mode in rad/s and what a newton takes from its stiffness, in 1/(N s^2)."""
    load = fr.AxialLoad(MEAN, 0.0, 10.0, noise=1.0)
    parts = NoisyModes(constants_under(ROD, MEAN), load).parts(Loads.single(load), [MODE])
    return math.sqrt(float(parts.squared[0, 0])), abs(float(np.ravel(parts.per_newton)[0]))


def resonant(centre: float, width: float, strength: float) -> tuple[fr.AxialLoad, fr.results.FilteredGrowth]:
    """Return a load with noise about ``centre`` times twice the mode's frequency, and the growth that a filter gives.

    ``width`` is the half-width over twice the frequency; ``strength`` the largest density over that at which white
    noise makes the mode grow.  In units of the mode's frequency w, z'' + 2 b z' + a^2 z = g xi has the density
    2 g^2 / ((a^2 - u^2)^2 + 4 b^2 u^2) at the frequency u.
    """
    w, k = coefficients()
    a, b = 2.0 * centre, 2.0 * width
    critical = 8.0 * ROD.damping_rate * w**2 / k**2  # N^2/Hz: S k^2 / 4 w^2 = 2 c
    peak = strength * critical * k**2 / w**3  # of z
    g = math.sqrt(0.5 * peak) * 2.0 * a * b
    hertz = np.unique(np.concatenate([np.linspace(1e-3, 4.0, 400), a + b * np.linspace(-20.0, 20.0, 401)]))
    hertz = hertz[hertz > 0.0]
    density = 2.0 * g**2 / ((a**2 - hertz**2) ** 2 + 4.0 * b**2 * hertz**2) * w**3 / k**2
    noise = tuple(zip((hertz * w / (2.0 * math.pi)).tolist(), density.tolist(), strict=True))
    system = fr.HillSystem([[1.0]], damping=[[2.0 * ROD.damping_rate / w]])
    filtered = ([[0.0, 1.0], [-(a**2), -2.0 * b]], [0.0, 1.0], [g, 0.0])
    return fr.AxialLoad(MEAN, 0.0, 10.0, noise=noise), fr.filtered_growth(system, [[1.0]], filtered, accuracy=2e-3)


def test_wide_bands_are_white() -> None:
    for strength, status in ((0.7, "stable"), (1.5, "unstable")):
        load, filtered = resonant(1.0, 0.2, strength)
        assert ROD.stability(load, modes=[MODE]).status == filtered.status == status


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(40, 6)))
def test_no_verdict_contradicts_the_growth_under_filtered_noise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    width = float(10.0 ** rng.uniform(-1.7, -0.7))
    centre, strength = 1.0 + float(rng.normal(0.0, 2.0 * width)), float(10.0 ** rng.uniform(-0.5, 0.8))
    load, filtered = resonant(centre, width, strength)
    verdict = ROD.stability(load, modes=[MODE])
    if filtered.status != "undecided" and verdict.status != "undecided":
        assert verdict.status == filtered.status, (centre, width, strength, filtered.rate, verdict.exponents)


def test_noise_beside_twice_the_frequency_is_not_passed_over() -> None:
    """White noise of the density there would let the mode decay, and it grows."""
    load, filtered = resonant(0.93, 0.03, 4.0)
    assert filtered.status == "unstable"
    w, _ = coefficients()
    there = float(np.interp(w / math.pi, *np.array(load.noise).T))
    white = ROD.stability(fr.AxialLoad(MEAN, 0.0, 10.0, noise=there), modes=[MODE])
    assert white.status == "stable"
    verdict = ROD.stability(load, modes=[MODE])
    assert verdict.status == "undecided"
    assert "the noise is uneven" in verdict.undecided_by
    assert verdict.left_out == ""  # margins count the same noise


def test_arrays_and_single_loads_agree() -> None:
    load, _ = resonant(0.93, 0.03, 4.0)
    means = MEAN * np.linspace(0.9, 1.1, 9)
    statuses = ROD.verdicts(load, mean=means)
    names = {1: "stable", 0: "unstable", -1: "undecided"}
    single = [ROD.stability(fr.AxialLoad(float(mean), 0.0, 10.0, noise=load.noise)).status for mean in means]
    assert [names[int(status)] for status in statuses] == single
    assert "undecided" in single


def test_a_density_that_is_linear_about_a_frequency_is_its_own() -> None:
    noise = ((1.0, 1.0), (5.0, 2.0), (9.0, 3.0))
    found = densities_about(noise, np.array([4.0, 6.0]), np.array([0.1, 0.2]))
    np.testing.assert_allclose([found.least, found.most], [[1.75, 2.25], [1.75, 2.25]], rtol=1e-9)
    even = densities_about(2.0, np.array([4.0]), np.array([10.0]))
    assert even.least == even.most == 2.0


def test_growth_that_uneven_noise_may_undo_is_undecided() -> None:
    """In a narrow box the least density within the reach of the noise makes nothing grow, in arrays as well."""
    w, k = coefficients()
    centre, density = w / math.pi, 8.0 * ROD.damping_rate * w**2 / k**2
    for factor in (1.01, 1.5):
        size = factor * density
        noise = [(0.985 * centre, 0.0), (0.99 * centre, size), (1.01 * centre, size), (1.015 * centre, 0.0)]
        load = fr.AxialLoad(MEAN, 0.0, 10.0, noise=noise)
        verdict = ROD.stability(load)
        assert verdict.status == "undecided"
        assert verdict.growth_rate <= verdict.error
        assert int(ROD.verdicts(load, mean=MEAN)) == -1
