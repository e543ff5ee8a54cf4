"""Mathieu's equation over arrays: verdicts, growth and discriminants against 50 digits, and ufunc manners."""

from __future__ import annotations

import math
import os
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.floquet.mathieu_chains import mathieu_counts
from floquetrod.methods import reference
from tests.conftest import JIT, depth, needs_jit
from tests.inside import count_below
from tests.seams import Tuned
from tests.strategies import mathieu_points, near_boundary_points

pytestmark = pytest.mark.kernels

THINNED = 1 if JIT else 10  # every tenth point alone, where nothing is compiled
with np.load(Path(__file__).parents[1] / "data/golden.npz") as golden:
    GOLDEN = {name: golden[name][::THINNED] for name in golden}


def test_verdicts_agree_with_fifty_digits_on_ten_thousand_points() -> None:
    assert GOLDEN["alpha"].size >= 10_000 // THINNED
    stable = fr.mathieu.is_stable(GOLDEN["alpha"], GOLDEN["beta"])
    assert np.array_equal(stable, GOLDEN["stable"])


@pytest.mark.parametrize("offset", [-1e-12, 1e-12])
def test_verdicts_hold_a_relative_1e_12_to_either_side(offset: float) -> None:
    stable = fr.mathieu.is_stable(GOLDEN["alpha"], GOLDEN["beta"] * (1.0 + offset))
    assert np.array_equal(stable, GOLDEN["stable"])


def test_growth_rates_to_1e_8_wherever_above_1e_9() -> None:
    growth = fr.mathieu.growth_rate(GOLDEN["alpha"], GOLDEN["beta"])
    true = GOLDEN["growth_rate"]
    some = true > 1e-9
    assert some.sum() > 3000 // THINNED
    assert np.abs(growth[some] / true[some] - 1.0).max() < 1e-8
    assert np.array_equal(growth > 0.0, ~GOLDEN["stable"])


def test_discriminants_to_1e_12_near_and_1e_10_far() -> None:
    found = fr.mathieu.discriminant(GOLDEN["alpha"], GOLDEN["beta"])
    true = GOLDEN["discriminant"]
    finite = np.isfinite(true)
    assert np.array_equal(found[~finite], true[~finite])
    error = np.abs(found[finite] - true[finite]) / np.maximum(1.0, np.abs(true[finite]))
    near = (GOLDEN["alpha"][finite] <= 6.0) & (np.abs(GOLDEN["beta"][finite]) <= 4.0)
    assert near.sum() > 20 // THINNED
    assert error[near].max() < 1e-12
    assert error.max() < 1e-10


@settings(max_examples=depth(60, 8))
@given(mathieu_points() | near_boundary_points())
def test_fresh_points_agree_with_the_reference(point: tuple[float, float]) -> None:
    alpha, beta = point
    true = reference(fr.Mathieu(alpha, beta), digits=50)
    found = fr.stability(fr.Mathieu(alpha, beta), method="spectral")
    assert found.status in (true.status, "undecided")
    if found.status != "undecided":
        assert fr.mathieu.is_stable(alpha, beta) is true.stable
    assert fr.mathieu.growth_rate(alpha, beta) == pytest.approx(true.growth_rate, rel=1e-8, abs=1e-9)
    if math.isfinite(true.discriminant):
        scale = max(1.0, abs(true.discriminant))
        limit = 1e-12 if abs(alpha) <= 6.0 and abs(beta) <= 4.0 else 1e-10
        assert abs(fr.mathieu.discriminant(alpha, beta) - true.discriminant) <= limit * scale
        assert abs(found.discriminant - true.discriminant) <= found.error * scale


@settings(max_examples=depth(100, 12))
@given(mathieu_points(largest_alpha=5.0, beta=(-4.0, 1.0)))
def test_near_plane_discriminants_to_1e_12(point: tuple[float, float]) -> None:
    true = reference(fr.Mathieu(*point), digits=30).discriminant
    assert abs(fr.mathieu.discriminant(*point) - true) <= 1e-12 * max(1.0, abs(true))


