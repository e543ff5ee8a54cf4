"""How far an orbit goes in each state, and whether it is more than one round."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from floquetrod._util.arrays import Floats
from floquetrod.orbits.collocation import Collocation, Point, gauss
from floquetrod.orbits.orbit_mesh import evaluated

_SAME = 1e-5  # of the states, by which two orbits are distinguished (a choice)
_SAMPLES = 4  # of each interval for each degree of the polynomials
_RIVALS = 1e-2  # of the range, by which a sample may lie below the largest and its peak above it (a choice)
_STEPS = 5  # of Newton's method, from a sample next to a peak


class Extremes(NamedTuple):
    """Least and largest value of each state over the period (n,), and the shares of the period where they are (n,)."""

    least: Floats
    largest: Floats
    least_at: Floats
    largest_at: Floats


def returns_after(collocation: Collocation, point: Point, parts: int) -> bool:
    """Return whether an orbit returns after one of so many parts of what counts as its period."""
    turns = collocation.turns
    if turns is not None and turns % parts:
        return False
    shares = np.linspace(0.0, 1.0 / parts, 64, endpoint=False)
    gaps = evaluated(collocation, point, shares) - evaluated(collocation, point, shares + 1.0 / parts)
    return bool((np.abs(gaps) / point.scale).max() < _SAME)


def extremes(collocation: Collocation, point: Point) -> Extremes:
    """Return the extremes of the polynomials, as accurate as the states themselves."""
    values = np.concatenate([point.nodes[:, None], point.stages], axis=1)
    series = np.einsum("kj,ijn->kin", gauss(collocation.degree).to_series, values)
    largest, largest_at = _peaks(collocation, series)
    least, least_at = _peaks(collocation, -series)
    return Extremes(-least, largest, least_at, largest_at)


def _peaks(collocation: Collocation, series: Floats) -> tuple[Floats, Floats]:
    """Return the largest value of each state (n,), and where, of Legendre series (m + 1, N, n) on the intervals.

    The zeros of the derivative next to all samples almost as large as the largest, by Newton's method.
    """
    x = np.linspace(-1.0, 1.0, _SAMPLES * collocation.degree + 1)
    samples = np.moveaxis(legendre.legval(x, series), -1, 1)  # (N, k, n)
    tops, count = samples.max(axis=(0, 1)), samples.shape[2]
    largest, at = np.empty(count), np.empty(count)
    slope, bend = (np.asarray(legendre.legder(series, times), dtype=float) for times in (1, 2))
    for j in range(count):
        interval, place = np.nonzero(samples[:, :, j] >= tops[j] - _RIVALS * np.ptp(samples[:, :, j]))
        here, rising, bent = (each[:, interval, j] for each in (series, slope, bend))
        low, high = x[np.maximum(place - 1, 0)], x[np.minimum(place + 1, len(x) - 1)]
        peaks = x[place]
        for _ in range(_STEPS):
            rate, curve = _along(rising, peaks), _along(bent, peaks)
            with np.errstate(all="ignore"):
                peaks = np.where(curve < 0.0, np.clip(peaks - rate / curve, low, high), peaks)
        heights = _along(here, peaks)
        best, known = int(heights.argmax()), int(samples[interval, place, j].argmax())
        k, s = (best, peaks[best]) if heights[best] >= tops[j] else (known, x[place[known]])
        largest[j] = max(float(heights[best]), float(tops[j]))
        at[j] = collocation.mesh[interval[k]] + 0.5 * (s + 1.0) * collocation.steps[interval[k]]
    return largest, at


def _along(series: Floats, x: Floats) -> Floats:
    """Return the values (k,) of Legendre series (m + 1, k), each at its own place."""
    return np.asarray(legendre.legval(x, series, tensor=False))
