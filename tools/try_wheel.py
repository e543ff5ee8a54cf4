"""Install the wheel of dist/ in empty environments and try it there: `python -m tools.try_wheel --help`.

Each environment has a Python and the newest or the lowest dependencies that pyproject.toml allows.  First verdicts, the
terminal and what needs an extra are tried with the dependencies alone, warnings as errors; then a part of the suite
runs against the wheel, from the sdist without its package, or with --whole the quick suite, from the whole sdist.
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

ROOT = Path(__file__).parents[1]
SMOKE = ["tests/test_units.py", "tests/test_equations.py", "tests/test_methods.py", "tests/test_system_kernels.py"]
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

COMMANDS = ["--version", "--help", "check --rod nitinol --mean 0.2Fcr --amplitude 0.02Fcr --frequency 150"]


def main(arguments: list[str]) -> int:
    """Try every environment asked for; return 1 if one fails or no Python was found."""
    parser = argparse.ArgumentParser(prog="python -m tools.try_wheel", description="Try the wheel of dist/.")
    parser.add_argument("--pythons", nargs="+", default=[sys.executable], help="commands, such as python3.12")
    parser.add_argument("--dependencies", nargs="+", choices=["newest", "oldest"], default=["newest"])
    parser.add_argument("--whole", action="store_true", help="run the quick suite instead of a part of it")
    options = parser.parse_args(arguments)
    results = []
    for python in options.pythons:
        if not is_python(python):
            print(f"{python}: not found, left out")
            continue
        for which in options.dependencies:
            start = time.perf_counter()
            with tempfile.TemporaryDirectory() as folder:
                failed = attempt(python, which, Path(folder), options.whole)
            seconds = time.perf_counter() - start
            print(f"{python}, {which} dependencies: {failed or 'passed'} ({seconds:.0f} s)", flush=True)
            results.append(failed)
    return 0 if results and not any(results) else 1


def is_python(command: str) -> bool:
    """Return whether a command starts a Python: a launcher may be there without one."""
    try:
        return subprocess.run([command, "-c", ""], capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def attempt(python: str, which: str, folder: Path, whole: bool) -> str:
    """Try the wheel in an environment of its own; return the step that failed, or ""."""
    (wheel,) = (ROOT / "dist").glob("*.whl")
    (sdist,) = (ROOT / "dist").glob("*.tar.gz")
    limits = ["-c", str(ROOT / "constraints-oldest.txt")] if which == "oldest" else []
    own = {"MPLBACKEND": "Agg", "MPLCONFIGDIR": str(folder), "NUMBA_CACHE_DIR": str(folder / "cache")}
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
        ("tests", [*pytest, "--maxfail=20"] if whole else [*pytest, *SMOKE]),
    ]
    for name, command in steps:
        run = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=source, check=False)
        if run.returncode:
            print(f"{run.stdout}{run.stderr}", file=sys.stderr)
            return f"{name} failed"
        if name == "tests":
            print(run.stdout.splitlines()[-1])
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
