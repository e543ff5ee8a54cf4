"""What an ensemble of 10,000 short runs costs above the runs themselves, and whether its memory stays flat.

The runs themselves, with what is kept of them, are made one after another in a loop.  Processor time is compared, of
all threads: on a machine that others use it repeats better than the clock.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import floquetrod as fr
from benchmarks.measure import Row
from floquetrod.simulation import axes, workers

LOAD = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
PROBLEM = fr.SimulationProblem(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5)
RUNS = 10_000
OVER = {"frequency": [120.0, 150.0], "kick": [0.01, 0.02, 0.05, 0.1], "seed": range(RUNS // 8)}
PARTS = 5  # in which both are made in turn, so that a machine that slows down slows both


def run() -> list[Row]:
    """Return the ratio of processor times, and how much memory the second half of the runs adds."""
    study = axes.study_of(PROBLEM, OVER, "grid", None, 0)
    job = workers.Job(PROBLEM, None, None, False)
    step, alone, together, peaks = RUNS // PARTS, 0.0, 0.0, []
    workers.carry_out(job, [(0, study.values(0))])  # what is compiled is compiled
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(1) as pool:
        store = Path(folder) / "runs.zarr"
        fr.ensemble(PROBLEM, {"seed": [1]}, executor=pool, store=Path(folder) / "first.zarr")  # and imported
        for k in range(PARTS):
            runs = range(k * step, (k + 1) * step)
            alone += taken(lambda runs=runs: workers.carry_out(job, [(i, study.values(i)) for i in runs]))
            part = (k + 1, PARTS)
            together += taken(lambda part=part: fr.ensemble(PROBLEM, OVER, executor=pool, store=store, part=part))
            peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)
    return [
        Row(f"{RUNS:,} short runs with a zarr store, over the runs themselves", together / alone, "", at_most=1.05),
        Row("one of these runs", 1e3 * alone / RUNS, "ms"),
        Row("memory added after the first fifth of them", peaks[-1] - peaks[0], "MB", at_most=20.0),
    ]


def taken(work: Callable[[], object]) -> float:
    """Return the processor time in s that something takes in all threads."""
    started = time.process_time()
    work()
    return time.process_time() - started
