"""The map of the explorer: a chart at once and the bands of it in time, or cells that become ever smaller."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.progress import Progress
from floquetrod.explorer.background import Stale, ViewParts
from floquetrod.explorer.portions import in_portions, statuses_and_rates
from floquetrod.explorer.source import PanelSource, most_modes
from floquetrod.plane import Bands, Chart
from floquetrod.plotting.explorer_panels import UNKNOWN, MapView
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.rod import Rod
from floquetrod.rod.stability_map import stability_map

_ACCURACY = 1.0 / 1000.0  # of bands: a third of a pixel
_POINTS = 240, 180  # columns and rows of the chart at most
_WORK = 1_500_000  # points times modes of a chart at once: some 30 milliseconds
_BANDED = 600  # modes up to which bands are searched: seconds

_MAP = 32, 24  # columns and rows of the map that grows, in the end
_COARSENINGS = (8, 4, 2, 1)  # cells side by side that are one at first


class _Replaced(Exception):  # no error: it ends a search that nobody waits for
    """The search has been replaced by another one."""


class ChartMap(PanelSource):
    """A chart of points at once; in time its bands between exact curves, or more points where it has none."""

    def __init__(self, rod: Rod, model: ModeModel, limits: dict[str, tuple[float, float]]) -> None:
        """Find how many points can be judged at once."""
        self.rod, self.limits = rod, limits
        self.every = most_modes(model, limits, 0.0)
        fewer = min(1.0, math.sqrt(_WORK / (self.every * _POINTS[0] * _POINTS[1])))
        self.points = [max(24, int(fewer * number)) for number in _POINTS]
        self.chart: Chart | None = None
        self.banded: tuple[Chart, Bands] | None = None
        self._amplitude = math.nan

    def at_once(self, load: Load) -> ViewParts:
        """Return the chart where the amplitude is another one."""
        if self.chart is not None and self._amplitude == load.amplitude:
            return {}
        self._amplitude, self.chart = load.amplitude, self._points(load, self.points)
        return {"map": _cells(self.chart)}

    def first(self, load: Load, verdict: RodStability, stale: Stale) -> Iterator[ViewParts]:
        """Yield the bands, or a chart of more points."""
        chart = self.chart
        if chart is None:
            return
        if self.every > _BANDED or chart.source is None or not chart.source.prompt:
            if self.points != [*_POINTS]:
                yield {"map": _cells(self._points(load, _POINTS))}
            return
        if self.banded is None or self.banded[0] is not chart:
            try:
                self.banded = chart, chart.find_bands(_ACCURACY, progress=_ending(stale))
            except _Replaced:
                return
        yield {"map": _cells(chart)._replace(bands=self.banded[1])}

    def _points(self, load: Load, points: Sequence[int]) -> Chart:
        """Return the map at an amplitude, of so many columns and rows."""
        return stability_map(
            self.rod, load, mean=(*self.limits["mean"], points[1]), frequency=(*self.limits["frequency"], points[0])
        )


def _cells(chart: Chart) -> MapView:
    return MapView(chart.stable.astype(np.int8), None)


def _ending(stale: Stale) -> Progress:
    """Return what ends a search, from within it, once it is stale."""

    def watch(_done: int, _total: int) -> None:
        if stale():
            raise _Replaced

    return watch


class GrowingMap(PanelSource):
    """Cells judged in time, the large ones first; keeps the known cells of an amplitude."""

    def __init__(self, model: ModeModel, limits: dict[str, tuple[float, float]]) -> None:
        """Know nothing."""
        self.model, self.limits = model, limits
        self._amplitude: float | None = None
        self._cells: NDArray[np.int8] = np.full(_MAP[::-1], UNKNOWN, dtype=np.int8)

    def at_once(self, load: Load) -> ViewParts:
        """Return an empty map where the amplitude is another one."""
        return {} if self._amplitude == load.amplitude else {"map": MapView(np.full_like(self._cells, UNKNOWN), None)}

    def first(self, load: Load, verdict: RodStability, stale: Stale) -> Iterator[ViewParts]:
        """Yield the map in large cells."""
        yield from self._map(load, stale, _COARSENINGS[:2])

    def rest(self, load: Load, stale: Stale) -> Iterator[ViewParts]:
        """Yield the map in cells of every size."""
        yield from self._map(load, stale, _COARSENINGS)

    def _map(self, load: Load, stale: Stale, sides: Sequence[int]) -> Iterator[ViewParts]:
        """Yield the map in ever smaller cells."""
        if self._amplitude != load.amplitude:
            self._amplitude, self._cells = load.amplitude, np.full(_MAP[::-1], UNKNOWN, dtype=np.int8)
        yield {"map": MapView(self._filled(1), None)}
        # Middles of cells, the map's edges those of the sliders.
        frequency, mean = (
            low + (np.arange(number) + 0.5) * (high - low) / number
            for number, (low, high) in zip(_MAP, (self.limits["frequency"], self.limits["mean"]), strict=True)
        )

        def judge(places: NDArray[np.int64]) -> None:
            column, row = places.T
            loads = Loads((len(places),), mean[row], np.full(len(places), load.amplitude), frequency[column])
            self._cells[row, column] = statuses_and_rates(self.model, loads)[0]

        for side in sides:
            # Neighbours in frequency together: they share the number of modes.
            places = np.array(
                [(i, j) for i in range(side // 2, _MAP[0], side) for j in range(side // 2, _MAP[1], side)]
            )
            unknown = self._cells[places[:, 1], places[:, 0]] == UNKNOWN
            for _ in in_portions(places[unknown], judge, stale):
                yield {"map": MapView(self._filled(side), None)}

    def _filled(self, side: int) -> NDArray[np.int8]:
        """Return the cells, those not known yet as the known ones in whose larger cells they lie."""
        filled = self._cells.copy()
        for size in (s for s in _COARSENINGS if s >= side):
            at = size // 2
            known = self._cells[at::size, at::size]
            large = np.repeat(np.repeat(known, size, axis=0), size, axis=1)[: _MAP[1], : _MAP[0]]
            filled = np.where(large == UNKNOWN, filled, large)
        return np.where(self._cells == UNKNOWN, filled, self._cells)
