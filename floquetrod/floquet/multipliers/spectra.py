"""Eigenvalues with errors: discs about computed ones that hold the eigenvalues of every matrix within a distance.

For A = V diag(z) V^-1 with unit columns in V, V^-1 (A + E) V has Gershgorin discs of radius n k_i |E| about z_i, where
k_i is the norm of row i of V^-1, the condition number of z_i; or sqrt(n) |V| k_i |E|, less where n is large.  A disc
apart from all others shrinks to about k_i |E|.

Where eigenvectors are nearly parallel, as of a Jordan block, the triangular form A = Q (D + N) Q^H bounds clusters of
eigenvalues without them: see `triangular_radii`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Bools, Complexes, Floats, are_diagonal
from floquetrod._util.caching import cached_property

Form = Callable[[NDArray[Any]], NDArray[Any]]

LARGE = 200
"""Rows above which 2-norms are bounded, not computed: a decomposition takes seconds (a choice)."""
_MOST_TRIANGULAR = 100  # rows of a triangular form that bounds clusters: a tenth of a second (a choice)
_COARSE = 1e-6  # of the norm: radii of clusters above which another bound is tried (a choice)
_HALVINGS = 24  # of the range of a radius, in its logarithm (a choice)
_SEVERAL = 24  # rows from which products bound a 2-norm in a third of the time of singular values (measured)


class Discs(NamedTuple):
    """Eigenvalues of a matrix known up to an error.

    The discs of a cluster together hold as many eigenvalues of the true matrix as it has members.  ``right`` and
    ``left`` are empty where eigenvectors cannot be computed accurately enough.
    """

    values: Complexes  # (n,), eigenvalues of the matrix computed
    radii: Floats  # (n,)
    clusters: tuple[NDArray[np.intp], ...]  # of eigenvalues whose discs touch, directly or by others between them
    right: Complexes  # (n, n), eigenvectors, unit columns
    left: Complexes  # (n, n), rows of the inverse of ``right``
    error: float  # distance of the true matrix, in the 2-norm, the rounding of the eigenvalues included
    matrix: NDArray[Any]  # (n, n), the matrix computed
    spread: float  # the 2-norm of ``left``

    @property
    def reaches(self) -> Floats:
        """How far from each value the true eigenvalue that it stands for may be, (n,)."""
        if len(self.clusters) == len(self.values):
            return self.radii
        return reaches(np.abs(self.values[:, None] - self.values[None, :]), self.radii, self.clusters)


class Eigen(NamedTuple):
    """Eigenvalues of a matrix, its eigenvectors as unit columns, and their inverse."""

    values: NDArray[Any]
    right: NDArray[Any]
    left: NDArray[Any]


def eigen(matrix: NDArray[Any]) -> Eigen | None:
    """Return the eigenvalues of a matrix; None where it is not finite, and where eigenvectors have no inverse."""
    if not np.isfinite(matrix).all():
        return None
    try:
        values, right = np.linalg.eig(matrix)
        return Eigen(values, right, _inverse(values, right))
    except np.linalg.LinAlgError:
        return None


def eigenvalue_discs(matrix: NDArray[Any], error: float, known: Eigen | None = None) -> Discs | None:
    """Return discs for the eigenvalues of all matrices within ``error`` of ``matrix``.

    ``known`` eigenvalues are not computed again.  None where the matrix or the error is not finite, and where
    eigenvectors fail of a matrix of more than 100 rows.
    """
    discs = _discs_of_vectors(matrix, error, known)
    if discs is not None and not is_coarse(discs.radii, discs.clusters, float(np.abs(discs.values).max())):
        return discs
    triangular = _discs_of_triangle(matrix, error)
    if discs is None or (triangular is not None and triangular.radii.max() < discs.radii.max()):
        return triangular
    return discs


def is_coarse(radii: Floats, clusters: Sequence[NDArray[np.intp]], size: float) -> bool:
    """Return whether touching discs are large beside the largest eigenvalue, so that another bound may be lower."""
    return len(clusters) < len(radii) and bool(radii.max() > _COARSE * size)


def diagonalised_discs(matrix: NDArray[Any], error: float) -> Discs | None:
    """Return discs with eigenvectors; None where these cannot be computed accurately enough."""
    return _discs_of_vectors(matrix, error, None)


def normal_discs(matrix: NDArray[Any], error: float) -> Discs | None:
    """Return discs for the eigenvalues of a nearly normal matrix, with orthonormal eigenvectors; None if not finite.

    Schur's form A = Q (D + N) Q^H is at the distance abs(N) of the normal matrix Q D Q^H, whose eigenvalues move by no
    more than a change of it (F. L. Bauer and C. T. Fike, Numer. Math. 2 (1960) 137, doi:10.1007/BF01386217): every disc
    has the radius abs(N) + ``error``.  The eigenvalues of two unitary matrices can even be paired one to one within
    their distance: R. Bhatia and C. Davis, Linear Multilinear Algebra 15 (1984) 71, doi:10.1080/03081088408817578.
    """
    from scipy.linalg import schur

    n = len(matrix)
    if not (np.isfinite(matrix).all() and np.isfinite(error)):
        return None
    triangle, vectors = schur(matrix.astype(np.complex128), output="complex")
    values = np.diag(triangle).copy()
    off = float(np.linalg.norm(np.triu(triangle, 1)))
    total = error + off + 4.0 * n * EPS * float(np.abs(values).max())
    radii = np.full(n, total)
    gaps = np.abs(values[:, None] - values[None, :])
    return Discs(values, radii, touching(gaps, radii), vectors, vectors.conj().T, total, matrix, 1.0)


@np.errstate(over="ignore", invalid="ignore")  # an overflow is then not finite
def _discs_of_vectors(matrix: NDArray[Any], error: float, known: Eigen | None) -> Discs | None:
    """Return Gershgorin's discs in the coordinates of the eigenvectors."""
    n = len(matrix)
    decomposition = (known or eigen(matrix)) if math.isfinite(error) else None
    if decomposition is None:
        return None
    values, right, left = decomposition
    total = error + 4.0 * n * EPS * spectral_norm(matrix)
    conditions = np.linalg.norm(left, axis=1)
    uncertainty = n * EPS * float(np.linalg.norm(conditions))
    if not uncertainty < 0.1 or not math.isfinite(total):  # the inverse is not one
        return None
    many = float(n) if n < LARGE else min(n, math.sqrt(n) * spectral_norm(right))
    whole = many * conditions * total * (1.0 + 2.0 * uncertainty)
    values = values.astype(np.complex128)
    gaps = np.abs(values[:, None] - values[None, :])
    clusters = touching(gaps, whole)
    radii = whole.copy()
    spread = spectral_norm(left)
    alone = np.array([cluster[0] for cluster in clusters if len(cluster) == 1], dtype=np.intp)
    room = gaps[alone] - whole - whole[alone, None]
    room[np.arange(alone.size), alone] = math.inf  # none is in its own way
    share = (conditions * total / room).max(axis=1, initial=0.0)
    shrinks = share < 1.0  # row i may be divided by it: the other discs still do not reach this one
    alone, share = alone[shrinks], share[shrinks]
    radii[alone] = conditions[alone] * total * (1.0 + (many - 1.0) * share) * (1.0 + 2.0 * uncertainty)
    return Discs(
        values, radii, clusters, right.astype(np.complex128), left.astype(np.complex128), total, matrix, spread
    )


