"""Characteristic roots of systems with delays and constant coefficients: the multiples of 2 pi i a map leaves open."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Complexes
from floquetrod.equations import DelaySystem, HillSystem
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.floquet.multipliers.classification import LogDiscs

_MOST_TURNS = 4096  # multiples tried for each root (a choice)


def per_period(system: DelaySystem, logs: LogDiscs, period: float) -> LogDiscs:
    """Return the characteristic roots times the system's period, from logarithms of a map over another ``period``."""
    exponents = [_root(system, complex(log) / period, period) for log in logs.values]
    roots = np.asarray(exponents, dtype=np.complex128)
    ratio = float(system.period) / period
    return LogDiscs(
        np.asarray(roots * complex(system.period)),
        logs.low * ratio,
        logs.high * ratio,
        logs.radii * ratio,
        logs.clusters,
    )


def _root(system: DelaySystem, log: complex, period: float) -> complex:
    """Return log + 2 pi i k / period for the k at which the characteristic determinant is smallest for its size."""
    from floquetrod.floquet.multipliers.delay_maps import rate

    turns = min(_MOST_TURNS, math.ceil(rate(system, max(0.0, -log.real)) * period / (2.0 * math.pi)) + 1)
    candidates = np.asarray(log + 2j * math.pi / period * np.arange(-turns, turns + 1), dtype=np.complex128)
    residuals = np.abs(np.linalg.det(characteristic(system, candidates))) / (1.0 + np.abs(candidates)) ** (
        system.order * (1 + system.is_second_order)
    )
    root = complex(candidates[int(residuals.argmin())])
    return root.conjugate() if log.imag < 0.0 < root.imag or root.imag < 0.0 < log.imag else root


def characteristic(system: DelaySystem, roots: Complexes) -> Complexes:
    """Return s^2 M + s (C + G) + K + sum_j D_j exp(-s tau_j), or s I - A - sum_j B_j exp(-s tau_j), (m, n, n)."""
    present, s = system.present, roots[:, None, None]
    if isinstance(present, HillSystem):
        matrix = s**2 * mass_matrix(present) + s * velocity_matrix(present) + present.coefficient(0.0)
        sign = 1.0
    else:
        matrix, sign = s * np.eye(system.order) - present.coefficient(0.0), -1.0
    for delay, coefficient in system.delayed:
        matrix = matrix + sign * np.exp(-s * float(delay)) * coefficient.coefficient(0.0)
    return np.asarray(matrix)
