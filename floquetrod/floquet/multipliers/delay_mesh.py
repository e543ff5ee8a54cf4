"""Collocation of systems with delays over a period: nodes, integrals of polynomials, and where delayed values lie.

The highest derivative of a solution is a polynomial on every piece of the period, given by its values at Gauss's
nodes; its integrals are the solution.  Of these, the next periods need the values at Chebyshev's points of the pieces
that delays reach back to, and the state at the end.  Time is counted in periods.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.interpolation import chebyshev_points, chebyshev_weights


class DelayRows(NamedTuple):
    """Rows that give the values delayed by one delay at the nodes."""

    now: Floats  # (F, F), rows over the unknowns of this period
    now_state: Floats  # (F, r), rows over the state at its beginning
    past: Floats  # (F, k H), rows over the values kept of the last k periods, the last one first


class Mesh(NamedTuple):
    """Rows, of one equation, over F values of the highest derivative and the r parts of the state at the beginning."""

    nodes: Floats  # (F,), Gauss's nodes, as parts of the period
    value: Floats  # (F, F), the solution at the nodes
    value_state: Floats  # (F, r)
    rate: Floats  # (F, F), its first derivative there, where equations are of second order
    rate_state: Floats  # (F, r)
    delays: tuple[DelayRows, ...]  # of each delay
    end: Floats  # (r + H, F), the state at the end of the period and the values kept
    end_state: Floats  # (r + H, r)
    periods: int  # how many periods back delays reach, 1 or more
    breaks: tuple[float, ...]  # ends of the pieces
    kept: tuple[int, ...]  # the pieces whose values are kept

    @property
    def size(self) -> int:
        """Rows of the map over a period, of one equation."""
        kept = len(self.end) - self.value_state.shape[1]
        return int(self.value_state.shape[1] + self.periods * kept)


class Source(NamedTuple):
    """Where delayed values at nodes of a piece come from: a piece of this period, or the values kept."""

    delay: int  # its number
    nodes: NDArray[np.intp]  # (k,), within the piece
    piece: int | None  # of this period; None where they come from earlier ones
    rows: Floats  # (k, r + N) over the first state of that piece and its unknowns, or (k, H) over values kept


class PieceMesh(NamedTuple):
    """Rows, of one equation, over the state at the beginning of each of P pieces and the unknowns at its N nodes."""

    nodes: Floats  # (P N,), Gauss's nodes, as parts of the period
    value: Floats  # (P, N, r + N), the solution at the nodes
    rate: Floats  # (P, N, r + N), its first derivative there, where equations are of second order
    end: Floats  # (P, r, r + N), the state at the end of the piece
    sources: tuple[tuple[Source, ...], ...]  # of each piece
    kept_values: Floats  # (kept pieces, N + r, r + N), the values kept of a piece
    periods: int  # how many periods back delays reach, 1 or more
    breaks: tuple[float, ...]  # ends of the pieces
    kept: tuple[int, ...]  # the pieces whose values are kept

    @property
    def size(self) -> int:
        """Rows of the map over a period, of one equation."""
        return int(self.end.shape[1] + self.periods * self.kept_values.shape[0] * self.kept_values.shape[1])


@functools.lru_cache(maxsize=64)
def rule(count: int) -> tuple[Floats, Floats]:
    """Return Gauss's nodes from -1 to 1 and the matrix from values there to coefficients of Legendre's polynomials."""
    nodes, weights = legendre.leggauss(count)
    values = legendre.legvander(nodes, count - 1) * weights[:, None]
    return nodes, values.T * (np.arange(count) + 0.5)[:, None]


def integral(count: int, at: Floats, times: int) -> Floats:
    """Return rows, over values at ``count`` nodes, of the interpolant integrated from -1 ``times`` times."""
    coefficients = _integrated(count, times)
    return np.asarray(legendre.legvander(at, len(coefficients) - 1) @ coefficients)


@functools.lru_cache(maxsize=128)
def _integrated(count: int, times: int) -> Floats:
    """Return the matrix from values at nodes to coefficients of the interpolant integrated from -1 ``times`` times."""
    coefficients: NDArray[Any] = rule(count)[1]
    for _ in range(times):
        coefficients = legendre.legint(coefficients, lbnd=-1, axis=0)
    return np.asarray(coefficients)


class _Collocation(NamedTuple):
    """Pieces of the period with as many nodes each, and the states at their beginnings as rows (P + 1, 2, F)."""

    breaks: Floats
    nodes: int
    derivatives: int
    starts: Floats

    def place(self, t: Floats) -> NDArray[np.intp]:
        """Return the pieces that times lie in."""
        return np.clip(np.searchsorted(self.breaks, t, side="right") - 1, 0, len(self.breaks) - 2)

    def rows(self, t: Floats, piece: NDArray[np.intp], rate: bool = False) -> tuple[Floats, Floats]:
        """Return the solution at times of pieces, or its rate, as rows over the unknowns and over the state."""
        length = np.diff(self.breaks)[piece]
        into = t - self.breaks[piece]
        times = 1 if rate else self.derivatives
        rows = self.starts[piece, int(rate)].copy()
        if times == 2:
            rows += into[:, None] * self.starts[piece, 1]
        own = integral(self.nodes, 2.0 * into / length - 1.0, times) * ((0.5 * length) ** times)[:, None]
        rows.reshape(len(t), -1, self.nodes)[np.arange(len(t)), piece] += own
        state = np.ones((len(t), self.derivatives))
        if self.derivatives == 2:
            state[:, 0], state[:, 1] = (0.0, 1.0) if rate else (1.0, t)
        return rows, state


def _collocation(breaks: Floats, count: int, derivatives: int) -> _Collocation:
    total = len(breaks) - 1
    starts = np.zeros((total + 1, 2, total * count))
    once, twice = (integral(count, np.array([1.0]), times)[0] for times in (1, 2))
    for p, length in enumerate(np.diff(breaks).tolist()):
        starts[p + 1] = starts[p]
        own = slice(p * count, (p + 1) * count)
        if derivatives == 2:
            starts[p + 1, 0] += length * starts[p, 1]
            starts[p + 1, 0, own] += (0.5 * length) ** 2 * twice
            starts[p + 1, 1, own] += 0.5 * length * once
        else:
            starts[p + 1, 0, own] += 0.5 * length * once
    return _Collocation(breaks, count, derivatives, starts)


@functools.lru_cache(maxsize=16)
def mesh(
    breaks: tuple[float, ...],
    count: int,
    derivatives: int,
    delays: tuple[float, ...],
    active: tuple[tuple[bool, ...], ...],
) -> Mesh:
    """Return the rows of a mesh.

    Parameters
    ----------
    breaks : tuple of float
        Ends of the pieces as parts of the period, from 0 to 1.
    count : int
        Nodes in each piece.
    derivatives : int
        Order of the equations, 1 or 2.
    delays : tuple of float
        Delays as parts of the period.
    active : tuple of tuple of bool
        Of each delay, on which pieces its term is not zero.
    """
    pieces, period = _one_period(breaks, count, derivatives)
    own = np.repeat(np.arange(len(breaks) - 1), count)
    where = [np.asarray(on)[own] for on in active]
    sources = [_source(pieces, period.nodes, delay, on) for delay, on in zip(delays, where, strict=True)]
    touched, periods = _reached(sources)
    kept = count + derivatives
    rows = tuple(_delayed(pieces, source, touched, kept, periods) for source in sources)
    end, end_state = _end(pieces, touched, kept)
    return Mesh(*period[:5], rows, end, end_state, periods, breaks, tuple(touched))


class PeriodRows(NamedTuple):
    """As of a `Mesh` the rows of one period, without a history: ``end`` of its state alone."""

    nodes: Floats
    value: Floats
    value_state: Floats
    rate: Floats
    rate_state: Floats
    end: Floats  # (r, F)
    end_state: Floats  # (r, r)


class EarlierRows(NamedTuple):
    """The solution at the nodes less a delay, moved into the period, as rows."""

    periods: NDArray[np.intp]  # (F,), by which it was moved
    active: Bools  # (F,), where the delayed term is not zero
    value: Floats  # (F, F)
    state: Floats  # (F, r)


def _one_period(breaks: tuple[float, ...], count: int, derivatives: int) -> tuple[_Collocation, PeriodRows]:
    pieces = _collocation(np.asarray(breaks), count, derivatives)
    length = np.diff(pieces.breaks)
    nodes = (pieces.breaks[:-1, None] + length[:, None] * 0.5 * (rule(count)[0] + 1.0)).ravel()
    own = np.repeat(np.arange(len(length)), count)
    value, value_state = pieces.rows(nodes, own)
    rate, rate_state = pieces.rows(nodes, own, rate=True) if derivatives == 2 else (value, value_state)
    return pieces, PeriodRows(nodes, value, value_state, rate, rate_state, *_end(pieces, [], 0))


def one_period(
    breaks: tuple[float, ...],
    count: int,
    derivatives: int,
    delays: tuple[float, ...],
    active: tuple[tuple[bool, ...], ...],
) -> tuple[PeriodRows, list[EarlierRows]]:
    """Return the rows of a period and, of each delay, where it reads within this period; arguments as of `mesh`."""
    pieces, period = _one_period(breaks, count, derivatives)
    own = np.repeat(np.arange(len(breaks) - 1), count)
    earlier = []
    for delay, on in zip(delays, active, strict=True):
        there, turn, piece, here = _source(pieces, period.nodes, delay, np.asarray(on)[own])
        earlier.append(EarlierRows(turn, here, *pieces.rows(there, piece)))
    return period, earlier


@functools.lru_cache(maxsize=16)
def piece_mesh(
    breaks: tuple[float, ...],
    count: int,
    derivatives: int,
    delays: tuple[float, ...],
    active: tuple[tuple[bool, ...], ...],
) -> PieceMesh:
    """Return the rows of a mesh of many pieces, see `mesh`."""
    edges, kept = np.asarray(breaks), count + derivatives
    pieces = _Collocation(edges, count, derivatives, np.empty((len(edges), 2, 0)))
    length, gauss = np.diff(edges), rule(count)[0]
    nodes = (edges[:-1, None] + length[:, None] * 0.5 * (gauss + 1.0)).ravel()
    own = np.repeat(np.arange(len(length)), count)
    sources = [_source(pieces, nodes, delay, np.asarray(on)[own]) for delay, on in zip(delays, active, strict=True)]
    touched, periods = _reached(sources)
    chebyshev, one = chebyshev_points(kept), np.array([1.0])

    def rows(x: Floats, rate: bool = False) -> Floats:
        return np.stack([_rows_within(float(part), count, derivatives, x, rate=rate) for part in length])

    ends = [rows(one, bool(order)) for order in range(derivatives)]
    return PieceMesh(
        nodes,
        rows(gauss),
        rows(gauss, derivatives == 2),
        np.concatenate(ends, axis=1),
        tuple(tuple(_sources_of(pieces, sources, touched, p, periods)) for p in range(len(length))),
        rows(chebyshev)[touched],
        periods,
        breaks,
        tuple(touched),
    )


def _rows_within(length: float, count: int, derivatives: int, x: Floats, *, rate: bool = False) -> Floats:
    """Return the solution at places -1 to 1 of a piece, or its rate, as rows over its first state and unknowns."""
    times = 1 if rate else derivatives
    state = np.ones((len(x), derivatives))
    if derivatives == 2:
        state[:, 0], state[:, 1] = (0.0, 1.0) if rate else (1.0, 0.5 * length * (x + 1.0))
    return np.concatenate([state, (0.5 * length) ** times * integral(count, x, times)], axis=1)


def _sources_of(
    pieces: _Collocation, sources: list[_Source], touched: list[int], p: int, periods: int
) -> Iterator[Source]:
    """Yield where the delayed values at the nodes of piece ``p`` come from."""
    kept, length = pieces.nodes + pieces.derivatives, np.diff(pieces.breaks)
    own = slice(p * pieces.nodes, (p + 1) * pieces.nodes)
    for delay, source in enumerate(sources):
        there, turn, piece, on = source[0][own], source[1][own], source[2][own], source[3][own]
        for q in np.unique(piece[on & (turn == 0)]).tolist():
            some = np.flatnonzero(on & (turn == 0) & (piece == q))
            x = 2.0 * (there[some] - pieces.breaks[q]) / length[q] - 1.0
            yield Source(delay, some, q, _rows_within(float(length[q]), pieces.nodes, pieces.derivatives, x))
        before = np.flatnonzero(on & (turn > 0))
        if before.size:
            yield Source(delay, before, None, _past_rows(pieces, source, touched, kept, periods)[own][before])


def _reached(sources: list[_Source]) -> tuple[list[int], int]:
    """Return the pieces whose values are kept, and how many periods back they are needed."""
    touched = sorted({int(p) for _, turn, piece, on in sources for p in piece[on & (turn > 0)]})
    return touched, max([1, *(int(turn[on].max(initial=1)) for _, turn, _, on in sources)])


_Source = tuple[Floats, NDArray[np.intp], NDArray[np.intp], Bools]


def _source(pieces: _Collocation, nodes: Floats, delay: float, on: Bools) -> _Source:
    """Return the instants t - delay within their periods, how many periods back, their pieces, and where in use."""
    earlier = nodes - delay
    turn = np.where(earlier < 0.0, np.ceil(-earlier), 0.0).astype(np.intp)
    there = earlier + turn
    return there, turn, pieces.place(there), on


def _delayed(pieces: _Collocation, source: _Source, touched: list[int], kept: int, periods: int) -> DelayRows:
    there, turn, piece, on = source
    now = on & (turn == 0)
    value, state = pieces.rows(there, piece)
    return DelayRows(value * now[:, None], state * now[:, None], _past_rows(pieces, source, touched, kept, periods))


def _past_rows(pieces: _Collocation, source: _Source, touched: list[int], kept: int, periods: int) -> Floats:
    """Return the delayed values that come from earlier periods as rows over the values kept."""
    there, turn, piece, on = source
    before = np.flatnonzero(on & (turn > 0))
    past = np.zeros((len(there), periods, len(touched), kept))
    column = np.searchsorted(touched, piece[before])
    length = np.diff(pieces.breaks)[piece[before]]
    weights = chebyshev_weights(kept, 2.0 * (there[before] - pieces.breaks[piece[before]]) / length - 1.0)
    past[before, turn[before] - 1, column] = weights
    return past.reshape(len(there), -1)


def _end(pieces: _Collocation, touched: list[int], kept: int) -> tuple[Floats, Floats]:
    """Return the rows of the state at the end and of the values kept."""
    last, end = np.array([len(pieces.breaks) - 2]), np.array([1.0])
    ends = [pieces.rows(end, last, rate=bool(order)) for order in range(pieces.derivatives)]
    length = np.diff(pieces.breaks)
    for p in touched:
        t = pieces.breaks[p] + length[p] * 0.5 * (chebyshev_points(kept) + 1.0)
        ends.append(pieces.rows(t, np.full(kept, p)))
    return np.concatenate([rows for rows, _ in ends]), np.concatenate([state for _, state in ends])
