"""Install the wheel of dist/ in empty environments and try it there: `python -m tools.try_wheel --help`.

Each environment has a Python and the newest or the lowest dependencies that pyproject.toml allows.  First verdicts, the
terminal and what needs an extra are tried with the dependencies alone, warnings as errors; then a part of the suite
runs against the wheel, from the sdist without its package, or with --whole the quick suite, from the whole sdist, on
two workers.  What every step says is kept in .cache/try_wheel, and printed if one fails.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path
from typing import TextIO

ROOT = Path(__file__).parents[1]
SMOKE = [
    "tests/units/test_units.py",
    "tests/equations/test_equations.py",
    "tests/floquet/test_methods.py",
    "tests/floquet/test_system_kernels.py",
]
"""Tests that reach values, methods and compiled kernels, and need no extra."""

FIRST = """
import floquetrod as fr
assert fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25)).status == "unstable"
assert fr.certify(fr.Mathieu(alpha=1e-8, beta=-0.25)).status == "unstable"
rod = fr.Rod.nitinol()
critical = rod.critical_force
assert rod.stability(fr.AxialLoad(0.2 * critical, 0.2 * critical, 150.0)).status == "unstable"
"""

WITHOUT_EXTRAS = """
import importlib.util
import floquetrod as fr
present = [name for name in ("xarray", "zarr", "dask", "tornado", "ipympl", "shtab") if importlib.util.find_spec(name)]
assert not present, f"the environment is not empty: {present}"
def told(action, extra):
    try:
        action()
    except ImportError as error:
        assert f"pip install floquetrod[{extra}]" in str(error), error
    else:
        raise AssertionError(f"needs no {extra}")
chart = fr.chart(lambda alpha, beta: fr.Mathieu(alpha, beta), over={"alpha": [0.1, 0.2], "beta": [-0.3, -0.2]})
told(chart.to_xarray, "xarray")
told(chart.bands.to_xarray, "xarray")
"""

COMMANDS = [
    "--version",
    "--help",
    "check --rod nitinol --mean 0.2Fcr --amplitude 0.02Fcr --frequency 150",
    "example --all --out tried",
    "check --rod tried/my_rod.toml --mean 4N --amplitude 2N --frequency 16Hz",
]


def main(arguments: list[str]) -> int:
    """Try every environment asked for; return 1 if one fails or no Python was found."""
    parser = argparse.ArgumentParser(prog="python -m tools.try_wheel", description="Try the wheel of dist/.")
    parser.add_argument("--pythons", nargs="+", default=[sys.executable], help="commands, such as python3.12")
    parser.add_argument("--dependencies", nargs="+", choices=["newest", "oldest"], default=["newest"])
    parser.add_argument("--whole", action="store_true", help="run the quick suite instead of a part of it")
    options = parser.parse_args(arguments)
    results = []
    for python in options.pythons:
        version = version_of(python)
        if not version:
            print(f"{python}: not found, left out")
            continue
        for which in options.dependencies:
            start = time.perf_counter()
            with tempfile.TemporaryDirectory() as folder, log_of(version, which) as log:
                failed = attempt(python, which, Path(folder), options.whole, log)
            seconds = time.perf_counter() - start
            print(f"Python {version}, {which} dependencies: {failed or 'passed'} ({seconds:.0f} s)", flush=True)
            results.append(failed)
    return 0 if results and not any(results) else 1


def version_of(command: str) -> str:
    """Return the version of the Python a command starts, or "": a launcher may be there without one."""
    question = "import platform; print(platform.python_version())"
    try:
        return subprocess.run([command, "-c", question], capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        return ""


def log_of(version: str, which: str) -> TextIO:
    """Open the file that keeps what the steps of an attempt say."""
    folder = ROOT / ".cache" / "try_wheel"
    folder.mkdir(parents=True, exist_ok=True)
    return (folder / f"{version}-{which}.log").open("w+", encoding="utf-8", errors="replace")


def attempt(python: str, which: str, folder: Path, whole: bool, log: TextIO) -> str:
    """Try the wheel in an environment of its own; return the step that failed, or ""."""
    (wheel,) = (ROOT / "dist").glob("*.whl")
    (sdist,) = (ROOT / "dist").glob("*.tar.gz")
    limits = ["-c", str(ROOT / "constraints-oldest.txt")] if which == "oldest" else []
    caches = {"MPLCONFIGDIR": str(folder), "NUMBA_CACHE_DIR": str(folder / "cache")}
    own = {"MPLBACKEND": "Agg", "OPENBLAS_NUM_THREADS": "1", **caches}
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")} | own
    scripts = folder / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
    inside = str(scripts / "python")
    pip = [inside, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    strict = [inside, "-W", "error", "-P", "-c"]
    source = unpacked(sdist, folder, whole)
    pytest = [inside, "-m", "pytest", "-q", "-m", "not slow", "-p", "no:cacheprovider"]
    steps = [
        ("environment", [python, "-m", "venv", str(folder / "venv")]),
        ("installation", [*pip, "install", *limits, str(wheel)]),
        ("requirements", [inside, "-m", "pip", "check"]),
        ("import", [*strict, "import floquetrod"]),
        ("first verdicts", [*strict, FIRST]),
        ("without extras", [*strict, WITHOUT_EXTRAS]),
        *[("terminal", [str(scripts / "floquetrod"), *command.split()]) for command in COMMANDS],
        ("test tools", [*pip, "install", *limits, f"{wheel}[test]" if whole else "hypothesis", "pytest"]),
        ("versions", [inside, "-m", "pip", "freeze"]),
        ("tests", [*pytest, "-n", "2", "--dist", "worksteal"] if whole else [*pytest, *SMOKE]),
    ]
    for name, command in steps:
        run = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, env=environment, cwd=source, check=False)
        if run.returncode:
            log.seek(0)
            print(log.read(), file=sys.stderr)
            return f"{name} failed, see {log.name}"
    log.seek(0)
    print(log.read().splitlines()[-1])
    return ""


def unpacked(sdist: Path, folder: Path, whole: bool) -> Path:
    """Unpack the sdist; without its package, so that tests import the wheel, unless all of it is asked for."""
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    source = folder / sdist.name.removesuffix(".tar.gz")
    if not whole:
        shutil.rmtree(source / "floquetrod")
    return source


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
