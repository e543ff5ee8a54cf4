"""How fast second moments of many equations grow, without the matrix of all their moments.

P' = A P + P A^T + s^2 sum_i G_i P G_i^T maps semidefinite P to such: the fastest growth belongs to a semidefinite
matrix (M. G. Krein and M. A. Rutman, Amer. Math. Soc. Transl. 26 (1950)).  Over a step h noise is one kick,

    P -> Phi (P + h s^2 sum_i G_i P G_i^T) Phi^T,   Phi by Magnus's series to fourth order,

which errs by the fourth power of h only, as kicks that are evenly spread over a period sample it like harmonics do.

In Floquet's coordinates, P = V R V^H with V the eigenvectors of the map over a period, the map of R without noise is
diagonal, with mu_i conj(mu_j).  Noise couples most what these tell apart least: pairs of nearly equal products, among
them all i = j, whose small eigenvalue problem is a first approximation, and with the diagonal elsewhere preconditions
Davidson's method for the map over a period itself (E. R. Davidson, J. Comput. Phys. 17 (1975) 87).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem
from floquetrod.equations.matrices import velocity_matrix
from floquetrod.floquet.systems import magnus

_TURN = 0.6  # radians that the fastest mode turns by in a step
_LEAST_STEPS = 64
_FINER = 1.5  # steps of the finer of two meshes over those of the other
_MOST_PAIRS = 120  # whose eigenvalue problem is solved as a whole, beside the pairs i = j (a choice)
_NEAR = 8.0  # pairs are taken whose products turn apart by less than this much of what noise couples (a choice)
_LEAST_GAP = 1e-6  # of multipliers, in the preconditioner
_FEW = 4  # equations up to which the map is computed as a whole
_ROUNDS = 60
_EACH, _PER_CUBE = 2e-4, 8e-8  # s, that a step of all rounds takes: of any number of equations, and over its cube
_SETTLED = 3e-11  # part of the moments that the map changes beyond a factor, at which rounds end
_SAME = 1e-8  # of the factor: a larger change means that others were followed
_ALMOST = 0.9  # positivity of moments that may become those that grow fastest (a choice)
_SEMIDEFINITE = 1e-6  # share of negative eigenvalues in what counts as semidefinite


class Growth(NamedTuple):
    """Growth rate of second moments per unit of time, and its error: twice what a coarser mesh changes, an estimate.

    NaN and infinite where it was not found.
    """

    rate: float
    error: float


class MomentGrowth(NamedTuple):
    """A system of the kind q'' + C q' + K(t) q = s sum_i G_i q xi_i, of which s is still open, on two meshes.

    The coordinates of the finer one, and the moments that grow fastest on it, are where the other begins.
    """

    coarse: _OnSteps
    fine: _OnSteps
    floquet: _Floquet

    @classmethod
    def of(cls, system: HillSystem, noise: Sequence[Floats]) -> Self:
        """Return that of a single system of mass 1 and the matrices G_i of its sources, (n, n)."""
        fastest = math.sqrt(float(np.abs(np.linalg.eigvalsh(system.stiffness)).max()))
        steps = math.ceil(max(_LEAST_STEPS, fastest * float(system.period) / _TURN))
        scale = max(fastest, 1.0 / float(system.period))
        coarse, fine = (_OnSteps.of(system, noise, count, scale) for count in (steps, math.ceil(_FINER * steps)))
        return cls(coarse, fine, _Floquet.of(fine))

    @property
    def seconds(self) -> float:
        """What an intensity takes, as estimated."""
        return len(self.fine.steps) * (_EACH + _PER_CUBE * len(self.fine.kicks[0]) ** 3)

    def __call__(self, density: float) -> Growth:
        """Return how fast second moments grow at an intensity s, ``density`` its square."""
        if not density:
            rate = self.fine.rate_without_noise(self.floquet.multipliers)
            return Growth(rate, 2.0 * abs(rate - self.coarse.rate_without_noise(np.linalg.eigvals(self.coarse.whole))))
        try:
            near = _Near.of(self.floquet, density)
            found = self.fine.growth(density, near, near.start)
            other = self.coarse.growth(density, near, found.moments)
        except np.linalg.LinAlgError:
            return Growth(math.nan, math.inf)
        error = 2.0 * abs(found.rate - other.rate) + found.change + other.change
        return Growth(found.rate, error) if math.isfinite(error) else Growth(math.nan, math.inf)


class _Fastest(NamedTuple):
    """Moments that grow fastest, (4 n^2,), their rate, and what the last round changed of it.

    The change is infinite where none settled.
    """

    moments: Floats
    rate: float
    change: float


class _OnSteps(NamedTuple):
    """The map over a period by equal steps."""

    period: float
    steps: Floats  # (N, 2 n, 2 n), maps over the steps, of (scale q, q')
    kicks: list[Floats]  # (n, n) each, square root of h times the matrices of noise, by which scale q changes q'

    @classmethod
    def of(cls, system: HillSystem, noise: Sequence[Floats], count: int, scale: float) -> Self:
        """Return it for so many steps and unknowns (scale q, q')."""
        period = float(system.period)
        kicks = [math.sqrt(period / count) / scale * np.asarray(matrix) for matrix in noise]
        return cls(period, _magnus(system, count, scale), kicks)

    @property
    def whole(self) -> Floats:
        """The map over a period without noise, (2 n, 2 n)."""
        return functools.reduce(lambda before, step: np.asarray(step @ before), self.steps)

    def rate_without_noise(self, multipliers: NDArray[Any]) -> float:
        """Return how fast second moments grow without noise, given the multipliers of this mesh."""
        return 2.0 * math.log(float(np.abs(multipliers).max())) / self.period

    def growth(self, density: float, near: _Near, start: Floats) -> _Fastest:
        """Return what grows fastest, searched for from some moments on.

        Projected in Floquet's coordinates, where the map is nearly diagonal: in others that are far from orthogonal a
        space may have larger values that are of no solution.
        """
        factor, floquet = math.nan, near.floquet
        fresh = _every(len(floquet.vectors)) if len(floquet.vectors) <= 2 * _FEW else start[None]
        basis = images = np.zeros((0, 2 * start.size))
        moments = np.zeros((0, start.size))
        for _ in range(_ROUNDS):
            rows = floquet.rows(fresh)
            rows = _orthonormal(_orthonormal(rows, basis), basis)
            fresh = floquet.moments(rows)
            basis, moments = np.concatenate([basis, rows]), np.concatenate([moments, fresh])
            later = np.array([self._over_period(each, density) for each in fresh])
            images = np.concatenate([images, floquet.rows(later)])
            value, vector = _most_positive(moments, basis @ images.T)
            change, factor = 0.0 if math.isnan(factor) else abs(value - factor), value
            found, excess = vector @ moments, vector @ (images - factor * basis)
            if np.linalg.norm(excess) < _SETTLED * factor and change < _SAME * factor:
                known = _positivity(found) > 1.0 - _SEMIDEFINITE
                change = change / factor / self.period if known else math.inf
                return _Fastest(found, math.log(factor) / self.period, change)
            fresh = floquet.moments(near.towards(excess.view(complex), factor).view(float)[None])
        return _Fastest(start, math.nan, math.inf)

    def _over_period(self, moments: Floats, density: float) -> Floats:
        """Return moments a period later."""
        n = len(self.kicks[0])
        moments = moments.reshape(2 * n, 2 * n)
        for step in self.steps:
            moments = moments.copy()
            moments[n:, n:] += density * sum(kick @ moments[:n, :n] @ kick.T for kick in self.kicks)
            moments = step @ moments @ step.T
        return (0.5 * (moments + moments.T)).ravel()


class _Floquet(NamedTuple):
    """Floquet's coordinates."""

    multipliers: Complexes  # (2 n,)
    vectors: Complexes  # (2 n, 2 n), of the map over a period
    inverse: Complexes  # (2 n, 2 n), of their matrix
    turned: Complexes  # (N * sources, 2 n, 2 n), the kicks in these coordinates at the beginning

    @classmethod
    def of(cls, mesh: _OnSteps) -> Self:
        """Return those of a mesh."""
        n = len(mesh.kicks[0])
        before = [np.eye(2 * n)]
        for step in mesh.steps:
            before.append(step @ before[-1])
        multipliers, vectors = (each.astype(complex) for each in np.linalg.eig(before.pop()))
        along = np.array(before) @ vectors
        back, along = np.linalg.inv(along)[:, :, n:], along[:, :n]
        turned = np.concatenate([back @ (kick @ along) for kick in mesh.kicks])
        return cls(multipliers, vectors, np.linalg.inv(vectors), turned)

    @property
    def products(self) -> Complexes:
        """What the map over a period multiplies each entry of R with where there is no noise."""
        return np.asarray(self.multipliers[:, None] * self.multipliers.conj()[None, :])

    def moments(self, rows: Floats) -> Floats:
        """Return moments, (k, 4 n^2), of their `rows`."""
        coefficients = np.ascontiguousarray(rows).view(complex).reshape(-1, *self.vectors.shape)
        found = (self.vectors @ coefficients @ self.vectors.conj().T).real
        return np.asarray(0.5 * (found + np.swapaxes(found, 1, 2)).reshape(len(rows), -1))

    def rows(self, moments: Floats) -> Floats:
        """Return moments (k, 4 n^2) in these coordinates, real and imaginary parts by turns, (k, 8 n^2)."""
        found = self.inverse @ moments.reshape(-1, *self.inverse.shape) @ self.inverse.conj().T
        return np.asarray(found.reshape(len(moments), -1).view(float))


def _every(m: int) -> Floats:
    """Return a basis of all moments."""
    units = [np.zeros((m, m)) for _ in range(m * (m + 1) // 2)]
    for unit, i, j in zip(units, *np.triu_indices(m), strict=True):
        unit[i, j] = unit[j, i] = 1.0
    return np.array([unit.ravel() for unit in units])


class _Near(NamedTuple):
    """The pairs that noise couples most, and the map over a period among them."""

    floquet: _Floquet
    pairs: Any  # (k,), their places
    values: Complexes  # (k,), eigenvalues of the map among them
    vectors: Complexes  # (k, k), its eigenvectors
    inverse: Complexes  # (k, k), of their matrix
    start: Floats  # (4 n^2,), moments of the largest value

    @classmethod
    def of(cls, floquet: _Floquet, density: float) -> Self:
        """Return them for an intensity."""
        m, turned = len(floquet.multipliers), floquet.turned
        logarithms = np.log(floquet.products)
        reach = _NEAR * density * float(np.square(np.abs(turned)).sum(0).max())
        apart = np.abs(logarithms.imag).ravel()
        apart[:: m + 1] = -1.0
        pairs = np.argsort(apart, kind="stable")[: max(m, min(m + _MOST_PAIRS, int((apart < reach).sum())))]
        i, j = np.unravel_index(pairs, (m, m))
        within = np.diag(logarithms[i, j])
        for kick in turned:
            within += density * kick[np.ix_(i, i)] * kick[np.ix_(j, j)].conj()
        values, vectors = np.linalg.eig(within)
        largest = int(values.real.argmax())
        start = np.zeros(m * m, dtype=complex)
        start[pairs] = vectors[:, largest] / vectors[:m, largest].sum()  # the first pairs are the diagonal
        moments = floquet.moments(start.view(float)[None])[0]
        return cls(floquet, pairs, np.exp(values), vectors, np.linalg.inv(vectors), moments)

    def towards(self, excess: Complexes, factor: float) -> Complexes:
        """Return the direction in which to look for moments, given what the map makes of some beyond a factor."""
        found = excess / _away(self.floquet.products.ravel() - factor)
        found[self.pairs] = self.vectors @ ((self.inverse @ excess[self.pairs]) / _away(self.values - factor))
        return np.asarray(found)


def _away(gaps: Complexes) -> Complexes:
    """Return gaps, those next to zero a little larger."""
    return np.asarray(np.where(np.abs(gaps) > _LEAST_GAP, gaps, _LEAST_GAP))


def _magnus(system: HillSystem, count: int, scale: float) -> Floats:
    """Return the maps over equal steps of a period, (count, 2 n, 2 n), of (scale q, q')."""
    n, step = system.order, float(system.period) / count
    places = np.arange(count)[:, None] + 0.5 + magnus.PLACES
    rates = np.zeros((2 * count, 2 * n, 2 * n))
    rates[:, :n, n:] = scale * np.eye(n)
    rates[:, n:, :n] = -system.coefficient(places.ravel() * step) / scale
    rates[:, n:, n:] = -velocity_matrix(system)
    return magnus.flows(rates[::2], rates[1::2], step)


def _orthonormal(fresh: Floats, basis: Floats) -> Floats:
    """Return rows orthogonal to others and to each other."""
    return np.asarray(np.linalg.qr((fresh - fresh @ basis.T @ basis).T)[0].T)


def _most_positive(basis: Floats, within: Floats) -> tuple[float, Floats]:
    """Return the eigenvalue and the eigenvector of a map within a space whose moments are nearest to semidefinite.

    Others may be of no solution, and larger.  Of several that are semidefinite it is the largest.
    """
    values, vectors = np.linalg.eig(within)
    real = np.flatnonzero(np.abs(values.imag) <= 1e-12 * np.abs(values))
    real = real if real.size else np.arange(len(values))
    positivity = np.array([_positivity(vectors[:, i].real @ basis) for i in real])
    order = np.where(positivity > _ALMOST, 1.0 + np.maximum(values.real[real], 0.0), positivity)
    best = real[int(order.argmax())]
    return float(values[best].real), np.asarray(vectors[:, best].real)


def _positivity(moments: Floats) -> float:
    """Return 1 for a symmetric matrix that is semidefinite, up to its sign, less for others."""
    n = math.isqrt(len(moments))
    values = np.linalg.eigvalsh(moments.reshape(n, n))
    return float(abs(values.sum()) / np.abs(values).sum())
