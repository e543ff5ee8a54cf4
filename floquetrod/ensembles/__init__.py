"""One simulation with many values of its parameters: axes, workers, stores and statistics."""

from __future__ import annotations

from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.statistics import probability

__all__ = ["Runs", "probability"]
