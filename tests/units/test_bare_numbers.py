"""Numbers that the trade reads otherwise than SI: told with both readings, or refused, and never taken in silence."""

from __future__ import annotations

import itertools
import json
import math
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli, units
from floquetrod.bare_numbers import Quantity, bare_numbers
from floquetrod.rod.reading import read_tool
from tests.conftest import depth

EXAMPLES = Path(__file__).parents[2] / "floquetrod/examples"
TOOL = (EXAMPLES / "tool.toml").read_text(encoding="utf-8")
WELL = ["--well", str(EXAMPLES / "survey.csv"), "--rod", str(EXAMPLES / "tubing.toml"), "--friction", "0.3"]


def said(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> tuple[str, str]:
    assert cli.main(list(words)) == status
    captured = capsys.readouterr()
    return captured.out, captured.err


@pytest.mark.slow
def test_spindle_speeds_are_in_rpm(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = str(EXAMPLES / "tool.toml")
    for rpm in np.random.default_rng(1).integers(4000, 25_000, depth(12, 1)).tolist():
        bare, with_unit = (said(capsys, "lobes", path, "--at", text) for text in (str(rpm), f"{rpm}rpm"))
        assert bare == with_unit
        assert re.search(f"at {rpm} rpm it (chatters|does not chatter at any depth tried)", bare[0])
        assert "tangential 600 N/mm2, radial 200 N/mm2; along x 922 Hz, 1.1 %, 0.03993 kg" in bare[0]
    by_hand = said(capsys, "lobes", path, "--at", f"{5000 * math.pi / 30!r}rad/s", "--json")[0]
    assert json.loads(by_hand)["critical_depth_m"] == pytest.approx(0.408628e-3, rel=1e-5)
    file = tmp_path / "tool.toml"
    answers = []
    for speed in ('"9000:9400"', '"9000rpm:9400rpm"'):
        file.write_text(re.sub('speed = ".*"', f"speed = {speed}", TOOL), encoding="utf-8")
        answers.append(said(capsys, "lobes", str(file), "--points", "3x3", "--out", str(tmp_path / "x.csv"))[0])
    assert answers[0] == answers[1]
    error = said(capsys, "lobes", path, "--depth", "0:4", "--out", str(tmp_path / "x.csv"), status=2)[1]
    assert "--depth must have a unit, got '4', which may be in m or in mm; write 4mm" in error


PARTS = {
    "tangential": '"600MPa"',
    "radial": '"200MPa"',
    "frequency": '"922Hz"',
    "mass": '"39.93g"',
    "depth": '"0mm:4mm"',
}
BARE = {"tangential": "600", "radial": "200", "frequency": "922", "mass": "39.93", "depth": '"0:4"'}
OTHERS = {"tangential": "MPa", "radial": "MPa", "frequency": "Hz", "mass": "g", "depth": "mm"}


@pytest.mark.parametrize("bare", [each for n in range(1, 5) for each in itertools.combinations(PARTS, n)])
def test_one_number_without_a_unit_in_a_tool_file_is_refused_with_both_readings(
    bare: tuple[str, ...], tmp_path: Path
) -> None:
    file, text = tmp_path / "tool.toml", TOOL
    for name in bare:
        text = text.replace(f"{name} = {PARTS[name]}", f"{name} = {BARE[name]}")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"must have a unit, as .* has: got") as caught:
        fr.Milling.from_toml(file)
    name = next(each for each in PARTS if f"{each} must" in str(caught.value))
    assert name in bare
    typed = BARE[name].strip('"').partition(":")[2] or BARE[name]
    other = {"MPa": "(MPa|N/mm2)"}.get(OTHERS[name], OTHERS[name])
    assert re.search(rf"write {typed}[a-zA-Z/]+ or {typed}{other}$", str(caught.value))


def test_a_tool_file_in_si_alone_is_read_and_warned_of_where_nothing_is_so_soft(tmp_path: Path) -> None:
    file = tmp_path / "tool.toml"
    si = {"tangential": "600e6", "radial": "200e6", "frequency": "5793.097", "mass": "0.03993", "depth": '"0:4"'}
    text = TOOL
    for name, value in si.items():
        text = text.replace(f"{name} = {PARTS[name]}", f"{name} = {value}")
    file.write_text(text, encoding="utf-8")
    assert fr.Milling.from_toml(file).tangential == 600e6
    file.write_text(text.replace("600e6", "600"), encoding="utf-8")
    with pytest.warns(fr.PlausibilityWarning, match=r'tangential = 600 Pa .* tangential="600N/mm2"'):
        fr.Milling.from_toml(file)


def test_a_vibration_tool_has_all_its_units_or_none() -> None:
    values = (("1000", "lbf", "N"), ("15", "Hz", "rad/s"), ("50", "ft", "m"))
    for kept in itertools.product((False, True), repeat=3):
        parts = [number + unit * has for (number, unit, _), has in zip(values, kept, strict=True)]
        text = "@".join(parts)
        if all(kept):
            assert read_tool(text, "--tool").frequency == pytest.approx(15 * 2 * math.pi)
            continue
        if not any(kept):
            told = r"--tool 1000@15@50 is taken in N and rad/s, that is, at 2.39 Hz; write 1000N@15rad/s or 1000N@15Hz"
            with pytest.warns(fr.PlausibilityWarning, match=told):
                assert read_tool(text, "--tool").frequency == 15.0
            continue
        i = kept.index(False)
        number, _, si = values[i]
        other = ("lbf|kN", "Hz", "ft")[i]
        with pytest.raises(ValueError, match=rf"--tool '{text}': .*write {number}{si} or {number}({other})$"):
            read_tool(text, "--tool")
    assert read_tool("5kN@18Hz@0", "--tool").above_end == 0.0


@pytest.mark.slow
def test_the_tool_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--tool", "1000lbf@15Hz@50ft", "--depths", "3000ft", "--unit", "ft,lbf"]
    out, err = said(capsys, "reach", *WELL, *words)
    assert "1000 lbf at 15 Hz, 50 ft above the lower end: the force vibrates by at most" in out
    assert "warning" not in err
    out, _ = said(capsys, "reach", *WELL, *words, "--push", "500")
    assert said(capsys, "reach", *WELL, *words, "--push", "500")[1].count("--push 500 is taken in N") == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "warned"),
    [
        ("--mean 3kN --amplitude 2 --frequency 4Hz", ["--amplitude 2 is taken in N,", "write 2N or 2kN"]),
        ("--mean 3kN --amplitude 2kN --frequency 4", ["--frequency 4 is taken in rad/s,", "write 4rad/s or 4Hz"]),
        ("--mean 3000 --amplitude 1kip --frequency 4Hz", ["--mean 3000 is taken in N,", "3000N or 3000kip"]),
        ("--mean 0.2Fcr --amplitude 0.2 --frequency 4Hz", ["--amplitude 0.2 is taken in N,", "0.2N or 0.2Fcr"]),
        ("--mean 3kN --amplitude 2kN --frequency 4Hz --inclination 1.2", ["1.2rad or 1.2deg"]),
        ("--mean 3kip --amplitude 2kip --frequency 4Hz --length 60", ["--length 60 is taken in m,", "60m or 60ft"]),
        ("--mean 3kN --amplitude 2kN --frequency 4Hz --unit lbf --length 60", ["60m or 60ft"]),
        (
            "--mean 3kN --amplitude 2kN --frequency 4Hz --fluid-inside 8.5 --fluid-outside 8.5ppg",
            ["8.5kg/m3 or 8.5ppg"],
        ),
        ("--mean 3kN --amplitude 2kN --frequency 4Hz --fluid-inside 1000 --fluid-outside 8.5ppg", []),
        ("--mean 3kN --amplitude 0 --frequency 4Hz", []),
        ("--mean 3000 --amplitude 2000 --frequency 25", []),
        ("--mean 0.2Fcr --amplitude 20% --frequency 25", []),
    ],
)
def test_load_options_without_a_unit_beside_others_are_warned_of(
    words: str, warned: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    _, err = said(capsys, "check", "--rod", str(EXAMPLES / "tubing.toml"), "--no-margins", *words.split())
    lines = [line for line in err.splitlines() if "has a unit; write" in line]
    assert len(lines) == bool(warned)
    assert all(text in lines[0] for text in warned)


@pytest.mark.parametrize(
    ("old", "new", "warned"),
    [
        ('"200ft"', "200", "length 200 is taken in m, and diameter '2in' has a unit; write 200m or 200ft"),
        ('"60deg"', "1.1", "inclination 1.1 is taken in rad, .* write 1.1rad or 1.1deg"),
        ('"4.778in"', "0.25", "channel_diameter 0.25 is taken in m"),
        ('fluid_inside = "8.345ppg"', "fluid_inside = 8.345", "fluid_inside 8.345 .* 8.345kg/m3 or 8.345ppg"),
    ],
)
def test_rod_files_warn_of_a_number_that_may_be_in_another_unit(
    old: str, new: str, warned: str, tmp_path: Path
) -> None:
    file = tmp_path / "rod.toml"
    file.write_text((EXAMPLES / "tubing.toml").read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    if "channel" in warned:  # a hole of 0.25 in is narrower than the rod
        fr.Rod.from_toml(file)
        return
    with pytest.warns(fr.PlausibilityWarning, match=warned) as caught:
        fr.Rod.from_toml(file)
    assert len(caught) == 1


def test_every_rod_file_of_the_examples_is_read_without_a_word() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for file in sorted(EXAMPLES.glob("*.toml")):
            if "youngs_modulus" in (text := file.read_text(encoding="utf-8")) or "catalogue" in text:
                fr.Rod.from_toml(file)


def test_a_number_is_bare_only_beside_a_unit_that_tells_another_reading() -> None:
    rng = np.random.default_rng(5)
    kinds = ["force", "frequency", "length", "pressure", "angle", "speed"]
    for _ in range(depth(2000, 200)):
        drawn = []
        for name in range(rng.integers(1, 5)):
            kind = str(rng.choice(kinds))
            unit = str(rng.choice(["", *list(units.units_of(kind))[:4]]))
            drawn.append(Quantity(f"q{name}", f"{rng.integers(0, 9)} {unit}", kind))
        found = bare_numbers(drawn)
        assert all(each.quantity.unit == "" and each.quantity.size > 0 for each in found)
        assert all(each.unit != each.other and each.beside.unit for each in found)
        if all(each.unit == "" for each in drawn) or all(each.unit for each in drawn):
            assert not found
        elsewhere = any(each.unit for each in drawn)
        always = {each.name for each in drawn if each.kind in ("frequency", "angle") and not each.unit and each.size}
        alike = {each.name for each in drawn if any(o.kind == each.kind and o.unit for o in drawn)}
        assert always - alike <= {each.quantity.name for each in found} if elsewhere else True


def survey(folder: Path, rows: np.ndarray, heading: str = "MD (m),Inc (deg),Azi (deg)") -> Path:
    file = folder / "survey.csv"
    lines = [",".join(f"{value:.6g}" for value in row) for row in rows]
    file.write_text("\n".join([*([heading] if heading else []), *lines]), encoding="utf-8")
    return file


@pytest.mark.slow
def test_surveys_in_other_conventions_are_warned_of(tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    for _ in range(depth(300, 25)):
        n = int(rng.integers(4, 30))
        md = np.cumsum(np.r_[0.0, rng.uniform(60.0, 200.0, n - 1)])
        build = np.clip(
            np.linspace(0.0, rng.uniform(25.0, 90.0), n) + rng.normal(0, 0.1, n) * (np.arange(n) > 0), 0, 90
        )
        azimuth = rng.uniform(20.0, 340.0) + np.cumsum(rng.normal(0, 0.5, n))
        right = np.c_[md, build, azimuth]
        for heading in ("MD (m),Inc (deg),Azi (deg)", ""):
            unit = {} if heading else {"depth_unit": "m"}
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                good = fr.WellPath.from_csv(survey(tmp_path, right, heading), **unit)
            radians = np.c_[md, np.radians(right[:, 1:])]
            with pytest.warns(fr.PlausibilityWarning, match=r'probably in radians; give angle_unit="rad"'):
                fr.WellPath.from_csv(survey(tmp_path, radians, heading), **unit)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                told = fr.WellPath.from_csv(survey(tmp_path, radians, heading), angle_unit="rad", **unit)
            np.testing.assert_allclose(told.inclination, good.inclination, atol=1e-4)
            upside = np.c_[md, 180.0 - build, azimuth]
            with pytest.warns(fr.PlausibilityWarning, match="the well goes up from there: 0 is straight down"):
                fr.WellPath.from_csv(survey(tmp_path, upside, heading), **unit)
        exchanged = survey(tmp_path, right[:, [0, 2, 1]], "")
        if azimuth.max() > 180.0:
            with pytest.raises(ValueError, match="inclination at station"):
                fr.WellPath.from_csv(exchanged, depth_unit="m")
        else:
            with pytest.warns(fr.PlausibilityWarning, match=r"columns|goes up"):
                fr.WellPath.from_csv(exchanged, depth_unit="m")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            fr.WellPath(md, np.radians(180.0 - build), np.radians(azimuth))
            fr.WellPath(md, np.full(n, np.radians(30.0)), np.radians(build))  # a section that turns, as likely
        assert [str(each.message).split(":")[0].split(" deg ")[1] for each in caught] == [
            "of inclination, so that the well goes up from there"
        ]


def test_a_section_that_begins_inclined_has_no_exchanged_columns() -> None:
    """It may turn from an azimuth of 0: by less than its inclination changes, or less than wells build."""
    rng = np.random.default_rng(29)
    for _ in range(depth(300, 30)):
        md = np.cumsum(np.r_[0.0, rng.uniform(60.0, 200.0, 9)])
        built = np.linspace(rng.uniform(10.0, 30.0), rng.uniform(60.0, 90.0), 10)
        held = rng.uniform(10.0, 90.0) + np.zeros(10)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for inclination, most in ((built, 29.0), (held, 19.0)):
                azimuth = np.linspace(0.0, rng.uniform(1.0, most), 10)
                fr.WellPath(md, np.radians(inclination), np.radians(azimuth))


def test_a_vertical_well_is_no_survey_in_radians(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for _ in range(depth(200, 20)):
        n = int(rng.integers(12, 60))
        rows = np.c_[np.arange(n) * 30.0, rng.uniform(0.0, 1.5, n), rng.uniform(0.0, 360.0, n)]
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            fr.WellPath.from_csv(survey(tmp_path, rows))


@pytest.mark.slow
def test_the_terminal_warns_of_a_survey_with_its_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = np.array([[0, 0, 0.5], [600, 0, 0.5], [900, 0.52, 0.6], [1500, 1.57, 0.8]])
    words = ["--well", str(survey(tmp_path, rows)), *WELL[2:], "--depths", "1000m"]
    assert "probably in radians; give --angle-unit rad" in said(capsys, "reach", *words)[1]
    assert "radians" not in said(capsys, "reach", *words, "--angle-unit", "rad")[1]
