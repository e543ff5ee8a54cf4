"""Coefficients of systems in pieces of the period: matrices with a start, a slope and harmonics on each of them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, NoReturn, TypeVar

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Bools, Complexes, Floats, Ints
from floquetrod._util.calling import constructor_hints
from floquetrod._util.content import ByContent
from floquetrod.equations import matrices
from floquetrod.equations.complex_form import complex_matrix
from floquetrod.equations.matrices import Matrix

System = TypeVar("System")
OfMatrix = Callable[[Matrix], Matrix]

MOST_PIECES = 1024
"""Most pieces of a period (a choice)."""

Pieces = tuple[tuple[Any, "Varying"], ...]
"""Pairs of a duration, a double, a Fraction or an array of a batch, and the matrix over it."""


def one_of_mean_and_start(mean: Any, start: Any) -> tuple[str, Any]:
    """Return the name and the value of the one given argument, mean or start; TypeError for both or none."""
    if (mean is None) == (start is None):
        given = "none" if mean is None else "both"
        raise TypeError(f"a piece must have either its mean, where it has no slope, or its start, got {given}")
    return ("mean", mean) if start is None else ("start", start)


def refuse_mean_with_slope(length: str, mean: str = "mean", start: str = "start") -> NoReturn:
    """Raise ValueError about a mean beside a slope, naming both readings."""
    raise ValueError(
        f"{mean} beside a slope may be read in two ways: give {start} = {mean} where it is the value at the beginning "
        f"of the piece, or {start} = {mean} - slope * {length} / 2 where it is the mean over the piece"
    )


@constructor_hints()
@dataclass(frozen=True, eq=False, repr=False)
class Varying(ByContent):
    """A matrix that varies over a piece of the period, for ``from_pieces`` of `HillSystem` and `PeriodicSystem`.

    start + slope (t - b) + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t, b the time at which the piece begins,
    w = 2 pi / period of the whole period, and t from its beginning.  Complex matrices are for `PeriodicSystem` alone.

    Parameters
    ----------
    mean : array_like (..., n, n), optional
        Constant part of a matrix without slope: give either ``mean`` or ``start``.
    slope : array_like (..., n, n), optional
        Change per unit of time; none by default, and None where it is zero.
    cosines : sequence of array_like (..., n, n)
        Coefficients of the cosines of the whole period, from the first harmonic on; none by default.
    sines : sequence of array_like (..., n, n)
        Coefficients of the sines of the whole period, from the first harmonic on; none by default.
    start : array_like (..., n, n), optional
        Value of start + slope (t - b) at the beginning of the piece; beside a slope ``mean`` is refused, since a ramp
        has its mean half the piece later.

    Examples
    --------
    >>> Varying(start=[[1.0]], slope=[[-0.5]])
    Varying(start=[[1.0]], slope=[[-0.5]])
    >>> Varying([[1.0]], cosines=[[[0.5]]])
    Varying(start=[[1.0]], cosines=[[[0.5]]])
    """

    start: Matrix
    slope: Matrix | None = None
    cosines: tuple[Matrix, ...] = ()
    sines: tuple[Matrix, ...] = ()

    def __init__(
        self, mean: Any = None, slope: Any = None, cosines: Any = (), sines: Any = (), *, start: Any = None
    ) -> None:
        """Check and copy the matrices."""
        most = 2 * matrices.MOST_EQUATIONS
        name, value = one_of_mean_and_start(mean, start)
        beginning = matrices.square(name, value, most=most, complex_too=True)
        order = beginning.shape[-1]
        ramp = None if slope is None else matrices.square("slope", slope, order, name, most, complex_too=True)
        if ramp is not None and not ramp.any():
            ramp = None
        if ramp is not None and name == "mean":
            refuse_mean_with_slope("duration")
        series = {
            series_name: matrices.by_harmonic(series_name, values, order, name, complex_too=True)
            for series_name, values in (("cosines", cosines), ("sines", sines))
        }
        self.__setstate__({"start": beginning, "slope": ramp, **series})

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over the matrices, closed to writing."""
        vars(self).update(state)
        for matrix in self.matrices:
            matrix.flags.writeable = False

    @property
    def matrices(self) -> tuple[Matrix, ...]:
        """The start, the slope where there is one, cosines and sines."""
        return (self.start, *(() if self.slope is None else (self.slope,)), *self.cosines, *self.sines)

    @property
    def slope_or_zero(self) -> Matrix:
        """The slope, zeros without one."""
        return np.zeros(self.start.shape) if self.slope is None else self.slope

    @property
    def is_constant(self) -> bool:
        """Whether the matrix is one and the same all over the piece."""
        return self.slope is None and not any(matrix.any() for matrix in (*self.cosines, *self.sines))

    def mapped(self, of_start: Any, of_others: Any) -> Varying:
        """Return the matrix with ``of_start`` applied to the start and ``of_others`` to all other coefficients."""
        slope = None if self.slope is None else of_others(self.slope)
        cosines, sines = ([of_others(m) for m in series] for series in (self.cosines, self.sines))
        return Varying(start=of_start(self.start), slope=slope, cosines=cosines, sines=sines)

    def __repr__(self) -> str:
        """Return the constructor's call, large matrices by their shape."""
        return matrices.constructor_call(self, ["start", "slope", "cosines", "sines"])


