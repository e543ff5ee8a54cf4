"""Maps over a period of systems with delays, many with one mesh at once."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.equations import DelaySystem, HillSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.floquet.multipliers.delay_mesh import Mesh, PieceMesh, mesh

_MOST_BREAKS = 10  # breaks beyond the jumps of coefficients, their images under delays (a choice)
_SMALLEST = 1e-12  # part of the period: breaks closer together than this are one
_PHASE = 12.0  # radians that solutions turn by in a piece, about (a choice)


class Coefficients(NamedTuple):
    """q^(r) = value q + rate q' + sum_j delayed[j] q(t - tau_j) at nodes, r = 1 or 2, of many systems; t in periods."""

    value: Floats  # (b, F, n, n)
    rate: Floats | None  # (b, F, n, n), None for r = 1, and without damping
    delayed: tuple[Floats, ...]  # (b, F, n, n) each


class PeriodPieces(NamedTuple):
    """The pieces of a map's period, for the mesh of a system."""

    period: float  # of the map
    breaks: tuple[float, ...]  # ends of pieces as parts of it
    active: tuple[tuple[bool, ...], ...]  # of each delay: on which pieces its term is not zero

    @property
    def longest(self) -> float:
        """The longest piece as part of the period."""
        return float(np.diff(self.breaks).max())

    def cut(self, count: int) -> PeriodPieces:
        """Return as many pieces of each."""
        parts = [np.linspace(low, high, count + 1)[:-1] for low, high in pairwise(self.breaks)]
        active = tuple(tuple(np.repeat(on, count).tolist()) for on in self.active)
        return self._replace(breaks=(*np.concatenate(parts).tolist(), 1.0), active=active)

    def smallest_modulus(self, system: DelaySystem, above: float) -> float:
        """Return the modulus over the map's period that ``above`` is over the longest delay, where that is longer."""
        return float(above ** min(1.0, self.period / max(system.longest_delay, self.period)))

    def delays(self, system: DelaySystem) -> tuple[float, ...]:
        """Return the delays as parts of the period."""
        return tuple(float(Fraction(delay) / Fraction(self.period)) for delay in system.delays)

    def mesh(self, system: DelaySystem, count: int) -> Mesh:
        """Return the mesh with ``count`` nodes in each piece."""
        return mesh(self.breaks, count, 2 if system.is_second_order else 1, self.delays(system), self.active)


def period_pieces(system: DelaySystem, jumps: set[Fraction] | None = None) -> PeriodPieces:
    """Return the pieces of a system: between the jumps of its coefficients and the images of these under delays.

    A jump at t bends the solution there, less so at t + tau, and less again with every further delay.  Where nothing
    varies the period is the longest delay, except for the solutions under a force, whose ``jumps``, parts of the
    period, may be none: then it is the system's own.
    """
    fixed = system.is_constant and bool(system.delayed) and jumps is None
    exact = max(Fraction(delay) for delay in system.delays) if fixed else by_pieces.exact_period(system.present)
    matrices = () if fixed else (system.present, *(term.coefficient for term in system.delayed))
    own = {piece.begin / exact for matrix in matrices if matrix.pieces for piece in by_pieces.in_time(matrix)}
    breaks = with_images(own | (jumps or set()), [Fraction(delay) / exact for delay in system.delays])
    edges = distinct(sorted(map(float, breaks | {Fraction(0)})))
    turn = rate(system) * float(exact)
    fine = [0.0]
    for low, high in pairwise(edges):
        fine += np.linspace(low, high, max(1, math.ceil((high - low) * turn / _PHASE)) + 1)[1:].tolist()
    middles = np.asarray([0.5 * (low + high) for low, high in pairwise(fine)]) * float(exact)
    active = tuple(tuple(presence(term.coefficient, middles)) for term in system.delayed)
    return PeriodPieces(float(exact), tuple(fine), active)


def with_images(jumps: set[Fraction], delays: list[Fraction]) -> set[Fraction]:
    """Return jumps, as parts of the period, and their images under delays while they are few."""
    images = fresh = set(jumps)
    while fresh:
        fresh = {(jump + delay) % 1 for jump in fresh for delay in delays} - images
        if len(images) + len(fresh) > len(jumps) + _MOST_BREAKS:
            break
        images = images | fresh
    return images


