"""Slips of units and radii are suspected; plausible rods and loads are not."""

from __future__ import annotations

import math
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.cli.main import main
from tests.conftest import depth
from tests.inside import may_be_hertz, pipes, suspicions_of_load, suspicions_of_rod

NITINOL = {"youngs_modulus": 68e9, "density": 6500, "radius": 0.8e-3, "length": 3.1, "channel_radius": 4.7e-3}
TUBING = {"youngs_modulus": 207e9, "density": 7850, "diameter": 0.0508, "wall_thickness": 0.00396} | {
    "length": 60,
    "channel_diameter": 0.124,
}

SLIPS: list[tuple[dict[str, Any], str]] = [
    (NITINOL | {"length": 3100}, r"length = 3100 m .*mode 6144.*; .*length=\"3100mm\""),
    (NITINOL | {"radius": 0.8, "channel_radius": 4.7}, r"radius = 0.8 m .*1.6 m thick.*; .*radius=\"0.8mm\""),
    (NITINOL | {"radius": 0.8, "channel_radius": 4.7, "length": 3100}, r"radius = 0.8 m .*; .*radius=\"0.8mm\""),
    (NITINOL | {"channel_radius": 4.7}, r"channel_radius = 4.7 m .*; .*channel_radius=\"4.7mm\""),
    (NITINOL | {"radius": 0.7, "channel_radius": 4.7}, r"length = 3.1 m .*no slender rod; .*\"0.7mm\""),
    (NITINOL | {"youngs_modulus": 68}, r"youngs_modulus = 68 Pa .*; .*youngs_modulus=\"68GPa\""),
    (NITINOL | {"youngs_modulus": 68000}, r"youngs_modulus = 68000 Pa .*; .*youngs_modulus=\"68000MPa\""),
    (NITINOL | {"youngs_modulus": 30e6}, r"youngs_modulus = 3e\+07 Pa .*; .*psi\""),
    (TUBING | {"youngs_modulus": "207MPa"}, r"youngs_modulus = 2.07e\+08 Pa .*in GPa\? .*=\"207GPa\""),
    (TUBING | {"youngs_modulus": 29e6}, r"youngs_modulus = 2.9e\+07 Pa .*; .*=\"2.9e\+07psi\""),
    (TUBING | {"youngs_modulus": 207e3}, r"youngs_modulus = 207000 Pa .*; .*=\"207000MPa\""),
    (NITINOL | {"youngs_modulus": 68e12}, r"youngs_modulus = 6.8e\+13 Pa .*diamond; .*GPa"),
    (NITINOL | {"density": 6.5}, r"density = 6.5 kg/m\^3 .*; .*density=\"6.5g/cm3\""),
    (NITINOL | {"density": 6500e3}, r"density = 6.5e\+06 kg/m\^3 .*; a number is taken in kg/m\^3"),
    (NITINOL | {"gravity": 981}, r"gravity = 981 m/s\^2 looks like cm/s\^2; .*9.81"),
    (NITINOL | {"gravity": 32.2}, r"gravity = 32.2 m/s\^2 looks like ft/s\^2; .*9.81"),
    (
        TUBING | {"diameter": None, "radius": "2in", "wall_thickness": "0.156in"},
        r"radius = 0.0508 m is the diameter .*2.00x0.156 .*; give diameter=0.0508",
    ),
    (
        TUBING | {"diameter": None, "radius": 0.0508, "wall_thickness": None, "inner_radius": 0.042875},
        r"radius = 0.0508 m is the diameter .*2.00x0.156 .*; give diameter=0.0508",
    ),
]


