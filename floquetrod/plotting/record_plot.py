"""Drawings of measured forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod.plotting.chart_plot import axes_or_new
from floquetrod.units import Unit

_SHOWN = 8  # periods drawn of a record (a choice)
_BEYOND = 3.0  # times the frequency of the last harmonic kept, up to which the spectrum is drawn (a choice)


def draw_record(record: Any, ax: Any, force: Unit) -> Any:
    """Draw a `floquetrod.ForceRecord` on two axes: its first periods with the fit, and its spectrum with the noise.

    Forces are in the unit ``force``; without axes a new figure is made.
    """
    from matplotlib import pyplot

    if ax is None:
        ax = pyplot.subplots(2, 1, figsize=(7.0, 6.0), layout="constrained")[1]
    chosen = validate.listed("ax", ax, 2, "axes") if validate.iterable(ax) else []
    if len(chosen) != 2:
        raise validate.wrong_type("ax", f"must be two axes of matplotlib, got {validate.short(ax)}")
    above, below = (axes_or_new(each) for each in chosen)
    _draw_fit(record, above, force)
    _draw_spectrum(record, below, force)
    return ax


def draw_record_and_shape(record: Any, verdict: Any, force: Unit) -> Any:
    """Return a figure of a record with, below, the shape that grows under it; ValueError where there is none.

    Forces are in the unit ``force``.
    """
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(7.0, 9.2), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=[1.5, 1.0])
    above, below = parts
    try:
        verdict.plot(below.subplots())
    except ValueError:
        pyplot.close(figure)
        raise
    draw_record(record, above.subplots(2, 1), force)
    return figure


def _draw_fit(record: Any, ax: Any, shown: Unit) -> None:
    """Draw samples in grey and the fit in black over the first periods."""
    start = record.time[0]
    end = min(record.time[-1], start + _SHOWN * record.period)
    seen = record.time <= end
    ax.plot(
        record.time[seen] - start, shown.of(record.samples[seen]), ".", color="0.65", markersize=2.5, label="record"
    )
    times = np.linspace(start, end, 2000)
    middle = 0.5 * (record.time[0] + record.time[-1])
    fit = record.force(times) + record.trend * (times - middle)
    ax.plot(
        times - start,
        shown.of(fit),
        color="black",
        linewidth=1.0,
        label="fit with its trend" if record.trend else "fit",
    )
    ax.set_xlabel("time after the first sample / s" if start else "time $t$ / s")
    ax.set_ylabel(f"force $F$ / {shown.name}")
    ax.legend(fontsize="x-small", loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)


def _draw_spectrum(record: Any, ax: Any, shown: Unit) -> None:
    """Draw the spectra in grey, the harmonics kept in black with two standard errors, and the noise dashed."""
    frequency, *amplitudes = record.spectrum()
    whole, left = map(shown.of, amplitudes)
    noise = shown.of(2.0 * record.noise / np.sqrt(record.time.size))  # root mean square of what it adds to an amplitude
    size = f"{shown.of(record.noise):.3g} {shown.name}"
    ax.plot(frequency, whole, color="0.75", linewidth=0.8, label="record less mean and trend")
    ax.plot(frequency, left, color="0.4", linewidth=0.8, label="what the fit leaves")
    places = np.array(record.harmonic_numbers, dtype=int) - 1
    sizes, errors = shown.of(np.abs(record.harmonics[places])), shown.of(2.0 * record.harmonic_errors[places])
    end, largest = frequency[-1], float(whole.max())
    if places.size:
        end, largest = min(end, _BEYOND * (places[-1] + 1) / record.period), float(sizes.max())
        ax.errorbar(
            (places + 1) / record.period, sizes, errors, fmt="o", color="black", markersize=4, label="harmonics kept"
        )
    ax.axhline(noise, color="black", linestyle="--", linewidth=0.8, label=f"noise of {size} a sample, on average")
    ax.set_yscale("log")
    ax.set_xlim(0.0, end)
    ax.set_ylim(0.1 * noise if noise > 1e-9 * largest else 1e-6 * largest, 2.0 * largest)
    ax.set_xlabel("frequency / Hz")
    ax.set_ylabel(f"amplitude / {shown.name}")
    ax.legend(fontsize="x-small", loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