class TimedPiece(NamedTuple):
    """A piece of one system: mean + slope (t - origin) + sum_k Re(Z_k exp(i k w t)) for ``length`` from ``begin`` on.

    The instants are exact, and t counts from the beginning of the period, as the phase of harmonics does.
    """

    begin: Fraction
    length: Fraction
    mean: Matrix
    slope: Matrix | None
    harmonics: Complexes
    origin: Fraction

    @property
    def is_constant(self) -> bool:
        """Whether the matrix is one and the same all over the piece."""
        return self.slope is None and not len(self.harmonics)

    @property
    def size(self) -> Matrix:
        """Bound of the magnitude of each entry, to rounding."""
        farthest = float(max(abs(self.begin - self.origin), abs(self.begin + self.length - self.origin)))
        slope = 0.0 if self.slope is None else np.abs(self.slope) * farthest
        return np.asarray(np.abs(self.mean) + slope + np.abs(self.harmonics).sum(axis=0))

    @property
    def beginning(self) -> Matrix:
        """The matrix at the beginning without harmonics, rounded."""
        into = float(self.begin - self.origin)
        return self.mean if self.slope is None or not into else self.mean + self.slope * into

    def at(self, into: Floats, period: float) -> Matrix:
        """Return the matrix, of shape (*into.shape, n, n), at times from the beginning of the piece."""
        phase = (2.0 * math.pi / period) * (float(self.begin) + into)
        waves = np.exp(1j * phase[..., None] * np.arange(1, len(self.harmonics) + 1))
        values = np.asarray(self.mean + np.einsum("...k,kij->...ij", waves, self.harmonics).real)
        if self.slope is None:
            return values
        return np.asarray(values + self.slope * (into + float(self.begin - self.origin))[..., None, None])


class PieceArrays(NamedTuple):
    """Pieces of many systems as arrays, for the kernels of maps.

    On piece j, t from its beginning, A = mean[:, j] + slope[:, j] t + Re sum_k harmonics[:, j, k-1] exp(i k w t),
    w = 2 pi / period.
    """

    mean: Floats  # (b, P, N, N), real
    slope: Floats | None  # (b, P, N, N), real; None for zero
    harmonics: Complexes  # (b, P, H, N, N), complex
    length: Floats  # (b, P), durations
    period: Floats  # (b,), periods of the harmonics

    @property
    def sizes(self) -> Floats:
        """Bounds (b, P, N, N) of the magnitudes of A's entries."""
        sizes = np.abs(self.mean) + np.abs(self.harmonics).sum(axis=2)
        return np.asarray(sizes if self.slope is None else sizes + np.abs(self.slope) * self.length[..., None, None])

    def some(self, chosen: slice | Bools | Ints) -> PieceArrays:
        """Return the pieces of the systems ``chosen``."""
        mean, slope, harmonics, length, period = self
        slope = None if slope is None else slope[chosen]
        return PieceArrays(mean[chosen], slope, harmonics[chosen], length[chosen], period[chosen])

    def scaled(self, scaling: Floats) -> PieceArrays:
        """Return the pieces in coordinates x / scaling, scaling (b, N)."""
        ratio = scaling[:, None, None, :] / scaling[:, None, :, None]
        slope = None if self.slope is None else self.slope * ratio
        return PieceArrays(self.mean * ratio, slope, self.harmonics * ratio[:, :, None], self.length, self.period)


