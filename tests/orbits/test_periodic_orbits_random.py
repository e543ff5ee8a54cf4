"""Random systems against DOP853 and Newton's method on the return map: no orbit and no verdict is wrong."""

from __future__ import annotations

import logging
import re
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import floquetrod as fr
from tests.conftest import some

Floats = NDArray[np.float64]

LOG = logging.getLogger(__name__)  # pytest --log-cli-level=INFO shows what was compared
RTOL = 3e-14


class Oscillators:
    """Oscillators coupled by springs, with cubic ones, driven and stiffened in time."""

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        spread = rng.normal(size=(count, count))
        self.stiffness = np.diag(rng.uniform(0.3, 4.0, count)) + 0.05 * (spread + spread.T)
        self.damping, self.cubic = rng.uniform(0.02, 0.4, count), rng.uniform(-0.1, 1.0, count)
        self.push, self.phase = rng.uniform(0.1, 1.0, count), rng.uniform(0.0, 6.0, count)
        self.pulse, self.count = rng.uniform(0.0, 0.6), count

    def __call__(self, t: Any, x: Any, omega: float) -> Any:
        """Return the rates."""
        q, v = x[: self.count], x[self.count :]
        column = (slice(None), *(None,) * (np.ndim(x) - 1))
        drive = self.push[column] * np.cos(omega * t + self.phase[column])
        pull = self.stiffness @ q * (1.0 + self.pulse * np.cos(omega * t)) + self.cubic[column] * q**3
        return np.concatenate([v, drive - self.damping[column] * v - pull])


class Network:
    """Rates that saturate, driven."""

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        self.decay = rng.uniform(0.2, 2.0, count)
        self.links = rng.normal(size=(count, count)) * 1.5 / np.sqrt(count)
        self.push = rng.normal(size=count)

    def __call__(self, t: Any, x: Any, omega: float) -> Any:
        """Return the rates."""
        column = (slice(None), *(None,) * (np.ndim(x) - 1))
        drive = self.push[column] * np.cos(omega * t + 0.3 * np.sin(omega * t))
        return drive - self.decay[column] * x + self.links @ np.tanh(x)


def drawn(seed: int) -> tuple[fr.NonlinearSystem, int]:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    made = Oscillators(rng, count) if seed % 2 else Network(rng, max(2, 2 * count - int(rng.integers(0, 2))))
    size = 2 * count if seed % 2 else len(made.decay)  # type: ignore[union-attr]
    return fr.NonlinearSystem(made, period="2*pi/omega", parameters={"omega": float(rng.uniform(0.6, 2.5))}), size


class SelfExcited:
    """Van der Pol oscillators, close enough in frequency for the drag between them to hold them together."""

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        self.stiffness = np.diag(rng.uniform(0.9, 1.1, count))
        self.drag = rng.uniform(0.5, 1.5) * (np.eye(count) - 1.0 / count)
        self.drive, self.hard, self.count = rng.uniform(0.3, 2.0, count), rng.uniform(0.0, 0.5, count), count

    def __call__(self, t: Any, x: Any) -> Any:
        """Return the rates."""
        q, v = x[: self.count], x[self.count :]
        column = (slice(None), *(None,) * (np.ndim(x) - 1))
        push = self.drive[column] * (1.0 - q**2) * v
        return np.concatenate([v, push - self.drag @ v - self.stiffness @ q - self.hard[column] * q**3])


def autonomous_reference(orbit: fr.results.PeriodicOrbit) -> tuple[float, NDArray[np.complex128]]:
    """Return the period and the multipliers but for the trivial one, from the neighbourhood of an orbit."""
    system, n = orbit.system, len(orbit.states[0])
    state, period = orbit.states[0] * (1.0 + 1e-4 * np.cos(np.arange(n))), orbit.period * (1.0 + 1e-4)
    anchor = system.rates([0.0], state[None])[0]

    def rates(t: float, y: Floats) -> Floats:
        matrix = system.jacobians([t], y[None, :n])[0]
        return np.concatenate([system.rates([t], y[None, :n])[0], (matrix @ y[n:].reshape(n, n)).ravel()])

    for _ in range(5):
        start = np.concatenate([state, np.eye(n).ravel()])
        found = solve_ivp(rates, (0.0, period), start, method="DOP853", rtol=RTOL, atol=1e-14).y[:, -1]
        matrix, end = found[n:].reshape(n, n), found[:n]
        last = system.rates([0.0], end[None])[0]
        core = np.block([[matrix - np.eye(n), last[:, None]], [anchor[None], np.zeros((1, 1))]])
        step = -np.linalg.solve(core, np.append(end - state, 0.0))
        state, period = state + step[:n], period + step[n]
    multipliers = np.linalg.eigvals(matrix)
    return period, np.delete(multipliers, np.abs(multipliers - 1.0).argmin())


