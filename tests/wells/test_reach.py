"""How far a string can be pushed into a well, and what a tool changes."""

from __future__ import annotations

import functools
import itertools
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import pyplot

import floquetrod as fr
from floquetrod import units
from floquetrod.plotting.reach_plot import draw_lower_end, draw_wall, draw_well
from floquetrod.rod.answers import pushing, string_reach
from floquetrod.rod.answers.growth_along import growth_along
from floquetrod.rod.answers.string_reach import far, frequency_table
from floquetrod.units import AnswerUnits
from floquetrod.wells.drag import Drag, WellGeometry
from tests.conftest import depth as depth_of_draws
from tests.conftest import some
from tests.inside import damping_across, drag_of, stress_along
from tests.seams import Heard

TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
DEPTHS = np.linspace(1000.0, 4000.0, 4)
TOOL = fr.VibrationTool("8kN", "18Hz", "30m")
METRE = units.unit("m", "", "length")


@functools.cache
def string() -> fr.results.Reach:
    """Return a reach whose numbers tests replace."""
    return TUBING.reach(WELL, 0.3, depth=[4000.0])


def test_in_a_level_hole_it_ends_where_lock_up_does() -> None:
    expected = TUBING.lock_up(0.3, 900.0).length
    path = fr.WellPath.straight(length=1.5 * expected, inclination=math.pi / 2.0)
    found = TUBING.reach(path, 0.3, far_force=900.0, helical="always", depth=np.linspace(100.0, path.end, 10))
    assert found.is_stopped
    assert found.reach == pytest.approx(expected, abs=path.end / 10.0 / 25.0**2)


@pytest.mark.slow
def test_where_it_ends_mean_forces_become_infinite() -> None:
    found = TUBING.reach(WELL, 0.3, depth=DEPTHS)
    step = 1000.0 / 25.0**2
    assert not TUBING.mean_force(WELL, 0.3, bottom=found.reach - step, depth=[0.0]).is_locked
    assert TUBING.mean_force(WELL, 0.3, bottom=found.reach + step, depth=[0.0]).is_locked
    for depth, force in zip(DEPTHS[:2], found.injector[:2], strict=True):
        one = TUBING.mean_force(WELL, 0.3, bottom=depth, depth=[0.0])
        assert force == pytest.approx(one.at_top, rel=1e-6)


SHORT_HELIX = fr.WellPath(
    [
        0,
        437.3055501986551,
        1063.8860581609604,
        1489.1927477961558,
        2148.154255423122,
        2608.149718164062,
        2942.959488110964,
    ],
    [0, 0, 0.6371828557368573, 1.2292064462733374, 1.6690298043288738, 1.75, 1.75],
    [
        *(0.3160732245689949, -0.024986577899869744, 0.1517529055116697, 0.10617352043257672),
        *(0.15620019715774586, 0.2764670059199878, 0.3477316107469158),
    ],
)
STIFF = fr.Rod(
    *(2.07e11, 7850),
    radius=0.014560815934333622,
    inner_radius=0.006904710837331386,
    length=10,
    channel_radius=0.13920085580916752,
    fluid_inside=1000,
    fluid_outside=1400,
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "depths", [None, *(pytest.param(depths, marks=pytest.mark.slow) for depths in ([2942.0], [50.0, 2800.0, 2900.0]))]
)
def test_a_short_helix_that_locks_up_is_not_passed_over(depths: list[float] | None) -> None:
    """It begins where the string leaves the low side, with the lower end at 2752.25 m by steps of 5 mm."""
    friction, far_force = 0.1522268148152164, -3514.107319806371
    found = STIFF.reach(SHORT_HELIX, friction, far_force=far_force, depth=depths)
    assert (found.limit, found.lock_up) == ("lock-up", found.reach)
    assert found.reach == pytest.approx(2752.255, abs=0.006)
    for off, is_locked in ((0.0, False), (1e-6 * SHORT_HELIX.end, True)):
        one = STIFF.mean_force(SHORT_HELIX, friction, far_force=far_force, bottom=found.reach + off, depth=[0.0])
        assert one.is_locked == is_locked


