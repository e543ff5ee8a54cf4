"""One exponent s + i k w for each Floquet solution, chosen among the eigenvalues of Hill's or of a cyclic matrix.

Each Floquet solution appears many times among such eigenvalues, once for each way of writing it, and the solutions'
states at one instant tell which eigenvalues stand for independent ones.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.floquet.multipliers.classification import LogDiscs
from floquetrod.floquet.multipliers.spectra import log_distances, touching
from floquetrod.floquet.multipliers.symplectic import symplectic_unit

_SINES = (0.5, 0.1, 1e-2, 1e-4, 1e-6)
"""Sines of the angle between a state and the span of the chosen ones, below which it depends on them: tried in turn
(a choice)."""
_ROUNDING = 1e-12  # of a form on a subspace, computed in doubles


class Solutions(NamedTuple):
    """Independent Floquet solutions."""

    logs: Complexes  # (N,), logarithms of the multipliers, their imaginary parts from -pi to pi
    radii: Floats  # (N,), errors of the logarithms
    states: Complexes  # (N, N), states at one instant, unit columns


def independent(states: Complexes, distance: Floats) -> NDArray[np.intp] | None:
    """Return as many independent columns as rows, in the order of ``distance``; None where there are too few."""
    states = states / np.maximum(np.linalg.norm(states, axis=0), 1e-300)
    nearest = np.argsort(distance, kind="stable")
    # Clearly independent ones first: where exponents nearly coincide, the several states of one solution mix with
    # another's and differ a little.
    choices = (_independent(states, nearest, sine) for sine in _SINES)
    return next((chosen for chosen in choices if chosen is not None), None)


def _independent(states: Complexes, nearest: NDArray[np.intp], smallest_sine: float) -> NDArray[np.intp] | None:
    """Return columns whose sine with the span of the columns before exceeds a smallest one; None where too few do."""
    order = len(states)
    basis = np.zeros((order, 0), dtype=np.complex128)
    chosen: list[int] = []
    for i in nearest.tolist():
        rest = states[:, i] - basis @ (basis.conj().T @ states[:, i])
        size = float(np.linalg.norm(rest))
        if size > smallest_sine:
            rest = rest / size
            rest = rest - basis @ (basis.conj().T @ rest)
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
            chosen.append(i)
            if len(chosen) == order:
                return np.array(chosen, dtype=np.intp)
    return None


def principal(logs: Complexes) -> Complexes:
    """Return logarithms with imaginary parts from -pi to pi."""
    return np.asarray(logs.real + 1j * (math.pi - np.remainder(math.pi - logs.imag, 2.0 * math.pi)))


def log_discs(solutions: Solutions, shift: float, *, are_real: bool = True) -> LogDiscs:
    """Return discs about logarithms less ``shift``, touching ones in clusters.

    A multiplier of a real system (``are_real``) whose disc meets the real axis and no other disc is real.
    """
    logs, radii = solutions.logs, solutions.radii
    clusters = touching(log_distances(logs, logs), radii)
    values = logs - shift
    for i in (int(cluster[0]) for cluster in clusters if len(cluster) == 1 and are_real):
        if abs(logs[i].imag) <= radii[i]:
            values[i] = values[i].real
        elif math.pi - abs(logs[i].imag) <= radii[i]:
            values[i] = values[i].real + 1j * math.pi
    return LogDiscs.about(values, radii, clusters)


def krein_sign(solutions: Solutions, cluster: NDArray[np.intp]) -> int:
    """Return the Krein sign of a cluster on the circle of a system in canonical coordinates; 0 where it is not sure."""
    logs, radii, states = solutions
    left = np.linalg.inv(states)
    conditions = np.linalg.norm(left, axis=1)
    others = np.setdiff1d(np.arange(len(logs)), cluster)
    slack = _ROUNDING
    if len(others):
        gap = float(log_distances(logs[cluster], logs[others]).min())
        error = float((radii / conditions).max())
        size = math.sqrt(len(cluster)) * float(np.linalg.norm(left[cluster]) * np.linalg.norm(left[others]))
        slack += 2.0 * size * error / max(gap, 5e-324)
    basis = np.linalg.qr(states[:, cluster])[0]
    values = np.linalg.eigvalsh(basis.conj().T @ (-1j * symplectic_unit(len(logs) // 2)) @ basis)
    return 1 if values[0] > slack else -1 if values[-1] < -slack else 0


def balance(sizes: Floats) -> Floats:
    """Return powers of two d that make diag(1/d) A diag(d) about balanced, for magnitudes of the entries of A."""
    from scipy.linalg.lapack import dgebal  # which `matrix_balance` wraps in six times its time

    floor = 1e-12 * float(sizes.max()) if sizes.any() else 1.0  # entries that vanish would take the scales to infinity
    if not np.isfinite(sizes).all():
        raise ValueError("magnitudes must be finite")
    return np.asarray(dgebal(np.maximum(sizes, floor), scale=1, permute=0)[3])
