"""Interval arithmetic: every number is enclosed between two others, rounded outwards.

Of mpmath's intervals only the sums, products, quotients and pi are used, the latter widened; what else is needed is
made of these.  A sign is used only where the whole interval has it; where it does not, `Unresolved` is raised.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod.floquet.proof.proof import Enclosure

_LARGEST_WORK = 4e6  # interval operations, about ten seconds' worth (heuristic)


class Unresolved(Exception):
    """The sign of a quantity cannot be determined at the present precision."""


class TooMuchWork(ValueError):
    """The arithmetic would take too long."""


def arithmetic(digits: int) -> Any:
    """Return a context of interval arithmetic with the given number of decimal digits."""
    from mpmath.ctx_iv import MPIntervalContext

    context = MPIntervalContext()  # our own: the precision of mpmath.iv is shared by the whole process
    context.dps = digits
    return context


def check_work(context: Any, operations: float) -> None:
    """Raise `TooMuchWork` where that many operations would take too long."""
    if operations * (1.0 + context.prec / 2000.0) > _LARGEST_WORK:
        raise TooMuchWork(f"{operations:.0e} operations with intervals")


def rational(context: Any, value: Fraction) -> Any:
    """Enclose an exact number."""
    return context.mpf(value.numerator) / value.denominator


def pi(context: Any) -> Any:
    """Enclose pi, a unit of the last place wider than mpmath does."""
    return context.pi * (1 + context.mpf([-1, 1]) / 2 ** (context.prec - 1))


class CoshSinhc(NamedTuple):
    """Enclosures of cosh(sqrt z) and sinh(sqrt z) / sqrt z."""

    cosh: Any
    sinhc: Any


def cosh_sinhc(context: Any, z: Any) -> CoshSinhc:
    """Enclose cosh(sqrt z) and sinh(sqrt z) / sqrt z, entire in z: series for z / 4^k, doubled k times.

    For abs(z) <= 1 what follows a term is below that term.
    """
    size = max(abs(float(z.a)), abs(float(z.b)))
    doublings = max(0, math.ceil(0.5 * math.log2(size))) + 1 if size > 0.0 else 0
    z = z / 4**doublings
    even = odd = term = context.one
    n = 0
    while not abs(term) < context.mpf(2) ** (-context.prec - 8) and n < context.prec:
        n += 1
        term = term * z / (2 * n * (2 * n - 1))
        even += term
        odd += term / (2 * n + 1)
    rest = abs(term) * context.mpf([-1, 1])
    even, odd = even + rest, odd + rest
    for _ in range(doublings):
        even, odd = 2 * even**2 - 1, odd * even
    return CoshSinhc(even, odd)


def exp(context: Any, x: Any) -> Any:
    """Enclose the exponential function."""
    cosh, sinhc = cosh_sinhc(context, x**2)
    return cosh + x * sinhc


def enclose(quantity: str, value: Any) -> Enclosure:
    """Return an interval by the name of what it holds."""
    import mpmath

    low, high = (mpmath.mp.make_mpf(end) for end in value._mpi_)
    return Enclosure(quantity, low, high)
