"""The leading multipliers of a compact map with errors: of its invariant subspace, all others decay faster."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod.floquet.systems import spectra
from floquetrod.floquet.systems.classification import LogDiscs
from floquetrod.floquet.systems.independent_solutions import balance

_ROUNDING = 8.0 * EPS  # of the map, relative, beside what its eigenvalues add (heuristic)


class Multipliers(NamedTuple):
    """The leading eigenvalues of a map."""

    values: Complexes  # (p,)
    radii: Floats  # (p,), errors as of `spectra.Discs`
    all_values: Complexes  # (S,), every eigenvalue of the map


@np.errstate(over="ignore", invalid="ignore")  # what overflows is then not finite
def leading(matrix: Floats, least: float) -> Multipliers | None:
    """Return the eigenvalues of modulus above ``least``, the largest in any case; None where they cannot be determined.

    With T11 the block of an ordered Schur form of the invariant subspace and P the spectral projector upon it, a change
    E of the map moves T11 by P E to first order, at most |P| |E|: G. W. Stewart, J.-G. Sun, Matrix Perturbation Theory.
    """
    from scipy.linalg import lapack, solve_sylvester

    if not np.isfinite(matrix).all():
        return None
    scales = balance(np.abs(matrix))
    balanced = matrix * scales[None, :] / scales[:, None]
    form, _, real, imaginary, vectors, _, failed = lapack.dgees(lambda *_: False, balanced)
    everything = real + 1j * imaginary
    sizes = np.abs(everything)
    edge = _gap_below(sizes, min(least, 0.999 * float(sizes.max(initial=0.0))))
    if failed or not edge > 0.0:
        return None if failed else Multipliers(np.zeros(1, dtype=complex), np.full(1, _ROUNDING), everything)
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
    return None if discs is None else Multipliers(discs.values, discs.radii, everything)


def _gap_below(sizes: Floats, least: float) -> float:
    """Return a modulus at or below ``least``, in the widest gap of moduli down to half of it."""
    below = np.sort(sizes[(sizes <= least) & (sizes >= 0.5 * least)])[::-1]
    edges = np.concatenate([[least], below, [0.5 * least]])
    gaps = edges[:-1] - edges[1:]
    widest = int(gaps.argmax())
    return float(0.5 * (edges[widest] + edges[widest + 1]))


def with_change(found: Multipliers, before: Complexes) -> Multipliers:
    """Return multipliers whose radii hold twice the distance from those of a coarser mesh, too."""
    change = np.abs(found.values[:, None] - before[None, :]).min(axis=1)
    return found._replace(radii=found.radii + 2.0 * change)


def log_discs(multipliers: Complexes, radii: Floats) -> LogDiscs:
    """Return the logarithms of multipliers, discs that touch in clusters; one of a disc on the real axis is real."""
    clusters = spectra.touching(np.abs(multipliers[:, None] - multipliers[None, :]), radii)
    values = multipliers.copy()
    for i in (int(cluster[0]) for cluster in clusters if len(cluster) == 1):
        if abs(values[i].imag) <= radii[i]:
            values[i] = values[i].real
    return LogDiscs.of(values, radii, clusters)
