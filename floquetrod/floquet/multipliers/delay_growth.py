"""The growth rate of a system with delays, by collocation: one number, for searches."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.equations import DelaySystem
from floquetrod.floquet.multipliers import delay_maps

_COUNTS = (8, 12, 16, 20, 26, 32, 40, 50)  # nodes in a piece, tried in turn (a choice)
_MOST_ROWS = 1000  # of collocation (a choice: a second)
_AGREES = 1e-12  # relative change of the modulus at which refinement ends
_USABLE = 1e-9  # largest change of a modulus that is returned (a choice)


def moduli(maps: Floats) -> Floats:
    """Return the largest moduli of the eigenvalues of maps (b, S, S)."""
    return np.asarray(np.abs(np.linalg.eigvals(maps)).max(axis=1))


def growth_rate(system: DelaySystem) -> float:
    """Return the real part of the leading exponent, per unit of time; NaN where it takes too much."""
    pieces = delay_maps.period_pieces(system)
    coarse, change = math.nan, math.inf
    for count in _COUNTS:
        mesh = pieces.mesh(system, count)
        if system.order * max(mesh.size, len(mesh.nodes)) > _MOST_ROWS:
            break
        radius = float(
            moduli(delay_maps.period_maps(mesh, delay_maps.coefficients(system, pieces.period, mesh.nodes)))[0]
        )
        change, coarse = abs(radius - coarse) / radius if radius > 0.0 else 0.0, radius
        if change <= _AGREES:
            break
    if not change <= _USABLE:
        return math.nan
    return math.log(coarse) / pieces.period if coarse > 0.0 else -math.inf
