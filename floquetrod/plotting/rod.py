"""Drawings of simulated rods."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.plotting.charts import new_axes

_LINES = {
    "work": ("black", "-"),
    "dissipated": ("black", "--"),
    "kinetic": ("0.35", "-"),
    "bend": ("0.35", "--"),
    "gravity": ("0.35", ":"),
    "stretch": ("0.6", "-"),
    "shear": ("0.6", "--"),
    "twist": ("0.6", ":"),
    "contact": ("0.6", "-."),
}


def draw_top_view(run: Any, ax: Any = None, pictures: int = 5) -> Any:
    """Draw a `floquetrod.simulation.Simulation` from above: some times of its last quarter, the last one black."""
    ax = new_axes() if ax is None else ax
    last = run.time.size - 1
    chosen = np.unique(np.linspace(last - last // 4, last, pictures).astype(int))
    for place, frame in enumerate(chosen):
        shade = str(0.8 * (1.0 - (place + 1) / len(chosen)))
        x, y = run.positions[frame, :, 0], 1e3 * run.positions[frame, :, 1]
        ax.plot(x, y, color=shade, linewidth=1.4 if frame == last else 0.8, label=f"{run.time[frame]:.3g} s")
    _frame_axes(ax, run)
    ax.legend(fontsize="x-small", loc="upper right", ncols=len(chosen))
    return ax


def draw_energy(run: Any, ax: Any = None) -> Any:
    """Draw the sizes of the energies of a `floquetrod.simulation.Simulation` over time, seven decades of them."""
    ax = new_axes() if ax is None else ax
    for name, (colour, line) in _LINES.items():
        ax.plot(run.time, np.abs(run.energy[name]), color=colour, linestyle=line, linewidth=1.0, label=name)
    largest = max(1e-12, *(float(np.abs(run.energy[name]).max()) for name in _LINES))
    ax.set_yscale("log")
    ax.set_ylim(1e-7 * largest, 10.0 * largest)
    ax.set_xlabel("time $t$ / s")
    ax.set_ylabel("size of the energy / J")
    ax.legend(fontsize="x-small", ncols=3)
    return ax


def animate_top_view(run: Any) -> Any:
    """Return a matplotlib animation of the rod from above."""
    from matplotlib.animation import FuncAnimation

    ax = new_axes()
    (line,) = ax.plot([], [], color="black", linewidth=1.2)
    clock = ax.text(0.99, 0.95, "", transform=ax.transAxes, ha="right", va="top", fontsize="small")
    _frame_axes(ax, run)

    def show(frame: int) -> tuple[Any, Any]:
        line.set_data(run.positions[frame, :, 0], 1e3 * run.positions[frame, :, 1])
        clock.set_text(f"{run.time[frame]:.3f} s")
        return line, clock

    return FuncAnimation(ax.figure, show, frames=run.time.size, interval=40, blit=True)


def _frame_axes(ax: Any, run: Any) -> None:
    """Set the limits of a top view: the rod's length, and its motion or a tenth of the channel."""
    gap = 1e3 * run.rod.gap
    side = max(0.1 * gap, 1.05e3 * float(np.abs(run.positions[:, :, 1]).max()))
    ax.set_xlim(-0.505 * run.rod.length, 0.505 * run.rod.length)
    ax.set_ylim(-side, side)
    ax.set_xlabel("along the channel $x$ / m")
    ax.set_ylabel("across the channel $y$ / mm")
