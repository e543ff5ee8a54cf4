"""What is stored of an ensemble, and where: in memory.

`floquetrod.ensembles.stores_disk` and `floquetrod.ensembles.stores_zarr` have the stores that save it as it comes.
"""

from __future__ import annotations

import bisect
import builtins
import hashlib
import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.caching import cached_property
from floquetrod._util.suggest import short
from floquetrod._util.version import __version__
from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.variables import DONE, FAILED, PENDING, Variable
from floquetrod.ensembles.varied_axes import RUN_SEED, Design
from floquetrod.simulation.arithmetic import arithmetic
from floquetrod.simulation.outcome import DEFINITION, KINDS

_RUNS_IN_A_CHUNK = 256  # at most: files of kilobytes, written again with each save of a run of theirs
_SECONDS_BETWEEN = 1.0  # of wall time, between saves: what a kill costs
_LONGER = 50.0  # times the duration of a save until the next one: saves take at most a fiftieth
MOST_MEMORY = 1 << 32  # bytes of frames in memory, half of what a laptop has
_LISTED = 3  # differences of studies that a message lists (a choice)
REASON = 240  # characters of a reason that are stored: two lines of a terminal, and part of the format of stores
DIED = "its worker process died"  # begins the reason of a run that had no error of its own
_PASSING = (MemoryError, OSError)


class ResultField(NamedTuple):
    """The type, unit and meaning of a result."""

    dtype: Any
    unit: str
    long_name: str

    @property
    def nothing(self) -> Any:
        """What stands for it where there is none."""
        return np.nan if self.dtype is np.float64 else 0


RESULTS = {
    "status": ResultField(np.int8, "1", "pending, done or failed"),
    "buckled": ResultField(np.bool_, "1", f"whether the rod has buckled: {DEFINITION}"),
    "outcome": ResultField(np.int8, "1", "what has become of the rod"),
    "angle_in_the_end": ResultField(
        np.float64, "rad", "largest angle of any node from where it began, over the last quarter"
    ),
    "time_to_buckle": ResultField(np.float64, "s", "first recorded time beyond 5 degrees of a run that buckled"),
    "dominant_mode": ResultField(np.int16, "1", "mode of largest amplitude over the last quarter"),
    "growth_rate": ResultField(np.float64, "1/s", "growth rate of the dominant mode while motion is small"),
    "growth_error": ResultField(np.float64, "1/s", "error of the growth rate"),
    "largest_angle": ResultField(np.float64, "rad", "largest angle of any node at any time"),
    "energy_error": ResultField(np.float64, "J", "largest error of the energy balance"),
    "wall_time": ResultField(np.float64, "s", "time that the run took"),
}
"""Results of every run, beside ``reason``, a text."""

_FLAGS = {
    "status": {"flag_values": [PENDING, DONE, FAILED], "flag_meanings": "pending done failed"},
    "outcome": {
        "flag_values": list(range(len(KINDS))),
        "flag_meanings": " ".join(kind.replace(" ", "_") for kind in KINDS),
    },
}
"""Meanings of the numbers of a result, as netCDF's conventions give them."""


class RunResult(NamedTuple):
    """The number, status, reason, results, summary and, if wanted, frames of a run."""

    run: int
    status: int
    reason: str = ""
    results: Mapping[str, float] = {}
    summary: Mapping[str, float] = {}
    frames: Mapping[str, NDArray[np.float64]] | None = None


def reason_of(error: BaseException) -> str:
    """Return why a run failed, from what it raised; of errors that may pass, with the name that Python has for them."""
    kind = type(error)
    if isinstance(error, _PASSING):  # NumPy has a MemoryError of its own
        kind = next(base for base in kind.__mro__ if base.__module__ == "builtins")
    return f"{kind.__name__}: {error}"


