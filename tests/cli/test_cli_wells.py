"""Options of the terminal for rods in wells: --path, --depth, --curvature, --natural-curvature."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

import floquetrod as fr
from floquetrod.cli.main import main

LOAD = ["--mean", "0.3N", "--amplitude", "0.2N", "--frequency", "24Hz"]
ROD = fr.Rod.nitinol()


@pytest.fixture
def survey(tmp_path: Path) -> Path:
    path = tmp_path / "survey.csv"
    path.write_text("MD (m),Inc (deg),Azi (deg)\n0,70,10\n50,90,10\n")
    return path


@pytest.mark.slow
def test_a_rod_on_a_path_is_that_of_python(survey: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["check", "--rod", "nitinol", *LOAD, "--path", str(survey), "--depth", "20m", "--no-margins", "--json"])
        == 0
    )
    rod = ROD.replace(path=fr.WellPath.from_csv(survey), depth=20.0)
    found = rod.stability(fr.AxialLoad(0.3, 0.2, 2.0 * math.pi * 24.0))
    said = json.loads(capsys.readouterr().out)
    assert (said["status"], said["growth_rate_per_s"]) == (found.status, pytest.approx(found.growth_rate))
    assert said["rod"]["depth"] == 20.0


def test_a_curvature_keeps_the_modes_independent(capsys: pytest.CaptureFixture[str]) -> None:
    curved = ["--rod", "nitinol", "--curvature", "3deg/30m"]
    assert main(["ranges", *curved, "--mean", "0.3N", "--amplitude", "0.2N", "--frequency", "20Hz:24Hz", "--json"]) == 0
    rod = ROD.replace(curvature="3deg/30m")
    found = rod.ranges(
        "frequency", mean=0.3, amplitude=0.2, bounds=(40.0 * math.pi, 48.0 * math.pi), growth_tolerance=1e-6
    )
    assert json.loads(capsys.readouterr().out)["stable"] == json.loads(json.dumps(found.as_dict()["stable"]))
    assert main(["certify", *curved, *LOAD, "--json"]) == 0
    verdict = rod.stability(fr.AxialLoad(0.3, 0.2, 48.0 * math.pi)).status
    assert json.loads(capsys.readouterr().out)["status"] == verdict


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--depth", "3m"], "--depth needs --path, got '3m' alone"),
        (["--path", "{survey}", "--curvature", "0.1"], "--curvature must not be given with --path"),
        (["--path", "{survey}", "--inclination", "80deg"], "--inclination must not be given with --path"),
        (["--path", "none.csv"], "survey none.csv: there is no such file"),
        (["--path", "{survey}", "--depth", "48m"], "--depth"),
        (["--path", "{survey}", "--depth", "deep"], "error: --depth must be a number with a length unit"),
        (["--path", "{bare}"], "--depth-unit must be given, such as m or ft"),
        (["--curvature", "3kg"], "error: --curvature must be a number with a curvature unit"),
        (["--curvature", "nan"], "--curvature must be"),
    ],
)
def test_mistakes_name_the_option(
    options: list[str], message: str, survey: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bare = survey.with_name("bare.csv")
    bare.write_text("md,inc,azi\n0,70,10\n50,90,10\n")
    given = [text.format(survey=survey, bare=bare) for text in options]
    assert main(["check", "--rod", "nitinol", *LOAD, *given]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_the_explorer_says_the_command_of_a_rod_in_a_well(
    survey: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "shown.png"
    assert main(["explore", "--rod", "nitinol", *LOAD, "--curvature", "3deg/30m", "--out", str(picture)]) == 0
    assert "--curvature 3deg/30m" in capsys.readouterr().out


@pytest.mark.slow
def test_a_rod_bent_like_its_well_is_simulated(survey: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["simulate", "--rod", "nitinol", *LOAD, "--path", str(survey), "--duration", "0.2s", "--no-theory", "--json"]
    assert main([*line, "--natural-curvature", "path"]) == 0
    bent = json.loads(capsys.readouterr().out)
    assert main(line) == 0
    assert json.loads(capsys.readouterr().out) != bent
    assert main([*line, "--natural-curvature", "round"]) == 2
    assert "--natural-curvature must be" in capsys.readouterr().err
