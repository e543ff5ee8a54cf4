"""Symplectic maps: the numbers of their pairs of multipliers, and Krein signs.

With J = [[0, I], [-I, 0]] a symplectic S has S^-1 = -J S^T J.  W = (S + S^-1 - 2) / 4 is skew-Hamiltonian, so that its
Krylov spaces are isotropic: an orthonormal basis Q of n columns, Q^T J Q = 0, with W Q = Q H has the number
y = (mu + 1/mu - 2) / 4 of each pair of multipliers once, as an eigenvalue of H.
Mehrmann and Watkins, SIAM J. Sci. Comput. 22 (2001) 1905, doi:10.1137/S1064827500366434.

D = J (S - S^-1) / 2 is symmetric and D W = W^T D.  On the two dimensions that belong to a pair on the circle it is
definite, and negative where the multiplier on the upper half has the Krein sign +1.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.multipliers.spectra import Discs, Eigen

_BROKEN = 64.0  # roundings of a product with W, below which its remainder is no new direction


class PairMatrix(NamedTuple):
    """A matrix whose eigenvalues are the numbers y of a symplectic map S, its entries doubles or of mpmath."""

    matrix: NDArray[Any]  # (n, n), H
    error: float  # how far, in the 2-norm, H may be from one that belongs to the true map
    basis: NDArray[Any]  # (2 n, n), Q
    image: NDArray[Any]  # (2 n, n), S Q
    form: NDArray[Any]  # (2 n, 2 n), -D
    eigen: Eigen | None  # eigenvalues of H in doubles; None where they fail


def symplectic_unit(n: int) -> Floats:
    """Return J of order 2 n."""
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])


@np.errstate(over="ignore", invalid="ignore")  # of maps that overflow
def pair_matrix(full: NDArray[Any], error: float, rounding: float = EPS) -> PairMatrix:
    """Return the matrix of the pairs of a symplectic map of order 2 n, known within ``error`` in the 2-norm.

    ``rounding`` is the relative one of the map's entries.
    """
    n = len(full) // 2
    back = np.block([[full[n:, n:].T, -full[:n, n:].T], [-full[n:, :n].T, full[:n, :n].T]])
    w = 0.25 * (full + back) - 0.5 * np.eye(2 * n)
    scale = _scale(w)
    w = w / scale
    basis = _isotropic(w, rounding)
    turned = np.concatenate([basis[n:], -basis[:n]])
    moved = w @ basis
    block, coupling = basis.T @ moved, _doubles(basis.T @ (w @ turned))
    missed = error / scale + float(np.linalg.norm(_doubles(turned.T @ moved)))
    eigen = spectra.eigen(_doubles(block))
    slip = _slip(eigen, coupling, missed) if n > 1 and missed > 0.0 else 0.0
    half = 0.5 * (back - full)
    return PairMatrix(
        scale * block,
        scale * (missed + slip),
        basis,
        full @ basis,
        np.concatenate([half[n:], -half[:n]]),
        None if eigen is None else eigen._replace(values=scale * eigen.values),
    )


def _doubles(matrix: NDArray[Any]) -> Floats:
    return np.asarray(matrix, dtype=float)


def _scale(matrix: NDArray[Any]) -> float:
    """Return a power of two next to the largest entry, 1 for zero and infinite matrices."""
    largest = float(np.abs(_doubles(matrix)).max())
    return math.ldexp(1.0, math.frexp(largest)[1]) if 0.0 < largest < 2.0**1000 else 1.0


def _isotropic(w: NDArray[Any], rounding: float) -> NDArray[Any]:
    """Return the basis (2 n, n) of a Krylov space, continued from the next coordinate where it ends."""
    n = len(w) // 2
    rows = np.zeros((2 * n, 2 * n), dtype=w.dtype)  # each column of the basis, and J times it
    column = np.eye(1, 2 * n, dtype=w.dtype)[0]
    for k in range(n):
        rows[2 * k] = column
        rows[2 * k + 1, :n], rows[2 * k + 1, n:] = column[n:], -column[:n]
        spanned = rows[: 2 * k + 2]
        product = w @ column
        column = _beside(spanned, product)
        if not _length(column) > _BROKEN * rounding * _length(product):
            left = 1.0 - np.square(spanned).sum(axis=0)
            column = _beside(spanned, np.eye(1, 2 * n, int(left.argmax()), dtype=w.dtype)[0])
        if k < n - 1:
            column = _beside(spanned, column / _length(column))
            column = column / _length(column)
    return rows[::2].T


def _beside(rows: NDArray[Any], column: NDArray[Any]) -> NDArray[Any]:
    """Return the remainder of a vector orthogonal to orthonormal rows."""
    return np.asarray(column - (rows @ column) @ rows)


def _slip(eigen: Eigen | None, coupling: Floats, error: float) -> float:
    """Return the change, beyond ``error``, of the block H of [[H, X], [0, H^T]] for a change of the whole matrix.

    A change E of the lower left block is removed by a skew P, H^T P - P H = E, which changes H by X P: in coordinates
    of eigenvectors X_ij E_ij / (z_i - z_j), but no more than the root of X_ij E_ij where z_i and z_j are close.
    """
    if eigen is None:
        return 2.0 * math.sqrt(float(np.linalg.norm(coupling)) * error)
    gaps = np.abs(eigen.values[:, None] - eigen.values[None, :])
    coupled = np.abs(eigen.left @ coupling @ eigen.left.T)
    np.fill_diagonal(coupled, 0.0)
    moved = error * spectra.spectral_norm(eigen.right) ** 2
    with np.errstate(divide="ignore"):
        slips = np.fmin(coupled / gaps * moved, np.sqrt(coupled * moved))
    return 2.0 * float(np.linalg.norm(slips))


def reversible_pair_matrix(full: Floats) -> Floats:
    """Return an n x n matrix whose eigenvalues are y of a map S with R S R = S^-1, R = diag(I, -I): a block."""
    n = len(full) // 2
    return 0.5 * (full[:n, :n] - np.eye(n))


def _length(column: NDArray[Any]) -> Any:
    return (column @ column) ** 0.5


def krein_signs(pairs: PairMatrix, discs: Discs) -> spectra.Signs:
    """Return the Krein signs of clusters of y: of their multipliers on the upper half of the circle.

    +1 for a natural oscillator that turns by less than half a turn in a period; 0 where signs are mixed or unknown.
    """
    return spectra.Signs(
        discs,
        lambda vectors: pairs.form @ vectors,
        float(np.linalg.norm(pairs.form)),
        pairs.error,
        lambda columns: pairs.basis @ columns,
        lambda columns: np.hstack([pairs.basis @ columns, pairs.image @ columns]),
    )


def krein_form(vectors: NDArray[Any]) -> Complexes:
    """Return -i J times vectors."""
    n = len(vectors) // 2
    return np.asarray(-1j * np.concatenate([vectors[n:], -vectors[:n]]))