def reference(system: fr.NonlinearSystem, state: Floats, period: float) -> tuple[Floats, Floats]:
    """Return the state at time 0 of the orbit near a state, and the map over a period: DOP853, Newton's method."""
    n = len(state)

    def rates(t: float, y: Floats) -> Floats:
        matrix = system.evaluated.by_differences(np.array([t]), y[None, :n], system.parameters)[0]
        return np.concatenate([system.rates([t], y[None, :n])[0], (matrix @ y[n:].reshape(n, n)).ravel()])

    def plain(t: float, y: Floats) -> Floats:
        return system.rates([t], y[None])[0]

    start = np.concatenate([state, np.eye(n).ravel()])
    found = solve_ivp(rates, (0.0, period), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    matrix = found[n:].reshape(n, n)
    for _ in range(6):
        end = solve_ivp(plain, (0.0, period), state, method="DOP853", rtol=RTOL, atol=1e-15).y[:, -1]
        step = np.linalg.solve(np.eye(n) - matrix, end - state)
        state = state + step
    start = np.concatenate([state, np.eye(n).ravel()])
    found = solve_ivp(rates, (0.0, period), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return state, found[n:].reshape(n, n)


def found(system: fr.NonlinearSystem, size: int) -> fr.results.PeriodicOrbit | None:
    """Return the orbit that motion from a small state leads to, of several periods where it doubles; None in chaos."""
    start = 0.1 * np.ones(size)
    try:
        return fr.periodic_orbit(system, start)
    except fr.NoOrbitError:
        return None
    except ValueError as error:
        doubled = re.search(r"returns after (\d) periods", str(error))
        if doubled is None:
            raise
        return fr.periodic_orbit(system, start, int(doubled[1]) * float(system.period or 0.0))


def check(orbit: fr.results.PeriodicOrbit) -> None:
    """Compare an orbit, its multipliers and its verdict with the reference."""
    size, scale, verdict = len(orbit.states[0]), orbit.point.scale, orbit.stability
    state, matrix = reference(orbit.system, orbit.states[0] + 1e-4 * scale * np.cos(np.arange(size)), orbit.period)
    gap = float((np.abs(state - orbit.states[0]) / scale).max())
    assert gap <= orbit.error + 1e-13 * np.linalg.cond(np.eye(size) - matrix)
    true, vectors = np.linalg.eig(matrix)
    largest = float(np.abs(true).max())
    doubt = 1e-10 * max(largest, 1.0) * np.linalg.cond(vectors)  # of the reference
    for mu, error in zip(verdict.multipliers, verdict.multiplier_errors, strict=True):
        assert np.abs(true - mu).min() <= error + doubt
    assert abs(largest - 1.0) > doubt
    assert verdict.status == ("stable" if largest < 1.0 else "unstable")
    LOG.info("%d %s %.1e %.1e %.1e %.6f", size, verdict.status, orbit.error, gap, verdict.error, largest)


@pytest.mark.slow
@pytest.mark.parametrize("tens", some(range(20), 6, 2))
def test_random_forced_systems(tens: int) -> None:
    drawn_ones = [drawn(seed) for seed in range(10 * tens, 10 * tens + 10)]
    orbits = [orbit for orbit in (found(*each) for each in drawn_ones) if orbit is not None]
    assert len(orbits) >= 8
    for orbit in orbits:
        check(orbit)


@pytest.mark.slow
@pytest.mark.parametrize("fives", some(range(6), 2, 1))
def test_random_oscillators_that_excite_themselves(fives: int) -> None:
    for seed in range(5 * fives, 5 * fives + 5):
        rng = np.random.default_rng(seed)
        count = int(rng.integers(1, 4))
        system = fr.NonlinearSystem(SelfExcited(rng, count))
        orbit = fr.periodic_orbit(system, np.concatenate([2.0 * np.ones(count), np.zeros(count)]))
        period, multipliers = autonomous_reference(orbit)
        verdict = orbit.stability
        assert abs(orbit.period - period) <= orbit.period_error + 1e-12 * period
        assert orbit.trivial_multiplier_less_1 is not None
        assert orbit.trivial_multiplier_less_1 < 1e-10
        for mu, error in zip(verdict.multipliers, verdict.multiplier_errors, strict=True):
            assert np.abs(multipliers - mu).min() <= error + 1e-10
        assert verdict.status == ("stable" if float(np.abs(multipliers).max()) < 1.0 else "unstable")
        LOG.info(
            "%d %s %.3g %.1e %.1e", 2 * count, verdict.status, period, orbit.period_error, abs(orbit.period - period)
        )
