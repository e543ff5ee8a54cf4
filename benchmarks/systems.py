"""Multipliers of periodic systems: time by size, two threads, and the verdicts of what people do today.

Set OPENBLAS_NUM_THREADS=1 for times of one thread: the products of large matrices use as many as BLAS likes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import floquetrod as fr
from benchmarks.measure import Row, best_of
from floquetrod.floquet.kernels.system_even import half_period_map, pair_numbers
from floquetrod.floquet.kernels.system_maps import product, segment_maps

Floats = NDArray[np.float64]

ACCURACY = 1e-10
COUPLING = np.array([[0.5, 1.0], [1.0, 0.8]])
SIDE = 10


def run() -> list[Row]:
    """Return the times with what was promised, and the numbers of wrong verdicts."""
    return [*pairs(), *sizes(), *first_order(), *verdicts()]


def multipliers_even(stiffness: Floats, amplitudes: Floats, period: float) -> NDArray[np.complex128]:
    """Return x = mu + 1/mu of one system u'' + (stiffness + sum of amplitudes cos k w t) u = 0."""
    found = half_period_map(stiffness[None], amplitudes[None], [period], ACCURACY)
    x: NDArray[np.complex128] = 2.0 + 4.0 * np.linalg.eigvals(found.b[0].T @ found.c[0])
    return x


def multipliers(mean: Floats, harmonics: NDArray[np.complex128], period: float) -> NDArray[np.complex128]:
    """Return the multipliers of one system x' = A(t) x."""
    whole = product(segment_maps(mean[None], harmonics[None], [period], ACCURACY))
    found: NDArray[np.complex128] = np.linalg.eigvals(whole.matrix[0]).astype(complex)
    return found


def best_loaded(call: Callable[[], object]) -> float:
    """Return the best time of a call after some seconds of calls: what is asked for often is machine code by then."""
    end = time.perf_counter() + 4.0
    while time.perf_counter() < end:
        call()
    return best_of(call)


def coupled(strength: Floats, frequency: Floats) -> tuple[Floats, Floats, Floats]:
    """Return arrays of coupled Mathieu equations, q'' + (diag(1, 4) + strength cos wt COUPLING) q = 0."""
    stiffness = np.broadcast_to(np.diag([1.0, 4.0]), (strength.size, 2, 2)).copy()
    return stiffness, strength.ravel()[:, None, None, None] * COUPLING, 2.0 * math.pi / frequency.ravel()


def pairs() -> list[Row]:
    """Return the times of many pairs of equations, and of one."""
    side = 200
    strength, frequency = np.meshgrid(np.linspace(0.05, 1.0, side), np.linspace(1.0, 5.0, side), indexing="ij")
    systems = coupled(strength, frequency)
    one = best_of(lambda: pair_numbers(*systems, ACCURACY))
    two = best_of(lambda: pair_numbers(*systems, ACCURACY, workers=2))
    single = fr.HillSystem(np.diag([1.0, 4.0]), [0.2 * COUPLING], period=2.0 * math.pi / 3.0)
    alone = best_loaded(lambda: fr.systems.multipliers(single))
    batch = fr.HillSystem(np.diag([1.0, 4.0]), [strength[..., None, None] * COUPLING], period=2.0 * math.pi / frequency)
    public, threads = (best_of(lambda w=w: fr.systems.is_stable(batch, workers=w)) for w in (1, 2))
    half, force = math.pi / frequency, strength[..., None, None] * COUPLING
    square = fr.HillSystem.from_pieces([(half, np.diag([1.0, 4.0]) + force), (half, np.diag([1.0, 4.0]) - force)])
    jumping = best_of(lambda: fr.systems.is_stable(square, workers=1))
    matrices = as_first_order(*(array[0] for array in systems))
    peer = best_of(lambda: dop853_multipliers(*matrices, 1e-10), repeats=3)
    return [
        Row(
            "2 equations, a chart: x, errors, Krein forms", 1e6 * one / side**2, "us", "DOP853", 1e6 * peer, at_most=1.2
        ),
        Row("2 equations, one call: multipliers", 1e6 * alone, "us", "DOP853", 1e6 * peer, at_most=25.0),
        Row("2 equations, a chart: is_stable", 1e6 * public / side**2, "us", "DOP853", 1e6 * peer),
        Row("the same, a square wave", 1e6 * jumping / side**2, "us", "a cosine", 1e6 * public / side**2),
        Row("the same, two threads", 1e6 * threads / side**2, "us", "one thread", 1e6 * public / side**2),
        Row("2 equations, a chart, two threads", 1e6 * two / side**2, "us", "one thread", 1e6 * one / side**2),
    ]


