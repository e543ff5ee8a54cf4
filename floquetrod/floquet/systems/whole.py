"""Maps over a whole period in balanced coordinates, with errors."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import norms
from floquetrod.floquet.kernels.system_maps import product, segment_maps


class PeriodMaps(NamedTuple):
    """Maps (b, N, N) over a period in coordinates x / scaling, and their errors (b,) in the 2-norm there."""

    matrix: NDArray[np.float64]
    error: NDArray[np.float64]
    scaling: NDArray[np.float64]


def is_oscillators(mean: NDArray[np.float64], harmonics: NDArray[np.complex128]) -> bool:
    """Return whether x' = A(t) x is q'' + K(t) q = 0, K symmetric to the bit, as it stands."""
    n = len(mean) // 2
    lower = np.concatenate([mean[None, n:, :n], harmonics[:, n:, :n]])
    velocities = not mean[:n, :n].any() and not mean[n:, n:].any() and np.array_equal(mean[:n, n:], np.eye(n))
    rest = harmonics[:, :n].any() or harmonics[:, n:, n:].any()
    return bool(velocities and not rest and (lower == lower.swapaxes(-1, -2)).all())


def seconds_needed(mean: Any, harmonics: Any, period: Any) -> NDArray[np.float64]:
    """Return about how long the map of each system takes (b,), in seconds: measured on one core of 2024."""
    n = mean.shape[-1]
    sizes = np.abs(mean) + np.abs(harmonics).sum(axis=1)
    inner = sizes * (1.0 - np.eye(n))
    with np.errstate(all="ignore"):
        for _ in range(4):  # balance rows and columns: the unit of time then changes nothing
            stretch = np.sqrt(np.sqrt(inner.sum(axis=-1) / inner.sum(axis=-2)))
            stretch = np.where(np.isfinite(stretch) & (stretch > 0.0), stretch, 1.0)
            inner = inner * stretch[:, None, :] / stretch[:, :, None]
    inner += sizes * np.eye(n)
    phase = period * np.minimum(inner.sum(axis=-1).max(axis=-1), inner.sum(axis=-2).max(axis=-1))
    return np.asarray(phase * (1e-5 + 1e-6 * n * n))


@np.errstate(over="ignore", under="ignore", invalid="ignore")  # of maps that overflow, whose errors are then not finite
def period_maps(
    mean: Any, harmonics: Any, period: Any, uncertainty: Any, rtol: float, *, paired: bool, workers: int | None = 1
) -> PeriodMaps:
    """Return the maps of x' = A(t) x; ``uncertainty`` is the error of A's entries.

    Where ``paired``, positions and velocities are scaled by inverse factors: the map stays symplectic or reversible.
    """
    n, plain = mean.shape[-1], mean
    scaling = _paired_scaling(mean, harmonics) if paired else np.ones(mean.shape[:-1])
    harmonics = harmonics * scaling[:, None, None, :] / scaling[:, None, :, None]
    mean = mean * scaling[:, None, :] / scaling[:, :, None]
    whole = product(segment_maps(mean, harmonics, period, rtol, workers=workers))
    matrix, error, inner = whole.matrix, whole.error, whole.scaling
    if paired:
        error = error * inner.max(axis=-1) / inner.min(axis=-1)
    else:
        matrix = matrix * inner[:, None, :] / inner[:, :, None]
        scaling = inner
    size = norms(matrix)
    stretch = error_stretch(plain, scaling)
    moved = np.where(uncertainty > 0.0, period * uncertainty * n * stretch * np.maximum(size, 1.0) ** 2, 0.0)
    return PeriodMaps(matrix, error + moved, scaling)


def error_stretch(mean: NDArray[np.float64], scaling: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how much larger errors of the coefficients may be in coordinates x / scaling.

    Where positions change at the rate of velocities, [0, 1] in the upper half of the mean (b, 2n, 2n), nothing is in
    error there, nor in a lower right block that is zero.
    """
    n = mean.shape[-1] // 2
    every = scaling.max(axis=-1) / scaling.min(axis=-1)
    if mean.shape[-1] % 2 or not ((mean[:, :n, n:] == np.eye(n)).all() and not mean[:, :n, :n].any()):
        return np.asarray(every)
    columns = scaling if mean[:, n:, n:].any() else scaling[:, :n]
    return np.asarray(columns.max(axis=-1) / scaling[:, n:].min(axis=-1))


def _paired_scaling(mean: NDArray[np.float64], harmonics: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return powers of two, g for positions and 1 / g for velocities, that make both drive each other equally."""
    n = mean.shape[-1] // 2
    sizes = np.abs(mean) + np.abs(harmonics).sum(axis=1)
    up, down = sizes[:, :n, n:].max(axis=-1), sizes[:, n:, :n].max(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        power = np.round(0.25 * np.log2(up / down))
    g = 2.0 ** np.clip(np.where(np.isfinite(power), power, 0.0), -200.0, 200.0)
    return np.concatenate([g, 1.0 / g], axis=-1)
