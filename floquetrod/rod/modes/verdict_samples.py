"""Verdicts on a rod at samples along a quantity of the load, and where they change between them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod._util.roots import bisected
from floquetrod.floquet.first_change import FirstChange, first_change
from floquetrod.floquet.status import STABLE
from floquetrod.rod.answers.stability_intervals import Search
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.modes.mode_model import ModeModel

AT_ONCE = 16  # samples examined before a change is searched for (a choice)
HALVINGS = 36  # of the distance of two samples (a choice)


class VerdictCounts(NamedTuple):
    """How many verdicts the search of a piece takes: at samples, and to halve the distance of two of them."""

    samples: int
    halvings: int
    seconds_each: float = 0.0

    def in_time(self, seconds: float, seconds_each: float, least: VerdictCounts) -> VerdictCounts:
        """Return as many verdicts as time allows, no more than these, and none where that is less than the least."""
        verdicts = min(seconds / seconds_each, 1000.0)
        if verdicts < least.samples:
            return VerdictCounts(0, 0)
        samples = max(least.samples, min(self.samples, int(0.5 * verdicts)))
        halvings = max(least.halvings, min(self.halvings, int(verdicts) - samples))
        return VerdictCounts(samples, halvings, seconds_each)

    @property
    def seconds(self) -> float:
        """The duration of the search, as estimated."""
        return (self.samples + self.halvings) * self.seconds_each


class VerdictSamples(NamedTuple):
    """Verdicts along one quantity of the load."""

    model: ModeModel
    search: Search
    halvings: int = HALVINGS

    def stable(self, values: Floats, progress: Progress | None = None) -> Bools:
        """Return where the rod is stable."""
        model = self.model.under(self.search.load)
        loads = Loads.along(self.search.load, self.search.varied, values)
        return np.asarray(model.status(loads, self.search.growth_tolerance, None, progress) == STABLE)

    def locate(self, good: Floats, bad: Floats) -> Floats:
        """Return the last stable values between stable and unstable ones."""
        return bisected(self.stable, good, bad, self.halvings)[0]

    def first_change(
        self,
        samples: int,
        begins: bool,
        *,
        known: bool,
        at_once: int,
        refused: type[Exception] | tuple[()] = (),
        progress: Progress | None = None,
    ) -> FirstChange:
        """Return where the verdict first changes within the bounds of the search, from the first on.

        ``known`` where the first sample has the verdict ``begins``; at an error ``refused`` the search ends.
        """
        values = np.linspace(*self.search.bounds, samples)

        def blocks() -> Iterator[tuple[Floats, Bools]]:
            last = values[:1] if known else values[:0]
            for start in range(int(known), samples, at_once):
                block = values[start : start + at_once]
                yield np.append(last, block), np.append(np.full(last.size, begins), self.stable(block))
                if progress is not None:
                    progress(min(start + at_once, samples), samples)
                last = block[-1:]

        return first_change(
            blocks(), begins, self.locate, self.search.bounds, abs(float(values[1] - values[0])), refused
        )
