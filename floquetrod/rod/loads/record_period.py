"""The period of samples: where their spectrum is strongest, which harmonic that is, and which harmonics there are."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Floats
from floquetrod.rod.loads.record_fit import Fit, Samples, fit, freed, level
from floquetrod.units import Unit

FALSE_HARMONIC = 0.01
"""Chance that white noise alone puts any harmonic of a record among those kept (a choice)."""

FEWEST_PERIODS = 1.9
"""Periods that a record has at least: two, less the error of the period."""

RANDOM_ALONE = "--amplitude 0 --noise spectrum (Python: harmonics=0, and noisy_load of the record)"
"""What takes all of a record but its mean as random."""

_NEWTON = Unit("N", 1.0)
_MOST_HARMONICS = 20  # searched for by default (a choice)
_DEEPEST = 10  # number of the strongest harmonic at most (a choice)
_FALSE_PERIOD = 1e-3  # chance that white noise alone passes for a period, or multiplies it (a choice)
_COLOURED = 1e-3  # chance that white noise counts as stronger about one frequency than on average (a choice)
_NEAREST = 2.0  # frequencies that the record tells apart, on a side, whose noise is averaged at least (a choice)
_LEAST_FREEDOM = 2.0  # of an average of noise (a choice)
_FALSE_TREND = 0.01  # chance that white noise alone passes for a trend (a choice)
_WORTH_A_FIT = 8.0  # power over that of the noise above which a frequency between harmonics is fitted (a choice)
_PRIMES = (2, 3, 5, 7)  # factors of the numbers up to `_DEEPEST`
_SLOW = 4.0  # periods in the record up to which a fundamental may be a drift (a choice)
_DRIFT = 0.1  # size of harmonics, relative to all, up to which they may be those of a drift (a choice)
_GUESS = 0.1  # how far off a given frequency may be, relative to it (a choice)
_GUESS_HARMONICS = 5  # whose power tells where the frequency is (a choice)
_COARSE = 0.05  # error of a frequency that is refined later, relative to its standard error (a choice)
_KNOWN = 0.1  # radians at the ends of a record that the frequency leaves open in its highest harmonic (a choice)
_MOST_CELLS = 1 << 21  # of the grid of a spectrum, which takes half a second
_IN_A_PART = 4  # frequencies that the record tells apart, in the narrowest bands of its noise (a choice)
_NOTHING = 1e-9  # power relative to its mean: less is rounding (a choice)
_UNEVEN_BAND = 0.2  # chance that even noise is divided (a choice)
IN_A_FINE_BAND = 16
"""Frequencies that the record tells apart, over which the power of its noise is averaged at least, even or not."""

_FINE = 512  # bands of such averages at most (a choice)
_PADDING = 4  # frequencies of a spectrum per reciprocal of the duration


class PeriodicFit(NamedTuple):
    """What a record was found to be."""

    fit: Fit  # of the harmonics kept
    every: Fit  # of all harmonics searched for
    beyond: tuple[int, ...]  # harmonics above the noise that were not searched for
    factors: Floats  # how many times the noise about 0 and each harmonic kept exceeds its average, in amplitude
    wanders: bool  # no harmonic stands above the noise next to it: the strongest is kept
    may_be_noise: bool  # so does none in one record of 1000 anywhere, in noise as strong as next to the harmonics


def find(samples: Samples, guess: float | None, most: int | None) -> PeriodicFit:
    """Return the fit of a mean, a trend and harmonics, so many at most.

    ``guess`` are the periods in the record, known within a tenth or half a period.  Raises ValueError for a record
    without a period above the noise, or of less than two.
    """
    line = np.polynomial.polynomial.polyfit(samples.tau, samples.values, 1)
    level = samples.values - np.polynomial.polynomial.polyval(samples.tau, line)
    power = power_spectrum(samples, level)
    most = _MOST_HARMONICS if most is None else most
    if guess is None:
        periods, tried = _strongest(samples, power, level), power.power.size * power.step
        first = _climb(samples, periods, most)
        best = None if first is None else _longer(samples, first, periods, most)
    else:
        periods, tried = _near(samples, power, guess, most)
        best = _climb(samples, periods, most, _GUESS_HARMONICS)
    if best is None:
        raise _without_period(samples, "the fit does not settle", guess)
    if best.omega < FEWEST_PERIODS * math.pi:
        raise _too_short(best.omega / math.pi, guess is not None)
    return _kept(samples, best, tried, most, guess)


def without_period(samples: Samples) -> PeriodicFit:
    """Return the fit of a mean and a trend alone, where all the rest is noise; its frequency is 1 Hz."""
    omega = 2.0 * math.pi * samples.half
    every = level(samples, omega, trend=True)
    factors = coloured(every, _left(samples, every))
    if every.with_noise(factors).trend_chance() >= math.log(_FALSE_TREND):
        every = level(samples, omega, trend=False)
        factors = coloured(every, _left(samples, every))
    return PeriodicFit(every.with_noise(factors), every, (), factors, wanders=False, may_be_noise=False)


def refine(samples: Samples, found: PeriodicFit, most: int | None) -> PeriodicFit | None:
    """Return the fit of samples that differ from those of ``found`` by a sine that is no harmonic.

    Which harmonics stand above the noise is tested again.  None where the fit does not settle.
    """
    best = fit(samples, found.fit.omega, found.every.numbers, precision=_COARSE)
    return None if best is None else _kept(samples, best, 1.0, _MOST_HARMONICS if most is None else most)


class NoPeriodError(ValueError):
    """Samples show no period, or not two; ``problem`` says the first in a unit of force."""

    problem: Callable[[Unit], str] | None = None


def _without_period(samples: Samples, why: str, guess: float | None = None) -> ValueError:
    # Variance v of samples at a rate r is that of noise of the one-sided density 2 v / r up to r / 2.
    # A trend is no part of the noise.
    rate = (samples.tau.size - 1) / (2.0 * samples.half)
    mean = samples.offset + samples.scale * float(samples.values.mean())
    ends, variance = _drift(samples)
    density = 2.0 * samples.scale**2 * variance / rate
    drift = tuple(samples.offset + samples.scale * end for end in ends)
    problem = partial(_random_alone, why, mean, density, drift, guess is not None)
    error = wrong_value("force", problem(_NEWTON), kind=NoPeriodError)
    error.__dict__["problem"] = problem
    return error


def _drift(samples: Samples) -> tuple[tuple[float, ...], float]:
    """Return the values at both ends of a trend, none where it may be chance, and the variance without it."""
    variance = float(samples.values.var())
    line = np.polynomial.polynomial.polyfit(samples.tau, samples.values, 1)
    left = float((samples.values - np.polynomial.polynomial.polyval(samples.tau, line)).var())
    free = samples.tau.size - 2
    if 0.5 * free * math.log(max(left, samples.rounding**2) / variance) > math.log(_FALSE_TREND):
        return (), variance
    return (float(line[0] - line[1]), float(line[0] + line[1])), left


def _random_alone(why: str, mean: float, density: float, ends: tuple[float, ...], is_given: bool, unit: Unit) -> str:
    """Return that there is no period, and what to give for noise alone of a mean in N and a density in N^2/Hz.

    ``ends`` are the forces in N from which to which it drifts, none where it does not; ``is_given``: a frequency was.
    """
    each = unit, Unit(f"{unit.name}^2/Hz", unit.size**2)
    push, noise = (one.show(value, 4).replace(" ", "") for one, value in zip(each, (mean, density), strict=True))
    drifts = f"; it drifts from {unit.of(ends[0]):.3g} to {unit.show(ends[1], 3)}" if ends else ""
    beside = " about that drift" if ends else ""
    near = " near the frequency given" if is_given else ""
    other = "another" if is_given else "its approximate"
    how = "" if is_given else ": --force-frequency, such as 10Hz (Python: frequency=, in rad/s)"
    return (
        f"shows no period above the noise{near}: {why}{drifts}; record longer, or give {other} frequency{how}; "
        f"where it is random alone{beside}, take its spectrum: {_taking_all(is_given)}; or, with one density at all "
        f"frequencies, give its mean and its density: --mean {push} --amplitude 0{unit.name} --noise {noise} and any "
        "--frequency, such as 1Hz, as no sine acts (Python: "
        f'fr.AxialLoad("{push}", 0, "1Hz", noise="{noise}"))'
    )


def _taking_all(is_given: bool) -> str:
    """Return what takes all of a record but its mean as random, where a frequency is given without that."""
    return RANDOM_ALONE.replace(" (", " without --force-frequency (") if is_given else RANDOM_ALONE


def _too_short(periods: float, is_given: bool = False) -> ValueError:
    return wrong_value(
        "force",
        f"must be recorded for two periods or more, got {periods:.2g}: its strongest variation takes "
        f"{1.0 / periods:.2g} of the time recorded; record longer, or, where that is a drift, give the "
        "approximate frequency: --force-frequency, such as 10Hz (Python: frequency=, in rad/s), or, where it is random "
        f"alone, take its spectrum: {_taking_all(is_given)}",
        kind=NoPeriodError,
    )


# --- where to start ---


def _strongest(samples: Samples, power: Spectrum, level: Floats) -> float:
    """Return the strongest frequency in periods per record; ValueError where noise alone may be as strong."""
    if not power.power.size:
        raise wrong_value("force", f"must have more samples than {samples.tau.size} for its period to be found")
    top = int(power.power.argmax())
    variance = max(float(level @ level) / level.size, samples.rounding**2)
    tried = power.power.size * power.step
    if math.log(tried) - power.power[top] / variance > math.log(_FALSE_PERIOD):
        raise _without_period(samples, "white noise would have as strong a frequency")
    shift = 0.0
    if 0 < top < power.power.size - 1:
        before, at, after = power.power[top - 1 : top + 2]
        bend = before - 2.0 * at + after
        shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    periods = power.step * (top + 1 + shift)
    if periods < FEWEST_PERIODS:
        raise _too_short(periods)
    return periods


def _near(samples: Samples, power: Spectrum, guess: float, most: int) -> tuple[float, float]:
    """Return the frequency near a guess whose harmonics are strongest, and among how many it was chosen."""
    reach = max(_GUESS * guess, 0.5)
    if guess + reach < FEWEST_PERIODS:
        raise wrong_value(
            "frequency",
            f"must have two periods or more in the record, got {guess:.2g}; without a unit it is in rad/s; record "
            "longer",
        )
    if not guess + reach < samples.highest:
        raise wrong_value(
            "frequency",
            f"must lie below half of the sampling rate, got {guess * math.pi / samples.half:.6g} rad/s for "
            f"samples that are {samples.interval * samples.half:.3g} s apart; without a unit it is in rad/s",
        )
    numbers = np.arange(1, min(most, _GUESS_HARMONICS, int(samples.highest / guess)) + 1)
    tries = np.arange(max(guess - reach, power.step), guess + reach, 0.5 * power.step / numbers[-1])
    strength = power.at(tries[:, None] * numbers).sum(axis=1)
    return float(tries[strength.argmax()]), max(1.0, 2.0 * reach * numbers[-1])


def _limit(samples: Samples, periods: float, most: int) -> int:
    """Return the number of harmonics fitted to a record of this many periods: at most two thirds of the samples."""
    return max(0, min(most, int(samples.highest / periods), (samples.tau.size // 3 * 2 - 3) // 2))


def _climb(samples: Samples, periods: float, most: int, first: int = 1) -> Fit | None:
    """Return the fit of all harmonics: of few at first, which know the frequency well enough for more.

    Of fewer where that of all does not settle, of noise mostly; None where none does.
    """
    most = _limit(samples, periods, most)
    omega, size = math.pi * periods, min(first, most)
    last: Fit | None = None
    while size:
        following = min(2 * size, most)
        few = size < most and samples.is_long
        found = fit(samples.some if few else samples, omega, tuple(range(1, size + 1)), precision=_COARSE)
        if few and (found is None or found.frequency_error * following > _KNOWN):
            found = fit(samples, omega, tuple(range(1, size + 1)), precision=_COARSE)
        if found is None:
            return last
        if size == most:
            return found
        last, omega, size = found, found.omega, following
    return None


# --- which harmonic the strongest is ---


def _longer(samples: Samples, first: Fit, periods: float, most: int) -> Fit:
    """Return the fit whose fundamental is the strongest frequency, or a fraction of it that explains more.

    A longer period is chosen where its further harmonics lower the residual by more than chance, once in a thousand
    records, would, and which no drift explains.
    """
    penalty = math.log(most * _DEEPEST / _FALSE_PERIOD)
    told = _significant(samples, first, penalty)
    if told is None:
        sparse = fit(samples, first.omega, (1,), precision=_COARSE) or first
        left = _left(samples, sparse)
    else:
        sparse, left = told
    best, score = first, _score(samples, sparse, penalty)
    for part in range(2, min(_DEEPEST, most) + 1):
        base = periods / part
        between = [k for k in range(1, _limit(samples, base, most) + 1) if math.gcd(k, part) == 1]
        if not between or left.at(base * np.array(between)).max() < _WORTH_A_FIT * sparse.variance:
            continue
        found = _climb(samples, base, most, part)
        chosen = None if found is None else _significant(samples, found, penalty)
        if found is None or chosen is None:
            continue
        alike = _of_one_period(samples, chosen[0])
        if alike is None:
            continue
        if _telling(alike) and (other := _score(samples, alike, penalty)) < score:
            best, score = found, other
    return best


def _telling(found: Fit) -> bool:
    """Return whether the harmonics have no shorter period.

    With few periods in the record, those that a shorter one would leave out must be a tenth of all: a drift is not.
    """
    sizes, numbers = np.abs(found.amplitudes), np.array(found.numbers)
    least = _DRIFT * float(np.linalg.norm(sizes)) if found.omega < _SLOW * math.pi else 0.0
    return all(float(np.linalg.norm(sizes[numbers % prime > 0])) > least for prime in _PRIMES)


def _of_one_period(samples: Samples, found: Fit, *, trend: bool = True, precision: float = _COARSE) -> Fit | None:
    """Return the fit without harmonics whose own frequency is no multiple of that of the strongest: other sines.

    A sine that is no harmonic but near one draws the fit to itself, and both leave more than the noise.  With the
    frequency of each harmonic free they do not, and chance moves one off its place in one record of 1000.
    """
    if len(found.numbers) < 2:
        return found
    shifts, covariance, fitted, residual = freed(samples, found)
    factors = coloured(fitted, power_spectrum(samples, residual))[1:]
    numbers = np.array(found.numbers)
    strongest = int(np.abs(found.amplitudes).argmax())
    contrast = np.eye(numbers.size)
    contrast[:, strongest] -= numbers / numbers[strongest]
    moved = contrast @ shifts
    errors = np.diag(contrast @ (covariance * np.outer(factors, factors)) @ contrast.T)
    ratio = np.divide(moved**2, errors, out=np.zeros_like(moved), where=errors > 0.0)
    chances = -0.5 * fitted.free * np.log1p(ratio / fitted.free)
    alike = chances > math.log(_FALSE_PERIOD / numbers.size)
    if alike.all():
        return found
    return fit(samples, found.omega, tuple(numbers[alike].tolist()), trend=trend, precision=precision)


def _significant(samples: Samples, found: Fit, penalty: float) -> tuple[Fit, Spectrum] | None:
    """Return the fit of the harmonics that are chance at exp(-penalty) at most, and the spectrum of its residual.

    They are tested twice: the noise about those chosen is seen only once the others have been left out.
    """
    left = _left(samples, found)
    for _ in range(2):
        chances = found.with_noise(coloured(found, left)).log_chances()
        chosen = tuple(np.array(found.numbers)[chances < -penalty].tolist())
        if chosen == found.numbers:
            break
        sparse = fit(samples, found.omega, chosen, precision=_COARSE) if chosen else None
        if sparse is None:
            return None
        found, left = sparse, _left(samples, sparse)
    return found, left


def _left(samples: Samples, found: Fit) -> Spectrum:
    """Return the spectrum of the residual."""
    return power_spectrum(samples, samples.values - found.values(samples.tau))


def _score(samples: Samples, found: Fit, penalty: float) -> float:
    """Return the negative logarithm of the likelihood, with a penalty for each harmonic."""
    return 0.5 * samples.tau.size * math.log(found.squares) + penalty * len(found.numbers)


# --- which harmonics there are ---


def _kept(samples: Samples, best: Fit, tried: float, most: int, guess: float | None = None) -> PeriodicFit:
    """Return the fit of the harmonics above the noise, with a trend where there is one."""
    left = _left(samples, best)
    on_average = best.with_noise(coloured(best, left, math.inf)).log_chances()
    every = best.with_noise(coloured(best, left))
    least = math.log(FALSE_HARMONIC / len(every.numbers))
    if on_average.min() > least or on_average.min() + math.log(tried) > math.log(_FALSE_PERIOD):
        raise _without_period(samples, "noise would have as strong a frequency", guess)
    above = every.log_chances() < least
    wanders = not above.any()
    may_be_noise = wanders or every.log_chances().min() + math.log(tried) > math.log(_FALSE_PERIOD)
    above[on_average.argmin()] |= wanders
    numbers = tuple(np.array(every.numbers)[above].tolist())
    trend = every.trend_chance() < math.log(_FALSE_TREND)
    found = fit(samples, every.omega, numbers, trend=trend)
    if found is not None and found.omega > _SLOW * math.pi:
        found = _of_one_period(samples, found, trend=trend, precision=1e-4)
    if found is None:
        raise _without_period(samples, "the fit does not settle")
    left = _left(samples, found)
    factors = coloured(found, left)
    beyond: list[int] = []
    if len(every.numbers) == most:
        further = np.arange(most + 1, int(samples.highest * math.pi / found.omega) + 1)
        power = left.at(further * (found.omega / math.pi))
        beyond = further[power > found.variance * math.log(max(1, further.size) / FALSE_HARMONIC)].tolist()
    return PeriodicFit(found.with_noise(factors), every, tuple(beyond), factors, wanders, may_be_noise)


# --- spectra ---


class Spectrum(NamedTuple):
    """Power abs(sum y exp(-i omega tau))^2 / n at the frequencies ``step``, 2 ``step``, ... in periods per record."""

    step: float
    power: Floats

    def at(self, frequency: Any) -> Floats:
        """Return the power at the nearest frequencies, 0 beyond the largest."""
        place = np.rint(np.asarray(frequency) / self.step).astype(int) - 1
        return np.where(place < self.power.size, self.power[np.clip(place, 0, self.power.size - 1)], 0.0)

    @property
    def apart(self) -> tuple[Floats, Floats]:
        """The frequencies that the record tells apart, and the power there."""
        power = self.power[min(_PADDING, self.power.size) - 1 :: _PADDING]
        return np.asarray(self.step * _PADDING * np.arange(1, power.size + 1), dtype=float), power

    def within(self, low: float, high: float) -> slice:
        """Return where the frequencies lie between two others."""
        return slice(max(0, math.floor(low / self.step)), max(0, math.ceil(high / self.step) - 1))


def power_spectrum(samples: Samples, values: Floats) -> Spectrum:
    """Return the power of values at the times of the samples.

    Where the times are not even each is shared out to the two nearest points of a grid four times as fine as the median
    interval, or as fine as memory allows; the spectrum ends where that would be felt.
    """
    from scipy.fft import next_fast_len

    if samples.is_even:
        cells = samples.tau.size - 1
        return _transformed(values, cells, next_fast_len(_PADDING * cells, real=True), samples.highest, cells + 1)
    cells = int(min(_MOST_CELLS, math.ceil(8.0 / samples.interval)))
    place = (samples.tau + 1.0) * (0.5 * cells)
    left = np.minimum(place.astype(int), cells - 1)
    right = place - left
    grid = np.zeros(cells + 1)
    grid += np.bincount(left, values * (1.0 - right), cells + 1)
    grid += np.bincount(left + 1, values * right, cells + 1)
    size = next_fast_len(_PADDING * cells, real=True)
    return _transformed(grid, cells, size, min(samples.highest, cells / 8.0), samples.tau.size)


def _transformed(grid: Floats, cells: int, size: int, highest: float, count: int) -> Spectrum:
    """Return the power, up to the highest frequency, of ``count`` samples on a grid, padded to a size."""
    from scipy.fft import rfft

    step = cells / size
    found = rfft(grid, size)[1 : int(highest / step) + 1]
    return Spectrum(step, (found.real**2 + found.imag**2) / count)


class EvenBand(NamedTuple):
    """A band of a spectrum in which the power is even, except for chance, with its ends in periods per record.

    ``power`` is the mean there, and ``error`` its standard error, relative to it.
    """

    low: float
    high: float
    power: float
    error: float
    is_narrowest: bool  # too narrow to be divided once more


def even_bands(found: Spectrum) -> Iterator[EvenBand]:
    """Yield the bands of a spectrum: all of it, divided into four, and these again, where it is uneven beyond chance.

    Parts of 4, 8, 16, ... frequencies that the record tells apart are compared; no band has less than four, unless the
    spectrum has.
    """
    # At frequencies that the record tells apart the powers of even noise are independent and exponential.
    at, power = found.apart
    whole, first, left = power.size, 0, [power]
    while left:
        power = left.pop()
        is_narrowest = power.size < 4 * _IN_A_PART <= whole
        if power.size >= 4 * _IN_A_PART and _is_uneven(power):
            left.extend(np.array_split(power, 4)[::-1])
            continue
        last = first + power.size - 1
        yield EvenBand(
            float(at[first]), float(at[last]), float(power.mean()), 1.0 / math.sqrt(power.size), is_narrowest
        )
        first = last + 1


def fine_bands(found: Spectrum) -> Iterator[tuple[float, float]]:
    """Yield middle and mean power, plus its standard error, of bands of `IN_A_FINE_BAND` frequencies or more.

    They overlap, so that about every frequency there is one.
    """
    at, power = found.apart
    step = max(IN_A_FINE_BAND // 4, math.ceil(power.size / _FINE))
    width = min(power.size, max(IN_A_FINE_BAND, 2 * step))
    whole = np.concatenate([[0.0], np.cumsum(power)])
    for first in range(0, power.size - width + 1, step):
        mean = float(whole[first + width] - whole[first]) / width
        yield float(at[first : first + width].mean()), mean * (1.0 + 1.0 / math.sqrt(width))


def _is_uneven(power: Floats) -> bool:
    """Return whether parts of one of the widths differ beyond chance: all of them, or one from the rest."""
    # Bartlett's test: of m means of k exponential powers each, 2 k sum(log(mean of all) - log(mean)), over
    # 1 + (m + 1) / 6 m k, is distributed as chi squared with m - 1 degrees of freedom, almost.  It finds slopes.  A
    # narrow band that rises or falls is found by its own mean, k times which is distributed as a gamma of order k;
    # such parts overlap by half, so that no band lies between two.
    from scipy.special import chdtri, gammainc, gammaincc

    if not power.any():
        return False
    whole = np.concatenate([[0.0], np.cumsum(power / power.mean())])
    widths = [_IN_A_PART << k for k in range(int(math.log2(power.size // _IN_A_PART)))]  # two parts or more
    chance = _UNEVEN_BAND / len(widths)  # of each width
    for width in widths:
        number = power.size // width
        k = power.size / number
        ends = np.rint(np.linspace(0.0, power.size, 2 * number + 1)).astype(int)
        parts = np.maximum(_NOTHING, (whole[ends[2:]] - whole[ends[:-2]]) / (ends[2:] - ends[:-2]))
        spread = -2.0 * k * float(np.log(parts[::2]).sum()) / (1.0 + (number + 1.0) / (6.0 * number * k))
        if spread > chdtri(number - 1.0, 0.5 * chance):
            return True
        # Half of the chance is shared out to two sides of twice as many parts.
        if min(gammaincc(k, k * parts.max()), gammainc(k, k * parts.min())) < 0.125 * chance / number:
            return True
    return False


def coloured(found: Fit, residual: Spectrum, nearest: float = _NEAREST) -> Floats:
    """Return how many times the noise about frequency 0 and about each harmonic exceeds its average, in amplitude.

    1 where the excess may be chance.  The noise about a harmonic is the mean power of the residual on both sides,
    except for what the fit has taken out, within ``nearest`` frequencies that the record tells apart, twice as many and
    so on up to half the fundamental.  The narrowest counts whose excess is chance once in a thousand records, as a band
    of noise may be narrow.
    """
    from scipy.special import chdtri

    # The power of white noise over its variance, averaged over n / 2 independent frequencies, is chi^2 of n degrees of
    # freedom over n; the chance is shared out among the averages.  An error from so few is more often too small: over
    # an average with n degrees of freedom the square of an error is n / (n - 2) on average, as in Student's t.
    base = found.omega / math.pi
    free = np.ones(residual.power.size, dtype=bool)
    for number in (0, *found.numbers):
        free[residual.within(number * base - 0.75, number * base + 0.75)] = False
    widest = max(2.0 * _NEAREST, 0.5 * base)
    narrower = math.ceil(math.log2(max(1.0, widest / nearest)))
    reaches = [nearest * 2.0**place for place in range(narrower)] + [widest]
    factors = np.ones(len(found.numbers) + 1)
    for place, number in enumerate((0, *found.numbers)):
        for reach in reaches:
            about = residual.within(number * base - reach, number * base + reach)
            power = residual.power[about][free[about]]
            freedom = 2.0 * power.size * residual.step
            if freedom < _LEAST_FREEDOM:
                continue
            ratio = float(power.mean()) / found.variance
            if ratio > chdtri(freedom, _COLOURED / len(reaches)) / freedom:
                factors[place] = math.sqrt(ratio * freedom / max(freedom - 2.0, 0.5))
                break
    return factors
