"""Systems of which some solutions grow by many decades in a period: errors of the coefficients do not hide them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import floquetrod as fr
from tests.conftest import depth

MASS = [[2.0, 0.3], [0.3, 1.0]]
FAST = [[-800.0, 30.0], [30.0, 5.0]]
WAVE = [[90.0, 4.0], [4.0, 3.0]]


@pytest.mark.parametrize("method", ["monodromy", pytest.param("half_period", marks=pytest.mark.slow)])
@pytest.mark.parametrize("scale", [1.0, pytest.param(4.0, marks=pytest.mark.slow)])
def test_fast_growth_is_decided_beside_rounded_coefficients(method: str, scale: float) -> None:
    system = fr.HillSystem(scale * np.array(FAST), [scale * np.array(WAVE)], mass=MASS, period=3.0)
    found = fr.stability(system, method)
    exact = fr.stability(system, "reference")
    assert found.status == exact.status == "unstable"
    assert found.growth_rate * 3.0 > 60.0
    assert abs(found.growth_rate - exact.growth_rate) <= found.exponent_errors[0] < 1e-9
    assert (
        max(x.real + e for x, e in zip(found.exponents, found.exponent_errors, strict=True)) < 1.2 * found.growth_rate
    )


@pytest.mark.slow
def test_fast_growth_of_a_system_without_symmetry() -> None:
    system = fr.HillSystem(
        FAST, [WAVE], [[[1.0, 2.0], [-3.0, 0.5]]], damping=[[0.3, 0.1], [0.0, 0.2]], mass=MASS, period=3.0
    )
    found, exact = fr.stability(system, "monodromy"), fr.stability(system, "reference")
    assert found.status == exact.status == "unstable"
    assert abs(found.growth_rate - exact.growth_rate) <= found.exponent_errors[0] < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("waveform", ["sine", (1.0, 0.3 + 0.4j)])
def test_pressed_tubing_is_unstable_as_simple_marching_says(waveform: str | tuple[complex, ...]) -> None:
    rng = np.random.default_rng(7)
    for _ in range(depth(8, 5)):
        low = float(rng.uniform(1.0, 1.4))
        path = fr.WellPath.arc(length=150.0, inclination=(low, low - 0.1))
        ends = str(rng.choice(["hinged", "clamped", "hinged-clamped"]))
        rod = fr.Rod(
            youngs_modulus=2.06e11, density=7850.0, radius=0.028, inner_radius=0.024, length=100.0, channel_radius=0.06,
            path=path, depth=20.0, ends=ends, damping_rate=0.05,
        )  # fmt: skip
        force = float(rng.uniform(42e3, 55e3))
        load = fr.AxialLoad(
            force, float(rng.uniform(0.02, 0.1)) * force, float(rng.uniform(3.0, 15.0)), waveform=waveform
        )
        found = rod.stability(load)
        assert found.status == "unstable"
        assert found.error < 0.01 * found.growth_rate
        assert found.system is not None
        assert _marched(found.system, rng) == pytest.approx(found.growth_rate, rel=1e-5)


def _marched(system: fr.HillSystem, rng: np.random.Generator) -> float:
    """Return the growth of the fastest of a few solutions that begin at random and have become the fastest ones."""
    first = system.as_periodic_system()
    period, order = float(system.period), first.order
    turns = 2j * np.pi / period * (1.0 + np.arange(len(first.harmonics)))

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        matrix = first.mean + np.tensordot(np.exp(turns * t), first.harmonics, 1).real
        return (matrix @ x.reshape(order, -1)).ravel()

    reached = rng.normal(size=(order, 6))
    for _ in range(8):  # after 4 some are 3e-4 from the fastest still, after 8 none is 1e-7
        basis = np.linalg.qr(reached)[0]
        run = solve_ivp(rates, (0.0, period), basis.ravel(), "DOP853", rtol=1e-8, atol=1e-12)
        reached = run.y[:, -1].reshape(order, -1)
    return float(np.log(np.abs(np.linalg.eigvals(basis.T @ reached)).max())) / period
