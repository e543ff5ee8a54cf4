"""The command that draws the stability lobes of a milling cutter."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod.milling import read_speed

TOOL = Path(__file__).parents[2] / "floquetrod/examples/tool.toml"


def test_it_says_the_critical_depth(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["lobes", str(TOOL), "--at", "15000rpm"]) == 0
    depth = fr.Milling.from_toml(TOOL).critical_depth("15000rpm")
    answer = capsys.readouterr().out
    assert f"at 15000 rpm it chatters from a depth of {1e3 * depth:.6g} mm on\nrelative error below 1e-08; " in answer
    assert cli.main(["lobes", str(TOOL), "--at", "15000rpm", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["critical_depth_m"] == depth
    assert cli.main(["lobes", str(TOOL), "--at", "5000rad/s"]) == 0
    assert capsys.readouterr().err == ""  # a unit was typed: nothing to warn of


@pytest.mark.slow
def test_it_writes_lobes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [tmp_path / name for name in ("lobes.png", "lobes.csv", "lobes.npz")]
    line = ["lobes", str(TOOL), "--speed", "14000:22000rpm", "--depth", "0:3.5mm", "--points", "12x8", "--json"]
    assert cli.main([*line, *(word for path in files for word in ("--out", str(path)))]) == 0
    record = json.loads(capsys.readouterr().out)
    assert {lobe["kind"] for lobe in record["lobes"]} == {"Hopf", "flip"}
    assert all(path.stat().st_size > 500 for path in files)
    chart = fr.Chart.load(files[2])
    assert (chart.x.unit, chart.y.unit) == ("rpm", "mm")
    assert chart.x.values[-1] == pytest.approx(22000.0)
    assert record["speeds_rad_per_s"][0] == pytest.approx(14000.0 * math.pi / 30.0)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["missing.toml"], "must be a TOML file of a milling cutter"),
        ([str(TOOL), "--speed", "5000rpm"], "--speed must be a range"),
        ([str(TOOL), "--speed", "9000rpm:5000rpm"], "--speed must be a range from less to more"),
        ([str(TOOL), "--depth", "0mm:4kg"], "--depth must be"),
        ([str(TOOL), "--points", "7"], "--points must be columns x rows"),
        ([str(TOOL), "--out", "lobes.doc"], "--out"),
    ],
)
def test_bad_options_are_refused(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["lobes", *words]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("teeth = 2", "", "key 'teeth' is missing"),
        ("teeth = 2", "tooth = 2", "unknown key 'tooth'"),
        ('mass = "39.93g"', "", "x[0]: mass or stiffness must be given"),
        ("[tool]", "[cutter]", "one table [tool]"),
        ("immersion = 1.0", "immersion = 2", "immersion must lie between"),
        ("teeth = 2", 'teeth = "two"', "teeth must"),
    ],
)
def test_bad_files_are_refused(
    old: str, new: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tool.toml"
    path.write_text(TOOL.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    assert cli.main(["lobes", str(path), "--at", "5000rpm"]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_uneven_teeth_are_read_from_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    search, answers = fr.Milling.critical_depth, {}

    def searched_once(mill: fr.Milling, speed: float | str) -> float:
        """Return the critical depth of one cutter at one speed, searched once, for the terminal and for Python."""
        question = mill, read_speed(speed)
        if question not in answers:
            answers[question] = search(mill, speed)
        return answers[question]

    monkeypatch.setattr(fr.Milling, "critical_depth", searched_once)
    path = tmp_path / "uneven.toml"
    uneven = 'teeth = 2\npitch = ["170deg", "190deg"]\nhelix = "30deg"\ndiameter = "12mm"\n'
    text = TOOL.read_text(encoding="utf-8").replace("teeth = 2\n", uneven)
    path.write_text(text, encoding="utf-8")
    mill = fr.Milling.from_toml(path)
    assert [math.degrees(angle) for angle in mill.pitch] == pytest.approx([170.0, 190.0])
    assert cli.main(["lobes", str(path), "--at", "15000rpm"]) == 0
    answer = capsys.readouterr().out
    assert "pitch 170, 190 deg; helix 30 deg on a diameter of 12 mm" in answer
    assert f"{1e3 * mill.critical_depth('15000rpm'):.6g} mm" in answer
    path.write_text(text.replace('"190deg"', "3.316"), encoding="utf-8")
    assert cli.main(["lobes", str(path), "--at", "15000rpm"]) == 2
    assert "pitch[1] must have a unit" in capsys.readouterr().err
