"""Work that continues while a window follows its sliders: one job at a time, the latest one."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from queue import Empty, SimpleQueue
from typing import Any, TypeAlias

ViewParts: TypeAlias = dict[str, Any]
"""What is shown again, by the name of the place in the window."""

Stale: TypeAlias = Callable[[], bool]
"""Whether a job has been replaced and should end."""

Job: TypeAlias = Callable[[Stale], Iterator[ViewParts]]
"""Yields parts as they are found."""


class Background:
    """A thread that works on the latest job only; what it finds is fetched by the thread that draws."""

    def __init__(self) -> None:
        """Wait for a first job."""
        self._jobs: SimpleQueue[tuple[int, Job] | None] = SimpleQueue()
        self._finished: SimpleQueue[tuple[int, ViewParts | BaseException | None]] = SimpleQueue()
        self._latest = 0
        self._busy = False
        self._working = threading.Lock()
        self._thread: threading.Thread | None = None

    def start(self, job: Job) -> None:
        """Replace whatever is under way by a job."""
        self._latest += 1
        self._busy = True
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="floquetrod explorer", daemon=True)
            self._thread.start()
        self._jobs.put((self._latest, job))

    def run(self, job: Job) -> Iterator[ViewParts]:
        """Yield what a job finds, in the calling thread, in place of whatever is under way."""
        self._latest += 1
        self._busy = False
        with self._working:
            yield from job(lambda: False)

    def fetch(self) -> tuple[list[ViewParts], bool]:
        """Return panels finished by the latest job since the last call, and whether it continues; raise its error."""
        parts: list[ViewParts] = []
        while True:
            try:
                number, outcome = self._finished.get_nowait()
            except Empty:
                return parts, self._busy
            if number != self._latest:
                continue
            if isinstance(outcome, dict):
                parts.append(outcome)
                continue
            self._busy = False
            if outcome is not None:
                raise outcome

    def stop(self) -> None:
        """End the thread as soon as its job allows."""
        self._latest += 1
        self._busy = False
        self._jobs.put(None)

    def _work(self) -> None:
        while (given := self._jobs.get()) is not None:
            number, job = given
            with self._working:
                try:
                    self._do(number, job)
                except Exception as error:
                    self._finished.put((number, error))
                else:
                    self._finished.put((number, None))

    def _do(self, number: int, job: Job) -> None:
        def stale() -> bool:
            return number != self._latest

        if stale():
            return
        for parts in job(stale):
            if stale():
                return
            self._finished.put((number, parts))
