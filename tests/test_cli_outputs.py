"""The terminal: progress, pictures beside answers, and no half file after Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from floquetrod import cli
from floquetrod.cli import common

LOAD = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]


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


def test_answers_beside_pictures_and_along_other_quantities(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


@pytest.mark.parametrize("command", ["map", "reproduce"])
def test_ctrl_c_ends_a_long_command_and_leaves_no_half_file(command: str, tmp_path: Path) -> None:
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
