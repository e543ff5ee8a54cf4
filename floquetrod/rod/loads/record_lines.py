"""Lines in the spectrum of a record's residual: sines that its fit does not hold, such as that of a second tool."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.rod.loads.record_fit import Fit, Samples, fit, series
from floquetrod.rod.loads.record_period import PeriodicFit, Spectrum, coloured, power_spectrum, refine

LEAST_LINE = 0.01
"""Amplitude of a line over that of the fit, from which it is kept (a choice)."""

_FALSE_LINE = 1e-3  # chance that noise alone, as strong everywhere as about the line, makes one (a choice)
_MOST = 5  # lines searched for (a choice)
_NEAR = 4.0  # frequencies that the record tells apart, about 0 and a harmonic, that are drift and wander (a choice)
_ABOUT = (8.0, 32.0)  # frequencies that the record tells apart on either side of a line, whose noise counts (a choice)
_OWN = 3.0  # of them about the line itself, over which its power leaks
_FEWEST = 4.0  # of them, from which the level of the noise is known (a choice)
_LEVEL_ERROR = 3.0  # standard errors by which that level may be underestimated (a choice)
_TURNS = 30  # of the fit of two frequencies at most; two to five are usual
_SETTLED = 1e-4  # change of the second sine in a turn, in its standard errors (a choice)


def fitted_lines(samples: Samples, residual: Floats, harmonics: Floats, least: float) -> list[Fit]:
    """Return fits of one harmonic each to lines in the residual of a fit of ``harmonics``, the strongest first.

    ``least`` is the smallest amplitude of a line.  A line has more power than noise, as strong everywhere as about the
    line, has anywhere in a record of 1000.  The level of that noise is the median of the power, over log 2, as the
    power of noise is distributed exponentially, on the side and within the distance where that is largest.  Nothing is
    searched for within four frequencies that the record tells apart of 0 and of harmonics in the fit, at omega =
    ``harmonics``, where a drift or a fundamental that wanders leaves as much.
    """
    periods = harmonics / math.pi
    found: list[Fit] = []
    left = replace(samples, values=residual)
    for _ in range(_MOST):
        power = power_spectrum(samples, left.values)
        place = _strongest(power, periods, [line.omega / math.pi for line in found])
        if place is None:
            break
        line = fit(left, math.pi * power.step * (place + 1), (1,), trend=False)
        if line is None or abs(line.amplitudes[0]) < least:
            break
        found.append(line)
        left = replace(left, values=left.values - line.values(samples.tau))
    return sorted(found, key=lambda line: -abs(line.amplitudes[0]))


class TwoSines(NamedTuple):
    """The joint fit of a periodic force and of a second sine, with the errors of both."""

    found: PeriodicFit
    second: Fit  # its mean is 0


def fit_with_second(samples: Samples, found: PeriodicFit, line: Fit, most: int | None) -> TwoSines | None:
    """Return the joint fit of mean, trend, harmonics and a second sine, None where it does not settle.

    ``line`` is the sine fitted to the residual of ``found``.
    """
    # Least squares of f(tau) + Re c exp(i w_2 tau), f the mean, trend and harmonics, by turns: f is fitted to the
    # samples less the sine, the sine to the samples less f.  Where neither moves any more the residual is orthogonal
    # to the derivatives by all unknowns, as in one fit of all.  A turn shrinks the distance to it by cos^2 of the angle
    # between the derivatives of both.  At four frequencies that the record tells apart or more, as for every line,
    # that is a few hundredths at most, and so is what the covariance of both leaves out of the errors of each.
    tau, scale = samples.tau, 1.0
    for _ in range(_TURNS):
        sine = series(line.omega * tau, (1,), line.amplitudes)
        new = refine(replace(samples, values=samples.values - sine), found, most)
        if new is None:
            return None
        found = new
        left = samples.values - found.fit.values(tau)
        moved = fit(replace(samples, values=left), line.omega, (1,), trend=False)
        if moved is None:
            return None
        scale = moved.sizes()[1].item()
        step = abs((moved.amplitudes - line.amplitudes).item()) / scale
        line, turned = moved, abs(moved.omega - line.omega) / moved.frequency_error
        if max(step, turned) <= _SETTLED:
            break
    else:
        return None
    # The residual of all: its degrees of freedom are fewer by the three unknowns of the second sine.
    free = found.fit.free - 3
    if free < 1:
        return None
    variance = found.fit.squares / free
    first = replace(found.fit, covariance=found.fit.covariance * (variance / found.fit.variance), free=free)
    residual = left - series(line.omega * tau, (1,), line.amplitudes)
    line = replace(line, covariance=line.covariance * (variance / line.variance), squares=found.fit.squares, free=free)
    line = line.with_noise(coloured(line, power_spectrum(samples, residual)))
    return TwoSines(found._replace(fit=first), line)


def _strongest(power: Spectrum, harmonics: Floats, known: list[float]) -> int | None:
    """Return where the strongest line is in a spectrum, None without any."""
    at = power.step * np.arange(1, power.power.size + 1)
    is_open = at > _NEAR
    for taken, reach in (*((harmonic, _NEAR) for harmonic in harmonics.tolist()), *((line, _OWN) for line in known)):
        is_open &= np.abs(at - taken) > reach
    tried = float(is_open.sum()) * power.step
    for place in np.argsort(np.where(is_open, -power.power, 0.0))[:_MOST].tolist():
        if not is_open[place]:
            break
        if power.power[place] > _level(power, at[place]) * math.log(max(tried, 1.0) / _FALSE_LINE):
            return int(place)
    return None


def _level(power: Spectrum, at: float) -> float:
    """Return the level of the noise about a line, on the side where it is largest; infinite where it is not known."""
    levels = []
    for reach in _ABOUT:
        for side in (power.within(at - reach, at - _OWN), power.within(at + _OWN, at + reach)):
            independent = power.power[side].size * power.step
            if independent > _FEWEST:
                error = 1.0 + _LEVEL_ERROR / math.sqrt(independent)
                levels.append(float(np.median(power.power[side])) / math.log(2.0) * error)
    return max(levels, default=math.inf)
