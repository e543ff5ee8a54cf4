"""The decaying solution of the adjoint equation, cell by cell, and the integral of its size over all later time.

Motions against friction are tested for escape with it, see `floquetrod.kernels.friction`.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel


@kernel
def _left_vector(table: Any, begin: int, end: int, decay: float) -> tuple[float, float]:
    """Return the left eigenvector of the period's matrix that belongs to the growing solution, of length 1.

    Rows of M - L I, L the smaller eigenvalue, are multiples of it (Cayley and Hamilton).  ``decay`` is the size of L.
    """
    a, b, c, d = 1.0, 0.0, 0.0, 1.0
    scale = 1.0
    for k in range(begin, end):
        m11, m12, m21, m22 = table[k, 0], table[k, 1], table[k, 2], table[k, 3]
        a, b, c, d = m11 * a + m12 * c, m11 * b + m12 * d, m21 * a + m22 * c, m21 * b + m22 * d
        size = max(abs(a), abs(b), abs(c), abs(d))
        if size > 1e100:
            a, b, c, d, scale = a / size, b / size, c / size, d / size, scale / size
    small = decay * scale if a + d >= 0.0 else -decay * scale
    a -= small
    d -= small
    first = math.hypot(a, b)
    second = math.hypot(c, d)
    if first >= second:
        return (a / first, b / first) if first > 0.0 else (0.0, 0.0)
    return c / second, d / second


@kernel
def vectors_fill(begin: Any, end: Any, damping: Any, rate: Any, out: Any, tables: Any, vectors: Any) -> None:
    """Fill ``vectors`` with the left vector at the beginning of each cell, and its length before it was made 1.

    An equation's cells are those from ``begin`` to ``end``; ``rate`` is its growth, damping included.  ``out`` is the
    share of psi that a period takes away.
    """
    for i in range(len(begin)):
        out[i] = -math.expm1(-2.0 * math.pi * rate[i])
        l1, l2 = _left_vector(tables, begin[i], end[i], math.exp(-2.0 * math.pi * (rate[i] + 2.0 * damping[i])))
        for _ in range(2):  # once around takes out what is left of the other eigenvector
            for k in range(end[i] - 1, begin[i] - 1, -1):
                m1 = l1 * tables[k, 0] + l2 * tables[k, 2]
                m2 = l1 * tables[k, 1] + l2 * tables[k, 3]
                size = math.hypot(m1, m2)
                l1, l2 = m1 / size, m2 / size
                vectors[k, 0], vectors[k, 1], vectors[k, 2] = l1, l2, size


@kernel
def rows_fill(begin: Any, end: Any, shrink: Any, out: Any, vectors: Any, sizes: Any, tables: Any) -> None:
    """Fill the columns of the escape test: the left vectors over what is left of the integral of abs(psi).

    ``sizes`` holds that integral over each cell for a vector of length 1.  ``out`` is the kick above which all escape.
    """
    for i in range(len(begin)):
        left = 0.0
        for sweep in range(2):
            for k in range(end[i] - 1, begin[i] - 1, -1):
                left = sizes[k] + left / vectors[k, 2]
                if sweep == 1:
                    tables[k, 9] = vectors[k, 0] / left
                    tables[k, 10] = vectors[k, 1] / left
            if sweep == 0:
                left /= shrink[i]
        slope = abs(tables[begin[i], 10])
        out[i] = 1.0 / slope if slope > 0.0 else math.inf
