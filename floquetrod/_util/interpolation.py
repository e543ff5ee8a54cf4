"""Weights of interpolating polynomials, through Chebyshev's points or through a few others."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats


def chebyshev_points(count: int) -> Floats:
    """Return Chebyshev's points from -1 to 1 (count,), both ends among them, in increasing order."""
    return -np.cos(math.pi * np.arange(count) / (count - 1))


def chebyshev_weights(count: int, at: Floats) -> Floats:
    """Return the weights (p, count) of the values at Chebyshev's points in the polynomial through them, at places (p,).

    J.-P. Berrut and L. N. Trefethen, SIAM Review 46 (2004) 501, doi:10.1137/S0036144502417715, equation (4.2).
    """
    weights = np.resize([1.0, -1.0], count)
    weights[[0, -1]] *= 0.5
    gaps = at[:, None] - chebyshev_points(count)
    met = gaps == 0.0
    ratios = weights / np.where(met, 1.0, gaps)
    return np.asarray(np.where(met.any(axis=1, keepdims=True), met, ratios / ratios.sum(axis=1, keepdims=True)))


def lagrange_weights(places: Floats, at: float) -> Floats:
    """Return the weights (n,) of values at places (n,) in their polynomial at another place; NaN for equal places."""
    points = places.tolist()
    ratios = ([(at - b) / (a - b or math.nan) for j, b in enumerate(points) if j != i] for i, a in enumerate(points))
    return np.array([math.prod(factors, start=1.0) for factors in ratios])
