"""The axial wave of a tool along a string: closed forms, its energy, and turns between wave and force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.wells import strings
from floquetrod.wells.drag import CHECKED, FAST, TRIED, Fineness
from floquetrod.wells.kernels import shaken_march, tool_wave
from floquetrod.wells.kernels.wall_contact import LOCKED
from floquetrod.wells.shaken_string import ShakenString
from tests.inside import drag_of
from tests.seams import Tuned

TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
WEIGHT = TUBING.weight_per_length
IMPEDANCE = TUBING.mass_along * TUBING.wave_speed
LEVEL = 0.5 * math.pi
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 5000.0], ["0deg", "0deg", "90deg", "90deg"])


def shaken_string(
    tool: fr.VibrationTool, friction: object, bottom: float, effort: Fineness, speed: float = 0.05
) -> ShakenString:
    """Return a string in `WELL` that has not settled yet."""
    drag = drag_of(TUBING, WELL, friction, "pushed", "energy", tool, speed)
    assert drag.shaking is not None
    return ShakenString(drag, drag.shaking, 0.0, bottom, 0.0, effort)


@pytest.mark.parametrize(("above_end", "frequency"), [(0.0, "18Hz"), (30.0, "18Hz"), (170.0, "7Hz"), (299.0, "40Hz")])
def test_without_friction_it_stands_between_a_free_and_a_held_end(above_end: float, frequency: str) -> None:
    """From the lower end up cos k x below the tool, sin k (L - x) above, and at the tool the force falls by its own."""
    length, tool = 300.0, fr.VibrationTool("5kN", frequency, above_end)
    path = fr.WellPath.straight(length=length, inclination=LEVEL)
    found = TUBING.mean_force(path, 0.0, tool=tool, speed=1e-9, depth=np.linspace(0.0, length, 61))
    k, x = tool.frequency / TUBING.wave_speed, length - found.depth
    below, scale = x < above_end, tool.amplitude / abs(math.cos(k * length))
    sine, cosine = np.sin(k * (length - x)), np.cos(k * (length - x))
    ends = math.sin(k * (length - above_end)), math.cos(k * above_end)
    speed = np.abs(np.where(below, ends[0] * np.cos(k * x), ends[1] * sine)) * scale
    force = np.abs(np.where(below, ends[0] * np.sin(k * x), ends[1] * cosine)) * scale
    smooth = abs(x - above_end) > 1e-6
    np.testing.assert_allclose(IMPEDANCE * found.speed, speed, atol=2e-5 * speed.max())
    np.testing.assert_allclose(found.vibration[smooth], force[smooth], atol=2e-5 * speed.max())


@pytest.mark.parametrize("frequency", ["7Hz", "18Hz", "40Hz"])
@pytest.mark.parametrize("bottom", [300.0, 1000.0])
def test_viscous_damping_takes_from_it_what_the_closed_form_says(frequency: str, bottom: float) -> None:
    """It is cos k x and sin k (L - x) with k^2 = (w^2 - 2 i c w) / c_0^2."""
    tool, damped = fr.VibrationTool("5kN", frequency), TUBING.replace(damping_rate=8.0)
    path = fr.WellPath.straight(length=bottom, inclination=LEVEL)
    found = damped.mean_force(path, 0.0, tool=tool, speed=1e-9, depth=np.linspace(0.0, bottom, 61))
    w, c = tool.frequency, TUBING.wave_speed
    k = complex(w * w, -2.0 * 8.0 * w) ** 0.5 / c
    speed = tool.amplitude * abs(w / (c * k)) * np.abs(np.sin(k * found.depth) / np.cos(k * bottom)) / IMPEDANCE
    force = tool.amplitude * np.abs(np.cos(k * found.depth) / np.cos(k * bottom))
    np.testing.assert_allclose(found.speed, speed, atol=2e-3 * speed.max())
    np.testing.assert_allclose(found.vibration[:-1], force[:-1], atol=2e-3 * force.max())


def test_a_tool_that_does_not_push_changes_no_digit() -> None:
    one, other = (
        TUBING.mean_force(WELL, 0.3, bottom=2500.0, depth=[0.0, 1200.0], tool=each)
        for each in (None, fr.VibrationTool(0.0, 100.0))
    )
    assert one == other


@pytest.mark.slow
def test_along_a_long_string_it_falls_on_a_straight_line() -> None:
    """V' = (2 / pi) mu N / Z where the string slides slowly: what comes from the upper end is as slow as that."""
    path, tool = fr.WellPath.straight(length=3000.0, inclination=LEVEL), fr.VibrationTool("4kN", "18Hz")
    found = TUBING.mean_force(path, 0.2, tool=tool, speed=1e-4)
    start, fall = tool.amplitude / IMPEDANCE, 2.0 / math.pi * 0.2 * WEIGHT / IMPEDANCE
    expected = start - fall * (3000.0 - found.depth)
    moves = expected > 0.1 * start
    assert 50 < moves.sum() < 0.8 * moves.size
    np.testing.assert_allclose(found.speed[moves], expected[moves], atol=0.03 * start)
    assert (found.speed[expected < -0.05 * start] < 2e-4).all()


