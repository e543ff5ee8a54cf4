"""The smallest kick that escapes, and the kicks whose fate is proved."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod import _validate
from floquetrod._compile import over_chunks
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.friction.preparation import arguments, cells, growth_of, growth_without_friction, over_friction
from floquetrod.kernels import friction as kernels


class KickRange(NamedTuple):
    """Kicks between ``low`` and ``high``."""

    low: float
    high: float


def critical_perturbation(
    alpha: Any,
    beta: Any,
    gamma: Any = 1.0,
    damping: Any = 0.0,
    *,
    upto: Any = math.inf,
    samples: int = 32,
    effort: int = 100_000,
    workers: int | None = None,
) -> Any:
    """Return the infimum of kicks epsilon that escape; infinite where none does, NaN where it could not be decided.

    No kick up to gamma / sqrt(abs(alpha) + abs(beta)) escapes, and every kick beyond a bound known in closed form does
    (docs/friction.md).  In between ``samples`` kicks are tried upwards in geometric steps, closer together where
    neighbouring orbits differ in kind; the first escape is bisected to 1e-9, and kicks below it are tried at distances
    that shrink.  A range of escaping kicks that lies lower and between two kicks tried is missed: about one equation
    in thirty has one, up to five per cent lower (measured on a few hundred; `escape_ranges` looks closer).

    Parameters
    ----------
    alpha, beta, gamma, damping : array_like
        Broadcast against each other; the result is proportional to gamma.
    upto : array_like
        Kicks beyond it are not looked at: the result is infinite where none up to it escapes.  Quicker, and decided
        where only large kicks cannot be.
    samples : int
        Kicks tried.
    effort, workers : int
        As in `outcome`.

    Examples
    --------
    >>> round(float(critical_perturbation(0.0, 0.25)), 9)
    2.0
    """
    limited = _validate.array("upto", upto, least=0.0, largest=math.inf)
    if not (limited > 0.0).all():
        raise ValueError(f"upto must be greater than zero, got {upto!r}; leave it out to look at every kick")
    shape, alpha, beta, gamma, c, limit = arguments(alpha, beta, gamma, damping, upto=limited)
    samples = _validate.integer("samples", samples, 1)
    effort = _validate.integer("effort", effort, 1)
    rate = growth_without_friction(alpha, beta, c, workers)
    held = gamma > 0.0
    out = np.empty(alpha.size)
    counts = np.full(alpha.size, samples, dtype=np.int64), np.full(alpha.size, effort, dtype=np.int64)
    inputs = (alpha, beta, c, np.where(held, rate, -1.0), *counts, over_friction(limit, gamma))
    over_chunks(kernels.critical_fill, inputs, out, workers=workers, chunk=64, interpret_up_to=0)
    out = np.where(held | (rate < 0.0), np.where(held, gamma, 1.0) * out, 0.0)  # without friction the slightest kick
    return out.reshape(shape) if shape else float(out[0])


def certain_kicks(equation: FrictionalMathieu) -> KickRange:
    """Return the kick up to which none escapes, and that above which every one does: both proved.

    The second is infinite where nothing grows without friction.  docs/friction.md derives them.

    Examples
    --------
    >>> certain_kicks(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0)).low
    2.0
    """
    require(equation, (FrictionalMathieu,), "certain_kicks")
    largest = abs(equation.alpha) + abs(equation.beta)
    rate = growth_of(equation)
    if rate < 0.0:
        return KickRange(math.inf, math.inf)
    if largest == 0.0:
        return KickRange(math.inf, math.inf) if equation.gamma > 0.0 else KickRange(0.0, 0.0)
    table, _ = cells(equation, rate)
    first = abs(float(table[0, 10]))
    high = equation.gamma / first if first > 0.0 else math.inf
    return KickRange(equation.gamma / math.sqrt(largest), high)
