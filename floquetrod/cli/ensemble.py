"""`floquetrod ensemble`: many runs of one simulated rod, from a study file, with statistics."""

from __future__ import annotations

import argparse
import math
import re
import shlex
import signal
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import floquetrod as fr
from floquetrod._util.interchange import with_unit
from floquetrod._util.result_report import Table
from floquetrod._util.tables import require_file
from floquetrod._util.waiting import Waiting, roughly
from floquetrod.cli.common import describe_command, table_or_figure, warnings_at_once, write_each
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser, ratio, whole_number
from floquetrod.ensembles.overview import BucklingShare, Overview
from floquetrod.simulation.outcome import DEFINITION

_HELP = """\
Simulate a rod many times, with other loads, kicks, seeds or data each time, and count how often it buckles.

examples:
  floquetrod example study.toml
  floquetrod ensemble study.toml
  floquetrod ensemble study.toml --store runs.zarr --workers 8
  floquetrod ensemble study.toml --out buckling.png --out runs.csv
  floquetrod ensemble study.toml --store runs.zarr --part 3/100

a study file, in which strings may carry units:
  rod = "nitinol"                      # or a rod file, or a table [rod] as in rod files
  [load]                               # mean, amplitude, frequency, mean_at, wave, axial_damping, force
  mean = "0.825Fcr"
  amplitude = "0.7Fcr"
  frequency = "24Hz"
  [run]                                # duration, friction, segments, frames, stop_early, ...
  duration = "2s"
  friction = 0.1
  [start]                              # kick by mode, random, case, seed
  kick = {8 = "50mm/s"}
  random = "50mm/s"
  [over]                               # the varied numbers of the rod, load and run; kick scales the start
  kick = {from = "10mm/s", to = "80mm/s", steps = 8}
  frequency = ["19Hz", "24Hz"]
  length = {distribution = "normal", mean = "3.1m", deviation = "5mm"}
  seed = {from = 1, to = 100}
  [ensemble]                           # layout ("grid" or "list"), samples and seed of distributions, frames
  samples = 20

Fcr is the critical force of the rod that the file describes, even if the rod is varied.  Distributions are uniform and
loguniform (low, high) and normal (mean, deviation; low and high if it is truncated).

A store ends in .zarr (a folder that xarray opens, even while it grows; needs floquetrod[ensemble]) or in .npz.  Ctrl-C
and SIGTERM end the runs in progress, and keep the others: the same command continues.  So do the jobs of an array,
which share a store by --part.  The exit status is 130 when interrupted, 2 for invalid input.
"""

_ROWS = 40  # of the table that are printed, as a screen has; all of them are in the JSON
_REASONS = 5  # kinds of failure that are printed, the most frequent ones
_LOGGED = 60.0  # s between lines of progress at most where stderr is a log: a thousand in a night


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _ensemble, ("study", "store", "workers", "part", "json"))
    command.add_argument("study", type=Path, help="TOML file: what is simulated, and what is varied")
    command.add_argument(
        "--store", metavar="FILE", type=Path, help="folder.zarr or file.npz to write while results come"
    )
    command.add_argument("--resume", action="store_true", help="continue an existing store, which is also the default")
    command.add_argument(
        "--workers", metavar="N", type=whole_number, help="processes (default: threads, one for each processor)"
    )
    command.add_argument(
        "--part", metavar="K/N", help="k/n: only the k-th of n parts, for jobs that share a store ending in .zarr"
    )
    command.add_output(
        "--out", table_or_figure, "write a figure of the probability of buckling (.png, .pdf, .svg), or the runs (.csv)"
    )
    command.add_argument(
        "--over",
        metavar="NAME,NAME",
        help="two varied quantities, such as length,mean: the figure shows each run over both (default: the two that "
        "are drawn, if two are)",
    )
    command.add_argument(
        "--confidence", metavar="SHARE", type=ratio, default=0.95, help="of the intervals (default 0.95)"
    )


