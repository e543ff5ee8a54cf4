"""The drawing of how far a string can be pushed into a well."""

from __future__ import annotations

import re
import textwrap
from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import figure_or_new, patch
from floquetrod.units import AnswerUnits, Unit

_TITLE = 95  # characters in a line of the title


def draw_reach(result: Any, shown: AnswerUnits, title: str, figure: Any = None) -> Any:
    """Return a figure of a `Reach`: the well's section, the force at the injector, and along the string."""
    more = [1.0] if result.tool else []
    figure = figure_or_new(figure, (7.2, 12.3 + 1.4 * len(more)))
    axes = figure.subplots(7 + len(more), 1, height_ratios=[1.5, 1.2, 1.0, 1.2, 1.0, 1.0, 1.0, *more])
    section, injector, bit, force, contact, friction, stress = axes[:7]
    _draw_section(result, shown.length, section)
    _draw_injector(result, shown, injector)
    _draw_bit(result, shown, bit)
    along, depth, pressed = result.along, shown.length.of(result.along.depth), shown.per_length.of(result.along.contact)
    _draw_line(force, depth, shown.force.of(along.force), f"force in the string / {shown.force.name}")
    _draw_line(contact, depth, pressed, f"contact / ({shown.per_length.name})")
    _draw_line(friction, depth, along.friction, "friction")
    friction.set_ylim(bottom=0.0)
    _draw_stress(result, shown, stress)
    if along.is_helix.any():
        contact.set_yscale("log")
        contact.set_ylim(bottom=1e-3 * pressed[np.isfinite(pressed)].max())
    if result.tool:
        _draw_growth(result, depth, axes[7])
    for ax in axes[3:]:
        _shade(result, depth, ax)
    for ax in axes[1:]:
        ax.set_xlim(shown.length.of(result.path.start), shown.length.of(result.path.end))
    force.legend(handles=_areas(result), loc="best", fontsize="x-small", frameon=False)
    axes[-1].set_xlabel(f"measured depth / {shown.length.name}")
    unbroken = re.sub(r"(?<=\d) (?=\S)", "\N{NO-BREAK SPACE}", title)  # numbers stay beside their units
    figure.suptitle(textwrap.fill(unbroken, _TITLE), fontsize="medium")
    return figure


def _draw_section(result: Any, unit: Unit, ax: Any) -> None:
    """Draw the well from its side, the string as deep as it reaches."""
    path, end = result.path, result.along.depth[-1]
    depths = np.unique(np.concatenate([np.linspace(path.start, path.end, 400), path.stations]))
    places = path.position(depths)
    run = unit.of(np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places[:, :2], axis=0).T))]))
    down = unit.of(places[:, 2])
    ax.plot(run, down, color="0.7", linewidth=4.0, solid_capstyle="butt", label="well")
    inside = depths <= end
    ax.plot(run[inside], down[inside], color="black", linewidth=1.4, label="string")
    grows = np.interp(depths, result.along.depth, result.growth) > 0.0
    ax.plot(*_only(run, down, grows & inside), color=palette.UNSTABLE, linewidth=1.8, label="grows")
    ax.set_xlabel(f"horizontal distance / {unit.name}")
    ax.set_ylabel(f"true vertical depth / {unit.name}")
    if ax.dataLim.width < 0.1 * ax.dataLim.height:  # vertical, or nearly
        ax.set_aspect("equal", adjustable="datalim")
    ax.invert_yaxis()
    ax.legend(loc="best", fontsize="x-small", frameon=False)


def _only(x: Any, y: Any, kept: Any) -> tuple[Any, Any]:
    return np.where(kept, x, np.nan), np.where(kept, y, np.nan)


def _draw_injector(result: Any, shown: AnswerUnits, ax: Any) -> None:
    """Draw the force at the injector over the depth of the lower end, that deeper than it is pushed in grey."""
    depth, unit = shown.length.of(result.depth), shown.force
    cases = [(result.injector, result.reach, result.lock_up, "-", "without the tool")]
    if result.tool:
        cases.append((result.injector_shaken, result.reach_shaken, result.lock_up_shaken, "--", "with the tool"))
    highest = [0.0]
    for force, reach, lock_up, line, label in cases:
        goes = result.depth <= reach
        first = max(np.count_nonzero(goes) - 1, 0)
        deeper = {"label": "deeper than it is pushed"} if np.isfinite(force[~goes]).any() else {}
        ax.plot(depth[first:], unit.of(force[first:]), color="0.7", linestyle=line, **deeper)
        ax.plot(depth[goes], unit.of(force[goes]), color="black", linestyle=line, label=label)
        end = {"color": "0.5", "linestyle": line, "linewidth": 0.8, "label": "reach" if line == "-" else None}
        ax.axvline(shown.length.of(reach), **end)
        if lock_up > reach and np.isfinite(lock_up):
            ax.axvline(shown.length.of(lock_up), color="0.5", linestyle=":", linewidth=0.8, label="lock-up by statics")
        highest += list(unit.of(force[goes]))
    bottom, top = ax.get_ylim()
    most = max(highest) + 0.2 * max(max(highest) - bottom, 1e-9)
    ax.set_ylim(bottom, min(top, most))
    handles, names = ax.get_legend_handles_labels()
    if len(names) > 1:
        kept = dict(zip(names, handles, strict=True))
        ax.legend(kept.values(), kept.keys(), loc="best", fontsize="x-small", frameon=False)
    ax.axhline(0.0, color="0.7", linewidth=0.6)
    ax.set_ylabel(f"at the injector / {unit.name}")