@pytest.mark.parametrize(("parameters", "words"), SLIPS)
def test_slips_in_a_rod_are_suspected_once_and_where_they_are_made(parameters: dict[str, Any], words: str) -> None:
    with pytest.warns(fr.PlausibilityWarning, match=words) as heard:
        rod = fr.Rod(**parameters)
    assert len(heard) == 1
    assert heard[0].filename == __file__
    assert 'warnings.simplefilter("ignore", fr.PlausibilityWarning)' in str(heard[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert pickle.loads(pickle.dumps(rod)) == rod


WELL = fr.WellPath([0.0, 500.0, 950.0, 1500.0], ["0deg", "0deg", "90deg", "90deg"])


@pytest.mark.parametrize(
    "ask",
    [
        lambda rod: rod.lock_up(28),
        lambda rod: rod.mean_force(WELL, 28, depth=[0.0]),
        lambda rod: rod.mean_force(WELL, [(0.0, 0.2), ("1200m", 28)], depth=[0.0]),
        lambda rod: rod.stability(fr.AxialLoad(1.0, 0.5, "20Hz"), friction=28, kick=0.05),
    ],
)
def test_a_coefficient_of_friction_in_per_cent_is_suspected(ask: Callable[[fr.Rod], Any]) -> None:
    rod = fr.Rod.nitinol()
    with pytest.warns(fr.PlausibilityWarning, match=r"friction = 28 .*per cent.*friction=0\.28 \(") as heard:
        ask(rod)
    assert [each.filename for each in heard] == [__file__]


@pytest.mark.parametrize("friction", [0.0, 0.28, 1.5, 200.0, 28.1234567])
def test_other_coefficients_of_friction_are_not(friction: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fr.Rod.nitinol().lock_up(friction)


def test_the_terminal_tells_of_friction_in_per_cent(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lock-up", "--rod", "nitinol", "--friction", "28"]) == 0
    assert capsys.readouterr().err.rstrip().endswith("was it in per cent? It is a coefficient: --friction 0.28")


def test_silenced() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", fr.PlausibilityWarning)
        fr.Rod(**NITINOL | {"length": 3100})


def test_copies_that_the_package_makes_are_not_judged() -> None:
    with pytest.warns(fr.PlausibilityWarning):
        rod = fr.Rod(**NITINOL | {"density": 20})
    load = fr.AxialLoad(0.1 * rod.critical_force, 0.1 * rod.critical_force, 300.0)
    assert rod.stability(load).damping_to_stabilise >= 0.0


def test_replace_is_judged() -> None:
    with pytest.warns(fr.PlausibilityWarning, match="length = 3100 m"):
        fr.Rod.nitinol().replace(length=3100)


LOADS = [
    (fr.Rod.nitinol(), (300, 0.3, "24Hz"), r"mean = 300 N is 177 times .*; .*mean=\"300mN\""),
    (fr.Rod(**TUBING), (2, 1, "1Hz"), r"mean = 2 N and amplitude = 1 N .*; .*mean=\"2kN\", amplitude=\"1kN\""),
    (fr.Rod.nitinol(), (0.34, 0.34, 24), r"frequency = 24 rad/s .*AxialLoad.hertz.*frequency=\"24Hz\""),
]


@pytest.mark.parametrize(("rod", "numbers", "words"), LOADS)
def test_slips_in_a_load_are_suspected(rod: fr.Rod, numbers: tuple[Any, ...], words: str) -> None:
    with pytest.warns(fr.PlausibilityWarning, match=words) as heard:
        rod.stability(fr.AxialLoad(*numbers))
    assert [each.filename for each in heard] == [__file__]


def test_a_frequency_in_rad_per_s_is_suspected_only_where_it_matters() -> None:
    rod = fr.Rod.nitinol()
    weak, strong = fr.AxialLoad(0.34, 1e-9, 24), fr.AxialLoad(0.34, 0.34, 24)
    assert may_be_hertz(rod, weak)
    assert rod.replace(damping_rate=1.0).stability(weak).stable  # in Hz it would be, too: no warning
    assert not may_be_hertz(rod, fr.AxialLoad.hertz(0.34, 0.34, 24))
    assert not may_be_hertz(rod, strong.varied("mean", 2.0 * rod.critical_force))


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return where the frequencies are gathered at which arrays of verdicts are asked for."""
    frequencies: list[float] = []
    verdicts = fr.Rod.verdicts

    def gathering(rod: fr.Rod, *load: Any, frequency: Any, **options: Any) -> Any:
        frequencies.extend(np.ravel(frequency).tolist())
        return verdicts(rod, *load, frequency=frequency, **options)

    monkeypatch.setattr(fr.Rod, "verdicts", gathering)
    return frequencies


def test_a_load_is_not_judged_again_for_the_warning(judged: list[float], capsys: pytest.CaptureFixture[str]) -> None:
    rod = fr.Rod.nitinol()
    in_hertz = 2.0 * math.pi * 24
    with pytest.warns(fr.PlausibilityWarning, match="frequency = 24 rad/s"):
        rod.stability(fr.AxialLoad(0.34, 0.34, 24))
    assert judged == [in_hertz]
    rod.stability(fr.AxialLoad(0.34, 0.34, 24.0001))
    rod.stability(fr.AxialLoad(0.34, 0.34, 150.0))
    check = ["check", "--rod", "nitinol", "--mean", "0.34", "--no-margins", "--amplitude"]
    assert main([*check, "0.34", "--frequency", "24rad/s"]) == 0
    assert main([*check, "0", "--frequency", "24"]) == 0
    assert judged == [in_hertz] * 2  # by the verdict of the terminal at 24 rad/s, which does not know what was typed
    assert "taken in rad/s" not in capsys.readouterr().err
    assert main([*check, "0.34", "--frequency", "24"]) == 0
    assert "taken in rad/s" in capsys.readouterr().err
    assert set(judged) == {in_hertz}


SIZES = sorted({(pipe.diameter, pipe.wall_thickness) for pipe in pipes() if pipe.wall_thickness})


@st.composite
def plausible_rods(draw: st.DrawFn) -> fr.Rod:
    """Rods as they are built and simulated."""
    kind = draw(st.sampled_from(["lab", "steel", "pipe", "fibre"]))
    inclination = draw(st.sampled_from([math.pi / 2, 1.0, 0.3]))
    if kind == "pipe":
        diameter, wall = draw(st.sampled_from(SIZES))
        fluid = draw(st.sampled_from([0.0, 1.2, 1000.0, 1800.0]))
        return fr.Rod(
            207e9,
            7850.0,
            diameter=diameter,
            wall_thickness=wall,
            length=draw(st.sampled_from([10.0, 60, 500, 5000])),
            channel_diameter=diameter * draw(st.floats(1.1, 8.0)),
            fluid_inside=fluid,
            fluid_outside=fluid,
            inclination=inclination,
        )
    if kind == "fibre":
        radius, modulus, density, length = 62.5e-6, 72e9, 2200.0, draw(st.sampled_from([0.1, 1.0, 10.0]))
    elif kind == "lab":
        modulus, density = draw(st.sampled_from([(68e9, 6500.0), (3e9, 1200.0), (70e9, 2700.0), (5e6, 1100.0)]))
        radius, length = draw(st.sampled_from([0.0005, 0.0008, 0.003])), draw(st.sampled_from([0.3, 1, 3.1, 31]))
    else:
        modulus, density = draw(st.sampled_from([(200e9, 7850.0), (210e9, 7800.0), (110e9, 8900.0), (400e9, 19300.0)]))
        radius, length = draw(st.sampled_from([0.001, 0.01, 0.05])), draw(st.sampled_from([0.5, 5, 100]))
    hole = radius * draw(st.floats(1.05, 40.0))
    return fr.Rod(modulus, density, radius, length, hole, inclination=inclination)


@given(rod=plausible_rods(), mean=st.floats(-3.0, 3.0), amplitude=st.floats(0.0, 5.0), hertz=st.floats(0.1, 200.0))
@settings(deadline=None, max_examples=depth(300, 75))
def test_plausible_rods_and_loads_raise_no_suspicion(rod: fr.Rod, mean: float, amplitude: float, hertz: float) -> None:
    assert not list(suspicions_of_rod(rod))
    load = fr.AxialLoad.hertz(mean * rod.critical_force, amplitude * rod.critical_force, round(hertz, 1))
    assert not list(suspicions_of_load(rod, load))
    assert not may_be_hertz(rod, load)


def test_the_terminal_tells_it_in_a_line(capsys: pytest.CaptureFixture[str], tmp_path: Any) -> None:
    path = tmp_path / "rod.toml"
    lines = 'youngs_modulus = "68GPa"\ndensity = 6500\nradius = "0.8mm"\nlength = 3100\nchannel_radius = "4.7mm"\n'
    path.write_text(lines, encoding="utf-8")
    command = ["check", "--rod", str(path), "--mean", "0", "--amplitude", "0", "--frequency", "1", "--modes", "1-3"]
    assert main([*command, "--json"]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("{")
    warned = [line for line in told.err.splitlines() if "3100" in line]
    assert len(warned) == 1
    assert warned[0].startswith("floquetrod: warning: length = 3100 m")
    assert warned[0].endswith('length="3100mm"')


STRENGTH = ["--rod", "nitinol", "--mean", "0.3Fcr", "--amplitude", "0.2Fcr"]
OVER = ["--rod", "nitinol", "--mean", "0:0.3Fcr", "--amplitude", "0.2Fcr"]
PIXELS = ["--points", "3x3", "--pixels"]
AT_16 = "16 is taken in rad/s: at 16 rad/s no mode grows, at 16 Hz one does"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (["check", *STRENGTH, "--no-margins", "--frequency", "16"], f"--frequency {AT_16}; write 16rad/s or 16Hz"),
        (["check", *STRENGTH, "--no-margins", "--frequency", "15.0013"], "--frequency 15.0013 is taken"),
        (["check", *STRENGTH, "--no-margins", "--frequency", "107"], "at 107 rad/s a mode grows, at 107 Hz none does"),
        (["certify", *STRENGTH, "--frequency", "16"], f"--frequency {AT_16}; write 16rad/s or 16Hz"),
        (["certify", *STRENGTH, "--frequency", "15:16"], "; write 15:16rad/s or 15:16Hz"),
        pytest.param(
            ["ranges", *OVER, "--frequency", "16"],
            f"--frequency {AT_16}, under mean 0 N and amplitude 0.3392 N",
            marks=pytest.mark.slow,
        ),
        (["ranges", *STRENGTH, "--frequency", "10:16"], "--frequency 10:16 is taken"),
        pytest.param(
            ["map", *OVER, *PIXELS, "--frequency", "10:16"], "--frequency 10:16 is taken", marks=pytest.mark.slow
        ),
        pytest.param(
            ["map", *OVER, "--points", "3x3", "--pixels", "--frequency", "10:60Hz", "--mark", "0.5,16"],
            f"--mark frequency {AT_16}",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ["simulate", *STRENGTH, "--duration", "2ms", "--frequency", "16"],
            f"--frequency {AT_16}",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ["explore", *STRENGTH, "--out", "explorer.png", "--frequency", "16"],
            f"--frequency {AT_16}",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_bare_frequency_whose_hertz_change_the_verdict_is_told(
    line: list[str], words: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    assert main(line) == 0
    told = [each for each in capsys.readouterr().err.splitlines() if "taken in rad/s" in each]
    assert len(told) == 1
    assert told[0].startswith("floquetrod: warning: --")
    assert words in told[0]


@pytest.mark.parametrize(
    "frequency",
    ["16rad/s", "16Hz", "104", "152"],  # with a unit; unstable both ways; stable both ways
)
def test_no_word_about_hertz_where_it_is_said_or_does_not_matter(
    frequency: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", *STRENGTH, "--no-margins", "--frequency", frequency]) == 0
    assert capsys.readouterr().err == ""
