"""`fr.ensemble`: one simulation with many values of what it depends on, from a laptop to a cluster."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Mapping, Sequence, Set
from concurrent.futures import Executor
from contextlib import AbstractContextManager, closing, nullcontext, suppress
from pathlib import Path
from typing import Any, Literal

from floquetrod._util import interrupt, validate, waiting
from floquetrod._util.calling import level_of_caller
from floquetrod.ensembles import stores_disk, stores_zarr, tasks
from floquetrod.ensembles.stores import RESULTS, MemoryStore, RunResult, StoreLayout, chunk_shape, reason_of
from floquetrod.ensembles.variables import DONE
from floquetrod.ensembles.varied_axes import MOST_RUNS, RUN_SEED, Design, design_of, varied
from floquetrod.ensembles.workers import OwnProcesses, TaskRunner, require_executor, work
from floquetrod.simulation.resolution import ResolutionWarning
from floquetrod.simulation.simulation_problem import SimulationProblem


def ensemble(
    problem: SimulationProblem,
    over: Mapping[str, Any],
    *,
    layout: Literal["grid", "list"] = "grid",
    samples: int | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    workers: int | None = None,
    store: str | Path | None = None,
    summary: tasks.Summary | None = None,
    frames: bool = False,
    part: tuple[int, int] | None = None,
    retry_failed: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> Any:
    """Simulate a problem with many values of its parameters; results are arrays over named axes.

    Parameters
    ----------
    problem : SimulationProblem
        Gives everything that ``over`` does not.
    over : mapping
        Values by name, in SI units.  Names are the numbers among the fields of the problem ("friction", "duration",
        "segments", ...), of its load ("mean", "amplitude", "frequency", ...), the parameters of its rod ("length",
        "youngs_modulus", ...), and of its start: "kick" scales the whole perturbation so that its largest speed is
        this, in m/s, and "seed" is the seed of its noise.  Values are a sequence, or a distribution of `scipy.stats`
        with its parameters given; ``samples`` values are drawn of it.
    layout : {"grid", "list"}
        "grid": every combination of the values, one dimension for each name; values drawn share the dimension "sample".
        A sample has its own seeds: the seed of a run follows from ``seed``, its sample and its seed in ``over``, and is
        the coordinate ``run_seed``.
        "list": the first values together, the second ones, and so on, along the one dimension "run".
    samples : int, optional
        How many values are drawn from distributions.
    seed : int
        Seed of the values drawn from distributions, and of the seeds of their runs.
    executor : concurrent.futures.Executor, optional
        Makes the runs, in any order; it is not shut down.  Any object with the same ``submit``: a process pool,
        ``MPIPoolExecutor`` of mpi4py, or a ``Client`` of dask.distributed.  By default threads, as many as there are
        processors.
    workers : int, optional
        Makes the runs in so many processes instead.  One that dies is replaced; a run in which three died has failed.
    store : path, optional
        Written while results come: a folder that ends in ".zarr", or a file in ".npz".  Where it exists, only the runs
        that it lacks are made.  A store that another process fills is refused.
    summary : callable, optional
        Makes further results of every run: takes a `Simulation`, returns numbers by name.
    frames : bool
        Whether time, angle and positions of every frame are stored, too.
    part : tuple of int, optional
        (k, n): makes the k-th of n parts only, for the jobs of an array that share a store ending in ".zarr".
    retry_failed : bool
        Whether runs of a store that failed for a temporary cause, a MemoryError, an OSError or workers that died, are
        made again.  A run that failed by any other error would fail again and is not.
    progress : callable, optional
        Called with the numbers of runs done and to do.  Without it a terminal or a notebook shows them, and the time
        left, in a line on stderr after a second.

    Returns
    -------
    xarray.Dataset, or Runs where xarray is not installed
        Over the axes: ``status`` (0 pending, 1 done, 2 failed) and ``reason``, why a run failed; ``buckled``,
        ``time_to_buckle`` (s, NaN where it did not), ``dominant_mode``, ``growth_rate`` and ``growth_error`` of that
        mode (1/s, NaN with friction, or where there is too little to fit), ``largest_angle`` (rad), ``energy_error``
        (J, the largest), ``wall_time`` (s), and the results of ``summary``.  Some runs are pending after Ctrl-C, which
        abandons those in progress, and where a part was made.

    Raises
    ------
    TypeError, ValueError
        Before anything runs: for names that the problem does not have, values other than numbers, or without
        a possible problem, columns of a list whose lengths differ, a store of another study or one that another
        process fills, arguments that cannot be pickled for other processes.  One run that cannot be made is recorded as
        failed.
    RuntimeError
        When the executor breaks, or three worker processes one after another end as soon as they start; results so far
        are in the store.
    ImportError
        For a store ending in ".zarr" without the extra: pip install floquetrod[ensemble].

    Warns
    -----
    CheckpointWarning
        Once, when the store cannot be written: the results are returned all the same, and the same call makes the
        missing runs later.  Frames are returned as far as 4 GiB of memory hold all of them, else the frames in the
        store.  Also where the file system has no locks.
    RuntimeWarning
        Once, at the end, when processes of ``workers`` died and were replaced; it is never raised as an error.

    Notes
    -----
    Every run depends on the problem and its values alone: results are the same bit for bit, whatever makes them.

    Examples
    --------
    >>> import floquetrod as fr
    >>> load = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
    >>> problem = fr.SimulationProblem(fr.Rod.nitinol(), load, duration=0.01, segments=60, frames=5)
    >>> found = fr.ensemble(problem, over={"frequency": [120.0, 150.0], "seed": range(3)})
    >>> dict(found.sizes), int(found.status.sum()), bool(found.buckled.any())
    ({'frequency': 2, 'seed': 3}, 6, False)
    """
    study = design_of(problem, over, layout, samples, seed)
    place = None if store is None else validate.path("store", store)
    if summary is not None:
        validate.function("summary", summary)
    frames, share = validate.flag("frames", frames), _part(part)
    retry_failed = validate.flag("retry_failed", retry_failed)
    validate.progress(progress)
    executor, count = require_executor(executor, workers)
    names, chunk, make = _store(place, study, frames, share[1])
    job = tasks.TaskSettings(problem, summary, None, frames)
    opened: MemoryStore | None = None
    if names is not None:
        if (summary is None) == bool(names):
            raise ValueError(f"store {place} holds another study, with another summary; give another path")
        opened = make(StoreLayout(study, names, frames, chunk))
    plan = StoreLayout(study, names or (), frames, chunk)
    runs = plan.runs_of(plan.part(share))
    pending = list(runs) if opened is None else opened.pending(runs, retry_failed=retry_failed)
    sentences = (tasks.coarseness(problem, study.values(run)) for run in tasks.spread(pending))
    if sentence := next(filter(None, sentences), ""):
        warnings.warn(sentence, ResolutionWarning, stacklevel=level_of_caller())
    runner = None if not pending else TaskRunner(executor) if count is None else OwnProcesses(count)
    try:
        if runner is not None:
            runner.require_picklable(job)
        first: list[RunResult] = []
        if summary is not None and pending:
            # A run that is made again may end the process or have no memory: the names are learned from others.
            fresh = pending if opened is None else opened.pending(runs, retry_failed=False) or opened.one_done()
            summary_names, first = _first_runs(job, study, fresh)
            if (
                opened is not None
                and any(one.status == DONE for one in first)
                and set(summary_names) != set(names or ())
            ):
                raise ValueError(
                    f"store {place} holds a summary of {', '.join(names or ())}, got {', '.join(summary_names)}"
                )
            job = job._replace(names=summary_names if opened is None else names)
        if opened is None:
            opened = make(StoreLayout(study, job.names or (), frames, chunk))
        if runner is not None:
            with _shown(progress) as told:
                _fill(opened, plan.part(share), job, runner, first, retry_failed, told)
    finally:
        if runner is not None:
            runner.close()
    if runner is not None and runner.replaced:
        with suppress(RuntimeWarning):  # where warnings are errors this one would cost the results
            warnings.warn(_replaced_in_words(runner.replaced), RuntimeWarning, stacklevel=level_of_caller())
    try:
        importlib.import_module("floquetrod.ensembles.accessor")
    except ImportError:  # without xarray
        return opened.runs()
    return opened.to_xarray()


def _replaced_in_words(count: int) -> str:
    """Return that so many worker processes were replaced."""
    some = "1 worker process ended and was" if count == 1 else f"{count} worker processes ended and were"
    return f"{some} replaced, killed or out of memory; no finished run was lost"


def _shown(
    progress: Callable[[int, int], None] | None,
) -> AbstractContextManager[Callable[[int, int], None] | None]:
    """Return a context with the listener to the number of runs: the caller's function, a line on stderr, or None."""
    if progress is not None or not waiting.can_redraw():
        return nullcontext(progress)
    return waiting.Waiting("simulating", "runs", first=1.0)


