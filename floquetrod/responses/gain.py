"""`fr.gain`: the spectrum of a signal and its idlers over a range of frequencies, refined where it bends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Report, Reported, Table, number
from floquetrod.equations import Equation
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.problems import Problem, require_problem
from floquetrod.floquet.references import references
from floquetrod.responses.forces import force_of
from floquetrod.responses.harmonic_balance import balanced
from floquetrod.responses.hill_arrays import HillArrays, hill_arrays
from floquetrod.responses.methods import BY_NAME, sources

_FIRST = 65  # frequencies at first (a choice)
_BEND = 0.02  # part of the largest gain by which a curve may leave its chord (a choice)
_MOST = 4000  # frequencies (a choice)
_ROUNDS = 30
_IDLERS = (-2, -1, 0, 1)
_MOST_WAVES = 64


class Slowest(NamedTuple):
    """The Floquet solution that a peak comes from: its decay rate and its frequency nearest to the peak."""

    decay_rate: float
    frequency: float


@dataclass(frozen=True, eq=False, repr=False)
class Gain(ByContent, NoTruthValue, Reported):
    """Amplitudes of the waves exp(i (w + 2 pi k / T) t) for a force exp(i w t) of amplitude one, over frequencies w.

    Attributes
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem.
    force_at : int
        The coordinate that the force acts on, from 0.
    response_of : int
        The coordinate whose waves are given, from 0.
    frequency : ndarray (m,)
        w, in radians per unit of time, increasing; closer together where the spectrum bends.
    waves : tuple of int
        k: 0 is the signal, others are idlers.
    amplitudes : ndarray (m, waves)
        Complex harmonic transfer functions.
    error : ndarray (m,)
        Estimate of the error of each row as a fraction of the largest amplitude of the coordinate.
    """

    ask = ".peak or .amplitudes"

    equation: Problem
    force_at: int
    response_of: int
    frequency: Floats
    waves: tuple[int, ...]
    amplitudes: Complexes
    error: Floats

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the method."""
        return references(sources(self.equation, "hill"))

    def of(self, wave: int = 0) -> Floats:
        """Return the magnitudes (m,) of a wave.

        Parameters
        ----------
        wave : int
            k, one of ``waves``: 0 for the signal, -1 for the first idler.

        Returns
        -------
        ndarray
            (m,), in the order of the frequencies.

        Raises
        ------
        TypeError, ValueError
            For a wave that was not computed.
        """
        chosen = validate.integer("wave", wave, -_MOST_WAVES, _MOST_WAVES)
        if chosen not in self.waves:
            raise ValueError(f"wave must be one of {', '.join(map(str, self.waves))}, got {chosen}")
        return np.abs(self.amplitudes[:, self.waves.index(chosen)])

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Frequency and magnitude of the signal at its largest, between the frequencies too."""
        from scipy.optimize import minimize_scalar

        signal = self.of(0)
        i = int(signal.argmax())
        low, high = self.frequency[max(i - 1, 0)], self.frequency[min(i + 1, len(signal) - 1)]
        found = minimize_scalar(
            lambda w: -self._signal(w), bounds=(float(low), float(high)), method="bounded", options={"xatol": 1e-10}
        )
        if -found.fun >= signal[i]:
            return float(found.x), float(-found.fun)
        return float(self.frequency[i]), float(signal[i])

    def _signal(self, frequency: float) -> float:
        """Return the magnitude of the signal at one frequency."""
        force = np.zeros((1, 1, self._arrays.mass.shape[-1]), dtype=complex)
        force[0, 0, self.force_at] = 1.0
        values, _ = balanced(self._arrays, force, np.array([frequency]))
        return float(abs(values[0, values.shape[1] // 2, self.response_of]))

    @cached_property
    def _arrays(self) -> HillArrays:
        """The coefficients for Hill's matrix."""
        return hill_arrays(self.equation)

    @cached_property
    def width(self) -> float:
        """Width of the peak where the signal is 1 / sqrt(2) of it, NaN where the range does not contain it."""
        where, top = self.peak
        signal, half = self.of(0), top / math.sqrt(2.0)
        below = np.flatnonzero((self.frequency < where) & (signal < half))
        above = np.flatnonzero((self.frequency > where) & (signal < half))
        if not (len(below) and len(above)):
            return math.nan
        from scipy.optimize import brentq

        pairs = ((self.frequency[below[-1]], where), (where, self.frequency[above[0]]))
        low, high = (brentq(lambda w: self._signal(w) - half, *pair, xtol=1e-13, rtol=1e-12) for pair in pairs)
        return float(high - low)

    @cached_property
    def slowest(self) -> Slowest:
        """Decay rate of the slowest free motion, and its frequency nearest to the peak.

        At the threshold of instability the rate goes to 0, the peak's height grows as its inverse, and its width, of an
        isolated peak, goes to twice the rate.
        """
        period = float(self.equation.period)
        exponent = max(stability(self.equation).exponents, key=lambda e: e.real)
        turn, where = 2.0 * math.pi / period, self.peak[0]
        candidates = [
            sign * exponent.imag + turn * round((where - sign * exponent.imag) / turn) for sign in (1.0, -1.0)
        ]
        return Slowest(-exponent.real, min(candidates, key=lambda w: abs(w - where)))

    def plot(self, ax: Any = None) -> Any:
        """Draw the magnitudes of signal and idlers over frequency, on ``ax`` or on new axes.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Examples
        --------
        >>> import floquetrod as fr
        >>> amplifier = fr.HillSystem([[1.0]], sines=[[[0.03]]], damping=[[0.02]], period=3.141592653589793)
        >>> fr.gain(amplifier, frequency=(0.9, 1.1)).plot().get_yscale()
        'log'
        """
        from floquetrod.plotting.response_plot import draw_gain

        return draw_gain(self, ax)

    def report(self) -> Report:
        """Return the peak, its width, what it tends to, and a table of waves at the peak."""
        where, top = self.peak
        rate, frequency = self.slowest
        i = int(self.of(0).argmax())
        width = "wider than the range" if math.isnan(self.width) else f"{self.width:.6g}"
        lines = [
            ("equation", repr(self.equation)),
            ("width", f"{width} at 1 / sqrt(2) of the peak"),
            ("decay", f"{rate:.6g} per unit of time of the slowest free motion, at the frequency {frequency:.6g}"),
            (
                "error",
                f"at most {float(self.error.max()):.1g} of the largest amplitude, {len(self.frequency)} frequencies",
            ),
        ]
        rows = [[str(k), f"{abs(self.amplitudes[i, j]):.6g}"] for j, k in enumerate(self.waves)]
        table = Table([("wave k", ">"), (f"at {self.frequency[i]:.6g}", ">")], rows)
        return Report(f"peak {top:.6g} at {where:.6g}", lines, table)

    def as_dict(self) -> dict[str, Any]:
        """Return the spectrum as numbers for JSON; None for infinite or unknown ones."""
        return {
            "force_at": self.force_at,
            "response_of": self.response_of,
            "peak_frequency": self.peak[0],
            "peak": self.peak[1],
            "width": number(self.width),
            "decay_rate": self.slowest.decay_rate,
            "frequency": self.frequency.tolist(),
            **{f"wave_{k}": np.abs(self.amplitudes[:, j]).tolist() for j, k in enumerate(self.waves)},
            "error": self.error.tolist(),
        }

    def __repr__(self) -> str:
        """Return the peak as a sentence."""
        return f"<gain: peak {self.peak[1]:.6g} at {self.peak[0]:.6g}, {len(self.frequency)} frequencies>"


