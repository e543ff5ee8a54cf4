"""The terminal: progress, pictures beside answers, and no half file after Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from drawn import note
from floquetrod import cli
from floquetrod.plane import Axis
from floquetrod.plane.bands import Band, Bands
from floquetrod.plotting import charts

LOAD = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]


@pytest.mark.slow
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


@dataclass(frozen=True)
class OneBand:
    """A source that finds one band, and reports how far it is."""

    x: Axis
    y: Axis
    prompt: bool = True

    def __call__(self, accuracy: float, progress: Any) -> Bands:
        """Return it."""
        progress(1, 2)
        progress(2, 2)
        band = Band(np.array([100.0, 150.0, 120.0]), np.array([0.2, 0.4, 0.8]), 7, 1, 2.5, (120.0, 0.5))
        return Bands(self.x, self.y, (band,), "1/s", 0.0, 12, accuracy, (0.0, 0.0))


def test_a_map_is_drawn_as_bands_or_as_pixels(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = []
    stability_map = fr.stability_map

    def map_with_a_band(*args: Any, **load: Any) -> fr.Chart:
        chart = stability_map(*args, **load)
        return replace(chart, source=OneBand(chart.x.ends, chart.y.ends))

    monkeypatch.setattr(fr, "stability_map", map_with_a_band)
    monkeypatch.setattr(charts, "save_figure", lambda axes, path: drawn.append(axes))
    over = ["--mean", "0:1.1Fcr", "--amplitude", "0.2Fcr", "--frequency", "5:30Hz", "--points", "8x6"]
    names = {kind: str(tmp_path / f"map.{kind}") for kind in ("png", "csv", "npz")}
    out = [part for name in names.values() for part in ("--out", name)]
    for asked in ([], ["--bands"]):
        assert cli.main(["map", "--rod", "nitinol", *over, *out, *asked]) == 0
        said = capsys.readouterr().out
        assert "1 unstable band; 12 negligible tongues left out\n" in said
        assert "1 unstable band; 12 negligible tongues left out" in note(drawn.pop())
    head, first, *_ = Path(names["csv"]).read_text(encoding="utf-8").splitlines()  # in the units of the question
    assert head == "band,mode,partner,tongue,largest growth [1/s],frequency [Hz],mean force [Fcr]"
    assert first.startswith("1,7,,1,2.5,15.9154")
    loaded = fr.Chart.load(names["npz"])
    assert loaded.bands.bands[0].x.tolist() == [100.0, 150.0, 120.0]
    assert cli.main(["map", "--rod", "nitinol", *over, "--json", "--out", names["npz"]]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["bands"], record["tongues_left_out"]) == (1, 12)

    assert cli.main(["map", "--rod", "nitinol", *over, "--pixels", "--out", names["png"], "--out", names["npz"]]) == 0
    assert "unstable band" not in capsys.readouterr().out
    assert "points stable" in note(drawn.pop())
    with pytest.raises(ValueError, match="bands must be computed before"):
        fr.Chart.load(names["npz"]).find_bands()
    for wrong, message in (
        (["--pixels", "--out", names["csv"]], "a .csv file holds the vertices of bands; leave out --pixels"),
        (["--pixels", "--bands"], "not allowed with argument"),
        (["--out", str(tmp_path / "map.txt")], "--out must end in .png, .pdf, .svg, .csv or .npz"),
    ):
        assert cli.main(["map", "--rod", "nitinol", *over, *wrong]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.parametrize("command", ["map", pytest.param("studies", marks=pytest.mark.slow)])
def test_ctrl_c_ends_a_long_command_and_leaves_no_half_file(command: str, tmp_path: Path) -> None:
    big = ["--mean", "0:1.1Fcr", "--amplitude", "0.2Fcr", "--frequency", "20:200", "--points", "4900x4900"]
    arguments = {
        "map": ["map", "--rod", "nitinol", *big, "--growth", "--out", "m.npz"],
        "studies": ["--out", "r"],
    }
    modules = {"map": "floquetrod.cli", "studies": "studies.__main__"}
    # A shell's job is told; a process in the background would inherit "ignore".
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); " + (
        f"from {modules[command]} import main; print('ready', flush=True); sys.exit(main())"
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
        _, said = run.communicate(timeout=600)
    assert run.returncode == 130, said
    assert said.endswith(f"{'floquetrod' if command == 'map' else command}: interrupted\n")
    assert not list(tmp_path.rglob("*.npz"))
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and path.suffix != ".png"]
