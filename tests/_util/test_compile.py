"""Compiling: its cache, Ctrl-C meanwhile, threads and forks, and what is said of it.

What one process may do only once, or not at all in the process of the tests, is done in another one.
"""

from __future__ import annotations

import gc
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util import compilation, interrupt, kernel_cache
from floquetrod.cli import common
from floquetrod.floquet.kernels import powers
from floquetrod.floquet.mathieu_chains import mathieu_counts
from floquetrod.simulation import integration
from tests.conftest import needs_jit, some
from tests.seams import Tuned

ROOT = Path(__file__).parents[2]

TELL = "import logging, sys; logging.basicConfig(level='INFO', stream=sys.stdout, format='%(message)s')\n"
SMALL = """
import numpy as np
from floquetrod._util.compilation import compiled
from floquetrod.floquet.kernels.powers import displacement_fill
maps, out = np.array([[2.0, 0.0, 0.0, 2.0, 0.0]] * 3), np.empty(3)
def once():
    compiled(displacement_fill)(maps, out, 3)
    return f"{out[0]:.3f}"
"""
ANSWER = "-inf"  # the map is a multiple of the unit matrix: A stays zero


def python(program: str, cache: Path, **settings: str) -> subprocess.CompletedProcess[str]:
    """Run a program with a cache of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(cache), **settings}
    return subprocess.run(
        [sys.executable, "-P", "-c", program], capture_output=True, text=True, env=environment, timeout=600, check=False
    )


def kept(cache: Path) -> list[Path]:
    return sorted(path for path in cache.rglob("*") if path.is_file())


# --- the cache -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@needs_jit
def test_a_second_process_compiles_nothing_and_a_damaged_file_is_replaced(tmp_path: Path) -> None:
    first = python(TELL + SMALL + "print(once())", tmp_path)
    assert (first.stdout, first.stderr) == (f"compiling displacement_fill\n{ANSWER}\n", "")
    (file,) = kept(tmp_path)
    damage = (
        "from pathlib import Path\nfrom floquetrod._util import compilation\n"
        f"file = Path({str(file)!r})\nwhole = file.read_bytes()\n"
        "middle = len(whole) // 2\n"
        "flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]\n"
        "for content in (b'', whole[:40], whole[:-1], flipped):\n"
        "    file.write_bytes(content)\n"
        "    for _ in range(2):\n"
        "        compilation._compiled.cache_clear()\n"
        "        print(once())\n"
        "print('a folder', file=sys.stderr, flush=True)\n"
        "file.unlink()\nfile.mkdir()\n"
        "compilation._compiled.cache_clear()\n"
        "print(once())"
    )
    again = python(TELL + SMALL + "print(once())\n" + damage, tmp_path)
    before, _, after = again.stderr.partition("a folder\n")
    assert before == ""
    assert after.count("NUMBA_CACHE_DIR") == 1
    compiling = f"compiling displacement_fill\n{ANSWER}\n"
    assert again.stdout == f"{ANSWER}\n" + 4 * f"{compiling}{ANSWER}\n" + compiling


@pytest.mark.slow
@needs_jit
def test_without_any_folder_it_runs_uncached_and_says_so_once(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "floquetrod", tmp_path / "floquetrod", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "floquetrod/floquet/kernels/__pycache__").write_text(
        "a file: no folder can be made here, whoever runs this"
    )
    nowhere = str(tmp_path / "floquetrod/py.typed" / "below a file")
    program = (
        TELL
        + SMALL
        + "from floquetrod.floquet.kernels.leapfrog_map import leapfrog_map_fill; compiled(leapfrog_map_fill)\n"
    )
    run = python(
        program + "print(once(), once())",
        Path(nowhere),
        PYTHONPATH=str(tmp_path),
        HOME=nowhere,
        XDG_CACHE_HOME=nowhere,
        LOCALAPPDATA=nowhere,
        PYTHONDONTWRITEBYTECODE="1",
    )
    assert run.stdout == f"compiling displacement_fill\n{ANSWER} {ANSWER}\n", run.stderr
    assert run.stderr.count("RuntimeWarning") == 1
    assert "every process compiles them again" in run.stderr
    assert "set the environment variable NUMBA_CACHE_DIR" in run.stderr


@needs_jit
@pytest.mark.slow
@pytest.mark.parametrize("trouble", ["full", "gone"])
def test_a_disk_that_fails_meanwhile_costs_a_warning(trouble: str, tmp_path: Path) -> None:
    spoil = {
        "full": "import errno\n"
        "def replace(path, content): raise OSError(errno.ENOSPC, 'No space left on device')\n"
        "kernel_cache._replace = replace",
        "gone": "import shutil; shutil.rmtree(sys.argv[1]); open(sys.argv[1], 'w').close()",
    }[trouble]
    cache = tmp_path / "cache"
    program = (
        f"import sys; sys.argv[1:] = [{str(cache)!r}]\n"
        + SMALL
        + (f"from floquetrod._util import kernel_cache\ncompiled(displacement_fill)\n{spoil}\nprint(once(), once())")
    )
    run = python(program, cache)
    assert run.stdout == f"{ANSWER} {ANSWER}\n", run.stderr
    assert run.stderr.count("RuntimeWarning") == 1
    assert not kept(tmp_path / "cache")


@pytest.mark.slow
@needs_jit
def test_code_with_checked_indices_is_kept_beside_the_other(tmp_path: Path) -> None:
    short = TELL + SMALL + "out = np.empty(0)\ntry:\n    once()\nexcept IndexError:\n    print('checked')"
    assert python(TELL + SMALL + "print(once())", tmp_path, NUMBA_BOUNDSCHECK="0").stdout.endswith(f"{ANSWER}\n")
    for said in ("compiling displacement_fill\nchecked\n", "checked\n"):
        assert python(short, tmp_path, NUMBA_BOUNDSCHECK="1").stdout == said
    assert len(kept(tmp_path)) == 2


def test_a_file_is_whole_or_not_there(tmp_path: Path) -> None:
    file = tmp_path / "kernel.nbc"
    kernel_cache._replace(file, b"one")
    umask = os.umask(0)
    os.umask(umask)
    assert file.stat().st_mode & 0o777 == 0o666 & ~umask  # others who share the installation read it
    with pytest.raises(TypeError):
        kernel_cache._replace(file, "not bytes")  # type: ignore[arg-type]
    assert file.read_bytes() == b"one"
    assert kept(tmp_path) == [file]


@pytest.mark.slow
@needs_jit
def test_a_kernel_is_compiled_again_when_what_it_calls_or_reads_changes_in_another_file(tmp_path: Path) -> None:
    sources = {
        "low.py": "from floquetrod._util.compilation import kernel\nfrom deep import FACTOR\n"
        "@kernel\ndef inner(x: float) -> float:\n    return FACTOR * x + 1.0\n",
        "deep.py": "FACTOR = 2.0\n",
        "high.py": "from floquetrod._util.compilation import kernel\nfrom low import inner\n"
        "@kernel\ndef outer(x: float) -> float:\n    return inner(x)\n",
    }
    for name, text in sources.items():
        (tmp_path / name).write_text(text)
    program = TELL + "from floquetrod._util.compilation import compiled; import high; print(compiled(high.outer)(10.0))"
    settings = {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)]), "PYTHONDONTWRITEBYTECODE": "1"}
    assert python(program, tmp_path / "cache", **settings).stdout == "compiling outer\n21.0\n"
    for file, old, new, said in (
        ("low.py", "import FACTOR", "import FACTOR\n\n# moved down", "21.0\n"),
        ("low.py", "+ 1.0", "+ 2.0", "compiling outer\n22.0\n"),
        ("deep.py", "2.0", "3.0", "compiling outer\n32.0\n"),
    ):
        path = tmp_path / file
        path.write_text(path.read_text().replace(old, new))
        assert python(program, tmp_path / "cache", **settings).stdout == said
        assert len(kept(tmp_path / "cache")) == 1  # what no longer fits is replaced


@pytest.mark.slow
@needs_jit
def test_code_for_two_record_types_compiled_in_two_processes_is_kept_apart(tmp_path: Path) -> None:
    """The numbers by which numba counts the record types that a process meets must not name their code."""
    roots = "".join(f"        total += math.sqrt(abs(record['end'] + {k}.0 - total))\n" for k in range(40))
    (tmp_path / "ends.py").write_text(
        "import math\nfrom floquetrod._util.compilation import kernel\n"
        "@kernel\ndef many(record: object, times: int) -> float:\n"  # too large to be inlined: it has its own name
        f"    total = 0.0\n    for _ in range(times):\n{roots}    return total\n"
        "@kernel\ndef end(record: object) -> float:\n"
        "    return many(record, 2) + many(record, 3)\n"
    )
    program = (
        "import numpy as np; import ends; from floquetrod._util.compilation import compiled\n"
        "for size in {}:\n"
        "    record = np.zeros(1, [('values', float, (size,)), ('end', float)])[0]\n"
        "    record['end'] = size\n"
        "    print(abs(compiled(ends.end)(record) - ends.end(record)) < 1e-9, end=' ')"
    )
    settings = {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)]), "PYTHONDONTWRITEBYTECODE": "1"}
    for sizes in ([3], [5], [3, 5], [5, 3]):
        run = python(program.format(sizes), tmp_path / "cache", **settings)
        assert run.stdout == "True " * len(sizes), run.stderr
    assert len(kept(tmp_path / "cache")) == 2


def test_what_a_fingerprint_cannot_see_is_refused() -> None:
    scope: dict[str, Any] = {"__name__": "here", "TABLE": {1: 2.0}, "GOOD": (1, (2.0, "x"), np.arange(2000.0))}
    exec("def f(x):\n    return GOOD\ndef g(x):\n    return TABLE[x]", scope)
    options = compilation._OPTIONS
    one = kernel_cache.fingerprint(scope["f"], options)
    assert one == kernel_cache.fingerprint(scope["f"], options)
    scope["GOOD"][2][1000] += 1e-9
    assert one != kernel_cache.fingerprint(scope["f"], options)
    assert kernel_cache.fingerprint(scope["f"], {**options, "fastmath": True}) != one
    with pytest.raises(TypeError, match=r"here\.g reads TABLE, of type dict"):
        kernel_cache.fingerprint(scope["g"], options)


def test_every_kernel_has_a_fingerprint_of_its_own() -> None:
    import importlib
    import pkgutil

    found = {
        value
        for module in pkgutil.walk_packages(fr.__path__, "floquetrod.")
        if not module.name.endswith("__main__")
        for value in vars(importlib.import_module(module.name)).values()
        if getattr(value, "__kernel__", False)
    }
    assert len(found) > 60
    assert len({kernel_cache.fingerprint(function, {}) for function in found}) == len(found)


# --- Ctrl-C ----------------------------------------------------------------------------------------------------------

BIG = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a process in the background would inherit "ignore"
import numpy as np
from floquetrod._util.compilation import compiled
from floquetrod.floquet.kernels.mathieu_discriminant import damped_stable_fill
points, out = np.linspace(-1.0, 1.0, 50), np.empty(50, dtype=bool)
def once():
    compiled(damped_stable_fill)(points, points, 0.1 + 0.0 * points, out)
"""