def drawn_string(seed: int) -> tuple[fr.Rod, fr.WellPath, float, float]:
    """Return a string of steel with a yield strength, a well that builds, turns and undulates, friction and a force."""
    rng = np.random.default_rng([48, seed])
    size = int(rng.integers(4, 8))
    measured = np.append(0.0, np.cumsum(rng.uniform(150.0, 650.0, size)))
    inclination = np.concatenate([[0.0, 0.0], np.sort(rng.uniform(0.2, 1.75, size - 1))])
    inclination[2:] += rng.normal(0.0, 0.1, size - 1) * rng.integers(0, 2)
    well = fr.WellPath(measured, np.abs(inclination), rng.normal(0.0, 0.15, size + 1))
    radius = rng.uniform(0.012, 0.03)
    rod = fr.Rod(
        *(2.07e11, 7850.0),
        radius=radius,
        inner_radius=radius * rng.uniform(0.4, 0.85),
        length=10.0,
        channel_radius=rng.uniform(0.05, 0.15),
        fluid_inside=1000.0,
        fluid_outside=rng.uniform(1000.0, 1400.0),
        yield_strength=rng.uniform(200e6, 700e6),
    )
    return rod, well, rng.uniform(0.2, 0.9), rng.uniform(-5e3, 2e3)


def require_reach(found: fr.results.Reach, rod: fr.Rod, friction: float, far_force: float) -> None:
    """Require that a string goes as deep as it reaches, and no deeper."""
    well, stress = found.path, 0.0
    if found.reach > well.start:
        along = rod.mean_force(well, friction, far_force=far_force, bottom=found.reach)
        assert not along.is_locked
        assert along.at_top <= found.push
        stress = float(np.max(stress_along(rod, well, along, along.vibration).largest))
        assert stress <= found.yield_share * rod.yield_strength * (1.0 + 1e-12) or found.limit == "lock-up"
    if found.is_stopped:
        deeper = found.reach + 3e-6 * (well.end - well.start)
        along = rod.mean_force(
            well, friction, far_force=far_force, bottom=deeper, depth=well.stations[well.stations < deeper]
        )
        off = stress_along(rod, well, along, along.vibration).largest.max()
        strength = found.yield_share * rod.yield_strength
        is_beyond = {
            "lock-up": along.is_locked,
            "push": along.at_top > found.push * (1.0 - 1e-9),
            "yield": off > 0.999 * strength or stress > 0.999 * strength,  # at a bend between its places, too
        }
        assert is_beyond[found.limit]
    else:
        assert found.reach == found.depth[-1]


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
@pytest.mark.parametrize(
    "seeds",
    [pytest.param(range(start, start + 100), marks=pytest.mark.slow) for start in range(0, 1000, 100)],
    ids=str,
)
def test_a_reach_is_one_at_which_the_mean_force_is_finite_and_hardly_deeper_it_is_not(seeds: range) -> None:
    for seed in some(seeds, 4, 1):  # of which each takes seconds
        rod, well, friction, far_force = drawn_string(seed)
        push = [None, 5e3, 30e3][seed % 3]
        found = rod.reach(well, friction, far_force=far_force, push=push, depth=[well.end])
        require_reach(found, rod, friction, far_force)
        statics = rod.reach(
            well, friction, far_force=far_force, yield_share=None, depth=well.end * np.array([0.3, 0.77, 1.0])
        )
        require_reach(replace(statics, yield_share=1e9), rod, friction, far_force)
        assert statics.lock_up == pytest.approx(found.lock_up, abs=2e-6 * well.end)
        assert found.reach <= statics.reach + 2e-6 * well.end
        share = fr.probability_of_reach(
            rod, well, (friction, friction * (1.0 + 1e-12)), depth=[well.end], push=push, far_force=far_force, samples=1
        )
        assert share.probability[0] == (not found.is_stopped)


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
def test_between_the_depths_at_which_the_lower_end_turns_no_string_is_stopped() -> None:
    """Forces of strings to a thousand depths, of which none exceeds those at both turning points beside it."""
    well = fr.WellPath([0.0, 500.0, 900.0, 1400.0, 1700.0, 2200.0], [0.0, 0.0, 1.3, 1.75, 1.0, 1.6])
    strings = pushing.Pushing(TUBING, drag_of(TUBING, well, 0.25, "pushed", "energy", None, 0.05), 500.0)
    turning = strings.turning(well.end)
    assert 2 <= turning.size <= 8
    every = np.union1d(np.linspace(1.0, well.end, 1000), turning)
    force = strings.run(every, 500.0, pushing.FAST, pushing.STATICS).force
    ends = np.searchsorted(every, np.concatenate([[1.0], turning, [well.end]]))
    for low, high in itertools.pairwise(ends):
        steps = np.diff(force[low : high + 1])
        assert (steps > -1e-3).all() or (steps < 1e-3).all()


