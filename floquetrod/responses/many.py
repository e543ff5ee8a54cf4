"""Responses of many scalar equations, or of many systems of one size, at once: amplitudes, means and extremes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod.responses.harmonic_balance import balanced
from floquetrod.responses.hill_arrays import HillArrays, scalar_arrays
from floquetrod.responses.motions import largest_of


@dataclass(frozen=True, eq=False)
class ManyResponses(ByContent):
    """Steady motions of b problems of n coordinates, with an infinite error on a resonance.

    Whether free motion decays they do not say.

    Attributes
    ----------
    amplitudes : ndarray (b, 2 K + 1, n)
        Of exp(i (w + k W) t), k from -K to K.
    error : ndarray (b,)
        Estimate of the error of a coordinate as a fraction of its largest value.
    is_real : bool
        Whether the force has the period of the coefficients, so that motions are real.
    """

    amplitudes: Complexes
    error: Floats
    is_real: bool

    @property
    def mean(self) -> Floats:
        """Means over time (b, n) under a force of the period."""
        return np.asarray(self.amplitudes[:, self.amplitudes.shape[1] // 2].real)

    @cached_property
    def largest(self) -> Floats:
        """Largest magnitude of each coordinate over time, (b, n), a true extreme; NaN on a resonance."""
        flat = np.swapaxes(self.amplitudes, 1, 2).reshape(-1, self.amplitudes.shape[1])
        largest = largest_of(flat, real=self.is_real).reshape(len(self.amplitudes), -1)
        largest[~np.isfinite(self.error)] = np.nan
        return largest


def respond_to_many(
    arrays: HillArrays, force: Complexes, frequency: Floats | None = None, workers: int | None = 1
) -> ManyResponses:
    """Return the responses of many problems, see `floquetrod.responses.harmonic_balance.balanced`."""
    shift = np.zeros(len(force)) if frequency is None else frequency
    return ManyResponses(*balanced(arrays, force, shift, workers=workers), frequency is None)


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
    arrays = scalar_arrays(mean, harmonics, damping, omega)
    forces = np.zeros((len(arrays.omega), 1, 1), dtype=complex)
    forces[:, 0, 0] = force
    return respond_to_many(arrays, forces, workers=workers)