def read(pieces: Any) -> Pieces:
    """Return the argument ``pieces``, checked: pairs of a duration and a matrix, or a `Varying`."""
    example = "pieces must be a sequence of (duration, matrix)"
    if isinstance(pieces, str | bytes) or not validate.iterable(pieces):
        raise TypeError(f"{example}, got {validate.short(pieces)}")
    checked_pieces: list[tuple[Any, Varying]] = []
    for i, pair in enumerate(validate.listed("pieces", pieces, MOST_PIECES, "pieces")):
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise TypeError(f"{example}, got {validate.short(pair)} as pieces[{i}]")
        value = pair[1] if isinstance(pair[1], Varying) else Varying(_constant(f"pieces[{i}][1]", pair[1]))
        if checked_pieces and value.start.shape[-1] != checked_pieces[0][1].start.shape[-1]:
            order = checked_pieces[0][1].start.shape[-1]
            raise ValueError(f"pieces[{i}][1] must be {order} x {order} as pieces[0][1] is, got {value.start.shape}")
        checked_pieces.append((_duration(f"pieces[{i}][0]", pair[0]), value))
    if not checked_pieces:
        raise ValueError(f"{example}, one at least, got none")
    return tuple(checked_pieces)


def _constant(name: str, value: Any) -> Matrix:
    """Return the constant matrix of a piece."""
    return matrices.square(name, value, complex_too=True)


def _duration(name: str, value: Any) -> Any:
    """Return the duration of a piece, exactly: a double, a Fraction that is no double, or an array of a batch."""
    if isinstance(value, Fraction):
        nearest = matrices.periods(float(value), name)
        return nearest if value == nearest else value
    return matrices.periods(value, name)


def total(durations: list[Any]) -> float | Floats:
    """Return the sum of durations, rounded once."""
    shape = np.broadcast_shapes(*map(np.shape, durations))
    if not shape:
        return float(sum(map(Fraction, durations)))
    lengths = np.array([np.broadcast_to(float(d) if isinstance(d, Fraction) else d, shape) for d in durations])
    if len(lengths) <= 2:
        return np.asarray(lengths.sum(axis=0))
    return np.array([math.fsum(column) for column in lengths.reshape(len(lengths), -1).T.tolist()]).reshape(shape)


def one_series(pieces: Pieces) -> Varying | None:
    """Return the only piece of a period where it is one Fourier series after all, else None."""
    duration, value = pieces[0]
    return value if len(pieces) == 1 and value.slope is None and not isinstance(duration, Fraction) else None


def made(kind: Callable[..., System], pieces: Any, **others: Any) -> System:
    """Return a system of a kind from the pieces of its matrix, as a Fourier series where it is one."""
    checked_pieces = read(pieces)
    period, single = total([duration for duration, _ in checked_pieces]), one_series(checked_pieces)
    if single is not None:
        return kind(single.start, single.cosines, single.sines, period=period, **others)
    return kind(average(checked_pieces, period), period=period, pieces=checked_pieces, **others)


def mapped(
    kind: Callable[..., System], system: Any, of_mean: OfMatrix, of_other: OfMatrix = np.asarray, **others: Any
) -> System:
    """Return a system of a kind whose matrices are functions of another's: of means, and of all others."""
    if system.pieces:
        return made(kind, [(duration, value.mapped(of_mean, of_other)) for duration, value in system.pieces], **others)
    series = [[of_other(matrix) for matrix in coefficients] for coefficients in (system.cosines, system.sines)]
    return kind(of_mean(getattr(system, system.MEAN)), *series, period=system.period, **others)