def _draw_bit(result: Any, shown: AnswerUnits, ax: Any) -> None:
    """Draw what arrives at the lower end over its depth; what would arrive near the injector is far more."""
    curves = [(_to_the_reach(result, result.bit, result.reach, result.is_stopped), "-")]
    if result.tool:
        shaken = _to_the_reach(result, result.bit_shaken, result.reach_shaken, result.is_stopped_shaken)
        curves.append((shaken, "--"))
    deep = np.concatenate([result.bit[1:], result.bit_shaken[1:], [result.far_force + 1e3]])
    low, size = result.far_force, float(np.nanmax(deep)) - result.far_force
    for (depth, force), line in curves:
        ax.plot(shown.length.of(depth), shown.force.of(force), color="black", linestyle=line, marker=".")
        more = result.is_limited(force) & (force < low + 1.1 * size)
        if more.any():
            ax.plot(shown.length.of(depth[more]), shown.force.of(force[more]), "k^", label="so much or more")
            ax.legend(loc="best", fontsize="x-small", frameon=False)
    ax.set_ylim(shown.force.of(low), shown.force.of(low + 1.1 * size))
    ax.set_ylabel(f"at the lower end / {shown.force.name}")
    ax.set_xlabel(f"measured depth of the lower end / {shown.length.name}")


def _to_the_reach(result: Any, forces: Any, reach: float, is_stopped: bool) -> tuple[Any, Any]:
    """Return depths and forces at the lower end, where the string stops that which it was sought with."""
    arrives = np.isfinite(forces) & (result.bit_depth <= reach)
    depth, force = result.bit_depth[arrives], forces[arrives]
    return (np.append(depth, reach), np.append(force, result.far_force)) if is_stopped else (depth, force)


def _draw_line(ax: Any, depth: Any, values: Any, label: str) -> None:
    ax.plot(depth, np.where(np.isfinite(values), values, np.nan), color="black", linewidth=1.2)
    ax.set_ylabel(label)


def _draw_stress(result: Any, shown: AnswerUnits, ax: Any) -> None:
    """Draw the largest stress in the section, what of it is bending, and the yield strength."""
    unit, depth, bending = shown.pressure, shown.length.of(result.along.depth), result.bending_stress
    _draw_line(ax, depth, unit.of(result.largest_stress), f"largest stress / {unit.name}")
    ax.plot(depth, unit.of(bending), color="black", linestyle="--", linewidth=0.8, label="bending")
    if result.yield_strength is not None:
        strength = unit.of(result.yield_strength)
        ax.axhline(strength, color="black", linestyle="-.", linewidth=1.2, label="yield strength")
        if result.yield_share is not None and result.yield_share < 1.0:
            label = f"{100.0 * result.yield_share:.3g} % of it"
            ax.axhline(result.yield_share * strength, color="black", linestyle=":", linewidth=1.0, label=label)
    _legend_above(ax)


def _draw_growth(result: Any, depth: Any, ax: Any) -> None:
    """Draw how fast waves across the string grow, after friction and without."""
    _draw_line(ax, depth, result.growth, "growth / (1/s)")
    free = {"color": "black", "linestyle": "--", "linewidth": 0.8, "label": "without friction across"}
    ax.plot(depth, result.growth_free, **free)
    _legend_above(ax)


def _legend_above(ax: Any) -> None:
    """Put the legend above curves that begin at 0, in a row."""
    ax.set_ylim(0.0, 1.4 * max(ax.dataLim.ymax, 1e-9))
    ax.legend(loc="upper left", ncols=4, fontsize="x-small", frameon=False)


def _shade(result: Any, depth: Any, ax: Any) -> None:
    """Shade where the string is buckled or unstable."""
    from matplotlib.transforms import blended_transform_factory

    over = blended_transform_factory(ax.transData, ax.transAxes)
    along = result.along
    for is_so, style in (
        (along.is_snaking & ~along.is_helix, {"facecolor": palette.UNKNOWN}),
        (along.is_helix, {"facecolor": palette.NEUTRAL}),
        (result.growth > 0.0, {"facecolor": palette.UNSTABLE}),
    ):
        ax.fill_between(depth, 0.0, 1.0, where=is_so, transform=over, linewidth=0.0, zorder=0.0, **style)


def _areas(result: Any) -> list[Any]:
    shades = {"snaking": palette.UNKNOWN, "helix": palette.NEUTRAL}
    shades |= {"waves across it grow": palette.UNSTABLE} if result.tool else {}
    return [patch(name, {"facecolor": shade}) for name, shade in shades.items()]
