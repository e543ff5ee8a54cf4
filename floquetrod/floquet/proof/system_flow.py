"""The map over one period, enclosed: Taylor series over equal steps, all steps at a time, their product as a tree.

The unit of time is the period.  What the series leave out is bounded by `precise_maps.last_power`.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from floquetrod.floquet.multipliers.precise_maps import last_power
from floquetrod.floquet.proof.balls import Array
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved
from floquetrod.floquet.proof.system_problem import Arithmetic, BallPiece, Flow, Matrix, row_sum

_MOST_STEPS = 2**14
_MOST_NUMBERS = 2**25  # of the terms of all series, held at once: half a gigabyte in balls of doubles (a choice)
_STEP = 1.2  # growth exponent of a step, about the cheapest with 15 digits (measured)
_LONGEST_STEP = 6.0


def monodromy(arithmetic: Arithmetic, flow: Flow) -> Matrix:
    """Enclose the matrix that maps a solution over one period."""
    maps = [_piece_map(arithmetic, piece) for piece in flow.pieces]
    total = maps[0]
    for matrix in maps[1:]:
        total = matrix @ total
    return total


def _piece_map(arithmetic: Arithmetic, piece: BallPiece) -> Matrix:
    """Enclose the matrix that maps a solution over a piece, whose length is the unit of time from here on."""
    length = float(piece.length)
    if piece.length != 1:
        factor = arithmetic.rational(piece.length)
        piece = piece.each(lambda m: m * factor, lambda m: m * factor)
        piece = piece._replace(slope=None if piece.slope is None else piece.slope * factor)
    waves = [wave.parts() for wave in piece.waves]
    steepness = 0.0 if piece.slope is None else row_sum(piece.slope)
    sizes = np.array([row_sum(piece.mean) + steepness, *(row_sum(c) + row_sum(s) for c, s in waves)])
    total = float(sizes.sum())
    step = min(_STEP * arithmetic.digits / 15.0, _LONGEST_STEP)
    if not total < step * _MOST_STEPS:
        raise TooMuchWork("so many steps of a period")
    turning = max(2.0 * len(sizes) * length, 1.0)
    steps = 2 ** max(0, math.ceil(math.log2(max(total, 1e-300) / step)), math.ceil(math.log2(turning)))
    rates = np.array([2.0 * math.pi * k * length * (1.0 + 1e-15) for k in range(len(sizes))])
    truncation = last_power(sizes, rates, 1.0 / steps, -math.log(10.0) * (arithmetic.digits + 2.0), steepness)
    if truncation is None:
        raise Unresolved("the Taylor series converge too slowly")
    order, remainder = truncation[0], max(math.exp(truncation[1]), 1e-290)
    entries = steps * piece.mean.shape[0] ** 2
    if entries * order > _MOST_NUMBERS:
        raise TooMuchWork("so large Taylor series")
    blocks = 2.0 * len(sizes) - (1.0 if piece.slope is None else 0.0)
    arithmetic.check_work(entries * order * (piece.mean.shape[0] * blocks + order * len(waves)))
    taylor = _taylor_sums(arithmetic, piece, steps, order)
    maps = taylor.widened(np.full(taylor.shape, remainder))
    while maps.shape[0] > 1:
        maps = maps[1::2] @ maps[0::2]
    return maps[0]


def _taylor_sums(arithmetic: Arithmetic, piece: BallPiece, steps: int, order: int) -> Matrix:
    """Return the sums of the Taylor series of the maps over each step of a piece, (steps, n, n).

    A product of A(t) with a solution needs, of the wave k, the solution times cos(2 pi k t) and sin(2 pi k t), t from
    the step's beginning: their Taylor coefficients are sums with weights (2 pi k h)^l / l!.  Of the slope it needs the
    solution times t: the coefficient before.
    """
    size = piece.mean.shape[0]
    rows = [_means(arithmetic, piece, steps)]
    for k, wave in enumerate(piece.waves, 1):
        cosine, sine = wave.parts()[0], -wave.parts()[1]
        c, s = (part[:, None, None] for part in arithmetic.turns(_turned(piece, k, steps)))
        rows += [cosine * c + sine * s, sine * c - cosine * s]
    if piece.slope is not None:
        rows.append(_repeated(piece.slope.shifted(1.0 / steps), steps))
    matrix = arithmetic.join(rows, 2).shifted(1.0 / steps)
    weights = _weights(arithmetic, piece, steps, order)
    terms = arithmetic.zeros((order + 1, steps * size * size), real=True)
    terms[0] = _repeated(arithmetic.exact(np.eye(size)), steps).each(np.ravel)
    for m in range(order):
        columns = [terms[m].each(lambda a: a.reshape(steps, size, size))]
        if piece.waves:
            known = terms[: m + 1].each(lambda a: a[::-1])
            products = (weights[:, : m + 1] @ known).each(lambda a: a.reshape(-1, steps, size, size))
            columns += [products[i] for i in range(products.shape[0])]
        if piece.slope is not None:
            before = terms[m - 1] if m else arithmetic.zeros((steps * size * size,), real=True)
            columns.append(before.each(lambda a: a.reshape(steps, size, size)))
        terms[m + 1] = (matrix @ arithmetic.join(columns, 1)).over(m + 1).each(np.ravel)
    return terms.each(lambda a: a[::-1]).sum(0).each(lambda a: a.reshape(steps, size, size))


def _means(arithmetic: Arithmetic, piece: BallPiece, steps: int) -> Matrix:
    """Return the mean, and what the slope has added, at the beginning of each step."""
    means = _repeated(piece.mean, steps)
    if piece.slope is None:
        return means
    return means + piece.slope * arithmetic.exact(np.arange(steps) / steps)[:, None, None]


def _turned(piece: BallPiece, k: int, steps: int) -> Array:
    """Return by which part of a turn, from -1/2 to 1/2, wave k has turned at the beginning of each step."""
    if piece.begin == 0 and piece.length == 1:
        turned = (k * np.arange(steps)) % steps / steps
        return np.where(turned > 0.5, turned - 1.0, turned)
    exact = [k * (piece.begin + piece.length * step / steps) % 1 for step in range(steps)]
    return np.array([turn - (turn > Fraction(1, 2)) for turn in exact], dtype=object)


def _weights(arithmetic: Arithmetic, piece: BallPiece, steps: int, order: int) -> Matrix:
    """Return the Taylor coefficients of cos(2 pi k h s) and sin(2 pi k h s), two rows for each k."""
    weights = arithmetic.zeros((2 * len(piece.waves), order + 1), real=True)
    for k in range(1, len(piece.waves) + 1):
        angle = (arithmetic.two_pi() * arithmetic.rational(k * piece.length)).shifted(1.0 / steps)
        term = arithmetic.exact(np.array(1.0))
        for power in range(order + 1):
            weights[2 * (k - 1) + power % 2, power] = term if power % 4 < 2 else -term
            term = (term * angle).over(power + 1)
    return weights


def _repeated(matrix: Matrix, times: int) -> Matrix:
    return matrix.each(lambda a: np.repeat(a[None], times, 0))
