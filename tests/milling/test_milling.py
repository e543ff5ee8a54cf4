"""A milling cutter: the tables of the literature, its equations, critical depths and lobes."""

from __future__ import annotations

import functools
import math
import pickle
import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod.milling import read_depth, read_speed, stability_lobes
from floquetrod.milling.stability_lobes import critical_depths, judged
from tests.conftest import DEEP, depth

MODE = fr.ToolMode("922Hz", 0.011, mass="39.93g")


def cutter(immersion: float = 1.0, direction: str = "up", teeth: int = 2) -> fr.Milling:
    """Return the cutter of the tables, with one mode along the feed."""
    return fr.Milling(
        x=[MODE], teeth=teeth, tangential="600MPa", radial="200MPa", immersion=immersion, direction=direction
    )


@pytest.mark.parametrize(
    ("immersion", "direction", "speed", "depth", "modulus"),
    [
        (1.0, "up", "5000rpm", "0.2mm", 0.819742784),
        (1.0, "up", "5000rpm", "0.5mm", 1.073975587),
        (1.0, "down", "5000rpm", "1mm", 1.406473525),
        (0.5, "up", "8000rpm", "0.6mm", 1.165651146),
        (0.5, "down", "8000rpm", "0.6mm", 0.931173893),
    ],
)
def test_largest_moduli_are_those_of_the_table(
    immersion: float, direction: str, speed: str, depth: str, modulus: float
) -> None:
    """Converged values, not the coarse 0.8192, 1.0726 and 1.4040 that are often printed."""
    mill = cutter(immersion, direction)
    found = mill.stability(speed, depth)
    assert abs(found.multipliers[0]) == pytest.approx(modulus, abs=6e-10)
    assert found.error < 1e-8
    assert found.status == ("unstable" if modulus > 1.0 else "stable")
    place = (np.array([read_speed(speed)]), np.array([read_depth(depth)]))
    log = judged(mill, *place, growth=True).growth[0]
    assert math.exp(log) == pytest.approx(modulus, abs=1e-8)


def test_critical_depth_is_that_of_the_table() -> None:
    mill = cutter()
    depth = mill.critical_depth("5000rpm")
    assert f"{1e3 * depth:.5f}" == "0.40863"
    assert mill.stability("5000rpm", depth * (1.0 - 1e-7)).status == "stable"
    assert mill.stability("5000rpm", depth * (1.0 + 1e-7)).status == "unstable"
    assert mill.critical_depth("5000rpm", most="0.4mm") == math.inf


@pytest.mark.slow
def test_rows_of_the_table_by_the_second_method() -> None:
    mill = cutter()
    found = fr.stability(mill.system("5000rpm", "0.5mm"), "semi_discretisation")
    assert abs(found.multipliers[0]) == pytest.approx(1.073975587, abs=found.multiplier_errors[0])
    assert found.multiplier_errors[0] < 1e-3


@pytest.mark.parametrize("teeth", [1, 2, *(pytest.param(teeth, marks=pytest.mark.slow) for teeth in (3, 4))])
def test_equations_and_quick_verdicts_agree(teeth: int) -> None:
    """Three teeth have a force whose frequency is no harmonic of the time between teeth."""
    modes = {"x": [MODE], "y": [fr.ToolMode("1.1kHz", "1.2%", stiffness="2.4N/um")]}
    mill = fr.Milling(**modes, teeth=teeth, tangential="600MPa", radial="200MPa", immersion=0.3, direction="down")
    speed, depth = 950.0, 1.1e-3
    verdict = mill.stability(speed, depth)
    log = judged(mill, np.array([speed]), np.array([depth]), growth=True).growth[0]
    assert log / verdict.period == pytest.approx(verdict.exponents[0].real, abs=1e-6 / verdict.period)


def test_cutting_is_that_of_one_tooth_after_another() -> None:
    mill = cutter(0.5, "up", teeth=3)
    angles = np.linspace(0.0, mill.cycle, 50, endpoint=False)
    expected = np.where(angles < 0.5 * math.pi, np.sin(angles) * (6e8 * np.cos(angles) + 2e8 * np.sin(angles)), 0.0)
    assert mill.cutting(angles)[:, 0, 0] == pytest.approx(expected, abs=1e-3)
    assert mill.jumps == pytest.approx((0.0, 0.5 * math.pi))
    whole = cutter(1.0, teeth=4).cutting(angles)
    assert np.ptp(whole) < 1e-6 * np.abs(whole).max()  # two of four teeth cut, and make up for each other


