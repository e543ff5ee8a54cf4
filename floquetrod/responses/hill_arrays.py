"""The coefficients of equations and systems, delayed ones too, as arrays for Hill's matrix."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import DelaySystem, Equation, HillSystem, PeriodicSystem, matrices
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.floquet.problems import Problem


class HillArrays(NamedTuple):
    """M q'' + C q' + sum_d K_d(t) q(t - delay_d) = f of several problems of one size, M = 0 and C = I in first order.

    K_d = means[d] + sum_m halves[d, m-1] exp(i m W t) and conjugates.
    """

    mass: Floats  # (b, n, n)
    rates: Floats  # (b, n, n)
    means: Floats  # (b, D, n, n)
    halves: Complexes  # (b, D, H, n, n)
    delays: Floats  # (b, D), 0 first
    omega: Floats  # (b,)
    error: Floats  # (b,), of K_d(t), entry by entry

    @property
    def reach(self) -> Floats:
        """About the highest frequency (b,), in radians per unit of time, of solutions that do not decay fast."""
        sizes = _norms(self.means).sum(axis=1) + 2.0 * _norms(self.halves).sum(axis=(1, 2))
        if not self.mass.any():
            return np.asarray(sizes / np.maximum(_norms(self.rates), 1e-300) * math.sqrt(self.mass.shape[-1]))
        inverse = 1.0 / self.mass[:, 0, 0] if self.mass.shape[-1] == 1 else _norms(np.linalg.inv(self.mass))
        return np.asarray(np.sqrt(sizes * inverse) + _norms(self.rates) * inverse)


def _norms(array: Any) -> Floats:
    """Return Frobenius norms over the last two axes."""
    if array.shape[-1] == 1:
        return np.asarray(np.abs(array[..., 0, 0]))
    return np.asarray(np.sqrt((array.real**2 + array.imag**2).sum(axis=(-2, -1))))


def hill_arrays(problem: Problem) -> HillArrays:
    """Return the arrays of a problem of Fourier series, or of a batch of such systems, flat in the order of C."""
    if isinstance(problem, Equation):
        (piece,) = problem.pieces()
        harmonics = np.array(piece.harmonics, dtype=complex)[None]
        return scalar_arrays(float(piece.start), harmonics, problem.damping, 2.0 * math.pi / float(problem.period))
    present = problem.present if isinstance(problem, DelaySystem) else problem
    delayed = problem.delayed if isinstance(problem, DelaySystem) else ()
    sign, n, size = 1.0 if isinstance(present, HillSystem) else -1.0, present.order, math.prod(present.shape)
    terms: list[HillSystem | PeriodicSystem] = [present, *(term.coefficient for term in delayed)]

    def flat(array: Any, tail: int = 2) -> Any:
        return matrices.flat(array, present.shape, tail)

    means = sign * np.stack([flat(getattr(term, term.MEAN)) for term in terms], axis=1)
    count = max(term.harmonics.shape[-3] for term in terms)
    halves: Complexes = np.zeros((size, len(terms), count, n, n), dtype=complex)
    for j, term in enumerate(terms):
        halves[:, j, : term.harmonics.shape[-3]] = 0.5 * sign * flat(term.harmonics, 3)
    if isinstance(present, HillSystem):
        mass, rates = flat(mass_matrix(present)), flat(velocity_matrix(present))
    else:
        mass, rates = np.zeros((size, n, n)), np.tile(np.eye(n), (size, 1, 1))
    delays = np.tile([0.0, *(float(term.delay) for term in delayed)], (size, 1))
    omega = 2.0 * math.pi / flat(np.asarray(present.period, dtype=float), 0)
    error = np.full(size, len(terms) * float(np.max(getattr(present, "error_norm", present.coefficient_error))))
    return HillArrays(mass, rates, means, halves, delays, omega, error)


def scalar_arrays(mean: Any, harmonics: Any, damping: Any, omega: Any) -> HillArrays:
    """Return the arrays of A'' + 2 c A' = (mean + sum_k Re(Z_k exp(i k W t))) A + f, with W = ``omega``.

    ``harmonics`` are Z_k (b, H); ``mean``, ``damping`` and ``omega`` (b,) broadcast.
    """
    waves = np.asarray(harmonics, dtype=complex)
    numbers = (np.asarray(value, dtype=float) for value in (mean, damping, omega))
    mean, damping, omega, _ = (np.array(each) for each in np.broadcast_arrays(*numbers, np.empty(len(waves))))
    batch = len(mean)
    halves: Any = -0.5 * np.broadcast_to(waves, (batch, waves.shape[-1])).reshape(batch, 1, -1, 1, 1)
    return HillArrays(
        np.ones((batch, 1, 1)),
        2.0 * damping.reshape(batch, 1, 1),
        -mean.reshape(batch, 1, 1, 1),
        halves,
        np.zeros((batch, 1)),
        omega,
        np.zeros(batch),
    )
