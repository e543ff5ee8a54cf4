"""Pictures of branches of periodic orbits."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.charts import new_axes
from floquetrod.plotting.orbits import STYLES

_LINES: dict[str, dict[str, Any]] = {
    "stable": {"color": "black", "linewidth": 1.8},
    "unstable": {"color": palette.UNSTABLE, "linewidth": 1.4},
    "undecided": {"color": "0.5", "linewidth": 1.4},
}
_MARKERS = {"fold": "^", "branch point": "D", "period doubling": "s", "Neimark-Sacker": "o"}
_NAMES = {1: "stable", 0: "unstable", -1: "undecided"}


def draw_branch(branch: Any, ax: Any, state: int, quantity: str) -> Any:
    """Draw a quantity of a `floquetrod.Branch` over its parameter, its parts in lines that tell their verdict."""
    ax = new_axes() if ax is None else ax
    lines = _parts(branch, state, quantity)
    for status, style in _LINES.items():
        for x, y in lines[status]:
            ax.plot(x, y, linestyle=STYLES[status], label=_new(ax, status), solid_capstyle="butt", **style)
    _draw_points(branch, ax, state, quantity)
    ax.margins(x=0.02)
    ax.set_xlabel(branch.parameter)
    ax.set_ylabel("period" if quantity == "period" else f"{quantity} of x[{state}]")
    ax.legend(loc="best", fontsize="small", frameon=False)
    return ax


def _parts(branch: Any, state: int, quantity: str) -> dict[str, list[tuple[list[float], list[float]]]]:
    """Return lines (x, y) by their verdict, cut where that changes: at a special point where there is one."""
    x, y = branch.values.tolist(), _heights(branch, state, quantity)
    names = [_NAMES[int(code)] for code in branch.status]
    points: list[tuple[float, float, str | None]] = [(*each, name) for *each, name in zip(x, y, names, strict=True)]
    for point in reversed(branch.special_points):
        points.insert(point.after + 1, (point.value, _heights(point, state, quantity), None))
    found: dict[str, list[tuple[list[float], list[float]]]] = {name: [] for name in _LINES}
    last = None
    for (x0, y0, before), (x1, y1, behind) in pairwise(points):
        name = behind if before is None else before if behind in (None, before) else "undecided"
        name = last or "undecided" if name is None else name
        if name == last:
            found[name][-1][0].append(x1)
            found[name][-1][1].append(y1)
        else:
            found[name].append(([x0, x1], [y0, y1]))
        last = name
    return found


def _draw_points(branch: Any, ax: Any, state: int, quantity: str) -> None:
    """Draw special points with a marker for each kind, named in the legend."""
    for kind, marker in _MARKERS.items():
        points = [point for point in branch.special_points if point.kind == kind]
        if points:
            heights = [_heights(point, state, quantity) for point in points]
            style = {**palette.POINT, "marker": marker, "linestyle": "none", "markersize": 6, "zorder": 5}
            ax.plot([point.value for point in points], heights, label=_new(ax, kind), **style)


def _new(ax: Any, label: str) -> str | None:
    """Return a label, None where the legend has it already, of another branch in the same picture."""
    return None if label in ax.get_legend_handles_labels()[1] else label


def _heights(result: Any, state: int, quantity: str) -> Any:
    """Return what is drawn of a branch, a list, or of a special point, a number."""
    values = np.asarray(getattr(result, quantity))
    return (values if quantity == "period" else values[..., state]).tolist()