def distinct(edges: list[float]) -> list[float]:
    """Return the edges, and 1; of edges apart by rounding alone the first."""
    distinct = [0.0]
    for edge in edges:
        if edge - distinct[-1] > _SMALLEST and 1.0 - edge > _SMALLEST:
            distinct.append(edge)
    return [*distinct, 1.0]


def presence(coefficient: Any, times: Floats) -> list[bool]:
    """Return of each time whether a matrix is not zero all over the piece about it."""
    pieces = by_pieces.in_time(coefficient)
    ends = [float(piece.begin + piece.length) for piece in pieces]
    there = np.minimum(np.searchsorted(ends, times % float(coefficient.period)), len(pieces) - 1)
    return [bool(pieces[i].size.any()) for i in there]


def rate(system: DelaySystem, decay: float = 0.0) -> float:
    """Return about the highest frequency, in radians per unit of time, of solutions that decay at most at ``decay``."""
    sizes = [_size(system.present)]
    sizes += [_size(coefficient) * math.exp(min(decay * float(delay), 300.0)) for delay, coefficient in system.delayed]
    if not isinstance(system.present, HillSystem):
        return float(sum(np.linalg.norm(size, 2) for size in sizes))
    inverse = inverse_mass(system)
    damping = 0.0 if system.present.damping is None else float(np.linalg.norm(inverse @ system.present.damping, 2))
    return math.sqrt(sum(float(np.linalg.norm(np.abs(inverse) @ size, 2)) for size in sizes)) + damping


def _size(coefficient: Any) -> Floats:
    return np.asarray(np.maximum.reduce([piece.size for piece in by_pieces.in_time(coefficient)]))


def inverse_mass(system: DelaySystem) -> Floats:
    """Return the inverse of M, the identity for equations of first order."""
    if not isinstance(system.present, HillSystem):
        return np.eye(system.order)
    return np.asarray(np.linalg.inv(mass_matrix(system.present)))


def coefficients(system: DelaySystem, period: float, nodes: Floats) -> Coefficients:
    """Return the coefficients of one system at nodes, parts of the period of its map."""
    times = nodes * period
    present, delayed = system.present.coefficient(times), [t.coefficient.coefficient(times) for t in system.delayed]
    if not isinstance(system.present, HillSystem):
        return Coefficients(period * present[None], None, tuple(period * matrix[None] for matrix in delayed))
    inverse = -inverse_mass(system)
    damping = velocity_matrix(system.present)
    moving = np.broadcast_to(period * inverse @ damping, present.shape)[None] if damping.any() else None
    square = period * period * inverse
    return Coefficients((square @ present)[None], moving, tuple((square @ matrix)[None] for matrix in delayed))


class HistoryMap(NamedTuple):
    """Maps over a period with what they are made of: the unknowns, the highest derivatives at the nodes, as rows.

    A state holds, of each equation, q and q', or x, at the beginning, then the values kept of the last periods.
    """

    maps: Floats  # (b, S, S)
    unknowns: Floats  # (b, F n, S), over the state
    left: Floats  # (b, F n, F n), whose solution for the forces at the nodes is what these add to the unknowns


def period_map(mesh: Mesh, coefficients: Coefficients) -> HistoryMap:
    """Return the maps over a period of systems with coefficients at the nodes of a mesh, and their unknowns."""
    batch, count, n, _ = coefficients.value.shape
    derivatives = mesh.value_state.shape[1]
    kept = len(mesh.end) - derivatives
    left = _times(coefficients.value, mesh.value)
    start = _times(coefficients.value, mesh.value_state)
    if coefficients.rate is not None:
        left += _times(coefficients.rate, mesh.rate)
        start += _times(coefficients.rate, mesh.rate_state)
    past = np.zeros((batch, count, n, mesh.periods * kept, n))
    for coefficient, rows in zip(coefficients.delayed, mesh.delays, strict=True):
        if rows.now.any():
            left += _times(coefficient, rows.now)
            start += _times(coefficient, rows.now_state)
        past += _times(coefficient, rows.past)
    size = count * n
    left = np.eye(size) - left.reshape(batch, size, size)
    right = np.concatenate([start.reshape(batch, size, -1), past.reshape(batch, size, -1)], axis=2)
    unknowns = np.linalg.solve(left, right)
    new = np.kron(mesh.end, np.eye(n)) @ unknowns
    new[:, :, : derivatives * n] += np.kron(mesh.end_state, np.eye(n))
    return HistoryMap(_square(np.asarray(new), kept * n), unknowns, left)