def may_pass(reason: str) -> bool:
    """Return whether a run that failed for this reason may come out otherwise when it is made again."""
    kind = getattr(builtins, reason.partition(":")[0], None)
    return reason.startswith(DIED) or (isinstance(kind, type) and issubclass(kind, _PASSING))


@dataclass(frozen=True)
class StoreLayout:
    """What a store holds: a study, the names of its summary, whether frames, and the shape of chunks of runs."""

    study: Design
    summary: tuple[str, ...]
    frames: bool
    chunk: tuple[int, ...]

    @property
    def kinds(self) -> dict[str, ResultField]:
        """All results by name, the summary's too."""
        return RESULTS | {name: ResultField(np.float64, "1", f"{name} of the summary") for name in self.summary}

    @property
    def frame_shapes(self) -> dict[str, tuple[tuple[str, int], ...]]:
        """Names of the arrays of a run's frames, with their dimensions; empty without frames."""
        if not self.frames:
            return {}
        frame, node = ("frame", self.study.problem.frames), ("node", self.study.problem.mesh.segments + 1)
        return {"time": (frame,), "angle": (frame, node), "positions": (frame, node, ("axis", 3))}

    @cached_property
    def starts(self) -> list[int]:
        """Number of the first run of every chunk; a chunk is a contiguous range of runs."""
        shape, starts = self.study.shape, [0]
        for length, step in zip(shape, self.chunk, strict=True):
            starts = [start * length + place for start in starts for place in range(0, length, step)]
        return starts

    def part(self, part: tuple[int, int]) -> range:
        """Return the chunks of the k-th of n parts, ``part`` = (k, n)."""
        (k, n), count = part, len(self.starts)
        return range((k - 1) * count // n, k * count // n)

    def runs_of(self, chunks: range) -> range:
        """Return the runs in consecutive chunks."""
        edges = [*self.starts, self.study.size]
        return range(edges[chunks.start], edges[chunks.stop])

    def attrs(self, name: str) -> dict[str, Any]:
        """Return the attributes of a result."""
        if name == "reason":
            return {"long_name": "why a run failed"}
        kind = self.kinds[name]
        own = {"long_name": kind.long_name, "units": kind.unit}
        return own | _FLAGS.get(name, {})

    @property
    def coords(self) -> dict[str, Variable]:
        """What is varied, and the seeds of runs where samples have their own."""
        coords = {
            axis.name: Variable(
                (axis.dim,), axis.values, {"long_name": axis.name.replace("_", " "), "units": axis.unit}
            )
            for axis in self.study.axes
        }
        if self.study.has_own_seeds:
            about = {"long_name": "seed of the run, derived from its sample and its seed", "units": "1"}
            coords[RUN_SEED] = Variable(("sample", "seed"), self.study.own_seeds, about)
        return coords

    @property
    def about(self) -> dict[str, Any]:
        """Attributes of the whole, plain data."""
        return {
            "version": __version__,
            "problem": json.dumps(self.study.problem.as_dict()),
            "varied": [axis.name for axis in self.study.axes],
            "summary": list(self.summary),
            "study": json.dumps(identity(self.study, self.frames)),
        }


def identity(study: Design, frames: bool) -> dict[str, Any]:
    """Return plain data that distinguishes a study from every other, except for the names of its summary."""
    own = {"seeds": [study.seed, "of each sample"]} if study.has_own_seeds else {}
    return {
        "problem": study.problem.as_dict(),
        "axes": [[axis.name, axis.dim, hashlib.sha256(axis.values.tobytes()).hexdigest()] for axis in study.axes],
        "frames": frames,
        "arithmetic": arithmetic(),
        "buckled": DEFINITION,
        **own,
    }


def require_same(place: Path, attrs: Mapping[str, Any], study: Design, frames: bool) -> tuple[str, ...]:
    """Return the names of the summary that a store holds; ValueError unless it holds this study."""
    try:
        theirs, names = json.loads(attrs["study"]), tuple(map(str, attrs["summary"]))
    except (KeyError, TypeError, ValueError):
        raise ValueError(f"store {place} is not one of fr.ensemble; give another path") from None
    ours = identity(study, frames)
    wrong = [name for name in {**ours, **theirs} if theirs.get(name) != ours.get(name)]
    if "buckled" in wrong:
        raise ValueError(
            f"store {place} was made by a version with another rule for which rods have buckled; it can be read, with "
            "floquetrod.ensembles.Runs.load or xarray.open_zarr, but not continued: give another path"
        )
    if wrong == ["arithmetic"]:
        other = [f"{name} {value}" for name, value in theirs["arithmetic"].items() if ours[wrong[0]].get(name) != value]
        raise ValueError(
            f"store {place} was made with {', '.join(other)}; continue it where that is installed, or give another path"
        )
    if wrong:
        parts = [_axes_apart(theirs.get("axes", []), ours["axes"])] if "axes" in wrong else []
        there, here = ({name: of.get(name) for name in wrong if name != "axes"} for of in (theirs, ours))
        parts += _apart(there, here)
        more = f" and {len(parts) - _LISTED} more" if len(parts) > _LISTED else ""
        raise ValueError(
            f"store {place} holds another study: {'; '.join(parts[:_LISTED])}{more}; give another path, or ask for the "
            "study there"
        )
    return names


def _axes_apart(theirs: list[list[str]], ours: list[list[str]]) -> str:
    """Return in words how the varied quantities of a store differ from this study's."""
    there, here = ({name: values for name, *values in axes} for axes in (theirs, ours))
    if there.keys() != here.keys():
        return f"it varies {', '.join(there) or 'nothing'}, and this one {', '.join(here) or 'nothing'}"
    other = [name for name in here if there[name][-1] != here[name][-1]]
    if other:
        return f"it has other values of {', '.join(other)}"
    if there == here:
        return "it varies the same in another order"
    return "it combines them in another layout, grid or list"


def _apart(theirs: Any, ours: Any, name: str = "") -> list[str]:
    """Return in words the entries of plain data in which two studies differ."""
    if isinstance(theirs, Mapping) and isinstance(ours, Mapping):
        both = dict.fromkeys([*ours, *theirs])
        return [each for key in both for each in _apart(theirs.get(key), ours.get(key), str(key))]
    if theirs == ours:
        return []
    there, here = ("none" if value is None else short(value) for value in (theirs, ours))
    return [f"{name.replace('_', ' ')} {there} there, {here} here"]


def chunk_shape(shape: tuple[int, ...], parts: int) -> tuple[int, ...]:
    """Return the shape of chunks, contiguous ranges of at most 256 runs, at least ``parts`` of them."""
    chunk, room = [], min(_RUNS_IN_A_CHUNK, math.ceil(math.prod(shape) / parts))
    for length in reversed(shape):
        step = math.ceil(length / math.ceil(length / room))
        chunk.append(step)
        room = room // step if step == length else 1
    return tuple(reversed(chunk))


class MemoryStore:
    """Results in memory."""

    def __init__(self, layout: StoreLayout) -> None:
        """Begin with every run pending."""
        self.layout = layout
        size = layout.study.size
        self.values: dict[str, NDArray[Any]] = {  # (runs,), by name
            name: np.full(size, kind.nothing, dtype=kind.dtype) for name, kind in layout.kinds.items()
        }
        self.reasons: dict[int, str] = {}  # why runs failed, by their number
        self._frames = self._room_for_frames()
        self._dirty: set[int] = set()
        self._due = time.monotonic() + _SECONDS_BETWEEN

    def open_part(self, chunks: range) -> None:
        """Keep others from writing these chunks, where that is possible."""

    def close(self) -> None:
        """Let others write again."""

    def pending(self, runs: range, *, retry_failed: bool) -> list[int]:
        """Return those runs that have to be made: pending and, if wanted, failed for a reason that may pass."""
        status = self.values["status"][runs.start : runs.stop]
        unfinished: list[int] = (np.flatnonzero(status != DONE) + runs.start).tolist()
        again = {run for run, reason in self.reasons.items() if retry_failed and may_pass(reason)}
        return [run for run in unfinished if run in again or self.values["status"][run] == PENDING]

    def one_done(self) -> list[int]:
        """Return one run that is done, or none."""
        return [int(run) for run in np.flatnonzero(self.values["status"] == DONE)[:1]]

    def record(self, outcome: RunResult) -> None:
        """Take over what came of a run."""
        run = outcome.run
        for name, value in (*outcome.results.items(), *outcome.summary.items()):
            self.values[name][run] = value
        self.reasons.pop(run, None)
        if outcome.reason:
            self.reasons[run] = outcome.reason[:REASON]
        self.values["status"][run] = outcome.status
        if outcome.frames is not None:
            self._record_frames(run, outcome.frames)
        self._mark(run)

    def _mark(self, run: int) -> None:
        """Note that the result of a run has yet to be saved."""
        self._dirty.add(bisect.bisect_right(self.layout.starts, run) - 1)

    def save_when_due(self) -> None:
        """Save about every second, or less often where saving takes long."""
        started = time.monotonic()
        if started >= self._due:
            self.save()
            took = time.monotonic() - started
            self._due = started + took + max(_SECONDS_BETWEEN, _LONGER * took)

    def save(self) -> None:
        """Write new results, where there is a disk to write to."""

    def runs(self) -> Runs:
        """Return the runs stored so far."""
        study = self.layout.study
        text = np.full(study.size, "", dtype=f"U{max(1, *map(len, self.reasons.values()), 1)}")
        for run, reason in self.reasons.items():
            text[run] = reason
        variables = {
            name: Variable(study.dims, values.reshape(study.shape).copy(), self.layout.attrs(name))
            for name, values in (("status", self.values["status"]), ("reason", text), *self.values.items())
        }
        return Runs(variables | self._frame_variables(), self.layout.coords, self.layout.about)

    def to_xarray(self) -> Any:
        """Return the runs stored so far as an xarray.Dataset."""
        return self.runs().to_xarray()

    def _room_for_frames(self) -> dict[str, NDArray[np.float64]]:
        """Return arrays for the frames of all runs."""
        shapes = {name: tuple(length for _, length in dims) for name, dims in self.layout.frame_shapes.items()}
        size = 8 * self.layout.study.size * sum(map(math.prod, shapes.values()))
        if size > MOST_MEMORY:
            raise ValueError(
                f"frames of {self.layout.study.size:,} runs take {size:,} bytes of memory, at most {MOST_MEMORY:,}; "
                "give a store that ends in .zarr, or leave frames out"
            )
        return {name: np.full((self.layout.study.size, *shape), np.nan) for name, shape in shapes.items()}

    def _record_frames(self, run: int, frames: Mapping[str, NDArray[np.float64]]) -> None:
        """Take over the frames of a run; where it ended early the rest is NaN."""
        for name, values in frames.items():
            self._frames[name][run, : len(values)] = values

    def _frame_variables(self) -> dict[str, Variable]:
        """Return the arrays of frames as variables."""
        study = self.layout.study
        return {
            name: Variable(
                (*study.dims, *(dim for dim, _ in dims)),
                self._frames[name].reshape(*study.shape, *(length for _, length in dims)),
                FRAME_ATTRS[name],
            )
            for name, dims in self.layout.frame_shapes.items()
        }


FRAME_ATTRS = {
    "time": {"long_name": "time of a frame", "units": "s"},
    "angle": {"long_name": "angle of a node around the channel's axis, 0 on the floor", "units": "rad"},
    "positions": {"long_name": "place of a node: x along the channel, z up, its axis at y = z = 0", "units": "m"},
}
"""Attributes of the arrays of frames."""
