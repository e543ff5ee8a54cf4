"""The growth rate of a mode from its recorded amplitude, by the recurrence that a Floquet solution obeys."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEAST_PER_PERIOD = 8  # frames in a forcing period: interpolation between them costs the rate less than 1e-4
_LINEAR_UP_TO = 0.05  # rad: up to here sin(theta) is theta to 4e-4 (a choice)
_MARGIN = 4  # frames at both ends to which the recurrence does not reach (heuristic)


class GrowthFit(NamedTuple):
    """A growth rate in 1/s, the times between which it was fitted, and how far both halves of them disagree."""

    rate: float
    start: float
    end: float
    error: float

    def __repr__(self) -> str:
        """Return, say, "4.22 +- 0.0003 1/s between 0 s and 1.2 s"."""
        return f"{self.rate:.6g} +- {self.error:.1g} 1/s between {self.start:.3g} s and {self.end:.3g} s"


def fit_growth(
    time: NDArray[np.float64], amplitude: NDArray[np.float64], period: float, damping_rate: float
) -> GrowthFit:
    """Return the growth rate of a solution of A'' + 2 c A' = p(t) A with p of ``period`` T, sampled at equal times.

    Any solution obeys A(t + T) + exp(-2 c T) A(t - T) = D A(t), D the trace of the monodromy matrix, the decaying
    partner and the phase included.  D is the least-squares solution with every time given equal weight; the rate is
    that of the larger root of z + exp(-2 c T) / z = D, zero at the least.
    """
    from scipy.interpolate import make_interp_spline

    step = float(time[1] - time[0])
    shift = period / step
    curve = make_interp_spline(np.arange(len(time)), amplitude, k=7)
    # The ends of an interpolating spline are its worst part.
    places = np.arange(math.ceil(shift) + _MARGIN, math.floor(len(time) - 1 - shift) - _MARGIN + 1)
    before, after = curve(places - shift), curve(places + shift)
    middle, total = amplitude[places], after + math.exp(-2.0 * damping_rate * period) * before
    weight = 1.0 / np.maximum(before**2 + middle**2 + after**2, 1e-300)

    def rate(part: slice) -> float:
        trace = float(np.sum((weight * middle * total)[part]) / np.sum((weight * middle**2)[part]))
        return growth_of_trace(trace, period, damping_rate)

    half = len(places) // 2
    both = rate(slice(None)), abs(rate(slice(None, half)) - rate(slice(half, None)))
    return GrowthFit(both[0], float(time[0]), float(time[-1]), 0.5 * both[1])


def fit_linear_growth(
    time: NDArray[np.float64],
    amplitude: NDArray[np.float64],
    largest_angle: NDArray[np.float64],
    *,
    duration: float,
    frames: int,
    period: float | None,
    damping_rate: float,
) -> GrowthFit:
    """Return the growth rate of a mode up to the time at which any node passes 0.05 rad.

    ``duration`` in s and ``frames`` are those of the whole run.  ``period`` is that of the force, in s; None where it
    is constant, and any period will do.  Raises ValueError where there are fewer than three periods, or fewer than 8
    frames in each.
    """
    beyond = np.flatnonzero(largest_angle > _LINEAR_UP_TO)
    count = int(beyond[0]) if beyond.size else time.size
    step = duration / (frames - 1)
    if period is None:
        period = max(count, 9) * step / 4.0
    if period < LEAST_PER_PERIOD * step:
        needed = math.ceil(LEAST_PER_PERIOD * duration / period) + 1
        raise ValueError(f"growth_rate needs {LEAST_PER_PERIOD} frames a forcing period: ask for {needed} frames")
    if (count - 1) * step < 3.0 * period:
        raise ValueError(
            f"growth_rate needs three forcing periods of motion below {_LINEAR_UP_TO:g} rad, got "
            f"{max(0, count - 1) * step / period:.2g}; simulate longer, or from a smaller perturbation"
        )
    return fit_growth(time[:count], amplitude[:count], period, damping_rate)


def growth_of_trace(trace: float, period: float, damping_rate: float) -> float:
    """Return the growth rate that belongs to a trace of the monodromy matrix, zero when nothing grows."""
    size = 0.5 * abs(trace) * math.exp(damping_rate * period)
    return max(0.0, math.acosh(size) / period - damping_rate) if size > 1.0 else 0.0
