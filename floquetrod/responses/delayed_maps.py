"""The method "monodromy" with delays: the map of a state and its history over a period, and what the force adds."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats, norms
from floquetrod.equations import DelaySystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.delay_solve import joined_series
from floquetrod.floquet.multipliers import delay_maps
from floquetrod.floquet.multipliers.delay_maps import PeriodPieces
from floquetrod.responses.forces import Force
from floquetrod.responses.motions import PiecewiseMotion
from floquetrod.responses.period_maps import MarchedResponse

_NODES = (20, 26)  # in each piece, the second number to learn the error of the first (heuristic)
_MOST_STATES = 3000  # rows of a map (a choice: seconds)
_FACTOR = 2.0  # error over the change between the two numbers of nodes


def marched_delayed(system: DelaySystem, force: Force) -> MarchedResponse:
    """Return the response of a system with delays by collocation, with an error from two numbers of nodes."""
    pieces = _pieces(system, force)
    coarse, _ = _collocated(system, force, pieces, _NODES[0])
    fine, rounding = _collocated(system, force, pieces, _NODES[1])
    grid = np.linspace(0.0, 1.0, 8 * len(pieces.breaks) + 33) * fine.period
    values = fine.values(grid, 0)
    largest = float(np.abs(values).max())
    change = float(np.abs(coarse.values(grid, 0) - values).max())
    error = (_FACTOR * change + rounding) / largest if largest > 0.0 else 0.0
    return MarchedResponse(fine, error if error == error else np.inf)


def _pieces(system: DelaySystem, force: Force) -> PeriodPieces:
    """Return the pieces of the period, no longer than a few turns of the force."""
    exact = by_pieces.exact_period(system.present)
    pieces = delay_maps.period_pieces(system, {piece.begin / exact for piece in force.pieces})
    turns = abs(force.frequency or 0.0) * pieces.period + 6.0 * len(force.harmonics)
    count = int(np.ceil(max(1.0, turns * pieces.longest / 12.0)))
    return pieces.cut(count) if count > 1 else pieces


def _collocated(system: DelaySystem, force: Force, pieces: PeriodPieces, count: int) -> tuple[PiecewiseMotion, float]:
    """Return the motion with so many nodes in each piece, and its rounding."""
    mesh, n, period = pieces.mesh(system, count), system.order, pieces.period
    if mesh.size * n > _MOST_STATES:
        raise ValueError(
            f"equation must be one whose map over a period has at most {_MOST_STATES:,} rows for method='monodromy', "
            f"got {mesh.size * n:,}: its delays reach over too many periods, or solutions turn too often"
        )
    derivatives = 2 if system.is_second_order else 1
    made = delay_maps.period_map(mesh, delay_maps.coefficients(system, period, mesh.nodes))
    driving = _at_nodes(system, force, mesh.nodes * period) * period**derivatives
    added = np.linalg.solve(made.left[0], driving.ravel())
    total = made.maps.shape[1]
    column = np.zeros(total, dtype=complex)
    new = np.kron(mesh.end, np.eye(n)) @ added
    column[: len(new)] = new
    turn = 1.0 if force.frequency is None else np.exp(1j * force.frequency * period)
    left = turn * np.eye(total) - made.maps[0]
    try:
        state = np.linalg.solve(left, column)
        norm = float(np.linalg.norm(np.linalg.inv(left), 2))
    except np.linalg.LinAlgError:
        state, norm = np.full(total, np.nan + 0j), np.inf
    rounding = norm * EPS * (4.0 * float(norms(made.maps[0])) + total**0.5) * float(np.linalg.norm(state))
    unknowns = (made.unknowns[0] @ state + added).reshape(len(pieces.breaks) - 1, count, n)
    whole: Any = joined_series(unknowns, pieces.breaks, state[: derivatives * n].reshape(derivatives, n))[0]
    if force.frequency is None:
        whole = whole.real.copy()
    own = Fraction(period)
    edges = np.array([float(Fraction(share) * own) for share in pieces.breaks])
    return PiecewiseMotion(float(period), force.frequency, edges, whole), rounding


def _at_nodes(system: DelaySystem, force: Force, times: Floats) -> Complexes:
    """Return the force at times, over the mass, (k, n)."""
    inverse = delay_maps.inverse_mass(system)
    if force.frequency is not None:
        return np.asarray(np.exp(1j * force.frequency * times)[:, None] * (inverse @ force.mean))
    values = np.empty((len(times), force.order), dtype=complex)
    period = system.period
    if not force.pieces:
        turns = np.exp(2j * np.pi * np.outer(times / period, np.arange(1, len(force.harmonics) + 1)))
        values[:] = force.mean + (turns @ force.harmonics).real
        return np.asarray(values @ inverse.T)
    ends = [float(piece.begin + piece.length) for piece in force.pieces]
    place = np.minimum(np.searchsorted(ends, times, side="right"), len(ends) - 1)
    for j, piece in enumerate(force.pieces):
        here = place == j
        values[here] = np.diagonal(piece.at(times[here] - float(piece.begin), period), axis1=-2, axis2=-1)
    return np.asarray(values @ inverse.T)
