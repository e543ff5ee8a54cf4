"""A period of the motion against friction, cut into cells: made once for an equation, of many equations at a time.

By homogeneity gamma = 1.  docs/friction.md derives the escape test and the proved kicks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import over_chunks
from floquetrod._util.roots import bisected
from floquetrod.kernels import friction as kernels
from floquetrod.kernels import frictional_escape as escape
from floquetrod.kernels.frictional_cell import CELL_WAVE, TERMS, at_the_end, series, slope, value

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_FEWEST_CELLS = 32  # a period
_BLOCK = 8192  # cells at a time (measured: fastest; some 6 MB)
_INTERPRETED_CELLS = 20_000  # whose rows are made without compiling: a tenth of a second each time (measured)
_HALVINGS = 45  # of a cell in search of the time of a stop, to far less than `_ROUNDED`
_FEW_HALVINGS = 27  # in search of a zero of psi, whose square is below rounding in the integral
_STEEP = 1e12  # a slope beyond which the kick that stops is at its limit, to rounding
_LONGEST_PUSH = 8.0 * math.pi  # how long first stops are followed (a choice: a shorter time gives a lower bound)
_ROUNDED = 1e-12  # relative: a proved kick is lowered by it, far more than its error of rounding (measured)


class Propagators(NamedTuple):
    """Cells of equations, one equation after the other.

    Attributes
    ----------
    first : ndarray
        Where the cells of each equation begin, and the number of all.
    tables : ndarray, shape (cells, 11)
        The matrix and the forcing of (A, A') over a cell for s = 1; bounds on what A = 1, A' = 1 and the forcing change
        in A' anywhere in it; the row (e1, e2) of the escape test abs(e1 A + e2 A') > 1 at its beginning.
    bases : ndarray, shape (cells, 3, 18)
        The Taylor series of A from A = 1, from A' = 1 and of the forced motion, in the cell's length.
    ceiling : ndarray
        Proved: every kick above it escapes; infinite where no such kick is known.
    """

    first: Integers
    tables: Floats
    bases: Floats
    ceiling: Floats


def cell_counts(alpha: Floats, beta: Floats, damping: Floats) -> Integers:
    """Return the number of cells of a period: short against every wave."""
    wave = np.maximum(np.sqrt(np.abs(alpha) + np.abs(beta)), 2.0 * damping)
    counts: Integers = np.maximum(_FEWEST_CELLS, (2.0 * math.pi * wave / CELL_WAVE).astype(np.int64) + 1)
    return counts


def propagators(alpha: Floats, beta: Floats, damping: Floats, rate: Floats, workers: int | None) -> Propagators:
    """Return the cells of equations; ``rate`` is the growth of each, damping included, zero where it is not known."""
    counts = cell_counts(alpha, beta, damping)
    first = np.append(0, np.cumsum(counts))
    tables, bases = np.zeros((first[-1], kernels.COLUMNS)), np.empty((first[-1], 3, TERMS))
    of = np.repeat(np.arange(alpha.size), counts)
    tau = (np.arange(first[-1]) - first[of]) * (2.0 * math.pi / counts[of])
    h, sine, cosine = 2.0 * math.pi / counts[of], alpha[of] * np.sin(tau), alpha[of] * np.cos(tau)
    for block in range(0, of.size, _BLOCK):
        part = slice(block, block + _BLOCK)
        where = of[part]
        _fill_cells(sine[part], cosine[part], beta[where], damping[where], h[part], tables[part], bases[part])
    ceiling = np.full(alpha.size, math.inf)
    grows = np.flatnonzero(rate > 0.0)
    if grows.size:
        few = _INTERPRETED_CELLS // int(counts.max())
        begin, end, vectors, sizes = first[:-1][grows], first[1:][grows], np.zeros((of.size, 3)), np.empty(of.size)
        shrink, reach = np.empty(grows.size), np.empty(grows.size)
        inputs = (begin, end, damping[grows], rate[grows])
        over_chunks(
            escape.vectors_fill, inputs, shrink, tables, vectors, workers=workers, chunk=64, interpret_up_to=few
        )
        for block in range(0, of.size, _BLOCK):
            part = slice(block, block + _BLOCK)
            sizes[part] = _sizes(sine[part], cosine[part], beta[of[part]], damping[of[part]], h[part], vectors[part])
        ends = (begin, end, shrink)
        over_chunks(
            escape.rows_fill, ends, reach, vectors, sizes, tables, workers=workers, chunk=64, interpret_up_to=few
        )
        ceiling[grows] = reach
    return Propagators(first, tables, bases, ceiling)


def _fill_cells(
    sine: Floats, cosine: Floats, beta: Floats, damping: Floats, h: Floats, tables: Floats, bases: Floats
) -> None:
    """Fill the first nine columns of ``tables``, and ``bases``, with one cell each."""
    p, a = np.empty((TERMS, h.size)), np.empty((TERMS, h.size))
    steps = np.arange(TERMS)[:, None]
    for column, (a0, a1, s) in enumerate(((1.0, 0.0, 0.0), (0.0, h, 0.0), (0.0, 0.0, 1.0))):
        series(sine, cosine, beta, damping, s, h, a0, a1, p, a)
        bases[:, column] = a.T
        end, start = (4, 5) if column == 2 else (column, 2 + column)
        tables[:, end], rate = at_the_end(a)
        tables[:, start] = rate / h
        tables[:, 6 + column] = (steps[2:] * np.abs(a[2:])).sum(axis=0) / h


def _sizes(sine: Floats, cosine: Floats, beta: Floats, damping: Floats, h: Floats, vectors: Floats) -> Floats:
    """Return the integral of abs(psi) over each cell, psi the solution that the left vector at its beginning is of."""
    p, a = np.empty((TERMS, h.size)), np.empty((TERMS, h.size))
    l1, l2 = vectors[:, 0], vectors[:, 1]
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


def no_kick_escapes_up_to(alpha: Floats, beta: Floats, cells: Propagators) -> Floats:
    """Return a kick up to which none escapes: none of these stops first beyond ``safe``, where a stop is kept.

    Up to the first stop A = kick S + F, S and F the motions from A' = 1 without friction and from rest with it; the
    kick g = -F' / S' stops at tau, at A = g S + F.  Both grow with tau until A is ``safe`` (docs/friction.md), and the
    kick that stops there is returned, or that of the time where S' is so steep that g has its limit to rounding.
    """
    outward = beta + np.abs(alpha)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        safe = 2.0 / np.abs(alpha)
        safe = np.where(outward > 0.0, np.minimum(safe, 1.0 / outward), safe)
        best = 1.0 / np.sqrt(np.abs(alpha) + np.abs(beta))  # by comparison with the largest force throughout
        counts = np.diff(cells.first)
        active = np.flatnonzero(np.isfinite(best))
        s0, s1, f0, f1 = np.zeros(best.size), np.ones(best.size), np.zeros(best.size), np.zeros(best.size)
        k = 0
        while active.size:
            i, cell = active, cells.first[active] + k % counts[active]
            m11, m12, m21, m22, g0, g1 = cells.tables[cell, :6].T
            t0, t1 = m11 * s0[i] + m12 * s1[i], m21 * s0[i] + m22 * s1[i]
            r0, r1 = m11 * f0[i] + m12 * f1[i] + g0, m21 * f0[i] + m22 * f1[i] + g1
            beyond = t1 * (safe[i] - r0) + t0 * r1 <= 0.0  # the kick that stops here stops beyond ``safe``
            j, within = i[beyond], i[~beyond]
            if j.size:
                s = _motion(cells.bases[cell[beyond]], s0[j], s1[j], 0.0)
                f = _motion(cells.bases[cell[beyond]], f0[j], f1[j], 1.0)
                best[j] = np.maximum(best[j], _kick_that_stops_at(safe[j], s, f))
            s0[i], s1[i], f0[i], f1[i] = t0, t1, r0, r1
            best[within] = np.maximum(best[within], -f1[within] / s1[within])
            k += 1
            active = within[(s1[within] < _STEEP) & (k * 2.0 * math.pi / counts[within] < _LONGEST_PUSH)]
    bound: Floats = best * (1.0 - _ROUNDED)
    return bound


def _motion(bases: Floats, a: Floats, velocity: Floats, s: float) -> Floats:
    """Return the series of motions in a cell each, from A = a and A' = velocity at its beginning."""
    whole: Floats = (a[:, None] * bases[:, 0] + velocity[:, None] * bases[:, 1] + s * bases[:, 2]).T
    return whole


def _kick_that_stops_at(safe: Floats, s: Floats, f: Floats) -> Floats:
    """Return the kick -F' / S' of the time in the cell at which the kick that stops there stops at ``safe``."""

    def before(x: Floats) -> NDArray[np.bool_]:
        stops: Floats = slope(s, x) * (safe - value(f, x)) + value(s, x) * slope(f, x)
        return ~(stops <= 0.0)  # NaN too

    low, _ = bisected(before, np.zeros(safe.size), np.ones(safe.size), _HALVINGS)
    return np.where(low > 0.0, -slope(f, low) / slope(s, low), 0.0)
