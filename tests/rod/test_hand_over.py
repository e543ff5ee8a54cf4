"""A verdict on a rod in one file to pass on."""

from __future__ import annotations

import base64
import copy
import datetime
import html
import pickle
import re
import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.cli.main import main
from floquetrod.plotting import document
from floquetrod.rod import hand_over
from floquetrod.rod.model.assumptions import Assumption
from floquetrod.units import unit

ROOT = Path(__file__).parents[2]
ROD = fr.Rod.nitinol()
VERDICT = ROD.stability(fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0))
STATIC = ROD.stability(fr.AxialLoad(0.5, 0.0, 150.0))


def words(page: str) -> str:
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", page)).split())


@pytest.mark.slow
def test_a_page_needs_no_other_file_and_says_what_the_verdict_says(tmp_path: Path) -> None:
    path = fr.save_report(VERDICT, tmp_path / "rod.html", units={"mean": "Fcr"})
    page = path.read_text(encoding="utf-8")
    assert not re.search(r'(?:src|href)="(?!data:)', page)
    for line in (
        "UNSTABLE: mode 7 grows",
        "mean 0.2 Fcr (0.3392 N)",
        "margins",
        "Dawson & Paslay 1984",
    ):
        assert line in words(page)
    assert "again" not in words(page)  # no command was typed
    assert not re.search(r"Rod\(|AxialLoad\(|=\)|monospace", page)
    pictures = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', page)
    assert len(pictures) == 1
    assert ET.fromstring(base64.b64decode(pictures[0])).tag.endswith("svg")
    assert fr.save_report(VERDICT, tmp_path / "again.html", units={"mean": "Fcr"}).read_bytes() == path.read_bytes()


def test_text_is_not_markup(tmp_path: Path) -> None:
    page = fr.save_report(STATIC, tmp_path / "a.html", command="floquetrod report --rod '<b>&.toml'").read_text()
    assert "&lt;b&gt;&amp;.toml" in page
    assert "<img" not in page  # without vibration there is no map


@pytest.mark.slow
def test_a_pdf_has_pages_of_text_and_one_of_each_figure(tmp_path: Path) -> None:
    plain = fr.save_report(STATIC, tmp_path / "plain.pdf").read_bytes()
    drawn = fr.save_report(VERDICT, tmp_path / "drawn.pdf").read_bytes()
    pages = [len(re.findall(rb"/Type /Page\b", content)) for content in (plain, drawn)]
    assert plain.startswith(b"%PDF")
    assert pages == [2, 3]
    assert b"/Subtype /Image" not in drawn  # figures are lines and text
    assert b"Mono" not in drawn


def test_the_rod_is_there_parameter_by_parameter(tmp_path: Path) -> None:
    page = fr.save_report(STATIC, tmp_path / "a.html").read_text()
    for told in (
        "Young's modulus 68 GPa",
        "diameter 1.6 mm (0.06299 in)",
        "inclination 90 deg",
        "gravity 9.81 m/s2",
    ):
        assert (told in words(page)) == ("inclination" not in told)  # what it has not is left out


def test_every_assumption_has_a_limit(tmp_path: Path) -> None:
    tubing = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)
    mud = tubing.replace(fluid_inside=1200.0, fluid_outside=1200.0, inclination="60deg")
    loads = fr.AxialLoad("5kN", "1kN", "5Hz"), fr.AxialWave.hertz(5000.0, 1000.0, 5.0)
    for rod in (tubing, tubing.replace(curvature=0.01), mud):
        for load in loads:
            for assumption in rod.stability(load).assumptions:
                assert isinstance(assumption, Assumption)
                assert assumption.limit, assumption
    page = words(fr.save_report(STATIC, tmp_path / "a.html").read_text())
    assert "Small angles (at 15 degrees gravity acts as if 0.9 % weaker" in page


def test_an_assumption_keeps_its_limit_in_copies() -> None:
    kept, *_ = VERDICT.assumptions
    for again in (pickle.loads(pickle.dumps(kept)), copy.deepcopy(kept)):
        assert (type(again), again, again.limit) == (Assumption, str(kept), kept.limit)
    with pytest.raises(TypeError, match="limit"):
        Assumption("no torque")  # type: ignore[call-arg]


