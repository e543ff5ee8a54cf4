"""Small ensembles that several files of tests share, and scripts that other processes run."""

from __future__ import annotations

import functools
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod.ensembles.runs import Runs, require_runs

ROOT = Path(__file__).parents[1]
LOAD = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
PROBLEM = fr.SimulationProblem(fr.Rod.nitinol(), LOAD, duration=0.01, segments=60, frames=5)
OVER = {"frequency": [120.0, 150.0], "kick": [0.01, 0.05, 0.1], "seed": [3, 4]}
RUNS = 12
"""Of `OVER`."""
SEEDS = 100
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


@functools.cache
def undisturbed(summary: Any = None, frames: bool = False) -> Any:
    """Return the runs of `OVER`, which nothing disturbs."""
    return fr.ensemble(PROBLEM, OVER, summary=summary, frames=frames)


@functools.cache
def _stored(varied: tuple[tuple[str, tuple[float, ...]], ...], frames: bool) -> tuple[dict[str, bytes], Any]:
    """Return the files of a store by their paths, and what is in it."""
    with tempfile.TemporaryDirectory() as name:
        place = Path(name) / "runs.zarr"
        found = fr.ensemble(PROBLEM, dict(varied), store=place, frames=frames).load()
        files = [path for path in place.rglob("*") if path.is_file()]
        return {path.relative_to(place).as_posix(): path.read_bytes() for path in files}, found


def stored(place: Path, over: Mapping[str, Sequence[float]], *, frames: bool) -> Any:
    """Make a store that holds all runs, once for all tests, and return what is in it."""
    files, found = _stored(tuple((name, tuple(values)) for name, values in over.items()), frames)
    for name, content in files.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_bytes(content)
    return found


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


def waits_at_140_dies_at_150(run: fr.Simulation) -> Mapping[str, float]:
    """Return a summary; at one frequency end the process, at another begin once and wait until that has happened."""
    frequency, folder = run.problem.load.frequency, Path(os.environ["ENSEMBLE_CASES"])
    with (folder / f"{frequency:g}").open("a") as file:
        file.write("made\n")
    if frequency == 150.0:
        os.kill(os.getpid(), signal.SIGKILL)
    while frequency == 140.0 and not _has_died_twice(folder):
        time.sleep(0.01)
    return {"one": 1.0}


def _has_died_twice(folder: Path) -> bool:
    """Return whether the run at 150 rad/s has been made twice, the first time with the process that is gone since."""
    return (folder / "150").exists() and (folder / "150").read_text().count("made") == 2


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
        "from tests.ensemble_cases import *\n"
        "from floquetrod.ensembles import stores\n"
        "stores._SECONDS_BETWEEN = 0.02\n"
        "if __name__ == '__main__':\n"
    )
    text = start + "".join(f"    {line}\n" for line in body.strip().splitlines())
    return subprocess.Popen(
        [sys.executable, "-c", text, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        text=True,
        **options,
    )


def killed_again_and_again(place: Path, times: int, seed: int, how: str) -> int:
    """Kill a process that fills a store so many times, at random moments; return the runs it had then."""
    import xarray  # which processes that make runs do without

    rng = np.random.default_rng(seed)
    for _ in range(times):
        body = f"fr.ensemble(PROBLEM, {{**OVER, 'seed': range(SEEDS)}}, store=sys.argv[1], {how})"
        with script(body, place, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
            while not place.exists() and process.poll() is None:
                time.sleep(0.01)
            time.sleep(float(rng.uniform(0.0, 0.6)))
            process.kill()
    return int((xarray.open_zarr(place).status == 1).sum())
