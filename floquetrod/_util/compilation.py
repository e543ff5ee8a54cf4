"""Compile flags and the choice between interpreted and compiled kernels, in one place.

A kernel is a plain Python function of floats and arrays.  Called directly it is interpreted, which suits a handful of
scalars and leaves numba unloaded.  ``compiled(kernel)`` is the same function as machine code, cached on disk with
a fingerprint of its code, of the kernels it calls, in whatever file, and of the constants they read; it is compiled
again where that differs.  For a few scalars, and for the first thousands of loads on a short rod, interpreting takes
less time than loading numba, which is why a verdict is immediate.

Kernels lie in folders `kernels/` beside their subject, one or more to a file, and may call kernels of other files.
Called kernels are compiled for the types of their arguments, not for each constant they are called with; only a
parameter annotated `Literal` is, where that pays.  Records have named fields, not numbered columns; kernels that often
run interpreted take views of the fields.  `fastmath` stays off: NaN and infinity must keep their meaning.  While numba
compiles, Ctrl-C takes effect at the end of a pass.  The logger `floquetrod.compile` reports each function that is
compiled at the level INFO, which the terminal shows, and warns once per process that it takes some seconds.

*Threads.*  `over_chunks` and `in_threads` start with the calling thread alone, estimate the remaining time from the
finished chunks, and then start as many threads as have a millisecond of work each.  Chunks do not depend on the
number of threads, and no thread outlives a call.
"""

from __future__ import annotations

import contextvars
import functools
import gc
import inspect
import logging
import os
import threading
import time
import types
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import interrupt, validate

F = TypeVar("F", bound=Callable[..., Any])

_LOG = logging.getLogger("floquetrod.compile")  # names compiled kernels, at the level INFO, and warns of long waits
_LONG = 3.0  # seconds of compiling one kernel before the warning (a choice)

INTERPRETED_UP_TO = 64  # elements; below this, loading numba costs more than it saves (heuristic)
_OPTIONS = {"nogil": True, "error_model": "numpy"}
_CHUNK = 8192  # elements a thread takes at a time (heuristic: well above the cost of a call, well below a map)
_WORTH_A_THREAD = 1e-3  # seconds of work for each thread below which it does not pay (measured: one costs 0.1 ms)

_INTERPRETED: dict[Callable[..., Any], float] = {}
"""Work of each kernel while interpreted, in multiples of ``interpret_up_to``, see `runner`."""


def kernel(function: F) -> F:
    """Mark ``function`` as a kernel: it may be compiled, and so are the marked functions it calls."""
    function.__kernel__ = True  # type: ignore[attr-defined]
    return function


@contextmanager
def _compiling() -> Iterator[Callable[[], None]]:
    """Serialise numba's work, which is not thread-safe, and defer Ctrl-C meanwhile; see `interrupt.held`.

    The lock is held across a fork, so that no child process starts while numba is at work.
    """
    with _LOCK, interrupt.held() as deliver, _uncollected():
        yield deliver


@contextmanager
def _uncollected() -> Iterator[None]:
    """Let no garbage be collected: numba makes millions of objects and keeps most, and a search costs a fifth more."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


_LOCK = threading.RLock()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_LOCK.acquire, after_in_parent=_LOCK.release, after_in_child=_LOCK.release)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the machine-code version of a kernel (GIL released, IEEE division, no fastmath, cached on disk).

    It is compiled, or loaded, by the first call with arguments of new types, or beforehand by `compiled_for`.
    """
    with _LOCK:
        return _compiled(function)


def is_at_hand(function: Callable[..., Any]) -> bool:
    """Return whether machine code of a kernel takes only milliseconds to load: numba runs already, and code is kept."""
    if not _compiled.cache_info().currsize:
        return False
    cache = getattr(compiled(function), "_cache", None)
    return cache is not None and cache.is_kept()


def compiled_for(function: Callable[..., Any], *arguments: Any) -> Callable[..., Any]:
    """Return `compiled` of a kernel once it is ready to be called with such arguments."""
    run: Any = compiled(function)
    if hasattr(run, "py_func"):
        import numba

        signature = tuple(map(numba.typeof, arguments))
        if signature not in run.overloads:
            run.compile(signature)
    return cast(Callable[..., Any], run)


