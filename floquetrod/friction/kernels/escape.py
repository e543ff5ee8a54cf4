"""The decaying solution of the adjoint equation, cell by cell, and the integral of its size over all later time.

Motions against friction are tested for escape with it, see `floquetrod.friction.kernels.stick_slip_motion`.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.friction.kernels.records import PERIOD


@kernel
def _left_vector(cells: Any, begin: int, end: int, decay: float) -> tuple[float, float]:
    """Return the left eigenvector of the period's matrix that belongs to the growing solution, of length 1.

    Rows of M - L I, L the smaller eigenvalue, are multiples of it (Cayley and Hamilton).  ``decay`` is the size of L.
    """
    # M = product of the matrices of the cells, the first acting first, divided by its largest entry whenever that is
    # large (``scale``).  (M - L1)(M - L2) = 0, so that rows r of M - L2 obey r (M - L1) = 0: the longer row is the
    # better one.  L2, the smaller eigenvalue, has the sign of the trace, and is not taken from M, where it would be
    # lost by cancellation.
    m11, m12, m21, m22 = cells["m11"], cells["m12"], cells["m21"], cells["m22"]
    a, b, c, d = 1.0, 0.0, 0.0, 1.0
    scale = 1.0
    for k in range(begin, end):
        p, q, r, s = m11[k], m12[k], m21[k], m22[k]
        a, b, c, d = p * a + q * c, p * b + q * d, r * a + s * c, r * b + s * d
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
def vectors_fill(begin: Any, end: Any, damping: Any, rate: Any, out: Any, cells: Any, vectors: Any) -> None:
    """Fill ``vectors`` with the left vector at the beginning of each cell, and its length before it was made 1.

    An equation's cells are those from ``begin`` to ``end``; ``rate`` is its growth, damping included.  ``out`` is the
    share of psi that is lost in a period.
    """
    # Left vectors l of the adjoint equation go backwards: l at the beginning of a cell is (l at its end) M_cell, made
    # 1, with its length kept.  Forwards they decay, so backwards the wanted one grows over the other, by a period's
    # factor a turn: two turns leave it alone.  begin, end, damping, rate and out are (n,), of equations; vectors and
    # cells lie in one line.
    m11, m12, m21, m22 = cells["m11"], cells["m12"], cells["m21"], cells["m22"]
    first, second, length = vectors["l1"], vectors["l2"], vectors["length"]
    for i in range(len(begin)):
        out[i] = -math.expm1(-PERIOD * rate[i])
        l1, l2 = _left_vector(cells, begin[i], end[i], math.exp(-PERIOD * (rate[i] + 2.0 * damping[i])))
        for _ in range(2):  # once around takes out what is left of the other eigenvector
            for k in range(end[i] - 1, begin[i] - 1, -1):
                m1 = l1 * m11[k] + l2 * m21[k]
                m2 = l1 * m12[k] + l2 * m22[k]
                size = math.hypot(m1, m2)
                l1, l2 = m1 / size, m2 / size
                first[k], second[k], length[k] = l1, l2, size


@kernel
def escape_fill(begin: Any, end: Any, shrink: Any, out: Any, vectors: Any, sizes: Any, cells: Any) -> None:
    """Fill the escape test of ``cells``: the left vectors, divided by the integral of abs(psi) from the cell onwards.

    ``sizes`` holds the integral over each cell for a vector of length 1.  ``out`` is the kick above which all escape.
    """
    # The test is |l (A, A')| > integral of |psi| over all later time, psi the solution that l belongs to.  From cell to
    # cell backwards, left = sizes[k] + left / length[k], since a vector of length 1 at the beginning of cell k has 1 /
    # length[k] at its end.  The first sweep gives the integral over one period; all later ones follow as a geometric
    # series of the factor 1 - shrink, so dividing by ``shrink`` sums it; the second sweep writes e = l / left.  A kick
    # is A = 0, A' = kick.
    e1, e2, l1, l2, length = cells["e1"], cells["e2"], vectors["l1"], vectors["l2"], vectors["length"]
    for i in range(len(begin)):
        left = 0.0
        for sweep in range(2):
            for k in range(end[i] - 1, begin[i] - 1, -1):
                left = sizes[k] + left / length[k]
                if sweep == 1:
                    e1[k] = l1[k] / left
                    e2[k] = l2[k] / left
            if sweep == 0:
                left /= shrink[i]
        slope = abs(e2[begin[i]])
        out[i] = 1.0 / slope if slope > 0.0 else math.inf
