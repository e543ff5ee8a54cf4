"""Periodic orbits with multipliers, and a branch of them: time and error beside SKHiPPR, and shooting by DOP853.

All start from the same guess.  SKHiPPR is left out where it is not installed; see `benchmarks.skhippr`.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import floquetrod as fr
from benchmarks.measure import Row, best_of
from benchmarks.skhippr import PEER

Floats = NDArray[np.float64]


def van_der_pol(t: Any, x: Any, mu: float) -> Any:
    """Return the rates of van der Pol's oscillator."""
    return x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]


def duffing(t: Any, x: Any, omega: float) -> Any:
    """Return the rates of a forced Duffing oscillator."""
    return x[1], np.cos(omega * t) - 0.2 * x[1] - x[0] - x[0] ** 3


class Case(NamedTuple):
    """An orbit: the system, where to start, about its period, its multipliers but for the trivial one, harmonics."""

    name: str
    system: fr.NonlinearSystem
    start: tuple[float, float]
    period: float
    multipliers: tuple[complex, ...]
    harmonics: int


DUFFING = fr.NonlinearSystem(duffing, period="2*pi/omega", parameters={"omega": 1.2})
PAIR = -0.5151904349744719 + 0.2924014755250478j
CASES = [
    Case("Duffing", DUFFING, (1.2, 0.6), 2.0 * math.pi / 1.2, (PAIR, PAIR.conjugate()), 25),
    *(
        Case(
            f"van der Pol, mu = {mu:g}", fr.NonlinearSystem(van_der_pol, parameters={"mu": mu}), (2.0, 0.0), near, m, h
        )
        for mu, near, m, h in ((1.0, 6.66, (8.596950636038e-4,), 45), (3.0, 8.86, (6.98947562608e-16,), 100))
    ),
]
"""Multipliers by DOP853 at 3e-14 and Newton's method; the smallest from the integral of the trace along the orbit."""


def run() -> list[Row]:
    """Return times and errors of multipliers, ours and theirs."""
    rows = []
    for case in CASES:
        peers = {"DOP853 1e-10": lambda case=case: shooting(case)}
        if importlib.util.find_spec("skhippr") is not None:
            peers[PEER] = balance(case)
        ours, found = best_of(lambda case=case: orbit(case)), orbit(case)
        for name, call in peers.items():
            rows.append(Row(f"{case.name}", 1e3 * ours, "ms", name, 1e3 * best_of(call, repeats=3)))
        rows.append(Row(f"{case.name}, error of multipliers", missed(case, found), "of the largest, or 1"))
        for name, call in peers.items():
            rows.append(Row(f"{case.name}, that of {name}", missed(case, call()), "of the largest, or 1"))
    return [*rows, *branches()]


SWEPT, FOLDS = (0.5, 2.8), (2.2131659546287503, 1.635305551337615)
"""Range of omega of the branch of Duffing orbits, and its folds by DOP853 and Newton's method, to about 1e-14."""


def branches() -> list[Row]:
    """Return times of the branch round both folds, per orbit, and errors of the folds, ours and theirs."""
    start = fr.periodic_orbit(DUFFING.with_parameters(omega=SWEPT[0]), (0.6, 0.0))
    ours, found = best_of(lambda: follow(start), repeats=3), follow(start)
    folds = [point.value for point in found.special_points if point.kind == "fold"]
    name, count = "Duffing branch", len(found.orbits)
    rows = [Row(f"{name}, error of folds", float(np.abs(np.array(folds) - FOLDS).max()), "rad/s")]
    if importlib.util.find_spec("skhippr") is None:
        return [*rows, Row(f"{name}, {count} orbits", 1e3 * ours, "ms")]
    call = continuation(start)
    theirs, values = best_of(call, repeats=3), call()
    steps = np.diff(values)
    turns = values[1 + np.flatnonzero(steps[1:] * steps[:-1] < 0.0)]
    missed_by = float(np.abs(turns - FOLDS).max())
    return [
        Row(f"{name}, {count} orbits", 1e3 * ours, "ms", f"{PEER}, {len(values)}", 1e3 * theirs),
        Row(f"{name}, an orbit of it", 1e3 * ours / count, "ms", PEER, 1e3 * theirs / len(values)),
        *rows,
        Row(f"{name}, that of {PEER}, which does not locate folds", missed_by, "rad/s"),
    ]


def follow(start: fr.results.PeriodicOrbit) -> fr.Branch:
    """Return our branch, in steps about as long as theirs."""
    return fr.follow(start, over={"omega": SWEPT}, longest=0.1)