@functools.cache
def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    with _compiling():
        import numba

        from floquetrod._util.kernel_cache import KernelCache, fingerprint

        # numba uses a part of numpy that is imported on first use: imported here, it cannot be half imported at a fork.
        typeof: Any = numba.typeof
        typeof(np.empty(0))
        _name_records_by_content()
        njit: Any = numba.njit
        result = njit(**_OPTIONS)(_with_compiled_callees(function))
    if not hasattr(result, "py_func"):  # NUMBA_DISABLE_JIT
        return function
    compile_types = result.compile

    def compile_undisturbed(signature: Any) -> Any:
        # numba runs Python code from within LLVM, where an exception is printed and discarded: Ctrl-C there would be
        # lost.  It is delivered between the passes of the compiler.
        started = time.thread_time()

        def act() -> None:
            deliver()
            if time.thread_time() - started > _LONG:
                _tell_once()

        with (
            _compiling() as deliver,
            result._cache.alone(signature, result.targetctx, deliver),
            numba.core.event.install_listener("numba:run_pass", _after_passes(act)),
        ):
            return compile_types(signature)

    result.compile = compile_undisturbed
    sources = fingerprint(function, _OPTIONS)
    result._cache = KernelCache(result.py_func, sources, lambda: _LOG.info("compiling %s", function.__qualname__))
    return cast(Callable[..., Any], result)


@functools.cache
def _tell_once() -> None:
    """Say that compiling takes long: as a warning of the log, which Python prints where nobody has set one up."""
    _LOG.warning("floquetrod is compiling, once, for up to a minute; later processes load what is kept on disk")


def _name_records_by_content() -> None:
    """Let symbols of machine code name a record type by its content.

    numba names it by the order in which a process met its types.  Code for two record types, compiled in two processes
    and kept on disk, would then have one name, and a third process that loads both would run one in place of the other.
    """
    import hashlib

    from numba.core import types as numba_types

    def mangling_args(record: Any) -> tuple[str, tuple[str]]:
        return type(record).__name__, (hashlib.sha256(record.name.encode()).hexdigest()[:32],)

    kind: Any = numba_types.Record
    kind.mangling_args = property(mangling_args)


@functools.cache
def _callee(function: Callable[..., Any]) -> Any:
    """Return the machine-code version of a kernel for other kernels, which are compiled and cached together with it.

    numba would compile it once more for every constant it is called with.  Only parameters annotated `Literal` keep
    that behaviour, where specialising on the constant pays.
    """
    import numba
    from numba.core import types as numba_types

    # Entry points for Python and C cost a quarter of the time it takes to compile small functions.
    njit: Any = numba.njit
    result = njit(**_OPTIONS, no_cpython_wrapper=True, no_cfunc_wrapper=True)(_with_compiled_callees(function))
    if not hasattr(result, "py_func"):  # NUMBA_DISABLE_JIT
        return function
    template: Any = result.get_call_template
    general: Any = numba_types.unliteral
    annotations = function.__annotations__
    constant = [str(annotations.get(name)).startswith("Literal") for name in inspect.signature(function).parameters]

    def general_template(kinds: Any, keywords: Any) -> Any:
        pairs = zip(kinds, constant, strict=False)  # those with a default may be left out
        return template(tuple(kind if kept else general(kind) for kind, kept in pairs), keywords)

    result.get_call_template = general_template
    return result


