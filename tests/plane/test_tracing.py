"""Bands traced from verdicts alone: vertices on boundaries, tongues followed to their tips, holes and edges."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

import floquetrod as fr
from floquetrod.mathieu.mathieu_charts import MathieuPlane
from floquetrod.plane import Axis, Band, Bands, charted
from floquetrod.plane.contours import crossings
from floquetrod.plane.family import Family, Judged, Verdicts
from floquetrod.plane.polygons import area, contains
from tests.conftest import depth

Floats = NDArray[np.float64]
ACCURACY = 1.0 / 3000.0


def axes(x: tuple[float, float, int], y: tuple[float, float, int]) -> tuple[Axis, Axis]:
    return Axis("a", "", "", np.linspace(*x)), Axis("b", "", "", np.linspace(*y))


def traced(status: Callable[[Floats, Floats], Any], x: tuple[float, float, int], y: tuple[float, float, int]) -> Bands:
    """Return the bands of a plane whose status is a function of places."""

    def judge(a: Floats, b: Floats) -> tuple[NDArray[np.int8], float]:
        a, b = np.broadcast_arrays(a, b)
        return np.asarray(status(a.ravel(), b.ravel())).astype(np.int8).reshape(a.shape), math.nan

    return charted(Judged(judge), *axes(x, y)).bands


def corners(band: Band) -> Floats:
    return np.column_stack([band.x, band.y])


def distances(points: Floats, bands: Bands, size: tuple[float, float]) -> Floats:
    """Return the distance of points from the nearest side of all bands, as a share of the axes."""
    rings = [corners(band) / size for band in bands]
    start = np.concatenate(rings)
    side = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings]) - start
    to = points[:, None] / size - start
    share = np.clip((to * side).sum(-1) / np.maximum((side**2).sum(-1), 1e-300), 0.0, 1.0)
    result: Floats = np.hypot(*np.moveaxis(to - share[..., None] * side, -1, 0)).min(axis=1)
    return result


def agree(bands: Bands, judge: Callable[[Floats, Floats], Any], seed: int = 0, near: float = 5e-4) -> None:
    """Hold bands to verdicts at random places, but for those as near to a boundary as bands are accurate."""
    rng = np.random.default_rng(seed)
    x, y = (rng.uniform(*axis.values, 1500) for axis in (bands.x, bands.y))
    inside = np.zeros(x.size, dtype=np.bool_)
    for band in bands:
        inside |= contains(corners(band), np.column_stack([x, y]))
    wrong = inside != (np.asarray(judge(x, y)) == 0)
    if wrong.any():
        size = np.ptp(bands.x.values), np.ptp(bands.y.values)
        assert distances(np.column_stack([x, y])[wrong], bands, size).max() < near


@pytest.mark.slow
@pytest.mark.parametrize(
    "points", [(25, 20), *(pytest.param(points, marks=pytest.mark.slow) for points in ((60, 50), (80, 40), (200, 200)))]
)
@pytest.mark.parametrize("growth", [pytest.param(True, marks=pytest.mark.slow), False])
def test_mathieu_traced_agrees_with_transition_curves(points: tuple[int, int], growth: bool) -> None:
    def judge(alpha: Floats, beta: Floats) -> tuple[NDArray[np.int8], Any]:
        stable = fr.mathieu.is_stable(alpha, beta)
        rate = fr.mathieu.growth_rate(alpha, beta) if growth else math.nan
        return stable.astype(np.int8), rate

    x, y = axes((0.0, 2.0, points[0]), (-2.5, 0.6, points[1]))
    bands = charted(Judged(judge), x, y).bands
    assert bands.accuracy == ACCURACY
    assert len(bands) == 4
    agree(bands, fr.mathieu.is_stable)
    for band in bands:
        inner = (band.x > 0.0) & (band.x < 2.0) & (band.y > -2.5) & (band.y < 0.6)
        curves = fr.mathieu.transition_curves(band.x[inner], 6)
        off = np.abs(np.concatenate([curves.even, curves.odd]) - band.y[inner])
        assert np.nanmin(off, axis=0).max() < 1e-9 * 3.1
    alpha = np.linspace(0.0, 2.0, 801)
    curves = fr.mathieu.transition_curves(alpha, 3)
    for order, (even, odd, width) in enumerate(zip(curves.even, curves.odd, curves.width, strict=True)):
        followed = width > 1e-8 * (30.0 if order else 1.0)
        for curve in (even, odd)[: 1 + (order > 0)]:
            some = followed & (curve > -2.5) & (curve < 0.6)
            points_on = np.column_stack([alpha[some], curve[some]])
            assert distances(points_on, bands, (2.0, 3.1)).max() < ACCURACY
    if growth:  # the largest growth within each band is that of dense samples
        a, b = np.meshgrid(np.linspace(0.0, 2.0, depth(400, 200)), np.linspace(-2.5, 0.6, depth(400, 200)))
        rate = fr.mathieu.growth_rate(a, b).ravel()
        for band in bands:
            dense = rate[contains(corners(band), np.column_stack([a.ravel(), b.ravel()]))].max()
            assert dense * (1.0 - 1e-9) <= band.largest_growth <= 1.02 * dense


class Traced(MathieuPlane):
    """The same plane, of which no exact bands are known."""

    def exact_bands(self, *_: Any) -> None:
        """Return none."""
        return


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "tolerance"), [(0.05, 0.0), (0.02, 0.01)])
def test_exact_and_traced_bands_of_one_family_agree(damping: float, tolerance: float) -> None:
    charts = [
        charted(kind(damping, tolerance, None, None), *axes((0.0, 2.0, 40), (-1.6, 0.4, 40)))
        for kind in (MathieuPlane, Traced)
    ]
    exact, found = (sorted(chart.bands, key=lambda band: -area_of(band)) for chart in charts)
    assert [len(exact), len(found)] == [3, 3]
    for one, other in zip(exact, found, strict=True):
        around = 2.0 * (np.ptp(one.x) / 2.0 + np.ptp(one.y) / 2.0)
        assert area_of(one) / 4.0 == pytest.approx(area_of(other) / 4.0, abs=2.0 * ACCURACY * around)
        assert one.largest_growth == pytest.approx(other.largest_growth, rel=1e-3)
        assert distances(corners(other), charts[0].bands, (2.0, 2.0)).max() < 2.0 * ACCURACY
    stated = [
        (chart.bands.growth_unit, chart.bands.growth_tolerance, chart.bands.accuracy, chart.bands.tongues_left_out)
        for chart in charts
    ]
    assert stated[0] == stated[1]
    assert [any(chart.bands.resolution) for chart in charts] == [False, True]


def area_of(band: Band) -> float:
    return abs(area(corners(band)))


def test_a_tip_is_followed_to_less_than_a_thousandth_of_the_grid() -> None:
    def status(a: Floats, b: Floats) -> Any:
        return ~(np.abs(b - 0.4 - 0.3 * a**2) < 0.05 * np.maximum(a - 0.1, 0.0) ** 3)

    bands = traced(status, (0.0, 1.0, 30), (0.0, 1.0, 30))
    assert len(bands) == 1
    assert bands.bands[0].x.min() == pytest.approx(0.1, abs=3e-3)  # where it is 1e-9 wide
    assert bands.bands[0].x.max() == 1.0
    agree(bands, status)


def test_dots_of_a_thin_tongue_become_one_band() -> None:
    def status(a: Floats, b: Floats) -> Any:
        return ~(np.abs(b - 0.2 - 0.5 * a - 0.1 * np.sin(3.0 * a)) < 0.004)

    across, up = axes((0.0, 1.0, 41), (0.0, 1.0, 37))
    assert 2 <= (~status(across.values, up.values[:, None])).sum() <= 20  # of 41 columns
    bands = traced(status, (0.0, 1.0, 41), (0.0, 1.0, 37))
    assert len(bands) == 1
    band = bands.bands[0]
    assert (band.x.min(), band.x.max()) == (0.0, 1.0)
    assert area(corners(band)) == pytest.approx(0.008, rel=0.02)
    agree(bands, status)


@pytest.mark.slow
def test_a_tongue_beside_the_edge_of_the_plane_is_followed_along_it() -> None:
    def status(a: Floats, b: Floats) -> Any:
        return ~((a <= 0.3) & (b < 0.7) | (np.abs(b - 0.017) < 0.0145 - 0.002 * a))

    bands = traced(status, (0.0, 1.0, 20), (0.0, 1.0, 20))
    assert [band.x.max() for band in bands] == [1.0]
    agree(bands, status)


@pytest.mark.parametrize("joined", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_outlines_of_a_grid_are_those_of_its_parts(joined: bool, seed: int) -> None:
    """What only a diagonal connects is one part where the middles of cells are unstable, else two; holes contrarily."""
    unstable = np.random.default_rng(seed).random((30, 40)) < 0.5
    u, v = np.linspace(0.0, 1.0, 40), np.linspace(0.0, 1.0, 30)
    found = crossings(u, v, unstable, lambda places: np.full(len(places), joined))
    around, across = ndimage.generate_binary_structure(2, 2), ndimage.generate_binary_structure(2, 1)
    parts = ndimage.label(unstable, around if joined else across)[1]
    holes = ndimage.label(~np.pad(unstable, 1), across if joined else around)[1] - 1
    assert len(found.rings) == parts + holes
    row, column = (np.searchsorted(line, found.inside[:, k]) for line, k in ((v, 1), (u, 0)))
    assert unstable[row, column].all()


def test_thin_tongues_that_cross_are_one_band() -> None:
    """Where they cross, cells of the grid have two unstable corners of four, and what joins them is in their middle."""

    def status(a: Floats, b: Floats) -> Any:
        rising = np.abs(b - 0.3 - 0.5 * a) < 0.05 * np.maximum(a - 0.2, 0.0) ** 2
        return ~(rising | (np.abs(b - 0.8 + 0.6 * a) < 0.03 * a**2))

    bands = traced(status, (0.0, 1.0, 33), (0.0, 1.0, 42))
    assert len(bands) == 1
    assert bands.accuracy == ACCURACY
    agree(bands, status)


def test_holes_islands_and_gaps() -> None:
    def ring(a: Floats, b: Floats) -> Any:
        r = np.hypot(a, b)
        return ~((r < 0.8) & (r > 0.4) | (r < 0.15))

    bands = traced(ring, (-1.0, 1.0, 30), (-1.0, 1.0, 31))
    sizes = sorted(area(corners(band)) for band in bands)
    assert sizes == pytest.approx([math.pi * 0.15**2, math.pi * (0.64 - 0.16)], rel=3e-3)
    for band in bands:
        r = np.hypot(band.x, band.y)
        assert np.abs(r[:, None] - [0.15, 0.4, 0.8]).min(axis=1).max() < 1e-9
        assert math.isnan(band.largest_growth)
    agree(bands, ring)

    def two_halves(a: Floats, b: Floats) -> Any:  # a stable strip that no row of the grid shows whole
        return np.abs(b - 0.02 - 0.1 * a) < 0.01

    bands = traced(two_halves, (-1.0, 1.0, 30), (-1.0, 1.0, 30))
    assert len(bands) == 2
    agree(bands, two_halves)


def test_everything_stable_unstable_or_undecided() -> None:
    plane = (0.0, 1.0, 5), (2.0, 4.0, 6)
    assert len(traced(lambda a, b: np.ones(a.size), *plane)) == 0
    assert len(traced(lambda a, b: np.full(a.size, -1), *plane)) == 0
    (band,) = traced(lambda a, b: np.zeros(a.size), *plane)
    assert sorted(zip(band.x.tolist(), band.y.tolist(), strict=True)) == [
        (0.0, 2.0),
        (0.0, 4.0),
        (1.0, 2.0),
        (1.0, 4.0),
    ]
    # an undecided strip belongs to no band
    (band,) = traced(lambda a, b: np.where(a < 0.5, 0, np.where(a < 0.7, -1, 1)), *plane)
    assert band.x.max() == pytest.approx(0.5, abs=1e-9)


class Decaying(Family):
    """A family of which growth is known of stable places too, or their verdicts alone; it counts places judged."""

    growth_unit, growth_tolerance, judged = "per tau", 0.0, 0

    def __init__(self, rate: Callable[[Floats, Floats], Floats], signed: bool) -> None:
        self.rate, self.signed = rate, signed

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return verdicts, and growth where something grows."""
        rate = self._judged(*np.broadcast_arrays(x, y))
        return Verdicts(np.where(rate > 0.0, 0, 1), np.maximum(rate, 0.0))

    @property
    def signed_growth(self) -> Callable[[Floats, Floats], Floats] | None:
        """Return the function of growth, if it is known everywhere."""
        return self._judged if self.signed else None

    def _judged(self, x: Floats, y: Floats) -> Floats:
        self.judged += x.size
        return self.rate(x, y)


