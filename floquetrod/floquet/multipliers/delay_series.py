"""Multipliers of a system with delays as zeros of a determinant, none left out: their number is a winding number.

K(v) = I - sum_e C_e v^e is singular at the v = 1 / nu, mu = nu^q a multiplier.  With l = log v and G = K^-1 dK/dl,

    d(log det K)/dl = tr G,     log det K(l + d) - log det K(l) = tr E - tr E^2 / 2 + ...,    E = G d + R,

where |R| <= |K^-1| (d^2 / 2 max |d^2 K/dl^2| + error of K).  Along an arc of a circle of v the argument changes by less
than a right angle where |tr E| + |E|^2 / (2 - 2 |E|), in Frobenius's norm, is less: arcs are halved until it is, and
then no matrix within the error is singular on the circle.  |K^-1| is the 2-norm, at most 1 + |K^-1 - I|, or Frobenius's
in |tr R|.  Newton's method finds the zeros within, as many as counted.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Bools, Complexes, Floats, inverses

_ENTRIES = 1 << 20  # of matrices at once (a choice)
_CLEAR = 1.4  # radians, less than a right angle
_CONTRACTS = 0.75  # largest |E| on an arc
_MOST_ARCS = 1 << 15  # in one round (a choice)
_FINEST = 1e-13  # arc, in radians over the radians of the longest delay
_CELL = 0.5  # size of a cell that begins with Newton's method, in radians of the longest delay (a choice)
_INNERMOST = 1.0 / 8.0, 1.0 / 512.0, 1e-6  # |v|^p of the innermost cells, by rounds: there a delayed term hardly acts
_ROUNDS = 60  # of Newton's method
_ALONG, _FEW = 12, 4  # points of a circle about a zero, and of large matrices (a choice)
_LARGE = 24  # more rows make singular values much slower than inverses (a choice)
_WIDENED, _WIDER = 60, 1.5  # times that such a circle is widened, and by how much (a choice)


class Zeros(NamedTuple):
    """Zeros of det K, l = log v with 0 <= imag l <= pi / q, each as often as its multiplicity."""

    values: Complexes
    radii: Floats  # of discs that hold as many zeros of every K within the error


class DelaySeries(NamedTuple):
    """K(v) = I - sum_e C_e v^e."""

    exponents: NDArray[np.intp]  # (E,)
    matrices: Floats  # (E, N, N)
    error: float  # of K in the 2-norm, within the circle that holds all v wanted
    parts: int  # q, mu = v^-q
    longest: int  # power of v that the longest delay is

    @property
    def half_turn(self) -> float:
        """The argument of v at which mu is -|mu|."""
        return math.pi / self.parts

    def values(self, logs: Complexes) -> tuple[Complexes, Complexes]:
        """Return K and dK/dl at logarithms of v (m,), (m, N, N) each."""
        order = self.matrices.shape[-1]
        flat = self.matrices.reshape(len(self.exponents), -1)
        terms: Complexes = np.exp(np.multiply.outer(logs, self.exponents))
        value = _combined(-terms, flat).reshape(-1, order, order)
        value += np.eye(order)
        return value, _combined(-terms * self.exponents, flat).reshape(-1, order, order)

    def curvature(self, log_radius: float) -> float:
        """Return a bound of the norm of d^2 K/dl^2 on a circle."""
        sizes = np.sqrt(np.square(self.matrices).sum(axis=(1, 2)))
        return float((sizes * self.exponents**2 * np.exp(self.exponents * log_radius)).sum())

    def chunks(self, logs: Complexes) -> list[Complexes]:
        """Return parts of an array, each computed at once."""
        size = max(1, _ENTRIES // max(self.matrices.shape[-1] ** 2, len(self.exponents)))
        return [logs[k : k + size] for k in range(0, len(logs), size)]


def _combined(factors: Complexes, rows: Floats) -> Complexes:
    """Return the product of complex factors (m, E) and real rows (E, k), without complex copies of these."""
    total = np.empty((len(factors), rows.shape[1]), dtype=np.complex128)
    np.matmul(factors.real, rows, out=total.real)
    np.matmul(factors.imag, rows, out=total.imag)
    return total


class _Local(NamedTuple):
    """Of points: the argument of det K, tr G, the norms of G and of K^-1, and a bound of the latter's 2-norm, (m,)."""

    phase: Complexes
    trace: Complexes
    slope: Floats
    inverse: Floats
    largest: Floats


def _local(series: DelaySeries, logs: Complexes) -> _Local:
    found = []
    for some in series.chunks(logs):
        value, derivative = series.values(some)
        phase = np.linalg.slogdet(value)[0]
        inverse = inverses(value)
        slope = inverse @ derivative
        size, norm = (_frobenius(each) for each in (slope, inverse))
        inverse[:, np.arange(len(inverse[0])), np.arange(len(inverse[0]))] -= 1.0
        largest = np.minimum(norm, 1.0 + _frobenius(inverse))
        found.append((phase, np.trace(slope, axis1=1, axis2=2), size, norm, largest))
    return _Local(*(np.concatenate(part) for part in zip(*found, strict=True)))


