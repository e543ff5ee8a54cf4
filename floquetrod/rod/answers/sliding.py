"""The damping by friction of a wave across a string that slides along its channel.

Coulomb's friction points against the whole velocity.  Of a string that slides at a = v + V cos(w t) along and moves at
u across the part mu N u / hypot(a, u) is across: a slow wave is damped as if by a fluid, at mu N / (2 m abs(a)), a fast
one by a constant force.
"""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.roots import bisected

_FASTEST = 1e3  # m/s of a wave across: beyond, friction does nothing
_HALVINGS = 60


def damping_across(pressed: Floats, sliding: float, shaking: Floats, across: Floats) -> Floats:
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

    Notes
    -----
    mu N / (2 m) times the mean of 1 / hypot(v + V cos, pi U / 4), which is 1 / agm(Re r, abs(r)) with
    r^2 = (v + V + i w) (v - V - i w), w = pi U / 4 (DLMF 19.8.5).  It takes the energy that friction takes where U is
    much less and where it is much more than the speed along; in between it is within 4 % of it.
    """
    from scipy.special import agm

    w = 0.25 * math.pi * np.asarray(across)
    root = np.sqrt((sliding + shaking + 1j * w) * (sliding - shaking - 1j * w))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(pressed > 0.0, 0.5 * pressed / agm(root.real, np.abs(root)), 0.0)


def least_speed(rate: Floats, pressed: Floats, sliding: float, shaking: Floats) -> Floats:
    """Return the speed across in m/s above which waves that grow at ``rate`` in 1/s without friction grow with it.

    0 where any does, infinite where none.  Friction damps a faster wave less.
    """
    low = np.zeros(rate.size)
    none = rate > damping_across(pressed, sliding, shaking, low)
    high = np.where(rate > 0.0, np.minimum(2.0 / math.pi * pressed / np.maximum(rate, 1e-300), _FASTEST), 0.0)
    _, high = bisected(lambda u: ~(rate > damping_across(pressed, sliding, shaking, u)), low, high, _HALVINGS)
    return np.where(none, 0.0, np.where(rate > 0.0, high, math.inf))
