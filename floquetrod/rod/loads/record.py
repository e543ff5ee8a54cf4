"""A measured force: a record with noise, fitted by a mean and a Fourier series."""

from __future__ import annotations

import cmath
import functools
import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message, argument_of, error_in
from floquetrod._util.arrays import EPS, shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import constructor_hints, level_of_caller
from floquetrod._util.content import ByContent
from floquetrod._util.interchange import by_keys
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning
from floquetrod.rod.loads.load import LOAD, AxialLoad, Load, LoadSource, Second, Waveform, load_number
from floquetrod.rod.loads.record_file import read_columns
from floquetrod.rod.loads.record_fit import Fit, Samples, series
from floquetrod.rod.loads.record_lines import LEAST_LINE, TwoSines, fit_with_second, fitted_lines
from floquetrod.rod.loads.record_period import (
    RANDOM_ALONE,
    NoPeriodError,
    PeriodicFit,
    Spectrum,
    even_bands,
    find,
    fine_bands,
    power_spectrum,
    without_period,
)
from floquetrod.tables.arguments import column_argument, delimiter_argument
from floquetrod.units import Unit

_LATEST = 1e12  # s
_FEWEST = 12  # samples
_NEWTON = units.unit("N", "", "force")
_HERTZ = "Hz"  # in which a record's frequency is said, as its spectrum is drawn
_UNEVEN = 8.0  # times its median, from which the density of noise is no sensor's; white noise has 2.5 (a choice)
_ERRORS = 2.0  # standard errors by which drawn loads depart from the fit: 95 %
_PULLED = 0.1  # mean pull over the amplitude, from which it is said (a choice)
_PULLS = (
    " pulls on average, as forces are positive in compression; if the sensor counts compression as negative, change "
    "the sign of the forces"
)
_APART, _SAME = 1.0, 0.01  # frequencies that the record tells apart, and of a frequency: a second sine is a line's
_FOLDED = 10  # harmonics that a line may be an alias of (a choice)
_MOST_HARMONICS = 1000  # largest value of ``harmonics`` (a choice)
_IN_PYTHON = "(Python: second= of the record)"


class Band(NamedTuple):
    """A band of the spectrum of a record's noise: its ends, the one-sided density in it, and the standard error."""

    low: float  # Hz
    high: float  # Hz
    density: float  # N^2/Hz
    error: float  # relative to the density
    is_narrowest: bool

    @property
    def places(self) -> tuple[float, ...]:
        """Frequencies in Hz at which the density stands for the band, its ends; of the narrowest bands the middle.

        In these it may change as it does from one to the next.
        """
        return (0.5 * (self.low + self.high),) if self.is_narrowest else (self.low, self.high)


