"""Stability lobes of a slotting cutter, 400 x 200 points with bands, against semi-discretisation of the same accuracy.

Processor time, of one thread.  The semi-discretisation is that of the literature, of first order with the delay a whole
number of steps and the map's leading eigenvalue by Arnoldi's method; it takes as many steps as make its moduli near the
boundary as good as 1e-4, which are a hundred times worse than those of the chart.
"""

from __future__ import annotations

import math
import time
from functools import partial

import numpy as np

import floquetrod as fr
from benchmarks.measure import Row
from floquetrod.milling import stability_lobes

MODE = fr.ToolMode("922Hz", 0.011, mass="39.93g")
SLOT = fr.Milling(x=[MODE], teeth=2, tangential="600MPa", radial="200MPa")
PITCH = 2.0 * math.pi / SLOT.teeth
COLUMNS, ROWS = 400, 200
SPEED, DEPTH = ("5000rpm", "10000rpm", COLUMNS), ("0mm", "4mm", ROWS)
ACCURACY = 1e-4
SAMPLE = 6


def run() -> list[Row]:
    """Return the figures of the lobes with what was promised."""
    SLOT.lobes(("5000rpm", "5100rpm", 2), ("0mm", "1mm", 2))
    start = time.process_time()
    found = SLOT.lobes(SPEED, DEPTH)
    ours = time.process_time() - start
    bands = found.chart.bands
    both = time.process_time() - start
    places = [(float(found.speeds[i]), float(found.depths[i])) for i in np.linspace(0, COLUMNS - 1, SAMPLE).astype(int)]
    steps = next(m for m in (40, 80, 160, 320, 640, 1280, 2560) if worst(places, m) <= ACCURACY)
    start = time.process_time()
    for place in places:
        semi_discretised(*place, steps)
    peer = (time.process_time() - start) / SAMPLE * COLUMNS * ROWS
    against = f"semi-discretisation, {steps} steps"
    return [
        Row(f"lobes of {COLUMNS} x {ROWS} points", ours, "s", against, peer, ratio_at_least=50.0),
        Row(f"with their bands, {sum(len(band.x) for band in bands)} vertices", both, "s", against, peer, at_most=60.0),
        Row("largest error of a modulus at their boundary", largest_error(places), ""),
        Row("error of 40 steps, as in the literature", worst(places, 40), ""),
    ]


def largest_error(places: list[tuple[float, float]]) -> float:
    """Return by how much moduli are off with which the chart decides near its boundary."""
    speeds, depths = (np.array(column) for column in zip(*places, strict=True))
    logs = stability_lobes.judged(SLOT, speeds, depths, growth=True).logs
    return float(np.abs(np.exp(logs) - 1.0).max())


def worst(places: list[tuple[float, float]], steps: int) -> float:
    """Return the largest error of semi-discretisation at critical depths, where the modulus is 1."""
    return max(map(partial(error, steps=steps), places))


def error(place: tuple[float, float], steps: int) -> float:
    """Return how far the modulus at a critical depth is from 1."""
    return abs(semi_discretised(*place, steps) - 1.0)


def semi_discretised(speed: float, depth: float, steps: int) -> float:
    """Return the largest modulus of a multiplier, the time between teeth in so many steps."""
    from scipy.linalg import expm
    from scipy.sparse.linalg import eigs

    period = PITCH / speed
    h = period / steps
    edges = np.linspace(0.0, PITCH, 8 * steps + 1)
    cutting = SLOT.cutting(0.5 * (edges[1:] + edges[:-1]))[:, 0, 0].reshape(steps, 8).mean(axis=1)
    force = depth * cutting / MODE.mass
    matrix = np.zeros((steps, 4, 4))  # x, x', and a force that varies linearly
    matrix[:, 0, 1] = h
    matrix[:, 1, 0], matrix[:, 1, 1] = -h * (MODE.frequency**2 + force), -2.0 * h * MODE.damping_ratio * MODE.frequency
    matrix[:, 1, 2] = h
    matrix[:, 2, 3] = 1.0
    found = expm(matrix)
    size = steps + 2
    values, state = np.zeros((2 * steps + 1, size)), np.zeros((2, size))
    values[: steps + 1, 1:] = np.eye(steps + 1)
    state[0], state[1, 0] = values[steps], 1.0
    for i in range(steps):
        late, later = force[i] * values[i], force[i] * values[i + 1]
        state = found[i, :2, :2] @ state + np.outer(found[i, :2, 2], late) + np.outer(found[i, :2, 3], later - late)
        values[steps + i + 1] = state[0]
    whole = np.concatenate([state[1:], values[steps:]])
    return float(np.abs(eigs(whole, k=1, return_eigenvectors=False)).max())
