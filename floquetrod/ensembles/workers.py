"""Where the runs of an ensemble are made: threads, own processes, or any executor of `concurrent.futures`."""

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
from typing import Any, NamedTuple

from floquetrod._util import interrupt, validate
from floquetrod._util.compilation import cores
from floquetrod.ensembles.runs import FAILED
from floquetrod.ensembles.stores import DIED, Outcome
from floquetrod.ensembles.tasks import Job, Piece, carry_out

_TASK = 0.25  # s of work in a task, so that handing it over costs little (a choice)
_MOST_IN_A_TASK = 256  # runs (a choice)
_WINDOW = 512  # tasks handed to an executor whose size is unknown (a choice: more than any has workers, few in memory)
_HEARD_WITHIN = 0.1  # s between checks for Ctrl-C (a choice)
_DEATHS = 3  # of workers, after which the run they died in is recorded as failed (a choice)
_STARTS = 3  # of workers that end before they have begun, one after another, until no more are started (a choice)


class TaskRunner:
    """Takes tasks, as many at a time as there is `room` for; the base hands them to an executor of the caller's."""

    def __init__(self, executor: Executor) -> None:
        """Take tasks for an executor."""
        self.executor = executor
        self._stop = threading.Event()
        self._same_process = isinstance(executor, ThreadPoolExecutor)
        self._room, self._counted = 0, -math.inf

    @property
    def room(self) -> int:
        """Return how many tasks to hand over, two for every worker and two more, checked again every second."""
        if time.monotonic() - self._counted > 1.0:
            count = _size_of(self.executor)
            self._room, self._counted = _WINDOW if count is None else 2 * count + 2, time.monotonic()
        return self._room

    def submit(self, job: Job, piece: Piece) -> Future[list[Outcome]]:
        """Hand over a task."""
        if self._same_process:
            return self.executor.submit(carry_out, job, piece, self._end_when_stopped)
        return self.executor.submit(carry_out, job, piece)

    def has_begun(self, task: Future[Any]) -> bool:
        """Return whether the worker of a task that has ended had started."""
        return True

    def has_died(self, task: Future[Any], error: BaseException | None) -> bool:
        """Note the end of a task; return whether its error means that its worker has died, and others live on."""
        return type(error).__name__ == "KilledWorker"  # of dask.distributed

    def stop(self) -> None:
        """Abandon the runs in progress."""
        self._stop.set()

    def close(self) -> None:
        """End what has been started here."""

    def require_picklable(self, job: Job) -> None:
        """Raise TypeError, with a remedy, where tasks cannot be sent to other processes."""
        if self._same_process:
            return
        try:
            pickle.dumps(job)
        except Exception as error:  # pickle raises many kinds
            if not (isinstance(self.executor, ProcessPoolExecutor) or _is_of(self.executor, "mpi4py")):
                with suppress(Exception):  # of executors that pickle functions by value
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


def _is_of(executor: Executor, package: str) -> bool:
    """Return whether an executor is one of a package."""
    return type(executor).__module__.partition(".")[0] == package


def _size_of(executor: Any) -> int | None:
    """Return how many workers an executor has, None where it does not tell."""
    with suppress(Exception):  # a cluster that has gone: the next task tells
        if _is_of(executor, "distributed"):
            return int(sum(executor._client.nthreads().values()))
        found = executor.num_workers if _is_of(executor, "mpi4py") else executor._max_workers
        return validate.integer("workers", found, 0)
    return None


class OwnThreads(TaskRunner):
    """Own threads, as many as there are processors."""

    def __init__(self) -> None:
        """Start them when they are needed."""
        super().__init__(ThreadPoolExecutor(cores()))

    def close(self) -> None:
        """End the threads."""
        self.executor.shutdown(cancel_futures=True)


class OwnProcesses(TaskRunner):
    """Own processes, each in its own pool: when one dies, its task is known, and the others go on."""

    def __init__(self, workers: int) -> None:
        """Start them."""
        self._pools = [_Pool.started() for _ in range(workers)]
        self._busy: dict[Future[Any], int] = {}
        self._failed_starts = 0
        super().__init__(self._pools[0].executor)
        try:
            while self._pools[0].pid.exception() is not None:
                self._replace(0)
        except BaseException:
            self.close()
            raise

    @property
    def room(self) -> int:
        """Return how many tasks to hand over, one for every process."""
        return len(self._pools)

    def submit(self, job: Job, piece: Piece) -> Future[list[Outcome]]:
        """Hand a task to a process that has none."""
        place = next(place for place in range(self.room) if place not in self._busy.values())
        try:
            task = self._pools[place].executor.submit(carry_out, job, piece)
        except BrokenExecutor:  # it died between tasks
            self._replace(place)
            task = self._pools[place].executor.submit(carry_out, job, piece)
        self._busy[task] = place
        return task

    def has_begun(self, task: Future[Any]) -> bool:
        """Return whether the process of a task had started when the task ended."""
        return self._pools[self._busy[task]].has_begun

    def has_died(self, task: Future[Any], error: BaseException | None) -> bool:
        """Note that the process of a task is free; return whether it has died, and is replaced."""
        place = self._busy.pop(task)
        died = isinstance(error, BrokenExecutor)
        if died:
            self._replace(place)
        return died

    def stop(self) -> None:
        """End the processes at once."""
        for pool in self._pools:
            if pool.has_begun:
                with suppress(OSError):  # it has ended
                    os.kill(pool.pid.result(), signal.SIGTERM)

    def close(self) -> None:
        """End the processes."""
        for pool in self._pools:
            pool.executor.shutdown(cancel_futures=True)

    def _replace(self, place: int) -> None:
        """Start another process in the place of one that has died; RuntimeError where none ever begins."""
        self._failed_starts = 0 if self._pools[place].has_begun else self._failed_starts + 1
        if self._failed_starts >= _STARTS:
            raise RuntimeError(
                f"{_STARTS} worker processes one after another ended as soon as they started: in a script call "
                "fr.ensemble(workers=...) under 'if __name__ == \"__main__\":', which new processes import without "
                "running it; elsewhere check whether they are killed, or memory is short"
            )
        self._pools[place].executor.shutdown(wait=False)
        self._pools[place] = _Pool.started()


