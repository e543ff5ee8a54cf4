"""How probable it is that a string reaches a depth: against quantiles of friction and strings pushed one by one."""

from __future__ import annotations

import json
import math
import pickle
from typing import Any

import numpy as np
import pytest
from scipy import special, stats

import floquetrod as fr
from tests.conftest import depth, some

TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
DEPTHS = [1200.0, 2000.0, 3000.0]


def most_friction(bottom: float, push: float = math.inf) -> float:
    """Return the greatest coefficient with which a string is pushed to a depth, by halving."""
    low, high = 0.2, 0.4
    for _ in range(14):
        middle = 0.5 * (low + high)
        found = TUBING.mean_force(WELL, middle, bottom=bottom, depth=[0.0])
        low, high = (middle, high) if found.at_top <= push and not found.is_locked else (low, middle)
    return low


@pytest.mark.slow
@pytest.mark.parametrize("push", [None, pytest.param(20e3, marks=pytest.mark.slow)])
def test_with_one_friction_it_is_the_share_below_what_stops_the_string(push: float | None) -> None:
    friction = stats.uniform(0.2, 0.2)
    many = depth(200, 8)
    found = fr.probability_of_reach(TUBING, WELL, friction, depth=[3000.0], push=push, samples=many, seed=2)
    drawn = friction.ppf(np.random.default_rng(2).random((1, many))[0])
    for i, each in enumerate(found.depth):
        limit = most_friction(each, math.inf if push is None else push)
        assert found.probability[i] == np.mean(drawn <= limit)
        low, high = stats.binomtest(int((drawn <= limit).sum()), many).proportion_ci(0.95, "exact")
        assert (found.low[i], found.high[i]) == pytest.approx((low, high), rel=1e-12)  # which SciPy finds as a root
    assert 0.0 < found.probability[0] < 1.0


@pytest.mark.slow
def test_samples_are_strings_pushed_one_by_one() -> None:
    """Friction by depth, a weight, and a survey with both kinds of errors, with paths made by hand."""
    many = depth(25, 3)
    parameters: dict[str, Any] = {
        "inclination_systematic": ("-3deg", "3deg"),
        "fluid_inside": (0.0, 1500.0),
        "azimuth_random": stats.norm(0.0, 0.05),
    }
    friction = [(0.0, stats.norm(0.25, 0.02)), ("1200m", 0.3), ("1450m", (0.2, 0.45))]
    found = fr.probability_of_reach(TUBING, WELL, friction, parameters, depth=DEPTHS, samples=many, seed=6)
    hits = np.zeros(3)
    for u in np.random.default_rng(6).random((8, many)).T:
        off = math.radians(-3.0 + 6.0 * u[2])
        phi = WELL.inclination + off
        turned = 0.05 * special.ndtri(u[4:]) + np.where(phi < 0.0, math.pi, 0.0)
        well = fr.WellPath(WELL.depth, np.abs(phi), turned)
        string = TUBING.replace(fluid_inside=1500.0 * u[3])
        given = [(0.0, 0.25 + 0.02 * special.ndtri(u[0])), (1200.0, 0.3), (1450.0, 0.2 + 0.25 * u[1])]
        goes = [not string.mean_force(well, given, bottom=each, depth=[0.0]).is_locked for each in DEPTHS]
        hits += np.cumprod(goes)
    np.testing.assert_array_equal(found.probability, hits / many)
    assert 0.0 < found.probability[-1] < 1.0


@pytest.mark.slow
def test_deeper_is_less_probable_and_a_tool_helps() -> None:
    tool = fr.VibrationTool("8kN", "18Hz", "30m")
    options: dict[str, Any] = {"depth": [2600.0, 3000.0, 3400.0], "samples": depth(15, 6), "seed": 1}
    still, shaken = (fr.probability_of_reach(TUBING, WELL, (0.24, 0.36), tool=each, **options) for each in (None, tool))
    for found in (still, shaken):
        assert (np.diff(found.probability) <= 0.0).all()
        assert ((found.low <= found.probability) & (found.probability <= found.high)).all()
    assert (shaken.probability >= still.probability).all()
    assert shaken.probability.sum() > still.probability.sum()


