"""Meissner's equation: both ends of the band of bounded motion in closed form, factorised.

With l1 = beta + alpha, l2 = beta - alpha, h = pi / 2, c = cosh(h sqrt l), s = sinh(h sqrt l) / sqrt l, the map from the
middle of one half period to the middle of the next is [y1, y2; y1', y2'] = [c2, s2; l2 s2, c2] [c1, s1; l1 s1, c1],
both instants are instants of even symmetry, and

    trace - 2 = 4 y1' y2,    trace + 2 = 4 y1 y2'.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod.floquet.proof.many_digits import cosh_sinhc, pi, rational


class Factors(NamedTuple):
    """Enclosures of (trace - 2) / 4 and (trace + 2) / 4."""

    minus: Any
    plus: Any


def trace_factors(context: Any, halves: tuple[Fraction, Fraction], damping: Fraction) -> Factors:
    """Enclose (trace -+ 2) / 4 for u'' = p u, p constant over both halves of the period 2 pi, c^2 added to it."""
    first, second = halves
    alpha, beta, c = (rational(context, value) for value in ((first - second) / 2, (first + second) / 2, damping))
    mean = beta + c**2
    half = pi(context) / 2
    l1, l2 = mean + alpha, mean - alpha
    (c1, s1), (c2, s2) = ((c, half * s) for c, s in (cosh_sinhc(context, half**2 * level) for level in (l1, l2)))
    y1, y2 = c2 * c1 + l1 * s2 * s1, c2 * s1 + s2 * c1
    v1, v2 = l2 * s2 * c1 + l1 * c2 * s1, l2 * s2 * s1 + c2 * c1
    return Factors(v1 * y2, y1 * v2)
