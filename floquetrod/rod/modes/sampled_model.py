"""Modes whose verdicts along a quantity of the load are found at samples: ranges, margins, bands, damping."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from floquetrod._util.progress import Progress
from floquetrod.floquet.first_change import FirstChange, bracket
from floquetrod.floquet.status import STABLE
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.stability_intervals import (
    Search,
    StabilityIntervals,
    UnstableBand,
    WhatGrows,
    intervals_along,
)
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.coupled_samples import SampledInterval, unstable_intervals
from floquetrod.rod.model.contact import up_to_wall
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.modes.sampled_ranges import SampledPiece, joined_intervals, pieces_of
from floquetrod.rod.modes.verdict_samples import AT_ONCE, HALVINGS, VerdictCounts, VerdictSamples

_CLOSER = 17  # places in a band at which growth is examined (a choice)
_STRONGEST = 10.0  # damping rate that is tried, in terms of the frequency of the load (a choice)
_MARGIN_SAMPLES = 65  # of each piece of a search for a margin (a choice)


@dataclass(frozen=True)
class SampledModel(ModeModel):
    """Modes without exact tongues, with verdicts under many loads, which sample the range of loads."""

    samples: ClassVar[int] = 257
    """Samples of each piece of a search."""
    at_once: ClassVar[int] = AT_ONCE
    """Samples that are examined before a change is searched for."""

    # --- margins ---

    @abstractmethod
    def buckles(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether the mean force alone buckles a mode."""

    def is_stable(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether a rod is seen to be stable under one load."""
        return bool(self.under(load).status(Loads((1,), *Loads.single(load).flat), growth_tolerance)[0] == STABLE)

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return a damping rate in 1/s above which this load is stable, to nine digits."""
        return self.damping_required(self.template, verdict.growth_tolerance)

    def margin_edge(
        self,
        verdict: RodStability,
        quantity: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> FirstChange:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, by samples."""
        load = self.template
        piece = up_to_wall(self.rod, load, quantity, piece)
        longest = max(1.0, load.frequency / min(piece)) if quantity == "frequency" else 1.0
        counts = self.margin_counts(verdict, seconds, longest)
        if piece[0] == piece[1] or not counts.samples:
            return FirstChange(None, piece[0], 0.0)
        search = Search(quantity, load, piece, verdict.margin_tolerance)
        change = VerdictSamples(self, search, counts.halvings).first_change(
            counts.samples,
            verdict.status == "stable",
            known=piece[0] == getattr(load, quantity),
            at_once=self.at_once,
            refused=ValueError,  # too many modes, or loads too large or too slow: nothing is known of them
            progress=progress,
        )
        return change._replace(seconds=counts.seconds)

    def margin_counts(self, verdict: RodStability, seconds: float, longest: float) -> VerdictCounts:
        """Return how many verdicts a piece of a search for a margin takes.

        ``longest`` is the longest period of its loads over the period of the load of the verdict.
        """
        return VerdictCounts(_MARGIN_SAMPLES, HALVINGS)

    # --- along a quantity ---

    def ranges(self, search: Search, progress: Progress | None) -> StabilityIntervals:
        """Return the stability intervals of one quantity of the load, sampled; ``resolution`` is their distance."""
        self.require_on_wall(search)
        samples = VerdictSamples(self, search)

        def unstable(piece: tuple[float, float], progress: Progress | None) -> tuple[list[SampledInterval], float]:
            values = np.linspace(*piece, self.samples)
            stable = samples.stable(values, progress)
            return unstable_intervals(values, stable, samples.locate, piece), float(values[1] - values[0])

        pieces = [SampledPiece(*ends, self.samples, unstable) for ends in pieces_of(search, self.rod.critical_force)]
        intervals, resolution = joined_intervals(search.bounds, pieces, progress)
        places = np.linspace(*search.bounds, self.samples)
        modes = self.count_for(Loads.along(search.load, search.varied, places), search.growth_tolerance)
        return intervals_along(self, search, intervals, modes, resolution)

    def first_growth(self, search: Search, progress: Progress | None) -> FirstChange:
        """Return where something first grows within bounds, from the low one up, by samples."""
        known = search.bounds[0] > 0.0
        return VerdictSamples(self, search).first_change(
            self.samples, True, known=known, at_once=self.at_once, progress=progress
        )

    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return the growth in each band, sampled, and the damping that the fastest growth requires."""
        unstable, model = [], self.under(search.load)
        for done, (low, high) in enumerate(bands, start=1):
            places = np.linspace(low, high, _CLOSER)
            _, growth, modes_there = model.answers(Loads.along(search.load, search.varied, places))
            worst = int(np.nan_to_num(growth).argmax())
            at = float(places[worst])
            damping = model.damping_required(search.load.varied(search.varied, at), search.growth_tolerance)
            fastest = int(modes_there[worst])
            cause: WhatGrows = fastest if fastest > 0 else "unnamed"
            unstable.append(UnstableBand(low, high, float(np.nan_to_num(growth)[worst]), at, cause, damping))
            if progress is not None:
                progress(done, len(bands))
        return tuple(unstable)

    def damping_required(self, load: Load, growth_tolerance: float) -> float:
        """Return the least damping rate in 1/s, to nine digits, above which a load is stable, as far as tried.

        Infinite where the mean force alone buckles a mode, and where none up to ten times the frequency of the load, or
        of the critical mode, is.
        """
        if self.buckles(load, growth_tolerance):
            return math.inf

        def is_calm(rate: float) -> bool:
            return replace(self, rod=self.rod.replace(damping_rate=rate)).is_calm(load, growth_tolerance)

        if is_calm(0.0):
            return 0.0
        fastest = max(load.frequency, self.rod.natural_frequency(self.rod.critical_mode))
        return bracket(is_calm, 1e-6 * load.frequency, _STRONGEST * fastest, 1e-9)[1]

    def is_calm(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether no mode is seen to grow under one load."""
        return self.is_stable(load, growth_tolerance)
