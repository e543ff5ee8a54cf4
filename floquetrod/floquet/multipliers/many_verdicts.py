"""Verdicts on many systems at once, by the rules of `classification` where every multiplier is apart from all others.

Systems that these rules leave open are marked undecided, for `floquetrod.stability` to judge one by one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS, Bools, Complexes, Floats, inverses, norms
from floquetrod.floquet import multiplier_pairs
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE


class ManyDiscs(NamedTuple):
    """Eigenvalues of many matrices: values and radii (b, n), and whether each disc is apart from the others (b, n)."""

    values: Complexes
    radii: Floats
    apart: Bools


class ManyVerdicts(NamedTuple):
    """Status (b,) of int8 and growth rates (b,) of many systems, per unit of time if not said otherwise.

    Of systems with delays the rates are NaN where they were not needed.
    """

    status: NDArray[np.int8]
    growth: Floats


@np.errstate(over="ignore", invalid="ignore")  # an overflow has infinite radii, or NaN
def many_discs(matrices: NDArray[Any], errors: Floats) -> ManyDiscs:
    """Return discs as `spectra.eigenvalue_discs` does, all of them before they shrink; NaN where not computed."""
    n = matrices.shape[-1]
    finite = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(errors)
    values, right = np.linalg.eig(np.where(finite[:, None, None], matrices, np.eye(n)))
    left = inverses(right)
    conditions = np.linalg.norm(left, axis=-1)
    uncertainty = n * EPS * np.sqrt(np.square(conditions).sum(axis=-1))
    total = errors + 4.0 * n * EPS * norms(matrices)
    usable = finite & (uncertainty < 0.1)
    radii = np.where(usable[:, None], n * conditions * (total * (1.0 + 2.0 * uncertainty))[:, None], np.inf)
    values = np.where(finite[:, None], values.astype(np.complex128), np.nan)
    return ManyDiscs(values, radii, _apart(values, radii))


@np.errstate(invalid="ignore")
def touch_zero(discs: ManyDiscs) -> Bools:
    """Return which eigenvalues may be 0, (b, n): where their discs, or discs connected to them, hold it."""
    values, radii, _ = discs
    lost = np.logical_not(np.abs(values) > radii)
    while True:
        gaps = np.abs(values[:, :, None] - values[:, None, :])
        near = np.logical_not(gaps > radii[:, :, None] + radii[:, None, :])
        more = (near & lost[:, None, :]).any(axis=2)
        if not (more & ~lost).any():
            return lost
        lost |= more


@np.errstate(over="ignore", invalid="ignore")
def pair_discs(values: Complexes, radii: Floats) -> ManyDiscs:
    """Return discs of given radii."""
    return ManyDiscs(values, radii, _apart(values, radii))


def _apart(values: NDArray[Any], radii: Floats) -> Bools:
    """Return whether each disc touches no other."""
    apart = np.ones(values.shape, dtype=np.bool_)
    for shift in range(1, values.shape[1]):
        neighbour, reach = np.roll(values, shift, axis=1), np.roll(radii, shift, axis=1)
        apart &= np.abs(values - neighbour) > radii + reach
    return apart


@np.errstate(over="ignore", invalid="ignore")
def pair_verdicts(discs: ManyDiscs, period: Floats, damping: float) -> ManyVerdicts:
    """Return verdicts from y = (mu + 1/mu - 2) / 4 of the pairs of systems with uniform damping removed."""
    y, radii, apart = discs
    growth = np.abs(multiplier_pairs.logarithms(y).real)
    off = np.abs(y - np.clip(y.real, -1.0, 0.0)) > radii
    inside = (np.abs(y.imag) <= radii) & (
        multiplier_pairs.decided(multiplier_pairs.excess(y.real, 1.0 + y.real), radii) < 0
    )
    bounded = apart & inside & ~off
    grows = off & (apart | _reduce(np.logical_and, off)[:, None])
    growth = np.where(bounded, 0.0, growth)
    if damping == 0.0:
        unstable, stable = _reduce(np.logical_or, grows), _reduce(np.logical_and, bounded)
    else:
        limit = (damping * period)[:, None]
        uncertainty = multiplier_pairs.slopes(y, 1.0 + y, radii)
        known = apart & (radii <= 0.5 * np.minimum(np.abs(y), np.abs(1.0 + y)))
        unstable = _reduce(np.logical_or, known & (growth - uncertainty > limit))
        stable = _reduce(np.logical_and, bounded | (known & (growth + uncertainty < limit)))
    return _verdicts(stable, unstable, _reduce(np.maximum, growth) / period - damping)


@np.errstate(over="ignore", invalid="ignore")
def multiplier_verdicts(discs: ManyDiscs, period: Floats, *, paired: bool, damping: float) -> ManyVerdicts:
    """Return verdicts from the multipliers; paired ones of systems with uniform ``damping`` removed."""
    values, radii, apart = discs
    sizes = np.abs(values)
    with np.errstate(divide="ignore"):
        growth = np.log(sizes)
        low, high = np.log(np.maximum(sizes - radii, 0.0)), np.log(sizes + radii)
    limit = (damping * period)[:, None] if paired else 0.0
    outside = low > limit
    unstable = _reduce(np.logical_or, outside & (apart | _reduce(np.logical_and, outside)[:, None]))
    decays = high < limit
    if paired and damping == 0.0:
        # A disc on the circle that meets no other, nor another's mirror image, holds one multiplier on it exactly.
        mirrored = np.abs(sizes - 1.0) * (1.0 + 1.0 / np.maximum(sizes, 0.5))
        bounded = _apart(values, radii + mirrored) & (low <= 0.0) & (high >= 0.0) & (radii < 0.5)
        growth = np.where(bounded, 0.0, growth)
        decays = bounded
    fastest = _reduce(np.maximum, growth)
    return _verdicts(_reduce(np.logical_and, decays), unstable, fastest / period - (damping if paired else 0.0))


def _reduce(join: np.ufunc, rows: NDArray[Any]) -> NDArray[Any]:
    """Return ``join.reduce`` over the columns of many short rows, which is slow along rows."""
    return np.asarray(join.reduce(np.ascontiguousarray(rows.T)))


def _verdicts(stable: Any, unstable: Any, growth: Any) -> ManyVerdicts:
    status = np.full(stable.shape, UNDECIDED, dtype=np.int8)
    status[stable], status[unstable] = STABLE, UNSTABLE
    return ManyVerdicts(status, np.where(stable, 0.0, np.maximum(growth, 0.0)))
