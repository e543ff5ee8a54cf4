"""The terminal: answers, JSON, one-line errors, exit status; and the examples."""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
import runpy
import shlex
import subprocess
import sys
import threading
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod import cli
from floquetrod._util import waiting
from floquetrod.cli.main import _parser as parser
from floquetrod.floquet.registry import applicable
from tests.conftest import depth
from tests.seams import Forbidden

mpl.use("Agg")

ROOT = Path(__file__).parents[2]
LOAD = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]
CHECK = ["check", "--rod", "nitinol", *LOAD]


def test_check_tells_all_a_user_needs(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(CHECK) == 0
    text = capsys.readouterr().out
    assert text.startswith("UNSTABLE: mode 7 grows, tenfold in 0.544 s\n")
    for line in (
        r"growth    4\.23568 1/s in mode 7, tenfold in 0\.5436 s",
        r"grows to  about 24 degrees in mode 7 alone, about which it beats without damping",
        r"load      mean 0\.2 Fcr \(0\.3392 N\), amplitude 0\.2 Fcr \(0\.3392 N\), 150 rad/s \(23\.87 Hz\)",
        r"margins   mean force  stable 0\.1256 Fcr lower or 0\.0743\d Fcr higher\n",
        r"          amplitude   stable 0\.1461 Fcr lower, in steps of \S+ Fcr\n",
        r"          frequency   stable 11\.34 rad/s lower or 6\.332 rad/s higher\n",
        r"damping   stable with a damping_rate above 4\.20579 1/s",
        r"checked   modes 1 to 23: every higher mode grows at less than \de-\d+ per second",
        r"          of these modes the table lists those that grow and the nearest to growth\n",
        r"method    spectral; discriminants good to \de-13 relative",
        r"   7    0\.058051    -0\.242143  tongue 1 +4\.236",
    ):
        assert re.search(line, text), line


def test_json_is_strict_and_says_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*CHECK, "--json"]) == 0
    record = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    rod = fr.Rod.nitinol()
    result = rod.stability(fr.AxialLoad(0.2 * rod.critical_force, 0.2 * rod.critical_force, 150.0))
    assert record["status"] == "unstable"
    assert record["unstable_modes"] == [7]
    assert record["growth_rate_per_s"] == result.growth_rate
    assert len(record["modes"]) == record["modes_checked"] == result.modes_checked
    assert record["modes"][6]["interval"] == "tongue 1"


