"""Kernels for the characteristic values of Mathieu's equation and the widths of its tongues.

Each characteristic value is an eigenvalue of one of the four tridiagonal chains of `mathieu_counts`,
found by bisection on the count of negative pivots: the order asked for is the order returned, whatever q.  Here ``q``
keeps its sign, so that a_m and b_m keep theirs (a_m(-q) = b_m(q) for odd m, DLMF 28.2.27).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.compilation import kernel

_NUDGE = 1e-30  # stands in for a pivot of exactly zero


@kernel
def chain_count(x: float, q: float, first: float, shift: float) -> int:
    """Return how many eigenvalues of the chain with diagonal first^2 + shift, (first + 2)^2, ... lie below ``x``."""
    # Sturm's count (J. W. Demmel, Applied Numerical Linear Algebra, 5.3.4): as many pivots d_k = k^2 - x - q^2 /
    # d_(k-1) are negative as eigenvalues lie below x.  The link is q, of the first two rows of the even chain sqrt(2)
    # q; once d > |q| and the next diagonal is at least 2 |q|, no later pivot is negative (head of `mathieu_counts`).
    size = abs(q)
    k = first
    d = (k * k - x) + shift
    link = 2.0 * q if first == 0.0 else q  # the first coupling of the even chain is sqrt(2) q
    count = 0
    while True:
        d = d if d != 0.0 else _NUDGE
        count += d < 0.0
        if d > size and k > 0.0 and (k + 2.0) * (k + 2.0) - x >= 2.0 * size:
            return count
        k += 2.0
        d = (k * k - x) - link * (q / d)
        link = q


@kernel
def first_row(order: int, odd_solution: bool) -> float:
    """Return the square root of the first diagonal entry of the chain that holds a_order or b_order."""
    if order % 2 == 1:
        return 1.0
    return 2.0 if odd_solution else 0.0


@kernel
def corner_shift(order: int, q: float, odd_solution: bool) -> float:
    """Return the shift, 0 or +-q, of the first diagonal entry of the chain that holds a_order or b_order."""
    if order % 2 == 0:
        return 0.0
    return -q if odd_solution else q


class PlaneLine(NamedTuple):
    """A line through the plane of (a, q), a = slope u, q = q0 + q1 u, with a scale of growth^2 along it, w0 + w1 u."""

    slope: float
    q0: float
    q1: float
    w0: float
    w1: float


@kernel
def tongue_bracket(order: int, odd_solution: bool, line: PlaneLine, low: float, high: float) -> tuple[float, float]:
    """Return neighbouring doubles u on a line between which a crosses a_order, or b_order, upwards.

    Along the line the count of characteristic values below a must not fall; u is between ``low`` and ``high``.
    """
    slope, q0, q1, _, _ = line
    first, sign = first_row(order, odd_solution), corner_shift(order, 1.0, odd_solution)
    wanted = int((order - first) / 2.0)  # eigenvalues below it in its chain
    for _ in range(1200):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        q = q0 + q1 * middle
        if chain_count(slope * middle, q, first, sign * q) > wanted:
            high = middle
        else:
            low = middle
    return low, high


@kernel
def characteristic_value(order: int, q: float, odd_solution: bool) -> float:
    """Return a_order(q), or b_order(q) when ``odd_solution``."""
    centre = float(order) * float(order)
    if q == 0.0:
        return centre
    # The coupling has norm at most 2 |q| (Gershgorin), so every eigenvalue moves by no more than that (Weyl).
    reach = 2.0 * abs(q) * (1.0 + 1e-15) + 1e-15 * centre
    low, high = tongue_bracket(order, odd_solution, PlaneLine(1.0, q, 0.0, 1.0, 0.0), centre - reach, centre + reach)
    return 0.5 * (low + high)


@kernel
def _eigenvector(value: float, q: float, first: float, shift: float, rows: int) -> Any:
    """Return an eigenvector of a chain, every component to high relative accuracy (twisted factorisation).

    Pivots run forwards from the first row and backwards from the last; they meet where the vector is largest, and each
    component follows from its neighbour without subtraction, so exponentially small ones keep their digits.
    """
    # Pivots of the tridiagonal matrix with the diagonal d_i and the links l_i: forwards f_i = d_i - l_(i-1)^2 /
    # f_(i-1), backwards b_i = d_i - l_i^2 / b_(i+1).  They meet where f_i + b_i - d_i is smallest; from there on v_i =
    # -l_i / f_i v_(i+1) and v_i = -l_(i-1) / b_i v_(i-1) (I. S. Dhillon and B. N. Parlett, Linear Algebra Appl. 387
    # (2004) 1).
    diagonal = np.empty(rows)
    link = np.empty(rows)
    for i in range(rows):
        k = first + 2.0 * i
        diagonal[i] = k * k - value
        link[i] = q
    diagonal[0] += shift
    if first == 0.0:
        link[0] = math.sqrt(2.0) * q
    forward = np.empty(rows)
    backward = np.empty(rows)
    forward[0] = diagonal[0] if diagonal[0] != 0.0 else _NUDGE
    for i in range(1, rows):
        d = diagonal[i] - link[i - 1] * (link[i - 1] / forward[i - 1])
        forward[i] = d if d != 0.0 else _NUDGE
    backward[rows - 1] = diagonal[rows - 1]
    for i in range(rows - 2, -1, -1):
        d = diagonal[i] - link[i] * (link[i] / backward[i + 1])
        backward[i] = d if d != 0.0 else _NUDGE
    meet = 0
    least = math.inf
    for i in range(rows):
        gap = abs(forward[i] + backward[i] - diagonal[i])
        if gap < least:
            least = gap
            meet = i
    vector = np.empty(rows)
    vector[meet] = 1.0
    for i in range(meet - 1, -1, -1):
        vector[i] = -link[i] / forward[i] * vector[i + 1]
    for i in range(meet + 1, rows):
        vector[i] = -link[i - 1] / backward[i] * vector[i - 1]
    return vector


@kernel
def tongue_width(order: int, q: float) -> float:
    """Return |a_order(q) - b_order(q)| to high relative accuracy, however small, without subtracting the two.

    With u, v the eigenvectors of the chains of a and b, which differ in one corner only,

        odd order:   (a - b) u.v = 2 q u_0 v_0,        even order:  (a - b) u'.v = sqrt(2) q u_0 v_0,

    u' being u without its first component: multiply each eigenvalue equation by the other eigenvector and subtract.
    """
    a = characteristic_value(order, q, False)
    b = characteristic_value(order, q, True)
    top = math.sqrt(max(a, b, 0.0) + 2.0 * abs(q))
    rows = int(0.5 * max(top, float(order))) + 40
    u = _eigenvector(a, q, first_row(order, False), corner_shift(order, q, False), rows + 1)
    v = _eigenvector(b, q, first_row(order, True), corner_shift(order, q, True), rows)
    offset = 0 if order % 2 == 1 else 1
    total = 0.0
    for i in range(rows):
        total += u[i + offset] * v[i]
    corner = 2.0 if order % 2 == 1 else math.sqrt(2.0)
    return float(abs(corner * q * (u[0] / total) * v[0]))


@kernel
def characteristic_fill(order: Any, q: Any, odd_solution: Any, out: Any) -> None:
    """Fill ``out`` with characteristic values."""
    for i in range(len(order)):
        out[i] = characteristic_value(order[i], q[i], odd_solution[i])


@kernel
def width_fill(order: Any, q: Any, out: Any) -> None:
    """Fill ``out`` with tongue widths."""
    for i in range(len(order)):
        out[i] = tongue_width(order[i], q[i])
