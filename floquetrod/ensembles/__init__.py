"""One simulation with many values of its parameters: axes, workers, stores and statistics.

A run is a pure function of a problem and its values, so it does not matter which process computes it.  `workers`
submits tasks to an executor and notices when a worker dies; a store (`stores_disk`, `stores_zarr`) writes complete
chunks of runs, the status last, so that every run marked as done is complete.
"""

from __future__ import annotations

from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.statistics import probability

__all__ = ["Runs", "probability"]
