"""What an ensemble of 10,000 short runs costs above the runs themselves, and whether its memory stays flat.

A pool of one thread takes the processor time of every task, in which nothing but runs are made; it is compared with
that of the whole process, of the same execution: other work on the machine hardly changes their ratio.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import floquetrod as fr
from benchmarks.measure import Row

LOAD = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
PROBLEM = fr.SimulationProblem(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5)
RUNS = 10_000
OVER = {"frequency": [120.0, 150.0], "kick": [0.01, 0.02, 0.05, 0.1], "seed": range(RUNS // 8)}


class TimedPool(ThreadPoolExecutor):
    """A thread that adds up the processor time of its tasks in s."""

    seconds = 0.0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do a task and take its time."""

        def timed() -> Any:
            started = time.thread_time()
            try:
                return fn(*args, **kwargs)
            finally:
                self.seconds += time.thread_time() - started

        return super().submit(timed)


def run() -> list[Row]:
    """Return the ratio of processor times, and how much memory is added after the first tenth of the runs."""
    memory = []

    def note(done: int, total: int) -> None:
        if done in (total // 10, total):
            memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)

    with tempfile.TemporaryDirectory() as folder, TimedPool(1) as pool:
        # What is compiled and imported then is.
        fr.ensemble(PROBLEM, {"seed": [1]}, executor=pool, store=Path(folder) / "first.zarr")
        pool.seconds, started = 0.0, time.process_time()
        fr.ensemble(PROBLEM, OVER, executor=pool, store=Path(folder) / "runs.zarr", progress=note)
        whole = time.process_time() - started
    return [
        Row(f"{RUNS:,} short runs with a zarr store, over the runs themselves", whole / pool.seconds, "", at_most=1.05),
        Row("one of these runs", 1e3 * pool.seconds / RUNS, "ms"),
        Row("memory added after the first tenth of them", memory[-1] - memory[0], "MB", at_most=20.0),
    ]
