"""Characteristic roots of systems with delays and constant coefficients: the multiples of 2 pi i a map leaves open."""

from __future__ import annotations

import math
from typing import Any

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


def characteristic(system: DelaySystem, roots: Complexes, rate: bool = False) -> Any:
    """Return s^2 M + s (C + G) + K + sum_j D_j exp(-s tau_j), or s I - A - sum_j B_j exp(-s tau_j), (m, n, n).

    With ``rate`` also its derivative by s.
    """
    present, s = system.present, roots[:, None, None]
    if isinstance(present, HillSystem):
        mass, velocity = mass_matrix(present), velocity_matrix(present)
        matrix, slope, sign = s**2 * mass + s * velocity + present.coefficient(0.0), 2.0 * s * mass + velocity, 1.0
    else:
        one = np.eye(system.order)
        matrix, slope, sign = s * one - present.coefficient(0.0), one + 0.0 * s, -1.0
    for delay, coefficient in system.delayed:
        term = sign * np.exp(-s * float(delay)) * coefficient.coefficient(0.0)
        matrix, slope = matrix + term, slope - float(delay) * term
    return (matrix, slope) if rate else np.asarray(matrix)