def test_another_result_is_passed_on_with_what_it_says(tmp_path: Path) -> None:
    page = fr.save_report(fr.stability(fr.Hill(-0.25, (0.5,))), tmp_path / "a.html").read_text()
    assert "UNSTABLE" in page.upper()
    assert "made by floquetrod" in words(page)
    assert "data:image" not in page


@pytest.mark.slow
def test_an_equation_is_passed_on_with_what_changes_its_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    equation = fr.Mathieu.from_aq(1.2, -0.9, 0.1)
    drawn = []
    monkeypatch.setattr(hand_over.chart_plot, "mark", lambda axes, x, y, text: drawn.append((axes, x, y)))
    page = fr.save_report(fr.stability(equation), tmp_path / "a.html").read_text()
    for line in (
        "growth 0.280198 per unit z, tenfold in 8.218 z",
        "damping stable with a damping above 0.410143 per unit z, 0.310143 more",
        "margins changes with a at 1.76362 (0.5636 higher) and at 0.0336536 (1.166 lower), in steps of 0.047",
        "changes with -q at 0.29116 (0.6088 lower), none higher up to 3.6, in steps of 0.042",
        "Figure 1. The equation among others with other q and a, with the damping 0.1: unstable where coloured.",
    ):
        assert line in words(page)
    for axes, x, y in drawn:
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("$q$", "$a$")
        assert (x, y) == (-0.9, 1.2)
        assert axes.get_xlim() == (-3.6, 0.0)
    assert drawn
    with pytest.raises(ValueError, match="units must be left out"):
        fr.save_report(fr.stability(equation), tmp_path / "b.html", units={"force": "lbf"})


@pytest.mark.slow
def test_motion_after_the_onset_is_told(tmp_path: Path) -> None:
    rod = ROD.replace(damping_rate=3.0, length=1.2)
    load = fr.AxialLoad(0.1 * rod.critical_force, 0.3 * rod.critical_force, 110.0)
    motion = rod.steady_motion(load)
    page = words(fr.save_report(rod.stability(load), tmp_path / "a.html", motion=motion).read_text())
    assert "moves by 6.512 degrees in mode 2" in page
    assert re.search(r"grows to about 6\.\d degrees in mode 2 alone", page)


@pytest.mark.slow
def test_lines_of_a_pdf_fit_its_page() -> None:
    lines = document._wrapped("word " * 60 + "x" * 200, 3.0, 8.5)
    assert "".join(lines).replace(" ", "") == "word" * 60 + "x" * 200
    assert all(document._width(line, 8.5) <= 3.0 + 1e-6 for line in lines)
    assert all(document._width(f"{a} {b.split()[0]}", 8.5) > 3.0 for a, b in pairwise(lines) if "x" not in b)


@pytest.mark.slow
def test_a_chart_is_handed_over_as_its_picture(tmp_path: Path) -> None:
    chart = fr.mathieu.chart((0.0, 1.0, 5), (-1.0, 0.0, 5))
    page = fr.save_report(chart, tmp_path / "chart.html").read_text(encoding="utf-8")
    assert "Chart of stability" in page
    assert "of 25 points stable" in page
    assert page.count("<img") == 1
    with pytest.raises(ValueError, match="units must be left out"):
        fr.save_report(chart, tmp_path / "other.html", units={"mean": "N"})


