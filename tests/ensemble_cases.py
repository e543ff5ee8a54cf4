"""Small ensembles that several files of tests share, and scripts that other processes run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray

import conftest
import floquetrod as fr
from floquetrod.ensembles.runs import Runs, require_runs

ROOT = Path(__file__).parents[1]
LOAD = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
PROBLEM = fr.SimulationProblem(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5)
OVER = {"frequency": [120.0, 150.0], "kick": [0.01, 0.05, 0.1], "seed": range(5)}  # 30 runs
SEEDS = conftest.depth(100, 40)
"""Of ensembles long enough to be killed."""


def assert_same(one: Any, other: Any) -> None:
    """Assert that two ensembles have the same results to the bit; how long runs took may differ."""
    first, second = require_runs("one", one), require_runs("other", other)
    assert first.dims == second.dims
    assert first.units == second.units
    assert first.coords.keys() == second.coords.keys()
    assert first.variables.keys() == second.variables.keys()
    for name in (first.coords | first.variables).keys() - {"wall_time"}:
        a, b = first[name], second[name]
        assert a.dtype.kind == b.dtype.kind, name
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name


def in_memory(found: Any) -> Runs:
    """Return an ensemble as `Runs`."""
    return require_runs("found", found)


def depth(run: fr.Simulation) -> Mapping[str, float]:
    """Return a summary."""
    return {"depth": float(run.positions[:, :, 2].min()), "early": run.ended != "duration"}


def fails_at_150(run: fr.Simulation) -> Mapping[str, float]:
    """Return a summary, but not for every frequency."""
    if run.problem.load.frequency == 150.0:
        raise ArithmeticError("this summary knows no 150 rad/s")
    return {"one": 1.0}


def exits_at_150(run: fr.Simulation) -> Mapping[str, float]:
    """Return a summary, but exit at one frequency."""
    if run.problem.load.frequency == 150.0:
        sys.exit(3)
    return {"one": 1.0}


def kills_at_150(run: fr.Simulation) -> Mapping[str, float]:
    """Return a summary, but end the process at one frequency."""
    if run.problem.load.frequency == 150.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"one": 1.0}


class Stopped:
    """Progress that interrupts after a number of runs, and counts all."""

    def __init__(self, after: float = np.inf) -> None:
        self.after, self.calls = after, 0

    def __call__(self, done: int, total: int) -> None:
        """Count a call."""
        self.calls += 1
        if self.calls == self.after:
            raise KeyboardInterrupt


def script(body: str, *arguments: object, **options: Any) -> subprocess.Popen[str]:
    """Start another Python that has imported what is in this file and runs a script."""
    start = (
        "import sys, numpy as np, floquetrod as fr\n"
        "from ensemble_cases import *\n"
        "from floquetrod.ensembles import stores\n"
        "stores._SECONDS_BETWEEN = 0.02\n"
        "if __name__ == '__main__':\n"
    )
    text = start + "".join(f"    {line}\n" for line in body.strip().splitlines())
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    return subprocess.Popen(
        [sys.executable, "-c", text, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": path},
        text=True,
        **options,
    )


def killed_again_and_again(place: Path, times: int, seed: int, how: str) -> int:
    """Kill a process that fills a store so many times, at random moments; return the runs it had then."""
    rng = np.random.default_rng(seed)
    for _ in range(times):
        body = f"fr.ensemble(PROBLEM, {{**OVER, 'seed': range(SEEDS)}}, store=sys.argv[1], {how})"
        with script(body, place, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
            while not place.exists() and process.poll() is None:
                time.sleep(0.01)
            time.sleep(float(rng.uniform(0.0, 0.6)))
            process.kill()
    return int((xarray.open_zarr(place).status == 1).sum())
