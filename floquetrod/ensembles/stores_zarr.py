"""A zarr store of an ensemble: written chunk by chunk, by many processes, read by others while it grows.

It is of zarr's format 2, whose types include text and whose consolidated metadata is part of the format.  Files of
chunks are written here: a file of that format is the compressed content of its array.  Each takes the place of an older
one at once, has a checksum, and counts as missing where that does not fit.
"""

from __future__ import annotations

import secrets
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from floquetrod.ensembles.axes import Study
from floquetrod.ensembles.runs import DONE, PENDING
from floquetrod.ensembles.stores import FRAME_ATTRS, REASON, Layout, MemoryStore, require_same

_ABANDONED = 3600.0  # s after which an unfinished creation was abandoned (a choice)
_LOCK = "status/.lock"  # where zarr does not look for arrays


class ZarrStore(MemoryStore):
    """Results in memory that are written to a zarr store chunk by chunk; frames are written as they come."""

    def __init__(self, layout: Layout, path: Path) -> None:
        """Create the store unless it exists, and take over what it holds."""
        super().__init__(layout)
        self.path = path
        self._codec = _codec()
        self._lock: IO[bytes] | None = None
        self._own = range(len(self.layout.starts))
        if not path.exists():
            self._create()
        for chunk in self._own:
            self._read(chunk)

    def open_part(self, chunks: range) -> None:
        """Lock these chunks; ValueError when another process writes some of them."""
        self._own = chunks
        if sys.platform == "win32" or not chunks:
            return
        import fcntl

        self._lock = (self.path / _LOCK).open("r+b")
        try:
            fcntl.lockf(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB, len(chunks), chunks.start)
        except (BlockingIOError, PermissionError):
            self.close()
            raise ValueError(
                f"store {self.path} is being filled by another process; wait for it, or give each its part=(k, n)"
            ) from None
        except OSError:  # not every file system has locks
            return
        for chunk in chunks:  # which another process may have written since it was read
            self._read(chunk)

    def close(self) -> None:
        """Release the lock."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def to_xarray(self) -> Any:
        """Return results from memory, those of other processes as the store has them, and frames as they are read."""
        import xarray

        for chunk in range(len(self.layout.starts)):
            if chunk not in self._own:
                self._read(chunk)
        found = self.runs().to_xarray()
        if self.layout.frames:
            found = found.assign(xarray.open_zarr(self.path, chunks=None)[list(self.layout.frame_shapes)].data_vars)
        return found

    def _write(self, chunks: Iterable[int]) -> None:
        """Write chunks of results, of each the status last."""
        for chunk in sorted(chunks):
            runs = self.layout.runs_of(range(chunk, chunk + 1))
            if reasons := {run: self.reasons[run] for run in runs if run in self.reasons}:
                text = np.full(len(runs), "", dtype=f"U{REASON}")
                text[[run - runs.start for run in reasons]] = list(reasons.values())
                self._write_chunk("reason", runs, text)
            for name in [*(name for name in self.values if name != "status"), "status"]:
                self._write_chunk(name, runs, self.values[name][runs.start : runs.stop])

    def _write_chunk(self, name: str, runs: range, values: NDArray[Any]) -> None:
        """Write the values of consecutive runs."""
        full = np.zeros(self.layout.chunk, dtype=values.dtype)  # chunks at an edge are filled up
        full[tuple(map(slice, self._extent(runs)))] = values.reshape(self._extent(runs))
        replace(self._file(name, runs.start), self._codec.encode(full.tobytes()))

    def _read(self, chunk: int) -> None:
        """Take over a chunk of results; where a file of it is missing or damaged its runs are pending."""
        runs = self.layout.runs_of(range(chunk, chunk + 1))
        part = slice(runs.start, runs.stop)
        found = {name: self._read_chunk(name, runs, values.dtype) for name, values in self.values.items()}
        for name, values in found.items():
            if values is not None:
                self.values[name][part] = values
        if any(values is None for values in found.values()):
            self.values["status"][part] = PENDING
        for run in runs:
            if self.values["status"][run] == DONE and not self._has_frames(run):
                self.values["status"][run] = PENDING
        text = self._read_chunk("reason", runs, np.dtype(f"U{REASON}"))
        if text is not None:
            self.reasons |= {runs.start + int(run): str(text[run]) for run in np.flatnonzero(text != "")}

    def _read_chunk(self, name: str, runs: range, dtype: Any) -> NDArray[Any] | None:
        """Return the values of consecutive runs, None where there is no such file or it is damaged."""
        try:
            content = self._codec.decode(self._file(name, runs.start).read_bytes())
            full = np.frombuffer(content, dtype=dtype).reshape(self.layout.chunk)
        except (OSError, RuntimeError, ValueError):
            return None
        return full[tuple(map(slice, self._extent(runs)))].ravel()

    def _extent(self, runs: range) -> tuple[int, ...]:
        """Return the shape of the runs of a chunk, less than that of a chunk at an edge."""
        first = np.unravel_index(runs.start, self.layout.study.shape)
        every = zip(self.layout.study.shape, first, self.layout.chunk, strict=True)
        return tuple(min(step, length - int(at)) for length, at, step in every)

    def _file(self, name: str, run: int, *more: int) -> Path:
        """Return the file of the chunk that begins with a run; ``more`` are its further numbers."""
        first = np.unravel_index(run, self.layout.study.shape)
        numbers = [int(at) // step for at, step in zip(first, self.layout.chunk, strict=True)]
        return self.path.joinpath(name, *map(str, [*numbers, *more]))

    def _room_for_frames(self) -> dict[str, NDArray[np.float64]]:
        """Return no arrays: frames are written as they come."""
        return {}

    def _frame_variables(self) -> dict[str, Any]:
        """Return no variables: `to_xarray` reads them from the store."""
        return {}

    def _keep_frames(self, run: int, frames: Mapping[str, NDArray[np.float64]]) -> None:
        """Write the frames of a run."""
        for name, file in self._frame_files(run).items():
            full = np.full([length for _, length in self.layout.frame_shapes[name]], np.nan)
            full[: len(frames[name])] = frames[name]
            replace(file, self._codec.encode(full.tobytes()))

    def _has_frames(self, run: int) -> bool:
        """Return whether all frames of a run are there and can be read, as far as they are asked for."""
        try:
            return all(self._codec.decode(file.read_bytes()) for file in self._frame_files(run).values())
        except (OSError, RuntimeError, ValueError):
            return False

    def _frame_files(self, run: int) -> dict[str, Path]:
        """Return the files of the frames of a run."""
        place = [str(int(number)) for number in np.unravel_index(run, self.layout.study.shape)]
        return {
            name: self.path.joinpath(name, *place, *["0"] * len(dims))
            for name, dims in self.layout.frame_shapes.items()
        }

    def _create(self) -> None:
        """Make the store beside its place and move it there; of several that do so at once, the first one's stays."""
        folder = self.path.parent
        if not folder.is_dir():
            raise ValueError(f"there is no folder {str(folder)!r} to write {self.path.name} to; make it first")
        for old in folder.glob(f".{self.path.name}.*.part"):
            with suppress(OSError):
                if time.time() - old.stat().st_mtime > _ABANDONED:
                    shutil.rmtree(old)
        target, self.path = self.path, folder / f".{self.path.name}.{secrets.token_hex(8)}.part"
        try:
            self._make_arrays()
            self.path.rename(target)
        except OSError as error:
            if not target.exists():
                raise ValueError(f"store {target} cannot be written: {error.strerror}; choose another") from None
        finally:
            shutil.rmtree(self.path, ignore_errors=True)
            self.path = target
        _, chunk, _ = open_store(target, self.layout.study, self.layout.frames, self.layout.chunk)
        if chunk != self.layout.chunk:
            raise ValueError(f"store {target} has been made with parts of other sizes meanwhile; begin again")

    def _make_arrays(self) -> None:
        """Write all metadata, coordinates, and the status of every run."""
        import zarr

        group = zarr.create_group(self.path, zarr_format=2, attributes=self.layout.about)
        study, chunk = self.layout.study, self.layout.chunk
        ones = (1,) * len(chunk)

        def add(name: str, dtype: Any, shape: Any, chunks: Any, dims: Any, attrs: Any) -> Any:
            """Add an array; one of numbers has no value that would stand for a missing one."""
            return group.create_array(
                name,
                shape=shape,
                chunks=chunks,
                dtype=dtype,
                fill_value=np.nan if np.dtype(dtype).kind == "f" else None,
                compressors=self._codec,
                chunk_key_encoding={"name": "v2", "separator": "/"},
                attributes={**attrs, "_ARRAY_DIMENSIONS": list(dims)},
            )

        for name, v in self.layout.coords.items():
            add(name, v.values.dtype, v.values.shape, v.values.shape, v.dims, v.attrs)[...] = v.values
        add("reason", f"U{REASON}", study.shape, chunk, study.dims, self.layout.attrs("reason"))
        for name, kind in self.layout.kinds.items():
            add(name, kind.dtype, study.shape, chunk, study.dims, self.layout.attrs(name))
        for name, dims in self.layout.frame_shapes.items():
            names, lengths = zip(*dims, strict=True)
            shape = (*study.shape, *lengths)
            add(name, np.float64, shape, (*ones, *lengths), (*study.dims, *names), FRAME_ATTRS[name])
        (self.path / _LOCK).touch()
        for number in range(len(self.layout.starts)):
            runs = self.layout.runs_of(range(number, number + 1))
            self._write_chunk("status", runs, self.values["status"][runs.start : runs.stop])
        zarr.consolidate_metadata(self.path)


