"""The paper's test as a criterion: by leapfrog it ends where stepping ends, exactly it follows growth and phase."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.floquet.kernels.powers import displacement_fill
from floquetrod.methods import monodromy_matrix
from tests.inside import leapfrog_map_fill, mathieu_map_fill
from tests.strategies import decades

ALPHA, BETA = np.meshgrid(np.linspace(0.0, 5.0, 100), np.linspace(-4.0, 1.0, 100))  # the window of the paper's chart


def stepped(table: np.ndarray, step: float, damping: float) -> tuple[float, float]:
    """Return (A, A') from (0, 1), kick by kick, with the coefficient at the beginning of each step."""
    a, v, decay = 0.0, 1.0, math.exp(-damping * step)
    for p, following in zip(table, np.roll(table, -1), strict=True):
        v = v * decay + 0.5 * step * p * a
        a += step * v
        v = (v + 0.5 * step * following * a) * decay
    return a, v


@pytest.mark.kernels
def test_leapfrog_ends_where_stepping_ends(rng: np.random.Generator) -> None:
    count, periods = 100, 13
    sine = np.sin(np.arange(count) * (2.0 * math.pi / count))
    alpha, beta = rng.uniform(-2.0, 2.0, 20), rng.uniform(-1.5, 0.5, 20)
    damping = rng.choice([0.0, 0.05], 20)
    maps, out, plain_maps, plain = np.empty((20, 5)), np.empty(20), np.empty((20, 5)), [0.0] * 20
    compiled(leapfrog_map_fill)(alpha, beta, damping, maps, sine, 2.0 * math.pi)
    compiled(displacement_fill)(maps, out, periods)
    leapfrog_map_fill(alpha.tolist(), beta.tolist(), damping.tolist(), plain_maps, sine.tolist(), 2.0 * math.pi)
    displacement_fill(plain_maps.tolist(), plain, periods)
    for i in range(20):
        table = beta[i] + alpha[i] * sine
        a, v = stepped(np.tile(table, periods), 2.0 * math.pi / count, damping[i])
        # Where A crosses zero its logarithm has no digits: compare A itself, in units of the whole motion.
        for log10_ratio in (out[i], plain[i]):
            assert 10.0**log10_ratio == pytest.approx(abs(a), abs=1e-9 * math.hypot(a, v))


@pytest.mark.kernels
def test_the_exact_map_is_the_monodromy_matrix(rng: np.random.Generator) -> None:
    alpha, beta = rng.uniform(-3.0, 3.0, 6), rng.uniform(-3.0, 1.0, 6)
    damping = rng.choice([0.0, 0.2], 6)
    for fill in (mathieu_map_fill, compiled(mathieu_map_fill)):
        maps = np.empty((6, 5))
        fill(alpha, beta, damping, maps)
        for i in range(6):
            expected = monodromy_matrix(fr.Mathieu(alpha[i], beta[i], damping[i])).T.ravel()
            assert maps[i, :4] * math.exp(maps[i, 4]) == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_huge_growth_and_strong_damping() -> None:
    for by in ("exact", "leapfrog"):
        huge, slow = fr.FiniteTimeCriterion(by=by, step=2e-3).growth(0.0, [1e4, -0.25], [0.0, 60.0])
        assert huge == pytest.approx((200.0 * math.pi * 100.0 - math.log(200.0)) / math.log(10.0), rel=1e-2)
        # Overdamped: the slower exponent is close to -0.25 / (2 c).
        assert slow == pytest.approx((-0.125 / 60.0 * 200.0 * math.pi - math.log(120.0)) / math.log(10.0), rel=1e-2)


@given(decades(1e-6, 3.0), st.sampled_from((-1.0, 1.0)), st.integers(1, 200))
def test_constant_coefficients_in_closed_form(size: float, sign: float, periods: int) -> None:
    beta, root, time = sign * size, math.sqrt(size), 2.0 * math.pi * periods
    assume(root * time < 600.0)
    expected = (math.sinh(root * time) if beta > 0.0 else math.sin(root * time)) / root
    got = fr.FiniteTimeCriterion(periods=periods).growth(0.0, beta)
    assert 10.0**got == pytest.approx(abs(expected), rel=1e-10, abs=1e-10 / root)


@pytest.mark.slow
def test_both_ways_agree_on_the_whole_chart() -> None:
    exact, leapfrog = (fr.FiniteTimeCriterion(by=by) for by in ("exact", "leapfrog"))
    assert np.array_equal(exact.is_stable(ALPHA, BETA), leapfrog.is_stable(ALPHA, BETA))


def test_the_test_differs_from_its_threshold_only_beside_it() -> None:
    criterion = fr.FiniteTimeCriterion()
    assert criterion.threshold == pytest.approx(0.0219880, rel=1e-5)
    growth = fr.mathieu.growth_rate(ALPHA, BETA)
    differ = criterion.is_stable(ALPHA, BETA) != (growth <= criterion.threshold)
    assert 0 < differ.sum() < 20
    assert np.abs(growth[differ] - criterion.threshold).max() < 0.0026
    # and what it calls unstable is: nothing bounded grows a million times
    assert not (fr.mathieu.is_stable(ALPHA, BETA) & ~criterion.is_stable(ALPHA, BETA)).any()


@pytest.mark.slow
def test_charts_and_maps_take_the_criterion() -> None:
    criterion = fr.FiniteTimeCriterion()
    chart = fr.mathieu.chart((0.0, 3.0, 30), (-2.0, 0.5, 20), criterion=criterion)
    assert np.array_equal(chart.stable, criterion.is_stable(chart.x.values, chart.y.values[:, None]))
    assert chart.caption.endswith("stable means growth below 1e+06 in 100 periods, computed exactly")
    rod = fr.Rod.nitinol()
    load = {"mean": (0.0, 1.1 * rod.critical_force, 23), "frequency": (20.0, 200.0, 19)}
    chart = fr.stability_map(rod, amplitude=0.2 * rod.critical_force, criterion=criterion, **load)
    # Every mode on its own, more of them than are looked at.
    mean, omega = np.meshgrid(chart.y.values, chart.x.values, indexing="ij")
    expected = np.ones(mean.shape, dtype=bool)
    for mode in range(1, 60):
        w2 = (mode * np.pi / rod.length) ** 2
        inertia = rod.mass_per_length * omega**2
        alpha = w2 * 0.2 * rod.critical_force / inertia
        beta = (mean * w2 - rod.flexural_rigidity * w2**2) / inertia - (rod.pendulum_frequency / omega) ** 2
        expected &= criterion.is_stable(alpha, beta)
    assert np.array_equal(chart.stable, expected)


@pytest.mark.slow
def test_a_function_of_equations_is_tested_by_the_equations_it_returns() -> None:
    criterion = fr.FiniteTimeCriterion()
    plane = (0.0, 1.5, 12), (-2.0, 0.5, 10)
    chart = fr.mathieu.chart(
        *plane, 0.01, equation=lambda a, b, c: fr.Mathieu(2.0 * a, b, 2.0 * c), criterion=criterion, growth=True
    )
    expected = criterion.is_stable(2.0 * chart.x.values, chart.y.values[:, None], 0.02)
    assert np.array_equal(chart.stable, expected)
    assert np.array_equal(
        chart.growth_rate, fr.mathieu.growth_rate(2.0 * chart.x.values, chart.y.values[:, None], 0.02)
    )
    assert not np.array_equal(expected, criterion.is_stable(chart.x.values, chart.y.values[:, None], 0.01))
    place = chart.bands.bands[-1].place
    assert not criterion.is_stable(2.0 * place[0], place[1], 0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"periods": 0}, "periods must be 1 or more"),
        ({"limit": 1.0}, "limit must be greater than 1"),
        ({"by": "guess"}, "by must be one of 'exact', 'leapfrog'"),
        ({"step": 0.0}, "step must be greater than zero"),
        ({"step": 1.0}, "step must lie between"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.FiniteTimeCriterion(**change)  # type: ignore[arg-type]


def test_two_criteria_at_once_are_refused() -> None:
    with pytest.raises(ValueError, match="growth_tolerance must be 0 with a criterion"):
        fr.mathieu.chart((0.0, 1.0, 3), (-1.0, 0.0, 3), growth_tolerance=0.1, criterion=fr.FiniteTimeCriterion())
