"""Locks on files, which end with the process that holds them, however it ends.

They are the operating system's, so nobody has to guess whether an owner still lives: a process that is stopped keeps
its lock, one that is killed loses it.  Other machines see a lock as far as the file system passes it on, as NFS does
and Lustre where it is mounted with flock.  On Linux a lock belongs to the opened file, so that two threads of one
process exclude each other, too; elsewhere to the process.  On Windows nothing is locked.
"""

from __future__ import annotations

import errno
import os
import struct
import sys
import weakref
from contextlib import suppress
from pathlib import Path


class Lock:
    """A lock on consecutive bytes of a file, whether it has them or not, until it is released.

    The file is made where it is missing.  With ``remove`` it is removed when the lock is released; then every lock on
    it must be of the same bytes.  Raises BlockingIOError when another holds a lock on one of the bytes, OSError when
    the file cannot be locked.
    """

    def __init__(self, path: Path, part: range, *, remove: bool) -> None:
        """Take the lock."""
        self._path, self._part, self._remove = path, part, remove
        self._handle: int | None = None
        while self._handle is None:
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            try:
                _lock(handle, part)
                # The one who had the lock before may have removed the file after it was opened here.
                if not remove or _is_file(path, handle):
                    self._handle = handle
                    _held.add(self)
            finally:
                if self._handle is None:
                    os.close(handle)

    def release(self) -> None:
        """Release the lock."""
        if self._handle is None:
            return
        handle, self._handle = self._handle, None
        if self._remove and _is_file(self._path, handle):
            with suppress(OSError):
                self._path.unlink()
        with suppress(OSError):  # a child that was forked has the file open, too
            _unlock(handle, self._part)
        os.close(handle)

    def forget(self) -> None:
        """Close the file in a process that was forked: the lock is its parent's, and ends with that."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def lock_beside(path: Path) -> Lock:
    """Return a lock for writers of a file that every save replaces: on a hidden file beside it, links followed.

    Raises the errors of `Lock`.
    """
    target = Path(os.path.realpath(path))
    return Lock(target.with_name(f".{target.name}.lock"), range(1), remove=True)


_held: weakref.WeakSet[Lock] = weakref.WeakSet()


def _forget() -> None:
    for lock in list(_held):
        lock.forget()


if sys.platform != "win32":
    import fcntl

    os.register_at_fork(after_in_child=_forget)

    def _lock(handle: int, part: range) -> None:
        """Lock a part of an open file; BlockingIOError where another has locked some of it."""
        try:
            _set(handle, fcntl.F_WRLCK, part)
        except OSError as error:
            if error.errno in (errno.EAGAIN, errno.EACCES):
                raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)) from None
            raise

    def _unlock(handle: int, part: range) -> None:
        """Unlock a part of an open file."""
        _set(handle, fcntl.F_UNLCK, part)

    def _set(handle: int, kind: int, part: range) -> None:
        """Set the kind of lock on a part of an open file."""
        if sys.platform == "linux":
            request = struct.pack("hhqqi0q", kind, os.SEEK_SET, part.start, len(part), 0)
            fcntl.fcntl(handle, fcntl.F_OFD_SETLK, request)
        else:
            command = fcntl.LOCK_UN if kind == fcntl.F_UNLCK else fcntl.LOCK_EX | fcntl.LOCK_NB
            fcntl.lockf(handle, command, len(part), part.start)

else:

    def _lock(handle: int, part: range) -> None:
        """Do nothing."""

    def _unlock(handle: int, part: range) -> None:
        """Do nothing."""


def _is_file(path: Path, handle: int) -> bool:
    """Return whether an open file is still the one of that path."""
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except OSError:
        return False
