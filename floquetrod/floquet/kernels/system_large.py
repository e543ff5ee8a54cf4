"""What the maps of many equations share: Taylor series of u'' + K(t) u = 0 whose products of matrices are numpy's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Complexes, Floats, are_diagonal
from floquetrod.floquet.kernels.system_series import ROUNDING

Ints = NDArray[np.int_]

_WORTH_STOPPING = 50
"""Number of equations beyond which a product of matrices costs more than bounding the rest of a series (heuristic)."""
_BEYOND = 40  # terms that a bound follows one by one before it ends in a geometric series
_SMALLEST_BLOCK = 100  # rows below which a matrix is not split (heuristic)
_COLUMNS = 256  # of a series that are computed at once, so that its last terms stay in the cache (measured)
LEVELS = 6
"""Levels of a `split` matrix of at most 2,000 rows, the blocks at its ends included."""
_FARTHEST = 500  # terms that it follows at most


class ModalEquations(NamedTuple):
    """The equations v'' + (diag(rates) + sum_k F_k cos(m_k w t + pi turn_k)) v = 0 of u = q v."""

    rates: Floats  # (n,), the mean stiffness
    basis: Floats  # (n, n), q, orthogonal: eigenvectors of the mean stiffness, or the identity
    matrices: list[Floats]  # (n, n) each, F_k
    orders: Ints  # m_k, 0 of the first one where the mean stiffness is not diagonal
    turns: Floats  # phases in half turns
    norms: Floats  # (H,), bounds of the amplitudes of each harmonic in the 2-norm
    slack: float  # relative error of the rates and matrices
    constant: float = 0.0  # bound of the 2-norm of the matrix of order 0

    @classmethod
    def of(cls, stiffness: Floats, harmonics: Complexes) -> Self:
        """Return u'' + (S + Re sum_m Z_m exp(i m w t)) u = 0 in the eigenvectors of S."""
        n = len(stiffness)
        waves: tuple[Floats, ...] = (harmonics.real, harmonics.imag)
        if are_diagonal(stiffness):
            return cls._of(stiffness.diagonal().copy(), np.eye(n), waves, 2.0 * ROUNDING)
        return cls._of(*in_modes(stiffness, waves), ROUNDING * (4.0 + 4.0 * math.sqrt(n)))

    @classmethod
    def as_they_are(cls, stiffness: Floats, harmonics: Complexes) -> Self:
        """Return the equations in their own coordinates: where few states are carried, eigenvectors would cost more."""
        rates = stiffness.diagonal().copy()
        rest = stiffness - np.diag(rates)
        parts = cls._of(rates, np.eye(len(rates)), (harmonics.real, harmonics.imag), 2.0 * ROUNDING)
        if not rest.any():
            return parts
        return parts._replace(
            matrices=[rest, *parts.matrices],
            orders=np.append(0, parts.orders),
            turns=np.append(0.0, parts.turns),
            constant=norm_bound(rest),
        )

    @classmethod
    def _of(cls, rates: Floats, q: Floats, waves: tuple[Floats, ...], slack: float) -> Self:
        """Return the equations with a diagonal stiffness, and with the real and imaginary parts of the harmonics."""
        # Re Z exp(i m w t) = Re Z cos(m w t) + Im Z cos(m w t + pi / 2)
        harmonics = enumerate(zip(*waves, strict=True), 1)
        terms = [(m, turn, f) for m, parts in harmonics for turn, f in zip((0.0, 0.5), parts, strict=True) if f.any()]
        norms = np.zeros(max((m for m, _, _ in terms), default=0))
        for m, _, f in terms:
            norms[m - 1] = math.hypot(norms[m - 1], norm_bound(f))
        matrices = [np.ascontiguousarray(f) for _, _, f in terms]
        orders, turns = np.array([m for m, _, _ in terms], dtype=int), np.array([turn for _, turn, _ in terms])
        return cls(rates, q, matrices, orders, turns, norms, slack)


def in_modes(stiffness: Floats, waves: Sequence[Floats]) -> tuple[Floats, Floats, tuple[Floats, ...]]:
    """Return the rates and eigenvectors of a symmetric stiffness (n, n), and matrices (..., n, n) in these."""
    rates, q = np.linalg.eigh(stiffness)
    return rates, q, tuple(q.T @ wave @ q if wave.any() else wave for wave in waves)


class Split(NamedTuple):
    """A symmetric matrix [[A, U V], [(U V)^T, D]]; its blocks A and D are matrices or of this form again."""

    upper: Matrix
    left: Floats
    right: Floats
    lower: Matrix


Matrix = Floats | Split


def split(matrix: Floats, tolerance: float) -> Matrix:
    """Return a large symmetric matrix with off-diagonal blocks of low rank as far as that makes products cheaper.

    What is dropped is below ``tolerance`` in the 2-norm at each of at most `LEVELS` levels.
    """
    n = len(matrix)
    half = n // 2
    if half < _SMALLEST_BLOCK:
        return matrix
    left, sizes, right = np.linalg.svd(matrix[:half, half:], full_matrices=False)
    rank = int((sizes > tolerance).sum())
    if rank > n // 8:
        return matrix
    upper, lower = split(matrix[:half, :half].copy(), tolerance), split(matrix[half:, half:].copy(), tolerance)
    return Split(upper, left[:, :rank] * sizes[:rank], right[:rank], lower)


def times(matrix: Matrix, factor: float) -> Matrix:
    """Return a multiple of a matrix."""
    if not isinstance(matrix, Split):
        return factor * matrix
    upper, lower = times(matrix.upper, factor), times(matrix.lower, factor)
    return Split(upper, factor * matrix.left, matrix.right, lower)


def add_product(matrix: Matrix, x: Floats, out: Floats, work: Floats) -> None:
    """Add matrix @ x to ``out``; ``work`` is memory of the same shape."""
    if not isinstance(matrix, Split):
        out += np.matmul(matrix, x, out=work)
        return
    half = len(matrix.left)
    upper, lower = slice(half), slice(half, None)
    add_product(matrix.upper, x[upper], out[upper], work[upper])
    out[upper] += np.matmul(matrix.left, matrix.right @ x[lower], out=work[upper])
    add_product(matrix.lower, x[lower], out[lower], work[lower])
    out[lower] += np.matmul(matrix.right.T, matrix.left.T @ x[upper], out=work[lower])


class TaylorTerms:
    """Terms x_i, matrices (n, q), of a series that solves u'' + (diag(s) + sum_k c_k(t) F_k) u = 0.

    All terms share memory, since as much of it anew takes longer than the products do: rows of ``terms`` come again
    after ``rows``.

    Attributes
    ----------
    terms : ndarray (rows, n, q)
        The last terms, each in the row of its number modulo ``rows``.
    work : ndarray (n, q)
        Free between two terms.
    """

    def __init__(
        self, s: Floats, matrices: Sequence[Matrix], c: Floats, most: int, terms: Floats, *, constant: bool
    ) -> None:
        """Begin with the first terms given; ``constant``: c_0l is 0 but for l = 0, ``most`` the largest l."""
        self.terms, self.work = terms, np.empty(terms.shape[1:])
        self._s, self._c, self._most, self._first = s[:, None], c[: len(matrices)], most, int(constant)
        self._matrices, self._mixed = matrices, np.empty((len(matrices) - self._first, *terms.shape[1:]))

    def append(self, i: int, place: int, factor: Any) -> Floats:
        """Return the term in the row of a place: s x_i + sum_k F_k sum_l c_kl x_(i-l), times a factor."""
        rows = len(self.terms)
        current: Floats = self.terms[i % rows]
        out: Floats = self.terms[place % rows]
        flat = self.terms[: i + 1].reshape(min(i + 1, rows), -1)
        lags = np.arange(min(i, self._most) + 1)
        weights = np.zeros((len(self._mixed), len(flat)))
        weights[:, (i - lags) % rows] = self._c[self._first :, : len(lags)]
        np.matmul(weights, flat, out=self._mixed.reshape(len(self._mixed), flat.shape[1]))
        np.multiply(self._s, current, out=out)
        for k, matrix in enumerate(self._matrices):
            add_product(matrix, current if k < self._first else self._mixed[k - self._first], out, self.work)
        out *= factor
        return out

    def scaled(self, term: Floats, factor: float) -> Floats:
        """Return a multiple of a term, until the next one."""
        np.multiply(term, factor, out=self.work)
        return self.work


def tail(sizes: Floats, shrink: float) -> float:
    """Return `system_series.tail` of a series, from the Frobenius norms of its terms."""
    return math.sqrt(float(np.square(sizes) @ shrink ** np.arange(len(sizes), 0, -1.0)))


class Stop(NamedTuple):
    """When a series u(t + h x) = sum_j u_j x^j may end: its truncation error in balanced maps is small."""

    rates: Floats  # bounds of the Taylor coefficients of h^2 K, in units of h
    doubled: float  # bound of 4 h^2 K at twice the reach
    level: float  # an error u_j of the series is one of (level + slope j) |u_j| of the maps
    slope: float
    tolerance: float  # error of the maps at which the series ends

    def factor(self, power: int) -> float:
        """Return the error of the maps for a unit error of the term of this power."""
        return self.level + self.slope * power

    def _next(self, bounds: Floats, j: int) -> float:
        """Return the bound of |u_j| that follows from those before it."""
        return float(self.rates[: j - 1] @ bounds[j - 2 :: -1]) / ((j - 1.0) * j) if j > 1 else math.inf

    def left_out(self, sizes: Floats) -> float:
        """Bound the error of the maps from ending a series whose terms have the norms ``sizes``.

        |u_(j+2)| <= sum_l |K_l| |u_(j-l)| / ((j + 1) (j + 2)): this is followed for some terms, beyond which it allows
        bounds to fall by half from one to the next.  Infinite once one of them alone exceeds the tolerance.
        """
        count = len(sizes)
        last = max(count + _BEYOND, math.ceil(math.sqrt(min(self.doubled, 4.0 * len(self.rates) ** 2))))
        if last >= len(self.rates) or self._next(sizes, count) * self.factor(count) >= self.tolerance:
            return math.inf
        bounds = np.zeros(last + 1)
        bounds[:count] = sizes
        for j in range(count, last + 1):
            bounds[j] = bound = self._next(bounds, j)
            if bound * self.factor(j) >= self.tolerance:
                return math.inf
        index = np.arange(last + 1.0)
        beyond = float((bounds * 2.0**index).max()) * 2.0**-last * self.factor(last + 2)
        return float(bounds[count:] @ (self.level + self.slope * index[count:])) + beyond


def stop_rule(
    n: int, size: float, norms: Floats, first: int, angle: float, phases: tuple[float, float], tolerance: float
) -> Stop:
    """Return the rule for K = S + sum_k F_k cos(k w t + phase), |S| <= ``size``, |F_k| <= ``norms``, w h = ``angle``.

    These are in units of h; ``phases`` are the least and the largest rate of the balanced coordinates.  A series of few
    equations is not stopped: its terms cost less than the rule.
    """
    slow, fast = phases
    index = np.arange(1.0, _FARTHEST)
    harmonics = np.arange(first, first + len(norms))
    powers = np.cumprod(np.hstack([np.ones((len(norms), 1)), harmonics[:, None] * angle / index]), axis=1)
    rates = norms @ powers
    rates[0] += size
    doubled = 4.0 * float(rates @ 2.0 ** np.arange(float(len(rates)))) if n >= _WORTH_STOPPING else math.inf
    spread = math.sqrt(fast / slow)
    slope = spread + 1.0 / slow
    return Stop(rates, doubled, spread + fast + slope, slope, tolerance)


def crossing(
    s: Floats, matrices: Sequence[Matrix], c: Floats, most: int, h: float, order: int, ratio: float, stop: Stop,
    *, constant: bool,
) -> tuple[Floats, Floats, float]:  # fmt: skip
    """Return the maps of (u, h u') from a centre to h after and before it (2 n, 2 n), and their truncation error.

    ``c`` are the Taylor coefficients in units of h of the factors of the matrices; the first ``most`` + 1 are
    used.  The series has powers up to ``order``, if it is not stopped.
    """
    n = len(s)
    parts = [slice(start, min(start + _COLUMNS, 2 * n)) for start in range(0, 2 * n, _COLUMNS)]
    stop = stop._replace(tolerance=stop.tolerance / math.sqrt(len(parts)))
    forth, back = np.empty((2, 2 * n, 2 * n))
    rests = []
    for part in parts:
        x = np.zeros((most + 3, n, part.stop - part.start))
        x[0], x[1] = np.split(np.eye(2 * n)[:, part], 2)
        even, odd, rest = _summed(TaylorTerms(s, matrices, c, most, x, constant=constant), h, order, ratio, stop)
        forth[:, part], back[:, part] = even + odd, even - odd
        rests.append(rest)
    return forth, back, math.hypot(*rests)


def _summed(series: TaylorTerms, h: float, order: int, ratio: float, stop: Stop) -> tuple[Floats, Floats, float]:
    """Return the even and the odd part of (u, h u') at h, and the truncation error, from the first two terms."""
    x = series.terms
    sizes = np.zeros(order + 1)
    sizes[:2] = np.linalg.norm(x[0]), np.linalg.norm(x[1])
    n = x.shape[1]
    sums = np.zeros((2, 2 * n, x.shape[-1]))  # of even and odd powers
    sums[0, :n], sums[1, :n], sums[0, n:] = x[0], x[1], x[1]
    for i in range(order - 1):
        term = series.append(i, i + 2, -h * h / ((i + 1.0) * (i + 2.0)))
        sizes[i + 2] = math.sqrt(float(np.vdot(term, term)))
        sums[i % 2, :n] += term
        sums[1 - i % 2, n:] += series.scaled(term, i + 2.0)  # the slope is odd where the value is even
        rest = stop.left_out(sizes[: i + 3]) if i % 2 else math.inf
        if rest < stop.tolerance:
            break
    else:
        rest = stop.factor(order) * tail(sizes, ratio**-2.0) / (1.0 - 1.0 / ratio) ** 2
    return sums[0], sums[1], rest


def joined(forth: Floats, back: Floats, error: float, g: Floats, h: float, *, symmetric: bool) -> tuple[Floats, float]:
    """Return the map between both sides of a centre in balanced coordinates, and its error; see `crossing`."""
    n = len(g)
    outer = np.concatenate([g, 1.0 / (h * g)])
    forth, back = (matrix * (outer[:, None] / outer[None, :]) for matrix in (forth, back))
    if symmetric:
        back = np.block([[back[n:, n:].T, -back[:n, n:].T], [-back[n:, :n].T, back[:n, :n].T]])
    else:
        back = np.asarray(np.linalg.inv(back))
    one, two = norm_bound(forth), norm_bound(back)
    wrong = error * (one + two + error) + ROUNDING * (2.0 * n + 2.0) * one * two
    if not symmetric:
        wrong += (error + 8.0 * n * ROUNDING) * one * two * two
    return forth @ back, wrong


def norm_bound(matrix: Floats) -> float:
    """Bound the spectral norm of a matrix from its entries."""
    sizes = np.abs(matrix)
    product = float(sizes.sum(axis=0).max()) * float(sizes.sum(axis=1).max())
    return min(float(np.linalg.norm(matrix)), math.sqrt(product))


def chain(maps: list[Floats], errors: list[float]) -> tuple[Floats, float]:
    """Return the product of maps, the first acting first, and its error; see `system_series.chain_error`."""
    size = len(maps[0])
    prefixes = [maps[0]]
    for factor in maps[1:]:
        prefixes.append(factor @ prefixes[-1])
    befores = [1.0, *(norm_bound(prefix) for prefix in prefixes[:-1])]
    total, share, after = 0.0, 0.0, 1.0
    suffix = None
    for j in range(len(maps) - 1, -1, -1):
        norm = norm_bound(maps[j])
        local = errors[j] + (ROUNDING * (size + 2.0) * norm * math.sqrt(size) if j else 0.0)
        total += after * local * befores[j]
        share += local / norm if norm > 0.0 else math.inf
        if j:
            suffix = maps[j] if suffix is None else suffix @ maps[j]
            after = norm_bound(suffix)
    return prefixes[-1], total * math.exp(min(share * len(maps), 50.0))
