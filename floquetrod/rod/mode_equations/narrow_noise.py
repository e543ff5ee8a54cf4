"""Noise in a narrow band: between which densities it acts on a mode as white noise would.

A mode of frequency f grows in mean square at 4 g^2 S - 2 c under white noise of density S, and at g A - c under a sine
of amplitude A and frequency 2 f, with a tongue from 2 f - g A / pi to 2 f + g A / pi.  Noise within d of 2 f has the
mean square V(d), the integral of S from 2 f - d to 2 f + d.  As its amplitude changes slowly it acts like a sine while
d is less than the half-width of the tongue of a sine three times as strong, 3 sqrt(2 V(d)) g / pi: the large
amplitudes, though rare, make the growth in mean square.  Within such a d it is not told from white noise of its mean,
V(d) / 2 d, and where this differs from S(2 f) the growth is known between both alone.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.rod.loads.load import Noise, density_at

_TOGETHER = 3.0 * math.sqrt(2.0) / math.pi  # half-width in Hz of the tongue, over g sqrt(V) (a choice: three times)
_DISTANCES = np.geomspace(1e-4, 1.0, 64)  # d over the highest frequency of the noise (a choice)
_EVEN = 1e-3  # difference of densities, relative to the density, that is none (a choice)
_PAIRS = 65  # frequencies of an integral (a choice)
_SURE = 0.7  # of a mean density, that is counted on (a choice)
_AT_ONCE = 1 << 13  # frequencies


class Densities(NamedTuple):
    """Least and largest density in N^2/Hz, and the distance in Hz within which the largest is found."""

    least: Floats
    most: Floats
    distance: Floats


class Excess(NamedTuple):
    """What exceeds the density of noise at twice the frequency of a mode, below it.

    Attributes
    ----------
    variance : ndarray
        Of the force in N^2.
    density : ndarray
        Largest density in N^2/Hz with which the force stays away from its mean.
    pairs : ndarray
        Integral in N^4/Hz^5 of S(v) S(2 f - v) / (v (2 f - v))^2 over v about f, f the frequency of the mode, less what
        white noise of the density at 2 f has.
    least_variance, least_density : ndarray
        Of the part below f / 2, variance, and 0.7 times its mean density weighted with itself: a part of what acts on
        the mode as if it were constant.
    """

    variance: Floats
    density: Floats
    pairs: Any
    least_variance: Any
    least_density: Any


def excess_below(noise: Noise, hertz: Floats) -> Excess:
    """Return by how much the density of noise below frequencies in Hz exceeds that at them."""
    if not isinstance(noise, tuple):
        return Excess(*np.zeros((5, *np.shape(hertz))))
    flat = np.ravel(hertz)
    blocks = [_excess(noise, flat[start : start + _AT_ONCE]) for start in range(0, flat.size, _AT_ONCE)]
    return Excess(*(np.concatenate(each).reshape(np.shape(hertz)) for each in zip(*blocks, strict=True)))


def _excess(noise: tuple[tuple[float, float], ...], hertz: Floats) -> Excess:
    """Return the excess below flat frequencies, by trapezoids, which are above a part that begins between places."""
    at, own = np.array([0.0, *(pair[0] for pair in noise if pair[0] > 0.0)]), density_at(noise, hertz)
    below = np.minimum(at, hertz[:, None])
    over = np.maximum(0.0, density_at(noise, below) - own[:, None])
    variance = (0.5 * np.diff(below, axis=1) * (over[:, 1:] + over[:, :-1])).sum(axis=1)
    # A force that stays at F takes F^2 / S of the probability per unit of time, a slow sine of the amplitude F twice as
    # much in a narrow band; it is not slow beside the mode from a quarter of 2 f on.
    density = np.where(below <= 0.25 * hertz[:, None], over, 0.5 * over).max(axis=1)
    v = hertz[:, None] * np.linspace(0.25, 0.5, _PAIRS)
    other = hertz[:, None] - v
    product = density_at(noise, v) * density_at(noise, other) - np.square(own)[:, None]
    weight = np.square(np.maximum(v * other, np.finfo(float).tiny))
    pairs = np.asarray(2.0 * np.trapezoid(np.maximum(0.0, product) / weight, v, axis=1))
    slow = np.minimum(at, 0.25 * hertz[:, None])
    over = np.maximum(0.0, density_at(noise, slow) - own[:, None])
    width = 0.5 * np.diff(slow, axis=1)
    known = (width * (over[:, 1:] + over[:, :-1])).sum(axis=1)
    square = (width * (np.square(over[:, 1:]) + np.square(over[:, :-1]))).sum(axis=1)
    least = np.divide(_SURE * square, known, out=np.zeros_like(known), where=known > 0.0)
    return Excess(variance, density, pairs, known, least)


def densities_about(noise: Noise, hertz: Floats, gain: Floats) -> Densities:
    """Return between which densities noise acts on modes, from frequencies 2 f in Hz and g in 1/(N s), of one shape."""
    if not isinstance(noise, tuple):
        density = density_at(noise, hertz)
        return Densities(density, density, np.zeros_like(density))
    flat = [np.ravel(each) for each in np.broadcast_arrays(hertz, gain)]
    blocks = range(0, flat[0].size, _AT_ONCE)
    found = [_about(noise, *(each[start : start + _AT_ONCE] for each in flat)) for start in blocks]
    shape = np.broadcast_shapes(np.shape(hertz), np.shape(gain))
    return Densities(*(np.concatenate(each).reshape(shape) for each in zip(*found, strict=True)))


def _about(noise: tuple[tuple[float, float], ...], hertz: Floats, gain: Floats) -> Densities:
    """Return the densities about flat frequencies."""
    at = np.array([0.0, *(pair[0] for pair in noise if pair[0] > 0.0)])
    density = density_at(noise, at)
    whole = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(at) * (density[1:] + density[:-1]))])

    def mean_square(to: Any) -> Any:
        """Return the integral of the density from 0 to a frequency, a parabola between two of its places."""
        place = np.clip(np.searchsorted(at, to, side="right") - 1, 0, at.size - 1)
        part = np.minimum(to, at[-1]) - at[place]
        return whole[place] + 0.5 * part * (density[place] + density_at(noise, at[place] + part))

    distance = _DISTANCES * at[-1]
    below = np.maximum(0.0, hertz[:, None] - distance)
    strength = np.maximum(0.0, mean_square(hertz[:, None] + distance) - mean_square(below))
    own = density_at(noise, hertz)
    together = distance <= _TOGETHER * gain[:, None] * np.sqrt(strength)
    mean = np.where(together, strength / (hertz[:, None] + distance - below), own[:, None])
    place = mean.argmax(axis=1)
    least, most = mean.min(axis=1), mean[np.arange(hertz.size), place]
    least, most = (np.where(np.abs(each - own) > _EVEN * own, each, own) for each in (least, most))
    return Densities(np.minimum(least, own), np.maximum(most, own), distance[place])
