"""Draw a string in a well and a rod in its channel, with the symbols of the pages, for light and for dark pages.

python docs/make_drawings.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

from matplotlib import pyplot
from matplotlib.patches import Arc, Circle, Polygon

from floquetrod.plotting import palette

HERE = Path(__file__).parent
WIDTH = 4.6  # inches, and units of a drawing; 350 pixels of a phone are three quarters of it
STYLE = {"svg.fonttype": "path", "svg.hashsalt": "floquetrod", "font.size": 12.0, "mathtext.fontset": "dejavusans"}


class Drawing:
    """An empty drawing, and what its parts have in common: the colours of a page, arrows, dimensions, words."""

    def __init__(self, height: float, theme: int) -> None:
        """Begin a drawing of a height in inches, for a light page with ``theme`` 0, for a dark one with 1."""
        self.ink, self.page, self.line = (palette.PAGE[name][theme] for name in ("ink", "page", "line"))
        self.figure = pyplot.figure(figsize=(WIDTH, height))
        self.axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, WIDTH), ylim=(0.0, height))
        self.axes.axis("off")

    def words(self, x: float, y: float, text: str, **options: Any) -> None:
        """Write words; centred, unless the options say where from."""
        self.axes.text(x, y, text, color=self.ink, **{"ha": "center", "va": "center", **options})

    def path(self, x: Any, y: Any, **options: Any) -> None:
        """Draw a line through points."""
        self.axes.plot(x, y, **{"color": self.ink, "linewidth": 1.0, "solid_capstyle": "round", **options})

    def arrow(self, start: tuple[float, float], end: tuple[float, float], ends: str = "-|>", **options: Any) -> None:
        """Draw an arrow; with ``ends`` "<|-|>" a dimension."""
        style = {"arrowstyle": ends, "color": self.ink, "linewidth": 1.0, "shrinkA": 0.0, "shrinkB": 0.0, **options}
        self.axes.annotate("", end, start, arrowprops=style)

    def save(self, name: str) -> None:
        """Save the drawing, without the ground of its page."""
        self.figure.savefig(HERE / name, transparent=True, metadata={"Date": None})
        pyplot.close(self.figure)


def well(theme: int) -> Drawing:
    """Draw a string that is pushed into a well which builds from the vertical to a lateral, with a vibration tool."""
    drawing = Drawing(3.5, theme)
    radius, top, start = 1.3, 2.95, 0.75  # of the build; the surface; where the well begins
    kick_off = 2.2
    turn = np.linspace(0.0, 0.5 * np.pi, 60)

    def along(offset: float, to: float = 4.35) -> tuple[Any, Any]:
        """Return a line at a distance from the axis of the well, to the outside of its build."""
        x = start + radius - (radius + offset) * np.cos(turn)
        y = kick_off - (radius + offset) * np.sin(turn)
        return np.r_[start - offset, x, to], np.r_[top, y, y[-1]]

    outside, inside = along(0.13), along(-0.13)
    drawing.axes.fill(
        np.r_[outside[0], inside[0][::-1]], np.r_[outside[1], inside[1][::-1]], color=drawing.line, alpha=0.35, lw=0.0
    )
    for wall in (outside, inside):
        drawing.path(*wall, color=drawing.line, linewidth=1.6)
    drawing.path([0.1, start - 0.13], [top, top], color=drawing.line, linewidth=1.6)
    drawing.path([start + 0.13, 4.4], [top, top], color=drawing.line, linewidth=1.6)
    drawing.path(*along(0.07, 4.1), linewidth=3.2)
    level = kick_off - radius - 0.07
    tool = [(3.25, level - 0.07), (3.65, level - 0.07), (3.65, level + 0.07), (3.25, level + 0.07)]
    drawing.axes.add_patch(Polygon(tool, facecolor=palette.UNSTABLE, edgecolor=drawing.ink, linewidth=1.0, zorder=3))

    drawing.arrow((start - 0.07, 3.45), (start - 0.07, top + 0.04))
    drawing.words(start + 0.06, 3.27, "push at the surface", ha="left")
    drawing.words(start + 0.3, 2.6, "rod or string", ha="left")
    drawing.arrow((start + 0.27, 2.6), (start - 0.03, 2.6), "->")

    angle = np.radians(42.0)
    x, y = start + radius - radius * np.cos(angle), kick_off - radius * np.sin(angle)
    drawing.path([x, x], [y, y - 0.85], linestyle=(0, (4, 3)))
    drawing.path([x, x + 0.8 * np.sin(angle)], [y, y - 0.8 * np.cos(angle)], linestyle=(0, (4, 3)))
    drawing.axes.add_patch(Arc((x, y), 1.2, 1.2, theta1=270.0, theta2=270.0 + 42.0, color=drawing.ink, linewidth=1.0))
    drawing.words(x + 0.18, y - 0.46, r"$\phi$", fontsize=14)
    drawing.words(0.1, y - 1.02, "inclination $\\phi$, from the vertical", ha="left")

    drawing.words(3.5, level + 0.6, "vibration tool")
    drawing.arrow((3.45, level + 0.46), (3.45, level + 0.1), "->")
    drawing.arrow((3.65, level - 0.36), (4.1, level - 0.36), "<|-|>")
    drawing.words(3.87, level - 0.54, "above_end")
    for place in (3.65, 4.1):
        drawing.path([place, place], [level - 0.43, level - 0.23], color=drawing.line)
    drawing.words(2.45, level + 0.98, "well, bore")
    drawing.arrow((2.45, level + 0.84), (2.45, level + 0.22), "->")
    return drawing


def rod(theme: int) -> Drawing:
    """Draw a rod that is pushed at both ends in its channel, from above and in a section across."""
    drawing = Drawing(3.5, theme)
    left, right, middle, half = 0.75, 3.85, 2.72, 0.34
    s = np.linspace(left, right, 400)
    drawing.axes.fill_between([left, right], middle - half, middle + half, color=drawing.line, alpha=0.35, linewidth=0)
    for wall in (middle - half, middle + half):
        drawing.path([left, right], [wall, wall], color=drawing.line, linewidth=1.6)
    drawing.path(s, middle + 0.15 * np.sin(5.0 * np.pi * (s - left) / (right - left)), linewidth=3.2)
    for end, way in ((left, -1.0), (right, 1.0)):
        drawing.arrow((end + 0.45 * way, middle), (end + 0.06 * way, middle))
    drawing.words(0.5 * WIDTH, 3.31, r"$F(t) = F_{\mathrm{ave}} + \Delta F\,\sin\omega t$ at both ends")
    drawing.arrow((left, middle - 0.52), (right, middle - 0.52), "<|-|>")
    drawing.words(0.5 * WIDTH, middle - 0.7, "$L$, seen from above")

    x, y, channel, radius = 1.0, 0.88, 0.8, 0.22
    gap, angle = channel - radius, np.radians(50.0)
    centre = x + gap * np.sin(angle), y - gap * np.cos(angle)
    drawing.axes.add_patch(Circle((x, y), channel, color=drawing.line, alpha=0.35, linewidth=0.0))
    drawing.axes.add_patch(Circle((x, y), channel, fill=False, color=drawing.line, linewidth=1.6))
    section = {"facecolor": drawing.page, "edgecolor": drawing.ink, "linewidth": 1.6}
    drawing.axes.add_patch(Circle(centre, radius, **section, zorder=3))
    drawing.path([x, x], [y, y - channel], linestyle=(0, (4, 3)))
    drawing.arrow((x, y), centre, zorder=4)
    drawing.axes.add_patch(Arc((x, y), 0.56, 0.56, theta1=270.0, theta2=320.0, color=drawing.ink, linewidth=1.0))
    drawing.words(x + 0.12, y - 0.4, r"$\theta$", fontsize=13)
    drawing.words(x + 0.34, y - 0.1, "$R$", fontsize=13)
    drawing.arrow((x, y), (x - channel * np.cos(0.6), y + channel * np.sin(0.6)))
    drawing.words(x - 0.2, y + 0.34, "$R + r_o$", ha="left")
    lines = (
        "$R$  radial clearance",
        "$r_o$  radius of the rod",
        "$R + r_o$  radius of the channel",
        r"$\theta(s, t)$  angle on the wall",
        "$s$  from the upper end",
    )
    for number, line in enumerate(lines):
        drawing.words(2.02, 1.52 - 0.3 * number, line, ha="left")
    return drawing


if __name__ == "__main__":
    with mpl.rc_context(STYLE):
        for theme, page in enumerate(("light", "dark")):
            well(theme).save(f"drawing_well_{page}.svg")
            rod(theme).save(f"drawing_rod_{page}.svg")