def _with_compiled_callees(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel whose names of other kernels mean their machine-code versions."""
    scope = dict(function.__globals__)
    for name in function.__code__.co_names:
        callee = scope.get(name)
        if getattr(callee, "__kernel__", False):
            scope[name] = _callee(callee)
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, function.__closure__)
    copy.__qualname__ = function.__qualname__
    copy.__module__ = function.__module__
    return copy


def _after_passes(act: Callable[[], None]) -> Any:
    """Return a listener to numba's compiler that calls ``act`` after each of its passes."""
    from numba.core.event import Listener

    class AfterPasses(Listener):
        def on_start(self, event: Any) -> None:
            pass

        def on_end(self, event: Any) -> None:
            act()

    return AfterPasses()


def runner(
    function: Callable[..., Any], size: int, *, interpret_up_to: int = INTERPRETED_UP_TO, compile_after: int = 0
) -> Callable[..., Any]:
    """Return a kernel as it stands or compiled, by the number of elements of work: the one rule for that choice.

    Up to ``interpret_up_to`` elements are always interpreted, which takes less time than loading numba.  Larger work
    is, too, until the process has called this kernel for ``compile_after`` times as many: compiling takes seconds, too
    long for a single question.
    """
    if size <= interpret_up_to:
        return function
    work = _INTERPRETED.get(function, 0.0) + size / max(interpret_up_to, 1)
    if interpret_up_to and work <= compile_after:
        _INTERPRETED[function] = work
        return function
    return compiled(function)


def cores() -> int:
    """Return the number of processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not every system has affinities
        return os.cpu_count() or 1


def _is_plain(array: NDArray[Any]) -> bool:
    """Return whether an array is contiguous, aligned and writable; its flags warn of broadcasting before NumPy 2.0."""
    return array.flags.c_contiguous and array.flags.aligned and not array.data.readonly


def over_chunks(
    function: Callable[..., Any],
    inputs: Sequence[NDArray[Any]],
    out: NDArray[Any],
    *constants: Any,
    workers: int | None = None,
    chunk: int = _CHUNK,
    interpret_up_to: int = INTERPRETED_UP_TO,
    compile_after: int = 0,
) -> None:
    """Call ``function(*inputs, out, *constants)`` on matching pieces of equally long arrays, in threads if it pays.

    Kernels release the GIL, so the threads run side by side, and Ctrl-C is handled between pieces.
    ``interpret_up_to`` and ``compile_after`` as in `runner`.
    """
    workers = validate.workers(workers)
    size = len(out)
    run: Any = runner(function, size, interpret_up_to=interpret_up_to, compile_after=compile_after)
    if not hasattr(run, "py_func"):  # interpreted: plain floats are faster than numpy's, and overflow quietly
        with np.errstate(all="ignore"):  # as in machine code
            run(*(array.tolist() for array in inputs), out, *constants)
        return
    # One layout of arrays: a kernel is compiled for every layout, and read-only arrays have another.
    inputs = [array if _is_plain(array) else np.array(array, order="C") for array in inputs]
    if size <= chunk:
        run(*inputs, out, *constants)
        return
    pieces = [
        (*(array[start : start + chunk] for array in inputs), out[start : start + chunk], *constants)
        for start in range(0, size, chunk)
    ]
    in_threads(run, pieces, workers or cores())


def in_threads(run: Callable[..., Any], pieces: Sequence[tuple[Any, ...]], workers: int) -> None:
    """Call ``run`` on every piece, in up to ``workers`` threads if the rest, by the time taken so far, is worth it.

    The pieces do not depend on the threads, and so neither do results.  Ctrl-C, which an ending thread could swallow,
    is handled between pieces.  No thread outlives the call: a fork finds none.
    """
    left = iter(pieces)
    started = time.perf_counter()
    for done, piece in enumerate(left, 1):
        run(*piece)
        seconds = (time.perf_counter() - started) * (len(pieces) / done - 1.0)
        threads = min(workers, len(pieces) - done, int(seconds / _WORTH_A_THREAD))
        if threads > 1:
            _share(run, left, threads)


def _share(run: Callable[..., Any], left: Iterator[tuple[Any, ...]], threads: int) -> None:
    """Call ``run`` on the rest of an iterator, in this thread and others; raise the first exception of any of them."""
    errors: list[BaseException] = []
    overflow = np.geterr()  # numpy before 2.0 keeps the treatment of floating-point errors by thread

    def work(after: Callable[[], None]) -> None:
        try:
            with np.errstate(**overflow):
                for piece in left:
                    run(*piece)
                    after()
        except BaseException as error:
            errors.append(error)
            for _ in left:  # so that the others end
                pass

    threads_started: list[threading.Thread] = []
    with interrupt.held() as deliver:
        try:
            for _ in range(threads - 1):
                thread = threading.Thread(target=contextvars.copy_context().run, args=(work, interrupt.nothing))
                thread.start()
                threads_started.append(thread)
            work(deliver)
        finally:
            for thread in threads_started:
                thread.join()
    if errors:
        raise errors[0]
