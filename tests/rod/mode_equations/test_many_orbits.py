"""Large orbits under many loads at once are those of the search under one; the map that shows them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.rod.large_orbits import alone, orbits_alone
from floquetrod.rod.mode_equations.many_orbits import ModeLoads, smallest_stable
from tests.conftest import depth
from tests.inside import Shapes

ROD = fr.Rod.nitinol().replace(damping_rate=3.0)
UNIT = ROD.critical_force


@pytest.mark.parametrize(
    ("ends", "waveform"),
    [
        ("hinged", "sine"),
        pytest.param("clamped", "sine", marks=pytest.mark.slow),
        pytest.param("hinged", (1.0, 0.3j), marks=pytest.mark.slow),
    ],
)
def test_orbits_are_those_of_the_search_under_each_load(ends: str, waveform: Any) -> None:
    rng, count = np.random.default_rng(7), depth(60, 4)
    rod = ROD.replace(ends=ends, damping_rate=float(rng.uniform(0.5, 5.0)))
    like = fr.AxialLoad(0.3 * UNIT, 1.0, 150.0, waveform=waveform)
    shapes, moving = Shapes.of(rod, like, 23), 0
    numbers = UNIT * rng.uniform(0.1, 0.5, count), UNIT * rng.uniform(0.1, 0.4, count), rng.uniform(110.0, 190.0, count)
    for mode in (6, 7, 8):
        equation = alone(rod, like, shapes, mode, 0.0)
        vibration = numbers[1][:, None] * equation.motion.vibrating[:, 0, 0]
        every = smallest_stable(equation, ModeLoads(numbers[0], numbers[2], vibration))
        for i, found in enumerate(every):
            load = like.with_numbers(*(float(each[i]) for each in numbers))
            known = [orbit for orbit in orbits_alone(alone(rod, load, shapes, mode, 0.0)) if orbit.is_stable]
            known = [orbit for orbit in known if orbit.amplitude < 0.7]
            assert (found is not None) == bool(known)
            if found is not None:
                moving += 1
                assert found.turns == known[0].turns
                assert found.amplitude == pytest.approx(known[0].amplitude, rel=2e-3)
                assert np.abs(found.multipliers).max() == pytest.approx(np.abs(known[0].multipliers).max(), rel=2e-3)
    assert moving >= count // 3


@pytest.fixture(scope="module")
def chart() -> fr.Chart:
    return fr.stability_map(
        ROD, mean=0.2 * UNIT, amplitude=[0.1 * UNIT, 0.15 * UNIT], frequency=[147.0, 151.5, 156.0], large_motion=True
    )


def test_the_map_shows_where_rest_is_not_all(chart: fr.Chart, tmp_path: Path) -> None:
    assert chart.stable.tolist() == [[True, True, True], [False, True, True]]
    assert chart.large_motion is not None
    assert np.isnan(chart.large_motion[1, 0])
    assert chart.carries_large_motion.tolist() == [[False, False, False], [False, True, False]]
    assert chart.large_motion[1, 1] == pytest.approx(0.3375, rel=0.05)  # of the mode with lift-off
    assert chart.large_motion[1, 2] == 0.0  # 25 degrees, which leave the wall
    assert "a large motion found, too, at 1 stable points" in chart.caption
    assert fr.Chart.load(chart.save(tmp_path / "chart.npz")) == chart
    assert "large_motion" in chart.to_xarray()
    for bands in (True, False):
        legend = chart.plot(bands=bands).get_legend()
        assert "large motion" in [text.get_text() for text in legend.get_texts()][-1]


def test_maps_without_large_motion_are_as_before(chart: fr.Chart) -> None:
    plain = fr.stability_map(ROD, mean=0.2 * UNIT, amplitude=chart.y.values, frequency=chart.x.values)
    assert plain.large_motion is None
    assert not plain.carries_large_motion.any()
    assert np.array_equal(plain.stable, chart.stable)


@pytest.mark.parametrize(
    ("rod", "given", "message"),
    [
        (ROD, {"criterion": fr.FiniteTimeCriterion()}, "large_motion"),
        (ROD, {"friction": 0.1, "kick": 0.1}, "large_motion"),
        (ROD.replace(ends="clamped-free"), {}, "free"),
    ],
)
def test_maps_that_cannot_be_made(rod: fr.Rod, given: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.stability_map(rod, mean=0.3, amplitude=(0.1, 0.2, 2), frequency=(50.0, 60.0, 2), large_motion=True, **given)