class _Pool(NamedTuple):
    """A pool of one process, and the number that the system knows it by."""

    executor: ProcessPoolExecutor
    pid: Future[int]

    @property
    def has_begun(self) -> bool:
        """Return whether its process has started."""
        return self.pid.done() and self.pid.exception() is None

    @classmethod
    def started(cls) -> _Pool:
        """Return a pool whose process is starting."""
        executor = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _prepare)
        return cls(executor, executor.submit(os.getpid))


def _prepare() -> None:
    """Leave Ctrl-C to the parent, and end with it however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Any) -> None:
    """End this process once its parent has ended."""
    parent.join()
    os._exit(1)


def require_executor(executor: Any, workers: Any) -> int | None:
    """Return the number of own processes, None for none; an error for an object that accepts no tasks."""
    count = None if workers is None else validate.integer("workers", workers, 1, validate.MOST_THREADS)
    if executor is None:
        return count
    if not isinstance(executor, Executor):
        raise TypeError(
            f"executor must be one of concurrent.futures such as ProcessPoolExecutor(8), got {validate.short(executor)}"
        )
    if count is not None:
        raise ValueError(f"workers is a number of own processes, got {count} beside an executor; leave one of them out")
    return None


def runner_for(executor: Executor | None, workers: int | None) -> TaskRunner:
    """Return what takes tasks."""
    if executor is not None:
        return TaskRunner(executor)
    return OwnThreads() if workers is None else OwnProcesses(workers)


# --- the work ---


def work(
    runner: TaskRunner,
    job: Job,
    pending: Sequence[int],
    values: Callable[[int], Mapping[str, float]],
    idle: Callable[[], None],
) -> Generator[Outcome, None, None]:
    """Yield outcomes as they come, in any order; ends early, after abandoning the rest, on Ctrl-C.

    ``idle`` is called about ten times a second at least.  Raises RuntimeError when the executor breaks.
    """
    tasks: dict[Future[list[Outcome]], list[int]] = {}
    queue, alone, deaths = deque(pending), deque[int](), Counter[int]()
    pace = _Pace()
    broken: RuntimeError | None = None
    with interrupt.held() as deliver:
        try:
            while queue or alone or tasks:
                while broken is None and (queue or alone) and len(tasks) < runner.room:
                    runs = [alone.popleft()] if alone else pace.take(queue, runner.room)
                    try:
                        tasks[runner.submit(job, [(run, values(run)) for run in runs])] = runs
                    except Exception as refusal:  # every executor has its own ways to break
                        broken = _broken(refusal)
                done, _ = wait(tasks, timeout=0.0 if broken else _HEARD_WITHIN, return_when=FIRST_COMPLETED)
                deliver()
                for task in done:
                    runs, error = tasks.pop(task), _error(task)
                    begun = runner.has_begun(task)
                    if runner.has_died(task, error):
                        if len(runs) == 1 and begun:
                            deaths[runs[0]] += 1
                        fatal = [run for run in runs if deaths[run] >= _DEATHS]
                        alone.extend(run for run in runs if run not in fatal)
                        for run in fatal:
                            yield Outcome(run, FAILED, f"{DIED} {_DEATHS} times: killed, or out of memory")
                    elif error is not None:
                        broken = _broken(error)
                    else:
                        found = task.result()
                        pace.note(found)
                        yield from found
                        made = {outcome.run for outcome in found}
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
    cause = str(error) or type(error).__name__
    return RuntimeError(
        f"the executor has failed ({type(error).__name__}: {cause}); finished runs are kept: call fr.ensemble again "
        "with the same arguments, store and a new executor to continue"
    )


class _Pace:
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

    def note(self, found: Sequence[Outcome]) -> None:
        """Learn from the wall time of runs."""
        self._seconds += sum(outcome.results.get("wall_time", 0.0) for outcome in found)
        self._runs += len(found)
