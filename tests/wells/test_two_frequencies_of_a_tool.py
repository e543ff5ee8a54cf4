"""A tool of two frequencies: friction under both waves, what damps each, and how far a string goes with it."""

from __future__ import annotations

import contextlib
import io
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod import cli
from floquetrod._util.compilation import compiled
from floquetrod.rod.loads.tool import independent_sines
from floquetrod.wells.drag import CHECKED, FAST, WellGeometry
from floquetrod.wells.kernels import shaken_march, tool_wave
from floquetrod.wells.shaken_string import ShakenString
from tests.conftest import depth as depth_of_draws
from tests.conftest import some
from tests.inside import drag_of

TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
IMPEDANCE = TUBING.mass_along * TUBING.wave_speed
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 5000.0], ["0deg", "0deg", "90deg", "90deg"])
GOLDEN = 0.5 * (1.0 + math.sqrt(5.0))


def drawn_speeds(rng: np.random.Generator) -> tuple[float, float, float]:
    """Return v, V and V' in m/s, of very different sizes too, or V + V' a little more or less than v."""
    v, one, other = (10.0 ** rng.uniform(-2.0, 0.0, 3)).tolist()
    return (float((one + other) * rng.choice([0.99, 1.01])) if rng.random() < 0.2 else v), one, other


def direction(v: float, one: float, other: float, phases: tuple[Any, Any]) -> NDArray[np.float64]:
    """Return the sign of the velocity at pairs of phases."""
    return np.sign(v + one * np.cos(phases[0]) + other * np.cos(phases[1]))


def damping(v: float, one: float, other: float) -> float:
    """Return the component of the direction at the frequency of the wave ``one``."""
    ratio, _ = tool_wave.friction(4.0 / math.pi, v, 1e-9, one, other)
    return ratio * one


# --- friction under two waves ---


@pytest.mark.parametrize("seed", range(depth_of_draws(8, 3)))
def test_friction_is_the_mean_over_a_long_time(seed: int) -> None:
    rng = np.random.default_rng([54, seed])
    v, one, other = drawn_speeds(rng)
    ratio = math.sqrt(rng.uniform(0.1, 9.0))
    time = 0.6180339887 * np.arange(1_000_000) + rng.uniform(0.0, 9.0)
    phases = time, ratio * time + rng.uniform(0.0, 6.0)
    sign = direction(v, one, other, phases)
    assert tool_wave.friction_share(v, one, other) == pytest.approx(sign.mean(), abs=3e-4)
    assert damping(v, one, other) == pytest.approx(2.0 * (sign * np.cos(phases[0])).mean(), abs=3e-4)
    assert damping(v, other, one) == pytest.approx(2.0 * (sign * np.cos(phases[1])).mean(), abs=3e-4)


@pytest.mark.parametrize("seed", range(30))
def test_friction_and_what_damps_the_waves_are_slopes_of_one_function(seed: int) -> None:
    """Of the mean of abs(v + V cos + V' cos), by v, and twice its slopes by V and by V'."""
    v, one, other = drawn_speeds(np.random.default_rng([55, seed]))
    phase = math.pi * (np.arange(20_000) + 0.5) / 20_000

    def mean_speed(v: float, one: float, other: float) -> float:
        """Return the mean of the size of the velocity, over one of the phases in closed form."""
        u = v + other * np.cos(phase)
        within = np.clip(u / one, -1.0, 1.0)
        return float(np.mean(2.0 / math.pi * (u * np.arcsin(within) + one * np.sqrt(1.0 - within**2))))

    def slope(k: int) -> float:
        step = 1e-4 * min(v, one, other)
        low, high = ([x + sign * step * (j == k) for j, x in enumerate((v, one, other))] for sign in (-1.0, 1.0))
        return (mean_speed(*high) - mean_speed(*low)) / (2.0 * step)

    assert tool_wave.friction_share(v, one, other) == pytest.approx(slope(0), abs=2e-4)
    assert damping(v, one, other) == pytest.approx(2.0 * slope(1), abs=1e-3)
    assert damping(v, other, one) == pytest.approx(2.0 * slope(2), abs=1e-3)
    assert tool_wave.friction_share(v, one, other) == tool_wave.friction_share(v, other, one)


