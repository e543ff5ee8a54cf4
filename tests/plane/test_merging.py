"""Tongues that merge in a band: found in polygons, named, listed, kept in files and labelled where they begin."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod._util.arrays import Floats
from floquetrod.cli.common import bands_in_numbers, bands_listed
from floquetrod.plane import Axis, Family, Verdicts, charted
from floquetrod.plane.bands import beginning
from floquetrod.plane.family import Names
from floquetrod.plane.merging import merging_tongues
from floquetrod.plane.polygons import contains, with_holes_joined


def comb(rng: np.random.Generator, teeth: int) -> tuple[Floats, Floats]:
    """Return a polygon with teeth that point downwards, and their tips."""
    x = np.linspace(0.05, 0.95, 2 * teeth + 1)
    y = np.where(np.arange(x.size) % 2, rng.uniform(0.05, 0.4, x.size), rng.uniform(0.5, 0.7, x.size))
    y[[0, -1]] = 1.0
    tips = np.column_stack([x, y])[1::2]
    return np.column_stack([x, y]), tips


@pytest.mark.parametrize("seed", range(4))
def test_every_tooth_of_a_comb_is_found_from_each_side(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ring, tips = comb(rng, int(rng.integers(2, 6)))
    for flip in (False, True):
        for turn in (False, True):
            points, wanted = ((1.0 - at if flip else at)[:, :: -1 if turn else 1] for at in (ring, tips))
            for way in (points, points[::-1]):
                feet = merging_tongues(way)
                order = np.lexsort(wanted.T)
                found = np.array([foot.tip for foot in feet])
                assert found[np.lexsort(found.T)] == pytest.approx(wanted[order], abs=1e-12)
                assert contains(points, np.array([foot.inside for foot in feet])).all()


def test_what_is_no_merging_has_none() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    hole = 0.4 + 0.2 * square[::-1]
    bent = np.array([[0.0, 0.0], [0.5, 0.005], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for ring in (square, bent, *with_holes_joined([square, hole])):
        assert merging_tongues(ring) == []


@dataclass(frozen=True)
class Teeth(Family):
    """A comb, whose tooth k is the combination of modes k + 1 and 7, alternately a sum and a difference."""

    ring: Any
    tips: Any
    growth_unit: str = "1/s"
    growth_tolerance: float = 0.0

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return growth within the comb."""
        x, y = np.broadcast_arrays(x, y)
        grows = contains(self.ring, np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)
        return Verdicts(np.where(grows, 0, 1), np.where(grows, y, 0.0))

    def name(self, x: float, y: float) -> Names:
        """Return the name of the nearest tooth; the first is mode 1 alone."""
        tooth = int(np.abs(self.tips[:, 0] - x).argmin())
        return (tooth + 1, (-1) ** tooth * 7 if tooth else None, 1)


def test_merged_tongues_are_named_listed_kept_and_labelled(tmp_path: Path) -> None:
    ring, tips = comb(np.random.default_rng(3), 4)
    x, y = (Axis(name, "", "", np.linspace(0.0, 1.0, 25)) for name in ("across", "up"))
    chart = charted(Teeth(ring, tips), x, y).in_units()
    (band,) = chart.bands
    assert sorted((t.mode, t.partner, t.tongue) for t in band.merged if t.partner) == [
        (2, -7, 1),
        (3, 7, 1),
        (4, -7, 1),
    ]
    for tongue in band.merged:
        assert np.array(tongue.place) == pytest.approx(tips[(tongue.mode or 0) - 1], abs=0.01)
    names = [tongue.name for tongue in band.merged]
    assert {"mode 1, tongue 1", "modes 2 - 7, tongue 1"} < set(names)
    assert all(f"merged: {name}" in bands_listed(chart.bands) for name in names)
    assert [entry["name"] for entry in bands_in_numbers(chart.bands)[0]["merged"]] == names
    chart.save(tmp_path / "chart.npz")
    assert fr.Chart.load(tmp_path / "chart.npz").bands == chart.bands
    scaled = chart.bands.scaled(x, y, (2.0, 1.0))
    assert scaled.bands[0].merged[0].place[0] == 2.0 * band.merged[0].place[0]
    axes = chart.plot()
    axes.figure.canvas.draw()
    drawn = [text for artist in axes.artists for text in getattr(artist, "texts", ()) if text.get_visible()]
    assert {"1·1", "3+7·1"} < {text.get_text() for text in drawn}
    assert len(drawn) == 4
    assert "mode·tongue: 4\N{MINUS SIGN}7·1 is modes 4 - 7" in axes.get_legend().get_title().get_text()
    pyplot.close(axes.figure)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_tongue_that_the_chart_cuts_off_begins_along_the_end_of_the_chart(seed: int) -> None:
    ring, tips = comb(np.random.default_rng(seed), 4)
    least = float(tips[:, 1].mean())  # tips of some teeth lie below
    x, y = (Axis(name, "", "", np.linspace(low, 1.0, 25)) for name, low in (("across", 0.0), ("up", least)))
    bands = charted(Teeth(ring, tips), x, y).bands
    tongues = [(band, tongue) for band in bands for tongue in band.merged]
    rows = [(tongue["name"], *tongue["begins_along"]) for band in bands_in_numbers(bands) for tongue in band["merged"]]
    cut = 0
    for (band, tongue), (name, across, up) in zip(tongues, rows, strict=True):
        tip = tips[(tongue.mode or 0) - 1]
        assert (name, across, up) == (tongue.name, *map(list, beginning(band, tongue)))
        assert up[0] == up[1] == tongue.place[1]
        if tip[1] >= least:
            assert across == [tongue.place[0]] * 2
            assert [across[0], up[0]] == pytest.approx(tip, abs=0.01)
            continue
        cut += 1
        left, right = ring[:-1], ring[1:]
        sides = (left[:, 1] - least) * (right[:, 1] - least) < 0.0
        share = (least - left[sides, 1]) / (right[sides, 1] - left[sides, 1])
        edges = left[sides, 0] + share * (right[sides, 0] - left[sides, 0])
        assert across == pytest.approx([edges[edges < tip[0]].max(), edges[edges > tip[0]].min()], abs=1e-3)
        assert up[0] == least
        assert tongue.place[0] == pytest.approx(0.5 * sum(across))
        assert f"merged: {name} " in bands_listed(bands)
        assert f"begins at {across[0]:.5g} to {across[1]:.5g}, {least:.5g}" in bands_listed(bands)
    assert cut


def pendulums(omega: float, A: float) -> fr.HillSystem:
    """Return two coupled pendulums whose pivot moves by A cos(omega t)."""
    pivot = -A * omega**2 * np.diag([4.0, 6.25])
    stiffness = [[47.24, -8.0], [-8.0, 69.3125]]
    return fr.HillSystem(stiffness, [pivot], damping=0.2 * np.eye(2), period=2.0 * np.pi / omega)


@pytest.mark.slow
def test_the_combination_between_two_tongues_is_named() -> None:
    chart = fr.chart(pendulums, over={"omega": (11.0, 18.0, 60), "A": (0.0, 0.03, 45)})
    (band,) = chart.bands
    assert {tongue.name for tongue in band.merged} == {"mode 1, tongue 1", "mode 2, tongue 1", "modes 1 + 2, tongue 1"}
