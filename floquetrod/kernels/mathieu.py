"""Kernels for Mathieu's equation: counts of transition curves, and the exact discriminant from Hill's determinants.

In the form y'' + (a - 2 q cos 2 z) y = 0, Hill's infinite matrix splits by symmetry into four real symmetric
tridiagonal chains.  With q >= 0 (its sign only shifts time) their diagonals are

    even, period pi    0, 4, 16, 36, ...   off-diagonals squared 2 q^2, q^2, q^2, ...
    odd,  period pi       4, 16, 36, ...                                q^2, q^2, ...
    period 2 pi        1 + q, 9, 25, ...                          q^2,  q^2, q^2, ...
    period 2 pi        1 - q, 9, 25, ...                          q^2,  q^2, q^2, ...

and their eigenvalues are the characteristic values a_0 < b_1 <= a_1 < b_2 <= ... (DLMF 28.2, 28.4).

*Count.*  The number N of them below a is the number of negative pivots d_k = D_k - a - q^2 / d_(k-1).  Once d_k > q
and D_j - a >= 2 q for all later j, d_(k+1) >= 2 q - q^2 / q = q, strictly: every later pivot stays above q, so the
count of the *infinite* matrices is known when all four chains have got that far.  Solutions are bounded when a lies
between a_m and b_(m+1), that is when N is odd.

*Discriminant.*  The determinants themselves, scaled by the diagonal they have at a = q = 0, are the half-period values
of the cosine- and sine-like solutions y1, y2 from z = 0, an instant of even symmetry, to z = pi / 2:

    y1' = (pi/2) det(even),  y2 = (pi/2) det(odd),  y1 = det(1 + q),  y2' = det(1 - q),
    trace - 2 = 4 y1' y2,    trace + 2 = 4 y1 y2'

so the excess X = (abs(trace) - 2) / 4 is a product of two determinants that keep their digits where the trace loses
them.  A determinant is the product of its pivots up to an index K times what the infinite rest contributes; that is a
linear combination of A(K), A(K + 1) where, with h^2 = a / 4, Q = q^2 / 16 and D = 4 kappa^2,

    A(kappa) = (1 - h^2 / (kappa + 1)^2) A(kappa + 1) - Q / ((kappa + 1)^2 (kappa + 2)^2) A(kappa + 2),   A(inf) = 1,

is the scaled determinant of everything beyond kappa; it starts from an asymptotic series far out and runs inwards.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

UNDECIDED = -1  # count of a chain whose pivots would not settle: a is an eigenvalue as far as a double can tell

_TINY_Q = 1e-120  # below this a coupling acts only through its sign, and q^2 would leave the range of a double
_LANES = 32  # points counted side by side: a few vector registers' worth (measured)
_EPS = 2.220446049250313e-16
_TAIL_ERROR = 3e-14  # relative error of `_tail` (measured; a test holds it)
_ENOUGH = 2e-13  # relative error of the excess above which the minors are run again in double-double


@kernel
def count_below(a: float, q: float) -> int:
    """Return how many characteristic values (q != 0) lie below ``a``, or `UNDECIDED`."""
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
            count = count_below(a[i] * (1.0 - 4.0 * _EPS), q[i])
        out[i] = max(count, 0)


@kernel
def is_stable_scalar(alpha: float, beta: float) -> bool:
    """Return whether every solution of A'' = (beta + alpha sin tau) A is bounded."""
    if alpha == 0.0:
        return beta < 0.0
    return count_below(-4.0 * beta, 2.0 * alpha) % 2 == 1


@kernel
def stable_one_by_one(alpha: Any, beta: Any, out: Any) -> None:
    """Fill ``out`` with the verdicts on undamped equations, point after point: for the few."""
    for i in range(len(alpha)):
        out[i] = is_stable_scalar(alpha[i], beta[i])


@kernel
def stable_fill(alpha: Any, beta: Any, out: Any) -> None:
    """Fill ``out`` with the verdicts on undamped equations, many points side by side.

    The parity of the count is the sign of the product of all pivots, so the three-term recurrence of the leading
    minors decides it without divisions, and the points of a block advance together in vector registers.
    """
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
            out[start + j] = ((c[j] < 0.0) != (s[j] < 0.0)) != ((e[j] < 0.0) != (o[j] < 0.0))
        if unsettled > 0 or tiny > 0:
            # Rare: points on a transition curve to rounding, or forcing so weak that its square is lost.
            for j in range(_LANES):
                if unsettled > 0 or qs[j] < 1e-100:
                    out[start + j] = is_stable_scalar(alpha[start + j], beta[start + j])
    for i in range(whole, n):
        out[i] = is_stable_scalar(alpha[i], beta[i])


# --- the exact discriminant ------------------------------------------------------------------------------------------


@kernel
def _power_sum(x: float, i2: float, s: float) -> float:
    """Return x^(s - 1) times the sum of k^-s over k = x + 1/2, x + 3/2, ... (midpoint Euler-Maclaurin series)."""
    t = 1.0 - (s + 5.0) * (s + 6.0) * i2 * (127.0 * 967680.0 / (154828800.0 * 31.0))
    t = 1.0 - (s + 3.0) * (s + 4.0) * i2 * (31.0 * 5760.0 / (967680.0 * 7.0)) * t
    t = 1.0 - (s + 1.0) * (s + 2.0) * i2 * (7.0 * 24.0 / 5760.0) * t
    return 1.0 / (s - 1.0) - s * i2 * t / 24.0


@kernel
def _slack(a: float, q: float) -> float:
    """Return the factor by which errors may grow with the size of the equation: 1 up to a + 2 q = 50 (a choice)."""
    return max(1.0, (abs(a) + 2.0 * q) / 50.0)


@kernel
def _far_out(h2: float, big_q: float) -> float:
    """Return an index beyond which the series of `_log_tail` is good to `_TAIL_ERROR` times slack (measured)."""
    far = max(30.0, 4.0 * math.sqrt(abs(h2)))
    if big_q > 20.0 or abs(h2) > 36.0:
        # The first terms left out, of third, fourth and fifth order in Q, each against its share of the error.
        share = 1e13 / _slack(4.0 * h2, 4.0 * math.sqrt(big_q))
        far = max(
            far,
            3.0 * big_q**0.25,
            (big_q**3 * (20.0 * h2 * h2 + 100.0) * share) ** (1.0 / 15.0),
            (big_q**4 * (5.0 * abs(h2) + 40.0) * share) ** (1.0 / 17.0),
            (big_q**5 * share) ** (1.0 / 19.0),
        )
    return far


@kernel
def _log_tail(kappa: float, h2: float, big_q: float) -> float:
    """Return log A(kappa) for large kappa, by the cumulants of the tail determinant up to fourth order in Q."""
    x = kappa + 0.5
    i2 = 1.0 / (x * x)
    total = 0.0
    power = h2 * i2 * x
    s = 2.0
    j = 1.0
    while abs(power) > 1e-17 and j < 60.0:
        total -= power / j * _power_sum(x, i2, s)
        power *= h2 * i2
        s += 2.0
        j += 1.0
    # First and second order in Q about the centres k + 1/2: 1 / ((k^2 - h^2)((k + 1)^2 - h^2)) and half its square.
    x = kappa + 1.0
    i2 = 1.0 / (x * x)
    b = (0.5 + 2.0 * h2) * i2
    c = (0.25 - h2) * i2
    c = c * c
    scale = big_q * i2 * i2
    one = scale * x
    two = 0.5 * scale * scale * x
    g0 = 0.0
    g = 1.0
    w0 = 0.0
    w = 1.0
    s = 4.0
    while s < 120.0:
        total -= one * g * _power_sum(x, i2, s) + two * w * _power_sum(x, i2, s + 4.0)
        # Both this coefficient and the one before: a single one may vanish (at a = -1, say).
        if one * (abs(g) + abs(g0)) + two * (abs(w) + abs(w0)) < 1e-17 * s:
            break
        g0, g = g, b * g - c * g0
        w0, w = w, g + b * w - c * w0
        s += 2.0
    # Second order, neighbours: 1 / ((k^2 - h^2) ((k + 1)^2 - h^2)^2 ((k + 2)^2 - h^2)) about the centres k + 1.
    x = kappa + 1.5
    i2 = 1.0 / (x * x)
    b = (2.0 + 2.0 * h2) * i2
    c = (1.0 - h2) * i2
    c = c * c
    f = h2 * i2
    two = big_q * i2 * i2
    two = two * two * x
    g0 = 0.0
    g = 1.0
    w0 = 0.0
    w = 1.0
    s = 8.0
    while s < 120.0:
        total -= two * w * _power_sum(x, i2, s)
        if two * (abs(w) + abs(w0)) < 1e-17 * s:
            break
        g0, g = g, b * g - c * g0
        w0, w = w, g + 2.0 * f * w - f * f * w0
        s += 2.0
    # Third and fourth order: leading terms about their mean centres kappa + 8/5, kappa + 13/7.
    x = kappa + 1.6
    i2 = 1.0 / (x * x)
    cube = big_q * i2 * i2
    cube = cube * cube * cube * x
    total -= 10.0 / 3.0 * cube * (_power_sum(x, i2, 12.0) + (6.0 * h2 + 11.8) * i2 / 13.0)
    x = kappa + 13.0 / 7.0
    i2 = 1.0 / (x * x)
    fourth = big_q * i2 * i2
    fourth = fourth * fourth
    return total - 35.0 / 4.0 * fourth * fourth * x / 15.0


@kernel
def _tail(kappa: float, h2: float, big_q: float) -> tuple[float, float, int]:
    """Return A(kappa), A(kappa + 1), both to be multiplied by 2 to the third value."""
    pairs = max(0, int(0.5 * (_far_out(h2, big_q) - kappa)) + 1)
    top = kappa + 2.0 * pairs
    # Ratio A(top) / A(top + 1) by the backward continued fraction; a step divides the error by about top^4 / Q.
    step = big_q / (top * top * top * top)
    error = step
    k = top + 1.0
    while error > 1e-17:
        error *= step
        k += 1.0
    ratio = 1.0 - h2 / (k * k)
    while k > top + 1.0:
        k -= 1.0
        ratio = (1.0 - h2 / (k * k)) - big_q / (k * k * (k + 1.0) * (k + 1.0) * ratio)
    log_tail = _log_tail(top, h2, big_q)
    exponent = 0
    if abs(log_tail) > 300.0:
        exponent = int(log_tail / math.log(2.0))
        log_tail -= exponent * math.log(2.0)
    here = math.exp(log_tail)
    above = here / ratio
    k = top
    i0 = 1.0 / ((k + 1.0) * (k + 1.0))
    for _ in range(pairs):
        # Two steps at once, so that the products that do not wait for the last step are done beside it.
        i1 = 1.0 / (k * k)
        i2 = 1.0 / ((k - 1.0) * (k - 1.0))
        f1 = 1.0 - h2 * i1
        f2 = 1.0 - h2 * i2
        g1 = big_q * i1 * i0
        here, above = (f2 * f1 - big_q * i2 * i1) * here - f2 * g1 * above, f1 * here - g1 * above
        i0 = i2
        k -= 2.0
        if not (1e-200 < abs(here) < 1e200):
            here, shift = math.frexp(here)
            above = math.ldexp(above, -shift)
            exponent += shift
    here, shift = math.frexp(here)
    return here, math.ldexp(above, -shift), exponent + shift


@kernel
def _pair(a: float, q: float, odd_period: bool) -> tuple[float, float, int, int, float, float, int]:
    """Return the determinants of two chains: (even, odd) of period pi, or (1 + q, 1 - q) of period 2 pi.

    Values: both mantissas, both binary exponents, both relative errors (first-order estimates), and the last index.
    The error of a determinant close to zero is that of ``a`` times its logarithmic derivative, carried along.
    """
    q2 = q * q
    nudge = 1e-20 * (1.0 + abs(a) + q)  # stands in for a pivot of exactly zero: far below the rounding of a
    eu, ev = 0, 0
    dv = -1.0  # derivatives of the pivots with respect to a
    if odd_period:
        k = 1.0
        u = 1.0 - a + q
        v = 1.0 - a - q
        u = u if u != 0.0 else nudge
        v = v if v != 0.0 else nudge
        du = -1.0
        pu, pv = u, v
        lu, lv = du / u, dv / v
    else:
        # The even chain has one row more; start both at the row of 4.
        k = 2.0
        least = max(1e-25 * q * q, 1e-300)  # as far below a_0 = -q^2 / 2 + ... as matters
        u = -a if abs(a) > least else -least
        v = 4.0 - a if a != 4.0 else nudge
        lu = -1.0 / u
        pu = u
        r = 2.0 * q * (q / u)
        du = -1.0 - r / u
        u = v - r
        u = u if u != 0.0 else nudge
        pu = 0.25 * pu * u
        pv = 0.25 * v
        lu += du / u
        lv = dv / v
    top = a + 2.0 * q
    spare = 0.0
    settled = k * k - a >= 2.0 * q and u > q and v > q
    while not settled:
        k += 2.0
        kk = k * k
        x = kk - a
        r = q2 / u
        du = -1.0 + r / u * du
        u = x - r
        u = u if u != 0.0 else nudge
        r = q2 / v
        dv = -1.0 + r / v * dv
        v = x - r
        v = v if v != 0.0 else nudge
        lu += du / u
        lv += dv / v
        pu *= u / kk
        pv *= v / kk
        if not (1e-100 < abs(pu) < 1e100 and 1e-100 < abs(pv) < 1e100):
            f, i = math.frexp(pu)
            pu = f
            eu += i
            f, i = math.frexp(pv)
            pv = f
            ev += i
        settled = x >= 2.0 * q and u > q and v > q
        if kk > top:
            spare += 1.0
            settled = settled or spare > 400.0 + 0.1 * k
    here, above, e = _tail(0.5 * k, 0.25 * a, q2 * 0.0625)
    r = q2 / ((k + 2.0) * (k + 2.0))
    pu, iu = math.frexp(pu * (here - above * r / u))
    pv, iv = math.frexp(pv * (here - above * r / v))
    scale = 4.0 * _EPS * (abs(a) + 2.0 * q)
    rounding = _TAIL_ERROR * _slack(a, q) + _EPS * k
    return pu, pv, eu + iu + e, ev + iv + e, rounding + scale * abs(lu), rounding + scale * abs(lv), int(k)


@kernel
def _two_sum(x: float, y: float) -> tuple[float, float]:
    """Return x + y rounded and the rounding error (Knuth)."""
    s = x + y
    t = s - x
    return s, (x - (s - t)) + (y - t)


@kernel
def _two_product(x: float, y: float) -> tuple[float, float]:
    """Return x y rounded and the rounding error (Dekker; magnitudes below 1e290)."""
    p = x * y
    t = 134217729.0 * x
    xh = t - (t - x)
    xl = x - xh
    t = 134217729.0 * y
    yh = t - (t - y)
    yl = y - yh
    return p, ((xh * yh - p) + xh * yl + xl * yh) + xl * yl


@kernel
def _step(
    xh: float, xl: float, ph: float, pl: float, gh: float, gl: float, oh: float, ol: float
) -> tuple[float, float]:
    """Return x p - g o, every number in double-double."""
    h, low = _two_product(xh, ph)
    low += xh * pl + xl * ph
    m, n = _two_product(gh, oh)
    n += gh * ol + gl * oh
    s, t = _two_sum(h, -m)
    return _two_sum(s, t + (low - n))


@kernel
def _double_double(ah: float, al: float, q: float, chain: int) -> tuple[float, int]:
    """Return mantissa and exponent of one determinant, its leading minors run in double-double (``a`` = ah + al).

    Chains: 0 even, 1 odd of period pi; 2 with 1 + q, 3 with 1 - q of period 2 pi.
    """
    gh, gl = _two_product(q, q)
    oh, ol = 1.0, 0.0
    norm = 1.0
    e = 0
    if chain >= 2:
        k = 1.0
        h, low = _two_sum(1.0, -ah)
        ph, pl = _two_sum(h, q if chain == 2 else -q)
        ph, pl = _two_sum(ph, pl + (low - al))
    else:
        k = 2.0
        norm = 0.25
        xh, xl = _two_sum(4.0, -ah)
        ph, pl = _two_sum(xh, xl - al)
        if chain == 0:
            th, tl = _step(ph, pl, -ah, -al, 2.0 * gh, 2.0 * gl, 1.0, 0.0)
            oh, ol, ph, pl = -ah, -al, th, tl
    top = ah + 2.0 * q
    spare = 0.0
    settled = False
    while not settled:
        k += 2.0
        xh, xl = _two_sum(k * k, -ah)
        th, tl = _step(xh, xl - al, ph, pl, gh, gl, oh, ol)
        oh, ol, ph, pl = ph, pl, th, tl
        norm /= k * k
        size = max(abs(ph), abs(oh))
        if size > 1e60 or size < 1e-60 or norm < 1e-200:
            i = max(-900, math.frexp(size)[1])
            f = math.ldexp(1.0, -i)
            oh, ol, ph, pl = oh * f, ol * f, ph * f, pl * f
            e += i
            norm, i = math.frexp(norm)
            e += i
        settled = xh >= 2.0 * q and ph != 0.0 and (ph > q * oh) == (oh > 0.0)
        if k * k > top:
            spare += 1.0
            settled = settled or spare > 400.0 + 0.1 * k
    here, above, i = _tail(0.5 * k, 0.25 * ah, q * q * 0.0625)
    norm, j = math.frexp(norm * (here * ph - above * (q * q / ((k + 2.0) * (k + 2.0))) * oh))
    return norm, e + i + j


@kernel
def _excess_constant(a: float) -> tuple[int, float, int, float, int]:
    """Return what `excess` does where alpha = 0."""
    root = 0.5 * math.sqrt(abs(a))
    if a > 0.0:
        f = root - math.floor(root + 0.5)
        error = 4.0 * _EPS * (1.0 + math.pi * root)
        if abs(f) <= 0.25:
            return 1, -(math.sin(math.pi * f) ** 2), 0, error, 1
        return -1, -(math.cos(math.pi * f) ** 2), 0, error, 1
    error = 8.0 * _EPS * (1.0 + math.pi * root)
    if root < 100.0:
        return 1, math.sinh(math.pi * root) ** 2, 0, error, 1
    power = 2.0 * math.pi * root / math.log(2.0)
    whole = math.floor(power)
    return 1, 0.25 * 2.0 ** (power - whole), int(whole), error, 1


@kernel
def excess(alpha: float, beta: float, damping: float) -> tuple[int, float, int, float, int]:
    """Return (sign, X, exponent, error, rows): the excess X 2^exponent of the equation freed of its damping.

    X = (abs(D) - 2) / 4 for the discriminant D of (alpha, beta + damping^2) and ``sign`` that of D; ``error`` is the
    estimated error relative to abs(X) (absolute where X is zero); ``rows`` counts the rows of the determinants.
    """
    q = 2.0 * abs(alpha)
    ch, cl = _two_product(damping, damping)
    bh, bl = _two_sum(beta, ch)
    ah = -4.0 * bh
    al = -4.0 * (bl + cl)
    if q == 0.0:
        return _excess_constant(ah)
    # (trace - 2) / 4, from the chains of period pi, gives (trace + 2) / 4 by adding 1, except where that cancels:
    # there, beside the boundaries of period 2 pi, the other two chains are needed.
    u, v, eu, ev, ru, rv, rows = _pair(ah, q, False)
    x = u * v * (0.25 * math.pi * math.pi)
    e = eu + ev
    value = math.ldexp(x, e) if e < 60 else math.copysign(1e18, x)
    cancels = -1.5 < value < -0.67
    if cancels:
        u, v, eu, ev, ru, rv, rows = _pair(ah, q, True)
        x = -u * v
        e = eu + ev
        value = math.ldexp(x, e)
    error = ru + rv
    if error > 1e-9 or error * min(1.0, abs(value)) > _ENOUGH * _slack(ah, q):
        chain = 2 if cancels else 0
        uu, eu = _double_double(ah, al, q, chain)
        vv, ev = _double_double(ah, al, q, chain + 1)
        x = uu * vv * (-1.0 if cancels else 0.25 * math.pi * math.pi)
        # The derivative of a determinant is the same in both precisions; the determinant is what has changed.
        old = e
        e = eu + ev
        loss = abs(u * v / (uu * vv)) * 2.0 ** max(-900.0, min(900.0, float(old - e))) if x != 0.0 else math.inf
        error = 2.0 * (_TAIL_ERROR * _slack(ah, q) + _EPS * rows) + 1e-15 * error * max(1.0, loss)
        value = math.ldexp(x, e) if e < 60 else math.copysign(1e18, x)
    if cancels:
        return -1, x, e, error, 4 * rows
    if value >= -0.5:
        return 1, x, e, error, 2 * rows
    if e < 60:
        return -1, -1.0 - value, 0, error * abs(value / (1.0 + value)), 2 * rows
    return -1, -x, e, error, 2 * rows


@kernel
def undamped_growth(alpha: float, beta: float, damping: float) -> float:
    """Return the growth rate per unit tau of the equation freed of its damping, (alpha, beta + damping^2)."""
    _, x, e, _, _ = excess(alpha, beta, damping)
    if x <= 0.0:
        return 0.0
    if e > 900:
        return (math.log(2.0) + 0.5 * (math.log(x) + e * math.log(2.0))) / math.pi
    odd = e % 2
    return math.asinh(math.ldexp(math.sqrt(x * (1.0 + odd)), (e - odd) // 2)) / math.pi


@kernel
def growth(alpha: float, beta: float, damping: float) -> float:
    """Return the growth rate per unit tau of A'' + 2 c A' = (beta + alpha sin tau) A, zero where stable."""
    return max(0.0, undamped_growth(alpha, beta, damping) - damping)


