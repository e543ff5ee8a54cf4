"""Nanoseconds an element-step without and with friction, and the throughput of two runs in two threads."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import floquetrod as fr
from benchmarks.measure import Row, best_of
from floquetrod._compile import compiled
from floquetrod.kernels import cosserat
from floquetrod.segmented import SegmentedRod

SEGMENTS, STEPS = 250, 1000
ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)


def run() -> list[Row]:
    """Return the figures of the issue's list, with what was promised."""
    free, rubbing = element_step(0.0), element_step(0.1)
    rows = [
        Row("element-step, no friction", 1e9 * free, "ns", at_most=9.0),
        Row("element-step, friction and rolling", 1e9 * rubbing, "ns", at_most=14.0),
    ]
    second = fr.simulate(ROD, LOAD, 0.05, segments=SEGMENTS, frames=21).seconds / 0.05
    rows.append(Row("a simulated second of the reference rod, frames included", second, "s"))
    if (os.cpu_count() or 1) > 1:
        rows.append(Row("two runs in two threads take, of one after the other", two_threads(), "", at_most=1.0 / 1.7))
    return rows


def prepared(friction: float) -> tuple[Any, Any]:
    """Return a moving rod and its physics."""
    cut = SegmentedRod(ROD, SEGMENTS)
    rod = cut.at_rest(LOAD.mean)
    rod["vy"][: SEGMENTS + 1] = fr.Perturbation.random(1e-3, seed=1).velocities(SEGMENTS)
    cut.set_off(rod)
    return rod, cut.physics(LOAD, cut.safe_step()[0], friction)


def element_step(friction: float) -> float:
    """Return the seconds one step of one segment takes."""
    rod, physics = prepared(friction)
    advance = compiled(cosserat.advance)
    return best_of(lambda: advance(rod, STEPS, physics), repeats=40) / (STEPS * SEGMENTS)


def two_threads() -> float:
    """Return the time of two runs in two threads over that of both, one after the other; the best of several."""
    advance = compiled(cosserat.advance)
    rods = [prepared(0.1) for _ in range(2)]
    ratios = []
    with ThreadPoolExecutor(2) as pool:
        for _ in range(10):
            start = time.perf_counter()
            for rod, physics in rods:
                advance(rod, 20 * STEPS, physics)
            middle = time.perf_counter()
            list(pool.map(lambda pair: advance(pair[0], 20 * STEPS, pair[1]), rods))
            ratios.append((time.perf_counter() - middle) / (middle - start))
    return min(ratios)
