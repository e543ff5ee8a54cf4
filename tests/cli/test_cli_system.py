"""`floquetrod check --system`: systems from files, answers, JSON, exit status and one-line errors."""

from __future__ import annotations

import json
import math
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod import cli
from floquetrod.equations.system_files import read_system
from tests.seams import Tuned

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "floquetrod/examples/system.toml"

COUPLED = """\
[system]
stiffness = [[1, 0], [0, 4]]
cosines = [[[0.1, 0.2], [0.2, 0.16]]]
"""
BLADE = """\
[system]
mean = [[0, 1], [-1, -1.5]]
cosines = [[[0, 0], [-3.0, 0]]]
sines = [[[0, 0], [0, -3.0]], [[0, 0], [-3.375, 0]]]
frequency = 1
"""


def written(tmp_path: Path, text: str, name: str = "system.toml") -> str:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def said(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert cli.main(["check", "--system", *arguments]) == status
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


# --- answers ---------------------------------------------------------------------------------------------------------


def test_check_tells_all_a_user_needs(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, str(EXAMPLE))
    assert text.startswith("UNSTABLE: grows at 0.0353278 per unit time\n")
    for line in (
        r"system    2 equations of second order, hamiltonian, 1 harmonic, period 2.0944 \(angular frequency 3\)",
        r"growth    0\.0353278 per unit time, tenfold in 65\.18",
        r"named     sum resonance of modes 1 and 2, order 1, growth 0\.0353278",
        r"margin    the largest multiplier lies 0\.0768 outside the unit circle",
        r"damping   stable with more damping than C \+ 0\.070671\d I, which adds a decay rate of 0\.035336 per unit",
        r"method    half_period, 1 half period; multipliers good to \de-1\d relative",
        r"  -0\.539940098 \+0\.931641105i     1\.07679639     \+0\.667193     \de-1\d$",
    ):
        assert re.search(line, text, re.MULTILINE), line


def test_a_stable_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, written(tmp_path, COUPLED + "frequency = 1.0\n"), "--exit-code")
    assert text.startswith("STABLE, strongly: small changes of the coefficients leave every motion bounded\n")
    assert "growth    " not in text
    assert "damping   " not in text
    apart = re.search(r"on the unit circle; those of opposite Krein signs are (\S+) rad apart or more", text)
    assert apart is not None
    result = fr.stability(read_system(tmp_path / "system.toml"))
    angles = {
        sign: [np.angle(mu) for mu, s in zip(result.multipliers, result.krein_signs, strict=True) if s == sign]
        for sign in (1, -1)
    }
    expected = min(abs(math.remainder(a - b, 2.0 * math.pi)) for a in angles[1] for b in angles[-1])
    assert float(apart[1]) == pytest.approx(expected, rel=1e-3)
    signs = re.findall(r"([+-])$", text, re.MULTILINE)
    assert sorted(signs) == ["+", "+", "-", "-"]


def test_a_unit_of_the_frequency_makes_time_seconds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = "\nTime is in seconds, because {} has a unit: the matrices must be in seconds, too.\n"
    given = 'frequency = "4.8 GHz"'
    path = written(tmp_path, COUPLED + given)
    assert said(capsys, path).endswith(line.format(given))
    assert cli.main(["certify", "--system", path]) == 0
    assert capsys.readouterr().out.endswith(line.format(given))
    delay = '[[system.delayed]]\ndelay = "1.5s"\nmatrix = [[0.1, 0], [0, 0]]'
    assert said(capsys, written(tmp_path, f"{COUPLED}frequency = 3\n{delay}")).endswith(line.format('delay = "1.5s"'))
    family = '[system]\nstiffness = [["a"]]\ncosines = [[["b"]]]\n[parameters]\na = "1:2"\nb = "0:1"\n'
    path, out = written(tmp_path, family.replace("[par", f"{given}\n[par")), str(tmp_path / "chart.npz")
    assert cli.main(["chart", "--system", path, "--points", "2x2", "--pixels", "--out", out]) == 0
    assert line.format(given) in capsys.readouterr().out
    assert "Time is" not in said(capsys, written(tmp_path, COUPLED + "frequency = 30.16"))