@pytest.mark.parametrize("seed", range(10))
def test_a_weak_second_wave_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng([56, seed])
    v, one = 10.0 ** rng.uniform(-2.0, 0.0, 2)
    assert tool_wave.friction_share(v, one, 1e-9) == pytest.approx(tool_wave.friction_share(v, one, 0.0), abs=1e-4)
    assert damping(v, one, 1e-9) == pytest.approx(damping(v, one, 0.0), abs=1e-4)


@pytest.mark.parametrize("seed", range(10))
def test_the_slope_of_what_damps_a_wave_is_that_of_differences(seed: int) -> None:
    v, one, other = drawn_speeds(np.random.default_rng([57, seed]))
    step = 1e-5 * one
    low, high = (size * tool_wave.friction(1.0, v, 1e-2, size, other)[0] for size in (one - step, one + step))
    _, slope = tool_wave.friction(1.0, v, 1e-2, one, other)
    assert slope == pytest.approx((high - low) / (2.0 * step), rel=0.1, abs=0.02 / one)


@pytest.mark.parametrize(
    ("second", "above_end"),
    [
        (("6kN", "29Hz"), 0.0),
        # Interpreted, it takes seconds.
        pytest.param(("2kN", "7Hz"), 30.0, marks=[pytest.mark.kernels, pytest.mark.slow]),
        (("8kN", "18.3Hz"), 200.0),
    ],
)
def test_friction_takes_from_each_wave_what_the_tool_gives_it(second: tuple[str, str], above_end: float) -> None:
    """Half of each amplitude times the velocity in phase with it, as for one frequency."""
    tool = fr.VibrationTool("8kN", "18Hz", above_end, second=second)
    drag = drag_of(TUBING, WELL, 0.2, "pushed", "energy", tool, 0.05)
    assert drag.shaking is not None
    string = ShakenString(drag, drag.shaking, 0.0, 2000.0, 0.0, FAST._replace(cells=24))
    pressed = 0.2 * TUBING.weight_per_length
    string.waves[0].balance.most[:] = 4.0 / math.pi * pressed * np.diff(string.edges)
    assert [compiled(tool_wave.find_waves)(string.waves, 1e-6) for _ in range(20)][-1]
    speeds = []
    for wave in string.waves:
        below, above = wave.cells.below[wave.cells.kind], wave.cells.above[wave.cells.kind]
        speeds.append(np.abs(below * wave.q[:-1, None] + above * wave.q[1:, None]).ravel())
    for k, wave in enumerate(string.waves):
        given = 0.5 * wave.tool.amplitude * np.interp(above_end, string.nodes, wave.q.real)
        each = zip(speeds[k], speeds[1 - k], strict=True)
        rates = np.array([0.5 * pressed * damping(0.05, one, other) * one for one, other in each])
        assert rates @ np.diff(string.edges) == pytest.approx(given, rel=2e-3)


# --- strings ---


def drawn_tool(seed: int, **changed: Any) -> fr.VibrationTool:
    """Return a tool of two frequencies."""
    rng = np.random.default_rng([58, seed])
    numbers = {
        "amplitude": rng.uniform(2e3, 8e3),
        "frequency": 2.0 * math.pi * rng.uniform(6.0, 20.0),
        "above_end": float(rng.choice([0.0, 30.0, 90.0])),
    }
    ratio = float(rng.choice([GOLDEN, math.sqrt(2.0), 2.0 + 1.0 / math.e]))
    numbers["second"] = (rng.uniform(1e3, 6e3), ratio * numbers["frequency"])
    return fr.VibrationTool(**{**numbers, **changed})


def mean_force(tool: fr.VibrationTool, bottom: float = 2400.0) -> fr.results.MeanForce:
    return TUBING.mean_force(WELL, 0.3, bottom=bottom, tool=tool, depth=[0.0, 1200.0, 2000.0])


@pytest.mark.parametrize("seed", [2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 1))])
def test_a_second_sine_that_does_not_push_changes_no_digit(seed: int) -> None:
    tool = drawn_tool(seed, second=None)
    quiet = drawn_tool(seed, second=(0.0, 1.7 * tool.frequency))
    assert mean_force(quiet) == mean_force(tool)
    only = drawn_tool(seed, amplitude=0.0)
    assert mean_force(only) == mean_force(fr.VibrationTool(*only.sines[1], tool.above_end))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_exchanged_sines_change_no_digit(seed: int) -> None:
    tool = drawn_tool(seed)
    (amplitude, frequency), other = tool.sines
    assert mean_force(fr.VibrationTool(*other, tool.above_end, second=(amplitude, frequency))) == mean_force(tool)


