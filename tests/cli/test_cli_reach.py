"""The command that says how far a string can be pushed into a well."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from tests.conftest import depth, some

EXAMPLES = Path(__file__).parents[2] / "floquetrod/examples"
SURVEY = "MD (m),Inc (deg),Azi (deg)\n0,0,0\n1000,0,0\n1450,90,0\n2000,90,0\n"


@pytest.fixture
def line(tmp_path: Path) -> list[str]:
    """Return a command about a short well."""
    (tmp_path / "survey.csv").write_text(SURVEY, encoding="utf-8")
    return ["reach", "--well", str(tmp_path / "survey.csv"), "--rod", str(EXAMPLES / "tubing.toml")]


def test_it_says_what_the_library_finds(line: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*line, "--friction", "0.2,0.3@1450m", "--push", "1kN", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    rod, path = fr.Rod.from_toml(EXAMPLES / "tubing.toml"), fr.WellPath.from_csv(tmp_path / "survey.csv")
    found = rod.reach(path, [(0.0, 0.2), (1450.0, 0.3)], push=1000.0)
    assert record["reach_m"] == found.reach
    assert record["injector_N"] == found.injector.tolist()


@pytest.mark.slow
def test_it_draws(line: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*line, "--friction", "0.2"]) == 0
    assert capsys.readouterr().out.startswith("How far does the string go? To 2,000 m, the end of the well.")
    picture = tmp_path / "reach.png"
    page = tmp_path / "reach.html"
    files = ["--out", str(picture), "--report", str(page), "--unit", "ft,lbf"]
    assert cli.main([*line, "--friction", "0.3", "--tool", "5kN@18Hz@30m", *files]) == 0
    text = capsys.readouterr().out
    assert text.startswith("Does the tool help? It is not needed: without it the string goes to 6,562 ft")
    assert "lower end lbf" in text
    assert "lower end lbf" in page.read_text(encoding="utf-8")
    assert picture.stat().st_size > 10_000


@pytest.mark.slow
def test_what_limits_it_and_its_speed_are_options_and_said(line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    path = fr.WellPath.from_csv(line[2])
    string = [*line[:4], "2.00x0.156 CT90", "--bore", "4.778in", "--friction", "0.9"]
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1000.0)
    for share, given in (("30%", 0.3), ("none", None), ("0.05", 0.05))[depth(0, 2) :]:
        assert cli.main([*string, "--yield-share", share, "--json"]) == 0
        record, found = json.loads(capsys.readouterr().out), rod.reach(path, 0.9, yield_share=given)
        assert (record["reach_m"], record["limit"], record["yield_share"]) == (found.reach, found.limit, given)
    assert found.limit == "yield"
    assert cli.main(string) == 0
    assert "in air: no fluids given" in capsys.readouterr().out
    for option, names in (("--help", ["speed"]), ("--help-all", ["speed", "push", "yield-share"])):
        with pytest.raises(SystemExit):
            cli.main(["reach", option])
        text = capsys.readouterr().out
        assert all(f"--{name}" in text for name in names)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*some(range(8), 2, 0), 10])
def test_the_terminal_and_python_reach_the_same(seed: int, line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Drawn friction, tool, speed of sliding, push, force at the bit and share of yield, in the units of people."""
    rng = np.random.default_rng([48, 4, seed])
    friction, below = rng.uniform(0.2, 0.9, 2).round(3).tolist()
    share, push = round(rng.uniform(0.02, 1.0), 3), f"{rng.uniform(5.0, 60.0):.2f}kN"
    tool = f"{rng.uniform(1.0, 9.0):.2f}kN", f"{rng.uniform(5.0, 25.0):.2f}Hz", f"{rng.uniform(0.0, 90.0):.1f}ft"
    speed, bit = f"{rng.uniform(10.0, 60.0):.1f}ft/min", f"{rng.uniform(-500.0, 500.0):.1f}lbf"
    string = [*line[:3], "--rod", "2.00x0.156 CT90", "--bore", "4.778in", "--friction", f"{friction},{below}@900m"]
    limits = ["--yield-share", f"{100.0 * share:.1f}%", "--push", push, f"--far-force={bit}", "--speed", speed]
    assert cli.main([*string, *limits, *(["--tool", "@".join(tool)] if seed % 3 else []), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    found = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1000.0).reach(
        fr.WellPath.from_csv(line[2]),
        [(0.0, friction), (900.0, below)],
        tool=fr.VibrationTool(*tool) if seed % 3 else None,
        speed=speed,
        push=push,
        far_force=bit,
        yield_share=share,
    )
    record.pop("command", None)
    assert record["limit"] == found.limit
    assert {name: record[name] for name in found.as_dict()} == json.loads(json.dumps(found.as_dict()))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--friction", "0.3@1500m"], "--friction must be such as 0.2 or"),
        (["--friction", "0.3,0.2"], "--friction must be such as 0.2 or"),
        (["--friction", "much"], "--friction must be a number"),
        (["--friction", "0.3", "--tool", "5kN"], "--tool must be such as 5kN@18Hz"),
        (
            ["--friction", "0.3", "--tool", "5kN@18m"],
            "got '5kN@18m': 5kN is a force, 18m is a length; write it such as",
        ),
        (["--friction", "0.3", "--tool", "15Hz@1500lbf"], "1500lbf is a force; write 1500lbf@15Hz"),
        (["--friction", "0.3", "--tool", "5kN@30m@18Hz"], "18Hz is a frequency; write 5kN@18Hz@30m"),
        (
            ["--friction", "0.3", "--tool", "5kN@18Hz@2000m"],
            "--tool must lie in the string, less than its length 2000 m",
        ),
        (["--friction", "0.3", "--push", "3 furlong"], "--push must be a number with"),
        (["--friction", "0.3", "--yield-share", "150%"], "--yield-share must"),
        (["--friction", "0.3", "--yield-share", "much"], "--yield-share must be a number"),
        (["--friction", "0.3", "--out", "reach.doc"], "--out must end in"),
        (["--friction", "0.3", "--report", "reach.doc"], "--report must end in"),
        (["--friction", "0.3", "--unit", "mm/s"], "--unit must name units such as ft,lbf, got 'mm/s'"),
        (["--friction", "0.3", "--unit", "ft,lbf,m"], "--unit must name one unit of length, got ft and m"),
        (["--friction", "0.3", "--unit", "Fcr"], "--unit must be a unit of force (N, kN"),
        (["--friction", "0.3", "--depths", "1:2:3ft"], "--depths must be a list such as"),
        (["--friction", "0.3", "--depths", "deep"], "--depths must be a number with"),
        ([], "--friction"),
    ],
)
def test_bad_options_are_refused(
    options: list[str], words: str, line: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = cli.main([*line, *options])
    except SystemExit as ended:
        status = int(ended.code or 0)
    assert status == 2
    assert words in capsys.readouterr().err


def test_a_bad_survey_is_refused_with_its_line(line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    Path(line[2]).write_text(SURVEY + "1900,90,0\n", encoding="utf-8")
    assert cli.main([*line, "--friction", "0.3"]) == 2
    assert "line 6: depth at station 5 must increase" in capsys.readouterr().err


@pytest.mark.slow
def test_depths_and_units_that_were_asked_for(
    line: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rod, path = fr.Rod.from_toml(EXAMPLES / "tubing.toml"), fr.WellPath.from_csv(tmp_path / "survey.csv")
    foot, pound = 0.3048, 4.4482216152605
    assert cli.main([*line, "--friction", "0.3", "--depths", "4000,5000,6000ft", "--unit", "ft,lbf"]) == 0
    text = capsys.readouterr().out
    found = rod.reach(path, 0.3, depth=[4000 * foot, 5000 * foot, 6000 * foot])
    assert text.startswith(f"How far does the string go? To {found.reach / foot:,.0f} ft")
    rows = [row.split() for row in text.split("lower end lbf\n")[1].splitlines()]
    assert [row[0] for row in rows] == ["4000", "5000", "6000"]
    assert [row[1] for row in rows] == [f"{each / pound:.0f}" for each in found.injector]
    assert cli.main([*line, "--friction", "0.3", "--depths", "4000:6000ft", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["depth_m"] == pytest.approx(np.linspace(4000, 6000, 10) * foot)


def test_messages_about_a_survey_name_options(line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    for text, said in (
        ("MD,Inc,Azi\n0,0,0\n30,1,0\n", "--depth-unit must be given, such as m or ft: the heading names none"),
        ("MD (m),Inc (mil),Azi\n0,0,0\n30,1,0\n", "--angle-unit must be given, such as deg or rad"),
        (
            "Ort,DEVI,HAZI\nFT,DEG,DEG\n0,0,0\n30,1,0\n",
            "none of them says depth; choose one by --survey-columns DEPTH; the headings are 'Ort",
        ),
    ):
        Path(line[2]).write_text(text, encoding="utf-8")
        assert cli.main([*line, "--friction", "0.3"]) == 2
        assert said in capsys.readouterr().err
    assert cli.main([*line, "--friction", "0.3", "--depth-unit", "kg"]) == 2
    assert "--depth-unit must be a unit of length" in capsys.readouterr().err


def test_depths_beyond_the_survey_are_told_in_their_unit(line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*line, "--friction", "0.3", "--depths", "5000:7000ft"]) == 2
    assert "below the start of the path and down to its end, 0 to 6561.68 ft, got 7000 ft" in capsys.readouterr().err
