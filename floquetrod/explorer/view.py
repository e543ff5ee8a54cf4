"""What is shown of a rod under a load: what the model of its modes answers while a slider moves, the rest in time."""

from __future__ import annotations

from collections.abc import Iterator

from floquetrod.explorer.background import Stale, ViewParts
from floquetrod.explorer.maps import ChartMap, GrowingMap
from floquetrod.explorer.mode_panels import LineAndShape, ModesAndRates
from floquetrod.explorer.source import PanelSource
from floquetrod.explorer.verdict_words import MARGINS, verdict_words
from floquetrod.rod.answers.rod_stability import growing_in_words
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.rod import Rod


class View:
    """The verdict, a map and two panels on the modes; the model of the modes decides which.

    ``load`` is of the kind that is shown; its quantities move between ``limits``, in SI units.
    """

    def __init__(self, rod: Rod, load: Load, limits: dict[str, tuple[float, float]]) -> None:
        """Choose the panels."""
        self.model = model = rod._modes_under(load)
        self.map: PanelSource = ChartMap(rod, model, limits) if model.prompt else GrowingMap(model, limits)
        located = model.among_tongues(load, (1,)) is not None
        modes = ModesAndRates(model, limits) if located else LineAndShape(model, limits)
        self.modes: PanelSource = modes
        self.panels: tuple[str, str] = modes.panels  # names of those beside the map

    def at_once(self, load: Load) -> ViewParts:
        """Return the panels that follow a slider, with a verdict if it takes no longer than a slider may wait."""
        verdict = "being judged ..."
        if self.model.prompt:
            rate, mode = (values[0] for values in self.model.fastest(Loads.single(load)))
            words = f"mode {mode} grows" if mode > 0 else "growth"
            verdict = verdict_words("unstable" if rate > 0.0 else "stable", float(rate), words)
        return {"verdict": verdict, "details": ""} | self.map.at_once(load) | self.modes.at_once(load)

    def in_time(self, load: Load, stale: Stale) -> Iterator[ViewParts]:
        """Yield the whole verdict, what the panels find in time, and how far the verdict reaches."""
        try:
            verdict = self.model.verdict(load)
        except ValueError as error:  # too many modes, or a resonance of axial waves
            yield {"verdict": f"no verdict: {str(error).partition(';')[0]}", "shape": None}
            yield from self._rest(load, stale)
            return
        yield {"verdict": verdict_words(verdict.status, verdict.growth_rate, growing_in_words(verdict))}
        for source in (self.modes, self.map):
            yield from source.first(load, verdict, stale)
        yield from self._rest(load, stale)
        for name, margin in MARGINS.items() if verdict.has_quick_margins else ():
            if stale():
                return
            yield {"margin": (name, margin(verdict))}

    def _rest(self, load: Load, stale: Stale) -> Iterator[ViewParts]:
        for source in (self.modes, self.map):
            yield from source.rest(load, stale)
