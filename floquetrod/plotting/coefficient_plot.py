"""Pictures of periodic coefficients as they were written: what to look at before a verdict is asked for."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import new_axes

_MOST = 6  # entries of a matrix in one picture
_STYLES = (
    ("black", "-"),
    ("0.45", "-"),
    (palette.NEUTRAL, "-"),
    ("black", "--"),
    ("0.45", "--"),
    (palette.NEUTRAL, "--"),
)

_LEAST, _MOST_SAMPLES, _IN_A_WAVE = 201, 20_001, 24  # instants of a piece that are drawn


def instants(harmonics: int) -> NDArray[np.float64]:
    """Return the parts of a piece, from 0 to 1, at which its coefficient is drawn, for so many harmonics."""
    return np.linspace(0.0, 1.0, min(max(_LEAST, _IN_A_WAVE * harmonics + 1), _MOST_SAMPLES))


class CoefficientPiece(NamedTuple):
    """A coefficient, or several, on one piece of the period, at its ends their limits from within."""

    time: NDArray[np.float64]  # (k,)
    values: NDArray[np.float64]  # (k, number of coefficients)


def draw_coefficients(
    stretches: list[CoefficientPiece],
    names: list[str],
    *,
    time: str,
    axis: str,
    title: str,
    mean: float | None,
    ax: Any,
) -> Any:
    """Draw coefficients over one period: a line on each piece, dots across a jump, a chain at the mean."""
    ax = new_axes() if ax is None else ax
    begin, end = float(stretches[0].time[0]), float(stretches[-1].time[-1])
    shown = range(min(_MOST, len(names)))
    for i in shown:
        colour, style = _STYLES[i]
        gap = 1e-9 * max(float(np.abs(each.values[:, i]).max()) for each in stretches)
        before = stretches[-1].values[-1, i]  # the end of the period is its beginning
        for k, each in enumerate(stretches):
            line = {"color": colour, "linestyle": style, "linewidth": 1.4}
            ax.plot(each.time, each.values[:, i], label=names[i] if k == 0 else None, **line)
            if abs(each.values[0, i] - before) > gap:
                jump = {"color": colour, "linestyle": ":", "linewidth": 1.0, "label": None}
                sides = [before, each.values[0, i]]
                for instant in {float(each.time[0]), end} if k == 0 else {float(each.time[0])}:
                    ax.plot([instant, instant], sides, **jump)
            before = each.values[-1, i]
    if mean is not None:
        ax.axhline(mean, color="0.45", linestyle="-.", linewidth=0.8, label=f"mean {mean + 0.0:.5g}")
    ax.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    margin = 0.02 * (end - begin)
    ax.set_xlim(begin - margin, end + margin)
    ax.set_xlabel(f"{time}, over a period of {_period(end - begin)}")
    ax.set_ylabel(axis if len(names) == len(shown) else f"{axis}, {len(shown)} of {len(names)} entries")
    ax.set_title(title, fontsize="small")
    ax.legend(loc="best", fontsize="small", frameon=False)
    return ax


def _period(period: float) -> str:
    return {2.0 * math.pi: r"$2\pi$", math.pi: r"$\pi$"}.get(period, f"{period:.6g}")
