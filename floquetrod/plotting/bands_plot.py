"""Pictures of bands of energies over the phase, with the density of states beside."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod.plotting import palette
from floquetrod.plotting.chart_plot import axes_or_new

_ENERGIES = 240  # at which the density of states is drawn


def draw_bands(bands: Any, ax: Any) -> Any:
    """Draw `floquetrod.results.EnergyBands`: energies over phases, gaps shaded, and the density of states."""
    beside = None
    if ax is None:
        from matplotlib import pyplot

        _, (ax, beside) = pyplot.subplots(
            1, 2, figsize=(7.2, 4.2), sharey=True, width_ratios=(2.2, 1.0), layout="constrained"
        )
    ax = axes_or_new(ax)
    phases, energies = np.atleast_1d(bands.phase), np.atleast_2d(bands.energies)
    order = np.argsort(phases)
    style: dict[str, Any] = {"color": "black", "linewidth": 1.4}
    if len(phases) == 1:
        style = palette.POINT | {"linestyle": "none", "markersize": 5}
    ax.plot(phases[order], energies[order], **style)
    bottom, top = _range(bands)
    for i, (low, high) in enumerate(bands.gaps.tolist()):
        for axes in (ax, beside) if beside is not None else (ax,):
            axes.axhspan(low, min(high, top), color=palette.UNKNOWN, zorder=0, label="gap" if i == 0 else None)
    ax.set_ylim(bottom, top)
    ax.set_xlabel("phase over a period / rad")
    ax.set_ylabel("energy $E$")
    if len(phases) > 1:
        ax.set_xlim(float(phases.min()), float(phases.max()))
        turns = np.arange(
            math.ceil(phases.min() / math.pi * 2.0 - 1e-9), math.floor(phases.max() / math.pi * 2.0 + 1e-9) + 1
        )
        if len(turns) <= 9:
            ax.set_xticks(turns * math.pi / 2.0, [_in_pi(int(turn)) for turn in turns])
    if beside is not None:
        _draw_density(beside, bands, bottom, top)
    if len(bands.gaps):
        (ax if beside is None else beside).legend(loc="upper right", fontsize="small")
    return ax


def _range(bands: Any) -> tuple[float, float]:
    """Return the energies that the picture ends at."""
    bottom = float(bands.edges.min()) if len(bands.edges) else bands.below - 1.0
    return bottom - 0.06 * (bands.below - bottom), bands.below


def _in_pi(half_turns: int) -> str:
    """Return a multiple of pi / 2 as a label."""
    if half_turns % 2 == 0:
        whole = half_turns // 2
        return {0: "0", 1: r"$\pi$", -1: r"$-\pi$"}.get(whole, rf"${whole}\pi$")
    return {1: r"$\pi/2$", -1: r"$-\pi/2$"}.get(half_turns, rf"${half_turns}\pi/2$")


def _draw_density(ax: Any, bands: Any, bottom: float, top: float) -> None:
    """Draw the density of states up from the left, its peaks at edges cut off."""
    energies = _energies(bands, bottom, top)
    density = bands.density(energies)
    ax.plot(density, energies, color="black", linewidth=1.2)
    positive = density[density > 0.0]
    if positive.size:
        ax.set_xlim(0.0, 4.0 * float(np.median(positive)))
    ax.set_xlabel("density of states")


def _energies(bands: Any, bottom: float, top: float) -> Any:
    """Return energies at which the density is drawn: closer together towards the edges of bands, both sides of each."""
    parts = [np.array([bottom])]
    count = max(12, _ENERGIES // max(1, len(bands.edges)))
    nodes = 0.5 * (1.0 - np.cos(math.pi * (np.arange(count) + 0.5) / count))
    for low, high in bands.edges.tolist():
        inside = low + (high - low) * nodes
        parts.append(np.concatenate([[low - 1e-9 * (top - bottom)], inside, [high + 1e-9 * (top - bottom)]]))
    energies = np.unique(np.concatenate(parts))
    return energies[(energies >= bottom) & (energies <= top)]