def _fill(
    store: MemoryStore,
    chunks: range,
    job: tasks.TaskSettings,
    runner: TaskRunner,
    first: Sequence[RunResult],
    retry_failed: bool,
    progress: Callable[[int, int], None] | None,
) -> None:
    """Simulate the pending runs, and record their results, until all are done or Ctrl-C."""
    study, runs = store.layout.study, store.layout.runs_of(chunks)
    try:
        store.open_part(chunks)
        pending = store.pending(runs, retry_failed=retry_failed)
        for outcome in first:
            if outcome.run in pending:  # else another process has made it meanwhile
                pending.remove(outcome.run)
                store.record(outcome)
        done = len(runs) - len(pending)
        with (
            suppress(KeyboardInterrupt),
            closing(work(runner, job, pending, study.values, store.save_when_due)) as outcomes,
        ):
            for outcome in outcomes:
                store.record(outcome)
                done += 1
                if progress is not None:
                    progress(done, len(runs))
    finally:
        with interrupt.held():
            store.save()
            store.close()


def _first_runs(
    job: tasks.TaskSettings, study: Design, pending: Sequence[int]
) -> tuple[tuple[str, ...], list[RunResult]]:
    """Return the names of the summary, and the runs made to learn them: until one could be made."""
    made = []
    for run in pending:
        try:
            simulation = varied(job.problem, study.values(run)).run()
        except tasks.OWN_ERRORS as error:  # recorded as any other run's
            made.append(tasks.failure(run, error))
            continue
        if not simulation.complete:
            raise KeyboardInterrupt
        try:
            outcome = tasks.outcome(job, run, simulation)
        except tasks.OWN_ERRORS as error:
            at = ", ".join(f"{name} = {value:g}" for name, value in study.values(run).items())
            raise validate.wrong_value(
                "summary", f"must return numbers for a run; for that with {at} it raised {reason_of(error)}"
            ) from error
        names = tuple(outcome.summary)
        taken = {
            *RESULTS,
            RUN_SEED,
            *study.dims,
            *(axis.name for axis in study.axes),
            "reason",
            "time",
            "angle",
            "positions",
        }
        for name in names:
            if name in taken or not name.isidentifier():
                raise validate.wrong_value("summary", f"must use names that are not taken, got {name!r}")
        return names, [*made, outcome]
    return (), made


