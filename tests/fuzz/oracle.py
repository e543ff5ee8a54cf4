"""Growth of u'' = (b + a cos s) u over arrays, by time stepping: independent of every line of the package.

The sixth-order Magnus integrator with three Gauss points (Blanes, Casas and Ros, BIT 40 (2000) 434) is carried over
half a period; s = 0 is an instant of even symmetry, so that with the cosine- and sine-like solutions y1, y2 at s = pi

    (D - 2) / 4 = y1' y2,    -(D + 2) / 4 = -y1 y2',    D the trace over the period,

and X = max(y1' y2, -y1 y2') is positive exactly where u grows, at 2 asinh(sqrt(X)) / (2 pi) per unit of s.  Both
factors vanish at the ends of a tongue and are known to a few units of rounding, so that growth far below the rounding
of D is seen.  The step is halved until two runs agree; their difference is the error stated, a 64th the one expected.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_GAUSS = 0.5 + math.sqrt(15.0) / 10.0 * np.array([-1.0, 0.0, 1.0])
_MOST_STEPS = 1 << 14


class Growth(NamedTuple):
    """Growth per unit of s of the undamped equation: at least ``low``, at most ``high``."""

    low: Array
    high: Array
    middle: Array


def growth(alpha: ArrayLike, mean: ArrayLike, accuracy: float = 1e-10) -> Growth:
    """Return the growth of u'' = (mean + alpha sin tau) u, with bounds good to about ``accuracy``."""
    a, b = (np.array(x, dtype=np.float64) for x in np.broadcast_arrays(alpha, mean))
    shape = a.shape
    a, b = np.abs(a.ravel()), b.ravel()
    excess, error = np.empty(a.size), np.full(a.size, np.inf)
    scale = np.sqrt(np.maximum(1.0, a + np.abs(b)))
    steps = 8 * 2 ** np.ceil(np.log2(np.maximum(1.0, 0.6 * scale))).astype(int)
    for count in sorted(set(steps.tolist())):
        at = np.flatnonzero(steps == count)
        coarse = half_period(a[at], b[at], count)
        while at.size:
            count *= 2
            fine = half_period(a[at], b[at], count)
            value, spread = _excess(coarse, fine, scale[at], count)
            worse = (spread > accuracy * (1.0 + np.abs(value))) & (spread < 0.5 * error[at])  # else rounding is reached
            better = spread < error[at]
            excess[at[better]], error[at[better]] = value[better], spread[better]
            if count >= _MOST_STEPS:
                break
            at, coarse = at[worse], fine[:, worse]
    low, high, middle = (_rate(x).reshape(shape) for x in (excess - error, excess + error, excess))
    return Growth(low, high, middle)


def half_period(a: Array, b: Array, count: int) -> Array:
    """Return y1, y1', y2, y2' at s = pi after ``count`` steps."""
    h = math.pi / count
    y1, d1, y2, d2 = np.ones(a.size), np.zeros(a.size), np.zeros(a.size), np.ones(a.size)
    with np.errstate(over="ignore", invalid="ignore"):
        for step in range(count):
            p = [b + a * math.cos(h * (step + place)) for place in _GAUSS]
            x, y, z = _exponent(*p, h)
            square = z * z + x * y
            root = np.sqrt(np.abs(square))
            bounded = np.minimum(root, 700.0)
            even = np.where(square < 0.0, np.cos(root), np.cosh(bounded))
            ratio = np.where(square < 0.0, np.sin(root), np.sinh(bounded))
            odd = np.where(root > 1e-3, ratio / np.where(root > 0.0, root, 1.0), 1.0 + square / 6.0)
            m11, m12, m21, m22 = even + odd * z, odd * x, odd * y, even - odd * z
            y1, d1 = m11 * y1 + m12 * d1, m21 * y1 + m22 * d1
            y2, d2 = m11 * y2 + m12 * d2, m21 * y2 + m22 * d2
    return np.array([y1, d1, y2, d2])


def _exponent(p1: Array, p2: Array, p3: Array, h: float) -> tuple[Array, Array, Array]:
    """Return the Magnus exponent [[z, x], [y, -z]] of a step of u'' = p u."""
    d = math.sqrt(15.0) / 3.0 * h * (p3 - p1)
    e = 10.0 / 3.0 * h * (p3 - 2.0 * p2 + p1)
    y = h * p2
    # C1 = [a1, a2] = h d H;  C2 = -[a1, 2 a3 + C1] / 60, in the basis X, Y, H of the 2 x 2 matrices of trace zero.
    cx, cy, cz = h * h * d / 30.0, -h * d * y / 30.0, -h * e / 30.0
    lx, ly, lz = -20.0 * h, -20.0 * y - e, h * d
    ry = d + cy
    return (
        h + 2.0 * (lz * cx - lx * cz) / 240.0,
        y + e / 12.0 + 2.0 * (ly * cz - lz * ry) / 240.0,
        (lx * ry - ly * cx) / 240.0,
    )


def _excess(coarse: Array, fine: Array, scale: Array, count: int) -> tuple[Array, Array]:
    """Return X of the finer run and a bound on its error: the difference of the runs, and rounding."""
    y1, d1, y2, d2 = fine
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.abs(y1) + np.abs(d1) / scale + np.abs(y2) * scale + np.abs(d2)
        rounding = 2.0**-50 * count * size * np.array([np.ones_like(scale), scale, 1.0 / scale, np.ones_like(scale)])
        e1, f1, e2, f2 = np.abs(fine - coarse) + rounding
        plus, minus = d1 * y2, -y1 * d2
        plus_error = np.abs(d1) * e2 + np.abs(y2) * f1 + f1 * e2
        minus_error = np.abs(y1) * f2 + np.abs(d2) * e1 + e1 * f2
        even = plus > minus
        value, error = np.where(even, plus, minus), np.where(even, plus_error, minus_error)
    unknown = ~np.isfinite(value) | ~np.isfinite(error)
    return np.where(unknown, 1e300, value), np.where(unknown, 1e300, error)


def _rate(excess: Array) -> Array:
    """Return the growth per unit of s that X stands for, minus its root where u is bounded."""
    root = np.sqrt(np.minimum(np.abs(excess), 1e300))
    grows: Array = np.where(excess > 0.0, np.arcsinh(root) / math.pi, -root)
    return grows