@kernel
def growth_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` with growth rates."""
    for i in range(len(alpha)):
        out[i] = growth(alpha[i], beta[i], damping[i])


@kernel
def is_stable_damped(alpha: float, beta: float, c: float) -> bool:
    """Return whether every solution of A'' + 2 c A' = (beta + alpha sin tau) A is bounded, c >= 0."""
    if c == 0.0:
        return is_stable_scalar(alpha, beta)
    if alpha == 0.0:
        return beta <= 0.0  # at beta = 0 what is left is A' + 2 c A = const
    return bool(count_below(-4.0 * (beta + c * c), 2.0 * alpha) % 2 == 1 or undamped_growth(alpha, beta, c) <= c)


@kernel
def damped_stable_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` with the verdicts on equations with damping, or without."""
    for i in range(len(alpha)):
        out[i] = is_stable_damped(alpha[i], beta[i], damping[i])


@kernel
def discriminant_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` with discriminants (traces of the monodromy matrix), infinite beyond the range of a double."""
    for i in range(len(alpha)):
        sign, x, e, _, _ = excess(alpha[i], beta[i], damping[i])
        decay = 2.0 * math.pi * damping[i]
        if e > 900 or decay > 700.0:
            size = math.log(4.0) + math.log(abs(x)) + e * math.log(2.0) - decay if x > 0.0 else -decay
            out[i] = sign * (math.exp(size) if size < 709.7 else math.inf)
        else:
            out[i] = sign * (2.0 + 4.0 * math.ldexp(x, e)) * math.exp(-decay)


