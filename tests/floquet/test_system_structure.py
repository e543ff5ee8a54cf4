"""Verdicts that follow from the structure of the matrices: Jordan blocks, heavy damping, norms that are kept."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.multipliers import whole_period_maps
from tests.conftest import depth


def every_door(system: Any) -> set[str]:
    """Return the verdicts of a call, of arrays and of a batch, and that of a proof where there is one."""
    names = {True: "stable", False: "unstable"}
    batch = fr.systems.stack([system, system])
    found = {fr.stability(system).status, names[fr.systems.is_stable(system)]}
    found |= {names[bool(one)] for one in fr.systems.is_stable(batch)}
    proof = fr.certify(system)
    return found | ({proof.status} - {"undecided"})


def proved(system: Any) -> str:
    return fr.certify(system).status


# --- Jordan blocks ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [2, 3, 5, 8, 12, 20])
@pytest.mark.parametrize("rate", [-1.0, 0.3])
def test_chains_are_decided(n: int, rate: float) -> None:
    system = fr.PeriodicSystem(rate * np.eye(n) + np.eye(n, k=1))
    status = "stable" if rate < 0.0 else "unstable"
    assert every_door(system) == {status}
    assert proved(system) == status
    result = fr.stability(system)
    assert all(abs(e - rate) <= error for e, error in zip(result.exponents, result.exponent_errors, strict=True))
    assert max(result.exponent_errors) < 1e-3


@pytest.mark.parametrize("coupling", [1.0, 1e3, 1e6, 1e12])
def test_a_strong_coupling_one_way_is_no_growth(coupling: float) -> None:
    system = fr.PeriodicSystem([[-1.0, coupling], [0.0, -1.0]])
    assert every_door(system) == {"stable"}
    assert all(abs(e + 1.0) < 1e-6 for e in fr.stability(system).exponents)


def test_defective_multipliers_in_any_coordinates() -> None:
    rng = np.random.default_rng(3)
    for _ in range(depth(60, 10)):
        n = int(rng.integers(2, 7))
        rate = float(rng.choice([-1.0, -0.3, 0.2, 0.9]))
        turned = np.linalg.qr(rng.normal(size=(n, n)))[0] @ np.diag(rng.uniform(0.5, 2.0, n))
        system = fr.PeriodicSystem(turned @ (rate * np.eye(n) + np.eye(n, k=1)) @ np.linalg.inv(turned))
        assert every_door(system) == {"stable" if rate < 0.0 else "unstable"}


@pytest.mark.slow
def test_defective_multipliers_of_varying_coefficients() -> None:
    rng = np.random.default_rng(8)
    for _ in range(depth(60, 10)):
        n = int(rng.integers(2, 5))
        rate, decay = float(rng.uniform(-1.0, 1.0)), 1e-3
        mean = (rate if abs(rate) > decay else decay) * np.eye(n) + np.triu(rng.normal(size=(n, n)), 1)
        waves = [0.5 * np.eye(n) + np.triu(rng.normal(size=(n, n)), 1)]
        assert every_door(fr.PeriodicSystem(mean, waves)) == {"stable" if mean[0, 0] < 0.0 else "unstable"}


def test_what_drifts_stays_undecided() -> None:
    for system in (
        fr.PeriodicSystem([[0.0, 1.0], [0.0, 0.0]]),
        fr.PeriodicSystem(np.eye(3, k=1)),
    ):
        assert fr.stability(system).status == "undecided"
        assert fr.certify(system, max_digits=30).status == "undecided"


def test_levels_of_what_is_only_driven() -> None:
    sizes = np.array([[[1.0, 4.0, 0.0], [0.0, 2.0, 8.0], [0.0, 0.0, 3.0]]])
    levels = whole_period_maps._levels(sizes)
    assert levels is not None
    scaled = sizes * levels[:, None, :] / levels[:, :, None]
    assert np.triu(scaled[0], 1).max() <= 4e-6
    assert whole_period_maps._levels(np.ones((1, 3, 3))) is None
    assert whole_period_maps._levels(np.eye(3)[None]) is None


# --- heavy damping ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "damping", [1e2, 1e8, *(pytest.param(damping, marks=pytest.mark.slow) for damping in (1e4, 1e5, 1e6))]
)
def test_heavy_damping_is_stable_and_its_opposite_is_not(damping: float) -> None:
    damped = fr.HillSystem([[1.0]], [[[0.5]]], damping=[[damping]], period=1.0)
    assert every_door(damped) == {"stable"}
    driven = fr.HillSystem([[1.0]], [[[0.5]]], damping=[[-damping]], period=1.0)
    assert fr.stability(driven).status == "unstable"
    assert fr.systems.is_stable(driven) is False
    assert proved(driven) in ("unstable", "undecided")


def test_one_equation_with_heavy_damping_is_the_scalar_one() -> None:
    rng = np.random.default_rng(6)
    for _ in range(depth(40, 5)):
        mean, wave = float(rng.uniform(-1.0, 2.0)), float(rng.uniform(-3.0, 3.0))
        damping, period = float(10.0 ** rng.uniform(0.0, 4.4)), float(rng.uniform(0.5, 2.0))
        scalar = fr.stability(fr.Hill(-mean, (-wave,), period=period, damping=0.5 * damping))
        system = fr.stability(fr.HillSystem([[mean]], [[[wave]]], damping=[[damping]], period=period))
        assert scalar.status == system.status, (mean, wave, damping, period)


@pytest.mark.slow
def test_heavy_damping_of_several_equations() -> None:
    rng = np.random.default_rng(9)
    for _ in range(depth(12, 3)):
        n = int(rng.integers(2, 5))
        half = rng.normal(size=(n, n))
        stiffness, wave = half @ half.T + np.eye(n), rng.normal(size=(n, n))
        wave = 0.4 * (wave + wave.T) / np.abs(np.linalg.eigvalsh(wave + wave.T)).max()
        damping = np.diag(10.0 ** rng.uniform(3.0, 8.0, n))
        assert every_door(fr.HillSystem(stiffness, [wave], damping=damping, period=1.0)) == {"stable"}


def test_a_stiffness_that_pushes_is_not_overdamped_to_rest() -> None:
    system = fr.HillSystem([[-1.0]], [[[0.5]]], damping=[[1e4]], period=1.0)
    assert fr.stability(system).status == "unstable"
    assert proved(system) != "stable"


def test_a_damping_that_drives_is_not_overdamped_to_rest() -> None:
    system = fr.HillSystem([[1.35, 0.05], [0.05, 1.35]], [0.2 * np.eye(2)], damping=-1e8 * np.eye(2), period=1.0)
    assert every_door(system) == {"unstable"}
    assert proved(system) == "unstable"


# --- norms that are kept ---------------------------------------------------------------------------------------------


def skew(rng: np.random.Generator, n: int) -> np.ndarray:
    matrix = rng.normal(size=(n, n))
    return matrix - matrix.T


@pytest.mark.slow
def test_skew_symmetric_systems_are_stable_by_every_door() -> None:
    rng = np.random.default_rng(1)
    for _ in range(depth(20, 4)):
        n = int(rng.integers(2, 7))
        waves = [skew(rng, n) for _ in range(int(rng.integers(0, 3)))]
        system = fr.PeriodicSystem(skew(rng, n), waves, waves[:1], period=float(rng.uniform(0.5, 8.0)))
        assert system.keeps_norm
        assert every_door(system) == {"stable"}
        assert proved(system) == "stable"
        for result in fr.compare(system).results:
            assert result.status == "stable", result
            assert all(exponent.real == 0.0 for exponent in result.exponents)
        assert np.abs(fr.systems.multipliers(system)) == pytest.approx(1.0, abs=1e-12)
        assert fr.stability(system).growth_rate == fr.systems.growth_rate(system) == 0.0


def test_their_exponents_are_those_of_the_map() -> None:
    system = fr.PeriodicSystem(skew(np.random.default_rng(5), 5), [skew(np.random.default_rng(6), 5)])
    turns = sorted(np.angle(np.linalg.eigvals(fr.stability(system).monodromy.matrix)))
    found = sorted(exponent.imag * system.period for exponent in fr.stability(system).exponents)
    assert found == pytest.approx(turns, abs=1e-9)


def test_skew_symmetric_pieces_and_functions() -> None:
    rng = np.random.default_rng(12)
    jumping = fr.PeriodicSystem.from_pieces([(0.5, skew(rng, 3)), (1.0, skew(rng, 3))])
    assert jumping.structure == "unitary"
    assert every_door(jumping) == {"stable"}
    first, second = skew(rng, 4), skew(rng, 4)
    sampled = fr.PeriodicSystem.from_function(lambda t: first + second * math.exp(math.sin(t)), 2.0 * math.pi)
    assert sampled.structure == "unitary"
    assert fr.stability(sampled).status == "stable"


def test_one_ulp_off_keeps_no_norm() -> None:
    matrix = skew(np.random.default_rng(7), 3)
    matrix[0, 1] = np.nextafter(matrix[0, 1], 9.0)
    system = fr.PeriodicSystem(matrix)
    assert not system.keeps_norm
    assert system.structure == "general"


def test_what_turns_without_stiffness() -> None:
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert every_door(fr.HillSystem(np.zeros((2, 2)), gyroscopic=turn)) == {"stable"}
    assert every_door(fr.HillSystem(np.eye(4), gyroscopic=np.kron(np.eye(2), turn))) == {"stable"}
    singular = np.zeros((3, 3))
    singular[:2, :2] = turn
    assert fr.stability(fr.HillSystem(np.zeros((3, 3)), gyroscopic=singular)).status == "unstable"
    assert fr.stability(fr.HillSystem(np.zeros((2, 2)))).status == "unstable"
