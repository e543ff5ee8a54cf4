"""What every question about kicks begins with: arguments that broadcast, growth without friction, a period's cells."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate, mathieu
from floquetrod._arrays import broadcast
from floquetrod._compile import fastest
from floquetrod.equations import FrictionalMathieu
from floquetrod.kernels import friction as kernels

EFFORT = 500_000
"""Cells an orbit may take, 32 or more to a period: a few thousandths of a second (a choice)."""


def arguments(alpha: Any, beta: Any, gamma: Any, damping: Any, **kicks: NDArray[np.float64]) -> tuple[Any, ...]:
    """Return the common shape and the flat arrays of arguments that broadcast; ``kicks`` are checked already."""
    largest = np.finfo(np.float64).max
    arrays = {
        "alpha": _validate.array("alpha", alpha),
        "beta": _validate.array("beta", beta),
        "gamma": _validate.array("gamma", gamma, least=0.0, largest=largest),
        "damping": _validate.array("damping", damping, least=0.0, largest=_validate.LARGEST**0.5),
        **kicks,
    }
    shape, flat = broadcast(**arrays)
    return (shape, *flat)


def size_of(epsilon: Any) -> NDArray[np.float64]:
    """Return the size of kicks: to either side they are mirror images."""
    largest = np.finfo(np.float64).max
    size: NDArray[np.float64] = np.abs(_validate.array("epsilon", epsilon, least=-largest, largest=largest))
    return size


def over_friction(kick: NDArray[np.float64], gamma: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return kick / gamma, all that matters of the two; the kick itself where there is no friction."""
    with np.errstate(over="ignore"):
        return kick / np.where(gamma > 0.0, gamma, 1.0)


def growth_without_friction(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], damping: NDArray[np.float64], workers: int | None
) -> NDArray[np.float64]:
    """Return growth rates without friction, -1 where nothing grows; 0 where it is linear or too slow for a double."""
    stable = mathieu.is_stable(alpha, beta, damping, workers=workers)
    return np.where(stable, -1.0, mathieu.growth_rate(alpha, beta, damping, workers=workers))


def growth_of(equation: FrictionalMathieu) -> float:
    """Return the growth rate of one equation without friction, as `growth_without_friction` does."""
    alpha, beta, damping = (np.array([value]) for value in (equation.alpha, equation.beta, equation.damping))
    return float(growth_without_friction(alpha, beta, damping, 1)[0])


def cells(equation: FrictionalMathieu, rate: float) -> tuple[NDArray[np.float64], Any]:
    """Return the cells of a period and the workspace that goes with them."""
    e = equation
    count = kernels.cell_count(e.alpha, e.beta, e.damping)
    table, work = np.empty((count, kernels.COLUMNS)), kernels.workspace()
    fastest(kernels.prepare, count // 4)(e.alpha, e.beta, e.damping, rate, table, work)
    return table, work
