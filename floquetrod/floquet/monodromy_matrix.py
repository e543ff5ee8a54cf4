"""The map over a period of any equation or system, from solutions with unit initial values."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.equations import Equation, HillSystem
from floquetrod.equations.hill_system import states
from floquetrod.floquet.problems import Problem, require_without_delays
from floquetrod.floquet.solve import Solution, solve


class MonodromyMatrix(NamedTuple):
    """The matrix (N, N) that maps a state over one period, and an estimate of the largest error of an entry.

    Complex for a complex system.
    """

    matrix: NDArray[Any]
    error: float


def monodromy_over_period(problem: Problem, *, backward: bool = False) -> MonodromyMatrix:
    """Return the matrix that maps (A, A'), (q, q') or x from the beginning of a period to its end, or back.

    Each column is a solution with unit initial values; its error is the estimate of `floquetrod.solve`.
    """
    require_without_delays(problem, "a monodromy matrix, whose map is one of histories")
    span = (float(problem.period), 0.0) if backward else (0.0, float(problem.period))
    order = states_of(problem)
    columns = [marched(problem, unit, span) for unit in np.eye(order)]
    matrix = np.stack([column.states[-1] for column in columns], axis=1)
    return MonodromyMatrix(matrix, max(column.error * float(np.abs(column.states).max()) for column in columns))


def states_of(problem: Problem) -> int:
    """Return how many numbers make a state."""
    return 2 if isinstance(problem, Equation) else states(problem)


def marched(problem: Problem, state: NDArray[Any], span: tuple[float, float]) -> Solution:
    """Return the solution from a state at the beginning of a span."""
    start = state.reshape(2, -1) if isinstance(problem, HillSystem) else state
    try:
        solution: Solution = solve(problem, start, span)
    except ValueError as error:
        raise ValueError(f"equation must be one that can be solved over its period, and {error}") from None
    return solution