@pytest.mark.slow
def test_the_reach_is_that_within_a_share_of_yield_and_lock_up_is_told_beside_it() -> None:
    rod = TUBING.replace(yield_strength="70ksi")
    shares = (None, 0.8, 0.5, 0.15)[:: depth_of_draws(1, 2)]
    deep = [rod.reach(WELL, 0.2, yield_share=share, depth=[4000.0]) for share in shares]
    assert [each.limit for each in deep] == ["lock-up", *["yield"] * (len(shares) - 1)]
    assert all(a.reach > b.reach for a, b in itertools.pairwise(deep))
    assert [each.lock_up for each in deep] == pytest.approx([deep[0].reach] * len(shares), abs=0.01)
    for each in deep[1:]:
        assert each.stress.share_of_yield == pytest.approx(each.yield_share, rel=0.02)
        assert each.stress.share_of_yield <= each.yield_share
        beyond = far(each.lock_up, METRE)
        assert f"within {100.0 * each.yield_share:g} % of yield; not within it: {beyond}." in repr(each)
        assert f"at {far(each.lock_up, METRE)} m" in str(each.report())
        assert each.as_dict()["limit"] == "yield"
    pushed = rod.reach(WELL, 0.2, push="1kN", depth=[4000.0])
    assert pushed.limit == "push"
    assert rod.mean_force(WELL, 0.2, bottom=pushed.reach).at_top == pytest.approx(1e3, rel=1e-3)
    assert "with 1 kN" in repr(pushed)
    plain = TUBING.reach(WELL, 0.2, depth=[4000.0])
    assert (plain.limit, plain.reach) == ("lock-up", plain.lock_up)
    assert "since no yield strength is given" in str(plain.report())
    for wrong in (0.0, 1.5, -1.0, "much"):
        with pytest.raises((TypeError, ValueError), match=r"^yield_share must"):
            rod.reach(WELL, 0.2, yield_share=wrong)


def test_a_string_is_told_to_hang_in_air_where_no_fluid_is_given() -> None:
    dry = TUBING.replace(fluid_inside=0.0, fluid_outside=0.0)
    rods = dry, TUBING, TUBING.replace(fluid_inside=0.0)
    for rod, said in zip(rods, ("in air: no fluids given", "in its fluids\n", "fluids, with none inside"), strict=True):
        text = str(rod.reach(WELL, 0.3, depth=[50.0]).report())
        assert said in text


@pytest.mark.slow
@pytest.mark.parametrize("above_end", [0.0, 30.0])
def test_each_force_with_the_tool_is_that_of_its_own_string(above_end: float) -> None:
    tool = fr.VibrationTool("8kN", "18Hz", above_end)
    found = TUBING.reach(WELL, 0.3, tool=tool, depth=[2500.0])
    still, shaken = (TUBING.mean_force(WELL, 0.3, bottom=2500.0, tool=each, depth=[0.0]) for each in (None, tool))
    assert found.injector[0] == pytest.approx(still.at_top, rel=1e-6)
    assert found.injector_shaken[0] == pytest.approx(shaken.at_top, abs=2.0 * shaken.error)
    assert shaken.error < 5e-3 * abs(still.at_top)


@pytest.mark.slow
@pytest.mark.parametrize("push", [pytest.param(None, marks=pytest.mark.slow), "15kN"])
def test_the_force_at_the_bit_is_what_the_upper_end_can_push_there(push: str | None) -> None:
    found = TUBING.reach(WELL, 0.3, push=push, depth=[1200.0, 2500.0, 3500.0])
    assert np.isnan(found.bit[-1])
    scale = TUBING.critical_force
    for depth, force in zip(found.bit_depth[:2], found.bit[:2], strict=True):
        slack = 5e-4 * (scale + force**2 / scale)
        for off, arrives in ((-slack, True), (slack, False)):
            top = TUBING.mean_force(WELL, 0.3, far_force=force + off, bottom=depth, depth=[0.0]).at_top
            assert (top <= (math.inf if push is None else 15e3) and math.isfinite(top)) == arrives


@pytest.mark.slow
def test_where_it_never_gets_nothing_arrives_at_the_bit() -> None:
    found = TUBING.reach(WELL, 0.3, depth=[3500.0])
    assert np.isnan(found.bit).all()
    assert found.as_dict()["bit_N"] == [None]
    assert "locked" in str(found.report())