def test_no_depth_leaves_the_free_vibration() -> None:
    found = cutter().stability("5000rpm", 0.0)
    assert found.exponents[0].real == pytest.approx(-0.011 * MODE.frequency, rel=1e-9)


@pytest.mark.slow
def test_lobes_are_named_and_agree_with_single_verdicts() -> None:
    mill = cutter()
    lobes = mill.lobes(("14000rpm", "22000rpm", 16), ("0.1mm", "3.5mm", 8))
    assert {lobe.kind for lobe in lobes.lobes} == {"Hopf", "flip"}
    first = max(lobes.lobes, key=lambda lobe: lobe.speeds[1] - lobe.speeds[0])
    assert str(first) == "Hopf lobe 1"
    table = lobes.report().table
    assert table is not None
    width = 30.0 / np.pi * (lobes.speeds[1] - lobes.speeds[0])
    assert f"Lobes narrower than {width:.4g} rpm, the distance of columns of the chart, may be missed." in table.rest
    assert pickle.loads(pickle.dumps(lobes)) == lobes
    rng = np.random.default_rng(5)
    for i, j in zip(rng.integers(0, 8, 4), rng.integers(0, 16, 4), strict=True):
        verdict = mill.stability(float(lobes.speeds[j]), 1e-3 * float(lobes.chart.y.values[i]))
        assert (verdict.status == "stable") == bool(lobes.chart.stable[i, j])


@pytest.mark.slow
def test_lobes_agree_with_single_verdicts_at_many_places() -> None:
    rng = np.random.default_rng(17)
    for mill in (cutter(), cutter(0.2, "down"), cutter(0.5, "up", teeth=3)):
        lobes = mill.lobes(("4000rpm", "24000rpm", 120), ("0.05mm", "6mm", 80))
        assert lobes.chart.undecided == 0
        for i, j in zip(rng.integers(0, 80, 60), rng.integers(0, 120, 60), strict=True):
            verdict = mill.stability(float(lobes.speeds[j]), 1e-3 * float(lobes.chart.y.values[i]))
            assert verdict.status == "undecided" or (verdict.status == "stable") == bool(lobes.chart.stable[i, j])


@pytest.mark.slow
def test_bands_lie_on_the_boundary() -> None:
    mill = cutter()
    chart = mill.lobes(("8000rpm", "20000rpm", 60), ("0mm", "4mm", 40)).chart
    (band,) = chart.bands.bands
    inside = (band.y < 3.999) & (band.y > 0.0) & (band.x > 8001.0) & (band.x < 19999.0)
    speeds, depths = math.pi / 30.0 * band.x[inside], 1e-3 * band.y[inside]
    logs = judged(mill, speeds, depths, growth=True).growth
    assert np.abs(logs).max() < 1e-4


def test_critical_depths_of_many_speeds_are_those_of_each() -> None:
    mill = cutter(0.5, "up")
    speeds = np.array([700.0, 900.0])
    assert critical_depths(mill, speeds) == pytest.approx([mill.critical_depth(s) for s in speeds], rel=1e-9)


