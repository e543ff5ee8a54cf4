"""A process that runs simulations in children, which it kills or starves of disk; see `test_simulation_losses`.

    python nursery.py kills FOLDER COUNT SEED
    python nursery.py disks FOLDER COUNT SEED

It prints a line of JSON.  A process of its own, because it forks, with the kernels already compiled.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import floquetrod as fr
from floquetrod.simulation import checkpoints, integration

ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)
PROBLEM = fr.SimulationProblem(ROD, LOAD, duration=0.3, friction=0.1, segments=60, frames=31)


def run(checkpoint: Path | None = None, progress: Callable[[int, int], None] | None = None) -> fr.Simulation:
    return PROBLEM.run(progress, checkpoint)


def digest(result: fr.Simulation) -> str:
    """Return what tells every bit of a finished run."""
    assert result.complete
    arrays = [result.time, result.positions, result.velocities, *result.energy.values()]
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def child(work: Callable[[], object]) -> int:
    """Start ``work`` in a child; its exit status tells whether it came to its end."""
    if (pid := os.fork()) == 0:
        status = 1
        try:
            work()
            status = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(status)
    return pid


def ended_well(pid: int) -> bool:
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0


def kills(folder: Path, count: int, chance: random.Random) -> dict[str, Any]:
    """Kill runs that save after every few steps; each is resumed by the next, and by one that is left in peace."""
    expected = digest(run())
    checkpoints._SECONDS_BETWEEN, integration._LEAST_STEPS, integration._ELEMENT_STEPS = 0.0, 50, 0
    path, copy = folder / "run.ckpt", folder / "copy.ckpt"
    killed = torn = resumed = wrong = 0
    while killed < count:
        pid = child(lambda: run(path))
        time.sleep(chance.uniform(0.0, 0.1))
        os.kill(pid, signal.SIGKILL)
        if os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) != -signal.SIGKILL:  # it had come to its end
            path.unlink(missing_ok=True)
            continue
        killed += 1
        torn += any(part.suffix == ".part" for part in folder.iterdir())
        resumed += path.exists()
        if path.exists():
            copy.write_bytes(path.read_bytes())
        wrong += not ended_well(child(lambda: check(copy, expected)))
        copy.unlink(missing_ok=True)
    checkpoints._SECONDS_BETWEEN = 5.0
    finished = digest(run(path)) == expected
    return {
        "killed": killed,
        "torn": torn,  # killed in the middle of a save
        "resumed": resumed,
        "wrong": wrong,
        "finished": finished,
        "left": sorted(part.name for part in folder.iterdir()),
    }


def check(path: Path, expected: str) -> None:
    checkpoints._SECONDS_BETWEEN = 5.0  # of this child
    assert digest(run(path)) == expected


def disks(folder: Path, count: int, chance: random.Random) -> dict[str, Any]:
    """Let the disk fill up at a random place of a random save, for good or for a while."""
    whole = run(folder / "whole.ckpt")
    expected, size = digest(whole), (folder / "whole.ckpt").stat().st_size
    (folder / "whole.ckpt").unlink()
    checkpoints._SECONDS_BETWEEN, integration._LEAST_STEPS, integration._ELEMENT_STEPS = 0.0, 500, 0
    path = folder / "run.ckpt"
    warned = wrong = stale = recovered = 0
    for turn in range(count):
        path.unlink(missing_ok=True)
        limit(chance.randrange(size))  # of the bytes in a file: beyond it every write fails
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            progress = None if turn % 2 else relieve(after=chance.randrange(10, 40))
            result = run(path, progress)
        limit(resource.RLIM_INFINITY)
        warned += any(issubclass(warning.category, fr.CheckpointWarning) for warning in caught)
        wrong += digest(result) != expected
        last = caught[-1].message if caught else None
        stale += isinstance(last, fr.CheckpointWarning) and last.simulation is result
        recovered += path.exists() and digest(run(path)) == expected
    return {
        "disks": count,
        "warned": warned,
        "wrong": wrong,
        "stale": stale,  # of which the last save failed, too
        "recovered": recovered,  # of which a checkpoint can be resumed to the same bits
        "left": sorted(part.name for part in folder.iterdir()),
    }


def limit(size: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))


def relieve(after: int) -> Callable[[int, int], None]:
    """Return progress that makes room on the disk after so many calls."""
    calls = iter(range(after, -1, -1))

    def progress(done: int, total: int) -> None:
        if next(calls, 1) == 0:
            limit(resource.RLIM_INFINITY)

    return progress


if __name__ == "__main__":
    what, folder, count, seed = sys.argv[1:]
    found = {"kills": kills, "disks": disks}[what](Path(folder), int(count), random.Random(int(seed)))
    sys.stdout.write(json.dumps(found))
