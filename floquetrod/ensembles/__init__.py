"""One simulation with many values of what it depends on: what is varied, who makes the runs, where results go."""

from __future__ import annotations

from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.statistics import probability

__all__ = ["Runs", "probability"]
