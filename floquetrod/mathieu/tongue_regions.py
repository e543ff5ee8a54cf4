"""Which tongues can meet a window of loads, and their outlines, a batch at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod.mathieu.tongue_curves import TongueCurves, Window
from floquetrod.mathieu.tongue_intervals import counts, growth_bounds, numbers_between, where_bounded
from floquetrod.mathieu.tongue_outlines import Outlines, outlines

_AT_ONCE = 2048  # tongues outlined between two reports of progress: some tenths of a second (a choice)
_ASKED = 1 << 16  # tongues asked at once whether they may exceed the level: some megabytes (a choice)
_CELLS = 32  # parts of a range of amplitudes in which tongues are counted (a choice)


class UndampedEquations(NamedTuple):
    """Equations with ``stiffness`` (1/s^2) and ``gain``, as in `TongueCurves`, with their damping rate removed.

    Growth up to ``growth_tolerance`` counts as stable; without one, tongues that grow no faster than ``negligible``
    are left out.  All three in 1/s.
    """

    stiffness: Floats
    gain: Floats
    damping: float
    growth_tolerance: float
    negligible: float

    @property
    def rate(self) -> float:
        """What growth without damping must exceed."""
        return self.damping + self.growth_tolerance

    @property
    def least(self) -> float:
        """What the largest growth of a tongue without damping must exceed."""
        return self.damping + (self.growth_tolerance or self.negligible)


class Regions(NamedTuple):
    """Outlines of tongues ``order`` of the equations ``which``, and how many tongues of the window were left out."""

    which: Ints
    order: Ints
    outlines: Outlines
    tongues_left_out: int


def unstable_regions(
    oscillators: UndampedEquations, window: Window, accuracy: float, progress: Callable[[int, int], None] | None
) -> Regions:
    """Return the outlines of all tongues that meet a window and exceed the level there."""
    which, order, met = _tongues(oscillators, window)
    first, last = (np.full(which.size, end) for end in window.span)
    if window.span[0] < 0.0 < window.span[1]:  # all tongues but 0 have no width without forcing: a part on either side
        split = np.flatnonzero(order > 0)
        which, order = np.concatenate([which, which[split]]), np.concatenate([order, order[split]])
        first, last = np.concatenate([first, np.zeros(split.size)]), np.concatenate([last, last[split]])
        last[split] = 0.0
    curves = TongueCurves(window, order, oscillators.stiffness[which], oscillators.gain[which], oscillators.rate)
    regions = []
    for start in range(0, which.size, _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        piece = outlines(curves.some(part), first[part], last[part], accuracy)
        regions.append(piece._replace(which=piece.which + start))
        if progress is not None:
            progress(min(start + _AT_ONCE, which.size), which.size)
    joined = _joined(regions)
    tall = joined.growth > oscillators.least
    joined = _some(joined, tall)
    which, order = which[joined.which], order[joined.which]
    drawn = len(set(zip(which.tolist(), order.tolist(), strict=True)))
    return Regions(which, order, joined, max(0, met - drawn))


def _joined(regions: list[Outlines]) -> Outlines:
    if not regions:
        nothing, number = np.empty(0), np.empty(0, dtype=np.int64)
        return Outlines(number, number, nothing, nothing, nothing, np.empty((0, 2)))
    return Outlines(*(np.concatenate(parts) for parts in zip(*regions, strict=True)))


def _some(regions: Outlines, chosen: Bools) -> Outlines:
    """Return some of the outlines."""
    of_vertex = np.repeat(chosen, regions.size)
    return Outlines(
        regions.which[chosen],
        regions.size[chosen],
        regions.line[of_vertex],
        regions.place[of_vertex],
        regions.growth[chosen],
        regions.peak[chosen],
    )


def _tongues(oscillators: UndampedEquations, window: Window) -> tuple[Ints, Ints, int]:
    """Return (equation, order) of all tongues that may exceed the level in the window, and how many there are in all.

    The count of characteristic values below a mode falls as the mean or the frequency rises.  Between two amplitudes
    none of them moves by more than twice the change of q (Weyl).  A bound on growth, which falls as the mean falls, and
    at given forces with the frequency, leaves out high tongues.
    """
    every = np.arange(oscillators.gain.size)
    strongest = max(map(abs, window.span)) if window.over == "amplitude" else window.fixed
    if strongest == 0.0:
        return every, np.zeros(every.size, dtype=np.int64), 0  # nothing but static buckling
    means = (window.low, window.high) if window.along == "mean" else (window.fixed, window.fixed)
    slow, fast = _frequencies(window)

    def coefficients(i: Ints, mean: Floats, amplitude: float, omega: Floats | float) -> tuple[Floats, Floats]:
        x = 4.0 / (omega * omega) if isinstance(omega, float) else 4.0 / omega**2
        return x * (oscillators.stiffness[i] - oscillators.gain[i] * mean), 0.5 * x * oscillators.gain[i] * amplitude

    def settled(place: Floats, i: Ints) -> Bools:
        """Return whether nothing grows up to a frequency, or up to a mean at the only one."""
        mean, omega = (np.full(i.size, means[1]), place) if slow < fast else (place, np.full(i.size, fast))
        a, q = coefficients(i, mean, strongest, omega)
        return growth_bounds(a, q) * omega <= oscillators.least

    low, high = (slow, fast) if slow < fast else means
    ends = np.full(every.size, low), np.full(every.size, high)
    start = where_bounded(settled, *ends)
    matters = start < high
    amplitudes = np.linspace(*window.span, _CELLS + 1) if window.over == "amplitude" else np.array([strongest])
    least, most, met_least, met_most = ([] for _ in range(4))  # counts for each amplitude
    step = (window.span[1] - window.span[0]) / _CELLS if amplitudes.size > 1 else 0.0
    for amplitude in np.abs(amplitudes).tolist():
        if amplitude == 0.0:
            amplitude = 1e-9 * strongest  # without forcing tongues have no width, and no count is even
        fewest, q = coefficients(every, np.full(every.size, means[1]), amplitude, fast)
        margin = coefficients(every, np.zeros(every.size), step, fast)[1]
        met_least.append(counts(fewest, q))
        least.append(counts(fewest - margin, q))
        furthest, q = coefficients(every, np.full(every.size, means[0]), amplitude, slow)
        met_most.append(counts(furthest, q))
        mean, omega = (np.full(every.size, means[0]), start) if slow < fast else (start, np.full(every.size, fast))
        far, q = coefficients(every, mean, amplitude, omega)
        margin = coefficients(every, np.zeros(every.size), step, omega)[1]
        most.append(counts(far + margin, q))
    met = np.max(met_most, axis=0) // 2 - (np.min(met_least, axis=0) + 1) // 2 + 1
    which, order = numbers_between((np.min(least, axis=0) + 1) // 2, np.where(matters, np.max(most, axis=0) // 2, -1))
    parts = [slice(start, start + _ASKED) for start in range(0, which.size, _ASKED)]
    tall = np.concatenate(
        [_tall(oscillators, window, which[part], order[part], strongest) for part in parts] or [which > 0]
    )
    return which[tall], order[tall], int(np.maximum(met, 0).sum())


def _frequencies(window: Window) -> tuple[float, float]:
    """Return the lowest and the highest frequency of a window."""
    if window.along == "frequency":
        return window.low, window.high
    return window.span if window.over == "frequency" else (window.fixed, window.fixed)


def _tall(oscillators: UndampedEquations, window: Window, which: Ints, order: Ints, strongest: float) -> Bools:
    """Return which tongues may exceed the level in the window.

    The fastest growth of a tongue on a line falls with the frequency and rises with the amplitude: the line to examine
    has the largest amplitude, or the lowest frequency at which the tongue reaches the window, which it does at the
    largest mean.  (Observed.  Where the mean alone buckles a mode, growth along the frequency first falls with the
    amplitude: such tongues are all kept.)
    """
    line = np.full(which.size, strongest)
    if window.over == "frequency":
        top = window._replace(
            along="frequency", over="amplitude", fixed=window.high, low=window.span[0], high=window.span[1]
        )
        curves = TongueCurves(top, order, oscillators.stiffness[which], oscillators.gain[which], 0.0)
        edge, _ = curves.edges(np.arange(which.size), line)
        line = np.clip(edge, *window.span)
    curves = TongueCurves(window, order, oscillators.stiffness[which], oscillators.gain[which], 0.0)
    tall = curves.ridge(np.arange(which.size), line) > oscillators.least**2
    if window.along == "frequency":
        tall |= oscillators.stiffness[which] < oscillators.gain[which] * window.fixed
    return tall
