"""Files written atomically, and checksummed npz files of arrays with a description.

A save writes a temporary file (a part) beside its target, flushes it to the disk and renames it to the target.  The
writer of a part holds a lock on it, which ends with the process however that ends: a part without a lock has been
abandoned, and the next save into the folder removes it.
"""

from __future__ import annotations

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
from typing import IO, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate

Result = TypeVar("Result")

_LARGEST = 1 << 33  # bytes of a file, and of its arrays: what a person may still want to load
_PART = re.compile(r"\.floquetrod-[0-9a-f]{16}\.part")
_SEAL = b"sha256:"
_SEALED = len(_SEAL) + 2 * hashlib.sha256().digest_size
_CLOSED_FIRST = sys.platform == "win32"  # which does not rename a file that is open
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
    """Raise ValueError for what is to be read and is a folder, a device or a pipe, or has too many bytes.

    Whoever opens a pipe waits for what may never come.
    """
    try:
        about = path.stat()
    except FileNotFoundError:
        raise ValueError("there is no such file") from None
    if not stat.S_ISREG(about.st_mode):
        raise ValueError("it is a folder or a device, or a pipe; name a file")
    if largest is not None and about.st_size > largest:
        raise ValueError(f"it has {about.st_size:,} bytes, at most {largest:,} are read")


@contextmanager
def atomic_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for writing that takes the place of ``path`` once it is complete and on the disk.

    Until then the old one stays.  Symbolic links are followed; an older file's permissions are kept.
    """
    target = _target(path)
    # The part must not be readable by anyone who may not read the target; the system sets the rights of a new file.
    handle, part = _new_part(target.parent, 0o600 if target.exists() else 0o666)
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
    _clear(folder)
    while True:
        part = folder / f".floquetrod-{secrets.token_hex(8)}.part"
        handle = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL | _BINARY, mode)
        # Before it was locked, another process may have taken it for abandoned.
        if _locked(handle) is not False and part.exists():
            return handle, part
        os.close(handle)


def _clear(folder: Path) -> None:
    """Remove the parts that processes left behind when they were killed."""
    with suppress(OSError):
        for path in folder.iterdir():
            if _PART.fullmatch(path.name):
                _remove_abandoned(path)


def _remove_abandoned(part: Path) -> None:
    """Remove a part unless its writer lives, or nobody can tell."""
    with suppress(OSError):  # it is another user's, or has gone meanwhile
        handle = os.open(part, os.O_RDWR | _BINARY)
        try:
            if _locked(handle):
                part.unlink()
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
    path: str | Path, file_format: str, what: str, build: Callable[[dict[str, Any], dict[str, NDArray[Any]]], Result]
) -> Result:
    """Return what ``build`` makes of description and arrays that `write_npz` wrote with this ``meta["format"]``.

    Raises ValueError, saying that the file is not ``what``, for one that is damaged, foreign, or not as ``build``
    wants it.
    """
    path = validate.path("path", path)
    if not path.exists():
        raise ValueError(f"{path} is not {what} that can be read: there is no such file")
    try:
        meta, arrays = _unpack(path)
        if meta["format"] != file_format:
            raise ValueError(f"its format is {meta['format']!r}, not {file_format!r}: it is of another kind or version")
        return build(meta, arrays)
    except Exception as error:  # any error while reading means that the file is not one of ours
        cause = f"it has no {error}" if isinstance(error, KeyError) else error
        raise ValueError(f"{path} is not {what} that can be read: {cause}") from error


def _unpack(path: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return description and arrays of a sealed file."""
    require_regular(path, _LARGEST)
    with path.open("rb") as file:
        seal = _seal(file)
        if not (found := file.read()).startswith(_SEAL):
            raise ValueError("it has no checksum: it is damaged, foreign, or of a version before checksums")
        if found != seal:
            raise ValueError("its checksum does not fit: it is damaged")
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > _LARGEST:
                raise ValueError(f"it holds more than {_LARGEST:,} bytes")
            arrays = {member.filename.removesuffix(".npy"): _array(archive, member) for member in members}
    if len(arrays) != len(members):
        raise ValueError("it holds two arrays of one name")
    meta = json.loads(str(field(arrays, "meta", arrays["meta"].dtype, ())[()]))
    if not isinstance(meta, dict):
        raise ValueError("its description is none")
    del arrays["meta"]
    return meta, arrays


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    """Return a member of an archive; memory is allocated only as far as there is content."""
    with archive.open(member) as stream:
        if np.lib.format.read_magic(stream) != (1, 0):
            raise ValueError(f"{member.filename} is of another version")
        shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
        content = bytearray(stream.read())
    if dtype.hasobject or math.prod(shape) * dtype.itemsize != len(content):
        raise ValueError(f"{member.filename} is not what its header says")
    return np.ndarray(shape, dtype, buffer=content, order="F" if fortran else "C")


def field(
    arrays: Mapping[str, NDArray[Any]], name: str, dtype: Any, shape: tuple[int | None, ...], *, finite: bool = False
) -> NDArray[Any]:
    """Return an array of a file; ValueError unless it has this type and this shape, None for any length."""
    array = arrays[name]
    fits = len(array.shape) == len(shape) and all(
        wanted in (None, length) for wanted, length in zip(shape, array.shape, strict=True)
    )
    if not fits or array.dtype.newbyteorder("=") != np.dtype(dtype):
        raise ValueError(f"{name} is an array of {array.dtype} and shape {array.shape}")
    if finite and not np.isfinite(array).all():
        raise ValueError(f"{name} is not finite")
    return array.astype(dtype, copy=False)


def entry(meta: Mapping[str, Any], name: str, kind: type[Result]) -> Result:
    """Return an entry of a file's description; ValueError unless it is of this type, and finite."""
    value = meta[name]
    if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
        raise ValueError(f"{name} is {value!r}")
    return value