def test_a_speed_without_a_unit_that_may_be_in_rpm_is_warned_of_with_both_readings() -> None:
    for value, number in (("900", "900"), (6000, "6000"), (6000.0, "6000.0"), ("6000", "6000")):
        with pytest.warns(fr.PlausibilityWarning) as caught:
            assert read_speed(value) == float(value)
        assert [each.category for each in caught] == [fr.PlausibilityWarning]
        found = re.match(
            r'speed = (\S+) rad/s is (\S+) rpm; .*: write "(.*)rpm" or "(.*)rad/s"', str(caught[0].message)
        )
        assert found is not None
        assert found.group(1, 3, 4) == (number,) * 3
        assert float(found[2]) == pytest.approx(float(value) * 30.0 / math.pi, rel=1e-5)
    for silent in ("6000rad/s", "6000rpm", 628.3185307179587, 6283.185307179587, 900.0):
        read_speed(silent)  # warnings are errors
    with pytest.warns(fr.PlausibilityWarning, match=r"speed\[1\] = 6000 rad/s is 57295\.8 rpm"):
        cutter().lobes(("5900rad/s", 6000, 2), ("0mm", "0.1mm", 2))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fr.ToolMode("922Hz", 0.011), "mass or stiffness must be given"),
        (lambda: fr.ToolMode("922Hz", 0.011, mass=1.0, stiffness=1.0), "mass or stiffness must be given"),
        (lambda: fr.ToolMode("922Hz", 1.5, mass=1.0), "damping_ratio must lie between"),
        (lambda: fr.ToolMode("922mm", 0.1, mass=1.0), "frequency must be a number with a frequency unit"),
        (lambda: fr.Milling(teeth=2, tangential=6e8, radial=2e8), "x or y must hold a ToolMode"),
        (lambda: fr.Milling(x=[1.0], teeth=2, tangential=6e8, radial=2e8), r"x\[0\] must be"),
        (lambda: fr.Milling(x=MODE, teeth=0, tangential=6e8, radial=2e8), "teeth must"),
        (lambda: fr.Milling(x=MODE, teeth=2, tangential=6e8, radial=2e8, immersion=1.2), "immersion must lie between"),
        (lambda: fr.Milling(x=MODE, teeth=2, tangential=6e8, radial=2e8, direction="left"), "direction must be"),
        (lambda: cutter().stability(0.0, "1mm"), "speed must be greater than zero"),
        (lambda: cutter().stability("5000rpm", "-1mm"), "depth must be zero or more"),
        (lambda: cutter().lobes(("5000rpm", "4000rpm", 5), ("0mm", "1mm", 5)), "speed must be"),
        (lambda: cutter().lobes("5000rpm", ("0mm", "1mm", 5)), "speed must be"),
    ],
)
def test_bad_input_has_one_clear_error(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises((TypeError, ValueError), match=message):
        call()


def drawn_cutter(rng: np.random.Generator) -> fr.Milling:
    modes = [
        fr.ToolMode(f"{rng.uniform(400, 1500)}Hz", rng.uniform(0.008, 0.04), mass=f"{rng.uniform(20, 200)}g")
        for _ in range(rng.integers(1, 3))
    ]
    return fr.Milling(
        x=modes[:1],
        y=modes[1:],
        teeth=int(rng.integers(1, 5)),
        tangential="600MPa",
        radial="200MPa",
        immersion=float(rng.choice([1.0, 0.5, 0.1])),
        direction=str(rng.choice(["up", "down"])),
    )


@functools.cache
def drawn_lobes(seed: int) -> Any:
    rng = np.random.default_rng(seed)
    cutter = drawn_cutter(rng)
    beat = min(mode.frequency for mode in cutter.modes) / cutter.teeth
    low = beat * rng.uniform(0.15, 0.5)
    high = low * rng.uniform(1.1, 4.0)
    deep = 20.0 * min(2.0 * mode.damping_ratio * mode.stiffness for mode in cutter.modes) / 6e8
    return cutter.lobes(
        (low, high, int(rng.integers(12, 24 * DEEP + 16))), (0.0, deep * rng.uniform(0.2, 1.5), depth(12, 8))
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(60, 1)))
def test_names_in_a_chart_of_lobes_are_led_to_the_least_depths_of_the_widest(seed: int) -> None:
    lobes = drawn_lobes(seed)
    ax = lobes.plot()
    ax.figure.canvas.draw()
    if not lobes.lobes:
        assert [text.get_text().replace("\n", " ") for text in ax.texts] == [lobes.none_in_range]
        pyplot.close(ax.figure)
        return
    (artist,) = (each for each in ax.artists if hasattr(each, "points"))
    rpm, named = 30.0 / math.pi, set()
    for text, (x, y) in zip(artist.texts, artist.points, strict=True):
        owners = [
            lobe
            for lobe in lobes.lobes
            if f"{lobe.kind} {lobe.number}" == text.get_text()
            and rpm * lobe.speeds[0] * (1.0 - 1e-12) <= x <= rpm * lobe.speeds[1] * (1.0 + 1e-12)
        ]
        assert len(owners) == 1
        assert y == pytest.approx(1e3 * owners[0].depth)
        named.add(id(owners[0]))
    natural = np.array([mode.frequency for mode in lobes.milling.modes])
    lowest: dict[tuple[str, int], Any] = {}
    for lobe in sorted(lobes.lobes, key=lambda lobe: lobe.depth):
        lowest.setdefault((str(lobe), int(np.abs(natural - lobe.frequency).argmin())), lobe)
    wide = sorted((lobe.speeds[1] - lobe.speeds[0] for lobe in lowest.values()), reverse=True)
    narrowest = min(lobe.speeds[1] - lobe.speeds[0] for lobe in lobes.lobes if id(lobe) in named)
    assert len(named) == min(12, len(wide))
    assert narrowest == wide[len(named) - 1]
    pyplot.close(ax.figure)


