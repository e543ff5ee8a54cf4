"""The drawings of how far a string can be pushed into a well."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import explain, figure_or_new, patch
from floquetrod.plotting.leaders import add_leaders
from floquetrod.units import AnswerUnits, Unit

_TITLE = 80  # characters in a line of the title
_APART = 0.2  # of the depths, between two labels (a choice)
_BEFORE_THE_END = 0.85  # of the depth, where curves are named (a choice)
_FEW = 20  # depths of a curve, fewer of which are marked (a choice)
_DECADES = 1e-3  # of the largest contact, from which it is drawn where a helix presses hard


def draw_reach(result: Any, shown: AnswerUnits, title: str, figure: Any = None) -> Any:
    """Return a figure of a `Reach`: the force that pushes the string, that in the string, and the stress."""
    figure = figure_or_new(figure, (7.2, 8.4))
    push, force, stress = axes = figure.subplots(3, 1, sharex=True, height_ratios=[1.2, 1.0, 1.0])
    _draw_push(result, shown, push)
    _draw_force(result, shown, force)
    _draw_stress(result, shown, stress)
    _end_at_the_well(result, shown, axes)
    unbroken = re.sub(r"(?<=\d) (?=\S)", "\N{NO-BREAK SPACE}", title)  # numbers stay beside their units
    if title:
        figure.suptitle("\n".join(_even_lines(unbroken)), fontsize="medium")
    return figure


def _even_lines(text: str) -> list[str]:
    """Return a title in as few lines as fit, about as long as each other."""
    number = len(textwrap.wrap(text, _TITLE))
    widths = range(len(text) // max(number, 1), _TITLE + 1)
    return next((lines for width in widths if len(lines := textwrap.wrap(text, max(width, 1))) <= number), [text])


def draw_well(result: Any, shown: AnswerUnits, figure: Any = None) -> Any:
    """Return a figure of the well from its side, the string as deep as it reaches."""
    figure = figure_or_new(figure, (7.2, 3.4))
    ax, unit = figure.subplots(), shown.length
    path, end = result.path, result.along.depth[-1]
    depths = np.unique(np.concatenate([np.linspace(path.start, path.end, 400), path.stations]))
    places = path.position(depths)
    run = unit.of(np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places[:, :2], axis=0).T))]))
    down = unit.of(places[:, 2])
    ax.plot(run, down, color="0.7", linewidth=4.0, solid_capstyle="butt", label="well")
    inside = depths <= end
    ax.plot(run[inside], down[inside], color="black", linewidth=1.4, label="string")
    grows = np.interp(depths, result.along.depth, result.growth) > 0.0
    if (grows & inside).any():
        ax.plot(*_only(run, down, grows & inside), color=palette.UNSTABLE, linewidth=1.8, label="lateral waves grow")
    ax.set_xlabel(f"horizontal distance / {unit.name}")
    ax.set_ylabel(f"true vertical depth / {unit.name}")
    if ax.dataLim.width < 0.1 * ax.dataLim.height:  # vertical, or nearly
        ax.set_aspect("equal", adjustable="datalim")
    ax.margins(x=0.03, y=0.08)
    ax.invert_yaxis()
    explain(ax, ax.get_lines())
    return figure


def draw_lower_end(result: Any, shown: AnswerUnits, figure: Any = None) -> Any:
    """Return a figure of the largest force that arrives at the lower end, over its depth.

    What would arrive near the upper end is far more, and is left out.
    """
    figure = figure_or_new(figure, (7.2, 3.0))
    ax = figure.subplots()
    curves = [(result.bit, result.reach, "without the tool" if result.tool else "", palette.POINT)]
    if result.tool:
        filled = {**palette.POINT, "markerfacecolor": "black", "marker": "s"}
        curves.append((result.bit_shaken, result.reach_shaken, "with the tool", filled))
    deep = np.concatenate([result.bit[1:], result.bit_shaken[1:], [result.far_force + 1e3]])
    low, size = result.far_force, float(np.nanmax(deep)) - result.far_force
    handles = []
    for force, reach, label, style in curves:
        arrives = np.isfinite(force) & (result.bit_depth <= reach) & (force < low + 1.1 * size)
        style = {**style, "linestyle": "none", "markersize": 5, "label": label or "largest force"}
        handles += ax.plot(shown.length.of(result.bit_depth[arrives]), shown.force.of(force[arrives]), **style)
        more = arrives & result.is_limited(force)
        if more.any():
            above = {"linestyle": "none", "marker": "^", "color": "black", "label": "so much or more"}
            handles += ax.plot(shown.length.of(result.bit_depth[more]), shown.force.of(force[more]), **above)
    ax.set_ylim(shown.force.of(low - 0.05 * size), shown.force.of(low + 1.15 * size))
    ax.set_ylabel(f"force at the lower end / {shown.force.name}")
    _end_at_the_well(result, shown, [ax])
    ax.set_xlabel(f"measured depth of the lower end / {shown.length.name}")
    explain(ax, handles)
    return figure


def draw_wall(result: Any, shown: AnswerUnits, figure: Any = None) -> Any:
    """Return a figure of the contact with the wall and of the friction along the string."""
    figure = figure_or_new(figure, (7.2, 3.8))
    contact, friction = axes = figure.subplots(2, 1, sharex=True)
    along, depth = result.along, shown.length.of(result.along.depth)
    pressed = shown.per_length.of(along.contact)
    _draw_line(contact, depth, pressed, f"contact / ({shown.per_length.name})")
    if along.is_helix.any():
        contact.set_yscale("log")
        shown_contact = pressed[np.isfinite(pressed) & (pressed > 0.0)]
        most = shown_contact.max()
        contact.set_ylim(max(_DECADES * most, 0.5 * shown_contact.min()), 2.0 * most)
    else:
        contact.set_ylim(bottom=0.0)
    _draw_line(friction, depth, along.friction, "coefficient\nof friction")
    friction.set_ylim(0.0, 1.15 * along.friction.max())
    _end_at_the_well(result, shown, axes)
    return figure


def draw_growth(result: Any, shown: AnswerUnits, figure: Any = None) -> Any:
    """Return a figure of how fast lateral waves grow along the string with its tool, and with other frequencies."""
    has_others = np.isfinite(result.frequency_growth).any()
    figure = figure_or_new(figure, (7.2, 5.2 if has_others else 2.8))
    along, *others = np.atleast_1d(figure.subplots(1 + has_others, 1))
    depth = shown.length.of(result.along.depth)
    _draw_line(along, depth, result.growth, "growth / (1/s)")
    along.plot(depth, result.growth_free, color="0.45", linestyle="--", linewidth=0.9)
    largest = [int(np.argmax(values)) for values in (result.growth, result.growth_free)]
    names = ["with friction", "without friction across"]
    points = [(float(depth[k]), float(v[k])) for k, v in zip(largest, (result.growth, result.growth_free), strict=True)]
    _end_at_the_well(result, shown, [along])
    along.set_ylim(0.0, 1.25 * max(along.dataLim.ymax, 1e-9))
    add_leaders(along, names, points)
    for ax in others:
        reached = np.isfinite(result.frequency_growth)
        frequency = shown.frequency.of(result.frequencies)
        ax.plot(frequency[reached], result.frequency_growth[reached], **palette.POINT, linestyle="none", markersize=5)
        ax.set_ylim(0.0, 1.25 * max(ax.dataLim.ymax, 1e-9))
        ax.axvline(shown.frequency.of(result.tool.frequency), color="0.6", linestyle=":", linewidth=1.0)
        add_leaders(ax, ["the tool's own"], [(shown.frequency.of(result.tool.frequency), 1.1 * ax.dataLim.ymax)])
        ax.set_xlabel(f"frequency of the tool / {shown.frequency.name}")
        ax.set_ylabel("fastest growth / (1/s)")
    return figure


def _only(x: Any, y: Any, kept: Any) -> tuple[Any, Any]:
    return np.where(kept, x, np.nan), np.where(kept, y, np.nan)


class _Push(NamedTuple):
    """The force that pushes the lower end to a depth, how deep it goes and why no deeper, and the force at the end.

    ``end`` is the depth of the last force, which is a little above the reach where the string locks up there.
    """

    force: Floats
    reach: float
    limit: str
    line: str
    name: str
    end: float
    at_end: float


def _pushes(result: Any) -> Iterator[_Push]:
    """Yield the string without the tool and with it; where they end, and what pushes them there."""
    ends = float(result.along.depth[-1]), result.along.injector
    if not result.tool:
        yield _Push(result.injector, result.reach, result.limit, "-", "", *ends)
        return
    yield _Push(result.injector, result.reach, result.limit, "-", "without the tool", *result._injector_at_reach)
    yield _Push(result.injector_shaken, result.reach_shaken, result.limit_shaken, "--", "with the tool", *ends)


def _draw_push(result: Any, shown: AnswerUnits, ax: Any) -> None:
    """Draw the force at the injector over the depth of the lower end, down to the depth reached."""
    unit, depth = shown.force, shown.length.of(result.depth)
    names, points = [], []
    for push in _pushes(result):
        goes = (result.depth < push.end) & np.isfinite(push.force)
        x = shown.length.of(np.append(result.depth[goes], push.end))
        y = unit.of(np.append(push.force[goes], push.at_end))
        computed = "." if x.size < _FEW else ""
        ax.plot(x, y, color="black", linestyle=push.line, linewidth=1.2, marker=computed)
        ax.plot(x[-1:], y[-1:], **palette.POINT, markersize=6, linestyle="none")
        names.append(f"{_depth(push.reach, shown.length)}: {_limit(result, push.limit, shown)}")
        points.append((float(x[-1]), float(y[-1])))
    for push in _pushes(result):
        if push.name and (k := _apart(result)) is not None:
            names.append(push.name)
            points.append((float(depth[k]), float(unit.of(push.force[k]))))
    low, high = ax.get_ylim()
    if np.isfinite(result.push) and unit.of(result.push) < high + 1.5 * (high - low):
        ax.axhline(unit.of(result.push), color="0.45", linestyle="-.", linewidth=0.9)
        names.append(f"greatest push {shown.force.show(result.push, 4)}")
        points.append((float(depth[0]), float(unit.of(result.push))))
    ax.axhline(0.0, color="0.7", linewidth=0.6)
    ax.margins(y=0.12)
    add_leaders(ax, names, points)
    ax.set_ylabel(f"force at the surface / {unit.name}")
    _head(ax, "force that pushes the lower end to a depth, negative where the string pulls")


def _apart(result: Any) -> int | None:
    """Return at which depth the forces without the tool and with it differ most, not too near to where they end.

    None where they are not known to differ.
    """
    goes = result.depth <= _BEFORE_THE_END * min(result.reach, result.reach_shaken)
    differ = np.zeros(goes.shape)
    differ[goes] = np.abs(result.injector[goes] - result.injector_shaken[goes])
    differ[~np.isfinite(differ)] = 0.0
    return int(np.argmax(differ)) if differ.any() else None


def _limit(result: Any, limit: str, shown: AnswerUnits) -> str:
    """Return why the string goes no deeper, in words."""
    if limit == "yield":
        return f"{100.0 * result.yield_share:.3g} % of the yield strength"
    return f"the push of {shown.force.show(result.push, 4)}" if limit == "push" else limit


def _depth(depth: float, unit: Unit) -> str:
    """Return a depth in words, with commas between thousands."""
    value = unit.of(depth)
    return f"{value:,.0f} {unit.name}" if value >= 1e3 else unit.show(depth, 4)


def _draw_force(result: Any, shown: AnswerUnits, ax: Any) -> None:
    """Draw the force in the string, shaded where it is buckled or lateral waves grow."""
    along, depth = result.along, shown.length.of(result.along.depth)
    _draw_line(ax, depth, shown.force.of(along.force), f"force in the string / {shown.force.name}")
    ax.axhline(0.0, color="0.7", linewidth=0.6)
    handles = []
    for name, is_so, colour in (
        ("snaking", along.is_snaking & ~along.is_helix, palette.UNKNOWN),
        ("helix", along.is_helix, palette.NEUTRAL),
        ("lateral waves grow", result.growth > 0.0, palette.UNSTABLE),
    ):
        if is_so.any():
            _shade(ax, depth, is_so, colour)
            handles.append(patch(name, {"facecolor": colour}))
    if handles:
        ax.legend(handles=handles, loc="best", fontsize="x-small", framealpha=0.9, edgecolor="none")
    _head(ax, f"compression in the string, pushed as far as it goes{' with the tool' if result.tool else ''}")


def _draw_line(ax: Any, depth: Any, values: Any, label: str) -> None:
    ax.plot(depth, np.where(np.isfinite(values), values, np.nan), color="black", linewidth=1.2)
    ax.set_ylabel(label)


def _draw_stress(result: Any, shown: AnswerUnits, ax: Any) -> None:
    """Draw the largest stress in the section, what of it is bending, and the yield strength."""
    unit, depth, bending = shown.pressure, shown.length.of(result.along.depth), _finite(result.bending_stress)
    whole = _finite(result.largest_stress)
    name_of_whole = "axial and bending" if result.wellhead.pressure_inside is None else "von Mises"
    _draw_line(ax, depth, unit.of(whole), f"stress / {unit.name}")
    ax.plot(depth, unit.of(bending), color="black", linestyle="--", linewidth=0.8)
    names, points = [], []
    k = int(np.nanargmax(whole))
    apart = np.abs(depth - depth[k]) > _APART * np.ptp(depth)  # so that neither label is in the way of the other
    m = int(np.nanargmax(np.where(apart, bending, np.nan)))
    for i, name, values in ((k, name_of_whole, whole), (m, "bending", bending)):
        names.append(name)
        points.append((float(depth[i]), float(unit.of(values[i]))))
    left, strength = float(shown.length.of(result.path.start)), result.yield_strength
    if strength is not None:
        lines = [(strength, "-.", f"yield strength {unit.show(strength, 3)}")]
        share = result.yield_share
        if share is not None and share < 1.0:
            lines.append((share * strength, ":", f"{100.0 * share:.3g} % of it, the limit"))
        for value, line, name in lines:
            ax.axhline(unit.of(value), color="black", linestyle=line, linewidth=1.0)
            names.append(name)
            points.append((left, float(unit.of(value))))
    ax.set_ylim(0.0, 1.2 * max(ax.dataLim.ymax, 1e-9))
    add_leaders(ax, names, points)
    _head(ax, "largest stress along the string")


def _finite(values: Floats) -> Floats:
    """Return values, NaN where they are infinite: there a string is locked up."""
    return np.where(np.isfinite(values), values, np.nan)


def _head(ax: Any, text: str) -> None:
    """Write over a panel what it shows."""
    ax.set_title(text, loc="left", fontsize="small")


def _shade(ax: Any, depth: Any, is_so: Any, colour: str) -> None:
    """Shade depths from below to above."""
    from matplotlib.transforms import blended_transform_factory

    over = blended_transform_factory(ax.transData, ax.transAxes)
    ax.fill_between(depth, 0.0, 1.0, where=is_so, transform=over, linewidth=0.0, zorder=0.0, facecolor=colour)


def _end_at_the_well(result: Any, shown: AnswerUnits, axes: Any) -> None:
    """Let axes of depth begin and end where the well does, with a little room, and name the lowest."""
    start, end = shown.length.of(result.path.start), shown.length.of(result.path.end)
    for ax in axes:
        ax.set_xlim(start - 0.01 * (end - start), end + 0.01 * (end - start))
    axes[-1].set_xlabel(f"measured depth / {shown.length.name}")
