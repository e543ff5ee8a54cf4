"""The method "hill": amplitudes of all harmonics from Hill's matrix, of one problem or of many at once."""

from __future__ import annotations

import math
import sys
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod._util.compilation import over_chunks, runner
from floquetrod.responses.hill_arrays import HillArrays
from floquetrod.responses.kernels.harmonic_balance import balance_fill

MOST_ROWS = 200_000
"""Most rows of Hill's matrix (a choice: a second)."""

_MARGIN = 7  # harmonics beyond those at which solutions turn (heuristic)
_LEFT_OUT = 0.25 * EPS  # part of the solution's size that truncation may leave out
_INTERPRETED_UP_TO = 4000  # multiplications, about, that take less time interpreted than loading numba (heuristic)
_CHUNK = 256


class TooManyRows(ValueError):
    """Hill's matrix would take more rows than `MOST_ROWS`."""

    def __init__(self, message: str, rows: float) -> None:
        super().__init__(message)
        self.rows = rows


class Amplitudes(NamedTuple):
    """Amplitudes (b, 2 K + 1, n) of exp(i (w + k W) t), k from -K to K, and their errors (b,).

    The error is of all amplitudes of a coordinate together, over the largest one; infinite on a resonance.
    """

    values: Complexes
    error: Floats


def balanced(
    arrays: HillArrays, force: Complexes, frequency: Floats, force_error: float = 0.0, workers: int | None = 1
) -> Amplitudes:
    """Return the response of every problem to forces of amplitudes (b, 2 F + 1, n) of exp(i (w + k W) t).

    Parameters
    ----------
    arrays : HillArrays
        Of b problems, or of one for all forces.
    force : ndarray (b, 2 F + 1, n)
        Complex amplitudes.
    frequency : ndarray (b,)
        w, radians per unit of time.
    force_error : float
        Error of each entry of the force.
    workers : int or None
        Threads; None for all cores.
    """
    batch, n = len(force), force.shape[-1]
    reach, omega = np.broadcast_to(arrays.reach, batch), np.broadcast_to(arrays.omega, batch)
    harmonics = arrays.halves.shape[2]
    cuts = np.ceil((np.abs(frequency) + reach) / omega) + force.shape[1] // 2 + min(harmonics, 4) + _MARGIN
    largest = float(cuts.max(initial=0.0))
    rows = (2.0 * largest + 1.0) * n
    if not rows <= MOST_ROWS:
        raise TooManyRows(
            f"equation would take {rows:.3g} rows of Hill's matrix, above the limit of {MOST_ROWS:,}: its period is "
            "too long beside its other times, or the frequency too high; method='monodromy' may take it",
            rows,
        )
    unknown = np.stack([np.broadcast_to(arrays.error, batch), np.full(batch, force_error)], axis=1)
    whole = int(largest)
    values = np.zeros((batch, 2 * whole + 1, n), dtype=complex)
    error = np.full(batch, math.inf)
    left = np.arange(batch)
    wanted = _classes(cuts)
    while len(left):
        again = []
        for cut in np.unique(wanted[left]).astype(int).tolist():
            if cut > whole:
                values = np.pad(values, ((0, 0), (cut - whole, cut - whole), (0, 0)))
                whole = cut
            members = left[wanted[left] == cut]
            out = _filled(arrays, force, frequency, unknown, members, cut, workers)
            values[members] = 0.0
            values[members, whole - cut : whole + cut + 1] = out[:, :-2].reshape(len(members), 2 * cut + 1, n)
            error[members] = out[:, -2].real
            more = members[out[:, -1].real > _LEFT_OUT]
            wanted[more] = np.ceil(1.4 * cut) + 4
            again.append(more[2.0 * wanted[more] * n <= MOST_ROWS])
        left = np.concatenate(again)
    return Amplitudes(values, error)


def _classes(cuts: Floats) -> Floats:
    """Return numbers of harmonics, a few different ones where there are many problems."""
    if len(cuts) < 3:
        return cuts.copy()
    return np.asarray(np.ceil(np.exp2(np.ceil(4.0 * np.log2(cuts)) / 4.0)))


def _filled(
    arrays: HillArrays, force: Complexes, frequency: Floats, unknown: Floats, members: Any, cut: int,
    workers: int | None,
) -> Complexes:  # fmt: skip
    """Return the rows of the kernel for some of the problems."""
    n, count = force.shape[-1], len(members)
    rows, width = (2 * cut + 1) * n, (arrays.halves.shape[2] + 1) * n - 1
    out = np.empty((count, rows + 2), dtype=complex)
    every = count == len(force)

    def chosen(array: Any) -> Any:
        wide = np.broadcast_to(array, (len(force), *array.shape[1:])) if len(array) != len(force) else array
        return np.require(
            wide if every else wide[members], requirements=["C", "W"]
        )  # or the kernel is compiled once more

    inputs = [chosen(array) for array in (*arrays[:-1], frequency, force, unknown)]
    work = count * rows * (width + 4) * 4
    free = 0 if "numba" in sys.modules else _INTERPRETED_UP_TO
    run = runner(balance_fill, work, interpret_up_to=free, compile_after=20)
    if run is balance_fill:
        with np.errstate(all="ignore"):
            run(*(array.tolist() for array in inputs), out, cut)
    elif count <= _CHUNK:
        run(*inputs, out, cut)
    else:
        over_chunks(balance_fill, inputs, out, cut, workers=workers, chunk=_CHUNK, interpret_up_to=0)
    return out