@pytest.mark.slow
def test_no_name_in_the_chart_of_the_slot_covers_a_lobe() -> None:
    lobes = cutter().lobes(("5000rpm", "25000rpm", depth(120, 40)), ("0mm", "4mm", depth(60, 20)))
    ax = lobes.plot()
    ax.figure.canvas.draw()
    (artist,) = (each for each in ax.artists if hasattr(each, "points"))
    x, y = np.meshgrid(lobes.chart.x.values, lobes.chart.y.values)
    unstable = ax.transData.transform(np.column_stack([x[~lobes.chart.stable], y[~lobes.chart.stable]]))
    named = [text.get_text() for text in artist.texts if text.get_visible()]
    assert {f"Hopf {number}" for number in range(1, 5)} <= set(named)
    for text in (text for text in artist.texts if text.get_visible()):
        box = text.get_window_extent()
        covered = (unstable > [box.x0, box.y0]) & (unstable < [box.x1, box.y1])
        assert not covered.all(axis=1).any(), text.get_text()
    pyplot.close(ax.figure)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(60, 2)))
def test_the_table_of_lobes_has_each_once_and_no_neighbours_are_one_lobe(seed: int) -> None:
    lobes = drawn_lobes(seed)
    table = lobes.report().table
    if table is None:
        assert "no lobe in range" in lobes.report().headline
        return
    natural = np.array([mode.frequency for mode in lobes.milling.modes])
    parts: dict[tuple[str, int], list[Any]] = {}
    for lobe in lobes.lobes:
        parts.setdefault((str(lobe), int(np.abs(natural - lobe.frequency).argmin())), []).append(lobe)
    heads = [head for head, _ in table.columns]
    rows = [dict(zip(heads, row, strict=True)) for row in table.rows]
    assert [row["lobe"] for row in rows] == [name for name, _ in parts]
    assert [float(row["least depth / mm"]) for row in rows] == pytest.approx(
        [1e3 * min(part.depth for part in each) for each in parts.values()], rel=1e-5
    )
    assert [row.get("parts", "1") for row in rows] == [str(len(each)) for each in parts.values()]
    assert ("parts" in heads) == (".lobes has each part" in table.rest) == (len(rows) < len(lobes.lobes))
    assert all(len(line) < 120 for line in table.rest.splitlines())
    assert ("mode / Hz" in heads) == (natural.size > 1)
    for one, other in pairwise(lobes.lobes):
        assert one.speeds[1] < other.speeds[0]
        assert str(one) != str(other) or other.speeds[0] - one.speeds[1] > stability_lobes.edge_width(lobes.speeds)


@pytest.mark.slow
def test_the_lobes_of_the_slot_are_numbered_downwards_and_named_near_its_mode() -> None:
    lobes = cutter().lobes(("5000rpm", "25000rpm", depth(120, 60)), ("0mm", "4mm", depth(60, 30)))
    wide = [lobe for lobe in lobes.lobes if lobe.depth < 1e-3]
    assert list(map(str, wide)) == [f"Hopf lobe {number}" for number in (5, 4, 3, 2, 1)]
    flips = [lobe.number for lobe in lobes.lobes if lobe.kind == "flip"]
    assert flips == sorted(flips, reverse=True)
    assert all(0.8 < lobe.frequency / (2.0 * math.pi * 922.0) < 1.2 for lobe in lobes.lobes)


