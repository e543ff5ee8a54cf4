"""A plane of loads: two of mean force, amplitude and frequency vary, the third is fixed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats, shaped
from floquetrod._util.progress import Progress
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.plane import Axis, Family, FoundBands, Verdicts
from floquetrod.plane.family import VERTEX
from floquetrod.plotting.chart_plot import NAMES
from floquetrod.rod.loads.load import LOAD, Load, Loads, Quantity
from floquetrod.rod.modes.mode_model import BandFinder, ModeModel
from floquetrod.rod.rod import Rod

_ACROSS: tuple[Quantity, ...] = ("frequency", "mean", "amplitude")
AXES: dict[Quantity, tuple[str, str, str]] = {name: (*NAMES[name], LOAD[name].unit) for name in _ACROSS}
"""Names, symbols and units of the quantities of a load, the one drawn to the right first."""


@dataclass(frozen=True)
class LoadPlane(Family):
    """A rod's loads over a plane."""

    rod: Rod
    across: Quantity  # along x
    up: Quantity
    fixed: Quantity  # of one value, ``value``
    value: float
    growth_tolerance: float  # this and all below as in `stability_map`
    test: FiniteTimeCriterion | None  # its criterion
    friction: float | None
    kick: float | None
    template: Load
    workers: int | None
    growth_unit: str = "1/s"

    @property
    def model(self) -> ModeModel:
        """The model of the modes."""
        return self.rod._modes_under(self.template)

    @property
    def is_plain(self) -> bool:
        """Whether stable means that nothing grows for all time, without friction."""
        return self.test is None and self.friction is None

    @property
    def prompt(self) -> bool:
        """Whether there are exact bands."""
        return self.is_plain and self.model.bands(self.across, self.up, self.value, self.growth_tolerance) is not None

    @property
    def criterion(self) -> str:
        """What passes the test."""
        return "" if self.test is None else str(self.test)

    @property
    def points_at_once(self) -> int:
        """As many as the model likes."""
        return self.model.loads_at_once or super().points_at_once

    @property
    def by_columns(self) -> bool:
        """Yes, along a column a force varies alone, so that a few of its systems tell of all."""
        return True

    @property
    def most_judged(self) -> int:
        """Fewer than usual, since a criterion, and more so coupled modes or friction, take a minute or so."""
        return 100_000 if self._is_fast else 4000

    @property
    def vertex(self) -> float:
        """Nearer to a boundary than this, verdicts take much longer, except by a criterion."""
        return VERTEX if self._is_fast else 1e-6

    @property
    def _is_fast(self) -> bool:
        return self.test is not None and self.friction is None

    def subject(self) -> dict[str, Any]:
        """Return the rod, its load, and what does not vary."""
        name, _, unit = AXES[self.fixed]
        fixed = [[name, self.value, unit], ["critical force", self.rod.critical_force, "N"]]
        if self.friction is not None:
            fixed += [["friction", self.friction, ""], ["kick", self.kick, "m/s"]]
        subject: dict[str, Any] = {"kind": "rod", "fixed": fixed, "rod": self.rod.as_dict()}
        if self.template.features:
            subject["load"] = self.template.kind_as_dict()
            subject["kind"] = f"rod, {self.template.features}"
        return subject

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return verdicts, with growth rates in 1/s and the numbers of the fastest modes where they must be known."""
        if growth and self.is_plain:
            loads = Loads.of(**self._load(x, y))
            answers = self.model.answers(loads, self.growth_tolerance, self.workers)
            return Verdicts(*(shaped(column, loads.shape) for column in answers))
        status = self.rod.verdicts(
            self.template,
            **self._load(x, y),
            growth_tolerance=self.growth_tolerance,
            criterion=self.test,
            friction=self.friction,
            kick=self.kick,
            workers=self.workers,
        )
        return Verdicts(np.asarray(status), *(self._fastest(x, y) if growth else ()))

    def growth(self, x: Floats, y: Floats) -> Floats:
        """Return growth rates in 1/s, which tell nothing about a test in finite time or a kick against friction."""
        return np.asarray(self._fastest(x, y)[0]) if self.is_plain else np.full(x.shape, np.nan)

    def exact_bands(self, x: Axis, y: Axis, accuracy: float, progress: Progress | None) -> FoundBands | None:
        """Return the bands between exact curves where the model has them."""
        find: BandFinder | None = None
        if self.is_plain:
            find = self.model.bands(self.across, self.up, self.value, self.growth_tolerance)
        return None if find is None else find(x, y, accuracy, progress)

    def _fastest(self, x: Floats, y: Floats) -> tuple[Any, Any]:
        """Return the growth rate in 1/s and the number of the fastest mode."""
        growth, mode = self.rod.growth_rate(self.template, **self._load(x, y), return_mode=True, workers=self.workers)
        return growth, mode

    def _load(self, x: Floats, y: Floats) -> dict[Quantity, Any]:
        return {self.across: x, self.up: y, self.fixed: self.value}
