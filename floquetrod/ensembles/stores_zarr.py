"""A zarr store of an ensemble: written chunk by chunk, by many processes, read by others while it grows.

It is of zarr's format 2, whose types include text and whose consolidated metadata is part of the format.  Files of
chunks are written here: a file of that format is the compressed content of its array.  Each takes the place of an older
one at once, has a checksum, and counts as missing where that does not fit.  The checksum covers the place in the store,
too, and the store's identity; it follows the compressed content in a frame that readers skip.

zarr 3.1 writes whole files, too, and passes the tests of kills, Ctrl-C and full disks.  It fails two of
test_ensemble_stores.py: a lost chunk reads as fill values (::test_damaged_chunks_are_computed_again), and one from
another place or store is taken for the right one (::test_chunks_that_change_places_are_computed_again).
"""

from __future__ import annotations

import hashlib
import json
import math
import secrets
import shutil
import struct
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import interrupt
from floquetrod._util.locks import Lock
from floquetrod.ensembles import stores
from floquetrod.ensembles.stores import FRAME_ATTRS, REASON, MemoryStore, StoreLayout, require_same
from floquetrod.ensembles.stores_disk import DiskStore
from floquetrod.ensembles.variables import DONE, FAILED, PENDING
from floquetrod.ensembles.varied_axes import Design

_ABANDONED = 3600.0  # s after which a creation that takes a second has been killed
_SEAL = struct.pack("<II", 0x184D2A50, hashlib.sha256().digest_size)
"""Head of a frame that decoders of Zstandard skip, RFC 8878, 3.1.2: its magic number and the length of its content."""

_LOCK = "status/.lock"  # where zarr does not look for arrays


