"""The coefficients of equations and systems, delayed ones too, as arrays for Hill's matrix."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import DelaySystem, Equation, HillSystem, PeriodicSystem
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
    """Return the arrays of one problem whose coefficients are Fourier series, in a batch of one."""
    omega = np.array([2.0 * math.pi / float(problem.period)])
    if isinstance(problem, Equation):
        (piece,) = problem.pieces()
        halves: Any = np.array(piece.harmonics, dtype=complex).reshape(1, 1, -1, 1, 1) * -0.5
        rates, mean = np.array([[[2.0 * problem.damping]]]), np.array([[[[-float(piece.start)]]]])
        return HillArrays(np.ones((1, 1, 1)), rates, mean, halves, np.zeros((1, 1)), omega, np.zeros(1))
    present = problem.present if isinstance(problem, DelaySystem) else problem
    delayed = problem.delayed if isinstance(problem, DelaySystem) else ()
    sign = 1.0 if isinstance(present, HillSystem) else -1.0
    terms: list[HillSystem | PeriodicSystem] = [present, *(term.coefficient for term in delayed)]
    means = sign * np.array([getattr(term, term.MEAN) for term in terms])
    count = max(len(term.harmonics) for term in terms)
    parts: Complexes = np.zeros((len(terms), count, present.order, present.order), dtype=complex)
    for j, term in enumerate(terms):
        parts[j, : len(term.harmonics)] = 0.5 * sign * term.harmonics
    if isinstance(present, HillSystem):
        mass, rates = mass_matrix(present), velocity_matrix(present)
    else:
        mass, rates = np.zeros((present.order,) * 2), np.eye(present.order)
    delays = np.array([0.0, *(float(term.delay) for term in delayed)])
    error = np.array([len(terms) * float(np.max(getattr(present, "error_norm", present.coefficient_error)))])
    return HillArrays(mass[None], rates[None], means[None], parts[None], delays[None], omega, error)
