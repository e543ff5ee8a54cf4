"""One of Hill's four determinants cut off after any number of rows, as in the published study, and its error."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import EPS
from floquetrod.floquet.multiplier_pairs import ldexp

_MOST_LEFT_OUT = 0.1  # of a determinant, beyond which its error can no longer be determined (a choice)
_PRODUCT_TERMS = 32  # powers of h^2 / k^2, at most 1/4: 4^-32 is far below rounding


class ChainDeterminant:
    """One determinant: its scaled value (value * 2**exponent), count of negative minors' ratios, and its errors."""

    def __init__(self, a: float, q: float, first: int, rows: int, shift: float = 0.0) -> None:
        """Expand the tridiagonal determinant of ``rows`` rows with diagonal first^2 - a + shift, (first + 2)^2 - a, ...

        Minors obey M_k = (D_k - a) M_(k-1) - q^2 M_(k-2); each is scaled by D_k (1 for D = 0) at once.
        """
        before, here = 1.0, first * first - a + shift
        slope_before, slope = 0.0, -1.0
        self.negative = int(here < 0.0)
        self.exponent = 0
        coupling = 2.0 * q * q if first == 0 else q * q
        k = first
        if k:
            here, slope = here / (k * k), slope / (k * k)
        scale = float(k * k or 1)
        # here and before are M_k and M_(k-1) over the product of D; slope and slope_before their derivatives by a.
        for _ in range(rows - 1):
            k += 2
            d = float(k * k)
            here, before = ((d - a) * here - coupling / scale * before) / d, here
            slope, slope_before = (
                ((d - a) * slope - before - coupling / scale * slope_before) / d,
                slope,
            )
            self.negative += (here < 0.0) != (before < 0.0)
            coupling, scale = q * q, d
            if not 1e-100 < abs(here) + abs(before) < 1e100:
                power = math.frexp(abs(here) + abs(before))[1]
                scaled = (ldexp(x, -power) for x in (here, before, slope, slope_before))
                here, before, slope, slope_before = scaled
                self.exponent += power
        # The last pivot, M_k / M_(k-1) unscaled: beyond q, with rows of at least 2 q to come, the rest is known.
        ratio = here * k * k / before if before else math.inf if here else 0.0
        kappa, h2, big_q = 0.5 * k, 0.25 * a, q * q / 16.0
        self.settled = ratio > q and (k + 2) ** 2 - a >= 2.0 * q
        if not self.settled:
            self.value, self.sensitivity, self.left_out = here, math.inf, math.inf
            return
        self.sensitivity = abs(slope / here) if math.isfinite(slope) else math.inf
        # value = M (1 - edge) exp(-coupled) times the product of 1 - h^2 / k^2 over the rows left out.
        log_rest, rounding = _log_product(kappa, h2)
        coupled, self.left_out = _coupling(kappa, h2, big_q)
        # The last row kept is coupled to the first left out, a part `edge` of the whole.
        edge = 4.0 * big_q / ratio / ((kappa + 1.0) ** 2 - h2)
        gap = (kappa + 1.0) ** 2 - h2
        self.left_out += rounding + abs(edge) * big_q / gap / ((kappa + 2.0) ** 2 - h2)
        if not self.left_out < _MOST_LEFT_OUT:
            self.settled, self.left_out = False, math.inf
        power = int(log_rest / math.log(2.0))
        rest = math.exp(log_rest - power * math.log(2.0))
        self.value, shift = math.frexp(here * math.exp(-coupled) * (1.0 - edge) * rest)
        self.exponent += power + shift


def _coupling(kappa: float, h2: float, big_q: float) -> tuple[float, float]:
    """Return minus the logarithm of what the coupling of the rows left out multiplies by, and its error.

    To first order it is S, the sum of Q / ((j^2 - h^2) ((j + 1)^2 - h^2)) over j = kappa + 1, kappa + 2, ...  With
    m = j + 1/2 and u = h^2 + 1/4 a term is Q m^-4 [1 + 2 u / m^2 + ...]: two terms are summed where the series is
    short.  Second order is below 3 Q S / (2 gap), gap the smallest denominator.
    """
    from scipy.special import zeta

    least = (kappa + 1.0) ** 2 - h2  # 4 least >= 2 q: positive
    gap = least * ((kappa + 2.0) ** 2 - h2)
    middle, u = kappa + 1.5, h2 + 0.25
    four, six = float(zeta(4.0, middle)), float(zeta(6.0, middle))
    if abs(u) < 0.25 * middle * middle:
        first = big_q * (four + 2.0 * u * six)
        # The next terms are (3 h^4 + ...) / m^8 and fall like powers of u / m^2, at most 1/4.
        error = 8.0 * big_q * (u * u + abs(u) + 1.0) * six / (middle * middle)
    else:
        # Each term lies between 0 and the first, and below that of h^2 = 0 where h^2 < 0.
        highest = big_q * four if h2 <= 0.0 else big_q / gap + big_q / math.sqrt(gap)
        first, error = 0.5 * highest, 0.5 * highest
    return first, error + 3.0 * big_q / gap * (first + error)


def _log_product(kappa: float, h2: float) -> tuple[float, float]:
    """Return the logarithm of the product of 1 - h^2 / k^2 over k = kappa + 1, kappa + 2, ..., and its rounding.

    h^2 must be below (kappa + 1)^2.
    """
    from scipy.special import loggamma, zeta

    first = kappa + 1.0
    if abs(h2) < 0.25 * first * first:
        # Term by term, without the cancellation between logarithms of Gamma functions.
        powers = np.arange(1, _PRODUCT_TERMS)
        sums = zeta(2.0 * powers, first) * first ** (2.0 * powers)  # of (first / k)^2j, at most first + 1
        value = -float(np.sum((h2 / (first * first)) ** powers / powers * sums))
        return value, 8.0 * EPS * (1.0 + abs(value))
    h = math.sqrt(abs(h2))
    far = first + h + 20.0  # what cancels is of the size far log(far), or below (heuristic)
    rounding = 8.0 * EPS * far * math.log(far)
    if h2 >= 0.0:
        return 2.0 * math.lgamma(first) - math.lgamma(first - h) - math.lgamma(first + h), rounding
    return 2.0 * (math.lgamma(first) - float(loggamma(complex(first, h)).real)), rounding
