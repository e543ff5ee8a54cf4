"""Pictures of bands: shapes in every file, thin ones seen, growth inside them, names where there is room."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import pyplot
from matplotlib.colors import to_rgb
from matplotlib.patches import Rectangle
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod.plane import Axis
from floquetrod.plane.bands import Band, Bands
from floquetrod.plotting import chart_plot, labels, palette
from tests.conftest import depth
from tests.drawn import note

mpl.use("Agg")

X, Y = (Axis(name, "", "", np.array([0.0, 1.0])) for name in ("across", "up"))


def bands_of(*bands: Band, **changes: Any) -> Bands:
    """Return bands over the unit square."""
    whole = {
        "growth_unit": "1/s",
        "growth_tolerance": 0.0,
        "tongues_left_out": 0,
        "accuracy": 1e-3,
        "resolution": (0.0, 0.0),
    }
    return Bands(X, Y, bands, **whole | changes)


def box(x0: float, x1: float, y0: float, y1: float, *names: int | None, turned: bool = False) -> Band:
    """Return a rectangle, passed the other way round where ``turned``."""
    x, y = np.array([x0, x1, x1, x0]), np.array([y0, y0, y1, y1])
    mode, tongue = names or (None, None)
    way = slice(None, None, -1 if turned else 1)
    return Band(x[way], y[way], mode, tongue, 1.0, (0.5 * (x0 + x1), 0.5 * (y0 + y1)))


@dataclass(frozen=True)
class Given:
    """A source that has the answer."""

    bands: Bands
    prompt: bool = True

    def __call__(self, accuracy: float, progress: Any) -> Bands:
        """Return it."""
        return self.bands


def chart_of(bands: Bands, growth: float | None = None, points: int = 40) -> fr.Chart:
    """Return a chart over the unit square, unstable in its bands, where growth is the same everywhere."""
    places = (np.arange(points) + 0.5) / points
    stable = np.ones((points, points), dtype=bool)
    for band in bands:
        x, y = np.meshgrid(places, places)
        stable &= ~((x > band.x.min()) & (x < band.x.max()) & (y > band.y.min()) & (y < band.y.max()))
    rate = None if growth is None else np.where(stable, 0.0, growth)
    axes = (Axis(axis.name, "", "", places) for axis in (X, Y))
    subject = {"kind": "squares", "fixed": [["friction", 0.25, ""]]}
    return fr.Chart(*axes, stable, rate, None, "1/s", subject, 0.0, "", 0, fr.__version__, Given(bands))


def pixels(ax: Any) -> NDArray[np.float64]:
    """Return the inside of axes as it looks, row by row from below, colours from 0 to 1."""
    ax.figure.canvas.draw()
    window = ax.get_window_extent()
    picture = np.asarray(ax.figure.canvas.buffer_rgba())[::-1, :, :3] / 255.0
    return picture[int(window.y0) + 3 : int(window.y1) - 3, int(window.x0) + 3 : int(window.x1) - 3]


def is_colour(picture: NDArray[np.float64], colour: str, within: float = 0.02) -> NDArray[np.bool_]:
    """Return which pixels have a colour."""
    found: NDArray[np.bool_] = (np.abs(picture - to_rgb(colour)) < within).all(axis=-1)
    return found


def written(ax: Any, kind: str) -> bytes:
    """Return the file of a figure."""
    file = io.BytesIO()
    ax.figure.savefig(file, format=kind)
    pyplot.close(ax.figure)
    return file.getvalue()


def shown(ax: Any) -> dict[str, tuple[float, float]]:
    """Return the labels that are drawn, and where in the axes, from 0 to 1."""
    ax.figure.canvas.draw()
    for artist in ax.artists:
        if hasattr(artist, "shown"):
            texts = [text for text in artist.texts if text.get_text() in artist.shown]
            places = ax.transAxes.inverted().transform(np.reshape([text.get_position() for text in texts], (-1, 2)))
            return {text.get_text(): tuple(place) for text, place in zip(texts, places.tolist(), strict=True)}
    return {}


@pytest.mark.slow
def test_files_hold_shapes_and_no_image() -> None:
    bands = bands_of(box(0.1, 0.4, 0.1, 0.9, 7, 1), box(0.6, 0.9, 0.2, 0.8, 8, 1))
    for plot in (bands.plot, chart_of(bands).plot):
        drawing = written(plot(), "svg")
        assert b"<path" in drawing
        assert b"<image" not in drawing
        assert b"/Subtype /Image" not in written(plot(), "pdf")
    assert b"<image" in written(chart_of(bands).plot(bands=False), "svg")


def test_figures_are_opaque_for_dark_pages() -> None:
    drawing = written(bands_of(box(0.1, 0.4, 0.1, 0.9)).plot(), "svg").decode()
    backgrounds = re.findall(r'<g id="patch_[12]">\s*<path d="[^"]*"[^>]*style="([^"]*)"', drawing)
    assert len(backgrounds) == 2
    assert all("fill: #ffffff" in style and "opacity" not in style for style in backgrounds)


@pytest.mark.parametrize("growth", [None, 3.0])
def test_a_band_thinner_than_a_pixel_is_a_line(growth: float | None) -> None:
    thin = bands_of(box(0.3 - 1e-7, 0.3 + 1e-7, 0.0, 1.0), box(0.7, 0.7 + 1e-12, 0.0, 1.0))
    ax = chart_of(thin, growth).plot()
    picture = pixels(ax)
    pyplot.close(ax.figure)
    for place in (0.3, 0.7):
        column = round(place * picture.shape[1])
        line = 1.0 - picture[:, column - 3 : column + 4].min(axis=(1, 2))
        assert line.min() > 0.3  # from below to above, without a gap
    assert is_colour(picture[:, : int(0.28 * picture.shape[1])], palette.STABLE).all()


@pytest.mark.slow
@pytest.mark.parametrize("turned", [False, True])
def test_growth_fills_bands_to_their_edges_and_no_further(turned: bool) -> None:
    # The edges lie between points of the chart; where the two overlap is inside both.
    bands = bands_of(box(0.113, 0.548, 0.2, 0.8), box(0.4, 0.887, 0.3, 0.7, turned=turned))
    ax = chart_of(bands, 3.0, 10).plot()
    picture = pixels(ax)
    pyplot.close(ax.figure)
    rows, columns = picture.shape[:2]
    y, x = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij")

    def inside(x0: float, x1: float, y0: float, y1: float, around: float) -> NDArray[np.bool_]:
        return (x > x0 - around) & (x < x1 + around) & (y > y0 - around) & (y < y1 + around)

    def union(around: float) -> NDArray[np.bool_]:
        return inside(0.113, 0.548, 0.2, 0.8, around) | inside(0.4, 0.887, 0.3, 0.7, around)

    white = is_colour(picture, palette.STABLE)
    assert not white[union(-0.012)].any()
    assert white[~union(0.012)].all()
    fastest = is_colour(picture, palette.FASTEST, 0.05)
    assert fastest[inside(0.45, 0.5, 0.45, 0.55, 0.0)].all()


def test_unknown_growth_is_drawn_as_the_slowest() -> None:
    chart = chart_of(bands_of(box(0.1, 0.9, 0.1, 0.9)), 3.0)
    rate = np.where(chart.x.values < 0.5, chart.growth_rate, np.nan)
    ax = replace(chart, growth_rate=rate).plot()
    picture = pixels(ax)
    pyplot.close(ax.figure)
    assert is_colour(picture[picture.shape[0] // 2, int(0.8 * picture.shape[1])], palette.UNSEEN).all()


@pytest.mark.slow
def test_no_bands_are_no_colours() -> None:
    for growth in (None, 0.0):
        ax = chart_of(bands_of(), growth).plot()
        assert is_colour(pixels(ax), palette.STABLE).all()
        assert "0 unstable bands" in note(ax)
        pyplot.close(ax.figure)


@pytest.mark.slow
def test_files_of_many_bands_stay_small() -> None:
    rng = np.random.default_rng(1)
    corners = rng.random((30_000, 2))  # of four each: a file in which every one is a shape takes 6 MB, or 1
    bands = bands_of(*(box(x, x + 1e-3, y, y + 0.05, 7, 1) for x, y in corners.tolist()))
    for kind, most in {"svg": 1_500_000, "pdf": 800_000}.items():
        assert len(written(bands.plot(), kind)) < most


def test_a_chart_draws_bands_where_it_knows_them(tmp_path: Path) -> None:
    chart = chart_of(bands_of(box(0.1, 0.4, 0.1, 0.9, 7, 1)))

    def said(**how: Any) -> str:
        ax = chart.plot(**how)
        pyplot.close(ax.figure)
        return note(ax)

    expected = "squares, friction 0.25: 1 unstable band; labels mode·tongue: 7·1 is mode 7, tongue 1"
    assert said() == said(bands=True) == expected
    assert "points stable" in said(bands=False)
    chart.find_bands()
    kept = replace(chart, source=None)
    assert kept.plot(bands=False) is not None
    chart = fr.Chart.load(chart.save(tmp_path / "c.npz"))
    assert "1 unstable band" in said()
    chart = kept
    assert "points stable" in said()
    with pytest.raises(ValueError, match="bands must be computed before a chart is saved"):
        kept.plot(bands=True)
    with pytest.raises(TypeError, match="bands must be True or False"):
        kept.plot(bands=3)  # type: ignore[arg-type]
    pyplot.close("all")


def test_captions_say_what_is_left_out() -> None:
    def title(**changes: Any) -> str:
        ax = bands_of(box(0.1, 0.4, 0.1, 0.9), **changes).plot()
        pyplot.close(ax.figure)
        return note(ax)

    assert title() == "1 unstable band"
    assert title(tongues_left_out=1200) == "1 unstable band; 1,200 negligible tongues left out"
    tolerant = title(tongues_left_out=1, growth_tolerance=0.1)
    assert tolerant == "1 unstable band of growth above 0.1 1/s; 1 slower tongue left out"
    assert "bands, and gaps in them, narrower than 0.01 by 0.02 may have been missed" in title(resolution=(0.01, 0.02))


def test_captions_say_what_is_tested_and_what_is_not_known() -> None:
    chart = replace(chart_of(bands_of()), criterion="a test", undecided=3)
    ax = chart.plot()
    pyplot.close(ax.figure)
    assert note(ax).endswith("0 unstable bands; a test; 3 of 1600 points undecided")


def test_labels_name_what_is_known() -> None:
    def said(*names: int | None) -> tuple[str, str]:
        band = box(0.0, 1.0, 0.0, 1.0, *names)
        return labels.label(band), labels.explanation([band])

    assert said(12, 3) == ("12·3", "labels mode·tongue: 12·3 is mode 12, tongue 3")
    assert said(12, None) == ("12", "labels: modes")
    assert said(None, 0) == ("0", "labels: tongues")
    assert said(None, None) == ("", "")
    both = replace(box(0.0, 1.0, 0.0, 1.0, 1, 3), partner=2)
    assert (labels.label(both), both.name) == ("1+2·3", "modes 1 + 2, tongue 3")
    assert repr(both) == "<modes 1 + 2, tongue 3: 4 vertices, largest growth 1 at (0.5, 0.5)>"
    assert labels.label(replace(both, partner=-2)) == "1\N{MINUS SIGN}2·3"


def test_labels_lie_in_their_bands_and_nowhere_else() -> None:
    wide, other, thin = box(0.1, 0.5, 0.1, 0.9, 7, 1), box(0.4, 0.9, 0.3, 0.6, 8, 1), box(0.95, 0.96, 0.0, 1.0, 9, 1)
    places = shown(bands_of(wide, other, thin).plot())
    assert places.keys() == {"7·1", "8·1", "9·1"}
    assert places["9·1"][0] > 0.9
    assert not 0.95 < places["9·1"][0] < 0.96  # beside it
    assert 0.1 < places["7·1"][0] < 0.4
    assert 0.5 < places["8·1"][0] < 0.9
    assert shown(bands_of(wide, box(0.1, 0.5, 0.1, 0.9, 8, 1)).plot()) == {}  # one over the other
    pyplot.close("all")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(20, 5)))
def test_a_few_narrow_bands_have_their_names_beside(seed: int) -> None:
    rng = np.random.default_rng([51, seed])
    edges = np.sort(rng.uniform(0.02, 0.95, 5)) + 0.01 * np.arange(5)
    thin = [box(x, x + 0.004, low := rng.uniform(0.0, 0.7), low + 0.2, i, 1) for i, x in enumerate(edges, start=1)]
    ax = bands_of(*thin).plot()
    ax.figure.canvas.draw()
    (names,) = (artist for artist in ax.artists if hasattr(artist, "shown"))
    boxes = [text.get_window_extent() for text in names.texts if text.get_text() in names.shown]
    assert len(boxes) >= 4  # one may have no room
    for i, name in enumerate(boxes):
        assert not any(name.overlaps(other) for other in boxes[:i])
        for band in thin:
            ends = ax.transData.transform(np.column_stack([band.x, band.y]))
            assert not name.overlaps(Bbox([ends.min(axis=0), ends.max(axis=0)]))
    for number, line in names.lines.items():
        x, y = ax.transData.inverted().transform(line[0])
        band = names.shapes[number]
        assert band.x.min() - 0.005 < x < band.x.max() + 0.005
        assert band.y.min() - 0.01 < y < band.y.max() + 0.01
    pyplot.close(ax.figure)
    assert shown(bands_of(*(box(x, x + 0.002, 0.0, 1.0, 1, 1) for x in np.linspace(0.05, 0.9, 7))).plot()) == {}
    pyplot.close("all")


@pytest.mark.slow
def test_no_line_to_a_name_crosses_another_band() -> None:
    wide, sliver = box(0.5, 0.58, 0.002, 1.0, 7, 1), box(0.5, 0.58, 0.0, 0.001, 8, 1)
    assert shown(bands_of(wide, sliver).plot()).keys() == {"7·1"}
    assert shown(bands_of(replace(wide, mode=None, tongue=None), sliver).plot()) == {}  # one without a name
    assert shown(bands_of(sliver).plot()).keys() == {"8·1"}
    pyplot.close("all")


@pytest.mark.slow
def test_labels_avoid_markers_lines_texts_and_legends() -> None:
    def place(*what: str) -> tuple[float, float] | None:
        ax = bands_of(box(0.35, 0.65, 0.0, 1.0, 7, 1)).plot()
        if "mark" in what:
            chart_plot.mark(ax, 0.5, 0.5, "the load")
        if "lines" in what:
            ax.plot([0.0, 1.0, np.nan, 0.0, 1.0], [0.5, 0.5, np.nan, 0.45, 0.45], color="black")
        if "legend" in what:
            ax.plot([2.0], [2.0], color="black", label="a line of words, long enough to cover the band")
            ax.legend(loc="lower center")
        found = shown(ax).get("7·1")
        pyplot.close(ax.figure)
        return found

    assert place() == pytest.approx((0.5, 0.5), abs=0.02)
    for what in (["mark"], ["lines"], ["mark", "lines", "legend"]):
        found = place(*what)
        assert found is not None
        assert abs(found[1] - 0.5) > 0.02


@pytest.mark.slow
def test_labels_follow_the_axes() -> None:
    ax = bands_of(box(0.1, 0.12, 0.1, 0.9, 7, 1)).plot()
    ((column, _),) = shown(ax).values()
    assert not 0.1 <= column <= 0.12
    ax.set_xlim(0.09, 0.13)
    ((column, _),) = shown(ax).values()
    assert 0.25 < column < 0.75  # inside it
    ax.set_xlim(0.5, 0.6)
    assert shown(ax) == {}
    pyplot.close(ax.figure)


@settings(max_examples=depth(60, 15), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(3, 12))
def test_a_label_fits_into_its_polygon(seed: int, corners: int) -> None:
    rng = np.random.default_rng(seed)
    turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, corners))
    size = rng.uniform(5.0, 40.0, corners)
    x, y = 40.3 + size * np.cos(turn), 30.2 + size * np.sin(turn)
    inside = labels.cells_inside(x, y, (60, 80))
    rows, columns = np.mgrid[:60, :80]
    path = mpl.path.Path(np.column_stack([x, y]))
    assert (inside == path.contains_points(np.column_stack([columns.ravel(), rows.ravel()])).reshape(60, 80)).all()
    (found,) = labels.places([(x, y, 7.0, 4.0)], np.ones((60, 80), dtype=bool))
    fits = [
        (row, column) for row in range(57) for column in range(74) if inside[row : row + 4, column : column + 7].all()
    ]
    assert (found is not None) == bool(fits)
    if found is not None:
        left, bottom = int(found[0] - 3.0), int(found[1] - 1.0)
        assert inside[bottom : bottom + 4, left : left + 7].all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bands", "growth"),
    [
        pytest.param(True, True, marks=pytest.mark.slow),
        pytest.param(False, True, marks=pytest.mark.slow),
        (True, False),
    ],
)
def test_titles_fit_in_a_line_and_notes_in_the_picture(growth: bool, bands: bool) -> None:
    """What was asked is the title; provenance, names and colours are told below the axes."""
    tubing = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=30.0)
    force = tubing.critical_force
    chart = fr.stability_map(
        tubing, mean=(0.0, 1.2 * force, 30), amplitude=0.2 * force, frequency=(5.0, 30.0, 40), growth=growth
    ).in_units(mean="kN", frequency="Hz")
    ax = chart.plot(bands=bands)
    figure = ax.figure
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    title, legend = ax.title, ax.get_legend()
    assert title.get_text() == "rod, amplitude 2.61 kN"
    assert len(title._get_wrapped_text().splitlines()) == 1
    assert title.get_window_extent(renderer).width < ax.bbox.width
    box = legend.get_window_extent(renderer)
    assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width
    assert box.y0 >= 0.0
    assert box.y1 < ax.xaxis.label.get_window_extent(renderer).y0
    unstable, stable = (text.get_text() for text in legend.get_texts())
    assert (unstable, stable) == ("unstable, the darker the faster it grows" if growth else "unstable", "stable")
    shades = [palette.UNSEEN, palette.UNSTABLE, palette.FASTEST] if growth else [palette.UNSTABLE]
    assert [to_rgb(patch.get_facecolor()) for patch in legend.findobj(Rectangle)] == [
        to_rgb(colour) for colour in (*shades, palette.STABLE)
    ]
    assert "critical force 13.0262 kN" in note(ax)
    assert ("mode" in note(ax)) == bands
    pyplot.close(figure)


def test_notes_of_panels_side_by_side_stay_apart() -> None:
    figure, axes = pyplot.subplots(1, 2, figsize=(10.0, 4.4), layout="constrained", sharey=True)
    for ax in axes:
        chart_plot.explain(ax, chart_plot.colours("unstable", "stable"), "a note of many words " * 8)
    figure.canvas.draw()
    left, right = (ax.get_legend().get_window_extent() for ax in axes)
    assert left.x1 < right.x0
    assert min(ax.bbox.width for ax in axes) > 0.4 * figure.bbox.width  # notes take no room from the panels
    pyplot.close(figure)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(40, 1)))
def test_what_a_note_explains_is_drawn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rod = fr.Rod.nitinol()
    force, low, first = rod.critical_force, rng.uniform(0.0, 0.8), rng.uniform(15.0, 120.0)
    chart = fr.stability_map(
        rod,
        mean=(low * force, (low + rng.uniform(0.1, 0.6)) * force, 20),
        amplitude=float(rng.choice([0.01, 0.05, 0.2, 0.5])) * force,
        frequency=(first, first * rng.uniform(1.2, 3.0), 24),
        growth=bool(rng.integers(2)),
    )
    chart.find_bands()
    for ax in (chart.plot(), chart.bands.plot()):
        for size in ((7.0, 5.0), (5.0, 5.5), (12.0, 9.0))[: depth(3, 2)]:
            ax.figure.set_size_inches(*size)
            ax.figure.canvas.draw()
            drawn = [name for artist in ax.artists if hasattr(artist, "shown") for name in artist.shown]
            explained = re.search(r"labels mode·tongue: (\S+) is modes? \S+", note(ax))
            assert (explained is not None) is bool(drawn), note(ax)
            assert explained is None or explained[1] in drawn
        pyplot.close(ax.figure)
