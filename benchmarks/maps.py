"""A rod's map of a million loads: time a mode verdict, threads, memory, and the same map the usual ways."""

from __future__ import annotations

import tracemalloc

import numpy as np

import floquetrod as fr
from benchmarks import peers
from benchmarks.measure import Row, best_of

ROD = fr.Rod.nitinol()
SIDE = 1000
MAP = {
    "mean": (0.0, 1.1 * ROD.critical_force, SIDE),
    "amplitude": 0.2 * ROD.critical_force,
    "frequency": (20.0, 200.0, SIDE),
}


def run() -> list[Row]:
    """Return the figures of the map with what was promised."""
    verdicts = mode_verdicts()
    one = best_of(lambda: fr.stability_map(ROD, **MAP, workers=1), repeats=5)
    two = best_of(lambda: fr.stability_map(ROD, **MAP, workers=2), repeats=5)
    dop853, leapfrog = slow_ways()
    return [
        Row(f"map of {SIDE} x {SIDE} loads, one thread", one, "s"),
        Row(f"a mode verdict of its {verdicts / 1e6:.1f} million", 1e9 * one / verdicts, "ns", at_most=25.0),
        Row("two threads", two, "s", "one thread", one, ratio_at_least=1.7),
        Row("memory beyond the result", extra_memory() / 2**20, "MB", at_most=64.0),
        Row("map, against solve_ivp, DOP853", one, "s", "solve_ivp on a sample", dop853 * verdicts),
        Row("map, against the paper's test", one, "s", "compiled leapfrog on a sample", leapfrog * verdicts),
    ]


def mode_verdicts() -> int:
    """Return how many mode verdicts the map stands for: every mode that can matter, load by load, on a coarse map."""
    means, omegas = np.linspace(*MAP["mean"][:2], 40), np.linspace(*MAP["frequency"][:2], 40)
    needed = [ROD.modes_needed(fr.AxialLoad(m, MAP["amplitude"], w))[0] for m in means for w in omegas]
    return round(float(np.mean(needed)) * SIDE * SIDE)


def slow_ways() -> tuple[float, float]:
    """Return the seconds a mode verdict takes by a monodromy matrix and by the paper's test, from a few loads."""
    equations = [
        equation
        for share in (0.1, 0.6)
        for omega in (50.0, 150.0)
        for equation in ROD.modal_system(
            fr.AxialLoad(share * ROD.critical_force, MAP["amplitude"], omega), (2, 7, 12)
        ).equations
    ]
    dop853 = best_of(lambda: [peers.dop853(e.alpha, e.beta) for e in equations], repeats=3)
    leapfrog = best_of(lambda: [peers.leapfrog(e.alpha, e.beta) for e in equations], repeats=3)
    return dop853 / len(equations), leapfrog / len(equations)


def extra_memory() -> int:
    """Return the bytes at the peak of making the map, beyond those of the map itself."""
    tracemalloc.start()
    chart = fr.stability_map(ROD, **MAP, growth=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak - sum(
        array.nbytes for array in (chart.stable, chart.growth_rate, chart.first_mode) if array is not None
    )
