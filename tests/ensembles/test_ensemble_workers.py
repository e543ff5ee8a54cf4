"""Who makes the runs of an ensemble: bits, deaths of workers, broken executors, Ctrl-C, kills of the parent."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import floquetrod as fr
from floquetrod.ensembles import varied_axes, workers
from floquetrod.ensembles.stores import RunResult
from tests.ensemble_cases import (
    LOAD,
    OVER,
    PROBLEM,
    assert_same,
    depth,
    exits_at_150,
    script,
    undisturbed,
    waits_at_140_dies_at_150,
)
from tests.seams import Tuned

LONG = "PROBLEM.replace(duration=1000.0)"


@pytest.mark.parametrize("workers", [None, pytest.param(2, marks=pytest.mark.slow)])
def test_bits_do_not_depend_on_who_makes_the_runs(workers: int | None) -> None:
    serial = [varied_axes.varied(PROBLEM, dict(zip(OVER, run, strict=True))).run() for run in product(*OVER.values())]
    found = fr.ensemble(PROBLEM, OVER, workers=workers)
    assert found.largest_angle.values.ravel().tolist() == [run.largest_angle.max() for run in serial]
    assert found.energy_error.values.ravel().tolist() == [np.abs(run.energy_error).max() for run in serial]
    assert_same(fr.ensemble(PROBLEM, OVER, workers=workers, summary=depth), undisturbed(depth))


@pytest.mark.slow
def test_a_process_pool_that_is_given_is_not_shut_down() -> None:
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert_same(fr.ensemble(PROBLEM, OVER, executor=pool), undisturbed())
        assert pool.submit(int).result() == 0
        with pytest.raises(TypeError, match="summary must be picklable to reach other processes"):
            fr.ensemble(PROBLEM, OVER, executor=pool, summary=lambda run: {"a": 1.0})


@pytest.mark.slow
def test_a_worker_that_dies_costs_the_others_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    """It is replaced, a run that kills its workers has failed, and a run in progress meanwhile is made once."""
    tuned(deaths_of_workers_in_a_run=2)
    monkeypatch.setenv("ENSEMBLE_CASES", str(tmp_path))
    over = {"frequency": [120.0, 140.0, 150.0]}
    found = fr.ensemble(PROBLEM, over, summary=waits_at_140_dies_at_150, workers=2)
    assert found.status.values.tolist() == [1, 1, 2]
    assert str(found.reason.values[2]) == "its worker process died 2 times: killed, or out of memory"
    made = [(tmp_path / f"{frequency:g}").read_text().count("made") for frequency in over["frequency"]]
    assert made == [1, 1, 2]
    assert (
        found.largest_angle.values[1] == PROBLEM.replace(load=replace(LOAD, frequency=140.0)).run().largest_angle.max()
    )


@pytest.mark.slow
def test_workers_that_are_killed_while_idle_or_busy_are_replaced() -> None:
    pids: list[int] = []
    started = workers._Pool.started

    def noted(alive: Any) -> Any:
        pool = started(alive)
        pool.begun.add_done_callback(lambda pid: pids.append(pid.result()))
        return pool

    def kill(done: int, total: int) -> None:
        if done in (4, 8):
            with suppress(ProcessLookupError):  # it has been killed, and the next one has not started
                os.kill(pids[-1], signal.SIGKILL)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(workers._Pool, "started", noted)
        found = fr.ensemble(PROBLEM, OVER, workers=2, progress=kill)
    assert_same(found, undisturbed())
    assert len(pids) > 2


@pytest.mark.slow
@pytest.mark.parametrize("which", [0, 1])
def test_workers_that_are_killed_while_they_start_are_replaced(
    which: int, monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    started, pools = workers._Pool.started, []

    def killed(alive: Any) -> Any:
        pools.append(started(alive))
        if len(pools) - 1 == which:
            for process in pools[-1].executor._processes.values():
                process.kill()
        return pools[-1]

    monkeypatch.setattr(workers._Pool, "started", killed)
    tuned(deaths_of_workers_in_a_run=1)
    told = r"^1 worker process ended and was replaced, killed or out of memory; no finished run was lost$"
    with pytest.warns(RuntimeWarning, match=told):
        found = fr.ensemble(PROBLEM, OVER, workers=2)
    assert_same(found, undisturbed())
    assert len(pools) == 3


@pytest.mark.slow
def test_workers_that_never_start_end_the_ensemble(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    started, pools = workers._Pool.started, []

    def killed(alive: Any) -> Any:
        pools.append(started(alive))
        if len(pools) > 1:
            for process in pools[-1].executor._processes.values():
                process.kill()
        return pools[-1]

    def kill(done: int, total: int) -> None:
        os.kill(pools[0].begun.result(), signal.SIGKILL)

    monkeypatch.setattr(workers._Pool, "started", killed)
    over = {"frequency": [120.0, 140.0, 150.0]}
    with pytest.raises(RuntimeError, match="3 worker processes one after another ended as soon as they started"):
        fr.ensemble(PROBLEM, over, workers=1, store=tmp_path / "runs.npz", progress=kill)
    found = fr.ensembles.Runs.load(tmp_path / "runs.npz")
    assert (found["status"] == 1).any()
    assert not (found["status"] == 2).any()


@pytest.mark.parametrize("options", [{}, pytest.param({"workers": 1}, marks=pytest.mark.slow)])
def test_a_summary_that_exits_fails_its_run_alone(options: dict[str, Any]) -> None:
    over = {"frequency": [120.0, 150.0, 160.0]}
    found = fr.ensemble(PROBLEM, over, summary=exits_at_150, **options)
    assert found.status.values.tolist() == [1, 2, 1]
    assert found.reason.values[1] == "SystemExit: 3"
    with pytest.raises(ValueError, match="for that with frequency = 150 it raised SystemExit: 3"):
        fr.ensemble(PROBLEM, {"frequency": [150.0]}, summary=exits_at_150, **options)


class Breaking(Executor):
    """An executor that breaks after a number of tasks, in one of its ways."""

    def __init__(self, after: int, way: str) -> None:
        """Note how."""
        self.left, self.way = after, way

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do the task at once."""
        task: Future[Any] = Future()
        self.left -= 1
        if self.left >= 0:
            task.set_result(fn(*args, **kwargs))
        elif self.way == "submit":
            raise RuntimeError("cannot schedule new futures after shutdown")
        elif self.way == "cancelled":
            task.cancel()
            task.set_running_or_notify_cancel()
        else:
            task.set_exception({"broken": BrokenExecutor("gone"), "other": OSError("lost")}[self.way])
        return task


