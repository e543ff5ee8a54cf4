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
from floquetrod.floquet.proof.kernels.double_intervals import (
    PI_HIGH,
    PI_LOW,
    Pair,
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
def _power_sum(n: float, j: int) -> Pair:
    """Enclose the sum of k^(-2 j) for k = n, n + 2, n + 4, ...: the midpoint rule, errors between two integrals."""
    # f(x) = x^(-2 j).  Twice f(k) is less than the integral of f from k - 1 to k + 1: by f''(k) / 3 at least and (f''(k
    # - 1) + f''(k + 1)) / 6 at most, f'' being convex.  Over k = n, n + 2, ... these add up to |f'(n)| / 6 at least,
    # and to (f''(n - 1) + |f'(n)|) / 6 at most, since f'' falls.  ``whole`` is the integral from n - 1 on.
    power = 2.0 * j
    before = divide((1.0, 1.0), (n - 1.0, n - 1.0))
    here = divide((1.0, 1.0), (n, n))
    f = 1.0, 1.0
    g = here
    for _ in range(2 * j):
        f = multiply(f, before)
        g = multiply(g, here)
    # f: (n - 1)^(-2 j); g: n^(-2 j - 1), so that abs(f'(n)) = 2 j g and f''(n - 1) = 2 j (2 j + 1) f / (n - 1)^2
    whole = divide(multiply(f, (n - 1.0, n - 1.0)), (power - 1.0, power - 1.0))
    high = up(whole[1] - down(down(power * g[0]) / 6.0))
    steep = up(up(up(power * (power + 1.0) * f[1]) * up(before[1] * before[1])) * 0.5)
    low = down(whole[0] - up(up(steep + up(up(power * g[1]) * 0.5)) / 3.0))
    return 0.5 * low, 0.5 * high


@kernel
def _tail(a: Pair, q: float, ql: float, n: float) -> Pair:
    """Enclose the product of all e_k / (k^2 h) for k = n, n + 2, ...; q in [ql, q].

    e_k / (k^2 h) = 1 - (a + y_k) / k^2 with y_k = q^2 / ((k + 2)^2 - a - ...), its logarithm is log of
    1 - a / k^2 plus log of 1 - y_k / (k^2 - a).
    """
    # -log of the product = sum_j (a^j / j) sum_k k^-2j + terms in q: the first sum runs over j = 1 to 8 in ``total``,
    # and ``rest`` bounds what follows, a geometric series of ratio |a| / n^2 <= 1/4. The coupling adds between
    # ``least`` and ``most``: y_k / (k^2 - a) is at least q^2 over (k^2 + |a|)^2, at most q^2 over (room k^2)^2, summed
    # by an integral; ``room`` is the least 1 - (a + q) / k^2.
    size = max(abs(a[0]), abs(a[1]))
    n2 = n * n
    ratio = up(size / n2)
    if not up(up(size + 2.0 * q) / n2) <= 0.25:
        return math.nan, math.nan
    total = 0.0, 0.0
    power = 1.0, 1.0
    last = 1.0
    for j in range(1, 9):
        power = multiply(power, a)
        powers = _power_sum(n, j)
        total = add(total, divide(multiply(power, powers), (float(j), float(j))))
        last = powers[1]
    rest = last
    for _ in range(9):
        rest = up(rest * (size if _ < 8 else ratio))
    rest = up(rest / down(1.0 - ratio))
    low = down(total[0] - rest)
    high = up(total[1] + rest)
    # The sum of y_k / (k^2 - a), and of -log(1 - t) <= t / (1 - t).
    room = down(1.0 - up(max(0.0, up(a[1] + q)) / n2))
    most = up(up(q * q) / down(down(6.0 * down(down(n2 - 1.0) * down(n2 - 1.0))) / n))
    most = up(most / down(room * room))
    far = up(1.0 + up(max(0.0, -a[0]) / n2))
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
def _taken(d: Pair, kappa: Pair, g2: Pair) -> Pair:
    """Return v = kappa + g^2 / d, what the row of a pivot d and its own kappa take from the next; d holds no zero."""
    if d[0] > 0.0:
        return down(kappa[0] + down(g2[0] / d[1])), up(kappa[1] + up(g2[1] / d[0]))
    return down(kappa[0] + down(g2[1] / d[1])), up(kappa[1] + up(g2[0] / d[0]))


@kernel
def _share(v: Pair, x: Pair) -> Pair:
    """Return 1 - v / x, what a row with the diagonal x, above zero, contributes to a product."""
    low = down(1.0 - up(v[1] / (x[0] if v[1] >= 0.0 else x[1])))
    high = up(1.0 - down(v[0] / (x[1] if v[0] >= 0.0 else x[0])))
    return low, high


@kernel
def _scaled(product: Pair, steps: int) -> tuple[Pair, int]:
    """Return a product scaled back to the range of a double, and in how many steps."""
    low, high = product
    size = max(abs(low), abs(high))
    if size > _BIG:
        return (down(low / _STEP), up(high / _STEP)), steps + 1
    if size * _BIG < 1.0:
        return (down(low * _STEP), up(high * _STEP)), steps - 1
    return product, steps


@kernel
def _diagonal(k: float, h: Pair) -> Pair:
    """Enclose k^2 h."""
    return down(k * k * h[0]), up(k * k * h[1])


@kernel
def _middle(c: Pair, s: Pair, t: Pair, e: Pair, g2: Pair) -> Pair:
    """Enclose S_c S_s: as a product, and as the squared mean less the square of half their difference t."""
    # S_c = c - g^2 / e and S_s = s - g^2 / e are strongly correlated: both carry the widths of kappa and e.  With t = c
    # - s known well, S_c S_s = m^2 - (t / 2)^2, m = S_c - t / 2 = S_s + t / 2, whose enclosure is that of both; the
    # narrower of the two products counts, end by end.
    beyond = divide(g2, e)
    c = subtract(c, beyond)
    s = subtract(s, beyond)
    half = 0.5 * t[0], 0.5 * t[1]
    one = subtract(c, half)
    other = add(s, half)
    mean = max(one[0], other[0]), min(one[1], other[1])
    squares = subtract(square(mean), square(half))
    product = multiply(c, s)
    return max(product[0], squares[0]), min(product[1], squares[1])


@kernel
def _met(enclosure: Pair, middle: Pair, rest: Pair, steps: int) -> Pair:
    """Return the intersection of an enclosure with the product of two others, whose scalings are undone."""
    # X = middle times rest, rest scaled by `_STEP`^steps: the factors return as powers of two, exactly, except that
    # what leaves the doubles is replaced by 1e300, still a bound.
    low, high = multiply(middle, rest)
    if not low <= high:
        return enclosure
    while steps > 0:  # exact, and what overflows is still a bound
        low = min(low * _STEP, 1e300)
        high = max(high * _STEP, -1e300)
        steps -= 1
    while steps < 0:
        low = down(low / _STEP)
        high = up(high / _STEP)
        steps += 1
    return max(enclosure[0], low), min(enclosure[1], high)


@kernel
def excess(kappa: Pair, p: Pair, omega: Pair, parity: int) -> Pair:
    """Enclose X_even (``parity`` 0) or X_odd (1) for kappa, p > 0 and omega of a box; NaN where it cannot.

    Every row where forward and backward pivots can meet gives an enclosure; the result is their intersection.
    """
    # Rows k = parity, parity + 2, ... have the diagonal x = k^2 h and the pivots, with v = kappa + g^2 / d (`_taken`),
    #     forward c, s = x - v of the two chains,    backward e = x - v of both,    t = c - s <- g^2 t / (c s).
    # A determinant over its diagonal is, for every row r, (product of forward c / x before r) (S_c / x) (product of
    # backward e / x beyond), S_c = c - g^2 / e (twisted factorisation: I. S. Dhillon and B. N. Parlett, Linear Algebra
    # Appl. 387 (2004) 1), and likewise with s; X is the product of both.  Backward first, from far out down to
    # ``inner``: for each row, e of the next one and w, the squared product of all beyond, are kept in ``backward``, its
    # scaling in ``scales``; then forward up to ``outer``, w the product of all rows before, and at each row on the way
    # an enclosure (`_middle`, `_met`).  No one row is the best for all of a box, since a pivot that may be zero there
    # ends a side: hence all rows, and their intersection.
    enclosure = -math.inf, math.inf
    h = square(omega)
    h = 0.25 * h[0], 0.25 * h[1]
    g = 0.5 * p[1]
    g2 = square((0.5 * p[0], g))
    a = divide(kappa, h)
    q = up(g / h[0])
    top = max(a[1] + 2.0 * q, 0.0)
    reach = max(top, 2.0 * q - a[0])
    if not (h[0] > 0.0 and reach < 0.05 * _LONGEST * _LONGEST):
        return enclosure
    first = float(parity)
    n = first + 2.0 * math.floor(1.3 * math.sqrt(reach) + 4.0)
    # Rows where pivots may meet: from the last with k^2 <= a - 2 q to the first with k^2 >= a + 2 q.
    inner = first + 2.0 * max(0.0, math.floor(0.5 * (math.sqrt(max(a[0] - 2.0 * q, 0.0)) - first)))
    outer = first + 2.0 * max(0.0, math.ceil(0.5 * (math.sqrt(top) - first)))
    w = _tail(a, q, down(0.5 * p[0] / h[1]), n + 2.0)
    # From far out the backward pivots settle; e is that of row k.
    k = n + 2.0 * (_SETTLING + 1.0)
    x = _diagonal(k, h)
    if not (down(x[0] - kappa[1]) >= 2.0 * g and w[0] > 0.0 and w[1] < math.inf):
        return enclosure
    e = down(down(x[0] - kappa[1]) - g), up(x[1] - kappa[0])
    while k > n + 2.0:
        k -= 2.0
        e = subtract(_diagonal(k, h), _taken(e, kappa, g2))
    # The product of all rows from k on, both chains, beside them; kept for the rows where pivots may meet.
    w = square(w)
    steps = 0
    count = int(0.5 * (outer - inner)) + 1
    backward = np.empty((count, 4))
    scales = np.zeros(count, dtype=np.int64)
    least = count
    while True:
        k -= 2.0
        if k <= outer:
            least = int(0.5 * (k - inner))
            backward[least, 0], backward[least, 1] = e
            backward[least, 2], backward[least, 3] = w
            scales[least] = steps
        if k <= inner:
            break
        x = _diagonal(k, h)
        v = _taken(e, kappa, g2)
        e = subtract(x, v)
        if not (e[0] > 0.0 or e[1] < 0.0):
            break
        w, steps = _scaled(multiply(w, square(_share(v, x))), steps)
    if least == count:
        return enclosure
    # Forward pivots c and s of the two chains, their difference t, and the product of all rows before.
    steps = 0
    if parity == 1:
        w = -1.0, -1.0
        k = 1.0
        x = h
        vc = down(kappa[0] - g), up(kappa[1] - 0.5 * p[0])
        vs = down(kappa[0] + 0.5 * p[0]), up(kappa[1] + g)
        t = p
    else:
        w = square((0.5 * PI_LOW, 0.5 * PI_HIGH))
        # The even chain has the row 0 more, coupled by 2 g^2; it may itself be the row where pivots meet.
        twice = 2.0 * g2[0], 2.0 * g2[1]
        if inner == 0.0 and least == 0:
            v = _taken((backward[0, 0], backward[0, 1]), kappa, twice)
            c = multiply(divide((-v[1], -v[0]), h), w)
            enclosure = _met(enclosure, c, (backward[0, 2], backward[0, 3]), scales[0])
        if not (kappa[0] > 0.0 or kappa[1] < 0.0):
            return enclosure
        w = multiply(w, (-a[1], -a[0]))
        k = 2.0
        x = _diagonal(k, h)
        vc = kappa
        minus = -kappa[1], -kappa[0]
        vs = _taken(minus, kappa, twice)
        t = divide(twice, minus)
    while k <= outer:
        c = subtract(x, vc)
        s = subtract(x, vs)
        i = int(0.5 * (k - inner))
        if k >= inner and i >= least:
            middle = _middle(c, s, t, (backward[i, 0], backward[i, 1]), g2)
            middle = multiply(divide(middle, square(x)), w)
            enclosure = _met(enclosure, middle, (backward[i, 2], backward[i, 3]), steps + scales[i])
        if not ((c[0] > 0.0 or c[1] < 0.0) and (s[0] > 0.0 or s[1] < 0.0)):
            break
        w = multiply(multiply(w, _share(vc, x)), _share(vs, x))
        w, steps = _scaled(w, steps)
        t = divide(multiply(t, g2), multiply(c, s))
        k += 2.0
        x = _diagonal(k, h)
        vc = _taken(c, kappa, g2)
        vs = _taken(s, kappa, g2)
    return enclosure
