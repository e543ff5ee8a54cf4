"""Where the multipliers lie: discs that contain the eigenvalues of an enclosed matrix.

With V close to the matrix of eigenvectors and W to its inverse, V^-1 M V = (W V)^-1 (W M V) is close to a diagonal
matrix, and Gershgorin's theorem applies: discs that touch no others hold as many eigenvalues as they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod.floquet.proof.balls import Array, down, up
from floquetrod.floquet.proof.many_digits import Unresolved
from floquetrod.floquet.proof.system_problem import Arithmetic, Matrix

_ROUND = 2.0**-51  # of two operations with doubles


class EigenvalueDiscs(NamedTuple):
    """Discs whose union contains all eigenvalues, with multiplicity; a connected part of it as many as it has discs.

    ``centres`` are rounded to doubles.  ``low`` and ``high`` bound abs(z)^2 - 1 over each disc.  ``gaps`` are lower
    bounds of the distance between two discs, below zero where they may touch and infinite on the diagonal.
    """

    centres: Array
    radii: Array
    low: Array
    high: Array
    gaps: Array

    @property
    def isolated(self) -> Array:
        """Whether each disc touches no other, so that it holds one eigenvalue."""
        return (self.gaps > 0.0).all(1)

    def parts(self) -> list[Array]:
        """Return the connected parts, each as the indices of its discs."""
        from scipy.sparse.csgraph import connected_components

        count, label = connected_components(~(self.gaps > 0.0), directed=False)
        return [np.flatnonzero(label == i) for i in range(count)]

    def on_circle(self) -> Array:
        """Return which discs hold one eigenvalue of modulus 1, where with mu there is 1 / conj(mu).

        The mirror image of such a disc meets no other disc, so its eigenvalue is its own mirror image.
        """
        shift = np.maximum(np.abs(self.low), np.abs(self.high))  # abs(z - 1 / conj(z)) = abs(abs(z)^2 - 1) / abs(z)
        least = np.sqrt(np.maximum(down(1.0 + self.low), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.isolated & (least > 0.0) & (up(shift / least)[:, None] < self.gaps).all(1)


def enclose_eigenvalues(arithmetic: Arithmetic, matrix: Matrix) -> EigenvalueDiscs:
    """Return discs that contain the eigenvalues of every matrix enclosed."""
    if not np.isfinite(matrix.upper()).all():
        raise Unresolved("the map over a period is too large")
    vectors, inverse = arithmetic.eigenvectors(matrix)
    return _gershgorin(arithmetic, _similar(arithmetic, matrix, vectors, inverse))


def _similar(arithmetic: Arithmetic, matrix: Matrix, vectors: Matrix, inverse: Matrix) -> Matrix:
    """Enclose V^-1 M V."""
    product = inverse @ (matrix @ vectors)
    defect = (inverse @ vectors - arithmetic.exact(np.eye(matrix.shape[0]))).upper()
    size = float(up(defect.sum(-1)).max())
    if not size < 0.5:
        raise Unresolved("a multiple multiplier cannot be excluded")
    # With W V = I + F, abs(F) <= defect: the entries of I - (I + F)^-1 are at most defect + size^2 / (1 - size).
    inverse_error = up(defect + up(size * size / (1.0 - size)))
    return product.widened(up(inverse_error @ product.upper()))


def _gershgorin(arithmetic: Arithmetic, matrix: Matrix) -> EigenvalueDiscs:
    """Return Gershgorin's discs, those that touch no others shrunk by a scaling of their own."""
    n = matrix.shape[0]
    diagonal = matrix[np.arange(n), np.arange(n)]
    centres, own = diagonal.centred()
    others = matrix.upper()
    np.fill_diagonal(others, 0.0)
    radii = up(own + up(others.sum(1)))
    apart = (centres[:, None] - centres[None, :]).lower()
    np.fill_diagonal(apart, 0.0)
    gaps = _gaps(apart, radii)
    # Unknown i times e, all others kept: its radius shrinks by e, those of others grow by others[j, i] / e.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        scale = up(4.0 * others.T / gaps).max(1)
    shrinks = (gaps > 0.0).all(1) & (scale < 1.0)
    radii = np.where(shrinks, up(own + up(scale * others.sum(1))), radii)
    real, imaginary = centres.parts()
    square = real * real + imaginary * imaginary - arithmetic.exact(np.ones(n))
    sizes = up(centres.upper() + radii)
    reach = up(radii * up(2.0 * sizes))
    middle = square.centre()
    error = up(up(square.offset() + reach) + _ROUND * (np.abs(middle) + reach))
    return EigenvalueDiscs(centres.centre(), radii, middle - error, middle + error, _gaps(apart, radii))


def _gaps(apart: Array, radii: Array) -> Array:
    """Return lower bounds of the distance between two discs, infinite on the diagonal."""
    together = up(radii[:, None] + radii[None, :])
    gaps = np.where(together < apart, (apart - together) * (1.0 - _ROUND), -1.0)
    np.fill_diagonal(gaps, np.inf)
    return gaps