def test_infinities_are_null(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["check", "--rod", "nitinol", "--mean", "1.2Fcr", "--amplitude", "0", "--frequency", "24Hz", "--json"]
    assert cli.main(arguments) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["damping_to_stabilise_per_s"] is None
    assert record["frequency_rad_per_s"] == pytest.approx(150.796, abs=1e-3)


def test_options_reach_the_library(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*CHECK, "--no-margins", "--damping-rate", "5"]) == 0
    assert capsys.readouterr().out.startswith("STABLE")
    assert cli.main([*CHECK, "--no-margins", "--growth-tolerance", "5"]) == 0
    assert capsys.readouterr().out.startswith("STABLE")
    assert cli.main([*CHECK, "--no-margins", "--modes", "1-3,8"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("STABLE")
    assert "the 4 modes requested" in out
    assert cli.main([*CHECK, "--no-margins", "--modes", "7,6-7,7"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("UNSTABLE: mode 7 grows, tenfold in 0.544 s\n")
    assert "the 2 modes requested" in out


@pytest.mark.parametrize("mean", ["-0.2Fcr", "-1e-1", "-.5", "-2"])
def test_a_pull_may_follow_its_option(mean: str, capsys: pytest.CaptureFixture[str]) -> None:
    start = ["check", "--rod", "nitinol", "--amplitude", "0", "--frequency", "24Hz", "--no-margins", "--json"]
    answers = []
    for arguments in ([*start, "--mean", mean], [*start, f"--mean={mean}"]):
        assert cli.main(arguments) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert answers[0] == answers[1]
    assert answers[0]["mean_N"] < 0.0


def test_a_rod_from_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    rod = fr.Rod.from_toml(ROOT / "floquetrod/examples/my_rod.toml")
    assert rod == fr.Rod(200e9, 7850.0, 1.5e-3, 6.0, 12e-3, damping_rate=0.05)
    assert cli.main(["check", "--rod", str(ROOT / "floquetrod/examples/my_rod.toml"), *LOAD]) == 0
    assert f"critical force {rod.critical_force:.4g} N (of a long rod)" in capsys.readouterr().out


def test_a_warning_is_one_line_beside_the_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "--rod", "nitinol", "--mean", "1", "--amplitude", "0.1", "--frequency", "400Hz"]) == 0
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert captured.err.startswith(
        "floquetrod: warning: at 2513.27 rad/s (400 Hz) the rod is 0.38 axial wavelengths long"
    )
    assert captured.out


def test_examples_in_the_help_can_be_typed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    commands = re.findall(r"^    ([\w-]+)", capsys.readouterr().out, re.MULTILINE)
    assert len(commands) > 5
    every = parser()
    for command in commands:
        with pytest.raises(SystemExit):
            cli.main([command, "--help-all"])
        shown = re.sub(r"\\\n *", "", capsys.readouterr().out)  # as a shell joins lines
        examples = re.findall(r"^  floquetrod (.*)$", shown, re.MULTILINE)
        assert examples, command
        for example in examples:
            assert every.parse_args(shlex.split(example)).command in (command, "example")


@pytest.mark.parametrize(("text", "ends"), [("28:30Hz", (28.0, 30.0)), ("28Hz:1800rpm", (1680.0, 1800.0))])
def test_a_range_has_one_unit_and_is_answered_in_it(
    text: str, ends: tuple[float, float], capsys: pytest.CaptureFixture[str]
) -> None:
    rest = ["--rod", "nitinol", "--mean", "0.2Fcr", "--amplitude", "0.2Fcr"]
    assert cli.main(["ranges", *rest, "--frequency", text]) == 0
    lines = capsys.readouterr().out.splitlines()
    unit = "Hz" if text.endswith("Hz") else "rpm"
    assert lines[2].startswith(f"searched  frequency from {ends[0]:g} to {ends[1]:g} {unit}; modes 1 to ")
    safe = [float(number) for number in re.findall(r"[\d.]+", lines[0].partition(", except for")[0])]
    assert ends[0] <= min(safe) < max(safe) <= ends[1]
    assert lines[0].startswith("safe: ")
    assert f" {unit}" in lines[0]


KICK = [
    *("check", "--rod", "nitinol", "--mean", "0.825Fcr", "--amplitude", "0.7Fcr", "--frequency", "150"),
    *("--friction", "0.1"),
]


def test_a_bound_of_zero_is_said_to_prove_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.825 * rod.critical_force, 0.7 * rod.critical_force, 150.0)
    result = rod.stability(load, friction=0.1, kick=0.05)
    monkeypatch.setattr(fr.results.FrictionalRodStability, "critical_kick", fr.rod.CriticalKick(0.03, 9, 0.0))
    assert "proved    nothing for any kick, however small" in str(result.report())


@pytest.mark.slow
def test_check_with_friction(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*KICK, "--kick", "50mm/s"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("UNSTABLE: the kick of 50 mm/s destabilises modes 9, 10\n")
    assert "needed    32.1184 mm/s is the smallest found to buckle the rod, into mode 9" in out
    assert "proved    no kick up to 27.8299 mm/s buckles the rod" in out
    assert "without friction:\nUNSTABLE: modes 8, 9, 10, 12 grow" in out
    assert cli.main([*KICK, "--no-margins", "--kick", "30mm/s", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["with_friction"]["status"] == "stable"
    assert record["with_friction"]["critical_mode"] == 9
    assert record["without_friction"]["status"] == "unstable"
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.825 * rod.critical_force, 0.7 * rod.critical_force, 150.0)
    needed = rod.critical_kick(load, friction=0.1)
    assert record["with_friction"]["critical_kick_m_per_s"] == needed.kick
    assert record["with_friction"]["no_kick_buckles_up_to_m_per_s"] == needed.none_up_to
    assert cli.main([*KICK, "--no-margins", "--kick", "50mm/s", "--mean", "0.34Fcr", "--amplitude", "0"]) == 0
    assert "no mode grows even without friction" in capsys.readouterr().out


def test_map_with_friction(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "kick.npz"
    load = ["--mean", "0:1.1Fcr", "--amplitude", "0.7Fcr", "--frequency", "100:200", "--points", "4x3"]
    assert cli.main(["map", "--rod", "nitinol", *load, "--mu", "0.1", "--kick", "50mm/s", "--out", str(path)]) == 0
    assert "amplitude 0.7 Fcr, critical force 1.69603 N, friction 0.1, kick 50 mm/s" in capsys.readouterr().out
    chart = fr.Chart.load(path)
    rod = fr.Rod.nitinol()
    for row, mean in enumerate(chart.y.values):
        for column, omega in enumerate(chart.x.values):
            verdict = rod.stability(fr.AxialLoad(mean, 0.7 * rod.critical_force, omega), friction=0.1, kick=0.05)
            assert chart.stable[row, column] == verdict.stable


def test_compare(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["compare", "--alpha", "0.5", "--beta", "-0.25"]) == 0
    text = capsys.readouterr().out
    assert "all methods agree" in text
    assert cli.main(["compare", "--alpha", "0.5", "--beta", "-0.25", "--waveform", "square", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["agree"]
    assert record["verdict"].startswith(record["status"].upper())
    names = [row["method"] for row in record["methods"]]
    assert names == [method.name for method in applicable(fr.Meissner(0.5, -0.25))]
    assert {"monodromy", "square_wave", "leapfrog", "reference"} <= set(names)


FORMS: dict[tuple[str, str], Any] = {
    ("a", "q"): fr.Mathieu.from_aq,
    ("alpha", "beta"): fr.Mathieu,
    ("delta", "epsilon"): fr.Mathieu.from_delta_epsilon,
}


@pytest.mark.slow
@pytest.mark.parametrize("names", FORMS)
@pytest.mark.parametrize("seed", range(depth(10, 2)))
def test_compare_takes_every_form_of_mathieus_equation(
    names: tuple[str, str], seed: int, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng([55, seed])
    numbers = dict(zip(names, rng.uniform(-1.5, 1.5, 2).round(4).tolist(), strict=True)) | {"damping": 0.05}
    words = [word for name, value in numbers.items() for word in (f"--{name}", str(value))]
    equation = FORMS[names](**numbers)
    assert cli.main(["compare", *words, "--json"]) == 0
    methods = {row["method"]: row for row in json.loads(capsys.readouterr().out)["methods"]}
    verdict = fr.stability(equation, method="monodromy")
    assert methods["monodromy"]["status"] == verdict.status
    assert methods["monodromy"][f"growth_rate_per_{verdict.unit}"] == verdict.growth_rate
    assert methods["monodromy"][f"decay_rate_per_{verdict.unit}"] == verdict.decay_rate
    assert cli.main(["compare", *words]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(verdict.status.upper())
    assert f"\n\nequation  {equation!r}\n          {equation._formula}\n\n" in printed


def test_compare_begins_with_the_verdict_and_what_changes_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["compare", "--a", "1.2", "--q", "0.9", "--damping", "0.1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == (
        "UNSTABLE: grows at 0.280198 per unit z, tenfold in 8.218 z; stable with a damping above 0.410143 per unit z, "
        "0.310143 more; changes with a at 1.76362 (0.5636 higher) and at 0.0336536 (1.166 lower), in steps of 0.047; "
        "changes with q at 0.29116 (0.6088 lower), none higher up to 3.6, in steps of 0.042"
    )
    assert sum(line.startswith("square_wave (another equation)") for line in lines) == 1
    assert lines[-1] == "all methods agree; square_wave solves another equation"
    assert cli.main(["compare", "--a", "1", "--q", "0"]) == 0
    assert "on a boundary: changes with q as soon as its magnitude differs from 0\n" in capsys.readouterr().out
    assert cli.main(["compare", "--a", "-3", "--q", "-1.5"]) == 0
    head = capsys.readouterr().out.partition("\n")[0]
    assert "strong damping does not stabilise it" in head
    assert head.endswith(
        "changes with -q at 3.11805 (1.618 higher), none lower down to 0, in steps of 0.07; "
        "changes with a at -0.936818 (2.063 higher), none lower down to -6"
    )
    assert cli.main(["compare", "--a", "5", "--q", "0.1", "--damping", "0.01"]) == 0
    head = capsys.readouterr().out.partition("\n")[0]
    assert "; stable without damping; " in head


@pytest.mark.parametrize("forcing", [0.9, -0.9])
@pytest.mark.parametrize(
    ("family", "name"), [(partial(fr.Mathieu.from_aq, 1.2), "q"), (lambda q, c: fr.Mathieu(q, -0.3, c), "alpha")]
)
def test_numbers_in_the_verdict_of_compare_change_it(family: Any, name: str, forcing: float) -> None:
    text = str(fr.compare(family(forcing, 0.1)).report()).partition("\n")[0]
    needed = float(re.search(r"a damping above (\S+) per", text)[1])  # type: ignore[index]
    assert [fr.stability(family(forcing, needed + d)).stable for d in (-1e-4, 1e-4)] == [False, True]
    sign, edge = re.search(rf"changes with (-?){name} at (\S+)", text).groups()  # type: ignore[union-attr]
    assert (sign == "-") == (forcing < 0.0)
    sides = [fr.stability(family(math.copysign(float(edge) + d, forcing), 0.1)).stable for d in (-1e-4, 1e-4)]
    assert sorted(sides) == [False, True]


def test_an_equation_is_written_with_its_numbers() -> None:
    written = {
        fr.Mathieu.from_aq(1.2, 0.9): "y'' + (1.2 - 1.8 cos 2z) y = 0",
        fr.Mathieu.from_aq(-0.2, -0.7, 0.05): "y'' + 0.1 y' + (-0.2 + 1.4 cos 2z) y = 0",
        fr.Mathieu(0.5, -0.25): "A'' = (-0.25 + 0.5 sin tau) A",
        fr.Meissner(-0.5, 0.25, 0.1): "A'' + 0.2 A' = (0.25 - 0.5 sign(sin tau)) A",
        fr.Hill(-0.3, cosines=(0.1,)): "",
    }
    for equation, formula in written.items():
        report = str(fr.stability(equation).report())
        assert f"equation  {equation!r}\n" + (f"          {formula}\n" if formula else "") in report
    decays = fr.stability(fr.Mathieu.from_aq(0.2, 0.3, 0.05))
    lines = dict(decays.report().lines)
    assert lines["decay"] == f"{decays.decay_rate:.6g} per unit z, the slowest motion"
    one, other = decays.exponents
    assert lines["exponent"].startswith(f"{one.real:.6g} {one.imag:+.6g}i and {other.real:.6g} {other.imag:+.6g}i per ")
    assert "growth" not in lines


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "command is missing; name one, such as floquetrod check"),
        (["check", *LOAD], "one of the arguments --system --rod is required"),
        (["check", "--rod", "nitinol", *LOAD[2:]], "--mean is the constant push, 0 for a rod only shaken"),
        (["frobnicate"], "command must be one of check, .*, got 'frobnicate'"),
        (["check", "--rod", "nitinol", *LOAD, "--json=1"], "ignored explicit argument"),
        (["check", "--rod", "no.toml", *LOAD], "got 'no.toml': there is no such file"),
        ([*CHECK[:-1], "0"], "--frequency must be greater than zero, got '0'"),
        ([*CHECK[:-1], "24Hx"], "--frequency must be a number with a frequency unit"),
        ([*CHECK, "--modes", "a"], "--modes must be like 1-25"),
        ([*CHECK, "--modes", "0"], "--modes must count upwards between 1 and 20000, got '0'"),
        ([*CHECK, "--modes", "3,5-3"], "--modes must count upwards between 1 and 20000, got '5-3'"),
        ([*CHECK, "--modes", "1-999999999"], "--modes must count upwards between 1 and 20000"),
        ([*CHECK, "--modes", "1-99999999999999999999"], "--modes must be like 1-25"),
        ([*CHECK, "--modes", "-3"], "--modes must be like 1-25"),
        ([*CHECK, "--kick", "50mm/s"], "--kick needs --friction"),
        ([*CHECK, "--mu", "0.1"], "--friction needs --kick, got .* add .* such as --kick 50mm/s"),
        ([*CHECK, "--mu", "-0.1", "--kick", "1mm/s"], "--friction must be zero or more"),
        ([*CHECK, "--mu", "nan", "--kick", "1mm/s"], "--friction/--mu must be a number"),
        ([*CHECK, "--mu", "0.1", "--kick", "-50mm/s"], "--kick must be greater than zero, got '-50mm/s'"),
        ([*CHECK, "--mu", "0.1", "--kick", "0"], "--kick must be greater than zero, got '0'"),
        ([*CHECK, "--mu", "0.1", "--kick", "50mph"], "unit 'mph' is not understood"),
        ([*CHECK, "--json", "-5"], "ignored explicit argument"),
        ([*CHECK[:-1], "1e-300"], "--frequency must lie between 1e-09 and 1e\\+12 rad/s, got '1e-300'"),
        ([*CHECK, "--damping-rate", "-1"], "--damping-rate must be zero or more, got -1.0; give the decay rate in 1/s"),
        (["compare", "--alpha", "x", "--beta", "0"], "--alpha must be a number such as 0.5, got 'x'"),
        (["compare", "--alpha=--", "--beta", "0"], "--alpha needs a value, got '--'"),
        (["compare", "--alpha", "nan", "--beta", "0"], "--alpha must be finite"),
        (
            ["compare", "--a", "1"],
            "--q is required with --a",
        ),
        (["compare", "--a", "1", "--beta", "2"], "or --delta and --epsilon, got --a and --beta"),
        (["compare"], "or --delta and --epsilon, got none of them"),
        (["compare", "--a", "1", "--q", "1e30"], r"--q must lie between -2e\+09 and 2e\+09, got 1e\+30"),
        (
            ["compare", "--a", "1", "--q", "1", "--waveform", "square"],
            "--waveform square needs --alpha and --beta, got",
        ),
        (
            ["check", "--rod", "nitinol", "--damping-ratio", "1%", *LOAD],
            "give --damping-rate in 1/s, the ratio times the",
        ),
        (
            ["check", "--rod", "nitinol", "--damping-rate", "1%", *LOAD],
            "a ratio of critical damping is a rate only times",
        ),
    ],
)
def test_errors_are_one_line_and_status_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("floquetrod: error: ")
    assert re.search(message, captured.err)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("length = ", "cannot be read"),
        ("{sheet}\nradius = 1" + 400 * "0", "radius must be finite"),
        ("length = 3.0", "missing key 'youngs_modulus'"),
        ("bore = 1", "unknown key 'bore'"),
        ('{sheet}\nradius = "0.8 kg"', "radius must be a number with a length unit"),
        ("{sheet}\nradius = -1", "radius must be greater than zero"),
        ("{sheet}\nradius = [1]", "radius must be a number with a length unit"),
        ("{sheet}\nradius = 0.1", "half of channel_diameter"),
    ],
)
def test_bad_rod_files(text: str, message: str, tmp_path: Path) -> None:
    sheet = "youngs_modulus = 68e9\ndensity = 6500\nlength = 3.1\nchannel_radius = 4.7e-3"
    path = tmp_path / "rod.toml"
    path.write_text(text.format(sheet=sheet), encoding="utf-8")
    with pytest.raises(ValueError, match=message) as caught:
        fr.Rod.from_toml(path)
    assert str(path) in str(caught.value)


def test_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["--help"], ["check", "--help"], ["compare", "--help"]):
        with pytest.raises(SystemExit) as stop:
            cli.main(arguments)
        assert stop.value.code == 0
        text = capsys.readouterr().out
        assert "floquetrod check --rod nitinol" in text or "floquetrod compare --alpha" in text


def test_control_c(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fr.Rod, "stability", interrupt)
    assert cli.main(CHECK) == 130
    assert capsys.readouterr().err == "floquetrod: interrupted\n"


def python(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a new interpreter."""
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, cwd=ROOT, check=False)


@pytest.mark.slow
def test_a_reader_that_stops_early_is_no_error() -> None:
    run = subprocess.Popen(
        [sys.executable, "-m", "floquetrod", *CHECK, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT
    )
    assert run.stdout is not None
    run.stdout.close()
    assert run.stderr is not None
    assert run.stderr.read() == b""
    run.stderr.close()
    assert run.wait() == 0


@pytest.mark.slow
def test_a_cold_verdict_loads_no_compiler() -> None:
    code = "import sys, floquetrod as fr; rod = fr.Rod.nitinol(); load = fr.AxialLoad(0.34, 0.34, 150.0)"
    run = python("-c", f"{code}; print(rod.stability(load).status, *sys.modules)")
    assert run.stdout.startswith("unstable")
    assert not {"numba", "scipy", "mpmath", "sympy", "matplotlib"} & set(run.stdout.split())
    assert python("-m", "floquetrod", *CHECK[:-1]).returncode == 2


LONG = (
    "ensemble_phase_diagram", "ensemble_probability", "helical_buckling", "real_lengths", "simulation_tubing",
    "systems_coupled", "uncertainty", "vibration_and_drag", "real_guidewire", "real_inclined", "thin_tongues",
    "friction", "real_clamped", "systems_ground", "orbit_duffing", "orbit_van_der_pol", "orbit_period_doubling",
    "well_bends", "systems_noise", "milling_lobes", "milling_variable_pitch", "systems_damping", "systems_beam",
    "force_record", "my_rod", "tapered_string",
    "simulation", "rod_backbone", "simulation_stepped_load", "rod_not_straight", "systems_bands",
)  # fmt: skip
"""Examples of many runs or verdicts, which `make slow` and `make docs` run."""


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.name, marks=[pytest.mark.slow] * (path.stem in LONG))
        for path in sorted((ROOT / "examples").glob("*.py"))
    ],
)
def test_examples_run(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path)])
    monkeypatch.setattr(pyplot, "show", lambda: None)  # no window, with a display either
    pyplot.close("all")  # of other tests
    try:
        runpy.run_path(str(path))
    finally:
        pyplot.close("all")
    captured = capsys.readouterr()
    assert captured.out
    assert captured.err == ""


@pytest.mark.slow
def test_the_critical_force_needs_no_number_before_it(capsys: pytest.CaptureFixture[str]) -> None:
    answers = []
    for ends in ("0.5:1Fcr", "0.5:Fcr"):
        arguments = ["ranges", "--rod", "nitinol", "--amplitude", "0.2Fcr", "--frequency", "150", "--mean", ends]
        assert cli.main(arguments) == 0
        answers.append(capsys.readouterr().out)
    assert answers[0] == answers[1]


def test_ranges(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["ranges", "--rod", "nitinol", "--amplitude", "0.2Fcr", "--frequency", "150", "--mean", "0:1.5Fcr"]
    assert cli.main([*arguments, "--growth-tolerance", "0.01"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("safe: 0 to 0.0744 Fcr, 0.275 to ")
    assert cli.main([*arguments, "--growth-tolerance", "0.01", "--full"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^ +0 to 0\.07440\d+ +stable +end of the search \.\.\. mode 7, tongue 1$", text, re.MULTILINE)
    assert cli.main([*arguments, "--growth-tolerance", "0.01", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["stable"][0]["high_end"] == [7, 1]
    assert record["stable"][0]["high_N"] == pytest.approx(0.126187679, abs=1e-9)
    assert len(record["unstable"]) == len(record["stable"]) == 5
    assert record["unstable"][0]["low_N"] == record["stable"][0]["high_N"]
    assert record["unstable"][0]["cause"] == [7, 1]
    assert {band["status"] for band in record["unstable"]} == {"unstable"}
    for name in ("worst_growth_rate_per_s", "required_damping_rate_per_s"):
        assert record["unstable"][0][name] == pytest.approx(4.351, abs=1e-3)
    assert record["unstable"][-1]["required_damping_rate_per_s"] is None
    for change, message in (
        ({"--mean": "0.1Fcr"}, "exactly one of --mean, --amplitude, --frequency must be a range"),
        ({"--mean": "1:0.1"}, "--mean must be a range whose first end is the lower one"),
        ({"--mean": "0:x"}, "--mean must be a number with a force unit"),
    ):
        wrong = [change.get(arguments[i - 1], text) for i, text in enumerate(arguments)]
        assert cli.main(wrong) == 2
        assert message in capsys.readouterr().err


MAP = ["map", "--rod", "nitinol", "--amplitude", "0.2Fcr", "--mean", "0:1.1Fcr", "--frequency", "20:200"]


def test_map(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    out = [str(tmp_path / name) for name in ("map.png", "map.npz")]
    arguments = [*MAP, "--points", "12x9", "--growth", "--mark", "0.2Fcr,150", "--out", out[0], "--out", out[1]]
    assert cli.main(arguments) == 0
    assert "written: " in capsys.readouterr().out
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    assert fr.Chart.load(out[1]).stable.shape == (9, 12)
    for wrong, message in (
        (["--out", "map.doc"], "--out must end in .png"),
        (["--out", str(tmp_path / "no" / "map.png")], "there is no folder"),
        (["--out", out[0], "--points", "9"], "--points must be columns x rows such as 400x300"),
        (["--out", out[0], "--mark", "1"], "--mark must be two quantities"),
        (["--out", out[0], "--frequency", "150"], "two of --mean, --amplitude, --frequency must be ranges"),
    ):
        assert cli.main([*MAP, *wrong]) == 2
        assert message in capsys.readouterr().err


STEADY = ["--mean", "0.34Fcr", "--amplitude", "0.2Fcr", "--frequency", "24.5Hz", "--damping-rate", "1"]


@pytest.mark.parametrize(
    ("load", "status", "code"), [(LOAD, "unstable", 1), (STEADY, "stable", 0), (["--undecided"], "undecided", 3)]
)
def test_the_exit_code_is_the_verdict_for_those_who_ask(
    load: list[str], status: str, code: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if status == "undecided":
        judge, load = fr.Rod.stability, LOAD
        monkeypatch.setattr(fr.Rod, "stability", lambda *a, **k: replace(judge(*a, **k), status="undecided"))
    for arguments, expected in (([], 0), (["--exit-code"], code), (["--exit-code", "--json"], code)):
        assert cli.main(["check", "--rod", "nitinol", "--no-margins", *load, *arguments]) == expected
    assert f'"status": "{status}"' in capsys.readouterr().out
    assert cli.main(["check", "--rod", "nitinol", *load, "--exit-code", "--modes", "x"]) == 2


def test_the_exit_code_with_friction_is_that_of_the_headline(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*KICK, "--no-margins", "--kick", "30mm/s", "--exit-code"]) == 0
    assert capsys.readouterr().out.startswith("STABLE")
    assert cli.main([*KICK, "--no-margins", "--kick", "50mm/s", "--exit-code"]) == 1
    assert capsys.readouterr().out.startswith("UNSTABLE")


def test_margins_are_those_of_the_library(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*CHECK, "--json", "--unit", "Hz"]) == 0
    record = json.loads(capsys.readouterr().out)
    rod = fr.Rod.nitinol()
    result = rod.stability(fr.AxialLoad(0.2 * rod.critical_force, 0.2 * rod.critical_force, 150.0))
    for name, unit in (("mean_force", "N"), ("amplitude", "N"), ("frequency", "rad_per_s")):
        margin = getattr(result, f"{name}_margin")
        for side in ("below", "above"):
            value = getattr(margin, side)
            assert record[f"{name}_margin_{side}_{unit}"] == (value if value < float("inf") else None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("units", "lines"),
    [
        ("Hz", ["23.8732 Hz (150 rad/s)", "stable 1.805 Hz lower or 1.008 Hz higher", "mean 0.2 Fcr (0.3392 N)"]),
        ("N,rpm", ["mean 0.339206 N (0.2 Fcr)", "stable 0.213 N lower", "1432.39 rpm (150 rad/s)"]),
        ("lbf", ["mean 0.0762565 lbf (0.2 Fcr)", "150 rad/s (23.87 Hz)"]),
    ],
)
def test_answers_are_in_the_units_asked_for(units: str, lines: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*CHECK, "--unit", units]) == 0
    out = capsys.readouterr().out
    assert [line for line in lines if line not in out] == []


@pytest.mark.slow
def test_kicks_are_answered_in_the_unit_of_the_kick(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*KICK, "--kick", "0.05m/s"]) == 0
    out = capsys.readouterr().out
    assert "0.0321184 m/s is the smallest found to buckle the rod" in out
    assert "kick needed m/s" in out
    assert "mm/s" not in out
    assert cli.main([*KICK, "--no-margins", "--kick", "0.05m/s", "--unit", "cm/s"]) == 0
    assert "3.21184 cm/s is the smallest found to buckle the rod" in capsys.readouterr().out


def test_a_map_speaks_the_units_of_its_ranges(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], saved: list[Any]
) -> None:
    load = ["--mean", "0:1.1Fcr", "--amplitude", "0.3N", "--frequency", "5:30Hz", "--mark", "0.5Fcr,10Hz"]
    out = ["--out", str(tmp_path / "map.png"), "--out", str(tmp_path / "map.npz")]
    for extra, right, top, unit in (([], 30.0, 1.1, "Hz"), (["--unit", "rpm,N"], 1800.0, 1.1 * 1.696030137, "rpm")):
        assert cli.main(["map", "--rod", "nitinol", *load, "--points", "6x5", "--pixels", *out, *extra]) == 0
        axes = saved.pop()
        assert axes.collections[0].get_coordinates()[-1, -1].tolist() == pytest.approx([right * 13 / 12, top * 9 / 8])
        assert axes.get_xlabel().endswith(f" / {unit}")
        (mark,) = axes.lines
        assert mark.get_xydata()[0].tolist() == pytest.approx([right / 3.0, top * 0.5 / 1.1])
        assert "amplitude 0.3 N" in axes.get_title().replace("\n", " ")
        assert "amplitude 0.3 N" in capsys.readouterr().out
    chart = fr.Chart.load(tmp_path / "map.npz")  # the numbers stay in SI units
    assert chart.x.unit == "rad/s"
    assert chart.x.values[-1] == pytest.approx(188.4956, abs=1e-4)


# What nobody means, in place of one word of a command: what the one line of the answer must hold.
JUNK = [
    *((name, text) for name in ("--mean", "--amplitude", "--frequency") for text in ("1e400N", "nanHz", "", "5 5Hz")),
    *((name, text) for name in ("--mean", "--amplitude", "--frequency") for text in ("inf", "1e309", "\u0663", "0x1F")),
    ("--mean", "1e13"),
    ("--mean", "1e11"),
    ("--amplitude", "-1N"),
    ("--amplitude", "1e400"),
    ("--frequency", "-5Hz"),
    ("--frequency", "0Fcr"),
    ("--frequency", "0Hz"),
    ("--frequency", "1e-400"),
    ("--frequency", "1e12Hz"),
    ("--damping-rate", "-1"),
    ("--damping-rate", "1Hz"),
    ("--growth-tolerance", "-1"),
    ("--growth-tolerance", "nan"),
    ("--unit", "parsec"),
    ("--unit", "Hz,rpm"),
    ("--unit", "kg/m3"),
    ("--rod", "no/such.toml"),
    ("--rod", "."),
    ("--rod", ""),
    ("--rod", 300 * "x"),
]
RANGES = [
    *(
        ("--frequency", text)
        for text in ("20:10Hz", "10:10Hz", "0:20Hz", "-5:5Hz", ":", "5:", "1:2:3", "nan:5", "1:1e400")
    ),
    *(("--mean", text) for text in ("1:0Fcr", "0:0", "0:1e400N", "0:1Hz")),
]
FILES = [
    *(("--out", text) for text in ("no/such/map.png", "map", "map.doc", ".", "folder.png", 300 * "x" + ".png")),
    *(("--points", text) for text in ("", "9", "1x9", "1e3x5", "-3x4", "\u00b2x\u00b2", "99999x99999", "3x3x3")),
    *(("--mark", text) for text in ("1", "1,2,3", "x,y", ",", "0.2Fcr,0Hz")),
]
MAP_LINE = {"--mean": "0:1Fcr", "--amplitude": "0.2Fcr", "--frequency": "5:30Hz", "--rod": "nitinol"}
RANGES_LINE = {"--mean": "0.2Fcr", "--amplitude": "0.2Fcr", "--frequency": "10:20Hz", "--rod": "nitinol"}


@pytest.mark.parametrize(
    ("command", "given", "option", "text"),
    [
        *(("check", {**RANGES_LINE, "--frequency": "20Hz"}, *junk) for junk in JUNK),
        *(
            ("ranges", RANGES_LINE, *junk)
            for junk in [*JUNK, *RANGES[:9]]
            if ":" in junk[1] or junk[0] != "--frequency"
        ),
        *(("ranges", {**RANGES_LINE, "--frequency": "20Hz"}, *junk) for junk in RANGES[9:]),
        *(("map", MAP_LINE, *junk) for junk in [*JUNK, *RANGES, *FILES] if ":" in junk[1] or junk[0] not in MAP_LINE),
        *(
            ("explore", {**RANGES_LINE, "--frequency": "20Hz"}, *junk)
            for junk in [*JUNK, *FILES[:6]]
            if "growth" not in junk[0]
        ),
    ],
)
def test_junk_is_one_line_that_names_option_and_value(
    command: str,
    given: dict[str, str],
    option: str,
    text: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    forbidden: Forbidden,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder.png").mkdir()
    forbidden(fr.Rod, "growth_rate")
    line = [command, *(f"{name}={value}" for name, value in {**given, option: text}.items())]
    assert cli.main(line) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(r"floquetrod: error: .+\n", captured.err)
    assert option in captured.err
    assert text[:40] in captured.err
    assert list(tmp_path.iterdir()) == [tmp_path / "folder.png"]


def test_a_word_while_a_question_takes_its_time(clock: list[float]) -> None:
    class Screen(io.StringIO):
        def isatty(self) -> bool:
            return True

    class Pauses(threading.Event):
        """The waits of a question that is left in its third: each of them ends when there is something to say."""

        def __init__(self) -> None:
            super().__init__()
            self.seconds: list[float | None] = []
            self.counted = threading.Event()

        def wait(self, timeout: float | None = None) -> bool:
            self.seconds.append(timeout)
            self.counted.wait()
            clock[0] += timeout or 0.0
            return len(self.seconds) == 3

    clock[0], screen, pauses = 100.0, Screen(), Pauses()
    progress = waiting.Waiting("searching", "points")
    progress._left = pauses
    with contextlib.redirect_stderr(screen), progress:
        progress(1000, 4000)
        pauses.counted.set()
    assert pauses.seconds == [waiting.FIRST, waiting.EVERY, waiting.EVERY]
    line = "searching: 0 s, 1,000 of 4,000 points (Ctrl-C ends it)"
    spoken = screen.getvalue().split("\r")
    assert spoken == [line, line.replace("0 s", "1 s"), " " * len(line), ""]  # and nothing is left of it
    assert not any("_speak" in thread.name for thread in threading.enumerate())


def test_no_word_in_a_file_for_the_first_seconds() -> None:
    silent = io.StringIO()
    with contextlib.redirect_stderr(silent), waiting.Waiting("searching"):
        pass
    assert silent.getvalue() == ""
    assert not any("_speak" in thread.name for thread in threading.enumerate())


def test_python_m_floquetrod(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["floquetrod", *CHECK])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("floquetrod", run_name="__main__")
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("UNSTABLE: mode 7 grows")


def test_lock_up_says_what_the_library_finds(capsys: pytest.CaptureFixture[str]) -> None:
    line = ["lock-up", "--rod", "nitinol", "--friction", "0.2", "--far-force", "0.5Fcr", "--push", "10N"]
    rod = fr.Rod.nitinol()
    found = rod.lock_up(0.2, 0.5 * rod.critical_force)
    assert cli.main(line) == 0
    text = capsys.readouterr().out
    assert text.startswith(repr(found)[1:-1])
    assert "10 N at the upper end pushes 62.12 m" in text
    assert cli.main([*line, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["length_m"], record["pushed_length_m"]) == (found.length, found.pushed_length(10.0))
    steep = ["lock-up", "--rod", "nitinol", "--friction", "0.1", "--inclination", "10deg", "--json"]
    assert cli.main(steep) == 0
    assert json.loads(capsys.readouterr().out)["length_m"] is None  # never


def test_an_inclination_replaces_that_of_the_rod(capsys: pytest.CaptureFixture[str]) -> None:
    line = [*CHECK, "--mean-at", "none", "--no-margins", "--json"]
    assert cli.main([*line, "--inclination", "70deg"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["rod"]["inclination"] == pytest.approx(math.radians(70.0))
    rod = fr.Rod.nitinol().replace(inclination="70deg")
    load = fr.AxialLoad(0.2 * rod.critical_force, 0.2 * rod.critical_force, 150.0, mean_at=None)
    assert record["growth_rate_per_s"] == rod.stability(load).growth_rate