def _discs_of_triangle(matrix: NDArray[Any], error: float) -> Discs | None:
    """Return discs from the complex Schur form, of at most 100 rows."""
    from scipy.linalg import schur

    n = len(matrix)
    if n > _MOST_TRIANGULAR or not np.isfinite(error) or not np.isfinite(matrix).all():
        return None
    try:
        triangle = schur(matrix, output="complex", check_finite=False)[0]
    except np.linalg.LinAlgError:
        return None
    total = error + 4.0 * n * EPS * spectral_norm(matrix)
    values = np.diag(triangle).copy()
    gaps = np.abs(values[:, None] - values[None, :])
    radii = triangular_radii(gaps, np.abs(np.triu(triangle, 1)), total)
    nothing = np.zeros((0, 0), dtype=np.complex128)
    return Discs(values, radii, touching(gaps, radii), nothing, nothing, total, matrix, 0.0)


def triangular_radii(gaps: Floats, upper: Floats, error: float) -> Floats:
    """Return radii (n,) of discs about the eigenvalues z_i of a triangular T, for all matrices T + E, |E| < error.

    Where abs(z - z_j) >= d_j for all j, abs((z - T)^-1) <= C^-1 entry by entry, C = diag(d) - abs(N) the comparison
    matrix of T = diag(z_j) + N, and z is no eigenvalue of T + E where the norm of C^-1 is below 1 / error.  About a
    cluster, on the boundary of discs of radius d, d_j = d for its members and the distance of z_j from the cluster less
    d for the others: where no z there is an eigenvalue of any T + t E, the discs keep as many as they have centres.
    A cluster takes in any eigenvalue too close for such a d.
    Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), Theorem 8.12; a Jordan block of order p has
    d of the order error^(1/p), as Henrici, Numer. Math. 4 (1962) 24, doi:10.1007/BF01386294, has it.

    Parameters
    ----------
    gaps : ndarray (n, n)
        abs(z_i - z_j).
    upper : ndarray (n, n)
        abs(N), strictly upper triangular.
    error : float
        Bound of the norm of E, the rounding of T included; greater than zero.
    """
    n = len(gaps)
    radii = np.empty(n)
    done = np.zeros(n, dtype=np.bool_)
    for i in range(n):
        members = np.arange(n) == i
        while not done[i]:
            away = gaps[members].min(axis=0)
            room = 0.5 * float(away[~members].min(initial=math.inf))
            radius = _smallest_radius(members, away, upper, error, room)
            if radius is None and not members.all():
                members |= away <= 2.0 * room
                continue
            radius = math.inf if radius is None else radius  # of a T that overflows
            radii[members] = np.where(done[members], np.minimum(radii[members], radius), radius)
            done |= members
    return radii


