"""How fast waves across a string grow under a force of two frequencies, at each depth of a well.

A wave k obeys A'' + 2 c A' = (beta + a_1 cos(w_1 t) + a_2 cos(w_2 t)) A with m beta = -(E I k^4 - F k^2 + N / R) and
m a_i = dF_i (k^2 - N' / R), as in `growth_along`; phases do not matter.  Its tongues lie where the natural frequency W
is w_1 / 2 or w_2 / 2, of half width h = a_i / 2 in W^2, and, of second order, at w_1 and w_2, h = a_i^2 / (2 w_i)^2,
and at (w_2 +- w_1) / 2, h = a_1 a_2 / (2 w_1 w_2); growth in the middle is h / (2 W).  Other terms of second order
shift the middle of each by a_i^2 / (8 (W^2 - w_i^2 / 4)), and a tongue at w_i / 2 by -a_i^2 / (8 w_i^2) by itself.

These rank the waves; the growth of the best of them is that of periodic approximants.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod.equations import Hill, TwoFrequencies
from floquetrod.floquet.quasiperiodic import growth_of_many
from floquetrod.rod.answers.growth_along import contact_slope, resonant_squares
from floquetrod.rod.model.data import RodData
from floquetrod.wells.drag import StringProperties, WellGeometry

MOST_PLACES = 2500.0  # over the ratio of the frequencies, at most: beyond some 10 s (a choice)

_TOLERANCE = 1e-6  # growth over the slower frequency from which its digits count
_RANKED, _NEAR = 0.4, 0.75  # share of the largest growth expected, and seen, at which tongues are examined (a choice)
_DENOMINATORS, _DOUBT = (144, 1000), 1e-3  # of approximants; of waves that may grow faster by more, larger ones
_SHARES = np.array([-0.5, 0.0, 0.5])  # of the half width of a tongue
_CLOSER = 0.4 * _SHARES, 0.2 * _SHARES, np.zeros(1)  # the same about the best wave, one time after the other
_STRONG = 0.15  # half width over W^2, from which tongues leave their order and waves between them are examined
_WIDE = np.linspace(0.1, 1.5, 15)  # of the wavenumber that resonates with the faster frequency
_LIMIT = 1e6  # of coefficients over the square of the slower frequency


class UncertainGrowth(NamedTuple):
    """Fastest growth in 1/s at each place, 0 where none is seen, its half wave in m, and the error of the growth."""

    rate: Floats
    half_wave: Floats
    error: Floats


class _Waves(NamedTuple):
    """Waves at places: the numbers of places and tongues, and squares of wavenumbers in 1/m^2 with a width of each."""

    place: Ints
    tongue: Ints
    square: Floats
    width: Floats


def growth_of_two_sines(
    rod: RodData,
    place: WellGeometry,
    force: Floats,
    amplitudes: tuple[Floats, Floats],
    frequencies: tuple[float, float],
) -> UncertainGrowth:
    """Return the fastest growth at places under a mean compression and two vibrations in N, without friction across.

    Frequencies in rad/s, the slower one first.  After the rod's damping rate, of all wavelengths as if force and well
    were the same around.  The error is that of the approximants and of the search among waves.
    """
    search = _Search(rod, place, force, amplitudes, frequencies)
    waves = search.likely()
    found = search.growth(waves)
    near = found.rate > _NEAR * np.maximum(search.largest(waves, found.rate), 0.0)[waves.place]
    rate, half_wave = np.zeros(force.size), np.zeros(force.size)
    highest, rates = np.zeros(force.size), [rate]
    for shares in (*_CLOSER, None):
        rate = np.maximum(rate, search.largest(waves, found.rate))
        rates.append(rate)
        np.maximum.at(highest, waves.place, found.highest)
        best = (found.rate == rate[waves.place]) & (found.rate > 0.0)
        half_wave[waves.place[best]] = math.pi / np.sqrt(waves.square[best])
        if shares is not None:
            waves = search.around(waves, found.rate, near, shares)
            found = search.growth(waves)
            near = found.rate > 0.0
    # Growth that the last two refinements add is an error of the search.
    return UncertainGrowth(rate, half_wave, np.maximum(highest - rate, 0.0) + (rate - rates[-3]))


class _Growths(NamedTuple):
    """Growth of waves in 1/s, -infinite where it is not known, and the growth that it does not exceed."""

    rate: Floats
    highest: Floats


class _Search:
    """Waves at places of a string, and their growth."""

    def __init__(
        self,
        rod: RodData,
        place: WellGeometry,
        force: Floats,
        amplitudes: tuple[Floats, Floats],
        frequencies: tuple[float, float],
    ) -> None:
        pipe = StringProperties(rod.flexural_rigidity, rod.weight_per_length, rod.radial_clearance)
        self.rigidity, self.inertia, self.damping = pipe.rigidity, rod.mass_per_length, rod.damping_rate
        self.force, self.held = force, pipe.lying(force, place) / pipe.clearance
        self.tilt = contact_slope(pipe, place, force) / pipe.clearance
        self.amplitudes, self.frequencies = amplitudes, frequencies

    def coefficients(self, place: Ints, square: Floats) -> tuple[Floats, Floats, Floats]:
        """Return beta, a_1 and a_2 of waves in 1/s^2."""
        stiff = self.rigidity * square**2 - self.force[place] * square + self.held[place]
        one, two = (size[place] * (square - self.tilt[place]) / self.inertia for size in self.amplitudes)
        return -stiff / self.inertia, one, two

    def likely(self) -> _Waves:
        """Return waves in tongues whose expected growth is near the largest of their place, and of none the softest."""
        slow, fast = self.frequencies
        every = np.arange(self.force.size)
        found, expected, is_strong = [], [], np.zeros(self.force.size, np.bool_)
        middles = 0.5 * slow, 0.5 * fast, slow, fast, 0.5 * (slow + fast), 0.5 * (fast - slow)
        for sign in (1.0, -1.0):
            for tongue, middle in enumerate(middles):
                square, exists = self._resonant(np.full(every.size, middle**2), sign)
                _, one, two = self.coefficients(every, square)
                first = one**2 / (2.0 * slow) ** 2, two**2 / (2.0 * fast) ** 2, one * two / (2.0 * slow * fast)
                half = np.abs((0.5 * one, 0.5 * two, *first, first[2])[tongue])
                shift = sum(
                    -0.125 * a**2 / w**2 if middle == 0.5 * w else 0.125 * a**2 / (middle**2 - 0.25 * w**2)
                    for a, w in ((one, slow), (two, fast))
                )
                half = np.minimum(half, 0.9 * middle**2)
                centre = middle**2 + np.clip(shift, -0.5 * middle**2, 0.5 * middle**2)
                inner, _ = self._resonant(centre, sign)
                ends = [self._resonant(np.maximum(centre + s * half, 0.01 * middle**2), sign)[0] for s in (-0.5, 0.5)]
                number = tongue + len(middles) * (sign < 0.0)
                found.append(_Waves(every, np.full(every.size, number), inner, np.abs(ends[1] - ends[0])))
                expected.append(np.where(exists, half / (2.0 * middle), 0.0))
                is_strong |= exists & (half > _STRONG * middle**2)
        growth = np.array(expected)
        chosen = (growth > 0.0) & ((growth >= _RANKED * growth.max(axis=0)) | is_strong)
        parts = [_spread(_some(waves, chosen[k]), _SHARES) for k, waves in enumerate(found)]
        top, _ = self._resonant(np.full(every.size, fast**2), 1.0)
        soft = np.maximum(0.5 * self.force / self.rigidity, 1e-3 * top)
        parts.append(_Waves(every, np.full(every.size, 2 * len(middles)), soft, 0.1 * soft))
        for k, share in enumerate(_WIDE):
            wide = _Waves(every, np.full(every.size, 2 * len(middles) + 1 + k), share**2 * top, 0.1 * share * top)
            parts.append(_some(wide, is_strong))
        return _joined(parts)

    def _resonant(self, square_of_frequency: Floats, sign: float) -> tuple[Floats, Bools]:
        """Return squares of wavenumbers whose natural frequency has a square, and whether there are such waves."""
        inertia = self.inertia * square_of_frequency
        under = self.force**2 - 4.0 * self.rigidity * (self.held - inertia)
        square = resonant_squares(self.rigidity, self.force, self.held, inertia, sign)
        return square, (under > 0.0) & (self.force + sign * np.sqrt(np.maximum(under, 0.0)) > 0.0)

    def growth(self, waves: _Waves) -> _Growths:
        """Return the growth of waves, of those that a bound lets grow: half the mean size of both waves over W."""
        slow, fast = self.frequencies
        beta, one, two = self.coefficients(waves.place, waves.square)
        stiff = np.sqrt(np.maximum(-(beta + self.damping**2), 1e-300))
        bound = np.maximum((np.abs(one) + np.abs(two)) / (math.pi * stiff) - self.damping, 0.0)
        beta, one, two = (values / slow**2 for values in (beta, one, two))
        within = (np.abs(beta) < _LIMIT) & (np.abs(one) + np.abs(two) < _LIMIT)
        rate, highest = np.where(bound > 0.0, -np.inf, 0.0), bound.copy()
        for most in _DENOMINATORS:
            doubtful = highest > (1.0 + _DOUBT) * np.maximum(self.largest(waves, rate), 0.0)[waves.place]
            chosen = np.flatnonzero(within & (bound > 0.0) & doubtful)
            if not chosen.size:
                break
            columns = zip(*(values[chosen].tolist() for values in (beta, one, two)), strict=True)
            problems = [
                TwoFrequencies(Hill(mean, (first,), damping=self.damping / slow), fast / slow, (second,))
                for mean, first, second in columns
            ]
            found = growth_of_many(problems, _TOLERANCE, most)
            known = np.isfinite(found.rate) & np.isfinite(found.error)
            rate[chosen[known]] = slow * found.rate[known]
            highest[chosen[known]] = np.minimum(slow * (found.rate + found.error)[known], bound[chosen[known]])
        return _Growths(rate, highest)

    def largest(self, waves: _Waves, rate: Floats) -> Floats:
        """Return the largest growth of each place."""
        largest = np.full(self.force.size, -np.inf)
        np.maximum.at(largest, waves.place, rate)
        return largest

    def around(self, waves: _Waves, rate: Floats, near: Bools, shares: Floats) -> _Waves:
        """Return waves about the fastest of each tongue of each place with waves ``near`` the largest growth.

        Before damping the square of growth is a parabola over a tongue: about its vertex through three waves.
        """
        key = waves.place * (1 + int(waves.tongue.max(initial=0))) + waves.tongue
        order = np.lexsort((waves.square, key))
        begins = np.flatnonzero(np.diff(key[order], prepend=-1))
        sizes = np.diff(np.append(begins, order.size))
        kept = []
        for begin, size in zip(begins.tolist(), sizes.tolist(), strict=True):
            members = order[begin : begin + size]
            if not near[members].any():
                continue
            best = int(members[np.argmax(rate[members])])
            middle, width = waves.square[best], waves.width[best]
            if size == _SHARES.size and np.isfinite(rate[members]).all():
                x, y = waves.square[members], np.square(np.maximum(rate[members] + self.damping, 0.0))
                middle = _vertex(x, y, middle)
            kept.append((waves.place[best], waves.tongue[best], middle, width))
        columns = np.array(kept).reshape(-1, 4).T
        return _spread(_Waves(columns[0].astype(np.intp), columns[1].astype(np.intp), *columns[2:]), shares)


def _vertex(x: Floats, y: Floats, best: float) -> float:
    """Return the vertex of the parabola through three points, within half of their distance of them; else the best."""
    slopes = np.diff(y) / np.maximum(np.diff(x), 1e-300)
    bend = slopes[1] - slopes[0]
    if not bend < 0.0:
        return best
    middle = 0.5 * (x[0] + x[1]) - slopes[0] * 0.5 * (x[2] - x[0]) / bend
    beyond = 0.25 * (x[2] - x[0])
    return float(np.clip(middle, max(x[0] - beyond, 0.5 * x[0]), x[2] + beyond))


def _some(waves: _Waves, chosen: Bools) -> _Waves:
    """Return some waves."""
    return _Waves(waves.place[chosen], waves.tongue[chosen], waves.square[chosen], waves.width[chosen])


def _spread(waves: _Waves, shares: Floats) -> _Waves:
    """Return for each wave several, at shares of its width from it."""
    square = waves.square[:, None] + shares * waves.width[:, None]
    square = np.maximum(square, 0.1 * waves.square[:, None]).ravel()
    size = shares.size
    return _Waves(np.repeat(waves.place, size), np.repeat(waves.tongue, size), square, np.repeat(waves.width, size))


def _joined(several: list[_Waves]) -> _Waves:
    """Return waves one after the other."""
    return _Waves(
        np.concatenate([each.place for each in several]),
        np.concatenate([each.tongue for each in several]),
        np.concatenate([each.square for each in several]),
        np.concatenate([each.width for each in several]),
    )
