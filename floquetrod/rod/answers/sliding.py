"""The damping by friction of a wave across a string that slides along its channel.

Coulomb's friction points against the whole velocity.  Of a string that slides at a = v + V cos(w t) along and moves at
u across the part mu N u / hypot(a, u) is across: a slow wave is damped as if by a fluid, at mu N / (2 m abs(a)), a fast
one by a constant force.  Of two frequencies, whose phases are free, the mean is over both phases.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.roots import bisected

_FASTEST = 1e3  # m/s of a wave across: beyond, friction does nothing
_HALVINGS = 60

_T = 0.2 * np.arange(-16, 17)
_NODES = np.tanh(0.5 * math.pi * np.sinh(_T))
_WEIGHTS = 0.1 * math.pi * np.cosh(_T) / np.cosh(0.5 * math.pi * np.sinh(_T)) ** 2
"""Of means over (-1, 1) of functions with logarithms at the ends: Takahasi and Mori's double exponential formula."""


def damping_across(
    pressed: Floats, sliding: float, shaking: Floats, across: Floats, other: Floats | None = None
) -> Floats:
    """Return the decay rate in 1/s of waves across, by friction alone.

    Parameters
    ----------
    pressed : ndarray
        Friction over inertia, mu N / m, in m/s^2.
    sliding : float
        v, the mean speed along in m/s, positive.
    shaking : ndarray
        V, amplitude of the speed along in m/s.
    across : ndarray
        U, amplitude of the speed across in m/s.
    other : ndarray, optional
        V', amplitude of the speed along in m/s at a second frequency.

    Notes
    -----
    mu N / (2 m) times the mean of 1 / hypot(v + V cos, pi U / 4), which is 1 / agm(Re r, abs(r)) with
    r^2 = (v + V + i w) (v - V - i w), w = pi U / 4 (DLMF 19.8.5).  It takes the energy that friction takes where U is
    much less and where it is much more than the speed along; in between it is within 4 % of it.  With a second
    frequency the mean of this over the phase p of the weaker one, with v + V' cos p for v, to 1e-4.
    """
    w = 0.25 * math.pi * np.asarray(across)
    with np.errstate(divide="ignore", invalid="ignore"):
        if other is None:
            mean = _inverse_speed(sliding, shaking, w)
        else:
            mean = _mean_inverse_speed(sliding, np.maximum(shaking, other), np.minimum(shaking, other), w)
        return np.where(pressed > 0.0, 0.5 * pressed * mean, 0.0)


def _inverse_speed(sliding: Any, shaking: Floats, w: Floats) -> Floats:
    """Return the mean of 1 / hypot(v + V cos, w)."""
    from scipy.special import agm

    root = np.sqrt((sliding + shaking + 1j * w) * (sliding - shaking - 1j * w))
    return np.asarray(1.0 / agm(root.real, np.abs(root)))


def _mean_inverse_speed(sliding: float, strong: Floats, weak: Floats, w: Floats) -> Floats:
    """Return the mean of 1 / hypot(v + V cos + V' cos, w) over both phases."""
    # Between the phases of the weaker wave at which v + V' cos p is V or -V, where the mean over the other is largest.
    turns = [np.arccos(np.clip((size - sliding) / np.maximum(weak, 1e-300), -1.0, 1.0)) for size in (strong, -strong)]
    total = np.zeros(strong.shape)
    for low, high in pairwise((np.zeros(strong.shape), *turns, np.full(strong.shape, math.pi))):
        phase = 0.5 * (low + high)[..., None] + 0.5 * (high - low)[..., None] * _NODES
        values = _inverse_speed(sliding + weak[..., None] * np.cos(phase), strong[..., None], w[..., None])
        total += np.where(high > low, 0.5 * (high - low) * (values @ _WEIGHTS), 0.0)
    return total / math.pi


def least_speed(rate: Floats, pressed: Floats, sliding: float, shaking: Floats, other: Floats | None = None) -> Floats:
    """Return the speed across in m/s above which waves that grow at ``rate`` in 1/s without friction grow with it.

    0 where any does, infinite where none.  Friction damps a faster wave less.
    """

    def grows(across: Floats) -> Bools:
        return np.asarray(rate > damping_across(pressed, sliding, shaking, across, other))

    low = np.zeros(rate.size)
    none = grows(low)
    high = np.where(rate > 0.0, np.minimum(2.0 / math.pi * pressed / np.maximum(rate, 1e-300), _FASTEST), 0.0)
    _, high = bisected(lambda u: ~grows(u), low, high, _HALVINGS)
    return np.where(none, 0.0, np.where(rate > 0.0, high, math.inf))