def average(pieces: Pieces, period: Any) -> Matrix:
    """Return the mean over the period."""
    first = pieces[0][1]
    if all(value.is_constant and np.array_equal(value.start, first.start) for _, value in pieces):
        return np.array(first.start)
    mean: Any = 0.0
    end = np.zeros(np.shape(period))
    for duration, value in pieces:
        begin, length = end, np.asarray(duration, dtype=float)
        end = begin + length
        share = (length / period)[..., None, None]
        middle = value.start if value.slope is None else value.start + value.slope * (0.5 * length)[..., None, None]
        mean = mean + share * middle
        for coefficients, function in ((value.cosines, np.sin), (value.sines, lambda angle: -np.cos(angle))):
            for k, matrix in enumerate(coefficients, start=1):
                w = 2.0 * math.pi * k / period
                mean = mean + ((function(w * end) - function(w * begin)) / (w * period))[..., None, None] * matrix
    return np.asarray(mean)


def in_time(system: Any) -> tuple[TimedPiece, ...]:
    """Return the pieces of a system, or of its real form if it is complex; a single one for a Fourier series."""
    matrices.require_one(system)
    system = real_form(system)
    if not system.pieces:
        mean = np.asarray(getattr(system, system.MEAN))
        return (TimedPiece(Fraction(0), Fraction(system.period), mean, None, system.harmonics, Fraction(0)),)
    timed, begin = [], Fraction(0)
    for duration, value in system.pieces:
        length = Fraction(duration)
        waves = matrices.harmonic_amplitudes(value.cosines, value.sines, (), system.order)
        timed.append(TimedPiece(begin, length, value.start, value.slope, waves, begin))
        begin += length
    return tuple(timed)


def exact_period(system: Any) -> Fraction:
    """Return the period of one system: the exact sum of the durations of its pieces."""
    return sum((Fraction(duration) for duration, _ in system.pieces), Fraction(0)) or Fraction(system.period)


def between(pieces: tuple[TimedPiece, ...], start: Fraction, length: Fraction) -> tuple[TimedPiece, ...]:
    """Return the pieces between ``start``, in the period, and ``length`` later, cut exactly."""
    if len(pieces) == 1 and pieces[0].slope is None:
        return (pieces[0]._replace(begin=start, length=length),)
    period = pieces[-1].begin + pieces[-1].length
    inside = []
    for turn in (0, period):
        for piece in pieces:
            low, high = max(piece.begin + turn, start), min(piece.begin + piece.length + turn, start + length)
            if low < high:
                inside.append(piece._replace(begin=low - turn, length=high - low))
    return tuple(inside)


def arrays_of(pieces: tuple[TimedPiece, ...], period: Fraction) -> PieceArrays:
    """Return pieces of one system, in the order in which they act, as arrays of a batch of one."""
    order, waves = pieces[0].mean.shape[-1], max(len(piece.harmonics) for piece in pieces)
    slope = np.zeros((1, len(pieces), order, order))
    harmonics = np.zeros((1, len(pieces), waves, order, order), dtype=complex)
    for j, piece in enumerate(pieces):
        if piece.slope is not None:
            slope[0, j] = piece.slope
        turns = [float(k * piece.begin / period % 1) for k in range(1, len(piece.harmonics) + 1)]
        harmonics[0, j, : len(turns)] = piece.harmonics * np.exp(2j * math.pi * np.asarray(turns))[:, None, None]
    mean = np.stack([piece.beginning for piece in pieces])[None]
    length = np.asarray([[float(piece.length) for piece in pieces]])
    return PieceArrays(mean, slope if slope.any() else None, harmonics, length, np.asarray([float(period)]))


def real_form(system: Any) -> Any:
    """Return the real system of twice the order that a complex system of first order is; a real one unchanged."""
    return getattr(system, "real_form", system)


