"""Verdicts on many systems with delays at once: by powers of their maps, near the boundary by eigenvalues.

The 512th power of a map M, found by nine squarings, bounds its spectral radius r from above by its norm, and from below
by its trace: |trace M^k| <= S r^k for S rows.  That takes a tenth of the time of eigenvalues.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.equations import DelaySystem
from floquetrod.equations.delay_system import moved
from floquetrod.floquet.multipliers import delay_growth, delay_maps, delay_series, delay_steps, whole_steps
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE

Maps = Callable[[NDArray[np.intp], int], Floats]
"""(indices of systems, nodes in a piece) -> maps over a period (b, S, S)."""

_SQUARINGS = 9
_ENTRIES = 1 << 18  # of maps at once (a choice: two megabytes)
_AT_FIRST = 8  # maps before their size is known (a choice: with 1,000 rows 64 megabytes)
_MARGINS = (0.05, 3e-3)  # of the logarithm of the radius, beyond which its bounds decide (a choice)
_WORTH = 400  # systems of as many nodes from which on bounds take less time than eigenvalues (measured)
_TRIED = 12  # systems of as many nodes with which their resolution is tested
_MORE = 6  # nodes that halve the digits still wrong, and more (a choice)
_MOST = 60  # nodes in a piece
_SAFETY = 3.0  # times the change to more nodes is the error of a logarithm (heuristic)
_ROUNDING = 1e-11  # of a logarithm, beside that


def judged(maps: Maps, counts: NDArray[np.intp], *, growth: bool = False) -> ManyVerdicts:
    """Return verdicts on systems, with growth over a period: the logarithms of the spectral radii of their maps.

    Parameters
    ----------
    maps : callable
    counts : ndarray (b,) of int
        Nodes in each piece with which each system is about resolved.
    growth : bool
        Whether the growth of every system must be known.
    """
    verdicts = ManyVerdicts(np.full(counts.size, UNDECIDED, dtype=np.int8), np.full(counts.size, np.nan))
    for count in np.unique(counts):
        members = np.flatnonzero(counts == count)
        _judge_count(maps, members, int(count), verdicts, growth)
    return verdicts


def of_systems(systems: Sequence[DelaySystem], *, growth: bool = False) -> ManyVerdicts:
    """Return verdicts on systems, growth where it must be known or was needed.

    Systems whose pieces and delays are the same parts of their periods are judged together; long delays, of which only
    the status is wanted, by the number of multipliers outside the unit circle.
    """
    verdicts = _of_exact(systems, growth)
    for i, system in enumerate(systems):
        if system.coefficient_error * float(system.period) > _ROUNDING:
            _include_errors(verdicts, i, system)
    return verdicts


def _include_errors(verdicts: ManyVerdicts, i: int, system: DelaySystem) -> None:
    """Leave a verdict undecided whose growth is within twice its changes by errors of coefficients."""
    growth = _of_exact([system, *moved(system)], growth=True).growth
    error = 2.0 * float(np.abs(growth[1:] - growth[0]).sum())
    if not abs(growth[0]) > error:
        verdicts.status[i] = UNDECIDED


def _of_exact(systems: Sequence[DelaySystem], growth: bool) -> ManyVerdicts:
    """Return verdicts on systems as `of_systems`, coefficients taken to be exact."""
    verdicts = ManyVerdicts(np.empty(len(systems), dtype=np.int8), np.full(len(systems), np.nan))
    pieces = [delay_maps.period_pieces(system) for system in systems]
    groups: dict[Any, list[int]] = {}
    for i, (system, layout) in enumerate(zip(systems, pieces, strict=True)):
        counted = None if growth else _by_count(system)
        if counted is not None:
            verdicts.status[i] = counted
            continue
        key = (layout.breaks, layout.active, layout.delays(system), system.order, system.is_second_order)
        groups.setdefault(key, []).append(i)
    for group in groups.values():
        members, group_pieces = [systems[i] for i in group], [pieces[i] for i in group]
        phases = [
            delay_maps.rate(m) * layout.period * layout.longest for m, layout in zip(members, group_pieces, strict=True)
        ]
        counts = np.minimum(4 * np.ceil(2.0 + 0.125 * np.asarray(phases)), _MOST - 2 * _MORE).astype(np.intp)
        judged_group = judged(_maps_of(members, group_pieces), counts, growth=growth)
        verdicts.status[group] = judged_group.status
        verdicts.growth[group] = judged_group.growth / np.array([layout.period for layout in group_pieces])
    return verdicts


def _by_count(system: DelaySystem) -> int | None:
    """Return the status of a system whose long delays are whole numbers of a step; None of other systems."""
    laid = whole_steps.steps(system) if whole_steps.is_long(system) else None
    series = None if laid is None else delay_steps.series(delay_steps.step_pieces(system, laid), 1.0)
    if series is None:
        return None
    outside = delay_series.outside(series, 0.0)
    return UNDECIDED if outside is None else UNSTABLE if outside else STABLE


def _maps_of(systems: Sequence[DelaySystem], pieces: Sequence[delay_maps.PeriodPieces]) -> Maps:
    """Return the function that computes the maps of systems with one mesh."""

    def maps(which: NDArray[np.intp], count: int) -> Floats:
        mesh = pieces[0].mesh(systems[0], count)
        coefficients = [delay_maps.coefficients(systems[i], pieces[i].period, mesh.nodes) for i in which.tolist()]
        values, delayed = (
            np.concatenate([sample.value for sample in coefficients]),
            [sample.delayed for sample in coefficients],
        )
        rates = [np.zeros_like(sample.value) if sample.rate is None else sample.rate for sample in coefficients]
        rate = np.concatenate(rates) if systems[0].is_second_order else None
        return delay_maps.period_maps(
            mesh, delay_maps.Coefficients(values, rate, tuple(map(np.concatenate, zip(*delayed, strict=True))))
        )

    return maps


def _judge_count(maps: Maps, members: NDArray[np.intp], count: int, verdicts: ManyVerdicts, growth: bool) -> None:
    for margin in () if growth or members.size < _WORTH else _MARGINS:
        count = _resolved(maps, members, count, 0.4 * margin)
        bounds = zip(*(_bounds(chunk) for chunk in _chunks(maps, members, count)), strict=True)
        low, high = (np.concatenate(side) for side in bounds)
        verdicts.status[members[high < -margin]] = STABLE
        verdicts.status[members[low > margin]] = UNSTABLE
        members = members[(high >= -margin) & (low <= margin)]
        if members.size < _WORTH:
            break
    if not members.size:
        return
    logs = _logs(maps, members, count)
    while True:
        count += _MORE
        before, logs = logs, _logs(maps, members, count)
        error = _SAFETY * np.abs(logs - before) + _ROUNDING
        verdicts.growth[members] = logs
        verdicts.status[members] = np.where(logs > error, UNSTABLE, np.where(logs < -error, STABLE, UNDECIDED))
        left = np.flatnonzero(error > (1e-3 if growth else 0.5) * np.abs(logs))
        if not left.size or count >= _MOST:
            return
        members, logs = members[left], logs[left]


def _resolved(maps: Maps, members: NDArray[np.intp], count: int, accuracy: float) -> int:
    """Return a number of nodes that resolves the radii of a sample of systems, first and last among them.

    Radii far from 1, either way, count as resolved as well.
    """
    tried = members[np.unique(np.linspace(0, members.size - 1, _TRIED).astype(np.intp))]
    coarse = _logs(maps, tried, count)
    while count < _MOST:
        fine = _logs(maps, tried, count + _MORE)
        if (np.abs(fine - coarse) <= np.maximum(accuracy, 0.3 * np.abs(fine))).all():
            break
        count, coarse = count + _MORE, fine
    return count


def _chunks(maps: Maps, members: NDArray[np.intp], count: int) -> Iterator[Floats]:
    """Yield the maps of systems, a chunk at a time: a few, and then as many as their size allows."""
    first = maps(members[:_AT_FIRST], count)
    yield first
    step = max(1, _ENTRIES // first.shape[1] ** 2)
    for start in range(_AT_FIRST, members.size, step):
        yield maps(members[start : start + step], count)


def _logs(maps: Maps, members: NDArray[np.intp], count: int) -> Floats:
    """Return the logarithms of the largest moduli."""
    with np.errstate(divide="ignore"):
        return np.concatenate([np.log(delay_growth.moduli(chunk)) for chunk in _chunks(maps, members, count)])


def _bounds(matrices: Floats) -> tuple[Floats, Floats]:
    """Return bounds of the logarithm of the spectral radius of matrices (b, S, S), from below and from above."""
    power, log = matrices, np.zeros(len(matrices))
    for _ in range(_SQUARINGS):
        size = np.maximum(np.sqrt(np.einsum("bij,bij->b", power, power)), 1e-280)
        power = power / size[:, None, None]
        power = power @ power
        log = 2.0 * (log + np.log(size))
    with np.errstate(divide="ignore"):
        high = 0.5 * np.log(np.einsum("bij,bij->b", power, power))
        low = np.log(np.abs(np.einsum("bii->b", power)) / power.shape[1])
    return (log + low) / 2**_SQUARINGS, (log + high) / 2**_SQUARINGS
