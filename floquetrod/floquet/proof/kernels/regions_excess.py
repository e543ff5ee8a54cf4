"""Kernels that enclose the discriminant's excess over a box of one mode, by twisted factorisations.

The chains (see `regions_modes`) of one parity differ in their first rows only.  Down from these run
the forward pivots d_c and d_s, up from far out the backward pivots e that both chains share, and where they meet, in
row r, stand S = d - g^2 / e.  The determinants are products of all of them, and so are the excesses

    X_even = (trace - 2) / 4 = (pi^2 / 4) det(even) det(odd),    X_odd = -(trace + 2) / 4 = -det(1 + q) det(1 - q),

whose sum is -1 exactly.  Growth per period is 2 asinh(sqrt X) for the one of them that is positive.
"""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.floquet.proof.kernels.intervals import (
    PI_HIGH,
    PI_LOW,
    add,
    divide,
    down,
    exp,
    multiply,
    square,
    subtract,
    up,
)

_LONGEST = 100_000.0  # the last row of a chain: nothing is concluded beyond it
_SETTLING = 3  # rows the backward pivots are given to settle before their product begins
_STEP = 2.0**256  # by which products are scaled
_BIG = 2.0**200  # above which


@kernel
def _power_sum(n: float, j: int) -> tuple[float, float]:
    """Enclose the sum of k^(-2 j) for k = n, n + 2, n + 4, ...: the midpoint rule, errors between two integrals."""
    power = 2.0 * j
    al, ah = divide(1.0, 1.0, n - 1.0, n - 1.0)
    bl, bh = divide(1.0, 1.0, n, n)
    fl, fh = 1.0, 1.0
    gl, gh = bl, bh
    for _ in range(2 * j):
        fl, fh = multiply(fl, fh, al, ah)
        gl, gh = multiply(gl, gh, bl, bh)
    # fl: (n - 1)^(-2 j); gl: n^(-2 j - 1), so that abs(f'(n)) = 2 j gl and f''(n - 1) = 2 j (2 j + 1) fl / (n - 1)^2
    whole_low, whole_high = multiply(fl, fh, n - 1.0, n - 1.0)
    whole_low, whole_high = divide(whole_low, whole_high, power - 1.0, power - 1.0)
    high = up(whole_high - down(down(power * gl) / 6.0))
    steep = up(up(up(power * (power + 1.0) * fh) * up(ah * ah)) * 0.5)
    low = down(whole_low - up(up(steep + up(up(power * gh) * 0.5)) / 3.0))
    return 0.5 * low, 0.5 * high


@kernel
def _tail(al: float, ah: float, q: float, ql: float, n: float) -> tuple[float, float]:
    """Enclose the product of all e_k / (k^2 h) for k = n, n + 2, ...; a in [al, ah], q in [ql, q].

    e_k / (k^2 h) = 1 - (a + y_k) / k^2 with y_k = q^2 / ((k + 2)^2 - a - ...), so that its logarithm is that of
    1 - a / k^2 plus that of 1 - y_k / (k^2 - a).
    """
    size = max(abs(al), abs(ah))
    n2 = n * n
    ratio = up(size / n2)
    if not up(up(size + 2.0 * q) / n2) <= 0.25:
        return math.nan, math.nan
    low, high = 0.0, 0.0
    pl, ph = 1.0, 1.0
    last = 1.0
    for j in range(1, 9):
        pl, ph = multiply(pl, ph, al, ah)
        sl, sh = _power_sum(n, j)
        tl, th = multiply(pl, ph, sl, sh)
        tl, th = divide(tl, th, float(j), float(j))
        low, high = add(low, high, tl, th)
        last = sh
    rest = last
    for _ in range(9):
        rest = up(rest * (size if _ < 8 else ratio))
    rest = up(rest / down(1.0 - ratio))
    low = down(low - rest)
    high = up(high + rest)
    # The sum of y_k / (k^2 - a), and of -log(1 - t) <= t / (1 - t).
    room = down(1.0 - up(max(0.0, up(ah + q)) / n2))
    most = up(up(q * q) / down(down(6.0 * down(down(n2 - 1.0) * down(n2 - 1.0))) / n))
    most = up(most / down(room * room))
    far = up(1.0 + up(max(0.0, -al) / n2))
    least = down(max(0.0, down(ql * ql)) / up(6.0 * up((n + 1.0) * up((n + 1.0) * (n + 1.0)))))
    least = max(0.0, down(least / up(far * far)))
    step = up(up(q * q) / down(down(n2 * room) * down(n2 * room)))
    most = up(most / down(1.0 - step))
    low = down(low + least)
    high = up(high + most)
    first, _ = exp(-high)
    _, second = exp(-low)
    return first, second


