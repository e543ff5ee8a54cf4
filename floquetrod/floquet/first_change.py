"""Where a verdict first changes along a quantity: the one search behind margins, ranges and critical values.

A source knows the verdicts on a piece of the quantity.  Counted tongues leave no gap: their resolution is 0.  Samples
leave gaps as wide as their distance, and every change between two samples is located by bisection.  A
search goes outward through pieces, the nearest first, and its `FirstChange` states the coarsest resolution on its way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress

Locate: TypeAlias = Callable[[Floats, Floats], Floats]
"""Returns the last stable value between stable values and unstable ones, which may be lower or higher."""

_MOST_HALVINGS = 60  # of a bracket (a choice)


class FirstChange(NamedTuple):
    """Where a verdict first changes on a way.

    Attributes
    ----------
    at : float or None
        The value of the quantity; None where the verdict is seen not to change.
    searched : float
        Value up to which was searched: ``at`` where the verdict changes.
    resolution : float
        Changes closer together than this may have been passed over; 0 where none can be.
    seconds : float
        Duration of the search, as estimated.
    error : float
        Of ``at``; NaN where it is not estimated.
    """

    at: float | None
    searched: float
    resolution: float
    seconds: float = 0.0
    error: float = math.nan


def first_change(
    blocks: Iterable[tuple[Floats, Bools]],
    begins: bool,
    locate: Locate,
    piece: tuple[float, float],
    resolution: float,
    refused: type[Exception] | tuple[()] = (),
) -> FirstChange:
    """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, from samples.

    Parameters
    ----------
    blocks : iterable of (ndarray, ndarray)
        Values in the order of the way, the first of each block the last of the block before, and whether each is
        stable.  No block is asked for beyond the first change.
    begins : bool
        The verdict before the first sample: whether it is stable.
    locate : callable
        Locates the change between two samples.
    piece : (float, float)
    resolution : float
        Distance of samples.
    refused : exception, optional
        Ends the search where a sample has no verdict.
    """
    reached = piece[0]
    try:
        for values, stable in blocks:
            different = np.flatnonzero(stable != begins)
            if different.size:
                i = int(different[0])
                if i == 0:
                    return FirstChange(float(values[0]), float(values[0]), resolution)
                at = float(changes(values[i - 1 : i + 1], stable[i - 1 : i + 1], locate)[0])
                return FirstChange(at, at, resolution)
            reached = float(values[-1])
    except refused:
        return FirstChange(None, reached, resolution)
    return FirstChange(None, piece[1], resolution)


def changes(values: Floats, stable: Bools, locate: Locate) -> Floats:
    """Return the last stable value before each change between neighbouring samples."""
    i = np.flatnonzero(stable[1:] != stable[:-1])
    near, far = values[i], values[i + 1]
    return locate(np.where(stable[i], near, far), np.where(stable[i], far, near))


def outward(
    way: list[float],
    search: Callable[[tuple[float, float], float, Progress | None], FirstChange],
    progress: Iterable[Progress | None],
    seconds: float = math.inf,
) -> FirstChange:
    """Return where the verdict first changes on a way of several pieces, or where the time for the search ends.

    Parameters
    ----------
    way : list of float
        The ends of the pieces, the nearest first.
    search : callable (piece, seconds, progress) -> FirstChange
        Searches one piece.
    progress : iterable of callable
        Called with the progress in each piece.
    seconds : float
        Half of the time that is left goes to a piece, all of it to the last one: nearer changes come first.
    """
    change, left = FirstChange(None, way[0], 0.0), seconds
    for piece, report in zip(pairwise(way), progress, strict=True):
        if piece[0] != piece[1]:
            share = left if piece[1] == way[-1] else 0.5 * left
            in_piece = search(piece, share, report)
            change = in_piece._replace(resolution=max(change.resolution, in_piece.resolution))
            left -= in_piece.seconds
            if change.at is not None or change.searched != piece[1]:
                break
        if report is not None:
            report(1, 1)
    return change


def bracket(holds: Callable[[float], bool], start: float, limit: float, digits: float) -> tuple[float, float]:
    """Return two values, the second no more than ``digits`` of it larger, between which a statement becomes true.

    The statement is wrong at zero.  ``start`` and four times as much again and again are tried, then the bracket is
    halved; its upper end is infinite where the statement is wrong up to ``limit``.
    """
    low, high = 0.0, start
    while not holds(high):
        low, high = high, 4.0 * high
        if high > limit:
            return low, math.inf
    for _ in range(_MOST_HALVINGS):
        if high - low <= digits * high:
            break
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return low, high


def root_below(excess: Callable[[float], float], high: float, farthest: float) -> float:
    """Return the factor below ``high`` at which a growing excess becomes zero, to 14 digits.

    ``high`` where the excess is not above zero there, NaN where it stays above zero, or unknown, down to ``high /
    farthest``.
    """
    from scipy.optimize import brentq

    low = 0.5 * high
    while not excess(low) < 0.0:
        low *= 0.5
        if low < high / farthest:
            return math.nan
    return float(brentq(excess, low, high, xtol=1e-14 * high, rtol=1e-14)) if excess(high) > 0.0 else high


def separation(is_apart: Callable[[float], bool], nearest: float) -> float:
    """Return how far apart, relative to a critical value, verdicts on both sides of it are decided.

    Four times ``nearest`` again and again; 0.5 or more where they are decided at no distance below that.
    """
    apart = nearest
    while apart < 0.5 and not is_apart(apart):
        apart *= 4.0
    return apart
