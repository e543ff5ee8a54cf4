"""A plane of loads: two of mean force, amplitude and frequency vary, the third is fixed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import shaped
from floquetrod.mathieu.criterion import FiniteTimeCriterion
from floquetrod.plane import Axis, TracedBands
from floquetrod.plane.judging import VERTEX
from floquetrod.rod.loads.load import AnyLoad, Loads, Quantity
from floquetrod.rod.rod import Rod

_MOST_FAST, _MOST_SLOW = 100_000, 4000
"""Points judged at most for bands: by a criterion, and of coupled modes or with friction, a minute or so (a choice)."""

_VERTEX_SLOW = 1e-6
"""How far their vertices may be from the boundary, as a share of the axes: nearer to it verdicts take much longer."""


@dataclass(frozen=True)
class LoadPlane:
    """What is asked about a rod's loads in a plane; it judges places for `floquetrod.plane.TracedBands`.

    Attributes
    ----------
    across, up, fixed : str
        The quantities, that along x first; the last has one value, ``value``.
    growth_tolerance, criterion, friction, kick, like, workers
        As in `stability_map`.
    """

    rod: Rod
    across: Quantity
    up: Quantity
    fixed: Quantity
    value: float
    growth_tolerance: float
    criterion: FiniteTimeCriterion | None
    friction: float | None
    kick: float | None
    like: AnyLoad | None
    workers: int | None

    def verdicts(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Any:
        """Return 1 where stable, 0 where not, -1 where undecided, x and y broadcast against each other."""
        return self.rod.verdicts(
            *self._load(x, y),
            growth_tolerance=self.growth_tolerance,
            criterion=self.criterion,
            friction=self.friction,
            kick=self.kick,
            like=self.like,
            workers=self.workers,
        )

    def with_growth(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[Any, Any, Any]:
        """Return verdicts, growth rates in 1/s and the numbers of the fastest modes."""
        if self.criterion is not None:
            return self.verdicts(x, y), *self.fastest(x, y)
        loads = Loads.of(*self._load(x, y))
        found = self.rod.modes_under(self.like).answers(loads, self.growth_tolerance, self.workers)
        return shaped(found.status, loads.shape), shaped(found.growth, loads.shape), shaped(found.mode, loads.shape)

    def fastest(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[Any, Any]:
        """Return the growth rate in 1/s and the number of the fastest mode."""
        return self.rod.fastest(*self._load(x, y), like=self.like, workers=self.workers)

    def growth(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the growth rate in 1/s."""
        return np.asarray(self.fastest(x, y)[0])

    def __call__(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
        """Return verdicts, and NaN: growth is asked for apart."""
        return np.asarray(self.verdicts(x, y)).astype(np.int8), np.full(x.size, np.nan)

    def traced(self, x: Axis, y: Axis, verdicts: NDArray[np.int8]) -> TracedBands:
        """Return the source that traces the bands of a map; growth is not known with friction or a criterion."""
        plain = self.criterion is None and self.friction is None
        growth = self.growth if plain else None
        fast = self.criterion is not None and self.friction is None
        most, vertex = (_MOST_FAST, VERTEX) if fast else (_MOST_SLOW, _VERTEX_SLOW)
        return TracedBands(
            self, x, y, verdicts == 0, "1/s", self.growth_tolerance, growth, most=most, vertex=vertex, prompt=False
        )

    def _load(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[Any, Any, Any]:
        along: dict[Quantity, Any] = {self.across: x, self.up: y, self.fixed: self.value}
        return along["mean"], along["amplitude"], along["frequency"]
