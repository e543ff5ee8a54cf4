"""The study's figures, in its layout; the data come computed, and what is drawn of them has a label with its name."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import typeset
from floquetrod.plotting.shapes import fill


class UnstableForces(NamedTuple):
    """An unstable interval of mean force (F_cr) of one mode; ``seen``: growth passes the test's threshold."""

    low: float
    high: float
    mode: int
    seen: bool


def draw_plane(
    ax: Any,
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    unstable: NDArray[np.bool_],
    curves: Any = None,
) -> None:
    """Draw unstable points of the (alpha, beta) plane under the transition curves, if given."""
    _shade(ax, alpha, beta, unstable)
    if curves is not None:
        _draw_curves(ax, curves)
    _frame(ax, (alpha[0], alpha[-1]), (beta[0], beta[-1]), r"$\alpha$", r"$\beta$")


def draw_exact_plane(ax: Any, bands: Any, curves: Any) -> None:
    """Draw the unstable bands of the (alpha, beta) plane under the transition curves."""
    fill(ax, bands, palette.UNSTABLE, label="unstable band")
    _draw_curves(ax, curves)
    _frame(ax, bands.x.values, bands.y.values, r"$\alpha$", r"$\beta$")


def draw_outlines(ax: Any, bands: Any) -> None:
    """Draw the boundaries of bands as lines, but not the edge of the plane."""
    ends = [axis.values[[0, -1]] for axis in (bands.x, bands.y)]
    for band in bands:
        line = np.column_stack([np.append(band.x, band.x[0]), np.append(band.y, band.y[0])])
        beside = [np.isclose(line[:, k, None], ends[k], rtol=0.0, atol=1e-9 * np.ptp(ends[k])) for k in (0, 1)]
        on_edge = np.hstack(beside)
        hidden = (on_edge[1:] & on_edge[:-1]).any(axis=1)
        for part in np.split(np.arange(len(hidden)), np.flatnonzero(np.diff(hidden)) + 1):
            if not hidden[part[0]]:
                chosen = np.append(part, part[-1] + 1)
                ax.plot(*line[chosen].T, color="black", linewidth=0.8, label="boundary")


def draw_modes(ax: Any, alpha: NDArray[np.float64], beta: NDArray[np.float64], unstable: NDArray[np.bool_]) -> None:
    """Mark modes 1, 2, ... at (alpha, beta): filled where unstable, numbered where there is room."""
    ax.plot(alpha, beta, color="black", linewidth=0.5, label="_all modes")
    for i, (x, y) in enumerate(zip(alpha, beta, strict=True)):
        style = palette.POINT | ({"markerfacecolor": "black"} if unstable[i] else {})
        said = "unstable" if unstable[i] else "stable"
        ax.plot(x, y, **style, markersize=5, zorder=3, label=f"mode {i + 1}, {said}")
    box = palette.BOX | {"boxstyle": "round,pad=0.1", "edgecolor": "none"}
    last = None
    for i, place in enumerate(zip(alpha, beta, strict=True)):
        here = ax.transData.transform(place)
        if last is not None and abs(here - last).max() < 12.0:
            continue  # no room for its number
        last = here
        ax.annotate(
            str(i + 1),
            place,
            xytext=(0, 9),
            textcoords="offset points",
            fontsize="x-small",
            bbox=box,
            ha="center",
            va="center",
        )


def draw_map(
    ax: Any,
    omega: NDArray[np.float64],
    force: NDArray[np.float64],
    failing: NDArray[np.bool_] | None,
    bands: Collection[Any],
    colour: str,
) -> None:
    """Draw a map over frequency (rad/s) and mean force (F_cr): bands in a colour, over them what fails a test."""
    fill(ax, bands, colour, label="unstable band")
    if failing is not None:
        _shade(ax, omega, force, failing)
    _frame(ax, (omega[0], omega[-1]), (force[0], force[-1]), r"$\omega$ / (rad/s)", r"$F_\mathrm{ave} / F_\mathrm{cr}$")


def draw_intervals(ax: Any, intervals: list[UnstableForces], upto: float) -> None:
    """Draw the unstable intervals of the mean force, a row for each mode."""
    for low, high, mode, seen in intervals:
        colour = palette.UNSTABLE if seen else palette.UNSEEN
        name = f"unstable interval of mode {mode}" + ("" if seen else ", below the threshold")
        ax.broken_barh([(low, high - low)], (mode - 0.4, 0.8), facecolor=colour, edgecolor="none", label=name)
        edge = [low, low], [mode - 0.4, mode + 0.4]
        ax.plot(*edge, color=colour, linewidth=1.0, label="_edge")  # however thin the bar
    top = max((interval.mode for interval in intervals), default=1) + 0.6
    _frame(ax, (0.0, upto), (0.4, top), r"$F_\mathrm{ave} / F_\mathrm{cr}$", "unstable mode $m$")
    ax.yaxis.get_major_locator().set_params(integer=True)