@pytest.mark.kernels
@pytest.mark.parametrize("above_end", [0.0, 30.0, 200.0])
def test_friction_takes_what_the_tool_gives(above_end: float) -> None:
    """Half the force times the velocity in phase with it, and mu N (2 / pi) sqrt(V^2 - v^2) of every metre."""
    speed, tool = 0.05, fr.VibrationTool("8kN", "18Hz", above_end)
    string = shaken_string(tool, 0.2, 2000.0, FAST._replace(cells=24), speed)
    ends = np.linspace(0.0, 2000.0, 4001)
    pressed = 0.2 * WEIGHT * (1.0 + 0.5 * np.sin((2000.0 - ends[:-1]) / 100.0))
    (wave,) = string.waves
    shaken_march.means(ends, pressed, string.edges, wave.balance.most)
    wave.balance.most[:] *= 4.0 / math.pi * np.diff(string.edges)
    assert tool_wave.find_waves(string.waves, string.soft)
    tool_speed = np.interp(above_end, string.nodes, wave.q.real)
    found = string.wave_at(2000.0 - 0.5 * (ends[1:] + ends[:-1]))[0]
    taken = np.sum(pressed * 2.0 / math.pi * np.sqrt(np.maximum(found**2 - speed**2, 0.0))) * 0.5
    assert taken == pytest.approx(0.5 * tool.amplitude * tool_speed, rel=5e-4)


@pytest.mark.kernels
@pytest.mark.parametrize("second", [None, pytest.param(("6kN", "29Hz"), marks=pytest.mark.slow)])
def test_interpreted_and_compiled_strings_agree(second: tuple[str, str] | None) -> None:
    tool = fr.VibrationTool("20kN", "18Hz", 30.0, second=second)
    strings = [shaken_string(tool, 0.3, 1700.0, TRIED) for _ in range(2)]
    for string, run in zip(strings, (shaken_march.settle, compiled(shaken_march.settle)), strict=True):
        string.marched.y[0] = 1.0
        found = string.sliding, string.pieces, string.waves, string.edges
        assert run(*found, string.soft, 1e-7, 30, string.marched)
        assert 0 < string.marched.helix.sum() < string.marched.helix.size
    np.testing.assert_allclose(strings[0].marched.y, strings[1].marched.y, atol=1e-12)
    for one, other in zip(strings[0].waves, strings[1].waves, strict=True):
        np.testing.assert_allclose(one.q, other.q, rtol=1e-9, atol=1e-9)


@pytest.mark.kernels
def test_means_between_other_edges_keep_the_sum() -> None:
    edges, to = np.array([0.0, 1.0, 1.5, 4.0]), np.array([0.0, 0.25, 2.0, 2.1, 4.0])
    values, out = np.array([3.0, -2.0, 5.0]), np.empty(4)
    shaken_march.means(edges, values, to, out)
    np.testing.assert_allclose(out, [3.0, (0.75 * 3.0 - 0.5 * 2.0 + 0.5 * 5.0) / 1.75, 5.0, 5.0], rtol=1e-14)
    assert out @ np.diff(to) == pytest.approx(values @ np.diff(edges), rel=1e-14)


