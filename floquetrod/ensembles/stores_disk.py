"""What the stores of an ensemble on a disk share, and the simpler one: a single npz file, saved whole."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from floquetrod._util import sealed_files
from floquetrod._util.locks import Lock, lock_beside
from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.stores import MemoryStore, StoreLayout, require_same
from floquetrod.ensembles.variables import DONE, FAILED, PENDING
from floquetrod.ensembles.varied_axes import Design
from floquetrod.simulation.checkpoints import warn


class DiskStore(MemoryStore, ABC):
    """Results in memory, saved to a disk.

    While it is open for a part, a lock keeps every other from filling the same runs; it ends with the process.
    """

    def __init__(self, layout: StoreLayout, path: Path) -> None:
        """Begin with every run pending."""
        super().__init__(layout)
        self.path = path
        self._lock: Lock | None = None
        self._has_warned = False

    def open_part(self, chunks: range) -> None:
        """Keep others from writing these chunks, and take over what they wrote before.

        Raises ValueError when another process writes some of them.
        """
        if not chunks:
            return
        try:
            self._lock = self._locked(chunks)
        except BlockingIOError:
            raise ValueError(
                f"store {self.path} is being filled by another process, or another thread of this one; wait until it "
                "ends, or give each a store of its own, or its part=(k, n) of one that ends in .zarr"
            ) from None
        except OSError as error:  # not every file system has locks
            warn(f"store {self.path} cannot be locked ({error.strerror}): make sure that nothing else fills it")
        self._refresh(chunks)

    def close(self) -> None:
        """Release the lock."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def save(self) -> None:
        """Write new results, or warn once: the runs continue, and the next save tries again."""
        if self._dirty and self._succeeds(lambda: self._write(self._dirty)):
            self._dirty = set()

    def _succeeds(self, write: Callable[[], None]) -> bool:
        """Return whether something could be written; where not, warn the first time."""
        try:
            write()
        except (OSError, ValueError, MemoryError) as error:
            cause = getattr(error, "strerror", None) or str(error) or type(error).__name__
            if not self._has_warned:
                self._has_warned = True
                warn(
                    f"store {self.path} cannot be written ({cause}); the runs continue, their results are returned, "
                    "and writing is tried again until the end; to add what the store then lacks, remove the cause and "
                    "call fr.ensemble again with the same arguments"
                )
            return False
        return True

    @abstractmethod
    def _locked(self, chunks: range) -> Lock:
        """Return a lock of these chunks; BlockingIOError when another holds one of some of them."""

    @abstractmethod
    def _refresh(self, chunks: range) -> None:
        """Take over what others have written of these chunks."""

    @abstractmethod
    def _write(self, chunks: Iterable[int]) -> None:
        """Write chunks of results."""


class NpzStore(DiskStore):
    """Results in memory, saved to an npz file, whole.

    A file that another process has written meanwhile, where files cannot be locked, is taken over before the next save,
    not overwritten.
    """

    def __init__(self, layout: StoreLayout, path: Path, stored: Runs | None, known: tuple[int, ...] | None) -> None:
        """Begin, or continue with what was found in a file, which was known to be in this state before it was read."""
        super().__init__(layout, path)
        self._known = known
        if stored is not None:
            self._take_over(stored)

    def _locked(self, chunks: range) -> Lock:
        """Return a lock of the whole store."""
        return lock_beside(self.path)

    def _refresh(self, chunks: range) -> None:
        """Take over a file that is not the one last read or written here; ValueError for one of another study."""
        state = _state(self.path)
        if state is not None and state != self._known:
            stored = Runs.load(self.path)
            names = require_same(self.path, stored.attrs, self.layout.study, self.layout.frames)
            if names != self.layout.summary:
                raise ValueError(f"store {self.path} holds another study, with another summary; give another path")
            self._take_over(stored)
        self._known = state

    def _take_over(self, stored: Runs) -> None:
        """Take over the results in a file of the runs not done here."""
        shape, status = self.layout.study.shape, stored["status"].ravel()
        for name, values in (self.values | self._frames).items():
            theirs = stored.variables[name].values
            if theirs.shape != (*shape, *values.shape[1:]) or theirs.dtype != values.dtype:
                raise ValueError(f"store {self.path} holds {name} of shape {theirs.shape}; give another path")
        reasons = stored["reason"].ravel()
        new = np.where(self.values["status"] == FAILED, status == DONE, self.values["status"] == PENDING)
        for name, values in (self.values | self._frames).items():
            values[new] = stored[name].reshape(values.shape)[new]
        for run in np.flatnonzero(new).tolist():
            self.reasons.pop(run, None)
            if status[run] == FAILED:
                self.reasons[run] = str(reasons[run])

    def _write(self, chunks: Iterable[int]) -> None:
        """Write the file again."""
        self._refresh(range(0))
        self.runs().save(self.path)
        self._known = _state(self.path)


def _state(path: Path) -> tuple[int, ...] | None:
    """Return what changes when a file is written, None where there is none."""
    try:
        about = path.stat()
    except FileNotFoundError:
        return None
    return about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns


def open_store(
    place: Path, study: Design, frames: bool
) -> tuple[tuple[str, ...] | None, Callable[[StoreLayout], MemoryStore]]:
    """Return the names of the summary of a store, None where there is no store yet, and what opens it.

    Raises ValueError for a store of another study, and where none can be written.
    """
    sealed_files.writable(place)
    known = _state(place)
    stored = None if known is None else Runs.load(place)
    names = None if stored is None else require_same(place, stored.attrs, study, frames)
    return names, lambda layout: NpzStore(layout, place, stored, known)
