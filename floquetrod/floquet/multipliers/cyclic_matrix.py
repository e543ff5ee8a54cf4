"""Multipliers from the cyclic matrix of the maps over segments of the period, whose eigenvalues are their roots.

The matrix that maps (x_0, ..., x_(m-1)), the states at the beginnings of the segments, to (F_(m-1) x_(m-1), F_0 x_0,
F_1 x_1, ...) has the m-th roots of the multipliers as its eigenvalues: where the product of the maps holds 1e+16
beside 1e-16, it holds 100 beside 0.01 with m = 8.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.floquet.multipliers import independent_solutions, spectra
from floquetrod.floquet.multipliers.independent_solutions import Solutions


def solutions(maps: NDArray[Any], errors: Floats, scales: Floats, *, keeps_norm: bool = False) -> Solutions | None:
    """Return independent Floquet solutions from the maps (m, n, n) over segments of a period, without multiplying them.

    Parameters
    ----------
    maps : ndarray (m, n, n)
        Of x / scales; real or complex.
    errors : ndarray (m,)
        Bounds of their errors in the 2-norm.
    scales : ndarray (n,)
    keeps_norm : bool
        Whether the maps are unitary, and with them the cyclic matrix.

    Returns
    -------
    Solutions or None
        None where eigenvectors cannot be computed accurately enough.
    """
    count, order, _ = maps.shape
    cyclic = np.zeros((count, order, count, order), dtype=maps.dtype)
    for j, segment in enumerate(maps):
        cyclic[(j + 1) % count, :, j] = segment
    discs_of = spectra.normal_discs if keeps_norm else spectra.diagonalised_discs
    discs = discs_of(cyclic.reshape(count * order, count * order), float(errors.max()))
    if discs is None:
        return None
    states = discs.right[:order]
    chosen = independent_solutions.independent(states, np.abs(np.angle(discs.values)))
    if chosen is None:
        return None
    roots, radii = discs.values[chosen], discs.radii[chosen]
    with np.errstate(divide="ignore"):
        relative = np.minimum(radii / np.abs(roots), 1.0)
        uncertainties = -count * np.log1p(-relative)
    states = states[:, chosen] * scales[:, None]
    logs = independent_solutions.principal(count * np.log(roots))
    return Solutions(logs, uncertainties, states / np.linalg.norm(states, axis=0))
