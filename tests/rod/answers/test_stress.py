"""Stress of a rod that lies in its channel, and how far it is from yield."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.cli.main import main

ROD = fr.Rod.nitinol()
PIPE = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0)


def test_a_uniform_force_over_the_area() -> None:
    found = ROD.stress(fr.AxialLoad(-0.5, 0.3, 150.0))
    assert found.axial == pytest.approx(0.8 / (math.pi * 0.8e-3**2), rel=1e-12)  # a pull counts as a push does
    assert (found.bending, found.yield_strength, found.share_of_yield) == (0.0, None, None)


def test_bending_follows_the_channel() -> None:
    bent = PIPE.replace(curvature="3deg/30m")
    found = bent.stress(fr.AxialLoad("20kN", "5kN", "1Hz"))
    assert found.bending == pytest.approx(207e9 * 25.4e-3 * math.radians(0.1), rel=1e-12)
    assert found.share_of_yield == pytest.approx(found.largest / (90e3 * 6894.757293168), rel=1e-9)


def test_the_worst_place_is_where_force_and_bend_together_are_worst() -> None:
    """Of a path: against samples of the force and the curvature, taken here."""
    path = fr.WellPath([0.0, 300.0, 600.0], np.radians([10.0, 70.0, 80.0]), np.radians([0.0, 0.0, 40.0]))
    rod = PIPE.replace(length=500.0, path=path, depth=50.0)
    load = fr.AxialLoad("30kN", "10kN", "0.1Hz", mean_at=1.0)
    found = rod.stress(load)
    s = np.linspace(0.0, 500.0, 5001)
    vertical = path.position(50.0 + s)[:, 2]
    force = np.abs(load.mean + rod.weight_per_length * (vertical - vertical[-1])) + load.amplitude
    kappa = np.hypot(*path.curvature(50.0 + s))
    assert found.largest == pytest.approx((force / rod.area + 207e9 * 25.4e-3 * kappa).max(), rel=1e-3)
    assert 0.0 <= found.position <= 500.0


def test_a_wave_is_largest_where_the_response_says() -> None:
    wave = fr.AxialWave(0.0, "2kN", "15Hz")
    long = PIPE.replace(length=600.0)
    found = long.stress(wave)
    assert found.axial == pytest.approx(long.axial_response(wave).largest / long.area, rel=2e-3)


def test_harmonics_in_and_out_of_phase() -> None:
    load = fr.AxialLoad(0.0, 1.0, 150.0, waveform=[1.0, 0.5j])
    t = np.linspace(0.0, 2.0 * math.pi, 20001)
    peak = np.abs((np.exp(1j * t) + 0.5j * np.exp(2j * t)).real).max()
    assert ROD.stress(load).axial * ROD.area == pytest.approx(peak, rel=5e-3)


def test_files_and_copies_keep_the_strength(tmp_path: Path) -> None:
    assert PIPE.replace(length=50.0).yield_strength == PIPE.yield_strength
    assert fr.Rod(**PIPE.as_dict()) == PIPE
    assert "yield_strength" not in ROD.as_dict()
    path = tmp_path / "rod.toml"
    path.write_text('catalogue = "2.00x0.156 CT90"\nbore = "4.778in"\nlength = "60m"\nyield_strength = "500MPa"\n')
    assert fr.Rod.from_toml(path).yield_strength == 500e6


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, "3kg", True])
def test_no_strength(bad: object) -> None:
    with pytest.raises((ValueError, TypeError), match="yield_strength"):
        ROD.replace(yield_strength=bad)


def test_the_terminal_says_it_where_the_grade_is_known(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "rod.toml"
    path.write_text('catalogue = "2.00x0.156 CT90"\nbore = "4.778in"\nlength = 60.0\ncurvature = "0.1 1/m"\n')
    load = ["--mean", "5kN", "--amplitude", "1kN", "--frequency", "1Hz", "--no-margins"]
    main(["check", "--rod", str(path), *load])
    assert "stress    at most 536 MPa, 86 % of the yield strength 621 MPa: axial 10.3 MPa" in capsys.readouterr().out
    main(["check", "--rod", str(path), *load, "--json"])
    assert json.loads(capsys.readouterr().out)["stress"]["share_of_yield"] == pytest.approx(0.864, abs=1e-3)
    main(["check", "--rod", str(path), *load, "--mean", "400kN"])
    assert ", beyond the yield strength 621 MPa" in capsys.readouterr().out


LEVEL = fr.WellPath.straight(length=600.0, inclination="90deg")


def test_along_a_level_hole_a_helix_bends_the_string() -> None:
    """The stress at its upper end by hand, F / A + E r_o R F / (2 E I)."""
    found = PIPE.reach(LEVEL, 0.3, far_force="20kN", helical="always", depth=[600.0], yield_share=None)
    force, area = found.along.at_top, math.pi * (25.4e-3**2 - 21.4376e-3**2)
    assert found.stress.axial == pytest.approx(force / area, rel=1e-12)
    assert found.stress.position == 0.0
    curvature = PIPE.radial_clearance * force / (2.0 * PIPE.flexural_rigidity)
    assert found.stress.bending == pytest.approx(207e9 * 25.4e-3 * curvature, rel=1e-3)
    assert found.yields[0]  # it locks up at 558 m, and next to that its upper end yields
    assert not found.yields[-1]


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
def test_where_a_string_is_bent_beyond_yield_reach_says_so() -> None:
    """An arc of a radius of 7 m, E r_o / 7 m = 751 MPa, and straight parts beside it."""
    sharp = 450.0 + 7.0 * math.pi / 2.0
    path = fr.WellPath([0.0, 450.0, sharp, 470.0], ["0deg", "0deg", "90deg", "90deg"])
    found = PIPE.reach(path, 0.3, depth=[470.0], yield_share=None)
    where = found.along.depth[found.yields]
    assert where.size
    assert 440.0 < where.min() < where.max() <= sharp + 1e-9
    assert found.bending_stress.max() == pytest.approx(207e9 * 25.4e-3 / 7.0, rel=0.1)
    assert "beyond the yield strength 621 MPa" in str(found.report())
    assert "\nyields    4" in str(found.report())
    told = json.loads(json.dumps(found.as_dict()))
    assert told["stress"]["share_of_yield"] > 1.2
    assert len(told["bending_stress_Pa"]) == len(told["along"]["depth_m"])


def test_without_a_grade_nothing_yields() -> None:
    found = PIPE.replace(yield_strength=None).reach(LEVEL, 0.3, depth=[600.0])
    assert not found.yields.any()
    assert found.stress.share_of_yield is None
    assert "any stress, since no yield strength is given" in str(found.report())
    assert "of the yield strength" not in str(found.report())


@pytest.mark.slow
def test_a_tool_adds_its_vibration() -> None:
    found = PIPE.reach(LEVEL, 0.3, tool=fr.VibrationTool("5kN", "18Hz"), depth=[600.0])
    force = np.abs(found.along.force) + found.amplitude
    assert found.axial_stress == pytest.approx(force / PIPE.area, rel=1e-12)


def test_a_strength_in_megapascals_is_suspected() -> None:
    with pytest.warns(
        fr.PlausibilityWarning, match='yield_strength = 620 Pa is that of no solid; was it in MPa.*"620MPa"'
    ):
        ROD.replace(yield_strength=620.0)
