"""Complex matrices as real ones of twice the order, and back.

x = u + i v solves x' = (P + i Q) x where (u, v) solves the real system with the matrix [[P, -Q], [Q, P]], whose
multipliers are the complex system's and their conjugates.  Matrices of this form commute with
J = [[0, -1], [1, 0]], as do their sums and products, so that every map of the real system is [[F, -G], [G, F]] with the
map F + i G of the complex one.  With the isometry U = [1; -i] / sqrt(2) it is U^H M U: the nearest such map where M is
rounded, no farther in the 2-norm than M is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def real_matrix(matrix: NDArray[Any]) -> NDArray[Any]:
    """Return [[P, -Q], [Q, P]] of complex matrices P + i Q, (..., n, n) to (..., 2 n, 2 n)."""
    n = matrix.shape[-1]
    real = np.empty((*matrix.shape[:-2], 2 * n, 2 * n))
    real[..., :n, :n] = real[..., n:, n:] = matrix.real
    real[..., n:, :n] = matrix.imag
    real[..., :n, n:] = -np.asarray(matrix.imag)
    return real


def complex_matrix(matrix: NDArray[Any]) -> NDArray[Any]:
    """Return P + i Q of matrices [[P, -Q], [Q, P]], the mean of both copies, (..., 2 n, 2 n) to (..., n, n).

    Also of the complex amplitudes of harmonics of such matrices, and of numbers of mpmath.
    """
    n = matrix.shape[-1] // 2
    diagonal = matrix[..., :n, :n] + matrix[..., n:, n:]
    return np.asarray((diagonal + 1j * (matrix[..., n:, :n] - matrix[..., :n, n:])) / 2)


def real_forms(systems: Sequence[Any]) -> list[Any]:
    """Return systems as they are where all are real, else all with twice as many equations."""
    if not any(getattr(system, "is_complex", False) for system in systems):
        return list(systems)
    return [system.doubled for system in systems]


def real_vector(vector: NDArray[Any]) -> NDArray[np.float64]:
    """Return (u, v) of complex vectors u + i v, (..., n) to (..., 2 n)."""
    return np.concatenate([vector.real, vector.imag], axis=-1)


def complex_vector(vector: NDArray[Any]) -> NDArray[np.complex128]:
    """Return u + i v of vectors (u, v), (..., 2 n) to (..., n)."""
    n = vector.shape[-1] // 2
    return np.asarray(vector[..., :n] + 1j * vector[..., n:])
