"""Ensembles on a cluster of Dask's and on processes of MPI, and twenty kills: too slow for every change."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import floquetrod as fr
from floquetrod.ensembles import tasks, varied_axes, workers
from tests.ensemble_cases import OVER, PROBLEM, ROOT, SEEDS, assert_same, killed_again_and_again

pytestmark = pytest.mark.slow

MANY = {"frequency": [120.0, 150.0], "kick": [0.01, 0.05, 0.1, 0.2], "seed": range(250)}


@pytest.fixture(scope="module")
def serial() -> Any:
    """Return 2,000 runs made one after another."""
    study = varied_axes.design_of(PROBLEM, MANY, "grid", None, 0)
    job = tasks.TaskSettings(PROBLEM, None, None, False)
    every = tasks.simulate_runs(job, [(run, study.values(run)) for run in range(study.size)])
    return {name: [outcome.results[name] for outcome in every] for name in every[0].results if name != "wall_time"}


def assert_as_serial(found: Any, serial: Any) -> None:
    assert (found.status == 1).all()
    assert found.sizes == {"frequency": 2, "kick": 4, "seed": 250}
    for name, values in serial.items():
        assert np.array_equal(found[name].values.ravel().astype(float), np.array(values, dtype=float), equal_nan=True)


@pytest.mark.filterwarnings(
    "ignore::DeprecationWarning", "ignore::ResourceWarning", "ignore::UserWarning"
)  # Dask's own
def test_two_thousand_runs_on_a_dask_cluster(serial: Any, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=str(tmp_path)
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        # What a lambda is to Dask: pickled by value.
        found = fr.ensemble(
            PROBLEM,
            MANY,
            executor=client,
            store=tmp_path / "runs.zarr",
            summary=lambda run: {"process": float(os.getpid())},
        )
        assert len(set(found.process.values.ravel().tolist()) - {float(os.getpid())}) == 2
    assert_as_serial(found, serial)
    assert_as_serial(xarray.open_zarr(tmp_path / "runs.zarr"), serial)


def test_two_thousand_runs_on_processes_of_mpi(serial: Any, tmp_path: Path) -> None:
    pytest.importorskip("mpi4py")
    mpiexec = shutil.which("mpiexec", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))
    assert mpiexec is not None
    study = tmp_path / "study.py"
    study.write_text(
        "import os, sys\n"
        "import floquetrod as fr\n"
        "from tests.ensemble_cases import PROBLEM\n"
        "from tests.ensembles.test_ensemble_slow import MANY, process\n"
        "from mpi4py.futures import MPIPoolExecutor\n"
        "if __name__ == '__main__':\n"
        "    with MPIPoolExecutor() as pool:\n"
        "        found = fr.ensemble(PROBLEM, MANY, executor=pool, store=sys.argv[1], summary=process)\n"
        "    others = set(found.process.values.ravel().tolist()) - {float(os.getpid())}\n"
        "    print(len(others))\n"
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [mpiexec, "-n", "3", sys.executable, "-m", "mpi4py.futures", str(study), str(tmp_path / "runs.zarr")]
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["2"]
    assert_as_serial(xarray.open_zarr(tmp_path / "runs.zarr"), serial)


def process(run: fr.Simulation) -> dict[str, float]:
    """Return the process that made a run, as a summary."""
    return {"process": float(os.getpid())}


@pytest.mark.parametrize("how", ["", "workers=2"])
def test_twenty_kills_of_the_parent_lose_and_repeat_nothing(how: str, tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    had, made = killed_again_and_again(place, 20, 7, how), []
    over = {**OVER, "seed": range(SEEDS)}
    found = fr.ensemble(PROBLEM, over, store=place, progress=lambda done, total: made.append(done))
    assert len(made) == 6 * SEEDS - had
    assert_same(found, fr.ensemble(PROBLEM, over))


def test_twenty_kills_of_workers_lose_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pids: list[int] = []
    started, rng = workers._Pool.started, np.random.default_rng(11)
    kills = set(rng.choice(np.arange(20, 6 * SEEDS - 20), 20, replace=False).tolist())

    def noted(alive: Any) -> Any:
        pool = started(alive)
        pool.begun.add_done_callback(lambda pid: pids.append(pid.result()))
        return pool

    def kill(done: int, total: int) -> None:
        if done in kills:
            alive = [pid for pid in pids if _is_alive(pid)]
            if alive:
                os.kill(int(rng.choice(alive)), signal.SIGKILL)
                kills.discard(done)

    monkeypatch.setattr(workers._Pool, "started", noted)
    over = {**OVER, "seed": range(SEEDS)}
    seen: list[int] = []
    found = fr.ensemble(
        PROBLEM,
        over,
        workers=2,
        store=tmp_path / "runs.zarr",
        progress=lambda done, total: (kill(done, total), seen.append(done))[0],
    )
    assert seen == list(range(1, 6 * SEEDS + 1))
    assert_same(found, fr.ensemble(PROBLEM, over))
    assert len(kills) < 10


def _is_alive(pid: int) -> bool:
    """Return whether a process lives, and has not merely not been waited for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
