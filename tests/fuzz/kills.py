"""Runs killed at any moment, saves included: what is saved goes on to the bit, and nothing is left lying about."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from floquetrod.ensembles import Runs
from tests.fuzz import apart, runs
from tests.fuzz.core import Found, told

CASES = 40
QUICK = 3

_LATEST = 0.25  # seconds: longer than a run takes


def check(rng: np.random.Generator) -> Found:
    """Kill runs with checkpoints, one of them or two of one file, or processes that fill the store of an ensemble."""
    what = rng.random()
    return checkpoint(rng) if what < 0.4 else _shared_checkpoint(rng) if what < 0.6 else _store(rng)


def _shared_checkpoint(rng: np.random.Generator) -> Found:
    """Simulate with one checkpoint in two processes of which one is stopped, goes on and is killed."""
    moments = rng.uniform(0.0, _LATEST, 3).tolist()
    expected = runs.reference()
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        path = Path(name) / "run.ckpt"
        wrong = stopped_and_killed(lambda: runs.simulate(path), "is in use by another", lambda: _frames(path), moments)
        done, found = apart.answer(lambda: runs.simulate(path))
        if not done:
            wrong.append(f"does not go on: {found}")
        elif different := runs.differences(expected, found):
            wrong.append(f"goes on to another {', '.join(different)}")
    return Found(3, [f"a shared checkpoint, at {moments} s: {line}" for line in wrong])


def _frames(path: Path) -> int:
    """Return how many frames a checkpoint holds."""
    if not path.exists():
        return 0
    with np.load(path) as held:
        return len(held["positions"])


def _store(rng: np.random.Generator) -> Found:
    """Fill a store from two processes of which one is stopped, goes on and is killed: no run is lost."""
    kind, moments = str(rng.choice(["runs.npz", "runs.zarr"])), rng.uniform(0.0, _LATEST, 3).tolist()
    runs.filled(False)
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        place = Path(name) / kind
        wrong = stopped_and_killed(
            lambda: runs.fill(place), "is being filled by another process", lambda: _count(place), moments
        )
        done, found = apart.answer(lambda: runs.fill(place))
        if not done:
            wrong.append(f"does not go on: {found}")
        elif different := runs.differing(runs.filled(False), found):
            wrong.append(f"goes on to another {', '.join(different)}")
    return Found(3, [f"{kind}, at {moments} s: {line}" for line in wrong])


def stopped_and_killed(work: Callable[[], Any], busy: str, count: Callable[[], int], moments: list[float]) -> list[str]:
    """Return what is wrong about a file that one process writes while another that began to is stopped.

    ``busy`` is what the second is refused with, ``count`` how much the file holds.
    """
    process, pipe = apart.start(work)
    time.sleep(moments[0])
    os.kill(process, signal.SIGSTOP)
    done, found = apart.answer(work)
    wrong = [] if done or busy in found else [f"a second process: {found}"]
    before = count()
    os.kill(process, signal.SIGCONT)
    time.sleep(moments[1])
    os.kill(process, signal.SIGKILL)
    apart.finish(process, pipe)
    apart.kill_after(work, moments[2])
    after = count()
    return wrong if after >= before else [*wrong, f"of {before} {after} are left"]


def _count(place: Path) -> int:
    """Return how many runs a store holds."""

    def count() -> int:
        found = Runs.load(place) if place.suffix == ".npz" else xarray.open_zarr(place)
        return int(np.sum(np.asarray(found["status"]) == 1))

    if not place.exists():
        return 0
    done, found = apart.answer(count)
    return int(found) if done else -1


def checkpoint(rng: np.random.Generator) -> Found:
    """Kill a run up to three times, go on from what is there, and compare with the run that nothing disturbed."""
    expected = runs.reference()
    failures = []
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        path = Path(name) / "run.ckpt"
        moments = [float(rng.uniform(0.0, _LATEST)) for _ in range(int(rng.integers(1, 4)))]
        for moment in moments:
            apart.kill_after(lambda: runs.simulate(path), moment)
        try:
            different = runs.differences(expected, runs.simulate(path))
            if different:
                failures.append(f"goes on to another {', '.join(different)}")
        except Exception as error:
            failures.append(f"does not go on: {told(error)}")
        left = runs.strays(Path(name))
        if left:
            failures.append(f"leaves {', '.join(left)}")
    return Found(len(moments), [f"killed after {moments} s: {line}" for line in failures])
