"""Compiled kernels kept on disk, one file for each kernel and types of arguments.

numba's own cache of a function does not see that a function it calls, or a constant, has changed in another file; it
raises where no folder can be written, and for damaged files.  This cache replaces it.  It stores machine code with a
fingerprint of all its sources, and treats a file that does not match, for any reason, as missing.
"""

from __future__ import annotations

import functools
import hashlib
import pickle
import sys
import time
import types
import uuid
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from floquetrod._util.locks import Lock, lock_beside

_LAYOUT = 2  # of the files
_DIGEST = hashlib.sha256().digest_size
_LONGEST = 120.0  # s that a process waits for another that compiles (a choice: longer than the slowest kernel)
_POLL = 0.1  # s between two attempts


class KernelCache:
    """The cache of one function with the interface numba expects: to load, and to save, code for given types.

    ``sources`` is the `fingerprint` of the function; ``announce`` is called before numba compiles.
    """

    def __init__(self, function: Callable[..., Any], sources: bytes, announce: Callable[[], None]) -> None:
        """Find the folder numba would use; where there is none, store nothing and warn once."""
        self._function, self._sources, self._announce = function, sources, announce
        from numba.core import caching

        find: Any = caching.CompileResultCacheImpl
        self._numba: Any = None
        self.cache_path: str | None = None
        try:
            self._numba = find(function)
            self.cache_path = self._numba.locator.get_cache_path()
        except RuntimeError:  # "no locator available": neither of the folders it tries can be written
            _warn_uncached()

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return compiled code, or None."""
        target.refresh()  # numba requires this of a cache: a loaded function uses what the target has registered
        kept = self._load(signature, target)
        if kept is None:
            self._announce()
        return kept

    def _load(self, signature: Any, target: Any) -> Any:
        if self.cache_path is None:
            return None
        path, key = self._place(signature, target.codegen())
        try:
            content = path.read_bytes()
            payload = content[2 * _DIGEST :]
            if content[: 2 * _DIGEST] != key + hashlib.sha256(payload).digest():
                return None
            return self._numba.rebuild(target, pickle.loads(payload))
        except Exception:  # whatever is wrong with the file or its folder, compiling is the remedy
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Store compiled code; where the folder cannot be written, or is full, warn once and continue."""
        if self.cache_path is None or not self._numba.check_cachable(result):
            return
        from numba.core import serialize

        dumps: Any = serialize.dumps
        path, key = self._place(signature, result.codegen)
        payload = dumps(self._numba.reduce(result))
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            _replace(path, key + hashlib.sha256(payload).digest() + payload)
        except OSError as error:
            _warn_uncached(str(error))

    def is_kept(self) -> bool:
        """Return whether valid compiled code, for any types, is on disk."""
        if self.cache_path is None:
            return False
        paths = Path(self.cache_path).glob(f"{self._name}-*.{sys.implementation.cache_tag}.nbc")
        try:
            return any(_begins_with(path, self._key) for path in paths)
        except OSError:
            return False

    @contextmanager
    def alone(self, signature: Any, target: Any, idle: Callable[[], None]) -> Iterator[None]:
        """Let one process at a time compile for these types: others wait, and load what it has kept.

        ``idle`` is called meanwhile.  Nobody waits where code is on disk already, or where files cannot be locked.
        """
        lock = None
        if self.cache_path is not None:
            path, key = self._place(signature, target.codegen())
            lock = None if _begins_with(path, key) else _locked(path, idle)
        try:
            yield
        finally:
            if lock is not None:
                lock.release()

    @property
    def _name(self) -> str:
        return f"{self._function.__module__}.{self._function.__qualname__}"

    @property
    def _key(self) -> bytes:
        """Digest of sources and versions, by which the content of a file is valid."""
        import numba

        return hashlib.sha256(self._sources + repr((_LAYOUT, sys.version, numba.__version__)).encode()).digest()

    def _place(self, signature: Any, codegen: Any) -> tuple[Path, bytes]:
        """Return the file for these types on this processor, and the key of valid content."""
        import numba

        config: Any = numba.config
        variant = (str(signature), codegen.magic_tuple(), config.BOUNDSCHECK, config.OPT)
        kind = hashlib.sha256(repr(variant).encode()).hexdigest()[:16]
        return Path(self.cache_path or "") / f"{self._name}-{kind}.{sys.implementation.cache_tag}.nbc", self._key


