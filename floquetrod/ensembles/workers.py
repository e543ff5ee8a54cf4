"""Where the runs of an ensemble are made: on any executor of `concurrent.futures`, by default on threads."""

from __future__ import annotations

import math
import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from floquetrod._util import interrupt, validate
from floquetrod._util.compilation import cores
from floquetrod.ensembles.stores import DIED, RunResult
from floquetrod.ensembles.tasks import Batch, TaskSettings, simulate_runs
from floquetrod.ensembles.variables import FAILED

_TASK = 0.25  # s of runs in a task, beside which the milliseconds of handing it over do not count
_MOST_IN_A_TASK = 256  # runs, so that progress is heard of where they take no time
_UNKNOWN_SIZE = 512  # tasks under way on an executor that does not tell how many workers it has
_POLL = 0.1  # s between checks for Ctrl-C: at once, to a person
_DEATHS = 3  # of workers, after which the run they died in has failed: one or two may be killed for memory others took
_STARTS = 3  # of workers that end before they have begun, one after another, until no more are started


class TaskRunner:
    """Takes tasks, as many at a time as there is `room` for, and hands them to an executor."""

    replaced = 0
    """How many processes have died and were replaced here."""

    def __init__(self, executor: Executor | None) -> None:
        """Take tasks for the caller's executor, or for threads of its own, as many as there are processors."""
        self.executor = ThreadPoolExecutor(cores()) if executor is None else executor
        self._is_own = executor is None
        self._stop = threading.Event()
        self._same_process = isinstance(self.executor, ThreadPoolExecutor)
        self._pickles_by_value = not (isinstance(executor, ProcessPoolExecutor) or _is_of(executor, "mpi4py"))
        self._room, self._counted = 0, -math.inf

    @property
    def room(self) -> int:
        """Return how many tasks to hand over, two for every worker and two more, checked again every second."""
        if time.monotonic() - self._counted > 1.0:
            count = _size_of(self.executor)
            self._room, self._counted = _UNKNOWN_SIZE if count is None else 2 * count + 2, time.monotonic()
        return self._room

    def submit(self, job: TaskSettings, batch: Batch) -> Future[list[RunResult]]:
        """Hand over a task."""
        progress = (self._end_when_stopped,) if self._same_process else ()
        task = self.executor.submit(simulate_runs, job, batch, *progress)
        if not isinstance(task, Future):
            raise TypeError(f"its submit must return a Future of concurrent.futures, got {validate.short(task)}")
        return task

    def has_died(self, error: BaseException | None) -> bool:
        """Return whether the error of a task means that its worker has died, and others live on."""
        return type(error).__name__ == "KilledWorker"  # of dask.distributed

    def has_begun(self, task: Future[Any]) -> bool:
        """Return whether the worker of a task that has ended had started."""
        return True

    def stop(self) -> None:
        """Abandon the runs in progress."""
        self._stop.set()

    def close(self) -> None:
        """End the executor started here."""
        if self._is_own:
            self.executor.shutdown(cancel_futures=True)

    def require_picklable(self, job: TaskSettings) -> None:
        """Raise TypeError, with a remedy, where tasks cannot be sent to other processes."""
        if self._same_process:
            return
        try:
            pickle.dumps(job)
        except Exception as error:  # pickle raises many kinds
            if self._pickles_by_value:
                with suppress(Exception):
                    import cloudpickle

                    cloudpickle.dumps(job)
                    return
            raise TypeError(
                f"summary must be picklable to reach other processes, got {validate.short(job.summary)} ({error}); "
                "define it at the top level of a module, or run in threads"
            ) from None

    def _end_when_stopped(self, done: int, total: int) -> None:
        """End a run in a thread once it is to be abandoned."""
        if self._stop.is_set():
            raise KeyboardInterrupt  # which ends a run as Ctrl-C would in the main thread


def _is_of(executor: Executor | None, package: str) -> bool:
    """Return whether an executor is one of a package."""
    return type(executor).__module__.partition(".")[0] == package


def _size_of(executor: Any) -> int | None:
    """Return how many workers an executor has, None where it does not tell."""
    with suppress(Exception):  # a cluster that has gone: the next task tells
        if _is_of(executor, "distributed"):
            return int(sum(executor._client.nthreads().values()))
        count = executor.num_workers if _is_of(executor, "mpi4py") else executor._max_workers
        return validate.integer("workers", count, 0)
    return None


