"""The explorer's window: a map, the modes on the stability chart, their growth rates, a slider for each quantity."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.plotting import palette
from floquetrod.units import Unit, label

QUANTITIES = ("mean", "amplitude", "frequency")
_NAMES = {
    "mean": ("mean force", r"F_\mathrm{ave}"),
    "amplitude": ("amplitude", r"\Delta F"),
    "frequency": ("frequency", r"\omega"),
}


class View(NamedTuple):
    """What the window shows for one load.

    ``unstable`` is the map over frequency (columns) and mean force (rows); ``chart`` that over ``chart_alpha`` and
    ``chart_beta`` (first, last); ``alpha``, ``beta`` and ``growth`` (1/s) are those of modes 1, 2, ...
    """

    load: dict[str, float]
    unstable: NDArray[np.bool_]
    chart: NDArray[np.bool_]
    chart_alpha: tuple[float, float]
    chart_beta: tuple[float, float]
    alpha: NDArray[np.float64]
    beta: NDArray[np.float64]
    growth: NDArray[np.float64]
    verdict: str


class Window:
    """A matplotlib figure that shows a `View` and reports what its sliders are moved to.

    Axes and labels are drawn once; a new view redraws only what moves, over a copy of the rest, so that it follows the
    slider.  Where axes must grow they do so in steps, with one full drawing each.
    """

    def __init__(
        self,
        limits: dict[str, tuple[float, float]],
        units: dict[str, Unit],
        view: View,
        moved: Callable[[dict[str, float]], View],
    ) -> None:
        """Open the window on ``view``; ``moved`` is asked for the view of a new load, by quantity in SI units.

        ``limits`` and views are in SI units; what is shown, sliders included, is in ``units``.
        """
        from matplotlib import pyplot
        from matplotlib.widgets import Slider

        self.figure: Any = pyplot.figure(figsize=(10.5, 6.6))
        self._moved, self._units = moved, units
        labels = {name: label(*_NAMES[name], units[name].name) for name in QUANTITIES}
        ends = {name: tuple(units[name].of(end) for end in limits[name]) for name in QUANTITIES}
        areas = self.figure.subplots(1, 3)
        self.figure.subplots_adjust(left=0.08, right=0.98, bottom=0.33, top=0.88, wspace=0.32)
        self._map, self._chart, self._bars = areas
        style: dict[str, Any] = {"origin": "lower", "aspect": "auto", "cmap": palette.verdicts(), "vmin": 0, "vmax": 1}
        extent = (*ends["frequency"], *ends["mean"])
        self._map_image = self._map.imshow(view.unstable, extent=extent, interpolation="nearest", **style)
        (self._here,) = self._map.plot([], [], **palette.POINT, markersize=8)
        self._map.set_xlabel(labels["frequency"])
        self._map.set_ylabel(labels["mean"])
        self._map.set_title("unstable loads (orange)", fontsize="medium")
        self._chart_image = self._chart.imshow(view.chart, interpolation="nearest", **style)
        (self._all,) = self._chart.plot([], [], **palette.POINT, linewidth=0.6)
        (self._growing,) = self._chart.plot([], [], "o", color="black")
        self._chart.set_xlabel(r"$\alpha$")
        self._chart.set_ylabel(r"$\beta$")
        self._chart.set_title("modes on the stability chart", fontsize="medium")
        self._stems = self._bars.bar(np.arange(1, view.growth.size + 1), view.growth, color=palette.UNSTABLE)
        self._bars.set_xlabel("mode $m$")
        self._bars.set_ylabel("growth rate / (1/s)")
        self._bars.set_title("growth of each mode", fontsize="medium")
        self._text = self._map.text(
            0.08, 0.94, "", fontsize="large", weight="bold", transform=self.figure.transFigure, clip_on=False
        )
        self.sliders = {}
        for row, name in enumerate(QUANTITIES):
            place = self.figure.add_axes((0.26, 0.16 - 0.055 * row, 0.58, 0.03))
            start, colour = units[name].of(view.load[name]), palette.NEUTRAL
            slider = Slider(place, labels[name], *ends[name], valinit=start, color=colour, initcolor="none")
            slider.drawon = False
            slider.on_changed(self._ask)
            self.sliders[name] = slider
        self._moving = [self._map_image, self._here, self._chart_image, self._all, self._growing, self._text]
        self._moving += self._stems
        for slider in self.sliders.values():
            self._moving += [slider.poly, slider.valtext, *slider.ax.lines]
        for artist in self._moving:
            artist.set_animated(True)
        self._rest: Any = None
        self._frame: Any = None
        self.figure.canvas.mpl_connect("draw_event", self._drawn)
        self.show(view)

    def show(self, view: View) -> None:
        """Replace what is shown."""
        self._map_image.set_data(view.unstable)
        here = [[self._units[name].of(view.load[name])] for name in ("frequency", "mean")]
        self._here.set_data(*here)
        self._chart_image.set_data(view.chart)
        self._all.set_data(view.alpha, view.beta)
        growing = view.growth > 0.0
        self._growing.set_data(view.alpha[growing], view.beta[growing])
        for stem, rate in zip(self._stems, view.growth, strict=True):
            stem.set_height(rate)
        self._text.set_text(view.verdict)
        extent = (*view.chart_alpha, *view.chart_beta)
        highest = _step_above(float(view.growth.max()))
        if self._frame is not None and highest <= self._frame[1] <= 10.0 * highest:
            highest = self._frame[1]  # axes larger than needed do not warrant a full redraw
        canvas = self.figure.canvas
        if self._rest is None or (extent, highest) != self._frame or not canvas.supports_blit:
            self._frame = extent, highest
            self._chart_image.set_extent(extent)
            self._bars.set_ylim(0.0, highest)
            canvas.draw_idle()
        else:
            canvas.restore_region(self._rest)
            self._draw_moving()
            canvas.blit(self.figure.bbox)

    def _drawn(self, _: Any) -> None:
        """Keep a copy of the static parts and draw the moving ones over it."""
        if self.figure.canvas.is_saving():  # then everything is drawn already
            return
        if self.figure.canvas.supports_blit:
            self._rest = self.figure.canvas.copy_from_bbox(self.figure.bbox)
        self._draw_moving()

    def _draw_moving(self) -> None:
        for artist in self._moving:
            artist.axes.draw_artist(artist)

    def _ask(self, _: float) -> None:
        self.show(self._moved({name: float(self._units[name].si(slider.val)) for name, slider in self.sliders.items()}))


def _step_above(value: float) -> float:
    """Return the least of 1, 2, 5, 10, 20, ... that is above ``value``."""
    step = 1.0
    while step <= value:
        step *= 2.5 if f"{step:e}"[0] == "2" else 2.0
    return step
