"""Draw the pictures of the README and of the first page: a string in a well, an equation and a system of equations.

What is drawn is the code of the first page.  Its three pictures, which a phone stacks, are one in the README.

python docs/make_pictures.py
"""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import forge_pages
from matplotlib import pyplot
from PIL import Image

import floquetrod as fr
from floquetrod.plotting import palette

HERE = Path(__file__).parent
COLOURS = 48  # which are enough, and keep the files small
SMALL = "small"


def save(figure: Any, name: str, dpi: int, panel: Any = None) -> None:
    """Save a figure, or one panel of it, with few colours."""
    drawn, box = io.BytesIO(), None
    if panel is not None:
        box = panel.get_tightbbox().padded(8.0).transformed(figure.dpi_scale_trans.inverted())
    figure.savefig(drawn, dpi=dpi, bbox_inches=box)
    Image.open(drawn).convert("RGB").quantize(COLOURS).save(HERE / name, optimize=True)


def first_page() -> dict[str, Any]:
    """Return the names that the code of the first page makes."""
    names: dict[str, Any] = {}
    for cell in forge_pages.cells(forge_pages.source("index")):
        with contextlib.redirect_stdout(io.StringIO()):
            exec(cell.code, names)
    return names


def draw_reach(axes: Any, tubing: fr.Rod, well: fr.WellPath, found: Any) -> None:
    """Draw the force that arrives at the lower end over its depth, without and with the tool."""
    # What arrives is found at a dozen of the depths asked for, here at other ones each time.
    curves = [
        tubing.reach(well, 0.3, tool=found.tool, depth=np.linspace(first, 4500.0, 12))
        for first in np.linspace(150.0, 500.0, 5)
    ]
    for kind, reach, line, label in (
        ("bit", found.reach, "-", "pushed"),
        ("bit_shaken", found.reach_shaken, "--", "with the tool"),
    ):
        depth, force = (np.concatenate([getattr(each, name) for each in curves]) for name in ("bit_depth", kind))
        arrives = np.flatnonzero(np.isfinite(force) & (depth < reach))
        kept = arrives[depth[arrives].argsort()]
        at = np.append(depth[kept], reach)  # where the string is stuck nothing is left
        axes.plot(1e-3 * at, 1e-3 * np.append(force[kept], 0.0), line, color="black", label=label)
    for depth, text in ((found.reach, "stuck"), (found.reach_shaken, "stuck, with the tool")):
        axes.annotate(
            f"{text}\n{depth:.0f} m",
            (1e-3 * depth, 0.0),
            xytext=(-70, 14) if text == "stuck" else (0, 92),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL,
            bbox=palette.BOX,
            arrowprops={"arrowstyle": "->", "linewidth": 0.8},
        )
    axes.set(xlim=(0.0, 4.5), ylim=(0.0, 45.0), xlabel="measured depth / km", ylabel="force at the lower end / kN")
    axes.legend(loc="upper right", fontsize=SMALL, frameon=False)


def bare(axes: Any) -> None:
    """Remove from a chart what stands beside it, and the names of its tongues, which that explains."""
    for artist in (axes.get_legend(), *axes.artists):
        if artist is not None:
            artist.remove()
    for other in [each for each in axes.figure.axes if each.get_label() == "<colorbar>"]:
        other.remove()
    axes.set_title("")


def draw_equation(axes: Any) -> None:
    """Draw the chart of Mathieu's equation, and in it the one of the first page."""
    chart = fr.chart(lambda q, a: fr.Mathieu.from_aq(a=a, q=q), over={"q": (0.0, 5.0, 101), "a": (-2.0, 10.0, 101)})
    chart.plot(axes)
    bare(axes)
    axes.plot(0.9, 1.2, **palette.POINT)
    axes.text(3.4, 0.9, "unstable", ha="center", va="center")
    axes.text(0.9, 2.9, "stable", ha="center", va="center")


def draw_system(axes: Any, oscillators: Any) -> None:
    """Draw the chart of two oscillators with the growth in it, and in it the system of the first page."""
    over = {"omega": (1.5, 4.5, 121), "epsilon": (0.0, 0.6, 61)}
    fr.chart(oscillators, over=over, growth=True).plot(axes)
    bare(axes)
    axes.plot(3.0, 0.2, **palette.POINT)
    axes.text(3.5, 0.3, "stable", ha="center", va="center")
    axes.text(2.47, 0.5, "darker:\nfaster", ha="center", va="center")


if __name__ == "__main__":
    names = first_page()
    figure, panels = pyplot.subplots(1, 3, figsize=(12.0, 3.3), layout="constrained")
    figure.get_layout_engine().set(wspace=0.05)  # so that each panel is cut out with nothing of its neighbour
    draw_reach(panels[0], names["tubing"], names["well"], names["reach"])
    draw_equation(panels[1])
    draw_system(panels[2], names["oscillators"])
    titles = ("How far can tubing be pushed?", "Mathieu's equation", "Two coupled oscillators")
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title, fontsize="medium")
    save(figure, "picture.png", 100)
    for panel, name in zip(panels, ("rod", "equation", "system"), strict=True):
        save(figure, f"picture_{name}.png", 150, panel)
