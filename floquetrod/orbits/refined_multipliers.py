"""Multipliers that coincide, or a simple one, by their eigenvectors, with the error that errors of the maps make."""

from __future__ import annotations

import cmath
from collections.abc import Callable

import numpy as np

from floquetrod._util.arrays import Complexes
from floquetrod.orbits.orbit_multipliers import Segments, maps_across


def refined(cluster: Complexes, segments: Segments) -> tuple[Complexes, float]:
    """Return multipliers (k,) that coincide, or one, refined, and about the error of the mean of their logarithms.

    The maps F_i have mu^(1/N) = r as an eigenvalue of the cyclic matrix C that holds them.  With its right eigenvectors
    X = (X_i) and left ones Y, scaled so that Y* X = 1, the multipliers are mu (1 + m / r)^N for the eigenvalues m of
    Y* (C - r) X, and the sum of m changes by the trace of sum Y_(i+1)* E_i X_i where F_i change by E_i (G. W. Stewart
    and J. Sun, Matrix Perturbation Theory, 1990, IV.2 and V.2).  That is far less than what bounds the errors of all
    multipliers at once where some of them decay fast; by as much as that bound, a multiplier of the verdict may differ
    from the eigenvalue of the maps.
    """
    from scipy.sparse import bsr_array, csc_array, identity
    from scipy.sparse.linalg import splu

    maps, errors = maps_across(segments)
    count, n, _ = maps.shape
    sizes = np.exp(np.mean(np.log(np.abs(maps).max(axis=(1, 2)))))
    centre = complex(cluster.mean())
    root = cmath.exp(cmath.log(centre) / count)
    places = np.arange(count)
    cyclic = bsr_array(
        (np.roll(maps, 1, axis=0), np.roll(places, 1), np.arange(count + 1)), shape=(count * n, count * n)
    )
    factors = splu(csc_array(cyclic - (root + 1e-13 * sizes) * identity(count * n, dtype=complex)))
    right = _iterated(factors.solve, count * n, len(cluster))
    left = _iterated(lambda vectors: factors.solve(vectors, trans="H"), count * n, len(cluster))
    left = np.asarray(np.linalg.solve(left.conj().T @ right, left.conj().T).conj().T, dtype=np.complex128)
    x, y = (vectors.reshape(count, n, -1) for vectors in (right, left))
    missed = np.roll(maps @ x, 1, axis=0) - root * x
    offsets = np.linalg.eigvals(left.conj().T @ missed.reshape(right.shape)) / root
    norms = np.linalg.norm(np.roll(y, -1, axis=0), 2, axis=(1, 2)) * np.linalg.norm(x, 2, axis=(1, 2))
    return centre * (1.0 + offsets) ** count, float(count * (norms * errors).sum() / abs(root))


def _iterated(solve: Callable[[Complexes], Complexes], rows: int, count: int) -> Complexes:
    """Return an orthonormal basis (rows, count) of the eigenvectors that inverse iteration finds."""
    vectors = np.cos(np.outer(np.arange(rows), 2.399 + 0.731 * np.arange(count))) + 0.1j
    for _ in range(3):
        vectors = np.linalg.qr(solve(vectors))[0]
    return np.asarray(vectors)
