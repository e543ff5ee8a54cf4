"""Growth of u'' = p u with 30 digits, by Taylor series in mpmath: the judge of verdicts beside a boundary."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mpmath

_STEP = 0.8  # of a Taylor series, times the rate at which the solution or the coefficient changes
_SAFETY = 12  # digits beyond those asked for


def excess(mean: float, waves: Sequence[complex], period: float | None, damping: float = 0.0, digits: int = 30) -> Any:
    """Return (abs(D) - 2) / 4 of u'' = (mean + c^2 + sum_k Re(z_k exp(i k W s))) u, W = 2 pi / period.

    Numbers are taken exactly; a period of None is the exact 2 pi.
    """
    about = 2.0 * math.pi if period is None else period
    size = abs(mean) + damping**2 + sum(map(abs, waves))
    turn = 2.0 * math.pi / about
    rate = max(math.sqrt(size), turn * max(1, len(waves)))
    with mpmath.workdps(digits + _SAFETY + int(0.5 * about * math.sqrt(size))):
        length = exact_length(period)
        steps = math.ceil(rate * about / _STEP)
        constant = mpmath.mpf(mean) + mpmath.mpf(damping) ** 2
        solutions = [[mpmath.mpf(1), mpmath.mpf(0)], [mpmath.mpf(0), mpmath.mpf(1)]]
        for step in range(steps):
            h = length / steps
            series = _coefficient(constant, waves, 2 * mpmath.pi / length, h * step, h)
            solutions = [_advance(*one, series, h) for one in solutions]
        trace = solutions[0][0] + solutions[1][1]
        return (abs(trace) - 2) / 4


def exact_length(period: float | None) -> Any:
    """Return the period as a number of mpmath: None stands for 2 pi."""
    return 2 * mpmath.pi if period is None else mpmath.mpf(period)


def _coefficient(mean: Any, waves: Sequence[complex], turn: Any, start: Any, h: Any) -> list[Any]:
    """Return the Taylor series of the coefficient about ``start``, in powers of (s - start) / h, times h^2."""
    order = 8
    while order * math.log(2.0 * _STEP) - math.lgamma(order + 1.0) > -math.log(10.0) * (mpmath.mp.dps + 2):
        order += 1
    series = [mpmath.mpf(0)] * order
    series[0] = mean
    for k, z in enumerate(waves, start=1):
        if z == 0:
            continue
        term = mpmath.mpc(z.real, z.imag) * mpmath.expj(k * turn * start)
        for power in range(order):
            series[power] += term.real
            term = term * mpmath.mpc(0, k * turn * h) / (power + 1)
    return [h * h * value for value in series]


def _advance(value: Any, slope: Any, series: list[Any], h: Any) -> list[Any]:
    terms = [value, slope * h]
    for n in range(len(series)):
        total = mpmath.fdot(series[: n + 1], terms[n::-1])
        terms.append(total / ((n + 1) * (n + 2)))
    return [mpmath.fsum(terms), mpmath.fsum(n * term for n, term in enumerate(terms)) / h]


def square_excess(alpha: float, beta: float, damping: float = 0.0, digits: int = 30) -> Any:
    """Return (abs(D) - 2) / 4 of Meissner's equation freed of its damping: two halves of constant coefficient."""
    with mpmath.workdps(digits + _SAFETY + int(3.0 * math.sqrt(abs(alpha) + abs(beta) + damping**2))):
        mean = mpmath.mpf(beta) + mpmath.mpf(damping) ** 2
        first, second = (_half(mean + sign * mpmath.mpf(alpha)) for sign in (1, -1))
        product = second * first
        return (abs(product[0, 0] + product[1, 1]) - 2) / 4


def _half(p: Any) -> Any:
    """Return the map of u'' = p u over half a period."""
    root = mpmath.sqrt(mpmath.mpc(p))
    even = mpmath.cosh(root * mpmath.pi).real
    odd = (mpmath.sinh(root * mpmath.pi) / root).real if p != 0 else +mpmath.pi
    return mpmath.matrix([[even, odd], [p * odd, even]])