@constructor_hints()
@dataclass(frozen=True, eq=False, init=False, repr=False)
class ForceRecord(units.InUnits, LoadSource, ByContent):
    """Force measured over time, with noise and over any number of periods, fitted by a mean and a Fourier series.

    It can be given in place of a load; its `load` is then used.

    F(t) = mean + Re sum of c_h exp(i h frequency t), with the frequency and all coefficients fitted together by least
    squares.  The samples may be uneven and have gaps.  A linear trend is fitted too where there is one; it is not part
    of the force.

    Parameters
    ----------
    time : array_like (n,)
        In s, increasing.
    force : array_like (n,)
        In N, positive in compression.  Samples whose time or force is NaN are left out, at most half of them.
    harmonics : int, optional
        Largest number of harmonics searched for, 20 by default; fewer where the sampling rate or the number of samples
        allows no more, as ``note`` then says if ``harmonics`` is given.  With 0 no sine is fitted: all but the mean
        and a trend is noise, which `noisy_load` takes as a random force.
    frequency : float, optional
        Approximate frequency of the fundamental in rad/s, known to within a tenth or half a period per record; it is
        refined.  By default it is searched for: the strongest frequency of the record is then one of its first ten
        harmonics.
    second : float, optional
        Approximate frequency in rad/s of a sine that the record holds beside the fit, as `lines` of a record without
        this argument names it, known to within a hundredth or a period per record.  It is fitted together with mean,
        trend and harmonics and is the second sine of `load`; `noise` and all errors are those of what both leave.

    Attributes
    ----------
    time : ndarray
        Times of the samples fitted, in s.
    samples : ndarray
        The samples, in N.
    mean : float
        Mean force in N, at the middle of the record.
    mean_error : float
        Its standard error.
    trend : float
        Drift of the mean in N/s, 0 unless noise alone would cause one as large in less than one record of 100.
    trend_error : float
        Its standard error.
    frequency : float
        Of the fundamental in rad/s; 2 pi without harmonics, where no answer depends on it.
    frequency_error : float
        Its standard error.
    harmonics : ndarray of complex
        Amplitudes c_h in N of the harmonics 1, 2, ... searched for, 0 for those in the noise.
    harmonic_errors : ndarray
        Standard errors of their sizes in N.
    noise : float
        Root mean square in N of the residual of the fit.
    second : tuple of float or None
        The second sine fitted: amplitude in N, frequency in rad/s, phase in rad at time 0; None where none is fitted.
    second_errors : tuple of float or None
        Standard errors of its amplitude in N and of its frequency in rad/s.
    note : str
        Harmonics and samples left out, limits, and where the noise is not white.
    force_unit_named : bool
        Whether the unit of force is known: False for a file that names none and was read without ``force_unit``.
    time_unit_named : bool
        Whether the unit of time is known, as for dates and clock times.

    Raises
    ------
    TypeError, ValueError
        For unusable samples: a time that does not increase, or a force that does instead; fewer than 12 samples or two
        periods; a force without a period above the noise.

    Notes
    -----
    A harmonic counts as present where noise alone would give one as large, among all searched for, in less than one
    record of 100 (F test): from about 3.9 times the noise of an amplitude, noise * sqrt(2/n), for 20 harmonics.  A sine
    whose own frequency is off its multiple of the fundamental, by more than chance makes it in one record of 1000, is
    no harmonic, but one of `lines`.  A longer period than the strongest frequency's is chosen where its further
    harmonics pass a sharper test, one in 1000 records, and, where the record has fewer than four such periods, are a
    tenth of all: a drift makes smaller ones.  Where noise in a narrow band about the strongest harmonic is as strong,
    as that of a frequency that wanders, it is kept all the same; ``note`` says so, and the frequency may then be off by
    more than its error.

    Errors follow from least squares with white noise; about harmonics where the spectrum of the residual is
    significantly higher than white noise, they grow with it, and nowhere shrink.  In records drawn with bands of noise
    of four times the reciprocal of the record's duration or more, about the harmonic or beside it, amplitude and
    frequency are off by 0.7 to 1.3 standard errors in the root mean square; in narrower bands by more.  The mean is off
    by more in noise that grows towards frequency 0, such as a drift that is no straight line.  Aliases of frequencies
    above half the sampling rate cannot be distinguished from the harmonics that they coincide with.

    Answers about a record are in its unit of force and in Hz.

    Examples
    --------
    >>> t = np.arange(730) / 1600.0
    >>> push = 3.0 + 2.0 * np.sin(100.0 * t) + 0.5 * np.cos(200.0 * t)
    >>> record = ForceRecord(t, push + 0.1 * np.random.default_rng(1).standard_normal(t.size))
    >>> record.harmonic_numbers, round(record.mean, 1), round(float(abs(record.harmonics[0])), 1)
    ((1, 2), 3.0, 2.0)
    >>> abs(record.frequency - 100.0) < 4.0 * record.frequency_error < 0.1
    True
    """

    time: NDArray[np.float64]
    samples: NDArray[np.float64]
    mean: float
    mean_error: float
    trend: float
    trend_error: float
    frequency: float
    frequency_error: float
    harmonics: NDArray[np.complex128]
    harmonic_errors: NDArray[np.float64]
    noise: float
    second: Second | None
    second_errors: tuple[float, float] | None
    note: str
    force_unit_named: ClassVar[bool] = True
    time_unit_named: ClassVar[bool] = True

    def __init__(
        self,
        time: Any,
        force: Any,
        harmonics: int | None = None,
        frequency: float | None = None,
        second: float | None = None,
    ) -> None:
        """Check the samples and fit them."""
        most = None if harmonics is None else validate.integer("harmonics", harmonics, 0, _MOST_HARMONICS)
        guess = None if frequency is None else load_number("frequency", frequency)
        if most == 0 and guess is not None:
            raise validate.wrong_value("frequency", f"goes with a harmonic at least, got {guess!r} with harmonics=0")
        near = None if second is None else load_number("frequency", second, "second")
        if most == 0 and near is not None:
            raise validate.wrong_value("second", f"goes with a harmonic at least, got {near!r} with harmonics=0")
        times, forces, missing = _checked(time, force)
        if most is not None and 2 * most + 4 > times.size:
            raise validate.wrong_value(
                "harmonics",
                f"must be at most {times.size // 2 - 2} for {times.size} samples, got {most}: a harmonic has "
                "two unknowns, mean, trend and frequency one each",
            )
        samples = Samples.of(times, forces)
        periods = None if guess is None else guess * samples.half / math.pi
        found = without_period(samples) if most == 0 else find(samples, periods, most)
        beside = None if near is None else _two_sines(samples, found, near, most)
        found = found if beside is None else beside.found
        fit = _in_units(samples, found)
        trend = _trend(fit["trend"], fit["trend_error"], _NEWTON)
        note = _note(trend, found, missing, most)
        values = {"time": times, "samples": forces, **fit, **_second_in_units(samples, beside), "note": note}
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, name, value)
        self.given_in(units.GivenUnits.of(force=force)._replace(frequency=_HERTZ))

    @classmethod
    def from_csv(
        cls,
        path: str | Path,
        time: str | int | None = None,
        force: str | int | None = None,
        *,
        time_unit: str | None = None,
        force_unit: str | None = None,
        delimiter: str | None = None,
        harmonics: int | None = None,
        frequency: float | None = None,
        second: float | None = None,
    ) -> Self:
        """Read a record from a text file of columns; lines that begin with # are comments.

        The text is in UTF-8 or, where it cannot be, in Windows-1252.  Times are numbers, times of day such as
        12:00:00.000 or 02:00:00.000 PM, or dates with them, such as 2024-01-31T12:00:00.000+01:00, 31.01.2024 or
        01/31/2024, also in a column of their own, "Date".  Which number of 01/02/2024 is the month is taken such that
        the days of the record are closer together.

        Parameters
        ----------
        path : path
            Cells that are empty, or hold NaN, OVLD, OL, ---, Over Range or the like, are samples without a number;
            numbers in quotes may have commas between thousands.  The first line may hold headings, with units in the
            line below; up to 200 other lines may precede them.
        time : str or int, optional
            Heading of the column of times, with its unit or without, or its number from 0.  By default the one headed
            time, t, timestamp, elapsed or alike; of two columns with other headings or none, the first.
        force : str or int, optional
            Heading of the column of forces, likewise, or its number from 0.  By default the one headed force, f or
            load, or with such a word; of two columns with other headings or none, the second; of two of which the
            other is the time, the one with a unit of force in its heading or with ``force_unit``.
        time_unit : str, optional
            Unit of the times, such as "ms".  By default that in the heading, as in "t [ms]" or "time_ms", else s.
        force_unit : str, optional
            Unit of the forces, such as "lbf".  By default that in the heading, as in "force (kN)", "F / N",
            "FORCE_LBF" or "lbf" alone, else N: then `force_unit_named` is False, and verdicts warn where kN or mN are
            more likely, or where lbf are as likely and matter.
        delimiter : str, optional
            Separator of columns, by default the first of semicolon, tab, comma and space that the first line holds.
            With another one than the comma, numbers may have decimal commas.
        harmonics : int, optional
            As for `ForceRecord`.
        frequency : float, optional
            In rad/s, as for `ForceRecord`.
        second : float, optional
            In rad/s, as for `ForceRecord`.

        Returns
        -------
        ForceRecord
            With the fit.

        Raises
        ------
        TypeError, ValueError
            For a file that cannot be read, naming argument or line, and for samples that `ForceRecord` refuses.
        """
        path = validate.path("path", path)
        wanted = column_argument("time", time), column_argument("force", force)
        for name, unit in (("time", time_unit), ("force", force_unit)):
            if unit is not None:
                units.unit(unit, f"{name}_unit", name)
        delimiter = delimiter_argument(delimiter)
        if harmonics is not None:
            validate.integer("harmonics", harmonics, 0, _MOST_HARMONICS)
        if frequency is not None:
            load_number("frequency", frequency)
        if second is not None:
            load_number("frequency", second, "second")
        try:
            found = read_columns(path, *wanted, time_unit, force_unit, delimiter)
        except (OSError, ValueError) as error:
            raise error_in(f"force record {path}", error) from None
        try:
            record = cls(found.time, found.force, harmonics, frequency, second)
        except NoPeriodError as error:
            shown = units.unit(found.force_unit or "N", "", "force")
            said = str(error) if error.problem is None else f"force {error.problem(shown)}"
            raise NoPeriodError(f"force record {path}: {said}") from None
        except ValueError as error:
            if (about := argument_of(error)) is not None and about.name in ("frequency", "second"):
                raise error_in(f"force record {path}", error) from None
            # About the samples, not about which columns hold them.
            raise ValueError(f"force record {path}: {error}") from None
        object.__setattr__(record, "force_unit_named", bool(found.force_unit))
        object.__setattr__(record, "time_unit_named", found.has_time_unit)
        return record.given_in(record.given_units._replace(force=found.force_unit))

    @property
    def period(self) -> float:
        """Period in s."""
        return 2.0 * math.pi / self.frequency

    @property
    def periods(self) -> float:
        """Number of periods in the record."""
        return float(self.time[-1] - self.time[0]) / self.period

    @property
    def _force_unit(self) -> Unit:
        """Unit of forces in words and figures."""
        return units.AnswerUnits.named(given=self.given_units).force

    @property
    def load(self) -> AxialLoad:
        """The fitted force as a load, the same all along a rod; its harmonics are the waveform, a sine without any."""
        load = AxialLoad(self.mean, self.amplitude, self.frequency, waveform=self.waveform, second=self.second)
        return load.given_in(self.given_units)

    @cached_property
    def noise_spectrum(self) -> tuple[tuple[float, float], ...]:
        """Frequencies in Hz, and the one-sided spectral density there in N^2/Hz of the residual of the fit.

        Pairs at both ends of each band in which the power of the residual is even, except for chance, and in the middle
        of the narrowest.  The density is the average over the band; its relative standard error is one over the square
        root of the number of frequencies in it that the record tells apart.  A spectrum in which parts, of 4, 8, 16 or
        more such frequencies, differ beyond chance, that of one even record in five, is divided into four, and so are
        these, as long as four frequencies are left to each.  What rises less above the noise beside it is not seen:
        three times the density in 16 frequencies is missed in three of ten records of 4000 samples; verdicts therefore
        try the averages over 16 frequencies, too.  Nothing is known above half of the sampling rate.
        """
        return self._spectrum_of([band.density for band in self._bands])

    def _spectrum_of(self, densities: Iterable[float]) -> tuple[tuple[float, float], ...]:
        """Return pairs of frequency in Hz and density in N^2/Hz from a density of each band."""
        return tuple((at, density) for band, density in zip(self._bands, densities, strict=True) for at in band.places)

    @cached_property
    def _spectrum(self) -> tuple[Spectrum, float, float]:
        """The power of the residual, and the units of its frequencies in Hz and of its power in N^2/Hz."""
        samples = Samples.of(self.time, self.samples)
        rate = (self.time.size - 1) / float(self.time[-1] - self.time[0])
        return power_spectrum(samples, self._residual(samples)), 0.5 / samples.half, 2.0 / rate

    @cached_property
    def _bands(self) -> tuple[Band, ...]:
        """The bands of the spectrum of the noise."""
        found, hertz, density = self._spectrum
        return tuple(
            Band(hertz * band.low, hertz * band.high, density * band.power, band.error, band.is_narrowest)
            for band in even_bands(found)
        )

    @cached_property
    def _fine_spectrum(self) -> tuple[tuple[float, float], ...]:
        """The spectrum of the noise in bands of few frequencies, however even it is, plus their standard errors."""
        found, hertz, density = self._spectrum
        return tuple((hertz * at, density * power) for at, power in fine_bands(found))

    @cached_property
    def lines(self) -> tuple[Second, ...]:
        """Sines that the record holds beside the fit, five at most, the strongest first, as of a second tool.

        Each has its amplitude in N, its frequency in rad/s and its phase in rad at time 0, as ``second`` of a load
        takes it.  A hundredth of the ``amplitude`` is the least; noise, as strong everywhere as about the line, makes
        one in less than one record of 1000.  They count as noise in all other attributes.  A verdict on the record is
        undecided where one of them would change it.  The sentence that the record prints names a line that may be a
        harmonic, among the first ten, above half of the sampling rate, folded by evenly spaced samples.
        """
        samples = Samples.of(self.time, self.samples)
        residual = self._residual(samples) / samples.scale
        harmonics = np.array(self.harmonic_numbers) * (self.frequency * samples.half)
        if self.second is not None:
            harmonics = np.append(harmonics, self.second[1] * samples.half)
        found = fitted_lines(samples, residual, harmonics, LEAST_LINE * self.amplitude / samples.scale)
        return tuple(_sine(samples, line) for line in found)

    def _residual(self, samples: Samples) -> NDArray[np.float64]:
        """Return the samples less the fit, in N."""
        level = self.samples - self.mean - self.trend * (self.time - samples.centre)
        residual: NDArray[np.float64] = level - self._sines(self.time)
        return residual

    @property
    def _mean_error(self) -> float:
        return self.mean_error

    @property
    def _is_uneven(self) -> bool:
        density = np.array([band.density for band in self._bands])
        return bool(density.max() > _UNEVEN * float(np.median(density)))

    def _with_fine_noise(self) -> None:
        """Its load has no noise."""

    def _with_residual(self) -> ChangedRecord:
        return ChangedRecord(self, functools.partial(_with_noise, self.noise_spectrum))

    @property
    def _means(self) -> tuple[float, ...]:
        """Mean forces in N at the beginning and the end of a record with a trend."""
        change = 0.5 * self.trend * float(self.time[-1] - self.time[0])
        return (self.mean - change, self.mean + change) if change else ()

    def _line_in_words(self, line: Second) -> str:
        """Return a line as ``--second`` takes it, in the unit of the record."""
        unit = self._force_unit
        return f"{unit.of(line[0]):.4g}{unit.name}@{_hertz_of(line)}"

    def _within_errors(self, count: int) -> Iterator[AxialLoad]:
        """Yield loads with numbers drawn about the fitted ones, with twice their standard errors."""
        random, fit, kept = np.random.default_rng(0), self.load, np.flatnonzero(self.harmonics)
        slowest = LOAD["frequency"].least
        for _ in range(count):
            shift = random.standard_normal((kept.size, 2)) @ np.array([1.0, 1j])
            harmonics = self.harmonics.copy()
            harmonics[kept] += _ERRORS * self.harmonic_errors[kept] * shift
            spread = _ERRORS * self.mean_error, _ERRORS * self.frequency_error
            mean, omega = random.normal((fit.mean, fit.frequency), spread).tolist()
            shape = tuple((harmonics[: kept[-1] + 1] / self.amplitude).tolist()) if kept.size else fit.waveform
            second = self.second
            if second is not None and self.second_errors is not None:
                off, moved = (_ERRORS * error for error in self.second_errors)
                c = second[0] + off * complex(*random.standard_normal(2).tolist())
                at = max(second[1] + moved * random.standard_normal(), slowest)
                second = abs(c), at, second[2] + cmath.phase(c)
            yield replace(fit, mean=mean, frequency=max(omega, slowest), waveform=shape, second=second)

    @property
    def noisy_load(self) -> ChangedRecord:
        """The record with the spectrum of its residual as the noise of its load, for verdicts in mean square.

        As an argument it stands for its ``load``; `Rod.stability` counts the errors of its numbers and densities.  With
        the record itself in place of a load the noise only makes the verdict uncertain.  Warns of `lines`, whose power
        a spectrum spreads over a band as if they were noise.
        """
        if self.second is not None:
            raise validate.wrong_value(
                "noisy_load", "goes without a second sine; read the record without second= (terminal: --second)"
            )
        noisy = self._with_residual()
        for said in self._lines_in_words("the record", noisy.load):
            warnings.warn(Message(said, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())
        return noisy

    @cached_property
    def harmonic_numbers(self) -> tuple[int, ...]:
        """Numbers of the harmonics above the noise."""
        return tuple((np.flatnonzero(self.harmonics) + 1).tolist())

    @cached_property
    def amplitude(self) -> float:
        """Half the distance in N between the largest and the smallest value of the fit."""
        return 0.5 * (self._extreme(1.0) + self._extreme(-1.0)) if self.harmonic_numbers else 0.0

    @cached_property
    def waveform(self) -> Waveform:
        """The harmonics up to the last one above the noise, over the amplitude; "sine" without any."""
        if not self.harmonic_numbers:
            return "sine"
        return tuple((self.harmonics[: self.harmonic_numbers[-1]] / self.amplitude).tolist())

    def force(self, t: Any) -> Any:
        """Return the fitted force, mean, harmonics and any second sine, in N at times in s, in their shape.

        Returns
        -------
        float or ndarray
            In N, in the shape of ``t``.

        Raises
        ------
        TypeError, ValueError
            For times that are not finite, and for other units.
        """
        times = units.array("t", t, "time", -_LATEST, _LATEST)
        values = self.mean + self._sines(times)
        return shaped(np.asarray(values), times.shape)

    def plot(self, ax: Any = None) -> Any:
        """Draw the record with the fit, and the spectrum with the noise, on two matplotlib axes.

        Forces are in the unit of the record.

        Returns
        -------
        sequence of two matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.record_plot import draw_record

        return draw_record(self, ax, self._force_unit)

    def spectrum(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return frequencies in Hz, up to half of the sampling rate, and amplitudes in N of record and residual there.

        Those of the record without its mean and trend, and of the residual of the fit.

        Returns
        -------
        tuple of three ndarrays
            Frequencies in Hz, amplitudes of the record and of the residual in N.
        """
        samples = Samples.of(self.time, self.samples)
        left = self._residual(samples)
        record = power_spectrum(samples, left + self._sines(self.time))
        residual = power_spectrum(samples, left)
        frequency: NDArray[Any] = record.step * np.arange(1, record.power.size + 1) / (2.0 * samples.half)
        whole, rest = (2.0 * np.sqrt(found.power / self.time.size) for found in (record, residual))
        return frequency, whole, rest

    def as_dict(self) -> dict[str, Any]:
        """Return the fit as numbers for JSON, units in the keys."""
        return by_keys(
            self,
            "mean_N mean_error_N amplitude_N frequency_rad_per_s frequency_error_rad_per_s harmonic_numbers noise_N "
            "periods note",
        )

    def __repr__(self) -> str:
        """Return the fit as a sentence."""
        return f"<{self.in_words(self._force_unit)}>"

    def in_words(self, force: Unit, frequency: Unit | None = None) -> str:
        """Return the fit as a sentence, with a unit of frequency that in place of the period."""
        return self._beside_in_words(self.load, force, frequency)

    def _beside_in_words(self, load: Load, force: Unit, frequency: Unit | None = None) -> str:
        """Return the fit as a sentence, as `in_words`, beside a load that may hold some of the lines."""
        if not self.harmonic_numbers:
            duration = float(self.time[-1] - self.time[0])
            text = (
                f"force of mean {force.show(self.mean)} with a noise of {force.show(self.noise, 3)} and no sine; "
                f"{duration:.4g} s, {self.time.size} samples"
            )
            return self._with_notes(text, load, force)
        off = self.frequency_error / self.frequency
        digits = min(max(math.ceil(-math.log10(off)) + 1, 3), 8) if off > 0.0 else 8
        often = f"period {self.period:.{digits}g} s +- {self.period * off:.1g} s"
        if frequency is not None:
            often = f"{frequency.show(self.frequency, digits)} +- {frequency.show(self.frequency_error, 1)}"
        hertz = units.unit(_HERTZ, "", "frequency") if frequency is None else frequency
        strongest = self._strongest
        at = f", the strongest, number {strongest}, at {hertz.show(strongest * self.frequency)}" * (strongest > 1)
        text = (
            f"force of mean {force.show(self.mean)} and amplitude {force.show(self.amplitude)}, {often}, "
            f"{_harmonics(self.harmonic_numbers)} above a noise of {force.show(self.noise, 3)}{at}; "
            f"{self.periods:.4g} periods, {self.time.size} samples"
        )
        if self.second is not None and self.second_errors is not None:
            text += (
                f"; fitted together with a second sine of {force.show(self.second[0], 4)} +- "
                f"{force.show(self.second_errors[0], 1)} at {hertz.show(self.second[1])}"
            )
            text = "; ".join([text, *self._folded_in_words([self.second])])
        return self._with_notes(text, load, force)

    def _with_notes(self, text: str, load: Load, force: Unit) -> str:
        """Return a text on the fit with all that is said about it, beside a load that may hold some of the lines."""
        in_newtons, said = (_trend(self.trend, self.trend_error, each) for each in (_NEWTON, force))
        note = self.note.replace(in_newtons, said) if self.trend else self.note
        named = {"time is in seconds": self.time_unit_named, "force is in newtons": self.force_unit_named}
        taken = " and ".join(words for words, is_named in named.items() if not is_named)
        notes = [f"the file names no unit, so {taken}"] * bool(taken) + [note] * bool(note)
        return "; ".join([text, *notes, *self._lines_in_words("it", load), *self._pull_in_words("it")])

    @property
    def _strongest(self) -> int:
        """Number of the strongest harmonic, 1 without any."""
        return int(np.abs(self.harmonics).argmax()) + 1 if self.harmonic_numbers else 1

    def _moved_in_words(self, frequencies: Sequence[float]) -> list[Message]:
        """Return that other frequencies, a value or the ends of a range in rad/s, move the strongest harmonic.

        Nothing is said where that is the first, as the frequency given is then its own.
        """
        if self._strongest == 1 or set(frequencies) == {self.frequency}:
            return []
        hertz = units.unit(_HERTZ, "", "frequency")
        own, *given = (f"{hertz.of(each):.4g}" for each in (self.frequency, *frequencies))
        before, *after = (f"{hertz.of(self._strongest * each):.4g}" for each in (self.frequency, *frequencies))
        to = f"between {' and '.join(after)}" if after[1:] else after[0]
        return [
            Message(
                Mention("frequency"),
                f" {':'.join(given)} Hz replaces that of the fundamental, {own} Hz; the strongest harmonic of the "
                f"record, number {self._strongest}, moves from {before} to {to} Hz",
            )
        ]

    def _lines_beside(self, second: Second | None) -> tuple[Second, ...]:
        """Return the lines other than the second sine of a load."""
        if second is None:
            return self.lines
        apart = _APART * self.frequency / self.periods
        return tuple(line for line in self.lines if abs(line[1] - second[1]) > max(apart, _SAME * line[1]))

    def _lines_in_words(self, it: str, load: Load) -> list[str]:
        """Return which lines the force, ``it``, holds beside the fit and the second sine of a load."""
        lines = self._lines_beside(load.second)
        if not lines:
            return []
        sines = " and ".join(map(self._line_in_words, lines))
        many = "sines, or noise in narrow bands," if len(lines) > 1 else "a sine, or noise in a narrow band,"
        what = f"--second {_hertz_of(lines[0])} fits {'one' if lines[1:] else 'it'} together with the rest {_IN_PYTHON}"
        if load.second is not None:
            what = "a load has one second sine"
        elif load.noise:
            what = "as noise its power is spread over a band, which may hide that it makes the rod unstable"
        said = [f"{it} holds {many} beside the fit: {sines}", what, *self._folded_in_words(lines)]
        return ["; ".join(said)]

    def _folded_in_words(self, lines: Sequence[Second]) -> list[str]:
        """Return which lines may be aliases of harmonics above half of the sampling rate."""
        if not self.harmonic_numbers or not Samples.of(self.time, self.samples).is_even:
            return []
        # Evenly spaced samples show n f at its distance from the nearest multiple of the sampling rate, at f_s / 2 at
        # the most.
        base, duration = 1.0 / self.period, float(self.time[-1] - self.time[0])
        rate = (self.time.size - 1) / duration
        above = np.arange(1, _FOLDED + 1)
        above = above[above * base > 0.5 * rate]
        shown = np.abs(above * base - rate * np.round(above * base / rate))
        said = []
        for line in lines:
            near = np.abs(shown - line[1] / (2.0 * math.pi)) <= _APART / duration
            if near.any():
                said.append(
                    f"{line[1] / (2.0 * math.pi):.6g} Hz may be harmonic {above[near][0]} folded at the sampling rate "
                    f"of {rate:.6g} Hz, as a faster record would show"
                )
        return said

    def _left_out_in_words(self, load: Load) -> str:
        """Return the lines of the record that a load does not hold, "" without any."""
        sines = [self._line_in_words(line) for line in self._lines_beside(load.second)]
        return f"the sine{'s' * (len(sines) > 1)} {' and '.join(sines)} of the record" if sines else ""

    def _pull_in_words(self, it: str) -> list[str]:
        """Return that the force pulls on average, of ``it``, where it does so by a tenth of its amplitude or more."""
        return [it + _PULLS] * (self.mean < -_PULLED * self.amplitude)

    def _sines(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the harmonics and any second sine, in N at times in s."""
        vibration = self._vibration(self.frequency * times)
        if self.second is None:
            return vibration
        amplitude, frequency, phase = self.second
        vibration += amplitude * np.sin(frequency * times + phase)
        return vibration

    def _vibration(self, angle: NDArray[np.float64]) -> NDArray[np.float64]:
        return series(angle, self.harmonic_numbers, self.harmonics[np.array(self.harmonic_numbers, dtype=int) - 1])

    def _extreme(self, sign: float) -> float:
        """Return the largest value of the vibration, or of its negative: on a grid, then by Newton's method."""
        angles = np.linspace(0.0, 2.0 * math.pi, 64 * self.harmonic_numbers[-1], endpoint=False)
        values = sign * self._vibration(angles)
        angle, numbers = float(angles[values.argmax()]), np.arange(1, self.harmonics.size + 1)
        for _ in range(5):
            terms = sign * self.harmonics * np.exp(1j * numbers * angle)
            slope, bend = float((1j * numbers * terms).real.sum()), -float((numbers**2 * terms).real.sum())
            if bend < 0.0:
                angle -= slope / bend
        return max(float(values.max()), sign * float(self._vibration(np.array(angle))))


@dataclass(frozen=True)
class ChangedRecord(LoadSource):
    """A measured force with some numbers, or the kind of load, changed: ``change`` makes its load of the record's.

    The errors of unchanged numbers count in verdicts.
    """

    record: ForceRecord
    change: Callable[[Load], Load]

    @property
    def load(self) -> Load:
        """The changed load."""
        return self.change(self.record.load)

    @property
    def lines(self) -> tuple[Second, ...]:
        """The lines of the record that the changed load does not hold as its second sine."""
        return self.record._lines_beside(self.load.second)

    def _left_out_in_words(self, load: Load) -> str:
        return self.record._left_out_in_words(load)

    @property
    def _means(self) -> tuple[float, ...]:
        return self.record._means if self.load.mean == self.record.mean else ()

    @property
    def _mean_error(self) -> float:
        return self.record.mean_error if self.load.mean == self.record.mean else 0.0

    @property
    def _is_uneven(self) -> bool:
        return not self.load.noise and self.record._is_uneven

    def _with_fine_noise(self) -> Load | None:
        load = self.load
        is_measured = load.noise and load.noise == self.record.noise_spectrum
        return replace(load, noise=self.record._fine_spectrum) if is_measured else None

    def _with_residual(self) -> ChangedRecord:
        noise = self.record.noise_spectrum
        return ChangedRecord(self.record, lambda fit: _with_noise(noise, self.change(fit)))

    def _line_in_words(self, line: Second) -> str:
        return self.record._line_in_words(line)

    def _within_errors(self, count: int) -> Iterator[Load]:
        """Yield loads as `ForceRecord`; where its spectrum is their noise, each band departs by two standard errors."""
        random, spectrum = np.random.default_rng(0), self.record.noise_spectrum if self.load.noise else ()
        if spectrum:
            densities, errors = np.array([(band.density, band.error) for band in self.record._bands]).T
        for load in map(self.change, self.record._within_errors(count)):
            if load.noise and load.noise == spectrum:
                drawn = densities * np.exp(_ERRORS * errors * random.standard_normal(errors.size))
                yield replace(load, noise=self.record._spectrum_of(drawn.tolist()))
            else:
                yield load


def _with_noise(noise: tuple[tuple[float, float], ...], fit: Load) -> Load:
    """Return a load with noise in place of any second sine, beside which noise is not known."""
    return replace(fit, noise=noise, second=None).given_in(fit.given_units)


def _checked(time: Any, force: Any) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return times in s and forces in N of the valid samples, checked, and the number of samples left out as NaN."""
    times = _column("time", time, -_LATEST, _LATEST)
    forces = _column("force", force, LOAD["mean"].least, LOAD["mean"].largest)
    if times.size != forces.size:
        raise ValueError(f"time and force must have one length, got {times.size} and {forces.size}")
    there = ~(np.isnan(times) | np.isnan(forces))
    if times.size and 2 * int(there.sum()) < times.size:
        raise ValueError(
            f"time and force must be numbers in half of the samples at least, got NaN in {int((~there).sum())} of "
            f"{times.size}"
        )
    times, forces = times[there], forces[there]
    if times.size < _FEWEST:
        raise ValueError(f"time and force must have {_FEWEST} samples or more, got {times.size}")
    steps = np.diff(times)
    if not (steps > 0.0).all():
        at = int(np.flatnonzero(steps <= 0.0)[0])
        if (np.diff(forces) > 0.0).all():
            raise validate.wrong_value("time", "must increase; force does in its place: the two columns are swapped")
        remedy = "sort the samples by time"
        if not (steps < 0.0).any():
            remedy = "equal times may have lost digits where they were written; keep one sample of each"
        raise validate.wrong_value(
            "time",
            f"must increase, got {float(times[at + 1])!r} after {float(times[at])!r} s "
            f"({int((steps <= 0.0).sum())} of {steps.size} steps do not increase); {remedy}",
        )
    if np.ptp(forces) <= 4.0 * EPS * np.abs(forces).max():
        raise validate.wrong_value(
            "force", f"must vary, got {float(forces[0])!r} N throughout; for a constant force use AxialLoad"
        )
    return times, forces, int((~there).sum())


def _column(name: str, values: Any, least: float, largest: float) -> NDArray[np.float64]:
    """Return one column of samples as a new array, in which there may be NaN."""
    values = validate.untyped(name, units.si(values, name, name))
    try:
        holes = np.isnan(values)
    except TypeError:  # of another kind, which the check names
        holes = np.array(False)
    if holes.any():
        values = np.where(holes, 0.0, values)
    result = np.where(holes, np.nan, validate.array(name, values, least=least, largest=largest))
    if result.ndim != 1:
        raise validate.wrong_value(name, f"must be one-dimensional, got an array of shape {result.shape}")
    return result


def _in_units(samples: Samples, found: PeriodicFit) -> dict[str, Any]:
    """Return what was found in s and N, phases from time 0."""
    best, every = found.fit, found.every
    frequency = best.omega / samples.half
    harmonics = np.zeros(len(every.numbers), dtype=complex)
    errors = samples.scale * every.sizes()[1]
    places = np.array(best.numbers, dtype=int) - 1
    harmonics[places] = (
        samples.scale * best.amplitudes * np.exp(-1j * np.array(best.numbers) * (frequency * samples.centre))
    )
    errors[places] = samples.scale * best.sizes()[1]
    deviations = np.sqrt(best.covariance.diagonal())
    return {
        "mean": float(samples.offset + samples.scale * best.coefficients[0]),
        "mean_error": float(samples.scale * deviations[0]),
        "trend": float(samples.scale * best.coefficients[1] / samples.half),
        "trend_error": float(samples.scale * deviations[1] / samples.half) if best.coefficients[1] else 0.0,
        "frequency": float(frequency),
        "frequency_error": float(deviations[-1] / samples.half),
        "harmonics": harmonics,
        "harmonic_errors": errors,
        "noise": float(samples.scale * math.sqrt(best.variance)),
    }


def _two_sines(samples: Samples, found: PeriodicFit, near: float, most: int | None) -> TwoSines:
    """Return the joint fit with the line of the residual whose frequency is near one in rad/s; else ValueError."""
    residual = samples.values - found.fit.values(samples.tau)
    harmonics = found.fit.omega * np.array(found.fit.numbers)
    lines = fitted_lines(samples, residual, harmonics, 0.0)
    off = [abs(line.omega / samples.half - near) for line in lines]
    place = int(np.argmin(off)) if off else 0
    if not off or off[place] > max(_APART * math.pi / samples.half, _SAME * near):
        held = " and ".join(f"{line.omega / samples.half / (2.0 * math.pi):.6g}" for line in lines)
        base = found.fit.omega / samples.half / (2.0 * math.pi)
        beside = f"it holds {held} Hz" if lines else "it holds none above the noise"
        multiple = round(near / (2.0 * math.pi * base))
        if multiple in found.fit.numbers and abs(near / (2.0 * math.pi) - multiple * base) <= _SAME * multiple * base:
            beside = f"the fit holds harmonic {multiple}, so that the verdict without second has it"
        raise validate.wrong_value(
            "second",
            f"must be the frequency of a sine that the record holds beside its fit, whose fundamental is {base:.6g} "
            f"Hz: {beside}, got {near / (2.0 * math.pi):.6g} Hz",
        )
    joint = fit_with_second(samples, found, lines[place], most)
    if joint is None:
        raise validate.wrong_value("second", "cannot be fitted: the fit of both sines does not settle")
    return joint


def _second_in_units(samples: Samples, joint: TwoSines | None) -> dict[str, Any]:
    """Return the second sine and its errors in N and rad/s, None without one."""
    if joint is None:
        return {"second": None, "second_errors": None}
    off, moved = joint.second.sizes()[1].item(), joint.second.frequency_error
    errors = float(samples.scale * off), float(moved / samples.half)
    return {"second": _sine(samples, joint.second), "second_errors": errors}


def _sine(samples: Samples, line: Fit) -> Second:
    """Return a fit of one harmonic as amplitude in N, frequency in rad/s and phase in rad at time 0."""
    # Re c exp(i omega tau) = abs(c) sin(omega tau + arg c + pi / 2), with tau from the middle of the record.
    (c,), omega = line.amplitudes.tolist(), line.omega / samples.half
    phase = (cmath.phase(c) + 0.5 * math.pi - omega * samples.centre) % (2.0 * math.pi)
    return float(abs(c) * samples.scale), float(omega), float(phase)


def _hertz_of(line: Second) -> str:
    """Return the frequency of a line in words."""
    return f"{line[1] / (2.0 * math.pi):.6g}{_HERTZ}"


def _trend(trend: float, error: float, force: Unit) -> str:
    """Return a trend in N/s in words, in a unit of force per second."""
    return f"trend of {force.of(trend):.3g} +- {force.of(error):.1g} {force.name}/s, removed from the force"


def _harmonics(numbers: Iterable[int]) -> str:
    """Return the numbers of harmonics in words."""
    text = ", ".join(map(str, numbers))
    return f"harmonic{'s' * (',' in text)} {text}"


def _note(trend: str, found: PeriodicFit, missing: int, most: int | None) -> str:
    """Return what a reader of the fit should know."""
    parts = []
    if missing:
        parts.append(f"{missing} sample{'s' * (missing > 1)} without a number left out")
    if found.fit.coefficients[1]:
        parts.append(trend)
    tested = len(found.every.numbers)
    if most is not None and tested < most:
        parts.append(f"{tested} harmonics fitted: the sampling allows no more")
    if found.beyond:
        some = ", ".join(map(str, found.beyond[:3])) + (" and others" if len(found.beyond) > 3 else "")
        parts.append(f"harmonics {some} above the noise but not fitted (Python: harmonics={found.beyond[-1]})")
    above = [number for number, factor in zip((0, *found.fit.numbers), found.factors, strict=True) if factor > 1.0]
    if above:
        where = " and ".join([*["frequency 0"] * (0 in above), *[_harmonics(filter(None, above))] * any(above)])
        accounted = "" if found.wanders else ", which the errors account for"
        parts.append(f"noise about {where} up to {found.factors.max():.2g} times its average{accounted}")
    if found.wanders:
        parts.append(
            "no harmonic stands above the noise next to it, and the strongest is kept: the force may be random there, "
            "or its frequency wander, by more than its error"
        )
    if found.may_be_noise:
        parts.append(
            "the harmonics may be chance in a band of noise; if the force is random alone, take the spectrum of all of "
            f"it: {RANDOM_ALONE}"
        )
    return "; ".join(parts)
