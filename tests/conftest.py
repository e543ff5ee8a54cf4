"""Settings of the whole suite: how deeply it looks, random numbers that can be drawn again, `--bite`."""

from __future__ import annotations

import contextlib
import gc
import importlib
import logging
import os
import re
import secrets
import signal
import sys
import threading
import time
import zlib
from collections.abc import Callable, Generator, Iterable
from pathlib import Path
from typing import Any, TypeVar

# Before numpy is loaded: the workers of a run share the processors, and threads of small matrices only wait for each
# other there (measured: eigenvalues of a few hundred rows twenty times slower).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest
from hypothesis import HealthCheck, is_hypothesis_test, settings
from hypothesis.internal.conjecture import providers

Case = TypeVar("Case")
SEED = "FLOQUETROD_TEST_SEED"
QUICK_SEED = 104031710  # of `make test`; any other does
BITES: dict[str, tuple[int, ...]] = {}
"""Examples checked and discarded, of each property."""

LEAST_SHARE = 0.3
"""Share of the examples drawn that a property has to be true of, rather than discard (a choice)."""

DEEP = os.environ.get("FLOQUETROD_TEST_DEPTH") == "deep"
"""Whether to look as deeply as `make slow` does: at many examples, fresh in every run.

`make test` draws few and always the same, so that one tree either passes or fails; `make slow` and `make fuzz` search.
The report's header tells how to draw them again (`FLOQUETROD_TEST_SEED`, and hypothesis prints a blob).
"""


def depth(deep: int, quick: int) -> int:
    """Return how often to draw: the first number when the suite looks deeply, else the second."""
    return deep if DEEP else quick


def some(cases: Iterable[Case], many: int, few: int) -> list[Case]:
    """Return `depth(many, few)` of the cases, in their order: others in each run of `make slow`, else always the same.

    For cases of seconds each: all of them stay, and which ones are tried changes from run to run.
    """
    every = list(cases)
    rng = np.random.default_rng(int(os.environ.get(SEED, QUICK_SEED)))
    chosen = rng.choice(len(every), min(depth(many, few), len(every)), replace=False)
    return [every[i] for i in sorted(chosen)]


# No deadline: nothing is timed.
settings.register_profile("default", deadline=None, print_blob=True, derandomize=not DEEP, max_examples=depth(100, 15))
# Without the compiler an example costs about a hundred times more.
settings.register_profile(
    "interpreted",
    deadline=None,
    print_blob=True,
    derandomize=not DEEP,
    max_examples=depth(6, 3),
    suppress_health_check=[HealthCheck.too_slow],
)
JIT = os.environ.get("NUMBA_DISABLE_JIT", "0") != "1"
needs_jit = pytest.mark.skipif(not JIT, reason="nothing is compiled with NUMBA_DISABLE_JIT=1")
settings.load_profile("default" if JIT else "interpreted")
if not DEEP:
    # Hypothesis reads the numbers that stand in the code, for seconds in each worker, to draw some of them: after every
    # change of the code, other ones.
    providers._get_local_constants = lambda: providers._local_constants


def pytest_configure(config: pytest.Config) -> None:
    """Choose the seed of the run before the worker processes start, so that all of them inherit it; hear Ctrl-C.

    A run in the background inherits that Ctrl-C is ignored, and so would all that its tests start and interrupt.
    """
    os.environ.setdefault(SEED, str(secrets.randbits(63) if DEEP else QUICK_SEED))
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell every other worker process to import the test files backwards, where all are to be imported."""
    every = node.config.args_source is pytest.Config.ArgsSource.TESTPATHS
    node.workerinput["backwards"] = every and int(node.gateway.id.removeprefix("gw")) % 2 == 1


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Let no garbage be collected among test files, modules and tests, now or later: nearly all of them stay.

    What pytest makes of a test file, in a new tree, is kept for the next process.  Two workers that import the files
    from both ends make one half each; from the same end both would make all.
    """
    gc.disable()
    if getattr(session.config, "workerinput", {}).get("backwards"):
        for path in sorted(Path(__file__).parent.rglob("test_*.py"), reverse=True):
            name = ".".join(path.relative_to(Path(__file__).parents[1]).with_suffix("").parts)
            with contextlib.suppress(Exception, pytest.skip.Exception):  # told when pytest collects the file
                importlib.import_module(name)
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(20_000, 20, 20)  # compiling makes many objects and little garbage: a twentieth of all the work
        gc.enable()


