"""What is shown of a rod whose modes are independent: points and rates at once, curves and margins in time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod.explorer.background import Parts, Stale
from floquetrod.explorer.words import MARGINS, verdict_words
from floquetrod.plane import Bands, Chart, Progress
from floquetrod.plotting.explorer_panels import MapView, ModesView, RatesView, straightened
from floquetrod.rod.load import AxialLoad, Load
from floquetrod.rod.map import stability_map
from floquetrod.rod.modes import ModalSystem
from floquetrod.rod.rod import Rod

_ACCURACY = 1.0 / 1000.0  # of bands: a third of a pixel
_POINTS = 240, 180  # columns and rows of the map at most
_WORK = 1_500_000  # points times modes of a map at once: some 30 milliseconds
_CHART = 300, 240  # columns and rows of the chart of modes: pixels
_SHOWN = 0.01  # growth in 1/s that no mode beyond those shown exceeds (a choice)
_FEWEST, _MOST = 6, 400  # modes shown
_BANDED = 600  # modes up to which bands are searched: seconds (a choice)
_FARTHEST = 1e4  # natural frequency over that of the load up to which the chart goes


class _Replaced(Exception):  # no error: it ends a search that nobody waits for
    """The search has been replaced by another one."""


@dataclass
class IndependentModes:
    """The rod and the limits within which its load moves; keeps what the last move left as it was."""

    rod: Rod
    limits: dict[str, tuple[float, float]]
    chart: Chart | None = None
    banded: tuple[Chart, Bands] | None = None
    frame: tuple[float, float, float, float] | None = None
    _amplitude: float = math.nan
    panels: tuple[str, str] = ("modes", "rates")
    _drawn: tuple[object, ...] = field(default=())

    def __post_init__(self) -> None:
        """Find how many modes are looked at and shown."""
        (_, mean), (_, amplitude), (slowest, fastest) = self.limits.values()
        constants = self.rod.mode_constants
        every = [constants.modes_needed(AxialLoad(mean, amplitude, at), 0.0)[0] for at in (slowest, fastest)]
        seen = [constants.modes_needed(AxialLoad(mean, amplitude, at), _SHOWN)[0] for at in (slowest, fastest)]
        self.every = max(every)
        self.numbers = np.arange(1, min(max(_FEWEST, *seen), _MOST) + 1)
        fewer = min(1.0, math.sqrt(_WORK / (self.every * _POINTS[0] * _POINTS[1])))
        self.points = [max(24, int(fewer * number)) for number in _POINTS]

    def at_once(self, load: Load) -> Parts:
        """Return what follows a slider."""
        rate, mode = self.rod.fastest(load.mean, load.amplitude, load.frequency, like=load)
        status = "unstable" if rate > 0.0 else "stable"
        system = ModalSystem(self.rod.mode_constants, load, tuple(self.numbers.tolist()))
        growth = mathieu.growth_rate(system.alpha, system.beta, system.damping) * load.frequency
        parts: Parts = {"verdict": verdict_words(status, float(rate), f"mode {mode} grows"), "details": ""}
        if self.chart is None or self._amplitude != load.amplitude:
            self._amplitude, self.chart = load.amplitude, self._points(load, self.points)
            parts["map"] = _cells(self.chart)
        return parts | {
            "rates": RatesView(self.numbers, growth),
            "modes": self._modes(system.alpha, system.beta, system.damping, growth),
        }

    def in_time(self, load: Load, stale: Stale) -> Iterator[Parts]:
        """Yield what takes longer: the whole verdict, the bands between curves, and how far the verdict reaches."""
        verdict = self.rod.modes_under(load).verdict(load)
        words = f"mode {verdict.fastest_mode} grows"
        yield {"verdict": verdict_words(verdict.status, verdict.growth_rate, words)}
        chart = self.chart
        if chart is not None and self.every > _BANDED:
            yield {"map": _cells(self._points(load, _POINTS))}
        elif chart is not None:
            if self.banded is None or self.banded[0] is not chart:
                try:
                    self.banded = chart, chart.find_bands(_ACCURACY, progress=_ending(stale))
                except _Replaced:
                    return
            yield {"map": _cells(chart)._replace(bands=self.banded[1])}
        for name, margin in MARGINS.items():
            if stale():
                return
            yield {"margin": (name, margin(verdict))}

    def _points(self, load: Load, points: Sequence[int]) -> Chart:
        """Return the map at an amplitude, of so many columns and rows."""
        return stability_map(
            self.rod,
            mean=(*self.limits["mean"], points[1]),
            amplitude=load.amplitude,
            frequency=(*self.limits["frequency"], points[0]),
            like=load,
        )

    def _modes(
        self, alpha: NDArray[np.float64], beta: NDArray[np.float64], damping: float, growth: NDArray[np.float64]
    ) -> ModesView:
        """Return where modes lie among tongues, over axes that stay as they are for most moves."""
        x = np.clip(-np.sign(beta) * np.sqrt(np.abs(beta)), -_FARTHEST, _FARTHEST)
        wanted = _frame(x, alpha)
        frame = wanted if self.frame is None or not _holds(self.frame, wanted) else self.frame
        drawn = (frame, damping)
        tongues = None
        if drawn != self._drawn:
            across = np.linspace(straightened(frame[0]), straightened(frame[1]), _CHART[0])
            up = np.linspace(math.log10(frame[2]), math.log10(frame[3]), _CHART[1])
            places = straightened(across, back=True)
            tongues = ~mathieu.is_stable(10.0 ** up[:, None], -np.sign(places) * places**2, damping)
            self.frame, self._drawn = frame, drawn
        return ModesView(self.numbers, x, alpha, growth, frame, tongues)


def _cells(chart: Chart) -> MapView:
    return MapView((~chart.stable).astype(np.int8), None)


def _ending(stale: Stale) -> Progress:
    """Return what ends a search, from within it, once it is stale."""

    def watch(_done: int, _total: int) -> None:
        if stale():
            raise _Replaced

    return watch


def _frame(x: NDArray[np.float64], alpha: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return round ends of axes that hold all modes: left, right, bottom, top."""
    left = -0.5 if x.min() >= -0.4 else -1.25 * 2.0 ** math.ceil(math.log2(-x.min()))
    right = 1.25 * 2.0 ** math.ceil(math.log2(max(float(x.max()), 1.0)))
    low, high = (max(float(value), 1e-6) for value in (alpha[0], alpha[-1]))
    return left, right, 10.0 ** math.floor(math.log10(low) - 0.1), 10.0 ** math.ceil(math.log10(high) + 0.1)


def _holds(frame: tuple[float, ...], wanted: tuple[float, ...]) -> bool:
    """Return whether axes hold what they must and are not much larger, so that they may stay."""
    left, right, bottom, top = frame
    holds = left <= wanted[0] and wanted[1] <= right and bottom <= wanted[2] and wanted[3] <= top
    larger = (right / wanted[1], wanted[2] / bottom, top / wanted[3])
    return holds and larger[0] <= 2.0 and max(larger[1:]) <= 11.0
