"""The path of a well: arcs between stations, against closed forms, and surveys that are none."""

from __future__ import annotations

import math
import pickle
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")


@st.composite
def paths(draw: st.DrawFn) -> fr.WellPath:
    """Draw a path of up to seven stations, whose directions change by less than half a turn."""
    steps = draw(st.lists(st.tuples(st.floats(1.0, 60.0), st.floats(-1.0, 1.0), st.floats(-1.2, 1.2)), min_size=1))[:6]
    start = draw(st.floats(0.0, 5000.0)), draw(st.floats(0.0, math.pi)), draw(st.floats(-3.0, 3.0))
    stations = start + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    folded = np.abs((stations[:, 1] + math.pi) % (2.0 * math.pi) - math.pi)
    return fr.WellPath(stations[:, 0], np.clip(folded, 0.0, math.pi), stations[:, 2])


def tangent(path: fr.WellPath, depth: np.ndarray) -> np.ndarray:
    """Return the direction of the path from its angles."""
    phi, psi = path.inclination_at(depth), path.azimuth_at(depth)
    return np.stack([np.sin(phi) * np.cos(psi), np.sin(phi) * np.sin(psi), np.cos(phi)], axis=-1)


def normals(path: fr.WellPath, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions in which curvatures kappa_n and kappa_b bend the path."""
    phi, psi = path.inclination_at(depth), path.azimuth_at(depth)
    upwards = np.stack([np.cos(phi) * np.cos(psi), np.cos(phi) * np.sin(psi), -np.sin(phi)], axis=-1)
    return upwards, np.stack([-np.sin(psi), np.cos(psi), 0.0 * psi], axis=-1)


def test_a_plane_arc_is_the_circle() -> None:
    path = fr.WellPath.arc(length=450.0, inclination=("0deg", "90deg"), azimuth=0.7, depth=1000.0)
    s = np.linspace(1000.0, 1450.0, 31)
    radius, turned = 900.0 / math.pi, (s - 1000.0) / 450.0 * math.pi / 2.0
    out = radius * (1.0 - np.cos(turned))
    expected = np.stack([out * math.cos(0.7), out * math.sin(0.7), radius * np.sin(turned)], axis=-1)
    np.testing.assert_allclose(path.position(s), expected, rtol=0.0, atol=1e-12 * 450.0)
    np.testing.assert_allclose(path.inclination_at(s), turned, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(path.curvature(s)[0], 1.0 / radius, rtol=1e-13)
    np.testing.assert_array_equal(path.curvature(s)[1], 0.0)
    np.testing.assert_allclose(path.azimuth_at(s), 0.7, rtol=0.0, atol=0.0)


def test_a_level_turn_is_the_circle_seen_from_above() -> None:
    path = fr.WellPath([0.0, 100.0], math.pi / 2.0, [0.0, 1.0])
    s = np.linspace(0.0, 100.0, 11)
    expected = np.stack([100.0 * np.sin(s / 100.0), 100.0 * (1.0 - np.cos(s / 100.0)), 0.0 * s], axis=-1)
    np.testing.assert_allclose(path.position(s), expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(path.azimuth_at(s), s / 100.0, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(path.curvature(s), np.broadcast_to([[0.0], [0.01]], (2, 11)), rtol=0.0, atol=1e-16)


def test_an_arc_over_the_vertical_turns_the_azimuth_round() -> None:
    path = fr.WellPath([0.0, 100.0], ["10deg", "10deg"], ["0deg", "180deg"])
    np.testing.assert_allclose(path.dogleg_severity, 6.0, rtol=1e-14)
    assert path.inclination_at(50.0) < 1e-15
    np.testing.assert_allclose(path.azimuth_at([0.0, 25.0, 75.0, 100.0]), [0.0, 0.0, math.pi, math.pi], atol=1e-14)
    np.testing.assert_allclose(path.position(100.0)[:2], 0.0, atol=1e-14)


@given(path=paths())
def test_the_direction_is_the_slope_of_the_position_and_curvature_that_of_the_direction(path: fr.WellPath) -> None:
    step = 1e-3
    middle = 0.5 * (path.depth[1:] + path.depth[:-1])
    up, down = middle - step, middle + step
    slope = (path.position(down) - path.position(up)) / (2.0 * step)
    sharpest = np.radians(path.dogleg_severity / 30.0)
    rounding = 1e-15 * (1.0 + path.end) / step
    assert (np.abs(slope - tangent(path, middle)).max(axis=-1) <= sharpest**2 * step**2 + rounding).all()
    bend = (tangent(path, down) - tangent(path, up)) / (2.0 * step)
    build, side = (k[:, None] * n for k, n in zip(path.curvature(middle), normals(path, middle), strict=True))
    assert (np.abs(bend - build - side).max(axis=-1) <= sharpest**3 * step**2 + (1.0 + sharpest) * rounding).all()


@given(path=paths(), cut=st.floats(0.01, 0.99))
def test_cutting_a_path_changes_nothing(path: fr.WellPath, cut: float) -> None:
    middle = path.start + cut * path.length
    upper, lower = path.part(path.start, middle), path.part(middle, path.end)
    s = np.linspace(path.start, path.end, 40)
    for part, inside in ((upper, s[s < middle]), (lower, s[s > middle])):
        moved = path.position(inside) - path.position(part.start)
        np.testing.assert_allclose(part.position(inside), moved, rtol=0.0, atol=1e-11 * path.length)
        np.testing.assert_allclose(tangent(part, inside), tangent(path, inside), rtol=0.0, atol=1e-11)
    assert (upper.length + lower.length) == pytest.approx(path.length, rel=1e-14)


@given(bend=st.floats(-1e-7, 1e-7), turn=st.floats(-1e-7, 1e-7), inclination=st.floats(0.1, 3.0))
def test_nearly_straight_paths_lose_no_digits(bend: float, turn: float, inclination: float) -> None:
    lower = inclination + bend
    path = fr.WellPath([0.0, 10.0], [inclination, lower], [0.0, turn])
    build, side = path.curvature(5.0)
    assert build == pytest.approx((lower - inclination) / 10.0, rel=1e-7, abs=1e-15)  # the rest is of higher order
    assert side == pytest.approx(math.sin(inclination) * turn / 10.0, rel=1e-6, abs=1e-300)


def test_a_straight_path_is_a_line() -> None:
    path = fr.WellPath.straight(length=300.0, inclination="60deg", azimuth="90deg", depth=50.0)
    np.testing.assert_allclose(path.position(350.0), [0.0, 300.0 * math.sin(math.pi / 3.0), 150.0], atol=1e-12)
    assert path.curvature(100.0) == (0.0, 0.0)
    assert (path.start, path.end, path.length) == (50.0, 350.0, 300.0)


def test_on_a_station_curvature_is_that_of_the_interval_below() -> None:
    path = fr.WellPath([0.0, 100.0, 200.0, 300.0], [0.5, 0.5, 0.8, 0.8])
    np.testing.assert_allclose(path.curvature([0.0, 100.0, 200.0, 300.0])[0], [0.0, 0.003, 0.0, 0.0], atol=1e-17)
    np.testing.assert_allclose(path.inclination_at(path.stations), path.inclination, rtol=1e-15)


def test_a_vertical_station_has_no_azimuth() -> None:
    one, other = (fr.WellPath([0.0, 100.0, 200.0], [0.0, 0.3, 0.0], [north, 2.0, -north]) for north in (0.0, 1.5))
    s = np.linspace(0.0, 200.0, 21)
    np.testing.assert_array_equal(one.position(s), other.position(s))
    np.testing.assert_allclose(one.curvature(s)[0], np.where(s < 100.0, 0.003, -0.003), rtol=1e-12)
    np.testing.assert_array_equal(other.curvature(s)[1], 0.0)


def test_a_path_is_a_value() -> None:
    path = fr.WellPath(["0ft", "100ft"], ["3deg", "5deg"], "10deg")
    assert (path.depth[1], path.inclination[1]) == (30.48, math.radians(5.0))
    same = fr.WellPath(**path.as_dict())
    assert (same, hash(same)) == (path, hash(path))
    assert pickle.loads(pickle.dumps(path)) == path
    assert path != fr.WellPath.straight(length=30.48, inclination=0.1)
    assert repr(path) == "<well path of 2 stations, 0 to 100 ft, inclination 3 to 5 deg, doglegs up to 2 deg/100 ft>"
    assert "100.00" in str(path.report())
    assert "30.48" in str(same.report())
    assert "<table>" in path._repr_html_()
    with pytest.raises(ValueError, match="read-only"):
        path.depth[0] = 3.0
    with pytest.raises(TypeError, match="the measured depth is depth"):
        fr.WellPath(md=[0.0, 1.0], inclination=0.0)  # type: ignore[call-arg]


IMPOSSIBLE = {
    "station 1 must have two stations": ([0.0], [0.0], 0.0),
    "station 0 must have two stations": ([], [], 0.0),
    "depth at station 3 must increase from station to station, got 20 m after 30 m": ([0, 30, 20], 0.1, 0.0),
    "depth at station 2 must increase from station to station, got 30 m after 30 m": ([30, 30, 60], 0.1, 0.0),
    "depth at station 1 must lie between 0 and 1e": ([-5.0, 30.0], 0.1, 0.0),
    "depth at station 2 must lie between 0 and 1e": ([0.0, 3e6], 0.1, 0.0),
    "depth at station 2 must be finite, got nan": ([0.0, math.nan], 0.1, 0.0),
    "inclination at station 2 must be finite, got inf": ([0.0, 1.0], [0.1, math.inf], 0.0),
    "azimuth at station 1 must be finite": ([0.0, 1.0], 0.1, [math.nan, 0.0]),
    "inclination at station 2 must lie between 0.*got 45 rad.*deg": ([0.0, 1.0], [0.0, 45.0], 0.0),
    "inclination at station 1 must lie between 0.*got -0.1 rad": ([0.0, 1.0], [-0.1, 0.1], 0.0),
    "azimuth at station 2 must lie within two turns, got 270 rad.*deg": ([0.0, 1.0], 0.1, [0.0, 270.0]),
    "inclination at station 2 must not reverse": ([0.0, 1.0], math.pi / 2.0, [0.0, math.pi]),
    "inclination must have as many numbers as depth has, 3, got 2": ([0, 1, 2], [0.1, 0.2], 0.0),
    "azimuth must have as many numbers as depth has, 2, got 3": ([0, 1], 0.1, [1, 2, 3]),
    "inclination.1. must be a number with a angle unit": ([0, 1], ["1deg", "2 parsec"], 0.0),
    "depth must be a list": (3.0, 0.1, 0.0),
    "depth must be a list.*got ..0": ([[0.0, 1.0]], 0.1, 0.0),
}


@pytest.mark.parametrize("words", IMPOSSIBLE)
def test_what_is_no_path_is_refused_by_station(words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        fr.WellPath(*IMPOSSIBLE[words])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("depth", [[True, False], [1j, 2j], None, "abc", np.array(["2020-01-01"], "M8[D]")])
def test_what_is_no_number_is_refused(depth: object) -> None:
    with pytest.raises((TypeError, ValueError), match="depth"):
        fr.WellPath(depth, 0.1)


def test_depths_off_the_path_are_refused() -> None:
    path = fr.WellPath([100.0, 130.0], 0.3)
    for call in (path.position, path.curvature, path.inclination_at, path.azimuth_at):
        with pytest.raises(ValueError, match="depth must lie between 100 and 130 m, got 131 m"):
            call([110.0, 131.0])
    with pytest.raises(ValueError, match="end must lie below start = 120 m, got 110 m"):
        path.part(120.0, 110.0)
    np.testing.assert_array_equal(path.position(130.0 + 1e-8), path.position(130.0))


@pytest.mark.filterwarnings("error::floquetrod.PlausibilityWarning")
def test_doglegs_that_look_like_typing_errors_are_told() -> None:
    angles = np.array([0.0, 1.0, 2.0, 12.0, 4.0, 5.0])
    depth = 30.0 * np.arange(6)
    with pytest.warns(fr.PlausibilityWarning, match=r"station 4 turns the well by 10 deg and back at 90 m"):
        fr.WellPath(depth, np.radians(angles))
    with pytest.warns(fr.PlausibilityWarning, match=r"station 2 gives a dogleg of 57.3 deg/30 m.*'30deg'") as heard:
        fr.WellPath([0.0, 30.0, 60.0], [0.0, 1.0, 2.0])
    assert heard[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fr.WellPath(depth, np.radians(np.where(angles == 12.0, 3.0, angles)))
        fr.WellPath.arc(length=3.1, inclination=("80deg", "90deg"))  # of a laboratory: 97 deg/30 m


# --- errors of a survey ---


@given(path=paths(), off=st.floats(-0.2, 0.2), turned=st.floats(-7.0, 7.0))
def test_what_all_stations_have_wrong_turns_the_path(path: fr.WellPath, off: float, turned: float) -> None:
    """The same azimuth turns it about the vertical, and the same inclination is that of each station and no more."""
    depth = np.linspace(path.start, path.end, 9)
    north, east, down = path.with_errors(azimuth=turned).position(depth).T
    before = path.position(depth).T
    expected = before[0] + 1j * before[1]
    np.testing.assert_allclose(north + 1j * east, expected * np.exp(1j * turned), atol=1e-9 * path.length)
    np.testing.assert_allclose(down, before[2], atol=1e-9 * path.length)
    tilted = path.inclination + off
    if tilted.min() >= 0.0 and tilted.max() <= math.pi:
        np.testing.assert_array_equal(path.with_errors(off).inclination, tilted)


def test_errors_beyond_the_vertical_go_on_on_its_other_side() -> None:
    path = fr.WellPath([0.0, 30.0, 60.0], [0.001, 0.1, math.pi - 0.001], [0.3, 0.3, 12.5])
    found = path.with_errors([-0.003, "1deg", 0.004], 0.1)
    np.testing.assert_allclose(found.inclination, [0.002, 0.1 + math.pi / 180.0, math.pi - 0.003])
    np.testing.assert_allclose(np.exp(1j * found.azimuth), np.exp(1j * np.array([0.4 + math.pi, 0.4, 12.6 + math.pi])))
    assert path.with_errors() == path


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"inclination": [0.1, 0.2]}, "inclination must have as many numbers as depth has, 3, got 2"),
        ({"inclination": [0.1, math.nan, 0.2]}, "inclination at station 2 must be finite"),
        ({"azimuth": "0.1m"}, "azimuth must .*angle"),
        ({"inclination": [0.0, 0.0, 3.13]}, "inclination at station 3 must not reverse the direction"),
    ],
)
def test_errors_that_leave_no_path_are_refused(given: dict, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words):
        fr.WellPath([0.0, 30.0, 60.0], 0.01).with_errors(**given)
