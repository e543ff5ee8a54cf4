"""Eigenvalues with errors, to many digits, for the method `reference`: `spectra` has them in doubles."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.floquet.multipliers.spectra import Discs, is_coarse, touching, triangular_radii
from floquetrod.floquet.multipliers.symplectic import PairMatrix


class PreciseDiscs(NamedTuple):
    """Eigenvalues as in `Discs`; values and vectors are numbers of mpmath, vectors empty where they fail."""

    values: NDArray[Any]
    radii: Floats  # (n,), doubles, rounded up
    clusters: tuple[NDArray[np.intp], ...]  # indices of the eigenvalues whose discs touch
    right: NDArray[Any]
    left: NDArray[Any]
    error: float  # not zero
    size: float  # norm of the matrix

    def rounded(self) -> Discs:
        """Return values, radii and clusters as doubles; the vectors are left out."""
        nothing = np.zeros((0, 0), dtype=np.complex128)
        values = self.values.astype(np.complex128)
        return Discs(values, self.radii, self.clusters, nothing, nothing, self.error, nothing, 0.0)


def eigenvalue_discs(matrix: NDArray[Any], error: float, context: Any) -> PreciseDiscs | None:
    """Return discs for the eigenvalues of all matrices within ``error`` of ``matrix``, as `spectra` does.

    None where numbers are beyond the range of doubles, or the eigenvalues do not converge.
    """
    n = len(matrix)
    size = math.hypot(*(float(abs(v)) for v in matrix.flat))
    total = 1.001 * error + math.ldexp(64.0 * n * n * (size + 1e-300), -context.prec)
    if not math.isfinite(total):
        return None
    discs = _discs_of_vectors(matrix, total, size, context)
    if discs is not None and not is_coarse(discs.radii, discs.clusters, size):
        return discs
    triangular = _discs_of_triangle(matrix, total, size, context)
    if discs is None or (triangular is not None and triangular.radii.max() < discs.radii.max()):
        return triangular
    return discs


def _discs_of_triangle(matrix: NDArray[Any], total: float, size: float, context: Any) -> PreciseDiscs | None:
    """Return discs from the complex Schur form."""
    try:
        triangle = _array(context.schur(context.matrix(matrix.tolist()))[1])
    except (ZeroDivisionError, OverflowError, RuntimeError):
        return None
    values = np.diag(triangle).copy()
    gaps = _gaps(values)
    upper = np.array([[float(abs(v)) for v in row] for row in np.triu(triangle, 1)])
    radii, nothing = triangular_radii(gaps, upper, total), np.zeros((0, 0), dtype=object)
    return PreciseDiscs(values, radii, touching(gaps, radii), nothing, nothing, total, size)


def _discs_of_vectors(matrix: NDArray[Any], total: float, size: float, context: Any) -> PreciseDiscs | None:
    """Return Gershgorin's discs in the coordinates of the eigenvectors; None where these fail."""
    n = len(matrix)
    try:
        eigenvalues, vectors = context.eig(context.matrix(matrix.tolist()))
        right = _array(vectors)
        lengths = [context.sqrt(sum(abs(v) ** 2 for v in column)) for column in right.T]
        right = right / np.array(lengths, dtype=object)
        left = _array(context.inverse(context.matrix(right.tolist())))
        conditions = np.array([_norm(row) for row in left])
    except (ZeroDivisionError, OverflowError, RuntimeError):  # eigenvectors in one direction; no convergence
        return None
    values = np.array(list(eigenvalues), dtype=object)
    uncertainty = math.ldexp(n * n * _norm(left.ravel()), -context.prec)
    if not uncertainty < 0.1:
        return None
    radii = n * conditions * total * (1.0 + 2.0 * uncertainty)
    gaps = _gaps(values)
    clusters = touching(gaps, radii)
    for cluster in clusters:
        if len(cluster) == 1 and n > 1:
            i, others = cluster[0], np.arange(n) != cluster[0]
            share = float((conditions[others] * total / (gaps[i, others] - radii[others] - radii[i])).max())
            if share < 1.0:
                radii[i] = conditions[i] * total * (1.0 + (n - 1) * share) * (1.0 + 2.0 * uncertainty)
    return PreciseDiscs(values, radii, clusters, right, left, total, size)


