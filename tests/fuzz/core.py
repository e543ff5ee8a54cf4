"""What all attacks share: the random numbers of a case, limits of time and warnings, and what a case found."""

from __future__ import annotations

import importlib
import signal
import time
import traceback
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ATTACKS = (
    "junk",
    "terminal",
    "files",
    "kills",
    "disks",
    "ranges",
    "verdicts",
    "systems",
    "real_rods",
    "margins",
    "kicks",
    "consistency",
    "concurrency",
)
"""Names of all attacks: modules of this package."""

LONGEST = 10.0
"""Seconds in which a call that is not said to be long has to answer."""


class Found(NamedTuple):
    """How many answers a case compared, and one line for each that is wrong."""

    answers: int
    failures: list[str]


class TookTooLong(BaseException):
    """A call did not answer in time; no `Exception`, so that nothing on the way takes it for an error of its own."""


@dataclass
class Tally:
    """What the cases of an attack found so far."""

    attack: str
    cases: int = 0
    answers: int = 0
    seconds: float = 0.0
    failures: list[str] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        """Add what other cases of the same attack found."""
        self.cases += other.cases
        self.answers += other.answers
        self.seconds += other.seconds
        self.failures += other.failures


def load(attack: str) -> Any:
    """Return the module of an attack."""
    return importlib.import_module(f"tests.fuzz.{attack}")


def numbers(attack: str, seed: int, case: int) -> np.random.Generator:
    """Return the random numbers of a case, which are its own whatever ran before."""
    return np.random.default_rng([seed, zlib.crc32(attack.encode()), case])


def run(attack: str, seed: int, cases: range) -> Iterator[Tally]:
    """Yield the tally of each case in turn."""
    check: Callable[[np.random.Generator], Found] = load(attack).check
    for case in cases:
        started = time.perf_counter()
        with own_warnings_only():
            try:
                found = check(numbers(attack, seed, case))
            except (Exception, TookTooLong) as error:
                found = Found(1, [f"raised {told(error)}"])
        again = f"python -m tests.fuzz --only {attack} --seed {seed} --case {case}"
        lines = [f"{again}  # {line}" for line in found.failures]
        yield Tally(attack, 1, found.answers, time.perf_counter() - started, lines)


@contextmanager
def limit(seconds: float = LONGEST) -> Iterator[None]:
    """Raise `TookTooLong` in the main thread after so many seconds of processor time, which is that of one core.

    Compiled code is interrupted when it returns; what never returns is ended by the process that runs the attacks.
    """

    def expired(*_: object) -> None:
        raise TookTooLong(f"no answer within {seconds:g} s of processor time")

    before = signal.signal(signal.SIGPROF, expired)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@contextmanager
def own_warnings_only() -> Iterator[None]:
    """Turn every warning into an error, except for the classes that the package defines itself."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for category in own_warnings():
            warnings.simplefilter("ignore", category)
        yield


def own_warnings() -> list[type[Warning]]:
    """Return the warnings that the package defines."""
    import floquetrod.friction
    import floquetrod.rod  # noqa: F401  (defines one of them)

    waiting: list[type[Warning]] = [UserWarning, RuntimeWarning]
    found = []
    while waiting:
        waiting += (some := waiting.pop().__subclasses__())
        found += [kind for kind in some if kind.__module__.startswith("floquetrod")]
    return found


def told(error: BaseException) -> str:
    """Return an exception on one line, with the public function that was asked and the line that raised."""
    frames = traceback.extract_tb(error.__traceback__)
    inside = [frame for frame in frames if "floquetrod" in Path(frame.filename).parts] or frames
    where = f" in {inside[0].name}, {Path(inside[-1].filename).name}:{inside[-1].lineno}" if inside else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}{where}"