def test_what_is_wrong_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"path must end in \.html or \.pdf, got '.*a\.doc'"):
        fr.save_report(STATIC, tmp_path / "a.doc")
    with pytest.raises(TypeError, match=r"result must be a result with a report, such as what rod\.stability"):
        fr.save_report(ROD, tmp_path / "a.html")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"motion must be what rod\.steady_motion returned"):
        fr.save_report(STATIC, tmp_path / "a.html", motion=3.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"reach must be what rod\.reach returned"):
        fr.save_report(STATIC, tmp_path / "a.html", reach=3.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"record must be what fr\.ForceRecord\.from_csv returned"):
        fr.save_report(STATIC, tmp_path / "a.html", record=3.0)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_report_on_a_measured_force_has_its_noise_and_its_figure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The verdict is that of ``check``, about the record and not about its fit alone."""
    time = np.arange(600) / 400.0
    noise = 0.01 * np.random.default_rng(50).standard_normal(time.size)
    rows = np.column_stack([time, 0.34 + 0.3 * np.sin(150.0 * time) + noise])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="t (s),force (N)", comments="")
    question = ["--rod", "nitinol", "--force", str(tmp_path / "run.csv"), "--no-margins"]
    assert main(["check", *question]) == 0
    checked = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert main(["report", *question, "--out", str(tmp_path / "run.html")]) == 0
    page = words((tmp_path / "run.html").read_text())
    said = [line for line in checked if line.startswith(("growth", "method", "note", "record"))]
    assert len(said) == 4
    assert all(line in page for line in said)
    assert "noise in the record makes the growth rate uncertain" in page
    assert "Measured force and its fit" in page


def test_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    load = ["--rod", "nitinol", "--mean", "0.2Fcr", "--amplitude", "0", "--frequency", "24Hz"]
    assert main(["report", *load]) == 0
    assert capsys.readouterr().out == "STABLE: no mode grows\nwritten: report.html\n"
    assert "24 Hz" in words((tmp_path / "report.html").read_text())
    for wrong, message in (
        (["--tool", "5kN@18Hz"], "--tool needs --well"),
        (["--well", "survey.csv"], "--well needs --friction"),
        (["--out", "report.doc"], "--out must end in .html or .pdf"),
    ):
        assert main(["report", *load, *wrong]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.slow
def test_of_tubing_in_a_well_reach_is_told_and_drawn(tmp_path: Path) -> None:
    path = tmp_path / "tubing.html"
    load = ["--mean", "3kN", "--amplitude", "2kN", "--frequency", "4Hz", "--no-margins"]
    well = ["--well", str(ROOT / "floquetrod/examples/survey.csv"), "--friction", "0.3", "--tool", "5kN@18Hz@30m"]
    assert (
        main(["report", "--rod", str(ROOT / "floquetrod/examples/tubing.toml"), *load, *well, "--out", str(path)]) == 0
    )
    page = path.read_text()
    assert re.search(r"<h2[^>]*>Reach</h2>", page)
    captions = re.findall(r"<figcaption>Figure (\d+)\. ", page)
    assert captions == [str(k + 1) for k in range(page.count("<img"))]
    assert len(captions) == 7  # shape and map; of the reach what answers, the well, the lower end, the wall, the waves


UNITS = {"mean": "lbf", "amplitude": "lbf", "frequency": "Hz", "length": "ft", "pressure": "ksi"}


@pytest.mark.slow
def test_all_of_it_is_in_the_units_asked_for(tmp_path: Path) -> None:
    tubing = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="20ft", inclination="60deg")
    verdict = tubing.stability(fr.AxialLoad("3000lbf", 0.0, "15Hz"))
    page = words(fr.save_report(verdict, tmp_path / "a.html", units=UNITS).read_text())
    for told in (
        f"critical force {tubing.critical_force / 4.4482216152605:.4g} lbf",
        "inner diameter 1.688 in, inclination 60 deg",
        "length 20 ft",
        "diameter 2 in (50.8 mm)",
        "Young's modulus 30.0228 Mpsi",
        "yield strength 90 ksi",
        "half wave",
        "gravity 32.185 ft/s2",
        "density 490.059 lb/ft3",
    ):
        assert told in page, told
    told, _ = page.split("Assumptions, and their limits")
    assert not re.search(r"\d (N|m|MPa|GPa|kg/m|kg/m3|m/s2|N/m|N m\^2)(?![\w/^])", told)


@pytest.mark.slow
def test_only_the_load_asked_about_warns(tmp_path: Path) -> None:
    tubing = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="30m", inclination="60deg")
    verdict = tubing.stability(fr.AxialLoad("10kN", "5kN", "15Hz"))  # 0.09 wavelengths long, at the edge of a map 0.16
    fr.save_report(verdict, tmp_path / "a.html", margins=False)


def test_units_are_checked_before_anything_is_computed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fr.Rod, "reach", None)
    load = [
        "--rod",
        str(ROOT / "floquetrod/examples/tubing.toml"),
        "--mean",
        "3kN",
        "--amplitude",
        "0",
        "--frequency",
        "4Hz",
    ]
    well = ["--well", str(ROOT / "floquetrod/examples/survey.csv"), "--friction", "0.3"]
    assert main(["report", *load, *well, "--unit", "ft,parsec"]) == 2
    assert "--unit must name units such as Hz,Fcr or ft,lbf, got 'parsec'" in capsys.readouterr().err


@pytest.mark.slow
def test_a_reach_is_written_in_the_units_asked_for_and_others_refuse_them(tmp_path: Path) -> None:
    tubing = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0)
    found = tubing.reach(fr.WellPath.straight(length=1000.0, inclination=1.5), 0.3, depth=[500.0, 1000.0])
    page = words(fr.save_report(found, tmp_path / "a.html", units={"length": "ft", "force": "lbf"}).read_text())
    assert "To 3,281 ft, the end of the well" in page
    assert "surface lbf" in page
    for units, words_of_error in (({"depth": "ft"}, "units must be of mean"), ({"force": "Fcr"}, "units\\['force'\\]")):
        with pytest.raises(ValueError, match=words_of_error):
            fr.save_report(found, tmp_path / "b.html", units=units)
    proof = fr.certify(fr.Mathieu(alpha=0.5, beta=-0.25))
    with pytest.raises(ValueError, match="units must be left out"):
        fr.save_report(proof, tmp_path / "b.html", units={"force": "lbf"})
    assert not (tmp_path / "b.html").exists()


@pytest.mark.slow
def test_one_report_whichever_command_writes_it(tmp_path: Path) -> None:
    """What is said of a string and its well by `report` is said by `reach`, in the same words; inputs come first."""
    rod, survey = str(ROOT / "floquetrod/examples/tubing.toml"), str(ROOT / "floquetrod/examples/survey.csv")
    well = ["--rod", rod, "--well", survey, "--friction", "0.3", "--project", "a <job>"]
    load = ["--mean", "3kN", "--amplitude", "0", "--frequency", "4Hz", "--no-margins", "--unit", "m,kN"]
    files = tmp_path / "report.html", tmp_path / "reach.html"
    assert main(["report", *well, *load, "--out", str(files[0])]) == 0
    assert main(["reach", *well, "--unit", "m,kN", "--report", str(files[1])]) == 0
    pages = [file.read_text() for file in files]
    assert all("a &lt;job&gt;" in page and page.index("verdict") < page.index(">Inputs<") for page in pages)
    of_both, of_reach = (set(re.findall(r"<h2>(.*?)</h2>", page)) for page in pages)
    assert of_reach - {"Constant forces where the well is level"} <= of_both
    rows = [set(re.findall(r"<tr>.*?</tr>", page.split(">Reach</h2>")[1].split("<figure>")[0])) for page in pages]
    assert rows[1]
    assert rows[1] == rows[0]
    for told in ("survey.csv", "tubing.toml", "friction", "Dawson", "Small angles", "made by"):
        assert all(told in page for page in pages), told


@pytest.mark.slow
def test_a_tapered_string_has_the_constant_forces_of_each_section(tmp_path: Path) -> None:
    sections = [fr.Section(name, length="1500m") for name in ("2.00x0.203 CT90", "2.00x0.156 CT90")]
    string = fr.Rod(sections=sections, bores=[("0m", "4.778in")])
    well = fr.WellPath([0.0, 1000.0, 1450.0, 2000.0], ["0deg", "0deg", "90deg", "90deg"])
    found = string.reach(well, 0.2, depth=["1900m"])
    page = words(fr.save_report(found, tmp_path / "reach.html").read_text(encoding="utf-8"))
    level, newtons = string.replace(inclination="90deg"), unit("N", "force", "force")
    for part in level.uniform_parts:
        force, *_ = part.rod.critical_forces["sinusoidal"]
        assert f"sinusoidal, section {part.section + 1} {newtons.show(force, 4)}" in page
    assert "uniform_parts" not in page


def test_criteria_that_do_not_apply_are_left_out(tmp_path: Path) -> None:
    steep = ROD.replace(inclination="30deg")
    for rod, is_told in ((ROD, False), (steep, True)):
        page = fr.save_report(
            rod.stability(fr.AxialLoad(0.1, 0.0, 150.0)), tmp_path / "a.html", margins=False
        ).read_text()
        assert ("Lubinski" in page) is is_told
        assert "Dawson" in page


def test_a_project_and_files_are_told(tmp_path: Path) -> None:
    page = words(fr.save_report(STATIC, tmp_path / "a.html", project="Test 12", files={"rod": "wire.toml"}).read_text())
    assert f"Test 12 \N{MIDDLE DOT} {datetime.date.today().day} " in page
    assert "Files rod wire.toml" in page
    with pytest.raises(TypeError, match="files must be"):
        fr.save_report(STATIC, tmp_path / "b.html", files=["wire.toml"])  # type: ignore[arg-type]
    assert not (tmp_path / "b.html").exists()