def _store(
    place: Path | None, study: Design, frames: bool, parts: int
) -> tuple[tuple[str, ...] | None, tuple[int, ...], Callable[[StoreLayout], MemoryStore]]:
    """Return the names of the summary of a store, None where there is no store yet, its chunks, and what opens it.

    Raises ValueError for a store of another study, and where none can be written.
    """
    chunk = chunk_shape(study.shape, parts)
    if place is None:
        return None, chunk, MemoryStore
    if place.suffix == ".zarr":
        return stores_zarr.open_store(place, study, frames, chunk)
    if place.suffix != ".npz":
        raise validate.wrong_value("store", f"must end in .zarr or .npz, got {validate.short(str(place))}")
    if parts > 1:
        raise validate.wrong_value(
            "part", f"needs a store that many can write: one that ends in .zarr, got {str(place)!r}"
        )
    names, make = stores_disk.open_store(place, study, frames)
    return names, chunk, make


def _part(part: Any) -> tuple[int, int]:
    """Return the argument ``part`` as (k, n), by default the only part of one."""
    if part is None:
        return 1, 1
    try:
        if isinstance(part, str | bytes | Mapping | Set):
            raise TypeError
        k, n = part
    except Exception:  # whatever an iterator raises
        raise validate.wrong_type(
            "part", f"must be two integers (k, n), the k-th of n parts, got {validate.short(part)}"
        ) from None
    n = validate.integer("part[1]", n, 1, MOST_RUNS)
    return validate.integer("part[0]", k, 1, n, "parts are counted from 1"), n
