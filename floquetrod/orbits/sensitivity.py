"""The error of one multiplier, to first order, from the errors of the maps over the intervals of a mesh."""

from __future__ import annotations

import cmath
from collections.abc import Callable

import numpy as np

from floquetrod._util.arrays import Complexes
from floquetrod.orbits.multipliers import Segments, maps_across


def error_of(multiplier: complex, segments: Segments) -> float:
    """Return about the error of a simple multiplier: errors of the maps between its eigenvectors at each instant.

    The maps F_i have mu^(1/N) = r as an eigenvalue of the cyclic matrix that holds them, with right and left
    eigenvectors (x_i) and (y_i): it changes by sum y_(i+1)* E_i x_i / sum y_i* x_i where F_i change by E_i (G. W.
    Stewart and J. Sun, Matrix Perturbation Theory, 1990, IV.2).  That is far less than what bounds the errors of all
    multipliers at once where some of them decay fast.
    """
    from scipy.sparse import bsr_array, csc_array, identity
    from scipy.sparse.linalg import splu

    maps, errors = maps_across(segments)
    count, n, _ = maps.shape
    sizes = np.exp(np.mean(np.log(np.abs(maps).max(axis=(1, 2)))))
    root = cmath.exp(cmath.log(multiplier) / count)
    places = np.arange(count)
    cyclic = bsr_array(
        (np.roll(maps, 1, axis=0), np.roll(places, 1), np.arange(count + 1)), shape=(count * n, count * n)
    )
    shifted = csc_array(cyclic - (root + 1e-13 * sizes) * identity(count * n, dtype=complex))
    factors = splu(shifted)
    right = _iterated(factors.solve, count, n)
    left = _iterated(lambda vector: factors.solve(vector, trans="H"), count, n)
    norms = np.linalg.norm(np.roll(left, -1, axis=0), axis=1) * np.linalg.norm(right, axis=1)
    change = float((norms * errors).sum() / abs((left.conj() * right).sum()))
    return float(count * abs(multiplier) * change / abs(root))


def _iterated(solve: Callable[[Complexes], Complexes], count: int, n: int) -> Complexes:
    """Return the eigenvector (N, n) that inverse iteration finds."""
    vector = np.cos(2.399 * np.arange(count * n)) + 0.1j
    for _ in range(3):
        vector = solve(vector)
        vector = vector / np.abs(vector).max()
    return np.asarray(vector.reshape(count, n))
