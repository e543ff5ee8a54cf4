"""Where a rod's modes grow along one quantity of the load, mean force, amplitude or frequency, without a grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod._util.spans import complement
from floquetrod.mathieu import tongue_intervals
from floquetrod.mathieu.tongue_intervals import Tongues
from floquetrod.rod.loads.load import Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystem


class UnstableInterval(NamedTuple):
    """The rod's ``mode`` grows for loads between ``low`` and ``high``, in its resonance tongue ``tongue``."""

    low: float
    high: float
    mode: int
    tongue: int


class UnstableLoads(NamedTuple):
    """Intervals of a quantity in which modes grow.

    Attributes
    ----------
    intervals : list of UnstableInterval
        Where modes grow.
    tongues_left_out : int
        Resonance tongues that nowhere exceed the tolerance.
    resolution : float
        Width, in N or rad/s, up to which an interval may have been missed; 0 where none can be.
    """

    intervals: list[UnstableInterval]
    tongues_left_out: int
    resolution: float


def unstable_loads(
    varied: Quantity,
    system: ModalSystem,
    tolerance: float,
    bounds: tuple[float, float],
    *,
    union: bool = False,
    nearest: float | None = None,
    progress: Progress | None = None,
) -> UnstableLoads:
    """Return where modes grow faster than ``tolerance`` (1/s) as one quantity of the load goes through ``bounds``.

    ``system`` has the modes, and the load's other quantities.  With ``union`` only the union of all intervals is right:
    modes likely to grow are searched first, and what they cover is not searched again, nor are its tongues counted.
    With ``nearest``, one of the ``bounds``, only the edge nearest to it is: what lies beyond the nearest interval found
    is not searched either.
    """
    if not union:
        return tongues_within(varied, system, tolerance, [bounds])
    chosen = _likely_first(varied, system, bounds)
    intervals: list[UnstableInterval] = []
    tongues_left_out, resolution, done, size = 0, 0.0, 0, 1
    while done < len(chosen):
        gaps = [gap[:2] for gap in complement(bounds, intervals)]
        if nearest is not None:
            gaps = [gap for gap in gaps if nearest in gap]
        if not gaps:
            break
        more = tongues_within(varied, replace(system, modes=chosen[done : done + size]), tolerance, gaps)
        intervals += more.intervals
        tongues_left_out, resolution = tongues_left_out + more.tongues_left_out, max(resolution, more.resolution)
        done, size = done + size, 2 * size
        if progress is not None:
            progress(min(done, len(chosen)), len(chosen))
    return UnstableLoads(intervals, tongues_left_out, resolution)


def _likely_first(varied: Quantity, system: ModalSystem, bounds: tuple[float, float]) -> tuple[int, ...]:
    """Return the modes in the order in which the largest push lowers their stiffness, the most first."""
    top = replace(system, load=system.load.varied(varied, bounds[1]))
    return tuple(system.modes[i] for i in np.argsort(-(top.beta + top.alpha), kind="stable"))


def tongues_within(
    varied: Quantity, system: ModalSystem, tolerance: float, intervals: Sequence[tuple[float, float]]
) -> UnstableLoads:
    """Search every mode over every interval for unstable loads; ends are bit for bit the intervals' where they meet."""
    still = system.per_newton == 0.0
    if still.any():
        moved = replace(system, modes=tuple(np.array(system.modes)[~still].tolist()))
        rest = tongues_within(varied, moved, tolerance, intervals)
        return rest._replace(intervals=rest.intervals + _unmoved(system, still, tolerance, intervals))
    mode = np.repeat(np.arange(len(system.modes)), len(intervals))  # the index of each search's mode
    low, high = (
        np.tile(np.asarray(ends, dtype=np.float64), len(system.modes)) for ends in zip(*intervals, strict=True)
    )
    along = {"mean": _along_mean, "amplitude": _along_amplitude, "frequency": _along_frequency}[varied]
    tongues_above, resolution = along(system, mode, tolerance, low, high)
    unstable = [
        UnstableInterval(first, last, system.modes[mode[which]], order)
        for which, order, first, last in zip(
            tongues_above.which.tolist(),
            tongues_above.order.tolist(),
            tongues_above.first.tolist(),
            tongues_above.last.tolist(),
            strict=True,
        )
        if last > first
    ]
    return UnstableLoads(unstable, tongues_above.left_out, resolution)


