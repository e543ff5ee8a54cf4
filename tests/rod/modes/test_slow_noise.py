"""Noise slower than a mode, which makes its stiffness drift, against moments that are closed by Hermite functions."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

import floquetrod as fr
from floquetrod._util.arrays import Floats
from floquetrod.rod.mode_equations.moment_coefficients import ModeCoefficients, growth_of_white_noise
from floquetrod.rod.mode_equations.narrow_noise import densities_about, excess_below
from floquetrod.rod.mode_equations.slow_noise import growth_as_stiffness_drifts, least_intensities
from tests.conftest import depth
from tests.rod.modes.test_narrow_noise import MEAN, MODE, ROD, coefficients

Filter = tuple[Floats, Floats, Floats]
STIFFNESS = np.array([[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -2.0, 0.0]])  # acting on E[q^2], E[q q'], E[q'^2]


def slow(rms: float, rate: float) -> Filter:
    """Return a filter of a root mean square, over the stiffness, that forgets at a rate, over the frequency."""
    return np.array([[-rate]]), np.array([math.sqrt(2.0 * rate)]), np.array([rms])


def band(rms: float, centre: float, half: float) -> Filter:
    """Return a filter that resonates at ``centre``, of a half-width ``half``, both over the mode's frequency."""
    matrix = np.array([[0.0, 1.0], [-(centre**2), -2.0 * half]])
    return matrix, np.array([0.0, 1.0]), np.array([rms * math.sqrt(4.0 * half) * centre, 0.0])


def density(filter_: Filter, at: Floats) -> Floats:
    """Return the one-sided density per Hz at frequencies in Hz, in units of the mode's."""
    f, b, d = filter_
    turn = 2j * math.pi * at[:, None, None] * np.eye(len(f)) - f
    return np.asarray(
        2.0 * np.abs(np.linalg.solve(turn, np.broadcast_to(b[:, None], (len(at), len(b), 1)))[..., 0] @ d) ** 2
    )


def exact(filter_: Filter, c: float, order: int, sine: tuple[float, float] = (0.0, 1.0), steps: int = 80) -> float:
    """Return the growth of second moments of q'' + 2 c q' + (1 + a cos W t + noise) q = 0, from ``sine`` (a, W)."""
    f, b, d = filter_
    root = np.linalg.cholesky(solve_continuous_lyapunov(f, -np.outer(b, b)))
    turned, through = np.linalg.solve(root, f @ root), root.T @ d
    every = [a for a in itertools.product(range(order + 1), repeat=len(d)) if sum(a) <= order]
    place = {a: i for i, a in enumerate(every)}
    relaxing, coupling = np.zeros((2, len(every), len(every)))
    for a, row in place.items():
        for i, j in itertools.product(range(len(d)), repeat=2):
            moved: Any = [*a]
            moved[i] -= 1
            moved[j] += 1
            if a[i]:
                relaxing[row, place[tuple(moved)]] += turned[i, j] * math.sqrt(a[i] * moved[j])
        for j in range(len(d)):
            above = place.get((*a[:j], a[j] + 1, *a[j + 1 :]))
            if above is not None:
                coupling[row, above] = coupling[above, row] = through[j] * math.sqrt(a[j] + 1)
    alone = np.array([[0.0, 2.0, 0.0], [-1.0, -2.0 * c, 1.0], [0.0, -2.0, -4.0 * c]])
    mean = np.kron(np.eye(len(every)), alone) + np.kron(coupling, STIFFNESS) + np.kron(relaxing, np.eye(3))
    amplitude, frequency = sine
    if not amplitude:
        return float(np.linalg.eigvals(mean).real.max())
    period, waves = 2.0 * math.pi / frequency, np.kron(np.eye(len(every)), amplitude * STIFFNESS)
    whole = np.eye(len(mean))
    for i in range(steps):
        whole = expm(period / steps * (mean + math.cos(2.0 * math.pi * (i + 0.5) / steps) * waves)) @ whole
    return math.log(np.abs(np.linalg.eigvals(whole)).max()) / period


