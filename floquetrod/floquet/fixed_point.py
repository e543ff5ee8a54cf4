"""The map over a period by power series, summed in fixed point, a step at a time.

Numbers are integers times 2**-bits.  `floquetrod.floquet.methods.reference` says which series and why.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

GUARD_BITS = 24  # beyond what the digits need (heuristic)

Matrix = tuple[int, int, int, int]


class PrecisePiece(NamedTuple):
    """A piece of the coefficient with time in units of period / 2 pi, as numbers of a context."""

    begin: Any
    length: Any
    mean: Any
    slope: Any
    harmonics: tuple[tuple[Any, Any], ...]

    @property
    def size(self) -> Any:
        """Bound on abs(p)."""
        return abs(self.mean) + abs(self.slope) * self.length + sum(abs(re) + abs(im) for re, im in self.harmonics)


def period_map(
    stretches: list[PrecisePiece], damping: Any, context: Any, pieces: int, more: int, bits: int, offset: float
) -> tuple[Matrix, int, int]:
    """Return the map over a period as integers times 2**exponent, and the terms summed.

    Each stretch takes its share of about ``pieces`` steps, and ``more``.  A period that is one stretch begins
    ``offset`` steps after tau = 0.
    """
    total, exponent, terms = (1 << bits, 0, 0, 1 << bits), -bits, 0
    for stretch in stretches:
        count = math.ceil(pieces * stretch.length / (2 * context.pi)) + more
        half = stretch.length / (2 * count)
        shifted = context.mpf(offset) if len(stretches) == 1 and not stretch.slope else context.zero
        for piece in range(count):
            middle = (2 * piece + 1 + shifted) * half
            ends = _ends(stretch, middle, half, damping, context, bits)
            terms += sum(end[4] for end in ends)
            total, exponent = _advance(total, exponent, ends, bits)
    return total, exponent, terms


def _ends(
    stretch: PrecisePiece, middle: Any, half: Any, damping: Any, context: Any, bits: int
) -> list[tuple[int, int, int, int, int]]:
    """Return what `_series` does for both unit solutions of a step whose middle is ``middle`` after the beginning."""
    starts = ((1 << bits, 0), (0, 1 << bits))
    mean = stretch.mean + stretch.slope * middle
    waves = []
    for k, (re, im) in enumerate(stretch.harmonics, start=1):
        cosine, sine = context.cos_sin(k * (stretch.begin + middle))
        waves.append((re * cosine - im * sine, re * sine + im * cosine))
    if stretch.slope:
        p = _power_series(mean, stretch.slope, waves, half, bits)
        drag = _fixed(2 * damping * half, bits)
        return [_direct_series(start, p, drag, half, bits) for start in starts]
    drag = _fixed(2 * damping, bits)
    tangent = context.tan(half / 2)
    shift = -context.mag(tangent)  # the series runs in t 2**shift, at most 1
    reach = _fixed(context.ldexp(tangent, shift), bits)
    fixed = [(_fixed(re, bits), _fixed(im, bits)) for re, im in waves]
    return [_series(start, _fixed(mean, bits), drag, fixed, reach, shift, bits) for start in starts]


def _power_series(mean: Any, slope: Any, waves: list[tuple[Any, Any]], half: Any, bits: int) -> list[int]:
    """Return p_j half^(j + 2) in fixed point, p = sum_j p_j x^j about a step's middle."""
    terms = [mean * half**2, slope * half**3]
    for k, (re, im) in enumerate(waves, start=1):
        a, b, j = re * half**2, im * half**2, 0
        while j < 2 or max(abs(a), abs(b)) * 2**bits > 1:
            if j == len(terms):
                terms.append(0 * a)
            terms[j] += a
            a, b, j = -k * half * b / (j + 1), k * half * a / (j + 1), j + 1
    return [_fixed(term, bits) if term else 0 for term in terms]


