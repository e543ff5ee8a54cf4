"""The method "monodromy": x(T) = Phi x(0) + p, from the map over a period of the system with its force as a state."""

from __future__ import annotations

import functools
import math
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from floquetrod._util.arrays import EPS, Complexes, Floats, norms
from floquetrod.equations import Equation, HillSystem, PeriodicSystem, matrices
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.pieces import TimedPiece
from floquetrod.floquet.kernels.system_maps import SegmentMaps, product
from floquetrod.floquet.multipliers.whole_period_maps import balanced_maps, error_stretch, seconds_needed
from floquetrod.floquet.solve import first_order_course
from floquetrod.responses.forces import Force
from floquetrod.responses.motions import PiecewiseMotion

_RTOL = 1e-14
_PHASE = 2.0  # radians, about, that solutions turn by on a segment (a choice)
_ORDER = 30  # of Taylor series on a segment: 2^30 / 30! is 4e-24
_MOST_SEGMENTS = 20_000  # (a choice: a second)
_LONGEST = 30.0  # seconds (a choice)
_MOST_PRODUCTS = 10_000_000  # of numbers, up to which errors are carried by products of all maps


class ForcedSystem(NamedTuple):
    """x' = A(t) x + B(t) y, y' = J y, in pieces of the period: a state y of one, or of a cosine and a sine."""

    pieces: tuple[TimedPiece, ...]
    period: Fraction
    states: int  # of x
    coordinates: int  # of them the first that are returned
    start: Complexes  # y at t = 0
    scale: float  # of B, and so of x
    error: float  # of A, entry by entry
    force_error: float  # of the scaled B


def forced_system(problem: Equation | HillSystem | PeriodicSystem, force: Force) -> ForcedSystem:
    """Return the system of first order that has its force as a state, of about the size of the others."""
    course = first_order_course(problem)
    n = 1 if isinstance(problem, Equation) else problem.order
    states = course.pieces[0].mean.shape[0]
    inverse: Any = np.eye(n)
    if isinstance(problem, HillSystem):
        inverse = np.linalg.inv(matrices.mass_matrix(problem))
    ends = [*(piece.begin for piece in course.pieces[1:]), course.period]
    present = tuple(
        TimedPiece(p.begin, end - p.begin, p.mean, p.slope if p.slope.any() else None, p.harmonics, p.begin)
        for p, end in zip(course.pieces, ends, strict=True)
    )
    into = np.zeros((states, n))
    into[states - n :] = inverse
    driving = _force_pieces(force, course.period, into)
    rates = np.abs(present[0].mean).sum(axis=1).max()
    size = max((float(piece.size.max()) for piece in driving), default=0.0)
    wanted = float(max(rates, 1.0 / float(course.period)))
    scale = size / wanted or 1.0
    doubt = max(float(np.abs(piece.doubt).max()) for piece in course.pieces)
    start = np.array([1.0 + 0j]) if force.frequency is None else np.array([1.0, -1j])
    edges = [*sorted({p.begin for p in present} | {p.begin for p in driving}), course.period]
    joined = []
    for low, high in pairwise(edges):
        (a,), (b,) = (by_pieces.between(each, low, high - low) for each in (present, driving))
        joined.append(_joined(a, b, scale, force.frequency))
    norm = float(np.abs(inverse).sum(axis=1).max())
    return ForcedSystem(tuple(joined), course.period, states, n, start, scale, doubt, norm * force.error / scale)


def _force_pieces(force: Force, period: Fraction, into: Floats) -> tuple[TimedPiece, ...]:
    """Return the force in pieces, as columns (states, k) of the states that drive."""
    if force.frequency is not None:  # (Re b, -Im b) times (1, -i) exp(i w t)
        columns = into @ np.stack([force.mean.real, -force.mean.imag], axis=1)
        empty = np.zeros((0, *columns.shape), dtype=complex)
        return (TimedPiece(Fraction(0), period, columns, None, empty, Fraction(0)),)

    def column(diagonal: Any) -> Any:
        return (into @ np.diagonal(diagonal, axis1=-2, axis2=-1)[..., None]) if diagonal is not None else None

    if not force.pieces:
        columns = (into @ force.mean.real)[:, None]
        harmonics = (into @ force.harmonics[..., None]).reshape(-1, len(into), 1)
        return (TimedPiece(Fraction(0), period, columns, None, harmonics, Fraction(0)),)
    last = force.pieces[-1]
    stretch = period / (last.begin + last.length)  # of pi, which the pieces have as a double
    return tuple(
        TimedPiece(p.begin * stretch, p.length * stretch, column(p.mean), column(p.slope), column(p.harmonics),
                   p.origin * stretch)
        for p in force.pieces
    )  # fmt: skip


