"""Kernels for the determinant of Mathieu's chains beyond an index, scaled by the diagonal at a = q = 0.

With h^2 = a / 4, Q = q^2 / 16 and D = 4 kappa^2 the scaled determinant of everything beyond kappa obeys

    A(kappa) = (1 - h^2 / (kappa + 1)^2) A(kappa + 1) - Q / ((kappa + 1)^2 (kappa + 2)^2) A(kappa + 2),   A(inf) = 1,

and starts from an asymptotic series at a large index and runs inwards.
"""

from __future__ import annotations

import math

from floquetrod._util.compilation import kernel

TAIL_ERROR = 3e-14  # relative error of `tail` (measured; a test holds it)


@kernel
def _power_sum(x: float, i2: float, s: float) -> float:
    """Return x^(s - 1) times the sum of k^-s over k = x + 1/2, x + 3/2, ... (midpoint Euler-Maclaurin series)."""
    t = 1.0 - (s + 5.0) * (s + 6.0) * i2 * (127.0 * 967680.0 / (154828800.0 * 31.0))
    t = 1.0 - (s + 3.0) * (s + 4.0) * i2 * (31.0 * 5760.0 / (967680.0 * 7.0)) * t
    t = 1.0 - (s + 1.0) * (s + 2.0) * i2 * (7.0 * 24.0 / 5760.0) * t
    return 1.0 / (s - 1.0) - s * i2 * t / 24.0


@kernel
def slack(a: float, q: float) -> float:
    """Return the factor by which errors may grow with the size of the equation: 1 up to a + 2 q = 50 (a choice)."""
    return max(1.0, (abs(a) + 2.0 * q) / 50.0)


@kernel
def _far_out(h2: float, coupling: float) -> float:
    """Return an index beyond which the series of `_log_tail` is good to `TAIL_ERROR` times slack (measured)."""
    # Where the terms of order Q^3 h^4 / x^15, Q^4 h^2 / x^17 and Q^5 / x^19 that the series lacks are below its error.
    far = max(30.0, 4.0 * math.sqrt(abs(h2)))
    if coupling > 20.0 or abs(h2) > 36.0:
        # The first terms left out, of third, fourth and fifth order in Q, each against its share of the error.
        share = 1e13 / slack(4.0 * h2, 4.0 * math.sqrt(coupling))
        far = max(
            far,
            3.0 * coupling**0.25,
            (coupling**3 * (20.0 * h2 * h2 + 100.0) * share) ** (1.0 / 15.0),
            (coupling**4 * (5.0 * abs(h2) + 40.0) * share) ** (1.0 / 17.0),
            (coupling**5 * share) ** (1.0 / 19.0),
        )
    return far


@kernel
def _log_tail(kappa: float, h2: float, coupling: float) -> float:
    """Return log A(kappa) for large kappa, by the cumulants of the tail determinant up to fourth order in Q."""
    # Divided by its diagonal 1 - h^2 / k^2, k = kappa + 1, kappa + 2, ..., the determinant has ones on it and couplings
    # t_k = Q / ((k^2 - h^2) ((k + 1)^2 - h^2)), of which no two neighbours occur in one product.  The logarithm of such
    # a sum is
    #     log A = sum log(1 - h^2 / k^2) - sum t_k - sum (t_k^2 / 2 + t_k t_(k+1)) - (10/3) t^3 - (35/4) t^4 - ...,
    # the last two for equal neighbours (of log((1 + sqrt(1 - 4 t)) / 2)).  Each sum over k is expanded in even powers
    # of 1 / m about the centre m of its product, which leaves no odd ones, and `_power_sum` sums m^-s from x = the
    # first m - 1/2 on: i2 = 1 / x^2, and g and w are coefficients of 1 / (1 - b y + c y^2) and of its square, y = (x /
    # m)^2.
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
    scale = coupling * i2 * i2
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
    two = coupling * i2 * i2
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
    cube = coupling * i2 * i2
    cube = cube * cube * cube * x
    total -= 10.0 / 3.0 * cube * (_power_sum(x, i2, 12.0) + (6.0 * h2 + 11.8) * i2 / 13.0)
    x = kappa + 13.0 / 7.0
    i2 = 1.0 / (x * x)
    fourth = coupling * i2 * i2
    fourth = fourth * fourth
    return total - 35.0 / 4.0 * fourth * fourth * x / 15.0


@kernel
def tail(kappa: float, h2: float, coupling: float) -> tuple[float, float, int]:
    """Return A(kappa), A(kappa + 1), both to be multiplied by 2 to the third value."""
    # A(k) = (1 - h^2 / (k+1)^2) A(k+1) - Q / ((k+1)^2 (k+2)^2) A(k+2), the recurrence at the head of the file, run
    # inwards from ``top``, where the asymptotic series of `_log_tail` begins it: outwards it would be unstable.
    # ``here`` and ``above`` are A(k) and A(k + 1), scaled by 2^-exponent.
    pairs = max(0, int(0.5 * (_far_out(h2, coupling) - kappa)) + 1)
    top = kappa + 2.0 * pairs
    # Ratio A(top) / A(top + 1) by the backward continued fraction; a step divides the error by about top^4 / Q.
    step = coupling / (top * top * top * top)
    error = step
    k = top + 1.0
    while error > 1e-17:
        error *= step
        k += 1.0
    ratio = 1.0 - h2 / (k * k)
    while k > top + 1.0:
        k -= 1.0
        ratio = (1.0 - h2 / (k * k)) - coupling / (k * k * (k + 1.0) * (k + 1.0) * ratio)
    log_tail = _log_tail(top, h2, coupling)
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
        g1 = coupling * i1 * i0
        here, above = (f2 * f1 - coupling * i2 * i1) * here - f2 * g1 * above, f1 * here - g1 * above
        i0 = i2
        k -= 2.0
        if not (1e-200 < abs(here) < 1e200):
            here, shift = math.frexp(here)
            above = math.ldexp(above, -shift)
            exponent += shift
    here, shift = math.frexp(here)
    return here, math.ldexp(above, -shift), exponent + shift
