"""Pictures of solutions over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.plotting.chart_plot import axes_or_new


def draw_solution(solution: Any, ax: Any, periods: float) -> Any:
    """Draw a `floquetrod.mathieu.FloquetSolution` from 0 on: real part solid, imaginary part, if any, dashed."""
    ax = axes_or_new(ax)
    time = np.linspace(0.0, periods * solution.period, 1000)
    values = solution(time)
    ax.plot(time, values.real, color="black", linewidth=1.2, label="real part")
    if not solution.is_real:
        ax.plot(time, values.imag, color="black", linestyle="--", linewidth=1.0, label="imaginary part")
        ax.legend(loc="best", fontsize="small")
    ax.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    per = "$z$" if solution.period < 4.0 else r"$\tau$"
    rate = solution.exponent.real if solution.exponent.imag == 0.0 else solution.exponent
    exponent = f"\nexponent {rate:.5g} per unit of {per}".replace("j", "i") if rate else ""
    ax.set_xlabel(per)
    ax.set_ylabel("solution, without unit")
    ax.set_title(f"{solution.name}{exponent}", fontsize="small", wrap=True)
    return ax
