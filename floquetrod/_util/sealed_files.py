"""Files written atomically, and checksummed npz files of arrays with a description.

A save writes a temporary file (a part) beside its target, flushes it to the disk and renames it to the target.  The
writer of a part holds a lock on it, which ends with the process however that ends: a part without a lock has been
abandoned, and the next save into the folder removes it.
"""

from __future__ import annotations

import copy
import errno
import hashlib
import json
import math
import os
import re
import secrets
import stat
import sys
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.example_files import where_to_get

Result = TypeVar("Result")

_LARGEST = 1 << 33  # bytes of a file, and of its arrays, that are read (a choice)
_LARGEST_DESCRIPTION = 1 << 28  # bytes, of the JSON beside the arrays (a choice)
_MOST_UNFOLDED = 1032  # bytes that one byte of deflate can stand for: 258 in two bits
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_PART = re.compile(r"\.floquetrod-[0-9a-f]{16}\.part")
_SEAL = b"sha256:"
_SEALED = len(_SEAL) + 2 * hashlib.sha256().digest_size
_CLOSED_FIRST = sys.platform == "win32"  # which does not rename a file that is open
_CLOSED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR)  # of a folder that takes no file
_BINARY = getattr(os, "O_BINARY", 0)  # exists on Windows only


def writable(path: str | Path) -> Path:
    """Return ``path`` after checking that a file can be written there, before the work whose result it will hold.

    Raises ValueError when its folder is missing or closed, or when it is a folder, a device or write-protected.
    """
    path = validate.path("path", path)
    folder = _target(path).parent
    try:
        handle, part = _new_part(folder, 0o600)
    except OSError as error:
        raise ValueError(f"{path} cannot be written: {error.strerror} (folder {folder}); choose another") from None
    os.close(handle)
    part.unlink(missing_ok=True)
    return path


def require_regular(path: Path, largest: int | None = None) -> None:
    """Raise ValueError unless a path to be read is a regular file, of no more than ``largest`` bytes.

    Opening a pipe may wait for ever.
    """
    try:
        about = path.stat()
    except FileNotFoundError:
        raise ValueError(f"there is no such file{where_to_get(path.name)}") from None
    if not stat.S_ISREG(about.st_mode):
        raise ValueError("it is a folder or a device, or a pipe; name a file")
    if largest is not None and about.st_size > largest:
        raise ValueError(f"it has {about.st_size:,} bytes, at most {largest:,} are read")


@contextmanager
def atomic_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for writing that takes the place of ``path`` once it is complete and on the disk.

    Until then the old one stays.  Symbolic links are followed; an older file's permissions are kept.  Raises ValueError
    where nothing can be written there, OSError where a disk fails.
    """
    target = _target(path)
    # The part must not be readable by anyone who may not read the target; the system sets the rights of a new file.
    try:
        handle, part = _new_part(target.parent, 0o600 if target.exists() else 0o666)
    except OSError as error:
        if error.errno in _CLOSED:
            where = f"{path}: {error.strerror} (folder {target.parent})"
            raise validate.wrong_value("path", f"must be in a folder that can be written, got {where}") from None
        raise
    try:
        with os.fdopen(handle, "w+b") as file:
            yield file
            file.flush()
            _take_rights(part, target)
            os.fsync(file.fileno())
            if not _CLOSED_FIRST:  # else the lock would end before the part is in its place
                part.replace(target)
        if _CLOSED_FIRST:
            part.replace(target)
        _flush_folder(target.parent)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def _target(path: Path) -> Path:
    """Return the file that ``path`` names, links followed; ValueError when it cannot be written."""
    target = Path(os.path.realpath(path))
    try:
        mode = target.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        if not target.parent.is_dir():
            folder = target.parent if path.parent.is_dir() else path.parent
            raise ValueError(f"there is no folder {str(folder)!r} to write {path.name} to; make it first") from None
        return target
    except OSError as error:
        raise ValueError(f"{path} cannot be written: {error.strerror}; choose another") from None
    if stat.S_ISDIR(mode):
        raise ValueError(f"{path} is a folder; name a file in it")
    if not stat.S_ISREG(mode):
        raise ValueError(f"{path} is a device or a pipe; name a file")
    if not os.access(target, os.W_OK):
        raise ValueError(f"{path} is write-protected; change its permissions or choose another file")
    return target


def _new_part(folder: Path, mode: int) -> tuple[int, Path]:
    """Return handle and path of a new file in ``folder``, locked, after clearing away abandoned ones."""
    _remove_abandoned(folder)
    while True:
        part = folder / f".floquetrod-{secrets.token_hex(8)}.part"
        handle = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, mode)
        # Before it was locked, another process may have taken it for abandoned.
        if _locked(handle) is not False and part.exists():
            return handle, part
        os.close(handle)


def _remove_abandoned(folder: Path) -> None:
    """Remove the parts that killed processes left behind; others, and where locks say nothing, stay."""
    with suppress(OSError):
        for path in folder.iterdir():
            if not _PART.fullmatch(path.name):
                continue
            with suppress(OSError):  # it is another user's, or has gone meanwhile
                handle = os.open(path, os.O_RDWR | _BINARY)
                try:
                    if _locked(handle):
                        path.unlink()
                finally:
                    os.close(handle)


def _locked(handle: int) -> bool | None:
    """Lock an open file until it is closed; False when another holds it, None where files cannot be locked."""
    if sys.platform == "win32":
        return None
    import fcntl

    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return False if error.errno in (errno.EWOULDBLOCK, errno.EACCES) else None
    return True


def _take_rights(part: Path, target: Path) -> None:
    """Give a part the owner and the permissions of the file that it will replace, if there is one."""
    try:
        old = target.stat()
    except FileNotFoundError:
        return
    if sys.platform != "win32":
        for owner in ((-1, old.st_gid), (old.st_uid, -1)):
            with suppress(OSError):  # only the administrator may give files away
                os.chown(part, *owner)
    part.chmod(stat.S_IMODE(old.st_mode))


def _flush_folder(folder: Path) -> None:
    """Write a folder's entries to the disk, where the system can."""
    with suppress(OSError):  # the file is in its place and on the disk: there is nothing more to do
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def write_npz(path: str | Path, meta: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], *, compress: bool) -> Path:
    """Write arrays and a description to an npz file; an older file of that name stays whole until the new one is.

    The comment at the end of the archive is a checksum of every byte before it.
    """
    path = validate.path("path", path)
    content = {"meta": np.array(json.dumps(meta)), **arrays}
    size = sum(array.nbytes for array in content.values())
    if size > _LARGEST:
        raise ValueError(f"{path} would hold {size:,} bytes, at most {_LARGEST:,} are written and read; save less")
    method = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    with atomic_file(path) as file:
        with zipfile.ZipFile(file, "w") as archive:
            archive.comment = bytes(_SEALED)  # room for the checksum
            for name, array in content.items():
                member = zipfile.ZipInfo(f"{name}.npy")  # with a fixed date: the same content makes the same file
                member.compress_type = method
                with archive.open(member, "w", force_zip64=True) as stream:
                    np.lib.format.write_array(stream, np.asanyarray(array), version=(1, 0), allow_pickle=False)
        seal = _seal(file)
        file.seek(-_SEALED, os.SEEK_END)
        file.write(seal)
    return path