def pytest_report_header(config: pytest.Config) -> str:
    """Tell how to draw the same numbers again."""
    return f"random numbers: {SEED}={os.environ[SEED]}"


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """Random numbers of this run and this test; set FLOQUETROD_TEST_SEED to the printed value to draw them again.

    A test draws the same in whichever folder its file lies.
    """
    path, colons, test = request.node.nodeid.partition("::")
    name = f"tests/{Path(path).name}{colons}{test}"
    return np.random.default_rng([int(os.environ[SEED]), zlib.crc32(name.encode())])


@pytest.fixture
def tuned(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Set constants of the package for a test, by their names in `tests/seams.py`."""
    from tests.seams import CONSTANTS

    def tune(**values: Any) -> None:
        for name, value in values.items():
            for place in CONSTANTS[name]:
                module, _, attribute = place.rpartition(".")
                monkeypatch.setattr(importlib.import_module(f"floquetrod.{module}"), attribute, value)

    return tune


@pytest.fixture
def forbidden(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any, str], None]:
    """Let a test fail that calls a function of a module or class."""

    def forbid(owner: Any, name: str) -> None:
        monkeypatch.setattr(owner, name, lambda *_, **__: pytest.fail(f"{name} was called"))

    return forbid


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any, str], list[tuple[Any, ...]]]:
    """Listen to a function of a module or class: return the list of the arguments of its calls, which grows."""

    def hear(owner: Any, name: str) -> list[tuple[Any, ...]]:
        calls: list[tuple[Any, ...]] = []
        function = getattr(owner, name)

        def listening(*arguments: Any, **named: Any) -> Any:
            calls.append(arguments)
            return function(*arguments, **named)

        monkeypatch.setattr(owner, name, listening)
        return calls

    return hear


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Stop the clock by which progress and saves go: a list of its seconds, which a test sets."""
    seconds = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: seconds[0])
    return seconds


@pytest.fixture
def saved(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Let the terminal save no figure, and return the list of those that it would have saved."""
    from floquetrod.plotting import chart_plot

    figures: list[Any] = []
    monkeypatch.setattr(chart_plot, "save_figure", lambda figure, path: figures.append(figure))
    return figures


@pytest.fixture(autouse=True)
def _no_lines_of_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no slow machine add lines to stderr that a test reads."""
    monkeypatch.setattr("floquetrod._util.waiting.PLAIN", 1e6)


@pytest.fixture(autouse=True)
def _no_lines_about_compiling(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no kernel that this test is the first to compile add a line to stderr."""
    monkeypatch.setattr(logging.getLogger("floquetrod.compile"), "disabled", True)


@pytest.fixture(autouse=True, scope="module")
def _no_figures_of_other_files() -> Generator[None]:
    """Close the figures that the tests of a file have left open."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


# --- how often each property bit -------------------------------------------------------------------------------------


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--bite`."""
    parser.addoption("--bite", action="store_true", help="run properties only, and count the examples they discard")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out files without kernels when only those are asked for: importing them all takes as long as the tests."""
    only_kernels = config.option.markexpr.startswith("kernels") and collection_path.match("test_*.py")
    return True if only_kernels and "mark.kernels" not in collection_path.read_text(encoding="utf-8") else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave only properties when asked how often they bite."""
    if config.getoption("--bite"):
        others = [item for item in items if not is_hypothesis_test(getattr(item, "obj", None))]
        config.hook.pytest_deselected(items=others)
        items[:] = [item for item in items if item not in set(others)]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Read off hypothesis's statistics how many examples were checked and discarded."""
    report = yield
    told = getattr(item, "hypothesis_statistics", None)
    if told and report.when == "call":
        counts = re.findall(r"(\d+) passing\D+(\d+) failing\D+(\d+) invalid", told)
        report.examples = [sum(int(count[column]) for count in counts) for column in (0, 2)]
    return report


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Collect what the worker processes report."""
    if hasattr(report, "examples"):
        BITES[report.nodeid] = tuple(report.examples)


def toothless(bites: dict[str, tuple[int, ...]]) -> list[str]:
    """Return the properties that were checked too rarely, or of which nothing is known."""
    return [name for name, (checked, discarded) in bites.items() if not checked > LEAST_SHARE * (checked + discarded)]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail where a property hardly bit, or none was seen to."""
    asked = session.config.getoption("--bite") and not hasattr(session.config, "workerinput")
    if asked and session.exitstatus == pytest.ExitCode.OK and (toothless(BITES) or not BITES):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell how often each property bit, those that discard most first."""
    if config.getoption("--bite"):
        terminalreporter.section("examples checked, discarded")
        few = toothless(BITES)
        for name, (checked, discarded) in sorted(BITES.items(), key=lambda bite: bite[1][0] / max(1, sum(bite[1]))):
            remark = "  TOO FEW" if name in few else ""
            terminalreporter.write_line(f"{checked:6d} {discarded:6d}  {name}{remark}")
