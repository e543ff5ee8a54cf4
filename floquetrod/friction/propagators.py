"""A period of the motion against friction, divided into cells: made once for an equation, of many at a time.

By homogeneity gamma = 1.  The page `theory/friction` derives the escape test and the proved kicks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.compilation import over_chunks
from floquetrod._util.roots import bisected
from floquetrod.friction.kernels import escape as escape
from floquetrod.friction.kernels.cell import CELL_WAVE, TERMS, at_the_end, series, value
from floquetrod.friction.kernels.records import BASIS, CELL, LEFT_VECTOR, PERIOD

Records = NDArray[np.void]

_FEWEST_CELLS = 32  # a period
_BLOCK = 8192  # cells at a time (measured: fastest; some 6 MB)
_INTERPRETED_CELLS = 20_000  # whose rows are made without compiling: a tenth of a second each time (measured)
_FEW_HALVINGS = 27  # in search of a zero of psi, whose square is below rounding in the integral


class Propagators(NamedTuple):
    """Cells of equations, one equation after the other."""

    first: Ints  # where the cells of each equation begin, and the number of all
    cells: Records  # of `CELL`: propagators, bounds and escape tests
    bases: Records  # of `BASIS`: the Taylor series they come from
    ceiling: Floats  # proved: every kick above it escapes; infinite where no such kick is known


def cell_counts(alpha: Floats, beta: Floats, damping: Floats) -> Ints:
    """Return the number of cells of a period: short against every wave."""
    wave = np.maximum(np.sqrt(np.abs(alpha) + np.abs(beta)), 2.0 * damping)
    counts: Ints = np.maximum(_FEWEST_CELLS, (2.0 * math.pi * wave / CELL_WAVE).astype(np.int64) + 1)
    return counts


def propagators(alpha: Floats, beta: Floats, damping: Floats, rate: Floats, workers: int | None) -> Propagators:
    """Return the cells of equations; ``rate`` is the growth of each, damping included, zero where it is not known."""
    # The cells of all equations lie in one line, those of equation e from first[e] to first[e + 1], each of h = 2 pi /
    # count: tau is where a cell begins, sine and cosine are alpha sin tau and alpha cos tau there.  Three passes, each
    # needing the one before: propagators by Taylor series (all equations); for growing equations the left vectors of
    # the adjoint equation, backwards through their cells; the integrals of abs(psi) over each cell, from these; and
    # then the escape tests, whose value at the beginning of the period is the kick above which all escape.
    counts = cell_counts(alpha, beta, damping)
    first = np.append(0, np.cumsum(counts))
    cells, bases = np.zeros(first[-1], CELL), np.empty(first[-1], BASIS)
    of = np.repeat(np.arange(alpha.size), counts)
    h = PERIOD / counts[of]
    tau = (np.arange(first[-1]) - first[of]) * h
    sine, cosine = alpha[of] * np.sin(tau), alpha[of] * np.cos(tau)
    for block in range(0, of.size, _BLOCK):
        part = slice(block, block + _BLOCK)
        where = of[part]
        _fill_cells(sine[part], cosine[part], beta[where], damping[where], h[part], cells[part], bases[part])
    ceiling = np.full(alpha.size, math.inf)
    grows = np.flatnonzero(rate > 0.0)
    if grows.size:
        few = _INTERPRETED_CELLS // int(counts.max())
        begin, end, vectors, sizes = (
            first[:-1][grows],
            first[1:][grows],
            np.zeros(of.size, LEFT_VECTOR),
            np.empty(of.size),
        )
        shrink, reach = np.empty(grows.size), np.empty(grows.size)
        inputs = (begin, end, damping[grows], rate[grows])
        over_chunks(escape.vectors_fill, inputs, shrink, cells, vectors, workers=workers, chunk=64, interpret_up_to=few)
        for block in range(0, of.size, _BLOCK):
            part = slice(block, block + _BLOCK)
            sizes[part] = _sizes(sine[part], cosine[part], beta[of[part]], damping[of[part]], h[part], vectors[part])
        ends = (begin, end, shrink)
        over_chunks(
            escape.escape_fill, ends, reach, vectors, sizes, cells, workers=workers, chunk=64, interpret_up_to=few
        )
        ceiling[grows] = reach
    return Propagators(first, cells, bases, ceiling)


def _fill_cells(
    sine: Floats, cosine: Floats, beta: Floats, damping: Floats, h: Floats, cells: Records, bases: Records
) -> None:
    """Fill ``bases``, and ``cells`` except for their escape tests."""
    p, a = np.empty((TERMS, h.size)), np.empty((TERMS, h.size))
    steps = np.arange(TERMS)[:, None]
    for basis, end, end_velocity, change, (a0, a1, s) in (
        ("from_a", "m11", "m21", "change_a", (1.0, 0.0, 0.0)),
        ("from_velocity", "m12", "m22", "change_velocity", (0.0, h, 0.0)),
        ("forced", "f1", "f2", "change_forced", (0.0, 0.0, 1.0)),
    ):
        series(sine, cosine, beta, damping, s, h, a0, a1, p, a)
        bases[basis] = a.T
        cells[end], rate = at_the_end(a)
        cells[end_velocity] = rate / h
        cells[change] = (steps[2:] * np.abs(a[2:])).sum(axis=0) / h


def _sizes(sine: Floats, cosine: Floats, beta: Floats, damping: Floats, h: Floats, vectors: Records) -> Floats:
    """Return the integral of abs(psi) over each cell, psi the solution that the left vector at its beginning is of."""
    p, a = np.empty((TERMS, h.size)), np.empty((TERMS, h.size))
    l1, l2 = vectors["l1"], vectors["l2"]
    series(sine, cosine, beta, -damping, 0.0, h, l2, (2.0 * damping * l2 - l1) * h, p, a)
    integral = a / np.arange(1.0, TERMS + 1.0)[:, None]  # of each term, up to x = 1
    whole = integral.sum(axis=0)
    result = np.abs(whole)
    crosses = np.flatnonzero((a[0] >= 0.0) != (value(a, 1.0) >= 0.0))  # at most once: cells are short
    if crosses.size:
        a, integral = a[:, crosses], integral[:, crosses]
        low, _ = bisected(
            lambda x: (value(a, x) >= 0.0) == (a[0] >= 0.0),
            np.zeros(crosses.size),
            np.ones(crosses.size),
            _FEW_HALVINGS,
        )
        part = low * value(integral, low)
        result[crosses] = np.abs(part) + np.abs(whole[crosses] - part)
    sizes: Floats = h * result
    return sizes