@pytest.mark.slow
@needs_jit
def test_ctrl_c_where_numba_forgets_exceptions_is_heard_and_compiling_can_be_tried_again(tmp_path: Path) -> None:
    # LLVM calls this hook through ctypes, which prints an exception and goes on.
    program = SMALL + (
        "import os, signal\n"
        "from numba.core.codegen import CPUCodeLibrary as Library\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "hook, times = Library._object_compiled_hook.__func__, []\n"
        "def interrupted(cls, *arguments):\n"
        "    if not times:\n"
        "        times.append(1)\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    hook(cls, *arguments)\n"
        "Library._object_compiled_hook = classmethod(interrupted)\n"
        "try:\n    once(); print('lost')\nexcept KeyboardInterrupt:\n    print('heard')\n"
        "print(once(), len(times), signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    )
    run = python(program, tmp_path)
    assert (run.stdout, run.stderr) == (f"heard\n{ANSWER} 1 True\n", "")


@pytest.mark.slow
@needs_jit
@pytest.mark.parametrize("delay", [0.4, *(pytest.param(delay, marks=pytest.mark.slow) for delay in (0.0, 1.1))])
def test_ctrl_c_while_numba_compiles_ends_it(delay: float, tmp_path: Path) -> None:
    hearing = "try:\n    print('ready', flush=True)\n    once()\n    signal.pause()\n"  # should compiling be faster
    program = BIG + hearing + "except KeyboardInterrupt:\n    print('heard')\n"
    run = interrupted([sys.executable, "-P", "-c", program], delay, tmp_path)
    assert run == ("heard\n", "", 0)


@pytest.mark.slow
@needs_jit
@pytest.mark.parametrize("delay", some(np.linspace(0.05, 2.5, 25), 9, 5))
def test_ctrl_c_ends_a_command_that_compiles(delay: float, tmp_path: Path) -> None:
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n" + (
        "from floquetrod.cli import main; print('ready', flush=True); sys.exit(main())"
    )
    big = ["--mean", "0:1.1Fcr", "--amplitude", "0.2Fcr", "--frequency", "20:200", "--points", "4900x4900"]
    out = ["--out", str(tmp_path / "map.npz")]
    _, said, status = interrupted(
        [sys.executable, "-P", "-c", program, "map", "--rod", "nitinol", *big, *out], delay, tmp_path
    )
    assert status == 130, said
    assert "Traceback" not in said
    assert said.endswith("floquetrod: interrupted\n")