def from_instant(system: Any, start: Fraction, length: Fraction) -> tuple[PieceArrays, float]:
    """Return the pieces of one first-order system between two instants, and the error of their entries."""
    if not system.pieces and not start and length == system.period:
        return of_batch(system), system.coefficient_error
    inside = between(in_time(system), start, length)
    rounding = max(
        (EPS * float(p.size.max()) for p in inside if p.slope is not None and p.begin != p.origin), default=0.0
    )
    return arrays_of(inside, exact_period(system)), system.coefficient_error + rounding


def of_batch(system: Any) -> PieceArrays:
    """Return the pieces of a system or of a batch, of the real form if complex, flat in the order of C."""
    system = real_form(system)
    if system.pieces and not system.shape:
        return arrays_of(in_time(system), exact_period(system))
    size, order, flat = math.prod(system.shape), system.order, functools.partial(matrices.flat, shape=system.shape)
    period = flat(system.period, tail=0)
    if not system.pieces:
        mean = flat(getattr(system, system.MEAN), tail=2)[:, None]
        harmonics = flat(system.harmonics, tail=3)[:, None]
        return PieceArrays(mean, None, harmonics, period[:, None], period)
    waves = max(max(len(value.cosines), len(value.sines)) for _, value in system.pieces)
    shape = (size, len(system.pieces))
    mean, slope = np.zeros((2, *shape, order, order))
    harmonics, length = np.zeros((*shape, waves, order, order), dtype=complex), np.zeros(shape)
    begin = np.zeros(size)
    for j, (duration, value) in enumerate(system.pieces):
        mean[:, j], length[:, j] = flat(value.start, tail=2), flat(np.asarray(duration, dtype=float), tail=0)
        if value.slope is not None:
            slope[:, j] = flat(value.slope, tail=2)
        series = matrices.harmonic_amplitudes(value.cosines, value.sines, system.shape, order)
        count = series.shape[-3]
        turned = np.exp(2j * math.pi * (begin / period)[:, None] * np.arange(1, count + 1))
        harmonics[:, j, :count] = flat(series, tail=3) * turned[..., None, None]
        begin = begin + length[:, j]
    return PieceArrays(mean, slope if slope.any() else None, harmonics, length, period)


def fourier(system: Any, count: int) -> Complexes:
    """Return Fourier amplitudes (count, n, n) of the coefficient of one system in pieces, or all of a series.

    By Gauss's rule on each piece, with enough nodes for ten digits: they name resonances, no more.
    """
    system = real_form(system)
    if not system.pieces:
        return np.asarray(system.harmonics)
    period = float(system.period)
    nodes, weights = np.polynomial.legendre.leggauss(2 * count + 16)
    amplitudes = np.zeros((count, system.order, system.order), dtype=complex)
    for piece in in_time(system):
        local = 0.5 * float(piece.length) * (1.0 + nodes)
        t = float(piece.begin) + local
        waves = np.exp(-2j * math.pi / period * np.arange(1, count + 1)[:, None] * t)
        amplitudes += np.tensordot(waves * (weights * float(piece.length) / period), piece.at(local, period), axes=1)
    return amplitudes


def value_at(system: Any, times: Any) -> Floats:
    """Return the coefficient of one system at times, (*times.shape, n, n); at a jump the mean of both sides."""
    if real_form(system) is not system:
        return complex_matrix(value_at(real_form(system), times))
    pieces, period = in_time(system), float(system.period)
    times = validate.array("t", times, least=-1e14 * period, largest=1e14 * period)
    if not system.pieces:
        return pieces[0].at(times, period)
    phase = times - period * np.floor(times / period)
    result, weight = np.zeros((*phase.shape, system.order, system.order)), np.zeros(phase.shape)
    for j, piece in enumerate(pieces):
        low, high = float(piece.begin), float(piece.begin + piece.length)
        for shift in (0.0, period) if j + 1 == len(pieces) else (0.0,):  # the end of the period is its beginning
            t = phase + shift
            here = (low <= t) & (t <= high)
            result[here] += piece.at(t[here] - low, period)
            weight[here] += 1.0
    return np.asarray(result / weight[..., None, None])


