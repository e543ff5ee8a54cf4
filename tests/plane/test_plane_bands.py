"""Bands between exact curves: every point that grows lies in one, nothing else does, and vertices lie on boundaries."""

from __future__ import annotations

import itertools
import math
import pickle
from typing import Any

import numpy as np
import pytest
from matplotlib.path import Path
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod._util import compilation
from floquetrod.mathieu import chart
from floquetrod.plane import Band, Bands, Chart
from floquetrod.rod.kernels import independent_modes as rod_modes
from tests.conftest import depth
from tests.inside import SLOW_GROWTH, mode_constants

Floats = NDArray[np.float64]

ACCURACY = 1.0 / 3000.0
PLANES = [("frequency", "mean"), ("frequency", "amplitude"), ("mean", "amplitude")]
ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force


def covered(bands: Bands, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which points lie in a band."""
    inside = np.zeros(x.size, dtype=bool)
    for band in bands:
        closed = np.column_stack([np.append(v, v[0]) for v in (band.x, band.y)])
        inside |= Path(closed).contains_points(np.column_stack([x, y]))
    return inside


def distance(bands: Bands, x: float, y: float) -> float:
    """Return the distance of a point from the nearest edge, in shares of the axes."""
    wide, high = (float(np.ptp(axis.values)) for axis in (bands.x, bands.y))
    nearest = math.inf
    for band in bands:
        u, v = (band.x - x) / wide, (band.y - y) / high
        du, dv = np.roll(u, -1) - u, np.roll(v, -1) - v
        length = du * du + dv * dv
        t = np.clip(-(u * du + v * dv) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        nearest = min(nearest, float(np.hypot(u + t * du, v + t * dv).min()))
    return nearest


def disagreements(bands: Bands, x: Floats, y: Floats, rate: Floats, tolerance: float) -> list[tuple[float, float]]:
    """Return points that grow outside all bands, or do not inside one, farther from every edge than the accuracy."""
    inside = covered(bands, x, y)
    grows = rate > (tolerance or SLOW_GROWTH) * (1.0 + 1e-6)
    wrong = (grows & ~inside) | (inside & (rate <= tolerance))
    points = zip(x[wrong].tolist(), y[wrong].tolist(), strict=True)
    return [point for point in points if distance(bands, *point) > bands.accuracy]


def random_map(seed: int, across: str, up: str) -> tuple[fr.Rod, Chart, float]:
    """Return a random rod, its map over a random window, and the third quantity."""
    rng = np.random.default_rng(seed)
    damping = float(rng.choice([0.0, 10.0 ** rng.uniform(-2.0, 1.3)]))
    rod = ROD.replace(length=float(10.0 ** rng.uniform(-0.3, 0.8)), damping_rate=damping)
    tolerance = float(rng.choice([0.0, 10.0 ** rng.uniform(-3.0, 1.0)]))
    mean, amplitude = np.sort(rng.uniform(-0.5, 2.0, 2)) * UNIT, np.sort(rng.uniform(0.0, 1.5, 2)) * UNIT
    slow = 10.0 ** rng.uniform(1.3, 2.0)
    windows = {
        "frequency": (slow, slow * rng.uniform(1.5, 6.0)),
        "mean": (float(mean[0]), float(mean[1])),
        "amplitude": (float(amplitude[0]) * rng.integers(2), float(amplitude[1])),
    }
    values: dict[str, Any] = {name: (*ends, 2) for name, ends in windows.items()}
    (third,) = set(windows) - {across, up}
    values[third] = 0.5 * sum(windows[third])
    return rod, fr.stability_map(rod, growth_tolerance=tolerance, **values), values[third]


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("seed", range(depth(4, 2)))
def test_what_grows_lies_in_a_band_and_nothing_else_does(plane: tuple[str, str], seed: int) -> None:
    across, up = plane
    rod, found, fixed = random_map(seed, across, up)
    rng = np.random.default_rng(seed)
    x, y = (rng.uniform(*axis.ends.values, 4000) for axis in (found.x, found.y))
    (third,) = {"frequency", "mean", "amplitude"} - set(plane)
    loads = {across: x, up: y, third: np.full(x.size, fixed)}
    rate, _ = rod.growth_rate(
        mean=loads["mean"], amplitude=loads["amplitude"], frequency=loads["frequency"], return_mode=True
    )
    bands = found.bands
    assert bands.accuracy == ACCURACY
    assert bands.resolution == (0.0, 0.0)
    assert disagreements(bands, x, y, rate, found.growth_tolerance) == []
    fastest = max((band.largest_growth for band in bands), default=found.growth_tolerance or SLOW_GROWTH)
    assert fastest >= rate.max() * (1.0 - 1e-7)


@pytest.mark.parametrize(("damping", "tolerance"), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.05), (0.02, 0.01)])
def test_bands_of_a_chart_of_the_equation(damping: float, tolerance: float) -> None:
    found = chart((-3.0, 4.0, 5), (-4.0, 1.5, 5), damping, growth_tolerance=tolerance)
    rng = np.random.default_rng(1)
    x, y = (rng.uniform(*axis.ends.values, 4000) for axis in (found.x, found.y))
    rate = fr.mathieu.growth_rate(x, y, damping)
    assert disagreements(found.bands, x, y, rate, tolerance) == []
    assert all(band.mode is None for band in found.bands)
    zero = [band for band in found.bands if band.tongue == 0]
    assert len(zero) == 1
    assert zero[0].largest_growth == pytest.approx(rate[covered(found.bands, x, y)].max(), rel=0.05)


def mode_equation(rod: fr.Rod, band: Band, load: dict[str, float]) -> fr.Mathieu:
    """Return the equation of a band's mode under a load."""
    assert band.mode is not None
    family = rod_modes.mode_family(*mode_constants(rod)[:4], load["mean"], load["amplitude"], load["frequency"])
    return fr.Mathieu(*rod_modes.mode_coefficients(*family, band.mode), rod.damping_rate / load["frequency"])


RATES = [(0.0, 0.0), (1.5, 0.0), (0.5, 0.8)]
"""Damping rates and growth tolerances in 1/s."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plane", "rate"),
    [
        pytest.param(plane, rate, marks=[pytest.mark.slow] * ((plane, rate) != (PLANES[1], RATES[1])))
        for plane in PLANES
        for rate in RATES
    ],
)
def test_vertices_lie_on_boundaries_judged_by_reference(plane: tuple[str, str], rate: tuple[float, float]) -> None:
    across, up = plane
    damping, tolerance = rate
    rod = ROD.replace(damping_rate=damping)
    values: dict[str, Any] = {
        "mean": (0.0, 1.1 * UNIT, 2),
        "amplitude": (0.0, 0.8 * UNIT, 2),
        "frequency": (60.0, 200.0, 2),
    }
    (third,) = set(values) - set(plane)
    values[third] = 0.45 * values[third][1]
    found = fr.stability_map(rod, growth_tolerance=tolerance, **values)
    rng = np.random.default_rng(7)
    wide = [b for b in found.bands if min(np.ptp(b.x) / b.x.max(), np.ptp(b.y) / b.y.max()) > 1e-3]
    asked = 0
    for band in [wide[i] for i in rng.permutation(len(wide))[: depth(6, 4)]]:
        inner = np.flatnonzero(inside_window(found, band) & (np.abs(band.y) > 1e-3) & (np.abs(band.x) > 1e-3))
        for k in rng.permutation(inner)[:2].tolist():
            verdicts = set()
            for dx, dy in ((1e-9, 0.0), (-1e-9, 0.0), (0.0, 1e-9), (0.0, -1e-9)):
                load = {across: band.x[k] * (1.0 + dx), up: band.y[k] * (1.0 + dy), third: values[third]}
                verdict = fr.stability(mode_equation(rod, band, load), method="reference")
                verdicts.add(verdict.growth_rate * load["frequency"] > tolerance)
            assert verdicts == {False, True}, (band.name, k)
            asked += 1
    assert asked >= 6


def inside_window(found: Chart, band: Band) -> NDArray[np.bool_]:
    """Return which vertices of a band do not lie on the edge of the window."""
    (left, right), (low, high) = found.x.ends.values, found.y.ends.values
    return (band.x > left) & (band.x < right) & (band.y > low) & (band.y < high)


@pytest.mark.slow
def test_largest_growth_is_that_of_a_dense_grid() -> None:
    found = fr.stability_map(ROD, mean=(0.0, 1.1 * UNIT, 2), amplitude=0.3 * UNIT, frequency=(60.0, 150.0, 2))
    bands = sorted(found.bands, key=lambda band: -band.largest_growth)[:10]
    for band in bands:
        x, y = np.linspace(band.x.min(), band.x.max(), 300), np.linspace(band.y.min(), band.y.max(), 300)[:, None]
        family = rod_modes.mode_family(*mode_constants(ROD)[:4], y, 0.3 * UNIT, x)
        alpha, beta = np.broadcast_arrays(*rod_modes.mode_coefficients(*family, band.mode))
        rate = fr.mathieu.growth_rate(alpha, beta) * x
        own = covered(
            Bands(**(vars(found.bands) | {"bands": (band,)})), *(v.ravel() for v in np.broadcast_arrays(x, y))
        )
        assert rate.ravel()[own].max() <= band.largest_growth * (1.0 + 1e-9)
        assert rate.ravel()[own].max() >= 0.97 * band.largest_growth
        load = fr.AxialLoad(band.place[1], 0.3 * UNIT, band.place[0])
        assert ROD.stability(load, modes=[band.mode]).growth_rate == pytest.approx(band.largest_growth, rel=1e-7)


def test_windows_that_hold_no_band_or_lie_within_one() -> None:
    assert len(chart((0.0, 0.1, 5), (-0.19, -0.16, 5)).bands) == 0
    (whole,) = chart((1.0, 1.1, 5), (-0.3, -0.25, 5)).bands
    assert (whole.name, whole.x.size) == ("tongue 1", 4)
    assert sorted(zip(whole.x.tolist(), whole.y.tolist(), strict=True)) == [
        (1.0, -0.3), (1.0, -0.25), (1.1, -0.3), (1.1, -0.25)
    ]  # fmt: skip
    assert whole.place[0] == 1.1


def test_bands_are_taken_by_index_and_slice_as_they_are_iterated() -> None:
    bands = chart((0.0, 10.0, 41), (0.0, 3.0, 25)).bands
    assert len(bands) > 2
    assert [bands[i] for i in range(len(bands))] == list(bands)
    assert bands[-1] is bands.bands[-1]
    assert bands[1:] == tuple(bands)[1:]
    with pytest.raises(IndexError):
        bands[len(bands)]


def test_tongues_begin_in_a_point_without_forcing() -> None:
    bands = chart((0.0, 2.0, 5), (-2.5, 0.5, 5)).bands
    for band in bands:
        if band.tongue:
            k = int(np.argmin(band.x))
            assert band.x[k] == 0.0
            assert band.y[k] == pytest.approx(-0.25 * band.tongue**2, rel=1e-14)


def test_tongues_are_mirrored_where_the_amplitude_changes_sign() -> None:
    bands = chart((-2.0, 2.0, 5), (-2.5, 0.5, 5), 0.05).bands
    assert sorted(band.tongue or 0 for band in bands) == [0, 1, 1, 2, 2, 3, 3]
    left, right = (next(b for b in bands if b.tongue == 1 and b.place[0] * side > 0.0) for side in (-1.0, 1.0))
    assert sorted((-left.x).tolist()) == pytest.approx(sorted(right.x.tolist()), rel=1e-9)
    assert left.largest_growth == right.largest_growth


def test_without_vibration_only_buckling_is_left() -> None:
    found = fr.stability_map(ROD, mean=(0.0, 1.1 * UNIT, 2), amplitude=0.0, frequency=(20.0, 200.0, 2))
    assert [band.name for band in found.bands] == [f"mode {mode}, tongue 0" for mode in (5, 6, 7)]
    assert found.bands.tongues_left_out == 0
    for band in found.bands:
        assert band.x.size == 4
        family = rod_modes.mode_family(*mode_constants(ROD)[:4], band.y.min(), 0.0, 1.0)
        assert rod_modes.mode_coefficients(*family, band.mode)[1] == pytest.approx(0.0, abs=1e-9)


def test_tongues_are_counted() -> None:
    fine = fr.stability_map(ROD, mean=(0.0, UNIT, 2), amplitude=0.2 * UNIT, frequency=(80.0, 150.0, 2))
    coarse = fr.stability_map(
        ROD, mean=(0.0, UNIT, 2), amplitude=0.2 * UNIT, frequency=(80.0, 150.0, 2), growth_tolerance=0.5
    )
    names = {band.name for band in fine.bands}
    assert {band.name for band in coarse.bands} < names
    assert all(band.largest_growth > 0.5 for band in coarse.bands)
    assert all(band.largest_growth > SLOW_GROWTH for band in fine.bands)
    assert fine.bands.tongues_left_out > 0 < coarse.bands.tongues_left_out


@pytest.mark.slow
def test_a_coarser_accuracy_needs_fewer_vertices() -> None:
    found = chart((0.0, 3.0, 5), (-3.0, 0.5, 5), 0.05)
    sizes = [sum(band.x.size for band in found.find_bands(accuracy)) for accuracy in (0.1, 1e-3, 1e-5)]
    assert sizes[0] < sizes[1] < sizes[2]
    x, y = np.random.default_rng(3).uniform((0.0, -3.0), (3.0, 0.5), (4000, 2)).T
    rate = fr.mathieu.growth_rate(x, y, 0.05)
    for accuracy in (0.01, 1e-5):
        assert disagreements(found.find_bands(accuracy), x, y, rate, 0.0) == []


def test_sources_can_be_sent_to_other_processes() -> None:
    for found in (
        fr.stability_map(ROD, mean=(0.0, UNIT, 2), amplitude=0.2 * UNIT, frequency=(100.0, 150.0, 2)),
        chart((0.0, 1.0, 2), (-1.0, 0.0, 2)),
    ):
        copy = pickle.loads(pickle.dumps(found))
        assert copy.find_bands() == found.bands


def test_progress_is_reported() -> None:
    calls: list[tuple[int, int]] = []
    chart((0.0, 1.0, 2), (-1.0, 0.0, 2)).find_bands(progress=lambda done, total: calls.append((done, total)))
    assert calls
    assert calls[-1][0] == calls[-1][1]


def test_interpreted_kernels_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    found = chart((0.0, 1.0, 2), (-1.0, 0.2, 2), 0.05)
    expected = found.find_bands(0.02)
    monkeypatch.setattr(compilation, "runner", lambda function, size, **_: function)
    again = found.find_bands(0.02)
    assert len(again) == len(expected)
    for one, other in zip(again, expected, strict=True):
        assert one.x == pytest.approx(other.x, rel=1e-9)
        assert one.y == pytest.approx(other.y, rel=1e-9, abs=1e-9)


BENT = fr.Rod.nitinol()


def bent_windows(curvature: float) -> list[dict[str, tuple[float, float]]]:
    """Return windows in which the force never moves the rod off its wall: pushed, and pulled or on the high side."""
    lift = BENT.weight_per_length / abs(curvature)  # N, with this sign of the curvature it leaves the wall
    near = (0.02 * lift, 0.5 * lift) if curvature < 0.0 else (-0.5 * lift, 0.3 * lift)
    far = (1.5 * lift, 3.0 * lift) if curvature < 0.0 else (-3.0 * lift, -1.5 * lift)
    return [{"mean": mean, "amplitude": (0.0, 0.4 * lift), "frequency": (40.0, 200.0)} for mean in (near, far)]


@pytest.mark.parametrize("fixed", ["mean", "amplitude", "frequency"])
@pytest.mark.parametrize(
    "curvature", [0.2, *(pytest.param(k, marks=pytest.mark.slow) for k in (0.6, 0.02, -0.02, -0.2))]
)
def test_bands_where_the_channel_bends_hold_all_that_grows(curvature: float, fixed: str) -> None:
    rng = np.random.default_rng(7)
    cases = list(itertools.product(bent_windows(curvature), (0.0, 0.5), (0.0, 0.3)))
    for window, damping, tolerance in cases[:: depth(1, 3)]:
        rod = BENT.replace(curvature=curvature, damping_rate=damping)
        points = {name: rng.uniform(*ends, depth(2000, 100)) for name, ends in window.items()}
        points[fixed][:] = np.mean(window[fixed])  # type: ignore[index]
        axes = {name: (*ends, 2) for name, ends in window.items()} | {fixed: float(points[fixed][0])}
        bands = fr.stability_map(rod, **axes, growth_tolerance=tolerance).find_bands(ACCURACY)
        assert bands.resolution == (0.0, 0.0)
        x, y = (points[name] for name in ("frequency", "mean", "amplitude") if name != fixed)
        rate = rod.growth_rate(mean=points["mean"], amplitude=points["amplitude"], frequency=points["frequency"])
        assert disagreements(bands, x, y, rate, tolerance) == []


@pytest.mark.slow
@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("seed", range(12))
def test_bands_of_random_rods_that_build_or_drop(plane: tuple[str, str], seed: int) -> None:
    rng = np.random.default_rng(seed)
    curvature = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-2.0, 0.0))
    length, damping = 10.0 ** rng.uniform(-0.3, 0.8), rng.choice([0.0, 10.0 ** rng.uniform(-2.0, 1.0)])
    rod = ROD.replace(length=float(length), damping_rate=float(damping), curvature=curvature)
    lift = -rod.weight_per_length / curvature  # N, at this force the rod leaves its wall
    room = rng.uniform(0.1, 3.0) * UNIT
    near, far = lift + np.sign(rng.choice([-lift, lift])) * np.sort(rng.uniform(0.05, 1.0, 2)) * room
    low, high, most = min(near, far), max(near, far), 0.95 * abs(near - lift)
    windows = {"frequency": (30.0, 30.0 * rng.uniform(1.5, 6.0)), "mean": (low, high), "amplitude": (0.0, most)}
    points = {name: rng.uniform(*ends, 1000) for name, ends in windows.items()}
    (third,) = set(windows) - set(plane)
    points[third][:] = np.mean(windows[third])
    axes: dict[str, Any] = {name: (*ends, 2) for name, ends in windows.items()} | {third: float(points[third][0])}
    bands = fr.stability_map(rod, **axes).find_bands(ACCURACY)
    assert bands.resolution == (0.0, 0.0)
    rate = rod.growth_rate(mean=points["mean"], amplitude=points["amplitude"], frequency=points["frequency"])
    assert disagreements(bands, points[plane[0]], points[plane[1]], rate, 0.0) == []


@pytest.mark.slow
def test_bands_where_the_rod_leaves_its_wall_are_traced() -> None:
    lift = BENT.weight_per_length / 0.2
    rod = BENT.replace(curvature=-0.2)
    found = fr.stability_map(rod, mean=(0.5 * lift, 2.0 * lift, 9), amplitude=0.1, frequency=(60.0, 90.0, 9))
    assert found.undecided > 0
    assert min(found.bands.resolution) > 0.0


def test_a_mode_that_compression_holds_has_a_band_of_its_own() -> None:
    rod = BENT.replace(curvature=0.2)
    found = fr.stability_map(rod, mean=(0.1, 3.0, 2), amplitude=0.5, frequency=(40.0, 200.0, 2))
    longest = rod.length / np.pi * np.sqrt(rod.curvature / rod.radial_clearance)
    held = [band for band in found.bands if band.mode is not None and band.mode < longest]
    assert held
    for band in held:
        assert rod.stability(fr.AxialLoad(band.place[1], 0.5, band.place[0]), [band.mode]).growth_rate == pytest.approx(
            band.largest_growth, rel=1e-3
        )