def interrupted(command: list[str], delay: float, cache: Path) -> tuple[str, str, int]:
    """Interrupt a program, which says when it is ready, after a delay; return what else it says, and its status."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(cache)}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, env=environment, **pipes) as run:  # type: ignore[call-overload]
        assert run.stdout.readline() == "ready\n"
        time.sleep(delay)
        run.send_signal(signal.SIGINT)
        out, said = run.communicate(timeout=600)
    return out, said, run.returncode


def test_held_ctrl_c_is_delivered_when_asked_and_at_the_end() -> None:
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    steps = []

    def asked() -> None:
        with interrupt.held() as deliver:
            deliver()
            signal.raise_signal(signal.SIGINT)
            steps.append("held")
            deliver()
            steps.append("not reached")

    def at_the_end(error: Exception | None) -> None:
        with interrupt.held():
            signal.raise_signal(signal.SIGINT)
            steps.append("held to the end")
            if error is not None:
                raise error

    try:
        with pytest.raises(KeyboardInterrupt):
            asked()
        with pytest.raises(KeyboardInterrupt):
            at_the_end(None)
        with pytest.raises(KeyboardInterrupt):
            at_the_end(RuntimeError("which does not hide Ctrl-C"))
        assert steps == ["held", "held to the end", "held to the end"]
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        heard: list[int] = []
        signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
        with interrupt.held() as deliver:
            signal.raise_signal(signal.SIGINT)
            assert heard == []
            deliver()
            assert heard == [signal.SIGINT]
        assert heard == [signal.SIGINT]
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        with interrupt.held():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_leave_signals_alone() -> None:
    seen = []

    def hold() -> None:
        with interrupt.held() as deliver:
            deliver()
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=hold)
    thread.start()
    thread.join()
    assert seen == [signal.getsignal(signal.SIGINT)]


# --- threads and forks -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@needs_jit
def test_many_threads_that_ask_first_get_one_compilation(tmp_path: Path) -> None:
    program = (
        TELL
        + SMALL
        + (
            "from concurrent.futures import ThreadPoolExecutor\n"
            "with ThreadPoolExecutor(8) as pool:\n"
            "    print({task.result() for task in [pool.submit(once) for _ in range(8)]})"
        )
    )
    assert python(program, tmp_path).stdout == f"compiling displacement_fill\n{{{ANSWER!r}}}\n"


@pytest.mark.slow
@needs_jit
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
def test_a_child_forked_while_a_thread_compiles_is_not_stuck(tmp_path: Path) -> None:
    program = SMALL + (
        "import os, sys, threading, time, warnings\n"
        "warnings.simplefilter('ignore', DeprecationWarning)  # Python warns of forks beside threads\n"
        "thread = threading.Thread(target=once); thread.start(); time.sleep(0.6)\n"
        "child = os.fork()\n"
        "if child == 0:\n    os._exit(0 if once() == '-inf' else 1)\n"
        "thread.join(); print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))"
    )
    assert python(program, tmp_path).stdout == "0\n"


@pytest.mark.slow
@needs_jit
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_worker_processes_compile_and_agree(method: str, tmp_path: Path) -> None:
    import multiprocessing

    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"there is no {method} here")
    program = SMALL + (
        "import multiprocessing, sys\n"
        "from concurrent.futures import ProcessPoolExecutor\n"
        "import floquetrod as fr\n"
        f"context = multiprocessing.get_context({method!r})\n"
        "with ProcessPoolExecutor(2, mp_context=context) as pool:\n"
        "    points = [np.linspace(-1.0, 0.2, 100)] * 2\n"
        "    first, second = pool.map(fr.mathieu.is_stable, [0.5, 0.5], points)\n"
        "print((first == second).all(), (first == fr.mathieu.is_stable(0.5, points[0])).all())"
    )
    run = python(program, tmp_path)
    assert run.stdout == "True True\n", run.stderr


@pytest.mark.slow
@needs_jit
@pytest.mark.skipif(sys.platform == "win32", reason="files are not locked there")
def test_processes_that_start_together_compile_once(tmp_path: Path) -> None:
    program = TELL + SMALL + "print(compiled(displacement_fill).__name__, flush=True); input(); print(once())"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path)}
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    both = [subprocess.Popen([sys.executable, "-P", "-c", program], env=environment, **pipes) for _ in range(2)]
    assert [process.stdout.readline() for process in both if process.stdout] == 2 * ["displacement_fill\n"]
    for process in both:
        assert process.stdin
        process.stdin.write("\n")
        process.stdin.flush()
    said = sorted(process.communicate(timeout=600)[0] for process in both)
    assert said == [f"{ANSWER}\n", f"compiling displacement_fill\n{ANSWER}\n"]
    assert len(kept(tmp_path)) == 1


@pytest.mark.slow
def test_nobody_waits_for_ever_for_a_process_that_compiles(tmp_path: Path, tuned: Tuned) -> None:
    tuned(seconds_for_another_to_compile=0.3)
    asked: list[None] = []
    other = kernel_cache._locked(tmp_path / "kernel.nbc", lambda: None)
    assert other is not None
    if sys.platform == "linux":  # elsewhere a process does not exclude itself
        assert kernel_cache._locked(tmp_path / "kernel.nbc", lambda: asked.append(None)) is None
        assert len(asked) == 3
    other.release()
    (tmp_path / "file").touch()
    assert kernel_cache._locked(tmp_path / "file" / "kernel.nbc", lambda: None) is None


@pytest.fixture
def willing(tuned: Tuned) -> None:
    """Let any work be worth a thread."""
    tuned(seconds_worth_a_thread=1e-12)


@pytest.mark.parametrize(("seconds", "workers", "shared"), [(1e-5, 8, 0), (4e-4, 8, 3), (1.0, 8, 8), (1.0, 1, 0)])
def test_each_thread_gets_a_millisecond_of_work_or_is_not_started(
    seconds: float, workers: int, shared: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter(np.arange(1000) * seconds)
    started: list[int] = []
    monkeypatch.setattr(compilation.time, "perf_counter", lambda: next(clock))

    def share(run: Callable[..., None], left: Iterator[Any], threads: int) -> None:
        started.append(threads)
        share_truly(run, left, threads)

    share_truly = compilation._share
    monkeypatch.setattr(compilation, "_share", share)
    done: list[int] = []
    compilation.in_threads(done.append, [(k,) for k in range(10)], workers)
    assert sorted(done) == list(range(10))
    assert started == ([shared] if shared else [])


def test_threads_work_side_by_side_in_the_context_of_the_call(willing: None) -> None:
    both, kept = threading.Barrier(2), []

    def run(piece: int) -> None:
        if piece > 0:
            both.wait(60.0)
        kept.append((threading.current_thread(), np.geterr()["over"]))

    with np.errstate(over="raise"):
        compilation.in_threads(run, [(k,) for k in range(3)], 2)
    assert {how for _, how in kept} == {"raise"}
    assert [thread.is_alive() for thread in {thread for thread, _ in kept}].count(True) == 1  # this one


def test_a_failure_in_any_thread_ends_the_work(willing: None) -> None:
    tried = []

    def run(piece: int) -> None:
        tried.append(piece)
        if piece > 0:
            raise RuntimeError("broken")

    before = threading.active_count()
    with pytest.raises(RuntimeError, match="broken"):
        compilation.in_threads(run, [(k,) for k in range(10_000)], 4)
    assert len(tried) <= 5
    assert threading.active_count() == before


class Pieces(list[tuple[int]]):
    """Pieces of work that say when all of them have been taken."""

    def __iter__(self) -> Iterator[tuple[int]]:
        self.taken, self.all_taken = super().__iter__(), threading.Event()
        return iter(self._next, None)

    def _next(self) -> tuple[int] | None:
        try:
            return next(self.taken)
        except StopIteration:
            self.all_taken.set()
            return None


def test_ctrl_c_while_threads_work_ends_it_between_pieces(willing: None) -> None:
    pieces = Pieces((k,) for k in range(1000))
    both, ended = threading.Barrier(2), []

    def run(piece: int) -> None:
        if piece in (1, 2):  # one each
            both.wait(60.0)
            if threading.current_thread() is threading.main_thread():
                signal.raise_signal(signal.SIGINT)
        elif piece > 2:  # the other thread, while this one hears of it
            assert pieces.all_taken.wait(60.0)
        ended.append(piece)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            compilation.in_threads(run, pieces, 2)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert set(ended) <= {0, 1, 2, 3}


def test_results_do_not_depend_on_threads_to_the_bit(willing: None, rng: np.random.Generator) -> None:
    size = 9000
    alpha, beta, damping = rng.uniform(0.0, 30.0, size), rng.uniform(-40.0, 5.0, size), rng.uniform(0.0, 0.3, size)
    systems = fr.HillSystem([[1, 0], [0, 4]], [[[0.1, 0.2], [0.2, 0.16]]], period=np.linspace(1.0, 9.0, size))
    for ask in (
        lambda workers: fr.mathieu.is_stable(alpha, beta, workers=workers),
        lambda workers: fr.mathieu.growth_rate(alpha, beta, damping, workers=workers),
        lambda workers: fr.systems.growth_rate(systems, workers=workers),
    ):
        one = ask(1).tobytes()
        assert [ask(workers).tobytes() == one for workers in (None, 2, 3)] == [True] * 3


def test_systems_without_affinities_count_all_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert compilation.cores() == (os.cpu_count() or 1)


# --- what is said, and counted ---------------------------------------------------------------------------------------


@pytest.fixture
def _no_lines_about_compiling() -> None:
    """Let these tests read what is said of compiling, unlike all others."""


def test_the_terminal_says_once_that_it_compiles(capsys: pytest.CaptureFixture[str]) -> None:
    log = logging.getLogger("floquetrod.compile")
    level, handlers = log.level, list(log.handlers)
    with common.compiling_told():
        log.info("compiling %s", "one")
        log.info("compiling %s", "two")
    assert capsys.readouterr().err == "floquetrod: compiling, once; this takes some seconds\n"
    log.info("compiling %s", "three")
    assert capsys.readouterr().err == ""
    assert (log.level, log.handlers) == (level, handlers)


@pytest.mark.slow
@needs_jit
def test_compiling_that_takes_long_is_told_once_in_a_process(tmp_path: Path) -> None:
    program = SMALL + (
        "from floquetrod._util import compilation\n"
        "compilation._LONG = 0.0\n"
        "from floquetrod.floquet.mathieu_chains.mathieu_counts import shown_one_by_one\n"
        "once(); compiled(shown_one_by_one)(maps[:, 0].copy(), maps[:, 1].copy(), np.empty(3, np.int8))"
    )
    first, second = python(program, tmp_path), python(program, tmp_path)
    assert first.stderr.startswith("floquetrod is compiling, once")
    assert first.stderr.count("\n") == 1
    assert (first.stdout, second.stdout, second.stderr) == ("", "", "")


@pytest.mark.slow
@needs_jit
def test_a_command_says_that_it_compiles(tmp_path: Path) -> None:
    call = ["map", "--rod", "nitinol", "--mean", "0:1Fcr", "--amplitude", "0.2Fcr", "--frequency", "20:200rad/s"]
    small = [*call, "--points", "30x30", "--paper-criterion", "leapfrog", "--out", str(tmp_path / "map.npz")]
    command = "from floquetrod._util import waiting\nfrom floquetrod.cli import main\n"
    command += "waiting.PLAIN = 1e6\n"  # no lines of progress, however slow
    command += f"main({small!r})"
    assert python(command, tmp_path).stderr == "floquetrod: compiling, once; this takes some seconds\n"
    assert python(command, tmp_path).stderr == ""


def test_the_clock_of_a_simulation_starts_when_all_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    order: list[str] = []
    clock = time.monotonic

    def recorded(function: Callable[..., Any], *arguments: Any) -> Callable[..., Any]:
        order.append(f"compile {function.__name__}")
        return compilation.compiled_for(function, *arguments)

    def tick() -> float:
        order.append("clock")
        return clock()

    monkeypatch.setattr(integration, "compiled_for", recorded)
    monkeypatch.setattr(integration.time, "monotonic", tick)
    load = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
    fr.simulate(fr.Rod.nitinol(), load, duration=1e-4, segments=60, frames=2)
    assert order[:3] == ["compile advance", "compile drift", "clock"]
    assert set(order[3:]) == {"clock"}


# --- interpreted or compiled


def test_small_work_and_little_work_are_interpreted(monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    monkeypatch.setattr(compilation, "compiled", lambda function: "machine code")
    tuned(interpreted_work={})

    def chosen(size: int, **options: int) -> str:
        return "machine code" if compilation.runner(len, size, **options) == "machine code" else "interpreted"

    few = compilation.INTERPRETED_UP_TO
    assert [chosen(size) for size in (0, few, few + 1)] == ["interpreted", "interpreted", "machine code"]
    assert [chosen(size, interpret_up_to=0, compile_after=9) for size in (0, 1)] == ["interpreted", "machine code"]
    # Three times 40 elements are up to 30 times as many as 4; what is always interpreted does not count.
    asked = [chosen(size, interpret_up_to=4, compile_after=30) for size in (40, 4, 40, 4, 40, 4, 40, 4)]
    assert asked == ["interpreted"] * 6 + ["machine code", "interpreted"]


# --- one compilation for a kernel ------------------------------------------------------------------------------------


def test_first_loads_of_a_rod_are_interpreted_unless_they_take_long(
    monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    rod, rng, asked = fr.Rod.nitinol(), np.random.default_rng(1), []
    mean, amplitude = rod.critical_force * rng.uniform(0.0, 1.0, (2, 100))
    tuned(interpreted_work={})
    monkeypatch.setattr(compilation, "compiled", lambda kernel: asked.append(kernel.__name__) or kernel)
    tuned(is_modes_kernel_on_disk=lambda kernel: False)
    tuned(milliseconds_to_load_numba=100.0)
    rod.is_stable(mean=mean, amplitude=amplitude, frequency=150.0)
    assert not asked
    for _ in range(4):
        rod.is_stable(mean=mean, amplitude=amplitude, frequency=150.0)
    assert "modes_stable_fill" in asked
    asked.clear()
    rod.replace(length=100.0 * rod.length).is_stable(mean=mean[:65], amplitude=amplitude[:65], frequency=150.0)
    assert asked == ["modes_stable_fill"]


@pytest.mark.slow
@needs_jit
def test_first_loads_of_a_rod_have_the_bits_of_machine_code(tuned: Tuned) -> None:
    rod, rng = fr.Rod.nitinol(), np.random.default_rng(1)
    mean, amplitude, frequency = np.array([[1.0], [0.6], [150.0]]) * rng.uniform(0.2, 1.0, (3, 1000))
    tuned(interpreted_work={})
    answers = []
    for at_hand in (False, True):
        tuned(is_modes_kernel_on_disk=lambda kernel, answer=at_hand: answer)
        answers.append(rod.growth_rate(mean=mean, amplitude=amplitude, frequency=frequency, return_mode=True))
        assert np.count_nonzero(answers[-1][0])
    assert all(map(np.array_equal, *answers))


@needs_jit
def test_a_kernel_is_compiled_once_whatever_arrays_come(tmp_path: Path) -> None:
    locked = np.linspace(0.1, 1.0, 100)
    locked.flags.writeable = False
    plain, strided = locked.copy(), np.repeat(locked, 2)[::2]
    runs = [fr.mathieu.is_stable(a, -0.3) for a in (plain, locked, strided, plain.astype(np.float32), plain.tolist())]
    runs += [fr.FiniteTimeCriterion(by="leapfrog").growth(a, -0.3) > 0.0 for a in (plain, locked, strided)]
    assert all(len(run) == 100 for run in runs)
    for used in (mathieu_counts.shown_fill, powers.displacement_fill):
        before = len(compilation.compiled(used).signatures)
        out = np.empty(100, dtype=np.int8 if used is mathieu_counts.shown_fill else np.float64)
        inputs = (locked, locked) if used is mathieu_counts.shown_fill else (np.ones((100, 5))[:, ::-1],)
        constants = () if used is mathieu_counts.shown_fill else (3,)
        compilation.over_chunks(used, inputs, out, *constants)
        assert len(compilation.compiled(used).signatures) == before


COUNTED = """
import json
import numpy as np
import floquetrod as fr
import floquetrod.mathieu.array_functions
from floquetrod._util import compilation
made = {}
plain = compilation._compiled
def noted(function):
    made[function.__name__] = plain(function)
    return made[function.__name__]