@kernel
def multipliers_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` (n, 2) complex with multipliers, the larger (or that of positive rotation) first."""
    for i in range(len(alpha)):
        sign, x, e, _, _ = excess(alpha[i], beta[i], damping[i])
        decay = 2.0 * math.pi * damping[i]
        if x > 0.0:
            rise = 2.0 * math.pi * undamped_growth(alpha[i], beta[i], damping[i])
            out[i, 0] = sign * (math.exp(rise - decay) if rise - decay < 709.7 else math.inf)
            out[i, 1] = sign * math.exp(-rise - decay)
        else:
            root = min(1.0, math.sqrt(-math.ldexp(x, e)))  # sine of half the angle
            real = sign * (1.0 - 2.0 * root * root) * math.exp(-decay)
            imag = 2.0 * root * math.sqrt(1.0 - root * root) * math.exp(-decay)
            out[i, 0] = complex(real, imag)
            out[i, 1] = complex(real, -imag)


# --- a family of modes: alpha_m = A m^2, beta_m = B m^2 - C m^4 - D ------------------------------------------------


@kernel
def mode_family(
    w2: Any, mass: Any, rigidity: Any, pendulum: Any, mean: Any, amplitude: Any, frequency: Any
) -> tuple[Any, Any, Any, Any]:
    """Return A, B, C, D of a rod's modes, Eq. (4) of DOI 10.1115/1.4031710.

    ``w2`` is the square of the first mode's wavenumber, ``mass`` per length, ``rigidity`` E I, ``pendulum`` the
    frequency of swinging in the channel; all in SI units.
    """
    inertia = mass * frequency * frequency
    swing = pendulum / frequency
    return w2 * amplitude / inertia, w2 * mean / inertia, rigidity * w2 * w2 / inertia, swing * swing


@kernel
def mode_coefficients(big_a: Any, big_b: Any, big_c: Any, big_d: Any, mode: Any) -> tuple[Any, Any]:
    """Return alpha = A m^2 and beta = B m^2 - C m^4 - D of a mode m, or of an array of them."""
    m2 = 1.0 * mode * mode
    return big_a * m2, (big_b - big_c * m2) * m2 - big_d


@kernel
def growth_bound(a: float, q: float) -> float:
    """Return a bound on the growth per unit tau where a > 2 q: q P P' / (4 k1), exponentially small in sqrt(a).

    Resonance couples the waves exp(+-i k z), k^2 near a, through the indices between them.  Those with
    a - k^2 >= 2 q are evanescent: eliminated from the middle outwards, each passes on at most q / (a - k^2 - q) of
    what reaches it.  P is the product over them from the middle index to k1, the first that is not; P' the same from
    the next index; the first that is not evanescent turns a coupling q into a rate q / (4 k1).  The worse of both
    parities counts.  For q -> 0 and even order it is the true leading term of the tongue.
    """
    worst = 0.0
    for parity in range(2):
        k = float(parity)
        product = 1.0
        beside = 1.0
        while a - k * k >= 2.0 * q:
            factor = q / (a - k * k - q)
            product *= factor
            if k > 1.0:
                beside *= factor
            k += 2.0
        worst = max(worst, product * beside)
    return 0.25 * q / math.sqrt(a - 2.0 * q) * worst


@kernel
def growth_bound_fill(a: Any, q: Any, out: Any) -> None:
    """Fill ``out`` with `growth_bound`, infinite where a <= 2 q."""
    for i in range(len(a)):
        out[i] = growth_bound(a[i], q[i]) if a[i] > 2.0 * q[i] else math.inf


@kernel
def modes_left_out(big_a: float, big_b: float, big_c: float, big_d: float, last: int) -> float:
    """Return a bound on the growth per unit tau of every mode after ``last``, infinite where none is known.

    From m = last + 1 on, and m^4 >= D / C, the ratio a / q grows with m and so does k1, so that the products of
    `growth_bound` only fall; its prefactor is A / 4 over the square root of C - (A + B) / m^2 + D / m^4, which is at
    least what it is with (A + B) and -D replaced by zero where negative.
    """
    m2 = (last + 1.0) * (last + 1.0)
    room = big_c - max(big_a + big_b, 0.0) / m2 + min(big_d, 0.0) / (m2 * m2)
    if room <= 0.0 or big_c * m2 * m2 < big_d:
        return math.inf
    if big_a == 0.0:
        return 0.0
    q = 2.0 * big_a * m2
    a = 4.0 * ((big_c * m2 - big_b) * m2 + big_d)
    here = growth_bound(a, q)
    return here / (0.25 * q / math.sqrt(a - 2.0 * q)) * 0.25 * big_a / math.sqrt(room)


@kernel
def modes_needed(big_a: float, big_b: float, big_c: float, big_d: float, target: float, guess: int) -> int:
    """Return the least M >= 1 such that every mode after M grows at no more than ``target`` per unit tau.

    A good ``guess``, the answer for a load nearby, makes it quick.
    """
    low, high = 0, guess
    step = 1
    if modes_left_out(big_a, big_b, big_c, big_d, guess) > target:
        low, high = guess, guess + 1
        while modes_left_out(big_a, big_b, big_c, big_d, high) > target:
            step *= 2
            low, high = high, high + step
    else:
        while high > 1 and modes_left_out(big_a, big_b, big_c, big_d, max(1, high - step)) <= target:
            high = max(1, high - step)
            step *= 2
        low = max(0, high - step)
    while high - low > 1:
        middle = (low + high) // 2
        if modes_left_out(big_a, big_b, big_c, big_d, middle) > target:
            low = middle
        else:
            high = middle
    return high


@kernel
def modes_needed_fill(big_a: Any, big_b: Any, big_c: Any, big_d: Any, target: Any, out: Any) -> None:
    """Fill ``out`` with `modes_needed`."""
    last = 1
    for i in range(len(big_a)):
        last = modes_needed(big_a[i], big_b[i], big_c[i], big_d[i], target[i], last)
        out[i] = last


@kernel
def _modes_of_load(
    w2: float,
    mass: float,
    rigidity: float,
    pendulum: float,
    mean: float,
    amplitude: float,
    omega: float,
    damping_rate: float,
    slowest: float,
    guess: int,
) -> tuple[float, float, float, float, float, int]:
    """Return A, B, C, D and c of a rod under a load, and how many modes to ask when ``slowest`` (1/s) is to be seen."""
    c = damping_rate / omega
    a, b, stiffness, d = mode_family(w2, mass, rigidity, pendulum, mean, amplitude, omega)
    return a, b, stiffness, d, c, modes_needed(a, b, stiffness, d - c * c, c + slowest / omega, guess)


@kernel
def _mode_stable(
    big_a: float, big_b: float, big_c: float, big_d: float, mode: int, damping: float, tolerance: float
) -> bool:
    """Return whether one mode of a family grows no faster than ``tolerance``."""
    alpha, beta = mode_coefficients(big_a, big_b, big_c, big_d, mode)
    if tolerance == 0.0:
        return is_stable_damped(alpha, beta, damping)
    if alpha != 0.0 and count_below(-4.0 * (beta + damping * damping), 2.0 * alpha) % 2 == 1:
        return True
    return undamped_growth(alpha, beta, damping) <= damping + tolerance


@kernel
def modes_stable_fill(
    mean: Any,
    amplitude: Any,
    frequency: Any,
    out: Any,
    w2: float,
    mass: float,
    rigidity: float,
    pendulum: float,
    damping_rate: float,
    tolerance: float,
    smallest: float,
) -> None:
    """Fill ``out`` with whether no mode of a rod grows faster than ``tolerance`` under each load (rates per second).

    Rates below ``smallest`` may be left out.  Neighbouring loads need about as many modes and mostly fail in the same
    one, which is asked first.
    """
    slowest = max(tolerance, smallest)
    last = 1
    suspect = 1
    for i in range(len(mean)):
        a, b, stiffness, d, c, last = _modes_of_load(
            w2, mass, rigidity, pendulum, mean[i], amplitude[i], frequency[i], damping_rate, slowest, last
        )
        level = tolerance / frequency[i]
        suspect = min(suspect, last)
        stable = _mode_stable(a, b, stiffness, d, suspect, c, level)
        if stable:
            for mode in range(1, last + 1):
                if mode != suspect and not _mode_stable(a, b, stiffness, d, mode, c, level):
                    stable = False
                    suspect = mode
                    break
        out[i] = stable


@kernel
def modes_growth_fill(
    mean: Any,
    amplitude: Any,
    frequency: Any,
    out: Any,
    w2: float,
    mass: float,
    rigidity: float,
    pendulum: float,
    damping_rate: float,
    smallest: float,
) -> None:
    """Fill ``out`` (n, 2) with the largest growth rate per second and the mode that has it (0 where none grows)."""
    last = 1
    for i in range(len(mean)):
        a, b, stiffness, d, c, last = _modes_of_load(
            w2, mass, rigidity, pendulum, mean[i], amplitude[i], frequency[i], damping_rate, smallest, last
        )
        best = 0.0
        first = 0
        for mode in range(1, last + 1):
            alpha, beta = mode_coefficients(a, b, stiffness, d, mode)
            if alpha == 0.0 or count_below(-4.0 * (beta + c * c), 2.0 * alpha) % 2 == 0:
                rate = growth(alpha, beta, c)
                if rate > best:
                    best = rate
                    first = mode
        out[i, 0] = best * frequency[i]
        out[i, 1] = first
