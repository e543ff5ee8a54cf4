"""Verdicts on many systems with delays at once: most by powers of their maps, those near the boundary by eigenvalues.

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
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE
from floquetrod.floquet.systems import delay_growth, delay_maps
from floquetrod.floquet.systems.many import ManyVerdicts

Maps = Callable[[NDArray[np.intp], int], Floats]
"""Returns the maps over a period of some systems, by their places, with a number of nodes in each piece."""

_SQUARINGS = 9
_ENTRIES = 1 << 18  # of maps at once (a choice: two megabytes)
_MARGINS = (0.05, 3e-3)  # of the logarithm of the radius, beyond which its bounds decide (a choice)
_WORTH = 400  # systems of as many nodes from which on bounds take less time than eigenvalues (measured)
_TRIED = 12  # of systems of as many nodes that tell how good these are
_MORE = 6  # nodes that halve the digits still wrong, and more (a choice)
_MOST = 60  # nodes in a piece
_SAFETY = 3.0  # times the change to more nodes is the error of a logarithm (heuristic)
_ROUNDING = 1e-11  # of a logarithm, beside that


def judged(maps: Maps, counts: NDArray[np.intp], *, growth: bool = False) -> ManyVerdicts:
    """Return verdicts on systems, growth over a period: logarithms of the largest moduli of multipliers.

    Parameters
    ----------
    maps : callable
    counts : ndarray (b,) of int
        Nodes in each piece with which each system is about resolved.
    growth : bool
        Whether that of all must be known.
    """
    found = ManyVerdicts(np.full(counts.size, UNDECIDED, dtype=np.int8), np.full(counts.size, np.nan))
    for count in np.unique(counts):
        some = np.flatnonzero(counts == count)
        _of_one_count(maps, some, int(count), found, growth)
    return found


def of_systems(systems: Sequence[DelaySystem], *, growth: bool = False) -> ManyVerdicts:
    """Return verdicts on systems, growth where it must be known or was needed.

    Those whose pieces and delays are the same parts of their periods are judged together.
    """
    found = ManyVerdicts(np.empty(len(systems), dtype=np.int8), np.empty(len(systems)))
    laid = [delay_maps.layout(system) for system in systems]
    groups: dict[Any, list[int]] = {}
    for i, (system, one) in enumerate(zip(systems, laid, strict=True)):
        key = (one.breaks, one.active, one.delays(system), system.order, system.is_second_order)
        groups.setdefault(key, []).append(i)
    for group in groups.values():
        members, layouts = [systems[i] for i in group], [laid[i] for i in group]
        phases = [delay_maps.rate(m) * one.period * one.longest for m, one in zip(members, layouts, strict=True)]
        counts = np.minimum(4 * np.ceil(2.0 + 0.125 * np.asarray(phases)), _MOST - 2 * _MORE).astype(np.intp)
        some = judged(_maps_of(members, layouts), counts, growth=growth)
        found.status[group] = some.status
        found.growth[group] = some.growth / np.array([one.period for one in layouts])
    return found


def _maps_of(systems: Sequence[DelaySystem], layouts: Sequence[delay_maps.Layout]) -> Maps:
    """Return what makes the maps of systems with one mesh."""

    def maps(which: NDArray[np.intp], count: int) -> Floats:
        on = layouts[0].mesh(systems[0], count)
        each = [delay_maps.coefficients(systems[i], layouts[i].period, on.nodes) for i in which.tolist()]
        values, delayed = (np.concatenate([one.value for one in each]), [one.delayed for one in each])
        rates = [np.zeros_like(one.value) if one.rate is None else one.rate for one in each]
        rate = np.concatenate(rates) if systems[0].is_second_order else None
        return delay_maps.period_maps(
            on, delay_maps.Coefficients(values, rate, tuple(map(np.concatenate, zip(*delayed, strict=True))))
        )

    return maps


def _of_one_count(maps: Maps, some: NDArray[np.intp], count: int, found: ManyVerdicts, growth: bool) -> None:
    for margin in () if growth or some.size < _WORTH else _MARGINS:
        count = _resolved(maps, some, count, 0.4 * margin)
        bounds = zip(*(_bounds(part) for part in _parts(maps, some, count)), strict=True)
        low, high = (np.concatenate(each) for each in bounds)
        found.status[some[high < -margin]] = STABLE
        found.status[some[low > margin]] = UNSTABLE
        some = some[(high >= -margin) & (low <= margin)]
        if some.size < _WORTH:
            break
    if not some.size:
        return
    logs = _logs(maps, some, count)
    while True:
        count += _MORE
        before, logs = logs, _logs(maps, some, count)
        error = _SAFETY * np.abs(logs - before) + _ROUNDING
        found.growth[some] = logs
        found.status[some] = np.where(logs > error, UNSTABLE, np.where(logs < -error, STABLE, UNDECIDED))
        left = np.flatnonzero(error > (1e-3 if growth else 0.5) * np.abs(logs))
        if not left.size or count >= _MOST:
            return
        some, logs = some[left], logs[left]


def _resolved(maps: Maps, some: NDArray[np.intp], count: int, accuracy: float) -> int:
    """Return a number of nodes with which a few of the systems have radii as good as asked, first and last among them.

    Radii that are far off, either way, count as known as well.
    """
    tried = some[np.unique(np.linspace(0, some.size - 1, _TRIED).astype(np.intp))]
    coarse = _logs(maps, tried, count)
    while count < _MOST:
        fine = _logs(maps, tried, count + _MORE)
        if (np.abs(fine - coarse) <= np.maximum(accuracy, 0.3 * np.abs(fine))).all():
            break
        count, coarse = count + _MORE, fine
    return count


def _parts(maps: Maps, some: NDArray[np.intp], count: int) -> Iterator[Floats]:
    """Yield the maps of systems, some at a time."""
    size = maps(some[:1], count).shape[1]
    step = max(1, _ENTRIES // size**2)
    for start in range(0, some.size, step):
        yield maps(some[start : start + step], count)


def _logs(maps: Maps, some: NDArray[np.intp], count: int) -> Floats:
    """Return the logarithms of the largest moduli."""
    with np.errstate(divide="ignore"):
        return np.concatenate([np.log(delay_growth.moduli(part)) for part in _parts(maps, some, count)])


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
