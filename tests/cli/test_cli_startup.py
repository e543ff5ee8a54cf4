"""A command of the terminal imports what it needs alone, and its standard streams may be closed, full or broken."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

PARAMETERS = {f"floquetrod.rod{name}" for name in ("", ".model", ".model.parameters")}
"""What the options of the terminal are made of: it needs neither numpy nor a rod."""
CHECK = "check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 24Hz --no-margins"
_COMMAND = f"exec {sys.executable} -m floquetrod"


def loaded_after(*arguments: str) -> set[str]:
    """Return the modules that a fresh interpreter has loaded after a command."""
    code = (
        "import contextlib, io, sys\nfrom floquetrod.cli import main\n"
        f"with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit): main({list(arguments)!r})\n"
        "print(*sys.modules)"
    )
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def _own(modules: set[str]) -> set[str]:
    """Return which commands, and which packages of floquetrod's, are among modules."""
    return {each.split(".")[1] for each in modules if each.startswith("floquetrod.")}


@pytest.mark.parametrize(
    ("first", "given", "threads"),
    [
        ("", {}, "1"),
        pytest.param("", {"MKL_NUM_THREADS": "3"}, "None", marks=pytest.mark.slow),
        pytest.param("import numpy", {}, "None", marks=pytest.mark.slow),
    ],
)
def test_products_take_one_thread_unless_told_otherwise(first: str, given: dict[str, str], threads: str) -> None:
    code = f"import os\n{first}\nfrom floquetrod.cli import main\nmain(['lock-up', '--rod', 'nitinol', '--mu', '0.3'])"
    code += "\nprint(os.environ.get('OPENBLAS_NUM_THREADS'))"
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")} | given
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert told.stdout.split()[-1] == threads


@pytest.mark.parametrize("arguments", [["--version"], ["--help"], ["chek"]])
def test_what_is_about_no_command_imports_none(arguments: list[str]) -> None:
    loaded = loaded_after(*arguments)
    assert _own(loaded) == {"_util", "cli", "units", "parameter", "rod", "results"}
    assert {each for each in loaded if each.startswith("floquetrod.rod.")} <= PARAMETERS
    assert "numpy" not in loaded


@pytest.mark.parametrize(
    ("line", "absent"),
    [
        (CHECK, {"simulation", "ensembles", "explorer"}),
        pytest.param(
            "compare --alpha 0.5 --beta -0.25",
            {"rod", "simulation", "ensembles", "explorer", "friction"},
            marks=pytest.mark.slow,
        ),
        pytest.param("simulate --help", {"ensembles", "explorer"}, marks=pytest.mark.slow),
    ],
)
def test_a_command_imports_no_other(line: str, absent: set[str]) -> None:
    loaded = loaded_after(*line.split())
    assert not _own(loaded - PARAMETERS) & absent
    others = {"check", "certify", "ranges", "map", "explore", "compare", "simulate", "ensemble"}
    assert {each for each in others if f"floquetrod.cli.{each}" in loaded} == {line.split()[0]}


@pytest.mark.slow
def test_one_equation_by_every_method_compiles_nothing() -> None:
    """Loading numba takes seconds on a busy machine, longer than all methods together."""
    assert "numba" not in loaded_after("compare", "--a", "1.2", "--q", "0.9", "--damping", "0.1")


@pytest.mark.slow
def test_a_check_of_a_rod_imports_what_it_uses() -> None:
    """Neither drawing nor records, systems or maps of many equations, nor numpy's masked arrays, which cost time."""
    loaded = loaded_after(*CHECK.removesuffix(" --no-margins").split())
    unused = {
        "plotting",
        "rod.record",
        "cli.system",
        "cli.kick",
        "kernels.system_maps",
        "floquet.multipliers.stabilising_damping",
    }
    assert not {f"floquetrod.{each}" for each in unused} & loaded
    # Before 2.0, numpy itself loads them.
    assert "numpy.ma" not in loaded or np.lib.NumpyVersion(np.__version__) < "2.0.0"


def run(line: str) -> tuple[int, str, str]:
    """Return exit status, output and errors of a line of the shell that begins with a command."""
    done = subprocess.run(["sh", "-c", f"{_COMMAND} {line}"], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.slow
def test_a_closed_stderr_costs_nothing() -> None:
    status, out, err = run(f"{CHECK} 2>&-")
    assert (status, err) == (0, "")
    assert out.startswith("UNSTABLE: mode 7 grows")
    assert run("check --rod x 2>&-") == (2, "", "")


@pytest.mark.parametrize("line", [f"{CHECK} >&-", "--version >&-", "ranges --help >&- <&-"])
def test_an_answer_that_is_lost_is_an_error(line: str) -> None:
    status, out, err = run(line)
    assert (status, out) == (2, "")
    assert err.startswith("floquetrod: error: standard output is closed")
    assert err.count("\n") == 1


def test_all_streams_closed() -> None:
    assert run(f"{CHECK} <&- >&- 2>&-") == (2, "", "")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
def test_a_full_disk_is_an_error_on_one_line() -> None:
    message = "floquetrod: error: the answer could not be written: No space left on device\n"
    assert run(f"{CHECK} >/dev/full") == (2, "", message)
    status, out, err = run("--help >/dev/full")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert run("check --rod x 2>/dev/full") == (2, "", "")
    assert run(f"{CHECK} --json 2>/dev/full")[0] == 0


@pytest.mark.slow
def test_a_reader_of_errors_who_has_gone_costs_no_answer() -> None:
    """A warning that nobody reads must not be taken for an answer that nobody reads."""
    line = "check --rod nitinol --length 3100 --modes 1-3 --mean 0 --amplitude 0 --frequency 1 --json"
    code = (
        "import os, subprocess, sys\nreader, writer = os.pipe()\nos.close(reader)\n"
        f"done = subprocess.run([sys.executable, '-m', 'floquetrod', *{line.split()!r}], stderr=writer)\n"
        "sys.exit(done.returncode)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout[:1]) == (0, "{")


@pytest.mark.slow
def test_a_file_does_not_take_the_place_of_a_closed_stream(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("closed")
    line = "ensemble study.toml --store runs.npz >/dev/null 2>&- <&-"
    study = (
        'rod = "nitinol"\n[load]\nmean = 0.3\namplitude = 0.3\nfrequency = "24Hz"\n'
        '[run]\nduration = "2ms"\nsegments = 40\nframes = 3\n[over]\nkick = ["20mm/s"]\n'
    )
    (folder / "study.toml").write_text(study, encoding="utf-8")
    done = subprocess.run(
        ["sh", "-c", f"cd {folder} && {_COMMAND} {line}"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (folder / "runs.npz").exists()
