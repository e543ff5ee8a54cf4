"""Checkpoints: files with which a simulation continues bit for bit."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import sealed_files
from floquetrod._util.calling import level_of_caller
from floquetrod._util.locks import Lock, lock_beside
from floquetrod._util.version import __version__
from floquetrod.simulation.arithmetic import arithmetic
from floquetrod.simulation.recorded_motion import RecordedMotion
from floquetrod.simulation.rod_mesh import ENERGIES
from floquetrod.simulation.step_size import TimeSteps

_FORMAT = "floquetrod checkpoint 4"
_SECONDS_BETWEEN = 5.0  # of wall time, between saves (a choice)
_QUICK_SAVE = 0.25  # s: after one that takes longer, the next is put off as many times longer (a choice)


class CheckpointWarning(UserWarning):
    """A checkpoint could not be written; the run continues, and its frames are kept in memory.

    Where warnings are errors, this one is raised at the end alone: ``simulation`` is then the result that `simulate`
    would have returned.
    """

    def __init__(self, message: str, simulation: Any = None) -> None:
        """Keep the result, if there is one yet."""
        super().__init__(message)
        self.simulation = simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle of both arguments."""
        return type(self), (str(self), self.simulation)


class RunState(NamedTuple):
    """A run under way: record of the rod now and one piece of steps earlier, frames so far, wall time in s."""

    rod: Any
    before: Any
    frames: dict[str, NDArray[np.float64]]
    seconds: float


class Resumable(NamedTuple):
    """What the content of a file is checked against.

    The segments, record type and time steps of the run, the steps there may be between its two records, and what
    computes them.
    """

    segments: int
    layout: np.dtype[np.void]
    time_steps: TimeSteps
    most_steps: int
    advance: Callable[[Any, int], Any]

    def record(self, arrays: Mapping[str, NDArray[Any]], name: str) -> Any:
        """Return the record of the rod that a file holds under ``name``."""
        layout = self.layout
        (rod,) = np.frombuffer(bytearray(sealed_files.field(arrays, name, np.uint8, (layout.itemsize,))), dtype=layout)
        clock = float(rod["clock"][0])
        if not (0.0 <= clock <= self.time_steps.count and clock == int(clock)):
            raise ValueError(f"the clock of its {name} shows {clock!r} steps")
        return rod

    def other_rounding(self, before: Any, rod: Any) -> str:
        """Return why a record does not follow from the one ``before`` here, "" where it does.

        The arithmetic is the same, but a processor or a system's library may differ in a last digit.
        """
        steps, repeated = int(rod["clock"][0]) - int(before["clock"][0]), before.copy()
        self.advance(repeated, steps)
        if repeated.tobytes() == rod.tobytes():
            return ""
        return f"its last {steps} steps come out otherwise; continue it on the machine that wrote it"

    def frames(self, arrays: Mapping[str, NDArray[Any]], rod: Any) -> dict[str, NDArray[np.float64]]:
        """Return the frames that a file holds, as many as the clock of its record says."""
        count = int(rod["clock"][0]) // self.time_steps.per_frame + 1
        return {
            name: sealed_files.field(arrays, name, np.float64, (count, *shape), finite=True)
            for name, shape in frame_shapes(self.segments).items()
        }


def other_arithmetic(theirs: Mapping[str, str]) -> str:
    """Return why a run computed with an arithmetic cannot be continued with this machine's, "" where it can."""
    ours = arithmetic()
    other = [f"{name} {value}" for name, value in theirs.items() if ours.get(name) != value]
    return f"it was computed with {', '.join(other)}; continue it where that is installed" if other else ""


def frame_shapes(segments: int) -> dict[str, tuple[int, ...]]:
    """Return the arrays that a frame consists of, with their shapes."""
    return {
        "positions": (segments + 1, 3),
        "velocities": (segments + 1, 3),
        "energies": (len(ENERGIES),),
        "impulses": (2,),
    }


