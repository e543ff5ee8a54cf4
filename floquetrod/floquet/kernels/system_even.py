"""Maps over half a period of u'' + K(t) u = 0 with K even in t, with error bounds, over arrays of systems."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Complexes, Floats, are_diagonal, inverses, norms
from floquetrod._util.compilation import over_chunks
from floquetrod.floquet.kernels.system_even_large import half_period_large
from floquetrod.floquet.kernels.system_even_pairs import NOT_DONE, outcome_fill, pair_fill
from floquetrod.floquet.kernels.system_even_steps import half_period_fill
from floquetrod.floquet.kernels.system_series import ROUNDING, reach, run_of, usable

_EXPLICIT_UP_TO = 8  # equations: of one system of more, interpreted kernels take 10 to 100 times as long as products
_PRODUCTS_UP_TO = 3e4  # milliseconds of interpreted kernels, as estimated: products of one system take 0.2 s (measured)
_MANY_UP_TO = 60  # equations: of several systems at once kernels take less time than numpy's products (measured)

_COMPILE_AFTER = 1000.0
"""Milliseconds, as estimated, for which a process interprets kernels before they are compiled (heuristic)."""


class HalfPeriodMap(NamedTuple):
    """Maps over half a period from an instant of evenness, in balanced coordinates.

    With u = basis v and u' = basis^-T p, the map of (v, p) is [[a, b], [c, d]].  Where K is symmetric this is a
    symplectic change of coordinates: b^T c and a^T d have the eigenvalues they have in (u, u').
    """

    a: Floats  # (batch, n, n), the blocks
    b: Floats
    c: Floats
    d: Floats
    error: Floats  # (batch,), of [[a, b], [c, d]] in the Frobenius norm: truncation bounded, rounding to first order
    basis: Floats  # (batch, n, n), eigenvectors of the mean stiffness, or the identity, over the roots of the rates
    symmetric: bool  # whether every matrix of the batch is symmetric, to the bit


def half_period_map(
    stiffness: Any, amplitudes: Any, period: Any, accuracy: float = 1e-12, workers: int | None = 1
) -> HalfPeriodMap:
    """Return the maps over half a period of u'' + (S + sum_k A_k cos(k w t)) u = 0, from t = 0, w = 2 pi / period.

    Parameters
    ----------
    stiffness, amplitudes, period : array_like, (b, n, n), (b, H, n, n), (b,)
        S, A_1..A_H (H may be 0) and the period.
    accuracy : float
        The error aimed at per segment, in balanced coordinates; what was reached is in ``error``.
    workers : int or None
        Threads for small n; None for all cores.

    Returns
    -------
    HalfPeriodMap
        The work grows like sqrt(|K|) times the period.  Where a system is not finite, or its map overflows, the error
        is infinite.
    """
    stiffness, amplitudes, period = _arrays(stiffness, amplitudes, period)
    lost = ~usable(stiffness, amplitudes, period)
    if lost.any():
        stiffness[lost], amplitudes[lost], period[lost] = 0.0, 0.0, 1.0
    batch, n = stiffness.shape[:2]
    symmetric = _symmetric(stiffness, amplitudes)
    omega = 2.0 * math.pi / period
    s = np.diagonal(stiffness, axis1=-2, axis2=-1).copy()
    q, f, first, slack = np.eye(n)[None], amplitudes, 1, 2.0 * ROUNDING
    if not are_diagonal(stiffness):
        if symmetric:
            s, q = np.linalg.eigh(stiffness)
            f = q.swapaxes(-1, -2)[:, None] @ amplitudes @ q[:, None]
            slack = ROUNDING * (4.0 + 4.0 * math.sqrt(n))
        else:
            f = np.concatenate([(stiffness * (1.0 - np.eye(n)))[:, None], amplitudes], axis=1)
            first = 0
    out = np.empty((batch, 4 * n * n + n + 1))
    constants = (first, accuracy, reach(accuracy), symmetric, slack)
    many = n > _EXPLICIT_UP_TO and (batch > 1 or _milliseconds(stiffness, amplitudes, period) > _PRODUCTS_UP_TO)
    if n <= (_MANY_UP_TO if many else _EXPLICIT_UP_TO):
        run = run_of(half_period_fill, _COMPILE_AFTER, lambda: _milliseconds(stiffness, amplitudes, period))
        inputs = s, f, omega
        if batch == 1 or run is half_period_fill:  # the shortest way for a single system
            with np.errstate(all="ignore"):  # interpreted, as machine code does
                run(*_arrays(*inputs), out, *constants)
        else:
            chunk = max(1, 8192 // n**3)
            over_chunks(half_period_fill, inputs, out, *constants, workers=workers, chunk=chunk, interpret_up_to=0)
    else:
        for i in range(batch):
            v, g, error = half_period_large(
                s[i], f[i], first, float(omega[i]), accuracy, reach(accuracy), symmetric, slack
            )
            out[i] = np.concatenate([v.ravel(), g, [error]])
    if lost.any():
        out[lost, : 4 * n * n], out[lost, -1] = math.nan, math.inf
    v = out[:, : 4 * n * n].reshape(batch, 2 * n, 2 * n)
    basis = q / out[:, None, 4 * n * n : -1]
    return HalfPeriodMap(v[:, :n, :n], v[:, :n, n:], v[:, n:, :n], v[:, n:, n:], out[:, -1], basis, symmetric)


def pair_numbers(
    stiffness: Any, amplitudes: Any, period: Any, accuracy: float = 1e-12, workers: int | None = 1
) -> tuple[Complexes, Floats, Floats]:
    """Return x = mu + 1/mu of systems of two equations, their errors, and their Krein forms.

    Parameters as for `half_period_map`, with n = 2.

    Returns
    -------
    x : numpy.ndarray, (b, 2), complex
        The two numbers, real or a complex pair.
    errors : numpy.ndarray, (b, 2)
        Radius about each; close pairs have large ones.
    krein : numpy.ndarray, (b, 2)
        u^T R u / u^T u, u the eigenvector, R = A^T C; 0 where its sign is undecided, x is complex or K not symmetric.
    """
    stiffness, amplitudes, period = _arrays(stiffness, amplitudes, period)
    out = np.empty((len(period), 8))
    inputs = (stiffness, amplitudes, period)
    run = run_of(pair_fill, _COMPILE_AFTER, lambda: _milliseconds(*inputs))
    if len(out) == 1 or run is pair_fill:
        with np.errstate(all="ignore"):  # interpreted, as machine code does
            run(*inputs, out, accuracy, reach(accuracy))  # the shortest way for a single system
        if len(out) == 1 and out[0, 4] != NOT_DONE:
            return out[:, :4].view(complex), out[:, 4:6], out[:, 6:]
    else:
        over_chunks(pair_fill, inputs, out, accuracy, reach(accuracy), workers=workers, chunk=512, interpret_up_to=0)
    left = out[:, 4] == NOT_DONE
    if left.any():
        symmetric = _symmetric_each(stiffness) & _symmetric_each(amplitudes).all(axis=1)
        for part in (left & symmetric, left & ~symmetric):
            if part.any():
                half_maps = half_period_map(stiffness[part], amplitudes[part], period[part], accuracy, workers)
                out[part] = _outcomes(half_maps, workers)
    return out[:, :4].view(complex), out[:, 4:6], out[:, 6:]


@np.errstate(over="ignore", under="ignore", invalid="ignore")  # of maps that overflow, whose errors are then not finite
def _outcomes(half_maps: HalfPeriodMap, workers: int | None) -> Floats:
    """Return the rows of `pair_fill` from maps over half a period."""
    maps, errors = np.block([[half_maps.a, half_maps.b], [half_maps.c, half_maps.d]]), half_maps.error
    back, wrong = maps, errors
    if not half_maps.symmetric:
        back = inverses(maps)
        size, spread = norms(maps), norms(back)
        safe = spread * errors < 0.5
        wrong = spread**2 * (errors + 16.0 * ROUNDING * size) / (1.0 - np.where(safe, spread * errors, 0.0))
        wrong = np.where(safe, wrong, math.inf)
    out = np.empty((len(maps), 8))
    finite = np.isfinite(maps).all(axis=(1, 2)) & np.isfinite(back).all(axis=(1, 2)) & np.isfinite(wrong)
    out[~finite] = [math.nan, math.nan, math.nan, math.nan, math.inf, math.inf, 0.0, 0.0]
    inputs = (maps, back, errors, wrong, np.full(len(maps), half_maps.symmetric))
    rows = np.empty((int(finite.sum()), 8))
    over_chunks(outcome_fill, [array[finite] for array in inputs], rows, workers=workers, compile_after=64)
    out[finite] = rows
    return out


def _milliseconds(stiffness: Floats, amplitudes: Floats, period: Floats) -> float:
    """Return about how many milliseconds the interpreted kernels take (measured)."""
    batch, n = stiffness.shape[:2]
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        size = np.abs(stiffness).sum(axis=(1, 2)) + np.abs(amplitudes).sum(axis=(1, 2, 3))
        phases = float(np.fmin(period * np.sqrt(size / n), 1e6).clip(0.0).sum())
    return float(batch + phases * (0.3 + n**3 / 200.0))


def _arrays(*values: Any) -> list[Floats]:
    """Return the values as arrays that own their data: kernels are compiled for one layout only."""
    return [np.array(value, dtype=float, order="C") for value in values]


def _symmetric(*values: Floats) -> bool:
    """Say whether all matrices of stacks are symmetric, to the bit."""
    return all(bool(_symmetric_each(value).all()) for value in values)


def _symmetric_each(matrices: Floats) -> Bools:
    """Say which matrices of a stack are symmetric, to the bit."""
    return np.asarray((matrices == matrices.swapaxes(-1, -2)).all(axis=(-2, -1)))
