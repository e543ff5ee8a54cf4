"""Kernels for Mathieu's equation: its discriminant from Hill's determinants, growth rates, verdicts and multipliers.

The determinants of the four chains (`mathieu_determinants`) are the half-period values of the
cosine- and sine-like solutions y1, y2 from z = 0, an instant of even symmetry, to z = pi / 2:

    y1' = (pi/2) det(even),  y2 = (pi/2) det(odd),  y1 = det(1 + q),  y2' = det(1 - q),
    trace - 2 = 4 y1' y2,    trace + 2 = 4 y1 y2'

so the discriminant's excess X = (abs(trace) - 2) / 4 is a product of two determinants that keep their digits where the
trace loses them.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.arrays import EPS
from floquetrod._util.compilation import kernel
from floquetrod.floquet.mathieu_chains.mathieu_counts import shown_by_count
from floquetrod.floquet.mathieu_chains.mathieu_determinants import determinant, determinant_pair, two_product, two_sum
from floquetrod.floquet.mathieu_chains.mathieu_tail import TAIL_ERROR, slack
from floquetrod.floquet.status import STABLE, UNSTABLE

_ENOUGH = 2e-13  # relative error of the excess above which the minors are run again in double-double


@kernel
def _unforced_excess(a: float) -> tuple[int, float, int, float, int]:
    """Return what `discriminant_excess` does where alpha = 0."""
    # y'' + a y = 0 over its period pi: trace = 2 cos(pi sqrt a) = 2 cos(2 pi root), so (trace - 2) / 4 = -sin^2(pi
    # root), or with the other sign -cos^2; f is root less the nearest whole number, so that no digits are lost.  For a
    # < 0 it is sinh^2(pi |root|), beyond 100 as exp(2 pi root) / 4 = 2^power / 4.
    root = 0.5 * math.sqrt(abs(a))
    if a > 0.0:
        f = root - math.floor(root + 0.5)
        error = 4.0 * EPS * (1.0 + math.pi * root)
        if abs(f) <= 0.25:
            return 1, -(math.sin(math.pi * f) ** 2), 0, error, 1
        return -1, -(math.cos(math.pi * f) ** 2), 0, error, 1
    error = 8.0 * EPS * (1.0 + math.pi * root)
    if root < 100.0:
        return 1, math.sinh(math.pi * root) ** 2, 0, error, 1
    power = 2.0 * math.pi * root / math.log(2.0)
    whole = math.floor(power)
    return 1, 0.25 * 2.0 ** (power - whole), int(whole), error, 1


@kernel
def discriminant_excess(alpha: float, beta: float, damping: float) -> tuple[int, float, int, float, int]:
    """Return (sign, X, exponent, error, rows): the excess X 2^exponent of the equation freed of its damping.

    X = (abs(D) - 2) / 4 for the discriminant D of (alpha, beta + damping^2) and ``sign`` the sign of D; ``error`` is
    the estimated error relative to abs(X) (absolute where X is zero); ``rows`` counts the rows of the determinants.
    """
    q = 2.0 * abs(alpha)
    ch, cl = two_product(damping, damping)
    bh, bl = two_sum(beta, ch)
    ah = -4.0 * bh
    al = -4.0 * (bl + cl)
    if q == 0.0:
        return _unforced_excess(ah)
    # (trace - 2) / 4, from the chains of period pi, gives (trace + 2) / 4 by adding 1, except where that cancels:
    # there, beside the boundaries of period 2 pi, the other two chains are needed.
    u, v, eu, ev, ru, rv, rows = determinant_pair(ah, q, False)
    x = u * v * (0.25 * math.pi * math.pi)
    e = eu + ev
    value = math.ldexp(x, e) if e < 60 else math.copysign(1e18, x)
    cancels = -1.5 < value < -0.67
    if cancels:
        u, v, eu, ev, ru, rv, rows = determinant_pair(ah, q, True)
        x = -u * v
        e = eu + ev
        value = math.ldexp(x, e)
    # Near a boundary of strong forcing the minors lose digits: there both run again in double-double.
    error = ru + rv
    if error > 1e-9 or error * min(1.0, abs(value)) > _ENOUGH * slack(ah, q):
        chain = 2 if cancels else 0
        uu, eu = determinant(ah, al, q, chain)
        vv, ev = determinant(ah, al, q, chain + 1)
        x = uu * vv * (-1.0 if cancels else 0.25 * math.pi * math.pi)
        # The derivative of a determinant is the same in both precisions; the determinant is what has changed.
        old = e
        e = eu + ev
        loss = abs(u * v / (uu * vv)) * 2.0 ** max(-900.0, min(900.0, float(old - e))) if x != 0.0 else math.inf
        error = 2.0 * (TAIL_ERROR * slack(ah, q) + EPS * rows) + 1e-15 * error * max(1.0, loss)
        value = math.ldexp(x, e) if e < 60 else math.copysign(1e18, x)
    if cancels:
        return -1, x, e, error, 4 * rows
    # X by the sign of the trace: (trace - 2) / 4 for a positive one, else -(trace + 2) / 4 = -1 - that.
    if value >= -0.5:
        return 1, x, e, error, 2 * rows
    if e < 60:
        return -1, -1.0 - value, 0, error * abs(value / (1.0 + value)), 2 * rows
    return -1, -x, e, error, 2 * rows


@kernel
def undamped_growth(alpha: float, beta: float, damping: float) -> float:
    """Return the growth rate per unit tau of the equation freed of its damping, (alpha, beta + damping^2)."""
    # Growth per period 2 asinh(sqrt X), since |D| = 2 + 4 X = 2 cosh; over 2 pi, and by logarithms beyond doubles.
    _, x, e, _, _ = discriminant_excess(alpha, beta, damping)
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
def is_stable(alpha: float, beta: float, c: float, tolerance: float = 0.0) -> bool:
    """Return whether no solution of A'' + 2 c A' = (beta + alpha sin tau) A grows faster than ``tolerance``; c >= 0."""
    if alpha == 0.0 and c > 0.0 and tolerance == 0.0:
        return beta <= 0.0  # at beta = 0 what is left is A' + 2 c A = const
    shown = shown_by_count(alpha, beta + c * c)
    if shown == STABLE or (shown == UNSTABLE and c + tolerance == 0.0):
        return shown == STABLE
    return undamped_growth(alpha, beta, c) <= c + tolerance