def gain(equation: Problem, at: int = 0, out: int | None = None, *, frequency: Any, waves: Any = _IDLERS) -> Gain:
    """Return the spectrum of the signal and its idlers under a force of amplitude one, over a range of frequencies.

    Parameters
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        A stable problem whose coefficients are Fourier series.
    at : int
        The coordinate that the force exp(i w t) acts on, from 0.
    out : int, optional
        The coordinate whose waves are returned, from 0; by default the same.
    frequency : (float, float) or array_like (m,)
        The range of w, in radians per unit of time, in which frequencies are added until all waves bend by no more than
        2 % of the peak between two; or the frequencies themselves, three at least, increasing.
    waves : sequence of int
        k of the waves exp(i (w + 2 pi k / T) t) to return.

    Returns
    -------
    Gain

    Raises
    ------
    TypeError, ValueError
        For coordinates and frequencies that do not fit, for coefficients with jumps, for unstable problems, and for a
        frequency on a resonance.

    Examples
    --------
    >>> import floquetrod as fr
    >>> amplifier = fr.HillSystem([[1.0]], sines=[[[0.03]]], damping=[[0.02]], period=3.141592653589793)
    >>> spectrum = fr.gain(amplifier, frequency=(0.9, 1.1))
    >>> f"{spectrum.peak[1]:.3f} at {spectrum.peak[0]:.5f}", round(spectrum.slowest.decay_rate, 5)
    ('114.281 at 0.99999', 0.0025)
    """
    require_problem(equation)
    n = 1 if isinstance(equation, Equation) else equation.order
    source = validate.integer("at", at, 0, n - 1)
    target = source if out is None else validate.integer("out", out, 0, n - 1)
    chosen = validate.integers("waves", waves, -_MOST_WAVES, _MOST_WAVES)
    if 0 not in chosen or len(set(chosen)) < len(chosen):
        raise ValueError(f"waves must be different numbers, 0 for the signal among them, got {list(chosen)}")
    frequencies, refined = _frequencies(frequency)
    silent = force_of(equation, np.zeros(n))
    if refused := BY_NAME["hill"].refusal(equation, silent):
        raise TypeError(refused.replace("method='hill'", "a spectrum"))
    verdict = stability(equation)
    if verdict.status == "unstable":
        raise ValueError(
            f"equation must be stable for a gain, and free motion grows at {verdict.growth_rate:.6g} per unit of time: "
            "it is beyond the threshold"
        )
    arrays = hill_arrays(equation)
    rows, error = _waves(arrays, frequencies, source, target, chosen)
    for _ in range(_ROUNDS if refined else 0):
        between = _bends(frequencies, rows)
        if not len(between) or len(frequencies) + len(between) > _MOST:
            break
        more, errors = _waves(arrays, between, source, target, chosen)
        order = np.argsort(np.concatenate([frequencies, between]), kind="stable")
        frequencies = np.concatenate([frequencies, between])[order]
        rows, error = np.concatenate([rows, more])[order], np.concatenate([error, errors])[order]
    return Gain(equation, source, target, frequencies, chosen, rows, error)