def _smallest_radius(members: Bools, away: Floats, upper: Floats, error: float, room: float) -> float | None:
    """Return about the smallest d of discs about a cluster, at most ``room``; None where no such d will do."""
    from scipy.linalg import solve_triangular

    ones = np.ones(len(away))

    @np.errstate(over="ignore", invalid="ignore")  # a d too small
    def holds(radius: float) -> bool:
        comparison = np.diag(np.where(members, radius, away - radius)) - upper
        rows, columns = (
            float(solve_triangular(comparison, ones, trans=turned, check_finite=False).max()) for turned in (0, 1)
        )
        # bounds the 2-norm; the rest is rounding; an error beyond 1e154 has no square
        return bool((1.01 * error * rows) * (1.01 * error * columns) < 1.0)

    low, high = error, min(room, 4.0 * (error + float(upper.sum()) + float(away[members].max())))
    if not low < high or not holds(high):
        return None
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def reaches(distances: Floats, radii: Floats, clusters: tuple[NDArray[np.intp], ...]) -> Floats:
    """Return how far from each centre the eigenvalue it stands for may be: anywhere in the discs of its cluster."""
    farthest = radii.copy()
    for cluster in clusters:
        if len(cluster) > 1:
            farthest[cluster] = (distances[np.ix_(cluster, cluster)] + radii[cluster][None, :]).max(axis=1)
    return farthest


def spectral_norm(matrix: NDArray[Any]) -> float:
    """Return the 2-norm as numpy's ``norm`` does, which spends as long on checks; of 24 rows and more a bound of it.

    Up to 200 rows it is at most 1.5 times the norm.
    """
    if min(matrix.shape) >= LARGE:
        sizes = np.abs(matrix)
        return math.sqrt(min(np.square(sizes).sum(), sizes.sum(axis=0).max() * sizes.sum(axis=1).max()))
    if min(matrix.shape) >= _SEVERAL:
        scale = float(np.abs(matrix).max())
        if not 0.0 < scale < math.inf:
            return scale
        power = matrix / scale
        power = power.conj().T @ power
        power = power @ power
        return 1.001 * scale * math.sqrt(math.sqrt(math.sqrt(np.linalg.norm(power @ power))))  # n^(1/16) times the norm
    return float(np.linalg.svd(matrix, compute_uv=False)[0])


def symmetric_bounds(matrix: Floats) -> tuple[float, float]:
    """Return a lower and an upper bound of the eigenvalues of a symmetric matrix."""
    values = np.linalg.eigvalsh(matrix)
    slack = 8.0 * EPS * len(values) * float(np.abs(values).max())
    return float(values[0]) - slack, float(values[-1]) + slack


def _inverse(values: NDArray[Any], vectors: NDArray[Any]) -> NDArray[Any]:
    """Return the inverse of eigenvectors; of a large real matrix from the real and imaginary parts of its pairs."""
    upper = np.flatnonzero(values.imag > 0.0)
    if len(values) < LARGE or not np.array_equal(values[upper].conj(), values[np.minimum(upper + 1, len(values) - 1)]):
        return np.asarray(np.linalg.inv(vectors))
    halves = vectors.real.copy()
    halves[:, upper + 1] = vectors[:, upper].imag
    rows = np.linalg.inv(halves).astype(np.complex128)
    real, imaginary = rows[upper], rows[upper + 1]
    rows[upper], rows[upper + 1] = 0.5 * (real - 1j * imaginary), 0.5 * (real + 1j * imaginary)
    return rows


def touching(distances: Floats, radii: Floats) -> tuple[NDArray[np.intp], ...]:
    """Return the sets of discs that touch, directly or by others between them, from their centres' distances (n, n)."""
    n = len(radii)
    near = distances <= radii[:, None] + radii[None, :]
    if are_diagonal(near):
        return tuple(np.arange(n)[:, None])
    left, clusters = set(range(n)), []
    while left:
        members, fresh = set(), {min(left)}
        while fresh:
            members |= fresh
            fresh = {int(j) for i in fresh for j in np.flatnonzero(near[i])} - members
        left -= members
        clusters.append(np.array(sorted(members), dtype=np.intp))
    return tuple(clusters)