@kernel
def damped_stable_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` with the verdicts on equations with damping, or without."""
    for i in range(len(alpha)):
        out[i] = is_stable(alpha[i], beta[i], damping[i], 0.0)


@kernel
def discriminant_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` with discriminants (traces of the monodromy matrix), infinite beyond the range of a double."""
    # D = sign (2 + 4 X) exp(-2 pi c), by its logarithm, 4 X being all of it, where either factor leaves the doubles.
    for i in range(len(alpha)):
        sign, x, e, _, _ = discriminant_excess(alpha[i], beta[i], damping[i])
        decay = 2.0 * math.pi * damping[i]
        if e > 900 or decay > 700.0:
            size = math.log(4.0) + math.log(abs(x)) + e * math.log(2.0) - decay if x > 0.0 else -decay
            out[i] = sign * (math.exp(size) if size < 709.7 else math.inf)
        else:
            out[i] = sign * (2.0 + 4.0 * math.ldexp(x, e)) * math.exp(-decay)


@kernel
def multipliers_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` (n, 2) complex with multipliers, the larger (or the one of positive rotation) first."""
    # mu^2 - D mu + exp(-4 pi c) = 0, D = sign (2 + 4 X) exp(-2 pi c).  For X > 0 both are real, sign exp(+-rise -
    # decay).  For X <= 0 they are a pair of the angle theta, sin^2(theta / 2) = -X (pi - theta where D < 0): half
    # angles keep the digits of a pair close to 1 or -1.
    for i in range(len(alpha)):
        sign, x, e, _, _ = discriminant_excess(alpha[i], beta[i], damping[i])
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


@kernel
def exponents_fill(alpha: Any, beta: Any, damping: Any, out: Any) -> None:
    """Fill ``out`` (n, 2) complex with Floquet exponents per unit tau, the faster (or of positive rotation) first."""
    # log(mu) / 2 pi: +-(growth) - c with the imaginary part 0 or 1/2 where X > 0, else +-i theta / 2 pi - c, theta / 2
    # = asin(sqrt(-X)) (pi - theta where D < 0), as in `multipliers_fill`.  0.0 - x keeps zeros positive.
    for i in range(len(alpha)):
        sign, x, e, _, _ = discriminant_excess(alpha[i], beta[i], damping[i])
        if x > 0.0:
            rate = undamped_growth(alpha[i], beta[i], damping[i])
            turn = 0.0 if sign > 0 else 0.5
            out[i, 0] = complex(rate - damping[i], turn)
            out[i, 1] = complex(-rate - damping[i], turn)
        else:
            part = math.asin(min(1.0, math.sqrt(-math.ldexp(x, e)))) / math.pi
            turn = part if sign > 0 else 0.5 - part
            out[i, 0] = complex(0.0 - damping[i], turn)
            out[i, 1] = complex(0.0 - damping[i], 0.5 if turn == 0.5 else 0.0 - turn)


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
    if q == 0.0:
        return worst  # nothing couples
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