def _lobes(x: Floats, y: Floats) -> Floats:
    """Return growth above lobes that meet at corners."""
    return np.maximum(y - 0.5 - 0.35 * np.sin(7.0 * x), np.log(0.2 + y) + 0.2 * np.cos(11.0 * x))


def _ring(x: Floats, y: Floats) -> Floats:
    """Return growth in a ring about the middle, which reaches over the edge of the plane."""
    return 0.04 - (np.hypot(x - 0.4, y - 0.5) - 0.45) ** 2


def _cliff(x: Floats, y: Floats) -> Floats:
    """Return growth that jumps at an oblique line, and is not known beyond another."""
    return np.where(y > 0.3 + 0.4 * x, 3.0, np.where(y > 0.1 + 0.4 * x, -1e-3, -np.inf))


@pytest.mark.slow
@pytest.mark.parametrize("rate", [_lobes, _ring, _cliff])
def test_bands_by_signed_growth_are_those_by_verdicts(rate: Callable[[Floats, Floats], Floats]) -> None:
    families = [Decaying(rate, signed) for signed in (True, False)]
    signed, plain = (charted(family, *axes((0.0, 1.0, 14), (0.0, 1.0, 12))).bands for family in families)
    assert len(signed) == len(plain)
    for bands in (signed, plain):
        agree(bands, lambda a, b: rate(a, b) <= 0.0)
    for band, other in zip(signed, plain, strict=True):
        inner = (np.minimum(band.x, band.y) > 0.0) & (np.maximum(band.x, band.y) < 1.0)
        if rate is not _cliff:
            assert np.abs(rate(band.x[inner], band.y[inner])).max() < 1e-9
        assert area_of(band) == pytest.approx(area_of(other), rel=1e-3)
        assert band.largest_growth == pytest.approx(other.largest_growth)
    if rate is not _cliff:
        assert families[0].judged < 0.9 * families[1].judged