@pytest.mark.slow
def test_the_report_says_where_the_deepest_cut_is() -> None:
    lobes = cutter().lobes(("14000rpm", "20000rpm", 9), ("0.1mm", "3.5mm", 8))
    best = int(lobes.depths.argmax())
    assert lobes.report().lines == [
        ("deepest", f"no chatter up to {1e3 * lobes.depths[best]:.6g} mm at {14000 + 750 * best:.6g} rpm")
    ]
    free = cutter().lobes(("18000rpm", "25000rpm", 8), ("0mm", "1mm", 6))
    deepest = "no chatter up to 1 mm, the end of the chart, at 19000 to 25000 rpm"
    assert free.depths.tolist()[1:] == [math.inf] * 7
    assert free.report().lines == [("deepest", deepest)]


@pytest.mark.slow
def test_progress_of_lobes_rises_to_the_end_and_may_end_the_work() -> None:
    mill, plane = cutter(), (("14000rpm", "22000rpm", 60), ("0.1mm", "3.5mm", 24))
    told: list[tuple[int, int]] = []
    lobes = mill.lobes(*plane, progress=lambda *each: told.append(each))
    assert lobes == mill.lobes(*plane)
    done = [each for each, _ in told]
    assert {total for _, total in told} == {100}
    assert done == sorted(done)
    assert len(set(done)) > 10
    assert done[0] < 15
    assert done[-1] == 100
    assert max(later - each for each, later in pairwise(done)) < 25  # neither the chart nor the search is left out

    def enough(done: int, _: int) -> None:
        if done > 0:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        mill.lobes(*plane, progress=enough)
    with pytest.raises(TypeError, match="progress must be a function"):
        mill.lobes(*plane, progress=3)


@pytest.mark.slow
def test_the_least_depth_of_a_lobe_is_searched_between_columns() -> None:
    lobes = cutter().lobes(("5650rpm", "6550rpm", 8), ("0mm", "1mm", 6))
    (lobe,) = lobes.lobes
    width = lobes.speeds[1] - lobes.speeds[0]
    depths = critical_depths(cutter(), np.linspace(lobe.at - width, lobe.at + width, 21))
    assert lobe.depth <= depths.min() * (1.0 + 1e-9)
    assert lobe.depth < 0.999 * lobes.depths.min()  # at a column chatter begins deeper
    assert cutter().critical_depth(f"{lobe.at!r}rad/s") == pytest.approx(lobe.depth, rel=1e-9)


@pytest.mark.parametrize(("below", "above"), [(1e-6, 3e-6), (1e-5, 1e-6)])
def test_the_search_of_a_least_depth_ends_where_speeds_are_as_close_as_rounding(below: float, above: float) -> None:
    """Depths are known to 1e-9 only: here all but the middle one are larger by less, however near they are."""
    boundary = stability_lobes._Boundary(cutter(), np.linspace(0.0, 1e-3, 6))
    middle = boundary.start(615.025, 0.3159e-3)
    left, right = (
        middle._replace(speed=middle.speed + side, depth=middle.depth * (1.0 + 1e-10)) for side in (-below, above)
    )
    search, later = boundary.valley(left, middle, right), middle._replace(depth=middle.depth * (1.0 + 4e-10))
    place, ended = next(search), None
    while ended is None:
        try:
            place = search.send(later._replace(speed=place.speed))
        except StopIteration as end:
            ended = end.value
    assert ended == (middle, later.depth - middle.depth)


def variable_pitch_cutter() -> fr.Milling:
    """Return a cutter whose flip lobes are narrower than the columns of a usual chart."""
    return fr.Milling(
        x=[fr.ToolMode("800Hz", "2%", stiffness="10N/um")],
        teeth=4,
        tangential="700N/mm2",
        radial="210N/mm2",
        immersion=0.5,
        direction="down",
        pitch=["70deg", "110deg"] * 2,
    )


