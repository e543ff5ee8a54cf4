"""Semi-discretisation of second order: short steps with constant coefficients, extrapolated.

T. Insperger and G. Stepan, Semi-Discretization for Time-Delay Systems, Springer 2011, doi:10.1007/978-1-4614-0335-7.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.interpolation import lagrange_weights
from floquetrod.equations import DelaySystem
from floquetrod.floquet.multipliers import delay_maps, delay_roots, delay_spectra
from floquetrod.floquet.multipliers.classification import classify_multipliers
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost

_MOST_ROWS = 2400  # of the map with the shortest steps (a choice: some seconds)
_RADIANS = 0.25  # that solutions turn by in a coarse step, about (a choice)
_SAFETY = 3.0  # times the difference of two extrapolations (heuristic)
_NEIGHBOURS = 4  # points of the history that a delayed value is interpolated from


def semi_discretisation(system: DelaySystem, *, above: float = 0.3) -> SystemStability:
    """Classify by steps over which coefficients have their values in the middle, and the delayed term varies linearly.

    A step is the exponential of the state's own matrix, and of the matrix of a force that grows linearly.  Delayed
    values are interpolated by cubics between the ends of steps, which lie on all jumps.  The multipliers of three maps,
    each with steps half as long, are extrapolated twice.

    Parameters
    ----------
    system : DelaySystem
        One whose finest map has at most 2,400 rows; else the result is undecided.
    above : float
        Modulus above which multipliers are found, the largest in any case, over the period or the longest delay,
        whichever is longer; from 0.01 to 0.9.

    Returns
    -------
    SystemStability
        Its errors are estimates, three times the difference of the extrapolations.

    Raises
    ------
    TypeError, ValueError
        For ``above`` outside 0.01 to 0.9.

    Examples
    --------
    >>> import math
    >>> system = DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], delayed=[(2.0 * math.pi, [[0.15]])])
    >>> f"{semi_discretisation(system).multipliers[0]:.5f}"
    '-0.46167-0.22150j'
    """
    above = validate.within("above", above, 0.01, 0.9)
    laid = delay_maps.period_pieces(system)
    grids = [_grid(system, laid, refinement) for refinement in (1, 2, 4)]
    rows = system.order * (grids[-1].reach + 2)
    cost = Cost(len(grids[-1].times) - 1, "steps")
    if rows > _MOST_ROWS or len(grids[-1].times) > 4 * _MOST_ROWS:
        return SystemStability.declined(system, "semi_discretisation", cost, f"needs a map of {rows:,} rows")
    coarse, middle, fine = (_largest(_map(system, grid), laid.smallest_modulus(system, above)) for grid in grids)
    finest = _extrapolated(fine, _nearest(fine, middle))
    coarser = _extrapolated(_nearest(fine, middle), _nearest(_nearest(fine, middle), coarse))
    radii = _SAFETY * np.abs(finest - coarser) + 1e-12 * np.abs(finest)
    logs = delay_spectra.log_discs(finest, radii)
    if system.is_constant:
        logs = delay_roots.per_period(system, logs, laid.period)
    return classify_multipliers(system, "semi_discretisation", logs, cost=cost)


class _StepEnds(NamedTuple):
    """Ends of steps in a period, from 0 to 1 in periods, and how many of the last ones a state holds."""

    times: Floats
    reach: int
    period: float


def _grid(system: DelaySystem, laid: delay_maps.PeriodPieces, refinement: int) -> _StepEnds:
    """Return the steps of a period, none longer than the shortest delay, all breaks among their ends."""
    longest = _RADIANS / max(delay_maps.rate(system) * laid.period, 1e-12)
    shortest = min((float(delay) / laid.period for delay in system.delays), default=1.0)
    step = min(longest, 0.5 * shortest, 1.0 / 12.0)
    times = [0.0]
    for low, high in pairwise(laid.breaks):
        count = refinement * max(2, math.ceil((high - low) / step))
        times += np.linspace(low, high, count + 1)[1:].tolist()
    back = system.longest_delay / laid.period
    whole = math.floor(back)
    reach = whole * (len(times) - 1) + int(np.searchsorted(np.asarray(times), back - whole)) + _NEIGHBOURS
    first = np.asarray(times)
    lengths = np.concatenate([np.diff(first)] * (whole + 2))[::-1]
    reach = max(reach, int(np.searchsorted(np.cumsum(lengths), back)) + _NEIGHBOURS)
    return _StepEnds(first, reach, laid.period)


def _map(system: DelaySystem, grid: _StepEnds) -> Floats:
    """Return the map over a period of values at the ends of the last steps, the newest last, and of rates."""
    n, second = system.order, system.is_second_order
    steps, reach = len(grid.times) - 1, grid.reach
    width = (reach + 1 + second) * n
    values = np.zeros((reach + 1 + steps, n, width))  # at the ends of steps, as rows over the state
    values[: reach + 1].reshape(-1, width)[:, : (reach + 1) * n] = np.eye((reach + 1) * n)
    rates = np.zeros((n, width))
    if second:
        rates[:, -n:] = np.eye(n)
    lengths = np.diff(grid.times)
    before = np.resize(lengths[::-1], reach)[::-1]
    ends = np.concatenate([[0.0], np.cumsum(before)]) - before.sum()
    ends = np.concatenate([ends, grid.times[1:]])
    exponentials = _exponentials(system, grid, lengths)
    for i in range(steps):
        state = np.concatenate([values[reach + i], rates]) if second else values[reach + i]
        now = reach + i
        moved = exponentials.own[i] @ state
        for j, delay in enumerate(system.delays):
            back = float(delay) / grid.period
            for part, t in enumerate((grid.times[i] - back, grid.times[i + 1] - back)):
                moved += exponentials.forced[j][part][i] @ _interpolated(values, ends, t, now)
        values[now + 1] = moved[:n]
        rates = moved[n:]
    last = values[steps:].reshape(-1, width)
    return np.concatenate([last, rates]) if second else last


class _Exponentials(NamedTuple):
    """Maps of each step: from the state, and for each delay from its values at the beginning and at the end."""

    own: Floats
    forced: list[tuple[Floats, Floats]]


def _exponentials(system: DelaySystem, grid: _StepEnds, lengths: Floats) -> _Exponentials:
    from scipy.linalg import expm

    given = delay_maps.coefficients(system, grid.period, 0.5 * (grid.times[1:] + grid.times[:-1]))
    n, steps = system.order, len(lengths)
    size = (1 + system.is_second_order) * n
    matrix = np.zeros((steps, size, size))
    matrix[:, size - n :, :n] = given.value[0]
    if system.is_second_order:
        matrix[:, :n, n:] = np.eye(n)
        if given.rate is not None:
            matrix[:, n:, n:] = given.rate[0]
    # exp of [[A, b, 0], [0, 0, 1/h], [0, 0, 0]] h holds what a force grown linearly from 0 to 1 leaves, and a constant.
    bordered = np.zeros((steps, size + 2 * n, size + 2 * n))
    bordered[:, :size, :size] = matrix * lengths[:, None, None]
    bordered[:, size - n : size, size : size + n] = lengths[:, None, None] * np.eye(n)
    bordered[:, size : size + n, size + n :] = np.eye(n)
    exponential = expm(bordered)
    own, constant, linear = (
        exponential[:, :size, :size],
        exponential[:, :size, size : size + n],
        exponential[:, :size, size + n :],
    )
    forced = [((constant - linear) @ matrices[0], linear @ matrices[0]) for matrices in given.delayed]
    return _Exponentials(own, forced)


def _interpolated(values: Floats, ends: Floats, t: float, now: int) -> Floats:
    """Return the value at a time as rows over the state, by a cubic between four known ends of steps."""
    first = int(np.searchsorted(ends[: now + 1], t)) - _NEIGHBOURS // 2
    first = min(max(first, 0), now + 1 - _NEIGHBOURS)
    weights = lagrange_weights(ends[first : first + _NEIGHBOURS], t)
    return np.asarray(np.tensordot(weights, values[first : first + _NEIGHBOURS], axes=1))


def _largest(matrix: Floats, least: float) -> Complexes:
    """Return the eigenvalues of modulus above ``least``, the largest ones in any case."""
    values = np.linalg.eigvals(matrix).astype(np.complex128)
    sizes = np.abs(values)
    return values[sizes >= min(least, 0.999 * float(sizes.max()))]


def _nearest(to: Complexes, among: Complexes) -> Complexes:
    return np.asarray(among[np.abs(to[:, None] - among[None, :]).argmin(axis=1)])


def _extrapolated(fine: Complexes, coarse: Complexes) -> Complexes:
    return np.asarray(fine + (fine - coarse) / 3.0)