@pytest.mark.parametrize(("given", "unit"), [('frequency = "4.8 GHz"', "s"), ("frequency = 30.16", None)])
def test_json_names_the_unit_of_time(
    given: str, unit: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, COUPLED + given)
    family = f'[system]\nstiffness = [["a"]]\ncosines = [[["b"]]]\n{given}\n[parameters]\na = "1:2"\nb = "0:1"\n'
    drawn = ["--points", "2x2", "--pixels", "--out", str(tmp_path / "chart.npz")]
    for command in (
        ["check", "--system", path],
        ["certify", "--system", path],
        ["chart", "--system", written(tmp_path, family, "family.toml"), *drawn],
    ):
        assert cli.main([*command, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["time_unit"] == unit


def test_a_system_file_is_read_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line on the unit of time is about the file that was answered, whatever becomes of it meanwhile."""
    family = '[system]\nstiffness = [["a"]]\ncosines = [[["b"]]]\nperiod = "2s"\n[parameters]\na = "1:2"\nb = "0:1"\n'
    drawn = ["--points", "2x2", "--pixels", "--out", str(tmp_path / "chart.npz")]
    for command, text, answer, more in (
        ("check", COUPLED + 'period = "2s"', "stability", []),
        ("certify", COUPLED + 'period = "2s"', "certify", []),
        ("chart", family, "chart", drawn),
    ):
        path, decide = written(tmp_path, text), getattr(fr, answer)

        def decide_without_file(*given: Any, path: str = path, decide: Any = decide, **named: Any) -> Any:
            Path(path).unlink()
            return decide(*given, **named)

        monkeypatch.setattr(fr, answer, decide_without_file)
        assert cli.main([command, "--system", path, *more]) == 0
        assert 'Time is in seconds, because period = "2s" has a unit' in capsys.readouterr().out


def test_a_damped_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    damped = COUPLED + "frequency = 1.0\ndamping = [[0.1, 0], [0, 0.4]]\n"
    text = said(capsys, written(tmp_path, damped), "--exit-code", "--method", "monodromy")
    assert text.startswith("STABLE: every motion decays\n")
    inside = re.search(r"margin    the largest multiplier lies (\S+) inside the unit circle", text)
    assert inside is not None
    largest = max(map(abs, fr.stability(read_system(tmp_path / "system.toml")).multipliers))
    assert float(inside[1]) == pytest.approx(1.0 - largest, rel=1e-3)
    assert "method    monodromy, " in text


def test_a_system_of_first_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, written(tmp_path, BLADE), "--exit-code", status=1)
    assert text.startswith("UNSTABLE: grows at 0.0906136 per unit time\n")
    assert "2 equations of first order, general, 2 harmonics, period 6.28319" in text
    assert "damping   stable with A - c I in place of A, c above 0.0906136 per unit time\n" in text


def test_the_damping_of_a_first_order_system_with_delays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    delayed = "[[system.delayed]]\ndelay = 1.0\nmatrix = [[-3.0]]"
    text = said(capsys, written(tmp_path, f"[system]\nmean = [[-1.0]]\nperiod = 1.0\n{delayed}"))
    found = re.search(
        r"^damping   stable with A - c I in place of A, c above (\S+) per unit time; larger", text, re.MULTILINE
    )
    assert found is not None
    # At the least c, i w = -(1 + c) - 3 exp(-i w): then 3 sin w = w and 1 + c = -3 cos w.
    w = brentq(lambda w: 3.0 * math.sin(w) - w, 2.0, 3.0)
    assert float(found[1]) == pytest.approx(-1.0 - 3.0 * math.cos(w), rel=1e-5)


def test_no_damping_suffices_for_an_unstable_mean(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "[system]\nstiffness = [[-1.0, 0.0], [0.0, 1.0]]\nperiod = 2.0")
    text = "strong damping does not stabilise it, as the mean stiffness alone is unstable; weak damping may (fr.margin"
    assert text in said(capsys, path)
    assert json.loads(said(capsys, path, "--json"))["damping_to_stabilise_per_unit_time"] is None


def test_an_undecided_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crossing = COUPLED.replace("0.2", "0.0").replace("0.16", "0").replace("0.1,", "1e-16,") + "frequency = 3\n"
    text = said(capsys, written(tmp_path, crossing), "--exit-code", "--method", "half_period", status=3)
    assert text.startswith("UNDECIDED: ")
    assert "note      4 multipliers near" in text
    assert said(capsys, written(tmp_path, crossing), "--method", "half_period")


def test_constant_coefficients(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, written(tmp_path, "[system]\nstiffness = [[2.0]]\nperiod = 1.0"))
    assert text.startswith("STABLE")
    assert "1 equation of second order, hamiltonian, constant coefficients, period 1 " in text


def test_many_multipliers_are_cut_short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "chain.npz"
    np.savez(path, stiffness=np.diag(np.arange(1.0, 31.0)), damping=np.diag(np.linspace(0.1, 0.2, 30)), period=1.0)
    text = said(capsys, str(path))
    assert "and 20 more, which decay faster (the JSON lists them)" in text
    assert len(json.loads(said(capsys, str(path), "--json"))["multipliers"]) == 60


@pytest.mark.parametrize("frequency", [1.0, 3.0])
def test_json_is_strict_and_says_the_same(frequency: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, COUPLED + f"frequency = {frequency}\n")
    status = 1 if frequency == 3.0 else 0
    text = said(capsys, path, "--json", "--exit-code", status=status)
    record = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    result = fr.stability(read_system(path))
    assert record["status"] == result.status
    assert record["strongly_stable"] is result.strongly_stable
    assert record["growth_rate_per_unit_time"] == result.growth_rate
    assert record["damping_to_stabilise_per_unit_time"] == result.damping_to_stabilise
    assert (result.damping_to_stabilise > 0.0) == (frequency == 3.0)
    assert [complex(m["real"], m["imag"]) for m in record["multipliers"]] == list(result.multipliers)
    assert [m["error"] for m in record["multipliers"]] == list(result.multiplier_errors)
    assert [m["krein_sign"] for m in record["multipliers"]] == list(result.krein_signs)
    assert [r["name"] for r in record["resonances"]] == [str(r) for r in result.resonances]
    assert (record["largest_multiplier_less_1"] > 0.0) == (frequency == 3.0)
    assert (record["opposite_krein_signs_apart_rad"] is None) == (frequency == 3.0)
    assert record["structure"] == "hamiltonian"
    assert record["period"] == result.period


def test_multipliers_beyond_a_double_are_null(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "[system]\nstiffness = [[-1.0]]\nperiod = 30.0")
    record = json.loads(said(capsys, path, "--json"), parse_constant=lambda name: pytest.fail(name))
    assert record["status"] == "unstable"
    assert record["growth_rate_per_unit_time"] == pytest.approx(1.0, rel=1e-9)


# --- files -----------------------------------------------------------------------------------------------------------


def test_the_example_is_the_system_it_says() -> None:
    expected = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [[[0.1, 0.2], [0.2, 0.16]]], period=2.0 * math.pi / 3.0)
    assert read_system(EXAMPLE) == expected


@pytest.mark.parametrize(
    ("line", "period"),
    [
        ("period = 2.0", 2.0),
        ("period = 2", 2.0),
        ('period = "0.2s"', 0.2),
        ("frequency = 4", 0.5 * math.pi),
        ('frequency = "50Hz"', 0.02),
        ('frequency = "60 rpm"', 1.0),
    ],
)
def test_period_or_frequency(line: str, period: float, tmp_path: Path) -> None:
    assert read_system(written(tmp_path, COUPLED + line)).period == pytest.approx(period, rel=1e-15)


def test_every_matrix_is_read(tmp_path: Path) -> None:
    arrays: dict[str, Any] = {
        "stiffness": np.array([[1.0, 0.25], [0.25, 4.0]]),
        "cosines": np.array([[[0.5, 1.0], [1.0, 0.5]], [[0.0, 0.1], [0.1, 0.0]]]),
        "sines": np.array([[[0.5, 0.0], [0.0, 0.25]]]),
        "mass": np.array([[3.0, 1.0], [1.0, 1.0]]),
        "damping": np.array([[0.1, 0.0], [0.0, 0.3]]),
        "gyroscopic": np.array([[0.0, 0.5], [-0.5, 0.0]]),
        "period": 2.5,
    }
    expected = fr.HillSystem(**arrays)
    lines = [f"{name} = {np.asarray(value).tolist()}" for name, value in arrays.items()]
    assert read_system(written(tmp_path, "\n".join(["[system]", *lines]))) == expected
    np.savez(tmp_path / "one.npz", **arrays)
    np.savez_compressed(tmp_path / "two.npz", **arrays)
    assert read_system(tmp_path / "one.npz") == read_system(tmp_path / "two.npz") == expected
    turned = {name: value for name, value in arrays.items() if name != "period"} | {"frequency": "24Hz"}
    np.savez(tmp_path / "three.npz", **turned)
    assert read_system(tmp_path / "three.npz").period == pytest.approx(1.0 / 24.0)
    first = {"mean": arrays["stiffness"], "sines": arrays["cosines"], "period": 2.5, "coefficient_error": 1e-12}
    np.savez(tmp_path / "four.npz", **first)
    assert read_system(tmp_path / "four.npz") == fr.PeriodicSystem(**first)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stiffness = ", r"cannot be read: Invalid value"),
        ("stiffness = [[1.0]]", r"cannot be read: it has no table \[system\]"),
        ("system = 3", r"cannot be read: it has no table \[system\]"),
        ("[system]\nstiffness = [[1.0]]\n[rod]\nlength = 3", r"it holds 'rod' outside of \[system\]"),
        ("[system]\nstifness = [[1.0]]", "unknown key 'stifness'; did you mean stiffness?"),
        ("[system]\nstiffness = [[1.0]]\nsine = []", "unknown key 'sine'; did you mean sines?"),
        ("[system]\nstiffness = [[1.0]]\nx = 1", "unknown key 'x'; the keys are stiffness, mass, "),
        ("[system]\nmass = [[1.0]]", "it has neither stiffness nor mean; give stiffness for M q''"),
        ("[system]\nstiffness = [[1.0]]\nmean = [[1.0]]", "it has stiffness and mean; give stiffness for"),
        ("[system]\nmean = [[1.0]]\nmass = [[1.0]]", "key 'mass' does not go with mean, in first order"),
        ("[system]\nmean = [[1.0]]\ndamping = [[1.0]]", "key 'damping' does not go with mean"),
        (COUPLED, "it has neither period nor frequency; give one of them for cosines and sines"),
        (COUPLED + "period = 1\nfrequency = 1", "it has period and frequency; give one of them"),
        (COUPLED + "period = 0", "period must be greater than zero, got 0"),
        (COUPLED + "period = nan", "period must be finite, got nan"),
        (COUPLED + "period = true", "period must be a number with a time unit"),
        (
            COUPLED + 'period = "2 Hz"',
            "period must be a number with a time unit .* unit 'Hz' is not understood; it is a unit of frequency\n$",
        ),
        (COUPLED + 'period = "pi"', r"'pi'.*; formulas need a table \[parameters\], which may be empty"),
        ('[system]\nstiffness = [["2*pi"]]', r"real number, got .*; formulas need a table \[parameters\]"),
        (COUPLED + "frequency = [1]", "frequency must be a number with a frequency unit"),
        (COUPLED + "frequency = 1e-320", "period must be finite|frequency must"),
        (COUPLED + f"period = 1{'0' * 400}", "period must be finite, got an integer beyond 1e308"),
        ("[system]\nstiffness = [[1.0, 2.0]]", r"stiffness must be a square matrix.*got shape \(1, 2\)"),
        ("[system]\nstiffness = [[1.0, 2.0], [3.0]]", "stiffness must be an array or nested lists of equal lengths"),
        ("[system]\nstiffness = [[nan]]", "stiffness must be finite"),
        ("[system]\nstiffness = [[1e40]]", "stiffness must be finite and lie between"),
        ('[system]\nstiffness = [["1"]]', r"stiffness\[0\]\[0\] must be a real number, got '1'\n$"),
        (
            '[system]\nmean = [[0, "-0.5i*25"], [1, 0]]',
            r"mean\[0\]\[1\] must be a number, or a text such as \"-0.1\+2i\" for a complex one, got '-0.5i\*25'; "
            r"formulas need a table \[parameters\], which may be empty\n$",
        ),
        ('[[system.pieces]]\nduration = 1\nmean = [["i*3"]]', r"pieces\[0\].mean\[0\]\[0\].*; formulas need a table"),
        ('[system]\nmean = [["-0.5I"]]', r"mean\[0\]\[0\].* got '-0.5I'; the imaginary unit is written i\n$"),
        ('[system]\nmean = [["2.5I*a"]]\n[parameters]\na = 1', r"mean\[0\]\[0\].*; the imaginary unit is written i\n$"),
        (
            '[system]\nstiffness = [["-0.5i*25"]]',
            r"stiffness\[0\]\[0\] must be a real number, got '-0.5i\*25'; complex entries need mean, in first order",
        ),
        (
            '[system]\nstiffness = [["-0.5i*a"]]\n[parameters]\na = 1',
            r"stiffness\[0\]\[0\] must be .*; complex entries need mean, in first order without delays\n$",
        ),
        (f"[system]\nmean = {'[' * 340}{']' * 340}", "it has lists or tables nested more than 16 deep"),
        ("[system]\nstiffness = [[true]]", "stiffness must hold real numbers"),
        ("[system]\nstiffness = [[2026-01-01]]", "stiffness must be|stiffness.* must be"),
        ("[system]\nstiffness = 4.0", r"stiffness must be a square matrix.*for one equation give \[\[4.0\]\]"),
        ("[system]\nstiffness = [[9007199254740993]]", "is not a binary number of 53 digits"),
        (COUPLED + "period = 1\nmass = [[1, 0.1], [0.2, 1]]", "mass must be symmetric"),
        (COUPLED + "period = 1\nsines = [[0, 1], [1, 0]]", r"sines must be a sequence of matrices"),
        (COUPLED + "period = 1\nsines = [[[0, 1]]]", r"sines\[0\] must be a square matrix"),
        ("[system]\nstiffness = [[[1.0]], [[2.0]]]", r"a batch of shape \(2,\)"),
        ("[system]\nstiffness = " + 3000 * "[", "cannot be read"),
    ],
)
def test_bad_files_are_one_line_and_status_2(
    text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, text)
    assert cli.main(["check", "--system", path, "--exit-code"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith(f"floquetrod: error: --system: system file {path}")
    assert re.search(message, captured.err)


def test_files_of_other_kinds(tmp_path: Path, tuned: Tuned) -> None:
    def refused(name: str, message: str) -> None:
        with pytest.raises(ValueError, match=f"system file .*{re.escape(name)}.*{message}"):
            read_system(tmp_path / name)

    refused("missing.toml", "cannot be read: there is no such file")
    (tmp_path / "folder.npz").mkdir()
    refused("folder.npz", "cannot be read: it is a folder or a device")
    refused("system.json", "must end in .toml or .npz")
    (tmp_path / "latin.toml").write_bytes(b"# \xe9\n")
    refused("latin.toml", "cannot be read: 'utf-8' codec")
    (tmp_path / "text.npz").write_text("stiffness")
    refused("text.npz", "cannot be read: File is not a zip file")
    np.savez(tmp_path / "objects.npz", stiffness=np.array([[object()]], dtype=object))
    refused("objects.npz", "cannot be read: Object arrays cannot be loaded")
    np.savez(tmp_path / "complex.npz", stiffness=np.array([[1j]]))
    refused("complex.npz", "stiffness must hold real numbers")
    np.savez(tmp_path / "other.npz", a=1.0)
    refused("other.npz", "unknown key 'a'")
    with zipfile.ZipFile(tmp_path / "foreign.npz", "w") as archive:
        archive.writestr("stiffness.txt", "1")
    refused("foreign.npz", "'stiffness.txt' is no array")
    np.savez(tmp_path / "cut.npz", stiffness=np.eye(50))
    content = (tmp_path / "cut.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(content[: len(content) // 2])
    refused("cut.npz", "cannot be read")
    (tmp_path / "flipped.npz").write_bytes(content[:400] + bytes([content[400] ^ 255]) + content[401:])
    refused("flipped.npz", "cannot be read: Bad CRC-32")
    np.savez_compressed(tmp_path / "bomb.npz", stiffness=np.zeros((300, 300)))
    tuned(bytes_of_a_system_file={".toml": 10, ".npz": 100_000})
    refused("bomb.npz", "cannot be read: it holds 720,128 bytes, at most 100,000 are read")
    (tmp_path / "long.toml").write_text(COUPLED)
    refused("long.toml", "cannot be read: it has 76 bytes, at most 10 are read")


# --- options ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rod", "nitinol", "--system", "a.toml"], "not allowed with argument"),
        ([], "one of the arguments --system --rod is required"),
        (
            ["--system", "a.toml", "--mean", "1N"],
            "--mean belongs to --rod, got .1N.: a system is described by its file alone",
        ),
        (
            ["--system", "a.toml", "--margins"],
            "--margins belongs to --rod: a system is .* alone; fr.margin in Python finds the margins of its parameters",
        ),
        (["--system", "a.toml", "--frequency", "0"], "--frequency belongs to --rod"),
        (["--system", "a.toml", "--growth-tolerance", "0"], "--growth-tolerance belongs to --rod"),
        (["--system", "a.toml", "--friction", "0.0"], "--friction belongs to --rod"),
        (["--system", "a.toml", "--modes", "1"], "--modes belongs to --rod"),
        (["--system", "a.toml"], "--system must be a TOML or npz file, got .a.toml.: there is no such file"),
        (["--system", ""], "--system must be a TOML or npz file"),
        (
            ["--system", str(EXAMPLE), "--method", "best"],
            "--method must be one of 'auto', .* got 'best'",
        ),
        (
            ["--rod", "nitinol", "--mean", "1", "--amplitude", "1", "--frequency", "9", "--method", "auto"],
            "--method belongs to --system",
        ),
    ],
)
def test_options_that_do_not_go_together(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["check", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert re.search(message, captured.err)


def test_the_file_in_the_help_is_a_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["check", "--help-all"])
    shown = capsys.readouterr().out
    found = re.search(r"^  \[system\]\n(?:  \w+ = .*\n)+", shown, re.MULTILINE)
    assert found is not None
    system = read_system(written(tmp_path, found[0].replace("  [", "[", 1)))
    assert system == read_system(EXAMPLE)
    assert "floquetrod check --system system.toml" in shown


def test_certify_proves_the_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["certify", "--system", str(EXAMPLE), "--exit-code"]) == 1
    assert capsys.readouterr().out == f"PROVED UNSTABLE: {fr.certify(read_system(EXAMPLE)).statement} (15 digits)\n"  # type: ignore[union-attr]
    calm = written(tmp_path, "[system]\nstiffness = [[1.0, 0.0], [0.0, 4.0]]\nperiod = 2.5\n")
    assert cli.main(["certify", "--system", str(calm), "--json", "--exit-code"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "stable"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--largest"], "--largest belongs to --rod"),
        (["--vary", "length=1%"], "--vary belongs to --rod"),
        (["--mean", "3N"], "--mean belongs to --rod, got '3N'"),
        (["--growth-tolerance", "0.1"], "--growth-tolerance belongs to --rod"),
        (["--rod", "nitinol"], "not allowed with"),
    ],
)
def test_a_system_takes_no_box(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["certify", "--system", str(EXAMPLE), *arguments]) == 2
    assert re.search(message, capsys.readouterr().err)


FAMILY = (ROOT / "floquetrod/examples/family.toml").read_text(encoding="utf-8")
NUMBERS = FAMILY.replace('"1.5:4.5"', "2.0").replace('"0:0.6"', '"3/10"')


def test_a_family_is_checked_at_numbers_of_its_parameters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    family, numbers = tmp_path / "family.toml", tmp_path / "numbers.toml"
    family.write_text(FAMILY, encoding="utf-8")
    numbers.write_text(NUMBERS, encoding="utf-8")
    asked = [
        ["--system", str(numbers)],
        ["--system", str(family), "--set", "omega=2", "--set", "epsilon = 0.3"],
        ["--system", str(numbers), "--set", "zeta=0.02/2"],
    ]
    answers = []
    for words in asked:
        assert cli.main(["check", *words, "--json"]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1] == answers[2]
    matrices = {"cosines": [[[0.15, 0.3], [0.3, 0.24]]], "damping": [[0.02, 0.0], [0.0, 0.04]]}
    alike = fr.stability(fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], **matrices, period=math.pi))
    assert answers[0]["status"] == alike.status == "unstable"
    assert answers[0]["growth_rate_per_unit_time"] == pytest.approx(alike.growth_rate, rel=1e-12)
    assert cli.main(["check", *asked[1]]) == 0
    assert "damping" in capsys.readouterr().out
    assert cli.main(["certify", *asked[1]]) == 0
    assert "UNSTABLE" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        (FAMILY, [], "parameter 'omega' must have a number for one system, got the range 1.5:4.5; give it one, in the "
         "terminal --set omega=3, or draw them all by floquetrod chart"),
        (FAMILY, ["omega=2", "epsilon=0:1"], "parameter 'epsilon' must have a number for one system"),
        (NUMBERS, ["omeg=2"], "did you mean omega?"),
        (NUMBERS, ["omega"], "--set must be a parameter and its value such as omega=2.5, got 'omega'"),
        (NUMBERS, ["omega=2", "omega=3"], "--set must give omega once, got '2' and '3'"),
        (NUMBERS, ["omega=2Hz"], "omega must be a number without a unit, or a formula of numbers"),
        (NUMBERS.replace("0.01", "true"), [], "zeta must"),
        (COUPLED + "frequency = 3.0\n", ["omega=2"], "it has no table [parameters], and a value of 'omega' was given"),
    ],
)  # fmt: skip
def test_wrong_values_of_parameters_are_refused(
    text: str, words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "system.toml"
    path.write_text(text, encoding="utf-8")
    assert cli.main(["check", "--system", str(path), *(word for value in words for word in ("--set", value))]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert len(said.splitlines()) == 1


@pytest.mark.parametrize("command", ["check", "certify"])
def test_parameters_of_a_system_do_not_go_with_a_rod(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([command, "--rod", "nitinol", "--frequency", "20Hz", "--set", "omega=2"]) == 2
    assert "--set belongs to --system, got 'omega=2' with --rod" in capsys.readouterr().err
