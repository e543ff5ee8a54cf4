"""Maps over a whole period in balanced coordinates, with errors."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Complexes, Floats, norms
from floquetrod.equations.complex_form import complex_matrix
from floquetrod.equations.pieces import PieceArrays
from floquetrod.floquet.kernels.system_maps import SegmentMaps, product, segment_maps

_FEW_ROUNDS, _MANY_ROUNDS = 4, 10  # of balancing rows and columns: for an estimate of the time, and for maps (a choice)
_LESS, _MOST_HALVINGS = 20, 500  # couplings of blocks are halved 20 times beside the largest rate; in all (a choice)
_FAST = 9.0  # logarithm of the norm of a map above which it matters how errors grow (a choice)


class PeriodMaps(NamedTuple):
    """Maps (b, N, N) over a period in coordinates x / scaling, and their errors (b,) in the 2-norm there."""

    matrix: NDArray[Any]
    error: Floats
    scaling: Floats


def is_oscillators(mean: Floats, harmonics: Complexes) -> bool:
    """Return whether x' = A(t) x is q'' + K(t) q = 0, K symmetric bit for bit, as it stands."""
    n = len(mean) // 2
    lower = np.concatenate([mean[None, n:, :n], harmonics[:, n:, :n]])
    velocities = not mean[:n, :n].any() and not mean[n:, n:].any() and np.array_equal(mean[:n, n:], np.eye(n))
    rest = harmonics[:, :n].any() or harmonics[:, n:, n:].any()
    return bool(velocities and not rest and (lower == lower.swapaxes(-1, -2)).all())


def seconds_needed(pieces: PieceArrays) -> Floats:
    """Return about how long the map of each system takes (b,), in seconds: measured on one core of 2024."""
    n, sizes = pieces.mean.shape[-1], pieces.sizes
    levels = _levels(sizes.max(axis=1))
    if levels is not None:
        sizes = sizes * levels[:, None, None, :] / levels[:, None, :, None]
    scaling = _balance(sizes.max(axis=1), _FEW_ROUNDS)
    with np.errstate(over="ignore", invalid="ignore"):
        sizes = sizes * scaling[:, None, None, :] / scaling[:, None, :, None]
        sums = np.minimum(sizes.sum(axis=-1).max(axis=-1), sizes.sum(axis=-2).max(axis=-1))
        return np.asarray((pieces.length * sums).sum(axis=-1) * (1e-5 + 1e-6 * n * n))


def _levels(sizes: Floats) -> Floats | None:
    """Return scales (b, N) of x in which blocks hardly drive others that do not drive them; None without any.

    Where A, of magnitudes (b, N, N), is block triangular after a permutation, the diagonal blocks alone have the
    multipliers, and each level of blocks may be scaled by itself: couplings become a millionth of the largest rate, as
    far as the range of doubles allows.  Tried where a row or a column of an A has its diagonal entry alone.
    """
    n = sizes.shape[-1]
    inner = sizes * (1.0 - np.eye(n))
    rows, columns = inner.any(axis=-1), inner.any(axis=-2)
    one_sided = (rows != columns).any(axis=-1)
    if not one_sided.any():
        return None
    levels = np.ones(sizes.shape[:-1])
    for b in np.flatnonzero(one_sided):
        depth, label = _depths(inner[b])
        across = label[:, None] != label[None, :]
        rate = float(sizes[b][~across].max())
        largest = float(sizes[b][across].max())
        halvings = math.log2(largest / rate) + _LESS if rate > 0.0 else _LESS
        levels[b] = np.exp2(-depth * np.floor(min(max(halvings, 0.0), _MOST_HALVINGS / depth.max())))
    return levels