def continuation(start: fr.results.PeriodicOrbit) -> Callable[[], Floats]:
    """Return a call of SKHiPPR's pseudo-arclength continuation, which returns the values of omega it passes."""
    from skhippr.cycles.hbm import HBMSystem
    from skhippr.Fourier import Fourier
    from skhippr.odes.nonautonomous import Duffing
    from skhippr.solvers.continuation import pseudo_arclength_continuator
    from skhippr.solvers.newton import NewtonSolver
    from skhippr.stability.KoopmanHillProjection import KoopmanHillSubharmonic

    fourier = Fourier(N_HBM=25, L_DFT=200, n_dof=2, real_formulation=True)
    guess = fourier.DFT(np.asarray(start(fourier.time_samples(SWEPT[0]))).T)

    def call() -> Floats:
        ode = Duffing(t=0.0, x=start.states[0], alpha=1.0, beta=1.0, delta=0.2, F=1.0, omega=SWEPT[0])
        method = KoopmanHillSubharmonic(fourier=fourier, tol=1e-4, autonomous=False)
        system = HBMSystem(ode, SWEPT[0], fourier, guess.copy(), stability_method=method)
        solver, values = NewtonSolver(tolerance=1e-10, verbose=False), []
        for point in pseudo_arclength_continuator(
            system, solver, 0.02, (1e-4, 0.2), 1, continuation_parameter="omega", num_steps=2000
        ):
            values.append(float(np.squeeze(point.omega)))
            if not 0.4 <= values[-1] <= SWEPT[1]:
                break
        return np.array(values)

    return call


def missed(case: Case, found: Any) -> float:
    """Return the largest error of a multiplier found for each that is known."""
    return max(float(np.abs(np.asarray(found) - known).min()) for known in case.multipliers)


def orbit(case: Case) -> tuple[complex, ...]:
    """Return our multipliers."""
    return fr.periodic_orbit(case.system, case.start, case.period).stability.multipliers


def shooting(case: Case) -> NDArray[np.complex128]:
    """Return multipliers by Newton's method on the map over a period, as most people write it."""
    system, autonomous = case.system, case.system.is_autonomous
    given, state, period = dict(system.parameters), np.array(case.start), case.period
    anchor = np.array(system.function(0.0, state, **given))

    def rates(t: float, y: Floats) -> Floats:
        x, maps = y[:2], y[2:].reshape(2, 2)
        return np.concatenate([system.function(t, x, **given), (system.jacobians([t], x[None])[0] @ maps).ravel()])

    for _ in range(20):
        start = np.concatenate([state, np.eye(2).ravel()])
        end = solve_ivp(rates, (0.0, period), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        matrix, gap = end[2:].reshape(2, 2), end[:2] - state
        core = matrix - np.eye(2)
        if autonomous:
            last = np.array(system.function(period, end[:2], **given))
            core = np.block([[core, last[:, None]], [anchor[None], np.zeros((1, 1))]])
            gap = np.append(gap, 0.0)
        step = -np.linalg.solve(core, gap)
        state, period = state + step[:2], period + (step[2] if autonomous else 0.0)
        if np.abs(step).max() < 1e-9:
            break
    return np.linalg.eigvals(matrix)


def balance(case: Case) -> Callable[[], NDArray[np.complex128]]:
    """Return a call of SKHiPPR: harmonic balance, its Newton solver, and multipliers by the Koopman-Hill projection."""
    from skhippr.cycles.hbm import HBMSystem
    from skhippr.Fourier import Fourier
    from skhippr.odes.autonomous import Vanderpol
    from skhippr.odes.nonautonomous import Duffing
    from skhippr.solvers.newton import NewtonSolver
    from skhippr.stability.KoopmanHillProjection import KoopmanHillSubharmonic

    omega, x = 2.0 * math.pi / case.period, np.array(case.start)
    fourier = Fourier(N_HBM=case.harmonics, L_DFT=8 * case.harmonics, n_dof=2, real_formulation=True)
    period = solve_ivp(
        lambda t, y: case.system.function(t, y, **case.system.parameters),
        (0.0, case.period),
        x,
        t_eval=fourier.time_samples(omega),
        rtol=1e-8,
        atol=1e-10,
    )
    guess = fourier.DFT(period.y)

    def call() -> NDArray[np.complex128]:
        if case.system.is_autonomous:
            ode: Any = Vanderpol(x=x, nu=case.system.parameters["mu"])
        else:
            ode = Duffing(t=0.0, x=x, alpha=1.0, beta=1.0, delta=0.2, F=1.0, omega=omega)
        method = KoopmanHillSubharmonic(fourier=fourier, tol=1e-4, autonomous=case.system.is_autonomous)
        system = HBMSystem(ode, omega, fourier, guess.copy(), stability_method=method)
        NewtonSolver(tolerance=1e-10, verbose=False).solve(system)
        return np.asarray(system.determine_stability(update=True)[1])

    return call
