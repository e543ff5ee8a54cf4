"""Cyclic systems of equations with a border, solved by orthogonal eliminations of every second unknown.

x_(i+1) - G_i x_i = columns_i s + right_i for i = 0 .. N - 1, x_N = x_0, with a few scalars s and as many rows that
tie everything together.  Each elimination takes the unknown between two neighbouring equations out of them by a QR
decomposition, all pairs at once, which is stable whatever the maps G grow or shrink by (S. J. Wright, SIAM J. Sci.
Stat. Comput. 13 (1992) 742); the cost is O(N n^3).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.orbits.kernels import interval_cycle

_NO_STAGES = np.empty((0, 0, 0, 0))
_FAMILY = 1e-10  # of the largest singular value: one below it is zero, and orbits form a family (a choice)


class BorderedSolution(NamedTuple):
    """Solutions of a bordered system, one for each of q right sides."""

    nodes: Floats  # (N, n, q), the unknowns x_i
    scalars: Floats  # (S, q), the scalars
    core: Floats  # (n + S, n + S), what is left of the equations in x_0 and the scalars; singular where the whole is
    kernel: tuple[Floats, Floats]  # (N, n) and (S,), the solution without right sides, or what is nearest to one


class _Level(NamedTuple):
    """Unknowns in the middle of pairs of equations: R x = right - left x_before - next x_after."""

    triangle: Floats
    left: Floats
    after: Floats
    right: Floats


def solve(
    maps: Floats, columns: Floats, right: Floats, rows: Floats, corner: Floats, targets: Floats
) -> BorderedSolution:
    """Return the solution of x_(i+1) - G_i x_i = columns_i s + right_i and rows . x + corner s = targets.

    Parameters
    ----------
    maps : ndarray (N, n, n)
        The matrices G_i.
    columns : ndarray (N, n, S)
        How the scalars drive the equations.
    right : ndarray (N, n, q)
        Right sides.
    rows : ndarray (S, N, n)
        Factors of the x_i in the rows of the border.
    corner : ndarray (S, S)
        Factors of the scalars there.
    targets : ndarray (S, q)
        Right sides of the border.

    Where the whole is singular, the shortest solution is returned.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where a block is singular.
    """
    n, scalars, count = maps.shape[1], columns.shape[2], right.shape[2]
    unit = np.broadcast_to(np.eye(n), maps.shape)
    before, after = -maps, np.ascontiguousarray(unit)
    levels, rest = [], np.concatenate([columns, right], axis=2)
    while len(before) > 1:
        level, before, after, rest = _eliminated(before, after, rest)
        levels.append(level)
    # Every x_i as a matrix applied to (x_0, s, 1): a factor of x_0, of the scalars, and what remains.
    unknowns = np.concatenate([np.eye(n), np.zeros((n, scalars + count))], axis=1)[None]
    for level in reversed(levels):
        unknowns = _filled_in(level, unknowns)
    core = np.empty((n + scalars, n + scalars))
    core[:n, :n], core[:n, n:] = before[0] + after[0], -rest[0, :, :scalars]
    tied = rows.reshape(scalars, rows.shape[1] * n) @ unknowns.reshape(-1, n + scalars + count)
    core[n:, :n], core[n:, n:] = tied[:, :n], tied[:, n : n + scalars] + corner
    known = np.concatenate([rest[0, :, scalars:], targets - tied[:, n + scalars :]])
    return _of_core(unknowns, core, known)


class Balanced(NamedTuple):
    """Equations with a border in which scalars and rows have size 1."""

    rows: Floats  # (S, N, n)
    corner: Floats  # (S, S)
    columns: Floats  # (N, n, S)
    units: Floats  # (S,), of the scalars
    sizes: Floats  # (S,), by which rows and their targets are multiplied


def balanced(rows: Floats, corner: Floats, columns: Floats, smallest: float = 1e-300) -> Balanced:
    """Return equations in units of the scalars and of the rows; a scalar counts as one that changes ``smallest``."""
    # Where an orbit does not depend on the parameter its column is rounding; the rows tell its unit then.
    ends = np.abs(corner).max(axis=0, initial=0.0)
    units = 1.0 / np.maximum(np.maximum(np.abs(columns).sum(axis=(0, 1)), ends), smallest)
    sizes = 1.0 / np.maximum(np.abs(rows).sum(axis=(1, 2)) + np.abs(corner * units).sum(axis=1), 1e-300)
    return Balanced(rows * sizes[:, None, None], corner * units * sizes[:, None], columns * units, units, sizes)


def solve_by(
    run: Callable[..., Any],
    maps: Floats,
    columns: Floats,
    right: Floats,
    rows: Floats,
    corner: Floats,
    targets: Floats,
    scale: Floats,
    inner: Floats = _NO_STAGES,
    constant: float = 0.0,
) -> tuple[Floats, Floats, Floats | None]:
    """Return the unknowns (N, n, q) and the scalars (S, q) by the kernel, which scales the states by ``scale`` (n,).

    And what the first right side changes at the Gauss points (N, m, n), by ``inner`` (N, m, n, n + 1 + S) and a
    ``constant``; None where the equations are nearly singular.  Other arguments as in `solve`.
    """
    n, scalars, count = maps.shape[1], columns.shape[2], right.shape[2]
    width = n + scalars + count
    states, left, units = np.empty((len(maps), n, width)), np.empty((n + scalars, width)), np.empty(scalars)
    nodes, free, stages = np.empty(right.shape), np.empty((scalars, count)), np.empty(inner.shape[:3])
    given = maps, columns, right, rows, corner, targets, scale, inner, constant
    outcome = run(*given, states, left, units, nodes, free, stages)
    if outcome == interval_cycle.SINGULAR:
        raise np.linalg.LinAlgError("singular")
    if outcome == interval_cycle.NEARLY_SINGULAR:
        solution = _of_core(states, left[:, : n + scalars], -left[:, n + scalars :])
        return solution.nodes * scale[:, None], solution.scalars * units[:, None], None
    return nodes, free, stages


def _of_core(unknowns: Floats, core: Floats, known: Floats) -> BorderedSolution:
    """Return the solution from the last equations, in x_0 and the scalars."""
    answer, kernel = _least(core, known)
    n, free = unknowns.shape[1], len(core)
    nodes = unknowns[:, :, :free] @ answer + unknowns[:, :, free:]
    return BorderedSolution(nodes, answer[n:], core, (unknowns[:, :, :free] @ kernel, kernel[n:]))


def _least(core: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Return the shortest solution, and the vector that the matrix makes shortest.

    Where orbits form a family, as in a conservative system, the shortest step leads to the nearest.
    """
    left, sizes, turned = np.linalg.svd(core)
    if not (0.0 < sizes[0] < np.inf):
        raise np.linalg.LinAlgError("singular")
    kept = int(np.count_nonzero(sizes > _FAMILY * sizes[0]))
    return np.asarray(turned[:kept].T @ ((left[:, :kept].T @ right) / sizes[:kept, None])), turned[-1]


