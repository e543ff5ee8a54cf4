"""Kicks against friction: a map like the paper's Figure 6(a), and a chart of critical kicks.

The map is on one thread; leapfrog is extrapolated from a sample of its mode equations.
"""

from __future__ import annotations

import time

import numpy as np

import floquetrod as fr
from benchmarks.measure import Row, best_of
from floquetrod.rod.friction.mode_friction import mode_friction

FRICTION, KICK = 0.1, 0.05


def run() -> list[Row]:
    """Return the time of both, with what was promised."""
    return [paper_map(), critical_chart()]


def paper_map() -> Row:
    """Time 100 x 100 loads, all relevant modes: event-driven, and leapfrog as the paper runs it."""
    rod = fr.Rod.nitinol()
    unit = rod.critical_force
    mean, frequency = np.linspace(0.0, unit, 100)[:, None], np.linspace(20.0, 200.0, 100)
    ours = best_of(
        lambda: rod.is_stable(
            mean=mean, amplitude=0.7 * unit, frequency=frequency, friction=FRICTION, kick=KICK, workers=1
        ),
        repeats=2,
    )
    alphas, betas, gammas, kicks, orbits = [], [], [], [], 0
    for share in np.linspace(0.05, 0.95, 5):
        for omega in np.linspace(25.0, 195.0, 5):
            load = fr.AxialLoad(share * unit, 0.7 * unit, omega)
            modes = np.arange(1, rod.modes_needed(load)[0] + 1)
            system = rod.modal_system(load, modes)
            inside = mode_friction(rod, FRICTION, KICK, load.amplitude, load.frequency)
            orbits += modes.size
            pick = (int(100.0 * share) + int(omega)) % modes.size
            alphas.append(system.alpha[pick])
            betas.append(system.beta[pick])
            gammas.append(inside.gamma)
            kicks.append(inside.epsilon)
    leapfrog = best_of(lambda: fr.friction.leapfrog_escapes(alphas, betas, gammas, kicks), repeats=2)
    whole = leapfrog / len(alphas) * orbits / 25.0 * 1e4
    return Row("100 x 100 loads with friction", ours, "s", "the paper's leapfrog", whole, ratio_at_least=100.0)


def critical_chart() -> Row:
    """Time the critical kick on 200 x 200 points of the (alpha, beta) plane, on all cores."""
    alpha, beta = np.linspace(0.01, 2.0, 200), np.linspace(-1.5, 0.5, 200)[:, None]
    fr.friction.critical_kick(0.5, 0.2)
    start = time.perf_counter()
    fr.friction.critical_kick(alpha, beta)
    return Row("200 x 200 critical kicks, all cores", time.perf_counter() - start, "s", at_most=51.0)
