"""Progress on stderr while a question takes its time."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

EVERY = 1.0
"""Seconds until the first message, and between messages."""


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Report on stderr what is being done and since when, if stderr is a terminal.

    Nothing is reported within the first second.  The cursor stays at the beginning of the line, so that the next output
    replaces the message.
    """
    if not sys.stderr.isatty():
        yield
        return
    done = threading.Event()
    thread = threading.Thread(target=_speak, args=(what, done), daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _speak(what: str, done: threading.Event) -> None:
    start, width = time.monotonic(), 0
    while not done.wait(EVERY):
        line = f"{what}: {time.monotonic() - start:.0f} s (Ctrl-C ends it)"
        width = len(line)
        print(line, end="\r", file=sys.stderr, flush=True)
    if width:
        print(" " * width, end="\r", file=sys.stderr, flush=True)