def _eliminated(before: Floats, after: Floats, rest: Floats) -> tuple[_Level, Floats, Floats, Floats]:
    """Return the equations before x_left + after x_right = rest that remain of pairs of them, and what was taken out.

    The last equation of an odd number is kept.
    """
    n, pairs = before.shape[1], len(before) // 2
    first, second = slice(0, 2 * pairs, 2), slice(1, 2 * pairs, 2)
    q, r = np.linalg.qr(np.concatenate([after[first], before[second]], axis=1), mode="complete")
    turned = np.swapaxes(q, 1, 2)
    left, right = turned[:, :, :n] @ before[first], turned[:, :, n:] @ after[second]
    known = turned[:, :, :n] @ rest[first] + turned[:, :, n:] @ rest[second]
    level = _Level(r[:, :n], left[:, :n], right[:, :n], known[:, :n])
    odd = slice(2 * pairs, None)
    kept = ((left[:, n:], before[odd]), (right[:, n:], after[odd]), (known[:, n:], rest[odd]))
    before, after, rest = (np.concatenate(parts) for parts in kept)
    return level, before, after, rest


def _filled_in(level: _Level, unknowns: Floats) -> Floats:
    """Return the unknowns (N, n, n + S + q) of a level; those given, of the next level, are every second of them."""
    n, pairs = unknowns.shape[1], len(level.triangle)
    left = unknowns[:pairs]
    right = np.concatenate([unknowns, unknowns[:1]])[1 : pairs + 1]
    known = -(level.left @ left) - level.after @ right
    known[:, :, n:] += level.right
    middle = np.linalg.solve(level.triangle, known)
    whole = np.empty((pairs + len(unknowns), *unknowns.shape[1:]))
    whole[0 : 2 * pairs : 2], whole[1 : 2 * pairs : 2] = left, middle
    whole[2 * pairs :] = unknowns[pairs:]
    return whole
