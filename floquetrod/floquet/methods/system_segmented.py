"""Multipliers that span many decades: eigenvalues of the cyclic matrix of the maps over segments of the period."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats, norms
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.hill_system import in_first_order
from floquetrod.floquet.multipliers import cyclic_matrix, independent_solutions
from floquetrod.floquet.multipliers.classification import classify_multipliers
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.multipliers.whole_period_maps import (
    PeriodMaps,
    balanced_maps,
    error_stretch,
    in_scaling,
    of_complex,
)
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Cost

_FEWEST, _MOST_ROWS = 8, 1000  # segments; rows of the cyclic matrix (a choice: about ten seconds)
_LARGEST_PHASE = 1e4  # radians in a period (a choice: a second of work)
_LARGEST_CONDITION = 100.0  # of the map over a segment: rounding then costs two digits (a choice)


def segmented(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify by the maps over m segments of the period, without multiplying them.

    The matrix that maps (x_0, ..., x_(m-1)), the states at the beginnings of the segments, to (F_(m-1) x_(m-1), F_0
    x_0, F_1 x_1, ...) has the m-th roots of the multipliers as its eigenvalues: where the product of the maps holds
    1e+16 beside 1e-16, it holds 100 beside 0.01 with m = 8.

    Parameters
    ----------
    system : HillSystem or PeriodicSystem
        One whose cyclic matrix has at most 1,000 rows; else the result is undecided.
    rtol : float
        Relative error of the map over each segment, from 1e-15 to 1e-3.

    Returns
    -------
    SystemStability
        Its errors are bounds for all maps within the errors of the segments' maps, which are estimates.

    Raises
    ------
    TypeError, ValueError
        For an accuracy outside 1e-15 to 1e-3.

    Examples
    --------
    >>> system = HillSystem([[-36.0, 0.0], [0.0, 1.0]], cosines=[[[0.3, 0.3], [0.3, 0.3]]])
    >>> [f"{abs(mu):.4g}" for mu in segmented(system).multipliers]
    ['2.359e+16', '1.055', '0.9482', '4.239e-17']
    """
    rtol = validate.within("rtol", rtol, 1e-15, 1e-3)
    freed = undamped_pairs(system)
    subject, damping = freed or (system, 0.0)
    first = in_first_order(subject)
    if first.order * _FEWEST > _MOST_ROWS:
        return _too_large(system, _FEWEST)
    if _phase(first) > _LARGEST_PHASE:
        return SystemStability.declined(
            system, "segmented", Cost(0, "segments"), "the period holds more waves than can be followed"
        )
    parts = len(first.pieces) or 1
    count, solutions = parts * math.ceil(_FEWEST / parts), None
    while first.order * count <= _MOST_ROWS:
        maps, errors, scales = _segments(first, count // parts, rtol)
        condition = float(np.linalg.cond(maps).max()) if np.isfinite(maps).all() else math.inf
        if not condition < math.inf:
            count *= 8
            continue
        excess = math.log(condition) / math.log(_LARGEST_CONDITION)
        if excess <= 1.0:
            solutions = cyclic_matrix.solutions(maps, errors, scales, keeps_norm=first.keeps_norm)
            break
        count = parts * math.ceil(1.1 * excess * count / parts)
    else:
        return _too_large(system, count)
    cost = Cost(count, "segments")
    if solutions is None:
        return SystemStability.declined(
            system, "segmented", cost, "the eigenvectors cannot be computed accurately enough"
        )
    logs = independent_solutions.log_discs(solutions, damping * float(system.period), are_real=not first.is_complex)
    hamiltonian = freed is not None and first.structure == "hamiltonian"
    krein = functools.partial(independent_solutions.krein_sign, solutions) if hamiltonian else None
    return classify_multipliers(system, "segmented", logs, krein=krein, cost=cost)


def _too_large(system: HillSystem | PeriodicSystem, count: int) -> SystemStability:
    note = f"needs cyclic matrices of more than {_MOST_ROWS} rows"
    return SystemStability.declined(system, "segmented", Cost(count, "segments"), note)


def _phase(system: PeriodicSystem) -> float:
    """Return a bound on the angle that solutions turn by in a period, in balanced coordinates."""
    sizes = np.maximum.reduce([piece.size for piece in by_pieces.in_time(system)])
    scales = independent_solutions.balance(sizes)
    return float(system.period) * float(np.linalg.norm(sizes * scales[None, :] / scales[:, None], 2))


def _segments(system: PeriodicSystem, count: int, rtol: float) -> tuple[NDArray[Any], Floats, Floats]:
    """Return the maps over ``count`` segments of each piece, balanced, their errors in the 2-norm, and the scales.

    Where the norm is kept they are not balanced.
    """
    arrays = by_pieces.of_batch(system)
    balanced = balanced_maps(arrays, rtol, count, exact=system.coefficient_error == 0.0)
    stretch = float(error_stretch(arrays.mean, balanced.scaling)[0])
    segments = len(balanced.maps[0])
    maps = PeriodMaps(balanced.maps[0], balanced.errors[0], np.repeat(balanced.scaling, segments, axis=0))
    if system.keeps_norm:
        maps = in_scaling(maps, np.ones(maps.scaling.shape))
    if system.is_complex:
        maps = of_complex(maps)
    length = np.repeat(arrays.length[0] / count, count)
    with np.errstate(over="ignore", invalid="ignore"):  # of maps that overflow
        change = system.coefficient_error * system.real_form.order * stretch * length * norms(maps.matrix)
        return maps.matrix, maps.error + change, maps.scaling[0]
