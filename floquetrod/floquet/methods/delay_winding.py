"""Zeros of a determinant of one period: multipliers of systems with long delays, counted by a winding number.

J. Sieber and R. Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011) 129, doi:10.1137/100796455.
"""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util import validate
from floquetrod.equations import DelaySystem
from floquetrod.floquet.multipliers import delay_roots, delay_series, delay_steps, spectra
from floquetrod.floquet.multipliers.classification import LogDiscs, classify_multipliers
from floquetrod.floquet.multipliers.delay_series import DelaySeries, Zeros
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost

_FURTHEST = 1e4  # |mu|^-r, r the longest delay in periods, up to which the largest multiplier is sought (a choice)
_FURTHER = 2.0  # times as far, where there is none yet
_NEARER = (1.5, 1.05)  # the same, where solutions grow too fast for what is asked
_BESIDE = (1.0, 1.11, 1.23)  # of the bound of |mu|^-r: circles tried until none of their points is a multiplier

_LEFT_OUT = "multipliers of modulus below {:.3g} are left out"


def winding(system: DelaySystem, *, above: float = 0.5) -> SystemStability:
    """Classify by the zeros of det(mu I - Phi(mu^-r)), Phi(s) the map of the system whose delayed terms are times s.

    A solution with x(t + T) = mu x(t) has x(t - r T) = mu^-r x(t).  Phi is entire in s: its Taylor series comes from
    maps on a circle, which take no longer for long delays than for short ones.  A winding number counts the multipliers
    above a modulus, and Newton's method finds as many.

    Parameters
    ----------
    system : DelaySystem
        One whose delays are whole multiples of the period, or of a part of it: at most 24 unknowns in all parts.  Of
        constant coefficients the delays may be whole multiples of any step.
    above : float
        Modulus above which multipliers are found, the largest in any case, over the period or the longest delay,
        whichever is longer; from 1e-4 to 0.9.

    Returns
    -------
    SystemStability
        Its errors hold the truncation and the rounding of the maps, over the derivative of the determinant.

    Examples
    --------
    >>> import math
    >>> system = DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], delayed=[(200.0 * math.pi, [[0.2]])])
    >>> found = winding(system)
    >>> found.status, sum(abs(mu) > 1.0 for mu in found.multipliers), f"{abs(found.multipliers[0]):.12f}"
    ('unstable', 20, '1.003148769600')
    """
    above = validate.within("above", above, 1e-4, 0.9)
    pieces = delay_steps.step_pieces(system)
    points = 0
    for reach in (1.0 / above, *_NEARER):
        while reach <= max(_FURTHEST, 1.0 / above):
            series = delay_steps.series(pieces, _BESIDE[-1] * reach)
            zeros = None if series is None else _within(series, reach)
            points += 0 if series is None else len(series.exponents)
            if series is None or zeros is None:
                break
            if zeros.values.size:
                logs = _logarithms(series, zeros)
                least = reach ** -(pieces.parts / pieces.slowest)
                if system.is_constant:
                    logs = delay_roots.per_period(system, logs, float(pieces.period))
                    least **= float(system.period) / float(pieces.period)
                cost, note = Cost(points, "coefficients"), _LEFT_OUT.format(least)
                return classify_multipliers(system, "winding", logs, cost=cost, note=note)
            reach *= _FURTHER
    note = "solutions grow too fast within a period, or multipliers cannot be distinguished from each other"
    return SystemStability.declined(system, "winding", Cost(points, "coefficients"), note)


def _within(series: DelaySeries, reach: float) -> Zeros | None:
    """Return the zeros within a circle, or one a little larger."""
    for beside in _BESIDE:
        radius = math.log(reach * beside) / max(series.longest, series.parts)
        count = delay_series.outside(series, radius)
        if count is not None:
            return delay_series.zeros(series, radius, count)
    return None


def _logarithms(series: DelaySeries, zeros: Zeros) -> LogDiscs:
    """Return the logarithms of multipliers from zeros, l = log v: log mu = -q l, conjugates included."""
    upper = (zeros.values.imag > 0.0) & (zeros.values.imag < series.half_turn)
    values = -series.parts * np.concatenate([zeros.values, zeros.values[upper].conj()])
    values.imag[values.imag <= -math.pi] = math.pi
    radii = series.parts * np.concatenate([zeros.radii, zeros.radii[upper]])
    return LogDiscs.about(values, radii, spectra.touching(spectra.log_distances(values, values), radii))