def _joined(a: TimedPiece, b: TimedPiece, scale: float, frequency: float | None) -> TimedPiece:
    """Return a piece of [[A, B / scale], [0, J]]."""
    states, driving = b.mean.shape
    size = states + driving

    def whole(left: Any, right: Any, kind: Any = float) -> Any:
        matrix = np.zeros((size, size), dtype=kind)
        if left is not None:
            matrix[:states, :states] = left
        if right is not None:
            matrix[:states, states:] = right / scale
        return matrix

    mean = whole(a.beginning, b.beginning)
    if frequency is not None:
        mean[states, states + 1], mean[states + 1, states] = -frequency, frequency
    count = max(len(a.harmonics), len(b.harmonics))
    harmonics = np.zeros((count, size, size), dtype=complex)
    for k in range(count):
        left = a.harmonics[k] if k < len(a.harmonics) else None
        harmonics[k] = whole(left, b.harmonics[k] if k < len(b.harmonics) else None, complex)
    slope = None if a.slope is None and b.slope is None else whole(a.slope, b.slope)
    return TimedPiece(a.begin, a.length, mean, slope, harmonics, a.begin)


class MarchedResponse(NamedTuple):
    """A forced motion, its error as a fraction of the largest coordinate, and the multipliers' map."""

    motion: PiecewiseMotion
    error: float


def marched(problem: Equation | HillSystem | PeriodicSystem, force: Force) -> MarchedResponse:
    """Return the response by maps over segments of the period, the force a state of its own."""
    system = forced_system(problem, force)
    pieces = by_pieces.arrays_of(system.pieces, system.period)
    seconds = float(seconds_needed(pieces)[0])
    segments = _segments(system)
    if not seconds * len(system.pieces) < _LONGEST or not segments * len(system.pieces) <= _MOST_SEGMENTS:
        raise ValueError(
            "equation would take too many steps over its period: its coefficients are too large, the period too long "
            "or the frequency of the force too high"
        )
    maps = balanced_maps(pieces, _RTOL, segments)
    n, count = system.states, maps.maps.shape[1]
    with np.errstate(all="ignore"):
        errors = maps.errors[0] + _moved(system, maps, np.repeat(pieces.length[0] / segments, segments))
        unit = SegmentMaps(maps.maps, errors[None], np.ones_like(maps.scaling))
        matrix, total, _ = product(unit)
        scaling = maps.scaling[0]
        driving = system.start / scaling[n:]
        turn = 1.0 if force.frequency is None else np.exp(1j * force.frequency * float(system.period))
        slip = EPS * abs(force.frequency or 0.0) * float(system.period)
        left = np.asarray(turn * np.eye(n) - matrix[0, :n, :n])
        first, error = _started(left, matrix[0, :n, n:] @ driving, driving, float(total[0]) + slip)
        states = np.zeros((count + 1, n + len(driving)), dtype=complex)
        states[0] = np.concatenate([first, driving])
        added = np.empty(count)
        for j in range(count):
            states[j + 1] = maps.maps[0, j] @ states[j]
            size = float(np.linalg.norm(states[j]))
            added[j] = (errors[j] + 2.0 * EPS * len(scaling) ** 0.5 * float(norms(maps.maps[0, j]))) * size
        bound = _carried(maps.maps[0, :, :n, :n], error, added)
        motion = _dense(system, force, states * scaling, segments)
        largest = float(np.abs(motion.series[:, 0]).max(initial=0.0))
        seen = bound * float(scaling[: system.coordinates].max()) * system.scale
        largest = max(largest, float(np.abs(states[:, : system.coordinates] * scaling[: system.coordinates]).max()
                                     * system.scale))  # fmt: skip
        still = largest == 0.0 and force.largest == 0.0
        relative = 0.0 if still else seen / largest if largest > 0.0 else math.inf
    return MarchedResponse(motion, relative if relative == relative else math.inf)


def _carried(maps: Floats, first: float, added: Floats) -> float:
    """Return the largest error at the end of any segment: of the error at the beginning, and of those added since."""
    count, n = maps.shape[:2]
    errors = np.concatenate([[first], added])
    if count * count * n**3 > _MOST_PRODUCTS:
        bound = largest = first
        for j in range(count):
            bound = float(np.linalg.norm(maps[j], 2)) * bound + added[j]
            largest = max(largest, bound)
        return largest
    products, largest = np.empty((0, n, n)), first
    for j in range(count):
        products = np.concatenate([maps[j] @ products, maps[j][None] if j == 0 else np.eye(n)[None]])
        largest = max(largest, float((norms(products) * errors[: j + 1 + (j > 0)][: len(products)]).sum()))
    return largest


