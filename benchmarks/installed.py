"""What an installation costs beside SciPy's: megabytes, seconds to install, to import and to a first answer.

Needs a network, or a cache of pip that holds the wheels; without them it says so and has no rows.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.measure import Row

ROOT = Path(__file__).parents[1]
VERDICT = "import floquetrod as fr; fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25))"
SCIPY = "from scipy.special import mathieu_a; mathieu_a(1, 0.25)"
MAP = (
    "import numpy as np, floquetrod as fr; rod = fr.Rod.nitinol(); force = rod.critical_force * np.linspace(0, 1, 50);"
    "fr.stability_map(rod, mean=force, amplitude=0.3, frequency=np.linspace(20.0, 200.0, 50))"
)


def run() -> list[Row]:
    """Return sizes and times of two fresh environments, one with this package and one with SciPy alone."""
    with tempfile.TemporaryDirectory() as folder:
        ours, peer = Path(folder) / "ours", Path(folder) / "peer"
        try:
            built = Path(folder) / "wheel"
            _pip(sys.executable, "wheel", "--no-deps", "--wheel-dir", str(built), str(ROOT))
            (wheel,) = built.glob("*.whl")
            _fresh(ours), _fresh(peer)
            empty = _megabytes(ours)
            for _ in range(2):  # the second time from pip's cache
                seconds = _install(ours, str(wheel)), _install(peer, "scipy")
        except subprocess.CalledProcessError as error:
            print(f"pip cannot install here: {error.stderr.decode().strip().splitlines()[-1:]}", file=sys.stderr)
            return []
        whole, scipy = _megabytes(ours) - empty, _megabytes(peer) - empty
        alone = _size(next(ours.rglob("site-packages")) / "floquetrod") / 1e6
        rows = [
            Row("floquetrod alone on disk", alone, "MB", "SciPy and NumPy", scipy),
            Row("with all it needs", whole, "MB", "SciPy and NumPy", scipy),
            Row("installation, wheels in the cache", seconds[0], "s", "SciPy", seconds[1]),
            Row("import", _least(ours, "import floquetrod"), "s", "import scipy", _least(peer, "import scipy")),
        ]
        cold, warm = _seconds(ours, VERDICT, ours / "1"), _least(ours, VERDICT)
        rows += [
            Row("process with a first verdict", cold, "s", "scipy.special.mathieu_a", _least(peer, SCIPY)),
            Row("the same again", warm, "s", "scipy.special.mathieu_a", _least(peer, SCIPY)),
            Row("process with a first compiled map", _seconds(ours, MAP, ours / "2"), "s"),
            Row("the same again", _seconds(ours, MAP, ours / "2"), "s"),
        ]
        return rows


def _fresh(folder: Path) -> None:
    subprocess.run([sys.executable, "-m", "venv", "--clear", str(folder)], check=True, capture_output=True)


def _pip(python: str, *arguments: str) -> None:
    command = [python, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    subprocess.run(command, check=True, capture_output=True)


def _install(folder: Path, what: str) -> float:
    """Return the seconds that an installation into a cleared environment takes."""
    _fresh(folder)
    start = time.perf_counter()
    _pip(str(_python(folder)), "install", what)
    return time.perf_counter() - start


def _python(folder: Path) -> Path:
    return folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink())


def _megabytes(folder: Path) -> float:
    return _size(folder) / 1e6


def _seconds(folder: Path, program: str, cache: Path) -> float:
    """Return the seconds of a process of its own, with a given cache of compiled code."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "MPLBACKEND": "Agg"}
    environment.pop("PYTHONPATH", None)
    start = time.perf_counter()
    subprocess.run([str(_python(folder)), "-P", "-c", program], check=True, env=environment, cwd=folder)
    return time.perf_counter() - start


def _least(folder: Path, program: str) -> float:
    return min(_seconds(folder, program, folder / "1") for _ in range(5))