def test_a_string_is_what_it_is_beside_others() -> None:
    drag = drag_of(
        TUBING, WELL, [(0, 0.2), (1450.0 + 1e-13, 0.3)], "pushed", "energy", fr.VibrationTool("8kN", 99.0), 0.05
    )
    bottoms = np.array([700.0, 1450.0, 2500.0, 3900.0])
    frequency = np.array([50.0, 110.0, 70.0, 200.0])
    assert drag.shaking is not None

    def run(some: slice) -> strings.Run:
        other = replace(drag, shaking=replace(drag.shaking, frequency=frequency[some]))
        return strings.run(other, 0.0, bottoms[some], 0.0, np.array([0.0, 600.0]), TRIED)

    together = run(slice(None))
    for k in range(bottoms.size):
        alone = run(slice(k, k + 1))
        assert (alone.top_y[0], alone.is_settled[0]) == (together.top_y[k], together.is_settled[k])
        np.testing.assert_array_equal(alone.y[:, 0], together.y[:, k])
        np.testing.assert_array_equal(alone.wave[..., 0], together.wave[..., k])


@pytest.mark.slow
@pytest.mark.parametrize(("frequency", "above_end"), [("9Hz", 0.0), ("18Hz", 30.0), ("18Hz", 200.0), ("25Hz", 200.0)])
def test_forces_from_above_and_from_below_meet(frequency: str, above_end: float) -> None:
    tool = fr.VibrationTool("8kN", frequency, above_end)
    drag = drag_of(TUBING, WELL, 0.3, "pushed", "energy", tool, 0.05)
    bottoms = np.array([2000.0, 3250.0, 4000.0])
    runs = [strings.run(drag, 0.0, bottoms, 0.0, np.empty(0), FAST._replace(share=share)) for share in (1.0, 0.0)]
    assert all(run.is_settled[:2].all() and run.top_y[2] >= LOCKED for run in runs)
    np.testing.assert_allclose(runs[0].top_y, runs[1].top_y, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("frequency", "above_end"), [("9Hz", 0.0), ("18Hz", 30.0), ("25Hz", 200.0)])
@pytest.mark.parametrize("bottom", [1700.0, 2500.0, 3100.0])
def test_the_error_is_that_of_the_wave(frequency: str, above_end: float, bottom: float) -> None:
    tool = fr.VibrationTool("8kN", frequency, above_end)
    found = TUBING.mean_force(WELL, 0.3, bottom=bottom, tool=tool, depth=np.linspace(0.0, bottom, 100))
    drag = drag_of(TUBING, WELL, 0.3, "pushed", "energy", tool, 0.05)
    fine = strings.run(drag, 0.0, np.array([bottom]), 0.0, found.depth, CHECKED[0]._replace(cells=96, soft=3e-5))
    assert 0.0 < found.error < 100.0
    np.testing.assert_allclose(found.force, drag.force(fine.y[:, 0]), atol=2.0 * found.error)


def test_what_has_not_settled_is_said(tuned: Tuned) -> None:
    tool = fr.VibrationTool("8kN", "18Hz", 30.0)
    tuned(rounds_of_a_shaken_string=2)
    assert math.isinf(TUBING.mean_force(WELL, 0.3, bottom=2500.0, tool=tool, depth=[0.0]).error)


@pytest.mark.slow
def test_a_string_that_has_not_settled_is_taken_as_stopped(tuned: Tuned) -> None:
    tool = fr.VibrationTool("8kN", "18Hz", 30.0)
    assert np.isfinite(TUBING.reach(WELL, 0.3, tool=tool, depth=[2500.0]).injector_shaken[0])
    tuned(rounds_of_a_shaken_string=2)
    cut = TUBING.reach(WELL, 0.3, tool=tool, depth=[2500.0])
    assert np.isinf(cut.injector_shaken[0])
    assert cut.is_stopped_shaken