def _depths(couplings: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return how many blocks each unknown drives one after another at most, and the number of its block, (N,) each."""
    from scipy.sparse.csgraph import connected_components

    count, label = connected_components(couplings, directed=True, connection="strong")
    driven = np.zeros((count, count), dtype=np.bool_)
    i, j = np.nonzero(couplings)
    driven[label[i], label[j]] = True  # block of j drives that of i
    np.fill_diagonal(driven, False)
    depth = np.zeros(count, dtype=np.intp)
    for _ in range(count):
        deeper = np.where(driven, depth[:, None] + 1, 0).max(axis=0, initial=0)
        if np.array_equal(deeper, depth):
            break
        depth = deeper
    return depth[label], label


def _balance(sizes: Floats, rounds: int) -> Floats:
    """Return scales (b, N) of x in which rows and columns of A, of magnitudes (b, N, N), are about equally large."""
    n = sizes.shape[-1]
    inner, scaling = sizes * (1.0 - np.eye(n)), np.ones(sizes.shape[:-1])
    with np.errstate(all="ignore"):
        for _ in range(rounds):
            stretch = np.sqrt(np.sqrt(inner.sum(axis=-1) / inner.sum(axis=-2)))
            stretch = np.where(np.isfinite(stretch) & (stretch > 0.0), stretch, 1.0)
            inner = inner * stretch[:, None, :] / stretch[:, :, None]
            scaling = scaling * stretch
    return scaling


@np.errstate(all="ignore")  # maps that overflow, whose errors are then not finite, and maps that decay to zero
def period_maps(
    pieces: PieceArrays, uncertainty: Any, rtol: float, *, paired: bool, workers: int | None = 1
) -> PeriodMaps:
    """Return the maps of x' = A(t) x over all pieces; ``uncertainty`` is the error of A's entries.

    Where ``paired``, positions and velocities are scaled by inverse factors: the map stays symplectic or reversible.
    """
    uncertainty = np.broadcast_to(np.asarray(uncertainty, dtype=float), pieces.mean.shape[:1])
    maps = _in_segments(pieces, uncertainty, rtol, 1, paired, workers)
    growth = np.log(norms(maps.matrix))
    fast = (growth > _FAST) & np.isfinite(growth) & (uncertainty > 0.0)
    if fast.any():
        segments = math.ceil(0.5 * growth[fast].max())
        again = _in_segments(pieces.some(fast), uncertainty[fast], rtol, segments, paired, workers)
        for whole, refined in zip(maps, again, strict=True):
            whole[fast] = refined
    return maps


def growth_rate(pieces: PieceArrays, rtol: float) -> float:
    """Return the growth rate of one system x' = A(t) x; NaN where its map overflows, -inf where it decays to zero."""
    matrix = period_maps(pieces, 0.0, rtol, paired=False).matrix[0]
    if not np.isfinite(matrix).all():
        return math.nan
    largest = float(np.abs(np.linalg.eigvals(matrix)).max())
    return math.log(largest) / float(pieces.period[0]) if largest > 0.0 else -math.inf


def of_complex(maps: PeriodMaps) -> PeriodMaps:
    """Return the maps of complex systems from the maps of their real forms.

    Real and imaginary parts get one scale; balancing may have given them two that differ a little.
    """
    scaling = maps.scaling[:, : maps.scaling.shape[-1] // 2]
    matrix, error, _ = in_scaling(maps, np.concatenate([scaling, scaling], axis=-1))
    return PeriodMaps(complex_matrix(matrix), error, scaling)


def in_scaling(maps: PeriodMaps, scaling: Floats) -> PeriodMaps:
    """Return maps in coordinates x / scaling for other scales."""
    ratio = maps.scaling / scaling
    matrix = maps.matrix * ratio[:, :, None] / ratio[:, None, :]
    return PeriodMaps(matrix, maps.error * _spread(ratio), scaling)


def _in_segments(
    pieces: PieceArrays, uncertainty: Floats, rtol: float, segments: int, paired: bool, workers: int | None
) -> PeriodMaps:
    """Return maps as products over segments of each piece; the more segments, the less overestimated the error."""
    if paired:
        scaling = _paired_scaling(pieces.sizes.max(axis=1))
        segmented = _maps(pieces.scaled(scaling), rtol, segments, workers)
    else:
        segmented = balanced_maps(pieces, rtol, segments, workers, exact=not uncertainty.any())
        scaling, segmented = segmented.scaling, segmented._replace(scaling=np.ones(segmented.scaling.shape))
    matrix, error, inner = product(segmented)
    lengths = np.repeat(pieces.length / segments, segments, axis=1)
    change = uncertainty * pieces.mean.shape[-1] * error_stretch(pieces.mean, scaling)
    moved = np.where(uncertainty > 0.0, change * _carried(segmented.maps, lengths), 0.0)
    return PeriodMaps(matrix.copy(), error * _spread(inner) + moved, scaling)


def _carried(maps: Floats, lengths: Floats) -> Floats:
    """Return the largest change (b,) of the product of maps (b, S, N, N) by a change of A by 1 in the 2-norm."""
    count = maps.shape[1]
    before, after = np.ones((2, *lengths.shape))
    prefix, suffix = maps[:, 0], maps[:, -1]
    for j in range(1, count):
        before[:, j], after[:, count - 1 - j] = norms(prefix), norms(suffix)
        prefix, suffix = maps[:, j] @ prefix, suffix @ maps[:, count - 1 - j]
    return np.asarray((after * lengths * np.maximum(norms(maps), 1.0) ** 2 * before).sum(axis=1))


def balanced_maps(
    pieces: PieceArrays, rtol: float, segments: int = 1, workers: int | None = 1, *, exact: bool = False
) -> SegmentMaps:
    """Return the maps of x / scaling, rows and columns balanced, over equal segments of all pieces.

    Where the coefficients are ``exact``, blocks that drive no other are scaled by themselves.
    """
    levels = _levels(pieces.sizes.max(axis=1)) if exact else None
    if levels is not None:
        levelled = balanced_maps(pieces.scaled(levels), rtol, segments, workers)
        return levelled._replace(scaling=levelled.scaling * levels)
    if pieces.mean.shape[1] > 1:
        scaling = np.exp2(np.round(np.log2(_balance(pieces.sizes.max(axis=1), _MANY_ROUNDS)))).astype(float)
        return _maps(pieces.scaled(scaling), rtol, segments, workers)._replace(scaling=scaling)
    maps, errors, scaling = _maps(pieces, rtol, segments, workers)
    return SegmentMaps(maps * scaling[:, None, None, :] / scaling[:, None, :, None], errors, scaling)


def _maps(pieces: PieceArrays, rtol: float, segments: int, workers: int | None) -> SegmentMaps:
    """Return the maps over equal segments of all pieces, without scaling where there are several pieces."""
    batch, count, n = pieces.mean.shape[:3]
    slope = pieces.slope
    if count == 1 and slope is None and np.array_equal(pieces.length[:, 0], pieces.period):
        return segment_maps(pieces.mean[:, 0], pieces.harmonics[:, 0], pieces.period, rtol, segments, workers)

    def flat(array: NDArray[Any]) -> NDArray[Any]:
        return array.reshape(batch * count, *array.shape[2:])

    maps = segment_maps(
        flat(pieces.mean),
        flat(pieces.harmonics),
        np.repeat(pieces.period, count),
        rtol,
        segments,
        workers,
        None if slope is None else flat(slope),
        flat(pieces.length),
    )
    errors = (maps.errors * _spread(maps.scaling)[:, None]).reshape(batch, count * segments)
    return SegmentMaps(maps.maps.reshape(batch, count * segments, n, n), errors, np.ones((batch, n)))


def _spread(scaling: Floats) -> Floats:
    """Return the largest growth of an error in coordinates x instead of x / scaling."""
    return np.asarray(scaling.max(axis=-1) / scaling.min(axis=-1))


def uncertain_entries(means: Floats) -> Bools:
    """Return which entries (N, N) of A with the means (b, P, N, N) its error may be in.

    Where positions change at the rate of velocities, [0, 1] in the upper half of the means, nothing is in error there,
    nor in a lower right block that is zero.
    """
    n = means.shape[-1] // 2
    entries = np.ones(means.shape[-2:], dtype=np.bool_)
    if means.shape[-1] % 2 or not ((means[..., :n, n:] == np.eye(n)).all() and not means[..., :n, :n].any()):
        return entries
    entries[:n] = False
    entries[n:, n:] = means[..., n:, n:].any()
    return entries


def error_stretch(means: Floats, scaling: Floats) -> Floats:
    """Return the largest growth of errors of the coefficients in coordinates x / scaling."""
    entries = uncertain_entries(means)
    columns, rows = scaling[:, entries.any(axis=0)], scaling[:, entries.any(axis=1)]
    return np.asarray(columns.max(axis=-1) / rows.min(axis=-1))


def _paired_scaling(sizes: Floats) -> Floats:
    """Return powers of two, g for positions and 1 / g for velocities, that make both drive each other equally."""
    n = sizes.shape[-1] // 2
    up, down = sizes[:, :n, n:].max(axis=-1), sizes[:, n:, :n].max(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        power = np.round(0.25 * np.log2(up / down))
    g = 2.0 ** np.clip(np.where(np.isfinite(power), power, 0.0), -200.0, 200.0)
    return np.concatenate([g, 1.0 / g], axis=-1)
