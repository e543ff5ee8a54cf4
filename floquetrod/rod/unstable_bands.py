"""Between stability intervals: how fast the unstable bands grow at the most, and which damping stabilises them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod.floquet.systems.result import Resonance
from floquetrod.mathieu.tongues import damping_to_stabilise
from floquetrod.rod.coupled import CoupledLoads
from floquetrod.rod.coupled_stability import classify_coupled
from floquetrod.rod.load import Load, Loads, Progress, Quantity
from floquetrod.rod.modal import ModalRod
from floquetrod.rod.modes import ModalSystem, ModalSystems
from floquetrod.rod.tongues import tongues_within

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Values: TypeAlias = Callable[[Floats, Ints], Floats]
"""Values at places, one for each, in the intervals with the numbers given."""

Named: TypeAlias = tuple[int, int] | Resonance | Literal["unnamed"]
"""What grows: (mode, tongue), a resonance of coupled modes, or "unnamed" where that could not be told."""

_SAMPLES = 17  # loads at which growth and damping are evaluated in each tongue of a band (a choice)
_OF_OTHERS = 3  # at which the damping is, in each band, that modes which do not grow there require (a choice)
_CLOSER = 9  # places in each step of a refinement: the interval then shrinks to a quarter (a choice)
_STEPS, _FEWER_STEPS = 6, 3  # of a refinement: to 4^-6 of the distance of samples, or to 4^-3


class UnstableBand(NamedTuple):
    """A range of one quantity of the load, in N or rad/s, in which some mode grows, or may grow where undecided.

    Attributes
    ----------
    low, high : float
        Its ends: those of stability intervals, or of the search.
    worst_growth : float
        Largest growth rate in it, in 1/s; zero where none is seen to grow.
    at : float
        Where that is.
    cause : (int, int), Resonance or "unnamed"
        What grows there: (mode, tongue), where modes are coupled a resonance.
    required_damping : float
        The rod's total damping rate in 1/s above which every rate stabilises all of the band, infinite where
        none does.  Where modes are coupled, that of the load ``at`` which growth is worst.
    """

    low: float
    high: float
    worst_growth: float
    at: float
    cause: Named
    required_damping: float


@dataclass(frozen=True)
class Searched:
    """What a search of stability intervals went through: one quantity of a load on a rod.

    Attributes
    ----------
    rod : ModalRod
    varied : Quantity
    load : Load
        With the largest value of what is varied.
    growth_tolerance : float
        In 1/s.
    modes : int
        Modes looked at, 1 to this.
    """

    rod: ModalRod
    varied: Quantity
    load: Load
    growth_tolerance: float
    modes: int

    @property
    def has_coupled_modes(self) -> bool:
        """Whether modes do not obey an equation of Mathieu's each."""
        return not self.rod.coupled_numbers.has_mathieu_modes(self.load)

    def unstable_bands(
        self, bands: Sequence[tuple[float, float]], progress: Progress | None = None
    ) -> tuple[UnstableBand, ...]:
        """Return what grows between the ends of bands, in increasing order, in which nothing is stable."""
        if not bands:
            return ()
        return self._coupled(bands, progress) if self.has_coupled_modes else self._independent(bands)

    def _independent(self, bands: Sequence[tuple[float, float]]) -> tuple[UnstableBand, ...]:
        system = ModalSystem(self.rod.mode_constants, self.load, tuple(range(1, self.modes + 1)))
        parts = tongues_within(self.varied, system, self.growth_tolerance, bands).intervals
        low, high = (np.array([part[side] for part in parts]) for side in (0, 1))
        mode = np.array([part.mode for part in parts], dtype=np.int64)
        found = _peaks(lambda x, i: self._growth(mode[i], x), low, high, _SAMPLES, _STEPS)
        band = np.searchsorted(np.array([ends[0] for ends in bands]), low, side="right") - 1
        damping = self._dampings(bands, band, mode, low, high)
        rows = []
        for k, ends in enumerate(bands):
            inside = np.flatnonzero(band == k)
            rate, at = 0.0, 0.5 * sum(ends)  # where a band is too narrow for doubles in between
            cause: Named = "unnamed"
            if inside.size:
                worst = int(inside[found.value[inside].argmax()])
                rate, at = float(found.value[worst]), float(found.at[worst])
                cause = parts[worst].mode, parts[worst].tongue
            rows.append(UnstableBand(*ends, rate, at, cause, float(damping[k])))
        return tuple(rows)

    def _dampings(
        self, bands: Sequence[tuple[float, float]], band: Ints, mode: Ints, low: Floats, high: Floats
    ) -> Floats:
        """Return the damping rate that each band requires, sampled in every mode, and in every tongue by itself."""
        found = _peaks(lambda x, i: self._damping(mode[i], x), low, high, _SAMPLES, 0)
        known = np.zeros(len(bands))
        np.maximum.at(known, band, found.value)
        last, _ = self.rod.replace(damping_rate=0.0).modes_needed(self.load, 0.0)
        other, index = np.divmod(np.arange(len(bands) * last), last)
        first, after = (np.array([ends[side] for ends in bands])[other] for side in (0, 1))
        # What asks for less damping than is known by now need not be known.
        more = _peaks(lambda x, i: self._damping(index[i] + 1, x, known[other[i]]), first, after, _OF_OTHERS, 0)
        band, mode = np.append(band, other), np.append(mode, index + 1)
        found = _Peaks(*(np.append(one, two) for one, two in zip(found, more, strict=True)))
        order = np.lexsort((found.value, band))
        best = order[np.append(np.diff(band[order]) > 0, True)]  # the last one of each band is its largest
        closer = _peaks(
            lambda x, i: self._damping(mode[best[i]], x), found.low[best], found.high[best], _CLOSER, _FEWER_STEPS
        )
        return np.asarray(np.maximum(found.value[best], closer.value))

    def _coefficients(self, mode: Ints, values: Floats) -> tuple[Floats, Floats, Floats]:
        """Return alpha, beta and the frequency of modes, each at its own load."""
        systems = ModalSystems(self.rod.mode_constants, Loads.along(self.load, self.varied, values))
        return *systems.coefficients(mode), systems.loads.frequency

    def _growth(self, mode: Ints, values: Floats) -> Floats:
        """Return the growth rates of modes in 1/s, each at its own load."""
        alpha, beta, frequency = self._coefficients(mode, values)
        return np.asarray(mathieu.growth_rate(alpha, beta, self.rod.damping_rate / frequency) * frequency)

    def _damping(self, mode: Ints, values: Floats, least: Floats | float = 0.0) -> Floats:
        """Return the damping rates in 1/s from which on modes are stable, each at its own load; 0 for some < least."""
        alpha, beta, frequency = self._coefficients(mode, values)
        return np.asarray(damping_to_stabilise(alpha, beta, least / frequency) * frequency)

    def _coupled(self, bands: Sequence[tuple[float, float]], progress: Progress | None) -> tuple[UnstableBand, ...]:
        numbers = self.rod.coupled_numbers

        def growth(values: Floats, _: Ints) -> Floats:
            loads = Loads.along(self.load, self.varied, values)
            rate = CoupledLoads(numbers, self.load, loads, self.growth_tolerance).answers(quick=True).growth
            return np.asarray(np.where(np.isnan(rate), 0.0, rate))

        low, high = (np.array([ends[side] for ends in bands]) for side in (0, 1))
        found = _peaks(growth, low, high, _SAMPLES, _FEWER_STEPS)
        rows = []
        for ends, at, rate in zip(bands, found.at.tolist(), found.value.tolist(), strict=True):
            load = self.load.varied(self.varied, at)
            count = numbers.modes_needed(Loads.single(load), load, self.growth_tolerance)
            worst = classify_coupled(self.rod, load, count, self.growth_tolerance)
            cause: Named = worst.resonances[0] if worst.resonances else "unnamed"
            rows.append(UnstableBand(*ends, rate, at, cause, worst.damping_to_stabilise))
            if progress is not None:
                progress(len(rows), len(bands))
        return tuple(rows)


class _Peaks(NamedTuple):
    """The largest value found on each interval, where, and the places next to it."""

    at: Floats
    value: Floats
    low: Floats
    high: Floats


def _peaks(values: Values, low: Floats, high: Floats, points: int, steps: int) -> _Peaks:
    """Return the largest of some values on each interval, evaluated ever closer to the largest before."""
    found = _largest(values, low, high, points)
    for _ in range(steps):
        closer = _largest(values, found.low, found.high, _CLOSER)
        better = closer.value >= found.value
        at, value = np.where(better, closer.at, found.at), np.where(better, closer.value, found.value)
        found = _Peaks(at, value, closer.low, closer.high)
    return found


def _largest(values: Values, low: Floats, high: Floats, points: int) -> _Peaks:
    """Return the largest of some evenly spaced values on each interval, both ends included."""
    rows = np.arange(low.size)
    x = np.linspace(low, high, points, axis=1)
    y = values(x.ravel(), np.repeat(rows, points)).reshape(x.shape)
    best = y.argmax(axis=1)
    return _Peaks(
        x[rows, best], y[rows, best], x[rows, np.maximum(best - 1, 0)], x[rows, np.minimum(best + 1, points - 1)]
    )