def _square(new: Floats, kept: int) -> Floats:
    """Return square maps (b, S, S): new values, and below them the ``kept`` ones, which become a period older."""
    batch, made, total = new.shape
    square = np.zeros((batch, total, total))
    square[:, :made] = new
    older = np.arange(made, total)
    square[:, older, older - kept] = 1.0
    return square


def period_maps(mesh: Mesh, coefficients: Coefficients) -> Floats:
    """Return the maps over a period, (b, S, S), of systems with coefficients at the nodes of a mesh."""
    return period_map(mesh, coefficients).maps


def maps_by_piece(mesh: PieceMesh, coefficients: Coefficients) -> Floats:
    """Return the maps of `period_maps`, found from piece to piece: for many pieces.

    The unknowns u of a piece, with the state x at its beginning, are

        (1 - C_u) u = C_x x + sum_j delayed[j] z_j,   C = value V + rate R,

    with rows V = (V_x, V_u) and R of the mesh, and z_j from earlier pieces and periods; of the same piece they belong
    to the left side.  Of P pieces this takes 1 / P^2 of the work of all unknowns at once.
    """
    batch, _, n, _ = coefficients.value.shape
    count, r = mesh.value.shape[1], mesh.end.shape[1]
    columns = mesh.size * n
    state = np.zeros((batch, r, n, columns))
    state.reshape(batch, r * n, columns)[:, :, : r * n] = np.eye(r * n)
    solutions: list[Floats] = []  # of each piece, its first state and its unknowns (b, r + N, n, S)
    for p, sources in enumerate(mesh.sources):
        own = slice(p * count, (p + 1) * count)
        value, rate = coefficients.value[:, own], None if coefficients.rate is None else coefficients.rate[:, own]
        left = _times(value, mesh.value[p, :, r:])
        right = _applied(value, _rows_of(mesh.value[p, :, :r], state))
        if rate is not None:
            left += _times(rate, mesh.rate[p, :, r:])
            right += _applied(rate, _rows_of(mesh.rate[p, :, :r], state))
        for source in sources:
            delayed = coefficients.delayed[source.delay][:, own][:, source.nodes]
            if source.piece is None:
                history = _times(delayed, source.rows)
                right[:, source.nodes, :, r * n :] += history.reshape(batch, -1, n, columns - r * n)
            elif source.piece == p:
                left[:, source.nodes] += _times(delayed, source.rows[:, r:])
                right[:, source.nodes] += _applied(delayed, _rows_of(source.rows[:, :r], state))
            else:
                right[:, source.nodes] += _applied(delayed, _rows_of(source.rows, solutions[source.piece]))
        size = count * n
        unknowns = np.linalg.solve(np.eye(size) - left.reshape(batch, size, size), right.reshape(batch, size, columns))
        solutions.append(np.concatenate([state, unknowns.reshape(batch, count, n, columns)], axis=1))
        state = _rows_of(mesh.end[p], solutions[p])
    kept = [_rows_of(rows, solutions[p]) for p, rows in zip(mesh.kept, mesh.kept_values, strict=True)]
    new = np.concatenate([state, *kept], axis=1).reshape(batch, -1, columns)
    return _square(new, new.shape[1] - r * n)


def _applied(matrices: Floats, values: Floats) -> Floats:
    """Return matrices (b, f, n, n) times values (b, f, n, S)."""
    return np.asarray(matrices * values if matrices.shape[-1] == 1 else matrices @ values)


def _rows_of(rows: Floats, solution: Floats) -> Floats:
    """Return rows (f, g) of solutions (b, g, n, S), (b, f, n, S)."""
    batch, parts, n, columns = solution.shape
    return np.asarray(rows @ solution.reshape(batch, parts, n * columns)).reshape(batch, -1, n, columns)


def _times(coefficient: Floats, rows: Floats) -> Floats:
    """Return the matrices (b, F, n, g, n) of rows (F, g) of every equation, multiplied by coefficients."""
    return np.asarray(coefficient[:, :, :, None, :] * rows[None, :, None, :, None])
