"""The drawing of pick-up and slack-off weights over depth, for several factors of friction."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.plotting.chart_plot import axes_or_new
from floquetrod.plotting.leaders import add_leaders
from floquetrod.units import AnswerUnits

_DASHES = ["-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)), (0, (1, 3)), (0, (9, 2, 1, 2, 1, 2))]
"""Of the lines of one factor of friction each, which are told apart in grey, too."""


_BESIDE = 0.05  # of the weights shown, between them and the ends of the axis (a choice)
_NAMED_AT = 0.7  # of the depth, where pick-up and slack-off are named (a choice)
_LEFT = 0.5  # of the range of weights of a string picked up, by which the axis goes on to the left (a choice)


def draw_weights(result: Any, shown: AnswerUnits, ax: Any = None) -> Any:
    """Draw `SurfaceWeights`: weights at the surface to the right, the depth of the lower end downwards."""
    ax = axes_or_new(ax)
    depth, force = shown.length.of(result.depth), shown.force
    ax.plot(force.of(result.free), depth, color="0.6", linewidth=2.5, label="without friction")
    moved = np.concatenate([result.pick_up.ravel(), result.free])
    left = force.of(moved.min() - _LEFT * (moved.max() - moved.min()))
    stops: list[tuple[float, float]] = []
    for k, factor in enumerate(result.friction):
        style = {"color": str(0.12 * (k // len(_DASHES))), "linestyle": _DASHES[k % len(_DASHES)], "linewidth": 1.3}
        ax.plot(force.of(result.pick_up[k]), depth, label=f"friction {factor.in_words(shown.length)}", **style)
        goes = np.isfinite(result.slack_off[k])
        ax.plot(force.of(result.slack_off[k][goes]), depth[goes], **style)
        if np.isfinite(result.lock_up[k]) and goes.any():
            stops.append((max(left, force.of(result.slack_off[k][goes][-1])), depth[goes][-1]))
    if stops:
        ax.plot(*np.transpose(stops), "kx", markersize=7.0, clip_on=False, label="locks up below")
    ax.axvline(0.0, color="0.7", linewidth=0.6, zorder=0.0)
    start, end = shown.length.of(result.path.start), float(depth[-1])
    ax.set_ylim(end, start)
    right = force.of(moved.max())
    lowest = min(float(np.min(line.get_xdata(), initial=right)) for line in ax.lines)
    room = _BESIDE * (right - max(left, lowest))
    ax.set_xlim(left if lowest < left else lowest - room, right + room)
    ax.xaxis.set_label_position("top")
    ax.xaxis.tick_top()
    ax.set_xlabel(f"surface weight{' (below 0: pushed)' if _is_pushed(result) else ''} / {force.name}")
    ax.set_ylabel(f"measured depth of the lower end / {shown.length.name}")
    ax.legend(loc="best", fontsize="small", frameon=False)
    named = [("pick-up", result.pick_up), ("slack-off", result.slack_off)]
    points = []
    for _, weights in named:
        last = weights[-1][np.isfinite(weights[-1])]
        k = int(_NAMED_AT * (last.size - 1)) if last.size else 0
        points.append((max(float(force.of(weights[-1, k])), left), float(depth[k])))
    add_leaders(ax, [name for name, _ in named], points)
    return ax


def _is_pushed(result: Any) -> bool:
    """Return whether the string has to be pushed anywhere."""
    finite = result.slack_off[np.isfinite(result.slack_off)]
    return bool((finite < 0.0).any() or (result.pick_up < 0.0).any())
