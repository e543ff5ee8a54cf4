"""Properties that are computed once: what threads and forked processes get."""

from __future__ import annotations

import os
import signal
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from floquetrod._util.caching import cached_property
from tests.fuzz import apart


class Slow:
    """One property, whose computation can be held up."""

    def __init__(self) -> None:
        self.began, self.go_on = threading.Event(), threading.Event()
        self.counted = 0

    @cached_property
    def value(self) -> list[int]:
        """A new list."""
        self.counted += 1
        self.began.set()
        assert self.go_on.wait(60.0)
        return []


def free() -> Slow:
    slow = Slow()
    slow.go_on.set()
    return slow


def test_it_is_computed_once() -> None:
    slow = free()
    assert slow.value is slow.value
    assert slow.counted == 1
    assert Slow.value.__doc__ == "A new list."


def test_instances_do_not_wait_for_each_other() -> None:
    held = Slow()
    with ThreadPoolExecutor(2) as pool:
        waiting = pool.submit(lambda: held.value)
        try:
            assert held.began.wait(60.0)
            assert pool.submit(lambda: free().value).result(60.0) == []
        finally:
            held.go_on.set()
        assert waiting.result(60.0) is held.value


def test_threads_that_ask_at_once_get_one_value() -> None:
    slow = Slow()
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(lambda: slow.value)
        assert slow.began.wait(60.0)
        slow.began.clear()
        second = pool.submit(lambda: slow.value)
        assert slow.began.wait(60.0)
        slow.go_on.set()
        assert first.result(60.0) is second.result(60.0) is slow.value
    assert slow.counted == 2


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
def test_a_child_forked_while_a_thread_computes_can_compute() -> None:
    held = Slow()
    thread = threading.Thread(target=lambda: held.value)
    thread.start()
    try:
        assert held.began.wait(60.0)
        process, reader = apart.start(lambda: free().value)
        if not apart.ended(process, 60.0):
            os.kill(process, signal.SIGKILL)
        assert apart.finish(process, reader) == (True, [])
    finally:
        held.go_on.set()
        thread.join()