def mode(filter_: Filter, c: float, sine: tuple[float, float]) -> tuple[ModeCoefficients, Any]:
    """Return the coefficients of a mode of the frequency 1 and the noise, as pairs."""
    at = np.linspace(0.0, 2.0, 4001)
    noise = tuple(zip(at.tolist(), density(filter_, at).tolist(), strict=True))
    one = np.ones((1, 1))
    waves = (sine[0] * one.astype(complex),) if sine[0] else ()
    parts = ModeCoefficients(one, waves, sine[1] * one, one, c, per_newton=one)
    return parts.with_density(np.interp(parts.hertz, *np.array(noise).T)), noise


def bounded(filter_: Filter, c: float, sine: tuple[float, float] = (0.0, 1.0)) -> tuple[float, float, float]:
    """Return the growth as the stiffness drifts, under the largest density, and under that at twice the frequency."""
    parts, noise = mode(filter_, c, sine)
    chosen, one = np.ones((1, 1), dtype=np.bool_), np.ones((1, 1))
    drifting = growth_as_stiffness_drifts(parts, excess_below(noise, parts.reference), noise, -1e9, chosen, None)
    most = densities_about(noise, parts.hertz, 0.25 * one).most
    white = [fr.second_moments(*_noisy(c, sine, float(s[0, 0]))) for s in (0.5 * most, np.square(parts.intensity))]
    rates = [fr.stability(moments, "monodromy").exponents[0].real for moments in white]
    return float(drifting[0, 0]), rates[0], rates[1]


def least(filter_: Filter) -> float:
    """Return the growth that is counted on without damping and sine, 0 where none is."""
    parts, noise = mode(filter_, 0.0, (0.0, 1.0))
    found = least_intensities(parts, excess_below(noise, parts.reference), noise)
    return float(growth_of_white_noise(parts.squared, np.square(found))[0, 0])


def _noisy(c: float, sine: tuple[float, float], squared: float) -> Any:
    period = 2.0 * math.pi / sine[1]
    return fr.HillSystem([[1.0]], [[[sine[0]]]], damping=[[2.0 * c]], period=period), [([[1.0]], math.sqrt(squared))]


@pytest.mark.parametrize(("rate", "most"), [(0.05, 1.3), (0.5, 1.6), (2.0, 1.6)])
def test_growth_under_noise_that_forgets_slowly_is_known(rate: float, most: float) -> None:
    """From drifts that only change the frequency to some that buckle the mode, which need the surplus of variance."""
    for rms in (0.05, 0.1, 0.8):
        found, _, white = bounded(slow(rms, rate), 0.0)
        true = exact(slow(rms, rate), 0.0, 64)
        assert white < true < found < most * true


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(60, 4)))
def test_growth_as_the_stiffness_drifts_is_no_less_than_that_under_drawn_filters(seed: int) -> None:
    """Of 300 drawn bands from a tenth of the mode's frequency on the bound was 0.64 of the growth at least."""
    rng = np.random.default_rng((7, seed))
    rms = float(10.0 ** rng.uniform(-1.5, -0.4))
    narrow = band(rms, float(10.0 ** rng.uniform(-1.0, 0.27)), float(10.0 ** rng.uniform(-1.5, -0.5)))
    wide = slow(rms, float(10.0 ** rng.uniform(-1.7, 0.7)))
    for filter_, order, share in ((narrow, 14, 0.6), (wide, 48, 0.97)):
        assert max(bounded(filter_, 0.0)) > share * exact(filter_, 0.0, order) - 1e-7
    strong = float(10.0 ** rng.uniform(-1.0, 0.0))
    narrow = band(strong, float(10.0 ** rng.uniform(-1.0, 0.27)), float(10.0 ** rng.uniform(-1.5, -0.5)))
    wide = slow(strong, float(10.0 ** rng.uniform(-1.5, 0.5)))
    for filter_, order in ((narrow, 14), (wide, 48)):
        assert least(filter_) <= 1.02 * exact(filter_, 0.0, order)