def log_distances(first: Complexes, second: Complexes) -> Floats:
    """Return distances (m, n) between logarithms, multiples of 2 pi i aside."""
    gap = first[:, None] - second[None, :]
    turned = np.remainder(gap.imag + math.pi, 2.0 * math.pi) - math.pi
    return np.asarray(np.hypot(gap.real, turned))


def basis_of(discs: Discs, cluster: NDArray[np.intp]) -> Complexes:
    """Return an orthonormal basis of a cluster's invariant subspace."""
    return np.asarray(np.linalg.qr(discs.right[:, cluster])[0])


def subspace_error(discs: Discs, cluster: NDArray[np.intp]) -> float:
    """Return about how far, as an angle, the true invariant subspace of a cluster may be from the computed one."""
    others = np.ones(len(discs.values), dtype=np.bool_)
    others[cluster] = False
    if not others.any():
        return 0.0
    gap = float(np.abs(discs.values[cluster][:, None] - discs.values[others][None, :]).min())
    size = spectral_norm(discs.left[cluster]) * spectral_norm(discs.right[:, cluster])
    return 2.0 * size * discs.spread * discs.error / max(gap, 5e-324)


@dataclass(frozen=True)
class Signs:
    """The sign of a Hermitian form on clusters of eigenvalues: 1 or -1 where it is definite beyond errors, else 0.

    The signs of single eigenvalues are computed for all of them at once.
    """

    discs: Discs
    form: Form  # its matrix times vectors, the columns of a matrix
    size: float  # its norm
    error: float
    vectors: Form = np.asarray  # from coordinates of ``discs`` to the form's
    around: Form | None = None  # spans all vectors of a cluster, where ``discs`` has half of them

    def __call__(self, cluster: NDArray[np.intp]) -> int:
        """Return the sign on a cluster; 0 without eigenvectors."""
        if not self.discs.right.size:
            return 0
        if len(cluster) == 1:
            return int(self._singles[cluster[0]])
        columns, angle = basis_of(self.discs, cluster), subspace_error(self.discs, cluster)
        vectors = self.vectors(columns)
        if self.around is not None:
            spanning = self.around(columns)
            vectors, left = np.linalg.qr(spanning)
            lengths = np.linalg.svd(left, compute_uv=False)
            angle *= 2.0 * float(lengths[0] / max(float(lengths[-1]), 5e-324))
        turned = self.form(vectors)
        values = np.linalg.eigvalsh(vectors.conj().T @ turned)
        slack = self._slack(spectral_norm(turned), angle)
        return 1 if values[0] > slack else -1 if values[-1] < -slack else 0

    @cached_property
    @np.errstate(over="ignore", invalid="ignore")  # equal eigenvalues have angles that are not finite: no sign
    def _singles(self) -> NDArray[np.int_]:
        discs, vectors = self.discs, self.vectors(self.discs.right)
        turned = self.form(vectors)
        values = np.einsum("ij,ij->j", vectors.conj(), turned).real
        gaps = np.abs(discs.values[:, None] - discs.values[None, :])
        np.fill_diagonal(gaps, math.inf)
        conditions = np.linalg.norm(discs.left, axis=1)
        angles = 2.0 * conditions * discs.spread * discs.error / np.maximum(gaps.min(axis=1), 5e-324)
        slack = self._slack(np.linalg.norm(turned, axis=0), angles)
        return np.where(np.abs(values) > slack, np.sign(values), 0.0).astype(int)

    def _slack(self, turned: Any, angle: Any) -> Any:
        """Return the change of the form on vectors an ``angle`` away, ``turned`` the length of their image."""
        return self.error + (2.0 * turned + self.size * angle) * angle


@np.errstate(over="ignore", invalid="ignore")  # an overflow has an error that is not finite
def discriminant(discs: Discs, cluster: NDArray[np.intp]) -> tuple[float, float]:
    """Return ((z1 - z2) / 2)^2 of a real matrix's cluster of two, and its error, far smaller than z1's and z2's.

    The error is infinite without eigenvectors.
    """
    if not discs.right.size:
        return 0.0, math.inf
    basis = basis_of(discs, cluster)
    block = basis.conj().T @ discs.matrix @ basis
    columns, rows = (np.linalg.qr(vectors)[1] for vectors in (discs.right[:, cluster], discs.left[cluster].conj().T))
    projector = spectral_norm(columns @ rows.conj().T)
    error = 4.0 * projector * discs.error
    half = 0.5 * (block[0, 0] - block[1, 1])
    value = half * half + block[0, 1] * block[1, 0]
    spread = 2.0 * abs(half) + abs(block[0, 1]) + abs(block[1, 0])
    return float(value.real), float(error * spread + 2.0 * error * error)
