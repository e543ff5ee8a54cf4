"""How a rod lifts off the wall next to a hinged end: the bending energy that it saves there.

A rod on its wall whose angle has the slope theta' is curved towards the axis of the channel by kappa = R theta'^2.  A
hinge carries no moment in that plane either, so next to it the rod straightens and leaves the wall by a little, u(s).
Slow against the contact, and short against a half wave, it takes the u >= 0 of least energy

    int (E I u''^2 / 2 + N u + P(u)) ds - E I kappa u'(0),  u(0) = 0,

N the contact force there of the rod on the wall, P what it takes to press the wall less, a force like indentation^1.5
as in the simulator.  In units of the indentation d and of the length b = (E I d / N)^(1/4) that is one function of
K = kappa b^2 / d: y'''' = (1 - y)_+^1.5 - 1, y(0) = 0, y''(0) = -K.  With s(K) = y'(0) the energy is
-(E I d^2 / b^3) int_0^K s.  A soft wall or small motion has s = K / (sqrt(2) 1.5^(1/4)), a hard wall K^1.5 / 3, from
which s differs by a part that falls like 1 / K^2 (found by solving for it).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats

_LARGEST = 60.0  # K up to which the slope is solved for; beyond it is that of a hard wall and what falls like 1 / K^2
_LEAST_CONTACT = 0.2  # of the weight: below, contact is about to be lost, and what is saved grows no more
_ROUNDED = 0.1  # of the weight, over which it ceases to grow
_SOLVED = 32  # values of K it is solved for
_DEGREE = 14  # of the polynomial through them, smooth for integrators, right to 0.3 %
_JOINED = 1e4  # weight of its value and slope at the last K, where it goes over into that of larger K
_POINTS = 150  # of the finite differences, whose error of second order is extrapolated


class Energy(NamedTuple):
    """An energy of curvature and contact force with its derivatives, those by contact force over the weight."""

    value: Any
    by_curvature: Any
    by_contact: Any
    by_curvature_twice: Any
    by_both: Any
    by_contact_twice: Any


@dataclass(frozen=True)
class LiftOff:
    """What a hinged end saves of energy."""

    rigidity: float  # E I in N m^2
    weight: float  # on the wall in N/m
    indentation: float  # depth in m to which that weight indents the wall

    def energy(self, curvature: Any, contact: Any) -> Energy:
        """Return the energy in J at curvatures in 1/m and contact forces over the weight, with its derivatives.

        The indentation goes like contact^(2/3), so that b goes like contact^(-1/12) and K like contact^(-5/6).
        """
        root = np.hypot(contact - _LEAST_CONTACT, _ROUNDED)
        n = 0.5 * (contact + _LEAST_CONTACT + root)  # contact, except for where it is about to be lost
        dn, ddn = 0.5 * (1.0 + (contact - _LEAST_CONTACT) / root), 0.5 * _ROUNDED**2 / root**3
        squared = np.sqrt(self.rigidity * self.indentation / self.weight)  # b^2 under the weight
        unit = squared / self.indentation
        scale = -self.rigidity * np.sqrt(squared)
        k = unit * curvature * n ** (-5.0 / 6.0)
        s, ds, whole = _slope(k)
        left = 1.5833333333333333 * whole - 0.8333333333333334 * s * k
        bent = n ** (7.0 / 12.0) * 0.8333333333333334 * k / n * (0.8333333333333334 * ds * k - 0.75 * s)
        by_n = scale * n ** (7.0 / 12.0) * left / unit**2
        return Energy(
            scale * n ** (19.0 / 12.0) * whole / unit**2,
            scale * n**0.75 * s / unit,
            by_n * dn,
            scale * n ** (-1.0 / 12.0) * ds,
            scale * n**-0.25 * (0.75 * s - 0.8333333333333334 * k * ds) / unit * dn,
            scale * (7.0 / 12.0 * n ** (-5.0 / 12.0) * left + bent) / unit**2 * dn**2 + by_n * ddn,
        )


def _slope(k: Any) -> tuple[Any, Any, Any]:
    """Return s, its derivative, and its integral from 0."""
    ratio, slope, integral = _solutions()
    near, far, soft = np.minimum(k, _LARGEST), np.maximum(k, _LARGEST), k < _LARGEST
    x, y = np.log1p(near), 1.0 + near
    r, dr = ratio(x), slope(x) / y
    hard, by_k, beyond = _of_hard_wall(far)
    s = np.where(soft, near * np.sqrt(y) * r, hard)
    ds = np.where(soft, np.sqrt(y) * (r + near * dr + 0.5 * near * r / y), by_k)
    return s, ds, near**2 * integral(x) + beyond


def _of_hard_wall(k: Any) -> tuple[Any, Any, Any]:
    """Return s from the last K on, its derivative, and its integral from there."""
    root, lost, last = np.sqrt(k), _beside_hard_wall(), np.sqrt(_LARGEST)
    whole = 0.4 * (root**5 - last**5) + 2.0 * lost * (root - last)
    return (root**3 + lost / root) / 3.0, (1.5 * root - 0.5 * lost / root**3) / 3.0, whole / 3.0


@functools.cache
def _beside_hard_wall() -> float:
    """Return c of s = K^1.5 (1 + c / K^2) / 3 at the last K."""
    return float(_LARGEST**2 * (3.0 * _solved(_LARGEST) / _LARGEST**1.5 - 1.0))


@functools.cache
def _solutions() -> tuple[Any, Any, Any]:
    """Return s / (K sqrt(1 + K)), its slope, and the integral of s over K^2 as polynomials of log(1 + K)."""
    from numpy.polynomial.chebyshev import Chebyshev, chebvander

    top = float(np.log1p(_LARGEST))
    x = 0.5 * top * (1.0 - np.cos(np.pi * (np.arange(_SOLVED) + 0.5) / _SOLVED))
    k = np.append(np.expm1(x), _LARGEST)
    hard, by_k, _ = _of_hard_wall(_LARGEST)
    solved = np.array([*(_solved(value) for value in k[:-1].tolist()), hard]) / (k * np.sqrt(1.0 + k))
    end_slope = solved[-1] * ((1.0 + _LARGEST) * (by_k / hard - 1.0 / _LARGEST) - 0.5)
    places = np.append(2.0 * x / top - 1.0, 1.0)
    slopes_at_end = 2.0 / top * np.arange(_DEGREE + 1.0) ** 2
    rows = np.vstack([chebvander(places, _DEGREE), slopes_at_end])
    heavy = np.append(np.ones(_SOLVED), [_JOINED, _JOINED])
    found = np.linalg.lstsq(heavy[:, None] * rows, heavy * np.append(solved, end_slope), rcond=None)[0]
    ratio = Chebyshev(found, domain=[0.0, top])
    points, weights = np.polynomial.legendre.leggauss(96)
    share = 0.5 * (points + 1.0)
    dense = 0.5 * top * (1.0 - np.cos(np.pi * (np.arange(64) + 0.5) / 64))
    outer = np.expm1(dense)[:, None]
    inner = outer * share**2
    slopes = inner * np.sqrt(1.0 + inner) * ratio(np.log1p(inner))
    whole = (slopes / outer) @ (weights * share)
    return ratio, ratio.deriv(), Chebyshev.fit(dense, whole, 3 * _DEGREE, domain=[0.0, top])


def _solved(k: float) -> float:
    """Return s(K) by finite differences, extrapolated."""
    coarse, fine = (_slope_with(k, points) for points in (_POINTS, 2 * _POINTS))
    return (4.0 * fine - coarse) / 3.0


def _slope_with(k: float, points: int) -> float:
    """Return s(K) with so many points: Newton's method on the energy, which is convex, in steps that lessen it."""
    from scipy.linalg import solve_banded

    h = (16.0 + 3.0 * np.sqrt(k)) / points
    bands = np.array([[1.0], [-4.0], [6.0], [-4.0], [1.0]]) * np.ones(points - 1)
    bands[2, 0] = 5.0
    bands /= h**4
    pull = np.zeros(points - 1)
    pull[0] = k / h**2
    y = np.zeros(points - 1)

    def bent(y: Floats) -> Floats:
        f = np.concatenate([[-y[0], 0.0], y, [0.0, 0.0]])
        return np.asarray((f[:-4] - 4.0 * f[1:-3] + 6.0 * f[2:-2] - 4.0 * f[3:-1] + f[4:]) / h**4)

    def energy(y: Floats) -> float:
        return float(0.5 * y @ bent(y) - pull @ y + np.sum(y + (np.maximum(1.0 - y, 0.0) ** 2.5 - 1.0) / 2.5))

    for _ in range(100):
        pressed = np.maximum(1.0 - y, 0.0)
        slope = bent(y) - pull + 1.0 - pressed**1.5
        stiff = bands.copy()
        stiff[2] += 1.5 * np.sqrt(pressed)
        step = solve_banded((2, 2), stiff, -slope)
        if np.abs(step).max() < 1e-6 * (1.0 + np.abs(y).max()):
            break
        before, part = energy(y), 1.0
        while part > 1e-6 and energy(y + part * step) > before + 1e-12 * abs(before) + 1e-4 * part * (slope @ step):
            part *= 0.5
        y = y + part * step
    return float((2.0 * y[0] + k * h * h) / (2.0 * h))
