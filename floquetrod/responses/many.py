"""Responses of many scalar equations, or of many systems of one size, at once: amplitudes, means and extremes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem, PeriodicSystem, matrices
from floquetrod.equations.matrices import mass_matrix, velocity_matrix
from floquetrod.responses.harmonic_balance import balanced
from floquetrod.responses.hill_arrays import HillArrays
from floquetrod.responses.motions import largest_of


class ManyResponses(NamedTuple):
    """Steady motions of b problems of n coordinates; NaN, and an infinite error, on a resonance.

    Whether free motion decays they do not say.
    """

    amplitudes: Complexes
    """Amplitudes (b, 2 K + 1, n) of exp(i (w + k W) t), k from -K to K."""
    largest: Floats
    """Largest magnitude of each coordinate over time, (b, n): a true extreme."""
    error: Floats
    """Estimate (b,) of the error of a coordinate as a fraction of its largest value."""

    @property
    def mean(self) -> Floats:
        """Means over time (b, n) under a force of the period."""
        return np.asarray(self.amplitudes[:, self.amplitudes.shape[1] // 2].real)


def respond_to_many(
    arrays: HillArrays, force: Complexes, frequency: Floats | None = None, workers: int | None = 1
) -> ManyResponses:
    """Return the responses of many problems, see `floquetrod.responses.harmonic_balance.balanced`."""
    shift = np.zeros(len(force)) if frequency is None else frequency
    amplitudes, error = balanced(arrays, force, shift, workers=workers)
    flat = np.swapaxes(amplitudes, 1, 2).reshape(-1, amplitudes.shape[1])
    largest = largest_of(flat, real=frequency is None).reshape(len(force), -1)
    largest[~np.isfinite(error)] = np.nan
    return ManyResponses(amplitudes, largest, error)


def scalar_responses(
    mean: Any, harmonics: Any, damping: Any, omega: Any, force: Any, workers: int | None = 1
) -> ManyResponses:
    """Return the periodic responses of A'' + 2 c A' = (mean + sum_k Re(Z_k exp(i k W t))) A + force.

    Parameters
    ----------
    mean, damping, omega, force : array_like (b,)
        They broadcast; W = ``omega`` is 2 pi over the period, and the force is constant.
    harmonics : array_like (b, H)
        Complex Z_k: -1j alpha for alpha sin W t, alpha for alpha cos W t.
    workers : int or None
        Threads; None for all cores.
    """
    mean, damping, omega, force = np.broadcast_arrays(
        *(np.asarray(v, dtype=float) for v in (mean, damping, omega, force))
    )
    waves = np.asarray(harmonics, dtype=complex)
    waves = np.broadcast_to(waves, (mean.size, waves.shape[-1]))
    batch = mean.size

    def each(values: Any) -> Any:
        return np.ascontiguousarray(values).reshape(batch, 1, 1)

    arrays = HillArrays(
        np.ones((batch, 1, 1)),
        2.0 * each(damping),
        -each(mean)[:, None],
        np.asarray(-0.5 * waves.reshape(batch, 1, -1, 1, 1)),
        np.zeros((batch, 1)),
        np.ascontiguousarray(omega).reshape(batch),
        np.zeros(batch),
    )
    return respond_to_many(arrays, each(force).astype(complex), workers=workers)


def system_arrays(systems: HillSystem | PeriodicSystem) -> HillArrays:
    """Return the arrays of a batch of systems, each one Fourier series, flat in the order of C."""
    size, n = math.prod(systems.shape), systems.order

    def flat(array: Any, tail: int = 2) -> Any:
        return matrices.flat(array, systems.shape, tail)

    sign = 1.0 if isinstance(systems, HillSystem) else -1.0
    means = sign * flat(getattr(systems, systems.MEAN))[:, None]
    halves: Complexes = 0.5 * sign * flat(systems.harmonics, 3)[:, None]
    if isinstance(systems, HillSystem):
        mass, rates = flat(mass_matrix(systems)), flat(velocity_matrix(systems))
    else:
        mass, rates = np.zeros((size, n, n)), np.broadcast_to(np.eye(n), (size, n, n))
    omega = 2.0 * math.pi / flat(np.asarray(systems.period, dtype=float), 0)
    error = np.full(size, float(np.max(getattr(systems, "error_norm", systems.coefficient_error))))
    return HillArrays(mass, rates, means, halves, np.zeros((size, 1)), omega, error)
