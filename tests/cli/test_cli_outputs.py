"""The terminal: progress, pictures beside answers, and no half file after Ctrl-C."""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod import cli
from floquetrod.cli.parser import Parser
from floquetrod.plane import Axis
from floquetrod.plane.bands import Band, Bands
from floquetrod.plotting import chart_plot
from tests.conftest import DEEP
from tests.drawn import note

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
    assert windows.startswith("safe: nowhere from 100 to 120 rad/s")


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
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, saved: list[Any]
) -> None:
    stability_map = fr.stability_map

    def map_with_a_band(*args: Any, **load: Any) -> fr.Chart:
        chart = stability_map(*args, **load)
        return replace(chart, source=OneBand(chart.x.ends, chart.y.ends))

    monkeypatch.setattr(fr, "stability_map", map_with_a_band)
    over = ["--mean", "0:1.1Fcr", "--amplitude", "0.2Fcr", "--frequency", "5:30Hz", "--points", "8x6"]
    names = {kind: str(tmp_path / f"map.{kind}") for kind in ("png", "csv", "npz")}
    out = [part for name in names.values() for part in ("--out", name)]
    for asked in ([], ["--bands"]):
        assert cli.main(["map", "--rod", "nitinol", *over, *out, *asked]) == 0
        said = capsys.readouterr().out
        assert "1 unstable band; 12 negligible tongues left out\n" in said
        assert "1 unstable band; 12 negligible tongues left out" in note(saved.pop())
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
    assert "points stable" in note(saved.pop())
    with pytest.raises(ValueError, match="bands must be computed before"):
        fr.Chart.load(names["npz"]).find_bands()
    for wrong, message in (
        (["--pixels", "--out", names["csv"]], "a .csv file holds the vertices of bands; leave out --pixels"),
        (["--pixels", "--bands"], "not allowed with argument"),
        (["--out", str(tmp_path / "map.txt")], "--out must end in .png, .pdf, .svg, .csv or .npz"),
    ):
        assert cli.main(["map", "--rod", "nitinol", *over, *wrong]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.slow
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
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), "MPLBACKEND": "Agg"},
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == "ready\n"
        time.sleep(0.7)
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=600)
    assert run.returncode == 130, said
    assert said.endswith(f"{'floquetrod' if command == 'map' else command}: interrupted\n")
    assert not list(tmp_path.rglob("*.npz"))
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and path.suffix != ".png"]


EXAMPLES = Path(__file__).parents[2] / "floquetrod/examples"
READ = {"path", "well", "study", "store", "checkpoint", "tool", "earlier", "start", "folder"}
"""Options and arguments of which each names one file that is read, or is kept up to date, or a folder."""

WRITING = ["check", "map", "chart", "explore", "ranges", "simulate", "ensemble", "report", "reach", "weights", "lobes"]
"""Commands that write files."""

LONG = {"chart", "explore", "ensemble", "reach", "weights", "lobes", "simulate", "map"}
"""Commands whose questions take longest: all write by one rule."""


def asked(folder: Path) -> dict[str, list[str]]:
    """Return a small question for every command that writes files, with a measured force for the fit of one."""
    time = np.arange(0.0, 2.0, 0.002)
    record = folder / "record.csv"
    np.savetxt(
        record, np.c_[time, 0.5 + 0.3 * np.sin(150.0 * time)], delimiter=",", header="time s,force N", comments=""
    )
    study = folder / "study.toml"
    study.write_text(
        'rod = "nitinol"\n[load]\nmean = "0.3Fcr"\namplitude = "0.3Fcr"\nfrequency = "24Hz"\n'
        '[run]\nduration = "10ms"\nsegments = 60\n[start]\nrandom = "1mm/s"\n'
        '[over]\nkick = ["10mm/s", "20mm/s"]\nseed = {from = 1, to = 3}\n',
        encoding="utf-8",
    )
    rod, ranged = ["--rod", "nitinol"], ["--mean", "0:1.1Fcr", "--frequency", "20:200rad/s", "--points", "6x5"]
    return {
        "check": [*rod, "--force", str(record), "--no-margins"],
        "map": [*rod, "--amplitude", "0.2Fcr", *ranged],
        "chart": ["--system", str(EXAMPLES / "family.toml"), "--points", "5x4"],
        "explore": [*rod, *LOAD],
        "ranges": [*rod, "--mean", "0.3Fcr", "--amplitude", "0.2Fcr", "--frequency", "100:120"],
        "simulate": [*rod, *LOAD, "--duration", "10ms", "--segments", "60", "--no-theory"],
        "ensemble": [str(study)],
        "report": [*rod, *LOAD],
        "reach": [
            *("--well", str(EXAMPLES / "survey.csv"), "--rod", str(EXAMPLES / "tubing.toml")),
            *("--friction", "0.3", "--depths", "2000m,3000m"),
        ],
        "weights": [
            *("--well", str(EXAMPLES / "survey.csv"), "--rod", str(EXAMPLES / "tubing.toml")),
            *("--friction", "0.2,0.3", "--depths", "1000m"),
        ],
        "lobes": [str(EXAMPLES / "tool.toml"), "--speed", "9000rpm:11000rpm", "--points", "5x4"],
    }


