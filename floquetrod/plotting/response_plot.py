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


def draw_gain(spectrum: Any, ax: Any) -> Any:
    """Draw a `floquetrod.results.Gain`: magnitudes of signal and idlers over frequency."""
    ax = axes_or_new(ax)
    order = sorted(range(len(spectrum.waves)), key=lambda j: (abs(spectrum.waves[j]), spectrum.waves[j] > 0))
    for i, j in enumerate(order):
        k = spectrum.waves[j]
        name = "signal, $k = 0$" if k == 0 else f"idler, $k = {k}$"
        grey = "black" if i < 4 else "0.55"
        ax.plot(
            spectrum.frequency, abs(spectrum.amplitudes[:, j]), _LINES[i % 4], color=grey, linewidth=1.2, label=name
        )
    ax.set_yscale("log")
    ax.set_xlabel(r"frequency of the force $\omega$, radians per unit of time")
    ax.set_ylabel("amplitude per amplitude of the force")
    ax.set_title(f"Gain: peak {spectrum.peak[1]:.5g} at {spectrum.peak[0]:.5g}", fontsize="small")
    ax.legend(fontsize="small")
    return ax


def draw_variance(noise: Any, ax: Any) -> Any:
    """Draw the variances of a `floquetrod.results.OutputNoise` over a period, and their means as thin lines."""
    ax = axes_or_new(ax)
    time = np.linspace(0.0, noise.period, 401)
    n = len(noise.sources)
    whole = np.asarray(noise.covariance(time)).reshape(len(time), n, n)
    means = np.atleast_1d(noise.variance)
    for i in range(min(n, 8)):
        grey = "black" if i < 4 else "0.55"
        ax.plot(time, whole[:, i, i], _LINES[i % 4], color=grey, linewidth=1.2, label=f"coordinate {i}")
        ax.axhline(means[i], color=grey, linestyle=_LINES[i % 4], linewidth=0.5)
    ax.set_ylim(0.0, None)
    ax.set_xlabel(f"time, over a period of {noise.period:.5g}")
    ax.set_ylabel("variance")
    if n > 1:
        ax.legend(fontsize="small")
    ax.set_title("Variance under noise; thin: mean", fontsize="small")
    return ax