def _codec() -> Any:
    """Return what compresses chunks and knows damaged ones."""
    import numcodecs

    return numcodecs.Zstd(level=1, checksum=True)


def replace(path: Path, content: bytes) -> None:
    """Write a file that takes the place of an older one once it is complete.

    It is not flushed to the disk: what a loss of power destroys has no valid checksum, and is computed again.
    """
    part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        part.write_bytes(content)
    except OSError:
        part.unlink(missing_ok=True)
        raise
    part.replace(path)


def open_store(
    place: Path, study: Study, frames: bool, chunk: tuple[int, ...]
) -> tuple[tuple[str, ...] | None, tuple[int, ...], Callable[[Layout], MemoryStore]]:
    """Return the names of the summary of a store, None where there is no store yet, its chunks, and what opens it.

    Raises ValueError for a store of another study, ImportError without the extra.
    """
    try:
        import xarray  # noqa: F401
        import zarr
    except ImportError as error:
        raise ImportError(
            f"a store that ends in .zarr needs {error.name}: pip install floquetrod[ensemble], or give one that ends "
            "in .npz"
        ) from None

    def make(layout: Layout) -> MemoryStore:
        return ZarrStore(layout, place)

    if not place.exists():
        return None, chunk, make
    try:
        group: Any = zarr.open_group(place, mode="r")
        attrs, chunks = dict(group.attrs), group["status"].chunks
    except Exception:  # whatever zarr raises for what it cannot read
        raise ValueError(f"store {place} is not one of fr.ensemble; give another path") from None
    return require_same(place, attrs, study, frames), tuple(map(int, chunks)), make
