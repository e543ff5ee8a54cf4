"""What becomes of a kick, for ever: over arrays, and of one with the reason."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate
from floquetrod._compile import compiled, over_chunks
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.friction.preparation import (
    EFFORT,
    arguments,
    cells,
    growth_of,
    growth_without_friction,
    over_friction,
    size_of,
)
from floquetrod.kernels import friction as kernels
from floquetrod.result import NoTruthValue

UNDECIDED, BOUNDED, ESCAPES = -1, 0, 1
"""Values of `outcome`."""

_SHORT = 2000  # cells that are cheaper interpreted than numba is to load (measured)


class UndecidedWarning(UserWarning):
    """Some orbits could not be decided; they are not counted among those that escape."""


def outcome(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    effort: int = EFFORT,
    workers: int | None = None,
) -> Any:
    """Return the fate of each kick: `ESCAPES` (1), `BOUNDED` (0) or `UNDECIDED` (-1), as int8.

    Parameters
    ----------
    alpha, beta, gamma, epsilon, damping : array_like
        Broadcast against each other.  gamma and damping are zero or more; a negative kick is the mirror image of its
        positive.  Fastest where epsilon varies along the last axis.
    effort : int
        Cells an orbit may take before it is given up as undecided.
    workers : int, optional
        Threads; by default all cores.

    Notes
    -----
    Without friction an orbit escapes where Mathieu's equation is unstable and the kick is not zero.  Where it is
    stable no kick escapes: proved but for exact resonances, which no double hits (docs/friction.md).

    Examples
    --------
    >>> outcome(0.0, 0.25, 1.0, [1.999, 2.001]).tolist()
    [0, 1]
    """
    shape, alpha, beta, gamma, c, kick = arguments(alpha, beta, gamma, damping, epsilon=size_of(epsilon))
    fates = _fates(alpha, beta, gamma, kick, c, effort, workers)
    result = np.where(fates == kernels.GROWS, ESCAPES, np.where(fates < kernels.GROWS, BOUNDED, UNDECIDED))
    return result.astype(np.int8).reshape(shape) if shape else np.int8(result[0])


def escapes(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    effort: int = EFFORT,
    workers: int | None = None,
) -> Any:
    """Return whether each kick escapes for good, as bool; arguments as in `outcome`.

    Warns
    -----
    UndecidedWarning
        When some orbits could not be decided: False there means "not known to escape"; `outcome` tells which.

    Examples
    --------
    >>> escapes(1.0, [0.3, -0.7], 1.0, 2.0).tolist()
    [True, False]
    """
    fate = outcome(alpha, beta, gamma, epsilon, damping, effort=effort, workers=workers)
    unknown = int(np.count_nonzero(fate == UNDECIDED))
    if unknown:
        warnings.warn(
            f"{unknown} of {np.size(fate)} kicks could not be decided and count as not escaping; "
            "friction.outcome tells which, a larger effort may settle them",
            UndecidedWarning,
            stacklevel=2,
        )
    return fate == ESCAPES


def _fates(
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    gamma: NDArray[np.float64],
    kick: NDArray[np.float64],
    damping: NDArray[np.float64],
    effort: int,
    workers: int | None,
) -> NDArray[np.int8]:
    """Return why each run ended, as the kernels number it."""
    effort = _validate.integer("effort", effort, 1)
    rate = growth_without_friction(alpha, beta, damping, workers)
    out = np.empty(kick.size, dtype=np.int8)
    if kick.size == 1:
        one = FrictionalMathieu(float(alpha[0]), float(beta[0]), float(gamma[0]), float(damping[0]))
        out[0] = _code(one, float(kick[0]), float(rate[0]), effort, np.zeros(7))
        return out
    free = gamma == 0.0
    runs = np.where(free, -1.0, rate)
    limit = np.full(kick.size, effort, dtype=np.int64)
    inputs = (alpha, beta, damping, runs, over_friction(kick, gamma), limit)
    over_chunks(kernels.outcome_fill, inputs, out, workers=workers, chunk=64, interpret_up_to=0)
    out[free & (rate >= 0.0) & (kick > 0.0)] = kernels.GROWS
    return out


@dataclass(frozen=True, repr=False)
class Fate(NoTruthValue):
    """What becomes of one kick.

    Attributes
    ----------
    equation, epsilon : FrictionalMathieu, float
        What was asked.
    status : {"bounded", "escapes", "undecided"}
    reason : str
        How it is known.
    tau : float
        Time at which it was known.
    reversals, sticks : int
        How often the motion had come to a stop by then, and how often it had stuck.
    """

    ask = ".status"

    equation: FrictionalMathieu
    epsilon: float
    status: Literal["bounded", "escapes", "undecided"]
    reason: str
    tau: float
    reversals: int
    sticks: int

    def __repr__(self) -> str:
        """Return the fate as a sentence."""
        when = f" after {self.tau / (2.0 * math.pi):.3g} periods and {self.reversals} stops" if self.tau > 0.0 else ""
        return f"<{self.status}: {self.reason}; known{when or ' at once'}>"


_REASONS: dict[int, tuple[Literal["bounded", "escapes", "undecided"], str]] = {
    kernels.NO_GROWTH: ("bounded", "nothing grows without friction"),
    kernels.STUCK: ("bounded", "sticks for ever"),
    kernels.CREEPS: ("bounded", "creeps inwards, a little every period"),
    kernels.TRAPPED: ("bounded", "sticks and slips within bounds, as far as sampling shows"),
    kernels.GROWS: ("escapes", "the growing Floquet solution has outgrown friction"),
    kernels.LIMIT: ("undecided", "not decided within the effort allowed"),
}


def fate(equation: FrictionalMathieu, epsilon: float, *, effort: int = EFFORT) -> Fate:
    """Return what becomes of one kick A(0) = 0, A'(0) = epsilon, and how that is known.

    Examples
    --------
    >>> fate(FrictionalMathieu(alpha=1.0, beta=0.3, gamma=1.0), 2.0).status
    'escapes'
    """
    require(equation, (FrictionalMathieu,), "fate")
    epsilon = _validate.finite("epsilon", epsilon)
    effort = _validate.integer("effort", effort, 1)
    e = equation
    start = np.zeros(7)
    code = _code(e, abs(epsilon), growth_of(e), effort, start)
    status, reason = _REASONS[code]
    return Fate(e, epsilon, status, reason, float(start[2] + 2.0 * math.pi * start[6]), int(start[4]), int(start[5]))


def _code(e: FrictionalMathieu, kick: float, rate: float, effort: int, start: NDArray[np.float64]) -> int:
    """Return why the run of one kick ended, as the kernels number it."""
    if rate < 0.0:
        return kernels.NO_GROWTH
    if e.gamma == 0.0:
        return kernels.GROWS if kick > 0.0 else kernels.STUCK
    return _one(e, rate, kick / e.gamma, effort, start)


def _one(e: FrictionalMathieu, rate: float, kick: float, effort: int, start: NDArray[np.float64]) -> int:
    """Return the fate of one kick: interpreted where that is soon known, else compiled."""
    table, work = cells(e, rate)
    if kick * kick * (abs(e.alpha) + abs(e.beta)) > 1.0:
        start[1] = kick
        none = np.empty((0, 4))
        code = int(kernels.run(e.alpha, e.beta, e.damping, table, start, min(effort, _SHORT), effort, True, none, work))
        if code < kernels.LIMIT:
            return code
    judge = compiled(kernels.judge) if effort > _SHORT else kernels.judge
    return int(judge(e.alpha, e.beta, e.damping, table, kick, effort, True, start, work))