def _segments(system: ForcedSystem) -> int:
    """Return into how many segments each piece is cut."""
    omega = 2.0 * math.pi / float(system.period)
    phases = []
    for piece in system.pieces:
        sizes = piece.size
        rate = float(np.abs(np.linalg.eigvals(sizes)).max())
        phases.append((rate + len(piece.harmonics) * omega) * float(piece.length) / _PHASE)
    largest = max(phases)
    return math.ceil(max(largest, 4.0 / len(system.pieces), 1.0)) if largest < 1e9 else 10**9


def _moved(system: ForcedSystem, maps: SegmentMaps, lengths: Floats) -> Floats:
    """Return the errors of the maps of segments that errors of the coefficients and the force cause."""
    if not (system.error or system.force_error):
        return np.zeros(len(lengths))
    stretch = float(error_stretch(np.stack([piece.mean for piece in system.pieces])[None], maps.scaling)[0])
    change = (system.error + system.force_error) * len(maps.scaling[0]) * stretch
    return np.asarray(change * lengths * np.maximum(norms(maps.maps[0]), 1.0) ** 2)


def _started(left: Any, right: Any, driving: Any, error: float) -> tuple[Any, float]:
    """Return the state at the beginning of the period, and its error."""
    try:
        inverse = np.linalg.inv(left)
        state = np.linalg.solve(left, right)
    except np.linalg.LinAlgError:
        return np.full(len(right), np.nan + 0j), math.inf
    size = float(np.linalg.norm(np.concatenate([state, driving])))
    rounding = 4.0 * EPS * len(right) * float(np.linalg.norm(left)) * float(np.linalg.norm(state))
    norm = float(np.linalg.norm(inverse, 2))
    slip = norm * error
    return state, norm * (error * size + rounding) / (1.0 - slip) if slip < 0.5 else math.inf


def _dense(system: ForcedSystem, force: Force, states: Complexes, segments: int) -> PiecewiseMotion:
    """Return the motion between the ends of segments, from Taylor series about these."""
    omega = 2.0 * math.pi / float(system.period)
    ends: list[Any] = [np.zeros(1)]
    series: list[Any] = []
    to_series = _to_legendre()
    for j, piece in enumerate(system.pieces):
        length = float(piece.length) / segments
        into: Floats = np.asarray(length * np.arange(segments), dtype=float)
        inside = states[j * segments : (j + 1) * segments]
        terms = _taylor(piece, into, length, omega, inside)[:, :, : system.coordinates]
        series.append(system.scale * np.einsum("ml,lsn->smn", to_series, terms))
        ends.append(float(piece.begin) + into + length)
    whole = np.concatenate(series)
    ends[-1][-1] = float(system.period)
    period = float(system.period)
    return PiecewiseMotion(
        period, force.frequency, np.concatenate(ends), whole if force.frequency is not None else whole.real.copy()
    )


@functools.cache
def _to_legendre() -> Floats:
    """Return the matrix from a power series on 0 to 1 to Legendre's polynomials on -1 to 1."""
    columns = np.zeros((_ORDER, _ORDER))
    power: Any = np.ones(1)
    for j in range(_ORDER):
        columns[: j + 1, j] = power
        power = 0.5 * legendre.legadd(power, legendre.legmulx(power))
    return columns


def _taylor(piece: TimedPiece, into: Floats, length: float, omega: float, states: Complexes) -> Complexes:
    """Return Taylor terms (order, S, N) in units of the length, about times of a piece."""
    terms = np.zeros((_ORDER, *states.shape), dtype=complex)
    terms[0] = states
    mean = piece.mean.T * length
    slope = None if piece.slope is None else piece.slope.T * length
    rates = 1j * omega * np.arange(1, len(piece.harmonics) + 1)
    waves = np.exp(np.outer(rates, float(piece.begin) + into))[None] * np.ones((_ORDER, 1, 1))
    waves[1:] *= np.cumprod((rates * length)[None, :, None] / np.arange(1, _ORDER)[:, None, None], axis=0)
    used = [k for k in range(len(rates)) if piece.harmonics[k].any()]
    for i in range(_ORDER - 1):
        total = terms[i] @ mean
        if slope is not None:
            total = total + into[:, None] * (terms[i] @ slope)
            if i:
                total = total + length * (terms[i - 1] @ slope)
        for k in used:
            past = terms[i::-1]
            factor = waves[: i + 1, k, :, None]
            matrix = 0.5 * length * piece.harmonics[k].T
            total = total + (factor * past).sum(axis=0) @ matrix + (factor.conj() * past).sum(axis=0) @ matrix.conj()
        terms[i + 1] = total / (i + 1)
    return terms