@pytest.mark.slow
def test_strings_are_marched_side_by_side(heard: Heard) -> None:
    """Sixty strings, which end and buckle at depths of their own, take hardly more steps than the longest alone."""
    calls = heard(Drag, "slopes")
    numbers = []
    for depths in ([2900.0], np.linspace(50.0, 2900.0, 60)):
        calls.clear()
        TUBING.reach(WELL, 0.3, depth=depths)
        numbers.append(len(calls))
    assert numbers[1] < 1.6 * numbers[0]


def test_a_weak_injector_stops_it_before_lock_up() -> None:
    path = fr.WellPath.straight(length=1000.0, inclination=math.pi / 2.0)
    found = TUBING.reach(path, 0.3, push="3kN", depth=np.linspace(100.0, 1000.0, 5))
    assert found.reach == pytest.approx(3000.0 / (0.3 * TUBING.weight_per_length), abs=1.0)
    assert TUBING.reach(path, 0.1, depth=[1000.0]).reach == 1000.0


@pytest.mark.slow
def test_a_tool_too_weak_to_move_the_string_gains_nothing() -> None:
    found = TUBING.reach(WELL, 0.3, tool=fr.VibrationTool(1.0, "18Hz"), depth=[2500.0, 3500.0])
    assert found.reach < 3500.0
    assert found.reach_shaken == pytest.approx(found.reach, rel=5e-4)
    assert (found.gain, found.useful_frequencies) == (0.0, ())
    assert "gains no depth" in str(found.report())
    assert replace(found, reach_shaken=found.reach - 100.0).gain == pytest.approx(-100.0)


@pytest.mark.slow
def test_gains_that_the_depths_asked_for_cut_short_say_so() -> None:
    """At other speeds and frequencies, too: a longer search would give larger gains there."""
    lines = dict(TUBING.reach(WELL, 0.3, tool=TOOL, depth=[3500.0]).report().lines)
    assert lines["speed"].count(" m/s (to the deepest depth asked for)") == 2
    assert "m at 0.2 m/s" in lines["speed"].rsplit(",", 1)[1]
    assert re.match(r"farthest at [\d.]+ Hz: to 3,500 m \(\+510 m\), the deepest depth asked for, ", lines["tool Hz"])
    lines = dict(TUBING.reach(WELL, 0.3, tool=TOOL, depth=[4000.0]).report().lines)
    assert "asked for" not in lines["speed"] + lines["tool Hz"]


METRE = units.unit("m", "", "length")


@pytest.mark.slow
def test_what_a_tool_gains_is_told_for_three_speeds_of_sliding() -> None:
    found = TUBING.reach(WELL, 0.3, tool=TOOL, speed="0.1m/s", depth=[4000.0])
    assert found.speeds == pytest.approx([0.04, 0.1, 0.4])
    assert found.reach_at_speeds[1] == found.reach_shaken
    for speed, deep in zip(found.speeds, found.reach_at_speeds, strict=True):
        other = TUBING.reach(WELL, 0.3, tool=TOOL, speed=speed, depth=[4000.0])
        assert other.reach_shaken == pytest.approx(deep, abs=0.5)
        assert not TUBING.mean_force(WELL, 0.3, tool=TOOL, speed=speed, bottom=deep).is_locked
    assert (np.diff(found.gain_at_speeds) < 0.0).all()
    gains = [far(deep, METRE, less=found.reach)[1:] for deep in found.reach_at_speeds]
    assert f"the tool gains {gains[0]} m at 0.04 m/s, {gains[1]} m at 0.1 m/s" in str(found.report())
    assert f"(+{gains[1]} m)" in str(found.report())  # the headline, with the same digits
    sheet = found.as_dict()
    assert sheet["gain_at_speeds_m"] == pytest.approx(found.gain_at_speeds)
    assert TUBING.reach(WELL, 0.3, depth=[1000.0]).speeds.size == 0


