"""From maps over half a period of even systems to the matrices whose eigenvalues are the pairs, with errors."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats, inverses, norms
from floquetrod.equations.matrices import mirrored
from floquetrod.equations.pieces import PieceArrays
from floquetrod.floquet.kernels.system_even import HalfPeriodMap, half_period_map
from floquetrod.floquet.multipliers import spectra, whole_period_maps

_FARTHEST = 1500.0  # logarithm of growth over a period, more than twice that of the largest double
_FAST = 1e4  # norm of a map above which it matters how errors grow (a choice)
_INSTANTS = 16  # of half a period, for a mean (a choice)
_LARGEST_EXPONENT = 50.0  # beyond it nothing is known of a map


class PairMatrices(NamedTuple):
    """Matrices of many even systems."""

    matrix: Floats  # (b, n, n), its eigenvalues are (mu + 1/mu - 2) / 4
    error: Floats  # (b,), its error, in the 2-norm
    form: Floats  # (b, n, n), with which it is self-adjoint, negative on eigenvectors of Krein sign +1; symmetric
    form_error: Floats  # (b,), its error, in the 2-norm
    symmetric: bool  # whether the stiffness is; else there is no form
    basis: Floats  # (b, n, n), u = basis v of the eigenvectors v


def seconds_needed(stiffness: Any, amplitudes: Any, period: Any) -> Floats:
    """Return about how long the map of each system takes (b,), in seconds: measured on one core of 2024.

    Infinite where an equation is pushed away so strongly at all times that solutions grow beyond doubles.
    """
    n = stiffness.shape[-1]
    squares = np.square(stiffness).sum(axis=(1, 2)), np.square(amplitudes).sum(axis=(2, 3))
    phase = period * np.sqrt(np.sqrt(squares[0]) + np.sqrt(squares[1]).sum(axis=1))
    seconds = np.asarray(phase * (0.5e-6 + 1.5e-7 * n * n))
    far = phase > _FARTHEST
    if far.any():
        pushed = -np.diagonal(stiffness[far], axis1=1, axis2=2)
        pushed = pushed - np.abs(np.diagonal(amplitudes[far], axis1=2, axis2=3)).sum(axis=1)
        beyond = period[far] * np.sqrt(np.maximum(pushed.max(axis=1), 0.0)) > _FARTHEST
        seconds[far] = np.where(beyond, np.inf, seconds[far])
    return seconds


def pair_matrices(
    stiffness: Any, amplitudes: Any, period: Any, uncertainty: Any, rtol: float, workers: int | None = 1
) -> PairMatrices:
    """Return the matrices of u'' + (S + sum_k A_k cos k w t) u = 0, S and A with an ``uncertainty`` in 2-norm."""
    half = half_period_map(stiffness, amplitudes, period, rtol, workers)
    with np.errstate(over="ignore", invalid="ignore"):  # of maps that overflow, whose errors are then not finite
        n = half.a.shape[-1]
        whole, error = _whole(half, stiffness, amplitudes, period, uncertainty)
        if half.symmetric:
            return _numbers(half, error, np.swapaxes(half.b, -1, -2), error)
        inverse = inverses(whole)
        left, reach = -inverse[..., :n, n:], norms(inverse)
        left_error = 2.0 * reach**2 * (error + 4.0 * n * EPS * norms(whole))
        lost = ~(reach * error < 0.5)
        if lost.any():
            # The inverse is the map back over the next half period, for -t and -u': it is even about that instant too.
            signs = (-1.0) ** np.arange(1, amplitudes.shape[1] + 1)[:, None, None]
            next_half = half_period_map(stiffness, signs * amplitudes, period, rtol, workers)
            back = _whole(next_half, stiffness, amplitudes, period, uncertainty)[1]
            left[lost], left_error[lost] = next_half.b[lost], back[lost]
        return _numbers(half, error, left, left_error)


@np.errstate(over="ignore", invalid="ignore")  # of maps that overflow, whose errors are then not finite
def of_pieces(
    pieces: PieceArrays, next_half: PieceArrays, uncertainty: float, rtol: float, *, symmetric: bool
) -> PairMatrices:
    """Return the matrices of u'' + K(t) u = 0 in first order, from its pieces over half a period from an even instant.

    ``next_half`` are the pieces of the next half, whose map replaces the inverse where K is not symmetric, and
    ``uncertainty`` the error of K's entries.
    """
    n = pieces.mean.shape[-1] // 2
    maps = whole_period_maps.period_maps(pieces, uncertainty, rtol, paired=True)
    matrix, basis = maps.matrix, maps.scaling[:, :n, None] * np.eye(n)
    a, b, c, d = matrix[:, :n, :n], matrix[:, :n, n:], matrix[:, n:, :n], matrix[:, n:, n:]
    half = HalfPeriodMap(a, b, c, d, maps.error, basis, symmetric)
    if symmetric:
        return _numbers(half, half.error, np.swapaxes(b, -1, -2), half.error)
    back = whole_period_maps.period_maps(next_half, uncertainty, rtol, paired=True)
    return _numbers(half, half.error, back.matrix[:, :n, n:], back.error)


def _whole(
    half: HalfPeriodMap, stiffness: Any, amplitudes: Any, period: Any, uncertainty: Any
) -> tuple[Floats, Floats]:
    """Return maps (b, 2 n, 2 n) over half a period, and their errors, including errors of the coefficients."""
    whole = joined(half)
    size = _sizes(whole)
    stretch = np.square(size)  # of an error on the way to the end of the half period, the way there included
    if not np.any(uncertainty) and np.isfinite(stretch).all():
        return whole, half.error
    slip = 0.5 * period * uncertainty * _sizes(half.basis) ** 2 * stretch
    fast = (size > _FAST) & np.isfinite(stretch)
    if fast.any():
        fast_systems = stiffness[fast], amplitudes[fast], period[fast]
        slip[fast] *= np.minimum(1.0, _most_growth(half.basis[fast], *fast_systems) / stretch[fast])
        unsure = np.broadcast_to(uncertainty, size.shape)[fast]
        slip[fast] = np.fmin(slip[fast], _carried(half.error[fast], size[fast], *fast_systems, unsure))
    return whole, half.error + slip


def _carried(
    error: Floats, size: Floats, stiffness: Any, amplitudes: Any, period: Floats, uncertainty: Floats
) -> Floats:
    """Return the change (b,), in the 2-norm, of maps of an error E by an uncertainty of the coefficients.

    A map is a product of m segments, E = sum_j |after j| e_j |before j| exp(m sum_j e_j / |segment j|).  Each e_j
    contains the rounding of the coefficients, at least 2 u |S| h / r, u the rounding of a double, h the length of a
    segment, r the slowest rate of the balance; an uncertainty d adds d h / r.  The same products carry both: to first
    order the change is E x, x = d / (2 u |S|).  As |map| <= |after j| |segment j| |before j|, the sum in the exponent
    is at most E / |map|, and m is no more than the radians of the fastest motion.
    """
    frobenius = np.sqrt(np.square(stiffness).sum(axis=(1, 2)))  # the 2-norm, or up to sqrt(n) times as much
    strongest = frobenius + np.sqrt(np.square(amplitudes).sum(axis=(2, 3))).sum(axis=1)
    segments = 1.0 + 0.5 * period * np.sqrt(strongest)
    share = uncertainty * math.sqrt(stiffness.shape[-1]) / (EPS * frobenius)
    return np.asarray(error * share * np.exp(np.minimum(share * error / size * segments, _LARGEST_EXPONENT)))


def _most_growth(basis: Floats, stiffness: Any, amplitudes: Any, period: Floats) -> Floats:
    """Bound the product of the norms of the maps to any instant and from there on, (b,), by their logarithmic norm.

    With v' = D p and p' = -B(t) v that is half the norm of D - B(t), whose mean is taken from a few instants.  It is an
    exponent, so that no bound of it will do.
    """
    turned = np.swapaxes(basis, -1, -2)
    rates = inverses(turned @ basis) - turned @ stiffness @ basis
    waves = turned[:, None] @ amplitudes @ basis[:, None]
    orders = 1.0 + np.arange(waves.shape[1])
    phases = np.pi / _INSTANTS * (0.5 + np.arange(_INSTANTS))
    sums = sum(_norms(rates - np.tensordot(np.cos(phase * orders), waves, (0, 1))) for phase in phases)
    return np.asarray(np.exp(0.25 * period * sums / _INSTANTS))


def joined(half: HalfPeriodMap) -> Floats:
    """Return maps (b, 2 n, 2 n) from their blocks."""
    return np.concatenate([np.concatenate([half.a, half.b], -1), np.concatenate([half.c, half.d], -1)], -2)


def _sizes(matrices: Floats) -> Floats:
    """Bound the 2-norms of matrices (b, n, n): for large, nearly diagonal ones far below `norms`."""
    if matrices.shape[-1] < spectra.LARGE:
        return norms(matrices)
    return np.array([spectra.spectral_norm(matrix) for matrix in matrices])


def _norms(matrices: Floats) -> Floats:
    """Return the 2-norms of matrices (b, n, n); of very many rows bounds of them, which take less time."""
    if matrices.shape[-1] >= spectra.LARGE:
        return np.array([spectra.spectral_norm(matrix) for matrix in matrices])
    return np.asarray(np.linalg.norm(matrices, 2, axis=(-2, -1)))


def _numbers(half: HalfPeriodMap, error: Floats, left: Floats, left_error: Floats) -> PairMatrices:
    """Return the matrices that follow from maps over half a period and the upper right blocks of their inverses."""
    form, form_slip = products(np.swapaxes(half.a, -1, -2), error, half.c, error)
    return PairMatrices(
        *products(left, left_error, half.c, error),
        mirrored(form),
        form_slip,
        half.symmetric,
        half.basis,
    )


def products(left: Floats, left_error: Floats, right: Floats, error: Floats) -> tuple[Floats, Floats]:
    """Return products of matrices (b, n, n) with errors (b,), and the errors of the products."""
    left_size, right_size = _sizes(left), _sizes(right)
    rounding = left.shape[-1] * EPS * left_size * right_size
    return left @ right, left_size * error + right_size * left_error + error * left_error + rounding