@pytest.mark.slow
@pytest.mark.parametrize(
    "way", ["submit", "broken", *(pytest.param(way, marks=pytest.mark.slow) for way in ("cancelled", "other"))]
)
def test_what_came_before_an_executor_broke_is_kept(way: str, tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    with pytest.raises(RuntimeError, match=r"executor has failed .*finished runs are kept: call fr\.ensemble again"):
        fr.ensemble(PROBLEM, OVER, executor=Breaking(5, way), store=place)
    assert (xarray.open_zarr(place).status == 1).sum() > 0
    assert_same(fr.ensemble(PROBLEM, OVER, store=place), undisturbed())


def test_a_task_whose_worker_of_dask_was_killed_is_tried_alone() -> None:
    class KilledWorker(Exception):
        pass

    class Lossy(Executor):
        def submit(self, fn: Any, /, job: Any, batch: Any) -> Future[Any]:
            task: Future[Any] = Future()
            if any(values["seed"] == 3 for _, values in batch):
                task.set_exception(KilledWorker())
            else:
                task.set_result(fn(job, batch))
            return task

    found = fr.ensemble(PROBLEM, OVER, executor=Lossy())
    assert ((found.status == 2).values == (found.seed == 3).values).all()


def test_a_worker_that_was_interrupted_makes_its_runs_again() -> None:
    class Interrupted(ThreadPoolExecutor):
        calls = 0

        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
            self.calls += 1
            if self.calls % 3 == 0:
                task: Future[list[RunResult]] = Future()
                task.set_result([])
                return task
            return super().submit(fn, *args, **kwargs)

    with Interrupted(1) as pool:
        assert_same(fr.ensemble(PROBLEM, OVER, executor=pool), undisturbed())


@pytest.mark.slow
def test_what_submits_tasks_is_an_executor() -> None:
    """Of a Dask client its own executor, as the client's futures are not those of the standard library."""

    class Submits:
        def __init__(self, answer: Any) -> None:
            self.answer = answer

        def submit(self, fn: Any, /, *args: Any) -> Any:
            return self.answer(fn(*args))

    class Client(Submits):
        def get_executor(self) -> Submits:
            return Submits(done)

    def done(result: Any) -> Future[Any]:
        task: Future[Any] = Future()
        task.set_result(result)
        return task

    assert_same(fr.ensemble(PROBLEM, OVER, executor=Submits(done)), undisturbed())
    assert_same(fr.ensemble(PROBLEM, OVER, executor=Client(list)), undisturbed())
    with pytest.raises(RuntimeError, match="submit must return a Future of concurrent"):
        fr.ensemble(PROBLEM, OVER, executor=Submits(list))


def test_few_tasks_are_under_way_at_a_time() -> None:
    class Counted(ThreadPoolExecutor):
        most, now = 0, 0

        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
            self.now += 1
            self.most = max(self.most, self.now)
            task = super().submit(fn, *args, **kwargs)
            task.add_done_callback(lambda _: self.end())
            return task

        def end(self) -> None:
            self.now -= 1

    with Counted(2) as pool:
        fr.ensemble(PROBLEM, OVER, executor=pool)
    assert pool.most <= 6


def test_an_error_of_progress_ends_the_runs(tmp_path: Path) -> None:
    def wrong(done: int, total: int) -> None:
        if done == 7:
            raise ZeroDivisionError

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(ZeroDivisionError):
        fr.ensemble(PROBLEM, OVER, store=tmp_path / "runs.npz", progress=wrong)
    assert signal.getsignal(signal.SIGINT) is before
    assert (fr.ensembles.Runs.load(tmp_path / "runs.npz")["status"] == 1).sum() >= 7


@pytest.mark.slow
@pytest.mark.parametrize("how", ["", pytest.param("workers=2,", marks=pytest.mark.slow)])
def test_ctrl_c_returns_what_came_at_once(how: str, tmp_path: Path) -> None:
    body = f"""
found = fr.ensemble(
    {LONG}, {{"duration": [0.01, 0.02, 1000.0, 2000.0]}}, {how} store=sys.argv[1],
    progress=lambda done, total: print(done, flush=True),
)
print(found.status.values.tolist(), flush=True)
"""
    with script(body, tmp_path / "runs.zarr", stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert [process.stdout.readline() for _ in range(2)] == ["1\n", "2\n"]
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        assert process.stdout.read() == "[1, 1, 0, 0]\n"
        assert process.stderr.read() == ""
    assert process.returncode == 0
    assert xarray.open_zarr(tmp_path / "runs.zarr").status.values.tolist() == [1, 1, 0, 0]


@pytest.mark.slow
def test_processes_of_a_killed_parent_end() -> None:
    body = f"""
from floquetrod.ensembles import workers
def tell(pool):
    print(pool.begun.result(), flush=True)
    return pool
start = workers._Pool.started
workers._Pool.started = lambda alive: tell(start(alive))
fr.ensemble({LONG}, {{"duration": [1000.0, 2000.0]}}, workers=1)
"""
    with script(body, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        worker = int(process.stdout.readline())
        time.sleep(0.3)
        process.kill()
        process.stdout.read()  # open until the last process has ended
    while Path(f"/proc/{worker}").exists():
        time.sleep(0.05)


@pytest.mark.slow
def test_a_script_without_a_guard_is_told_of_it(tmp_path: Path) -> None:
    file = tmp_path / "study.py"
    file.write_text(
        "from tests.ensemble_cases import PROBLEM\nimport floquetrod as fr\n"
        "fr.ensemble(PROBLEM, {'friction': [0.1]}, workers=1)\n"
    )
    here = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, file], env=here, capture_output=True, text=True, timeout=600)
    assert done.returncode == 1
    assert "under 'if __name__ == \"__main__\":'" in done.stderr
