"""`floquetrod certify`: words, numbers, exit statuses and refusals."""

from __future__ import annotations

import json

import pytest

import floquetrod as fr
from floquetrod.cli import certify
from floquetrod.cli.main import main

LOAD = ["--mean", "0.33Fcr:0.35Fcr", "--amplitude", "0.2Fcr", "--frequency", "150", "--growth-tolerance", "0.05"]
POINT = ["--mean", "0.34Fcr", "--amplitude", "0.2Fcr", "--frequency", "24Hz", "--damping-rate", "0.5"]


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Return exit status, output and errors of the command for the reference rod."""
    status = main(["certify", "--rod", "nitinol", *arguments])
    output = capsys.readouterr()
    return status, output.out, output.err


def test_a_box_proved_stable(capsys: pytest.CaptureFixture[str]) -> None:
    status, text, _ = run(capsys, *LOAD, "--exit-code")
    assert status == 0
    assert text.startswith("PROVED STABLE: under no load of the box does a mode grow faster than 0.05 1/s")
    assert "mean force 0.33 to 0.35 Fcr" in text
    assert "frequency 150 rad/s" in text


def test_json_has_si_units(capsys: pytest.CaptureFixture[str]) -> None:
    _, text, _ = run(capsys, *LOAD, "--vary", "length=3.099:3.101", "--vary", "radius=0.8:0.8mm", "--json")
    record = json.loads(text)
    assert record["status"] == "stable"
    force = fr.Rod.nitinol().critical_force
    assert record["box"][0] == {"name": "mean", "low": 0.33 * force, "high": 0.35 * force, "unit": "N"}
    assert record["box"][3] == {"name": "length", "low": 3.099, "high": 3.101, "unit": "m"}
    assert record["box"][4]["low"] == record["box"][4]["high"] == pytest.approx(0.8e-3)
    assert record["share_stable"] == 1.0


def test_mixed_unstable_and_undecided_exit_statuses(capsys: pytest.CaptureFixture[str]) -> None:
    mixed = [*LOAD, "--vary", "length=2.9:3.1", "--exit-code"]
    status, text, _ = run(capsys, *mixed)
    assert status == 1
    assert text.startswith("MIXED")
    assert text.count("example") == 2
    assert ", length " in text
    unstable = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "149:151", "--exit-code"]
    status, text, _ = run(capsys, *unstable)
    assert (status, text.split(":")[0]) == (1, "PROVED UNSTABLE")
    status, text, _ = run(capsys, *LOAD[:-1], "0", "--exit-code", "--unit", "N,Hz")
    assert (status, text.split("\n")[0]) == (3, "UNDECIDED")
    assert "note" in text
    assert "23.8732 Hz" in text
    record = json.loads(run(capsys, *mixed, "--json")[1])
    assert [example["status"] for example in record["examples"]] == ["stable", "unstable"]


@pytest.mark.parametrize(
    "text",
    [
        "length=±5mm",
        "length=3.1m±5mm",
        "length=3100±5mm",
        "length=3100mm+-5",
        "length=3.1m+/-0.005",
        "length=3.095:3.105m",
    ],
)
def test_a_tolerance_may_stand_behind_the_value_of_the_rod(text: str) -> None:
    name, ends = certify._tolerance(text, fr.Rod.nitinol())
    assert name == "length"
    assert ends == pytest.approx((3.095, 3.105), rel=1e-12)


def test_tolerances_are_told_in_their_own_units(capsys: pytest.CaptureFixture[str]) -> None:
    foot = 0.3048
    _, text, _ = run(capsys, *LOAD, "--vary", f"length=±{0.001 / foot}ft", "--vary", "channel_diameter=0.001%")
    assert f"rods      length {3.099 / foot:.6g} to {3.101 / foot:.6g} ft" in text
    radius = fr.Rod.nitinol().channel_radius / 0.0254
    assert f"channel radius {0.99999 * radius:.6g} to {1.00001 * radius:.6g} in" in text
    _, text, _ = run(capsys, *LOAD, "--vary", "length=3.099:3.101", "--unit", "cm")
    assert "rods      length 309.9 to 310.1 cm" in text


@pytest.mark.slow
def test_the_largest_safe_box(capsys: pytest.CaptureFixture[str]) -> None:
    status, text, _ = run(capsys, *POINT, "--largest")
    assert status == 0
    assert text.startswith("proved: no mode grows faster than ")
    assert text.splitlines()[1].split() == ["from", "now", "to", "unit"]
    assert text.splitlines()[4].split()[-1] == "Hz"
    record = json.loads(run(capsys, *POINT, "--largest", "--json")[1])
    mean = record["safe"][0]
    assert mean["low"] < mean["value"] < mean["high"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([*LOAD, "--largest"], "--largest needs one load"),
        ([*LOAD, "--vary", "length"], "--vary must be a parameter"),
        ([*LOAD, "--vary", "lenth=3:4"], "--vary must be a parameter"),
        ([*LOAD, "--vary", "length=4:3"], "--vary must be a range"),
        ([*LOAD, "--vary", "length=3kg:4kg"], "--vary must be a number with a length unit"),
        ([*LOAD, "--vary", "length=0.1ft"], "one value; a tolerance of that size is length=±0.1ft"),
        ([*LOAD, "--vary", "length=3.1m"], "one value, the rod's own; a tolerance is length=3.1m±1%"),
        ([*LOAD, "--vary", "length=4m±1mm"], "write length=±1mm, or length=3.999:4.001m for a range about another"),
        ([*LOAD, "--vary", "length=4m±1kg"], "--vary must be a number with a length unit"),
        ([*LOAD, "--vary", "length=3:3.1", "--vary", "length=3.1:3.2"], "--vary must name a parameter once"),
        ([*LOAD, "--max-boxes", "0"], "--max-boxes must be 1 or more"),
        (["--mean", "0.3"], "--amplitude, --frequency"),
        ([*POINT[:4], "--frequency", "0:150"], "--frequency must be greater than zero"),
        ([*LOAD, "--wave", "free"], "certify needs independent modes"),
        ([*POINT, "--wave", "free", "--largest"], "error: --largest needs independent modes"),
        ([*POINT, "--noise", "1e-4N^2/Hz", "--largest"], "--largest is not answered under noise"),
        (["--mean", "0.2Fcr", *POINT[2:6], "--largest"], "proved stable"),
    ],
)
def test_refusals(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, errors = run(capsys, *arguments)
    assert status == 2
    assert words in errors
    assert errors.count("\n") == 1