class OwnProcesses(TaskRunner):
    """Processes of its own, which end with this one however it ends.

    Each is a pool by itself, as the death of one process breaks its pool and ends what every other one of it is doing:
    test_ensemble_workers.py::test_a_worker_that_dies_costs_the_others_nothing.
    """

    def __init__(self, workers: int) -> None:
        """Start each when it has a task."""
        self._alive, self._lifeline = _CONTEXT.Pipe(duplex=False)
        self._pools: list[_Pool] = []
        self._tasks: list[Future[Any]] = []  # the latest of each
        self._workers, self._failed_starts = workers, 0
        self._same_process = self._pickles_by_value = False

    @property
    def room(self) -> int:
        """Return how many tasks to hand over, one for every process, so that its death costs one task."""
        return self._workers

    def submit(self, job: TaskSettings, batch: Batch) -> Future[list[RunResult]]:
        """Hand a task to a process that has none, or to a new one, also in the place of one that has died."""
        place = next((place for place, task in enumerate(self._tasks) if task.done()), len(self._pools))
        if place == len(self._pools):
            self._pools.append(_Pool.started(self._alive))
            self._tasks.append(self._pools[place].begun)
        try:
            task = self._pools[place].executor.submit(simulate_runs, job, batch)
        except BrokenExecutor:
            self._replace(place)
            task = self._pools[place].executor.submit(simulate_runs, job, batch)
        self._tasks[place] = task
        return task

    def has_died(self, error: BaseException | None) -> bool:
        """Return whether the process of a task has died."""
        return isinstance(error, BrokenExecutor)

    def has_begun(self, task: Future[Any]) -> bool:
        """Return whether the process of a task had started when the task ended."""
        return self._pools[self._tasks.index(task)].has_begun

    def stop(self) -> None:
        """End the processes at once."""
        self._lifeline.close()

    def close(self) -> None:
        """End the processes."""
        for pool in self._pools:
            pool.executor.shutdown(cancel_futures=True)
        self._lifeline.close()
        self._alive.close()

    def _replace(self, place: int) -> None:
        """Start another process in the place of one that has died; RuntimeError where none ever begins."""
        self._failed_starts = 0 if self._pools[place].has_begun else self._failed_starts + 1
        if self._failed_starts >= _STARTS:
            raise NoWorkers(
                f"{_STARTS} worker processes one after another ended as soon as they started: in a script call "
                "fr.ensemble(workers=...) under 'if __name__ == \"__main__\":', which new processes import without "
                "running it; elsewhere check whether they are killed, or memory is short"
            )
        self._pools[place].executor.shutdown(wait=False)
        self._pools[place] = _Pool.started(self._alive)
        self.replaced += 1


_CONTEXT = multiprocessing.get_context("spawn")  # a fork would copy threads' locks in whatever state they are


class NoWorkers(RuntimeError):
    """New processes end before they have begun."""


class _Pool(NamedTuple):
    """A pool of one process, and the task that tells that it has begun."""

    executor: ProcessPoolExecutor
    begun: Future[int]

    @property
    def has_begun(self) -> bool:
        """Return whether its process has started."""
        return self.begun.done() and self.begun.exception() is None

    @classmethod
    def started(cls, alive: Connection) -> _Pool:
        """Return a pool whose process is starting, and ends when nobody has the other end of a pipe any more."""
        executor = ProcessPoolExecutor(1, _CONTEXT, _prepare, (alive,))
        return cls(executor, executor.submit(os.getpid))


