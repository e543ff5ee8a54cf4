"""The bend that tubing has from its reel: its contact beside that of a beam between two walls, and its stress."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import floquetrod as fr
from floquetrod import cli
from tests.conftest import depth
from tests.inside import drag_of

PIPE = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
BENT = PIPE.replace(residual_curvature=0.1)
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])


def contacts(rigidity: float, clearance: float, curvature: float) -> tuple[np.ndarray, np.ndarray]:
    """Return distances from the free end in m and the forces in N of a beam on the walls that it lies between.

    Its energy, E I / 2 times the integral of (y'' - kappa_0)^2 by finite differences, is least with abs(y) <= R; the
    far end is clamped on the lower wall.  The forces are the multipliers of the bounds.
    """
    length, count = 3.0 * math.sqrt(12.0 * clearance / curvature), 120
    step = length / count
    second = (
        np.eye(count - 1, count + 1) - 2.0 * np.eye(count - 1, count + 1, 1) + np.eye(count - 1, count + 1, 2)
    ) / (step * step)
    clamped = np.full(2, -clearance)
    weighted, wanted = math.sqrt(step) * second[:, 2:], math.sqrt(step) * (curvature - second[:, :2] @ clamped)
    bounds = -clearance * np.ones(count - 1), clearance * np.ones(count - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        y = lsq_linear(weighted, wanted, bounds=bounds, method="bvls", tol=1e-14).x
    force = -rigidity * weighted.T @ (weighted @ y - wanted)
    distance = length - step * np.arange(2, count + 1)
    return distance, force


@pytest.mark.parametrize(("curvature", "clearance"), [(0.1, 0.0353), (0.25, 0.02)])
def test_the_contact_is_that_of_a_beam_between_walls(curvature: float, clearance: float) -> None:
    """To the square of a mesh of 40 points over the part that springs off the wall."""
    rod = PIPE.replace(residual_curvature=curvature, channel_radius=PIPE.radius + clearance)
    distance, force = contacts(rod.flexural_rigidity, clearance, curvature)
    found = rod.mean_force(WELL, 0.2, bottom=500.0).end_contact
    assert np.abs(force).sum() == pytest.approx(found, rel=3e-3)
    springs = math.sqrt(12.0 * clearance / curvature)
    beyond = np.abs(force[distance > 1.1 * springs])
    assert beyond.sum() < 3e-3 * found  # held straight it does not press elsewhere
    assert force[distance < 0.1 * springs].sum() == pytest.approx(0.5 * found, rel=3e-3)


@pytest.mark.parametrize("motion", [pytest.param("pushed", marks=pytest.mark.slow), "pulled", "standing"])
def test_friction_at_the_lower_end_is_against_the_motion(motion: str) -> None:
    """The string is a straight one with so much more compression at its lower end."""
    friction = [(0.0, 0.1), (900.0, 0.4)]
    bent = BENT.mean_force(WELL, friction, motion=motion, far_force=700.0, bottom=1200.0, depth=[300.0])
    sign = {"pushed": 1.0, "pulled": -1.0, "standing": 0.0}[motion]
    contact = BENT.flexural_rigidity * 0.1**1.5 / math.sqrt(3.0 * BENT.radial_clearance)
    straight = PIPE.mean_force(
        WELL, friction, motion=motion, far_force=700.0 + sign * 0.4 * contact, bottom=1200.0, depth=[300.0]
    )
    assert bent.end_contact == pytest.approx(contact, rel=1e-12)
    np.testing.assert_allclose(bent.force, straight.force, rtol=1e-12, atol=1e-9)


@pytest.mark.slow
def test_without_a_bend_nothing_changes() -> None:
    plain, named = PIPE.reach(WELL, 0.3, depth=[400.0]), PIPE.replace(residual_curvature=0.0)
    assert named == PIPE
    assert named.reach(WELL, 0.3, depth=[400.0]).as_dict() == plain.as_dict()
    assert "bend" not in dict(plain.report().lines)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.3, [(0.0, 0.25), (2000.0, 0.35)], [(0.0, 0.35), (2880.0, 0.1)]][depth(0, 2) :])
def test_a_bent_string_reaches_less_and_as_far_as_its_mean_force(friction: Any) -> None:
    bent = BENT.reach(WELL, friction, depth=[3000.0], yield_share=None)
    straight = PIPE.reach(WELL, friction, depth=[3000.0], yield_share=None)
    assert bent.limit == "lock-up"
    assert bent.reach < straight.reach
    goes, stops = (BENT.mean_force(WELL, friction, bottom=bent.reach + off, depth=[0.0]) for off in (0.0, 0.05))
    assert not goes.is_locked
    assert stops.is_locked
    weights = BENT.surface_weights(WELL, friction, depth=[3000.0])
    assert weights.lock_up[0] == pytest.approx(bent.lock_up, abs=1e-6 * WELL.end)


def test_no_depth_on_the_way_is_left_out_where_friction_changes() -> None:
    """A short sticky interval, whose friction at the lower end alone exceeds the push."""
    friction = [(0.0, 0.1), (500.0, 1.4), (500.5, 0.1)]
    push = 0.5 * 1.4 * drag_of(BENT, WELL, 0.1, "pushed", "energy", None, 0.05).end_contact
    level = fr.WellPath.straight(length=700.0, inclination="89deg")
    free = {"yield_share": None, "depth": [700.0]}
    found = BENT.reach(level, friction, push=push + 4e3 * 0.05, **free)
    assert found.limit == "push"
    assert found.reach == pytest.approx(500.0, abs=1e-3)


def test_its_stress_is_that_of_holding_it_straight() -> None:
    load = fr.AxialLoad("20kN", "5kN", "1Hz")
    more = BENT.stress(load).bending - PIPE.stress(load).bending
    assert more == pytest.approx(BENT.youngs_modulus * BENT.radius * 0.1, rel=1e-12)
    found = BENT.reach(WELL, 0.2, depth=[400.0], yield_share=1.0)
    plain = PIPE.reach(WELL, 0.2, depth=[400.0], yield_share=1.0)
    assert found.bending_stress.min() >= more
    assert plain.bending_stress.min() < more
    assert f"held straight it adds {more / 1e6:.3g} MPa of bending stress" in dict(found.report().lines)["bend"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(8, 1)))
def test_the_terminal_and_python_agree(seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng([50, 11, seed])
    survey = tmp_path / "survey.csv"
    survey.write_text("MD (m),Inc (deg),Azi (deg)\n0,0,0\n1000,0,0\n1450,90,0\n2000,90,0\n", encoding="utf-8")
    bend = f"{rng.uniform(0.01, 0.08):.4f}rad/m"
    line = ["reach", "--well", str(survey), "--rod", "2.00x0.156 CT90", "--bore", "4.778in", "--friction", "0.4"]
    assert cli.main([*line, "--residual-curvature", bend, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1000.0, residual_curvature=bend)
    found = rod.reach(fr.WellPath.from_csv(survey), 0.4)
    assert (record["reach_m"], record["limit"]) == (found.reach, found.limit)
    assert record["along"]["end_contact_N"] == found.along.end_contact
    assert record["largest_stress_Pa"] == found.as_dict()["largest_stress_Pa"]


def test_verdicts_on_modes_refuse_it() -> None:
    with pytest.raises(
        ValueError, match=r"residual_curvature is not part of verdicts on modes.*residual_curvature=0\.0"
    ):
        BENT.stability(fr.AxialLoad(1e3, 1e3, 1.0))
    with pytest.raises(ValueError, match="residual_curvature must be zero or more"):
        PIPE.replace(residual_curvature=-0.1)
