"""Ctrl-C deferred during code that would lose it or be broken by it, and delivered at the next safe point."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def held() -> Iterator[Callable[[], None]]:
    """Defer Ctrl-C until the end of the block, or until the function it yields is called.

    Both then call the handler that Ctrl-C would have called without the block, which as a rule raises
    KeyboardInterrupt.  Only the main thread receives signals, and only a handler written in Python can be called later:
    elsewhere nothing changes.
    """
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler) or threading.current_thread() is not threading.main_thread():
        yield nothing
        return
    frames: list[FrameType | None] = []

    def note(_: int, frame: FrameType | None) -> None:
        frames.append(frame)

    def deliver() -> None:
        if frames and threading.current_thread() is threading.main_thread():
            frame = frames[-1]
            frames.clear()
            handler(signal.SIGINT, frame)

    signal.signal(signal.SIGINT, note)
    try:
        yield deliver
    finally:
        signal.signal(signal.SIGINT, handler)
        deliver()


def nothing() -> None:
    """Do nothing, as the function that `held` yields where no Ctrl-C arrived."""
