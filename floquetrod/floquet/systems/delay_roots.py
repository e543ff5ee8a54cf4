"""Characteristic roots of systems with delays that nothing varies: the multiples of 2 pi i that a map leaves open."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Complexes
from floquetrod.equations import DelaySystem, HillSystem
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.floquet.systems.classification import LogDiscs

_MOST_TURNS = 4096  # that are tried for each root (a choice)


def per_period(system: DelaySystem, logs: LogDiscs, period: float) -> LogDiscs:
    """Return logarithms over the system's own period, of characteristic roots, from those of a map over another."""
    found = [_root(system, complex(log) / period, period) for log in logs.values]
    roots = np.asarray(found, dtype=np.complex128)
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
    from floquetrod.floquet.systems.delay_maps import rate

    turns = min(_MOST_TURNS, math.ceil(rate(system, max(0.0, -log.real)) * period / (2.0 * math.pi)) + 1)
    tried = np.asarray(log + 2j * math.pi / period * np.arange(-turns, turns + 1), dtype=np.complex128)
    left = np.abs(np.linalg.det(characteristic(system, tried))) / (1.0 + np.abs(tried)) ** (
        system.order * (1 + system.is_second_order)
    )
    found = complex(tried[int(left.argmin())])
    return found.conjugate() if log.imag < 0.0 < found.imag or found.imag < 0.0 < log.imag else found


def characteristic(system: DelaySystem, roots: Complexes) -> Complexes:
    """Return s^2 M + s (C + G) + K + sum_j D_j exp(-s tau_j), or s I - A - sum_j B_j exp(-s tau_j), (m, n, n)."""
    present, s = system.present, roots[:, None, None]
    if isinstance(present, HillSystem):
        found = s**2 * mass_matrix(present) + s * velocity_matrix(present) + present.coefficient(0.0)
        sign = 1.0
    else:
        found, sign = s * np.eye(system.order) - present.coefficient(0.0), -1.0
    for delay, coefficient in system.delayed:
        found = found + sign * np.exp(-s * float(delay)) * coefficient.coefficient(0.0)
    return np.asarray(found)
