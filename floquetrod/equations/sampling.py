"""Expansions of matrices that functions compute: one Fourier series, or pieces of the period between jumps."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS
from floquetrod.equations import matrices
from floquetrod.equations.complex_form import complex_matrix, real_matrix
from floquetrod.equations.matrices import Matrix
from floquetrod.equations.pieces import MOST_PIECES, Pieces, Varying

Function = Callable[[float], Any]

_FIRST_SAMPLES, _MOST_SAMPLES = 64, 2048  # of a function, over its period
_TRIALS = 24  # instants between the samples at which the series is tried
_GOLDEN = 0.6180339887498949  # whose multiples, less whole numbers, lie nowhere close together
_NEGLIGIBLE = 4.0 * EPS  # part of the largest coefficient: harmonics below it are rounding
_REQUIRED_DECAY = 1e-10  # part of the largest coefficient: where the last harmonics exceed it, the series is refused

_NODES, _TRIALS_IN_A_PIECE = 96, 48  # instants at which a piece is fitted, and tried
_HARMONICS = (0, 2, 4, 8, 12)  # of the fits to a piece that are tried in turn (a choice)
_ROUNDED = 64.0 * EPS  # part of the largest value: a fit that misses less is exact to rounding
_LARGEST_FIT = 100.0  # sum of a fit's coefficients over the largest value: with larger ones it loses digits (a choice)
_SHORTEST = 2.0**-12  # part of the period: a piece that is not smooth over it has a jump (a choice)


class Sampled(NamedTuple):
    """A function expanded: pieces of its period, and an estimate of the error of their entries."""

    pieces: Pieces
    error: float


def expanded(function: Any, period: Any, jumps: Any, most: int, *, complex_too: bool = False) -> Sampled:
    """Return a function's matrix, at most ``most`` rows, in pieces that end at its ``jumps``; without any in one.

    With ``complex_too`` it may be complex.
    """
    validate.function("function", function)
    period = float(matrices.periods(validate.positive("period", period)))
    instants = [validate.finite(f"jumps[{i}]", t) for i, t in enumerate(validate.sequence("jumps", jumps))]
    for i, t in enumerate(instants):
        if not 0.0 <= t < period:
            raise ValueError(f"jumps[{i}] must lie within a period, from 0 to below {period:g}, got {t!r}")
    start = 0.5 * min(filter(None, instants), default=0.0)  # where it does not jump
    first = matrices.square(f"function({start:g})", function(start), most=most, complex_too=complex_too)
    if first.ndim != 2:
        raise ValueError(f"function must return one square matrix, got shape {first.shape}")
    if not (complex_too and _is_complex(function, [start, start + _GOLDEN * period])):
        return _of_real(function, period, instants, first.shape)
    n = len(first)
    sampled = _of_real(lambda t: _real_form(function, t, n), period, instants, (2 * n, 2 * n))
    pieces = tuple((duration, value.mapped(complex_matrix, complex_matrix)) for duration, value in sampled.pieces)
    return sampled._replace(pieces=pieces)


def _is_complex(function: Function, instants: list[float]) -> bool:
    """Return whether a function returns complex numbers, be they real at one instant."""
    return any(np.asarray(function(t)).dtype.kind == "c" for t in instants)


def _real_form(function: Function, t: float, order: int) -> Matrix:
    """Return the real form of a complex matrix at an instant, checked."""
    value = matrices.square(f"function({t:g})", function(t), most=2 * matrices.MOST_EQUATIONS, complex_too=True)
    if value.shape != (order, order):
        raise ValueError(f"function must always return shape {(order, order)}, got {value.shape} at t = {t:g}")
    return real_matrix(value)


def _of_real(function: Function, period: float, instants: list[float], shape: tuple[int, ...]) -> Sampled:
    """Return a real matrix in pieces that end at instants, without any in one."""
    if instants:
        return _in_pieces(function, period, instants, shape)
    return smooth(lambda times: _samples(function, times, shape), period)


def smooth(sampled: Callable[[NDArray[Any]], Matrix], period: float, required: float = _REQUIRED_DECAY) -> Sampled:
    """Return a smooth matrix as one Fourier series, from a function that returns its values (k, n, n) at times (k,).

    ``required`` is the part of the largest value that the series may miss; ValueError where it misses more.
    """
    # series_k = (1 / count) sum_j values_j exp(-2 pi i j k / count): the trapezoidal rule, whose error falls
    # exponentially with count for a smooth function (L. N. Trefethen and J. A. C. Weideman, SIAM Review 56 (2014) 385,
    # doi:10.1137/130932132).  values (count, n, n) are at equal steps; count doubles, old values kept, until the last
    # quarter of the harmonics is negligible, or no longer falls (noise), and the series meets the function at
    # ``shares`` of the period, too.  These are irregular (golden section): a harmonic of order above count / 2 takes
    # the values of a lower one at all equal steps, and is seen only between them.  size is the largest entry of values,
    # gap how far the function is from periodic.
    count = _FIRST_SAMPLES
    values = sampled(np.arange(count) * (period / count))
    size = max(float(np.abs(values).max()), 5e-324)
    gap = _gap(sampled, period, np.array([0.0, 0.37, 0.71]), size)
    shares = np.arange(1, _TRIALS + 1) * _GOLDEN % 1.0
    trials = sampled(shares * period)
    size, before_rest = max(size, float(np.abs(trials).max())), 0.0
    while True:
        series = np.fft.rfft(values, axis=0) / count
        top = 3 * count // 8  # harmonics from here on are the last quarter of the resolved ones
        sizes = np.abs(series).max(axis=(1, 2))
        rest = float(sizes[top:].max())
        floor = max(_NEGLIGIBLE * size, 2.0 * rest)
        kept = int(np.flatnonzero(sizes[:top] > floor).max(initial=0))
        waves = np.exp(2j * math.pi * shares[:, None] * np.arange(kept + 1))
        waves[:, 1:] *= 2.0
        missed = float(np.abs(np.tensordot(waves, series[: kept + 1], axes=1).real - trials).max())
        # Harmonics that no longer fall as samples double are the noise of the function's values.
        noise = rest <= _REQUIRED_DECAY * size and rest > 0.4 * before_rest > 0.0
        if (rest <= _NEGLIGIBLE * size or noise) and missed <= 16.0 * (math.sqrt(count) * floor + gap):
            break
        if count == _MOST_SAMPLES:
            if max(rest, missed) > required * size:
                raise ValueError(
                    f"function is not smooth: with harmonics up to {top} its series still misses "
                    f"{max(rest, missed) / size:.1g} of its largest value; name its jumps and kinks in jumps"
                )
            break
        count, before_rest = 2 * count, rest
        between = sampled(np.arange(1, count, 2) * (period / count))
        values = np.stack([values, between], axis=1).reshape(count, *values.shape[1:])
        size = max(size, float(np.abs(between).max()))
    neglected = 2.0 * float(np.abs(series[kept + 1 :]).sum(axis=0).max())
    tidy = _tidy(values, trials)
    waves = series[1 : kept + 1]
    varying = Varying(tidy(series[0].real), None, tidy(2.0 * waves.real), tidy(-2.0 * waves.imag))
    return Sampled(((period, varying),), 2.0 * (neglected + missed + (kept + 1) * EPS * size) + gap)


def _gap(sampled: Callable[[NDArray[Any]], Matrix], period: float, shares: NDArray[Any], size: float) -> float:
    """Return the largest difference of values a period apart; ValueError where it exceeds noise.

    At a jump rounding decides between the two sides, so values differ there in a function that is periodic: then they
    agree at all other instants.
    """
    gaps = _gaps(sampled, period, shares)
    gap, noise = float(gaps.max()), 1e-9 * size
    if gap <= noise:
        return gap
    others = np.arange(1, _TRIALS + 1) * _GOLDEN % 1.0
    if float(_gaps(sampled, period, others).max()) <= noise:
        instant = float(shares[gaps.argmax()]) * period
        raise ValueError(
            f"function jumps at t = {instant:.6g}, which is not among its jumps: values a period of {period:g} apart "
            f"agree everywhere else; name all its jumps within a period, such as jumps=[{instant:.6g}, ...]"
        )
    raise ValueError(
        f"function is not periodic: values a period of {period:g} apart differ by {gap:.3g}, of {size:.3g}"
    )


def _gaps(sampled: Callable[[NDArray[Any]], Matrix], period: float, shares: NDArray[Any]) -> NDArray[Any]:
    """Return the largest difference of values a period apart, at instants ``shares`` of the period."""
    periods = np.where(shares < 0.7, 1.0, -1.0)  # later and earlier ones
    before, again = sampled(shares * period), sampled((shares + periods) * period)
    return np.asarray(np.abs(again - before).max(axis=(1, 2)))


def _in_pieces(function: Function, period: float, jumps: list[float], shape: tuple[int, ...]) -> Sampled:
    """Return a function in pieces between its jumps, cut further where a few harmonics do not describe them."""
    whole = Fraction(period)
    edges = sorted({Fraction(0), *map(Fraction, jumps), whole})
    waiting = [(low, high - low) for low, high in pairwise(edges)][::-1]
    shares = np.array([float((0.7 * float(low) + 0.3 * float(high)) / period) for low, high in pairwise(edges)])
    size = max(float(np.abs(_samples(function, shares * period, shape)).max()), 5e-324)
    gap = _gap(lambda times: _samples(function, times, shape), period, shares[[0, len(shares) // 2, -1]], size)
    fitted: list[tuple[Fraction, Varying]] = []
    error = 0.0
    while waiting:
        begin, length = waiting.pop()
        fit = _fit(function, period, begin, length, shape) if 2 * length <= whole else None
        if fit is None:
            if length < _SHORTEST * whole or len(fitted) + len(waiting) > MOST_PIECES - 2:
                raise ValueError(
                    f"function is not smooth near t = {float(begin):.6g}, which is not among its jumps; name it there"
                )
            waiting += [(begin + length / 2, length / 2), (begin, length / 2)]
            continue
        fitted.append((length, fit[0]))
        error = max(error, fit[1])
    return Sampled(tuple(fitted), error + gap)


def _fit(
    function: Function, period: float, begin: Fraction, length: Fraction, shape: tuple[int, ...]
) -> tuple[Varying, float] | None:
    """Return start, slope and harmonics fitted to a piece by least squares, and their error; None without a fit.

    Harmonics of the whole period describe any smooth function over half of it or less: it may be extended smoothly.
    D. Huybrechs, SIAM J. Numer. Anal. 47 (2010) 4326, doi:10.1137/090752456.
    """
    inner = 0.5 * (1.0 - np.cos(math.pi * (np.arange(_NODES) + 0.5) / _NODES))
    between = np.sort([1e-9, 1.0 - 1e-9, *(np.arange(1, _TRIALS_IN_A_PIECE) * _GOLDEN % 1.0)])
    begins, lasts = float(begin), float(length)
    times, tried = begins + lasts * inner, begins + lasts * between
    values, trials = _samples(function, times, shape), _samples(function, tried, shape)
    if (values == values[0]).all() and (trials == values[0]).all():
        return Varying(values[0]), 0.0
    size = max(float(np.abs(values).max()), float(np.abs(trials).max()))
    flat, before = values.reshape(len(values), -1), math.inf
    for count in _HARMONICS:
        design, check = (_columns((t - begins) / lasts, t / period, count) for t in (times, tried))
        solved = np.linalg.lstsq(design, flat, rcond=1e-14)[0]
        missed = float(np.abs(check @ solved - trials.reshape(len(trials), -1)).max())
        total = float(np.abs(solved).sum(axis=0).max())
        noise = missed <= _REQUIRED_DECAY * size and missed > 0.4 * before
        if total <= _LARGEST_FIT * size and (missed <= _ROUNDED * size or (noise and count > 4)):
            tidy = _tidy(values, trials)
            rows = tidy(np.asarray(solved, dtype=np.float64).reshape(-1, *shape))
            value = Varying(None, rows[1] / lasts, rows[2 : 2 + count], rows[2 + count :], start=rows[0])
            return value, 2.0 * missed + 4.0 * EPS * total
        before = missed
    return None


def _columns(local: NDArray[Any], turns: NDArray[Any], count: int) -> Matrix:
    """Return the columns of a fit: 1, the part of the piece that is past, and harmonics."""
    angles = 2.0 * math.pi * turns[:, None] * np.arange(1, count + 1)
    return np.hstack([np.ones((len(local), 1)), local[:, None], np.cos(angles), np.sin(angles)])


def _tidy(*samples: Matrix) -> Callable[[Matrix], Matrix]:
    """Return the function that symmetrises matrices where all samples are symmetric, or skew; else leaves them."""
    if all(matrices.symmetric(values) for values in samples):
        return lambda values: 0.5 * (values + np.swapaxes(values, -1, -2))
    if all(np.array_equal(values, -np.swapaxes(values, -1, -2)) for values in samples):
        return lambda values: 0.5 * (values - np.swapaxes(values, -1, -2))
    return np.asarray


def _samples(function: Function, times: NDArray[Any], shape: tuple[int, ...]) -> Matrix:
    """Return the matrix at several instants, checked."""
    values = []
    for t in times.tolist():
        value = matrices.square(f"function({t:g})", function(t), most=2 * matrices.MOST_EQUATIONS)
        if value.shape != shape:
            raise ValueError(f"function must always return shape {shape}, got {value.shape} at t = {t:g}")
        values.append(value)
    return np.array(values)
