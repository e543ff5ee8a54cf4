"""The map over a period of any system."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.floquet.systems import spectra
from floquetrod.floquet.systems.classification import classify_multipliers, classify_pairs, logarithms, undamped_pairs
from floquetrod.floquet.systems.result import SystemStability
from floquetrod.floquet.systems.symplectic import krein_sign, pair_matrix
from floquetrod.floquet.verdict import Cost
from floquetrod.kernels.system_draft import flow


def monodromy(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify."""
    pairs = undamped_pairs(system)
    subject = pairs[0] if pairs else system
    first = subject.as_periodic_system() if isinstance(subject, HillSystem) else subject
    full, error, steps = flow(first.mean, first.harmonics, 2.0 * np.pi / system.period, system.period, rtol)
    size = float(np.linalg.norm(full, 2))
    error += system.period * first.coefficient_error * first.order * size
    cost = Cost(steps, "steps")
    discs = spectra.eigenvalue_discs(full, error)
    if pairs is None:
        return classify_multipliers(system, "monodromy", logarithms(discs) if discs else None, cost=cost)
    n = first.order // 2
    if first.structure != "hamiltonian":
        inverse = np.diag([1.0] * n + [-1.0] * n) @ full @ np.diag([1.0] * n + [-1.0] * n)
        matrix = 0.25 * (full[:n, :n] + inverse[:n, :n]) - 0.5 * np.eye(n)
        return classify_pairs(system, "monodromy", spectra.eigenvalue_discs(matrix, error), cost=cost)
    pair_discs = spectra.eigenvalue_discs(pair_matrix(full), error)

    def krein(cluster: NDArray[np.intp]) -> int:
        return krein_sign(discs, pair_discs, cluster) if discs and pair_discs else 0

    return classify_pairs(system, "monodromy", pair_discs, krein=krein, cost=cost)
