"""Axes of a plane, and their values as people give them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent

_MOST_POINTS = 1 << 28  # of a chart, which are five gigabytes with growth rates and modes (a choice)


@dataclass(frozen=True, eq=False)
class Axis(ByContent):
    """One axis of a chart: the quantity, its symbol in mathematics, its unit ("" for none) and its values."""

    name: str
    symbol: str
    unit: str
    values: Floats

    @property
    def ends(self) -> Axis:
        """The same axis with its first and last value only."""
        return Axis(self.name, self.symbol, self.unit, self.values[[0, -1]])

    @property
    def cell_edges(self) -> Floats:
        """Where the cells about the values begin and end, midway to the neighbours and no further than the axis."""
        values = self.values
        return np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1]), values[-1:]])

    @property
    def label(self) -> str:
        """Label of the axis, symbol and unit included."""
        if not self.symbol:
            return self.name + (f" / {self.unit}" if self.unit else "")
        # "alpha" and its letter would say it twice
        name = "" if self.symbol.replace("_{", "").strip("\\}") == self.name.replace("_", "") else self.name
        return units.label(name, self.symbol, self.unit)


def axis_values(name: str, values: Any) -> Floats:
    """Return the values of an axis given as (low, high, number) or as an increasing array of another length than 3."""
    array = validate.array(name, values, least=-1e12, largest=1e12)
    if array.ndim != 1 or array.size < 2:
        raise ValueError(f"{name} must be (low, high, number) or an increasing array, got {validate.short(values)}")
    if array.size == 2 and isinstance(values, tuple):
        raise ValueError(f"{name} must be (low, high, number), got {validate.short(values)} without a number of points")
    if array.size == 3 and isinstance(values, tuple):
        count = validate.integer(f"{name}[2]", values[2], 2)
        require_bearable(count, f"{name}[2]")
        if not array[0] < array[1]:
            raise ValueError(f"{name} must be (low, high, number) with low < high, got {validate.short(values)}")
        return np.linspace(array[0], array[1], count)
    if not (np.diff(array) > 0.0).all():
        raise ValueError(f"{name} must increase from value to value, got {validate.short(values)}")
    return array


def require_bearable(points: int, name: str) -> None:
    """Raise ValueError for more points than a chart may have."""
    if points > _MOST_POINTS:
        raise ValueError(f"{name} must be at most {_MOST_POINTS:,}, got {points:,}; take fewer, or a part of the plane")
