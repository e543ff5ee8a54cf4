"""The map over one period, enclosed: Taylor series over equal steps, all steps at a time, their product as a tree.

The unit of time is the period.  What the series leave out is bounded by `precise_maps.last_power`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod.floquet.proof.intervals import TooMuchWork, Unresolved
from floquetrod.floquet.proof.system_problem import Arithmetic, Flow, Matrix, row_sum
from floquetrod.floquet.systems.precise_maps import last_power

Array = Any

_MOST_STEPS = 2**14
_MOST_NUMBERS = 2**25  # of the terms of all series, held at once: half a gigabyte in balls of doubles (a choice)
_STEP = 1.2  # growth exponent of a step, about the cheapest with 15 digits (measured)
_LONGEST_STEP = 6.0


def monodromy(arithmetic: Arithmetic, flow: Flow) -> Matrix:
    """Enclose the matrix that maps a solution over one period."""
    sizes = [row_sum(flow.mean)]
    sizes += [row_sum(c) + row_sum(s) for c, s in zip(flow.cosines, flow.sines, strict=True)]
    total = sum(sizes)
    step = min(_STEP * arithmetic.digits / 15.0, _LONGEST_STEP)
    if not total < step * _MOST_STEPS:
        raise TooMuchWork("so many steps of a period")
    steps = 2 ** max(0, math.ceil(math.log2(max(total, 1e-300) / step)), math.ceil(math.log2(2.0 * len(sizes))))
    waves = np.array([2.0 * math.pi * k for k in range(len(sizes))])
    found = last_power(np.array(sizes), waves, 1.0 / steps, -math.log(10.0) * (arithmetic.digits + 2.0))
    if found is None:
        raise Unresolved("the Taylor series converge too slowly")
    order, remainder = found[0], max(math.exp(found[1]), 1e-290)
    entries = steps * flow.mean.shape[0] ** 2
    if entries * order > _MOST_NUMBERS:
        raise TooMuchWork("so large Taylor series")
    arithmetic.check_work(entries * order * (flow.mean.shape[0] * (2.0 * len(sizes) - 1.0) + order * len(flow.cosines)))
    taylor = _taylor_sums(arithmetic, flow, steps, order)
    if flow.error:  # Gronwall: a map over the step h changes by at most exp(a h) (exp(error h) - 1)
        remainder += float(np.exp(total / steps) * np.expm1(flow.error / steps)) * (1.0 + 1e-10)
    maps = taylor.widened(np.full(taylor.shape, remainder))
    while maps.shape[0] > 1:
        maps = maps[1::2] @ maps[0::2]
    return maps[0]


def _taylor_sums(arithmetic: Arithmetic, flow: Flow, steps: int, order: int) -> Matrix:
    """Return the sums of the Taylor series of the maps over each step, (steps, n, n).

    A product of A(t) with a solution needs, of the wave k, the solution times cos(2 pi k t) and sin(2 pi k t), t from
    the step's beginning: their Taylor coefficients are sums with weights (2 pi k h)^l / l!.
    """
    size = flow.mean.shape[0]
    rows = [_repeated(flow.mean, steps)]
    for k, (cosine, sine) in enumerate(zip(flow.cosines, flow.sines, strict=True), 1):
        turned = (k * np.arange(steps)) % steps / steps
        c, s = (part[:, None, None] for part in arithmetic.turns(np.where(turned > 0.5, turned - 1.0, turned)))
        rows += [cosine * c + sine * s, sine * c - cosine * s]
    matrix = arithmetic.join(rows, 2).shifted(1.0 / steps)
    weights = _weights(arithmetic, len(flow.cosines), steps, order)
    terms = arithmetic.zeros((order + 1, steps * size * size), real=True)
    terms[0] = _repeated(arithmetic.exact(np.eye(size)), steps).each(np.ravel)
    for m in range(order):
        columns = [terms[m].each(lambda a: a.reshape(steps, size, size))]
        if flow.cosines:
            known = terms[: m + 1].each(lambda a: a[::-1])
            products = (weights[:, : m + 1] @ known).each(lambda a: a.reshape(-1, steps, size, size))
            columns += [products[i] for i in range(products.shape[0])]
        terms[m + 1] = (matrix @ arithmetic.join(columns, 1)).over(m + 1).each(np.ravel)
    return terms.each(lambda a: a[::-1]).sum(0).each(lambda a: a.reshape(steps, size, size))


def _weights(arithmetic: Arithmetic, waves: int, steps: int, order: int) -> Matrix:
    """Return the Taylor coefficients of cos(2 pi k h s) and sin(2 pi k h s), two rows for each k."""
    weights = arithmetic.zeros((2 * waves, order + 1), real=True)
    for k in range(1, waves + 1):
        angle = (arithmetic.two_pi() * arithmetic.exact(np.array(float(k)))).shifted(1.0 / steps)
        term = arithmetic.exact(np.array(1.0))
        for power in range(order + 1):
            weights[2 * (k - 1) + power % 2, power] = term if power % 4 < 2 else -term
            term = (term * angle).over(power + 1)
    return weights


def _repeated(matrix: Matrix, times: int) -> Matrix:
    return matrix.each(lambda a: np.repeat(a[None], times, 0))
