"""Thumbnails of the gallery: of one size, drawn for it, so that their text and lines can be read."""

from __future__ import annotations

import io
import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import image, pyplot
from matplotlib.text import Text

import floquetrod as fr

mpl.use("Agg")

DOCS = Path(__file__).parents[2] / "docs"
THUMBNAILS = SimpleNamespace(**runpy.run_path(str(DOCS / "thumbnails.py")))


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


def panels() -> Any:
    """Return a figure as examples draw them: two panels of one axis, small text, legends, notes, a scale."""
    figure, (above, below) = pyplot.subplots(2, 1, sharex=True, figsize=(8.0, 6.0), layout="constrained")
    above.plot([0.0, 1234.0], [0.0, 5.0], linewidth=0.8, label="a line")
    above.annotate("7", (600.0, 2.0), fontsize="x-small")
    above.annotate("a remark that reaches beyond a small panel", (1000.0, 2.0))
    above.set_title("a title", fontsize="small")
    above.set_title("(a)", loc="left")
    above.set_ylabel("height / m", fontsize="small")
    above.legend(fontsize="small")
    figure.colorbar(below.pcolormesh([[1.0, 2.0], [3.0, 4.0]]), ax=below)
    below.set_xlabel("length / m")
    figure.suptitle("a title of all")
    figure.supylabel("a label of all")
    figure.legend(loc="outside lower center")
    return figure


def picture(figure: Any) -> Any:
    """Return the pixels of a thumbnail."""
    file = io.BytesIO()
    figure.savefig(file, dpi=THUMBNAILS.DPI)
    file.seek(0)
    return image.imread(file)


def test_a_thumbnail_is_the_first_panel_in_large_text() -> None:
    figure = panels()
    THUMBNAILS.redraw(figure)
    assert picture(figure).shape[:2] == (420, 600)
    (panel,) = figure.axes
    written = {text.get_text(): text for text in panel.findobj(Text) if text.get_text() and text.get_visible()}
    assert {"7", "a label of all", "length / m", "0", "1000"} <= written.keys()
    assert not {"a title", "(a)", "a remark that reaches beyond a small panel"} & written.keys()
    assert panel.get_legend() is None
    assert not [*figure.texts, *figure.legends]
    sizes = {name: text.get_fontsize() for name, text in written.items()}
    assert min(sizes.values()) >= THUMBNAILS.SMALL
    assert sizes["a label of all"] == THUMBNAILS.LARGE
    assert panel.get_lines()[0].get_linewidth() == pytest.approx(0.8 * THUMBNAILS.THICKER)
    # Everything is in the picture, and the panel takes most of it.
    around = panel.get_tightbbox()
    assert 0.0 <= around.x0 < around.x1 <= figure.bbox.width
    assert 0.0 <= around.y0 < around.y1 <= figure.bbox.height
    assert panel.bbox.width * panel.bbox.height > 0.5 * figure.bbox.width * figure.bbox.height


def test_letters_of_a_thumbnail_are_as_high_as_those_of_a_page() -> None:
    """A thumbnail is shown at about half its pixels: ten points are then ten pixels."""
    figure = panels()
    THUMBNAILS.redraw(figure)
    (label,) = (text for text in figure.axes[0].texts if text.get_text() == "7")
    assert label.get_window_extent().height / 2 >= 7.0


def test_texts_that_would_overlap_are_left_out() -> None:
    figure, ax = pyplot.subplots(figsize=(8.0, 6.0))
    box = {"boxstyle": "round", "facecolor": "white"}
    for x, name in ((0.2, "Hopf 3"), (0.3, "flip 2"), (0.8, "Hopf 1")):
        ax.annotate(name, (x, 0.5), bbox=box)
    THUMBNAILS.redraw(figure)
    assert [text.get_text() for text in ax.texts] == ["Hopf 3", "Hopf 1"]


def test_names_of_bands_grow_too() -> None:
    ax = fr.mathieu.chart((0.0, 3.0, 20), (-4.5, 1.0, 20)).plot()
    THUMBNAILS.redraw(ax.figure)
    (names,) = (artist for artist in ax.artists if hasattr(artist, "shown"))
    assert "1" in names.shown
    assert {text.get_fontsize() for text in names.texts} == {THUMBNAILS.SMALL}


@pytest.mark.slow
def test_the_first_picture_saved_is_the_thumbnail(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Later figures and blocks have none, and what sphinx-gallery saves is the figure as it was."""
    scrapers = SimpleNamespace(matplotlib_scraper=save_as_sphinx_gallery)
    monkeypatch.setitem(sys.modules, "sphinx_gallery", SimpleNamespace(scrapers=scrapers))
    monkeypatch.setitem(sys.modules, "sphinx_gallery.scrapers", scrapers)
    paths = Paths(tmp_path)
    block = {"image_path_iterator": paths}
    assert THUMBNAILS.scraper(None, block, {}) == ""
    assert len(paths) == 0
    expected = picture(panels())
    pyplot.close("all")
    panels()
    pyplot.figure(figsize=(3.0, 2.0))
    assert THUMBNAILS.scraper(None, block, {}) == "2.png 3.png"
    pyplot.figure(figsize=(3.0, 2.0))
    assert THUMBNAILS.scraper(None, block, {}) == "4.png"
    assert not pyplot.get_fignums()
    small, whole, *others = (image.imread(path) for path in paths.given)
    assert small.shape[:2] == (420, 600)
    assert np.array_equal(whole, expected)
    assert [other.shape[:2] for other in others] == [(300, 450), (300, 450)]


class Paths:
    """Paths as sphinx-gallery numbers them."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.given = folder, []

    def __len__(self) -> int:
        return len(self.given)

    def __next__(self) -> Path:
        self.given.append(self.folder / f"{len(self) + 1}.png")
        return self.given[-1]


def save_as_sphinx_gallery(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save and close all figures, as sphinx-gallery's own scraper does; return where."""
    names = []
    for number in pyplot.get_fignums():
        path = next(block_vars["image_path_iterator"])
        pyplot.figure(number).savefig(path, dpi=THUMBNAILS.DPI)
        names.append(path.name)
    pyplot.close("all")
    return " ".join(names)