def sizes() -> list[Row]:
    """Return the times of map and eigenvalues of larger systems."""
    rng = np.random.default_rng(1)
    rows = []
    for n, at_most in ((8, 0.12), (32, 1.3), (128, 45.0)):
        random = rng.normal(size=(n, n)) / n
        stiffness = np.diag(16.0 * (np.arange(1.0, n + 1.0) / n) ** 2)
        system = stiffness, 0.2 * (random + random.T)[None], 2.0 * math.pi / 2.3
        name = f"{n} equations, one call"
        ours = best_loaded(lambda system=system: multipliers_even(*system))
        rows.append(against_dop853(name, ours, as_first_order(*system) if n <= 32 else None, at_most, "ms"))
    return rows


def first_order() -> list[Row]:
    """Return the times of systems that have no instant of evenness, or damping of several rates."""
    mean, harmonics, period = as_first_order(np.diag([1.0, 4.0]), 0.2 * COUPLING[None], 2.0 * math.pi / 3.0)
    mean[2:, 2:] = -np.diag([0.004, 0.4])
    damped = mean, harmonics, period
    rotor = ground_resonance(18.0)
    hub = np.asarray(rotor.mean), np.asarray(rotor.harmonics), float(rotor.period)
    return [
        against_dop853("2 damped equations, one call", best_loaded(lambda: multipliers(*damped)), damped, 60.0, "us"),
        against_dop853("ground resonance, 12 rows, one call", best_loaded(lambda: multipliers(*hub)), hub, 0.3, "ms"),
    ]


def against_dop853(
    name: str,
    seconds: float,
    system: tuple[Floats, NDArray[np.complex128], float] | None,
    at_most: float,
    unit: str,
) -> Row:
    """Return the row of a time against that of DOP853 with rtol 1e-10, where a system to integrate is given."""
    scale = {"us": 1e6, "ms": 1e3}[unit]
    if system is None:
        return Row(name, scale * seconds, unit, at_most=at_most)
    peer = best_of(lambda: dop853_multipliers(*system, 1e-10), repeats=3)
    return Row(name, scale * seconds, unit, "DOP853", scale * peer, at_most=at_most)


def verdicts() -> list[Row]:
    """Return how many verdicts are wrong on a chart of coupled Mathieu equations; ours decide, or are not counted."""
    strength, frequency = np.meshgrid(np.linspace(0.05, 1.0, SIDE), np.linspace(1.0, 5.0, SIDE), indexing="ij")
    systems = coupled(strength, frequency)
    stable, decided = decided_verdicts(*systems)
    rows = [Row(f"{SIDE} x {SIDE} chart: left undecided by us", int((~decided).sum()), "points", at_most=0.0)]
    peers: list[tuple[str, Callable[..., NDArray[np.complex128]]]] = [
        ("DOP853 as it comes, |mu| <= 1", lambda *system: dop853_multipliers(*system, 1e-3)),
        ("DOP853 with rtol 1e-10, |mu| <= 1", lambda *system: dop853_multipliers(*system, 1e-10)),
    ]
    for name, peer in peers:
        theirs = [
            bool(abs(peer(*as_first_order(*(array[i] for array in systems)))).max() <= 1.0) for i in range(stable.size)
        ]
        wrong = int(((np.array(theirs) != stable) & decided).sum())
        rows.append(Row(f"{SIDE} x {SIDE} chart: wrong verdicts of {name}", wrong, "points"))
    return rows


