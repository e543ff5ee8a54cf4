"""Drawings of simulated rods."""

from __future__ import annotations

import itertools
import shutil
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from floquetrod._util.sealed_files import atomic_file
from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import axes_or_new, explain, figure_or_new, new_axes, typeset
from floquetrod.units import AnswerUnits, Unit

ANIMATIONS = (".gif", ".mp4")
"""Kinds of file an animation is written to."""

_LINES = {
    "work": ("black", "-"),
    "dissipated": ("black", "--"),
    "kinetic": ("0.35", "-"),
    "bend": ("0.35", "--"),
    "gravity": ("0.35", ":"),
    "stretch": ("0.6", "-"),
    "twist": ("0.6", ":"),
    "contact": ("0.6", "-."),
}


def draw_top_view(run: Any, ax: Any = None, pictures: int = 5) -> Any:
    """Draw a `floquetrod.Simulation` from above: some times of its last quarter, the last one black."""
    ax = axes_or_new(ax)
    last = run.time.size - 1
    chosen = np.unique(np.linspace(last - last // 4, last, pictures).astype(int))
    for place, frame in enumerate(chosen):
        shade = str(0.8 * (1.0 - (place + 1) / len(chosen)))
        x, y = run.positions[frame, :, 0], 1e3 * run.positions[frame, :, 1]
        ax.plot(x, y, color=shade, linewidth=1.4 if frame == last else 0.8, label=f"{run.time[frame]:.3g} s")
    _frame_axes(ax, run)
    explain(ax, ax.get_lines()[-len(chosen) :], columns=6)
    return ax


def draw_energy(run: Any, ax: Any = None) -> Any:
    """Draw the sizes of the energies of a `floquetrod.Simulation` over time, seven decades of them."""
    ax = axes_or_new(ax)
    for name, (colour, line) in _LINES.items():
        ax.plot(run.time, np.abs(run.energy[name]), color=colour, linestyle=line, linewidth=1.0, label=name)
    largest = max(1e-12, *(float(np.abs(run.energy[name]).max()) for name in _LINES))
    ax.set_yscale("log")
    ax.set_ylim(1e-7 * largest, 10.0 * largest)
    ax.set_xlabel("time $t$ / s")
    ax.set_ylabel("size of the energy / J")
    explain(ax, ax.get_lines()[-len(_LINES) :])
    return ax


def draw_growth(run: Any, modes: Sequence[int], rates: Sequence[float], ax: Any = None, note: str = "") -> Any:
    """Draw the size of some modes of a run over time on a logarithmic scale, dashed the growth each is predicted.

    A prediction passes through the mode's largest amplitude of the first half of the time below 0.05 rad, beyond which
    motion is not linear; ``rates`` in 1/s, zeros are not drawn.  A note is written over the legend.
    """
    ax = axes_or_new(ax)
    sizes = np.degrees(np.abs(run.mode_amplitudes(modes)))
    top = max(1e-9, float(sizes.max()))
    beyond = np.flatnonzero(run.largest_angle > 0.05)
    linear = int(beyond[0]) if beyond.size else run.time.size
    lines: list[Any] = []
    for place, (mode, rate, size) in enumerate(zip(modes, rates, sizes.T, strict=True)):
        shade = str(0.65 * place / max(1, len(modes) - 1))
        width, above = 1.2 - 0.2 * place, 3 - 0.1 * place
        lines += ax.plot(run.time, size, color=shade, linewidth=width, label=f"mode {mode}", zorder=above)
        if rate > 0.0:
            at = int(size[: max(1, linear // 2)].argmax())
            line = size[at] * np.exp(rate * (run.time[:linear] - run.time[at]))
            label = f"mode {mode}, predicted {rate:.3g} 1/s"
            style = {"color": shade, "linestyle": "--", "linewidth": 1.2, "zorder": 4}
            lines += ax.plot(run.time[:linear], line, label=label, **style)
    ax.set_yscale("log")
    ax.set_ylim(1e-6 * top, 3.0 * top)
    ax.set_xlabel("time $t$ / s")
    ax.set_ylabel(r"amplitude $|A_m|$ / degree")
    explain(ax, lines, note)
    return ax


def draw_run(run: Any, modes: Sequence[int], rates: Sequence[float], figure: Any = None) -> Any:
    """Return a figure of the rod from above and of the growth of its modes: the load its title, the start a note."""
    figure = figure_or_new(figure, (7.0, 7.0))
    above, below = figure.subplots(2, 1)
    draw_top_view(run, above)
    draw_growth(run, modes, rates, below, "; ".join(filter(None, [f"start: {run.problem.start_words}", run.note])))
    figure.suptitle(typeset(run.caption), fontsize="medium")
    return figure


def animate_top_view(run: Any, pictures: int = 200) -> Any:
    """Return a matplotlib animation of the rod from above, of at most so many pictures."""
    from matplotlib.animation import FuncAnimation

    chosen = np.unique(np.linspace(0, run.time.size - 1, pictures).astype(int))
    ax = new_axes()
    (line,) = ax.plot([], [], color="black", linewidth=1.2)
    clock = ax.text(0.99, 0.95, "", transform=ax.transAxes, ha="right", va="top", fontsize="small")
    _frame_axes(ax, run)
    ax.figure.draw_without_rendering()
    ax.figure.set_layout_engine("none")  # laid out once, for all pictures

    def show(frame: int) -> tuple[Any, Any]:
        line.set_data(run.positions[frame, :, 0], 1e3 * run.positions[frame, :, 1])
        clock.set_text(f"{run.time[frame]:.3f} s")
        return line, clock

    return FuncAnimation(ax.figure, show, frames=chosen.tolist(), interval=40, blit=True)


def require_writer(path: Path) -> None:
    """Raise ValueError when no animation can be written to a file of this kind here."""
    from matplotlib import animation

    if path.suffix == ".mp4" and not animation.writers.is_available("ffmpeg"):
        raise ValueError(f"{path.name} needs the program ffmpeg, which is not installed; a .gif needs none")


def save_animation(animation: Any, path: Path, progress: Callable[[int, int], None] | None = None) -> Path:
    """Write an animation to a .gif or .mp4 file, which is whole or not there, and close its figure."""
    from matplotlib import pyplot

    require_writer(path)
    # A writer opens its file by name, and derives the kind from the name: hence a folder, not a temporary name.
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / f"drawn{path.suffix}"
        writer = "pillow" if path.suffix == ".gif" else "ffmpeg"
        animation.save(drawn, writer=writer, dpi=100, progress_callback=progress)
        with atomic_file(path) as file, drawn.open("rb") as source:
            shutil.copyfileobj(source, file)
    pyplot.close(animation._fig)
    return path


def _frame_axes(ax: Any, run: Any) -> None:
    """Set the limits of a top view: the rod's length, and its motion or a tenth of the channel."""
    gap = 1e3 * float(np.max(run.problem.mesh.clearance))
    side = max(0.1 * gap, 1.05e3 * float(np.abs(run.positions[:, :, 1]).max()))
    ax.set_xlim(-0.505 * run.rod.length, 0.505 * run.rod.length)
    ax.set_ylim(-side, side)
    ax.set_xlabel("along the channel $x$ / m")
    ax.set_ylabel("across the channel $y$ / mm")


def draw_shape(verdict: Any, shape: Any, name: str, ax: Any = None) -> Any:
    """Draw the shape in which a rod grows, at one instant and its envelope, and what grows; return the axes.

    Positions are in the unit in which the rod was given.  Of a string the sections are numbered from the upper end,
    with lines where sections or bores change.
    """
    ax, unit = axes_or_new(ax), AnswerUnits.named(given=verdict.rod.given_units).length
    s = unit.of(shape.s)
    ax.fill_between(s, -shape.envelope, shape.envelope, color=palette.NEUTRAL, alpha=0.35, linewidth=0.0)
    ax.collections[-1].set_label("over a period")
    (line,) = ax.plot(s, shape.deflection, color="black", linewidth=1.0, label="one instant")
    ax.set(xlabel=f"position from the upper end $s$ / {unit.name}", ylabel="deflection / largest", ylim=(-1.1, 1.1))
    ax.set_xlim(s[0], s[-1])
    rate = verdict.growth_rate
    growth = f"{verdict.status}, growth {rate:.4g} 1/s" if rate else f"{verdict.status}: the motion that lasts longest"
    ax.set_title(f"{growth}: {name}" if name else growth, fontsize="medium", wrap=True)
    explain(ax, [line, ax.collections[-1], *_draw_sections(verdict.rod, ax, unit)])
    return ax


def _draw_sections(rod: Any, ax: Any, unit: Unit) -> list[Any]:
    """Draw where sections and bores of a string change, and number its sections; return what the legend explains."""
    parts: Any = rod.uniform_parts
    drawn: dict[str, Any] = {}
    for upper, lower in itertools.pairwise(parts):
        label, style = ("another bore", ":") if upper.section == lower.section else ("another section, by number", "--")
        drawn[label] = ax.axvline(unit.of(lower.start), color="0.4", linestyle=style, linewidth=1.0, label=label)
    if rod.sections:
        ax.set_ylim(-1.1, 1.35)
        for number in range(len(rod.sections)):
            ends = [end for part in parts if part.section == number for end in (part.start, part.end)]
            ax.text(
                0.5 * unit.of(ends[0] + ends[-1]), 1.22, str(number + 1), ha="center", va="center", fontsize="small"
            )
    return list(drawn.values())