def test_the_thinnest_tongue() -> None:
    # F2-b: in double precision the trace is -2 within rounding; the count still sees the tongue.
    assert not fr.mathieu.is_stable(1e-8, -0.25)
    assert fr.mathieu.growth_rate(1e-8, -0.25) == pytest.approx(5.0e-9, rel=1e-8)
    assert fr.mathieu.growth_rate(1e-300, -0.25) == pytest.approx(5.0e-301, rel=1e-8)


def test_no_forcing() -> None:
    beta = np.array([-4.0, -1.0, -0.3, -0.25, 0.0, 0.25, 1.0])
    assert fr.mathieu.is_stable(0.0, beta).tolist() == [True] * 4 + [False] * 3
    assert fr.mathieu.growth_rate(0.0, beta) == pytest.approx(np.sqrt(np.maximum(beta, 0.0)), rel=1e-14)
    root = np.sqrt(np.abs(beta))
    trace = np.where(beta < 0.0, 2.0 * np.cos(2.0 * np.pi * root), 2.0 * np.cosh(2.0 * np.pi * root))
    assert fr.mathieu.discriminant(0.0, beta) == pytest.approx(trace, rel=1e-13, abs=1e-13)


def test_claims_about_single_points() -> None:
    # F2-c: the boundary at beta = -0.80 lies between 1.58 and 1.6.  F2-d: some beta > 0 are stable.
    assert fr.mathieu.is_stable([1.5, 1.58, 1.6], -0.80).tolist() == [True, True, False]
    assert fr.mathieu.is_stable(1.0, 0.378)


def test_damping_can_destabilise() -> None:
    assert fr.mathieu.is_stable(1.0, 0.378488)
    assert not fr.mathieu.is_stable(1.0, 0.378488, damping=0.03)
    assert fr.mathieu.is_stable(0.1, -0.25, damping=0.06)


@pytest.mark.kernels
@pytest.mark.parametrize("size", [1, 100])
def test_a_coefficient_of_zero_is_the_same_however_it_is_asked(size: int) -> None:
    # A'' = 0 grows linearly; with damping A' + 2 c A is constant, and any push, however small, grows.
    zero = np.zeros(size)
    assert not fr.mathieu.is_stable(zero, 0.0).any()
    assert not fr.mathieu.is_stable(zero, 0.0, zero).any()
    assert fr.mathieu.is_stable(zero, 0.0, zero + 0.1).all()
    assert not fr.mathieu.is_stable(zero, 1e-30, zero + 0.1).any()
    assert fr.mathieu.is_stable(zero, -1e-30, zero).all()
    assert fr.stability(fr.Mathieu(0.0, 0.0)).status == "unstable"
    assert fr.stability(fr.Mathieu(0.0, 0.0, 0.1)).status == "stable"


def test_undamped_is_damped_by_nothing(rng: np.random.Generator) -> None:
    alpha, beta = rng.uniform(-20.0, 20.0, 5000), rng.uniform(-30.0, 5.0, 5000)
    assert (fr.mathieu.is_stable(alpha, beta) == fr.mathieu.is_stable(alpha, beta, np.zeros(5000))).all()


def test_damping_is_a_substitution() -> None:
    alpha, beta, c = 1.3, -0.4, 0.07
    undamped = fr.mathieu.growth_rate(alpha, beta + c * c)
    assert fr.mathieu.growth_rate(alpha, beta, c) == pytest.approx(undamped - c, rel=1e-12)
    product = np.prod(fr.mathieu.multipliers(alpha, beta, c))
    assert product == pytest.approx(math.exp(-4.0 * math.pi * c), rel=1e-12)


@given(mathieu_points())
def test_the_sign_of_alpha_only_shifts_time(point: tuple[float, float]) -> None:
    alpha, beta = point
    for function in (fr.mathieu.is_stable, fr.mathieu.growth_rate, fr.mathieu.discriminant):
        assert function(alpha, beta) == function(-alpha, beta)


