"""Forced motions as functions of time: a Fourier series, or polynomials on pieces of the period."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import runner
from floquetrod._util.content import ByContent
from floquetrod.responses.kernels.extremes import largest_fill

_NEGLIGIBLE = 1e-17  # part of the largest amplitude below which harmonics are left out
_LEAST = 2  # harmonics that are kept, negligible or not
_MOST_HARMONICS = 64  # of a motion with jumps in a derivative, whose amplitudes fall slowly (a choice)
_NODES, _PARTS = 40, 16  # of Gauss's rule on a part of the period, and parts: exp(i k W t) turns by 25 radians on one
_ROUNDS = 11  # of the search for an extreme: each makes its bracket four times smaller
_CLOSE = 0.55  # part of the largest square on the grid that a maximum between its points may have there
_INTERPRETED_UP_TO = 4000


class Motion(Protocol):
    """A motion x(t) = exp(i w t) u(t), u of the period, which is real without a frequency w."""

    @property
    def period(self) -> float:
        """The period T."""

    @property
    def frequency(self) -> float | None:
        """The frequency w of the force."""

    def values(self, times: Floats, derivative: int) -> Complexes:
        """Return x, or its derivative, at times (k,), as (k, n)."""

    @property
    def amplitudes(self) -> Complexes:
        """Amplitudes (2 K + 1, n) of exp(i (w + k W) t), k from -K to K."""

    def mean_squares(self) -> Floats:
        """Return the mean square of each coordinate over time, (n,)."""

    def largest(self) -> Floats:
        """Return the largest modulus of each coordinate over time, (n,)."""


@dataclass(frozen=True, eq=False)
class FourierMotion(ByContent):
    """A motion as its amplitudes (2 K + 1, n) of exp(i (w + k W) t)."""

    period: float
    frequency: float | None
    amplitudes: Complexes

    def values(self, times: Floats, derivative: int) -> Complexes:
        """Return x, or its derivative, at times (k,), as (k, n)."""
        middle = len(self.amplitudes) // 2
        shift = 0.0 if self.frequency is None else self.frequency
        rates = shift + np.arange(-middle, middle + 1) * (2.0 * math.pi / self.period)
        turns = np.outer(times / self.period % 1.0, np.arange(-middle, middle + 1))
        waves = np.exp(2j * math.pi * turns)
        if shift:
            waves *= np.exp(1j * shift * times)[:, None]
        return np.asarray(waves @ (self.amplitudes * (1j * rates[:, None]) ** derivative))

    def mean_squares(self) -> Floats:
        """Return the mean square of each coordinate over time, (n,)."""
        return np.asarray((np.abs(self.amplitudes) ** 2).sum(axis=0))

    def largest(self) -> Floats:
        """Return the largest modulus of each coordinate over time, (n,)."""
        return largest_of(self.amplitudes.T, real=self.frequency is None)


@dataclass(frozen=True, eq=False)
class PiecewiseMotion(ByContent):
    """A motion as Legendre series (S, m, n) on pieces of the period that end at ``ends`` (S + 1,)."""

    period: float
    frequency: float | None
    ends: Floats
    series: NDArray[Any]

    def values(self, times: Floats, derivative: int) -> Complexes:
        """Return x, or its derivative, at times (k,), as (k, n)."""
        turns = np.floor(times / self.period)
        phase = np.clip(times - turns * self.period, 0.0, self.period)
        values = self._within(phase, derivative)
        if self.frequency is None:
            return values
        return np.asarray(values * np.exp(1j * self.frequency * self.period * turns)[:, None])

    def _within(self, phase: Floats, derivative: int = 0) -> Complexes:
        """Return x at times within the period."""
        place = np.clip(np.searchsorted(self.ends, phase, side="right") - 1, 0, len(self.series) - 1)
        low, length = self.ends[place], (self.ends[1:] - self.ends[:-1])[place]
        series: NDArray[Any] = self.series
        if derivative:
            series = np.moveaxis(np.asarray(legendre.legder(np.moveaxis(series, 1, 0))), 0, 1)
        powers = legendre.legvander(2.0 * (phase - low) / length - 1.0, series.shape[1] - 1)
        values = np.empty((len(phase), series.shape[2]), dtype=series.dtype)
        for start in range(0, len(phase), 4096):  # a few megabytes at a time
            chunk = slice(start, start + 4096)
            values[chunk] = np.einsum("tm,tmn->tn", powers[chunk], series[place[chunk]])
        if derivative:
            values *= (2.0 / length)[:, None]
        return values.astype(complex)

    @cached_property
    def amplitudes(self) -> Complexes:
        """Amplitudes (2 K + 1, n) of exp(i (w + k W) t), k from -K to K."""
        times, weights = self._rule
        shift = 0.0 if self.frequency is None else self.frequency
        rates = np.arange(-_MOST_HARMONICS, _MOST_HARMONICS + 1) * (2.0 * math.pi / self.period) + shift
        return trimmed(np.exp(-1j * np.outer(rates, times)) @ (self._within(times) * weights[:, None]))

    def mean_squares(self) -> Floats:
        """Return the mean square of each coordinate over time, (n,)."""
        times, weights = self._rule
        return np.asarray(weights @ np.abs(self._within(times)) ** 2)

    @property
    def _rule(self) -> tuple[Floats, Floats]:
        """Gauss's nodes on parts of the pieces, and weights of a mean over the period."""
        nodes, weights = legendre.leggauss(_NODES)
        parts = math.ceil(_PARTS * float(np.diff(self.ends).max()) / self.period)
        length = np.repeat(np.diff(self.ends) / parts, parts)
        begins = np.repeat(self.ends[:-1], parts) + np.tile(np.arange(parts), len(self.series)) * length
        times = begins[:, None] + 0.5 * length[:, None] * (nodes + 1.0)
        return times.ravel(), (0.5 * length[:, None] * weights / self.period).ravel()

    def largest(self) -> Floats:
        """Return the largest modulus of each coordinate over time, (n,)."""
        parts = np.linspace(0.0, 1.0, 17)[:-1]
        times = np.append((self.ends[:-1, None] + np.diff(self.ends)[:, None] * parts).ravel(), self.ends[-1])
        squares = np.abs(self._within(times)) ** 2
        largest = np.sqrt(squares.max(axis=0))
        for i in range(squares.shape[1]):
            square = squares[:, i]
            inner = np.arange(len(times))
            before, after = np.maximum(inner - 1, 0), np.minimum(inner + 1, len(times) - 1)
            peaks = (square >= square[before]) & (square >= square[after]) & (square >= _CLOSE * square.max())
            low, high = times[before[peaks]], times[after[peaks]]
            for _ in range(_ROUNDS):
                grid = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, 9)
                sizes = np.abs(self._within(grid.ravel())[:, i]).reshape(grid.shape)
                largest[i] = max(largest[i], float(sizes.max()))
                best = sizes.argmax(axis=1)
                rows = np.arange(len(grid))
                low, high = grid[rows, np.maximum(best - 1, 0)], grid[rows, np.minimum(best + 1, 8)]
        return np.asarray(largest)


def trimmed(amplitudes: Complexes) -> Complexes:
    """Return amplitudes (2 K + 1, n) without the negligible outermost harmonics."""
    middle = len(amplitudes) // 2
    sizes = np.abs(amplitudes)
    top = np.maximum(sizes.max(axis=0), 1e-300)
    seen = np.flatnonzero((sizes > _NEGLIGIBLE * top).any(axis=1))
    most = min(middle, int(np.abs(seen - middle).max(initial=_LEAST)))
    return amplitudes[middle - most : middle + most + 1]


def largest_of(amplitudes: Any, *, real: bool) -> Floats:
    """Return the largest modulus over a period of series with amplitudes (b, 2 K + 1)."""
    series = np.ascontiguousarray(amplitudes, dtype=complex)
    out = np.empty((len(series), 2))
    free = 0 if "numba" in sys.modules else _INTERPRETED_UP_TO
    run = runner(largest_fill, 8 * series.shape[1] * series.size, interpret_up_to=free, compile_after=20)
    run(series if run is not largest_fill else series.tolist(), out, real)
    return out[:, 0].copy()
