"""What axial waves make of a force along a rod: the largest, where it is, and the resonances it comes from."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.interchange import by_keys
from floquetrod.rod.loads.axial_line import AxialLine
from floquetrod.rod.loads.load import AxialWave, Load

MOST_FACTOR = 100.0
"""Largest force along the rod over that at the driven end for which a wave without axial damping is judged (a choice).

Next to a resonance that factor is one over the distance from it, in radians of omega L / c_0.  Above 100 an error of
0.01 in that phase, two thirds of a percent of the wave speed at the first resonance, decides the force; and so would a
damping of half a percent of the critical one, which this load lacks: it limits the factor there to about 100.
"""

_MOST_RESONANCES = 1000  # between bounds of a search: it could not resolve more
_ROOM = 1e-6  # beside what is refused, far above rounding
_SAMPLES = 129  # of half a wave, and again between neighbours of the largest (a choice)
_LEAST_DECAY = 1e-5  # of a wave along the rod: with less, the force at resonance is infinite for all that matters
_FINE = 32  # samples of the shortest wave and period, where several harmonics meet (half a percent)


class AxialResonanceError(ValueError):
    """A load's frequency is so near an axial resonance that there is no verdict."""


class AxialResonance(NamedTuple):
    """A frequency of the load at which it, or a harmonic of it, resonates with axial waves of the rod.

    Attributes
    ----------
    frequency : float
        Of the load, in rad/s.
    harmonic : int
        The harmonic of the load that resonates: 1 for the load's own frequency.
    factor : float
        Largest force of this harmonic along the rod over that at the driven end, there; infinite without axial damping.
    """

    frequency: float
    harmonic: int
    factor: float

    @property
    def hertz(self) -> float:
        """The frequency in Hz."""
        return self.frequency / (2.0 * math.pi)

    def __str__(self) -> str:
        """Return the frequency in rad/s and Hz, and the harmonic."""
        of = f" of harmonic {self.harmonic}" if self.harmonic > 1 else ""
        return f"{self.frequency:.6g} rad/s ({self.hertz:.4g} Hz){of}"


@dataclass(frozen=True, repr=False)
class AxialResponse:
    """How large a load's vibration becomes along a rod, by axial waves, without the mean force.

    Attributes
    ----------
    amplitude : float
        Largest vibration in N at the driven end: the amplitude of a sine.
    largest : float
        Largest vibration in N along the rod; with several harmonics accurate to half a percent.  Infinite next to a
        resonance without axial damping, where ``factor`` would exceed 100.
    position : float
        Position of the largest, in m from the upper end; of equal ones the nearest to it, NaN where it is infinite.
    factor : float
        ``largest`` over ``amplitude``, also where both are zero.
    critical_forces : float
        ``largest`` over the rod's critical force.
    resonances : tuple of AxialResonance
        The nearest below and above the load's frequency, harmonics counted; where ``largest`` is infinite the one that
        makes it so; empty for a force uniform along the rod.
    section : int or None
        Number of the section at ``position``, from the upper end, from 0; None for a rod of one section.
    """

    amplitude: float
    largest: float
    position: float
    factor: float
    critical_forces: float
    resonances: tuple[AxialResonance, ...]
    section: int | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers for JSON, in SI units; None where one is infinite or unknown.

        Returns
        -------
        dict of str
            Among them ``resonances``, a list with a dict for each.
        """
        resonances = [by_keys(r, "frequency_rad_per_s frequency_Hz=hertz harmonic factor") for r in self.resonances]
        numbers = by_keys(self, "amplitude_N largest_N position_m factor critical_forces") | {"resonances": resonances}
        return numbers if self.section is None else numbers | {"section": self.section}

    @property
    def in_words(self) -> str:
        """The largest vibration in newtons and critical forces, where it is, and the nearest resonances, in words."""
        if math.isinf(self.factor):
            return f"vibration of {self.amplitude:.4g} N at the axial resonance {self.resonances[0]}, undamped"
        names = " and ".join(map(str, self.resonances))
        nearest = f"; axial resonance{'s' * (len(self.resonances) > 1)} nearby: {names}" if names else ""
        return (
            f"vibration of {self.amplitude:.4g} N becomes {self.largest:.4g} N, {self.factor:.3g} times as much and "
            f"{self.critical_forces:.3g} critical forces, at {self.position:.4g} m{self.in_section}{nearest}"
        )

    @property
    def in_section(self) -> str:
        """The section at ``position`` in words, "" for a rod of one section."""
        return "" if self.section is None else f", in section {self.section + 1}"

    def __repr__(self) -> str:
        """Return the numbers as a sentence."""
        return f"<{self.in_words}>"


class AxialGap(NamedTuple):
    """Frequencies of a load, in rad/s, without a verdict: a wave without axial damping is too near a resonance."""

    low: float
    high: float
    resonance: AxialResonance


def wave_ratio(rod: Any, load: Load) -> float:
    """Return omega L / (2 pi c_0), the rod's length in axial waves; far below 1 the force is uniform along the rod."""
    return float(load.frequency * rod.length / (2.0 * math.pi) / rod.wave_speed)


