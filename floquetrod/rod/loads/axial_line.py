"""The line along which axial waves travel: pieces of one impedance and one wave speed each, from the driven end down.

In each piece the vibrating force P and the velocity of the rod along its axis obey

    dP / dtau = Z nu V,    dV / dtau = -nu P / Z,    nu^2 = omega^2 - 2 i c_a omega,

tau the time of travel from the driven end, Z = A sqrt(E rho) the impedance; the velocity is V times a factor, the same
all along.  Both are continuous, so that where Z_1 meets Z_2 the share (Z_2 - Z_1) / (Z_2 + Z_1) of a wave of force is
reflected.  With waves down and up, P = D exp(-i nu tau) (1 + G exp(-2 i nu (T - tau))) in a piece of the time of
travel T; G follows from the far end upwards, D from the driven end downwards.

Without damping the angle theta of P = r sin(theta), Z V = r cos(theta), measured from the far end upwards, increases
with the frequency (H. Pruefer, Math. Ann. 95 (1926) 499, DOI 10.1007/BF01206624): the n-th resonance is where it comes
to n pi at the driven end, and none is missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.roots import bisected, largest, roots
from floquetrod.rod.loads.load import RESONANT, AxialWave, Load, resonates

_SAMPLES = 33  # of frequencies between resonances, among which the force is examined (a choice)
_SUMMIT = 0.05  # of the largest force allowed, above which a summit between resonances is examined (a choice)
_SECTIONS = 40  # of such a summit: to 4e-9 of the distance of samples
_HALVINGS = 60  # to rounding
_ULPS = 4.0  # for each piece, by which the ends of what is refused are moved out (rounding of the angle)


class LinePiece(NamedTuple):
    """A piece of a line: length in m, speed of axial waves in m/s, and impedance Z = A sqrt(E rho) in N s/m."""

    length: float
    wave_speed: float
    impedance: float


@dataclass(frozen=True)
class AxialLine:
    """The rod as axial waves see it; neighbours of one wave speed and impedance are one piece.

    Attributes
    ----------
    pieces : tuple of LinePiece
        From the driven end down.
    """

    pieces: tuple[LinePiece, ...]

    def __post_init__(self) -> None:
        """Join like neighbours."""
        joined: list[LinePiece] = []
        for piece in self.pieces:
            if joined and joined[-1][1:] == piece[1:]:
                piece = piece._replace(length=joined.pop().length + piece.length)
            joined.append(piece)
        object.__setattr__(self, "pieces", tuple(joined))

    @property
    def is_uniform(self) -> bool:
        """Whether it has one piece."""
        return len(self.pieces) == 1

    @cached_property
    def length(self) -> float:
        """Of the line in m."""
        return sum(piece.length for piece in self.pieces)

    @cached_property
    def wave_speed(self) -> float:
        """Length over the time of travel, in m/s."""
        return self.pieces[0].wave_speed if self.is_uniform else self.length / float(self._times.sum())

    @property
    def slowest(self) -> float:
        """The least wave speed in m/s."""
        return min(piece.wave_speed for piece in self.pieces)

    @property
    def unit(self) -> float:
        """Frequency in rad/s at which a wave turns by one radian along the line, one over the time of travel."""
        return self.wave_speed / self.length

    @cached_property
    def edges(self) -> Floats:
        """Distance in m from the driven end to the upper ends of all pieces, and to the far end."""
        return np.append(0.0, np.cumsum([piece.length for piece in self.pieces]))

    def profile(self, load: Load, s: Floats, frequency: float) -> NDArray[Any]:
        """Return the vibration of unit amplitude at places s in m from the driven end, (len(s),).

        Real without axial damping.  ValueError at a resonance without axial damping.
        """
        if self.is_uniform or not isinstance(load, AxialWave):
            return load.profile(self.wave_speed, self.length, s, frequency)
        if self.is_near_pole(load, frequency):
            raise resonates(load, frequency, self.length)
        found = self._force(load.far_end, _complex_frequency(load, frequency), s)
        return np.asarray(found.real if load.axial_damping == 0.0 else found)

    def largest(self, load: AxialWave, frequency: Floats) -> Floats:
        """Return the largest force along the line over that at the driven end at frequencies, without axial damping.

        Infinite at a resonance, and where rounding leaves too few digits.
        """
        return self._largest(load.far_end, frequency.astype(complex))

    def is_near_pole(self, load: AxialWave, frequency: float) -> bool:
        """Return whether a line of several pieces is so near a resonance that rounding leaves too few digits."""
        nu = np.array([_complex_frequency(load, frequency)])
        return not self.is_uniform and not self._largest(load.far_end, nu)[0] < 1.0 / RESONANT

    def refused(
        self, load: AxialWave, bounds: tuple[float, float], most: float, room: float
    ) -> list[tuple[float, float, float]]:
        """Return where the force would be more than ``most`` times that at the driven end, without axial damping.

        Ends and resonance in rad/s, in increasing order; ends of a uniform line may lie outside the bounds.  ``room``
        is added to each, as a fraction of it.
        """
        if not self.is_uniform:
            return self._refused(load, bounds, most, room)
        first, step = load.resonant_phases
        half = (1.0 + room) * math.asin(1.0 / most) * step / math.pi
        least = max(0, math.ceil((bounds[0] / self.unit - half - first) / step))
        last = math.floor((bounds[1] / self.unit + half - first) / step)
        phases = [first + n * step for n in range(least, last + 1)]
        return [((phase - half) * self.unit, (phase + half) * self.unit, phase * self.unit) for phase in phases]

    def _refused(
        self, load: AxialWave, bounds: tuple[float, float], most: float, room: float
    ) -> list[tuple[float, float, float]]:
        """Return `refused` of several pieces: where the force passes ``most`` between resonances, bisected."""
        low, high = bounds
        numbers = np.arange(max(0, self.passed(load, low) - 1), self.passed(load, high) + 1)
        resonances = self.resonances(load, numbers)

        def size(frequency: Floats) -> Floats:
            return np.where(np.isin(frequency, resonances), math.inf, self.largest(load, frequency))

        if low == high:
            near = float(resonances[np.argmin(np.abs(resonances - low))])
            return [(low, high, near)] if size(np.array([low]))[0] > most else []
        x = _between(np.unique([low, *resonances[(resonances > low) & (resonances < high)], high]))
        x = np.unique(np.append(x, _summits(size, x, most)))
        beyond = size(x) > most
        at = np.flatnonzero(beyond[1:] != beyond[:-1])
        inside, outside = (np.where(beyond[at] == is_beyond, x[at], x[at + 1]) for is_beyond in (True, False))
        ends, _ = bisected(lambda frequency: size(frequency) <= most, outside, inside, _HALVINGS)
        cuts = np.concatenate([[low] * bool(beyond[0]), ends, [high] * bool(beyond[-1])]).reshape(-1, 2)
        spans = []
        for start, end in cuts.tolist():
            within = resonances[(resonances >= start) & (resonances <= end)]
            near = within[0] if within.size else resonances[np.argmin(np.abs(resonances - 0.5 * (start + end)))]
            wider = room * (end - start) + _ULPS * len(self.pieces) * float(np.spacing(end))
            spans.append((start - wider, end + wider, float(near)))
        return spans

    def places_of_largest(self, frequency: float) -> Floats:
        """Return the ends in m of stretches in which the largest force of one frequency lies, (n, 2).

        Of a uniform line the half wave at the driven end.  In each of several pieces, with nu = a - i b, |D exp(-i nu
        tau) + U exp(i nu tau)|^2 is a multiple of cosh(2 b tau + e) + cos(2 a tau + f): half a wave nearer to one of
        its ends the force is as large or larger.
        """
        if self.is_uniform:
            return np.array([[0.0, min(self.length, math.pi * self.wave_speed / frequency)]])
        speed = np.array([piece.wave_speed for piece in self.pieces])
        near = np.minimum(np.diff(self.edges), math.pi * speed / frequency)
        upper, lower = self.edges[:-1], self.edges[1:]
        return np.concatenate([np.stack([upper, upper + near], axis=1), np.stack([lower - near, lower], axis=1)])

    # --- resonances without damping, numbered from 0 ---

    def resonances(self, load: AxialWave, numbers: Ints) -> Floats:
        """Return frequencies in rad/s at which the force along the line is infinite without axial damping."""
        if self.is_uniform:
            first, step = load.resonant_phases
            return np.asarray((first + numbers * step) * self.unit)
        line, far_end = self._excited(load.far_end)
        target, room = (numbers + 1) * math.pi, 0.5 * math.pi * (len(line.pieces) - 1)
        phase = target - (0.5 * math.pi if far_end == "held" else 0.0)
        low, high = (np.maximum(0.0, phase + side * (1e-9 + room)) / float(line._times.sum()) for side in (-1.0, 1.0))

        def beyond(frequency: Floats, i: Ints) -> Floats:
            return line._angle(far_end, frequency) - target[i]

        every = np.arange(len(numbers))
        return roots(beyond, low, high, beyond(low, every), beyond(high, every))

    def passed(self, load: AxialWave, frequency: float) -> int:
        """Return how many resonances are at most so high, in rad/s."""
        if self.is_uniform:
            first, step = load.resonant_phases
            return max(0, math.floor((frequency / self.unit - first) / step) + 1)
        line, far_end = self._excited(load.far_end)
        return math.floor(float(line._angle(far_end, np.array([frequency]))[0]) / math.pi)

    def _excited(self, far_end: str) -> tuple[AxialLine, str]:
        """Return the line, and what its far end is, whose resonances under a force at its upper end are these."""
        if far_end != "driven":
            return self, far_end
        return (self._upper_half, "held") if self._is_symmetric else (self, "free")

    def _angle(self, far_end: str, frequency: Floats) -> Floats:
        """Return the angle theta at the driven end without damping."""
        angle = np.full(frequency.shape, 0.5 * math.pi if far_end == "held" else 0.0)
        for i in reversed(range(len(self.pieces))):
            angle = angle + frequency * self._times[i]
            if i:
                ratio = self.pieces[i - 1].impedance / self.pieces[i].impedance
                sin, cos = np.sin(angle), np.cos(angle)
                angle = angle + np.arctan2((1.0 - ratio) * sin * cos, ratio * cos**2 + sin**2)
        return angle

    # --- waves ---

    @cached_property
    def _times(self) -> Floats:
        """Times of travel in s along the pieces."""
        return np.array([piece.length / piece.wave_speed for piece in self.pieces])

    @cached_property
    def _mirrored(self) -> AxialLine:
        return AxialLine(self.pieces[::-1])

    @cached_property
    def _is_symmetric(self) -> bool:
        return self.pieces == self.pieces[::-1]

    @cached_property
    def _upper_half(self) -> AxialLine:
        """The upper half of a symmetric line."""
        middle = len(self.pieces) // 2
        half = self.pieces[middle]._replace(length=0.5 * self.pieces[middle].length)
        return AxialLine((*self.pieces[:middle], half))

    def _force(self, far_end: str, nu: complex, s: Floats) -> NDArray[np.complex128]:
        """Return P at places for 1 at the driven end."""
        if far_end == "driven":
            if self._is_symmetric:
                return self._upper_half._force("held", nu, np.minimum(s, self.length - s))
            return self._force("free", nu, s) + self._mirrored._force("free", nu, self.length - s)
        down, gain = (part[:, 0] for part in self._waves(far_end, np.array([nu])))
        i = np.searchsorted(self.edges[1:-1], s, side="right")
        speed = np.array([piece.wave_speed for piece in self.pieces])[i]
        since, left = (s - self.edges[i]) / speed, (self.edges[i + 1] - s) / speed
        # 1 + G exp(-2 i nu left), which keeps its digits where the piece is short against the wave
        both = gain[i] * np.exp(-2j * nu * left) - np.expm1(-2j * nu * left)
        return np.asarray(down[i] * np.exp(-1j * nu * since) * both)

    def _waves(self, far_end: str, nu: NDArray[np.complex128]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return D and 1 + G of each piece for P = 1 at the driven end, the far end held or free, (n, len(nu))."""
        phase = self._times[:, None] * nu
        decay, lost = np.exp(-1j * phase), -np.expm1(-2j * phase)
        gain, share = np.empty_like(decay), np.empty_like(decay)
        here = np.full(nu.shape, 2.0 if far_end == "held" else 0.0, dtype=complex)
        for i in reversed(range(len(self.pieces))):
            gain[i] = here
            above = here * decay[i] ** 2 + lost[i]  # P over D at the upper end of the piece
            if i:
                back = self._reflected(i)
                meeting = 1.0 + back * (above - 1.0)
                share[i], here = (1.0 + back) / meeting, (1.0 + back) * above / meeting
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            share[0] = 1.0 / above
            return np.cumprod(np.concatenate([share[:1], share[1:] * decay[:-1]]), axis=0), gain

    def _reflected(self, i: int) -> float:
        """Return the share of a wave of force that the upper end of piece i reflects."""
        upper, lower = self.pieces[i - 1].impedance, self.pieces[i].impedance
        return (lower - upper) / (lower + upper)

    def _largest(self, far_end: str, nu: NDArray[np.complex128]) -> Floats:
        """Return the largest |P| along the line for 1 at the driven end; decay within a piece neglected."""
        phase = self._times[:, None] * nu
        if far_end == "driven":
            if self._is_symmetric:
                return self._upper_half._largest("held", nu)
            parts = self._amplitudes("free", phase, nu), self._mirrored._amplitudes("free", phase[::-1], nu)
            most = np.max([_most(*part, each) for part, each in zip(parts, (phase, phase[::-1]), strict=True)], axis=0)
            down, up = parts[0][0] + parts[1][1][::-1], parts[0][1] + parts[1][0][::-1]
            # Of two terms that all but cancel rounding would leave too few digits.
            return np.where(most < 1.0 / RESONANT, _most(down, up, phase), math.inf)
        return _most(*self._amplitudes(far_end, phase, nu), phase)

    def _amplitudes(self, far_end: str, phase: NDArray[Any], nu: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the waves down at the upper end and up at the lower end of each piece, (n, len(nu))."""
        down, gain = self._waves(far_end, nu)
        with np.errstate(invalid="ignore", over="ignore"):
            return down, down * np.exp(-1j * phase) * (gain - 1.0)


def _most(down: NDArray[Any], up: NDArray[Any], phase: NDArray[Any]) -> Floats:
    """Return the largest |D exp(-i nu tau) + U exp(-i nu (T - tau))| in any piece, (n, m) to (m,)."""
    with np.errstate(invalid="ignore", over="ignore"):
        decay = np.exp(-1j * phase)
        ends = np.maximum(np.abs(down + up * decay), np.abs(down * decay + up))
        first = np.mod(np.angle(down) - np.angle(up) + phase.real, 2.0 * math.pi)  # where both have one phase
        size = np.where(first <= 2.0 * phase.real, np.abs(down) + np.abs(up), ends).max(axis=0)
    return np.where(np.isfinite(size), size, math.inf)


def _complex_frequency(load: AxialWave, frequency: float) -> complex:
    """Return nu = sqrt(omega^2 - 2 i c_a omega)."""
    return complex(np.sqrt(complex(frequency * frequency, -2.0 * load.axial_damping * frequency)))


def _between(ends: Floats) -> Floats:
    """Return places from the first end to the last, so many from each to the next."""
    shares = np.linspace(0.0, 1.0, _SAMPLES)
    return np.append((ends[:-1, None] + np.diff(ends)[:, None] * shares[:-1]).ravel(), ends[-1])


def _summits(size: Callable[[Floats], Floats], x: Floats, most: float) -> Floats:
    """Return places between samples at which a function that is at most so large at its samples is larger."""
    sizes = size(x)
    middle = sizes[1:-1]
    is_high = (middle >= sizes[:-2]) & (middle >= sizes[2:]) & (middle > _SUMMIT * most) & (middle <= most)
    i = 1 + np.flatnonzero(is_high)
    places, values = largest(lambda at, _: size(at), x[i - 1], x[i + 1], _SECTIONS)
    return places[values > most]
