"""Kernels for the determinants of the four chains of Mathieu's equation, in double and in double-double precision.

The head of `mathieu_counts` lists the chains.  A determinant, scaled by its diagonal at a = q = 0, is the
product of its pivots up to an index K times what the infinite rest contributes: a linear combination of A(K), A(K + 1)
of `mathieu_tail`.
"""

from __future__ import annotations

import math

from floquetrod._util.arrays import EPS
from floquetrod._util.compilation import kernel
from floquetrod.floquet.mathieu_chains.mathieu_tail import TAIL_ERROR, slack, tail


@kernel
def determinant_pair(a: float, q: float, odd_period: bool) -> tuple[float, float, int, int, float, float, int]:
    """Return the determinants of two chains: (even, odd) of period pi, or (1 + q, 1 - q) of period 2 pi.

    Values: both mantissas, both binary exponents, both relative errors (first-order estimates), and the last index.
    The error of a determinant close to zero is the error of ``a`` times its logarithmic derivative, carried along.
    """
    # Two chains of one parity side by side, u and v their pivots, x = D_k - a the diagonal they share from the second
    # row on:
    #     u <- x - q^2 / u,    du/da <- -1 + (q / u)^2 du/da,    p_u <- p_u u / k^2,    lu <- lu + (du/da) / u,
    # p_u 2^eu the determinant over its diagonal at a = q = 0, lu its logarithmic derivative; v likewise.  Downwards,
    # until both pivots exceed q and the chains no longer resonate: from there the rest, up to infinity, is the same
    # linear combination of A(kappa) and A(kappa + 1), kappa = k / 2, for both (`tail`; h^2 = a / 4, Q = q^2 / 16).  A
    # pivot near zero makes its successor large and their product harmless, as long as neither is exactly zero.
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
        # Beyond the crest k^2 = a + 2 q pivots settle at once, except where a is an eigenvalue to rounding.
        if kk > top:
            spare += 1.0
            settled = settled or spare > 400.0 + 0.1 * k
    # The rest couples to the last row k by q^2 / ((k + 2)^2 u), both diagonals scaled.
    here, above, e = tail(0.5 * k, 0.25 * a, q2 * 0.0625)
    r = q2 / ((k + 2.0) * (k + 2.0))
    pu, iu = math.frexp(pu * (here - above * r / u))
    pv, iv = math.frexp(pv * (here - above * r / v))
    scale = 4.0 * EPS * (abs(a) + 2.0 * q)
    rounding = TAIL_ERROR * slack(a, q) + EPS * k
    return pu, pv, eu + iu + e, ev + iv + e, rounding + scale * abs(lu), rounding + scale * abs(lv), int(k)


@kernel
def two_sum(x: float, y: float) -> tuple[float, float]:
    """Return x + y rounded and the rounding error (Knuth)."""
    # x + y = s + e exactly (D. E. Knuth, The Art of Computer Programming 2, 4.2.2), whichever of the two is larger.
    s = x + y
    t = s - x
    return s, (x - (s - t)) + (y - t)


@kernel
def two_product(x: float, y: float) -> tuple[float, float]:
    """Return x y rounded and the rounding error (Dekker; magnitudes below 1e290)."""
    # x y = p + e exactly (T. J. Dekker, Numerische Mathematik 18 (1971) 224, doi:10.1007/BF01397083): 134217729 = 2^27
    # + 1 cuts each factor into halves of 26 bits, whose products are exact.
    p = x * y
    t = 134217729.0 * x
    xh = t - (t - x)
    xl = x - xh
    t = 134217729.0 * y
    yh = t - (t - y)
    yl = y - yh
    return p, ((xh * yh - p) + xh * yl + xl * yh) + xl * yl


@kernel
def _times_minus_times(
    xh: float, xl: float, ph: float, pl: float, gh: float, gl: float, oh: float, ol: float
) -> tuple[float, float]:
    """Return x p - g o, every number in double-double."""
    # Each product with its rounding error and the cross terms of the low parts; low times low is below the last bit.
    h, low = two_product(xh, ph)
    low += xh * pl + xl * ph
    m, n = two_product(gh, oh)
    n += gh * ol + gl * oh
    s, t = two_sum(h, -m)
    return two_sum(s, t + (low - n))


@kernel
def determinant(ah: float, al: float, q: float, chain: int) -> tuple[float, int]:
    """Return mantissa and exponent of one determinant, its leading minors run in double-double (``a`` = ah + al).

    Chains: 0 even, 1 odd of period pi; 2 with 1 + q, 3 with 1 - q of period 2 pi.
    """
    # Leading minors M_k = (D_k - a) M_(k-1) - q^2 M_(k-2), the last two as double-doubles: (oh, ol) of k - 2, (ph, pl)
    # of k. ``norm`` times 2^e is what they are scaled by: the product of the diagonal at a = q = 0, and powers of two
    # that keep the minors in range.  They run until the ratio of neighbours exceeds q, where the chain no longer
    # resonates; the rest beyond kappa = k / 2 enters by the determinants A(kappa), A(kappa + 1) of `tail`, h^2 = a / 4
    # and Q = q^2 / 16. Double-double, since near a curve the minors lose all digits that a double has.
    gh, gl = two_product(q, q)
    oh, ol = 1.0, 0.0
    norm = 1.0
    e = 0
    if chain >= 2:
        k = 1.0
        h, low = two_sum(1.0, -ah)
        ph, pl = two_sum(h, q if chain == 2 else -q)
        ph, pl = two_sum(ph, pl + (low - al))
    else:
        k = 2.0
        norm = 0.25
        xh, xl = two_sum(4.0, -ah)
        ph, pl = two_sum(xh, xl - al)
        if chain == 0:
            th, tl = _times_minus_times(ph, pl, -ah, -al, 2.0 * gh, 2.0 * gl, 1.0, 0.0)
            oh, ol, ph, pl = -ah, -al, th, tl
    top = ah + 2.0 * q
    spare = 0.0
    settled = False
    while not settled:
        k += 2.0
        xh, xl = two_sum(k * k, -ah)
        th, tl = _times_minus_times(xh, xl - al, ph, pl, gh, gl, oh, ol)
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
    here, above, i = tail(0.5 * k, 0.25 * ah, q * q * 0.0625)
    norm, j = math.frexp(norm * (here * ph - above * (q * q / ((k + 2.0) * (k + 2.0))) * oh))
    return norm, e + i + j
