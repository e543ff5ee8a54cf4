"""Multipliers over many decades: what is stated holds, what is not known is NaN, and all ways to ask agree."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.multipliers.precise_spectra import eigenvalue_discs as precise_discs
from floquetrod.floquet.registry import applicable
from tests.conftest import depth, some
from tests.decades import known_system, unmatched

NEAR = 1e-6  # to a multiplier on the circle, of a logarithm


def count_outside(exponents: np.ndarray) -> int:
    return int((exponents.real > 0.0).sum())


def check_known(seed: int, *, slow: bool = False) -> None:
    """Compare every public answer on one system with the exponents by which it was made."""
    known = known_system(np.random.default_rng(seed))
    system, outside = known.system, count_outside(known.exponents)
    assert np.abs(known.exponents.real).min() * system.period > NEAR
    status = "unstable" if outside else "stable"
    judged = fr.stability(system)
    assert judged.status == status
    assert not unmatched(known, judged), seed
    assert sum(abs(mu) > 1.0 for mu in judged.multipliers) == outside
    assert len(judged.exponents) == system.order
    for method in (method.name for method in applicable(system) if slow or method.name != "reference"):
        result = fr.stability(system, method)
        assert result.status in (status, "undecided"), (seed, method)
        assert not unmatched(known, result), (seed, method)
        stated = zip(result.multipliers, result.multiplier_errors, strict=True)
        assert not any(mu == mu and math.isinf(error) for mu, error in stated)
    assert fr.systems.is_stable(system) is (status == "stable")
    assert fr.systems.growth_rate(system) == pytest.approx(judged.growth_rate, rel=1e-6, abs=1e-9)
    true = np.exp(known.exponents * system.period)
    for mu in fr.systems.multipliers(system):
        assert mu != mu or (np.abs(mu - true) / np.abs(true)).min() < 0.99, (seed, mu)


@pytest.mark.parametrize("seed", range(10))
def test_exponents_known_by_construction(seed: int) -> None:
    check_known(seed)


@pytest.mark.slow
def test_three_hundred_systems_over_forty_decades() -> None:
    for seed in some(range(1000, 1300), 100, 30):
        check_known(seed, slow=seed % 10 == 0)


def test_a_batch_tells_what_each_system_does() -> None:
    rng = np.random.default_rng(4)
    every = [known_system(rng, most=2) for _ in range(depth(60, 12))]
    batch = fr.systems.stack([known.system for known in every])
    alone = [fr.systems.multipliers(known.system) for known in every]
    np.testing.assert_allclose(fr.systems.multipliers(batch), alone, rtol=1e-9, atol=0.0, equal_nan=True)
    assert fr.systems.is_stable(batch).tolist() == [not count_outside(known.exponents) for known in every]


def test_small_multipliers_beside_large_ones_are_told_by_the_next_method() -> None:
    rates = np.array([7.3, 1.1, -0.9, -7.2])
    shear = np.eye(4) + np.diag([0.4, -0.7, 0.5], 1)
    system = fr.PeriodicSystem(shear @ np.diag(rates) @ np.linalg.inv(shear), period=2.0 * math.pi)
    assert [exponent.real for exponent in fr.stability(system).exponents] == pytest.approx(rates.tolist(), abs=1e-9)
    assert sum(abs(mu) > 1.0 for mu in fr.stability(system).multipliers) == 2
    lossy = fr.stability(system, "monodromy")
    unknown = [exponent != exponent for exponent in lossy.exponents]
    assert unknown == [math.isinf(error) for error in lossy.exponent_errors] == [False, True, True, True]
    assert -0.9 < lossy.unknown_below < 7.3
    assert "3 multipliers" in lossy.note
    assert "not known" in str(lossy.report().table.rows[1][0])
    json.dumps(lossy.as_dict(), allow_nan=False)
    assert "not all multipliers known: monodromy" in repr(fr.compare(system))


def test_what_is_small_within_a_period_is_known() -> None:
    system = fr.PeriodicSystem([[-4, -1], [0, -0.1]], [[[0.01, 0.02], [0.01, 0.01]]], period=10)
    result = fr.stability(system)
    assert abs(result.multipliers[1]) == pytest.approx(4.247e-18, rel=1e-3)
    assert result.multiplier_errors[1] < 1e-25
    assert result.decay_rate == pytest.approx(0.09998, rel=1e-4)


def test_decay_is_no_faster_than_what_is_not_known() -> None:
    system = fr.PeriodicSystem([[-4, -1], [0, -0.1]], [[[0.01, 0.02], [0.01, 0.01]]], period=10)
    result = fr.stability(system, "monodromy")
    assert result.stable
    assert result.unknown_below < -0.1
    assert result.decay_rate == pytest.approx(0.09998, rel=1e-4)


def test_pairs_that_a_large_one_hides_are_nan_in_arrays() -> None:
    system = fr.HillSystem([[-36.0, 0.0], [0.0, 1.0]], cosines=[[[0.3, 0.3], [0.3, 0.3]]])
    found = fr.systems.multipliers(system)
    assert np.isnan(found).tolist() == [False, False, True, True]
    assert found[0].real == pytest.approx(fr.stability(system).multipliers[0].real, rel=1e-9)
    many = fr.systems.multipliers(fr.HillSystem(np.diag([-36.0, 1.0, 2.0]), cosines=[np.full((3, 3), 0.3)]))
    assert np.isnan(many).tolist() == [False, False, True, True, True, True]


# --- comparison ------------------------------------------------------------------------------------------------------


def test_approximations_contradict_nobody() -> None:
    equation = fr.Mathieu(alpha=0.36371049402800, beta=0.09612171791432)
    compared = fr.compare(equation)
    assert compared.agree
    assert compared.approximations == ("square_wave", "leapfrog")
    assert "approximations that say otherwise: square_wave" in repr(compared)
    assert fr.compare(fr.Meissner(alpha=0.3, beta=-0.2)).approximations == ("leapfrog",)


def test_methods_agree_within_what_they_state() -> None:
    rng = np.random.default_rng(2)
    for i in range(depth(120, 6)):
        values = rng.uniform(0.0, 2.0), rng.uniform(-2.0, 0.5)
        kind = fr.Mathieu if i % 2 else fr.Meissner
        assert fr.compare(kind(*values, damping=float(rng.choice([0.0, 0.1])))).agree, values
        if i % 3 == 0:
            assert fr.compare(known_system(rng, most=3).system).agree, i


def test_a_number_beyond_its_error_is_a_contradiction(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from floquetrod.floquet import comparison

    compute = comparison.run

    def off(method: str, problem: fr.PeriodicSystem) -> fr.results.Stability:
        result = compute(method, problem)
        moved = tuple(exponent + 1e-3 for exponent in result.exponents)
        return replace(result, exponents=moved) if method == "segmented" else result

    monkeypatch.setattr(comparison, "run", off)
    compared = fr.compare(fr.PeriodicSystem([[-1.0, 0.3], [0.2, -0.4]]))
    assert not compared.agree
    assert {"segmented"} == set.intersection(*(set(pair[:2]) for pair in compared.disagreements))


def test_what_no_method_decides_is_not_agreed_upon() -> None:
    assert "no method decides" in repr(fr.compare(fr.PeriodicSystem([[0.0, 1.0], [0.0, 0.0]])))


# --- clusters --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("digits", [15, pytest.param(40, marks=pytest.mark.slow)])
def test_discs_of_a_defective_matrix_hold_the_eigenvalues_of_those_near_it(digits: int) -> None:
    from mpmath.ctx_mp import MPContext

    context = MPContext()
    context.dps = digits
    rng = np.random.default_rng(digits)
    for _ in range(depth(300, 20)):
        n = int(rng.integers(2, 8))
        block = np.diag(rng.choice([0.5, -0.3, 0.1, 0.9], n)) + np.diag(rng.choice([0.0, 1.0, 5.0], n - 1), 1)
        turned = rng.normal(size=(n, n))
        matrix = turned @ block @ np.linalg.inv(turned) if rng.random() < 0.5 else block
        error = float(10.0 ** rng.uniform(-11.0, -4.0))
        if digits == 15:
            discs = spectra.eigenvalue_discs(matrix, error)
        else:
            found = precise_discs(np.array([[context.mpf(v) for v in row] for row in matrix]), error, context)
            discs = None if found is None else found.rounded()
        assert discs is not None
        change = np.outer(rng.normal(size=n), rng.normal(size=n))
        true = np.linalg.eigvals(matrix + change * (0.99 * error / np.linalg.norm(change, 2)))
        rounding = 1e-13 * np.linalg.norm(matrix) / error  # of the eigenvalues computed here, beside the change
        for cluster in discs.clusters:
            inside = (np.abs(true[:, None] - discs.values[cluster]) <= discs.radii[cluster] * (1.0 + rounding)).any(1)
            assert inside.sum() == len(cluster)


def test_one_that_a_cluster_holds_may_be_anywhere_in_it() -> None:
    distances, radii = np.array([[0.0, 1.0, 9.0], [1.0, 0.0, 8.0], [9.0, 8.0, 0.0]]), np.array([0.7, 0.5, 0.1])
    clusters = spectra.touching(distances, radii)
    assert spectra.reaches(distances, radii, clusters).tolist() == [1.5, 1.7, 0.1]
