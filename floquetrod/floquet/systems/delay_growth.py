"""How fast the leading solution of a system with delays grows: one number, for searches."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.equations import DelaySystem
from floquetrod.floquet.systems import delay_maps

_COUNTS = (8, 12, 16, 20, 26, 32, 40, 50)  # nodes in a piece, tried in turn (a choice)
_MOST_ROWS = 1000  # of collocation (a choice: a second)
_AGREES = 1e-12  # relative change of the modulus at which it ends
_USABLE = 1e-9  # largest change with which it is told (a choice)


def moduli(maps: Floats) -> Floats:
    """Return the largest moduli of the eigenvalues of maps (b, S, S)."""
    return np.asarray(np.abs(np.linalg.eigvals(maps)).max(axis=1))


def growth_rate(system: DelaySystem) -> float:
    """Return the real part of the leading exponent, per unit of time; NaN where it takes too much."""
    laid = delay_maps.layout(system)
    before, change = math.nan, math.inf
    for count in _COUNTS:
        on = laid.mesh(system, count)
        if system.order * max(on.size, len(on.nodes)) > _MOST_ROWS:
            break
        found = float(moduli(delay_maps.period_maps(on, delay_maps.coefficients(system, laid.period, on.nodes)))[0])
        change, before = abs(found - before) / found if found > 0.0 else 0.0, found
        if change <= _AGREES:
            break
    if not change <= _USABLE:
        return math.nan
    return math.log(before) / laid.period if before > 0.0 else -math.inf