class Checkpoint:
    """The file of one run, and a context in which no other run may use it, which ends with the process at the latest.

    Parameters
    ----------
    path : Path
        ValueError, before anything is computed, when nothing can be written there.
    identity : mapping
        Plain data that distinguishes the run from every other.
    """

    def __init__(self, path: Path, identity: Mapping[str, Any]) -> None:
        """Make sure that the file can be written."""
        self.path = sealed_files.writable(path)
        self._identity = dict(identity)
        self._due = 0.0
        self._lock: Lock | None = None

    def __enter__(self) -> Checkpoint:
        """Keep others from the file; ValueError when another run uses it."""
        try:
            self._lock = lock_beside(self.path)
        except BlockingIOError:
            raise ValueError(
                f"checkpoint {self.path} is in use by another simulation, in another process or another thread of this "
                "one; wait until that ends, or give another path"
            ) from None
        except OSError as error:  # not every file system has locks
            warn(f"checkpoint {self.path} cannot be locked ({_cause(error)}): make sure that no other run uses it")
        return self

    def __exit__(self, *error: object) -> None:
        """Let others use the file."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def exists(self) -> bool:
        """Return whether there is something to continue from."""
        return self.path.exists()

    def start_clock(self) -> None:
        """Count the time to the first save from now."""
        self._due = time.monotonic() + _SECONDS_BETWEEN

    def save_when_due(self, state: Callable[[], RunState]) -> None:
        """Save from time to time, or warn: slow saves become rare, so that they take little of a run's time."""
        now = time.monotonic()
        if now < self._due:
            return
        try:
            self._save(state())
        except (OSError, ValueError, MemoryError) as error:
            warn(f"checkpoint {self.path} cannot be written ({_cause(error)}); the run continues, and tries again")
        took = time.monotonic() - now
        self._due = now + took + _SECONDS_BETWEEN * max(1.0, took / _QUICK_SAVE)

    def save_at_the_end(self, state: RunState, result: RecordedMotion) -> None:
        """Save, or warn, also on Ctrl-C: the result exists and must be returned."""
        try:
            self._save(state)
        except (OSError, ValueError, MemoryError, KeyboardInterrupt) as error:
            text = f"checkpoint {self.path} has not been brought up to date ({_cause(error)}); the result is in memory"
            warnings.warn(CheckpointWarning(text, result), stacklevel=level_of_caller())

    def _save(self, state: RunState) -> None:
        """Write the file."""
        meta = {
            "format": _FORMAT,
            "version": __version__,
            "arithmetic": arithmetic(),
            "problem": self._identity,
            "seconds": state.seconds,
        }
        records = {"state": state.rod, "before": state.before}
        arrays = {name: np.frombuffer(rod.tobytes(), np.uint8) for name, rod in records.items()}
        sealed_files.write_npz(self.path, meta, arrays | state.frames, compress=False)

    def load(self, expected: Resumable) -> RunState:
        """Return the state that the file holds.

        Raises ValueError, with a remedy, when it is damaged, of another format or another run, or cannot be continued
        bit for bit here.
        """
        remedy = "or remove it to start again"
        try:
            foreign, state = sealed_files.read_npz(
                self.path, _FORMAT, "a checkpoint of a simulation", lambda *content: self._read(expected, *content)
            )
        except ValueError as error:
            raise ValueError(f"{error}; give another path, {remedy}") from error.__cause__
        if state is None:
            raise ValueError(f"checkpoint {self.path} {foreign}, {remedy}")
        return state

    def _read(
        self, expected: Resumable, meta: dict[str, Any], arrays: sealed_files.Arrays
    ) -> tuple[str, RunState | None]:
        """Return why the content is not for this run, or the state it holds."""
        unlike = f"of floquetrod {sealed_files.entry(meta, 'version', str)} cannot be continued bit for bit here"
        if other := other_arithmetic(sealed_files.entry(meta, "arithmetic", dict)):
            return f"{unlike}: {other}", None
        mine, its = self._identity, sealed_files.entry(meta, "problem", dict)
        if wrong := [name for name in {**mine, **its} if its.get(name) != mine.get(name)]:
            return f"belongs to another run, with another {', '.join(wrong)}; give another path", None
        before, rod = (expected.record(arrays, name) for name in ("before", "state"))
        frames = expected.frames(arrays, rod)
        steps = int(rod["clock"][0]) - int(before["clock"][0])
        if not 0 <= steps <= expected.most_steps:
            raise ValueError("its states do not follow one another")
        if other := expected.other_rounding(before, rod):
            return f"{unlike}: {other}", None
        return "", RunState(rod, before, frames, sealed_files.entry(meta, "seconds", float))


def warn(text: str) -> None:
    """Warn the caller of the package of what must not end a run."""
    with suppress(CheckpointWarning):  # raised where warnings are errors: a run is worth more
        warnings.warn(CheckpointWarning(text), stacklevel=level_of_caller())


def _cause(error: BaseException) -> str:
    """Return why a save failed, in a few words."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
