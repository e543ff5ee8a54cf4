"""The explorer's window: panels, sliders, the verdict above and the command below."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from typing import Any

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import NAMES
from floquetrod.plotting.explorer_panels import GrowthBars, GrowthLine, Map, Modes, ShapeOf
from floquetrod.units import Unit, label

_TICK = 80  # milliseconds between two looks for what has been found meanwhile
_DIGITS = 12  # of a slider's value: what it is meant to be, without rounding
_NARROW = 8.0  # inches: side by side in less, titles overlap
_PER_INCH = {"verdict": 9.0, "details": 11.0, "command": 11.0}
"""Characters in an inch of the lines of each text."""

_LEFT, _BETWEEN, _RIGHT = 0.825, 0.9185, 0.22  # inches beside panels: what is written there does not shrink
_WIDE_TEXTS = {"verdict": (0.03, 0.955), "details": (0.03, 0.905), "busy": (0.98, 0.955), "command": (0.03, 0.045)}
_HIGH_PANELS = [(0.2, 0.735 - 0.23 * place, 0.76, 0.145) for place in range(3)]
_HIGH_TEXTS = {"verdict": (0.03, 0.97), "details": (0.03, 0.923), "busy": (0.98, 0.992), "command": (0.03, 0.022)}
_INLINE = (
    "sliders do not move here: use %matplotlib widget (pip install ipympl),\n"
    "a window, or a browser: floquetrod explore --web"
)


class ExplorerWindow:
    """A matplotlib figure that shows parts of a view as they come, and reports what its sliders are moved to.

    Axes and labels are drawn once; a new view redraws only what moves, over a copy of the rest, so that it follows the
    slider.  Where axes must change they do so in steps, with one full drawing each.
    """

    def __init__(
        self,
        limits: Mapping[str, tuple[float, float]],
        units: Mapping[str, Unit],
        steps: Mapping[str, float],
        panels: tuple[str, str],
        length: float,
        numbers: Mapping[str, float],
        moved: Callable[[str, float], Mapping[str, Any]],
        begin: Callable[[], None],
        fetch: Callable[[], Mapping[str, Any]],
    ) -> None:
        """Open the window.

        ``moved`` is asked for what to show when a quantity has been moved, to a value in SI units; ``begin`` is called
        when a live window has been drawn first, and then ``fetch`` is called repeatedly for the results found since.
        Limits, ``numbers`` to begin with and panels are in SI units, on the screen in ``units``, which has a slider for
        each of its names; ``steps`` of the sliders are in these.
        """
        import matplotlib as mpl
        from matplotlib import pyplot

        self.figure: Any = pyplot.figure(figsize=(11.0, 7.0))
        self._moved, self._begin, self._fetch, self._units = moved, begin, fetch, units
        areas = self.figure.subplots(1, 3)
        self._areas = list(areas)
        kinds: dict[str, Callable[[Any], Any]] = {
            "modes": Modes,
            "rates": GrowthBars,
            "line": lambda ax: GrowthLine(ax, limits["frequency"], units["frequency"]),
            "shape": lambda ax: ShapeOf(ax, length),
        }
        self._panels: dict[str, Any] = {"map": Map(areas[0], limits, units)}
        self._panels |= {name: kinds[name](ax) for name, ax in zip(panels, areas[1:], strict=True)}
        place: dict[str, Any] = {"transform": self.figure.transFigure, "clip_on": False, "va": "center"}
        self._texts = {
            "verdict": areas[0].text(0.0, 0.0, "", fontsize="large", weight="bold", **place),
            "details": areas[0].text(0.0, 0.0, "", fontsize="small", **place),
            "busy": areas[0].text(0.0, 0.0, "", fontsize="small", ha="right", color="0.35", **place),
            "command": areas[0].text(0.0, 0.0, "", fontsize=8.0, family="monospace", **place),
        }
        if mpl.get_backend().lower().endswith("inline"):
            self.figure.text(0.98, 0.955, _INLINE, fontsize="x-small", ha="right", va="center", color="0.35")
        self.sliders: dict[str, Any] = {}
        for name in units:
            self._add_slider(name, limits[name], numbers[name], steps[name])
        self._moving = [artist for panel in self._panels.values() for artist in panel.moving]
        for slider in self.sliders.values():
            self._moving += [slider.poly, slider.valtext, *slider.ax.lines]
        self._moving += self._texts.values()
        for artist in self._moving:
            artist.set_animated(True)
        self._rest: Any = None
        self._timer: Any = None
        self.words: dict[str, str] = {}
        self._arrange()
        self.figure.canvas.mpl_connect("resize_event", lambda _: self._arrange())
        self.figure.canvas.mpl_connect("draw_event", self._drawn)

    @property
    def is_live(self) -> bool:
        """Whether the figure is shown where timers run, in a window, a browser, a notebook with widgets."""
        from matplotlib.backend_bases import TimerBase

        return type(self.figure.canvas.new_timer(_TICK)) is not TimerBase

    def _add_slider(self, name: str, limits: tuple[float, float], start: float, step: float) -> None:
        from matplotlib.widgets import Slider

        class Undrawn(Slider):
            drawon = False  # or every slider would draw the whole figure where nothing defers that

        unit = self._units[name]
        low, high = (unit.of(end) for end in limits)
        slider = Undrawn(
            self.figure.add_axes((0.26, 0.0, 0.58, 0.03), label=name),
            label(*NAMES[name], unit.name),
            low,
            high,
            valinit=unit.of(start),
            valstep=step,
            valfmt="%.6g",
            color=palette.NEUTRAL,
            initcolor="none",
        )
        slider.valtext.set_text(slider.valfmt % unit.of(start))  # which need not be a whole number of steps
        slider.on_changed(lambda value: self.show(self._moved(name, self._meant(name, value))))
        self.sliders[name] = slider

    def _arrange(self) -> None:
        """Lay everything out side by side, or one above the other where the figure is narrow, as on a phone."""
        width = self.figure.get_figwidth()
        wide, across = width >= _NARROW, (width - _LEFT - 2.0 * _BETWEEN - _RIGHT) / 3.0
        side_by_side = [((_LEFT + k * (across + _BETWEEN)) / width, 0.385, across / width, 0.45) for k in range(3)]
        panels = side_by_side if wide else _HIGH_PANELS
        for ax, place in zip(self._areas, panels, strict=True):
            ax.set_position(place)
        for panel in self._panels.values():
            if hasattr(panel, "arrange"):
                panel.arrange()
        for row, slider in enumerate(self.sliders.values()):
            slider.ax.set_position(
                (0.26, 0.235 - 0.055 * row, 0.58, 0.03) if wide else (0.06, 0.169 - 0.05 * row, 0.7, 0.024)
            )
            slider.label.set(
                x=-0.02 if wide else 0.0,
                y=0.5 if wide else 1.05,
                ha="right" if wide else "left",
                va="center" if wide else "bottom",
            )
        for name, at in (_WIDE_TEXTS if wide else _HIGH_TEXTS).items():
            self._texts[name].set_position(at)
        for name, text in self.words.items():
            self._write(name, text)

    def _write(self, name: str, text: str) -> None:
        """Write words in lines that fit the figure."""
        width = max(20, round(_PER_INCH[name] * self.figure.get_figwidth()))
        self._texts[name].set_text(textwrap.fill(text, width, break_on_hyphens=False))

    def _meant(self, name: str, value: float) -> float:
        """Return the SI value that a slider is meant to stand at."""
        return float(self._units[name].si(float(f"{value:.{_DIGITS}g}")))

    def show(self, parts: Mapping[str, Any]) -> None:
        """Replace panels by their names, "load", "busy", and words."""
        changed = self._rest is None
        for name, part in parts.items():
            if name == "load":
                for panel in self._panels.values():
                    if hasattr(panel, "move"):
                        panel.move(part)
            elif name == "busy":
                self._texts["busy"].set_text("refining ..." if part else "")
            elif name in self._panels:
                changed = self._panels[name].show(part) or changed
            else:
                self.words[name] = part
                self._write(name, part)
        canvas = self.figure.canvas
        if changed or not canvas.supports_blit:
            canvas.draw_idle()
        elif parts:
            canvas.restore_region(self._rest)
            self._draw_moving()
            canvas.blit(self.figure.bbox)

    def when_closed(self, then: Callable[[], None]) -> None:
        """Call a function once when the window closes."""
        self.figure.canvas.mpl_connect("close_event", lambda _: self._close(then))

    def _close(self, then: Callable[[], None]) -> None:
        if self._timer is not None:
            self._timer.stop()
        then()

    def _drawn(self, _: Any) -> None:
        """Keep a copy of the static parts and draw the moving ones over it."""
        canvas = self.figure.canvas
        if canvas.is_saving():  # then everything is drawn already
            return
        if canvas.supports_blit:
            self._rest = canvas.copy_from_bbox(self.figure.bbox)
        else:
            self._rest = False
        self._draw_moving()
        if self._timer is None and self.is_live:  # from the first picture on: then there is a loop to wait in
            self._begin()
            self._timer = canvas.new_timer(_TICK)
            self._timer.add_callback(self._look)
            self._timer.start()

    def _draw_moving(self) -> None:
        for artist in self._moving:
            artist.axes.draw_artist(artist)

    def _look(self) -> None:
        parts = self._fetch()
        if len(parts) > 1 or parts["busy"] != bool(self._texts["busy"].get_text()):
            self.show(parts)