def _unmoved(
    system: ModalSystem, still: Bools, tolerance: float, intervals: Sequence[tuple[float, float]]
) -> list[UnstableInterval]:
    """Return all of the intervals for every mode that no force moves, at m_0, where it grows by itself."""
    squared = (system.beta + system.damping**2) * system.frequency**2
    grows = still & (squared > (system.constants.damping_rate + tolerance) ** 2)
    return [UnstableInterval(*ends, int(system.modes[i]), 0) for i in np.flatnonzero(grows) for ends in intervals]


def _along_mean(system: ModalSystem, mode: Ints, tolerance: float, low: Floats, high: Floats) -> tuple[Tongues, float]:
    """At a given amplitude a mode's alpha is fixed, and beta is linear in the mean force: it falls where held by it."""
    c, gain = system.damping, system.per_newton[mode]
    offset = system.load.mean - (system.beta[mode] + c * c) / gain
    falls = gain < 0.0
    low, high = np.where(falls, high, low), np.where(falls, low, high)  # of the mean force, at which beta is
    ends = [(force - offset) * gain for force in (low, high)]
    growing = tongue_intervals.along_mean(system.alpha[mode], _level(system, mode, tolerance), *ends)
    growing = _converted(growing, lambda b, i: offset[i] + b / gain[i], ends, (low, high))
    turned = falls[growing.which]
    first, last = np.where(turned, growing.last, growing.first), np.where(turned, growing.first, growing.last)
    return growing._replace(first=first, last=last), 0.0


def _along_amplitude(
    system: ModalSystem, mode: Ints, tolerance: float, low: Floats, high: Floats
) -> tuple[Tongues, float]:
    """At a given mean force a mode's beta is fixed, and alpha is proportional to the amplitude."""
    c, gain = system.damping, np.abs(system.per_newton[mode])
    ends = [force * gain for force in (low, high)]
    growing = tongue_intervals.along_amplitude(system.beta[mode] + c * c, _level(system, mode, tolerance), *ends)
    resolution = float(np.max(growing.resolution / gain, initial=0.0))
    return _converted(growing, lambda alpha, i: alpha / gain[i], ends, (low, high)), resolution


def _along_frequency(
    system: ModalSystem, mode: Ints, tolerance: float, low: Floats, high: Floats
) -> tuple[Tongues, float]:
    """At given forces alpha, beta and c^2 are all proportional to 1 / omega^2."""
    (alpha, beta), damping_rate = system.in_seconds, system.constants.damping_rate
    rate = np.full(mode.size, damping_rate + tolerance)
    return tongue_intervals.along_frequency(alpha[mode], beta[mode] + damping_rate**2, rate, low, high), 0.0


def _level(system: ModalSystem, mode: Ints, tolerance: float) -> Floats:
    """Return the growth per unit tau without damping above which a mode grows faster than the tolerance."""
    return np.full(mode.size, system.damping + tolerance / system.frequency)


def _converted(
    growing: Tongues, back: Callable[[Floats, Ints], Floats], ends: Sequence[Floats], limits: tuple[Floats, Floats]
) -> Tongues:
    """Return parts in the quantity of the load; one that ends where its search does ends there bit for bit."""
    i = growing.which
    first = np.where(growing.first <= ends[0][i], limits[0][i], back(growing.first, i))
    last = np.where(growing.last >= ends[1][i], limits[1][i], back(growing.last, i))
    return growing._replace(first=first, last=last)