def _ensemble(options: argparse.Namespace) -> Output:
    if not 0.0 < options.confidence < 1.0:
        raise ValueError(f"--confidence must lie between 0 and 1, got {options.confidence:g}")
    part, store = _part(options), options.store
    require_file("study file", options.study, "a TOML file")
    study = fr.Study.from_toml(options.study)
    if store is None and study.options.get("frames"):
        raise ValueError(f"study file {options.study}: [ensemble] frames needs a --store to keep them in")
    plane = _plane(study, options)
    _require_picture(study, options.out or (), plane)
    progress, started = Waiting("simulating", "runs", longest=_LOGGED), time.monotonic()
    with warnings_at_once(), _stopped_by_signals() as stopped, progress:
        try:
            found = study.run(workers=options.workers, store=store, part=part, progress=progress)
        except (ImportError, RuntimeError) as error:
            raise ValueError(str(error)) from None
        except KeyboardInterrupt:  # before the first run, or while results were read
            return Output(f"INTERRUPTED before a run was done\n{_onwards(options)}", 130)
    summary = Overview.of(found, options.confidence)
    complete = summary.pending == 0 or progress.is_complete or not stopped
    record = {
        "runs": summary.total,
        "done": summary.done,
        "failed": summary.failed,
        "pending": summary.pending,
        "made_now": progress.counted_now,
        "complete": complete,
        "buckled": summary.buckled,
        "outcomes": summary.outcomes,
        "buckled_means": DEFINITION,
        "notes": summary.doubts,
        "failures": [{"reason": reason, "runs": count} for reason, count in summary.reasons],
        "confidence": options.confidence,
        "rows": [
            {**{with_unit(name, summary.units[name]): v for name, v in row.at.items()}, **row.counts, **row.shares}
            for row in summary.rows
        ],
        "store": None if store is None else str(store),
        "continue": None if complete else _command(options),
        "seconds": time.monotonic() - started,
        "seconds_of_all_runs": summary.wall_time,
    }
    said = "\n".join(_report(summary, record, study, options))
    written = write_each(options.out, lambda path: _write(path, found, study, options.confidence, plane))
    return output(options, lambda: said, lambda: record, 0 if complete else 130, written)


def _plane(study: fr.Study, options: argparse.Namespace) -> tuple[str, ...] | None:
    """Return the quantities of --over; ValueError, before anything runs, unless they are two that the study varies."""
    from floquetrod.rod.distributions import quantile_function

    if options.over is None:
        return None
    names = tuple(name.strip() for name in options.over.split(","))
    # Seeds are no quantity, and one value alone, or a value again and again, does not vary.
    varied = [
        name
        for name, given in study.over.items()
        if name != "seed" and (quantile_function(given) is not None or len(set(given)) > 1)
    ]
    if len(set(names)) != 2 or len(names) != 2 or not set(names) <= set(varied):
        raise ValueError(
            f"--over must be two quantities that vary in [over] of {study.path}, with a comma between; these are "
            f"{', '.join(varied) or 'none'}; got {options.over!r}"
        )
    if not any(path.suffix != ".csv" for path in options.out or ()):
        raise ValueError("--over is about a figure: name one with --out, such as --out buckling.png")
    return names


def _require_picture(study: fr.Study, paths: Iterable[Path], plane: tuple[str, ...] | None) -> None:
    """Refuse a figure, before anything runs, where a study has nothing to be drawn."""
    from floquetrod.ensembles.shares import RANDOM
    from floquetrod.ensembles.varied_axes import LAYOUTS, dims_of

    dims = dims_of(study.over, study.options.get("layout", LAYOUTS[0]))
    chosen = [name for name, dim in dims.items() if dim not in RANDOM and len(set(study.over[name])) > 1]
    if plane or len(chosen) in (1, 2) or set(RANDOM) & set(dims.values()):
        return
    for path in paths:
        if path.suffix != ".csv":
            raise ValueError(
                f"--out {path} needs one or two quantities that vary, or runs that are drawn, got "
                f"{', '.join(chosen) or 'none'} in [over] of {study.path}: give the others one value, vary the seed or "
                "a distribution, or write a .csv file"
            )


def _write(path: Path, found: Any, study: fr.Study, confidence: float, plane: tuple[str, ...] | None) -> None:
    """Write a table of the runs, or a figure of the share that buckled in the units of the study."""
    from floquetrod.ensembles.pictures import draw
    from floquetrod.ensembles.runs import Runs
    from floquetrod.plotting import chart_plot

    runs = found if isinstance(found, Runs) else Runs.of_each_run(found)
    if path.suffix == ".csv":
        runs.to_csv(path)
    else:
        chart_plot.save_figure(draw(runs, "buckled", confidence, study.units, plane), path)


def _part(options: argparse.Namespace) -> tuple[int, int] | None:
    """Return which part is to be made, None for everything."""
    if options.part is None:
        return None
    match = re.fullmatch(r"(\d{1,7})/(\d{1,7})", options.part, re.ASCII)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise ValueError(
            f"--part must be the number of a part and how many there are such as 3/100, got {options.part!r}"
        )
    if options.store is None:
        raise ValueError("--part needs --store: parts are put together in a store; name a folder such as runs.zarr")
    return int(match[1]), int(match[2])


@contextmanager
def _stopped_by_signals() -> Iterator[list[int]]:
    """Let SIGTERM end the runs as Ctrl-C does; yields a list to which either adds its number.

    Where Ctrl-C is ignored, as in jobs in the background, it stays ignored.
    """
    seen: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield seen
        return

    def stop(number: int, _: FrameType | None) -> None:
        seen.append(number)
        raise KeyboardInterrupt

    def terminate(number: int, frame: FrameType | None) -> None:
        handler = signal.getsignal(signal.SIGINT)  # which may hold Ctrl-C back until results are written
        (handler if callable(handler) else stop)(number, frame)

    own = [signal.SIGTERM] if signal.getsignal(signal.SIGINT) is signal.SIG_IGN else [signal.SIGTERM, signal.SIGINT]
    before = {number: signal.signal(number, terminate if number == signal.SIGTERM else stop) for number in own}
    try:
        yield seen
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


