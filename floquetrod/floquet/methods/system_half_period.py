"""The map over half a period from an instant about which the stiffness is even: the pairs of multipliers, directly."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet import registry
from floquetrod.floquet.multiplier_pairs import logarithms
from floquetrod.floquet.multipliers import half_period_maps, spectra, whole_period_maps
from floquetrod.floquet.multipliers.classification import classify_pairs, too_long
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Cost

_COST = Cost(1, "half period")


def half_period(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify a system of even stiffness by its map V = [[A, B], [C, D]] over half a period.

    From an instant of evenness, (mu + 1/mu - 2) / 4 are the eigenvalues of B^T C where K is symmetric, and of -Q C,
    Q the upper right block of V^-1, in general: half the integration, half the eigenvalues, and digits kept where
    multipliers meet at 1.

    Parameters
    ----------
    system : HillSystem
        Even about an instant, without gyroscopic matrix, its damping none or C = 2 c M, removed by q = exp(-c t) u.
    rtol : float
        Accuracy required of the map, relative to its size in coordinates that balance position and velocity.

    Returns
    -------
    SystemStability
        Errors follow from a bound on the map's truncation and an estimate of its rounding, times the condition numbers
        of the eigenvalues.

    Raises
    ------
    ValueError
        For other systems.
    """
    if needed := registry.refusal(system, "half_period"):
        raise ValueError(needed)
    return solved_pairs(system, rtol).verdict


class SolvedPairs(NamedTuple):
    """The verdict on an even system, and the solutions it rests upon, without damping; None where there are none."""

    verdict: SystemStability
    discs: spectra.Discs | None = None  # numbers y of the pairs
    pairs: half_period_maps.PairMatrices | None = None

    def fastest(self) -> tuple[complex, float, Complexes, Complexes] | None:
        """Return the largest multiplier, its error, and (u, u') at an instant of evenness of its solution and partner.

        The partner decays by 1 / conj(mu): the same solution backwards.  p = 4 A^T C v / (mu - 1 / mu), v the
        eigenvector.  None where the multipliers could not be computed.
        """
        if self.discs is None or self.pairs is None or not self.discs.right.size:
            return None
        logs = logarithms(self.discs.values)
        i = int(np.abs(logs.real).argmax())
        mu = complex(np.exp(logs[i] if logs[i].real > 0.0 else -logs[i]))
        if mu * mu == 1.0:
            return None
        vector, basis = self.discs.right[:, i], self.pairs.basis[0]
        momentum = 4.0 / (mu - 1.0 / mu) * (self.pairs.form[0] @ vector)
        position, velocity = basis @ vector, np.linalg.solve(basis.T, momentum)
        error = float(self.discs.radii[i]) * abs(4.0 * mu / (mu - 1.0 / mu))  # as mu + 1 / mu = 2 + 4 y
        return mu, error, np.concatenate([position, velocity]), np.concatenate([position, -velocity]).conj()


def solved_pairs(system: HillSystem | PeriodicSystem, rtol: float = 1e-12) -> SolvedPairs:
    """Classify an even system, as `half_period` does, and keep the solutions."""
    subject: Any = (undamped_pairs(system) or (None,))[0]
    rtol = validate.within("rtol", rtol, 1e-15, 0.1)
    seconds, pair_matrices = _in_pieces(subject, rtol) if subject.pieces else _of_series(subject, rtol)
    refused = too_long(system, "half_period", seconds)
    if refused is not None:
        return SolvedPairs(refused)
    matrices = pair_matrices()
    discs = spectra.eigenvalue_discs(matrices.matrix[0], float(matrices.error[0]))
    if discs is None or not matrices.symmetric:
        return SolvedPairs(classify_pairs(system, "half_period", discs, cost=_COST))
    form = -matrices.form[0]

    def times(vectors: Complexes) -> Complexes:
        return np.asarray(form @ vectors.real + 1j * (form @ vectors.imag))  # no complex copy of the form

    krein = spectra.Signs(discs, times, spectra.spectral_norm(form), float(matrices.form_error[0]))
    return SolvedPairs(classify_pairs(system, "half_period", discs, krein=krein, cost=_COST), discs, matrices)


def _of_series(system: HillSystem, rtol: float) -> tuple[float, Callable[[], half_period_maps.PairMatrices]]:
    """Return the seconds that one Fourier series takes, and what computes the matrix of its pairs."""
    form: Any = system.even_form
    arrays = form.stiffness[None], form.amplitudes[None], np.array([float(system.period)])
    seconds = float(half_period_maps.seconds_needed(*arrays)[0])
    return seconds, lambda: half_period_maps.pair_matrices(*arrays, form.error[None], rtol)


def _in_pieces(system: HillSystem, rtol: float) -> tuple[float, Callable[[], half_period_maps.PairMatrices]]:
    """Return the seconds that a stiffness in pieces takes, and what computes the matrix of its pairs."""
    first, start = system.as_periodic_system(), system.even_start or Fraction(0)
    half = by_pieces.exact_period(first) / 2
    pieces, error = by_pieces.from_instant(first, start, half)
    other, _ = by_pieces.from_instant(first, start + half, half)
    seconds = float(whole_period_maps.seconds_needed(pieces)[0])
    return seconds, lambda: half_period_maps.of_pieces(pieces, other, error, rtol, symmetric=system.is_symmetric)