@pytest.mark.slow
def test_a_tool_gains_reach_and_says_where_it_hurts() -> None:
    still, shaken = TUBING.reach(WELL, 0.3, depth=DEPTHS), TUBING.reach(WELL, 0.3, tool=TOOL, depth=DEPTHS)
    assert (still.gain, still.reach) == (0.0, shaken.reach)
    assert shaken.gain > 50.0
    assert (shaken.injector_shaken <= shaken.injector + 1.0).all()
    assert not shaken.growth.any()
    assert "no lateral wave grows" in str(shaken.report())
    held = shaken.growth_free > 0.0
    assert held.any()
    assert (shaken.speed_to_grow[held] > shaken.sliding).all()
    assert np.isinf(shaken.speed_to_grow[~held]).all()
    assert shaken.useful_frequencies == ()
    said = str(shaken.report())
    assert (
        f"{far(shaken.frequency_depth[-1], METRE)} m at least, each with lateral waves" in said
    )  # where it hangs free, without damping
    best = int(np.nanargmax(shaken.reach_at_frequencies))
    hertz = f"{shaken.frequencies[best] / (2.0 * math.pi):.3g}Hz"
    assert f"farthest at {hertz[:-2]} Hz: to {far(shaken.reach_at_frequencies[best], METRE)} m (" in said
    alone = TUBING.reach(WELL, 0.3, tool=fr.VibrationTool(TOOL.amplitude, hertz, TOOL.above_end), depth=DEPTHS)
    assert shaken.reach_at_frequencies[best] == pytest.approx(alone.reach_shaken, rel=2e-3)
    table = frequency_table(shaken, shaken._units(None, None, None, None))
    assert table is not None
    assert len(table.rows) == shaken.frequencies.size
    assert (np.isnan(shaken.reach_at_frequencies) == np.isinf(shaken.frequency_growth)).all()
    damped = TUBING.replace(damping_rate=0.6).reach(WELL, 0.3, tool=TOOL, depth=DEPTHS)
    assert damped.useful_frequencies == damped.stable_frequencies != ()
    assert still.useful_frequencies == ()
    assert (shaken.bit_shaken >= shaken.bit - 1.0)[np.isfinite(shaken.bit)].all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frequency", "above_end", "expected"),
    [
        ("18Hz", 0.0, 3771.0),
        ("9Hz", 30.0, 3717.0),
        ("18Hz", 30.0, 3574.0),
        ("25Hz", 30.0, 3408.0),
        ("18Hz", 71.3, 3045.0),
    ],
)
def test_the_reach_is_that_with_finer_waves(
    frequency: str, above_end: float, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The table of docs/theory/mean_force.md; a quarter of a wave above the lower end, 71.3 m, little is gained."""
    well = fr.WellPath([0.0, 1000.0, 1450.0, 5000.0], ["0deg", "0deg", "90deg", "90deg"])
    drag = drag_of(TUBING, well, 0.3, "pushed", "energy", fr.VibrationTool("8kN", frequency, above_end), 0.05)
    search, found = pushing.Pushing(TUBING, drag, 0.0), []
    for cells in (pushing.FAST.cells, 36):
        for name in ("FAST", "SOUGHT"):
            monkeypatch.setattr(pushing, name, getattr(pushing, name)._replace(cells=cells))
        found.append(search.reached(well.end, pushing.STATICS).depth)
    assert found == pytest.approx([expected, found[0]], rel=5e-4)


@pytest.mark.slow
def test_a_strong_tool_makes_waves_grow_against_friction() -> None:
    found = TUBING.reach(WELL, 0.3, tool=fr.VibrationTool("20kN", "18Hz", "30m"), depth=DEPTHS)
    grows = found.growth > 0.0
    assert grows.any()
    assert not (grows & found.along.is_snaking).any()
    assert (found.growth <= found.growth_free).all()
    assert (found.speed_to_grow[grows] < found.sliding).all()
    assert np.isfinite(found.half_wave[grows]).all()
    assert found.frequency_growth[np.isclose(found.frequencies, TOOL.frequency)] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("force", "frequency"), some([("8kN", "18Hz"), ("20kN", "12Hz"), ("14kN", "4Hz")], 1, 1))
def test_with_another_frequency_it_says_what_a_tool_of_that_frequency_does(force: str, frequency: str) -> None:
    """Whose string has another mean force: all waves at all places under that say what few of them said."""
    tool = fr.VibrationTool(force, frequency, "30m")
    found = TUBING.reach(WELL, 0.3, tool=tool, depth=DEPTHS)
    bottoms = found.frequency_depth
    assert found.reach < bottoms[0] < bottoms[-1] < found.reach_shaken
    places = np.linspace(0.0, bottoms[-1], 1 + math.ceil(bottoms[-1] / string_reach._SPACING))
    for k in range(1, found.frequencies.size, 5):
        other = fr.VibrationTool(tool.amplitude, float(found.frequencies[k]), tool.above_end)
        ask = [(bottom, np.append(places[places < bottom], bottom)) for bottom in bottoms]
        own = [TUBING.mean_force(WELL, 0.3, bottom=bottom, tool=other, depth=depth) for bottom, depth in ask]
        assert math.isinf(found.frequency_growth[k]) == any(each.is_locked or each.error > 1e5 for each in own)
        if math.isfinite(found.frequency_growth[k]):
            grown = max(_growth(each, other.frequency, found.sliding) for each in own)
            assert found.frequency_growth[k] == pytest.approx(grown, rel=0.02, abs=0.02)  # by quick forces


def _growth(along: fr.results.MeanForce, frequency: float, sliding: float) -> float:
    """Return the largest growth along a string less what friction takes from it."""
    free = ~along.is_snaking
    place = WellGeometry.at(WELL.arcs.at(along.depth[free]))
    found = growth_along(TUBING, place, along.force[free], along.vibration[free], frequency).rate
    pressed = 0.3 * along.contact[free] / TUBING.mass_per_length
    lost = damping_across(pressed, sliding, along.speed[free], np.full(found.size, sliding))
    return float(np.maximum(found - lost, 0.0).max())


@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
def test_growth_along_a_level_hole_is_that_of_a_long_rod() -> None:
    """Of the modes of a rod of 300 half waves, which stand close, the fastest grows like the fastest wave."""
    rod = fr.Rod.nitinol().replace(length=60.0, damping_rate=0.3)
    mean, amplitude = 0.2 * rod.critical_force, 0.2 * rod.critical_force
    verdict = rod.stability(fr.AxialLoad(mean, amplitude, 150.0))
    level = WellGeometry(np.ones(1), np.zeros(1), np.zeros(1), np.zeros(1))
    found = growth_along(rod, level, np.array([mean]), np.array([amplitude]), 150.0)
    assert found.rate[0] == pytest.approx(verdict.growth_rate, rel=5e-3)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
def test_growth_along_a_string_is_that_of_sections_cut_out_of_it() -> None:
    """Of 100 m with hinged ends, with their weight and bends, whose modes come within 5 % of the fastest wave."""
    well = fr.WellPath(["0m", "900m", "1350m", "2600m"], ["0deg", "0deg", "85deg", "88deg"])
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=2600.0).replace(damping_rate=0.05)
    found = rod.reach(well, 0.2, tool=fr.VibrationTool("20kN", "18Hz", 300.0), depth=[2200.0])
    for depth in (1500.0, 1800.0, 2000.0):
        k = int(np.abs(found.along.depth - depth).argmin())
        section = rod.replace(length=100.0, path=well, depth=float(found.along.depth[k]) - 50.0)
        load = fr.AxialLoad(float(found.along.force[k]), float(found.amplitude[k]), found.tool.frequency)
        verdict = section.stability(load)
        assert verdict.status == "unstable"
        assert verdict.growth_rate == pytest.approx(found.growth_free[k], rel=0.05)
        assert section.length / verdict.fastest_mode == pytest.approx(found.half_wave[k], rel=0.06)


def test_in_a_bend_the_force_enters_twice() -> None:
    """Waves as long as the bend holds down, k^2 = kappa / R, feel no vibration: there no tongue lies."""
    rod = fr.Rod.nitinol()
    force, size = np.array([0.2 * rod.critical_force]), np.array([0.1 * rod.critical_force])
    bends = [WellGeometry(np.ones(1), np.zeros(1), np.array([k]), np.zeros(1)) for k in (0.0, 0.05)]
    straight, bent = (growth_along(rod, each, force, size, 150.0) for each in bends)
    wave = (math.pi / straight.half_wave[0]) ** 2
    stiffer = force[0] * 0.05 / rod.radial_clearance
    assert bent.half_wave[0] > straight.half_wave[0]  # held by the bend, so that longer waves resonate
    assert stiffer > 0.0
    assert bent.rate[0] < straight.rate[0] * (1.0 - 0.5 * 0.05 / rod.radial_clearance / wave)


@pytest.mark.slow
def test_what_it_says_and_draws() -> None:
    tool = fr.VibrationTool("8kN", "18Hz")
    found = TUBING.reach(WELL, [(0, 0.2), (1450, 0.3)], tool=tool, depth=DEPTHS)
    assert repr(found).startswith("<Does the tool help? Yes, sliding at 0.05 m/s: 3")
    text = str(found.report())
    assert "at most" in text
    assert "locked" in text
    sheet = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert sheet["reach_m"] == found.reach
    assert sheet["injector_N"][-1] is None
    figure = found.plot()
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["force at the surface / kN", "force in the string / kN", "stress / MPa"]
    assert pyplot.get_fignums() == [figure.number]  # notebooks show it
    with_tool = figure.axes[0].lines[2].get_xydata()
    assert with_tool[-1] == pytest.approx([found.along.depth[-1], found.along.injector / 1e3])
    pyplot.close(figure)
    plain = TUBING.reach(WELL, 0.1, depth=[1000.0])
    lock_up = "by friction, whatever the stress and the push: nowhere down to 1,000 m"
    assert dict(plain.report().lines)["lock-up"] == lock_up
    assert plain.as_dict()["tool"] is None
    assert "grows" not in str(plain.report())


def test_a_tool_above_the_string_is_refused() -> None:
    far = fr.VibrationTool("8kN", "18Hz", "4000m")
    words = r"^tool must lie in the string, less than its length 4000 m above the lower end, got above_end = 4000 m"
    with pytest.raises(ValueError, match=words):
        TUBING.reach(WELL, 0.3, tool=far)
    with pytest.raises(ValueError, match=words):
        fr.probability_of_reach(TUBING, WELL, (0.2, 0.3), depth=[3000.0], tool=far)


def test_depths_off_the_path_are_refused() -> None:
    with pytest.raises(
        ValueError, match="depth must lie below the start of the path and down to its end, 0 to 4000 m, got"
    ):
        TUBING.reach(WELL, 0.3, depth=[5000.0])


@pytest.mark.parametrize(
    ("depth", "said"),
    [
        (["13000ft", "14000ft"], "0 to 13123.4 ft, got 14000 ft"),
        ("5km", "0 to 4 km, got 5 km"),
        ([0.0, 100.0], "0 to 4000 m, got 0 m"),
        ([], "0 to 4000 m, got none"),
    ],
)
def test_depths_beyond_the_path_are_told_in_the_unit_they_were_given_in(depth: object, said: str) -> None:
    with pytest.raises(ValueError, match=f"^depth must lie below the start of the path and down to its end, {said}$"):
        TUBING.reach(WELL, 0.3, depth=depth)


@given(
    st.tuples(st.floats(1.0, 3900.0), st.floats(1.0, 3900.0), st.floats(1.0, 2.0)),
    st.sampled_from(["lock-up", "yield", "push", "end of the well", "deepest asked for"]),
    st.sampled_from(["m", "ft"]),
)
def test_the_first_line_answers_whether_the_tool_helps(
    depths: tuple[float, float, float], limit: str, unit: str
) -> None:
    without, shaken, farther = depths
    limits = {"limit": "lock-up", "limit_shaken": limit, "push": 5e4}
    with_tool = replace(string(), tool=TOOL, reach=without, reach_shaken=shaken, **limits)
    found = replace(with_tool, lock_up=without, lock_up_shaken=farther * shaken, yield_share=0.8)
    said = found._in_words(AnswerUnits.named(length=unit))
    numbers = [float(number.replace(",", "")) for number in re.findall(r"[+-]?\d[\d,]*\.?\d*(?=[ ,.)])", said)]
    foot = {"m": 1.0, "ft": 0.3048}[unit]
    if found.gain == 0.0:
        assert said.startswith("Does the tool help? No, not at a sliding speed of ")
        return
    assert said.startswith("Does the tool help? " + ("Yes, sliding at " if shaken > without else "No: "))
    numbers = numbers[shaken > without :]  # without the speed
    assert numbers[0] == pytest.approx(shaken / foot, rel=6e-4)
    assert numbers[1] == pytest.approx(without / foot, rel=6e-4)
    assert numbers[2] == pytest.approx(numbers[0] - numbers[1], rel=1e-3)  # of the numbers that are shown
    if limit in ("yield", "push"):
        assert numbers[-1] == pytest.approx(min(farther * shaken, 4000.0) / foot, rel=6e-4)


@pytest.mark.slow
def test_it_answers_in_the_units_asked_for() -> None:
    found = TUBING.replace(yield_strength="90ksi").reach(WELL, 0.3, depth=[50.0, 1200.0])
    foot, pound = 0.3048, 4.4482216152605
    text = str(found.report(depth="ft", force="lbf"))
    weight = found.weight_per_length * foot / pound
    assert f"weighs {weight:.4g} lbf/ft" in text
    assert "of the yield strength 90 ksi" in text
    for other in ("MPa", " N", " m ", "kN"):
        assert other not in text
    assert "of the yield strength 90000 psi" in str(found.report("ft", "lbf", "psi"))
    figure = found.plot(depth="ft", force="lbf", pressure="psi")
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["force at the surface / lbf", "force in the string / lbf", "stress / psi"]
    shown = AnswerUnits.named("lbf", "ft", "psi")
    well, lower_end, wall = (draw(found, shown).axes for draw in (draw_well, draw_lower_end, draw_wall))
    assert [ax.get_ylabel() for ax in (*well, *lower_end, *wall)] == [
        *("true vertical depth / ft", "force at the lower end / lbf", "contact / (lbf/ft)", "coefficient\nof friction"),
    ]
    pressed = wall[0].lines[0].get_ydata()
    assert pressed == pytest.approx(found.along.contact / (pound / foot), nan_ok=True)
    curve = figure.axes[1].lines[0]
    assert curve.get_xdata() == pytest.approx(found.along.depth / foot)
    assert curve.get_ydata() == pytest.approx(found.along.force / pound)
    with pytest.raises(ValueError, match=r"^depth must be a unit of length"):
        found.plot(depth="lbf")


@pytest.mark.slow
def test_what_is_not_tried_at_the_lower_end_is_marked() -> None:
    found = TUBING.reach(WELL, 0.3, depth=[30.0, 50.0, 1200.0])
    assert found.bit_limit == pytest.approx(10.0 * TUBING.critical_force)
    assert found.is_limited(found.bit).tolist() == [True, True, False]
    rows = str(found.report(force="N")).splitlines()
    assert rows[-3].split()[-1] == f">{found.bit[1]:.0f}"
    assert rows[-2].split()[-1] == f"{found.bit[2]:.0f}"
    assert rows[-1].startswith("> at the lower end: more may arrive")
    curve, marks = draw_lower_end(found, AnswerUnits.named("N")).axes[0].lines[:2]
    assert curve.get_ydata() == pytest.approx(found.bit)
    assert marks.get_ydata() == pytest.approx(found.bit[:2])


@pytest.mark.slow
def test_the_figure_ends_where_the_string_does_however_few_depths_were_asked_for() -> None:
    found = TUBING.reach(WELL, 0.3, tool=TOOL, depth=[2000.0, 4000.0])
    figure = found.plot()
    without, end, _, end_shaken = figure.axes[0].lines[:4]
    assert without.get_marker() == "."  # few depths, which are marked
    assert end.get_xdata()[0] == pytest.approx(found.reach, rel=2e-3)
    assert end_shaken.get_xdata()[0] == pytest.approx(found.reach_shaken, rel=2e-3)
    just_above = TUBING.mean_force(WELL, 0.3, bottom=float(end.get_xdata()[0])).at_top
    assert end.get_ydata()[0] == pytest.approx(just_above / 1e3, rel=1e-3)
    texts = {text.get_text() for artist in figure.axes[0].artists for text in artist.texts}
    assert {"without the tool", "with the tool"} <= texts
    pyplot.close(figure)


@pytest.mark.slow
def test_a_reach_with_a_tool_says_its_error_and_how_finely_it_was_sampled() -> None:
    lines = dict(TUBING.reach(WELL, 0.3, tool=TOOL, depth=[4000.0]).report(depth="ft").lines)
    assert lines["error"] == "some 6 ft with the tool, 0.05 % of the depth"
    assert lines["sampled"].startswith("at depths 131 ft apart or less")
    assert not {"error", "sampled"} & set(dict(string().report().lines))


@pytest.mark.parametrize(
    ("force", "said"),
    [("1120lbf", "1120 lbf at 18 Hz, 98.43 ft above"), ("1125.75lbf", "1125.75 lbf at"), ("5kN", "1124 lbf at 18 Hz")],
)
def test_a_tool_is_said_as_it_was_given_or_to_four_digits(force: str, said: str) -> None:
    tool = fr.VibrationTool(force, "18Hz", "30m")
    assert tool.in_words(AnswerUnits.named(force="lbf", length="ft")).startswith(said)
