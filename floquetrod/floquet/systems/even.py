"""From maps over half a period of even systems to the matrices whose eigenvalues are the pairs, with errors."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.kernels.system_even import HalfPeriodMap, half_period_map

_EPS = 2.220446049250313e-16


class PairMatrices(NamedTuple):
    """Matrices of many even systems.

    Attributes
    ----------
    matrix : ndarray (b, n, n)
        Its eigenvalues are (mu + 1/mu - 2) / 4.
    error : ndarray (b,)
        Its error, in the 2-norm.
    form : ndarray (b, n, n)
        The symmetric form with which it is self-adjoint; it is negative on eigenvectors of Krein sign +1.
    form_error : ndarray (b,)
        Its error, in the 2-norm.
    symmetric : bool
        Whether the stiffness is; else there is no form.
    """

    matrix: NDArray[np.float64]
    error: NDArray[np.float64]
    form: NDArray[np.float64]
    form_error: NDArray[np.float64]
    symmetric: bool


def seconds_needed(stiffness: Any, amplitudes: Any, period: Any) -> NDArray[np.float64]:
    """Return about how long the map of each system takes (b,), in seconds: measured on one core of 2024."""
    n = stiffness.shape[-1]
    phase = 0.5 * period * np.sqrt(_norm(stiffness) + _norm(amplitudes).sum(axis=-1))
    return np.asarray(phase * (1e-6 + 3e-7 * n * n))


def pair_matrices(
    stiffness: Any, amplitudes: Any, period: Any, doubt: Any, rtol: float, workers: int | None = 1
) -> PairMatrices:
    """Return the matrices of u'' + (S + sum_k A_k cos k w t) u = 0, S and A known up to ``doubt`` in the 2-norm."""
    half = half_period_map(stiffness, amplitudes, period, rtol, workers)
    with np.errstate(over="ignore", invalid="ignore"):  # of maps that overflow, whose errors are then not finite
        return _numbers(half, period, doubt)


def _numbers(half: HalfPeriodMap, period: Any, doubt: Any) -> PairMatrices:
    """Return the matrices that follow from maps over half a period."""
    n = half.a.shape[-1]
    size = _norm(np.concatenate([np.concatenate([half.a, half.b], -1), np.concatenate([half.c, half.d], -1)], -2))
    error = half.error + 0.5 * period * doubt * (_norm(half.basis) * size) ** 2
    if half.symmetric:
        left, left_error = np.swapaxes(half.b, -1, -2), error
    else:
        whole = np.block([[half.a, half.b], [half.c, half.d]])
        finite = np.isfinite(whole).all(axis=(-2, -1), keepdims=True)
        inverse = np.linalg.inv(np.where(finite, whole, np.eye(2 * n)))
        left = -inverse[..., :n, n:]
        reach = _norm(inverse)
        with np.errstate(divide="ignore", invalid="ignore"):
            left_error = np.where(reach * error < 0.5, 2.0 * reach**2 * (error + 4.0 * n * _EPS * size), np.inf)
    small, large = _norm(left), _norm(half.c)
    upper = _norm(half.a)
    form = np.swapaxes(half.a, -1, -2) @ half.c
    with np.errstate(invalid="ignore"):  # zero times infinity is not known either
        slip = small * error + large * left_error + error * left_error + n * _EPS * small * large
        form_slip = (upper + large) * error + error**2 + n * _EPS * upper * large
    return PairMatrices(left @ half.c, slip, 0.5 * (form + np.swapaxes(form, -1, -2)), form_slip, half.symmetric)


def _norm(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Frobenius norms."""
    return np.asarray(np.sqrt(np.square(matrix).sum(axis=(-2, -1))))
