"""Lines in the spectrum of a record's residual: sines that its fit does not hold, such as that of a second tool."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.rod.loads.record_fit import Samples
from floquetrod.rod.loads.record_period import Spectrum, power_spectrum

LEAST_LINE = 0.01
"""Amplitude of a line over that of the fit, from which it is kept (a choice)."""

_FALSE_LINE = 1e-3  # chance that noise alone, as strong everywhere as about the line, makes one (a choice)
_MOST = 5  # lines searched for (a choice)
_NEAR = 4.0  # frequencies that the record tells apart, about 0 and a harmonic, that are drift and wander (a choice)
_ABOUT = (8.0, 32.0)  # frequencies that the record tells apart on either side of a line, whose noise counts (a choice)
_OWN = 3.0  # of them about the line itself, over which its power leaks
_FEWEST = 4.0  # of them that tell the level of the noise (a choice)
_LEVEL_ERROR = 3.0  # standard errors by which that level may be underestimated (a choice)
_STEPS = 30  # of the search for the frequency of a line: each divides its bracket by 1.6


class Line(NamedTuple):
    """A sine amplitude sin(omega tau + phase) in the units of `Samples`."""

    amplitude: float
    omega: float
    phase: float

    def values(self, tau: Floats) -> Floats:
        """Return the sine at times."""
        result: Floats = self.amplitude * np.sin(self.omega * tau + self.phase)
        return result


def lines(samples: Samples, residual: Floats, harmonics: Floats, least: float) -> list[Line]:
    """Return lines of at least an amplitude in the residual of a fit of ``harmonics``, the strongest first.

    A line has more power than noise, as strong everywhere as about the line, has anywhere in a record of 1000.  The
    level of that noise is the median of the power, over log 2, as the power of noise is distributed exponentially, on
    the side and within the distance where that is largest.
    Nothing is searched for within four frequencies that the record tells apart of 0 and of harmonics in the fit, at
    omega = ``harmonics``, where a drift or a fundamental that wanders leaves as much.
    """
    periods = harmonics / math.pi
    found: list[Line] = []
    left = residual
    for _ in range(_MOST):
        power = power_spectrum(samples, left)
        place = _strongest(power, periods, [line.omega / math.pi for line in found])
        if place is None:
            break
        line = _fitted(samples, left, math.pi * power.step * (place + 1), math.pi * power.step)
        if line.amplitude < least:
            break
        found.append(line)
        left = left - line.values(samples.tau)
    return sorted(found, key=lambda line: -line.amplitude)


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
    """Return the level of the noise about a line, the largest that a side tells; infinite where none does."""
    levels = []
    for reach in _ABOUT:
        for side in (power.within(at - reach, at - _OWN), power.within(at + _OWN, at + reach)):
            independent = power.power[side].size * power.step
            if independent > _FEWEST:
                error = 1.0 + _LEVEL_ERROR / math.sqrt(independent)
                levels.append(float(np.median(power.power[side])) / math.log(2.0) * error)
    return max(levels, default=math.inf)


def _fitted(samples: Samples, values: Floats, omega: float, width: float) -> Line:
    """Return the sine nearest to values by least squares, of a frequency within a width of one: by golden section."""
    low, high = omega - width, omega + width
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    inner = [high - ratio * (high - low), low + ratio * (high - low)]
    sizes = [abs(_transform(samples, values, each)) for each in inner]
    for _ in range(_STEPS):
        if sizes[0] > sizes[1]:
            high, inner[1], sizes[1] = inner[1], inner[0], sizes[0]
            inner[0] = high - ratio * (high - low)
            sizes[0] = abs(_transform(samples, values, inner[0]))
        else:
            low, inner[0], sizes[0] = inner[0], inner[1], sizes[1]
            inner[1] = low + ratio * (high - low)
            sizes[1] = abs(_transform(samples, values, inner[1]))
    best = 0.5 * (low + high)
    waves = np.column_stack([np.sin(best * samples.tau), np.cos(best * samples.tau)])
    sine, cosine = np.linalg.lstsq(waves, values, rcond=None)[0].tolist()
    return Line(math.hypot(sine, cosine), best, math.atan2(cosine, sine))


def _transform(samples: Samples, values: Floats, omega: float) -> Any:
    """Return the sum of values exp(-i omega tau)."""
    turns: Complexes = np.exp(-1j * omega * samples.tau)
    return values @ turns
