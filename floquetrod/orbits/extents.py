"""How far an orbit goes in each state, and whether it is more than one round."""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.orbits.orbit import PeriodicOrbit

_SAME = 1e-5  # of the states, by which two orbits are distinguished (a choice)


def returns_after(orbit: PeriodicOrbit, parts: int) -> bool:
    """Return whether an orbit returns after one of so many parts of what counts as its period."""
    turns = orbit.collocation.turns
    if turns is not None and turns % parts:
        return False
    times = np.linspace(0.0, orbit.period / parts, 64, endpoint=False)
    gaps = np.abs(orbit(times) - orbit(times + orbit.period / parts))
    return bool((gaps / orbit.point.scale).max() < _SAME)


def extent(orbit: PeriodicOrbit) -> tuple[Floats, Floats]:
    """Return the least and the largest value of each state, by parabolas through the outermost three points."""
    given, point = orbit.collocation, orbit.point
    values = np.concatenate([point.nodes[:, None], point.stages], axis=1).reshape(-1, point.nodes.shape[1])
    times = np.concatenate([given.mesh[:-1, None], given.shares], axis=1).ravel()
    return -_top(times, -values), _top(times, values)


def _top(times: Floats, values: Floats) -> Floats:
    """Return the largest value (n,) of each column of values (k, n) at times (k,) of a circle of length 1."""
    peak, columns = values.argmax(axis=0), np.arange(values.shape[1])
    before, after = peak - 1, (peak + 1) % len(times)
    left, right = (times[peak] - times[before]) % 1.0, (times[after] - times[peak]) % 1.0
    top, down, up = values[peak, columns], values[before, columns], values[after, columns]
    slopes = (top - down) / left, (up - top) / right
    bend = (slopes[1] - slopes[0]) / (left + right)
    rate = (slopes[0] * right + slopes[1] * left) / (left + right)
    with np.errstate(divide="ignore", invalid="ignore"):
        added = np.where(bend < 0.0, -0.25 * rate**2 / bend, 0.0)
    return np.asarray(top + np.where(np.isfinite(added), added, 0.0))