def _direct_series(
    start: tuple[int, int], p: list[int], drag: int, half: Any, bits: int
) -> tuple[int, int, int, int, int]:
    """Sum A and B at both ends of a step by the power series in x / half; returns as `_series` does.

    ``p`` is from `_power_series` and ``drag`` is 2 c half.
    """
    step = _fixed(half, bits)
    a = [start[0], start[1] * step >> bits]
    n, small = 0, 0
    while small < 4:
        push = sum(p[j] * a[n - j] for j in range(min(len(p), n + 1))) - drag * (n + 1) * a[n + 1]
        a.append((push >> bits) // ((n + 1) * (n + 2)))
        small = small + 1 if abs(a[-1]) < 4 else 0
        n += 1
    slopes = [(j * value << bits) // step for j, value in enumerate(a)]
    return sum(a[0::2]), sum(a[1::2]), sum(slopes[1::2]), sum(slopes[2::2]), n


def _series(
    start: tuple[int, int], mean: int, damping: int, waves: list[tuple[int, int]], reach: int, shift: int, bits: int
) -> tuple[int, int, int, int, int]:
    """Sum A and B = A' at both ends of a piece from ``start`` = (A, B) in its middle.

    Returns the even and odd parts of A and of B, and the number of terms; all in fixed point with ``bits`` bits.
    """
    # The recurrences of `floquetrod.floquet.methods.reference` in the coefficients of t = tan(theta / 2), n from 0 on:
    #     (n + 1) A_(n+1) = 2 B_n - (n - 1) A_(n-1),    (n + 1) B_(n+1) = 2 (p A - 2 c B)_n - (n - 1) B_(n-1),
    # and W_k = W_(k-1) + i t (W_(k-1) + W_k).  All are integers times 2^-bits, and of power n times 2^(-shift n), so
    # that none outgrows the others; ``reach`` is t at the end of the piece times 2^shift.  ``chain`` holds W_k of order
    # n - 1 and is replaced by order n on the way up in k.  The sum ends after four orders in a row whose terms at the
    # end of the piece are below a few last bits.
    a_now, b_now = start
    a_old = b_old = 0
    a_all, b_all = [a_now], [b_now]
    chain = [(0, 0)] * len(waves)  # coefficients of W_k one order below
    descent = bits - reach.bit_length() + 1 - math.log2(reach / (1 << (reach.bit_length() - 1)))
    small = 0
    n = 0
    while small < 4:
        push = mean * a_now - damping * b_now
        lower_re, lower_im, here_re, here_im = a_old, 0, a_now, 0
        largest = abs(a_now) | abs(b_now)
        for k, (wave_re, wave_im) in enumerate(waves):
            old_re, old_im = chain[k]
            # W_k = W_(k-1) + i t (W_(k-1) + W_k), the bracket one order below
            here_re, here_im = here_re - ((lower_im + old_im) >> shift), here_im + ((lower_re + old_re) >> shift)
            chain[k] = here_re, here_im
            lower_re, lower_im = old_re, old_im
            push += wave_re * here_re - wave_im * here_im
            largest |= abs(here_re) | abs(here_im)
        a_next = ((b_now << 1 >> shift) - ((n - 1) * a_old >> 2 * shift)) // (n + 1)
        b_next = ((push >> (bits + shift - 1)) - ((n - 1) * b_old >> 2 * shift)) // (n + 1)
        small = small + 1 if largest.bit_length() < 4 + n * descent else 0
        a_old, b_old, a_now, b_now = a_now, b_now, a_next, b_next
        a_all.append(a_now)
        b_all.append(b_now)
        n += 1
    square = reach * reach >> bits
    parts = []
    for series in (a_all, b_all):
        even, odd = _horner(series[0::2], square, bits), _horner(series[1::2], square, bits)
        parts += [even, odd * reach >> bits]
    return parts[0], parts[1], parts[2], parts[3], n


def _horner(coefficients: list[int], argument: int, bits: int) -> int:
    total = 0
    for coefficient in reversed(coefficients):
        total = coefficient + (total * argument >> bits)
    return total


def _advance(total: Matrix, exponent: int, ends: list[tuple[int, int, int, int, int]], bits: int) -> tuple[Matrix, int]:
    """Multiply ``total`` by the map over a piece: its later end times the inverse of its earlier end."""
    (ae, ao, be, bo, _), (ce, co, de, do, _) = ends
    late = (ae + ao, ce + co, be + bo, de + do)
    w, x, y, z = ae - ao, ce - co, be - bo, de - do
    determinant = w * z - x * y
    inverse = [(entry << 2 * bits) // determinant for entry in (z, -x, -y, w)]
    product = multiply(multiply(late, inverse), total)
    excess = max(entry.bit_length() for entry in product) - bits - GUARD_BITS
    a, b, c, d = (entry >> excess if excess > 0 else entry for entry in product)
    return (a, b, c, d), exponent - 2 * bits + max(excess, 0)


def multiply(left: Sequence[Any], right: Sequence[Any]) -> tuple[Any, Any, Any, Any]:
    """Return the product of two 2 x 2 matrices, row by row."""
    a, b, c, d = left
    e, f, g, h = right
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


def _fixed(number: Any, bits: int) -> int:
    return int(number.context.ldexp(number, bits))
