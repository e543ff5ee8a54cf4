"""The map over a period of any system, by Taylor series."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.hill_system import in_first_order
from floquetrod.floquet.kernels.system_maps_large import large_seconds, period_map_large
from floquetrod.floquet.multipliers import spectra, symplectic, whole_period_maps
from floquetrod.floquet.multipliers.classification import (
    LogDiscs,
    classify_multipliers,
    classify_pairs,
    classify_unitary,
    too_long,
)
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Cost

_COST = Cost(1, "period")
_SEVERAL = 9  # equations: for as many or more, the interpreted kernel takes 10 to 100 times as long as numpy's products
_MANY = 48
"""Number of equations for which, as for more, the eigenvalues of the map are computed, not those of pairs.

Pairs take a quarter less time; but some of so many may be so close that they lose up to eight digits (measured).
"""


def monodromy(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify a system by its map over a period.

    Where multipliers come in mu, 1 / mu, the numbers mu + 1/mu are computed, each once, which keeps digits where
    multipliers meet at 1 or -1: of a symplectic map S by reducing S + S^-1 to block triangular form, of a reversible
    one as the eigenvalues of a block.  Of 48 equations q'' + K(t) q = 0 or more, K symmetric, the multipliers
    themselves are: some of so many pairs may be so close that the reduction would lose most digits.  A complex system
    is integrated as the real one of twice the order; its map is then a complex matrix, with the multipliers of the
    system alone.  Where the norm is kept, the map is unitary, and eigenvalues have no error but the map's.

    Parameters
    ----------
    system : HillSystem or PeriodicSystem
        Uniform damping C = 2 c M is removed by q = exp(-c t) u.
    rtol : float
        Accuracy required of the map, relative to its size in balanced coordinates.

    Returns
    -------
    SystemStability
        Errors follow from a bound on the map's truncation and an estimate of its rounding, times the condition numbers
        of the eigenvalues.

    Raises
    ------
    TypeError, ValueError
        For an accuracy outside 1e-15 to 0.1.
    """
    rtol = validate.within("rtol", rtol, 1e-15, 0.1)
    many = solved_many(system, rtol)
    if many is not None:
        return many.verdict
    pairs = undamped_pairs(system)
    subject = pairs[0] if pairs else system
    first = in_first_order(subject)
    reversible = pairs is not None and subject.structure == "reversible"
    start = _even_start(subject) if reversible and isinstance(subject, HillSystem) else Fraction(0)
    pieces, uncertainty = by_pieces.from_instant(first, start, by_pieces.exact_period(first))
    refused = too_long(system, "monodromy", float(whole_period_maps.seconds_needed(pieces)[0]))
    if refused is not None:
        return refused
    unitary = isinstance(system, PeriodicSystem) and system.keeps_norm
    if pairs is not None and not unitary and not reversible and _are_oscillators(first, _SEVERAL):
        full, error, _ = _map_of_many(first, rtol)
    else:
        maps = whole_period_maps.period_maps(pieces, uncertainty, rtol, paired=pairs is not None and not unitary)
        maps = whole_period_maps.of_complex(maps) if first.is_complex else maps
        # In coordinates in which the norm is kept; rows and columns of such an A are balanced as they are.
        maps = whole_period_maps.in_scaling(maps, np.ones(maps.scaling.shape)) if unitary else maps
        full, error = maps.matrix[0], float(maps.error[0])
    if unitary:
        return classify_unitary(system, "monodromy", spectra.normal_discs(full, error), cost=_COST)
    if pairs is None:
        discs = spectra.eigenvalue_discs(full, error)
        return classify_multipliers(system, "monodromy", LogDiscs.of(*discs[:3]) if discs else None, cost=_COST)
    if reversible:
        block = spectra.eigenvalue_discs(symplectic.reversible_pair_matrix(full), error)
        return classify_pairs(system, "monodromy", block, cost=_COST)
    reduced = symplectic.pair_matrix(full, error)
    discs = spectra.eigenvalue_discs(reduced.matrix, reduced.error, reduced.eigen)
    krein = None if discs is None else symplectic.krein_signs(reduced, discs)
    return classify_pairs(system, "monodromy", discs, krein=krein, cost=_COST)


def _even_start(system: HillSystem) -> Fraction:
    """Return an instant of evenness: only from there on is the map reversible."""
    form = system.even_form
    return system.even_start or Fraction(0) if form is None else Fraction(float(form.start)) % Fraction(system.period)


def _are_oscillators(first: PeriodicSystem, fewest: int) -> bool:
    """Return whether a system is q'' + K(t) q = 0, K symmetric and without jumps, of enough equations."""
    return (
        first.is_smooth and first.order >= 2 * fewest and whole_period_maps.is_oscillators(first.mean, first.harmonics)
    )


def _coefficients(first: PeriodicSystem) -> tuple[Floats, Complexes]:
    """Return the mean of K and its harmonics."""
    n = first.order // 2
    return -first.mean[n:, :n], -first.harmonics[:, n:, :n]


def _map_of_many(first: PeriodicSystem, rtol: float) -> tuple[Floats, float, Floats]:
    """Return the map over a period of oscillators, its error, and its coordinates."""
    error = first.order // 2 * first.coefficient_error
    return period_map_large(*_coefficients(first), float(first.period), error, rtol)


class SolvedMany(NamedTuple):
    """The verdict on many equations, and the solutions that it rests upon, without damping, where there are any."""

    verdict: SystemStability
    discs: spectra.Discs | None  # multipliers and eigenvectors (v, p) of the map
    basis: Floats  # (n, n), u = basis v and u' = basis^-T p

    def fastest(self) -> tuple[complex, float, Complexes, Complexes] | None:
        """Return the largest multiplier, its error, and (u, u') at the beginning of its solution and of its partner.

        The partner decays by 1 / conj(mu).  None where the multipliers could not be computed.
        """
        if self.discs is None or not self.discs.right.size:
            return None
        values = self.discs.values
        i = int(np.abs(values).argmax())
        mu = complex(values[i])
        partner = int(np.abs(values * np.conj(mu) - 1.0).argmin())
        positions, momenta = np.split(self.discs.right[:, [i, partner]], 2)
        states = np.concatenate([self.basis @ positions, np.linalg.solve(self.basis.T, momenta)])
        return mu, float(self.discs.radii[i]), states[:, 0], states[:, 1]


def solved_many(system: HillSystem | PeriodicSystem, rtol: float = 1e-12) -> SolvedMany | None:
    """Classify many equations q'' + K(t) q = 0, damping removed, with K symmetric, by the eigenvalues of their map.

    None for other systems; ``rtol`` as for `monodromy`.
    """
    subject, damping = undamped_pairs(system) or (None, 0.0)
    if subject is None:
        return None
    first = in_first_order(subject)
    if not _are_oscillators(first, _MANY):
        return None
    period = float(first.period)
    refused = too_long(system, "monodromy", large_seconds(*_coefficients(first), period))
    if refused is not None:
        return SolvedMany(refused, None, np.eye(first.order // 2))
    full, error, basis = _map_of_many(first, rtol)
    discs = spectra.eigenvalue_discs(full, error)
    logs = krein = None
    if discs is not None:
        logs = LogDiscs.of(*discs[:3], damping * period)
        krein = spectra.Signs(discs, symplectic.krein_form, 1.0, 0.0)
    return SolvedMany(classify_multipliers(system, "monodromy", logs, krein=krein, cost=_COST), discs, basis)