def _report(summary: Overview, record: dict[str, Any], study: fr.Study, options: argparse.Namespace) -> Iterator[str]:
    """Yield the lines of the answer."""
    headline = (
        f"{summary.done:,} of {summary.total:,} runs done, {summary.failed:,} failed, {summary.pending:,} pending"
    )
    yield headline if record["complete"] else f"INTERRUPTED: {headline}"
    stored = summary.done + summary.failed - record["made_now"]
    if options.store is not None and stored > 0:
        yield f"{stored:,} of {summary.total:,} runs were in the store before; {record['made_now']:,} were made now"
    yield ""
    if summary.done:
        yield f"buckled   {summary.buckled:,} of {summary.done:,}{_others(summary)}"
        yield f"          buckled means {DEFINITION}"
        yield from (f"note      {text}" for text in summary.doubts)
    for place, (reason, count) in enumerate(summary.reasons[:_REASONS]):
        yield f"{'' if place else 'failed':<8}  {count:,}: {reason}"
    if len(summary.reasons) > _REASONS:
        yield f"{'':<8}  and others, {len(summary.reasons) - _REASONS} kinds: {_named(options)}"
    yield f"cost      {record['seconds']:.3g} s{_whole_cost(summary)}"
    yield f"store     {options.store}" if options.store is not None else "store     none: name one with --store"
    if not record["complete"]:
        yield _onwards(options)
    if summary.done:
        yield from _table(summary.rows, study, options)


def _whole_cost(summary: Overview) -> str:
    """Return how long all runs done took, each by itself, and about how long the pending ones will."""
    if not summary.done:
        return ""
    each = summary.wall_time / summary.done
    text = f"; all {summary.done:,} runs done took {roughly(summary.wall_time)}, one after the other"
    left = f", the {summary.pending:,} pending about {roughly(each * summary.pending)}" if summary.pending else ""
    return f"{text}{left}"


def _others(summary: Overview) -> str:
    """Return what became of the rods beyond 5 degrees that have not buckled."""
    words = [
        f"{count:,} {kind}" for kind, count in summary.outcomes.items() if kind not in ("buckled", "quiet") and count
    ]
    if summary.resting is not None:
        low, high = (f"{math.degrees(angle):.3g}" for angle in summary.resting)
        range_of = low if low == high else f"{low} to {high}"
        resting = f"{summary.outcomes['at rest']:,} at rest"
        words = [f"{word} at {range_of} degrees" if word == resting else word for word in words]
    return f"; not buckled, but beyond 5 degrees: {', '.join(words)}" if words else ""


def _named(options: argparse.Namespace) -> str:
    """Return where everything is."""
    return "--json lists them" if options.store is None else f"see reason in {options.store}"


def _table(rows: list[BucklingShare], study: fr.Study, options: argparse.Namespace) -> Iterator[str]:
    """Yield the table of probabilities."""
    if not rows:
        return
    yield ""
    heads = ["runs done", "share that buckled", f"{100.0 * options.confidence:g} % interval"]
    moving = any(row.counts["moving"] for row in rows)
    heads += ["if moving runs buckle too"] if moving else []
    columns = [(name.replace("_", " "), ">1") for name in rows[0].at] + [(head, ">1") for head in heads]
    listed = []
    for row in rows[:_ROWS]:
        share, low, high, highest = ("-" if part is None else f"{part:.3f}" for part in row.shares.values())
        failed = f", {row.counts['failed']:,} failed" if row.counts["failed"] else ""
        listed.append(
            (
                *(study.units[name].show(value, 4) for name, value in row.at.items()),
                f"{row.counts['done']:,}{failed}",
                share,
                f"{low} to {high}",
                *([f"up to {highest}"] if moving else []),
            )
        )
    more = len(rows) - _ROWS
    yield str(Table(columns, listed, f"and {more:,} more: --json lists them all" if more > 0 else ""))


def _onwards(options: argparse.Namespace) -> str:
    """Return a line about how to go on."""
    if options.store is None:
        return "continue  not possible without --store: the same command starts from the beginning"
    return f"continue  {_command(options)}"


def _command(options: argparse.Namespace) -> str | None:
    """Return the command that goes on, None where nothing was stored."""
    if options.store is None:
        return None
    words = ["floquetrod", "ensemble", str(options.study), "--store", str(options.store)]
    words += [] if options.workers is None else ["--workers", str(options.workers)]
    words += [] if options.part is None else ["--part", options.part]
    words += [] if options.confidence == 0.95 else ["--confidence", f"{options.confidence:g}"]
    return shlex.join([*words, *(["--json"] if options.json else [])])