def draw_kicks(ax: Any, force: NDArray[np.float64], kicks: dict[int, NDArray[np.float64]], applied: float) -> None:
    """Draw the kick (mm/s) that each mode needs over the mean force (F_cr), numbered about where it needs least."""
    from matplotlib.patheffects import withStroke

    ax.set_yscale("log")
    ax.set_xlim(force[0], force[-1])
    ax.set_ylim(10.0, 1000.0)
    inner = (force > 0.04 * force[-1]) & (force < 0.96 * force[-1])
    taken: list[Any] = []
    for mode, values in kicks.items():
        finite = np.where(np.isfinite(values), values, np.nan)
        ax.plot(force, finite, color="black", linewidth=0.9, label=f"mode {mode}")
        seen = np.where(inner & np.isfinite(values) & (values < 900.0), values, np.inf)
        at = int(seen.argmin())
        here = ax.transData.transform((force[at], seen[at]))
        if seen[at] == np.inf or any(abs(here - other).max() < 10.0 for other in taken):
            continue
        taken.append(here)
        where = {"xytext": (0, -6), "textcoords": "offset points", "ha": "center", "va": "center"}
        clear = [withStroke(linewidth=2.0, foreground=palette.STABLE)]  # of lines that cross it
        ax.annotate(str(mode), (force[at], seen[at]), fontsize="x-small", path_effects=clear, zorder=3.0, **where)
    ax.axhline(applied, color="0.4", linestyle="--", linewidth=0.9, label="_applied kick")
    ax.set_xlabel(r"$F_\mathrm{ave} / F_\mathrm{cr}$")
    ax.set_ylabel("critical kick $v_c$ / (mm/s)")


def draw_kick_map(ax: Any, omega: NDArray[np.float64], force: NDArray[np.float64], kick: NDArray[np.float64]) -> None:
    """Draw the critical kick (mm/s) over frequency and mean force: dark where small, hatched where there is none."""
    from matplotlib.colors import LogNorm

    ax.patch.set(**palette.NO_KICK)
    shown = np.ma.masked_where(~np.isfinite(kick), kick)
    shades = palette.shades(darkest_first=True)
    mesh = ax.pcolormesh(
        omega, force, shown, cmap=shades, norm=LogNorm(15.0, 300.0), rasterized=True, label="critical kick"
    )
    ticks = [20.0, 50.0, 100.0, 200.0]
    bar = ax.figure.colorbar(mesh, ax=ax, label="critical kick $v_c$ / (mm/s)", extend="both", ticks=ticks, format="%g")
    bar.minorticks_off()
    levels = [30.0, 40.0, 50.0, 70.0, 100.0, 200.0]
    lines = ax.contour(omega, force, shown, levels=levels, colors="black", linewidths=0.6)
    ax.clabel(lines, fontsize="x-small")
    ax.set_xlabel(r"$\omega$ / (rad/s)")
    ax.set_ylabel(r"$F_\mathrm{ave} / F_\mathrm{cr}$")


def draw_strip(run: Any, ax: Any, title: str) -> None:
    """Draw a run from above as one small panel of many: four times of its last quarter, farthest out in black."""
    last = run.time.size - 1
    quarter = np.arange(last - last // 4, last + 1)
    widest = int(quarter[run.largest_angle[quarter].argmax()])
    for frame in (*np.linspace(quarter[0], last, 4).astype(int), widest):
        x, y = run.positions[frame, :, 0], 1e3 * run.positions[frame, :, 1]
        style = {"color": "black", "linewidth": 1.0} if frame == widest else {"color": "0.7", "linewidth": 0.6}
        ax.plot(x, y, **style, label=f"rod at {run.time[frame]:.6g} s")
    ax.set_title(title, fontsize="x-small", pad=4.0)


def strips(rows: Sequence[str], columns: Sequence[str], size: tuple[float, float], gap: float) -> tuple[Any, Any]:
    """Return a figure of panels that share their axes, and these in rows and columns; ``gap`` is R in m."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(rows), len(columns), sharex=True, sharey=True, squeeze=False)
    for row, name in zip(axes, rows, strict=True):
        row[0].set_ylabel(name, fontsize="x-small")
    for ax in axes.flat:
        ax.set_ylim(-1.05e3 * gap, 1.05e3 * gap)
        ax.tick_params(labelsize="xx-small")
    for ax, name in zip(axes[0], columns, strict=True):
        ax.annotate(name, (0.5, 1.25), xycoords="axes fraction", ha="center", va="bottom", fontsize="small")
    for ax in axes[-1]:
        ax.set_xlabel("$x$ / m", fontsize="x-small")
    return figure, axes


def panels(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, list[Any]]:
    """Return a figure and its axes, lettered (a), (b), ... along the rows."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = list(np.ravel(figure.subplots(rows, columns)))
    for letter, ax in zip("abcdefgh" if len(axes) > 1 else "", axes, strict=False):
        ax.set_title(f"({letter})", loc="left", fontsize="medium")
    return figure, axes


def caption(figure: Any, text: str, width: int) -> None:
    """Write the caption under the figure."""
    figure.supxlabel(typeset(textwrap.fill(text, width)), fontsize="small", x=0.01, ha="left")


def _draw_curves(ax: Any, curves: Any) -> None:
    for name, family in (("even", curves.even), ("odd", curves.odd)):
        for values in family:
            ax.plot(curves.alpha, values, color="black", linewidth=0.7, label=f"{name} transition curve")


def _frame(ax: Any, across: Sequence[float], up: Sequence[float], right: str, above: str) -> None:
    """Set the limits of axes and their labels."""
    ax.set_xlim(*across)
    ax.set_ylim(*up)
    ax.set_xlabel(right)
    ax.set_ylabel(above)


def _shade(ax: Any, x: NDArray[np.float64], y: NDArray[np.float64], where: NDArray[np.bool_]) -> None:
    shown = np.ma.masked_where(~where, np.ones(where.shape))
    ax.pcolormesh(x, y, shown, cmap=palette.verdicts(), vmin=0.0, vmax=1.0, rasterized=True, label="unstable point")
