"""What every question about kicks begins with: arguments that broadcast, growth without friction, a period's cells."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate, mathieu
from floquetrod._arrays import broadcast
from floquetrod._compile import fastest, over_chunks
from floquetrod.equations import FrictionalMathieu
from floquetrod.kernels import friction as kernels

EFFORT = 500_000
"""Cells an orbit may take, 32 or more to a period: a few thousandths of a second (a choice)."""

SHORT = 4000
"""Cells of one orbit that are interpreted, in up to a second: cheaper than numba is to load (measured)."""

_INTERPRETED_CELLS = 200  # prepared in one call without compiling: less than a tenth of a second (measured)
_PATIENCE = 10  # times as many before that is compiled, which takes two seconds (heuristic)
_AT_ONCE = 200_000  # cells held at once (a choice: some 20 MB)


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


class Prepared(NamedTuple):
    """Equations that grow without friction, ready for kicks to be judged; gamma = 1.

    Attributes
    ----------
    values : ndarray
        alpha, beta and damping of each.
    first, tables : ndarray
        Where the cells of each begin, and the cells of all.
    floor, ceiling : ndarray
        Proved: no kick up to the one escapes, every kick above the other does; infinite where no such kick is known.
    """

    values: NDArray[np.float64]
    first: NDArray[np.int64]
    tables: NDArray[np.float64]
    floor: NDArray[np.float64]
    ceiling: NDArray[np.float64]

    def nothing_known(self) -> NDArray[np.float64]:
        """Return what orbits of each equation have shown before the first was followed."""
        return np.full((self.first.size, kernels.KNOWN), -1.0)

    def judge(
        self,
        equation: NDArray[np.int64],
        kicks: NDArray[np.float64],
        effort: int,
        workers: int | None,
        known: NDArray[np.float64],
        patient: bool,
    ) -> NDArray[np.float64]:
        """Return fate, time, reversals and sticks of rows of kicks, one equation to a row; NaN is no kick.

        ``known``, a row for each, is what orbits have shown; see the kernel for ``patient``.
        """
        out = np.full((*kicks.shape, 4), np.nan)
        kicks = np.ascontiguousarray(kicks)  # one layout: the kernel is compiled for each there is
        constants = equation, self.values, self.first, known, kicks, effort, patient, self.tables
        rows = np.arange(equation.size)
        over_chunks(kernels.judge_fill, (rows,), out, *constants, workers=workers, chunk=32, interpret_up_to=0)
        return out


def prepare(
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    damping: NDArray[np.float64],
    rate: NDArray[np.float64],
    workers: int | None,
) -> Prepared:
    """Return equations ready for kicks to be judged; ``rate`` is their growth without friction."""
    counts = _cell_counts(alpha, beta, damping)
    first = np.cumsum(counts) - counts
    tables = np.empty((int(counts.sum()), kernels.COLUMNS))
    floor = np.empty(alpha.size)
    inputs = (alpha, beta, damping, rate, first)
    few = _INTERPRETED_CELLS // int(counts.max(initial=1))
    over_chunks(
        kernels.prepare_fill, inputs, floor, tables, workers=workers, chunk=64, interpret_up_to=few, patience=_PATIENCE
    )
    with np.errstate(divide="ignore"):
        ceiling = 1.0 / np.abs(tables[first, 10])
    return Prepared(np.stack([alpha, beta, damping], axis=1), first, tables, np.minimum(floor, ceiling), ceiling)


def prepare_one(equation: FrictionalMathieu, rate: float) -> Prepared:
    """Return one equation ready for kicks to be judged."""
    alpha, beta, damping, rates = np.array([[equation.alpha], [equation.beta], [equation.damping], [rate]])
    return prepare(alpha, beta, damping, rates, 1)


def parts(
    chosen: NDArray[np.int64], alpha: NDArray[np.float64], beta: NDArray[np.float64], damping: NDArray[np.float64]
) -> list[NDArray[np.int64]]:
    """Return the indices ``chosen`` in parts whose cells fit into memory at once."""
    if not chosen.size:
        return []
    turn = np.cumsum(_cell_counts(alpha[chosen], beta[chosen], damping[chosen])) // _AT_ONCE
    return np.split(chosen, np.flatnonzero(np.diff(turn)) + 1)


def _cell_counts(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], damping: NDArray[np.float64]
) -> NDArray[np.int64]:
    equations = zip(alpha.tolist(), beta.tolist(), damping.tolist(), strict=True)
    return np.array([kernels.cell_count(*equation) for equation in equations], dtype=np.int64)
