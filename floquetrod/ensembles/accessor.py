"""``dataset.floquetrod`` for an xarray.Dataset; registered by `floquetrod.ensemble`, or by importing this module."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import xarray

from floquetrod.ensembles import statistics
from floquetrod.ensembles.runs import Runs

_register: Any = xarray.register_dataset_accessor


@_register("floquetrod")
class EnsembleAccessor:
    """Statistics of the results of an ensemble."""

    def __init__(self, dataset: Any) -> None:
        """Take the dataset."""
        self._dataset = dataset

    def probability(self, name: str = "buckled", *, over: str | Iterable[str], confidence: float = 0.95) -> Any:
        """Return what `floquetrod.ensembles.probability` does."""
        return statistics.probability(self._dataset, name, over=over, confidence=confidence)

    def plot(
        self, name: str = "buckled", *, over: Sequence[str] | None = None, confidence: float = 0.95, figure: Any = None
    ) -> Any:
        """Draw what `floquetrod.ensembles.runs.Runs.plot` does."""
        return Runs.of_each_run(self._dataset).plot(name, over=over, confidence=confidence, figure=figure)

    def to_csv(self, path: str | Path) -> Path:
        """Write what `floquetrod.ensembles.runs.Runs.to_csv` does."""
        return Runs.of_each_run(self._dataset).to_csv(path)