def checked(pieces: Any, others: dict[str, Any], mean: str) -> Pieces:
    """Return the argument ``pieces`` of a constructor, checked against its mean, its series and its period."""
    if isinstance(pieces, tuple) and not pieces:
        return ()
    checked_pieces = read(pieces)
    period = total([duration for duration, _ in checked_pieces])
    fitting = not others["cosines"] and not others["sines"] and np.array_equal(period, others["period"])
    if not (fitting and np.array_equal(average(checked_pieces, period), others[mean])):
        raise ValueError(
            f"pieces must be those of which {mean} and period are the mean and the sum, without cosines and sines; "
            "from_pieces finds these"
        )
    return checked_pieces


def even_start(pieces: tuple[TimedPiece, ...]) -> Fraction | None:
    """Return an instant, in the first half of the period, about which the pieces are exactly even; None without one.

    None, too, where they have harmonics, whose evenness rounding hides.
    """
    if any(len(piece.harmonics) for piece in pieces):
        return None
    period = pieces[-1].begin + pieces[-1].length
    for piece in pieces:
        start = piece.begin / 2  # the beginning of the period meets its mirror image, the beginning of another piece
        around = between(pieces, start, period)
        pairs = zip(around, around[::-1], strict=True)
        if all(piece.length == mirror.length and _mirrored(piece, mirror) for piece, mirror in pairs):
            return start % (period / 2)
    return None


def _mirrored(piece: TimedPiece, mirror: TimedPiece) -> bool:
    """Return whether pieces without harmonics are exactly each other's mirror image."""
    if piece.slope is None or mirror.slope is None:
        return piece.slope is None and mirror.slope is None and np.array_equal(piece.mean, mirror.mean)
    if not np.array_equal(piece.slope, -mirror.slope):
        return False
    into, out = mirror.begin - mirror.origin, piece.begin + piece.length - piece.origin
    ends = zip(piece.mean.flat, piece.slope.flat, mirror.mean.flat, strict=True)
    return all(
        Fraction(mean) + Fraction(slope) * out == Fraction(end) - Fraction(slope) * into for mean, slope, end in ends
    )


def draw(system: Any, ax: Any) -> Any:
    """Draw the entries of the periodic matrix of one system over one period, and return the axes."""
    from floquetrod.plotting.coefficient_plot import CoefficientPiece, draw_coefficients, instants

    # Of a complex system the left half of the real form, its real parts and its imaginary parts.
    is_complex = real_form(system) is not system
    pieces, mean = in_time(system), getattr(real_form(system), system.MEAN)
    shown = mean.shape[-1] // 2 if is_complex else mean.shape[-1]
    curves = []
    for piece in pieces:
        into = float(piece.length) * instants(len(piece.harmonics))
        curves.append((float(piece.begin) + into, piece.at(into, float(system.period))[..., :shown]))
    first = curves[0][1][0]
    varies = np.array([np.abs(values - first).max(axis=0) for _, values in curves]).max(axis=0) > 0.0
    chosen = varies if varies.any() else np.ones_like(varies)
    if not is_complex and all(matrices.symmetric(values) for _, values in curves):
        chosen = np.triu(chosen)
    rows, columns = np.nonzero(chosen)
    symbol = {"stiffness": "K", "mean": "A"}[system.MEAN]
    form = r"$M\ddot{q} + (C + G)\dot{q} + K(t) q = 0$" if symbol == "K" else r"$\dot{x} = A(t) x$"

    def label(i: int, j: int) -> str:
        part, row = ("Re" if i < shown else "Im", i % shown) if is_complex else ("", i)
        entry = f"{symbol}_{{{row + 1}{',' if system.order > 9 else ''}{j + 1}}}"
        return rf"$\mathrm{{{part}}}\,{entry}$" if part else f"${entry}$"

    return draw_coefficients(
        [CoefficientPiece(time, values[:, rows, columns]) for time, values in curves],
        [label(int(i), int(j)) for i, j in zip(rows, columns, strict=True)],
        time="$t$",
        axis=f"${symbol}(t)$",
        title=f"{form}, {system.variation}",
        mean=float(mean[rows[0], columns[0]]) if len(rows) == 1 else None,
        ax=ax,
    )
