"""Pictures of runs, charts and solutions: titles of one line, one notation, legends beside what they explain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.colors import to_rgb
from matplotlib.patches import Rectangle

import floquetrod as fr
from floquetrod import units
from floquetrod.mathieu import characteristic_function, floquet_solutions
from floquetrod.plotting import palette
from tests.drawn import note

mpl.use("Agg")

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force
LOAD = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
MANY = fr.Perturbation.modes({4: 2.5, 7: -0.01, 8: 1e-3, 9: 2e-3}) + fr.Perturbation.random(1e-3, seed=1)


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


@cache
def run() -> fr.Simulation:
    """Return a short run of many modes."""
    return fr.simulate(ROD, LOAD, duration=0.05, frames=40, friction=0.05, perturbation=MANY)


def boxes(figure: Any) -> tuple[Any, list[Any]]:
    """Return the legends of a drawn figure and their places."""
    figure.draw_without_rendering()
    legends = [ax.get_legend() for ax in figure.axes]
    return legends, [legend.get_window_extent() for legend in legends]


@pytest.mark.slow
def test_a_run_is_titled_in_a_line_and_its_start_told_below() -> None:
    figure = run().plot_run()
    legends, places = boxes(figure)
    (title,) = figure.texts
    assert title.get_text() == (r"mean 0.2 $F_\mathrm{cr}$, amplitude 0.2 $F_\mathrm{cr}$, 150 rad/s, friction 0.05")
    assert len(title._get_wrapped_text().splitlines()) == 1
    assert title.get_window_extent().width < figure.bbox.width
    assert note(figure.axes[1]).startswith(
        "start: 2500 mm/s in mode 4, -10 mm/s in mode 7, 1 mm/s in mode 8, 2 mm/s in mode 9, random speeds up to 1 mm/s"
    )
    for ax, legend, place in zip(figure.axes, legends, places, strict=True):
        assert place.y1 < ax.xaxis.label.get_window_extent().y0
        assert place.y0 >= 0.0
        assert place.x1 < figure.bbox.width
        assert len(legend.get_texts()) == len(ax.get_lines())


@pytest.mark.slow
def test_a_run_off_the_wall_says_so_in_its_picture() -> None:
    thrown = fr.simulate(ROD, LOAD, duration=0.5, perturbation=fr.Perturbation.modes({3: 3.0}))
    assert thrown.note
    assert thrown.named_mode is None
    assert thrown.note in note(thrown.plot_run().axes[1])


@pytest.mark.slow
@pytest.mark.parametrize("plot", ["plot", "plot_energy", pytest.param("plot_growth", marks=pytest.mark.slow)])
def test_legends_of_runs_hide_no_line(plot: str) -> None:
    ax = getattr(run(), plot)()
    _, (place,) = boxes(ax.figure)
    assert place.y1 < ax.bbox.y0
    assert place.y0 >= 0.0


@pytest.mark.parametrize("undecided", [0, 3])
def test_the_legend_of_a_map_with_friction_says_what_the_kick_does(undecided: int) -> None:
    load = {"mean": (0.0, 1.2 * FORCE, 3), "amplitude": 0.7 * FORCE, "frequency": (100.0, 200.0, 3)}
    chart = fr.stability_map(ROD, **load, friction=0.1, kick=0.05).in_units(kick="mm/s")
    words = ["a kick of 50 mm/s buckles it", "a kick of 50 mm/s does not"]
    words[0] += " or undecided" if undecided else ""
    ax = replace(chart, undecided=undecided).plot(bands=False)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == words


@pytest.mark.parametrize("undecided", [0, 3])
@pytest.mark.parametrize("bands", [True, False])
def test_the_legend_of_a_growth_map_says_what_darker_means(undecided: int, bands: bool) -> None:
    chart = fr.stability_map(
        ROD, mean=(0.0, 1.2 * FORCE, 12), amplitude=0.2 * FORCE, frequency=(100.0, 200.0, 16), growth=True
    )
    ax = replace(chart, undecided=undecided).plot(bands=bands)
    words = "unstable or undecided" if undecided else "unstable"
    legend = ax.get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [f"{words}, the darker the faster it grows", "stable"]
    seen = [to_rgb(patch.get_facecolor()) for patch in legend.findobj(Rectangle)]
    assert seen == [to_rgb(colour) for colour in (palette.UNSEEN, palette.UNSTABLE, palette.FASTEST, palette.STABLE)]
    assert [other.get_ylabel() for other in ax.figure.axes[1:]] == ["growth rate / (1/s)"]


@pytest.mark.parametrize(
    ("value", "unit", "digits", "text"),
    [
        (2605.24, "N", 6, "2.60524 kN"),
        (2605.24, "N", 3, "2.61 kN"),
        (-62841.7, "N", 3, "-62.8 kN"),
        (3.1e6, "N", 3, "3.1 MN"),
        (0.339206, "N", 6, "0.339206 N"),
        (0.0041, "N", 3, "4.1 mN"),
        (0.0, "N", 3, "0 N"),
        (2605.24, "lbf", 3, "2610 lbf"),
        (2605.24, "Fcr", 2, "2600 Fcr"),
        (0.25, "", 3, "0.25"),
        (np.nan, "N", 3, "nan N"),
    ],
)
def test_quantities_have_one_notation(value: float, unit: str, digits: int, text: str) -> None:
    assert units.with_unit(value, unit, digits) == text


def test_notes_and_titles_have_one_notation() -> None:
    """No force in newtons by the thousand beside one in kN, and no number with an exponent."""
    tubing = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=30.0, damping_rate=0.2)
    force = tubing.critical_force
    chart = fr.stability_map(tubing, mean=(0.0, 1.1 * force, 8), amplitude=0.2 * force, frequency=(20.0, 40.0, 8))
    for drawn in (chart.plot(bands=False), chart.plot(bands=True)):
        assert drawn.get_title() == f"rod, amplitude {0.2e-3 * force:.3g} kN"
        assert f"critical force {1e-3 * force:.6g} kN" in note(drawn)
    coarse = replace(chart.bands, resolution=(0.124, 130.2))
    assert "narrower than 0.12 rad/s by 130 N may have been missed" in coarse.caption
    scaled = chart.in_units(mean="Fcr", amplitude="Fcr").plot(bands=False)
    assert scaled.get_title() == r"rod, amplitude 0.2 $F_\mathrm{cr}$"
    assert r"amplitude 0.2 $F_\mathrm{cr}$, critical force" in note(scaled)


@pytest.mark.slow
def test_a_long_title_is_cut_to_what_was_asked_and_the_note_has_the_whole() -> None:
    wave = fr.AxialWave(0.0, 0.0, 1.0, far_end="held", axial_damping=2.125, mean_at=0.25)
    chart = fr.stability_map(ROD, wave, mean=(0.0, FORCE, 3), amplitude=0.2 * FORCE, frequency=(20.0, 40.0, 3))
    ax = chart.plot(bands=False)
    ax.figure.draw_without_rendering()
    assert ax.get_title() == "rod, amplitude 0.339 N"
    assert note(ax).startswith(f"{chart.subject['kind']}, amplitude")
    assert ax.title.get_window_extent().width < ax.bbox.width


def test_solutions_tell_their_exponent_with_its_unit() -> None:
    title = floquet_solutions(fr.Mathieu(1.5, -0.6))[0].plot().get_title()
    assert title.endswith(r"i per unit of $\tau$")
    ax = floquet_solutions(fr.Mathieu.from_aq(a=-3.98765432, q=1.23456789))[0].plot()
    drawn = ax.title.get_window_extent(ax.figure.canvas.get_renderer())
    assert ax.figure.bbox.x0 <= drawn.x0 < drawn.x1 <= ax.figure.bbox.x1
    assert "\nexponent 0.1" in title
    assert characteristic_function(3, 10.0, "a").plot().get_title() == "ce_3(z, 10)"


def test_dimensionless_time_has_its_letter_in_notes() -> None:
    ax = fr.mathieu.chart((0.0, 1.0, 8), (-1.0, 0.0, 8), damping=0.1, growth=True).plot(bands=False)
    assert "tau" not in note(ax)
    assert "per unit of \N{GREEK SMALL LETTER TAU}" in note(ax)
    assert "per unit of \N{GREEK SMALL LETTER TAU}" in ax.figure.axes[1].get_ylabel()


def test_a_shape_is_drawn_in_the_unit_of_the_rod() -> None:
    steel = {"youngs_modulus": "207GPa", "density": 7850.0, "diameter": "2in"}
    parts = [fr.Section(**steel, wall_thickness=wall, length="100ft") for wall in ("0.156in", "0.203in")]
    for rod in (
        fr.Rod.catalogue("2.00x0.156", bore="4.778in", length="200ft"),
        fr.Rod(sections=parts, channel_diameter="4.778in"),
    ):
        ax = rod.stability(fr.AxialLoad("1350lbf", "1500lbf", "2Hz", waveform=(1.0, 0.3j)), modes=range(1, 5)).plot()
        assert ax.get_xlabel() == "position from the upper end $s$ / ft"
        assert ax.get_xlim() == pytest.approx((0.0, 200.0))
        pyplot.close(ax.figure)
