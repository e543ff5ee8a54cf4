"""Between stability intervals: how fast the unstable bands grow at the most, and which damping stabilises them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from floquetrod import mathieu
from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod._util.spans import complement
from floquetrod.mathieu.tongue_intervals import damping_to_stabilise
from floquetrod.rod.answers.stability_intervals import BandBeyond, Search, UnstableBand, WhatGrows
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.mode_equations.modal_systems import ModalSystem, ModalSystems
from floquetrod.rod.mode_equations.unstable_loads import tongues_within
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.data import RodData
from floquetrod.rod.modes.mode_model import ModeModel

Values: TypeAlias = Callable[[Floats, Ints], Floats]
"""Values at places, one for each, in the intervals with the numbers given."""

_SAMPLES = 17  # loads at which growth and damping are evaluated in each tongue of a band (a choice)
_OF_OTHERS = 3  # at which the damping is, in each band, that modes which do not grow there require (a choice)
_CLOSER = 9  # places in each step of a refinement: the interval then shrinks to a quarter
_STEPS, _FEWER_STEPS = 6, 3  # of a refinement: to 4^-6 of the distance of samples, or to 4^-3


@dataclass(frozen=True)
class BandSearch:
    """The tongues of independent modes along one quantity of a load.

    Attributes
    ----------
    rod : RodData
    search : Search
    modes : int
        Modes examined, 1 to this.
    """

    rod: RodData
    search: Search
    modes: int

    def unstable_bands(self, bands: Sequence[tuple[float, float]]) -> tuple[UnstableBand, ...]:
        """Return the fastest growth and the damping required in each band, given by its ends, in increasing order."""
        varied, load, _, tolerance = self.search
        system = ModalSystem(mode_constants(self.rod), load, tuple(range(1, self.modes + 1)))
        tongues = tongues_within(varied, system, tolerance, bands).intervals
        low, high = (np.array([part[side] for part in tongues]) for side in (0, 1))
        mode = np.array([part.mode for part in tongues], dtype=np.int64)
        peaks = _peaks(lambda x, i: self._growth(mode[i], x), low, high, _SAMPLES, _STEPS)
        band = np.searchsorted(np.array([ends[0] for ends in bands]), low, side="right") - 1
        damping = self._dampings(bands, band, mode, low, high)
        rows = []
        for k, ends in enumerate(bands):
            inside = np.flatnonzero(band == k)
            rate, worst_load = 0.0, 0.5 * sum(ends)  # where a band is too narrow for doubles in between
            cause: WhatGrows = "unnamed"
            if inside.size:
                worst = int(inside[peaks.value[inside].argmax()])
                rate, worst_load = float(peaks.value[worst]), float(peaks.at[worst])
                cause = tongues[worst].mode, tongues[worst].tongue
            rows.append(UnstableBand(*ends, rate, worst_load, cause, float(damping[k])))
        return tuple(rows)

    def band_beyond(self, edge: float) -> BandBeyond | None:
        """Return the band that begins at ``edge``, an end of the bounds of the search, up to their other end."""
        varied, load, bounds, tolerance = self.search
        system = ModalSystem(mode_constants(self.rod), load, tuple(range(1, self.modes + 1)))
        tongues = tongues_within(varied, system, tolerance, [bounds]).intervals
        if not tongues:
            return None
        upwards = edge == bounds[0]
        begins = min(tongues, key=lambda part: abs((part.low if upwards else part.high) - edge))
        near = begins.low if upwards else begins.high
        gaps = [gap for gap in complement(bounds, tongues) if (gap.low > near if upwards else gap.high < near)]
        end = bounds[1] if upwards else bounds[0]
        if gaps:
            end = gaps[0].low if upwards else gaps[-1].high
        low, high = sorted((near, end))
        inside = [part for part in tongues if low <= part.low and part.high <= high]
        mode = np.array([part.mode for part in inside], dtype=np.int64)
        first, last = (np.array([part[side] for part in inside]) for side in (0, 1))
        peaks = _peaks(lambda x, i: self._growth(mode[i], x), first, last, _SAMPLES, _STEPS)
        return BandBeyond((begins.mode, begins.tongue), float(peaks.value.max()), is_thin=bool(gaps))

    def _dampings(
        self, bands: Sequence[tuple[float, float]], band: Ints, mode: Ints, low: Floats, high: Floats
    ) -> Floats:
        """Return the damping rate that each band requires, sampled in every mode, and in every tongue by itself."""
        peaks = _peaks(lambda x, i: self._damping(mode[i], x), low, high, _SAMPLES, 0)
        known = np.zeros(len(bands))
        np.maximum.at(known, band, peaks.value)
        last, _ = mode_constants(self.rod.replace(damping_rate=0.0)).modes_needed(self.search.load, 0.0)
        other_band, index = np.divmod(np.arange(len(bands) * last), last)
        first, after = (np.array([ends[side] for ends in bands])[other_band] for side in (0, 1))
        # What asks for less damping than is known by now need not be known.
        other_peaks = _peaks(
            lambda x, i: self._damping(index[i] + 1, x, known[other_band[i]]), first, after, _OF_OTHERS, 0
        )
        band, mode = np.append(band, other_band), np.append(mode, index + 1)
        peaks = _Peaks(*map(np.append, peaks, other_peaks))
        order = np.lexsort((peaks.value, band))
        best = order[np.append(np.diff(band[order]) > 0, True)]  # the last one of each band is its largest
        closer = _peaks(
            lambda x, i: self._damping(mode[best[i]], x), peaks.low[best], peaks.high[best], _CLOSER, _STEPS
        )
        return np.asarray(np.maximum(peaks.value[best], closer.value))

    def _coefficients(self, mode: Ints, values: Floats) -> tuple[Floats, Floats, Floats]:
        """Return alpha, beta and the frequency of modes, each at its own load."""
        systems = ModalSystems(mode_constants(self.rod), Loads.along(self.search.load, self.search.varied, values))
        return *systems.coefficients(mode), systems.loads.frequency

    def _growth(self, mode: Ints, values: Floats) -> Floats:
        """Return the growth rates of modes in 1/s, each at its own load."""
        alpha, beta, frequency = self._coefficients(mode, values)
        return np.asarray(mathieu.growth_rate(alpha, beta, self.rod.damping_rate / frequency) * frequency)

    def _damping(self, mode: Ints, values: Floats, least: Floats | float = 0.0) -> Floats:
        """Return the damping rates in 1/s above which modes are stable, each at its own load; 0 for some < least."""
        alpha, beta, frequency = self._coefficients(mode, values)
        return np.asarray(damping_to_stabilise(alpha, beta, least / frequency) * frequency)


def sampled_bands(
    model: ModeModel, search: Search, bands: Sequence[tuple[float, float]], progress: Progress | None
) -> tuple[UnstableBand, ...]:
    """Return unstable bands of coupled modes by samples, each with the cause of growth at its worst load."""
    varied, template, _, tolerance = search

    def growth(values: Floats, _: Ints) -> Floats:
        rate = model.growth_estimate(Loads.along(template, varied, values), tolerance)
        return np.asarray(np.where(np.isnan(rate), 0.0, rate))

    low, high = (np.array([ends[side] for ends in bands]) for side in (0, 1))
    peaks = _peaks(growth, low, high, _SAMPLES, _FEWER_STEPS)
    rows = []
    for ends, worst_load, rate in zip(bands, peaks.at.tolist(), peaks.value.tolist(), strict=True):
        load = template.varied(varied, worst_load)
        count = model.count_for(Loads.single(load), tolerance)
        worst = model.verdict(load, range(1, count + 1), tolerance)
        cause: WhatGrows = worst.resonances[0] if worst.resonances else "unnamed"
        rows.append(UnstableBand(*ends, rate, worst_load, cause, worst.damping_to_stabilise))
        if progress is not None:
            progress(len(rows), len(bands))
    return tuple(rows)


class _Peaks(NamedTuple):
    """The largest value on each interval, where, and the sampled places next to it."""

    at: Floats
    value: Floats
    low: Floats
    high: Floats


def _peaks(values: Values, low: Floats, high: Floats, points: int, steps: int) -> _Peaks:
    """Return the largest of some values on each interval, evaluated ever closer to the largest before."""
    peaks = _largest(values, low, high, points)
    for _ in range(steps):
        closer = _largest(values, peaks.low, peaks.high, _CLOSER)
        better = closer.value >= peaks.value
        at, value = np.where(better, closer.at, peaks.at), np.where(better, closer.value, peaks.value)
        peaks = _Peaks(at, value, closer.low, closer.high)
    return peaks


def _largest(values: Values, low: Floats, high: Floats, points: int) -> _Peaks:
    """Return the largest of some evenly spaced values on each interval, both ends included."""
    rows = np.arange(low.size)
    x = np.linspace(low, high, points, axis=1)
    y = values(x.ravel(), np.repeat(rows, points)).reshape(x.shape)
    best = y.argmax(axis=1)
    return _Peaks(
        x[rows, best], y[rows, best], x[rows, np.maximum(best - 1, 0)], x[rows, np.minimum(best + 1, points - 1)]
    )