def discriminant(discs: PreciseDiscs, cluster: NDArray[np.intp]) -> tuple[float, float]:
    """Return ((z1 - z2) / 2)^2 of a real matrix's cluster of two, and its error, far smaller than z1's and z2's."""
    if not discs.right.size:
        return 0.0, math.inf
    half = (discs.values[cluster[0]] - discs.values[cluster[1]]) / 2
    error = 4.0 * _norm(np.dot(discs.right[:, cluster], discs.left[cluster]).ravel()) * discs.error
    value = float((half * half).real)
    return value, error * (4.0 * discs.size + 2.0 * error) + 1e-15 * abs(value)


def krein_sign(pairs: PairMatrix, discs: PreciseDiscs, cluster: NDArray[np.intp]) -> int:
    """Return the Krein sign of a cluster of y: of its multipliers on the upper half of the circle, 0 where mixed."""
    if not discs.right.size:
        return 0
    vectors = discs.right[:, cluster]
    columns = np.dot(pairs.basis, vectors)
    if len(cluster) > 1:  # one vector of a single pair will do, whose sign is that of all
        columns = np.hstack([columns, np.dot(pairs.image, vectors)])
    basis, spread = _orthonormal(columns)
    turned = np.dot(pairs.form, basis)
    values = np.linalg.eigvalsh(np.dot(basis.T.conj(), turned).astype(np.complex128))
    slack = 1e-12 + pairs.error + 2.0 * _norm(pairs.form.ravel()) * spread * _subspace_error(discs, cluster)
    return 1 if values[0] > slack else -1 if values[-1] < -slack else 0


def _orthonormal(columns: NDArray[Any]) -> tuple[NDArray[Any], float]:
    """Return an orthonormal basis of the span of columns, and their norm over the shortest remainder of one."""
    basis: list[NDArray[Any]] = []
    lengths = []
    for column in columns.T:
        for _ in range(2):
            for direction in basis:
                overlap = sum(v.conjugate() * x for v, x in zip(direction, column, strict=True))
                column = column - overlap * direction
        lengths.append(sum(abs(v) ** 2 for v in column) ** 0.5)
        basis.append(column / (lengths[-1] or 1))
    shortest = float(min(lengths))
    return np.array(basis, dtype=object).T, _norm(columns.ravel()) / shortest if shortest > 0.0 else math.inf


def _subspace_error(discs: PreciseDiscs, members: NDArray[np.intp]) -> float:
    """Return about the angle between the true and the computed invariant subspace of the eigenvalues ``members``."""
    others = np.setdiff1d(np.arange(len(discs.values)), members)
    if not len(others):
        return 0.0
    gap = min(float(abs(discs.values[i] - discs.values[j])) for i in members for j in others)
    size = _norm(discs.left[members].ravel()) * math.sqrt(len(members)) * _norm(discs.left[others].ravel())
    return size * discs.error / gap if gap > 0.0 else math.inf


def _gaps(values: NDArray[Any]) -> Floats:
    """Return the distances of numbers of mpmath from each other, rounded to doubles."""
    return np.array([[float(abs(a - b)) for b in values] for a in values]).reshape(len(values), len(values))


def _norm(numbers: NDArray[Any]) -> float:
    return math.sqrt(sum(float(abs(v)) ** 2 for v in numbers))


def _array(matrix: Any) -> NDArray[Any]:
    """Return a matrix of mpmath as an array."""
    return np.array(matrix.tolist(), dtype=object).reshape(matrix.rows, matrix.cols)
