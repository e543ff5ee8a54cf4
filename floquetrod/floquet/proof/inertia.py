"""How many eigenvalues of an enclosed Hermitian matrix are negative.

Congruence keeps their number (Sylvester).  With V close to the eigenvectors, V^H H V is close to a diagonal matrix;
where in each row the diagonal entry exceeds the sum of the others, the diagonal has the signs of the
eigenvalues (Gershgorin, the others going to zero on a straight line), and V cannot be singular.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod.floquet.proof.balls import Array, up
from floquetrod.floquet.proof.many_digits import Unresolved
from floquetrod.floquet.proof.system_problem import Arithmetic, Matrix


class Inertia(NamedTuple):
    """Number of negative eigenvalues, and the least share by which a diagonal entry exceeds the others of its row."""

    negative: int
    margin: float


def inertia(arithmetic: Arithmetic, matrix: Matrix, sizes: Array) -> Inertia:
    """Count the negative eigenvalues of every Hermitian matrix enclosed; raises `Unresolved` where zero may be one.

    ``sizes`` are the orders of magnitude of the rows, by which rows and columns are scaled.
    """
    scale = 2.0 ** -np.round(0.5 * np.log2(sizes))
    scaled = matrix.shifted(scale[:, None] * scale[None, :])
    centre = scaled.centre()
    if not np.isfinite(centre).all():
        raise Unresolved("Hill's matrix is too large")
    vectors = arithmetic.exact(np.linalg.eigh(centre)[1])
    nearly_diagonal = arithmetic.reduced(vectors.adjoint() @ (scaled @ vectors))
    diagonal, offset = _diagonal(nearly_diagonal)
    sizes = nearly_diagonal.upper()
    np.fill_diagonal(sizes, 0.0)
    others = up(up(sizes.sum(1)) + offset)
    if not (np.abs(diagonal) > others).all():
        raise Unresolved("the sign of an eigenvalue of Hill's matrix cannot be determined")
    return Inertia(int((diagonal < 0.0).sum()), float((1.0 - others / np.abs(diagonal)).min()))


def _diagonal(matrix: Matrix) -> tuple[Array, Array]:
    """Return the real parts of the diagonal as doubles, and upper bounds of their errors."""
    entries = matrix[np.arange(matrix.shape[0]), np.arange(matrix.shape[0])].parts()[0]
    return entries.centre(), entries.offset()