def decided_verdicts(*systems: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pairs of equations are stable, and where this is decided by discs and Krein forms."""
    x, errors, krein = pair_numbers(*systems, 1e-13)
    away = np.hypot(np.maximum(abs(x.real) - 2.0, 0.0), x.imag) > errors
    inside = (abs(x.real) + errors < 2.0) & (krein != 0.0)
    stable = inside.all(axis=1)
    return stable, stable | away.any(axis=1)


def as_first_order(
    stiffness: Floats, amplitudes: Floats, period: float
) -> tuple[Floats, NDArray[np.complex128], float]:
    """Return mean, harmonics and period of x' = A(t) x, x = (u, u')."""
    n = len(stiffness)
    mean, harmonics = np.zeros((2 * n, 2 * n)), np.zeros((len(amplitudes), 2 * n, 2 * n), dtype=complex)
    mean[:n, n:], mean[n:, :n] = np.eye(n), -stiffness
    harmonics[:, n:, :n] = -amplitudes
    return mean, harmonics, float(period)


def dop853_multipliers(
    mean: Floats, harmonics: NDArray[np.complex128], period: float, rtol: float
) -> NDArray[np.complex128]:
    """Return the eigenvalues of the monodromy matrix by solve_ivp, DOP853; rtol 1e-3 is its default."""
    n = len(mean)
    rates = 2j * math.pi / period * np.arange(1, len(harmonics) + 1)

    def slope(t: float, x: Floats) -> Floats:
        matrix = mean + np.tensordot(np.exp(rates * t), harmonics, 1).real
        rise: Floats = (matrix @ x.reshape(n, n)).ravel()
        return rise

    atol = min(1e-6, 0.01 * rtol)
    end = solve_ivp(slope, (0.0, period), np.eye(n).ravel(), method="DOP853", rtol=rtol, atol=atol).y[:, -1]
    found: NDArray[np.complex128] = np.linalg.eigvals(end.reshape(n, n)).astype(complex)
    return found


def ground_resonance(speed: float) -> fr.PeriodicSystem:
    """Return a rotor of four blades, one without its lag damper, on an elastic hub, at ``speed`` in rad/s."""
    blade_mass, moment, inertia, hinge = 94.9, 289.1, 1084.7, 0.3048
    dampers = np.array([0.0, 4067.5, 4067.5, 4067.5])
    hub_mass, hub_stiffness, hub_damping = 8026.6, 1240481.8, 51078.7

    def matrix(t: float) -> Floats:
        angle = speed * t + 0.5 * math.pi * np.arange(4)
        sine, cosine = moment * np.sin(angle), moment * np.cos(angle)
        mass, damping, stiffness = (np.zeros((6, 6)) for _ in range(3))
        blades = np.arange(4)
        mass[blades, blades], damping[blades, blades] = inertia, dampers
        stiffness[blades, blades] = hinge * moment * speed**2
        mass[:4, 4], mass[:4, 5], mass[4, :4], mass[5, :4] = -sine, cosine, -sine, cosine
        stiffness[4, :4], stiffness[5, :4] = speed**2 * sine, -(speed**2) * cosine
        damping[4, :4], damping[5, :4] = -2.0 * speed * cosine, -2.0 * speed * sine
        for i in (4, 5):
            mass[i, i], damping[i, i], stiffness[i, i] = hub_mass + 4.0 * blade_mass, hub_damping, hub_stiffness
        rows = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
        return np.vstack([np.hstack([np.zeros((6, 6)), np.eye(6)]), rows])

    return fr.PeriodicSystem.from_function(matrix, 2.0 * math.pi / speed)
