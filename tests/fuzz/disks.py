"""Full disks: the result comes back, a warning says what happened, and the old file is whole."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import floquetrod as fr
from tests.fuzz import apart, runs
from tests.fuzz.core import Found

CASES = 40
QUICK = 4

PLACES = ("fsync", "replace", "rename", "fdopen", "write", "open")
"""Functions of os that a disk may fail in."""


def check(rng: np.random.Generator) -> Found:
    """Let the disk fail under a run with checkpoints, an ensemble, a chart or the output of a command."""
    what = rng.random()
    if what < 0.05:
        return Found(1, _terminal())
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        fails, how = _failing(rng)
        if what < 0.4:
            wrong = run(Path(name), fails)
        elif what < 0.7:
            place = Path(name) / str(rng.choice(["runs.npz", "runs.zarr"]))
            frames, begin = bool(rng.random() < 0.5), int(rng.integers(0, 20))
            how = f"{place.suffix} store{' with frames' * frames}, after {begin} runs {how}"
            wrong = ensemble(place, frames, begin, fails)
        else:
            wrong = _chart(Path(name), fails)
    return Found(1, [f"{how}: {line}" for line in wrong])


def _failing(rng: np.random.Generator) -> tuple[Callable[[], None], str]:
    """Return a function that makes disks of this process fail, and its description."""
    if rng.random() < 0.5:
        size = int(2 ** rng.uniform(6.0, 15.0))
        return lambda: limit_files(size), f"files of at most {size} bytes"
    place, share = str(rng.choice(PLACES)), float(rng.choice([0.3, 1.0]))
    seed = int(rng.integers(2**31))
    return lambda: break_os(place, share, np.random.default_rng(seed)), f"os.{place} fails {share:.0%} of the time"


def limit_files(size: int) -> None:
    """Let this process write no file beyond so many bytes, and no bytecode, which Python leaves cut off there."""
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def break_os(place: str, share: float, rng: np.random.Generator) -> None:
    """Let a function of os raise "no space left on device" at random, in this process and for good."""
    works = getattr(os, place)

    def fails(*arguments: Any, **options: Any) -> Any:
        if rng.random() < share:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return works(*arguments, **options)

    setattr(os, place, fails)


def run(place: Path, fails: Callable[[], None]) -> list[str]:
    """Run with a checkpoint on a disk that fails from the start, or once there is a first checkpoint.

    A disk that takes no file at all is refused before anything is computed: nothing is lost then.
    """
    checkpoint = place / "run.ckpt"
    expected = runs.reference()

    def work() -> tuple[list[str], int]:
        fails()
        begun: list[int] = []
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            try:
                found = runs.simulate(checkpoint, progress=lambda done, _: begun.append(done))
            except ValueError as error:
                if "cannot be written" in str(error) and not begun:
                    return [], 1
                raise
        return runs.differences(expected, found), len(heard)

    done, answer = apart.answer(work)
    if not done:
        return [f"the result of a run is lost: {answer}"]
    different, heard = answer
    wrong = [f"the result has another {', '.join(different)}"] if different else []
    if not heard and not checkpoint.exists():
        wrong.append("no warning that nothing was saved")
    if checkpoint.exists():
        different = runs.differences(expected, runs.simulate(checkpoint))
        wrong += [f"the checkpoint goes on to another {', '.join(different)}"] if different else []
    left = runs.strays(place)
    return wrong + ([f"leaves {', '.join(left)}"] if left else [])


def ensemble(place: Path, frames: bool, begin: int, fails: Callable[[], None]) -> list[str]:
    """Make an ensemble on a disk that fails after some runs; afterwards, go on where there is room."""
    expected = runs.filled(frames)

    def work() -> tuple[list[str], list[str]]:
        begun: list[int] = []

        def progress(done: int, total: int) -> None:
            begun.append(done)
            if done == begin:
                fails()

        if not begin:
            fails()
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            try:
                found = runs.fill(place, frames, progress)
            except ValueError as error:
                if "cannot be written" in str(error) and not begun:
                    return [], []
                raise
        return runs.differing(expected, found), [str(warning.message) for warning in heard]

    done, answer = apart.answer(work)
    if not done:
        return [f"the results of an ensemble are lost: {answer}"]
    different, heard = answer
    wrong = [f"the results have another {', '.join(different)}"] if different else []
    for text in ("cannot be written", "cannot be locked"):
        if (count := sum(text in line for line in heard)) > 1:
            wrong.append(f"warns {count} times that the store {text}")
    done, answer = apart.answer(lambda: runs.fill(place, frames))
    if not done:
        return [*wrong, f"the store does not go on: {answer}"]
    if different := runs.differing(expected, answer):
        wrong.append(f"the store goes on to another {', '.join(different)}")
    left = runs.strays(place.parent)
    return wrong + ([f"leaves {', '.join(left)}"] if left else [])


def _chart(place: Path, fails: Callable[[], None]) -> list[str]:
    """Save a chart over an older one on a disk that fails: an OSError, and one of the two whole."""
    path = place / "chart.npz"
    older, newer = (fr.mathieu.chart((0.0, top, 30), (-1.0, 0.0, 20), growth=True) for top in (1.0, 2.0))
    older.save(path)

    def work() -> bool:
        fails()
        try:
            newer.save(path)
        except OSError:
            return False
        return True

    done, saved = apart.answer(work)
    if not done:
        return [f"saving a chart raises something else than OSError: {saved}"]
    different = runs.differences(newer if saved else older, fr.Chart.load(path))
    wrong = [f"the file holds another {', '.join(different)}"] if different else []
    left = runs.strays(place)
    return wrong + ([f"leaves {', '.join(left)}"] if left else [])


def _terminal() -> list[str]:
    """Answer to a full disk: an error on one line, and no status of success."""
    command = [sys.executable, "-m", "floquetrod", "compare", "--alpha", "0.5", "--beta", "-0.3"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    ok = done.returncode == 2 and done.stderr.count("\n") == 1 and "Traceback" not in done.stderr
    return [] if ok else [f"output to a full disk: status {done.returncode}, {done.stderr!r}"]
