"""The lowest uniform damping rate above which no motion grows, by a search over rates."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from floquetrod._util.arrays import EPS, Floats
from floquetrod.equations import DelaySystem, HillSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.matrices import mass_matrix
from floquetrod.floquet.multipliers import delay_growth, delay_maps, whole_period_maps

_TIMES = 2.0 ** np.arange(-1, 4)  # the growth rate: damping rates tried (a choice)
_PARTS = 2.0 ** np.arange(-12, 1)  # of the fastest frequency: damping rates tried as well (a choice)
_LEAST = 1e-6  # of the forcing's frequency: growth rates below it are taken as so large (a choice)
_MOST_SECONDS = 60.0  # estimated for all maps (a choice)
_MAPS = 40  # about as many as a search takes
_ACCURACY = 1e-12  # of a map; growth over a period up to ten times as much cannot be distinguished from none
_PRECISION = 1e-10  # relative, of the rate found


def least_damping(
    excess: Callable[[float], float],
    growth: float,
    frequency: float,
    further: Floats | None = None,
    uncertainty: float = 0.0,
) -> float:
    """Return the lowest damping rate above which no motion grows, to ten digits, at all rates tried.

    Parameters
    ----------
    excess : callable (rate) -> float
        Growth rate at a damping rate; not above zero at some large rate.
    growth : float
        About the rate searched for: half, one, two, four and eight times as much are tried.
    frequency : float
        Angular frequency of the forcing; of a smaller growth rate than a millionth of it, that is tried.
    further : ndarray, optional
        Other rates to try.
    uncertainty : float
        Growth rate that cannot be distinguished from none.

    Returns
    -------
    float
        0 where nothing grows at any rate tried, nor without damping; NaN where ``excess`` is NaN or within its error.
    """
    from scipy.optimize import brentq

    growth_at = functools.cache(excess)
    scale = max(growth, _LEAST * frequency)
    tried = np.unique(np.concatenate([scale * _TIMES, [] if further is None else further])).tolist()
    values = [growth_at(rate) for rate in tried]
    if not all(abs(value) >= uncertainty for value in values):
        return math.nan
    growing = [i for i, value in enumerate(values) if value > 0.0]
    if not growing:
        if not growth_at(0.0) > 0.0:
            return 0.0
        low, high = 0.0, tried[0]
    else:
        low, *above = tried[growing[-1] :]
        high = above[0] if above else 2.0 * low
    while growth_at(high) > 0.0:
        low, high = high, 2.0 * high
    if math.isnan(growth_at(high)):
        return math.nan
    return float(brentq(growth_at, low, high, xtol=_PRECISION * max(low, 1e-3 * high), rtol=_PRECISION))


def damping_to_stabilise(system: HillSystem, growth: float) -> float:
    """Return the lowest c for which no solution of M q'' + (C + 2 c M + G) q' + K(t) q = 0 grows, as far as tried.

    ``growth`` is the growth rate without c, 0 where the system is stable.  Infinite where M^-1 times the mean of K has
    an eigenvalue of negative real part, along which strong damping only slows the growth; NaN where the search would
    take more than about a minute, or growth cannot be distinguished from none.
    """
    n, period = system.order, float(system.period)
    mass = mass_matrix(system)
    stiffness = np.linalg.solve(mass, system.stiffness)
    sizes = [float(np.linalg.norm(np.linalg.solve(mass, m), 2)) for m in (*system.cosines, *system.sines)]
    pieces = by_pieces.in_time(system) if system.pieces else ()
    sizes += [float(np.linalg.norm(np.linalg.solve(mass, piece.size), 2)) for piece in pieces]
    size = float(np.linalg.norm(stiffness, 2))
    if float(np.linalg.eigvals(stiffness).real.min()) < -8.0 * n * EPS * size * float(np.linalg.cond(mass)):
        return math.inf
    rates = math.sqrt(size + sum(sizes)) * _PARTS
    present = 0.0 if system.damping is None else system.damping

    def damped(rate: float) -> by_pieces.PieceArrays:
        return by_pieces.of_batch(replace(system, damping=present + 2.0 * rate * mass).as_periodic_system())

    def excess(rate: float) -> float:
        """Return the growth rate, negative where everything decays."""
        if rate == 0.0:
            return growth
        first_order = damped(rate)
        if float(whole_period_maps.seconds_needed(first_order)[0]) * _MAPS > _MOST_SECONDS:
            return math.nan
        return whole_period_maps.growth_rate(first_order, _ACCURACY)

    return least_damping(
        excess, growth, 2.0 * math.pi / period, further=np.asarray(rates), uncertainty=10.0 * _ACCURACY / period
    )


def damping_of_delayed(system: DelaySystem, growth: float) -> float:
    """Return the lowest c for which no solution of a system with delays grows with C + 2 c M, or with A - c I.

    As `damping_to_stabilise`, infinite where the mean of M^-1 (K + sum_j D_j) has an eigenvalue of negative real part.
    """
    n, period, further = system.order, float(system.period), None
    if isinstance(system.present, HillSystem):
        mass = mass_matrix(system.present)
        still = np.linalg.solve(mass, sum((term.coefficient.mean for term in system.delayed), system.present.stiffness))
        if float(np.linalg.eigvals(still).real.min()) < -8.0 * n * EPS * float(np.linalg.norm(still, 2)):
            return math.inf
        further = np.asarray(delay_maps.rate(system) * _PARTS)

    def excess(rate: float) -> float:
        """Return the growth rate, negative where everything decays."""
        return delay_growth.growth_rate(system.damped(rate))

    return least_damping(excess, growth, 2.0 * math.pi / period, further=further, uncertainty=10.0 * _ACCURACY / period)