def _prepare(alive: Connection) -> None:
    """Leave Ctrl-C to the parent, and end with it (test_ensemble_workers.py::test_processes_of_a_killed_parent_end)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(alive,), daemon=True).start()


def _end_with(alive: Connection) -> None:
    """End this process once its parent has closed the pipe, or has ended."""
    with suppress(EOFError, OSError):
        alive.recv()
    os._exit(1)


def require_executor(executor: Any, workers: Any) -> tuple[Executor | None, int | None]:
    """Return the executor and the number of own processes, None each for none; an error for what takes no tasks."""
    count = None if workers is None else validate.integer("workers", workers, 1, validate.MOST_THREADS)
    if executor is None:
        return None, count
    if hasattr(executor, "get_executor"):  # a Client of dask.distributed, whose own futures are of another kind
        executor = executor.get_executor()
    if not callable(getattr(executor, "submit", None)):
        raise validate.wrong_type(
            "executor",
            "must submit tasks as those of concurrent.futures do, ProcessPoolExecutor(8), say, "
            f"got {validate.short(executor)}",
        )
    if count is not None:
        raise validate.wrong_value(
            "workers", f"is a number of own processes, got {count} beside an executor; leave one of them out"
        )
    return executor, None


# --- the work ---


def work(
    runner: TaskRunner,
    job: TaskSettings,
    pending: Sequence[int],
    values: Callable[[int], Mapping[str, float]],
    idle: Callable[[], None],
) -> Generator[RunResult, None, None]:
    """Yield outcomes as they come, in any order; ends early, after abandoning the rest, on Ctrl-C.

    ``idle`` is called about ten times a second at least.  Raises RuntimeError when the executor breaks.
    """
    tasks: dict[Future[list[RunResult]], list[int]] = {}
    queue, alone, deaths = deque(pending), deque[int](), Counter[int]()
    sizes = _TaskSizes()
    broken: RuntimeError | None = None
    with interrupt.held() as deliver:
        try:
            while queue or alone or tasks:
                while broken is None and (queue or alone) and len(tasks) < runner.room:
                    runs = [alone.popleft()] if alone else sizes.take(queue, runner.room)
                    try:
                        tasks[runner.submit(job, [(run, values(run)) for run in runs])] = runs
                    except Exception as refusal:  # every executor has its own ways to break
                        broken = _broken(refusal)
                done, _ = wait(tasks, timeout=0.0 if broken else _POLL, return_when=FIRST_COMPLETED)
                deliver()
                for task in done:
                    runs, error = tasks.pop(task), _error(task)
                    if runner.has_died(error):
                        if len(runs) == 1 and runner.has_begun(task):
                            deaths[runs[0]] += 1
                        fatal = [run for run in runs if deaths[run] >= _DEATHS]
                        alone.extend(run for run in runs if run not in fatal)
                        for run in fatal:
                            yield RunResult(run, FAILED, f"{DIED} {_DEATHS} times: killed, or out of memory")
                    elif error is not None:
                        broken = _broken(error)
                    else:
                        results = task.result()
                        sizes.note(results)
                        yield from results
                        made = {outcome.run for outcome in results}
                        alone.extend(run for run in runs if run not in made)  # a worker was interrupted
                idle()
                if broken is not None:
                    raise broken
        finally:
            if tasks:
                runner.stop()
                for task in tasks:
                    task.cancel()


def _error(task: Future[Any]) -> BaseException | None:
    """Return what a task raised, its cancellation too."""
    try:
        return task.exception()
    except CancelledError as error:
        return error


def _broken(error: BaseException) -> RuntimeError:
    """Return the error for an executor that makes no more runs."""
    if isinstance(error, NoWorkers):
        return error
    cause = str(error) or type(error).__name__
    return RuntimeError(
        f"the executor has failed ({type(error).__name__}: {cause}); finished runs are kept: call fr.ensemble again "
        "with the same arguments, store and a new executor to continue"
    )


class _TaskSizes:
    """How many runs make a task: as many as take a quarter of a second, but leave some for every worker."""

    def __init__(self) -> None:
        self._seconds, self._runs = 0.0, 0

    def take(self, queue: deque[int], room: int) -> list[int]:
        """Take the runs of the next task."""
        count = 1
        if self._runs:
            mean = max(self._seconds / self._runs, _TASK / _MOST_IN_A_TASK)
            count = max(1, min(int(_TASK / mean), _MOST_IN_A_TASK, math.ceil(len(queue) / max(2 * room, 1))))
        return [queue.popleft() for _ in range(min(count, len(queue)))]

    def note(self, results: Sequence[RunResult]) -> None:
        """Learn from the wall time of runs."""
        self._seconds += sum(outcome.results.get("wall_time", 0.0) for outcome in results)
        self._runs += len(results)