@pytest.mark.parametrize("seed", range(3))
def test_sines_of_one_frequency_add_as_vectors(seed: int) -> None:
    rng = np.random.default_rng([59, seed])
    tool = drawn_tool(seed, second=None)
    phase, amplitude = rng.uniform(0.0, 6.0), rng.uniform(1e3, 6e3)
    both = drawn_tool(seed, second=(amplitude, tool.frequency, phase))
    size = abs(tool.amplitude + amplitude * np.exp(1j * phase))
    one = mean_force(drawn_tool(seed, amplitude=size, second=None))
    np.testing.assert_allclose(mean_force(both).force, one.force, rtol=1e-9)


@pytest.mark.slow
def test_a_weak_second_sine_changes_little() -> None:
    tool = drawn_tool(0)
    weak = mean_force(drawn_tool(0, second=(1e-3, tool.sines[1][1])))
    one = mean_force(drawn_tool(0, second=None))
    np.testing.assert_allclose(weak.force, one.force, atol=weak.error + one.error)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_phase_between_free_frequencies_changes_no_digit(seed: int) -> None:
    tool = drawn_tool(seed)
    assert mean_force(drawn_tool(seed, second=(*tool.sines[1], 1.0))) == mean_force(tool)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_the_error_is_that_of_finer_cells(seed: int) -> None:
    """Friction is the mean direction under the waves of much finer cells, too."""
    from floquetrod.wells import strings

    tool = drawn_tool(100 + seed)
    found = mean_force(tool)
    drag = drag_of(TUBING, WELL, 0.3, "pushed", "energy", tool, 0.05)
    fine = strings.run(drag, 0.0, np.array([2400.0]), 0.0, found.depth, CHECKED[0]._replace(cells=96, soft=3e-5))
    assert fine.is_settled[0]
    np.testing.assert_allclose(found.force, drag.force(fine.y[:, 0]), atol=2.0 * found.error)
    assert found.error < 100.0


@pytest.mark.parametrize("seed", range(20))
def test_frequencies_whose_phases_lock_are_refused(seed: int) -> None:
    rng = np.random.default_rng([60, seed])
    over, under = rng.integers(1, 10, 2).tolist()
    tool = fr.VibrationTool(1e3, 100.0, second=(1e3, 100.0 * over / under * (1.0 + rng.uniform(-5e-6, 5e-6))))
    over, under = max(over, under) // math.gcd(over, under), min(over, under) // math.gcd(over, under)
    with pytest.raises(
        ValueError, match=rf"tool must have two frequencies whose phases are free, .* {over}/{under} of"
    ):
        mean_force(tool)
    free = fr.VibrationTool(1e3, 100.0, second=(1e3, 100.0 * over / under * 1.002))
    assert len(independent_sines(free)) == 2


def test_friction_of_locked_phases_beyond_those_refused_is_that_of_free_ones_to_a_twentieth() -> None:
    """Of drawn waves, at the ratios p/q with the smallest p + q that are not refused."""
    rng, angle = np.random.default_rng(61), 2.0 * math.pi * (np.arange(4000) + 0.5) / 4000
    for over, under in ((1, 20), (4, 17), (8, 13), (10, 11), (13, 17)):
        assert len(independent_sines(fr.VibrationTool(1.0, 1.0, second=(1.0, over / under)))) == 2
        for _ in range(40):
            v, one, other = drawn_speeds(rng)
            sign = direction(v, one, other, (under * angle, over * angle + rng.uniform(0.0, 2.0 * math.pi)))
            assert tool_wave.friction_share(v, one, other) == pytest.approx(sign.mean(), abs=0.05)


# --- reach ---


LEVEL = fr.WellPath.straight(length=400.0, inclination="90deg")


