"""Zeros of a determinant of one period: multipliers of systems with long delays, counted by a winding number.

J. Sieber and R. Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011) 129, doi:10.1137/100796455.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import DelaySystem
from floquetrod.equations.delay_system import moved
from floquetrod.floquet import registry
from floquetrod.floquet.multipliers import (
    delay_blocks,
    delay_maps,
    delay_roots,
    delay_series,
    delay_steps,
    spectra,
    whole_steps,
)
from floquetrod.floquet.multipliers.classification import LogDiscs, classify_multipliers
from floquetrod.floquet.multipliers.delay_series import DelaySeries, Zeros
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost

_FURTHEST = 1e4  # |mu|^-r, r the longest delay in periods, up to which the largest multiplier is sought (a choice)
_FURTHER = 2.0  # times as far, where there is none yet
_NEARER = (1.5, 1.05)  # the same, where solutions grow too fast for the accuracy wanted
_BESIDE = (1.0, 1.11, 1.23)  # of the bound of |mu|^-r: circles tried until none of their points is a multiplier

_NODES = (8, 12, 18, 24, 32, 44)  # in a piece, where a period is collocated (a choice)
_UNCHANGED, _USABLE = 1e-11, 1e-6  # changes of logarithms at which refinement ends, and that are taken (a choice)
_LEFT_OUT = "multipliers of modulus below {:.3g} are left out"


def winding(system: DelaySystem, *, above: float = 0.5) -> SystemStability:
    """Classify by the zeros of det(mu I - Phi(mu^-r)), Phi(s) the map of the system whose delayed terms are times s.

    A solution with x(t + T) = mu x(t) has x(t - r T) = mu^-r x(t).  Phi is entire in s: its Taylor series comes from
    maps on a circle, which take no longer for long delays than for short ones.  A winding number counts the multipliers
    above a modulus, and Newton's method finds as many.  Delays that are no whole numbers of a step, a part of the
    period with at most 24 unknowns in all parts, take collocation of one period instead of maps, with the unknowns of
    earlier periods as powers of 1 / mu.

    Parameters
    ----------
    system : DelaySystem
        One with delays, not longer than 4,000 steps; collocation takes at most 240 rows a period.  Else the result is
        undecided.
    above : float
        Modulus above which multipliers are found, the largest in any case, over the period or the longest delay,
        whichever is longer; from 1e-4 to 0.9.

    Returns
    -------
    SystemStability
        Its errors hold the truncation and the rounding of the maps, over the derivative of the determinant; by
        collocation they are estimates, twice the change to fewer nodes.  In both cases twice the change by coefficients
        off by their error is added.

    Raises
    ------
    TypeError, ValueError
        For a system without delays, and for ``above`` outside 1e-4 to 0.9.

    Examples
    --------
    >>> import math
    >>> system = DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], delayed=[(200.0 * math.pi, [[0.2]])])
    >>> found = winding(system)
    >>> found.status, sum(abs(mu) > 1.0 for mu in found.multipliers), f"{abs(found.multipliers[0]):.12f}"
    ('unstable', 20, '1.003148769600')
    """
    above = validate.within("above", above, 1e-4, 0.9)
    if needed := registry.refusal(system, "winding"):
        raise TypeError(f"{needed}, got {validate.short(system)}")
    laid = whole_steps.steps(system)
    if laid is None:
        return _by_collocation(system, above)
    pieces = delay_steps.step_pieces(system, laid)
    found, points = _largest(lambda reach: delay_steps.series(pieces, _BESIDE[-1] * reach), above)
    cost = Cost(points, "coefficients")
    if found is None:
        note = "solutions grow too fast within a period, or multipliers cannot be distinguished from each other"
        return SystemStability.declined(system, "winding", cost, note)
    for other in moved(system) if system.coefficient_error else ():
        shifted = delay_steps.series(delay_steps.step_pieces(other, laid), _BESIDE[-1] * found.reach)
        found = found._replace(zeros=_with_change(found.zeros, shifted))
    return _classified(system, found, float(pieces.period), cost)


def _with_change(zeros: Zeros, shifted: DelaySeries | None) -> Zeros:
    """Return zeros whose discs also hold twice the change to the zeros of another series."""
    values = None if shifted is None else delay_series.followed(shifted, zeros.values)
    changes = math.inf if values is None else np.abs(values - zeros.values)
    return zeros._replace(radii=zeros.radii + 2.0 * changes)


class _Refined(NamedTuple):
    """Zeros on a mesh, and their changes from a coarser one."""

    nodes: int  # in a piece
    series: DelaySeries
    values: Complexes
    changes: Floats


def _by_collocation(system: DelaySystem, above: float) -> SystemStability:
    """Classify by collocation of one period, with more nodes until multipliers stay as they are."""
    laid = delay_maps.period_pieces(system)
    values: Complexes | None = None
    best: _Refined | None = None
    reach, rows = 1.0, 0
    for count in _NODES:
        series = delay_blocks.series(system, laid, count)
        if series is None:
            break
        before, rows = values, series.matrices.shape[-1]
        if before is None:
            largest, _ = _largest(_at_any_reach(series), above)
            if largest is not None:
                reach, values = largest.reach, largest.zeros.values
        else:
            values = delay_series.followed(series, before)
        if values is None or (best is None and before is not None and not _are_all(series, values, reach)):
            break
        if before is not None:
            changes = np.abs(values - before)
            if best is not None and changes.max() >= best.changes.max():
                break
            best = _Refined(count, series, values, changes)
            if changes.max() <= _UNCHANGED:
                break
    cost = Cost(rows, "rows")
    if best is None or not best.changes.max() <= _USABLE:
        note = "needs collocation of too many rows, or its multipliers cannot be distinguished from each other"
        return SystemStability.declined(system, "winding", cost, note)
    zeros = delay_series.discs(best.series, best.values)
    zeros = zeros._replace(radii=zeros.radii + 2.0 * best.changes)
    for other in moved(system) if system.coefficient_error else ():
        zeros = _with_change(zeros, delay_blocks.series(other, laid, best.nodes))
    return _classified(system, _Largest(best.series, zeros, reach), laid.period, cost)


def _at_any_reach(series: DelaySeries) -> Callable[[float], DelaySeries]:
    """Return a series as a function of the reach, on which it does not depend."""
    return lambda _: series


class _Largest(NamedTuple):
    """The zeros of the largest multipliers, those with |mu|^-r up to ``reach``, r the longest delay in periods."""

    series: DelaySeries
    zeros: Zeros
    reach: float


def _largest(series_to: Callable[[float], DelaySeries | None], above: float) -> tuple[_Largest | None, int]:
    """Return the zeros of multipliers above a modulus, one at least, and how many coefficients were computed.

    ``series_to`` gives a series that holds up to a reach; without one, or without any zeros, None is returned.
    """
    coefficients = 0
    for reach in (1.0 / above, *_NEARER):
        while reach <= max(_FURTHEST, 1.0 / above):
            series = series_to(reach)
            if series is None:
                break
            coefficients += len(series.exponents)
            zeros = _within(series, reach)
            if zeros is None:
                break
            if zeros.values.size:
                return _Largest(series, zeros, reach), coefficients
            reach *= _FURTHER
    return None, coefficients


def _classified(system: DelaySystem, found: _Largest, period: float, cost: Cost) -> SystemStability:
    """Return the verdict from the zeros of multipliers over a period, which of constant coefficients is a step."""
    series = found.series
    logs, least = _logarithms(series, found.zeros), found.reach ** -(series.parts / max(series.parts, series.longest))
    if system.is_constant:
        logs = delay_roots.per_period(system, logs, period)
        least **= float(system.period) / period
    return classify_multipliers(system, "winding", logs, cost=cost, note=_LEFT_OUT.format(least))


def _are_all(series: DelaySeries, values: Complexes, reach: float) -> bool:
    """Return whether a finer series has as many zeros as have been followed."""
    upper = (values.imag > 0.0) & (values.imag < series.half_turn)
    farthest = float(values.real.max())
    for beside in (_BESIDE[0], *_BESIDE):
        radius = math.log(reach * beside) / series.longest
        if radius >= farthest:
            count = delay_series.outside(series, radius)
            if count is not None:
                return count == int(np.where(upper, 2, 1).sum())
    return False


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
