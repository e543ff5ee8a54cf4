"""Special points of branches against DOP853 at 3e-14 with Newton's method on an extended map, and against averaging."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import floquetrod as fr

Floats = NDArray[np.float64]
Flow = Callable[[Floats, float], tuple[Floats, Floats, Floats]]

DAMPING = {"damped": 0.2, "weakly damped": 0.02}


def duffing(t: Any, x: Any, omega: float, c: float, force: float, cubic: float) -> Any:
    return x[1], force * np.cos(omega * t) - c * x[1] - x[0] - cubic * x[0] ** 3


def roessler(t: Any, x: Any, c: float) -> Any:
    return -x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - c)


def marched(rates: Any, matrix: Any, by_parameter: Any, start: Floats, span: float) -> tuple[Floats, Floats, Floats]:
    """Return the state, its derivatives with the start, and with the parameter, after a time."""
    n = len(start)

    def variational(t: float, y: Floats) -> Floats:
        jacobian = matrix(t, y[:n])
        flows = y[n:].reshape(n, n + 1)
        grown = jacobian @ flows
        grown[:, n] += by_parameter(t, y[:n])
        return np.concatenate([rates(t, y[:n]), grown.ravel()])

    first = np.concatenate([start, np.hstack([np.eye(n), np.zeros((n, 1))]).ravel()])
    found = solve_ivp(variational, (0.0, span), first, method="DOP853", rtol=3e-14, atol=3e-14)
    flows = found.y[n:, -1].reshape(n, n + 1)
    return found.y[:n, -1], flows[:, :n], flows[:, n]


def duffing_map(c: float, force: float, cubic: float) -> Flow:
    """Return the map over a period in the phase tau = omega t, of x and dx/dtau, and its derivatives."""

    def flow(start: Floats, omega: float) -> tuple[Floats, Floats, Floats]:
        def rates(tau: float, x: Floats) -> Floats:
            return np.array([x[1], (force * np.cos(tau) - c * omega * x[1] - x[0] - cubic * x[0] ** 3) / omega**2])

        def matrix(tau: float, x: Floats) -> Floats:
            return np.array([[0.0, 1.0], [-(1.0 + 3.0 * cubic * x[0] ** 2) / omega**2, -c / omega]])

        def by_omega(tau: float, x: Floats) -> Floats:
            rest = force * np.cos(tau) - x[0] - cubic * x[0] ** 3
            return np.array([0.0, -2.0 * rest / omega**3 + c * x[1] / omega**2])

        return marched(rates, matrix, by_omega, start, 2.0 * math.pi)

    return flow


def crossing(flow: Flow, start: Floats, value: float, at: float) -> float:
    """Return the parameter at which the map of an orbit near a start has the multiplier ``at``.

    Newton's method on the orbit at each value inside the secant method on det(M - at); a fold by the secant method over
    states instead, where the orbit is not a function of the parameter: the first state is fixed, the parameter free.
    """

    def orbit(fixed: float) -> tuple[Floats, float, Floats]:
        x, p = start.copy(), value
        for _ in range(30):
            end, matrix, by_p = flow(x, p)
            if at > 0.0:  # unknowns: the other states and the parameter
                x[0] = fixed
                system = np.hstack([(matrix - np.eye(len(x)))[:, 1:], by_p[:, None]])
                step = np.linalg.solve(system, x - end)
                x[1:] += step[:-1]
                p += step[-1]
            else:
                p = fixed
                step = np.linalg.solve(matrix - np.eye(len(x)), x - end)
                x = x + step
            if np.abs(step).max() < 1e-13:
                break
        start[:] = x
        return x, p, flow(x, p)[1]

    def test(fixed: float) -> float:
        _, _, matrix = orbit(fixed)
        return float(np.linalg.det(matrix - at * np.eye(len(matrix))))

    first = float(start[0]) if at > 0.0 else value
    low, high = first * (1.0 - 2e-3), first * (1.0 + 2e-3)
    found = float(brentq(test, low, high, xtol=1e-13, rtol=1e-14))
    return orbit(found)[1]


def duffing_branch(kind: str) -> fr.Branch:
    c = DAMPING[kind]
    given = {"omega": 1.2, "c": c, "force": 1.0, "cubic": 1.0}
    if kind == "weakly damped":  # of size 1 at resonance
        given |= {"omega": 0.7, "force": 0.02, "cubic": 0.1}
    system = fr.NonlinearSystem(duffing, period="2*pi/omega", parameters=given)
    return fr.follow(fr.periodic_orbit(system, [0.1, 0.0]), {"omega": (0.7, 3.0)})


@pytest.mark.slow
@pytest.mark.parametrize("kind", DAMPING)
def test_folds_of_a_duffing_oscillator(kind: str) -> None:
    branch = duffing_branch(kind)
    given = branch.orbits[0].system.parameters
    flow = duffing_map(given["c"], given["force"], given["cubic"])
    assert [point.kind for point in branch.special_points] == ["fold", "fold"]
    for point in branch.special_points:
        start = point.orbit.states[0] / np.array([1.0, point.value])
        known = crossing(flow, start, point.value, 1.0)
        assert abs(point.value - known) < 1e-10
        assert point.error < 1e-10


@pytest.mark.slow
def test_folds_against_averaging() -> None:
    """Averaged: (w^2 - 1 - 3 k a^2 / 4)^2 a^2 + (c w a)^2 = f^2, with errors of second order in k a^2, c and f."""
    branch = duffing_branch("weakly damped")
    c, f, k = 0.02, 0.02, 0.1

    amplitude = np.linspace(0.05, 1.2 * f / c, 1_000_001)
    middle = 1.0 + 0.75 * k * amplitude**2 - 0.5 * c**2
    with np.errstate(invalid="ignore"):  # no frequency has amplitudes beyond the peak
        width = np.sqrt(middle**2 - (1.0 + 0.75 * k * amplitude**2) ** 2 + (f / amplitude) ** 2)
    right, left = np.sqrt(middle + width), np.sqrt(middle - width)
    falling = np.flatnonzero((right[1:-1] < right[:-2]) & (right[1:-1] < right[2:])) + 1
    averaged = (float(right[falling[0]]), float(max(np.nanmax(left), np.nanmax(right[falling[0] :]))))
    # The backbone's next term, 15 (k a^2)^2 / 256, at the amplitudes of the folds.
    for point, known in zip(sorted(branch.special_points, key=lambda each: each.value), averaged, strict=True):
        assert abs(point.value - known) < 15.0 / 256.0 * (k * point.amplitude[0] ** 2) ** 2


@pytest.mark.slow
def test_a_resonance_against_a_scan() -> None:
    """Sweeps up and down by DOP853 jump where the branch folds."""
    branch = duffing_branch("damped")
    upper, lower = sorted((point.value for point in branch.special_points), reverse=True)
    flow = duffing_map(0.2, 1.0, 1.0)
    for edge, sign in ((upper, 1.0), (lower, -1.0)):
        kept = [orbit for orbit, value in zip(branch.orbits, branch.values, strict=True) if orbit.status == "stable"]
        side = [each for each in kept if sign * (edge - each.system.parameters["omega"]) > 2e-3]
        near = min(side, key=lambda each: abs(each.system.parameters["omega"] - edge))
        state = near.states[0] / np.array([1.0, near.system.parameters["omega"]])
        for share in (-1e-3, 1e-3):  # before it, motion stays near; after it, it leaves
            x, omega = state.copy(), edge + sign * share
            for _ in range(250):
                x = flow(x, omega)[0]
            settled = fr.periodic_orbit(near.system.with_parameters(omega=omega), x * [1.0, omega])
            amplitude = float(np.ptp(settled(np.linspace(0.0, settled.period, 400))[:, 0])) / 2.0
            jumped = abs(amplitude - float(near.states[:, 0].max())) > 0.3
            assert jumped == (share > 0.0), (edge, share, amplitude)


def roessler_test(c: float, x: Floats, period: float) -> tuple[Floats, float, float]:
    """Return the orbit on the plane x_0' = 0 at a value of the parameter, its period, and det(M + 1) without the 1."""
    for _ in range(40):

        def rates(t: float, y: Floats) -> Floats:
            return np.asarray(roessler(t, y, c), dtype=float)

        def matrix(t: float, y: Floats) -> Floats:
            return np.array([[0.0, -1.0, -1.0], [1.0, 0.2, 0.0], [y[2], 0.0, y[0] - c]])

        end, whole, _ = marched(rates, matrix, lambda t, y: np.zeros(3), x, period)
        row = np.array([0.0, -1.0, -1.0])
        system = np.zeros((4, 4))
        system[:3, :3], system[:3, 3], system[3, :3] = whole - np.eye(3), rates(0.0, end), row
        step = np.linalg.solve(system, -np.concatenate([end - x, [row @ x]]))
        x, period = x + step[:3], period + step[3]
        if np.abs(step).max() < 1e-12:
            break
    others = np.linalg.eigvals(whole)
    # the one near -1: the others are 1 and nearly 0
    mu = others[np.abs(others + 1.0).argmin()].real
    return x, period, float(mu + 1.0)