def _seal(file: IO[bytes]) -> bytes:
    """Return the checksum over a file except for its own place at the end."""
    left = file.seek(0, os.SEEK_END) - _SEALED
    file.seek(0)
    digest = hashlib.sha256()
    while left > 0 and (block := file.read(min(left, 1 << 20))):
        digest.update(block)
        left -= len(block)
    return _SEAL + digest.hexdigest().encode()


def read_npz(
    path: str | Path, file_format: str, what: str, build: Callable[[dict[str, Any], Arrays], Result]
) -> Result:
    """Return ``build(description, arrays)`` of a file that `write_npz` wrote with this ``meta["format"]``.

    Raises ValueError, saying that the file is not ``what``, for a damaged or foreign file, and for errors of ``build``.
    """
    path = validate.path("path", path)
    if not path.exists():
        raise ValueError(f"{path} is not {what} that can be read: there is no such file")
    try:
        with _opened(path) as (meta, arrays):
            if meta["format"] != file_format:
                raise ValueError(
                    f"its format is {meta['format']!r}, not {file_format!r}: it is of another kind or version"
                )
            return build(meta, arrays)
    except Exception as error:  # any error while reading means that the file is not one of ours
        cause = f"it has no {error}" if isinstance(error, KeyError) else error
        raise ValueError(f"{path} is not {what} that can be read: {cause}") from error


@contextmanager
def _opened(path: Path) -> Iterator[tuple[dict[str, Any], Arrays]]:
    """Open a sealed file; yield its description, and its arrays, still unread except for their headers."""
    require_regular(path, _LARGEST)
    with path.open("rb") as file:
        seal = _seal(file)
        if not (stored := file.read()).startswith(_SEAL):
            raise ValueError("it has no checksum: it is damaged, foreign, or of a version before checksums")
        if stored != seal:
            raise ValueError("its checksum does not fit: it is damaged")
        with Arrays.opened(file, path.stat().st_size) as arrays:
            if arrays.size > _LARGEST:
                raise ValueError(f"it holds more than {_LARGEST:,} bytes")
            header = arrays.headers["meta"]
            if header.size > _LARGEST_DESCRIPTION:
                raise ValueError(f"its description has more than {_LARGEST_DESCRIPTION:,} bytes")
            meta = json.loads(str(field(arrays, "meta", header.dtype, ())[()]))
            if not isinstance(meta, dict):
                raise ValueError("its description is none")
            yield meta, arrays


