"""The panels of the explorer's window: a map, modes among tongues and their rates, growth over frequency, a shape.

Each panel has ``moving`` artists, drawn again for each view over a copy of everything else; `show` returns whether that
everything else has changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.plotting import palette, shapes
from floquetrod.plotting.chart_plot import NAMES
from floquetrod.plotting.leaders import name_bands
from floquetrod.units import Unit, label

UNKNOWN = -2
"""Cells of a map without a verdict yet; the others are a status, undecided -1, unstable 0, stable 1."""

_STRAIGHT = 2.0  # natural frequencies over the load's up to which their axis is linear: the first four tongues
_TICKS = (0, 1, 10, 100, 1000, -1, -10, -100, -1000, 0.5, 2, 5, 20, 50, -2, 1.5)
"""Natural over load frequencies to write on their axis where there is room, the most important first."""
_HALF_DIGIT = 3.2  # points that half a digit of a tick takes
_MOST_LABELS = 16  # modes named on the chart


class MapView(NamedTuple):
    """Cells over frequency (columns) and mean force (rows), and the bands they belong to, where these are known."""

    cells: NDArray[np.int8]
    bands: Any


class ModesView(NamedTuple):
    """Modes by number: natural over load frequency, negative where buckled, alpha, growth in 1/s.

    ``frame`` holds the ends of both axes; ``tongues`` the unstable points between them, evenly spaced as drawn, None
    where both are as they were.
    """

    numbers: NDArray[np.int64]
    ratio: Floats
    alpha: Floats
    growth: Floats
    frame: tuple[float, float, float, float]
    tongues: NDArray[np.bool_] | None


class RatesView(NamedTuple):
    """Growth of modes by number, in 1/s."""

    numbers: NDArray[np.int64]
    growth: Floats


class LineView(NamedTuple):
    """Growth in 1/s over the frequency in rad/s; NaN where it is not known."""

    frequency: Floats
    growth: Floats


class ShapeView(NamedTuple):
    """A solution along the rod, in m: one instant, and its envelope over a period; its name and growth in 1/s."""

    s: Floats
    deflection: Floats
    envelope: Floats
    name: str
    growth: float


class Map:
    """Safe loads at one amplitude, and where the load is."""

    def __init__(self, ax: Any, limits: Mapping[str, tuple[float, float]], units: Mapping[str, Unit]) -> None:
        """Prepare axes between the limits, in SI units."""
        from matplotlib.colors import ListedColormap

        self._ax, self._units = ax, units
        ends = {name: tuple(units[name].of(end) for end in limits[name]) for name in ("frequency", "mean")}
        colours = ListedColormap([palette.UNKNOWN, palette.NEUTRAL, palette.UNSTABLE, palette.STABLE])
        self._image = ax.imshow(
            [[UNKNOWN]],
            extent=(*ends["frequency"], *ends["mean"]),
            origin="lower",
            aspect="auto",
            interpolation="nearest",
            cmap=colours,
            vmin=UNKNOWN - 0.5,
            vmax=1.5,
        )
        (self._here,) = ax.plot([], [], **palette.POINT, markersize=8)
        ax.set_xlim(*ends["frequency"])
        ax.set_ylim(*ends["mean"])
        ax.set_xlabel(label(*NAMES["frequency"], units["frequency"].name))
        ax.set_ylabel(label(*NAMES["mean"], units["mean"].name))
        ax.set_title("orange: unstable at this amplitude", fontsize="medium")
        self._bands: Any = None
        self._drawn: list[Any] = []
        self.moving = [self._image, self._here]

    def move(self, load: Mapping[str, float]) -> None:
        """Move the mark to a load, in SI units."""
        self._here.set_data(*([self._units[name].of(load[name])] for name in ("frequency", "mean")))

    def show(self, view: MapView) -> bool:
        """Show cells, or bands where they are known."""
        if view.bands is not None and view.bands is self._bands:
            return False
        self._image.set_data(view.cells)
        self._image.set_visible(view.bands is None)
        changed = self._bands is not view.bands
        self._bands = view.bands
        for artist in self._drawn:
            artist.remove()
        self._drawn = []
        if view.bands is not None:
            factors = tuple(1.0 / self._units[name].size for name in ("frequency", "mean"))
            scaled = view.bands.scaled(view.bands.x, view.bands.y, factors)
            before = list(self._ax.get_children())
            shapes.fill(self._ax, scaled, palette.UNSTABLE)
            name_bands(self._ax, scaled.bands, halo=False)
            self._drawn = [artist for artist in self._ax.get_children() if artist not in before]
        return changed


class Modes:
    """Modes by natural frequency among the resonance tongues of the load."""

    def __init__(self, ax: Any) -> None:
        """Prepare the axes."""
        from matplotlib.ticker import FuncFormatter, MultipleLocator

        self._ax = ax
        self._frame: tuple[float, float, float, float] | None = None
        style: dict[str, Any] = {"origin": "lower", "aspect": "auto", "cmap": palette.verdicts(), "vmin": 0, "vmax": 1}
        self._image = ax.imshow([[False]], interpolation="nearest", **style)
        (self._all,) = ax.plot([], [], **palette.POINT, linewidth=0.6, markersize=4)
        (self._growing,) = ax.plot([], [], "o", color="black", markersize=5)
        style = {"fontsize": "x-small", "ha": "left", "va": "top", "visible": False, "clip_on": True}
        self._names = [ax.text(0.0, 0.0, "", **style) for _ in range(_MOST_LABELS)]
        ax.set_xlabel(r"natural over load frequency $\omega_m/\omega$")
        ax.set_ylabel(r"stiffness amplitude $\alpha_m$", fontsize="small", labelpad=2.0)
        ax.set_title("modes among resonance tongues", fontsize="medium")
        ax.yaxis.set_major_locator(MultipleLocator(1.0))
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"$10^{{{value:.0f}}}$"))
        self.moving = [self._all, self._growing, *self._names]

    def show(self, view: ModesView) -> bool:
        """Show modes, and tongues where they are given."""
        x, y = straightened(view.ratio), np.log10(np.maximum(view.alpha, view.frame[2]))
        self._all.set_data(x, y)
        growing = view.growth > 0.0
        self._growing.set_data(x[growing], y[growing])
        if view.tongues is not None:
            self._image.set_data(view.tongues)
            left, right = (float(straightened(end)) for end in view.frame[:2])
            self._image.set_extent((left, right, *np.log10(view.frame[2:])))
            self._frame = view.frame
            self.arrange()
        self._name(view.numbers, x, y, growing)
        return view.tongues is not None

    def arrange(self) -> None:
        """Write as many ticks as there is room for."""
        if self._frame is None:
            return
        (left, right), points = self._ax.get_xlim(), 72.0 * self._ax.get_window_extent().width / self._ax.figure.dpi
        taken: dict[str, float] = {}
        for tick in _TICKS:
            if self._frame[0] <= tick <= self._frame[1]:
                name, at = f"{tick:g}", float(straightened(tick))
                gaps = ((abs(at - other), len(name) + len(beside) + 1) for beside, other in taken.items())
                if all(gap / (right - left) * points > _HALF_DIGIT * halves for gap, halves in gaps):
                    taken[name] = at
        self._ax.set_xticks(list(taken.values()), list(taken))

    def _name(self, numbers: NDArray[np.int64], x: Floats, y: Floats, growing: NDArray[np.bool_]) -> None:
        """Write numbers beside modes where there is room, those that grow first."""
        places = self._ax.transData.transform(np.column_stack([x, y]))
        order = [*np.flatnonzero(growing).tolist(), *np.flatnonzero(~growing).tolist()]
        least = 1.6 * self._ax.figure.dpi / 72.0 * self._names[0].get_fontsize()
        taken: list[int] = []
        for i in order:
            if len(taken) < _MOST_LABELS and all(np.abs(places[i] - places[j]).max() > least for j in taken):
                taken.append(i)
        for text, at in zip(self._names, taken, strict=False):
            text.set(text=f" {numbers[at]}", position=(x[at], y[at]), weight="bold" if growing[at] else "normal")
        for place, text in enumerate(self._names):
            text.set_visible(place < len(taken))


class GrowthBars:
    """How fast each mode grows."""

    def __init__(self, ax: Any) -> None:
        """Prepare the axes."""
        from matplotlib.collections import LineCollection
        from matplotlib.ticker import MaxNLocator

        self._ax, self._top = ax, 0.0
        self._bars = ax.add_collection(LineCollection([], colors=palette.UNSTABLE, capstyle="butt"), autolim=False)
        ax.set_xlabel("mode $m$")
        ax.set_ylabel("growth rate / (1/s)")
        ax.set_title("growth of each mode", fontsize="medium")
        ax.xaxis.set_major_locator(MaxNLocator("auto", integer=True))
        self.moving = [self._bars]

    def show(self, view: RatesView) -> bool:
        """Show the rates."""
        count = view.numbers.size
        self._bars.set_segments([[(m, 0.0), (m, rate)] for m, rate in zip(view.numbers, view.growth, strict=True)])
        self._bars.set_linewidth(max(1.5, 140.0 / count))
        self._ax.set_xlim(0.4, count + 0.6)
        top = fitting(float(view.growth.max()), self._top)
        changed, self._top = top != self._top, top
        self._ax.set_ylim(0.0, top)
        return changed


class GrowthLine:
    """Growth of the fastest solution over the frequency, the forces staying as they are."""

    def __init__(self, ax: Any, limits: tuple[float, float], unit: Unit) -> None:
        """Prepare the axes."""
        self._ax, self._unit, self._top = ax, unit, 0.0
        (self._curve,) = ax.plot([], [], ".-", color=palette.UNSTABLE, markersize=4, linewidth=1.2)
        (self._here,) = ax.plot([], [], color="black", linewidth=0.8, linestyle="--")
        ax.set_xlim(*(unit.of(end) for end in limits))
        ax.set_xlabel(label(*NAMES["frequency"], unit.name))
        ax.set_ylabel("growth rate / (1/s)")
        ax.set_title("growth over the frequency", fontsize="medium")
        self.moving = [self._curve, self._here]

    def move(self, load: Mapping[str, float]) -> None:
        """Move the line at the load's frequency."""
        here = self._unit.of(load["frequency"])
        self._here.set_data([here, here], [0.0, 1e12])

    def show(self, view: LineView) -> bool:
        """Show the known growth."""
        known = np.isfinite(view.growth)
        self._curve.set_data(self._unit.of(view.frequency[known]), view.growth[known])
        top = fitting(float(view.growth[known].max(initial=0.0)), self._top)
        changed, self._top = top != self._top, top
        self._ax.set_ylim(-0.02 * top, top)
        return changed