@kernel
def _pivot(
    xl: float, xh: float, dl: float, dh: float, kl: float, kh: float, gl: float, gh: float
) -> tuple[float, float, float, float]:
    """Return v = kappa + g^2 / d and the pivot x - v; ``gl``, ``gh`` enclose g^2, d does not hold zero."""
    if dl > 0.0:
        vl = down(kl + down(gl / dh))
        vh = up(kh + up(gh / dl))
    else:
        vl = down(kl + down(gh / dh))
        vh = up(kh + up(gl / dl))
    return vl, vh, down(xl - vh), up(xh - vl)


@kernel
def _share(vl: float, vh: float, xl: float, xh: float) -> tuple[float, float]:
    """Return 1 - v / x, what a row with the diagonal x, above zero, contributes to a product."""
    low = down(1.0 - up(vh / (xl if vh >= 0.0 else xh)))
    high = up(1.0 - down(vl / (xh if vl >= 0.0 else xl)))
    return low, high


@kernel
def _scaled(low: float, high: float, steps: int) -> tuple[float, float, int]:
    """Return a product scaled back to the range of a double, and in how many steps."""
    size = max(abs(low), abs(high))
    if size > _BIG:
        return down(low / _STEP), up(high / _STEP), steps + 1
    if size * _BIG < 1.0:
        return down(low * _STEP), up(high * _STEP), steps - 1
    return low, high, steps


@kernel
def _diagonal(k: float, hl: float, hh: float) -> tuple[float, float]:
    """Enclose k^2 h."""
    return down(k * k * hl), up(k * k * hh)


@kernel
def _middle(
    cl: float, ch: float, sl: float, sh: float, tl: float, th: float, el: float, eh: float, gl: float, gh: float
) -> tuple[float, float]:
    """Enclose S_c S_s: as a product, and as the square of their mean less that of half their difference t."""
    bl, bh = divide(gl, gh, el, eh)
    cl, ch = subtract(cl, ch, bl, bh)
    sl, sh = subtract(sl, sh, bl, bh)
    ml, mh = subtract(cl, ch, 0.5 * tl, 0.5 * th)
    nl, nh = add(sl, sh, 0.5 * tl, 0.5 * th)
    ml, mh = square(max(ml, nl), min(mh, nh))
    nl, nh = square(0.5 * tl, 0.5 * th)
    ml, mh = subtract(ml, mh, nl, nh)
    cl, ch = multiply(cl, ch, sl, sh)
    return max(cl, ml), min(ch, mh)


@kernel
def _met(low: float, high: float, ml: float, mh: float, wl: float, wh: float, steps: int) -> tuple[float, float]:
    """Return the intersection of an enclosure with the product of two others, of which many scalings are undone."""
    ml, mh = multiply(ml, mh, wl, wh)
    if not ml <= mh:
        return low, high
    while steps > 0:  # exact, and what overflows is still a bound
        ml = min(ml * _STEP, 1e300)
        mh = max(mh * _STEP, -1e300)
        steps -= 1
    while steps < 0:
        ml = down(ml / _STEP)
        mh = up(mh / _STEP)
        steps += 1
    return max(low, ml), min(high, mh)


