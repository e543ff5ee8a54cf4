"""Pressure and stripper at the wellhead: surface weights by the balance of the wall, Lame's stresses, two doors."""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod import cli
from floquetrod.wells.drag import MOTIONS
from tests.conftest import depth
from tests.inside import stress_of

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")

PIPE = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])


@pytest.mark.slow
@given(
    pressure=st.floats(0.0, 8e7),
    inside=st.floats(0.0, 8e7),
    friction=st.floats(0.0, 5e4),
    motion=st.sampled_from(sorted(MOTIONS)),
)
@settings(max_examples=depth(30, 6), deadline=None)
def test_the_injector_feels_what_the_wall_carries(pressure: float, inside: float, friction: float, motion: str) -> None:
    """From the force in the wall, which the stripper alone changes; the pressure inside has no part in it."""
    found = PIPE.mean_force(WELL, 0.2, motion=motion, bottom=900.0, wellhead_pressure=pressure, stripper=friction)
    outer, inner = math.pi * PIPE.radius**2, math.pi * PIPE.inner_radius**2
    below = found.at_top - inside * inner + pressure * outer  # compression in the wall
    above = below + {"pushed": friction, "standing": 0.0, "pulled": -friction}[motion]
    assert found.injector == pytest.approx(above + inside * inner, rel=1e-12, abs=1e-3)
    assert found.surface_weight == -found.injector
    assert found.at_top == PIPE.mean_force(WELL, 0.2, motion=motion, bottom=900.0).at_top


def test_without_a_wellhead_nothing_changes() -> None:
    plain, named = PIPE.reach(WELL, 0.3, depth=[400.0]), {"wellhead_pressure": 0.0, "stripper": "0N"}
    assert PIPE.reach(WELL, 0.3, depth=[400.0], **named).as_dict() == plain.as_dict()
    assert plain.wellhead_force == 0.0
    assert "wellhead" not in dict(plain.report().lines)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(12, 1)))
def test_the_injector_has_less_left_for_the_string(seed: int) -> None:
    """A reach within a push against pressure and stripper is that within what they leave of it."""
    rng = np.random.default_rng([50, 8, seed])
    pressure, friction = rng.uniform(0.0, 3e7), rng.uniform(0.0, 2e4)
    added = pressure * math.pi * PIPE.radius**2 + friction
    push = added + rng.uniform(-5e3, 2e4)
    at = {"depth": [600.0, 2400.0], "far_force": 300.0}
    found = PIPE.reach(WELL, 0.25, push=push, wellhead_pressure=pressure, stripper=friction, **at)
    plain = PIPE.reach(WELL, 0.25, push=push - found.wellhead_force, **at)
    assert found.wellhead_force == pytest.approx(added, rel=1e-12)
    assert (found.reach, found.limit) == (plain.reach, plain.limit)
    np.testing.assert_allclose(found.injector, plain.injector + added, rtol=1e-12)
    np.testing.assert_array_equal(found.bit, plain.bit)


@pytest.mark.slow
@pytest.mark.parametrize("tool", [None, pytest.param(fr.VibrationTool("2kN", "15Hz"), marks=pytest.mark.slow)])
def test_a_push_too_small_to_begin_with_gets_nowhere(tool: fr.VibrationTool | None) -> None:
    """Weight helps later on, whichever depths are asked for."""
    push = 1e7 * math.pi * PIPE.radius**2 - 100.0
    for depths in ([900.0], [1.0, 10.0, 900.0])[: depth(2, 1)]:
        found = PIPE.reach(WELL, 0.2, tool=tool, push=push, wellhead_pressure=1e7, depth=depths)
        assert (found.reach, found.limit) == (0.0, "push")
        assert found.injector[-1] < push
    assert PIPE.reach(WELL, 0.2, tool=tool, push=push + 200.0, wellhead_pressure=1e7, depth=[900.0]).reach == 900.0


def von_mises(rod: fr.Rod, force: float, bending: float, inside: float, outside: float) -> float:
    """Return the largest von Mises stress in Pa of both faces and sides, by Lame's stresses and the wall's force."""
    inner, outer = rod.inner_radius, rod.radius
    wall = -(force - math.pi * inner**2 * inside + math.pi * outer**2 * outside) / rod.area  # in tension
    a = (inside * inner**2 - outside * outer**2) / (outer**2 - inner**2)
    b = (inside - outside) * inner**2 * outer**2 / (outer**2 - inner**2)
    largest = 0.0
    for r in (inner, outer):
        hoop, radial = a + b / r**2, a - b / r**2
        for side in (1.0, -1.0):
            axial = wall + side * bending * r / outer
            square = 0.5 * ((axial - hoop) ** 2 + (hoop - radial) ** 2 + (radial - axial) ** 2)
            largest = max(largest, math.sqrt(square))
    return largest


@given(
    force=st.floats(-3e5, 3e5),
    bent=st.floats(0.0, 0.05),
    inside=st.floats(0.0, 1e8),
    outside=st.floats(0.0, 1e8),
)
@settings(max_examples=depth(300, 60))
def test_the_stress_is_that_of_lame_and_von_mises(force: float, bent: float, inside: float, outside: float) -> None:
    one = np.ones(1)
    found = stress_of(PIPE, bent * one, force * one, np.zeros(1, bool), 0.0, (inside - outside) * one)
    bending = PIPE.youngs_modulus * PIPE.radius * bent
    assert found.largest[0] == pytest.approx(von_mises(PIPE, force, bending, inside, outside), rel=1e-6, abs=10.0)
    equal = stress_of(PIPE, bent * one, force * one, np.zeros(1, bool), 0.0, 0.0 * one)
    plain = stress_of(PIPE, bent * one, force * one, np.zeros(1, bool), 0.0, None)
    assert equal.largest[0] == pytest.approx(plain.largest[0], rel=1e-12)


