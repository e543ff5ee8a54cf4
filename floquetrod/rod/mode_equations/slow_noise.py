"""Noise slower than a mode: the stiffness drifts with it, and the growth of second moments follows.

Let S2 be the density of the noise at twice the frequency of a mode.  What exceeds S2 below that frequency is not white
noise to the mode, but lets its stiffness K = w^2 - k F drift.  Let the excess have the variance V and at most the
one-sided density S, and let r(F) be the growth of second moments at the stiffness K, where the rest acts as white
noise.  With F an Ornstein-Uhlenbeck process of variance V and rate a = 4 V / S, whose density at the frequency 0 is S,
the expectation of exp(integral of r(F)) grows at the largest eigenvalue of

    a V u'' + (r(F) - a F^2 / 4 V + a / 2) u

(Feynman and Kac).  It is the mean of r where the drift is fast beside the growth, and the largest r(F) - F^2 / S where
it is slow: to stay at F costs so much of the probability per unit of time.  The growth r comes from the equation

    u'' + (K - c^2 + p(t)) u = s u xi,   q = exp(-c t) u,

as 2 l + 2 e - 2 e0 - 2 c: l is the exponent without noise, 4 e (K - c^2 + e^2) = s^2, and e0 is e without noise.

Noise at the frequencies v and 2 w - v acts as well like noise at 2 w, of the size f(v) f(2 w - v) / v (2 w - v): in
second order, as the second tongue of Mathieu's equation is made by a sine of the frequency w.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod.rod.loads.load import Noise, density_at, largest_density
from floquetrod.rod.mode_equations.moment_coefficients import (
    ModeCoefficients,
    growth_of_white_noise,
    intensity_of_growth,
)
from floquetrod.rod.mode_equations.narrow_noise import Excess

_SPREAD = 1.5  # variance that is counted over the one given, as no drift is as slow as is assumed (a choice)
_DEVIATIONS, _BEYOND = 7.0, 1.15  # standard deviations of the drift, and of the farthest value that may matter
_PLACES = 160  # of the drift (a choice)
_LITTLE = 1.25  # times the growth under white noise, which a drift passes at no place where it does little (a choice)
_CLOSE = 0.02  # of a growth rate, that bounds give (a choice)
_FAR = 0.05  # of the stiffness, which the drift must reach to be counted on (a choice)
_STEPS = 40  # of the iteration to the farthest value
_AT_ONCE = 1 << 11  # modes


def growth_as_stiffness_drifts(
    parts: ModeCoefficients, excess: Excess, noise: Noise, tolerance: float, chosen: Bools, workers: int | None
) -> Floats:
    """Return the growth of second moments in 1/s of chosen modes, (loads, modes).

    NaN of the others, and where no drift that may matter lets a mode grow faster than the tolerance.
    """
    growth = np.full(parts.squared.shape, np.nan)
    variance, density, paired = _of_stiffness(parts, excess)
    ends = _ends(parts, variance, density)
    rows, columns = np.nonzero(chosen & (variance > 0.0) & ~(_bound(parts, ends[1], noise, paired) <= tolerance))
    for start in range(0, rows.size, _AT_ONCE):
        at = rows[start : start + _AT_ONCE], columns[start : start + _AT_ONCE]
        growth[at] = _of_some(
            parts.some(at),
            variance[at],
            density[at],
            paired[at],
            (ends[0][at], ends[1][at]),
            noise,
            tolerance,
            workers,
        )
    return growth


def least_intensities(parts: ModeCoefficients, excess: Excess, noise: Noise) -> Floats:
    """Return the intensity in 1/s^1.5 of white noise that makes modes grow as they do at least, 0 where none grows.

    Of the excess as `Excess` has it at least: of 160 filters of each kind drawn, of one state and of two, the growth
    was 0.99 times the exact one at most.
    """
    known = Excess(excess.least_variance / _SPREAD, excess.least_density / _SPREAD, 0.0, 0.0, 0.0)
    c, (variance, density, paired) = parts.damping, _of_stiffness(parts, known)
    far = _ends(parts, variance, density)[1]
    bound = _bound(parts, far, noise, paired)
    matters = ~(bound + 2.0 * c <= _LITTLE * (parts.growth_bounds[0] + 2.0 * c)) & (far > _FAR * np.abs(parts.squared))
    if c == 0.0:  # any white noise makes these grow: a verdict needs no more
        matters &= parts.intensity == 0.0
    growth = growth_as_stiffness_drifts(parts, known, noise, 0.0, matters, None)
    least = intensity_of_growth(parts.squared - c * c, np.maximum(np.nan_to_num(growth), 0.0) + 2.0 * c)
    return np.where((growth > 0.0) & np.isfinite(growth), least, 0.0)


def may_grow_as_stiffness_drifts(parts: ModeCoefficients, excess: Excess, noise: Noise, tolerance: float) -> Bools:
    """Return whether a bound lets modes grow faster than a tolerance as their stiffness drifts, (loads, modes)."""
    variance, density, paired = _of_stiffness(parts, excess)
    bound = _bound(parts, _ends(parts, variance, density)[1], noise, paired)
    return np.asarray((variance > 0.0) & ~(bound <= tolerance))


def _of_stiffness(parts: ModeCoefficients, excess: Excess) -> tuple[Floats, Floats, Floats]:
    """Return variance in 1/s^4 and two-sided density in 1/s^3 of the drift, and intensity in 1/s^1.5 of the pairs."""
    squared_gain = np.square(np.broadcast_to(parts.per_newton, parts.squared.shape))
    variance, density = _SPREAD * squared_gain * excess.variance, 0.5 * _SPREAD * squared_gain * excess.density
    return variance, density, squared_gain / math.tau**2 * np.sqrt(0.5 * excess.pairs)


def _of_some(
    some: ModeCoefficients,
    variance: Floats,
    density: Floats,
    paired: Floats,
    ends: tuple[Floats, Floats],
    noise: Noise,
    tolerance: float,
    workers: int | None,
) -> Floats:
    """Return the growth of modes, (n,), from variance and two-sided density of the drifts of their stiffness.

    ``paired`` is the intensity in 1/s^1.5 of the pairs of frequencies that add up to twice theirs.
    """
    drift = np.linspace(-ends[0], ends[1], _PLACES, axis=-1)
    moved = some._replace(squared=some.squared - drift, least=0.0)
    moved = moved.with_density(density_at(noise, np.maximum(moved.hertz, 0.5 * some.reference)))
    moved = moved._replace(intensity=np.hypot(moved.intensity, paired[:, None]))
    growth = _growth(moved, workers)
    found = np.full(len(variance), np.nan)
    for i in np.flatnonzero((growth > tolerance).any(axis=1)):
        a = 2.0 * variance[i] / density[i]
        steady = a * drift[i] ** 2 / (4.0 * variance[i]) - 0.5 * a
        side = a * variance[i] / (drift[i, 1] - drift[i, 0]) ** 2
        of_step = _largest(-steady, side)  # 0 apart from the error of the step
        found[i] = _largest(growth[i] - steady, side) - of_step
    return found


def _growth(moved: ModeCoefficients, workers: int | None) -> Floats:
    """Return the growth of second moments in 1/s at each place of the drift, (n, places)."""
    from floquetrod.systems.batch_verdicts import verdicts

    c = moved.damping
    low, high = moved.growth_bounds
    growth = 0.5 * (low + high)
    left = ~(high - low <= _CLOSE * (low + 2.0 * c))
    if not left.any():
        return growth
    bare = moved._replace(squared=moved.squared - c * c, damping=0.0)
    still = np.sqrt(np.maximum(0.0, -bare.squared))
    alone = still.copy()
    if any(wave.any() for wave in moved.waves):
        alone[left] = verdicts(bare.system(left), workers=workers, quick=True).growth * bare.rate[left]
        places = np.arange(_PLACES)
        for row in alone[np.isnan(alone).any(axis=1)]:  # at the edge of a tongue, to some digits: like its neighbours
            known = ~np.isnan(row)
            row[~known] = np.interp(places[~known], places[known], row[known]) if known.any() else math.inf
    white = growth_of_white_noise(bare.squared, np.square(moved.intensity))
    return np.where(left, 2.0 * alone + np.maximum(0.0, white - 2.0 * still) - 2.0 * c, growth)


def _largest(diagonal: Floats, side: float) -> float:
    """Return the largest eigenvalue of the second difference times ``side``, plus a diagonal."""
    from scipy.linalg import eigh_tridiagonal

    if not np.isfinite(diagonal).all():
        return math.inf
    last = diagonal.size - 1
    found = eigh_tridiagonal(
        diagonal - 2.0 * side, np.full(last, side), eigvals_only=True, select="i", select_range=(last, last)
    )
    return float(found[0])


def _ends(parts: ModeCoefficients, variance: Floats, density: Floats) -> tuple[Floats, Floats]:
    """Return how much stiffness the drift may add, and take, as far as it matters, in 1/s^2, (loads, modes)."""
    # A drift by y makes moments grow at 2 sqrt(y + sizes - w^2) at most where it buckles the mode, at sizes / w and
    # s^2 / 2 w^2 where it does not, and costs y^2 / 2 S.  The iteration falls to the largest y at which both are equal.
    sizes, scale = parts.sizes(0), np.maximum(np.abs(parts.squared), np.square(parts.frequency) * 1e-12)
    shaken = sizes / np.sqrt(scale) + 0.5 * np.square(parts.intensity) / scale
    farthest = np.cbrt(np.square(4.0 * density)) + sizes + np.abs(parts.squared)
    for _ in range(_STEPS):
        buckled = 2.0 * np.sqrt(np.maximum(0.0, farthest + sizes - parts.squared))
        farthest = np.minimum(farthest, np.sqrt(2.0 * density * (buckled + shaken)))
    deviation = _DEVIATIONS * np.sqrt(variance)
    return (
        np.maximum(deviation, _BEYOND * np.sqrt(2.0 * density * shaken)),
        np.maximum(deviation, _BEYOND * farthest),
    )


def _bound(parts: ModeCoefficients, most: Floats, noise: Noise, paired: Floats) -> Any:
    """Return a bound of the growth in 1/s as the drift takes at most so much stiffness, infinite where it buckles."""
    # u'^2 + L u^2 grows at most at sizes / sqrt(L) and by the white noise, L = w^2 - c^2 less the drift.
    least = parts.squared - parts.damping**2 - most
    held = least > 0.0
    least = np.where(held, least, 1.0)
    hertz = np.maximum(np.sqrt(least) / math.pi, 0.5 * parts.reference)
    strongest = np.square(parts.with_density(largest_density(noise, hertz)).intensity) + np.square(paired)
    rate = parts.sizes(0) / np.sqrt(least) + growth_of_white_noise(least, strongest) - 2.0 * parts.damping
    other = parts._replace(squared=parts.squared - most, intensity=np.sqrt(strongest)).growth_bounds[1]
    return np.where(held, np.minimum(rate, other), math.inf)