def _frequencies(frequency: Any) -> tuple[Floats, bool]:
    """Return the first frequencies, and whether others are added between them."""
    values = validate.array("frequency", frequency)
    if values.shape == (2,):
        low, high = validate.interval("frequency", frequency)
        return np.linspace(low, high, _FIRST), True
    if values.ndim != 1 or len(values) < 3:
        raise ValueError(
            f"frequency must be a range (low, high) or three frequencies at least, got shape {values.shape}"
        )
    if not (np.diff(values) > 0.0).all():
        raise ValueError("frequency must increase")
    validate.elements("frequency", len(values))
    return np.array(values), False


def _waves(
    arrays: HillArrays, frequencies: Floats, source: int, target: int, waves: tuple[int, ...]
) -> tuple[Complexes, Floats]:
    """Return the amplitudes (m, waves) of the waves at frequencies, and their errors; ValueError on a resonance."""
    count, n = len(frequencies), arrays.mass.shape[-1]
    force = np.zeros((count, 1, n), dtype=complex)
    force[:, 0, source] = 1.0
    values, error = balanced(arrays, force, frequencies)
    if not (error < 1e-2).all():
        raise ValueError(
            f"frequency must not be on a resonance, where no motion is bounded, got {frequencies[error.argmax()]:.9g}"
        )
    middle = values.shape[1] // 2
    rows = np.zeros((count, len(waves)), dtype=complex)
    for j, k in enumerate(waves):
        if abs(k) <= middle:
            rows[:, j] = values[:, middle + k, target]
    return rows, error


def _bends(frequencies: Floats, rows: Complexes) -> Floats:
    """Return frequencies between those where a magnitude leaves the chord of its neighbours, next to each."""
    sizes = np.abs(rows)
    top = np.maximum(sizes.max(axis=0), 1e-300)
    before, here, after = sizes[:-2], sizes[1:-1], sizes[2:]
    share = ((frequencies[1:-1] - frequencies[:-2]) / (frequencies[2:] - frequencies[:-2]))[:, None]
    chord = before + share * (after - before)
    # A neighbourhood bends by a fraction of the peak, or of its own size where that is small.
    bend = (np.abs(here - chord) > _BEND * np.maximum(here, 1e-3 * top)) & (here > 1e-3 * top)
    bent = np.flatnonzero(bend.any(axis=1)) + 1
    gaps = np.unique(np.concatenate([bent - 1, bent]))
    gaps = gaps[(frequencies[gaps + 1] - frequencies[gaps]) > 1e-9 * (frequencies[-1] - frequencies[0])]
    return np.asarray(0.5 * (frequencies[gaps] + frequencies[gaps + 1]))
