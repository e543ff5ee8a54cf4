"""The map over half a period from an instant about which the stiffness is even."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.floquet.systems import spectra
from floquetrod.floquet.systems.classification import classify_pairs, undamped_pairs
from floquetrod.floquet.systems.result import SystemStability
from floquetrod.floquet.verdict import Cost
from floquetrod.kernels.system_draft import flow


def half_period(system: HillSystem | PeriodicSystem, *, rtol: float = 1e-12) -> SystemStability:
    """Classify."""
    pairs = undamped_pairs(system)
    form = pairs[0].even_form if pairs is not None and isinstance(pairs[0], HillSystem) else None
    if form is None:
        raise ValueError("half_period needs a stiffness even about an instant, no G, and damping in proportion to M")
    n, w = system.order, 2.0 * np.pi / system.period
    mean = np.block([[np.zeros((n, n)), np.eye(n)], [-form.stiffness, np.zeros((n, n))]])
    waves = np.zeros((len(form.amplitudes), 2 * n, 2 * n), dtype=complex)
    waves[:, n:, :n] = -form.amplitudes
    v, error, steps = flow(mean, waves, w, 0.5 * system.period, rtol)
    a, b, c, d = v[:n, :n], v[:n, n:], v[n:, :n], v[n:, n:]
    size = float(np.linalg.norm(v, 2))
    error += 0.5 * system.period * float(form.error) * size**2
    symmetric = pairs is not None and isinstance(pairs[0], HillSystem) and pairs[0].is_symmetric
    matrix = b.T @ c if symmetric else _unsymmetric(a, b, c, d)
    discs = spectra.eigenvalue_discs(matrix, 2.0 * error * size)
    stiff = a.T @ c

    def krein(cluster: NDArray[np.intp]) -> int:
        return -spectra.definiteness(discs, cluster, stiff, 2.0 * error * size) if discs else 0

    return classify_pairs(system, "half_period", discs, krein=krein if symmetric else None, cost=Cost(steps, "steps"))


def _unsymmetric(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], d: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return y of a reversible system: the full map's upper left block is 1 + 2 y."""
    n = len(a)
    v = np.block([[a, b], [c, d]])
    mirror = np.diag([1.0] * n + [-1.0] * n)
    full = mirror @ np.linalg.inv(v) @ mirror @ v
    return np.asarray(0.5 * (full[:n, :n] - np.eye(n)))
