"""Collocation at Gauss's nodes: multipliers of systems with delays from the map of what they remember.

D. Breda, S. Maset and R. Vermiglio, SIAM J. Numer. Anal. 50 (2012) 1456, doi:10.1137/100815505.
"""

from __future__ import annotations

import numpy as np

from floquetrod._util import validate
from floquetrod.equations import DelaySystem
from floquetrod.equations.delay_system import moved
from floquetrod.floquet.multipliers import delay_maps, delay_roots, delay_spectra
from floquetrod.floquet.multipliers.classification import classify_multipliers
from floquetrod.floquet.multipliers.delay_spectra import LeadingMultipliers
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost

_FEWEST, _MOST = 8, 56  # nodes in a piece (a choice)
_MOST_ROWS = 2000  # of the equations of collocation, and of the map (a choice: some seconds)
_PLENTY = 100  # rows above which larger changes end it (a choice: time goes with their cube)
_LEFT_OUT = "multipliers of modulus below {:.3g} are left out"


def collocation(system: DelaySystem, *, rtol: float = 1e-12, above: float = 0.1) -> SystemStability:
    """Classify by the map over a period of the state and of the history within the delays.

    On each piece between the jumps of coefficients, and their images by the delays, the highest derivative is a
    polynomial that satisfies the equation at Gauss's nodes.  The values that later periods need are kept at Chebyshev's
    points.  Multipliers converge like the power 2 m of the number m of nodes, or faster, where coefficients are smooth;
    where delays and period are not commensurate and coefficients jump, as the power of the order of jumps not resolved.

    Parameters
    ----------
    system : DelaySystem
        One whose equations of collocation are at most 2,000; else the result is undecided.
    rtol : float
        Change of the multipliers from one number of nodes to the next at which it stops, from 1e-15 to 1e-3; above 100
        rows it is larger, as their number cubed.
    above : float
        Modulus above which multipliers are found, the largest in any case, over the period or the longest delay,
        whichever is longer; from 1e-4 to 0.9.

    Returns
    -------
    SystemStability
        Its errors are estimates: twice the change to fewer nodes, twice that by coefficients off by their error, and
        the condition of the invariant subspace times rounding.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges.

    Examples
    --------
    >>> import math
    >>> system = DelaySystem([[3.0]], [[[2.0]]], damping=[[0.1]], delayed=[(2.0 * math.pi, [[0.15]])])
    >>> found = collocation(system)
    >>> f"{found.multipliers[0]:.12f}", found.error < 1e-11
    ('-0.461668137358-0.221495084819j', True)
    """
    rtol = validate.within("rtol", rtol, 1e-15, 1e-3)
    above = validate.within("above", above, 1e-4, 0.9)
    laid = delay_maps.period_pieces(system)
    least = laid.smallest_modulus(system, above)
    multipliers, rows = _converged(system, laid, least, rtol)
    cost = Cost(rows, "rows")
    if multipliers is None:
        note = f"needs collocation of more than {_MOST_ROWS} rows, or its multipliers cannot be distinguished"
        return SystemStability.declined(system, "collocation", cost, note)
    logs = delay_spectra.log_discs(multipliers.values, multipliers.radii)
    if system.is_constant:
        logs = delay_roots.per_period(system, logs, laid.period)
    note = _LEFT_OUT.format(least ** (float(system.period) / laid.period))
    return classify_multipliers(system, "collocation", logs, cost=cost, note=note)


def _converged(
    system: DelaySystem, laid: delay_maps.PeriodPieces, least: float, rtol: float
) -> tuple[LeadingMultipliers | None, int]:
    """Return the multipliers, their radii holding twice the last change, and the rows it took."""
    count, before, best = _FEWEST, None, None
    rows, rising = 0, 0
    while count <= _MOST:
        if system.order * (len(laid.breaks) - 1) * count > _MOST_ROWS:
            break
        on = laid.mesh(system, count)
        if on.size * system.order > _MOST_ROWS:
            break
        rows = system.order * max(on.size, len(on.nodes))
        given = delay_maps.coefficients(system, laid.period, on.nodes)
        matrix = delay_maps.period_maps(on, given)[0]
        multipliers = delay_spectra.leading(matrix, least)
        if multipliers is not None and before is not None:
            changed = delay_spectra.with_change(multipliers, before)
            change = float((changed.radii / np.abs(changed.values)).max())
            if best is None or change < best[0]:
                best, rising = (change, changed), 0
            else:
                rising += 1
            if change <= rtol * max(1.0, (rows / _PLENTY) ** 3) or rising == (3 if change > 1e-6 else 1):
                break
        before = None if multipliers is None else multipliers.all_values
        count += max(4, count // 4)
    if best is None:
        return None, rows
    _, accurate = best
    for other in moved(system) if system.coefficient_error else ():
        given = delay_maps.coefficients(other, laid.period, on.nodes)
        near = delay_spectra.leading(delay_maps.period_maps(on, given)[0], least)
        if near is None:
            return None, rows
        accurate = delay_spectra.with_change(accurate, near.all_values)
    return accurate, rows
