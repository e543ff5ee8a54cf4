"""The mean force along a string in a well: closed forms, symmetries, and what a tool leaves of friction."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from benchmarks import drag
from floquetrod.wells import strings
from floquetrod.wells.drag import CHECKED, FAST, SOUGHT
from tests.conftest import depth
from tests.inside import drag_of

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")

TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
WEIGHT = TUBING.weight_per_length
IMPEDANCE = TUBING.mass_along * TUBING.wave_speed


def arc_force(path: fr.WellPath, depth: np.ndarray, mu: float, far_force: float) -> np.ndarray:
    """Return the force along an arc in a vertical plane, with the string on its low side: shared by the theory page."""
    kappa = path.curvature(path.start)[0]
    a, b = (1.0 - mu**2) / (1.0 + mu**2), 2.0 * mu / (1.0 + mu**2)
    phi, end = path.inclination_at(depth), path.inclination_at(path.end)

    def steady(angle: np.ndarray) -> np.ndarray:
        return WEIGHT / kappa * (a * np.sin(angle) + b * np.cos(angle))

    return (far_force - steady(end)) * np.exp(mu * (end - phi)) + steady(phi)


@pytest.mark.parametrize("mu", [0.3, *(pytest.param(mu, marks=pytest.mark.slow) for mu in (0.0, 1.0))])
@pytest.mark.parametrize("ends", [(0.3, 1.2), (0.1, math.pi / 2.0), (1.5, 0.8)])
@pytest.mark.parametrize("motion", ["pushed", "pulled"])
def test_along_an_arc_the_force_is_the_closed_form(mu: float, ends: tuple[float, float], motion: str) -> None:
    path = fr.WellPath.arc(length=300.0, inclination=ends, depth=700.0)
    found = TUBING.mean_force(
        path, mu, motion=motion, far_force=500.0, depth=np.linspace(700.0, 1000.0, 9), helical="alone"
    )
    expected = arc_force(path, found.depth, mu if motion == "pushed" else -mu, 500.0)
    lying = WEIGHT * np.sin(path.inclination_at(found.depth)) + expected * path.curvature(found.depth)[0]
    on_low_side = np.flip(np.cumprod(np.flip(lying > 0.0))).astype(bool)
    assert on_low_side.sum() > 2
    kept = on_low_side & ~found.is_helix
    size = np.abs(expected).max()
    np.testing.assert_allclose(found.force[kept], expected[kept], rtol=0.0, atol=1e-10 * size)
    np.testing.assert_allclose(found.contact[kept], lying[kept], rtol=0.0, atol=1e-10 * WEIGHT)
    assert found.error < 1e-7 * size


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arc", pytest.param("S", marks=pytest.mark.slow), "turn"])
def test_from_station_to_station_others_come_to_it_with_the_first_order(name: str) -> None:
    """The method of torque-and-drag codes (SPE 11380), three times as good with stations three times as close."""
    off = []
    for apart in (30.0, 10.0):
        path = drag.path(name, apart)
        found = drag.TUBING.mean_force(path, drag.FRICTION, motion="pulled", depth=[0.0])
        off.append(drag.johancsik(path, "pulled") + found.at_top)
    assert off[0] / off[1] == pytest.approx(3.0, abs=0.1)
    assert abs(off[1]) < 0.002 * abs(found.at_top)


@pytest.mark.parametrize("inclination", [90.0, 75.0, 40.0])
@pytest.mark.parametrize("far_force", [-3000.0, 0.0, 800.0])
def test_in_a_straight_well_it_is_lock_up(inclination: float, far_force: float) -> None:
    rod = TUBING.replace(inclination=math.radians(inclination))
    expected = rod.lock_up(0.3, far_force)
    length = 1200.0
    path = fr.WellPath.straight(length=length, inclination=math.radians(inclination))
    found = TUBING.mean_force(path, 0.3, far_force=far_force, helical="always", depth=np.linspace(0.0, length, 9))
    np.testing.assert_allclose(found.force, expected.force(length - found.depth), rtol=1e-9)


def test_a_straight_well_locks_up_where_lock_up_says() -> None:
    reach = TUBING.lock_up(0.3).length
    for factor, is_locked in ((1.0 - 1e-9, False), (1.0 + 1e-9, True)):
        path = fr.WellPath.straight(length=factor * reach, inclination=math.pi / 2.0)
        found = TUBING.mean_force(path, 0.3, helical="always")
        assert found.is_locked == is_locked
        assert np.isinf(found.force).any() == is_locked


@st.composite
def wells(draw: st.DrawFn) -> fr.WellPath:
    """Draw a well that bends and turns."""
    stations = draw(st.lists(st.tuples(st.floats(0.05, 2.0), st.floats(-1.0, 1.0)), min_size=2, max_size=4))
    inclination, azimuth = np.array(stations).T
    return fr.WellPath(100.0 + 200.0 * np.arange(len(stations)), inclination, azimuth)


def test_a_helix_that_comes_and_goes_between_stations_is_found_with_any_step() -> None:
    """One that begins to rounding where a step does, and one that begins and ends within a step."""
    path = fr.WellPath(
        [113.05613442, 466.45597334, 965.83981662, 1182.94008491, 1428.18642961],
        [0.72567502, 1.00633654, 0.17936921, 1.6560107, 1.27392006],
        [-0.40061225, -0.84490686, 0.5263619, -0.73784202, -0.73358672],
    )
    friction = [(0.0, 0.040631155557995235), (566.345924757363, 0.16154657980403428)]
    found = drag_of(TUBING, path, friction, "pushed", "loading", None, 0.05)
    bottoms = path.end - np.linspace(0.0, 3e-9, 13)
    for effort in (CHECKED[1]._replace(tolerance=1e-11, steps=3), FAST, SOUGHT):
        force = found.force(strings.run(found, path.start, bottoms, 14983.829300062029, np.empty(0), effort).top_y)
        np.testing.assert_allclose(force, -5454.0844, atol=0.02)


@pytest.mark.slow
@settings(max_examples=depth(60, 3))
@given(path=wells(), mu=st.floats(0.05, 0.5), far_force=st.floats(-1e4, 2e4))
def test_turning_to_the_other_side_changes_nothing(path: fr.WellPath, mu: float, far_force: float) -> None:
    other = fr.WellPath(path.depth, path.inclination, -path.azimuth)
    one, mirrored = (TUBING.mean_force(each, mu, far_force=far_force, depth=each.stations) for each in (path, other))
    np.testing.assert_allclose(one.force, mirrored.force, rtol=1e-9, atol=1e-6)


@pytest.mark.slow
@settings(max_examples=depth(60, 3))
@given(path=wells(), far_force=st.floats(-1e4, 5e3))
def test_a_string_is_the_sum_of_its_parts(path: fr.WellPath, far_force: float) -> None:
    middle = 0.4 * path.start + 0.6 * path.end
    whole = TUBING.mean_force(path, 0.2, far_force=far_force, depth=[middle])
    lower = TUBING.mean_force(path.part(middle, path.end), 0.2, far_force=far_force)
    if lower.is_locked:
        assert whole.is_locked
        return
    upper = TUBING.mean_force(path.part(path.start, middle), 0.2, far_force=lower.at_top)
    assert lower.at_top == pytest.approx(whole.force[1], rel=1e-8, abs=1e-5)
    assert upper.at_top == pytest.approx(whole.at_top, rel=1e-6, abs=1e-3)


def test_a_standing_string_carries_its_weight_and_no_more() -> None:
    path = fr.WellPath([0.0, 500.0, 900.0, 1500.0], [0.0, 0.1, 1.4, 1.6], [0.0, 1.0, 2.0, 2.5])
    found = TUBING.mean_force(path, 0.3, motion="standing", far_force=300.0, depth=path.stations)
    drop = path.position(path.end)[2] - path.position(path.stations)[:, 2]
    np.testing.assert_allclose(found.force, 300.0 - WEIGHT * drop, rtol=1e-9)


def test_friction_by_interval_is_that_of_each_part() -> None:
    path = fr.WellPath.straight(length=600.0, inclination=1.3)
    found = TUBING.mean_force(path, [(0, 0.1), ("200m", 0.4)], depth=[200.0])
    across, along = WEIGHT * math.sin(1.3), WEIGHT * math.cos(1.3)
    lower = 400.0 * (0.4 * across - along)
    np.testing.assert_allclose(found.force, [lower + 200.0 * (0.1 * across - along), lower, 0.0], rtol=1e-11, atol=1e-7)
    np.testing.assert_array_equal(found.friction, [0.1, 0.4, 0.4])


@pytest.mark.parametrize(
    ("kappa", "force"), [(0.0, 1.6960285886), (0.002, 1.7186134), (0.01, 1.8119169), (0.05, 2.3472859)]
)
def test_a_string_snakes_from_the_static_limit_on(kappa: float, force: float) -> None:
    """The truth of the static limit where the well builds, F = 2 E I (k + sqrt(k^2 + q / E I))."""
    rod = fr.Rod.nitinol()
    path = fr.WellPath.arc(length=2e-4, inclination=(math.pi / 2.0 - 2e-4 * kappa, math.pi / 2.0))
    for factor, is_snaking in ((1.0 - 1e-7, False), (1.0 + 1e-7, True)):
        found = rod.mean_force(path, far_force=factor * force, depth=path.stations)
        assert found.is_snaking[-1] == is_snaking
        helix = 2.0 * rod.flexural_rigidity * (kappa + math.sqrt(kappa**2 + 0.0)) / rod.radial_clearance
        assert not found.is_helix[-1] or helix > force


def test_a_helix_needs_more_by_every_criterion_and_presses_with_f_squared() -> None:
    path = fr.WellPath.straight(length=1.0, inclination=math.pi / 2.0)
    for name, ratio in (("energy", math.sqrt(2.0)), ("loading", 1.83), ("alone", math.sqrt(8.0)), ("always", 0.01)):
        for factor in (0.999, 1.001):
            force = factor * ratio * TUBING.critical_force
            found = TUBING.mean_force(path, 0.2, far_force=force, helical=name, depth=[0.5])
            is_helix = factor > 1.0 or name == "always"
            more = force**2 * TUBING.radial_clearance / (4.0 * TUBING.flexural_rigidity)
            assert found.is_helix[-1] == is_helix
            assert found.contact[-1] == pytest.approx(WEIGHT + is_helix * more, rel=1e-12)


def left_of_friction(distance: float, mu: float, speed: float, source: float) -> float:
    """Return the force in N that friction takes over a distance from a tool, in a level hole, in closed form."""
    start = math.sqrt(source**2 - speed**2)
    fall = 2.0 * mu * WEIGHT / (math.pi * IMPEDANCE)
    reach = start / fall
    near = min(distance, reach)

    def primitive(wave: float) -> float:
        return wave * math.atan2(speed, wave) + 0.5 * speed * math.log(speed**2 + wave**2)

    shaken = 2.0 / math.pi * (primitive(start) - primitive(start - fall * near)) / fall
    return mu * WEIGHT * (shaken + max(0.0, distance - reach))


@pytest.mark.parametrize(("frequency", "within"), [("18Hz", 3e-3), pytest.param("72Hz", 3e-4, marks=pytest.mark.slow)])
@pytest.mark.parametrize("distance", [200.0, 700.0])
def test_a_wave_that_ends_before_it_is_reflected_obeys_the_closed_form(
    distance: float, frequency: str, within: float
) -> None:
    """That of a wave that runs one way, which changes little along its length: the shorter it is the better."""
    path = fr.WellPath.straight(length=3000.0, inclination=math.pi / 2.0)
    tool, speed = fr.VibrationTool("5kN", frequency), 1e-3
    found = TUBING.mean_force(path, 0.2, tool=tool, speed=speed, depth=[3000.0 - distance])
    expected = left_of_friction(distance, 0.2, speed, 5000.0 / IMPEDANCE)
    assert found.force[1] == pytest.approx(expected, rel=within)
    assert found.speed[-1] == pytest.approx(5000.0 / IMPEDANCE, rel=within)


RESONANCES = [  # length, times a quarter wave, share of that frequency, friction, force, speed, tool above, damping
    (2119.517556545945, 7, 1.01, 0.3, 599.574077550054, 0.0018629148731677126, 0.0, 0.05),
    (620.7825073055494, 7, 0.999, 0.3, 289.25735988712773, 0.0012706987483227141, 0.0, 0.0),
]


def drawn_resonance(seed: int) -> tuple[float, ...]:
    """Return a level string and a tool next to an axial resonance, as in `RESONANCES`."""
    rng = np.random.default_rng([19, seed])
    near = float(rng.choice([1.0, 1.0001, 1.001, 1.01, 0.99, 0.999]))
    wave = float(rng.uniform(200.0, 3000.0)), 2.0 * float(rng.integers(0, 4)) + 1.0, near
    pushed = float(rng.choice([0.002, 0.02, 0.1, 0.3])), 10.0 ** rng.uniform(2.0, 4.0), 10.0 ** rng.uniform(-3.0, -1.0)
    return *wave, *pushed, float(rng.choice([0.0, 30.0])), float(rng.choice([0.0, 0.05]))


@pytest.mark.parametrize(
    ("cases", "is_drawn"),
    [
        pytest.param(RESONANCES[:1], False, marks=pytest.mark.slow),
        (RESONANCES[1:], False),
        pytest.param([drawn_resonance(seed) for seed in range(depth(36, 12))], True, marks=pytest.mark.slow),
    ],
)
def test_next_to_an_axial_resonance_the_speed_is_that_of_much_finer_cells(
    cases: list[tuple[float, ...]], is_drawn: bool
) -> None:
    """Where friction is hardly more than what the tool gives, and the wave hardly faster than the string slides."""
    for length, quarters, near, mu, force, speed, above, damping in cases:
        frequency = 0.5 * math.pi * quarters * TUBING.wave_speed / length * near
        path, rod = fr.WellPath.straight(length=length, inclination="90deg"), TUBING.replace(damping_rate=damping)
        tool, depths = fr.VibrationTool(force, frequency, above), np.linspace(0.0, length, 101)
        found = rod.mean_force(path, mu, tool=tool, speed=speed, depth=depths)
        drag = drag_of(rod, path, mu, "pushed", "energy", tool, speed)
        effort = CHECKED[0]._replace(cells=144, soft=1e-8)
        fine = strings.run(drag, 0.0, np.array([length]), 0.0, depths, effort)
        if is_drawn and not (fine.is_settled[0] and math.isfinite(found.speed_error)):
            continue  # about to lock up
        largest, off = found.speed.max(), np.abs(fine.wave[0, :, 0] - found.speed).max()
        assert off < max(found.speed_error, 1e-4 * largest)
        assert is_drawn or off < found.speed_error < 0.02 * largest


def test_the_law_of_friction_is_the_mean_over_a_period() -> None:
    """Coulomb friction against v + V cos: (2 / pi) asin(v / V) on average, and (2 / pi) sqrt(V^2 - v^2) with V cos."""
    phase = 2.0 * math.pi * (np.arange(200_000) + 0.5) / 200_000
    speed, size = 0.3, 0.8
    sign = np.sign(speed + size * np.cos(phase))
    wave = math.sqrt(size**2 - speed**2)
    assert sign.mean() == pytest.approx(2.0 / math.pi * math.atan2(speed, wave), abs=1e-5)
    assert (sign * size * np.cos(phase)).mean() == pytest.approx(2.0 / math.pi * wave, abs=1e-5)


def test_a_tool_above_the_hole_or_slower_than_the_string_does_nothing() -> None:
    path = fr.WellPath.straight(length=300.0, inclination=1.4)
    still = TUBING.mean_force(path, 0.2)
    for tool, speed in ((fr.VibrationTool(5e3, 100.0, 400.0), 0.01), (fr.VibrationTool(5e3, 100.0), 2.0)):
        assert TUBING.mean_force(path, 0.2, tool=tool, speed=speed).at_top == pytest.approx(still.at_top, rel=1e-9)


def test_what_it_says() -> None:
    path = fr.WellPath([0.0, 1000.0, 1450.0, 3000.0], ["0deg", "0deg", "90deg", "90deg"])
    found = TUBING.mean_force(path, 0.3)
    assert repr(found).startswith("<string pushed to 3000 m locks up at ")
    assert json.loads(json.dumps(found.as_dict(), allow_nan=False))["force_N"][0] is None
    assert "helix" in str(found.report())
    assert found == TUBING.mean_force(path, 0.3)
    assert repr(TUBING.mean_force(path, 0.3, motion="pulled")).startswith(
        "<string pulled to 3000 m needs 77.2 kN of pull"
    )


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"friction": -0.1}, "friction must be zero or more"),
        ({"friction": [(100, 0.2)]}, "friction must begin at depth 0"),
        ({"friction": [(0, 0.2), (0, 0.3)]}, "friction must begin at depth 0 and continue"),
        ({"friction": [0.2, 0.3]}, r"friction\[0\] must be a depth and a coefficient"),
        ({"motion": "push"}, "motion must be one of.*did you mean pushed"),
        ({"helical": "often"}, "helical must be one of"),
        ({"bottom": 4000.0}, "bottom must lie below 0 and not below 300 m"),
        ({"bottom": "4 parsec"}, "bottom must be a number with"),
        ({"depth": [100.0, 400.0]}, "depth must lie from 0 m to bottom = 300 m, got 400 m"),
        ({"far_force": "5 km"}, "far_force must be a number with a force unit"),
        ({"tool": "5kN"}, "tool must be a VibrationTool"),
        ({"tool": fr.VibrationTool(1.0, 1.0), "speed": 0.0}, "speed must"),
        ({"path": "survey.csv"}, "path must be a WellPath.*from_csv"),
    ],
)
def test_bad_input_is_refused(wrong: dict, words: str) -> None:
    path = fr.WellPath.straight(length=300.0, inclination=1.4)
    with pytest.raises((TypeError, ValueError), match=words):
        TUBING.mean_force(**{"path": path, "friction": 0.2, **wrong})
