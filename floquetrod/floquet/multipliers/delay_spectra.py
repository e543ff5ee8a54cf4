"""The leading multipliers of a compact map, with errors, from the invariant subspace that decays most slowly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.multipliers.classification import LogDiscs
from floquetrod.floquet.multipliers.independent_solutions import balance

_ROUNDING = 8.0 * EPS  # of the map, relative, beside the rounding of its eigenvalues (heuristic)


class LeadingMultipliers(NamedTuple):
    """The leading eigenvalues of a map."""

    values: Complexes  # (p,)
    radii: Floats  # (p,), errors as of `spectra.Discs`
    all_values: Complexes  # (S,), every eigenvalue of the map


@np.errstate(over="ignore", invalid="ignore")  # an overflow is then not finite
def leading(matrix: Floats, smallest: float) -> LeadingMultipliers | None:
    """Return the eigenvalues of modulus above ``smallest``, the largest in any case; None where they are too uncertain.

    With T11 the block of an ordered Schur form of the invariant subspace and P the spectral projector upon it, a change
    E of the map moves T11 by P E to first order, at most |P| |E|: G. W. Stewart, J.-G. Sun, Matrix Perturbation Theory.
    """
    from scipy.linalg import lapack, solve_sylvester

    if not np.isfinite(matrix).all():
        return None
    scales = balance(np.abs(matrix))
    balanced = matrix * scales[None, :] / scales[:, None]
    form, _, real, imaginary, vectors, _, failed = lapack.dgees(lambda *_: False, balanced)
    spectrum = real + 1j * imaginary
    sizes = np.abs(spectrum)
    edge = _gap_below(sizes, min(smallest, 0.999 * float(sizes.max(initial=0.0))))
    if failed or not edge > 0.0:
        return None if failed else LeadingMultipliers(np.zeros(1, dtype=complex), np.full(1, _ROUNDING), spectrum)
    form, _, _, _, count, _, _, failed = lapack.dtrsen(sizes > edge, form, vectors, job="N", lwork=max(1, len(form)))
    if failed or not count:
        return None
    block, rest, coupling = form[:count, :count], form[count:, count:], form[:count, count:]
    projector = 1.0
    if count < len(form):
        projector = float(np.hypot(1.0, np.linalg.norm(solve_sylvester(block, -rest, coupling), 2)))
    rounding = _ROUNDING + 4.0 * EPS * float(np.sqrt(len(matrix)))
    error = projector * rounding * float(np.linalg.norm(balanced, 2))
    discs = spectra.diagonalised_discs(block, error)
    return None if discs is None else LeadingMultipliers(discs.values, discs.radii, spectrum)


def _gap_below(sizes: Floats, smallest: float) -> float:
    """Return a modulus at or below ``smallest``, in the widest gap of moduli down to half of it."""
    below = np.sort(sizes[(sizes <= smallest) & (sizes >= 0.5 * smallest)])[::-1]
    edges = np.concatenate([[smallest], below, [0.5 * smallest]])
    gaps = edges[:-1] - edges[1:]
    widest = int(gaps.argmax())
    return float(0.5 * (edges[widest] + edges[widest + 1]))


def with_change(fine: LeadingMultipliers, coarse: Complexes) -> LeadingMultipliers:
    """Return multipliers with radii larger by twice their distance from the multipliers of a coarser mesh."""
    change = np.abs(fine.values[:, None] - coarse[None, :]).min(axis=1)
    return fine._replace(radii=fine.radii + 2.0 * change)


def log_discs(multipliers: Complexes, radii: Floats) -> LogDiscs:
    """Return the logarithms of multipliers, touching discs in clusters; a lone disc on the real axis has a real one."""
    clusters = spectra.touching(np.abs(multipliers[:, None] - multipliers[None, :]), radii)
    values = multipliers.copy()
    for i in (int(cluster[0]) for cluster in clusters if len(cluster) == 1):
        if abs(values[i].imag) <= radii[i]:
            values[i] = values[i].real
    return LogDiscs.of(values, radii, clusters)