def _frobenius(matrices: Complexes) -> Floats:
    """Return Frobenius's norms (m,)."""
    flat = matrices.reshape(len(matrices), -1).view(np.float64)
    return np.asarray(np.sqrt(np.einsum("mk,mk->m", flat, flat)))


def _traces(series: DelaySeries, logs: Complexes) -> Complexes:
    """Return tr G at logarithms of v, infinite where K is singular."""
    found = []
    for some in series.chunks(logs):
        value, derivative = series.values(some)
        trace = np.einsum("mij,mji->m", inverses(value), derivative)
        found.append(np.where(np.isnan(trace) & np.isfinite(value).all(axis=(1, 2)), np.inf, trace))
    return np.concatenate(found)


@np.errstate(all="ignore")  # what overflows is not clear
def outside(series: DelaySeries, log_radius: float) -> int | None:
    """Return how many multipliers are larger in modulus than exp(-q log_radius), each as often as its multiplicity.

    None where one of some K within the error lies on that circle.
    """
    order, longest = series.matrices.shape[-1], series.longest
    curvature = series.curvature(log_radius)
    number = max(8, math.ceil(4.0 * series.half_turn * longest))
    arcs, places, phases = np.arange(number), [], []
    while arcs.size:
        half = 0.5 * series.half_turn / number
        if arcs.size > _MOST_ARCS or half * longest < _FINEST:
            return None
        centres = series.half_turn * (arcs + 0.5) / number
        local = _local(series, np.asarray(log_radius + 1j * centres, dtype=np.complex128))
        bend = 0.5 * half * half * curvature
        size = local.slope * half + local.largest * (bend + math.sqrt(order) * series.error)
        rest = local.inverse * (bend + math.sqrt(order) * series.error)
        turn = np.abs(local.trace) * half + rest + size * size / (2.0 - 2.0 * size)
        clear = (size < _CONTRACTS) & (turn < _CLEAR)
        places.append(centres[clear])
        phases.append(local.phase[clear])
        arcs, number = np.concatenate([2 * arcs[~clear], 2 * arcs[~clear] + 1]), 2 * number
    along = np.concatenate(phases)[np.argsort(np.concatenate(places))]
    # det K is real at both ends, and within a right angle of its value at the centre of the last arc.
    ends = np.sign(along[[0, -1]].real)
    closed = np.concatenate([ends[:1], along, ends[1:]])
    return round(float(np.angle(closed[1:] / closed[:-1]).sum()) / math.pi)


@np.errstate(all="ignore")  # as above
def followed(series: DelaySeries, coarse: Complexes) -> Complexes | None:
    """Return the zeros near the zeros of another series; None where one is lost."""
    real = (coarse.imag == 0.0) | (coarse.imag == series.half_turn)
    done, values = _by_newton(series, coarse.copy(), float(coarse.real.max()) + 1.0)
    if not done.all():
        return None
    values.imag[real] = coarse.imag[real]
    return values


@np.errstate(all="ignore")  # as above
def discs(series: DelaySeries, values: Complexes) -> Zeros:
    """Return zeros with the radii of their discs."""
    return Zeros(values, _radii(series, values))


@np.errstate(all="ignore")  # iterates that leave the circle are dropped
def zeros(series: DelaySeries, log_radius: float, count: int) -> Zeros | None:
    """Return the zeros within a circle of v, as many as counted, conjugate pairs once; None where some are missed.

    The radius of a disc is such that K is nowhere on its edge as near to a singular matrix as its error.
    """
    cell = _CELL
    for innermost in _INNERMOST:
        logs = _distinct(series, _iterated(series, log_radius, cell, innermost))
        inside = logs[logs.real <= log_radius]
        radii = _radii(series, inside)
        real = _on_axis(series, inside, radii)
        inside.imag[real] = np.where(inside.imag[real] > 0.5 * series.half_turn, series.half_turn, 0.0)
        times = np.ones(len(inside), dtype=np.intp)
        if int(np.where(real, 1, 2).sum()) != count:
            times = _multiplicities(series, inside, radii)
        if int((np.where(real, 1, 2) * times).sum()) == count:
            return Zeros(np.repeat(inside, times), np.repeat(radii, times))
        cell *= 0.5
    return None