def commands() -> dict[str, Parser]:
    """Return the parser of every command."""
    parser = import_module("floquetrod.cli.main")._parser()
    return next(dict(action.choices) for action in parser._actions if isinstance(action, argparse._SubParsersAction))


def test_every_option_that_names_a_file_writes_each_it_is_given_or_takes_one(tmp_path: Path) -> None:
    for name, command in commands().items():
        files = {action.dest for action in command._actions if action.type is Path} - READ
        assert files == {action.dest for action in command.outputs}, name
        assert bool(files) is (name in asked(tmp_path)) is (name in WRITING), name


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in WRITING])
def test_files_named_twice_are_all_written_and_told(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stub(_: Any, path: Path, **__: Any) -> Path:
        path.write_bytes(bytes(200))
        pyplot.close("all")
        return path

    monkeypatch.chdir(tmp_path)
    if not DEEP:  # pictures take seconds
        monkeypatch.setattr(chart_plot, "save_figure", stub)
        monkeypatch.setattr(fr, "save_report", stub)
    question, command = asked(tmp_path)[name], commands()[name]
    for json_too in (False, True) if DEEP else (name in ("map", "simulate"),):
        files, words = [], [name, *question, *(["--json"] if json_too else [])]
        for action in command.outputs:
            kinds = [kind for kind in action.kinds() if kind not in (".mp4", ".gif")]  # which take a program
            for number, kind in enumerate([*kinds, kinds[0]]):
                files.append(f"{json_too}-{action.dest}-{number}{kind}")
                words += [action.option_strings[0], files[-1]]
        assert cli.main(words) == 0
        text = capsys.readouterr().out
        written = json.loads(text)["written"] if json_too else text.splitlines()[-1].partition(": ")[2].split(", ")
        assert sorted(written) == sorted(files)
        assert json_too or text.splitlines()[-1].startswith("written: ")
        assert all(Path(file).stat().st_size >= 200 for file in files)


@pytest.mark.parametrize("name", WRITING)
def test_a_file_named_twice_is_refused_before_anything_is_computed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    question, option = asked(tmp_path)[name], commands()[name].outputs[0]
    kind = option.kinds()[0]
    (tmp_path / f"link{kind}").symlink_to(tmp_path / f"one{kind}")
    for other in (f"one{kind}", f"./one{kind}", f"link{kind}"):
        words = [option.option_strings[0], f"one{kind}", option.option_strings[0], other]
        assert cli.main([name, *question, *words]) == 2
        assert "is named twice; give every file its own name" in capsys.readouterr().err
        assert not (tmp_path / f"one{kind}").exists()


def test_a_file_that_is_read_is_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked(tmp_path)
    record = tmp_path / "record.csv"
    before = record.read_bytes()
    ranged = ["--mean", "0:1Fcr", "--frequency", "20:200rad/s"]
    assert cli.main(["map", "--rod", "nitinol", "--force", str(record), *ranged, "--out", str(record)]) == 2
    assert "is named twice" in capsys.readouterr().err
    assert record.read_bytes() == before


def test_a_file_that_is_read_is_named_once() -> None:
    tried = set()
    for command in commands().values():
        read = [action for action in command._actions if action.type is Path and action not in command.outputs]
        for action in filter(lambda each: each.option_strings, read):
            name = action.option_strings[0]
            with pytest.raises(ValueError, match=rf"{name} must be given once, got 'a' and 'b'"):
                command.parse_args([name, "a", name, "b"])
            tried.add(action.dest)
    assert tried == READ - {"tool", "study"}
    parser = Parser()
    parser.add_argument("--well", type=Path)
    parser.add_argument("--speed", default="3")
    found = parser.parse_args(["--well", "a", "--speed", "3", "--well", "a", "--speed", "4"])
    assert (found.well, found.speed) == (Path("a"), "4")