class ZarrStore(DiskStore):
    """Results in memory, written to a zarr store chunk by chunk; frames are written as they come."""

    def __init__(self, layout: StoreLayout, path: Path) -> None:
        """Create the store unless it exists, and take over what it holds."""
        super().__init__(layout, path)
        self._codec = _codec()
        about = layout.about
        self._identity = json.dumps([about["study"], about["summary"], layout.chunk], sort_keys=True).encode()
        self._own = range(len(self.layout.starts))
        self._waiting: dict[int, Mapping[str, NDArray[np.float64]]] = {}  # frames that could not be written
        if not path.exists():
            with interrupt.held():
                self._create()
        self._succeeds(self._write_known)
        self._refresh(self._own)

    def open_part(self, chunks: range) -> None:
        """Do as every store on a disk, and note which chunks are written here."""
        self._own = chunks
        super().open_part(chunks)

    def save(self) -> None:
        """Write new results and waiting frames, or warn once."""
        for run, frames in list(self._waiting.items()):
            if frames and self._succeeds(partial(self._write_frames, run, frames)):
                del self._waiting[run]
                self._mark(run)
        super().save()

    def to_xarray(self) -> Any:
        """Return results from memory, results of other processes from the store, and frames, read when needed."""
        for chunk in range(len(self.layout.starts)):
            if chunk not in self._own:
                self._read(chunk)
        dataset = self.runs().to_xarray()
        return dataset.assign(self._stored_frames().data_vars) if self.layout.frames else dataset

    def _stored_frames(self) -> Any:
        """Return the frames as the store has them; where some could not be written and there is room, all in memory."""
        import xarray

        names = list(self.layout.frame_shapes)
        others = [name for name in (*self.layout.coords, *self.values, "reason") if name not in names]
        dataset = xarray.open_zarr(self.path, chunks=None, drop_variables=others)[names]
        if not self._waiting or dataset.nbytes > stores.MOST_MEMORY:
            return dataset
        dataset = dataset.load()
        for run, frames in self._waiting.items():
            place = tuple(map(int, np.unravel_index(run, self.layout.study.shape)))
            for name, values in frames.items():
                dataset[name].values[place][: len(values)] = values
        return dataset

    def _locked(self, chunks: range) -> Lock:
        """Return a lock of these chunks."""
        return Lock(self.path / _LOCK, chunks, remove=False)

    def _refresh(self, chunks: range) -> None:
        """Take over what the store has of these chunks."""
        for chunk in chunks:
            self._read(chunk)

    def _write(self, chunks: Iterable[int]) -> None:
        """Write chunks of results, of each the status last."""
        for chunk in sorted(chunks):
            runs = self.layout.runs_of(range(chunk, chunk + 1))
            reasons = {run: self.reasons[run] for run in runs if run in self.reasons}
            if reasons or self._file("reason", runs.start).exists():  # of runs that had failed
                text = np.full(len(runs), "", dtype=f"U{REASON}")
                text[[run - runs.start for run in reasons]] = list(reasons.values())
                self._write_chunk("reason", runs, text)
            for name in (name for name in self.values if name != "status"):
                self._write_chunk(name, runs, self.values[name][runs.start : runs.stop])
            status = [PENDING if run in self._waiting else self.values["status"][run] for run in runs]
            self._write_chunk("status", runs, np.array(status, dtype=self.values["status"].dtype))

    def _write_chunk(self, name: str, runs: range, values: NDArray[Any]) -> None:
        """Write the values of consecutive runs."""
        full = np.zeros(self.layout.chunk, dtype=values.dtype)  # chunks at an edge are filled up
        full[tuple(map(slice, self._extent(runs)))] = values.reshape(self._extent(runs))
        self._write_sealed(self._file(name, runs.start), full.tobytes())

    def _read(self, chunk: int) -> None:
        """Take over a chunk of results; where a file of it is missing or damaged its runs are pending."""
        runs = self.layout.runs_of(range(chunk, chunk + 1))
        part = slice(runs.start, runs.stop)
        columns = {name: self._read_chunk(name, runs, values.dtype) for name, values in self.values.items()}
        for name, values in columns.items():
            if values is not None:
                self.values[name][part] = values
        if any(values is None for values in columns.values()):
            self.values["status"][part] = PENDING
        text = self._read_chunk("reason", runs, np.dtype(f"U{REASON}"))
        for place, run in enumerate(runs):
            status = self.values["status"][run]
            self.reasons.pop(run, None)
            if status == FAILED and text is not None and text[place]:
                self.reasons[run] = str(text[place])
            elif status == FAILED or (status == DONE and not self._has_frames(run)):
                self.values["status"][run] = PENDING

    def _read_chunk(self, name: str, runs: range, dtype: Any) -> NDArray[Any] | None:
        """Return the values of consecutive runs, None where there is no such file or it is damaged."""
        size = math.prod(self.layout.chunk) * np.dtype(dtype).itemsize
        content = self._read_sealed(self._file(name, runs.start), size)
        if content is None:
            return None
        full = np.frombuffer(content, dtype=dtype).reshape(self.layout.chunk)
        return full[tuple(map(slice, self._extent(runs)))].ravel()

    def _write_sealed(self, file: Path, content: bytes) -> None:
        """Write a chunk, compressed, and after it the checksum of its content, its place and the store's identity."""
        packed = bytes(self._codec.encode(content))
        replace(file, packed + _SEAL + self._seal(file, packed))

    def _read_sealed(self, file: Path, size: int) -> bytes | None:
        """Return the content of a chunk, of a size in bytes, None where it is missing, damaged or belongs elsewhere."""
        try:
            written = file.read_bytes()
        except OSError:
            return None
        packed = written[: max(len(written) - len(_SEAL) - hashlib.sha256().digest_size, 0)]
        return self._decoded(packed, size) if written[len(packed) :] == _SEAL + self._seal(file, packed) else None

    def _decoded(self, packed: bytes, size: int) -> bytes | None:
        """Return what was compressed, None where it is damaged or has more bytes, whatever it claims."""
        content = np.empty(size, np.uint8)
        try:
            self._codec.decode(packed, out=content)
        except (RuntimeError, ValueError):
            return None
        return content.tobytes()

    def _seal(self, file: Path, packed: bytes) -> bytes:
        """Return the checksum of a chunk: of its compressed content, its place, and the identity of its store."""
        place = file.relative_to(self.path).as_posix().encode()
        parts = (self._identity, place, packed)
        return hashlib.sha256(b"".join(len(part).to_bytes(8, "little") + part for part in parts)).digest()

    def _extent(self, runs: range) -> tuple[int, ...]:
        """Return the shape of the runs of a chunk, cut off at the edges of the axes."""
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

    def _record_frames(self, run: int, frames: Mapping[str, NDArray[np.float64]]) -> None:
        """Write the frames of a run; where they cannot be written they wait, as far as memory is for them."""
        if not self._succeeds(partial(self._write_frames, run, frames)):
            size = 8 * sum(math.prod(length for _, length in dims) for dims in self.layout.frame_shapes.values())
            self._waiting[run] = frames if size * (len(self._waiting) + 1) <= stores.MOST_MEMORY else {}

    def _write_frames(self, run: int, frames: Mapping[str, NDArray[np.float64]]) -> None:
        """Write the frames of a run."""
        for name, file in self._frame_files(run).items():
            full = np.full([length for _, length in self.layout.frame_shapes[name]], np.nan)
            full[: len(frames[name])] = frames[name]
            self._write_sealed(file, full.tobytes())

    def _has_frames(self, run: int) -> bool:
        """Return whether all arrays of frames of a run exist and can be read."""
        sizes = {name: 8 * math.prod(length for _, length in dims) for name, dims in self.layout.frame_shapes.items()}
        return all(self._read_sealed(file, sizes[name]) is not None for name, file in self._frame_files(run).items())

    def _frame_files(self, run: int) -> dict[str, Path]:
        """Return the files of the frames of a run."""
        place = [str(int(number)) for number in np.unravel_index(run, self.layout.study.shape)]
        return {
            name: self.path.joinpath(name, *place, *["0"] * len(dims))
            for name, dims in self.layout.frame_shapes.items()
        }

    def _write_known(self) -> None:
        """Write what does not depend on runs, metadata and coordinates, where a file is missing or differs."""
        for path, content in self._metadata().items():
            if not _is_json(self.path / path, content):
                replace(self.path / path, content)
        for name, v in self.layout.coords.items():
            file = self.path.joinpath(name, *["0"] * len(v.dims))
            content, stored = v.values.tobytes(), None
            with suppress(OSError):
                stored = self._decoded(file.read_bytes(), len(content))
            if stored != content:
                replace(file, self._codec.encode(content))

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
            self._write_known()
            for number in range(len(self.layout.starts)):
                runs = self.layout.runs_of(range(number, number + 1))
                self._write_chunk("status", runs, self.values["status"][runs.start : runs.stop])
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

    def _metadata(self) -> dict[str, bytes]:
        """Return the files that describe the arrays, by their paths in the store."""
        import zarr

        files: dict[str, Any] = {}
        store = zarr.storage.MemoryStore(files)
        group = zarr.create_group(store, zarr_format=2, attributes=self.layout.about)
        study, chunk = self.layout.study, self.layout.chunk
        ones = (1,) * len(chunk)

        def add(name: str, dtype: Any, shape: Any, chunks: Any, dims: Any, attrs: Any) -> None:
            """Add an array; one of numbers has no value that would stand for a missing one."""
            group.create_array(
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
            add(name, v.values.dtype, v.values.shape, v.values.shape, v.dims, v.attrs)
        add("reason", f"U{REASON}", study.shape, chunk, study.dims, self.layout.attrs("reason"))
        for name, kind in self.layout.kinds.items():
            add(name, kind.dtype, study.shape, chunk, study.dims, self.layout.attrs(name))
        for name, dims in self.layout.frame_shapes.items():
            names, lengths = zip(*dims, strict=True)
            shape = (*study.shape, *lengths)
            add(name, np.float64, shape, (*ones, *lengths), (*study.dims, *names), FRAME_ATTRS[name])
        zarr.consolidate_metadata(store)
        return {name: content.to_bytes() for name, content in files.items()}


def _is_json(file: Path, content: bytes) -> bool:
    """Return whether a file holds what this JSON says."""
    try:
        return bool(json.loads(file.read_bytes()) == json.loads(content))
    except (OSError, ValueError, RecursionError):
        return False


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
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def open_store(
    place: Path, study: Design, frames: bool, chunk: tuple[int, ...]
) -> tuple[tuple[str, ...] | None, tuple[int, ...], Callable[[StoreLayout], MemoryStore]]:
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

    make = partial(ZarrStore, path=place)
    if not place.exists():
        return None, chunk, make
    try:
        group: Any = zarr.open_group(place, mode="r")
        attrs, chunks = dict(group.attrs), tuple(map(int, group["status"].chunks))
    except Exception:  # whatever zarr raises for what it cannot read
        raise ValueError(f"store {place} is not one of fr.ensemble; give another path") from None
    names = require_same(place, attrs, study, frames)
    if not _are_ranges(chunks, study.shape):
        raise ValueError(f"store {place} has damaged metadata; give another path")
    return names, chunks, make


def _are_ranges(chunk: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    """Return whether chunks of this shape are contiguous ranges of runs, as `chunk_shape` makes them."""
    if len(chunk) != len(shape) or not all(1 <= step <= length for step, length in zip(chunk, shape, strict=True)):
        return False
    partial = next((place for place, step in enumerate(chunk) if step > 1), len(chunk) - 1)
    return chunk[partial + 1 :] == shape[partial + 1 :]