compilation._compiled = noted
from numba.core import event
callees = []
class Compiled(event.Listener):
    def on_start(self, e):
        d = e.data["dispatcher"]
        if d.py_func.__module__.startswith("floquetrod"):
            callees.append(d.py_func.__qualname__)
    def on_end(self, e):
        pass
event.register("numba:compile", Compiled())
floquetrod.mathieu.array_functions._COMPILE_AFTER = 0  # short questions are compiled here too
from floquetrod.rod.mode_equations import modal_systems
modal_systems.is_at_hand = lambda kernel: True
a = np.linspace(0.1, 1.0, 200)
locked = a.copy()
locked.flags.writeable = False
rod = fr.Rod.nitinol()
for x in (a, locked, a[::2], np.arange(1, 101), 1.5):
    fr.mathieu.is_stable(x, -0.3 * a[0])
    fr.mathieu.is_stable(np.ones(100), x if np.size(x) == 100 else -0.5, 0.1)
    fr.mathieu.growth_rate(np.ones(100), -0.5, x if np.size(x) == 100 else 0)
    rod.is_stable(mean=x, amplitude=0.3, frequency=np.linspace(50.0, 99.0, np.size(x)), growth_tolerance=0)
    rod.is_stable(mean=0.3, amplitude=x, frequency=99, growth_tolerance=0.5)
    rod.growth_rate(mean=0.3, amplitude=x, frequency=99, return_mode=True)
load = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
fr.simulate(rod, load, duration=1e-4, segments=60, frames=2)
fr.simulate(rod, load, duration=1e-4, segments=60, frames=2, friction=0.1, time_step=1e-6)
counts = {name: len(run.signatures) for name, run in made.items()}
print(json.dumps({"signatures": counts, "callees": {name: callees.count(name) for name in callees}}))
"""


@pytest.mark.slow
@needs_jit
def test_public_calls_compile_each_kernel_and_each_callee_once(tmp_path: Path) -> None:
    import json

    run = python(COUNTED, tmp_path)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert {"modes_stable_fill", "damped_stable_fill", "modes_growth_fill", "advance"} <= set(found["signatures"])
    assert {name: count for name, count in found["signatures"].items() if count != 1} == {}
    # Nodes move with friction, and without it: that constant pays.
    assert {name: count for name, count in found["callees"].items() if count != 1} == {"move_nodes": 2}


@pytest.mark.parametrize("collects", [True, False])
def test_garbage_is_collected_after_compiling_as_before(collects: bool) -> None:
    """Not meanwhile, and not by an inner use, of a kernel that another one calls, before the outer one ends."""
    before = gc.isenabled()
    try:
        (gc.enable if collects else gc.disable)()
        with compilation._compiling():
            with compilation._compiling():
                pass
            assert not gc.isenabled()
        assert gc.isenabled() == collects
    finally:
        (gc.enable if before else gc.disable)()