class ShapeOf:
    """The fastest solution along the rod."""

    def __init__(self, ax: Any, length: float) -> None:
        """Prepare the axes."""
        self._ax = ax
        (self._area,) = ax.fill([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], color=palette.NEUTRAL, alpha=0.35, linewidth=0.0)
        (self._line,) = ax.plot([], [], color="black", linewidth=1.0)
        ax.set_xlim(0.0, length)
        ax.set_ylim(-1.1, 1.45)
        ax.set_xlabel("position from the upper end $s$ / m")
        ax.set_ylabel("deflection / largest")
        ax.set_title("shape of the fastest solution", fontsize="medium")
        self._text = ax.text(0.5, 0.98, "", transform=ax.transAxes, ha="center", va="top", fontsize="small")
        self.moving = [self._area, self._line, self._text]

    def show(self, view: ShapeView | None) -> bool:
        """Show a shape, or none."""
        if view is None:
            self._line.set_data([], [])
            self._area.set_xy([[0.0, 0.0]])
            self._text.set_text("")
            return False
        self._line.set_data(view.s, view.deflection)
        around = np.concatenate([view.envelope, -view.envelope[::-1]])
        self._area.set_xy(np.column_stack([np.concatenate([view.s, view.s[::-1]]), around]))
        self._text.set_text(f"{view.name}\ngrowth {view.growth:.3g} 1/s; grey: over a period")
        return False


def straightened(ratio: Any, *, back: bool = False) -> Any:
    """Return places on the axis of natural frequencies: linear up to 2 either way, logarithmic beyond; or back."""
    size = np.abs(ratio)
    if back:
        beyond = _STRAIGHT * np.exp(np.maximum(size - _STRAIGHT, 0.0) / _STRAIGHT)
    else:
        beyond = _STRAIGHT + _STRAIGHT * np.log(np.maximum(size, _STRAIGHT) / _STRAIGHT)
    return np.sign(ratio) * np.where(size <= _STRAIGHT, size, beyond)


def fitting(highest: float, top: float) -> float:
    """Return the end of an axis for values up to ``highest``: unchanged for 0 and up to ten times too large."""
    if highest == 0.0:
        return top or 1.0
    wanted = _step_above(highest)
    return top if wanted <= top <= 10.0 * wanted else wanted


def _step_above(value: float) -> float:
    """Return the least of 1, 2, 5, 10, 20, ... times 1e-3 that is above ``value``."""
    step = 1e-3
    while step <= value:
        step *= 2.5 if f"{step:e}"[0] == "2" else 2.0
    return step