def test_multipliers_keep_the_small_one() -> None:
    large, small = fr.mathieu.multipliers(3.0, 40.0)
    assert abs(large) > 1e15
    assert large * small == pytest.approx(1.0, rel=1e-12)
    rotation = fr.mathieu.multipliers(0.3, -0.6)
    assert np.abs(rotation) == pytest.approx(1.0, rel=1e-14)
    assert rotation.sum().real == pytest.approx(fr.mathieu.discriminant(0.3, -0.6), rel=1e-13)


def test_broadcasting_and_types() -> None:
    alpha, beta = np.linspace(0.1, 3.0, 7)[:, None], np.linspace(-3.0, 0.5, 5)
    stable = fr.mathieu.is_stable(alpha, beta)
    assert stable.shape == (7, 5)
    assert stable.dtype == bool
    assert fr.mathieu.multipliers(alpha, beta).shape == (7, 5, 2)
    assert fr.mathieu.growth_rate(alpha, beta, np.zeros((2, 1, 1))).shape == (2, 7, 5)
    assert fr.mathieu.is_stable(np.empty((0, 3)), 0.1).shape == (0, 3)
    assert isinstance(fr.mathieu.is_stable(0.5, -0.2), bool)
    one_by_one = [[fr.mathieu.is_stable(float(a), float(b)) for b in beta] for a in alpha[:, 0]]
    assert stable.tolist() == one_by_one
    assert fr.mathieu.is_stable(2, -3) == fr.mathieu.is_stable(2.0, -3.0)


def test_compiled_and_interpreted_kernels_agree(rng: np.random.Generator) -> None:
    alpha, beta = rng.uniform(0.0, 50.0, 400), rng.uniform(-50.0, 10.0, 400)
    for function in (fr.mathieu.growth_rate, fr.mathieu.discriminant):
        pieces = [function(alpha[i : i + 40], beta[i : i + 40]) for i in range(0, 400, 40)]
        assert function(alpha, beta) == pytest.approx(np.concatenate(pieces), rel=1e-10, abs=1e-12)
    counts = [count_below(-4.0 * b, 2.0 * a) % 2 == 1 for a, b in zip(alpha.tolist(), beta.tolist(), strict=True)]
    assert fr.mathieu.is_stable(alpha, beta).tolist() == counts


@pytest.mark.parametrize("damping", [0.0, pytest.param(1e-3, marks=pytest.mark.slow), 0.3])
def test_near_bands_thinner_than_rounding_verdict_and_growth_agree(damping: float) -> None:
    # An odd count of curves said stable there: two that coincide are computed with different rounding.
    beta = 59.14823157446198 - damping * damping + np.arange(-12, 13) * np.spacing(59.14823157446198)
    grows = fr.mathieu.growth_rate(6842.662812224557, beta, damping)
    assert grows.min() > 26.0
    assert not fr.mathieu.is_stable(6842.662812224557, beta, damping).any()
    assert not fr.mathieu.is_stable(6842.662812224557, np.tile(beta, 10), damping).any()  # compiled
    assert not any(fr.mathieu.is_stable(6842.662812224557, float(b), damping) for b in beta)


@pytest.mark.parametrize("place", [0.01, 0.5, 0.99])
def test_in_bands_that_only_determinants_are_asked_about_points_are_stable(place: float) -> None:
    low, high = fr.mathieu.characteristic_values(1, 20.0, "a"), fr.mathieu.characteristic_values(2, 20.0, "b")
    beta = -0.25 * (low + place * (high - low))  # of a band 2.4e-4 wide
    assert mathieu_counts.shown_by_count(10.0, beta) == mathieu_counts.NEAR_A_BAND
    assert fr.mathieu.is_stable(10.0, beta)
    assert fr.mathieu.is_stable(10.0, np.full(100, beta)).all()
    assert fr.mathieu.is_stable(10.0, beta, 1e-12)


@needs_jit
def test_workers_do_not_change_the_result(rng: np.random.Generator) -> None:
    alpha, beta = rng.uniform(0.0, 5.0, 40_000), rng.uniform(-4.0, 1.0, 40_000)
    alone, together = (fr.mathieu.is_stable(alpha, beta, workers=n) for n in (1, 2))
    assert np.array_equal(alone, together)


