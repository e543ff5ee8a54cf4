"""Progress on stderr while a question takes its time."""

from __future__ import annotations

import math
import shutil
import sys
import threading
import time
from contextlib import suppress
from typing import Self

from floquetrod._util.suggest import printable

FIRST = 0.5
"""Seconds until the line is shown, so that it is within the first second of a command."""

EVERY = 0.25
"""Seconds between changes of the line (a choice)."""

PLAIN = 10.0
"""Seconds until a line is written where stderr is no terminal, and the next after twice as long (a choice)."""


def can_redraw() -> bool:
    """Return whether stderr can show a line again where it was, as a terminal and a notebook do."""
    return sys.stderr is not None and (sys.stderr.isatty() or type(sys.stderr).__module__.startswith("ipykernel."))


class Waiting:
    """A line on stderr that names the task and its time so far.

    A context: the line appears ``first`` seconds after it was entered and moves until it is left.  It may be called
    with the numbers done and in all of the ``counted`` things.  The cursor stays at the beginning of the line, so that
    the next output replaces it.  Where stderr is a file or a pipe, lines are added to it after 10 s, 30 s, 70 s and so
    on, the pauses at most ``longest`` in s.
    """

    def __init__(self, what: str, counted: str = "", first: float = FIRST, longest: float = math.inf) -> None:
        self.what = printable(what)
        self.counted = counted
        self.first = first
        self.longest = longest
        self._start = time.monotonic()
        self._first: tuple[float, int] | None = None
        self._last: tuple[int, int] | None = None
        self._called = 0.0
        self._longest = (0.0, 0)
        self._width = 0
        self._left = threading.Event()
        self._thread = threading.Thread(target=self._speak, daemon=True)

    def __enter__(self) -> Self:
        """Start to show the line."""
        self._start = time.monotonic()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the line."""
        self._left.set()
        self._thread.join()

    def __call__(self, done: int, total: int) -> None:
        """Note that ``done`` of ``total`` is done.

        The rate is counted from the first call, without the longest pause between two calls, the present pause
        included: work before the first call may be of an earlier run, and code is compiled in one of the pauses.
        """
        now = time.monotonic()
        if self._last is not None:
            self._longest = max(self._longest, (now - self._called, done - self._last[0]))
        self._first = self._first or (now, done)
        self._last, self._called = (done, total), now

    @property
    def is_complete(self) -> bool:
        """Whether all is done."""
        return self._last is not None and self._last[0] == self._last[1]

    @property
    def counted_now(self) -> int:
        """Number of things done since it was entered, without those that were done before."""
        return 0 if self._first is None or self._last is None else self._last[0] - self._first[1] + 1

    @property
    def rate(self) -> float:
        """Number done in a second; zero while it is not known, in the first second counted."""
        if self._first is None or self._last is None:
            return 0.0
        now = time.monotonic()
        pause, meanwhile = max(self._longest, (now - self._called, 0))
        seconds = now - self._first[0] - pause
        return (self._last[0] - self._first[1] - meanwhile) / seconds if seconds >= 1.0 else 0.0

    @property
    def remaining(self) -> float | None:
        """Seconds until all is done, None while the rate is not known."""
        rate = self.rate
        return (self._last[1] - self._last[0]) / rate if self._last is not None and rate > 0.0 else None

    def _speak(self) -> None:
        if not can_redraw():
            self._add_lines()
            return
        pause = self.first
        while not self._left.wait(pause):
            pause = EVERY
            line = self._line()[: shutil.get_terminal_size().columns - 1]
            print(f"{line:<{self._width}}", end="\r", file=sys.stderr, flush=True)
            self._width = len(line)
        if self._width:
            print(" " * self._width, end="\r", file=sys.stderr, flush=True)

    def _add_lines(self) -> None:
        pause = PLAIN
        while not self._left.wait(pause):
            pause = min(2.0 * pause, self.longest)
            print(f"floquetrod: {self._line()}", file=sys.stderr, flush=True)

    def _line(self) -> str:
        line = f"{self.what}: {time.monotonic() - self._start:.0f} s"
        if self._last is not None and self.counted:
            done, total = self._last
            line += f", {done:,} of {total:,} {self.counted}"
            if (seconds := self.remaining) is not None:
                line += f", {self.rate:,.0f} a second" if self.rate >= 1.0 else ""
                line += f", {roughly(seconds)} left"
        return f"{line} (Ctrl-C ends it)"


def say(message: str) -> None:
    """Print a message on stderr, in place of a line of `Waiting` that may be there."""
    message = printable(message)
    line = f"\r{message:<{shutil.get_terminal_size().columns - 1}}" if sys.stderr.isatty() else message
    with suppress(OSError):  # a full disk, or nobody who reads: the answer does not depend on it
        print(line, file=sys.stderr, flush=True)


def roughly(seconds: float) -> str:
    """Return a time in words, in the largest unit with a count of at least two."""
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} seconds"