@pytest.mark.slow
def test_a_flip_lobe_between_columns_is_listed_and_named_in_the_picture() -> None:
    lobes = variable_pitch_cutter().lobes(("6500rpm", "6950rpm", 4), ("0mm", "4.5mm", 10))
    rpm = 30.0 / math.pi
    (flip,) = (lobe for lobe in lobes.lobes if lobe.kind == "flip")
    assert not any(flip.speeds[0] <= speed <= flip.speeds[1] for speed in lobes.speeds)
    assert 1e3 * flip.depth == pytest.approx(3.78332, abs=5e-6)
    assert rpm * flip.at == pytest.approx(6708.67, abs=0.05)
    assert flip.frequency == pytest.approx(3.5 * 2.0 * flip.at)  # 3.5 vibrations in half a turn
    assert flip.error == pytest.approx(1e-8 * flip.depth)
    ax = lobes.plot()
    (artist,) = (each for each in ax.artists if hasattr(each, "points"))
    named = dict(zip((text.get_text() for text in artist.texts), artist.points, strict=True))
    assert named["flip 1"] == pytest.approx((rpm * flip.at, 1e3 * flip.depth))
    pyplot.close(ax.figure)


@pytest.mark.parametrize("beside", [0.5, 0.99, math.inf])
@pytest.mark.parametrize("edge", [1.6, 1.7, 1.79])
def test_a_least_depth_beside_another_lobe_has_an_error_that_covers_it(edge: float, beside: float) -> None:
    # Depths 1 + (s - 1.5)^2 over speeds s, but between 1.2 and an edge another lobe at another depth, or none: the lobe
    # is lowest at the edge.
    boundary = stability_lobes._Boundary(variable_pitch_cutter(), np.linspace(0.0, 4.0, 10))

    def start(speed: float) -> Any:
        if 1.2 < speed < edge:
            onset = stability_lobes._Onset("flip", math.pi, 0.5, 1.0)
            return stability_lobes._Start(speed, beside, onset if math.isfinite(beside) else None)
        onset = stability_lobes._Onset("Hopf", 1.0, 7.16, 14.3)
        return stability_lobes._Start(speed, 1.0 + (speed - 1.5) ** 2, onset)

    search = boundary.valley(start(1.0), start(1.8), start(3.0))
    (low, error), place = (None, None), next(search)
    while low is None:
        try:
            place = search.send(start(place.speed))
        except StopIteration as end:
            low, error = end.value
    lowest = 1.0 + (edge - 1.5) ** 2
    assert low.depth - error <= lowest <= low.depth < lowest + 1e-6


@pytest.mark.slow
def test_least_depths_of_lobes_do_not_depend_on_the_columns_of_the_chart() -> None:
    page = fr.Milling(
        x=[MODE],
        teeth=4,
        tangential="600MPa",
        radial="200MPa",
        immersion=0.3,
        direction="down",
        pitch=["70deg", "110deg"] * 2,
    )
    for mill, deep, flips in ((variable_pitch_cutter(), "16mm", 3), (page, "8mm", 3)):
        tables: list[dict[str, Any]] = []
        for columns in (60, 100, 200):
            least: dict[str, Any] = {}
            for lobe in mill.lobes(("3000rpm", "12000rpm", columns), ("0mm", deep, 60)).lobes:
                if str(lobe) not in least or lobe.depth < least[str(lobe)].depth:
                    least[str(lobe)] = lobe
            tables.append(least)
        wide = [{name for name in least if name != "flip lobe 4"} for least in tables]  # 0.07 rpm wide
        assert wide[0] == wide[1] == wide[2]
        assert sum(name.startswith("flip") for name in wide[0]) == flips
        for name in wide[0]:
            for one, other in pairwise(least[name] for least in tables):
                assert abs(one.depth - other.depth) <= one.error + other.error, name


