"""What is said, and done, in cases that are rare."""

from __future__ import annotations

import functools
import math
import os
import runpy
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod._util import compilation
from floquetrod.cli import common
from floquetrod.floquet.methods.leapfrog import leapfrog
from floquetrod.kernels import mathieu as kernels

ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force
LOAD = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]


def test_python_m_floquetrod(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["floquetrod", "check", "--rod", "nitinol", *LOAD])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("floquetrod", run_name="__main__")
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("UNSTABLE: mode 7 grows")


def test_systems_without_affinities_count_all_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert compilation.cores() == (os.cpu_count() or 1)


def test_a_failing_thread_ends_the_work() -> None:
    out = np.empty(40_000)
    with pytest.raises(RuntimeError, match="broken"):
        compilation.over_chunks(_Broken(), [out], out, workers=2, chunk=100, interpret_up_to=0)


class _Broken:
    """What `compiled` returns of itself: machine code that fails."""

    py_func = "of a kernel"

    def __call__(self, values: np.ndarray, out: np.ndarray) -> None:
        raise RuntimeError("broken")


@pytest.fixture(autouse=True)
def _stands_for_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("compiled", "compiled_for"):
        real = getattr(compilation, name)
        monkeypatch.setattr(compilation, name, functools.partial(_unless_broken, real))


def _unless_broken(real: Callable[..., object], function: object, *arguments: object) -> object:
    return function if isinstance(function, _Broken) else real(function, *arguments)


def test_progress_is_shown_to_a_terminal_after_a_second(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    progress = common.Progress("points")
    progress(1000, 4000)
    assert capsys.readouterr().err == ""
    assert progress.first is not None
    progress.first = (progress.first[0] - 4.0, 1000)
    progress(3000, 4000)
    assert capsys.readouterr().err.rstrip() == "\r3,000 of 4,000 points, 500 a second, 2 s left"
    progress(4000, 4000)
    assert capsys.readouterr().err.startswith("\r4,000 of 4,000 points, 750 a second, 0 s left")


def test_answers_in_other_forms(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def said(*arguments: str) -> str:
        assert cli.main(list(arguments)) == 0
        return capsys.readouterr().out

    far = said("check", "--rod", "nitinol", "--mean", "30Fcr", "--amplitude", "0", "--frequency", "150")
    assert "no change within 8 Fcr either way" in far
    picture = str(tmp_path / "x.png")
    assert '"amplitude_N"' in said("explore", "--rod", "nitinol", *LOAD, "--json", "--out", picture)
    over = ["--mean", "0:0.5Fcr", "--amplitude", "0.2Fcr", "--frequency", "100:150"]
    chart = said("map", "--rod", "nitinol", *over, "--points", "8x6", "--json", "--out", picture)
    assert '"points": 48' in chart
    windows = said("ranges", "--rod", "nitinol", "--mean", "0.3Fcr", "--amplitude", "0.2Fcr", "--frequency", "100:120")
    assert windows.startswith("stable frequency")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (ROD.stability(fr.AxialLoad(0.34 * UNIT, 0.2 * UNIT, 150.0)), "<stable; "),
        (ROD.stability(fr.AxialLoad(0.2 * UNIT, 0.2 * UNIT, 150.0), growth_tolerance=4.3), "within the tolerance"),
        (
            ROD.stability(fr.AxialLoad(0.825 * UNIT, 0.7 * UNIT, 150.0), friction=fr.Coulomb(0.1, 0.05)),
            "sets off modes 9, 10",
        ),
        (fr.mathieu.transition_curves([0.0, 1.0], [1, 2]), "orders 1, 2 at 2 values"),
        (fr.friction.trajectory(fr.FrictionalMathieu(0.0, 0.25, 1.0), 1.9, periods=1), "motion from A' = 1.9 over 1 "),
        (ROD.stable_frequencies(0.9 * UNIT, 0.7 * UNIT, (100.0, 101.0)), "  none\n"),
    ],
)
def test_values_introduce_themselves(value: object, words: str) -> None:
    assert words in repr(value)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: fr.Mathieu(1.0, 1.0, 1e200), ValueError, "damping must be at most"),
        (lambda: fr.friction.fates([1.0, 2.0], [0.1, 0.2, 0.3], 1.0, 1.0), ValueError, "must broadcast to one shape"),
        (lambda: ROD.is_stable([1.0, 2.0], [0.1, 0.2, 0.3], 150.0), ValueError, "must broadcast to one shape"),
        (lambda: fr.friction.leapfrog_escapes(1.0, 0.3, 0.0, 1.0), ValueError, "gamma must be greater than zero"),
        (lambda: fr.stability_map("rod", mean=1.0, amplitude=1.0, frequency=1.0), TypeError, "rod must be a Rod"),
        (
            lambda: fr.stability_map(
                ROD,
                mean=(0.0, 1.0, 4),
                amplitude=0.3,
                frequency=(100.0, 150.0, 4),
                growth=True,
                friction=fr.Coulomb(0.1, 0.05),
            ),
            ValueError,
            "leave out either growth or friction",
        ),
    ],
)
def test_bad_input_is_named(call: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()  # type: ignore[operator]


def test_numbers_beyond_a_double() -> None:
    # A growth of 800 per unit tau: the discriminant is beyond the range of a double, its logarithm is not.
    for method, error in (("spectral", 1e-6), ("leapfrog", 1e-2)):  # leapfrog's steps are short against tau, not 1/800
        verdict = fr.stability(fr.Mathieu(1.0, 6.4e5), method=method)
        assert verdict.discriminant == math.inf
        assert verdict.growth_rate == pytest.approx(800.0, rel=error)
        assert math.isinf(abs(verdict.multipliers[0]))
    out = np.empty(2)
    kernels.discriminant_fill(np.zeros(2), np.array([6.4e5, 0.25]), np.array([0.0, 0.1]), out)
    assert out[0] == math.inf
    assert out[1] == pytest.approx(2.0 * math.cosh(2.0 * math.pi * math.sqrt(0.26)) * math.exp(-0.2 * math.pi))
    assert leapfrog(fr.Mathieu(1.0, 2.5e3)).growth_rate == pytest.approx(50.0, rel=1e-3)


def test_without_vibration_only_buckling_is_left_along_the_frequency() -> None:
    safe = ROD.stable_frequencies(0.9 * UNIT, 0.0, (50.0, 150.0))
    assert [(part.low, part.high) for part in safe] == [(50.0, 150.0)]
    assert len(ROD.stable_frequencies(1.1 * UNIT, 0.0, (50.0, 150.0))) == 0


@pytest.mark.parametrize("command", ["map", "reproduce"])
def test_ctrl_c_ends_it_at_once_and_leaves_no_half_file(command: str, tmp_path: Path) -> None:
    big = ["--mean", "0:1.1Fcr", "--amplitude", "0.2Fcr", "--frequency", "20:200", "--points", "4900x4900"]
    arguments = {
        "map": ["map", "--rod", "nitinol", *big, "--growth", "--out", "m.npz"],
        "reproduce": ["reproduce", "--out", "r"],
    }
    # A shell's job is told; a process in the background would inherit "ignore".
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); " + (
        "from floquetrod.cli import main; print('ready', flush=True); sys.exit(main())"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, *arguments[command]],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1]), "MPLBACKEND": "Agg"},
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == "ready\n"
        time.sleep(1.5)
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=60)
    assert run.returncode == 130, said
    assert said.endswith("floquetrod: interrupted\n")
    assert not list(tmp_path.rglob("*.npz"))
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and path.suffix != ".png"]