@pytest.mark.slow
def test_a_second_sine_lessens_the_push_and_lateral_waves_have_their_growth() -> None:
    tools = (fr.VibrationTool("5kN", "18Hz", "30m", second=second) for second in (None, ("3kN", "29Hz")))
    alone, found = (TUBING.reach(LEVEL, 0.3, tool=tool, depth=[400.0]) for tool in tools)
    assert 0.0 < found.injector_shaken[0] < 0.97 * alone.injector_shaken[0]
    lines = dict(found.report().lines)
    assert lines["waves"].startswith("no lateral wave grows; at ")
    assert alone.growth_error is None
    assert alone.as_dict()["growth_error_per_s"] is None
    assert lines["tool Hz"] == "not examined with a tool of two frequencies"
    assert lines["tool"].startswith("5 kN at 18 Hz and 3 kN at 29 Hz, 30 m above the lower end: ")
    assert any("phases of the tool's two frequencies" in each for each in found.assumptions)
    said = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert found.growth_error is not None
    assert (found.growth_error < 1e-3).all()
    assert said["growth_without_friction_per_s"] == found.growth_free.tolist()
    assert said["growth_error_per_s"] == found.growth_error.tolist()
    assert said["along"]["second_vibration_N"] == pytest.approx(found.along.second_vibration)
    assert 1.0 < found.growth_free.max() < 3.0
    assert (found.speed_to_grow > found.sliding).all()
    found.plot()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_exchanged_sines_grow_alike_and_a_faint_one_changes_nothing(seed: int) -> None:
    """A faint one to the errors, and to the grid of waves under one frequency."""
    tool = drawn_tool(300 + seed)
    (amplitude, frequency), other = tool.sines
    exchanged = fr.VibrationTool(*other, tool.above_end, second=(amplitude, frequency))
    both = [TUBING.reach(LEVEL, 0.3, tool=each, depth=[400.0]) for each in (tool, exchanged)]
    for name in ("growth", "growth_free", "growth_error", "speed_to_grow", "half_wave"):
        np.testing.assert_array_equal(*(getattr(each, name) for each in both))
    faint = fr.VibrationTool(amplitude, frequency, tool.above_end, second=(1e-3, other[1]))
    one, two = (TUBING.reach(LEVEL, 0.3, tool=replace(faint, second=s), depth=[400.0]) for s in (None, faint.second))
    assert two.growth_error is not None
    off = np.abs(two.growth_free - one.growth_free)
    assert (off <= two.growth_error + 3e-3 * one.growth_free + 1e-6).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_growth_at_a_depth_is_that_of_a_long_integration(seed: int) -> None:
    from tests.rod.answers.test_growth_of_two_sines import integrated

    rng = np.random.default_rng([62, seed])
    tool = drawn_tool(400 + seed)
    found = TUBING.reach(WELL, 0.3, tool=tool, depth=[3000.0])
    along = found.along
    assert found.growth_error is not None
    assert along.second_vibration is not None
    (_, slow), (_, fast) = independent_sines(tool)
    k = int(rng.choice(np.flatnonzero(found.growth_free > 0.3 * found.growth_free.max())))
    place = WellGeometry.at(WELL.arcs.at(along.depth[k : k + 1])), along.force[k : k + 1]
    sizes = np.array([along.vibration - along.second_vibration, along.second_vibration])[:, k : k + 1]
    expected = integrated(math.pi / found.half_wave[k], place, sizes, fast / slow, 0.0, slow=slow)
    assert found.growth_free[k] == pytest.approx(expected, abs=5e-3 + found.growth_error[k])


@pytest.mark.slow
def test_a_strong_tool_makes_waves_grow_where_friction_leaves_them() -> None:
    tool = fr.VibrationTool("5kN", "18Hz", "30m", second=("20kN", "29Hz"))
    found = TUBING.reach(LEVEL, 0.3, tool=tool, depth=[400.0])
    grows = found.growth > 0.0
    assert grows.any()
    assert (found.growth < found.growth_free)[grows].all()
    assert (found.speed_to_grow[grows] <= found.sliding).all()
    assert "lateral waves grow from" in dict(found.report().lines)["waves"]
    found.plot()


