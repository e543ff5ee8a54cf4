"""What the explorer shows of the modes: each among the tongues of its equation, or the growth of all together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod.explorer.background import Stale, ViewParts
from floquetrod.explorer.portions import in_portions, statuses_and_rates
from floquetrod.explorer.source import PanelSource, most_modes
from floquetrod.plotting.explorer_panels import LineView, ModesView, RatesView, ShapeView, straightened
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.modes.mode_model import ModeModel

_CHART = 300, 240  # columns and rows of the chart of modes: pixels
_SHOWN = 0.01  # growth in 1/s that no mode beyond those shown exceeds: tenfold in four minutes
_FEWEST, _MOST = 6, 400  # modes shown
_FARTHEST = 1e4  # natural frequency over that of the load up to which the chart goes

_LINE = (17, 33, 65)  # frequencies of the line through the load, each finding those before it again


class ModesAndRates(PanelSource):
    """Where each mode lies among the tongues of Mathieu's equation, and how fast it grows: all of it at once."""

    panels: ClassVar[tuple[str, str]] = ("modes", "rates")

    def __init__(self, model: ModeModel, limits: dict[str, tuple[float, float]]) -> None:
        """Find how many modes are shown."""
        self.model = model
        self.numbers = np.arange(1, min(max(_FEWEST, most_modes(model, limits, _SHOWN)), _MOST) + 1)
        self.frame: tuple[float, float, float, float] | None = None
        self._drawn: tuple[object, ...] = ()

    def at_once(self, load: Load) -> ViewParts:
        """Return modes and rates."""
        system = self.model.among_tongues(load, self.numbers.tolist())
        if system is None:
            return {}
        growth = mathieu.growth_rate(system.alpha, system.beta, system.damping) * load.frequency
        modes = self._modes(system.alpha, system.beta, system.damping, growth)
        return {"rates": RatesView(self.numbers, growth), "modes": modes}

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


class LineAndShape(PanelSource):
    """Growth over the frequency and the shape that grows, found in time; keeps the known points of the line."""

    panels: ClassVar[tuple[str, str]] = ("line", "shape")

    def __init__(self, model: ModeModel, limits: dict[str, tuple[float, float]]) -> None:
        """Know nothing."""
        self.model, self.limits = model, limits
        self._line_of: tuple[float, float] | None = None
        self._growth: NDArray[np.float64] = np.full(_LINE[-1], np.nan)
        self._tried: NDArray[np.bool_] = np.zeros(_LINE[-1], dtype=np.bool_)

    def at_once(self, load: Load) -> ViewParts:
        """Return an empty line where the forces are others."""
        if self._line_of == (load.mean, load.amplitude):
            return {}
        return {"line": LineView(self._frequencies, np.full(_LINE[-1], np.nan))}

    def first(self, load: Load, verdict: RodStability, stale: Stale) -> Iterator[ViewParts]:
        """Yield growth at few frequencies, and the shape."""
        yield from self._line(load, stale, _LINE[:1])
        if not stale():
            yield {"shape": _shape(verdict)}

    def rest(self, load: Load, stale: Stale) -> Iterator[ViewParts]:
        """Yield growth at all frequencies."""
        yield from self._line(load, stale, _LINE)

    @property
    def _frequencies(self) -> NDArray[np.float64]:
        return np.linspace(*self.limits["frequency"], _LINE[-1])

    def _line(self, load: Load, stale: Stale, numbers: Sequence[int]) -> Iterator[ViewParts]:
        """Yield growth over the frequency, at ever more frequencies."""
        if self._line_of != (load.mean, load.amplitude):
            self._line_of = load.mean, load.amplitude
            self._growth, self._tried = np.full(_LINE[-1], np.nan), np.zeros(_LINE[-1], dtype=np.bool_)
        every = self._frequencies
        yield {"line": LineView(every, self._growth.copy())}

        def compute(chosen: NDArray[np.int64]) -> None:
            self._growth[chosen] = statuses_and_rates(self.model, Loads.along(load, "frequency", every[chosen]))[1]
            self._tried[chosen] = True

        for number in numbers:
            wanted = np.arange(0, _LINE[-1], (_LINE[-1] - 1) // (number - 1))
            for _ in in_portions(wanted[~self._tried[wanted]], compute, stale):
                yield {"line": LineView(every, self._growth.copy())}


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


def _shape(verdict: RodStability) -> ShapeView | None:
    """Return the shape that grows; None where the model does not say how its coordinates bend the rod."""
    try:
        shape = verdict.shape
    except ValueError:
        return None
    name = str(verdict.resonances[0]) if verdict.resonances else "the slowest to decay"
    return ShapeView(*shape, name, verdict.growth_rate)