def test_slow_noise_that_makes_modes_buckle_is_unstable() -> None:
    """White noise of the density at twice the frequency of any mode lets it decay; the growth is within its range."""
    rod, load = in_newtons(slow(0.6, 0.1), 0.02, (0.0, 2.0))
    w, _ = coefficients()
    true = exact(slow(0.6, 0.1), 0.02, 48) * w
    white = rod.stability(fr.AxialLoad(MEAN, 0.0, "1Hz", noise=load.noise[-1][1]), modes=[MODE])
    assert white.status == "stable"
    verdict = rod.stability(load, modes=[MODE])
    less, more = verdict.evidence.growth_errors
    assert verdict.status == "unstable"
    assert verdict.growth_rate - less <= true <= verdict.growth_rate + more
    assert verdict.growth_rate > 0.4 * true
    whole = rod.stability(load)
    assert int(rod.verdicts(load, mean=MEAN)) == 0
    assert float(rod.growth_rate(load, mean=MEAN)) == pytest.approx(whole.growth_rate, rel=1e-6)


def test_a_mode_beside_a_tongue_may_grow_as_slow_noise_leads_it_there() -> None:
    """White noise of the density at twice its frequency lets it decay, at 0.02."""
    sine, c, filter_ = (0.2, 2.15), 0.01, slow(0.05, 0.05)
    true = exact(filter_, c, 12, sine)
    found, _, white = bounded(filter_, c, sine)
    assert white < -0.019 < 0.002 < true < found


def in_newtons(filter_: Filter, damping: float, sine: tuple[float, float]) -> tuple[fr.Rod, fr.AxialLoad]:
    """Return a rod and a load whose mode `MODE` obeys the equation of `exact`; ``damping`` over the frequency."""
    w, k = coefficients()
    at = np.unique(np.concatenate([np.linspace(0.0, 1.5, 600), np.linspace(1.5, 8.0, 80)]))
    values = density(filter_, at) * w**3 / k**2
    noise = tuple(zip((at * w).tolist(), values.tolist(), strict=True))
    load = fr.AxialLoad(MEAN, sine[0] * w**2 / k, sine[1] * w, noise=noise)
    return ROD.replace(damping_rate=damping * w), load


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(60, 6)))
def test_no_verdict_contradicts_the_growth_of_closed_moments(seed: int) -> None:
    """Of a sine about the first tongue and noise that is slower than the mode; arrays agree."""
    rng = np.random.default_rng((8, seed))
    amplitude, rms = float(10.0 ** rng.uniform(-1.5, -0.5)), float(10.0 ** rng.uniform(-1.7, -0.6))
    sine = (amplitude, 2.0 + float(rng.normal(0.0, 0.5 * amplitude + rms)))
    c, filter_ = (
        float(0.25 * amplitude * 10.0 ** rng.uniform(-1.0, 0.2)),
        slow(rms, float(10.0 ** rng.uniform(-1.7, 0.0))),
    )
    true = exact(filter_, c, 16, sine)
    rod, load = in_newtons(filter_, c, sine)
    verdict = rod.stability(load, modes=[MODE])
    if verdict.status != "undecided" and abs(true) > 0.05 * c:
        assert verdict.status == ("unstable" if true > 0.0 else "stable"), (sine, c, rms, true)
    together = int(rod.verdicts(load, mean=load.mean))
    assert together == {"stable": 1, "unstable": 0, "undecided": -1}[rod.stability(load).status]


def test_damped_modes_are_decided_under_noise_of_a_fifth_of_their_stiffness() -> None:
    """A quarter of the critical density and less than a fifth of the stiffness, 0.22, leave it stable."""
    rod, load = in_newtons(slow(0.22, 1.0), 0.02, (0.0, 2.0))
    assert exact(slow(0.22, 1.0), 0.02, 24) < -0.02
    verdict = rod.stability(load, modes=[MODE])
    assert verdict.status == "stable"
    rare = rod.stability(in_newtons(slow(0.22, 0.05), 0.02, (0.0, 2.0))[1], modes=[MODE])
    assert rare.status == "undecided"
    assert "changes the stiffness slowly" in rare.undecided_by
    assert exact(slow(0.22, 0.05), 0.02, 64) > 0.5