def _begins_with(path: Path, key: bytes) -> bool:
    """Return whether a file is there and begins with a key."""
    try:
        with path.open("rb") as file:
            return file.read(len(key)) == key
    except OSError:
        return False


def _locked(path: Path, idle: Callable[[], None]) -> Lock | None:
    """Return the lock of a file, waiting for another process that has it; None where it cannot be locked, or not soon.

    The time is limited because a process that is stopped keeps its locks.
    """
    waited = 0.0
    while waited < _LONGEST:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            return lock_beside(path)
        except BlockingIOError:
            time.sleep(_POLL)
            waited += _POLL
            idle()
        except OSError:
            break
    return None


@functools.cache
def _warn_uncached(why: str = "neither the package's folder nor a cache in the home folder can be written") -> None:
    """Warn once in a process that compiled kernels are lost when it ends."""
    if _warn_uncached.cache_info().misses > 1:
        return  # for another reason: the remedy is the same
    warnings.warn(
        f"compiled kernels cannot be kept on disk ({why}), so every process compiles them again, for some seconds; "
        "set the environment variable NUMBA_CACHE_DIR to a folder that can be written",
        RuntimeWarning,
        stacklevel=2,
    )


def _replace(path: Path, content: bytes) -> None:
    """Write a file atomically, readable by others who share the installation."""
    temporary = path.with_name(f"{path.name}.{uuid.uuid4().hex}.tmp")
    try:
        with temporary.open("xb") as file:
            file.write(content)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def fingerprint(function: Callable[..., Any], options: dict[str, Any]) -> bytes:
    """Return a digest of a kernel and of the options of its compilation.

    It covers the kernel's code, the code of the kernels it calls, and the constants any of them reads.
    """
    seen: dict[str, str] = {}
    _describe_kernel(function, seen)
    return hashlib.sha256(repr((options, sorted(seen.items()))).encode()).digest()


def _describe_kernel(function: Callable[..., Any], seen: dict[str, str]) -> None:
    """Add a kernel, and the kernels it calls, to ``seen``."""
    name = f"{function.__module__}.{function.__qualname__}"
    if name in seen:
        return
    seen[name] = ""
    names = {}
    for read in function.__code__.co_names:
        if read in function.__globals__:
            value = function.__globals__[read]
            if getattr(value, "__kernel__", False):
                _describe_kernel(value, seen)
                names[read] = f"{value.__module__}.{value.__qualname__}"
            else:
                names[read] = _describe(value, f"{name} reads {read}")
    defaults = _describe(function.__defaults__, f"a default of {name}")
    code = list(_describe_code(function.__code__, name))
    seen[name] = repr((code, defaults, sorted(function.__annotations__.items()), sorted(names.items())))


def _describe_code(code: types.CodeType, where: str) -> Iterator[str]:
    yield from (repr(code.co_code), repr(code.co_varnames), repr(code.co_names), repr(code.co_argcount))
    yield from (_describe(constant, where) for constant in code.co_consts)


def _describe(value: Any, where: str) -> str:
    """Return a text that differs for values with different machine code."""
    if (
        value is None
        or value is ...
        or isinstance(value, (bool, int, float, complex, str, bytes, np.generic, np.dtype))
    ):
        return repr(value)
    if isinstance(value, (tuple, frozenset)):
        texts = [_describe(element, where) for element in value]
        return f"{type(value).__name__}({texts if isinstance(value, tuple) else sorted(texts)})"
    if isinstance(value, np.ndarray):
        return f"{value.dtype.str}{value.shape}{value.tobytes()!r}"
    if isinstance(value, types.CodeType):
        return repr(list(_describe_code(value, where)))
    if isinstance(value, (types.BuiltinFunctionType, np.ufunc)):
        return repr(value.__name__)
    if isinstance(value, type):
        return f"{value.__module__}.{value.__qualname__}{getattr(value, '_fields', '')}"
    if isinstance(value, types.ModuleType) and value.__name__ in ("math", "cmath", "numpy"):
        return value.__name__
    raise TypeError(f"{where}, of type {type(value).__name__}, whose changes the cache of compiled kernels cannot see")
