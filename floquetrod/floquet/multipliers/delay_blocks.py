"""Collocation of one period in place of a history: its unknowns as powers of 1 / mu.

A history of a solution with x(t + T) = mu x(t) is its last period times powers of v = 1 / mu.  The map of the state and
the values kept then has no more rows than for a delay of one period, K(v) = I - sum_e C_e v^e, e - 1 the periods back.
"""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import EPS, norms
from floquetrod.equations import DelaySystem
from floquetrod.floquet.multipliers import delay_maps
from floquetrod.floquet.multipliers.delay_series import DelaySeries
from floquetrod.floquet.multipliers.independent_solutions import balance

_MOST_ROWS, _MOST_KEPT = 240, 3000  # of a period, and of the history (a choice: some seconds)


def series(system: DelaySystem, laid: delay_maps.PeriodPieces, count: int) -> DelaySeries | None:
    """Return K(v) with ``count`` nodes in each piece; None of too many rows."""
    n = system.order
    if n * (len(laid.breaks) - 1) * count > 2 * _MOST_ROWS:
        return None
    mesh = laid.mesh(system, count)
    made = n * len(mesh.end)
    if made > _MOST_ROWS or n * mesh.size > _MOST_KEPT:
        return None
    given = delay_maps.coefficients(system, laid.period, mesh.nodes)
    new, kept = delay_maps.period_maps(mesh, given)[0][:made], made - n * mesh.value_state.shape[1]
    exponents, matrices = [1], [new[:, :made]]
    for back in range(1, mesh.periods):
        block = np.zeros((made, made))
        block[:, made - kept :] = new[:, made + (back - 1) * kept : made + back * kept]
        if block.any():
            exponents.append(back + 1)
            matrices.append(block)
    stacked = np.stack(matrices)
    scales = balance(np.abs(stacked).sum(axis=0))
    stacked = stacked * scales[None, None, :] / scales[None, :, None]
    error = (8.0 + 4.0 * float(np.sqrt(made))) * EPS * float(norms(stacked).sum())
    return DelaySeries(np.asarray(exponents), stacked, error, 1, max(exponents))
