"""The count of the eigenvalues of Hill's matrices below zero, which says in which tongue an equation lies."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS

MOST_ROWS = 250
"""Rows of a banded matrix beyond which nothing is counted (a choice: a few seconds of work)."""


class HillCount(NamedTuple):
    """Periodic and antiperiodic eigenvalues of -u'' + p u below zero, and the work done for their count."""

    below: int | None  # how many there are; None where one cannot be distinguished from zero, or nothing was counted
    cut: int  # K, the harmonics of the largest matrix
    rows: int  # of all matrices
    is_too_large: bool  # whether more than `MOST_ROWS` rows would be needed


def hill_count(mean: float, harmonics: NDArray[Any], turn: float) -> HillCount:
    """Return the count for p = mean + sum_k Re(z_k exp(-i k W tau)), z_k the ``harmonics`` (n,), W = ``turn``.

    N(H_K) and N(H_K - C C* / delta) are computed (head of `methods.spectral`), with K doubled until both agree, from
    where ((K + 1) W)^2 exceeds the coefficient.  The conjugates of all harmonics reverse time, and give the same
    count.
    """
    bound = float(np.abs(harmonics).sum())
    cut = math.ceil(math.sqrt(abs(mean) + 2.0 * bound) / turn) + len(harmonics) + 8
    rows = 0
    while 2 * cut + 2 <= MOST_ROWS:
        below, settled = _banded_count(mean, harmonics, bound, turn, cut)
        rows += 4 * cut
        if below is not None or not settled:
            return HillCount(below, cut, rows, is_too_large=False)
        cut *= 2
    return HillCount(None, cut, rows, is_too_large=True)


def _bands(mean: float, harmonics: NDArray[Any], frequencies: NDArray[Any], correction: float) -> NDArray[Any]:
    """Return the lower bands of H, less C C* times ``correction`` at both ends."""
    size, width = len(frequencies), len(harmonics)
    bands = np.zeros((width + 1, size), dtype=np.complex128)
    bands[0] = frequencies**2 + mean
    for j in range(1, width + 1):
        bands[j, : size - j] = 0.5 * harmonics[j - 1]
    if correction > 0.0 and width:
        # C couples the last `width` rows to the rows beyond; C C* is the Gram matrix of those couplings.
        couplings = np.zeros((width, width), dtype=np.complex128)
        for row in range(width):
            for j in range(row + 1, width + 1):
                couplings[width - 1 - row, j - row - 1] = 0.5 * np.conj(harmonics[j - 1])
        gram = couplings @ couplings.conj().T * correction
        for i in range(width):
            for j in range(i + 1):
                bands[i - j, size - width + j] -= gram[i, j]
                # The other end is the mirror image: row r from the end there couples with conjugate amplitudes.
                bands[i - j, width - 1 - i] -= gram[i, j]
    return bands


def _banded_count(mean: float, harmonics: NDArray[Any], bound: float, turn: float, cut: int) -> tuple[int | None, bool]:
    """Return the exact count of eigenvalues below zero (None if the ends differ) and whether none is close to zero."""
    from scipy.linalg import eigvals_banded

    delta = ((cut + 0.5) * turn) ** 2 + mean - bound
    if delta <= 0.0:
        return None, True
    counts = []
    for correction in (0.0, 1.0 / delta):
        total = 0
        for frequencies in (np.arange(-cut, cut + 1.0) * turn, (np.arange(-cut, cut) + 0.5) * turn):
            values = eigvals_banded(_bands(mean, harmonics, frequencies, correction), lower=True)
            norm = max(abs(values[0]), abs(values[-1]))
            if np.abs(values).min() <= len(values) * EPS * norm:
                return None, False
            total += int((values < 0.0).sum())
        counts.append(total)
    return (counts[0] if counts[0] == counts[1] else None), True
