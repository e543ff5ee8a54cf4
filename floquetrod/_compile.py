"""Compile flags and the choice between interpreted and compiled kernels, in one place.

A kernel is a plain Python function of floats and arrays.  Called as it stands it is interpreted: right for a handful
of scalars, and numba stays unloaded.  ``compiled(kernel)`` is the same function as machine code, cached on disk.
"""

from __future__ import annotations

import functools
import os
import types
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from numpy.typing import NDArray

from floquetrod import _validate

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
    """Return ``function`` itself for small work (``size`` elements), its compiled version for more."""
    return function if size <= _INTERPRETED_UP_TO else compiled(function)


def cores() -> int:
    """Return the number of processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not every system has affinities
        return os.cpu_count() or 1


def over_chunks(
    function: Callable[..., Any],
    inputs: Sequence[NDArray[Any]],
    out: NDArray[Any],
    *constants: Any,
    workers: int | None = None,
    chunk: int = _CHUNK,
    interpret_up_to: int = _INTERPRETED_UP_TO,
) -> None:
    """Call ``function(*inputs, out, *constants)`` on matching pieces of equally long arrays, in threads if it pays.

    Kernels release the GIL, so the threads run side by side, and Ctrl-C is answered between pieces.  Arrays of up to
    ``interpret_up_to`` elements are left to the interpreter.
    """
    workers = _validate.workers(workers) or cores()
    size = len(out)
    run: Any = function if size <= interpret_up_to else compiled(function)
    if not hasattr(run, "py_func"):  # interpreted: plain floats are faster than numpy's, and overflow quietly
        run(*(array.tolist() for array in inputs), out, *constants)
        return
    pieces = [
        (*(array[start : start + chunk] for array in inputs), out[start : start + chunk], *constants)
        for start in range(0, size, chunk)
    ]
    if not run.signatures:  # compile it before threads could race to do it
        run(*pieces.pop(0))
    threads = min(workers, len(pieces))
    if threads <= 1:
        for piece in pieces:
            run(*piece)
        return
    with ThreadPoolExecutor(threads) as pool:
        running = [pool.submit(run, *piece) for piece in pieces]
        try:
            for task in running:
                task.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
