"""Strong stability by counting: Bott's index of Hamiltonian second-order systems.

N(theta) is the number of negative eigenvalues of -M d^2/dt^2 - G d/dt - K(t) on q(t + T) = exp(i theta) q(t).  As theta
passes a multiplier exp(i theta) N falls by its Krein sign, and no multiplier off the circle changes it.  Where N varies
by n in all between 0 and pi, all n pairs are on the circle, and none meets one of the other sign.
Bott, Comm. Pure Appl. Math. 9 (1956) 171, doi:10.1002/cpa.3160090204.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS
from floquetrod.equations import HillSystem

_MOST_ROWS = 800  # of a matrix (a choice: a second for each angle)


class Counts(NamedTuple):
    """N at angles, in ascending order, of those angles at which it is certain; and the number n of pairs."""

    angles: NDArray[np.float64]
    counts: NDArray[np.intp]
    pairs: int

    @property
    def strongly_stable(self) -> bool:
        """Whether the counts show strong stability."""
        return int(np.abs(np.diff(self.counts)).sum()) == self.pairs

    def krein_sign(self, angles: NDArray[np.float64]) -> int:
        """Return the Krein sign of a cluster of multipliers exp(i angle), all in one half of the circle; 0 if mixed."""
        upper = angles >= 0.0
        if not (upper.all() or not upper.any()):
            return 0
        turned = np.abs(angles)
        below = np.searchsorted(self.angles, turned.min(), side="left") - 1
        above = np.searchsorted(self.angles, turned.max(), side="right")
        if below < 0 or above >= len(self.angles):
            return 0
        jumps = np.diff(self.counts[below : above + 1])
        if int(np.abs(jumps).sum()) != len(angles) or abs(int(jumps.sum())) != len(angles):
            return 0
        return int(-np.sign(jumps.sum())) * (1 if upper.all() else -1)


def count_between(system: HillSystem, angles: NDArray[np.float64]) -> Counts | None:
    """Return N at 0, pi and between the angles of multipliers; None where the matrices would be too large.

    A count is that of the infinite matrix (see `_certain_count`), rounding estimated.
    """
    sorted_angles = np.sort(np.abs(angles))
    edges = np.concatenate([[0.0], sorted_angles, [math.pi]])
    samples = np.unique(np.concatenate([[0.0, math.pi], 0.5 * (edges[1:] + edges[:-1])]))
    cut = _cut(system)
    if cut is None:
        return None
    cuts = [cut + extra for extra in (0, 3, 8, 20) if system.order * (2 * (cut + extra) + 1) <= _MOST_ROWS]
    certain = {}
    for theta in samples.tolist():
        counts = (_certain_count(system, theta, longer) for longer in cuts)
        count = next((count for count in counts if count is not None), None)
        if count is not None:
            certain[theta] = count
    return Counts(np.array(list(certain)), np.array(list(certain.values()), dtype=np.intp), system.order)


def _norm(matrix: NDArray[np.float64] | NDArray[np.complex128] | None) -> float:
    return 0.0 if matrix is None else float(np.linalg.norm(matrix, 2))


def _coupling(system: HillSystem) -> float:
    """Return a bound on the norm of the periodic part of K."""
    return sum(_norm(z) for z in system.harmonics)


def _tail(system: HillSystem, cut: int) -> float:
    """Return a lower bound on the eigenvalues of the part of Hill's matrix beyond the harmonics of number ``cut``."""
    least = 1.0 if system.mass is None else float(np.linalg.eigvalsh(system.mass)[0])
    frequency = (cut + 0.5) * 2.0 * math.pi / float(system.period)
    gyroscopic = _norm(system.gyroscopic)
    if frequency * least <= gyroscopic:
        return -math.inf
    return least * frequency**2 - gyroscopic * frequency - _norm(system.stiffness) - _coupling(system)


def _cut(system: HillSystem) -> int | None:
    """Return the harmonic at which the matrices end; None where they would be too large."""
    wanted = max(_coupling(system), 0.1 * _norm(system.stiffness), 1e-300)
    cut = len(system.harmonics) + 1
    while system.order * (2 * cut + 1) <= _MOST_ROWS:
        if _tail(system, cut) >= wanted:
            return cut
        cut += 1 + cut // 8
    return None


def _certain_count(system: HillSystem, theta: float, cut: int) -> int | None:
    """Return N(theta) of the infinite matrix, None where an eigenvalue cannot be distinguished from 0.

    In blocks [[H, C], [C*, T]] with T >= delta > 0, N is that of H - C T^-1 C* by Sylvester's law; it lies between
    those of H and of H - |C|^2 P / delta, P the projector on the harmonics that C couples.
    """
    matrix = _matrix(system, theta, cut)
    rows = len(matrix)
    slack = 8.0 * EPS * math.sqrt(rows) * float(np.abs(matrix).sum(axis=0).max()) + float(system.error_norm)
    upper = np.linalg.eigvalsh(matrix)
    lowered = matrix.copy()
    reach = system.order * len(system.harmonics)
    edge = np.r_[0:reach, rows - reach : rows]
    lowered[edge, edge] -= _coupling(system) ** 2 / _tail(system, cut)
    lower = np.linalg.eigvalsh(lowered) if reach else upper
    if np.abs(upper).min() <= slack or np.abs(lower).min() <= slack:
        return None
    low, high = int((upper < 0.0).sum()), int((lower < 0.0).sum())
    return low if low == high else None


def _matrix(system: HillSystem, theta: float, cut: int) -> NDArray[np.complex128]:
    """Return the block of Hill's Hermitian matrix of the harmonics -cut to cut."""
    n, period = system.order, float(system.period)
    mass = np.eye(n) if system.mass is None else system.mass
    result = np.zeros((2 * cut + 1, n, 2 * cut + 1, n), dtype=np.complex128)
    for j in range(2 * cut + 1):
        frequency = (theta + 2.0 * math.pi * (j - cut)) / period
        result[j, :, j] = frequency**2 * mass - system.stiffness
        if system.gyroscopic is not None:
            result[j, :, j] -= 1j * frequency * system.gyroscopic
        for m, z in enumerate(system.harmonics[: 2 * cut - j], start=1):
            result[j + m, :, j] -= 0.5 * z
            result[j, :, j + m] -= 0.5 * z.conj()
    return result.reshape((2 * cut + 1) * n, (2 * cut + 1) * n)
