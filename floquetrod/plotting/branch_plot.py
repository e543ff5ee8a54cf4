"""Pictures of branches of periodic orbits, and of curves of their special points."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import NAMES, axes_or_new
from floquetrod.plotting.orbit_plot import STYLES

Floats = NDArray[np.float64]

_LINES: dict[str, dict[str, Any]] = {
    "stable": {"color": "black", "linewidth": 1.8},
    "unstable": {"color": palette.UNSTABLE, "linewidth": 1.4},
    "undecided": {"color": "0.5", "linewidth": 1.4},
}
_MARKS = 8  # of its kind along a curve of special points
_FINE = 12  # parts between two orbits of a rod
_OFF_WALL: dict[str, Any] = {"color": "black", "marker": "x", "linestyle": "none", "markersize": 7, "zorder": 6}
_MARKERS = {"fold": "^", "branch point": "D", "period doubling": "s", "Neimark-Sacker": "o"}
_BESIDE = {"stable": "", "unstable": ", of unstable orbits", "undecided": ", other multipliers undecided"}
_NAMES = {1: "stable", 0: "unstable", -1: "undecided"}


def draw_branch(branch: Any, ax: Any, state: int, quantity: str) -> Any:
    """Draw a quantity of a `floquetrod.Branch` over its parameter, its parts in lines that tell their verdict."""
    ax = axes_or_new(ax)
    heights = _heights(branch, state, quantity), [_heights(each, state, quantity) for each in branch.special_points]
    draw_over_parameter(ax, branch, *heights)
    ax.set_xlabel(branch.parameter)
    ax.set_ylabel("period" if quantity == "period" else f"{quantity} of x[{state}]")
    return finished(ax)


def draw_bifurcation_curve(curve: Any, ax: Any) -> Any:
    """Draw a `floquetrod.results.BifurcationCurve` in the plane of its parameters, and the point it was begun with."""
    ax = axes_or_new(ax)
    x, y = curve.values.T
    names = ["stable" if k == 0 else "undecided" if k < 0 else "unstable" for k in curve.outside]
    first = 0
    marks = {"marker": _MARKERS[curve.kind], "markersize": 3.5, "markevery": max(1, len(x) // _MARKS)}
    for i in range(1, len(x)):
        if i + 1 < len(x) and names[i + 1] == names[i]:
            continue
        label = _new(ax, f"{curve.kind}{_BESIDE[names[i]]}")
        style = {"color": "black", "linestyle": STYLES[names[i]], "linewidth": 1.4, **marks}
        ax.plot(x[first : i + 1], y[first : i + 1], label=label, **style)
        first = i
    style = {**palette.POINT, "marker": _MARKERS[curve.kind], "linestyle": "none", "markersize": 6, "zorder": 5}
    ax.plot(x[curve.start], y[curve.start], label=_new(ax, f"{curve.kind} on the branch"), **style)
    ax.set_xlabel(curve.parameters[0])
    ax.set_ylabel(curve.parameters[1])
    return finished(ax)


def finished(ax: Any) -> Any:
    """Return axes with margins and a legend."""
    ax.margins(x=0.02)
    ax.legend(loc="best", fontsize="small", frameon=False)
    return ax


def draw_over_parameter(
    ax: Any,
    branch: Any,
    heights: list[float],
    of_points: list[float],
    scale: float = 1.0,
    rests: tuple[float | None, float | None] = (None, None),
    fine: int = 1,
) -> None:
    """Draw heights of orbits and of special points over the parameter times ``scale``.

    ``rests`` are values of the parameter at which the branch comes to height 0 beyond its first orbit and its last.
    With ``fine`` parts between two orbits, squares of heights go along straight lines, as they do near rest.
    """
    lines = _parts(branch, heights, of_points, rests)
    for status, style in _LINES.items():
        for parameters, drawn in lines[status]:
            across, up = scale * np.array(parameters), np.array(drawn)
            if fine > 1:
                between, whole = np.arange((len(across) - 1) * fine + 1) / fine, np.arange(len(across))
                across, up = np.interp(between, whole, across), np.sqrt(np.interp(between, whole, up * up))
            ax.plot(across, up, linestyle=STYLES[status], label=_new(ax, status), solid_capstyle="butt", **style)
    for kind, marker in _MARKERS.items():
        at = [i for i, point in enumerate(branch.special_points) if point.kind == kind]
        if at:
            x, y = [scale * branch.special_points[i].value for i in at], [of_points[i] for i in at]
            style = {**palette.POINT, "marker": marker, "linestyle": "none", "markersize": 6, "zorder": 5}
            ax.plot(x, y, label=_new(ax, kind), **style)


def _parts(
    branch: Any, heights: list[float], of_points: list[float], rests: tuple[float | None, float | None]
) -> dict[str, list[tuple[list[float], list[float]]]]:
    """Return lines (x, y) by their verdict, cut where that changes: at a special point where there is one."""
    names = [_NAMES[int(code)] for code in branch.status]
    points: list[tuple[float, float, str | None]] = list(zip(branch.values.tolist(), heights, names, strict=True))
    for point, height in reversed(list(zip(branch.special_points, of_points, strict=True))):
        points.insert(point.after + 1, (point.value, height, None))
    if rests[0] is not None:
        points.insert(0, (rests[0], 0.0, names[0]))
    if rests[1] is not None:
        points.append((rests[1], 0.0, names[-1]))
    lines: dict[str, list[tuple[list[float], list[float]]]] = {name: [] for name in _LINES}
    last = None
    for (x0, y0, before), (x1, y1, behind) in pairwise(points):
        name = behind if before is None else before if behind in (None, before) else "undecided"
        name = last or "undecided" if name is None else name
        if name == last:
            lines[name][-1][0].append(x1)
            lines[name][-1][1].append(y1)
        else:
            lines[name].append(([x0, x1], [y0, y1]))
        last = name
    return lines


def _new(ax: Any, label: str) -> str | None:
    """Return a label, None where the legend has it already, of another branch in the same picture."""
    return None if label in ax.get_legend_handles_labels()[1] else label


def _heights(result: Any, state: int, quantity: str) -> Any:
    """Return the drawn heights of a branch, a list, or of a special point, a number."""
    values = np.asarray(getattr(result, quantity))
    return (values if quantity == "period" else values[..., state]).tolist()


def draw_rod_branches(result: Any, ax: Any, unit: Any) -> Any:
    """Draw the largest angles of a `floquetrod.results.RodBranches` in degrees over its parameter in a unit."""
    ax = axes_or_new(ax)
    for each in result.parts:
        degrees = np.degrees(each.amplitude), np.degrees(each.special_amplitudes)
        draw_over_parameter(
            ax, each.branch, degrees[0].tolist(), degrees[1].tolist(), 1.0 / unit.size, each.rests, _FINE
        )
        for i in each.leaves:
            ax.plot(
                each.branch.values[i] / unit.size, degrees[0][i], label=_new(ax, "about to leave its wall"), **_OFF_WALL
            )
    ax.set_xlabel(units.label(*NAMES[result.parameter], unit.name))
    ax.set_ylabel("largest angle / degree")
    ax.set_ylim(bottom=0.0)
    return finished(ax)