def _iterated(series: DelaySeries, log_radius: float, cell: float, innermost: float) -> Complexes:
    """Return where Newton's method ends that begins in cells near zeros, and at those without the delayed terms."""
    size, half_turn = cell / max(series.longest, 2 * series.parts), series.half_turn
    angles = np.linspace(0.0, half_turn, max(8, math.ceil(half_turn / size)) + 1)
    depth = log_radius - math.log(innermost) / series.longest
    radii = log_radius - size * np.arange(math.ceil(depth / size) + 1)
    points = (radii[:, None] + 1j * angles[None, :]).ravel()
    step = -1.0 / _traces(series, points)
    near = np.abs(step) < 1.5 * max(size, half_turn / (len(angles) - 1))
    alone = np.linalg.eigvals(series.matrices[0]) if series.exponents[0] == 1 else np.zeros(0)
    alone = -np.log(alone[np.abs(alone) > 0.0].astype(complex))
    alone = alone.real + 1j * np.abs(alone.imag)  # of a negative mu the logarithm lies at -pi
    logs = np.concatenate([(points + step)[near], alone])
    return _by_newton(series, logs, log_radius)[1]


def _by_newton(series: DelaySeries, logs: Complexes, log_radius: float) -> tuple[Bools, Complexes]:
    """Return which iterations of Newton's method end at zeros, and where those end."""
    left, done = np.arange(len(logs)), np.zeros(len(logs), dtype=np.bool_)
    last = np.full(len(logs), math.inf)
    for _ in range(_ROUNDS):
        if not left.size:
            break
        step = -1.0 / _traces(series, logs[left])
        logs[left] += step
        width = np.abs(step)
        ended = (width <= 4.0 * EPS) | ((width < 1e-9 / series.longest) & (width >= 0.75 * last[left]))
        done[left[ended]] = True
        last[left] = width
        lost = ~np.isfinite(logs[left]) | (logs[left].real > log_radius + 4.0 / series.longest)
        left = left[~ended & ~lost]
    done[left[last[left] < 1e-9 / series.longest]] = True
    return done, np.asarray(logs[done])


def _distinct(series: DelaySeries, logs: Complexes) -> Complexes:
    """Return logarithms of v in the upper half of a turn of mu, those that differ by rounding once."""
    turn = 2.0 * series.half_turn
    angles = np.remainder(logs.imag + series.half_turn, turn) - series.half_turn
    folded = logs.real + 1j * np.abs(angles)
    folded = folded[np.argsort(folded.real)]
    kept: list[int] = []
    tolerance = 1e-7 / series.longest
    for i, value in enumerate(folded):
        back = [k for k in kept[-64:] if value.real - folded[k].real <= tolerance]
        if not any(abs(value - folded[k]) <= tolerance for k in back):
            kept.append(i)
    return np.asarray(folded[kept])


def _on_axis(series: DelaySeries, logs: Complexes, radii: Floats) -> Bools:
    """Return which zeros belong to real multipliers, as far as their discs show it."""
    return np.asarray(np.minimum(logs.imag, series.half_turn - logs.imag) <= radii)


def _circles(logs: Complexes, radii: Floats, count: int) -> Complexes:
    """Return points (m, count) on circles."""
    turned = np.exp(2j * math.pi / count * (np.arange(count) + 0.25))
    return np.asarray(logs[:, None] + radii[:, None] * turned)


def _radii(series: DelaySeries, logs: Complexes) -> Floats:
    """Return the radii of discs about zeros."""
    if not logs.size:
        return np.zeros(0)
    value, derivative = series.values(logs)
    left, sizes, right = np.linalg.svd(value)
    slope = np.abs(np.einsum("mi,mij,mj->m", left[:, :, -1].conj(), derivative, right[:, -1].conj()))
    rounding = 8.0 * EPS * (1.0 + np.abs(logs))
    radii: Floats = 1.01 * (series.error + sizes[:, -1]) / slope + rounding
    open_ones, count = np.arange(len(logs)), _ALONG if value.shape[-1] < _LARGE else _FEW
    for _ in range(_WIDENED):
        edge = series.values(_circles(logs[open_ones], radii[open_ones], count).ravel())[0]
        least = _smallest(edge).reshape(-1, count).min(axis=1)
        open_ones = open_ones[~(least > series.error)]
        if not open_ones.size:
            return radii
        radii[open_ones] *= _WIDER
    radii[open_ones] = math.inf
    return radii


def _smallest(matrices: Complexes) -> Floats:
    """Return the smallest singular values (m,), of large matrices bounds from below."""
    if matrices.shape[-1] < _LARGE:
        return np.asarray(np.linalg.svd(matrices, compute_uv=False)[:, -1])
    return np.asarray(1.0 / np.linalg.norm(inverses(matrices), axis=(1, 2)))


def _multiplicities(series: DelaySeries, logs: Complexes, radii: Floats) -> NDArray[np.intp]:
    """Return how many zeros each circle of a thousandth of a cell holds, or of ten radii."""
    if not logs.size:
        return np.zeros(0, dtype=np.intp)
    wide = np.maximum(10.0 * radii, 1e-4 / series.longest)
    points = _circles(logs, wide, _ALONG)
    trace = _traces(series, points.ravel()).reshape(points.shape)
    return np.asarray(np.rint(((points - logs[:, None]) * trace).mean(axis=1).real).astype(np.intp))
