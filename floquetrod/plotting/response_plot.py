"""Pictures of forced motions."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod.plotting.chart_plot import axes_or_new

_LINES = ("-", "--", "-.", ":")


def draw_response(response: Any, ax: Any) -> Any:
    """Draw a `floquetrod.results.Response` over a period, its modulus where it has a frequency of its own."""
    ax = axes_or_new(ax)
    time = np.linspace(0.0, response.period, 801)
    values = np.asarray(response.solution(time)).reshape(len(time), -1)
    letter = response.letter
    real = response.frequency is None
    means = np.atleast_1d(response.mean)
    for i in range(min(values.shape[1], 8)):
        name = letter if values.shape[1] == 1 else f"{letter}_{{{i + 1}}}"
        shown = values[:, i] if real else np.abs(values[:, i])
        label = f"${name}$" if real else f"$|{name}|$"
        grey = "black" if i < 4 else "0.55"
        ax.plot(time, shown, _LINES[i % 4], color=grey, linewidth=1.2, label=label)
        if real:
            ax.axhline(means[i], color=grey, linestyle=_LINES[i % 4], linewidth=0.5)
    ax.set_xlabel(f"time, over a period of {response.period:.5g}")
    if values.shape[1] > 1:
        ax.set_ylabel(f"steady motion ${letter}_i$" if real else f"modulus $|{letter}_i|$ of the steady motion")
        ax.legend(fontsize="small")
    else:
        ax.set_ylabel(f"steady motion ${letter}$" if real else f"modulus $|{letter}|$ of the steady motion")
    at = "" if real else f" at the frequency {response.frequency:.6g}"
    ax.set_title(f"Response{at}" + ("; thin: mean" if real else ""), fontsize="small")
    return ax