@pytest.mark.slow
def test_frequencies_far_apart_along_a_long_string_are_not_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    from floquetrod.rod.answers import string_reach

    monkeypatch.setattr(string_reach, "MOST_PLACES", 50.0)
    tool = fr.VibrationTool("5kN", "18Hz", "30m", second=("3kN", "29Hz"))
    found = TUBING.reach(LEVEL, 0.3, tool=tool, depth=[400.0])
    assert np.isnan(found.growth).all()
    assert np.isnan(found.growth_error).all()
    assert dict(found.report().lines)["waves"].startswith("not examined: ")
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["growth_per_s"][0] is None
    found.plot()


@pytest.mark.slow
def test_lateral_growth_is_that_of_the_one_sine_that_pushes() -> None:
    only = fr.VibrationTool(0.0, "3Hz", second=("8kN", "18Hz"))
    one = fr.VibrationTool("8kN", "18Hz")
    found, expected = (TUBING.reach(WELL, 0.3, tool=tool, depth=[3900.0]) for tool in (only, one))
    assert found.reach_shaken == expected.reach_shaken
    np.testing.assert_array_equal(found.growth_free, expected.growth_free)
    assert (expected.growth_free > 0.0).any()


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(4), 1, 1))
def test_the_doors_agree(seed: int, tmp_path: Path) -> None:
    """Python, the terminal and the mean force just before and beyond the depth reached."""
    tool = drawn_tool(200 + seed)
    (amplitude, frequency), (second, faster) = tool.sines
    survey = tmp_path / "survey.csv"
    survey.write_text("MD (m), Inc (deg), Azi (deg)\n0,0,0\n1000,0,0\n1450,90,0\n5000,90,0\n")
    well = fr.WellPath.from_csv(survey)
    found = TUBING.reach(well, 0.3, tool=tool, depth=[5000.0])
    for off, is_locked in ((-2.0, False), (2.0, True)):
        there = TUBING.mean_force(well, 0.3, bottom=found.reach_shaken + off, tool=tool, depth=[0.0])
        assert (there.is_locked or math.isinf(there.error)) == is_locked
    words = ["reach", "--well", str(survey), "--rod", "2.00x0.156", "--bore", "4.778in", "--friction", "0.3"]
    words += ["--fluid-inside", "1000kg/m3", "--fluid-outside", "1000kg/m3", "--depths", "5000m"]
    words += ["--tool", f"{amplitude!r}N@{frequency!r}rad/s@{tool.above_end!r}m+{second!r}N@{faster!r}rad/s"]
    with contextlib.redirect_stdout(io.StringIO()) as said:
        assert cli.main([*words, "--json"]) == 0
    answer = json.loads(said.getvalue())
    assert answer["reach_with_tool_m"] == pytest.approx(found.reach_shaken, rel=1e-9)
    for name, values in (
        ("growth_without_friction_per_s", found.growth_free),
        ("growth_error_per_s", found.growth_error),
    ):
        np.testing.assert_allclose(answer[name], values, rtol=1e-6, atol=1e-9)
    assert answer["tool"]["second"] == pytest.approx([second, faster], rel=1e-12)


def test_the_report_has_the_tool(tmp_path: Path) -> None:
    tool = fr.VibrationTool("5kN", "18Hz", "30m", second=("3kN", "29Hz", "90deg"))
    assert tool == eval(repr(tool), {"VibrationTool": fr.VibrationTool})
    assert "5 kN at 18 Hz and 3 kN at 29 Hz, 1.571 rad ahead, 30 m" in tool._at_hand().headline


@pytest.mark.kernels
def test_two_waves_beside_each_other_leave_one_mean_friction() -> None:
    tool = fr.VibrationTool("8kN", "18Hz", second=("5kN", "29Hz"))
    drag = drag_of(TUBING, WELL, 0.3, "pushed", "energy", tool, 0.05)
    assert drag.shaking is not None
    string = ShakenString(drag, drag.shaking, 0.0, 600.0, 0.0, FAST._replace(cells=6))
    for wave in string.waves:
        wave.q[:] = np.linspace(0.4, 0.0, wave.q.size)
    left = np.empty(string.waves[0].balance.left.size)
    shaken_march.friction_left(string.waves, left)
    depth = 600.0 - 0.5 * (string.edges[1:] + string.edges[:-1])
    np.testing.assert_allclose(string.wave_at(depth)[2], left, rtol=1e-9)
