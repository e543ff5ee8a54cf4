"""What people do today, and an independent judge of who is right."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import eigvalsh_tridiagonal
from scipy.special import mathieu_a, mathieu_b

import floquetrod as fr

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


def scipy_curves(alpha: Floats, beta: Floats) -> Bools:
    """Return verdicts on the map alpha x beta from SciPy's characteristic values, vectorised as well as they allow.

    Bounded between a_m and b_(m+1).  Of the ways to put that (tongues instead of intervals, a parity, sorted curves)
    this one makes the fewest errors where the curves are those of another order.
    """
    a, q = -4.0 * beta, 2.0 * alpha
    # Both a_m and b_m exceed m^2 beyond order sqrt(2 q), and lower ones exceed m^2 - 2 q: two orders to spare.
    orders = np.arange(math.isqrt(int(max(a.max(), 2.0 * q.max(), 0.0))) + 3)[:, None]
    stable = np.zeros((alpha.size, beta.size), dtype=bool)
    for lower, upper in zip(mathieu_a(orders, q), mathieu_b(orders + 1, q), strict=True):
        stable |= (a > lower[:, None]) & (a < upper[:, None])
    return stable


def dop853(alpha: float, beta: float) -> bool:
    """Return the verdict of the monodromy matrix by solve_ivp, DOP853 with rtol 1e-10, by its trace."""

    def slope(tau: float, y: Floats) -> list[float]:
        p = beta + alpha * math.sin(tau)
        return [y[1], p * y[0], y[3], p * y[2]]

    end = solve_ivp(slope, (0.0, 2.0 * math.pi), [1.0, 0.0, 0.0, 1.0], method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    return bool(abs(end[0] + end[3]) < 2.0)


@numba.njit
def leapfrog(alpha: float, beta: float) -> bool:
    """Return the verdict of the paper's test as the paper runs it: 100 periods, step by step, step 5e-4."""
    count = 4 * math.ceil(0.5 * math.pi / 5e-4)
    step, wave = 2.0 * math.pi / count, np.sin(np.arange(count) * (2.0 * math.pi / count))
    a, v = 0.0, 1.0
    for i in range(100 * count):
        v += 0.5 * step * (beta + alpha * wave[i % count]) * a
        a += step * v
        v += 0.5 * step * (beta + alpha * wave[(i + 1) % count]) * a
    return abs(a) < 1e6


def judge_map(alpha: Floats, beta: Floats, *verdicts: Bools) -> Bools:
    """Return the right verdicts on the map alpha x beta, whatever ``verdicts`` say.

    LAPACK's eigenvalues of Hill's matrices place the curves; where a point is nearer than 1e-9 to one, or any of
    ``verdicts`` differs, mpmath decides with 50 digits.
    """
    right = np.empty((alpha.size, beta.size), dtype=bool)
    doubt = np.empty_like(right)
    a = -4.0 * beta
    for i, value in enumerate(alpha):
        curves = _curves(2.0 * value, a.max())
        place = np.searchsorted(curves, a)
        right[i] = place % 2 == 1
        nearest = np.minimum(
            np.abs(a - curves[np.maximum(place - 1, 0)]), np.abs(curves[np.minimum(place, curves.size - 1)] - a)
        )
        doubt[i] = nearest < 1e-9 * np.maximum(1.0, np.abs(a))
    for verdict in verdicts:
        doubt |= verdict != right
    for i, j in np.argwhere(doubt):
        equation = fr.Mathieu(alpha=alpha[i], beta=beta[j])
        right[i, j] = fr.stability(equation, method="reference", digits=50).stable
    return right


def _curves(q: float, highest: float) -> Floats:
    size = 30 + int(math.sqrt(max(highest, 0.0) + 2.0 * q))
    even = 4.0 * np.arange(size) ** 2
    odd = (2.0 * np.arange(size) + 1.0) ** 2
    coupling = np.full(size - 1, q)
    first = coupling * np.where(np.arange(size - 1) == 0, math.sqrt(2.0), 1.0)
    edge = np.where(np.arange(size) == 0, q, 0.0)
    chains = [(even, first), (even[1:], coupling[1:]), (odd + edge, coupling), (odd - edge, coupling)]
    return np.sort(np.concatenate([eigvalsh_tridiagonal(*chain) for chain in chains]))
