"""Work in a forked process, which may be killed, run out of disk or be interrupted."""

from __future__ import annotations

import io
import os
import pickle
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from typing import Any


def start(work: Callable[[], Any]) -> tuple[int, int]:
    """Run ``work`` in a fork of this process; return its id and the end of a pipe that its pickled answer comes from.

    A fork has all kernels compiled already: hundreds of kills take seconds.
    """
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        # Python 3.12 warns where threads run, as those of pytest's workers do; the child touches none of theirs.
        warnings.simplefilter("ignore", DeprecationWarning)
        process = os.fork()
    if process:
        os.close(writer)
        return process, reader
    os.close(reader)
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        try:
            answer = True, work()
        except BaseException as error:
            answer = False, f"{type(error).__name__}: {error} {traceback.format_exc(limit=-2)!r}"
        with io.FileIO(writer, "w") as pipe:  # not os.fdopen, which may be what is broken on purpose
            rest = memoryview(pickle.dumps(answer))
            while rest:  # a process stopped and continued may have written a part
                rest = rest[pipe.write(rest) :]
    finally:
        sys.stdout = sys.stderr = None  # what the parent has buffered is not the child's to print
        os._exit(0)


def ended(process: int, seconds: float) -> bool:
    """Wait for a process, so many seconds at most; return whether it has ended."""
    latest = time.monotonic() + seconds
    while os.waitid(os.P_PID, process, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > latest:
            return False
        time.sleep(0.01)
    return True


def finish(process: int, reader: int) -> tuple[bool, Any]:
    """Wait for the answer: (True, answer), or (False, what it raised or how it ended)."""
    with os.fdopen(reader, "rb") as pipe:
        data = pipe.read()
    _, status = os.waitpid(process, 0)
    if status or not data:  # one that was killed may have written a part
        return False, f"ended with status {status}"
    done, answer = pickle.loads(data)
    return bool(done), answer


def answer(work: Callable[[], Any]) -> tuple[bool, Any]:
    """Run ``work`` in a fork and wait for it."""
    return finish(*start(work))


def kill_after(work: Callable[[], Any], seconds: float) -> bool:
    """Run ``work`` in a fork and kill it after some time; return whether it was still running."""
    process, reader = start(work)
    time.sleep(seconds)
    os.kill(process, signal.SIGKILL)
    done, _ = finish(process, reader)
    return not done