def test_bare_pressure_of_a_thick_wall() -> None:
    """A pipe without force and bends: sqrt(3) p r_o^2 / (r_o^2 - r_i^2) at its bore (Timoshenko, Strength II, 44)."""
    zero = np.zeros(1)
    found = stress_of(PIPE, zero, zero, np.zeros(1, bool), 0.0, np.array([5e7])).largest[0]
    outer, inner = PIPE.radius, PIPE.inner_radius
    assert found == pytest.approx(math.sqrt(3.0) * 5e7 * outer**2 / (outer**2 - inner**2), rel=1e-12)
    assert found == pytest.approx(von_mises(PIPE, 0.0, 0.0, 5e7, 0.0), rel=1e-12)


@pytest.mark.slow
def test_pressure_takes_its_part_of_the_yield_share() -> None:
    """The reach ends where von Mises' stress along the string, by the test's own formula, comes to the share."""
    heavy = PIPE.replace(fluid_inside=1400.0)
    given_ = {"wellhead_pressure": 1e7, "pressure_inside": 4.5e7, "depth": [3000.0], "yield_share": 0.36}
    found = heavy.reach(WELL, 0.2, **given_)
    assert found.limit == "yield"
    assert heavy.reach(WELL, 0.2, wellhead_pressure=1e7, depth=[3000.0], yield_share=0.36).reach > found.reach
    along = found.along
    stress = [
        von_mises(heavy, force, bending, 4.5e7 + 1400.0 * 9.81 * down, 1e7 + 1000.0 * 9.81 * down)
        for force, bending, down in zip(
            along.force, found.bending_stress, WELL.position(along.depth)[:, 2], strict=True
        )
    ]
    np.testing.assert_allclose(found.largest_stress, stress, rtol=1e-9)
    assert max(stress) == pytest.approx(0.36 * heavy.yield_strength, rel=2e-3)
    assert found.stress.share_of_yield == pytest.approx(0.36, rel=2e-3)
    assert "von Mises with" in str(found.stress)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(12, 1)))
def test_the_terminal_and_python_agree(seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng([50, 9, seed])
    survey = tmp_path / "survey.csv"
    survey.write_text("MD (m),Inc (deg),Azi (deg)\n0,0,0\n1000,0,0\n1450,90,0\n2000,90,0\n", encoding="utf-8")
    wellhead = {
        "wellhead_pressure": f"{rng.uniform(0.0, 5000.0):.1f}psi",
        "stripper": f"{rng.uniform(0.0, 6.0):.2f}kip",
        "pressure_inside": f"{rng.uniform(0.0, 8000.0):.1f}psi",
    }
    pipe = "2.00x0.156 CT90"
    line = ["reach", "--well", str(survey), "--rod", pipe, "--bore", "4.778in", "--friction", "0.3", "--json"]
    typed = [f"--{name.replace('_', '-')}={text}" for name, text in wellhead.items()]
    assert cli.main([*line, "--push", "90kN", *typed]) == 0
    record = json.loads(capsys.readouterr().out)
    rod = fr.Rod.catalogue(pipe, bore="4.778in", length=1000.0)
    found = rod.reach(fr.WellPath.from_csv(survey), 0.3, push="90kN", **wellhead)
    assert record["reach_m"] == found.reach
    assert record["wellhead_force_N"] == found.wellhead_force
    assert record["injector_N"] == found.as_dict()["injector_N"]
    assert record["largest_stress_Pa"] == found.as_dict()["largest_stress_Pa"]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"wellhead_pressure": -1.0}, "wellhead_pressure must be zero or more"),
        ({"wellhead_pressure": "3kN"}, "wellhead_pressure must be a number with a pressure unit"),
        ({"stripper": "-5lbf"}, "stripper must be zero or more"),
        ({"stripper": math.nan}, "stripper must be finite"),
        ({"pressure_inside": 1e12}, "pressure_inside must lie between"),
    ],
)
def test_bad_wellheads(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        PIPE.reach(WELL, 0.3, depth=[500.0], **wrong)
    for ask in (fr.Rod.nitinol().reach, partial(fr.probability_of_reach, fr.Rod.nitinol())):
        with pytest.raises(ValueError, match="pressure_inside is that in a tube, and this rod is solid, got 5 Pa"):
            ask(WELL, 0.3, pressure_inside=5.0)


@pytest.mark.slow
def test_a_probability_knows_the_wellhead() -> None:
    at = {"depth": [900.0, 2600.0], "samples": 4, "seed": 3}
    found = fr.probability_of_reach(PIPE, WELL, (0.2, 0.3), push=50e3, wellhead_pressure=2e7, stripper=5e3, **at)
    added = 2e7 * math.pi * PIPE.radius**2 + 5e3
    plain = fr.probability_of_reach(PIPE, WELL, (0.2, 0.3), push=50e3 - added, **at)
    np.testing.assert_array_equal(found.probability, plain.probability)


def test_only_what_the_wellhead_has_is_said() -> None:
    def said(**wellhead: str) -> str:
        found = PIPE.reach(WELL, 0.3, depth=[1000.0], **wellhead)
        return dict(found.report(force="lbf", pressure="psi").lines)["wellhead"]

    assert said(stripper="500lbf") == "500 lbf of push at the injector: 500 lbf by the stripper"
    assert "stripper" not in said(wellhead_pressure="3000psi")
    both = said(stripper="500lbf", wellhead_pressure="3000psi")
    assert "by 3000 psi on the cross-section and 500 lbf by the stripper" in both
