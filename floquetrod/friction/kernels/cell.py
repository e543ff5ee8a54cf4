"""One cell of a motion against friction: its Taylor series, and the first reversal in it.

Polynomials are in x = (t - tau) / h from the cell's beginning tau, h its length.  All but the search for roots serve
arrays of cells too: coefficients in rows.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

ORDER = 16  # of the series of p: with the cells below, what is left out is under 1e-17
TERMS = ORDER + 2  # coefficients of A
CELL_WAVE = 0.7  # longest cell times the largest sqrt(abs(p)), and times 2 c
HALVINGS = 45  # of a cell in search of a reversal
_NARROWEST = 2.0**-HALVINGS
_NEAR = 1e-9  # relative step of Newton's method after which the next would be below rounding
_EPS = 2.220446049250313e-16
_INVERSE = np.array([1.0 / ((j + 1.0) * (j + 2.0)) for j in range(TERMS)])
_BERNSTEIN = np.array(
    [
        [
            [math.comb(i, j) / math.comb(n, j) if j <= i <= n else 0.0 for j in range(ORDER + 1)]
            for i in range(ORDER + 1)
        ]
        for n in (ORDER, ORDER - 1, ORDER - 2)
    ]
)
"""From powers to Bernstein coefficients, for the degrees that occur."""


@kernel
def series(sine: Any, cosine: Any, beta: Any, c: Any, s: Any, h: Any, a0: Any, a1: Any, p: Any, a: Any) -> None:
    """Fill ``a`` with the coefficients of A, from A = a0 and h A' = a1 at the beginning of the cell.

    There ``sine`` is alpha sin tau and ``cosine`` alpha cos tau; friction forces with -s; ``p`` is scratch space.
    """
    square = h * h
    order = len(a) - 2  # of the arrays, not the constant: loops that the compiler need not unroll
    p[0] = sine * square
    p[1] = cosine * square * h
    for i in range(order - 1):
        p[i + 2] = -p[i] * (square * _INVERSE[i])
    p[0] += beta * square
    a[0] = a0
    a[1] = a1
    drag = -2.0 * c * h
    for j in range(order):
        total = -s * square if j == 0 else 0.0
        for i in range(j, -1, -1):  # the newest coefficient last: the sum need not wait for it
            total += p[i] * a[j - i]
        a[j + 2] = (total + drag * (j + 1.0) * a[j + 1]) * _INVERSE[j]


@kernel
def value(a: Any, x: Any) -> Any:
    """Return A from its series."""
    total = 0.0
    for j in range(len(a) - 1, -1, -1):
        total = total * x + a[j]
    return total


@kernel
def slope(a: Any, x: Any) -> Any:
    """Return dA/dx from the series of A."""
    total = 0.0
    for j in range(len(a) - 1, 0, -1):
        total = total * x + j * a[j]
    return total


@kernel
def at_the_end(a: Any) -> tuple[Any, Any]:
    """Return A and dA/dx at x = 1."""
    total = 0.0
    rate = 0.0
    for j in range(len(a) - 1, 0, -1):
        total += a[j]
        rate += j * a[j]
    return total + a[0], rate


@kernel
def _bracketed_root(q: Any, n: int, low: float, high: float) -> float:
    """Return the zero of the polynomial q of degree n in [low, high], where it falls from positive to not positive."""
    # Newton's method on q(x) = sum_j q_j x^j, q(low) > 0 >= q(high): f and d are q and its derivative by Horner's rule,
    # both from one pass; where a step leaves the bracket, its middle is taken.  The start is the zero of a parabola, in
    # the form 2 q_0 / (sqrt(q_1^2 - 4 q_0 bend) - q_1), which does not cancel for q_1 <= 0.
    x = 0.5 * (low + high)
    if low == 0.0 and high == 1.0 and q[1] <= 0.0:  # from the parabola through both ends with the slope at the first
        end = q[n]
        for j in range(n - 1, -1, -1):
            end += q[j]
        if q[0] > 0.0 >= end:
            bend = end - q[0] - q[1]
            x = min(1.0, 2.0 * q[0] / (math.sqrt(max(0.0, q[1] * q[1] - 4.0 * q[0] * bend)) - q[1]))
    for _ in range(80):
        f = q[n]
        d = 0.0
        for j in range(n - 1, -1, -1):
            d = d * x + f
            f = f * x + q[j]
        if f > 0.0:
            low = x
        else:
            high = x
        new = x - f / d if d != 0.0 else low
        inside = low < new < high
        if not inside:
            new = 0.5 * (low + high)
        if (inside and abs(new - x) <= _NEAR * x) or high - low <= 2.0 * _EPS * high:
            return new
        x = new
    return x


@kernel
def first_root(q: Any, n: int, stack: Any) -> float:
    """Return the first zero in (0, 1] of the polynomial q of degree n, positive at 0; -1 where there is none.

    Most are monotone by a bound on the slope.  Else Bernstein coefficients without a change of sign exclude a zero, one
    change means one zero, more are halved.  Zeros that `HALVINGS` do not separate count as tangency: no reversal.
    """
    bound = 0.0
    end = 0.0
    for j in range(n, 1, -1):
        bound += j * abs(q[j])
        end += q[j]
    end += q[1] + q[0]
    # |q'(x) - q_1| <= sum_(j > 1) j |q_j| on [0, 1]: q is monotone where |q_1| exceeds that.
    if q[1] >= bound or (q[1] <= -bound and end > 0.0):
        return -1.0
    if q[1] <= -bound:
        return _bracketed_root(q, n, 0.0, 1.0)
    # b_i = sum_(j <= i) C(i, j) / C(n, j) q_j: as many zeros as changes of sign of b, or fewer by an even number.
    for i in range(n + 1):
        total = 0.0
        for j in range(i + 1):
            total += _BERNSTEIN[ORDER - n, i, j] * q[j]
        stack[0, i] = total
    depth = 0
    low = 0.0
    width = 1.0
    # stack[depth] is the piece looked at; below it lie right halves still to be looked at, widest first.
    while True:
        changes = 0
        positive = True
        for i in range(n + 1):
            if stack[depth, i] != 0.0 and (stack[depth, i] > 0.0) != positive:
                changes += 1
                positive = not positive
        if changes == 1 and not positive:
            return _bracketed_root(q, n, low, low + width)
        if changes == 0 or width < _NARROWEST:
            # No zero here: continue with the right half stored last.
            low += width
            if depth == 0 or low >= 1.0:
                return -1.0
            depth -= 1
            width = stack[depth, n + 1]
            continue
        # Halve (de Casteljau): the right half replaces the piece, the left is put on top.
        for i in range(n + 1):
            stack[depth + 1, i] = stack[depth, i]
        width *= 0.5
        for j in range(1, n + 1):
            for i in range(n + 1 - j):
                stack[depth, i] = 0.5 * (stack[depth, i] + stack[depth, i + 1])
            # stack[depth, 0] is the left half's next coefficient; the right half's come out in place, last first.
            stack[depth + 1, j] = stack[depth, 0]
        stack[depth, n + 1] = width
        depth += 1
        stack[depth, n + 1] = width
