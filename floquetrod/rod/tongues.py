"""Where a rod's modes grow along one quantity of the load, mean force, amplitude or frequency, without a grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from floquetrod.mathieu import tongues
from floquetrod.mathieu.bands import Floats, Ints
from floquetrod.mathieu.tongues import Tongues
from floquetrod.rod.data import RodData
from floquetrod.rod.load import AxialLoad

Quantity: TypeAlias = Literal["mean", "amplitude", "frequency"]
"""A quantity of `AxialLoad` that may vary."""

Progress: TypeAlias = Callable[[int, int], None]
"""Called with the numbers of modes searched and to search."""

HAIRLINE_GROWTH = 1e-6
"""Growth in 1/s, tenfold in a month, up to which a tongue is a hairline: searches leave it out, and count it."""


class UnstableRange(NamedTuple):
    """The rod's ``mode`` grows for loads between ``low`` and ``high``, in resonance tongue ``tongue``."""

    low: float
    high: float
    mode: int
    tongue: int


class UnstableLoads(NamedTuple):
    """What a search found: parts in which modes grow, tongues that nowhere exceed the tolerance, what may be missed.

    ``resolution`` is the width, in N or rad/s, up to which a part may have been missed; 0 where none can be.
    """

    ranges: list[UnstableRange]
    hairlines: int
    resolution: float


def unstable_loads(
    varied: Quantity,
    rod: RodData,
    load: AxialLoad,
    modes: Sequence[int],
    tolerance: float,
    between: tuple[float, float],
    *,
    union: bool = False,
    nearest: float | None = None,
    progress: Progress | None = None,
) -> UnstableLoads:
    """Return where modes grow faster than ``tolerance`` (1/s) as one quantity of ``load`` goes through ``between``.

    With ``union`` only the union of all parts is right: modes likely to grow are searched first, and what they cover is
    not searched again, nor are its tongues counted.  With ``nearest``, an end of ``between``, only the edge nearest to
    it is: what lies beyond the nearest part found is not searched either.
    """
    if not union:
        return _search(varied, rod, load, modes, tolerance, [between])
    chosen = _likely_first(varied, rod, load, modes, between)
    found: list[UnstableRange] = []
    hairlines, resolution, done, size = 0, 0.0, 0, 1
    while done < len(chosen):
        left = gaps(found, between)
        if nearest is not None:
            left = [gap for gap in left if nearest in gap]
        if not left:
            break
        part = _search(varied, rod, load, chosen[done : done + size], tolerance, left)
        found += part.ranges
        hairlines, resolution = hairlines + part.hairlines, max(resolution, part.resolution)
        done, size = done + size, 2 * size
        if progress is not None:
            progress(min(done, len(chosen)), len(chosen))
    return UnstableLoads(found, hairlines, resolution)


def gaps(ranges: Sequence[UnstableRange], between: tuple[float, float]) -> list[tuple[float, float]]:
    """Return what ``ranges`` leave of ``between``."""
    at, high = between
    left = []
    for part in sorted(ranges):
        if part.low > at:
            left.append((at, min(part.low, high)))
        at = max(at, part.high)
        if at >= high:
            return left
    return [*left, (at, high)]


def _likely_first(
    varied: Quantity, rod: RodData, load: AxialLoad, modes: Sequence[int], between: tuple[float, float]
) -> list[int]:
    """Return the modes, those first whose stiffness the largest push lowers most."""
    top = replace(load, **{varied: between[1]})
    alpha, beta = rod.mode_parameters(top, modes)
    return [modes[i] for i in np.argsort(-(beta + alpha), kind="stable")]


def _search(
    varied: Quantity,
    rod: RodData,
    load: AxialLoad,
    modes: Sequence[int],
    tolerance: float,
    intervals: Sequence[tuple[float, float]],
) -> UnstableLoads:
    """Search every mode over every interval."""
    number = np.repeat(np.asarray(modes, dtype=np.float64), len(intervals))
    low, high = (np.tile(np.asarray(ends, dtype=np.float64), len(modes)) for ends in zip(*intervals, strict=True))
    along = {"mean": _along_mean, "amplitude": _along_amplitude, "frequency": _along_frequency}[varied]
    found, resolution = along(rod, load, number, tolerance, low, high)
    ranges = [
        UnstableRange(first, last, int(number[which]), order)
        for which, order, first, last in zip(
            found.which.tolist(), found.order.tolist(), found.first.tolist(), found.last.tolist(), strict=True
        )
        if last > first
    ]
    return UnstableLoads(ranges, found.left_out, resolution)


def _along_mean(
    rod: RodData, load: AxialLoad, modes: Floats, tolerance: float, low: Floats, high: Floats
) -> tuple[Tongues, float]:
    """At a given amplitude a mode's alpha is fixed, and beta is linear in the mean force."""
    omega = load.frequency
    c = rod.damping_rate / omega
    alpha, beta = rod.mode_parameters(load, modes)
    gain = rod.mode_family(1.0, 0.0, omega)[1] * modes**2  # beta gained by 1 N
    offset = load.mean - (beta + c * c) / gain
    ends = [(force - offset) * gain for force in (low, high)]
    found = tongues.along_mean(alpha, np.full(modes.size, c + tolerance / omega), *ends)
    return _converted(found, lambda b, i: offset[i] + b / gain[i], ends, (low, high)), 0.0


def _along_amplitude(
    rod: RodData, load: AxialLoad, modes: Floats, tolerance: float, low: Floats, high: Floats
) -> tuple[Tongues, float]:
    """At a given mean force a mode's beta is fixed, and alpha is proportional to the amplitude."""
    omega = load.frequency
    c = rod.damping_rate / omega
    _, beta = rod.mode_parameters(load, modes)
    gain = rod.mode_family(0.0, 1.0, omega)[0] * modes**2  # alpha gained by 1 N
    ends = [force * gain for force in (low, high)]
    found = tongues.along_amplitude(beta + c * c, np.full(modes.size, c + tolerance / omega), *ends)
    resolution = float(np.max(found.resolution / gain, initial=0.0))
    return _converted(found, lambda alpha, i: alpha / gain[i], ends, (low, high)), resolution


def _along_frequency(
    rod: RodData, load: AxialLoad, modes: Floats, tolerance: float, low: Floats, high: Floats
) -> tuple[Tongues, float]:
    """At given forces alpha, beta and c^2 are all proportional to 1 / omega^2."""
    alpha, beta = rod.mode_parameters(replace(load, frequency=1.0), modes)
    rate = np.full(modes.size, rod.damping_rate + tolerance)
    return tongues.along_frequency(alpha, beta + rod.damping_rate**2, rate, low, high), 0.0


def _converted(
    found: Tongues,
    back: Callable[[Floats, Ints], Floats],
    ends: Sequence[Floats],
    limits: tuple[Floats, Floats],
) -> Tongues:
    """Return parts in the quantity of the load; one that ends where its search does ends there to the bit."""
    i = found.which
    first = np.where(found.first <= ends[0][i], limits[0][i], back(found.first, i))
    last = np.where(found.last >= ends[1][i], limits[1][i], back(found.last, i))
    return found._replace(first=first, last=last)
