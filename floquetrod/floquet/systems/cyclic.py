"""Multipliers from the cyclic matrix of the maps over segments of the period, whose eigenvalues are their roots.

The matrix that maps (x_0, ..., x_(m-1)), the states at the beginnings of the segments, to (F_(m-1) x_(m-1), F_0 x_0,
F_1 x_1, ...) has the m-th roots of the multipliers as its eigenvalues: where the product of the maps holds 1e+16
beside 1e-16, it holds 100 beside 0.01 with m = 8.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats, norms
from floquetrod.floquet.systems import independent_solutions, spectra
from floquetrod.floquet.systems.independent_solutions import Solutions

_ROUNDS = 3  # of orthogonal iteration (a choice)


class Evened(NamedTuple):
    """Maps in other coordinates at each instant between segments, in which every direction grows evenly."""

    maps: Floats  # (m, n, n)
    errors: Floats  # (m,), bounds of their errors in the 2-norm
    basis: Floats  # (n, n), the coordinates at the first instant: x = basis y


def evened(maps: Floats, errors: Floats) -> Evened:
    """Return maps over segments in coordinates in which what decays fast here and slowly there decays evenly.

    Frames that motion turns into each other, the faster growing directions first, are found by orthogonal iteration
    over a few rounds; each axis is then scaled by what it has grown less its mean.  The multipliers are the same
    whatever the frames are.
    """
    count, n, _ = maps.shape
    frames = np.empty((count, n, n))
    frame = np.eye(n)
    for _ in range(_ROUNDS):
        grown = np.empty((count, n))
        for j in range(count):
            frames[j] = frame
            frame, triangle = np.linalg.qr(maps[j] @ frame)
            grown[j] = np.abs(np.diag(triangle))
    logs = np.log(np.maximum(grown, 1e-300))
    scales = np.zeros((count, n))
    scales[1:] = np.cumsum(logs - logs.mean(axis=0), axis=0)[:-1]
    scales = np.exp2(np.round(np.clip(scales, -300.0, 300.0) / np.log(2.0)))
    frames = frames * scales[:, None, :]
    ahead = np.roll(np.swapaxes(frames, 1, 2) / scales[:, :, None] ** 2, -1, axis=0)
    spread = np.sqrt(np.square(scales[:, None, :] / np.roll(scales, -1, axis=0)[:, :, None]).sum(axis=(1, 2)))
    rounding = 8.0 * n * EPS * norms(maps)
    return Evened(ahead @ maps @ frames, (errors + rounding) * spread, frames[0])


def solutions(maps: Floats, errors: Floats, scales: Floats) -> Solutions | None:
    """Return independent Floquet solutions from the maps (m, n, n) over segments of a period, without multiplying them.

    Parameters
    ----------
    maps : ndarray (m, n, n)
        Of x / scales.
    errors : ndarray (m,)
        Bounds of their errors in the 2-norm.
    scales : ndarray (n,)

    Returns
    -------
    Solutions or None
        None where eigenvectors cannot be computed accurately enough.
    """
    count, order, _ = maps.shape
    cyclic = np.zeros((count, order, count, order))
    for j, one in enumerate(maps):
        cyclic[(j + 1) % count, :, j] = one
    discs = spectra.eigenvalue_discs(cyclic.reshape(count * order, count * order), float(errors.max()))
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
