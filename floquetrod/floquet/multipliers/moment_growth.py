"""The growth rate of the second moments of many equations, without the matrix of all moments.

P' = A P + P A^T + s^2 sum_i G_i P G_i^T maps semidefinite P to such: the fastest growth belongs to a semidefinite
matrix (M. G. Krein and M. A. Rutman, Amer. Math. Soc. Transl. 26 (1950)).  Over a step h noise is one kick,

    P -> Phi (P + h s^2 sum_i G_i P G_i^T) Phi^T,   Phi by Magnus's series to fourth order,

which errs by the fourth power of h only, as kicks spread evenly over a period sample it like harmonics do.

In Floquet's coordinates, P = V R V^H with V the eigenvectors of the map over a period, the map of R without noise is
diagonal, with mu_i conj(mu_j).  Noise couples pairs of nearly equal products most, among them all i = j.  The small
eigenvalue problem of these pairs is a first approximation; with the diagonal elsewhere it preconditions Davidson's
method for the map over a period itself (E. R. Davidson, J. Comput. Phys. 17 (1975) 87).
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
from floquetrod.floquet.multipliers import magnus_flows

_TURN = 0.6  # radians that the fastest mode turns by in a step
_LEAST_STEPS = 64
_FINER = 1.5  # steps of the fine mesh over steps of the coarse one
_MOST_PAIRS = 120  # whose eigenvalue problem is solved as a whole, beside the pairs i = j (a choice)
_NEAR = 8.0  # times the coupling by noise: pairs are taken whose products turn apart by less (a choice)
_LEAST_GAP = 1e-6  # of multipliers, in the preconditioner
_FEW = 4  # equations up to which the map is computed as a whole
_ROUNDS = 60
_EACH, _PER_CUBE = 2e-4, 8e-8  # s, that a step of all rounds takes: of any number of equations, and over its cube
_SETTLED = 3e-11  # residual of the moments over their factor, at which rounds end
_SAME = 1e-8  # change of the factor, relative: a larger one means that other moments were followed
_ALMOST = 0.9  # positivity of moments that may become the fastest growing ones (a choice)
_SEMIDEFINITE = 1e-6  # share of negative eigenvalues up to which moments count as semidefinite


class MomentRate(NamedTuple):
    """Growth rate of second moments per unit of time, and its estimated error: twice the change to a coarser mesh.

    NaN and infinite where the search failed.
    """

    rate: float
    error: float


class MomentGrowth(NamedTuple):
    """The growth of second moments of q'' + C q' + K(t) q = s sum_i G_i q xi_i as a function of s, on two meshes.

    The search on the coarse mesh starts from the fastest growing moments of the fine one, in its coordinates.
    """

    coarse: _OnSteps
    fine: _OnSteps
    floquet: _Floquet

    @classmethod
    def of(cls, system: HillSystem, noise: Sequence[Floats]) -> Self:
        """Return the function of a single system of mass 1 and the matrices G_i (n, n) of its noise sources."""
        fastest = math.sqrt(float(np.abs(np.linalg.eigvalsh(system.stiffness)).max()))
        steps = math.ceil(max(_LEAST_STEPS, fastest * float(system.period) / _TURN))
        scale = max(fastest, 1.0 / float(system.period))
        coarse, fine = (_OnSteps.of(system, noise, count, scale) for count in (steps, math.ceil(_FINER * steps)))
        return cls(coarse, fine, _Floquet.of(fine))

    @property
    def seconds(self) -> float:
        """Estimated time of one call."""
        return len(self.fine.steps) * (_EACH + _PER_CUBE * len(self.fine.kicks[0]) ** 3)

    def __call__(self, density: float) -> MomentRate:
        """Return the growth rate of second moments at an intensity s, ``density`` its square."""
        if not density:
            rate = self.fine.rate_without_noise(self.floquet.multipliers)
            coarse_rate = self.coarse.rate_without_noise(np.linalg.eigvals(self.coarse.whole))
            return MomentRate(rate, 2.0 * abs(rate - coarse_rate))
        try:
            near = _Near.of(self.floquet, density)
            fine = self.fine.growth(density, near, near.start)
            coarse = self.coarse.growth(density, near, fine.moments)
        except np.linalg.LinAlgError:
            return MomentRate(math.nan, math.inf)
        error = 2.0 * abs(fine.rate - coarse.rate) + fine.change + coarse.change
        return MomentRate(fine.rate, error) if math.isfinite(error) else MomentRate(math.nan, math.inf)


class _Fastest(NamedTuple):
    """The fastest growing moments, (4 n^2,), their rate, and its change in the last round: infinite if unsettled."""

    moments: Floats
    rate: float
    change: float


class _OnSteps(NamedTuple):
    """The map over a period by equal steps."""

    period: float
    steps: Floats  # (N, 2 n, 2 n), maps over the steps, of (scale q, q')
    kicks: list[Floats]  # (n, n), sqrt(h) times the noise matrices: from scale q to changes of q'

    @classmethod
    def of(cls, system: HillSystem, noise: Sequence[Floats], count: int, scale: float) -> Self:
        """Return the map by ``count`` steps of the unknowns (scale q, q')."""
        period = float(system.period)
        step, n = period / count, system.order
        places = np.arange(count)[:, None] + 0.5 + magnus_flows.PLACES
        rates = np.zeros((2 * count, 2 * n, 2 * n))  # at both points of every step
        rates[:, :n, n:] = scale * np.eye(n)
        rates[:, n:, :n] = -system.coefficient(places.ravel() * step) / scale
        rates[:, n:, n:] = -velocity_matrix(system)
        kicks = [math.sqrt(step) / scale * np.asarray(matrix) for matrix in noise]
        return cls(period, magnus_flows.flows(rates[::2], rates[1::2], step), kicks)

    @property
    def whole(self) -> Floats:
        """The map over a period without noise, (2 n, 2 n)."""
        return functools.reduce(lambda before, step: np.asarray(step @ before), self.steps)

    def rate_without_noise(self, multipliers: NDArray[Any]) -> float:
        """Return the growth rate of second moments without noise, from the multipliers of this mesh."""
        return 2.0 * math.log(float(np.abs(multipliers).max())) / self.period

    def growth(self, density: float, near: _Near, start: Floats) -> _Fastest:
        """Return the fastest growing moments, by Davidson's method from the moments ``start``.

        Projected in Floquet's coordinates, where the map is nearly diagonal: in coordinates far from orthogonal a
        space may have larger values that belong to no solution.
        """
        factor, floquet = math.nan, near.floquet
        fresh = _symmetric_basis(len(floquet.vectors)) if len(floquet.vectors) <= 2 * _FEW else start[None]
        basis = images = np.zeros((0, 2 * start.size))
        moments = np.zeros((0, start.size))
        for _ in range(_ROUNDS):
            rows = floquet.rows(fresh)
            rows = _orthonormal(_orthonormal(rows, basis), basis)
            fresh = floquet.moments(rows)
            basis, moments = np.concatenate([basis, rows]), np.concatenate([moments, fresh])
            later = np.array([self._over_period(matrix, density) for matrix in fresh])
            images = np.concatenate([images, floquet.rows(later)])
            value, vector = _most_positive(moments, basis @ images.T)
            change, factor = 0.0 if math.isnan(factor) else abs(value - factor), value
            candidate, excess = vector @ moments, vector @ (images - factor * basis)
            if np.linalg.norm(excess) < _SETTLED * factor and change < _SAME * factor:
                known = _positivity(candidate) > 1.0 - _SEMIDEFINITE
                change = change / factor / self.period if known else math.inf
                return _Fastest(candidate, math.log(factor) / self.period, change)
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
        """Return the coordinates of a mesh."""
        n = len(mesh.kicks[0])
        before = [np.eye(2 * n)]
        for step in mesh.steps:
            before.append(step @ before[-1])
        multipliers, vectors = (array.astype(complex) for array in np.linalg.eig(before.pop()))
        along = np.array(before) @ vectors
        back, along = np.linalg.inv(along)[:, :, n:], along[:, :n]
        turned = np.concatenate([back @ (kick @ along) for kick in mesh.kicks])
        return cls(multipliers, vectors, np.linalg.inv(vectors), turned)

    @property
    def products(self) -> Complexes:
        """Factors mu_i conj(mu_j) of the entries of R over a period without noise."""
        return np.asarray(self.multipliers[:, None] * self.multipliers.conj()[None, :])

    def moments(self, rows: Floats) -> Floats:
        """Return moments (k, 4 n^2) from their coordinates, as `rows` returns them."""
        coefficients = np.ascontiguousarray(rows).view(complex).reshape(-1, *self.vectors.shape)
        moments = (self.vectors @ coefficients @ self.vectors.conj().T).real
        return np.asarray(0.5 * (moments + np.swapaxes(moments, 1, 2)).reshape(len(rows), -1))

    def rows(self, moments: Floats) -> Floats:
        """Return moments (k, 4 n^2) in these coordinates, real and imaginary parts by turns, (k, 8 n^2)."""
        rows = self.inverse @ moments.reshape(-1, *self.inverse.shape) @ self.inverse.conj().T
        return np.asarray(rows.reshape(len(moments), -1).view(float))


def _symmetric_basis(m: int) -> Floats:
    """Return the basis (m (m + 1) / 2, m^2) of all symmetric matrices (m, m)."""
    units = [np.zeros((m, m)) for _ in range(m * (m + 1) // 2)]
    for unit, i, j in zip(units, *np.triu_indices(m), strict=True):
        unit[i, j] = unit[j, i] = 1.0
    return np.array([unit.ravel() for unit in units])


class _Near(NamedTuple):
    """The pairs that noise couples most, and the map over a period among them."""

    floquet: _Floquet
    pairs: Any  # (k,), their indices i m + j
    values: Complexes  # (k,), eigenvalues of the map among them
    vectors: Complexes  # (k, k), its eigenvectors
    inverse: Complexes  # (k, k), of their matrix
    start: Floats  # (4 n^2,), moments of the largest value

    @classmethod
    def of(cls, floquet: _Floquet, density: float) -> Self:
        """Return the pairs for an intensity."""
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
        """Return the next direction of the search, from the residual of moments and of their factor."""
        direction = excess / _away(self.floquet.products.ravel() - factor)
        direction[self.pairs] = self.vectors @ ((self.inverse @ excess[self.pairs]) / _away(self.values - factor))
        return np.asarray(direction)


def _away(gaps: Complexes) -> Complexes:
    """Return gaps kept away from zero."""
    return np.asarray(np.where(np.abs(gaps) > _LEAST_GAP, gaps, _LEAST_GAP))


def _orthonormal(fresh: Floats, basis: Floats) -> Floats:
    """Return rows orthogonal to the rows of ``basis`` and to each other."""
    return np.asarray(np.linalg.qr((fresh - fresh @ basis.T @ basis).T)[0].T)


def _most_positive(basis: Floats, within: Floats) -> tuple[float, Floats]:
    """Return the eigenvalue and the eigenvector of a projected map whose moments are nearest to semidefinite.

    Indefinite ones may belong to no solution, and be larger.  Of several semidefinite ones it is the largest.
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