def axial_response(load: Load, line: AxialLine, critical_force: float) -> AxialResponse:
    """Return what `Rod.axial_response` does."""
    if not isinstance(load, AxialWave):
        largest = load.amplitude * _over_a_period(load.harmonics[:, None])[0] + _of_second(load)
        return AxialResponse(largest, largest, 0.0, 1.0, largest / critical_force, ())
    amplitude = load.amplitude * float(_over_a_period(load.harmonics[:, None])[0])
    near = gaps(load, line, (load.frequency, load.frequency), 0.0)
    if near:
        return AxialResponse(amplitude, math.inf, math.nan, math.inf, math.inf, (near[0].resonance,))
    nearest = tuple(_nearest(load, line))
    factor, position = _largest(load, line)
    largest = factor * amplitude
    return AxialResponse(amplitude, largest, position, factor, largest / critical_force, nearest)


def along(load: Load, line: AxialLine, s: NDArray[np.float64], frequency: float) -> NDArray[Any]:
    """Return the vibration of every harmonic along the rod for an amplitude of one newton, complex (H, len(s))."""
    return np.array(
        [
            h * line.profile(load, s, k * frequency) if h else np.zeros(s.size)
            for k, h in enumerate(load.harmonics.tolist(), start=1)
        ]
    )


def largest_along(load: Load, line: AxialLine, s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest size over a period of the vibration at places along the rod, in N."""
    return load.amplitude * _over_a_period(along(load, line, s, load.frequency)) + _of_second(load)


def _of_second(load: Load) -> float:
    """Return the amplitude in N of a second sine, 0 without one: sometime the two push together."""
    return 0.0 if load.second is None else load.second[0]


def bound(load: Load, line: AxialLine, frequency: float) -> float:
    """Return the largest force along the rod for an amplitude of one newton if harmonics met in phase."""
    if load.is_uniform:
        return float(np.abs(load.harmonics).sum())
    sizes = np.abs(load.harmonics).tolist()
    return math.fsum(sizes[k - 1] * _factor(load, line, k * frequency)[0] for k in _present(load))


def require_off_resonance(load: Load, line: AxialLine, frequency: float) -> None:
    """Raise AxialResonanceError for a frequency next to an axial resonance, without axial damping."""
    gap = next(iter(gaps(load, line, (frequency, frequency), 0.0)), None)
    if gap is not None:
        near = gap.resonance
        at = f"the axial resonance of the rod at {near.harmonic * near.frequency:.6g} rad/s"
        where = f"is where harmonic {near.harmonic} of the load meets {at}" if near.harmonic > 1 else f"is at {at}"
        damping = Mention("axial_damping")
        raise wrong_value(
            "frequency",
            f"{frequency:.9g} rad/s ({frequency / (2.0 * math.pi):.6g} Hz) {where}, far end "
            f"{getattr(load, 'far_end', '')}: without ",
            damping,
            f" the force along its {line.length:g} m would be more than {MOST_FACTOR:g} times that at the driven end; ",
            "give ",
            damping,
            ", or another frequency",
            kind=AxialResonanceError,
        )


def gaps(load: Load, line: AxialLine, bounds: tuple[float, float], room: float = _ROOM) -> list[AxialGap]:
    """Return the frequencies within bounds at which `require_off_resonance` raises, in increasing order, apart.

    ``room`` is added to each, as a fraction of it, so that the ends are answered to rounding.
    """
    if not isinstance(load, AxialWave) or load.axial_damping > 0.0:
        return []
    all_gaps = []
    for k in _present(load):
        within = k * bounds[0], k * bounds[1]
        number = line.passed(load, within[1]) - line.passed(load, within[0])
        if number > _MOST_RESONANCES:
            raise wrong_value(
                "bounds",
                f"hold {number} axial resonances of harmonic {k}, of which at most {_MOST_RESONANCES} "
                "can be left out: give narrower bounds, or ",
                Mention("axial_damping"),
            )
        for low, high, frequency in line.refused(load, within, MOST_FACTOR, room):
            resonance = AxialResonance(frequency / k, k, math.inf)
            all_gaps.append(AxialGap(max(low / k, bounds[0]), min(high / k, bounds[1]), resonance))
    return joined(all_gaps)


def joined(found: Iterable[AxialGap]) -> list[AxialGap]:
    """Return gaps in increasing order, those that meet as one, named after the lower one's resonance."""
    apart: list[AxialGap] = []
    for gap in sorted(found):
        if apart and gap.low <= apart[-1].high:
            apart[-1] = apart[-1]._replace(high=max(apart[-1].high, gap.high))
        else:
            apart.append(gap)
    return apart


def _present(load: Load) -> list[int]:
    """Return the numbers h of the harmonics present, c_h != 0."""
    return (1 + np.flatnonzero(load.harmonics)).tolist()


def _nearest(load: AxialWave, line: AxialLine) -> Iterator[AxialResonance]:
    """Yield the nearest resonance not above the load's frequency, if any, and the nearest above it.

    Where a whole number of waves fits the rod, Re kappa = w_n / c_0: with axial damping at w_n^2 / sqrt(w_n^2 + c_a^2).
    """
    damping = load.axial_damping
    below: list[tuple[float, int]] = []
    above: list[tuple[float, int]] = []
    for k in _present(load):
        square = (k * load.frequency) ** 2
        natural = math.sqrt(0.5 * (square + math.sqrt(square * (square + 4.0 * damping**2))))
        passed = line.passed(load, natural)
        numbers = np.arange(max(0, passed - 1), passed + 1)
        for n, at in zip(numbers.tolist(), line.resonances(load, numbers).tolist(), strict=True):
            frequency = at / k / math.sqrt(1.0 + (damping / at) ** 2)
            (below if n < passed else above).append((frequency, k))
    for frequency, k in (*([max(below, key=lambda r: (r[0], -r[1]))] if below else ()), min(above)):
        is_finite = damping > _LEAST_DECAY * line.unit and not line.is_near_pole(load, k * frequency)
        factor = _factor(load, line, k * frequency)[0] if is_finite else math.inf
        yield AxialResonance(frequency, k, factor)


def _largest(load: AxialWave, line: AxialLine) -> tuple[float, float]:
    """Return the largest force along the rod over that at the driven end, and its position."""
    present = _present(load)
    if len(present) == 1:
        return _factor(load, line, present[0] * load.frequency)
    waves = load.frequency * present[-1] * line.length / (2.0 * math.pi * line.slowest)
    most = 16 * _SAMPLES * len(line.pieces)
    s = np.union1d(np.linspace(0.0, line.length, 2 * _SAMPLES + min(math.ceil(_FINE * waves), most)), line.edges)

    def size(places: NDArray[np.float64]) -> NDArray[np.float64]:
        return _over_a_period(along(load, line, places, load.frequency))

    largest, position = _peak(size, s)
    return largest / float(size(np.zeros(1))[0]), position


def _factor(load: Load, line: AxialLine, frequency: float) -> tuple[float, float]:
    """Return the largest force of one harmonic over that at the driven end, and its position.

    |cos(a + i b)|^2 = (cos 2a + cosh 2b) / 2, and sines alike: half a wave nearer to the driven end the force is as
    large or larger, so that the largest lies within half a wave of that end; of several pieces near any of their ends.
    """
    stretches = line.places_of_largest(frequency)
    places = np.linspace(stretches[:, 0], stretches[:, 1], _SAMPLES, axis=1).ravel()
    if not line.is_uniform:
        places = np.unique(places)
    return _peak(lambda s: np.abs(line.profile(load, s, frequency)), places)


def _peak(size: Any, s: NDArray[np.float64]) -> tuple[float, float]:
    """Return the largest of sizes at places, sampled ever closer, and where; of equal ones the first."""
    value, place = -math.inf, 0.0
    for _ in range(3):
        sizes = size(s)
        at = int(np.argmax(sizes >= sizes.max() * (1.0 - 1e-9)))
        if sizes[at] > value:
            value, place = float(sizes.max()), float(s[at])
        s = np.linspace(s[max(at - 1, 0)], s[min(at + 1, s.size - 1)], _SAMPLES)
    return value, place


def _over_a_period(harmonics: NDArray[Any]) -> NDArray[np.float64]:
    """Return the largest size over a period of sums of harmonics, (H, n) to (n,)."""
    number = len(harmonics)
    if np.count_nonzero(np.any(harmonics != 0.0, axis=1)) <= 1:
        return np.asarray(np.abs(harmonics).max(axis=0))
    spectrum = np.zeros((number + 1, harmonics.shape[1]), dtype=complex)
    spectrum[1:] = 0.5 * harmonics
    times = _FINE * number
    step = max(1, (1 << 20) // times)
    parts = [spectrum[:, i : i + step] for i in range(0, spectrum.shape[1], step)]
    return np.concatenate([np.abs(np.fft.irfft(part, times, axis=0, norm="forward")).max(axis=0) for part in parts])
