"""Compile flags and the choice between interpreted and compiled kernels, in one place.

A kernel is a plain Python function of floats and arrays.  Called as it stands it is interpreted: right for a handful
of scalars, and numba stays unloaded.  ``compiled(kernel)`` is the same function as machine code, cached on disk.
"""

from __future__ import annotations

import functools
import os
import types
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

F = TypeVar("F", bound=Callable[..., Any])

_INTERPRETED_UP_TO = 64  # elements; below this, loading numba costs more than it saves (heuristic)
_CHUNK = 8192  # elements a thread takes at a time (heuristic: well above the cost of a call, well below a map)


def kernel(function: F) -> F:
    """Mark ``function`` as a kernel: it may be compiled, and so are the marked functions it calls."""
    function.__kernel__ = True  # type: ignore[attr-defined]
    return function


@functools.cache
def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the machine-code version of a kernel (GIL released, IEEE division, no fastmath, cached on disk)."""
    import numba

    scope = dict(function.__globals__)
    for name in function.__code__.co_names:
        callee = scope.get(name)
        if getattr(callee, "__kernel__", False):
            scope[name] = compiled(callee)
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, function.__closure__)
    copy.__qualname__ = function.__qualname__
    copy.__module__ = function.__module__
    result: Callable[..., Any] = numba.njit(cache=True, nogil=True, error_model="numpy")(copy)
    return result


def fastest(function: Callable[..., Any], size: int) -> Callable[..., Any]:
    """Return ``function`` itself for small work and its compiled version for work of more than a few elements."""
    return function if size <= _INTERPRETED_UP_TO else compiled(function)


def cores() -> int:
    """Return the number of processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not every system has affinities
        return os.cpu_count() or 1


def over_chunks(
    function: Callable[..., Any],
    arrays: tuple[NDArray[Any], ...],
    *,
    workers: int | None = None,
    chunk: int = _CHUNK,
) -> None:
    """Call ``function(*pieces)`` on matching pieces of equally long arrays, in threads when there is enough to do.

    The last arrays are the outputs; kernels release the GIL, so the threads run side by side.
    """
    size = len(arrays[0])
    run = fastest(function, size)
    threads = min(workers or cores(), -(-size // chunk))
    if threads <= 1:
        # Large single-threaded work goes in pieces too, so that Ctrl-C is answered between them.
        for start in range(0, size, max(chunk, 1)):
            run(*(array[start : start + chunk] for array in arrays))
        return
    run(*(array[:1] for array in arrays))  # compile once, before the threads race to do it
    with ThreadPoolExecutor(threads) as pool:
        pieces = [
            pool.submit(run, *(array[start : start + chunk] for array in arrays)) for start in range(0, size, chunk)
        ]
        try:
            for piece in pieces:
                piece.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def broadcast(*values: Any) -> tuple[tuple[int, ...], tuple[NDArray[np.float64], ...]]:
    """Return the common shape and the flat, contiguous float64 versions of ``values``."""
    arrays = np.broadcast_arrays(*values)
    return arrays[0].shape, tuple(np.ascontiguousarray(array, dtype=np.float64).ravel() for array in arrays)