@kernel
def excess(kl: float, kh: float, pl: float, ph: float, slow: float, fast: float, parity: int) -> tuple[float, float]:
    """Enclose X_even (``parity`` 0) or X_odd (1) for kappa, p > 0 and omega of a box; NaN where it cannot.

    Every row where forward and backward pivots can meet gives an enclosure; the result is their intersection.
    """
    nothing = -math.inf, math.inf
    hl, hh = square(slow, fast)
    hl, hh = 0.25 * hl, 0.25 * hh
    g = 0.5 * ph
    gl, gh = square(0.5 * pl, g)
    al, ah = divide(kl, kh, hl, hh)
    q = up(g / hl)
    top = max(ah + 2.0 * q, 0.0)
    reach = max(top, 2.0 * q - al)
    if not (hl > 0.0 and reach < 0.05 * _LONGEST * _LONGEST):
        return nothing
    first = float(parity)
    n = first + 2.0 * math.floor(1.3 * math.sqrt(reach) + 4.0)
    # Rows where pivots may meet: from the last with k^2 <= a - 2 q to the first with k^2 >= a + 2 q.
    inner = first + 2.0 * max(0.0, math.floor(0.5 * (math.sqrt(max(al - 2.0 * q, 0.0)) - first)))
    outer = first + 2.0 * max(0.0, math.ceil(0.5 * (math.sqrt(top) - first)))
    low, high = nothing
    wl, wh = _tail(al, ah, q, down(0.5 * pl / hh), n + 2.0)
    # From far out the backward pivots settle; e is that of row k.
    k = n + 2.0 * (_SETTLING + 1.0)
    xl, xh = _diagonal(k, hl, hh)
    if not (down(xl - kh) >= 2.0 * g and wl > 0.0 and wh < math.inf):
        return nothing
    el, eh = down(down(xl - kh) - g), up(xh - kl)
    while k > n + 2.0:
        k -= 2.0
        xl, xh = _diagonal(k, hl, hh)
        _, _, el, eh = _pivot(xl, xh, el, eh, kl, kh, gl, gh)
    # The product of all rows from k on, both chains, beside them; kept for the rows where pivots may meet.
    wl, wh = square(wl, wh)
    steps = 0
    count = int(0.5 * (outer - inner)) + 1
    backward = np.empty((count, 4))
    scales = np.zeros(count, dtype=np.int64)
    least = count
    while True:
        k -= 2.0
        if k <= outer:
            least = int(0.5 * (k - inner))
            backward[least, 0] = el
            backward[least, 1] = eh
            backward[least, 2] = wl
            backward[least, 3] = wh
            scales[least] = steps
        if k <= inner:
            break
        xl, xh = _diagonal(k, hl, hh)
        vl, vh, el, eh = _pivot(xl, xh, el, eh, kl, kh, gl, gh)
        if not (el > 0.0 or eh < 0.0):
            break
        fl, fh = _share(vl, vh, xl, xh)
        fl, fh = square(fl, fh)
        wl, wh = multiply(wl, wh, fl, fh)
        wl, wh, steps = _scaled(wl, wh, steps)
    if least == count:
        return nothing
    # Forward pivots of the two chains, their difference t, and the product of all rows before.
    steps = 0
    if parity == 1:
        wl, wh = -1.0, -1.0
        k = 1.0
        xl, xh = hl, hh
        cvl, cvh = down(kl - g), up(kh - 0.5 * pl)
        svl, svh = down(kl + 0.5 * pl), up(kh + g)
        tl, th = pl, ph
    else:
        wl, wh = square(0.5 * PI_LOW, 0.5 * PI_HIGH)
        if inner == 0.0 and least == 0:
            el, eh = backward[0, 0], backward[0, 1]
            vl, vh, cl, ch = _pivot(0.0, 0.0, el, eh, kl, kh, 2.0 * gl, 2.0 * gh)
            cl, ch = divide(-vh, -vl, hl, hh)
            cl, ch = multiply(cl, ch, wl, wh)
            low, high = _met(low, high, cl, ch, backward[0, 2], backward[0, 3], scales[0])
        if not (kl > 0.0 or kh < 0.0):
            return low, high
        fl, fh = multiply(wl, wh, -ah, -al)
        wl, wh = fl, fh
        k = 2.0
        xl, xh = _diagonal(k, hl, hh)
        cvl, cvh = kl, kh
        svl, svh, _, _ = _pivot(xl, xh, -kh, -kl, kl, kh, 2.0 * gl, 2.0 * gh)
        tl, th = divide(2.0 * gl, 2.0 * gh, -kh, -kl)
    while k <= outer:
        cl, ch = down(xl - cvh), up(xh - cvl)
        sl, sh = down(xl - svh), up(xh - svl)
        i = int(0.5 * (k - inner))
        if k >= inner and i >= least:
            el, eh = backward[i, 0], backward[i, 1]
            pl, ph = _middle(cl, ch, sl, sh, tl, th, el, eh, gl, gh)
            fl, fh = square(xl, xh)
            pl, ph = divide(pl, ph, fl, fh)
            pl, ph = multiply(pl, ph, wl, wh)
            low, high = _met(low, high, pl, ph, backward[i, 2], backward[i, 3], steps + scales[i])
        if not ((cl > 0.0 or ch < 0.0) and (sl > 0.0 or sh < 0.0)):
            break
        fl, fh = _share(cvl, cvh, xl, xh)
        wl, wh = multiply(wl, wh, fl, fh)
        fl, fh = _share(svl, svh, xl, xh)
        wl, wh = multiply(wl, wh, fl, fh)
        wl, wh, steps = _scaled(wl, wh, steps)
        fl, fh = multiply(cl, ch, sl, sh)
        tl, th = multiply(tl, th, gl, gh)
        tl, th = divide(tl, th, fl, fh)
        k += 2.0
        xl, xh = _diagonal(k, hl, hh)
        cvl, cvh, _, _ = _pivot(xl, xh, cl, ch, kl, kh, gl, gh)
        svl, svh, _, _ = _pivot(xl, xh, sl, sh, kl, kh, gl, gh)
    return low, high
