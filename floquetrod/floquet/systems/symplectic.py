"""Symplectic maps: the numbers of their pairs of multipliers, and Krein signs.

With J = [[0, I], [-I, 0]] a symplectic S has S^-1 = -J S^T J, and S + S^-1 is skew-Hamiltonian: an orthogonal
symplectic change of coordinates makes it block triangular, [[H, *], [0, H^T]], so that each mu + 1/mu is one
eigenvalue of H.
Van Loan, Linear Algebra Appl. 61 (1984) 233, doi:10.1016/0024-3795(84)90034-X.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod.floquet.systems import spectra
from floquetrod.floquet.systems.spectra import Discs


def symplectic_unit(n: int) -> NDArray[np.float64]:
    """Return J of order 2 n."""
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])


@np.errstate(over="ignore", invalid="ignore")  # of maps that overflow
def pair_matrix(full: NDArray[Any], error: float) -> tuple[NDArray[Any], float]:
    """Return an n x n matrix whose eigenvalues are y = (mu + 1/mu - 2) / 4 of a symplectic map of order 2 n.

    Its entries may be doubles or numbers of mpmath.  Also how far, in the 2-norm, it may be from one that belongs to
    another symplectic map within ``error``.
    """
    n = len(full) // 2
    unit = symplectic_unit(n)
    w = 0.25 * (full - unit @ full.T @ unit) - 0.5 * np.eye(2 * n)
    for j in range(n - 1):
        _reflect(w, w[n + j + 1 :, j].copy(), j + 1)
        _rotate(w, j, j + 1)
        _reflect(w, w[j + 1 : n, j].copy(), j + 1)
    block = np.array(w[:n, :n])
    return block, error + _slip(block, w[:n, n:], error)


def _slip(block: NDArray[Any], coupling: NDArray[Any], error: float) -> float:
    """Return by how much more than ``error`` the block H of [[H, X], [0, H^T]] changes for a change of the whole.

    A change E of the lower left block is removed by a skew P, H^T P - P H = E, which changes H by X P: in coordinates
    of eigenvectors X_ij E_ij / (z_i - z_j), but no more than the root of X_ij E_ij where z_i and z_j are close.
    """
    scale = max((float(abs(v)) for v in block.flat), default=0.0)
    if len(block) == 1 or error == 0.0:
        return 0.0
    reach = float(max(abs(v) for v in coupling.flat)) * len(block)
    most = 2.0 * float(np.sqrt(reach)) * float(np.sqrt(error))
    if not 0.0 < scale < np.inf:
        return most
    try:
        values, right = np.linalg.eig(np.array(block / scale, dtype=float))
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return most
    gaps = np.abs(values[:, None] - values[None, :]) * scale
    coupled = np.abs(left @ np.array(coupling / (reach or 1.0), dtype=float) @ left.T)
    np.fill_diagonal(coupled, 0.0)
    moved = error * float(np.linalg.norm(right, 2)) ** 2
    with np.errstate(divide="ignore"):
        slips = np.fmin(coupled * reach / gaps * moved, np.sqrt(coupled * reach) * np.sqrt(moved))
    return 2.0 * float(np.linalg.norm(slips))


def reversible_pair_matrix(full: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an n x n matrix whose eigenvalues are y of a map S with R S R = S^-1, R = diag(I, -I): a block."""
    n = len(full) // 2
    return 0.5 * (full[:n, :n] - np.eye(n))


def _reflect(w: NDArray[Any], column: NDArray[Any], start: int) -> None:
    """Apply the reflection that leaves only the first entry of ``column``, to both halves of the coordinates."""
    size = _length(column)
    if size == 0 or len(column) == 1:
        return
    column[0] += size if column[0] >= 0 else -size
    column /= _length(column)
    n = len(w) // 2
    for half in (0, n):
        part = slice(half + start, half + n)
        w[part] -= 2.0 * np.outer(column, column @ w[part])
        w[:, part] -= 2.0 * np.outer(w[:, part] @ column, column)


def _rotate(w: NDArray[Any], j: int, i: int) -> None:
    """Rotate coordinates i and n + i so that entry (n + i, j) vanishes."""
    n = len(w) // 2
    size = _length(np.array([w[i, j], w[n + i, j]]))
    if size == 0:
        return
    c, s = w[i, j] / size, w[n + i, j] / size
    turn = np.array([[c, s], [-s, c]])
    both = [i, n + i]
    w[both] = turn @ w[both]
    w[:, both] = w[:, both] @ turn.T


def _length(column: NDArray[Any]) -> Any:
    """Return the norm of a vector of doubles, or of numbers of mpmath."""
    largest = np.abs(column).max(initial=0)
    return 0 if largest == 0 else largest * ((column / largest) @ (column / largest)) ** 0.5


def krein_sign(full: Discs, pairs: Discs, cluster: NDArray[np.intp]) -> int:
    """Return the Krein sign of those multipliers on the upper half of the circle that a cluster of y stands for.

    +1 for a natural oscillator that turns by less than half a turn in a period; 0 where signs are mixed or unknown.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        y = 0.25 * (full.values + 1.0 / full.values - 2.0)
    distance = np.abs(y[:, None] - pairs.values[None, :])
    distance[full.values.imag <= 0.0] = np.inf
    owner = distance.argmin(axis=1)
    members = np.flatnonzero(np.isin(owner, cluster) & (full.values.imag > 0.0))
    if len(members) != len(cluster):
        return 0
    return spectra.definiteness(full, members, krein_form, 1.0, 0.0)


def krein_form(vectors: NDArray[Any]) -> NDArray[np.complex128]:
    """Return -i J times vectors."""
    n = len(vectors) // 2
    return np.asarray(-1j * np.concatenate([vectors[n:], -vectors[:n]]))