def test_calls_from_threads() -> None:
    many = 60 if JIT else 12
    alpha, beta = np.meshgrid(np.linspace(0.0, 5.0, many), np.linspace(-4.0, 1.0, many))
    expected = fr.mathieu.growth_rate(alpha, beta)
    found: list[np.ndarray] = []
    threads = [threading.Thread(target=lambda: found.append(fr.mathieu.growth_rate(alpha, beta))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert all(np.array_equal(expected, one) for one in found)


@pytest.mark.slow
@pytest.mark.parametrize("alpha", [0.0, 1e-300, 1e-160, 1e-30, 1.0, 1e6, 1e9][:: depth(1, 3)])
@pytest.mark.parametrize("beta", [-1e9, -1e6, -1.0, -0.25, -1e-300, 0.0, 1e-300, 1.0, 1e6, 1e9][:: depth(1, 3)])
def test_extreme_parameters_neither_crash_nor_loop(alpha: float, beta: float, tuned: Tuned) -> None:
    if os.environ.get("NUMBA_DISABLE_JIT") == "1" and max(alpha, abs(beta)) > 1e5:
        pytest.skip("a minute each when interpreted; run compiled")
    tuned(functions_compiled_after=0)  # interpreted, a hundred of the hardest points take ten seconds
    many = np.full(depth(100, 65), alpha)
    stable = fr.mathieu.is_stable(many, beta)
    assert stable.all() or not stable.any()
    assert bool(stable[0]) is bool(fr.mathieu.is_stable(alpha, beta))
    growth = fr.mathieu.growth_rate(many, beta)[0]
    assert math.isfinite(growth)
    assert growth >= 0.0
    assert not math.isnan(fr.mathieu.discriminant(many, beta)[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((math.nan, 0.1), "alpha must be finite"),
        ((0.1, math.inf), "beta must be finite"),
        (([0.1, math.nan], [0.1, 0.2]), r"alpha\[1\] = nan"),
        (([0.1, 0.2], [0.1, 0.2, 0.3]), "must broadcast to one shape"),
        ((0.1, 0.1, -1.0), "damping must be finite and lie between 0"),
        ((2e9, 0.1), "alpha must lie between"),
    ],
)
def test_bad_values(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.mathieu.is_stable(*arguments)


@pytest.mark.parametrize("alpha", ["0.5", None, 1j, [[1.0], [2.0, 3.0]]])
def test_bad_types(alpha: object) -> None:
    with pytest.raises((TypeError, ValueError), match=r"alpha|inhomogeneous"):
        fr.mathieu.growth_rate(alpha, 0.1)


def around_the_widest_bands_that_counts_decide(points: int, rng: np.random.Generator) -> list[np.ndarray]:
    """Return alpha and beta where (2 q - a)^2 is 104 q to 130 q: an odd count ceases to show anything there."""
    q = rng.uniform(30.0, 300.0, points)
    return [0.5 * q, -0.25 * (2.0 * q - np.sqrt(rng.uniform(104.0, 130.0, points) * q))]


def test_blocks_count_as_single_points_do_where_they_run_interpreted(rng: np.random.Generator) -> None:
    points = [values.tolist() for values in around_the_widest_bands_that_counts_decide(640, rng)]
    blocks, single = np.empty(640, np.int8), np.empty(640, np.int8)
    mathieu_counts.shown_fill(*points, blocks)
    mathieu_counts.shown_one_by_one(*points, single)
    assert blocks.tolist() == single.tolist()


@needs_jit
def test_blocks_count_as_single_points_do_near_bands_thinner_than_rounding(rng: np.random.Generator) -> None:
    points = around_the_widest_bands_that_counts_decide(1 << 15, rng)
    blocks, single = np.empty(1 << 15, np.int8), np.empty(1 << 15, np.int8)
    compiled(mathieu_counts.shown_fill)(*points, blocks)
    compiled(mathieu_counts.shown_one_by_one)(*points, single)
    assert {*blocks.tolist()} <= {-1, 0, 1}
    assert np.flatnonzero(blocks != single).tolist() == []
    assert {*fr.mathieu.is_stable(*points).view(np.int8).tolist()} <= {0, 1}