def test_a_budget_that_is_too_small_is_said() -> None:
    def dirt(a: Floats, b: Floats) -> Any:
        return np.sin(400.0 * a) * np.sin(400.0 * b) > 0.0

    bands = traced(dirt, (0.0, 1.0, 12), (0.0, 1.0, 12))
    assert bands.accuracy >= 1.0 / 11.0


def pair(omega: float, epsilon: float) -> fr.HillSystem:
    """Return oscillators that grow together, forced near the sum of their frequencies."""
    forcing = epsilon * np.array([[0.5, 1.0], [1.0, 0.8]])
    return fr.HillSystem(np.diag([1.0, 4.0]), [forcing], period=2.0 * math.pi / omega)


@pytest.mark.slow
def test_two_oscillators() -> None:
    chart = fr.chart(pair, over={"omega": (1.7, 4.4, 40), "epsilon": (0.0, 0.5, 20)})
    bands = chart.bands
    assert len(bands) == 3
    assert bands.resolution == pytest.approx((2.7 / 39.0, 0.5 / 19.0))
    bottoms = sorted((float(band.y.min()), float(band.x[band.y.argmin()])) for band in bands)
    assert max(y for y, _ in bottoms) < 1e-3
    assert sorted(x for _, x in bottoms) == pytest.approx([2.0, 3.0, 4.0], abs=1e-3)
    assert chart.source is not None
    agree(bands, lambda x, y: chart.source.family.verdicts(x, y).status)  # type: ignore[union-attr]
    for band in bands:
        inner = np.flatnonzero((band.y < 0.5) & (band.y > 0.05))
        for i in inner[:: max(1, inner.size // 4)].tolist():
            there = [fr.stability(pair(band.x[i] + shift, band.y[i])).status for shift in (-2e-8, 2e-8)]
            assert sorted(there) == ["stable", "unstable"]
    assert pickle.loads(pickle.dumps(chart)).find_bands(0.01).bands == chart.find_bands(0.01).bands


def test_errors_of_the_family_are_named() -> None:
    def family(a: float, b: float) -> fr.Mathieu:
        if 0.501 < a < 0.999:
            raise RuntimeError("no")
        return fr.Mathieu(alpha=a, beta=b)

    chart = fr.chart(family, over={"a": (0.0, 1.0, 3), "b": (-1.0, 0.1, 4)})
    with pytest.raises(ValueError, match=r"family\(a=0\.\d+, b=.*raised RuntimeError: no"):
        _ = chart.bands


@pytest.mark.slow
def test_meissner_and_the_finite_time_criterion() -> None:
    chart = fr.mathieu.chart((0.0, 3.0, 40), (-3.0, 1.0, 40), equation=fr.Meissner)
    bands = chart.bands

    def trace(
        alpha: Floats, beta: Floats
    ) -> Floats:  # half a period with stiffness -beta - alpha, half with -beta + alpha
        w, v = (np.sqrt(part.astype(complex)) for part in (-beta - alpha, -beta + alpha))
        a, b = math.pi * w, math.pi * v
        product = np.sin(a) / w * v * np.sin(b) + np.sin(b) / v * w * np.sin(a)
        return np.asarray((2.0 * np.cos(a) * np.cos(b) - product).real)

    for band in bands:
        inner = (band.x > 0.0) & (band.x < 3.0) & (band.y > -3.0) & (band.y < 1.0)
        ends = np.array([np.abs(trace(band.x[inner], band.y[inner] + shift)) - 2.0 for shift in (-8e-9, 0.0, 8e-9)])
        thin = np.abs(ends[1]) < 1e-9 * np.maximum(1.0, np.abs(ends[0] - ends[2]) / 1e-8)
        assert ((ends[0] * ends[2] <= 0.0) | thin).all()
    agree(bands, lambda a, b: np.abs(trace(a, b)) <= 2.0)
    criterion = fr.FiniteTimeCriterion()
    chart = fr.mathieu.chart((0.0, 1.0, 20), (-1.0, 0.5, 20), criterion=criterion)
    assert chart.bands.bands
    agree(chart.bands, criterion.is_stable)


@pytest.mark.slow
def test_rods_judged_by_a_criterion() -> None:
    rod = fr.Rod.nitinol()
    plane: dict[str, Any] = {"mean": (0.8, 1.7, 20), "amplitude": 0.34, "frequency": (120.0, 200.0, 20)}
    criterion = fr.FiniteTimeCriterion()
    chart = fr.stability_map(rod, **plane, criterion=criterion)
    assert chart.bands.bands
    agree(chart.bands, lambda x, y: rod.verdicts(mean=y, amplitude=0.34, frequency=x, criterion=criterion))


@pytest.mark.slow
def test_rods_with_coupled_modes() -> None:
    short = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, ends="clamped-clamped")  # of few modes, and they are coupled
    chart = fr.stability_map(short, mean=(700.0, 1500.0, 7), amplitude=1000.0, frequency=(18.0, 24.0, 7))
    bands = chart.find_bands(0.1)
    assert bands.bands
    for band in bands:
        assert band.largest_growth == pytest.approx(
            short.growth_rate(mean=band.place[1], amplitude=1000.0, frequency=band.place[0], return_mode=True)[0],
            rel=1e-9,
        )
