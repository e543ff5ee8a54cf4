"""Kernels that count the transition curves of Mathieu's equation below a point, and the verdicts that follow.

In the form y'' + (a - 2 q cos 2 z) y = 0, Hill's infinite matrix splits by symmetry into four real symmetric
tridiagonal chains.  With q >= 0 (its sign only shifts time) their diagonals are

    even, period pi    0, 4, 16, 36, ...   off-diagonals squared 2 q^2, q^2, q^2, ...
    odd,  period pi       4, 16, 36, ...                                q^2, q^2, ...
    period 2 pi        1 + q, 9, 25, ...                          q^2,  q^2, q^2, ...
    period 2 pi        1 - q, 9, 25, ...                          q^2,  q^2, q^2, ...

and their eigenvalues are the characteristic values a_0 < b_1 <= a_1 < b_2 <= ... (DLMF 28.2, 28.4).

The number N of them below a is the number of negative pivots d_k = D_k - a - q^2 / d_(k-1).  Once d_k > q and
D_j - a >= 2 q for all later j, d_(k+1) >= 2 q - q^2 / q = q, strictly: every later pivot stays above q, so the count of
the *infinite* matrices is known when all four chains get there.  Solutions are bounded when a lies between a_m
and b_(m+1), that is when N is odd.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.arrays import EPS
from floquetrod._util.compilation import kernel
from floquetrod.floquet.status import STABLE, UNSTABLE

NEAR_A_BAND = -1  # a count shows no status

UNDECIDED = -1  # count of a chain whose pivots would not settle: a is an eigenvalue as far as a double can tell

_TINY_Q = 1e-120  # below this a coupling acts only through its sign, and q^2 would leave the range of a double
_WIDE = 104.0  # (2 q - a)^2 / q up to which bands take e^-8 of the room or more, far above rounding (a choice)
_LANES = 32  # points counted side by side: a few vector registers' worth (measured)


@kernel
def count_below(a: float, q: float) -> int:
    """Return how many characteristic values (q != 0) lie below ``a``, or `UNDECIDED`."""
    # Pivots d_k = D_k - a - q^2 / d_(k-1) of the four chains (see the head of the file): c and s are those of period 2
    # pi with 1 + q and 1 - q, e and o the even and the odd chain of period pi.  x is the bare diagonal k^2 - a; one
    # turn of the loop takes one row of each chain.  The squares are written q (q / d), which leaves no range that d
    # itself does not. It ends when every pivot exceeds q and x >= 2 q, after which no pivot can be negative (DLMF 28.2,
    # 28.4; the head). ``spare`` counts rows beyond the crest k^2 = a + 2 q: pivots that still do not settle there mean
    # that a is an eigenvalue to rounding.
    q = abs(q)
    if a > 0.5 and q < _TINY_Q:
        q = _TINY_Q
    x = 1.0 - a
    c = x + q
    s = x - q
    e = -a
    count = (c < 0.0) + (s < 0.0) + (e < 0.0)
    x = 4.0 - a
    o = x
    # A pivot that is exactly zero is taken as an infinitesimal positive one: the next is then minus infinity, so that
    # the two together count one negative pivot, whichever sign the infinitesimal had.
    e = x - 2.0 * q * (q / e) if e != 0.0 else -math.inf
    count += (e < 0.0) + (o < 0.0)
    top = a + 2.0 * q
    k = 3.0
    spare = 0.0
    while not (x >= 2.0 * q and c > q and s > q and e > q and o > q):
        x = k * k - a
        c = x - q * (q / c) if c != 0.0 else -math.inf
        s = x - q * (q / s) if s != 0.0 else -math.inf
        x = (k + 1.0) * (k + 1.0) - a
        e = x - q * (q / e) if e != 0.0 else -math.inf
        o = x - q * (q / o) if o != 0.0 else -math.inf
        count += (c < 0.0) + (s < 0.0) + (e < 0.0) + (o < 0.0)
        if k * k > top:
            spare += 1.0
            if spare > 400.0 + 0.1 * k:
                return UNDECIDED
        k += 2.0
    return count


@kernel
def count_fill(a: Any, q: Any, out: Any) -> None:
    """Fill ``out`` with how many characteristic values lie below ``a``; with q = 0 tongues have no width but tongue 0.

    A count left undecided, on a transition curve to rounding, is taken as that just above it.
    """
    for i in range(len(a)):
        count = count_below(a[i], q[i])
        if count == UNDECIDED:
            count = count_below(a[i] * (1.0 - 4.0 * EPS), q[i])
        out[i] = max(count, 0)


@kernel
def shown_by_count(alpha: float, beta: float) -> int:
    """Return `STABLE` or `UNSTABLE`, or `NEAR_A_BAND` where an odd count does not show that solutions are bounded."""
    # a = -4 beta, q = 2 |alpha|; an even number of curves below a means growth, an odd one that a lies between a_m and
    # b_(m+1).  Far below 2 q these two curves are closer than rounding: there the odd count shows nothing.
    if alpha == 0.0:
        return STABLE if beta < 0.0 else UNSTABLE
    a = -4.0 * beta
    q = 2.0 * abs(alpha)
    if count_below(a, q) % 2 == 0:
        return UNSTABLE
    depth = 2.0 * q - a
    return NEAR_A_BAND if depth > 0.0 and depth * depth > _WIDE * q else STABLE


@kernel
def shown_one_by_one(alpha: Any, beta: Any, out: Any) -> None:
    """Fill ``out`` with what counts show of undamped equations, point by point: for small arrays."""
    for i in range(len(alpha)):
        out[i] = shown_by_count(alpha[i], beta[i])


@kernel
def shown_fill(alpha: Any, beta: Any, out: Any) -> None:
    """Fill ``out`` with what `shown_by_count` says of undamped equations, many points side by side.

    The parity of the count is the sign of the product of all pivots, so the three-term recurrence of the leading
    minors decides it without divisions, and the points of a block advance together in vector registers.
    """
    # Leading minors of the four chains, squares of q in g: M_k = (D_k - a) M_(k-1) - q^2 M_(k-2), the newest in c, s,
    # e, o, the one before in c0, s0, e0, o0 (c and s of period 2 pi with 1 + q and 1 - q, e and o the even and the odd
    # chain of period pi), of `_LANES` points each.  The pivots are d_k = M_k / M_(k-1), so that the sign of the last
    # minor is the parity of the negative pivots, and d_k > q reads M_k > q M_(k-1) for a positive M_(k-1).  Rows are
    # run to the largest a + 2 q of the block without a test, since no chain may stop before; then pairs of rows until
    # all points have settled.  ``out`` is 0 for an even number of curves below a and 1 for an odd one, but -1 near
    # bands thinner than rounding.
    n = len(alpha)
    ab = np.empty(_LANES)
    qs = np.empty(_LANES)
    q2 = np.empty(_LANES)
    tops = np.empty(_LANES)
    c = np.empty(_LANES)
    c0 = np.empty(_LANES)
    s = np.empty(_LANES)
    s0 = np.empty(_LANES)
    e = np.empty(_LANES)
    e0 = np.empty(_LANES)
    o = np.empty(_LANES)
    o0 = np.empty(_LANES)
    whole = n - n % _LANES
    for start in range(0, whole, _LANES):
        tiny = 0
        for j in range(_LANES):
            a = -4.0 * beta[start + j]
            q = max(2.0 * abs(alpha[start + j]), _TINY_Q)
            # First minors, of the rows 1 +- q, of the rows 0 and 4 of the even chain, and of the row 4 of the odd one.
            ab[j] = a
            qs[j] = q
            q2[j] = q * q
            c0[j] = 1.0
            s0[j] = 1.0
            o0[j] = 1.0
            c[j] = (1.0 - a) + q
            s[j] = (1.0 - a) - q
            e0[j] = -a
            o[j] = 4.0 - a
            e[j] = -a * (4.0 - a) - 2.0 * q * q
            tops[j] = a + 2.0 * q
            tiny += 1 if q < 1e-100 else 0
        width = _LANES // 2
        while width > 0:  # the largest, by halves: no step waits for the one before
            for j in range(width):
                tops[j] = tops[j] if tops[j] > tops[j + width] else tops[j + width]
            width //= 2
        top = max(tops[0], 0.0)
        # Rows with k^2 up to a + 2 q: k grows by 2 a row, and two rows are taken at a time.
        last = max(2, int(math.sqrt(top) * 0.5) + 2)
        level = 1
        limit = last + 40
        k = 3.0
        while True:
            while level < last:
                d1 = k * k
                d2 = (k + 1.0) * (k + 1.0)
                d3 = (k + 2.0) * (k + 2.0)
                d4 = (k + 3.0) * (k + 3.0)
                for j in range(_LANES):  # two rows of each chain, so that every minor is stored half as often
                    a = ab[j]
                    g = q2[j]
                    x = d1 - a
                    y = d3 - a
                    t = x * c[j] - g * c0[j]
                    c[j], c0[j] = y * t - g * c[j], t
                    t = x * s[j] - g * s0[j]
                    s[j], s0[j] = y * t - g * s[j], t
                    x = d2 - a
                    y = d4 - a
                    t = x * e[j] - g * e0[j]
                    e[j], e0[j] = y * t - g * e[j], t
                    t = x * o[j] - g * o0[j]
                    o[j], o0[j] = y * t - g * o[j], t
                k += 4.0
                level += 2
                # Both minors of a chain over the larger one: signs and ratios stay, and doubles suffice for 16 rows.
                if level % 16 == 1:
                    for j in range(_LANES):
                        f = 1.0 / max(abs(c[j]), abs(c0[j]))
                        c[j] *= f
                        c0[j] *= f
                        f = 1.0 / max(abs(s[j]), abs(s0[j]))
                        s[j] *= f
                        s0[j] *= f
                        f = 1.0 / max(abs(e[j]), abs(e0[j]))
                        e[j] *= f
                        e0[j] *= f
                        f = 1.0 / max(abs(o[j]), abs(o0[j]))
                        o[j] *= f
                        o0[j] *= f
            # Settled: d = c / c0 > q in every chain, written without the division.
            unsettled = 0
            for j in range(_LANES):
                g = qs[j]
                settled = (
                    ((c[j] > g * c0[j]) == (c0[j] > 0.0))
                    & ((s[j] > g * s0[j]) == (s0[j] > 0.0))
                    & ((e[j] > g * e0[j]) == (e0[j] > 0.0))
                    & ((o[j] > g * o0[j]) == (o0[j] > 0.0))
                )
                unsettled += 0 if settled else 1
            if unsettled == 0 or level >= limit:
                break
            last = level + 1
        for j in range(_LANES):
            odd = ((c[j] < 0.0) != (s[j] < 0.0)) != ((e[j] < 0.0) != (o[j] < 0.0))
            depth = 2.0 * qs[j] - ab[j]
            out[start + j] = odd - 2 * (odd & (depth > 0.0) & (depth * depth > _WIDE * qs[j]))  # else `NEAR_A_BAND`
        if unsettled > 0 or tiny > 0:
            # Rare: points on a transition curve to rounding, or forcing so weak that its square is lost.
            for j in range(_LANES):
                if unsettled > 0 or qs[j] < 1e-100:
                    out[start + j] = shown_by_count(alpha[start + j], beta[start + j])
    for i in range(whole, n):
        out[i] = shown_by_count(alpha[i], beta[i])
