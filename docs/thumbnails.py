"""Thumbnails of the gallery, drawn for their size: the first panel of the first figure, with large text and no legend.

A figure shrunk to a thumbnail has lines and letters of three pixels.  `scraper` is what sphinx-gallery calls for each
block of an example: it saves the figures as they are and, before an example's first one, its thumbnail.  The first
picture saved is what sphinx-gallery makes the thumbnail of; it is on no page.
"""

from __future__ import annotations

from typing import Any

SIZE = 4.0, 2.8  # inches
DPI = 150
LARGE, SMALL = 12.0, 10.0  # points: labels of axes, all other text
THICKER = 1.5  # lines, compared with the figure
STEPS = 4  # between the numbers of an axis


def scraper(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any], **options: Any) -> str:
    """Save the figures of a block, after the thumbnail of the first one of an example; return the block's text."""
    from matplotlib import pyplot
    from sphinx_gallery.scrapers import matplotlib_scraper

    paths, numbers = block_vars["image_path_iterator"], pyplot.get_fignums()
    if not numbers or len(paths):
        return str(matplotlib_scraper(block, block_vars, gallery_conf, **options))
    figure, thumbnail = pyplot.figure(numbers[0]), next(paths)
    text = str(matplotlib_scraper(block, block_vars, gallery_conf, **options))
    redraw(figure)
    figure.savefig(thumbnail, dpi=DPI)
    return text


def redraw(figure: Any) -> None:
    """Turn a figure into one that can be read at the size of a thumbnail, of its first panel alone."""
    from matplotlib.collections import PathCollection
    from matplotlib.text import Text

    panel = figure.axes[0]
    _keep_alone(figure, panel)
    _write_large(panel)
    for line in panel.get_lines():
        line.set_linewidth(THICKER * line.get_linewidth())
    for points in panel.findobj(PathCollection):
        points.set_sizes(THICKER * points.get_sizes())
    figure.set_size_inches(SIZE)
    figure.set_dpi(DPI)
    figure.set_layout_engine("constrained")
    inside = [text for text in panel.texts if isinstance(text, Text)]
    for text in inside:
        text.set_in_layout(False)
    figure.draw_without_rendering()
    kept: list[Any] = []
    for text in inside:  # what was placed for a larger panel has no room in every small one
        box = _box(text)
        (x0, y0), (x1, y1) = box.get_points()
        within = panel.bbox.x0 < x0 and x1 < panel.bbox.x1 and panel.bbox.y0 < y0 and y1 < panel.bbox.y1
        if within and not any(box.overlaps(other) for other in kept):
            kept.append(box)
        else:
            text.remove()


def _box(text: Any) -> Any:
    """Return where a text is, with the frame about it."""
    frame = text.get_bbox_patch()
    return text.get_window_extent() if frame is None else frame.get_window_extent()


def _keep_alone(figure: Any, panel: Any) -> None:
    """Remove all other panels, titles and legends; the panel gets the label of an axis that it shares."""
    from matplotlib.gridspec import GridSpec

    labels = [other.get_xlabel() for other in panel.get_shared_x_axes().get_siblings(panel)]
    panel.set_xlabel(max(labels, key=len))
    panel.tick_params(labelbottom=True)
    panel.set_ylabel(figure.get_supylabel() or panel.get_ylabel())
    for other in figure.axes[1:]:
        other.remove()
    for each in (*figure.texts, *figure.legends, *filter(None, [panel.get_legend()])):
        each.remove()
    for name in ("_suptitle", "_supxlabel", "_supylabel"):
        setattr(figure, name, None)
    for place in ("left", "center", "right"):
        panel.set_title("", loc=place)
    panel.set_subplotspec(GridSpec(1, 1, figure=figure)[0])


def _write_large(panel: Any) -> None:
    """Give all text the size of a thumbnail, and axes so few numbers that these have room."""
    from matplotlib.text import Text
    from matplotlib.ticker import FixedLocator, MaxNLocator

    for axis in (panel.xaxis, panel.yaxis):
        axis.label.set_fontsize(LARGE)
        if axis.get_scale() == "linear" and not isinstance(axis.get_major_locator(), FixedLocator):
            axis.set_major_locator(MaxNLocator(STEPS, steps=[1, 2, 2.5, 5, 10]))
    panel.tick_params(labelsize=SMALL)
    names = [text for artist in panel.artists for text in getattr(artist, "texts", ())]  # of bands
    for text in (*panel.findobj(Text), *names):
        text.set_fontsize(max(SMALL, text.get_fontsize()))