class _Header(NamedTuple):
    """An array's header in an npz file."""

    member: zipfile.ZipInfo
    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]
    start: int  # of its content, bytes from the beginning of the member

    @property
    def size(self) -> int:
        """Bytes of the content."""
        return math.prod(self.shape) * self.dtype.itemsize


class Arrays(Mapping[str, NDArray[Any]]):
    """The arrays of an npz file by name, each read on access; `headers` has their shapes and types before.

    False claims cost no memory: headers and directory must agree with each other and with the length of the file.
    """

    def __init__(self, archive: zipfile.ZipFile, length: int) -> None:
        """Read the headers of an archive of a length in bytes; ValueError where they cannot be right."""
        members = archive.infolist()
        for member in members:
            if not member.filename.endswith(".npy"):
                raise ValueError(f"{member.filename!r} is no array")
            if member.compress_size > length or member.file_size > _MOST_UNFOLDED * member.compress_size:
                raise ValueError(f"{member.filename} claims more than a file of {length:,} bytes can hold")
        self._archive = archive
        self.headers = {member.filename.removesuffix(".npy"): _header(archive, member) for member in members}
        if len(self.headers) != len(members):
            raise ValueError("it holds two arrays of one name")

    def under(self, prefix: str) -> Arrays:
        """Return the arrays whose names begin with a prefix, by the rest of their names."""
        below = copy.copy(self)
        below.headers = {n.removeprefix(prefix): header for n, header in self.headers.items() if n.startswith(prefix)}
        return below

    @classmethod
    @contextmanager
    def opened(cls, file: IO[bytes] | Path, length: int) -> Iterator[Arrays]:
        """Open an npz file of a length in bytes."""
        with zipfile.ZipFile(file) as archive:
            yield cls(archive, length)

    @property
    def size(self) -> int:
        """Bytes of all arrays with their headers."""
        return sum(header.member.file_size for header in self.headers.values())

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Read an array; memory is allocated once, and only used as far as there is content."""
        header = self.headers[name]
        array = np.ndarray(header.shape, header.dtype, order="F" if header.fortran else "C")
        with self._archive.open(header.member) as stream:
            stream.read(header.start)
            left: memoryview = memoryview(array.reshape(-1, order="A").view(np.uint8).data)
            while left and (block := stream.read(min(len(left), 1 << 20))):
                left[: len(block)] = block
                left = left[len(block) :]
            if left or stream.read(1):
                raise ValueError(f"{header.member.filename} is not what its header says")
        return array

    def __contains__(self, name: object) -> bool:
        """Return whether there is an array of this name, without reading it."""
        return name in self.headers

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self.headers)

    def __len__(self) -> int:
        """Return the number of arrays."""
        return len(self.headers)


def _header(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> _Header:
    """Return the header of a member of an archive; ValueError where it does not fit its length."""
    with archive.open(member) as stream:
        version = np.lib.format.read_magic(stream)
        if version not in _HEADERS:
            raise ValueError(f"{member.filename} is of another version")
        shape, fortran, dtype = _HEADERS[version](stream)
        header = _Header(member, shape, fortran, dtype, stream.tell())
    if dtype.hasobject:
        raise ValueError(f"Object arrays cannot be loaded, and {member.filename} is one")
    if not dtype.itemsize or any(length < 0 for length in shape):
        raise ValueError(f"{member.filename} is not what its header says")
    if header.start + header.size != member.file_size:
        raise ValueError(f"{member.filename} is not what its header says")
    return header


def field(
    arrays: Mapping[str, NDArray[Any]], name: str, dtype: Any, shape: tuple[int | None, ...], *, finite: bool = False
) -> NDArray[Any]:
    """Return an array of a file; ValueError unless it has this type and this shape, None for any length."""
    claimed = arrays.headers[name] if isinstance(arrays, Arrays) else arrays[name]
    require_shape(arrays, name, shape)
    if claimed.dtype.newbyteorder("=") != np.dtype(dtype):
        raise ValueError(f"{name} is an array of {claimed.dtype} and shape {claimed.shape}")
    array = arrays[name]
    if finite and not np.isfinite(array).all():
        raise ValueError(f"{name} is not finite")
    return array.astype(dtype, copy=False)


def require_shape(arrays: Mapping[str, NDArray[Any]], name: str, shape: tuple[int | None, ...]) -> tuple[int, ...]:
    """Return the shape of an array of a file, which is not read; ValueError unless it is this, None for any length."""
    claimed = arrays.headers[name] if isinstance(arrays, Arrays) else arrays[name]
    fits = len(claimed.shape) == len(shape) and all(
        wanted in (None, length) for wanted, length in zip(shape, claimed.shape, strict=True)
    )
    if not fits:
        raise ValueError(f"{name} is an array of {claimed.dtype} and shape {claimed.shape}")
    return claimed.shape


def entry(meta: Mapping[str, Any], name: str, kind: type[Result]) -> Result:
    """Return an entry of a file's description; ValueError unless it is of this type, and finite."""
    value = meta[name]
    if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
        raise ValueError(f"{name} is {value!r}")
    return value
