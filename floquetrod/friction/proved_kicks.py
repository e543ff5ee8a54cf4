"""Kicks whose fate is proved: up to which none escapes, above which every one does (page `theory/friction`)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.roots import bisected
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.friction.inputs import Prepared, growth_of, prepare_one
from floquetrod.friction.kernels.cell import slope, value
from floquetrod.friction.kernels.records import PERIOD
from floquetrod.friction.propagators import Records

_HALVINGS = 45  # of a cell in search of the time of a stop, to far less than `_ROUNDED`
_STEEP = 1e12  # a slope beyond which the kick that stops is at its limit, to rounding
_LONGEST_PUSH = 8.0 * math.pi  # how long first stops are followed: a shorter time gives a lower bound
_ROUNDED = 1e-12  # relative: a proved kick is lowered by it, far more than its error of rounding (measured)


class CertainKicks(NamedTuple):
    """The kicks whose fate is proved.

    Attributes
    ----------
    bounded_up_to : float
        No kick up to it escapes; infinite where none ever does.
    escapes_above : float
        Every kick above it escapes; infinite where there is no such kick.
    """

    bounded_up_to: float
    escapes_above: float


def certain_kicks(equation: FrictionalMathieu) -> CertainKicks:
    """Return the kick up to which none escapes, and that above which every one does: both proved.

    The second is infinite where nothing grows without friction; the page `theory/friction` derives them.

    Returns
    -------
    CertainKicks
        Both, per unit tau.

    Raises
    ------
    TypeError
        For another equation.

    Examples
    --------
    >>> round(certain_kicks(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0)).bounded_up_to, 9)
    2.0
    """
    require(equation, (FrictionalMathieu,), "certain_kicks")
    rate = growth_of(equation)
    if rate < 0.0:
        return CertainKicks(math.inf, math.inf)
    if equation.alpha == equation.beta == 0.0:
        return CertainKicks(math.inf, math.inf) if equation.gamma > 0.0 else CertainKicks(0.0, 0.0)
    low, high = proved(prepare_one(equation, rate))
    return CertainKicks(equation.gamma * low.item(), equation.gamma * high.item())


def proved(prepared: Prepared) -> tuple[Floats, Floats]:
    """Return the kicks over gamma up to which none escapes, and those above which every one does."""
    ceiling = prepared.propagators.ceiling
    return np.minimum(_no_kick_escapes_up_to(prepared), ceiling), ceiling


def _no_kick_escapes_up_to(prepared: Prepared) -> Floats:
    """Return a kick up to which none escapes: the first stop is within ``safe``, and none moves farther out from there.

    Up to the first stop A = kick S + F, S and F the motions from A' = 1 without friction and from rest with it; the
    kick g = -F' / S' stops at tau, at A = g S + F.  Both grow with tau until A is ``safe`` (page `theory/friction`);
    the kick that stops there is returned, or g at the time where S' is so steep that g equals its limit to rounding.
    """
    alpha, beta = prepared.coefficients["alpha"], prepared.coefficients["beta"]
    first, cells, bases, _ = prepared.propagators
    outward = beta + np.abs(alpha)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        safe = 2.0 / np.abs(alpha)
        safe = np.where(outward > 0.0, np.minimum(safe, 1.0 / outward), safe)
        best = 1.0 / np.sqrt(np.abs(alpha) + np.abs(beta))  # by comparison with the largest force throughout
        counts = np.diff(first)
        active = np.flatnonzero(np.isfinite(best))
        s0, s1, f0, f1 = np.zeros(best.size), np.ones(best.size), np.zeros(best.size), np.zeros(best.size)
        k = 0
        while active.size:
            i, place = active, first[active] + k % counts[active]
            cell = cells[place]
            m11, m12, m21, m22 = cell["m11"], cell["m12"], cell["m21"], cell["m22"]
            t0, t1 = m11 * s0[i] + m12 * s1[i], m21 * s0[i] + m22 * s1[i]
            r0, r1 = m11 * f0[i] + m12 * f1[i] + cell["f1"], m21 * f0[i] + m22 * f1[i] + cell["f2"]
            beyond = t1 * (safe[i] - r0) + t0 * r1 <= 0.0  # the kick that stops here stops beyond ``safe``
            j, within = i[beyond], i[~beyond]
            if j.size:
                s = _motion(bases[place[beyond]], s0[j], s1[j], 0.0)
                f = _motion(bases[place[beyond]], f0[j], f1[j], 1.0)
                best[j] = np.maximum(best[j], _kick_that_stops_at(safe[j], s, f))
            s0[i], s1[i], f0[i], f1[i] = t0, t1, r0, r1
            best[within] = np.maximum(best[within], -f1[within] / s1[within])
            k += 1
            active = within[(s1[within] < _STEEP) & (k * PERIOD / counts[within] < _LONGEST_PUSH)]
    bound: Floats = best * (1.0 - _ROUNDED)
    return bound


def _motion(bases: Records, a: Floats, velocity: Floats, s: float) -> Floats:
    """Return the series of motions in a cell each, from A = a and A' = velocity at its beginning."""
    whole: Floats = (a[:, None] * bases["from_a"] + velocity[:, None] * bases["from_velocity"] + s * bases["forced"]).T
    return whole


def _kick_that_stops_at(safe: Floats, s: Floats, f: Floats) -> Floats:
    """Return the kick -F' / S' of the time in the cell at which the kick that stops there stops at ``safe``."""

    def before(x: Floats) -> Bools:
        stops: Floats = slope(s, x) * (safe - value(f, x)) + value(s, x) * slope(f, x)
        return ~(stops <= 0.0)  # NaN too

    low, _ = bisected(before, np.zeros(safe.size), np.ones(safe.size), _HALVINGS)
    return np.where(low > 0.0, -slope(f, low) / slope(s, low), 0.0)