@pytest.mark.slow
def test_three_period_doublings_of_roesslers_equations() -> None:
    system = fr.NonlinearSystem(roessler, parameters={"c": 2.6})
    orbit = fr.periodic_orbit(system, [1.0, 1.0, 0.0], 5.75)
    ends = (3.0, 3.9, 4.14)
    values = []
    for end in ends:
        branch = fr.follow(orbit, {"c": (orbit.system.parameters["c"], end)}, longest=0.1)
        (point,) = [each for each in branch.special_points if each.kind == "period doubling"]
        at_crest = np.array([point.orbit(t) for t in np.linspace(0.0, point.orbit.period, 4000)])
        turning = -at_crest[:, 1] - at_crest[:, 2]
        k = int(np.flatnonzero((turning[:-1] > 0.0) & (turning[1:] <= 0.0))[0])
        state = {"x": at_crest[k], "period": point.orbit.period}

        def test(c: float, state: dict[str, Any] = state) -> float:
            state["x"], state["period"], found = roessler_test(c, state["x"], state["period"])
            return found

        known = float(brentq(test, point.value - 1e-4, point.value + 1e-4, xtol=1e-12))
        assert abs(point.value - known) < 1e-8
        assert point.error < 1e-8
        values.append(point.value)
        orbit = point.switch()
    ratio = (values[1] - values[0]) / (values[2] - values[1])
    assert 3.0 < ratio < 4.7  # Feigenbaum's 4.669 in the end
