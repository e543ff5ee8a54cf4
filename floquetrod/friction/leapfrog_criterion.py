"""The paper's test with friction: a hundred periods of leapfrog."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod._util.compilation import runner
from floquetrod.friction.inputs import arguments, over_friction, size_of
from floquetrod.friction.kernels.frictional_leapfrog import frictional_leapfrog_fill

_MOST_STEPS = 1e9  # of one motion, a choice: some seconds
_HARDEST = 1e100  # kick over friction; beyond it friction is lost in rounding, and the ratio makes no difference


def leapfrog_escapes(
    alpha: Any,
    beta: Any,
    gamma: Any,
    kick: Any,
    *,
    damping: Any = 0.0,
    periods: int = 100,
    step: float = 5e-4,
    limit: float = 1e6,
) -> Any:
    """Return the result of the paper's test: whether abs(A) / kick reaches ``limit`` after 100 periods of leapfrog.

    Kick, drift, kick; friction is an impulse that stops a motion without turning it, so that it sticks.  Motions that
    grow more slowly than ln(limit) over the time followed count as stable.  Other arguments as in `fates`.

    Parameters
    ----------
    gamma : array_like
        Friction force over inertia, greater than 0.
    periods : int
        Periods 2 pi followed, 1 or more.
    step : float
        Step of tau, 1e-6 to 0.5.
    limit : float
        Ratio abs(A) / kick at which a motion counts as escaped, greater than 0.

    Returns
    -------
    bool or ndarray of bool
        In the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, for shapes that do not broadcast, and for more steps than can be taken.

    Examples
    --------
    >>> leapfrog_escapes(1.0, 0.3, 1.0, [0.5, 2.0], step=0.01).tolist()
    [False, True]
    """
    shape, alpha, beta, gamma, c, kick = arguments(alpha, beta, gamma, damping, kick=size_of(kick))
    if not (gamma > 0.0).all():
        raise validate.wrong_value(
            "gamma", "must be greater than zero here; without friction use method='leapfrog' of stability"
        )
    periods = validate.integer("periods", periods, 1)
    count = math.ceil(2.0 * math.pi / validate.within("step", step, 1e-6, 0.5))
    limit = validate.positive("limit", limit)
    if float(periods) * count > _MOST_STEPS:
        raise validate.wrong_value(
            "periods", f"must be at most {_MOST_STEPS // count:.0f} of {count} steps, got {periods}"
        )
    sine = np.sin(2.0 * math.pi * np.arange(count) / count)
    out = np.empty(alpha.size, dtype=np.bool_)

    run = runner(frictional_leapfrog_fill, alpha.size * periods * count // 1000)
    with np.errstate(over="ignore", invalid="ignore"):  # interpreted: what grows beyond doubles has escaped
        run(alpha, beta, c, np.minimum(over_friction(kick, gamma), _HARDEST), sine, periods, limit, out)
    return shaped(out, shape)
