"""The map over a period of any system, by Taylor series."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.kernels.system_maps_large import large_seconds, period_map_large
from floquetrod.floquet.systems import spectra, symplectic, whole
from floquetrod.floquet.systems.classification import (
    classify_multipliers,
    classify_pairs,
    logarithms,
    too_long,
    undamped_pairs,
)
from floquetrod.floquet.systems.result import SystemStability
from floquetrod.floquet.verdict import Cost

_COST = Cost(1, "period")
_MANY = 100  # equations: for as many or more, the eigenvalues of the map are computed, not those of pairs (a choice)


def monodromy(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify a system by its map over a period.

    Where multipliers come in mu, 1 / mu, the numbers mu + 1/mu are computed, each once, which keeps digits where
    multipliers meet at 1 or -1: of a symplectic map S by reducing S + S^-1 to block triangular form, of a reversible
    one as those of a block.  Of 100 equations q'' + K(t) q = 0 or more, K symmetric, the multipliers themselves are:
    the reduction would take longer than all else.

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
    """
    rtol = validate.within("rtol", rtol, 1e-15, 0.1)
    pairs = undamped_pairs(system)
    subject = pairs[0] if pairs else system
    first = subject.as_periodic_system() if isinstance(subject, HillSystem) else subject
    reversible = pairs is not None and subject.structure == "reversible"
    start = _even_start(subject) if reversible and isinstance(subject, HillSystem) else Fraction(0)
    if pairs and first.is_smooth and first.order >= 2 * _MANY and whole.is_oscillators(first.mean, first.harmonics):
        return _many(system, first, pairs[1], rtol)
    pieces, uncertainty = by_pieces.from_instant(first, start, by_pieces.exact_period(first))
    refused = too_long(system, "monodromy", float(whole.seconds_needed(pieces)[0]))
    if refused is not None:
        return refused
    maps = whole.period_maps(pieces, uncertainty, rtol, paired=pairs is not None)
    full, error = maps.matrix[0], float(maps.error[0])
    discs = spectra.eigenvalue_discs(full, error)
    if pairs is None:
        return classify_multipliers(system, "monodromy", logarithms(discs) if discs else None, cost=_COST)
    if reversible:
        block = spectra.eigenvalue_discs(symplectic.reversible_pair_matrix(full), error)
        return classify_pairs(system, "monodromy", block, cost=_COST)
    found = spectra.eigenvalue_discs(*symplectic.pair_matrix(full, error))

    def krein(cluster: NDArray[np.intp]) -> int:
        return symplectic.krein_sign(discs, found, cluster) if discs and found else 0

    return classify_pairs(system, "monodromy", found, krein=krein, cost=_COST)


def _even_start(system: HillSystem) -> Fraction:
    """Return an instant of evenness: only from there on is the map reversible."""
    form = system.even_form
    return system.even_start or Fraction(0) if form is None else Fraction(float(form.start)) % Fraction(system.period)


def _many(system: HillSystem | PeriodicSystem, first: PeriodicSystem, damping: float, rtol: float) -> SystemStability:
    """Classify many equations, freed of damping q'' + K(t) q = 0 with K symmetric, by the eigenvalues of their map."""
    n, period = first.order // 2, float(first.period)
    stiffness, harmonics = -first.mean[n:, :n], -first.harmonics[:, n:, :n]
    refused = too_long(system, "monodromy", large_seconds(stiffness, harmonics, period))
    if refused is not None:
        return refused
    discs = spectra.eigenvalue_discs(*period_map_large(stiffness, harmonics, period, n * first.coefficient_error, rtol))
    if discs is None:
        return classify_multipliers(system, "monodromy", None, cost=_COST)
    krein = spectra.signs(discs, symplectic.krein_form, 1.0, 0.0)
    return classify_multipliers(system, "monodromy", logarithms(discs, damping * period), krein=krein, cost=_COST)
