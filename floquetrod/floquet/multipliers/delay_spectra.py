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


class LeadingSubspace(NamedTuple):
    """The invariant subspace of the leading eigenvalues of a map, in balanced coordinates."""

    basis: Floats  # (S, p), orthonormal
    block: Floats  # (p, p), the map within the subspace
    largest: float  # modulus of all eigenvalues
    balanced: Floats  # (S, S), the map
    scales: Floats  # (S,), of the states: those given are ``scales`` times balanced ones


class _OrderedForm(NamedTuple):
    """Real Schur form of a balanced map, its leading eigenvalues first."""

    form: Floats
    vectors: Floats
    leading: int  # how many eigenvalues, with the other one of a pair
    spectrum: Complexes  # of the map, in any order
    balanced: Floats
    scales: Floats


def _ordered_form(matrix: Floats, smallest: float, share: float = 0.999) -> _OrderedForm | None:
    """Return the form with eigenvalues above ``smallest`` first, and above a share of the largest; None if it fails."""
    from scipy.linalg import lapack

    scales = balance(np.abs(matrix))
    balanced = matrix * scales[None, :] / scales[:, None]
    form, _, real, imaginary, vectors, _, failed = lapack.dgees(lambda *_: False, balanced)
    spectrum = real + 1j * imaginary
    sizes = np.abs(spectrum)
    edge = _gap_below(sizes, min(smallest, share * float(sizes.max(initial=0.0))))
    count = 0
    if not failed and edge > 0.0:
        lwork = max(1, len(form))
        form, vectors, _, _, count, _, _, failed = lapack.dtrsen(sizes > edge, form, vectors, job="N", lwork=lwork)
    return None if failed else _OrderedForm(form, vectors, int(count), spectrum, balanced, scales)


def leading_subspace(matrix: Floats, share: float) -> LeadingSubspace | None:
    """Return the subspace of eigenvalues of modulus above a share of the largest; None where there is no Schur form."""
    ordered = _ordered_form(matrix, np.inf, share)
    if ordered is None:
        return None
    count, largest = ordered.leading, float(np.abs(ordered.spectrum).max(initial=0.0))
    basis, block = ordered.vectors[:, :count], ordered.form[:count, :count]
    return LeadingSubspace(basis, block, largest, ordered.balanced, ordered.scales)


@np.errstate(over="ignore", invalid="ignore")  # an overflow is then not finite
def leading(matrix: Floats, smallest: float) -> LeadingMultipliers | None:
    """Return the eigenvalues of modulus above ``smallest``, the largest in any case; None where they are too uncertain.

    With T11 the block of an ordered Schur form of the invariant subspace and P the spectral projector upon it, a change
    E of the map moves T11 by P E to first order, at most |P| |E|: G. W. Stewart, J.-G. Sun, Matrix Perturbation Theory.
    """
    from scipy.linalg import solve_sylvester

    ordered = _ordered_form(matrix, smallest) if np.isfinite(matrix).all() else None
    if ordered is None:
        return None
    form, count = ordered.form, ordered.leading
    if not count:
        zero = LeadingMultipliers(np.zeros(1, dtype=complex), np.full(1, _ROUNDING), ordered.spectrum)
        return None if ordered.spectrum.any() else zero
    block, rest, coupling = form[:count, :count], form[count:, count:], form[:count, count:]
    projector = 1.0
    if count < len(form):
        projector = float(np.hypot(1.0, np.linalg.norm(solve_sylvester(block, -rest, coupling), 2)))
    rounding = _ROUNDING + 4.0 * EPS * float(np.sqrt(len(matrix)))
    error = projector * rounding * float(np.linalg.norm(ordered.balanced, 2))
    discs = spectra.diagonalised_discs(block, error)
    return None if discs is None else LeadingMultipliers(discs.values, discs.radii, ordered.spectrum)


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