def test_the_same_seed_gives_the_same_samples() -> None:
    calls: list[tuple[int, int]] = []
    one = fr.probability_of_reach(
        TUBING, WELL, (0.2, 0.4), depth=[3000.0], samples=4, progress=lambda *n: calls.append(n)
    )
    assert calls == [(1, 4), (2, 4), (3, 4), (4, 4)]
    again = fr.probability_of_reach(TUBING, WELL, (0.2, 0.4), depth=[3000.0], samples=4, seed=one.seed)
    assert one == again == pickle.loads(pickle.dumps(one))
    assert json.loads(json.dumps(one.as_dict()))["depth_m"] == [3000.0]
    assert repr(one).startswith("<reaches 3000 m with probability ")
    assert "independent of each other" in str(one.report().with_assumptions())


@pytest.mark.parametrize(
    ("friction", "changes", "words"),
    [
        (0.3, {}, "friction or one of the parameters must be distributed"),
        ("a", {}, "friction must be a real number"),
        ((0.3, 0.2), {}, "friction must increase"),
        ((-0.3, 0.2), {}, "friction must be zero or more"),
        (stats.norm, {}, "friction must be a single real number"),
        (stats.norm(0.0, 0.1), {}, "possible strings and wells, but there is friction = -.*truncnorm"),
        ([(0, (0.1, 0.2)), (10, "x")], {}, "friction must be a real number, got 'x'"),
        ([(10, (0.1, 0.2))], {}, "friction must begin at depth 0"),
        ((0.2, 0.3), {"parameters": {"length": (1, 2)}}, "parameters must be among .* got 'length'"),
        ((0.2, 0.3), {"parameters": [1]}, "parameters must map names"),
        ((0.2, 0.3), {"parameters": {"azimuth_random": ("1deg", "2m")}}, r"parameters\['azimuth_random'\]\[1\]"),
        ((0.2, 0.3), {"parameters": {"radius": (0.08, 0.1)}}, "possible strings and wells, .*channel_radius"),
        ((0.2, 0.3), {"tool": 3}, "tool must be a VibrationTool"),
        ((0.2, 0.3), {"helical": "no"}, "helical must be one of"),
        ((0.2, 0.3), {"samples": 0}, "samples must be 1 or more"),
        ((0.2, 0.3), {"confidence": 1.0}, "confidence must be less than 1"),
        ((0.2, 0.3), {"push": "3m"}, "push must"),
        ((0.2, 0.3), {"depth": [5000.0]}, "depth must lie below"),
    ],
)
def test_what_cannot_be_pushed_is_refused(friction: Any, changes: dict[str, Any], words: str) -> None:
    options = {"samples": 5, "seed": 1, "depth": [2000.0]} | changes
    with pytest.raises((ValueError, TypeError), match=words):
        fr.probability_of_reach(TUBING, WELL, friction, **options)


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
@pytest.mark.slow
@pytest.mark.parametrize("seed", [seed for kind in range(3) for seed in some(range(kind, 20, 3), 1, 1)])
def test_with_a_tool_a_string_is_stopped_where_its_reach_says(seed: int) -> None:
    """Whatever depths are asked for: all before them count, those at which the tool alone adds too much stress, too."""
    rng = np.random.default_rng([48, 3, seed])
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
    well = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
    tool = fr.VibrationTool(rng.uniform(3e3, 2e4), f"{rng.uniform(5.0, 25.0)}Hz", rng.uniform(0.0, 100.0))
    friction, share = rng.uniform(0.2, 0.4), [None, rng.uniform(0.1, 0.4), 0.8][seed % 3]
    found = rod.reach(well, friction, tool=tool, yield_share=share, depth=[4000.0])
    assert found.reach_shaken >= found.reach or found.limit_shaken != "yield"
    off = 1e-3 * found.reach_shaken
    depths = found.reach_shaken + np.array([-off, off]) if found.is_stopped_shaken else np.array([4000.0])
    for asked in (depths[-1:], np.append(0.5 * depths[0], depths))[depth(0, 1) :]:
        between = friction, friction * (1.0 + 1e-12)
        told = fr.probability_of_reach(rod, well, between, depth=asked, tool=tool, yield_share=share, samples=1, seed=0)
        own = rod.reach(well, friction, tool=tool, yield_share=share, depth=asked)
        assert (told.probability == (asked <= own.reach_shaken)).all()
