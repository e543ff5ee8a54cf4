"""What is shown of a rod whose modes are coupled: all of it takes time, and appears as it is found."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from floquetrod.explorer.background import Parts, Stale
from floquetrod.explorer.words import MARGINS, verdict_words
from floquetrod.plotting.explorer_panels import UNKNOWN, LineView, MapView, ShapeView
from floquetrod.rod.load import Load, Loads
from floquetrod.rod.rod import Rod
from floquetrod.rod.verdict import RodStability

_MAP = 32, 24  # columns and rows of the map in the end
_COARSENINGS = (8, 4, 2, 1)  # cells side by side that are one at first
_LINE = (17, 33, 65)  # frequencies of the line through the load, each finding those before it again
_AT_ONCE = 0.15  # seconds after which what was found is shown (a choice)


class CoupledModes:
    """The rod and the limits within which its load moves; keeps what is known of the map and of the line."""

    panels: ClassVar[tuple[str, str]] = ("line", "shape")

    def __init__(self, rod: Rod, limits: dict[str, tuple[float, float]]) -> None:
        self.rod, self.limits = rod, limits
        self._map_of: float | None = None
        self._cells: NDArray[np.int8] = np.full(_MAP[::-1], UNKNOWN, dtype=np.int8)
        self._line_of: tuple[float, float] | None = None
        self._growth: NDArray[np.float64] = np.full(_LINE[-1], np.nan)
        self._tried: NDArray[np.bool_] = np.zeros(_LINE[-1], dtype=np.bool_)

    def at_once(self, load: Load) -> Parts:
        """Return what follows a slider: what is no longer so disappears."""
        parts: Parts = {"verdict": "being judged ...", "details": ""}
        if self._map_of != load.amplitude:
            parts["map"] = MapView(np.full(_MAP[::-1], UNKNOWN, dtype=np.int8), None)
        if self._line_of != (load.mean, load.amplitude):
            parts["line"] = LineView(self._frequencies, np.full(_LINE[-1], np.nan))
        return parts

    def in_time(self, load: Load, stale: Stale) -> Iterator[Parts]:
        """Yield the verdict, growth over the frequency, the shape that grows, an ever finer map, the margins."""
        try:
            verdict = self.rod.modes_under(load).verdict(load)
        except ValueError as error:  # too many modes, or a resonance of axial waves
            yield {"verdict": f"no verdict: {str(error).partition(';')[0]}", "shape": None}
            yield from self._line(load, stale, _LINE)
            yield from self._map(load, stale, _COARSENINGS)
            return
        what = f"{verdict.resonances[0]}," if verdict.resonances else "growth"
        yield {"verdict": verdict_words(verdict.status, verdict.growth_rate, what)}
        yield from self._line(load, stale, _LINE[:1])
        if not stale():
            yield {"shape": _shape(verdict)}
        yield from self._map(load, stale, _COARSENINGS[:2])
        yield from self._line(load, stale, _LINE)
        yield from self._map(load, stale, _COARSENINGS)
        if verdict.has_quick_margins:
            for name, margin in MARGINS.items():
                if stale():
                    return
                yield {"margin": (name, margin(verdict))}

    @property
    def _frequencies(self) -> NDArray[np.float64]:
        return np.linspace(*self.limits["frequency"], _LINE[-1])

    def _line(self, load: Load, stale: Stale, numbers: Sequence[int]) -> Iterator[Parts]:
        """Yield growth over the frequency, at ever more frequencies."""
        if self._line_of != (load.mean, load.amplitude):
            self._line_of = load.mean, load.amplitude
            self._growth, self._tried = np.full(_LINE[-1], np.nan), np.zeros(_LINE[-1], dtype=np.bool_)
        every = self._frequencies
        yield {"line": LineView(every, self._growth.copy())}

        def found(chosen: NDArray[np.int64]) -> None:
            self._growth[chosen] = _judged(self.rod, load, Loads.along(load, "frequency", every[chosen]))[1]
            self._tried[chosen] = True

        for number in numbers:
            wanted = np.arange(0, _LINE[-1], (_LINE[-1] - 1) // (number - 1))
            for _ in _in_portions(wanted[~self._tried[wanted]], found, stale):
                yield {"line": LineView(every, self._growth.copy())}

    def _map(self, load: Load, stale: Stale, sides: Sequence[int]) -> Iterator[Parts]:
        """Yield the map in ever smaller cells."""
        if self._map_of != load.amplitude:
            self._map_of, self._cells = load.amplitude, np.full(_MAP[::-1], UNKNOWN, dtype=np.int8)
        yield {"map": MapView(self._filled(1), None)}
        # Middles of cells, the map's edges those of the sliders.
        frequency, mean = (
            low + (np.arange(number) + 0.5) * (high - low) / number
            for number, (low, high) in zip(_MAP, (self.limits["frequency"], self.limits["mean"]), strict=True)
        )

        def found(places: NDArray[np.int64]) -> None:
            column, row = places.T
            loads = Loads((len(places),), mean[row], np.full(len(places), load.amplitude), frequency[column])
            self._cells[row, column] = 1 - _judged(self.rod, load, loads)[0]

        for side in sides:
            # Neighbours in frequency together: they share the number of modes.
            places = np.array(
                [(i, j) for i in range(side // 2, _MAP[0], side) for j in range(side // 2, _MAP[1], side)]
            )
            unknown = self._cells[places[:, 1], places[:, 0]] == UNKNOWN
            for _ in _in_portions(places[unknown], found, stale):
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


def _judged(rod: Rod, like: Load, loads: Loads) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Return statuses and growth rates in 1/s; -1 and NaN of loads that cannot be judged."""
    try:
        found = rod.modes_under(like).answers(loads)
    except ValueError:  # a resonance of axial waves, or too many modes
        if loads.size == 1:
            return np.array([-1], dtype=np.int8), np.array([np.nan])
        each = [_judged(rod, like, loads.part(slice(i, i + 1))) for i in range(loads.size)]
        statuses, rates = zip(*each, strict=True)
        return np.concatenate(statuses), np.concatenate(rates)
    return found.status, found.growth


def _in_portions(wanted: NDArray[np.int64], found: Callable[[NDArray[np.int64]], None], stale: Stale) -> Iterator[None]:
    """Yield after each portion of what is wanted, of a size that takes about as long as may pass unseen."""
    at, size = 0, 4
    while at < len(wanted) and not stale():
        began = time.monotonic()
        found(wanted[at : at + size])
        taken = time.monotonic() - began
        at += size
        yield
        size = int(np.clip(size * _AT_ONCE / max(taken, 1e-3), max(1, size // 2), 2 * size))


def _shape(verdict: RodStability) -> ShapeView:
    name = str(verdict.resonances[0]) if verdict.resonances else "the slowest to decay"
    return ShapeView(*verdict.shape, name, verdict.growth_rate)