def test_starts_between_columns_are_named_as_at_the_critical_depth() -> None:
    """Beside the end of a flip lobe a depth short by 2e-6 of it has the pair that is to meet at -1: a Hopf lobe's."""
    mill = drawn_cutter(np.random.default_rng(12))
    boundary = stability_lobes._Boundary(mill, np.linspace(0.0, 3.17037018871e-3, 12))
    columns = np.linspace(1143.39679716, 4103.1690699, 34)[2:4]
    one, other = map(boundary.start, columns.tolist(), critical_depths(mill, columns).tolist())
    (starts,) = boundary.together([boundary.refined(one, other, 0.41)], 10, 0, None)
    exact = critical_depths(mill, np.array([start.speed for start in starts]))
    assert [start.depth for start in starts] == pytest.approx(exact, rel=stability_lobes.ACCURACY)
    at_critical_depth = map(boundary.start, (start.speed for start in starts), exact.tolist())
    assert list(map(boundary.name, starts)) == list(map(boundary.name, at_critical_depth))
    assert {("flip", 3), ("Hopf", 3)} == set(map(boundary.name, starts))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(40, 2)))
def test_no_speed_within_a_lobe_has_less_depth_than_its_least(seed: int) -> None:
    lobes, rng = drawn_lobes(seed), np.random.default_rng(seed)
    for lobe in lobes.lobes:
        speeds = np.append(rng.uniform(*lobe.speeds, 6), lobe.at)
        deep = critical_depths(lobes.milling, speeds, 1e-3 * float(lobes.chart.y.values[-1]))
        assert deep[-1] == pytest.approx(lobe.depth, rel=1e-8, abs=lobe.error) or deep[-1] < lobe.depth
        for speed, less in zip(speeds.tolist(), deep.tolist(), strict=True):
            if less < lobe.depth - lobe.error:
                onset = stability_lobes._onset(lobes.milling, speed, less)
                between = 2.0 * math.pi / lobes.milling.teeth / lobes.milling.cycle
                assert (onset.kind, math.floor(onset.turns * between + 1e-6)) != (lobe.kind, lobe.number)


@pytest.mark.slow
def test_where_no_lobe_is_in_range_a_range_is_told_that_has_one() -> None:
    def asked(speed: tuple[str, str], low: str, high: str) -> Any:
        return cutter().lobes((*speed, 6), (low, high, 5))

    none = asked(("9000rpm", "11000rpm"), "0mm", "0.1mm")
    found = re.search(r"in range: nothing chatters up to 0.1 mm .* take depths up to ([\d.]+) mm", none.none_in_range)
    assert found is not None
    assert none.report().headline.endswith(none.none_in_range)
    ax = none.plot()
    assert [text.get_text().replace("\n", " ") for text in ax.texts] == [none.none_in_range]
    pyplot.close(ax.figure)
    some = asked(("9000rpm", "11000rpm"), "0mm", f"{found[1]}mm")
    assert some.lobes
    assert some.none_in_range == ""
    below = asked(("14500rpm", "18000rpm"), "3mm", "4mm")
    assert "no lobe in range: chatter begins below 3 mm; let the depths begin at 0 mm" in str(below.report())


@pytest.mark.slow
def test_critical_depths_are_as_accurate_as_said(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, coarse = np.random.default_rng(5), stability_lobes._logs

    def mode() -> fr.ToolMode:
        return fr.ToolMode(f"{rng.uniform(300, 1500)}Hz", float(rng.uniform(0.005, 0.05)), f"{rng.uniform(20, 400)}g")

    for teeth in (1, 2, 2, 3, 3, 4):
        turn = 360.0 / teeth
        pitch = (
            {"pitch": [f"{turn - 10.0}deg", f"{turn + 10.0}deg", *[f"{turn}deg"] * (teeth - 2)]} if teeth > 1 else {}
        )
        cutting = {"tangential": "600MPa", "radial": "200MPa", "direction": str(rng.choice(["up", "down"]))}
        immersion = float(rng.choice([1.0, 0.5]))
        mill = fr.Milling(x=[mode()], y=[mode()], teeth=teeth, immersion=immersion, **cutting, **pitch)
        speeds = read_speed("1rpm") * rng.uniform(4000.0, 20000.0, 3)
        depths = critical_depths(mill, speeds)
        with monkeypatch.context() as finer:
            finer.setattr(stability_lobes, "_logs", lambda *at: coarse(*at, more=20))
            assert critical_depths(mill, speeds) == pytest.approx(depths, rel=stability_lobes.ACCURACY)
